//! Bounds on the uncertainty of a shadow where an emitter or an occluder is not flat.
//!
//! Four vertices are in one plane up to rounding only, and no surface through them is the one that was meant. Far from each other
//! two polygons hide the same whatever surface is chosen. Where an occluder meets the emitter's plane, the choice decides which
//! stretch of it is in front. Every surface within the hulls of the vertices is allowed here, and the answer holds for all of them.
//!
//! | symbol | meaning |
//! |---|---|
//! | x | the receiver, the origin; lengths are normalised |
//! | h | height of x over the emitter's plane, from below |
//! | `s_E`, `s_Q` | half the thickness of the slab around the plane of emitter E and occluder Q that holds all surfaces |
//! | M, K | the plane of Q is `M.q = K`, K > 0 |
//! | `s` | `s_E + s_Q R/K` with R the largest distance of Q: so far off E's plane a point of Q may be in front or behind |
//! | P | the part of E that is seen so far, p a point of it |
//! | D | the part of P seen through points of Q that are within s of E's plane |
//! | A, L, r | area and perimeter of D, and its least distance |
//!
//! 1. A surface of Q differs from its plane by at most `s_Q` across, so by at most `s_Q R/K` along a ray that meets the plane within
//!    R. So two choices of surfaces differ in rays alone whose point q on the plane of Q is within s of E's plane: rays to D.
//! 2. The ray to p meets the plane of Q at `q = t p`, `t = K/(M.p)`, at the height `h (1 - t)`. It is within s if
//!    `K/(1 + s/h) <= M.p <= K/(1 - s/h)`: two half-spaces. Together with the sides of Q's cone they cut D out of P. Each is
//!    moved outward by twice its displacement by rounding and by vertices that Q's outline leaves outside.
//! 3. The irradiance through D is at most `max|B| A/r^2`.
//! 4. With D fixed on the emitter the kernel `(n1.w)(n2.w)/p^2` has a gradient of at most `6/p^3`. The boundary of D that belongs
//!    to Q lies off E's plane by at most s, so along the ray by at most `s |p|/h`, and moves with x as if it were in the plane but
//!    for a share `s/h`, counted twice; where that is large, as any boundary at Q's distance does. The boundary of another
//!    occluder, at distance S, moves by 1/S of x's motion. The sum of `6 A/r^3`, `2 L s/(h r^2)` and `length/(r S)` bounds the
//!    gradient for a unit of emission.
//!
//! A receiver that is nearly in the plane of Q may not see its vertices in convex order. Then D is all that is seen within the cone
//! of the vertices, at most `(K + s_Q)|p|` over Q's nearest distance from the plane through x that is parallel to Q; and where their hull
//! may hold the receiver, all that is seen.
//!
//! Nothing stays open where Q is surely in front, or behind, but for vertices that it shares with E's outline: there every surface
//! of E is at most `2 s/a` steep, a the least altitude of a triangle of its vertices, and Q rises faster. Nor where a plane through
//! x and an edge of E parts the two.

use std::cmp::Ordering;

use glam::DVec3;
use radgrad_numbers::exact::orientation;
use radgrad_numbers::number::ROUNDOFF;
use radgrad_numbers::power::normalising_power;
use radgrad_numbers::radius::Radius;
use radgrad_numbers::real::Real;
use radgrad_numbers::vec3::Vec3;

use crate::boundary::arc::Generator;
use crate::boundary::edge_name::EdgeName;
use crate::boundary::plan::{Plan, Side, side_of, sure_side};
use crate::boundary::visibility::part::{Sides, VisiblePart, nearness};
use crate::problem::polygon::Polygon;
use crate::problem::receiver::Receiver;

/// An occluder whose shadow is uncertain.
pub(super) struct Doubt {
    /// Vertices relative to the receiver, normalised.
    vertices: Vec<DVec3>,
    /// M and K.
    plane: (DVec3, f64),
    /// `s`; infinite where the receiver may be in the occluder's plane.
    slack: f64,
    /// `s_Q`.
    slab: f64,
    /// Whether it is not sure that the receiver sees a convex outline.
    is_edge_on: bool,
}

/// A region of the emitter whose visibility is uncertain.
struct Region {
    area: f64,
    perimeter: f64,
    /// Least distance from the receiver.
    distance: f64,
    /// Sum of length over distance from the receiver, of its sides that are other occluders' edges.
    turning: f64,
}

/// Where s is more of h, D is not cut out by heights.
const MOST_SHARE: f64 = 0.5;

/// A point with the nearness `1/S` of the side that starts there, 0 on the emitter's plane.
type Bordered = (DVec3, f64);

/// Whether a point is on the outline of a polygon, exactly.
pub(super) fn is_on_outline(point: DVec3, polygon: &Polygon) -> bool {
    polygon.vertices().contains(&point) || edges(polygon.vertices()).any(|[a, b]| is_between(a, point, b))
}

fn is_between(a: DVec3, point: DVec3, b: DVec3) -> bool {
    let (low, high) = (a.min(b), a.max(b));
    low.cmple(point).all() && point.cmple(high).all() && EdgeName::new(a, b).is_in_line_with(point)
}

/// Whether the receiver surely sees the vertices of a convex part in convex order: it is on one side of the planes through each
/// three in a row, the one on which the occluder's plane has it.
pub(super) fn is_seen_convex(x: DVec3, occluder: &Polygon, part: &[DVec3], plan: &Plan) -> bool {
    let way = match side_of(x, occluder, plan.power) {
        Side::Front => 1.0,
        Side::Back => -1.0,
        Side::InPlane => return false,
    };
    let next = |i: usize| part[i % part.len()];
    (0..part.len()).all(|i| -orientation([next(i), next(i + 1), next(i + 2), x]) * way >= 0.0)
}

fn edges(vertices: &[DVec3]) -> impl Iterator<Item = [DVec3; 2]> {
    vertices.iter().zip(vertices.iter().cycle().skip(1)).map(|(a, b)| [*a, *b])
}

impl Doubt {
    /// The doubt about a convex part of an occluder, if there is any.
    pub(super) fn of_part(
        receiver: &Receiver,
        emitter: &Polygon,
        occluder: &Polygon,
        part: &[DVec3],
        plan: &Plan,
    ) -> Option<Self> {
        if emitter.half_slab() == 0.0 && occluder.half_slab() == 0.0 {
            return None;
        }
        let x = receiver.position();
        let vertices: Vec<DVec3> = part.iter().map(|&v| (v - x) * plan.power).collect();
        let slab = occluder.half_slab() * plan.power;
        let (normal, offset) = (occluder.normal(), occluder.normal().dot(vertices[0]));
        let normal = if offset < 0.0 { -normal } else { normal };
        let reach = vertices.iter().map(|v| length(*v)).fold(0.0, largest);
        let off_plane = offset.abs() - slab - 16.0 * ROUNDOFF * reach;
        let slack = emitter.half_slab() * plan.power + if slab > 0.0 { slab * reach / off_plane } else { 0.0 };
        let slack = if slab > 0.0 && off_plane <= 0.0 { f64::INFINITY } else { slack * 1.01 };
        let is_edge_on = slab > 0.0 && !is_seen_convex(x, occluder, part, plan);
        let doubt = Self { vertices, plane: (normal, offset.abs()), slack, slab, is_edge_on };
        (!doubt.is_sure(emitter, part, plan) && !doubt.is_beyond_an_edge(x, emitter, part, plan)).then_some(doubt)
    }

    /// Whether the occluder may be seen edge-on, so that nothing is known of the order of its vertices.
    pub(super) const fn is_edge_on(&self) -> bool {
        self.is_edge_on
    }

    /// Whether all of it is surely in front of every surface of the emitter, or behind, but for vertices and edges that the two
    /// outlines share.
    fn is_sure(&self, emitter: &Polygon, part: &[DVec3], plan: &Plan) -> bool {
        if self.is_edge_on {
            return false;
        }
        // Surfaces of the occluder are in the hull of its vertices.
        let slab = emitter.half_slab() * plan.power * 1.01;
        let side = |v: &DVec3| sure_side(*v, emitter, plan.power, slab);
        let (open, known): (Vec<DVec3>, Vec<DVec3>) = part.iter().partition(|v| side(v).is_none());
        let is_one_side = |way: Side| known.iter().all(|v| side(v) == Some(way));
        if known.is_empty() || !(is_one_side(Side::Front) || is_one_side(Side::Back)) {
            return false;
        }
        // A flat emitter's plane leaves a corner in it no choice.
        if open.is_empty()
            || (emitter.half_slab() == 0.0 && open.iter().all(|&v| side_of(v, emitter, plan.power) == Side::InPlane))
        {
            return true;
        }
        let (origin, normal) = (emitter.vertices()[0], emitter.normal());
        let height = |v: &DVec3| normal.dot((*v - origin) * plan.power).abs();
        let least = known.iter().map(height).fold(f64::INFINITY, smallest) - self.slack;
        let extent = self.vertices.iter().map(|v| length(*v - self.vertices[0])).fold(0.0, largest);
        let is_steep = least * least_altitude(emitter, plan.power) > 8.0 * self.slack * extent + f64::MIN_POSITIVE;
        let is_shared = || match open[..] {
            [one] => is_on_outline(one, emitter),
            _ => edges(emitter.vertices()).any(|[a, b]| open.iter().all(|&v| v == a || v == b || is_between(a, v, b))),
        };
        is_steep && is_shared()
    }

    /// Whether a plane through the receiver and an edge of the emitter has the emitter on one side and the occluder on the other.
    fn is_beyond_an_edge(&self, x: DVec3, emitter: &Polygon, part: &[DVec3], plan: &Plan) -> bool {
        edges(emitter.vertices()).any(|[a, b]| {
            let [u, v] = [a, b].map(|p| (p - x) * plan.power);
            let (normal, name) = (u.cross(v), EdgeName::new(a, b));
            let side = |p: DVec3| {
                let r = (p - x) * plan.power;
                let height = normal.dot(r);
                let unsure = 16.0 * ROUNDOFF * length(u) * length(v) * length(r) + f64::MIN_POSITIVE;
                if height.abs() > unsure { height.partial_cmp(&0.0) } else { name.is_in_line_with(p).then_some(Ordering::Equal) }
            };
            // Counter-clockwise as the receiver sees it, the emitter is where the normal's heights are negative.
            emitter.vertices().iter().all(|&p| side(p).is_some_and(Ordering::is_le))
                && part.iter().all(|&p| side(p).is_some_and(Ordering::is_ge))
        })
    }

    /// Distance of the occluder, from below.
    fn nearest(&self) -> f64 {
        let nearest = self.vertices.iter().map(|v| length(*v)).fold(f64::INFINITY, smallest);
        let perimeter: f64 = edges(&self.vertices).map(|[u, v]| length(v - u)).sum();
        (nearest - 0.5 * perimeter).max(0.0)
    }

    /// Bounds for a unit of emission on the irradiance through D, and on its gradient with D's boundary moving; `None` where D is
    /// empty.
    pub(super) fn bounds<T: Real>(&self, part: &VisiblePart<T>, sides: &Sides<T>, height: f64) -> Option<[f64; 2]> {
        let Region { area, perimeter, distance, turning } = self.region(part, sides, height)?;
        let irradiance = (area / (distance * distance)).min(std::f64::consts::TAU);
        let share = self.slack / height;
        let own = if share < MOST_SHARE && !self.is_edge_on { 2.0 * share / distance } else { 1.0 / self.nearest() };
        let moving = 6.0 * area / (distance * distance * distance) + (perimeter * own + turning) / distance;
        Some([irradiance, moving].map(|bound| bound * 1.01))
    }

    /// D.
    fn region<T: Real>(&self, part: &VisiblePart<T>, sides: &Sides<T>, height: f64) -> Option<Region> {
        let own = part.corners.iter().map(|corner| {
            let near = match sides.unturned(corner.side) {
                line @ Generator::Occluder(_) => nearness(line).to_double(),
                Generator::Emitter(_) | Generator::Horizon(_) => 0.0,
            };
            (corner.point.map(T::value).into(), near)
        });
        let error = |point: Vec3<T>| point.x.value_error() + point.y.value_error() + point.z.value_error();
        let unknown = part.corners.iter().map(|corner| error(corner.point)).fold(0.0, largest);
        let mut region: Vec<Bordered> = own.collect();
        let reach = region.iter().map(|(p, _)| p.length()).fold(0.0, largest);
        let unknown = unknown + 8.0 * ROUNDOFF * reach;
        for (normal, offset, moved) in self.half_spaces(reach, height) {
            let margin = 2.0 * (moved + normal.length() * unknown);
            region = cut(&region, |p| normal.dot(p) - offset + margin);
        }
        let first = region.first()?.0;
        let side = |i: usize| region[(i + 1) % region.len()].0 - region[i].0;
        let perimeter: f64 = (0..region.len()).map(|i| side(i).length()).sum();
        let twice: DVec3 = (1..region.len()).map(|i| (region[i].0 - first).cross(side(i))).sum();
        let turning = (0..region.len()).map(|i| side(i).length() * region[i].1).filter(|turning| *turning != 0.0).sum();
        let nearest = region.iter().map(|(p, _)| p.length()).fold(f64::INFINITY, smallest);
        Some(Region {
            area: 0.5 * twice.length() + 2.0 * (perimeter + unknown) * unknown,
            perimeter: perimeter + 8.0 * unknown,
            distance: (nearest - 0.5 * perimeter - unknown).max(height),
            turning,
        })
    }

    /// The least cosine between a direction and a vertex, for that direction in the occluder's plane across an edge of which it is
    /// largest, from below. Above 0 the hull of the vertices is on one side of the receiver.
    fn narrowness(&self, vertices: &[DVec3]) -> f64 {
        let across = edges(vertices).filter_map(|[u, v]| (v - u).cross(self.plane.0).try_normalize());
        let least = |way: DVec3| vertices.iter().map(|v| way.dot(*v) / length(*v)).fold(1.0, smallest);
        across.flat_map(|way| [least(way), least(-way)]).fold(0.0, f64::max) * (1.0 - 1e-12) - 16.0 * ROUNDOFF
    }

    /// Half-spaces `N.p >= offset`, each with the error of N.p at distances up to `reach`, that hold the rays through D.
    fn half_spaces(&self, reach: f64, height: f64) -> Vec<(DVec3, f64, f64)> {
        let farthest = self.vertices.iter().map(|v| length(*v)).fold(0.0, largest);
        // The sides are those of a cone, whatever its size.
        let vertices: Vec<DVec3> = self.vertices.iter().map(|v| *v * normalising_power(farthest)).collect();
        let narrowness = if self.is_edge_on { self.narrowness(&vertices) } else { 1.0 };
        if narrowness <= 0.0 || narrowness.is_nan() {
            // It may surround the receiver.
            return Vec::new();
        }
        let middle: DVec3 = vertices.iter().sum();
        let mut half_spaces: Vec<(DVec3, f64, f64)> = Vec::with_capacity(vertices.len() + 2);
        for [u, v] in edges(&vertices) {
            let (inward, lengths) = (u.cross(v), length(u) * length(v));
            let inward = if inward.dot(middle) < 0.0 { -inward } else { inward };
            let outside = |w: &DVec3| -inward.dot(*w) / length(*w);
            let rounding = 16.0 * ROUNDOFF * lengths + f64::MIN_POSITIVE;
            // Of a sum of vertices at least this share of their lengths is left.
            let outside = vertices.iter().map(outside).fold(0.0, largest) / narrowness;
            half_spaces.push((inward, 0.0, (outside + rounding) * reach));
        }
        let ((normal, offset), share) = (self.plane, self.slack / height);
        let rounding = 16.0 * ROUNDOFF * (reach + offset);
        if share < MOST_SHARE && !self.is_edge_on {
            half_spaces.push((normal, offset / (1.0 + share), rounding));
            half_spaces.push((-normal, -offset / (1.0 - share), rounding));
        } else if self.is_edge_on {
            let nearest = self.nearest();
            if nearest > 0.0 {
                let aside = 1.5 * (offset + self.slab + 16.0 * ROUNDOFF * farthest) * reach / nearest;
                half_spaces.extend([(normal, -aside, rounding), (-normal, -aside, rounding)]);
            }
        }
        half_spaces
    }
}

/// The part of a convex polygon where `height` is not negative.
fn cut(region: &[Bordered], height: impl Fn(DVec3) -> f64) -> Vec<Bordered> {
    let heights: Vec<f64> = region.iter().map(|(p, _)| height(*p)).collect();
    let mut clipped = Vec::with_capacity(region.len() + 1);
    for (i, &(start, near)) in region.iter().enumerate() {
        let j = (i + 1) % region.len();
        let between = || start + (region[j].0 - start) * (heights[i] / (heights[i] - heights[j]));
        // A NaN height counts as inside.
        match (heights[i] < 0.0, heights[j] < 0.0) {
            (false, false) => clipped.push((start, near)),
            (false, true) => clipped.extend([(start, near), (between(), 0.0)]),
            (true, false) => clipped.push((between(), near)),
            (true, true) => {}
        }
    }
    clipped
}

/// The least altitude of the triangles that vertices of a polygon form, normalised, from below; 0 where there are too many to look
/// at.
fn least_altitude(polygon: &Polygon, power: f64) -> f64 {
    const MOST: usize = 8;
    let vertices = polygon.vertices();
    if vertices.len() > MOST {
        return 0.0;
    }
    let points = || vertices.iter().copied();
    let altitudes =
        points().flat_map(|a| points().flat_map(move |b| points().map(move |c| [a, b, c]))).filter_map(|[a, b, c]| {
            let is_triangle = a != b && b != c && c != a;
            let [b, c] = [b, c].map(|p| (p - a) * power);
            is_triangle.then(|| b.cross(c).length() / b.length())
        });
    let least = altitudes.fold(f64::INFINITY, smallest) - 64.0 * f64::EPSILON * polygon.size() * power;
    if least < 0.0 { 0.0 } else { least }
}

/// The length of a vector whose square may leave the range of doubles.
fn length(v: DVec3) -> f64 {
    Vec3::from(v).length()
}

/// The larger of two lengths; NaN if either is.
pub(crate) fn largest(a: f64, b: f64) -> f64 {
    if b > a || b.is_nan() { b } else { a }
}

/// The smaller of two lengths, likewise.
fn smallest(a: f64, b: f64) -> f64 {
    if b < a || b.is_nan() { b } else { a }
}
