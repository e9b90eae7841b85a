//! The part of the emitter the receiver sees, cut into pieces an integrand of section-8 type is smooth on.
//!
//! Everything is relative to the receiver and scaled by a power of two, both exactly. Each triangle is clipped at the horizon
//! by the exact signs of `n1.r` at its vertices; the rest is a convex polygon with three or four corners. Its point nearest to the
//! receiver, the apex, is chosen in double precision and from then on exact; the polygon is the signed sum of [`Fan`]s `q + s (a +
//! t b)`, 0 <= s, t <= 1, each from the apex to a stretch of boundary that starts nearest to the apex and leads away from it. Where
//! the apex or such a start lies matters for the cost, never for the truth.

use glam::DVec3;
use radgrad_core::Polygon;

use crate::enclosure::arithmetic::Real;
use crate::enclosure::ball::{Ball, BallVector, vector};
use crate::enclosure::exact::{Exact, ExactVector, along, cross, difference, dot};
use crate::enclosure::outline::{Place, Point, Stretch};
use crate::enclosure::source::origin;
use crate::enclosure::triangulation::triangles;

/// A triangle of the emitter that faces the receiver and reaches above its horizon.
#[derive(Debug)]
pub(crate) struct Triangle {
    /// Indices of its vertices.
    pub(crate) corners: [usize; 3],
    /// `N = e1 x e2`, not normalised.
    pub(crate) normal: ExactVector,
    /// `H = -N.r`, the height of the receiver over its plane times `|N|`.
    pub(crate) height: Exact,
}

/// A polygon with its vertices exact, wherever they have been moved.
pub(crate) struct Body<'a> {
    /// The polygon as given, which is triangulated.
    pub(crate) polygon: &'a Polygon,
    /// In the coordinates of the world.
    pub(crate) vertices: Vec<ExactVector>,
}

impl<'a> Body<'a> {
    /// Each vertex displaced by `parameter` times its rate, those without a rate not at all.
    pub(crate) fn new(polygon: &'a Polygon, rates: &[DVec3], parameter: f64) -> Self {
        let rates = rates.iter().copied().chain(std::iter::repeat(DVec3::ZERO));
        let vertices = polygon.vertices().iter().zip(rates).map(|(vertex, rate)| displaced(*vertex, rate, parameter)).collect();
        Self { polygon, vertices }
    }
}

/// `place + parameter rate`.
pub(crate) fn displaced(place: DVec3, rate: DVec3, parameter: f64) -> ExactVector {
    along(&place.to_array().map(Exact::from), parameter, &rate.to_array().map(Exact::from))
}

/// The emitter as seen from the receiver, exact.
#[derive(Debug)]
pub(crate) struct Frame {
    /// Coordinates are those of the world times `2^scale`.
    pub(crate) scale: i32,
    /// The world's origin.
    pub(crate) origin: ExactVector,
    /// `r_i`.
    pub(crate) vertices: Vec<ExactVector>,
    /// `n1.r_i`, with the normal as given but for a power of two.
    pub(crate) heights: Vec<Exact>,
    /// The receiver's normal.
    pub(crate) normal: ExactVector,
    /// Square of its length.
    pub(crate) normal_squared: Exact,
    /// Triangles that reach above the horizon and turn their lit side to the receiver.
    pub(crate) triangles: Vec<Triangle>,
}

impl Frame {
    /// From a position, with a normal of any length.
    pub(crate) fn new(position: DVec3, given: &ExactVector, emitter: &Body<'_>) -> Self {
        let exact = position.to_array().map(Exact::from);
        let raw: Vec<ExactVector> = emitter.vertices.iter().map(|vertex| difference(vertex, &exact)).collect();
        let scale = -raw.iter().flatten().filter(|c| !c.is_zero()).map(Exact::exponent).max().unwrap_or(0);
        let vertices: Vec<ExactVector> = raw.iter().map(|r| std::array::from_fn(|i| r[i].times_power(scale))).collect();
        let largest = given.iter().filter(|c| !c.is_zero()).map(Exact::exponent).max().unwrap_or(0);
        let normal: ExactVector = std::array::from_fn(|i| given[i].times_power(-largest));
        let heights: Vec<Exact> = vertices.iter().map(|r| dot(&normal, r)).collect();
        let triangles = triangles(emitter.polygon)
            .into_iter()
            .filter(|corners| corners.iter().any(|i| heights[*i].sign() > 0))
            .map(|corners| {
                let [r0, r1, r2] = corners.map(|i| &vertices[i]);
                let normal = cross(&difference(r1, r0), &difference(r2, r0));
                let height = -&dot(&normal, r0);
                Triangle { corners, normal, height }
            })
            .filter(|triangle| triangle.height.sign() > 0)
            .collect();
        let normal_squared = dot(&normal, &normal);
        Self { scale, origin: origin(position, scale), vertices, heights, normal, normal_squared, triangles }
    }

    /// A point of the world in the receiver's coordinates.
    pub(crate) fn relative(&self, point: &ExactVector) -> ExactVector {
        std::array::from_fn(|i| &point[i].times_power(self.scale) + &self.origin[i])
    }

    /// Directed edges of the seen triangles that no two of them share.
    pub(crate) fn boundary(&self) -> Vec<[usize; 2]> {
        let edges: Vec<[usize; 2]> =
            self.triangles.iter().flat_map(|t| (0..3).map(|m| [t.corners[m], t.corners[(m + 1) % 3]])).collect();
        edges.iter().copied().filter(|[i, j]| !edges.contains(&[*j, *i])).collect()
    }
}

/// How the area element depends on s.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Jacobian {
    /// A line, not an area.
    One,
    /// `s`: the rays leave the apex.
    Rising,
    /// `1 - s`: the rays end in one point.
    Falling,
}

/// The points `p + t u + s (c + t v)`, 0 <= s, t <= 1.
#[derive(Debug)]
pub(crate) struct Fan<T> {
    /// `p`.
    pub(crate) apex: BallVector<T>,
    /// `c`.
    pub(crate) start: BallVector<T>,
    /// `v`.
    pub(crate) way: BallVector<T>,
    /// `u`; none where the rays leave one point.
    pub(crate) shift: Option<BallVector<T>>,
    /// `n1.r` is `heights[0] + t heights[3] + s (heights[1] + t heights[2])`.
    pub(crate) heights: [Ball<T>; 4],
    pub(crate) jacobian: Jacobian,
    /// The area element without its dependence on s, times `|N|`; negative where the boundary is followed backward.
    pub(crate) measure: Ball<T>,
    /// Doubles next to `p`, `c`, `v`, `u`.
    pub(crate) near: [[f64; 3]; 4],
}

/// The outline of a triangle's part above the horizon.
pub(crate) fn outline(frame: &Frame, triangle: &Triangle) -> Vec<Stretch> {
    let mut outline: Vec<Stretch> = Vec::with_capacity(4);
    for m in 0..3 {
        let edge = [triangle.corners[m], triangle.corners[(m + 1) % 3]];
        if let Some(stretch) = Stretch::of_edge(frame, edge) {
            if let Some(last) = outline.last()
                && last.ends[1].is_level()
                && stretch.ends[0].is_level()
            {
                let ends = [last.ends[1].clone(), stretch.ends[0].clone()];
                outline.push(Stretch::between(ends));
            }
            outline.push(stretch);
        }
    }
    if let (Some(first), Some(last)) = (outline.first(), outline.last())
        && first.ends[0].is_level()
        && last.ends[1].is_level()
    {
        let ends = [last.ends[1].clone(), first.ends[0].clone()];
        outline.push(Stretch::between(ends));
    }
    outline
}

/// The fans of a convex part of a triangle, by its outline.
pub(crate) fn fans<T: Real>(frame: &Frame, triangle: &Triangle, outline: &[Stretch], bits: usize) -> Vec<Fan<T>> {
    let (apex, touched) = apex(frame, triangle, outline);
    let normal: BallVector<T> = vector(&triangle.normal, bits);
    let mut fans = Vec::with_capacity(8);
    for (index, stretch) in outline.iter().enumerate() {
        // From a point on an edge that edge spans nothing.
        if touched.contains(&Some(index)) {
            continue;
        }
        let (foot, place) = stretch.nearest(frame, apex.near);
        if place != Place::End {
            push_fans(&mut fans, [&apex, &foot, &stretch.ends[1]], true, &normal, bits);
        }
        if place != Place::Start {
            push_fans(&mut fans, [&apex, &foot, &stretch.ends[0]], false, &normal, bits);
        }
    }
    fans
}

/// Boundary longer than this times its distance from the apex is cut off.
const LONG: f64 = 8.0;
/// Where it is cut, in the same unit.
const CUT: f64 = 3.0;

/// The triangle from the apex to a stretch that starts at its foot. A thin one, cut into cells along its rays, would need a
/// number of cells that grows as the square of the logarithm of its thinness; so the part beyond a few of its widths is a strip
/// with rays along the stretch.
fn push_fans<T: Real>(
    fans: &mut Vec<Fan<T>>,
    [apex, foot, end]: [&Point; 3],
    forward: bool,
    normal: &BallVector<T>,
    bits: usize,
) {
    let (width, length) = (minus(foot.near, apex.near), minus(end.near, foot.near));
    let thinness = (dot64(width, width) / dot64(length, length)).sqrt();
    if !(thinness > 0.0 && thinness * LONG < 1.0) {
        fans.push(fan(apex, foot, end, forward, normal, bits));
        return;
    }
    let place = CUT * thinness;
    let (on_edge, inside) = (Point::between(foot, place, end), Point::between(apex, place, end));
    fans.push(fan(apex, foot, &on_edge, forward, normal, bits));
    fans.push(fan(apex, &on_edge, &inside, forward, normal, bits));
    fans.push(strip(&on_edge, &inside, end, forward, normal, bits));
}

fn fan<T: Real>(apex: &Point, foot: &Point, end: &Point, forward: bool, normal: &BallVector<T>, bits: usize) -> Fan<T> {
    let (start, way) = (foot.from(apex, bits), end.from(foot, bits));
    let measure = triple(&start, &way, normal);
    let level: Ball<T> = apex.height(bits);
    let none = level.zero();
    let near = [apex.near, nearby(&start), nearby(&way), [0.0; 3]];
    Fan {
        apex: apex.position(bits),
        start,
        way,
        shift: None,
        heights: [level, foot.climb(apex, bits), end.climb(foot, bits), none],
        jacobian: Jacobian::Rising,
        measure: if forward { measure } else { -&measure },
        near,
    }
}

/// The triangle of rays from the side `low high` to the point `end`.
fn strip<T: Real>(low: &Point, high: &Point, end: &Point, forward: bool, normal: &BallVector<T>, bits: usize) -> Fan<T> {
    let (start, shift) = (end.from(low, bits), high.from(low, bits));
    let way = shift.each_ref().map(|u| -u);
    let measure = triple(&start, &shift, normal);
    let climb = high.climb(low, bits);
    let heights = [low.height(bits), end.climb(low, bits), -&climb, climb];
    let near = [low.near, nearby(&start), nearby(&way), nearby(&shift)];
    Fan {
        apex: low.position(bits),
        start,
        way,
        shift: Some(shift),
        heights,
        jacobian: Jacobian::Falling,
        measure: if forward { measure } else { -&measure },
        near,
    }
}

fn nearby<T: Real>(v: &BallVector<T>) -> [f64; 3] {
    [0, 1, 2].map(|i| v[i].leading())
}

/// `(a x b).n`.
fn triple<T: Real>(a: &BallVector<T>, b: &BallVector<T>, n: &BallVector<T>) -> Ball<T> {
    let spanned: BallVector<T> = std::array::from_fn(|i| {
        let (j, k) = ((i + 1) % 3, (i + 2) % 3);
        &(&a[j] * &b[k]) - &(&a[k] * &b[j])
    });
    crate::enclosure::ball::dot(&spanned, n)
}

/// The point nearest to the receiver, and the one or two stretches it is an end of or on.
fn apex(frame: &Frame, triangle: &Triangle, outline: &[Stretch]) -> (Point, [Option<usize>; 2]) {
    let normal = [0, 1, 2].map(|i| triangle.normal[i].leading());
    let foot = {
        let r0 = outline[0].ends[0].near;
        let share = dot64(normal, r0) / dot64(normal, normal);
        normal.map(|n| n * share)
    };
    let outside = |stretch: &Stretch| {
        let [start, end] = stretch.ends.each_ref().map(|p| p.near);
        dot64(cross64(minus(end, start), minus(foot, start)), normal) <= 0.0
    };
    if !outline.iter().any(outside) {
        return (interior(frame, triangle, foot), [None, None]);
    }
    let mut best: Option<(f64, Point, Place, usize)> = None;
    for (index, stretch) in outline.iter().enumerate() {
        let (point, place) = stretch.nearest(frame, [0.0; 3]);
        let distance = dot64(point.near, point.near);
        if best.as_ref().is_none_or(|(least, ..)| distance < *least) {
            best = Some((distance, point, place, index));
        }
    }
    let Some((_, point, place, index)) = best else { return (interior(frame, triangle, foot), [None, None]) };
    let count = outline.len();
    let neighbour = match place {
        Place::Start => Some((index + count - 1) % count),
        Place::Within => None,
        Place::End => Some((index + 1) % count),
    };
    (point, [Some(index), neighbour])
}

/// A point of the triangle's plane next to `target`, exact: `r_0 + l e1 + m e2` with doubles l, m. The longest edge is e2: the
/// error of l then moves the point along the shortest way, and m corrects its part along e2.
fn interior(frame: &Frame, triangle: &Triangle, target: [f64; 3]) -> Point {
    let near = triangle.corners.map(|i| [0, 1, 2].map(|axis| frame.vertices[i][axis].leading()));
    let length = |m: usize| {
        let e = minus(near[(m + 1) % 3], near[m]);
        dot64(e, e)
    };
    let longest = (0..3).fold(0, |best, m| if length(m) > length(best) { m } else { best });
    let [base, second, first] = [longest, (longest + 1) % 3, (longest + 2) % 3];
    let (e1, e2) = (minus(near[first], near[base]), minus(near[second], near[base]));
    let (normal, way) = (cross64(e1, e2), minus(target, near[base]));
    let l = dot64(cross64(way, e2), normal) / dot64(normal, normal);
    let residual = [0, 1, 2].map(|i| way[i] - l * e1[i]);
    let m = dot64(residual, e2) / dot64(e2, e2);
    let corner = |place: usize| (&frame.vertices[triangle.corners[place]], &frame.heights[triangle.corners[place]]);
    let ((r0, h0), (r1, h1), (r2, h2)) = (corner(base), corner(first), corner(second));
    let position = along(&along(r0, l, &difference(r1, r0)), m, &difference(r2, r0));
    let height = &(h0 + &(&Exact::from(l) * &(h1 - h0))) + &(&Exact::from(m) * &(h2 - h0));
    Point::exact(position, height)
}

pub(crate) fn dot64(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

pub(crate) fn minus(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

fn cross64(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}
