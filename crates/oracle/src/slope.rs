//! How the enclosed radiosity changes along a path: of the vertices of emitter and occluders, of the emission, of the receiver.
//!
//! Central differences of enclosures of many digits, whose steps are so long that the rounding of coordinates is lost in them: of
//! orders 2, 4 and 6 by steps of 1/2, 1 and 2 (L. F. Richardson 1911). The distance between the two best is an estimate of
//! the error, and tells a path that is not smooth.

use radgrad_core::{Emitter, Polygon, Receiver};

use crate::enclosure::interval::Interval;
use crate::{Error, enclose_occluded};

/// The derivative of the radiosity along a path.
///
/// ```
/// # use radgrad_core::{DVec3, Emission, Emitter, Polygon, Receiver};
/// // A lamp that rises: between it and the point that it lights the light goes as one over the square of the distance, nearly.
/// let path = |step: f64| {
///     let corners = [DVec3::ZERO, DVec3::Y, DVec3::X].map(|corner| corner * 0.01 + DVec3::Z * (1.0 + step));
///     let lamp = Emitter::new(Polygon::new(corners.to_vec())?, Emission::Constant(1e4))?;
///     Ok((Receiver::new(DVec3::ZERO, DVec3::Z, 1.0)?, lamp, Vec::new()))
/// };
/// let slope = radgrad_oracle::slope_along(path, 1.0 / 512.0, 20)?;
/// assert!((slope.value / slope.radiosity + 2.0).abs() < 1e-3 && slope.error < 1e-9);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Slope {
    /// The derivative by the path's parameter, at 0.
    pub value: f64,
    /// Estimate of its error.
    pub error: f64,
    /// The radiosity there.
    pub radiosity: f64,
}

/// The derivative of the radiosity at parameter 0 of a path, which gives the case for a parameter of at most two steps either way.
///
/// # Errors
/// As [`enclose_occluded`], or if the path has no such case.
pub fn slope_along(
    path: impl Fn(f64) -> Result<(Receiver, Emitter, Vec<Polygon>), radgrad_core::Error>,
    step: f64,
    digits: u32,
) -> Result<Slope, Error> {
    let radiosity = |parameter: f64| -> Result<Interval, Error> {
        let (receiver, emitter, occluders) = path(parameter).map_err(Error::Problem)?;
        Ok(enclose_occluded(&receiver, &emitter, &occluders, digits)?.radiosity)
    };
    let central = |step: f64| -> Result<[f64; 2], Error> {
        let change = radiosity(step)?.less(&radiosity(-step)?);
        Ok([change.to_f64() / (2.0 * step), change.radius() / (2.0 * step)])
    };
    let [[half, by_half], [one, by_one], [two, by_two]] = [central(0.5 * step)?, central(step)?, central(2.0 * step)?];
    let [fine, coarse] = [(4.0 * half - one) / 3.0, (4.0 * one - two) / 3.0];
    let value = (16.0 * fine - coarse) / 15.0;
    // The weights of the three in all.
    let radius = 2.0 * by_half + by_one + by_two;
    Ok(Slope { value, error: (value - fine).abs() + radius, radiosity: radiosity(0.0)?.to_f64() })
}
