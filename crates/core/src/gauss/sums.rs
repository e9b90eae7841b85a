//! The rule's sums over its nodes, and their rounding errors.
//!
//! # Bound
//! u = 2^-53, in normalised lengths. `delta = u (4 rho + 18 L) + 2 sigma` bounds the error of a node's position, with rho the
//! farthest point, L the longest side and sigma the error of a side: that of the apex, two roundings of the largest and the
//! products of the sides with node and weight. The height over the horizon is a mean of those at the corners, with ten roundings
//! of the largest: `phi = (error at the corners) + 10u H`. With d the nearest point, `1/r^2` errs by `i = 2 delta/d + 5u`, and
//! relative to the sum P of `1/r^4`, whose terms are all positive, times the largest B:
//! - `B/r^4` by `p = 2i + 8u + (number of nodes in a row and of rows) u` and what B errs by;
//! - `B n1.r/r^4` by `H (p + u) + phi`;
//! - `B n1.r r/r^6` by `min(1, H/d) (p + i + delta/d + 3u) + phi/d`.
//!
//! Area, height, normals and the last few operations add 16u. Corners that are misplaced in the plane by up to 22u of the
//! spread change the domain by that along the perimeter, where the integrand is at most what the nearest point allows.

use super::source::OnTriangle;
use super::triangle::{Bound, Grid, Triangle};
use super::{Integral, Scene, rules};
use crate::number::ROUNDOFF;
use crate::vec3::Vec3;

/// Sums over nodes of `1/r^4` times 1, `B`, `B n1.r` and `B n1.r r/r^2`.
#[derive(Debug, Clone, Copy, Default)]
struct Sums {
    positive: f64,
    plain: f64,
    projected: f64,
    pulled: Vec3<f64>,
}

impl Sums {
    #[inline]
    fn add(&mut self, weight: f64, other: &Self) {
        self.positive += weight * other.positive;
        self.plain += weight * other.plain;
        self.projected += weight * other.projected;
        self.pulled = self.pulled + other.pulled * weight;
    }
}

/// A row of nodes: the points `start + step b`, `n1.r` at them, and the grid of b.
struct Row {
    start: Vec3<f64>,
    step: Vec3<f64>,
    facing: [f64; 2],
    grid: Grid,
}

impl Row {
    #[inline]
    fn sums(&self, emission: impl Fn(f64) -> f64) -> Sums {
        let Self { start, step, facing, grid } = *self;
        let (width, rule) = (1.0 / grid.panels as f64, rules::rule(grid.count));
        let mut total = Sums::default();
        for panel in 0..grid.panels {
            for node in rule {
                let b = (panel as f64 + node.at) * width;
                let r = start + step * b;
                let inverse = 1.0 / r.norm_squared();
                let positive = node.weight * inverse * inverse;
                let plain = positive * emission(b);
                let projected = plain * (facing[0] + facing[1] * b);
                total.add(1.0, &Sums { positive, plain, projected, pulled: r * (projected * inverse) });
            }
        }
        total
    }
}

impl Scene<'_> {
    /// The integral over a triangle, without the factor rho/pi.
    pub(super) fn integral(&self, triangle: &Triangle) -> Integral {
        let Self { n1, n2, height, .. } = *self;
        let total = match &triangle.emission {
            OnTriangle::Affine([value, first, side]) => triangle.sums(|a| {
                let (start, step) = (value + first * a, side * a);
                move |b| start + step * b
            }),
            OnTriangle::Polynomial(polynomial, [p, first, side]) => triangle.sums(|a| {
                let start = [p[0] + first[0] * a, p[1] + first[1] * a];
                let step = [side[0] * a, side[1] * a];
                move |b| polynomial.value([start[0] + step[0] * b, start[1] + step[1] * b])
            }),
        };
        let gradient = n2 * total.projected - n1 * (height * total.plain) + total.pulled * (4.0 * height);
        let error = triangle.error(self, &total);
        Integral {
            value: triangle.twice_area * height * total.projected,
            gradient: gradient * triangle.twice_area,
            value_error: triangle.truncation.value + error.value,
            gradient_error: triangle.truncation.gradient + error.gradient,
        }
    }
}

impl Triangle {
    /// The sums, with the emission as a function of a, then of b.
    #[inline]
    fn sums<F: Fn(f64) -> f64>(&self, emission: impl Fn(f64) -> F) -> Sums {
        let Self { apex, first, side, facing, grid: [rows, row], .. } = *self;
        let width = [1.0 / rows.panels as f64, 1.0 / row.panels as f64];
        let mut total = Sums::default();
        for panel in 0..rows.panels {
            for node in rules::rule(rows.count) {
                let a = (panel as f64 + node.at) * width[0];
                let (start, step) = (apex + first * a, side * a);
                let row = Row { start, step, facing: [facing[0] + facing[1] * a, facing[2] * a], grid: row };
                total.add(node.weight * width[0] * width[1] * a, &row.sums(emission(a)));
            }
        }
        total
    }

    /// Bound on the rounding errors.
    fn error(&self, scene: &Scene<'_>, sums: &Sums) -> Bound {
        const U: f64 = ROUNDOFF;
        let Scene { height, ref source, input_error, .. } = *scene;
        let Self { nearest, farthest, longest, most_facing, .. } = *self;
        let moved = (U * (4.0 * farthest + 18.0 * longest) + 2.0 * self.side_error) / nearest;
        let inverse = 2.0 * moved + 5.0 * U;
        let plain = 2.0 * inverse + (8 + self.grid[0].nodes() + self.grid[1].nodes()) as f64 * U + source.rounding;
        let facing = self.facing_error + 10.0 * U * most_facing;
        let projected = most_facing * (plain + U) + facing;
        let steep = (most_facing / nearest).min(1.0);
        let pulled = steep * (plain + inverse + moved + 3.0 * U) + facing / nearest;
        let area = self.twice_area.abs();
        let last = area * (16.0 * U + input_error) + self.twice_area_error;
        // Relative to the largest emission over the fourth power of the nearest distance.
        let near = nearest * nearest;
        let misplaced = self.misplaced_area / (near * near);
        let size = source.largest * (1.0 + 1e-9);
        let value = sums.positive * (area * projected + last * most_facing) + misplaced * most_facing;
        let gradient = sums.positive * (area * (projected + height * (plain + 4.0 * pulled)))
            + (sums.positive * last + misplaced) * (most_facing + height * (1.0 + 4.0 * steep));
        Bound { value: size * height * value, gradient: size * gradient }
    }
}
