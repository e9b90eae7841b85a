//! `cargo xtask mutants`: plants faults in the code that users run, one at a time, and sees which of them the audit catches.
//!
//! The faults stand where they are planted, `mutant!("place.what", value, fault)` (`radgrad_numbers::mutant`), and are nothing in any
//! build but this command's: it runs cargo with itself as compiler of the workspace's crates, which adds `--cfg radgrad_mutants`,
//! so that other crates are shared with normal builds. One program is built, the small setting of the audit (example `bite`), and
//! run once for each fault, named by the environment variable `RADGRAD_MUTANT`.
//!
//! `data/mutants.toml` says of each fault what becomes of it: caught by truth; caught by nothing but the record of the bounds; or
//! harmless, with the reason. Of a caught one it names the check that tells, which is then the first to be made.

use std::collections::{BTreeMap, BTreeSet};
use std::error::Error;
use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode, Stdio};
use std::thread;
use std::time::{Duration, Instant};

use comfy_table::Table as Printed;
use indicatif::ProgressBar;
use radgrad_audit::witness::Witness;
use serde::{Deserialize, Serialize};

use crate::summary::{fitted, with_header};
use crate::{cargo, in_workspace, verify};

/// Plant faults in shipped code, one at a time: each must be caught, or be harmless for a reason that is written down
#[derive(Debug, clap::Args)]
pub(crate) struct Arguments {
    /// Only these faults
    names: Vec<String>,
    /// Print one object of JSON instead of a table
    #[arg(long)]
    summary: bool,
    /// Of what truth does not catch, climb this many rounds for cases that tell; found ones go to OUT/witnesses.jsonl, for data/worst,
    /// and OUT/records.jsonl, for data/record
    #[arg(long, value_name = "ROUNDS")]
    search: Option<u64>,
    /// Where tables go
    #[arg(long, default_value = "target/mutants")]
    out: PathBuf,
}

/// Set where this program is called as a compiler.
const AS_COMPILER: &str = "RADGRAD_MUTANTS_COMPILE";

/// A fault that makes the program run on for this long is caught by that.
const PATIENCE: Duration = Duration::from_secs(120);

/// Of the faults that are not harmless this share must be caught.
const CAUGHT: f64 = 0.95;

/// `data/mutants.toml`.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
struct Listed {
    /// Truth tells, by the check in which it does.
    caught: BTreeMap<String, BTreeSet<String>>,
    /// Nothing tells but that a bound is smaller than it was, by the check that remembers.
    by_record: BTreeMap<String, BTreeSet<String>>,
    /// Nothing tells: with what is known of it.
    #[serde(default)]
    unnoticed: BTreeMap<String, String>,
    /// Nothing is wrong: with the reason.
    harmless: BTreeMap<String, String>,
}

/// What becomes of a fault, the best first.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
enum Verdict {
    Caught,
    ByRecord,
    Harmless,
    Unnoticed,
}

impl Verdict {
    const fn name(self) -> &'static str {
        match self {
            Self::Caught => "caught",
            Self::ByRecord => "by the record",
            Self::Unnoticed => "unnoticed",
            Self::Harmless => "harmless",
        }
    }
}

/// What is known of a fault.
#[derive(Debug, Clone, Copy)]
struct Expected<'a> {
    verdict: Verdict,
    /// The check that tells, or the reason why nothing does.
    by: &'a str,
}

impl Listed {
    fn read() -> Result<Self, Box<dyn Error>> {
        let path = in_workspace("data/mutants.toml");
        let text = fs::read_to_string(&path).map_err(|error| format!("{}: {error}", path.display()))?;
        Ok(toml::from_str(&text)?)
    }

    /// Every fault with what is known of it.
    fn all(&self) -> BTreeMap<&str, Expected<'_>> {
        let mut all = BTreeMap::new();
        for (checks, verdict) in [(&self.caught, Verdict::Caught), (&self.by_record, Verdict::ByRecord)] {
            for (by, ids) in checks {
                all.extend(ids.iter().map(|id| (id.as_str(), Expected { verdict, by })));
            }
        }
        for (reasons, verdict) in [(&self.harmless, Verdict::Harmless), (&self.unnoticed, Verdict::Unnoticed)] {
            all.extend(reasons.iter().map(|(id, by)| (id.as_str(), Expected { verdict, by })));
        }
        all
    }
}

impl Expected<'_> {
    /// How the program is called: nothing beyond the record has to be asked of what only the record tells.
    fn arguments(&self) -> Vec<&str> {
        match self.verdict {
            Verdict::Caught => vec!["--check", self.by, "--until-wrong"],
            Verdict::ByRecord => vec!["--check", self.by, "--alone"],
            Verdict::Harmless | Verdict::Unnoticed => vec!["--until-wrong"],
        }
    }
}

/// The outcome of a fault.
#[derive(Debug, Serialize)]
struct Row {
    id: String,
    verdict: Verdict,
    /// What told, or the reason why nothing does.
    by: String,
    seconds: f64,
}

/// The object that `--summary` prints.
#[derive(Debug, Serialize)]
struct Summary<'a> {
    planted: usize,
    /// By truth or by the record.
    caught: usize,
    by_record: usize,
    unnoticed: usize,
    harmless: usize,
    seconds: f64,
    table: &'a [Row],
}

/// Whether this program is called as a compiler; then how that ended.
pub(crate) fn as_compiler() -> Option<ExitCode> {
    std::env::var_os(AS_COMPILER)?;
    let mut arguments = std::env::args_os().skip(1);
    let status = Command::new(arguments.next()?).args(arguments).args(["--cfg", "radgrad_mutants"]).status();
    Some(if status.is_ok_and(|status| status.success()) { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

/// Whether each fault fared as `data/mutants.toml` says, or better, and enough of them are caught.
pub(crate) fn run(arguments: &Arguments) -> Result<bool, Box<dyn Error>> {
    let (start, listed) = (Instant::now(), Listed::read()?);
    let listed = listed.all();
    if let Some(unknown) = arguments.names.iter().find(|name| !listed.contains_key(name.as_str())) {
        return Err(format!("no fault is called {unknown:?}: data/mutants.toml lists them").into());
    }
    fs::create_dir_all(&arguments.out)?;
    let program = build(&arguments.out)?;
    let control = planted(&program, "", &[])?;
    if let Some(wrong) = control.found.first().map(String::as_str).or(control.by_record.then_some("a bound that is smaller")) {
        return Err(format!("without a fault the audit finds {wrong}").into());
    }
    let wanted: Vec<(&str, Expected<'_>)> = listed
        .into_iter()
        .filter(|(id, _)| arguments.names.is_empty() || arguments.names.iter().any(|name| name == id))
        .collect();
    let bar = ProgressBar::new(wanted.len() as u64);
    bar.set_style(verify::style());
    let (mut rows, mut other, mut searched) = (Vec::new(), Vec::new(), Searched::default());
    for (id, expected) in wanted {
        bar.set_message(id.to_owned());
        let row = fared(&program, id, expected)?;
        if row.verdict != expected.verdict {
            let line = format!("{id} is {}, data/mutants.toml says {}", row.verdict.name(), expected.verdict.name());
            other.push(((row.verdict as u8) < expected.verdict as u8, line));
        }
        if let Some(rounds) = arguments.search.filter(|_| row.verdict != Verdict::Caught && row.verdict != Verdict::Harmless) {
            searched.search(&program, id, rounds)?;
        }
        rows.push(row);
        bar.inc(1);
    }
    bar.finish_and_clear();
    write(&rows, &searched, &arguments.out)?;
    let seconds = (10.0 * start.elapsed().as_secs_f64()).round() / 10.0;
    let summary = Summary::of(&rows, seconds);
    if arguments.summary {
        println!("{}", serde_json::to_string(&summary)?);
    } else {
        println!("{}\n{}", fitted(table(&summary)), counts(&summary));
    }
    for (is_better, line) in &other {
        eprintln!("{} {line}", if *is_better { "more is told than is listed:" } else { "VIOLATED" });
    }
    let are_enough = summary.are_enough();
    if !are_enough {
        eprintln!("VIOLATED less than {CAUGHT} of the faults that are not harmless are caught");
    }
    Ok(are_enough && other.iter().all(|(is_better, _)| *is_better))
}

/// What becomes of a fault.
fn fared(program: &Path, id: &str, expected: Expected<'_>) -> Result<Row, Box<dyn Error>> {
    let Told { found, by_record, seconds } = planted(program, id, &expected.arguments())?;
    let verdict = match (found.is_empty(), by_record) {
        (false, _) => Verdict::Caught,
        (true, true) => Verdict::ByRecord,
        (true, false) if expected.verdict == Verdict::Harmless => Verdict::Harmless,
        (true, false) => Verdict::Unnoticed,
    };
    let by = found.first().map_or(expected.by, String::as_str).to_owned();
    Ok(Row { id: id.to_owned(), verdict, by, seconds })
}

impl<'a> Summary<'a> {
    fn of(table: &'a [Row], seconds: f64) -> Self {
        let count = |verdict| table.iter().filter(|row| row.verdict == verdict).count();
        let by_record = count(Verdict::ByRecord);
        Self {
            planted: table.len(),
            caught: count(Verdict::Caught) + by_record,
            by_record,
            unnoticed: count(Verdict::Unnoticed),
            harmless: count(Verdict::Harmless),
            seconds,
            table,
        }
    }

    /// A run of some faults need not have many that are caught.
    fn are_enough(&self) -> bool {
        self.caught as f64 >= CAUGHT * (self.planted - self.harmless) as f64 || self.planted < 60
    }
}

/// Builds the small setting with faults to plant, and lays it aside.
fn build(out: &Path) -> Result<PathBuf, Box<dyn Error>> {
    let status = Command::new(cargo())
        .args(["build", "--package", "radgrad-audit", "--example", "bite", "--manifest-path"])
        .arg(in_workspace("Cargo.toml"))
        .env("RUSTC_WORKSPACE_WRAPPER", std::env::current_exe()?)
        .env(AS_COMPILER, "1")
        .status()?;
    if !status.success() {
        return Err("the program with faults to plant does not build".into());
    }
    let target = std::env::var_os("CARGO_TARGET_DIR").map_or_else(|| in_workspace("target"), PathBuf::from);
    let name = format!("bite{}", std::env::consts::EXE_SUFFIX);
    let program = out.join(&name);
    // A link to what a normal build writes anew would lose the faults.
    if program.exists() {
        fs::remove_file(&program)?;
    }
    fs::copy(target.join("debug/examples").join(&name), &program)?;
    Ok(fs::canonicalize(program)?)
}

/// What a run with a fault said.
struct Told {
    /// What truth found wrong.
    found: Vec<String>,
    /// Whether a bound is smaller than it was.
    by_record: bool,
    seconds: f64,
}

/// A line of the program.
#[derive(Deserialize)]
struct Line {
    check: String,
    by_record: bool,
    what: String,
}

fn planted(program: &Path, id: &str, arguments: &[&str]) -> Result<Told, Box<dyn Error>> {
    let start = Instant::now();
    let said = program.with_extension("said");
    let mut child = Command::new(program)
        .args(arguments)
        .env("RADGRAD_MUTANT", id)
        .env_remove(AS_COMPILER)
        .stdout(File::create(&said)?)
        .stderr(Stdio::null())
        .spawn()?;
    let status = loop {
        if let Some(status) = child.try_wait()? {
            break Some(status);
        }
        if start.elapsed() > PATIENCE {
            child.kill()?;
            child.wait()?;
            break None;
        }
        thread::sleep(Duration::from_millis(20));
    };
    let seconds = (100.0 * start.elapsed().as_secs_f64()).round() / 100.0;
    let text = fs::read_to_string(&said)?;
    let lines: Vec<Line> = text.lines().filter_map(|line| serde_json::from_str(line).ok()).collect();
    let mut found: Vec<String> =
        lines.iter().filter(|line| !line.by_record).map(|line| format!("{}: {}", line.check, line.what)).collect();
    let by_record = lines.iter().any(|line| line.by_record);
    match status {
        None => found.push(format!("it does not end in {} s", PATIENCE.as_secs())),
        Some(status) if lines.is_empty() && !status.success() => found.push(format!("it ends with {status}")),
        Some(_) => {}
    }
    Ok(Told { found, by_record, seconds })
}

/// Cases that tell of faults.
#[derive(Default)]
struct Searched {
    /// A bound is broken: with how near it comes without the fault.
    witnesses: Vec<Witness>,
    /// Lines of records.
    records: Vec<String>,
}

impl Searched {
    fn search(&mut self, program: &Path, id: &str, rounds: u64) -> Result<(), Box<dyn Error>> {
        let lines = |arguments: &[&str]| -> Result<Vec<String>, Box<dyn Error>> {
            let output = Command::new(program).args(arguments).env("RADGRAD_MUTANT", id).output()?;
            Ok(String::from_utf8(output.stdout)?.lines().map(str::to_owned).collect())
        };
        let rounds = rounds.to_string();
        let broken = lines(&["search", &rounds])?;
        for line in &broken {
            let mut witness: Witness = serde_json::from_str(line)?;
            let asked = witness.ask.of(&witness.case);
            if let Some(held) = asked.held.iter().find(|held| held.place == witness.place) {
                (witness.ratio, witness.bound) = (held.ratio, held.bound);
                witness.case.id = radgrad_scene::case::Id::Text(format!("{id}: {}", witness.place));
                self.witnesses.push(witness);
            }
        }
        let records = lines(&["hunt", id, &rounds])?;
        eprintln!("{id}: {} witnesses, {} records", broken.len(), records.len());
        self.records.extend(records);
        Ok(())
    }
}

fn write(rows: &[Row], searched: &Searched, out: &Path) -> Result<(), Box<dyn Error>> {
    let mut table = csv::Writer::from_path(out.join("planted.csv"))?;
    table.write_record(["fault", "verdict", "by", "seconds"])?;
    for row in rows {
        table.write_record([&row.id, row.verdict.name(), &row.by, &row.seconds.to_string()])?;
    }
    table.flush()?;
    let Searched { witnesses, records } = searched;
    if !witnesses.is_empty() {
        let lines = witnesses.iter().map(serde_json::to_string).collect::<Result<Vec<_>, _>>()?;
        fs::write(out.join("witnesses.jsonl"), lines.join("\n") + "\n")?;
    }
    if !records.is_empty() {
        fs::write(out.join("records.jsonl"), records.join("\n") + "\n")?;
    }
    Ok(())
}

fn table(summary: &Summary<'_>) -> Printed {
    let mut printed = with_header(&["fault", "verdict", "seconds", "by"]);
    for row in summary.table {
        printed.add_row([&row.id, row.verdict.name(), &row.seconds.to_string(), &row.by.chars().take(100).collect::<String>()]);
    }
    printed
}

fn counts(summary: &Summary<'_>) -> String {
    let Summary { planted, caught, by_record, unnoticed, harmless, seconds, .. } = summary;
    format!(
        "{planted} faults planted in shipped code: {caught} caught, {by_record} of them by the record of the bounds alone, {unnoticed} \
         unnoticed, {harmless} harmless; {seconds:.0} s"
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Names of the faults that stand in sources below a folder, but for those of documentation.
    fn in_sources(folder: &Path, found: &mut Vec<String>) {
        for entry in fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                in_sources(&path, found);
            } else if path.extension().is_some_and(|extension| extension == "rs") {
                let text = fs::read_to_string(&path).unwrap();
                let code = text.lines().filter(|line| !line.trim_start().starts_with("//")).collect::<Vec<_>>().join(" ");
                for rest in code.split("mutant!(").skip(1) {
                    if let Some(id) = rest.trim_start().strip_prefix('"').and_then(|rest| rest.split('"').next()) {
                        found.push(id.to_owned());
                    }
                }
            }
        }
    }

    /// As `radgrad_numbers::mutant` tells faults apart.
    fn key(id: &str) -> u64 {
        id.bytes().fold(0xcbf2_9ce4_8422_2325, |hash, byte| (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3))
    }

    #[test]
    fn the_summary_has_the_recorded_form() {
        let row = |id: &str, verdict, by: &str| Row { id: id.to_owned(), verdict, by: by.to_owned(), seconds: 0.25 };
        let rows = [
            row("a.sign", Verdict::Caught, "merge: three shards do not make the table of the whole"),
            row("b.bound", Verdict::ByRecord, "witnesses"),
            row("c.term", Verdict::Harmless, "A sum has it twice."),
            row("d.index", Verdict::Unnoticed, "Nothing reads it."),
        ];
        let summary = Summary::of(&rows, 1.5);
        let json = serde_json::to_string_pretty(&summary).unwrap();
        insta::assert_snapshot!(format!("{json}\n{}\n{}", table(&summary), counts(&summary)));
    }

    #[test]
    fn every_fault_in_the_code_is_listed_once_and_every_listed_one_is_there() {
        let mut found = Vec::new();
        for name in ["numbers", "core", "oracle", "audit", "scene", "solver"] {
            in_sources(&in_workspace(&format!("crates/{name}/src")), &mut found);
        }
        found.sort();
        let keys: BTreeSet<u64> = found.iter().map(|id| key(id)).collect();
        assert_eq!(keys.len(), found.len(), "two faults have one name, or names that are not told apart");
        let listed = Listed::read().unwrap();
        assert_eq!(listed.all().keys().copied().collect::<Vec<_>>(), found);
        let named = listed.caught.values().chain(listed.by_record.values()).map(BTreeSet::len).sum::<usize>();
        assert_eq!(named + listed.harmless.len() + listed.unnoticed.len(), found.len(), "a fault is listed twice");
        assert!(listed.harmless.values().chain(listed.unnoticed.values()).all(|why| why.len() > 40));
        assert!(found.len() >= 60 && listed.harmless.len() as f64 <= (1.0 - CAUGHT) * found.len() as f64);
    }
}
