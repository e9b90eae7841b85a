//! Curved patches: exact solutions are inside the stated bound, and as near as the default effort promises.

use std::f64::consts::{FRAC_PI_2, FRAC_PI_3, PI, TAU};

use radgrad_core::{DVec3, Polygon};
use radgrad_curved::{CurvedOptions, CurvedScene, CurvedSolution, Patch, Side, Value, solve};
use radgrad_scene::gauss_legendre;

fn polygon(points: &[[f64; 3]]) -> Patch {
    Patch::polygon(Polygon::new(points.iter().map(|&p| p.into()).collect()).unwrap())
}

/// The irradiance at a point, after a check that the radiosity is within its bound.
fn checked(solution: &CurvedSolution, patch: usize, at: [f64; 2], exact: f64, within: f64) -> f64 {
    let answer = solution.gather(patch, at).unwrap();
    let error = (answer.radiosity - exact).abs();
    assert!(error <= answer.bound, "{at:?}: {} off {exact} by more than {:e}", answer.radiosity, answer.bound);
    assert!(error <= within, "{at:?}: {} off {exact}", answer.radiosity);
    answer.irradiance
}

#[test]
fn inside_a_sphere_the_irradiance_is_the_mean_radiosity() {
    let (centre, radius) = (DVec3::new(1.0, -2.0, 0.5), 3.0);
    let sphere = || Patch::whole_sphere(centre, radius, Side::Inside).unwrap();
    let height = move |x: DVec3| (x.z - centre.z) / radius;
    // Means over the sphere: of the height 0, of its square a third, of its fourth power a fifth.
    let cases: [(Value, Value, f64, f64); 3] = [
        (0.7.into(), 2.0.into(), 2.0, 0.7),
        (0.7.into(), Value::function(4.0, move |x| 1.0 + 3.0 * height(x).powi(2)), 2.0, 0.7),
        (Value::function(0.9, move |x| 0.9 * height(x).powi(4)), Value::function(3.0, move |x| 1.5 + height(x)), 1.5, 0.18),
    ];
    for (reflectance, emitted, mean_emitted, mean_reflectance) in cases {
        let mut scene = CurvedScene::new();
        scene.add(sphere(), reflectance.clone(), emitted.clone()).unwrap();
        let solution = solve(scene, &CurvedOptions::default()).unwrap();
        let irradiance = mean_emitted / (1.0 - mean_reflectance);
        for at in [[0.0, 0.5], [0.3, 0.02], [0.9, 0.7]] {
            let (polar, azimuth) = (PI * at[1], TAU * at[0]);
            let outwards = DVec3::new(polar.sin() * azimuth.cos(), polar.sin() * azimuth.sin(), polar.cos());
            let value = |quantity: &Value| match quantity {
                Value::Constant(value) => *value,
                Value::Function { function, .. } => function(centre + outwards * radius),
            };
            checked(&solution, 0, at, value(&emitted) + value(&reflectance) * irradiance, 1e-6);
        }
    }
}

#[test]
fn in_a_bowl_cut_from_a_sphere_the_irradiance_is_even_too() {
    let polar = [2.0, PI];
    let mut scene = CurvedScene::new();
    let bowl = Patch::sphere(DVec3::ZERO, 2.0, polar, [0.5, 0.5 + TAU], Side::Inside).unwrap();
    scene.add(bowl, 0.8, 1.0).unwrap();
    let solution = solve(scene, &CurvedOptions::default()).unwrap();
    let part = 0.5 * (1.0 + polar[0].cos());
    for at in [[0.1, 0.1], [0.5, 0.9]] {
        checked(&solution, 0, at, 1.0 / (1.0 - 0.8 * part), 1e-6);
    }
}

#[test]
fn a_tube_sees_of_itself_what_is_known() {
    let (radius, height) = (1.5, 4.0);
    let mut scene = CurvedScene::new();
    let axis = DVec3::new(0.0, 2.4, 3.2);
    let tube = Patch::cylinder(DVec3::ONE, axis, radius, DVec3::X, [0.0, TAU], Side::Inside).unwrap();
    scene.add(tube, 0.0, 1.0).unwrap();
    let solution = solve(scene, &CurvedOptions { most_parts: 1, ..CurvedOptions::default() }).unwrap();
    // The factor of an open cylinder's inside to itself: 1 + h - sqrt(1 + h^2), h its height over its diameter.
    let h = height / (2.0 * radius);
    let mean: f64 = gauss_legendre(12)
        .iter()
        .map(|(x, weight)| 0.5 * weight * solution.gather(0, [0.2, 0.5 + 0.5 * x]).unwrap().irradiance)
        .sum();
    assert!((mean - (1.0 + h - (1.0 + h * h).sqrt())).abs() < 1e-6, "{mean}");
}

#[test]
fn a_sphere_over_a_floor_gives_what_a_point_in_its_place_would() {
    let (height, radius) = (2.0, 0.7);
    let mut scene = CurvedScene::new();
    let floor = [[-5.0, -5.0, 0.0], [5.0, -5.0, 0.0], [5.0, 5.0, 0.0], [-5.0, 5.0, 0.0]];
    scene.add(polygon(&floor), 0.5, 0.0).unwrap();
    scene.add(Patch::whole_sphere(DVec3::Z * height, radius, Side::Outside).unwrap(), 0.0, 1.0).unwrap();
    let options = CurvedOptions { error: 1e-3, most_parts: 2, most_cells: 2000, ..CurvedOptions::default() };
    let solution = solve(scene, &options).unwrap();
    for at in [[0.5, 0.5], [0.6, 0.45], [0.9, 0.2]] {
        let away = DVec3::new(10.0 * at[0] - 5.0, 10.0 * at[1] - 5.0, -height).length();
        checked(&solution, 0, at, 0.5 * radius * radius * height / away.powi(3), 1e-5);
    }
}

#[test]
fn between_concentric_spheres_light_is_even_past_the_inner_one() {
    let (small, large) = (1.0_f64, 2.0_f64);
    let (rho, emitted) = ([0.5, 0.6], [1.0, 0.3]);
    let mut scene = CurvedScene::new();
    for (radius, side, i) in [(small, Side::Outside, 0), (large, Side::Inside, 1)] {
        scene.add(Patch::whole_sphere(DVec3::ZERO, radius, side).unwrap(), rho[i], emitted[i]).unwrap();
    }
    let options = CurvedOptions { degree: 0, error: 0.02, most_parts: 2, most_cells: 500 };
    let solution = solve(scene, &options).unwrap();
    // The inner one sees the outer one only; the part (small/large)^2 of the outer one's view is the inner one.
    let part = (small / large).powi(2);
    let outer = (emitted[1] + rho[1] * part * emitted[0]) / (1.0 - rho[1] * (1.0 - part) - rho[1] * part * rho[0]);
    let inner = emitted[0] + rho[0] * outer;
    for at in [[0.1, 0.5], [0.7, 0.3]] {
        checked(&solution, 0, at, inner, 3e-3);
        checked(&solution, 1, at, outer, 3e-3);
    }
}

#[test]
fn a_long_vault_over_a_strip_has_the_factors_of_infinite_ones() {
    let half = 400.0;
    let vault = || Patch::cylinder(-DVec3::Y * half, DVec3::Y * 2.0 * half, 1.0, DVec3::X, [-PI, 0.0], Side::Inside).unwrap();
    let strip = polygon(&[[-1.0, -half, 0.0], [1.0, -half, 0.0], [1.0, half, 0.0], [-1.0, half, 0.0]]);
    let mut scene = CurvedScene::new();
    scene.add(strip, 0.0, 0.3).unwrap();
    scene.add(vault(), 0.0, 1.0).unwrap();
    let options = CurvedOptions { most_parts: 2, most_cells: 1000, ..CurvedOptions::default() };
    let solution = solve(scene, &options).unwrap();
    for u in [0.1, 0.4, 0.5] {
        // A chord's ends are seen from the arc under half the angles at the centre.
        let angle = PI * (1.0 - u);
        let to_strip = 0.5 * ((0.5 * angle).cos() + (0.5 * angle).sin());
        let gathered = solution.gather(1, [u, 0.5]).unwrap();
        let error = (gathered.irradiance - (1.0 - to_strip + 0.3 * to_strip)).abs();
        // The light that leaves by the ends is less than 1/400^2.
        assert!(error <= gathered.irradiance_bound + 1e-5 && error < 2e-5, "{u}: {gathered:?} {to_strip}");
    }
}

fn bezier(point: impl Fn(f64, f64) -> DVec3) -> [[DVec3; 4]; 4] {
    let third = |i: usize| i as f64 / 3.0;
    std::array::from_fn(|row| std::array::from_fn(|column| point(third(column), third(row))))
}

#[test]
fn a_flat_bezier_patch_is_a_polygon() {
    let lamp = |u: f64, v: f64| DVec3::new(v, u, 1.0);
    let floor = [[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [2.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
    let corners = [lamp(0.0, 0.0), lamp(1.0, 0.0), lamp(1.0, 1.0), lamp(0.0, 1.0)];
    let solved = |patch: Patch| {
        let mut scene = CurvedScene::new();
        scene.add(polygon(&floor), 0.5, 0.2).unwrap();
        scene.add(patch, 0.5, 1.0).unwrap();
        solve(scene, &CurvedOptions { error: 5e-3, ..CurvedOptions::default() }).unwrap()
    };
    let flat = solved(Patch::polygon(Polygon::new(corners.to_vec()).unwrap()));
    for other in [Patch::bezier(bezier(lamp)).unwrap(), Patch::bilinear(corners).unwrap()] {
        let other = solved(other);
        for at in [[0.2, 0.3], [0.7, 0.9]] {
            for patch in [0, 1] {
                let exact = flat.gather(patch, at).unwrap();
                checked(&other, patch, at, exact.radiosity, 2e-3);
                assert!((exact.radiosity - other.gather(patch, at).unwrap().radiosity).abs() < 1e-4);
            }
        }
    }
}

/// Control points of `z = c (x^2 + y^2)` over the square from -1 to 1: those of `x^2` are 1, -1/3, -1/3, 1.
fn paraboloid(c: f64) -> [[DVec3; 4]; 4] {
    let square = [1.0, -1.0 / 3.0, -1.0 / 3.0, 1.0];
    let abscissa = |i: usize| 2.0 * i as f64 / 3.0 - 1.0;
    std::array::from_fn(|row| {
        std::array::from_fn(|column| DVec3::new(abscissa(column), abscissa(row), c * (square[column] + square[row])))
    })
}

#[test]
fn a_bowl_and_a_lamp_exchange_the_same_light_both_ways() {
    let c = 0.3;
    let lamp = [[-0.5, -0.5, 1.2], [-0.5, 0.5, 1.2], [0.5, 0.5, 1.2], [0.5, -0.5, 1.2]];
    let solved = |of_bowl: f64, of_lamp: f64| {
        let mut scene = CurvedScene::new();
        scene.add(Patch::bezier(paraboloid(c)).unwrap(), 0.0, of_bowl).unwrap();
        scene.add(polygon(&lamp), 0.0, of_lamp).unwrap();
        solve(scene, &CurvedOptions { most_parts: 2, ..CurvedOptions::default() }).unwrap()
    };
    let (lit, dark) = (solved(0.0, 1.0), solved(1.0, 0.0));
    let (mut to_bowl, mut to_lamp) = (0.0, 0.0);
    let rule: Vec<(f64, f64)> = gauss_legendre(10).iter().map(|(x, weight)| (0.5 + 0.5 * x, 0.5 * weight)).collect();
    for &(u, a) in &rule {
        for &(v, b) in &rule {
            let [x, y] = [2.0 * u - 1.0, 2.0 * v - 1.0];
            let area = 4.0 * (1.0 + 4.0 * c * c * (x * x + y * y)).sqrt();
            to_bowl += a * b * area * lit.gather(0, [u, v]).unwrap().irradiance;
            to_lamp += a * b * dark.gather(1, [u, v]).unwrap().irradiance;
        }
    }
    assert!((to_bowl - to_lamp).abs() < 1e-6, "{to_bowl} {to_lamp}");
    assert!(dark.gather(0, [0.5, 0.5]).unwrap().irradiance > 0.1, "a bowl sees itself");
}

#[test]
fn a_bezier_patch_that_may_hide_something_is_refused() {
    let refused = |control, height: f64| {
        let mut scene = CurvedScene::new();
        scene.add(Patch::bezier(control).unwrap(), 0.5, 1.0).unwrap();
        let lamp = [[-0.5, -0.5, height], [-0.5, 0.5, height], [0.5, 0.5, height], [0.5, -0.5, height]];
        scene.add(polygon(&lamp), 0.5, 0.0).unwrap();
        solve(scene, &CurvedOptions { most_parts: 1, ..CurvedOptions::default() }).err().map(|error| error.to_string())
    };
    assert_eq!(refused(paraboloid(0.3), 1.2), None);
    for (control, height) in [(paraboloid(-0.3), 1.2), (paraboloid(0.3), -1.2)] {
        let message = refused(control, height).unwrap();
        assert!(message.starts_with("Bezier patch 0 may hide a part of the scene"), "{message}");
    }
}

#[test]
fn a_room_under_a_saddle_glows_evenly() {
    let heights = [1.0, 1.3, 1.0, 1.3];
    let ground = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
    let top = |i: usize| DVec3::new(ground[i % 4][0], ground[i % 4][1], heights[i % 4]);
    let low = |i: usize| DVec3::new(ground[i % 4][0], ground[i % 4][1], 0.0);
    let rho = [0.5, 0.3, 0.6, 0.4, 0.2, 0.7];
    let mut scene = CurvedScene::new();
    let mut add = |patch: Patch, i: usize| scene.add(patch, rho[i], 1.0 - rho[i]).unwrap();
    let flat = |points: [DVec3; 4]| Patch::polygon(Polygon::new(points.to_vec()).unwrap());
    add(flat([low(0), low(1), low(2), low(3)]), 0);
    for i in 0..4 {
        add(flat([low(i), top(i), top(i + 1), low(i + 1)]), 1 + i);
    }
    add(Patch::bilinear([top(0), top(3), top(2), top(1)]).unwrap(), 5);
    let options = CurvedOptions { degree: 0, error: 0.05, most_parts: 6, most_cells: 200 };
    let solution = solve(scene, &options).unwrap();
    for (patch, at) in [(0, [0.5, 0.5]), (0, [0.1, 0.9]), (5, [0.3, 0.6]), (2, [0.5, 0.4])] {
        checked(&solution, patch, at, 1.0, 5e-3);
    }
}

#[test]
fn what_is_out_of_range_is_refused_with_value_and_place() {
    let message = |patch: Result<Patch, radgrad_curved::Error>| patch.unwrap_err().to_string();
    let sphere = |radius, polar| Patch::sphere(DVec3::ZERO, radius, polar, [0.0, TAU], Side::Inside);
    assert_eq!(message(sphere(-1.0, [0.0, PI])), "sphere: its radius is -1: it must be above 0 and finite");
    assert!(message(sphere(1.0, [FRAC_PI_2, FRAC_PI_3])).contains("they must rise"));
    assert!(message(sphere(1.0, [1.0, 3.2])).contains("by no more than"));
    let axis = Patch::cylinder(DVec3::ZERO, DVec3::ZERO, 1.0, DVec3::X, [0.0, 1.0], Side::Inside);
    assert_eq!(message(axis), "cylinder: its axis is zero");
    let mut scene = CurvedScene::new();
    let whole = || Patch::whole_sphere(DVec3::ZERO, 1.0, Side::Inside).unwrap();
    let error = scene.add(whole(), 1.0, 0.0).unwrap_err().to_string();
    assert!(error.starts_with("reflectance of patch 0 is 1 at "), "{error}");
    scene.add(whole(), Value::function(0.5, |x| 0.6 * x.z.abs()), 1.0).unwrap();
    let error = solve(scene, &CurvedOptions::default()).unwrap_err().to_string();
    assert!(error.starts_with("reflectance of patch 0 is 0.5"), "{error}");
}

#[test]
fn errors_are_within_what_is_stated_at_any_effort() {
    let (mut points, mut nearest) = (0, 0.0_f64);
    for (radius, height) in [(0.2, 0.25), (0.7, 2.0), (1.0, 1.01), (3.0, 4.5)] {
        for most_cells in [4, 20, 100, 500] {
            let mut scene = CurvedScene::new();
            let floor = [[-5.0, -5.0, 0.0], [5.0, -5.0, 0.0], [5.0, 5.0, 0.0], [-5.0, 5.0, 0.0]];
            scene.add(polygon(&floor), 0.0, 0.0).unwrap();
            let centre = DVec3::new(0.1, -0.2, height);
            scene.add(Patch::whole_sphere(centre, radius, Side::Outside).unwrap(), 0.0, 1.0).unwrap();
            let options = CurvedOptions { degree: 0, most_parts: 1, error: 1e-5, most_cells };
            let solution = solve(scene, &options).unwrap();
            for at in [[0.5, 0.5], [0.53, 0.47], [0.61, 0.3], [0.95, 0.9], [0.2, 0.55]] {
                let away = (DVec3::new(10.0 * at[0] - 5.0, 10.0 * at[1] - 5.0, 0.0) - centre).length();
                let exact = radius * radius * height / away.powi(3);
                let gathered = solution.gather(0, at).unwrap();
                let error = (gathered.irradiance - exact).abs();
                assert!(error <= gathered.irradiance_bound, "{radius} {height} {most_cells} {at:?}: {error:e} {gathered:?}");
                (points, nearest) = (points + 1, nearest.max(error / gathered.irradiance_bound));
            }
        }
    }
    assert!(points == 80 && nearest > 0.01, "{nearest}");
}

#[test]
fn behind_a_ball_errors_are_within_what_is_stated_at_any_effort() {
    for (radius, offset) in [(1.0, 0.0), (0.3, 0.0), (0.8, 0.9), (0.1, 1.5)] {
        for most_cells in [4, 16, 64, 256] {
            let mut scene = CurvedScene::new();
            scene.add(Patch::whole_sphere(DVec3::ZERO, 2.0, Side::Inside).unwrap(), 0.0, 1.0).unwrap();
            let centre = DVec3::new(offset, 0.0, 0.2 * offset);
            scene.add(Patch::whole_sphere(centre, radius, Side::Outside).unwrap(), 0.0, 0.0).unwrap();
            let options = CurvedOptions { degree: 0, most_parts: 2, error: 1e-5, most_cells };
            let solution = solve(scene, &options).unwrap();
            for at in [[0.0, 0.5], [0.3, 0.2], [0.52, 0.61], [0.8, 0.9]] {
                let (azimuth, polar) = (TAU * at[0], PI * at[1]);
                let x = 2.0 * DVec3::new(polar.sin() * azimuth.cos(), polar.sin() * azimuth.sin(), polar.cos());
                // The light that the ball takes away, all of it being above the horizon.
                let (away, up) = ((centre - x).length(), -x.dot(centre - x) / 2.0);
                let exact = 1.0 - radius * radius * up / away.powi(3);
                if up <= radius {
                    continue;
                }
                let gathered = solution.gather(0, at).unwrap();
                let error = (gathered.irradiance - exact).abs();
                assert!(error <= gathered.irradiance_bound, "{radius} {offset} {most_cells} {at:?}: {error:e} {gathered:?}");
            }
        }
    }
}
