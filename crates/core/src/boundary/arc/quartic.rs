//! Fourth-order moments of an arc: with [`Moments`](crate::boundary::arc::Moments), all that the second derivatives need.

use radgrad_numbers::real::Real;
use radgrad_numbers::series::sine::half_angle_minus_sine;

use crate::boundary::arc::{Arc, Ends};
use crate::boundary::line::Frame;

/// Integrals over an arc of `cos^4`, `cos^3 sin` and `cos^2 sin^2` of the angle from the frame's `toward`.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Quartic<T> {
    pub(crate) cccc: T,
    pub(crate) cccs: T,
    pub(crate) ccss: T,
}

impl<T: Real> Arc<T> {
    /// Around its bisector the arc spans (-g/2, g/2), where odd powers of the sine vanish and `cos^2 sin^2 = (1 - cos 4t)/8`
    /// gives `m22 = (2g - sin 2g)/16`, `m40 = (g + sin g)/2 - m22`, `m04 = (g - sin g)/2 - m22`; the frame is turned from it by
    /// `atan2(s, c)`. As in [`Arc::moments`] the longer of sum and difference of the end directions gives the bisector.
    pub(crate) fn quartic_moments(&self, frame: &Frame<T>) -> Quartic<T> {
        let Ends { sin, cos, toward: [c1, c2], along: [s1, s2] } = self.ends(frame);
        let (half, two) = (T::exact(0.5), T::exact(2.0));
        let m22 = half_angle_minus_sine(self.angle * two, sin * cos * two) * T::exact(0.125);
        let m40 = (self.angle + sin) * half - m22;
        let m04 = half_angle_minus_sine(self.angle, sin) - m22;
        // The difference is a quarter turn ahead of the bisector.
        let (c, s) = if cos.value() >= 0.0 { (c1 + c2, s1 + s2) } else { (s2 - s1, c1 - c2) };
        let (cc, cs, ss) = (c * c, c * s, s * s);
        let scale = half / (T::exact(1.0) + cos.abs());
        let scale = scale * scale;
        let (six, three, four) = (T::exact(6.0), T::exact(3.0), T::exact(4.0));
        Quartic {
            cccc: (cc * cc * m40 + six * cc * ss * m22 + ss * ss * m04) * scale,
            cccs: cs * (cc * m40 - three * (cc - ss) * m22 - ss * m04) * scale,
            ccss: (cc * ss * (m40 + m04 - four * m22) + (cc * cc + ss * ss) * m22) * scale,
        }
    }
}

#[cfg(test)]
mod tests {
    use crate::boundary::arc::{Arc, Generator};
    use crate::boundary::line::{Frame, Sighted};
    use radgrad_numbers::vec3::Vec3;

    #[test]
    fn quartic_moments_are_their_integrals() {
        let frame = Frame {
            toward: Vec3::new(1.0, 0.0, 0.0),
            along: Vec3::new(0.0, 1.0, 0.0),
            normal: Vec3::new(0.0, 0.0, 1.0),
            distance: 1.0,
        };
        let direction = |psi: f64| Sighted::new(Vec3::new(libm::cos(psi), libm::sin(psi), 0.0) * 3.0);
        for (from, to) in [(-1.5, 1.5), (-0.2, 0.1), (0.3, 1.2), (-1.1, 1.0), (-1.4, 0.3), (-0.4, 1.5), (1.0, 1.0 + 1e-9)] {
            let q = Arc::between(direction(from), direction(to), Generator::Horizon(frame.normal)).quartic_moments(&frame);
            let g: f64 = to - from;
            let (twice, fourth) = (libm::sin(2.0 * to) - libm::sin(2.0 * from), libm::sin(4.0 * to) - libm::sin(4.0 * from));
            assert!((q.cccc - (3.0 * g / 8.0 + twice / 4.0 + fourth / 32.0)).abs() < 8e-16, "{from} {to}");
            assert!((q.ccss - (g / 8.0 - fourth / 32.0)).abs() < 8e-16, "{from} {to}");
            let fourth_power = |psi: f64| libm::cos(psi) * libm::cos(psi) * libm::cos(psi) * libm::cos(psi);
            assert!((q.cccs - 0.25 * (fourth_power(from) - fourth_power(to))).abs() < 8e-16, "{from} {to}");
        }
    }
}
