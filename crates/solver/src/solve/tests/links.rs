//! Bounds on the light that links neglect exceed that light.

use radgrad_core::{DVec3, Polygon};
use radgrad_scene::{Degenerate, Scene, largest};

use crate::links::station::Station;
use crate::links::transfer::Row;
use crate::solve::options::{Marking, Options};
use crate::solve::solution::Solution;
use crate::solve::solve;

/// The leaves below an element, or itself.
pub(super) fn leaves(solution: &Solution, element: usize) -> Vec<usize> {
    match solution.system.mesh.elements()[element].children() {
        Some(first) => (first..first + 4).flat_map(|child| leaves(solution, child)).collect(),
        None => vec![element],
    }
}

#[test]
fn what_a_link_neglects_is_within_its_bound() {
    let file = concat!(env!("CARGO_MANIFEST_DIR"), "/../../data/scenes/cornell.obj");
    let scene = Scene::read(file, Degenerate::Refuse).unwrap();
    let options = Options { error: 0.05, first_elements: 1, most_elements: 80, marking: Marking::Gradient, ..Options::default() };
    let solution = solve(&scene, &options, |_| true).unwrap();
    let (mesh, field, optics) = (&solution.system.mesh, &solution.radiosity.field, solution.optics());
    let (mut count, mut worst) = (0, 0.0_f64);
    for receiver in 0..mesh.elements().len() {
        let stations = Station::at_nodes(mesh, receiver);
        for link in
            solution.system.links[receiver].iter().filter(|link| field.neglected(mesh, link.source, 0, &link.rows[0]) > 0.0)
        {
            let len = mesh.basis(link.source).len();
            for (station, row) in stations.iter().zip(&link.rows) {
                for channel in 0..solution.system.channels.len() {
                    let sum = |row: &Row, element: usize| -> f64 {
                        row.values.iter().zip(field.coefficients(element, channel)).map(|(v, c)| v * c).sum()
                    };
                    let mut exact = 0.0;
                    let mut errors = row.error_of(field.coefficients(link.source, channel));
                    for leaf in leaves(&solution, link.source) {
                        let fine = optics.receive(station, leaf, &link.sight, len).unwrap();
                        exact += sum(&fine, leaf);
                        errors += fine.error_of(field.coefficients(leaf, channel));
                    }
                    let error = (exact - sum(row, link.source)).abs();
                    let bound = field.neglected(mesh, link.source, channel, row);
                    count += 1;
                    // A link that neglects nothing has no error.
                    if bound > 0.0 {
                        worst = largest(worst, (error - errors) / bound);
                    }
                    assert!(error <= bound + errors, "{receiver} from {}: {error:e}, {bound:e} and {errors:e}", link.source);
                }
            }
        }
    }
    println!("{count} rows, the worst {worst:.2} of its bound");
    assert!(count > 1000 && worst > 0.1, "{count} {worst}");
}

#[test]
fn a_scene_without_light_is_dark_and_nothing_is_linked_in_it() {
    let scene = without_lamps();
    let solution = solve(&scene, &Options::default(), |_| true).unwrap();
    assert_eq!((solution.mean(), solution.mean_estimate()[0].total()), (&[0.0][..], 0.0));
    assert!(
        solution.system.links.iter().all(Vec::is_empty)
            && solution.gather(DVec3::new(0.5, 0.5, 0.0), DVec3::Z).unwrap().radiosity[0] == 0.0
    );
}

/// Two squares that see each other.
fn without_lamps() -> Scene {
    let mut scene = Scene::new(["grey"]).unwrap();
    let (grey, surface) = (scene.add_material("grey", [0.5], [0.0]).unwrap(), scene.add_surface("all"));
    let low = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
    let high = [[0.0, 0.0, 1.0], [0.0, 1.0, 1.0], [1.0, 1.0, 1.0], [1.0, 0.0, 1.0]];
    for corners in [low, high] {
        scene.add_face(surface, grey, Polygon::new(corners.map(DVec3::from).to_vec()).unwrap(), None).unwrap();
    }
    scene
}
