//! The course, the findings and the end of a run, for people.

use comfy_table::presets::UTF8_FULL_CONDENSED;
use comfy_table::{CellAlignment, ColumnConstraint, Table as Printed};
use indicatif::ProgressStyle;
use radgrad_audit::cases::family::Family;
use radgrad_audit::checks::mutants::Mutant;
use radgrad_audit::gates::Gates;
use radgrad_audit::measures::leading::Leading;
use radgrad_audit::measures::measure::{Kind, Quantity, worse};
use radgrad_audit::measures::table::{FamilyTable, Table};

/// A row a family: the worst errors, alone and over the stated bound, then their medians and 99 %, the worst over the condition,
/// and outcomes. An exclamation mark stands at a figure beyond its gate.
pub(crate) fn families(table: &Table, gates: &Gates) -> Ranked {
    let mut ranked = Ranked::new(&[
        "family",
        "cases",
        "worst error\nvalue",
        "\ngradient",
        "worst / bound\nvalue",
        "\ngradient",
        "median\nvalue",
        "\ngradient",
        "99 %\nvalue",
        "\ngradient",
        "worst / condition\nvalue",
        "\ngradient",
        "not measured",
    ]);
    for (family, figures) in table.families() {
        let over_gate = figures.figures().iter().filter_map(|(quantity, distribution)| {
            Some(distribution.worst()?.value / gates.gate(*family, *quantity).unwrap_or(0.0))
        });
        ranked.add(over_gate.fold(0.0, worse), family_row(*family, figures, gates));
    }
    ranked
}

fn family_row(family: Family, table: &FamilyTable, gates: &Gates) -> Vec<String> {
    let not_measured: Vec<String> = table
        .counts()
        .iter()
        .filter(|(kind, _)| **kind != Kind::Measured)
        .map(|(kind, bin)| format!("{} {}", bin.count, kind.name()))
        .collect();
    let percentile = |quantity, percent| {
        let decade = table.figures().get(&quantity).and_then(|d| d.percentile(percent));
        decade.map_or_else(String::new, |d: Leading| d.decade().to_string())
    };
    let worst = |quantity| {
        let Some(worst) = table.figures().get(&quantity).and_then(|d| d.worst()) else { return String::new() };
        let beyond = gates.gate(family, quantity).is_none_or(|gate| worst.value > gate);
        format!("{}{:.1e}", if beyond { "! " } else { "" }, worst.value)
    };
    let quantities = [Quantity::Value, Quantity::Gradient];
    let mut row = vec![family.to_string(), table.cases().to_string()];
    row.extend(quantities.map(worst));
    row.extend([Quantity::ValueOverBound, Quantity::GradientOverBound].map(worst));
    row.extend(quantities.map(|quantity| percentile(quantity, 50)));
    row.extend(quantities.map(|quantity| percentile(quantity, 99)));
    row.extend([Quantity::ValueOverCondition, Quantity::GradientOverCondition].map(worst));
    row.push(not_measured.join("\n"));
    row
}

/// A row a slip: in how many cases it breaks the gate, and its worst errors.
pub(crate) fn mutants(rows: &[Mutant], gate: f64) -> Ranked {
    let mut ranked = Ranked::new(&["slip", "cases", "beyond the gate", "value worst", "gradient worst", "verdict"]);
    for row in rows {
        // The least noticed slip is the worst.
        let missed = 1.0 - row.beyond as f64 / row.cases.max(1) as f64;
        let cells = [
            row.name().to_owned(),
            row.cases.to_string(),
            row.beyond.to_string(),
            format!("{:.1e}", row.value),
            format!("{:.1e}", row.gradient),
            row.verdict(gate).to_owned(),
        ];
        ranked.add(if row.slip.is_some() { missed } else { 0.0 }, cells.to_vec());
    }
    ranked
}

/// A table whose rows have a rank, so that its worst row can stand for it.
#[derive(Debug)]
pub(crate) struct Ranked {
    pub(crate) table: Printed,
    titles: Vec<String>,
    worst: Option<(f64, Vec<String>)>,
}

impl Ranked {
    pub(crate) fn new(titles: &[&str]) -> Self {
        let titles: Vec<String> = titles.iter().map(|&title| title.to_owned()).collect();
        Self { table: with_header(&titles), titles, worst: None }
    }

    /// Adds a row; of equal ranks the first one stands for the table. NaN ranks highest.
    pub(crate) fn add(&mut self, rank: f64, cells: Vec<String>) {
        if self.worst.as_ref().is_none_or(|(worst, _)| rank.total_cmp(worst).is_gt()) {
            self.worst = Some((rank, cells.clone()));
        }
        self.table.add_row(cells);
    }

    /// The worst row, or all rows, no wider than the terminal.
    pub(crate) fn printed(self, all_rows: bool) -> String {
        let rows = self.table.row_count();
        match self.worst {
            Some((_, cells)) if !all_rows && rows > 1 => {
                let mut one = with_header(&self.titles);
                one.add_row(cells);
                format!("{}\n(the worst of {rows} rows; --tables prints all)", fitted(right_aligned(one)))
            }
            _ => fitted(right_aligned(self.table)),
        }
    }
}

/// Says how it ended.
pub(crate) fn ended(passed: bool) -> bool {
    println!("{}", if passed { "passed" } else { "FAILED" });
    passed
}

/// A bar of a run by cases.
pub(crate) fn style() -> ProgressStyle {
    let template = "{bar:40} {pos}/{len} cases, {per_sec}, {eta} left, {msg}";
    ProgressStyle::with_template(template).unwrap_or_else(|_| ProgressStyle::default_bar())
}

pub(crate) fn with_header<T: AsRef<str>>(titles: &[T]) -> Printed {
    let mut printed = Printed::new();
    printed.load_style(UTF8_FULL_CONDENSED).set_header(titles.iter().map(AsRef::as_ref));
    printed
}

/// Columns of a terminal that does not say how many it has.
const COLUMNS: usize = 100;

/// How many columns the terminal has, or `COLUMNS` says.
fn columns() -> usize {
    let said = std::env::var("COLUMNS").ok().and_then(|columns| columns.parse().ok());
    let terminal_width = || console::Term::stdout().size_checked().map(|(_, columns)| usize::from(columns));
    said.or_else(terminal_width).filter(|columns| *columns >= 40).unwrap_or(COLUMNS)
}

/// A table without the last columns that the terminal has no place for; the files have them all.
pub(crate) fn fitted(table: Printed) -> String {
    fitted_to(table, columns())
}

fn fitted_to(mut table: Printed, columns: usize) -> String {
    let count = table.column_count();
    let mut left_out = 0;
    loop {
        let text = table.to_string();
        let widest = text.lines().map(|line| line.chars().count()).max().unwrap_or(0);
        if widest <= columns || left_out + 2 >= count {
            let left_out_note = if left_out == 0 { String::new() } else { format!("\n({left_out} more columns in the files)") };
            return text + &left_out_note;
        }
        left_out += 1;
        if let Some(column) = table.column_mut(count - left_out) {
            column.set_constraint(ColumnConstraint::Hidden);
        }
    }
}

/// All columns but the first.
pub(crate) fn right_aligned(mut printed: Printed) -> Printed {
    for column in printed.column_iter_mut().skip(1) {
        column.set_cell_alignment(CellAlignment::Right);
    }
    printed
}

#[cfg(test)]
mod tests {
    use radgrad_audit::measures::run::Run;
    use radgrad_paper::appendix::Misprint;

    use super::*;

    #[test]
    fn tables_for_people_have_the_recorded_form() {
        let gates = Gates::from_toml(include_str!("../../data/gates.toml")).unwrap();
        let table = Run::of_each(3, &[Family::Generic, Family::EqualVertices], 1).table(|_| ());
        let row = |slip, beyond, value| Mutant { slip, cases: 10, beyond, value, gradient: 2e-12, worst: None };
        let rows = [row(None, 0, 1e-12), row(Some(Misprint::ALL[0]), 7, 0.25), row(Some(Misprint::ALL[1]), 0, 1e-12)];
        let [families, slips] = [families(&table, &gates), mutants(&rows, gates.appendix_a())];
        insta::assert_snapshot!(format!("{}\n{}", right_aligned(families.table), right_aligned(slips.table)));
    }

    #[test]
    fn the_worst_row_stands_for_a_table() {
        let ranked = |ranks: &[f64]| {
            let mut ranked = Ranked::new(&["family", "rank"]);
            ranks.iter().for_each(|rank| ranked.add(*rank, vec!["f".to_owned(), format!("<{rank}>")]));
            ranked
        };
        let short = ranked(&[0.5, 2.0, 1.0]).printed(false);
        assert!(short.contains("<2>") && !short.contains("<1>") && short.contains("3 rows"), "{short}");
        assert!(ranked(&[2.0, f64::NAN, 3.0]).printed(false).contains("<NaN>"));
        let whole = ranked(&[0.5, 2.0]).printed(true);
        assert!(whole.contains("<0.5>") && whole.contains("<2>") && !whole.contains("--tables"));
    }

    #[test]
    fn a_table_is_no_wider_than_the_terminal_and_says_what_is_left_out() {
        let mut table = with_header(&["family", "cases", "worst", "median"]);
        table.add_row(["generic", "1100", "1.2e-14", "1.1e-16"]);
        let whole = fitted_to(table.clone(), 100);
        assert!(whole.contains("1.1e-16") && !whole.contains("more columns"));
        let cut = fitted_to(table, 32);
        assert!(cut.contains("1.2e-14") && !cut.contains("1.1e-16") && cut.ends_with("(1 more columns in the files)"), "{cut}");
        assert!(cut.lines().all(|line| line.chars().count() <= 32));
    }
}
