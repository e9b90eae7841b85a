//! Bounds on the rounding errors of the sums of [`super`], on lanes.
//!
//! To first order in the unit roundoff u, as `batch::bound`.
//!
//! `docs/theory/linear-bound-on-lanes.md` has the symbols and the derivation.

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
