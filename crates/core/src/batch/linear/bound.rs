//! Bounds on the rounding errors of the sums of [`super`], on lanes.
//!
//! To first order in the unit roundoff u, as `batch::bound`.
//!
//! # Symbols
//! | symbol | meaning | error |
//! |---|---|---|
//! | S, k | distance of the nearest edge's line, and `1/S` | `(5.7c + 7) u` relative |
//! | R, c | distance of the farthest vertex, and `k R` | |
//! | Theta, n | sum of the angles g, and number of edges | |
//! | gB, beta | gradient of the emission, and the emission at the point of a line nearest to the receiver | |
//! | W | the largest emission at a vertex, and the length of gB times R: bounds beta, and gB times S | |
//! | h | height over the plane, the plane being known to a few roundings ([`crate::batch::linear::AffineEmission::new`]) | `dh <= 20u R` |
//! | d, s | place of a segment's end across and along its line, as in `linear_bound` | `dd <= 16u R`, `ds <= 5u R` |
//! | r, rho | distance of that end, and `(d^2 + s^2)^(1/2)` | r^2 by 5u relative |
//! | l, phi, psi | `ln(r/h)`, `atan2(s, d)`, `atan2(s, S)` | |
//! | ew | `5.66c u`, the relative error of an edge's moment | |
//!
//! # Terms, in units of W u
//! - `beta P` errs as the constant emitter's value, `Theta (5.7c + 17 + n/2)`, and by 4 Theta from beta; so does `h nu G`.
//! - C times h, with `|L| <= g c` and `kappa g` known to `2 ew + 40u`, errs by `8.3n + Theta (29.4c + 40)`, from the difference of
//!   two l known to `6u + 3u (l + l')`, of which `h l <= R/e`, and by `(n + 3) Theta (1 + c)` from the sum.
//! - X1 errs by its inputs, at each end of a segment. Its derivatives are at most `l + min(phi psi, 1)` with respect to phi,
//!   `min(phi psi, 1/2)` to psi, and phi to l (`linear_bound`).
//!   - phi moves by `(d ds + s dd)/rho^2`: of the first derivative, `l/rho <= 0.402/h` gives `0.402 (ds + dd)/h`, and
//!     `phi psi <= (pi/2) s/h` gives `(pi/2) (ds/2 + dd)/h`: 37.6 R/h in all.
//!   - psi moves by `ds/h`, and by `sin(2 psi)/2` times the relative error of S: `2.5 R/h` and `(1.5c + 2)`.
//!   - l errs by `dh/h + 3.5u + 3ul`: `31.5 R/h + 5.5 + 4.8 l`.
//!   - That is 143 R/h, 3c, 15 and 9.6 l for both ends. Where d has the wrong sign, the two segments are apart by `pi dd/h` at
//!     most, and the part of dd above, which is more, does not count.
//! - X1 errs by its evaluation, at each end:
//!   - phi to 4u of itself gives `6.3 (l + 1)`, and psi 3.2 at the first end. At the second it is that and g, which errs by
//!     `g (ew + 12.5u)`, and a sum: `4 + g (2.9c + 6.3)`;
//!   - J and the sums give `7.9 l + 22.9` (`linear_bound`, for right angles);
//!   - past a right angle pi and the quotient give 17.6, and its logarithm to 5.6u of itself `8.8 l + 6.2`, as
//!     `|ln 2 sin(phi + psi)| <= l + ln 2`.
//!   - The logarithm is taken of the product of several segments' quotients, which adds 0.8 for each.
//!   - With the difference of the two ends that is `50 l + 117` for both, and `Theta (n + 5)` from the sum, as `h |X1| <= R g` for
//!     a segment. Without its logarithm, at most `pi l + 2.2`, a term is larger by that: `(n + 5) (pi l + 2.2)` a segment.
//! - With `h l <= R/e` and `h c <= R`, `X1 h/R` is off by `143 + 3 + 22 + 1.2 (n + 5)` a segment, by `132 + 2.2 (n + 5)` h/R, and by
//!   9.2 Theta, half of which counts.
//! - The value in all, with its last products: `Theta (31c + 116 + 3n + n c/2) + n (98 + 0.6n + (72 + 1.1n) h/R)`.
//! - The gradient: that over h for `n2 Q`, and `k Theta (132c + 275 + 3n)` for the edges, two terms of the constant emitter's kind,
//!   with `gB P`.
//!
//! # Where the horizon crosses
//! c counts the crossing points and `1/|t|` too, n two edges more and Theta a half turn.
//! - A crossing point 8u R off and an angle 8c u off, `(32c + 27) u` for the horizon's, add `40c Theta + 78c n` to the value's
//!   units, and to the gradient's that over h and `k Theta 90c`.
//! - In X1 the two ends of edges that are crossing points have `ds <= 13u R` and l another 8u R/h off: 26 R/h each beyond the
//!   above.
//! - The horizon's segment has `S = h/|t|`, `d = h nu/|t|`, s to `12u R/|t|`, d to `23u R/|t|`, S to 20u R/h of itself and
//!   `6u/|t|`, l to 28u R/h: `(95 + 19/|t|) R/h` an end.
//! - The angles to which psi is added err by that much more, 8c of two edges and `32c + 27` of the horizon: `20c + 7`, half of it.
//! - In all 160c, of which 61c is in `78c n` already, and n is 5 at least: `98c n` instead.
//! - That the points are off along their edges by the angle eta changes the value by `pi eta^2` and the gradient by
//!   `eta^2 (k + 2 pi/h)`.

use fearless_simd::Simd;
use radgrad_numbers::lanes::lane::{Lane, Mask, constant};
use radgrad_numbers::number::ROUNDOFF;

use crate::batch::bound::{LaneBound, SECOND_ORDER};
use crate::batch::linear::{EmissionOnLanes, LinearSums, Wide};
use crate::batch::visible::SeenExtent;

/// Units of the value for each edge that no angle multiplies: half of C's 8.3 and of X1's 143, 3 and 22, and the last products; those,
/// half of X1's 132, that fall with the height; and of both the term of each edge for the sum of `n + 5`.
const EDGE_UNITS: f64 = 0.5 * (8.3 + 143.0 + 3.0 + 22.0) + 3.0 + 5.0 * UNITS_OF_SUM;
const EDGE_UNITS_OF_HEIGHT: f64 = 66.0 + 5.0 * UNITS_OF_SUM_OF_HEIGHT;
const UNITS_OF_SUM: f64 = 0.6;
const UNITS_OF_SUM_OF_HEIGHT: f64 = 1.1;

/// The quantities that the bounds are made of.
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
    pub(super) fn new<G: EmissionOnLanes<S>>(simd: S, sums: &LinearSums<S, G>, extent: &SeenExtent<S, f64>) -> Self {
        let number = |value: f64| constant::<S, f64>(simd, value);
        let zero = number(0.0);
        let SeenExtent { edges, farthest_square, crossing, .. } = extent;
        let farthest = farthest_square.sqrt();
        let unit = number(SECOND_ORDER * ROUNDOFF) * (sums.emission.largest(simd) + sums.emission.steepness(simd) * farthest);
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

    /// Whether terms of higher order are small, and the sums are numbers.
    #[inline(always)]
    pub(super) fn conditioned(&self, simd: S, value: Wide<S>) -> Mask<S, f64> {
        let limit = constant(simd, <f64 as Lane>::CONDITION);
        value.abs().at_most(constant(simd, f64::MAX))
            & self.condition.at_most(limit)
            & self.depth.at_most(limit)
            & self.shift.at_most(constant(simd, 1e-6))
    }

    #[inline(always)]
    pub(super) fn bound<const GRADIENT: bool>(&self, simd: S) -> LaneBound<S, f64> {
        let number = |value: f64| constant::<S, f64>(simd, value);
        let Self { unit, edges, angles, condition, crossing, nearest, inverse_height, depth, shift } = *self;
        let many = edges * (number(3.0) + condition * number(0.5));
        let by_angle = condition * number(31.0) + crossing * number(40.0) + number(116.0) + many;
        let of_height = number(EDGE_UNITS_OF_HEIGHT) + edges * number(UNITS_OF_SUM_OF_HEIGHT);
        let by_edge = crossing * number(98.0) + number(EDGE_UNITS) + edges * number(UNITS_OF_SUM) + of_height / depth;
        let units = angles * by_angle + edges * by_edge;
        // W, where it is not in units of roundoff.
        let size = unit * number(1.0 / (SECOND_ORDER * ROUNDOFF));
        let value = unit * units + size * shift * number(3.2);
        let mut gradient_square = number(0.0);
        if GRADIENT {
            let beside = angles * (condition * number(132.0) + crossing * number(90.0) + number(275.0) + edges * number(3.0));
            let moved = shift * (nearest + inverse_height * number(6.3));
            let gradient = unit * (nearest * beside + inverse_height * units) + size * moved;
            gradient_square = gradient * gradient;
        }
        LaneBound { value, gradient_square }
    }
}
