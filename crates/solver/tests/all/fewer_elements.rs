//! The Cornell box with its shadows: leaves divided where the gradient says so against all leaves divided alike, and faces cut along shadow
//! lines against these, with quadratic elements.

use radgrad_core::DVec3;
use radgrad_scene::{Degenerate, Scene};
use radgrad_solver::{Marking, Mesh, Options, Shape, Solution, solve};
use rayon::prelude::*;

/// A place and its share of the area.
struct Place {
    face: usize,
    point: DVec3,
    share: f64,
}

/// Places that cover all faces evenly, by the first points of the additive recurrence of the plastic number.
fn places(mesh: &Mesh) -> Vec<Place> {
    let total: f64 = mesh.roots().iter().map(|&root| mesh.elements()[root].area()).sum();
    let mut places = Vec::new();
    for element in mesh.roots().iter().map(|&root| &mesh.elements()[root]) {
        let count = (500.0 * element.area() / total).ceil();
        let mut k = 0.5;
        while k < count {
            let [a, b] = [0.754_877_666_246_692_7 * k, 0.569_840_290_998_053_2 * k].map(f64::fract);
            let place = if element.shape() == Shape::Triangle && a + b > 1.0 { [1.0 - a, 1.0 - b] } else { [a, b] };
            places.push(Place { face: element.face(), point: element.point(place), share: element.area() / count / total });
            k += 1.0;
        }
    }
    places
}

/// Root mean square over the area of the polynomials' error, relative to the mean radiosity, in each channel.
fn true_error(solution: &Solution, places: &[Place], exact: &[Vec<f64>]) -> Vec<f64> {
    let mesh = solution.mesh();
    let of_channel = |channel: usize| {
        let of_place = |(place, exact): (&Place, &Vec<f64>)| {
            let leaf = mesh.leaf_at(place.face, place.point).unwrap();
            let value = solution.value_on(leaf, channel, mesh.elements()[leaf].reference(place.point));
            place.share * (value - exact[channel]).powi(2)
        };
        places.iter().zip(exact).map(of_place).sum::<f64>().sqrt() / solution.mean()[channel]
    };
    (0..solution.channels().len()).map(of_channel).collect()
}

/// The root mean square over channels.
fn over_channels(errors: &[f64]) -> f64 {
    (errors.iter().map(|error| error * error).sum::<f64>() / errors.len() as f64).sqrt()
}

/// The number of elements with an error, on the line between two meshes of which one has more, in logarithms.
fn elements_for(error: f64, meshes: &[(f64, f64)]) -> Option<f64> {
    let pair = meshes.windows(2).find(|pair| pair[0].1 >= error && pair[1].1 <= error)?;
    let share = (pair[0].1 / error).ln() / (pair[0].1 / pair[1].1).ln();
    Some(pair[0].0 * (pair[1].0 / pair[0].0).powf(share))
}

#[test]
fn uniform_division_needs_three_times_the_elements_of_the_gradient_and_that_twice_those_of_shadow_lines() {
    let file = concat!(env!("CARGO_MANIFEST_DIR"), "/../../data/scenes/cornell.obj");
    let scene = Scene::read(file, Degenerate::Refuse).unwrap();
    let rough = Options { error: 0.05, degree: Some(2), most_elements: 1, ..Options::default() };
    let uniform = solve(&scene, &Options { first_elements: 2560, ..rough }, |_| true).unwrap();
    let places = places(uniform.mesh());
    let gather = |place: &Place| uniform.gather(place.point, uniform.mesh().polygons()[place.face].normal()).unwrap().radiosity;
    let exact: Vec<Vec<f64>> = places.par_iter().map(gather).collect();
    let mesh = |solution: &Solution| (solution.progress().elements as f64, over_channels(&true_error(solution, &places, &exact)));
    let (even, uniform_error) = mesh(&uniform);
    let mut by_gradient = Vec::new();
    let options = Options { error: 0.006, first_elements: 1, most_elements: 2000, marking: Marking::Gradient, ..rough };
    solve(&scene, &options, |solution| {
        by_gradient.push(mesh(solution));
        by_gradient.last().is_some_and(|last| last.1 > uniform_error)
    })
    .unwrap();
    let gradient = elements_for(uniform_error, &by_gradient).unwrap();
    let most_elements = (1..2000_usize).take_while(|&count| 2.0 * count as f64 <= gradient).count();
    let options = Options { error: 0.002, most_elements, marking: Marking::Shadows, ..options };
    let (shadows, of_shadows) = mesh(&solve(&scene, &options, |_| false).unwrap());
    println!("{uniform_error:.3e} with {even} alike, {gradient:.0} by the gradient; {of_shadows:.3e} with {shadows} along lines");
    assert!(even >= 3.0 * gradient, "{by_gradient:?} against {even} with {uniform_error}");
    assert!(of_shadows <= uniform_error, "{of_shadows} with {shadows}, {uniform_error} with {gradient}");
}
