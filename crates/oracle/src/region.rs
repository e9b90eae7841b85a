//! The part of an emitter that a receiver sees: lit side, clipped by the receiver's horizon, as triangles in the emitter's
//! plane.
//!
//! Coordinates are those of the foot of the receiver: `y - x = p u + q v - h n2` with `u, v, n2` orthonormal and right-handed,
//! `h` the height of `x` over the plane. Each vertex also carries `s = n1.(y - x)` and, for an affine emission, `b = B(y)`:
//! both are affine in `(p, q)`, so interpolating them between corners keeps relative accuracy where a dot product would cancel
//! (`s = 0` exactly on the horizon). Lengths are scaled by a power of two, `unit`, that brings the farthest vertex to [1, 2).
//! Everything up to the final rounding of `p, q, s, b, h` is done in [`Pair`]s: numbers are rounded relative to `x`, not to the
//! origin. Which side of the plane `x` is on is decided exactly (`side`): in the plane nothing is seen.
//!
//! Each triangle is cut at its point nearest to the receiver, the only place where the integrand peaks, and at the nearest
//! point of each edge; from then on these are corners, and halving a triangle approaches them with full relative accuracy.

mod compensated;
mod ear_clipping;
pub(crate) mod plane;
mod side;

use glam::DVec3;
use nalgebra::Vector3;
use radgrad_core::{Polygon, Receiver};

use crate::Error;
use crate::region::compensated::{Pair, PairVector, cross, dot, normalising_power, unit};
use crate::region::plane::{Edge, Triangle, Vertex};
use crate::region::side::{Side, side};
use crate::source_function::SourceFunction;

/// A vertex before rounding.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct PreciseVertex {
    pub(crate) p: Pair,
    pub(crate) q: Pair,
    s: Pair,
    b: Pair,
}

/// A vector in the frame `(u, v, n2)` of a region, of another type than one in space so that none is taken for the other.
pub(crate) type FrameVector = Vector3<f64>;

/// The part of a polygon that a receiver sees.
#[derive(Debug)]
pub(crate) struct Region {
    /// Disjoint triangles; none if nothing is seen.
    pub(crate) triangles: Vec<Triangle>,
    /// The boundary of the clipped polygon, counter-clockwise, each edge cut at its point nearest to the receiver. Where the
    /// horizon cuts a concave polygon into parts, they are joined by edges that run along the horizon and back.
    pub(crate) outline: Vec<Edge>,
    /// Whether the receiver lies in the polygon itself, border included.
    pub(crate) touched: bool,
    /// Height of the receiver over the plane, scaled.
    pub(crate) height: f64,
    /// Receiver normal in the frame `(u, v, n2)`.
    pub(crate) normal: FrameVector,
    /// The frame.
    pub(crate) axes: [DVec3; 3],
    /// Position of the receiver.
    pub(crate) position: DVec3,
    /// Scaled length over length.
    pub(crate) unit: f64,
    /// Reflectance over pi.
    pub(crate) factor: f64,
}

impl Region {
    pub(crate) fn new(receiver: &Receiver, polygon: &Polygon, source: &SourceFunction<'_>) -> Result<Self, Error> {
        let vertices = polygon.vertices();
        let position = receiver.position();
        let farthest = vertices.iter().map(|e| (*e - position).abs().max_element()).fold(0.0, f64::max);
        if !farthest.is_finite() {
            return Err(Error::NotFinite { quantity: "the distance of a vertex from the receiver", value: farthest });
        }
        let power = normalising_power(farthest);
        let rays: Vec<PairVector> = vertices.iter().map(|e| offset(*e, position, power)).collect();
        let axes = frame(&rays);
        let n1 = unit(receiver.given_normal().to_array().map(Pair::from));
        let normal = axes.map(|axis| dot(axis, n1));
        let height = -dot(axes[2], rays[0]);
        let place = |(index, ray): (usize, &PairVector)| {
            let (p, q) = (dot(axes[0], *ray), dot(axes[1], *ray));
            let s = normal[0] * p + normal[1] * q - normal[2] * height;
            PreciseVertex { p, q, s, b: Pair::from(source.at_vertex(index).unwrap_or(0.0)) }
        };
        let outline: Vec<PreciseVertex> = rays.iter().enumerate().map(place).collect();
        let mut region = Self {
            triangles: Vec::new(),
            outline: Vec::new(),
            touched: false,
            height: height.rounded(),
            normal: normal.map(Pair::rounded).into(),
            axes: axes.map(|axis| DVec3::from_array(axis.map(Pair::rounded))),
            position,
            unit: power,
            factor: receiver.reflectance() * std::f64::consts::FRAC_1_PI,
        };
        match side(position, polygon, &outline) {
            Side::Unlit => {}
            Side::InPlane => region.touched = ear_clipping::triangulate(&outline)?.iter().any(|ear| foot_inside(ear).is_some()),
            Side::Lit if height.is_positive() => region.see(&outline)?,
            Side::Lit => return Err(Error::Height { position }),
        }
        Ok(region)
    }

    /// Takes in the part above the horizon of a polygon whose lit side faces the receiver.
    fn see(&mut self, outline: &[PreciseVertex]) -> Result<(), Error> {
        for ear in ear_clipping::triangulate(outline)? {
            let visible = above_horizon(&ear);
            for i in 2..visible.len() {
                cut_at_nearest(&[visible[0], visible[i - 1], visible[i]], &mut self.triangles);
            }
        }
        let visible = above_horizon(outline);
        for (i, from) in visible.iter().enumerate() {
            let to = &visible[(i + 1) % visible.len()];
            let rim: Vec<PreciseVertex> = [Some(*from), nearest_within(from, to), Some(*to)].into_iter().flatten().collect();
            self.outline.extend(rim.windows(2).map(|ends| ends[0].edge_to(&ends[1])));
        }
        Ok(())
    }

    /// The point of space at in-plane coordinates `(p, q)`.
    pub(crate) fn point(&self, p: f64, q: f64) -> DVec3 {
        self.position + (self.axes[0] * p + self.axes[1] * q - self.axes[2] * self.height) / self.unit
    }

    /// The seen point at in-plane coordinates `(p, q)`, with height and emission interpolated from the corners.
    pub(crate) fn vertex(&self, p: f64, q: f64) -> Option<Vertex> {
        self.triangles.iter().find_map(|triangle| triangle.vertex(p, q))
    }

    /// Square of the distance of the nearest seen point.
    pub(crate) fn squared_distance(&self) -> f64 {
        let in_plane = self.triangles.iter().map(Triangle::squared_distance_to_foot).fold(f64::INFINITY, f64::min);
        in_plane + self.height * self.height
    }

    /// A vector of the frame in space.
    pub(crate) fn to_space(&self, v: FrameVector) -> DVec3 {
        self.axes[0] * v.x + self.axes[1] * v.y + self.axes[2] * v.z
    }
}

/// `(point - origin)` times a power of two.
fn offset(point: DVec3, origin: DVec3, power: f64) -> PairVector {
    [0, 1, 2].map(|axis| Pair::difference(point[axis], origin[axis]).scaled(power))
}

/// Normal by Newell's sum, `u` along the longest of the edges, `v = n2 x u`.
fn frame(rays: &[PairVector]) -> [PairVector; 3] {
    let count = rays.len();
    let from_first = |i: usize| minus(rays[i], rays[0]);
    let mut twice_area = [Pair::ZERO; 3];
    for i in 2..count {
        let term = cross(from_first(i - 1), from_first(i));
        twice_area = [0, 1, 2].map(|axis| twice_area[axis] + term[axis]);
    }
    let normal = unit(twice_area);
    let edge = |i: usize| minus(rays[(i + 1) % count], rays[i]);
    let length = |i: &usize| dot(edge(*i), edge(*i)).rounded();
    let longest = (0..count).max_by(|i, j| length(i).total_cmp(&length(j))).unwrap_or(0);
    let along = edge(longest);
    let off_plane = dot(along, normal);
    let u = unit([0, 1, 2].map(|axis| along[axis] - normal[axis] * off_plane));
    [u, cross(normal, u), normal]
}

fn minus(a: PairVector, b: PairVector) -> PairVector {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

impl PreciseVertex {
    #[cfg(test)]
    pub(crate) fn in_plane(p: Pair, q: Pair) -> Self {
        Self { p, q, s: Pair::ZERO, b: Pair::ZERO }
    }

    fn towards(&self, other: &Self, t: Pair) -> Self {
        let between = |a: Pair, b: Pair| a + (b - a) * t;
        Self {
            p: between(self.p, other.p),
            q: between(self.q, other.q),
            s: between(self.s, other.s),
            b: between(self.b, other.b),
        }
    }

    /// The segment to another vertex.
    fn edge_to(&self, to: &Self) -> Edge {
        let (along_p, along_q) = (to.p - self.p, to.q - self.q);
        let moment = self.p * along_q - self.q * along_p;
        let ends = [self.rounded(), to.rounded()];
        Edge { ends, along: [along_p.rounded(), along_q.rounded()], moment: moment.rounded() }
    }

    fn rounded(&self) -> Vertex {
        Vertex { p: self.p.rounded(), q: self.q.rounded(), s: self.s.rounded(), b: self.b.rounded() }
    }
}

/// Twice the signed area of a triangle in the plane.
pub(crate) fn twice_area(a: &PreciseVertex, b: &PreciseVertex, c: &PreciseVertex) -> Pair {
    (b.p - a.p) * (c.q - a.q) - (b.q - a.q) * (c.p - a.p)
}

/// The part of a polygon with `s >= 0` (Sutherland and Hodgman 1974).
fn above_horizon(polygon: &[PreciseVertex]) -> Vec<PreciseVertex> {
    let mut above = Vec::with_capacity(polygon.len() + 1);
    for (i, here) in polygon.iter().enumerate() {
        let next = &polygon[(i + 1) % polygon.len()];
        if !here.s.is_negative() {
            above.push(*here);
        }
        let crosses = (here.s.is_positive() && next.s.is_negative()) || (here.s.is_negative() && next.s.is_positive());
        if crosses {
            above.push(PreciseVertex { s: Pair::ZERO, ..here.towards(next, here.s / (here.s - next.s)) });
        }
    }
    if above.iter().any(|vertex| vertex.s.is_positive()) { above } else { Vec::new() }
}

/// Cuts a triangle into a fan around its point nearest to the foot of the receiver, with a spoke to the nearest point of every
/// edge, and keeps the parts with an area. An edge that passes the foot at distance `d` between far corners would be displaced
/// by their rounding, a relative error of `eps size / d` of everything near it.
fn cut_at_nearest(triangle: &[PreciseVertex; 3], parts: &mut Vec<Triangle>) {
    let mut rim = Vec::with_capacity(6);
    for (i, from) in triangle.iter().enumerate() {
        rim.push(*from);
        rim.extend(nearest_within(from, &triangle[(i + 1) % 3]));
    }
    let squared = |v: &PreciseVertex| (v.p * v.p + v.q * v.q).rounded();
    let on_rim = || rim.iter().copied().min_by(|one, other| squared(one).total_cmp(&squared(other)));
    let Some(hub) = foot_inside(triangle).or_else(on_rim) else { return };
    for (i, from) in rim.iter().enumerate() {
        let to = &rim[(i + 1) % rim.len()];
        let area = 0.5 * twice_area(from, to, &hub).rounded();
        if *from != hub && *to != hub && area > 0.0 {
            parts.push(Triangle { corners: [from.rounded(), to.rounded(), hub.rounded()], area });
        }
    }
}

/// The point of a segment nearest to the foot of the receiver, unless it is an end.
fn nearest_within(from: &PreciseVertex, to: &PreciseVertex) -> Option<PreciseVertex> {
    let (ep, eq) = (to.p - from.p, to.q - from.q);
    let t = -(from.p * ep + from.q * eq) / (ep * ep + eq * eq);
    (t.is_positive() && (Pair::from(1.0) - t).is_positive()).then(|| from.towards(to, t))
}

/// The foot of the receiver as a vertex, if it is inside the triangle or on its border.
fn foot_inside(triangle: &[PreciseVertex; 3]) -> Option<PreciseVertex> {
    let [a, b, c] = triangle;
    let opposite = |from: &PreciseVertex, to: &PreciseVertex| from.p * to.q - from.q * to.p;
    let weights = [opposite(b, c), opposite(c, a), opposite(a, b)];
    if weights.iter().any(|w| w.is_negative()) {
        return None;
    }
    let total = weights[0] + weights[1] + weights[2];
    if !total.is_positive() {
        return None;
    }
    let mean =
        |value: fn(&PreciseVertex) -> Pair| (weights[0] * value(a) + weights[1] * value(b) + weights[2] * value(c)) / total;
    Some(PreciseVertex { p: Pair::ZERO, q: Pair::ZERO, s: mean(|v| v.s), b: mean(|v| v.b) })
}

#[cfg(test)]
mod tests {
    use radgrad_core::{Emission, Emitter};

    use super::*;

    fn region(corners: &[[f64; 2]], height: f64, foot: [f64; 2], normal: [f64; 3]) -> Region {
        let vertices = corners.iter().map(|[x, y]| DVec3::new(*x, *y, 0.0)).collect();
        let emitter = Emitter::new(Polygon::new(vertices).unwrap(), Emission::Constant(1.0)).unwrap();
        let receiver = Receiver::new(DVec3::new(foot[0], foot[1], height), normal.into(), 1.0).unwrap();
        Region::new(&receiver, emitter.polygon(), &SourceFunction::Emitter(&emitter)).unwrap()
    }

    fn area(region: &Region) -> f64 {
        region.triangles.iter().map(|triangle| triangle.area).sum::<f64>() / (region.unit * region.unit)
    }

    const L_SHAPE: [[f64; 2]; 6] = [[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [1.0, 1.0], [1.0, 2.0], [0.0, 2.0]];

    #[test]
    fn a_concave_polygon_is_covered_once() {
        for foot in [[0.5, 0.5], [1.5, 1.5], [1.0, 1.0], [0.0, 0.7], [5.0, -3.0]] {
            assert!((area(&region(&L_SHAPE, 1e-3, foot, [0.0, 0.0, -1.0])) - 3.0).abs() < 1e-14);
        }
    }

    #[test]
    fn the_horizon_cuts_off_what_is_below_it() {
        // n1 = (1, 0, 0) at x = 1.5 sees the unit square's half beyond; looking the other way, the rest.
        assert!((area(&region(&L_SHAPE, 1.0, [1.5, 0.5], [1.0, 0.0, 0.0])) - 0.5).abs() < 1e-15);
        assert!((area(&region(&L_SHAPE, 1.0, [1.5, 0.5], [-1.0, 0.0, 0.0])) - 2.5).abs() < 1e-15);
        assert!(region(&L_SHAPE, 1.0, [1.5, 0.5], [0.0, 0.0, 1.0]).triangles.is_empty());
    }

    #[test]
    fn the_unlit_side_sees_nothing() {
        let region = region(&L_SHAPE, -1.0, [0.5, 0.5], [0.0, 0.0, 1.0]);
        assert!(region.triangles.is_empty() && region.outline.is_empty() && !region.touched);
    }

    #[test]
    fn touching_is_told_from_being_in_the_plane() {
        for (foot, touched) in
            [([0.5, 0.5], true), ([1.0, 1.5], true), ([2.0, 1.0], true), ([1.5, 1.5], false), ([3.0, 0.0], false)]
        {
            assert_eq!(region(&L_SHAPE, 0.0, foot, [0.0, 0.0, 1.0]).touched, touched, "{foot:?}");
        }
    }

    /// Places in a plane along no axis, exact in doubles; the determinant that says so has three times their digits.
    fn in_tilted_plane(i: i32, j: i32) -> DVec3 {
        let (u, v) = (DVec3::new(699_053.0, 349_529.0, -524_287.0), DVec3::new(-186_413.0, 911_003.0, 420_029.0));
        (u * f64::from(i) + v * f64::from(j)) * 2f64.powi(-36)
    }

    #[test]
    fn in_the_plane_nothing_is_seen_and_an_ulp_decides() {
        let corners = [(0, 0), (40_503, 1201), (9973, 30_011), (-7001, 20_023)].map(|(i, j)| in_tilted_plane(i, j));
        let emitter = Emitter::new(Polygon::new(corners.to_vec()).unwrap(), Emission::Constant(1.0)).unwrap();
        let from = |position: DVec3| {
            let receiver = Receiver::new(position, corners[1] - position, 1.0).unwrap();
            Region::new(&receiver, emitter.polygon(), &SourceFunction::Emitter(&emitter)).unwrap()
        };
        for i in 0..100 {
            let position = in_tilted_plane(811 * i - 30_011, 577 * i - 20_011);
            let region = from(position);
            assert!(region.triangles.is_empty() && region.outline.is_empty(), "{i}");
            let moved = |up: bool| position.with_x(if up { position.x.next_up() } else { position.x.next_down() });
            let lit_up = emitter.polygon().normal().x > 0.0;
            assert!(!from(moved(lit_up)).triangles.is_empty() && from(moved(!lit_up)).triangles.is_empty(), "{i}");
        }
        assert!(from(in_tilted_plane(10_007, 10_009)).touched && !from(in_tilted_plane(-10_007, 10_009)).touched);
    }

    #[test]
    fn halving_covers_the_triangle() {
        let region = region(&L_SHAPE, 0.5, [0.3, 0.6], [0.0, 0.0, -1.0]);
        for triangle in &region.triangles {
            for half in triangle.halves() {
                let [a, b, c] = half.corners;
                let area = 0.5 * ((b.p - a.p) * (c.q - a.q) - (b.q - a.q) * (c.p - a.p));
                assert!((area - half.area).abs() < 1e-15 && half.area == 0.5 * triangle.area);
            }
        }
    }

    #[test]
    fn an_edge_that_passes_close_keeps_its_relative_distance() {
        let needle = [[0.0, 0.0], [1.0, 0.0], [0.4, 1e-9]];
        let region = region(&needle, 1.0, [0.3, 2e-10], [0.0, 0.0, -1.0]);
        let distances: Vec<f64> =
            region.outline.iter().map(|edge| edge.moment.abs() / edge.squared_length().sqrt() / region.unit).collect();
        assert!(distances.iter().any(|d| (d / 2e-10 - 1.0).abs() < 1e-14), "{distances:?}");
    }
}
