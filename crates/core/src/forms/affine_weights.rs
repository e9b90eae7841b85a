//! The weights of the vertices of a flat polygon in the affine functions on its plane: `lambda_k`, 1 in all together.
//!
//! A triangle has one affine function for each set of vertex values, and `lambda_k` is 1 at vertex k and 0 at the others. A polygon of
//! more vertices has one for those values only that are affine, and moves in its plane's place for those motions only that keep it
//! flat. Any weights serve that give these; the least of them, which answer as well as any where values are not affine (by least
//! squares), are `lambda_k(y) = 1/N + (y - c).G^-1 (V_k - c)`, with c the mean of the vertices and
//! `G = sum (V_k - c)(V_k - c)^T` in the plane. In them the derivatives by all vertex values are themselves affine, so that a step along
//! them keeps the emission so.

use glam::DVec3;
use radgrad_numbers::offset::offset;
use radgrad_numbers::real::{RadiusOf, Real};
use radgrad_numbers::vec3::Vec3;

use crate::problem::polygon::Polygon;
use crate::problem::polynomial::plane::axes;

/// `lambda(y) = constant + slope.(y - x)`, the slope in the plane; lengths are normalised.
#[derive(Debug, Clone, Copy)]
pub(crate) struct AffineWeight<T> {
    pub(crate) constant: T,
    pub(crate) slope: Vec3<T>,
}

impl<T: Real> AffineWeight<T> {
    pub(crate) fn at(&self, point: Vec3<T>) -> T {
        self.constant + self.slope.dot(point)
    }
}

/// The weight of each vertex, seen from x.
pub(crate) fn affine_weights<T: Real>(polygon: &Polygon, x: DVec3, power: f64) -> Vec<AffineWeight<T>> {
    let vertices = polygon.vertices();
    let share = T::exact(1.0) / T::exact(vertices.len() as f64);
    // From the first vertex, so that nothing of the distance is lost.
    let from_first: Vec<Vec3<T>> = vertices.iter().map(|&v| offset(v, vertices[0], power)).collect();
    let mean = from_first.iter().fold(Vec3::zero(), |sum, v| sum + *v) * share;
    let [t_1, t_2] = axes::<T>(polygon);
    let arms: Vec<[T; 2]> = from_first.iter().map(|&v| [(v - mean).dot(t_1), (v - mean).dot(t_2)]).collect();
    let product = |i: usize, j: usize| arms.iter().fold(T::exact(0.0), |sum, arm| sum + arm[i] * arm[j]);
    let (uu, uv, vv) = (product(0, 0), product(0, 1), product(1, 1));
    let inverse = T::exact(1.0) / (uu * vv - uv * uv);
    let first: Vec3<T> = offset(vertices[0], x, power);
    let middle = first + mean;
    let weight = |&[a, b]: &[T; 2]| {
        let slope = t_1 * ((vv * a - uv * b) * inverse) + t_2 * ((uu * b - uv * a) * inverse);
        AffineWeight { constant: share - slope.dot(middle), slope }
    };
    arms.iter().map(weight).collect()
}

/// Bound on the magnitudes of the weights over the polygon.
pub(crate) fn largest_weight<T: Real>(weights: &[AffineWeight<T>], polygon: &Polygon, x: DVec3, power: f64) -> RadiusOf<T> {
    let at_vertices = polygon.vertices().iter().flat_map(|&v| {
        let point = offset(v, x, power);
        weights.iter().map(move |weight| weight.at(point))
    });
    // The sum of all, which is not a number where one is not.
    at_vertices.fold(0.0.into(), |sum: RadiusOf<T>, at| sum + (at.size() + at.error()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn weights_give_back_affine_functions_and_those_of_a_triangle_are_its_coordinates() {
        let x = DVec3::new(0.2, -0.4, 3.0);
        let corners =
            [[0.0, 0.0, 0.5], [2.0, 0.0, 0.5], [2.5, 1.0, 0.75], [0.5, 1.5, 0.875], [-0.25, 0.5, 0.625]].map(DVec3::from);
        for count in [3, 5] {
            let polygon = Polygon::new(corners[..count].to_vec()).unwrap();
            let weights = affine_weights::<f64>(&polygon, x, 0.5);
            let at = |y: DVec3| weights.iter().map(|w| w.at(Vec3::from((y - x) * 0.5))).collect::<Vec<_>>();
            for (i, &vertex) in corners[..count].iter().enumerate() {
                let lambda = at(vertex);
                let mean: DVec3 = lambda.iter().zip(&corners).map(|(l, v)| *v * *l).sum();
                assert!((lambda.iter().sum::<f64>() - 1.0).abs() < 1e-14 && (mean - vertex).length() < 1e-14, "{i} {lambda:?}");
                if count == 3 {
                    assert!((0..3).all(|k| (lambda[k] - f64::from(u8::from(k == i))).abs() < 1e-14), "{lambda:?}");
                }
            }
            assert!(largest_weight(&weights, &polygon, x, 0.5) >= 0.999);
        }
    }
}
