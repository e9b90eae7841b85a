//! The sums with occluders, over arcs whose ends are directions, with a derived bound: where [`sure`] is sure of the visible part.
//!
//! Symbols are those of [`super`] and of [`sure`]; `delta` and `delta'` are the spreads of an arc's ends, `d` their sum, sigma and
//! sigma' the shares along the arc's side, `l` their sum, and A and C the sums of the sizes of `a = toward.u` and of `c = n1.u` over
//! the ends.
//!
//! - (inline, across) is a vector of about the length `|p||p'|`. The ends move its angle by l. They and N are off the arc's plane in
//!   second order only, so that N counts by its length, 3.5u, and its rounding. The cross product errs by `(4/3)^(1/2) u < 1.2u` and
//!   u of itself, its product with N by `8.5u sin g`, and inline by 3u, which turns the vector by `3u sin g`:
//!   `dg = l + 1.2u + min(g, 1) 11.5u + 4ug`.
//! - One over a length errs by 3.5u, so the sine by `ds = l + 1.2u + min(g, 1) 18.5u` and the cosine by `l + 12u`; `1 + cos`
//!   is at least 1, `chi` at most `(T/4)(g + sin g)`, and errs by `(T/4)(dg + ds) + chi (l + 18u)`.
//! - `toward` errs by `en + 14u` and is normal to N, so that only the ends' share along the side moves a; one over S errs by
//!   `ew + 8u` relative, so a/S by `sigma + 2 en + 35u` over S, and c by `delta + 9u`: their sums and differences by
//!   `da = l + 4 en + 72u` and `dc = d + 20u`.
//! - With `|u' - u| <= g` for the differences, and psi as in [`super`], the weight times S errs by
//!   `A C ((T/4)(dg + ds) + chi (l + 18u)) + chi (da C + A dc) + 0.11 dg g^2 + 0.091 g (g (da + dc) + 6u g^2)` and by 3u of its
//!   size, which is at most `chi A C + 0.091 g^3`. Its product with N errs by `ew + 5u` of that size.
//! - Past a quarter turn the weight is that of [`super`], with the larger delta for eta.
//! - An arc of the horizon has a normal that errs by 2u, and no weight.
//! - Errors of at most `e_i` along the normals `N_i` are together, along any unit vector v, at most
//!   `sum e_i |N_i.v| <= (sum e_i)^(1/2) (v.M v)^(1/2)`, `M = sum e_i N_i N_i^T`, by Cauchy's inequality. The trace of M is
//!   `E = sum e_i`, and its largest eigenvalue at most `(|M^2|_F)^(1/2)`: together at most E times the fourth root of
//!   `|(M/E)^2|_F`.

use glam::{DMat3, DVec3};
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
    let mut errors = Errors { arcs: 0.0, angles: [0.0; 2], edges: [0.0; 2], along: DMat3::ZERO };
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
    /// Without the errors along the normals.
    edges: [f64; 2],
    /// M.
    along: DMat3,
}

impl Errors {
    fn add(&mut self, sure: &SureArc, facing: f64, cosines: impl FnOnce() -> f64) {
        let SureArc { arc, spreads: [first, last], slips, normal_error } = sure;
        let (g, spread, slip) = (arc.angle.abs(), first + last, slips[0] + slips[1]);
        let least = g.min(1.0);
        let of_ends = slip + 1.2 * U;
        let error = of_ends + least * (11.5 * U) + g * (units::ARC_TANGENT * U);
        let of_angle = AngleError {
            g,
            dg: error,
            ds: of_ends + least * (18.5 * U),
            ew: arc.line().map_or(0.0, Line::relative_error),
            eta: Some(first.max(*last)),
        };
        self.arcs += 1.0;
        self.angles[0] += g;
        self.angles[1] +=
            if g + SECOND_ORDER * of_angle.dg < std::f64::consts::PI { of_angle.of_term(facing) } else { f64::INFINITY };
        let Some(line) = arc.line() else { return };
        let (size, error) = if arc.is_within_a_quarter_turn() {
            of_weight(arc, line, &of_angle, [spread, slip], *normal_error, cosines())
        } else {
            of_angle.of_wide_weight(line.nearness())
        };
        self.edges[0] += size;
        self.edges[1] += size * (of_angle.ew + 5.0 * U);
        let normal = DVec3::from(line.normal);
        self.along += DMat3::from_cols(normal * normal.x, normal * normal.y, normal * normal.z) * error;
    }

    /// Errors of both sums.
    fn totals(&self) -> [f64; 2] {
        let sums = (self.arcs - 1.0).max(0.0) * U;
        let [angles, edges] = [self.angles, self.edges].map(|[sizes, errors]| errors + sums * sizes);
        [angles, edges + together(&self.along)]
    }
}

/// A bound on the norm of a sum of errors along normals, from M.
fn together(along: &DMat3) -> f64 {
    let diagonal = along.diagonal();
    let trace = diagonal.x + diagonal.y + diagonal.z;
    if !trace.is_normal() {
        return trace;
    }
    let shares = *along * trace.recip();
    let square = shares * shares;
    let largest = [square.x_axis, square.y_axis, square.z_axis].iter().map(|c| c.length_squared()).sum::<f64>().sqrt().sqrt();
    trace * largest.sqrt()
}

/// A bound on the size of the weight up to a quarter turn, and its error.
fn of_weight(
    arc: &Arc<f64>,
    line: &Line<f64>,
    of_angle: &AngleError<f64>,
    [spread, slip]: [f64; 2],
    en: f64,
    cosines: f64,
) -> (f64, f64) {
    let AngleError { g, dg, ds, .. } = *of_angle;
    let toward = line.frame().toward;
    let aside = arc.start.cosine(toward).abs() + arc.end.cosine(toward).abs();
    let (sum, turn) = arc.angle_and_sine();
    let (quarter, chi) = (0.25 * turn, 0.25 * turn * sum);
    let (da, dc) = (slip + 4.0 * en + 72.0 * U, spread + 20.0 * U);
    let of_chi = quarter * (dg + ds) + chi * (slip + 18.0 * U);
    let first = of_chi * aside * cosines + chi * (da * cosines + aside * dc);
    let second = SLOPE_OF_PSI * dg * g * g + LARGEST_PSI * g * (g * (da + dc) + 6.0 * U * g * g);
    let size = chi * aside * cosines + LARGEST_PSI * g * g * g;
    let nearness = line.nearness();
    (size * nearness, (first + second + 3.0 * U * size) * nearness)
}
