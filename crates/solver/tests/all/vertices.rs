//! Derivatives by vertices are those of solutions of scenes that were moved.

use radgrad_core::{DVec3, Polygon};
use radgrad_scene::{Degenerate, Scene, Surface};
use radgrad_solver::{Options, WeightedSum, solve};

/// The error of the solutions, the step of differences, and the error that derivatives may have, of their norm.
const ERROR: f64 = 2e-3;
const STEP: f64 = 1e-2;
const PART: f64 = 0.01;

/// The Cornell box with a closed ceiling, below which its light hangs, in metres, each vertex moved by `by`, which knows the face and the vertex.
fn cornell(by: impl Fn(&str, usize, DVec3) -> DVec3) -> Scene {
    let read = Scene::read(concat!(env!("CARGO_MANIFEST_DIR"), "/../../data/scenes/cornell.obj"), Degenerate::Refuse).unwrap();
    let mut scene = Scene::new(["red", "green", "blue"]).unwrap();
    let outlines: Vec<Vec<DVec3>> =
        read.polygons().map(|polygon| polygon.vertices().iter().map(|vertex| *vertex / 1000.0).collect()).collect();
    let materials: Vec<usize> = read
        .materials()
        .iter()
        .map(|of| scene.add_material(of.name(), of.reflectance().to_vec(), of.radiance().to_vec()).unwrap())
        .collect();
    let surfaces: Vec<usize> = read.surfaces().iter().map(|surface| scene.add_surface(surface.name())).collect();
    let mut add = |surface: usize, material: usize, outline: &[DVec3]| {
        let name = read.surfaces()[surface].name();
        let face = scene.faces().len();
        let moved = outline.iter().enumerate().map(|(vertex, at)| *at + by(name, face * 10 + vertex, *at));
        scene.add_face(surfaces[surface], materials[material], Polygon::new(moved.collect()).unwrap(), None).unwrap();
    };
    for (face, outline) in read.faces().iter().zip(&outlines) {
        let (surface, material) = (face.surface(), face.material());
        if read.surfaces()[surface].name() == "light" {
            let ceiling = read.faces().iter().find(|face| read.surfaces()[face.surface()].name() == "ceiling").unwrap();
            add(ceiling.surface(), ceiling.material(), outline);
            let hung: Vec<DVec3> = outline.iter().map(|vertex| *vertex - DVec3::Y * 0.06).collect();
            add(surface, material, &hung);
        } else {
            add(surface, material, outline);
        }
    }
    scene
}

/// The mean of the floor in each channel, all by itself.
fn of_floor(scene: &Scene) -> WeightedSum {
    let weights = |surface: &Surface| vec![if surface.name() == "floor" { 1.0 } else { 0.0 }; 3];
    WeightedSum { surfaces: scene.surfaces().iter().map(weights).collect(), points: Vec::new() }
}

/// The motion of a surface's vertices, by their index in the face and their place.
type Motion<'a> = (&'a str, &'a dyn Fn(usize, DVec3) -> DVec3);

/// Each vertex's motion, in an order that is no one's.
fn shaken(index: usize) -> f64 {
    (index as f64 * 2.399_963 + 0.4).sin()
}

#[test]
fn derivatives_by_vertices_are_differences_of_moved_scenes() {
    let still = cornell(|_, _, _| DVec3::ZERO);
    let options = Options { error: ERROR, ..Options::default() };
    let solution = solve(&still, &options, |_| true).unwrap();
    let faces_of = |name: &str| -> Vec<usize> {
        let is_of = |face: &usize| still.surfaces()[still.faces()[*face].surface()].name() == name;
        (0..still.faces().len()).filter(is_of).collect()
    };
    let value = |scene: &Scene| {
        let solution = solve(scene, &options, |_| true).unwrap();
        solution.derivative(scene, &of_floor(scene)).unwrap().value
    };
    let is_top = |at: DVec3| at.y > 0.3;
    let middle = DVec3::new(0.278, 0.4888, 0.2795);
    let motions: [Motion<'_>; 3] = [
        ("light", &|_, at| 5.0 * DVec3::new(0.3, 0.2, 1.0).cross(at - middle)),
        ("light", &|vertex, _| DVec3::new(shaken(vertex), 0.0, shaken(vertex + 7))),
        ("tall", &|_, at| if is_top(at) { DVec3::new(0.8, 0.0, -0.6) } else { DVec3::ZERO }),
    ];
    let [light, tall] = ["light", "tall"].map(|name| {
        let faces = faces_of(name);
        let by = solution.derivative_by_vertices(&still, &of_floor(&still), &faces).unwrap();
        (faces, by)
    });
    for (name, motion) in motions {
        let (faces, by) = if name == "light" { &light } else { &tall };
        let moved = |step: f64| cornell(|of, vertex, at| if of == name { motion(vertex % 10, at) * step } else { DVec3::ZERO });
        let [ahead, behind] = [STEP, -STEP].map(|step| value(&moved(step)));
        for channel in 0..3 {
            let (mut slope, mut size, mut way) = (0.0, 0.0, 0.0);
            for (&face, by) in faces.iter().zip(&by.vertices) {
                let outline = still.polygons().nth(face).unwrap().vertices();
                for (vertex, (at, by)) in outline.iter().zip(by).enumerate() {
                    slope += by[channel].dot(motion(vertex, *at));
                    size += by[channel].length_squared();
                    way += motion(vertex, *at).length_squared();
                }
            }
            let (difference, size) = ((ahead[channel] - behind[channel]) / (2.0 * STEP), size.sqrt());
            let (size, estimate) = (size * way.sqrt(), by.estimate[channel] * way.sqrt());
            println!(
                "{name} {channel}: {slope:.6} {difference:.6}, {:.2e} of {size:.4}, {:.1e}",
                (slope - difference) / size,
                estimate
            );
            assert!((slope - difference).abs() <= PART * size, "{name} {channel}: {slope} {difference} {size}");
            assert!((slope - difference).abs() <= 4.0 * estimate && estimate < 0.1 * size);
        }
    }
}

#[test]
fn a_scene_that_moves_as_a_whole_with_its_points_keeps_its_light() {
    let scene = cornell(|_, _, _| DVec3::ZERO);
    let error = 0.05;
    let solution = solve(&scene, &Options { error, ..Options::default() }, |_| true).unwrap();
    let faces: Vec<usize> = (0..scene.faces().len()).collect();
    let by = solution.derivative_by_vertices(&scene, &of_floor(&scene), &faces).unwrap();
    let total = |pick: &dyn Fn(DVec3, DVec3) -> f64| -> [f64; 2] {
        let pairs = scene.polygons().zip(&by.vertices).flat_map(|(polygon, by)| polygon.vertices().iter().zip(by));
        pairs.fold([0.0; 2], |[sum, size], (at, by)| {
            let value = pick(*at, by[0]);
            [sum + value, size + value.abs()]
        })
    };
    // Shifted, turned or scaled: irradiances are the same, and the sums are within the error asked for.
    for axis in [DVec3::X, DVec3::Y, DVec3::Z] {
        let shifted = total(&|_, by| by.dot(axis));
        let turned = total(&|at, by| axis.cross(at).dot(by));
        println!("{axis} {shifted:?} {turned:?}");
        assert!(shifted[0].abs() < error * shifted[1] && turned[0].abs() < error * turned[1], "{shifted:?} {turned:?}");
    }
    let scaled = total(&|at, by| at.dot(by));
    println!("{scaled:?}");
    assert!(scaled[0].abs() < error * scaled[1], "{scaled:?}");
}

#[test]
fn faces_that_are_not_there_or_twice_are_refused() {
    let scene = cornell(|_, _, _| DVec3::ZERO);
    let solution = solve(&scene, &Options { error: 0.5, ..Options::default() }, |_| true).unwrap();
    let refused = |faces: &[usize]| solution.derivative_by_vertices(&scene, &of_floor(&scene), faces).unwrap_err().to_string();
    assert!(refused(&[99]).contains("face 99") && refused(&[1, 2, 1]).contains("face 1 is asked for twice"));
}
