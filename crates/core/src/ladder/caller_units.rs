//! From normalised lengths and emission to the units of the caller.
//!
//! All is computed with lengths and an emission of about 1, so each result has to be multiplied by one power of two: exactly,
//! while the product is a normal number. A product beyond the range of a double is an error, and so is one that is not 0 but
//! below the normal range, where doubles have fewer digits than were found. A gradient or a Hessian is judged by its largest
//! component.

use glam::DVec3;
use radgrad_numbers::vec3::Vec3;

use crate::boundary::case::Case;
use crate::boundary::plan::Plan;
use crate::error::Error;
#[cfg(feature = "arbitrary-precision")]
use crate::problem::emission::Emission;
use crate::problem::emission::Emitter;

/// The power of two that takes a normalised result to the unit of the caller.
#[derive(Debug, Clone, Copy)]
pub(crate) struct CallerUnits {
    exponent: i32,
    quantity: &'static str,
}

/// The smallest double, an ulp of all that are not normal.
const SMALLEST: f64 = f64::from_bits(1);

/// Logarithm of the smallest normal number.
#[cfg(feature = "arbitrary-precision")]
const LOWEST: f64 = -1022.0;

impl CallerUnits {
    /// The unit of the radiosity, or of a derivative of it: that of the emission over that of length to the power `order`.
    #[inline]
    pub(crate) fn of_derivative(order: i32, quantity: &'static str, plan: &Plan, emitter: &Emitter) -> Self {
        Self { exponent: order * exponent(plan.power) - exponent(emitter.power()), quantity }
    }

    /// The unit of a derivative by the emission, that of length to the power `order`.
    pub(crate) fn of_length(order: i32, quantity: &'static str, plan: &Plan) -> Self {
        Self { exponent: -order * exponent(plan.power), quantity }
    }

    /// The components of a number, vector or matrix, at most nine, that is off by at most `error`, and a bound on the error they
    /// have in this unit.
    #[inline]
    pub(crate) fn components<const N: usize>(self, normalised: [f64; N], error: f64) -> Result<([f64; N], f64), Error> {
        let factor = self.factor();
        let (components, bound) = (normalised.map(|c| c * factor), error * factor);
        if are_normal(&components) && are_normal(&[bound]) { Ok((components, bound)) } else { self.rounded(normalised, error) }
    }

    /// The same where something is 0 or leaves the range of normal numbers.
    ///
    /// Below it each component is rounded by half the smallest double at most, and so is the bound: four of those halves
    /// together.
    #[cold]
    #[inline(never)]
    fn rounded<const N: usize>(self, normalised: [f64; N], error: f64) -> Result<([f64; N], f64), Error> {
        const { assert!(N <= 9) };
        let components = self.plain_rounded(normalised, error)?;
        let bound = libm::scalbn(error, self.exponent);
        let is_rounded = |normalised: f64, scaled: f64| normalised != 0.0 && scaled.abs() < f64::MIN_POSITIVE;
        let any_rounded =
            is_rounded(error, bound) || normalised.iter().zip(&components).any(|(c, scaled)| is_rounded(*c, *scaled));
        let bound = if any_rounded { (bound + 2.0 * SMALLEST).next_up() } else { bound };
        Ok((components, if bound.is_nan() { f64::INFINITY } else { bound }))
    }

    /// The components without a bound: one that is not 0 is taken to be known.
    #[inline]
    pub(crate) fn plain<const N: usize>(self, normalised: [f64; N]) -> Result<[f64; N], Error> {
        let factor = self.factor();
        let components = normalised.map(|c| c * factor);
        // Where the largest is normal all products are rounded once; the sum is at most nine times it.
        let size: f64 = components.iter().map(|c| c.abs()).sum();
        let is_normal = (16.0 * f64::MIN_POSITIVE..f64::INFINITY).contains(&size);
        if is_normal { Ok(components) } else { self.plain_rounded(normalised, 0.0) }
    }

    #[cold]
    #[inline(never)]
    fn plain_rounded<const N: usize>(self, normalised: [f64; N], error: f64) -> Result<[f64; N], Error> {
        let components = normalised.map(|c| libm::scalbn(c, self.exponent));
        self.check_finite(components)?;
        if largest(&normalised) > error {
            self.check_size(components)?;
        }
        Ok(components)
    }

    /// The power of two, or not a number where it is not a normal one.
    #[inline]
    fn factor(self) -> f64 {
        match u64::try_from(self.exponent + 1023) {
            Ok(biased @ 1..=2046) => f64::from_bits(biased << 52),
            _ => f64::NAN,
        }
    }

    /// The power of two, where it is not far from 1: times numbers of a moderate size it gives numbers that are normal.
    #[inline]
    pub(crate) fn moderate(self) -> Option<f64> {
        (-400..=400).contains(&self.exponent).then(|| self.factor())
    }

    /// Refuses a component that is not finite.
    pub(crate) fn check_finite<const N: usize>(self, components: [f64; N]) -> Result<(), Error> {
        if components.iter().any(|c| c.is_nan()) {
            return Err(Error::Scales { quantity: self.quantity });
        }
        let is_finite = components.iter().all(|c| c.is_finite());
        if is_finite { Ok(()) } else { Err(Error::Overflow { quantity: self.quantity }) }
    }

    /// Refuses a result below the normal range that is known not to be 0.
    pub(crate) fn check_size<const N: usize>(self, components: [f64; N]) -> Result<(), Error> {
        let is_normal = largest(&components) >= f64::MIN_POSITIVE;
        if is_normal { Ok(()) } else { Err(Error::Underflow { quantity: self.quantity }) }
    }

    /// The power of two itself.
    #[cfg(feature = "arbitrary-precision")]
    pub(crate) const fn magnitude(self) -> radgrad_numbers::big::magnitude::Magnitude {
        radgrad_numbers::big::magnitude::Magnitude::power_of_two(self.exponent as i64)
    }
}

impl Case<'_> {
    /// A normalised radiosity in the unit of the emission.
    #[inline]
    pub(crate) fn radiosity(&self, normalised: f64) -> Result<f64, Error> {
        self.radiosity_unit().plain([normalised]).map(|[radiosity]| radiosity)
    }

    /// A normalised gradient in the unit of the emission over that of length.
    #[inline]
    pub(crate) fn gradient(&self, Vec3 { x, y, z }: Vec3<f64>) -> Result<DVec3, Error> {
        self.gradient_unit().plain([x, y, z]).map(DVec3::from)
    }

    /// Bounds on the radiosity and on the norm of its gradient, if the emitter is so small for its distance that the radiosity is
    /// surely below the normal range, as many bits would find in the end. Occluders may steepen the gradient: past them its bound is
    /// infinite.
    ///
    /// With lengths in the plan's unit a vertex is at 1 or beyond, so an emitter of size s up to 1/8 is beyond 7/8. Its area is at most
    /// `sqrt(2) s^2`, as that of a cut through a cube, and the kernel at most `1/r^2`, with a gradient of at most `6/r^3`: so `|B| <=
    /// 2 albedo max|L| s^2`, and `|grad B|` is at most 8 times that. The logarithms leave another factor of 2 for their rounding.
    ///
    /// # Errors
    /// If the radiosity is surely not 0: no occluder hides a part, and all that is seen emits with one sign.
    #[cfg(feature = "arbitrary-precision")]
    pub(super) fn below_range(&self) -> Result<Option<[f64; 2]>, Error> {
        let Self { receiver, emitter, occluders, plan } = *self;
        let unit = libm::log2(plan.power);
        let size = libm::log2(emitter.polygon().size()) + unit;
        let radiosity = 2.0 + 2.0 * size + libm::log2(emitter.largest_emission()) + libm::log2(receiver.albedo().hi);
        if size > -3.0 || radiosity.is_nan() || radiosity > LOWEST {
            return Ok(None);
        }
        if occluders.is_empty() && emits_with_one_sign(emitter) {
            self.radiosity_unit().check_size([0.0])?;
        }
        let gradient = if occluders.is_empty() { radiosity + 3.0 + unit } else { f64::INFINITY };
        Ok(Some([radiosity, gradient].map(|bound| libm::exp2(bound).max(SMALLEST))))
    }

    #[inline]
    pub(crate) fn radiosity_unit(&self) -> CallerUnits {
        CallerUnits::of_derivative(0, "radiosity", self.plan, self.emitter)
    }

    #[inline]
    pub(crate) fn gradient_unit(&self) -> CallerUnits {
        CallerUnits::of_derivative(1, "gradient", self.plan, self.emitter)
    }
}

/// Whether all points of an emitter surely emit, and with the same sign.
#[cfg(feature = "arbitrary-precision")]
fn emits_with_one_sign(emitter: &Emitter) -> bool {
    match emitter.emission() {
        Emission::Constant(value) => *value != 0.0,
        Emission::Linear(_) => {
            let (count, error) = (emitter.polygon().vertices().len(), emitter.vertex_error());
            let is_beyond = |sign: f64| (0..count).all(|vertex| sign * emitter.vertex_value(vertex) > error);
            is_beyond(1.0) || is_beyond(-1.0)
        }
        Emission::Polynomial(_) => false,
    }
}

/// The exponent of a power of two from 2^-1023 up.
#[inline]
fn exponent(power_of_two: f64) -> i32 {
    // At most 2047.
    ((power_of_two.to_bits() >> 52) as i32) - 1023
}

/// Whether all are normal numbers.
#[inline]
fn are_normal(numbers: &[f64]) -> bool {
    numbers.iter().all(|c| (f64::MIN_POSITIVE..f64::INFINITY).contains(&c.abs()))
}

fn largest(components: &[f64]) -> f64 {
    components.iter().fold(0.0, |m: f64, c| m.max(c.abs()))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn unit(exponent: i32) -> CallerUnits {
        CallerUnits { exponent, quantity: "gradient" }
    }

    const UNDERFLOW: Error = Error::Underflow { quantity: "gradient" };

    #[test]
    fn exponents_are_those_of_powers_of_two() {
        for k in [-1023, -1022, -1, 0, 52, 1023] {
            assert_eq!(exponent(2f64.powi(k)), k);
        }
    }

    #[test]
    fn what_stays_normal_is_exact() {
        for k in [-2000, -1022, -3, 0, 900, 1500] {
            let value = libm::scalbn(1.375, -k / 2);
            let (components, bound) = unit(k).components([value, 0.0, -value], value * 2f64.powi(-20)).unwrap();
            assert_eq!(components.map(|c| libm::scalbn(c, -k)), [value, 0.0, -value]);
            assert_eq!(libm::scalbn(bound, -k), value * 2f64.powi(-20));
        }
    }

    #[test]
    fn what_leaves_the_range_is_said() {
        assert_eq!(unit(600).plain([2f64.powi(500), 0.0]), Err(Error::Overflow { quantity: "gradient" }));
        assert_eq!(unit(0).plain([f64::NAN]), Err(Error::Scales { quantity: "gradient" }));
        assert_eq!(unit(-1000).plain([2f64.powi(-23)]), Err(UNDERFLOW));
        assert_eq!(unit(-3000).components([1.0, 0.0, 1.0], 1e-16), Err(UNDERFLOW));
        assert_eq!(unit(-3000).plain([0.0; 3]), Ok([0.0; 3]));
    }

    #[test]
    fn a_small_component_beside_a_normal_one_is_rounded_within_the_bound() {
        let (small, error) = (1.37 * 2f64.powi(-52), 2f64.powi(-60));
        let ([normal, rounded], bound) = unit(-1022).components([1.0, small], error).unwrap();
        assert_eq!(normal, f64::MIN_POSITIVE);
        let error = (rounded / SMALLEST - small * 2f64.powi(52)).abs();
        assert!(error > 0.3 && bound / SMALLEST > error && bound / SMALLEST <= 4.0, "{error} {bound:e}");
    }

    #[test]
    fn what_may_be_0_is_no_underflow() {
        let (value, bound) = unit(-1100).components([1e-20], 1e-19).unwrap();
        assert!(value == [0.0] && bound > 0.0 && bound < 1e-322);
    }
}
