//! The error of gathers beside an edge where two faces meet.
//!
//! There each face fills the same part of the other's view, however close the edge is, and the radiosity rises to it as a power
//! of the distance does: no polynomial follows. But the views of faces of each other are the same all along the edge, but for its
//! ends.
//!
//! | symbol | meaning |
//! |---|---|
//! | `a`, `b` | the two faces, at an angle `alpha` |
//! | `s`, `t` | distances from the edge on a and on b, from 0 to `Y` |
//! | `C` | the radiosity by a corrected gather, `E + rho H` |
//! | `q` | the radiosity as that gather takes it: polynomial, detail and known error ([`crate::solve::second_gather`]) |
//! | `eps` | `B - C` |
//! | `K` | the gather at a place from strips along the edge, `K f(s) = int_0^Y f(t) dF(s, t)` |
//!
//! The gather of a at s lacks the error of b, `rho K (B - q)` with `B - q = (C - q) + eps`. So on both faces
//!
//! ```text
//! eps_a = rho_a K (C_b - q_b + eps_b),   F(s, t) = (1 - (s - t cos alpha)/|s - t e^(i alpha)|)/2
//! ```
//!
//! with F the form factor from s to the endless strip from 0 to t (crossed strings: H. Hottel 1954); of a strip that ends, at `x`
//! times its distance, either half gives `(x/(1 + x^2) + atan x)/pi` of that. `C - q` is sampled at distances that are graded
//! towards the edge, where `K` has the limit `(1 + cos alpha)/2` times the value: at the edge itself `C + eps` is therefore the
//! exact solution of both equations. The gradient across the edge lacks the slope of the same sum. `eps` is an estimate: nothing
//! is the same up to the ends, and the errors of the faces beyond Y are left out.

use std::f64::consts::PI;

use radgrad_core::{DVec3, Polygon};
use radgrad_scene::{largest, smallest};

use crate::error::Error;
use crate::mesh::basis::dot;
use crate::mesh::{Sight, TOUCHES};
use crate::solve::next_degree::Detail;
use crate::solve::solution::Solution;

/// A distance is Y times the third power of u. Functions are polynomials in u of this degree, and are gathered by so many strips.
const DEGREE: usize = 8;
const STRIPS: usize = 96;

/// Up to which part of Y points are corrected, and of the distance from the next edge.
const BESIDE: f64 = 0.5;

/// Up to how many times Y from the edge samples of the other face's error take eps.
const NEAR_EDGE: f64 = 4.0;

/// Y, over the distance to where a leaf ends: there it may meet yet another face, of which a place on the border sees nothing.
const WITHIN: f64 = 0.999;

/// From where to where it is asked whether anything is between, over Y.
const PLACES: [f64; 2] = [0.1, 1.0];

/// A place on the edge is taken to be so far from it, over the farthest distance.
const AT_EDGE: f64 = 1e-7;

/// The estimate of the correction's error is a part of its differences from two others: one of half the degree, and one with `q` averaged along
/// the edge, over so much of the distance from it to either side.
const OF_DEGREE: f64 = 0.25;
const OF_SAMENESS: f64 = 0.5;
const ASIDE: f64 = 0.5;

/// Faces that meet at a smaller sine are level; and a direction at a smaller one to a side goes along it.
const LEVEL: f64 = 1e-3;
const ALONG: f64 = 1e-9;

/// The step to either side for a slope, over the distance.
const STEP: f64 = 1e-3;

/// Sweeps, each of which makes the error smaller by the reflectance at least, and the change at which they end.
const MOST_SWEEPS: usize = 200;
const SOLVED: f64 = 1e-9;

/// Two leaves that meet in an edge, at the foot of a point on the first.
#[derive(Debug)]
struct Wedge {
    foot: DVec3,
    /// The direction of the edge.
    along: DVec3,
    /// For each, its face and the direction away from the edge.
    sides: [(usize, DVec3); 2],
    leaves: [usize; 2],
    /// How far it is to the ends of the edge.
    ends: [f64; 2],
    /// The distance of the point, and the farthest that counts.
    distance: f64,
    farthest: f64,
}

/// At a place, in each channel, the reflectance, and the radiosity of a corrected gather less the radiosity that gathers take for
/// it.
#[derive(Debug)]
struct Sample {
    rho: Vec<f64>,
    defect: Vec<f64>,
    /// The same with the mean of `q` on either side in place of `q`.
    defect_around: Vec<f64>,
}

/// A section across an edge: its samples, and in each channel `C - q + eps` of the other face at their places, by all of them, by every second
/// one, and with the mean of `q` on either side.
#[derive(Debug)]
pub(crate) struct Section {
    wedge: Wedge,
    samples: [Vec<Sample>; 2],
    errors: [Vec<Vec<f64>>; 3],
}

impl Section {
    /// The light that a gather lacks of the other face, with an estimate of its error, by the weights of samples of a degree.
    fn lacking(&self, weights: impl Fn(usize) -> Vec<f64>) -> Vec<[f64; 2]> {
        let [all, half] = [DEGREE, DEGREE / 2].map(weights);
        let [fine, rough, around] = &self.errors;
        let of_channel = |channel: usize| {
            let variants = [(&all, fine), (&half, rough), (&all, around)];
            let [lacking, rough, around] = variants.map(|(weights, errors)| dot(weights, &errors[channel]));
            let [of_degree, along_edge] = [rough, around].map(|other| (lacking - other).abs());
            [lacking, OF_DEGREE * of_degree + OF_SAMENESS * along_edge]
        };
        (0..fine.len()).map(of_channel).collect()
    }

    /// That of a point so far from the edge.
    pub(crate) fn lacking_at(&self, distance: f64) -> Vec<[f64; 2]> {
        self.lacking(|degree| self.wedge.view_weights(distance, degree))
    }
}

/// A point beside an edge in which its leaf meets another, between two places of the edge that all points of the two leaves share.
#[derive(Debug)]
pub(crate) struct BesideEdge {
    pub(crate) leaves: [usize; 2],
    pub(crate) distance: f64,
    pub(crate) other: usize,
    /// The places, and the weight of the second; that of the first is the remainder of 1.
    pub(crate) places: [DVec3; 2],
    pub(crate) weight: f64,
}

/// The light of the other face that a gather near an edge lacks: in each channel, with an estimate of its error; and how much
/// more it is a unit of length farther from the edge, likewise.
#[derive(Debug)]
pub(super) struct Lacking {
    /// Whether the point is so near the edge that the answer takes the correction.
    pub(super) is_beside: bool,
    pub(super) irradiance: Vec<[f64; 2]>,
    pub(super) away: DVec3,
    pub(super) slope: Vec<[f64; 2]>,
    pub(super) other: OtherFace,
}

/// The other face of an edge, and the term of its error where that is sampled near the point.
#[derive(Debug)]
pub(super) struct OtherFace {
    pub(super) face: usize,
    foot: DVec3,
    away: DVec3,
    farthest: f64,
    /// In each channel, at the samples: eps; or if the point is beside the edge, so that its gradient has `C - q + eps` from the slope already,
    /// `q - C`.
    more: Vec<Vec<f64>>,
}

impl OtherFace {
    /// How far a point of the own face is from the edge.
    pub(super) fn distance_of(&self, point: DVec3) -> f64 {
        (point - self.foot).length()
    }

    /// The term of `C - q` of a place, in each channel; `None` from Y on.
    pub(super) fn more_at(&self, place: DVec3) -> Option<Vec<f64>> {
        let distance = self.away.dot(place - self.foot);
        if distance >= self.farthest {
            return None;
        }
        let weights = interpolation(&samples(DEGREE), largest(distance / self.farthest, AT_EDGE).cbrt());
        Some(self.more.iter().map(|of| dot(of, &weights)).collect())
    }
}

impl Wedge {
    fn cosine(&self) -> f64 {
        self.sides[0].1.dot(self.sides[1].1)
    }

    /// The part of an endless strip's light, so far away, that comes from between the ends of the edge.
    fn part(&self, away: f64) -> f64 {
        let to_end = |end: f64| {
            let x = end / away;
            (x / (1.0 + x * x) + x.atan()) / PI
        };
        self.ends.map(to_end).iter().sum()
    }

    /// Weights of the samples in the gather at a place at a distance from the edge.
    fn view_weights(&self, distance: f64, degree: usize) -> Vec<f64> {
        let (samples, cosine) = (samples(degree), self.cosine());
        if distance <= AT_EDGE * self.farthest {
            let at_edge = |k: usize| if k == 0 { 0.5 * (1.0 + cosine) } else { 0.0 };
            return (0..samples.len()).map(at_edge).collect();
        }
        let away = |t: f64| (t * t + distance * (distance - 2.0 * t * cosine)).sqrt();
        let up_to = |t: f64| 0.5 * (t * cosine - distance) / away(t);
        let mut weights = vec![0.0; samples.len()];
        let mut below = up_to(0.0);
        for strip in 1..=STRIPS {
            let end = strip as f64 / STRIPS as f64;
            let above = up_to(self.farthest * end.powi(3));
            let middle = end - 0.5 / STRIPS as f64;
            let factor = (above - below) * self.part(away(self.farthest * middle.powi(3)));
            weights.iter_mut().zip(interpolation(&samples, middle)).for_each(|(weight, of)| *weight += factor * of);
            below = above;
        }
        weights
    }

    /// By how much more the point sees of that a unit of length farther from the edge; 0 on it, where that has no limit.
    fn slope_of_seen(&self, degree: usize) -> Vec<f64> {
        let step = STEP * self.distance;
        if self.distance <= AT_EDGE * self.farthest {
            return vec![0.0; degree + 1];
        }
        let [behind, ahead] = [-step, step].map(|step| self.view_weights(self.distance + step, degree));
        ahead.iter().zip(behind).map(|(ahead, behind)| (ahead - behind) / (2.0 * step)).collect()
    }
}

/// The u of samples: the extrema of Chebyshev's polynomial between 0 and 1. Every second one is a sample of half the degree.
fn samples(degree: usize) -> Vec<f64> {
    (0..=degree).map(|k| 0.5 * (1.0 - (PI * k as f64 / degree as f64).cos())).collect()
}

/// Weights of the values at samples in the polynomial through them (J.-P. Berrut and L. N. Trefethen 2004).
fn interpolation(samples: &[f64], u: f64) -> Vec<f64> {
    if samples.contains(&u) {
        return samples.iter().map(|sample| f64::from(*sample == u)).collect();
    }
    let term = |(k, sample): (usize, &f64)| {
        let end = if k == 0 || k + 1 == samples.len() { 0.5 } else { 1.0 };
        end * if k % 2 == 0 { 1.0 } else { -1.0 } / (u - sample)
    };
    let terms: Vec<f64> = samples.iter().enumerate().map(term).collect();
    let sum: f64 = terms.iter().sum();
    terms.into_iter().map(|term| term / sum).collect()
}

impl Solution {
    /// The irradiance that the corrected gather of a point lacks, if it is beside an edge where its leaf meets another face.
    pub(super) fn lacking_beside_edge(&self, leaf: usize, point: DVec3) -> Result<Option<Lacking>, Error> {
        match self.wedges_at(leaf, point, BESIDE).next() {
            Some((wedge, true)) => self.lacking_of(wedge, true),
            _ => Ok(None),
        }
    }

    /// That of all edges that are near, whether the point is beside them or not.
    pub(super) fn lacking_near_edges(&self, leaf: usize, point: DVec3) -> Result<Vec<Lacking>, Error> {
        let wedges = self.wedges_at(leaf, point, NEAR_EDGE);
        wedges.filter_map(|(wedge, is_beside)| self.lacking_of(wedge, is_beside).transpose()).collect()
    }

    fn lacking_of(&self, wedge: Wedge, is_beside: bool) -> Result<Option<Lacking>, Error> {
        let Some(section) = self.section(wedge)? else { return Ok(None) };
        let Section { wedge, samples: [_, there], errors: [fine, ..] } = &section;
        let more = |(channel, full): (usize, &Vec<f64>)| {
            let sampled = there.iter().map(|sample| sample.defect[channel]);
            full.iter().zip(sampled).map(|(full, sampled)| if is_beside { -sampled } else { full - sampled }).collect()
        };
        let [(_, away), (face, other_away)] = wedge.sides;
        Ok(Some(Lacking {
            is_beside,
            irradiance: section.lacking_at(wedge.distance),
            away,
            slope: section.lacking(|degree| wedge.slope_of_seen(degree)),
            other: OtherFace {
                face,
                foot: wedge.foot,
                away: other_away,
                farthest: wedge.farthest,
                more: fine.iter().enumerate().map(more).collect(),
            },
        }))
    }

    /// The section at the foot of a wedge.
    fn section(&self, wedge: Wedge) -> Result<Option<Section>, Error> {
        let distances: Vec<f64> = samples(DEGREE).iter().map(|u| wedge.farthest * u.powi(3)).collect();
        let Some(samples) = self.samples_of(&wedge, &distances)? else { return Ok(None) };
        let rows = |step: usize| -> Vec<Vec<f64>> {
            distances.iter().step_by(step).map(|distance| wedge.view_weights(*distance, DEGREE / step)).collect()
        };
        let [all, half] = [1, 2].map(rows);
        let error_there = |(step, rows): (usize, &[Vec<f64>]), of: fn(&Sample) -> &[f64]| -> Option<Vec<Vec<f64>>> {
            let of_channel = |channel: usize| {
                let in_samples = |of: fn(&Sample) -> &[f64]| {
                    [0, 1].map(|side| samples[side].iter().step_by(step).map(|sample| of(sample)[channel]).collect())
                };
                solve_errors(&in_samples(|sample| &sample.rho), &in_samples(of), rows).map(|[_, there]| there)
            };
            (0..self.channels().len()).map(of_channel).collect()
        };
        let errors = [
            error_there((1, &all), |sample| &sample.defect),
            error_there((2, &half), |sample| &sample.defect),
            error_there((1, &all), |sample| &sample.defect_around),
        ];
        let [Some(fine), Some(rough), Some(around)] = errors else { return Ok(None) };
        Ok(Some(Section { wedge, samples, errors: [fine, rough, around] }))
    }

    /// The edge that a point of a leaf is beside, and the places that points of these leaves share: those of Gauss's rule of two points.
    pub(crate) fn beside_edge(&self, leaf: usize, point: DVec3) -> Option<BesideEdge> {
        let (wedge, true) = self.wedges_at(leaf, point, BESIDE).next()? else { return None };
        let touch = TOUCHES * self.system.extent;
        let corners = |leaf: usize| {
            let vertices = self.element(leaf).polygon().vertices().iter().copied();
            vertices.filter(|v| (*v - wedge.foot).cross(wedge.along).length() <= touch)
        };
        let ends = wedge.leaves.map(|leaf| {
            let at = corners(leaf).map(|v| wedge.along.dot(v));
            at.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], at| [smallest(low, at), largest(high, at)])
        });
        let [low, high] = [largest(ends[0][0], ends[1][0]), smallest(ends[0][1], ends[1][1])];
        let first = corners(wedge.leaves[0]).next().filter(|_| high > low)?;
        let at = |part: f64| low + part * (high - low);
        let parts = [-1.0, 1.0].map(|side| 0.5 + side * 0.5 / 3.0_f64.sqrt());
        let place = |part: f64| first + wedge.along * (at(part) - wedge.along.dot(first));
        let part = ((wedge.along.dot(wedge.foot) - low) / (high - low)).clamp(0.0, 1.0);
        Some(BesideEdge {
            leaves: wedge.leaves,
            distance: wedge.distance,
            other: wedge.sides[1].0,
            places: parts.map(place),
            weight: (part - parts[0]) / (parts[1] - parts[0]),
        })
    }

    /// The sections at the places that points beside an edge share; `None` where nothing is known there.
    pub(crate) fn shared_sections(&self, beside: &BesideEdge) -> Result<Option<[Section; 2]>, Error> {
        let section = |place: DVec3| {
            let wedge = self.wedge_of(self.element(beside.leaves[0]).face(), place, beside.other);
            wedge.map_or(Ok(None), |wedge| self.section(wedge))
        };
        let [first, second] = beside.places.map(section);
        Ok(first?.zip(second?).map(|(first, second)| [first, second]))
    }

    /// The samples of a wedge, for each side and distance.
    fn samples_of(&self, wedge: &Wedge, distances: &[f64]) -> Result<Option<[Vec<Sample>; 2]>, Error> {
        let mut samples: [Vec<Sample>; 2] = Default::default();
        for (of_side, (face, away)) in samples.iter_mut().zip(wedge.sides) {
            for distance in distances {
                let offset = if *distance > 0.0 { *distance } else { AT_EDGE * wedge.farthest };
                let aside = [AT_EDGE * wedge.farthest, ASIDE * offset].map(|aside| wedge.along * aside);
                let Some(sample) = self.beyond_what_is_taken(face, wedge.foot + away * offset, aside)? else { return Ok(None) };
                of_side.push(sample);
            }
        }
        Ok(Some(samples))
    }

    /// The edges in which the face that a point is on meets others, the nearest first, if the point is `within` so many times Y and nothing is
    /// between the faces; and whether it is beside the edge, and no other is as near.
    fn wedges_at(&self, leaf: usize, point: DVec3, within: f64) -> impl Iterator<Item = (Wedge, bool)> {
        let own = self.element(leaf).face();
        let links = &self.system.links[self.receiver_of(leaf)];
        let mut faces: Vec<usize> = Vec::new();
        for link in links.iter().filter(|link| !matches!(link.sight, Sight::Nothing(_))) {
            let source = self.element(link.source);
            // Y is within a leaf of the source.
            let is_near = (source.centre() - point).length() <= (1.0 + 2.0 * largest(within, 1.0)) * source.radius();
            if is_near && !faces.contains(&source.face()) {
                faces.push(source.face());
            }
        }
        let mut wedges: Vec<Wedge> = faces.into_iter().filter_map(|face| self.wedge_of(own, point, face)).collect();
        wedges.sort_by(|a, b| a.distance.total_cmp(&b.distance));
        let next = wedges.get(1).map_or(f64::INFINITY, |next| next.distance);
        let is_beside = |(k, wedge): (usize, &Wedge)| k == 0 && wedge.distance <= BESIDE * smallest(wedge.farthest, next);
        let are_beside: Vec<bool> = wedges.iter().enumerate().map(is_beside).collect();
        let candidates = wedges.into_iter().zip(are_beside);
        candidates.filter(move |(wedge, _)| wedge.distance <= within * wedge.farthest && self.is_free(wedge))
    }

    /// The edge in which a leaf meets a face, at the foot of a point of the leaf, as far as both go on from there.
    fn wedge_of(&self, own: usize, point: DVec3, face: usize) -> Option<Wedge> {
        let [here, there] = [own, face].map(|face| &self.system.mesh.polygons()[face]);
        let along = here.normal().cross(there.normal());
        let sine = along.length();
        if sine < LEVEL {
            return None;
        }
        let along = along / sine;
        let away_on = |on: DVec3, other: DVec3| (other - on * on.dot(other)) / sine;
        let sides = [away_on(here.normal(), there.normal()), away_on(there.normal(), here.normal())];
        let distance = there.normal().dot(point - there.vertices()[0]) / sine;
        let foot = point - sides[0] * distance;
        let touch = TOUCHES * self.system.extent;
        if distance < -touch {
            return None;
        }
        let leaf_at = |face: usize, away: DVec3| {
            self.system.mesh.leaf_at(face, foot + away * touch).filter(|&leaf| self.element(leaf).is_at(foot, touch))
        };
        let (leaf, other) = (leaf_at(own, sides[0])?, leaf_at(face, sides[1])?);
        let on_leaf = |leaf: usize, way: DVec3| way_on(self.element(leaf).polygon(), foot, way);
        let away = WITHIN * smallest(on_leaf(leaf, sides[0]), on_leaf(other, sides[1]));
        let ends = [along, -along].map(|way| smallest(way_on(here, foot, way), way_on(there, foot, way)));
        let sides = [(own, sides[0]), (face, sides[1])];
        let distance = if distance > 0.0 { distance } else { 0.0 };
        Some(Wedge { foot, along, sides, leaves: [leaf, other], ends, distance, farthest: away })
    }

    /// Whether nothing is between the two sides, as some places of them see it.
    fn is_free(&self, wedge: &Wedge) -> bool {
        let [here, there] = wedge.sides;
        let place = |away: DVec3, part: f64| wedge.foot + away * (part * wedge.farthest);
        let aside = wedge.along * smallest(wedge.farthest, smallest(wedge.ends[0], wedge.ends[1]));
        let is_free = |from: f64, to: f64, part: f64| {
            let ends = [place(here.1, from), place(there.1, to) + aside * part];
            !self.system.mesh.is_between(ends, [here.0, there.0])
        };
        PLACES.iter().all(|&from| PLACES.iter().all(|&to| [-1.0, 0.0, 1.0].iter().all(|&part| is_free(from, to, part))))
    }

    /// The sample at a place of a face; `None` if nothing is known there. Between two leaves, which a little `aside` tells, gathers see as much
    /// of the one as of the other.
    fn beyond_what_is_taken(&self, face: usize, place: DVec3, [little, aside]: [DVec3; 2]) -> Result<Option<Sample>, Error> {
        let Some(leaf) = self.system.mesh.leaf_at(face, place) else { return Ok(None) };
        let [rho, radiosity] = self.corrected_at(leaf, place)?;
        let defect = |aside: DVec3| {
            let taken = [place + aside, place - aside].map(|place| self.taken_at(face, place));
            let [Some(here), Some(there)] = taken else { return None };
            Some(here.iter().zip(&there).zip(&radiosity).map(|((here, there), all)| all - 0.5 * (here + there)).collect())
        };
        let [Some(defect), Some(defect_around)] = [defect(little), defect(aside)] else { return Ok(None) };
        Ok(Some(Sample { rho, defect, defect_around }))
    }

    /// In each channel, the reflectance of a place of a leaf, and the radiosity by a corrected gather, without the emission of
    /// lamps.
    pub(super) fn corrected_at(&self, leaf: usize, place: DVec3) -> Result<[Vec<f64>; 2], Error> {
        let (face, irradiance) = (self.element(leaf).face(), self.corrected_on(leaf, place)?);
        let [rho, emitted] = self.system.surfaces.reflectance_and_emission(face, place);
        let radiosity = |c: usize| rho[c] * irradiance[c] + emitted[c] - self.lamp_on(face, c);
        let radiosity = (0..rho.len()).map(radiosity).collect();
        Ok([rho, radiosity])
    }

    /// The radiosity `q` that gathers take a place to have, without the emission of lamps; `None` if the error of gathers is not
    /// known.
    pub(super) fn taken_at(&self, face: usize, place: DVec3) -> Option<Vec<f64>> {
        let (leaf, error) = (self.system.mesh.leaf_at(face, place)?, self.known_error()?);
        let (element, basis) = (self.element(leaf), self.basis(leaf));
        let (at, is_sure) = (element.reference(place), self.has_sure_details());
        let (functions, more) = (basis.values(at), basis.above()?.values(at));
        let taken = |(channel, detail): (usize, &Detail)| {
            let values = [&self.radiosity.field, error].map(|field| dot(field.coefficients(leaf, channel), &functions));
            let detail = if is_sure { detail.sure() * dot(&detail.coefficients, &more) } else { 0.0 };
            values[0] + values[1] + detail
        };
        Some(self.details()[leaf].iter().enumerate().map(taken).collect())
    }
}

/// How far it is in a direction to where a convex polygon ends; less for others.
fn way_on(polygon: &Polygon, from: DVec3, way: DVec3) -> f64 {
    let (v, normal) = (polygon.vertices(), polygon.normal());
    let to_side = |i: usize| {
        let outward = (v[(i + 1) % v.len()] - v[i]).cross(normal);
        let (speed, left) = (outward.dot(way), outward.dot(v[i] - from));
        if speed <= ALONG * outward.length() {
            return f64::INFINITY;
        }
        if left > 0.0 { left / speed } else { 0.0 }
    };
    (0..v.len()).map(to_side).fold(f64::INFINITY, smallest)
}

/// `C - q + eps` on both sides, from reflectances, `C - q`, and the weights of all at each distance; `None` if the sum does not
/// end.
fn solve_errors(rho: &[Vec<f64>; 2], defect: &[Vec<f64>; 2], rows: &[Vec<f64>]) -> Option<[Vec<f64>; 2]> {
    let mut error = defect.clone();
    let size = defect.iter().flatten().map(|of| of.abs()).sum::<f64>();
    for _ in 0..MOST_SWEEPS {
        let mut change = 0.0;
        for side in [0, 1] {
            for (k, row) in rows.iter().enumerate() {
                let next = defect[side][k] + rho[side][k] * dot(row, &error[1 - side]);
                change += (next - error[side][k]).abs();
                error[side][k] = next;
            }
        }
        if change <= SOLVED * size {
            return Some(error);
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    fn wedge(angle: f64, farthest: f64) -> Wedge {
        let sides = [(0, DVec3::X), (1, DVec3::new(angle.cos(), 0.0, angle.sin()))];
        Wedge { foot: DVec3::ZERO, along: DVec3::Y, sides, leaves: [0, 1], ends: [1e6; 2], distance: 0.0, farthest }
    }

    #[test]
    fn what_is_seen_of_the_same_light_everywhere_is_the_form_factor_and_at_the_edge_its_limit() {
        for angle in [0.3, 1.0, 0.5 * PI, 2.5] {
            let wedge = wedge(angle, 2.0);
            for distance in [0.0, 1e-5, 1e-3, 0.1, 1.0] {
                let end = DVec3::new(2.0 * angle.cos() - distance, 0.0, 2.0 * angle.sin());
                let exact = if distance > 0.0 { 0.5 * (1.0 + end.x / end.length()) } else { 0.5 * (1.0 + angle.cos()) };
                for degree in [DEGREE, DEGREE / 2] {
                    let computed: f64 = wedge.view_weights(distance, degree).iter().sum();
                    assert!((computed - exact).abs() < 1e-12, "{angle} {distance} {degree}: {computed} {exact}");
                }
            }
        }
    }

    /// Of light that is `t`, from the distance 1 at a right angle, `int_0^Y t dF = (asinh Y - Y/sqrt(1 + Y^2))/2`.
    #[test]
    fn what_is_seen_of_light_that_rises_evenly_is_its_integral() {
        let (wedge, exact) = (wedge(0.5 * PI, 1.0), 0.5 * (1.0_f64.asinh() - 0.5_f64.sqrt()));
        let light = samples(DEGREE).into_iter().map(|u| u.powi(3)).collect::<Vec<f64>>();
        let computed = dot(&wedge.view_weights(1.0, DEGREE), &light);
        assert!((computed - exact).abs() < 2e-4 * exact, "{computed} {exact}");
    }
}
