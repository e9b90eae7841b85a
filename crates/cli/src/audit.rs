//! `radgrad audit`: draws the audit's cases, sends them to any program, and holds its answers to exact values.

use std::fs::{self, File};
use std::io::{self, BufRead, BufReader, BufWriter, Read, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdin, Command, Stdio};
use std::sync::mpsc::{RecvTimeoutError, SyncSender, sync_channel};
use std::thread;
use std::time::Duration;

use indicatif::ProgressBar;
use radgrad_audit::cases::family::{Family, Name};
use radgrad_audit::checks::foreign::{Gates, Held, Violation, hold};
use radgrad_audit::measures::measure::{Kind, Quantity};
use radgrad_audit::measures::run::Run;
use radgrad_audit::measures::table::{FamilyTable, Table};
use radgrad_scene::output::{Unwritten, write_whole};
use radgrad_scene::{printable, read_file};
use rayon::prelude::*;

use crate::say::say;

/// Options of `audit`.
#[derive(Debug, clap::Args)]
pub(crate) struct Arguments {
    /// The program, as the shell takes it: it reads a case a line and writes an answer a line, as `radgrad eval -` does.
    ///
    /// Fields of an answer: `radiosity`; `gradient`, `radiosity_error` and `gradient_error` where it has them; or `error`.
    #[arg(long, value_name = "CMD")]
    program: String,
    /// Cases of each family, fewer of dear ones.
    #[arg(long, default_value = "100", value_parser = clap::value_parser!(u64).range(1..))]
    cases: u64,
    /// Seed: the same seed gives the same cases on every machine.
    #[arg(long, default_value = "1")]
    seed: u64,
    /// Only these families.
    #[arg(long)]
    family: Vec<Family>,
    /// File of gates, the largest figures allowed: `[all]` or `[FAMILY]`, then `value = 1e-6`, `gradient = ..`.
    ///
    /// Without one, only a stated bound below its error is a violation, an answer that is no number, or a case without truth.
    #[arg(long)]
    gates: Option<PathBuf>,
    /// Folder for the tables: errors.csv, figures.csv, histogram.csv, outcomes.csv.
    #[arg(long)]
    out: Option<PathBuf>,
    /// Seconds in which the program has to write the next answer; it is ended when they are over.
    #[arg(long, default_value = "60", value_parser = clap::value_parser!(u64).range(1..=1_000_000))]
    seconds: u64,
    /// MiB of memory that it may have, where the shell can say so.
    #[arg(long, value_name = "MIB", default_value = "4096", value_parser = clap::value_parser!(u64).range(1..=1_000_000_000))]
    memory: u64,
}

/// Bytes of a line that is an answer, at most.
const LINE: u64 = 1 << 20;

/// Bytes of a file of gates, at most.
const GATES: u64 = 1 << 20;

/// Why nothing was audited.
#[derive(Debug, thiserror::Error)]
pub(crate) enum Failure {
    /// The program cannot be started, or ended before its last answer.
    #[error("{program}: {why}")]
    Program {
        /// As it was given.
        program: String,
        /// Why.
        why: String,
    },
    /// A file cannot be read or written.
    #[error("{path}: {why}", path = path.display())]
    File {
        /// Which.
        path: PathBuf,
        /// Why.
        why: String,
    },
    /// What was found cannot be written.
    #[error(transparent)]
    Unwritten(#[from] Unwritten),
    /// The same of the standard output.
    #[error("cannot write to the standard output: {0}")]
    Output(#[source] io::Error),
}

/// Whether nothing is violated.
pub(crate) fn run(arguments: &Arguments) -> Result<bool, Failure> {
    let gates = match &arguments.gates {
        None => Gates::default(),
        Some(path) => {
            let text = read_file(path, GATES).map_err(|error| file(path, error))?;
            let text = String::from_utf8(text).map_err(|error| file(path, error.utf8_error()))?;
            Gates::from_toml(&text).map_err(|error| file(path, error))?
        }
    };
    if let Some(out) = &arguments.out {
        fs::create_dir_all(out).map_err(|error| file(out, error))?;
    }
    let families = if arguments.family.is_empty() { Family::ALL.to_vec() } else { arguments.family.clone() };
    let names: Vec<Name> = Run::of_each(arguments.cases, &families, arguments.seed).names().collect();
    let lines = answers(arguments, &names)?;
    let bar = ProgressBar::new(names.len() as u64);
    let judge = |(name, line): (&Name, &String)| {
        let held = hold(&name.case(), line);
        bar.inc(1);
        held
    };
    let held: Vec<Held> = names.par_iter().zip(&lines).map(judge).collect();
    bar.finish_and_clear();
    let mut table = Table::default();
    for (name, held) in names.iter().zip(&held) {
        held.record(*name, &mut table);
    }
    let mut said = shown(&table);
    for kind in [Kind::Unanswered, Kind::NonFinite, Kind::Undetermined] {
        if let Some((name, held)) = names.iter().zip(&held).find(|(_, held)| held.kind == kind) {
            said.push(format!("the first {} is {name}: {}", kind.name(), held.remark.trim()));
        }
    }
    if let Some(out) = &arguments.out {
        write(&table, out)?;
    }
    let violations = gates.violations(&families, &table);
    for Violation { family, case, what } in &violations {
        said.push(format!("VIOLATED {family}: {what}{}", case.map_or_else(String::new, |case| format!(", at {case}"))));
    }
    let is_answered = held.iter().any(|held| held.kind == Kind::Measured);
    let result = match (is_answered, violations.is_empty()) {
        (false, _) => "FAILED, nothing was answered",
        (true, false) => "FAILED",
        (true, true) => "nothing is violated",
    };
    let count = families.len();
    let cases = format!("{} cases of {count} families, seed {}", table.cases(), arguments.seed);
    said.push(format!("{cases}, each against an enclosure of its exact value: {result}"));
    let mut out = io::stdout().lock();
    // What a program answers may have any character.
    said.iter().try_for_each(|line| writeln!(out, "{}", printable(line))).map_err(Failure::Output)?;
    Ok(is_answered && violations.is_empty())
}

fn file(path: &Path, why: impl std::fmt::Display) -> Failure {
    Failure::File { path: path.to_path_buf(), why: why.to_string() }
}

/// The program in a group of its own, with no more memory than it may have.
fn shell(program: &str, memory: u64) -> Command {
    let mut command = Command::new(if cfg!(windows) { "cmd" } else { "sh" });
    #[cfg(windows)]
    command.args(["/C", program]);
    #[cfg(unix)]
    {
        let limited = format!("ulimit -v {} 2>/dev/null; {program}", memory.saturating_mul(1024));
        std::os::unix::process::CommandExt::process_group(command.args(["-c", &limited]), 0);
    }
    command
}

/// Ends the program and all that it started.
fn end(child: &mut Child) {
    #[cfg(unix)]
    drop(Command::new("kill").args(["-KILL", "--", &format!("-{}", child.id())]).stderr(Stdio::null()).status());
    drop(child.kill());
    drop(child.wait());
}

/// A line for each case. Another thread writes and one reads, so that neither side waits for the other.
fn answers(arguments: &Arguments, names: &[Name]) -> Result<Vec<String>, Failure> {
    let program = &arguments.program;
    let failed = |why: String| Failure::Program { program: program.clone(), why };
    let child = shell(program, arguments.memory).stdin(Stdio::piped()).stdout(Stdio::piped()).spawn();
    let mut child = child.map_err(|error| failed(error.to_string()))?;
    let (Some(input), Some(output)) = (child.stdin.take(), child.stdout.take()) else {
        return Err(failed("it has no input or output".to_owned()));
    };
    let asked = names.to_vec();
    // That the program stops reading shows in its answers.
    thread::spawn(move || send(input, &asked));
    // Few at once: a program that answers without end waits.
    let (sender, receiver) = sync_channel(1024);
    thread::spawn(move || read(BufReader::new(output), &sender));
    let mut lines = Vec::new();
    let why = loop {
        match receiver.recv_timeout(Duration::from_secs(arguments.seconds)) {
            Ok(Ok(line)) if lines.len() < names.len() => lines.push(line),
            Ok(Ok(_)) => break Some(format!("it answered more than {} cases: a line for each is due", names.len())),
            Ok(Err(why)) => break Some(why),
            Err(RecvTimeoutError::Timeout) => {
                let (done, all) = (lines.len(), names.len());
                let rule = format!("more with --seconds than {} if it needs them", arguments.seconds);
                break Some(format!("no answer came in time after {done} of {all}: give it {rule}"));
            }
            Err(RecvTimeoutError::Disconnected) => break None,
        }
    };
    if let Some(why) = why {
        end(&mut child);
        return Err(failed(why));
    }
    let status = child.wait().map_err(|error| failed(error.to_string()))?;
    if lines.len() != names.len() {
        if !status.success() {
            say(format_args!("{program}: {status}"));
        }
        return Err(failed(format!("it answered {} of {} cases: a line for each is due", lines.len(), names.len())));
    }
    Ok(lines)
}

/// Hands on the lines of an output, or why there are no more.
fn read(mut output: impl BufRead, to: &SyncSender<Result<String, String>>) {
    loop {
        let mut line = Vec::new();
        let found = match output.by_ref().take(LINE).read_until(b'\n', &mut line) {
            Ok(0) => return,
            Ok(count) if count as u64 == LINE => Err(format!("a line of it is longer than {LINE} bytes")),
            Ok(_) => {
                String::from_utf8(line).map(|line| line.trim_end().to_owned()).map_err(|error| error.utf8_error().to_string())
            }
            Err(error) => Err(error.to_string()),
        };
        if to.send(found).is_err() {
            return;
        }
    }
}

fn send(mut input: ChildStdin, names: &[Name]) -> io::Result<()> {
    for name in names {
        let mut line = serde_json::to_vec(&name.case())?;
        line.push(b'\n');
        input.write_all(&line)?;
    }
    input.flush()
}

/// A line a family: cases, how many were answered, median and worst errors, the worst over its bound.
fn shown(table: &Table) -> Vec<String> {
    let row = |[family, rest @ ..]: [String; 8]| {
        format!("{family:17}{}", rest.iter().map(|cell| format!(" {cell:>9}")).collect::<String>())
    };
    let titles = ["family", "cases", "answered", "value", "worst", "gradient", "worst", "/ bound"];
    let mut lines = vec![row(titles.map(str::to_owned))];
    for (family, of) in table.families() {
        let figure = |quantity, which: fn(&FamilyTable, Quantity) -> Option<String>| which(of, quantity).unwrap_or_default();
        let median: fn(&FamilyTable, Quantity) -> Option<String> =
            |of, quantity| Some(of.figures().get(&quantity)?.percentile(50)?.to_string());
        let worst: fn(&FamilyTable, Quantity) -> Option<String> = |of, quantity| {
            let value = of.figures().get(&quantity)?.worst()?.value;
            Some(if value == 0.0 { "0".to_owned() } else { format!("{value:.1e}") })
        };
        let over = [Quantity::ValueOverBound, Quantity::GradientOverBound].into_iter();
        let over = over.filter_map(|quantity| of.figures().get(&quantity)?.worst()).map(|worst| worst.value).reduce(f64::max);
        lines.push(row([
            family.to_string(),
            of.cases().to_string(),
            of.count(Kind::Measured).to_string(),
            figure(Quantity::Value, median),
            figure(Quantity::Value, worst),
            figure(Quantity::Gradient, median),
            figure(Quantity::Gradient, worst),
            over.map_or_else(String::new, |over| format!("{over:.2}")),
        ]));
    }
    lines
}

fn write(table: &Table, out: &Path) -> Result<(), Failure> {
    type Part = fn(&Table, &mut BufWriter<File>) -> csv::Result<()>;
    let files: [(&str, Part); 4] = [
        ("errors.csv", |table, file| table.write_errors(file)),
        ("figures.csv", |table, file| table.write_figures(file)),
        ("histogram.csv", |table, file| table.write_histogram(file)),
        ("outcomes.csv", |table, file| table.write_outcomes(file)),
    ];
    for (name, part) in files {
        write_whole(&out.join(name), |file| part(table, file))?;
    }
    Ok(())
}
