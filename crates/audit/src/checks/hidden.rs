//! The index of what may hide what: its decisions held against core, which asks all polygons, against plain intersections of segments and rays, and against
//! themselves in other units and with other axes. How far each decision reaches is found by halving, and remembered.

use glam::DVec3;
use radgrad_core::{Answer, Emission, Emitter, Polygon, Receiver, evaluate};
use radgrad_scene::{Beam, FactorSettings, FormFactors, Occluders, Scene, probes};

use crate::cases::sampler::Sampler;
use crate::checks::exchanges::moved;
use crate::checks::screens::of_faces;
use crate::scenes::draw;

/// Polygons of a drawn scene.
const POLYGONS: usize = 14;

/// A point of a lattice, where edges and planes coincide, or anywhere.
fn point(s: &mut Sampler, is_lattice: bool) -> DVec3 {
    if is_lattice { DVec3::from([(); 3].map(|()| f64::from(s.below(5)) * 0.5 - 1.0)) } else { s.cube() }
}

fn polygon(s: &mut Sampler, is_lattice: bool) -> Polygon {
    loop {
        let [a, b, c] = [(); 3].map(|()| point(s, is_lattice));
        let corners = match s.below(3) {
            0 => vec![a, b, c],
            1 => vec![a, b, c, a + c - b],
            _ => vec![a, b, c, a * 0.5 + (b + c) * 0.25],
        };
        if let Ok(polygon) = Polygon::new(corners) {
            return polygon;
        }
    }
}

/// By a cyclic shift of the axes and a power of two, with the vertices from another one on: exactly the same polygon.
fn turned(polygon: &Polygon, by: usize, power: f64) -> Option<Polygon> {
    let mut corners: Vec<DVec3> = polygon.vertices().iter().map(|&corner| shifted(corner, by) * power).collect();
    corners.rotate_left(by);
    Polygon::new(corners).ok()
}

fn shifted(point: DVec3, by: usize) -> DVec3 {
    moved(point, ([by % 3, (by + 1) % 3, (by + 2) % 3], [1.0; 3]))
}

/// Units in which the same is asked.
const POWERS: [f64; 3] = [1.0, 1.0 / (1u64 << 40) as f64, (1u64 << 30) as f64];

/// The light that planes of surfaces leave out, as they are level up to rounding.
const PLANES: f64 = 1e-12;

/// The bound on a gradient above which it has two values: others are known to twelve digits.
const TWO_VALUES: f64 = 1e-6;

/// The light of a lamp on a receiver past all polygons and past some of them; nothing where there is no beam.
fn past(receiver: &Receiver, lamp: &Polygon, all: &[Polygon], some: Option<&[usize]>) -> Option<[Answer; 2]> {
    let emitter = Emitter::new(lamp.clone(), Emission::Constant(1.0)).ok()?;
    let seen = |polygons: &mut dyn Iterator<Item = &Polygon>| evaluate(receiver, &emitter, polygons.collect::<Vec<_>>()).ok();
    let past_all = seen(&mut all.iter())?;
    let nothing = Answer { radiosity: 0.0, radiosity_error: 0.0, gradient: DVec3::ZERO, gradient_error: 0.0, ..past_all };
    Some([past_all, some.map_or(Some(nothing), |some| seen(&mut some.iter().map(|&k| &all[k])))?])
}

/// Violations by what is found in the beam from a point, or from a polygon, to another polygon.
#[must_use]
pub fn of_beam(index: u64) -> Vec<String> {
    let s = &mut Sampler::new(22, "beams", index);
    let is_lattice = s.one_in(2);
    let mut others: Vec<Polygon> = (0..POLYGONS).map(|_| polygon(s, is_lattice)).collect();
    let [surface, lamp] = [(); 2].map(|()| polygon(s, is_lattice));
    let (at, direction) = (point(s, is_lattice), point(s, is_lattice));
    // One beside the beam whose edge is seen along an edge of the lamp.
    if let [a, b, c, ..] = *lamp.vertices()
        && is_lattice
    {
        let [a, b, c] = [a, b, c].map(|corner| (at + corner) * 0.5);
        others.extend(Polygon::new(vec![a, b, a + b - c]));
    }
    let mut findings = Vec::new();
    let mut sets = Vec::new();
    for (by, power) in POWERS.into_iter().enumerate() {
        let turn = |polygon: &Polygon| turned(polygon, by, power);
        let (Some(all), Some(lamp)) = (others.iter().map(turn).collect::<Option<Vec<_>>>(), turn(&lamp)) else { continue };
        let Ok(receiver) = Receiver::new(shifted(at, by) * power, shifted(direction, by), 1.0) else { continue };
        let occluders = Occluders::new(&all);
        let polygons = |beam: Option<Beam>| beam.map(|beam| occluders.in_beam(&beam, &[]).polygons);
        let exactly = polygons(Beam::from_receiver(&receiver, &lamp));
        if by == 0 {
            let corners = surface.vertices();
            // A point of the surface's plane, exactly on a lattice.
            let on = (corners[0] + corners[1] * 2.0 + corners[2]) / 4.0;
            let of_surface = Receiver::new(on, surface.normal(), 1.0).ok();
            let by_surface = polygons(Beam::from_polygon(&surface, &lamp));
            let asked = [(Some(receiver), exactly.clone(), 0.0), (of_surface.filter(|_| is_lattice), by_surface, PLANES)];
            for (receiver, chosen, slack) in
                asked.into_iter().filter_map(|(receiver, chosen, slack)| Some((receiver?, chosen, slack)))
            {
                let Some([past_all, past_some]) = past(&receiver, &lamp, &all, chosen.as_deref()) else { continue };
                let slopes = (past_all.gradient - past_some.gradient).length();
                // Where the gradient has two values, one of them is of a polygon that hides nothing.
                let has_two = |answer: &Answer| answer.gradient_error > TWO_VALUES;
                let are_as_sure = has_two(&past_all) == has_two(&past_some);
                if (past_all.radiosity - past_some.radiosity).abs() > past_all.radiosity_error + past_some.radiosity_error + slack
                    || slack == 0.0 && (!are_as_sure || slopes > past_all.gradient_error + past_some.gradient_error)
                {
                    findings.push(format!("beam {index}: {past_some:?} past those in the beam, {past_all:?} past all"));
                }
            }
        }
        sets.push(exactly);
    }
    // On a lattice all differences are exact, so that nothing depends on axes or units.
    if is_lattice && sets.iter().any(|set| *set != sets[0]) {
        findings.push(format!("beam {index}: other axes and units have others between: {sets:?}"));
    }
    findings
}

/// Violations by a lamp whose corners are in a receiver's horizon up to rounding: where one is above it, and the receiver before the lamp, there is a beam.
#[must_use]
pub fn of_horizon(index: u64) -> Vec<String> {
    // Whole numbers of this are doubles, and sums of their products whole numbers of its square.
    const UNIT: f64 = 1.0 / (1u64 << 50) as f64;
    let s = &mut Sampler::new(29, "horizons", index);
    let mut whole = || s.integer(-(1 << 49), 1 << 49);
    let [x, y, z] = [whole(), whole(), whole()];
    // Of half of the normals the components cancel.
    let normal = [x, y, if index.is_multiple_of(2) { z } else { -x - y + z / (1 << 20) }];
    if normal[2] == 0 {
        return Vec::new();
    }
    let height = |at: [i64; 3]| (0..3).map(|k| i128::from(normal[k]) * i128::from(at[k])).sum::<i128>();
    let level = |_| {
        let [x, y] = [whole() / 4, whole() / 4];
        let z = i64::try_from(-height([x, y, 0]) / i128::from(normal[2])).ok().filter(|z| z.abs() < 1 << 50)?;
        (height([x, y, z]) > 0).then_some([x, y, z])
    };
    // Those that are least above it.
    let mut above: Vec<[i64; 3]> = (0..60).filter_map(level).collect();
    above.sort_by_key(|&place| height(place));
    let [a, b, ..] = above[..] else { return Vec::new() };
    #[allow(clippy::cast_precision_loss, reason = "of 51 bits at most")]
    let at = |place: [i64; 3]| DVec3::from(place.map(|x| x as f64)) * UNIT;
    let Ok(receiver) = Receiver::new(DVec3::ZERO, at(normal), 1.0) else { return Vec::new() };
    // With a corner that is clearly below, so that the lamp is not in the horizon.
    let below = at(a) - at(normal) * 0.5;
    let has_beam = [[at(a), at(b), below], [at(b), at(a), below]]
        .map(|corners| Polygon::new(corners.to_vec()).is_ok_and(|lamp| Beam::from_receiver(&receiver, &lamp).is_some()));
    // It is before one side of it.
    if !has_beam.contains(&true) {
        return vec![format!("horizon {index}: {:?} is above the horizon, and there is no beam", [a, b])];
    }
    Vec::new()
}

/// How many times a direction it is from a point to a polygon's inside, if a ray goes there; `None` too within `margin` of an edge or of the plane.
fn crossing(polygon: &Polygon, from: DVec3, toward: DVec3, margin: f64) -> Option<Option<f64>> {
    let (vertices, normal) = (polygon.vertices(), polygon.normal());
    let (above, falls) = (normal.dot(from - vertices[0]), -normal.dot(toward));
    if above.abs() <= margin || falls.abs() <= margin {
        return None;
    }
    let at = from + toward * (above / falls);
    // The sum of the angles at which edges are seen.
    let mut turn = 0.0;
    for (k, &a) in vertices.iter().enumerate() {
        let (u, v) = (a - at, vertices[(k + 1) % vertices.len()] - at);
        let (sine, cosine) = (normal.dot(u.cross(v)), u.dot(v));
        if sine.abs() <= margin && cosine <= margin {
            return None;
        }
        turn += libm::atan2(sine, cosine);
    }
    Some((turn > std::f64::consts::PI && above / falls > 0.0).then_some(above / falls))
}

/// Violations by the first polygon along rays, and by what is between two points.
#[must_use]
pub fn of_rays(index: u64) -> Vec<String> {
    const MARGIN: f64 = 1e-6;
    let s = &mut Sampler::new(23, "rays", index);
    let mut polygons: Vec<Polygon> = (0..POLYGONS).map(|_| polygon(s, false)).collect();
    // Each with another side, back to back.
    let backs: Vec<Polygon> =
        polygons.iter().filter_map(|p| Polygon::new(p.vertices().iter().rev().copied().collect()).ok()).collect();
    polygons.extend(backs);
    let mut findings = Vec::new();
    for (by, power) in POWERS.into_iter().enumerate() {
        let Some(all) = polygons.iter().map(|polygon| turned(polygon, by, power)).collect::<Option<Vec<_>>>() else { continue };
        let occluders = Occluders::new(&all);
        for _ in 0..40 {
            let (from, to) = (s.cube() * 1.3, s.cube() * 1.3);
            let along = to - from;
            let meets: Option<Vec<_>> = polygons.iter().map(|polygon| crossing(polygon, from, along, MARGIN)).collect();
            let Some(meets) = meets else { continue };
            let faces = |face: usize| polygons[face].normal().dot(along) < 0.0;
            let hits = meets.iter().enumerate().filter_map(|(face, share)| share.map(|share| (share, face)));
            let first = hits.clone().filter(|&(_, face)| faces(face)).min_by(|a, b| a.0.total_cmp(&b.0));
            let [start, end] = [from, to].map(|point| shifted(point, by) * power);
            let leave_out = first.map_or(Vec::new(), |(_, face)| vec![face, (face + POLYGONS) % (2 * POLYGONS)]);
            let second =
                hits.clone().filter(|&(_, face)| faces(face) && !leave_out.contains(&face)).min_by(|a, b| a.0.total_cmp(&b.0));
            for (expected, without) in [(first, &[][..]), (second, &leave_out[..])] {
                let said = occluders.first_along(start, end - start, without);
                if said.map(|(face, _)| face) != expected.map(|(_, face)| face) {
                    findings.push(format!("rays {index} by {by}: from {from} along {along} first {said:?}, it is {expected:?}"));
                }
                if let (Some((_, at)), Some((share, _))) = (said, expected)
                    && (at - (start + (end - start) * share)).length() > 1e-9 * power
                {
                    findings.push(format!("rays {index} by {by}: {at} is not where it meets the first"));
                }
            }
            let is_between = hits.clone().any(|(share, _)| share < 1.0);
            if hits.clone().all(|(share, _)| (share - 1.0).abs() > MARGIN)
                && occluders.is_between([start, end], &[]) != is_between
            {
                findings.push(format!("rays {index} by {by}: between {from} and {to} it is {is_between} that something is"));
            }
        }
    }
    findings
}

/// Violations by the first polygon along a ray that starts on another one, which it does not meet, to either side.
#[must_use]
pub fn of_starts(index: u64) -> Vec<String> {
    let s = &mut Sampler::new(24, "starts", index);
    let level = |z: f64| quad([0.0, 0.0, z], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]);
    let mut outlines = [level(-1.0), level(0.0), level(1.0)];
    outlines[2].reverse();
    let from = DVec3::new(s.between(0.1, 0.9), s.between(0.1, 0.9), 0.0);
    let aside = DVec3::new(s.between(0.05, 0.95), s.between(0.05, 0.95), 0.0) - from;
    let mut findings = Vec::new();
    for (by, power) in POWERS.into_iter().enumerate() {
        let level = |outline: &Vec<DVec3>| Polygon::new(outline.clone()).ok().and_then(|polygon| turned(&polygon, by, power));
        let Some(polygons) = outlines.iter().map(level).collect::<Option<Vec<_>>>() else { continue };
        let occluders = Occluders::new(&polygons);
        for (expected, up) in [(2, DVec3::Z), (0, -DVec3::Z)] {
            let said = occluders.first_along(shifted(from, by) * power, shifted(aside + up, by) * power, &[]);
            if said.map(|(face, _)| face) != Some(expected) {
                findings.push(format!("starts {index} by {by}: from {from} to {up} first {said:?}, it is {expected}"));
            }
        }
    }
    findings
}

/// A floor with towers on it, some of them wall to wall.
fn city(index: u64) -> Result<Scene, String> {
    let s = &mut Sampler::new(26, "city", index);
    let side = 2 + s.below(2);
    let mut outlines = vec![quad([0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0])];
    for (i, j) in (0..side).flat_map(|i| (0..side).map(move |j| (i, j))) {
        let step = 1.0 / f64::from(side);
        let wide = step * if s.one_in(3) { 1.0 } else { s.between(0.4, 0.9) };
        let [x, y, tall] = [f64::from(i) * step, f64::from(j) * step + 0.01, step * s.spread(-2, 1)];
        let deep = 0.7 * step;
        outlines.extend([
            quad([x, y, tall], [wide, 0.0, 0.0], [0.0, deep, 0.0]),
            quad([x, y, 0.0], [wide, 0.0, 0.0], [0.0, 0.0, tall]),
            quad([x + wide, y, 0.0], [0.0, deep, 0.0], [0.0, 0.0, tall]),
            quad([x + wide, y + deep, 0.0], [-wide, 0.0, 0.0], [0.0, 0.0, tall]),
            quad([x, y + deep, 0.0], [0.0, -deep, 0.0], [0.0, 0.0, tall]),
        ]);
    }
    let turn = |corner: DVec3| {
        let [x, y] = [0.8 * corner.x - 0.6 * corner.y, 0.6 * corner.x + 0.8 * corner.y];
        shifted(DVec3::new(x, y, corner.z), (index % 3) as usize)
    };
    of_faces(outlines.into_iter().map(|outline| outline.into_iter().map(turn).collect()))
}

fn quad(corner: [f64; 3], u: [f64; 3], v: [f64; 3]) -> Vec<DVec3> {
    draw::quad(corner.into(), u.into(), v.into())
}

/// Segments between two faces.
const SEGMENTS: usize = 24;

/// Violations by pairs of faces of a drawn city that are held to see nothing of each other: then no segment between the two is free.
///
/// # Errors
/// If the scene or a factor is refused: why.
pub fn of_city(index: u64) -> Result<Vec<String>, String> {
    let scene = city(index)?;
    let said = |error: radgrad_scene::Error| error.to_string();
    let factors = FormFactors::new(&scene).map_err(said)?;
    let settings = FactorSettings { tolerance: 1.0, estimate: 1.0, most_cells: 10, ..FactorSettings::default() };
    let matrix = factors.matrix(&settings, || ()).map_err(said)?;
    let polygons: Vec<&Polygon> = scene.polygons().collect();
    let s = &mut Sampler::new(27, "segments", index);
    let mut findings = Vec::new();
    for (i, j) in (0..polygons.len()).flat_map(|i| (0..i).map(move |j| (i, j))) {
        if matrix.row(i).any(|entry| entry.face == j) {
            continue;
        }
        let mut on = |face: usize| {
            let [a, b, _, d] = polygons[face].vertices() else { return DVec3::NAN };
            *a + (*b - *a) * s.between(0.02, 0.98) + (*d - *a) * s.between(0.02, 0.98)
        };
        let is_seen = |[x, y]: &[DVec3; 2]| {
            let rises = [polygons[i].normal().dot(*y - *x), polygons[j].normal().dot(*x - *y)];
            rises.iter().all(|rise| *rise > 1e-9) && !factors.index().is_between([*x, *y], &[i, j])
        };
        if let Some([x, y]) = (0..SEGMENTS).map(|_| [on(i), on(j)]).find(is_seen) {
            findings.push(format!("city {index}: {i} and {j} are held to be hidden, and {x} sees {y}"));
        }
    }
    Ok(findings)
}

/// The work of searches, in boxes and polygons that are compared with beams, and the pairs of faces that no search proves hidden: figures to be remembered.
///
/// # Errors
/// If the scene is refused: why.
pub(crate) fn recorded_work(index: u64) -> Result<Vec<f64>, String> {
    let scene = city(index)?;
    let factors = FormFactors::new(&scene).map_err(|error| error.to_string())?;
    let rows: Vec<usize> = (0..factors.faces().len()).collect();
    let seen = factors.sightings(&rows).map_err(|error| error.to_string())?;
    let s = &mut Sampler::new(28, "work", index);
    let others: Vec<Polygon> = (0..60).map(|_| polygon(s, false)).collect();
    let small =
        others.iter().filter_map(|of| Polygon::new(of.vertices().iter().map(|&v| v * 0.2 + of.vertices()[0]).collect()).ok());
    let occluders = Occluders::new(&small.collect::<Vec<_>>());
    let mut work = vec![seen.into_iter().sum::<usize>()];
    for pair in others.chunks_exact(2).take(12) {
        if let Some(beam) = Beam::from_polygon(&pair[0], &pair[1]) {
            let met = occluders.in_beam(&beam, &[]);
            work.extend([met.boxes_tested, met.polygons_tested, met.polygons.len()]);
        }
    }
    Ok(work.into_iter().map(|count| count as f64).collect())
}

/// The largest number below a tenth up to which a decision is what it is at the least one.
fn reach(is_so: impl Fn(f64) -> bool) -> f64 {
    let [mut low, mut high] = [1e-30_f64, 0.1];
    let first = is_so(low);
    if is_so(high) == first {
        return high;
    }
    while high / low > 1.0 + 1e-9 {
        let middle = (low * high).sqrt();
        if is_so(middle) == first { low = middle } else { high = middle }
    }
    low
}

/// How far decisions reach that rounding is allowed for, in drawn planes of the axes: heights, without a rounding of their own.
///
/// # Errors
/// If a polygon is refused: why.
pub(crate) fn recorded(index: u64) -> Result<Vec<f64>, String> {
    let s = &mut Sampler::new(24, "reaches", index);
    let by = (index % 3) as usize;
    let size = [1.0, 0.01, 1e-5][s.below(3) as usize];
    let at = |x: f64, y: f64, z: f64| shifted(DVec3::new(x, y, z), by);
    let made = |corners: Vec<DVec3>| Polygon::new(corners).map_err(|error| error.to_string());
    // Of `from_rounded`, a little off any plane, or of triangles.
    let bent = if s.one_in(2) { 1e-9 * size } else { 0.0 };
    let [x, y, u, v] = [s.between(0.3, 0.6), s.between(0.3, 0.6), s.between(0.2, 0.4), s.between(0.2, 0.4)];
    let rectangle = |z: f64, bent: f64| {
        let corners = [[x, y, z], [x + size * u, y, z], [x + size * u, y + size * v, z + bent], [x, y + size * v, z]];
        corners.map(|[x, y, z]| at(x, y, z)).to_vec()
    };
    let rounded = |corners: Vec<DVec3>| Polygon::from_rounded(corners, 2.0 * bent).map_err(|error| error.to_string());
    let surface = rounded(rectangle(0.0, bent))?;
    let lamp = made(rectangle(0.5, 0.0).into_iter().rev().collect())?;
    let small = |z: f64| [[0.2, 0.2], [0.7, 0.2], [0.2, 0.7]].map(|[a, b]| at(x + size * u * a, y + size * v * b, z)).to_vec();
    let is_found = |beam: Option<Beam>, other: &[DVec3]| {
        let other = Polygon::new(other.to_vec()).ok();
        beam.zip(other).is_some_and(|(beam, other)| !Occluders::new([&other]).in_beam(&beam, &[]).polygons.is_empty())
    };
    let middle = at(x + 0.3 * size * u, y + 0.3 * size * v, 0.0);
    let receiver = |z: f64, normal: DVec3| Receiver::new(middle + at(0.0, 0.0, z), normal, 1.0).ok();
    let down = at(0.0, 0.0, -1.0);
    let mut reaches = Vec::new();
    let mut add = |reach: f64| reaches.push(reach);
    // Above a surface, and before a lamp.
    add(reach(|z| is_found(Beam::from_polygon(&surface, &lamp), &small(z))));
    add(reach(|z| is_found(Beam::from_polygon(&lamp, &surface), &small(z))));
    add(reach(|z| is_found(Beam::from_point_of(&surface, middle, &lamp), &small(z))));
    // A receiver before a bent lamp, which no exact predicate decides; and something before a receiver's horizon.
    add(reach(|z| receiver(z, down).is_none_or(|receiver| Beam::from_receiver(&receiver, &surface).is_some())));
    add(reach(|z| receiver(-z, down).is_none_or(|receiver| Beam::from_receiver(&receiver, &surface).is_some())));
    let upright = at(1.0, 1.0, 0.0);
    let beside = |z: f64| {
        let corner = |along: f64, up: f64| middle + at(size * along, -size * along, up) + upright * z;
        [corner(0.0, 0.1), corner(0.0, 0.2), corner(0.01, 0.15)]
    };
    for sign in [1.0, -1.0] {
        let is_found = |receiver: Receiver, z: f64| is_found(Beam::from_receiver(&receiver, &lamp), &beside(sign * z));
        add(reach(|z| receiver(0.0, upright).is_none_or(|receiver| is_found(receiver, z))));
    }
    // The lamp over the surface's plane, and two polygons in one.
    add(reach(|z| made(small(z).into_iter().rev().collect()).is_ok_and(|lamp| Beam::from_polygon(&surface, &lamp).is_some())));
    add(reach(|z| {
        let wall = [[1.5, 0.2, -0.5], [1.5, 0.2, z], [1.5, 0.9, z], [1.5, 0.9, -0.5]].map(|[x, y, z]| at(x, y, z)).to_vec();
        made(wall).is_ok_and(|wall| probes::exchange(&surface, &wall, 1e-12, f64::INFINITY) != [0.0; 2])
    }));
    let flat = made(rectangle(0.0, 0.0))?;
    for far in [0.0, 3.0] {
        add(reach(|z| probes::height(&flat, at(x + far, y + far, z)) == 0.0));
    }
    // Rays and segments that start near a plane.
    let index = Occluders::new([&flat]);
    add(reach(|z| index.first_along(middle + at(0.0, 0.0, z), at(0.1 * size, 0.0, -1.0), &[]).is_some()));
    add(reach(|z| index.is_between([middle + at(0.0, 0.0, z), middle - at(0.0, 0.0, 1.0)], &[])));
    // What an edge hides that passes before a lamp's by so much.
    for ahead in [0.0, 1e-16, 1e-13, 1e-6] {
        let wall = [[x + ahead, 0.0, 0.0], [x + ahead, 2.0, 0.0], [x + ahead, 2.0, 0.6], [x + ahead, 0.0, 0.6]];
        add(probes::may_hide(middle, &surface, &lamp, &made(wall.map(|[x, y, z]| at(x, y, z)).to_vec())?));
    }
    Ok(reaches)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_not_found_hides_nothing_and_rays_meet_what_is_there() {
        let findings = (0..60).flat_map(|index| [of_beam(index), of_horizon(index), of_rays(index % 6)]).flatten();
        assert_eq!(findings.collect::<Vec<_>>(), Vec::<String>::new());
        assert_eq!(of_city(0), Ok(Vec::new()));
    }

    #[test]
    fn a_reach_is_found_to_its_digits() {
        assert!((reach(|z| z < 3e-13) - 3e-13).abs() < 1e-21);
        assert_eq!(reach(|_| true), 0.1);
    }
}
