//! Form factors past drawn screens: brackets of every effort, and values, held against what points of a face see in closed form.
//!
//! The light past a screen and the light past the rest of its plane add up to the free light, whatever the screen: so values are held against each other.

use std::f64::consts::PI;

use glam::DVec3;
use radgrad_certificate::{Request, certify};
use radgrad_core::{Emission, Emitter, Polygon, Receiver, Tolerance, evaluate_value};
use radgrad_scene::{Factor, FactorSettings, FormFactors, Scene, gauss_legendre, probes};

use crate::cases::sampler::Sampler;
use crate::checks::exchanges::moved;
use crate::measures::measure::is_worse;
use crate::scenes::draw::{cuboid, quad};

/// Pairs of cells that brackets may take: each of them is proven.
const EFFORTS: [usize; 4] = [1, 6, 30, 150];

/// Screens between two faces, by how they lie.
const KINDS: u64 = 11;

/// The first of them, of which records are.
const RECORDED: u64 = 10;

/// Two faces that look at each other, and what is between.
#[derive(Debug, Clone)]
struct Drawn {
    faces: [Vec<DVec3>; 2],
    screens: Vec<Vec<DVec3>>,
}

impl Drawn {
    fn new(s: &mut Sampler, kind: u64) -> Self {
        let mut face = |z: f64| {
            let [u, v] = [DVec3::new(s.between(0.4, 0.8), 0.0, s.between(-0.1, 0.1)), DVec3::new(0.1, s.between(0.4, 0.8), 0.1)];
            quad(DVec3::new(s.between(-0.5, -0.2), s.between(-0.5, -0.2), z), u, v)
        };
        let (low, mut high) = (face(0.0), face(0.9));
        high.reverse();
        let mut level = |from: f64, to: f64| s.between(from, to);
        let (x, y, z) = (level(-0.2, 0.1), level(-0.2, 0.1), level(0.35, 0.6));
        let (tilt, size) = (DVec3::new(0.0, 0.0, level(-0.1, 0.1)), level(0.15, 0.4));
        let large = |x: f64, z: f64| quad(DVec3::new(x, -2.0, z), DVec3::X * 3.0 + tilt, DVec3::Y * 4.0);
        let triangle =
            |x: f64, y: f64, z: f64| vec![DVec3::new(x, y, z), DVec3::new(x + size, y, z), DVec3::new(x, y + size, z) + tilt];
        let screens = match kind {
            // One edge through the middle, or one polygon of few edges.
            0 => vec![large(x, z)],
            1 => vec![triangle(x, y, z)],
            // Two panels with a common edge.
            2 => {
                let ridge = [DVec3::new(x, y, z), DVec3::new(x, y + size, z)];
                let panel = |to: DVec3| vec![ridge[0], ridge[1], ridge[1] + to, ridge[0] + to];
                vec![panel(DVec3::new(size, 0.0, -0.1)), panel(DVec3::new(-size, 0.0, -0.1)).into_iter().rev().collect()]
            }
            // Rows, the lower ones partly in the shadow of the higher.
            3 => (0..3).map(|k| large(x + 0.12 * f64::from(k), 0.2 + 0.2 * f64::from(k))).collect(),
            // The two sides of a street.
            4 => {
                let other = quad(DVec3::new(x - 3.05, -2.0, z + 0.1), DVec3::X * 3.0, DVec3::Y * 4.0);
                vec![large(x + 0.05, z), other]
            }
            // Upright, with both faces on either side of its plane.
            5 => vec![quad(DVec3::new(x, -0.3, 0.25), DVec3::new(0.05, 0.5, 0.0), DVec3::Z * 0.4)],
            // All is hidden, by two that share an edge.
            6 => {
                let half = |x: f64| quad(DVec3::new(x, -2.0, z), DVec3::X * 2.0, DVec3::Y * 4.0);
                vec![half(-2.0), half(0.0)]
            }
            // With a notch.
            7 => {
                let notched = [[0.0, 0.0], [1.0, 0.0], [1.0, 0.3], [0.3, 0.3], [0.3, 1.0], [0.0, 1.0]];
                vec![notched.map(|[u, v]| DVec3::new(x + size * u, y + size * v, z)).to_vec()]
            }
            // Some small ones.
            8 => (0..3).map(|_| triangle(level(-0.4, 0.3), level(-0.4, 0.3), level(0.2, 0.7))).collect(),
            // One that stands on the lower face, along an edge of it.
            9 => vec![vec![low[0], low[1], low[1] + DVec3::Z * size, low[0] + DVec3::Z * size]],
            // Two blocks, past whose corners segments go.
            _ => {
                let mut block = || {
                    let corner = DVec3::new(level(-0.6, 0.4), level(-0.6, 0.4), level(0.25, 0.45));
                    cuboid(corner, corner + DVec3::new(level(0.1, 0.6), level(0.1, 0.6), level(0.1, 0.3)), false)
                };
                [block(), block()].concat()
            }
        };
        Self { faces: [low, high], screens }
    }

    /// Turned, in another unit, and beside something that is far away for it.
    fn scene(&self, index: u64, power: f64) -> Result<Scene, String> {
        let axes = [[0, 1, 2], [1, 2, 0], [2, 0, 1]][(index % 3) as usize];
        let place = |point: &DVec3| moved(*point, (axes, [1.0; 3])) * power;
        let far = [[0.9, 0.9, -0.9], [0.9, 0.95, -0.9], [0.95, 0.9, -0.9]].map(|corner| DVec3::from(corner) / power);
        let beside = (power < 1.0).then(|| far.to_vec());
        let outlines = self.faces.iter().chain(&self.screens).chain(&beside);
        of_faces(outlines.map(|outline| outline.iter().map(place).collect()))
    }

    /// Contradictions by the certificate of a lamp, which is the second face, at a slant: the first face reflects half, all else is black. Nothing
    /// is where coordinates are 0.
    fn certified(mut self, seed: u64) -> Result<Vec<String>, String> {
        let corners = self.faces.iter_mut().chain(&mut self.screens).flatten();
        corners.for_each(|corner| *corner += DVec3::new(2.0 * corner.z - 3.0, 3.0, 1.5));
        let [rough, factor] = [self.by_points(3)?, self.by_points(5)?];
        let slack = 2.0 * (factor - rough).abs() + 1e-9;
        let said = |error: radgrad_scene::Error| error.to_string();
        let mut scene = Scene::new(["grey"]).map_err(said)?;
        let materials = [[0.5, 0.0], [0.0, 1.0 / PI], [0.0, 0.0]].map(|[rho, radiance]| {
            let name = format!("{rho} {radiance}");
            scene.add_material(name, [rho], [radiance]).map_err(said)
        });
        let mut areas = Vec::new();
        for (k, outline) in self.faces.iter().chain(&self.screens).enumerate() {
            let surface = scene.add_surface(k.to_string());
            let polygon = Polygon::new(outline.clone()).map_err(|error| error.to_string())?;
            areas.push(polygon.area());
            scene.add_face(surface, materials[k.min(2)].clone()?, polygon, None).map_err(said)?;
        }
        let request = Request { width: 0.01, rays: 2000, seed, delta: 1e-6 };
        let reflected = certify(&scene, &request).map_err(|error| error.to_string())?.reflected[0];
        let share = 0.5 * areas[0] / areas.iter().sum::<f64>();
        let [least, most] = [factor - slack, factor + slack].map(|factor| share * factor);
        let is_beside = is_worse(reflected.lower, most) || is_worse(least, reflected.upper);
        Ok(is_beside.then(|| format!("{least:e} to {most:e} is reflected, certified is {reflected:?}")).into_iter().collect())
    }

    /// The factor from the first face to the second, by points of cells along each side of the first.
    fn by_points(&self, cells: u32) -> Result<f64, String> {
        let polygon = |outline: &Vec<DVec3>| Polygon::new(outline.clone()).map_err(|error| error.to_string());
        let from = polygon(&self.faces[0])?;
        let emitter = Emitter::new(polygon(&self.faces[1])?, Emission::Constant(1.0)).map_err(|error| error.to_string())?;
        let screens = self.screens.iter().map(polygon).collect::<Result<Vec<_>, _>>()?;
        let [a, b, _, d] = self.faces[0][..] else { return Err("no quadrilateral".to_owned()) };
        let rule = gauss_legendre(3);
        let mut sum = 0.0;
        for (i, j) in (0..cells).flat_map(|i| (0..cells).map(move |j| (i, j))) {
            for (&(x, w), &(y, z)) in rule.iter().flat_map(|u| rule.iter().map(move |v| (u, v))) {
                let [u, v] = [(i, x), (j, y)].map(|(cell, place)| (f64::from(cell) + 0.5 + 0.5 * place) / f64::from(cells));
                let receiver = Receiver::new(a + (b - a) * u + (d - a) * v, from.normal(), 1.0);
                let receiver = receiver.map_err(|error| error.to_string())?;
                let seen = evaluate_value(&receiver, &emitter, &screens, Tolerance { relative: 0.0, absolute: 1e-10 });
                sum += 0.25 * w * z * seen.map_err(|error| error.to_string())?.radiosity;
            }
        }
        Ok(sum / f64::from(cells * cells))
    }
}

/// A scene of faces, each of a surface of its own.
pub(crate) fn of_faces(outlines: impl Iterator<Item = Vec<DVec3>>) -> Result<Scene, String> {
    let said = |error: radgrad_scene::Error| error.to_string();
    let mut scene = Scene::new(["grey"]).map_err(said)?;
    let material = scene.add_material("grey", [0.5], [0.0]).map_err(said)?;
    for outline in outlines {
        let surface = scene.add_surface("each");
        let polygon = Polygon::new(outline).map_err(|error| error.to_string())?;
        scene.add_face(surface, material, polygon, None).map_err(said)?;
    }
    Ok(scene)
}

/// Settings with which brackets are narrowed as far as the effort goes.
fn narrowed(most_cells: usize) -> FactorSettings {
    FactorSettings { tolerance: 1e-9, most_cells, estimate: 1e-4, most_points: 400, ..FactorSettings::default() }
}

/// The factors of a scene between its first two faces, with every effort.
fn factors(scene: &Scene, order: [usize; 2]) -> Result<Vec<Factor>, String> {
    let factors = FormFactors::new(scene).map_err(|error| error.to_string())?;
    let answer = |&cells: &usize| factors.between(order[0], order[1], &narrowed(cells)).map_err(|error| error.to_string());
    EFFORTS.iter().map(answer).collect()
}

/// The unit in which faces are small beside the scene.
const SMALL: f64 = 1.0 / 4096.0;

/// The largest error of an estimated value, over its estimate.
const OF_ESTIMATE: f64 = 20.0;

/// Violations by the factor between two faces past drawn screens.
///
/// # Errors
/// If a polygon, a scene or a factor is refused: why.
pub fn of_drawn(index: u64) -> Result<Vec<String>, String> {
    let kind = index % KINDS;
    let mut drawn = Drawn::new(&mut Sampler::new(19, "screens", index), kind);
    // Every other one looks at a face that is not convex.
    if let ([a, b, c, d], 1) = (&drawn.faces[1][..], index % 2) {
        drawn.faces[1] = vec![*a, *b, b.midpoint(*c), a.midpoint(*c), c.midpoint(*d), *d];
    }
    let [rough, truth] = [drawn.by_points(3)?, drawn.by_points(5)?];
    let slack = 2.0 * (truth - rough).abs() + 1e-9;
    let mut findings = drawn.clone().certified(index)?;
    findings.iter_mut().for_each(|finding| finding.insert_str(0, &format!("screens {index}: ")));
    for power in [1.0, SMALL] {
        let scene = drawn.scene(index, power)?;
        let [areas, back] = [[0, 1], [1, 0]].map(|order| (scene.faces()[order[0]].polygon().area(), factors(&scene, order)));
        for ((factor, back_factor), cells) in areas.1?.into_iter().zip(back.1?).zip(EFFORTS) {
            let mut hold = |is_right: bool, what: &str| {
                if !is_right {
                    findings.push(format!("screens {index} times {power:e}, {cells} cells: {what}: {factor:?}, it is {truth:e}"));
                }
            };
            let Factor { value, lower, upper, error, estimate, .. } = factor;
            hold(lower - slack <= truth && truth <= upper + slack, "the bracket is beside the factor");
            hold(lower <= value && value <= upper && error >= upper - value && error >= value - lower, "the value is outside");
            hold(!is_worse((value - truth).abs(), OF_ESTIMATE * estimate + slack), "the value is off its estimate");
            let there = [value, lower, upper].map(|figure| figure * areas.0);
            let here = [back_factor.value, back_factor.lower, back_factor.upper].map(|figure| figure * back.0);
            let is_same = there.iter().zip(here).all(|(a, b)| (a - b).abs() <= 1e-13 * there[2]);
            hold(is_same, "it is another one the other way");
            hold(kind != 6 || upper == 0.0, "it is not proven hidden");
        }
    }
    Ok(findings)
}

/// Violations by faces that see nothing of each other: all figures of their factor are 0.
///
/// # Errors
/// If the scene or a factor is refused: why.
pub fn of_nothing() -> Result<Vec<String>, String> {
    let side = quad(DVec3::ZERO, DVec3::X, DVec3::Y);
    let back = side.iter().rev().copied().collect();
    let scene = of_faces([side, back].into_iter())?;
    let factors = FormFactors::new(&scene).map_err(|error| error.to_string())?;
    let nothing = Factor { value: 0.0, lower: 0.0, upper: 0.0, error: 0.0, modelling: 0.0, estimate: 0.0, occluders: 0 };
    let mut findings = Vec::new();
    for [from, to] in [[0, 1], [1, 0], [0, 0]] {
        let said = factors.between(from, to, &FactorSettings::default()).map_err(|error| error.to_string())?;
        if said != nothing {
            findings.push(format!("from {from} to {to}, which see nothing of each other: {said:?}"));
        }
    }
    Ok(findings)
}

/// A rectangle beyond all beams, cut along the lines of the edges of a convex outline in it: the parts outside of each edge and inside those before.
fn rest_of_plane(outline: &[DVec3]) -> Vec<Vec<DVec3>> {
    let z = outline[0].z;
    let mut left = quad(DVec3::new(-3.0, -3.0, z), DVec3::X * 6.0, DVec3::Y * 6.0);
    let mut parts = Vec::new();
    for (k, &a) in outline.iter().enumerate() {
        let along = outline[(k + 1) % outline.len()] - a;
        let heights: Vec<f64> = left.iter().map(|&p| along.cross(p - a).z).collect();
        let (mut inside, mut outside) = (Vec::new(), Vec::new());
        for (i, &p) in left.iter().enumerate() {
            let (next, j) = (left[(i + 1) % left.len()], (i + 1) % left.len());
            if heights[i] >= 0.0 {
                inside.push(p);
            } else {
                outside.push(p);
            }
            if heights[i] * heights[j] < 0.0 {
                let cut = p + (next - p) * (heights[i] / (heights[i] - heights[j]));
                inside.push(cut);
                outside.push(cut);
            }
        }
        if outside.len() > 2 {
            parts.push(outside);
        }
        left = inside;
    }
    parts
}

/// Violations by a screen and the rest of its plane, each alone: values by many digits, by few and by looks, and brackets.
///
/// # Errors
/// If a polygon, a scene or a factor is refused: why.
pub fn of_complements(index: u64) -> Result<Vec<String>, String> {
    let s = &mut Sampler::new(20, "complements", index);
    let mut drawn = Drawn::new(s, 1);
    let level = drawn.screens[0][0].z;
    drawn.screens[0].iter_mut().for_each(|corner| corner.z = level);
    let others = rest_of_plane(&drawn.screens[0]);
    let faces = || drawn.faces.iter().cloned();
    let scenes = [of_faces(faces())?, of_faces(faces().chain(drawn.screens.clone()))?, of_faces(faces().chain(others))?];
    let ready = [0, 1, 2].map(|k| FormFactors::new(&scenes[k]).map_err(|error| error.to_string()));
    let [free, past, through] = ready;
    let (free, past, through) = (free?, past?, through?);
    let digits = FactorSettings { tolerance: 1e-3, most_cells: 100, estimate: 1e-8, most_points: 4000, ..narrowed(0) };
    let looks = FactorSettings { tolerance: 1.0, estimate: 1.0, ..narrowed(10) };
    let mut findings = Vec::new();
    for (name, settings, most) in [("many digits", digits, 1e-7), ("few digits", narrowed(60), 1e-3), ("looks", looks, 1e-5)] {
        let [all, past, others] =
            [&free, &past, &through].map(|of| of.between(0, 1, &settings).map_err(|error| error.to_string()));
        let (all, past, others) = (all?, past?, others?);
        let apart = (past.value + others.value - all.value).abs();
        if is_worse(apart, most) {
            findings.push(format!("complements {index}, {name}: {past:?} and {others:?} are not {all:?}, by {apart:e}"));
        }
        if past.lower + others.lower > all.upper || past.upper + others.upper < all.lower {
            findings.push(format!("complements {index}, {name}: brackets {past:?} and {others:?} are beside {all:?}"));
        }
    }
    Ok(findings)
}

/// Brackets with every effort, by their middle and half their width, and the value with its estimate: figures to be remembered.
///
/// # Errors
/// If a polygon, a scene or a factor is refused: why.
pub(crate) fn recorded(index: u64) -> Result<Vec<(f64, f64)>, String> {
    let drawn = Drawn::new(&mut Sampler::new(21, "screens", index), index % RECORDED);
    let answer = |factor: &Factor| {
        [(0.5 * (factor.lower + factor.upper), 0.5 * (factor.upper - factor.lower)), (factor.value, factor.estimate)]
    };
    Ok(factors(&drawn.scene(index, 1.0)?, [0, 1])?.iter().flat_map(answer).collect())
}

/// How many of its lengths an edge starts before where it does.
const EARLIER: [f64; 4] = [0.0, 1024.0, (1u64 << 20) as f64, (1u64 << 26) as f64];

/// Bounds on the share of segments that pass outside one edge, which starts farther and farther away on its line: rounding takes more and more; and
/// that share by points.
fn shares(index: u64) -> Result<([[f64; 2]; 4], f64), String> {
    let s = &mut Sampler::new(25, "shares", index);
    let size = [0.5, 0.03, 1e-3][s.below(3) as usize];
    let mut cell = |z: f64| {
        let corners = (0..3 + s.below(3)).map(|k| {
            let turn = f64::from(k);
            DVec3::new(libm::cos(turn) * size, libm::sin(turn) * size, z)
        });
        Polygon::new(corners.collect()).map_err(|error| error.to_string())
    };
    let [a, b] = [cell(0.0)?, cell(1.0)?];
    // Few digits, so that all starts are on one line exactly.
    let mut few = |range: f64| (s.between(-range, range) * 256.0).round() / 256.0;
    let (start, along) = (DVec3::new(few(0.3) * size, few(0.3) * size, 0.5 + few(0.2)), DVec3::new(few(1.0), few(1.0), few(0.3)));
    let bounds = EARLIER.map(|lengths| {
        let from = start - along * lengths;
        probes::share_outside([&a, &b], [from, from + along])
    });
    Ok((bounds, share_by_points([a.vertices(), b.vertices()], start, along)))
}

/// The share of the segments from one outline to another that have a line on the one side, by points of the first.
fn share_by_points([from, to]: [&[DVec3]; 2], start: DVec3, along: DVec3) -> f64 {
    let area = |outline: &[DVec3]| {
        let fan = outline.windows(2).map(|two| (two[0] - outline[0]).cross(two[1] - outline[0]));
        0.5 * fan.sum::<DVec3>().length()
    };
    // Of the part where the heights are above 0.
    let part = |heights: &dyn Fn(DVec3) -> f64| {
        let mut part = Vec::new();
        for (k, &p) in to.iter().enumerate() {
            let next = to[(k + 1) % to.len()];
            let [h, other] = [heights(p), heights(next)];
            if h >= 0.0 {
                part.push(p);
            }
            if h * other < 0.0 {
                part.push(p + (next - p) * (h / (h - other)));
            }
        }
        if part.len() > 2 { area(&part) / area(to) } else { 0.0 }
    };
    let mut share = 0.0;
    for two in from[1..].windows(2) {
        let triangle = [from[0], two[0], two[1]];
        let weight = area(&triangle) / (area(from) * f64::from(POINTS * POINTS));
        // Middles of the parts either way up.
        for (i, j) in (0..POINTS).flat_map(|i| (0..POINTS).map(move |j| (i, j))) {
            let [u, v, third] = if i + j < POINTS { [i, j, 1] } else { [POINTS - 1 - i, POINTS - 1 - j, 2] };
            let [u, v] = [u, v].map(|place| (f64::from(place) + f64::from(third) / 3.0) / f64::from(POINTS));
            let x = triangle[0] + (triangle[1] - triangle[0]) * u + (triangle[2] - triangle[0]) * v;
            let normal = (start - x).cross(along);
            share += weight * part(&|y| normal.dot(y - x));
        }
    }
    share
}

/// Points along a side, and the part of a share that they leave.
const POINTS: u32 = 10;
const OF_POINTS: f64 = 0.01;

/// Violations by shares beside a drawn edge: they are the same wherever it starts on its line, and that of points.
///
/// # Errors
/// If a cell is refused: why.
pub fn of_shares(index: u64) -> Result<Vec<String>, String> {
    let (entries, share) = shares(index)?;
    let [low, high] = entries[0];
    if is_worse(low, share + OF_POINTS) || is_worse(share - OF_POINTS, high) {
        return Ok(vec![format!("share {index} is in {:?}, by points it is {share}", entries[0])]);
    }
    let apart = entries.iter().find(|[least, most]| !(least <= &high && &low <= most));
    Ok(apart.map(|other| format!("share {index} is in {:?}, and in {other:?}", entries[0])).into_iter().collect())
}

/// The same by their middle and half their width: figures to be remembered.
///
/// # Errors
/// If a cell is refused: why.
pub(crate) fn recorded_shares(index: u64) -> Result<Vec<(f64, f64)>, String> {
    Ok(shares(index)?.0.map(|[least, most]| (0.5 * (least + most), 0.5 * (most - least))).to_vec())
}

/// Violations by the value of a factor of which little is asked, past a screen that leaves the far corners of two unit squares alone: no point inside
/// either one sees much past it, and yet there is light. Of the sums `u` of all four distances to the corner's edges those below `2 d` are free.
///
/// # Errors
/// If there is no such factor: why.
pub fn of_corners(index: u64) -> Result<Vec<String>, String> {
    let d = Sampler::new(42, "corners", index).between(0.02, 0.2);
    let (low, mut high) = (quad(DVec3::ZERO, DVec3::X, DVec3::Y), quad(DVec3::Z, DVec3::X, DVec3::Y));
    high.reverse();
    let screen = [[-1.0, -1.0], [2.0, -1.0], [2.0, -d], [-d, 2.0], [-1.0, 2.0]].map(|[x, y]| DVec3::new(x, y, 0.5));
    let scene = of_faces([low, high, screen.to_vec()].into_iter())?;
    let said = |error: radgrad_scene::Error| error.to_string();
    let factors = FormFactors::new(&scene).map_err(said)?;
    let settings = FactorSettings { tolerance: 0.5, estimate: 1.0, relative_estimate: 1.0, ..FactorSettings::default() };
    // The kernel at the corners is `1/pi`, and less elsewhere; the free pairs are a corner of a hypercube.
    let light = (2.0 * d).powi(4) / (24.0 * PI);
    let mut findings = Vec::new();
    for [from, to] in [[0, 1], [1, 0]] {
        let Factor { value, upper, estimate, .. } = factors.between(from, to, &settings).map_err(said)?;
        let least = light / (1.0 + 4.0 * d * d).powi(2);
        if is_worse(value - light, estimate) || is_worse(least - value, estimate) || is_worse(least, upper) {
            findings
                .push(format!("corners {index}: {value:e} to {estimate:e} and at most {upper:e}, it is {least:e} to {light:e}"));
        }
    }
    Ok(findings)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn factors_past_screens_are_what_points_see_and_add_up_with_the_rest_of_the_plane() {
        for index in 0..KINDS {
            assert_eq!(of_drawn(index), Ok(Vec::new()));
        }
        assert_eq!(of_complements(0), Ok(Vec::new()));
        for index in 0..40 {
            assert_eq!(of_shares(index), Ok(Vec::new()));
        }
    }
}
