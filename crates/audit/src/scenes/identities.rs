//! Rooms whose light has a closed form: even light, the same materials by values and by textures, and two squares face to face.

use std::f64::consts::PI;

use glam::DVec3;
use radgrad_certificate::{Interval, Place, Request, certify, certify_points};
use radgrad_core::Polygon;
use radgrad_scene::{FactorSettings, FormFactors, Quantity, Scene, Texture};
use radgrad_solver::{Options, Solution, solve};

use super::draw::{cuboid, quad};
use crate::cases::sampler::Sampler;
use crate::measures::measure::is_worse;

type Wrong = Result<Vec<String>, String>;

/// A quadrilateral, its reflectance and the radiosity that it emits.
type Wall = (Vec<DVec3>, f64, f64);

/// A box of a size from inside: its floor, its ceiling and its sides.
fn walls(size: DVec3) -> [Vec<DVec3>; 6] {
    let mut walls = cuboid(DVec3::ZERO, size, true).into_iter();
    std::array::from_fn(|_| walls.next().unwrap_or_default())
}

/// The scene of these walls, its values by materials or by textures of one texel; in a second channel, if there is one, they emit 1 and are black.
fn scene(walls: &[Wall], is_textured: bool, channels: &[&str]) -> Result<Scene, Box<dyn std::error::Error>> {
    let mut scene = Scene::new(channels.iter().copied())?;
    let each = |values: [f64; 2]| values[..channels.len()].to_vec();
    for (corners, reflectance, emitted) in walls {
        add_wall(&mut scene, corners, &[each([*reflectance, 0.0]), each([emitted / PI, 1.0 / PI])], is_textured)?;
    }
    Ok(scene)
}

/// Adds a wall with these values in each channel, by its material or by textures of one texel.
fn add_wall(
    scene: &mut Scene,
    corners: &[DVec3],
    given: &[Vec<f64>; 2],
    is_textured: bool,
) -> Result<(), Box<dyn std::error::Error>> {
    let whole = |values: &Vec<f64>| values.iter().map(|value| if *value > 0.0 { 1.0 } else { 0.0 }).collect();
    let [rho, radiance] = if is_textured { given.each_ref().map(whole) } else { given.clone() };
    let name = scene.faces().len().to_string();
    let material = scene.add_material(name.clone(), rho, radiance)?;
    let surface = scene.add_surface(name);
    let polygon = Polygon::new(corners.to_vec())?;
    if !is_textured {
        scene.add_face(surface, material, polygon, None)?;
        return Ok(());
    }
    for quantity in Quantity::ALL {
        let texture = Texture::new("even", [1, 1], scene.channels().len(), given[quantity as usize].clone())?;
        scene.set_texture(material, quantity, texture)?;
    }
    scene.add_textured_face(surface, material, polygon, &[[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]], None)?;
    Ok(())
}

fn solved(walls: &[Wall], is_textured: bool, options: &Options) -> Result<(Scene, Solution), String> {
    let scene = scene(walls, is_textured, &["grey"]).map_err(|error| error.to_string())?;
    let solution = solve(&scene, options, |_| true).map_err(|error| error.to_string())?;
    Ok((scene, solution))
}

/// Even light by certificates: whatever glows and reflects together like a black body of radiosity 1 has that everywhere, by textures too.
fn even(index: u64) -> Wrong {
    let s = &mut Sampler::new(71, "even", index);
    let size = DVec3::new(s.between(0.5, 2.0), s.between(0.5, 2.0), s.between(0.5, 2.0));
    let walls = walls(size).map(|corners| {
        let rho = s.between(0.1, 0.9);
        (corners, rho, 1.0 - rho)
    });
    let mut findings = Vec::new();
    let floor = Place { position: DVec3::new(0.3, 0.4, 0.0) * size, normal: DVec3::Z, face: Some(0) };
    for is_textured in [false, true] {
        let scene = scene(&walls, is_textured, &["grey", "black"]).map_err(|error| error.to_string())?;
        let request = Request { width: 0.05, rays: 4_000, seed: index, delta: 1e-6 };
        let certificate = certify(&scene, &request).map_err(|error| error.to_string())?;
        if !certificate.mean.iter().all(|limits| limits.contains(1.0)) {
            findings.push(format!("even light by textures ({is_textured}) has the certificate {:?}", certificate.mean));
        }
        let points = certify_points(&scene, &[floor], &Request { rays: 500, ..request }).map_err(|error| error.to_string())?;
        for point in points {
            let point = point.map_err(|error| error.to_string())?;
            let radiosity = point.radiosity.iter().flatten().all(|limits| limits.contains(1.0));
            if !radiosity || !point.irradiance.iter().all(|limits| limits.contains(1.0)) {
                findings.push(format!("in even light by textures ({is_textured}) a point has {point:?}"));
            }
        }
    }
    Ok(findings)
}

/// A room with a lamp: the surfaces have the mean of the scene, each emits its radiosity less the reflected part, and a black one reflects nothing.
fn surfaces(index: u64) -> Wrong {
    let s = &mut Sampler::new(72, "surfaces", index);
    let size = DVec3::new(s.between(0.5, 2.0), 1.0, s.between(0.5, 2.0));
    let mut room: Vec<Wall> = walls(size).map(|corners| (corners, s.between(0.1, 0.9), 0.0)).to_vec();
    room[s.below(6) as usize].1 = 0.0;
    let [_, ceiling, ..] = walls(size);
    let panel = ceiling.into_iter().map(|p| size * DVec3::new(0.4, 0.4, 0.05) + p * DVec3::new(0.2, 0.2, 0.9)).collect();
    room.push((panel, 0.3, s.between(1.0, 4.0)));
    let options = Options { error: 0.02, first_elements: 6, most_elements: 60, ..Options::default() };
    let mut findings = Vec::new();
    let mut means = Vec::new();
    for is_textured in [false, true] {
        let (scene, solution) = solved(&room, is_textured, &options)?;
        let by_surface = solution.by_surface(&scene);
        let total: f64 = by_surface.iter().map(|surface| surface.area).sum();
        let mean = by_surface.iter().map(|surface| surface.area * surface.mean[0]).sum::<f64>() / total;
        if is_worse((mean - solution.mean()[0]).abs(), 1e-9 * mean) {
            findings.push(format!("surfaces have the mean {mean:e}, the scene {:e}", solution.mean()[0]));
        }
        // On an edge and in a corner of the floor light is the same as beside them.
        for place in [DVec3::new(0.4, 0.0, 0.0), DVec3::new(0.0, 0.7, 0.0), DVec3::ZERO] {
            let beside = place + (DVec3::new(0.5, 0.5, 0.0) - place) * 1e-5;
            let radiosity = |place: DVec3| solution.gather(place * size, DVec3::Z).map(|gathered| gathered.radiosity[0]);
            let [edge, beside] = [radiosity(place), radiosity(beside)].map(|of| of.map_err(|error| error.to_string()));
            let (edge, beside) = (edge?, beside?);
            if is_worse((edge - beside).abs(), 5e-2 * beside) {
                findings.push(format!("at {place} of the floor there is {edge:e}, beside it {beside:e}"));
            }
        }
        for (surface, (_, rho, emitted)) in by_surface.iter().zip(&room) {
            let error = (surface.mean[0] - surface.reflected[0] - emitted).abs();
            if is_worse(error, 1e-9 * mean) || (*rho == 0.0 && is_worse(surface.reflected[0].abs(), 1e-9 * mean)) {
                findings.push(format!("a surface of reflectance {rho} that emits {emitted} has {surface:?}"));
            }
        }
        means.push((mean, solution.mean_estimate()[0].total()));
    }
    let [(plain, off), (textured, other)] = means[..] else { return Ok(findings) };
    if is_worse((plain - textured).abs(), off + other + 1e-9 * plain) {
        findings.push(format!("the mean is {plain:e}, by textures {textured:e}, the estimates are {off:e} and {other:e}"));
    }
    Ok(findings)
}

/// Unit squares face to face that reflect half and emit 1: the radiosity in the middle of one and in its corner (an expansion of the integral
/// equation, to 15 digits).
const FACING: [([f64; 2], f64); 2] = [([0.5, 0.5], 1.133_303_564_992_420_8), ([0.0, 0.0], 1.076_981_393_145_044_5)];

/// Gathers of rough solutions: their errors are within twice the estimates, and below those of the polynomials that they gather.
fn gathered(degree: usize) -> Wrong {
    let [floor, ceiling, ..] = walls(DVec3::ONE);
    let faces = [floor, ceiling].map(|wall| (wall, 0.5, 1.0));
    let mut findings = Vec::new();
    for elements in [1, 8] {
        let options =
            Options { error: 1.0, degree: Some(degree), first_elements: elements, most_elements: elements, ..Options::default() };
        let (_, solution) = solved(&faces, false, &options)?;
        let (mut errors, mut rough) = (0.0, 0.0);
        for ([x, y], exact) in FACING {
            let point = DVec3::new(x, y, 0.0);
            let answer = solution.gather(point, DVec3::Z).map_err(|error| error.to_string())?;
            let (error, estimate) = ((answer.radiosity[0] - exact).abs(), answer.estimate[0].total());
            if is_worse(error, 2.0 * estimate + 1e-12) {
                findings.push(format!(
                    "degree {degree}, {elements} elements: a gather is off by {error:e}, estimated to {estimate:e}"
                ));
            }
            let polynomial = solution.value_on(answer.leaf, 0, solution.mesh().elements()[answer.leaf].reference(point));
            (errors, rough) = (errors + error, rough + (polynomial - exact).abs());
        }
        if is_worse(errors, 0.5 * rough) {
            findings
                .push(format!("degree {degree}, {elements} elements: gathers are off by {errors:e}, polynomials by {rough:e}"));
        }
    }
    Ok(findings)
}

/// A box of grey walls under a glowing ceiling, and in a second channel, of that reflectance, without light.
fn lit_in_one_channel(size: DVec3, other: f64) -> Result<Scene, Box<dyn std::error::Error>> {
    let mut scene = Scene::new(["lit", "dark"])?;
    let surface = scene.add_surface("every");
    for (index, corners) in walls(size).into_iter().enumerate() {
        let radiance = if index == 1 { 1.0 } else { 0.0 };
        let material = scene.add_material(index.to_string(), [0.5, other], [radiance, 0.0])?;
        scene.add_face(surface, material, Polygon::new(corners)?, None)?;
    }
    Ok(scene)
}

/// A room with light in one channel alone: in the other one there is none, and no doubt of it.
fn half_dark() -> Wrong {
    let scene = lit_in_one_channel(DVec3::new(1.0, 1.5, 1.0), 0.7).map_err(|error| error.to_string())?;
    let options = Options { error: 0.1, first_elements: 1, most_elements: 12, ..Options::default() };
    let solution = solve(&scene, &options, |_| true).map_err(|error| error.to_string())?;
    let mut findings = Vec::new();
    for leaf in solution.mesh().leaves() {
        let [lit, dark] =
            [0, 1].map(|channel| [solution.value_on(leaf, channel, [0.4; 2]), solution.estimate_on(leaf)[channel].total()]);
        if dark != [0.0; 2] || !(lit[0] > 0.0 && lit[1] > 0.0) {
            findings.push(format!("in the dark channel leaf {leaf} has {dark:?}, in the lit one {lit:?}"));
        }
    }
    Ok(findings)
}

/// A point that rounding has put beside its face is on it, and one far beside is not.
fn beside(size: f64) -> Wrong {
    let [floor, ceiling, ..] = walls(DVec3::splat(size));
    let scene = scene(&[(floor, 0.5, 0.0), (ceiling, 0.5, 1.0)], false, &["grey"]).map_err(|error| error.to_string())?;
    let request = Request { width: 0.5, rays: 500, seed: 3, delta: 1e-3 };
    let mut findings = Vec::new();
    for (distance, is_on) in [(1e-9, true), (-1e-9, true), (1e-4, false)] {
        for (along, outward) in [(DVec3::X, -DVec3::Y), (DVec3::Y, -DVec3::X), (DVec3::new(2.0, 1.0, 0.0), DVec3::X)] {
            // At the middle of an edge.
            let position = (along * 0.5 + outward * distance) * size;
            let place = Place { position, normal: DVec3::Z, face: Some(0) };
            let points = certify_points(&scene, &[place], &request).map_err(|error| error.to_string())?;
            if points[0].is_ok() != is_on {
                findings.push(format!("{position} beside the floor: {:?}", points[0]));
            }
        }
    }
    Ok(findings)
}

/// In a channel without light there is none, also where nothing is absorbed.
fn dark_and_white() -> Wrong {
    let scene = lit_in_one_channel(DVec3::ONE, 1.0).map_err(|error| error.to_string())?;
    let request = Request { width: 0.2, rays: 2_000, seed: 5, delta: 1e-3 };
    let certificate = certify(&scene, &request).map_err(|error| error.to_string())?;
    let [lit, dark] = [certificate.reflected[0], certificate.reflected[1]];
    let holds = dark.upper == 0.0 && lit.lower > 0.0 && lit.upper.is_finite();
    Ok((!holds).then(|| format!("a white channel without light has {dark:?}, the other one {lit:?}")).into_iter().collect())
}

/// The faces of a convex block do not see each other: walks on it end, though it absorbs nothing.
fn white_block() -> Wrong {
    let corners = [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z];
    let faces = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]].map(|face| (face.map(|k| corners[k]).to_vec(), 1.0, 0.0));
    let lamp = [[-2.0, -2.0], [-2.0, 2.0], [2.0, 2.0], [2.0, -2.0]].map(|[x, y]| DVec3::new(x, y, 3.0)).to_vec();
    let mut walls = faces.to_vec();
    walls.push((lamp, 0.0, 1.0));
    let scene = scene(&walls, false, &["grey"]).map_err(|error| error.to_string())?;
    let request = Request { width: 0.2, rays: 4_000, seed: 7, delta: 1e-3 };
    let limits = certify(&scene, &request).map_err(|error| error.to_string())?.reflected[0];
    let holds = limits.lower > 0.0 && limits.upper.is_finite();
    Ok((!holds).then(|| format!("a white block under a lamp reflects {limits:?}")).into_iter().collect())
}

/// A closed room that glows and reflects everything, beside a face that only hides: its light is never lost, wherever that face is in order.
fn lossless() -> Wrong {
    let said = |error: radgrad_scene::Error| error.to_string();
    let mut findings = Vec::new();
    for place in [0, 3, 6] {
        let mut scene = Scene::new(["grey"]).map_err(said)?;
        let (room, plate) = (scene.add_surface("room"), scene.add_obstruction("plate"));
        let white = scene.add_material("white", [1.0], [1.0]).map_err(said)?;
        let mut faces: Vec<(usize, Vec<DVec3>)> = walls(DVec3::ONE).into_iter().map(|corners| (room, corners)).collect();
        let beside = faces[0].1.iter().map(|p| *p - DVec3::Z).collect();
        faces.insert(place, (plate, beside));
        for (surface, corners) in faces {
            scene.add_face(surface, white, Polygon::new(corners).map_err(|error| error.to_string())?, None).map_err(said)?;
        }
        let options = Options { error: 0.1, first_elements: 1, most_elements: 12, ..Options::default() };
        let told = solve(&scene, &options, |_| false).map(|solution| solution.mean().to_vec());
        if !matches!(told, Err(radgrad_solver::Error::Lossless { .. })) {
            findings.push(format!("light that is never lost is solved with a plate before face {place}: {told:?}"));
        }
    }
    Ok(findings)
}

/// A floor of very many faces under a lamp: a solution links some of them.
fn many_faces() -> Wrong {
    let said = |error: radgrad_scene::Error| error.to_string();
    let mut scene = Scene::new(["grey"]).map_err(said)?;
    let surface = scene.add_surface("every");
    let [grey, lamp] =
        [scene.add_material("grey", [0.5], [0.0]).map_err(said)?, scene.add_material("lamp", [0.0], [1.0]).map_err(said)?];
    let tile = |k: u32| quad(DVec3::new(f64::from(k % 32), f64::from(k / 32), 0.0) / 32.0, DVec3::X / 32.0, DVec3::Y / 32.0);
    let ceiling = quad(DVec3::Z * 0.5, DVec3::Y, DVec3::X);
    let panel = quad(DVec3::splat(0.4), DVec3::Y * 0.2, DVec3::X * 0.2);
    let floor = (0..1024).map(|k| (grey, tile(k)));
    for (material, corners) in floor.chain([(grey, ceiling), (lamp, panel)]) {
        scene.add_face(surface, material, Polygon::new(corners).map_err(|error| error.to_string())?, None).map_err(said)?;
    }
    let solution = solve(&scene, &Options { error: 0.05, degree: Some(0), ..Options::default() }, |_| false)
        .map_err(|error| error.to_string())?;
    Ok(if solution.progress().links == 0 { vec!["of very many faces none is linked".to_owned()] } else { Vec::new() })
}

/// A room whose walls are all alike, where every walk brings the same light, so that limits are wide by the truncation of walks alone; and at a point
/// of its floor, where textures make walks take the light of lamps that they meet.
fn alike(reflectance: f64, width: f64) -> Wrong {
    let walls = walls(DVec3::ONE).map(|corners| (corners, reflectance, 1.0 - reflectance));
    let request = Request { width, rays: 100_000, seed: 11, delta: 1e-3 };
    let mut findings = Vec::new();
    let mut hold = |what: &str, limits: Interval| {
        if !limits.contains(1.0) {
            findings.push(format!(
                "where all walls reflect {reflectance} {what} of 1 has the certificate {limits:?} of width {width}"
            ));
        }
    };
    let plain = scene(&walls, false, &["grey"]).map_err(|error| error.to_string())?;
    hold("the mean", certify(&plain, &request).map_err(|error| error.to_string())?.mean[0]);
    let textured = scene(&walls, true, &["grey"]).map_err(|error| error.to_string())?;
    hold("the irradiance", on_floor(&textured, &Request { rays: 2_000, ..request })?);
    Ok(findings)
}

/// The certificate of the irradiance at a point of the floor of a box of side 1.
fn on_floor(scene: &Scene, request: &Request) -> Result<Interval, String> {
    let floor = Place { position: DVec3::new(0.3, 0.4, 0.0), normal: DVec3::Z, face: Some(0) };
    let points = certify_points(scene, &[floor], request).map_err(|error| error.to_string())?;
    let point = points.into_iter().next().ok_or("no point")?;
    Ok(point.map_err(|error| error.to_string())?.irradiance[0])
}

/// A room of radiosity 1 whose walls give their light by textures but for one, which gives little: walks that leave it out leave out no other light.
fn one_faint_lamp() -> Wrong {
    let said = |error: Box<dyn std::error::Error>| error.to_string();
    let mut scene = Scene::new(["grey"]).map_err(|error| error.to_string())?;
    for (index, corners) in walls(DVec3::ONE).iter().enumerate() {
        let (is_textured, reflectance) = (index != 1, if index == 1 { 0.999 } else { 0.5 });
        add_wall(&mut scene, corners, &[vec![reflectance], vec![(1.0 - reflectance) / PI]], is_textured).map_err(said)?;
    }
    let limits = on_floor(&scene, &Request { width: 0.2, rays: 20_000, seed: 11, delta: 1e-3 })?;
    let told = format!("with one faint lamp the irradiance of 1 has the certificate {limits:?}");
    Ok((!limits.contains(1.0)).then_some(told).into_iter().collect())
}

/// A wide lamp close above a small floor, which nearly all of its light passes by: walks start from pairs of triangles.
fn close_lamp(side: f64) -> Wrong {
    let floor = quad(DVec3::ZERO, DVec3::X * side, DVec3::Y * side);
    let lamp = quad(DVec3::new(-2.0, -2.0, 1e-3), DVec3::Y * 4.0, DVec3::X * 4.0);
    let scene = scene(&[(floor, 0.5, 0.0), (lamp, 0.0, 1.0)], false, &["grey"]).map_err(|error| error.to_string())?;
    let factors = FormFactors::new(&scene).map_err(|error| error.to_string())?;
    let factor = factors.between(0, 1, &FactorSettings::default()).map_err(|error| error.to_string())?;
    let share = 0.5 * side * side / (side * side + 16.0);
    let request = Request { width: 0.02, rays: 200_000, seed: 13, delta: 1e-6 };
    let limits = certify(&scene, &request).map_err(|error| error.to_string())?.reflected[0];
    let is_beside = is_worse(limits.lower, share * factor.upper) || is_worse(share * factor.lower, limits.upper);
    let told = format!("a floor of side {side} under a close lamp reflects {:e}, certified is {limits:?}", share * factor.value);
    Ok(is_beside.then_some(told).into_iter().collect())
}

/// Contradictions of a few rooms of each kind.
#[must_use]
pub fn all_wrong() -> Vec<String> {
    let rooms = [even(0), surfaces(0), surfaces(1), half_dark(), gathered(0), gathered(1), gathered(2)];
    let told = rooms.into_iter().chain([
        beside(1.0),
        beside(100.0),
        beside(0.01),
        dark_and_white(),
        white_block(),
        lossless(),
        many_faces(),
    ]);
    let told = told.chain([
        alike(0.9, 0.2),
        alike(0.9, 0.6),
        alike(0.5, 0.05),
        alike(0.1, 0.2),
        one_faint_lamp(),
        close_lamp(0.2),
        close_lamp(0.5),
    ]);
    told.flat_map(|told| told.unwrap_or_else(|why| vec![why])).map(|what| format!("identities: {what}")).collect()
}
