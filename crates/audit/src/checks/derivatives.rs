//! Second derivatives against differences of gradients, and irradiance vectors against radiosities of turned receivers, both to many digits.
//!
//! `record` holds these answers to the same formula with a tighter tolerance, which tells nothing of the formula. A case in which differences
//! by two steps disagree is left out: its truth is not smooth.

use std::f64::consts::PI;

use glam::{DMat3, DVec3};
use radgrad_core::{Receiver, hessian_to, irradiance_vector_to};
use radgrad_scene::case::Problem;
use radgrad_scene::smallest;

use crate::bounds::digits;
use crate::measures::truth::Truth;

/// Digits of the truth.
pub(crate) const DIGITS: u32 = 20;

/// The step over the distance of the nearest vertex; the second one is half of it.
const STEP: f64 = 1.0 / 1024.0;

/// Largest difference of the results by the two steps, over the size of the matrix.
const SMOOTH: f64 = 1e-7;

/// Violations by the second derivatives and the irradiance vector of a case; `None` if neither has a truth to compare with.
#[must_use]
pub fn wrong(problem: &Problem, tolerance: f64) -> Option<Vec<String>> {
    let (second, vector) = (second_derivatives(problem, tolerance), irradiance_vector(problem, tolerance));
    (second.is_some() || vector.is_some()).then(|| second.into_iter().chain(vector).flatten().collect())
}

/// The truth at another place.
fn truth_at(problem: &Problem, position: DVec3, normal: DVec3) -> Option<Truth> {
    let receiver = Receiver::new(position, normal, problem.receiver.reflectance()).ok()?;
    digits::enclosure(&Problem { receiver, ..problem.clone() }, DIGITS).ok()
}

fn second_derivatives(problem: &Problem, tolerance: f64) -> Option<Option<String>> {
    let Problem { receiver, emitter, occluders, .. } = problem;
    let (x, normal) = (receiver.position(), receiver.normal());
    let nearest = emitter.polygon().vertices().iter().map(|vertex| vertex.distance(x)).fold(f64::INFINITY, smallest);
    let differences = |step: f64| -> Option<DMat3> {
        let column = |axis: DVec3| -> Option<DVec3> {
            let gradient = |steps: f64| -> Option<(f64, DVec3)> {
                let there = x + axis * (steps * step);
                Some((
                    (there - x).dot(axis),
                    DVec3::from(truth_at(problem, there, normal)?.gradient.each_ref().map(|g| g.to_f64())),
                ))
            };
            let [a, b, c, d] = [gradient(-2.0)?, gradient(-1.0)?, gradient(1.0)?, gradient(2.0)?];
            // A difference of fourth order: the wider one cancels the third derivatives.
            Some((c.1 - b.1) / (c.0 - b.0) * (4.0 / 3.0) - (d.1 - a.1) / (d.0 - a.0) / 3.0)
        };
        Some(DMat3::from_cols(column(DVec3::X)?, column(DVec3::Y)?, column(DVec3::Z)?))
    };
    let size = |matrix: DMat3| DVec3::new(matrix.x_axis.length(), matrix.y_axis.length(), matrix.z_axis.length()).length();
    let [wide, narrow] = [differences(STEP * nearest)?, differences(0.5 * STEP * nearest)?];
    let room = SMOOTH * size(narrow);
    if !(size(wide - narrow) < room && room.is_normal()) {
        return None;
    }
    let answer = hessian_to(receiver, emitter, occluders, tolerance).ok()?;
    let error = size(answer.matrix - narrow);
    let holds = (0.0..=answer.error + room).contains(&error);
    Some((!holds).then(|| format!("second derivatives to {tolerance:e} are off by {error:e}, the bound is {:e}", answer.error)))
}

/// Where all of the emitter is above the horizon, a receiver's irradiance is the component along its normal.
fn irradiance_vector(problem: &Problem, tolerance: f64) -> Option<Option<String>> {
    let Problem { receiver, emitter, occluders, .. } = problem;
    let (x, vertices) = (receiver.position(), emitter.polygon().vertices());
    let toward = (vertices.iter().sum::<DVec3>() / vertices.len() as f64 - x).try_normalize()?;
    let across = toward.any_orthonormal_vector();
    let normals = [toward, toward + across * 0.25, toward + toward.cross(across) * 0.25].map(DVec3::normalize);
    let facing = |normal: &DVec3| vertices.iter().all(|vertex| (*vertex - x).dot(*normal) > 1e-6 * vertex.distance(x));
    let whole = |normal: DVec3| vertices.iter().all(|vertex| (*vertex - x).dot(normal) > 0.0);
    if !normals.iter().all(facing) || !whole(receiver.normal()) || receiver.reflectance() == 0.0 {
        return None;
    }
    let answer = irradiance_vector_to(receiver, emitter, occluders, tolerance).ok()?;
    let mut worst = None;
    for normal in normals {
        let truth = truth_at(problem, x, normal)?.radiosity.to_f64() * PI / receiver.reflectance();
        let error = (answer.vector.dot(normal) - truth).abs();
        if !(0.0..=answer.error + 1e-14 * truth.abs()).contains(&error) {
            let what = format!("the irradiance vector to {tolerance:e} is off by {error:e}, the bound is {:e}", answer.error);
            worst = Some(what);
        }
    }
    Some(worst)
}
