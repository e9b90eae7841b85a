//! A search for what tells that a fault is planted, in the build of `cargo xtask mutants` alone: [`hunt`] asks the same cases with the
//! fault and without, and climbs towards where the two differ most, by a bound that is smaller or by values that contradict.

use glam::DVec3;
use radgrad_core::mutant::plant;
use radgrad_oracle::Arithmetic;
use radgrad_scene::case::{Case, EmissionRecord};
use rayon::prelude::*;

use crate::family::Family;
use crate::measure::worse;
use crate::record::{Of, Record, Said};
use crate::sampler::Sampler;
use crate::search::{change, constant, drawn};
use crate::witness::Ask;

/// Cases of a round.
const ROUND: usize = 128;

/// The best that are kept.
const KEPT: usize = 12;

/// Ways to ask a case of core that take next to no time.
const CHEAP: [Of; 8] = [
    Of::Answer(Ask::Answer(1.0)),
    Of::Answer(Ask::Answer(1.0)),
    Of::Answer(Ask::Answer(1e-9)),
    Of::Answer(Ask::Answer(1e-12)),
    Of::Answer(Ask::Answer(1e-13)),
    Of::Answer(Ask::Value(1.0)),
    Of::Answer(Ask::Lanes(1.0)),
    Of::Answer(Ask::SingleLanes(1.0)),
];

/// Dearer ones.
const DEAR: [Of; 8] = [
    Of::Answer(Ask::Answer(1e-15)),
    Of::Answer(Ask::Answer(0.0)),
    Of::Answer(Ask::Digits(30)),
    Of::Hessian(1.0),
    Of::Hessian(1e-10),
    Of::Irradiance(1.0),
    Of::Irradiance(1e-12),
    Of::Answer(Ask::Digits(60)),
];

/// Of the oracle.
const ORACLE: [Of; 4] = [
    Of::Oracle(Arithmetic::DoubleDouble, 20),
    Of::Oracle(Arithmetic::DoubleDouble, 15),
    Of::Oracle(Arithmetic::Limbs, 20),
    Of::Oracle(Arithmetic::Astro, 20),
];

/// What tells of a fault, the best first: how much a bound is larger without it, or above a million where values contradict.
pub type Found = Vec<(f64, Of, Case)>;

/// Climbs for so many rounds from some cases, and from others that are drawn.
#[must_use]
pub fn hunt(id: &str, rounds: u64, start: &[(Of, Case)]) -> Found {
    let (is_oracle, mut found) = (id.starts_with("oracle."), Found::new());
    for round in 0..rounds {
        let sampler = &mut Sampler::new(5, id, round);
        let mut candidates: Vec<(Of, Case)> = (0..ROUND).map(|_| candidate(sampler, &found, start, is_oracle)).collect();
        if round == 0 && !is_oracle {
            candidates.extend_from_slice(start);
        }
        let asked = |candidates: &[(Of, Case)]| -> Vec<Result<Said, String>> {
            candidates.par_iter().map(|(of, case)| of.asked(Some(case))).collect()
        };
        plant("");
        let without = asked(&candidates);
        plant(id);
        let with = asked(&candidates);
        plant("");
        for (((of, case), without), with) in candidates.into_iter().zip(without).zip(with) {
            let gain = gain(&without, &with);
            let place = found.partition_point(|other| other.0 >= gain);
            if gain > 1.0 + 4e-6 && place < KEPT {
                found.insert(place, (gain, of, case));
                found.truncate(KEPT);
            }
        }
        if found.len() == KEPT && found[1].0 > 1e6 {
            break;
        }
    }
    // What cannot be recorded is no witness.
    found.retain(|(_, of, case)| Record::new(*of, Some(case.clone())).is_ok());
    found
}

fn candidate(sampler: &mut Sampler, found: &Found, start: &[(Of, Case)], is_oracle: bool) -> (Of, Case) {
    let drawn_of = |sampler: &mut Sampler| match sampler.below(8) {
        of if is_oracle => ORACLE[of as usize % 4],
        0 => DEAR[sampler.below(8) as usize],
        of => CHEAP[of as usize],
    };
    let pick = |sampler: &mut Sampler, count: usize| sampler.below(u32::try_from(count).unwrap_or(1)) as usize;
    match sampler.below(8) {
        0..=3 if !found.is_empty() => {
            let (_, of, case) = &found[pick(sampler, found.len())];
            let mut case = case.clone();
            for _ in 0..1 + sampler.below(2) {
                change(&mut case, sampler);
            }
            if sampler.one_in(16) {
                darken(&mut case, sampler);
            }
            (if sampler.one_in(8) { drawn_of(sampler) } else { *of }, case)
        }
        4 | 5 if !start.is_empty() && !is_oracle => {
            let (of, case) = &start[pick(sampler, start.len())];
            let mut case = case.clone();
            change(&mut case, sampler);
            if sampler.one_in(16) {
                darken(&mut case, sampler);
            }
            (if sampler.one_in(2) { drawn_of(sampler) } else { *of }, case)
        }
        6 if is_oracle => {
            let family = [Family::Far, Family::FarNeedle, Family::Generic, Family::Clipped][sampler.below(4) as usize];
            (drawn_of(sampler), family.case(77, u64::from(sampler.below(1000))))
        }
        7 if !is_oracle => (drawn_of(sampler), if sampler.one_in(2) { beside_an_edge(sampler) } else { aligned(sampler) }),
        _ => (drawn_of(sampler), drawn(sampler)),
    }
}

/// A rectangle in a frame of its own: a corner, its sides and its normal.
fn rectangle(sampler: &mut Sampler) -> ([DVec3; 4], DVec3) {
    let (corner, normal) = (sampler.cube(), sampler.direction());
    let along = sampler.perpendicular(normal);
    let (u, v) = (along * sampler.between(0.3, 2.0), normal.cross(along) * sampler.between(0.3, 2.0));
    ([corner, corner + u, corner + u + v, corner + v], normal)
}

/// A receiver over an edge of a rectangle, or as near as can be, facing anywhere: a crossing of the horizon next to it, or the edge
/// over its foot.
fn beside_an_edge(sampler: &mut Sampler) -> Case {
    let (corners, normal) = rectangle(sampler);
    let foot = corners[0] + (corners[1] - corners[0]) * sampler.between(-0.2, 1.2);
    let height = sampler.spread(-36, 1);
    let aside = if sampler.one_in(2) { DVec3::ZERO } else { sampler.direction() * height };
    let facing = if sampler.one_in(2) { sampler.direction() } else { sampler.cube() * 0.5 - normal };
    let count = if sampler.one_in(2) { 3 } else { 4 };
    let mut case = constant("edge", [foot + normal * height + aside, facing], &corners[..count], 1.0);
    if sampler.one_in(2) {
        let gradient = sampler.cube().to_array();
        case.emitter.emission = EmissionRecord::Gradient { value: sampler.between(0.5, 4.0), gradient };
    }
    case
}

/// A screen with a vertex, or an edge, that is seen on one of the emitter's to a rounding.
fn aligned(sampler: &mut Sampler) -> Case {
    let (corners, normal) = rectangle(sampler);
    let middle = (corners[0] + corners[2]) * 0.5;
    let position = middle + normal * sampler.between(0.5, 3.0) + sampler.cube() * 0.5;
    let facing = middle - position;
    let mut case = constant("aligned", [position, facing], &corners, 1.0);
    let on_edge = |sampler: &mut Sampler| {
        let first = sampler.below(4) as usize;
        let place = if sampler.one_in(2) { 0.0 } else { sampler.uniform() };
        corners[first] + (corners[(first + 1) % 4] - corners[first]) * place
    };
    let share = sampler.between(0.2, 0.8);
    let screen = [0; 3].map(|_| {
        let target = if sampler.one_in(3) { middle + sampler.cube() } else { on_edge(sampler) };
        (position + (target - position) * share).to_array()
    });
    case.occluders = vec![screen.to_vec()];
    case
}

/// To next to nothing, so that results are below the normal range.
fn darken(case: &mut Case, sampler: &mut Sampler) {
    if let EmissionRecord::Constant { constant } = &mut case.emitter.emission {
        *constant *= sampler.spread(-1022, -980);
    }
}

/// How much better it is without the fault.
fn gain(without: &Result<Said, String>, with: &Result<Said, String>) -> f64 {
    const OTHER: f64 = 1e6;
    match (without, with) {
        (Ok(without), Ok(with)) => {
            if !without.wrong.is_empty() {
                return 0.0;
            }
            if !with.wrong.is_empty() {
                return 2.0 * OTHER;
            }
            if without.statements.len() != with.statements.len() {
                return OTHER;
            }
            let pairs = without.statements.iter().zip(&with.statements);
            let of = |(a, b): (&crate::record::Statement, &crate::record::Statement)| {
                let apart = a.apart(b);
                if apart > 1.0 || apart.is_nan() {
                    OTHER * (2.0 + apart.min(1e6))
                } else if b.bound < a.bound && a.bound.is_finite() {
                    (a.bound / b.bound).min(OTHER)
                } else if a.has_moved(b) {
                    1.0 + 1e-5 + apart
                } else {
                    1.0
                }
            };
            pairs.map(of).fold(1.0, worse)
        }
        (Ok(_), Err(_)) => 3.0 * OTHER,
        _ => 0.0,
    }
}
