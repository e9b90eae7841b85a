//! The rule's sums over its nodes, and their rounding errors.
//!
//! # Bound
//! u = 2^-53, in normalised lengths. With rho the farthest and d the nearest point, L the longest side and sigma the error of a
//! side, the position of a node errs by the apex and the start of its row, u rho each (u rho more beside a crossing of the
//! horizon), by the products of the sides with node and weight, and by its own rounding: relative to its distance by `delta = (u
//! (2 rho + 9 L) + 2 sigma)/d + u`. The height over the horizon is a mean of those at the corners, with ten roundings of the
//! largest, H: `phi = (error at the corners) + 10u H`. `1/r^2` errs by `i = 2 delta + 5u`, its square, weights and sums, all of one
//! sign, by `p = 2i + (11 + additions to a lane) u`, relative. So, with `|B|` known to within b,
//! - `sum B/r^4` errs by `p + u` of `sum |B|/r^4` and by b of `sum 1/r^4`;
//! - `sum B n1.r/r^4` by `p + 2u` of the sum of sizes, by b H of `sum 1/r^4`, and by phi of `sum |B|/r^4`;
//! - `sum B n1.r r/r^6` by `p + i + delta + 4u` of the sum of sizes, by b min(1, H/d), and by phi/d.
//!
//! Where the emission is nowhere negative the sums are those of sizes.
//!
//! Area, height, normals and the last few operations add 16u. Corners that are misplaced in the plane by up to 22u of the
//! spread change the domain by that along the perimeter, where the integrand is at most what the nearest point allows.

use std::sync::LazyLock;

use fearless_simd::prelude::*;
use fearless_simd::{Level, dispatch, f64x8};

use super::source::OnTriangle;
use super::triangle::{Bound, Grid, Triangle};
use super::{Integral, Scene, rules};
use crate::number::ROUNDOFF;
use crate::vec3::Vec3;

/// Sums over nodes of `1/r^4` times 1, `B`, `B n1.r` and `B n1.r r/r^2`.
#[derive(Debug, Clone, Copy)]
struct Sums<T> {
    positive: T,
    plain: T,
    projected: T,
    pulled: Vec3<T>,
}

impl<S: Simd> Sums<f64x8<S>> {
    #[inline(always)]
    fn zero(simd: S) -> Self {
        let zero = f64x8::splat(simd, 0.0);
        Self { positive: zero, plain: zero, projected: zero, pulled: Vec3::new(zero, zero, zero) }
    }

    #[inline(always)]
    fn into_arrays(self) -> Sums<[f64; rules::LANES]> {
        Sums {
            positive: *self.positive.as_array(),
            plain: *self.plain.as_array(),
            projected: *self.projected.as_array(),
            pulled: self.pulled.map(|v| *v.as_array()),
        }
    }
}

impl Sums<[f64; rules::LANES]> {
    /// The sums over the lanes.
    fn total(&self) -> Sums<f64> {
        let sum = |[a, b, c, d, e, f, g, h]: [f64; rules::LANES]| ((a + b) + (c + d)) + ((e + f) + (g + h));
        Sums {
            positive: sum(self.positive),
            plain: sum(self.plain),
            projected: sum(self.projected),
            pulled: self.pulled.map(sum),
        }
    }
}

/// A row of nodes: the points `start + step b`, `n1.r` at them, and the weight of the row.
struct Row<S: Simd> {
    start: Vec3<f64x8<S>>,
    step: Vec3<f64x8<S>>,
    facing: [f64x8<S>; 2],
    weight: f64x8<S>,
}

impl<S: Simd> Sums<f64x8<S>> {
    /// Adds a row, eight nodes at a time whatever the machine, so that digits do not depend on it.
    #[inline(always)]
    fn add(&mut self, simd: S, row: &Row<S>, grid: Grid, emission: &impl Fn(f64x8<S>) -> f64x8<S>) {
        let (rule, width, one) = (rules::rule(grid.count), f64x8::splat(simd, 1.0 / grid.panels as f64), f64x8::splat(simd, 1.0));
        for panel in 0..grid.panels {
            let shift = f64x8::splat(simd, panel as f64);
            for (nodes, weights) in rule.nodes.chunks_exact(rules::LANES).zip(rule.weights.chunks_exact(rules::LANES)) {
                let b = (f64x8::from_slice(simd, nodes) + shift) * width;
                let r = row.start + row.step * b;
                let inverse = one / (r.x * r.x + r.y * r.y + r.z * r.z);
                let positive = f64x8::from_slice(simd, weights) * row.weight * inverse * inverse;
                let plain = positive * emission(b);
                let projected = plain * (row.facing[0] + row.facing[1] * b);
                let pull = projected * inverse;
                self.positive += positive;
                self.plain += plain;
                self.projected += projected;
                self.pulled = self.pulled + r * pull;
            }
        }
    }
}

/// The vector unit of this machine.
static LEVEL: LazyLock<Level> = LazyLock::new(Level::new);

impl Scene<'_> {
    /// The integral over a triangle, without the factor rho/pi.
    pub(super) fn integral(&self, triangle: &Triangle) -> Integral {
        let Self { n1, n2, height, .. } = *self;
        let total = dispatch!(*LEVEL, simd => triangle.sums(simd)).total();
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
    #[inline(always)]
    fn sums<S: Simd>(&self, simd: S) -> Sums<[f64; rules::LANES]> {
        match &self.emission {
            OnTriangle::Affine([value, first, side]) => self.with_emission(simd, |a| {
                let (start, step) = (f64x8::splat(simd, value + first * a), f64x8::splat(simd, side * a));
                move |b| start + step * b
            }),
            OnTriangle::Polynomial(polynomial, [p, first, side]) => self.with_emission(simd, |a| {
                let start = [p[0] + first[0] * a, p[1] + first[1] * a];
                let step = [side[0] * a, side[1] * a];
                move |b: f64x8<S>| {
                    let value = |b: f64| polynomial.value([start[0] + step[0] * b, start[1] + step[1] * b]);
                    f64x8::from_slice(simd, &b.as_array().map(value))
                }
            }),
        }
    }

    /// The sums, with the emission as a function of a, then of b.
    #[inline(always)]
    fn with_emission<S: Simd, F: Fn(f64x8<S>) -> f64x8<S>>(
        &self,
        simd: S,
        emission: impl Fn(f64) -> F,
    ) -> Sums<[f64; rules::LANES]> {
        let Self { apex, first, side, facing, grid: [rows, row], .. } = *self;
        let splat = |value: f64| f64x8::splat(simd, value);
        let width = [1.0 / rows.panels as f64, 1.0 / row.panels as f64];
        let rule = rules::rule(rows.count);
        let mut total = Sums::zero(simd);
        for panel in 0..rows.panels {
            for (node, weight) in rule.nodes.iter().zip(rule.weights).take(rows.count) {
                let a = (panel as f64 + node) * width[0];
                let (start, step) = (apex + first * a, side * a);
                let along = Row {
                    start: start.map(splat),
                    step: step.map(splat),
                    facing: [splat(facing[0] + facing[1] * a), splat(facing[2] * a)],
                    weight: splat(weight * width[0] * width[1] * a),
                };
                total.add(simd, &along, row, &emission(a));
            }
        }
        total.into_arrays()
    }

    /// To each lane.
    fn additions(&self) -> usize {
        let [rows, row] = self.grid;
        rows.nodes() * row.panels * row.count.div_ceil(rules::LANES)
    }

    /// Bound on the rounding errors.
    fn error(&self, scene: &Scene<'_>, sums: &Sums<f64>) -> Bound {
        const U: f64 = ROUNDOFF;
        let Scene { height, ref source, input_error, is_clipped, .. } = *scene;
        let Self { nearest, farthest, longest, most_facing, .. } = *self;
        let apex = if is_clipped { 3.0 } else { 2.0 };
        let moved = (U * (apex * farthest + 9.0 * longest) + 2.0 * self.side_error) / nearest + U;
        let inverse = 2.0 * moved + 5.0 * U;
        let each = 2.0 * inverse + (11 + self.additions()) as f64 * U;
        let facing = self.facing_error + 10.0 * U * most_facing;
        let steep = (most_facing / nearest).min(1.0);
        // Sums of sizes, and what the emission errs by.
        let bright = sums.positive * source.largest * (1.0 + 1e-9);
        let [plain, projected] = if self.is_bright { [sums.plain, sums.projected] } else { [bright, bright * most_facing] };
        let pulled = plain.min(projected / nearest);
        let emission = bright * source.rounding;
        let plain_error = plain * (each + U) + emission;
        let projected_error = projected * (each + 2.0 * U) + emission * most_facing + plain * facing;
        let pulled_error = pulled * (each + inverse + moved + 4.0 * U) + emission * steep + plain * facing / nearest;
        let area = self.twice_area.abs();
        let last = area * (16.0 * U + input_error) + self.twice_area_error;
        // Over the fourth power of the nearest distance.
        let near = nearest * nearest;
        let misplaced = self.misplaced_area / (near * near) * source.largest;
        Bound {
            value: height * (area * projected_error + last * projected + misplaced * most_facing),
            gradient: area * (projected_error + height * (plain_error + 4.0 * pulled_error))
                + last * (projected + height * (plain + 4.0 * pulled))
                + misplaced * (most_facing + height * (1.0 + 4.0 * steep)),
        }
    }
}
