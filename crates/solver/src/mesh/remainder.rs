//! The remainder of the best polynomial for a smooth function on an element, in the root mean square, by a bound on its
//! derivatives.
//!
//! On a simplex with barycentric coordinates `x_i` let `d_ij` be the derivative along the edge from corner i to corner j.
//! Polynomials of degree n that are orthogonal to all of lower degree, with the weight `W = prod x_i^a_i`, are eigenfunctions of
//! `-(1/W) sum d_ij (x_i x_j W d_ij)` with the eigenvalue `n (n + D + |a|)` in D dimensions, and their derivatives along an edge are
//! such polynomials of degree n - 1 with the weight `x_i x_j W` (D. Braess and C. Schwab 2000). Taken m times this gives for the
//! projection P on all polynomials of a degree below N, with `m <= N`,
//!
//! ```text
//! mean |f - P f|^2 <= sum over edges e1..em of mean(x_e1 .. x_em |d_e1 .. d_em f|^2) / prod_k (N - k)(N + k + D),  k < m
//! ```
//!
//! where `x_e = x_i x_j`. A mixed derivative along m vectors is at most m! times their lengths times the largest `|D^m f|/m!` along
//! any direction (S. Banach 1938, a symmetric form on a Euclidean space), so that the sum is at most the square of that times
//! `m!^2 mean(w^m)` with `w = sum x_i x_j |e_ij|^2`. On a parallelogram the projection is a product of those along its two sides,
//! and the squares of the remainders add up: twice the same with D = 1, where `mean(x^m (1 - x)^m) = m!^2/(2m + 1)!`.

use radgrad_core::DVec3;

use crate::mesh::basis::POWERS;
use crate::mesh::rule;
use crate::mesh::shape::Shape;

/// For each m up to `degree + 1` the root mean square of `f - P f` over a bound on `|D^m f|/m!`, P on the basis of the degree.
pub(crate) fn bounds(shape: Shape, [u, v]: [DVec3; 2], degree: usize) -> [f64; POWERS] {
    let dimension = match shape {
        Shape::Parallelogram => 1.0,
        Shape::Triangle => 2.0,
    };
    let sides = [u, v, v - u].map(DVec3::length_squared);
    // Exact for polynomials of twice the largest power.
    let nodes = if shape == Shape::Triangle { rule::collapsed(POWERS + 1) } else { Vec::new() };
    let (mut factorial, mut eigenvalues, mut beta) = (1.0, 1.0, 1.0);
    let mut bounds = [1.0; POWERS];
    for (order, bound) in bounds.iter_mut().enumerate().take(degree + 2).skip(1) {
        let (m, k) = (order as f64, (order - 1) as f64);
        let above = (degree + 1) as f64;
        factorial *= m;
        eigenvalues *= (above - k) * (above + k + dimension);
        beta *= m * m / (2.0 * m * (2.0 * m + 1.0));
        let power = |x: f64| std::iter::repeat_n(x, order).product::<f64>();
        let mean = match shape {
            Shape::Parallelogram => beta * (power(sides[0]) + power(sides[1])),
            Shape::Triangle => {
                let weight = |[s, t]: [f64; 2]| {
                    let third = 1.0 - s - t;
                    third * s * sides[0] + third * t * sides[1] + s * t * sides[2]
                };
                nodes.iter().map(|node| node.weight * power(weight(node.at))).sum::<f64>()
            }
        };
        *bound = factorial * (mean / eigenvalues).sqrt() * (1.0 + 1e-12);
    }
    bounds
}

#[cfg(test)]
mod tests {
    use radgrad_scene::largest;

    use super::*;
    use crate::mesh::basis::Basis;

    /// Root mean square of `(g.y)^m` less its projection, with a unit vector g; its `|D^m f|/m!` is at most 1.
    fn rms_remainder(shape: Shape, axes: [DVec3; 2], degree: usize, direction: DVec3, order: usize) -> f64 {
        let basis = Basis::new(shape, degree);
        let nodes = if shape == Shape::Triangle { rule::collapsed(8) } else { rule::product(8) };
        let f = |[s, t]: [f64; 2]| {
            let along = direction.dot(axes[0] * s + axes[1] * t);
            std::iter::repeat_n(along, order).product::<f64>()
        };
        let mut coefficients = vec![0.0; basis.len()];
        for node in &nodes {
            let values = basis.values(node.at);
            coefficients.iter_mut().zip(values).for_each(|(c, v)| *c += node.weight * v * f(node.at));
        }
        let square: f64 = nodes.iter().map(|node| node.weight * f(node.at) * f(node.at)).sum();
        largest(square - coefficients.iter().map(|c| c * c).sum::<f64>(), 0.0).sqrt()
    }

    #[test]
    fn no_power_of_a_coordinate_is_left_by_more_than_the_bound_and_the_next_after_the_basis_nearly_by_it() {
        for shape in [Shape::Parallelogram, Shape::Triangle] {
            for axes in [[DVec3::X, DVec3::Y], [DVec3::new(1.0, 0.3, 0.0), DVec3::new(-0.2, 2.0, 0.0)]] {
                for degree in 0..=4 {
                    let bounds = bounds(shape, axes, degree);
                    for (order, bound) in bounds.into_iter().enumerate().take(degree + 2).skip(1) {
                        let turned = |i: u32| DVec3::new((0.2 * f64::from(i)).cos(), (0.2 * f64::from(i)).sin(), 0.0);
                        let largest_remainder =
                            (0..16).map(|i| rms_remainder(shape, axes, degree, turned(i), order)).fold(0.0, largest);
                        assert!(
                            largest_remainder <= bound * (1.0 + 1e-6),
                            "{shape:?} {degree} {order}: {largest_remainder} {bound}"
                        );
                        assert!(
                            order <= degree || largest_remainder > 0.3 * bound,
                            "{shape:?} {degree} {order}: {largest_remainder} {bound}"
                        );
                    }
                }
            }
        }
    }
}
