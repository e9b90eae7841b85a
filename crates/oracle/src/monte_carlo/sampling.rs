//! Points of a seen region drawn by area or by solid angle, as maps from the unit square: one sample from two numbers, so that
//! any sequence on the square serves.
//!
//! By area: a triangle in proportion to its area, then `(1 - sqrt u, sqrt u (1 - v), sqrt u v)` (Turk 1990). By solid angle: a
//! triangle in proportion to the solid angle it subtends, `tan(Omega/2) = G0 / (1 + v0.v1 + v1.v2 + v2.v0)` with `G0 = v0.(v1 x
//! v2) = 2 area h / (|r0| |r1| |r2|)` (Van Oosterom and Strackee 1983), then Arvo's map (1995) in the algebraic form of Peters
//! (2021), carried in barycentric coordinates: no direction is rounded, so a triangle of 1e-10 sr is sampled as well as one of
//! 2 pi sr.

use crate::region::plane::{Triangle, Vertex};
use crate::region::{FrameVector, Region};

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
                (triangle.point([1.0 - root, root * (1.0 - v), root * v]), self.total())
            }
            Sampling::SolidAngle => {
                let vertex = triangle.point(Corners::new(triangle, self.height).barycentric([within, v]));
                let squared = vertex.p * vertex.p + vertex.q * vertex.q + self.height * self.height;
                (vertex, self.total() * squared * squared.sqrt() / self.height)
            }
        }
    }
}

/// Directions to the corners of a triangle.
#[derive(Debug)]
pub(crate) struct Corners {
    directions: [FrameVector; 3],
    distances: [f64; 3],
    /// `v0.(v1 x v2)`.
    volume: f64,
}

impl Corners {
    pub(crate) fn new(triangle: &Triangle, height: f64) -> Self {
        let rays = triangle.corners.map(|corner| FrameVector::new(corner.p, corner.q, -height));
        let distances = rays.map(|ray| ray.norm());
        let directions = rays.map(|ray| ray.normalize());
        let volume = 2.0 * triangle.area * height / (distances[0] * distances[1] * distances[2]);
        Self { directions, distances, volume }
    }

    fn cosine(&self, i: usize, j: usize) -> f64 {
        self.directions[i].dot(&self.directions[j])
    }

    pub(crate) fn solid_angle(&self) -> f64 {
        2.0 * libm::atan2(self.volume, 1.0 + self.cosine(0, 1) + self.cosine(1, 2) + self.cosine(2, 0))
    }

    /// Barycentric coordinates of the point that divides the triangle as `(u, v)`: the arc from corner 1 through it meets the
    /// side from corner 0 to corner 2 where the part on the side of corner 0 has the fraction `u` of the solid angle.
    pub(crate) fn barycentric(&self, [u, v]: [f64; 2]) -> [f64; 3] {
        let (sin, cos) = libm::sincos(0.5 * u * self.solid_angle());
        let [v0, v1, v2] = self.directions;
        let from_first = self.volume * cos - (self.cosine(0, 2) + self.cosine(1, 2)) * sin;
        let from_last = (1.0 + self.cosine(0, 1)) * sin;
        let axis = from_first * v0 + from_last * v2;
        let squared = axis.norm_squared();
        // At u = 0 the mirrored direction is corner 0 itself.
        let mirror = if squared > 0.0 { 2.0 * v0.dot(&axis) / squared } else { return [1.0, 0.0, 0.0] };
        let (first, last) = (mirror * from_first - 1.0, mirror * from_last);
        let chord = (v1 - (first * v0 + last * v2)).norm_squared();
        // Cosines from corner 1, by the chord: 1 - cos keeps its digits.
        let cos_side = 1.0 - 0.5 * chord;
        let cos_point = 1.0 - 0.5 * v * chord;
        let reach = (v * (1.0 + cos_point) / (1.0 + cos_side)).sqrt();
        let weights = [reach * first, cos_point - reach * cos_side, reach * last];
        let weights = [0, 1, 2].map(|i| weights[i] / self.distances[i]);
        let sum = weights[0] + weights[1] + weights[2];
        weights.map(|weight| weight / sum)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A triangle from in-plane corners; emission is not used.
    fn triangle(corners: [[f64; 2]; 3]) -> Triangle {
        let [[ap, aq], [bp, bq], [cp, cq]] = corners;
        let area = 0.5 * ((bp - ap) * (cq - aq) - (bq - aq) * (cp - ap));
        Triangle { corners: corners.map(|[p, q]| Vertex { p, q, s: 1.0, b: 1.0 }), area }
    }

    fn solid_angle(corners: [[f64; 2]; 3], height: f64) -> f64 {
        Corners::new(&triangle(corners), height).solid_angle()
    }

    #[test]
    fn solid_angles_are_right_from_1e_minus_10_to_2_pi() {
        // An octant: directions (1, 0, 0), (0, 1, 0), (0, 0, -1) in the limit.
        let octant = solid_angle([[1e9, 0.0], [0.0, 1e9], [0.0, 0.0]], 1.0);
        assert!((octant - std::f64::consts::FRAC_PI_2).abs() < 1e-8, "{octant}");
        let half_space = solid_angle([[-1e9, -1e9], [1e9, -1e9], [0.0, 1e9]], 1.0);
        assert!((half_space - std::f64::consts::TAU).abs() < 1e-8, "{half_space}");
        // Small: area cos / r^2 up to the variation over the triangle.
        let small = solid_angle([[1.0, 1.0], [1.00001, 1.0], [1.0, 1.00002]], 1.0);
        assert!((small / (1e-10 / 3.0_f64.powi(3).sqrt()) - 1.0).abs() < 1e-4, "{small}");
    }

    #[test]
    fn the_first_coordinate_is_the_fraction_of_the_solid_angle() {
        for (corners, height) in [
            ([[0.3, -0.2], [2.0, 0.5], [-1.0, 1.5]], 0.7),
            ([[-1e4, -1e4], [1e4, -1e4], [0.0, 1e4]], 1.0),
            ([[1.0, 1.0], [1.000_01, 1.0], [1.0, 1.000_02]], 1.0),
            ([[0.0, 0.0], [1.0, 0.0], [0.5, 1e-6]], 1e-3),
        ] {
            let whole = triangle(corners);
            for u in [0.001, 0.25, 0.5, 0.9] {
                // v = 1 is on the side from corner 0 to corner 2.
                let [first, second, last] = Corners::new(&whole, height).barycentric([u, 1.0]);
                assert!(second.abs() < 1e-12 && first > 0.0 && last > 0.0, "{first} {second} {last}");
                let split = [0, 1].map(|i| first * corners[0][i] + last * corners[2][i]);
                let [part, whole] = [solid_angle([corners[0], corners[1], split], height), solid_angle(corners, height)];
                assert!((part / whole - u).abs() < 1e-6 * u, "{corners:?} {u}: {}", part / whole);
            }
        }
    }

    #[test]
    fn the_second_coordinate_is_uniform_in_the_cosine_from_corner_1() {
        let corners = [[0.3, -0.2], [2.0, 0.5], [-1.0, 1.5]];
        let sampled = Corners::new(&triangle(corners), 0.7);
        let cosine = |v: f64| {
            let l = sampled.barycentric([0.4, v]);
            let ray = [0, 1].map(|i| l[0] * corners[0][i] + l[1] * corners[1][i] + l[2] * corners[2][i]);
            FrameVector::new(ray[0], ray[1], -0.7).normalize().dot(&sampled.directions[1])
        };
        for v in [0.0, 0.1, 0.5, 0.8] {
            assert!((cosine(v) - (1.0 - v * (1.0 - cosine(1.0)))).abs() < 1e-14);
        }
    }

    #[test]
    fn area_sampling_has_the_right_centroid() {
        let count = 64;
        let whole = [triangle([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]])];
        let cumulated = vec![0.5];
        let sampler = Sampler { triangles: &whole, height: 1.0, sampling: Sampling::Area, cumulated };
        let mut mean = [0.0; 2];
        for i in 0..count * count {
            let place = |k: i32| (f64::from(k) + 0.5) / f64::from(count);
            let (at, weight) = sampler.point([place(i / count), place(i % count)]);
            assert_eq!(weight, 0.5);
            mean = [mean[0] + at.p / f64::from(count * count), mean[1] + at.q / f64::from(count * count)];
        }
        assert!(mean.iter().all(|m| (m - 1.0 / 3.0).abs() < 1e-4), "{mean:?}");
    }
}
