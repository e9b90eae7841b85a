//! Irradiance in free space, where it is known and where it meets that of faces.

use radgrad_core::{DVec3, Polygon};
use radgrad_scene::{Degenerate, Prepared, Scene};

use crate::error::Error;
use crate::mesh::Mesh;
use crate::solve::gather::Irradiance;
use crate::solve::goal_points::GoalPoints;
use crate::solve::options::Options;
use crate::solve::solution::Solution;
use crate::solve::{solve, solve_on};

/// A closed room with a block in it, in which all faces glow and reflect evenly: so the radiosity is `E/(1 - rho)` everywhere.
fn even_room() -> Scene {
    let mut scene = Scene::new(["dim", "bright"]).unwrap();
    let emitted = [1.0, 3.0].map(|e| e * std::f64::consts::FRAC_1_PI);
    let (white, surface) = (scene.add_material("white", [0.25, 0.5], emitted).unwrap(), scene.add_surface("all"));
    let mut add_box = |low: [f64; 3], high: [f64; 3], outward: bool| {
        let corner = |i: usize| DVec3::from([0, 1, 2].map(|k| if i >> k & 1 == 0 { low[k] } else { high[k] }));
        for face in [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]] {
            let mut corners = face.map(corner).to_vec();
            if !outward {
                corners.reverse();
            }
            scene.add_face(surface, white, Polygon::new(corners).unwrap(), None).unwrap();
        }
    };
    add_box([0.0; 3], [4.0, 3.0, 2.5], false);
    add_box([1.0, 1.0, 0.5], [2.0, 1.5, 1.5], true);
    scene
}

/// Solved, with clusters though there are few faces.
fn clustered(scene: &Scene, options: &Options) -> Solution {
    let ready = Prepared::new(scene).unwrap();
    let mesh = Mesh::new(&ready.scene, 2).unwrap().clustered();
    solve_on(&ready, options, (mesh, GoalPoints::default()), |_| true).unwrap()
}

fn held(received: &Irradiance, exact: [f64; 2]) {
    for (channel, exact) in exact.into_iter().enumerate() {
        let (value, estimate) = (received.irradiance[channel], received.estimate[channel].total());
        assert!((value - exact).abs() <= 2.0 * estimate, "channel {channel}: {value} +- {estimate}, exactly {exact}");
    }
}

#[test]
fn in_a_room_that_glows_evenly_a_sensor_reads_the_same_wherever_and_however_it_is_held() {
    let scene = even_room();
    let exact = [1.0 / 0.75, 3.0 / 0.5];
    let by_links = solve(&scene, &Options { error: 0.01, ..Options::default() }, |_| true).unwrap();
    let by_clusters = clustered(&scene, &Options { error: 0.05, ..Options::default() });
    for position in [[0.5, 2.0, 0.85], [1.5, 0.9, 1.0], [1.5, 1.25, 1.5000001], [3.999, 0.001, 2.499]].map(DVec3::from) {
        for normal in [DVec3::Z, DVec3::new(-1.0, 2.0, -0.5), DVec3::new(0.0, -3.0, 0.0)] {
            let received = by_links.irradiance_at(position, normal).unwrap();
            held(&received, exact);
            assert!(received.irradiance.iter().zip(exact).all(|(value, exact)| (value - exact).abs() < 1e-6 * exact));
            held(&by_clusters.irradiance_at(position, normal).unwrap(), exact);
        }
    }
    // Inside the block only backs are seen.
    held(&by_links.irradiance_at(DVec3::new(1.5, 1.2, 1.0), DVec3::Z).unwrap(), [0.0; 2]);
}

#[test]
fn a_sensor_that_comes_to_a_face_reads_what_the_face_receives() {
    let file = concat!(env!("CARGO_MANIFEST_DIR"), "/../../data/scenes/cornell.obj");
    let options = Options { error: 5e-4, ..Options::default() };
    let solution = solve(&Scene::read(file, Degenerate::Refuse).unwrap(), &options, |_| true).unwrap();
    let mut lit = 0;
    for &root in solution.mesh().roots() {
        let element = &solution.mesh().elements()[root];
        let (point, normal) = (element.point([0.31, 0.37]), element.polygon().normal());
        let on_face = solution.gather(point, normal).unwrap();
        let above = solution.irradiance_at(point + normal * 1e-6, normal).unwrap();
        for channel in 0..3 {
            let [here, there] = [&on_face.irradiance, &above].map(|of| (of.irradiance[channel], of.estimate[channel].total()));
            // Each has links of its own, which neglect at most a tenth of the error asked for.
            let linked = 1e-3 * solution.reflected()[channel];
            assert!((here.0 - there.0).abs() <= 2e-3 * here.0 + linked, "{point} {channel}: {here:?} and {there:?}");
            lit += usize::from(here.0 > 0.0);
        }
        assert!(solution.is_on_a_face(point) && !solution.is_on_a_face(point + normal));
    }
    assert!(lit > 20);
}

#[test]
fn a_sensor_without_a_place_or_a_direction_is_refused_with_both() {
    let solution = solve(&even_room(), &Options { error: 0.5, ..Options::default() }, |_| false).unwrap();
    let nowhere = solution.irradiance_at(DVec3::new(f64::NAN, 0.0, 1.0), DVec3::Z).unwrap_err();
    assert!(matches!(nowhere, Error::Sample { .. }) && nowhere.to_string().contains("NaN"), "{nowhere}");
    let position = DVec3::new(1.0, 2.0, 0.85);
    let undirected = solution.irradiance_at(position, DVec3::ZERO).unwrap_err();
    assert!(matches!(undirected, Error::Sample { position: at, .. } if at == position), "{undirected}");
}
