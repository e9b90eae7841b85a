//! Linear emission `B(y) = beta + gB.(y - x)`, with horizon and occluders, in closed form; beyond HS95 A.2, which left X1 and
//! X2 to quadrature.
//!
//! With `c = -n2.omega` a point seen along omega is `y - x = omega h/c`, h the height of x over the emitter's plane. Then
//! - irradiance vector `E = int B omega domega = beta Phi + h q`, `q = int omega (gB.omega)/c domega = T gB - n2 (gB.Phi)`;
//! - `T = int r_t r_t^T / r^4 dA = 1/2 (X1 Id - contour r_t (x) nu / r^2 ds)`, in-plane; on a segment of the boundary at
//!   distance S from x, with `kappa = n2.N` and outward normal `nu = along x n2`, the contour term applied to gB is `[kappa g
//!   (gB.nu) + ln(|v|/|u|) (gB.along)] nu`;
//! - radiosity `(rho/pi) n1.E`; gradient `(rho/pi) { gB (Phi.n1) + n2 (q.n1) + sum e x V / |w| }` over emitter and occluder
//!   arcs, where `V = int_arc B (n1.omega) omega ds` has elementary primitives in the frame of the segment: `B = beta + S (g1 +
//!   g2 tan psi)`. On an edge of the emitter `toward.omega B/S` is linear in omega, and `B/|r|` at the ends: the weight of
//!   [`Arc::within_a_quarter_turn`] with the emission there.
//!
//! `X1 = int dA/r^2` is the one quantity that is not elementary. Its dilogarithm form is a sum over the segments, d the signed
//! in-plane distance of x's foot point, s the coordinate along, `phi = atan2(s, |d|)` and `q = exp(-2 asinh(|d|/h))`: `sgn(d) {
//! (phi2 - phi1) asinh(|d|/h) - 1/2 [Im Li2(-q e^(2 i phi)) - Cl2(2 phi + pi)] }`. With `Im Li2(r e^(it)) = om ln r + 1/2
//! [Cl2(2 om) + Cl2(2t) - Cl2(2 om + 2t)]` (Lewin 1981, 5.5), the duplication formula, and the angle `psi = atan2(s, S)` of the
//! arc in its own plane, an end adds `psi asinh(|d|/h) - 1/4 [2 Cl2(2 phi) - Cl2(2 phi - 2 psi) - Cl2(2 phi + 2 psi)]`. Now
//! `Cl2(2x) = 2x - 4 J(x) - 2x ln(2 sin x)` ([`crate::scalar::dilogarithm`]), and of the logarithms, with
//! `sin(phi +- psi) = s (S +- d)/(rho r)`, `rho^2 = d^2 + s^2` and `(S - d)(S + d) = h^2`, one is left, which both segments of a
//! vertex share:
//!
//! `phi ln(r/h) + 2 J(phi) - J(phi - psi) - J(phi + psi)`,
//!
//! the integral of `1/2 ln(r^2/h^2) dphi` by parts. Past a right angle, where `s^2 > d S`, `- J(phi + psi)` is
//! `J(pi - phi - psi) + pi/2 (ln(2 sin(phi + psi)) - 1)`.
//!
//! Loses digits where Phi does, and by a further factor |beta|/|B| ~ D/s far away.

use crate::boundary::arc::{Arc, Generator};
use crate::boundary::line::Frame;
use crate::boundary::plan::height_over_plane;
use crate::forms::irradiance_and_gradient::IrradianceAndGradient;
use crate::forms::segment::{logarithms, segment_frame, x1_term};
use crate::problem::emission::Emitter;
use crate::problem::receiver::{Receiver, unit_normal};
use crate::scalar::offset::offset;
use crate::scalar::radius::Radius;
use crate::scalar::real::Real;
use crate::scalar::vec3::Vec3;

/// An affine emission seen from x, in normalised lengths.
#[derive(Debug, Clone, Copy)]
pub(crate) struct SeenLinear<T> {
    pub(super) n1: Vec3<T>,
    pub(super) n2: Vec3<T>,
    /// Height of x over the plane.
    pub(super) height: T,
    /// The affine function continued to x.
    pub(super) beta: T,
    pub(super) gradient: Vec3<T>,
}

impl<T: Real> SeenLinear<T> {
    /// Vertices off the plane by the polygon's defect change height and emission by that much, and vertex values off the affine
    /// function by its residual: both go into the bounds.
    pub(crate) fn new(receiver: &Receiver, emitter: &Emitter, power: f64) -> Self {
        Self::from(receiver, emitter, power, height_over_plane(receiver.position(), emitter.polygon(), power))
    }

    /// The same from a height that takes the polygon for flat.
    #[inline]
    pub(super) fn from(receiver: &Receiver, emitter: &Emitter, power: f64, height: T) -> Self {
        let (x, polygon, emission) = (receiver.position(), emitter.polygon(), emitter.affine());
        let gradient = emitter.precise_gradient::<T>().map(|c| c.scaled(1.0 / power));
        let squared = gradient.norm_squared();
        let steepness = (squared.size() + squared.error()).sqrt();
        let defect = polygon.planarity_defect() * power;
        let beta = T::exact(emission.value) - gradient.dot(offset(polygon.vertices()[0], x, power));
        Self {
            n1: unit_normal(receiver),
            n2: polygon.unit_normal(),
            height: height.widened(defect.into()),
            beta: beta.widened(steepness * (2.0 * defect) + emission.residual.into()),
            gradient,
        }
    }
}

/// The sums over the arcs.
#[derive(Debug, Clone, Copy)]
pub(crate) struct LinearSum<T> {
    pub(super) seen: SeenLinear<T>,
    /// `sum g N`.
    pub(super) angles: Vec3<T>,
    pub(super) x1: T,
    /// `contour r_t (x) nu / r^2` applied to gB.
    pub(super) contour: Vec3<T>,
    /// `sum e x V / |w|`.
    pub(super) edges: Vec3<T>,
}

impl<T: Real> LinearSum<T> {
    pub(crate) fn new(seen: SeenLinear<T>) -> Self {
        Self { seen, angles: Vec3::zero(), x1: T::exact(0.0), contour: Vec3::zero(), edges: Vec3::zero() }
    }

    /// Adds the arc's terms of the value, and those of the gradient where it is wanted.
    pub(crate) fn add<const GRADIENT: bool>(&mut self, arc: &Arc<T>) {
        let frame = segment_frame(arc, self.seen.n2, self.seen.height);
        let logarithms = logarithms(arc, self.seen.height);
        self.add_irradiance(arc, &frame, logarithms);
        if GRADIENT {
            self.edges = self.edges - arc.generator.normal() * self.weight(arc, &frame, logarithms);
        }
    }

    fn add_irradiance(&mut self, arc: &Arc<T>, frame: &Frame<T>, logarithms: [T; 2]) {
        let SeenLinear { n2, height, gradient, .. } = self.seen;
        let kappa = n2.dot(frame.normal);
        let outward = frame.along.cross(n2);
        let flux = kappa * arc.angle * gradient.dot(outward) + (logarithms[1] - logarithms[0]) * gradient.dot(frame.along);
        self.angles = self.angles + frame.normal * arc.angle;
        self.contour = self.contour + outward * flux;
        self.x1 = self.x1 + x1_term(arc, frame, kappa, height, logarithms);
    }

    /// `toward . V / S` on the generating line.
    fn weight(&self, arc: &Arc<T>, frame: &Frame<T>, logarithms: [T; 2]) -> T {
        let SeenLinear { n1, beta, gradient, .. } = self.seen;
        let generating = match &arc.generator {
            Generator::Horizon(_) => return T::exact(0.0),
            Generator::Emitter(_) if arc.is_within_a_quarter_turn() => {
                let ends = [&arc.start, &arc.end];
                let emission = ends.map(|end| (beta + gradient.dot(end.point)) * end.inverse);
                return arc.within_a_quarter_turn(emission, ends.map(|end| n1.dot(end.point) * end.inverse));
            }
            Generator::Emitter(_) => None,
            Generator::Occluder(line) => Some(line.frame()),
        };
        let m = arc.moments(frame);
        let (p1, p2) = (n1.dot(frame.toward), n1.dot(frame.along));
        let (g1, g2) = (gradient.dot(frame.toward), gradient.dot(frame.along));
        let mixed = g1 * p2 + g2 * p1;
        let toward = beta * (m.cc * p1 + m.cs * p2) + frame.distance * (g1 * p1 * m.cc + mixed * m.cs + g2 * p2 * m.ss);
        match generating {
            None => toward / frame.distance,
            Some(line) => {
                let tangent = (logarithms[1] - logarithms[0]) - m.cs;
                let along = beta * (m.cs * p1 + m.ss * p2) + frame.distance * (g1 * p1 * m.cs + mixed * m.ss + g2 * p2 * tangent);
                let seen = line.toward.dot(frame.toward) * toward + line.toward.dot(frame.along) * along;
                seen / line.distance
            }
        }
    }

    pub(crate) fn total(self) -> IrradianceAndGradient<T> {
        let SeenLinear { n1, n2, height, beta, gradient } = self.seen;
        let (phi, q) = self.phi_and_q();
        IrradianceAndGradient {
            irradiance: phi * beta + q * height,
            gradient: gradient * phi.dot(n1) + n2 * q.dot(n1) + self.edges,
        }
    }

    #[inline]
    pub(super) fn phi_and_q(&self) -> (Vec3<T>, Vec3<T>) {
        let SeenLinear { n2, gradient, .. } = self.seen;
        let phi = self.angles * T::exact(-0.5);
        (phi, (gradient * self.x1 - self.contour) * T::exact(0.5) - n2 * gradient.dot(phi))
    }
}
