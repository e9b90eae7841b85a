//! The operations of the closed forms on lanes of doubles.

#[cfg(target_arch = "x86_64")]
use fearless_simd::Level;
use fearless_simd::prelude::*;
use fearless_simd::{Simd, f64x4, f64x8};

use crate::arithmetic::{Arithmetic, Doubles};
use crate::double_double::DoubleDouble;
use crate::double_double_on_lanes::SideBySide;
use crate::lanes::instruction_set::apart;
use crate::lanes::lane::{Lanes, Mask};
use crate::series::{clausen, sine};
use crate::{arc_tangent, arithmetic, logarithm};

/// Splits numbers by arithmetic on the bits: an integer in the last ones of 2^52 gives the double that exceeds 2^52 by it.
#[inline(always)]
fn exponent_and_mantissa<S: Simd, V: SimdFloat<S, Element = f64>>(simd: S, x: V) -> (V, V) {
    let bits = x.to_bits();
    let exponent = V::from_bits((bits >> 52) | (1075 << 52)) - V::splat(simd, ((1u64 << 52) + 1023) as f64);
    (exponent, V::from_bits((bits & ((1 << 52) - 1)) | (1023 << 52)))
}

/// Whether vectors surely have a fused multiply-add, known when code is compiled for them.
#[inline(always)]
fn fuses<S: Simd>(simd: S) -> bool {
    #[cfg(target_arch = "x86_64")]
    {
        matches!(simd.level(), Level::Avx2(_) | Level::Avx512(_))
    }
    #[cfg(not(target_arch = "x86_64"))]
    {
        let _ = simd;
        false
    }
}

/// As [`Doubles::run`]: without a fused multiply-add double-doubles take four times the code.
#[inline(always)]
fn run<S: Simd, A, R>(simd: S, arguments: A, operation: impl Fn(A) -> R) -> R {
    if fuses(simd) { operation(arguments) } else { apart(simd, arguments, operation) }
}

/// The same in batches, whose kernels have few double-doubles.
#[inline(always)]
fn run_in_place<S: Simd, A, R>(_: S, arguments: A, operation: impl Fn(A) -> R) -> R {
    operation(arguments)
}

/// The constants of a row, the `i`-th of each entry, in as many lanes as `like` has.
#[inline(always)]
fn in_row<T: Arithmetic>(like: T, [a, b, c]: &[[f64; 3]; 3], i: usize, [some, more]: [T::Mask; 2]) -> T {
    T::choose(more, like.like(c[i]), T::choose(some, like.like(b[i]), like.like(a[i])))
}

/// The `i`-th constants of entries, as [`Doubles::entry`].
#[inline(always)]
fn in_table<T: Arithmetic>(
    like: T,
    table: &[[[f64; 3]; 3]; 4],
    i: usize,
    (high, low): (T::Mask, Option<T::Mask>),
    column: [T::Mask; 2],
) -> T {
    let (mut first, mut second) = (in_row(like, &table[0], i, column), in_row(like, &table[2], i, column));
    if let Some(low) = low {
        first = T::choose(low, in_row(like, &table[1], i, column), first);
        second = T::choose(low, in_row(like, &table[3], i, column), second);
    }
    T::choose(high, second, first)
}

/// Functions and closures that vector code calls are always inlined: a function compiled apart has none of the vector's
/// instructions. So no `map` of arrays.
///
/// For a vector, or for a type that wraps one in its field 0.
macro_rules! arithmetic_on_lanes {
    ($type:ty, $mask:ty, $wrap:path, $wrap_mask:path, $run:path $(, $field:tt)?) => {
        impl<S: Simd> Arithmetic for $type {
            type Mask = $mask;
            const IS_DOUBLE: bool = true;

            #[inline(always)]
            fn like(self, constant: f64) -> Self {
                $wrap(SimdBase::splat(self$(.$field)?.token(), constant))
            }
            #[inline(always)]
            fn like_pi(self) -> Self {
                self.like(std::f64::consts::PI)
            }
            #[inline(always)]
            fn exceeds(self, other: Self) -> Self::Mask {
                $wrap_mask(self$(.$field)?.simd_gt(other$(.$field)?))
            }
            #[inline(always)]
            fn choose(mask: Self::Mask, set: Self, unset: Self) -> Self {
                $wrap(mask$(.$field)?.select(set$(.$field)?, unset$(.$field)?))
            }
            #[inline(always)]
            fn choose_of(mask: Self::Mask, set: impl FnOnce() -> Self, unset: impl FnOnce() -> Self) -> Self {
                Self::choose(mask, set(), unset())
            }
            #[inline(always)]
            fn abs(self) -> Self {
                $wrap(SimdBase::abs(self$(.$field)?))
            }
            #[inline(always)]
            fn sqrt(self) -> Self {
                $wrap(SimdFloat::sqrt(self$(.$field)?))
            }
            #[inline(always)]
            fn ln(self) -> Self {
                logarithm::of_normal(self)
            }
            #[inline(always)]
            fn atan2(self, x: Self) -> Self {
                arc_tangent::angle::<Self, true>(self, x)
            }
            #[inline(always)]
            fn atan2_right(self, x: Self) -> Self {
                arc_tangent::angle::<Self, false>(self, x)
            }
            #[inline(always)]
            fn clausen_rest(self) -> Self {
                let square = self * self;
                self * square * clausen::double_sum(square)
            }
            #[inline(always)]
            fn sine_series(square: Self) -> Self {
                sine::double_sum(square) * square.like(12.0)
            }
            #[inline(always)]
            fn known_to(self, _: f64) -> Self {
                self
            }
        }

        impl<S: Simd> Doubles for $type {
            #[inline(always)]
            fn min(self, other: Self) -> Self {
                $wrap(SimdBase::min(self$(.$field)?, other$(.$field)?))
            }
            #[inline(always)]
            fn max(self, other: Self) -> Self {
                $wrap(SimdBase::max(self$(.$field)?, other$(.$field)?))
            }
            #[inline(always)]
            fn product_error(self, other: Self, product: Self) -> Self {
                if fuses(self$(.$field)?.token()) {
                    $wrap(SimdFloat::mul_sub(self$(.$field)?, other$(.$field)?, product$(.$field)?))
                } else {
                    arithmetic::product_error(self, other, product)
                }
            }
            #[inline(always)]
            fn run<A, R>(self, arguments: A, operation: impl Fn(A) -> R) -> R {
                $run(self$(.$field)?.token(), arguments, operation)
            }
            #[inline(always)]
            fn exponent_and_mantissa(self) -> (Self, Self) {
                let (exponent, mantissa) = exponent_and_mantissa(self$(.$field)?.token(), self$(.$field)?);
                ($wrap(exponent), $wrap(mantissa))
            }
            #[inline(always)]
            fn entry(
                self,
                table: &[[[f64; 3]; 3]; 4],
                row: (Self::Mask, Option<Self::Mask>),
                column: [Self::Mask; 2],
            ) -> [Self; 3] {
                [in_table(self, table, 0, row, column), in_table(self, table, 1, row, column), in_table(self, table, 2, row, column)]
            }
        }
    };
}

arithmetic_on_lanes!(f64x4<S>, fearless_simd::mask64x4<S>, std::convert::identity, std::convert::identity, run);
arithmetic_on_lanes!(f64x8<S>, fearless_simd::mask64x8<S>, std::convert::identity, std::convert::identity, run);
arithmetic_on_lanes!(Lanes<S, f64>, Mask<S, f64>, Lanes, Mask, run_in_place, 0);

/// Implements [`SideBySide`] for double-doubles on a vector.
macro_rules! side_by_side {
    ($type:ty) => {
        impl<S: Simd> SideBySide for $type {
            #[inline(always)]
            fn apart<const N: usize>(
                arguments: [DoubleDouble<Self>; N],
                function: impl Fn([DoubleDouble<Self>; N]) -> DoubleDouble<Self>,
            ) -> DoubleDouble<Self> {
                apart(arguments[0].hi.token(), arguments, function)
            }
        }
    };
}

side_by_side!(f64x4<S>);
side_by_side!(f64x8<S>);

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use rand::{RngExt, SeedableRng, rngs::ChaCha8Rng};

    use super::*;
    use crate::dilogarithm;
    use crate::lanes::instruction_set::instruction_sets;
    use crate::on_instruction_set;

    #[inline(always)]
    fn every_function<S: Simd>(simd: S, [y, x, t]: [f64; 3]) -> [f64; 4] {
        let splat = |value: f64| f64x4::splat(simd, value);
        [splat(y).atan2(splat(x))[0], splat(y).atan2_right(splat(x.abs()))[1], splat(y).ln()[2], splat(t).clausen_rest()[3]]
    }

    #[test]
    fn lanes_have_the_digits_of_the_scalar_functions() {
        let mut random = ChaCha8Rng::seed_from_u64(6);
        for i in 0..40_000 {
            let spread = [1e-12, 1e-3, 1.0, 30.0, 200.0][i % 5];
            let mut power = || libm::exp(random.random_range(-spread..spread));
            let ratio = [power(), 0.25 * power(), 0.75 * power(), power()][i % 4];
            let (x, small) = (power(), libm::exp(-power().min(700.0)));
            let y = x * ratio;
            let x = if i % 3 == 0 { -x } else { x };
            let t = [random.random_range(-PI..PI) * 0.5, 0.5 * PI - small, small][i % 3];
            let scalars =
                [arc_tangent::atan2(y, x), arc_tangent::atan2(y, x.abs()), logarithm::ln(y), dilogarithm::clausen_rest(t)];
            for level in instruction_sets() {
                assert_eq!(on_instruction_set!(level, simd => every_function(simd, [y, x, t])), scalars, "{y:e} {x:e} {t:e}");
            }
        }
    }
}
