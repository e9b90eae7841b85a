//! Intervals for the radiosity of a scene, that hold with a stated probability whatever the scene is.
//!
//! The radiosity of diffuse faces is the expectation of the contributions of random walks (J. Arvo and D. Kirk 1990; theory of
//! the walks in `paths`), and the contribution of a walk is at most a number that follows from reflectances and emissions alone.
//! So limits for the mean of independent bounded numbers (`betting`) are limits for the radiosity: no mesh, no smoothness, no
//! solution enters. They fail with probability `delta`, 1e-6 if nothing else is requested, over the random numbers, which a seed
//! chooses; `delta` is shared by all channels and points.
//!
//! - [`certify`]: the mean radiosity over all area. Walks begin at lamps, or where these light next to nothing at pairs of parts of lamps and of
//!   faces, whichever needs less work by a pilot of its own random numbers (`source`).
//! - [`certify_points`]: the irradiance and the radiosity at points. Walks begin there, and take the light of lamps in closed form.
//!
//! Rays are those of [`radgrad_scene::Occluders`], in double precision: one that passes an edge within rounding, about 1e-10 of all, may go to
//! either side. The change of the result is far below the width of any interval here.
//!
//! ```
//! use radgrad_certificate::{Request, certify};
//! # use radgrad_scene::{Degenerate, Scene};
//! # let file = concat!(env!("CARGO_MANIFEST_DIR"), "/../../data/scenes/two_blocks.obj");
//! let scene = Scene::read(file, Degenerate::Refuse)?;
//! let certificate = certify(&scene, &Request { width: 0.2, ..Request::default() })?;
//! let mean = certificate.mean[0];
//! println!("between {} and {}, with probability 1 - {}", mean.lower, mean.upper, certificate.delta);
//! assert!(0.0 < mean.lower && mean.lower < mean.upper);
//! # Ok::<(), radgrad_certificate::Error>(())
//! ```

mod betting;
mod error;
mod mean;
mod model;
mod paths;
mod points;
#[cfg(test)]
mod rooms;
mod sampling;
mod source;

pub use error::Error;
pub use mean::{certify, certify_until};
pub use points::{Place, PointCertificate, certify_points, certify_points_until};

/// The request for a certificate: half-width, probability of failure, number of rays and seed.
///
/// ```
/// use radgrad_certificate::Request;
/// let request = Request { width: 0.005, ..Request::default() };
/// assert_eq!(request.delta, 1e-6);
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Request {
    /// The probability that any of the intervals fails.
    pub delta: f64,
    /// Half the width of each interval, over the mean radiosity that is reflected, or over the irradiance of a point: no more walks are made
    /// once it is reached.
    pub width: f64,
    /// Rays after which no more walks are made, whatever the width; for each point the same again.
    pub rays: u64,
    /// The seed of the random numbers (`ChaCha`, eight rounds).
    pub seed: u64,
}

impl Default for Request {
    fn default() -> Self {
        Self { delta: 1e-6, width: 0.01, rays: 20_000_000, seed: 1 }
    }
}

impl Request {
    fn check(&self) -> Result<(), Error> {
        if !(self.delta > 0.0 && self.delta < 1.0) {
            return Err(Error::Delta { value: self.delta });
        }
        if self.width > 0.0 { Ok(()) } else { Err(Error::Width { value: self.width }) }
    }
}

/// The least and the largest value that is not excluded. The upper end is infinite where walks may meet faces for ever that
/// absorb nothing.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Interval {
    /// The least value.
    pub lower: f64,
    /// The largest value.
    pub upper: f64,
}

impl Interval {
    /// Whether a value is not excluded.
    #[must_use]
    pub fn contains(&self, value: f64) -> bool {
        self.lower <= value && value <= self.upper
    }

    /// Half the width.
    #[must_use]
    pub fn half_width(&self) -> f64 {
        0.5 * (self.upper - self.lower)
    }

    fn map(self, f: impl Fn(f64) -> f64) -> Self {
        Self { lower: f(self.lower), upper: f(self.upper) }
    }
}

/// The certificate of a scene's mean radiosity.
#[derive(Debug, Clone, PartialEq)]
pub struct Certificate {
    /// The mean radiosity over all area that exchanges light, in each channel, in the unit of the scene's radiance times pi.
    pub mean: Vec<Interval>,
    /// The part of it that is reflected.
    pub reflected: Vec<Interval>,
    /// The mean reflected radiosity of each surface, in each channel, as the walks find it: an estimate, without an interval.
    pub surfaces: Vec<Vec<f64>>,
    /// The probability that any of the intervals fails.
    pub delta: f64,
    /// The seed.
    pub seed: u64,
    /// Walks, and their rays.
    pub walks: usize,
    /// Rays of all walks, with those of pilots.
    pub rays: u64,
}
