//! Certificates at points: walks begin there, against the light, and wherever they arrive the light of lamps is added in closed form.
//!
//! The irradiance of a point is that of lamps, in closed form to its proven bound, and what the rest reflects: the mean over directions, by the
//! cosine, of the radiosity that is met, and that is `rho` times an irradiance of the same kind. Lamps that emit evenly are taken in closed form; others
//! where a walk meets them. A lamp gives no point more than it emits, and that is the range.

use radgrad_core::{DVec3, Receiver};
use radgrad_scene::{FormFactors, Prepared, Scene, contains, largest};
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

/// The error that closed forms may have, by what a lamp emits: at the point, and where walks arrive.
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
    request.check()?;
    if places.is_empty() {
        return Ok(Vec::new());
    }
    let prepared = Prepared::of(scene)?;
    let model = Model::new(&prepared);
    let light = Light::new(&model, &prepared, FormFactors::new(scene)?);
    let delta = request.delta / (places.len() * model.channels) as f64;
    Ok(places.iter().enumerate().map(|(index, place)| light.certify(index, place, (request, delta))).collect())
}

/// How light is found where walks arrive.
struct Light<'a> {
    model: &'a Model<'a>,
    prepared: &'a Prepared,
    factors: FormFactors<'a>,
    walks: Walks<'a>,
    /// Lamps that are taken in closed form.
    lamps: Vec<usize>,
    /// Of each channel, the most irradiance by these, and the most that others emit.
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
        Self { model, prepared, factors, walks: Walks::ending(model), lamps, closed, met }
    }

    fn certify(&self, index: usize, place: &Place, (request, delta): (&Request, f64)) -> Result<PointCertificate, Error> {
        let Self { model, .. } = self;
        let refused = |rule: String| Error::Point { index, position: place.position, rule };
        let Some(normal) = place.normal.try_normalize() else {
            return Err(refused("the direction that it faces must be finite and not zero".to_owned()));
        };
        let point = self.prepared.placement.inward(place.position);
        if let Some(face) = place.face {
            let Some(known) = model.faces.get(face) else {
                return Err(refused(format!("there is no face {face}, they are numbered from 0 to {}", model.faces.len() - 1)));
            };
            let (outline, (low, high)) = (model.outline(face), self.prepared.scene.bounds().unwrap_or_default());
            let (height, reach) = (known.normal.dot(point - outline[0]).abs(), NEAR * (high - low).length());
            let is_on = height <= reach && (contains(outline, known.normal, point) || is_beside(outline, point, reach));
            if !is_on || known.normal.dot(normal) <= 0.0 {
                return Err(refused(format!("it must be on face {face} and face the way that that does")));
            }
        }
        let direct = self.direct(place.face, place.position, normal, FINE).map_err(|source| refused(source.to_string()))?;
        let walker = FromPoint { light: self, walks: self.walks.clone(), face: place.face, point, normal, direct };
        let mut trial = Trial::new(walker, request, delta, 3 + index as u64)?;
        let cut = trial.cut();
        let each = |(channel, cut): (usize, f64)| {
            let most = self.closed[channel] + self.met[channel];
            if most > 0.0 { cut / most } else { 0.0 }
        };
        trial.walker.walks.cut = cut.into_iter().enumerate().map(each).collect();
        let outcome = trial.run()?;
        let with = |(limits, direct): (&Interval, &[f64; 2])| Interval {
            lower: direct[0] + limits.lower,
            upper: direct[1] + limits.upper,
        };
        let irradiance: Vec<Interval> = outcome.limits.iter().zip(&trial.walker.direct).map(with).collect();
        let radiosity = place.face.map(|face| self.radiosity(face, point, &irradiance));
        Ok(PointCertificate { irradiance, radiosity, walks: outcome.walks, rays: outcome.rays })
    }

    /// The radiosity of a point of a face, from its irradiance.
    fn radiosity(&self, face: usize, point: DVec3, irradiance: &[Interval]) -> Vec<Interval> {
        let Self { model, .. } = self;
        let [mut reflectance, mut emission] = [vec![1.0; model.channels], vec![1.0; model.channels]];
        model.reflect(face, point, &mut reflectance);
        model.emit(face, point, &mut emission);
        let of = |((interval, rho), emitted): ((&Interval, &f64), &f64)| {
            // Where nothing is reflected nothing is unknown.
            interval.map(|value| emitted + if *rho == 0.0 { 0.0 } else { rho * value })
        };
        irradiance.iter().zip(&reflectance).zip(&emission).map(of).collect()
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
                    for ((ends, direct), weight) in sums.iter_mut().zip(direct).zip(&weights) {
                        *ends = [0, 1].map(|end| ends[end] + weight * direct[end]);
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
            times(closed[channel], self.walks.most[channel]) + times(met[channel], 1.0 + self.walks.more[channel])
        };
        (0..closed.len()).map(range).collect()
    }

    fn known(&self) -> Vec<f64> {
        self.direct.iter().map(|[_, high]| *high).collect()
    }

    fn leaves_out(&self) -> Vec<f64> {
        let Light { closed, met, .. } = self.light;
        self.walks.cut.iter().zip(closed).zip(met).map(|((cut, closed), met)| cut * (closed + met)).collect()
    }
}
