//! Closed rooms: from a point within, faces past screens and the screens themselves fill the sky; and every row of form factors sums to 1.
//!
//! Whatever hides a face is seen in its place. So the light of walls and screens of emission 1 is 1, its gradient is 0, however screens
//! overlap, pierce each other or stand level with edges: on few integer coordinates they do all of that exactly.

use glam::DVec3;
use radgrad_core::{Emission, Emitter, Error, Polygon, Receiver, evaluate_to};
use radgrad_oracle::{Arithmetic, Interval, Request, Source, enclose_source_occluded};
use radgrad_scene::{FactorSettings, FormFactors};
use rayon::prelude::*;

use crate::cases::sampler::Sampler;
use crate::checks::screens::of_faces;
use crate::measures::measure::is_worse;

/// Half the side of a room.
const HALF: f64 = 6.0;

/// Walls that look inwards.
fn walls() -> Vec<Vec<DVec3>> {
    let wall = |axis: usize, sign: f64| {
        let corner = |[u, v]: [f64; 2]| {
            let mut at = [0.0; 3];
            (at[axis], at[(axis + 1) % 3], at[(axis + 2) % 3]) = (sign * HALF, u * HALF, v * HALF);
            DVec3::from(at)
        };
        let mut corners: Vec<DVec3> = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]].map(corner).to_vec();
        if sign > 0.0 {
            corners.reverse();
        }
        corners
    };
    (0..3).flat_map(|axis| [-1.0, 1.0].map(|sign| wall(axis, sign))).collect()
}

/// Screens in a room, on integers or anywhere.
fn drawn(s: &mut Sampler, on_integers: bool, most: u32) -> Vec<Vec<DVec3>> {
    let few = |v: DVec3| if on_integers { v.round() } else { v };
    let mut screens: Vec<Vec<DVec3>> = Vec::new();
    for _ in 0..1 + s.below(most) {
        let [a, u, v] = [s.cube() * 2.5, s.cube() * 3.0, s.cube() * 3.0].map(few);
        if u.cross(v).length() < 0.5 {
            continue;
        }
        match s.below(4) {
            0 => screens.push(vec![a, a + u, a + u + v, a + v]),
            // In halves with a common edge.
            1 => screens.extend([vec![a, a + u, a + u + v], vec![a, a + u + v, a + v]]),
            // Again, a step behind.
            2 => screens.extend([vec![a, a + u, a + v], vec![a + few(a), a + u + few(a), a + v + few(a)]]),
            _ => screens.push(vec![a, a + u, a + v]),
        }
    }
    screens.retain(|screen| screen.iter().all(|corner| corner.abs().max_element() < HALF));
    screens
}

/// The surfaces that a point of a room sees: each one, and the others that may hide it.
struct Sky {
    receiver: Receiver,
    surfaces: Vec<(Emitter, Vec<Polygon>)>,
}

impl Sky {
    fn drawn(index: u64, on_integers: bool) -> Result<Self, Error> {
        let s = &mut Sampler::new(63, "closed", index);
        let few = |v: DVec3| if on_integers { v.round() } else { v };
        let unit = if on_integers { [1.0, 0.125, 1024.0][s.below(3) as usize] } else { 1.0 };
        let (x, toward) = (few(s.cube() * 2.0), few(s.cube() * 2.0 + DVec3::Z * 2.1));
        let mut screens = drawn(s, on_integers, 3);
        // A receiver in a screen's plane may be on it.
        screens.retain(|screen| {
            let normal = (screen[1] - screen[0]).cross(screen[2] - screen[0]);
            normal.dot(screen[0] - x).abs() > 0.05 * normal.length()
        });
        let polygon = |corners: &[DVec3]| Polygon::new(corners.iter().map(|corner| *corner * unit).collect());
        let seen = |screen: &Vec<DVec3>| {
            let normal = (screen[1] - screen[0]).cross(screen[2] - screen[0]);
            let is_front = normal.dot(x - screen[0]) > 0.0;
            if is_front { screen.clone() } else { screen.iter().rev().copied().collect() }
        };
        let screens = screens.iter().map(|screen| polygon(&seen(screen))).collect::<Result<Vec<_>, _>>()?;
        let emitter = |polygon: Polygon| Emitter::new(polygon, Emission::Constant(1.0));
        let mut surfaces = Vec::new();
        for wall in walls() {
            surfaces.push((emitter(polygon(&wall)?)?, screens.clone()));
        }
        for (k, screen) in screens.iter().enumerate() {
            let others = screens.iter().enumerate().filter(|(other, _)| *other != k).map(|(_, other)| other.clone()).collect();
            surfaces.push((emitter(screen.clone())?, others));
        }
        Ok(Self { receiver: Receiver::new(x * unit, toward, 1.0)?, surfaces })
    }
}

/// Contradictions by the surfaces that a point sees.
fn of_sky(index: u64, on_integers: bool) -> Result<Vec<String>, Error> {
    let Sky { receiver, surfaces } = Sky::drawn(index, on_integers)?;
    let name = format!("closed:{index}, {}", if on_integers { "on integers" } else { "anywhere" });
    let mut findings = Vec::new();
    for tolerance in [1.0, 1e-11] {
        let (mut value, mut slope, mut errors) = (-1.0, DVec3::ZERO, [4e-16 * surfaces.len() as f64, 0.0]);
        for (emitter, occluders) in &surfaces {
            let answer = evaluate_to(&receiver, emitter, occluders, tolerance)?;
            value += answer.radiosity;
            slope += answer.gradient;
            errors[0] += answer.radiosity_error;
            errors[1] += answer.gradient_error + 4e-16 * answer.gradient.length();
        }
        if is_worse(value.abs(), errors[0]) || is_worse(slope.length(), errors[1]) {
            findings.push(format!("{name}, to {tolerance:e}: all is {value:e} above 1, its gradient {slope:?}, to {errors:?}"));
        }
        // Level edges may leave a gradient open, not the value.
        if is_worse(errors[0], 1e-7) || (!on_integers && tolerance < 1.0 && is_worse(errors[1], 1e-8)) {
            findings.push(format!("{name}, to {tolerance:e}: known to {errors:?} only"));
        }
    }
    Ok(findings)
}

/// The same by the oracle's enclosures.
fn of_enclosures(index: u64) -> Result<Vec<String>, Box<dyn std::error::Error>> {
    let on_integers = !index.is_multiple_of(3);
    let Sky { receiver, surfaces } = Sky::drawn(index, on_integers)?;
    let arithmetic = [Arithmetic::DoubleDouble, Arithmetic::Limbs, Arithmetic::DoubleDouble][(index % 3) as usize];
    let digits = [15, 17, 17][(index % 3) as usize];
    let mut residual = Interval::around_decimal("1", 0.0)?;
    for (emitter, occluders) in &surfaces {
        let request = Request { digits, arithmetic: Some(arithmetic), budget: 10_000_000 };
        let enclosure = enclose_source_occluded(&receiver, &Source::Emitter(emitter), occluders, &request)?;
        residual = residual.less(&enclosure.radiosity);
    }
    let is_sharp = residual.radius() <= 2.0 * 10f64.powi(-i32::try_from(digits)?) * surfaces.len() as f64;
    let says_so = residual.contains(0.0) && is_sharp;
    Ok((!says_so).then(|| format!("closed:{index}, {digits} digits: 1 less all is {residual:?}")).into_iter().collect())
}

/// Contradictions by the form factors of a room with screens that have two sides.
fn of_factors(index: u64) -> Result<Vec<String>, String> {
    let s = &mut Sampler::new(64, "closed", index);
    let screens = drawn(s, index.is_multiple_of(2), 1);
    let back = |screen: &Vec<DVec3>| screen.iter().rev().copied().collect();
    let count = walls().len() + 2 * screens.len();
    let scene = of_faces(walls().into_iter().chain(screens.iter().flat_map(|screen| [screen.clone(), back(screen)])))?;
    let factors = FormFactors::new(&scene).map_err(|error| error.to_string())?;
    let mut findings = Vec::new();
    for (cells, estimate) in [(1, 1e-2), (12, 1e-4)] {
        let settings =
            FactorSettings { tolerance: 1e-4, most_cells: cells, estimate, most_points: 400, ..FactorSettings::default() };
        // From a wall and from a screen.
        for from in [usize::try_from(index % 6).unwrap_or(0), count - 1] {
            let (mut lower, mut upper, mut value, mut estimate) = (0.0, 0.0, 0.0, 0.0);
            for to in (0..count).filter(|to| *to != from) {
                let factor = factors.between(from, to, &settings).map_err(|error| error.to_string())?;
                (lower, upper) = (lower + factor.lower, upper + factor.upper);
                (value, estimate) = (value + factor.value, estimate + factor.estimate);
            }
            let room = 1e-12;
            if !(lower <= 1.0 + room && upper >= 1.0 - room) || is_worse((value - 1.0_f64).abs(), 10.0 * estimate + 1e-6) {
                findings.push(format!(
                    "closed:{index}, {cells} cells: row {from} sums to {value} +- {estimate:e}, in [{lower}, {upper}]"
                ));
            }
        }
    }
    Ok(findings)
}

/// Contradictions of the first rooms.
#[must_use]
pub fn all_wrong(count: u64) -> Vec<String> {
    let said = |error: &dyn std::fmt::Display, index: u64| vec![format!("closed:{index}: {error}")];
    let ask = |index: u64| {
        let mut findings = [true, false].map(|way| of_sky(index, way).unwrap_or_else(|error| said(&error, index))).concat();
        if index < count / 8 {
            findings.extend(of_enclosures(index).unwrap_or_else(|error| said(&error, index)));
            findings.extend(of_factors(index).unwrap_or_else(|error| said(&error, index)));
        }
        findings
    };
    (0..count).into_par_iter().flat_map_iter(ask).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn skies_and_rows_are_full_and_without_a_wall_they_are_not() {
        assert_eq!(all_wrong(64), Vec::<String>::new());
        let Sky { receiver, surfaces } = Sky::drawn(0, true).unwrap();
        let of =
            |(emitter, occluders): &(Emitter, Vec<Polygon>)| evaluate_to(&receiver, emitter, occluders, 1e-9).unwrap().radiosity;
        let seen: Vec<f64> = surfaces.iter().map(of).collect();
        assert!((seen.iter().sum::<f64>() - 1.0).abs() < 1e-8 && seen.iter().any(|&share| share > 1e-3));
    }
}
