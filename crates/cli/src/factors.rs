//! `radgrad factors`: the form factors of a scene.

mod ahead;
mod by_rays;
mod formats;
pub(crate) mod kept;
mod npz;
mod one;
mod said;

use std::fmt::Display;
use std::io::{self, Write};
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::time::Instant;

use radgrad_scene::output::{self, Unwritten};
use radgrad_scene::{Entry, Error, FactorMatrix, FactorSettings, FormFactors, Materials, Narrowed, Scene};
use serde::Serialize;

use crate::places;
use crate::resume::fingerprint;
use crate::say::say;
use crate::scene::SceneFile;
use ahead::Progress;
use formats::{Format, Table};
use kept::Kept;
use one::{Asked, OneFactor};
use said::Summary;

/// Options of `radgrad factors`.
#[derive(Debug, clap::Args)]
pub(crate) struct Arguments {
    #[command(flatten)]
    scene: SceneFile,
    /// Print one JSON object: faces, seconds, closure, the worst rows, reciprocity, the worst bound and the number of factors not met.
    #[arg(long)]
    summary: bool,
    /// Write the factors: .csv has a line a factor between faces, with its bracket; .mtx is Matrix Market and .npz
    /// `SciPy`'s compressed rows, both by face; .txt or .out is `View3D`'s text and .idf are `EnergyPlus`' user view factors, both by surface. Bounds of
    /// .mtx, .txt and .out go to a second file, as NAME.bounds.txt.
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
    /// In a .csv, end the factors of each face with a line to a face `open`: 1 less their sum, the share of its view that no face
    /// has.
    #[arg(long, requires = "out")]
    open: bool,
    /// Absolute bound that is asked of each factor [default: 0.001]. Where one is not met, it is listed and the exit status is 1. By rays, the
    /// half-width of the widest interval [default: 0.01].
    #[arg(long)]
    tolerance: Option<f64>,
    /// Bound that is asked of each factor over itself; the larger of the two counts [default: 0].
    #[arg(long)]
    relative: Option<f64>,
    /// Pairs of cells that the bracket of one factor past occluders may take, at most 1000000000. By default 40000, then twice as many
    /// again and again for those that are not met, up to 4000000 more for the whole scene; for one factor by --from, 1000000.
    #[arg(long, value_parser = count)]
    cells: Option<usize>,
    /// Error down to which the value of a factor past occluders is integrated, in its bracket: an estimate. By default 3e-3 of
    /// --tolerance, or a tenth of --tolerance over what the factor were with nothing in between, whichever is larger.
    #[arg(long)]
    estimate: Option<f64>,
    /// Move factors the least, inside their brackets and reciprocal as they are, until the rows of a closed scene sum to 1.
    #[arg(long, conflicts_with = "rows")]
    repair: bool,
    /// Block i of n blocks of rows, into a .csv: written one after the other the blocks are the whole file, byte for byte, if all
    /// bounds are met.
    #[arg(long, value_name = "I/N", value_parser = block)]
    rows: Option<[usize; 2]>,
    /// Keep each row here as soon as it is computed, and go on where a run before that wrote this file was interrupted: for the
    /// same scene, block and settings, to the same bytes in the end.
    #[arg(long, value_name = "FILE")]
    resume: Option<PathBuf>,
    /// One factor as well as it can be known: from this surface ...
    #[arg(long, value_name = "SURFACE", requires = "to", conflicts_with_all = ["out", "repair", "rows", "resume", "estimate"])]
    from: Option<String>,
    /// ... to this one. The exit status is 0 where the digits or the bound that are asked for are reached, or one of them by default.
    #[arg(long, value_name = "SURFACE", requires = "from")]
    to: Option<String>,
    /// Significant digits that are asked of it, past occluders estimated; its bracket is proven as far as --tolerance and --cells go [default: 6].
    #[arg(long, requires = "from", value_parser = clap::value_parser!(u8).range(1..=15))]
    digits: Option<u8>,
    /// Points that its digits may take past occluders, at most 1000000000 [default: 30000].
    #[arg(long, requires = "from", value_parser = count)]
    points: Option<usize>,
    #[command(flatten)]
    by_rays: by_rays::Options,
}

/// The largest count.
const MOST: usize = 1_000_000_000;

/// A count that may be multiplied without exceeding an integer.
fn count(text: &str) -> Result<usize, String> {
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
    #[error(transparent)]
    Same(#[from] places::Same),
    #[error("`{}`: factors are written to a name ending in .csv, .mtx, .npz, .txt, .out or .idf", .0.display())]
    Format(PathBuf),
    #[error("`{}`: a block of rows is written to a name ending in .csv", .0.display())]
    Block(PathBuf),
    #[error("`{}`: --open adds lines to a name ending in .csv", .0.display())]
    Open(PathBuf),
    #[error("`{}`: factors by rays are those of faces: name a file that ends in .csv, .mtx or .npz, or ask for --method brackets", .0.display())]
    ByFace(PathBuf),
    #[error("--rows by rays counts rows that --resume FILE keeps: name that file, and write with --join when all are counted")]
    Part,
    #[error("--{option} goes with --method {of}: leave it out, or ask for that method")]
    OtherMethod { option: &'static str, of: &'static str },
    #[error("--{rays} goes with --method rays and --{brackets} with --method brackets: leave one of them out")]
    Together { rays: &'static str, brackets: &'static str },
    #[error("--{option} is {value}: it must be between 0 and 1")]
    Share { option: &'static str, value: f64 },
    #[error("cannot write the summary: {0}")]
    Summary(#[source] io::Error),
}

/// Pairs of cells beyond those of [`FactorSettings::most_cells`] that the factors which are not met may take, in all.
const EFFORT: usize = 4_000_000;

/// Factors that are listed one by one.
const LISTED: usize = 20;

/// Computes and writes the factors; whether all bounds are met.
pub(crate) fn run(arguments: &Arguments) -> Result<bool, Failure> {
    let started = Instant::now();
    // What cannot be written is refused before anything is computed.
    let out = arguments.out.as_deref().map(|file| Ok::<_, Failure>((file, Format::of(file)?))).transpose()?;
    if let Some((file, _)) = out.filter(|(_, format)| *format != Format::Csv) {
        if arguments.rows.is_some() {
            return Err(Failure::Block(file.to_owned()));
        }
        if arguments.open {
            return Err(Failure::Open(file.to_owned()));
        }
    }
    let settings = settings(arguments)?;
    let outputs = out.iter().flat_map(|(file, format)| formats::files(file, *format)).map(|file| ("out", file));
    let outputs: Vec<_> = outputs.chain(arguments.resume.clone().map(|file| ("resume", file))).collect();
    places::check((&arguments.scene.path, arguments.scene.budget), &arguments.by_rays.inputs(), &outputs)?;
    outputs.iter().try_for_each(|(_, file)| output::check(file))?;
    let scene = arguments.scene.read(Materials::Optional)?;
    let factors = FormFactors::new(&scene)?;
    factors.warnings().for_each(say);
    if let (Some(from), Some(to)) = (&arguments.from, &arguments.to) {
        let asked = asked_of_one(arguments, &settings);
        let found = OneFactor::find(&factors, [from, to], asked)?.after(started.elapsed().as_secs_f64());
        print(&found, arguments.summary)?;
        let unmet = found.unmet();
        unmet.iter().for_each(say);
        return Ok(unmet.is_empty());
    }
    let rows = factors.faces().len();
    if by_rays::are_chosen(arguments, rows)? {
        return by_rays::run(&factors, arguments, out, started).map(|()| true);
    }
    let block = arguments.rows.map_or(0..rows, |[i, n]| rows_of(rows, i, n));
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
    ahead::announce(&factors, block.len(), block.len().saturating_sub(computed.len()), &narrower)?;
    let progress = Progress::new(block.len(), computed.len());
    let found = factors.rows_from(block, &narrower, computed, |row| {
        kept.iter().for_each(|kept| kept.keep(row));
        progress.row();
    });
    progress.end();
    let mut matrix = found?;
    kept.map_or(Ok(()), Kept::close)?;
    let narrowed = factors.narrow(&mut matrix, &narrower, if arguments.cells.is_none() { EFFORT } else { 0 })?;
    finite(&matrix)?;
    let repaired = if arguments.repair { Some(matrix.repair(&settings)?) } else { None };
    let seconds = started.elapsed().as_secs_f64();
    if let Some((file, format)) = out {
        let table = Table { first: arguments.rows.is_none_or(|[i, _]| i == 1), open: arguments.open };
        formats::write(file, format, &scene, &arguments.scene.path, &matrix, table)?;
    }
    let unmet: Vec<(usize, Entry)> = matrix.unmet(&settings).collect();
    print(&Summary::of(&factors, &matrix, &settings, repaired, seconds), arguments.summary)?;
    if arguments.rows.is_none() && matrix.entries().next().is_none() {
        say("no face sees another: all factors are 0");
    }
    let is_met = unmet.is_empty();
    if !is_met {
        list(&scene, unmet, narrowed);
    }
    Ok(is_met)
}

/// Writes factors that a caller has of a scene that may be in no file.
pub(crate) fn written(matrix: &FactorMatrix, scene: &Scene, file: &Path, open: bool) -> Result<(), Failure> {
    let format = Format::of(file)?;
    if open && format != Format::Csv {
        return Err(Failure::Open(file.to_owned()));
    }
    finite(matrix)?;
    formats::write(file, format, scene, Path::new(scene.title().unwrap_or("scene")), matrix, Table { first: true, open })
}

/// What is asked of one factor.
fn asked_of_one(arguments: &Arguments, settings: &FactorSettings) -> Asked {
    let FactorSettings { tolerance, relative, .. } = *settings;
    Asked {
        digits: arguments.digits.unwrap_or(one::DIGITS),
        tolerance,
        relative,
        points: arguments.points.unwrap_or(one::POINTS),
        cells: arguments.cells.unwrap_or(one::CELLS),
        wants: [arguments.digits.is_some(), arguments.tolerance.is_some() || arguments.relative.is_some()],
    }
}

/// The settings that are asked for, each a share from 0 to 1.
fn settings(arguments: &Arguments) -> Result<FactorSettings, Failure> {
    let usual = FactorSettings::default();
    let [tolerance, relative] = [arguments.tolerance.unwrap_or(usual.tolerance), arguments.relative.unwrap_or(usual.relative)];
    let most_cells = arguments.cells.unwrap_or(usual.most_cells);
    let estimate = arguments.estimate.unwrap_or(3e-3 * tolerance);
    for (option, value) in [("tolerance", tolerance), ("relative", relative), ("estimate", estimate)] {
        if !(0.0..=1.0).contains(&value) {
            return Err(Failure::Share { option, value });
        }
    }
    // `--estimate` is absolute: it replaces both defaults.
    let relative_estimate = if arguments.estimate.is_some() { 0.0 } else { 0.1 * tolerance };
    Ok(FactorSettings { tolerance, relative, most_cells, estimate, relative_estimate, ..usual })
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

/// The factors whose bounds are not met, the worst first, and what would meet them.
fn list(scene: &Scene, mut unmet: Vec<(usize, Entry)>, narrowed: Narrowed) {
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
    let Narrowed { spent, most_cells, wanted } = narrowed;
    // Rounded up.
    let worst = 1.005 * unmet.first().map_or(0.0, |(_, entry)| entry.error);
    let cells = match wanted {
        // Above this the option is refused.
        wanted if wanted > 0.0 && wanted <= MOST as f64 => {
            let powers = std::iter::successors(Some(1_usize), |power| power.checked_mul(2));
            let wanted = powers.take_while(|power| *power < MOST).find(|power| *power as f64 >= wanted).unwrap_or(MOST);
            format!("by how brackets narrow --cells {wanted} would do, ")
        }
        _ => "more --cells would not do, ".to_owned(),
    };
    say(format_args!(
        "not met: {} factors with up to {most_cells} pairs of cells each and {spent} more in all: {cells}and all meet \
         --tolerance {worst:.2e}",
        unmet.len()
    ));
}
