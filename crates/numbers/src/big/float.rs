//! Exact operations on `BigFloat`, and its conversions from and to doubles.

use astro_float::{BigFloat, RoundingMode, Sign};

use crate::big::magnitude::Magnitude;

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
    let leading = mantissa_bits(words, 0);
    if leading == 0 {
        return 0.0;
    }
    // One more bit for all that follow: a number midway between two doubles but for these is nearer to one of them.
    let count = 64 / (8 * size_of_val(&words[0]));
    let is_more = words.iter().rev().skip(count).any(|word| *word != 0);
    let size = libm::scalbn((leading | u64::from(is_more)) as f64, exponent - 64).max(f64::from_bits(1));
    if sign == Sign::Neg { -size } else { size }
}

/// 64 bits of a mantissa, whose highest are those of place 0: the library's words have 32 or 64 bits, by the target.
pub(crate) fn mantissa_bits<W: Copy + Into<u64>>(words: &[W], place: usize) -> u64 {
    let width = 8 * size_of::<W>();
    let count = 64 / width;
    (0..count).fold(0, |bits, part| {
        let word = words.len().checked_sub(1 + place * count + part).map_or(0, |index| words[index].into());
        bits | (word << (64 - width * (part + 1)))
    })
}

/// The nearest double and a bound on the size of the rest, above it by two roundings.
pub(crate) fn split_double(number: &BigFloat) -> (f64, Magnitude) {
    let double = nearest_double(number);
    (double, Magnitude::of_number(&exact_sum(number, &exact(-double))) * (1.0 + 2.0 * f64::EPSILON))
}

#[cfg(test)]
mod tests {
    use super::mantissa_bits;

    #[test]
    fn bits_of_a_mantissa_are_the_same_in_words_of_either_size() {
        let (long, short) =
            ([0x1111_2222_3333_4444_u64, 0xaaaa_bbbb_cccc_dddd], [0x3333_4444_u32, 0x1111_2222, 0xcccc_dddd, 0xaaaa_bbbb]);
        for (place, bits) in [(0, long[1]), (1, long[0]), (2, 0)] {
            assert_eq!((mantissa_bits(&long, place), mantissa_bits(&short, place)), (bits, bits));
        }
        // An odd number of short words ends in the middle of a long one.
        assert_eq!(mantissa_bits(&short[1..], 1), 0x1111_2222_0000_0000);
    }
}
