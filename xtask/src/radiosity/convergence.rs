//! Error of a solution by its number of elements: two unit squares that reflect half and radiate 1, face to face or meeting in an
//! edge. The first is smooth; at the edge of the second, radiosity has no derivative.
//!
//! The error is that of the polynomials, the root mean square over places of the floor, relative. Exact is the gather of a finer
//! solution, of degree 4 where the light is smooth.

use std::error::Error;

use radgrad_core::DVec3;
use radgrad_solver::{MAX_DEGREE, Options, Shape, Solution, solve};

use super::graph::{Graph, Series};
use super::squares::{FLOOR, WALL, ceiling, scene};

/// Which two squares.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Pair {
    Opposed,
    Edge,
}

impl Pair {
    pub(super) const fn name(self) -> &'static str {
        match self {
            Self::Opposed => "opposed",
            Self::Edge => "edge",
        }
    }
}

/// A solution.
pub(super) struct Point {
    degree: usize,
    uniform: bool,
    elements: usize,
    error: f64,
    estimate: f64,
}

impl Point {
    pub(super) fn record(&self) -> Vec<String> {
        let division = if self.uniform { "uniform" } else { "where it pays" };
        let numbers = [self.error, self.estimate].map(|v| format!("{v:.3e}"));
        [self.degree.to_string(), division.to_owned(), self.elements.to_string()].into_iter().chain(numbers).collect()
    }
}

/// Places a side, not in step with any division.
const SIDE: u32 = 37;

/// Elements, divided ones too, at most: fewer where many are near each other, and need closed forms.
const MOST: [usize; 2] = [200, 100];

pub(super) fn measure(pair: Pair) -> Result<Vec<Point>, Box<dyn Error>> {
    let other = if pair == Pair::Opposed { ceiling(1.0) } else { WALL };
    let scene = scene(&[(FLOOR, 0.5, 1.0), (other, 0.5, 1.0)])?;
    let (degree, first_elements, most_elements) = if pair == Pair::Opposed { (4, 32, 1) } else { (2, 8, 150) };
    let fine = Options { error: 1e-5, degree: Some(degree), first_elements, most_elements, ..Options::default() };
    let reference = solve(&scene, &fine, |_| true)?;
    let centre = |i: u32| (f64::from(i) + 0.5) / f64::from(SIDE);
    let places: Vec<DVec3> = (0..SIDE).flat_map(|i| (0..SIDE).map(move |j| DVec3::new(centre(i), centre(j), 0.0))).collect();
    let gather = |&place: &DVec3| Ok(reference.gather(place, DVec3::Z)?.radiosity[0]);
    let exact = places.iter().map(gather).collect::<Result<Vec<f64>, radgrad_solver::Error>>()?;
    let mean = exact.iter().sum::<f64>() / exact.len() as f64;
    let rms_error = |solution: &Solution| {
        let squares = places.iter().zip(&exact).map(|(&place, exact)| (value(solution, place) - exact).powi(2));
        (squares.sum::<f64>() / exact.len() as f64).sqrt() / mean
    };
    let max_elements = MOST[usize::from(pair == Pair::Edge)];
    let mut points = Vec::new();
    for degree in 0..=MAX_DEGREE {
        let point = |uniform: bool, solution: &Solution| {
            let (progress, error) = (solution.progress(), rms_error(solution));
            Point { degree, uniform, elements: progress.elements, error, estimate: progress.estimate }
        };
        // Beyond that the reference is no better.
        let goes_on = |point: &Point| point.error > 1e-7 && point.elements * 4 <= 2 * max_elements;
        let options =
            Options { error: 1e-9, degree: Some(degree), first_elements: 1, most_elements: max_elements, ..Options::default() };
        for first_elements in (0..).map(|level| 2 << (2 * level)) {
            let alike = Options { first_elements, most_elements: 1, ..options };
            points.push(point(true, &solve(&scene, &alike, |_| false)?));
            if !points.last().is_some_and(goes_on) {
                break;
            }
        }
        solve(&scene, &options, |solution| {
            points.push(point(false, solution));
            points.last().is_some_and(goes_on)
        })?;
    }
    Ok(points)
}

/// Radiosity of the polynomials at a place of the floor.
fn value(solution: &Solution, place: DVec3) -> f64 {
    let mesh = solution.mesh();
    let outside = |element: usize| {
        let [s, t] = mesh.elements()[element].reference(place);
        debug_assert_eq!(mesh.elements()[element].shape(), Shape::Parallelogram);
        (-s).max(-t).max(s - 1.0).max(t - 1.0)
    };
    let mut element = 0;
    while let Some(first) = mesh.elements()[element].children() {
        element = (first..first + 4).fold(first, |best, e| if outside(e) < outside(best) { e } else { best });
    }
    solution.value_on(element, 0, mesh.elements()[element].reference(place))
}

/// For each degree the order of convergence of the last two uniform divisions, in the size of elements.
pub(super) fn orders(points: &[Point]) -> Vec<(usize, f64)> {
    let of_degree = |degree: usize| {
        let uniform: Vec<&Point> = points.iter().filter(|p| p.uniform && p.degree == degree).collect();
        let [.., a, b] = uniform[..] else { return None };
        Some((degree, (a.error / b.error).ln() / (0.5 * (b.elements as f64 / a.elements as f64).ln())))
    };
    (0..=MAX_DEGREE).filter_map(of_degree).collect()
}

pub(super) fn graph(pair: Pair, points: &[Point]) -> Graph {
    let line = |degree: usize, uniform: bool| Series {
        name: format!("degree {degree}, {}", if uniform { "uniform" } else { "where it pays" }),
        points: points
            .iter()
            .filter(|p| p.degree == degree && p.uniform == uniform)
            .map(|p| (p.elements as f64, p.error))
            .collect(),
        colour: degree,
        dashed: uniform,
    };
    let what = if pair == Pair::Opposed { "face to face at distance 1" } else { "that meet in an edge" };
    Graph {
        title: format!("Two unit squares {what}"),
        under: "Root mean square error of the polynomials, relative; both reflect half and radiate 1.".to_owned(),
        across: "elements",
        upward: "relative error",
        counts: false,
        series: (0..=MAX_DEGREE).flat_map(|degree| [line(degree, true), line(degree, false)]).collect(),
    }
}
