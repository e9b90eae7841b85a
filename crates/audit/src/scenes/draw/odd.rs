//! Scenes at the edge of a modeller's intent: objects that almost touch, cross, stand on each other, or have hardly any width.

use glam::DVec3;

use super::{CEILING, FLOOR, Room, cuboid, quad, reversed, turned_or_not};
use crate::cases::sampler::Sampler;
use crate::scenes::model::{Expected, Model, Probe};

/// A room with some oddities, in the open at times.
pub(in crate::scenes) fn odd(s: &mut Sampler) -> Model {
    let high = if s.one_in(3) { 0.99 } else { 0.8 };
    let mut room = Room::new(s, 0.05, high);
    light(&mut room, s);
    let mut probes = Vec::new();
    for _ in 0..=s.below(3) {
        probes.extend(add_oddity(&mut room, s).map(|at| Probe { part: FLOOR, position: at }));
    }
    if s.one_in(4) {
        // Not the floor, which points are on.
        let part = CEILING + s.below(5) as usize;
        room.parts.remove(part);
    }
    let size = room.size;
    let mut model = super::finish(room.parts, s);
    let inside = |p: &DVec3| p.x > 0.0 && p.y > 0.0 && p.x < size.x && p.y < size.y;
    model.probes.extend(probes.into_iter().filter(|probe| inside(&probe.position)));
    model.expected = Expected::Either;
    turned_or_not(model, s)
}

/// A lamp, or faces that glow.
fn light(room: &mut Room, s: &mut Sampler) {
    match s.below(5) {
        0 => room.parts[CEILING].emitted = vec![1.0],
        1 => room.parts.iter_mut().for_each(|part| part.emitted = vec![1.0 - part.reflectance[0]]),
        2 => {
            // Its edge touches the wall.
            let sides = [s.between(0.1, 0.4), s.between(0.1, 0.4)];
            let origin = DVec3::new(0.0, 0.3 * room.size.y, 0.9 * room.size.z);
            let emitted = room.emission(sides[0] * sides[1]);
            room.lamp(quad(origin, DVec3::Y * sides[1], DVec3::X * sides[0]), emitted);
        }
        3 => {
            let side = s.spread(-45, -2);
            let drop = room.size.z * s.between(0.05, 0.9);
            let corners = room.below_ceiling(s, [side, side], drop);
            let emitted = room.emission(side * side);
            room.lamp(corners, emitted);
        }
        _ => {
            // One that reflects, too.
            let sides = [s.between(0.1, 0.5), s.between(0.1, 0.5)];
            let corners = room.below_ceiling(s, sides, 0.2);
            let emitted = room.emission(sides[0] * sides[1]);
            room.add(reversed(&corners), 0.5, 0.0);
            room.add(corners, 0.5, emitted);
        }
    }
}

/// Adds one thing; perhaps a point of the floor that is near it.
fn add_oddity(room: &mut Room, s: &mut Sampler) -> Option<DVec3> {
    let size = room.size;
    let origin = DVec3::new(s.between(0.1, 0.6), s.between(0.1, 0.6), 0.0) * size;
    let (u, v) = (DVec3::X * s.between(0.1, 0.3), DVec3::Y * s.between(0.1, 0.3));
    let up = DVec3::Z * (s.between(0.1, 0.5) * size.z);
    let (rho, back) = (s.between(0.0, 0.9), s.between(0.0, 0.9));
    let both = |room: &mut Room, corners: Vec<DVec3>| {
        room.add(reversed(&corners), back, 0.0);
        room.add(corners, rho, 0.0);
    };
    let middle = origin + (u + v) * 0.5;
    match s.below(16) {
        0 => {
            // It hovers over the floor.
            let gap = DVec3::Z * s.spread(-45, -3);
            both(room, quad(origin + gap, v, u));
            Some(middle + u * s.between(-1.0, 1.0))
        }
        1 => {
            // It stands on the floor, seen from both sides or from one.
            let corners = quad(origin, u + v * s.between(-1.0, 1.0), up);
            if s.one_in(2) {
                both(room, corners);
            } else {
                room.add(corners, rho, 0.0);
            }
            Some(origin + v * s.between(-0.2, 0.2))
        }
        2 => {
            // It goes through the floor.
            both(room, quad(origin - up * s.between(0.1, 0.9), u + v * s.between(-1.0, 1.0), up));
            Some(origin + v * s.between(-0.2, 0.2))
        }
        3 => {
            // Two cross.
            both(room, quad(origin + up * 0.2, u, up));
            let start = origin + up * 0.2 + u * s.between(0.2, 0.8) - v * 0.5;
            both(room, quad(start, v, up * s.between(0.3, 1.0)));
            Some(middle)
        }
        4 => {
            // A lamp in a shade with cracks.
            let crack = s.spread(-30, -4);
            let (low, high) = (origin + up, origin + up + u + v + DVec3::Z * (0.2 * size.z));
            for corners in cuboid(low, high, false).into_iter().skip(1) {
                let normal = (corners[1] - corners[0]).cross(corners[2] - corners[1]);
                let by = normal / normal.length() * crack;
                room.add(corners.iter().map(|p| *p + by).collect(), rho, 0.0);
            }
            let top = cuboid(low, high, true).swap_remove(CEILING);
            let emitted = room.emission((u.length() * v.length()).max(1e-3));
            room.add(top, 0.0, emitted);
            Some(middle)
        }
        5 => {
            // A closed box with a lamp in it: nothing of that gets out.
            let (low, high) = (origin + up * 0.1, origin + up + u + v);
            for corners in cuboid(low, high, false) {
                room.add(corners, rho, 0.0);
            }
            for (index, corners) in cuboid(low, high, true).into_iter().enumerate() {
                room.add(corners, back, if index == 0 { 1.0 } else { 0.0 });
            }
            Some(middle)
        }
        6 => {
            // A needle.
            let thin = s.direction() * s.spread(-40, -8);
            let corners = vec![origin + up, origin + up + u + v, origin + up + thin];
            both(room, corners);
            None
        }
        7 => {
            // A box with a bottom that stands on the floor.
            for corners in cuboid(origin, origin + u + v + up, false) {
                room.add(corners, rho, 0.0);
            }
            Some(middle + u * s.between(-1.0, 1.0))
        }
        8 => {
            // Nearly level with the floor.
            let tilt = DVec3::Z * s.spread(-30, -4);
            both(room, quad(origin + tilt * s.between(0.0, 1.0), v, u + tilt));
            Some(middle + u * s.between(-1.0, 1.0))
        }
        9 => {
            // An L.
            let corners = [[0.0, 0.0], [1.0, 0.0], [1.0, 0.4], [0.4, 0.4], [0.4, 1.0], [0.0, 1.0]];
            both(room, corners.iter().map(|[a, b]| origin + up + u * *a + v * *b).collect());
            Some(middle)
        }
        10 => {
            // A fan of needles around a point of it.
            let (count, apex) = (4 + s.below(8), middle + up);
            let on = |k: u32| {
                let t = f64::from(k) / f64::from(count);
                origin + up + u * t
            };
            for k in 0..count {
                both(room, vec![apex, on(k), on(k + 1)]);
            }
            Some(middle)
        }
        11 => {
            // Tetrahedra anywhere.
            for _ in 0..=s.below(3) {
                let centre = DVec3::new(s.between(0.2, 0.8), s.between(0.2, 0.8), s.between(0.2, 0.8)) * size;
                let [a, b, c, d] = [0, 1, 2, 3].map(|_| centre + s.cube() * 0.15);
                let outward = (b - a).cross(c - a).dot(d - a) < 0.0;
                for corners in [[a, b, c], [a, c, d], [a, d, b], [b, d, c]] {
                    room.add(if outward { corners.to_vec() } else { reversed(&corners) }, rho, 0.0);
                }
            }
            None
        }
        12 => {
            // A box of any size.
            let side = s.spread(-45, -2);
            let low = middle + up;
            for corners in cuboid(low, low + DVec3::splat(side), false) {
                room.add(corners, rho, 0.0);
            }
            Some(middle)
        }
        13 => {
            // A wall far away, and as large as it is far.
            let far = s.spread(3, 24);
            both(room, quad(DVec3::new(-far, -far, -far), DVec3::X * (2.0 * far), DVec3::Y * (2.0 * far)));
            None
        }
        14 => {
            // A star.
            let points = 3 + s.below(6);
            let inner = s.spread(-12, 0);
            let on = |k: u32| {
                let turn = f64::from(k) * std::f64::consts::PI / f64::from(points);
                let reach = if k.is_multiple_of(2) { 0.5 } else { 0.5 * inner };
                middle + up + u * (reach * libm::cos(turn)) + v * (reach * libm::sin(turn))
            };
            both(room, (0..2 * points).map(on).collect());
            Some(middle)
        }
        _ => {
            // A stack of plates close to each other.
            let gap = DVec3::Z * s.spread(-20, -3);
            for k in 0..3 {
                both(room, quad(origin + up + gap * f64::from(k), v, u));
            }
            Some(middle)
        }
    }
}
