//! The program's output files, for callers that have a solution.

use std::path::Path;
use std::sync::atomic::AtomicBool;

use clap::Parser;
use radgrad_certificate::{Certificate, Request};
use radgrad_scene::output::write_whole;
use radgrad_scene::{FactorMatrix, Scene};
use radgrad_solver::Solution;

pub use crate::certified::RAYS_A_POINT;
use crate::certified::requested;
use crate::export::Format;
use crate::summary::Summary;
use crate::view::View;

/// Writes a solution of a scene, and the certificate of its mean if there is one, to a file whose name ends in `.vtu` or `.ply`.
///
/// # Errors
/// If the name ends otherwise, or the file cannot be written: it is then as it was.
pub fn solution(solution: &Solution, scene: &Scene, certificate: Option<&Certificate>, file: &Path) -> Result<(), String> {
    let format = Format::of(file).ok_or_else(|| format!("`{}`: expected a name ending in .vtu or .ply", file.display()))?;
    write_whole(file, |out| format.write(solution, scene, certificate, out)).map_err(|error| error.to_string())
}

/// Writes factors of a scene as `radgrad factors --out` does: `.csv`, `.mtx`, `.txt`, `.out` or `.idf`, with the share of each face's view that no
/// face has where `open` asks for it in a `.csv`.
///
/// # Errors
/// If the name ends otherwise, or a file cannot be written.
pub fn factors(matrix: &FactorMatrix, scene: &Scene, file: &Path, open: bool) -> Result<(), String> {
    crate::factors::written(matrix, scene, file, open).map_err(|error| error.to_string())
}

/// The output of `radgrad solve --summary`: one JSON object, of a run that was asked for an error and took some seconds.
///
/// # Errors
/// If a number in it is none.
pub fn summary(
    solution: &Solution,
    scene: &Scene,
    certificate: Option<&Certificate>,
    error: f64,
    seconds: f64,
) -> Result<String, String> {
    serde_json::to_string(&Summary::of(solution, scene, certificate, error, seconds)).map_err(|error| error.to_string())
}

/// The certificate that `radgrad solve` asks for of a scene that was solved to this error, of this half-width if one is given.
#[must_use]
pub fn certifying(solution: &Solution, error: f64, width: Option<f64>) -> Request {
    requested(solution, error, width)
}

/// The image of a camera.
#[derive(Debug, Clone, PartialEq)]
pub struct Picture {
    /// Width and height.
    pub size: [usize; 2],
    /// Radiosity in each channel of each pixel, row by row from the upper left.
    pub radiosity: Vec<f64>,
    /// An estimate of its error.
    pub estimate: Vec<f64>,
}

/// The options of `radgrad solve` that are about a view.
#[derive(Debug, Parser)]
#[command(no_binary_name = true)]
struct Options {
    #[command(flatten)]
    view: View,
}

/// Draws a view, with the options of `radgrad solve --view`, `--camera` first; writes it where a file is named. It ends soon after another
/// thread sets `stop`.
///
/// # Errors
/// If an option is wrong, the file cannot be written, or it was ended.
pub fn picture(solution: &Solution, options: &[String], stop: &AtomicBool) -> Result<Picture, String> {
    let Options { view } = Options::try_parse_from(options).map_err(|error| error.render().to_string().trim().to_owned())?;
    view.picture(solution, stop).map_err(|error| error.to_string())
}
