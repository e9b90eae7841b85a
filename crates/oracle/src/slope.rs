//! How the enclosed radiosity changes along a path: of the vertices of emitter and occluders, of the emission, of the receiver.
//!
//! Central differences of enclosures of many digits, whose steps are so long that the rounding of coordinates is lost in them: of
//! orders 2, 4 and 6 by steps of 1/2, 1 and 2 (L. F. Richardson 1911). The distance between the two best is an estimate of
//! the error, and tells a path that is not smooth. A corner or a jump at the place itself is lost in differences of both sides: the
//! mean of the two, extrapolated likewise, is then not what is there, and that over the step is added.

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
/// let (floor, lamp, _) = path(0.0)?;
/// let radiosity = radgrad_oracle::enclose(&floor, &lamp, 20)?.radiosity.to_f64();
/// assert!((slope.value / radiosity + 2.0).abs() < 1e-3 && slope.error < 1e-9);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Slope {
    /// The derivative by the path's parameter, at 0.
    pub value: f64,
    /// Estimate of its error.
    pub error: f64,
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
    let here = radiosity(0.0)?;
    // The central difference, the mean of both ends over what is here, and the radius, each over the step.
    let central = |step: f64| -> Result<[f64; 3], Error> {
        let [ahead, behind] = [radiosity(step)?, radiosity(-step)?];
        let change = ahead.less(&behind);
        let rise = 0.5 * (ahead.less(&here).to_f64() + behind.less(&here).to_f64());
        Ok([change.to_f64() / (2.0 * step), rise / step, change.radius() / (2.0 * step)])
    };
    let [half, one, two] = [central(0.5 * step)?, central(step)?, central(2.0 * step)?];
    let slope = Extrapolated::new([half[0], one[0], two[0]]);
    // Over one step each.
    let rise = Extrapolated::new([0.5 * half[1], one[1], 2.0 * two[1]]);
    // The weights of the three in all.
    let radius = 2.0 * half[2] + one[2] + two[2];
    Ok(Slope { value: slope.sixth, error: (slope.sixth - slope.fourth).abs() + rise.sixth.abs() + radius })
}

/// The limit of an even function of the step at 0, from half of one, one and two.
struct Extrapolated {
    fourth: f64,
    sixth: f64,
}

impl Extrapolated {
    fn new([half, one, two]: [f64; 3]) -> Self {
        let [fine, coarse] = [(4.0 * half - one) / 3.0, (4.0 * one - two) / 3.0];
        Self { fourth: fine, sixth: (16.0 * fine - coarse) / 15.0 }
    }
}

#[cfg(test)]
mod tests {
    use radgrad_core::{DVec3, Emission};

    use super::*;

    /// The slope at a lamp whose screen is moved by that function of the parameter.
    fn past_a_screen(moved: impl Fn(f64) -> f64) -> Slope {
        let polygon = |corners: [[f64; 3]; 3]| Polygon::new(corners.map(DVec3::from).to_vec());
        let path = |parameter: f64| {
            let lamp = polygon([[-1.0, -1.0, 2.0], [0.3, 1.0, 2.0], [1.0, -1.0, 2.0]])?;
            let along = moved(parameter);
            let screen = polygon([[along, -2.0, 1.0], [along, 2.0, 1.0], [3.0, 0.0, 1.0]])?;
            Ok((Receiver::new(DVec3::ZERO, DVec3::Z, 1.0)?, Emitter::new(lamp, Emission::Constant(1.0))?, vec![screen]))
        };
        slope_along(path, 1.0 / 1024.0, 18).unwrap()
    }

    #[test]
    fn a_corner_or_a_jump_at_the_place_itself_is_no_slope() {
        let smooth = past_a_screen(|parameter| parameter);
        assert!(smooth.value > 0.05 && smooth.error < 1e-9, "{smooth:?}");
        // Central differences of these are as smooth as can be.
        for moved in [|parameter: f64| parameter.abs(), |parameter: f64| if parameter == 0.0 { 1e-4 } else { parameter }] {
            let slope = past_a_screen(moved);
            assert!(slope.error > 1e-3, "{slope:?}");
        }
    }
}
