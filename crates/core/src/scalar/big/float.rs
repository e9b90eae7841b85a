//! Exact operations on `BigFloat`, and its conversions from and to doubles.

use astro_float::{BigFloat, RoundingMode, Sign};

use crate::scalar::big::magnitude::Magnitude;

/// To nearest: at most half a unit in the last place.
pub(crate) const NEAREST: RoundingMode = RoundingMode::ToEven;

/// Exactly this double. The crate's own conversion halves subnormal numbers: those are brought into the normal range first.
pub(crate) fn exact(value: f64) -> BigFloat {
    if value.abs() < f64::MIN_POSITIVE {
        shifted(&BigFloat::from_f64(value * 2f64.powi(64), 64), -64)
    } else {
        BigFloat::from_f64(value, 64)
    }
}

/// The sum to as many bits as it takes. The crate's own gives 0 where either number is 0.
pub(crate) fn exact_sum(a: &BigFloat, b: &BigFloat) -> BigFloat {
    if a.is_zero() {
        b.clone()
    } else if b.is_zero() {
        a.clone()
    } else {
        a.add_full_prec(b)
    }
}

/// Times a power of two, exactly.
pub(crate) fn shifted(number: &BigFloat, exponent: i32) -> BigFloat {
    let mut shifted = number.clone();
    if let Some(own) = number.exponent().filter(|_| !number.is_zero()) {
        shifted.set_exponent(own + exponent);
    }
    shifted
}

/// The nearest double; the smallest one of its sign for a number that is too small, so that a sign is never lost.
pub(crate) fn nearest_double(number: &BigFloat) -> f64 {
    let Some((words, _, sign, exponent, _)) = number.as_raw_parts() else {
        return if number.is_inf_pos() {
            f64::INFINITY
        } else if number.is_inf_neg() {
            f64::NEG_INFINITY
        } else {
            f64::NAN
        };
    };
    let leading = words.last().copied().unwrap_or(0);
    if leading == 0 {
        return 0.0;
    }
    let size = libm::scalbn(leading as f64, exponent - 64).max(f64::from_bits(1));
    if sign == Sign::Neg { -size } else { size }
}

/// The nearest double and a bound on the size of what it leaves, above it by two roundings.
pub(crate) fn split_double(number: &BigFloat) -> (f64, Magnitude) {
    let double = nearest_double(number);
    (double, Magnitude::of(&exact_sum(number, &exact(-double))) * (1.0 + 2.0 * f64::EPSILON))
}
