//! The contribution of a segment of the boundary to `X1 = int dA/r^2`; [`crate::forms::linear`] has the derivation.

use radgrad_numbers::arithmetic::Arithmetic;
use radgrad_numbers::radius::Radius;
use radgrad_numbers::real::{RadiusOf, Real};
use radgrad_numbers::vec3::Vec3;

use crate::boundary::arc::{Arc, Generator};
use crate::boundary::line::{Frame, Sighted};

/// The frame of the segment of the emitter's plane that the arc sees, from that plane's normal and the height of x over it. The
/// horizon and an occluder's edge meet the plane along `n2 x N`.
pub(crate) fn segment_frame<T: Real>(arc: &Arc<T>, n2: Vec3<T>, height: T) -> Frame<T> {
    if let Generator::Emitter(line) = &arc.generator {
        return line.frame();
    }
    met_frame(arc.generator.normal(), n2, height)
}

/// The same of a plane with that normal.
#[inline(always)]
pub(crate) fn met_frame<T: Arithmetic>(normal: Vec3<T>, n2: Vec3<T>, height: T) -> Frame<T> {
    let meet = n2.cross(normal);
    let sine = meet.norm_squared().sqrt();
    let along = meet * (height.like(1.0) / sine);
    Frame { toward: along.cross(normal), along, normal, distance: height / sine }
}

/// `ln(r/h)` of the ends of an arc.
#[inline]
pub(crate) fn logarithms<T: Real>(arc: &Arc<T>, height: T) -> [T; 2] {
    let square = height * height;
    let log_distance = |end: &Sighted<T>| (end.square / square).ln() * T::exact(0.5);
    [log_distance(&arc.start), log_distance(&arc.end)]
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
    let ends = [
        x1_end(arc.start.point.dot(frame.along), distances, height, logarithms[0]),
        x1_end(arc.end.point.dot(frame.along), distances, height, logarithms[1]),
    ];
    x1_between(ends, signed).0
}

/// Term and quotient of an end. Always inlined: the two have much in common.
#[inline(always)]
fn x1_end<T: Real>(s: T, distances: [T; 3], height: T, logarithm: T) -> [T; 3] {
    match without_direction(s.abs(), distances[0], height) {
        Some(end) => end.on_side_of(s),
        None => X1End::new(s.abs(), distances, logarithm).on_side_of(s),
    }
}

fn lowest<T: Real>(height: T) -> RadiusOf<T> {
    (height.size() - height.error()).max(0.0.into())
}

/// Where d and s are both about 0 phi is not known, but the integral from 0 to it is at most `pi/4 (d^2 + s^2)/h^2`.
fn without_direction<T: Real>(s: T, d: T, height: T) -> Option<X1End<T>> {
    let (zero, one, moved) = (T::exact(0.0), T::exact(1.0), s.error() + d.error());
    ((d * d + s * s).size() <= moved * moved * 16.0).then(|| {
        let radius = (s.size() + d.size() + moved) / lowest(height);
        X1End { term: zero.widened(radius * radius), above: one, below: one, phi: zero, psi: zero, is_obtuse: false }
    })
}

/// The contribution of a segment's end to X1: a term, and `pi/4` times the logarithm of a quotient.
pub(crate) struct X1End<T: Arithmetic> {
    term: T,
    above: T,
    below: T,
    pub(crate) phi: T,
    pub(crate) psi: T,
    /// Whether `phi + psi` is past a right angle.
    pub(crate) is_obtuse: T::Mask,
}

impl<T: Arithmetic> X1End<T> {
    /// At `s >= 0` along a segment at the in-plane distance d and the distance S, given them and their sum.
    #[inline(always)]
    pub(crate) fn new(s: T, distances: [T; 3], logarithm: T) -> Self {
        Self::at_angle(s, s.atan2_right(distances[1]), distances, logarithm)
    }

    /// The same, given the angle psi too.
    #[inline(always)]
    pub(crate) fn at_angle(s: T, psi: T, [d, distance, reach]: [T; 3], logarithm: T) -> Self {
        let phi = s.atan2_right(d);
        let (sum, square, pi) = (phi + psi, s * s, s.like_pi());
        let is_obtuse = square.exceeds(d * distance);
        let plain = phi * logarithm + (phi.clausen_rest() * s.like(2.0) - (phi - psi).clausen_rest());
        let last = T::choose(is_obtuse, pi - sum, sum).clausen_rest();
        let one = s.like(1.0);
        Self {
            term: plain + T::choose(is_obtuse, last - pi * s.like(0.5), -last),
            above: T::choose_of(
                is_obtuse,
                #[inline(always)]
                || square * (reach * reach) * s.like(4.0),
                #[inline(always)]
                || one,
            ),
            below: T::choose_of(
                is_obtuse,
                #[inline(always)]
                || (d * d + square) * (distance * distance + square),
                #[inline(always)]
                || one,
            ),
            phi,
            psi,
            is_obtuse,
        }
    }

    /// Term and quotient of the end at s, given those at its magnitude.
    #[inline(always)]
    pub(crate) fn on_side_of(&self, s: T) -> [T; 3] {
        let Self { term, above, below, .. } = *self;
        let back = s.like(0.0).exceeds(s);
        [T::choose(back, -term, term), T::choose(back, below, above), T::choose(back, above, below)]
    }
}

/// X1 between two ends of a segment whose in-plane distance has the sign given, and the logarithm of the quotient.
#[inline(always)]
pub(crate) fn x1_between<T: Arithmetic>([start, end]: [[T; 3]; 2], signed: T) -> (T, T) {
    let quotient = ((end[1] * start[2]) / (end[2] * start[1])).ln();
    let term = (end[0] - start[0]) + quotient * (signed.like_pi() * signed.like(0.25));
    (T::choose(signed.like(0.0).exceeds(signed), -term, term), quotient)
}
