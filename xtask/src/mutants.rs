//! `cargo xtask mutants`: plants faults in the code that users run, one at a time, and sees which of them the audit catches.
//!
//! The faults stand where they are planted, `mutant!("place.what", value, fault)` (`radgrad_core::mutant`), and are nothing in any
//! build but this command's: it runs cargo with itself as compiler of the workspace's crates, which adds `--cfg radgrad_mutants`,
//! so that other crates are shared with normal builds. One program is built, the small setting of the audit (example `bite`), and
//! run once for each fault, named by the environment variable `RADGRAD_MUTANT`.
//!
//! `data/mutants.toml` says of each fault what becomes of it: caught by truth; told by nothing but the record of the bounds; left
//! unnoticed, since the bound is too wide; or harmless, with the reason.

use std::collections::{BTreeMap, BTreeSet};
use std::error::Error;
use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode, Stdio};
use std::thread;
use std::time::{Duration, Instant};

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
    /// For faults that are not caught, climb this many rounds towards a case that breaks a bound; it goes to OUT/witnesses.jsonl
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

/// `data/mutants.toml`.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
struct Listed {
    /// Truth tells.
    caught: BTreeSet<String>,
    /// Nothing tells but that a bound is smaller than it was.
    by_record: BTreeSet<String>,
    /// Nothing tells, since the bound is wider than the fault: with the reason.
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
    Unnoticed,
    Harmless,
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

impl Listed {
    fn read() -> Result<Self, Box<dyn Error>> {
        let path = in_workspace("data/mutants.toml");
        let text = fs::read_to_string(&path).map_err(|error| format!("{}: {error}", path.display()))?;
        Ok(toml::from_str(&text)?)
    }

    /// Every fault with its verdict, and the reason where it needs one.
    fn all(&self) -> BTreeMap<&str, (Verdict, &str)> {
        let sets = [(&self.caught, Verdict::Caught), (&self.by_record, Verdict::ByRecord)];
        let told = sets.into_iter().flat_map(|(set, verdict)| set.iter().map(move |id| (id.as_str(), (verdict, ""))));
        let maps = [(&self.unnoticed, Verdict::Unnoticed), (&self.harmless, Verdict::Harmless)];
        let not =
            maps.into_iter().flat_map(|(map, verdict)| map.iter().map(move |(id, why)| (id.as_str(), (verdict, why.as_str()))));
        told.chain(not).collect()
    }
}

/// What came of a fault.
#[derive(Debug, Serialize)]
struct Row {
    id: String,
    verdict: Verdict,
    /// What told, or the reason why nothing does.
    by: String,
    seconds: f64,
}

/// What `--summary` prints.
#[derive(Debug, Serialize)]
struct Summary<'a> {
    planted: usize,
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

/// Whether each fault fared as `data/mutants.toml` says, or better.
pub(crate) fn run(arguments: &Arguments) -> Result<bool, Box<dyn Error>> {
    let (start, listed) = (Instant::now(), Listed::read()?);
    let listed = listed.all();
    if let Some(unknown) = arguments.names.iter().find(|name| !listed.contains_key(name.as_str())) {
        return Err(format!("no fault is called {unknown:?}: data/mutants.toml lists them").into());
    }
    fs::create_dir_all(&arguments.out)?;
    let program = build(&arguments.out)?;
    let control = planted(&program, "", &[])?;
    if let Some(wrong) = control.found.first() {
        return Err(format!("without a fault the audit finds {wrong}").into());
    }
    let wanted: Vec<(&str, (Verdict, &str))> = listed
        .into_iter()
        .filter(|(id, _)| arguments.names.is_empty() || arguments.names.iter().any(|name| name == id))
        .collect();
    let bar = ProgressBar::new(wanted.len() as u64);
    bar.set_style(verify::style());
    let (mut rows, mut other, mut better, mut witnesses) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
    for (id, (expected, reason)) in wanted {
        bar.set_message(id.to_owned());
        let Told { found, by_record, seconds } = planted(&program, id, &["--first"])?;
        let verdict = match (found.is_empty(), by_record) {
            (false, _) => Verdict::Caught,
            (true, true) => Verdict::ByRecord,
            (true, false) if expected == Verdict::Harmless => Verdict::Harmless,
            (true, false) => Verdict::Unnoticed,
        };
        if verdict != expected {
            let line = format!("{id} is {}, data/mutants.toml says {}", verdict.name(), expected.name());
            if (verdict as u8) < expected as u8 { better.push(line) } else { other.push(line) }
        }
        let by = found.first().map_or(reason, String::as_str).to_owned();
        rows.push(Row { id: id.to_owned(), verdict, by, seconds });
        if let Some(rounds) = arguments.search.filter(|_| verdict != Verdict::Caught && verdict != Verdict::Harmless) {
            witnesses.extend(searched(&program, id, rounds)?);
        }
        bar.inc(1);
    }
    bar.finish_and_clear();
    let seconds = start.elapsed().as_secs_f64();
    write(&rows, &witnesses, &arguments.out)?;
    let count = |verdict| rows.iter().filter(|row| row.verdict == verdict).count();
    let summary = Summary {
        planted: rows.len(),
        caught: count(Verdict::Caught),
        by_record: count(Verdict::ByRecord),
        unnoticed: count(Verdict::Unnoticed),
        harmless: count(Verdict::Harmless),
        seconds: (10.0 * seconds).round() / 10.0,
        table: &rows,
    };
    if arguments.summary {
        println!("{}", serde_json::to_string(&summary)?);
    } else {
        print(&summary);
    }
    for line in &better {
        eprintln!("more is told than is listed: {line}");
    }
    for line in &other {
        eprintln!("VIOLATED {line}");
    }
    Ok(other.is_empty())
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

/// Cases that break a bound where a fault is planted, with how near they come where it is not.
fn searched(program: &Path, id: &str, rounds: u64) -> Result<Vec<Witness>, Box<dyn Error>> {
    let output = Command::new(program).args(["search", &rounds.to_string()]).env("RADGRAD_MUTANT", id).output()?;
    let text = String::from_utf8(output.stdout)?;
    let mut witnesses = Vec::new();
    for line in text.lines() {
        let mut witness: Witness = serde_json::from_str(line)?;
        let asked = witness.ask.of(&witness.case);
        if let Some(held) = asked.held.iter().find(|held| held.place == witness.place) {
            (witness.ratio, witness.bound) = (held.ratio, held.bound);
            witness.case.id = radgrad_scene::case::Id::Text(format!("{id}: {}", witness.place));
            witnesses.push(witness);
        }
    }
    eprintln!("{id}: {} witnesses of {}", witnesses.len(), text.lines().count());
    Ok(witnesses)
}

fn write(rows: &[Row], witnesses: &[Witness], out: &Path) -> Result<(), Box<dyn Error>> {
    let mut table = csv::Writer::from_path(out.join("planted.csv"))?;
    table.write_record(["fault", "verdict", "by", "seconds"])?;
    for row in rows {
        table.write_record([&row.id, row.verdict.name(), &row.by, &row.seconds.to_string()])?;
    }
    table.flush()?;
    if !witnesses.is_empty() {
        let lines = witnesses.iter().map(serde_json::to_string).collect::<Result<Vec<_>, _>>()?;
        fs::write(out.join("witnesses.jsonl"), lines.join("\n") + "\n")?;
    }
    Ok(())
}

fn print(summary: &Summary<'_>) {
    let mut printed = with_header(&["fault", "verdict", "seconds", "by"]);
    for row in summary.table {
        printed.add_row([&row.id, row.verdict.name(), &row.seconds.to_string(), &row.by.chars().take(100).collect::<String>()]);
    }
    println!("{}", fitted(printed));
    println!(
        "{} faults planted in shipped code: {} caught by truth, {} by the record of the bounds, {} unnoticed, {} harmless; {:.0} s",
        summary.planted, summary.caught, summary.by_record, summary.unnoticed, summary.harmless, summary.seconds
    );
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

    /// As `radgrad_core::mutant` tells faults apart.
    fn key(id: &str) -> u64 {
        id.bytes().fold(0xcbf2_9ce4_8422_2325, |hash, byte| (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3))
    }

    #[test]
    fn every_fault_in_the_code_is_listed_once_and_every_listed_one_is_there() {
        let mut found = Vec::new();
        for name in ["core", "oracle", "audit", "scene", "solver"] {
            in_sources(&in_workspace(&format!("crates/{name}/src")), &mut found);
        }
        found.sort();
        let keys: BTreeSet<u64> = found.iter().map(|id| key(id)).collect();
        assert_eq!(keys.len(), found.len(), "two faults have one name, or names that are not told apart");
        let listed = Listed::read().unwrap();
        let counts = [listed.caught.len(), listed.by_record.len(), listed.unnoticed.len(), listed.harmless.len()];
        assert_eq!(listed.all().keys().copied().collect::<Vec<_>>(), found);
        assert_eq!(counts.iter().sum::<usize>(), found.len(), "a fault is listed twice");
        assert!(found.len() >= 60 && listed.unnoticed.values().chain(listed.harmless.values()).all(|why| why.len() > 20));
    }
}
