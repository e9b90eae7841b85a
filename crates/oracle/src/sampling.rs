//! Points of a seen region drawn by area or by solid angle, as maps from the unit square: one sample from two numbers, so that any
//! sequence on the square serves.
//!
//! By area: a triangle in proportion to its area, then `(1 - sqrt u, sqrt u (1 - v), sqrt u v)` (Turk 1990).
//! By solid angle: a triangle in proportion to the solid angle it subtends, `tan(Omega/2) = G0 / (1 + v0.v1 + v1.v2 + v2.v0)` with
//! `G0 = v0.(v1 x v2) = 2 area h / (|r0| |r1| |r2|)` (Van Oosterom and Strackee 1983), then Arvo's map (1995) in the algebraic
//! form of Peters (2021), carried in barycentric coordinates: no direction is rounded, so a triangle of 1e-10 sr is
//! sampled as well as one of 2 pi sr.

use crate::region::{Region, Triangle, Vertex};

/// How points are distributed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Sampling {
    /// Uniformly over the area: the weight of a sample varies as `cos cos / r^2`.
    Area,
    /// Uniformly over the solid angle: the weight of a sample varies as `cos` at the receiver.
    SolidAngle,
}

/// A distribution over the triangles of a region.
#[derive(Debug)]
pub(crate) struct Sampler<'a> {
    triangles: &'a [Triangle],
    height: f64,
    sampling: Sampling,
    /// Sums of the measures of the triangles up to and with each.
    cumulated: Vec<f64>,
}

impl<'a> Sampler<'a> {
    pub(crate) fn new(region: &'a Region, sampling: Sampling) -> Self {
        let mut total = 0.0;
        let measure = |triangle: &Triangle| match sampling {
            Sampling::Area => triangle.area,
            Sampling::SolidAngle => Corners::new(triangle, region.height).solid_angle(),
        };
        let cumulate = |triangle: &Triangle| {
            total += measure(triangle);
            total
        };
        let cumulated = region.triangles.iter().map(cumulate).collect();
        Self { triangles: &region.triangles, height: region.height, sampling, cumulated }
    }

    /// Area or solid angle of the whole region.
    pub(crate) fn total(&self) -> f64 {
        self.cumulated.last().copied().unwrap_or(0.0)
    }

    /// The point that belongs to `(u, v)` of the unit square, and `1 / density` with respect to area.
    pub(crate) fn point(&self, [u, v]: [f64; 2]) -> (Vertex, f64) {
        let place = u * self.total();
        let index = self.cumulated.partition_point(|sum| *sum <= place).min(self.triangles.len() - 1);
        let below = if index == 0 { 0.0 } else { self.cumulated[index - 1] };
        let within = ((place - below) / (self.cumulated[index] - below)).min(1.0);
        let triangle = &self.triangles[index];
        match self.sampling {
            Sampling::Area => {
                let root = within.sqrt();
                (triangle.at([1.0 - root, root * (1.0 - v), root * v]), self.total())
            }
            Sampling::SolidAngle => {
                let at = triangle.at(Corners::new(triangle, self.height).barycentric([within, v]));
                let squared = at.p * at.p + at.q * at.q + self.height * self.height;
                (at, self.total() * squared * squared.sqrt() / self.height)
            }
        }
    }
}

/// Directions to the corners of a triangle.
struct Corners {
    directions: [[f64; 3]; 3],
    distances: [f64; 3],
    /// `v0.(v1 x v2)`.
    volume: f64,
}

impl Corners {
    fn new(triangle: &Triangle, height: f64) -> Self {
        let rays = triangle.corners.map(|corner| [corner.p, corner.q, -height]);
        let distances = rays.map(|ray| dot(ray, ray).sqrt());
        let directions = [0, 1, 2].map(|i| rays[i].map(|c| c / distances[i]));
        let volume = 2.0 * triangle.area * height / (distances[0] * distances[1] * distances[2]);
        Self { directions, distances, volume }
    }

    fn cosine(&self, i: usize, j: usize) -> f64 {
        dot(self.directions[i], self.directions[j])
    }

    fn solid_angle(&self) -> f64 {
        2.0 * libm::atan2(self.volume, 1.0 + self.cosine(0, 1) + self.cosine(1, 2) + self.cosine(2, 0))
    }

    /// Barycentric coordinates of the point that divides the triangle as `(u, v)`: the arc from corner 1 through it meets the side from
    /// corner 0 to corner 2 where the part on the side of corner 0 has the fraction `u` of the solid angle.
    fn barycentric(&self, [u, v]: [f64; 2]) -> [f64; 3] {
        let (sin, cos) = libm::sincos(0.5 * u * self.solid_angle());
        let [v0, v1, v2] = self.directions;
        let from_first = self.volume * cos - (self.cosine(0, 2) + self.cosine(1, 2)) * sin;
        let from_last = (1.0 + self.cosine(0, 1)) * sin;
        let axis = [0, 1, 2].map(|i| from_first * v0[i] + from_last * v2[i]);
        let squared = dot(axis, axis);
        // At u = 0 the mirrored direction is corner 0 itself.
        let mirror = if squared > 0.0 { 2.0 * dot(v0, axis) / squared } else { return [1.0, 0.0, 0.0] };
        let (first, last) = (mirror * from_first - 1.0, mirror * from_last);
        let side = [0, 1, 2].map(|i| first * v0[i] + last * v2[i]);
        let chord = [0, 1, 2].map(|i| v1[i] - side[i]);
        // Cosines from corner 1, by the chord: 1 - cos keeps its digits.
        let cos_side = 1.0 - 0.5 * dot(chord, chord);
        let cos_point = 1.0 - 0.5 * v * dot(chord, chord);
        let reach = (v * (1.0 + cos_point) / (1.0 + cos_side)).sqrt();
        let weights = [reach * first, cos_point - reach * cos_side, reach * last];
        let weights = [0, 1, 2].map(|i| weights[i] / self.distances[i]);
        let sum = weights[0] + weights[1] + weights[2];
        weights.map(|weight| weight / sum)
    }
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}
