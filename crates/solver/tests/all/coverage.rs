//! Estimates cover errors: in rooms of random shape with a block in them whose radiosity is known, and in the Cornell box against
//! values of a far finer solution.

use std::f64::consts::PI;

use radgrad_core::{DVec3, Polygon};
use radgrad_scene::{Degenerate, Scene, largest};
use radgrad_solver::{Marking, Options, Solution, solve};

/// Numbers in [0, 1) from a seed: the 64-bit generator of D. Knuth's MMIX.
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.next()
    }
}

/// The faces of a box of this size around the origin's corner, seen from inside, or of a box in it, seen from outside.
fn faces(low: DVec3, high: DVec3, inside: bool) -> Vec<[DVec3; 4]> {
    let corner = |i: usize| {
        let pick = |bit: usize, l: f64, h: f64| if i >> bit & 1 == 1 { h } else { l };
        DVec3::new(pick(0, low.x, high.x), pick(1, low.y, high.y), pick(2, low.z, high.z))
    };
    let quads = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]];
    let turned = |mut quad: [usize; 4]| {
        if !inside {
            quad.reverse();
        }
        quad.map(corner)
    };
    quads.into_iter().map(turned).collect()
}

fn room(random: &mut Random) -> (Scene, Vec<Polygon>) {
    let size = DVec3::new(random.between(0.7, 2.0), random.between(0.7, 2.0), random.between(0.7, 2.0));
    let low = size * random.between(0.2, 0.4);
    let high = low + size * random.between(0.1, 0.4);
    let mut scene = Scene::new(["grey"]).unwrap();
    let quads = faces(DVec3::ZERO, size, true).into_iter().chain(faces(low, high, false));
    let mut polygons = Vec::new();
    for (index, quad) in quads.enumerate() {
        let rho = random.between(0.05, 0.85);
        let material = scene.add_material(index.to_string(), [rho], [(1.0 - rho) / PI]).unwrap();
        let surface = scene.add_surface(index.to_string());
        let polygon = Polygon::new(quad.to_vec()).unwrap();
        polygons.push(polygon.clone());
        scene.add_face(surface, material, polygon, None).unwrap();
    }
    (scene, polygons)
}

fn point_on(polygon: &Polygon, random: &mut Random) -> DVec3 {
    let v = polygon.vertices();
    let (s, t) = (random.between(0.001, 0.999), random.between(0.001, 0.999));
    v[0] + (v[1] - v[0]) * s + (v[3] - v[0]) * t
}

#[test]
fn in_rooms_of_random_shape_that_glow_evenly_nothing_is_off_by_more_than_is_estimated() {
    // With E = 1 - rho in a closed room with a block that hangs in it, B = 1.
    let mut random = Random(3);
    for _ in 0..3 {
        let (scene, polygons) = room(&mut random);
        let options = Options { degree: Some(1), first_elements: 1, most_elements: 1, ..Options::default() };
        let solution = solve(&scene, &options, |_| true).unwrap();
        for polygon in &polygons {
            let gathered = solution.gather(point_on(polygon, &mut random), polygon.normal()).unwrap();
            let error = (gathered.radiosity[0] - 1.0).abs();
            assert!(error <= 2.0 * gathered.estimate[0].total() && error < 1e-9, "{error:e} {:?}", gathered.estimate[0]);
        }
    }
}

/// A closed room of this size in which boxes hang in rows, all with reflectances of their own and with `E = 1 - rho`: `B = 1`.
fn hanging_boxes(random: &mut Random, rows: [usize; 2]) -> (Scene, Vec<Polygon>) {
    let size = DVec3::new(rows[0] as f64, rows[1] as f64, 1.5);
    let mut quads = faces(DVec3::ZERO, size, true);
    for i in 0..rows[0] {
        for j in 0..rows[1] {
            let mut between = |low: f64, high: f64| random.between(low, high);
            let low = DVec3::new(i as f64 + between(0.1, 0.3), j as f64 + between(0.1, 0.3), between(0.1, 0.3));
            let high = DVec3::new(i as f64 + between(0.6, 0.9), j as f64 + between(0.6, 0.9), between(0.6, 1.4));
            quads.extend(faces(low, high, false));
        }
    }
    let mut scene = Scene::new(["grey"]).unwrap();
    let surface = scene.add_surface("all");
    let mut polygons = Vec::new();
    for (index, quad) in quads.into_iter().enumerate() {
        let rho = random.between(0.05, 0.85);
        let material = scene.add_material(index.to_string(), [rho], [(1.0 - rho) / PI]).unwrap();
        let polygon = Polygon::new(quad.to_vec()).unwrap();
        polygons.push(polygon.clone());
        scene.add_face(surface, material, polygon, None).unwrap();
    }
    (scene, polygons)
}

#[test]
fn among_many_boxes_that_glow_evenly_estimates_cover_what_is_neglected_of_clusters_of_far_faces() {
    let mut random = Random(11);
    let (scene, polygons) = hanging_boxes(&mut random, [12, 14]);
    let mut links = Vec::new();
    for error in [1.0, 0.2] {
        let options = Options { error, degree: Some(0), first_elements: 1, most_elements: 0, ..Options::default() };
        let solution = solve(&scene, &options, |_| true).unwrap();
        links.push(solution.progress().links);
        let (mut mean_error, mut estimate, mut exceeding) = (0.0, 0.0, 0);
        let some: Vec<&Polygon> = polygons.iter().step_by(7).collect();
        for &polygon in &some {
            let gathered = solution.gather(point_on(polygon, &mut random), polygon.normal()).unwrap();
            let (here, likely) = ((gathered.radiosity[0] - 1.0).abs(), gathered.estimate[0].total());
            exceeding += usize::from(here > 2.0 * likely);
            (mean_error, estimate) = (mean_error + here / some.len() as f64, estimate + likely / some.len() as f64);
        }
        println!(
            "{error}: {} links, {mean_error:.1e} off, {estimate:.1e} estimated, {exceeding} beyond twice that",
            links[links.len() - 1]
        );
        assert!(mean_error <= estimate && 20 * exceeding <= some.len(), "{mean_error:e} {estimate:e} {exceeding}");
    }
    // Clusters are in force.
    assert!(links[0] <= links[1] && 4 * links[1] < polygons.len() * polygons.len(), "{links:?}");
}

fn cornell() -> Scene {
    let file = concat!(env!("CARGO_MANIFEST_DIR"), "/../../data/scenes/cornell.obj");
    Scene::read(file, Degenerate::Refuse).unwrap()
}

/// Position, normal, radiosities and bounds on their errors, as `data/reference/cornell_radiosity.jsonl` has them.
fn references() -> Vec<[f64; 12]> {
    let text = include_str!("../../../../data/reference/cornell_radiosity.jsonl");
    let numbers = |line: &str| {
        let is_part = |c: char| c.is_ascii_digit() || matches!(c, '.' | '-' | 'e' | '+');
        let parts = line.split(|c: char| !is_part(c)).filter_map(|part| part.parse::<f64>().ok());
        parts.collect::<Vec<f64>>().try_into().unwrap()
    };
    text.lines().map(numbers).collect()
}

/// Mean error and mean estimate at the points of reference, over the mean radiosity that is reflected, the worst of the channels.
fn compared(solution: &Solution) -> [f64; 2] {
    let (mut errors, mut estimates, mut exceeding) = ([0.0; 3], [0.0; 3], 0);
    let references = references();
    for r in &references {
        let gathered = solution.gather([r[0], r[1], r[2]].into(), [r[3], r[4], r[5]].into()).unwrap();
        for channel in 0..3 {
            let error = (gathered.radiosity[channel] - r[6 + channel]).abs();
            let estimate = gathered.estimate[channel].total();
            exceeding += usize::from(error > 2.0 * estimate + r[9 + channel]);
            errors[channel] += error;
            estimates[channel] += estimate;
        }
    }
    assert!(
        20 * exceeding <= 3 * references.len(),
        "{exceeding} of {} are off by more than twice the estimate",
        3 * references.len()
    );
    let worst = |sums: [f64; 3]| {
        let relative_error = |channel: usize| sums[channel] / references.len() as f64 / solution.reflected()[channel];
        largest(largest(relative_error(0), relative_error(1)), relative_error(2))
    };
    [worst(errors), worst(estimates)]
}

#[test]
fn solutions_of_the_cornell_box_are_within_their_estimates_of_a_far_finer_one() {
    for (degree, error) in [(1, 0.1), (2, 0.02)] {
        // The estimate is that of the mean error of gathers.
        let options = Options { error, degree: Some(degree), marking: Marking::Gradient, ..Options::default() };
        let solution = solve(&cornell(), &options, |_| true).unwrap();
        let [gather_error, estimate] = compared(&solution);
        let stated = solution.progress().estimate;
        println!("degree {degree}: {gather_error:.1e} gather_error, {stated:.1e} stated in the mean, {estimate:.1e} at points");
        assert!(stated <= error && gather_error <= stated && gather_error > 1e-7, "{gather_error:e} {stated:e}");
    }
}
