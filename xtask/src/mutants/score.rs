//! What became of the drawn faults: the score, its limits, and what is known of survivors.

use std::collections::{BTreeSet, HashMap};
use std::error::Error;
use std::fmt;
use std::fs;
use std::path::Path;

use comfy_table::Table as Printed;
use serde::{Deserialize, Serialize};
use statrs::distribution::{Beta, ContinuousCDF};

use super::draw::{Drawn, Source};
use super::run::Seen;
use crate::files;
use crate::summary::{fitted, with_header};

/// Of the faults that are not harmless so many are noticed at least, of 600 drawn with seed 20261127: this may rise, and not fall.
pub(crate) const NOTICED: f64 = 0.75;

/// The limits of a share hold it in 19 of 20 samples.
const DOUBT: f64 = 0.05;

/// `data/mutants.toml`.
#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Known {
    /// Faults of which nothing is wrong.
    #[serde(default)]
    harmless: Vec<KnownFault>,
    /// Faults with which something is wrong that no check comes to.
    #[serde(default)]
    survivor: Vec<KnownFault>,
}

/// A fault by its place: wherever the line stands now.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct KnownFault {
    file: String,
    /// The text of the line.
    line: String,
    /// The text of the place.
    place: String,
    operators: Vec<String>,
    why: String,
}

impl Known {
    pub(crate) fn read(file: &Path) -> Result<Self, Box<dyn Error>> {
        let text = fs::read_to_string(file).map_err(|error| format!("{}: {error}", file.display()))?;
        Ok(toml::from_str(&text)?)
    }
}

/// Why nothing notices a fault, if it is one of some.
fn why<'a>(known: &'a [KnownFault], drawn: &Drawn, sources: &[Source]) -> Option<&'a str> {
    known.iter().find(|known| known.is(drawn, sources)).map(|known| known.why.as_str())
}

impl KnownFault {
    fn is(&self, drawn: &Drawn, sources: &[Source]) -> bool {
        let (path, (_, line), text) = (&sources[drawn.file].path, drawn.line(sources), drawn.text(sources));
        self.file == *path
            && self.line == line
            && self.place == text
            && self.operators.iter().any(|operator| operator == drawn.fault.operator)
    }
}

/// What became of a fault, the best first.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum Verdict {
    ByTruth,
    ByRecord,
    Harmless,
    Unnoticed,
    NeverDiffers,
    Unreached,
}

impl Verdict {
    pub(crate) const fn name(self) -> &'static str {
        match self {
            Self::ByTruth => "by truth",
            Self::ByRecord => "by the record",
            Self::Harmless => "harmless",
            Self::Unnoticed => "unnoticed",
            Self::NeverDiffers => "never differs",
            Self::Unreached => "unreached",
        }
    }
}

/// A fault and what became of it.
#[derive(Debug, Serialize)]
pub(crate) struct Row {
    /// File and line.
    pub(crate) place: String,
    pub(crate) operator: &'static str,
    /// What it stands in the place of.
    pub(crate) text: String,
    pub(crate) line: String,
    pub(crate) verdict: Verdict,
    /// What told, or why nothing does.
    pub(crate) by: String,
    pub(crate) seconds: f64,
}

impl Row {
    /// A harmless fault that is noticed is none: then what is known is wrong.
    pub(crate) fn new(drawn: &Drawn, sources: &[Source], seen: Seen, seconds: f64, known: &Known) -> Self {
        let unnoticed = || why(&known.survivor, drawn, sources).unwrap_or_default().to_owned();
        let (verdict, by) = match (seen, why(&known.harmless, drawn, sources)) {
            (Seen::Truth { check, what }, _) => (Verdict::ByTruth, format!("{check}: {what}")),
            (Seen::Record { check, what }, _) => (Verdict::ByRecord, format!("{check}: {what}")),
            (_, Some(why)) => (Verdict::Harmless, why.to_owned()),
            (Seen::Nothing, None) => (Verdict::Unnoticed, unnoticed()),
            (Seen::NeverDiffers, None) => (Verdict::NeverDiffers, unnoticed()),
            (Seen::Unreached, None) => (Verdict::Unreached, unnoticed()),
        };
        let (line, text) = drawn.line(sources);
        Self {
            place: format!("{}:{line}", sources[drawn.file].path),
            operator: drawn.fault.operator,
            text: drawn.text(sources),
            line: text.to_owned(),
            verdict,
            by,
            seconds: (100.0 * seconds).round() / 100.0,
        }
    }

    fn is_noticed(&self) -> bool {
        matches!(self.verdict, Verdict::ByTruth | Verdict::ByRecord)
    }
}

/// A share of the faults that are not harmless, with its limits.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub(crate) struct Share {
    pub(crate) share: f64,
    pub(crate) at_least: f64,
    pub(crate) at_most: f64,
}

impl Share {
    /// Clopper and Pearson's limits (Biometrika 26, 1934).
    pub(crate) fn new(count: usize, total: usize) -> Self {
        let (k, n) = (count as f64, total as f64);
        let quantile = |a: f64, b: f64, p: f64| Beta::new(a, b).map_or(f64::NAN, |beta| beta.inverse_cdf(p));
        Self {
            share: rounded(k / n),
            at_least: rounded(if count == 0 { 0.0 } else { quantile(k, n - k + 1.0, 0.5 * DOUBT) }),
            at_most: rounded(if count == total { 1.0 } else { quantile(k + 1.0, n - k, 1.0 - 0.5 * DOUBT) }),
        }
    }
}

impl fmt::Display for Share {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { share, at_least, at_most } = self;
        write!(f, "{:.1} % ({:.1} to {:.1})", 100.0 * share, 100.0 * at_least, 100.0 * at_most)
    }
}

fn rounded(share: f64) -> f64 {
    (1e4 * share).round() / 1e4
}

/// The object that `--summary` prints.
#[derive(Debug, Serialize)]
pub(crate) struct Summary<'a> {
    pub(crate) drawn: usize,
    pub(crate) by_truth: usize,
    pub(crate) by_record: usize,
    /// With those below.
    pub(crate) unnoticed: usize,
    /// No check comes to where it gives another value.
    pub(crate) never_differs: usize,
    /// No check comes to it.
    pub(crate) unreached: usize,
    pub(crate) harmless: usize,
    pub(crate) seed: u64,
    /// Drawn before these, and not compiled.
    pub(crate) refused: usize,
    pub(crate) noticed_share: Share,
    pub(crate) truth_share: Share,
    pub(crate) seconds: f64,
    pub(crate) survivors: Vec<&'a Row>,
}

impl<'a> Summary<'a> {
    pub(crate) fn new(rows: &'a [Row], [seed, refused]: [u64; 2], seconds: f64) -> Self {
        let count = |verdict| rows.iter().filter(|row| row.verdict == verdict).count();
        let [by_truth, by_record, harmless] = [Verdict::ByTruth, Verdict::ByRecord, Verdict::Harmless].map(count);
        let counted = rows.len() - harmless;
        Self {
            drawn: rows.len(),
            by_truth,
            by_record,
            unnoticed: counted - by_truth - by_record,
            never_differs: count(Verdict::NeverDiffers),
            unreached: count(Verdict::Unreached),
            harmless,
            seed,
            refused: usize::try_from(refused).unwrap_or(usize::MAX),
            noticed_share: Share::new(by_truth + by_record, counted),
            truth_share: Share::new(by_truth, counted),
            seconds: seconds.round(),
            survivors: rows.iter().filter(|row| !row.is_noticed()).collect(),
        }
    }

    /// Whether so few are noticed that it is no chance.
    pub(crate) fn is_too_low(&self) -> bool {
        self.noticed_share.at_most < NOTICED
    }
}

/// For people.
pub(crate) fn printed(summary: &Summary<'_>) -> String {
    let mut table: Printed = with_header(&["place", "operator", "verdict", "in", "why"]);
    for row in &summary.survivors {
        table.add_row([&row.place, row.operator, row.verdict.name(), &row.line, &row.by]);
    }
    let Summary { drawn, by_truth, by_record, unnoticed, never_differs, unreached, harmless, seed, seconds, .. } = summary;
    format!(
        "{}\n{drawn} faults drawn with seed {seed}: {by_truth} noticed by truth, {by_record} by the record alone, {unnoticed} not \
         ({unreached} of them where no check comes, {never_differs} where it gives no other value), {harmless} harmless; {seconds:.0} s\n\
         of those that are not harmless {} are noticed, {} by truth",
        fitted(table),
        summary.noticed_share,
        summary.truth_share,
    )
}

/// All rows as CSV; `data/tables/faults.csv` has those of a large sample for the report, with the lines of survivors and the checks that told of
/// the others.
pub(crate) fn write(rows: &[Row], seed: u64, file: &Path) -> Result<(), Box<dyn Error>> {
    files::table(file, |table| {
        table.write_record(["seed", "place", "operator", "text", "line", "verdict", "by", "seconds"])?;
        for row in rows {
            let [seed, seconds] = [seed.to_string(), row.seconds.to_string()];
            table.write_record([&seed, &row.place, row.operator, &row.text, &row.line, row.verdict.name(), &row.by, &seconds])?;
        }
        Ok(())
    })
}

/// File, operator and line, by which a fault is recognised in a table of a commit before.
pub(crate) fn label(drawn: &Drawn, sources: &[Source]) -> [String; 3] {
    [&sources[drawn.file].path, drawn.fault.operator, drawn.line(sources).1].map(str::to_owned)
}

/// Labels of those faults of a table that truth did not notice, in files that begin with one of some paths, with a comma between them.
pub(crate) fn survivors(table: &Path, prefixes: &str) -> Result<BTreeSet<[String; 3]>, Box<dyn Error>> {
    let mut labels = BTreeSet::new();
    for row in csv::Reader::from_path(table)?.deserialize() {
        let row: HashMap<String, String> = row?;
        let is_asked =
            |path: &str| row["verdict"] != Verdict::ByTruth.name() && prefixes.split(',').any(|prefix| path.starts_with(prefix));
        if let Some((path, _)) = row["place"].rsplit_once(':').filter(|(path, _)| is_asked(path)) {
            labels.insert([path, &row["operator"], &row["line"]].map(str::to_owned));
        }
    }
    Ok(labels)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::files::in_workspace;
    use crate::mutants::places;

    #[test]
    fn limits_are_those_of_the_binomial_distribution() {
        // Of 9 in 10 they are known to be 0.5550 and 0.9975.
        assert_eq!(Share::new(9, 10), Share { share: 0.9, at_least: 0.555, at_most: 0.9975 });
        assert_eq!((Share::new(0, 10).at_least, Share::new(10, 10).at_most), (0.0, 1.0));
    }

    #[test]
    fn a_summary_counts_what_becomes_of_each_and_lists_survivors() {
        let text = "fn f(a: f64) -> f64 {\n    2.0 * a\n}\n";
        let sources = [Source { path: "a.rs".to_owned(), text: text.to_owned() }];
        let fault = places::faults(text).unwrap().into_iter().find(|fault| fault.operator == "halved").unwrap();
        let drawn = Drawn { file: 0, fault };
        let known = "[[harmless]]\nfile = \"a.rs\"\nline = \"2.0 * a\"\nplace = \"2.0\"\noperators = [\"halved\"]\nwhy = \"No one asks.\"";
        let (none, known): (Known, Known) = (Known::default(), toml::from_str(known).unwrap());
        let told = |by: fn(&'static str, String) -> Seen| by("merge", "it is off".to_owned());
        let truth = told(|check, what| Seen::Truth { check, what });
        let record = told(|check, what| Seen::Record { check, what });
        let row = |seen, known| Row::new(&drawn, &sources, seen, 0.25, known);
        let rows = [
            row(truth, &known),
            row(record, &none),
            row(Seen::Nothing, &known),
            row(Seen::Nothing, &none),
            row(Seen::NeverDiffers, &none),
            row(Seen::Unreached, &none),
        ];
        let summary = Summary::new(&rows, [7, 1], 1.5);
        insta::assert_snapshot!(format!("{}\n{}", serde_json::to_string_pretty(&summary).unwrap(), printed(&summary)));
    }

    #[test]
    fn what_is_known_of_is_still_there_and_has_a_reason() {
        let known = Known::read(&in_workspace("data/mutants.toml")).unwrap();
        let mut gone = Vec::new();
        for known in known.harmless.iter().chain(&known.survivor) {
            let text = fs::read_to_string(in_workspace(&known.file)).unwrap();
            let faults = places::faults(&text).unwrap();
            let sources = [Source { path: known.file.clone(), text }];
            for operator in &known.operators {
                let is_it = |fault: &places::Fault| {
                    fault.operator == operator && known.is(&Drawn { file: 0, fault: fault.clone() }, &sources)
                };
                if !faults.iter().any(is_it) {
                    gone.push(format!("{}: {}: {operator}", known.file, known.line));
                }
            }
            assert!(known.why.len() > 40, "{}", known.line);
        }
        assert!(gone.is_empty(), "{gone:#?}");
    }
}
