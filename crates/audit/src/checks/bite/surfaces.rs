//! Polygons that are flat but for the rounding of their coordinates, and polygons that turn inward, against the triangles of which they can
//! be made: an answer holds for each surface through the vertices, and with its bound for one made of triangles along either diagonal.
//!
//! Triangles are flat and convex, so that the reference shares no code for other polygons. Bounds are held from above too, by the rounding of
//! the coordinates.

use glam::DVec3;
use radgrad_core::batch::{Engine, ReadyEmitter};
use radgrad_core::{Answer, Emission, Emitter, Error, Method, Polygon, Receiver, evaluate_to};
use radgrad_scene::case::Problem;

use crate::cases::sampler::Sampler;
use crate::checks::batches::{DOUBLE, asked, entry};
use crate::measures::measure::{is_worse, worse};
use crate::measures::truth::norm_above;

/// How an occluder is to emitter and receiver.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Place {
    /// There is none.
    Absent,
    /// Between.
    Between,
    /// It stands on an edge of the emitter, or hangs from it.
    OnEdge,
    /// It lies on the emitter, but for an edge that is a little higher than all of its corners.
    Lying,
    /// It stands on a corner, or hangs from it.
    OnCorner,
    /// It passes through the emitter.
    Through,
    /// It passes through the emitter's plane beyond an edge.
    Beyond,
    /// The receiver is in its plane, but for rounding or a little more.
    EdgeOn,
}

const PLACES: [Place; 8] =
    [Place::Absent, Place::Between, Place::OnEdge, Place::OnCorner, Place::Through, Place::Beyond, Place::EdgeOn, Place::Lying];

impl Place {
    /// The largest bound allowed, over the light and the relative rounding of coordinates: in an occluder's plane the hidden part may be
    /// anything, and so may that of an emitter on which the occluder all but lies.
    const fn most(self) -> f64 {
        match self {
            Self::EdgeOn | Self::Lying => f64::INFINITY,
            Self::Through => 1e6,
            _ => 1e3,
        }
    }
}

/// A drawn receiver, with outlines of the emitter and of an occluder.
struct Drawn {
    receiver: Receiver,
    emitter: Vec<DVec3>,
    occluder: Vec<DVec3>,
    precision: f64,
    place: Place,
}

/// A quadrilateral about a middle, which turns inward at its first vertex or nowhere.
fn outline(sampler: &mut Sampler, middle: DVec3, [u, v]: [DVec3; 2], turns_in: bool) -> [DVec3; 4] {
    let mut near = || sampler.between(0.7, 1.3);
    let [a, b, c, d] = [near(), near(), near(), near()];
    let first = if turns_in { u * (0.3 * a) } else { -u * a };
    [middle + first, middle - v * b, middle + u * (c + 0.5), middle + v * d]
}

fn drawn(sampler: &mut Sampler) -> Option<Drawn> {
    let precision = sampler.spread(-46, -22);
    // Rounded by as much as is said, so that four vertices are in no plane.
    let rounded = |v: DVec3| (v / precision).round() * precision;
    let normal = sampler.direction();
    let across = sampler.perpendicular(normal);
    let axes = [across, normal.cross(across)];
    let [turns_in, occluder_turns_in] = [(); 2].map(|()| sampler.one_in(3));
    let middle = sampler.cube() * 2.0;
    let emitter = outline(sampler, middle, axes, turns_in).map(rounded);
    let inside = |sampler: &mut Sampler| {
        let [a, b, c] = [emitter[0], emitter[1], emitter[2]];
        let (s, t) = (sampler.between(0.2, 0.4), sampler.between(0.2, 0.4));
        a + (b - a) * s + (c - a) * t
    };
    let distance = if sampler.one_in(3) { 20.0 } else { 1.5 };
    let x = inside(sampler) + (normal + sampler.cube() * 0.5) * distance;
    let place = PLACES[sampler.below(8) as usize];
    let target = inside(sampler);
    let rise = (x - target) * sampler.between(0.05, 0.3) * if sampler.one_in(3) { -1.0 } else { 1.0 };
    let aside = sampler.perpendicular((x - target).normalize()) * sampler.between(0.2, 0.6);
    let corner = sampler.below(4) as usize;
    let [a, b] = [emitter[corner], emitter[(corner + 1) % 4]];
    let occluder = match place {
        Place::Absent => Vec::new(),
        Place::Between => {
            let size = sampler.between(0.1, 0.4);
            let place = target + (x - target) * sampler.between(0.3, 0.8);
            outline(sampler, place, axes.map(|axis| axis * size), occluder_turns_in).map(rounded).to_vec()
        }
        Place::OnEdge => vec![a, b, rounded(b + rise * 1.3 + (b - a) * 0.1), rounded(a + rise)],
        Place::Lying => {
            let whole = Polygon::from_rounded(emitter.to_vec(), precision).ok()?;
            let (up, defect) = (whole.normal(), whole.planarity_defect());
            let mut over = |corner: DVec3, other: DVec3| {
                let foot = corner + (other - corner) * sampler.between(0.3, 0.7);
                foot + up * (defect * sampler.between(1.02, 1.5) - up.dot(foot - emitter[0]))
            };
            vec![a, b, over(b, emitter[(corner + 2) % 4]), over(a, emitter[(corner + 3) % 4])]
        }
        Place::OnCorner => vec![a, rounded(a + rise + aside), rounded(a + rise * 2.0), rounded(a + rise - aside)],
        Place::Through => {
            // Aside, so that the receiver is not in its plane.
            let up = rise + aside.cross(normal) * 0.5;
            [target - up * 0.5, target + up + aside, target + up * 2.0, target + up - aside].map(rounded).to_vec()
        }
        Place::Beyond => {
            let outward = (b - a).cross(normal).normalize();
            let foot = (a + b) * 0.5 + outward * sampler.between(0.3, 2.0);
            let along = (b - a) * 0.2;
            [foot - along - rise, foot + along - rise, foot + along + rise, foot - along + rise].map(rounded).to_vec()
        }
        Place::EdgeOn => {
            let place = target + (x - target) * sampler.between(0.3, 0.7);
            let tilt = normal * (sampler.sign() * precision * sampler.between(0.0, 8.0));
            let way = (x - target) * 0.1;
            [place - way - aside, place - way + aside, place + way + aside + tilt, place + way - aside].map(rounded).to_vec()
        }
    };
    let facing = target - x + sampler.cube() * (0.3 * distance);
    let receiver = Receiver::new(x, facing, 1.0).ok()?;
    Some(Drawn { receiver, emitter: emitter.to_vec(), occluder, precision, place })
}

/// The triangles along a diagonal.
fn halves(outline: &[DVec3], diagonal: usize) -> Result<Vec<Polygon>, Error> {
    let corner = |k: usize| outline[(diagonal + k) % outline.len()];
    if outline.is_empty() {
        return Ok(Vec::new());
    }
    [[0, 1, 2], [0, 2, 3]].into_iter().map(|half| Polygon::new(half.map(corner).to_vec())).collect()
}

fn answer(receiver: &Receiver, emitter: Polygon, occluders: &[Polygon], tolerance: f64) -> Result<Answer, Error> {
    evaluate_to(receiver, &Emitter::new(emitter, Emission::Constant(1.0))?, occluders, tolerance)
}

/// A linear emission by its value at a place and its gradient.
#[derive(Debug, Clone, Copy)]
struct Sloping {
    place: DVec3,
    value: f64,
    gradient: DVec3,
}

impl Sloping {
    fn emitter(self, polygon: Polygon) -> Result<Emitter, Error> {
        let first = self.value + self.gradient.dot(polygon.vertices()[0] - self.place);
        Emitter::new(polygon, Emission::gradient(first, self.gradient))
    }
}

/// Contradictions to an occluder that is made of triangles with these corners, and the bound over the one allowed.
fn compared(drawn: &Drawn, triangulated: &[DVec3]) -> Result<(Vec<String>, f64), Error> {
    let Drawn { receiver, emitter, occluder, precision, place } = drawn;
    let whole = |outline: &[DVec3]| Polygon::from_rounded(outline.to_vec(), *precision);
    let screens: Vec<Polygon> = if occluder.is_empty() { Vec::new() } else { vec![whole(occluder)?] };
    let flat = whole(emitter)?;
    let answers = [1.0, 1e-3].map(|tolerance| answer(receiver, flat.clone(), &screens, tolerance));
    let turns_in = |outline: &[DVec3]| {
        let [a, b, c, d] = outline else { return false };
        (*b - *a).cross(*c - *a).dot((*d - *c).cross(*b - *c)) < 0.0
            || (*b - *a).cross(*d - *a).dot((*d - *c).cross(*b - *c)) < 0.0
    };
    let (mut findings, mut most) = (Vec::new(), 0.0);
    for (k, l) in [(0, 0), (1, 1), (0, 1), (1, 0)] {
        // The other diagonal of what turns inward is outside.
        if (k == 1 && turns_in(emitter)) || (l == 1 && (occluder.is_empty() || turns_in(occluder))) {
            continue;
        }
        let (mut value, mut slope, mut room) = (0.0, DVec3::ZERO, [0.0; 2]);
        let screens = halves(triangulated, l)?;
        for half in halves(emitter, k)? {
            let part = answer(receiver, half, &screens, 1e-12)?;
            value += part.radiosity;
            slope += part.gradient;
            room[0] += part.radiosity_error;
            room[1] += part.gradient_error;
        }
        for said in answers.iter().flatten() {
            let error = [(said.radiosity - value).abs(), norm_above(said.gradient - slope)];
            let bound = [said.radiosity_error + room[0], said.gradient_error + room[1]];
            if !(error[0] <= bound[0] * (1.0 + 1e-12) && error[1] <= bound[1] * (1.0 + 1e-12)) {
                findings.push(format!("{place:?}, diagonals {k} and {l}: off by {error:?}, known to {bound:?}: {said:?}"));
            }
            most = worse(most, said.radiosity_error / (said.radiosity + room[0]).max(1e-3) / precision);
        }
    }
    Ok((findings, most))
}

/// Contradictions between a receiver on a surface that is not flat, within its outline or beyond, and receivers just in front of and just
/// behind it: now and then it is all but level with a corner along an axis. Often the emission is negative, and not the same everywhere.
fn on_surface(sampler: &mut Sampler) -> Result<Vec<String>, Error> {
    let precision = sampler.spread(-46, -40);
    let rounded = |v: DVec3| (v / precision).round() * precision;
    let mut normal = sampler.direction();
    // Some have no part along an axis, from which the outline is seen as a line.
    if sampler.one_in(2) {
        normal[sampler.below(3) as usize] = 0.0;
    }
    let normal = normal.normalize();
    let across = sampler.perpendicular(normal);
    let axes = [across, normal.cross(across)];
    let (middle, turns_in) = (sampler.cube() * 2.0, sampler.one_in(3));
    let corners = outline(sampler, middle, axes, turns_in).map(rounded);
    let mut place = corners[0] + axes[0] * sampler.between(-2.0, 3.0) + axes[1] * sampler.between(-1.5, 1.5);
    let (axis, corner) = (sampler.below(3) as usize, corners[sampler.below(4) as usize]);
    let along = axes.iter().max_by(|a, b| a[axis].abs().total_cmp(&b[axis].abs())).copied().unwrap_or(normal);
    if sampler.one_in(2) {
        place += along * ((corner[axis] - place[axis] + sampler.sign() * sampler.spread(-40, -28)) / along[axis]);
    }
    let facing = sampler.direction();
    let gradient = axes[0] * if sampler.one_in(2) { 0.0 } else { sampler.between(-0.02, 0.02) };
    let emission = Sloping { place: middle, value: sampler.sign(), gradient };
    let constant = sampler.sign() * sampler.spread(-8, 2);
    let is_constant = sampler.one_in(2);
    let lit = |polygon: Polygon| {
        if is_constant { Emitter::new(polygon, Emission::Constant(constant)) } else { emission.emitter(polygon) }
    };
    let whole = Polygon::from_rounded(corners.to_vec(), precision)?;
    // As high as the highest vertex, and as low as the lowest one can be.
    let (defect, up) = (whole.planarity_defect(), whole.normal());
    let height = up.dot(place - corners[0]);
    let (receiver, emitter) = (Receiver::new(place, facing, 1.0)?, lit(whole)?);
    let said = evaluate_to(&receiver, &emitter, &[], 1.0)?;
    let mut findings = Vec::new();
    if said.method != Method::OnSurface {
        return Ok(findings);
    }
    let ready = ReadyEmitter::<f64>::new(emitter.clone());
    let problem = Problem { receiver, emitter, occluders: Vec::new(), tolerance: 1.0 };
    let lanes = asked(Engine::new(), (&problem, &ready), &[[place, facing]], &DOUBLE, 3)?;
    let (on_lanes, _, [lanes_error, _]) = entry(&lanes, &DOUBLE, 0);
    for step in [-defect, defect] {
        let receiver = Receiver::new(place + up * (step - height), facing, 1.0)?;
        let (mut value, mut own) = (0.0, 0.0);
        for half in halves(&corners, 0)? {
            let part = evaluate_to(&receiver, &lit(half)?, &[], 1e-6)?;
            value += part.radiosity;
            own += part.radiosity_error;
        }
        for (told, bound) in [(said.radiosity, said.radiosity_error), (on_lanes, lanes_error)] {
            let (error, room) = ((told - value).abs(), bound + own);
            if is_worse(error, room) || room.is_nan() {
                findings
                    .push(format!("at {step:e} over a surface it is {value}, not {told}: off by {error:e}, known to {room:e}"));
            }
        }
    }
    Ok(findings)
}

/// Cases that are seldom drawn: a screen behind the plane of the emitter's first corner and before other corners; and one that is seen edge on
/// along an edge of the emitter, over which one of its corners reaches.
fn chosen() -> Result<[Drawn; 2], Error> {
    let slight = libm::ldexp(1.0, -24);
    let square = |heights: [f64; 2], [low, high]: [f64; 2]| {
        let corners = [[low, low], [low, high], [high, high], [high, low]];
        (0..4).map(|k| DVec3::new(corners[k][0], corners[k][1], heights[k % 2])).collect::<Vec<_>>()
    };
    let behind = Drawn {
        receiver: Receiver::new(DVec3::new(0.3, 0.4, 0.0), DVec3::Z, 1.0)?,
        emitter: square([1.0 - slight, 1.0 + slight], [0.0, 1.0]),
        occluder: square([1.0 - 0.5 * slight; 2], [-0.5, 1.5]),
        precision: 16.0 * slight,
        place: Place::Lying,
    };
    let edge_on = Drawn {
        receiver: Receiver::new(DVec3::ZERO, DVec3::Z, 1.0)?,
        emitter: [[-1.0, 0.0], [-1.0, 1.0], [1.0, 1.0], [1.0, 0.0]].map(|[x, y]| DVec3::new(x, y, 1.0)).to_vec(),
        occluder: [[-0.0625, -0.5, 0.5], [0.0625, -0.5, 0.5], [0.078_125, -10.0, 0.625], [-0.078_125, 1.25, 0.625]]
            .map(|[x, y, z]| DVec3::new(x, y * slight, z))
            .to_vec(),
        precision: 16.0 * slight,
        place: Place::EdgeOn,
    };
    Ok([behind, edge_on])
}

/// Contradictions of so many draws.
pub(super) fn all_wrong(count: u64) -> Vec<String> {
    let (mut findings, mut refused) = (Vec::new(), 0);
    let of_chosen = |drawn: &Drawn| Ok(compared(drawn, &drawn.occluder)?.0);
    let told = chosen().and_then(|chosen| chosen.iter().map(of_chosen).collect::<Result<Vec<_>, _>>());
    findings.extend(told.map_or_else(|error| vec![error.to_string()], |told| told.concat()));
    for index in 0..count {
        let Some(drawn) = drawn(&mut Sampler::new(63, "surfaces", index)) else { continue };
        match compared(&drawn, &drawn.occluder) {
            Ok((wrong, most)) => {
                findings.extend(wrong.into_iter().map(|what| format!("surfaces:63:{index}: {what}")));
                if is_worse(most, drawn.place.most()) {
                    let place = drawn.place;
                    findings.push(format!("surfaces:63:{index}: {place:?}: the bound is {most:e} times the rounding"));
                }
            }
            Err(_) => refused += 1,
        }
    }
    for index in 0..4 * count {
        match on_surface(&mut Sampler::new(66, "on a surface", index)) {
            Ok(wrong) => findings.extend(wrong.into_iter().map(|what| format!("on a surface:66:{index}: {what}"))),
            Err(_) => refused += 1,
        }
    }
    if 4 * refused > 5 * count {
        findings.push(format!("{refused} of {count} drawn surfaces are refused"));
    }
    findings
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_answer_for_one_surface_is_told_from_another() {
        assert_eq!(all_wrong(60), Vec::<String>::new());
        let drawn = (0..400).filter_map(|index| drawn(&mut Sampler::new(63, "surfaces", index)));
        let between: Vec<Drawn> = drawn.filter(|drawn| drawn.place == Place::Between).collect();
        let moved = |drawn: &&Drawn| {
            let mut corners = drawn.occluder.clone();
            let aside = (corners[1] - corners[3]) * 0.01;
            corners[1] += aside;
            compared(drawn, &corners).is_ok_and(|(wrong, _)| !wrong.is_empty())
        };
        assert!(2 * between.iter().filter(moved).count() > between.len());
    }
}
