//! Scenes as files of the world have them: walls cut in every way and rounded, faces on faces and faces twice, plates of two sides among
//! more than a thousand faces.

use glam::DVec3;
use radgrad_oracle::scene::known::furnace_emission;

use super::{CEILING, FLOOR, Room, cuboid, finish, point_on, quad, reversed, turn, turning};
use crate::cases::sampler::Sampler;
use crate::scenes::model::{Change, Exact, Model, Part, Probe};
use crate::scenes::written::{Lies, Rounding, Window, Written};

/// Turned, mostly moved, and written with one of three roundings.
fn written(s: &mut Sampler) -> Change {
    let axes = turning(s);
    let by = if s.below(10) < 3 { DVec3::ZERO } else { s.direction() * s.spread(-4, 13) };
    let rounding = [Rounding::Single, Rounding::Decimals(6), Rounding::Decimals(3)][s.below(3) as usize];
    Change::File(Written { axes, by, rounding })
}

/// Outlines that fill a rectangle with the sides `u` and `v`.
fn cut_wall(origin: DVec3, u: DVec3, v: DVec3, s: &mut Sampler) -> Vec<Vec<DVec3>> {
    let point = |[x, y]: [f64; 2]| origin + u * x + v * y;
    let outlines: Vec<Vec<[f64; 2]>> = match s.below(5) {
        0 => vec![vec![[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]],
        1 => {
            // Seven to nine vertices: some on the edges.
            let [a, b] = [s.between(0.05, 0.5), s.between(0.5, 0.95)];
            let below = [[a, 0.0], [b, 0.0]][..s.below(3) as usize].to_vec();
            let corners =
                [[1.0, 0.0], [1.0, s.between(0.05, 0.5)], [1.0, s.between(0.5, 0.95)], [1.0, 1.0], [s.between(0.05, 0.95), 1.0]];
            vec![[vec![[0.0, 0.0]], below, corners.to_vec(), vec![[0.0, 1.0]]].concat()]
        }
        2 => guillotine(Window::WHOLE, 2, s),
        3 => {
            let t = [s.between(0.1, 0.9), 0.0];
            vec![vec![[0.0, 0.0], t, [0.0, 1.0]], vec![t, [1.0, 0.0], [1.0, 1.0]], vec![t, [1.0, 1.0], [0.0, 1.0]]]
        }
        _ => {
            // The first is a needle.
            let t = [s.between(0.2, 0.8), s.spread(-10, -5) / v.length()];
            vec![
                vec![[0.0, 0.0], [1.0, 0.0], t],
                vec![[0.0, 0.0], t, [0.0, 1.0]],
                vec![t, [1.0, 0.0], [1.0, 1.0]],
                vec![t, [1.0, 1.0], [0.0, 1.0]],
            ]
        }
    };
    outlines.into_iter().map(|outline| outline.into_iter().map(point).collect()).collect()
}

/// A rectangle cut across, and its parts again, so often or less.
fn guillotine(of: Window, depth: u32, s: &mut Sampler) -> Vec<Vec<[f64; 2]>> {
    let Window { low, high } = of;
    if depth == 0 || s.one_in(5) {
        return vec![vec![low, [high[0], low[1]], high, [low[0], high[1]]]];
    }
    let axis = s.below(2) as usize;
    let middle = low[axis] + s.between(0.2, 0.8) * (high[axis] - low[axis]);
    let (mut first, mut second) = (of, of);
    (first.high[axis], second.low[axis]) = (middle, middle);
    [guillotine(first, depth - 1, s), guillotine(second, depth - 1, s)].concat()
}

/// A closed box with sides of 1 to 6.
pub(in crate::scenes) fn rounded(s: &mut Sampler) -> Model {
    let size = DVec3::new(s.between(1.0, 6.0), s.between(1.0, 6.0), s.between(1.0, 6.0));
    let mut parts = Vec::new();
    for wall in cuboid(DVec3::ZERO, size, true) {
        let rho = s.between(0.1, 0.9);
        let outlines = cut_wall(wall[0], wall[1] - wall[0], wall[3] - wall[0], s);
        parts.extend(outlines.into_iter().map(|corners| Part::new(corners, rho, furnace_emission(rho))));
    }
    let mut model = finish(parts, s);
    model.closed = true;
    model.change = written(s);
    model
}

/// A room with windows on a wall, a lamp on its ceiling, a rug on its floor, and faces that are there twice.
pub(in crate::scenes) fn nested(s: &mut Sampler) -> Model {
    let mut room = Room::new(s, 0.1, 0.8);
    if s.one_in(3) {
        room.boxes(s, 1, false);
    }
    let wall = 2 + s.below(4) as usize;
    lay(&mut room.parts, CEILING, [0.2, 0.8], 10.0, s);
    lay(&mut room.parts, FLOOR, [0.1, 0.9], 0.0, s);
    lay(&mut room.parts, wall, [0.05, 0.45], 0.0, s);
    if s.one_in(2) {
        lay(&mut room.parts, wall, [0.55, 0.95], 0.0, s);
    }
    for _ in 0..=s.below(2) {
        let part = s.below(u32::try_from(room.parts.len()).unwrap_or(u32::MAX)) as usize;
        twice(&mut room.parts, part);
    }
    let mut model = finish(room.parts, s);
    model.closed = true;
    model.change = written(s);
    model
}

/// A face on another one, that begins and ends about there along its first side; some reach down to the edge.
fn lay(parts: &mut Vec<Part>, on: usize, [from, to]: [f64; 2], emitted: f64, s: &mut Sampler) {
    let bottom = if s.one_in(4) { 0.0 } else { s.between(0.05, 0.4) };
    let (low, high) = ([s.between(from, from + 0.1), bottom], [s.between(to - 0.1, to), s.between(0.5, 0.95)]);
    let window = Window { low, high };
    let lying = Part::new(window.corners(&parts[on].corners), s.between(0.0, 0.8), emitted);
    parts.push(Part { lies: Some(Lies { on, at: window }), ..lying });
}

/// A face again, below the first, so that nothing of it is seen.
fn twice(parts: &mut Vec<Part>, part: usize) {
    let second = parts[part].clone();
    parts[part].lies = Some(Lies { on: parts.len(), at: Window::WHOLE });
    parts.push(second);
}

/// A rectangle cut into so many by as many.
fn cells(corners: &[DVec3], side: usize) -> Vec<Vec<DVec3>> {
    let (u, v) = ((corners[1] - corners[0]) / side as f64, (corners[3] - corners[0]) / side as f64);
    (0..side * side).map(|k| quad(corners[0] + u * (k / side) as f64 + v * (k % side) as f64, u, v)).collect()
}

/// Squares along a side of each wall: with plates more than a thousand faces.
const SQUARES: usize = 13;

/// A box of squares with plates in it, of which each is two faces back to back: even in light.
pub(in crate::scenes) fn plates(s: &mut Sampler) -> Model {
    let size = DVec3::new(s.between(1.0, 3.0), s.between(1.0, 3.0), s.between(1.0, 3.0));
    let mut parts = Vec::new();
    let add = |parts: &mut Vec<Part>, corners: Vec<DVec3>, rho: f64| parts.push(Part::new(corners, rho, furnace_emission(rho)));
    for wall in cuboid(DVec3::ZERO, size, true) {
        let rho = s.between(0.1, 0.9);
        cells(&wall, SQUARES).into_iter().for_each(|corners| add(&mut parts, corners, rho));
    }
    let first = parts.len();
    let quarter = s.below(4);
    for k in 0..=s.below(3) {
        // Each in a quarter of its own.
        let corner = DVec3::new(f64::from((quarter + k) % 2), f64::from((quarter + k) / 2 % 2), 0.5) * 0.5;
        let centre = (corner + DVec3::splat(0.25)) * size;
        let u = s.direction();
        let v = s.perpendicular(u);
        let (u, v) = (u * s.between(0.1, 0.3), v * s.between(0.1, 0.3));
        let corners = quad(centre - (u + v) * 0.5, u, v);
        let rho = [s.between(0.1, 0.9), s.between(0.1, 0.9)];
        add(&mut parts, reversed(&corners), rho[0]);
        add(&mut parts, corners, rho[1]);
    }
    let mut model = finish(parts, s);
    for part in first..first + 2 {
        let position = point_on(&model.parts[part].corners, s);
        model.probes.push(Probe { part, position });
    }
    turn(&mut model, turning(s));
    (model.exact, model.closed, model.error) = (Exact::Even(1.0), true, 1.0);
    model.degree = Some(0);
    model
}
