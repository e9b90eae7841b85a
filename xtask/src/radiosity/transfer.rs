//! One transfer between two unit squares, projected on a basis of each degree, against the exact one.

use std::error::Error;

use radgrad_core::DVec3;
use radgrad_scene::gauss_legendre;
use radgrad_solver::{MAX_DEGREE, Options, solve};

use super::graph::{Graph, Series};
use super::squares::{FLOOR, Quad, WALL, ceiling, scene};

/// A case and a degree.
pub(super) struct Point {
    case: &'static str,
    degree: usize,
    /// Mean magnitude of the error, and its root mean square, over the mean radiosity.
    mean: f64,
    root_mean_square: f64,
}

impl Point {
    pub(super) fn record(&self) -> Vec<String> {
        vec![
            self.case.to_owned(),
            self.degree.to_string(),
            format!("{:.3e}", self.mean),
            format!("{:.3e}", self.root_mean_square),
        ]
    }
}

const CASES: [(&str, Quad); 4] = [
    ("parallel, gap 1", ceiling(1.0)),
    ("parallel, gap 0.3", ceiling(0.3)),
    ("parallel, gap 0.1", ceiling(0.1)),
    ("perpendicular, common edge", WALL),
];

/// The figures of H. Zatz (1993) at gap 1, by order.
const PUBLISHED: [f64; 5] = [0.1, 0.1, 0.0075, 0.0075, 0.0004];

pub(super) fn measure() -> Result<Vec<Point>, Box<dyn Error>> {
    let line: Vec<(f64, f64)> = gauss_legendre(24).iter().map(|&(x, w)| (0.5 + 0.5 * x, 0.5 * w)).collect();
    let mut points = Vec::new();
    for (case, other) in CASES {
        let scene = scene(&[(FLOOR, 0.5, 0.0), (other, 0.0, 1.0)])?;
        for degree in 0..=MAX_DEGREE {
            let options = Options { degree: Some(degree), first_elements: 1, most_elements: 1, ..Options::default() };
            let solution = solve(&scene, &options, |_| true)?;
            let (mut whole, mut first, mut second) = (0.0, 0.0, 0.0);
            for (s, v) in &line {
                for (t, w) in &line {
                    let exact = solution.gather_on(0, DVec3::new(*s, *t, 0.0))?.radiosity[0];
                    let error = (solution.value_on(0, 0, [*s, *t]) - exact).abs();
                    whole += v * w * exact;
                    first += v * w * error;
                    second += v * w * error * error;
                }
            }
            points.push(Point { case, degree, mean: first / whole, root_mean_square: second.sqrt() / whole });
        }
    }
    Ok(points)
}

pub(super) fn graph(points: &[Point]) -> Graph {
    let of_case = |(colour, (case, _)): (usize, (&'static str, Quad))| Series {
        name: case.to_owned(),
        points: points.iter().filter(|p| p.case == case).map(|p| (p.degree as f64, p.mean)).collect(),
        colour,
        dashed: false,
    };
    let mut series: Vec<Series> = CASES.into_iter().enumerate().map(of_case).collect();
    let published = PUBLISHED.iter().enumerate().map(|(degree, error)| (degree as f64, *error)).collect();
    series.push(Series { name: "Zatz 1993, gap 1".to_owned(), points: published, colour: 0, dashed: true });
    Graph {
        title: "One transfer between two unit squares".to_owned(),
        under: "Mean magnitude of the error over the mean radiosity, on a basis of each degree.".to_owned(),
        across: "degree",
        upward: "relative error",
        counts: true,
        series,
    }
}
