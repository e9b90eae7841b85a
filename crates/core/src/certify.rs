//! A number with a running error bound: the scalar that certifies a closed form.
//!
//! A [`Ball`] `(mid, radius)` stands for every real within `radius` of `mid`, a double or a double-double. Each operation returns a ball that
//! contains the exact result for all operands in the balls given. Its own rounding is at most `eps |result|` with the eps that
//! [`Number`] states for the operation; what the operands' radii do is written at each operation. Radii are sums and products of at most
//! eight non-negative doubles, each rounding loses a relative 2^-53 at most, and the factor [`UP`] pays for all of them, as it does for taking the
//! leading double of `mid` for its size. Results below the normal range lose more than a relative eps: [`TINY`] pays for that.

use std::ops::{Add, Div, Mul, Neg, Sub};

use crate::dilogarithm::{clausen, clausen_change};
use crate::number::{Number, ROUNDOFF};
use crate::real::Real;

/// A real number within `radius` of `mid`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Ball<N> {
    mid: N,
    radius: f64,
}

/// One above 1 by more than eight roundings of a radius.
const UP: f64 = 1.0 + 16.0 * f64::EPSILON;

/// Above the absolute error of any one operation whose result is not normal.
const TINY: f64 = f64::MIN_POSITIVE;

impl<N: Number> Ball<N> {
    #[inline]
    fn new(mid: N, radius: f64) -> Self {
        Self { mid, radius: radius * UP }
    }

    #[inline]
    pub(crate) const fn middle(self) -> N {
        self.mid
    }

    #[inline]
    fn size(self) -> f64 {
        self.mid.high().abs()
    }
}

impl<N: Number> Real for Ball<N> {
    type Number = N;

    #[inline]
    fn approximate(value: N, error: f64) -> Self {
        Self { mid: value, radius: error }
    }

    #[inline]
    fn value(self) -> f64 {
        self.mid.high()
    }

    #[inline]
    fn error(self) -> f64 {
        self.radius
    }

    #[inline]
    fn value_error(self) -> f64 {
        // Half an ulp rather than what the rounding was: whoever compares with a rounded truth must not find it broken.
        let rounding = if self.mid.low() == 0.0 { 0.0 } else { ROUNDOFF * self.size() };
        (self.radius + rounding) * UP
    }

    #[inline]
    fn widened(self, error: f64) -> Self {
        Self::new(self.mid, self.radius + error)
    }

    /// Where the sign is in doubt, both are enclosed.
    #[inline]
    fn with_sign_of(self, other: Self) -> Self {
        let signed = if other.value() < 0.0 { -self } else { self };
        if other.size() > other.radius { signed } else { Self::new(signed.mid, 2.0 * self.size() + self.radius) }
    }

    /// Below the normal range the power of two rounds.
    #[inline]
    fn scaled(self, power_of_two: f64) -> Self {
        let mid = self.mid.scaled(power_of_two);
        let lost = if mid.high() != 0.0 && mid.high().abs() < TINY / N::ROUNDOFF { TINY } else { 0.0 };
        Self { mid, radius: self.radius * power_of_two + lost }
    }

    /// `|sqrt(a) - sqrt(a')| = |a - a'| / (sqrt(a) + sqrt(a'))`; where the ball reaches 0, the root is within `[0, sqrt(mid + radius)]`.
    #[inline]
    fn sqrt(self) -> Self {
        let root = self.mid.sqrt();
        let high = root.high();
        let propagated = if self.radius < self.value() {
            self.radius / (high + (self.value() - self.radius).sqrt() * (1.0 - 2.0 * f64::EPSILON))
        } else {
            (self.value() + self.radius).sqrt()
        };
        Self::new(root, propagated + N::ROUNDOFF * high)
    }

    /// `|ln a - ln a'| <= -ln(1 - radius/mid) <= q / (1 - q)`, `q = radius/mid`.
    #[inline]
    fn ln(self) -> Self {
        let mid = self.mid.ln();
        let q = self.radius / self.value() * UP;
        let propagated = if q < 1.0 { q / (1.0 - q) * UP } else { f64::INFINITY };
        Self::new(mid, propagated + N::LIBRARY * mid.high().abs())
    }

    /// A disc of radius `p` around a point at distance `d` is seen under the half-angle `asin z`, `z = p/d`; `asin z <= z (1 + z^2/4)` up to
    /// 1/2 and `<= z pi/2` up to 1.
    #[inline]
    fn atan2(self, x: Self) -> Self {
        let mid = self.mid.atan2(x.mid);
        let moved = self.radius + x.radius;
        let distance = (self.size() * self.size() + x.size() * x.size()).sqrt();
        let z = moved / distance * UP;
        let propagated = if moved == 0.0 {
            0.0
        } else if z <= 0.5 {
            z * (1.0 + 0.25 * z * z)
        } else if z <= 1.0 {
            z * std::f64::consts::FRAC_PI_2
        } else {
            std::f64::consts::TAU
        };
        Self::new(mid, propagated + N::LIBRARY * mid.high().abs() + TINY)
    }

    #[inline]
    fn clausen(self) -> Self {
        let mid = clausen(self.mid);
        Self::new(mid, clausen_change(self.value(), self.radius) + N::CLAUSEN * mid.high().abs() + TINY)
    }
}

impl<N: Number> Add for Ball<N> {
    type Output = Self;
    #[inline]
    fn add(self, other: Self) -> Self {
        let mid = self.mid + other.mid;
        Self::new(mid, self.radius + other.radius + N::ROUNDOFF * mid.high().abs())
    }
}

impl<N: Number> Neg for Ball<N> {
    type Output = Self;
    #[inline]
    fn neg(self) -> Self {
        Self { mid: -self.mid, radius: self.radius }
    }
}

impl<N: Number> Sub for Ball<N> {
    type Output = Self;
    #[inline]
    fn sub(self, other: Self) -> Self {
        self + (-other)
    }
}

impl<N: Number> Mul for Ball<N> {
    type Output = Self;
    /// `|ab - a'b'| <= |a| rb + ra (|b| + rb)`.
    #[inline]
    fn mul(self, other: Self) -> Self {
        let mid = self.mid * other.mid;
        let propagated = self.size() * other.radius + self.radius * (other.size() + other.radius);
        Self::new(mid, propagated + N::ROUNDOFF * mid.high().abs() + TINY)
    }
}

impl<N: Number> Div for Ball<N> {
    type Output = Self;
    /// `|a/b - a'/b'| <= (ra + |a/b| rb) / (|b| - rb)`.
    #[inline]
    fn div(self, other: Self) -> Self {
        let mid = self.mid / other.mid;
        let least = (other.size() - other.radius) * (1.0 - 2.0 * f64::EPSILON);
        let size = mid.high().abs();
        let propagated = if least > 0.0 { (self.radius + size * other.radius + TINY) / least } else { f64::INFINITY };
        Self::new(mid, propagated + N::QUOTIENT * size + TINY)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::double_double::DoubleDouble;
    use proptest::prelude::*;

    /// Middle and radius of a ball, and a double inside it.
    fn inhabited() -> impl Strategy<Value = (f64, f64, f64)> {
        (-8.0..8.0f64, -18..0i32, -1.0..1.0f64).prop_map(|(mid, exponent, place)| {
            let radius = libm::exp10(f64::from(exponent));
            let inside = mid + place * radius * 0.999;
            (mid, radius, if (inside - mid).abs() <= radius { inside } else { mid })
        })
    }

    /// The ball contains the double-precision result, which itself may be off by a few ulp.
    fn contains<N: Number>(ball: Ball<N>, result: f64) -> bool {
        let difference = (ball.mid - N::from_double(result)).high().abs();
        difference <= ball.radius + 4.0 * f64::EPSILON * result.abs() || !ball.radius.is_finite()
    }

    fn check<N: Number>((a, ra, x): (f64, f64, f64), (b, rb, y): (f64, f64, f64)) -> Result<(), TestCaseError> {
        let ball = |mid, radius| Ball::approximate(N::from_double(mid), radius);
        let (p, q) = (ball(a, ra), ball(b, rb));
        prop_assert!(contains(p + q, x + y));
        prop_assert!(contains(p - q, x - y));
        prop_assert!(contains(p * q, x * y));
        prop_assert!(contains(p / q, x / y));
        if a > 0.0 && x > 0.0 {
            prop_assert!(contains(p.sqrt(), x.sqrt()));
            prop_assert!(contains(p.ln(), libm::log(x)));
            prop_assert!(contains(p.atan2(q), libm::atan2(x, y)));
        }
        if a.abs() < 6.2 && x.abs() < 6.2 {
            prop_assert!(contains(p.clausen(), clausen(x)));
        }
        Ok(())
    }

    proptest! {
        #[test]
        fn results_of_operands_in_the_balls_are_in_the_ball(a in inhabited(), b in inhabited()) {
            check::<f64>(a, b)?;
            check::<DoubleDouble>(a, b)?;
        }
    }

    #[test]
    fn dividing_by_a_ball_with_zero_bounds_nothing() {
        let zero = Ball::approximate(1e-3, 1e-2);
        assert_eq!((Ball::exact(1.0) / zero).error(), f64::INFINITY);
    }
}
