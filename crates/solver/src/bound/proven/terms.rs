//! What an element receives from a part of a scene changes by at most so much between two of its places, and differs from a
//! polynomial by at most so much: geometry alone.

use std::f64::consts::PI;

use radgrad_core::DVec3;
use radgrad_scene::{largest, smallest};

use super::nodes::{Nodes, ROUNDED};
use crate::mesh::element::Element;
use crate::mesh::screen::LEVEL;

/// An element that receives.
#[derive(Debug)]
pub(super) struct Target<'a> {
    pub(super) element: &'a Element,
    pub(super) nodes: &'a Nodes,
    /// For each part around a node, the node's place, and the largest distance of its places from it.
    pub(super) discs: Vec<(DVec3, f64)>,
    /// Lengths of the axes.
    lengths: [f64; 2],
}

/// Bounds over all places of an element on what a source gives.
#[derive(Debug, Clone, Copy)]
pub(super) struct Reach {
    /// On the form factor.
    pub(super) factor: f64,
    /// On the kernel times the source's area.
    pub(super) peak: f64,
    /// Distance, largest height over the receiver's plane and over the source's.
    pub(super) distance: f64,
    over: f64,
}

impl<'a> Target<'a> {
    pub(super) fn of(element: &'a Element, places: &[[f64; 2]], nodes: &'a Nodes) -> Self {
        let lengths = element.axes().map(DVec3::length);
        let disc = |near: &super::nodes::Near| {
            let reach = near.most[0] * lengths[0] + near.most[1] * lengths[1];
            (element.point(places[near.node]), reach * ROUNDED)
        };
        Self { element, nodes, discs: nodes.near.iter().map(disc).collect(), lengths }
    }

    fn normal(&self) -> DVec3 {
        self.element.polygon().normal()
    }

    /// Height over the plane.
    pub(super) fn height(&self, p: DVec3) -> f64 {
        self.normal().dot(p - self.element.centre())
    }

    /// The part of a segment that is above the plane.
    fn above(&self, [a, b]: [DVec3; 2]) -> Option<([DVec3; 2], [f64; 2])> {
        let heights = [self.height(a), self.height(b)];
        let level = LEVEL * ((a - self.element.centre()).length() + (b - self.element.centre()).length());
        match (heights[0] > level, heights[1] > level) {
            (false, false) => None,
            (true, true) => Some(([a, b], heights)),
            // To the level below, where it counts for nothing.
            (true, false) => {
                let end = b + (a - b) * (-smallest(heights[1], 0.0) / (heights[0] - smallest(heights[1], 0.0)));
                Some(([a, end], [heights[0], largest(heights[1], 0.0)]))
            }
            (false, true) => {
                let end = a + (b - a) * (-smallest(heights[0], 0.0) / (heights[1] - smallest(heights[0], 0.0)));
                Some(([end, b], [largest(heights[0], 0.0), heights[1]]))
            }
        }
    }

    /// For each axis, what a boundary along a segment changes the form factor by at most, per unit of the coordinate, from places
    /// in a disc; infinite where it comes near.
    pub(super) fn rates(&self, (place, radius): (DVec3, f64), segment: [DVec3; 2]) -> [f64; 2] {
        let Some(line) = self.line(place, segment) else { return [0.0; 2] };
        if radius >= 0.9 * line.distance {
            return [f64::INFINITY; 2];
        }
        let wider = 1.0 / (1.0 - radius / line.distance).powi(4);
        self.element.axes().map(|axis| {
            let across = axis.cross(line.along);
            let toward = across.dot(line.from).abs() + radius * across.length();
            toward * line.integral * wider / PI * ROUNDED
        })
    }

    /// A segment's part above the plane, from a place.
    fn line(&self, place: DVec3, segment: [DVec3; 2]) -> Option<Line> {
        let ([a, b], heights) = self.above(segment)?;
        let length = (b - a).length();
        if length == 0.0 {
            return None;
        }
        let along = (b - a) / length;
        let from = a - place;
        let start = from.dot(along);
        let end = start + length;
        let square = (from - along * start).length_squared();
        let away = if start > 0.0 {
            start
        } else if end < 0.0 {
            -end
        } else {
            0.0
        };
        let distance = (square + away * away).sqrt();
        if distance == 0.0 {
            return Some(Line { along, from, distance, across: 0.0, integral: f64::INFINITY });
        }
        let integral = of_height_over_fourth_power(heights, [start, end], square, distance);
        let across = square.sqrt();
        Some(Line { along, from, distance, across, integral })
    }

    /// What the form factor of a polygon that is wholly seen differs from a polynomial of a degree by at most.
    pub(super) fn beyond_of_even(&self, polygon: &[DVec3], degree: usize) -> f64 {
        let of_edge = |(i, &a): (usize, &DVec3)| {
            let Some(line) = self.line(self.element.centre(), [a, polygon[(i + 1) % polygon.len()]]) else { return 0.0 };
            let ratio = self.element.radius() / line.distance;
            if ratio < 0.9 {
                line.across * line.integral / PI * line.distance * tail(degree, ratio, |k| (k + 1.0) * (k + 2.0) / 6.0)
            } else {
                f64::INFINITY
            }
        };
        polygon.iter().enumerate().map(of_edge).sum::<f64>() * ROUNDED
    }

    /// Whether an element is so near that Taylor's polynomials do not converge.
    pub(super) fn is_near(&self, source: &Element) -> bool {
        self.beyond_of_any(source, 0).is_infinite() || self.beyond_of_even(source.polygon().vertices(), 0).is_infinite()
    }

    /// The same of what an element gives that is wholly seen, with a radiosity of at most 1.
    pub(super) fn beyond_of_any(&self, source: &Element, degree: usize) -> f64 {
        let (centre, normal) = (self.element.centre(), source.polygon().normal());
        let height = largest(normal.dot(centre - source.centre()), 0.0);
        let distance = source.distance(centre, height) * (1.0 - 1e-9);
        let ratio = self.element.radius() / distance;
        if ratio >= 0.9 || ratio.is_nan() {
            return f64::INFINITY;
        }
        let over = source.polygon().vertices().iter().map(|&v| self.height(v)).fold(0.0, largest);
        let (cos1, cos2) = (smallest(over / distance, 1.0), smallest(height / distance, 1.0));
        let tilt = self.tilt(normal);
        let unit = source.area() * cos1 / (PI * distance * distance);
        let c = |k: f64| (k + 1.0) * (k + 2.0) * (k + 3.0) / 6.0;
        unit * tail(degree, ratio, |k| cos2 * c(k) + tilt * c(k - 1.0)) * ROUNDED
    }

    /// Bound on the sine of the angle to a plane of this normal.
    fn tilt(&self, normal: DVec3) -> f64 {
        let level = self.normal().dot(normal);
        (1.0 - level * level + 1e-12).clamp(0.0, 1.0).sqrt()
    }

    /// What moves by `ds` and `dt`, each at most, changes by from a source whose radiosity has a gradient of at most 1: along the source,
    /// its boundary left aside.
    pub(super) fn drift(&self, source: &Element, reach: &Reach, [ds, dt]: [f64; 2]) -> f64 {
        let normal = source.polygon().normal();
        let whole = ds * self.lengths[0] + dt * self.lengths[1];
        let [u, v] = self.element.axes();
        let across = ds * normal.dot(u).abs() + dt * normal.dot(v).abs();
        if across == 0.0 {
            return whole * reach.factor * ROUNDED;
        }
        let centre = self.element.centre();
        let far = source.polygon().vertices().iter().map(|v| (*v - centre).length()).fold(0.0, largest) + self.element.radius();
        let near = across * (far * far / (across * across)).ln_1p() + 2.0 * far * (across / far).atan();
        let level = self.normal().dot(normal).abs();
        let touching = 2.0 * level * across + self.tilt(normal) * near / PI;
        let apart = across * source.area() * reach.over / (PI * reach.distance.powi(3));
        (whole * reach.factor + if apart < touching { apart } else { touching }) * ROUNDED
    }

    /// Bounds over the element on what a source gives.
    pub(super) fn reach(&self, source: &Element) -> Reach {
        let element = self.element;
        let (n1, n2) = (self.normal(), source.polygon().normal());
        let (to, from) = (element.polygon().vertices(), source.polygon().vertices());
        let over = from.iter().map(|&v| self.height(v)).fold(0.0, largest);
        let height = to.iter().map(|&v| n2.dot(v - source.centre())).fold(0.0, largest);
        let distance = largest(element.distance_to(source) * (1.0 - 1e-9), 0.0);
        let lune = 0.5 * (1.0 - n1.dot(n2)) + 1e-12;
        if over == 0.0 || height == 0.0 {
            return Reach { factor: 0.0, peak: 0.0, distance, over };
        }
        if distance == 0.0 {
            return Reach { factor: smallest(lune, 1.0), peak: f64::INFINITY, distance, over };
        }
        let square = PI * distance * distance;
        let peak = source.area() * smallest(over / distance, 1.0) * smallest(height / distance, 1.0) / square * ROUNDED;
        Reach { factor: smallest(smallest(peak, lune), 1.0), peak, distance, over }
    }
}

/// A segment as it is seen from a place.
struct Line {
    along: DVec3,
    /// From the place to where it begins.
    from: DVec3,
    /// From the segment, and from its line.
    distance: f64,
    across: f64,
    /// Of the height over `|r|^4` along it.
    integral: f64,
}

/// The integral has its closed form where the distance of the segment's line is more than `LEAST_ACROSS` of the segment's distance, and the
/// segment is shorter than `MOST_ALONG` of the line's distances. The line's distance then errs by at most about `MOST_ALONG` roundings,
/// and the closed form by `INTEGRAL_ROUNDING` of its values at the two ends.
const LEAST_ACROSS: f64 = 0.01;
const MOST_ALONG: f64 = 1e6;
const INTEGRAL_ROUNDING: f64 = 1e-9;

/// Bound on the integral over a segment of the height over `|r|^4`, from the heights of its ends, their places along its line, the square of
/// that line's distance, and the segment's distance.
fn of_height_over_fourth_power(heights: [f64; 2], [start, end]: [f64; 2], square: f64, distance: f64) -> f64 {
    let (length, across) = (end - start, square.sqrt());
    let simple = largest(heights[0], heights[1]) * length / (distance * distance * distance * distance);
    if across <= LEAST_ACROSS * distance || length >= MOST_ALONG * across {
        return simple;
    }
    let slope = (heights[1] - heights[0]) / length;
    let at_foot = heights[0] - slope * start;
    let even = |t: f64| t / (2.0 * square * (square + t * t)) + (t / across).atan() / (2.0 * square * across);
    let odd = |t: f64| -0.5 / (square + t * t);
    let ([even_start, odd_start], [even_end, odd_end]) = ([even(start), odd(start)], [even(end), odd(end)]);
    // Of a short segment the values at its ends cancel.
    let sizes = at_foot.abs() * (even_end.abs() + even_start.abs()) + slope.abs() * (odd_end.abs() + odd_start.abs());
    let integral = at_foot * (even_end - even_start) + slope * (odd_end - odd_start);
    smallest(integral + INTEGRAL_ROUNDING * sizes, simple)
}

/// `sum over k > degree of c(k) q^k`, where `c(k + 1)/c(k)` falls with k.
fn tail(degree: usize, ratio: f64, c: impl Fn(f64) -> f64) -> f64 {
    let mut k = degree as f64 + 1.0;
    let mut power = std::iter::repeat_n(ratio, degree + 1).product::<f64>();
    let (mut sum, mut term) = (0.0, c(k) * power);
    for _ in 0..200 {
        sum += term;
        k += 1.0;
        power *= ratio;
        let next = c(k) * power;
        let falls = next / term;
        if term == 0.0 || (falls < 1.0 && next / (1.0 - falls) <= 1e-3 * sum) {
            return sum + if term == 0.0 { 0.0 } else { next / (1.0 - falls) };
        }
        term = next;
    }
    f64::INFINITY
}

#[cfg(test)]
mod tests {
    use radgrad_core::Polygon;
    use radgrad_scene::gauss_legendre;

    use super::*;
    use crate::mesh::basis::Basis;
    use crate::mesh::shape::Shape;

    /// A wall that stands on the floor and faces away from it: their distance is rounded to less than 0.
    #[test]
    fn what_touches_is_no_nearer_than_0() {
        let bases = [Shape::Parallelogram, Shape::Triangle].map(|shape| Basis::new(shape, 1));
        let element = |corners: [[f64; 3]; 4]| {
            let polygon = Polygon::new(corners.map(DVec3::from).to_vec()).unwrap();
            Element::of_face(&polygon, 0, &bases).unwrap().remove(0)
        };
        let floor = element([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]]);
        let wall = element([[0.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, 1.0, 1.0], [0.0, 1.0, 0.0]]);
        let nodes = Nodes::of(&bases[0]);
        let places: Vec<[f64; 2]> = bases[0].nodes().iter().map(|node| node.at).collect();
        let target = Target::of(&floor, &places, &nodes);
        let reach = target.reach(&wall);
        let drift = target.drift(&wall, &reach, [0.25; 2]);
        assert!(reach.factor == 0.0 && reach.distance == 0.0 && drift > 0.0 && drift < 2.0, "{reach:?} {drift:e}");
    }

    /// With `t = d tan(a)` the integrand is `h cos^2(a)/d^3`, smooth, and the angle between the ends is known to its last digits.
    #[test]
    fn the_integral_over_a_segment_of_any_length_is_bounded() {
        let rule = gauss_legendre(20);
        let (mut sharp, mut all) = (0, 0);
        for k in 0..4000 {
            let unit = |j: u32| (f64::from(k) * 0.618_033_988_749_895 * f64::from(j) + 0.1 * f64::from(j)).fract();
            let (across, start) = (10_f64.powf(2.0 * unit(1) - 1.0), 6.0 * unit(2) - 3.0);
            let end = start + 10_f64.powf(16.0 * unit(3) - 14.0);
            if end - start == 0.0 {
                continue;
            }
            let heights = [unit(5), unit(7)];
            let turn = (across * (end - start)).atan2(across * across + start * end);
            let of = |x: f64| {
                let angle = (start / across).atan() + 0.5 * (1.0 + x) * turn;
                let part = (across * angle.tan() - start) / (end - start);
                (heights[0] + (heights[1] - heights[0]) * part.clamp(0.0, 1.0)) * angle.cos().powi(2)
            };
            let exact = 0.5 * turn * rule.iter().map(|(x, weight)| weight * of(*x)).sum::<f64>() / across.powi(3);
            let distance = across.hypot(largest(largest(start, -end), 0.0));
            let bound = of_height_over_fourth_power(heights, [start, end], across * across, distance);
            assert!(bound >= exact * (1.0 - 1e-9), "{across} {start} {end} {heights:?}: {bound:e} {exact:e}");
            (sharp, all) = (sharp + usize::from(bound <= 1.01 * exact), all + 1);
        }
        assert!(sharp > all / 4, "{sharp} of {all}");
    }
}
