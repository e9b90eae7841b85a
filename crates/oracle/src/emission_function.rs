//! Emissions `B(y)` that no closed form serves: spot lights, textures, measured lamps.
//!
//! `B(y)` is in W/m2 (or any unit, kept), its gradient in that unit over the unit of length. The emission is not defined off the
//! emitter's plane: only the gradient's part in it matters.

use glam::DVec3;

use crate::Error;
use crate::confidence::ConfidenceInterval;

/// Any function of the point `y` of an emitter.
///
/// A function known only by values at points can hide anything between them. [`Self::detail`] excludes that: the integrators look
/// at the function at least that closely before they believe an estimate of error.
///
/// ```
/// use radgrad_core::DVec3;
/// use radgrad_oracle::EmissionFunction;
/// // A spot 1 cm wide at the origin.
/// let (radiosity, slope) = (|y: DVec3| (-y.length_squared() / 2e-4).exp(), |y: DVec3| y * -1e4);
/// let spot = EmissionFunction {
///     radiosity: &radiosity,
///     gradient: Some(&|y| radiosity(y) * slope(y)),
///     detail: 0.02,
///     bounds: None,
/// };
/// assert_eq!((spot.radiosity)(DVec3::ZERO), 1.0);
/// ```
#[derive(Clone, Copy)]
pub struct EmissionFunction<'a> {
    /// `B(y)`.
    pub radiosity: &'a dyn Fn(DVec3) -> f64,
    /// `grad B(y)`, if `B` has one everywhere: a function that jumps has not.
    pub gradient: Option<&'a dyn Fn(DVec3) -> DVec3>,
    /// The width of the smallest feature: of a peak, a ripple, a texel. Infinite for a function that varies as slowly as a
    /// polynomial of low degree over the whole emitter.
    pub detail: f64,
    /// Only the distribution-free limits of Monte Carlo ask for them.
    pub bounds: Option<EmissionBounds>,
}

/// Bounds on an emission over its polygon.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EmissionBounds {
    /// Of `B(y)`.
    pub range: ConfidenceInterval,
    /// Of `|grad B(y)|`.
    pub steepest: f64,
}

impl EmissionFunction<'_> {
    pub(crate) fn check(&self) -> Result<(), Error> {
        if self.detail > 0.0 { Ok(()) } else { Err(Error::Detail { value: self.detail }) }
    }
}

impl std::fmt::Debug for EmissionFunction<'_> {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let mut fields = formatter.debug_struct("EmissionFunction");
        fields.field("has_gradient", &self.gradient.is_some()).field("detail", &self.detail).field("bounds", &self.bounds);
        fields.finish_non_exhaustive()
    }
}
