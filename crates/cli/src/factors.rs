//! `radgrad factors`: the form factors of a scene.

mod formats;

use std::io::{self, Write};
use std::ops::Range;
use std::path::PathBuf;
use std::time::Instant;

use radgrad_scene::{Entry, Error, Factor, FactorMatrix, FactorSettings, FormFactors, Materials, Repaired, Scene, largest};
use serde_json::json;

use crate::output::{self, Unwritten};
use crate::say::say;
use crate::scene::{SceneFile, progress};
use formats::Format;

/// What `radgrad factors` is asked for.
#[derive(Debug, clap::Args)]
pub(crate) struct Arguments {
    #[command(flatten)]
    scene: SceneFile,
    /// Print one JSON object: faces, seconds, closure, reciprocity, the worst bound and what is not met.
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
    /// --tolerance.
    #[arg(long)]
    estimate: Option<f64>,
    /// Move factors the least, inside their brackets and reciprocal as they are, until the rows of a closed scene sum to 1.
    #[arg(long, conflicts_with = "rows")]
    repair: bool,
    /// Block i of n blocks of rows, into a .csv: written one after the other the blocks are the whole file, byte for byte.
    #[arg(long, value_name = "I/N", value_parser = block)]
    rows: Option<[usize; 2]>,
    /// One factor as well as it can be known: from this surface ...
    #[arg(long, value_name = "SURFACE", requires = "to", conflicts_with_all = ["out", "repair", "rows", "estimate"])]
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

/// Writes what is asked for; whether all bounds are met.
pub(crate) fn run(arguments: &Arguments) -> Result<bool, Failure> {
    let started = Instant::now();
    // What cannot be written is refused before anything is computed.
    let out = arguments.out.as_deref().map(|file| Ok::<_, Failure>((file, Format::of(file)?))).transpose()?;
    if let (Some(_), Some((file, format))) = (arguments.rows, &out)
        && *format != Format::Csv
    {
        return Err(Failure::Block((*file).to_owned()));
    }
    let estimate = arguments.estimate.unwrap_or(3e-3 * arguments.tolerance);
    for (option, value) in [("tolerance", arguments.tolerance), ("relative", arguments.relative), ("estimate", estimate)] {
        if !(0.0..=1.0).contains(&value) {
            return Err(Failure::Share { option, value });
        }
    }
    out.iter().try_for_each(|(file, _)| output::check(file))?;
    let scene = arguments.scene.read(Materials::Optional)?;
    let settings = FactorSettings {
        tolerance: arguments.tolerance,
        relative: arguments.relative,
        most_cells: arguments.cells,
        estimate,
        ..FactorSettings::default()
    };
    let factors = FormFactors::new(&scene)?;
    if let (Some(from), Some(to)) = (&arguments.from, &arguments.to) {
        return one(arguments, &factors, [from, to], &settings);
    }
    let rows = factors.faces().len();
    let block = arguments.rows.map_or(0..rows, |[i, n]| rows_of(rows, i, n));
    let bar = progress(block.len());
    let mut matrix = factors.rows(block, &settings, || bar.inc(1))?;
    bar.finish_and_clear();
    finite(&matrix)?;
    let repaired = if arguments.repair { Some(matrix.repair()?) } else { None };
    let seconds = started.elapsed().as_secs_f64();
    if let Some((file, format)) = out {
        let first = arguments.rows.is_none_or(|[i, _]| i == 1);
        formats::write(file, format, &scene, &arguments.scene.path, &matrix, first)?;
    }
    let unmet: Vec<(usize, Entry)> = matrix.unmet(&settings).collect();
    let text = if arguments.summary {
        summary(&scene, &matrix, &settings, repaired, unmet.len(), seconds)
    } else {
        report(&scene, &matrix, &settings, repaired, unmet.len(), seconds)
    };
    writeln!(io::stdout().lock(), "{text}").map_err(Failure::Summary)?;
    list(&scene, unmet);
    Ok(matrix.unmet(&settings).next().is_none())
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
    let rough = FactorSettings { estimate: 1e-4, most_cells: 1, ..*settings };
    let guess = sum(factors, [from, to], &rough)?;
    // Where nothing is seen at a glance, the bracket says how much that can be.
    let size = if guess.value > 0.0 { guess.value } else { guess.upper };
    let precise = FactorSettings { estimate: (0.5 * digits * size).max(1e-16), most_points: POINTS_OF_ONE, ..*settings };
    let found = sum(factors, [from, to], &precise)?;
    let seconds = started.elapsed().as_secs_f64();
    let is_met = found.error <= settings.allowed(found.lower) && found.estimate <= digits * found.value;
    let Factor { value, lower, upper, error, estimate, occluders } = found;
    let text = if arguments.summary {
        json!({
            "from": names[0], "to": names[1], "factor": value, "lower": lower, "upper": upper, "error": error,
            "estimate": estimate, "occluders": occluders, "seconds": seconds,
        })
        .to_string()
    } else {
        let places = usize::from(arguments.digits).max(2) - 1;
        format!(
            "from {} to {}: {value:.places$e}\n\
             off by about        {estimate:.1e}   ({})\n\
             proven bracket      [{lower}, {upper}]",
            names[0],
            names[1],
            if occluders == 0 { "proven, in free sight" } else { "estimated: the difference of two rules" },
        )
    };
    writeln!(io::stdout().lock(), "{text}").map_err(Failure::Summary)?;
    if !is_met {
        say(format_args!("not met: {} digits and a bound of {}", arguments.digits, settings.allowed(lower)));
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

fn summary(
    scene: &Scene,
    matrix: &FactorMatrix,
    settings: &FactorSettings,
    repaired: Option<Repaired>,
    unmet: usize,
    seconds: f64,
) -> String {
    let mut object = json!({
        "faces": matrix.faces().len(),
        "surfaces": scene.surfaces().len(),
        "factors": matrix.entries().count(),
        "seconds": seconds,
        "tolerance": settings.tolerance,
        "relative": settings.relative,
        "unmet": unmet,
        "worst_closure": matrix.worst_closure(),
        "rows_that_cannot_close": matrix.unclosed().count(),
        "worst_reciprocity": matrix.worst_reciprocity(),
        "worst_bound": matrix.worst_bound(),
        "worst_bound_in_free_sight": free_sight(matrix),
    });
    if let Some(repaired) = repaired {
        object["repaired"] = json!({ "largest": repaired.largest, "mean": repaired.mean, "closure": repaired.closure });
    }
    object.to_string()
}

fn report(
    scene: &Scene,
    matrix: &FactorMatrix,
    settings: &FactorSettings,
    repaired: Option<Repaired>,
    unmet: usize,
    seconds: f64,
) -> String {
    let count = matrix.entries().count();
    let obstructed = matrix.entries().filter(|(_, entry)| entry.occluders > 0).count();
    let asked = if settings.relative > 0.0 {
        format!("{} or {} of the factor", settings.tolerance, settings.relative)
    } else {
        settings.tolerance.to_string()
    };
    let mut text = format!(
        "{} faces of {} surfaces, {count} factors, {obstructed} of them past occluders, in {seconds:.3} s\n\
         worst closure       {:.1e}   (largest |1 - sum of a row|); {} rows cannot be closed within their bounds\n\
         worst reciprocity   {:.1e}   (largest |A_i F_ij - A_j F_ji| over the smaller of the two areas)\n\
         worst bound         {:.1e}   (in free sight {:.1e}); {unmet} of {count} are over {asked}",
        matrix.faces().len(),
        scene.surfaces().len(),
        matrix.worst_closure(),
        matrix.unclosed().count(),
        matrix.worst_reciprocity(),
        matrix.worst_bound(),
        free_sight(matrix),
    );
    if let Some(Repaired { largest, mean, pair: [from, to], .. }) = repaired {
        text += &format!("\nrepaired            {largest:.1e}   (largest change, from {from} to {to}; {mean:.1e} in the mean)");
    }
    text
}

fn free_sight(matrix: &FactorMatrix) -> f64 {
    matrix.entries().filter(|(_, entry)| entry.occluders == 0).map(|(_, entry)| entry.error).fold(0.0, largest)
}
