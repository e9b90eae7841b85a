//! Certificates at points: walks begin there, against the light, and wherever they arrive the light of lamps is added in closed form.
//!
//! The irradiance of a point is that of lamps, in closed form to its proven bound, and that of reflected light: the mean over
//! directions, by the cosine, of the reflected radiosity that is met, and that is `rho` times an irradiance of the same kind.
//! Lamps that emit evenly are taken in closed form; others where a walk meets them. A lamp gives no point more than it emits, and
//! that is the range.

use std::sync::atomic::AtomicBool;

use radgrad_core::{DVec3, Receiver};
use radgrad_scene::{FormFactors, Prepared, Scene, contains, largest, smallest};
use rand::SeedableRng;
use rand::rngs::ChaCha8Rng;

use crate::error::Error;
use crate::model::Model;
use crate::paths::{Walks, by_cosine};
use crate::sampling::{Block, Trial, Walker};
use crate::source::largest_factor;
use crate::{Interval, Request};

/// Walks of one stream of random numbers.
const BLOCK: usize = 16;

/// Lamps beyond which all are taken where they are met.
const MOST_LAMPS: usize = 32;

/// The allowed error of closed forms relative to a lamp's emission: at the point, and where walks arrive.
const FINE: f64 = 1e-9;
const COARSE: f64 = 1e-4;

/// Rays that take as long as a closed form.
const CLOSED_FORM: u64 = 10;

/// How far a point may be off its face, over the extent of the scene.
const NEAR: f64 = 1e-6;

/// A point, the direction that it faces, and the face that it is on; none for a sensor in space.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Place {
    /// The point, in the scene's coordinates.
    pub position: DVec3,
    /// The direction that it faces.
    pub normal: DVec3,
    /// The face that it is on.
    pub face: Option<usize>,
}

/// The certificate of a point, in each channel.
#[derive(Debug, Clone, PartialEq)]
pub struct PointCertificate {
    /// The irradiance.
    pub irradiance: Vec<Interval>,
    /// The radiosity of a point on a face.
    pub radiosity: Option<Vec<Interval>>,
    /// Walks, and their rays, a closed form counted as ten.
    pub walks: usize,
    /// Rays, with those of the pilot.
    pub rays: u64,
}

/// Limits of the irradiance and of the radiosity at points. [`Request::delta`] is the probability that any of them fails.
///
/// ```
/// use radgrad_certificate::{Place, Request, certify_points};
/// use radgrad_core::DVec3;
/// # use radgrad_scene::{Degenerate, Scene};
/// # let file = concat!(env!("CARGO_MANIFEST_DIR"), "/../../data/scenes/two_blocks.obj");
/// let scene = Scene::read(file, Degenerate::Refuse)?;
/// let floor = Place { position: DVec3::new(2.0, 0.5, 0.0), normal: DVec3::Z, face: None };
/// let certified = certify_points(&scene, &[floor], &Request { width: 0.3, ..Request::default() })?;
/// let floor = certified[0].as_ref().map_err(Clone::clone)?;
/// assert!(floor.irradiance[0].lower > 0.0 && floor.radiosity.is_none());
/// # Ok::<(), radgrad_certificate::Error>(())
/// ```
///
/// # Errors
/// If the request is out of range, or the scene is refused; of a single point if it is not on its face, or faces nowhere.
pub fn certify_points(scene: &Scene, places: &[Place], request: &Request) -> Result<Vec<Result<PointCertificate, Error>>, Error> {
    certify_points_until(scene, places, request, &AtomicBool::new(false))
}

/// [`certify_points`] that ends with [`radgrad_scene::Error::Stopped`] soon after another thread sets `stop`.
///
/// # Errors
/// As [`certify_points`], and if it was ended.
pub fn certify_points_until(
    scene: &Scene,
    places: &[Place],
    request: &Request,
    stop: &AtomicBool,
) -> Result<Vec<Result<PointCertificate, Error>>, Error> {
    request.check()?;
    if places.is_empty() {
        return Ok(Vec::new());
    }
    let prepared = Prepared::new(scene)?;
    let model = Model::new(&prepared).until(stop);
    let light = Light::new(&model, &prepared, FormFactors::new(scene)?);
    let delta = request.delta / (places.len() * model.channels) as f64;
    let one = |(index, place)| {
        model.go_on()?;
        Ok(light.certify(index, place, (request, delta)))
    };
    let certificates = places.iter().enumerate().map(one).collect::<Result<_, Error>>()?;
    model.go_on()?;
    Ok(certificates)
}

/// How light is found where walks arrive.
struct Light<'a> {
    model: &'a Model<'a>,
    prepared: &'a Prepared,
    factors: FormFactors<'a>,
    walks: Walks<'a>,
    /// Lamps that are taken in closed form.
    lamps: Vec<usize>,
    /// Bounds in each channel on the irradiance by these lamps, and on the emission of others.
    closed: Vec<f64>,
    met: Vec<f64>,
}

impl<'a> Light<'a> {
    fn new(model: &'a Model<'a>, prepared: &'a Prepared, factors: FormFactors<'a>) -> Self {
        let even: Vec<usize> = model.lamps().filter(|(_, lamp)| lamp.emits_evenly()).map(|(lamp, _)| lamp).collect();
        let lamps = if even.len() > MOST_LAMPS { Vec::new() } else { even };
        let shares: Vec<f64> = lamps.iter().map(|&lamp| (largest_factor(model, lamp) + COARSE).min(1.0)).collect();
        let closed = |channel: usize| {
            let emitted = || lamps.iter().map(|&lamp| model.faces[lamp].emission[channel]);
            // All factors of a point are 1 at most together.
            let sum: f64 = emitted().zip(&shares).map(|(emitted, share)| emitted * share).sum();
            sum.min(emitted().fold(0.0, largest) * (1.0 + COARSE * lamps.len() as f64))
        };
        let met = |channel: usize| {
            let others = model.lamps().filter(|(lamp, _)| !lamps.contains(lamp));
            others.map(|(_, lamp)| lamp.emission[channel]).fold(0.0, largest)
        };
        let [closed, met]: [Vec<f64>; 2] = [(0..model.channels).map(closed).collect(), (0..model.channels).map(met).collect()];
        let walks = if met.iter().any(|met| *met > 0.0) { Walks::meeting(model) } else { Walks::ending(model) };
        Self { model, prepared, factors, walks, lamps, closed, met }
    }

    fn certify(&self, index: usize, place: &Place, (request, delta): (&Request, f64)) -> Result<PointCertificate, Error> {
        let Self { model, .. } = self;
        let refused = |rule: String| Error::Point { index, position: place.position, rule };
        let Some(normal) = place.normal.try_normalize() else {
            return Err(refused("the direction that it faces must be finite and not zero".to_owned()));
        };
        let point = self.prepared.placement.inward(place.position);
        if let Some(face) = place.face {
            let Some(own) = model.faces.get(face) else {
                return Err(refused(format!("there is no face {face}, they are numbered from 0 to {}", model.faces.len() - 1)));
            };
            let (outline, (low, high)) = (model.outline(face), self.prepared.scene.bounds().unwrap_or_default());
            let (height, reach) = (own.normal.dot(point - outline[0]).abs(), NEAR * (high - low).length());
            let is_on = height <= reach && (contains(outline, own.normal, point) || is_beside(outline, point, reach));
            if !is_on || own.normal.dot(normal) <= 0.0 {
                return Err(refused(format!("it must be on face {face} and face the way that that does")));
            }
        }
        let direct = self.direct(place.face, place.position, normal, FINE).map_err(|source| refused(source.to_string()))?;
        let walker = FromPoint { light: self, walks: self.walks.clone(), face: place.face, point, normal, direct };
        let mut trial = Trial::new(walker, request, delta, 3 + index as u64)?;
        let cut = trial.cut();
        let each = |(cut, bound): (f64, f64)| if bound > 0.0 { cut / bound } else { 0.0 };
        trial.walker.walks.cut = cut.into_iter().zip(self.to_come()).map(each).collect();
        let outcome = trial.run()?;
        let with = |(limits, direct): (&Interval, &[f64; 2])| Interval {
            lower: direct[0] + limits.lower,
            upper: direct[1] + limits.upper,
        };
        let irradiance: Vec<Interval> = outcome.limits.iter().zip(&trial.walker.direct).map(with).collect();
        let radiosity = place.face.map(|face| self.radiosity(face, point, &irradiance));
        Ok(PointCertificate { irradiance, radiosity, walks: outcome.walks, rays: outcome.rays })
    }

    /// Bound in each channel on the light of all later reflections, over the bound on the sum of their weights: lamps that are
    /// met count before the weight is reflected there.
    fn to_come(&self) -> Vec<f64> {
        let Walks { survival, more, .. } = &self.walks;
        let remaining_light = |((closed, met), more): ((&f64, &f64), &f64)| {
            closed + if *met > 0.0 && *more > 0.0 { met * (1.0 + 1.0 / more) / survival } else { 0.0 }
        };
        self.closed.iter().zip(&self.met).zip(more).map(remaining_light).collect()
    }

    /// The radiosity of a point of a face, from its irradiance.
    fn radiosity(&self, face: usize, point: DVec3, irradiance: &[Interval]) -> Vec<Interval> {
        let Self { model, .. } = self;
        let [mut reflectance, mut emission] = [vec![1.0; model.channels], vec![1.0; model.channels]];
        model.reflect(face, point, &mut reflectance);
        model.emit(face, point, &mut emission);
        let radiosity = |((interval, rho), emitted): ((&Interval, &f64), &f64)| {
            // Where nothing is reflected nothing is unknown.
            interval.map(|value| emitted + if *rho == 0.0 { 0.0 } else { rho * value })
        };
        irradiance.iter().zip(&reflectance).zip(&emission).map(radiosity).collect()
    }

    /// The least and the largest irradiance by lamps in closed form, in each channel.
    fn direct(
        &self,
        on: Option<usize>,
        position: DVec3,
        normal: DVec3,
        tolerance: f64,
    ) -> Result<Vec<[f64; 2]>, radgrad_scene::Error> {
        let mut ends = vec![[0.0; 2]; self.model.channels];
        let receiver = Receiver::new(position, normal, 1.0).map_err(radgrad_scene::Error::Receiver)?;
        for &lamp in self.lamps.iter().filter(|lamp| Some(**lamp) != on) {
            let factor = self.factors.at_point(&receiver, on, lamp, tolerance)?;
            let [low, high] = [factor.radiosity - factor.radiosity_error, factor.radiosity + factor.radiosity_error];
            for (ends, emitted) in ends.iter_mut().zip(&self.model.faces[lamp].emission) {
                *ends = [ends[0] + emitted * largest(low, 0.0), ends[1] + emitted * high];
            }
        }
        Ok(ends)
    }
}

/// Whether a point is within `reach` of an outline.
fn is_beside(outline: &[DVec3], point: DVec3, reach: f64) -> bool {
    let edges = outline.iter().zip(outline.iter().cycle().skip(1));
    edges.map(|(from, to)| (*from, *to - *from)).any(|(from, along)| {
        let share = along.dot(point - from) / along.length_squared();
        (point - from - along * share.clamp(0.0, 1.0)).length() <= reach
    })
}

/// Walks from a point.
struct FromPoint<'a> {
    light: &'a Light<'a>,
    walks: Walks<'a>,
    face: Option<usize>,
    point: DVec3,
    normal: DVec3,
    /// Its direct light in closed form.
    direct: Vec<[f64; 2]>,
}

impl Walker for FromPoint<'_> {
    fn block(&self, seed: u64, stream: u64) -> Result<Block, Error> {
        let Light { model, lamps, .. } = self.light;
        let mut generator = ChaCha8Rng::seed_from_u64(seed);
        generator.set_stream(stream);
        let mut block = Block::default();
        let mut weights = vec![1.0; model.channels];
        for _ in 0..BLOCK {
            model.go_on()?;
            let first = block.sums.len();
            block.sums.resize(first + model.channels, [0.0; 2]);
            weights.fill(1.0);
            block.rays += 1;
            let mut next = model.hit(self.face, self.point, by_cosine(self.normal, &mut generator));
            while let Some((face, point)) = next {
                let sums = &mut block.sums[first..];
                if !lamps.contains(&face) {
                    let mut met = weights.clone();
                    model.emit(face, point, &mut met);
                    sums.iter_mut().zip(met).for_each(|(ends, met)| *ends = ends.map(|end| end + met));
                }
                model.reflect(face, point, &mut weights);
                if !lamps.is_empty() && weights.iter().any(|weight| *weight > 0.0) {
                    block.rays += CLOSED_FORM;
                    let outward = self.light.prepared.placement.outward(point);
                    let direct = self.light.direct(Some(face), outward, model.faces[face].normal, COARSE)?;
                    for (channel, ends) in sums.iter_mut().enumerate() {
                        // The bounds of the closed form do not say that the value is at most the range.
                        let [low, high] = [direct[channel][0], smallest(direct[channel][1], self.light.closed[channel])];
                        *ends = [ends[0] + weights[channel] * low, ends[1] + weights[channel] * high];
                    }
                }
                next = self.walks.go_on(face, point, &mut weights, &mut generator, &mut block.rays);
            }
        }
        Ok(block)
    }

    fn ranges(&self) -> Vec<f64> {
        let Light { closed, met, .. } = self.light;
        let range = |channel: usize| {
            let times = |light: f64, times: f64| if light == 0.0 { 0.0 } else { light * times };
            times(closed[channel], self.walks.weight_limits[channel]) + times(met[channel], 1.0 + self.walks.more[channel])
        };
        (0..closed.len()).map(range).collect()
    }

    fn deterministic_part(&self) -> Vec<f64> {
        self.direct.iter().map(|[_, high]| *high).collect()
    }

    fn leaves_out(&self) -> Vec<f64> {
        self.walks.cut.iter().zip(self.light.to_come()).map(|(cut, bound)| cut * bound).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rooms::{self, Room};
    use crate::sampling::tests::limits;

    /// Checks walks from a point of a room in which the radiosity is 1 against their expectation, less the allowed truncation.
    fn hold(room: &Room, cut: f64) -> Result<(), Error> {
        let prepared = Prepared::new(&room.scene)?;
        let model = Model::new(&prepared);
        let light = Light::new(&model, &prepared, FormFactors::new(&room.scene)?);
        let point = prepared.placement.inward(room.point);
        let direct = light.direct(Some(0), room.point, DVec3::Z, FINE)?;
        let walks = Walks { cut: vec![cut], ..light.walks.clone() };
        let walker = FromPoint { light: &light, walks, face: Some(0), point, normal: DVec3::Z, direct };
        let range = walker.ranges()[0];
        let [[low, _], [_, high]] = limits(&walker, 300)?[0];
        let [low, high] = [low * range + walker.direct[0][0], high * range + walker.leaves_out()[0] + walker.direct[0][1]];
        assert!(low <= 1.0 && 1.0 <= high, "cut {cut}: {low} to {high}");
        assert!(cut > 0.0 || high - low < 0.3, "{low} to {high}");
        Ok(())
    }

    #[test]
    fn walks_have_the_mean_and_no_sum_beyond_its_range() -> Result<(), Error> {
        // Lamps in closed form, and lamps that are met; the last of few faces that reflect.
        let rooms = [[0.5; 8], [0.05; 8], [0.0, 0.9, 0.3, 0.7, 0.5, 0.2, 0.8, 0.1], [0.0, 0.5, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]];
        for reflectances in rooms {
            for (is_textured, cut) in [(false, 0.0), (true, 0.02)] {
                hold(&rooms::furnace(reflectances, is_textured), cut)?;
            }
        }
        Ok(())
    }

    #[test]
    fn no_hit_is_brighter_than_the_largest_factor_of_a_lamp() -> Result<(), Error> {
        let scene = rooms::lamp_over_a_floor();
        let prepared = Prepared::new(&scene)?;
        let model = Model::new(&prepared);
        let light = Light::new(&model, &prepared, FormFactors::new(&scene)?);
        let normal = DVec3::NEG_Z;
        let position = DVec3::new(0.5, 0.5, 0.4);
        let direct = light.direct(None, position, normal, FINE)?;
        let point = prepared.placement.inward(position);
        let walker = FromPoint { light: &light, walks: light.walks.clone(), face: None, point, normal, direct };
        let largest_sum = walker.block(1, 0)?.sums.iter().map(|[low, _]| *low).fold(0.0, largest);
        let range = walker.ranges()[0];
        // In the middle about its area over pi, times the reflectance.
        assert!(largest_sum > 0.01 && largest_sum <= range && range < 1.1 * largest_sum, "{largest_sum} of {range}");
        Ok(())
    }
}
