//! A triangle of the fan, `y = P + a (e1 + b e)`, a and b in [0, 1], e the side opposite P: the number of nodes for the precision that
//! is requested, and a bound on the truncation.
//!
//! # Symbols
//! | symbol | meaning |
//! |---|---|
//! | l | half the length of the segment on which y moves in one variable, the other held |
//! | `E_R` | Bernstein's ellipse around the segment, with semi-axes `A = (R + 1/R)/2` and `tau = (R - 1/R)/2` in units of l |
//! | d | lower bound on the distance of the real segment stretched to A: see below |
//! | q | `d^2 - tau^2 l^2`, a lower bound on the size of `r.r` in `E_R` |
//! | rho | distance of the farthest point of the triangle |
//! | M | bound on the integrand in `E_R` |
//! | n | nodes in the variable |
//!
//! # Truncation
//! - d is the height over the plane, or the distance of the centroid less the reach of the stretched triangle.
//! - In `E_R` `|r| <= rho + (R - 1) l`, `n1.r` grows by no more than that, and B as [`source`](crate::gauss::source) says: this
//!   gives M.
//! - The Chebyshev coefficients of the integrand are at most `2 M R^-k`.
//! - n nodes are exact below degree 2n, and for all odd k, where rule and integral are both 0.
//! - For an even k from 2n on, the rule on [-1, 1] gives at most 2 of the Chebyshev polynomial, its weights' sum, and the
//!   integral `2/(k^2 - 1) <= 2/3`: together they err by at most `8/3` of the coefficient.
//! - The sum over even k from 2n on is `(8/3) 2 M R^(-2n) / (1 - R^-2)`, and half of it on a unit interval:
//!   `(8/3) M R^(-2n) / (1 - R^-2)`, one such term for each variable. (The argument of Trefethen, "Is Gauss quadrature better
//!   than Clenshaw-Curtis?", 2008, Theorem 4.5, whose bound gives one power of `R^2` away.)
//!
//! # Equal numbers of nodes
//! Where few nodes do in the variable with the longer segment, the other has as many and is not planned. Twice the bound of the
//! longer segment then holds for the shorter one:
//! - Around the shorter segment take the ellipse that reaches as far beyond the ends, with A' and R' for A and R. It is no wider,
//!   so q and M but for the emission's growth are no worse, R' is larger than R, and the Jacobian at most 1/2 on average.
//! - A constant emission does not grow.
//! - An affine one grows by `A' <= R'`, and `R' R'^(-2n) <= R R^(-2n) <= 2A R^(-2n)`.
//! - One of degree `m <= 2n` grows by `R'^m`, and `R'^(m - 2n) <= R^(m - 2n)`.

use std::ops::Add;

use radgrad_numbers::number::ROUNDOFF;
use radgrad_numbers::offset::offset;
use radgrad_numbers::vec3::Vec3;

use crate::gauss::outline::OutlineCorner;
use crate::gauss::scene::Scene;
use crate::gauss::source::OnTriangle;
use crate::gauss::{FULL_PRECISION, rules, square};
use crate::problem::fan::{FanTriangle, Shape};
use crate::problem::receiver::Receiver;

/// A triangle of the fan, seen from the receiver, with the rule for it.
#[derive(Debug)]
pub(super) struct Triangle<'a> {
    pub(super) shape: &'a Shape,
    pub(super) seen: &'a SeenTriangle,
    pub(super) rule: Rule,
}

/// The grid of nodes, a bound on its truncation, and the triangle's extent.
#[derive(Debug, Clone, Copy)]
pub(super) struct Rule {
    pub(super) grid: [Grid; 2],
    pub(super) truncation: RuleBound,
    /// Bounds on the distance of its points from the receiver.
    pub(super) nearest: f64,
    pub(super) farthest: f64,
    /// The longer of the two sides at P, and the side opposite.
    pub(super) leg: f64,
    pub(super) base: f64,
}

/// The corners of a triangle as the receiver sees them, the apex P first.
#[derive(Debug)]
pub(super) struct SeenTriangle {
    /// P, and the distances of all corners.
    pub(super) apex: Vec3<f64>,
    pub(super) distances: [f64; 3],
    /// `n1.r`, the largest of these, and a bound on the error of them.
    pub(super) facing: [f64; 3],
    pub(super) most_facing: f64,
    pub(super) facing_error: f64,
    /// Bounds on the distance of the centroid, from below, and on that of a corner from it.
    pub(super) centroid: f64,
    pub(super) reach: f64,
    pub(super) emission: OnTriangle,
    /// Whether that is known to be nowhere negative.
    pub(super) is_bright: bool,
}

/// Bounds on the errors of value and gradient.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct RuleBound {
    pub(super) value: f64,
    pub(super) gradient: f64,
}

impl Add for RuleBound {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Self { value: self.value + other.value, gradient: self.gradient + other.gradient }
    }
}

/// A composite rule for one variable: equal panels with the same number of nodes.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(super) struct Grid {
    pub(super) panels: usize,
    pub(super) count: usize,
}

impl Grid {
    pub(super) const fn nodes(self) -> usize {
        self.panels * self.count
    }
}

impl Rule {
    pub(super) const fn nodes(&self) -> usize {
        self.grid[0].nodes() * self.grid[1].nodes()
    }
}

/// As many nodes in both variables where they take no more sets of lanes than rows of their own.
fn squared(grid: [Grid; 2]) -> [Grid; 2] {
    let [rows, row] = grid;
    let count = rows.count.max(row.count);
    let is_cheaper = rows.panels * row.panels == 1 && square::sets(count) <= rows.count * row.count.div_ceil(rules::LANES);
    if is_cheaper { [Grid { panels: 1, count }; 2] } else { grid }
}

/// So many nodes both variables have without a plan for the one that may need fewer.
const FEW: usize = 8;

/// The quantities that bound the integrand on a triangle.
struct Reach {
    /// Lower bound of the distance of the centroid less that of the corners from it.
    clear: f64,
    farthest: f64,
    most_facing: f64,
    area: f64,
    /// Truncation that is not worth another node.
    enough: RuleBound,
}

impl Scene<'_> {
    /// A triangle of a polygon that is fully visible, lengths of the fan being multiplied by `power`.
    #[inline(always)]
    pub(super) fn plain_triangle(&self, receiver: &Receiver, fan: &FanTriangle, power: f64) -> (Shape, SeenTriangle) {
        let vertices = self.source.polygon().vertices();
        let [a, b, c] = fan.corners;
        let places = [vertices[a], vertices[b], vertices[c]];
        let see = |place| offset::<f64>(place, receiver.position(), self.power);
        let offsets = [see(places[0]), see(places[1]), see(places[2])];
        let distances = [offsets[0].norm(), offsets[1].norm(), offsets[2].norm()];
        let facing = |i: usize| self.facing(receiver, places[i], offsets[i], distances[i]);
        let ((p, p_error), (q, q_error), (r, r_error)) = (facing(0), facing(1), facing(2));
        let centroid = (offsets[0] + fan.middle * power).norm() * (1.0 - 32.0 * ROUNDOFF);
        let (emission, is_bright) = self.source.on_corners(fan.corners, places);
        let triangle = SeenTriangle {
            apex: offsets[0],
            distances,
            facing: [p, q, r],
            most_facing: largest([p, q, r]),
            facing_error: largest([p_error, q_error, r_error]),
            centroid,
            reach: fan.reach * power + 32.0 * ROUNDOFF * centroid,
            emission,
            is_bright,
        };
        (fan.shape.scaled(power), triangle)
    }

    /// A triangle of a clipped outline with local offsets up to `spread`.
    pub(super) fn clipped_triangle(&self, corners: [OutlineCorner; 3], spread: f64) -> (Shape, SeenTriangle) {
        let [a, b, c] = &corners;
        let sides = [b.local - a.local, c.local - a.local, c.local - b.local];
        // Two local offsets and their difference; a share of it is the displacement of crossings as seen from the receiver.
        let mut shape = Shape::new(sides, sides.map(Vec3::norm), self.n2, 60.0 * ROUNDOFF * spread);
        shape.misplaced_area = 70.0 * ROUNDOFF * spread * largest(shape.lengths);
        let middle = (a.from_receiver + b.from_receiver + c.from_receiver) * (1.0 / 3.0);
        let centroid = middle.norm() * (1.0 - 32.0 * ROUNDOFF);
        let facing = [a.facing, b.facing, c.facing];
        let triangle = SeenTriangle {
            apex: a.from_receiver,
            distances: [a, b, c].map(|corner| corner.from_receiver.norm()),
            facing,
            most_facing: largest(facing),
            facing_error: largest([a.facing_error, b.facing_error, c.facing_error]),
            centroid,
            reach: largest([a, b, c].map(|corner| (corner.from_receiver - middle).norm())) + 32.0 * ROUNDOFF * centroid,
            emission: self.source.on_triangle([&a.lit, &b.lit, &c.lit]),
            is_bright: corners.iter().all(|corner| corner.lit.is_bright()),
        };
        (shape, triangle)
    }

    /// The number of nodes that a triangle needs; `None` if that is more than there are rules for.
    #[inline]
    pub(super) fn rule(&self, shape: &Shape, seen: &SeenTriangle) -> Option<Rule> {
        let [first, last, base] = shape.lengths;
        let leg = larger(first, last);
        // The area would lose digits to underflow.
        if larger(leg, base) < 1e-130 {
            return None;
        }
        let clear = seen.centroid - seen.reach;
        let nearest = larger(self.height, clear);
        let farthest = largest(seen.distances) * (1.0 + 4.0 * ROUNDOFF);
        let area = shape.twice_area.abs();
        // Slivers along the horizon are worth fewer than nine digits less than their area says.
        let nearness = 1.0 / farthest;
        let [p, q, r] = seen.facing;
        let facing = larger((p + q + r) * nearness * (1.0 / 3.0), 1e-9);
        let typical = 0.5 * area * self.source.largest * self.height * (nearness * nearness * nearness);
        let share = if seen.is_bright { self.enough } else { FULL_PRECISION };
        let enough = RuleBound { value: share * typical * facing, gradient: share * typical * nearness };
        let bounds = Reach { clear, farthest, most_facing: seen.most_facing, area, enough };
        // The Jacobian a is at most 1 + (A - 1)/2p in its own variable on p panels, and 1/2 on average in the other.
        let of_own = |overhang| 1.0 + overhang;
        let (grid, truncation) = match self.nodes(&bounds, 0.5 * larger(leg, base), |stretch| of_own(0.5 * (stretch - 1.0))) {
            Some((count, bound)) if count <= FEW && self.source.degree() <= 2 * count => {
                ([Grid { panels: 1, count }; 2], bound + bound + bound)
            }
            _ => {
                let (along, bound) = self.grid(&bounds, 0.5 * leg, of_own)?;
                let (across, other) = self.grid(&bounds, 0.5 * base, |_| 0.5)?;
                (squared([along, across]), bound + other)
            }
        };
        Some(Rule { grid, truncation, nearest, farthest, leg, base })
    }

    /// The cheapest grid for one variable, and the bound on its truncation.
    fn grid(&self, reach: &Reach, half: f64, jacobian: impl Fn(f64) -> f64) -> Option<(Grid, RuleBound)> {
        /// So few nodes are never half as many on half the length.
        const UNDIVIDED: usize = 6;
        let mut best: Option<(Grid, RuleBound)> = None;
        for panels in [1, 2, 4, 8] {
            let share = 1.0 / panels as f64;
            let overhang = |stretch: f64| jacobian(0.5 * (stretch - 1.0) * share);
            let Some((count, bound)) = self.nodes(reach, half * share, overhang) else { continue };
            let grid = Grid { panels, count };
            if best.is_some_and(|(cheapest, _)| cheapest.nodes() <= grid.nodes()) {
                break;
            }
            best = Some((grid, bound));
            if count <= UNDIVIDED {
                break;
            }
        }
        best
    }

    /// Nodes that each panel of half-length `half` needs, and the bound on the truncation of all panels.
    fn nodes(&self, reach: &Reach, half: f64, jacobian: impl Fn(f64) -> f64) -> Option<(usize, RuleBound)> {
        /// Share of the way to the nearest singularity; above it M grows faster than the ellipse helps.
        const SHARE: f64 = 0.75;
        let Self { height, ref source, .. } = *self;
        let tau = SHARE * larger(height, 0.5 * reach.clear) / half;
        let stretch = (tau * tau + 1.0).sqrt();
        let ratio = stretch + tau;
        let distance = larger(height, reach.clear - (stretch - 1.0) * half) * (1.0 - 8.0 * ROUNDOFF);
        let q = distance * distance - tau * tau * half * half;
        if q <= 0.0 || q.is_nan() {
            return None;
        }
        let grown = (ratio - 1.0) * half;
        let (far, facing) = (reach.farthest + grown, reach.most_facing + grown);
        let emission = source.largest * source.growth(stretch, ratio);
        let shrink = 1.0 / (ratio * ratio);
        // Small and large factors first: far away one of them alone times the area might underflow.
        let common = 8.0 / 3.0 * 1.01 * (shrink * jacobian(stretch) * emission) * reach.area / (q * q * (1.0 - shrink));
        let mut bound =
            RuleBound { value: common * height * facing, gradient: common * (facing + height + 4.0 * height * facing * far / q) };
        for count in 1..=rules::MOST {
            if bound.value <= reach.enough.value && bound.gradient <= reach.enough.gradient {
                return Some((count, bound));
            }
            bound.value *= shrink;
            bound.gradient *= shrink;
        }
        None
    }
}

#[inline(always)]
fn larger(a: f64, b: f64) -> f64 {
    if a > b { a } else { b }
}

#[inline(always)]
fn largest([a, b, c]: [f64; 3]) -> f64 {
    larger(larger(a, b), c)
}
