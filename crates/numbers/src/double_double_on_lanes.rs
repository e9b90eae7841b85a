//! Double-doubles as numbers that a closed form is written on, several side by side on the lanes of a vector.
//!
//! Sums and products are those of one double-double. Quotients, roots and functions have no branch, and terms below 2^-44 of a
//! series are summed in plain double precision.
//!
//! # Bound
//! Every result here is within [`ROUNDOFF_ON_LANES`], V = 2^-94, relative; u = 2^-53.
//! - Sum 3u^2 and product 8u^2, as on one double-double. Quotient: with `q = a_0/b_0` rounded, `a_0 - q b_0` is exact in two parts,
//!   and `a - q b` errs by `(1 + 2 + 4 + 5) u^2` of a in its four sums and products; divided by `b_0` instead of b it gives the rest,
//!   at most 5u of the quotient, to 2u: below 32u^2. Root: likewise `2.5u^2 + 3u^2` and u^2 for the square of the step, below 8u^2.
//! - A step of Horner's rule, `c + z s` with `|z s| <= |c|/4`, errs by `2u^2` from the product and `4u^2` from the sum; the next
//!   step multiplies the error by a quarter at most: below 12u^2 in all.
//! - The terms in plain double precision begin below 2^-44.4 of the first (of the arc tangent; 2^-44.7, 2^-45.8 and 2^-46.6 of the
//!   logarithm, the sine and Clausen's function), fall by a factor of 4 at least and err by 4u of themselves: 2^-95 in all. The terms
//!   left out are below 2^-97 together.
//! - So the arc tangent of s, `|s| <= 1/4`, errs by `2^-94.9` and s by 40u^2 of itself; the table's angle, from 0.46 up where it is not
//!   0, adds 2^-107 and a sum. Of the logarithm, `k ln 2 + ln m`, `|ln m| <= |ln x|`, and `|k ln 2| <= 2 |ln x|`.

use std::ops::Div;

use crate::arc_tangent::FROM;
use crate::arithmetic::{Arithmetic, Doubles};
use crate::double_double::functions::{LN_2, RECIPROCALS};
use crate::double_double::{DoubleDouble, fast_two_sum, two_product};
use crate::series::clausen;
use crate::series::sine::SINE_SERIES;

/// Bound on the relative error of any operation and function on lanes, V.
pub const ROUNDOFF_ON_LANES: f64 = 1.0 / (1u128 << 94) as f64;

/// Terms in double-double and terms in all: of the arc tangent, `z <= 1/16`; of the logarithm, `z <= 0.0295`; of the sine, `z <= 1`;
/// of Clausen's function, `z <= (pi/2)^2`.
const ARC_TANGENT: [usize; 2] = [10, 23];
const LOGARITHM: [usize; 2] = [8, 19];
const SINE: [usize; 2] = [7, 14];
const CLAUSEN: [usize; 2] = [21, 49];

/// Doubles on lanes.
pub trait SideBySide: Doubles {
    /// A function, compiled once and called: it is long, and used in many places.
    fn apart<const N: usize>(
        arguments: [DoubleDouble<Self>; N],
        function: impl Fn([DoubleDouble<Self>; N]) -> DoubleDouble<Self>,
    ) -> DoubleDouble<Self>;
}

/// `sum c_k z^k`.
#[inline(always)]
fn series<T: SideBySide>(
    z: DoubleDouble<T>,
    [wide, count]: [usize; 2],
    coefficient: impl Fn(usize) -> DoubleDouble,
    plain: impl Fn(usize) -> f64,
) -> DoubleDouble<T> {
    let mut tail = z.hi.like(plain(count - 1));
    for k in (wide..count - 1).rev() {
        tail = tail * z.hi + z.hi.like(plain(k));
    }
    let mut sum = DoubleDouble { hi: tail, lo: tail.like(0.0) };
    for k in (0..wide).rev() {
        let (c, product) = (z.same(coefficient(k)), sum * z);
        let (hi, lo) = fast_two_sum(c.hi, product.hi);
        let (hi, lo) = fast_two_sum(hi, lo + (c.lo + product.lo));
        sum = DoubleDouble { hi, lo };
    }
    sum
}

impl<T: SideBySide> DoubleDouble<T> {
    /// A number, the same on each lane.
    #[inline(always)]
    fn same(self, DoubleDouble { hi, lo }: DoubleDouble) -> Self {
        Self { hi: self.hi.like(hi), lo: self.hi.like(lo) }
    }

    /// Times powers of two, or 0: exact.
    #[inline(always)]
    fn times(self, powers: T) -> Self {
        Self { hi: self.hi * powers, lo: self.lo * powers }
    }

    /// `2 artanh((m - 1)/(m + 1)) + k ln 2`, m from the root of 1/2 to that of 2.
    #[inline(always)]
    fn logarithm(self) -> Self {
        let (exponent, mantissa) = self.hi.exponent_and_mantissa();
        let is_large = mantissa.exceeds(self.hi.like(std::f64::consts::SQRT_2));
        let (one, half) = (self.hi.like(1.0), self.hi.like(0.5));
        let power = mantissa / self.hi * T::choose(is_large, half, one);
        let (m, k) = (self.times(power), exponent + T::choose(is_large, one, self.hi.like(0.0)));
        let s = (m - self.like(1.0)) / (m + self.like(1.0));
        let sum = series(
            s * s,
            LOGARITHM,
            #[inline(always)]
            |k| RECIPROCALS[k],
            #[inline(always)]
            |k| 1.0 / (2 * k + 1) as f64,
        );
        (s * sum).times(self.hi.like(2.0)) + self.same(LN_2) * Self { hi: k, lo: self.hi.like(0.0) }
    }

    /// As [`crate::arc_tangent::angle`].
    #[inline(always)]
    fn angle<const LEFT: bool>(self, x: Self) -> Self {
        let (y, run) = (self, Arithmetic::abs(x));
        let (steep, left) = (y.exceeds(run), x.like(0.0).exceeds(x));
        let (small, large) = (Self::choose(steep, run, y), Self::choose(steep, y, run));
        let limit = |share: f64| small.hi.exceeds(x.hi.like(share) * large.hi);
        let octant = (steep, if LEFT { Some(left) } else { None });
        let [c, from, rest] = x.hi.entry(&FROM, octant, [limit(0.25), limit(0.75)]);
        let s = (small - large.times(c)) / (large + small.times(c));
        let s = Self::choose(if LEFT { steep ^ left } else { steep }, -s, s);
        let sum = series(
            -(s * s),
            ARC_TANGENT,
            #[inline(always)]
            |k| RECIPROCALS[k],
            #[inline(always)]
            |k| 1.0 / (2 * k + 1) as f64,
        );
        Self { hi: from, lo: rest } + s * sum
    }
}

impl<T: SideBySide> Div for DoubleDouble<T> {
    type Output = Self;
    #[inline(always)]
    fn div(self, divisor: Self) -> Self {
        self.hi.run(
            [self, divisor],
            #[inline(always)]
            |[a, b]| {
                let first = a.hi / b.hi;
                let (product, error) = two_product(first, b.hi);
                let remainder = ((a.hi - product) - (error + first * b.lo)) + a.lo;
                let (hi, lo) = fast_two_sum(first, remainder / b.hi);
                Self { hi, lo }
            },
        )
    }
}

impl<T: SideBySide> Arithmetic for DoubleDouble<T> {
    type Mask = T::Mask;
    const IS_DOUBLE: bool = false;

    #[inline(always)]
    fn like(self, constant: f64) -> Self {
        self.same(DoubleDouble { hi: constant, lo: 0.0 })
    }

    #[inline(always)]
    fn like_pi(self) -> Self {
        self.same(DoubleDouble::pi())
    }

    #[inline(always)]
    fn exceeds(self, other: Self) -> Self::Mask {
        self.hi.exceeds(other.hi)
    }

    #[inline(always)]
    fn choose(mask: Self::Mask, set: Self, unset: Self) -> Self {
        Self { hi: T::choose(mask, set.hi, unset.hi), lo: T::choose(mask, set.lo, unset.lo) }
    }

    #[inline(always)]
    fn choose_of(mask: Self::Mask, set: impl FnOnce() -> Self, unset: impl FnOnce() -> Self) -> Self {
        Self::choose(mask, set(), unset())
    }

    #[inline(always)]
    fn abs(self) -> Self {
        Self::choose(self.hi.like(0.0).exceeds(self.hi), -self, self)
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        self.hi.run(
            self,
            #[inline(always)]
            |a| {
                let root = a.hi.sqrt();
                let (square, error) = two_product(root, root);
                let remainder = ((a.hi - square) - error) + a.lo;
                let (hi, lo) = fast_two_sum(root, remainder / (root + root));
                Self { hi, lo }
            },
        )
    }

    #[inline(always)]
    fn ln(self) -> Self {
        T::apart(
            [self],
            #[inline(always)]
            |[x]| x.logarithm(),
        )
    }

    #[inline(always)]
    fn atan2(self, x: Self) -> Self {
        T::apart(
            [self, x],
            #[inline(always)]
            |[y, x]| y.angle::<true>(x),
        )
    }

    #[inline(always)]
    fn atan2_right(self, x: Self) -> Self {
        T::apart(
            [self, x],
            #[inline(always)]
            |[y, x]| y.angle::<false>(x),
        )
    }

    #[inline(always)]
    fn clausen_rest(self) -> Self {
        T::apart(
            [self],
            #[inline(always)]
            |[x]| {
                let square = x * x;
                let sum = series(
                    square,
                    CLAUSEN,
                    #[inline(always)]
                    |k| clausen::SERIES[k],
                    #[inline(always)]
                    |k| clausen::SERIES[k].hi,
                );
                x * square * sum
            },
        )
    }

    #[inline(always)]
    fn sine_series(square: Self) -> Self {
        series(
            square,
            SINE,
            #[inline(always)]
            |k| SINE_SERIES[k],
            #[inline(always)]
            |k| SINE_SERIES[k].hi,
        )
    }

    #[inline(always)]
    fn known_to(self, _: f64) -> Self {
        self
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::FRAC_PI_2;

    use fearless_simd::prelude::*;
    use fearless_simd::{Simd, f64x4};
    use rand::{RngExt, SeedableRng, rngs::ChaCha8Rng};

    use super::*;
    use crate::dilogarithm;
    use crate::lanes::instruction_set::instruction_sets;
    use crate::on_instruction_set;

    /// The functions of two numbers: sum, difference, product, quotient and root, logarithm, both arc tangents, Clausen's of the
    /// third, and the series of the sine of a fourth.
    #[inline(always)]
    fn every_function<S: Simd>(simd: S, numbers: [DoubleDouble; 4]) -> [DoubleDouble; 10] {
        let splat = |c: DoubleDouble| DoubleDouble { hi: f64x4::splat(simd, c.hi), lo: f64x4::splat(simd, c.lo) };
        let [a, b, t, square] = [splat(numbers[0]), splat(numbers[1]), splat(numbers[2]), splat(numbers[3])];
        let one = |c: DoubleDouble<f64x4<S>>| DoubleDouble { hi: c.hi[2], lo: c.lo[2] };
        [
            one(a + b),
            one(a - b),
            one(a * b),
            one(a / b),
            one(a.sqrt()),
            one(a.ln()),
            one(a.atan2(-b)),
            one(a.atan2_right(b)),
            one(t.clausen_rest()),
            one(DoubleDouble::sine_series(square)),
        ]
    }

    #[test]
    fn lanes_err_by_less_than_their_roundoff_and_alike_on_every_instruction_set() {
        let mut random = ChaCha8Rng::seed_from_u64(3);
        let mut worst = [0.0f64; 10];
        for i in 0..40_000 {
            let spread = [1e-9, 1e-3, 1.0, 30.0, 200.0][i % 5];
            let mut power = || libm::exp(random.random_range(-spread..spread));
            let (first, ratio) = (power(), [power(), 0.25 * power(), 0.75 * power(), power()][i / 5 % 4]);
            let mut fine = |hi: f64| DoubleDouble::from(hi) + DoubleDouble::from(hi * 1e-16 * random.random_range(-1.0..1.0));
            let (a, b) = (fine(first), fine(first * ratio));
            let t = fine(FRAC_PI_2 * libm::exp(-((i % 97) as f64) * 0.1));
            let square = fine(libm::exp(-((i % 89) as f64) * 0.2));
            let series = SINE_SERIES.iter().rev().fold(DoubleDouble::from(0.0), |sum, c| sum * square + *c);
            let truth = [
                a + b,
                a - b,
                a * b,
                a.divided_by(b),
                DoubleDouble::sqrt(a),
                DoubleDouble::ln(a),
                DoubleDouble::atan2(a, -b),
                DoubleDouble::atan2(a, b),
                dilogarithm::clausen_rest(t),
                series,
            ];
            let mut first = None;
            for level in instruction_sets() {
                let results = on_instruction_set!(level, simd => every_function(simd, [a, b, t, square]));
                assert_eq!(*first.get_or_insert(results), results, "{level:?}");
            }
            for ((worst, number), truth) in worst.iter_mut().zip(first.unwrap()).zip(truth) {
                let error = (number - truth).hi.abs();
                let relative = if truth.hi == 0.0 { error } else { error / truth.hi.abs() };
                *worst = worst.max(relative / ROUNDOFF_ON_LANES);
            }
        }
        println!("worst, in units: {worst:.5?}");
        // The truths err by 64 units of double-double, an eighth of this one, at most.
        assert!(worst.iter().all(|worst| *worst < 0.85), "{worst:?}");
        assert!(worst[6..].iter().all(|worst| *worst > 1e-3), "{worst:?}");
    }
}
