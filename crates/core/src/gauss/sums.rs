//! The rule's sums over its nodes, and their rounding errors.
//!
//! # Bound
//! In normalised lengths, with u = 2^-53, rho the farthest and d the nearest point, L the longest side, sigma the error of a side
//! and H the height over the horizon:
//!
//! - The position of a node errs by `delta + u r`, `delta = u (2 rho + 6 L) + 2 sigma`: by the apex and the start of its row, u rho
//!   each (u rho more beside a crossing of the horizon), by the products of the sides with the nodes (3u L more where those are of
//!   several panels), and by its own rounding.
//! - So `1/r^4` errs by `4 delta/r + 14u` of itself, and by 8u more with its weight. Sums over r follow from those over 1 and
//!   `r^2` by Cauchy's inequality.
//! - What is interpolated between corners errs by the error there, by the rounding of the two nodes, 4u of the largest, and by 6u
//!   of itself as long as no corner is negative.
//! - `r/r^2` is an inversion, which changes lengths by `1/r^2`: it errs by that times delta, and by 9u of itself.
//! - A sum of m additions to a lane and three over lanes errs by `(m + 3) u` of the sum of sizes.
//!
//! What `1/r^4` errs by scales a node's `n2 H - n1 h + 4 h H r/r^2` as a whole, and that is `n2 H - n1 h` reflected at r, at most
//! `H + h` long: the third term does not count for it. Where the emission is somewhere negative the sums of sizes are bounded by
//! its largest value.
//!
//! Height, normals and the last few operations add 8u. Corners that are misplaced in the plane by up to 22u of the
//! spread change the domain by that along the perimeter, where the integrand is at most what the nearest point allows.

use fearless_simd::prelude::*;
use fearless_simd::{dispatch, f64x8};

use super::source::OnTriangle;
use super::triangle::{Bound, Grid, Triangle};
use super::{Integral, Scene, rules};
use crate::level::LEVEL;
use crate::number::ROUNDOFF;
use crate::vec3::Vec3;

/// Sums over nodes of `1/r^4` times 1, `B`, `B n1.r`, `B n1.r r/r^2`, and of the second and third over `r^2`.
#[derive(Debug, Clone, Copy)]
struct Sums<T> {
    positive: T,
    plain: T,
    projected: T,
    pulled: Vec3<T>,
    plain_over_square: T,
    projected_over_square: T,
}

impl<T: Copy> Sums<T> {
    #[inline(always)]
    fn map<U>(self, f: impl Fn(T) -> U) -> Sums<U> {
        Sums {
            positive: f(self.positive),
            plain: f(self.plain),
            projected: f(self.projected),
            pulled: self.pulled.map(&f),
            plain_over_square: f(self.plain_over_square),
            projected_over_square: f(self.projected_over_square),
        }
    }
}

/// The sum over the lanes.
fn total([a, b, c, d, e, f, g, h]: [f64; rules::LANES]) -> f64 {
    ((a + b) + (c + d)) + ((e + f) + (g + h))
}

/// A row of nodes, from where a is 0 to where b is 1: points, and what is interpolated between the two ends.
struct Row<S: Simd> {
    start: Vec3<f64x8<S>>,
    step: Vec3<f64x8<S>>,
    facing: [f64x8<S>; 2],
    weight: f64x8<S>,
}

/// `(1 - b) p + b q`, which errs by 4u where neither is negative.
#[inline(always)]
fn between<S: Simd>([p, q]: [f64x8<S>; 2], b: f64x8<S>, rest: f64x8<S>) -> f64x8<S> {
    p * rest + q * b
}

impl<S: Simd> Sums<f64x8<S>> {
    #[inline(always)]
    fn zero(simd: S) -> Self {
        let zero = f64x8::splat(simd, 0.0);
        Self {
            positive: zero,
            plain: zero,
            projected: zero,
            pulled: Vec3::new(zero, zero, zero),
            plain_over_square: zero,
            projected_over_square: zero,
        }
    }

    /// The sums of a row, eight nodes at a time whatever the machine, so that digits do not depend on it. The emission is a
    /// function of b and 1 - b.
    #[inline(always)]
    fn of(simd: S, row: &Row<S>, grid: Grid, emission: &impl Fn(f64x8<S>, f64x8<S>) -> f64x8<S>) -> Self {
        let mut sums = Self::zero(simd);
        let (rule, width, one) = (rules::rule(grid.count), f64x8::splat(simd, 1.0 / grid.panels as f64), f64x8::splat(simd, 1.0));
        for panel in 0..grid.panels {
            let shift = f64x8::splat(simd, panel as f64);
            for (nodes, weights) in rule.nodes.chunks_exact(rules::LANES).zip(rule.weights.chunks_exact(rules::LANES)) {
                let b = (f64x8::from_slice(simd, nodes) + shift) * width;
                let rest = one - b;
                let r = row.start + row.step * b;
                let inverse = one / (r.x * r.x + r.y * r.y + r.z * r.z);
                let positive = f64x8::from_slice(simd, weights) * row.weight * inverse * inverse;
                let plain = positive * emission(b, rest);
                let projected = plain * between(row.facing, b, rest);
                let pull = projected * inverse;
                sums.add(&Self {
                    positive,
                    plain,
                    projected,
                    pulled: r * pull,
                    plain_over_square: plain * inverse,
                    projected_over_square: pull,
                });
            }
        }
        sums
    }

    #[inline(always)]
    fn add(&mut self, other: &Self) {
        self.positive += other.positive;
        self.plain += other.plain;
        self.projected += other.projected;
        self.pulled = self.pulled + other.pulled;
        self.plain_over_square += other.plain_over_square;
        self.projected_over_square += other.projected_over_square;
    }
}

impl Scene<'_> {
    /// The integral over a triangle, without the factor rho/pi.
    pub(super) fn integral(&self, triangle: &Triangle) -> Integral {
        let Self { n1, n2, height, .. } = *self;
        let total = dispatch!(*LEVEL, simd => triangle.sums(simd)).map(total);
        let gradient = n2 * total.projected - n1 * (height * total.plain) + total.pulled * (4.0 * height);
        let error = triangle.error(self, &total);
        // What the area errs by scales all.
        let (value, gradient) = (height * total.projected, gradient);
        let size = gradient.norm_squared().sqrt();
        Integral {
            value: triangle.twice_area * value,
            gradient: gradient * triangle.twice_area,
            value_error: triangle.truncation.value + error.value + triangle.twice_area_error * value.abs(),
            gradient_error: triangle.truncation.gradient + error.gradient + triangle.twice_area_error * size,
        }
    }
}

/// What is affine and has these values at the corners, at both ends of a row; it errs by 4u where none is negative.
#[inline(always)]
fn ends([apex, first, last]: [f64; 3], a: f64) -> [f64; 2] {
    let from_apex = (1.0 - a) * apex;
    [from_apex + a * first, from_apex + a * last]
}

impl Triangle {
    #[inline(always)]
    fn sums<S: Simd>(&self, simd: S) -> Sums<[f64; rules::LANES]> {
        match &self.emission {
            OnTriangle::Affine(corners) => self.with_emission(simd, |a| {
                let ends = ends(*corners, a).map(|value| f64x8::splat(simd, value));
                move |b, rest| between(ends, b, rest)
            }),
            OnTriangle::Polynomial(polynomial, [p, first, side]) => self.with_emission(simd, |a| {
                let start = [p[0] + first[0] * a, p[1] + first[1] * a];
                let step = [side[0] * a, side[1] * a];
                move |b: f64x8<S>, _| {
                    let value = |b: f64| polynomial.value([start[0] + step[0] * b, start[1] + step[1] * b]);
                    f64x8::from_slice(simd, &b.as_array().map(value))
                }
            }),
        }
    }

    /// The sums, with the emission as a function of a, then of b and 1 - b.
    #[inline(always)]
    fn with_emission<S: Simd, F: Fn(f64x8<S>, f64x8<S>) -> f64x8<S>>(
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
                    facing: ends(facing, a).map(splat),
                    weight: splat(weight * width[0] * width[1] * a),
                };
                total.add(&Sums::of(simd, &along, row, &emission(a)));
            }
        }
        total.map(|sum| *sum.as_array())
    }

    /// To each lane.
    fn additions(&self) -> usize {
        let [rows, row] = self.grid;
        rows.nodes() + row.panels * row.count.div_ceil(rules::LANES)
    }

    /// Bound on the rounding errors.
    fn error(&self, scene: &Scene<'_>, sums: &Sums<f64>) -> Bound {
        const U: f64 = ROUNDOFF;
        let Scene { height, ref source, input_error, is_clipped, .. } = *scene;
        let Self { nearest, farthest, longest, most_facing, .. } = *self;
        let apex = if is_clipped { 3.0 } else { 2.0 };
        let nodes = if self.grid.iter().all(|grid| grid.panels == 1) { 6.0 } else { 9.0 };
        let displaced = U * (apex * farthest + nodes * longest) + 2.0 * self.side_error;
        let sum = (3 + self.additions()) as f64 * U;
        let steep = (most_facing / nearest).min(1.0);
        // Sums of sizes, these over r and over r^2, and what the emission errs by.
        let bright = sums.positive * source.largest * (1.0 + 1e-9);
        let (plain, projected, emission) = if self.is_bright {
            let over_distance = |sum: f64, over_square: f64| (sum * over_square).sqrt() * (1.0 + 1e-9);
            let plain = [sums.plain, over_distance(sums.plain, sums.plain_over_square)];
            let projected = [sums.projected, over_distance(sums.projected, sums.projected_over_square)];
            (plain, projected, source.crossing)
        } else {
            let over_distance = |sum: f64| [sum, sum / nearest];
            (over_distance(bright), over_distance(bright * most_facing), source.rounding)
        };
        let emission = bright * emission;
        let pulled = plain[0].min(projected[1]);
        let inverted = if self.is_bright { sums.projected_over_square } else { pulled / nearest };
        // The first is what all three sums of a node have in common.
        let errors = |[size, over_distance]: [f64; 2]| 4.0 * displaced * over_distance + size * (32.0 * U + sum);
        let facing = self.facing_error + 4.0 * U * most_facing;
        let plain_error = errors(plain) + emission;
        let projected_error = errors(projected) + emission * most_facing + plain[0] * facing;
        let pulled_error = displaced * inverted + pulled * (17.0 * U + sum) + emission * steep + plain[1] * facing;
        let area = self.twice_area.abs();
        let last = 8.0 * U + input_error;
        // Over the fourth power of the nearest distance.
        let near = nearest * nearest;
        let misplaced = self.misplaced_area / (near * near) * source.largest;
        Bound {
            value: height * (area * (projected_error + last * projected[0]) + misplaced * most_facing),
            gradient: area * (projected_error + height * (plain_error + 4.0 * pulled_error))
                + area * last * (projected[0] + height * (plain[0] + 4.0 * pulled))
                + misplaced * (most_facing + height * (1.0 + 4.0 * steep)),
        }
    }
}
