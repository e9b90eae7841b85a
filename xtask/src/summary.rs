//! What a run found, as tables for people.

use comfy_table::presets::UTF8_FULL_CONDENSED;
use comfy_table::{CellAlignment, Table as Printed};
use radgrad_audit::family::Family;
use radgrad_audit::gates::Gates;
use radgrad_audit::leading::Leading;
use radgrad_audit::measure::{Kind, Quantity};
use radgrad_audit::mutants::Mutant;
use radgrad_audit::table::{FamilyTable, Table};

/// A row a family: outcomes, then median, 99 % and worst of the errors with the worst case of the gradient, then the worst over
/// the condition and over the stated bound. An exclamation mark stands at what is beyond its gate.
pub(crate) fn families(table: &Table, gates: &Gates) -> Printed {
    let mut printed = with_header(&[
        "family",
        "cases",
        "not measured",
        "value\nmedian",
        "\n99 %",
        "\nworst",
        "gradient\nmedian",
        "\n99 %",
        "\nworst",
        "worst / condition\nvalue",
        "\ngradient",
        "worst / bound\nvalue",
        "\ngradient",
    ]);
    for (family, figures) in table.families() {
        printed.add_row(family_row(*family, figures, gates));
    }
    right_aligned(printed)
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
    let mut row = vec![family.to_string(), table.cases().to_string(), not_measured.join("\n")];
    for quantity in [Quantity::Value, Quantity::Gradient] {
        row.extend([percentile(quantity, 50), percentile(quantity, 99), worst(quantity)]);
    }
    row.extend([
        worst(Quantity::ValueOverCondition),
        worst(Quantity::GradientOverCondition),
        worst(Quantity::ValueOverBound),
        worst(Quantity::GradientOverBound),
    ]);
    row
}

/// A row a slip: in how many cases it breaks the gate, and its worst errors.
pub(crate) fn mutants(rows: &[Mutant], gate: f64) -> Printed {
    let mut printed = with_header(&["slip", "cases", "beyond the gate", "value worst", "gradient worst", "verdict"]);
    for row in rows {
        printed.add_row([
            row.name().to_owned(),
            row.cases.to_string(),
            row.beyond.to_string(),
            format!("{:.1e}", row.value),
            format!("{:.1e}", row.gradient),
            row.verdict(gate).to_owned(),
        ]);
    }
    right_aligned(printed)
}

pub(crate) fn with_header(titles: &[&str]) -> Printed {
    let mut printed = Printed::new();
    printed.load_style(UTF8_FULL_CONDENSED).set_header(titles.to_vec());
    printed
}

/// All columns but the first.
pub(crate) fn right_aligned(mut printed: Printed) -> Printed {
    for column in printed.column_iter_mut().skip(1) {
        column.set_cell_alignment(CellAlignment::Right);
    }
    printed
}
