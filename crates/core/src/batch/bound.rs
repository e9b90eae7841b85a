//! Bounds on the rounding errors of the sums of [`crate::batch::edge`], on lanes.
//!
//! To first order in the unit roundoff u; [`SECOND_ORDER`] pays for the rest, since no relative error above 4e-4 is let through
//! ([`Lane::CONDITION`]).
//!
//! `docs/theory/constant-bound-on-lanes.md` has the symbols and the derivation.

use fearless_simd::Simd;
use radgrad_numbers::lanes::angle::ANGLE_ULP;
use radgrad_numbers::lanes::lane::{Lane, Lanes, Mask, constant};

use crate::batch::span::Crossing;
use crate::batch::sums::ConstantSums;

/// Pays for terms of second order.
pub(super) const SECOND_ORDER: f64 = 1.05;

/// Roundings of a term of the value, the sum's apart: an angle counts half.
const VALUE_UNITS: f64 = 0.5 * (30.0 + 2.0 * ANGLE_ULP);

/// Roundings of a term of the gradient, the sum's apart.
const GRADIENT_UNITS: f64 = 76.0 + ANGLE_ULP;

/// Units for the horizon's angle, at most pi.
const CLOSING_UNITS: f64 = 0.5 * (15.0 + 2.0 * std::f64::consts::PI * ANGLE_ULP);

/// Bounds on the sums `n1.Phi` and the gradient's.
pub(super) struct LaneBound<S: Simd, F: Lane> {
    pub(super) value: Lanes<S, F>,
    /// Square of the bound on the gradient's error.
    pub(super) gradient_square: Lanes<S, F>,
}

/// Half the root at which [`root_at_most`] is exact.
const TOUCHING: f64 = 8.0;

/// A root, or where it only decides which lanes are taken an upper bound on it: a root costs as much as twenty products. Single
/// precision is often near its limit.
#[inline(always)]
fn root_at_most<S: Simd, F: Lane>(simd: S, square: Lanes<S, F>, tight: bool) -> Lanes<S, F> {
    if tight || F::IS_SINGLE { square.sqrt() } else { square * constant(simd, 0.25 / TOUCHING) + constant(simd, TOUCHING) }
}

/// Whether the sums are known to a few digits at least; where they are not the receiver is next to an edge or its extension, or
/// the horizon cuts off a sliver.
#[inline(always)]
pub(super) fn conditioned<S: Simd, F: Lane>(
    simd: S,
    sums: &ConstantSums<S, F>,
    crossing: Option<&Crossing<S, F>>,
    farthest_square: Lanes<S, F>,
) -> Mask<S, F> {
    let limit = constant(simd, F::CONDITION * F::CONDITION);
    // Where the first holds nothing was NaN.
    let well = sums.value.abs().at_most(limit) & (sums.nearest * farthest_square).at_most(limit);
    let Some(crossing) = crossing else { return well };
    let worst = crossing.nearest.max(crossing.slant);
    well & (worst * farthest_square).at_most(limit)
}

/// The bounds for an outline of `edges` edges; looser where they need not be tight.
#[inline(always)]
pub(super) fn bound<S: Simd, F: Lane, const GRADIENT: bool>(
    simd: S,
    (edges, tight): (f64, bool),
    sums: &ConstantSums<S, F>,
    crossing: Option<&Crossing<S, F>>,
    farthest_square: Lanes<S, F>,
) -> LaneBound<S, F> {
    // The sums are twice the quantities that they are for.
    let units = constant(simd, 2.0 * SECOND_ORDER * F::ROUNDOFF) * sums.angles;
    // k R.
    let condition = root_at_most(simd, sums.nearest * farthest_square, tight);
    let mut value = units * (constant(simd, VALUE_UNITS + 0.5 * edges) + constant(simd, 5.7) * condition);
    let mut gradient = constant(simd, 0.0);
    if GRADIENT {
        gradient = units * (constant(simd, GRADIENT_UNITS + edges) + constant(simd, 50.0) * condition);
    }
    if let Some(Crossing { nearest, slant }) = crossing {
        let c = (*nearest * farthest_square).sqrt();
        let roundoff = constant(simd, SECOND_ORDER * F::ROUNDOFF);
        let eta_square = (constant(simd, 30.0) * roundoff) * (constant(simd, 30.0) * roundoff) * (farthest_square * *slant);
        let closing = (roundoff + roundoff) * (c * constant(simd, 16.0) + constant(simd, CLOSING_UNITS));
        value = value + units * c * constant(simd, 4.0) + eta_square * constant(simd, 6.4);
        // Lanes that are not cut must not see that others are.
        value = value + constant(simd, 0.0).below(c).select(closing, constant(simd, 0.0));
        if GRADIENT {
            gradient = gradient + units * c * constant(simd, 44.0) + (eta_square + eta_square);
        }
    }
    LaneBound { value, gradient_square: sums.nearest * (gradient * gradient) }
}
