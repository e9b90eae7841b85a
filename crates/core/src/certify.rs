//! A double with a running error bound: the second scalar of the closed forms.
//!
//! A [`Ball`] `(mid, radius)` stands for every real within `radius` of `mid`. Each operation returns a ball that contains the exact
//! result for all operands in the balls given. With u = 2^-53 and round to nearest, `fl(a op b) = (a op b)(1 + d)`, |d| <= u, so the radius
//! gains `u |fl|/(1-u)`; what the operands' radii do is written at each operation. Radii are sums and products of at most eight
//! non-negative doubles, each rounding loses a relative u at most, and the factor [`UP`] pays for all of them. Results below the normal range
//! lose more than a relative u: [`TINY`] pays for that.
//!
//! Assumed of the library, and tested in `tests/library_functions.rs`: `sqrt` is correctly rounded (IEEE 754); `log` and `atan2` err by at
//! most 2 ulp ([`LIBRARY_ERROR`]).

use std::ops::{Add, Div, Mul, Neg, Sub};

use crate::dilogarithm::{CLAUSEN_ERROR, clausen, clausen_change};
use crate::real::{ROUNDOFF, Real};

/// A real number within `radius` of `mid`.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Ball {
    mid: f64,
    radius: f64,
}

/// One above 1 by more than eight roundings of a radius.
const UP: f64 = 1.0 + 16.0 * f64::EPSILON;

/// Above the absolute error of any one operation whose result is not normal.
const TINY: f64 = f64::MIN_POSITIVE;

/// 2 ulp, an ulp being at most 2u of the result.
const LIBRARY_ERROR: f64 = 4.0 * ROUNDOFF;

impl Ball {
    #[inline]
    fn new(mid: f64, radius: f64) -> Self {
        Self { mid, radius: radius * UP }
    }
}

impl Real for Ball {
    #[inline]
    fn approximate(value: f64, error: f64) -> Self {
        Self { mid: value, radius: error }
    }

    #[inline]
    fn value(self) -> f64 {
        self.mid
    }

    #[inline]
    fn error(self) -> f64 {
        self.radius
    }

    #[inline]
    fn widened(self, error: f64) -> Self {
        Self::new(self.mid, self.radius + error)
    }

    /// Where the sign is in doubt, both are enclosed.
    #[inline]
    fn with_sign_of(self, other: Self) -> Self {
        if other.mid.abs() > other.radius {
            Self { mid: self.mid.with_sign_of(other.mid), radius: self.radius }
        } else {
            Self::new(self.mid.with_sign_of(other.mid), 2.0 * self.mid.abs() + self.radius)
        }
    }

    /// `|sqrt(a) - sqrt(a')| = |a - a'| / (sqrt(a) + sqrt(a'))`; where the ball reaches 0, the root is within `[0, sqrt(mid + radius)]`.
    #[inline]
    fn sqrt(self) -> Self {
        let root = self.mid.sqrt();
        let propagated = if self.radius < self.mid {
            self.radius / (root + (self.mid - self.radius).sqrt() * (1.0 - 4.0 * ROUNDOFF))
        } else {
            (self.mid + self.radius).sqrt()
        };
        Self::new(root, propagated + ROUNDOFF * root)
    }

    /// `|ln a - ln a'| <= -ln(1 - radius/mid) <= q / (1 - q)`, `q = radius/mid`.
    #[inline]
    fn ln(self) -> Self {
        let mid = libm::log(self.mid);
        let q = self.radius / self.mid * UP;
        let propagated = if q < 1.0 { q / (1.0 - q) * UP } else { f64::INFINITY };
        Self::new(mid, propagated + LIBRARY_ERROR * mid.abs())
    }

    /// A disc of radius `p` around a point at distance `d` is seen under the half-angle `asin z`, `z = p/d`; `asin z <= z (1 + z^2/4)` up to
    /// 1/2 and `<= z pi/2` up to 1.
    #[inline]
    fn atan2(self, x: Self) -> Self {
        let mid = libm::atan2(self.mid, x.mid);
        let moved = self.radius + x.radius;
        let distance = (self.mid * self.mid + x.mid * x.mid).sqrt();
        let z = moved / distance * UP;
        let propagated = if z <= 0.5 {
            z * (1.0 + 0.25 * z * z)
        } else if z <= 1.0 {
            z * std::f64::consts::FRAC_PI_2
        } else {
            2.0 * std::f64::consts::PI
        };
        let propagated = if moved == 0.0 { 0.0 } else { propagated };
        Self::new(mid, propagated + LIBRARY_ERROR * mid.abs() + TINY)
    }

    #[inline]
    fn clausen(self) -> Self {
        let mid = clausen(self.mid);
        Self::new(mid, clausen_change(self.mid, self.radius) + CLAUSEN_ERROR * mid.abs() + TINY)
    }
}

impl Add for Ball {
    type Output = Self;
    #[inline]
    fn add(self, other: Self) -> Self {
        let mid = self.mid + other.mid;
        Self::new(mid, self.radius + other.radius + ROUNDOFF * mid.abs())
    }
}

impl Neg for Ball {
    type Output = Self;
    #[inline]
    fn neg(self) -> Self {
        Self { mid: -self.mid, radius: self.radius }
    }
}

impl Sub for Ball {
    type Output = Self;
    #[inline]
    fn sub(self, other: Self) -> Self {
        self + (-other)
    }
}

impl Mul for Ball {
    type Output = Self;
    /// `|ab - a'b'| <= |a| rb + ra (|b| + rb)`.
    #[inline]
    fn mul(self, other: Self) -> Self {
        let mid = self.mid * other.mid;
        let propagated = self.mid.abs() * other.radius + self.radius * (other.mid.abs() + other.radius);
        Self::new(mid, propagated + ROUNDOFF * mid.abs() + TINY)
    }
}

impl Div for Ball {
    type Output = Self;
    /// `|a/b - a'/b'| <= (ra + |a/b| rb) / (|b| - rb)`.
    #[inline]
    fn div(self, other: Self) -> Self {
        let mid = self.mid / other.mid;
        let least = (other.mid.abs() - other.radius) * (1.0 - 2.0 * ROUNDOFF);
        let propagated = if least > 0.0 { (self.radius + mid.abs() * other.radius) / least } else { f64::INFINITY };
        Self::new(mid, propagated + ROUNDOFF * mid.abs() + TINY)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// A ball and a double inside it.
    fn inhabited() -> impl Strategy<Value = (Ball, f64)> {
        (-8.0..8.0f64, -18..0i32, -1.0..1.0f64).prop_map(|(mid, exponent, place)| {
            let radius = libm::exp10(f64::from(exponent));
            let inside = (mid + place * radius).clamp(mid - radius * 0.999, mid + radius * 0.999);
            (Ball::approximate(mid, radius), if (inside - mid).abs() <= radius { inside } else { mid })
        })
    }

    /// The ball contains the double-precision result, which itself may be off by a few ulp.
    fn contains(ball: Ball, result: f64) -> bool {
        (ball.mid - result).abs() <= ball.radius + 8.0 * ROUNDOFF * result.abs() || !ball.radius.is_finite()
    }

    proptest! {
        #[test]
        fn results_of_operands_in_the_balls_are_in_the_ball((a, x) in inhabited(), (b, y) in inhabited()) {
            prop_assert!(contains(a + b, x + y));
            prop_assert!(contains(a - b, x - y));
            prop_assert!(contains(a * b, x * y));
            prop_assert!(contains(a / b, x / y));
            if a.mid > 0.0 && x > 0.0 {
                prop_assert!(contains(a.sqrt(), x.sqrt()));
                prop_assert!(contains(a.ln(), libm::log(x)));
                prop_assert!(contains(a.atan2(b), libm::atan2(x, y)));
            }
            if a.mid.abs() < 6.2 && x.abs() < 6.2 {
                prop_assert!(contains(a.clausen(), clausen(x)));
            }
        }
    }

    #[test]
    fn dividing_by_a_ball_with_zero_bounds_nothing() {
        let zero = Ball::approximate(1e-3, 1e-2);
        assert_eq!((Ball::exact(1.0) / zero).error(), f64::INFINITY);
    }
}
