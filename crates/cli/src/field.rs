//! `radgrad field`: the irradiance of a surface by the lamps alone, or by another surface, with gradient and bound.

mod picture;
pub(crate) use picture::{Canvas, colour};
mod vtu;

use std::io::Write;
use std::path::{Path, PathBuf};

use radgrad_core::DEFAULT_TOLERANCE;
use radgrad_scene::output::{self, Unwritten, extension, write_whole};
use radgrad_scene::{Error, FieldCell, FormFactors, Materials, Quantity, Scene};

use crate::scene::{SceneFile, progress};

/// The options of `radgrad field`.
#[derive(Debug, clap::Args)]
pub(crate) struct Arguments {
    #[command(flatten)]
    scene: SceneFile,
    /// Name of the surface that receives.
    #[arg(long, value_name = "SURFACE")]
    on: String,
    /// Cells along each side of each of its faces.
    #[arg(long, value_name = "N")]
    grid: usize,
    /// Where to write: .csv, .vtu (for `ParaView`) or .png (value, gradient and bound in colours).
    #[arg(long, value_name = "FILE")]
    out: PathBuf,
    /// The factor to this surface, instead of the irradiance from all lamps.
    #[arg(long, value_name = "SURFACE")]
    of: Option<String>,
    /// Channel of the lamps' radiance; the first if left out.
    #[arg(long)]
    channel: Option<String>,
    /// Relative error that is allowed.
    #[arg(long, default_value_t = DEFAULT_TOLERANCE)]
    tolerance: f64,
}

/// Why there is no field.
#[derive(Debug, thiserror::Error)]
pub(crate) enum Failure {
    #[error(transparent)]
    Scene(#[from] Error),
    #[error(transparent)]
    Unwritten(#[from] Unwritten),
    #[error("`{}`: a field is written to a name ending in .csv, .vtu or .png", .0.display())]
    Format(PathBuf),
    #[error("there is no channel `{channel}`: there are {known}")]
    Channel { channel: String, known: String },
    #[error("`{}` has no lamps in channel `{channel}`: say with --of which surface to look at", scene.display())]
    Dark { scene: PathBuf, channel: String },
    #[error("`{}`: lamp `{surface}` has a texture, whose light is found by `radgrad solve` only", scene.display())]
    Textured { scene: PathBuf, surface: String },
    #[error("`{}`: a picture shows one patch, and the surface has {patches}: write .csv or .vtu", file.display())]
    Picture { file: PathBuf, patches: usize },
}

enum Format {
    Csv,
    Vtu,
    Png,
}

pub(crate) fn run(arguments: &Arguments) -> Result<(), Failure> {
    let format = format_of(&arguments.out)?;
    output::check(&arguments.out)?;
    let needed = if arguments.of.is_none() { Materials::Required } else { Materials::Optional };
    let scene = arguments.scene.read(needed)?;
    let on = scene.surface_named(&arguments.on)?;
    let radiosities = radiosities(&scene, arguments)?;
    let factors = FormFactors::new(&scene)?;
    for warning in factors.warnings() {
        crate::say::say(warning);
    }
    let patches = scene.surfaces()[on].faces().len();
    if matches!(format, Format::Png) && patches != 1 {
        return Err(Failure::Picture { file: arguments.out.clone(), patches });
    }
    let counts = [arguments.grid, arguments.grid, patches];
    arguments.scene.afford("a grid of so many cells", &counts, 4 * size_of::<FieldCell>())?;
    let bar = progress(counts.iter().product());
    let cells = factors.field(on, arguments.grid, &radiosities, arguments.tolerance, || bar.inc(1))?;
    bar.finish_and_clear();
    finite(&cells)?;
    let quantity = match &arguments.of {
        Some(name) => format!("factor to {name}"),
        None => "irradiance by lamps alone".to_owned(),
    };
    let units = if arguments.of.is_some() { ["1", "1/unit of length"] } else { ["pi x radiance", "that/unit of length"] };
    let shown = picture::Shown { quantity: &quantity, surface: &arguments.on, units };
    match format {
        Format::Csv => write_whole(&arguments.out, |out| write_csv(out, &cells))?,
        Format::Vtu => write_whole(&arguments.out, |out| vtu::write(out, &cells))?,
        Format::Png => write_whole(&arguments.out, |out| picture::write(out, &cells, arguments.grid, shown))?,
    }
    Ok(())
}

/// Whether every value is a number, with a bound that is one.
fn finite(cells: &[FieldCell]) -> Result<(), Error> {
    for cell in cells {
        let numbers = [cell.value, cell.value_error, cell.gradient_error];
        if let Some(value) = numbers.into_iter().chain(cell.gradient.to_array()).find(|number| !number.is_finite()) {
            return Err(Error::NotFinite { what: format!("the value or the gradient at {}, or a bound,", cell.centre), value });
        }
    }
    Ok(())
}

/// The faces that give, each with its radiosity.
fn radiosities(scene: &Scene, arguments: &Arguments) -> Result<Vec<(usize, f64)>, Failure> {
    if let Some(name) = &arguments.of {
        let surface = scene.surface_named(name)?;
        return Ok(scene.surfaces()[surface].faces().iter().map(|&face| (face, 1.0)).collect());
    }
    let names = scene.channels();
    let channel = match &arguments.channel {
        None => 0,
        Some(name) => names.iter().position(|channel| channel == name).ok_or_else(|| Failure::Channel {
            channel: name.clone(),
            known: names.iter().map(|name| format!("`{name}`")).collect::<Vec<_>>().join(", "),
        })?,
    };
    if let Some(face) = scene.faces().iter().position(|face| face.chart(Quantity::Radiance).is_some()) {
        let surface = scene.surfaces()[scene.faces()[face].surface()].name().to_owned();
        return Err(Failure::Textured { scene: arguments.scene.path.clone(), surface });
    }
    let radiosity = |face: usize| scene.materials()[scene.faces()[face].material()].emitted_radiosity(channel).unwrap_or(0.0);
    let lamps: Vec<(usize, f64)> =
        (0..scene.faces().len()).map(|face| (face, radiosity(face))).filter(|lamp| lamp.1 > 0.0).collect();
    if lamps.is_empty() {
        return Err(Failure::Dark { scene: arguments.scene.path.clone(), channel: names[channel].clone() });
    }
    Ok(lamps)
}

fn format_of(file: &Path) -> Result<Format, Failure> {
    match extension(file).as_str() {
        "csv" => Ok(Format::Csv),
        "vtu" => Ok(Format::Vtu),
        "png" => Ok(Format::Png),
        _ => Err(Failure::Format(file.to_owned())),
    }
}

fn write_csv(out: impl Write, cells: &[FieldCell]) -> Result<(), csv::Error> {
    let mut table = csv::Writer::from_writer(out);
    let header = ["face", "x", "y", "z", "value", "gradient_x", "gradient_y", "gradient_z", "value_error", "gradient_error"];
    table.write_record(header)?;
    for cell in cells {
        let (p, g) = (cell.centre, cell.gradient);
        let numbers = [p.x, p.y, p.z, cell.value, g.x, g.y, g.z, cell.value_error, cell.gradient_error];
        let record = [cell.face.to_string()].into_iter().chain(numbers.map(|number| format!("{number:?}")));
        table.write_record(record)?;
    }
    table.flush()?;
    Ok(())
}
