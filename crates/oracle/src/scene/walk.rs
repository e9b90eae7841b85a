//! Random walks and the limits that follow from them.

use std::f64::consts::PI;

use glam::DVec3;
use rand::SeedableRng;
use rand::rngs::ChaCha8Rng;

use super::sampling::{area, by_cosine, kernel, on_triangle, uniform};
use super::{Effort, Kind, Known, LEAST_WEIGHT, Point, Scene, Truth};
use crate::Error;
use crate::confidence::{ConfidenceInterval, Moments, check_confidence};

/// Walks of the pilot, which measures the cost of a walk and enters nothing else.
const PILOT: usize = 64;

/// Fewest walks: fewer say nothing.
const FEWEST: usize = 200;

/// Rounding of a contribution, a few operations a bounce, relative to the largest there may be.
const ROUNDING: f64 = 1e-13;

/// The quantity to estimate: the mean over all area, or the radiosity at a point.
#[derive(Debug, Clone, Copy)]
enum Question<'a> {
    Mean,
    At(&'a Point),
}

impl Scene {
    /// The mean reflected radiosity and the radiosity at points, each by the kind of walks whose contributions have the least
    /// range.
    ///
    /// ```
    /// use radgrad_core::{DVec3, Polygon};
    /// use radgrad_oracle::scene::{Effort, Face, Point, Scene};
    /// // A closed tetrahedron of which every face has `E = 1 - rho`: the radiosity is 1 everywhere.
    /// let [a, b, c, d] = [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z];
    /// let faces = [([a, b, c], 0.5), ([a, c, d], 0.8), ([a, d, b], 0.2), ([b, d, c], 0.7)].map(|(corners, reflectance)| Face {
    ///     polygon: Polygon::new(corners.to_vec()).unwrap(),
    ///     reflectance,
    ///     emitted: 1.0 - reflectance,
    ///     exchanges: true,
    ///     pattern: None,
    /// });
    /// let scene = Scene::new(faces.to_vec())?;
    /// let centroid = Point { face: 0, position: (a + b + c) / 3.0 };
    /// let truth = scene.truth(&[centroid], &Effort::default())?;
    /// assert!(truth.points[0].interval.contains(1.0) && truth.points[0].interval.width() < 0.02);
    /// # Ok::<(), radgrad_oracle::Error>(())
    /// ```
    ///
    /// # Errors
    /// If the confidence is not between 0 and 1, or a point is of no face.
    pub fn truth(&self, points: &[Point], effort: &Effort) -> Result<Truth, Error> {
        self.truth_by(points, effort, |range, cost| {
            let kinds = [Kind::Particles, Kind::NextEvent, Kind::Plain];
            let best = kinds.into_iter().min_by(|&a, &b| (range(a) * cost(a)).total_cmp(&(range(b) * cost(b))));
            best.unwrap_or(Kind::Plain)
        })
    }

    /// The same by walks of one kind.
    ///
    /// # Errors
    /// As [`Self::truth`].
    pub fn truth_of_kind(&self, points: &[Point], effort: &Effort, kind: Kind) -> Result<Truth, Error> {
        self.truth_by(points, effort, |_, _| kind)
    }

    fn truth_by(
        &self,
        points: &[Point],
        effort: &Effort,
        choose: impl Fn(&dyn Fn(Kind) -> f64, &dyn Fn(Kind) -> f64) -> Kind,
    ) -> Result<Truth, Error> {
        check_confidence(effort.confidence)?;
        if let Some(point) = points.iter().find(|point| point.face >= self.faces.len()) {
            return Err(Error::NoFace { face: point.face, count: self.faces.len() });
        }
        let questions: Vec<Question<'_>> = std::iter::once(Question::Mean).chain(points.iter().map(Question::At)).collect();
        // A look at a lamp costs a ray more.
        let cost = |kind: Kind| if kind == Kind::Plain { 1.0 } else { 2.0 };
        let kinds: Vec<Kind> = questions.iter().map(|q| choose(&|kind| self.range(kind, q), &cost)).collect();
        let mut moments = vec![Moments::default(); questions.len()];
        // One set of particles for the mean, which needs no look at points, and one for all points.
        let at_points = effort.rays_a_point * points.len();
        for (asked, rays, stream) in [(0..1, effort.rays, 0), (1..questions.len(), at_points, u64::MAX / 2)] {
            let asked: Vec<usize> = asked.filter(|&i| kinds[i] == Kind::Particles).collect();
            let by_particles: Vec<Question<'_>> = asked.iter().map(|&i| questions[i]).collect();
            if !by_particles.is_empty() {
                asked
                    .into_iter()
                    .zip(self.particles(&by_particles, rays, effort.seed, stream))
                    .for_each(|(i, moment)| moments[i] = moment);
            }
        }
        for (i, question) in questions.iter().enumerate().filter(|(i, _)| kinds[*i] != Kind::Particles) {
            let rays = if i == 0 { effort.rays } else { effort.rays_a_point };
            moments[i] = self.walks(kinds[i], question, rays, effort.seed, 1 + i as u64);
        }
        let limits = |i: usize| self.limits(&moments[i], self.range(kinds[i], &questions[i]), effort.confidence);
        let mut truth = Truth { reflected: limits(0), emitted: self.mean_emitted(effort.seed), points: Vec::new() };
        for (i, point) in points.iter().enumerate() {
            let [rho, emitted] = self.faces[point.face].reflectance_and_emission(point.position);
            let Known { value, interval } = limits(i + 1);
            let direct = self.direct_at(point, effort, i as u64)?;
            let with = |reflected: f64, direct: f64| emitted + rho * direct + reflected;
            truth.points.push(Known {
                value: with(value, direct.value),
                interval: ConfidenceInterval {
                    low: with(interval.low, direct.interval.low),
                    high: with(interval.high, direct.interval.high),
                }
                .widened(ROUNDING * with(interval.high, direct.interval.high)),
            });
        }
        Ok(truth)
    }

    /// Range of a contribution: see the module's documentation.
    fn range(&self, kind: Kind, question: &Question<'_>) -> f64 {
        let (s, t) = (self.series.reflected, self.series.whole);
        let exchanging = || self.faces.iter().filter(|face| face.exchanges);
        let emitted = exchanging().map(|face| face.emitted).fold(0.0, f64::max);
        let lit = || self.faces.iter().zip(&self.light).filter(|(face, _)| face.exchanges);
        let next = lit().map(|(face, light)| face.reflectance * light).fold(0.0, f64::max) * t;
        match question {
            Question::Mean => match kind {
                Kind::Particles => self.whole_power() / self.area() * s,
                Kind::NextEvent => next,
                Kind::Plain => emitted * s,
            },
            Question::At(point) => {
                let rho = self.faces[point.face].reflectance;
                match kind {
                    Kind::Particles if self.whole_power() == 0.0 => 0.0,
                    Kind::Particles => self.whole_power() * rho * self.largest_kernel(point) * t,
                    Kind::NextEvent => rho * next,
                    Kind::Plain => rho * emitted * s,
                }
            }
        }
    }

    fn limits(&self, moments: &Moments, range: f64, confidence: f64) -> Known {
        let support = ConfidenceInterval { low: 0.0, high: range };
        let interval = if range.is_finite() {
            moments.distribution_free(confidence, support).widened(ROUNDING * range)
        } else {
            ConfidenceInterval { low: 0.0, high: f64::INFINITY }
        };
        let remainder = if range > 0.0 { self.series.rest * range } else { 0.0 };
        Known { value: moments.mean(), interval: ConfidenceInterval { low: interval.low, high: interval.high + remainder } }
    }

    /// How many walks so many rays are, by a few that are not used.
    fn count(rays: usize, cost: impl FnMut(&mut ChaCha8Rng) -> usize, generator: &mut ChaCha8Rng) -> usize {
        let mut cost = cost;
        let used: usize = (0..PILOT).map(|_| cost(generator)).sum();
        (rays * PILOT / used.max(PILOT)).max(FEWEST)
    }

    /// Walks from lamps, for several questions.
    fn particles(&self, questions: &[Question<'_>], rays: usize, seed: u64, stream: u64) -> Vec<Moments> {
        let mut moments = vec![Moments::default(); questions.len()];
        let mut contributions = vec![0.0; questions.len()];
        if self.whole_power() == 0.0 {
            // Nothing contributes, and nothing could.
            moments.iter_mut().for_each(|moment| (0..FEWEST).for_each(|_| moment.add(0.0)));
            return moments;
        }
        let mut generator = ChaCha8Rng::seed_from_u64(seed);
        generator.set_stream(stream);
        let count = Self::count(rays, |generator| self.particle(questions, &mut contributions, generator), &mut generator);
        for _ in 0..count {
            contributions.fill(0.0);
            self.particle(questions, &mut contributions, &mut generator);
            moments.iter_mut().zip(&contributions).for_each(|(moment, contribution)| moment.add(*contribution));
        }
        moments
    }

    /// The front that light from a place meets next.
    fn next(&self, face: usize, at: DVec3, generator: &mut ChaCha8Rng) -> Option<(usize, DVec3)> {
        let direction = by_cosine(self.faces[face].polygon.normal(), generator);
        let hit = self.caster.first(face, at, direction).filter(|hit| hit.front && self.faces[hit.face].exchanges)?;
        Some((hit.face, at + direction * hit.parameter))
    }

    /// One walk from a lamp; how many rays it took.
    fn particle(&self, questions: &[Question<'_>], contributions: &mut [f64], generator: &mut ChaCha8Rng) -> usize {
        let power = self.whole_power();
        let place = uniform(generator) * power;
        let lamp = &self.lamps[self.power.partition_point(|sum| *sum <= place).min(self.lamps.len() - 1)];
        let (mut face, mut at) = (lamp.face, on_triangle(&lamp.corners, generator));
        // With a pattern less than the most is emitted.
        let mut weight = power * self.faces[face].reflectance_and_emission(at)[1] / lamp.emitted;
        let (least, mut rays) = (LEAST_WEIGHT * power, 0);
        let area = self.area();
        for _ in 0..self.series.bounces {
            rays += 1;
            let Some(next) = self.next(face, at, generator) else { break };
            (face, at) = next;
            weight *= self.faces[face].reflectance_and_emission(at)[0];
            if weight == 0.0 {
                break;
            }
            for (question, contribution) in questions.iter().zip(&mut *contributions) {
                *contribution += match question {
                    Question::Mean => weight / area,
                    Question::At(point) => {
                        let normals = [point.face, face].map(|face| self.faces[face].polygon.normal());
                        let k = kernel(normals[0], normals[1], at - point.position);
                        if k == 0.0 || face == point.face {
                            continue;
                        }
                        rays += 1;
                        if !self.caster.is_clear([point.face, face], point.position, at) {
                            continue;
                        }
                        weight * k * self.faces[point.face].reflectance_and_emission(point.position)[0]
                    }
                };
            }
            if weight < least {
                if uniform(generator) * least >= weight {
                    break;
                }
                weight = least;
            }
        }
        rays
    }

    /// Walks of one kind for a question.
    fn walks(&self, kind: Kind, question: &Question<'_>, rays: usize, seed: u64, stream: u64) -> Moments {
        let mut generator = ChaCha8Rng::seed_from_u64(seed);
        generator.set_stream(stream);
        let mut moments = Moments::default();
        let walk = |generator: &mut ChaCha8Rng| match question {
            Question::At(point) => self.walk(kind, point.face, point.position, false, generator),
            Question::Mean => {
                let (face, position) = self.anywhere(generator);
                self.walk(kind, face, position, true, generator)
            }
        };
        let count = Self::count(rays, |generator| walk(generator).1, &mut generator);
        (0..count).for_each(|_| moments.add(walk(&mut generator).0));
        moments
    }

    /// A point, uniform over all area that exchanges light.
    fn anywhere(&self, generator: &mut ChaCha8Rng) -> (usize, DVec3) {
        let mut place = uniform(generator) * self.area();
        let mut last = (0, DVec3::ZERO);
        for (index, _) in self.faces.iter().enumerate().filter(|(_, face)| face.exchanges) {
            for triangle in &self.triangles[index] {
                let area = area(triangle);
                last = (index, triangle[0]);
                if place < area {
                    return (index, on_triangle(triangle, generator));
                }
                place -= area;
            }
        }
        last
    }

    /// Reflected light at a point by one walk, direct light included or not, and the rays it took.
    fn walk(&self, kind: Kind, face: usize, at: DVec3, direct: bool, generator: &mut ChaCha8Rng) -> (f64, usize) {
        let (mut face, mut at) = (face, at);
        let mut weight = self.faces[face].reflectance_and_emission(at)[0];
        let (mut sum, mut rays) = (0.0, 0);
        if weight == 0.0 {
            return (0.0, 1);
        }
        if direct && kind == Kind::NextEvent {
            sum += weight * self.look(face, at, generator);
            rays += 1;
        }
        let least = LEAST_WEIGHT * weight;
        for bounce in 0..self.series.bounces {
            rays += 1;
            let Some(next) = self.next(face, at, generator) else { break };
            (face, at) = next;
            let [rho, emitted] = self.faces[face].reflectance_and_emission(at);
            if kind == Kind::Plain && (direct || bounce > 0) {
                sum += weight * emitted;
            }
            weight *= rho;
            if weight == 0.0 {
                break;
            }
            if kind == Kind::NextEvent {
                sum += weight * self.look(face, at, generator);
                rays += 1;
            }
            if weight < least {
                if uniform(generator) * least >= weight {
                    break;
                }
                weight = least;
            }
        }
        (sum, rays)
    }

    /// Direct irradiance at a point by one point of one lamp: a triangle in proportion to its free irradiance, `E Omega / pi`, and
    /// a point of it by solid angle.
    fn look(&self, face: usize, at: DVec3, generator: &mut ChaCha8Rng) -> f64 {
        let normal = self.faces[face].polygon.normal();
        let mut visible = Vec::with_capacity(self.lamps.len());
        let mut total = 0.0;
        for lamp in self.lamps.iter().filter(|lamp| lamp.face != face && !self.caster.is_level(lamp.face, face)) {
            if let Some(corners) = lamp.seen_from(at) {
                total += lamp.emitted * corners.solid_angle() / PI;
                visible.push((total, lamp, corners));
            }
        }
        let place = uniform(generator) * total;
        let Some((_, lamp, corners)) =
            visible.get(visible.partition_point(|(sum, _, _)| *sum <= place).min(visible.len().max(1) - 1))
        else {
            return 0.0;
        };
        let end = lamp.point(corners.barycentric([uniform(generator), uniform(generator)]));
        let ray = end - at;
        let cosine = normal.dot(ray) / ray.length();
        if cosine > 0.0 && self.caster.is_clear([face, lamp.face], at, end) {
            total * cosine * self.faces[lamp.face].reflectance_and_emission(end)[1] / lamp.emitted
        } else {
            0.0
        }
    }

    /// Direct light at a point: enclosed, or sampled where it cannot be.
    fn direct_at(&self, point: &Point, effort: &Effort, stream: u64) -> Result<Known, Error> {
        if effort.digits >= 15
            && let Ok(interval) = self.direct(point, effort.digits)
        {
            return Ok(Known { value: 0.5 * (interval.low + interval.high), interval });
        }
        let mut generator = ChaCha8Rng::seed_from_u64(effort.seed);
        generator.set_stream(u64::MAX - stream);
        let lamps = self.lamps.iter().filter(|lamp| lamp.face != point.face);
        let range = lamps.filter_map(|lamp| Some(lamp.emitted * lamp.seen_from(point.position)?.solid_angle() / PI)).sum();
        let mut moments = Moments::default();
        let count = (effort.rays_a_point / 2).max(FEWEST);
        (0..count).for_each(|_| moments.add(self.look(point.face, point.position, &mut generator)));
        let support = ConfidenceInterval { low: 0.0, high: range };
        let interval = moments.distribution_free(effort.confidence, support).widened(ROUNDING * range);
        Ok(Known { value: moments.mean(), interval })
    }

    /// Mean emission: exact but for rounding without patterns, and a mean of many points with them.
    fn mean_emitted(&self, seed: u64) -> f64 {
        let mut generator = ChaCha8Rng::seed_from_u64(seed);
        generator.set_stream(u64::MAX);
        let mut sum = 0.0;
        for (index, face) in self.faces.iter().enumerate().filter(|(_, face)| face.exchanges) {
            sum += match &face.pattern {
                None => self.areas[index] * face.emitted,
                Some(_) => {
                    let mut of_face = 0.0;
                    for triangle in &self.triangles[index] {
                        let points =
                            (0..PATTERN_POINTS).map(|_| face.reflectance_and_emission(on_triangle(triangle, &mut generator))[1]);
                        of_face += area(triangle) * points.sum::<f64>() / f64::from(PATTERN_POINTS);
                    }
                    of_face
                }
            };
        }
        sum / self.area()
    }
}

/// Points of a triangle that the mean of a pattern's emission is taken from.
const PATTERN_POINTS: u32 = 10_000;
