//! Powers of two that bring lengths to about 1.

/// The power of two that brings `size` into [1, 2); 1 for 0.
#[inline]
pub fn normalising_power(size: f64) -> f64 {
    let exponent = (size.to_bits() >> 52) & 0x7ff;
    match exponent {
        0 if size == 0.0 => 1.0,
        0 => f64::from_bits(2045 << 52),
        2046.. => f64::from_bits(1 << 51),
        _ => f64::from_bits((2046 - exponent) << 52),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn normalising_powers_are_exact() {
        for (size, expected) in [(1.0, 1.0), (1.9, 1.0), (2.0, 0.5), (0.75, 2.0), (0.0, 1.0)] {
            assert_eq!(normalising_power(size), expected);
        }
        for size in [f64::MIN_POSITIVE, 5e-324, f64::MAX, 1e300, 1e-300] {
            let power = normalising_power(size);
            assert!(power > 0.0 && power.is_finite() && size * power < 4.0);
        }
    }
}
