//! Factors of very many faces by rays: counted row by row, kept as they are counted, written row by row.

use std::fmt;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::time::Instant;

use radgrad_scene::output::write_whole;
use radgrad_scene::{Counted, FormFactors, RayEntry, RayFactors, RayRow, RaySettings, Scene, largest};
use serde::Serialize;

use super::ahead::Progress;
use super::formats::{Format, Table};
use super::kept::{self, Kept};
use super::npz::{Rows, Take};
use super::{Arguments, Failure, print, rows_of};
use crate::resume::fingerprint;
use crate::say::say;

/// How factors are found.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub(super) enum Method {
    /// Each in a proven bracket.
    Brackets,
    /// By rays, each in an interval that holds with a stated probability.
    Rays,
}

/// Faces above which rays are the method, if nothing is asked for that brackets alone have.
const MANY: usize = 20_000;

/// Options that go with rays.
#[derive(Debug, clap::Args)]
pub(super) struct Options {
    /// How factors are found: in brackets that are proven, or by rays in intervals that hold with a stated probability, which takes far less time for
    /// very many faces [default: brackets up to 20000 faces, and where --relative, --cells, --estimate or --repair is given; else rays].
    #[arg(long, value_enum)]
    method: Option<Method>,
    /// By rays, the probability with which all intervals hold together [default: 0.99]. The number of rays follows from it and from --tolerance,
    /// which is the half-width of the widest, 0.01 by default.
    #[arg(long, value_name = "SHARE")]
    confidence: Option<f64>,
    /// Rays from each face, in place of the number that follows from --tolerance.
    #[arg(long, value_name = "COUNT", value_parser = clap::value_parser!(u32).range(1..))]
    rays: Option<u32>,
    /// The seed of the rays' random numbers [default: 1].
    #[arg(long)]
    seed: Option<u64>,
    /// By rays, leave out pairs both of whose factors are below this: what they have goes to the rest of their rows, so that rows still sum to 1 with
    /// what is open, and pairs are reciprocal.
    #[arg(long, value_name = "FACTOR")]
    drop_below: Option<f64>,
    /// By rays, rows that runs with --rows kept by --resume: with them all, nothing is counted again.
    #[arg(long, value_name = "FILE", num_args = 1..)]
    join: Vec<PathBuf>,
}

impl Options {
    /// Files that are read.
    pub(super) fn inputs(&self) -> Vec<(&'static str, &Path)> {
        self.join.iter().map(|file| ("join", file.as_path())).collect()
    }

    /// The option that rays alone have, if one is given.
    fn of_rays(&self) -> Option<&'static str> {
        let given = [
            (self.confidence.is_some(), "confidence"),
            (self.rays.is_some(), "rays"),
            (self.seed.is_some(), "seed"),
            (self.drop_below.is_some(), "drop-below"),
            (!self.join.is_empty(), "join"),
        ];
        given.iter().find(|(is_given, _)| *is_given).map(|(_, name)| *name)
    }
}

/// The option that brackets alone have, if one is given.
fn of_brackets(arguments: &Arguments) -> Option<&'static str> {
    let given = [
        (arguments.relative.is_some(), "relative"),
        (arguments.cells.is_some(), "cells"),
        (arguments.estimate.is_some(), "estimate"),
        (arguments.repair, "repair"),
    ];
    given.iter().find(|(is_given, _)| *is_given).map(|(_, name)| *name)
}

/// Whether the factors of so many faces are found by rays.
pub(super) fn are_chosen(arguments: &Arguments, faces: usize) -> Result<bool, Failure> {
    let (of_rays, of_brackets) = (arguments.by_rays.of_rays(), of_brackets(arguments));
    let by_rays = match (arguments.by_rays.method, of_rays, of_brackets) {
        (Some(method), ..) => method == Method::Rays,
        (None, Some(rays), Some(brackets)) => return Err(Failure::Together { rays, brackets }),
        (None, Some(_), None) => true,
        (None, None, brackets) => brackets.is_none() && faces > MANY,
    };
    match (by_rays, of_rays, of_brackets) {
        (true, _, Some(option)) => Err(Failure::OtherMethod { option, of: "brackets" }),
        (false, Some(option), _) => Err(Failure::OtherMethod { option, of: "rays" }),
        _ => Ok(by_rays),
    }
}

/// The settings that are asked for; whether there are so many rays is seen before any is drawn.
fn settings(arguments: &Arguments, faces: usize) -> Result<RaySettings, Failure> {
    let (options, usual) = (&arguments.by_rays, RaySettings::default());
    let settings = RaySettings {
        tolerance: arguments.tolerance.unwrap_or(usual.tolerance),
        confidence: options.confidence.unwrap_or(usual.confidence),
        rays: options.rays,
        seed: options.seed.unwrap_or(usual.seed),
    };
    settings.rays_for(faces)?;
    match options.drop_below.filter(|least| !(0.0..=1.0).contains(least)) {
        Some(value) => Err(Failure::Share { option: "drop-below", value }),
        None => Ok(settings),
    }
}

/// Counts, joins and writes.
pub(super) fn run(
    factors: &FormFactors<'_>,
    arguments: &Arguments,
    out: Option<(&Path, Format)>,
    started: Instant,
) -> Result<(), Failure> {
    let (faces, scene) = (factors.faces(), factors.scene());
    let settings = settings(arguments, faces.len())?;
    if let Some((file, _)) = out.filter(|(_, format)| !matches!(format, Format::Csv | Format::MatrixMarket | Format::Npz)) {
        return Err(Failure::ByFace(file.to_owned()));
    }
    let block = match arguments.rows {
        // Its rows are those of pairs with all the others: they are known when these are.
        Some(_) if out.is_some() || arguments.resume.is_none() => return Err(Failure::Part),
        Some([i, n]) => rows_of(faces.len(), i, n),
        None => 0..faces.len(),
    };
    let rays = settings.rays_for(faces.len())?;
    if arguments.by_rays.method.is_none() {
        let (count, confidence) = (faces.len(), settings.confidence);
        say(format_args!(
            "{count} faces: by {rays} rays from each, in intervals that hold together with a probability of {confidence}; --method brackets proves bounds"
        ));
    }
    let (head, asked) = (fingerprint(scene), format!("{settings:?}"));
    let mut counted: Vec<Counted> = Vec::new();
    for file in &arguments.by_rays.join {
        counted.extend(kept::rows::<Counted>(file, &head, &asked)?);
    }
    let kept = match &arguments.resume {
        Some(file) => {
            let (kept, rows) = Kept::open(file, &head, asked)?;
            counted.extend(rows);
            Some(kept)
        }
        None => None,
    };
    // A row in two files is one if both have the same; else it is refused when rows are joined.
    counted.sort_by_key(Counted::face);
    counted.dedup();
    let is_left = |face: &&usize| counted.binary_search_by_key(*face, Counted::face).is_err();
    let queue: Vec<usize> = faces[block.clone()].iter().filter(is_left).copied().collect();
    let progress = Progress::new(block.len(), block.len() - queue.len());
    let answers = factors.count_rays_of(&queue, &settings, |row| {
        kept.iter().for_each(|kept| kept.keep(row));
        progress.row();
    });
    progress.end();
    counted.extend(answers?);
    kept.map_or(Ok(()), Kept::close)?;
    if arguments.rows.is_some() {
        let total = faces.len();
        say(format_args!("{} of {total} rows are counted: --join takes them up", block.len()));
        return Ok(());
    }
    let mut by_rays = factors.by_rays(counted, &settings)?;
    if let Some(least) = arguments.by_rays.drop_below {
        by_rays = by_rays.without_below(least);
    }
    let summary = Summary::of(factors, &by_rays, arguments.by_rays.drop_below, started);
    if let Some((file, format)) = out {
        write(file, format, scene, &by_rays, arguments.open)?;
    }
    print(&Summary { seconds: started.elapsed().as_secs_f64(), ..summary }, arguments.summary)
}

/// Writes the factors row by row.
fn write(file: &Path, format: Format, scene: &Scene, factors: &RayFactors, open: bool) -> Result<(), Failure> {
    match format {
        Format::MatrixMarket => write_whole(file, |out| matrix_market(out, factors))?,
        Format::Npz => write_whole(file, |out| npz(out, factors))?,
        _ => write_whole(file, |out| csv(out, scene, factors, Table { first: true, open }))?,
    }
    Ok(())
}

fn csv(out: impl Write, scene: &Scene, factors: &RayFactors, table: Table) -> Result<(), csv::Error> {
    let mut lines = csv::Writer::from_writer(out);
    if table.first {
        lines.write_record([
            "from",
            "from_surface",
            "to",
            "to_surface",
            "factor",
            "interval_low",
            "interval_high",
            "by",
            "area",
        ])?;
    }
    let surface = |face: usize| scene.surfaces()[scene.faces()[face].surface()].name();
    factors.each_row(|RayRow { face, entries, open }| {
        let area = format!("{:?}", scene.faces()[face].polygon().area());
        let from = [face.to_string(), surface(face).to_owned()];
        let mut line = |to: &str, name: &str, entry: &RayEntry| {
            let [factor, low, high] = [entry.factor, entry.lower, entry.upper].map(|number| format!("{number:?}"));
            let by = if entry.is_exact { "closed form" } else { "rays" };
            lines.write_record([&from[0], &from[1], to, name, &factor, &low, &high, by, &area])
        };
        entries.iter().try_for_each(|entry| line(&entry.face.to_string(), surface(entry.face), entry))?;
        if table.open { line("open", "open", &open) } else { Ok(()) }
    })?;
    lines.flush()?;
    Ok(())
}

/// Coordinates from 1, by face, values alone.
fn matrix_market(mut out: impl Write, factors: &RayFactors) -> Result<(), std::io::Error> {
    let (count, rays, confidence) = (factors.len(), factors.rays(), factors.confidence());
    writeln!(out, "%%MatrixMarket matrix coordinate real general")?;
    writeln!(out, "% row i, column j: from face i to face j of the scene, counted from 1")?;
    writeln!(
        out,
        "% by {rays} rays from each face; a .csv has the intervals, which hold together with a probability of {confidence}"
    )?;
    writeln!(out, "{count} {count} {}", factors.stored())?;
    factors.each_row(|RayRow { face, entries, .. }| {
        entries.iter().try_for_each(|entry| writeln!(out, "{} {} {:e}", face + 1, entry.face + 1, entry.factor))
    })
}

/// Values alone, by face, and what is open.
fn npz(out: impl Write, factors: &RayFactors) -> Result<(), std::io::Error> {
    let each = |row: Take<'_>| {
        factors.each_row(|RayRow { face, entries, .. }| row(face, entries.iter().map(|entry| (entry.face, entry.factor)).unzip()))
    };
    let open = (0..factors.len()).map(|face| factors.open(face)).collect();
    Rows { faces: factors.len(), numbers: factors.stored(), open, each: &each }.write(out)
}

/// The summary of factors by rays.
#[derive(Debug, Serialize)]
struct Summary {
    method: &'static str,
    faces: usize,
    surfaces: usize,
    factors: usize,
    in_closed_form: usize,
    rays_a_face: u64,
    seconds: f64,
    confidence: f64,
    /// Half the width of the widest interval of a factor.
    widest_interval: f64,
    /// The upper limit of a factor that is not stored, with that confidence.
    absent_at_most: f64,
    #[serde(skip_serializing_if = "Option::is_none")]
    dropped_below: Option<f64>,
    /// The largest share of a view that no face has.
    most_open: f64,
    /// In the mean of the faces.
    mean_open: f64,
    warnings: Vec<String>,
}

impl Summary {
    fn of(factors: &FormFactors<'_>, found: &RayFactors, dropped_below: Option<f64>, started: Instant) -> Self {
        let opens: Vec<f64> = found.faces().iter().map(|face| found.open(*face)).collect();
        Self {
            method: "rays",
            faces: found.faces().len(),
            surfaces: factors.scene().surfaces().len(),
            factors: found.stored(),
            in_closed_form: found.exact(),
            rays_a_face: found.rays(),
            seconds: started.elapsed().as_secs_f64(),
            confidence: found.confidence(),
            widest_interval: found.widest(),
            absent_at_most: found.absent(),
            dropped_below,
            most_open: opens.iter().copied().fold(0.0, largest),
            mean_open: opens.iter().sum::<f64>() / opens.len().max(1) as f64,
            warnings: factors.warnings().map(ToString::to_string).collect(),
        }
    }
}

impl fmt::Display for Summary {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let &Self { faces, surfaces, factors, in_closed_form, rays_a_face, seconds, confidence, .. } = self;
        writeln!(
            f,
            "{faces} faces of {surfaces} surfaces, {factors} factors by {rays_a_face} rays from each face, {in_closed_form} of them in \
             closed form, in {seconds:.3} s"
        )?;
        writeln!(
            f,
            "widest interval     {:.1e}   (half-width; all hold together with a probability of {confidence}: no bounds)",
            self.widest_interval
        )?;
        writeln!(f, "not stored          {:.1e}   (what such a factor is at most, likewise)", self.absent_at_most)?;
        write!(f, "open                {:.4}   (largest share of a view; {:.4} in the mean)", self.most_open, self.mean_open)
    }
}
