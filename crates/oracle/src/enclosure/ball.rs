//! Ball arithmetic: a midpoint with a radius that bounds every rounding so far, as in Arb (Johansson, IEEE TC 66, 2017).
//!
//! Radii are doubles. Each is a sum of at most eight rounded non-negative terms, so multiplying it by `1 + 2^-49` covers their
//! rounding; a constant of the least normal size covers underflow, both in the radius and in a double-double midpoint. A radius
//! that is infinite or not a number says that nothing is known.

use std::ops::{Add, Mul, Neg, Sub};

use crate::enclosure::arithmetic::Real;
use crate::enclosure::exact::Exact;

/// All numbers within `radius` of `middle`.
#[derive(Debug, Clone)]
pub(crate) struct Ball<T> {
    pub(crate) middle: T,
    pub(crate) radius: f64,
}

/// A sum of non-negative terms, rounded up.
#[inline]
pub(crate) fn up(sum: f64) -> f64 {
    const INFLATION: f64 = 1.0 + 1.0 / (1u64 << 49) as f64;
    sum * INFLATION + f64::MIN_POSITIVE
}

impl<T: Real> Ball<T> {
    /// A double, exactly.
    pub(crate) fn from_f64(value: f64, bits: usize) -> Self {
        Self { middle: T::from_f64(value, bits), radius: 0.0 }
    }

    /// A dyadic rational.
    pub(crate) fn from_exact(value: &Exact, bits: usize) -> Self {
        let (middle, bound) = T::from_exact(value, bits);
        Self { middle, radius: if bound == 0.0 { 0.0 } else { up(bound) } }
    }

    /// The ball with a wider radius.
    pub(crate) fn widened(self, by: f64) -> Self {
        Self { radius: up(self.radius + by), middle: self.middle }
    }

    /// Zero, with the same number of bits.
    pub(crate) fn zero(&self) -> Self {
        Self { middle: self.middle.zero(), radius: 0.0 }
    }

    /// Multiplied by a small integer, by doubling and adding.
    pub(crate) fn times_small(&self, factor: usize) -> Self {
        match factor {
            0 => self.zero(),
            1 => self.clone(),
            _ => {
                let half = self.times_small(factor / 2);
                let double = &half + &half;
                if factor.is_multiple_of(2) { double } else { &double + self }
            }
        }
    }

    /// A double next to the midpoint.
    pub(crate) fn leading(&self) -> f64 {
        self.middle.leading()
    }

    /// An upper bound of the absolute value over the ball.
    pub(crate) fn magnitude(&self) -> f64 {
        up(self.middle.leading().abs() + self.radius)
    }

    /// The quotient. With `q = m/n` computed, `a/b - m/n = ((a - m) - (m/n)(b - n)) / b`; a divisor that may be 0 gives an
    /// infinite radius.
    #[inline]
    pub(crate) fn divided_by(&self, divisor: &Self) -> Self {
        let (middle, bound) = self.middle.divide(&divisor.middle);
        let least = divisor.middle.leading().abs() * (1.0 - f64::EPSILON * 8.0) - divisor.radius;
        let radius = if least > 0.0 {
            up((self.radius + (middle.leading().abs() + bound) * divisor.radius) / least + bound)
        } else {
            f64::INFINITY
        };
        Self { middle, radius }
    }

    /// The square root: for any `y > 0`, `|sqrt x - y| = |x - y^2| / (sqrt x + y) <= |x - y^2| / y`.
    pub(crate) fn sqrt(&self) -> Self {
        let root = Self { middle: self.middle.approximate_root(), radius: 0.0 };
        let residual = (self - &(&root * &root)).magnitude();
        let radius = up(residual / (root.leading() * (1.0 - f64::EPSILON * 8.0)));
        Self { radius: if root.leading() > 0.0 { radius } else { f64::INFINITY }, middle: root.middle }
    }
}

impl<T: Real> Add for &Ball<T> {
    type Output = Ball<T>;

    #[inline]
    fn add(self, other: Self) -> Ball<T> {
        let (middle, bound) = self.middle.add(&other.middle);
        Ball { middle, radius: up(self.radius + other.radius + bound) }
    }
}

impl<T: Real> Sub for &Ball<T> {
    type Output = Ball<T>;

    #[inline]
    fn sub(self, other: Self) -> Ball<T> {
        let (middle, bound) = self.middle.subtract(&other.middle);
        Ball { middle, radius: up(self.radius + other.radius + bound) }
    }
}

impl<T: Real> Mul for &Ball<T> {
    type Output = Ball<T>;

    #[inline]
    fn mul(self, other: Self) -> Ball<T> {
        let (middle, bound) = self.middle.multiply(&other.middle);
        let (a, b) = (self.middle.leading().abs(), other.middle.leading().abs());
        Ball { middle, radius: up(a * other.radius + (b + other.radius) * self.radius + bound) }
    }
}

impl<T: Real> Neg for &Ball<T> {
    type Output = Ball<T>;

    fn neg(self) -> Ball<T> {
        Ball { middle: self.middle.negated(), radius: self.radius }
    }
}

/// A vector of balls.
pub(crate) type BallVector<T> = [Ball<T>; 3];

/// `a . b`.
pub(crate) fn dot<T: Real>(a: &BallVector<T>, b: &BallVector<T>) -> Ball<T> {
    &(&(&a[0] * &b[0]) + &(&a[1] * &b[1])) + &(&a[2] * &b[2])
}

/// `a + scale b`.
pub(crate) fn along<T: Real>(a: &BallVector<T>, scale: &Ball<T>, b: &BallVector<T>) -> BallVector<T> {
    std::array::from_fn(|i| &a[i] + &(scale * &b[i]))
}

/// Exact components as balls.
pub(crate) fn vector<T: Real>(exact: &[Exact; 3], bits: usize) -> BallVector<T> {
    std::array::from_fn(|i| Ball::from_exact(&exact[i], bits))
}

/// `pi = 16 atan(1/5) - 4 atan(1/239)` (Machin 1706); each alternating series is cut after a term below the precision, which then
/// bounds the truncation.
pub(crate) fn pi<T: Real>(bits: usize) -> Ball<T> {
    let arctangent_of_inverse = |n: f64| {
        let one = Ball::<T>::from_f64(1.0, bits);
        let square = Ball::from_f64(n * n, bits);
        let mut power = one.divided_by(&Ball::from_f64(n, bits));
        let mut sum = power.clone();
        let cut = libm::scalbn(1.0, -i32::try_from(bits.max(128)).unwrap_or(i32::MAX));
        let mut odd = 1.0;
        let mut positive = false;
        while power.magnitude() > cut {
            power = power.divided_by(&square);
            odd += 2.0;
            let term = power.divided_by(&Ball::from_f64(odd, bits));
            sum = if positive { &sum + &term } else { &sum - &term };
            positive = !positive;
        }
        let last = power.magnitude();
        sum.widened(last)
    };
    let first = &arctangent_of_inverse(5.0) * &Ball::from_f64(16.0, bits);
    &first - &(&arctangent_of_inverse(239.0) * &Ball::from_f64(4.0, bits))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::enclosure::astro::Astro;
    use crate::enclosure::double_double::DoubleDouble;
    use crate::enclosure::interval::Interval;
    use crate::enclosure::limbs::Limbs;

    /// Whether the ball holds the exact number.
    fn holds<T: Real>(ball: &Ball<T>, exact: &Exact) -> bool {
        (&ball.middle.to_exact() - exact).magnitude() <= ball.radius
    }

    fn operations_enclose<T: Real>(bits: usize) {
        let ball = |value: f64, radius: f64| Ball::<T>::from_f64(value, bits).widened(radius);
        for (a, b) in [(0.1, 3.7), (-1e-9, 0.3), (5e7, -1e-7), (1.0, 1.0 + 1e-10)] {
            let (ra, rb) = (1e-3 * f64::abs(a), 1e-12 * f64::abs(b));
            let (x, y) = (ball(a, ra), ball(b, rb));
            for (u, v) in [(a + 0.99 * ra, b - 0.99 * rb), (a - 0.99 * ra, b - 0.99 * rb), (a, b)] {
                let (u, v) = (Exact::from(u), Exact::from(v));
                assert!(holds(&(&x + &y), &(&u + &v)) && holds(&(&x - &y), &(&u - &v)) && holds(&(&x * &y), &(&u * &v)));
                // u/v is in the quotient if u is in the quotient times v.
                let back = &x.divided_by(&y) * &Ball::from_exact(&v, bits);
                assert!(holds(&back, &u), "{a} / {b}");
            }
        }
        assert!(ball(1.0, 0.0).divided_by(&ball(1e-3, 1e-2)).radius.is_infinite());
        let root = ball(2.0, 1e-20).sqrt();
        assert!(holds(&(&root * &root), &Exact::from(2.0)) && root.radius < 1e-19);
        assert!(ball(-1.0, 0.0).sqrt().radius.is_infinite());
    }

    #[test]
    fn operations_enclose_in_every_arithmetic() {
        operations_enclose::<DoubleDouble>(106);
        operations_enclose::<Astro>(192);
    }

    /// All numbers between two doubles.
    fn between<T: Real>(low: f64, high: f64, bits: usize) -> Ball<T> {
        let (low, high) = (Exact::from(low), Exact::from(high));
        let (middle, half) = ((&low + &high).times_power(-1), (&high - &low).times_power(-1).magnitude());
        let ball = Ball::from_exact(&middle, bits);
        if half == 0.0 { ball } else { ball.widened(half) }
    }

    /// Results of interval arithmetic that others recorded: all of each is in the ball, and of points the ball has no more than that
    /// and one double at either end.
    fn vectors_are_enclosed<T: Real>(bits: usize, largest: f64) {
        let (mut points, mut intervals) = (0, 0);
        for line in include_str!("../../../../data/reference/itf1788.txt").lines().filter(|line| !line.starts_with('#')) {
            let (operation, numbers) = line.split_once(' ').unwrap();
            let numbers: Vec<f64> = numbers.split(' ').map(|number| number.parse().unwrap()).collect();
            if numbers.iter().any(|number| number.abs() > largest) {
                continue;
            }
            let (given, expected) = numbers.split_at(numbers.len() - 2);
            let balls: Vec<Ball<T>> = given.chunks(2).map(|ends| between(ends[0], ends[1], bits)).collect();
            let result = match (operation, &balls[..]) {
                ("add", [x, y]) => x + y,
                ("subtract", [x, y]) => x - y,
                ("multiply", [x, y]) => x * y,
                ("divide", [x, y]) => x.divided_by(y),
                ("negate", [x]) => -x,
                ("sqr", [x]) => x * x,
                ("sqrt", [x]) => x.sqrt(),
                ("recip", [x]) => Ball::from_f64(1.0, bits).divided_by(x),
                _ => panic!("{line}"),
            };
            let (low, high) = Interval::new(result.middle.to_exact(), result.radius).bounds();
            assert!(low < expected[0].next_up() && high > expected[1].next_down(), "{line}: {low:e} {high:e}");
            if given.chunks(2).all(|ends| ends[0] == ends[1]) {
                // A ball grows by the least normal double, which covers underflow.
                let (least, most) = (expected[0].next_down() - f64::MIN_POSITIVE, expected[1].next_up() + f64::MIN_POSITIVE);
                assert!(low >= least && high <= most, "{line}: {low:e} {high:e}");
                points += 1;
            }
            intervals += 1;
        }
        assert!(points >= 10 && intervals > 60, "{points} {intervals}");
    }

    #[test]
    fn test_vectors_of_interval_arithmetic_are_enclosed() {
        vectors_are_enclosed::<DoubleDouble>(106, 1e150);
        vectors_are_enclosed::<Limbs<3>>(192, f64::MAX);
        vectors_are_enclosed::<Astro>(192, f64::MAX);
    }

    #[test]
    fn pi_is_enclosed() {
        // Pi to 48 digits, as the sum of three doubles.
        let (first, second) = (Exact::from(std::f64::consts::PI), Exact::from(1.2246467991473532e-16));
        let truth = &(&first + &second) + &Exact::from(-2.9947698097183397e-33);
        for ball in [pi::<DoubleDouble>(106).middle.to_exact(), pi::<Astro>(192).middle.to_exact()] {
            assert!((&ball - &truth).magnitude() < 2e-31);
        }
        assert!(holds(&pi::<Astro>(128).widened(1e-47), &truth) && pi::<Astro>(128).radius < 1e-36);
        assert!(holds(&pi::<DoubleDouble>(106), &truth) && pi::<DoubleDouble>(106).radius < 1e-29);
    }
}
