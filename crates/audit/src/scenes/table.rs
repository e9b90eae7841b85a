//! Scenes counted by family and subject, and the gates they must stay within.

use std::collections::BTreeMap;
use std::io::Write;
use std::time::Duration;

use serde::Deserialize;

use radgrad_oracle::scene::Effort;

use super::certificates::CERTIFIED;
use super::family::{Family, Name};
use super::judge::{Ending, Judged, Outcome, RARE, Verdict, judge_as_sharply, judge_certificates};
use super::model::Expected;
use super::statement::{Quantum, Stated, Subject};
use super::truth::Sharpness;
use super::workers::on_all_cores;

/// Requirements on scenes.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct Requirement {
    /// Bounds that may be broken; also answers that must not be, panics, other digits and missing truths.
    pub broken: u64,
    /// Largest part of the estimates that were judged of which the error may be more than [`super::judge::ESTIMATES`] times.
    pub most_off: f64,
    /// Largest part of the limits of certificates that may fail, of those at a probability of `CERTIFIED`.
    pub most_missed: f64,
    /// Least part of the statements of a family that was judged.
    pub least_judged: f64,
    /// Least share of gradients within a hundredth of their length.
    pub least_gradients: f64,
    /// Largest median of the estimates of their errors over the errors.
    pub most_gradient_estimate: f64,
}

impl Requirement {
    /// How many of so many limits at `CERTIFIED` may fail: the part that is allowed, or more of few by chance, by two standard
    /// deviations.
    #[must_use]
    pub fn may_miss(&self, of: u64) -> f64 {
        let expected = CERTIFIED * of as f64;
        (self.most_missed * of as f64).max(expected + 2.0 * expected.sqrt())
    }
}

impl Default for Requirement {
    fn default() -> Self {
        Self {
            broken: 0,
            most_off: 0.05,
            most_missed: 0.015,
            least_judged: 0.5,
            least_gradients: 0.95,
            most_gradient_estimate: 5.0,
        }
    }
}

/// Scenes of a family that were asked one thing.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Row {
    /// Scenes.
    pub scenes: u64,
    /// Statements that held.
    pub held: u64,
    /// Statements that did not.
    pub broken: u64,
    /// Statements of which the error is more than it is estimated to be.
    pub off: u64,
    /// Limits that failed, of [`Self::fallible`] that may at times.
    pub missed: u64,
    /// Limits of certificates that are to fail with a probability of at least [`RARE`], as far as they were judged.
    pub fallible: u64,
    /// Statements whose truth is too rough.
    pub rough: u64,
    /// Scenes refused that may be.
    pub refused: u64,
    /// Scenes that failed otherwise: refused or answered where that must not be, panics, other digits, no truth.
    pub failed: u64,
    /// Bound over error of the statements held.
    pub over_error: Vec<f64>,
    /// Estimate over error, of the statements that are off too.
    pub estimates: Vec<f64>,
    /// Half-width over truth of limits of means that may not fail.
    pub widths: Vec<f64>,
    /// Of the answers.
    pub answer: Duration,
    /// Of the truths.
    pub truth: Duration,
}

/// A scene at which something is wrong.
#[derive(Debug, Clone, PartialEq)]
pub struct Violation {
    /// The scene.
    pub name: Name,
    /// The subject.
    pub subject: Subject,
    /// Everything that is wrong with it.
    pub faults: Vec<String>,
}

/// All scenes of a run.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Table {
    /// By family and subject.
    pub rows: BTreeMap<(Family, Subject), Row>,
    /// In the order of their names.
    pub violations: Vec<Violation>,
    /// Every statement that was judged.
    pub statements: Vec<(Name, Judged)>,
}

impl Table {
    /// So many scenes, shared among the families, on all cores. `done` is called after each, from any thread, with its
    /// violations.
    pub fn measure(
        families: &[Family],
        cases: u64,
        seed: u64,
        effort: &Effort,
        done: impl Fn(Name, &[Violation]) + Sync,
    ) -> Self {
        let each = cases.div_ceil(families.len().max(1) as u64);
        let names: Vec<Name> =
            (0..each).flat_map(|index| families.iter().map(move |&family| Name { family, seed, index })).collect();
        let judge_scene = |&name: &Name| {
            let model = name.model();
            let effort = (effort, Sharpness::OfEstimates);
            let mut outcomes: Vec<(Subject, Outcome)> = Vec::new();
            for &subject in name.family.subjects(name.index) {
                let outcome = match &outcomes[..] {
                    [(Subject::Solve, solved), ..] if subject == Subject::Certificate => {
                        judge_certificates(&model, solved, effort)
                    }
                    _ => judge_as_sharply(&model, subject, effort),
                };
                outcomes.push((subject, outcome));
            }
            let failing = outcomes.iter().filter(|(_, outcome)| outcome.fails(&model));
            let violations: Vec<Violation> =
                failing.map(|(subject, outcome)| Violation { name, subject: *subject, faults: outcome.faults(&model) }).collect();
            done(name, &violations);
            (name, model.expected, outcomes, violations)
        };
        let outcomes = on_all_cores(&names, judge_scene);
        let mut table = Self::default();
        for (name, expected, outcomes, violations) in outcomes {
            table.violations.extend(violations);
            outcomes.into_iter().for_each(|(subject, outcome)| table.add(name, subject, outcome, expected));
        }
        table.violations.sort_by_key(|violation| (violation.name, violation.subject));
        table
    }

    fn add(&mut self, name: Name, subject: Subject, outcome: Outcome, expected: Expected) {
        let row = self.rows.entry((name.family, subject)).or_default();
        row.scenes += 1;
        row.answer += outcome.answer;
        row.truth += outcome.truth;
        match outcome.ending {
            Ending::Judged(all) => {
                for one in all {
                    let count = match one.verdict {
                        Verdict::Held => &mut row.held,
                        Verdict::Broken => &mut row.broken,
                        Verdict::Off => &mut row.off,
                        Verdict::Missed => &mut row.missed,
                        Verdict::Rough => &mut row.rough,
                    };
                    *count += 1;
                    match (one.verdict, one.statement.stated) {
                        (Verdict::Held, Stated::Bound(_)) => row.over_error.push(one.over_error()),
                        (Verdict::Held | Verdict::Off, Stated::Estimate(_)) => row.estimates.push(one.over_error()),
                        (Verdict::Held | Verdict::Missed, Stated::Limits { delta, .. }) if delta >= RARE => row.fallible += 1,
                        (Verdict::Held, Stated::Limits { .. }) if matches!(one.statement.of, Quantum::Mean(_)) => {
                            row.widths.push(one.statement.stated.size() / one.known.value);
                        }
                        _ => {}
                    }
                    self.statements.push((name, one));
                }
            }
            Ending::Refused(_) if expected != Expected::Answer => row.refused += 1,
            _ => row.failed += 1,
        }
    }

    /// Scenes.
    #[must_use]
    pub fn scenes(&self) -> u64 {
        // Of each family the first thing that is asked is asked of every scene.
        let is_first = |family: Family, subject| family.subjects(0).first() == Some(&subject);
        self.rows.iter().filter(|((family, subject), _)| is_first(*family, *subject)).map(|(_, row)| row.scenes).sum()
    }

    /// Statements that were judged.
    #[must_use]
    pub fn judged(&self) -> u64 {
        self.sum(Row::judged)
    }

    /// The part of the estimates that were judged of which the error is more than it is estimated to be; `None` of none.
    #[must_use]
    pub fn share_off(&self) -> Option<f64> {
        let [off, all] = [self.sum(|row| row.off), self.sum(|row| row.estimates.len() as u64)];
        (all > 0).then(|| off as f64 / all as f64)
    }

    /// Limits of certificates that failed, of how many that may at times.
    #[must_use]
    pub fn missed(&self) -> [u64; 2] {
        [self.sum(|row| row.missed), self.sum(|row| row.fallible)]
    }

    /// Bounds broken, and scenes that failed otherwise.
    #[must_use]
    pub fn wrong(&self) -> u64 {
        self.sum(|row| row.broken + row.failed)
    }

    fn sum(&self, of: impl Fn(&Row) -> u64) -> u64 {
        self.rows.values().map(of).sum()
    }

    /// Families and subjects of which too small a part was judged.
    #[must_use]
    pub fn hardly_judged(&self, requirement: &Requirement) -> Vec<(Family, Subject, f64)> {
        let part = |row: &Row| row.judged() as f64 / (row.judged() + row.rough) as f64;
        let rows = self.rows.iter().filter(|(_, row)| row.judged() + row.rough > 0);
        let hardly = rows.filter(|(_, row)| part(row) < requirement.least_judged);
        hardly.map(|((family, subject), row)| (*family, *subject, part(row))).collect()
    }

    /// The rows as CSV.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn write(&self, out: impl Write) -> Result<(), csv::Error> {
        let record = |((family, subject), row): (&(Family, Subject), &Row)| {
            let Row { scenes, held, broken, off, missed, rough, refused, failed, .. } = row;
            let counts = [scenes, held, broken, off, missed, rough, refused, failed].map(u64::to_string);
            let figures = [
                figure(row.median_over_error()),
                figure(row.median_estimate()),
                figure(row.median_width()),
                format!("{:.3}", row.seconds_an_answer()),
                format!("{:.3}", row.truth.as_secs_f64() / row.scenes as f64),
            ];
            [family.name().to_owned(), subject.name().to_owned()].into_iter().chain(counts).chain(figures).collect::<Vec<_>>()
        };
        write_rows(out, &HEADER, self.rows.iter().map(record))
    }

    /// Every statement as CSV: value, bound or estimate, and truth.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn write_statements(&self, out: impl Write) -> Result<(), csv::Error> {
        let record = |(name, judged): &(Name, Judged)| {
            let Judged { statement, known, verdict, .. } = judged;
            let verdict = match verdict {
                Verdict::Held => "held",
                Verdict::Broken => "broken",
                Verdict::Off => "off",
                Verdict::Missed => "missed",
                Verdict::Rough => "rough",
            };
            let [bound, estimate, delta] = match statement.stated {
                Stated::Bound(bound) => [format!("{bound:e}"), String::new(), String::new()],
                Stated::Estimate(estimate) => [String::new(), format!("{estimate:e}"), String::new()],
                Stated::Limits { delta, .. } => [format!("{:e}", statement.stated.size()), String::new(), format!("{delta:e}")],
            };
            let truth = [known.value, known.interval.low, known.interval.high].map(|x| format!("{x:e}"));
            let said = [format!("{:e}", statement.value), bound, estimate, delta];
            let record = [name.to_string(), statement.of.name()].into_iter().chain(said).chain(truth);
            record.chain([verdict.to_owned()]).collect::<Vec<_>>()
        };
        let header = ["scene", "quantity", "value", "bound", "estimate", "delta", "truth", "low", "high", "verdict"];
        write_rows(out, &header, self.statements.iter().map(record))
    }
}

/// Columns of the table.
pub const HEADER: [&str; 15] = [
    "family",
    "subject",
    "scenes",
    "held",
    "broken",
    "off",
    "missed",
    "rough",
    "refused",
    "failed",
    "median_bound_over_error",
    "median_estimate_over_error",
    "median_half_width_over_mean",
    "seconds_an_answer",
    "seconds_a_truth",
];

/// A header and rows as CSV.
pub(super) fn write_rows<R: IntoIterator<Item: AsRef<[u8]>>>(
    out: impl Write,
    header: &[&str],
    rows: impl Iterator<Item = R>,
) -> Result<(), csv::Error> {
    let mut table = csv::Writer::from_writer(out);
    table.write_record(header)?;
    for row in rows {
        table.write_record(row)?;
    }
    table.flush()?;
    Ok(())
}

fn figure(value: Option<f64>) -> String {
    value.map_or_else(String::new, |value| format!("{value:.3e}"))
}

impl Row {
    /// Statements that were judged.
    #[must_use]
    pub const fn judged(&self) -> u64 {
        self.held + self.broken + self.off + self.missed
    }

    /// Median of bound over error among the statements held, the truth's half-width being the least error that can be told.
    #[must_use]
    pub fn median_over_error(&self) -> Option<f64> {
        median(&self.over_error)
    }

    /// Median of estimate over error.
    #[must_use]
    pub fn median_estimate(&self) -> Option<f64> {
        median(&self.estimates)
    }

    /// Median half-width of certificates of means over the mean.
    #[must_use]
    pub fn median_width(&self) -> Option<f64> {
        median(&self.widths)
    }

    /// Wall time of an answer, on a machine where other scenes are asked for beside it.
    #[must_use]
    pub fn seconds_an_answer(&self) -> f64 {
        self.answer.as_secs_f64() / self.scenes as f64
    }
}

pub(super) fn median(values: &[f64]) -> Option<f64> {
    let mut sorted: Vec<f64> = values.iter().copied().filter(|value| !value.is_nan()).collect();
    sorted.sort_by(f64::total_cmp);
    sorted.get(sorted.len() / 2).copied()
}
