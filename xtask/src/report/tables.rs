//! The tables of the page, each from one file of the audit.

use std::collections::BTreeSet;
use std::error::Error;

use radgrad_audit::cases::family::Family;
use radgrad_audit::checks::mutants::MARGIN;
use radgrad_audit::comparison::contender::Contender;
use radgrad_paper::appendix;
use serde::Deserialize;

use super::audit::{Audit, Figure, thousands};
use super::errata::Misprint;
use super::histogram::{self, value};
use super::rungs;
use super::table::{Cell, Table};
use crate::mutants::score::Verdict;

/// A number of a file, sorted as the number that it is.
fn figure(text: &str) -> Cell {
    let key = value(text);
    if key.is_nan() { Cell::from(text) } else { Cell::from(text).by(key) }
}

fn described(family: &str) -> &'static str {
    family.parse::<Family>().map_or("", Family::description)
}

pub(super) fn families(audit: &Audit) -> Table {
    let titles = [
        "family",
        "~what its cases are",
        "#cases",
        "#value median",
        "#99 %",
        "#worst",
        "#gradient median",
        "#99 %",
        "#worst",
        "#value / bound",
        "#gradient / bound",
        "worst case",
    ];
    let mut table = Table::new(
        "Relative errors by family, and the largest error over the bound stated with it; cargo xtask replay NAME shows a case",
        &["figures.csv", "outcomes.csv"],
        &titles,
    );
    for row in &audit.outcomes {
        let figure_of =
            |quantity: &str, field: fn(&Figure) -> &str| figure(audit.figure(&row.family, quantity).map_or("", field));
        let ended = [
            (row.refused, "refused"),
            (row.unanswered, "unanswered"),
            (row.non_finite, "not finite"),
            (row.undetermined, "undetermined"),
        ];
        let ended: Vec<String> =
            ended.iter().filter(|(count, _)| *count > 0).map(|(count, how)| format!("{count} {how}")).collect();
        let all_measured = row.measured == row.cases;
        let what = if all_measured {
            described(&row.family).to_owned()
        } else {
            format!("{} ({})", described(&row.family), ended.join(", "))
        };
        let mut cells = vec![Cell::code(&row.family), Cell::from(&what), Cell::from(row.cases)];
        for quantity in ["value", "gradient"] {
            cells.extend([
                figure_of(quantity, |f| &f.median),
                figure_of(quantity, |f| &f.p99),
                figure_of(quantity, |f| &f.worst),
            ]);
        }
        cells.extend(["value-over-bound", "gradient-over-bound"].map(|quantity| figure_of(quantity, |f| &f.worst)));
        cells.push(histogram::worst(audit, &row.family).map_or_else(|| Cell::from(""), |figure| Cell::code(&figure.worst_case)));
        table.push(cells);
    }
    table
}

pub(super) fn comparison(audit: &Audit, quantity: &str, what: &str) -> Table {
    let mut titles = vec!["family", "#cases"];
    titles.extend(["#printed, median", "#worst", "#corrected, median", "#worst"]);
    if quantity == "value" {
        titles.extend(["#fit, median", "#worst"]);
    }
    titles.extend(["#closed form, median", "#worst", "#certified, median", "#worst"]);
    let mut table = Table::new(&format!("{what}: relative errors of each way on the same cases"), &["comparison.csv"], &titles);
    let mut families: Vec<&str> = audit.comparison.iter().map(|row| row.family.as_str()).collect();
    families.dedup();
    for family in families {
        let fared = |contender: Contender| {
            audit.comparison.iter().find(|r| r.family == family && r.quantity == quantity && r.contender == contender.name())
        };
        let cases = fared(Contender::Certified).map_or(0, |row| row.cases);
        let mut cells = vec![Cell::code(family), Cell::from(cases)];
        for contender in Contender::ALL {
            if contender == Contender::SinglePrecision && quantity != "value" {
                continue;
            }
            cells.extend(
                fared(contender).map_or_else(|| ["–"; 2].map(Cell::from), |row| [figure(&row.median), figure(&row.worst)]),
            );
        }
        table.push(cells);
    }
    table
}

pub(super) fn errata(misprints: &[Misprint]) -> Table {
    let titles = ["~place in the paper", "name", "~printed", "~right", "harm to the radiosity", "harm to the gradient"];
    let mut table =
        Table::new("The paper's misprints, and the relative error that each causes by itself", &["errata.csv"], &titles);
    for Misprint { place, name, printed, right, harm } in misprints {
        let harm = harm.each_ref().map(|harm| {
            let largest = harm.rsplit(' ').nth(1).and_then(|percent| percent.parse().ok());
            let text = if harm.is_empty() { "none" } else { harm };
            Cell::from(text).by(largest.unwrap_or(0.0))
        });
        table.push([Cell::from(place), Cell::code(name), Cell::code(printed), Cell::code(right)].into_iter().chain(harm));
    }
    table
}

pub(super) fn mutants(audit: &Audit) -> Table {
    let titles = ["slip", "~what is wrong", "#cases", "#beyond the gate", "#value, worst", "#gradient, worst", "verdict"];
    let caption = format!("Slips planted in the second implementation; each must be beyond the gate by a factor of {MARGIN:.0}");
    let mut table = Table::new(&caption, &["mutants.csv"], &titles);
    for row in &audit.mutants {
        let description = appendix::Misprint::ALL
            .iter()
            .find(|slip| slip.name() == row.slip)
            .map_or("the corrected form, as it is", |slip| slip.description());
        let decade = |text: &str| Cell::from(text).by(value(text.trim_start_matches('<')));
        table.push([
            Cell::code(&row.slip),
            Cell::from(description),
            Cell::from(row.cases),
            Cell::from(row.beyond),
            decade(&row.value),
            decade(&row.gradient),
            Cell::from(&row.verdict),
        ]);
    }
    table
}

pub(super) fn bounds(audit: &Audit) -> Table {
    let titles = [
        "family",
        "#cases",
        "#answers",
        "#broken",
        "#largest error / bound, value",
        "#gradient",
        "#median error / bound, value",
        "#gradient",
        "#ns, Gauss rule",
        "#closed form",
        "#double-double",
        "#more bits",
    ];
    let caption =
        "Errors over stated bounds (1 would be a broken bound), and the median time of an answer by the rung that gave it";
    let mut table = Table::new(caption, &["bounds-figures.csv", "bounds.csv"], &titles);
    for row in audit.bounds.iter().filter(|row| row.nonzero > 0) {
        let figure_of =
            |quantity: &str, field: fn(&Figure) -> &str| audit.bounds_figure(&row.family, quantity).map_or("", field).to_owned();
        let times = rungs::RUNGS.map(|(rung, _)| {
            let median = value(&figure_of(&format!("time-{rung}"), |f| &f.median));
            if median.is_nan() { Cell::from("–") } else { Cell::from(&thousands(&format!("{median:.0}"))).by(median) }
        });
        let mut cells = vec![Cell::code(&row.family), Cell::from(row.cases), Cell::from(row.answers), Cell::from(row.broken)];
        cells.extend(["value-over-bound", "gradient-over-bound"].map(|quantity| figure(&figure_of(quantity, |f| &f.worst))));
        cells.extend(["value-tightness", "gradient-tightness"].map(|quantity| figure(&figure_of(quantity, |f| &f.median))));
        cells.extend(times);
        table.push(cells);
    }
    table
}

/// The bounds of whole scenes, by family and command; empty where none were audited.
pub(super) fn scenes(audit: &Audit) -> Table {
    let titles = [
        "family",
        "command",
        "#scenes",
        "#bounds held",
        "#broken",
        "#truth too rough",
        "#refused",
        "#median bound / error",
        "#median estimate / error",
    ];
    let caption = "Bounds of whole scenes against random walks, enclosures and exact solutions; where the truth is less sharp than the \
                   answer, its own width stands for the error, and a median below 1 says no more than that";
    let mut table = Table::new(caption, &["scenes.csv"], &titles);
    for row in audit.scenes.iter().flat_map(|scenes| &scenes.rows) {
        let counts = [row.scenes, row.held, row.broken, row.rough, row.refused].map(Cell::from);
        let medians = [&row.median_bound_over_error, &row.median_estimate_over_error];
        let medians = medians.map(|text| if text.is_empty() { Cell::from("–") } else { figure(text) });
        table.push([Cell::from(&row.family), Cell::code(&row.subject)].into_iter().chain(counts).chain(medians));
    }
    table
}

/// A row of `data/tables/search.csv`.
#[derive(Debug, Deserialize)]
pub(super) struct Searched {
    rung: String,
    emission: String,
    sight: String,
    quantity: String,
    tried: u64,
    worst: String,
    ask: String,
    why_little: String,
}

/// The rows of the search.
pub(super) fn searched(text: &str) -> Result<Vec<Searched>, Box<dyn Error>> {
    Ok(csv::Reader::from_reader(text.as_bytes()).deserialize().collect::<Result<_, _>>()?)
}

/// The largest error over bound that a search came to, by rung and quantity.
pub(super) fn closest(searched: &[Searched]) -> Table {
    let titles = ["rung", "#radiosity", "#gradient"];
    let caption = "The largest error over its bound that a search found, by the rung of the ladder that answered; 1 would be a bound \
                   that is exactly used up, more a broken one";
    let mut table = Table::new(caption, &["search.csv"], &titles);
    let mut rungs: Vec<&str> = searched.iter().map(|row| row.rung.as_str()).collect();
    rungs.dedup();
    for rung in rungs {
        let worst = |quantity: &str| {
            let chosen = searched.iter().filter(|row| row.rung == rung && row.quantity == quantity);
            let worst = chosen.max_by(|a, b| value(&a.worst).total_cmp(&value(&b.worst)));
            worst.map_or_else(|| Cell::from("–"), |row| figure(&row.worst))
        };
        table.push([Cell::code(rung), worst("value"), worst("gradient")]);
    }
    table
}

/// A drawn fault that `cargo xtask mutants` switched on, and its outcome.
#[derive(Debug, Deserialize)]
pub(super) struct Fault {
    seed: u64,
    place: String,
    operator: String,
    line: String,
    verdict: String,
    by: String,
}

/// The rows of a sample of faults.
pub(super) fn faults(text: &str) -> Result<Vec<Fault>, Box<dyn Error>> {
    Ok(csv::Reader::from_reader(text.as_bytes()).deserialize().collect::<Result<_, _>>()?)
}

/// How many are noticed: no estimate of another sample, since checks were written for some of them.
pub(super) fn faults_told(faults: &[Fault]) -> String {
    let count = |verdict: Verdict| faults.iter().filter(|fault| fault.verdict == verdict.name()).count();
    let [truth, record, harmless] = [Verdict::ByTruth, Verdict::ByRecord, Verdict::Harmless].map(count);
    let share = |count: usize| 100.0 * count as f64 / (faults.len() - harmless) as f64;
    let seeds: BTreeSet<u64> = faults.iter().map(|fault| fault.seed).collect();
    let seeds: Vec<String> = seeds.iter().map(u64::to_string).collect();
    format!(
        "{} faults were drawn with seed {}; {harmless} of them are harmless. Of the others {:.1} % are noticed, and {:.1} % by truth; \
         the rest of those noticed differ from what was recorded. We wrote checks for some of them after the draw, so that another sample has a lower \
         share, as the guide says.",
        faults.len(),
        seeds.join(", "),
        share(truth + record),
        share(truth),
    )
}

/// Those that nothing noticed.
pub(super) fn survivors(faults: &[Fault]) -> Table {
    let caption = "Drawn faults that no check noticed: the place, the fault, and the line that it stands in";
    let mut table = Table::new(caption, &["faults.csv"], &["place", "fault", "verdict", "line", "~why nothing tells"]);
    let noticed = [Verdict::ByTruth, Verdict::ByRecord].map(Verdict::name);
    for fault in faults.iter().filter(|fault| !noticed.contains(&fault.verdict.as_str())) {
        let Fault { place, operator, line, verdict, by, .. } = fault;
        table.push([Cell::code(place), Cell::from(operator), Cell::from(verdict), Cell::code(line), Cell::from(by)]);
    }
    table
}

/// The same by all that a bound is of.
pub(super) fn search(searched: &[Searched]) -> Table {
    let titles = ["rung", "emission", "sight", "quantity", "#tried", "#worst error / bound", "asked as", "~why it is small"];
    let caption = "The largest error over its bound that a search came to, which changes the worst cases found a little and keeps what \
                   is worse; cargo xtask verify --bounds goes on from there";
    let mut table = Table::new(caption, &["search.csv"], &titles);
    for Searched { rung, emission, sight, quantity, tried, worst, ask, why_little } in searched {
        let texts = [rung, emission, sight, quantity].map(Cell::from);
        let others = [Cell::from(*tried), figure(worst), Cell::code(ask), Cell::from(why_little)];
        table.push(texts.into_iter().chain(others));
    }
    table
}
