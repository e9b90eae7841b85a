//! The Cornell box: solutions of different effort and degree agree within their estimates, point by point, shadows included.

use radgrad_scene::{Degenerate, Scene};
use radgrad_solver::{Options, solve};

#[test]
fn a_rough_and_a_finer_solution_of_the_cornell_box_agree_within_their_estimates() {
    let file = concat!(env!("CARGO_MANIFEST_DIR"), "/../../data/scenes/cornell.obj");
    let scene = Scene::read(file, Degenerate::Refuse).unwrap();
    let solved = |degree, first_elements| {
        let options = Options { error: 0.5, degree: Some(degree), first_elements, most_elements: 1, ..Options::default() };
        solve(&scene, &options, |_| true).unwrap()
    };
    let (rough, finer) = (solved(0, 1), solved(1, 32));
    assert!(finer.progress().estimate < rough.progress().estimate);
    let (mut points, mut seen) = (0, 0);
    for face in scene.faces() {
        let vertices = face.polygon().vertices();
        let [a, b, c] = [vertices[0], vertices[1], vertices[2]];
        for (u, v) in [(0.2, 0.3), (0.6, 0.1), (0.05, 0.9)] {
            let point = a + (b - a) * u + (c - a) * v;
            let normal = face.polygon().normal();
            let (p, q) = (rough.gather(point, normal).unwrap(), finer.gather(point, normal).unwrap());
            for channel in 0..3 {
                let error = (p.radiosity[channel] - q.radiosity[channel]).abs();
                let estimates = p.estimate[channel].total() + q.estimate[channel].total();
                assert!(error <= 2.0 * estimates, "face {} channel {channel}: {error} above twice {estimates}", p.face);
                seen += usize::from(error > 0.01 * estimates);
            }
            points += 1;
        }
    }
    // An estimate that nothing comes near would say little.
    assert!(points == 3 * scene.faces().len() && seen > points, "{seen} of {points}");
}

#[test]
fn a_point_on_no_face_is_refused_with_its_place() {
    let file = concat!(env!("CARGO_MANIFEST_DIR"), "/../../data/scenes/cornell.obj");
    let scene = Scene::read(file, Degenerate::Refuse).unwrap();
    let options = Options { error: 1.0, degree: Some(0), first_elements: 1, most_elements: 1, ..Options::default() };
    let solution = solve(&scene, &options, |_| true).unwrap();
    let error = solution.gather([278.0, 5.0, 100.0].into(), [0.0, 1.0, 0.0].into()).unwrap_err().to_string();
    assert!(error.starts_with("no face at [278, 5, 100]"), "{error}");
}
