//! The diagrams of run time against error that `cargo xtask bench` leaves, taken in as they are.

use std::error::Error;
use std::fmt::Write;
use std::fs;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::svg::base64;
use crate::bench::regime::Regime;

/// A diagram as a picture of its own, so that its names and colours stay its own.
#[derive(Debug, Serialize)]
pub(super) struct Diagram {
    /// Address with the data in it.
    source: String,
    title: String,
    /// Alternative text.
    description: String,
    /// Its result, in short; nothing without a table.
    gist: String,
    file: String,
    /// The table beside it, where there is one.
    csv: Option<String>,
}

/// The diagrams of a folder in the order of the regimes, then of names, and the tables beside them; none if there is no such folder.
pub(super) fn read(folder: &Path) -> Result<(Vec<Diagram>, Vec<PathBuf>), Box<dyn Error>> {
    let mut files: Vec<PathBuf> = match fs::read_dir(folder) {
        Ok(entries) => entries.map(|entry| Ok(entry?.path())).collect::<Result<_, std::io::Error>>()?,
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => Vec::new(),
        Err(error) => return Err(format!("{}: {error}", folder.display()).into()),
    };
    let regime =
        |path: &PathBuf| Regime::ALL.iter().position(|regime| path.file_stem().is_some_and(|name| name == regime.name()));
    files.sort_by_key(|path| (regime(path).unwrap_or(Regime::ALL.len()), path.clone()));
    let with_extension = |extension: &str| -> Vec<PathBuf> {
        files.iter().filter(|path| path.extension().is_some_and(|e| e == extension)).cloned().collect()
    };
    let diagrams = with_extension("svg").iter().map(|path| diagram(path)).collect::<Result<_, _>>()?;
    Ok((diagrams, [with_extension("svg"), with_extension("csv")].concat()))
}

fn diagram(path: &Path) -> Result<Diagram, Box<dyn Error>> {
    let text = fs::read_to_string(path).map_err(|error| format!("{}: {error}", path.display()))?;
    let file = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    // The diagram's own title is its first text.
    let title = element(&text, "title").or_else(|| element(&text, "text")).unwrap_or_else(|| name.clone());
    let table = path.with_extension("csv");
    let csv = table.exists().then(|| format!("{name}.csv"));
    let gist = if csv.is_some() { told(&table)? } else { String::new() };
    let description = element(&text, "desc")
        .unwrap_or_else(|| format!("Relative error over the time of an answer, both logarithmic. {gist}").trim_end().to_owned());
    Ok(Diagram { source: format!("data:image/svg+xml;base64,{}", base64(text.as_bytes())), title, description, gist, file, csv })
}

/// A row of the table of a diagram.
#[derive(Debug, Deserialize)]
struct Row {
    emission: String,
    method: String,
    #[serde(rename = "value error worst")]
    value: f64,
    #[serde(rename = "gradient error worst")]
    gradient: f64,
    #[serde(rename = "ns median")]
    time: f64,
}

/// The result of a diagram, in short: how many methods, and the quickest to 12 digits of each emission.
fn told(table: &Path) -> Result<String, Box<dyn Error>> {
    let rows: Vec<Row> = csv::Reader::from_path(table)?.deserialize().collect::<Result<_, _>>()?;
    let mut methods: Vec<&str> = rows.iter().map(|row| row.method.as_str()).collect();
    methods.sort_unstable();
    methods.dedup();
    let mut text = format!("{} methods at {} settings.", methods.len(), rows.len());
    for emission in ["constant", "linear"] {
        let fine = rows.iter().filter(|row| row.emission == emission && row.value.max(row.gradient) <= 1e-12);
        if let Some(quickest) = fine.min_by(|a, b| a.time.total_cmp(&b.time)) {
            // Writing to a string cannot fail.
            let _ = write!(text, " Quickest to 1e-12, {emission} emission: {}, {:.0} ns.", quickest.method, quickest.time);
        }
    }
    Ok(text)
}

/// The text of the first element of a name.
fn element(text: &str, name: &str) -> Option<String> {
    let start = text.find(&format!("<{name}"))?;
    let inside = text[start..].split_once('>')?.1;
    let text = inside.split_once(&format!("</{name}>"))?.0.trim();
    (!text.is_empty()).then(|| {
        text.replace("&lt;", "<").replace("&gt;", ">").replace("&quot;", "\"").replace("&apos;", "'").replace("&amp;", "&")
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_diagram_names_itself_and_no_folder_is_no_diagram() {
        assert_eq!(element("<svg><title id=\"t\">far &amp; near</title></svg>", "title").as_deref(), Some("far & near"));
        assert_eq!(
            element("<svg><text x=\"0\">the emitter&apos;s plane</text></svg>", "text").as_deref(),
            Some("the emitter's plane")
        );
        assert_eq!(element("<svg></svg>", "desc"), None);
        assert!(read(Path::new("no/such/folder")).unwrap().0.is_empty());
    }
}
