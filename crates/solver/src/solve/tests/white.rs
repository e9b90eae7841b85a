//! Faces that reflect all light, or nearly: solved where any is lost, and refused where none is.

use radgrad_core::{DVec3, Polygon};
use radgrad_scene::Scene;

use crate::error::Error;
use crate::solve::options::Options;
use crate::solve::solution::Solution;
use crate::solve::solve;

/// Which way the faces of a box look.
#[derive(Clone, Copy, PartialEq)]
enum Facing {
    Inward,
    Outward,
}

/// Adds the faces of a box, each of a surface and a material of its own: reflectance and emitted radiosity.
fn add_box(scene: &mut Scene, name: &str, [low, high]: [[f64; 3]; 2], facing: Facing, faces: &[[f64; 2]]) {
    for (index, &[rho, emitted]) in faces.iter().enumerate() {
        let (axis, end) = (index / 2, index % 2);
        let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
        let mut corners = [[0, 0], [1, 0], [1, 1], [0, 1]].map(|[i, j]| {
            let mut corner = [0.0; 3];
            corner[axis] = [low, high][end][axis];
            corner[u] = [low, high][i][u];
            corner[v] = [low, high][j][v];
            DVec3::from(corner)
        });
        if (end == 1) == (facing == Facing::Inward) {
            corners.reverse();
        }
        let radiance = emitted * std::f64::consts::FRAC_1_PI;
        let material = scene.add_material(format!("{name} {index}"), [rho], [radiance]).unwrap();
        let surface = scene.add_surface(format!("{name} {index}"));
        scene.add_face(surface, material, Polygon::new(corners.to_vec()).unwrap(), None).unwrap();
    }
}

const ROOM: [[f64; 3]; 2] = [[0.0; 3], [5.0; 3]];

fn scene() -> Scene {
    Scene::new(["grey"]).unwrap()
}

fn room(faces: &[[f64; 2]]) -> Scene {
    let mut scene = scene();
    add_box(&mut scene, "room", ROOM, Facing::Inward, faces);
    scene
}

fn solved(scene: &Scene) -> Result<Solution, Error> {
    solve(scene, &Options { error: 0.05, degree: Some(1), first_elements: 24, ..Options::default() }, |_| false)
}

#[test]
fn light_that_is_lost_somewhere_is_solved_though_faces_reflect_all() {
    // A white ceiling, as bright as one that reflects nearly all.
    let with_ceiling = |rho: f64| room(&[[0.2, 0.0], [0.2, 0.0], [0.2, 1.0], [0.2, 0.0], [0.2, 0.0], [rho, 0.0]]);
    let [white, nearly] = [1.0, 1.0 - 1e-9].map(|rho| solved(&with_ceiling(rho)).unwrap());
    assert!((white.mean()[0] / nearly.mean()[0] - 1.0).abs() < 1e-6, "{:?} {:?}", white.mean(), nearly.mean());
    let estimate = white.mean_estimate()[0].total();
    assert!(estimate.is_finite() && estimate > 0.0);

    // All white, and open on one side; the rest, black, takes the light that leaves by the opening: all emitted light is sent
    // out.
    let closed = |last: [f64; 2]| room(&[[1.0, 0.0], [1.0, 0.0], [1.0, 1.0], [1.0, 0.0], [1.0, 0.0], last]);
    let open = room(&[[1.0, 0.0], [1.0, 0.0], [1.0, 1.0], [1.0, 0.0], [1.0, 0.0]]);
    let [open, black] = [open, closed([0.0, 0.0])].map(|scene| solved(&scene).unwrap());
    let [of_five, of_six] = [(&open, 5.0), (&black, 6.0)].map(|(of, faces)| faces * of.mean()[0]);
    assert!((of_five / of_six - 1.0).abs() < 0.01, "{of_five:?} {of_six:?}");
    // The black face's irradiance is all that is emitted, over its area.
    let irradiance = |x: f64, y: f64| black.gather(DVec3::new(x, y, 5.0), -DVec3::Z).unwrap().irradiance.irradiance[0];
    let places = [0.1, 0.3, 0.5, 0.7, 0.9].map(|x| 5.0 * x);
    let mean = places.iter().flat_map(|&x| places.map(|y| irradiance(x, y))).sum::<f64>() / 25.0;
    assert!((mean - 1.0).abs() < 0.03, "{mean}");
}

#[test]
fn a_closed_lit_space_whose_faces_reflect_all_is_refused_by_name_and_a_dark_one_is_dark() {
    let white = |emitted: f64| [[1.0, emitted], [1.0, 0.0], [1.0, 0.0], [1.0, 0.0], [1.0, 0.0], [1.0, 0.0]];
    let Err(Error::Lossless { channel, surfaces }) = solved(&room(&white(1.0))) else { panic!("no solution") };
    assert_eq!((channel.as_str(), surfaces.len(), surfaces[0].as_str()), ("grey", 6, "room 0"));

    // A patch that absorbs, too small for a ray to find, stands in it.
    let mut scene = room(&white(1.0));
    add_box(&mut scene, "speck", [[2.5; 3], [2.501; 3]], Facing::Outward, &[[0.0, 0.0]; 6]);
    assert!(!matches!(solved(&scene), Err(Error::Lossless { .. })));

    // A white cupboard, closed, in a grey room that is lit: lit inside it has no solution, dark it changes nothing.
    let grey = [[0.5, 1.0], [0.5, 0.0], [0.5, 0.0], [0.5, 0.0], [0.5, 0.0], [0.5, 0.0]];
    let with_cupboard = |inside: &[[f64; 2]]| {
        let mut scene = room(&grey);
        add_box(&mut scene, "outside", [[1.0; 3], [2.0; 3]], Facing::Outward, &[[0.5, 0.0]; 6]);
        add_box(&mut scene, "inside", [[1.0; 3], [2.0; 3]], Facing::Inward, inside);
        scene
    };
    let Err(error) = solved(&with_cupboard(&white(1.0))) else { panic!("no solution") };
    assert!(error.to_string().contains("`inside 0`") && !error.to_string().contains("room"), "{error}");
    let [dark, black] = [white(0.0), [[0.0, 0.0]; 6]].map(|inside| solved(&with_cupboard(&inside)).unwrap());
    assert_eq!(dark.mean(), black.mean());
    assert!(dark.mean_estimate()[0].total().is_finite());
}

#[test]
fn sweeps_where_hardly_any_light_is_lost_are_few() {
    // Of the same reflectance everywhere the mean is that of the emission over the lost part, up to the error of form factors.
    let rho = 0.995;
    let scene = room(&[[rho, 1.0], [rho, 0.0], [rho, 0.0], [rho, 0.0], [rho, 0.0], [rho, 0.0]]);
    let mut solution = solved(&scene).unwrap();
    let receivers = solution.system.receivers.clone();
    for &receiver in &receivers {
        let change: Vec<f64> = solution.radiosity.own[receiver].iter().map(|held| -held).collect();
        solution.radiosity.own[receiver].fill(0.0);
        solution.radiosity.field.add(&solution.system.mesh, receiver, 0, &change);
    }
    let before = solution.progress.gathers;
    solution.sweep(1e-8).unwrap();
    let sweeps = (solution.progress.gathers - before) / receivers.len();
    assert!(sweeps < 150, "{sweeps}");
    let exact = 1.0 / 6.0 / (1.0 - rho);
    assert!((solution.radiosity.mean[0] / exact - 1.0).abs() < 0.1, "{:?} {exact}", solution.radiosity.mean);
}
