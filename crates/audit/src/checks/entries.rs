//! Functions that the large runs do not call: core's answers without bounds, and operations on a matrix of form factors.
//!
//! Answers are compared with digits of the truth, and matrices with their own sums.

use std::f64::consts::PI;
use std::sync::Mutex;

use glam::DVec3;
use radgrad_core::{gradient, irradiance_vector, radiosity, radiosity_and_gradient};
use radgrad_paper::appendix;
use radgrad_scene::case::Problem;
use radgrad_scene::{ComputedRow, Entry, FactorBlock, FactorMatrix, FactorSettings, FormFactors, Repaired, Scene, largest};

use crate::bounds::digits;
use crate::checks::derivatives::DIGITS;
use crate::measures::measure::is_worse;
use crate::scenes::family::Name;
use crate::scenes::model::Model;
use crate::scenes::pieces::scene_of;

/// The largest error of a plain answer, relative to the magnitude of its terms, in cases far from any degeneracy.
const PLAIN: f64 = 1e-9;

/// The largest error of a sum of a matrix.
const SUM: f64 = 1e-12;

/// Violations by core's answers without bounds, in a case without occluders; none if the case has no truth to compare with.
#[must_use]
pub fn plain(problem: &Problem) -> Vec<String> {
    let Problem { receiver, emitter, .. } = problem;
    let Ok(truth) = digits::enclosure(problem, DIGITS) else { return Vec::new() };
    let [of_value, of_slope] = [PLAIN * truth.radiosity_magnitude(), PLAIN * truth.gradient_magnitude()];
    let mut findings = Vec::new();
    let mut hold = |what: &str, error: Result<f64, radgrad_core::Error>, most: f64| match error {
        Ok(error) if !is_worse(error, most) => {}
        Ok(error) => findings.push(format!("{what} is off by {error:e}")),
        Err(error) => findings.push(format!("{what}: {error}")),
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
    findings
}

/// Violations by blocks, sums by surface, narrowing and repair of the matrix of a scene.
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
    let (mut findings, count) = (Vec::new(), matrix.areas().len());
    let half = count / 2;
    let blocks = [0..half, half..count].map(|rows| factors.block(rows, &settings, || ()).map_err(said));
    let blocks = blocks.into_iter().collect::<Result<Vec<_>, String>>()?;
    let sent = blocks.iter().map(|block| FactorBlock::from_bytes(&block.to_bytes()).map_err(said));
    if sent.collect::<Result<Vec<_>, String>>()? != blocks {
        findings.push("blocks read from their bytes are others".to_owned());
    }
    let bytes = blocks[0].to_bytes();
    if [0, 15, bytes.len() - 1, bytes.len() - 51].into_iter().any(|length| FactorBlock::from_bytes(&bytes[..length]).is_ok()) {
        findings.push("a block is read from a part of its bytes".to_owned());
    }
    if factors.join(blocks).map_err(said)? != matrix {
        findings.push("blocks of rows are not the matrix".to_owned());
    }
    let by_surface = matrix.by_surface(&scene);
    for (row, (&surface, &area)) in by_surface.rows.iter().zip(by_surface.surfaces.iter().zip(&by_surface.areas)) {
        let faces = scene.surfaces()[surface].faces();
        let of_faces: f64 = faces.iter().map(|&face| matrix.areas()[face] * matrix.sum(face).factor).sum();
        let sum: f64 = row.iter().map(|to| to.factor).sum();
        if is_worse((sum - of_faces / area).abs(), SUM) || row.iter().any(|to| !(to.lower <= to.factor && to.factor <= to.upper))
        {
            findings.push(format!("surface {surface} sums to {sum}, its faces to {}", of_faces / area));
        }
    }
    let mut narrowed = matrix.clone();
    let left = factors.narrow(&mut narrowed, &settings, 10_000).map_err(said)?;
    let unmet = narrowed.unmet(&settings).count();
    if (left.wanted > 0.0) != (unmet > 0) || left.spent > 10_000 {
        findings.push(format!("{unmet} bounds are not met, and {left:?}"));
    }
    let kept = Mutex::new(Vec::new());
    let keep = |row: &ComputedRow| kept.lock().map_or((), |mut kept| kept.push(row.clone()));
    let all = factors.rows_from(0..count, &settings, Vec::new(), keep).map_err(said)?;
    let mut before = kept.into_inner().map_err(|error| error.to_string())?;
    before.truncate(half);
    if all != matrix || factors.rows_from(0..count, &settings, before, |_| ()).map_err(said)? != matrix {
        findings.push("rows that go on from a run before are not the matrix".to_owned());
    }
    findings.extend(apart(&matrix, &narrowed).map(|what| format!("narrowed, {what}")));
    if model.closed {
        let mut repaired = narrowed.clone();
        let Repaired { largest: most, mean, pair, closure, .. } = repaired.repair(&settings).map_err(said)?;
        let change = |(from, entry): (usize, Entry)| (repaired.factor(from, entry.face) - entry.factor).abs();
        let changes: Vec<f64> = narrowed.entries().map(change).collect();
        let of_pair = (repaired.factor(pair[0], pair[1]) - narrowed.factor(pair[0], pair[1])).abs();
        let differences = [
            changes.iter().copied().fold(0.0, largest) - most,
            of_pair - most,
            changes.iter().sum::<f64>() / changes.len() as f64 - mean,
        ];
        if differences.iter().any(|off| is_worse(off.abs(), SUM)) {
            findings
                .push(format!("repair says that it changed {pair:?} by {most:e} and all by {mean:e}, off by {differences:?}"));
        }
        if is_worse(closure, SUM) || is_worse(repaired.worst_closure(), SUM) || is_worse(repaired.worst_reciprocity(), SUM) {
            findings.push(format!("rows that are repaired lack {closure:e} or {:e}", repaired.worst_closure()));
        }
        findings.extend(apart(&narrowed, &repaired).map(|what| format!("repaired, {what}")));
    }
    Ok(findings)
}

/// Violations by what the rounding of a file's coordinates takes of factors: the outlines of both faces, and of what is in between, may be off by so much.
///
/// # Errors
/// If there is no matrix: why.
pub fn of_rounding(name: Name) -> Result<Vec<String>, String> {
    let said = |error: radgrad_scene::Error| error.to_string();
    let scene: Scene = name.model().scene().map_err(said)?;
    let factors = FormFactors::new(&scene).map_err(said)?;
    let settings = FactorSettings { tolerance: 0.05, most_cells: 30, estimate: 1e-2, ..FactorSettings::default() };
    let matrix = factors.matrix(&settings, || ()).map_err(said)?;
    let band = |face: usize| {
        let (face, vertices) = (&scene.faces()[face], scene.faces()[face].polygon().vertices());
        let sides = (0..vertices.len()).map(|k| (vertices[(k + 1) % vertices.len()] - vertices[k]).length());
        (face.moved() + 3.0_f64.sqrt() * scene.modelling().precision) * sides.sum::<f64>()
    };
    let mut findings = Vec::new();
    for (from, entry) in matrix.entries() {
        let [own, other] = [from, entry.face].map(|face| scene.faces()[face].polygon().area());
        let (expected, most) = ((band(from) + band(entry.face)) / own, own.min(other) / own);
        let room = 1e-6 * expected;
        let is_free_or_less = entry.occluders > 0 || entry.modelling <= expected + room;
        let reaches =
            entry.upper >= (entry.factor + expected).min(most) - room && entry.lower <= (entry.factor - expected).max(0.0) + room;
        if !(is_free_or_less && reaches) {
            findings.push(format!("{from} sees {entry:?}, of which rounding takes {expected:e} and more"));
        }
    }
    Ok(findings)
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
/// Violations by repairs in which the worst row waits for the others, or most pairs are at an end: brackets as of a run before, on a regular
/// tetrahedron.
///
/// # Errors
/// If there is no matrix, or it is not repaired: why.
pub fn of_repairs() -> Result<Vec<String>, String> {
    const PAIRS: [[usize; 2]; 6] = [[0, 1], [0, 2], [0, 3], [1, 2], [1, 3], [2, 3]];
    // The least, the value and the most of each pair, and what the factor from 0 to 2 is then.
    const WAITING: [[f64; 3]; 6] =
        [[0.6, 0.8, 0.8], [0.1, 0.1, 0.2], [0.0, 0.075, 0.15], [0.0, 0.075, 0.15], [0.0, 0.1, 0.15], [0.75, 0.85, 0.85]];
    const AT_ENDS: [[f64; 3]; 6] =
        [[0.75, 1.0, 1.0], [0.0, 0.0, 0.2], [0.0, 0.1, 0.2], [0.0, 0.2, 0.2], [0.05, 0.05, 0.3], [0.75, 1.0, 1.0]];
    let said = |error: radgrad_scene::Error| error.to_string();
    // The power of two that brings coordinates to 1/2 and more is 1, so that exchanges are in the scene's own unit.
    let [a, b, c, d] = [[1.0, 1.0, 1.0], [1.0, -1.0, -1.0], [-1.0, 1.0, -1.0], [-1.0, -1.0, 1.0]].map(|p| DVec3::from(p) * 0.75);
    let scene = scene_of([[b, c, d], [a, d, c], [a, b, d], [a, c, b]].map(|face| face.to_vec()).to_vec())?;
    let factors = FormFactors::new(&scene).map_err(said)?;
    let settings = FactorSettings { tolerance: 1e-9, ..FactorSettings::default() };
    let stored = Mutex::new(Vec::new());
    let store = |row: &ComputedRow| stored.lock().map_or((), |mut rows| rows.push(row.clone()));
    let area = factors.rows_from(0..4, &settings, Vec::new(), store).map_err(said)?.areas()[0];
    let changed = |row: &ComputedRow, brackets: &[[f64; 3]; 6]| -> Result<ComputedRow, serde_json::Error> {
        let mut text = serde_json::to_value(row)?;
        for pair in text["pairs"].as_array_mut().into_iter().flatten() {
            for ([from, to], [least, value, most]) in PAIRS.into_iter().zip(*brackets) {
                if from == row.face() && pair[0].as_u64() == Some(to as u64) {
                    for (name, number) in
                        [("least", least), ("value", value), ("most", most), ("estimate", 0.0), ("modelling", 0.0)]
                    {
                        pair[1][name] = (number * area).into();
                    }
                }
            }
        }
        serde_json::from_value(text)
    };
    let rows = stored.into_inner().map_err(|error| error.to_string())?;
    let mut findings = Vec::new();
    for (brackets, wanted) in [(WAITING, Some(1.0 / 9.0)), (AT_ENDS, None)] {
        let rows = rows.iter().map(|row| changed(row, &brackets)).collect::<Result<Vec<_>, _>>();
        let mut matrix = factors.rows_from(0..4, &settings, rows.map_err(|error| error.to_string())?, |_| ()).map_err(said)?;
        let closure = matrix.repair(&settings).map_err(said)?.closure;
        if is_worse(closure, SUM) || wanted.is_some_and(|wanted| is_worse((matrix.factor(0, 2) - wanted).abs(), 1e-9)) {
            findings.push(format!("a repaired row lacks {closure:e}, the factor 0 to 2 is {}", matrix.factor(0, 2)));
        }
    }
    Ok(findings)
}
