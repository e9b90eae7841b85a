//! `radgrad factors`: the form factors of a scene.

mod formats;
mod kept;
mod said;

use std::fmt::Display;
use std::io::{self, Write};
use std::ops::Range;
use std::path::PathBuf;
use std::time::Instant;

use radgrad_scene::output::{self, Unwritten};
use radgrad_scene::{Entry, Error, Factor, FactorMatrix, FactorSettings, FormFactors, Materials, Scene};
use serde::Serialize;

use crate::resume::fingerprint;
use crate::say::say;
use crate::scene::{SceneFile, progress};
use formats::Format;
use kept::Kept;
use said::{OneFactor, Summary};

/// Options of `radgrad factors`.
#[derive(Debug, clap::Args)]
pub(crate) struct Arguments {
    #[command(flatten)]
    scene: SceneFile,
    /// Print one JSON object: faces, seconds, closure, reciprocity, the worst bound and the number of factors not met.
    #[arg(long)]
    summary: bool,
    /// Write the factors: .csv has a line a factor between faces, with its bracket; .mtx is Matrix Market, by face; .txt or .out
    /// is `View3D`'s text and .idf are `EnergyPlus`' user view factors, both by surface. Bounds of .mtx, .txt and .out go to a second
    /// file, as NAME.bounds.txt.
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
    /// Absolute bound that is asked of each factor. Where one is not met, for --cells, it is listed and the exit status is 1.
    #[arg(long, default_value_t = FactorSettings::default().tolerance)]
    tolerance: f64,
    /// Bound that is asked of each factor over itself; the larger of the two counts.
    #[arg(long, default_value_t = FactorSettings::default().relative)]
    relative: f64,
    /// Pairs of cells that the bracket of one factor past occluders may take, at most 1000000000.
    #[arg(long, default_value_t = FactorSettings::default().most_cells, value_parser = count)]
    cells: usize,
    /// Error down to which the value of a factor past occluders is integrated, in its bracket: an estimate. By default 3e-3 of
    /// --tolerance, or a tenth of --tolerance over what the factor were with nothing in between, whichever is larger.
    #[arg(long)]
    estimate: Option<f64>,
    /// Move factors the least, inside their brackets and reciprocal as they are, until the rows of a closed scene sum to 1.
    #[arg(long, conflicts_with = "rows")]
    repair: bool,
    /// Block i of n blocks of rows, into a .csv: written one after the other the blocks are the whole file, byte for byte.
    #[arg(long, value_name = "I/N", value_parser = block)]
    rows: Option<[usize; 2]>,
    /// Keep each row here as soon as it is computed, and go on where a run before that wrote this file was interrupted: for the
    /// same scene, block and settings, to the same bytes in the end.
    #[arg(long, value_name = "FILE")]
    resume: Option<PathBuf>,
    /// One factor as well as it can be known: from this surface ...
    #[arg(long, value_name = "SURFACE", requires = "to", conflicts_with_all = ["out", "repair", "rows", "resume", "estimate"])]
    from: Option<String>,
    /// ... to this one.
    #[arg(long, value_name = "SURFACE", requires = "from")]
    to: Option<String>,
    /// Significant digits that are asked of it, estimated; its bracket is proven as far as --tolerance and --cells go.
    #[arg(long, default_value_t = 12, requires = "from", value_parser = clap::value_parser!(u8).range(1..=15))]
    digits: u8,
}

/// A count that may be multiplied without exceeding an integer.
fn count(text: &str) -> Result<usize, String> {
    const MOST: usize = 1_000_000_000;
    let value = text.parse::<usize>().map_err(|error| error.to_string())?;
    if value <= MOST { Ok(value) } else { Err(format!("{value} is above {MOST}")) }
}

/// Why there are no factors.
#[derive(Debug, thiserror::Error)]
pub(crate) enum Failure {
    #[error(transparent)]
    Scene(#[from] Error),
    #[error(transparent)]
    Unwritten(#[from] Unwritten),
    #[error(transparent)]
    Kept(#[from] kept::Failure),
    #[error("`{}`: factors are written to a name ending in .csv, .mtx, .txt, .out or .idf", .0.display())]
    Format(PathBuf),
    #[error("`{}`: a block of rows is written to a name ending in .csv", .0.display())]
    Block(PathBuf),
    #[error("--{option} is {value}: it must be between 0 and 1")]
    Share { option: &'static str, value: f64 },
    #[error("cannot write the summary: {0}")]
    Summary(#[source] io::Error),
}

/// Points that one factor may take.
const POINTS_OF_ONE: usize = 1_000_000;

/// Factors that are listed one by one.
const LISTED: usize = 20;

/// Computes and writes the factors; whether all bounds are met.
pub(crate) fn run(arguments: &Arguments) -> Result<bool, Failure> {
    let started = Instant::now();
    // What cannot be written is refused before anything is computed.
    let out = arguments.out.as_deref().map(|file| Ok::<_, Failure>((file, Format::of(file)?))).transpose()?;
    if let (Some(_), Some((file, format))) = (arguments.rows, &out)
        && *format != Format::Csv
    {
        return Err(Failure::Block((*file).to_owned()));
    }
    let settings = settings(arguments)?;
    out.iter().try_for_each(|(file, _)| output::check(file))?;
    let scene = arguments.scene.read(Materials::Optional)?;
    let factors = FormFactors::new(&scene)?;
    factors.warnings().for_each(say);
    if let (Some(from), Some(to)) = (&arguments.from, &arguments.to) {
        return one(arguments, &factors, [from, to], &settings);
    }
    let rows = factors.faces().len();
    let block = arguments.rows.map_or(0..rows, |[i, n]| rows_of(rows, i, n));
    let bar = progress(block.len());
    // A repair moves values away from the middle of their brackets, which are narrower for that.
    let share = if arguments.repair { 0.9 } else { 1.0 };
    let narrower = FactorSettings { tolerance: share * settings.tolerance, relative: share * settings.relative, ..settings };
    let (kept, computed) = match &arguments.resume {
        Some(file) => {
            let asked = format!("rows {block:?} of {rows}, {narrower:?}");
            let (kept, computed) = Kept::open(file, &fingerprint(&scene), asked)?;
            (Some(kept), computed)
        }
        None => (None, Vec::new()),
    };
    bar.inc(computed.len() as u64);
    let found = factors.rows_from(block, &narrower, computed, |row| {
        kept.iter().for_each(|kept| kept.keep(row));
        bar.inc(1);
    });
    bar.finish_and_clear();
    let mut matrix = found?;
    kept.map_or(Ok(()), Kept::close)?;
    finite(&matrix)?;
    let repaired = if arguments.repair { Some(matrix.repair(&settings)?) } else { None };
    let seconds = started.elapsed().as_secs_f64();
    if let Some((file, format)) = out {
        let first = arguments.rows.is_none_or(|[i, _]| i == 1);
        formats::write(file, format, &scene, &arguments.scene.path, &matrix, first)?;
    }
    let unmet: Vec<(usize, Entry)> = matrix.unmet(&settings).collect();
    print(&Summary::of(&factors, &matrix, &settings, repaired, seconds), arguments.summary)?;
    let is_met = unmet.is_empty();
    list(&scene, unmet);
    Ok(is_met)
}

/// The settings that are asked for, each a share from 0 to 1.
fn settings(arguments: &Arguments) -> Result<FactorSettings, Failure> {
    let Arguments { tolerance, relative, cells, .. } = *arguments;
    let estimate = arguments.estimate.unwrap_or(3e-3 * tolerance);
    for (option, value) in [("tolerance", tolerance), ("relative", relative), ("estimate", estimate)] {
        if !(0.0..=1.0).contains(&value) {
            return Err(Failure::Share { option, value });
        }
    }
    // `--estimate` is absolute: it replaces both defaults.
    let relative_estimate = if arguments.estimate.is_some() { 0.0 } else { 0.1 * tolerance };
    Ok(FactorSettings { tolerance, relative, most_cells: cells, estimate, relative_estimate, ..FactorSettings::default() })
}

/// Prints a summary as one JSON object, or as text.
fn print<T: Serialize + Display>(said: &T, as_json: bool) -> Result<(), Failure> {
    let mut out = io::stdout().lock();
    let printed = if as_json {
        serde_json::to_string(said).map_err(io::Error::from).and_then(|text| writeln!(out, "{text}"))
    } else {
        writeln!(out, "{said}")
    };
    printed.map_err(Failure::Summary)
}

/// Whether every factor is a number, with a bound that is one.
fn finite(matrix: &FactorMatrix) -> Result<(), Error> {
    let of_entry = matrix.entries().find(|(_, entry)| !(entry.factor.is_finite() && entry.error.is_finite()));
    if let Some((from, entry)) = of_entry {
        let value = if entry.factor.is_finite() { entry.error } else { entry.factor };
        return Err(Error::NotFinite { what: format!("the factor from face {from} to face {} or its bound", entry.face), value });
    }
    Ok(())
}

/// Block `i` of `n`, from 1.
fn rows_of(rows: usize, i: usize, n: usize) -> Range<usize> {
    let end = |k: usize| usize::try_from(rows as u128 * k as u128 / n as u128).unwrap_or(rows);
    end(i - 1)..end(i)
}

fn block(text: &str) -> Result<[usize; 2], String> {
    let parts = text.split_once('/').and_then(|(i, n)| Some([i.parse::<usize>().ok()?, n.parse().ok()?]));
    parts.filter(|[i, n]| 1 <= *i && i <= n).ok_or_else(|| "expected I/N, a block from 1 to N".to_owned())
}

/// The factors whose bounds are not met, the worst first.
fn list(scene: &Scene, mut unmet: Vec<(usize, Entry)>) {
    unmet.sort_by(|a, b| b.1.error.total_cmp(&a.1.error));
    let surface = |face: usize| scene.surfaces()[scene.faces()[face].surface()].name();
    for (from, entry) in unmet.iter().take(LISTED) {
        let Entry { face, factor, lower, upper, .. } = *entry;
        say(format_args!(
            "not met: from {from} ({}) to {face} ({}): {factor:.6} in [{lower:.6}, {upper:.6}]",
            surface(*from),
            surface(face)
        ));
    }
    if unmet.len() > LISTED {
        say(format_args!("not met: {} more, with their `error` in a .csv", unmet.len() - LISTED));
    }
}

/// One factor between surfaces: that of what all their faces exchange.
fn one(
    arguments: &Arguments,
    factors: &FormFactors<'_>,
    names: [&String; 2],
    settings: &FactorSettings,
) -> Result<bool, Failure> {
    let started = Instant::now();
    let scene = factors.scene();
    let [from, to] = [scene.surface_named(names[0])?, scene.surface_named(names[1])?];
    let mut digits = 1.0;
    (0..arguments.digits).for_each(|_| digits *= 0.1);
    let rough = FactorSettings { estimate: 1e-4, relative_estimate: 0.0, most_cells: 1, ..*settings };
    let guess = sum(factors, [from, to], &rough)?;
    // Where nothing is seen at a glance, the bracket says how much that can be.
    let size = if guess.value > 0.0 { guess.value } else { guess.upper };
    let estimate = (0.5 * digits * size).max(1e-16);
    let precise = FactorSettings { estimate, relative_estimate: 0.0, most_points: POINTS_OF_ONE, ..*settings };
    let found = sum(factors, [from, to], &precise)?;
    let seconds = started.elapsed().as_secs_f64();
    let is_met = found.error <= settings.allowed(found.lower) && found.estimate <= digits * found.value;
    print(&OneFactor::of(found, names.map(String::as_str), arguments.digits, seconds), arguments.summary)?;
    if !is_met {
        say(format_args!("not met: {} digits and a bound of {}", arguments.digits, settings.allowed(found.lower)));
    }
    Ok(is_met)
}

fn sum(factors: &FormFactors<'_>, [from, to]: [usize; 2], settings: &FactorSettings) -> Result<Factor, Failure> {
    let scene = factors.scene();
    let area = scene.area_of(from);
    let mut sum = Factor { value: 0.0, lower: 0.0, upper: 0.0, error: 0.0, estimate: 0.0, occluders: 0 };
    for &a in scene.surfaces()[from].faces() {
        let share = scene.faces()[a].polygon().area() / area;
        for &b in scene.surfaces()[to].faces() {
            let found = factors.between(a, b, settings)?;
            sum.value += share * found.value;
            sum.lower += share * found.lower;
            sum.upper += share * found.upper;
            sum.error += share * found.error;
            sum.estimate += share * found.estimate;
            sum.occluders = sum.occluders.max(found.occluders);
        }
    }
    Ok(sum)
}
