//! The weight of an arc in the gradient of a constant emitter's radiosity.

use radgrad_numbers::arithmetic::Arithmetic;
use radgrad_numbers::real::Real;
use radgrad_numbers::series::sine::psi;
use radgrad_numbers::vec3::Vec3;

use crate::boundary::arc::{Arc, Generator};
use crate::boundary::line::{Line, Sighted};

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
            return self.weight_past_a_quarter_turn(line, n1);
        }
        let (start, end) = (&self.start, &self.end);
        let near = if let Generator::Emitter(_) = self.generator {
            [start.inverse, end.inverse]
        } else {
            let toward = line.frame().toward * line.nearness();
            let near = |end: &Sighted<T>| end.point.dot(toward) * end.inverse;
            [near(start), near(end)]
        };
        self.within_a_quarter_turn(near, [start.cosine(n1), end.cosine(n1)])
    }

    /// Whether the angle is at most a right one.
    #[inline]
    pub(crate) fn is_within_a_quarter_turn(&self) -> bool {
        self.inline.value() >= 0.0
    }

    #[cold]
    fn weight_past_a_quarter_turn(&self, line: &Line<T>, n1: Vec3<T>) -> T {
        self.weight_in_frame(line, n1)
    }
}

impl<T: Arithmetic> Arc<T> {
    /// `p.(M n1)` of an arc up to a quarter turn for a vector p of its plane, from the components of p and of n1 along the
    /// directions of the ends.
    #[inline(always)]
    pub(crate) fn within_a_quarter_turn(&self, [q1, q2]: [T; 2], [c1, c2]: [T; 2]) -> T {
        let product = self.start.inverse * self.end.inverse;
        let (sin, cos) = (self.across * product, self.inline * product);
        let one_and_cos = cos.like(1.0) + cos;
        let chi = (self.angle + sin) / (one_and_cos * cos.like(4.0));
        chi * (q1 + q2) * (c1 + c2) + psi(self.angle, sin, cos, one_and_cos) * (q2 - q1) * (c2 - c1)
    }

    /// `|g + sin g|` and `1/(1 + cos g)`.
    #[inline(always)]
    pub(crate) fn angle_and_sine(&self) -> (T, T) {
        let product = self.start.inverse * self.end.inverse;
        let cos = self.inline * product;
        ((self.angle + self.across * product).abs(), cos.like(1.0) / (cos.like(1.0) + cos))
    }

    /// The weight on an edge of the emitter, of any angle.
    #[inline(always)]
    pub(crate) fn weight_in_frame(&self, line: &Line<T>, n1: Vec3<T>) -> T {
        let frame = line.frame();
        let m = self.moments(&frame);
        (m.cc * n1.dot(frame.toward) + m.cs * n1.dot(frame.along)) * line.nearness()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use radgrad_numbers::ball::Ball;
    use radgrad_numbers::double_double::DoubleDouble;
    use radgrad_numbers::number::ROUNDOFF;

    #[test]
    fn an_arc_of_no_length_weighs_nothing() {
        let point = |x: f64| Sighted::new(Vec3::new(2.0, x, 0.5));
        let line = Line::<f64>::along(Vec3::new(0.0, 1.0, 0.0), point(0.25).point);
        let arc = Arc::between(point(0.25), point(0.25), Generator::Occluder(line));
        assert_eq!(arc.weight(&line, Vec3::new(0.3, -0.5, 0.812)), 0.0);
        let point = |x: Ball<f64>| Sighted::new(Vec3::new(Ball::exact(2.0), x, Ball::exact(0.5)));
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
            let on_line = |psi: f64| Sighted::new(Vec3::new(2.0, 2.0 * libm::tan(psi), 0.5));
            let (start, end) = (on_line(from), on_line(to));
            let line = Line::<f64>::along(Vec3::new(0.0, 1.0, 0.0), start.point);
            let arc = Arc::between(start, end, Generator::Emitter(line));
            let whole = arc.weight_in_frame(&line, n1);
            assert!((arc.weight(&line, n1) - whole).abs() < 4e-16, "{from} {to}");
            // The same line taken for an occluder's: the ends are then needed in its frame.
            let shadow = Arc::between(start, end, Generator::Occluder(line));
            assert!((shadow.weight(&line, n1) - whole).abs() < 4e-16, "{from} {to}");
        }
    }
}
