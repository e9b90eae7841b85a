//! The coordinate plane that shows a flat set of points largest: two of their coordinates, unrounded.

use radgrad_core::DVec3;
use robust::Coord;

use crate::extremes::largest;

/// Which two coordinates to take, in which order, and the power of two that makes them about 1.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Projection {
    axes: [usize; 2],
    power: f64,
}

impl Projection {
    /// The projection of an outline, in which it is counter-clockwise if it has an orientation.
    pub(crate) fn onto_largest(outline: &[DVec3]) -> Self {
        let power = normalising_power(outline.iter().map(|v| v.abs().max_element()).fold(0.0, largest));
        let origin = outline.first().copied().unwrap_or_default();
        let offsets: Vec<DVec3> = outline.iter().map(|&v| (v - origin) * power).collect();
        let normal = offsets.windows(2).fold(DVec3::ZERO, |sum, pair| sum + pair[0].cross(pair[1]));
        let [x, y, z] = normal.abs().to_array();
        let (axes, up) = if z >= x && z >= y {
            ([0, 1], normal.z)
        } else if y >= x {
            ([2, 0], normal.y)
        } else {
            ([1, 2], normal.x)
        };
        Self { axes: if up < 0.0 { [axes[1], axes[0]] } else { axes }, power }
    }

    /// A point on the plane.
    pub(crate) fn point(&self, point: DVec3) -> Coord<f64> {
        let [x, y] = self.axes.map(|axis| point[axis] * self.power);
        Coord { x, y }
    }
}

/// The power of two that brings `size` to [1/2, 1), within 2^-1000 and 2^1000; 1 for 0.
pub(crate) fn normalising_power(size: f64) -> f64 {
    if size == 0.0 { 1.0 } else { libm::ldexp(1.0, -libm::frexp(size).1.clamp(-1000, 1000)) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use robust::orient2d;

    #[test]
    fn an_outline_in_any_plane_is_counter_clockwise_when_projected() {
        let triangle = [[0.0, 0.0, 0.0], [1.0, 0.1, 0.2], [0.3, 1.0, -0.4]].map(DVec3::from);
        for scale in [1.0, 1e-200, 1e200] {
            for turned in [|v: DVec3| v, |v: DVec3| DVec3::new(v.y, v.z, v.x), |v: DVec3| DVec3::new(v.z, v.x, v.y)] {
                let outline = triangle.map(|v| turned(v) * scale);
                let reversed = [outline[2], outline[1], outline[0]];
                for outline in [outline, reversed] {
                    let projection = Projection::onto_largest(&outline);
                    let [a, b, c] = outline.map(|v| projection.point(v));
                    assert!(orient2d(a, b, c) > 0.1);
                }
            }
        }
    }

    #[test]
    fn powers_bring_every_size_near_one() {
        for size in [1.0, 0.3, 7e300, f64::MAX, 1e-300] {
            let normalised = size * normalising_power(size);
            assert!((0.5..1.0).contains(&normalised) || size == f64::MAX && normalised < 2f64.powi(24), "{size:e}");
        }
        assert_eq!(normalising_power(0.0), 1.0);
    }
}
