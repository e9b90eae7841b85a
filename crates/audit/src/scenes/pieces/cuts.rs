//! Lines where the light of a lamp changes suddenly, and the parts that a face is cut into along such lines.

use std::f64::consts::TAU;
use std::sync::Mutex;

use glam::DVec3;
use radgrad_core::Polygon;
use radgrad_scene::{largest, smallest};
use radgrad_solver::{Element, Mesh, parts};

use super::{Wrong, exceeds, is_hidden, named, named_findings, scene_of, turned};
use crate::cases::sampler::Sampler;
use crate::scenes::draw::quad;

/// The part of a size within which points are on a line.
const ON: f64 = 1e-7;

/// Places at which the sight of a lamp changes, and those of them that no line passes.
#[derive(Debug, Default)]
struct Counts {
    changes: usize,
    missed: usize,
}

/// Findings on shadow lines past drawn screens, in so many rooms.
#[must_use]
pub fn shadow_lines(cases: u64) -> Vec<String> {
    let (mut findings, mut counts) = (Vec::new(), Counts::default());
    for index in 0..cases {
        findings.extend(named("shadow lines", index, lines_of(index, &mut counts)));
    }
    let Counts { changes, missed } = counts;
    // A change that is seen on less than a twelfth of a line may be missed.
    if 20 * missed > changes || changes == 0 {
        findings.push(format!("of {changes} places where the sight of a lamp changes no line passes {missed}"));
    }
    for unit in [1.0, 1.0 / (1u64 << 40) as f64, (1u64 << 40) as f64] {
        for (index, centre) in (0..).zip([DVec3::ZERO, DVec3::new(3.0, -5.0, 7.0)]) {
            findings.extend(named("parallel lines", index, parallel_lines(centre, unit)));
        }
    }
    findings
}

/// A floor, a lamp over it that faces down, and screens: some that rise from below the floor or above the lamp, and one that stands on a side of
/// the floor.
fn room(index: u64) -> Vec<Vec<DVec3>> {
    let s = &mut Sampler::new(23, "shadow lines", index);
    let level = |corners: &[[f64; 2]]| corners.iter().map(|[x, y]| DVec3::new(*x, *y, 0.0)).collect::<Vec<_>>();
    let floor = match index % 3 {
        0 => level(&[[-2.0, -2.1], [2.2, -1.8], [1.9, 2.0], [-2.1, 1.7]]),
        1 => level(&[[-2.4, -2.0], [2.3, -2.2], [0.4, 2.6]]),
        _ => level(&[[-2.0, -2.0], [2.0, -2.0], [2.0, 0.3], [0.4, 0.3], [0.4, 2.0], [-2.0, 2.0]]),
    };
    let tilt = |s: &mut Sampler| s.between(-0.2, 0.2);
    let (u, v) = (DVec3::new(s.between(0.2, 0.6), 0.1, tilt(s)), DVec3::new(0.1, s.between(0.2, 0.6), tilt(s)));
    let lamp = DVec3::new(s.between(-0.5, 0.3), s.between(-0.5, 0.3), 2.0);
    let lamp = if s.one_in(2) { vec![lamp, lamp + v, lamp + u] } else { vec![lamp, lamp + v, lamp + u + v, lamp + u] };
    let mut faces = vec![floor.clone(), lamp];
    for k in 0..2 {
        let (u, v) = (DVec3::new(s.between(0.4, 1.0), tilt(s), tilt(s)), DVec3::new(tilt(s), s.between(0.4, 1.0), tilt(s)));
        let rise = if s.one_in(2) { DVec3::Z * s.between(0.6, 1.6) } else { DVec3::ZERO };
        let height = if k == 0 { s.between(-0.5, 0.4) } else { s.between(0.7, 1.5) };
        let low = DVec3::new(s.between(-1.3, 0.6), s.between(-1.3, 0.6), height);
        faces.push(if s.one_in(2) {
            vec![low, low + u, low + v + rise]
        } else {
            vec![low, low + u, low + u + v + rise, low + v + rise]
        });
    }
    let side = s.below(u32::try_from(floor.len()).unwrap_or(3)) as usize;
    let [a, b] = [floor[side], floor[(side + 1) % floor.len()]];
    faces.push(vec![a, b, b + DVec3::Z * 0.8, a + DVec3::Z * 0.8]);
    let (turn, offset) = (turned(s), s.cube() * 3.0);
    faces.into_iter().map(|corners| corners.into_iter().map(|p| turn(p) + offset).collect()).collect()
}

/// Findings on the lines of a square screen under a square lamp, about a centre: two ends of a penumbra on each side, each line once.
fn parallel_lines(centre: DVec3, unit: f64) -> Wrong {
    let square = |half: f64, z: f64| {
        let side = 2.0 * half * unit;
        quad((centre + DVec3::new(-half, -half, z)) * unit, DVec3::X * side, DVec3::Y * side)
    };
    let lamp = square(0.5, 2.0).into_iter().rev().collect();
    let faces = vec![square(4.0, 0.0), lamp, square(1.0, 1.0)];
    let mesh = Mesh::new(&scene_of(faces)?, 0).map_err(|error| error.to_string())?;
    let lines: Vec<[DVec3; 2]> =
        parts::shadow_lines(&mesh, 0, 1).into_iter().map(|ends| ends.map(|p| p / unit - centre)).collect();
    let mut findings = Vec::new();
    for axis in [0, 1] {
        for place in [-2.5, -1.5, 1.5, 2.5] {
            let count = lines.iter().filter(|ends| ends.iter().all(|p| (p[axis] - place).abs() <= ON)).count();
            if count != 1 {
                findings.push(format!("about {centre} in a unit of {unit:e} {count} lines are at {place}"));
            }
        }
    }
    if lines.len() != 8 {
        findings.push(format!("about {centre} in a unit of {unit:e} there are {} lines, 8 are known", lines.len()));
    }
    Ok(findings)
}

/// The shares of two lines, each by a point and a direction, at which they meet; none if they are apart.
fn meet([a, along]: [DVec3; 2], [b, other]: [DVec3; 2]) -> Option<[f64; 2]> {
    let across = along.cross(other);
    let square = across.length_squared();
    let share = |direction: DVec3| (b - a).cross(direction).dot(across) / square;
    let [r, t] = [share(other), share(along)];
    let apart = (a + along * r - b - other * t).length();
    (square > 0.0 && apart <= 1e-8 * (along.length() + other.length())).then_some([r, t])
}

/// The distance of a point from a line.
fn distance(p: DVec3, [a, b]: [DVec3; 2]) -> f64 {
    (p - a).reject_from((b - a).normalize()).length()
}

/// The sides of a polygon.
fn sides(v: &[DVec3]) -> impl Iterator<Item = [DVec3; 2]> {
    (0..v.len()).map(|i| [v[i], v[(i + 1) % v.len()]])
}

/// Whether, seen from x, a corner of the lamp is on a side of a screen, a corner of a screen on a side of the lamp, or the lamp is edge-on.
fn is_aligned(x: DVec3, lamp: &Polygon, screens: &[&Polygon]) -> bool {
    let within = |share: f64| (-1e-6..=1.0 + 1e-6).contains(&share);
    let corner_behind = |v: DVec3, [a, b]: [DVec3; 2]| meet([x, v - x], [a, b - a]).is_some_and(|[r, t]| within(r) && within(t));
    let side_behind =
        |o: DVec3, [p, q]: [DVec3; 2]| meet([x, o - x], [p, q - p]).is_some_and(|[r, t]| r >= 1.0 - 1e-6 && within(t));
    lamp.normal().dot(x - lamp.vertices()[0]).abs() <= 1e-8
        || screens.iter().any(|screen| {
            let v = screen.vertices();
            lamp.vertices().iter().any(|&corner| sides(v).any(|side| corner_behind(corner, side)))
                || v.iter().any(|&corner| sides(lamp.vertices()).any(|side| side_behind(corner, side)))
        })
}

fn lines_of(index: u64, counts: &mut Counts) -> Wrong {
    let s = &mut Sampler::new(24, "places", index);
    let mesh = Mesh::new(&scene_of(room(index))?, 0).map_err(|error| error.to_string())?;
    let lines = parts::shadow_lines(&mesh, 0, 1);
    let (floor, lamp) = (&mesh.polygons()[0], &mesh.polygons()[1]);
    let screens: Vec<&Polygon> = mesh.polygons().iter().skip(2).collect();
    let level = ON * floor.size();
    let mut findings = Vec::new();
    for (place, &[a, b]) in lines.iter().enumerate() {
        let middle = (1..10).map(|k| a.lerp(b, 0.1 * f64::from(k)));
        if let Some(x) = middle.into_iter().find(|&x| !is_aligned(x, lamp, &screens)) {
            findings.push(format!("at {x} of the line from {a} to {b} nothing is in line with the lamp"));
        }
        let is_outside = |p: DVec3| {
            floor.normal().dot(p - floor.vertices()[0]).abs() > level
                || sides(floor.vertices()).all(|side| distance(p, side) > floor.size())
        };
        if [a, b].into_iter().any(is_outside)
            || sides(floor.vertices()).any(|side| distance(a, side) <= level && distance(b, side) <= level)
        {
            findings.push(format!("the line from {a} to {b} is along a side of the floor, or off it"));
        }
        if lines[..place]
            .iter()
            .any(|&other| distance(a, other) <= level && distance(b, other) <= level && (meets(other, a) || meets(other, b)))
        {
            findings.push(format!("the line from {a} to {b} is there twice"));
        }
    }
    // Each side of a screen passes corners of the lamp, and each of its corners the lamp's sides.
    for screen in &screens {
        for side in sides(screen.vertices()) {
            for (feature, target) in [
                (side[0].lerp(side[1], s.uniform()), lamp.vertices()[s.below(3) as usize]),
                (side[0], {
                    let v = lamp.vertices();
                    v[1].lerp(v[2], s.uniform())
                }),
            ] {
                if let Some(x) = seen_change(&mesh, feature, target) {
                    counts.changes += 1;
                    counts.missed += usize::from(!lines.iter().any(|&line| distance(x, line) <= level));
                }
            }
        }
    }
    Ok(findings)
}

/// Whether a point of a segment's line is between its ends.
fn meets([a, b]: [DVec3; 2], p: DVec3) -> bool {
    let share = (p - a).dot(b - a) / (b - a).length_squared();
    (1e-6..=1.0 - 1e-6).contains(&share)
}

/// The place inside the floor from which a feature of a screen is seen before a point of the lamp's outline, if the lamp is there in part hidden and in
/// part seen around that.
fn seen_change(mesh: &Mesh, feature: DVec3, target: DVec3) -> Option<DVec3> {
    let [floor, lamp] = [0, 1].map(|face| &mesh.polygons()[face]);
    let height = |p: DVec3| floor.normal().dot(p - floor.vertices()[0]);
    if !(height(feature) > 0.01 && height(feature) < 0.95 * height(target)) {
        return None;
    }
    let x = target + (feature - target) * (height(target) / (height(target) - height(feature)));
    let is_in = |element: &Element| element.face() == 0 && element.excess(element.reference(x)) < -0.01;
    if !mesh.elements().iter().any(is_in) || lamp.normal().dot(x - lamp.vertices()[0]) < 0.05 {
        return None;
    }
    let (length, (u, v)) = ((target - x).length(), (target - x).normalize().any_orthonormal_pair());
    let hidden = (0..16).filter(|&k| {
        let angle = TAU * (f64::from(k) + 0.3) / 16.0;
        let end = x + (target - x) * 0.999 + (u * angle.cos() + v * angle.sin()) * (1e-4 * length);
        mesh.polygons().iter().skip(2).any(|screen| is_hidden(x, end, screen))
    });
    (4..=12).contains(&hidden.count()).then_some(x)
}

/// Findings on parts of triangles and parallelograms, in so many cases.
#[must_use]
pub fn partitions(cases: u64) -> Vec<String> {
    named_findings("partition", cases, partition_of)
}

/// Area of a triangle or a parallelogram, and its longest side or diagonal over the height on that.
fn shape(v: &[DVec3]) -> [f64; 2] {
    let twice = (v[1] - v[0]).cross(v[2] - v[0]).length();
    let area = if v.len() == 3 { 0.5 * twice } else { twice };
    let square = v.iter().flat_map(|a| v.iter().map(move |b| a.distance_squared(*b))).fold(0.0, largest);
    [area, square / area]
}

/// The light of a jump from 1 to 2 across a line.
fn jump([a, b]: [DVec3; 2], normal: DVec3) -> impl Fn(DVec3) -> f64 {
    move |p: DVec3| if normal.cross(b - a).dot(p - a) > 0.0 { 2.0 } else { 1.0 }
}

fn partition_of(index: u64) -> Wrong {
    let s = &mut Sampler::new(25, "partitions", index);
    let turn = turned(s);
    let (u, v) = (turn(DVec3::X * s.between(0.8, 1.3)), turn(DVec3::new(s.between(-0.3, 0.3), s.between(0.8, 1.3), 0.0)));
    let (origin, normal) = (s.cube() * 2.0, turn(DVec3::Z));
    let at = |[a, b]: [f64; 2]| origin + u * a + v * b;
    let is_triangle = index % 2 == 1;
    let whole: Vec<DVec3> = if is_triangle {
        vec![at([0.0; 2]), at([1.0, 0.0]), at([0.0, 1.0])]
    } else {
        vec![at([0.0; 2]), at([1.0, 0.0]), at([1.0; 2]), at([0.0, 1.0])]
    };
    let degree = (index / 2 % 3) as usize;
    let [area, _] = shape(&whole);
    let cut_of = |whole: &[DVec3], line: [DVec3; 2], unit: f64, ends: (usize, f64), asked: &Mutex<Vec<Vec<DVec3>>>| {
        let radiosity = jump(line, normal);
        let light = |places: &[DVec3]| {
            asked.lock().unwrap_or_else(std::sync::PoisonError::into_inner).push(places.to_vec());
            places.iter().map(|&p| radiosity(p / unit)).collect()
        };
        let scaled: Vec<DVec3> = whole.iter().map(|&p| p * unit).collect();
        parts::partition(&scaled, &[line.map(|p| p * unit)], degree, ends, &light).map_err(|error| error.to_string())
    };
    let cut = |line, unit, ends, asked: &Mutex<Vec<Vec<DVec3>>>| cut_of(&whole, line, unit, ends, asked);
    let mut findings = Vec::new();
    // Across the middle: the light is cut where it jumps, and in any unit of length likewise.
    let (from, to) = (s.between(0.2, 0.5), s.between(0.2, 0.5));
    let line = [at([-0.1, from]), at([1.1, if is_triangle || degree == 0 { to } else { from }])];
    let asked = Mutex::default();
    let pieces = cut(line, 1.0, (24, 1e-6), &asked)?;
    let covered: f64 = pieces.iter().map(|piece| shape(piece)[0]).sum();
    if exceeds((covered - area).abs(), 1e-9 * area) {
        findings.push(format!("parts have the area {covered}, the whole has {area}"));
    }
    let radiosity = jump(line, normal);
    for piece in &pieces {
        let middle = piece.iter().sum::<DVec3>() / piece.len() as f64;
        let is_turned = sides(piece).any(|[a, b]| normal.dot((b - a).cross(middle - a)) <= 0.0);
        let is_outside = piece.iter().any(|p| sides(&whole).any(|[a, b]| normal.dot((b - a).cross(*p - a)) < -1e-9));
        let is_no_shape = piece.len() > 4 || piece.len() == 4 && (piece[0] + piece[2] - piece[1] - piece[3]).length() > 1e-9;
        if is_turned || is_outside || is_no_shape || piece.iter().any(|p| radiosity(p.lerp(middle, 1e-6)) != radiosity(middle)) {
            findings.push(format!("a part is no triangle or parallelogram of the whole on one side of the jump: {piece:?}"));
        }
    }
    let unit = 1.0 / (1u64 << 40) as f64;
    let tiny = cut(line, unit, (24, 1e-6), &Mutex::default())?;
    if tiny.concat() != pieces.concat().into_iter().map(|p| p * unit).collect::<Vec<_>>() {
        findings.push(format!("{} parts are others where lengths are {unit:e} of what they were", pieces.len()));
    }
    // Where light is asked for: all over the whole, and nowhere else.
    let asked = asked.into_inner().unwrap_or_default();
    let is_inside = |p: &DVec3| sides(&whole).all(|[a, b]| normal.dot((b - a).cross(*p - a)) >= -1e-12);
    if !asked.iter().flatten().all(is_inside) {
        findings.push("light is asked for beside the part".to_owned());
    }
    let Some(first) = asked.first().filter(|places| places.len() > 100) else { return Err("no light is asked for".to_owned()) };
    let centre = |of: &[DVec3]| of.iter().sum::<DVec3>() / of.len() as f64;
    let apart = (centre(first) - centre(&whole)).length();
    if exceeds(apart, 0.01) {
        findings.push(format!("light is asked for {apart} from the middle in the mean"));
    }
    // It is cut until polynomials leave as little as is asked for, and no further.
    let expected = residual(&whole, degree, first, &radiosity)?;
    let count = |error: f64| cut(line, 1.0, (24, error), &Mutex::default()).map(|pieces| pieces.len());
    let [enough, more] = [count(expected * (1.0 + 1e-7))?, count(expected * (1.0 - 1e-7))?];
    if enough != 1 || more == 1 {
        findings.push(format!("{enough} parts are enough for {expected:e}, {more} for a little less"));
    }
    // At a corner, and along a side: no part is too small, or too long. One cut is all that there may be.
    let [at_corner, along] = if is_triangle { [3, 3] } else { [4, 2] };
    for (ends, most) in [([[0.09, -0.01], [-0.01, 0.09]], at_corner), ([[-0.1, 0.015], [1.1, 0.015]], along)] {
        let pieces = cut(ends.map(at), 1.0, (most, 1e-6), &Mutex::default())?;
        let shapes: Vec<[f64; 2]> = pieces.iter().map(|piece| shape(piece)).collect();
        let [least, longest] =
            [shapes.iter().map(|of| of[0]).fold(area, smallest), shapes.iter().map(|of| of[1]).fold(0.0, largest)];
        if least < 0.0099 * area || exceeds(longest, 50.0) {
            findings.push(format!("a part has the share {} of the area, one is {longest} as long as wide", least / area));
        }
    }
    // Along a seventh of a part that is ten times as long or as wide, or of one in another unit, it is not cut, though the light jumps all along.
    for (is_wide, unit) in [(false, 1.0), (true, 1.0), (false, unit), (true, unit)] {
        let (u, v) = if is_wide { (u, v * 10.0) } else { (u * 10.0, v) };
        let at = |[a, b]: [f64; 2]| origin + u * a + v * b;
        let long = if is_triangle {
            vec![at([0.0; 2]), at([1.0, 0.0]), at([0.0, 1.0])]
        } else {
            vec![at([0.0; 2]), at([1.0, 0.0]), at([1.0; 2]), at([0.0, 1.0])]
        };
        let line = if is_wide { [[0.41, 0.22], [0.41, 0.36]] } else { [[0.22, 0.41], [0.36, 0.41]] }.map(at);
        let pieces = cut_of(&long, line, unit, (along, 1e-6), &Mutex::default())?;
        let is_on = |p: DVec3| distance(p / unit, line) <= ON;
        if pieces.iter().any(|piece| sides(piece).any(|[a, b]| is_on(a) && is_on(b))) {
            findings.push(format!("in a unit of {unit:e} a part is cut along a line that is short"));
        }
    }
    Ok(findings)
}

/// The root mean square that the polynomials of a degree leave of light at some places, expected of all places: by Gram and Schmidt.
fn residual(whole: &[DVec3], degree: usize, places: &[DVec3], light: &dyn Fn(DVec3) -> f64) -> Result<f64, String> {
    let mesh = Mesh::new(&scene_of(vec![whole.to_vec()])?, degree).map_err(|error| error.to_string())?;
    let (element, basis) = (&mesh.elements()[0], mesh.basis(0));
    let rows: Vec<Vec<f64>> = places.iter().map(|&p| basis.values(element.reference(p))).collect();
    let mut residual: Vec<f64> = places.iter().map(|&p| light(p)).collect();
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let take = |from: &mut [f64], along: &[f64]| {
        let share = dot(from, along) / dot(along, along);
        from.iter_mut().zip(along).for_each(|(from, along)| *from -= share * along);
    };
    let mut columns: Vec<Vec<f64>> = Vec::new();
    for index in 0..basis.len() {
        let mut column: Vec<f64> = rows.iter().map(|row| row[index]).collect();
        columns.iter().for_each(|before| take(&mut column, before));
        take(&mut residual, &column);
        columns.push(column);
    }
    Ok((dot(&residual, &residual) / (places.len() - basis.len()) as f64).sqrt())
}
