//! The rays of a face: uniform over its area, by the cosine over the directions before it.
//!
//! The four numbers of a ray, two of its origin and two of its direction, are uniform in a cell of a grid over all four: one ray a cell. So rays are
//! independent of each other, and their hits are the sum of independent trials whose mean probability is the factor. Cells of a direction
//! come one after the other, and directions along a line that turns back at its ends: rays that follow each other go to about the same place.
//!
//! Random numbers are those of `ChaCha`, eight rounds, in a stream of the face: they depend on the seed and on the face alone.

use radgrad_core::{DVec3, Polygon};
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};

use crate::extremes::largest as larger;
use crate::factors::rule::patches;

/// How many cells there are along each of the two numbers of an origin, and of a direction.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Grid {
    origins: u32,
    directions: u32,
}

impl Grid {
    /// With at least so many cells. The face that a ray meets depends more on directions: origins have the sixth root of them.
    pub(super) fn of(rays: u32) -> Self {
        let origins = (1_u32..).take_while(|side| u64::from(*side).pow(6) <= u64::from(rays)).last().unwrap_or(1);
        let wanted = rays.div_ceil(origins * origins);
        let directions = (1_u32..).find(|side| u64::from(*side).pow(2) >= u64::from(wanted)).unwrap_or(1);
        Self { origins, directions }
    }

    /// Cells, and so rays.
    pub(super) const fn rays(self) -> u64 {
        (self.origins as u64 * self.directions as u64).pow(2)
    }
}

/// A face that rays leave.
pub(super) struct Source {
    /// Triangles of its area, with the share of all that is in those before each.
    triangles: Vec<([DVec3; 3], f64, f64)>,
    /// Two directions along it, and its normal.
    frame: [DVec3; 3],
}

impl Source {
    pub(super) fn of(polygon: &Polygon) -> Self {
        let halves = |patch: super::super::rule::Patch| {
            let [a, b, c, d] = patch.corners;
            [[a, b, c], [a, c, d]].into_iter().take(if c == d { 1 } else { 2 })
        };
        let pieces: Vec<[DVec3; 3]> = patches(polygon.vertices()).into_iter().flat_map(halves).collect();
        let area = |[a, b, c]: &[DVec3; 3]| (*b - *a).cross(*c - *a).length();
        let whole: f64 = pieces.iter().map(area).sum();
        let mut before = 0.0;
        let triangles = pieces.iter().map(|triangle| {
            let share = area(triangle) / whole;
            before += share;
            (*triangle, before - share, share)
        });
        let normal = polygon.normal();
        let along = normal.any_orthonormal_vector();
        Self { triangles: triangles.collect(), frame: [along, normal.cross(along), normal] }
    }

    /// Calls with the origin and the direction of each ray.
    pub(super) fn rays(&self, grid: Grid, (seed, face): (u64, usize), mut ray: impl FnMut(DVec3, DVec3)) {
        let mut generator = ChaCha8Rng::seed_from_u64(seed);
        generator.set_stream(face as u64);
        let Grid { origins, directions } = grid;
        let mut in_cell = |cell: u32, cells: u32| (f64::from(cell) + generator.random::<f64>()) / f64::from(cells);
        for row in 0..directions {
            for column in 0..directions {
                let column = if row % 2 == 0 { column } else { directions - 1 - column };
                for (k, l) in (0..origins).flat_map(|k| (0..origins).map(move |l| (k, l))) {
                    let toward = self.direction(in_cell(row, directions), in_cell(column, directions));
                    ray(self.origin(in_cell(k, origins), in_cell(l, origins)), toward);
                }
            }
        }
    }

    /// Of two numbers from 0 to 1, a point uniform over the area.
    fn origin(&self, u: f64, v: f64) -> DVec3 {
        let chosen = self.triangles.iter().rev().find(|(_, before, _)| *before <= u).or(self.triangles.first());
        let Some(([a, b, c], before, share)) = chosen else { return DVec3::NAN };
        let away = ((u - before) / share).clamp(0.0, 1.0).sqrt();
        *a + (*b - *a + (*c - *b) * v) * away
    }

    /// Of two numbers from 0 to 1, a direction by the cosine: above a point uniform over the unit disc, to which squares around the middle are
    /// mapped as circles (P. Shirley and K. Chiu 1997).
    fn direction(&self, u: f64, v: f64) -> DVec3 {
        let [a, b] = [2.0 * u - 1.0, 2.0 * v - 1.0];
        let quarter = std::f64::consts::FRAC_PI_4;
        let (x, y) = if a.abs() > b.abs() {
            let (sin, cos) = libm::sincos(quarter * b / a);
            (a * cos, a * sin)
        } else {
            // In the middle both are 0; any other b is too large for this to change it.
            let (sin, cos) = libm::sincos(quarter * a / (b + f64::MIN_POSITIVE));
            (b * sin, b * cos)
        };
        let [along, across, normal] = self.frame;
        along * x + across * y + normal * larger(1.0 - (x * x + y * y), 0.0).sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn origins_are_uniform_and_directions_follow_the_cosine() {
        // An L: moments of its area, and the mean of the cosine, 2/3, and of its square, 1/2.
        let corners = [[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [1.0, 1.0], [1.0, 2.0], [0.0, 2.0]];
        let outline = Polygon::new(corners.map(|[x, y]| DVec3::new(x, y, 3.0)).to_vec()).unwrap();
        let grid = Grid::of(40_000);
        let (mut count, mut middle, mut cosines, mut sideways) = (0, DVec3::ZERO, [0.0; 2], DVec3::ZERO);
        Source::of(&outline).rays(grid, (1, 7), |from, toward| {
            count += 1;
            middle += from;
            cosines[0] += toward.z;
            cosines[1] += toward.z * toward.z;
            sideways += toward;
            assert!((toward.length() - 1.0).abs() < 1e-12 && from.z == 3.0);
        });
        assert_eq!(count, grid.rays());
        assert!(count >= 40_000);
        let n = count as f64;
        assert!((middle / n - DVec3::new(5.0 / 6.0, 5.0 / 6.0, 3.0)).length() < 0.01, "{}", middle / n);
        assert!((cosines[0] / n - 2.0 / 3.0).abs() < 1e-3 && (cosines[1] / n - 0.5).abs() < 1e-3, "{cosines:?}");
        assert!(sideways.x.abs() / n < 1e-2 && sideways.y.abs() / n < 1e-2, "{sideways}");
    }

    #[test]
    fn a_grid_has_at_least_the_rays_that_are_asked_for_and_not_many_more() {
        for rays in [1, 2, 5, 100, 1024, 10_000, 123_456, 7_000_000] {
            let count = Grid::of(rays).rays();
            assert!(count >= u64::from(rays) && count as f64 <= 1.2 * f64::from(rays) + 4.0, "{rays}: {count}");
        }
    }
}
