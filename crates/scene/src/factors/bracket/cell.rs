//! A convex part of a face.

use radgrad_core::DVec3;

use crate::extremes::{largest as larger, smallest as smaller};
use crate::factors::exchange::areas::FlatOutline;
use crate::factors::rule::middle;
use crate::factors::screen::area;
use crate::occluders::overlap::perimeter;

/// Data that the cells of a face share.
#[derive(Debug, Clone, Copy)]
pub(super) struct Plane {
    pub(super) normal: DVec3,
    /// Perimeter over area of the face: how well its plane is known.
    pub(super) slope: f64,
    /// Distance by which its vertices are off the plane.
    pub(super) defect: f64,
}

/// Points as near as this are one: four roundings of coordinates up to 1.
pub(super) const NEAR: f64 = 4.0 * f64::EPSILON;

/// A convex outline in a plane, counter-clockwise seen from its lit side.
#[derive(Debug, Clone)]
pub(in crate::factors) struct Cell {
    pub(in crate::factors) points: Vec<DVec3>,
    pub(in crate::factors) area: f64,
}

impl Cell {
    /// The cell, if it has an area.
    pub(super) fn new(points: Vec<DVec3>, plane: &Plane) -> Option<Self> {
        let area = area(&points, plane.normal);
        (points.len() >= 3 && area > 0.0).then_some(Self { points, area })
    }

    pub(super) fn centre(&self) -> DVec3 {
        middle(&self.points)
    }

    pub(super) fn perimeter(&self) -> f64 {
        perimeter(&self.points)
    }

    pub(super) fn part<'a>(&'a self, plane: &Plane) -> FlatOutline<'a> {
        FlatOutline { points: &self.points, normal: plane.normal, slope: plane.slope, defect: plane.defect, area: self.area }
    }

    /// The parts where a function, given at the corners and affine in between, is negative and where it is positive.
    pub(super) fn cut(&self, heights: &[f64], plane: &Plane) -> [Option<Self>; 2] {
        let count = self.points.len();
        let [mut below, mut above] = [(); 2].map(|()| Vec::with_capacity(count + 2));
        for i in 0..count {
            let j = (i + 1) % count;
            let (h, next) = (heights[i], heights[j]);
            if h <= 0.0 {
                below.push(self.points[i]);
            }
            if h >= 0.0 {
                above.push(self.points[i]);
            }
            if (h < 0.0 && next > 0.0) || (h > 0.0 && next < 0.0) {
                let point = self.points[i] + (self.points[j] - self.points[i]) * (h / (h - next));
                below.push(point);
                above.push(point);
            }
        }
        [below, above].map(|mut points| {
            let are_near = |a: DVec3, b: DVec3| (a - b).abs().max_element() <= NEAR;
            points.dedup_by(|b, a| are_near(*a, *b));
            while points.len() > 1 && are_near(points[0], points[points.len() - 1]) {
                points.pop();
            }
            Self::new(points, plane)
        })
    }

    /// Two directions in the plane: along the longest edge, and across it.
    pub(super) fn axes(&self, plane: &Plane) -> [DVec3; 2] {
        let count = self.points.len();
        let edges = (0..count).map(|i| self.points[(i + 1) % count] - self.points[i]);
        let longest = edges.max_by(|a, b| a.length_squared().total_cmp(&b.length_squared())).unwrap_or(DVec3::X);
        let along = longest.normalize_or_zero();
        [along, plane.normal.cross(along)]
    }

    /// How far it reaches in a direction.
    pub(super) fn extent(&self, direction: DVec3) -> f64 {
        let places = || self.points.iter().map(|&p| direction.dot(p - self.points[0]));
        places().fold(f64::NEG_INFINITY, larger) - places().fold(f64::INFINITY, smaller)
    }

    /// About how far a point is from it: from the box around it.
    pub(super) fn away(&self, point: DVec3) -> f64 {
        let low = self.points.iter().copied().fold(DVec3::INFINITY, DVec3::min);
        let high = self.points.iter().copied().fold(DVec3::NEG_INFINITY, DVec3::max);
        (point - point.clamp(low, high)).length()
    }

    /// Two halves, cut across a direction in the middle of its reach.
    pub(super) fn halves(&self, direction: DVec3, plane: &Plane) -> [Option<Self>; 2] {
        let places: Vec<f64> = self.points.iter().map(|&p| direction.dot(p - self.points[0])).collect();
        let middle = 0.5 * places.iter().copied().fold(f64::NEG_INFINITY, larger)
            + 0.5 * places.iter().copied().fold(f64::INFINITY, smaller);
        let heights: Vec<f64> = places.iter().map(|place| place - middle).collect();
        self.cut(&heights, plane)
    }
}
