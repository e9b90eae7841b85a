//! The natural logarithm in double precision, with a proven error and the same digits on every machine.
//!
//! A positive normal number is `2^k m` with m between the root of 1/2 and that of 2: `ln = k ln 2 + ln m`. With `f = m - 1`,
//! exact, and `s = f/(2 + f)`, `ln m = 2 artanh s = 2s + 2 s^3 L(s^2) = f - s (f - 2 s^2 L)`. L has the least largest relative
//! error on `[0, 0.0295]` by Remez's algorithm (weight `s^3/artanh s`): 2^-59.3 with rounded coefficients. `ln 2` is kept in two
//! parts, the first short enough for its product with k to be exact. One division; the only branch is for arguments that are not
//! normal numbers.
//!
//! # Bound
//! For k = 0 the subtraction from f rounds by half an ulp, and the subtrahend, at most 0.21 of f, errs by 4u relative: below 1.4
//! ulp. Else the two parts are at most a third apart from their sum, which rounds by half an ulp: below 1.5 ulp, 3u.

use crate::arithmetic::Doubles;
use crate::series::seven_terms;

/// Bound on the error of a logarithm, in units of roundoff of it, proved by `cargo xtask prove` from [`TRUNCATION`].
pub const UNITS: f64 = 3.0;

/// Largest relative error of `ln m`, by Remez's algorithm and with 120 digits: above 2^-59.3; and of `LN_2_PARTS` together.
pub const TRUNCATION: [f64; 2] = [1.42e-18, 1.0 / (1u128 << 96) as f64];

/// L in powers of `s^2`.
const ARTANH: [f64; 7] = [
    0.333_333_333_333_336_7,
    0.199_999_999_997_081_87,
    0.142_857_143_710_075_38,
    0.111_110_993_054_163_94,
    0.090_917_812_012_224_83,
    0.076_570_494_530_767_54,
    0.073_977_372_213_670_64,
];

/// `ln 2` in two parts, the first with eleven zeros at its end.
const LN_2_PARTS: [f64; 2] = [f64::from_bits(0x3fe6_2e42_fefa_3800), 5.497_923_018_708_371e-14];

/// Natural logarithm.
#[inline(always)]
pub fn ln(x: f64) -> f64 {
    if !(f64::MIN_POSITIVE..f64::INFINITY).contains(&x) {
        return libm::log(x);
    }
    of_normal(x)
}

/// The same of positive normal numbers.
#[inline(always)]
pub fn of_normal<T: Doubles>(x: T) -> T {
    let (exponent, mantissa) = x.exponent_and_mantissa();
    let high = mantissa.exceeds(x.like(std::f64::consts::SQRT_2));
    let f = T::choose(high, mantissa * x.like(0.5), mantissa) - x.like(1.0);
    let k = T::choose(high, exponent + x.like(1.0), exponent);
    let s = f / (f + x.like(2.0));
    let z = s * s;
    let series = z * seven_terms(&ARTANH, z);
    k * x.like(LN_2_PARTS[0]) + (f - (s * (f - (series + series)) - k * x.like(LN_2_PARTS[1])))
}

#[cfg(test)]
mod tests {
    use astro_float::{BigFloat, Consts, RoundingMode};
    use rand::{RngExt, SeedableRng, rngs::ChaCha8Rng};

    use super::*;
    use crate::double_double::DoubleDouble;
    use crate::number::{Number, ROUNDOFF};

    const BITS: usize = 192;
    const NEAREST: RoundingMode = RoundingMode::ToEven;

    #[test]
    fn the_logarithm_errs_by_less_than_its_bound() {
        let mut consts = Consts::new().unwrap();
        let mut random = ChaCha8Rng::seed_from_u64(4);
        let mut worst = 0.0f64;
        for i in 0..6000 {
            let spread = [1e-15, 1e-8, 1e-3, 0.3, 1.0, 700.0][i % 6];
            let x = match i % 11 {
                0 => {
                    (std::f64::consts::SQRT_2 * (1.0 + 1e-15 * random.random_range(-9.0..9.0)))
                        * 2f64.powi(random.random_range(-3..3))
                }
                _ => libm::exp(random.random_range(-spread..spread)),
            };
            let truth = BigFloat::from_f64(x, BITS).ln(BITS, NEAREST, &mut consts);
            let difference: f64 = BigFloat::from_f64(ln(x), BITS).sub(&truth, BITS, NEAREST).to_string().parse().unwrap();
            worst = worst.max(if x == 1.0 { difference } else { (difference / ln(x) / ROUNDOFF).abs() });
        }
        println!("{worst:.3} units");
        assert!(worst < <f64 as Number>::LIBRARY_UNITS, "{worst}");
    }

    /// Against double-double, which is held against arbitrary precision itself.
    #[test]
    fn a_million_strata_of_mantissas_and_exponents_err_by_less_than_two_ulp() {
        let mut random = ChaCha8Rng::seed_from_u64(5);
        let mut worst = (0.0, 0.0);
        const STRATA: u32 = 1 << 20;
        for stratum in 0..STRATA {
            let mantissa = 1.0 + (f64::from(stratum) + random.random_range(0.0..1.0)) / f64::from(STRATA);
            // Every other one near 1, where the logarithm is small.
            let exponent = if stratum % 2 == 0 { random.random_range(-1..=0) } else { random.random_range(-1000..1000) };
            let x = mantissa * 2f64.powi(exponent);
            let (value, truth) = (ln(x), DoubleDouble::from(x).ln());
            let error = ((DoubleDouble::from(value) - truth).hi / (value.abs().next_up() - value.abs())).abs();
            if error > worst.0 {
                worst = (error, x);
            }
        }
        println!("{:.3} ulp at {:e}", worst.0, worst.1);
        assert!(worst.0 > 0.5 && worst.0 < 2.0, "{} ulp at {:e}", worst.0, worst.1);
    }

    #[test]
    fn what_is_not_a_positive_normal_number_has_the_logarithm_of_the_library() {
        assert_eq!(ln(0.0), f64::NEG_INFINITY);
        assert_eq!(ln(f64::INFINITY), f64::INFINITY);
        assert!(ln(-1.0).is_nan() && ln(f64::NAN).is_nan());
        assert_eq!(ln(5e-324), libm::log(5e-324));
        assert_eq!((ln(1.0), ln(f64::MIN_POSITIVE)), (0.0, libm::log(f64::MIN_POSITIVE)));
    }
}
