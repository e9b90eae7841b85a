//! `radgrad audit`: draws the audit's cases, sends them to any program, and holds its answers to exact values.

use std::fs;
use std::io::{BufRead, BufReader, Write};
use std::path::{Path, PathBuf};
use std::process::{ChildStdin, Command, Stdio};
use std::thread;

use indicatif::ProgressBar;
use radgrad_audit::family::{Family, Name};
use radgrad_audit::foreign::{Gates, Held, Violation, hold};
use radgrad_audit::measure::{Kind, Quantity};
use radgrad_audit::run::Run;
use radgrad_audit::table::{FamilyTable, Table};
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
}

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
}

/// Whether nothing is violated.
pub(crate) fn run(arguments: &Arguments) -> Result<bool, Failure> {
    let gates = match &arguments.gates {
        None => Gates::default(),
        Some(path) => {
            let text = fs::read_to_string(path).map_err(|error| file(path, error))?;
            Gates::from_toml(&text).map_err(|error| file(path, error))?
        }
    };
    if let Some(out) = &arguments.out {
        fs::create_dir_all(out).map_err(|error| file(out, error))?;
    }
    let families = if arguments.family.is_empty() { Family::ALL.to_vec() } else { arguments.family.clone() };
    let names: Vec<Name> = Run::of_each(arguments.cases, &families, arguments.seed).names().collect();
    let lines = answers(&arguments.program, &names)?;
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
    print(&table);
    for kind in [Kind::Unanswered, Kind::NonFinite, Kind::Undetermined] {
        if let Some((name, held)) = names.iter().zip(&held).find(|(_, held)| held.kind == kind) {
            println!("the first {} is {name}: {}", kind.name(), held.remark.trim());
        }
    }
    if let Some(out) = &arguments.out {
        write(&table, out)?;
    }
    let violations = gates.violations(&families, &table);
    for Violation { family, case, what } in &violations {
        println!("VIOLATED {family}: {what}{}", case.map_or_else(String::new, |case| format!(", at {case}")));
    }
    let (cases, held) = (table.cases(), if violations.is_empty() { "nothing is violated" } else { "FAILED" });
    println!(
        "{cases} cases of {} families, seed {}, each against an enclosure of its exact value: {held}",
        families.len(),
        arguments.seed
    );
    Ok(violations.is_empty())
}

fn file(path: &Path, why: impl std::fmt::Display) -> Failure {
    Failure::File { path: path.to_path_buf(), why: why.to_string() }
}

fn shell(program: &str) -> Command {
    let (shell, flag) = if cfg!(windows) { ("cmd", "/C") } else { ("sh", "-c") };
    let mut command = Command::new(shell);
    command.arg(flag).arg(program);
    command
}

/// A line for each case. Another thread writes, so that neither side waits for the other.
fn answers(program: &str, names: &[Name]) -> Result<Vec<String>, Failure> {
    let failed = |why: String| Failure::Program { program: program.to_owned(), why };
    let child = shell(program).stdin(Stdio::piped()).stdout(Stdio::piped()).spawn();
    let mut child = child.map_err(|error| failed(error.to_string()))?;
    let (Some(input), Some(output)) = (child.stdin.take(), child.stdout.take()) else {
        return Err(failed("it has no input or output".to_owned()));
    };
    let lines = thread::scope(|scope| {
        // That the program stops reading shows in what it answers.
        let writer = scope.spawn(|| send(input, names));
        let lines: Vec<std::io::Result<String>> = BufReader::new(output).lines().collect();
        drop(writer.join());
        lines
    });
    let status = child.wait().map_err(|error| failed(error.to_string()))?;
    let lines: Vec<String> = lines.into_iter().collect::<Result<_, _>>().map_err(|error| failed(error.to_string()))?;
    if lines.len() != names.len() {
        if !status.success() {
            say(format_args!("{program}: {status}"));
        }
        return Err(failed(format!("it answered {} of {} cases: a line for each is due", lines.len(), names.len())));
    }
    Ok(lines)
}

fn send(mut input: ChildStdin, names: &[Name]) -> std::io::Result<()> {
    for name in names {
        let mut line = serde_json::to_vec(&name.case())?;
        line.push(b'\n');
        input.write_all(&line)?;
    }
    input.flush()
}

/// A row a family: cases, how many were answered, median and worst errors, the worst over its bound.
fn print(table: &Table) {
    let row = |cells: [String; 8]| {
        let [family, rest @ ..] = cells;
        println!("{family:17}{}", rest.iter().map(|cell| format!(" {cell:>9}")).collect::<String>());
    };
    let titles = ["family", "cases", "answered", "value", "worst", "gradient", "worst", "/ bound"];
    row(titles.map(str::to_owned));
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
        row([
            family.to_string(),
            of.cases().to_string(),
            of.count(Kind::Measured).to_string(),
            figure(Quantity::Value, median),
            figure(Quantity::Value, worst),
            figure(Quantity::Gradient, median),
            figure(Quantity::Gradient, worst),
            over.map_or_else(String::new, |over| format!("{over:.2}")),
        ]);
    }
}

fn write(table: &Table, out: &Path) -> Result<(), Failure> {
    type Part = fn(&Table, fs::File) -> csv::Result<()>;
    let files: [(&str, Part); 4] = [
        ("errors.csv", |table, file| table.write_errors(file)),
        ("figures.csv", |table, file| table.write_figures(file)),
        ("histogram.csv", |table, file| table.write_histogram(file)),
        ("outcomes.csv", |table, file| table.write_outcomes(file)),
    ];
    for (name, part) in files {
        let path = out.join(name);
        let created = fs::File::create(&path).map_err(|error| file(&path, error))?;
        part(table, created).map_err(|error| file(&path, error))?;
    }
    Ok(())
}
