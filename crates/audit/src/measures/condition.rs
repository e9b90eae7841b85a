//! The condition of a case: how far a rounding of the input, by half an ulp of every number in it, can move the answer.
//!
//! `effect = sum over motions m of |df/dm| u_m`, f the radiosity or the gradient (Euclidean norm), `u_m` the motion by half an
//! ulp of an input:
//! - receiver and emitter against each other along each axis: half an ulp of the receiver's coordinate and of the largest
//!   vertex's;
//! - the normal n1 turned about two axes: `eps/2`;
//! - the emitter's plane turned about two axes in it: half an ulp of the largest coordinate over the width across;
//! - each vertex along two axes in the plane: half an ulp of the vertex;
//! - emission and reflectance: `eps/2` of the answer each, there being no cancellation in a positive emission.
//!
//! These keep a polygon of any number of vertices planar, where moving single coordinates would bend it.
//!
//! The derivatives are central differences of core's answers, by 1/16 of the closest feature of the case (distance to vertex,
//! edge, plane, horizon; width of the emitter), so good to a few per cent. A step of an ulp would measure core's rounding
//! errors instead, and an error divided by itself passes every gate; here the error of a certified answer enters multiplied by
//! 8 ulp over that feature's size. Where a feature is within 16 ulp the step is an ulp's half after all, and the condition shows
//! it: the input determines no digit.

use glam::DVec3;
use radgrad_core::{Emission, Emitter, Error, Linear, Polygon, Polynomial, Receiver, evaluate, evaluate_to};
use radgrad_scene::case::Problem;

use crate::cases::sampler::normalising_power;
use crate::measures::seen::reduced;
use crate::measures::truth::norm;

/// The effect of half an ulp in every number of the input on the answer.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Condition {
    /// To the radiosity.
    pub radiosity: f64,
    /// To the gradient: Euclidean norm.
    pub gradient: f64,
}

/// Steps are this fraction of the closest feature.
const STEP: f64 = 1.0 / 16.0;

impl Condition {
    /// The condition of a case.
    ///
    /// # Errors
    /// If core refuses to answer, or a moved emitter is no longer valid.
    pub fn unoccluded(receiver: &Receiver, emitter: &Emitter) -> Result<Self, Error> {
        Self::occluded(receiver, emitter, &[])
    }

    /// The condition with occluders. If the visible part of the emitter is a polygon, it takes the emitter's place.
    ///
    /// # Errors
    /// As [`Self::unoccluded`].
    pub fn of_problem(problem: &Problem) -> Result<Self, Error> {
        let (emitter, occluders) = reduced(problem);
        Self::occluded(&problem.receiver, &emitter, occluders)
    }

    fn occluded(receiver: &Receiver, emitter: &Emitter, occluders: &[Polygon]) -> Result<Self, Error> {
        if !occluders.is_empty() {
            return past_screens(receiver, emitter, occluders);
        }
        let (receiver, emitter, power) = at_unit_scale(receiver, emitter)?;
        let setup = Setup::new(&receiver, &emitter);
        let (radiosity, gradient) = answer(&receiver, &emitter)?;
        let mut sum = Self { radiosity: f64::EPSILON * radiosity.abs(), gradient: f64::EPSILON * norm(gradient) };
        for (motion, half_ulp, lever) in setup.motions() {
            let step = half_ulp.max(STEP * setup.feature / lever);
            let moved_answer = |step| setup.moved(motion, step).and_then(|(r, e)| answer(&r, &e));
            let (forward, backward) = (moved_answer(step)?, moved_answer(-step)?);
            let share = half_ulp / (2.0 * step);
            sum.radiosity += share * (forward.0 - backward.0).abs();
            sum.gradient += share * norm(forward.1 - backward.1);
        }
        Ok(Self { gradient: sum.gradient * power, ..sum })
    }
}

/// Tolerance of the answers past occluders: over a step of 2^-12 it is a thousandth of the effect of half an ulp.
const ROUGH: f64 = 1e-7;

/// Receiver, normal and all occluders together moved, by 2^-12 of the closest feature: an answer is smooth between silhouettes
/// only. Single vertices stay where they are.
fn past_screens(receiver: &Receiver, emitter: &Emitter, occluders: &[Polygon]) -> Result<Condition, Error> {
    let setup = Setup::new(receiver, emitter);
    let x = receiver.position();
    let apart = occluders.iter().map(|o| o.normal().dot(x - o.vertices()[0]).abs()).filter(|d| *d > 0.0);
    let step = apart.fold(setup.feature, f64::min) / 4096.0;
    let largest = occluders.iter().flat_map(|o| o.vertices()).fold(DVec3::ZERO, |m, v| m.max(v.abs()));
    let see = |receiver: &Receiver, emitter: &Emitter, shift: DVec3| {
        let moved = |o: &Polygon| o.map(1.0, |v| v + shift);
        let moved: Vec<Polygon> = occluders.iter().map(moved).collect::<Result<_, _>>()?;
        evaluate_to(receiver, emitter, &moved, ROUGH).map(|answer| (answer.radiosity, answer.gradient))
    };
    let (radiosity, gradient) = see(receiver, emitter, DVec3::ZERO)?;
    let mut sum = Condition { radiosity: f64::EPSILON * radiosity.abs(), gradient: f64::EPSILON * norm(gradient) };
    let mut add = |share: f64, forward: (f64, DVec3), backward: (f64, DVec3)| {
        sum.radiosity += share * (forward.0 - backward.0).abs();
        sum.gradient += share * norm(forward.1 - backward.1);
    };
    for (motion, half_ulp, lever) in
        setup.motions().into_iter().filter(|(m, ..)| matches!(m, Motion::Position(_) | Motion::Turn(_)))
    {
        let step = half_ulp.max(step / lever);
        let moved_answer = |step| setup.moved(motion, step).and_then(|(r, e)| see(&r, &e, DVec3::ZERO));
        add(half_ulp / (2.0 * step), moved_answer(step)?, moved_answer(-step)?);
    }
    for axis in [DVec3::X, DVec3::Y, DVec3::Z] {
        let half_ulp = half_ulp(largest.dot(axis));
        let step = half_ulp.max(step);
        add(half_ulp / (2.0 * step), see(receiver, emitter, axis * step)?, see(receiver, emitter, -axis * step)?);
    }
    Ok(sum)
}

/// The case with its largest coordinate between 1 and 2, and the power of two that lengths were multiplied by: exact, and squares
/// of lengths stay in the range of doubles.
fn at_unit_scale(receiver: &Receiver, emitter: &Emitter) -> Result<(Receiver, Emitter, f64), Error> {
    let vertices = emitter.polygon().vertices();
    let largest = vertices.iter().fold(receiver.position().abs().max_element(), |m, v| m.max(v.abs().max_element()));
    let power = normalising_power(largest);
    let polygon = emitter.polygon().map(power, |v| v * power)?;
    let emission = match emitter.emission() {
        Emission::Linear(Linear::Gradient { value, gradient }) => Emission::gradient(*value, *gradient / power),
        Emission::Polynomial(polynomial) if power != 1.0 => {
            let over = |degree: u8| (0..degree).fold(1.0, |p, _| p * power);
            let terms = polynomial.terms().iter().map(|t| (t.coefficient / over(t.powers.iter().sum()), t.powers));
            Emission::Polynomial(Polynomial::new(polynomial.origin() * power, terms)?)
        }
        other => other.clone(),
    };
    let receiver = Receiver::new(receiver.position() * power, receiver.normal(), receiver.reflectance())?;
    Ok((receiver, Emitter::new(polygon, emission)?, power))
}

/// The certified answer: its digits keep the differences clean where the closed form in doubles has lost its own.
fn answer(receiver: &Receiver, emitter: &Emitter) -> Result<(f64, DVec3), Error> {
    evaluate(receiver, emitter, &[]).map(|answer| (answer.radiosity, answer.gradient))
}

/// A change of the input by a small number.
#[derive(Debug, Clone, Copy)]
enum Motion {
    /// The receiver by that length along a unit vector.
    Position(DVec3),
    /// The normal by that angle towards a unit vector across it.
    Turn(DVec3),
    /// The emitter's plane by that slope: vertices rise along n2 by it times their coordinate along a unit vector in the plane.
    Slope(DVec3),
    /// A vertex by that length along a unit vector in the plane.
    Vertex(usize, DVec3),
}

struct Setup<'a> {
    receiver: &'a Receiver,
    emitter: &'a Emitter,
    /// Largest distance of a vertex from the receiver: an angle moves points at most this far away.
    reach: f64,
    feature: f64,
}

impl<'a> Setup<'a> {
    fn new(receiver: &'a Receiver, emitter: &'a Emitter) -> Self {
        let x = receiver.position();
        let reach = emitter.polygon().vertices().iter().map(|v| (*v - x).length()).fold(0.0, f64::max);
        Self { receiver, emitter, reach, feature: closest_feature(receiver, emitter.polygon()) }
    }

    /// Each motion with its size by half an ulp and how far a unit of it moves a point.
    fn motions(&self) -> Vec<(Motion, f64, f64)> {
        let polygon = self.emitter.polygon();
        let (x, n1, n2) = (self.receiver.position(), self.receiver.normal(), polygon.normal());
        let largest = polygon.vertices().iter().fold(DVec3::ZERO, |m, v| m.max(v.abs()));
        let mut motions = Vec::with_capacity(7 + 2 * polygon.vertices().len());
        for axis in [DVec3::X, DVec3::Y, DVec3::Z] {
            motions.push((Motion::Position(axis), half_ulp(x.dot(axis)) + half_ulp(largest.dot(axis)), 1.0));
        }
        for axis in across(n1) {
            motions.push((Motion::Turn(axis), 0.5 * f64::EPSILON, self.reach));
        }
        let in_plane = principal_axes(polygon);
        for axis in in_plane {
            motions.push((Motion::Slope(axis), half_ulp(largest.max_element()) / width(polygon, axis), self.reach));
        }
        for (index, v) in polygon.vertices().iter().enumerate() {
            for axis in across(n2) {
                motions.push((Motion::Vertex(index, axis), half_ulp(v.abs().max_element()), 1.0));
            }
        }
        motions
    }

    fn moved(&self, motion: Motion, step: f64) -> Result<(Receiver, Emitter), Error> {
        let (mut position, mut normal) = (self.receiver.position(), self.receiver.normal());
        let polygon = self.emitter.polygon();
        let mut vertices = polygon.vertices().to_vec();
        match motion {
            Motion::Position(axis) => position += axis * step,
            Motion::Turn(axis) => normal += axis * step,
            Motion::Slope(axis) => {
                let base = vertices[0];
                for v in &mut vertices {
                    *v += polygon.normal() * (step * axis.dot(*v - base));
                }
            }
            Motion::Vertex(index, axis) => vertices[index] += axis * step,
        }
        // A polynomial is a function of the place and stays; an affine function moves along with vertex 0.
        let emission = match self.emitter.emission() {
            Emission::Polynomial(polynomial) => Emission::Polynomial(polynomial.clone()),
            Emission::Constant(_) | Emission::Linear(_) => {
                Emission::gradient(self.emitter.emission_at(polygon.vertices()[0]), self.emitter.emission_gradient())
            }
        };
        let receiver = Receiver::new(position, normal, self.receiver.reflectance())?;
        Ok((receiver, Emitter::new(Polygon::from_rounded(vertices, polygon.precision())?, emission)?))
    }
}

/// Smallest length in the problem that is not 0.
fn closest_feature(receiver: &Receiver, polygon: &Polygon) -> f64 {
    let (x, n1) = (receiver.position(), receiver.normal());
    let vertices = polygon.vertices();
    let count = vertices.len();
    let mut closest = f64::INFINITY;
    let mut consider = |length: f64| {
        if length > 0.0 && length < closest {
            closest = length;
        }
    };
    consider(polygon.normal().dot(x - vertices[0]).abs());
    for (i, &a) in vertices.iter().enumerate() {
        consider((a - x).length());
        consider(n1.dot(a - x).abs());
        let b = vertices[(i + 1) % count];
        consider(distance_to_segment(x, a, b));
        for other in (2..count).map(|k| vertices[(i + k) % count]) {
            consider(distance_to_segment(other, a, b));
        }
    }
    closest
}

fn distance_to_segment(point: DVec3, a: DVec3, b: DVec3) -> f64 {
    let (edge, r) = (b - a, point - a);
    let t = (r.dot(edge) / edge.dot(edge)).clamp(0.0, 1.0);
    (r - edge * t).length()
}

/// Two unit vectors across a unit vector and each other.
fn across(n: DVec3) -> [DVec3; 2] {
    let n = n.normalize();
    let first = n.any_orthonormal_vector();
    [first, n.cross(first)]
}

/// The direction of the longest edge, and the one across it in the plane.
fn principal_axes(polygon: &Polygon) -> [DVec3; 2] {
    let vertices = polygon.vertices();
    let edges = (0..vertices.len()).map(|i| vertices[(i + 1) % vertices.len()] - vertices[i]);
    let longest = edges.fold(DVec3::ZERO, |best, e| if e.length_squared() > best.length_squared() { e } else { best });
    let along = longest / longest.length();
    [along, polygon.normal().cross(along)]
}

fn width(polygon: &Polygon, axis: DVec3) -> f64 {
    let base = polygon.vertices()[0];
    let places = polygon.vertices().iter().map(|v| axis.dot(*v - base));
    let (low, high) = places.fold((0.0, 0.0), |(low, high): (f64, f64), p| (low.min(p), high.max(p)));
    high - low
}

/// Half the distance to the next double away from 0.
fn half_ulp(x: f64) -> f64 {
    0.5 * (x.abs().next_up() - x.abs())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cases::family::Family;
    use radgrad_core::radiosity_and_gradient;

    fn relative(family: Family, index: u64) -> (f64, f64) {
        let problem = family.case(1, index).problem().unwrap();
        let condition = Condition::unoccluded(&problem.receiver, &problem.emitter).unwrap();
        let (b, g) = radiosity_and_gradient(&problem.receiver, &problem.emitter).unwrap();
        (condition.radiosity / b, condition.gradient / g.length())
    }

    #[test]
    fn a_generic_case_is_known_to_a_few_ulp() {
        for index in 0..100 {
            let (value, gradient) = relative(Family::Generic, index);
            assert!((2e-16..1e-13).contains(&value), "{index}: {value:e}");
            assert!((2e-16..1e-13).contains(&gradient), "{index}: {gradient:e}");
        }
    }

    #[test]
    fn height_over_the_plane_is_what_a_grazing_value_depends_on() {
        // Over z = 0 at height h, B is proportional to h, and h is an exact input: its half ulp is no more than eps/2 of it. The
        // vertices' z are exact zeros; their half ulp is nothing. There remains the slope of the plane: eps/2 of the distance.
        let x = DVec3::new(3.0, 0.2, 1e-9);
        let triangle = Polygon::new(vec![DVec3::ZERO, DVec3::X, DVec3::Y]).unwrap();
        let emitter = Emitter::new(triangle, Emission::Constant(1.0)).unwrap();
        let receiver = Receiver::new(x, -DVec3::X, 1.0).unwrap();
        let condition = Condition::unoccluded(&receiver, &emitter).unwrap();
        let (b, _) = radiosity_and_gradient(&receiver, &emitter).unwrap();
        let tilted = f64::EPSILON / 1e-9;
        assert!((0.3 * tilted..6.0 * tilted).contains(&(condition.radiosity / b)), "{:e}", condition.radiosity / b / tilted);
    }

    #[test]
    fn a_shifted_origin_costs_the_digits_it_takes() {
        let condition_shifted = |shift: f64| {
            let problem = Family::Generic.case(1, 0).problem().unwrap();
            let shift = DVec3::splat(shift);
            let vertices = problem.emitter.polygon().vertices().iter().map(|v| *v + shift).collect();
            let emitter = Emitter::new(Polygon::new(vertices).unwrap(), Emission::Constant(1.0)).unwrap();
            let receiver = Receiver::new(problem.receiver.position() + shift, problem.receiver.normal(), 1.0).unwrap();
            Condition::unoccluded(&receiver, &emitter).unwrap().radiosity
        };
        let ratio = condition_shifted(2f64.powi(30)) / condition_shifted(2f64.powi(20));
        assert!((500.0..2100.0).contains(&ratio), "{ratio}");
    }

    #[test]
    fn every_case_with_light_has_a_condition() {
        for family in Family::ALL.into_iter().filter(|f| !f.is_refused()) {
            // Each number of a hundred vertices moves by itself.
            for index in 0..if family == Family::HundredVertices { 1 } else { 20 } {
                let problem = family.case(3, index).problem().unwrap();
                if evaluate(&problem.receiver, &problem.emitter, &[]).unwrap().radiosity == 0.0 {
                    continue;
                }
                let condition = Condition::unoccluded(&problem.receiver, &problem.emitter);
                let condition = condition.unwrap_or_else(|error| panic!("{family}:3:{index}: {error}"));
                assert!(condition.radiosity.is_finite() && condition.gradient.is_finite(), "{family}:3:{index} {condition:?}");
            }
        }
    }
}
