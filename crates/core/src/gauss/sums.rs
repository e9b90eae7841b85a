//! The rule's sums over its nodes, and bounds on their rounding errors.
//!
//! # Symbols
//! Lengths are normalised.
//!
//! | symbol | meaning |
//! |---|---|
//! | u | unit roundoff, 2^-53 |
//! | r | offset of a node from the receiver |
//! | d, rho | distances of the nearest and the farthest point |
//! | P | the apex of the triangle |
//! | e1, e | a side at P and the side opposite it; sigma is the error of both |
//! | L, l | length of the longer side at P, `e1` or `e1 + e`, and of e |
//! | H | height of a node over the horizon, `n1.r` |
//! | h | height of the receiver over the emitter's plane |
//! | k | error of a node's coordinates in units of u: 1, or 2 of several panels |
//!
//! # Errors of a node
//! - Its position errs by `delta + u r`, `delta = u (|P| + rho + (1 + k) L + (2 + k) l) + sigma`: from the apex (u |P| more beside
//!   a crossing of the horizon) and the start of its row, from the products of the sides with the nodes, from the rounding of the
//!   nodes, and from its own rounding.
//! - `1/r^4` errs by `4 delta/r + 4u + 8u` relative, and with its weight by 8u more.
//! - A value interpolated between corners errs by its error there, by 2ku of the largest for the nodes, and by 6u of itself where
//!   no corner is negative.
//! - `r/r^2` is an inversion, which changes lengths by `1/r^2`: it errs by delta times that, and by 7u relative.
//! - An error of `1/r^4` or of the emission scales `n2 H - n1 h + 4 h H r/r^2` as a whole. That is `n2 H - n1 h` reflected at r, at
//!   most `H + h` long: the third term does not count for it.
//! - An error of H scales `n2 + 4 h r/r^2`, which is `(1 + 8 h^2/r^2)^(1/2) <= 1 + 2h/r` long.
//!
//! # Errors of the sums
//! - A sum errs by u of the sum of sizes for each addition that a term goes through.
//! - Sums over r follow from those over 1 and `r^2` by Cauchy's inequality.
//! - Where the emission is somewhere negative the sums of sizes are bounded by its largest value.
//! - The last operations add 2u to the value, and to the gradient 5u, 6u and 3u of its three terms.
//! - Corners misplaced in the plane, by up to 22u of the spread, change the domain by that along the perimeter; the integrand there
//!   is at most its bound at the nearest point.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f64x8};
use radgrad_numbers::in_library;
use radgrad_numbers::number::ROUNDOFF;
use radgrad_numbers::vec3::Vec3;

use crate::forms::edge_lanes::INSTRUCTION_SET;
use crate::gauss::scene::{Integral, Scene};
use crate::gauss::source::OnTriangle;
use crate::gauss::triangle::{Grid, Rule, RuleBound, SeenTriangle, Triangle};
use crate::gauss::{rules, square};
use crate::problem::fan::Shape;
use crate::problem::polynomial::bivariate::Bivariate;

/// Sums over nodes of `1/r^4` times 1, `B`, `B n1.r`, `B n1.r r/r^2`, and of the second and third over `r^2`.
#[derive(Debug, Clone, Copy)]
struct NodeSums<T> {
    positive: T,
    plain: T,
    projected: T,
    pulled: Vec3<T>,
    plain_over_square: T,
    projected_over_square: T,
}

/// Rows that are added up before they go to the whole: fewer roundings for each.
const GROUP: usize = 4;

/// The sums over the lanes of eight, each as `((a + b) + (c + d)) + ((e + f) + (g + h))`.
#[inline(always)]
fn totals<S: Simd>([p, q, r, s, t, u, v, w]: [f64x8<S>; rules::LANES]) -> [f64; rules::LANES] {
    // Neighbours of both, the first ones' first.
    let pairs = |a: f64x8<S>, b: f64x8<S>| a.unzip_low(b) + a.unzip_high(b);
    *pairs(pairs(pairs(p, q), pairs(r, s)), pairs(pairs(t, u), pairs(v, w))).as_array()
}

/// A row of nodes, from where a is 0 to where b is 1: points, and the values interpolated between the two ends.
struct Row<S: Simd> {
    start: Vec3<f64x8<S>>,
    step: Vec3<f64x8<S>>,
    facing: [f64x8<S>; 2],
    weight: f64x8<S>,
}

/// `(1 - b) p + b q`, which errs by 4u where neither is negative.
#[inline(always)]
fn between<S: Simd>([p, q]: [f64x8<S>; 2], b: f64x8<S>, complement: f64x8<S>) -> f64x8<S> {
    p * complement + q * b
}

impl<S: Simd> NodeSums<f64x8<S>> {
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

    /// The contributions of eight nodes.
    #[inline(always)]
    fn at_nodes(simd: S, r: Vec3<f64x8<S>>, weight: f64x8<S>, emission: f64x8<S>, facing: f64x8<S>) -> Self {
        let inverse = f64x8::splat(simd, 1.0) / (r.x * r.x + r.y * r.y + r.z * r.z);
        let positive = weight * inverse * inverse;
        let plain = positive * emission;
        let projected = plain * facing;
        let pull = projected * inverse;
        Self { positive, plain, projected, pulled: r * pull, plain_over_square: plain * inverse, projected_over_square: pull }
    }

    /// The sums over the lanes.
    #[inline(always)]
    fn total(self) -> NodeSums<f64> {
        let Self { positive, plain, projected, pulled: Vec3 { x, y, z }, plain_over_square, projected_over_square } = self;
        let [positive, plain, projected, x, y, z, plain_over_square, projected_over_square] =
            totals([positive, plain, projected, x, y, z, plain_over_square, projected_over_square]);
        NodeSums { positive, plain, projected, pulled: Vec3::new(x, y, z), plain_over_square, projected_over_square }
    }

    /// The sums of a row, eight nodes at a time whatever the machine, so that digits do not depend on it. The emission is a
    /// function of b and 1 - b.
    #[inline(always)]
    fn over_row(simd: S, row: &Row<S>, grid: Grid, emission: &impl Fn(f64x8<S>, f64x8<S>) -> f64x8<S>) -> Self {
        let mut sums = Self::zero(simd);
        let (rule, width, one) = (rules::rule(grid.count), f64x8::splat(simd, 1.0 / grid.panels as f64), f64x8::splat(simd, 1.0));
        for panel in 0..grid.panels {
            let shift = f64x8::splat(simd, panel as f64);
            for (nodes, weights) in rule.nodes.chunks_exact(rules::LANES).zip(rule.weights.chunks_exact(rules::LANES)) {
                let b = (f64x8::from_slice(simd, nodes) + shift) * width;
                let complement = one - b;
                let (weight, facing) = (f64x8::from_slice(simd, weights) * row.weight, between(row.facing, b, complement));
                sums.add(&Self::at_nodes(simd, row.start + row.step * b, weight, emission(b, complement), facing));
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
    pub(super) fn integral(&self, triangle: &Triangle<'_>) -> Integral {
        let Self { n1, n2, height, .. } = *self;
        let total = in_library!(*INSTRUCTION_SET, simd => triangle.sums(simd));
        let gradient = n2 * total.projected - n1 * (height * total.plain) + total.pulled * (4.0 * height);
        let error = triangle.error(self, &total);
        let Shape { twice_area, twice_area_error, .. } = *triangle.shape;
        // A relative error of the area is one of the whole.
        let (value, gradient) = (height * total.projected, gradient);
        let size = gradient.norm();
        Integral {
            value: twice_area * value,
            gradient: gradient * twice_area,
            value_error: triangle.rule.truncation.value + error.value + twice_area_error * value.abs(),
            gradient_error: triangle.rule.truncation.gradient + error.gradient + twice_area_error * size,
        }
    }
}

/// The affine function with these values at the corners, at barycentric coordinates; where no value is negative it errs by 3u
/// beside the errors of the values.
#[inline(always)]
fn interpolated<S: Simd>([apex, first, last]: [f64x8<S>; 3], [p, q, r]: [f64x8<S>; 3]) -> f64x8<S> {
    apex * p + first * q + last * r
}

/// The affine function with these values at the corners, at both ends of a row; it errs by 4u where none is negative.
#[inline(always)]
fn ends([apex, first, last]: [f64; 3], a: f64) -> [f64; 2] {
    let from_apex = (1.0 - a) * apex;
    [from_apex + a * first, from_apex + a * last]
}

/// A polynomial at eight places.
#[inline(always)]
fn values<S: Simd>(simd: S, polynomial: &Bivariate<f64>, places: [f64x8<S>; 2]) -> f64x8<S> {
    polynomial.value_on(
        places,
        #[inline(always)]
        |c| f64x8::splat(simd, c),
    )
}

impl Triangle<'_> {
    #[inline(always)]
    fn sums<S: Simd>(&self, simd: S) -> NodeSums<f64> {
        let splat = |value: f64| f64x8::splat(simd, value);
        match (&self.seen.emission, self.is_square()) {
            (OnTriangle::Affine(corners), true) => {
                let corners = corners.map(splat);
                self.in_one_row(simd, |nodes, _| interpolated(corners, nodes))
            }
            (OnTriangle::Polynomial(polynomial, [p, first, side]), true) => {
                let [u, v] = [0, 1].map(|k| [p[k], first[k], side[k]].map(splat));
                self.in_one_row(simd, |[_, _, last], along| {
                    values(simd, polynomial, [u[0] + u[1] * along + u[2] * last, v[0] + v[1] * along + v[2] * last])
                })
            }
            (OnTriangle::Affine(corners), false) => self.row_by_row(simd, |a| {
                let ends = ends(*corners, a).map(splat);
                move |b, complement| between(ends, b, complement)
            }),
            (OnTriangle::Polynomial(polynomial, [p, first, side]), false) => self.row_by_row(simd, |a| {
                let [u, v] = [0, 1].map(|k| [p[k] + first[k] * a, side[k] * a].map(splat));
                move |b, _| values(simd, polynomial, [u[0] + u[1] * b, v[0] + v[1] * b])
            }),
        }
    }

    /// Whether all nodes are in one row ([`square`]).
    fn is_square(&self) -> bool {
        let [rows, row] = self.rule.grid;
        rows == row && rows.panels == 1
    }

    /// The sums over the nodes of a square, with the emission as a function of their barycentric coordinates and of a.
    #[inline(always)]
    fn in_one_row<S: Simd>(&self, simd: S, emission: impl Fn([f64x8<S>; 3], f64x8<S>) -> f64x8<S>) -> NodeSums<f64> {
        let splat = |value: f64| f64x8::splat(simd, value);
        let (apex, first, side) = (self.seen.apex.map(splat), self.shape.first.map(splat), self.shape.side.map(splat));
        let facing = self.seen.facing.map(splat);
        let mut total = NodeSums::zero(simd);
        for sets in square::square(self.rule.grid[0].count).chunks(GROUP) {
            let mut group = NodeSums::zero(simd);
            for nodes in sets {
                let barycentric = nodes.barycentric.map(|row| f64x8::load_array(simd, row));
                let along = f64x8::load_array(simd, nodes.along);
                let weight = f64x8::load_array(simd, nodes.weights);
                let r = apex + first * along + side * barycentric[2];
                let (emission, facing) = (emission(barycentric, along), interpolated(facing, barycentric));
                group.add(&NodeSums::at_nodes(simd, r, weight, emission, facing));
            }
            total.add(&group);
        }
        total.total()
    }

    /// The sums, with the emission as a function of a, then of b and 1 - b.
    #[inline(always)]
    fn row_by_row<S: Simd, F: Fn(f64x8<S>, f64x8<S>) -> f64x8<S>>(&self, simd: S, emission: impl Fn(f64) -> F) -> NodeSums<f64> {
        let (apex, first, side, facing) = (self.seen.apex, self.shape.first, self.shape.side, self.seen.facing);
        let [rows, row] = self.rule.grid;
        let splat = |value: f64| f64x8::splat(simd, value);
        let width = [1.0 / rows.panels as f64, 1.0 / row.panels as f64];
        let rule = rules::rule(rows.count);
        let mut total = NodeSums::zero(simd);
        for panel in 0..rows.panels {
            let (nodes, weights) = (&rule.nodes[..rows.count], &rule.weights[..rows.count]);
            for (nodes, weights) in nodes.chunks(GROUP).zip(weights.chunks(GROUP)) {
                let mut group = NodeSums::zero(simd);
                for (node, weight) in nodes.iter().zip(weights) {
                    let a = (panel as f64 + node) * width[0];
                    let (start, step) = (apex + first * a, side * a);
                    let along = Row {
                        start: start.map(splat),
                        step: step.map(splat),
                        facing: ends(facing, a).map(splat),
                        weight: splat(weight * width[0] * width[1] * a),
                    };
                    group.add(&NodeSums::over_row(simd, &along, row, &emission(a)));
                }
                total.add(&group);
            }
        }
        total.total()
    }

    /// Additions that a term goes through: an addition to 0 is exact.
    fn additions(&self) -> usize {
        let [rows, row] = self.rule.grid;
        let over_lanes = rules::LANES.ilog2() as usize;
        if self.is_square() {
            let sets = square::sets(rows.count);
            return sets.min(GROUP) - 1 + sets.div_ceil(GROUP) - 1 + over_lanes;
        }
        let in_row = row.panels * row.count.div_ceil(rules::LANES) - 1;
        let in_group = rows.count.min(GROUP) - 1;
        let groups = rows.panels * rows.count.div_ceil(GROUP) - 1;
        in_row + in_group + groups + over_lanes
    }

    /// Bound on the rounding errors.
    fn error(&self, scene: &Scene<'_>, sums: &NodeSums<f64>) -> RuleBound {
        const U: f64 = ROUNDOFF;
        let Scene { height, ref source, input_error, is_clipped, .. } = *scene;
        let Rule { nearest, farthest, leg, base, .. } = self.rule;
        let Shape { sides_error, twice_area, misplaced_area, .. } = *self.shape;
        let SeenTriangle { distances, most_facing, facing_error, is_bright, .. } = *self.seen;
        let apex = if is_clipped { 2.0 } else { 1.0 };
        let node = if self.rule.grid.iter().all(|grid| grid.panels == 1) { 1.0 } else { 2.0 };
        let displaced = U * (apex * distances[0] + farthest + (1.0 + node) * leg + (2.0 + node) * base) + sides_error;
        let sum = self.additions() as f64 * U;
        let steep = (most_facing / nearest).min(1.0);
        // Sums of sizes, the same over r and over r^2, and the error of the emission.
        let bright = sums.positive * source.largest * (1.0 + 1e-9);
        let (plain, projected, emission) = if is_bright {
            let over_distance = |sum: f64, over_square: f64| (sum * over_square).sqrt() * (1.0 + 1e-9);
            let plain = [sums.plain, over_distance(sums.plain, sums.plain_over_square)];
            let projected = [sums.projected, over_distance(sums.projected, sums.projected_over_square)];
            (plain, projected, source.crossing + 2.0 * node * source.per_node)
        } else {
            let over_distance = |sum: f64| [sum, sum / nearest];
            (over_distance(bright), over_distance(bright * most_facing), source.rounding + 4.0 * node * source.per_node)
        };
        let emission = bright * emission;
        let pulled = plain[0].min(projected[1]);
        let inverted = if is_bright { sums.projected_over_square } else { pulled / nearest };
        // The errors that the three sums of a node have in common; the second and third have more.
        let common = |[size, over_distance]: [f64; 2]| 4.0 * displaced * over_distance + size * (27.0 * U + sum);
        let facing = facing_error + 2.0 * node * U * most_facing;
        let plain_error = common(plain) + emission;
        let projected_error = common(projected) + 7.0 * U * projected[0] + emission * most_facing + plain[0] * facing;
        let pulled_error = displaced * inverted + pulled * (10.5 * U + sum) + 0.5 * plain[1] * facing;
        let area = twice_area.abs();
        // Over the fourth power of the nearest distance.
        let near = nearest * nearest;
        let misplaced = misplaced_area / (near * near) * source.largest;
        RuleBound {
            value: height * (area * (projected_error + (2.0 * U + input_error) * projected[0]) + misplaced * most_facing),
            gradient: area * (projected_error + height * (plain_error + 4.0 * pulled_error))
                + area * U * (5.0 * projected[0] + height * (6.0 * plain[0] + 12.0 * pulled))
                + area * input_error * (projected[0] + height * (plain[0] + 4.0 * pulled))
                + misplaced * (most_facing + height * (1.0 + 4.0 * steep)),
        }
    }
}
