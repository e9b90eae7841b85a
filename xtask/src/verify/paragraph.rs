//! The findings of a run of `verify`, in a paragraph that a person can quote.

use std::path::Path;

use radgrad_audit::checks::agreement::Agreement;
use radgrad_audit::measures::distribution::Extreme;
use radgrad_audit::measures::measure::Quantity;
use radgrad_audit::measures::run::Run;
use radgrad_audit::measures::table::Table;

use crate::{bounds, scenes};

/// The findings.
pub(super) struct Found<'a> {
    pub(super) table: &'a Table,
    pub(super) bounds: bounds::Held,
    pub(super) witnesses: usize,
    /// Slips in the second implementation that were caught.
    pub(super) slips: usize,
    pub(super) agreement: Agreement,
    /// Digits, and how many cases were held against the oracle to as many.
    pub(super) digits: Vec<(u32, u64)>,
    /// None where families of cases alone were asked for.
    pub(super) scenes: Option<scenes::Held>,
    pub(super) seconds: f64,
}

impl Found<'_> {
    /// The paragraph.
    pub(super) fn said(&self, run: &Run, out: &Path) -> String {
        let Self { table, bounds, witnesses, slips, agreement, digits, scenes, seconds } = self;
        let digits: Vec<String> = digits.iter().map(|(digits, cases)| format!("{cases} to {digits} digits")).collect();
        let errors = [Quantity::Value, Quantity::Gradient].map(|quantity| worst(table, quantity));
        let [value, gradient] = errors.map(|worst| worst.map_or_else(|| "none".to_owned(), named));
        let over = bounds.worst.map_or_else(|| "none".to_owned(), named);
        let scenes = scenes.map_or_else(
            || "no scenes".to_owned(),
            |scenes| format!("{} scenes with {} bounds judged", scenes.scenes, scenes.judged),
        );
        let Agreement { enclosed, cubature, monte_carlo, paper, contradictions, .. } = agreement;
        let (minutes, report) = (seconds / 60.0, out.join("verify-run.csv"));
        format!(
            "\nIn {} cases of {} families (seed {}), each against an enclosure of its exact value, the worst relative error of the value \
             is {value}, of the gradient {gradient}. Of {} answers in the bounds campaign the largest error over its bound is {over}; \
             {witnesses} recorded cases that come near a bound were asked again. {slips} slips planted in the second implementation \
             were caught. {enclosed} cases enclosed, {cubature} by cubature, {monte_carlo} by sampling, {paper} by appendix A: {} \
             disagree; {} against the oracle. {scenes}. {minutes:.1} minutes; the record is {}, and `cargo xtask report` makes a page of it.",
            table.cases(),
            run.cases.len(),
            run.seed,
            bounds.answers,
            contradictions.len(),
            digits.join(", "),
            report.display(),
        )
    }
}

fn named(worst: Extreme) -> String {
    format!("{:.1e} ({})", worst.value, worst.case)
}

fn worst(table: &Table, quantity: Quantity) -> Option<Extreme> {
    let extremes = table.families().values().filter_map(|family| family.figures().get(&quantity)?.worst());
    extremes.max_by(|a, b| a.value.total_cmp(&b.value))
}

#[cfg(test)]
mod tests {
    use radgrad_audit::cases::family::Family;

    use super::*;

    #[test]
    fn the_paragraph_has_the_recorded_form() {
        let run = Run::of_each(2, &[Family::Generic, Family::Far], 1);
        let table = run.table(|_| ());
        let case = "far:1:1".parse().unwrap();
        let figures = Found {
            table: &table,
            bounds: bounds::Held { passed: true, answers: 18, worst: Some(Extreme { value: 0.5, case }) },
            witnesses: 172,
            slips: 23,
            agreement: Agreement { enclosed: 4, cubature: 3, monte_carlo: 2, paper: 1, contradictions: Vec::new() },
            digits: vec![(34, 7), (50, 5)],
            scenes: Some(scenes::Held { passed: true, scenes: 16, judged: 99 }),
            seconds: 90.0,
        };
        insta::assert_snapshot!(figures.said(&run, Path::new("target/verify")));
    }
}
