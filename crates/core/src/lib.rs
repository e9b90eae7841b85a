//! Radiosity and its gradient at a receiver point due to a polygonal emitter, in closed form.

mod double_double;
mod emission;
mod error;
mod evaluate;
mod geometry;
pub mod paper;
mod vec3;

pub use emission::{Emission, Emitter, Linear};
pub use error::Error;
pub use evaluate::{Answer, Method, evaluate, gradient, radiosity, radiosity_and_gradient};
pub use geometry::{Polygon, Receiver};
pub use glam::DVec3;
