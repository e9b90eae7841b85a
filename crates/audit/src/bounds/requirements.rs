//! Requirements on the bounds table. Some need no number: no bound is broken, every valid case has an answer that is finite and
//! meets its tolerance, a receiver that gets no light is exactly 0, an invalid case is refused. `data/gates.toml` has the others:
//!
//! ```toml
//! [bounds.generic]
//! first-rung = 0.95
//! tightness = 0.01
//!
//! [bounds.far]
//! median-error = 4e-16
//! worst-error = 1e-14
//! ```
//!
//! `first-rung` is the least share of answers to 1e-12 given in double precision, by the Gauss rule or the closed form;
//! `tightness` the least median of error over bound, 0.01 if the median bound is to be at most 100 times the error, an answer
//! without error counting as 0; `median-error` and `worst-error` the largest relative errors of the answer to 1e-12. Each of the
//! three holds for value and gradient.

use std::fmt;

use serde::Deserialize;

use crate::bounds::mark::{Figure, Mark, Rung};
use crate::bounds::table::FamilyTable;
use crate::cases::family::{Family, Name};

/// Requirements on a family beyond the rules without a number.
#[derive(Debug, Clone, Copy, PartialEq, Default, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub struct Requirement {
    /// Least share of answers to 1e-12 by the first rung.
    pub first_rung: Option<f64>,
    /// Least median of error over bound.
    pub tightness: Option<f64>,
    /// Largest median of the relative error.
    pub median_error: Option<f64>,
    /// Largest relative error.
    pub worst_error: Option<f64>,
}

/// A requirement that does not hold.
#[derive(Debug, Clone, PartialEq)]
pub struct Breach {
    /// The first or worst case that does it.
    pub case: Name,
    /// The mark of the case, if it alone is to blame.
    pub mark: Option<Mark>,
    /// The requirement that does not hold, with the figure found.
    pub what: String,
}

impl fmt::Display for Breach {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "bounds of {}: {}, at {}", self.case.family, self.what, self.case)
    }
}

/// Everything in the table of a family that must not be.
pub(crate) fn breaches(family: Family, table: &FamilyTable, required: &Requirement) -> Vec<Breach> {
    let mut breaches = marked(family, table);
    breaches.extend(beyond(table, required));
    breaches
}

/// Cases with a mark that they must not have.
fn marked(family: Family, table: &FamilyTable) -> Vec<Breach> {
    let mut forbidden = Mark::FAULTS.to_vec();
    forbidden.push(if family.is_refused() { Mark::Nonzero } else { Mark::Refused });
    if family.is_refused() {
        forbidden.push(Mark::Zero);
    }
    if family.has_digits() {
        forbidden.push(Mark::ManyDigitsUnanswered);
    }
    if family.is_dark() {
        forbidden.push(Mark::Nonzero);
    }
    if family.is_rounded() {
        forbidden.retain(|mark| !matches!(mark, Mark::MissesDefault | Mark::MissesTight | Mark::ManyDigitsUnanswered));
    }
    let breach = |mark| {
        let bin = table.counts().get(&mark)?;
        Some(Breach { case: bin.first, mark: Some(mark), what: format!("{} {mark}", bin.count) })
    };
    forbidden.into_iter().filter_map(breach).collect()
}

/// Figures of a whole family that miss their requirement.
fn beyond(table: &FamilyTable, required: &Requirement) -> Vec<Breach> {
    let mut breaches = Vec::new();
    if let Some(least) = required.first_rung
        && let share = table.share_of(&Rung::FIRST)
        && share < least
        && let Some(bin) = [Rung::DoubleDouble, Rung::ArbitraryPrecision].iter().find_map(|&r| table.counts().get(&Mark::By(r)))
    {
        let what = format!("{:.2} % are answered by the first rung, {:.0} % must be", 100.0 * share, 100.0 * least);
        breaches.push(Breach { case: bin.first, mark: None, what });
    }
    let mut hold = |figure: Figure, percent: u64, gate: Option<f64>, least: bool| {
        let (Some(gate), Some(distribution)) = (gate, table.figures().get(&figure)) else { return };
        let (Some(worst), Some(step)) = (distribution.worst(), distribution.percentile(percent)) else { return };
        let value = match (percent, least) {
            (100, _) => worst.value,
            (_, true) => step.least(),
            (_, false) => step.end(),
        };
        if if least { value < gate } else { value > gate } {
            let name = if percent == 50 { "the median of " } else { "" };
            let what = format!("{name}{figure} is {value:.2e}, {gate:.0e} is the {}", if least { "least" } else { "most" });
            breaches.push(Breach { case: worst.case, mark: None, what });
        }
    };
    for figure in [Figure::ValueTightness, Figure::GradientTightness] {
        hold(figure, 50, required.tightness, true);
    }
    for figure in [Figure::SharpValueError, Figure::SharpGradientError] {
        hold(figure, 50, required.median_error, false);
    }
    for figure in [Figure::ValueError, Figure::GradientError] {
        hold(figure, 100, required.worst_error, false);
    }
    breaches
}
