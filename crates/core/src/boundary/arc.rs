//! The visible part of an emitter, as the arcs that bound it on the unit sphere around the receiver point.
//!
//! Each arc lies in the plane through x and a line, its GENERATING LINE: an edge of the emitter, an edge of an occluder (the
//! edge itself, not its shadow), or the receiver's horizon, which has no line. Seen from x the emitter's vertices run such that
//! the visible side of an arc from `u` to `v` is the one with `N . omega < 0`, `N = u x v / |u x v|`. All lengths are
//! normalised by [`crate::boundary::plan::Plan`].

mod quartic;
pub(crate) mod weight;

use radgrad_numbers::arithmetic::Arithmetic;
use radgrad_numbers::real::Real;
use radgrad_numbers::series::sine::half_angle_minus_sine;
use radgrad_numbers::vec3::Vec3;

use crate::boundary::line::{Frame, Line, Sighted};

/// The plane through the receiver in which an arc lies.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Generator<T> {
    /// The receiver's horizon, with the normal `N = -n1`.
    Horizon(Vec3<T>),
    /// An edge of the emitter.
    Emitter(Line<T>),
    /// An edge of an occluder.
    Occluder(Line<T>),
}

/// A piece of the visible boundary, from the direction of `start` to that of `end`, two points of the emitter's plane.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Arc<T> {
    pub(crate) start: Sighted<T>,
    pub(crate) end: Sighted<T>,
    /// Angle `g` from start to end, signed along the normal.
    pub(crate) angle: T,
    /// `|start| |end| sin g`.
    pub(crate) across: T,
    /// `|start| |end| cos g`.
    pub(crate) inline: T,
    pub(crate) generator: Generator<T>,
}

impl<T: Arithmetic> Generator<T> {
    /// Unit normal `N` of the plane through x.
    #[inline(always)]
    pub(crate) fn normal(&self) -> Vec3<T> {
        match self {
            Self::Horizon(normal) => *normal,
            Self::Emitter(line) | Self::Occluder(line) => line.normal,
        }
    }
}

impl<T: Real> Generator<T> {
    /// The same, run the other way.
    pub(crate) fn reversed(self) -> Self {
        match self {
            Self::Horizon(normal) => Self::Horizon(-normal),
            Self::Emitter(line) => Self::Emitter(line.reversed()),
            Self::Occluder(line) => Self::Occluder(line.reversed()),
        }
    }
}

impl<T> Arc<T> {
    /// The line that generates the arc; the horizon has none.
    #[inline]
    pub(crate) fn line(&self) -> Option<&Line<T>> {
        match &self.generator {
            Generator::Horizon(_) => None,
            Generator::Emitter(line) | Generator::Occluder(line) => Some(line),
        }
    }
}

impl<T: Arithmetic> Arc<T> {
    /// The arc between two points of a plane through x.
    #[inline(always)]
    pub(crate) fn between(start: Sighted<T>, end: Sighted<T>, generator: Generator<T>) -> Self {
        Self::new(start, end, generator.normal().dot(start.point.cross(end.point)), generator)
    }

    /// The part `fraction` long of the emitter's edge on `line`.
    #[inline(always)]
    pub(crate) fn of_edge(start: Sighted<T>, end: Sighted<T>, fraction: T, line: Line<T>) -> Self {
        Self::new(start, end, fraction * line.moment, Generator::Emitter(line))
    }

    #[inline(always)]
    fn new(start: Sighted<T>, end: Sighted<T>, across: T, generator: Generator<T>) -> Self {
        let inline = start.point.dot(end.point);
        Self { start, end, angle: across.atan2(inline), across, inline, generator }
    }

    /// The moments of the arc in a frame of its plane.
    ///
    /// `M = (g + sin g)/2 b b^T + (g - sin g)/2 t t^T` with b, t along the sum and the difference of the end directions
    /// (theory: HS95 A.1 without its I1 term, which cancels over a closed boundary). The longer of sum and difference gives
    /// both axes.
    #[inline(always)]
    pub(crate) fn moments(&self, frame: &Frame<T>) -> Moments<T> {
        let Ends { sin, cos, toward: [c1, c2], along: [s1, s2] } = self.ends(frame);
        let (wide, thin) = ((self.angle + sin) * sin.like(0.5), half_angle_minus_sine(self.angle, sin));
        // The two axes are perpendicular: the one along (c, s) has the moment `on`, the other one `off`.
        let obtuse = cos.like(0.0).exceeds(cos);
        let (c, s) = (c2 + T::choose(obtuse, -c1, c1), s2 + T::choose(obtuse, -s1, s1));
        let (on, off, cross) = (T::choose(obtuse, thin, wide), T::choose(obtuse, wide, thin), T::choose(obtuse, -sin, sin));
        let (cc, ss, one) = (c * c, s * s, sin.like(1.0));
        let scale = one / (sin.like(2.0) * (one + cos.abs()));
        Moments { cc: (on * cc + off * ss) * scale, cs: cross * c * s * scale, ss: (on * ss + off * cc) * scale }
    }

    #[inline(always)]
    fn ends(&self, frame: &Frame<T>) -> Ends<T> {
        let (start, end) = (&self.start, &self.end);
        Ends {
            sin: self.across * start.inverse * end.inverse,
            cos: self.inline * start.inverse * end.inverse,
            toward: [start.point.dot(frame.toward) * start.inverse, end.point.dot(frame.toward) * end.inverse],
            along: [start.point.dot(frame.along) * start.inverse, end.point.dot(frame.along) * end.inverse],
        }
    }
}

/// Sine and cosine of an arc's angle, and the directions of its two ends in a frame of its plane.
struct Ends<T> {
    sin: T,
    cos: T,
    toward: [T; 2],
    along: [T; 2],
}

/// Integrals over an arc of `cos^2`, `cos sin` and `sin^2` of the angle from the frame's `toward`.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Moments<T> {
    pub(crate) cc: T,
    pub(crate) cs: T,
    pub(crate) ss: T,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn series_and_difference_meet() {
        for g in [0.99999f64, 1.00001] {
            let direct = 0.5 * (g - libm::sin(g));
            let error = half_angle_minus_sine(g, libm::sin(g)) - direct;
            assert!(error.abs() < 1e-16, "{error:e}");
        }
        assert_eq!(half_angle_minus_sine(1e-100, 1e-100), 1e-300 / 12.0);
    }

    #[test]
    fn moments_of_wide_and_narrow_arcs_are_their_integrals() {
        let frame = Frame {
            toward: Vec3::new(1.0, 0.0, 0.0),
            along: Vec3::new(0.0, 1.0, 0.0),
            normal: Vec3::new(0.0, 0.0, 1.0),
            distance: 1.0,
        };
        let direction = |psi: f64| Sighted::new(Vec3::new(libm::cos(psi), libm::sin(psi), 0.0) * 3.0);
        for (from, to) in [(-1.5, 1.5), (-0.2, 0.1), (0.3, 1.2), (-1.1, 1.0), (1.0, 1.0 + 1e-9)] {
            let arc = Arc::between(direction(from), direction(to), Generator::Horizon(frame.normal));
            let m = arc.moments(&frame);
            let g: f64 = to - from;
            let wave = 0.5 * (libm::sin(2.0 * to) - libm::sin(2.0 * from));
            assert!((m.cc - 0.5 * (g + wave)).abs() < 4e-16, "{from} {to}");
            assert!((m.ss - 0.5 * (g - wave)).abs() < 4e-16, "{from} {to}");
            let cross = 0.5 * (libm::sin(to) * libm::sin(to) - libm::sin(from) * libm::sin(from));
            assert!((m.cs - cross).abs() < 4e-16, "{from} {to}");
        }
    }
}
