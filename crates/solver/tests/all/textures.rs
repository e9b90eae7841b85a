//! Scenes with textures: inside twice the stated estimate, and the same as scenes with a face for each texel.

use std::f64::consts::PI;

use radgrad_core::{DVec3, Polygon};
use radgrad_scene::{Quantity, Scene, Texture, largest};
use radgrad_solver::{Options, Solution, solve};

/// A number in [0, 1] for each texel, without order.
fn noise(column: usize, row: usize, seed: usize) -> f64 {
    ((column * 7919 + row * 104_729 + seed * 1_299_709) % 1009 * 7 % 101) as f64 / 100.0
}

fn corners(origin: [f64; 3], u: [f64; 3], v: [f64; 3]) -> [DVec3; 4] {
    let [o, u, v] = [origin, u, v].map(DVec3::from);
    [o, o + u, o + u + v, o + v]
}

/// The six sides of the unit cube, seen from inside.
fn cube() -> [[DVec3; 4]; 6] {
    let [x, y, z, o] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.0; 3]];
    [corners(o, x, y), corners(z, y, x), corners(o, z, x), corners(y, x, z), corners(o, y, z), corners(x, z, y)]
}

const UNIT: [[f64; 2]; 4] = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];

/// The cube with a reflectance of noise and the emission that makes it glow evenly; two sides are triangles, and on each the
/// texture lies otherwise.
fn furnace(size: usize) -> Scene {
    let mut scene = Scene::new(["grey"]).unwrap();
    for (side, quad) in cube().into_iter().enumerate() {
        let material = scene.add_material(side.to_string(), [0.9], [1.0 / PI]).unwrap();
        let rho = move |column, row| 0.05 + 0.9 * noise(column, row, side);
        let reflectance = Texture::from_fn("rho", [size, size], 1, |c, r| vec![rho(c, r)]).unwrap();
        let radiance = Texture::from_fn("1 - rho", [size, size], 1, |c, r| vec![1.0 - 0.9 * rho(c, r)]).unwrap();
        scene.set_texture(material, Quantity::Reflectance, reflectance).unwrap();
        scene.set_texture(material, Quantity::Radiance, radiance).unwrap();
        let surface = scene.add_surface(side.to_string());
        let turn = side as f64;
        let uv = UNIT.map(|[u, v]| [0.3 + turn.cos() * u - 0.7 * turn.sin() * v, turn.sin() * u + 0.7 * turn.cos() * v]);
        let parts: &[&[usize]] = if side < 2 { &[&[0, 1, 2], &[0, 2, 3]] } else { &[&[0, 1, 2, 3]] };
        for part in parts {
            let polygon = Polygon::new(part.iter().map(|&i| quad[i]).collect()).unwrap();
            let uv: Vec<[f64; 2]> = part.iter().map(|&i| uv[i]).collect();
            scene.add_textured_face(surface, material, polygon, &uv, None).unwrap();
        }
    }
    scene
}

#[test]
fn a_furnace_with_textures_glows_evenly() {
    let scene = furnace(16);
    for degree in 0..=3 {
        let options = Options { degree: Some(degree), ..Options::default() };
        let solution = solve(&scene, &options, |_| true).unwrap();
        for point in [[0.5, 0.5, 0.0], [0.01, 0.02, 0.0], [0.999, 0.3, 0.0], [0.42, 0.77, 0.0]] {
            let gathered = solution.gather(point.into(), DVec3::Z).unwrap();
            let (value, estimate) = (gathered.radiosity[0], gathered.estimate[0].total());
            let error = (value - 1.0).abs();
            assert!(error < 1e-10 && error <= 2.0 * estimate, "degree {degree}: {value} {estimate:e}");
        }
        let leaf = solution.mesh().leaves().last().unwrap();
        let value = solution.value_on(leaf, 0, [0.3, 0.3]);
        assert!((value - 1.0).abs() < 1e-10, "{value}");
        // Rounding in evaluations counts by the importance, which coarse elements know roughly.
        assert!(solution.mean_estimate()[0].total() < 1e-8, "{:?}", solution.mean_estimate());
    }
}

/// A floor of texels under a ceiling, both reflecting, either as textures or as a face for each texel. Both glow, or a lamp below
/// the ceiling does.
fn room(size: usize, textured: bool, lamp: bool) -> Scene {
    let [floor, ceiling] = [[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], [[0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0]]];
    let rho = |c: usize, r: usize| if (c + r).is_multiple_of(2) { 0.8 } else { 0.1 };
    let glow = |c: usize, r: usize| if lamp { 0.0 } else { noise(c, r, 3) };
    let mut scene = Scene::new(["grey"]).unwrap();
    let surface = scene.add_surface("all");
    let [o, u, v] = floor;
    let plain = scene.add_material("plain", [0.6], [if lamp { 0.0 } else { 0.2 }]).unwrap();
    let polygon = |[o, u, v]: [[f64; 3]; 3]| Polygon::new(corners(o, u, v).to_vec()).unwrap();
    scene.add_face(surface, plain, polygon(ceiling), None).unwrap();
    if lamp {
        let bright = scene.add_material("bright", [0.3], [5.0]).unwrap();
        let below = [[0.2, 0.4, 0.8], [0.0, 0.3, 0.0], [0.3, 0.0, 0.0]];
        scene.add_face(surface, bright, polygon(below), None).unwrap();
    }
    if textured {
        let material = scene.add_material("texels", [1.0], [if lamp { 0.0 } else { 1.0 }]).unwrap();
        let reflectance = Texture::from_fn("rho", [size, size], 1, |c, r| vec![rho(c, r)]).unwrap();
        scene.set_texture(material, Quantity::Reflectance, reflectance).unwrap();
        let radiance = Texture::from_fn("E", [size, size], 1, |c, r| vec![glow(c, r)]).unwrap();
        if !lamp {
            scene.set_texture(material, Quantity::Radiance, radiance).unwrap();
        }
        scene.add_textured_face(surface, material, polygon(floor), &UNIT, None).unwrap();
    } else {
        let part = 1.0 / size as f64;
        for r in 0..size {
            for c in 0..size {
                let material = scene.add_material("texel", [rho(c, r)], [glow(c, r)]).unwrap();
                let origin = [0, 1, 2].map(|k| o[k] + part * (c as f64 * u[k] + r as f64 * v[k]));
                let texel = [origin, u.map(|x| x * part), v.map(|x| x * part)];
                scene.add_face(surface, material, polygon(texel), None).unwrap();
            }
        }
    }
    scene
}

fn checked(textured: &Solution, faces: &Solution) -> f64 {
    let mut worst = 0.0_f64;
    for i in 0..9 {
        for (z, normal) in [(0.0, DVec3::Z), (1.0, -DVec3::Z)] {
            let point = DVec3::new(0.035 + 0.11 * f64::from(i), 0.96 - 0.1 * f64::from(i), z);
            let (a, b) = (textured.gather(point, normal).unwrap(), faces.gather(point, normal).unwrap());
            let error = (a.radiosity[0] - b.radiosity[0]).abs();
            let estimates = a.estimate[0].total() + b.estimate[0].total();
            assert!(error <= 2.0 * estimates, "{point}: {} {} {estimates:e}", a.radiosity[0], b.radiosity[0]);
            worst = largest(worst, error);
        }
    }
    worst
}

#[test]
fn a_texture_is_the_same_as_a_face_for_each_texel() {
    let solved = |textured| {
        let options = Options { error: 0.01, degree: Some(2), first_elements: 8, most_elements: 400, ..Options::default() };
        solve(&room(8, textured, false), &options, |_| true).unwrap()
    };
    let (textured, faces) = (solved(true), solved(false));
    assert!(checked(&textured, &faces) < 1e-3);
    assert!(textured.progress().elements < faces.progress().elements, "{:?} {:?}", textured.progress(), faces.progress());
}

#[test]
fn a_texture_under_a_lamp_is_the_same_as_a_face_for_each_texel() {
    for degree in 0..=3 {
        let solved = |textured| {
            let options =
                Options { error: 0.05, degree: Some(degree), first_elements: 8, most_elements: 400, ..Options::default() };
            solve(&room(4, textured, true), &options, |_| true).unwrap()
        };
        let (textured, faces) = (solved(true), solved(false));
        assert!(checked(&textured, &faces) < 0.05 * faces.mean()[0], "degree {degree}");
        let error = (textured.mean()[0] - faces.mean()[0]).abs();
        assert!(error < 0.05 * faces.mean()[0], "degree {degree}: {error} {:?}", textured.mean());
    }
}

#[test]
fn polynomials_and_textures_on_leaves_are_within_their_estimates() {
    for lamp in [false, true] {
        let options = Options { error: 0.02, degree: Some(1), most_elements: 100, ..Options::default() };
        within_estimates(&solve(&room(8, true, lamp), &options, |_| true).unwrap());
    }
}

fn within_estimates(solution: &Solution) {
    let mut nearest = 0.0_f64;
    for leaf in solution.mesh().leaves() {
        let estimate_on_leaf = solution.estimate_on(leaf)[0].total();
        let irradiance = solution.irradiance_on(leaf, 0);
        for at in [[0.1, 0.2], [0.55, 0.9], [0.8, 0.3]] {
            let exact = solution.gather_on(leaf, solution.mesh().elements()[leaf].point(at)).unwrap();
            let (value, estimate) = (exact.radiosity[0], exact.estimate[0].total());
            let error = (solution.value_on(leaf, 0, at) - value).abs();
            assert!(error <= estimate_on_leaf + 2.0 * estimate, "{leaf} {at:?}: {error} {estimate_on_leaf}");
            let fine = (solution.textured_on(leaf, 0, &irradiance, at) - value).abs();
            assert!(fine <= estimate_on_leaf + 2.0 * estimate, "{leaf} {at:?}: {fine} {estimate_on_leaf}");
            nearest = largest(nearest, error / estimate_on_leaf);
        }
    }
    assert!(nearest > 0.2, "an estimate that nothing comes near would say little: {nearest}");
}

#[test]
fn texels_that_reflect_nearly_everything_or_nothing_leave_an_estimate_in_every_channel() {
    let mut scene = Scene::new(["r", "g"]).unwrap();
    let surface = scene.add_surface("all");
    let board = |c: usize, r: usize| f64::from(u8::from((c + r).is_multiple_of(2)));
    for (name, quad) in ["floor", "ceiling", "front", "back", "left", "right"].into_iter().zip(cube()) {
        let glow = if name == "ceiling" { 1.0 } else { 0.0 };
        let material = scene.add_material(name, [0.98, 0.5], [glow, 2.0 * glow]).unwrap();
        let texture = Texture::from_fn("board", [6, 6], 2, |c, r| vec![board(c, r), 1.0 - board(c, r)]).unwrap();
        scene.set_texture(material, Quantity::Reflectance, texture).unwrap();
        let polygon = Polygon::new(quad.to_vec()).unwrap();
        scene.add_textured_face(surface, material, polygon, &UNIT, None).unwrap();
    }
    let solved = |first_elements, most_elements| {
        let options = Options { error: 0.05, degree: Some(1), first_elements, most_elements, ..Options::default() };
        solve(&scene, &options, |_| true).unwrap()
    };
    let (rough, fine) = (solved(6, 6), solved(96, 96));
    for point in [[0.1, 0.3, 0.0], [0.6, 0.55, 0.0], [0.9, 0.2, 0.0]] {
        let (a, b) = (rough.gather(point.into(), DVec3::Z).unwrap(), fine.gather(point.into(), DVec3::Z).unwrap());
        for channel in 0..2 {
            let estimates = [&a, &b].map(|gathered| gathered.estimate[channel].total());
            let error = (a.radiosity[channel] - b.radiosity[channel]).abs();
            let allowed = 2.0 * (estimates[0] + estimates[1]);
            assert!(allowed.is_finite() && error <= allowed, "{point:?} {channel}: {error} {estimates:?}");
        }
    }
    for (channel, (rough_mean, fine_mean)) in rough.mean().iter().zip(fine.mean()).enumerate() {
        let estimates: f64 = [&rough, &fine].map(|solution| solution.mean_estimate()[channel].total()).iter().sum();
        assert!((rough_mean - fine_mean).abs() <= 4.0 * estimates, "{channel}: {rough_mean} {fine_mean} {estimates}");
    }
}
