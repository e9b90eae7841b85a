//! Plates of two sides among more than a thousand faces, and plates close to each other.

use radgrad_core::{DVec3, Polygon};
use radgrad_scene::Scene;

use crate::solve::options::Options;
use crate::solve::solve;

/// Squares along a side of each wall.
const SQUARES: u32 = 13;

/// Reflectances of a wall and of the two sides of the plate; each emits the light that it does not reflect, so that the radiosity
/// is 1.
const WALL: f64 = 0.5;
const SIDES: [f64; 2] = [0.3, 0.8];

#[test]
fn light_is_even_on_both_sides_of_a_turned_plate_among_a_thousand_faces() {
    for axis in [DVec3::ZERO, DVec3::new(0.3, -0.5, 0.2)] {
        // The tangent of half the angle, along the axis (O. Rodrigues 1840).
        let turn = |v: DVec3| {
            let w = (v + axis.cross(v)) / (1.0 + axis.length_squared());
            v + 2.0 * axis.cross(w)
        };
        let mut scene = Scene::new(["grey"]).unwrap();
        let mut add = |corners: [DVec3; 4], rho: f64| {
            let material = scene.add_material(format!("{rho}"), [rho], [(1.0 - rho) * std::f64::consts::FRAC_1_PI]).unwrap();
            let surface = scene.add_surface("all");
            let polygon = Polygon::new(corners.map(turn).to_vec()).unwrap();
            scene.add_face(surface, material, polygon, None).unwrap();
        };
        for wall in 0..6_usize {
            let (axis, end) = (wall / 2, if wall % 2 == 1 { 1.0 } else { 0.0 });
            let corner_of = |i: u32, j: u32| {
                let mut corner = [end; 3];
                (corner[(axis + 1) % 3], corner[(axis + 2) % 3]) =
                    (f64::from(i) / f64::from(SQUARES), f64::from(j) / f64::from(SQUARES));
                DVec3::from(corner)
            };
            for (i, j) in (0..SQUARES).flat_map(|i| (0..SQUARES).map(move |j| (i, j))) {
                let mut corners = [corner_of(i, j), corner_of(i + 1, j), corner_of(i + 1, j + 1), corner_of(i, j + 1)];
                if wall % 2 == 1 {
                    corners.reverse();
                }
                add(corners, WALL);
            }
        }
        let (centre, u, v) = (DVec3::new(0.4, 0.5, 0.45), DVec3::new(0.2, 0.0, 0.1), DVec3::new(0.0, 0.25, 0.05));
        let mut plate = [centre - u - v, centre + u - v, centre + u + v, centre - u + v];
        add(plate, SIDES[0]);
        plate.reverse();
        add(plate, SIDES[1]);
        let options = Options { error: 1.0, degree: Some(0), first_elements: 1, ..Options::default() };
        let solution = solve(&scene, &options, |_| false).unwrap();
        assert!((solution.mean()[0] - 1.0).abs() < 1e-6, "{:?}", solution.mean());
        for side in [1.0, -1.0] {
            let normal = turn(u.cross(v).normalize() * side);
            for at in [centre, centre + 0.7 * u - 0.3 * v] {
                let irradiance = solution.gather(turn(at), normal).unwrap().irradiance.irradiance[0];
                assert!((irradiance - 1.0).abs() < 1e-6, "{side} {at}: {irradiance}");
            }
        }
    }
}

/// The radiosity near a corner of two plates a hundredth of their size apart, of which the lower one glows: no polynomial on either follows it.
#[test]
fn the_rim_of_a_narrow_gap_is_within_its_estimate() {
    let mut scene = Scene::new(["grey"]).unwrap();
    let (glowing, grey) = (
        scene.add_material("glowing", [0.9], [std::f64::consts::FRAC_1_PI]).unwrap(),
        scene.add_material("grey", [0.9], [0.0]).unwrap(),
    );
    let surface = scene.add_surface("plates");
    let corners = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
    let (low, mut high) = (corners.map(|[x, y]| DVec3::new(x, y, 0.0)), corners.map(|[x, y]| DVec3::new(x, y, 0.01)));
    high.reverse();
    scene.add_face(surface, glowing, Polygon::new(low.to_vec()).unwrap(), None).unwrap();
    scene.add_face(surface, grey, Polygon::new(high.to_vec()).unwrap(), None).unwrap();
    let solution = solve(&scene, &Options { error: 0.05, ..Options::default() }, |_| true).unwrap();
    let rim = solution.gather(DVec3::new(0.999, 0.999, 0.0), DVec3::Z).unwrap();
    // By random walks, with their standard error.
    let (truth, error) = (1.314_13, 0.009_61);
    let (value, estimate) = (rim.radiosity[0], rim.estimate[0].total());
    assert!((value - truth).abs() <= 2.0 * estimate + 5.0 * error && estimate < 0.5, "{value} +- {estimate}");
}
