//! How factors are written.

use std::ffi::OsString;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use radgrad_scene::output::{extension, write_whole};
use radgrad_scene::view3d::{MatrixHeader, write_matrix};
use radgrad_scene::{Entry, FactorMatrix, Quantity, Scene, SurfaceFactor, SurfaceMatrix};

use super::Failure;

/// Which program reads it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Format {
    Csv,
    /// Matrix Market: `scipy.io.mmread`, Julia's `MatrixMarket`, MATLAB's `mmread`.
    MatrixMarket,
    View3d,
    EnergyPlus,
}

impl Format {
    pub(super) fn of(file: &Path) -> Result<Self, Failure> {
        match extension(file).as_str() {
            "csv" => Ok(Self::Csv),
            "mtx" => Ok(Self::MatrixMarket),
            "txt" | "out" => Ok(Self::View3d),
            "idf" => Ok(Self::EnergyPlus),
            _ => Err(Failure::Format(file.to_owned())),
        }
    }
}

/// Writes the factors, and a second file with their bounds where the first has no place for them. `first` says whether a table
/// starts with its header.
pub(super) fn write(
    file: &Path,
    format: Format,
    scene: &Scene,
    scene_file: &Path,
    matrix: &FactorMatrix,
    first: bool,
) -> Result<(), Failure> {
    match format {
        Format::Csv => write_whole(file, |out| csv(out, scene, matrix, first))?,
        Format::MatrixMarket => {
            write_whole(file, |out| matrix_market(out, scene, matrix, |entry| entry.factor))?;
            write_whole(&beside(file), |out| matrix_market(out, scene, matrix, |entry| entry.error))?;
        }
        Format::View3d => {
            let by_surface = matrix.by_surface(scene);
            write_whole(file, |out| view3d(out, scene, &by_surface, |found| found.factor))?;
            let bound = |found: &SurfaceFactor| {
                let [above, below] = [found.upper - found.factor, found.factor - found.lower];
                if above > below || above.is_nan() { above } else { below }
            };
            write_whole(&beside(file), |out| view3d(out, scene, &by_surface, bound))?;
        }
        Format::EnergyPlus => write_whole(file, |out| energy_plus(out, scene, scene_file, &matrix.by_surface(scene)))?,
    }
    Ok(())
}

/// `NAME.bounds.EXT` for `NAME.EXT`.
fn beside(file: &Path) -> PathBuf {
    let mut name = file.file_stem().map_or_else(OsString::new, ToOwned::to_owned);
    name.push(".bounds");
    if let Some(extension) = file.extension() {
        name.push(".");
        name.push(extension);
    }
    file.with_file_name(name)
}

/// A line a factor, faces numbered from 0 in the order of the file.
fn csv(out: impl Write, scene: &Scene, matrix: &FactorMatrix, first: bool) -> Result<(), csv::Error> {
    let mut table = csv::Writer::from_writer(out);
    if first {
        table.write_record(["from", "from_surface", "to", "to_surface", "factor", "lower", "upper", "error", "occluders"])?;
    }
    let surface = |face: usize| scene.surfaces()[scene.faces()[face].surface()].name();
    for (from, entry) in matrix.entries() {
        let Entry { face, factor, lower, upper, error, occluders } = entry;
        table.write_record([
            &from.to_string(),
            surface(from),
            &face.to_string(),
            surface(face),
            &format!("{factor:?}"),
            &format!("{lower:?}"),
            &format!("{upper:?}"),
            &format!("{error:e}"),
            &occluders.to_string(),
        ])?;
    }
    table.flush()?;
    Ok(())
}

/// Coordinates from 1, by face; faces that only hide others have empty rows and columns.
fn matrix_market(
    mut out: impl Write,
    scene: &Scene,
    matrix: &FactorMatrix,
    number: impl Fn(&Entry) -> f64,
) -> Result<(), io::Error> {
    let count = scene.faces().len();
    writeln!(out, "%%MatrixMarket matrix coordinate real general")?;
    writeln!(out, "% row i, column j: from face i to face j of the scene, counted from 1")?;
    writeln!(out, "{count} {count} {}", matrix.entries().count())?;
    for (from, entry) in matrix.entries() {
        writeln!(out, "{} {} {:e}", from + 1, entry.face + 1, number(&entry))?;
    }
    Ok(())
}

/// One minus the mean reflectance stands for the emittance, as in a scene of one channel it is.
fn view3d(
    out: impl Write,
    scene: &Scene,
    by_surface: &SurfaceMatrix,
    number: impl Fn(&SurfaceFactor) -> f64,
) -> Result<(), radgrad_scene::Error> {
    let emittance = |&surface: &usize| {
        let first = scene.surfaces()[surface].faces().first();
        let channels = scene.channels().len();
        let mean = |&face: &usize| (0..channels).map(|c| scene.mean_over(face, Quantity::Reflectance, c)).sum::<f64>();
        1.0 - first.map_or(0.0, mean) / channels as f64
    };
    let emittances: Vec<f64> = by_surface.surfaces.iter().map(emittance).collect();
    let header = MatrixHeader { enclosure: scene.enclosure().unwrap_or(false), emittances: false };
    let rows = by_surface.rows.iter().map(|row| row.iter().map(&number).collect::<Vec<f64>>());
    write_matrix(out, header, &by_surface.areas, rows, &emittances)
}

/// `ZoneProperty:UserViewFactors:BySurfaceName`: the zone, which has the name of the scene's file, then for each pair the surface that
/// sees, the one that is seen, and the factor. All pairs are there, also those of 0: older versions refuse an object that has fewer than
/// the square of the zone's surfaces.
fn energy_plus(mut out: impl Write, scene: &Scene, file: &Path, by_surface: &SurfaceMatrix) -> Result<(), io::Error> {
    // Commas and semicolons end a field, `!` begins a comment.
    let field = |text: &str| text.replace([',', ';', '!', '\n', '\r'], "_");
    let zone = file.file_stem().map_or_else(|| "zone".into(), |stem| stem.to_string_lossy());
    let name = |row: usize| field(scene.surfaces()[by_surface.surfaces[row]].name());
    writeln!(out, "ZoneProperty:UserViewFactors:BySurfaceName,")?;
    write!(out, "  {}", field(&zone))?;
    for (i, row) in by_surface.rows.iter().enumerate() {
        for (j, found) in row.iter().enumerate() {
            write!(out, ",\n  {}, {}, {:?}", name(i), name(j), found.factor)?;
        }
    }
    writeln!(out, ";")
}
