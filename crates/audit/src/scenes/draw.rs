//! Scenes of every family, drawn from random numbers by ring operations, division and square root only: the same bits everywhere.

use glam::DVec3;
use radgrad_oracle::scene::known::{FacingRectangles, furnace_emission};
use radgrad_scene::Quantity;
use radgrad_solver::Marking;

use super::model::{Change, Exact, Expected, Grid, Model, Part, Probe, Ways};
use crate::cases::sampler::{Sampler, power_of_two};

pub(super) mod exact;
pub(super) mod odd;
pub(super) mod world;

/// Points asked at.
const PROBES: usize = 3;

/// Relative errors that the solver is asked for.
const ERRORS: [f64; 3] = [0.05, 0.005, 0.0005];

/// One that the first round reaches.
const ROUGH: f64 = 0.5;

/// Corners of a parallelogram, seen counter-clockwise from the side of `u x v`.
pub(crate) fn quad(origin: DVec3, u: DVec3, v: DVec3) -> Vec<DVec3> {
    vec![origin, origin + u, origin + u + v, origin + v]
}

fn reversed(corners: &[DVec3]) -> Vec<DVec3> {
    corners.iter().rev().copied().collect()
}

/// The faces of a box, seen from inside or from outside: below, above, then y = low, high, x = low, high.
pub(crate) fn cuboid(low: DVec3, high: DVec3, inside: bool) -> Vec<Vec<DVec3>> {
    let corner = |i: usize| {
        let pick = |bit: usize, l: f64, h: f64| if i >> bit & 1 == 1 { h } else { l };
        DVec3::new(pick(0, low.x, high.x), pick(1, low.y, high.y), pick(2, low.z, high.z))
    };
    let quads = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]];
    let turned = |quad: [usize; 4]| if inside { quad.map(corner).to_vec() } else { reversed(&quad.map(corner)) };
    quads.into_iter().map(turned).collect()
}

const FLOOR: usize = 0;
const CEILING: usize = 1;

/// A room that is being furnished; z is up and its floor at 0.
struct Room {
    size: DVec3,
    parts: Vec<Part>,
}

impl Room {
    fn new(s: &mut Sampler, low: f64, high: f64) -> Self {
        let size = DVec3::new(s.between(1.0, 3.0), s.between(1.0, 3.0), s.between(0.8, 2.0));
        let walls = cuboid(DVec3::ZERO, size, true);
        let parts = walls.into_iter().map(|corners| Part::new(corners, s.between(low, high), 0.0)).collect();
        Self { size, parts }
    }

    fn add(&mut self, corners: Vec<DVec3>, reflectance: f64, emitted: f64) {
        self.parts.push(Part::new(corners, reflectance, emitted));
    }

    /// A plate: a lamp below and a dark back above.
    fn lamp(&mut self, corners: Vec<DVec3>, emitted: f64) {
        self.add(reversed(&corners), 0.0, 0.0);
        self.add(corners, 0.0, emitted);
    }

    /// A rectangle under the ceiling that faces down, of the given sides.
    fn below_ceiling(&self, s: &mut Sampler, sides: [f64; 2], drop: f64) -> Vec<DVec3> {
        let [x, y] = [s.between(0.02, 0.98 - sides[0] / self.size.x), s.between(0.02, 0.98 - sides[1] / self.size.y)];
        let origin = DVec3::new(x * self.size.x, y * self.size.y, self.size.z - drop);
        quad(origin, DVec3::Y * sides[1], DVec3::X * sides[0])
    }

    /// Emission with which a lamp of this area lights the room to about 1.
    fn emission(&self, area: f64) -> f64 {
        let DVec3 { x, y, z } = self.size;
        2.0 * (x * y + y * z + z * x) / area
    }

    /// Boxes that hang or stand in different quarters of the room, below 0.6 of its height.
    fn boxes(&mut self, s: &mut Sampler, count: u32, standing: bool) {
        let first = s.below(4);
        for k in 0..count {
            let quarter = (first + k) % 4;
            let corner = DVec3::new(f64::from(quarter % 2), f64::from(quarter / 2), 0.0) * self.size * 0.5;
            let from = DVec3::new(s.between(0.05, 0.2), s.between(0.05, 0.2), s.between(0.02, 0.2)) * self.size;
            let to = DVec3::new(s.between(0.25, 0.45), s.between(0.25, 0.45), s.between(0.3, 0.6)) * self.size;
            let mut low = corner + from;
            if standing {
                low.z = 0.0;
            }
            let faces = cuboid(low, corner + to, false);
            for corners in faces.into_iter().skip(usize::from(standing)) {
                let reflectance = s.between(0.1, 0.8);
                self.add(corners, reflectance, 0.0);
            }
        }
    }

    /// The wall at x = 0 replaced by four pieces around an opening `[low, high]` of y and z.
    fn open_wall(&mut self, low: [f64; 2], high: [f64; 2]) {
        let wall = self.parts.remove(4);
        let DVec3 { y, z, .. } = self.size;
        let piece =
            |y0: f64, z0: f64, y1: f64, z1: f64| quad(DVec3::new(0.0, y0, z0), DVec3::Y * (y1 - y0), DVec3::Z * (z1 - z0));
        let pieces = [
            piece(0.0, 0.0, y, low[1]),
            piece(0.0, high[1], y, z),
            piece(0.0, low[1], low[0], high[1]),
            piece(high[0], low[1], y, high[1]),
        ];
        // `origin + u + v` of neighbours may differ by a rounding. Solver and oracle get the same corners, so that they are asked
        // for the same scene.
        for corners in pieces {
            self.add(corners, wall.reflectance[0], 0.0);
        }
    }

    /// The scene, turned at random in half the cases, with points on faces that reflect.
    fn finish(self, s: &mut Sampler) -> Model {
        turned_or_not(finish(self.parts, s), s)
    }
}

/// A scene of these faces, with random points.
fn finish(parts: Vec<Part>, s: &mut Sampler) -> Model {
    let mut model = Model {
        parts,
        probes: Vec::new(),
        exact: Exact::Nothing,
        expected: Expected::Answer,
        closed: false,
        change: Change::None,
        error: ERRORS[s.below(3) as usize],
        degree: None,
        ways: Ways::default(),
    };
    for _ in 0..PROBES {
        add_probe(&mut model, s);
    }
    model
}

/// Ways to ask for a scene: half of the scenes are asked for in the usual ones.
pub(super) fn ways(model: &mut Model, s: &mut Sampler) {
    if s.one_in(2) {
        return;
    }
    match s.below(5) {
        2 => model.ways.marking = Marking::Gradient,
        4 => model.ways.for_points = true,
        _ => (),
    }
    if model.degree.is_none() && s.one_in(2) {
        model.degree = Some(s.below(4) as usize);
    }
}

/// The area of a triangle or of a parallelogram, times two or not.
fn area(part: &Part) -> f64 {
    let [a, b, c] = [part.corners[0], part.corners[1], part.corners[2]];
    (b - a).cross(c - a).length()
}

/// A random point of a face that reflects, drawn by area.
fn add_probe(model: &mut Model, s: &mut Sampler) {
    let area = |part: &Part| if part.reflectance.iter().any(|rho| *rho > 0.0) { area(part) } else { 0.0 };
    let mut place = s.uniform() * model.parts.iter().map(area).sum::<f64>();
    let mut part = 0;
    for (index, of) in model.parts.iter().enumerate() {
        let area = area(of);
        if area > 0.0 {
            part = index;
            place -= area;
            if place < 0.0 {
                break;
            }
        }
    }
    let probe = point_on(&model.parts[part].corners, s);
    model.probes.push(Probe { part, position: probe });
}

/// A random point of a triangle or of a convex quadrilateral.
fn point_on(corners: &[DVec3], s: &mut Sampler) -> DVec3 {
    // Two in three away from edges: the nearer a corner, the rougher the truth.
    let margin = if s.one_in(3) { 0.01 } else { 0.15 };
    let [u, v] = [s.between(margin, 1.0 - margin), s.between(margin, 1.0 - margin)];
    if corners.len() == 4 {
        let (a, b) = (corners[0] + (corners[1] - corners[0]) * u, corners[3] + (corners[2] - corners[3]) * u);
        return a + (b - a) * v;
    }
    let (u, v) = if u + v > 1.0 { (1.0 - u, 1.0 - v) } else { (u, v) };
    corners[0] + (corners[1] - corners[0]) * u + (corners[2] - corners[0]) * v
}

/// Turned about the origin in half the cases.
fn turned_or_not(mut model: Model, s: &mut Sampler) -> Model {
    if !s.one_in(2) {
        turn(&mut model, turning(s));
    }
    model
}

/// Where the axes go in a turn at random.
fn turning(s: &mut Sampler) -> [DVec3; 3] {
    let x = s.direction();
    let y = s.perpendicular(x);
    [x, y, x.cross(y)]
}

fn turn(model: &mut Model, [x, y, z]: [DVec3; 3]) {
    let turned = |p: DVec3| x * p.x + y * p.y + z * p.z;
    let corners = model.parts.iter_mut().flat_map(|part| &mut part.corners);
    let positions = model.probes.iter_mut().map(|probe| &mut probe.position);
    corners.chain(positions).for_each(|p| *p = turned(*p));
}

pub(super) fn clutter(s: &mut Sampler) -> Model {
    let model = upright_clutter(s);
    turned_or_not(model, s)
}

fn upright_clutter(s: &mut Sampler) -> Model {
    let mut room = Room::new(s, 0.1, 0.8);
    let (count, standing) = (1 + s.below(3), s.one_in(3));
    room.boxes(s, count, standing);
    for _ in 0..=s.below(2) {
        let sides = [s.between(0.1, 0.5), s.between(0.1, 0.5)];
        let drop = s.between(0.02, 0.2);
        let corners = room.below_ceiling(s, sides, drop);
        let emitted = room.emission(sides[0] * sides[1]);
        // Two lamps at one height might lie in each other.
        if room.parts.iter().all(|part| part.emitted[0] == 0.0) {
            room.lamp(corners, emitted);
        }
    }
    let mut model = finish(room.parts, s);
    model.closed = !standing;
    if s.one_in(3) {
        model.colour(s);
    }
    model
}

pub(super) fn furnace(s: &mut Sampler) -> Model {
    let mut room = Room::new(s, 0.05, 0.95);
    let count = s.below(4);
    room.boxes(s, count, false);
    for part in &mut room.parts {
        part.emitted = part.reflectance.iter().map(|rho| furnace_emission(*rho)).collect();
    }
    let mut model = room.finish(s);
    model.exact = Exact::Even(1.0);
    model.closed = true;
    model
}

pub(super) fn facing(s: &mut Sampler) -> Model {
    let mut rectangle = || {
        let low = [s.between(-0.5, 0.5), s.between(-0.5, 0.5)];
        let high = [low[0] + s.between(0.5, 1.5), low[1] + s.between(0.5, 1.5)];
        [low, high]
    };
    let [[a, b], [c, d]] = [rectangle(), rectangle()];
    let rectangles = FacingRectangles {
        low: [a, c],
        high: [b, d],
        gap: s.between(0.5, 1.5),
        reflectance: [s.between(0.1, 0.9), s.between(0.1, 0.9)],
        emitted: [if s.one_in(2) { 0.0 } else { s.between(0.1, 2.0) }, s.between(0.1, 2.0)],
    };
    let mut model = between_rectangles(rectangles, s);
    // Of constants on few elements errors are large, so that an estimate that is too small shows.
    model.degree = Some(if s.one_in(2) { 0 } else { s.below(4) as usize });
    if model.degree == Some(0) {
        model.error = ROUGH;
    }
    model
}

/// Two rectangles that face each other, with random points.
fn between_rectangles(rectangles: FacingRectangles, s: &mut Sampler) -> Model {
    let corners = |which: usize, z: f64| {
        let ([a, b], [c, d]) = (rectangles.low[which], rectangles.high[which]);
        [[a, b, z], [c, b, z], [c, d, z], [a, d, z]].map(DVec3::from).to_vec()
    };
    let faces = [corners(0, 0.0), reversed(&corners(1, rectangles.gap))];
    let part = |(which, corners)| Part::new(corners, rectangles.reflectance[which], rectangles.emitted[which]);
    let mut model = finish(faces.into_iter().enumerate().map(part).collect(), s);
    model.exact = Exact::Facing(rectangles);
    model
}

/// A lamp in a shade of four walls, open below: its sides, the height of its rim and its depth.
fn shaded(room: &mut Room, s: &mut Sampler) -> (DVec3, f64) {
    let side = s.spread(-6, -1);
    let rim = (side * s.spread(-2, 4)).min(0.5 * room.size.z);
    let depth = (side * s.between(0.3, 1.5)).min(0.3 * room.size.z);
    let x = s.between(0.02, 0.98 - side / room.size.x) * room.size.x;
    let y = s.between(0.02, 0.98 - side / room.size.y) * room.size.y;
    let (low, high) = (DVec3::new(x, y, rim), DVec3::new(x + side, y + side, rim + depth));
    let emitted = room.emission(side * side);
    let reflectance = if s.one_in(2) { 0.0 } else { 0.5 };
    let outside = cuboid(low, high, false);
    // Above, and the four sides; the lamp is the inside of the top.
    for corners in outside.into_iter().skip(1) {
        room.add(corners, reflectance, 0.0);
    }
    let top = cuboid(low, high, true).swap_remove(CEILING);
    room.add(top, 0.0, emitted);
    (DVec3::new(0.5 * (low.x + high.x), 0.5 * (low.y + high.y), 0.0), side)
}

pub(super) fn downlight(s: &mut Sampler) -> Model {
    let model = upright_downlight(s);
    turned_or_not(model, s)
}

fn upright_downlight(s: &mut Sampler) -> Model {
    let mut room = Room::new(s, 0.3, 0.8);
    let (below, side) = shaded(&mut room, s);
    let mut model = finish(room.parts, s);
    // One point where the light falls.
    let aside = DVec3::new(s.between(-1.0, 1.0), s.between(-1.0, 1.0), 0.0) * (0.5 * side);
    model.probes.push(Probe { part: FLOOR, position: below + aside });
    model
}

/// A lamp outside, a little larger than the opening and nearer than that is wide, so that many walks find the way in.
fn behind(room: &mut Room, s: &mut Sampler, low: [f64; 2], high: [f64; 2]) {
    let width = (high[0] - low[0]).min(high[1] - low[1]);
    let away = width * s.between(0.2, 1.0);
    let [grow_y, grow_z] = [s.between(0.0, 0.5) * width, s.between(0.0, 0.5) * width];
    let origin = DVec3::new(-away, low[0] - grow_y, low[1] - grow_z);
    let (u, v) = (DVec3::Y * (high[0] - low[0] + 2.0 * grow_y), DVec3::Z * (high[1] - low[1] + 2.0 * grow_z));
    let emitted = room.emission((high[0] - low[0]) * (high[1] - low[1]));
    room.add(quad(origin, u, v), 0.0, emitted);
}

pub(super) fn slit(s: &mut Sampler) -> Model {
    let mut room = Room::new(s, 0.3, 0.8);
    let [width, length] = [s.spread(-7, -3), s.between(0.2, 0.6)];
    let [y, z] = [s.between(0.1, 0.9 - width), s.between(0.1, 0.9 - length)];
    let (wide, tall) = (room.size.y, room.size.z);
    let (low, high) = ([y * wide, z * tall], [(y + width) * wide, (z + length) * tall]);
    room.open_wall(low, high);
    behind(&mut room, s, low, high);
    room.finish(s)
}

pub(super) fn pinhole(s: &mut Sampler) -> Model {
    let mut room = Room::new(s, 0.3, 0.8);
    let side = 0.8 * s.spread(-6, -2);
    let low = [s.between(0.1, 0.6) * room.size.y, s.between(0.1, 0.6) * room.size.z];
    let high = [low[0] + side, low[1] + side];
    room.open_wall(low, high);
    behind(&mut room, s, low, high);
    room.finish(s)
}

pub(super) fn grating(s: &mut Sampler) -> Model {
    let mut room = Room::new(s, 0.2, 0.8);
    let count = 3 + s.below(6);
    let (height, part) = (s.between(0.3, 0.6) * room.size.z, s.between(0.3, 0.8));
    let pitch = 0.9 * room.size.x / f64::from(count);
    let upright = s.one_in(2);
    for k in 0..count {
        let origin = DVec3::new(0.05 * room.size.x + pitch * f64::from(k), 0.05 * room.size.y, height);
        let along = DVec3::Y * (0.9 * room.size.y);
        let across = if upright { DVec3::Z * (0.3 * part * room.size.z) } else { DVec3::X * (part * pitch) };
        let corners = quad(origin, across, along);
        let reflectance = s.between(0.0, 0.6);
        room.add(reversed(&corners), reflectance, 0.0);
        room.add(corners, reflectance, 0.0);
    }
    let sides = [s.between(0.05, 0.4), s.between(0.05, 0.4)];
    let corners = room.below_ceiling(s, sides, 0.05);
    let emitted = room.emission(sides[0] * sides[1]);
    room.lamp(corners, emitted);
    let mut model = room.finish(s);
    model.closed = true;
    model
}

pub(super) fn touching(s: &mut Sampler) -> Model {
    let mut room = Room::new(s, 0.2, 0.8);
    let (gap, side) = (s.spread(-14, -3), s.spread(-9, -2));
    let [u, v] = [s.between(0.02, 0.6), s.between(0.02, 0.6)];
    let emitted = room.emission(side * side);
    let (corners, part, near) = if s.one_in(2) {
        let origin = DVec3::new(u * room.size.x, v * room.size.y, gap);
        (quad(origin, DVec3::Y * side, DVec3::X * side), FLOOR, DVec3::new(origin.x, origin.y, 0.0))
    } else {
        let origin = DVec3::new(gap, u * room.size.y, v * room.size.z);
        (quad(origin, DVec3::Z * side, DVec3::Y * side), 4, DVec3::new(0.0, origin.y, origin.z))
    };
    room.lamp(corners, emitted);
    let mut model = finish(room.parts, s);
    // One point near the lamp's edge.
    let aside = side * s.between(-0.1, 0.05);
    let position = near - if part == FLOOR { DVec3::X } else { DVec3::Y } * aside;
    model.probes.push(Probe { part, position });
    model.closed = true;
    turned_or_not(model, s)
}

pub(super) fn bright(s: &mut Sampler) -> Model {
    let mut room = Room::new(s, 0.9, 0.99);
    let count = s.below(2);
    room.boxes(s, count, false);
    let sides = [s.between(0.1, 0.5), s.between(0.1, 0.5)];
    let corners = room.below_ceiling(s, sides, 0.1);
    let emitted = 0.1 * room.emission(sides[0] * sides[1]);
    room.lamp(corners, emitted);
    let mut model = room.finish(s);
    model.closed = true;
    model
}

pub(super) fn many_lamps(s: &mut Sampler) -> Model {
    let mut room = Room::new(s, 0.1, 0.7);
    let count = 4 + s.below(7);
    let side = 0.5 * room.size.x.min(room.size.y) / f64::from(count);
    for k in 0..count {
        // Each at a height and in a strip of its own.
        let y = s.between(0.05, 0.9) * (room.size.y - side);
        let x = (f64::from(k) + 0.25) / f64::from(count) * room.size.x;
        let origin = DVec3::new(x, y, room.size.z * s.between(0.8, 0.98));
        let emitted = room.emission(side * side) * s.spread(-20, 0);
        room.lamp(quad(origin, DVec3::Y * side, DVec3::X * side), emitted);
    }
    room.boxes(s, 1, false);
    let mut model = room.finish(s);
    model.closed = true;
    model
}

pub(super) fn textured(s: &mut Sampler) -> Model {
    let mut room = Room::new(s, 0.2, 0.8);
    room.boxes(s, 1, false);
    let sides = [s.between(0.1, 0.5), s.between(0.1, 0.5)];
    let corners = room.below_ceiling(s, sides, 0.1);
    let emitted = room.emission(sides[0] * sides[1]);
    room.lamp(corners, emitted);
    let mut grid = |quantity| {
        let size = [1 + s.below(4) as usize, 2 + s.below(3) as usize];
        Grid { size, texels: (0..size[0] * size[1]).map(|_| s.uniform()).collect(), quantity }
    };
    room.parts[FLOOR].grids.push(grid(Quantity::Reflectance));
    let glows = grid(Quantity::Radiance);
    if s.one_in(3) {
        room.parts[5].emitted = vec![1.0];
        room.parts[5].grids.push(glows);
    }
    room.finish(s)
}

pub(super) fn t_junctions(s: &mut Sampler) -> Model {
    let mut room = Room::new(s, 0.1, 0.8);
    let sides = [s.between(0.1, 0.5), s.between(0.1, 0.5)];
    let corners = room.below_ceiling(s, sides, 0.1);
    let emitted = room.emission(sides[0] * sides[1]);
    let walls: Vec<Part> = room.parts.drain(..).collect();
    for wall in walls {
        let [a, b, c, d] = [0, 1, 2, 3].map(|i| wall.corners[i]);
        if s.one_in(2) {
            room.parts.push(wall);
            continue;
        }
        // Triangles from a to points of the two sides that do not meet it, some close to each other.
        let first = s.between(0.1, 0.9);
        let second = (first + s.spread(-16, -3)).min(0.999);
        let third = s.between(0.1, 0.9);
        let on = |from: DVec3, to: DVec3, t: f64| from + (to - from) * t;
        let rim = [b, on(b, c, first), on(b, c, second), c, on(c, d, third), d];
        for pair in rim.windows(2) {
            room.add(vec![a, pair[0], pair[1]], wall.reflectance[0], 0.0);
        }
    }
    room.lamp(corners, emitted);
    room.finish(s)
}

pub(super) fn open(s: &mut Sampler) -> Model {
    let mut parts = Vec::new();
    let count = 3 + s.below(6);
    let first = s.below(8);
    for k in 0..count {
        // Each in a cell of its own of a grid of eight.
        let cell = (first + k) % 8;
        let centre = DVec3::new(f64::from(cell % 2), f64::from(cell / 2 % 2), f64::from(cell / 4)) * 2.0 - DVec3::ONE;
        let u = s.direction();
        let v = s.perpendicular(u);
        let (u, v) = (u * s.between(0.3, 0.6), v * s.between(0.3, 0.6));
        let corners =
            if s.one_in(2) { quad(centre - (u + v) * 0.5, u, v) } else { vec![centre - u, centre + u - v * 0.5, centre + v] };
        let emitted = if k == 0 || s.one_in(3) { s.between(0.5, 5.0) } else { 0.0 };
        let reflectance = s.between(0.1, 0.9);
        parts.push(Part::new(corners, reflectance, emitted));
    }
    finish(parts, s)
}

pub(super) fn overlap(s: &mut Sampler) -> Model {
    let mut room = Room::new(s, 0.1, 0.8);
    let sides = [s.between(0.1, 0.5), s.between(0.1, 0.5)];
    let corners = room.below_ceiling(s, sides, 0.1);
    let emitted = room.emission(sides[0] * sides[1]);
    room.lamp(corners, emitted);
    let [u, v] = [s.between(0.1, 0.4), s.between(0.1, 0.4)];
    let rug = quad(DVec3::new(u, v, 0.0) * room.size, DVec3::X * (0.5 * room.size.x), DVec3::Y * (0.5 * room.size.y));
    let reflectance = s.between(0.1, 0.8);
    match s.below(3) {
        0 => room.add(rug, reflectance, 0.0),
        1 => {
            let ceiling = room.parts[CEILING].corners.clone();
            room.add(ceiling, reflectance, 0.0);
        }
        _ => {
            // Two that cover a part of each other, above the floor.
            let up = DVec3::Z * (0.1 * room.size.z);
            let shift = DVec3::new(0.1, 0.05, 0.0) * room.size;
            room.add(rug.iter().map(|p| *p + up).collect(), reflectance, 0.0);
            room.add(rug.iter().map(|p| *p + up + shift).collect(), reflectance, 0.0);
        }
    }
    let mut model = finish(room.parts, s);
    model.expected = Expected::Refusal;
    model
}

/// A scene along the axes.
fn ordinary(s: &mut Sampler) -> Model {
    if s.one_in(2) { upright_clutter(s) } else { upright_downlight(s) }
}

pub(super) fn scaled(s: &mut Sampler) -> Model {
    let mut model = ordinary(s);
    let exponent = [s.integer(-20, 20), s.integer(-300, 300), s.integer(-700, 700)][s.below(3) as usize];
    model.change = Change::Scale(power_of_two(exponent));
    model.expected = Expected::Either;
    model
}

pub(super) fn shifted(s: &mut Sampler) -> Model {
    let mut model = ordinary(s);
    model.closed = false;
    // Coordinates to 2^-12, so that shifts by integers below 2^40 are exact.
    let coarse = |x: f64| {
        let scaled = x * 4096.0;
        (scaled - scaled % 1.0) / 4096.0
    };
    let whole = |s: &mut Sampler, size: f64| {
        let x = s.between(-size, size);
        x - x % 1.0
    };
    let size = power_of_two(s.integer(2, 40));
    model.change = Change::Shift(DVec3::new(whole(s, size), whole(s, size), whole(s, size)));
    let corners = model.parts.iter_mut().flat_map(|part| &mut part.corners);
    let positions = model.probes.iter_mut().map(|probe| &mut probe.position);
    corners.chain(positions).for_each(|p| *p = DVec3::new(coarse(p.x), coarse(p.y), coarse(p.z)));
    model.expected = Expected::Either;
    model
}
