//! The truth of each statement: exact where the scene has a closed form, an enclosure of direct light, else limits from walks.

use glam::DVec3;
use radgrad_oracle::confidence::ConfidenceInterval;
use radgrad_oracle::scene::{Effort, Kind, Known, Point, Scene};

use super::model::{Error, Exact, Model, Probe};
use super::statement::{Quantum, Statement, Subject};

/// The cost of walks, and the confidence with which their limits hold: of twenty thousand statements none is taken for wrong by
/// chance with a probability of 0.998 and more.
pub const EFFORT: Effort = Effort { rays: 600_000, rays_a_point: 1_000_000, digits: 15, seed: 1, confidence: 1.0 - 1e-7 };

/// How sharp a truth is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Sharpness {
    /// As sharp as the effort makes it.
    Full,
    /// As sharp as the estimates that it judges need: a value that a few rays know to [`OF_ESTIMATE`] of an estimate gets no
    /// more.
    OfEstimates,
}

/// The part of an estimate that the half-width of a truth need not be less than.
pub const OF_ESTIMATE: f64 = 0.2;

/// The first rays, as a part of all.
const FIRST: usize = 16;

/// Rays from a face for its form factors.
const SIGHTS: u32 = 16_384;

/// Relative rounding of the solver's input: reflectances as they are, radiosities as pi times a radiance.
const GIVEN: f64 = 1e-14;

/// The truth of a scene, as far as it is asked for.
#[derive(Debug)]
pub struct Truth {
    /// Mean of `B - E` in each channel, plus a hundredth of that of E for scenes that reflect next to nothing: half-widths are
    /// compared with it. Empty where only geometry is asked.
    pub scale: Vec<f64>,
    /// Of each statement, in their order.
    pub known: Vec<Known>,
}

impl Truth {
    /// The truth of all statements on a subject.
    ///
    /// # Errors
    /// If the oracle refuses the scene.
    pub fn compute(
        model: &Model,
        subject: Subject,
        statements: &[Statement],
        (effort, sharpness): (&Effort, Sharpness),
    ) -> Result<Self, Error> {
        match subject {
            Subject::Solve | Subject::Certificate => Self::of_radiosities(model, statements, effort, sharpness),
            Subject::Factors => Self::of_factors(model, statements, effort),
            Subject::Field => Self::of_field(model, statements, effort),
        }
    }

    fn of_radiosities(model: &Model, statements: &[Statement], effort: &Effort, sharpness: Sharpness) -> Result<Self, Error> {
        let points: Vec<Point> = model.probes.iter().map(|p| Point { face: p.part, position: p.position }).collect();
        let (mut means, mut at_points) = (Vec::new(), Vec::new());
        for channel in 0..model.channels() {
            let (mean, points) = match &model.exact {
                Exact::Even(value) => {
                    let largest = model.parts.iter().map(|part| part.reflectance[channel]).fold(0.0, f64::max);
                    let even = around(*value, value * GIVEN / (1.0 - largest));
                    (Mean { emitted: 0.0, reflected: even }, vec![even; points.len()])
                }
                Exact::Facing(rectangles) => {
                    let (reflected, points) =
                        rectangles.truth(&model.probes.iter().map(Probe::on_a_rectangle).collect::<Vec<_>>());
                    let emitted = model.oracle(channel)?.truth(&[], &Effort { rays: 1, ..*effort })?.emitted;
                    (Mean { emitted, reflected }, points)
                }
                Exact::Nothing => {
                    let (scene, effort) = (model.oracle(channel)?, for_faces(effort, model.parts.len()));
                    let truth = match sharpness {
                        Sharpness::Full => scene.truth(&points, &effort)?,
                        Sharpness::OfEstimates => as_sharp_as_estimates(&scene, &points, &effort, (statements, channel))?,
                    };
                    (Mean { emitted: truth.emitted, reflected: truth.reflected }, truth.points)
                }
            };
            means.push(mean);
            at_points.push(points);
        }
        let scale = |mean: &Mean| mean.reflected.value + 0.01 * mean.emitted;
        let truth_of = |statement: &Statement| match statement.of {
            Quantum::Mean(channel) => {
                let Mean { emitted, reflected } = means[channel];
                let plus = |x: f64| emitted + x;
                let interval = ConfidenceInterval { low: plus(reflected.interval.low), high: plus(reflected.interval.high) };
                rounded(Known { value: plus(reflected.value), interval })
            }
            Quantum::Point(probe, channel) => rounded(at_points[channel][probe]),
            _ => unknown(),
        };
        Ok(Self { scale: means.iter().map(scale).collect(), known: statements.iter().map(truth_of).collect() })
    }

    fn of_factors(model: &Model, statements: &[Statement], effort: &Effort) -> Result<Self, Error> {
        let scene = model.oracle(0)?;
        let pieces = model.visible_pieces();
        let mut areas = vec![0.0; model.parts.len()];
        pieces.iter().zip(scene.faces()).for_each(|((part, _), face)| areas[*part] += face.polygon.area());
        // The factors of a face are the means of those of its pieces, and each is the sum of those to the pieces of the other.
        let mut factors = vec![vec![around(0.0, 0.0); model.parts.len()]; model.parts.len()];
        for (face, (from, _)) in pieces.iter().enumerate() {
            let share = scene.faces()[face].polygon.area() / areas[*from];
            for (known, (to, _)) in scene.sights(face, SIGHTS, effort.seed, effort.confidence)?.into_iter().zip(&pieces) {
                factors[*from][*to] = plus(factors[*from][*to], share, known);
            }
        }
        let truth_of = |statement: &Statement| match statement.of {
            Quantum::Factor(from, to) => factors[from][to],
            Quantum::Reciprocity(..) => around(0.0, 0.0),
            Quantum::RowSum(_) => around(1.0, 0.0),
            _ => unknown(),
        };
        Ok(Self { scale: Vec::new(), known: statements.iter().map(truth_of).collect() })
    }

    fn of_field(model: &Model, statements: &[Statement], effort: &Effort) -> Result<Self, Error> {
        let scene = model.oracle(0)?;
        let truth_of = |statement: &Statement| match statement.of {
            Quantum::Cell(face, at) => {
                let point = Point { face, position: DVec3::from(at.map(f64::from_bits)) };
                Ok(rounded(enclosed(&scene, &point, effort)?))
            }
            _ => Ok(unknown()),
        };
        Ok(Self { scale: Vec::new(), known: statements.iter().map(truth_of).collect::<Result<_, Error>>()? })
    }
}

/// Estimates of walks of so many rays, and of rays from a face, of a scene: values with half the width of their limits.
///
/// # Errors
/// If the oracle refuses the scene: why.
pub(crate) fn recorded(model: &Model, rays: u32) -> Result<Vec<(f64, f64)>, String> {
    let (scene, said) = (model.oracle(0).map_err(|error| error.to_string())?, |error: radgrad_oracle::Error| error.to_string());
    let points: Vec<Point> = model.probes.iter().map(|p| Point { face: p.part, position: p.position }).collect();
    let effort = Effort { rays: rays as usize, rays_a_point: rays as usize, ..EFFORT };
    let mut truths = Vec::new();
    for kind in [Kind::Particles, Kind::NextEvent, Kind::Plain] {
        let truth = scene.truth_of_kind(&points, &effort, kind).map_err(said)?;
        truths.extend(std::iter::once(truth.reflected).chain(truth.points));
    }
    truths.extend(scene.sights(0, rays, effort.seed, effort.confidence).map_err(said)?);
    Ok(truths.iter().map(|known| (known.value, 0.5 * known.interval.width())).collect())
}

/// Few rays for all, then all for the points that these do not tell. Both hold at the confidence asked for, together.
fn as_sharp_as_estimates(
    scene: &Scene,
    points: &[Point],
    effort: &Effort,
    (statements, channel): (&[Statement], usize),
) -> Result<radgrad_oracle::scene::Truth, Error> {
    let effort = Effort { confidence: 1.0 - 0.5 * (1.0 - effort.confidence), ..*effort };
    let first = Effort { rays: effort.rays / FIRST, rays_a_point: effort.rays_a_point / FIRST, ..effort };
    let mut truth = scene.truth(points, &first)?;
    let is_told = |known: &Known, of: Quantum| {
        let mut estimates = statements.iter().filter(|statement| statement.of == of).map(|statement| statement.stated.size());
        estimates.all(|estimate| 0.5 * known.interval.width() <= OF_ESTIMATE * estimate)
    };
    let is_mean_told = is_told(&truth.reflected, Quantum::Mean(channel));
    let untold: Vec<usize> =
        (0..points.len()).filter(|&probe| !is_told(&truth.points[probe], Quantum::Point(probe, channel))).collect();
    if is_mean_told && untold.is_empty() {
        return Ok(truth);
    }
    let asked: Vec<Point> = untold.iter().map(|&probe| points[probe]).collect();
    let sharper = scene.truth(&asked, &Effort { rays: if is_mean_told { 1 } else { effort.rays }, ..effort })?;
    untold.into_iter().zip(sharper.points).for_each(|(probe, known)| truth.points[probe] = known);
    if !is_mean_told {
        truth.reflected = sharper.reflected;
    }
    Ok(truth)
}

/// More rays where there are few faces, which a ray costs less for.
fn for_faces(effort: &Effort, faces: usize) -> Effort {
    let times = (MANY_FACES / faces.max(1)).clamp(1, 4);
    Effort { rays: effort.rays * times, rays_a_point: effort.rays_a_point * times, ..*effort }
}

/// Faces of a scene that costs the stated effort.
const MANY_FACES: usize = 36;

/// Direct light at a point; where it is not enclosed nothing is known.
fn enclosed(scene: &Scene, point: &Point, effort: &Effort) -> Result<Known, Error> {
    match scene.direct(point, effort.digits) {
        Ok(interval) => Ok(Known { value: 0.5 * (interval.low + interval.high), interval }),
        Err(
            radgrad_oracle::Error::Budget { .. } | radgrad_oracle::Error::Rounding { .. } | radgrad_oracle::Error::Cell { .. },
        ) => Ok(unknown()),
        Err(error) => Err(error.into()),
    }
}

#[derive(Clone, Copy)]
struct Mean {
    emitted: f64,
    reflected: Known,
}

const fn around(value: f64, half: f64) -> Known {
    Known { value, interval: ConfidenceInterval { low: value - half, high: value + half } }
}

/// A sum with a part of another, each anywhere in its interval.
fn plus(sum: Known, share: f64, of: Known) -> Known {
    let low = sum.interval.low + share * of.interval.low;
    let high = sum.interval.high + share * of.interval.high;
    Known { value: sum.value + share * of.value, interval: ConfidenceInterval { low, high } }
}

const fn unknown() -> Known {
    Known { value: 0.0, interval: ConfidenceInterval { low: f64::NEG_INFINITY, high: f64::INFINITY } }
}

/// Wider by the motion through the rounding of the solver's input.
fn rounded(known: Known) -> Known {
    let by = GIVEN * known.value.abs();
    let interval = ConfidenceInterval { low: known.interval.low - by, high: known.interval.high + by };
    Known { value: known.value, interval }
}
