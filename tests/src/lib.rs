//! Parts shared by the tests across crates; the tests themselves are in `tests/`.

use glam::DVec3;
use radgrad_core::{Emitter, Error, Receiver};
use radgrad_paper::appendix;

pub mod decimal;
pub mod direct;
#[cfg(doctest)]
pub mod guide;
pub mod many_digits;
pub mod patchwork;
pub mod problem;
pub mod reference;
pub mod second_derivatives;

/// A way to compute radiosity and its gradient.
pub type Form = fn(&Receiver, &Emitter) -> Result<(f64, DVec3), Error>;

/// Both implementations: a law that holds for one must hold for the other.
pub const FORMS: [(&str, Form); 2] = [("arc form", radgrad_core::radiosity_and_gradient), ("appendix A", appendix_a)];

/// Appendix A of the paper, corrected.
///
/// # Errors
/// As [`appendix::radiosity_and_gradient`].
pub fn appendix_a(receiver: &Receiver, emitter: &Emitter) -> Result<(f64, DVec3), Error> {
    appendix::radiosity_and_gradient(receiver, emitter, None)
}

/// Relative errors of a radiosity and of its gradient (Euclidean norm) against a reference.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RelativeError {
    /// Error of the radiosity.
    pub radiosity: f64,
    /// Error of the gradient.
    pub gradient: f64,
}

impl RelativeError {
    /// Error of `computed` against `expected`, neither of which may be 0 where the other is not: that gives infinity.
    #[must_use]
    pub fn new(computed: (f64, DVec3), expected: (f64, DVec3)) -> Self {
        let relative = |error: f64, size: f64| if error == 0.0 { 0.0 } else { error / size };
        Self {
            radiosity: relative((computed.0 - expected.0).abs(), expected.0.abs()),
            gradient: relative((computed.1 - expected.1).length(), expected.1.length()),
        }
    }

    /// The larger of the two; NaN if either is.
    #[must_use]
    pub fn largest(self) -> f64 {
        if self.radiosity.is_nan() || self.gradient.is_nan() { f64::NAN } else { self.radiosity.max(self.gradient) }
    }
}
