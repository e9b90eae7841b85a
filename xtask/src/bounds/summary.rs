//! The bounds table, for people.

use comfy_table::Table as Printed;
use radgrad_audit::bounds::campaign::{DIGITS_EVERY, MANY_BY_ORACLE_EVERY, MANY_EVERY, ORACLE_EVERY};
use radgrad_audit::bounds::mark::{Figure, Mark, Rung};
use radgrad_audit::bounds::table::{FamilyTable, Table};
use radgrad_audit::measures::measure::worse;
use radgrad_audit::measures::run::Run;

use crate::summary::{Ranked, fitted, right_aligned, with_header};

/// The cases that were checked against each truth, then tightness, and with all rows also the rungs that answered.
pub(crate) fn print(table: &Table, run: &Run, all_rows: bool) -> String {
    let rungs = if all_rows { format!("\n{}", fitted(rungs(table))) } else { String::new() };
    format!("{}\n{}{rungs}", checked(table, run), tightness(table).printed(all_rows))
}

fn checked(table: &Table, run: &Run) -> String {
    let total = |mark| table.total(mark);
    let [answers, blunt] = [Mark::Answer, Mark::Blunt].map(total);
    format!(
        "bounds: {} cases, seed {}, {} of them not 0; {answers} answers to 1e-12, 1e-15 and loose tolerances
  against core's answer to a tolerance of 0 (rounding): {} cases
  against core's 22 digits (rounding, sharp), one in {DIGITS_EVERY}: {} cases
  against the oracle's enclosure (formulas too), one in {ORACLE_EVERY}: {} cases; it had none in {} more
  some truth was sharp, its radius within 1 % of the bound, for {} answers; blunt for {blunt}
  30, 50 and 100 digits against twice as many, one in {MANY_EVERY}: {} cases; against the oracle, one in {MANY_BY_ORACLE_EVERY}: {}
  broken {}, without an answer {}, not finite {}, above 1e-12 {}, above 1e-15 {}, many digits broken {}, out of reach {}",
        total(Mark::Case),
        run.seed,
        total(Mark::Nonzero),
        total(Mark::AgainstCore),
        total(Mark::AgainstDigits),
        total(Mark::AgainstOracle),
        total(Mark::WithoutOracle),
        answers - blunt,
        total(Mark::ManyDigits),
        total(Mark::ManyDigitsAgainstOracle),
        total(Mark::Broken),
        total(Mark::Unanswered),
        total(Mark::NonFinite),
        total(Mark::MissesDefault),
        total(Mark::MissesTight),
        total(Mark::ManyDigitsBroken),
        total(Mark::ManyDigitsUnanswered),
    )
}

/// A row a family: counts, largest and median of error over bound (the median also as bound over error), tolerances met.
fn tightness(table: &Table) -> Ranked {
    let mut ranked = Ranked::new(&[
        "family",
        "cases",
        "not 0",
        "broken",
        "largest error / bound\nvalue",
        "\ngradient",
        "median error / bound\nvalue",
        "\ngradient",
        "median bound / error\nvalue",
        "\ngradient",
        "1e-12\nmet, %",
        "1e-15\nmet, %",
        "sharp,\n%",
    ]);
    for (family, table) in table.families() {
        let figure = |value: Option<f64>| value.map_or_else(String::new, |value| format!("{value:.2e}"));
        let inverse = |value: Option<f64>| value.map_or_else(String::new, |value| format!("{:.1}", 1.0 / value));
        let [value, gradient] = [Figure::ValueTightness, Figure::GradientTightness].map(|figure| table.median(figure));
        let largest = [Figure::ValueOverBound, Figure::GradientOverBound].map(|figure| table.largest(figure).unwrap_or(0.0));
        let cells = [
            family.to_string(),
            table.count(Mark::Case).to_string(),
            table.count(Mark::Nonzero).to_string(),
            table.count(Mark::Broken).to_string(),
            figure(table.largest(Figure::ValueOverBound)),
            figure(table.largest(Figure::GradientOverBound)),
            figure(value),
            figure(gradient),
            inverse(value),
            inverse(gradient),
            unmarked_share(table, Mark::MissesDefault, Mark::Nonzero),
            unmarked_share(table, Mark::MissesTight, Mark::Nonzero),
            unmarked_share(table, Mark::Blunt, Mark::Answer),
        ];
        ranked.add(largest.into_iter().fold(0.0, worse), cells.to_vec());
    }
    ranked
}

/// The share of `all` that does not have a mark, in per cent cut (never rounded up to 100).
fn unmarked_share(table: &FamilyTable, mark: Mark, all: Mark) -> String {
    let (marked, all) = (table.count(mark), table.count(all));
    if all == 0 {
        return String::new();
    }
    let percent = 1e-3 * (1e5 * (all - marked) as f64 / all as f64).floor();
    if marked == 0 { "100".to_owned() } else { format!("{percent:.3}") }
}

/// A row a family: shares of the answers to 1e-12 by rung, and median times by rung.
fn rungs(table: &Table) -> Printed {
    let mut printed = with_header(&[
        "family",
        "1e-12 by, %\nquadrature",
        "\nclosed\nform",
        "\ndouble-\ndouble",
        "\narbitrary",
        "median ns of\nzero",
        "\nquadrature",
        "\nclosed\nform",
        "\ndouble-\ndouble",
        "\narbitrary",
    ]);
    for (family, table) in table.families() {
        let share = |rung: Rung| {
            let nonzero = table.count(Mark::Nonzero) > 0;
            if nonzero { format!("{:.2}", 100.0 * table.share_of(&[rung])) } else { String::new() }
        };
        let time = |rung| table.median(Figure::Time(rung)).map_or_else(String::new, |ns| format!("{ns:.0}"));
        let shares = Rung::ALL.into_iter().skip(1).map(share);
        printed.add_row([family.to_string()].into_iter().chain(shares).chain(Rung::ALL.map(time)));
    }
    right_aligned(printed)
}

#[cfg(test)]
mod tests {
    use radgrad_audit::bounds::campaign;
    use radgrad_audit::cases::family::Family;

    use super::*;

    #[test]
    fn tables_for_people_have_the_recorded_form() {
        let run = Run::of_each(3, &[Family::Generic, Family::Far, Family::BackFacing], 1);
        let table = campaign::table(&run, || ());
        // Times are the machine's.
        let titles = rungs(&Table::default());
        insta::assert_snapshot!(format!("{}\n{}\n{titles}", checked(&table, &run), right_aligned(tightness(&table).table)));
    }
}
