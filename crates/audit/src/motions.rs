//! Derivatives by the vertices of emitter and occluders, by emission, normal and reflectance, against the oracle's slope along a random path
//! that moves all of them at once, and against identities that hold in every case.
//!
//! One path a case tells a wrong derivative of any kind from a right one, but for a chance of no measure: the slope along it is the sum of
//! all derivatives, each times a random rate. A triangle's vertices move on their own, a larger polygon by an affine map that keeps it flat.

use glam::{DMat3, DVec3};
use radgrad_core::{
    Derivative, Derivatives, Emission, Emitter, Error, Linear, Polygon, Polynomial, Receiver, derivatives, evaluate_to,
};
use radgrad_oracle::{Slope, slope_along};
use radgrad_scene::case::Problem;
use radgrad_scene::smallest;

use crate::measure::is_worse;
use crate::sampler::Sampler;

/// Digits of the oracle's enclosures.
const DIGITS: u32 = 24;

/// The step over the distance of the nearest vertex.
const STEP: f64 = 1.0 / 1024.0;

/// Largest estimate of the slope's error, over the sizes of the derivatives that make it: beyond it the path is not smooth.
const SMOOTH: f64 = 1e-7;

/// What an identity may be off by, over the sizes of its terms, where the tolerance is no more.
const IDENTITY: f64 = 1e-12;

/// What was compared.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Compared {
    /// Violations.
    pub findings: Vec<String>,
    /// The difference from the oracle's slope over what bound and estimate allow, where the path is smooth.
    pub share: Option<f64>,
}

/// The derivatives of a case, held against the slope along the path of that number, and against identities.
#[must_use]
pub fn compare(problem: &Problem, tolerance: f64, path: u64) -> Compared {
    let Problem { receiver, emitter, occluders, .. } = problem;
    let found = match derivatives(receiver, emitter, occluders, tolerance) {
        Ok(found) => found,
        // The same is refused as of the gradient.
        Err(Error::OnSurface { .. } | Error::Overflow { .. } | Error::Underflow { .. } | Error::Scales { .. }) => {
            return Compared::default();
        }
        Err(error) => return Compared { findings: vec![format!("derivatives: {error}")], share: None },
    };
    let mut findings = identities(problem, &found, tolerance);
    let rates = Rates::random(problem, path);
    let share = rates.slope(problem).and_then(|slope| {
        let (expected, bound, size) = rates.sum(problem, &found);
        if !(slope.error <= SMOOTH * size && bound.is_finite()) {
            return None;
        }
        let error = (slope.value - expected).abs();
        let allowed = bound + 4.0 * slope.error + 1e-13 * size;
        if is_worse(error, allowed) {
            findings.push(format!(
                "derivatives to {tolerance:e} give a slope of {expected:e} along path {path}, the oracle {:e}: off by {error:e}, \
                 the bounds allow {allowed:e}",
                slope.value
            ));
        }
        Some(error / allowed)
    });
    Compared { findings, share }
}

/// Rates of change of everything along a path.
struct Rates {
    vertices: Vec<DVec3>,
    occluders: Vec<Vec<DVec3>>,
    emission: Vec<f64>,
    normal: DVec3,
    reflectance: f64,
    step: f64,
}

impl Rates {
    fn random(problem: &Problem, path: u64) -> Self {
        let Problem { receiver, emitter, occluders, .. } = problem;
        let random = &mut Sampler::new(path, "motions", 0);
        let x = receiver.position();
        let all = || std::iter::once(emitter.polygon()).chain(occluders);
        let nearest = all().flat_map(|polygon| polygon.vertices()).map(|v| v.distance(x)).fold(f64::INFINITY, smallest);
        let least = all().map(Polygon::size).fold(nearest, smallest);
        let vertices = motion(emitter.polygon(), least, random);
        let occluders = occluders.iter().map(|occluder| motion(occluder, least, random)).collect();
        let emission = match emitter.emission() {
            Emission::Constant(value) => vec![value * random.between(-1.0, 1.0)],
            Emission::Linear(Linear::AtVertices(values)) => {
                let largest = values.iter().fold(0.0, |m: f64, b| m.max(b.abs()));
                affine_values(emitter.polygon(), largest, random)
            }
            Emission::Linear(Linear::Gradient { value, gradient }) => {
                let all = std::iter::once(*value).chain(gradient.to_array());
                all.map(|c| c * random.between(-1.0, 1.0)).collect()
            }
            Emission::Polynomial(polynomial) => {
                polynomial.terms().iter().map(|term| term.coefficient * random.between(-1.0, 1.0)).collect()
            }
        };
        let normal = random.cube() * receiver.given_normal().length();
        let reflectance = if receiver.reflectance() < 0.99 { receiver.reflectance() * random.between(-1.0, 1.0) } else { 0.0 };
        Self { vertices, occluders, emission, normal, reflectance, step: STEP }
    }

    /// The case at a parameter.
    fn at(&self, problem: &Problem, parameter: f64) -> Result<(Receiver, Emitter, Vec<Polygon>), Error> {
        let Problem { receiver, emitter, occluders, .. } = problem;
        let moved = |polygon: &Polygon, rates: &[DVec3]| {
            let vertices = polygon.vertices().iter().zip(rates).map(|(vertex, rate)| *vertex + *rate * parameter);
            Polygon::new(vertices.collect())
        };
        let mut rates = self.emission.iter().map(|rate| rate * parameter);
        let mut change = |value: f64| value + rates.next().unwrap_or(0.0);
        let emission = match emitter.emission() {
            Emission::Constant(value) => Emission::Constant(change(*value)),
            Emission::Linear(Linear::AtVertices(values)) => Emission::at_vertices(values.iter().map(|v| change(*v)).collect()),
            Emission::Linear(Linear::Gradient { value, gradient }) => {
                Emission::gradient(change(*value), gradient.to_array().map(change).into())
            }
            Emission::Polynomial(polynomial) => {
                let terms = polynomial.terms().iter().map(|term| (change(term.coefficient), term.powers));
                Emission::Polynomial(Polynomial::new(polynomial.origin(), terms)?)
            }
        };
        let normal = receiver.given_normal() + self.normal * parameter;
        let reflectance = receiver.reflectance() + self.reflectance * parameter;
        let screens = occluders.iter().zip(&self.occluders).map(|(occluder, rates)| moved(occluder, rates));
        Ok((
            Receiver::new(receiver.position(), normal, reflectance)?,
            Emitter::new(moved(emitter.polygon(), &self.vertices)?, emission)?,
            screens.collect::<Result<_, _>>()?,
        ))
    }

    fn slope(&self, problem: &Problem) -> Option<Slope> {
        slope_along(|parameter| self.at(problem, parameter), self.step, DIGITS).ok()
    }

    /// The sum of all derivatives times their rates, the bound on its error, and the sum of the sizes of its terms.
    fn sum(&self, problem: &Problem, found: &Derivatives) -> (f64, f64, f64) {
        let mut sum = Terms::default();
        let derivatives = found.vertices.iter().chain(found.occluders.iter().flatten());
        for (derivative, rate) in derivatives.zip(self.vertices.iter().chain(self.occluders.iter().flatten())) {
            sum.add_vector(derivative, *rate);
        }
        for (derivative, rate) in found.emission.iter().zip(&self.emission) {
            sum.add(derivative.value * rate, derivative.error * rate.abs());
        }
        let normal = problem.receiver.normal();
        sum.add_vector(&found.normal, self.normal.reject_from_normalized(normal) / problem.receiver.given_normal().length());
        sum.add(found.reflectance.value * self.reflectance, found.reflectance.error * self.reflectance.abs());
        (sum.value, sum.error, sum.size)
    }
}

/// A sum, the bound on its error, and the sizes of its terms.
#[derive(Default)]
struct Terms {
    value: f64,
    error: f64,
    size: f64,
}

impl Terms {
    fn add(&mut self, value: f64, error: f64) {
        (self.value, self.error, self.size) = (self.value + value, self.error + error, self.size + value.abs());
    }

    fn add_vector(&mut self, derivative: &Derivative<DVec3>, rate: DVec3) {
        self.add(derivative.value.dot(rate), derivative.error * rate.length());
        self.size += derivative.value.length() * rate.length() - derivative.value.dot(rate).abs();
    }
}

/// A motion that keeps a polygon flat, of steps as long as `size` at most.
fn motion(polygon: &Polygon, size: f64, random: &mut Sampler) -> Vec<DVec3> {
    let vertices = polygon.vertices();
    if vertices.len() == 3 {
        return vertices.iter().map(|_| random.cube() * size).collect();
    }
    let map = DMat3::from_cols(random.cube(), random.cube(), random.cube());
    let shift = random.cube() * size;
    let share = size / polygon.size();
    vertices.iter().map(|vertex| shift + map * ((*vertex - vertices[0]) * share)).collect()
}

/// Values at the vertices of an affine function.
fn affine_values(polygon: &Polygon, largest: f64, random: &mut Sampler) -> Vec<f64> {
    let vertices = polygon.vertices();
    if vertices.len() == 3 {
        return vertices.iter().map(|_| largest * random.between(-1.0, 1.0)).collect();
    }
    let (value, slope) = (random.between(-1.0, 1.0), random.cube() / polygon.size());
    vertices.iter().map(|vertex| largest * (value + slope.dot(*vertex - vertices[0]))).collect()
}

/// Identities that do not hold: of all vertices together with the gradient, of turns and scales, of the emission, and of the parts of the
/// radiosity.
fn identities(problem: &Problem, found: &Derivatives, tolerance: f64) -> Vec<String> {
    let Problem { receiver, emitter, occluders, .. } = problem;
    let mut findings = Vec::new();
    let mut hold = |what: &str, error: f64, bound: f64, size: f64| {
        // Sums of these derivatives are rounded as often as they have terms.
        let rounding = 1e-15 * size * (4.0 + found.vertices.len() as f64);
        let within = tolerance > IDENTITY || error <= IDENTITY.max(1e3 * tolerance) * size || !bound.is_finite() || bound > IDENTITY * size;
        if is_worse(error, bound + rounding + f64::MIN_POSITIVE) || !within {
            findings.push(format!("{what} to {tolerance:e} is off by {error:e}, the bounds allow {bound:e}, its terms are {size:e}"));
        }
    };
    let radiosity = found.radiosity;
    if let Ok(answer) = evaluate_to(receiver, emitter, occluders, tolerance) {
        let off = (answer.radiosity - radiosity.value).abs();
        hold("the radiosity beside derivatives", off, answer.radiosity_error + radiosity.error, answer.radiosity.abs());
        let off = (answer.gradient - found.gradient.value).length();
        hold("the gradient beside derivatives", off, answer.gradient_error + found.gradient.error, answer.gradient.length());
    }
    let by_reflectance = found.reflectance.value * receiver.reflectance();
    let bound = found.reflectance.error * receiver.reflectance() + radiosity.error;
    hold("the derivative by the reflectance", (by_reflectance - radiosity.value).abs(), bound, radiosity.value.abs());
    let along = found.normal.value.dot(receiver.normal());
    let size = found.normal.value.length();
    hold("the derivative by the normal", (along - radiosity.value).abs(), found.normal.error + radiosity.error, size);
    let parameters: Vec<f64> = match emitter.emission() {
        Emission::Constant(value) => vec![*value],
        Emission::Linear(Linear::AtVertices(values)) => values.clone(),
        Emission::Linear(Linear::Gradient { value, gradient }) => {
            std::iter::once(*value).chain(gradient.to_array()).collect()
        }
        Emission::Polynomial(polynomial) => polynomial.terms().iter().map(|term| term.coefficient).collect(),
    };
    let mut euler = Terms::default();
    for (derivative, parameter) in found.emission.iter().zip(&parameters) {
        euler.add(derivative.value * parameter, derivative.error * parameter.abs());
    }
    let size = euler.size + radiosity.value.abs();
    hold("Euler's sum over the emission", (euler.value - radiosity.value).abs(), euler.error + radiosity.error, size);
    if let Emission::Linear(Linear::Gradient { .. }) | Emission::Polynomial(_) = emitter.emission() {
        return findings;
    }
    let places = emitter.polygon().vertices().iter().chain(occluders.iter().flat_map(|occluder| occluder.vertices()));
    let moved = || places.clone().zip(found.vertices.iter().chain(found.occluders.iter().flatten()));
    let about = receiver.position() + receiver.normal() * emitter.polygon().size();
    let (mut shift, mut turn, mut scale) = ([DVec3::ZERO; 2], [DVec3::ZERO; 2], Terms::default());
    for (place, derivative) in moved() {
        let arm = *place - about;
        shift[0] += derivative.value;
        shift[1] += DVec3::new(derivative.error, derivative.value.length(), 0.0);
        turn[0] += arm.cross(derivative.value);
        turn[1] += DVec3::new(derivative.error, derivative.value.length(), 0.0) * arm.length();
        scale.add_vector(derivative, arm);
    }
    let translation = found.translation();
    hold("the sum over all vertices", (shift[0] - translation.value).length(), shift[1].x + translation.error, shift[1].y);
    let rotation = found.rotation(about);
    hold("the turn of all vertices", (turn[0] - rotation.value).length(), turn[1].x + rotation.error, turn[1].y);
    let by_scale = found.scale(about);
    hold("the scale of all vertices", (scale.value - by_scale.value).abs(), scale.error + by_scale.error, scale.size);
    findings
}
