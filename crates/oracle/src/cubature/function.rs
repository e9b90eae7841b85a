//! Any emission `B(y)`, by two forms of the same integrals that check each other.
//!
//! [`Form::Surface`] asks for values of B only; its gradient loses digits near contact. [`Form::Boundary`] takes B's gradient at
//! the user's word, misses jumps of B, and keeps its digits near contact. Where both agree the answer is that of the one with the
//! smaller error; where they differ by more than their errors the status says so and the surface form answers, as it does where its
//! own error is too large to tell.

use radgrad_core::{Polygon, Receiver};

use super::{Estimate, Form, Status, integrate_form};
use crate::emission_function::EmissionFunction;
use crate::{Error, SourceFunction};

/// Largest relative error of the surface form with which it can vouch for the other: any slip that matters is larger.
const TELLING: f64 = 1e-2;

/// Radiosity and gradient of `polygon` with the emission `emission` at `receiver`, to the relative `tolerance`, each with
/// respect to its own size (norm), within `budget` evaluations of the emission.
///
/// The tolerance is met where the status is [`Status::Converged`]; otherwise the errors are above it. They are estimates, as
/// cautious as [`EmissionFunction::detail`] is true. Without a gradient of the emission the surface form answers alone. Occluders
/// are for [`crate::monte_carlo::integrate_source`].
///
/// ```
/// use radgrad_core::{DVec3, Polygon, Receiver};
/// use radgrad_oracle::EmissionFunction;
/// use radgrad_oracle::cubature::{Status, integrate_function};
/// let square = [(-1.0, -1.0), (-1.0, 1.0), (1.0, 1.0), (1.0, -1.0)].map(|(x, y)| DVec3::new(x, y, 1.0));
/// let ceiling = Polygon::new(square.to_vec())?;
/// // Ripples of wavelength 0.5.
/// let k = 4.0 * std::f64::consts::PI;
/// let ripples = EmissionFunction {
///     radiosity: &|y| 2.0 + (k * y.x).sin(),
///     gradient: Some(&|y| DVec3::X * k * (k * y.x).cos()),
///     detail: 0.5,
///     bounds: None,
/// };
/// let floor = Receiver::new(DVec3::new(0.3, 0.2, 0.0), DVec3::Z, 0.8)?;
/// let estimate = integrate_function(&floor, &ceiling, &ripples, 1e-9, 1_000_000)?;
/// assert_eq!(estimate.status, Status::Converged);
/// assert!(estimate.radiosity_error <= 1e-9 * estimate.radiosity);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// If the tolerance or the detail is not positive, the budget does not allow a first look at every detail, or the emission gives
/// a value that is not finite.
pub fn integrate_function(
    receiver: &Receiver,
    polygon: &Polygon,
    emission: &EmissionFunction<'_>,
    tolerance: f64,
    budget: usize,
) -> Result<Estimate, Error> {
    let by = |form, budget| integrate_form(receiver, polygon, SourceFunction::Function(emission), form, tolerance, budget);
    if emission.gradient.is_none() {
        return by(Form::Surface, budget);
    }
    let surface = by(Form::Surface, budget / 2).map_err(|error| match error {
        Error::Evaluations { needed, .. } => Error::Evaluations { budget, needed: 2 * needed },
        other => other,
    })?;
    match by(Form::Boundary, budget - surface.evaluations) {
        // Nothing is left to check with: the surface form stands for itself.
        Err(Error::Evaluations { .. }) => Ok(surface),
        boundary => Ok(surface.checked_by(&boundary?, tolerance)),
    }
}

impl Estimate {
    /// This estimate, that rests on values alone, or another one where its error is smaller; a contradiction where they are apart.
    fn checked_by(self, other: &Self, tolerance: f64) -> Self {
        let apart = [(self.radiosity - other.radiosity).abs(), (self.gradient - other.gradient).length()];
        let (own, theirs) = (self.errors(), other.errors());
        let evaluations = self.evaluations + other.evaluations;
        if (0..2).any(|i| apart[i] > own[i] + theirs[i]) {
            return Self { evaluations, status: Status::Contradiction, ..self };
        }
        let mut both = Self { evaluations, ..self };
        let telling = (0..2).all(|i| own[i] <= TELLING * self.sizes()[i]);
        if telling && other.radiosity_error < self.radiosity_error {
            (both.radiosity, both.radiosity_error) = (other.radiosity, other.radiosity_error);
        }
        if telling && other.gradient_error < self.gradient_error {
            (both.gradient, both.gradient_error) = (other.gradient, other.gradient_error);
        }
        let met = (0..2).all(|i| both.errors()[i] <= tolerance * both.sizes()[i]);
        both.status = match (met, self.status, other.status) {
            (true, ..) => Status::Converged,
            (_, Status::BudgetExhausted, _) | (_, _, Status::BudgetExhausted) => Status::BudgetExhausted,
            _ => Status::RoundoffLimited,
        };
        both
    }

    const fn errors(&self) -> [f64; 2] {
        [self.radiosity_error, self.gradient_error]
    }

    fn sizes(&self) -> [f64; 2] {
        [self.radiosity.abs(), self.gradient.length()]
    }
}
