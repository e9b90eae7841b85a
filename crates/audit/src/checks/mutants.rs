//! Mutation check: every misprint of the paper and every slip of its kind, planted in turn, must be seen by the measurement.
//!
//! The slips are planted in the second implementation, appendix A of the paper as corrected, on cases it is meant for: in free
//! sight at a few sizes, or in the dark. Uncorrupted it must stay within its gate there; corrupted it must break it, and by a
//! margin: a slip whose effect is below [`MARGIN`] gates is not told from rounding.

use std::io;

use radgrad_paper::appendix::{Misprint, radiosity_and_gradient};
use radgrad_scene::case::Problem;
use rayon::prelude::*;

use crate::cases::family::{Family, Name};
use crate::measures::decade::Decade;
use crate::measures::measure::{is_worse, ratio, worse};
use crate::measures::truth::Truth;

/// Families whose cases the second implementation is good for, where the horizon does not cut them.
const FAMILIES: [Family; 4] = [Family::Generic, Family::NGon, Family::BackFacing, Family::BelowHorizon];

/// A slip must break the gate by this factor.
pub const MARGIN: f64 = 1e3;

/// The second implementation on a number of cases, with one slip or none.
#[derive(Debug, Clone, PartialEq)]
pub struct Mutant {
    /// The slip; `None` is the control.
    pub slip: Option<Misprint>,
    /// Cases; in those with constant emission most slips of a linear one have no effect.
    pub cases: usize,
    /// Cases in which value or gradient is beyond the gate, or there is no answer or none that is finite.
    pub beyond: usize,
    /// Largest relative error of the value, and whose; infinite where there is none that is finite.
    pub value: f64,
    /// Largest relative error of the gradient.
    pub gradient: f64,
    /// The case with the largest of these errors.
    pub worst: Option<Name>,
}

impl Mutant {
    /// Whether all is as it must be: the control within the gate in every case, a slip beyond it by the margin in some.
    #[must_use]
    pub fn passes(&self, gate: f64) -> bool {
        match self.slip {
            None => self.cases > 0 && self.beyond == 0,
            Some(_) => is_worse(worse(self.value, self.gradient), MARGIN * gate),
        }
    }

    /// `ok` for the control, `caught` for a slip; `FAILED` where it is not so.
    #[must_use]
    pub fn verdict(&self, gate: f64) -> &'static str {
        match (self.passes(gate), self.slip) {
            (true, None) => "ok",
            (true, Some(_)) => "caught",
            (false, _) => "FAILED",
        }
    }

    /// Name in the table.
    #[must_use]
    pub fn name(&self) -> &'static str {
        self.slip.map_or("none (control)", Misprint::name)
    }
}

/// Writes `slip,verdict,cases,beyond,value,gradient`, the worst errors by their decade: the same on every machine.
///
/// # Errors
/// If `writer` fails.
pub fn write(rows: &[Mutant], gate: f64, writer: impl io::Write) -> csv::Result<()> {
    let mut file = csv::Writer::from_writer(writer);
    file.write_record(["slip", "verdict", "cases", "beyond", "value", "gradient"])?;
    for row in rows {
        let [cases, beyond] = [row.cases, row.beyond].map(|count| count.to_string());
        let [value, gradient] = [row.value, row.gradient].map(|error| Decade::containing(error).to_string());
        file.write_record([row.name(), row.verdict(gate), &cases, &beyond, &value, &gradient])?;
    }
    Ok(file.flush()?)
}

/// A case with its truth, computed once for all mutants.
struct Witness {
    name: Name,
    problem: Problem,
    truth: Truth,
}

/// A case without a truth or an answer, where both are due, and why.
pub type Lost = (Name, String);

/// Cases of the mutation check: `count` of each family; and those that are lost, each of which is a defect.
fn witnesses(seed: u64, count: u64) -> (Vec<Witness>, Vec<Lost>) {
    let names: Vec<Name> =
        FAMILIES.iter().flat_map(|&family| (0..count).map(move |index| Name { family, seed, index })).collect();
    let witness = |&name: &Name| {
        let problem = name.case().problem().map_err(|error| (name, error.to_string()))?;
        radiosity_and_gradient(&problem.receiver, &problem.emitter, None).map_err(|error| (name, error.to_string()))?;
        let truth = Truth::unoccluded(&problem.receiver, &problem.emitter).map_err(|error| (name, error.to_string()))?;
        Ok(Witness { name, problem, truth })
    };
    let outcomes: Vec<Result<Witness, Lost>> = names.par_iter().map(witness).collect();
    let (mut witnesses, mut lost) = (Vec::new(), Vec::new());
    for one in outcomes {
        match one {
            Ok(witness) => witnesses.push(witness),
            Err(one) => lost.push(one),
        }
    }
    (witnesses, lost)
}

/// The control and every mutant on `count` cases of each family, errors relative to truth, beyond `gate` or not; and the cases that
/// are lost.
#[must_use]
pub fn mutants(seed: u64, count: u64, gate: f64) -> (Vec<Mutant>, Vec<Lost>) {
    let (witnesses, lost) = witnesses(seed, count);
    let slips = std::iter::once(None).chain(Misprint::ALL.iter().copied().map(Some));
    (slips.map(|slip| mutant(slip, &witnesses, gate)).collect(), lost)
}

fn mutant(slip: Option<Misprint>, witnesses: &[Witness], gate: f64) -> Mutant {
    let mut row = Mutant { slip, cases: 0, beyond: 0, value: 0.0, gradient: 0.0, worst: None };
    for witness in witnesses {
        let (value, gradient) = relative_errors(slip, witness);
        row.cases += 1;
        row.beyond += usize::from(is_worse(worse(value, gradient), gate));
        if row.worst.is_none() || is_worse(worse(value, gradient), worse(row.value, row.gradient)) {
            row.worst = Some(witness.name);
        }
        row.value = worse(row.value, value);
        row.gradient = worse(row.gradient, gradient);
    }
    row
}

fn relative_errors(slip: Option<Misprint>, Witness { problem, truth, .. }: &Witness) -> (f64, f64) {
    match radiosity_and_gradient(&problem.receiver, &problem.emitter, slip) {
        Ok((radiosity, gradient)) => (
            ratio(truth.radiosity_error(radiosity), truth.radiosity_magnitude()),
            ratio(truth.gradient_error(gradient), truth.gradient_magnitude()),
        ),
        Err(_) => (f64::INFINITY, f64::INFINITY),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const GATE: f64 = 1e-9;

    #[test]
    fn every_slip_is_caught_and_the_corrected_form_is_not() {
        let (rows, lost) = mutants(1, 30, GATE);
        assert_eq!(lost, []);
        for mutant in rows {
            assert!(mutant.passes(GATE), "{}: {mutant:?}", mutant.name());
        }
    }

    #[test]
    fn a_slip_without_effect_is_reported_as_not_caught() {
        let harmless = mutant(Some(Misprint::K1Constant), &witnesses(1, 6).0, GATE);
        assert!(harmless.cases > 0 && !harmless.passes(GATE), "{harmless:?}");
    }
}
