//! The search for the largest error over bound that goes with the bounds campaign, and its table.

use std::error::Error;
use std::fs;
use std::path::Path;

use indicatif::ProgressBar;
use radgrad_audit::bounds::search::{Search, Worst};
use radgrad_audit::bounds::witness::{self, Place};

use crate::files::{self, in_workspace};
use crate::record::Record;
use crate::request::Arguments;
use crate::summary::{fitted, right_aligned, style, with_header};

/// Rounds of the search, and of the quick one.
const ROUNDS: [u64; 2] = [400, 40];

/// A bound whose worst is below this says little.
const LITTLE: f64 = 0.05;

/// Climbs from the recorded witnesses, prints and writes its results. Whether no bound was broken.
pub(super) fn run(arguments: &Arguments, out: &Path) -> Result<bool, Box<dyn Error>> {
    let mut search = Search::from_witnesses(&witness::read_all(&in_workspace("data/worst"))?);
    let rounds = ROUNDS[usize::from(arguments.quick || arguments.cases.is_some())];
    let bar = ProgressBar::new(rounds);
    bar.set_style(style());
    for round in 0..rounds {
        search.climb(arguments.seed, round);
        bar.inc(1);
    }
    bar.finish_and_clear();
    let reasons = reasons()?;
    println!("the largest error over bound that a search of {} cases came to\n{}", search.asked, printed(&search));
    write(&search, &reasons, out)?;
    let mut record = Record::new("search", arguments.seed, search.asked);
    record.note("places", search.places.len());
    let replay = |ask| format!("cases of {} asked as {ask}", out.join("worst.jsonl").display());
    for (place, Worst { worst, .. }) in &search.places {
        let Some(worst) = worst.first() else { continue };
        if worst.ratio > 1.0 {
            record.violated(format_args!("search: {place}: broken by a factor of {:.3}", worst.ratio), &replay(worst.ask));
        } else if worst.ratio < LITTLE && reason(&reasons, place).is_none() {
            record.violated(
                format_args!(
                    "search: {place}: the worst found is {:.3} of the bound, and data/worst/reasons.toml does not say why",
                    worst.ratio
                ),
                &replay(worst.ask),
            );
        }
    }
    for (ask, case, fault) in &search.faults {
        record.violated(format_args!("search: {fault}"), &format!("{ask}: {}", serde_json::to_string(case)?));
    }
    record.write(out)
}

type Reasons = std::collections::BTreeMap<String, String>;

/// Why bounds say little, by the beginning of their places' names.
fn reasons() -> Result<Reasons, Box<dyn Error>> {
    let path = in_workspace("data/worst/reasons.toml");
    let text = fs::read_to_string(&path).map_err(|error| format!("{}: {error}", path.display()))?;
    Ok(toml::from_str(&text)?)
}

/// That of the longest beginning.
fn reason<'a>(reasons: &'a Reasons, place: &Place) -> Option<&'a str> {
    let name = place.to_string();
    let matching = reasons.iter().filter(|(beginning, _)| name.starts_with(beginning.as_str()));
    matching.max_by_key(|(beginning, _)| beginning.len()).map(|(_, reason)| reason.as_str())
}

fn printed(search: &Search) -> String {
    let mut printed = with_header(&["rung", "emission", "sight", "quantity", "worst", "tried", "asked as"]);
    for (place, Worst { tried, worst }) in &search.places {
        let quantity = place.to_string().rsplit(' ').next().unwrap_or("").to_owned();
        let ratio = worst.first().map_or(0.0, |witness| witness.ratio);
        let mark = if ratio < LITTLE { "! " } else { "" };
        printed.add_row([
            place.by.name().to_owned(),
            place.emission.name().to_owned(),
            place.sight.name().to_owned(),
            quantity,
            format!("{mark}{ratio:.3}"),
            tried.to_string(),
            worst.first().map_or_else(String::new, |witness| witness.ask.to_string()),
        ]);
    }
    fitted(right_aligned(printed))
}

/// `search.csv`, and `worst.jsonl` with the two worst cases of each place: `data/worst/bounds.jsonl` is a copy of it.
fn write(search: &Search, reasons: &Reasons, out: &Path) -> Result<(), Box<dyn Error>> {
    let mut lines = String::new();
    files::table(&out.join("search.csv"), |table| {
        table.write_record(["rung", "emission", "sight", "quantity", "tried", "worst", "ask", "why_little"])?;
        for (place, Worst { tried, worst }) in &search.places {
            let name = place.to_string();
            let ratio = worst.first().map_or(0.0, |witness| witness.ratio);
            let why = if ratio < LITTLE { reason(reasons, place).unwrap_or("") } else { "" };
            let ask = worst.first().map_or_else(String::new, |witness| witness.ask.to_string());
            let parts: Vec<&str> = name.split(' ').collect();
            let (tried, ratio) = (tried.to_string(), format!("{ratio:.3}"));
            table.write_record(parts.into_iter().chain([tried.as_str(), &ratio, &ask, why]))?;
            for witness in worst.iter().take(2) {
                lines += &serde_json::to_string(witness)?;
                lines.push('\n');
            }
        }
        Ok(())
    })?;
    files::write(&out.join("worst.jsonl"), lines)?;
    Ok(())
}
