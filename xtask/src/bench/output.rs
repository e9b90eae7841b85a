//! The output of every method.

use radgrad_core::DVec3;

/// A method's output for a case.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Output {
    /// Radiosity.
    pub(crate) radiosity: f64,
    /// Its gradient.
    pub(crate) gradient: DVec3,
    /// Evaluations of the integrand, or of the closed form.
    pub(crate) evaluations: usize,
    /// Whether the method claims to have reached the tolerance.
    pub(crate) converged: bool,
    /// Proven relative errors of value and gradient, of a method with more digits than doubles can show.
    pub(crate) proven: Option<[f64; 2]>,
}

impl Output {
    /// An answer that claims nothing about itself.
    pub(crate) const fn new((radiosity, gradient): (f64, DVec3), evaluations: usize) -> Self {
        Self { radiosity, gradient, evaluations, converged: true, proven: None }
    }
}
