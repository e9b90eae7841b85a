//! A search for the largest error over bound, of each rung, emission, sight and quantity: [`Search::climb`] changes the worst
//! cases found so far a little, keeps a change that is worse, and repeats.
//!
//! Drawn at random, most cases are far from their bounds, since a bound adds up errors that seldom come together. The neighbours
//! of a bad case are bad more often than others; so a search finds cases that no affordable number of independent draws does. Its
//! proposals depend on the seed and the findings of earlier rounds alone, not on threads.

use std::collections::BTreeMap;

use glam::DVec3;
use radgrad_scene::case::{Case, EmissionRecord, EmitterRecord, Id, ReceiverRecord};
use rayon::prelude::*;

use crate::bounds::witness::{Asked, Place, Query, Witness};
use crate::cases::family::Family;
use crate::cases::sampler::Sampler;

/// Worst cases kept of each place.
const KEPT: usize = 6;

/// Cases of a round.
const ROUND: usize = 256;

/// Ways to ask, the first one's bounds those of whichever rung comes first.
const ASKS: [Query; 16] = [
    Query::Answer(1.0),
    Query::Answer(1.0),
    Query::Answer(1e-9),
    Query::Answer(1e-12),
    Query::Answer(1e-15),
    Query::Answer(0.0),
    Query::Value(1.0),
    Query::Lanes(1.0),
    Query::Lanes(1.0),
    Query::SingleLanes(1.0),
    Query::Digits(30),
    Query::Answer(1e-13),
    Query::Answer(1.0),
    Query::Lanes(1.0),
    Query::Value(1.0),
    Query::SingleLanes(1e-3),
];

/// The worst cases of a place.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Worst {
    /// Bounds seen there.
    pub tried: u64,
    /// The worst, the worst first.
    pub worst: Vec<Witness>,
}

/// The worst found so far.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Search {
    /// By place.
    pub places: BTreeMap<Place, Worst>,
    /// Cases asked.
    pub asked: u64,
    /// Faults whatever the bounds: the first of each kind, with the query of the case.
    pub faults: Vec<(Query, Case, String)>,
}

impl Search {
    /// From cases that are known to be bad, asked again.
    #[must_use]
    pub fn from_witnesses(witnesses: &[Witness]) -> Self {
        let mut search = Self::default();
        let asked: Vec<Asked> = witnesses.par_iter().map(|witness| witness.ask.check(&witness.case)).collect();
        for (witness, asked) in witnesses.iter().zip(asked) {
            search.add(witness.ask, &witness.case, asked);
        }
        search
    }

    /// One more round. The seed, the round and the worst cases so far determine the cases it tries.
    pub fn climb(&mut self, seed: u64, round: u64) {
        let sampler = &mut Sampler::new(seed, "search", round);
        let candidates: Vec<(Query, Case)> = (0..ROUND).map(|_| self.candidate(sampler)).collect();
        let asked: Vec<Asked> = candidates.par_iter().map(|(ask, case)| ask.check(case)).collect();
        for ((ask, case), asked) in candidates.into_iter().zip(asked) {
            self.add(ask, &case, asked);
        }
    }

    /// The worst error over bound at any place.
    #[must_use]
    pub fn worst(&self) -> Option<&Witness> {
        let worst_of_places = self.places.values().filter_map(|worst| worst.worst.first());
        worst_of_places.max_by(|a, b| a.ratio.total_cmp(&b.ratio))
    }

    fn add(&mut self, ask: Query, case: &Case, asked: Asked) {
        self.asked += 1;
        for fault in asked.faults {
            let kind = |text: &str| text.split(':').next().map(str::to_owned);
            if self.faults.iter().all(|(_, _, other)| kind(other) != kind(&fault)) {
                self.faults.push((ask, case.clone(), fault));
            }
        }
        for held in asked.held {
            let Worst { tried, worst } = self.places.entry(held.place).or_default();
            *tried += 1;
            let place = worst.partition_point(|other| other.ratio >= held.ratio);
            if place < KEPT && held.ratio > 0.0 && worst.iter().all(|other| other.ratio != held.ratio) {
                let mut case = case.clone();
                case.id = Id::Text(held.place.to_string());
                worst.insert(place, Witness { place: held.place, ask, ratio: held.ratio, bound: held.bound, case });
                worst.truncate(KEPT);
            }
        }
    }

    /// A neighbour of a bad case, or a case drawn anew.
    fn candidate(&self, sampler: &mut Sampler) -> (Query, Case) {
        if self.places.is_empty() || sampler.one_in(4) {
            return (drawn_ask(sampler), drawn(sampler));
        }
        // Places take turns, whatever has been found there; where nothing but the rounding to doubles is left, seldom.
        let places = u32::try_from(self.places.len()).unwrap_or(u32::MAX);
        let mut place = sampler.below(places) as usize;
        for _ in 0..8 {
            if self.places.keys().nth(place).is_some_and(|place| place.by.has_bounds_above_rounding()) || sampler.one_in(12) {
                break;
            }
            place = sampler.below(places) as usize;
        }
        let Some(worst) = self.places.values().nth(place).filter(|worst| !worst.worst.is_empty()) else {
            return (drawn_ask(sampler), drawn(sampler));
        };
        let witness = &worst.worst[sampler.below(u32::try_from(worst.worst.len()).unwrap_or(1)) as usize];
        let mut case = witness.case.clone();
        for _ in 0..1 + sampler.below(2) {
            change(&mut case, sampler);
        }
        (if sampler.one_in(8) { drawn_ask(sampler) } else { witness.ask }, case)
    }
}

fn drawn_ask(sampler: &mut Sampler) -> Query {
    ASKS[sampler.below(16) as usize]
}

/// Families that are cheap to answer and not always 0.
const FAMILIES: [Family; 27] = [
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
    Family::ContactScale,
    Family::GrazingScale,
    Family::ScreenScale,
    Family::SteepExtension,
    Family::PolynomialFar,
    Family::PolynomialClipped,
    Family::OneScreen,
    Family::SilhouetteScreen,
    Family::EdgeScreen,
    Family::NearScreen,
];

/// A case of a family, or one that is awkward to decide.
pub(crate) fn drawn(sampler: &mut Sampler) -> Case {
    if sampler.one_in(4) {
        return awkward(sampler);
    }
    let family = FAMILIES[sampler.below(27) as usize];
    family.case(u64::from(sampler.below(u32::MAX)), u64::from(sampler.below(1000)))
}

/// A rotated quadrilateral or triangle, its coordinates rounded; the receiver at a rounded place of its plane or a few roundings
/// off it, or anywhere, facing so that the horizon passes a vertex by a few roundings.
pub(crate) fn awkward(sampler: &mut Sampler) -> Case {
    let centre = sampler.cube();
    let normal = sampler.direction();
    let along = sampler.perpendicular(normal);
    let across = normal.cross(along);
    let [a, b] = [0, 1].map(|_| sampler.between(0.3, 2.0));
    let corners = [(1.0, 1.0), (-1.0, 1.0), (-1.0, -1.0), (1.0, -1.0)];
    let mut vertices: Vec<DVec3> = corners.iter().map(|(u, v)| centre + along * (a * u) + across * (b * v)).collect();
    if sampler.one_in(2) {
        vertices.pop();
    }
    let (u, v) = (sampler.between(-1.5, 1.5), sampler.between(-1.5, 1.5));
    let in_plane = centre + along * (a * u) + across * (b * v);
    let height = match sampler.below(3) {
        0 => 0.0,
        1 => sampler.sign() * sampler.spread(-60, -40),
        _ => sampler.spread(-8, 2),
    };
    let position = in_plane + normal * height;
    let facing = if sampler.one_in(2) {
        let vertex = vertices[sampler.below(u32::try_from(vertices.len()).unwrap_or(3)) as usize] - position;
        sampler.perpendicular(vertex.normalize()) * sampler.between(0.5, 2.0)
    } else {
        sampler.direction() - normal
    };
    let facing = if facing.length() > 0.01 { facing } else { -normal };
    let emission = match sampler.below(3) {
        0 => EmissionRecord::Gradient { value: sampler.between(0.5, 2.0), gradient: (sampler.cube() * 0.1).to_array() },
        _ => EmissionRecord::Constant { constant: sampler.between(0.5, 2.0) },
    };
    Case {
        id: Id::Text("awkward".to_owned()),
        receiver: ReceiverRecord { position: position.to_array(), normal: facing.to_array(), reflectance: 1.0 },
        emitter: EmitterRecord { vertices: vertices.iter().map(DVec3::to_array).collect(), emission },
        occluders: Vec::new(),
        tolerance: 1e-12,
        precision: 0.0,
    }
}

/// An emitter edge on to the receiver, to a few roundings and less: the receiver in the emitter's plane, the emitter in the receiver's
/// horizon, or both. Two of three are triangles; the others quadrilaterals that are as far from flat as is allowed.
pub(crate) fn brink(sampler: &mut Sampler) -> Case {
    if sampler.one_in(5) {
        return in_a_lattice(sampler);
    }
    let (is_warped, is_aligned) = (sampler.one_in(3), sampler.one_in(3));
    let (centre, normal) = if is_aligned {
        (DVec3::new(sampler.between(-1.0, 1.0), sampler.between(-1.0, 1.0), 0.0), DVec3::Z)
    } else {
        (sampler.cube(), sampler.direction())
    };
    let along = if is_aligned { DVec3::X } else { sampler.perpendicular(normal) };
    let across = normal.cross(along);
    // Without rounding of other coordinates heights may be of any size.
    let powers = match (is_warped, is_aligned) {
        (true, _) => [-48, -39],
        (false, true) => [-150, -51],
        (false, false) => [-60, -51],
    };
    let offset = |sampler: &mut Sampler| {
        if sampler.one_in(3) { DVec3::ZERO } else { normal * (sampler.sign() * sampler.spread(powers[0], powers[1])) }
    };
    let corners: &[[f64; 2]] =
        if is_warped { &[[1.0, 1.0], [-1.0, 1.0], [-1.0, -1.0], [1.0, -1.0]] } else { &[[1.0, 0.0], [0.0, 1.0], [-1.0, -0.5]] };
    let vertices: Vec<DVec3> = corners.iter().map(|[u, v]| centre + along * *u + across * *v + offset(sampler)).collect();
    let reach = if sampler.one_in(2) { 0.9 } else { 3.0 };
    let beside = along * sampler.between(-reach, reach) + across * sampler.between(-reach, reach);
    let position = centre + beside + offset(sampler);
    let facing = match sampler.below(3) {
        0 => normal * (sampler.sign() * sampler.between(0.5, 2.0)),
        1 => sampler.direction(),
        _ => sampler.cube() * 0.5 - normal,
    };
    let facing = if facing.length() > 0.01 { facing } else { -normal };
    constant("brink", [position, facing], &vertices, sampler.between(0.5, 2.0))
}

/// A receiver exactly in the plane of a triangle that no axis is normal to: whole numbers.
fn in_a_lattice(sampler: &mut Sampler) -> Case {
    let whole = |sampler: &mut Sampler, most: i64| sampler.integer(-most, most) as f64;
    let point = |sampler: &mut Sampler| DVec3::from_array([0; 3].map(|_| whole(sampler, 40)));
    let (origin, along) = (point(sampler), point(sampler) + DVec3::X * 100.0);
    let across = point(sampler) + DVec3::Y * 100.0;
    let position = origin + along * whole(sampler, 3) + across * whole(sampler, 3) + (along + across) * 5.0;
    constant("brink", [position, point(sampler) + DVec3::Z * 0.5], &[origin, origin + along, origin + across], 1.0)
}

/// A case of constant emission, from the receiver's position and direction.
pub(crate) fn constant(id: &str, [position, facing]: [DVec3; 2], vertices: &[DVec3], constant: f64) -> Case {
    Case {
        id: Id::Text(id.to_owned()),
        receiver: ReceiverRecord { position: position.to_array(), normal: facing.to_array(), reflectance: 1.0 },
        emitter: EmitterRecord {
            vertices: vertices.iter().map(DVec3::to_array).collect(),
            emission: EmissionRecord::Constant { constant },
        },
        occluders: Vec::new(),
        tolerance: 1e-12,
        precision: 0.0,
    }
}

/// Changes a case a little, or not so little.
pub(crate) fn change(case: &mut Case, sampler: &mut Sampler) {
    let largest = numbers_of_points(case).into_iter().fold(0.0, |m: f64, x| m.max(x.abs()));
    match sampler.below(8) {
        // The receiver along a line through it and a point of the emitter.
        0 => {
            let corner = DVec3::from_array(case.emitter.vertices[sampler.below(2) as usize]);
            let other = DVec3::from_array(case.emitter.vertices[2]);
            let toward = corner + (other - corner) * sampler.uniform();
            let x = DVec3::from_array(case.receiver.position);
            let step = sampler.sign() * sampler.spread(-30, 0);
            case.receiver.position = (x + (toward - x) * step).to_array();
        }
        // Its normal, anywhere or nearby.
        1 => {
            let n = DVec3::from_array(case.receiver.normal);
            let scale = if sampler.one_in(4) { 1.0 } else { sampler.spread(-40, -1) };
            case.receiver.normal = (n + sampler.direction() * (n.length() * scale)).to_array();
        }
        // The emission.
        2 => change_emission(&mut case.emitter.emission, sampler),
        // A vertex of a triangle, in any direction.
        3 | 4 if case.emitter.vertices.len() == 3 => {
            let place = sampler.below(3) as usize;
            let v = DVec3::from_array(case.emitter.vertices[place]);
            let step = sampler.direction() * (largest * sampler.spread(-52, -1));
            case.emitter.vertices[place] = (v + step).to_array();
        }
        // The receiver in any direction.
        5 | 6 => {
            let x = DVec3::from_array(case.receiver.position);
            let step = sampler.direction() * (largest * sampler.spread(-52, -1));
            case.receiver.position = (x + step).to_array();
        }
        // Some numbers by some roundings.
        _ => {
            let is_triangle = case.emitter.vertices.len() == 3 && case.occluders.is_empty();
            let receiver = &mut case.receiver;
            for x in receiver.position.iter_mut().chain(&mut receiver.normal) {
                *x *= 1.0 + f64::from(sampler.below(9)) * f64::EPSILON - 4.0 * f64::EPSILON;
            }
            if is_triangle {
                for x in case.emitter.vertices.iter_mut().flatten() {
                    *x *= 1.0 + f64::from(sampler.below(5)) * f64::EPSILON - 2.0 * f64::EPSILON;
                }
            }
        }
    }
}

fn change_emission(emission: &mut EmissionRecord, sampler: &mut Sampler) {
    let scale = sampler.spread(-30, 4);
    let shift = sampler.between(-1.0, 1.0);
    match emission {
        EmissionRecord::Constant { constant } => *constant *= 1.0 + 0.5 * shift,
        EmissionRecord::Vertices { vertices } => {
            let place = sampler.below(u32::try_from(vertices.len()).unwrap_or(1)) as usize;
            vertices[place] += scale * shift;
        }
        EmissionRecord::Gradient { value, gradient } => {
            *value += scale * shift;
            let factor = 1.0 + scale * sampler.between(-1.0, 1.0);
            *gradient = gradient.map(|c| c * factor);
        }
        EmissionRecord::Polynomial { polynomial } => {
            let count = u32::try_from(polynomial.terms.len()).unwrap_or(1);
            if count > 0 {
                polynomial.terms[sampler.below(count) as usize].coefficient *= 1.0 + scale * shift;
            }
        }
        EmissionRecord::Expression { .. } => {}
    }
}

fn numbers_of_points(case: &Case) -> Vec<f64> {
    case.receiver.position.iter().chain(case.emitter.vertices.iter().flatten()).copied().collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_search_is_the_same_again_and_climbs() {
        let climbed = |rounds: u64| {
            let mut search = Search::default();
            (0..rounds).for_each(|round| search.climb(1, round));
            search
        };
        let (short, long) = (climbed(1), climbed(3));
        assert_eq!(climbed(1), short);
        assert_eq!(long.faults, []);
        for (place, worst) in &short.places {
            let largest_ratio = |worst: &Worst| worst.worst.first().map_or(0.0, |witness| witness.ratio);
            assert!(
                largest_ratio(&long.places[place]) >= largest_ratio(worst) && largest_ratio(&long.places[place]) <= 1.0,
                "{place}"
            );
        }
        assert_eq!(
            Search::from_witnesses(&long.places.values().flat_map(|w| w.worst.clone()).collect::<Vec<_>>()).worst(),
            long.worst()
        );
    }
}
