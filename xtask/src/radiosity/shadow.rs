//! Error past the shadow of a screen by the number of elements: a square lamp over a floor that reflects half, and a black screen with one
//! edge over it. The penumbra ends in two lines, where the radiosity has no derivative.
//!
//! All elements are divided alike: those of the whole floor, and those of the floor cut along shadow lines. The error is the root mean
//! square of the polynomials over places of the floor, relative to the largest radiosity; exact is core's closed form.

use std::error::Error;

use radgrad_core::{DVec3, Emission, Emitter, Polygon, Receiver, evaluate};
use radgrad_solver::{Marking, Options, Solution, solve};

use super::graph::{Graph, Series};
use super::squares::{Quad, scene};

/// A solution.
pub(super) struct Point {
    degree: usize,
    cut: bool,
    elements: usize,
    error: f64,
}

impl Point {
    pub(super) fn record(&self) -> Vec<String> {
        let division = if self.cut { "along shadow lines" } else { "uniform" };
        vec![self.degree.to_string(), division.to_owned(), self.elements.to_string(), format!("{:.3e}", self.error)]
    }
}

const DEGREES: usize = 3;

/// Elements at least.
const FEWEST: [usize; 4] = [12, 48, 192, 768];

/// Places.
const PLACES: u32 = 4000;

/// A rectangle at a height that faces up.
const fn rectangle([low, high]: [[f64; 2]; 2], z: f64) -> Quad {
    [[low[0], low[1], z], [high[0], low[1], z], [high[0], high[1], z], [low[0], high[1], z]]
}

fn polygon(corners: Quad) -> Result<Polygon, radgrad_core::Error> {
    Polygon::new(corners.map(DVec3::from).to_vec())
}

/// Places of the floor and the radiosity there.
fn exact(lamp: Polygon, screen: &Polygon) -> Result<Vec<(DVec3, f64)>, radgrad_core::Error> {
    let lamp = Emitter::new(lamp, Emission::Constant(1.0))?;
    let exact_at = |k: u32| {
        let [a, b] = [0.754_877_666_246_692_7, 0.569_840_290_998_053_2].map(|step: f64| (step * (f64::from(k) + 0.5)).fract());
        let place = DVec3::new(8.0 * a - 4.0, 8.0 * b - 4.0, 0.0);
        Ok((place, evaluate(&Receiver::new(place, DVec3::Z, 0.5)?, &lamp, [screen])?.radiosity))
    };
    (0..PLACES).map(exact_at).collect()
}

pub(super) fn measure() -> Result<Vec<Point>, Box<dyn Error>> {
    let floor = rectangle([[-4.0, -4.0], [4.0, 4.0]], 0.0);
    let mut lamp = rectangle([[-0.5, -0.5], [0.5, 0.5]], 2.0);
    lamp.reverse();
    let screen = rectangle([[0.3, -4.0], [4.0, 4.0]], 1.0);
    let exact = exact(polygon(lamp)?, &polygon(screen)?)?;
    let scene = scene(&[(floor, 0.5, 0.0), (lamp, 0.0, 1.0), (screen, 0.0, 0.0)])?;
    let mut points = Vec::new();
    for degree in 0..DEGREES {
        for cut in [false, true] {
            for first_elements in FEWEST {
                let options = Options {
                    // That of the cuts: constants have few of them, so that there is something to divide.
                    error: if degree == 0 { 0.3 } else { 0.05 },
                    degree: Some(degree),
                    first_elements,
                    marking: if cut { Marking::Shadows } else { Marking::Gradient },
                    ..Options::default()
                };
                let solution = solve(&scene, &options, |_| false)?;
                points.push(Point { degree, cut, elements: solution.progress().elements, error: rms_error(&solution, &exact) });
            }
        }
    }
    Ok(points)
}

fn rms_error(solution: &Solution, exact: &[(DVec3, f64)]) -> f64 {
    let mesh = solution.mesh();
    let square = |&(place, value): &(DVec3, f64)| {
        let leaf = mesh.leaf_at(0, place)?;
        Some((solution.value_on(leaf, 0, mesh.elements()[leaf].reference(place)) - value).powi(2))
    };
    let largest = exact.iter().map(|of| of.1).fold(0.0, radgrad_scene::largest);
    (exact.iter().filter_map(square).sum::<f64>() / exact.len() as f64).sqrt() / largest
}

/// For each degree the orders of convergence in the size of elements, of the whole floor and of the floor cut along shadow lines, over
/// the last division.
pub(super) fn orders(points: &[Point]) -> Vec<(usize, [f64; 2])> {
    let order = |degree: usize, cut: bool| {
        let chosen: Vec<&Point> = points.iter().filter(|p| p.cut == cut && p.degree == degree).collect();
        let [.., a, b] = chosen[..] else { return None };
        Some((a.error / b.error).ln() / (0.5 * (b.elements as f64 / a.elements as f64).ln()))
    };
    (0..DEGREES).filter_map(|degree| Some((degree, [order(degree, false)?, order(degree, true)?]))).collect()
}

pub(super) fn graph(points: &[Point]) -> Graph {
    let line = |degree: usize, cut: bool| Series {
        name: format!("degree {degree}, {}", if cut { "along shadow lines" } else { "uniform" }),
        points: points.iter().filter(|p| p.degree == degree && p.cut == cut).map(|p| (p.elements as f64, p.error)).collect(),
        colour: degree,
        dashed: !cut,
    };
    Graph {
        title: "Past the shadow of a screen".to_owned(),
        under: "Root mean square error of the polynomials, relative to the largest radiosity of the floor.".to_owned(),
        across: "elements",
        upward: "relative error",
        counts: false,
        series: (0..DEGREES).flat_map(|degree| [line(degree, false), line(degree, true)]).collect(),
    }
}
