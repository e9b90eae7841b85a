//! Whether the host computes as IEEE 754 asks: bounds are proven for rounding to nearest with subnormal numbers.

use std::hint::black_box;

use crate::error::Error;

/// Refuses a host that flushes subnormal numbers to zero or rounds otherwise than to the nearest: in such a thread no bound holds.
/// Programs that load this library into another one's process may ask before they evaluate.
///
/// ```
/// assert_eq!(radgrad_scene::check_host(), Ok(()));
/// ```
///
/// # Errors
/// If it is such a host.
pub fn check_host() -> Result<(), Error> {
    let half = black_box(f64::MIN_POSITIVE) * black_box(0.5);
    if half == 0.0 || black_box(half) + black_box(half) != f64::MIN_POSITIVE {
        return Err(Error::Host { rule: "subnormal numbers are flushed to zero" });
    }
    let (one, quarter) = (black_box(1.0), black_box(0.25 * f64::EPSILON));
    let nearest = [one + quarter, one + 3.0 * quarter, -one - quarter, -one - 3.0 * quarter];
    if nearest != [1.0, 1.0 + f64::EPSILON, -1.0, -1.0 - f64::EPSILON] {
        return Err(Error::Host { rule: "numbers are not rounded to the nearest" });
    }
    Ok(())
}
