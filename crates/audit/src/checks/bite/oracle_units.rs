//! The oracle in another unit of length or of light, where by a power of two no digit changes; rooms and rectangles of which the radiosity is
//! known; and points on edges as further corners.

use std::f64::consts::PI;

use glam::DVec3;
use radgrad_core::{Emission, Emitter, Polygon, Receiver, evaluate_to};
use radgrad_oracle::cubature::{self, Status};
use radgrad_oracle::monte_carlo::{self, Sampling, Sequence};
use radgrad_oracle::scene::known::{FacingRectangles, furnace_emission};
use radgrad_oracle::scene::{Effort, Face, Kind, Known, Pattern, Point, Scene};
use radgrad_oracle::{Arithmetic, Interval, Request, Source, enclose_occluded, enclose_source};
use radgrad_scene::{largest, smallest};

use crate::cases::sampler::Sampler;
use crate::measures::measure::is_worse;

type Told = Result<Vec<String>, Box<dyn std::error::Error>>;

/// Units of length and of light.
const UNITS: [[f64; 2]; 4] = [
    [1.0, 1.0 / (1u64 << 40) as f64],
    [1.0 / (1u64 << 40) as f64, 1.0],
    [(1u64 << 50) as f64, 1024.0],
    [1.0 / 1024.0, (1u64 << 60) as f64],
];

/// A quadrilateral lit by a slope, with points on its edges as corners too, and a receiver before it.
fn lit(sampler: &mut Sampler, [length, light]: [f64; 2]) -> Result<(Receiver, Emitter), radgrad_core::Error> {
    let whole = |sampler: &mut Sampler| DVec3::from([(); 3].map(|()| sampler.integer(-4, 4) as f64));
    let (start, u, v) = (whole(sampler), whole(sampler) + DVec3::X * 9.0, whole(sampler) + DVec3::Y * 9.0);
    let corners = [[0.0, 0.0], [0.25, 0.0], [0.5, 0.0], [1.0, 0.0], [1.0, 0.75], [1.0, 1.0], [0.5, 1.0], [0.0, 1.0]];
    let mut corners = corners.map(|[s, t]| start + u * s + v * t).to_vec();
    corners.rotate_left(sampler.below(8) as usize);
    let normal = u.cross(v).normalize();
    let over = [DVec3::ZERO, (u + v) * 0.5, u * 2.0][sampler.below(3) as usize];
    let x = start + over + normal * sampler.between(2.0, 9.0);
    let facing = start + (u + v) * 0.5 - x + sampler.cube() * 3.0;
    let values: Vec<f64> = corners.iter().map(|c| (40.0 + DVec3::new(1.0, 0.5, -0.25).dot(*c)) * light).collect();
    let polygon = Polygon::new(corners.into_iter().map(|c| c * length).collect())?;
    Ok((Receiver::new(x * length, facing, 0.5)?, Emitter::new(polygon, Emission::at_vertices(values))?))
}

/// Cubature, sampling and enclosures in another unit, and cubature against the closed form.
fn points(sampler: &mut Sampler) -> Told {
    let mut findings = Vec::new();
    let again = sampler.clone();
    let (receiver, emitter) = lit(sampler, [1.0, 1.0])?;
    let truth = evaluate_to(&receiver, &emitter, &[], 1e-12)?;
    let estimate = cubature::integrate(&receiver, &emitter, 1e-9, 40_000)?;
    let error = [(estimate.radiosity - truth.radiosity).abs(), (estimate.gradient - truth.gradient).length()];
    let room = [estimate.radiosity_error + truth.radiosity_error, estimate.gradient_error + truth.gradient_error];
    if estimate.status != Status::Converged || !(error[0] <= room[0] && error[1] <= room[1]) {
        findings
            .push(format!("cubature over corners on edges is off by {error:?}, estimated to {room:?}: {:?}", estimate.status));
    }
    let sequence = Sequence::Independent { samples: 60, seed: 5 };
    let sampled = |receiver: &Receiver, emitter: &Emitter| {
        monte_carlo::integrate(receiver, emitter, &[], Sampling::SolidAngle, sequence, 0.999)
    };
    let before = sampled(&receiver, &emitter)?;
    for [length, light] in UNITS {
        let (receiver, emitter) = lit(&mut again.clone(), [length, light])?;
        let other = cubature::integrate(&receiver, &emitter, 1e-9, 40_000)?;
        let back = cubature::Estimate {
            radiosity: other.radiosity / light,
            gradient: other.gradient * (length / light),
            radiosity_error: other.radiosity_error / light,
            gradient_error: other.gradient_error * length / light,
            ..other
        };
        if back != estimate {
            findings.push(format!("cubature in units of {length:e} and {light:e} has {back:?}, not {estimate:?}"));
        }
        let after = sampled(&receiver, &emitter)?;
        let limits = std::iter::once((before.radiosity, after.radiosity, light));
        let slopes = (0..3).map(|axis| (before.gradient[axis], after.gradient[axis], light / length));
        for (one, other, unit) in limits.chain(slopes) {
            let numbers = |limits: monte_carlo::Limits, unit: f64| {
                [limits.mean, limits.distribution_free.low, limits.distribution_free.high].map(|number| number / unit)
            };
            if numbers(one, 1.0) != numbers(other, unit) {
                findings.push(format!("samples in units of {length:e} and {light:e}: {other:?}, not {one:?}"));
            }
        }
    }
    Ok(findings)
}

/// Enclosures of each arithmetic on light near the ends of the range, also of what a subnormal part of it is reflected.
fn enclosures(sampler: &mut Sampler) -> Told {
    let mut findings = Vec::new();
    let (receiver, emitter) = lit(&mut sampler.clone(), [1.0, 1.0])?;
    let truth = evaluate_to(&receiver, &emitter, &[], 1e-12)?;
    for [power, dimmed] in [[0, 0], [1000, 0], [-700, 0], [1000, -1066]] {
        let [light, reflectance, unit] = [(1.0, power), (0.5, dimmed), (1.0, power + dimmed)].map(|(m, p)| libm::ldexp(m, p));
        let (_, emitter) = lit(&mut sampler.clone(), [1.0, light])?;
        let receiver = Receiver::new(receiver.position(), receiver.given_normal(), reflectance)?;
        for (arithmetic, digits) in [(Arithmetic::DoubleDouble, 15), (Arithmetic::Limbs, 20), (Arithmetic::Astro, 20)] {
            let request = Request { digits, arithmetic: Some(arithmetic), budget: 100_000 };
            let enclosure = enclose_source(&receiver, &Source::Emitter(&emitter), &request)?;
            let error = (enclosure.radiosity.to_f64() / unit - truth.radiosity).abs();
            let room = enclosure.radiosity.radius() / unit + truth.radiosity_error;
            if !(error <= room && room <= 1e-11 * truth.radiosity) {
                findings.push(format!("{arithmetic:?} of light in units of {unit:e}: off by {error:e}, known to {room:e}"));
            }
        }
    }
    Ok(findings)
}

/// The faces of a closed box that look inward, and of a plate in it, in a unit. The reflectance of the first one rises from 0.075 to 0.175.
fn room([length, light]: [f64; 2]) -> Result<Vec<Face>, radgrad_core::Error> {
    let (low, high) = (DVec3::new(-1.0, 0.5, 2.0), DVec3::new(2.0, 2.5, 4.0));
    let mut faces = Vec::new();
    for axis in 0..3 {
        for (side, at) in [low, high].into_iter().enumerate() {
            let corner = |u: bool, v: bool| {
                let mut corner = at.to_array();
                for (turn, is_high) in [(1, u), (2, v)] {
                    let other = (axis + turn) % 3;
                    corner[other] = if is_high { high } else { low }.to_array()[other];
                }
                DVec3::from(corner)
            };
            let mut corners = vec![corner(false, false), corner(true, false), corner(true, true), corner(false, true)];
            if side == 1 {
                corners.reverse();
            }
            faces.push((corners, 0.1 * (2 * axis + side) as f64 + 0.2));
        }
    }
    let plate = [[0.0, 1.0, 3.0], [1.0, 1.0, 3.25], [1.0, 2.0, 3.25], [0.0, 2.0, 3.0]].map(DVec3::from).to_vec();
    faces.push((plate.clone(), 0.5));
    faces.push((plate.into_iter().rev().collect(), 0.25));
    let face = |(corners, reflectance): (Vec<DVec3>, f64)| {
        let polygon = Polygon::new(corners.into_iter().map(|corner| corner * length).collect())?;
        let emitted = furnace_emission(reflectance) * light;
        Ok(Face { polygon, reflectance, emitted, exchanges: true, pattern: None })
    };
    let mut faces = faces.into_iter().map(face).collect::<Result<Vec<Face>, _>>()?;
    // The face is where x is -1 in the unit: on another one the pattern is another.
    let at = move |point: DVec3| 0.05 + 0.05 * (point.x + point.y + length) / length;
    faces[0].pattern = Some(Pattern::new(move |point| [at(point), furnace_emission(at(point)) * light]));
    faces[0].emitted = light;
    Ok(faces)
}

/// Rays from a face, and the confidence of their intervals.
const RAYS: u32 = 500;
const CONFIDENCE: f64 = 0.999;

/// A closed room in which the radiosity is 1 everywhere, by each kind of walks; and in another unit.
fn rooms(sampler: &mut Sampler) -> Told {
    let mut findings = Vec::new();
    let seed = u64::from(sampler.below(1 << 30));
    let effort = Effort { rays: 1000, rays_a_point: 600, digits: 0, seed, confidence: 1.0 - 1e-7 };
    let said = |length: f64, light: f64| {
        let faces = room([length, light])?;
        // The mean of a pattern is taken of points.
        let rho = |(k, face): (usize, &Face)| face.polygon.area() * if k == 0 { 0.125 } else { face.reflectance };
        let reflected =
            faces.iter().enumerate().map(rho).sum::<f64>() / faces.iter().map(|face| face.polygon.area()).sum::<f64>();
        let scene = Scene::new(faces)?;
        let points = [(0, DVec3::new(-1.0, 1.5, 3.0)), (6, DVec3::new(0.5, 1.5, 3.125))];
        let points = points.map(|(face, position)| Point { face, position: position * length });
        let (mut sums, mut off) = (Vec::new(), 0.0);
        for kind in [Kind::Particles, Kind::NextEvent, Kind::Plain] {
            let truth = scene.truth_of_kind(&points, &effort, kind)?;
            sums.push((reflected, truth.reflected));
            off = largest(off, (1.0 - truth.emitted / light - reflected).abs());
            sums.extend(truth.points.into_iter().map(|point| (1.0, point)));
        }
        let chosen = scene.truth(&points, &effort)?.reflected.interval.width();
        let sights = scene.sights(7, RAYS, seed, CONFIDENCE)?;
        Ok::<_, Box<dyn std::error::Error>>((sums, sights, [chosen, off]))
    };
    let (known, sights, [chosen, off]) = said(1.0, 1.0)?;
    if is_worse(off, 2e-4) {
        findings.push(format!("the mean emission of a furnace is off by {off:e}"));
    }
    for (k, (truth, known)) in known.iter().enumerate() {
        // Walks from lamps say nothing of points.
        if !(known.interval.contains(*truth) && (known.interval.width() < 4.0 || k == 1 || k == 2)) {
            findings.push(format!("number {k} of a furnace is {truth}, not {known:?}"));
        }
    }
    let of_means = known.iter().step_by(3).map(|(_, known)| known.interval.width());
    let least = of_means.fold(f64::INFINITY, smallest);
    if is_worse(chosen, 2.0 * least) {
        findings.push(format!("the kind of walks that is chosen has an interval of {chosen}, another of {least}"));
    }
    // Every ray ends on the front of a face.
    let sum: f64 = sights.iter().map(|sight| sight.value).sum();
    if (sum - 1.0).abs() > 1e-12 {
        findings.push(format!("rays in a closed room end on its faces in {sum} of all cases"));
    }
    // Each end by Chernoff's inequality: with half of the doubt the fraction is not so far from it.
    let part = |q: f64, p: f64| if q == 0.0 { 0.0 } else { q * libm::log(q / p) };
    for Known { value, interval } in sights.iter().filter(|sight| sight.value > 0.0 && sight.value < 1.0) {
        let exponent =
            |p: f64| (part(*value, p) + part(1.0 - value, 1.0 - p)) * f64::from(RAYS) / libm::log(2.0 / (1.0 - CONFIDENCE));
        let is_end = |p: f64| (exponent(p) - 1.0).abs() < 1e-6;
        if !(interval.low < *value && *value < interval.high && is_end(interval.low) && is_end(interval.high)) {
            findings.push(format!("{value} of {RAYS} rays is known to {interval:?}"));
        }
    }
    for [length, light] in UNITS {
        let (other, of_other, _) = said(length, light)?;
        let numbers =
            |known: &Known, unit: f64| [known.value, known.interval.low, known.interval.high].map(|number| number / unit);
        let wrong = known.iter().zip(&other).find(|((_, one), (_, other))| numbers(one, 1.0) != numbers(other, light));
        if let Some(((_, one), (_, other))) = wrong {
            findings.push(format!("walks in units of {length:e} and {light:e}: {other:?}, not {one:?}"));
        }
        if of_other != sights {
            findings.push(format!("rays in units of {length:e}: {of_other:?}, not {sights:?}"));
        }
    }
    Ok(findings)
}

/// Two rectangles with mirrors' reflectances, by the rule of midpoints and a series of reflections.
fn rectangles(sampler: &mut Sampler) -> Told {
    const STEPS: u32 = 16;
    let mut findings = Vec::new();
    let mut between = |low: f64, high: f64| sampler.between(low, high);
    let low = [[0.0, 0.0], [between(-0.5, 0.5), between(-0.5, 0.5)]];
    let rectangles = FacingRectangles {
        low,
        high: low.map(|[x, y]| [x + between(0.5, 1.0), y + between(0.5, 1.0)]),
        gap: between(1.5, 3.0),
        reflectance: [between(0.1, 0.9), between(0.1, 0.9)],
        emitted: [between(0.5, 2.0), between(0.0, 0.5)],
    };
    let nodes = [0, 1].map(|which| {
        let size = [0, 1].map(|axis| rectangles.high[which][axis] - rectangles.low[which][axis]);
        let at = |axis: usize, k: u32| rectangles.low[which][axis] + size[axis] * (f64::from(k) + 0.5) / f64::from(STEPS);
        let places: Vec<[f64; 2]> = (0..STEPS * STEPS).map(|k| [at(0, k / STEPS), at(1, k % STEPS)]).collect();
        (places, size[0] * size[1] / f64::from(STEPS * STEPS))
    });
    let gathered = |[x, y]: [f64; 2], from: usize, light: &[f64]| -> f64 {
        let (places, weight) = &nodes[from];
        let part = |([u, v], light): (&[f64; 2], &f64)| {
            let square = (x - u).powi(2) + (y - v).powi(2) + rectangles.gap.powi(2);
            light * rectangles.gap.powi(2) / (PI * square * square)
        };
        places.iter().zip(light).map(part).sum::<f64>() * weight
    };
    let mut light = [0, 1].map(|which| vec![rectangles.emitted[which]; nodes[which].0.len()]);
    for _ in 0..12 {
        for which in 0..2 {
            let other = light[1 - which].clone();
            let new =
                |at: &[f64; 2]| rectangles.emitted[which] + rectangles.reflectance[which] * gathered(*at, 1 - which, &other);
            light[which] = nodes[which].0.iter().map(new).collect();
        }
    }
    let asked = [(0, nodes[0].0[37]), (1, nodes[1].0[200])];
    let (mean, points) = rectangles.truth(&asked);
    let areas = [0, 1].map(|which| nodes[which].1 * nodes[which].0.len() as f64);
    let reflected =
        |which: usize| light[which].iter().map(|light| light - rectangles.emitted[which]).sum::<f64>() * nodes[which].1;
    let truths = [(reflected(0) + reflected(1)) / (areas[0] + areas[1]), light[0][37], light[1][200]];
    for (known, truth) in std::iter::once(mean).chain(points).zip(truths) {
        // Of midpoints a thousandth of a step squared is left.
        if !((known.value - truth).abs() <= 1e-3 * truth && known.interval.width() <= 1e-9) {
            findings.push(format!("{rectangles:?}: {known:?}, by midpoints {truth}"));
        }
    }
    for [length, light] in UNITS {
        let scaled = |corners: [[f64; 2]; 2]| corners.map(|corner| corner.map(|c| c * length));
        let (low, high) = (scaled(rectangles.low), scaled(rectangles.high));
        let emitted = rectangles.emitted.map(|emitted| emitted * light);
        let other = FacingRectangles { low, high, gap: rectangles.gap * length, emitted, ..rectangles };
        let (again, _) = other.truth(&[]);
        let numbers =
            |known: Known, unit: f64| [known.value, known.interval.low, known.interval.high].map(|number| number / unit);
        if numbers(again, light) != numbers(mean, 1.0) {
            findings.push(format!("{rectangles:?} in units of {length:e} and {light:e}: {again:?}, not {mean:?}"));
        }
    }
    Ok(findings)
}

/// Intervals as decimal numbers.
fn decimals(sampler: &mut Sampler) -> Told {
    let mut findings = Vec::new();
    let value = sampler.sign() * sampler.between(1.0, 10.0) * libm::exp10(sampler.integer(-9, 9) as f64);
    for share in [1e-12, 1e-5, 0.3, 3.0] {
        let interval = Interval::around_decimal(&format!("{value}"), share * value.abs())?;
        let text = interval.to_decimal()?;
        let written: f64 = text.parse()?;
        // Cut after the last digit above the radius, so that the next one is lost.
        let is_right = if share < 1.0 { (written - value).abs() <= 10.0 * interval.radius() } else { text == "0" };
        let digits = text.bytes().take_while(|byte| *byte != b'e').filter(u8::is_ascii_digit).count() as f64;
        if !is_right || digits > 2.0 - libm::log10(share) || share < 1.0 && digits < -libm::log10(share) {
            findings.push(format!("{value} to {share} of it is written {text}"));
        }
    }
    Ok(findings)
}

/// A check by its name.
type Ask = (&'static str, fn(&mut Sampler) -> Told);

/// A flat screen with a corner that turns inward, against the closed form and against its two halves.
fn corners_inward(sampler: &mut Sampler) -> Told {
    let level = |corners: &[[f64; 2]], z: f64| Polygon::new(corners.iter().map(|[x, y]| DVec3::new(*x, *y, z)).collect());
    let lamp = level(&[[-1.0, -1.0], [-1.0, 1.0], [1.0, 1.0], [1.0, -1.0]], 2.0)?;
    let lamp = Emitter::new(lamp, Emission::Constant(1.0))?;
    let place = DVec3::new(sampler.between(-0.25, 0.25), sampler.between(-0.25, 0.25), 0.0);
    let receiver = Receiver::new(place, DVec3::new(0.125, -0.25, 1.0), 0.8)?;
    let mut corners = [[-0.25, -0.25], [-0.25, 0.5], [0.0, 0.5], [0.0, 0.0], [0.375, 0.0], [0.375, -0.25]];
    corners.rotate_left(sampler.below(6) as usize);
    let whole = [level(&corners, 1.0)?];
    let halves = [
        level(&[[-0.25, -0.25], [-0.25, 0.5], [0.0, 0.5], [0.0, -0.25]], 1.0)?,
        level(&[[0.0, -0.25], [0.0, 0.0], [0.375, 0.0], [0.375, -0.25]], 1.0)?,
    ];
    let one = enclose_occluded(&receiver, &lamp, &whole, 15)?.radiosity;
    let both = enclose_occluded(&receiver, &lamp, &halves, 15)?.radiosity;
    let truth = evaluate_to(&receiver, &lamp, &whole, 1e-12)?;
    let error = one.error_of(truth.radiosity);
    let is_right = one.overlaps(&both) && error <= 2.0 * one.radius() + truth.radiosity_error;
    Ok(if is_right { Vec::new() } else { vec![format!("past an L {one:?}, past its halves {both:?}, off by {error:e}")] })
}

/// Contradictions of so many draws of each.
pub(super) fn all_wrong(count: u64) -> Vec<String> {
    let asks: [Ask; 6] = [
        ("points", points),
        ("enclosures", enclosures),
        ("rooms", rooms),
        ("rectangles", rectangles),
        ("decimals", decimals),
        ("corners inward", corners_inward),
    ];
    let asked = |(name, ask): Ask| -> Vec<String> {
        let told = |index: u64| ask(&mut Sampler::new(64, name, index)).unwrap_or_else(|error| vec![format!("{name}: {error}")]);
        (0..count).flat_map(told).collect()
    };
    asks.into_iter().flat_map(asked).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_is_wrong() {
        assert_eq!(all_wrong(2), Vec::<String>::new());
    }
}
