//! Pictures of solutions, and the gradients of their gathers.

use radgrad_scene::{Degenerate, Scene, largest};
use radgrad_solver::{Options, Shape, solve};

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
            let error = (mean(&before) - mean(&after)).abs();
            assert!(
                is_triangle || error <= 0.02 * before.iter().fold(0.0, |most, value| largest(most, value.abs())),
                "{leaf}: {error}"
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
    let mut checked = 0;
    for leaf in solution.mesh().leaves() {
        let element = &solution.mesh().elements()[leaf];
        let centre = element.point([0.29, 0.33]);
        let gradients = solution.gradient_at(leaf, centre).unwrap();
        let u = element.point([1.0, 0.0]) - element.point([0.0, 0.0]);
        let step = 1e-4;
        let value = |s: f64| solution.radiosity_on(leaf, centre + u * s).unwrap();
        let (after, before) = (value(step), value(-step));
        for channel in 0..3 {
            let difference = (after[channel] - before[channel]) / (2.0 * step);
            let slope = gradients[channel].dot(u);
            let scale = solution.mean()[channel] + difference.abs();
            assert!((slope - difference).abs() <= 1e-3 * scale, "leaf {leaf} channel {channel}: {slope} and {difference}");
            checked += usize::from(difference.abs() > 1e-2 * scale);
        }
    }
    assert!(checked > 20, "{checked}");
}
