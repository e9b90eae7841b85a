//! The same case in another unit, turned, mirrored, named from another vertex, or with other or negative brightness: each answer and each
//! bound is the same, or times the unit's power.
//!
//! Nothing need be known of the truth, so that bounds are told too that no error comes near. A unit of length or of emission that is a
//! power of two changes no digit; turned or mirrored, sums are rounded in another order. Beside the place itself derivatives are nearly the same,
//! or have a bound that says how far from it they may be.

use glam::{DMat3, DVec3};
use radgrad_core::{
    Emission, Emitter, Error, Method, Polygon, Receiver, derivatives, evaluate_to, hessian_to, irradiance_vector_to,
};
use radgrad_scene::case::{Case, EmissionRecord, Problem};
use rayon::prelude::*;

use crate::bounds::witness::{self, AnswerMethod, Query};
use crate::cases::family::{Family, Name};
use crate::cases::sampler::Sampler;
use crate::measures::measure::{is_worse, worse};

/// A change after which the answers are known.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Change {
    /// Lengths times 2 to this power.
    Lengths(i32),
    /// Emission times a power of two, or minus one.
    Emission(f64),
    /// x for y, y for z, z for x.
    Turned,
    /// -z for z, and vertices in the other order from the same first one.
    Mirrored,
    /// The second vertex named first.
    Renamed,
}

const CHANGES: [Change; 8] = [
    Change::Lengths(3),
    Change::Lengths(-40),
    Change::Lengths(200),
    Change::Emission(-1.0),
    Change::Emission(1.0 / 1024.0),
    Change::Turned,
    Change::Mirrored,
    Change::Renamed,
];

/// A value with its bound, in units of length to a power.
struct Said {
    what: &'static str,
    by: Option<AnswerMethod>,
    method: Option<Method>,
    value: DMat3,
    bound: f64,
    power: i32,
}

/// The largest relative distance of two bounds that are the same sums in another order.
const ORDER: f64 = 1e-9;

/// The same in single precision.
const SINGLE_ORDER: f64 = 1e-5;

/// The same of bounds on the effect of rounding.
const ROUGH: f64 = 0.5;

impl Change {
    /// The largest relative distance of bounds before and after it; none if it is not known. Where the bound is found along with the rounding
    /// errors (past occluders and horizons, of second derivatives) another order is another bound.
    fn room(self, said: &Said, is_whole: bool) -> Option<f64> {
        match (self, said.by) {
            // Where emission is nowhere negative fewer nodes are enough.
            (Self::Emission(factor), Some(AnswerMethod::Quadrature)) if factor < 0.0 => None,
            (Self::Lengths(_) | Self::Emission(_), _) => Some(0.0),
            (_, Some(AnswerMethod::SingleLanes)) => Some(SINGLE_ORDER),
            (_, Some(AnswerMethod::Lanes)) => Some(ORDER),
            (Self::Turned, Some(AnswerMethod::Quadrature)) => Some(ORDER),
            (_, Some(AnswerMethod::ClosedForm)) if is_whole => Some(ROUGH),
            _ => None,
        }
    }

    /// The unit of length after it.
    pub(crate) fn length(self) -> f64 {
        if let Self::Lengths(power) = self { libm::ldexp(1.0, power) } else { 1.0 }
    }

    /// The factor of the emission.
    pub(crate) const fn factor(self) -> f64 {
        if let Self::Emission(factor) = self { factor } else { 1.0 }
    }

    fn point(self, [x, y, z]: [f64; 3]) -> [f64; 3] {
        match self {
            Self::Turned => [y, z, x],
            Self::Mirrored => [x, y, -z],
            _ => [x, y, z],
        }
    }

    fn polygon<T: Clone>(self, vertices: &mut [T]) {
        match self {
            Self::Mirrored => vertices[1..].reverse(),
            Self::Renamed => vertices.rotate_left(1),
            _ => {}
        }
    }

    /// The case after it; none where it is another one by rounding.
    pub(crate) fn of(self, case: &Case) -> Option<Case> {
        let mut case = case.clone();
        let at = |p: &mut [f64; 3]| *p = self.point(*p).map(|c| c * self.length());
        at(&mut case.receiver.position);
        case.receiver.normal = self.point(case.receiver.normal);
        case.precision *= self.length();
        for polygon in std::iter::once(&mut case.emitter.vertices).chain(&mut case.occluders) {
            polygon.iter_mut().for_each(at);
            self.polygon(polygon);
        }
        let factor = self.factor();
        match &mut case.emitter.emission {
            EmissionRecord::Constant { constant } => *constant *= factor,
            EmissionRecord::Vertices { vertices } => {
                self.polygon(vertices);
                vertices.iter_mut().for_each(|value| *value *= factor);
            }
            EmissionRecord::Gradient { .. } if self == Self::Renamed => return None,
            EmissionRecord::Gradient { value, gradient } => {
                *value *= factor;
                *gradient = self.point(*gradient).map(|c| c * factor / self.length());
            }
            EmissionRecord::Polynomial { polynomial } if matches!(self, Self::Emission(_)) => {
                polynomial.terms.iter_mut().for_each(|term| term.coefficient *= factor);
            }
            EmissionRecord::Polynomial { .. } if self == Self::Renamed => {}
            EmissionRecord::Polynomial { .. } | EmissionRecord::Expression { .. } => return None,
        }
        Some(case)
    }

    /// The value back, as it was before.
    fn undone(self, said: &Said) -> (DMat3, f64) {
        let unit = self.length().powi(said.power);
        let (factor, size) = if let Self::Emission(factor) = self { (1.0 / factor, 1.0 / factor.abs()) } else { (1.0, 1.0) };
        // The images of the axes, as columns.
        let back = DMat3::from_cols_array(
            &[[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]
                .map(|axis| self.point(axis))
                .concat()
                .try_into()
                .unwrap_or_default(),
        );
        let value = match said.power {
            // A scalar, a vector, a matrix.
            0 if said.what.ends_with("value") => said.value,
            -2 => back.transpose() * said.value * back,
            _ => back.transpose() * said.value,
        };
        (value * (factor / unit), said.bound * (size / unit))
    }
}

fn column(v: DVec3) -> DMat3 {
    DMat3::from_cols(v, DVec3::ZERO, DVec3::ZERO)
}

/// All that is said of a case to small effort.
fn said(problem: &Problem) -> Vec<Said> {
    let Problem { receiver, emitter, occluders, .. } = problem;
    let mut statements = Vec::new();
    let asks = [
        (Query::Answer(1.0), "answer's value", "answer's gradient"),
        (Query::Value(1.0), "plain value", ""),
        (Query::Lanes(1.0), "lanes' value", "lanes' gradient"),
        (Query::SingleLanes(1.0), "single lanes' value", "single lanes' gradient"),
    ];
    for (ask, value, gradient) in asks {
        let mut problem = problem.clone();
        if matches!(ask, Query::SingleLanes(_)) && !witness::round_to_single(&mut problem) {
            continue;
        }
        let Ok(Some((by, answer))) = ask.answer(&problem) else { continue };
        let method = None;
        let scalar = column(DVec3::X * answer.radiosity);
        statements.push(Said { what: value, by, method, value: scalar, bound: answer.radiosity_error, power: 0 });
        if !gradient.is_empty() {
            let vector = column(answer.gradient);
            statements.push(Said { what: gradient, by, method, value: vector, bound: answer.gradient_error, power: -1 });
        }
    }
    if let Ok(answer) = hessian_to(receiver, emitter, occluders, 1.0) {
        let (by, method) = (None, Some(answer.method));
        statements.push(Said { what: "second derivatives", by, method, value: answer.matrix, bound: answer.error, power: -2 });
    }
    if let Ok(answer) = irradiance_vector_to(receiver, emitter, occluders, 1.0) {
        let (by, method) = (None, Some(answer.method));
        statements.push(Said {
            what: "irradiance vector",
            by,
            method,
            value: column(answer.vector),
            bound: answer.error,
            power: 0,
        });
    }
    statements
}

/// Of families whose coordinates lie well within the range, so that another unit is no other case.
const FAMILIES: [Family; 36] = [
    Family::Generic,
    Family::Far,
    Family::Clipped,
    Family::Contact,
    Family::NearEdge,
    Family::NearVertex,
    Family::NearExtension,
    Family::Grazing,
    Family::HorizonSliver,
    Family::Needle,
    Family::FarOrigin,
    Family::Concave,
    Family::NGon,
    Family::FarNeedle,
    Family::FarClipped,
    Family::FarScreen,
    Family::ContactSliver,
    Family::SteepExtension,
    Family::PolynomialFar,
    Family::PolynomialClipped,
    Family::InPlaneOutside,
    Family::BackFacing,
    Family::BelowHorizon,
    Family::OnSurface,
    Family::ShortNormal,
    Family::CancellingValues,
    Family::OccludersInPlane,
    Family::OneScreen,
    Family::SilhouetteScreen,
    Family::EdgeScreen,
    Family::DippingScreen,
    Family::NearScreen,
    Family::SteepNormal,
    Family::Standing,
    Family::Single,
    Family::IdleScreens,
];

/// Cases of each.
const CASES: u64 = 2;

/// Contradictions in a few cases of each family after a change.
#[must_use]
pub fn all_wrong() -> Vec<String> {
    let names = FAMILIES.into_iter().flat_map(|family| (0..CASES).map(move |index| Name { family, seed: 17, index }));
    let told: Vec<_> = names.collect::<Vec<_>>().into_par_iter().map(|name| (name, wrong(&name.case()))).collect();
    let count: usize = told.iter().map(|(_, (count, _))| count).sum();
    let few = (count < 20 * told.len()).then(|| format!("only {count} statements are compared"));
    let in_line = (0..IN_LINE).map(in_line).chain([of_touched(), of_small_corner()]);
    told.into_iter()
        .flat_map(|(name, (_, findings))| findings.into_iter().map(move |what| format!("{name}: {what}")))
        .chain(few)
        .chain(in_line.flat_map(|told| told.unwrap_or_else(|error| vec![error.to_string()])))
        .collect()
}

/// How many screens have an edge that the receiver sees in line with an edge of the lamp.
const IN_LINE: u64 = 40;

/// The distance to places beside a receiver: light whose gradient has one value changes it by little over it.
const BESIDE: f64 = 1.0 / (1 << 20) as f64;

/// The most that the second derivatives of these cases are.
const STEEPEST: f64 = 1e3;

/// The receiver sees an edge of a screen exactly in line with a part of the lamp's edge; the screen hides the lamp there, or lies beside it. The
/// gradient and the derivatives by vertices have two values: their bounds have to reach the values at every place beside.
fn in_line(index: u64) -> Result<Vec<String>, Error> {
    let s = &mut Sampler::new(37, "in line", index);
    let mut eighth = |low: i64, high: i64| s.integer(low, high) as f64 * 0.125;
    // Of half of them the plane through both edges is one of constant x.
    let slant = if index.is_multiple_of(2) { 0.0 } else { eighth(-8, 8) };
    let place = DVec3::new(eighth(-8, 8), eighth(-8, 8), eighth(-8, 8));
    let [a, b] = [eighth(-8, 0), eighth(1, 8)].map(|y| DVec3::new(slant, y, 1.0));
    let lamp = [a, b, DVec3::new(slant + 1.0, eighth(-8, 8), 1.0)];
    let [from, to] = [eighth(-8, 4), eighth(5, 12)].map(|share| a + (b - a) * share);
    let aside = DVec3::new(if index % 4 < 2 { -0.5 } else { 0.25 }, eighth(-2, 2), 0.0);
    let screen = [from * 0.5, to * 0.5, from * 0.5 + aside];
    let turn = |p: DVec3| place + if index.is_multiple_of(3) { p } else { DVec3::new(p.z, p.x, p.y) };
    let (mut lamp, screen) = (lamp.map(turn), Polygon::new(screen.map(turn).to_vec())?);
    // The lamp shines towards the receiver.
    if (lamp[1] - lamp[0]).cross(lamp[2] - lamp[0]).dot(place - lamp[0]) < 0.0 {
        lamp.reverse();
    }
    let lamp = Emitter::new(Polygon::new(lamp.to_vec())?, Emission::Constant(1.0))?;
    let asked = |aside: DVec3| -> Result<Vec<(DVec3, f64)>, Error> {
        let receiver = Receiver::new(place + aside * BESIDE, turn(DVec3::new(0.125, 0.25, 1.0)) - place, 1.0)?;
        let (light, by) = (evaluate_to(&receiver, &lamp, [&screen], 1e-9)?, derivatives(&receiver, &lamp, [&screen], 1e-9)?);
        let vertices = by.vertices.iter().chain(by.occluders.iter().flatten()).map(|vertex| (vertex.value, vertex.error));
        Ok(std::iter::once((light.gradient, light.gradient_error)).chain(vertices).collect())
    };
    let (here, mut findings) = (asked(DVec3::ZERO)?, Vec::new());
    for way in [DVec3::X, DVec3::Y, DVec3::Z].into_iter().flat_map(|axis| [axis, -axis]) {
        for (k, ((value, error), (beside, of_beside))) in here.iter().zip(asked(way)?).enumerate() {
            let apart = (*value - beside).length();
            if is_worse(apart, error + of_beside + STEEPEST * BESIDE) {
                findings.push(format!("in line {index}: derivative {k} is {value} to {error:e}, {apart:e} off just beside"));
            }
        }
    }
    Ok(findings)
}

/// A screen that touches a triangle's edge as it is seen hides nothing, and the edge stays where it is, whichever corner is named first.
fn of_touched() -> Result<Vec<String>, Error> {
    let corners = [[0.0, 1.0], [1.0, 0.0], [-1.0, 0.0]].map(|[x, y]| DVec3::new(x, y, 1.0));
    let screen = [[-1.0, 0.0], [1.0, 0.0], [1.0, -1.0], [-1.0, -1.0]].map(|[x, y]| DVec3::new(x, y, 0.5));
    let screen = Polygon::new(screen.to_vec())?;
    let receiver = Receiver::new(DVec3::X * 0.1, DVec3::new(0.1, 0.2, 1.0), 1.0)?;
    let mut findings = Vec::new();
    for first in 0..corners.len() {
        let mut named = corners.to_vec();
        named.rotate_left(first);
        let lamp = Emitter::new(Polygon::new(named)?, Emission::Constant(1.0))?;
        let free = evaluate_to(&receiver, &lamp, &[], 1e-9)?;
        let touched = evaluate_to(&receiver, &lamp, [&screen], 1e-9)?;
        if is_worse((free.gradient - touched.gradient).length(), free.gradient_error + 1e-15) {
            findings.push(format!("named from corner {first}: {touched:?} past a screen that hides nothing, {free:?} without"));
        }
    }
    Ok(findings)
}

/// From a corner of which all coordinates are at most 0, in a unit in which squares are a few of the least number: the same light.
fn of_small_corner() -> Result<Vec<String>, Error> {
    let seen = |unit: f64| {
        let polygon = |corners: &[[f64; 3]]| Polygon::new(corners.iter().map(|corner| DVec3::from(*corner) * unit).collect());
        let lamp = polygon(&[[0.0, 0.0, -1.55], [-0.62, 0.0, -1.55], [0.0, -0.62, -1.55]])?;
        let screen = polygon(&[[-0.3, 0.0, -1.18], [-0.62, 0.0, -1.18], [0.0, -0.62, -1.18], [0.0, -0.3, -1.18]])?;
        let receiver = Receiver::new(DVec3::ZERO, DVec3::NEG_Z, 1.0)?;
        evaluate_to(&receiver, &Emitter::new(lamp, Emission::Constant(1.0))?, [&screen], 1e-9)
    };
    let (one, small) = (seen(1.0)?, seen(libm::ldexp(1.0, -537))?);
    let is_same = (one.radiosity, one.radiosity_error) == (small.radiosity, small.radiosity_error);
    Ok(if is_same { Vec::new() } else { vec![format!("{one:?} is in a unit of 2^-537 {small:?}")] })
}

/// Contradictions between a case and the same after each change, and how many statements are compared.
#[must_use]
pub fn wrong(case: &Case) -> (usize, Vec<String>) {
    let Ok(problem) = case.problem() else { return (0, Vec::new()) };
    let (x, n1) = (problem.receiver.position(), problem.receiver.normal());
    let is_whole = problem.occluders.is_empty() && problem.emitter.polygon().vertices().iter().all(|v| n1.dot(*v - x) > 0.0);
    let (before, mut count, mut findings) = (said(&problem), 0, Vec::new());
    for change in CHANGES {
        let Some(Ok(problem)) = change.of(case).map(|case| case.problem()) else { continue };
        let after = said(&problem);
        for (one, other) in before.iter().filter_map(|one| Some((one, after.iter().find(|other| other.what == one.what)?))) {
            // Another part of the code has another bound.
            if (one.by, one.method) != (other.by, other.method) {
                continue;
            }
            count += 1;
            let (value, bound) = change.undone(other);
            let difference = (value - one.value).to_cols_array().iter().fold(0.0, |most, c| worse(most, c.abs()));
            let share = change.room(one, is_whole);
            let room = if share == Some(0.0) { 0.0 } else { one.bound + bound };
            if is_worse(difference, room) || share.is_some_and(|share| is_worse((bound - one.bound).abs(), share * one.bound)) {
                let what = one.what;
                findings
                    .push(format!("{change:?}, {what}: off by {difference:e}, the bound is {bound:e}, it was {:e}", one.bound));
            }
        }
    }
    (count, findings)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_the_same_in_another_unit_is_compared_digit_by_digit() {
        let case = Family::Clipped.case(1, 0);
        let (count, findings) = wrong(&case);
        assert!(count > 20 && findings.is_empty(), "{count}: {findings:?}");
        let said = said(&case.problem().unwrap());
        let of = |what: &str| said.iter().find(|one| one.what == what).unwrap();
        assert_eq!(Change::Lengths(3).room(of("second derivatives"), false), Some(0.0));
        assert_eq!(Change::Mirrored.room(of("second derivatives"), false), None);
        // Eight times as far off, the matrix is a 64th.
        let after = super::said(&Change::Lengths(3).of(&case).unwrap().problem().unwrap());
        let after = after.iter().find(|one| one.what == "second derivatives").unwrap();
        assert_eq!(after.value * 64.0, of("second derivatives").value);
    }
}
