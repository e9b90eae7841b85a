//! Logarithms on lanes, without a branch.
//!
//! A positive normal number is `2^k m` with m between the root of 1/2 and that of 2: `ln = k ln 2 + ln m`. With `f = m - 1`, exact,
//! and `s = f/(2 + f)`,
//!
//! `ln m = 2 artanh s = 2 s + 2 s^3 L(s^2) = f - s (f - 2 s^2 L)`.
//!
//! L has minimal largest relative error on `[0, 0.0295]`, found by Remez' algorithm in 60 digits (weight `s^3/artanh s`),
//! coefficients rounded to nearest: 2^-59.3 for the seven of double precision, 2^-30.2 for the three of single precision. `ln 2` is
//! kept in two parts, the first short enough for its product with k to be exact.
//!
//! # Error
//! For k = 0 the subtraction from f rounds by half an ulp, and what is subtracted, at most 0.21 of f, errs by 4u relative: below
//! 1.4 ulp. Else the two parts are at most a third apart from their sum, which rounds by half an ulp: below 1.5 ulp. The tests
//! measure 0.95; [`LOGARITHM_ULP`] is what bounds assume.

use fearless_simd::{Simd, SimdFloatElement};

use super::lanes::{Lane, Lanes, constant};

/// Largest error of a logarithm in units in the last place, assumed by the bounds.
pub(super) const LOGARITHM_ULP: f64 = 2.0;

/// What depends on the precision.
#[derive(Debug, Clone, Copy)]
pub(super) struct Logarithm<F: SimdFloatElement + 'static> {
    polynomial: &'static [F],
    /// `ln 2`, the first part with as many zeros at its end as an exponent has bits.
    ln_2: [F; 2],
    pub(super) mantissa_bits: u32,
    /// The mantissa's bits, and those of 1.
    pub(super) mantissa: F::Bits,
    pub(super) one: F::Bits,
    /// A number whose last bits count in units: an integer in them is added to it; the number less the bias of exponents.
    pub(super) magic: F::Bits,
    pub(super) magic_value: F,
}

impl Logarithm<f64> {
    pub(super) const DOUBLE: Self = Self {
        polynomial: &[
            0.333_333_333_333_336_7,
            0.199_999_999_997_081_87,
            0.142_857_143_710_075_38,
            0.111_110_993_054_163_94,
            0.090_917_812_012_224_83,
            0.076_570_494_530_767_54,
            0.073_977_372_213_670_64,
        ],
        ln_2: [f64::from_bits(0x3fe6_2e42_fefa_3800), 5.497_923_018_708_371e-14],
        mantissa_bits: 52,
        mantissa: (1 << 52) - 1,
        one: 1023 << 52,
        magic: 1075 << 52,
        magic_value: ((1u64 << 52) + 1023) as f64,
    };
}

impl Logarithm<f32> {
    pub(super) const SINGLE: Self = Self {
        polynomial: &[0.333_333_88, 0.199_887_87, 0.149_354_7],
        ln_2: [f32::from_bits(0x3f31_7200), 1.428_606_8e-6],
        mantissa_bits: 23,
        mantissa: (1 << 23) - 1,
        one: 127 << 23,
        magic: 150 << 23,
        magic_value: ((1 << 23) + 127) as f32,
    };
}

/// Natural logarithm of a positive normal number.
#[inline(always)]
pub(super) fn logarithm<S: Simd, F: Lane>(simd: S, number: Lanes<S, F>) -> Lanes<S, F> {
    let Logarithm { polynomial, ln_2, .. } = F::LOGARITHM;
    let (exponent, mantissa) = number.split(simd);
    let high = constant(simd, std::f64::consts::SQRT_2).below(mantissa);
    let mantissa = high.select(mantissa * constant(simd, 0.5), mantissa);
    let exponent = high.select(exponent + constant(simd, 1.0), exponent);
    let f = mantissa - constant(simd, 1.0);
    let s = f / (f + constant(simd, 2.0));
    let square = s * s;
    let series = square * square.polynomial(simd, polynomial);
    let less = s * (f - (series + series));
    exponent * Lanes::all(simd, ln_2[0]) + (f - (less - exponent * Lanes::all(simd, ln_2[1])))
}

#[cfg(test)]
mod tests {
    use fearless_simd::{Level, dispatch};
    use rand::{RngExt, SeedableRng, rngs::ChaCha8Rng};

    use super::*;
    use crate::double_double::DoubleDouble;
    use crate::level::levels;

    fn logarithms<F: Lane>(level: Level, x: &[F], out: &mut [F]) {
        #[inline(always)]
        fn run<S: Simd, F: Lane>(simd: S, x: &[F], out: &mut [F]) {
            let width = Lanes::<S, F>::COUNT;
            for (x, out) in x.chunks(width).zip(out.chunks_mut(width)) {
                logarithm(simd, Lanes::load(simd, x)).store(out);
            }
        }
        dispatch!(level, simd => run(simd, x, out));
    }

    /// Numbers of all exponents, of ordinary size, next to 1 and next to where the exponent changes.
    fn strata(count: usize) -> Vec<f64> {
        let mut random = ChaCha8Rng::seed_from_u64(4);
        let number = |i: usize| match i % 5 {
            0 => libm::exp(random.random_range(-708.0..709.0)),
            1 => libm::exp(random.random_range(-3.0..3.0)),
            2 => 1.0 + random.random_range(-1.0..1.0) * libm::exp(random.random_range(-36.0..-1.0)),
            3 => [std::f64::consts::SQRT_2, 2.0, 1.0][i / 5 % 3] * (1.0 + f64::from(random.random_range(-8..8)) * f64::EPSILON),
            _ => random.random_range(0.5..2.0),
        };
        (0..count).map(number).collect()
    }

    #[test]
    fn logarithms_in_double_precision_err_by_less_than_the_bounds_assume() {
        let x = strata(1_000_000);
        let mut out = vec![0.0; x.len()];
        logarithms(Level::new(), &x, &mut out);
        let mut worst = (0.0, 0.0);
        for (x, value) in x.iter().zip(&out) {
            if *x == 1.0 {
                assert_eq!(*value, 0.0);
                continue;
            }
            let size = value.abs();
            let error = (DoubleDouble::from(*value) - DoubleDouble::from(*x).ln()).to_f64().abs() / (size.next_up() - size);
            if error > worst.0 || error.is_nan() {
                worst = (error, *x);
            }
        }
        println!("{:.3} ulp at {:e}", worst.0, worst.1);
        assert!(worst.0 <= LOGARITHM_ULP, "{} ulp at {:e}", worst.0, worst.1);
    }

    #[test]
    fn all_levels_give_the_same_digits() {
        let x = strata(10_000);
        let single_x: Vec<f32> = x.iter().map(|v| f32::nearest(v.clamp(1e-37, 1e38))).collect();
        let mut first: Option<(Vec<u64>, Vec<u32>)> = None;
        for level in levels() {
            let (mut double, mut single) = (vec![0.0; x.len()], vec![0.0; x.len()]);
            logarithms(level, &x, &mut double);
            logarithms(level, &single_x, &mut single);
            let bits = (double.iter().map(|v| v.to_bits()).collect(), single.iter().map(|v| v.to_bits()).collect());
            assert_eq!(*first.get_or_insert(bits.clone()), bits, "{level:?}");
        }
    }

    /// Every number of single precision in [1/4, 4], and every mantissa at some other exponents.
    #[test]
    fn logarithms_in_single_precision_err_by_less_than_the_bounds_assume() {
        const TILE: usize = 1 << 13;
        let mut worst = 0.0f64;
        let (mut x, mut out, mut exact) = (vec![0.0f32; TILE], vec![0.0f32; TILE], vec![0.0; TILE]);
        for exponent in [1, 30, 90, 125, 126, 127, 128, 150, 200, 254u32] {
            for start in (0..1 << 23).step_by(TILE) {
                for (i, x) in (start..).zip(x.iter_mut()) {
                    *x = f32::from_bits((exponent << 23) | i);
                }
                let wide: Vec<f64> = x.iter().map(|v| f64::from(*v)).collect();
                logarithms(Level::new(), &x, &mut out);
                logarithms(Level::new(), &wide, &mut exact);
                for (value, exact) in out.iter().zip(&exact) {
                    let ulp = f64::from(value.abs().next_up() - value.abs());
                    worst = worst.max((f64::from(*value) - exact).abs() / ulp);
                }
            }
        }
        println!("{worst:.3} ulp");
        assert!(worst <= LOGARITHM_ULP, "{worst} ulp");
    }
}
