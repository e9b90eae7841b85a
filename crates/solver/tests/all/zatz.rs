//! One transfer between two unit squares, projected on bases of each degree (H. Zatz 1993): parallel at gaps 1, 0.3 and 0.1, and
//! perpendicular with a common edge.
//!
//! Errors are the mean magnitude over the mean radiosity. His figures at gap 1 are about 10 % for orders 0 and 1, 0.75 % for 2 and
//! 3, 0.04 % for 4. At the other gaps he plots a Galerkin solution in the same bases; no such solution can be nearer in the root
//! mean square than the projection of the exact transfer, so that ours is held against that one.

use std::f64::consts::FRAC_1_PI;

use radgrad_core::{DVec3, Polygon};
use radgrad_scene::{Scene, gauss_legendre, largest};
use radgrad_solver::{Basis, MAX_DEGREE, Options, Shape, Solution, solve};

type Quad = [[f64; 3]; 4];

const FLOOR: Quad = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
const WALL: Quad = [[0.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 1.0, 1.0], [0.0, 0.0, 1.0]];

const fn ceiling(gap: f64) -> Quad {
    [[0.0, 0.0, gap], [0.0, 1.0, gap], [1.0, 1.0, gap], [1.0, 0.0, gap]]
}

/// The floor reflects half, the other square radiates 1: relative errors do not depend on how much is reflected.
fn transfer(other: Quad, degree: usize) -> Solution {
    let mut scene = Scene::new(["grey"]).unwrap();
    let surface = scene.add_surface("squares");
    for (name, quad, reflectance, radiance) in [("floor", FLOOR, 0.5, 0.0), ("lamp", other, 0.0, FRAC_1_PI)] {
        let material = scene.add_material(name, [reflectance], [radiance]).unwrap();
        let polygon = Polygon::new(quad.map(DVec3::from).to_vec()).unwrap();
        scene.add_face(surface, material, polygon, None).unwrap();
    }
    let options = Options { degree: Some(degree), first_elements: 1, most_elements: 1, ..Options::default() };
    solve(&scene, &options, |_| true).unwrap()
}

/// Mean and root mean square of the error over the mean radiosity, and the latter of the best function of the basis: by a Gauss
/// rule that sees the basis to the last digit.
fn errors(solution: &Solution) -> [f64; 3] {
    let line: Vec<(f64, f64)> = gauss_legendre(24).iter().map(|&(x, w)| (0.5 + 0.5 * x, 0.5 * w)).collect();
    let basis = Basis::new(Shape::Parallelogram, solution.mesh().basis(0).degree());
    let (mut mean, mut first, mut second, mut square) = (0.0, 0.0, 0.0, 0.0);
    let mut best = vec![0.0; basis.len()];
    for (s, v) in &line {
        for (t, w) in &line {
            let exact = solution.gather_on(0, DVec3::new(*s, *t, 0.0)).unwrap().radiosity[0];
            let error = (solution.value_on(0, 0, [*s, *t]) - exact).abs();
            (mean, square) = (mean + v * w * exact, square + v * w * exact * exact);
            (first, second) = (first + v * w * error, second + v * w * error * error);
            best.iter_mut().zip(basis.values([*s, *t])).for_each(|(c, b)| *c += v * w * b * exact);
        }
    }
    let residual = largest(square - best.iter().map(|c| c * c).sum::<f64>(), 0.0);
    [first / mean, second.sqrt() / mean, residual.sqrt() / mean]
}

#[test]
fn errors_at_gap_1_are_below_those_that_zatz_has() {
    let published = [0.1, 0.1, 0.0075, 0.0075, 0.0004];
    for (degree, published) in published.into_iter().enumerate() {
        let solution = transfer(ceiling(1.0), degree);
        let [mean, ..] = errors(&solution);
        println!("degree {degree}: {mean:.2e}");
        assert!(mean <= published, "degree {degree}: {mean:e}");
        for at in [[0.1, 0.2], [0.5, 0.5], [0.97, 0.4]] {
            let exact = solution.gather_on(0, DVec3::new(at[0], at[1], 0.0)).unwrap().radiosity[0];
            let error = (solution.value_on(0, 0, at) - exact).abs();
            assert!(error <= solution.estimate_on(0)[0].total(), "degree {degree} at {at:?}: {error:e}");
        }
    }
}

#[test]
fn at_every_gap_and_order_the_error_is_near_the_least_that_the_basis_can_have() {
    for (name, other) in [("gap 1", ceiling(1.0)), ("gap 0.3", ceiling(0.3)), ("gap 0.1", ceiling(0.1)), ("edge", WALL)] {
        let mut previous = f64::INFINITY;
        for degree in 0..=MAX_DEGREE {
            let [mean, rms, best] = errors(&transfer(other, degree));
            println!("{name}, degree {degree}: mean {mean:.2e}, root mean square {rms:.2e}, least {best:.2e}");
            // Few nodes for a steep transfer: at gap 0.1 degree 0 is 15 % above the least.
            assert!(rms <= 1.2 * best, "{name}, degree {degree}: {rms:e} against {best:e}");
            assert!(rms <= previous * (1.0 + 1e-9), "{name}, degree {degree}: {rms:e} after {previous:e}");
            previous = rms;
        }
    }
}
