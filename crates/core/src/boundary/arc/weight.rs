//! What an arc weighs in the gradient of a constant emitter's radiosity.

use crate::boundary::arc::{Arc, Generator, sine_series};
use crate::boundary::line::Line;
use crate::scalar::number::Number;
use crate::scalar::real::Real;
use crate::scalar::vec3::Vec3;

impl<T: Real> Arc<T> {
    /// `toward . (M n1) / S` on the generating line `line`, at distance S; M is the arc's `int omega omega^T`.
    ///
    /// With u, v the directions of the ends, `M = chi (u + v)(u + v)^T + psi (v - u)(v - u)^T`, `chi = (g + sin g)/4(1 + cos g)`
    /// and `psi = (g - sin g)/4(1 - cos g)` (the axes of [`Arc::moments`], not normalised). An end of the generating line itself
    /// has `toward.u / S = 1/|r|`: neither S nor a frame is needed. Past a quarter turn u + v shrinks and its axis is taken from
    /// the frame.
    #[inline]
    pub(crate) fn weight(&self, line: &Line<T>, n1: Vec3<T>) -> T {
        if !self.is_within_a_quarter_turn() {
            return self.weight_in_frame(line, n1);
        }
        let ends = [&self.start, &self.end];
        let near = if let Generator::Emitter(_) = self.generator {
            ends.map(|end| end.inverse)
        } else {
            let toward = line.frame().toward * line.nearness();
            ends.map(|end| end.point.dot(toward) * end.inverse)
        };
        self.within_a_quarter_turn(near, ends.map(|end| n1.dot(end.point) * end.inverse))
    }

    /// `p.(M n1)` of an arc up to a quarter turn for a vector p of its plane, from what it and n1 are along the directions of the
    /// ends.
    #[inline]
    pub(crate) fn within_a_quarter_turn(&self, [q1, q2]: [T; 2], [c1, c2]: [T; 2]) -> T {
        let product = self.start.inverse * self.end.inverse;
        let (sin, cos) = (self.across * product, self.inline * product);
        let one_and_cos = T::exact(1.0) + cos;
        let chi = (self.angle + sin) / (one_and_cos * T::exact(4.0));
        chi * (q1 + q2) * (c1 + c2) + psi(self.angle, sin, cos, one_and_cos) * (q2 - q1) * (c2 - c1)
    }

    /// Whether the angle is at most a right one.
    #[inline]
    pub(crate) fn is_within_a_quarter_turn(&self) -> bool {
        self.inline.value() >= 0.0
    }

    /// `|g + sin g|` and `1/(1 + cos g)`.
    #[inline]
    pub(crate) fn angle_and_sine(&self) -> (T, T) {
        let product = self.start.inverse * self.end.inverse;
        let cos = self.inline * product;
        ((self.angle + self.across * product).abs(), T::exact(1.0) / (T::exact(1.0) + cos))
    }

    #[cold]
    fn weight_in_frame(&self, line: &Line<T>, n1: Vec3<T>) -> T {
        let frame = line.frame();
        let m = self.moments(&frame);
        (m.cc * n1.dot(frame.toward) + m.cs * n1.dot(frame.along)) * line.nearness()
    }
}

/// `(g - sin g)/4(1 - cos g)`, up to a quarter turn.
///
/// On doubles by [`PSI`]; else for small g by the series p of `6 (g - sin g)/g^3`, `sin g = g (1 - g^2 p/6)` and
/// `1 - cos g = sin^2 g/(1 + cos g)`.
#[inline]
fn psi<T: Real>(angle: T, sin: T, cos: T, one_and_cos: T) -> T {
    if T::Number::IS_DOUBLE {
        let z = angle * angle;
        return angle * (T::exact(PSI[0]) + z * higher(z)).widened(T::Number::roundoff() * 0.06);
    }
    if angle.value().abs() > 1.0 {
        return (angle - sin) / ((T::exact(1.0) - cos) * T::exact(4.0));
    }
    let square = angle * angle;
    let series = sine_series(square);
    let sine_over_angle = T::exact(1.0) - square * series / T::exact(6.0);
    angle * series * one_and_cos / (sine_over_angle * sine_over_angle * T::exact(24.0))
}

/// Coefficients of `psi(g)/g` in powers of `g^2` up to `(pi/2)^2`, of least largest relative error by Remez's algorithm: 2^-54
/// with rounded coefficients, most of it the rounding of 1/12.
pub(crate) const PSI: [f64; 10] = [
    0.083_333_333_333_333_33,
    0.002_777_777_777_777_888_5,
    9.920_634_920_487_068e-5,
    3.306_878_314_529_27e-6,
    1.043_837_648_752_227_8e-7,
    3.170_544_222_560_070_5e-9,
    9.365_030_454_239_462e-11,
    2.727_115_302_175_878e-12,
    7.214_105_562_980_108e-14,
    3.093_407_690_573_923_5e-15,
];

/// The polynomial of [`PSI`] without its first term, over `z`, by Estrin's scheme.
#[inline]
fn higher<T: Real>(z: T) -> T {
    let [_, c1, c2, c3, c4, c5, c6, c7, c8, c9] = PSI.map(T::exact);
    let z2 = z * z;
    let z4 = z2 * z2;
    ((c1 + c2 * z) + (c3 + c4 * z) * z2) + (((c5 + c6 * z) + (c7 + c8 * z) * z2) + c9 * z4) * z4
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::boundary::line::Sighted;
    use crate::scalar::ball::Ball;
    use crate::scalar::double_double::DoubleDouble;
    use crate::scalar::number::ROUNDOFF;

    #[test]
    fn an_arc_of_no_length_weighs_nothing() {
        let point = |x: f64| Sighted::at(Vec3::new(2.0, x, 0.5));
        let line = Line::<f64>::along(Vec3::new(0.0, 1.0, 0.0), point(0.25).point);
        let arc = Arc::between(point(0.25), point(0.25), Generator::Occluder(line));
        assert_eq!(arc.weight(&line, Vec3::new(0.3, -0.5, 0.812)), 0.0);
        let point = |x: Ball<f64>| Sighted::at(Vec3::new(Ball::exact(2.0), x, Ball::exact(0.5)));
        let [from, to] = [0.25, 0.25 + 1e-16].map(|x| point(Ball::approximate(x, 1e-15)));
        let line = Line::along(Vec3::new(0.0, 1.0, 0.0).map(Ball::exact), from.point);
        let weight =
            Arc::between(from, to, Generator::Occluder(line)).weight(&line, Vec3::new(0.3, -0.5, 0.812).map(Ball::exact));
        assert!(weight.value().abs() <= weight.error() && weight.error() < 1e-14, "{weight:?}");
    }

    #[test]
    fn psi_on_doubles_errs_by_three_roundoffs() {
        let mut worst = 0.0f64;
        for k in 1..4000 {
            let g = f64::from(k) * (std::f64::consts::FRAC_PI_2 / 4000.0);
            let (exact, one) = (DoubleDouble::from(g), DoubleDouble::from(1.0));
            let (sin, cos) = sine_and_cosine(exact);
            let ball = |middle| Ball::approximate(middle, 0.0);
            let truth = psi(ball(exact), ball(sin), ball(cos), ball(one + cos));
            let error = (DoubleDouble::from(psi(g, f64::NAN, f64::NAN, f64::NAN)) - truth.middle()).hi.abs();
            worst = worst.max(error / (truth.value() * ROUNDOFF));
        }
        println!("{worst:.2}");
        assert!(worst < 3.0 && worst > 0.5, "{worst}");
    }

    /// By Taylor's series.
    fn sine_and_cosine(g: DoubleDouble) -> (DoubleDouble, DoubleDouble) {
        let mut sums = [DoubleDouble::from(0.0); 2];
        let mut term = DoubleDouble::from(1.0);
        for k in 0..40u32 {
            let signed = if k % 4 < 2 { term } else { -term };
            sums[(k % 2) as usize] = sums[(k % 2) as usize] + signed;
            term = (term * g).divided_by(DoubleDouble::from(f64::from(k + 1)));
        }
        (sums[1], sums[0])
    }

    #[test]
    fn the_weight_is_that_of_the_moments_in_the_frame() {
        let n1 = Vec3::new(0.3, -0.5, 0.812);
        for (from, to) in [(-0.9, 0.2), (0.4, 0.4001), (-0.5, 1.0), (-0.78, 0.78), (1.0, 1.5), (0.2, 1.2)] {
            let on_line = |psi: f64| Sighted::at(Vec3::new(2.0, 2.0 * libm::tan(psi), 0.5));
            let (start, end) = (on_line(from), on_line(to));
            let line = Line::<f64>::along(Vec3::new(0.0, 1.0, 0.0), start.point);
            let arc = Arc::between(start, end, Generator::Emitter(line));
            let whole = arc.weight_in_frame(&line, n1);
            assert!((arc.weight(&line, n1) - whole).abs() < 4e-16, "{from} {to}");
            // The same line taken for an occluder's: the ends are then asked for in its frame.
            let shadow = Arc::between(start, end, Generator::Occluder(line));
            assert!((shadow.weight(&line, n1) - whole).abs() < 4e-16, "{from} {to}");
        }
    }
}
