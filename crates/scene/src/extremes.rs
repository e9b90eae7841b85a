//! Extremes that keep NaN. `f64::max` and `f64::min` pass over it, so that a bound made with them would be 0 where a value is
//! unknown.

/// The larger of two numbers; NaN if either is.
///
/// ```
/// use radgrad_scene::largest;
/// assert_eq!([1.0, 3.0, 2.0].into_iter().fold(0.0, largest), 3.0);
/// assert!([1.0, f64::NAN, 2.0].into_iter().fold(0.0, largest).is_nan());
/// ```
#[must_use]
pub const fn largest(a: f64, b: f64) -> f64 {
    if a > b || a.is_nan() { a } else { b }
}

/// The smaller of two numbers; NaN if either is.
///
/// ```
/// use radgrad_scene::smallest;
/// assert_eq!(smallest(1.0, 3.0), 1.0);
/// assert!(smallest(f64::NAN, 1.0).is_nan() && smallest(1.0, f64::NAN).is_nan());
/// ```
#[must_use]
pub const fn smallest(a: f64, b: f64) -> f64 {
    if a < b || a.is_nan() { a } else { b }
}
