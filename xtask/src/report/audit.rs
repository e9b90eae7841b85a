//! The files of a finished audit, read back: nothing of it is computed again.

use std::collections::BTreeMap;
use std::error::Error;
use std::path::{Path, PathBuf};

use serde::Deserialize;
use serde::de::DeserializeOwned;

/// The files of an audit.
#[derive(Debug)]
pub(super) struct Audit {
    /// `verify-run.csv`.
    pub(super) run: Fields,
    /// `bounds-run.csv`: of the same run, or of a larger campaign after it.
    pub(super) bounds_run: Fields,
    /// The violations, each with the command that shows it.
    pub(super) violations: Vec<Violated>,
    /// `figures.csv`.
    pub(super) figures: Vec<Figure>,
    /// `histogram.csv`.
    pub(super) histogram: Vec<Bin>,
    /// `outcomes.csv`.
    pub(super) outcomes: Vec<Outcomes>,
    /// `bounds.csv`.
    pub(super) bounds: Vec<Bounds>,
    /// `bounds-figures.csv`.
    pub(super) bounds_figures: Vec<Figure>,
    /// `mutants.csv`.
    pub(super) mutants: Vec<Mutant>,
    /// `comparison.csv`.
    pub(super) comparison: Vec<Fared>,
    /// `stability.csv`.
    pub(super) stability: Vec<Point>,
    /// `scenes-run.csv` and `scenes.csv`, unless the run was of families of cases alone.
    pub(super) scenes: Option<Scenes>,
    /// The files that were read.
    pub(super) files: Vec<PathBuf>,
}

/// The audit of whole scenes.
#[derive(Debug)]
pub(super) struct Scenes {
    pub(super) run: Fields,
    pub(super) rows: Vec<SceneRow>,
}

/// How the bounds of a command fared on the scenes of a family.
#[derive(Debug, Deserialize)]
pub(super) struct SceneRow {
    pub(super) family: String,
    pub(super) subject: String,
    pub(super) scenes: u64,
    pub(super) held: u64,
    pub(super) broken: u64,
    pub(super) rough: u64,
    pub(super) refused: u64,
    pub(super) median_bound_over_error: String,
    pub(super) median_estimate_over_error: String,
}

/// A record of fields.
#[derive(Debug)]
pub(super) struct Fields(BTreeMap<String, String>);

impl Fields {
    /// A field, empty if it is not there.
    pub(super) fn get(&self, field: &str) -> &str {
        self.0.get(field).map_or("", String::as_str)
    }

    /// A count with its thousands set apart; empty if it is not there.
    pub(super) fn count(&self, field: &str) -> String {
        thousands(self.get(field))
    }
}

/// `1234567` as `1,234,567`.
pub(super) fn thousands(digits: &str) -> String {
    let mut text = String::new();
    for (i, digit) in digits.chars().enumerate() {
        if i > 0 && (digits.len() - i).is_multiple_of(3) {
            text.push(',');
        }
        text.push(digit);
    }
    text
}

/// A row of a file of violations.
#[derive(Debug, Deserialize)]
pub(super) struct Violated {
    pub(super) violation: String,
    pub(super) command: String,
}

/// Median, 99 % and worst of a quantity of a family.
#[derive(Debug, Deserialize)]
pub(super) struct Figure {
    pub(super) family: String,
    pub(super) quantity: String,
    pub(super) median: String,
    pub(super) p99: String,
    pub(super) worst: String,
    pub(super) worst_case: String,
}

/// How many figures lie between two neighbours of 1, 2, 5, 10, ...
#[derive(Debug, Deserialize)]
pub(super) struct Bin {
    pub(super) family: String,
    pub(super) quantity: String,
    pub(super) from: f64,
    pub(super) to: f64,
    pub(super) count: u64,
}

/// How the cases of a family ended.
#[derive(Debug, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(super) struct Outcomes {
    pub(super) family: String,
    pub(super) cases: u64,
    pub(super) measured: u64,
    pub(super) refused: u64,
    pub(super) unanswered: u64,
    pub(super) non_finite: u64,
    pub(super) undetermined: u64,
}

/// The counts of the bounds campaign for a family.
#[derive(Debug, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(super) struct Bounds {
    pub(super) family: String,
    pub(super) cases: u64,
    pub(super) nonzero: u64,
    pub(super) broken: u64,
    pub(super) answers: u64,
    pub(super) by_quadrature: u64,
    pub(super) by_closed_form: u64,
    pub(super) by_double_double: u64,
    pub(super) by_arbitrary_precision: u64,
}

/// A slip planted in the second implementation.
#[derive(Debug, Deserialize)]
pub(super) struct Mutant {
    pub(super) slip: String,
    pub(super) verdict: String,
    pub(super) cases: u64,
    pub(super) beyond: u64,
    pub(super) value: String,
    pub(super) gradient: String,
}

/// How a contender fared with a quantity of a family.
#[derive(Debug, Deserialize)]
pub(super) struct Fared {
    pub(super) family: String,
    pub(super) contender: String,
    pub(super) quantity: String,
    pub(super) cases: u64,
    pub(super) median: String,
    pub(super) worst: String,
}

/// A point of a stability map.
#[derive(Debug, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(super) struct Point {
    pub(super) plane: String,
    pub(super) emission: String,
    pub(super) y: f64,
    pub(super) corrected_value: Option<f64>,
    pub(super) corrected_gradient: Option<f64>,
    pub(super) single_precision_value: Option<f64>,
    pub(super) closed_form_value: Option<f64>,
    pub(super) closed_form_gradient: Option<f64>,
    pub(super) certified_value: Option<f64>,
    pub(super) certified_gradient: Option<f64>,
    pub(super) value_bound: f64,
    pub(super) gradient_bound: f64,
    pub(super) rung: String,
}

impl Audit {
    /// Reads the folder that `cargo xtask verify` wrote.
    pub(super) fn read(folder: &Path) -> Result<Self, Box<dyn Error>> {
        let mut files = Vec::new();
        let mut register = |name: &str| {
            files.push(folder.join(name));
            folder.join(name)
        };
        let mut violations: Vec<Violated> = rows(&register("verify-violations.csv"))?;
        violations.extend(rows::<Violated>(&register("bounds-violations.csv"))?);
        let scenes = if folder.join("scenes-run.csv").exists() {
            violations.extend(rows::<Violated>(&register("scenes-violations.csv"))?);
            Some(Scenes { run: fields(&register("scenes-run.csv"))?, rows: rows(&register("scenes.csv"))? })
        } else {
            None
        };
        Ok(Self {
            run: fields(&register("verify-run.csv"))?,
            bounds_run: fields(&register("bounds-run.csv"))?,
            violations,
            figures: rows(&register("figures.csv"))?,
            histogram: rows(&register("histogram.csv"))?,
            outcomes: rows(&register("outcomes.csv"))?,
            bounds: rows(&register("bounds.csv"))?,
            bounds_figures: rows(&register("bounds-figures.csv"))?,
            mutants: rows(&register("mutants.csv"))?,
            comparison: rows(&register("comparison.csv"))?,
            stability: rows(&register("stability.csv"))?,
            scenes,
            files,
        })
    }

    /// Median, 99 % and worst of a quantity of a family.
    pub(super) fn figure(&self, family: &str, quantity: &str) -> Option<&Figure> {
        self.figures.iter().find(|figure| figure.family == family && figure.quantity == quantity)
    }

    /// The same in the bounds campaign.
    pub(super) fn bounds_figure(&self, family: &str, quantity: &str) -> Option<&Figure> {
        self.bounds_figures.iter().find(|figure| figure.family == family && figure.quantity == quantity)
    }
}

fn rows<T: DeserializeOwned>(path: &Path) -> Result<Vec<T>, Box<dyn Error>> {
    let missing = |error| format!("{}: {error}; `cargo xtask verify --quick` writes it", path.display());
    let mut reader = csv::Reader::from_path(path).map_err(missing)?;
    reader.deserialize().map(|row| row.map_err(|error| format!("{}: {error}", path.display()).into())).collect()
}

fn fields(path: &Path) -> Result<Fields, Box<dyn Error>> {
    Ok(Fields(rows::<(String, String)>(path)?.into_iter().collect()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn thousands_stand_apart() {
        assert_eq!(["", "7", "100", "1540", "10000000"].map(thousands), ["", "7", "100", "1,540", "10,000,000"]);
    }

    #[test]
    fn a_folder_without_an_audit_names_the_file_and_the_command() {
        let error = Audit::read(Path::new("no/such/folder")).unwrap_err().to_string();
        assert!(error.contains("verify-violations.csv") && error.contains("cargo xtask verify"), "{error}");
    }
}
