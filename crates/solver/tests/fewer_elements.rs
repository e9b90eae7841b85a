//! The Cornell box with its shadows: leaves divided where the gradient says so against all leaves divided alike.

use radgrad_scene::{Degenerate, Scene};
use radgrad_solver::{Marking, Mesh, Options, Shape, Solution, solve};

const CHANNEL: usize = 1;

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

/// Root mean square over the area of what the polynomials are off, relative to the mean radiosity.
fn true_error(solution: &Solution, places: &[(usize, [f64; 2], f64)], exact: &[f64]) -> f64 {
    let mesh = solution.mesh();
    let value = |root: usize, at: [f64; 2]| {
        let point = mesh.elements()[root].point(at);
        let outside = |leaf: usize| {
            let [s, t] = mesh.elements()[leaf].reference(point);
            let beyond = if mesh.elements()[leaf].shape() == Shape::Triangle { s + t - 1.0 } else { (s - 1.0).max(t - 1.0) };
            (-s).max(-t).max(beyond)
        };
        let mut leaf = root;
        while let Some(first) = mesh.elements()[leaf].children() {
            leaf = (first..first + 4).min_by(|&a, &b| outside(a).total_cmp(&outside(b))).unwrap();
        }
        solution.value_on(leaf, CHANNEL, mesh.elements()[leaf].reference(point))
    };
    let of_place = |(&(root, at, share), exact): (&(usize, [f64; 2], f64), &f64)| share * (value(root, at) - exact).powi(2);
    places.iter().zip(exact).map(of_place).sum::<f64>().sqrt() / solution.mean()[CHANNEL]
}

#[test]
fn the_gradient_needs_less_than_half_of_the_elements_in_the_cornell_box() {
    let file = concat!(env!("CARGO_MANIFEST_DIR"), "/../../data/scenes/cornell.obj");
    let scene = Scene::read(file, Degenerate::Refuse).unwrap();
    let rough = Options { degree: Some(1), first_elements: 1, most_elements: 1, ..Options::default() };
    let reference = solve(&scene, &Options { error: 0.05, first_elements: 300, ..rough }, |_| true).unwrap();
    let places = places(reference.mesh());
    let gather = |&(root, at, _): &(usize, [f64; 2], f64)| {
        let element = &reference.mesh().elements()[root];
        reference.gather(element.point(at), element.polygon().normal()).unwrap().radiosity[CHANNEL]
    };
    let exact: Vec<f64> = places.iter().map(gather).collect();
    let course = |uniform: bool| {
        let most_elements = if uniform { 300 } else { 200 };
        let options = Options { error: 0.01, most_elements, uniform, marking: Marking::Gradient, ..rough };
        let mut course = Vec::new();
        solve(&scene, &options, |solution| {
            course.push((solution.progress().elements as f64, true_error(solution, &places, &exact)));
            true
        })
        .unwrap();
        course
    };
    let (divided, uniform) = (course(false), course(true));
    println!("by the gradient {divided:.4?}\nuniform {uniform:.4?}");
    let (elements, error) = *divided.last().unwrap();
    let [(fewer, larger), (more, smaller)] = uniform[uniform.len() - 2..] else { panic!("uniform division has two rounds") };
    assert!(smaller < error && error < larger, "{error} with {elements} elements, uniform {smaller} with {more}");
    // Uniform errors fall like a power of the number of elements.
    let power = (larger / smaller).ln() / (more / fewer).ln();
    let uniform = more * (smaller / error).powf(1.0 / power);
    assert!(uniform >= 2.0 * elements, "{elements} elements against {uniform} uniform ones for an error of {error}");
    println!("{elements} elements against {uniform:.0}: {:.1} times", uniform / elements);
}
