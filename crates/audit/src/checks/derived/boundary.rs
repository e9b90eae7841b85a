//! The boundary of an emitter as a receiver sees it, found anew, of cases that are drawn for it.

use glam::DVec3;
use radgrad_core::{Error, Polygon, Receiver};
use radgrad_scene::largest;

use crate::cases::sampler::Sampler;

/// The unit roundoff.
pub(super) const U: f64 = f64::EPSILON / 2.0;

/// Bounds are sums of some hundred rounded terms, of which a few cancel.
pub(super) const SAME: f64 = 1e-9;

/// A visible piece of an edge, or of the horizon.
pub(super) struct Piece {
    /// Its ends, and the unit normal of their plane.
    pub(super) ends: [DVec3; 2],
    pub(super) normal: DVec3,
    /// Its angle, at most pi.
    pub(super) angle: f64,
    /// The edge; none of the horizon.
    pub(super) edge: Option<Edge>,
    /// How far the ends are off that the horizon cuts, in units of roundoff of their distances.
    pub(super) moved: [f64; 2],
}

/// The edge of a piece.
pub(super) struct Edge {
    /// Its direction, and the distance of its line.
    pub(super) along: DVec3,
    pub(super) distance: f64,
    /// The relative error of its moment, in units of roundoff, where that is taken at the end that serves.
    pub(super) of_moment: f64,
}

/// An emitter from a receiver.
pub(super) struct Seen {
    /// The receiver's unit normal and the emitter's.
    pub(super) n1: DVec3,
    pub(super) n2: DVec3,
    pub(super) height: f64,
    pub(super) vertices: Vec<DVec3>,
    pub(super) pieces: Vec<Piece>,
    /// The power of two that lengths are multiplied by.
    pub(super) power: f64,
}

impl Seen {
    /// `None` where decisions are not clear, or where an edge passes nearer than the derivations in double precision go.
    pub(super) fn new(receiver: &Receiver, polygon: &Polygon) -> Option<Self> {
        let farthest = polygon.vertices().iter().map(|v| (*v - receiver.position()).abs().max_element()).fold(0.0, largest);
        let power = libm::exp2(-libm::log2(farthest).floor());
        let (n1, n2) = (receiver.direction().normalize(), polygon.normal());
        let vertices: Vec<DVec3> = polygon.vertices().iter().map(|v| (*v - receiver.position()) * power).collect();
        let heights: Vec<f64> = vertices.iter().map(|r| n1.dot(*r)).collect();
        let height = -n2.dot(vertices[0]);
        if height < 1e-6 || heights.iter().any(|height| height.abs() < 1e-6) || heights.iter().all(|height| *height < 0.0) {
            return None;
        }
        let (mut pieces, mut crossings) = (Vec::new(), [Vec::new(), Vec::new()]);
        for (i, &a) in vertices.iter().enumerate() {
            let j = (i + 1) % vertices.len();
            let (b, e) = (vertices[j], vertices[j] - a);
            let (above, stays) = (heights[i] > 0.0, heights[j] > 0.0);
            if !above && !stays {
                continue;
            }
            let moment = a.cross(e).length();
            let at = if 4.0 * moment >= a.length() * e.length() || a.length() <= b.length() { a } else { b };
            let ratio = at.length() * e.length() / moment;
            if ratio >= 7.99 || (ratio - 4.0).abs() < 1e-9 {
                return None;
            }
            let (mut ends, mut moved) = ([a, b], [0.0; 2]);
            if above != stays {
                let share = heights[i] / (heights[i] - heights[j]);
                let (kept, part) = if above { (a, share) } else { (b, 1.0 - share) };
                let crossing = a + e * share;
                let which = usize::from(above);
                ends[which] = crossing;
                moved = [(kept.length() + 6.0 * part * e.length()) / crossing.length() + 1.0; 2];
                crossings[1 - which].push((crossing, moved[0]));
            }
            let normal = a.cross(e) / moment;
            let angle = libm::atan2(ends[0].cross(ends[1]).length(), ends[0].dot(ends[1]));
            let (along, distance) = (e.normalize(), moment / e.length());
            let edge = Edge { along, distance, of_moment: 3.5 * ratio + 1.0 };
            pieces.push(Piece { ends, normal, angle, edge: Some(edge), moved });
        }
        match crossings.each_ref().map(Vec::as_slice) {
            [[], []] => {}
            [[(exit, of_exit)], [(entry, of_entry)]] => {
                let angle = libm::atan2(-n1.dot(exit.cross(*entry)), exit.dot(*entry)).abs();
                let moved = [*of_exit, *of_entry];
                pieces.push(Piece { ends: [*exit, *entry], normal: -n1, angle, edge: None, moved });
            }
            _ => return None,
        }
        Some(Self { n1, n2, height, vertices, pieces, power })
    }

    pub(super) fn is_cut(&self) -> bool {
        self.pieces.iter().any(|piece| piece.edge.is_none())
    }

    /// The irradiance vector of a unit emission over pi.
    pub(super) fn phi(&self) -> DVec3 {
        self.pieces.iter().map(|piece| piece.normal * (-0.5 * piece.angle)).sum()
    }

    /// How many sums over arcs round: a polygon of up to four edges that is cut counts all of them.
    pub(super) fn additions(&self) -> f64 {
        let count = self.vertices.len();
        (if self.is_cut() && count <= 4 { count } else { self.pieces.len() - 1 }) as f64
    }
}

/// Whether an arc is up to a quarter turn.
pub(super) fn is_narrow(ends: &[DVec3; 2]) -> bool {
    ends[0].dot(ends[1]) >= 0.0
}

/// A convex polygon of few bits in the plane z = 0 that faces down, and a receiver below it.
pub(super) fn drawn(s: &mut Sampler, most: u32) -> Result<(Polygon, Receiver), Error> {
    let few = |x: f64| (1024.0 * x).round() / 1024.0;
    let count = 3 + s.below(most - 2);
    let size = [1.0, 1.0, 0.25, 1024.0][s.below(4) as usize];
    let first = s.between(0.0, 1.0);
    let corner = |k: u32| {
        let turn = std::f64::consts::TAU * (first - (f64::from(k) + s.between(-0.2, 0.2)) / f64::from(count));
        DVec3::new(few(libm::cos(turn)), few(libm::sin(turn)), 0.0) * size
    };
    let vertices = (0..count).map(corner).collect();
    let depth = [0.15, 0.5, 1.0, 1.8][s.below(4) as usize];
    let place = s.cube() * DVec3::new(0.8, 0.8, 0.1) - DVec3::Z * depth;
    let lean = if s.one_in(2) { 0.1 } else { 1.5 };
    let receiver = Receiver::new(place.map(few) * size, DVec3::Z + s.cube() * lean, [1.0, 0.5, 0.3][s.below(3) as usize])?;
    Ok((Polygon::new(vertices)?, receiver))
}

/// The finding about stated bounds that are not those derived.
pub(super) fn apart(what: &str, same: f64, stated: [f64; 2], derived: [f64; 2]) -> Option<String> {
    let is_same = |(stated, derived): (f64, f64)| (stated / derived - 1.0).abs() <= same;
    let is_off = !stated.into_iter().zip(derived).all(is_same);
    is_off.then(|| format!("{what}: the bounds {stated:?} are not {derived:?}"))
}

/// A case: how many bounds were compared, and the findings.
pub(super) type Told = Result<(usize, Vec<String>), Error>;
