//! Half-spaces, and proof that something is outside.
//!
//! A plane through three points o, a, b of the input has `s(p) = det(a - o, b - o, p - o)`, which is positive inside. In double
//! precision, `s = N.(p - o)` with `N = (a - o) x (b - o)`: each of its six terms is a product of three rounded differences and
//! passes through eight roundings (three differences, a product, the difference in N, another product, two sums), so that the
//! error is at most `8 u (1 + 16 u) sum |N|_i |p - o|_i` with u = 2^-53 and |N| the same cross product of magnitudes, added
//! instead of subtracted. The rounding of that sum itself is as much again of second order; 9 u covers all. Where this decides
//! nothing, an exact predicate does (J. R. Shewchuk 1997, crate `robust`).
//!
//! A polygon of more than three vertices that are in one plane only up to rounding has no plane through three of them that says
//! all; there the plane is that of its normal, and what is outside must be so by more than its vertices are off.
//!
//! The plane of a surface is known only as well as the rounded coordinates determine it. With vertices off by at most
//! `d = 4 eps C`, C their largest coordinate (four roundings each, as `radgrad_core::Polygon` allows), the area vector of a
//! polygon of perimeter P and area A is off by at most P d / 2, so that its normal is off by an angle P d / (2 A), and a vertex of
//! the same wall at distance r appears at a height of at most `4 eps (C + r) (2 + r P / A)`: the last factor has the two points'
//! own d, and twice the tilt.
//!
//! Lengths are multiplied by a power of two that brings those of the beam to about 1. Below 2^-900 of that products may
//! underflow; a magnitude of at least that much covers them.

use radgrad_core::{DVec3, Polygon, Receiver};
use robust::{Coord3D, orient3d};

use crate::projection::normalising_power;

/// The bound of the module's text, in units of the magnitudes.
const ROUNDING: f64 = 4.5 * f64::EPSILON;

/// 2^-900: covers underflow in products of normalised lengths.
const TINY: f64 = f64::from_bits((1023 - 900) << 52);

/// The part of space where `s > 0`.
#[derive(Debug, Clone)]
pub(super) struct HalfSpace {
    origin: DVec3,
    normal: DVec3,
    magnitude: DVec3,
    power: f64,
    /// Points are inside unless they are at least this far outside.
    slack: f64,
    exact: Exact,
}

/// How to decide what rounding leaves open.
#[derive(Debug, Clone)]
enum Exact {
    /// By three points, times a power of two.
    Points([Coord3D<f64>; 3], f64),
    /// Only where every product vanishes.
    Products,
    /// Not: points are inside then.
    Never,
    /// Not: what is level with the plane is on it.
    Level { largest: f64, slope: f64 },
}

/// Where a point is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Side {
    Inside,
    On,
    Outside,
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
    /// Largest coordinate.
    largest: f64,
    /// Perimeter over area.
    slope: f64,
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
            largest: vertices.iter().fold(0.0, |largest: f64, v| largest.max(v.abs().max_element())),
            slope: perimeter / area * power,
        }
    }

    /// The space in front, exactly; what is not certain to be elsewhere is in front.
    pub(super) fn front(&self, power: f64) -> HalfSpace {
        match self.corners {
            Some([o, a, b]) => HalfSpace::through(o, a, b, power),
            None => self.along_normal(power, Exact::Never),
        }
    }

    /// The space in front of the surface, where what is level with it up to the rounding of coordinates is not.
    pub(super) fn over(&self, power: f64) -> HalfSpace {
        self.along_normal(power, Exact::Level { largest: self.largest * power, slope: self.slope / power })
    }

    fn along_normal(&self, power: f64, exact: Exact) -> HalfSpace {
        let Self { origin, normal, .. } = *self;
        HalfSpace { origin, normal, magnitude: normal.abs() + TINY, power, slack: self.defect * power, exact }
    }
}

impl HalfSpace {
    /// Bounded by the plane through three points, inside where they run counter-clockwise.
    pub(super) fn through(o: DVec3, a: DVec3, b: DVec3, power: f64) -> Self {
        let (u, v) = ((a - o) * power, (b - o) * power);
        let (m, n) = (u.abs(), v.abs());
        let largest = [o, a, b].iter().fold(0.0, |largest: f64, p| largest.max(p.abs().max_element()));
        let scale = normalising_power(largest);
        Self {
            origin: o,
            normal: u.cross(v),
            magnitude: DVec3::new(m.y * n.z + m.z * n.y, m.z * n.x + m.x * n.z, m.x * n.y + m.y * n.x) + TINY,
            power,
            slack: 0.0,
            exact: Exact::Points([o, a, b].map(|p| coordinates(p, scale)), scale),
        }
    }

    /// Above the horizon of a receiver.
    pub(super) fn above(receiver: &Receiver, power: f64) -> Self {
        let normal = receiver.direction();
        let (origin, magnitude) = (receiver.position(), normal.abs() + TINY);
        Self { origin, normal, magnitude, power, slack: 0.0, exact: Exact::Products }
    }

    /// The other side of the same plane.
    pub(super) fn reversed(mut self) -> Self {
        self.normal = -self.normal;
        if let Exact::Points([_, a, b], _) = &mut self.exact {
            std::mem::swap(a, b);
        }
        self
    }

    /// Whether no point of a box is inside.
    ///
    /// `N.(p - o)` with the computed N is largest at the corner that the signs of N say; what the true N gives anywhere in the box
    /// differs from that by no more than the bound at the farthest coordinates.
    pub(super) fn misses_box(&self, low: DVec3, high: DVec3) -> bool {
        let (to_low, to_high) = ((low - self.origin) * self.power, (high - self.origin) * self.power);
        let corner = DVec3::select(self.normal.cmpgt(DVec3::ZERO), to_high, to_low);
        let reach = to_low.abs().max(to_high.abs());
        sum(self.normal * corner) < -(self.error(reach) + self.slack)
    }

    /// Whether no point of the convex hull of `points` is inside, where points on the plane are not.
    pub(super) fn excludes(&self, points: &[DVec3]) -> bool {
        points.iter().all(|&point| self.side(point) != Side::Inside)
    }

    /// The side of the plane that a point is on; inside where that is not certain.
    pub(super) fn side(&self, point: DVec3) -> Side {
        let (s, error) = self.value(point);
        if let Exact::Level { largest, slope } = self.exact {
            let r = ((point - self.origin) * self.power).length();
            let level = 4.0 * f64::EPSILON * (largest + r) * (2.0 + r * slope) + error + self.slack;
            return match s {
                s if s > level => Side::Inside,
                s if s < -level => Side::Outside,
                _ => Side::On,
            };
        }
        if s > error {
            return Side::Inside;
        }
        if s < -(error + self.slack) {
            return Side::Outside;
        }
        match &self.exact {
            Exact::Points([o, a, b], scale) => match -orient3d(*o, *a, *b, coordinates(point, *scale)) {
                s if s > 0.0 => Side::Inside,
                s if s < 0.0 => Side::Outside,
                _ => Side::On,
            },
            Exact::Products if self.vanishes(point) => Side::On,
            Exact::Products | Exact::Never | Exact::Level { .. } => Side::Inside,
        }
    }

    /// Whether `N.(p - o)` is zero term by term.
    fn vanishes(&self, point: DVec3) -> bool {
        (0..3).all(|axis| self.normal[axis] == 0.0 || point[axis] == self.origin[axis])
    }

    /// `s`, and the bound on its error.
    fn value(&self, point: DVec3) -> (f64, f64) {
        let r = (point - self.origin) * self.power;
        (sum(self.normal * r), self.error(r.abs()))
    }

    /// Bound on the error of `s` at this distance along each axis, normalised.
    fn error(&self, reach: DVec3) -> f64 {
        ROUNDING * sum(self.magnitude * reach) + f64::MIN_POSITIVE
    }
}

fn sum(v: DVec3) -> f64 {
    v.x + v.y + v.z
}

fn coordinates(point: DVec3, scale: f64) -> Coord3D<f64> {
    let [x, y, z] = (point * scale).to_array();
    Coord3D { x, y, z }
}
