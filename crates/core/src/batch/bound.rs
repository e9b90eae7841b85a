//! Bounds on the rounding errors of the sums of [`crate::batch::edge`], on lanes.
//!
//! To first order in the unit roundoff u; [`SECOND_ORDER`] pays for the rest, since no relative error above 4e-4 is let through
//! ([`Lane::CONDITION`]).
//!
//! # Symbols
//! | symbol | meaning | error |
//! |---|---|---|
//! | r, e | offset of an edge's start, and the edge | u of their length |
//! | n1 | the receiver's normal | 4.5u |
//! | S, k | distance of the edge's line, and `1/S`; the sums are bounded with the largest k | |
//! | R | distance of the farthest vertex | |
//! | rho | `k` times the length of r, at most `k R` | |
//! | w, m, N | moment `r x e`, its length, and its direction | `ew = 5.66 rho u` relative; N by ew |
//! | p, p' | ends of the visible piece | |
//! | g | angle between p and p' | |
//! | q, t | factors of the gradient's terms ([`crate::batch::edge`]) | |
//! | n | number of edges | |
//!
//! # Terms
//! - w errs by `4 sqrt(2) u |r||e|`, by Cauchy's inequality: by ew relative. m errs by `ew + 2.5u`, 1/m by `ew + 6.5u`.
//! - The scalar products p.p', p.e, n1.r and n1.e err by 5, 5, 8.5 and 8.5u of the lengths.
//! - The angle errs by `sin g (ew + 3.5u)` from m, by `5u sin g` from p.p', and by an ulp or two, at most 2u g each.
//! - `1/m^2` errs by `2 ew + 6u`, q by 15u, and so `g/m^3` by `3 ew + 17.5u` and the error of the angle.
//! - `q (2/e^2 - p.p'/m^2)` is `sin g cos(psi + psi')` over m^3, and errs by `sin g (2 ew |cos g| + 43u)` over m^3.
//! - The errors that both have from m are of opposite signs up to a right angle. Together they err by `g (3.7 ew + 75u)` over m^3,
//!   of a sum of at most 2g.
//! - t errs by `30u |r| e^2` from two products that may cancel, and so, over m |e|, by `(30 rho + 1) u`.
//! - `q (n1.e) (p + p').e/e^2` errs by 60u k g over m, of at most k g over m.
//! - So a term of the value errs by `g (2 ew + 29u)/2`.
//! - One of the gradient errs, over g k, by half of `3.7 ew + 75u`, of `2 (30 rho + 1) u` and of 60u, since the sums are twice
//!   the gradient; by ew from w again, and by 2u for the sum and the product with w. With `ew = 5.66 rho u` that is
//!   `(46.2 rho + 70.5) u`, taken as `g k (50 rho + 73) u`.
//! - Sums of n terms with the last five products add `n + 5`.
//!
//! # Where the horizon crosses
//! With `c = R/|p|`, the largest over crossing points:
//! - A crossing point `p = r + f e` is in place for the fraction f computed but for 6u R, taken as 8u R. That adds 8cu to the error
//!   of an angle and 44cu to that of a term of the gradient, relative to g.
//! - The horizon's own angle errs by `(32 c + 27) u`.
//! - f errs by `25 u R/d`, d the difference of the two heights, 16 of it from a vertex that was taken to be on the horizon. So the
//!   point is off along the edge by an angle of at most `eta = 30 u c |e|/d`.
//! - There `n1.omega = 0`: the light between the true and the assumed horizon changes the value by at most `pi eta^2`, the gradient
//!   by `k eta^2`.
//! - An edge with both ends on the assumed horizon is left out of the sums but not of the bound: it is less than `16u rho` above
//!   the true one, which changes the gradient by `16 rho k g u` and the value by the square of that.

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
