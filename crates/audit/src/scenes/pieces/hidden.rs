//! A point's view of clusters, and light that no node of an element sees.

use std::f64::consts::PI;

use glam::DVec3;
use radgrad_core::{Emission, Emitter, Polygon, Receiver, Tolerance, evaluate_value};
use radgrad_scene::{largest, smallest};
use radgrad_solver::{Mesh, parts};

use super::{FINE, Wrong, exceeds, scene_of, within};
use crate::cases::sampler::Sampler;

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

/// Rays from a point for its views.
const RAYS: usize = 64;

/// Findings on views of clusters, from points in bodies and about shards by turns.
#[must_use]
pub fn views(cases: u64) -> Vec<String> {
    let mut findings = Vec::new();
    let mut sum = [0.0; 2];
    for index in 0..cases {
        match views_of(index, &mut sum) {
            Ok(wrong) => findings.extend(wrong.into_iter().map(|what| format!("view {index}: {what}"))),
            Err(why) => findings.push(format!("view {index}: {why}")),
        }
    }
    let [squares, count] = sum;
    if !(0.05..=1.2).contains(&(squares / count)) {
        findings.push(format!("views by rays are off by {:e} of their deviations in the mean square", squares / count));
    }
    findings
}

fn views_of(index: u64, sum: &mut [f64; 2]) -> Wrong {
    let s = &mut Sampler::new(20, "views", index);
    let is_body = index.is_multiple_of(2);
    let faces = if is_body { body(s) } else { shards(s) };
    let scene = scene_of(faces.clone())?;
    let inside = |s: &mut Sampler| (0..4).map(|_| faces[s.below(128) as usize][s.below(3) as usize] * 0.25).sum::<DVec3>();
    let outside = |s: &mut Sampler| s.direction() * s.between(0.5, 4.0);
    let place = |s: &mut Sampler| if is_body { inside(s) } else { outside(s) };
    let receivers: Result<Vec<Receiver>, _> =
        (0..if is_body { 4 } else { 12 }).map(|_| Receiver::new(place(s), s.direction(), 1.0)).collect();
    let receivers = receivers.map_err(|error| error.to_string())?;
    let lamp = |corners: &Vec<DVec3>| Emitter::new(Polygon::new(corners.clone())?, Emission::Constant(1.0));
    let lamps: Result<Vec<Emitter>, _> = faces.iter().map(lamp).collect();
    let lamps = lamps.map_err(|error| error.to_string())?;
    let mut findings = Vec::new();
    let views = parts::views(&scene, &receivers, RAYS).map_err(|error| error.to_string())?;
    for (receiver, views) in receivers.iter().zip(views) {
        let tolerance = Tolerance { relative: 0.0, absolute: FINE };
        let factor = |lamp: &Emitter| evaluate_value(receiver, lamp, [], tolerance).map(|value| value.radiosity);
        let factors: Vec<f64> = lamps.iter().map(factor).collect::<Result<_, _>>().map_err(|error| error.to_string())?;
        for view in views {
            let truth: f64 = view.faces.iter().map(|&face| factors[face]).sum();
            let area: f64 = view.faces.iter().map(|&face| lamps[face].polygon().area()).sum();
            let kernel = |&face: &usize| {
                let polygon = lamps[face].polygon();
                let r = polygon.vertices().iter().sum::<DVec3>() / 3.0 - receiver.position();
                let (over, toward) = (receiver.normal().dot(r), -polygon.normal().dot(r));
                if over > 0.0 && toward > 0.0 { over * toward / (PI * r.length_squared() * r.length_squared()) } else { 0.0 }
            };
            let peak = view.faces.iter().map(kernel).fold(0.0, largest) * area;
            let [bound, most] = view.bounds;
            if exceeds(truth, bound * (1.0 + 1e-12) + 1e-12)
                || exceeds(peak, most * (1.0 + 1e-12))
                || exceeds(bound, most * (1.0 + 1e-12))
            {
                let count = view.faces.len();
                findings.push(format!(
                    "of {count} faces the factor is {truth:e}, the kernel {peak:e}, the bounds {bound:e}, {most:e}"
                ));
            }
            // What is behind gives nothing; as much as all is said of nothing that is small and far away.
            let nearest =
                |face: &usize| faces[*face].iter().map(|p| p.distance(receiver.position())).fold(f64::INFINITY, smallest);
            if view.faces.len() == 1 && nearest(&view.faces[0]) > 4.0 * area.sqrt() && bound > 4.0 * truth + 2.0 * area / PI {
                findings.push(format!("of a face the factor is {truth:e}, the bound {bound:e}"));
            }
            let [value, off] = view.sampled;
            if bound == 0.0 {
                if value != 0.0 || off != 0.0 || truth > 1e-12 {
                    findings.push(format!("what is behind is seen: {value:e}, {off:e}"));
                }
            } else if is_body && view.faces.len() > 4 && RAYS as f64 * truth > 4.0 && off > 0.0 && view.faces.len() < 128 {
                sum[0] += ((value - truth) / off).powi(2);
                sum[1] += 1.0;
            } else if view.faces.len() == 128 && (value - 1.0).abs() > 1e-12 {
                findings.push(format!("of rays {value} end on the body around"));
            }
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

/// With how many elements get light of a lamp that no node of them sees.
fn unseen_of(index: u64) -> Result<(Vec<String>, usize), String> {
    let s = &mut Sampler::new(21, "unseen", index);
    let quad = |origin: DVec3, u: DVec3, v: DVec3| vec![origin, origin + u, origin + u + v, origin + v];
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
    let scene = scene_of(faces)?;
    let said = |error: radgrad_solver::Error| error.to_string();
    let mut mesh = Mesh::new(&scene, 0).map_err(said)?;
    if s.one_in(2) {
        for root in mesh.roots().to_vec() {
            if mesh.elements()[root].face() > 0 {
                mesh.divide(root).map_err(said)?;
            }
        }
    }
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
