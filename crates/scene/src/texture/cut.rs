//! A convex polygon cut along the edges of texels.
//!
//! Corners carry their position in texels; both coordinates are affine, and so are those of the corners that a cut makes. Strips
//! between two rows are cut into their columns, neighbours of one value left together. Pieces cover the polygon, up to the
//! rounding of their corners.

use super::{Texture, floor};
use crate::extremes::{largest, smallest};

/// A convex part of a polygon on which a texture is constant.
#[derive(Debug, Clone, PartialEq)]
pub struct Piece<'a> {
    /// Its corners, in the coordinates and the turn of the polygon that was cut.
    pub corners: Vec<[f64; 2]>,
    /// The texture's values on it.
    pub values: &'a [f64],
}

/// A corner, and its position in texels.
#[derive(Debug, Clone, Copy)]
struct Corner {
    at: [f64; 2],
    texel: [f64; 2],
}

impl Texture {
    /// Cuts a convex polygon into pieces on which the texture is constant and hands each to `take`. `chart` gives `(u, v)` at a
    /// point of the polygon, and has to be affine.
    pub fn cut<'a>(&'a self, corners: &[[f64; 2]], chart: impl Fn([f64; 2]) -> [f64; 2], mut take: impl FnMut(Piece<'a>)) {
        let size = self.size().map(|n| n as f64);
        let corner = |&at: &[f64; 2]| {
            let uv = chart(at);
            Corner { at, texel: [uv[0] * size[0], uv[1] * size[1]] }
        };
        let polygon: Vec<Corner> = corners.iter().map(corner).collect();
        let rows = extent(&polygon, 1);
        for row in rows[0]..=rows[1] {
            let strip = between(&polygon, 1, [row, row.saturating_add(1)], rows);
            if strip.len() < 3 {
                continue;
            }
            let columns = extent(&strip, 0);
            let mut first = columns[0];
            loop {
                let values = self.texel([first, row]);
                let mut last = first;
                while last < columns[1] && self.texel([last + 1, row]) == values {
                    last += 1;
                }
                let piece = between(&strip, 0, [first, last.saturating_add(1)], columns);
                if piece.len() >= 3 {
                    take(Piece { corners: piece.iter().map(|corner| corner.at).collect(), values });
                }
                // The last column may be the last integer.
                if last >= columns[1] {
                    break;
                }
                first = last + 1;
            }
        }
    }
}

/// The first and last texel along an axis. A polygon that ends on the edge of a texel has no part of the next.
fn extent(polygon: &[Corner], axis: usize) -> [i64; 2] {
    let texels = polygon.iter().map(|corner| corner.texel[axis]);
    let (low, high) = texels.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), c| (smallest(low, c), largest(high, c)));
    let (first, last) = (floor(low), floor(high));
    [first, if last > first && last as f64 == high { last - 1 } else { last.max(first) }]
}

/// The part from one edge of texels to another, where `all` says between which ones there is anything.
fn between(polygon: &[Corner], axis: usize, [from, to]: [i64; 2], all: [i64; 2]) -> Vec<Corner> {
    let mut part = polygon.to_vec();
    if from > all[0] {
        part = beyond(&part, axis, from as f64, 1.0);
    }
    if to <= all[1] {
        part = beyond(&part, axis, to as f64, -1.0);
    }
    part
}

/// The part of a convex polygon on one side of a line (I. Sutherland and G. Hodgman 1974).
fn beyond(polygon: &[Corner], axis: usize, line: f64, side: f64) -> Vec<Corner> {
    let mut part = Vec::with_capacity(polygon.len() + 1);
    for (index, &b) in polygon.iter().enumerate() {
        let a = polygon[(index + polygon.len() - 1) % polygon.len()];
        let [over_a, over_b] = [a, b].map(|corner| side * (corner.texel[axis] - line));
        if (over_a > 0.0 && over_b < 0.0) || (over_a < 0.0 && over_b > 0.0) {
            let along = over_a / (over_a - over_b);
            let mix = |a: f64, b: f64| a + along * (b - a);
            let mut texel = [0, 1].map(|k| mix(a.texel[k], b.texel[k]));
            texel[axis] = line;
            part.push(Corner { at: [0, 1].map(|k| mix(a.at[k], b.at[k])), texel });
        }
        if over_b >= 0.0 {
            part.push(b);
        }
    }
    part
}

#[cfg(test)]
mod tests {
    use super::*;

    fn area(corners: &[[f64; 2]]) -> f64 {
        let twice = |i: usize| {
            let (a, b) = (corners[i], corners[(i + 1) % corners.len()]);
            a[0] * b[1] - a[1] * b[0]
        };
        0.5 * (0..corners.len()).map(twice).sum::<f64>()
    }

    #[test]
    fn pieces_cover_the_polygon_with_the_values_that_are_there() {
        let texture = Texture::from_fn("t", [5, 3], 1, |column, row| vec![(column * 7 + row * 3) as f64]).unwrap();
        let polygon = [[0.1, 0.0], [1.3, 0.2], [1.0, 1.1], [0.0, 0.9]];
        let charts: [fn([f64; 2]) -> [f64; 2]; 4] =
            [|p| p, |[s, t]| [0.3 - 2.0 * s + 0.7 * t, 1.5 * t - 0.4 * s], |[s, _]| [3.0 * s, 0.4], |_| [0.5, -0.3]];
        for (which, chart) in charts.into_iter().enumerate() {
            let (mut covered, mut pieces) = (0.0, 0);
            texture.cut(&polygon, chart, |piece| {
                let (count, mut middle) = (piece.corners.len() as f64, [0.0; 2]);
                for corner in &piece.corners {
                    middle = [middle[0] + corner[0] / count, middle[1] + corner[1] / count];
                }
                let size = area(&piece.corners);
                assert!(size > -1e-15);
                assert!(size < 1e-12 || texture.value_at(chart(middle)) == piece.values, "{which} {middle:?}");
                covered += size;
                pieces += 1;
            });
            assert!((covered - area(&polygon)).abs() < 1e-14, "{which}: {covered}");
            assert!(pieces >= if which < 3 { 3 } else { 1 }, "{which}: {pieces}");
        }
    }

    #[test]
    fn texels_beyond_all_integers_end() {
        let texture = Texture::new("t", [2, 2], 1, vec![0.25, 0.5, 0.75, 1.0]).unwrap();
        for far in [1e300, -1e300, 9.3e18, f64::INFINITY, f64::NAN] {
            let mut pieces = 0;
            texture.cut(&[[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]], |_| [far, far], |_| pieces += 1);
            assert!(pieces <= 1, "{far}");
        }
    }

    #[test]
    fn neighbours_of_one_value_stay_together() {
        let texture = Texture::new("t", [100, 1], 1, vec![0.5; 100]).unwrap();
        let mut pieces = 0;
        texture.cut(
            &[[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]],
            |p| p,
            |piece| {
                assert_eq!((piece.corners.len(), piece.values), (4, &[0.5][..]));
                pieces += 1;
            },
        );
        assert_eq!(pieces, 1);
    }
}
