//! Answers of the solver and of certificates that must be the same ones: of a scene in other units of light, with its channels in another
//! order.
//!
//! Nothing is said of which answer is right, and no bound is spared: every number that a solution gives is compared, so that what is decided
//! by a fixed amount of light, or in a channel by the light of another one, is seen.
//!
//! Beside them stands what certificates owe: limits that miss a known solution no more often than they say, and refusals.

use glam::DVec3;
use radgrad_certificate::{Interval, Place, Request, certify, certify_points};
use radgrad_scene::largest;
use radgrad_solver::{Ledger, Marking, Options, Solution, solve_for};

use super::family::Name;
use super::model::{Change, Model};
use crate::measures::measure::is_worse;

/// The order of the channels in the changed scene, in which none has the next one after it, and what light is multiplied by: a power of two, so that every digit stays.
const CHANNELS: [usize; 3] = [2, 1, 0];
const UNIT: f64 = 1.0 / (1u64 << 40) as f64;

/// Allowed difference of two numbers, over the largest of their kind or the mean of light: sums in another order round otherwise.
const ROUNDING: f64 = 1e-9;

/// Elements, and rounds.
const ELEMENTS: usize = 30;
const ROUNDS: usize = 2;

/// A kind of numbers that are proportional to the light of a channel, each with its values in all channels.
type Kind = (&'static str, Vec<Vec<f64>>);

/// Contradictions between the solutions, and the certificates, of a scene and of the same with light in another unit and channels in another order.
///
/// # Errors
/// If there is no answer: why.
pub fn in_other_channels(model: &Model) -> Result<Vec<String>, String> {
    let mut changed = model.clone();
    for part in &mut changed.parts {
        let of = |values: &[f64], unit: f64| CHANNELS.map(|from| unit * values[from % values.len()]).to_vec();
        (part.reflectance, part.emitted) = (of(&part.reflectance, 1.0), of(&part.emitted, UNIT));
    }
    let mut findings = Vec::new();
    for told in [solved, certified] {
        let (before, wrong) = told(model)?;
        let light: Vec<f64> = before[0].1.iter().map(|mean| mean[0].abs()).collect();
        findings.extend(wrong);
        for ((kind, before), (_, after)) in before.iter().zip(&told(&changed)?.0) {
            for (channel, &from) in CHANNELS.iter().enumerate() {
                let from = from % before.len();
                let pairs = before[from].iter().zip(&after[channel]).map(|(b, a)| (b * UNIT, *a)).collect();
                let least = ROUNDING * UNIT * light[from];
                let what = apart(pairs, least);
                findings.extend(what.map(|what| format!("{kind}, channel {from} with light times {UNIT:e}: {what}")));
            }
        }
    }
    Ok(findings)
}

/// The pair that differs by more than rounding of the largest one, and than what counts at least.
fn apart(pairs: Vec<(f64, f64)>, least: f64) -> Option<String> {
    let size = pairs.iter().map(|(b, _)| b.abs()).filter(|size| size.is_finite()).fold(0.0, largest);
    // What is no number is alike only where it is in both.
    let is_apart = |(b, a): &(f64, f64)| a.to_bits() != b.to_bits() && is_worse((a - b).abs(), largest(ROUNDING * size, least));
    pairs.into_iter().find(is_apart).map(|(b, a)| format!("{a:e} where it was {b:e}"))
}

/// All numbers of a solution, and what is wrong with its mesh.
fn solved(model: &Model) -> Result<(Vec<Kind>, Vec<String>), String> {
    let (solution, asked) = solution(model)?;
    let kinds = told(&solution, &asked, model.channels()).map_err(|error| error.to_string())?;
    Ok((kinds, uncovered(&solution)))
}

/// Faces of which the elements have another area, and elements of which points are not where they are.
pub(crate) fn uncovered(solution: &Solution) -> Vec<String> {
    let mesh = solution.mesh();
    let mut findings = Vec::new();
    for (face, polygon) in mesh.polygons().iter().enumerate() {
        let of_face = |element: &usize| mesh.elements()[*element].face() == face;
        let roots: f64 = mesh.roots().iter().copied().filter(of_face).map(|root| mesh.elements()[root].area()).sum();
        let leaves: f64 = mesh.leaves().filter(of_face).map(|leaf| mesh.elements()[leaf].area()).sum();
        if is_worse((roots - polygon.area()).abs().max((leaves - polygon.area()).abs()), 1e-7 * polygon.area()) {
            findings.push(format!("elements of face {face} have the areas {roots} and {leaves}, that has {}", polygon.area()));
        }
    }
    for leaf in mesh.leaves() {
        let (element, at) = (&mesh.elements()[leaf], [0.3, 0.2]);
        let point = element.point(at);
        let back = element.reference(point);
        let off = [0, 1].map(|axis: usize| (back[axis] - at[axis]).abs()).into_iter().fold(0.0, largest);
        if is_worse(off, 1e-9) || mesh.leaf_at(element.face(), point) != Some(leaf) {
            findings.push(format!(
                "a point of leaf {leaf} is {off:e} from where it was, and on {:?}",
                mesh.leaf_at(element.face(), point)
            ));
        }
    }
    findings
}

/// The solution of a scene, and the points that are asked for.
fn solution(model: &Model) -> Result<(Solution, Vec<(DVec3, DVec3)>), String> {
    let said = |error: radgrad_solver::Error| error.to_string();
    let scene = model.scene().map_err(|error| error.to_string())?;
    let asked = model.asked().map_err(|error| error.to_string())?;
    let options = Options {
        error: model.error,
        degree: model.degree,
        most_elements: ELEMENTS,
        first_elements: 1,
        marking: model.ways.marking,
        ..Options::default()
    };
    let served = if model.ways.for_points { &asked[..] } else { &[] };
    let goes_on = |solution: &Solution| solution.progress().round < ROUNDS;
    let solution = solve_for(&scene, &options, &[], served, goes_on).map_err(said)?;
    Ok((solution, asked))
}

/// All numbers that a solution gives, each kind in each channel as a sum with weights of their own and the sum of magnitudes.
///
/// # Errors
/// If there is no answer: why.
pub(crate) fn recorded(name: Name) -> Result<Vec<(f64, f64)>, String> {
    let mut model = name.model();
    // Scenes of a family are asked for in turn in each way.
    model.ways.marking = match (name.index % 2, name.index / 4 % 2) {
        (0, _) => Marking::Residual,
        (_, 0) => Marking::Gradient,
        _ => Marking::Shadows,
    };
    model.ways.for_points = name.index / 2 % 2 == 1;
    let (solution, asked) = solution(&model)?;
    let kinds = told(&solution, &asked, model.channels()).map_err(|error| error.to_string())?;
    let progress = solution.progress();
    let counts = [progress.elements, progress.links, progress.gathers].map(|count| (count as f64, 0.5));
    let of = |values: &Vec<f64>| {
        let weighed =
            values.iter().enumerate().map(|(index, value)| value * (0.5 + (0.618_033_988_749_894_9 * index as f64).fract()));
        weighed.fold((0.0, 0.0), |(sum, size): (f64, f64), value| (sum + value, size + WIDTH * value.abs()))
    };
    Ok(counts.into_iter().chain(kinds.iter().flat_map(|(_, channels)| channels).map(of)).collect())
}

/// The part of the sum of magnitudes that stands for the bound of a sum.
const WIDTH: f64 = 1e-3;

/// All numbers that a solution has for polynomials, and for points.
fn told(solution: &Solution, asked: &[(DVec3, DVec3)], channels: usize) -> Result<Vec<Kind>, radgrad_solver::Error> {
    let each = |of: &dyn Fn(usize) -> Vec<f64>| (0..channels).map(of).collect::<Vec<_>>();
    let entries = |ledger: &Ledger| ledger.entries().to_vec();
    let leaves: Vec<usize> = solution.mesh().leaves().collect();
    let at = [0.3, 0.2];
    let on_leaves = |of: &dyn Fn(usize, usize) -> Vec<f64>| each(&|c| leaves.iter().flat_map(|&leaf| of(leaf, c)).collect());
    let gathered = asked.iter().map(|&(at, normal)| solution.gather(at, normal)).collect::<Result<Vec<_>, _>>()?;
    let sensors =
        asked.iter().map(|&(at, normal)| solution.irradiance_at(at + normal * 0.05, normal)).collect::<Result<Vec<_>, _>>()?;
    Ok(vec![
        ("mean", each(&|c| vec![solution.mean()[c], solution.reflected()[c], solution.relative_to()[c]])),
        ("estimate of the mean", each(&|c| entries(&solution.mean_estimate()[c]))),
        ("value", on_leaves(&|leaf, c| vec![solution.value_on(leaf, c, at), solution.least_on(leaf, c)])),
        ("estimate of values", on_leaves(&|leaf, c| entries(&solution.estimate_on(leaf)[c]))),
        ("irradiance", on_leaves(&|leaf, c| solution.irradiance_on(leaf, c))),
        ("slope", on_leaves(&|leaf, c| solution.gradient_on(leaf, c, at).to_array().to_vec())),
        ("estimate of slopes", on_leaves(&|leaf, c| vec![solution.gradient_estimate_on(leaf, c, at)])),
        ("value at a point", each(&|c| gathered.iter().map(|point| point.radiosity[c]).collect())),
        ("estimate at a point", each(&|c| gathered.iter().flat_map(|point| entries(&point.estimate[c])).collect())),
        ("irradiance of a sensor", each(&|c| sensors.iter().map(|sensor| sensor.irradiance[c]).collect())),
        ("estimate of a sensor", each(&|c| sensors.iter().flat_map(|sensor| entries(&sensor.estimate[c])).collect())),
    ])
}

/// All numbers of certificates, and what they contradict each other by.
fn certified(model: &Model) -> Result<(Vec<Kind>, Vec<String>), String> {
    let scene = model.scene().map_err(|error| error.to_string())?;
    let request = Request { width: 0.2, rays: 2_000, seed: 17, delta: 1e-3 };
    let certificate = certify(&scene, &request).map_err(|error| error.to_string())?;
    let asked = model.asked().map_err(|error| error.to_string())?.into_iter().zip(&model.probes);
    let places: Vec<Place> =
        asked.map(|((position, normal), probe)| Place { position, normal, face: Some(probe.part) }).take(1).collect();
    let points = certify_points(&scene, &places, &Request { rays: 500, ..request }).map_err(|error| error.to_string())?;
    let points = points.into_iter().collect::<Result<Vec<_>, _>>().map_err(|error| error.to_string())?;
    let ends = |limits: &Interval| vec![limits.lower, limits.upper];
    let each = |of: &dyn Fn(usize) -> Vec<f64>| (0..model.channels()).map(of).collect::<Vec<_>>();
    let mut findings = Vec::new();
    if model.change == Change::None {
        let areas: Vec<f64> = scene.faces().iter().map(|face| face.polygon().area()).collect();
        for (channel, limits) in certificate.reflected.iter().enumerate() {
            // A surface is a face.
            let sum: f64 = certificate.surfaces.iter().zip(&areas).map(|(surface, area)| area * surface[channel]).sum();
            let mean = sum / areas.iter().sum::<f64>();
            if !limits.contains(mean) {
                findings.push(format!("surfaces reflect {mean:e} in the mean, the limits are {limits:?}"));
            }
        }
    }
    let kinds = vec![
        ("certificate", each(&|c| [ends(&certificate.mean[c]), ends(&certificate.reflected[c])].concat())),
        ("surfaces", each(&|c| certificate.surfaces.iter().map(|surface| surface[c]).collect())),
        ("certificate at a point", each(&|c| points.iter().flat_map(|point| ends(&point.irradiance[c])).collect())),
        (
            "certified radiosity",
            each(&|c| points.iter().filter_map(|point| point.radiosity.as_ref()).flat_map(|of| ends(&of[c])).collect()),
        ),
    ];
    Ok((kinds, findings))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_number_that_is_another_one_in_other_channels_is_seen() {
        let told = |pairs: &[(f64, f64)]| apart(pairs.to_vec(), 1e-20).is_some();
        assert!(!told(&[(1.0, 1.0 + 1e-12), (f64::NAN, f64::NAN), (f64::INFINITY, f64::INFINITY)]));
        assert!(told(&[(1.0, 1.0), (1e-3, 1.1e-3)]) && told(&[(1.0, f64::NAN)]) && told(&[(0.0, 1e-19)]));
    }
}
