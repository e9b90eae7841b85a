//! Certificates of a scene: limits that may fail, with a probability that is said.

use radgrad_certificate::{Interval, Place, Request, certify, certify_points};
use radgrad_scene::Scene;

use super::model::Model;
use super::statement::{Quantum, Stated, Statement};

/// Probabilities with which limits may fail: one that is seen to hold in a run, and the usual one.
pub(super) const CERTIFIED: f64 = 1e-2;
const PROBABILITIES: [f64; 2] = [CERTIFIED, 1e-6];

/// Relative half-width at which walks end, and rays for the mean and for a point.
const WIDTH: f64 = 0.02;
const RAYS: u64 = 100_000;
const RAYS_A_POINT: u64 = 20_000;

/// Of so many scenes points are asked for in one.
const WITH_POINTS: u64 = 10;

/// The limits of the mean, and in one scene of [`WITH_POINTS`] those at the points, once for each of the probabilities.
///
/// # Errors
/// If there are none: why.
pub(super) fn certified(model: &Model, scene: &Scene) -> Result<Vec<Statement>, String> {
    let first = model.seed();
    let mut statements = Vec::new();
    for (delta, seed) in PROBABILITIES.into_iter().zip([first, !first]) {
        let say = |of: Quantum, limits: &Interval| {
            let Interval { lower: low, upper: high } = *limits;
            let value = if high.is_finite() { 0.5 * (low + high) } else { low };
            Statement { of, value, stated: Stated::Limits { low, high, delta } }
        };
        let request = Request { delta, width: WIDTH, rays: RAYS, seed };
        let certificate = certify(scene, &request).map_err(|error| error.to_string())?;
        statements.extend(certificate.mean.iter().enumerate().map(|(channel, limits)| say(Quantum::Mean(channel), limits)));
        if !first.is_multiple_of(WITH_POINTS) {
            continue;
        }
        let asked = model.asked().map_err(|error| error.to_string())?;
        let place = |((position, normal), part)| Place { position, normal, face: Some(part) };
        let places: Vec<Place> = asked.into_iter().zip(model.probes.iter().map(|probe| probe.part)).map(place).collect();
        let points = certify_points(scene, &places, &Request { rays: RAYS_A_POINT, ..request });
        for (probe, point) in points.map_err(|error| error.to_string())?.into_iter().enumerate() {
            let radiosity = point.map_err(|error| error.to_string())?.radiosity.unwrap_or_default();
            statements.extend(radiosity.iter().enumerate().map(|(channel, limits)| say(Quantum::Point(probe, channel), limits)));
        }
    }
    Ok(statements)
}
