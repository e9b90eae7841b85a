//! What a segment of the boundary adds to `X1 = int dA/r^2`; [`crate::forms::linear`] has the derivation.

use crate::boundary::arc::{Arc, Generator};
use crate::boundary::line::{Frame, Sighted};
use crate::scalar::radius::Radius;
use crate::scalar::real::{RadiusOf, Real};
use crate::scalar::vec3::Vec3;

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

/// `ln(r/h)` of the ends of an arc.
#[inline]
pub(crate) fn logarithms<T: Real>(arc: &Arc<T>, height: T) -> [T; 2] {
    let square = height * height;
    [&arc.start, &arc.end].map(|end| (end.square / square).ln() * T::exact(0.5))
}

/// The segment's part of X1, given the [`logarithms`] of its ends.
///
/// It is `sgn(d) int 1/2 ln(1 + d^2/(h cos phi)^2) dphi` over part of (-pi/2, pi/2), so at most `pi asinh(|d|/h) <= pi |d|/h`:
/// that encloses it where the sign of d is not known.
pub(crate) fn x1_term<T: Real>(arc: &Arc<T>, frame: &Frame<T>, kappa: T, height: T, logarithms: [T; 2]) -> T {
    let signed = frame.distance * kappa;
    if signed.size() <= signed.error() {
        return T::exact(0.0).widened(signed.error() * (2.0 * 1.01 * std::f64::consts::PI) / lowest(height));
    }
    let d = signed.abs();
    let distances = [d, frame.distance, frame.distance + d];
    let at = |end: &Sighted<T>, logarithm: T| {
        let s = end.point.dot(frame.along);
        X1End::new(s.abs(), distances, logarithm, height).on_side_of(s)
    };
    let (start, end) = (at(&arc.start, logarithms[0]), at(&arc.end, logarithms[1]));
    let beyond = (end.above * start.below) / (end.below * start.above);
    let term = (end.term - start.term) + beyond.ln() * (T::pi() * T::exact(0.25));
    if signed.value() < 0.0 { -term } else { term }
}

fn lowest<T: Real>(height: T) -> RadiusOf<T> {
    (height.size() - height.error()).max(0.0.into())
}

/// What an end of a segment adds to X1: a term, and `pi/4` times the logarithm of a quotient.
struct X1End<T> {
    term: T,
    above: T,
    below: T,
}

impl<T: Real> X1End<T> {
    /// At `s >= 0` along a segment at the in-plane distance d and the distance S, given them and their sum.
    ///
    /// Where d and s are both about 0 phi is not known, but the integral from 0 to it is at most `pi/4 (d^2 + s^2)/h^2`.
    #[inline]
    fn new(s: T, [d, distance, reach]: [T; 3], logarithm: T, height: T) -> Self {
        let (one, foot_square) = (T::exact(1.0), d * d + s * s);
        let moved = s.error() + d.error();
        if foot_square.size() <= moved * moved * 16.0 {
            let most = (s.size() + d.size() + moved) / lowest(height);
            return Self { term: T::exact(0.0).widened(most * most), above: one, below: one };
        }
        let (phi, psi) = (s.atan2(d), s.atan2(distance));
        let sum = phi + psi;
        let plain = phi * logarithm + (phi.clausen_rest() * T::exact(2.0) - (phi - psi).clausen_rest());
        let square = s * s;
        if square.value() <= (d * distance).value() {
            return Self { term: plain - sum.clausen_rest(), above: one, below: one };
        }
        let beyond = (T::pi() - sum).clausen_rest() - T::pi() * T::exact(0.5);
        Self {
            term: plain + beyond,
            above: square * (reach * reach) * T::exact(4.0),
            below: foot_square * (distance * distance + square),
        }
    }

    /// `self` is at the magnitude of s.
    #[inline]
    fn on_side_of(self, s: T) -> Self {
        if s.value() < 0.0 { Self { term: -self.term, above: self.below, below: self.above } } else { self }
    }
}
