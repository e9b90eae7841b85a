//! The outline of a triangle's visible part: stretches of its edges and of the horizon, with exact ends.
//!
//! Where an edge crosses the horizon is a quotient of dyadic rationals. Points keep numerator and divisor, so that the way
//! between two of them has all its digits even where they nearly coincide: on contact the horizon passes the foot at a distance
//! of the order of the height.

use crate::enclosure::arithmetic::Real;
use crate::enclosure::ball::{Ball, BallVector};
use crate::enclosure::exact::{Exact, ExactVector, along, difference};
use crate::enclosure::surface::{Frame, dot64, minus};

/// A point of a triangle's plane.
#[derive(Debug, Clone)]
pub(crate) struct Point {
    numerator: ExactVector,
    divisor: Exact,
    /// `n1.r` times the divisor.
    height: Exact,
    /// The position in double precision.
    pub(crate) near: [f64; 3],
}

impl Point {
    fn new(numerator: ExactVector, divisor: Exact, height: Exact) -> Self {
        let near = [0, 1, 2].map(|i| numerator[i].leading() / divisor.leading());
        Self { numerator, divisor, height, near }
    }

    /// Where the ray along `direction` meets the plane at `height` in units of its normal, of which it covers `advance` at 1.
    pub(crate) fn on_plane(direction: &ExactVector, height: &Exact, advance: &Exact, over_horizon: &Exact) -> Self {
        if height == advance {
            return Self::exact(direction.clone(), over_horizon.clone());
        }
        // A common power of two keeps the leading doubles in range.
        let power = -advance.exponent();
        let lifted = |c: &Exact| (c * height).times_power(power);
        Self::new(direction.each_ref().map(lifted), advance.times_power(power), lifted(over_horizon))
    }

    pub(crate) fn exact(position: ExactVector, height: Exact) -> Self {
        Self::new(position, Exact::from(1.0), height)
    }

    /// `start + place (end - start)`.
    pub(crate) fn between(start: &Self, place: f64, end: &Self) -> Self {
        let common = start.numerator.each_ref().map(|n| n * &end.divisor);
        let numerator = along(&common, place, &end.way_from(start));
        let height = &(&start.height * &end.divisor) + &(&Exact::from(place) * &end.climb_from(start));
        Self::new(numerator, &start.divisor * &end.divisor, height)
    }

    /// The way from `start` here, times the divisors of both.
    fn way_from(&self, start: &Self) -> ExactVector {
        std::array::from_fn(|i| &(&self.numerator[i] * &start.divisor) - &(&start.numerator[i] * &self.divisor))
    }

    /// The same for `n1.r`.
    fn climb_from(&self, start: &Self) -> Exact {
        &(&self.height * &start.divisor) - &(&start.height * &self.divisor)
    }

    /// Whether it is on the horizon.
    pub(crate) fn is_level(&self) -> bool {
        self.height.is_zero()
    }

    /// `n1.r`.
    pub(crate) fn height<T: Real>(&self, bits: usize) -> Ball<T> {
        ratio(&self.height, &self.divisor, bits)
    }

    /// How much higher than `start` it is over the horizon.
    pub(crate) fn climb<T: Real>(&self, start: &Self, bits: usize) -> Ball<T> {
        ratio(&self.climb_from(start), &(&self.divisor * &start.divisor), bits)
    }

    /// The position.
    pub(crate) fn position<T: Real>(&self, bits: usize) -> BallVector<T> {
        quotient(&self.numerator, &self.divisor, bits)
    }

    /// The way from `start` here.
    pub(crate) fn from<T: Real>(&self, start: &Self, bits: usize) -> BallVector<T> {
        quotient(&self.way_from(start), &(&self.divisor * &start.divisor), bits)
    }
}

fn quotient<T: Real>(numerator: &ExactVector, divisor: &Exact, bits: usize) -> BallVector<T> {
    let divisor = Ball::from_exact(divisor, bits);
    numerator.each_ref().map(|n| Ball::from_exact(n, bits).divided_by(&divisor))
}

fn ratio<T: Real>(numerator: &Exact, divisor: &Exact, bits: usize) -> Ball<T> {
    let numerator_ball = Ball::from_exact(numerator, bits);
    if numerator.is_zero() || *divisor == Exact::from(1.0) {
        return numerator_ball;
    }
    numerator_ball.divided_by(&Ball::from_exact(divisor, bits))
}

/// Where a point of a stretch is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Place {
    Start,
    Within,
    End,
}

/// A stretch of an edge above the horizon, or of another line that bounds the visible part.
#[derive(Debug)]
pub(crate) struct Stretch {
    pub(crate) ends: [Point; 2],
    /// The edge, by its vertices, and where along it the ends are; none on another line.
    edge: Option<([usize; 2], [f64; 2])>,
}

impl Stretch {
    /// The stretch of a line between two points of it.
    pub(crate) const fn between(ends: [Point; 2]) -> Self {
        Self { ends, edge: None }
    }

    /// The part of edge `i j` above the horizon.
    pub(crate) fn of_edge(frame: &Frame, [i, j]: [usize; 2]) -> Option<Self> {
        let (start, end) = (&frame.heights[i], &frame.heights[j]);
        if start.sign() <= 0 && end.sign() <= 0 {
            return None;
        }
        let vertex = |k: usize| Point::exact(frame.vertices[k].clone(), frame.heights[k].clone());
        let (ends, range) = if start.sign() < 0 {
            let (point, place) = crossing(frame, [i, j]);
            ([point, vertex(j)], [place, 1.0])
        } else if end.sign() < 0 {
            let (point, place) = crossing(frame, [i, j]);
            ([vertex(i), point], [0.0, place])
        } else {
            ([vertex(i), vertex(j)], [0.0, 1.0])
        };
        Some(Self { ends, edge: Some(([i, j], range)) })
    }

    /// The point of the stretch nearest to `target`, about: an end, or a point with an exact place along it.
    pub(crate) fn nearest(&self, frame: &Frame, target: [f64; 3]) -> (Point, Place) {
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
            return (Point::between(start, fraction, end), Place::Within);
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

/// Where edge `i j` crosses the horizon, `(r_i (n1.r_j) - r_j (n1.r_i)) / (n1.r_j - n1.r_i)`, and about how far along it.
fn crossing(frame: &Frame, [i, j]: [usize; 2]) -> (Point, f64) {
    let (start, end) = (&frame.heights[i], &frame.heights[j]);
    let rise = end - start;
    let numerator = std::array::from_fn(|axis| &(&frame.vertices[i][axis] * end) - &(&frame.vertices[j][axis] * start));
    let place = -start.leading() / rise.leading();
    (Point::new(numerator, rise, Exact::zero()), place)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::enclosure::double_double::DoubleDouble;
    use crate::enclosure::surface::{Body, displaced};
    use glam::DVec3;
    use radgrad_core::Polygon;

    #[test]
    fn a_way_between_points_next_to_each_other_keeps_its_digits() {
        let triangle =
            Polygon::new([(-1.0, -1.0), (-1.0, 2.0), (2.0, -1.0)].map(|(x, y)| DVec3::new(x, y, 1.0)).to_vec()).unwrap();
        let frame =
            Frame::new(DVec3::ZERO, &displaced(DVec3::new(0.3, 0.1, 0.2), DVec3::ZERO, 0.0), &Body::new(&triangle, &[], 0.0));
        let (cut, _) = crossing(&frame, [0, 2]);
        assert!(cut.is_level());
        let vertex = Point::exact(frame.vertices[0].clone(), frame.heights[0].clone());
        let next = Point::between(&cut, 2f64.powi(-90), &vertex);
        let way = next.from::<DoubleDouble>(&cut, 106);
        let whole = vertex.from::<DoubleDouble>(&cut, 106);
        let expected = whole[0].leading() * 2f64.powi(-90);
        assert!((way[0].leading() - expected).abs() < 1e-15 * expected.abs(), "{} {expected}", way[0].leading());
        assert!(way[0].radius < 1e-30 * expected.abs());
    }
}
