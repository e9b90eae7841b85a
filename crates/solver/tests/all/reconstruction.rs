//! Hermite reconstruction of solutions: continuous over each face, and of fourth order where the light is smooth.

use std::f64::consts::FRAC_1_PI;

use radgrad_core::{DVec3, Polygon};
use radgrad_scene::{Degenerate, Scene, largest, smallest};
use radgrad_solver::{Element, Options, Shape, Solution, solve};

/// Two faces of one shape at distance 1, both of which reflect half and radiate 1: squares, or each cut into triangles.
fn opposed(triangles: bool) -> Scene {
    let mut scene = Scene::new(["grey"]).unwrap();
    let (white, surface) = (scene.add_material("white", [0.5], [FRAC_1_PI]).unwrap(), scene.add_surface("all"));
    let square = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)];
    let (low, high) = (square.map(|(x, y)| DVec3::new(x, y, 0.0)), square.map(|(x, y)| DVec3::new(y, x, 1.0)));
    for corners in [low, high] {
        let parts: &[&[usize]] = if triangles { &[&[0, 1, 2], &[0, 2, 3]] } else { &[&[0, 1, 2, 3]] };
        for part in parts {
            let polygon = Polygon::new(part.iter().map(|&i| corners[i]).collect()).unwrap();
            scene.add_face(surface, white, polygon, None).unwrap();
        }
    }
    scene
}

/// The largest difference between the patches and exact gathers at some points of each leaf.
fn off(solution: &Solution) -> f64 {
    let smooth = solution.reconstruct().unwrap();
    let mut off = 0.0_f64;
    for leaf in solution.mesh().leaves() {
        let element = &solution.mesh().elements()[leaf];
        for at in [[0.31, 0.27], [0.5, 0.45], [0.12, 0.6], [0.03, 0.5]] {
            let exact = solution.radiosity_on(leaf, element.point(at)).unwrap();
            off = (0..exact.len()).fold(off, |off, c| largest(off, (smooth.value_on(leaf, c, at) - exact[c]).abs()));
        }
    }
    off
}

#[test]
fn halving_the_elements_takes_the_error_down_by_the_fourth_power() {
    for (triangles, firsts) in [(false, [32, 128, 512]), (true, [16, 64, 256])] {
        let errors = firsts.map(|first_elements| {
            // Links that neglect nothing, so that neighbours gather the same.
            let options = Options { error: 1e-9, degree: Some(0), first_elements, most_elements: 1, ..Options::default() };
            let solution = solve(&opposed(triangles), &options, |_| true).unwrap();
            off(&solution)
        });
        println!("triangles: {triangles}, off {errors:?}");
        for pair in errors.windows(2) {
            let order = (pair[0] / pair[1]).log2();
            assert!(order > 3.5, "order {order:.2} from {errors:?}");
        }
    }
}

#[test]
fn patches_of_neighbours_meet_along_their_edges_past_hanging_vertices_too() {
    let file = concat!(env!("CARGO_MANIFEST_DIR"), "/../../data/scenes/cornell.obj");
    let scene = Scene::read(file, Degenerate::Refuse).unwrap();
    let options = Options { error: 0.2, degree: Some(0), first_elements: 1, most_elements: 90, ..Options::default() };
    let solution = solve(&scene, &options, |_| true).unwrap();
    let smooth = solution.reconstruct().unwrap();
    let mesh = solution.mesh();
    let corners = |element: &Element| -> &[[f64; 2]] {
        match element.shape() {
            Shape::Parallelogram => &[[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]],
            Shape::Triangle => &[[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]],
        }
    };
    // Faces are cut where others stand on them; there the light jumps, and nothing is joined.
    let root = |leaf: usize| std::iter::successors(Some(leaf), |&e| mesh.elements()[e].parent()).last();
    let (mut compared, mut hanging) = (0, 0);
    for leaf in mesh.leaves() {
        let element = &mesh.elements()[leaf];
        let own = corners(element);
        for k in 0..own.len() {
            let (a, b) = (own[k], own[(k + 1) % own.len()]);
            for t in [0.2, 0.5, 0.77] {
                let at = [a[0] + (b[0] - a[0]) * t, a[1] + (b[1] - a[1]) * t];
                let point = element.point(at);
                for other in mesh.leaves().filter(|&o| o != leaf && root(o) == root(leaf)) {
                    let neighbour = &mesh.elements()[other];
                    let [s, t] = neighbour.reference(point);
                    let inside = match neighbour.shape() {
                        Shape::Parallelogram => largest(s, t) < 1.0 + 1e-9,
                        Shape::Triangle => s + t < 1.0 + 1e-9,
                    };
                    if smallest(s, t) > -1e-9 && inside {
                        // Where a patch would leave the known bounds the polynomial stays, and nothing is joined.
                        let is_joined = |channel: &usize| [leaf, other].iter().all(|&of| smooth.patch(of, *channel).is_some());
                        for channel in (0..3).filter(is_joined) {
                            compared += 1;
                            hanging += usize::from(element.level() != neighbour.level());
                            let (here, there) = (smooth.value_on(leaf, channel, at), smooth.value_on(other, channel, [s, t]));
                            let gap = (here - there).abs();
                            assert!(gap <= 1e-7 * solution.mean()[channel], "{leaf} and {other} at {point}: {here} and {there}");
                        }
                    }
                }
            }
        }
    }
    assert!(compared > 100 && hanging > 30, "{compared} {hanging}");
}

#[test]
fn what_is_drawn_of_polynomials_is_nowhere_negative_and_keeps_their_means() {
    let file = concat!(env!("CARGO_MANIFEST_DIR"), "/../../data/scenes/cornell.obj");
    let scene = Scene::read(file, Degenerate::Refuse).unwrap();
    let solution = solve(&scene, &Options { error: 0.5, ..Options::default() }, |_| true).unwrap();
    let drawn = solution.not_negative();
    let grid = (0..12).flat_map(|i| (0..12).map(move |j| [i, j].map(|k| (f64::from(k) + 0.5) / 12.0)));
    let (mut negative, mut same) = (0, 0);
    for leaf in solution.mesh().leaves() {
        let is_triangle = solution.mesh().elements()[leaf].shape() == Shape::Triangle;
        let within: Vec<[f64; 2]> = grid.clone().filter(|[s, t]| !is_triangle || s + t < 1.0).collect();
        for channel in 0..3 {
            let before: Vec<f64> = within.iter().map(|&at| solution.value_on(leaf, channel, at)).collect();
            let after: Vec<f64> = within.iter().map(|&at| drawn.value_on(leaf, channel, at)).collect();
            assert!(after.iter().all(|value| *value >= -1e-12), "{leaf} {channel}: {after:?}");
            // There the polynomial is below 0, and 0 stands for it.
            if before.contains(&0.0) {
                negative += 1;
                continue;
            } else if before == after {
                same += 1;
            }
            // Both are polynomials of degree 2, and the mean of one is that of the other.
            let mean = |of: &[f64]| of.iter().sum::<f64>() / of.len() as f64;
            let off = (mean(&before) - mean(&after)).abs();
            assert!(
                is_triangle || off <= 0.02 * before.iter().fold(0.0, |most, value| largest(most, value.abs())),
                "{leaf}: {off}"
            );
        }
    }
    assert!(negative > 3 && same > 100, "{negative} {same}");
}

#[test]
fn the_gradient_of_a_gather_is_that_of_its_values() {
    let file = concat!(env!("CARGO_MANIFEST_DIR"), "/../../data/scenes/cornell.obj");
    let scene = Scene::read(file, Degenerate::Refuse).unwrap();
    let options = Options { error: 0.5, degree: Some(1), first_elements: 1, most_elements: 1, ..Options::default() };
    let solution = solve(&scene, &options, |_| true).unwrap();
    let mut seen = 0;
    for leaf in solution.mesh().leaves() {
        let element = &solution.mesh().elements()[leaf];
        let centre = element.point([0.29, 0.33]);
        let gradients = solution.gradient_at(leaf, centre).unwrap();
        let [u, _] = [element.point([1.0, 0.0]) - element.point([0.0, 0.0]), DVec3::ZERO];
        let step = 1e-4;
        let value = |s: f64| solution.radiosity_on(leaf, centre + u * s).unwrap();
        let (after, before) = (value(step), value(-step));
        for channel in 0..3 {
            let difference = (after[channel] - before[channel]) / (2.0 * step);
            let slope = gradients[channel].dot(u);
            let scale = solution.mean()[channel] + difference.abs();
            assert!((slope - difference).abs() <= 1e-3 * scale, "leaf {leaf} channel {channel}: {slope} and {difference}");
            seen += usize::from(difference.abs() > 1e-2 * scale);
        }
    }
    assert!(seen > 20, "{seen}");
}
