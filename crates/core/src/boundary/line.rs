//! A line of the scene as the receiver at the origin sees it: an edge of the emitter or of an occluder, with the plane through
//! the receiver and the line. All lengths are normalised by [`crate::boundary::plan::Plan`].

use glam::DVec3;
use radgrad_numbers::arithmetic::Arithmetic;
use radgrad_numbers::double_double::{DoubleDouble, ROUNDOFF_OF_DOUBLE_DOUBLE};
use radgrad_numbers::number::{Number, ROUNDOFF};
use radgrad_numbers::offset::{exact_offset, offset};
use radgrad_numbers::real::Real;
use radgrad_numbers::vec3::Vec3;

/// Errors of w in units of roundoff: of `|r||e|`, and of itself.
pub const MOMENT_UNITS: [f64; 2] = [3.5, 1.0];

/// Moments below which no bound is derived: their squares would underflow.
pub(crate) const LEAST_MOMENT: f64 = 1e-100;

/// A point, as seen from the receiver.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Sighted<T> {
    pub(crate) point: Vec3<T>,
    /// `|point|^2`.
    pub(crate) square: T,
    /// `1/|point|`.
    pub(crate) inverse: T,
}

/// A line with direction `e` and moment `w = a x e`, a any point of it.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Line<T> {
    pub(crate) e: Vec3<T>,
    /// `|e|`.
    pub(crate) length: T,
    /// `|w|`.
    pub(crate) moment: T,
    /// `w/|w|`.
    pub(crate) normal: Vec3<T>,
    inverse_moment: T,
    /// `|r|^2` of the point r that w was taken at: how far w may have cancelled.
    pub(crate) reach: T,
    /// Whether w was taken in double-double.
    is_precise: bool,
}

/// Orthonormal frame of the plane through x and a line: `toward` from x to the nearest point of the line, at `distance`;
/// `along` the line; `normal` the product of the two.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Frame<T> {
    pub(crate) toward: Vec3<T>,
    pub(crate) along: Vec3<T>,
    pub(crate) normal: Vec3<T>,
    pub(crate) distance: T,
}

impl<T: Arithmetic> Sighted<T> {
    #[inline(always)]
    pub(crate) fn new(point: Vec3<T>) -> Self {
        let square = point.norm_squared();
        Self { point, square, inverse: square.like(1.0) / square.sqrt() }
    }
}

impl<T: Arithmetic> Sighted<T> {
    /// `n.r/r` of its offset r.
    #[inline(always)]
    pub(crate) fn cosine(&self, n: Vec3<T>) -> T {
        n.dot(self.point) * self.inverse
    }
}

impl<T: Real> Sighted<T> {
    /// A point of the scene seen from `x`.
    #[inline]
    pub(crate) fn from(point: DVec3, x: DVec3, power: f64) -> Self {
        Self::new(offset(point, x, power))
    }
}

impl<T: Real> Line<T> {
    /// The line of the edge from `from` to `to`, seen from `x` as `ends`.
    ///
    /// Always inlined: a tenth of the plain closed form is the call.
    #[inline(always)]
    pub(crate) fn through(edge: [DVec3; 2], ends: [&Sighted<T>; 2], x: DVec3, power: f64) -> Self {
        let e: Vec3<T> = offset(edge[1], edge[0], power);
        let (w, square, reach) = (ends[0].point.cross(e), e.norm_squared(), ends[0].square);
        if 16.0 * w.norm_squared().value() >= reach.value() * square.value() {
            return Self::new(e, square, w, reach);
        }
        Self::passing_near(edge, ends, e, x, power)
    }

    /// Near the line's extension `w` cancels: taken at the nearer end it does less, and below an eighth of `|r| |e|` it is taken
    /// in double-double, so that its relative error stays at a few roundings down to 1e-14 of the distance.
    #[cold]
    fn passing_near([from, to]: [DVec3; 2], ends: [&Sighted<T>; 2], e: Vec3<T>, x: DVec3, power: f64) -> Self {
        let (vertex, near) = if ends[0].square.value() <= ends[1].square.value() { (from, ends[0]) } else { (to, ends[1]) };
        let (w, square, reach) = (near.point.cross(e), e.norm_squared(), near.square);
        let squares = reach.value() * square.value();
        if T::Number::BEYOND_DOUBLE_DOUBLE || 64.0 * w.norm_squared().value() >= squares {
            return Self::new(e, square, w, reach);
        }
        let exact = exact_offset(vertex, x, power).cross(exact_offset(to, from, power));
        let error = 4.0 * ROUNDOFF_OF_DOUBLE_DOUBLE * squares.sqrt();
        let w = exact.map(|c: DoubleDouble| T::from_double_double(c, error));
        Self { is_precise: true, ..Self::new(e, square, w, reach) }
    }

    /// The line through `point` along `e`.
    pub(crate) fn along(e: Vec3<T>, point: Vec3<T>) -> Self {
        Self::new(e, e.norm_squared(), point.cross(e), point.norm_squared())
    }

    /// Bound on the relative error of `w` where the scalar is a plain double.
    ///
    /// A component is a difference of two products of factors rounded once: it errs by 3u of the sum of their sizes and u of
    /// itself. The vector of those sums is at most `(4/3)^(1/2) |r| |e|` long, its square being that of the cross product of the
    /// vectors of sizes a, b and `4 sum_(i<j) a_i b_i a_j b_j <= (4/3) (a.b)^2`. Where w was taken in double-double it errs by
    /// its rounding and 4 units.
    #[inline]
    pub(crate) fn relative_error(&self) -> f64 {
        let ratio = self.reach.value().sqrt() * self.nearness().value();
        if self.is_precise {
            2.0 * ROUNDOFF + 4.0 * ROUNDOFF_OF_DOUBLE_DOUBLE * ratio
        } else {
            (MOMENT_UNITS[0] * ratio + MOMENT_UNITS[1]) * ROUNDOFF
        }
    }

    /// The same line, run the other way.
    pub(crate) fn reversed(self) -> Self {
        Self { e: -self.e, normal: -self.normal, ..self }
    }
}

impl<T: Arithmetic> Line<T> {
    /// The line with direction e, given its square, w, and `|r|^2` of the point where w was taken.
    #[inline(always)]
    pub(crate) fn new(e: Vec3<T>, square: T, w: Vec3<T>, reach: T) -> Self {
        let moment = w.norm_squared().sqrt();
        let inverse_moment = moment.like(1.0) / moment;
        Self { e, length: square.sqrt(), moment, normal: w * inverse_moment, inverse_moment, reach, is_precise: false }
    }

    /// One over the distance from x.
    #[inline(always)]
    pub(crate) fn nearness(&self) -> T {
        self.length * self.inverse_moment
    }

    #[inline(always)]
    pub(crate) fn frame(&self) -> Frame<T> {
        let inverse = self.length.like(1.0) / self.length;
        let along = self.e * inverse;
        Frame { toward: along.cross(self.normal), along, normal: self.normal, distance: self.moment / self.length }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_error_of_a_line_is_that_of_the_branch_it_took() {
        // Seen from the nearer end at an eighth of its distance, to a few roundings either way.
        let (mut precise, mut rounded) = (0, 0);
        for i in -40..40 {
            let slope = (1.0f64 / 63.0).sqrt() * (1.0 + f64::from(i) * ROUNDOFF);
            let ends = [DVec3::new(1.0, slope, 0.0), DVec3::new(2.0, slope, 0.0)];
            let [from, to] = ends.map(|end| Sighted::<f64>::from(end, DVec3::ZERO, 1.0));
            let line = Line::<f64>::through(ends, [&from, &to], DVec3::ZERO, 1.0);
            let expected = if line.is_precise { 3.0 * ROUNDOFF } else { (3.5 * 7.99 + 1.0) * ROUNDOFF };
            assert!(if line.is_precise { line.relative_error() < expected } else { line.relative_error() > expected });
            *(if line.is_precise { &mut precise } else { &mut rounded }) += 1;
        }
        assert!(precise > 0 && rounded > 0, "{precise} {rounded}");
    }

    #[test]
    fn a_line_almost_through_the_receiver_keeps_its_moment() {
        let ends = [DVec3::new(1.0, 3.0, 0.5), DVec3::new(2.0, 6.0, 1.0)];
        let x = DVec3::new(1e-12, 0.0, 0.0);
        let [from, to] = ends.map(|end| Sighted::from(end, x, 1.0));
        let line = Line::<f64>::through(ends, [&from, &to], x, 1.0);
        let expected = 1e-12 * (3.0f64 * 3.0 + 0.5 * 0.5).sqrt();
        assert!((line.moment - expected).abs() < 4.0 * ROUNDOFF * expected);
    }
}
