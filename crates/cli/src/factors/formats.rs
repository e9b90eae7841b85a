//! How factors are written.

use std::ffi::OsString;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use radgrad_scene::output::{extension, write_whole};
use radgrad_scene::view3d::{MatrixHeader, write_matrix};
use radgrad_scene::{Entry, FactorMatrix, Quantity, Scene, SurfaceFactor, SurfaceMatrix, largest};

use super::Failure;
use super::npz::{Rows, Take};

/// Which program reads it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Format {
    Csv,
    /// Matrix Market: `scipy.io.mmread`, Julia's `MatrixMarket`, MATLAB's `mmread`.
    MatrixMarket,
    /// `scipy.sparse.load_npz`.
    Npz,
    View3d,
    EnergyPlus,
}

impl Format {
    pub(super) fn of(file: &Path) -> Result<Self, Failure> {
        match extension(file).as_str() {
            "csv" => Ok(Self::Csv),
            "mtx" => Ok(Self::MatrixMarket),
            "npz" => Ok(Self::Npz),
            "txt" | "out" => Ok(Self::View3d),
            "idf" => Ok(Self::EnergyPlus),
            _ => Err(Failure::Format(file.to_owned())),
        }
    }
}

/// What a table of factors has beside their lines.
#[derive(Debug, Clone, Copy)]
pub(super) struct Table {
    /// A header.
    pub(super) first: bool,
    /// After the factors of each face the share of its view that no face has.
    pub(super) open: bool,
}

/// The files that are written: a second one has the bounds where the first has no place for them.
pub(super) fn files(file: &Path, format: Format) -> Vec<PathBuf> {
    let bounds = matches!(format, Format::MatrixMarket | Format::View3d).then(|| beside(file));
    [file.to_owned()].into_iter().chain(bounds).collect()
}

/// Writes the factors.
pub(super) fn write(
    file: &Path,
    format: Format,
    scene: &Scene,
    scene_file: &Path,
    matrix: &FactorMatrix,
    table: Table,
) -> Result<(), Failure> {
    match format {
        Format::Csv => write_whole(file, |out| csv(out, scene, matrix, table))?,
        Format::MatrixMarket => {
            write_whole(file, |out| matrix_market(out, scene, matrix, |entry| entry.factor))?;
            write_whole(&beside(file), |out| matrix_market(out, scene, matrix, |entry| entry.error))?;
        }
        Format::Npz => write_whole(file, |out| npz(out, scene, matrix))?,
        Format::View3d => {
            let by_surface = matrix.by_surface(scene);
            write_whole(file, |out| view3d(out, scene, &by_surface, |found| found.factor))?;
            let bound = |found: &SurfaceFactor| largest(found.upper - found.factor, found.factor - found.lower);
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

/// A line a factor, and the area of the first face; faces are numbered from 0 in the order of the file; what is open is the factor to a face `open`, which has no number: 1 less
/// the sum of the row, below 0 where errors make the row more than 1.
fn csv(out: impl Write, scene: &Scene, matrix: &FactorMatrix, Table { first, open }: Table) -> Result<(), csv::Error> {
    let mut table = csv::Writer::from_writer(out);
    if first {
        table.write_record([
            "from",
            "from_surface",
            "to",
            "to_surface",
            "factor",
            "lower",
            "upper",
            "error",
            "occluders",
            "area",
        ])?;
    }
    let surface = |face: usize| scene.surfaces()[scene.faces()[face].surface()].name();
    for &from in matrix.faces() {
        let area = format!("{:?}", matrix.areas()[from]);
        let mut line = |[to, name]: [&str; 2], [factor, lower, upper, error]: [f64; 4], occluders: &str| {
            table.write_record([
                &from.to_string(),
                surface(from),
                to,
                name,
                &format!("{factor:?}"),
                &format!("{lower:?}"),
                &format!("{upper:?}"),
                &format!("{error:e}"),
                occluders,
                &area,
            ])
        };
        for Entry { face, factor, lower, upper, error, occluders, .. } in matrix.row(from) {
            line([&face.to_string(), surface(face)], [factor, lower, upper, error], &occluders.to_string())?;
        }
        if open {
            let sum = matrix.sum(from);
            let [factor, lower, upper] = [1.0 - sum.factor, 1.0 - sum.upper, 1.0 - sum.lower];
            line(["open", "open"], [factor, lower, upper, largest(upper - factor, factor - lower)], "0")?;
        }
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

/// Values alone, by face; with what is open, 1 less the sum of the row.
fn npz(out: impl Write, scene: &Scene, matrix: &FactorMatrix) -> Result<(), io::Error> {
    let mut open = vec![1.0; scene.faces().len()];
    matrix.faces().iter().for_each(|&face| open[face] = 1.0 - matrix.sum(face).factor);
    let each = |row: Take<'_>| {
        matrix.faces().iter().try_for_each(|&face| row(face, matrix.row(face).map(|entry| (entry.face, entry.factor)).unzip()))
    };
    Rows { faces: open.len(), numbers: matrix.entries().count(), open, each: &each }.write(out)
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
