//! A scene before anything is computed from it: moved and scaled where that matters, exactly, and checked against the rules of its
//! model.
//!
//! Answers do not depend on the origin or on the unit of length. Rounding does: a point of a unit square near 1e9 is known to 1e-7,
//! and the square of a length near 1e200 to nothing. So a scene far from the origin is moved, and one of an extraordinary unit is
//! scaled. No coordinate is rounded by it:
//!
//! - With e the largest extent along an axis, an axis is moved by the middle c of its coordinates if `|c| >= 2 e`. Then all of them
//!   are between c/2 and 2c, and each difference is exact (P. Sterbenz 1974). Else no coordinate is above 2.5 e, and little is lost
//!   by staying.
//!   Rounding at that size is taken back where faces share planes ([`super::healing`]).
//! - If the largest coordinate is then not between 2^-64 and 2^64, the power of two that brings it to [1/2, 1) multiplies all. Only
//!   underflow makes that inexact, where a scene has lengths of very different sizes: it is refused.

use std::cell::OnceCell;
use std::sync::{Arc, PoisonError};

use radgrad_core::{DVec3, Polygon};

use super::healing::weld;
use super::indexed::{Indexed, Known};
use super::{Face, Modelling, Scene, overlaps};
use crate::error::Error;
use crate::extremes::largest;
use crate::occluders::Occluders;
use crate::placement::Placement;
use crate::projection::normalising_power;
use crate::texture::Quantity;
use crate::warning::Warning;

/// Binary digits that coordinates should leave to the extent of a scene.
const ENOUGH_DIGITS: i32 = 24;

/// Largest coordinates of scenes that stay in their unit: fourth powers of lengths are far from the ends of doubles.
const ORDINARY: std::ops::RangeInclusive<f64> = 1.0 / (1u128 << 64) as f64..=(1u128 << 64) as f64;

/// A scene that is ready: moved, scaled and checked.
///
/// ```
/// use radgrad_core::{DVec3, Polygon};
/// use radgrad_scene::{Prepared, Scene};
/// let mut scene = Scene::new(["grey"])?;
/// let (white, floor) = (scene.add_material("white", [0.8], [0.0])?, scene.add_surface("floor"));
/// let far_away = [(0.0, 0.0), (4.0, 0.0), (4.0, 4.0), (0.0, 4.0)].map(|(x, y)| DVec3::new(1e9 + x, y, 0.0));
/// scene.add_face(floor, white, Polygon::new(far_away.to_vec()).unwrap(), None)?;
/// let Prepared { scene: ready, placement, .. } = Prepared::new(&scene)?;
/// assert_eq!(ready.polygons().next().unwrap().vertices()[0], DVec3::new(-2.0, 0.0, 0.0));
/// assert_eq!(placement.outward(DVec3::new(-2.0, 0.0, 0.0)), far_away[0]);
/// # Ok::<(), radgrad_scene::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct Prepared {
    /// The scene near the origin, in a unit in which powers of its lengths are doubles.
    pub scene: Scene,
    /// How it was moved and scaled.
    pub placement: Placement,
    /// The index of its polygons.
    pub index: Arc<Occluders>,
    /// Properties of the scene that are probably not meant.
    pub warnings: Vec<Warning>,
}

impl Prepared {
    /// Moves, scales and checks a scene.
    ///
    /// # Errors
    /// If its lengths are of so different sizes that no double of one unit has them all; if a face is then no polygon any more, its
    /// vertices being off its plane by the rounding of large coordinates; or if two faces overlap in one plane, so that light
    /// from there would count twice.
    pub fn new(scene: &Scene) -> Result<Self, Error> {
        let placement = centring(scene);
        let ready = scene.placed(&placement)?;
        // Faces that were cut far away have corners that were rounded there.
        let rounding = 4.0 * f64::EPSILON * placement.centre.abs().max_element() * placement.power;
        let precision = ready.modelling.precision + rounding;
        let index = match scene.indexed.of(&ready, precision) {
            Some(index) => index,
            None => {
                let index = Arc::new(Occluders::new(ready.polygons()));
                let pairs = overlaps::pairs(&ready, &index, precision);
                overlaps::refused(pairs.iter().map(|pair| pair.named(scene, |at| placement.outward(at))))?;
                scene.indexed.keep(&ready, precision, &index);
                index
            }
        };
        let mut warnings: Vec<Warning> = coarse(scene).into_iter().collect();
        warnings.extend(ready.unlit(&index));
        Ok(Self { scene: ready, placement, index, warnings })
    }
}

/// The placement that brings a scene to its centre, and extraordinary lengths near 1.
fn centring(scene: &Scene) -> Placement {
    let Some((low, high)) = scene.bounds() else { return Placement::default() };
    // Halves cannot overflow.
    let (middle, half) = (low * 0.5 + high * 0.5, (high * 0.5 - low * 0.5).max_element());
    let is_far = |axis: usize| 0.25 * middle[axis].abs() >= half;
    let centre = DVec3::from([0, 1, 2].map(|axis| if is_far(axis) { middle[axis] } else { 0.0 }));
    let largest = (low - centre).abs().max((high - centre).abs()).max_element();
    let power = if ORDINARY.contains(&largest) { 1.0 } else { normalising_power(largest) };
    Placement { centre, power }
}

impl Indexed {
    fn faces(ready: &Scene) -> impl Iterator<Item = (&Polygon, usize, bool)> {
        ready.faces().iter().map(|face| (face.polygon(), face.surface(), ready.surfaces()[face.surface()].exchanges()))
    }

    fn of(&self, ready: &Scene, precision: f64) -> Option<Arc<Occluders>> {
        let cache = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let indexed = cache.as_ref().filter(|known| known.precision == precision)?;
        let is_same =
            Self::faces(ready).eq(indexed.faces.iter().map(|(polygon, surface, exchanges)| (polygon, *surface, *exchanges)));
        is_same.then(|| Arc::clone(&indexed.index))
    }

    fn keep(&self, ready: &Scene, precision: f64, index: &Arc<Occluders>) {
        let faces = Self::faces(ready).map(|(polygon, surface, exchanges)| (polygon.clone(), surface, exchanges)).collect();
        let indexed = Known { faces, precision, index: Arc::clone(index) };
        *self.0.lock().unwrap_or_else(PoisonError::into_inner) = Some(indexed);
    }
}

/// Whether doubles are so far apart at a scene's coordinates that they leave few digits to its extent.
fn coarse(scene: &Scene) -> Option<Warning> {
    let (low, high) = scene.bounds()?;
    // Half of it cannot overflow.
    let (half, largest) = ((high * 0.5 - low * 0.5).max_element(), low.abs().max(high.abs()).max_element());
    let spacing = largest - largest.next_down();
    let digits = libm::frexp(half / spacing).1;
    (digits < ENOUGH_DIGITS).then_some(Warning::Coarse { largest, spacing, digits })
}

impl Scene {
    fn placed(&self, placement: &Placement) -> Result<Self, Error> {
        let mut scene = self.clone();
        let mut outlines: Vec<Vec<DVec3>> = Vec::with_capacity(scene.faces.len());
        for (index, face) in scene.faces.iter().enumerate() {
            let from = face.polygon.vertices();
            let to: Vec<DVec3> = from.iter().map(|&v| placement.inward(v)).collect();
            // The inverse of a power of two is one as well.
            if let Some(vertex) = from.iter().zip(&to).position(|(&v, &w)| w / placement.power != v - placement.centre) {
                let (face, value) = (self.name_of(index), from[vertex]);
                return Err(Error::Range { face, vertex, value, power: placement.power });
            }
            outlines.push(to);
        }
        let Modelling { precision, distance, .. } = &mut scene.modelling;
        (*precision, *distance) = (*precision * placement.power, *distance * placement.power);
        if placement.centre != DVec3::ZERO {
            let coordinates = self.polygons().flat_map(Polygon::vertices).map(|v| v.abs().max_element());
            // Half a unit in the last place of the largest, and half of that again.
            let rounding = 0.75 * f64::EPSILON * coordinates.fold(0.0, largest) * placement.power;
            *precision += rounding;
            let mut welded = weld(outlines.iter().map(Vec::as_slice), rounding);
            welded.flatten(rounding);
            outlines = (0..outlines.len()).map(|face| welded.outline(face)).collect();
        }
        for (index, (face, outline)) in scene.faces.iter_mut().zip(outlines).enumerate() {
            let moved = face.polygon.vertices().iter().zip(&outline).map(|(&from, &to)| (placement.inward(from) - to).length());
            face.moved = face.moved * placement.power + moved.fold(0.0, largest);
            let precision = face.polygon.precision() * placement.power;
            face.polygon = Polygon::from_rounded(outline, precision)
                .map_err(|source| Error::Placed { face: self.name_of(index), source })?;
            for chart in face.charts.iter_mut().flatten() {
                *chart = chart.placed(placement);
            }
        }
        Ok(scene)
    }

    /// Whether a face gives and takes light.
    pub(crate) fn exchanges(&self, face: usize) -> bool {
        self.surfaces[self.faces[face].surface].exchanges
    }

    /// A face with its surface, and its place where it was read: as errors name it. There must be one of this index.
    #[must_use]
    pub fn name_of(&self, face: usize) -> String {
        let Face { surface, place, .. } = &self.faces[face];
        let name = format!("face {face} of `{}`", self.surfaces[*surface].name);
        place.as_ref().map_or_else(|| name.clone(), |place| format!("{name} ({place})"))
    }

    /// Lamps and surfaces with nothing before them.
    fn unlit(&self, index: &Occluders) -> Vec<Warning> {
        let exchanging: Vec<usize> = (0..self.faces.len()).filter(|&face| self.exchanges(face)).collect();
        // Asked of few faces mostly: of lamps, and of a surface until one of its faces sees another.
        let blindness: Vec<OnceCell<bool>> = vec![OnceCell::new(); self.faces.len()];
        let is_blind = |&face: &usize| *blindness[face].get_or_init(|| !index.faces_any(face, |other| self.exchanges(other)));
        let emits = |face: usize| (0..self.channels.len()).any(|channel| self.mean_over(face, Quantity::Radiance, channel) > 0.0);
        let lamps: Vec<usize> = exchanging.iter().copied().filter(|&face| emits(face)).collect();
        let mut warnings = Vec::new();
        if lamps.is_empty() {
            warnings.push(Warning::Dark);
        }
        if exchanging.len() > 1 && exchanging.iter().all(is_blind) {
            warnings.push(Warning::InsideOut);
            return warnings;
        }
        let named = |keep: &dyn Fn(&[usize]) -> bool| {
            let chosen = self.surfaces.iter().filter(|surface| surface.exchanges && keep(&surface.faces));
            chosen.map(|surface| surface.name.clone()).collect::<Vec<String>>()
        };
        let lights_nothing = |faces: &[usize]| faces.iter().any(|face| lamps.binary_search(face).is_ok() && is_blind(face));
        let sees_nothing = |faces: &[usize]| faces.iter().all(is_blind) && !lights_nothing(faces);
        let useless = named(&lights_nothing);
        if !useless.is_empty() {
            warnings.push(Warning::LightsNothing { surfaces: useless });
        }
        let blind = named(&sees_nothing);
        if !blind.is_empty() {
            warnings.push(Warning::SeesNothing { surfaces: blind });
        }
        warnings
    }
}

#[cfg(test)]
mod tests;
