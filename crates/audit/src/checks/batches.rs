//! Batches of receivers, and the same batch in another unit, with negative emission, in another order, on other vectors and on all threads:
//! each answer and each bound is the same, or times the unit's power; and each is held against the receiver alone.

use glam::DVec3;
use radgrad_core::batch::{Answers, Engine, Precision, ReadyEmitter, Receivers};
use radgrad_core::{Answer, Emission, Emitter, Error, Method, Polygon, Receiver, evaluate_to};
use radgrad_scene::case::{Case, Problem};
use rayon::prelude::*;

use crate::cases::family::Family;
use crate::cases::sampler::Sampler;
use crate::checks::lamps::entries;
use crate::checks::symmetry::Change;
use crate::measures::measure::is_worse;
use crate::measures::truth::norm_above;

/// Families whose receivers a batch is drawn about.
pub(crate) const FAMILIES: [Family; 16] = [
    Family::Generic,
    Family::Far,
    Family::Clipped,
    Family::Contact,
    Family::NearEdge,
    Family::Grazing,
    Family::HorizonSliver,
    Family::Needle,
    Family::Scale,
    Family::NGon,
    Family::FarClipped,
    Family::SteepExtension,
    Family::PolynomialFar,
    Family::OneScreen,
    Family::EdgeScreen,
    Family::Standing,
];

/// The case of batch `index`, of each family in turn.
pub(crate) fn case(seed: u64, index: u64) -> Case {
    FAMILIES[usize::try_from(index % FAMILIES.len() as u64).unwrap_or(0)].case(seed, index)
}

/// Places about an emitter, and ways to face: near and far, before it and now and then behind.
pub(crate) fn receivers(sampler: &mut Sampler, problem: &Problem, count: usize) -> Vec<[DVec3; 2]> {
    let v = problem.emitter.polygon().vertices();
    let middle = v.iter().sum::<DVec3>() / v.len() as f64;
    let (x, n1) = (problem.receiver.position(), problem.receiver.direction());
    let drawn = |_| {
        let along = [1.0, 1.0, 0.5, 3.0, 1e-3, -0.5][sampler.below(6) as usize];
        let reach = (x - middle).length() * [0.02, 0.3, 1.5][sampler.below(3) as usize];
        let position = middle + (x - middle) * along + sampler.cube() * reach;
        let facing = if sampler.one_in(2) { n1 } else { n1 + sampler.cube() * n1.length() };
        [position, facing]
    };
    (0..count).map(drawn).collect()
}

/// The reflectance of a receiver by its place in the batch: each is a number of single precision.
const REFLECTANCES: [f64; 3] = [1.0, 0.5, 0.25];

/// To and from a precision.
pub(crate) struct Cast<F> {
    pub(crate) to: fn(f64) -> F,
    pub(crate) from: fn(F) -> f64,
    /// The least number that squares can be taken of.
    pub(crate) least: f64,
}

impl<F> Cast<F> {
    pub(crate) fn is_single(&self) -> bool {
        (self.from)((self.to)(0.1)) != 0.1
    }
}

/// Doubles as they are.
pub(crate) const DOUBLE: Cast<f64> = Cast { to: |x| x, from: |x| x, least: 1e-140 };

/// Rounded to single precision.
#[allow(clippy::cast_possible_truncation, reason = "single precision is asked")]
pub(crate) const SINGLE: Cast<f32> = Cast { to: |x| x as f32, from: f64::from, least: 1e-17 };

/// How many ways there are to ask a batch.
pub(crate) const WAYS: usize = 9;

/// The first way that occluders are asked in.
pub(crate) const PAST_OCCLUDERS: usize = 6;

/// Answers of a batch in one of the ways.
pub(crate) fn asked<F: Precision>(
    engine: Engine,
    (problem, ready): (&Problem, &ReadyEmitter<F>),
    of: &[[DVec3; 2]],
    cast: &Cast<F>,
    way: usize,
) -> Result<Answers<F>, Error> {
    let Problem { emitter, occluders, .. } = problem;
    let column = |which: usize, axis: usize| of.iter().map(|place| (cast.to)(place[which][axis])).collect::<Vec<F>>();
    let [x, n] = [0, 1].map(|which| [0, 1, 2].map(|axis| column(which, axis)));
    let rho: Vec<F> = (0..of.len()).map(|k| (cast.to)(REFLECTANCES[k % 3])).collect();
    let receivers = Receivers::new([&x[0], &x[1], &x[2]], [&n[0], &n[1], &n[2]], &rho)?;
    let screens: Vec<&Polygon> = occluders.iter().collect();
    let mut answers = Answers::<F>::default();
    match way {
        0 => engine.radiosity(&receivers, emitter, &mut answers)?,
        1 => engine.radiosity_and_gradient(&receivers, emitter, &mut answers)?,
        2 => engine.radiosity_to(&receivers, emitter, 1e-3, &mut answers)?,
        3 => engine.evaluate_to(&receivers, emitter, 1.0, &mut answers)?,
        4 => engine.evaluate_ready(&receivers, ready, 1e-5, &mut answers)?,
        5 => engine.evaluate_to(&receivers, emitter, 1e-10, &mut answers)?,
        6 => engine.radiosity_occluded(&receivers, emitter, &screens, 1e-2, &mut answers)?,
        7 => engine.evaluate_occluded(&receivers, emitter, &screens, 1.0, &mut answers)?,
        _ => engine.evaluate_occluded(&receivers, emitter, &screens, 1e-9, &mut answers)?,
    }
    Ok(answers)
}

/// One entry: the value, the gradient and both bounds; a quantity that is not requested is NaN.
pub(crate) fn entry<F: Copy>(answers: &Answers<F>, cast: &Cast<F>, k: usize) -> (f64, DVec3, [f64; 2]) {
    let of = |array: &Vec<F>| array.get(k).map_or(f64::NAN, |value| (cast.from)(*value));
    let slope = DVec3::from(answers.gradient.each_ref().map(of));
    (of(&answers.radiosity), slope, [of(&answers.radiosity_error), of(&answers.gradient_error)])
}

/// Changes of a case after which a batch's answers are known.
const CHANGES: [Change; 5] =
    [Change::Lengths(3), Change::Lengths(-17), Change::Lengths(40), Change::Emission(-1.0), Change::Emission(1.0 / 1024.0)];

/// Each receiver alone, without occluders and past them.
type Alone = [Result<Answer, Error>; 2];

fn each_alone(problem: &Problem, places: &[[DVec3; 2]]) -> Result<Vec<Alone>, Error> {
    let alone = places.iter().enumerate().map(|(k, [at, facing])| {
        let receiver = Receiver::new(*at, *facing, REFLECTANCES[k % 3])?;
        Ok([&[][..], &problem.occluders[..]].map(|occluders| evaluate_to(&receiver, &problem.emitter, occluders, 1e-12)))
    });
    alone.collect()
}

/// Where a batch contradicts its receivers alone.
fn beside_alone<F: Copy>(batch: &Answers<F>, alone: &[Alone], cast: &Cast<F>, is_past_occluders: bool) -> Vec<(usize, String)> {
    let mut findings = Vec::new();
    for (k, alone) in alone.iter().enumerate() {
        let (value, slope, [of_value, of_slope]) = entry(batch, cast, k);
        let Ok(truth) = &alone[usize::from(is_past_occluders)] else { continue };
        let difference = (value - truth.radiosity).abs();
        if !of_value.is_nan() && is_worse(difference, of_value + truth.radiosity_error) {
            findings.push((k, format!("{value:e} to {of_value:e}, alone it is {truth:?}")));
        }
        let difference = norm_above(slope - truth.gradient);
        if !of_slope.is_nan() && is_worse(difference, (of_slope + truth.gradient_error) * (1.0 + 1e-12)) {
            findings.push((k, format!("{slope} to {of_slope:e}, alone it is {truth:?}")));
        }
    }
    findings
}

/// Where a batch that is asked in one way contradicts its receivers alone.
fn in_one_way<F: Precision>(
    name: &str,
    problem: &Problem,
    places: &[[DVec3; 2]],
    cast: &Cast<F>,
    way: usize,
) -> Result<Vec<String>, Error> {
    let ready = ReadyEmitter::<F>::new(problem.emitter.clone());
    let answers = asked(Engine::new(), (problem, &ready), places, cast, way)?;
    let findings = beside_alone(&answers, &each_alone(problem, places)?, cast, way >= PAST_OCCLUDERS);
    Ok(findings.into_iter().map(|(k, what)| format!("{name}, receiver {k}: {what}")).collect())
}

/// Rounds a place to the precision.
fn rounded<F>(cast: &Cast<F>) -> impl Fn(DVec3) -> DVec3 {
    |v| v.map(|c| (cast.from)((cast.to)(c)))
}

/// A sail whose tip is before a lamp and whose other corners are far beside it, so that its middle is nearer or farther than the lamp: receivers
/// about one that the tip hides the lamp from.
///
/// # Errors
/// If a polygon or receiver is refused.
fn past_sails<F: Precision>(index: u64, cast: &Cast<F>) -> Result<Vec<String>, Error> {
    let sampler = &mut Sampler::new(56, "sails", index);
    let (n, distance) = (sampler.direction(), sampler.between(1.5, 8.0));
    let (u, v) = n.any_orthonormal_pair();
    let round = rounded(cast);
    let middle = n * distance;
    let lamp = [[-1.0, -1.0], [-1.0, 1.0], [1.0, 0.0]].map(|[x, y]| round(middle + u * x + v * y));
    let share = sampler.between(0.1, 0.9);
    let outward = sampler.perpendicular(n);
    let along = (outward + n * sampler.between(-0.1, 0.1)).normalize();
    let tip = middle * share + along * (share * sampler.between(0.0, 0.8));
    let (far, across) = (tip + along * (distance * sampler.spread(0, 6)), n.cross(outward) * sampler.spread(-3, 5));
    let sail = Polygon::new(vec![tip, far - across, far + across])?;
    let emitter = Emitter::new(Polygon::new(lamp.to_vec())?, Emission::Constant(1.0))?;
    let problem = Problem { receiver: Receiver::new(DVec3::ZERO, n, 1.0)?, emitter, occluders: vec![sail], tolerance: 1.0 };
    let places: Vec<[DVec3; 2]> = (0..5).map(|_| [sampler.cube() * 0.1, n + sampler.cube() * 0.5].map(&round)).collect();
    in_one_way(&format!("sail {index}"), &problem, &places, cast, PAST_OCCLUDERS + 1)
}

/// A wall that stands on the floor, turned, and receivers on the floor nearer and nearer to its foot, which is level with them to rounding.
///
/// # Errors
/// If a polygon or receiver is refused.
fn at_the_foot<F: Precision>(index: u64, cast: &Cast<F>) -> Result<Vec<String>, Error> {
    let sampler = &mut Sampler::new(57, "feet", index);
    let (n, round) = (sampler.direction(), rounded(cast));
    let along = sampler.perpendicular(n);
    let (out, width) = (n.cross(along), sampler.spread(-3, 3));
    let feet = [-width, width].map(|x| round(along * x));
    let top = round(n * sampler.between(0.5, 2.0) + along * sampler.between(-1.0, 1.0));
    let wall = Polygon::new(vec![feet[0], feet[1], top])?;
    let wall = if wall.normal().dot(out) > 0.0 { wall } else { Polygon::new(vec![feet[1], feet[0], top])? };
    let emitter = Emitter::new(wall, Emission::Constant(1.0))?;
    let problem = Problem { receiver: Receiver::new(out, n, 1.0)?, emitter, occluders: Vec::new(), tolerance: 1.0 };
    let place = |_| {
        let from = if cast.is_single() { -12 } else { -40 };
        let position = out * sampler.spread(from, 0) + along * (width * sampler.between(-1.5, 1.5));
        [round(position), round(n)]
    };
    let places: Vec<[DVec3; 2]> = (0..8).map(place).collect();
    in_one_way(&format!("foot {index}"), &problem, &places, cast, 3)
}

/// Contradictions of batch `index` in one precision.
fn of_precision<F: Precision>(index: u64, cast: &Cast<F>, name: &str) -> Result<Vec<String>, Error> {
    let case = case(54, index);
    let Ok(problem) = case.problem() else { return Ok(Vec::new()) };
    let sampler = &mut Sampler::new(54, "batches", index);
    let round = rounded(cast);
    let drawn = receivers(sampler, &problem, 13).into_iter().map(|place| place.map(&round));
    let places: Vec<[DVec3; 2]> = drawn.filter(|[at, facing]| Receiver::new(*at, *facing, 1.0).is_ok()).collect();
    let ready = ReadyEmitter::<F>::new(problem.emitter.clone());
    let mut findings = Vec::new();
    let mut reversed = places.clone();
    // Reflectances go by the place: of 13 the order of three is another one backwards, so that the first is left where it is.
    reversed[1..].reverse();
    let alone = each_alone(&problem, &places)?;
    for way in 0..WAYS {
        let asking = |engine, problem: (&Problem, &ReadyEmitter<F>), of: &[[DVec3; 2]]| asked(engine, problem, of, cast, way);
        let Ok(first) = asking(Engine::new(), (&problem, &ready), &places) else { continue };
        let mut tell =
            |k: usize, what: String| findings.push(format!("batch {index} of {name}, way {way}, receiver {k}: {what}"));
        if entries(&first.counts) != places.len() {
            tell(0, format!("{:?} of {} receivers", first.counts, places.len()));
        }
        for engine in Engine::all().into_iter().chain([Engine::new().threads()]) {
            if asking(engine, (&problem, &ready), &places).as_ref() != Ok(&first) {
                tell(0, format!("{engine} gives other digits"));
            }
        }
        beside_alone(&first, &alone, cast, way >= PAST_OCCLUDERS).into_iter().for_each(|(k, what)| tell(k, what));
        if let Ok(other) = asking(Engine::new(), (&problem, &ready), &reversed) {
            for k in (1..places.len()).filter(|k| k % 3 == (places.len() - k) % 3) {
                let same = [entry(&first, cast, k), entry(&other, cast, places.len() - k)].map(|entry| format!("{entry:?}"));
                if same[0] != same[1] {
                    tell(k, format!("{} instead of {} at another place of the batch", same[1], same[0]));
                }
            }
        }
        for change in CHANGES {
            let Some(Ok(changed)) = change.of(&case).map(|case| case.problem()) else { continue };
            let (length, factor) = (change.length(), change.factor());
            let moved: Vec<_> = places.iter().map(|[at, facing]| [*at * length, *facing]).collect();
            let ready = ReadyEmitter::<F>::new(changed.emitter.clone());
            let Ok(other) = asking(Engine::new(), (&changed, &ready), &moved) else { continue };
            for k in 0..places.len() {
                // Where emission is nowhere negative the Gauss rule has fewer nodes.
                let method = first.method.get(k);
                if method != other.method.get(k) || (factor < 0.0 && method != Some(&Method::ClosedForm)) {
                    continue;
                }
                let ((a, u, [e, f]), (b, v, [g, h])) = (entry(&first, cast, k), entry(&other, cast, k));
                let units = [1.0 / factor, 1.0 / factor.abs(), length / factor.abs()];
                let numbers = [(a, b, units[0]), (e, g, units[1]), (f, h, units[2])];
                let slopes = (0..3).map(|axis| (u[axis], v[axis], length / factor));
                // Squares of smaller numbers leave the range.
                let is_off = |&(was, is, unit): &(f64, f64, f64)| {
                    was.abs() > cast.least && is.abs() > cast.least && was.to_bits() != (is * unit).to_bits()
                };
                if let Some((was, is, unit)) = numbers.into_iter().chain(slopes).find(is_off) {
                    tell(k, format!("{change:?}: {:e} instead of {was:e}", is * unit));
                }
            }
        }
    }
    Ok(findings)
}

/// A lamp across one axis and receivers about its plane, some nearer than rounding, and the same with x, y and z turned: as many are
/// answered in each way, and on the dark side is nothing.
///
/// # Errors
/// If a lamp or receiver is refused.
fn across_an_axis<F: Precision>(index: u64, cast: &Cast<F>) -> Result<Vec<String>, Error> {
    let sampler = &mut Sampler::new(55, "axes", index);
    let level = sampler.integer(-8, 8) as f64 * 0.125;
    let corners = [[0.0, 0.0], [1.0, 0.25], [0.75, 1.0], [-0.25, 0.75]].map(|[y, z]| DVec3::new(level, y, z));
    let heights = |sampler: &mut Sampler| {
        let height = sampler.spread(-22, 2);
        if sampler.one_in(3) { -height } else { height }
    };
    let single = rounded(cast);
    let place = |_| {
        let position = DVec3::new(level + heights(sampler), sampler.between(-1.0, 2.0), sampler.between(-1.0, 2.0));
        [single(position), single(sampler.direction() - DVec3::X)]
    };
    let places: Vec<[DVec3; 2]> = (0..16).map(place).collect();
    let (mut findings, mut first) = (Vec::new(), None);
    for turn in 0..3 {
        let turned = |v: DVec3| {
            if turn == 0 {
                v
            } else if turn == 1 {
                DVec3::new(v.z, v.x, v.y)
            } else {
                DVec3::new(v.y, v.z, v.x)
            }
        };
        let emitter = Emitter::new(Polygon::new(corners.map(turned).to_vec())?, Emission::Constant(1.0))?;
        let problem =
            Problem { receiver: Receiver::new(DVec3::ZERO, DVec3::X, 1.0)?, emitter, occluders: Vec::new(), tolerance: 1.0 };
        let places: Vec<[DVec3; 2]> = places.iter().map(|place| place.map(turned)).collect();
        let ready = ReadyEmitter::<F>::new(problem.emitter.clone());
        let answers = asked(Engine::new(), (&problem, &ready), &places, cast, 3)?;
        for (k, [at, _]) in places.iter().enumerate() {
            let (value, _, _) = entry(&answers, cast, k);
            if problem.emitter.polygon().normal().dot(*at - turned(corners[0])) <= 0.0 && value != 0.0 {
                findings.push(format!("turned {turn} times, receiver {k} of batch {index} has {value}"));
            }
        }
        let counts = *first.get_or_insert(answers.counts);
        if counts != answers.counts {
            findings.push(format!("batch {index} turned {turn} times has {:?}, it had {counts:?}", answers.counts));
        }
    }
    Ok(findings)
}

/// One reflectance for all is that of each, in batches that fill vectors and in those that do not.
fn one_for_all() -> Result<Vec<String>, Error> {
    let square = [[-1.0, -1.0], [-1.0, 1.0], [1.0, 1.0], [1.0, -1.0]].map(|[x, y]| DVec3::new(x, y, 1.0));
    let polygon = Polygon::new(square.to_vec())?;
    let mut findings = Vec::new();
    for emission in [Emission::Constant(1.0), Emission::gradient(1.0, DVec3::X * 0.25)] {
        let emitter = Emitter::new(polygon.clone(), emission)?;
        for count in [1, 15, 16, 17, 100] {
            let (zero, up): (Vec<f64>, Vec<f64>) = (vec![0.0; count], vec![1.0; count]);
            let x: Vec<f64> = (0..count).map(|k| k as f64 * 0.01).collect();
            let answers = |rho: &[f64]| {
                let receivers = Receivers::new([&x, &zero, &zero], [&zero, &zero, &up], rho)?;
                let mut output = Answers::<f64>::new();
                Engine::new().evaluate_to(&receivers, &emitter, 1e-9, &mut output)?;
                Ok::<_, Error>(output)
            };
            if answers(&[0.75])? != answers(&vec![0.75; count])? {
                findings.push(format!("{count} receivers: one reflectance for all is not that of each"));
            }
        }
    }
    Ok(findings)
}

/// Contradictions of the first batches.
#[must_use]
pub fn all_wrong(count: u64) -> Vec<String> {
    let of = |index: u64| {
        let told = [
            of_precision(index, &DOUBLE, "doubles"),
            of_precision(index, &SINGLE, "singles"),
            across_an_axis(index, &DOUBLE),
            across_an_axis(index, &SINGLE),
            past_sails(index, &DOUBLE),
            past_sails(index, &SINGLE),
            at_the_foot(index, &DOUBLE),
            at_the_foot(index, &SINGLE),
        ];
        told.into_iter().flat_map(move |told| told.unwrap_or_else(|error| vec![format!("batch {index}: {error}")]))
    };
    let together = one_for_all().unwrap_or_else(|error| vec![format!("batches of one reflectance: {error}")]);
    (0..count).into_par_iter().flat_map_iter(of).chain(together).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn batches_are_the_same_in_other_units_and_orders_and_an_entry_of_another_receiver_is_another() {
        assert_eq!(all_wrong(16), Vec::<String>::new());
        let problem = case(54, 0).problem().unwrap();
        let places = receivers(&mut Sampler::new(54, "batches", 0), &problem, 13);
        let ready = ReadyEmitter::<f64>::new(problem.emitter.clone());
        let answers = asked(Engine::new(), (&problem, &ready), &places, &DOUBLE, 3).unwrap();
        assert!(
            (0..12).any(|k| format!("{:?}", entry(&answers, &DOUBLE, k)) != format!("{:?}", entry(&answers, &DOUBLE, k + 1)))
        );
    }
}
