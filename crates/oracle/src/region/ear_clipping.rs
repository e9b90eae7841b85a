//! A simple polygon as triangles, by cutting off ears (Meisters 1975): one triangle less than vertices less one, no new vertex.
//!
//! Orientation signs come from doubled precision, so a needle or three vertices on a line are told apart where doubles would not;
//! a vertex on the line of its neighbours has no area and is dropped.

use crate::Error;
use crate::region::{PreciseVertex, twice_area};

/// Triangles that cover the polygon, counter-clockwise.
pub(crate) fn triangulate(polygon: &[PreciseVertex]) -> Result<Vec<[PreciseVertex; 3]>, Error> {
    let mut remaining = polygon.to_vec();
    let mut triangles = Vec::with_capacity(polygon.len().saturating_sub(2));
    while remaining.len() > 3 {
        let count = remaining.len();
        let around = |i: usize| [remaining[(i + count - 1) % count], remaining[i], remaining[(i + 1) % count]];
        let flat = (0..count).find(|&i| is_flat(&around(i)));
        let Some(tip) = flat.or_else(|| (0..count).find(|&i| is_ear(&around(i), &remaining))) else {
            return Err(Error::Triangulation { remaining: count });
        };
        if flat.is_none() {
            triangles.push(around(tip));
        }
        remaining.remove(tip);
    }
    if let [a, b, c] = remaining[..]
        && twice_area(&a, &b, &c).is_positive()
    {
        triangles.push([a, b, c]);
    }
    Ok(triangles)
}

fn is_flat([a, b, c]: &[PreciseVertex; 3]) -> bool {
    let area = twice_area(a, b, c);
    !area.is_positive() && !area.is_negative()
}

/// Whether the corner is convex and no other vertex lies in its triangle.
fn is_ear(corner: &[PreciseVertex; 3], remaining: &[PreciseVertex]) -> bool {
    let [a, b, c] = corner;
    twice_area(a, b, c).is_positive()
        && !remaining.iter().any(|v| {
            !corner.contains(v) && [(a, b), (b, c), (c, a)].iter().all(|(from, to)| !twice_area(from, to, v).is_negative())
        })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::region::compensated::Pair;

    fn outline(corners: &[[f64; 2]]) -> Vec<PreciseVertex> {
        corners.iter().map(|[p, q]| PreciseVertex::in_plane(Pair::from(*p), Pair::from(*q))).collect()
    }

    fn area(triangles: &[[PreciseVertex; 3]]) -> f64 {
        triangles.iter().map(|[a, b, c]| 0.5 * twice_area(a, b, c).rounded()).sum()
    }

    #[test]
    fn a_comb_is_covered() {
        let comb = [[0.0, 0.0], [5.0, 0.0], [5.0, 3.0], [4.0, 1.0], [3.0, 3.0], [2.0, 1.0], [1.0, 3.0], [0.5, 1.0]];
        let triangles = triangulate(&outline(&comb)).unwrap();
        assert_eq!((triangles.len(), area(&triangles)), (6, 9.25));
    }

    #[test]
    fn vertices_on_an_edge_add_no_triangle() {
        let square = [[0.0, 0.0], [0.5, 0.0], [1.0, 0.0], [1.0, 1.0], [0.25, 1.0], [0.0, 1.0]];
        let triangles = triangulate(&outline(&square)).unwrap();
        assert_eq!((triangles.len(), area(&triangles)), (2, 1.0));
    }

    #[test]
    fn clockwise_order_is_refused() {
        let clockwise = [[0.0, 0.0], [0.0, 1.0], [1.0, 1.0], [1.0, 0.0]];
        assert_eq!(triangulate(&outline(&clockwise)), Err(Error::Triangulation { remaining: 4 }));
    }
}
