//! Half-spaces, and proof that something is outside.
//!
//! A plane through three points o, a, b of the input has `s(p) = det(a - o, b - o, p - o)`, which is positive inside. In double
//! precision, in coordinates `q = (p - O) 2^k` of a [`Frame`], `s = N.q(p) - N.q(o)` with `N = (q(a) - q(o)) x (q(b) - q(o))`
//! from rounded differences a - o, b - o. A term of N passes through four roundings (two differences, a product, a difference),
//! one of s through five more (its difference, a product, three sums), so that with u = 2^-53 and M the cross product of
//! magnitudes, added instead of subtracted, the error is at most `9 u (1 + 9 u) (sum M_i) (|q(p)| + |q(o)|)` in largest
//! components. Computing that bound loses less than `10 u` of it: 10 u covers all. Where this decides nothing, an exact predicate
//! does (J. R. Shewchuk 1997, crate `robust`).
//!
//! A polygon of more than three vertices that are in one plane only up to rounding has no plane through three of them that decides
//! for all; there the plane is that of its normal, and a point outside must be so by more than the vertices' distances from it.
//!
//! The plane of a surface is known only as well as the rounded coordinates determine it. With vertices off by at most
//! `d = 4 eps C`, C their largest coordinate (four roundings each, as `radgrad_core::Polygon` allows), the area vector of a
//! polygon of perimeter P and area A is off by at most P d / 2, so that its normal is off by an angle P d / (2 A), and a vertex of
//! the same wall at distance r appears at a height of at most `8 eps (C + r) + r P d / A`: the two points' own d, and twice the tilt
//! ([`Level`]). Twice the tilt counts up to [`STEEPEST`]: what lies at that angle over a plane is `STEEPEST^2` of the hemisphere, less than a
//! rounding. Of a small polygon a larger tilt would leave light out.
//!
//! A frame's power of two brings its lengths to about 1. Below 2^-900 of that products may underflow; a magnitude of at least
//! that much covers them.

use radgrad_core::{DVec3, Polygon, Receiver};
use robust::{Coord3D, orient3d};

use crate::extremes::{largest, smallest};
use crate::projection::normalising_power;

/// The bound of the module's text, in units of the magnitudes.
const ROUNDING: f64 = 5.0 * f64::EPSILON;

/// 2^-900: covers underflow in products of normalised lengths.
const TINY: f64 = f64::from_bits((1023 - 900) << 52);

/// The largest slope of a surface's plane that counts as rounding: see the module's text.
const STEEPEST: f64 = 1e-8;

/// How far from the plane of a surface points of it may be by the rounding of coordinates.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Level {
    /// The largest coordinate.
    largest: f64,
    /// Twice the angle by which the plane may be off.
    tilt: f64,
}

impl Level {
    /// Of a polygon with this largest coordinate, and perimeter over area.
    pub(crate) fn new(largest: f64, slope: f64) -> Self {
        Self { largest, tilt: smallest(4.0 * f64::EPSILON * largest * slope, STEEPEST) }
    }

    /// At this distance from a vertex.
    pub(crate) fn at(self, r: f64) -> f64 {
        8.0 * f64::EPSILON * (self.largest + r) + r * self.tilt
    }

    /// The same in another unit.
    fn scaled(self, power: f64) -> Self {
        Self { largest: self.largest * power, ..self }
    }

    /// The same with a point that has this for its largest coordinate.
    fn with(self, coordinate: f64) -> Self {
        Self { largest: largest(self.largest, coordinate), ..self }
    }
}

/// Coordinates in which near points have size 1.
#[derive(Debug, Clone, Copy)]
pub(super) struct Frame {
    pub(super) origin: DVec3,
    pub(super) power: f64,
}

impl Frame {
    /// A point, with its coordinates in the frame.
    pub(super) fn locate(&self, point: DVec3) -> Located {
        let q = (point - self.origin) * self.power;
        Located { point, q, reach: q.abs().max_element() }
    }
}

/// A point in a frame.
#[derive(Debug, Clone, Copy)]
pub(super) struct Located {
    pub(super) point: DVec3,
    q: DVec3,
    reach: f64,
}

/// The part of space where `s > 0`.
#[derive(Debug, Clone)]
pub(super) struct HalfSpace {
    normal: DVec3,
    /// `N.q(o)`.
    offset: f64,
    /// Sum of the magnitudes of N.
    magnitude: f64,
    /// A point of the plane.
    origin: Located,
    /// By this much the plane itself may be off.
    slack: f64,
    exact: Exact,
}

/// The way to decide cases that rounding leaves open.
#[derive(Debug, Clone)]
enum Exact {
    /// By three points, times a power of two.
    Points([Coord3D<f64>; 3], f64),
    /// Only where every product vanishes.
    Products,
    /// Not.
    Never,
    /// They are not decided: a point level with the plane is on it.
    Level(Level),
}

/// Where a point is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Side {
    Inside,
    On,
    Outside,
    /// Any of these.
    Unknown,
}

impl HalfSpace {
    fn new(normal: DVec3, magnitude: DVec3, origin: Located, slack: f64, exact: Exact) -> Self {
        Self { normal, offset: sum(normal * origin.q), magnitude: sum(magnitude) + TINY, origin, slack, exact }
    }

    /// Bounded by the plane through three points, inside where they run counter-clockwise.
    pub(super) fn through(o: DVec3, a: DVec3, b: DVec3, frame: &Frame) -> Self {
        let (u, v) = ((a - o) * frame.power, (b - o) * frame.power);
        let (m, n) = (u.abs(), v.abs());
        let magnitude = DVec3::new(m.y * n.z + m.z * n.y, m.z * n.x + m.x * n.z, m.x * n.y + m.y * n.x);
        let largest = [o, a, b].iter().map(|p| p.abs().max_element()).fold(0.0, largest);
        let scale = normalising_power(largest);
        let exact = Exact::Points([o, a, b].map(|p| coordinates(p, scale)), scale);
        Self::new(u.cross(v), magnitude, frame.locate(o), 0.0, exact)
    }

    /// Above the horizon of a receiver.
    pub(super) fn above(receiver: &Receiver, frame: &Frame) -> Self {
        let normal = receiver.direction();
        Self::new(normal, normal.abs(), frame.locate(receiver.position()), 0.0, Exact::Products)
    }

    /// The other side of the same plane.
    pub(super) fn reversed(mut self) -> Self {
        (self.normal, self.offset) = (-self.normal, -self.offset);
        if let Exact::Points([_, a, b], _) = &mut self.exact {
            std::mem::swap(a, b);
        }
        self
    }

    /// Whether no point of a box is inside, given by two corners located in the half-space's frame.
    ///
    /// `N.q` with the computed N is largest at the corner that the signs of N choose; the value with the true N anywhere in the box
    /// exceeds it by no more than the bound at the farthest coordinate.
    pub(super) fn misses_box(&self, low: &Located, high: &Located) -> bool {
        let corner = DVec3::select(self.normal.cmpgt(DVec3::ZERO), high.q, low.q);
        sum(self.normal * corner) - self.offset < -(self.error(largest(low.reach, high.reach)) + self.slack)
    }

    /// Whether no point of a box is in front of a surface's plane by more than is level with it nearby.
    pub(super) fn excludes_box(&self, low: &Located, high: &Located) -> bool {
        let Exact::Level(level) = self.exact else { return self.misses_box(low, high) };
        let corner = DVec3::select(self.normal.cmpgt(DVec3::ZERO), high.q, low.q);
        sum(self.normal * corner) - self.offset <= self.slack + level.at(0.0)
    }

    /// The height up to which every point of a box is level with the plane. The farther the box, the larger it is: so boxes of a level floor are not
    /// looked into.
    fn level_at_box(&self, low: &Located, high: &Located) -> f64 {
        let Exact::Level(level) = self.exact else { return 0.0 };
        let beyond = (low.q - self.origin.q).max(self.origin.q - high.q).max(DVec3::ZERO);
        // The distance is rounded by less than this.
        level.at(beyond.length() * (1.0 - 8.0 * f64::EPSILON)) + self.slack
    }

    /// Whether no point in a box is on the other side, as [`Self::holds`] says it.
    pub(super) fn holds_box(&self, low: &Located, high: &Located) -> bool {
        let corner = DVec3::select(self.normal.cmpgt(DVec3::ZERO), low.q, high.q);
        // The same with the computed N at a point in it is larger, but for rounding, and that of the point counts on its side.
        sum(self.normal * corner) - self.offset >= 2.0 * self.error(largest(low.reach, high.reach)) - self.level_at_box(low, high)
    }

    /// Whether no point of the convex hull of `points` is inside, where points on the plane are not.
    pub(super) fn excludes(&self, points: impl IntoIterator<Item = Located>) -> bool {
        points.into_iter().all(|point| matches!(self.side(&point), Side::On | Side::Outside))
    }

    /// Whether no point of the convex hull of `points` is on the other side.
    pub(super) fn holds(&self, points: impl IntoIterator<Item = Located>) -> bool {
        points.into_iter().all(|point| matches!(self.side(&point), Side::On | Side::Inside))
    }

    /// The side of the plane that a point is on.
    pub(super) fn side(&self, point: &Located) -> Side {
        let s = sum(self.normal * point.q) - self.offset;
        let mut certain = self.error(point.reach) + self.slack;
        if let Exact::Level(level) = self.exact {
            certain += level.at((point.q - self.origin.q).length());
        }
        if s > certain {
            return Side::Inside;
        }
        if s < -certain {
            return Side::Outside;
        }
        match &self.exact {
            Exact::Points([o, a, b], scale) => match -orient3d(*o, *a, *b, coordinates(point.point, *scale)) {
                s if s > 0.0 => Side::Inside,
                s if s < 0.0 => Side::Outside,
                _ => Side::On,
            },
            Exact::Products if self.vanishes(point.point) => Side::On,
            Exact::Level(_) => Side::On,
            Exact::Products | Exact::Never => Side::Unknown,
        }
    }

    /// Whether `N.(p - o)` is zero term by term.
    fn vanishes(&self, point: DVec3) -> bool {
        (0..3).all(|axis| self.normal[axis] == 0.0 || point[axis] == self.origin.point[axis])
    }

    /// Bound on the error of `s` at a point with this largest coordinate in the frame.
    fn error(&self, reach: f64) -> f64 {
        ROUNDING * self.magnitude * (reach + self.origin.reach) + f64::MIN_POSITIVE
    }
}

/// The plane of a polygon.
#[derive(Debug, Clone)]
pub(super) struct Plane {
    origin: DVec3,
    normal: DVec3,
    /// Three vertices in order that are not on one line, where the others are exactly in their plane.
    corners: Option<[DVec3; 3]>,
    /// Distance by which vertices are off.
    defect: f64,
    level: Level,
}

impl Plane {
    pub(super) fn of(polygon: &Polygon) -> Self {
        let (vertices, normal) = (polygon.vertices(), polygon.normal());
        let power = normalising_power(polygon.size());
        let offset = |i: usize| (vertices[i % vertices.len()] - vertices[0]) * power;
        let turn = |i: usize| normal.dot(offset(i).cross(offset(i + 1)));
        let fan = 1..vertices.len() - 1;
        // The widest triangle of a fan: of a polygon with area at least one has area.
        let widest = fan.clone().max_by(|&i, &j| turn(i).total_cmp(&turn(j))).unwrap_or(1);
        let perimeter: f64 = (0..vertices.len()).map(|i| (offset(i + 1) - offset(i)).length()).sum();
        let area: f64 = 0.5 * fan.map(turn).sum::<f64>();
        Self {
            origin: vertices[0],
            normal,
            corners: (polygon.planarity_defect() == 0.0).then(|| [vertices[0], vertices[widest], vertices[widest + 1]]),
            defect: polygon.planarity_defect() * (1.0 + 4.0 * f64::EPSILON),
            level: Level::new(vertices.iter().map(|v| v.abs().max_element()).fold(0.0, largest), perimeter / area * power),
        }
    }

    /// The height of a point over the plane.
    pub(super) fn height(&self, point: DVec3) -> f64 {
        self.normal.dot(point - self.origin)
    }

    /// The height up to which a point may be level with the surface: more than twice the one that [`Self::over`] uses, so that it
    /// covers all points that that one takes for level.
    pub(super) fn slack(&self, point: DVec3) -> f64 {
        let r = (point - self.origin).length();
        4.0 * self.level.with(point.abs().max_element()).at(r) + 2.0 * self.defect
    }

    /// The space in front, exactly.
    pub(super) fn front(&self, frame: &Frame) -> HalfSpace {
        match self.corners {
            Some([o, a, b]) => HalfSpace::through(o, a, b, frame),
            None => self.along_normal(frame, Exact::Never),
        }
    }

    /// The space in front of the surface; a point level with it up to the rounding of coordinates is on its plane.
    pub(super) fn over(&self, frame: &Frame) -> HalfSpace {
        self.along_normal(frame, Exact::Level(self.level.scaled(frame.power)))
    }

    fn along_normal(&self, frame: &Frame, exact: Exact) -> HalfSpace {
        HalfSpace::new(self.normal, self.normal.abs(), frame.locate(self.origin), self.defect * frame.power, exact)
    }
}

fn sum(v: DVec3) -> f64 {
    v.x + v.y + v.z
}

fn coordinates(point: DVec3, scale: f64) -> Coord3D<f64> {
    let [x, y, z] = (point * scale).to_array();
    Coord3D { x, y, z }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Points within a few roundings of a plane through random points, and the exact side of each.
    fn near_a_plane() -> impl Iterator<Item = (HalfSpace, Located, Side)> {
        let mut state = 1_u64;
        let mut uniform = move || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
        };
        (0..20_000).map(move |i| {
            let mut point = || DVec3::new(uniform(), uniform(), uniform()) * if i % 3 == 0 { 1e6 } else { 1.0 };
            let [o, a, b, elsewhere] = [(); 4].map(|()| point());
            let frame = Frame { origin: elsewhere, power: normalising_power((o - elsewhere).abs().max_element()) };
            let p = o + (a - o) * uniform() + (b - o) * uniform();
            // Every other point is a few bounds away.
            let p = if i % 2 == 0 { p } else { p + (a - o).cross(b - o).normalize_or_zero() * (uniform() * 1e-13 * p.length()) };
            let exact = |p: DVec3| coordinates(p, 1.0);
            let side = match -orient3d(exact(o), exact(a), exact(b), exact(p)) {
                s if s > 0.0 => Side::Inside,
                s if s < 0.0 => Side::Outside,
                _ => Side::On,
            };
            (HalfSpace::through(o, a, b, &frame), frame.locate(p), side)
        })
    }

    #[test]
    fn sides_are_exact_however_near_the_plane() {
        for (half_space, point, side) in near_a_plane() {
            assert_eq!(half_space.side(&point), side);
            let opposite = [(Side::Inside, Side::Outside), (Side::Outside, Side::Inside), (Side::On, Side::On)];
            let (_, expected) = opposite.into_iter().find(|(given, _)| *given == side).unwrap();
            assert_eq!(half_space.reversed().side(&point), expected);
        }
    }

    #[test]
    fn a_box_is_missed_only_where_all_of_it_is_outside() {
        let mut missed = 0;
        for (half_space, point, side) in near_a_plane() {
            if half_space.misses_box(&point, &point) {
                assert_eq!(side, Side::Outside);
                missed += 1;
            }
        }
        assert!(missed > 0, "some points are far enough from the plane to tell");
    }
}
