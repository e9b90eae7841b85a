//! Points on edges where faces meet, and beside them.

use radgrad_core::{DVec3, Polygon};
use radgrad_scene::Scene;

use crate::solve::options::Options;
use crate::solve::solution::Solution;
use crate::solve::solve;

/// Two unit squares that meet in the y axis at an angle, with a reflectance and a radiosity of their own each.
fn groove(angle: f64, reflectance: [f64; 2], emitted: [f64; 2]) -> Scene {
    let mut scene = Scene::new(["grey"]).unwrap();
    let surface = scene.add_surface("groove");
    let away = DVec3::new(angle.cos(), 0.0, angle.sin());
    let corners = [[DVec3::ZERO, DVec3::X, DVec3::X + DVec3::Y, DVec3::Y], [DVec3::ZERO, DVec3::Y, away + DVec3::Y, away]];
    for (side, corners) in corners.into_iter().enumerate() {
        let radiance = emitted[side] * std::f64::consts::FRAC_1_PI;
        let material = scene.add_material(["floor", "wall"][side], [reflectance[side]], [radiance]).unwrap();
        scene.add_face(surface, material, Polygon::new(corners.to_vec()).unwrap(), None).unwrap();
    }
    scene
}

/// At the edge the two see nothing but each other: `B = E + rho F B'` with `F = (1 + cos alpha)/2`, whatever the faces' sizes.
#[test]
fn at_the_apex_of_a_groove_the_answer_is_exact_to_a_millionth() {
    for angle in [0.5, 1.0, std::f64::consts::FRAC_PI_2, 2.2] {
        for (rho, emitted) in [([0.5, 0.5], [1.0, 1.0]), ([0.8, 0.3], [1.0, 0.0])] {
            let solution = solve(&groove(angle, rho, emitted), &Options::default(), |_| true).unwrap();
            let factor = 0.5 * (1.0 + angle.cos());
            let normals = [DVec3::Z, DVec3::new(angle.sin(), 0.0, -angle.cos())];
            for (side, normal) in normals.into_iter().enumerate() {
                let [own, other] = [side, 1 - side];
                let exact = (emitted[own] + rho[own] * factor * emitted[other]) / (1.0 - rho[0] * rho[1] * factor * factor);
                for y in [0.1, 0.25, 0.37, 0.5, 0.9] {
                    let gather = solution.gather(DVec3::new(0.0, y, 0.0), normal).unwrap();
                    let (value, estimate) = (gather.radiosity[0], gather.estimate[0].total());
                    let error = (value - exact).abs();
                    assert!(error < 1e-6 * exact, "{angle} {rho:?} {side} {y}: {value} for {exact}");
                    assert!(error <= 2.0 * estimate, "{angle} {rho:?} {side} {y}: {error:e}, {estimate:e}");
                }
            }
        }
    }
}

#[test]
fn beside_the_apex_the_answer_is_far_nearer_than_polynomials_are_and_the_estimate_says_so() {
    let scene = groove(1.0, [0.5, 0.5], [1.0, 1.0]);
    let [rough, fine] = [1e-3, 2e-6].map(|error| solve(&scene, &Options { error, ..Options::default() }, |_| true).unwrap());
    for y in [0.3, 0.5, 0.8] {
        for x in [1e-6, 1e-4, 1e-3, 1e-2, 3e-2] {
            let gather = |solution: &Solution| solution.gather(DVec3::new(x, y, 0.0), DVec3::Z).unwrap();
            let (found, truth) = (gather(&rough), gather(&fine));
            let error = (found.radiosity[0] - truth.radiosity[0]).abs();
            // Of the polynomials alone it was 4e-3 at the edge.
            assert!(error < if x < 5e-3 { 1e-4 } else { 5e-4 }, "({x}, {y}): {error:e}");
            assert!(error <= 2.0 * found.estimate[0].total() + truth.estimate[0].total(), "({x}, {y}): {error:e}");
        }
    }
}

/// The light rises to the edge as a power of the distance, and so does its slope.
#[test]
fn beside_the_apex_the_gradient_is_that_of_a_finer_solution() {
    let scene = groove(1.0, [0.5, 0.5], [1.0, 1.0]);
    let [rough, fine] = [1e-3, 2e-6].map(|error| solve(&scene, &Options { error, ..Options::default() }, |_| true).unwrap());
    for y in [0.3, 0.5, 0.8] {
        for x in [1e-4, 1e-3, 1e-2, 3e-2] {
            let radiosity = |x: f64| fine.gather(DVec3::new(x, y, 0.0), DVec3::Z).unwrap().radiosity[0];
            let slope = (radiosity(1.01 * x) - radiosity(0.99 * x)) / (0.02 * x);
            let computed = rough.gradient(DVec3::new(x, y, 0.0), DVec3::Z).unwrap().radiosity;
            let error = (computed.gradient[0].x - slope).abs();
            assert!(error < 0.02 * slope.abs(), "({x}, {y}): {} for {slope}", computed.gradient[0].x);
            assert!(error <= 2.0 * computed.estimate[0], "({x}, {y}): {error:e}, {:e}", computed.estimate[0]);
        }
    }
}

/// A point on the border is one inside, whichever of two leaves it is between and by how little it misses the face.
#[test]
fn on_an_edge_and_a_little_beside_it_the_answer_is_the_same() {
    let solution = solve(&groove(1.0, [0.5, 0.5], [1.0, 1.0]), &Options::default(), |_| true).unwrap();
    let radiosity = |x: f64, y: f64| solution.gather(DVec3::new(x, y, 0.0), DVec3::Z).unwrap().radiosity[0];
    for (x, y) in [(-1e-9, 0.5), (1e-12, 0.5), (1e-8, 0.25), (0.0, 0.25 + 1e-9)] {
        assert!((radiosity(x, y) - radiosity(0.0, y)).abs() < 2e-6, "({x:e}, {y}): {} {}", radiosity(x, y), radiosity(0.0, y));
    }
}
