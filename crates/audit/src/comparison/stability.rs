//! Where each form loses digits: relative errors over planes of two parameters, as data for maps.
//!
//! A point of a plane is a case. Its truth is [`crate::bounds::digits`], core's enclosure to [`DIGITS`] digits; at one point in
//! [`ORACLE_EVERY`] that enclosure must meet the oracle's, which shares no formula with it. Held against it are the
//! [`Contender`]s; and the ladder must be within its stated bounds, and these within the tolerance, at every point.

mod plane;

use std::fmt;
use std::io;

use radgrad_core::{DEFAULT_TOLERANCE, evaluate};
use radgrad_scene::case::{Case, Problem};
use rayon::prelude::*;

use crate::bounds::digits;
use crate::bounds::mark::Rung;
use crate::comparison::contender::{Contender, Score, stated};
use crate::measures::seen::visible_part;
use crate::measures::table::two_digits;
use crate::measures::truth::Truth;
pub use plane::{Axis, Emitted, Plane};

/// Digits of the truth.
pub const DIGITS: u32 = 22;

/// The oracle checks one truth in so many: a prime, so that it moves over the columns of a plane.
pub const ORACLE_EVERY: usize = 41;

/// One point of a plane.
#[derive(Debug, Clone, PartialEq)]
pub struct Point {
    /// The two parameters.
    pub at: [f64; 2],
    /// By [`Contender::ALL`]: relative errors of value and gradient.
    pub scores: [[Score; 2]; 5],
    /// Relative bounds that the ladder stated for value and gradient.
    pub stated: [f64; 2],
    /// The rung that answered.
    pub rung: Rung,
}

/// A plane of points for one kind of emission.
#[derive(Debug, Clone, PartialEq)]
pub struct Map {
    /// The plane.
    pub plane: Plane,
    /// The emission.
    pub emitted: Emitted,
    /// Points along the first and along the second axis.
    pub cells: [u32; 2],
    /// The points, the first axis running fastest.
    pub points: Vec<Point>,
}

/// A fault, and where it is.
#[derive(Debug, Clone, PartialEq)]
pub struct Complaint {
    /// The message.
    pub what: String,
    /// The case, to be evaluated by itself.
    pub case: Case,
}

impl fmt::Display for Complaint {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.what)
    }
}

/// All maps, and how their truth stood the oracle.
///
/// ```
/// use radgrad_audit::comparison::stability::Stability;
/// let stability = Stability::compute([3, 3], || ());
/// assert!(stability.complaints.is_empty(), "the ladder is within its bounds everywhere");
/// stability.write(std::io::sink())?;
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Stability {
    /// The maps.
    pub maps: Vec<Map>,
    /// Truths that met the oracle's enclosure.
    pub agreed: u64,
    /// Truths that were to be checked where the oracle has no enclosure.
    pub without_oracle: u64,
    /// The fault.
    pub complaints: Vec<Complaint>,
}

impl Stability {
    /// Computes every plane with so many points along each axis, on all cores. `done` is called after each map.
    #[must_use]
    pub fn compute(cells: [u32; 2], done: impl Fn()) -> Self {
        let mut whole = Self::default();
        for plane in Plane::ALL {
            for emitted in Emitted::ALL {
                whole.add(plane, emitted, cells);
                done();
            }
        }
        whole
    }

    fn add(&mut self, plane: Plane, emitted: Emitted, cells: [u32; 2]) {
        let places: Vec<[u32; 2]> = (0..cells[1]).flat_map(|row| (0..cells[0]).map(move |column| [column, row])).collect();
        let looked: Vec<Looked> = places
            .par_iter()
            .enumerate()
            .map(|(index, &place)| look(plane, emitted, plane.values(place, cells), index % ORACLE_EVERY == 0))
            .collect();
        self.agreed += looked.iter().filter(|l| l.oracle == Some(true)).count() as u64;
        self.without_oracle += looked.iter().filter(|l| l.oracle == Some(false)).count() as u64;
        let mut points = Vec::with_capacity(looked.len());
        for Looked { point, complaints, .. } in looked {
            self.complaints.extend(complaints);
            points.push(point);
        }
        self.maps.push(Map { plane, emitted, cells, points });
    }

    /// Writes a row a point: plane, emission, parameters, errors by contender (empty where it is not meant for the case, `inf`
    /// where it has no answer), stated bounds, rung. The same on every machine but for the last digit of an error.
    ///
    /// # Errors
    /// If `writer` fails.
    pub fn write(&self, writer: impl io::Write) -> csv::Result<()> {
        let mut rows = csv::Writer::from_writer(writer);
        let columns = Contender::ALL.iter().flat_map(|c| ["value", "gradient"].map(|of| format!("{}-{of}", c.name())));
        let header: Vec<String> = ["plane", "emission", "x", "y"].map(str::to_owned).into_iter().chain(columns).collect();
        rows.write_record(header.iter().map(String::as_str).chain(["value-bound", "gradient-bound", "rung"]))?;
        for map in &self.maps {
            for point in &map.points {
                let [x, y] = point.at.map(|at| format!("{at:.4e}"));
                let mut row = vec![map.plane.name().to_owned(), map.emitted.name().to_owned(), x, y];
                let errors = point.scores.iter().flatten();
                row.extend(errors.map(|score| score.error().map_or_else(String::new, two_digits)));
                row.extend(point.stated.map(two_digits));
                row.push(point.rung.name().to_owned());
                rows.write_record(&row)?;
            }
        }
        Ok(rows.flush()?)
    }
}

/// A point, and its complaint; whether the oracle agreed, `Some(false)` if it had no enclosure.
struct Looked {
    point: Point,
    complaints: Vec<Complaint>,
    oracle: Option<bool>,
}

fn look(plane: Plane, emitted: Emitted, at: [f64; 2], by_oracle: bool) -> Looked {
    let case = plane.case(emitted, at);
    let nothing = Point { at, scores: [[Score::NotMeant; 2]; 5], stated: [f64::INFINITY; 2], rung: Rung::Zero };
    let complain = |what: String| Complaint { what: format!("{} {}: {what}", plane.name(), emitted.name()), case: case.clone() };
    let answered = case.problem().map_err(|error| error.to_string()).and_then(|problem| {
        let truth = digits::enclosure(&problem, DIGITS)?;
        let answer = evaluate(&problem.receiver, &problem.emitter, &problem.occluders).map_err(|error| error.to_string())?;
        Ok((problem, truth, answer))
    });
    let (problem, truth, answer) = match answered {
        Ok(answered) => answered,
        Err(why) => return Looked { point: nothing, complaints: vec![complain(why)], oracle: None },
    };
    let scores = Contender::ALL.map(|contender| contender.errors(&problem, &truth));
    let mut complaints = Vec::new();
    let (value, gradient) = truth.errors_at_least(answer.radiosity, answer.gradient);
    if value > answer.radiosity_error || gradient > answer.gradient_error {
        complaints.push(complain(format!("errors {value:e} and {gradient:e} are beyond the bounds of {answer:?}")));
    }
    if !answer.meets(DEFAULT_TOLERANCE) {
        complaints.push(complain(format!("the bounds of {answer:?} are beyond the tolerance")));
    }
    let oracle = by_oracle.then(|| agrees(&problem, &truth)).map(|agrees| {
        if agrees == Some(false) {
            complaints.push(complain(format!("the oracle's enclosure and {DIGITS} digits have nothing in common")));
        }
        agrees.is_some()
    });
    Looked {
        point: Point { scores, stated: stated(&answer), rung: Rung::from_method(answer.method), ..nothing },
        complaints,
        oracle,
    }
}

/// Whether the oracle's enclosure meets the truth; `None` where it has none.
fn agrees(problem: &Problem, truth: &Truth) -> Option<bool> {
    let emitter = visible_part(problem)?;
    Some(Truth::unoccluded(&problem.receiver, &emitter).ok()?.overlaps(truth))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_ladder_keeps_its_promise_on_every_plane_and_the_others_do_not() {
        let stability = Stability::compute([7, 5], || ());
        assert!(stability.complaints.is_empty(), "{:?}", stability.complaints);
        assert_eq!(stability.maps.len(), Plane::ALL.len() * Emitted::ALL.len());
        assert!(stability.agreed >= 4, "{} agreed, {} without", stability.agreed, stability.without_oracle);
        for map in &stability.maps {
            let worst = |contender: Contender| {
                let index = Contender::ALL.iter().position(|c| *c == contender).unwrap();
                map.points.iter().flat_map(|p| p.scores[index]).filter_map(Score::error).fold(0.0, f64::max)
            };
            let name = format!("{} {}", map.plane.name(), map.emitted.name());
            assert!(worst(Contender::Certified) < 1e-12, "{name}: {:e}", worst(Contender::Certified));
            assert!(worst(Contender::Corrected) > 1e-9, "{name}: {:e}", worst(Contender::Corrected));
            assert!(map.points.iter().all(|p| p.rung != Rung::Zero), "{name} is dark somewhere");
        }
    }

    #[test]
    fn a_row_has_a_cell_for_every_column() {
        let mut text = Vec::new();
        Stability::compute([2, 2], || ()).write(&mut text).unwrap();
        let text = String::from_utf8(text).unwrap();
        let mut lines = text.lines();
        let columns = lines.next().unwrap().split(',').count();
        assert_eq!(columns, 17);
        assert_eq!(lines.clone().count(), 4 * Plane::ALL.len() * Emitted::ALL.len());
        assert!(lines.all(|line| line.split(',').count() == columns));
    }
}
