//! Ways in that the large runs do not ask: core's answers without bounds, and what is made of a matrix of form factors.
//!
//! Each is held to what is known otherwise: digits of the truth, and sums of the matrix itself.

use std::f64::consts::PI;

use radgrad_core::{gradient, irradiance_vector, radiosity, radiosity_and_gradient};
use radgrad_paper::appendix;
use radgrad_scene::case::Problem;
use radgrad_scene::{FactorMatrix, FactorSettings, FormFactors, Scene};

use crate::bounds::digits;
use crate::measure::is_worse;
use crate::scenes::family::Name;
use crate::scenes::model::Model;

/// Digits of the truth.
const DIGITS: u32 = 20;

/// What plain answers may be off by, over the size of what they are of, in cases that are not next to anything.
const PLAIN: f64 = 1e-9;

/// What sums of a matrix may be off by.
const SUM: f64 = 1e-12;

/// What is wrong with the answers of core that have no bound, of a case without occluders; nothing if no truth is known.
#[must_use]
pub fn plain(problem: &Problem) -> Vec<String> {
    let Problem { receiver, emitter, .. } = problem;
    let Ok(truth) = digits::enclosure(problem, DIGITS) else { return Vec::new() };
    let [of_value, of_slope] = [PLAIN * truth.radiosity_magnitude(), PLAIN * truth.gradient_magnitude()];
    let mut found = Vec::new();
    let mut hold = |what: &str, error: Result<f64, radgrad_core::Error>, most: f64| match error {
        Ok(error) if !is_worse(error, most) => {}
        Ok(error) => found.push(format!("{what} is off by {error:e}")),
        Err(error) => found.push(format!("{what}: {error}")),
    };
    hold("radiosity", radiosity(receiver, emitter).map(|value| truth.radiosity_error(value)), of_value);
    hold("gradient", gradient(receiver, emitter).map(|slope| truth.gradient_error(slope)), of_slope);
    let both = radiosity_and_gradient(receiver, emitter);
    hold("radiosity of both", both.clone().map(|(value, _)| truth.radiosity_error(value)), of_value);
    hold("gradient of both", both.map(|(_, slope)| truth.gradient_error(slope)), of_slope);
    // The second implementation knows no polynomials.
    if let Ok((value, slope)) = appendix::radiosity_and_gradient(receiver, emitter, None) {
        hold("radiosity by appendix A", Ok(truth.radiosity_error(value)), of_value);
        hold("gradient by appendix A", Ok(truth.gradient_error(slope)), of_slope);
    }
    // Along the normal it is the irradiance.
    let along = irradiance_vector(receiver, emitter).map(|vector| vector.dot(receiver.normal()) * receiver.reflectance() / PI);
    hold("the irradiance vector along the normal", along.map(|value| truth.radiosity_error(value)), of_value);
    found
}

/// What is wrong with blocks, surfaces, narrowing and repair of the matrix of a scene.
///
/// # Errors
/// If there is no matrix: why.
pub fn of_matrix(name: Name) -> Result<Vec<String>, String> {
    let model: Model = name.model();
    let said = |error: radgrad_scene::Error| error.to_string();
    let scene: Scene = model.scene().map_err(said)?;
    let factors = FormFactors::new(&scene).map_err(said)?;
    let settings = FactorSettings { tolerance: 0.05, most_cells: 100, ..FactorSettings::default() };
    let matrix = factors.matrix(&settings, || ()).map_err(said)?;
    let (mut found, count) = (Vec::new(), matrix.areas().len());
    let half = count / 2;
    let blocks = [0..half, half..count].map(|rows| factors.block(rows, &settings, || ()).map_err(said));
    let blocks = blocks.into_iter().collect::<Result<Vec<_>, String>>()?;
    if factors.join(blocks).map_err(said)? != matrix {
        found.push("blocks of rows are not the matrix".to_owned());
    }
    let by_surface = matrix.by_surface(&scene);
    for (row, (&surface, &area)) in by_surface.rows.iter().zip(by_surface.surfaces.iter().zip(&by_surface.areas)) {
        let faces = scene.surfaces()[surface].faces();
        let of_faces: f64 = faces.iter().map(|&face| matrix.areas()[face] * matrix.sum(face).factor).sum();
        let sum: f64 = row.iter().map(|to| to.factor).sum();
        if is_worse((sum - of_faces / area).abs(), SUM) || row.iter().any(|to| !(to.lower <= to.factor && to.factor <= to.upper))
        {
            found.push(format!("surface {surface} sums to {sum}, its faces to {}", of_faces / area));
        }
    }
    let mut narrowed = matrix.clone();
    factors.narrow(&mut narrowed, &settings, 10_000).map_err(said)?;
    found.extend(apart(&matrix, &narrowed).map(|what| format!("narrowed, {what}")));
    if model.closed {
        let mut repaired = narrowed.clone();
        let closure = repaired.repair(&settings).map_err(said)?.closure;
        if is_worse(closure, SUM) || is_worse(repaired.worst_closure(), SUM) || is_worse(repaired.worst_reciprocity(), SUM) {
            found.push(format!("rows that are repaired lack {closure:e} or {:e}", repaired.worst_closure()));
        }
        found.extend(apart(&narrowed, &repaired).map(|what| format!("repaired, {what}")));
    }
    Ok(found)
}

/// The first entry that lies outside its bracket in either.
fn apart(matrix: &FactorMatrix, other: &FactorMatrix) -> Option<String> {
    matrix.entries().find_map(|(from, entry)| {
        let (to, factor) = (entry.face, other.factor(from, entry.face));
        let room = SUM * entry.upper;
        let is_within = entry.lower - room <= factor && factor <= entry.upper + room;
        (!is_within).then(|| format!("{from} sees {factor} of {to}, it was {} to {}", entry.lower, entry.upper))
    })
}
