//! Shadow lines: where the planes through edges of lamps and of occluders meet a receiver.
//!
//! Seen from a point x of a receiver the outline of an occluder passes a corner of a lamp, or a corner of the occluder passes the
//! outline of the lamp. There the radiosity or one of its derivatives jumps (P. S. Heckbert 1992; D. Lischinski, F. Tampieri and
//! D. P. Greenberg 1992). Such points are in the plane through a vertex `v` of the lamp and an edge `ab` of the occluder, or
//! through an edge `pq` of the lamp and a vertex `o` of the occluder. With the height `h` over the receiver the plane meets it in
//! the segment between the projections of `a` and `b` from `v`, or of `p` and `q` through `o`:
//!
//! ```text
//! v + (a - v) h(v) / (h(v) - h(a)),      p + (o - p) h(p) / (h(p) - h(o))
//! ```
//!
//! The plane of a lamp meets the receiver in a third kind of line: beyond it the lamp is seen from behind. The quadrics where an
//! edge of the lamp meets two edges of occluders at a time are left out. Lines in contact, where a face stands on the receiver,
//! are those of [`crate::mesh::contact`].
//!
//! An edge that several faces share makes one line, and a vertex inside a straight edge makes none. A line counts where rays from x that pass
//! around the point of the lamp are in part blocked and in part free: there the feature is an outline, and nothing else hides the lamp.
//! Rays from a few places along the line decide, without proof: a line too many or too few changes the elements, but no bound.

use std::collections::BTreeSet;

use radgrad_core::{DVec3, Polygon};
use radgrad_scene::{Occluders, largest, smallest};

use crate::mesh::contact::inside;

/// Features nearer to the level of a lamp's point than this fraction of its height throw their shadows out of every receiver.
const BELOW: f64 = 1e-3;

/// Places along a line where it is looked at.
const PLACES: usize = 12;

/// Directions around a feature: no two of them along one line, and none along an edge of a scene that has its edges along the axes.
const AROUND: [[f64; 2]; 8] =
    [[0.9, 0.3], [0.4, 0.8], [-0.3, 0.9], [-0.8, 0.4], [-0.9, -0.4], [-0.4, -0.9], [0.3, -0.8], [0.8, -0.3]];

/// Distance around a feature, and before the end of a ray, as fractions of the length of the ray.
const ASIDE: f64 = 1e-4;
const BEFORE: f64 = 1e-3;

/// Fraction of the face's size within which two lines are one.
const SAME: f64 = 1e-6;

/// The polygons of a scene, and which of them are lamps.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Scenery<'a> {
    pub(crate) polygons: &'a [Polygon],
    pub(crate) index: &'a Occluders,
    /// Faces.
    pub(crate) lamps: &'a [usize],
}

/// The edges and the vertices of some faces, each once.
#[derive(Debug, Default)]
struct Features {
    edges: Vec<[DVec3; 2]>,
    vertices: Vec<DVec3>,
}

impl Features {
    fn collect<'a>(polygons: impl Iterator<Item = &'a Polygon>) -> Self {
        // Adding 0 makes -0 of the same bits.
        let bits = |p: DVec3| (p + 0.0).to_array().map(f64::to_bits);
        let (mut edges, mut vertices, mut features) = (BTreeSet::new(), BTreeSet::new(), Self::default());
        for polygon in polygons {
            let v = polygon.vertices();
            for (i, &a) in v.iter().enumerate() {
                let b = v[(i + 1) % v.len()];
                if vertices.insert(bits(a)) {
                    features.vertices.push(a);
                }
                let (from, to) = (bits(a), bits(b));
                if edges.insert(if from < to { [from, to] } else { [to, from] }) {
                    features.edges.push([a, b]);
                }
            }
        }
        features.vertices.retain(|o| !is_straight(*o, &features.edges));
        features
    }
}

/// Whether an edge goes on straight through a vertex, as where one face's side is that of two others: it is no corner of an outline.
fn is_straight(o: DVec3, edges: &[[DVec3; 2]]) -> bool {
    let away = edges.iter().filter_map(|&[a, b]| match (a == o, b == o) {
        (true, false) => Some((b - o).normalize_or_zero()),
        (false, true) => Some((a - o).normalize_or_zero()),
        _ => None,
    });
    let away: Vec<DVec3> = away.collect();
    away.iter().any(|a| away.iter().any(|b| (*a + *b).length() <= SAME))
}

/// The segments of a face's plane, within it, where light of lamps changes suddenly.
///
/// `convex` are the convex parts of the face.
pub(crate) fn lines(scenery: &Scenery<'_>, face: usize, convex: &[Vec<DVec3>], between: &[Vec<usize>]) -> Vec<[DVec3; 2]> {
    let receiver = Receiver { scenery, face, convex, polygon: &scenery.polygons[face] };
    let mut lines = Vec::new();
    for (&lamp, between) in scenery.lamps.iter().zip(between).filter(|(lamp, _)| **lamp != face) {
        let of_lamp = &scenery.polygons[lamp];
        let v = of_lamp.vertices();
        lines.extend(receiver.horizon(of_lamp));
        let hiding = Features::collect(between.iter().map(|&other| &scenery.polygons[other]));
        let corners = v.iter().flat_map(|&v| hiding.edges.iter().map(move |&edge| (v, edge)));
        lines.extend(corners.filter_map(|(v, edge)| receiver.corner(lamp, v, edge)));
        let sides = (0..v.len()).map(|i| [v[i], v[(i + 1) % v.len()]]);
        let sides = sides.flat_map(|side| hiding.vertices.iter().map(move |&o| (side, o)));
        lines.extend(sides.filter_map(|(side, o)| receiver.side(lamp, side, o)));
    }
    joined(lines, SAME * receiver.polygon.size())
}

/// A face that receives.
struct Receiver<'a> {
    scenery: &'a Scenery<'a>,
    face: usize,
    convex: &'a [Vec<DVec3>],
    polygon: &'a Polygon,
}

impl Receiver<'_> {
    fn height(&self, p: DVec3) -> f64 {
        self.polygon.normal().dot(p - self.polygon.vertices()[0])
    }

    /// Where the plane of a lamp meets the face.
    fn horizon(&self, lamp: &Polygon) -> Option<[DVec3; 2]> {
        let (normal, across) = (self.polygon.normal(), lamp.normal().reject_from(self.polygon.normal()));
        let level = lamp.normal().dot(lamp.vertices()[0] - self.polygon.vertices()[0]);
        if across.length() <= SAME || lamp.vertices().iter().all(|&v| self.height(v) <= SAME * self.polygon.size()) {
            return None;
        }
        let foot = self.polygon.vertices()[0] + across * (level / across.length_squared());
        let reach =
            normal.cross(across).normalize_or_zero() * (self.polygon.size() + (foot - self.polygon.vertices()[0]).length());
        let segment = self.within([foot - 2.0 * reach, foot + 2.0 * reach])?;
        self.is_inside(segment).then_some(segment)
    }

    /// Whether a segment runs inside the face rather than along its outline.
    fn is_inside(&self, [a, b]: [DVec3; 2]) -> bool {
        let level = SAME * self.polygon.size();
        let v = self.polygon.vertices();
        let on = |i: usize| {
            let edge = v[(i + 1) % v.len()] - v[i];
            let inward = self.polygon.normal().cross(edge).normalize_or_zero();
            [a, b].iter().all(|p| inward.dot(*p - v[i]).abs() <= level)
        };
        (b - a).length() > level && !(0..v.len()).any(on)
    }

    /// The part of a segment that is in the face: from its first point in a convex part to the last one.
    fn within(&self, [a, b]: [DVec3; 2]) -> Option<[DVec3; 2]> {
        let parts =
            self.convex.iter().filter_map(|part| inside(part, [a, b], self.polygon.normal(), 0.0)).filter(|[from, to]| to > from);
        let [from, to] = parts.reduce(|[from, to], [start, end]| [smallest(from, start), largest(to, end)])?;
        Some([from, to].map(|share| a + (b - a) * share))
    }

    /// The shadow of an edge from a corner of a lamp.
    fn corner(&self, lamp: usize, v: DVec3, edge: [DVec3; 2]) -> Option<[DVec3; 2]> {
        let over = self.height(v);
        let [a, b] = clip(edge, |p| self.height(p) + SAME * over)
            .and_then(|edge| clip(edge, |p| (1.0 - BELOW) * over - self.height(p)))?;
        let shadow = [a, b].map(|p| v + (p - v) * (over / (over - self.height(p))));
        self.lit(lamp, shadow, |_| Some(v))
    }

    /// The shadow of a vertex from a side of a lamp.
    fn side(&self, lamp: usize, side: [DVec3; 2], o: DVec3) -> Option<[DVec3; 2]> {
        let over = self.height(o);
        if over <= SAME * self.polygon.size() {
            return None;
        }
        let [p, q] = clip(side, |m| (1.0 - BELOW) * self.height(m) - over)?;
        let shadow = [p, q].map(|m| m + (o - m) * (self.height(m) / (self.height(m) - over)));
        let plane = self.scenery.polygons[lamp].normal();
        self.lit(lamp, shadow, |x| {
            let (toward, level) = (plane.dot(o - x), plane.dot(p - x));
            (level / toward > 1.0).then(|| x + (o - x) * (level / toward))
        })
    }

    /// The part of a line where the light of a lamp changes; `target` is the point of the lamp that the feature passes, as seen from
    /// a point of the line.
    fn lit(&self, lamp: usize, line: [DVec3; 2], target: impl Fn(DVec3) -> Option<DVec3>) -> Option<[DVec3; 2]> {
        let of_lamp = &self.scenery.polygons[lamp];
        let [a, b] = clip(self.within(line)?, |x| of_lamp.normal().dot(x - of_lamp.vertices()[0]))?;
        if !self.is_inside([a, b]) {
            return None;
        }
        let midpoint = |place: usize| a + (b - a) * ((place as f64 + 0.5) / PLACES as f64);
        let counts = |place: &usize| target(midpoint(*place)).is_some_and(|m| self.is_outline(lamp, midpoint(*place), m));
        let first = (0..PLACES).find(counts)?;
        let last = (0..PLACES).rfind(counts)?;
        let share = |place: usize| place as f64 / PLACES as f64;
        Some([share(first), share(last + 1)].map(|share| a + (b - a) * share))
    }

    /// Whether around a point of a lamp, seen from a point of the face, something is hidden and something is free.
    fn is_outline(&self, lamp: usize, x: DVec3, m: DVec3) -> bool {
        let (toward, length) = ((m - x) * (1.0 - BEFORE), (m - x).length());
        let across = toward.any_orthogonal_vector().normalize_or_zero();
        let other = toward.cross(across).normalize_or_zero();
        let hidden = |[s, t]: &&[f64; 2]| {
            let end = x + toward + (across * *s + other * *t) * (ASIDE * length);
            self.scenery.index.is_between([x, end], &[self.face, lamp])
        };
        let count = AROUND.iter().filter(hidden).count();
        count > 0 && count < AROUND.len()
    }
}

/// The part of a segment where an affine function is not negative.
fn clip([a, b]: [DVec3; 2], of: impl Fn(DVec3) -> f64) -> Option<[DVec3; 2]> {
    let [start, end] = [a, b].map(of);
    if start < 0.0 && end < 0.0 {
        return None;
    }
    let crossing = a + (b - a) * (start / (start - end));
    Some(match (start < 0.0, end < 0.0) {
        (true, _) => [crossing, b],
        (_, true) => [a, crossing],
        _ => [a, b],
    })
}

/// Segments of which those on one line that overlap are joined.
fn joined(lines: Vec<[DVec3; 2]>, level: f64) -> Vec<[DVec3; 2]> {
    let mut joined: Vec<[DVec3; 2]> = Vec::new();
    for line in lines {
        let same = joined.iter_mut().find_map(|drawn| overlap(*drawn, line, level).map(|union| (drawn, union)));
        match same {
            Some((drawn, union)) => *drawn = union,
            None => joined.push(line),
        }
    }
    joined
}

/// Two segments of one line as one, where they meet.
fn overlap([a, b]: [DVec3; 2], other: [DVec3; 2], level: f64) -> Option<[DVec3; 2]> {
    let (along, length) = ((b - a).normalize_or_zero(), (b - a).length());
    let distance = |p: DVec3| (p - a).reject_from(along).length();
    if other.iter().any(|&p| distance(p) > level) {
        return None;
    }
    let [c, d] = other.map(|p| along.dot(p - a));
    let (from, to) = (smallest(c, d), largest(c, d));
    (from <= length + level && to >= -level).then(|| [a + along * smallest(from, 0.0), a + along * largest(to, length)])
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A rectangle at a height, facing down or up.
    fn rectangle([low, high]: [[f64; 2]; 2], z: f64, up: bool) -> Polygon {
        let mut v = vec![[low[0], low[1]], [high[0], low[1]], [high[0], high[1]], [low[0], high[1]]];
        if !up {
            v.reverse();
        }
        Polygon::new(v.into_iter().map(|[x, y]| DVec3::new(x, y, z)).collect()).unwrap()
    }

    /// The lines that a lamp and some screens make on the floor, which is the first, the lamp being the second.
    fn lines_of(polygons: &[Polygon]) -> Vec<[DVec3; 2]> {
        let index = Occluders::new(polygons);
        let scenery = Scenery { polygons, index: &index, lamps: &[1] };
        lines(&scenery, 0, &[polygons[0].vertices().to_vec()], &[(2..polygons.len()).collect()])
    }

    /// Where lines along y are.
    fn across(lines: &[[DVec3; 2]]) -> Vec<f64> {
        let mut positions: Vec<f64> = lines.iter().filter(|[a, b]| (a.x - b.x).abs() < 1e-9).map(|[a, _]| a.x).collect();
        positions.sort_by(f64::total_cmp);
        positions
    }

    fn floor_and_lamp() -> [Polygon; 2] {
        [rectangle([[-4.0, -4.0], [4.0, 4.0]], 0.0, true), rectangle([[-0.5, -0.5], [0.5, 0.5]], 2.0, false)]
    }

    #[test]
    fn umbra_and_penumbra_of_a_screen_end_where_geometry_says() {
        let [floor, lamp] = floor_and_lamp();
        let screen = rectangle([[-1.0, -1.0], [1.0, 1.0]], 1.0, true);
        let lines = lines_of(&[floor, lamp, screen]);
        // Halfway down an edge at 1 throws its shadow to 2 less or more half the lamp, from either end of the lamp.
        let positions = across(&lines);
        for expected in [-2.5, -1.5, 1.5, 2.5] {
            assert!(positions.iter().any(|x| (x - expected).abs() < 1e-9), "{expected}: {positions:?}");
        }
        assert_eq!(positions.len(), 4, "{positions:?}");
        assert_eq!(lines.len(), 8, "{lines:?}");
    }

    #[test]
    fn a_half_plane_throws_the_two_ends_of_a_penumbra() {
        let [floor, lamp] = floor_and_lamp();
        let half = rectangle([[0.25, -40.0], [40.0, 40.0]], 1.0, true);
        let lines = lines_of(&[floor, lamp, half]);
        let positions = across(&lines);
        assert_eq!(lines.len(), 2, "{lines:?}");
        assert!((positions[0] - 0.0).abs() < 1e-9 && (positions[1] - 1.0).abs() < 1e-9, "{positions:?}");
    }

    #[test]
    fn a_lamp_that_faces_away_or_is_hidden_makes_no_lines() {
        let [floor, lamp] = floor_and_lamp();
        let screen = rectangle([[-1.0, -1.0], [1.0, 1.0]], 1.0, true);
        let turned = rectangle([[-0.5, -0.5], [0.5, 0.5]], 2.0, true);
        assert!(lines_of(&[floor.clone(), turned, screen.clone()]).is_empty());
        let lid = rectangle([[-40.0, -40.0], [40.0, 40.0]], 1.5, true);
        assert!(lines_of(&[floor, lamp, screen, lid]).is_empty());
    }

    #[test]
    fn an_edge_that_faces_share_makes_one_line_and_none_where_it_is_no_outline() {
        let [floor, lamp] = floor_and_lamp();
        let halves = [[[-1.0, -1.0], [0.1, 1.0]], [[0.1, -1.0], [1.0, 1.0]]].map(|at| rectangle(at, 1.0, true));
        let [left, right] = halves;
        assert_eq!(lines_of(&[floor.clone(), lamp.clone(), left.clone(), right]).len(), 8);
        // A fold down from the edge at 0.1: that is one outline, whose shadow from the lamp's far side is at 0.7.
        let down = [[0.1, -1.0, 0.5], [0.1, 1.0, 0.5], [0.1, 1.0, 1.0], [0.1, -1.0, 1.0]].map(DVec3::from);
        let positions = across(&lines_of(&[floor, lamp, left, Polygon::new(down.to_vec()).unwrap()]));
        assert_eq!(positions.iter().filter(|x| (**x - 0.7).abs() < 1e-9).count(), 1, "{positions:?}");
    }
}
