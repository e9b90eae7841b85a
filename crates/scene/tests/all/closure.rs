//! The form factors from a point of a closed scene add up to 1: files, index and closed forms together.

use radgrad_core::{DVec3, Emission, Emitter, Polygon, Receiver, evaluate};
use radgrad_scene::{Beam, Degenerate, Found, Occluders, Scene};

/// The sum of the form factors from a point of a face to all others, its bound, and the results of the searches.
fn closure(scene: &Scene, index: &Occluders, face: usize, point: DVec3) -> (f64, f64, Vec<Found>) {
    let own = scene.faces()[face].polygon();
    let receiver = Receiver::new(point, own.normal(), 1.0).unwrap();
    let (mut sum, mut error, mut searches) = (0.0, 0.0, Vec::new());
    for (j, polygon) in scene.polygons().enumerate().filter(|(j, _)| *j != face) {
        let Some(beam) = Beam::from_point_of(own, point, polygon) else { continue };
        let search = index.in_beam(&beam, &[face, j]);
        let hiding = search.polygons.iter().map(|&i| scene.faces()[i].polygon());
        let emitter = Emitter::new(polygon.clone(), Emission::Constant(1.0)).unwrap();
        let answer = evaluate(&receiver, &emitter, hiding).unwrap();
        (sum, error) = (sum + answer.radiosity, error + answer.radiosity_error);
        searches.push(search);
    }
    (sum, error, searches)
}

/// The Cornell box, with its open side closed.
fn closed_cornell_box() -> Scene {
    let file = concat!(env!("CARGO_MANIFEST_DIR"), "/../../data/scenes/cornell.obj");
    let mut scene = Scene::read(file, Degenerate::Refuse).unwrap();
    let front = scene.add_surface("front");
    let corners = [[0.0, 0.0, 0.0], [552.8, 0.0, 0.0], [556.0, 548.8, 0.0], [0.0, 548.8, 0.0]];
    scene.add_face(front, 0, Polygon::new(corners.map(DVec3::from).to_vec()).unwrap(), None).unwrap();
    scene
}

#[test]
fn every_point_of_a_closed_room_sees_all_around() {
    let scene = closed_cornell_box();
    let index = Occluders::new(scene.polygons());
    let (mut searches, mut occluded) = (0, 0);
    for (face, polygon) in scene.polygons().enumerate() {
        for weights in [[6.0, 3.0, 1.0], [1.0, 1.0, 6.0]] {
            let weighted = weights.iter().zip(polygon.vertices()).map(|(&w, &v)| v * w);
            let point = weighted.sum::<DVec3>() / weights.iter().sum::<f64>();
            let (sum, error, found) = closure(&scene, &index, face, point);
            // The point itself is off its face by an ulp or so.
            assert!((sum - 1.0).abs() <= error + 4.0 * f64::EPSILON && error < 1e-12, "face {face}, {point}: {sum} +- {error:e}");
            searches += found.len();
            occluded += found.iter().filter(|found| !found.polygons.is_empty()).count();
        }
    }
    assert!(2 * occluded < searches, "of {searches} searches {occluded} found something");
}
