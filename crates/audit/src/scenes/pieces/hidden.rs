//! A point's view of clusters, and light that no node of an element sees.

use std::f64::consts::PI;

use glam::DVec3;
use radgrad_core::{Emission, Emitter, Polygon, Receiver, Tolerance, evaluate_value};
use radgrad_scene::{Scene, largest, smallest};
use radgrad_solver::{Element, Mesh, parts};

use super::{FINE, Wrong, exceeds, is_hidden, named, scene_of, turned, unit, within};
use crate::cases::sampler::Sampler;
use crate::scenes::draw::quad;

/// A body that is convex: an octahedron cut four times finer twice, its corners on an ellipsoid, seen from inside. Every face sees every other.
fn body(s: &mut Sampler) -> Vec<Vec<DVec3>> {
    let axes = DVec3::new(s.between(0.5, 2.0), s.between(0.5, 2.0), s.between(0.5, 2.0));
    let mut triangles: Vec<[DVec3; 3]> = Vec::new();
    for z in [DVec3::Z, DVec3::NEG_Z] {
        let rim = [DVec3::X, DVec3::Y, DVec3::NEG_X, DVec3::NEG_Y];
        let of = |i: usize| if z.z > 0.0 { [z, rim[(i + 1) % 4], rim[i]] } else { [z, rim[i], rim[(i + 1) % 4]] };
        triangles.extend((0..4).map(of));
    }
    for _ in 0..2 {
        let cut = |[a, b, c]: [DVec3; 3]| {
            let middle = |p: DVec3, q: DVec3| (p + q).normalize();
            let [ab, bc, ca] = [middle(a, b), middle(b, c), middle(c, a)];
            [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
        };
        triangles = triangles.into_iter().flat_map(cut).collect();
    }
    triangles.into_iter().map(|corners| corners.map(|p| p * axes).to_vec()).collect()
}

/// Shards that face about one way, about the origin. They may hide each other, which bounds do not count.
fn shards(s: &mut Sampler) -> Vec<Vec<DVec3>> {
    let way = s.direction();
    let shard = |_| {
        let (place, facing) = (s.cube(), (way + s.cube()).normalize_or(way));
        let (u, v) = facing.any_orthonormal_pair();
        vec![place, place + u * s.between(0.05, 0.5), place + v * s.between(0.05, 0.5)]
    };
    (0..24).map(shard).collect()
}

/// A stump of a pyramid on a polygon of six sides, seen from inside: its faces are of several elements each.
fn stump(s: &mut Sampler) -> Vec<Vec<DVec3>> {
    let corner = |k: u32| {
        let angle = std::f64::consts::TAU * f64::from(k) / 6.0;
        DVec3::new(angle.cos() * 1.3, angle.sin(), 0.0)
    };
    let (base, part, up) =
        ((0..6).map(corner).collect::<Vec<_>>(), s.between(0.4, 0.8), DVec3::new(0.1, 0.2, s.between(0.6, 1.2)));
    let top: Vec<DVec3> = base.iter().map(|p| *p * part + up).collect();
    let mut faces: Vec<Vec<DVec3>> =
        (0..6).map(|i| (i, (i + 1) % 6)).map(|(i, j)| vec![base[j], base[i], top[i], top[j]]).collect();
    faces.push(base);
    faces.push(top.into_iter().rev().collect());
    faces
}

/// Rays from a point for its views.
const RAYS: usize = 64;

/// Findings on views of clusters, from points in bodies, about shards and in stumps by turns.
#[must_use]
pub fn views(cases: u64) -> Vec<String> {
    let mut findings = Vec::new();
    let mut sum = [0.0; 2];
    for index in 0..cases {
        findings.extend(named("view", index, views_of(index, &mut sum)));
    }
    let [squares, count] = sum;
    if !(0.05..=1.2).contains(&(squares / count)) {
        findings.push(format!("views by rays are off by {:e} of their deviations in the mean square", squares / count));
    }
    findings
}

fn views_of(index: u64, sum: &mut [f64; 2]) -> Wrong {
    let s = &mut Sampler::new(20, "views", index);
    let is_body = index % 4 != 1;
    let faces = match index % 4 {
        1 => shards(s),
        3 => stump(s),
        _ => body(s),
    };
    let scene = scene_of(faces.clone())?;
    let mesh = Mesh::new(&scene, 0).map_err(|error| error.to_string())?;
    let (elements, some) = (mesh.elements(), u32::try_from(faces.len()).unwrap_or(1));
    let middle = faces.iter().flatten().sum::<DVec3>() / faces.iter().flatten().count() as f64;
    let some_corner = |s: &mut Sampler| faces[s.below(some) as usize][s.below(3) as usize];
    let inside = |s: &mut Sampler| ((0..4).map(|_| some_corner(s)).sum::<DVec3>() * 0.25).lerp(middle, 0.2);
    let outside = |s: &mut Sampler| s.direction() * s.between(0.5, 4.0);
    let place = |s: &mut Sampler| if is_body { inside(s) } else { outside(s) };
    let receivers: Result<Vec<Receiver>, _> =
        (0..if is_body { 4 } else { 12 }).map(|_| Receiver::new(place(s), s.direction(), 1.0)).collect();
    let receivers = receivers.map_err(|error| error.to_string())?;
    let lamp = |element: &Element| Emitter::new(element.polygon().clone(), Emission::Constant(1.0));
    let lamps: Result<Vec<Emitter>, _> = elements.iter().map(lamp).collect();
    let lamps = lamps.map_err(|error| error.to_string())?;
    let mut findings = Vec::new();
    let said = |error: radgrad_solver::Error| error.to_string();
    let views = parts::views(&scene, &receivers, RAYS).map_err(said)?;
    // Twice as large, or far smaller, from places as much farther away: the same rays.
    for power in [2.0, unit(2)] {
        let other = scene_of(faces.iter().map(|corners| corners.iter().map(|p| *p * power).collect()).collect())?;
        let receiver = Receiver::new(receivers[0].position() * power, receivers[0].normal(), 1.0);
        let again = parts::views(&other, &[receiver.map_err(|error| error.to_string())?], RAYS).map_err(said)?;
        if again[0].iter().zip(&views[0]).any(|(again, view)| again.sampled != view.sampled || again.bounds != view.bounds) {
            findings.push(format!("views of a scene {power} times as large are others"));
        }
    }
    if is_body && index > 1 {
        findings.extend(single_rays(&scene, &receivers[0], &lamps)?);
    }
    for (receiver, views) in receivers.iter().zip(views) {
        let tolerance = Tolerance { relative: 0.0, absolute: FINE };
        let factor = |lamp: &Emitter| evaluate_value(receiver, lamp, [], tolerance).map(|value| value.radiosity);
        let factors: Vec<f64> = lamps.iter().map(factor).collect::<Result<_, _>>().map_err(|error| error.to_string())?;
        for view in views {
            let (truth, count) = (view.elements.iter().map(|&element| factors[element]).sum::<f64>(), view.elements.len());
            let area: f64 = view.elements.iter().map(|&element| elements[element].area()).sum();
            let kernel = |&element: &usize| {
                let polygon = lamps[element].polygon();
                let r = elements[element].centre() - receiver.position();
                let (over, toward) = (receiver.normal().dot(r), -polygon.normal().dot(r));
                if over > 0.0 && toward > 0.0 { over * toward / (PI * r.length_squared() * r.length_squared()) } else { 0.0 }
            };
            let peak = view.elements.iter().map(kernel).fold(0.0, largest) * area;
            let [bound, most] = view.bounds;
            if exceeds(truth, bound * (1.0 + 1e-12) + 1e-12)
                || exceeds(peak, most * (1.0 + 1e-12))
                || exceeds(bound, most * (1.0 + 1e-12))
            {
                findings.push(format!(
                    "of {count} faces the factor is {truth:e}, the kernel {peak:e}, the bounds {bound:e}, {most:e}"
                ));
            }
            // What is behind gives nothing; as much as all is said of nothing that is small and far away.
            let corners = |element: usize| elements[element].polygon().vertices().iter();
            let nearest =
                |element: usize| corners(element).map(|p| p.distance(receiver.position())).fold(f64::INFINITY, smallest);
            if count == 1 && nearest(view.elements[0]) > 4.0 * area.sqrt() && bound > 4.0 * truth + 2.0 * area / PI {
                findings.push(format!("of a face the factor is {truth:e}, the bound {bound:e}"));
            }
            let [value, off] = view.sampled;
            // Rays that end on a part of all, as often as tosses of a coin.
            let (hits, rays) = (value * RAYS as f64, RAYS as f64);
            let deviation = (hits * (1.0 - hits / rays)).sqrt() / rays;
            if hits > 0.0 && hits < rays && exceeds((off - deviation).abs(), 1e-12) {
                findings.push(format!("{hits} of {rays} rays have the deviation {deviation:e}, said {off:e}"));
            }
            // A cluster that no ray met is as uncertain as one that a ray is likely to meet.
            if hits == 0.0 && exceeds(smallest(1.0, rays * truth).sqrt() / rays, off + 1e-12) {
                findings.push(format!("no ray of {rays} meets {truth}, said to {off}"));
            }
            if bound == 0.0 {
                if value != 0.0 || off != 0.0 || truth > 1e-12 {
                    findings.push(format!("what is behind is seen: {value:e}, {off:e}"));
                }
            } else if is_body && count > 4 && RAYS as f64 * truth > 4.0 && off > 0.0 && count < elements.len() {
                sum[0] += ((value - truth) / off).powi(2);
                sum[1] += 1.0;
            } else if is_body && count == elements.len() && (value - 1.0).abs() > 1e-12 {
                findings.push(format!("of rays {value} end on the body around"));
            }
        }
    }
    Ok(findings)
}

/// Places about a receiver, each of which sends one ray.
const SINGLE: u32 = 200;

/// Findings on views by single rays from many places: in the mean they are neither too much nor too little.
fn single_rays(scene: &Scene, receiver: &Receiver, lamps: &[Emitter]) -> Wrong {
    let said = |error: radgrad_core::Error| error.to_string();
    let near = |k: u32| receiver.position() + DVec3::new(0.618, 0.414, 0.732) * (1e-6 * f64::from(k));
    let places: Vec<Receiver> =
        (0..SINGLE).map(|k| Receiver::new(near(k), receiver.normal(), 1.0)).collect::<Result<_, _>>().map_err(said)?;
    let tolerance = Tolerance { relative: 0.0, absolute: 1e-9 };
    let factor = |lamp: &Emitter| evaluate_value(receiver, lamp, [], tolerance).map(|value| value.radiosity);
    let factors: Vec<f64> = lamps.iter().map(factor).collect::<Result<_, _>>().map_err(said)?;
    let views = parts::views(scene, &places, 1).map_err(|error| error.to_string())?;
    let mut findings = Vec::new();
    for cluster in (0..views[0].len()).filter(|&cluster| views[0][cluster].elements.len() < lamps.len()) {
        let truth: f64 = views[0][cluster].elements.iter().map(|&element| factors[element]).sum();
        let mean = views.iter().map(|views| views[cluster].sampled[0]).sum::<f64>() / f64::from(SINGLE);
        if truth > 0.1 && exceeds((mean - truth).abs(), 4.5 * (truth * (1.0 - truth) / f64::from(SINGLE)).sqrt() + 1e-9) {
            findings.push(format!("of single rays {mean} end where {truth} ought to"));
        }
    }
    Ok(findings)
}

/// Findings on bounds on light that no node of an element sees, in so many rooms.
#[must_use]
pub fn unseen(cases: u64) -> Vec<String> {
    let mut findings = Vec::new();
    let mut hidden = 0;
    for index in 0..cases {
        if index < 8 {
            findings.extend(named("unit", index, in_another_unit(index)));
        }
        match unseen_of(index) {
            Ok((wrong, count)) => {
                findings.extend(wrong.into_iter().map(|what| format!("unseen {index}: {what}")));
                hidden += count;
            }
            Err(why) => findings.push(format!("unseen {index}: {why}")),
        }
    }
    if hidden == 0 {
        findings.push("no light is hidden from the nodes of an element and seen elsewhere on it".to_owned());
    }
    findings
}

/// A lamp over a floor beside a wall, and things between them.
fn furnished(index: u64, s: &mut Sampler) -> Vec<Vec<DVec3>> {
    let (x, y, z) = (DVec3::X, DVec3::Y, DVec3::Z);
    let size = s.between(0.05, 0.6);
    let height = s.between(0.4, 2.0);
    let lamp = DVec3::new(s.between(0.0, 1.0), s.between(0.0, 1.0), height);
    let mut faces = vec![quad(lamp, y * size, x * size)];
    faces.push(quad(DVec3::ZERO, x, y));
    faces.push(vec![DVec3::new(-0.5, 0.0, 0.0), DVec3::new(-0.5, 1.0, 0.0), DVec3::new(-0.5, 0.4, 1.5)]);
    // A plate that hangs, a box that stands or hangs, and a shade around the lamp, or some of these.
    let kind = 1 + index % 7;
    if kind & 1 > 0 {
        let corner = DVec3::new(s.between(-0.2, 0.6), s.between(-0.2, 0.6), s.between(0.1, 0.9) * height);
        let (u, v) =
            (DVec3::new(s.between(0.2, 0.8), 0.1, 0.0), DVec3::new(0.0, s.between(0.2, 0.8), 0.1 * s.between(-1.0, 1.0)));
        faces.push(quad(corner, u, v));
        faces.push(quad(corner, v, u));
    }
    if kind & 2 > 0 {
        let low = DVec3::new(s.between(0.0, 0.5), s.between(0.0, 0.5), if s.one_in(2) { 0.0 } else { 0.1 * height });
        let high = low + DVec3::new(s.between(0.2, 0.4), s.between(0.2, 0.4), s.between(0.2, 0.7) * height);
        let d = high - low;
        let (u, v, w) = (x * d.x, y * d.y, z * d.z);
        faces.extend([quad(low + w, u, v), quad(low, u, w), quad(low + v, w, u), quad(low, w, v), quad(low + u, v, w)]);
    }
    if kind & 4 > 0 {
        let deep = z * (s.between(0.1, 0.6) * height);
        let (u, v) = (x * size, y * size);
        let foot = lamp - deep;
        faces.extend([quad(foot, u, deep), quad(foot + v, deep, u), quad(foot, deep, v), quad(foot + u, v, deep)]);
    }
    faces
}

/// The mesh of faces, in every other case divided once beside the first one.
fn divided(faces: Vec<Vec<DVec3>>, s: &mut Sampler) -> Result<Mesh, String> {
    let said = |error: radgrad_solver::Error| error.to_string();
    let mut mesh = Mesh::new(&scene_of(faces)?, 0).map_err(said)?;
    if s.one_in(2) {
        for root in mesh.roots().to_vec() {
            if mesh.elements()[root].face() > 0 {
                mesh.divide(root).map_err(said)?;
            }
        }
    }
    Ok(mesh)
}

/// Elements that a lamp may be hidden from in part as the solver says, and those for which samples say so.
#[derive(Debug, Default)]
struct Partly {
    said: usize,
    sampled: usize,
}

/// Findings on which elements see a lamp whole, in part or not at all, in so many rooms.
#[must_use]
pub fn sights(cases: u64) -> Vec<String> {
    let (mut findings, mut partly) = (Vec::new(), Partly::default());
    for index in 0..cases {
        findings.extend(named("sight", index, sights_of(index, &mut partly)));
    }
    let Partly { said, sampled } = partly;
    // Where outlines are near a beam some are said to cut it that do not: two elements in three that are named are cut.
    if 50 * said > 76 * sampled || sampled == 0 {
        findings.push(format!("{said} elements are said to see a part of a lamp, {sampled} do by samples"));
    }
    for (name, told) in [("a crossed lamp", crossed_lamp()), ("a foot", foot_in_plane()), ("a fold", folded())] {
        findings.extend(named(name, 0, told));
    }
    findings
}

/// Findings on a face that is folded within its precision: no half of it sees the other.
fn folded() -> Wrong {
    let said = |error: radgrad_scene::Error| error.to_string();
    let mut findings = Vec::new();
    // One of them is hollow, whichever diagonal is taken.
    for lift in [0.02, -0.02] {
        let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.2, 1.0, lift], [0.0, 1.0, 0.0]].map(DVec3::from).to_vec();
        let polygon = Polygon::from_rounded(corners, 0.05).map_err(|error| error.to_string())?;
        let mut scene = Scene::new(["grey"]).map_err(said)?;
        let (grey, surface) = (scene.add_material("grey", [0.5], [0.0]).map_err(said)?, scene.add_surface("all"));
        scene.add_face(surface, grey, polygon, None).map_err(said)?;
        let mesh = Mesh::new(&scene, 0).map_err(|error| error.to_string())?;
        let seen = parts::unseen(&mesh, 0).into_iter().filter(|(_, bound)| *bound != Some([0.0; 2]));
        findings.extend(seen.map(|(element, bound)| format!("lifted by {lift}, element {element} sees its own face: {bound:?}")));
        if mesh.roots().len() != 2 {
            findings.push(format!("a face lifted by {lift} has {} elements", mesh.roots().len()));
        }
    }
    Ok(findings)
}

/// Findings on light that no node sees in a unit that is far larger: every digit stays.
fn in_another_unit(index: u64) -> Wrong {
    let faces = furnished(index, &mut Sampler::new(21, "unseen", index));
    let smaller = faces.iter().map(|corners| corners.iter().map(|p| *p * unit(2)).collect()).collect();
    let unseen = |faces: Vec<Vec<DVec3>>| -> Result<_, String> {
        let mesh = Mesh::new(&scene_of(faces)?, 0).map_err(|error| error.to_string())?;
        Ok(parts::unseen(&mesh, 0))
    };
    let [before, after] = [unseen(faces)?, unseen(smaller)?];
    let apart = before.iter().zip(&after).filter(|(before, after)| before != after);
    Ok(apart.map(|(before, after)| format!("light that no node sees is {before:?}, in another unit {after:?}")).collect())
}

/// Pairs of a point of an element and one of the lamp between which it is asked what is there.
const PAIRS: u32 = 48;

fn sights_of(index: u64, partly: &mut Partly) -> Wrong {
    let s = &mut Sampler::new(27, "sights", index);
    let mut faces = furnished(index, s);
    if s.one_in(2) {
        faces[0].truncate(3);
    }
    // Plates that cross the floor, the wall, the lamp and each other, some wide enough to part what is before them from what is behind.
    for _ in 0..s.below(4) {
        let height = if s.one_in(3) { faces[0][0].z } else { s.between(0.0, 0.3) };
        let middle = DVec3::new(s.between(-0.6, 0.9), s.between(0.1, 0.9), height);
        let u = s.cube() * if s.one_in(2) { 3.0 } else { 0.5 };
        let v = s.perpendicular(u.normalize_or(DVec3::X)) * s.between(0.2, 0.6);
        let plate = vec![middle - u - v, middle + u - v, middle + u + v, middle - u + v];
        faces.push(plate.iter().rev().copied().collect());
        faces.push(plate);
    }
    let (turn, offset, unit) = (turned(s), s.cube() * 3.0, unit(index));
    let faces = faces.into_iter().map(|corners| corners.into_iter().map(|p| (turn(p) + offset) * unit).collect()).collect();
    let mesh = divided(faces, s)?;
    let (mut findings, level) = (misplaced_feet(&mesh, unit), 1e-9 * unit);
    for (element, bound) in parts::unseen(&mesh, 0) {
        let (to, from) = (&mesh.elements()[element], &mesh.elements()[0]);
        let screens = || (1..mesh.polygons().len()).filter(|&face| face != to.face()).map(|face| &mesh.polygons()[face]);
        let (mut free, mut hidden) = (0, 0);
        for _ in 0..PAIRS {
            let [x, y] = [to, from].map(|element| element.point(within(element.shape(), s)));
            if to.polygon().normal().dot(y - x) > level && from.polygon().normal().dot(x - y) > level {
                // What lies in the plane of an end, as the back of a plate does, is beside it.
                let is_level = |p: DVec3, screen: &Polygon| screen.normal().dot(p - screen.vertices()[0]).abs() <= level;
                let hides = |screen: &Polygon| !is_level(x, screen) && !is_level(y, screen) && is_hidden(x, y, screen);
                *if screens().any(hides) { &mut hidden } else { &mut free } += 1;
            }
        }
        let is_partly = free > 0 && hidden > 0;
        match bound {
            None if hidden > 0 => findings.push(format!("something is between the lamp and element {element}, nothing is said")),
            Some([0.0, _]) if is_partly => {
                findings.push(format!("of {PAIRS} looks from element {element} to the lamp {free} are free, {hidden} are not"));
            }
            Some([most, _]) if most > 0.0 => partly.said += 1,
            _ => {}
        }
        partly.sampled += usize::from(is_partly);
    }
    Ok(findings)
}

/// Findings on a lamp that a large plate crosses near a side: the floor sees a part of the lamp, though no edge of the plate lies before it.
fn crossed_lamp() -> Wrong {
    let (x, y, z) = (DVec3::X, DVec3::Y, DVec3::Z);
    let mut faces = vec![quad(DVec3::new(0.0, 0.35, 1.0), y * 0.3, x * 0.3)];
    faces.push(quad(DVec3::new(-0.5, 0.0, 0.0), x * 0.7, y));
    let plate = quad(DVec3::new(0.29, -5.0, -5.0), y * 10.0, z * 8.0);
    faces.push(plate.iter().rev().copied().collect());
    faces.push(plate);
    let mesh = Mesh::new(&scene_of(faces)?, 0).map_err(|error| error.to_string())?;
    let of_floor = parts::unseen(&mesh, 0).into_iter().filter(|(element, _)| mesh.elements()[*element].face() == 1);
    let wrong = of_floor.filter(|(_, bound)| !bound.is_some_and(|[most, _]| most > 0.0));
    Ok(wrong.map(|(element, bound)| format!("a plate crosses the lamp, element {element} is said to see {bound:?}")).collect())
}

/// Findings on the foot of a wall that ends a little above the floor, or below it: it is in the floor's plane.
fn foot_in_plane() -> Wrong {
    let floor = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]].map(|[x, y]| DVec3::new(x, y, 0.0)).to_vec();
    let mut findings = Vec::new();
    for gap in [2e-10, -2e-10] {
        let wall = [[0.2, gap], [0.8, gap], [0.8, 0.5], [0.2, 0.5]].map(|[x, z]| DVec3::new(x, 0.4, z)).to_vec();
        let mesh = Mesh::new(&scene_of(vec![floor.clone(), wall])?, 0).map_err(|error| error.to_string())?;
        let feet: Vec<[DVec3; 2]> =
            parts::feet(&mesh).into_iter().filter(|(on, foot, _)| (*on, *foot) == (0, 1)).map(|(_, _, ends)| ends).collect();
        if feet.len() != 1 || feet.iter().flatten().any(|p| p.z.abs() > 1e-15) {
            findings.push(format!("a wall {gap:e} over the floor stands on it in {feet:?}"));
        }
    }
    Ok(findings)
}

/// Findings on the segments in which faces cross or stand on each other, of faces that are convex: against the parts of the line of their planes
/// in both.
fn misplaced_feet(mesh: &Mesh, unit: f64) -> Vec<String> {
    let (feet, polygons) = (parts::feet(mesh), mesh.polygons());
    let mut findings = Vec::new();
    for (on, other) in (0..polygons.len()).flat_map(|on| (0..polygons.len()).map(move |other| (on, other))) {
        let (below, above) = (&polygons[on], &polygons[other]);
        let [height, other_height] = [below, above].map(|face| move |p: DVec3| face.normal().dot(p - face.vertices()[0]));
        let along = below.normal().cross(above.normal());
        let highest = above.vertices().iter().map(|&p| height(p)).fold(f64::NEG_INFINITY, largest);
        // Faces that are nearly in one plane, and those below, are left out.
        if along.length() < 0.05 || highest < 0.01 * unit {
            continue;
        }
        let across = along.cross(below.normal()).normalize();
        let start = below.vertices()[0];
        let start = start - across * (other_height(start) / above.normal().dot(across));
        let along = along.normalize();
        let mut range = [f64::NEG_INFINITY, f64::INFINITY];
        for face in [below, above] {
            let v = face.vertices();
            for (i, &a) in v.iter().enumerate() {
                let inward = face.normal().cross(v[(i + 1) % v.len()] - a).normalize();
                let (slope, level) = (inward.dot(along), inward.dot(start - a));
                // The sides of either cut off a ray of the line; one along it all or nothing.
                if slope.abs() < 1e-9 {
                    range[1] = if level < -1e-9 * unit { f64::NEG_INFINITY } else { range[1] };
                } else if slope > 0.0 {
                    range[0] = largest(range[0], -level / slope);
                } else {
                    range[1] = smallest(range[1], -level / slope);
                }
            }
        }
        let ends = range.map(|share| start + along * share);
        let said = feet.iter().find(|(face, foot, _)| *face == on && *foot == other).map(|(.., [a, b])| [*a, *b]);
        let is_there = range[1] - range[0] > 1e-3 * unit;
        let is_it = |[a, b]: [DVec3; 2]| {
            let apart = |p: DVec3, q: DVec3| p.distance(ends[0]) + q.distance(ends[1]);
            smallest(apart(a, b), apart(b, a)) <= 1e-6 * unit
        };
        if is_there && !said.is_some_and(is_it) || range[1] < range[0] - 1e-3 * unit && said.is_some() {
            findings.push(format!("face {other} is on face {on} at {range:?} from {start} along {along}, said {said:?}"));
        }
    }
    findings
}

/// With how many elements get light of a lamp that no node of them sees.
fn unseen_of(index: u64) -> Result<(Vec<String>, usize), String> {
    let s = &mut Sampler::new(21, "unseen", index);
    let faces = furnished(index, s);
    let mesh = divided(faces, s)?;
    let lamp = Emitter::new(mesh.polygons()[0].clone(), Emission::Constant(1.0)).map_err(|error| error.to_string())?;
    let (mut findings, mut hidden) = (Vec::new(), 0);
    for (element, bound) in parts::unseen(&mesh, 0) {
        let (Some([most, mean]), of) = (bound, &mesh.elements()[element]) else { continue };
        let screens: Vec<&Polygon> =
            (1..mesh.polygons().len()).filter(|&face| face != of.face()).map(|face| &mesh.polygons()[face]).collect();
        let light = |at: [f64; 2]| -> Result<f64, String> {
            let receiver = Receiver::new(of.point(at), of.polygon().normal(), 1.0).map_err(|error| error.to_string())?;
            let tolerance = Tolerance { relative: 0.0, absolute: 1e-9 };
            let value =
                evaluate_value(&receiver, &lamp, screens.iter().copied(), tolerance).map_err(|error| error.to_string())?;
            Ok(largest(value.radiosity - value.radiosity_error, 0.0))
        };
        let nodes = mesh.basis(element).nodes().iter().map(|node| light(node.at)).collect::<Result<Vec<_>, _>>()?;
        if nodes.iter().any(|light| *light > 0.0) {
            continue;
        }
        let at = (0..12).map(|_| light(within(of.shape(), s))).collect::<Result<Vec<_>, _>>()?;
        let brightest = at.iter().copied().fold(0.0, largest);
        let sum: f64 = at.iter().sum::<f64>() / at.len() as f64;
        hidden += usize::from(brightest > 1e-6);
        if exceeds(brightest, most * (1.0 + 1e-9) + 1e-8) || exceeds(mean, most) || exceeds(sum, 3.0 * mean + 1e-8) {
            findings
                .push(format!("on element {element} there is {brightest:e}, {sum:e} in the mean, said {most:e} and {mean:e}"));
        }
    }
    Ok((findings, hidden))
}
