//! An enclosed number: a midpoint of any precision and a radius.

use astro_float::{BigFloat, Consts, Radix, RoundingMode};

use crate::Error;
use crate::enclosure::ball::up;
use crate::enclosure::exact::Exact;

/// All numbers within a radius of a midpoint; the enclosed one is among them.
///
/// ```
/// use radgrad_oracle::Interval;
/// let third = Interval::around_decimal("0.3333333333333333333333", 1e-22)?;
/// assert!(!third.contains(1.0 / 3.0)); // the double is 2e-17 off
/// assert!(third.error_of(1.0 / 3.0) < 2e-17);
/// # Ok::<(), radgrad_oracle::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Interval {
    middle: Exact,
    radius: f64,
}

impl Interval {
    /// Exactly zero.
    pub(crate) fn zero() -> Self {
        Self { middle: Exact::zero(), radius: 0.0 }
    }

    pub(crate) const fn new(middle: Exact, radius: f64) -> Self {
        Self { middle, radius }
    }

    /// Reads a decimal number; the radius is one unit of its last digit.
    ///
    /// # Errors
    /// If `text` is not a finite decimal number.
    pub fn from_decimal(text: &str) -> Result<Self, Error> {
        let (middle, unit) = read(text)?;
        Ok(Self { middle, radius: up(unit) })
    }

    /// Reads a decimal number that is known to within `radius`.
    ///
    /// # Errors
    /// If `text` is not a finite decimal number, or the radius negative or not finite.
    pub fn around_decimal(text: &str, radius: f64) -> Result<Self, Error> {
        if !(0.0..f64::INFINITY).contains(&radius) {
            return Err(Error::Range { quantity: "the radius" });
        }
        let (middle, unit) = read(text)?;
        let exact = middle.is_zero() && radius == 0.0;
        Ok(Self { radius: if exact { 0.0 } else { up(radius + CONVERSION * unit) }, middle })
    }

    /// The double nearest the midpoint, to one unit in the last place.
    #[must_use]
    pub fn to_f64(&self) -> f64 {
        let first = self.middle.leading();
        first + (&self.middle - &Exact::from(first)).leading()
    }

    /// The radius.
    #[must_use]
    pub const fn radius(&self) -> f64 {
        self.radius
    }

    /// An upper bound of `|value - truth|`; infinite if `value` is not finite.
    #[must_use]
    pub fn error_of(&self, value: f64) -> f64 {
        if !value.is_finite() {
            return f64::INFINITY;
        }
        let distance = (&Exact::from(value) - &self.middle).magnitude();
        if distance == 0.0 && self.radius == 0.0 { 0.0 } else { up(distance + self.radius) }
    }

    /// Whether `value` is in the interval.
    #[must_use]
    pub fn contains(&self, value: f64) -> bool {
        value.is_finite() && self.overlaps(&Self { middle: Exact::from(value), radius: 0.0 })
    }

    /// Whether the two intervals have a point in common.
    #[must_use]
    pub fn overlaps(&self, other: &Self) -> bool {
        let distance = &self.middle - &other.middle;
        let distance = if distance.sign() < 0 { -&distance } else { distance };
        let reach = &Exact::from(self.radius) + &Exact::from(other.radius);
        (&reach - &distance).sign() >= 0
    }

    /// The distance of the midpoints over the sum of the radii: above 1 they have no point in common, and 0 where both are the same
    /// number.
    #[must_use]
    pub fn share_apart(&self, other: &Self) -> f64 {
        let distance = (&self.middle - &other.middle).magnitude();
        if distance == 0.0 { 0.0 } else { distance / (self.radius + other.radius) }
    }

    /// All differences of a number of this and one of the other interval.
    #[must_use]
    pub fn less(&self, other: &Self) -> Self {
        let radius = if self.radius == 0.0 && other.radius == 0.0 { 0.0 } else { up(self.radius + other.radius) };
        Self { middle: &self.middle - &other.middle, radius }
    }

    /// Doubles below and above every point of the interval.
    #[must_use]
    pub fn bounds(&self) -> (f64, f64) {
        let radius = Exact::from(self.radius);
        let (low, high) = (&self.middle - &radius, &self.middle + &radius);
        let outward = |v: &Exact, direction: i32| {
            let lead = v.leading();
            match (v - &Exact::from(lead)).sign() {
                s if s == direction && direction > 0 => lead.next_up(),
                s if s == direction => lead.next_down(),
                _ => lead,
            }
        };
        (outward(&low, -1), outward(&high, 1))
    }

    /// The midpoint as a decimal number, cut after the last digit that is larger than the radius; 0 if the radius is larger
    /// than the midpoint.
    ///
    /// # Errors
    /// If memory is exhausted.
    pub fn to_decimal(&self) -> Result<String, Error> {
        let unprintable = || Error::Range { quantity: "the decimal form" };
        if self.middle.is_zero() || self.middle.magnitude() <= self.radius {
            return Ok("0".to_owned());
        }
        let mut constants = Consts::new().map_err(|_| unprintable())?;
        let text = self.middle.to_big().format(Radix::Dec, RoundingMode::ToEven, &mut constants).map_err(|_| unprintable())?;
        let (mantissa, exponent) = text.split_once(['e', 'E']).unwrap_or((&text, "0"));
        let exponent: i32 = exponent.parse().map_err(|_| unprintable())?;
        if self.radius == 0.0 {
            return Ok(text);
        }
        let mut last = exponent;
        while power_of_ten(last - 1) > self.radius {
            last -= 1;
        }
        let places = usize::try_from(exponent - last).unwrap_or(0);
        let end = mantissa.find('.').map_or(mantissa.len(), |point| (point + 1 + places).min(mantissa.len()));
        Ok(format!("{}e{exponent}", &mantissa[..end]))
    }
}

/// Bound on the rounding of [`read`], in units of the last digit: 2^-60.
const CONVERSION: f64 = 1.0 / (1u64 << 60) as f64;

/// A decimal number and the unit of its last digit.
fn read(text: &str) -> Result<(Exact, f64), Error> {
    let error = || Error::Decimal { text: text.to_owned() };
    let mut constants = Consts::new().map_err(|_| error())?;
    let (digits, exponent) = text.split_once(['e', 'E']).unwrap_or((text, "0"));
    let places = digits.split_once('.').map_or(0, |(_, fraction)| fraction.len());
    let count = digits.bytes().filter(u8::is_ascii_digit).count();
    let readable = count > 0 && digits.trim_start_matches(['+', '-']).bytes().all(|b| b.is_ascii_digit() || b == b'.');
    let exponent: i32 = exponent.parse().map_err(|_| error())?;
    // log2(10) < 10/3; 64 bits more make the rounding of the conversion invisible beside the unit of the last digit.
    let bits = count * 10 / 3 + 64;
    let value = BigFloat::parse(text, Radix::Dec, bits, RoundingMode::ToEven, &mut constants);
    let middle = Exact::of_big(&value);
    if !readable || !middle.leading().is_finite() {
        return Err(error());
    }
    let last = exponent - i32::try_from(places).map_err(|_| error())?;
    Ok((middle, power_of_ten(last)))
}

/// `10^n`, rounded; infinite or 0 beyond the range of a double.
pub(crate) fn power_of_ten(n: i32) -> f64 {
    format!("1e{n}").parse().unwrap_or(f64::NAN)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn third() -> Interval {
        Interval::from_decimal("0.33333333333333333333333333333").unwrap()
    }

    #[test]
    fn a_decimal_with_a_radius_is_that_ball() {
        let tenth = Interval::around_decimal("1.0e-1", 1e-3).unwrap();
        assert!(tenth.contains(0.1009) && tenth.contains(0.0991) && !tenth.contains(0.1011));
        let sharp = Interval::around_decimal("1.0e-1", 0.0).unwrap();
        assert!(sharp.radius() > 0.0 && sharp.radius() < 1e-18, "a tenth is no dyadic number");
        assert_eq!(Interval::around_decimal("0", 0.0).unwrap(), Interval::zero());
        assert!(Interval::around_decimal("1", f64::NAN).is_err() && Interval::around_decimal("1", -1.0).is_err());
    }

    #[test]
    fn the_error_of_a_double_is_bounded_from_above_and_not_by_much() {
        let error = third().error_of(0.3333);
        assert!(error > 3.333_333_333_33e-5 && error < 3.333_333_333_34e-5, "{error:e}");
        assert_eq!(third().error_of(f64::NAN), f64::INFINITY);
        assert_eq!(Interval::zero().error_of(0.0), 0.0);
    }

    #[test]
    fn bounds_enclose_and_membership_is_exact() {
        let (low, high) = third().bounds();
        assert!(low < high && high - low < 1e-16);
        assert!(!third().contains(low) && !third().contains(high));
        assert!(Interval::from_decimal("0.25").unwrap().contains(0.25));
        assert!(third().overlaps(&Interval::from_decimal("0.333").unwrap()));
        assert!(third().less(&third()).contains(0.0) && third().less(&third()).radius() < 3e-29);
        assert!(!third().overlaps(&Interval::from_decimal("0.33333333333333333333333333336").unwrap()));
    }

    #[test]
    fn decimals_show_the_digits_that_are_known() {
        assert_eq!(third().to_decimal().unwrap(), "3.333333333333333333333333333e-1");
        assert!(Interval::from_decimal("one").is_err());
        assert!(Interval::from_decimal("NaN").is_err());
        assert!(Interval::from_decimal("").is_err());
    }
}
