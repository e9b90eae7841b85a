//! `cargo xtask mutants`: draws faults in the code that users run, switches them on one at a time, and sees which the audit notices.
//!
//! Nobody chooses them: [`places`] lists every place of the code that decides, evaluates or bounds where a fault of some kind can
//! stand, [`draw`] draws of all these by a seed, [`instrument`] writes a copy of the workspace in which the drawn ones can be switched
//! on, [`mod@run`] asks of each the checks of the audit's small setting (example `bite`) that come to its place, and [`score`] says what
//! became of them. `data/mutants.toml` has what is known of those that nothing notices.

mod draw;
mod instrument;
mod places;
mod run;
pub(crate) mod score;

use std::collections::BTreeSet;
use std::error::Error;
use std::fs;
use std::path::{Path, PathBuf};
use std::time::Instant;

use indicatif::ProgressBar;
use radgrad_audit::bounds::witness::Witness;
use radgrad_audit::checks::bite;
use rayon::prelude::*;

use self::draw::{Drawn, Source};
use self::instrument::Copy;
use self::places::Form;
use self::run::{Program, Seen};
use self::score::{Known, NOTICED, Row, Summary};
use crate::files::{self, in_workspace};
use crate::summary;

/// Draw faults in shipped code, and switch them on one at a time: how many does the audit notice?
#[derive(Debug, clap::Args)]
pub(crate) struct Arguments {
    /// How many faults are drawn
    #[arg(long, value_name = "N", default_value_t = 100)]
    sample: usize,
    /// What they are drawn by
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Print one object of JSON instead of a table
    #[arg(long)]
    summary: bool,
    /// For those that truth does not notice, climb this many rounds for cases that tell; they go to OUT/witnesses.jsonl, for data/worst
    #[arg(long, value_name = "ROUNDS")]
    search: Option<u64>,
    /// Instead of drawing, those faults which truth did not notice in data/tables/faults.csv, in files that begin with one of these,
    /// with a comma between them; OUT has what became of them in again.csv
    #[arg(long, value_name = "PATH")]
    again: Option<String>,
    /// Where the table, the copy of the workspace and its build go
    #[arg(long, default_value = "target/mutants")]
    out: PathBuf,
}

/// Whether enough of the drawn faults are noticed, and none that is known to be harmless.
pub(crate) fn run(arguments: &Arguments) -> Result<bool, Box<dyn Error>> {
    let start = Instant::now();
    let survivors = Known::read(&in_workspace("data/mutants.toml"))?;
    fs::create_dir_all(&arguments.out)?;
    let out = fs::canonicalize(&arguments.out)?;
    let (sources, mut all) = draw::shuffled(&in_workspace("."), arguments.seed)?;
    let mut sample = arguments.sample;
    if let Some(prefixes) = &arguments.again {
        // Whatever is drawn of today's sources.
        let survivors = score::survivors(&in_workspace("data/tables/faults.csv"), prefixes)?;
        all.retain(|drawn| survivors.contains(&score::label(drawn, &sources)));
        sample = all.len();
    }
    let (copy, refused, drawn) = instrumented(&sources, &all, sample, &out)?;
    let program = Program { path: copy.program(), out: out.clone() };
    let is_told = |number: usize| matches!(all[number].fault.form, Form::Told(_));
    let checks = program.checks(&bite::names(), is_told)?;
    let bar = ProgressBar::new(drawn.len() as u64);
    bar.set_style(summary::style());
    let fared = |&number: &usize| {
        let fared = program.fared(&checks, number).map_err(|error| error.to_string());
        bar.inc(1);
        fared.map(|(seen, seconds)| (number, seen, seconds))
    };
    let fared = drawn.par_iter().map(fared).collect::<Result<Vec<_>, String>>()?;
    bar.finish_and_clear();
    if let Some(rounds) = arguments.search {
        let missed = fared.iter().filter(|(_, seen, _)| !matches!(seen, Seen::Truth { .. })).map(|(number, ..)| *number);
        search(&program, missed, rounds)?;
    }
    let row = |(number, seen, seconds): (usize, Seen, f64)| Row::new(&all[number], &sources, seen, seconds, &survivors);
    let rows: Vec<Row> = fared.into_iter().map(row).collect();
    score::write(&rows, arguments.seed, &out.join(if arguments.again.is_some() { "again.csv" } else { "drawn.csv" }))?;
    let summary = Summary::new(&rows, [arguments.seed, refused as u64], start.elapsed().as_secs_f64());
    if arguments.summary {
        println!("{}", serde_json::to_string(&summary)?);
    } else {
        println!("{}", score::printed(&summary));
    }
    if summary.is_too_low() {
        eprintln!("VIOLATED it is no chance that less than {NOTICED} of the faults that are not harmless are noticed");
    }
    Ok(!summary.is_too_low())
}

/// The copy with the first `count` faults that compile; how many before the last of them do not; and which they are.
fn instrumented(
    sources: &[Source],
    all: &[Drawn],
    count: usize,
    out: &Path,
) -> Result<(Copy, usize, Vec<usize>), Box<dyn Error>> {
    let mut copy = Copy::new(&in_workspace("."), out)?;
    let (mut refused, mut compiled) = (BTreeSet::new(), 0);
    // The compiler stops at the first crate that is wrong, so that more are tried at once than are wanted.
    while compiled - refused.range(..compiled).count() < count && compiled < all.len() {
        let missing = count + refused.len() - compiled;
        compiled = all.len().min(compiled + missing + missing / 2 + 8);
        refuse(&mut copy, sources, all, compiled, &mut refused)?;
    }
    let drawn: Vec<usize> = (0..compiled).filter(|number| !refused.contains(number)).take(count).collect();
    copy.plant(sources, drawn.iter().map(|&number| (number, &all[number])))?;
    let in_vain = copy.refused(&["build", "--example", "bite"])?;
    if let Some(number) = in_vain.first() {
        return Err(format!("a fault that is checked does not compile: {:?}", all[*number]).into());
    }
    let last = drawn.last().copied().unwrap_or(0);
    Ok((copy, refused.range(..last).count(), drawn))
}

/// Leaves out what does not compile of the first faults, until all of the rest do.
fn refuse(
    copy: &mut Copy,
    sources: &[Source],
    all: &[Drawn],
    compiled: usize,
    refused: &mut BTreeSet<usize>,
) -> Result<(), Box<dyn Error>> {
    loop {
        let tried = (0..compiled).filter(|number| !refused.contains(number));
        copy.plant(sources, tried.map(|number| (number, &all[number])))?;
        let more = copy.refused(&["check", "--lib"])?;
        if more.is_empty() {
            return Ok(());
        }
        refused.extend(more);
    }
}

/// Cases in which faults break a bound, with how near they come to it without.
fn search(program: &Program, faults: impl Iterator<Item = usize>, rounds: u64) -> Result<(), Box<dyn Error>> {
    let mut lines = Vec::new();
    for fault in faults {
        for line in program.searched(fault, rounds)? {
            let mut witness: Witness = serde_json::from_str(&line)?;
            let asked = witness.ask.check(&witness.case);
            if let Some(held) = asked.held.iter().find(|held| held.place == witness.place) {
                (witness.ratio, witness.bound) = (held.ratio, held.bound);
                lines.push(serde_json::to_string(&witness)?);
            }
        }
    }
    Ok(files::write(&program.out.join("witnesses.jsonl"), lines.join("\n") + "\n")?)
}
