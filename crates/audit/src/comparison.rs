//! The contenders side by side: relative errors of each on the same cases, family by family.

pub mod contender;
mod single_precision;
pub mod stability;

use std::collections::BTreeMap;
use std::io;

use rayon::prelude::*;

use crate::bounds::digits;
use crate::cases::family::{Family, Name};
use crate::comparison::contender::{Contender, Score};
use crate::comparison::stability::DIGITS;
use crate::measures::distribution::Distribution;
use crate::measures::table::two_digits;

/// Of a dear family one case stands for at most so many of others.
const DEAREST: u64 = 25;

/// A contender's errors of one quantity in a family.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Fared {
    /// Its relative errors, infinite where it had no answer.
    pub errors: Distribution,
    /// Cases in which it had none.
    pub no_answer: u64,
}

impl Fared {
    fn add(&mut self, score: Score, case: Name) {
        if let Some(error) = score.error() {
            self.errors.add(error, case);
            self.no_answer += u64::from(score == Score::NoAnswer);
        }
    }
}

/// The errors of all: value and gradient by family and contender.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Comparison(BTreeMap<(Family, Contender), [Fared; 2]>);

impl Comparison {
    /// Tries all contenders on the first `count` cases of every family that is neither dark nor refused; on fewer where each takes long.
    #[must_use]
    pub fn compute(seed: u64, families: &[Family], count: u64) -> Self {
        let lit = families.iter().filter(|family| !family.is_dark() && !family.is_refused());
        let cases = |family: Family| count.div_ceil(family.dearness().min(DEAREST));
        let names: Vec<Name> =
            lit.flat_map(|&family| (0..cases(family)).map(move |index| Name { family, seed, index })).collect();
        let scored: Vec<(Name, [[Score; 2]; 5])> = names.par_iter().filter_map(|&name| Some((name, scores(name)?))).collect();
        let mut comparison = Self::default();
        for (name, scores) in scored {
            for (contender, scores) in Contender::ALL.into_iter().zip(scores) {
                let fared = comparison.0.entry((name.family, contender)).or_default();
                fared.iter_mut().zip(scores).for_each(|(fared, score)| fared.add(score, name));
            }
        }
        comparison
    }

    /// Value and gradient by family and contender.
    #[must_use]
    pub const fn rows(&self) -> &BTreeMap<(Family, Contender), [Fared; 2]> {
        &self.0
    }

    /// Writes `family,contender,quantity,cases,no_answer,median,p99,worst,worst_case`, none for quantities that a contender is
    /// not meant for; numbers to two digits.
    ///
    /// # Errors
    /// If `writer` fails.
    pub fn write(&self, writer: impl io::Write) -> csv::Result<()> {
        let mut rows = csv::Writer::from_writer(writer);
        rows.write_record(["family", "contender", "quantity", "cases", "no_answer", "median", "p99", "worst", "worst_case"])?;
        for ((family, contender), fared) in &self.0 {
            for (quantity, Fared { errors, no_answer }) in ["value", "gradient"].into_iter().zip(fared) {
                let Some(worst) = errors.worst() else { continue };
                let percentile = |percent| errors.percentile(percent).map_or_else(String::new, |step| step.to_string());
                let [cases, no_answer] = [errors.count(), *no_answer].map(|count| count.to_string());
                let (median, p99) = (percentile(50), percentile(99));
                let (worst, case) = (two_digits(worst.value), worst.case.to_string());
                let row = [family.name(), contender.name(), quantity, &cases, &no_answer, &median, &p99, &worst, &case];
                rows.write_record(row)?;
            }
        }
        Ok(rows.flush()?)
    }
}

/// The scores of all contenders; `None` where the truth is 0 or out of reach, and there is nothing to be relative to.
fn scores(name: Name) -> Option<[[Score; 2]; 5]> {
    let problem = name.case().problem().ok()?;
    let truth = digits::enclosure(&problem, DIGITS).ok()?;
    let is_lit = truth.radiosity_magnitude() > 0.0 && truth.gradient_magnitude() > 0.0;
    is_lit.then(|| Contender::ALL.map(|contender| contender.errors(&problem, &truth)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_corrected_form_is_better_than_the_printed_one_and_the_ladder_than_all_far_away() {
        let comparison = Comparison::compute(1, &[Family::Generic, Family::Far, Family::BackFacing], 20);
        let worst = |family, contender| {
            let [value, gradient] = &comparison.rows()[&(family, contender)];
            [value, gradient].map(|fared| fared.errors.worst().map_or(0.0, |worst| worst.value))
        };
        assert!(worst(Family::Generic, Contender::AsPrinted)[0] > 1e-4);
        assert!(worst(Family::Generic, Contender::Corrected)[0] < 1e-11);
        assert!(worst(Family::Far, Contender::Corrected)[1] > 1e-6);
        assert!(worst(Family::Far, Contender::Certified).iter().all(|error| *error < 1e-13));
        assert_eq!(comparison.rows().keys().filter(|(family, _)| *family == Family::BackFacing).count(), 0);
    }

    #[test]
    fn what_a_contender_is_not_meant_for_has_no_row() {
        let mut text = Vec::new();
        Comparison::compute(1, &[Family::PolynomialFar], 3).write(&mut text).unwrap();
        let text = String::from_utf8(text).unwrap();
        assert!(text.lines().any(|line| line.starts_with("polynomial-far,closed-form,gradient,3,0,")), "{text}");
        assert!(!text.contains("printed"), "{text}");
    }
}
