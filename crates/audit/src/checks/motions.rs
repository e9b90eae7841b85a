//! Derivatives by the vertices of emitter and occluders, by emission, normal and reflectance, against the oracle's slope along a random path
//! that moves all of them at once, and against identities that hold in every case.
//!
//! One path a case tells a wrong derivative of any kind from a right one, but for a chance of no measure: the slope along it is the sum of
//! all derivatives, each times a random rate. A triangle's vertices move on their own, a larger polygon by an affine map that keeps it flat.

use std::collections::BTreeMap;

use glam::{DMat3, DVec3};
use radgrad_core::{
    Derivative, Derivatives, Emission, Emitter, Error, Linear, Polygon, Polynomial, Receiver, derivatives, evaluate_to,
};
use radgrad_oracle::{Motion, Request, Slope, Source, enclose_moved, enclose_occluded, slope_along};
use radgrad_scene::case::Problem;
use radgrad_scene::{largest, smallest};
use rayon::prelude::*;

use crate::cases::family::{Family, Name};
use crate::cases::sampler::Sampler;
use crate::measures::measure::is_worse;
use crate::measures::run::Run;

/// Steps over the least of the lengths that a path must not make 0, and digits of the oracle's enclosures, which over a step are less than the
/// differences of sixth order leave. The short step is asked where the long one contradicts the derivatives: something narrower
/// than it may be beside the place.
const STEPS: [(f64, u32); 2] = [(1.0 / 1024.0, 18), (1.0 / (1u64 << 40) as f64, 32)];

/// Largest estimate of the slope's error, over the sizes of the derivatives that make it: beyond it the path is not smooth.
const SMOOTH: f64 = 1e-8;

/// The largest allowed error of a slope over the estimate of its error.
const ROOM: f64 = 16.0;

/// The largest allowed error of an identity, over the sizes of its terms, where the tolerance is no more.
const IDENTITY: f64 = 1e-12;

/// The result of a comparison.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Compared {
    /// Violations.
    pub findings: Vec<String>,
    /// The difference from the oracle's slope over the error that bound and estimate allow, where the path is smooth.
    pub share: Option<f64>,
}

/// The derivatives of a case, held against identities, and against the slope along the path of that number, if any.
#[must_use]
pub fn compare(problem: &Problem, tolerance: f64, path: Option<u64>) -> Compared {
    let Problem { receiver, emitter, occluders, .. } = problem;
    let answer = match derivatives(receiver, emitter, occluders, tolerance) {
        Ok(answer) => answer,
        // The same is refused as of the gradient.
        Err(Error::OnSurface { .. } | Error::Overflow { .. } | Error::Underflow { .. } | Error::Scales { .. }) => {
            return Compared::default();
        }
        Err(error) => return Compared { findings: vec![format!("derivatives: {error}")], share: None },
    };
    let mut findings = identities(problem, &answer, tolerance);
    let Some(path) = path else { return Compared { findings, share: None } };
    let rates = Rates::random(problem, path);
    let Terms { value: expected, error: bound, size } = rates.sum(problem, &answer);
    let mut share = None;
    let mut finding = None;
    for (step, digits) in STEPS {
        // The path is not smooth over such steps.
        let smooth = |slope: &Slope| slope.error <= SMOOTH * size && bound.is_finite();
        let Some(slope) = rates.slope(problem, step, digits).filter(smooth) else { break };
        let error = (slope.value - expected).abs();
        let allowed = bound + ROOM * slope.error + 1e-13 * size;
        // In the dark nothing is off.
        share = Some(if error > 0.0 { error / allowed } else { 0.0 });
        finding = is_worse(error, allowed).then(|| {
            format!(
                "derivatives to {tolerance:e} give a slope of {expected:e} along path {path}, the oracle {:e} by steps of {step:e}: \
                 off by {error:e}, the bounds allow {allowed:e}",
                slope.value
            )
        });
        if finding.is_none() {
            break;
        }
    }
    findings.extend(finding);
    Compared { findings, share }
}

/// Many cases, by family.
#[derive(Debug, Clone, Default)]
pub struct Campaign {
    /// Cases, those of them that were held against a slope, and the largest share of the error that bounds and estimates allow.
    pub rows: BTreeMap<Family, Row>,
    /// Violations, each with its case.
    pub wrong: Vec<(Name, String)>,
}

/// The cases of a family.
#[derive(Debug, Clone, Copy, Default)]
pub struct Row {
    /// Cases with an answer.
    pub cases: u64,
    /// Those held against a slope of the oracle.
    pub compared: u64,
    /// The largest difference from one over the error that bound and estimate allow.
    pub worst: f64,
}

/// Holds the cases of a run against identities, and against slopes where that is said: every second one to a tolerance that double precision
/// meets.
#[must_use]
pub fn campaign(run: &Run, has_slopes: bool, is_done: impl Fn(&Name) + Sync) -> Campaign {
    let names: Vec<Name> = run.names().collect();
    let ask = |name: &Name| {
        let tolerance = if name.index.is_multiple_of(2) { 1e-12 } else { 1.0 };
        let compared =
            name.case().problem().ok().map(|problem| compare(&problem, tolerance, has_slopes.then_some(name.seed ^ name.index)));
        is_done(name);
        Some((*name, compared?))
    };
    let mut campaign = Campaign::default();
    for (name, Compared { findings, share }) in names.par_iter().filter_map(ask).collect::<Vec<_>>() {
        let row = campaign.rows.entry(name.family).or_default();
        row.cases += 1;
        row.compared += u64::from(share.is_some());
        row.worst = largest(row.worst, share.unwrap_or(0.0));
        campaign.wrong.extend(findings.into_iter().map(|finding| (name, finding)));
    }
    campaign
}

impl Campaign {
    /// The share of cases that were held against a slope.
    #[must_use]
    pub fn compared(&self) -> f64 {
        let [cases, compared] =
            [|row: &Row| row.cases, |row: &Row| row.compared].map(|of| self.rows.values().map(of).sum::<u64>());
        compared as f64 / cases as f64
    }
}

/// Rates of change of everything along a path.
struct Rates {
    motion: Motion,
    emission: Vec<f64>,
    reflectance: f64,
}

impl Rates {
    fn random(problem: &Problem, path: u64) -> Self {
        let Problem { receiver, emitter, occluders, .. } = problem;
        let random = &mut Sampler::new(path, "motions", 0);
        let x = receiver.position();
        let all = || std::iter::once(emitter.polygon()).chain(occluders);
        let least = all().map(|polygon| least_length(polygon, x)).fold(f64::INFINITY, smallest);
        let farthest = all().flat_map(|polygon| polygon.vertices()).map(|v| length(*v - x)).fold(0.0, largest);
        // Polygons that share vertices, as the faces of a box, go on sharing them: apart, one or the other would hide more along the path.
        let polygons: Vec<&Polygon> = all().collect();
        let is_shared = |(index, polygon): (usize, &&Polygon)| {
            polygons[..index].iter().any(|other| other.vertices().iter().any(|vertex| polygon.vertices().contains(vertex)))
        };
        let is_together = path % 4 > 1 || polygons.iter().enumerate().any(is_shared);
        let common = is_together.then(|| Affine::random(x, random));
        let mut motion = |polygon: &Polygon| match &common {
            Some(map) => map.rates(polygon, least / farthest),
            None if polygon.vertices().len() == 3 => polygon.vertices().iter().map(|_| random.cube() * least).collect(),
            // Around a point aside, so that it is moved too.
            None => Affine::random(polygon.vertices()[0] + random.cube() * polygon.size(), random)
                .rates(polygon, least / polygon.size()),
        };
        let vertices = motion(emitter.polygon());
        let occluders = occluders.iter().map(motion).collect();
        let emission = match emitter.emission() {
            Emission::Constant(value) => vec![value * random.between(-1.0, 1.0)],
            Emission::Linear(Linear::AtVertices(values)) => {
                let largest = values.iter().fold(0.0, |m: f64, b| m.max(b.abs()));
                affine_values(emitter.polygon(), largest, random)
            }
            Emission::Linear(Linear::Gradient { value, gradient }) => {
                let coefficients = std::iter::once(*value).chain(gradient.to_array());
                coefficients.map(|c| c * random.between(-1.0, 1.0)).collect()
            }
            Emission::Polynomial(polynomial) => {
                polynomial.terms().iter().map(|term| term.coefficient * random.between(-1.0, 1.0)).collect()
            }
        };
        let normal = random.cube() * length(receiver.given_normal());
        let reflectance = if receiver.reflectance() < 0.99 { receiver.reflectance() * random.between(-1.0, 1.0) } else { 0.0 };
        Self { motion: Motion { vertices, occluders, normal }, emission, reflectance }
    }

    /// The oracle's slope: by differences along the motion; emission and reflectance, in which the radiosity is linear, need none.
    fn slope(&self, problem: &Problem, step: f64, digits: u32) -> Option<Slope> {
        let Problem { receiver, emitter, occluders, .. } = problem;
        let moved = |parameter: f64| {
            let request = Request::digits(digits);
            Ok(enclose_moved(receiver, &Source::Emitter(emitter), occluders, &self.motion, parameter, &request)?.radiosity)
        };
        let by_motion = slope_along(moved, step).ok()?;
        let brightening = Emitter::new(emitter.polygon().clone(), self.brightening(problem)?).ok()?;
        let by_light = enclose_occluded(receiver, &brightening, occluders, digits).ok()?.radiosity;
        Some(Slope { value: by_motion.value + by_light.to_f64(), error: by_motion.error + by_light.radius() })
    }

    /// The rates of the emission as an emission, with the relative rate of the reflectance, of which the light is the same multiple.
    fn brightening(&self, Problem { receiver, emitter, .. }: &Problem) -> Option<Emission> {
        let reflecting = if self.reflectance == 0.0 { 0.0 } else { self.reflectance / receiver.reflectance() };
        let rates: Vec<f64> = self.emission.iter().zip(parameters(emitter)).map(|(rate, b)| rate + reflecting * b).collect();
        Some(match (emitter.emission(), rates.as_slice()) {
            (Emission::Constant(_), [value]) => Emission::Constant(*value),
            (Emission::Linear(Linear::Gradient { .. }), [value, gradient @ ..]) => {
                Emission::gradient(*value, DVec3::from_slice(gradient))
            }
            (Emission::Polynomial(polynomial), _) => {
                let terms = polynomial.terms().iter().zip(rates).map(|(term, rate)| (rate, term.powers));
                Emission::Polynomial(Polynomial::new(polynomial.origin(), terms).ok()?)
            }
            _ => Emission::at_vertices(rates),
        })
    }

    /// The sum of all derivatives times their rates.
    fn sum(&self, problem: &Problem, found: &Derivatives) -> Terms {
        let mut sum = Terms::default();
        let Problem { receiver, .. } = problem;
        let Motion { vertices, occluders, normal } = &self.motion;
        let derivatives = found.vertices.iter().chain(found.occluders.iter().flatten());
        for (derivative, rate) in derivatives.zip(vertices.iter().chain(occluders.iter().flatten())) {
            sum.add_vector(derivative, *rate);
        }
        for (derivative, rate) in found.emission.iter().zip(&self.emission) {
            sum.add(derivative.value * rate, derivative.error * rate.abs());
        }
        let across = normal.reject_from_normalized(receiver.normal()) / length(receiver.given_normal());
        sum.add_vector(&found.normal, across);
        sum.add(found.reflectance.value * self.reflectance, found.reflectance.error * self.reflectance.abs());
        sum
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
        self.value += derivative.value.dot(rate);
        self.error += derivative.error * length(rate);
        self.size += length(derivative.value) * length(rate);
    }
}

/// An affine motion, which keeps polygons flat.
struct Affine {
    fixed: DVec3,
    linear: DMat3,
}

impl Affine {
    fn random(fixed: DVec3, random: &mut Sampler) -> Self {
        Self { fixed, linear: DMat3::from_cols(random.cube(), random.cube(), random.cube()) }
    }

    /// The rates of a polygon's vertices, that much of their distances from the point that the linear part leaves.
    fn rates(&self, polygon: &Polygon, share: f64) -> Vec<DVec3> {
        polygon.vertices().iter().map(|vertex| self.linear * ((*vertex - self.fixed) * share)).collect()
    }
}

/// The least of the lengths that a motion must not make 0: the distances of an edge and of the plane from the receiver, the least altitude
/// of a triangle, the size of another polygon.
fn least_length(polygon: &Polygon, x: DVec3) -> f64 {
    let vertices = polygon.vertices();
    let edges = vertices.iter().zip(vertices.iter().cycle().skip(1)).map(|(a, b)| {
        let (e, r) = (*b - *a, x - *a);
        let place = (r.dot(e) / e.length_squared()).clamp(0.0, 1.0);
        length(r - e * if place.is_nan() { 0.0 } else { place })
    });
    let width = if vertices.len() == 3 { 2.0 * polygon.area() / polygon.size() } else { polygon.size() };
    let height = polygon.normal().dot(x - vertices[0]).abs();
    let least = edges.fold(width, smallest);
    if height > 0.0 { smallest(least, height) } else { least }
}

/// The length of a vector whose square may leave the range of doubles.
fn length(v: DVec3) -> f64 {
    let scale = v.abs().max_element();
    if scale > 0.0 && scale.is_finite() { (v / scale).length() * scale } else { scale }
}

/// The parameters of an emission.
fn parameters(emitter: &Emitter) -> Vec<f64> {
    match emitter.emission() {
        Emission::Constant(value) => vec![*value],
        Emission::Linear(Linear::AtVertices(values)) => values.clone(),
        Emission::Linear(Linear::Gradient { value, gradient }) => std::iter::once(*value).chain(gradient.to_array()).collect(),
        Emission::Polynomial(polynomial) => polynomial.terms().iter().map(|term| term.coefficient).collect(),
    }
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

/// Violations where a screen is seen edge-on, and where the emission changes its sign.
#[must_use]
pub fn of_special_cases() -> Vec<String> {
    let told = std::iter::once(edge_on_aside()).chain((0..20).map(negated));
    told.flat_map(|told| told.unwrap_or_else(|error| vec![error.to_string()])).collect()
}

/// The derivatives by a screen that is seen edge-on have bounds if it is beside the lamp, and none if it is before it.
fn edge_on_aside() -> Result<Vec<String>, Error> {
    let lamp = [[-1.0, -1.0], [-1.0, 1.0], [1.0, 1.0], [1.0, -1.0]].map(|[x, y]| DVec3::new(x, y, 1.0));
    let emitter = Emitter::new(Polygon::new(lamp.to_vec())?, Emission::Constant(1.0))?;
    let receiver = Receiver::new(DVec3::ZERO, DVec3::Z, 1.0)?;
    let screen = |corners: [[f64; 2]; 3]| Polygon::new(corners.map(|[y, z]| DVec3::new(0.0, y, z)).to_vec());
    // In the plane x = 0 of the receiver, which cuts the lamp: beside it, and before it.
    let (aside, before) = (screen([[5.0, 0.125], [6.0, 0.125], [5.0, 0.5]])?, screen([[-0.25, 0.5], [0.25, 0.5], [0.0, 0.75]])?);
    let is_bounded = |screen: &Polygon| {
        let by_vertices = derivatives(&receiver, &emitter, [screen], 1e-9)?.occluders;
        Ok::<_, Error>(by_vertices[0].iter().all(|vertex| vertex.error.is_finite()))
    };
    let said = [is_bounded(&aside)?, is_bounded(&before)?];
    Ok((said != [true, false]).then(|| format!("screens edge-on have bounds {said:?}, not [true, false]")).into_iter().collect())
}

/// Derivatives for an emission and for its opposite have the same bounds.
fn negated(index: u64) -> Result<Vec<String>, Error> {
    let s = &mut Sampler::new(83, "negated", index);
    let corners = [[-1.0, -1.0], [-1.0, 1.0], [1.0, 1.0]].map(|[x, y]| DVec3::new(x, y, 1.0) + s.cube() * 0.125);
    let polygon = Polygon::new(corners.to_vec())?;
    let values = [s.between(0.5, 2.0), s.between(0.5, 2.0), s.between(0.5, 2.0)];
    let receiver = Receiver::new(s.cube() * 0.25, DVec3::Z, 0.5)?;
    let derived = |sign: f64| {
        let emitter = Emitter::new(polygon.clone(), Emission::at_vertices(values.map(|b| sign * b).to_vec()))?;
        derivatives(&receiver, &emitter, [], 1e-9)
    };
    let [plus, minus] = [derived(1.0)?, derived(-1.0)?];
    let of_each = |d: &Derivatives| [d.radiosity.error, d.reflectance.error, d.gradient.error, d.normal.error];
    Ok((of_each(&plus) != of_each(&minus) || plus.radiosity.value != -minus.radiosity.value)
        .then(|| format!("negated:{index}: {:?} and {:?}", of_each(&plus), of_each(&minus)))
        .into_iter()
        .collect())
}

/// Identities that do not hold: of all vertices together with the gradient, of turns and scales, of the emission, and of the parts of the
/// radiosity.
fn identities(problem: &Problem, found: &Derivatives, tolerance: f64) -> Vec<String> {
    let Problem { receiver, emitter, occluders, .. } = problem;
    let mut findings = Vec::new();
    let still = found.scale(receiver.position());
    if found.gradient.error.is_finite() && (still.value != 0.0 || still.error != 0.0) {
        findings.push(format!("a scale around the receiver changes the light by {:e}, known to {:e}", still.value, still.error));
    }
    let mut hold = |what: &str, error: f64, bound: f64, size: f64| {
        // Sums of these derivatives are rounded as often as they have terms.
        let rounding = 1e-15 * size * (4.0 + found.vertices.len() as f64);
        let within = tolerance > IDENTITY
            || error <= IDENTITY.max(1e3 * tolerance) * size
            || !bound.is_finite()
            || bound > IDENTITY * size;
        if is_worse(error, bound + rounding + f64::MIN_POSITIVE) || !within {
            findings
                .push(format!("{what} to {tolerance:e} is off by {error:e}, the bounds allow {bound:e}, its terms are {size:e}"));
        }
    };
    let radiosity = found.radiosity;
    if let Ok(answer) = evaluate_to(receiver, emitter, occluders, tolerance) {
        let difference = (answer.radiosity - radiosity.value).abs();
        hold("the radiosity beside derivatives", difference, answer.radiosity_error + radiosity.error, answer.radiosity.abs());
        let difference = length(answer.gradient - found.gradient.value);
        hold(
            "the gradient beside derivatives",
            difference,
            answer.gradient_error + found.gradient.error,
            length(answer.gradient),
        );
    }
    let by_reflectance = found.reflectance.value * receiver.reflectance();
    let bound = found.reflectance.error * receiver.reflectance() + radiosity.error;
    hold("the derivative by the reflectance", (by_reflectance - radiosity.value).abs(), bound, radiosity.value.abs());
    let along = found.normal.value.dot(receiver.normal());
    let size = length(found.normal.value);
    hold("the derivative by the normal", (along - radiosity.value).abs(), found.normal.error + radiosity.error, size);
    let parameters = parameters(emitter);
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
        shift[1] += DVec3::new(derivative.error, length(derivative.value), 0.0);
        turn[0] += arm.cross(derivative.value);
        turn[1] += DVec3::new(derivative.error, length(derivative.value), 0.0) * length(arm);
        scale.add_vector(derivative, arm);
    }
    let translation = found.translation();
    hold("the sum over all vertices", length(shift[0] - translation.value), shift[1].x + translation.error, shift[1].y);
    let rotation = found.rotation(about);
    hold("the turn of all vertices", length(turn[0] - rotation.value), turn[1].x + rotation.error, turn[1].y);
    let by_scale = found.scale(about);
    hold("the scale of all vertices", (scale.value - by_scale.value).abs(), scale.error + by_scale.error, scale.size);
    // Their bounds are those of their terms, and some roundings.
    let arm = length(receiver.position() - about);
    let (of_scale, scale_size) = (arm * found.gradient.error, arm * length(found.gradient.value));
    let (of_turn, turn_size) = (of_scale + found.normal.error, scale_size + length(found.normal.value));
    for (what, said, error, size) in
        [("turn", rotation.error, of_turn, turn_size), ("scale", by_scale.error, of_scale, scale_size)]
    {
        let allowed = 1.001 * (error + 16.0 * f64::EPSILON * size) + 2.0 * f64::MIN_POSITIVE;
        if error.is_finite() && is_worse(said, allowed) {
            findings.push(format!("the bound of a {what} is {said:e}, the errors of its terms allow {allowed:e}"));
        }
    }
    findings
}
