//! The sums past occluders, over arcs whose ends are directions, with a derived bound: where [`sure`] is sure of the visible part.
//!
//! Symbols are those of [`super`] and of [`sure`]; `delta` and `delta'` are the spreads of an arc's ends, `d` their sum, and A and C
//! the sums of the sizes of `a = toward.u` and of `c = n1.u` over the ends.
//!
//! - (inline, across) is a vector of about the length `|p||p'|`. The ends move its angle by d; the cross product errs by 2.5u, its
//!   product with N by `(en + 3u) sin g`, and inline by 3u, which turns the vector by `3u sin g`:
//!   `dg = d + 2.5u + min(g, 1) (en + 6u) + 4ug`. The ends displace an arc's plane in second order only.
//! - One over a length errs by 3.5u, so the sine by `ds = d + 2.5u + min(g, 1) (en + 13u)` and the cosine by `d + 12u`; `1 + cos`
//!   is at least 1, `chi` at most `(T/4)(g + sin g)`, and errs by `(T/4)(dg + ds) + chi (d + 18u)`.
//! - `toward` errs by `en + 10u`, one over S by `ew + 8u` relative, so a/S by `delta + 2 en + 27u` over S, and c by
//!   `delta + 9u`: their sums and differences by `da = d + 4 en + 56u` and `dc = d + 20u`.
//! - With `|u' - u| <= g` for the differences, and psi as in [`super`], the weight times S errs by
//!   `A C ((T/4)(dg + ds) + chi (d + 18u)) + chi (da C + A dc) + 0.11 dg g^2 + 0.091 g (g (da + dc) + 6u g^2)` and by 3u of its
//!   size, which is at most `chi A C + 0.091 g^3`. Its product with N errs by `ew + 5u` of that size.
//! - Past a quarter turn the weight is that of [`super`], with the larger delta for eta.
//! - An arc of the horizon has a normal that errs by 2u, and no weight.

use radgrad_numbers::number::ROUNDOFF;

use super::units::{self, LARGEST_PSI, SECOND_ORDER, SLOPE_OF_PSI};
use super::{AngleError, BoundedSum};
use crate::boundary::arc::Arc;
use crate::boundary::case::Case;
use crate::boundary::line::Line;
use crate::boundary::visibility::sure::{self, Hidden, SureArc};
use crate::forms::constant::{EdgeSum, SolidAngleVector};
use crate::forms::irradiance_and_gradient::IrradianceAndGradient;
use crate::problem::receiver::unit_normal;

const U: f64 = ROUNDOFF;

/// The sums for a unit emission and the bounds; they mean nothing unless something is surely hidden.
pub(crate) fn sums(case: &Case<'_>) -> (Hidden, IrradianceAndGradient<f64>, BoundedSum) {
    let Case { receiver, emitter, occluders, plan } = *case;
    let n1 = unit_normal(receiver);
    let (mut angles, mut edges) = (SolidAngleVector::zero(), EdgeSum::new(n1));
    let mut errors = Errors { arcs: 0.0, angles: [0.0; 2], edges: [0.0; 2] };
    let hidden = sure::visit_boundary(receiver, emitter.polygon(), occluders, plan, |sure| {
        angles.add(&sure.arc);
        edges.add(&sure.arc);
        let facing = n1.dot(sure.arc.generator.normal()).abs();
        let cosines = || [&sure.arc.start, &sure.arc.end].map(|end| end.cosine(n1).abs()).iter().sum();
        errors.add(sure, facing, cosines);
    });
    let terms = IrradianceAndGradient { irradiance: angles.phi(), gradient: edges.sum() };
    let [of_angles, of_edges] = errors.totals();
    let bound = BoundedSum::new(&terms, of_angles, of_edges);
    (hidden, terms, bound)
}

/// Sums of sizes and of errors.
struct Errors {
    arcs: f64,
    angles: [f64; 2],
    edges: [f64; 2],
}

impl Errors {
    fn add(&mut self, sure: &SureArc, facing: f64, cosines: impl FnOnce() -> f64) {
        let SureArc { arc, spreads: [first, last], normal_error } = sure;
        let (g, spread) = (arc.angle.abs(), first + last);
        let least = g.min(1.0);
        let of_angle = AngleError {
            g,
            dg: mutant!(
                "past-occluders.angle",
                spread + 2.5 * U + least * (normal_error + 6.0 * U) + g * (units::ARC_TANGENT * U),
                |dg| 0.1 * dg
            ),
            ds: spread + 2.5 * U + least * (normal_error + 13.0 * U),
            ew: arc.line().map_or(0.0, Line::relative_error),
            eta: Some(first.max(*last)),
        };
        self.arcs += 1.0;
        self.angles[0] += g;
        self.angles[1] +=
            if g + SECOND_ORDER * of_angle.dg < std::f64::consts::PI { of_angle.of_term(facing) } else { f64::INFINITY };
        let Some(line) = arc.line() else { return };
        let (size, error) = if arc.is_within_a_quarter_turn() {
            let (size, error) = of_weight(arc, line, &of_angle, spread, *normal_error, cosines());
            (size, error + size * (of_angle.ew + 5.0 * U))
        } else {
            let (size, error) = of_angle.of_wide_weight(line.nearness());
            (size, error + size * of_angle.ew)
        };
        self.edges[0] += size;
        self.edges[1] += error;
    }

    /// Errors of both sums.
    fn totals(&self) -> [f64; 2] {
        let sums = (self.arcs - 1.0).max(0.0) * U;
        [self.angles, self.edges].map(|[sizes, errors]| errors + sums * sizes)
    }
}

/// A bound on the size of the weight up to a quarter turn, and its error.
fn of_weight(arc: &Arc<f64>, line: &Line<f64>, of_angle: &AngleError<f64>, spread: f64, en: f64, cosines: f64) -> (f64, f64) {
    let AngleError { g, dg, ds, .. } = *of_angle;
    let toward = line.frame().toward;
    let aside = arc.start.cosine(toward).abs() + arc.end.cosine(toward).abs();
    let (sum, turn) = arc.angle_and_sine();
    let (quarter, chi) = (0.25 * turn, 0.25 * turn * sum);
    let (da, dc) = (spread + 4.0 * en + 56.0 * U, spread + 20.0 * U);
    let of_chi = quarter * (dg + ds) + chi * (spread + 18.0 * U);
    let first = of_chi * aside * cosines + chi * (da * cosines + aside * dc);
    let second = SLOPE_OF_PSI * dg * g * g + LARGEST_PSI * g * (g * (da + dc) + 6.0 * U * g * g);
    let size = chi * aside * cosines + LARGEST_PSI * g * g * g;
    let nearness = line.nearness();
    (size * nearness, mutant!("past-occluders.weight", (first + second + 3.0 * U * size) * nearness, |error| 0.1 * error))
}
