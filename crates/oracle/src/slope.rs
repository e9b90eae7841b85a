//! How the enclosed radiosity changes along a path: of the vertices of emitter and occluders, of the normal, of the emission.
//!
//! Central differences of enclosures of many digits, of orders 2, 4 and 6 by steps of 1/2, 1 and 2 (L. F. Richardson 1911). The distance
//! between the two best is an estimate of the error, and tells a path that is not smooth. A corner or a jump at the place itself is lost in
//! differences of both sides: the mean of the two, extrapolated likewise, then differs from the value there, and that over the step is added.
//! Something beside the place that is narrower than the steps is not told: then a shorter step does, with more digits.

use crate::Error;
use crate::enclosure::interval::Interval;

/// The derivative of the radiosity along a path.
///
/// ```
/// # use radgrad_core::{DVec3, Emission, Emitter, Polygon, Receiver};
/// use radgrad_oracle::{Motion, Request, Source, enclose_moved, slope_along};
/// // A lamp that rises: between it and the point that it lights the light goes as one over the square of the distance, nearly.
/// let corners = [DVec3::ZERO, DVec3::Y, DVec3::X].map(|corner| corner * 0.01 + DVec3::Z);
/// let lamp = Emitter::new(Polygon::new(corners.to_vec())?, Emission::Constant(1e4))?;
/// let floor = Receiver::new(DVec3::ZERO, DVec3::Z, 1.0)?;
/// let motion = Motion { vertices: vec![DVec3::Z; 3], ..Motion::default() };
/// let radiosity = |height: f64| {
///     let moved = enclose_moved(&floor, &Source::Emitter(&lamp), &[], &motion, height, &Request::digits(20));
///     Ok(moved?.radiosity)
/// };
/// let slope = slope_along(radiosity, 1.0 / 512.0)?;
/// assert!((slope.value / radiosity(0.0)?.to_f64() + 2.0).abs() < 1e-3 && slope.error < 1e-9);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Slope {
    /// The derivative by the path's parameter, at 0.
    pub value: f64,
    /// Estimate of its error.
    pub error: f64,
}

/// The derivative at parameter 0 of the radiosity along a path, which is enclosed for parameters of at most two steps either way.
///
/// # Errors
/// Those of the enclosures.
pub fn slope_along(radiosity: impl Fn(f64) -> Result<Interval, Error>, step: f64) -> Result<Slope, Error> {
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
    use radgrad_core::{DVec3, Emission, Emitter, Polygon, Receiver};

    use super::*;
    use crate::{Motion, Request, Source, enclose_moved};

    /// The slope at a lamp whose screen moves along x, from that place of its edge and with that height of its plane over the receiver.
    fn past_a_screen(edge: f64, height: f64, way: DVec3) -> Slope {
        let polygon = |corners: [[f64; 3]; 3]| Polygon::new(corners.map(DVec3::from).to_vec()).unwrap();
        let lamp = polygon([[-1.0, -1.0, 2.0], [-1.0, 1.0, 2.0], [1.0, 0.0, 2.0]]);
        let lamp = Emitter::new(lamp, Emission::Constant(1.0)).unwrap();
        let screen = polygon([[edge, -3.0, height], [edge, 3.0, height], [-4.0, 0.0, height]]);
        let receiver = Receiver::new(DVec3::ZERO, DVec3::Z, 1.0).unwrap();
        let motion = Motion { occluders: vec![vec![way; 3]], ..Motion::default() };
        let radiosity = |parameter: f64| {
            let request = Request::digits(18);
            let source = Source::Emitter(&lamp);
            Ok(enclose_moved(&receiver, &source, std::slice::from_ref(&screen), &motion, parameter, &request)?.radiosity)
        };
        slope_along(radiosity, 1.0 / 1024.0).unwrap()
    }

    #[test]
    fn a_corner_or_a_jump_at_the_place_itself_is_no_slope() {
        let smooth = past_a_screen(0.25, 1.0, DVec3::X);
        assert!(smooth.value < -0.05 && smooth.error < 1e-9, "{smooth:?}");
        // The screen's edge is seen along the lamp's; the screen's plane goes through the receiver.
        for corner in [past_a_screen(-0.5, 1.0, DVec3::X), past_a_screen(0.25, 0.0, DVec3::Z)] {
            assert!(corner.error > 1e-3, "{corner:?}");
        }
    }
}
