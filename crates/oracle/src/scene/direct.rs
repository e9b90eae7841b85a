//! Direct light at a point: the oracle's enclosures, lamp by lamp, past all that may hide it.

use glam::DVec3;
use radgrad_core::{Emission, Emitter, Polygon, Receiver};

use super::{Point, Scene};
use crate::confidence::ConfidenceInterval;
use crate::enclosure::source::Source;
use crate::enclosure::{Request, enclose_source_occluded};
use crate::error::Error;

impl Scene {
    /// Encloses the irradiance `D` that reaches a point straight from lamps, to so many digits of each lamp's.
    ///
    /// ```
    /// use radgrad_core::{DVec3, Polygon};
    /// use radgrad_oracle::scene::{Face, Point, Scene};
    /// let square = |z: f64| [(0.0, 0.0), (0.0, 1.0), (1.0, 1.0), (1.0, 0.0)].map(|(x, y)| DVec3::new(x, y, z));
    /// let face = |mut corners: [DVec3; 4], up: bool, reflectance: f64, emitted: f64| {
    ///     if up { corners.reverse() }
    ///     Polygon::new(corners.to_vec()).map(|polygon| Face { polygon, reflectance, emitted, exchanges: true, pattern: None })
    /// };
    /// let scene = Scene::new(vec![face(square(0.0), true, 0.5, 0.0)?, face(square(1.0), false, 0.0, 1.0)?])?;
    /// let direct = scene.direct(&Point { face: 0, position: DVec3::ZERO }, 15)?;
    /// assert!((direct.low - 0.138_531_605_994_893).abs() < 1e-15 && direct.width() < 1e-15);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// If a lamp has a pattern, or one cannot be enclosed.
    pub fn direct(&self, point: &Point, digits: u32) -> Result<ConfidenceInterval, Error> {
        self.irradiance(point, digits, |face| self.faces[face].emitted)
    }

    /// The same of faces with other radiosities than they emit.
    ///
    /// # Errors
    /// As [`Self::direct`].
    pub fn irradiance(&self, point: &Point, digits: u32, radiosity: impl Fn(usize) -> f64) -> Result<ConfidenceInterval, Error> {
        let receiver = Receiver::new(point.position, self.faces[point.face].polygon.normal(), 1.0).map_err(Error::Problem)?;
        let mut sum = ConfidenceInterval { low: 0.0, high: 0.0 };
        for (lamp, face) in self.faces.iter().enumerate() {
            let emitted = radiosity(lamp);
            let dark = emitted == 0.0 || !face.exchanges || self.caster.is_level(lamp, point.face);
            if dark {
                continue;
            }
            if face.pattern.is_some() {
                return Err(Error::Patterned { face: lamp });
            }
            let emitter = Emitter::new(face.polygon.clone(), Emission::Constant(emitted)).map_err(Error::Problem)?;
            let hiding = self.may_hide(point, lamp);
            let request = Request { budget: BUDGET, ..Request::digits(digits) };
            let enclosed = enclose_source_occluded(&receiver, &Source::Emitter(&emitter), &hiding, &request)?;
            let (low, high) = enclosed.radiosity.bounds();
            sum = ConfidenceInterval { low: (sum.low + low).next_down(), high: (sum.high + high).next_up() };
        }
        Ok(sum)
    }

    /// The polygons whose boxes meet that of the point and the lamp.
    fn may_hide(&self, point: &Point, lamp: usize) -> Vec<Polygon> {
        let around = |vertices: &[DVec3], low: DVec3, high: DVec3| {
            vertices.iter().fold((low, high), |(low, high), v| (low.min(*v), high.max(*v)))
        };
        let (low, high) = around(self.faces[lamp].polygon.vertices(), point.position, point.position);
        let meets = |polygon: &Polygon| {
            let first = polygon.vertices()[0];
            let (from, to) = around(polygon.vertices(), first, first);
            from.cmple(high).all() && to.cmpge(low).all()
        };
        let others = self.faces.iter().enumerate().filter(|&(index, face)| {
            !self.caster.is_level(index, point.face) && !self.caster.is_level(index, lamp) && meets(&face.polygon)
        });
        others.map(|(_, face)| face.polygon.clone()).collect()
    }
}

/// Evaluations that the light of one lamp may take.
const BUDGET: u64 = 2_000_000;
