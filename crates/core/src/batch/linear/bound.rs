//! What rounding may have done to the sums of [`super`], on lanes.
//!
//! To first order in the unit roundoff u, as `batch::bound`, whose symbols these are: `k = 1/S` of the nearest edge's line, R the
//! distance of the farthest vertex, `c = k R`, Theta the sum of the angles, n the number of edges. W is the largest emission at a
//! vertex and |gB| R: it bounds beta, the emission at any line's point nearest to the receiver, and `|gB| S`. The plane, the
//! gradient and the emission at vertices are known to a few roundings ([`crate::batch::linear::Glow::new`]), so heights err by
//! 20u R. In units of W u:
//! - `beta P` errs as the constant emitter's value, `Theta (5.7c + 17 + n/2)`, and by 4 Theta from beta; so does `h nu G`;
//! - of C times h, with `|L| <= g c` and `kappa g` known to `2 ew + 40u`, `ew = 5.66c u`: `6n + Theta (29.4c + 40)`, from the
//!   logarithm of a ratio known to 11u, and `(n + 3) Theta (1 + c)` from the sum;
//! - X1 from its inputs: with `ds <= 5u R`, `dd <= 16u R` and `dh <= 20u R` at each end of a segment, and `|df/ds| <= 0.41/h`,
//!   `|df/dd| <= 1.58/h` (the strip and the ends' turn have opposite signs), `|df/dh| <= 1.58/h`: 118 R/h a segment;
//! - X1 from its evaluation, which is of the first order in phi, lambda and Clausen's function only:
//!   `df/dpsi = lambda - lambda = 0`, `df/dphi = ln r/h` with 2 ulp of phi, `4.7 R/h` at both ends since `h ln R/h <= R/e`;
//!   `2 CLAUSEN + 10 + 3.2c` from the Clausen functions and their arguments; `Theta (42c + 23 + n)` from lambda, known to
//!   `(42c + 3) u + 3u lambda`, from which `h lambda <= R`, and from the sum, since `h |f' - f| <= R g`;
//! - psi errs by `(42c + 7) u` relatively as its line's S is not quite `sqrt(h^2 + d^2)`: to second order, with
//!   `d^2 f/dpsi^2 = (|d|/s) r^2/h^2` and `psi <= s/S`, f by half its square times `c R^2/h^2`, and nothing is believed where
//!   `c (R/h)^2 > 2^36`.
//!
//! That is `Theta (52c + 120 + 3n + n c/2) + n (100 + 2c)` for the value with its last products, the same over h for `n2 Q`, and
//! for the edges, two terms of the constant emitter's kind, `k Theta (132c + 275 + 3n)` with `gB P`.
//!
//! # Where the horizon crosses
//! c counts the crossing points and `1/|t|` too, n two edges more and Theta a half turn. A crossing point 8u R off and an angle
//! 8c u off, `(32c + 27) u` for the horizon's, add `40c Theta + 78c n` to the value's units, and to the gradient's that over h
//! and `k Theta 90c`; the horizon's segment has `d = h nu/|t|` and s to `12u R/|t|`, `122 (R/h)/|t|` in X1. That the points are
//! off along their edges by the angle eta changes the value by `pi eta^2` and the gradient by `eta^2 (k + 2 pi/h)`.

use fearless_simd::Simd;

use crate::batch::bound::{LaneBound, SECOND_ORDER};
use crate::batch::linear::segment::CLAUSEN;
use crate::batch::linear::{Glowing, LinearSums, Wide};
use crate::batch::visible::SeenExtent;
use crate::lanes::lane::{Lane, Mask, constant};
use crate::scalar::number::ROUNDOFF;

/// Units of the value for each edge that no angle multiplies: half of C's 6 and X1's from inputs, phi, Clausen's function and
/// rounding.
const EDGE_UNITS: f64 = 0.5 * (6.0 + 118.0 + 9.4 + 2.0 * CLAUSEN + 10.0) + 3.0;

/// What bounds are made of.
pub(super) struct Scales<S: Simd> {
    /// `W u`.
    unit: Wide<S>,
    /// n and Theta, with the horizon's.
    edges: Wide<S>,
    angles: Wide<S>,
    /// c, its share that only the horizon counts, and k.
    condition: Wide<S>,
    crossing: Wide<S>,
    nearest: Wide<S>,
    /// `1/h` and `R/h`.
    inverse_height: Wide<S>,
    depth: Wide<S>,
    /// `eta^2`.
    shift: Wide<S>,
}

impl<S: Simd> Scales<S> {
    #[inline(always)]
    pub(super) fn new<G: Glowing<S>>(simd: S, sums: &LinearSums<S, G>, extent: &SeenExtent<S, f64>) -> Self {
        let number = |value: f64| constant::<S, f64>(simd, value);
        let zero = number(0.0);
        let SeenExtent { edges, farthest_square, crossing, .. } = extent;
        let farthest = farthest_square.sqrt();
        let unit = number(SECOND_ORDER * ROUNDOFF) * (sums.glow.largest(simd) + sums.glow.steepness(simd) * farthest);
        let inverse_height = number(1.0) / sums.height;
        let mut condition_square = sums.nearest * *farthest_square;
        let (mut edges, mut angles, mut is_crossed, mut shift) = (number(*edges), sums.angles, zero.below(zero), zero);
        if let Some((crossing, clipped)) = crossing {
            condition_square = condition_square.max(crossing.nearest * *farthest_square).max(sums.slant);
            edges = clipped.select(edges + number(2.0), edges);
            angles = clipped.select(angles + number(std::f64::consts::PI), angles);
            let eta = number(30.0 * SECOND_ORDER * ROUNDOFF);
            shift = (eta * eta) * (*farthest_square * crossing.slant);
            is_crossed = *clipped;
        }
        let condition = condition_square.sqrt();
        Self {
            unit,
            edges,
            angles,
            condition,
            crossing: is_crossed.select(condition, zero),
            nearest: sums.nearest.sqrt(),
            inverse_height,
            depth: farthest * inverse_height,
            shift,
        }
    }

    /// Whether what is of higher order is small, and the sums are numbers.
    #[inline(always)]
    pub(super) fn conditioned(&self, simd: S, value: Wide<S>) -> Mask<S, f64> {
        let steep = constant(simd, (1u64 << 36) as f64);
        let limit = constant(simd, <f64 as Lane>::CONDITION);
        value.abs().at_most(constant(simd, f64::MAX))
            & self.condition.at_most(limit)
            & self.depth.at_most(limit)
            & (self.condition * self.depth * self.depth).at_most(steep)
            & self.shift.at_most(constant(simd, 1e-6))
    }

    #[inline(always)]
    pub(super) fn bound<const GRADIENT: bool>(&self, simd: S) -> LaneBound<S, f64> {
        let number = |value: f64| constant::<S, f64>(simd, value);
        let Self { unit, edges, angles, condition, crossing, nearest, inverse_height, depth, shift } = *self;
        let many = edges * (number(3.0) + condition * number(0.5));
        let by_angle = condition * number(52.0) + crossing * number(40.0) + number(120.0) + many;
        let by_edge = condition * number(2.0) + crossing * number(78.0) + number(EDGE_UNITS);
        let off = condition * number(42.0) + number(7.0);
        let second = edges * (off * off) * (condition * depth) * number(0.5 * SECOND_ORDER * ROUNDOFF);
        let units =
            mutant!("batch.linear-value", angles * by_angle + edges * by_edge + second, |units: Wide<S>| units * number(0.01));
        // W, where it is not in units of roundoff.
        let size = unit * number(1.0 / (SECOND_ORDER * ROUNDOFF));
        let value = unit * units + size * shift * number(3.2);
        let mut gradient_square = number(0.0);
        if GRADIENT {
            let beside = angles * (condition * number(132.0) + crossing * number(90.0) + number(275.0) + edges * number(3.0));
            let moved = shift * (nearest + inverse_height * number(6.3));
            let gradient = mutant!(
                "batch.linear-gradient",
                unit * (nearest * beside + inverse_height * units) + size * moved,
                |bound: Wide<S>| bound * number(0.01)
            );
            gradient_square = gradient * gradient;
        }
        LaneBound { value, gradient_square }
    }
}
