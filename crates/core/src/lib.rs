//! Radiosity and its gradient at a receiver point due to a polygonal emitter, in closed form and with proven bounds.
//!
//! `B(x) = (rho/pi) int B(y) (n1.r)(-n2.r)/|r|^4 dA`, `r = y - x` (N. Holzschuch and F. X. Sillion 1995, Eq. 1), over the part of
//! the emitter above the receiver's horizon and not hidden by occluders; the gradient is with respect to x at fixed n1. The
//! emission `B(y)` is constant, linear or a polynomial. Radiosity is in the unit of the emission, the gradient in that over the
//! unit of length; with `rho = 1` and `B(y) = 1` the radiosity is the form factor of the point. The emission of a lamp of radiance L is
//! `pi L`; the guide's page `docs/guide/units.md` sets radiance, emission, irradiance and illuminance side by side.
//!
//! - [`evaluate`] and [`evaluate_to`] answer to a relative tolerance, each number with a bound on its error;
//! - [`evaluate_value`] answers with the value alone, to a relative or an absolute tolerance;
//! - [`radiosity`], [`gradient`] and [`radiosity_and_gradient`] give the plain closed form in double precision, without bounds, at
//!   the least cost;
//! - [`evaluate_digits`] gives any number of digits;
//! - [`irradiance_vector`] and [`irradiance_vector_to`] serve many normals at one point, and are the derivative with respect to the
//!   normal; [`hessian`] and
//!   [`hessian_to`] give second derivatives with respect to position;
//! - [`derivatives()`] gives the derivatives by the vertices of emitter and occluders, by emission, normal and reflectance.
//!
//! ```
//! use radgrad_core::{DVec3, Emission, Emitter, Polygon, Receiver, evaluate};
//! let corners = [(0.0, 0.0), (0.0, 1.0), (1.0, 1.0), (1.0, 0.0)].map(|(x, y)| DVec3::new(x, y, 1.0));
//! let lamp = Polygon::new(corners.to_vec())?; // counter-clockwise seen from the side it lights
//! let lamp = Emitter::new(lamp, Emission::at_vertices(vec![1.0, 2.0, 3.0, 2.0]))?;
//! let floor = Receiver::new(DVec3::ZERO, DVec3::Z, 0.8)?;
//! let answer = evaluate(&floor, &lamp, &[])?;
//! assert!(answer.radiosity_error <= 1e-12 * answer.radiosity);
//! assert!(answer.gradient.z > 0.0, "nearer the lamp it is brighter");
//! # Ok::<(), radgrad_core::Error>(())
//! ```

#[cfg(feature = "batch")]
pub mod batch;
mod boundary;
#[doc(hidden)]
pub mod closed_forms;
mod derivatives;
mod error;
mod evaluate;
mod forms;
mod gauss;
mod hessian;
mod ladder;
mod problem;

pub use derivatives::{Derivative, Derivatives, derivatives};
pub use error::Error;
pub use evaluate::{
    DEFAULT_TOLERANCE, evaluate, evaluate_to, evaluate_value, gradient, irradiance_vector, irradiance_vector_to, radiosity,
    radiosity_and_gradient,
};
pub use glam::{DMat3, DVec3};
pub use hessian::{Hessian, hessian, hessian_to};
pub use ladder::answer::{Answer, Method, Tolerance, Value};
#[cfg(feature = "arbitrary-precision")]
pub use ladder::digits::{MOST_DIGITS, PreciseAnswer, evaluate_digits};
pub use ladder::irradiance::IrradianceVector;
pub use problem::emission::{Emission, Emitter, Linear};
pub use problem::polygon::Polygon;
pub use problem::polynomial::{Monomial, Polynomial};
pub use problem::receiver::Receiver;
pub use radgrad_numbers::effort;
