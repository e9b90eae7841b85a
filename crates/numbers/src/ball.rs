//! A number with a running error bound: the scalar that certifies a closed form.
//!
//! A [`Ball`] `(mid, radius)` stands for every real within `radius` of `mid`, a double, a double-double or a number of any
//! precision. Each operation returns a ball that contains the exact result for all operands in the balls given. Its own rounding
//! is at most `eps |result|` with the eps that [`Number`] states for the operation; the effect of the operands' radii is written at
//! each operation. Radii are sums and products of at most eight non-negative numbers, each rounding loses a relative 2^-53 at most,
//! and the factor `UP` pays for all of them, as it does for taking the leading double of `mid` for its size. Results below the
//! normal range lose more than a relative eps: [`Number::tiny`] pays for that.

use std::ops::{Add, Div, Mul, Neg, Sub};

use crate::arithmetic::Arithmetic;
use crate::dilogarithm::{clausen_rest, clausen_rest_change};
use crate::number::{Number, ROUNDOFF};
use crate::radius::Radius;
use crate::real::Real;

/// A real number within `radius` of `mid`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ball<N: Number> {
    mid: N,
    radius: N::Radius,
}

/// One above 1 by more than eight roundings of a radius.
const UP: f64 = 1.0 + 16.0 * f64::EPSILON;

/// One below 1 by two roundings.
const DOWN: f64 = 1.0 - 2.0 * f64::EPSILON;

#[inline(never)]
fn apart<R>(operation: impl FnOnce() -> R) -> R {
    operation()
}

impl<N: Number> Ball<N> {
    #[inline]
    fn new(mid: N, radius: N::Radius) -> Self {
        Self { mid, radius: (radius * UP) }
    }

    /// The result of an operation that errs by so many units of roundoff, with the error that the operands propagate.
    #[inline]
    fn result(mid: N, propagated: N::Radius, units: f64) -> Self {
        Self::new(mid, propagated + N::roundoff() * mid.size() * units)
    }

    /// Runs a long operation: in its place on doubles, as a call on wider numbers, where it stands in many places.
    #[inline(always)]
    fn called(operation: impl FnOnce() -> Self) -> Self {
        if N::IS_DOUBLE { operation() } else { apart(operation) }
    }

    /// The same of a sum or a product, which are in their place on double-doubles too.
    #[inline(always)]
    fn called_on_many_bits(operation: impl FnOnce() -> Self) -> Self {
        if N::BEYOND_DOUBLE_DOUBLE { apart(operation) } else { operation() }
    }

    /// The number without the bound.
    pub const fn middle(self) -> N {
        self.mid
    }
}

impl<N: Number> Real for Ball<N> {
    type Number = N;

    #[inline]
    fn approximate(value: N, error: N::Radius) -> Self {
        Self { mid: value, radius: error }
    }

    #[inline]
    fn value(self) -> f64 {
        self.mid.high()
    }

    #[inline]
    fn size(self) -> N::Radius {
        self.mid.size()
    }

    #[inline]
    fn error(self) -> N::Radius {
        self.radius
    }

    #[inline]
    fn value_error(self) -> f64 {
        // Half an ulp rather than the actual rounding: whoever compares with a rounded truth must not find the bound broken.
        let low = self.mid.low().abs();
        let rounding = if low == 0.0 { 0.0 } else { low.max(ROUNDOFF * self.value().abs()) };
        (self.radius.to_double() + rounding) * UP
    }

    #[inline]
    fn widened(self, error: N::Radius) -> Self {
        Self::new(self.mid, self.radius + error)
    }

    /// Below the normal range the power of two rounds.
    #[inline]
    fn scaled(self, power_of_two: f64) -> Self {
        let mid = self.mid.scaled(power_of_two);
        let rounds = mid.high() != 0.0 && mid.size() < N::tiny() / N::roundoff();
        let lost = if rounds { N::tiny() } else { 0.0.into() };
        Self { mid, radius: self.radius * power_of_two + lost }
    }
}

impl<N: Number> Arithmetic for Ball<N> {
    type Mask = bool;
    const IS_DOUBLE: bool = N::IS_DOUBLE;

    #[inline]
    fn like(self, constant: f64) -> Self {
        Self::exact(constant)
    }

    #[inline]
    fn like_pi(self) -> Self {
        Self::pi()
    }

    #[inline]
    fn exceeds(self, other: Self) -> bool {
        self.value() > other.value()
    }

    #[inline]
    fn choose(mask: bool, set: Self, unset: Self) -> Self {
        if mask { set } else { unset }
    }

    #[inline]
    fn choose_of(mask: bool, set: impl FnOnce() -> Self, unset: impl FnOnce() -> Self) -> Self {
        if mask { set() } else { unset() }
    }

    #[inline]
    fn abs(self) -> Self {
        if self.value() < 0.0 { -self } else { self }
    }

    #[inline]
    fn sine_series(square: Self) -> Self {
        let coefficients = N::sine_coefficients().rev();
        let sum = coefficients.fold(Self::exact(0.0), |sum, c| sum * square + Self::rounded(c));
        sum.known_to(0.25)
    }

    #[inline]
    fn known_to(self, units: f64) -> Self {
        self.widened(N::roundoff() * units)
    }

    /// `|sqrt(a) - sqrt(a')| = |a - a'| / (sqrt(a) + sqrt(a'))`; where the ball reaches 0, the root is within `[0, sqrt(mid +
    /// radius)]`.
    #[inline]
    fn sqrt(self) -> Self {
        Self::called(|| {
            let root = self.mid.sqrt();
            let propagated = if self.radius < self.size() {
                self.radius / (root.size() + (self.size() - self.radius).sqrt() * DOWN)
            } else {
                (self.size() + self.radius).sqrt()
            };
            Self::result(root, propagated, 1.0)
        })
    }

    /// `|ln a - ln a'| <= -ln(1 - radius/mid) <= q / (1 - q)`, `q = radius/mid`.
    #[inline]
    fn ln(self) -> Self {
        Self::called(|| {
            let one = N::Radius::from(1.0);
            let q = self.radius / self.size() * UP;
            let propagated = if q < one { q / (one - q) * UP } else { f64::INFINITY.into() };
            Self::result(self.mid.ln(), propagated, N::LIBRARY_UNITS)
        })
    }

    /// A disc of radius `p` around a point at distance `d` is seen under the half-angle `asin z`, `z = p/d`; `asin z <= z (1 +
    /// z^2/4)` up to 1/2 and `<= z pi/2` up to 1. Where the disc reaches the cut the angle may be off by a turn.
    #[inline]
    fn atan2(self, x: Self) -> Self {
        Self::called(|| {
            let moved = self.radius + x.radius;
            let distance = (self.size() * self.size() + x.size() * x.size()).sqrt();
            let z = moved / distance * UP;
            let cut = x.value() < 0.0 && self.size() <= self.radius;
            let propagated = if moved == 0.0.into() {
                moved
            } else if cut {
                std::f64::consts::TAU.into()
            } else if z <= 0.5.into() {
                z * (N::Radius::from(1.0) + z * z * 0.25)
            } else if z <= 1.0.into() {
                z * std::f64::consts::FRAC_PI_2
            } else {
                std::f64::consts::TAU.into()
            };
            Self::result(self.mid.atan2(x.mid), propagated + N::tiny(), N::LIBRARY_UNITS)
        })
    }

    #[inline]
    fn clausen_rest(self) -> Self {
        Self::result(clausen_rest(self.mid), clausen_rest_change(self.mid, self.radius) + N::tiny(), N::CLAUSEN_UNITS)
    }
}

impl<N: Number> Add for Ball<N> {
    type Output = Self;
    #[inline]
    fn add(self, other: Self) -> Self {
        Self::called_on_many_bits(|| Self::result(self.mid + other.mid, self.radius + other.radius, 1.0))
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
        Self::called_on_many_bits(|| {
            let propagated = self.size() * other.radius + self.radius * (other.size() + other.radius);
            Self::result(self.mid * other.mid, propagated + N::tiny(), 1.0)
        })
    }
}

impl<N: Number> Div for Ball<N> {
    type Output = Self;
    /// `|a/b - a'/b'| <= (ra + |a/b| rb) / (|b| - rb)`.
    #[inline]
    fn div(self, other: Self) -> Self {
        Self::called(|| {
            let mid = self.mid / other.mid;
            let least = (other.size() - other.radius) * DOWN;
            let propagated = if least > 0.0.into() {
                (self.radius + mid.size() * other.radius + N::tiny()) / least
            } else {
                f64::INFINITY.into()
            };
            Self::result(mid, propagated + N::tiny(), N::QUOTIENT_UNITS)
        })
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
        let (difference, radius) = ((ball.mid - N::from_double(result)).high().abs(), ball.radius.to_double());
        difference <= radius + 4.0 * f64::EPSILON * result.abs() || !radius.is_finite()
    }

    fn check<N: Number>((a, ra, x): (f64, f64, f64), (b, rb, y): (f64, f64, f64)) -> Result<(), TestCaseError> {
        let ball = |mid, radius: f64| Ball::approximate(N::from_double(mid), radius.into());
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
        if a.abs() < 1.57 && x.abs() < 1.57 {
            prop_assert!(contains(p.clausen_rest(), clausen_rest(x)));
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
    fn an_angle_across_the_cut_is_off_by_up_to_a_turn() {
        let angle = |y: f64, radius: f64| Ball::approximate(y, radius).atan2(Ball::exact(-1.0)).error();
        assert!(angle(1e-20, 1e-19) >= std::f64::consts::TAU && angle(-1e-20, 1e-19) >= std::f64::consts::TAU);
        assert!(angle(1e-18, 1e-19) < 1e-14);
    }

    #[test]
    fn dividing_by_a_ball_with_zero_bounds_nothing() {
        let zero = Ball::approximate(1e-3, 1e-2);
        assert_eq!((Ball::exact(1.0) / zero).error(), f64::INFINITY);
    }
}
