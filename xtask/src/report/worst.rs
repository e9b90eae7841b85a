//! The worst case of every family, with a picture and the command that replays it.

use std::error::Error;

use serde::Serialize;

use super::audit::Audit;
use super::histogram::{has_errors, worst};
use super::sketch::Geometry;

/// A worst case.
#[derive(Debug, Serialize)]
pub(super) struct Worst {
    family: String,
    /// `value` or `gradient`, whichever is worse.
    quantity: String,
    error: String,
    case: String,
    distance: String,
    height: String,
    size: String,
    json: String,
    picture: String,
}

/// The worst case of value and gradient together in every family that has errors.
pub(super) fn cases(audit: &Audit) -> Result<Vec<Worst>, Box<dyn Error>> {
    let mut cases = Vec::new();
    for row in audit.outcomes.iter().filter(|row| has_errors(audit, &row.family)) {
        let Some(figure) = worst(audit, &row.family) else { continue };
        let name = figure.worst_case.parse().map_err(|error| format!("figures.csv: {error}"))?;
        let Some(geometry) = Geometry::from_case(name) else { continue };
        cases.push(Worst {
            family: figure.family.clone(),
            quantity: figure.quantity.clone(),
            error: figure.worst.clone(),
            case: figure.worst_case.clone(),
            distance: plain(geometry.distance),
            height: plain(geometry.height),
            size: format!("{:.1e}", geometry.size),
            json: serde_json::to_string(&name.case())?,
            picture: geometry.draw(&format!("The worst case of {}", figure.family)),
        });
    }
    Ok(cases)
}

/// Two digits, without an exponent where that is short.
fn plain(x: f64) -> String {
    match x.abs() {
        ..0.01 => format!("{x:.1e}"),
        ..1.0 => format!("{x:.2}"),
        ..10.0 => format!("{x:.1}"),
        ..1000.0 => format!("{x:.0}"),
        _ => format!("{x:.1e}"),
    }
}

/// `family,quantity,error,case,distance,height,size,json`: distance and height in sizes of the emitter.
pub(super) fn csv(cases: &[Worst]) -> Result<Vec<u8>, Box<dyn Error>> {
    let mut rows = csv::Writer::from_writer(Vec::new());
    rows.write_record(["family", "quantity", "error", "case", "distance", "height", "size", "json"])?;
    for Worst { family, quantity, error, case, distance, height, size, json, .. } in cases {
        rows.write_record([family, quantity, error, case, distance, height, size, json])?;
    }
    Ok(rows.into_inner()?)
}
