//! The part of the emitter the receiver sees, cut into pieces an integrand of section-8 type is smooth on.
//!
//! Everything is relative to the receiver and scaled by a power of two, both exactly. Each triangle is clipped at the horizon by the
//! exact signs of `n1.r` at its vertices; what is left is a convex polygon with three or four corners. Its point nearest to the
//! receiver, the apex, is chosen in double precision and from then on exact; the polygon is the signed sum of [`Fan`]s
//! `q + s (a + t b)`, 0 <= s, t <= 1, each from the apex to a stretch of boundary that starts nearest to the apex and leads away from it.
//! Where the apex or such a start lies matters for the cost, never for the truth.

use radgrad_core::{Polygon, Receiver};

use crate::arithmetic::Real;
use crate::ball::{Ball, BallVector, vector};
use crate::exact::{Exact, ExactVector, along, cross, difference, dot};
use crate::source::origin;
use crate::triangulation::triangles;

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
    /// Square of the length of that normal.
    pub(crate) normal_squared: Exact,
    /// What is seen.
    pub(crate) triangles: Vec<Triangle>,
}

impl Frame {
    pub(crate) fn new(receiver: &Receiver, polygon: &Polygon) -> Self {
        let position = receiver.position().to_array().map(Exact::from);
        let raw: Vec<ExactVector> =
            polygon.vertices().iter().map(|v| difference(&v.to_array().map(Exact::from), &position)).collect();
        let scale = -raw.iter().flatten().filter(|c| !c.is_zero()).map(Exact::exponent).max().unwrap_or(0);
        let vertices: Vec<ExactVector> = raw.iter().map(|r| std::array::from_fn(|i| r[i].times_power(scale))).collect();
        let normal = receiver.direction().to_array().map(Exact::from);
        let heights: Vec<Exact> = vertices.iter().map(|r| dot(&normal, r)).collect();
        let triangles = triangles(polygon)
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
        Self { scale, origin: origin(receiver.position(), scale), vertices, heights, normal_squared, triangles }
    }

    /// Directed edges of the seen triangles that no two of them share.
    pub(crate) fn boundary(&self) -> Vec<[usize; 2]> {
        let edges: Vec<[usize; 2]> =
            self.triangles.iter().flat_map(|t| (0..3).map(|m| [t.corners[m], t.corners[(m + 1) % 3]])).collect();
        edges.iter().copied().filter(|[i, j]| !edges.contains(&[*j, *i])).collect()
    }
}

/// A point of a triangle's plane.
#[derive(Debug, Clone)]
pub(crate) struct Point<T> {
    exact: ExactVector,
    /// What rounding leaves to a ball: the way from `exact` to a point of the horizon.
    offset: Option<BallVector<T>>,
    /// `n1.r`, exact everywhere since it is 0 on the horizon.
    pub(crate) height: Exact,
    /// The position in double precision.
    pub(crate) near: [f64; 3],
}

impl<T: Real> Point<T> {
    fn exact(exact: ExactVector, height: Exact) -> Self {
        let near = [0, 1, 2].map(|i| exact[i].leading());
        Self { exact, offset: None, height, near }
    }

    fn on_horizon(exact: ExactVector, offset: BallVector<T>) -> Self {
        let near = [0, 1, 2].map(|i| exact[i].leading() + offset[i].leading());
        Self { exact, offset: Some(offset), height: Exact::zero(), near }
    }

    /// The position.
    pub(crate) fn position(&self, bits: usize) -> BallVector<T> {
        let exact = vector(&self.exact, bits);
        match &self.offset {
            None => exact,
            Some(offset) => std::array::from_fn(|i| &exact[i] + &offset[i]),
        }
    }

    /// The way from `start` here; no digits are lost where the exact parts cancel.
    pub(crate) fn from(&self, start: &Self, bits: usize) -> BallVector<T> {
        let exact = vector(&difference(&self.exact, &start.exact), bits);
        std::array::from_fn(|i| match (&self.offset, &start.offset) {
            (None, None) => exact[i].clone(),
            (Some(end), None) => &exact[i] + &end[i],
            (None, Some(start)) => &exact[i] - &start[i],
            (Some(end), Some(start)) => &exact[i] + &(&end[i] - &start[i]),
        })
    }
}

/// Where a point of a stretch is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Place {
    Start,
    Within,
    End,
}

/// A stretch of an emitter's edge, above the horizon.
#[derive(Debug)]
pub(crate) struct Stretch<T> {
    pub(crate) ends: [Point<T>; 2],
    /// The edge, by its vertices, and where along it the ends are; none on the horizon.
    edge: Option<([usize; 2], [f64; 2])>,
}

impl<T: Real> Stretch<T> {
    /// The part of edge `i j` above the horizon.
    pub(crate) fn of_edge(frame: &Frame, [i, j]: [usize; 2], bits: usize) -> Option<Self> {
        let (start, end) = (&frame.heights[i], &frame.heights[j]);
        if start.sign() <= 0 && end.sign() <= 0 {
            return None;
        }
        let vertex = |k: usize| Point::exact(frame.vertices[k].clone(), frame.heights[k].clone());
        let cut = || crossing(frame, [i, j], bits);
        let (ends, range) = if start.sign() < 0 {
            let (point, place) = cut();
            ([point, vertex(j)], [place, 1.0])
        } else if end.sign() < 0 {
            let (point, place) = cut();
            ([vertex(i), point], [0.0, place])
        } else {
            ([vertex(i), vertex(j)], [0.0, 1.0])
        };
        Some(Self { ends, edge: Some(([i, j], range)) })
    }

    /// The point of the stretch nearest to `target`, about: an end, or a point with an exact place along it.
    pub(crate) fn nearest(&self, frame: &Frame, target: [f64; 3], bits: usize) -> (Point<T>, Place) {
        let [start, end] = &self.ends;
        let way = minus(end.near, start.near);
        let fraction = dot64(minus(target, start.near), way) / dot64(way, way);
        if fraction >= 1.0 {
            return (end.clone(), Place::End);
        }
        // Not a number where the ends coincide: then either is nearest.
        if fraction.is_nan() || fraction <= 0.0 {
            return (start.clone(), Place::Start);
        }
        let Some(([i, j], [from, to])) = self.edge else {
            let fraction = Ball::from_f64(fraction, bits);
            let way = end.from(start, bits);
            let offset = std::array::from_fn(|k| {
                let step = &fraction * &way[k];
                start.offset.as_ref().map_or_else(|| step.clone(), |offset| &offset[k] + &step)
            });
            return (Point::on_horizon(start.exact.clone(), offset), Place::Within);
        };
        // Measured from the nearer vertex, so that a place next to it keeps its digits.
        let place = (from + fraction * (to - from)).clamp(0.0, 1.0);
        let (base, other, place) = if place <= 0.5 { (i, j, place) } else { (j, i, (1.0 - to) + (1.0 - fraction) * (to - from)) };
        let edge = difference(&frame.vertices[other], &frame.vertices[base]);
        let rise = &frame.heights[other] - &frame.heights[base];
        let height = &frame.heights[base] + &(&Exact::from(place) * &rise);
        (Point::exact(along(&frame.vertices[base], place, &edge), height), Place::Within)
    }
}

/// Where edge `i j` crosses the horizon, and about how far along it.
fn crossing<T: Real>(frame: &Frame, [i, j]: [usize; 2], bits: usize) -> (Point<T>, f64) {
    let near_start = (&abs(&frame.heights[i]) - &abs(&frame.heights[j])).sign() <= 0;
    let (base, other) = if near_start { (i, j) } else { (j, i) };
    let fall = Ball::from_exact(&(&frame.heights[base] - &frame.heights[other]), bits);
    let place = Ball::<T>::from_exact(&frame.heights[base], bits).divided_by(&fall);
    let edge: BallVector<T> = vector(&difference(&frame.vertices[other], &frame.vertices[base]), bits);
    let about = place.leading();
    let offset = edge.map(|e| &place * &e);
    (Point::on_horizon(frame.vertices[base].clone(), offset), if near_start { about } else { 1.0 - about })
}

fn abs(value: &Exact) -> Exact {
    if value.sign() < 0 { -value } else { value.clone() }
}

/// The points `q + s (a + t b)`, 0 <= s, t <= 1.
#[derive(Debug)]
pub(crate) struct Fan<T> {
    /// `q` and `n1.q`.
    pub(crate) apex: BallVector<T>,
    /// `a`, from the apex to the start of the boundary.
    pub(crate) start: BallVector<T>,
    /// `b`, along the boundary.
    pub(crate) way: BallVector<T>,
    /// `n1.r` is `heights[0] + s (heights[1] + t heights[2])`.
    pub(crate) heights: [Ball<T>; 3],
    /// `+-(a x b).N`, negative where the boundary is followed backward.
    pub(crate) measure: Ball<T>,
    /// Doubles next to `q`, `a`, `b`.
    pub(crate) near: [[f64; 3]; 3],
}

/// The fans of a triangle's visible part.
pub(crate) fn fans<T: Real>(frame: &Frame, triangle: &Triangle, bits: usize) -> Vec<Fan<T>> {
    let mut outline: Vec<Stretch<T>> = Vec::with_capacity(4);
    for m in 0..3 {
        let edge = [triangle.corners[m], triangle.corners[(m + 1) % 3]];
        if let Some(stretch) = Stretch::of_edge(frame, edge, bits) {
            if let Some(last) = outline.last()
                && last.ends[1].height.is_zero()
                && stretch.ends[0].height.is_zero()
            {
                let ends = [last.ends[1].clone(), stretch.ends[0].clone()];
                outline.push(Stretch { ends, edge: None });
            }
            outline.push(stretch);
        }
    }
    if let (Some(first), Some(last)) = (outline.first(), outline.last())
        && first.ends[0].height.is_zero()
        && last.ends[1].height.is_zero()
    {
        let ends = [last.ends[1].clone(), first.ends[0].clone()];
        outline.push(Stretch { ends, edge: None });
    }
    let (apex, touched) = apex(frame, triangle, &outline, bits);
    let normal: BallVector<T> = vector(&triangle.normal, bits);
    let mut fans = Vec::with_capacity(8);
    for (index, stretch) in outline.iter().enumerate() {
        // From a point on an edge that edge spans nothing.
        if touched.contains(&Some(index)) {
            continue;
        }
        let (foot, place) = stretch.nearest(frame, apex.near, bits);
        if place != Place::End {
            fans.push(fan(&apex, &foot, &stretch.ends[1], true, &normal, bits));
        }
        if place != Place::Start {
            fans.push(fan(&apex, &foot, &stretch.ends[0], false, &normal, bits));
        }
    }
    fans
}

fn fan<T: Real>(apex: &Point<T>, foot: &Point<T>, end: &Point<T>, forward: bool, normal: &BallVector<T>, bits: usize) -> Fan<T> {
    let (start, way) = (foot.from(apex, bits), end.from(foot, bits));
    let spanned: BallVector<T> = std::array::from_fn(|i| {
        let (j, k) = ((i + 1) % 3, (i + 2) % 3);
        &(&start[j] * &way[k]) - &(&start[k] * &way[j])
    });
    let measure = crate::ball::dot(&spanned, normal);
    let heights = [apex.height.clone(), &foot.height - &apex.height, &end.height - &foot.height];
    let near = [apex.near, [0, 1, 2].map(|i| start[i].leading()), [0, 1, 2].map(|i| way[i].leading())];
    Fan {
        apex: apex.position(bits),
        start,
        way,
        heights: heights.map(|h| Ball::from_exact(&h, bits)),
        measure: if forward { measure } else { -&measure },
        near,
    }
}

/// The point nearest to the receiver, and the one or two stretches it is an end of or on.
fn apex<T: Real>(frame: &Frame, triangle: &Triangle, outline: &[Stretch<T>], bits: usize) -> (Point<T>, [Option<usize>; 2]) {
    let normal = [0, 1, 2].map(|i| triangle.normal[i].leading());
    let foot = {
        let r0 = outline[0].ends[0].near;
        let share = dot64(normal, r0) / dot64(normal, normal);
        normal.map(|n| n * share)
    };
    let outside = |stretch: &Stretch<T>| {
        let [start, end] = stretch.ends.each_ref().map(|p| p.near);
        dot64(cross64(minus(end, start), minus(foot, start)), normal) <= 0.0
    };
    if !outline.iter().any(outside) {
        return (interior(frame, triangle, foot), [None, None]);
    }
    let mut best: Option<(f64, Point<T>, Place, usize)> = None;
    for (index, stretch) in outline.iter().enumerate() {
        let (point, place) = stretch.nearest(frame, [0.0; 3], bits);
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

/// A point of the triangle's plane next to `target`, exact: `r_0 + l e1 + m e2` with doubles l, m. The longest edge is e2: the error
/// of l then moves the point along the shortest way, and m makes good for what it does along e2.
fn interior<T: Real>(frame: &Frame, triangle: &Triangle, target: [f64; 3]) -> Point<T> {
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
    let rest = [0, 1, 2].map(|i| way[i] - l * e1[i]);
    let m = dot64(rest, e2) / dot64(e2, e2);
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
