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
//!   g2 tan psi)`.
//!
//! `X1 = int dA/r^2` is the one quantity that is not elementary. Its dilogarithm form is a sum over the segments, d the signed
//! in-plane distance of x's foot point, s the coordinate along, `phi = atan2(s, |d|)` and `q = exp(-2 asinh(|d|/h))`: `sgn(d) {
//! (phi2 - phi1) asinh(|d|/h) - 1/2 [Im Li2(-q e^(2 i phi)) - Cl2(2 phi + pi)] }`. With `Im Li2(r e^(it)) = om ln r + 1/2
//! [Cl2(2 om) + Cl2(2t) - Cl2(2 om + 2t)]` (Lewin 1981, 5.5), the duplication formula, and the angle psi of the arc in its own
//! plane, `delta = phi - psi`, it becomes `sgn(d) { g asinh(|d|/h) - 1/4 [2 Cl2(2 phi) - Cl2(2 delta) - Cl2(4 phi - 2 delta)]
//! }`, free of the cancelling logarithm of q.
//!
//! Loses digits where Phi does, and by a further factor |beta|/|B| ~ D/s far away.

mod side_by_side;

use crate::arc::{Arc, Generator};
use crate::line::Frame;
use crate::plan::{height_over_plane, offset, unit_normal};
use crate::radius::Radius;
use crate::real::Real;
use crate::terms::Terms;
use crate::vec3::Vec3;
use crate::{Emitter, Receiver};

pub(crate) use side_by_side::whole;

/// An affine emission seen from x, in normalised lengths.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Seen<T> {
    n1: Vec3<T>,
    n2: Vec3<T>,
    /// Height of x over the plane.
    height: T,
    /// The affine function continued to x.
    beta: T,
    gradient: Vec3<T>,
}

impl<T: Real> Seen<T> {
    /// Vertices off the plane by the polygon's defect change height and emission by that much, and vertex values off the affine
    /// function by its residual: both go into the bounds.
    pub(crate) fn new(receiver: &Receiver, emitter: &Emitter, power: f64) -> Self {
        Self::from(receiver, emitter, power, height_over_plane(receiver.position(), emitter.polygon(), power))
    }

    /// The same from a height that takes the polygon for flat.
    #[inline]
    fn from(receiver: &Receiver, emitter: &Emitter, power: f64, height: T) -> Self {
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
    seen: Seen<T>,
    /// `sum g N`.
    angles: Vec3<T>,
    x1: T,
    /// `contour r_t (x) nu / r^2` applied to gB.
    contour: Vec3<T>,
    /// `sum e x V / |w|`.
    edges: Vec3<T>,
}

impl<T: Real> LinearSum<T> {
    pub(crate) fn new(seen: Seen<T>) -> Self {
        Self { seen, angles: Vec3::zero(), x1: T::exact(0.0), contour: Vec3::zero(), edges: Vec3::zero() }
    }

    /// Adds the arc's terms of the value, and those of the gradient where it is wanted.
    pub(crate) fn add<const GRADIENT: bool>(&mut self, arc: &Arc<T>) {
        let frame = segment_frame(arc, self.seen.n2, self.seen.height);
        let log_ratio = self.add_irradiance(arc, &frame);
        if GRADIENT {
            self.add_edge(arc, &frame, log_ratio);
        }
    }

    /// Returns `ln(|v|/|u|)`.
    fn add_irradiance(&mut self, arc: &Arc<T>, frame: &Frame<T>) -> T {
        let Seen { n2, height, gradient, .. } = self.seen;
        let log_ratio = (arc.end.square / arc.start.square).ln() * T::exact(0.5);
        let kappa = n2.dot(frame.normal);
        let outward = frame.along.cross(n2);
        let flux = kappa * arc.angle * gradient.dot(outward) + log_ratio * gradient.dot(frame.along);
        self.angles = self.angles + frame.normal * arc.angle;
        self.contour = self.contour + outward * flux;
        self.x1 = self.x1 + x1_term(arc, frame, kappa, height);
        log_ratio
    }

    fn add_edge(&mut self, arc: &Arc<T>, frame: &Frame<T>, log_ratio: T) {
        let Seen { n1, beta, gradient, .. } = self.seen;
        let generating = match &arc.generator {
            Generator::Horizon(_) => return,
            Generator::Emitter(_) => None,
            Generator::Occluder(line) => Some(line.frame()),
        };
        let m = arc.moments(frame);
        let (p1, p2) = (n1.dot(frame.toward), n1.dot(frame.along));
        let (g1, g2) = (gradient.dot(frame.toward), gradient.dot(frame.along));
        let mixed = g1 * p2 + g2 * p1;
        let toward = beta * (m.cc * p1 + m.cs * p2) + frame.distance * (g1 * p1 * m.cc + mixed * m.cs + g2 * p2 * m.ss);
        let (seen, distance) = match generating {
            None => (toward, frame.distance),
            Some(line) => {
                let tangent = log_ratio - m.cs;
                let along = beta * (m.cs * p1 + m.ss * p2) + frame.distance * (g1 * p1 * m.cs + mixed * m.ss + g2 * p2 * tangent);
                let seen = line.toward.dot(frame.toward) * toward + line.toward.dot(frame.along) * along;
                (seen, line.distance)
            }
        };
        self.edges = self.edges - frame.normal * (seen / distance);
    }

    pub(crate) fn total(self) -> Terms<T> {
        let Seen { n1, n2, height, beta, gradient } = self.seen;
        let phi = self.angles * T::exact(-0.5);
        let q = (gradient * self.x1 - self.contour) * T::exact(0.5) - n2 * gradient.dot(phi);
        Terms { irradiance: phi * beta + q * height, gradient: gradient * phi.dot(n1) + n2 * q.dot(n1) + self.edges }
    }
}

/// The frame of the segment of the emitter's plane that the arc sees, from that plane's normal and the height of x over it. The
/// horizon and an occluder's edge meet the plane along `n2 x N`.
pub(crate) fn segment_frame<T: Real>(arc: &Arc<T>, n2: Vec3<T>, height: T) -> Frame<T> {
    if let Generator::Emitter(line) = &arc.generator {
        return line.frame();
    }
    let normal = arc.generator.normal();
    let meet = n2.cross(normal);
    let sine = meet.norm_squared().sqrt();
    let along = meet * (T::exact(1.0) / sine);
    Frame { toward: along.cross(normal), along, normal, distance: height / sine }
}

/// The segment's part of X1.
///
/// It is `sgn(d) int 1/2 ln(1 + d^2/(h cos phi)^2) dphi` over part of (-pi/2, pi/2), so at most `pi asinh(|d|/h) <= pi |d|/h`:
/// that encloses it where the sign of d is not known, as for a receiver straight below the line, when phi may not be known
/// either.
pub(crate) fn x1_term<T: Real>(arc: &Arc<T>, frame: &Frame<T>, kappa: T, height: T) -> T {
    let signed = frame.distance * kappa;
    if signed.size() <= signed.error() {
        let lowest = (height.size() - height.error()).max(0.0.into());
        return T::exact(0.0).widened(signed.error() * (2.0 * 1.01 * std::f64::consts::PI) / lowest);
    }
    let d = signed.abs();
    let reach = frame.distance + d;
    let clausens = |point: Vec3<T>| {
        let s = point.dot(frame.along);
        let phi = s.atan2(d);
        let delta = (s * height * height / reach).atan2(frame.distance * d + s * s);
        let (two, four) = (T::exact(2.0), T::exact(4.0));
        (phi * two).clausen() * two - (delta * two).clausen() - (phi * four - delta * two).clausen()
    };
    let term = arc.angle * (reach / height).ln() - (clausens(arc.end.point) - clausens(arc.start.point)) * T::exact(0.25);
    if signed.value() < 0.0 { -term } else { term }
}
