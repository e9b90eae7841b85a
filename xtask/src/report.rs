//! `cargo xtask report`: one page, `target/report/index.html`, from the files of a finished audit.
//!
//! The page needs no network and nothing beside it to be read; the files that its numbers are from are laid beside it all the
//! same. Nothing in it is from a clock: the same audit gives the same bytes.

mod audit;
mod axis;
mod bench;
mod errata;
mod heat;
mod histogram;
mod page;
mod rungs;
mod side_by_side;
mod sketch;
mod svg;
mod table;
mod tables;
mod worst;

use std::error::Error;
use std::fs;
use std::path::{Path, PathBuf};

use radgrad_audit::gates::Gates;

use crate::files::{self, in_workspace};
use audit::Audit;
use page::Page;

/// Write the report of a finished audit as one HTML page
#[derive(Debug, clap::Args)]
pub(crate) struct Arguments {
    /// Folder that `cargo xtask verify` wrote
    #[arg(long, default_value = "target/verify")]
    from: PathBuf,
    /// Folder that `cargo xtask bench` wrote
    #[arg(long, default_value = "target/bench")]
    bench: PathBuf,
    /// Folder to write to
    #[arg(long, default_value = "target/report")]
    out: PathBuf,
}

/// The page may not be larger.
const MOST_BYTES: usize = 6_000_000;

/// Writes the page and lays the data beside it.
pub(crate) fn run(arguments: &Arguments) -> Result<(), Box<dyn Error>> {
    let out = &arguments.out;
    fs::create_dir_all(out).map_err(|error| format!("{}: {error}", out.display()))?;
    let Report { html, data, copied } = Report::read(&arguments.from, &arguments.bench)?;
    for path in &copied {
        let to = out.join(path.file_name().unwrap_or_default());
        files::write(&to, fs::read(path).map_err(|error| format!("{}: {error}", path.display()))?)?;
    }
    for (name, bytes) in data.iter().map(|(name, bytes)| (*name, bytes.as_slice())).chain([("index.html", html.as_bytes())]) {
        files::write(&out.join(name), bytes)?;
    }
    println!("{} ({} kB), its data beside it", out.join("index.html").display(), html.len().div_ceil(1000));
    if html.contains("no-bench") {
        println!("WITHOUT run time against error: no diagrams in {}; `cargo xtask bench` makes them", arguments.bench.display());
    }
    Ok(())
}

/// A file made here: its name and its bytes.
type Beside = (&'static str, Vec<u8>);

/// The page and the files laid beside it.
struct Report {
    html: String,
    /// Files made here.
    data: Vec<Beside>,
    /// Files to be copied.
    copied: Vec<PathBuf>,
}

impl Report {
    fn read(from: &Path, bench: &Path) -> Result<Self, Box<dyn Error>> {
        let audit = Audit::read(from)?;
        let read = |path: &str| fs::read_to_string(in_workspace(path)).map_err(|error| format!("{path}: {error}"));
        let gates = Gates::from_toml(&read("data/gates.toml")?)?;
        let misprints = errata::read(&read("ERRATA.md")?)?;
        let (diagrams, of_bench) = bench::read(bench)?;
        let worst = worst::cases(&audit)?;
        let data = vec![("errata.csv", errata::csv(&misprints)?), ("worst-cases.csv", worst::csv(&worst)?)];
        let mut copied = audit.files.clone();
        copied.extend(["bounds-times.csv", "errors.csv"].map(|name| from.join(name)).into_iter().filter(|path| path.exists()));
        copied.extend(["data/gates.toml", "data/tables/search.csv", "data/tables/faults.csv"].map(in_workspace));
        let searched = tables::searched(&read("data/tables/search.csv")?)?;
        let faults = tables::faults(&read("data/tables/faults.csv")?)?;
        copied.extend(of_bench);
        let html = Page::new(&audit, &gates, &misprints, &worst, diagrams, (&searched, &faults)).render(&data, &copied)?;
        if html.len() > MOST_BYTES {
            return Err(format!("the page has {} bytes, {MOST_BYTES} are allowed", html.len()).into());
        }
        Ok(Self { html, data, copied })
    }
}

#[cfg(test)]
mod tests;
