//! Numbers with running error bounds, four at a time, one a lane, as [`crate::ball`] has them for a double.
//!
//! The bounds are those of its operations, but for the rounding of the radii themselves: no chain of operations here is 2^20 long, and each
//! loses at most eight roundings, so that [`LaneBall::sum_of_first`] pays for all of them with one factor. A radius is not a number, or
//! infinite, where nothing is bounded.

use std::ops::{Add, Div, Mul, Neg, Sub};

use fearless_simd::{Simd, f64x4};

use crate::arithmetic::Arithmetic;
use crate::ball::Ball;
use crate::number::{Number, ROUNDOFF};
use crate::real::Real;

/// Four real numbers, each within a radius of its middle.
#[derive(Debug, Clone, Copy)]
pub struct LaneBall<S: Simd> {
    middle: f64x4<S>,
    radius: f64x4<S>,
}

/// Pays for the rounding of radii.
const UP: f64 = 1.0 + 1e-8;

/// The largest error of a result below the normal range.
const TINY: f64 = f64::MIN_POSITIVE;

/// Error of the library's functions, in units of roundoff.
const LIBRARY: f64 = <f64 as Number>::LIBRARY_UNITS;

impl<S: Simd> LaneBall<S> {
    /// Numbers that are off by one rounding.
    #[inline(always)]
    pub fn rounded(middle: f64x4<S>) -> Self {
        Self { middle, radius: middle.abs() * ROUNDOFF + TINY }
    }

    /// The same number in all lanes.
    #[inline(always)]
    pub fn splat(simd: S, number: Ball<f64>) -> Self {
        Self {
            middle: <f64x4<S> as fearless_simd::SimdBase<S>>::splat(simd, number.middle()),
            radius: <f64x4<S> as fearless_simd::SimdBase<S>>::splat(simd, number.error()),
        }
    }

    /// The middles.
    #[inline(always)]
    pub const fn middle(self) -> f64x4<S> {
        self.middle
    }

    /// Bounds on the errors of the middles.
    #[inline(always)]
    pub fn error(self) -> f64x4<S> {
        self.radius * UP
    }

    /// Numbers that are moved to other lanes.
    #[inline(always)]
    pub fn moved(self, to: impl Fn(f64x4<S>) -> f64x4<S>) -> Self {
        Self { middle: to(self.middle), radius: to(self.radius) }
    }

    /// The sum of the first three lanes, or of all four.
    #[inline(always)]
    pub fn sum_of_first(self, count: usize) -> Ball<f64> {
        let ([a, b, c, d], [p, q, r, s]) =
            (*fearless_simd::SimdBase::as_array(&self.middle), *fearless_simd::SimdBase::as_array(&self.radius));
        let three = a + b + c;
        let (sum, size, radius) = match count {
            3 => (three, a.abs() + b.abs() + c.abs(), p + q + r),
            _ => (three + d, a.abs() + b.abs() + c.abs() + d.abs(), p + q + r + s),
        };
        Ball::approximate(sum, (radius + size * (3.0 * ROUNDOFF)) * UP)
    }

    /// Square roots: `|sqrt(a) - sqrt(a')| <= |a - a'|/sqrt(a)`. None is known where the ball reaches 0.
    #[inline(always)]
    pub fn sqrt(self) -> Self {
        let middle = self.middle.sqrt();
        let radius = self.radius / middle + middle * ROUNDOFF;
        Self::bounded_where(self.middle.exceeds(self.radius), middle, radius)
    }

    /// Angles of points in the first quadrant, given their middles as they are found from those of the coordinates: a disc of radius p
    /// around a point at the distance d is seen under `asin(p/d) <= 1.07 p/d` up to p = d/2.
    #[inline(always)]
    pub fn angle(across: Self, inline: Self, middle: f64x4<S>) -> Self {
        let distance = (across.middle * across.middle + inline.middle * inline.middle).sqrt();
        let seen = (across.radius + inline.radius) / distance;
        let radius = seen * 1.07 + middle.abs() * (LIBRARY * ROUNDOFF) + TINY;
        Self::bounded_where(seen.like(0.5).exceeds(seen), middle, radius)
    }

    /// Halves of logarithms, given their middles as they are found from those of the numbers: `|ln a - ln a'| <= q/(1 - q) <= 1.1 q`,
    /// `q = |a - a'|/a` up to 1/11. None is known of numbers that are not positive.
    #[inline(always)]
    pub fn half_logarithm(self, middle: f64x4<S>) -> Self {
        let radius = self.radius / self.middle * 0.55 + middle.abs() * (LIBRARY * ROUNDOFF) + TINY;
        Self::bounded_where((self.middle * 0.09).exceeds(self.radius), middle, radius)
    }

    #[inline(always)]
    fn bounded_where(is_known: <f64x4<S> as Arithmetic>::Mask, middle: f64x4<S>, radius: f64x4<S>) -> Self {
        Self { middle, radius: f64x4::choose(is_known, radius, middle.like(f64::INFINITY)) }
    }
}

impl<S: Simd> Add for LaneBall<S> {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        let middle = self.middle + other.middle;
        Self { middle, radius: self.radius + other.radius + middle.abs() * ROUNDOFF }
    }
}

impl<S: Simd> Sub for LaneBall<S> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        let middle = self.middle - other.middle;
        Self { middle, radius: self.radius + other.radius + middle.abs() * ROUNDOFF }
    }
}

impl<S: Simd> Neg for LaneBall<S> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self { middle: -self.middle, radius: self.radius }
    }
}

impl<S: Simd> Mul for LaneBall<S> {
    type Output = Self;
    /// `|ab - a'b'| <= |a| rb + ra (|b| + rb)`.
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        let middle = self.middle * other.middle;
        let propagated = self.middle.abs() * other.radius + self.radius * (other.middle.abs() + other.radius);
        Self { middle, radius: propagated + (middle.abs() * ROUNDOFF + TINY) }
    }
}

impl<S: Simd> Div for LaneBall<S> {
    type Output = Self;
    /// `|a/b - a'/b'| <= (ra + |a/b| rb)/(|b| - rb)`.
    #[inline(always)]
    fn div(self, other: Self) -> Self {
        let middle = self.middle / other.middle;
        let least = other.middle.abs() - other.radius;
        let radius = (self.radius + middle.abs() * other.radius + TINY) / least + (middle.abs() * ROUNDOFF + TINY);
        Self::bounded_where(least.exceeds(least.like(0.0)), middle, radius)
    }
}

#[cfg(test)]
mod tests {
    use fearless_simd::Level;
    use proptest::prelude::*;

    use super::*;
    use crate::double_double::DoubleDouble;
    use crate::on_instruction_set;

    /// Compares the results, as balls on lanes, with their exact values for numbers inside, as far as double-doubles go.
    fn check([(a, ra, x), (b, rb, y)]: [(f64, f64, f64); 2]) {
        let exact = |number: f64| DoubleDouble::from(number);
        let truths = [exact(x) + exact(y), exact(x) - exact(y), exact(x) * exact(y), exact(x).divided_by(exact(y))];
        let results = on_instruction_set!(Level::new(), simd => {
            let [p, q] = [(a, ra), (b, rb)].map(|(middle, radius)| LaneBall::splat(simd, Ball::approximate(middle, radius)));
            Some([p + q, p - q, p * q, p / q, p.sqrt(), q.sqrt()].map(|result| (result.middle()[0], result.error()[0])))
        });
        let results = results.unwrap();
        for ((middle, error), truth) in results.iter().zip(truths) {
            let deviation = (exact(*middle) - truth).hi.abs();
            assert!(
                deviation <= *error * (1.0 + 1e-9) || error.is_infinite(),
                "{a} {ra} {x}, {b} {rb} {y}: {middle} {error:e} {truth:?}"
            );
        }
        for ((middle, error), truth) in results[4..].iter().zip([x, y]) {
            assert!(
                (middle - truth.max(0.0).sqrt()).abs() <= error + 2.0 * ROUNDOFF * middle || !error.is_finite(),
                "{truth} {middle} {error:e}"
            );
        }
    }

    fn inhabited() -> impl Strategy<Value = (f64, f64, f64)> {
        (-8.0..8.0f64, -18..0i32, -1.0..1.0f64).prop_map(|(middle, exponent, place)| {
            let radius = libm::exp10(f64::from(exponent));
            let inside = middle + place * radius * 0.999;
            (middle, radius, if (inside - middle).abs() <= radius { inside } else { middle })
        })
    }

    proptest! {
        #[test]
        fn results_of_numbers_in_the_balls_are_in_the_balls(a in inhabited(), b in inhabited()) {
            check([a, b]);
        }
    }

    #[test]
    fn what_reaches_0_bounds_nothing_and_a_sum_counts_its_lanes() {
        let results = on_instruction_set!(Level::new(), simd => {
            let one = LaneBall::splat(simd, Ball::approximate(1.0, 0.0));
            let zero = LaneBall::splat(simd, Ball::approximate(1e-3, 1e-2));
            Some(([(one / zero).error()[0], zero.sqrt().error()[0]], [3, 4].map(|count| one.sum_of_first(count))))
        });
        let (errors, sums) = results.unwrap();
        assert_eq!(errors, [f64::INFINITY; 2]);
        assert_eq!(sums.map(Real::value), [3.0, 4.0]);
        assert!(sums.iter().all(|sum| sum.error() > 8.0 * ROUNDOFF && sum.error() < 16.0 * ROUNDOFF));
    }
}
