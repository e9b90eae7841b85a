//! Certificates against scenes whose light is known exactly.

use std::error::Error;

use radgrad_certificate::{Place, Request, certify, certify_points};
use radgrad_core::{DVec3, Polygon};
use radgrad_scene::{Quantity, Scene, Texture};

type Outcome = Result<(), Box<dyn Error>>;

/// A parallelogram from a corner and two sides; it faces the way of their cross product.
fn parallelogram(corner: [f64; 3], along: [f64; 3], up: [f64; 3]) -> Polygon {
    let [corner, along, up] = [corner, along, up].map(DVec3::from);
    Polygon::new(vec![corner, corner + along, corner + along + up, corner + up]).expect("a parallelogram")
}

/// The walls of a box from the origin, all facing in.
fn walls([x, y, z]: [f64; 3]) -> [Polygon; 6] {
    [
        parallelogram([0.0; 3], [x, 0.0, 0.0], [0.0, y, 0.0]),
        parallelogram([0.0, 0.0, z], [0.0, y, 0.0], [x, 0.0, 0.0]),
        parallelogram([0.0; 3], [0.0, 0.0, z], [x, 0.0, 0.0]),
        parallelogram([0.0, y, 0.0], [x, 0.0, 0.0], [0.0, 0.0, z]),
        parallelogram([0.0; 3], [0.0, y, 0.0], [0.0, 0.0, z]),
        parallelogram([x, 0.0, 0.0], [0.0, 0.0, z], [0.0, y, 0.0]),
    ]
}

/// A scene of one channel, each face with its reflectance and the radiosity that it emits.
fn scene(faces: impl IntoIterator<Item = (Polygon, f64, f64)>) -> Result<Scene, Box<dyn Error>> {
    let mut scene = Scene::new(["grey"])?;
    for (index, (polygon, reflectance, emitted)) in faces.into_iter().enumerate() {
        let material = scene.add_material(format!("m{index}"), [reflectance], [emitted / std::f64::consts::PI])?;
        let surface = scene.add_surface(format!("s{index}"));
        scene.add_face(surface, material, polygon, None)?;
    }
    Ok(scene)
}

/// A box with a plate of two sides in it, turned, where every face has `E = 1 - rho`: the radiosity is 1 everywhere.
fn furnace(reflectances: [f64; 8]) -> Result<(Scene, f64), Box<dyn Error>> {
    let [sides @ .., above, below] = reflectances;
    let (along, up) = ([0.6, 0.3, 0.1], [-0.2, 0.5, 0.4]);
    let plate = [parallelogram([0.8, 0.5, 0.4], along, up), parallelogram([0.8, 0.5, 0.4], up, along)];
    let faces: Vec<(Polygon, f64)> =
        walls([2.0, 1.5, 1.0]).into_iter().zip(sides).chain(plate.into_iter().zip([above, below])).collect();
    let area: f64 = faces.iter().map(|(polygon, _)| polygon.area()).sum();
    let emitted: f64 = faces.iter().map(|(polygon, rho)| polygon.area() * (1.0 - rho)).sum();
    Ok((scene(faces.into_iter().map(|(polygon, rho)| (polygon, rho, 1.0 - rho)))?, 1.0 - emitted / area))
}

#[test]
fn even_light_is_within_its_limits() -> Outcome {
    let rooms =
        [[0.5; 8], [0.9; 8], [0.0, 0.99, 0.3, 0.7, 0.5, 0.2, 0.9, 0.1], [0.8, 0.1, 0.8, 0.1, 0.8, 0.1, 0.0, 1.0], [0.97; 8]];
    for (room, reflectances) in rooms.into_iter().enumerate() {
        let (scene, reflected) = furnace(reflectances)?;
        for seed in 0..2 {
            let certificate = certify(&scene, &Request { width: 0.02, delta: 1e-3, seed, rays: 4_000_000 })?;
            let [mean, reflected_mean] = [certificate.mean[0], certificate.reflected[0]];
            assert!(
                mean.contains(1.0) && reflected_mean.contains(reflected),
                "room {room}, seed {seed}: {mean:?} {reflected_mean:?}"
            );
            assert!(mean.half_width() < 0.021, "room {room}, seed {seed}: {mean:?}");
        }
        let place = Place { position: DVec3::new(0.3, 0.2, 0.0), normal: DVec3::Z, face: Some(0) };
        let points = certify_points(&scene, &[place], &Request { width: 0.02, rays: 200_000, ..Request::default() })?;
        let point = points[0].as_ref().map_err(Clone::clone)?;
        let (irradiance, radiosity) =
            (point.irradiance[0], point.radiosity.as_ref().map_or(f64::NAN, |interval| interval[0].half_width()));
        assert!(point.radiosity.as_ref().is_some_and(|interval| interval[0].contains(1.0)), "room {room}: {point:?}");
        assert!(
            irradiance.contains(1.0) && irradiance.half_width() < 0.3 && radiosity <= irradiance.half_width(),
            "room {room}: {point:?}"
        );
    }
    Ok(())
}

/// A room of one reflectance with a gap of this width in its ceiling, and a lamp above that shines through it: the mean reflected radiosity but
/// for the light that leaves through the gap again, at most the gap's share of all that is incident on walls of that area.
fn lit_through_a_gap(rho: f64, gap: f64) -> Result<(Scene, [f64; 2]), Box<dyn Error>> {
    let [floor, _, sides @ ..] = walls([1.0, 1.0, 1.0]);
    // Ceilings face down; the lamp is level with them, 0.01 wide, and faces down.
    let ceiling = |x: f64, width: f64| parallelogram([x, 0.0, 1.0], [0.0, 1.0, 0.0], [width, 0.0, 0.0]);
    let lamp = parallelogram([0.495, 0.495, 6.0], [0.0, 0.01, 0.0], [0.01, 0.0, 0.0]);
    let margin = 0.5 - 0.5 * gap;
    let inner: Vec<Polygon> = [floor, ceiling(0.0, margin), ceiling(margin + gap, margin)].into_iter().chain(sides).collect();
    let area: f64 = inner.iter().map(Polygon::area).sum();
    let whole = area + lamp.area();
    // The lamp sees the gap under small angles: a Gauss rule of few points on the gap, at the middle of the lamp, is exact to 1e-5.
    let kernel = |x: f64, y: f64| {
        let (dx, dy, dz) = (x - 0.5, y - 0.5, 5.0);
        let square = dx * dx + dy * dy + dz * dz;
        dz * dz / (std::f64::consts::PI * square * square)
    };
    let count = 400;
    let midpoint = |k: i32| (f64::from(k) + 0.5) / f64::from(count);
    let through: f64 = (0..count).map(|k| gap * kernel(0.5, midpoint(k)) / f64::from(count)).sum::<f64>() * lamp.area();
    let emitted = 1e6;
    let faces = inner.into_iter().map(|polygon| (polygon, rho, 0.0)).chain([(lamp, 0.0, emitted)]);
    let scene = scene(faces)?;
    // All that comes in is absorbed, or leaves through the gap: of the light of each reflection, at most some ten times the gap's
    // share of the area.
    let radiosity = emitted * through * rho / (1.0 - rho) / whole;
    Ok((scene, [radiosity * (1.0 - 10.0 * gap / area * rho / (1.0 - rho) - 1e-3), radiosity * (1.0 + 1e-3)]))
}

#[test]
fn light_through_a_gap_is_within_its_limits() -> Outcome {
    for (gap, rho) in [(1e-2, 0.5), (1e-4, 0.7)] {
        let (scene, [least, most]) = lit_through_a_gap(rho, gap)?;
        for seed in 0..2 {
            let certificate = certify(&scene, &Request { width: 0.02, seed, rays: 3_000_000, ..Request::default() })?;
            let reflected = certificate.reflected[0];
            assert!(
                reflected.lower <= most && reflected.upper >= least,
                "{gap}, seed {seed}: {reflected:?} for {least} to {most}"
            );
            assert!(
                reflected.half_width() < 0.04 * most,
                "{gap}, seed {seed}: {reflected:?} of {most}, {} rays",
                certificate.rays
            );
        }
    }
    Ok(())
}

#[test]
fn what_no_range_bounds_is_bounded_from_below() -> Outcome {
    // Each face of the one channel reflects all but the floor; in the other the floor reflects, and nothing emits.
    let mut scene = Scene::new(["white", "dark"])?;
    let white = scene.add_material("white", [1.0, 0.5], [0.0, 0.0])?;
    let floor = scene.add_material("floor", [0.5, 0.5], [0.5 / std::f64::consts::PI, 0.0])?;
    for (index, polygon) in walls([1.0; 3]).into_iter().enumerate() {
        let surface = scene.add_surface(format!("s{index}"));
        scene.add_face(surface, if index == 0 { floor } else { white }, polygon, None)?;
    }
    let certificate = certify(&scene, &Request { width: 0.05, rays: 2_000_000, ..Request::default() })?;
    let [white, dark] = [certificate.mean[0], certificate.mean[1]];
    // Even light of radiosity 1.
    assert!(white.lower > 0.5 && white.lower <= 1.0 && white.upper == f64::INFINITY, "{white:?}");
    assert!(dark.lower == 0.0 && dark.upper == 0.0, "{dark:?}");
    Ok(())
}

#[test]
fn textures_count_where_walks_meet_them() -> Outcome {
    // Two squares far apart, so that each sees the other from all places alike: half of the lamp shines, half of the other one reflects.
    let mut scene = Scene::new(["grey"])?;
    let halves = Texture::new("halves", [2, 1], 1, vec![0.25, 1.0])?;
    let lamp = scene.add_material("lamp", [0.0], [1.0])?;
    let wall = scene.add_material("wall", [0.8], [0.0])?;
    scene.set_texture(lamp, Quantity::Radiance, halves.clone())?;
    scene.set_texture(wall, Quantity::Reflectance, halves)?;
    let lower = parallelogram([0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]);
    let upper = parallelogram([0.0, 0.0, 20.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0]);
    let corners = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
    let floor = scene.add_surface("floor");
    scene.add_textured_face(floor, lamp, lower, &corners, None)?;
    let ceiling = scene.add_surface("ceiling");
    scene.add_textured_face(ceiling, wall, upper, &corners, None)?;
    let certificate = certify(&scene, &Request { width: 0.02, rays: 3_000_000, ..Request::default() })?;
    // Mean emission pi 0.625, mean reflectance 0.5, one reflection, half of the area; the factor by that of far squares.
    let factor = 1.0 / (std::f64::consts::PI * 400.0);
    let reflected = 0.5 * 0.5 * std::f64::consts::PI * 0.625 * factor;
    let interval = certificate.reflected[0];
    assert!(
        interval.contains(reflected * (1.0 - 1e-3)) && interval.half_width() < 0.021 * reflected,
        "{interval:?} for {reflected}"
    );
    Ok(())
}

/// Two cubes with a wall between them, in three channels: on the left every face has `E = 1 - rho` times a
/// number of the channel, and on the right nothing is lit. The floor goes under both, and its textures tell the halves.
fn lit_and_dark_rooms() -> Result<Scene, Box<dyn Error>> {
    let mut scene = Scene::new(["red", "green", "blue"])?;
    let radiance = |rho: [f64; 3]| [0, 1, 2].map(|c| BRIGHT[c] * (1.0 - rho[c]) / std::f64::consts::PI);
    let floor = scene.add_material("floor", [1.0; 3], radiance(FLOOR))?;
    let reflectances = [FLOOR, DARK].concat();
    scene.set_texture(floor, Quantity::Reflectance, Texture::new("reflectance", [2, 1], 3, reflectances)?)?;
    let emission = [[1.0; 3], [0.0; 3]].concat();
    scene.set_texture(floor, Quantity::Radiance, Texture::new("emission", [2, 1], 3, emission)?)?;
    let surface = scene.add_surface("floor");
    let both = parallelogram([0.0; 3], [2.0, 0.0, 0.0], [0.0, 1.0, 0.0]);
    scene.add_textured_face(surface, floor, both, &[[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]], None)?;
    let dark = scene.add_material("dark", DARK, [0.0; 3])?;
    let right = scene.add_surface("right");
    for (index, polygon) in walls([1.0; 3]).into_iter().enumerate().skip(1) {
        let [even, odd] = [[0.2, 0.5, 0.8], [0.7, 0.1, 0.4]];
        let rho = if index % 2 == 0 { even } else { odd };
        let lit = scene.add_material(format!("lit{index}"), rho, radiance(rho))?;
        let wall = scene.add_surface(format!("left{index}"));
        let moved = polygon.vertices().iter().map(|corner| *corner + DVec3::X).collect();
        scene.add_face(wall, lit, polygon, None)?;
        scene.add_face(right, dark, Polygon::new(moved)?, None)?;
    }
    // A surface that only hides has no part in the mean.
    let aside = scene.add_obstruction("aside");
    scene.add_face(aside, dark, parallelogram([5.0; 3], [3.0, 0.0, 0.0], [0.0, 3.0, 0.0]), None)?;
    Ok(scene)
}

const BRIGHT: [f64; 3] = [1.0, 2.0, 3.0];
const FLOOR: [f64; 3] = [0.5, 0.3, 0.6];
const DARK: [f64; 3] = [0.9, 0.8, 0.7];

#[test]
fn no_light_comes_through_a_wall() -> Outcome {
    let scene = lit_and_dark_rooms()?;
    let certificate = certify(&scene, &Request { width: 0.02, rays: 1_500_000, ..Request::default() })?;
    for (channel, bright) in BRIGHT.into_iter().enumerate() {
        let (mean, reflected) = (certificate.mean[channel], certificate.reflected[channel]);
        assert!(mean.contains(0.5 * bright) && reflected.half_width() < 0.05 * reflected.lower, "channel {channel}: {mean:?}");
        // Not one walk of some hundred thousand gets there.
        assert_eq!(certificate.surfaces[1][channel], 0.0, "channel {channel}");
        let lit = certificate.surfaces[0][channel] / (0.5 * bright * FLOOR[channel]);
        assert!((lit - 1.0).abs() < 0.05, "channel {channel}: {lit}");
    }
    let place = |x: f64| Place { position: DVec3::new(x, 0.4, 0.0), normal: DVec3::Z, face: Some(0) };
    let points =
        certify_points(&scene, &[place(0.3), place(1.7)], &Request { width: 0.02, rays: 300_000, ..Request::default() })?;
    let [lit, dark] = [0, 1].map(|point| points[point].as_ref().expect("on the floor"));
    for (channel, bright) in BRIGHT.into_iter().enumerate() {
        let radiosity = lit.radiosity.as_ref().ok_or("on a face")?[channel];
        assert!(lit.irradiance[channel].contains(bright) && radiosity.contains(bright), "channel {channel}: {lit:?}");
        assert!(radiosity.half_width() < 0.1 * bright, "channel {channel}: {lit:?}");
        let irradiance = dark.irradiance[channel];
        assert!(irradiance.lower == 0.0 && irradiance.upper < 0.4 * bright, "channel {channel}: {dark:?}");
    }
    Ok(())
}

#[test]
fn channels_and_points_share_the_probability() -> Outcome {
    let cube = |channels: usize| -> Result<Scene, Box<dyn Error>> {
        let mut scene = Scene::new((0..channels).map(|channel| format!("c{channel}")))?;
        let wall = scene.add_material("wall", vec![0.5; channels], vec![0.1; channels])?;
        let dim = scene.add_material("dim", vec![0.3; channels], vec![0.0; channels])?;
        for (index, polygon) in walls([1.0; 3]).into_iter().enumerate() {
            let surface = scene.add_surface(format!("s{index}"));
            scene.add_face(surface, if index < 2 { wall } else { dim }, polygon, None)?;
        }
        Ok(scene)
    };
    let request = |delta: f64| Request { delta, width: 0.02, rays: 100_000, seed: 3 };
    // Powers of two, so that shares are the same numbers.
    let [one, four] = [cube(1)?, cube(4)?];
    let [alone, beside, wide] =
        [(&one, 0.0625), (&four, 0.25), (&four, 0.0625)].map(|(scene, delta)| certify(scene, &request(delta)));
    let (alone, beside, wide) = (alone?, beside?, wide?);
    assert_eq!(beside.mean, [alone.mean[0]; 4]);
    assert!(wide.mean[0].half_width() > alone.mean[0].half_width());
    let place = Place { position: DVec3::new(0.3, 0.2, 0.0), normal: DVec3::Z, face: Some(0) };
    let certify = |scene: &Scene, count: usize, delta: f64| certify_points(scene, &vec![place; count], &request(delta));
    let [alone, beside, of_four] = [certify(&one, 1, 0.0625)?, certify(&one, 2, 0.125)?, certify(&four, 1, 0.25)?];
    assert_eq!(alone[0], beside[0]);
    let [alone, of_four] = [&alone, &of_four].map(|points| points[0].as_ref().expect("on the floor"));
    assert_eq!(of_four.irradiance, [alone.irradiance[0]; 4]);
    Ok(())
}

#[test]
fn bytes_do_not_depend_on_threads() -> Outcome {
    let (scene, _) = furnace([0.0, 0.9, 0.3, 0.7, 0.5, 0.2, 0.9, 0.1])?;
    let request = Request { width: 0.05, ..Request::default() };
    let place = Place { position: DVec3::new(0.3, 0.2, 0.0), normal: DVec3::Z, face: None };
    let on = |threads: usize| -> Result<_, Box<dyn Error>> {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build()?;
        Ok(pool.install(|| -> Result<_, radgrad_certificate::Error> {
            Ok((certify(&scene, &request)?, certify_points(&scene, &[place], &Request { rays: 100_000, ..request })?))
        })?)
    };
    assert_eq!(on(1)?, on(3)?);
    Ok(())
}

#[test]
fn requests_out_of_range_are_refused_in_a_sentence() -> Outcome {
    let (scene, _) = furnace([0.5; 8])?;
    let message = |request: Request| certify(&scene, &request).expect_err("refused").to_string();
    assert!(message(Request { delta: 0.0, ..Request::default() }).contains("probability 0"));
    assert!(message(Request { width: f64::NAN, ..Request::default() }).contains("half-width of the interval is NaN"));
    // A point that is refused costs itself only; one that rounding moves past the edge of its face is on it.
    let above = Place { position: DVec3::new(0.3, 0.2, 0.1), normal: DVec3::Z, face: Some(0) };
    let nowhere = Place { normal: DVec3::ZERO, face: None, ..above };
    let beside = Place { position: DVec3::new(-1e-12, 0.2, 0.0), ..above };
    let points = certify_points(&scene, &[above, nowhere, beside], &Request { rays: 1_000, ..Request::default() })?;
    let refusal = points[0].as_ref().expect_err("refused").to_string();
    assert!(refusal.contains("point 0 at [0.3, 0.2, 0.1]: it must be on face 0"), "{refusal}");
    assert!(points[1].is_err() && points[2].is_ok(), "{points:?}");
    Ok(())
}
