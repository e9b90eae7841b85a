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
