//! The Cornell box with its shadows: leaves divided where the gradient says so against all leaves divided alike, with quadratic
//! elements, as by default.

use radgrad_scene::{Degenerate, Scene, largest};
use radgrad_solver::{Marking, Mesh, Options, Shape, Solution, solve};
use rayon::prelude::*;

/// Places that cover all faces evenly: face, root and reference coordinates, and their shares of the area, by the first points of
/// the additive recurrence of the plastic number.
fn places(mesh: &Mesh) -> Vec<(usize, [f64; 2], f64)> {
    let total: f64 = mesh.roots().iter().map(|&root| mesh.elements()[root].area()).sum();
    let mut places = Vec::new();
    for &root in mesh.roots() {
        let element = &mesh.elements()[root];
        let count = (3000.0 * element.area() / total).ceil();
        let mut k = 0.5;
        while k < count {
            let [a, b] = [0.754_877_666_246_692_7 * k, 0.569_840_290_998_053_2 * k].map(f64::fract);
            let at = if element.shape() == Shape::Triangle && a + b > 1.0 { [1.0 - a, 1.0 - b] } else { [a, b] };
            places.push((root, at, element.area() / count / total));
            k += 1.0;
        }
    }
    places
}

/// Root mean square over the area of the polynomials' error, relative to the mean radiosity, in each channel.
fn true_error(solution: &Solution, places: &[(usize, [f64; 2], f64)], exact: &[Vec<f64>]) -> Vec<f64> {
    let mesh = solution.mesh();
    let leaf_at = |root: usize, at: [f64; 2]| {
        let point = mesh.elements()[root].point(at);
        let outside = |leaf: usize| {
            let [s, t] = mesh.elements()[leaf].reference(point);
            let beyond = if mesh.elements()[leaf].shape() == Shape::Triangle { s + t - 1.0 } else { largest(s - 1.0, t - 1.0) };
            largest(largest(-s, -t), beyond)
        };
        let mut leaf = root;
        while let Some(first) = mesh.elements()[leaf].children() {
            leaf = (first..first + 4).min_by(|&a, &b| outside(a).total_cmp(&outside(b))).unwrap();
        }
        (leaf, mesh.elements()[leaf].reference(point))
    };
    let of_channel = |channel: usize| {
        let of_place = |(&(root, at, share), exact): (&(usize, [f64; 2], f64), &Vec<f64>)| {
            let (leaf, at) = leaf_at(root, at);
            share * (solution.value_on(leaf, channel, at) - exact[channel]).powi(2)
        };
        places.iter().zip(exact).map(of_place).sum::<f64>().sqrt() / solution.mean()[channel]
    };
    (0..solution.channels().len()).map(of_channel).collect()
}

#[test]
fn the_gradient_needs_less_than_a_third_of_the_elements_in_the_cornell_box() {
    let file = concat!(env!("CARGO_MANIFEST_DIR"), "/../../data/scenes/cornell.obj");
    let scene = Scene::read(file, Degenerate::Refuse).unwrap();
    let options = Options { error: 0.05, degree: Some(2), most_elements: 1, uniform: true, ..Options::default() };
    let [coarse, fine] =
        [640, 2560].map(|first_elements| solve(&scene, &Options { first_elements, ..options }, |_| true).unwrap());
    let places = places(fine.mesh());
    let gather = |&(root, at, _): &(usize, [f64; 2], f64)| {
        let element = &fine.mesh().elements()[root];
        fine.gather(element.point(at), element.polygon().normal()).unwrap().radiosity
    };
    let exact: Vec<Vec<f64>> = places.par_iter().map(gather).collect();
    let options = Options { error: 0.006, first_elements: 1, most_elements: 600, uniform: false, ..options };
    let divided = solve(&scene, &Options { marking: Marking::Gradient, ..options }, |solution| {
        println!("{} elements: {:.4?}", solution.progress().elements, true_error(solution, &places, &exact));
        true
    });
    let divided = divided.unwrap();
    let [elements, fewer, more] = [&divided, &coarse, &fine].map(|solution| solution.progress().elements as f64);
    let [errors, larger, smaller] = [&divided, &coarse, &fine].map(|solution| true_error(solution, &places, &exact));
    println!("uniform: {fewer} elements {larger:.4?}, {more} elements {smaller:.4?}");
    for (channel, error) in errors.into_iter().enumerate() {
        let (larger, smaller) = (larger[channel], smaller[channel]);
        assert!(error < larger, "{error} with {elements} elements, uniform {larger} with {fewer}");
        // Uniform errors fall like a power of the number of elements.
        let power = (larger / smaller).ln() / (more / fewer).ln();
        let uniform = more * (smaller / error).powf(1.0 / power);
        println!("channel {channel}: {elements} elements against {uniform:.0}, {:.1} times", uniform / elements);
        assert!(uniform >= 3.0 * elements, "{elements} elements against {uniform} uniform ones for an error of {error}");
    }
}
