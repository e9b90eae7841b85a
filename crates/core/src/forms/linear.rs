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
//! `Cl2(2x) = 2x - 4 J(x) - 2x ln(2 sin x)` ([`radgrad_numbers::dilogarithm`]), and of the logarithms, with
//! `sin(phi +- psi) = s (S +- d)/(rho r)`, `rho^2 = d^2 + s^2` and `(S - d)(S + d) = h^2`, one is left, which both segments of a
//! vertex share:
//!
//! `phi ln(r/h) + 2 J(phi) - J(phi - psi) - J(phi + psi)`,
//!
//! the integral of `1/2 ln(r^2/h^2) dphi` by parts. Past a right angle, where `s^2 > d S`, `- J(phi + psi)` is
//! `J(pi - phi - psi) + pi/2 (ln(2 sin(phi + psi)) - 1)`.
//!
//! Loses digits where Phi does, and by a further factor |beta|/|B| ~ D/s far away.

use radgrad_numbers::arithmetic::Arithmetic;
use radgrad_numbers::offset::offset;
use radgrad_numbers::radius::Radius;
use radgrad_numbers::real::Real;
use radgrad_numbers::vec3::Vec3;

use crate::boundary::arc::{Arc, Generator, Moments};
use crate::boundary::line::{Frame, Sighted};
use crate::boundary::plan::height_over_plane;
use crate::forms::irradiance_and_gradient::IrradianceAndGradient;
use crate::forms::segment::{logarithms, segment_frame, x1_term};
use crate::problem::emission::Emitter;
use crate::problem::receiver::{Receiver, unit_normal};

/// An affine emission seen from x, in normalised lengths.
#[derive(Debug, Clone, Copy)]
pub(crate) struct SeenLinear<T> {
    pub(in crate::forms) n1: Vec3<T>,
    pub(in crate::forms) n2: Vec3<T>,
    /// Height of x over the plane.
    pub(in crate::forms) height: T,
    /// The affine function continued to x.
    pub(in crate::forms) beta: T,
    pub(in crate::forms) gradient: Vec3<T>,
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

/// The contribution of an arc to the contour term: `flux nu`.
#[derive(Debug, Clone, Copy)]
pub(crate) struct ContourTerm<T> {
    pub(crate) kappa: T,
    /// `nu`.
    pub(crate) outward: Vec3<T>,
    /// gB along nu and along the segment.
    pub(crate) slope_outward: T,
    pub(crate) slope_along: T,
    pub(crate) flux: T,
}

/// n1 and gB along the first two axes of a frame, and the sum of the two mixed products.
struct InFrame<T> {
    p1: T,
    p2: T,
    g1: T,
    g2: T,
    mixed: T,
}

impl<T: Arithmetic> SeenLinear<T> {
    /// Given `ln(r/h)` at the ends.
    #[inline(always)]
    pub(super) fn contour(&self, arc: &Arc<T>, frame: &Frame<T>, [start, end]: [T; 2]) -> ContourTerm<T> {
        let kappa = self.n2.dot(frame.normal);
        let outward = frame.along.cross(self.n2);
        let (slope_outward, slope_along) = (self.gradient.dot(outward), self.gradient.dot(frame.along));
        let flux = kappa * arc.angle * slope_outward + (end - start) * slope_along;
        ContourTerm { kappa, outward, slope_outward, slope_along, flux }
    }

    /// The emission at a point over its distance.
    #[inline(always)]
    pub(super) fn emission(&self, point: &Sighted<T>) -> T {
        (self.beta + self.gradient.dot(point.point)) * point.inverse
    }

    /// n1 along the direction of a point.
    #[inline(always)]
    pub(super) fn cosine(&self, point: &Sighted<T>) -> T {
        self.n1.dot(point.point) * point.inverse
    }

    #[inline(always)]
    fn in_frame(&self, frame: &Frame<T>) -> InFrame<T> {
        let (p1, p2) = (self.n1.dot(frame.toward), self.n1.dot(frame.along));
        let (g1, g2) = (self.gradient.dot(frame.toward), self.gradient.dot(frame.along));
        InFrame { p1, p2, g1, g2, mixed: g1 * p2 + g2 * p1 }
    }

    /// `toward . V` in the frame of a segment with these moments.
    #[inline(always)]
    pub(super) fn toward(&self, frame: &Frame<T>, m: &Moments<T>) -> T {
        let InFrame { p1, p2, g1, g2, mixed } = self.in_frame(frame);
        self.beta * (m.cc * p1 + m.cs * p2) + frame.distance * (g1 * p1 * m.cc + mixed * m.cs + g2 * p2 * m.ss)
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
        let ContourTerm { kappa, outward, flux, .. } = self.seen.contour(arc, frame, logarithms);
        self.angles = self.angles + frame.normal * arc.angle;
        self.contour = self.contour + outward * flux;
        self.x1 = self.x1 + x1_term(arc, frame, kappa, self.seen.height, logarithms);
    }

    /// `toward . V / S` on the generating line.
    fn weight(&self, arc: &Arc<T>, frame: &Frame<T>, logarithms: [T; 2]) -> T {
        let case = &self.seen;
        let generating = match &arc.generator {
            Generator::Horizon(_) => return T::exact(0.0),
            Generator::Emitter(_) if arc.is_within_a_quarter_turn() => {
                let (start, end) = (&arc.start, &arc.end);
                let emission = [case.emission(start), case.emission(end)];
                return arc.within_a_quarter_turn(emission, [case.cosine(start), case.cosine(end)]);
            }
            Generator::Emitter(_) => return case.toward(frame, &arc.moments(frame)) / frame.distance,
            Generator::Occluder(line) => line.frame(),
        };
        let m = arc.moments(frame);
        let InFrame { p1, p2, g1, g2, mixed } = case.in_frame(frame);
        let tangent = (logarithms[1] - logarithms[0]) - m.cs;
        let along = case.beta * (m.cs * p1 + m.ss * p2) + frame.distance * (g1 * p1 * m.cs + mixed * m.ss + g2 * p2 * tangent);
        let toward = case.toward(frame, &m);
        let weight = generating.toward.dot(frame.toward) * toward + generating.toward.dot(frame.along) * along;
        weight / generating.distance
    }

    #[inline]
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
