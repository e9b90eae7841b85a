//! Statements of the solver, the form factors and the fields about a scene: each a value with its stated error.

use std::panic::{AssertUnwindSafe, catch_unwind};

use radgrad_scene::{FactorSettings, FormFactors, Quantity, Scene};
use radgrad_solver::{Ledger, Options, Solution, solve_for};

use super::certificates::certified;
use super::model::{Change, Model, Part};

/// A way to ask about a scene.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Subject {
    /// Radiosity, its mean and at points.
    Solve,
    /// Certificates of the mean and at points.
    Certificate,
    /// Form factors between faces, sums of rows and reciprocity.
    Factors,
    /// Direct light at points of a face.
    Field,
}

impl Subject {
    /// All of them, in the order of the tables.
    pub const ALL: [Self; 4] = [Self::Solve, Self::Certificate, Self::Factors, Self::Field];

    /// Name in tables.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Solve => "solve",
            Self::Certificate => "certificate",
            Self::Factors => "factors",
            Self::Field => "field",
        }
    }
}

/// The quantity of a statement.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Quantum {
    /// Mean radiosity in a channel.
    Mean(usize),
    /// Radiosity at a probe, in a channel.
    Point(usize, usize),
    /// Form factor from a face to another.
    Factor(usize, usize),
    /// `A_i F_ij - A_j F_ji`.
    Reciprocity(usize, usize),
    /// Sum of the factors of a face, in the open at least 1.
    RowSum(usize),
    /// Irradiance straight from all lamps at the middle of a cell of a face.
    Cell(usize, [u64; 3]),
}

impl Quantum {
    /// In words.
    #[must_use]
    pub fn name(self) -> String {
        match self {
            Self::Mean(channel) => format!("mean, channel {channel}"),
            Self::Point(probe, channel) => format!("point {probe}, channel {channel}"),
            Self::Factor(from, to) => format!("factor f{from} -> f{to}"),
            Self::Reciprocity(from, to) => format!("reciprocity f{from}, f{to}"),
            Self::RowSum(face) => format!("sum of row f{face}"),
            Self::Cell(face, at) => {
                let [x, y, z] = at.map(f64::from_bits);
                format!("field on f{face} at ({x}, {y}, {z})")
            }
        }
    }
}

/// The stated error of a value.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Stated {
    /// It is no more than this.
    Bound(f64),
    /// It is about this.
    Estimate(f64),
    /// The quantity is between two limits, which fail with this probability.
    Limits {
        /// The least value.
        low: f64,
        /// The largest value.
        high: f64,
        /// The probability.
        delta: f64,
    },
}

impl Stated {
    /// The bound, or the estimate, or half the distance of the limits.
    #[must_use]
    pub const fn size(self) -> f64 {
        match self {
            Self::Bound(size) | Self::Estimate(size) => size,
            Self::Limits { low, high, .. } => 0.5 * (high - low),
        }
    }

    /// The same of a size that is so many times as large.
    #[must_use]
    pub const fn times(self, factor: f64) -> Self {
        match self {
            Self::Bound(size) => Self::Bound(factor * size),
            Self::Estimate(size) => Self::Estimate(factor * size),
            Self::Limits { low, high, delta } => {
                let (middle, half) = (0.5 * (low + high), 0.5 * factor * (high - low));
                Self::Limits { low: middle - half, high: middle + half, delta }
            }
        }
    }
}

/// A value with its stated error.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Statement {
    /// Its quantity.
    pub of: Quantum,
    /// The value.
    pub value: f64,
    /// The bound on its error or the estimate of it.
    pub stated: Stated,
}

/// An answer.
#[derive(Debug, Clone, PartialEq)]
pub enum Response {
    /// Statements.
    Statements(Vec<Statement>),
    /// None, and why.
    Refused(String),
    /// A panic, which is a fault whatever was asked.
    Panicked,
}

/// The effort of the solver, for most scenes and for some: elements above which it divides nothing, and rounds. It is counted, so that
/// answers depend on the scene and not on the machine's mood.
const ELEMENTS: usize = 50;
const MORE_ELEMENTS: usize = 200;
const ROUNDS: usize = 3;

/// Cells along a side of the face that a field is asked on.
const CELLS: usize = 2;

/// The statements about a scene.
#[must_use]
pub fn ask(model: &Model, subject: Subject) -> Response {
    let answer = || -> Result<Vec<Statement>, String> {
        let scene = model.scene().map_err(|error| error.to_string())?;
        match subject {
            Subject::Solve => {
                let asked = model.asked().map_err(|error| error.to_string())?;
                let served = if model.ways.for_points { &asked[..] } else { &[] };
                let goes_on = |solution: &Solution| solution.progress().round < ROUNDS;
                let solution = solve_for(&scene, &counted(model), &[], served, goes_on).map_err(|error| error.to_string())?;
                radiosities(model, &solution)
            }
            Subject::Certificate => certified(model, &scene),
            Subject::Factors => factors(model, &scene),
            Subject::Field => field(model, &scene),
        }
    };
    match catch_unwind(AssertUnwindSafe(answer)) {
        Ok(Ok(statements)) => Response::Statements(statements),
        Ok(Err(why)) => Response::Refused(why),
        Err(_) => Response::Panicked,
    }
}

/// Values with their bounds, estimates or half the width of their limits.
///
/// # Errors
/// If there is no answer: why.
pub(crate) fn recorded(model: &Model, subject: Subject) -> Result<Vec<(f64, f64)>, String> {
    match ask(model, subject) {
        Response::Statements(statements) => Ok(statements.iter().map(|s| (s.value, s.stated.size())).collect()),
        Response::Refused(why) => Err(why),
        Response::Panicked => Err("it panicked".to_owned()),
    }
}

fn counted(model: &Model) -> Options {
    Options {
        error: model.error,
        degree: model.degree,
        most_elements: if model.ways.long { MORE_ELEMENTS } else { ELEMENTS },
        first_elements: 1,
        marking: model.ways.marking,
        ..Options::default()
    }
}

fn radiosities(model: &Model, solution: &Solution) -> Result<Vec<Statement>, String> {
    let say = |of: Quantum, value: f64, estimate: &Ledger| Statement { of, value, stated: Stated::Estimate(estimate.total()) };
    let means = solution.mean().iter().zip(solution.mean_estimate()).enumerate();
    let mut statements: Vec<Statement> =
        means.map(|(channel, (&value, estimate))| say(Quantum::Mean(channel), value, &estimate)).collect();
    for (probe, (at, normal)) in model.asked().map_err(|error| error.to_string())?.into_iter().enumerate() {
        let gathered = solution.gather(at, normal).map_err(|error| error.to_string())?;
        for (channel, (value, estimate)) in gathered.radiosity.into_iter().zip(&gathered.estimate).enumerate() {
            statements.push(say(Quantum::Point(probe, channel), value, estimate));
        }
    }
    Ok(statements)
}

fn factors(model: &Model, scene: &Scene) -> Result<Vec<Statement>, String> {
    let factors = FormFactors::new(scene).map_err(|error| error.to_string())?;
    let settings = FactorSettings { tolerance: 0.05, most_cells: 300, ..FactorSettings::default() };
    let matrix = factors.matrix(&settings, || ()).map_err(|error| error.to_string())?;
    // A face that was read from a file may be in pieces, or left out.
    let faces = |part: usize| {
        let name = format!("f{part}");
        scene.surfaces_named(&name).flat_map(|surface| scene.surfaces()[surface].faces().iter().copied()).collect()
    };
    let faces: Vec<Vec<usize>> = (0..model.parts.len()).map(faces).collect();
    let area = |part: usize| faces[part].iter().map(|&face| matrix.areas()[face]).sum::<f64>();
    // Areas of the unchanged scene, so that reciprocity of every change is stated in the same unit; no change of a file's unit is made.
    let unchanged = |part: &Part| radgrad_core::Polygon::new(part.corners.clone()).map(|polygon| polygon.area());
    let areas: Vec<f64> = match model.change {
        Change::File(_) => (0..faces.len()).map(area).collect(),
        _ => model.parts.iter().map(unchanged).collect::<Result<_, _>>().map_err(|error| error.to_string())?,
    };
    let mut statements = Vec::new();
    let say = |of: Quantum, value: f64, bound: f64| Statement { of, value, stated: Stated::Bound(bound) };
    // The mean over the pieces of the one of their factors to the other, with its bound. The matrix does not store exact zeros.
    let factor = |from: usize, is_seen: &dyn Fn(usize) -> bool| {
        faces[from].iter().fold([0.0, 0.0], |[value, bound], &face| {
            // Areas of scaled scenes may be none.
            let share = if faces[from].len() == 1 { 1.0 } else { matrix.areas()[face] / area(from) };
            let entries = matrix.row(face).filter(|entry| is_seen(entry.face));
            let [seen, error] = entries.fold([0.0, 0.0], |[seen, error], entry| [seen + entry.factor, error + entry.error]);
            [value + share * seen, bound + share * error]
        })
    };
    for from in (0..faces.len()).filter(|&from| !faces[from].is_empty()) {
        for to in (0..faces.len()).filter(|&to| to != from && !faces[to].is_empty()) {
            let [value, bound] = factor(from, &|face| faces[to].contains(&face));
            statements.push(say(Quantum::Factor(from, to), value, bound));
            if to > from {
                let [back, _] = factor(to, &|face| faces[from].contains(&face));
                let [a, b] = [from, to].map(|face| areas[face]);
                // One exchange a pair, divided by each area: reciprocal to the rounding.
                let bound = SUM * (a * value).abs();
                statements.push(say(Quantum::Reciprocity(from, to), a * value - b * back, bound));
            }
        }
        let [sum, error] = factor(from, &|_| true);
        let bound = error * (1.0 + SUM) + SUM;
        // The factors of a face in an open scene sum to anything up to 1; only a sum above 1 is wrong.
        let value = if model.closed || sum.is_nan() || sum > 1.0 { sum } else { 1.0 };
        statements.push(say(Quantum::RowSum(from), value, bound));
    }
    Ok(statements)
}

/// Rounding of the sums made here, of fewer than a hundred terms of at most 1.
const SUM: f64 = 200.0 * f64::EPSILON;

fn field(model: &Model, scene: &Scene) -> Result<Vec<Statement>, String> {
    if model.has_grid(Quantity::Radiance) {
        return Ok(Vec::new());
    }
    let factors = FormFactors::new(scene).map_err(|error| error.to_string())?;
    let lamp = |face: usize| {
        let material = &scene.materials()[scene.faces()[face].material()];
        material.emitted_radiosity(0).filter(|radiosity| *radiosity > 0.0).map(|radiosity| (face, radiosity))
    };
    let lamps: Vec<(usize, f64)> = (0..scene.faces().len()).filter_map(lamp).collect();
    let mut faces: Vec<usize> = model.probes.iter().map(|probe| probe.part).collect();
    faces.dedup();
    let mut statements = Vec::new();
    for face in faces {
        let surface = scene.faces()[face].surface();
        let cells = factors.field(surface, CELLS, &lamps, radgrad_core::DEFAULT_TOLERANCE, || ());
        for cell in cells.map_err(|error| error.to_string())? {
            let quantum = Quantum::Cell(face, model.change.undone(cell.centre).to_array().map(f64::to_bits));
            statements.push(Statement { of: quantum, value: cell.value, stated: Stated::Bound(cell.value_error) });
        }
    }
    Ok(statements)
}
