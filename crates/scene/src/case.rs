//! One case as JSON Lines: the machine interface of `radgrad eval`, one object a line.
//!
//! ```json
//! {"id":"a1","receiver":{"position":[0,0,0],"normal":[0,0,1],"reflectance":1.0},
//!  "emitter":{"vertices":[[0,0,1],[0.5,0.8,1],[1,0,1]],"emission":{"constant":2.0}},"occluders":[],"tolerance":1e-12}
//! ```
//!
//! (here on two lines to be read by people). `normal` may have any length; `id` is the number of the line, `reflectance` 1, `occluders` none and the
//! relative `tolerance` 1e-12 unless given. `"digits": 50` asks for decimal digits, `"hessian": true` for second derivatives too,
//! `"derivatives": true` for those by vertices, occluders, emission, normal and reflectance ([`DerivativesRecord`]):
//! they are no part of the [`Case`] but of the [`Line`]. `"precision"` is the length by which each coordinate of a vertex may be off, of
//! emitter and occluders alike: 0 unless given ([`Polygon::from_rounded`]). `truth`, `family` and `comment` may stand beside them and are passed over; any other field
//! is refused, since a misspelt one would go unseen. Lengths are in one unit of the caller's choice,
//! emission in any unit. Doubles are read and written exactly: the text of a [`Case`] reads back as the same case, bit for bit.
//!
//! A [`Case`] holds the fields of the line; [`Case::problem`] checks it and gives the types of `radgrad-core`; [`Line::answer`]
//! goes the whole way from a line to its answer or refusal.

mod answer;
mod derivatives;
mod emission;
mod estimate;
mod expression;
mod id;
mod point;

use std::io::{self, BufRead};

use radgrad_core::{DVec3, Emission, Emitter, Polygon, Receiver, effort};
use serde::de::IgnoredAny;
use serde::{Deserialize, Serialize};

pub use self::answer::{AnswerRecord, DigitsRecord, EstimateRecord, Refusal, Reply};
pub use self::derivatives::{DerivativeRecord, DerivativesRecord};
pub use self::emission::{EmissionRecord, PolynomialRecord, TermRecord};
pub use self::id::Id;
use crate::error::Error;
use crate::words::without_mark;

/// A case as written.
///
/// ```
/// use radgrad_scene::case::Case;
/// let line = br#"{"id":"a","receiver":{"position":[0,0,0],"normal":[0,0,1]},
///     "emitter":{"vertices":[[0,0,1],[0,1,1],[1,0,1]],"emission":{"vertices":[1,2,4]}}}"#;
/// let problem = Case::from_json(line)?.problem()?;
/// assert!(radgrad_core::evaluate(&problem.receiver, &problem.emitter, &problem.occluders).is_ok());
/// # Ok::<(), radgrad_scene::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(from = "Fields")]
pub struct Case {
    /// Name, given back with the answer.
    pub id: Id,
    /// The receiver.
    pub receiver: ReceiverRecord,
    /// The emitter.
    pub emitter: EmitterRecord,
    /// Vertices of each occluder: planar polygons, opaque from both sides, between receiver and emitter or not.
    pub occluders: Vec<Vec<[f64; 3]>>,
    /// Relative tolerance asked for, of value and gradient.
    pub tolerance: f64,
    /// Length by which each coordinate of a vertex may be off.
    #[serde(skip_serializing_if = "is_0")]
    pub precision: f64,
}

#[allow(clippy::trivially_copy_pass_by_ref, reason = "serde passes fields so")]
fn is_0(value: &f64) -> bool {
    *value == 0.0
}

/// All that may stand in a line.
#[derive(Deserialize)]
#[serde(deny_unknown_fields, expecting = "a case: {\"receiver\": .., \"emitter\": ..}")]
struct Fields {
    #[serde(default, deserialize_with = "given_id")]
    id: Option<Id>,
    receiver: ReceiverRecord,
    emitter: EmitterRecord,
    #[serde(default, deserialize_with = "point::lists")]
    occluders: Vec<Vec<[f64; 3]>>,
    #[serde(default = "default_tolerance")]
    tolerance: f64,
    #[serde(default)]
    precision: f64,
    digits: Option<u32>,
    #[serde(default)]
    hessian: bool,
    #[serde(default)]
    derivatives: bool,
    #[serde(default, rename = "truth")]
    _truth: IgnoredAny,
    #[serde(default, rename = "family")]
    _family: IgnoredAny,
    #[serde(default, rename = "comment")]
    _comment: IgnoredAny,
}

/// A name that is there is none that is null.
fn given_id<'de, D: serde::Deserializer<'de>>(input: D) -> Result<Option<Id>, D::Error> {
    Id::deserialize(input).map(Some)
}

impl From<Fields> for Case {
    fn from(Fields { id, receiver, emitter, occluders, tolerance, precision, .. }: Fields) -> Self {
        let id = id.unwrap_or_else(|| Id::Number(1.into()));
        Self { id, receiver, emitter, occluders, tolerance, precision }
    }
}

/// A receiver as written.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, expecting = "a receiver: {\"position\": [x, y, z], \"normal\": [x, y, z]}")]
pub struct ReceiverRecord {
    /// Position.
    #[serde(deserialize_with = "point::one")]
    pub position: [f64; 3],
    /// Normal, of any length but 0.
    #[serde(deserialize_with = "point::one")]
    pub normal: [f64; 3],
    /// Reflectance, in [0, 1].
    #[serde(default = "default_reflectance")]
    pub reflectance: f64,
}

/// An emitter as written.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, expecting = "an emitter: {\"vertices\": [[x, y, z], ...], \"emission\": ..}")]
pub struct EmitterRecord {
    /// Vertices, counter-clockwise seen from the lit side.
    #[serde(deserialize_with = "point::list")]
    pub vertices: Vec<[f64; 3]>,
    /// Emission over the polygon.
    pub emission: EmissionRecord,
}

const fn default_tolerance() -> f64 {
    radgrad_core::DEFAULT_TOLERANCE
}

const fn default_reflectance() -> f64 {
    1.0
}

/// A case that was checked.
#[derive(Debug, Clone, PartialEq)]
pub struct Problem {
    /// The receiver.
    pub receiver: Receiver,
    /// The emitter.
    pub emitter: Emitter,
    /// The occluders, in the order given.
    pub occluders: Vec<Polygon>,
    /// Relative tolerance, in [0, 1].
    pub tolerance: f64,
}

impl Case {
    /// Reads one line.
    ///
    /// ```
    /// use radgrad_scene::case::Case;
    /// let line = br#"{"id":1,"receiver":{"position":[0,0,0],"normal":[0,0,2]},
    ///     "emitter":{"vertices":[[0,0,1],[0,1,1],[1,0,1]],"emission":{"constant":2}}}"#;
    /// let problem = Case::from_json(line)?.problem()?;
    /// assert_eq!(problem.receiver.reflectance(), 1.0);
    /// # Ok::<(), radgrad_scene::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::Json`] if the line is not a JSON object with the fields of a case.
    pub fn from_json(line: &[u8]) -> Result<Self, Error> {
        Ok(serde_json::from_slice(line)?)
    }

    /// The problem this case states.
    ///
    /// # Errors
    /// If the receiver, the emitter, an occluder or the tolerance is refused by `radgrad-core`; the message names which.
    pub fn problem(&self) -> Result<Problem, Error> {
        let Parts { receiver, polygon, occluders } = self.parts()?;
        let emission = Emission::try_from(&self.emitter.emission);
        let emitter = emission.and_then(|emission| Emitter::new(polygon, emission)).map_err(Error::Emitter)?;
        Ok(Problem { receiver, emitter, occluders, tolerance: self.tolerance })
    }

    /// All but the emission.
    fn parts(&self) -> Result<Parts, Error> {
        let ReceiverRecord { position, normal, reflectance } = &self.receiver;
        let receiver = Receiver::new(DVec3::from_array(*position), DVec3::from_array(*normal), *reflectance);
        let polygon = |v: &[[f64; 3]]| Polygon::from_rounded(v.iter().map(|&v| DVec3::from_array(v)).collect(), self.precision);
        let occluders = self.occluders.iter().enumerate();
        let occluders = occluders.map(|(index, v)| polygon(v).map_err(|source| Error::Occluder { index, source }));
        if !(0.0..=1.0).contains(&self.tolerance) {
            return Err(Error::Tolerance(radgrad_core::Error::Tolerance { value: self.tolerance }));
        }
        Ok(Parts {
            receiver: receiver.map_err(Error::Receiver)?,
            polygon: polygon(&self.emitter.vertices).map_err(Error::Emitter)?,
            occluders: occluders.collect::<Result<_, _>>()?,
        })
    }
}

/// A case but for its emission, checked.
struct Parts {
    receiver: Receiver,
    polygon: Polygon,
    occluders: Vec<Polygon>,
}

/// The answers that a line asks for beside radiosity and gradient in doubles.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Wanted {
    /// That many decimal digits in place of doubles.
    pub digits: Option<u32>,
    /// Second derivatives too.
    pub hessian: bool,
    /// Derivatives by everything that shapes the radiosity too.
    pub derivatives: bool,
}

/// A line that was read: its number, from 1, and its case.
#[derive(Debug, Clone, PartialEq)]
pub struct Line {
    /// Number of the line, from 1, blank lines counted.
    pub number: usize,
    /// The case as written.
    pub case: Case,
    /// The other answers asked for.
    pub wanted: Wanted,
}

/// The rounding of doubles, which no tolerance below it is met by, but one of 0: it asks for the nearest doubles.
const ROUNDING: f64 = f64::EPSILON / 2.0;

impl Line {
    /// Reads line `number`; `None` if it is blank.
    ///
    /// # Errors
    /// A [`Refusal`] if it is no case. It carries the case's id where that can be read.
    pub fn read(number: usize, text: &[u8]) -> Option<Result<Self, Refusal>> {
        let text = if number == 1 { without_mark(text) } else { text };
        if text.trim_ascii().is_empty() {
            return None;
        }
        let fields = serde_json::from_slice::<Fields>(text);
        let line = fields.map(|mut fields| {
            fields.id.get_or_insert_with(|| Id::Number(number.into()));
            let wanted = Wanted { digits: fields.digits, hessian: fields.hessian, derivatives: fields.derivatives };
            Self { number, case: fields.into(), wanted }
        });
        Some(line.map_err(|error| Refusal { id: Id::find(text), line: number, error: error.into() }))
    }

    /// Checks and evaluates the case.
    ///
    /// # Errors
    /// A [`Refusal`] if a value is wrong, or the answer cannot be represented.
    pub fn answer(self) -> Result<Reply, Refusal> {
        let Self { number, case, wanted } = self;
        reply(&case, wanted).map_err(|error| Refusal { id: Some(case.id), line: number, error })
    }

    /// The same within so many operations, counted as [`radgrad_core::effort`] does: whether there is an answer depends on the line alone,
    /// and on no clock.
    ///
    /// ```
    /// use radgrad_scene::case::Line;
    /// let line = br#"{"id":1,"receiver":{"position":[0,0,0],"normal":[0,0,1]},
    ///     "emitter":{"vertices":[[0,0,1],[0,1,1],[1,0,1]],"emission":{"expression":"exp(x)"}}}"#;
    /// let line = Line::read(1, line).unwrap().unwrap();
    /// assert!(line.clone().answer_within(1_000_000_000).is_ok());
    /// assert!(line.answer_within(10).unwrap_err().error.to_string().contains("a line may take 1.00e1"));
    /// ```
    ///
    /// # Errors
    /// As for [`Self::answer`], and [`Error::Effort`].
    pub fn answer_within(self, operations: u64) -> Result<Reply, Refusal> {
        let (line, id) = (self.number, self.case.id.clone());
        let (answer, needed) = effort::within(operations, || self.answer());
        let error = Error::Effort { needed: needed as f64, limit: operations as f64 };
        answer.unwrap_or(Err(Refusal { id: Some(id), line, error }))
    }
}

/// Operations of the comparison of two edges of a polygon, each with each other.
const OF_TWO_EDGES: u64 = 4;

/// The operations of checking the polygons of a case: known before they are done.
fn of_polygons(case: &Case) -> u64 {
    let counts = std::iter::once(&case.emitter.vertices).chain(&case.occluders).map(|vertices| vertices.len() as u64);
    counts.map(|count| OF_TWO_EDGES * count * count / 2).sum()
}

fn reply(case: &Case, wanted: Wanted) -> Result<Reply, Error> {
    if !effort::spend(of_polygons(case)) {
        // Whoever set the limit drops this, and names the limit it takes.
        return Err(Error::Fault);
    }
    let is_finer = 0.0 < case.tolerance && case.tolerance < ROUNDING;
    match wanted.digits {
        None if is_finer => return Err(Error::TooFine { tolerance: case.tolerance, digits: digits_of(case.tolerance) }),
        Some(digits) if is_finer && digits < digits_of(case.tolerance) => {
            return Err(Error::TooFewDigits { digits, tolerance: case.tolerance });
        }
        _ => {}
    }
    let slopes = [(wanted.hessian, "hessian"), (wanted.derivatives, "derivatives")];
    let slopes = slopes.iter().find_map(|(wanted, name)| wanted.then_some(*name));
    if let (Some(second), Some(_)) = (slopes, wanted.digits) {
        return Err(Error::Together { first: "digits", second });
    }
    if let EmissionRecord::Expression { expression } = &case.emitter.emission {
        if let Some(second) = slopes.or(wanted.digits.map(|_| "digits")) {
            return Err(Error::Together { first: "an expression", second });
        }
        let expression = expression::Expression::parse(expression)?;
        let Parts { receiver, polygon, occluders } = case.parts()?;
        let answer = estimate::estimate(&receiver, &polygon, &occluders, &expression, case.tolerance)?;
        return EstimateRecord::new(case.id.clone(), &answer).map(Reply::Estimate);
    }
    let Problem { receiver, emitter, occluders, tolerance } = case.problem()?;
    if let Some(digits) = wanted.digits {
        let answer = radgrad_core::evaluate_digits(&receiver, &emitter, &occluders, digits).map_err(Error::Evaluation)?;
        return Ok(Reply::Digits(DigitsRecord::new(case.id.clone(), answer, digits)));
    }
    let answer = radgrad_core::evaluate_to(&receiver, &emitter, &occluders, tolerance).map_err(Error::Evaluation)?;
    let mut record = AnswerRecord::new(case.id.clone(), &answer);
    if wanted.hessian {
        let hessian = radgrad_core::hessian_to(&receiver, &emitter, &occluders, tolerance).map_err(Error::Evaluation)?;
        record = record.with_hessian(&hessian);
    }
    record.check_finite()?;
    if wanted.derivatives {
        let derivatives = radgrad_core::derivatives(&receiver, &emitter, &occluders, tolerance).map_err(Error::Evaluation)?;
        record.derivatives = Some(DerivativesRecord::new(&derivatives)?);
    }
    Ok(Reply::Doubles(record))
}

/// Digits that meet a tolerance.
fn digits_of(tolerance: f64) -> u32 {
    (0..=radgrad_core::MOST_DIGITS).find(|&digits| libm::pow(10.0, -f64::from(digits)) <= tolerance).unwrap_or(0)
}

/// The cases of `reader` in order, one line in memory at a time. Blank lines are skipped; a bad line is a [`Refusal`] and the
/// next one is read; only a failure to read ends the sequence.
pub fn read<R: BufRead>(mut reader: R) -> impl Iterator<Item = io::Result<Result<Line, Refusal>>> {
    let (mut text, mut number) = (Vec::new(), 0);
    std::iter::from_fn(move || {
        loop {
            text.clear();
            match reader.read_until(b'\n', &mut text) {
                Ok(0) => return None,
                Ok(_) => number += 1,
                Err(error) => return Some(Err(error)),
            }
            if let Some(line) = Line::read(number, &text) {
                return Some(Ok(line));
            }
        }
    })
}

#[cfg(test)]
mod tests;
