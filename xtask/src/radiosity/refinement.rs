//! Error of the polynomials in the Cornell box by the number of elements: all divided alike, those that add most to the error,
//! those with the largest error by the gradient (N. Holzschuch and F. X. Sillion 1995, 3.2), and faces cut along shadow lines into more
//! and more parts.
//!
//! The error is the root mean square over places that cover all faces evenly, relative to the mean radiosity of each channel. Exact
//! is the gather of a finer solution of degree 2.

use std::error::Error;

use radgrad_core::DVec3;
use radgrad_scene::{Degenerate, Scene};
use radgrad_solver::{Marking, Options, Shape, Solution, solve};

use super::graph::{Graph, Series};

/// How a mesh was divided.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Division {
    Uniform,
    Residual,
    Gradient,
    Shadows,
}

impl Division {
    const ALL: [Self; 4] = [Self::Uniform, Self::Residual, Self::Gradient, Self::Shadows];

    const fn name(self) -> &'static str {
        match self {
            Self::Uniform => "uniform",
            Self::Residual => "by the residual",
            Self::Gradient => "by the gradient",
            Self::Shadows => "along shadow lines",
        }
    }
}

/// A solution.
pub(super) struct Point {
    degree: usize,
    division: Division,
    elements: usize,
    errors: Vec<f64>,
    estimate: f64,
}

impl Point {
    pub(super) const HEADER: [&str; 7] = ["degree", "division", "elements", "red", "green", "blue", "estimate"];

    pub(super) fn record(&self) -> Vec<String> {
        let numbers = self.errors.iter().chain([&self.estimate]).map(|v| format!("{v:.3e}"));
        let name = self.division.name().to_owned();
        [self.degree.to_string(), name, self.elements.to_string()].into_iter().chain(numbers).collect()
    }

    /// Over the channels, in the root mean square.
    fn error(&self) -> f64 {
        (self.errors.iter().map(|e| e * e).sum::<f64>() / self.errors.len() as f64).sqrt()
    }
}

/// A place, its share of the area and the radiosity there.
struct Place {
    face: usize,
    point: DVec3,
    share: f64,
    exact: Vec<f64>,
}

/// Bases that are compared, and the error asked for: no links are finer than it needs.
const DEGREES: [(usize, f64); 3] = [(0, 0.03), (1, 0.01), (2, 0.006)];

/// Elements, divided ones too, at most, where division is not uniform.
const MOST: usize = 1300;

const UNIFORM: [usize; 4] = [1, 160, 640, 2560];

/// Parts that faces are cut into along shadow lines.
const PARTS: [usize; 4] = [60, 100, 200, 400];

pub(super) fn measure() -> Result<Vec<Point>, Box<dyn Error>> {
    let file = concat!(env!("CARGO_MANIFEST_DIR"), "/../data/scenes/cornell.obj");
    let scene = Scene::read(file, Degenerate::Refuse)?;
    let rough = Options { error: 0.05, degree: Some(2), first_elements: 300, most_elements: 1, ..Options::default() };
    let places = places(&solve(&scene, &Options { error: 0.02, ..rough }, |_| true)?)?;
    let mut points = Vec::new();
    for (degree, error) in DEGREES {
        let rough = Options { degree: Some(degree), ..rough };
        let point = |division: Division, solution: &Solution| {
            let (elements, estimate) = (solution.progress().elements, solution.progress().estimate);
            Point { degree, division, elements, errors: errors(solution, &places), estimate }
        };
        for first_elements in UNIFORM {
            let solution = solve(&scene, &Options { first_elements, ..rough }, |_| true)?;
            points.push(point(Division::Uniform, &solution));
        }
        for (division, marking) in [(Division::Residual, Marking::Residual), (Division::Gradient, Marking::Gradient)] {
            let options = Options { error, first_elements: 1, most_elements: MOST, marking, ..rough };
            solve(&scene, &options, |solution| {
                points.push(point(division, solution));
                true
            })?;
        }
        for most_elements in PARTS {
            let options = Options { error: 0.001, first_elements: 1, most_elements, marking: Marking::Shadows, ..rough };
            points.push(point(Division::Shadows, &solve(&scene, &options, |_| false)?));
        }
    }
    Ok(points)
}

/// The first points of the additive recurrence of the plastic number on each element of the coarsest mesh.
fn places(reference: &Solution) -> Result<Vec<Place>, radgrad_solver::Error> {
    let (elements, roots) = (reference.mesh().elements(), reference.mesh().roots());
    let total: f64 = roots.iter().map(|&root| elements[root].area()).sum();
    let mut places = Vec::new();
    for element in roots.iter().map(|&root| &elements[root]) {
        let count = (4000.0 * element.area() / total).ceil();
        let mut k = 0.5;
        while k < count {
            let [a, b] = [0.754_877_666_246_692_7 * k, 0.569_840_290_998_053_2 * k].map(f64::fract);
            let place = if element.shape() == Shape::Triangle && a + b > 1.0 { [1.0 - a, 1.0 - b] } else { [a, b] };
            let (face, point) = (element.face(), element.point(place));
            if let Some(leaf) = reference.mesh().leaf_at(face, point) {
                let exact = reference.gather_on(leaf, point)?.radiosity;
                places.push(Place { face, point, share: element.area() / count / total, exact });
            }
            k += 1.0;
        }
    }
    Ok(places)
}

fn errors(solution: &Solution, places: &[Place]) -> Vec<f64> {
    let mesh = solution.mesh();
    let of_channel = |channel: usize| {
        let square = |place: &Place| {
            let leaf = mesh.leaf_at(place.face, place.point)?;
            let value = solution.value_on(leaf, channel, mesh.elements()[leaf].reference(place.point));
            Some(place.share * (value - place.exact[channel]).powi(2))
        };
        places.iter().filter_map(square).sum::<f64>().sqrt() / solution.mean()[channel]
    };
    (0..solution.channels().len()).map(of_channel).collect()
}

/// Elements for one error, that of the most elements divided alike.
pub(super) struct Counts {
    error: f64,
    uniform: f64,
    gradient: f64,
    shadows: f64,
}

impl Counts {
    /// How many times as many elements uniform division needs as the gradient, and that as faces cut along shadow lines.
    pub(super) fn ratios(&self) -> [f64; 2] {
        [self.uniform / self.gradient, self.gradient / self.shadows]
    }
}

impl std::fmt::Display for Counts {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let ([by_gradient, by_shadows], Self { error, uniform, gradient, shadows }) = (self.ratios(), self);
        write!(
            f,
            "an error of {error:.3e} takes {uniform} elements divided alike, {gradient:.0} by the gradient ({by_gradient:.2} times fewer), "
        )?;
        write!(f, "{shadows:.0} along shadow lines ({by_shadows:.2} times fewer)")
    }
}

/// The counts for a degree, between measured ones on lines in logarithms; `None` where none are as good as that.
pub(super) fn counts(points: &[Point], degree: usize) -> Option<Counts> {
    let meshes_of = |division: Division| points.iter().filter(move |p| p.degree == degree && p.division == division);
    let finest = meshes_of(Division::Uniform).next_back()?;
    let error = finest.error();
    let elements = |division: Division| {
        let meshes: Vec<(f64, f64)> = meshes_of(division).map(|point| (point.elements as f64, point.error())).collect();
        let pair = meshes.windows(2).find(|pair| pair[0].1 >= error && pair[1].1 <= error)?;
        let share = (pair[0].1 / error).ln() / (pair[0].1 / pair[1].1).ln();
        Some(pair[0].0 * (pair[1].0 / pair[0].0).powf(share))
    };
    let [gradient, shadows] = [elements(Division::Gradient)?, elements(Division::Shadows)?];
    Some(Counts { error, uniform: finest.elements as f64, gradient, shadows })
}

pub(super) fn degrees() -> impl Iterator<Item = usize> {
    DEGREES.into_iter().map(|(degree, _)| degree)
}

pub(super) fn graph(points: &[Point], degree: usize) -> Graph {
    let line = |(colour, division): (usize, Division)| Series {
        name: division.name().to_owned(),
        points: points
            .iter()
            .filter(|p| p.degree == degree && p.division == division)
            .map(|p| (p.elements as f64, p.error()))
            .collect(),
        colour,
        dashed: division == Division::Uniform,
    };
    Graph {
        title: format!("The Cornell box, elements of degree {degree}"),
        under: "Root mean square error of the polynomials over area and channels, relative to the mean.".to_owned(),
        across: "elements",
        upward: "relative error",
        counts: false,
        series: Division::ALL.into_iter().enumerate().map(line).collect(),
    }
}
