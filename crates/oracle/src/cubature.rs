//! Eq. 1 (HS95) and its gradient by adaptive cubature: radiosity in the unit of the emission, its gradient in that unit over
//! length.
//!
//! The integrand is in `integrand`; the method, and the meaning of its estimates of error, is in `adaptive`. The radiosity keeps
//! its digits everywhere. The gradient's integral cancels near contact and loses `log10(size / height)` digits; the estimates count
//! them, and a tolerance beyond them ends in [`Status::RoundoffLimited`]. Nothing is converged unless both estimates say so.

mod adaptive;
mod contour;
mod function;
mod gauss_kronrod;
pub(crate) mod integrand;
pub(crate) mod piece;
mod triangle_rule;

use glam::DVec3;
use radgrad_core::{Emitter, Polygon, Receiver};

use crate::Error;
use crate::cubature::adaptive::{Goal, Refined};
pub use crate::cubature::function::integrate_function;
use crate::cubature::integrand::Integrand;
use crate::cubature::piece::Piece;
use crate::region::plane::Vertex;
use crate::region::{FrameVector, Region};
use crate::source_function::SourceFunction;

/// How an integration ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Status {
    /// Both estimates of error are within the tolerance.
    Converged,
    /// The evaluations allowed were spent first.
    BudgetExhausted,
    /// The remaining error is rounding of the integrand: doubles cannot do better on this integral.
    RoundoffLimited,
    /// Two forms of the same integral differ by more than both errors: the gradient stated is not that of the emission, or the
    /// emission jumps or has smaller features than stated. Only [`integrate_function`] compares them.
    Contradiction,
}

/// Radiosity and gradient with estimates of their absolute errors.
///
/// ```
/// use radgrad_oracle::cubature::{Status, integrate};
/// # use radgrad_core::{DVec3, Emission, Emitter, Polygon, Receiver};
/// # let triangle = Polygon::new(vec![DVec3::Z, DVec3::new(0.0, 1.0, 1.0), DVec3::new(1.0, 0.0, 1.0)])?;
/// # let lamp = Emitter::new(triangle, Emission::Constant(1.0))?;
/// # let floor = Receiver::new(DVec3::ZERO, DVec3::Z, 1.0)?;
/// let estimate = integrate(&floor, &lamp, 1e-9, 100_000)?;
/// assert!(estimate.status == Status::Converged && estimate.radiosity_error <= 1e-9 * estimate.radiosity);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Estimate {
    /// Radiosity `B(x)`.
    pub radiosity: f64,
    /// Its gradient with respect to `x` at fixed normal.
    pub gradient: DVec3,
    /// Estimated error of `radiosity`.
    pub radiosity_error: f64,
    /// Estimated Euclidean norm of the error of `gradient`.
    pub gradient_error: f64,
    /// Evaluations of the integrand (value and gradient together).
    pub evaluations: usize,
    /// How it ended.
    pub status: Status,
}

/// Which of three integrals for the same numbers: they share the clipped region and the rules, not the integrand.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Form {
    /// Eq. 1 and its kernel differentiated, over the surface. Needs no gradient of the emission.
    Surface,
    /// Eqs. 6 and 9 as corrected: along the contour, and over the surface where the emission varies.
    Contour,
    /// Eq. 1 over the surface; its gradient along the visible boundary and, where the emission varies, over the surface.
    Boundary,
}

impl Form {
    const fn name(self) -> &'static str {
        match self {
            Self::Surface => "the surface form",
            Self::Contour => "the contour form",
            Self::Boundary => "the boundary form",
        }
    }
}

/// Radiosity and gradient of `emitter` at `receiver` by [`Form::Surface`] to the relative `tolerance`, each with respect to its
/// own size (norm), within `budget` evaluations.
///
/// ```
/// use radgrad_core::{DVec3, Emission, Emitter, Polygon, Receiver};
/// use radgrad_oracle::cubature::{Status, integrate};
/// let triangle = Polygon::new(vec![DVec3::new(0.0, 0.0, 1.0), DVec3::new(0.0, 1.0, 1.0), DVec3::new(1.0, 0.0, 1.0)])?;
/// let emitter = Emitter::new(triangle, Emission::Constant(1.0))?;
/// let receiver = Receiver::new(DVec3::ZERO, DVec3::Z, 1.0)?;
/// let estimate = integrate(&receiver, &emitter, 1e-10, 100_000)?;
/// assert_eq!(estimate.status, Status::Converged);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// If the tolerance is not positive, the budget does not allow a first pass, or a number overflows.
pub fn integrate(receiver: &Receiver, emitter: &Emitter, tolerance: f64, budget: usize) -> Result<Estimate, Error> {
    integrate_form(receiver, emitter.polygon(), SourceFunction::Emitter(emitter), Form::Surface, tolerance, budget)
}

/// The same for any emission over `polygon`, by any of the forms.
///
/// # Errors
/// As [`integrate`], or if a function gives a value that is not finite or lacks the gradient that the form needs.
pub fn integrate_form(
    receiver: &Receiver,
    polygon: &Polygon,
    source: SourceFunction<'_>,
    form: Form,
    tolerance: f64,
    budget: usize,
) -> Result<Estimate, Error> {
    check_tolerance(tolerance)?;
    source.check(form != Form::Surface, form.name())?;
    let region = Region::new(receiver, polygon, &source)?;
    let integrand = Integrand::new(&region, source);
    let is_wary = matches!(source, SourceFunction::Function(_));
    let goal = Goal { tolerance, budget, longest: source.detail() * region.unit, is_wary };
    let triangles = || region.triangles.iter().copied().map(Piece::Triangle);
    let edges = || region.outline.iter().copied().map(Piece::Edge);
    let refined = match form {
        Form::Surface => {
            adaptive::integrate(triangles().collect(), region.height, &|_: &Piece, at: &Vertex| integrand.surface(at), goal)
        }
        Form::Contour => {
            let pieces = if source.is_constant() { edges().collect() } else { edges().chain(triangles()).collect() };
            adaptive::integrate(pieces, region.height, &|piece: &Piece, at: &Vertex| integrand.contour(piece, at), goal)
        }
        Form::Boundary => {
            let pieces = edges().chain(triangles()).collect();
            adaptive::integrate(pieces, region.height, &|piece: &Piece, at: &Vertex| integrand.boundary(piece, at), goal)
        }
    }?;
    Estimate::in_space(&region, refined)
}

pub(crate) fn check_tolerance(tolerance: f64) -> Result<(), Error> {
    if tolerance > 0.0 && tolerance.is_finite() { Ok(()) } else { Err(Error::Tolerance { value: tolerance }) }
}

impl Estimate {
    /// Converts from scaled lengths and the frame of the region.
    pub(crate) fn in_space(region: &Region, refined: Refined) -> Result<Self, Error> {
        let [value, gu, gv, gn] = refined.integral;
        let estimate = Self {
            radiosity: region.factor * value,
            gradient: region.to_space(FrameVector::new(gu, gv, gn)) * region.factor * region.unit,
            radiosity_error: region.factor * refined.error[0],
            gradient_error: region.factor * refined.error[1] * region.unit,
            evaluations: refined.evaluations,
            status: refined.status,
        };
        let size = estimate.gradient.abs().max_element();
        if !size.is_finite() {
            return Err(Error::NotFinite { quantity: "the gradient", value: size });
        }
        Ok(estimate)
    }
}
