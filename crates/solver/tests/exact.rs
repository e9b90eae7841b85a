//! Exact solutions: inside the stated bound, and as near as the default effort promises.

use std::f64::consts::PI;

use radgrad_core::Polygon;
use radgrad_scene::Scene;
use radgrad_solver::{Options, Solution, solve};

type Quad = [[f64; 3]; 4];

/// A scene of one channel: each face with its reflectance and the radiosity that it emits.
fn scene(faces: &[(Quad, f64, f64)]) -> Scene {
    let mut scene = Scene::new(["grey"]).unwrap();
    for (index, (corners, reflectance, emitted)) in faces.iter().enumerate() {
        let material = scene.add_material(index.to_string(), [*reflectance], [emitted / PI]).unwrap();
        let surface = scene.add_surface(index.to_string());
        let polygon = Polygon::new(corners.iter().map(|&p| p.into()).collect()).unwrap();
        scene.add_face(surface, material, polygon, None).unwrap();
    }
    scene
}

fn solved(faces: &[(Quad, f64, f64)], options: &Options) -> Solution {
    solve(&scene(faces), options, |_| true).unwrap()
}

/// Radiosity at a point, after a check that it is within its bound of `exact`; the bound over the error is returned with it.
fn checked(solution: &Solution, point: [f64; 3], normal: [f64; 3], exact: f64) -> (f64, f64) {
    let gathered = solution.gather(point.into(), normal.into()).unwrap();
    let (value, bound) = (gathered.radiosity[0], gathered.ledger[0].total());
    assert!((value - exact).abs() <= bound, "{point:?}: {value} off {exact} by more than {bound:e}");
    (value, bound / (value - exact).abs())
}

const FLOOR: Quad = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
const CEILING: Quad = [[0.0, 0.0, 1.0], [0.0, 1.0, 1.0], [1.0, 1.0, 1.0], [1.0, 0.0, 1.0]];
const SIDES: [Quad; 4] = [
    [[0.0, 0.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 1.0], [1.0, 0.0, 0.0]],
    [[0.0, 1.0, 0.0], [1.0, 1.0, 0.0], [1.0, 1.0, 1.0], [0.0, 1.0, 1.0]],
    [[0.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 1.0, 1.0], [0.0, 0.0, 1.0]],
    [[1.0, 0.0, 0.0], [1.0, 0.0, 1.0], [1.0, 1.0, 1.0], [1.0, 1.0, 0.0]],
];

#[test]
fn a_furnace_glows_evenly() {
    let quads: Vec<Quad> = [FLOOR, CEILING].into_iter().chain(SIDES).collect();
    let rho = [0.9, 0.1, 0.5, 0.3, 0.7, 0.2];
    let faces: Vec<_> = quads.into_iter().zip(rho).map(|(quad, rho)| (quad, rho, 1.0 - rho)).collect();
    for degree in 0..=3 {
        let solution = solved(&faces, &Options { degree, ..Options::default() });
        for point in [[0.5, 0.5, 0.0], [0.01, 0.02, 0.0], [0.999, 0.3, 0.0]] {
            let (value, _) = checked(&solution, point, [0.0, 0.0, 1.0], 1.0);
            assert!((value - 1.0).abs() < 1e-10, "degree {degree}: {value}");
        }
        assert!(solution.mean_bound()[0].total() < 1e-9, "{:?}", solution.mean_bound());
    }
}

#[test]
fn two_squares_that_face_each_other_have_the_known_radiosity() {
    let faces = [(FLOOR, 0.5, 1.0), (CEILING, 0.5, 1.0)];
    for degree in 0..=3 {
        let solution = solved(&faces, &Options { degree, ..Options::default() });
        let known = [([0.5, 0.5, 0.0], 1.133_303_564_992_420_8), ([0.0, 0.0, 0.0], 1.076_981_393_145_044_5)];
        for (point, exact) in known {
            let (value, index) = checked(&solution, point, [0.0, 0.0, 1.0], exact);
            println!("degree {degree}: {value} error {:.1e}, effectivity {index:.1}, {:?}", value - exact, solution.progress());
        }
    }
}

#[test]
fn at_the_apex_of_a_groove_the_radiosity_is_that_of_a_wedge() {
    // Two long strips that meet at an angle: far from all other edges, at the apex, each sees (1 + cos phi)/2 of the other.
    for phi in [1.0_f64, 2.0] {
        let (far, half) = (1e3, 1e3);
        let away = [far * phi.cos(), far * phi.sin()];
        let flat = [[0.0, -half, 0.0], [far, -half, 0.0], [far, half, 0.0], [0.0, half, 0.0]];
        let slanted = [[0.0, -half, 0.0], [0.0, half, 0.0], [away[0], half, away[1]], [away[0], -half, away[1]]];
        let rho = 0.5;
        let solution = solved(&[(flat, rho, 1.0), (slanted, rho, 1.0)], &Options { degree: 1, ..Options::default() });
        let exact = 1.0 / (1.0 - 0.5 * rho * (1.0 + phi.cos()));
        let (value, index) = checked(&solution, [1e-3, 0.0, 0.0], [0.0, 0.0, 1.0], exact);
        println!("{phi}: {value} {exact} {index} {:?}", solution.progress());
    }
}
