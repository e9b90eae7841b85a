//! Two unit squares face each other at distance 1, reflect half and radiate 1: error, estimate and their ratio for each degree.
//!
//! `cargo run --release -p radgrad-solver --example two_squares`

use std::error::Error;
use std::f64::consts::FRAC_1_PI;

use radgrad_core::{DVec3, Polygon};
use radgrad_scene::Scene;
use radgrad_solver::{Options, solve};

/// Radiosity at the centre of either.
const EXACT: f64 = 1.133_303_564_992_420_8;

fn main() -> Result<(), Box<dyn Error>> {
    let mut scene = Scene::new(["grey"])?;
    let white = scene.add_material("white", [0.5], [FRAC_1_PI])?;
    let surface = scene.add_surface("squares");
    let square = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)];
    let floor = square.map(|(x, y)| DVec3::new(x, y, 0.0));
    let ceiling = square.map(|(x, y)| DVec3::new(y, x, 1.0));
    for corners in [floor, ceiling] {
        scene.add_face(surface, white, Polygon::new(corners.to_vec())?, None)?;
    }
    println!("{:>6} {:>5} {:>8} {:>9} {:>9} {:>14}", "degree", "asked", "elements", "error", "estimate", "estimate/error");
    for degree in 0..=3 {
        for error in [1e-2, 1e-3, 1e-4] {
            let options = Options { error, degree: Some(degree), first_elements: 1, most_elements: 400, ..Options::default() };
            let solution = solve(&scene, &options, |_| true)?;
            let centre = solution.gather(DVec3::new(0.5, 0.5, 0.0), DVec3::Z)?;
            let (actual, estimate) = ((centre.radiosity[0] - EXACT).abs(), centre.estimate[0].total());
            let elements = solution.progress().elements;
            println!("{degree:>6} {error:>5.0e} {elements:>8} {actual:>9.1e} {estimate:>9.1e} {:>14.1}", estimate / actual);
        }
    }
    Ok(())
}
