//! `radgrad factors`: the form factors of a scene.

use std::io::Write;
use std::path::{Path, PathBuf};
use std::time::Instant;

use radgrad_scene::view3d::{MatrixHeader, write_matrix};
use radgrad_scene::{FactorMatrix, FactorSettings, FormFactors, Quantity, Scene};
use serde_json::json;

use crate::output::{Unwritten, extension, write_whole};
use crate::scene::{SceneFile, progress};

/// What `radgrad factors` is asked for.
#[derive(Debug, clap::Args)]
pub(crate) struct Arguments {
    #[command(flatten)]
    scene: SceneFile,
    /// Print one JSON object: faces, seconds, and the worst closure, reciprocity and bound.
    #[arg(long)]
    summary: bool,
    /// Write the matrix: .csv has a line a factor between faces, with its bound; .txt or .out is `View3D`'s text, by surface.
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
    /// Absolute bound that is asked of each factor: how far brackets past occluders are narrowed and points refined. Smaller takes longer
    /// (where many shadows fall about as its inverse square), up to --cells and --face-points; what is reached is reported.
    #[arg(long, default_value_t = FactorSettings::default().tolerance)]
    tolerance: f64,
    /// Pairs of cells that the bracket of one factor past occluders may take.
    #[arg(long, default_value_t = FactorSettings::default().most_cells)]
    cells: usize,
    /// Points along each side of a cell of a face, 1 to 16; below 3 no cell is divided.
    #[arg(long, default_value_t = FactorSettings::default().points_per_side)]
    points: usize,
    /// Points that a face may have in all.
    #[arg(long, default_value_t = FactorSettings::default().most_points_a_face)]
    face_points: usize,
}

/// Why there are no factors.
#[derive(Debug, thiserror::Error)]
pub(crate) enum Failure {
    #[error(transparent)]
    Scene(#[from] radgrad_scene::Error),
    #[error(transparent)]
    Unwritten(#[from] Unwritten),
    #[error("`{}`: the matrix is written to a name ending in .csv, .txt or .out", .0.display())]
    Format(PathBuf),
    #[error("--{option} is {value}: it must be between 0 and 1")]
    Share { option: &'static str, value: f64 },
    #[error("cannot write the summary: {0}")]
    Summary(#[source] std::io::Error),
}

/// How the matrix is written.
enum Format {
    Csv,
    View3d,
}

pub(crate) fn run(arguments: &Arguments) -> Result<(), Failure> {
    let started = Instant::now();
    // What cannot be written is refused before anything is computed.
    let out = arguments.out.as_deref().map(|file| Ok::<_, Failure>((file, format_of(file)?))).transpose()?;
    if !(0.0..=1.0).contains(&arguments.tolerance) {
        return Err(Failure::Share { option: "tolerance", value: arguments.tolerance });
    }
    let scene = arguments.scene.read()?;
    let settings = FactorSettings {
        tolerance: arguments.tolerance,
        most_cells: arguments.cells,
        points_per_side: arguments.points,
        most_points_a_face: arguments.face_points,
        ..FactorSettings::default()
    };
    let factors = FormFactors::new(&scene)?;
    for warning in factors.warnings() {
        eprintln!("radgrad: {warning}");
    }
    let bar = progress(2 * scene.faces().len());
    let matrix = factors.matrix(&settings, || bar.inc(1))?;
    bar.finish_and_clear();
    let seconds = started.elapsed().as_secs_f64();
    match out {
        Some((file, Format::Csv)) => write_whole(file, |out| write_csv(out, &scene, &matrix))?,
        Some((file, Format::View3d)) => write_whole(file, |out| write_view3d(out, &scene, &matrix))?,
        None => {}
    }
    let mut stdout = std::io::stdout().lock();
    let text = if arguments.summary {
        summary(&factors, &matrix, settings.tolerance, seconds)
    } else {
        report(&scene, &matrix, settings.tolerance, seconds)
    };
    writeln!(stdout, "{text}").map_err(Failure::Summary)
}

fn format_of(file: &Path) -> Result<Format, Failure> {
    match extension(file).as_str() {
        "csv" => Ok(Format::Csv),
        "txt" | "out" => Ok(Format::View3d),
        _ => Err(Failure::Format(file.to_owned())),
    }
}

fn summary(factors: &FormFactors<'_>, matrix: &FactorMatrix, tolerance: f64, seconds: f64) -> String {
    json!({
        "faces": matrix.faces().len(),
        "factors": matrix.entries().count(),
        "seconds": seconds,
        "tolerance": tolerance,
        "bounds_over_tolerance": over(matrix, tolerance),
        "worst_closure": matrix.worst_closure(),
        "worst_reciprocity": matrix.worst_reciprocity(),
        "worst_bound": matrix.worst_bound(),
        "worst_bound_in_free_sight": free_sight(matrix),
        "warnings": factors.warnings().map(ToString::to_string).collect::<Vec<String>>(),
    })
    .to_string()
}

fn report(scene: &Scene, matrix: &FactorMatrix, tolerance: f64, seconds: f64) -> String {
    let obstructed = matrix.entries().filter(|(_, entry)| entry.occluders > 0).count();
    format!(
        "{} faces of {} surfaces, {} factors, {obstructed} of them past occluders, in {seconds:.3} s\n\
         worst closure       {:.1e}   (largest |1 - sum of a row|; an open scene has rows below 1)\n\
         worst reciprocity   {:.1e}   (largest |A_i F_ij - A_j F_ji| over the smaller of the two areas)\n\
         worst bound         {:.1e}   (in free sight {:.1e}); {} of {} bounds are over {tolerance}",
        matrix.faces().len(),
        scene.surfaces().len(),
        matrix.entries().count(),
        matrix.worst_closure(),
        matrix.worst_reciprocity(),
        matrix.worst_bound(),
        free_sight(matrix),
        over(matrix, tolerance),
        matrix.entries().count(),
    )
}

/// How many bounds are wider than what was asked.
fn over(matrix: &FactorMatrix, tolerance: f64) -> usize {
    matrix.entries().filter(|(_, entry)| entry.error > tolerance).count()
}

fn free_sight(matrix: &FactorMatrix) -> f64 {
    matrix.entries().filter(|(_, entry)| entry.occluders == 0).map(|(_, entry)| entry.error).fold(0.0, f64::max)
}

/// A line a factor, faces numbered from 0 in the order of the file.
fn write_csv(out: impl Write, scene: &Scene, matrix: &FactorMatrix) -> Result<(), csv::Error> {
    let mut table = csv::Writer::from_writer(out);
    table.write_record(["from", "from_surface", "to", "to_surface", "factor", "error", "occluders"])?;
    let surface = |face: usize| scene.surfaces()[scene.faces()[face].surface()].name();
    for (from, entry) in matrix.entries() {
        table.write_record([
            &from.to_string(),
            surface(from),
            &entry.face.to_string(),
            surface(entry.face),
            &format!("{:?}", entry.factor),
            &format!("{:e}", entry.error),
            &entry.occluders.to_string(),
        ])?;
    }
    table.flush()?;
    Ok(())
}

/// One minus the mean reflectance stands for the emittance, as in a scene of one channel it is.
fn write_view3d(out: impl Write, scene: &Scene, matrix: &FactorMatrix) -> Result<(), radgrad_scene::Error> {
    let by_surface = matrix.by_surface(scene);
    let emittance = |&surface: &usize| {
        let first = scene.surfaces()[surface].faces().first();
        let channels = scene.channels().len();
        let mean = |&face: &usize| (0..channels).map(|c| scene.mean_over(face, Quantity::Reflectance, c)).sum::<f64>();
        1.0 - first.map_or(0.0, mean) / channels as f64
    };
    let emittances: Vec<f64> = by_surface.surfaces.iter().map(emittance).collect();
    let header = MatrixHeader { enclosure: scene.enclosure().unwrap_or(false), emittances: false };
    write_matrix(out, header, &by_surface.areas, &by_surface.rows, &emittances)
}
