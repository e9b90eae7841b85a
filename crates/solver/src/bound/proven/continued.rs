//! How far from a polynomial that is which a parallelogram receives of a source, by its continuation to complex places.
//!
//! | symbol | meaning |
//! |---|---|
//! | `c`, `u`, `v` | centre and half the axes of the parallelogram, whose places are `x = c + s u + t v` with s and t in [-1, 1] |
//! | `E` | the ellipse of all complex s with the foci -1 and 1 and the half axes a and b, `a + b = r` |
//! | `n1`, `n2` | normals of the parallelogram and of the source |
//! | `f` | the irradiance of a source that is wholly seen |
//!
//! Inside E, f continued in s from a real t is `1/pi int B (n1.(y - x)) (n2.(x - y)) / R^4 dy`, `R^2 = (y - x).(y - x)`, analytic while
//! R is not 0. The first product does not change with s; the second is at most `|n2.(c - y)| + a |n2.u| + |n2.v|`, as `|s| <= a`. With
//! `s = w + i q`, `w^2/a^2 + q^2/b^2 <= 1`, and any unit vector n
//!
//! ```text
//! |R^2| >= Re R^2 = |y - c - w u - t v|^2 - q^2 |u|^2 >= (A - |w| k)^2 - (1 - w^2/a^2) b^2 |u|^2 = D^2,     A = n.(y - c) - |n.v|,  k = |n.u|
//! ```
//!
//! if A is at least a k; the least over w in [-a, a] is there, or at `w = k A / (k^2 + b^2 |u|^2 / a^2)`. So f is at most
//! `M = max|B| area (n1.(y - x)) (n2.(x - y)) / (pi D^4)` inside E, and the part of its Chebyshev series up to degree m in s is off by at
//! most `2 M r^-m / (r - 1)` (L. N. Trefethen, Approximation Theory and Approximation Practice, 2013, theorem 8.2): this is the error `e_s`;
//! `e_t` is the same in t. Cutting a function's series at degree m enlarges the function by at most `L = 4/pi^2 ln(m + 1) + 3` (theorem 15.3).
//! So a polynomial of degree m in s and in t differs from f by at most `e_s + L e_t`, and another one by at most `L e_s + e_t`.
//!
//! Taylor's series needs a ball around c without a singularity; the series in s needs an ellipse around [-1, 1] without one. A parallelogram
//! that is longer than its distance from the source has no such ball, but such an ellipse.

use std::f64::consts::PI;

use radgrad_scene::{largest, smallest};

use super::nodes::ROUNDED;
use super::terms::Target;
use crate::mesh::element::Element;

/// Sums of half axes of the ellipses that are tried.
const ELLIPSES: [f64; 10] = [1.3, 1.7, 2.2, 3.0, 4.0, 6.0, 9.0, 14.0, 24.0, 48.0];

/// For each axis and ellipse, twice a bound on the irradiance inside it over `r - 1`, for a radiosity of at most 1; infinite where there is none.
#[derive(Debug)]
pub(super) struct Continued([[f64; ELLIPSES.len()]; 2]);

impl Continued {
    pub(super) fn of(target: &Target<'_>, source: &Element) -> Self {
        let (centre, vertices) = (target.element.centre(), source.polygon().vertices());
        let (n1, n2) = (target.element.polygon().normal(), source.polygon().normal());
        let over = vertices.iter().map(|&y| target.height(y)).fold(0.0, largest);
        let half = target.element.axes().map(|axis| axis * 0.5);
        let between = (source.centre() - centre).normalize_or_zero();
        let unit = source.area() * over / PI;
        let of_axis = |axis: usize| {
            let (u, v) = (half[axis], half[1 - axis]);
            let size = largest(u.length_squared(), f64::MIN_POSITIVE);
            let directions = [n1, -n2, between].map(|n| {
                let nearest = vertices.iter().map(|&y| n.dot(y - centre)).fold(f64::INFINITY, smallest);
                // Directions are unit vectors but for rounding.
                ((nearest - n.dot(v).abs()) / ROUNDED, n.dot(u).abs() * ROUNDED)
            });
            ELLIPSES.map(|r| {
                let [a, b] = [0.5 * (r + 1.0 / r), 0.5 * (r - 1.0 / r)];
                let square = directions.iter().map(|of| apart(*of, a, b * b * size)).fold(0.0, largest);
                if square <= 0.0 {
                    return f64::INFINITY;
                }
                let behind = n2.dot(centre - source.centre()).abs() + a * n2.dot(u).abs() + n2.dot(v).abs();
                2.0 * unit * behind / (square * square * (r - 1.0)) * ROUNDED
            })
        };
        Self([of_axis(0), of_axis(1)])
    }

    /// What a polynomial of a degree in each coordinate leaves at most, for a radiosity of at most 1.
    pub(super) fn beyond(&self, degree: usize) -> f64 {
        let in_axis = |of: &[f64; ELLIPSES.len()]| {
            let power = |r: f64| std::iter::repeat_n(1.0 / r, degree).product::<f64>();
            of.iter().zip(ELLIPSES).map(|(of, r)| of * power(r)).fold(f64::INFINITY, smallest)
        };
        let [s, t] = [in_axis(&self.0[0]), in_axis(&self.0[1])];
        let enlarged = 4.0 / (PI * PI) * (degree as f64 + 1.0).ln() + 3.0;
        (largest(s, t) + enlarged * smallest(s, t)) * ROUNDED
    }
}

/// The least of `(A - w k)^2 - (1 - w^2/a^2) q` for w in [0, a]; 0 where A is less than `a k`.
fn apart((nearest, along): (f64, f64), a: f64, imaginary: f64) -> f64 {
    if nearest <= a * along {
        return 0.0;
    }
    let at = |w: f64| (nearest - w * along) * (nearest - w * along) - (1.0 - w * w / (a * a)) * imaginary;
    let turn = along * nearest / (along * along + imaginary / (a * a));
    let value = if turn < a { at(turn) } else { at(a) };
    // The difference rounds as its larger terms do.
    value - 1e-13 * (nearest * nearest + imaginary)
}

#[cfg(test)]
mod tests {
    use radgrad_core::{DVec3, Polygon};
    use radgrad_scene::gauss_legendre;

    use super::super::nodes::Nodes;
    use super::*;
    use crate::mesh::basis::Basis;
    use crate::mesh::shape::Shape;

    /// What the best polynomials leave in the root mean square, of the kernel of a small source by the midpoint of each of its cells, is no more
    /// than the bound, whatever the places of the two; and where a long element faces a long source the bound falls and Taylor's does not.
    #[test]
    fn polynomials_in_each_coordinate_leave_no_more_than_the_bound() {
        let bases = [Shape::Parallelogram, Shape::Triangle].map(|shape| Basis::new(shape, 1));
        let nodes = Nodes::of(&bases[0]);
        let places: Vec<[f64; 2]> = bases[0].nodes().iter().map(|node| node.at).collect();
        let element = |corner: DVec3, u: DVec3, v: DVec3| {
            let polygon = Polygon::new(vec![corner, corner + u, corner + u + v, corner + v]).unwrap();
            Element::of_face(&polygon, 0, &bases).unwrap().remove(0)
        };
        let rule: Vec<(f64, f64)> = gauss_legendre(24).iter().map(|(x, weight)| (*x, 0.5 * weight)).collect();
        let legendre = |n: usize, x: f64| -> f64 {
            let (mut before, mut now) = (1.0, x);
            for k in 1..n {
                let k = k as f64;
                (before, now) = (now, ((2.0 * k + 1.0) * x * now - k * before) / (k + 1.0));
            }
            (2.0 * n as f64 + 1.0).sqrt() * if n == 0 { 1.0 } else { now }
        };
        let (mut sharpest, mut finite) = (0.0_f64, 0);
        for k in 0..60_u32 {
            let unit = |j: u32| (f64::from(k) * 0.618_033_988_749_895 * f64::from(j) + 0.1 * f64::from(j)).fract();
            let to = element(DVec3::ZERO, DVec3::X * (0.2 + unit(1)), DVec3::new(0.3 * unit(2), 0.5 + 2.0 * unit(3), 0.0));
            let turned = DVec3::new(-0.3 + unit(4), 0.2, 0.6 * unit(5) - 0.3);
            let from = element(DVec3::new(unit(6) - 0.5, 2.0 * unit(7), 0.5 + unit(8)), DVec3::Y * (0.2 + unit(9)), turned);
            let target = Target::of(&to, &places, &nodes);
            let (n1, n2) = (to.polygon().normal(), from.polygon().normal());
            let cell = |i: u32, j: u32| from.point([(f64::from(i) + 0.5) / 4.0, (f64::from(j) + 0.5) / 4.0]);
            let cells: Vec<DVec3> = (0..4).flat_map(|i| (0..4).map(move |j| (i, j))).map(|(i, j)| cell(i, j)).collect();
            let gathered = |x: f64, y: f64| -> f64 {
                let at = to.point([0.5 + 0.5 * x, 0.5 + 0.5 * y]);
                let of = |y: &DVec3| n1.dot(*y - at) * n2.dot(at - *y) / (*y - at).length_squared().powi(2);
                cells.iter().map(of).sum::<f64>() * from.area() / (16.0 * PI)
            };
            let values: Vec<Vec<f64>> = rule.iter().map(|(x, _)| rule.iter().map(|(y, _)| gathered(*x, *y)).collect()).collect();
            let all = || (0..rule.len()).flat_map(|i| (0..rule.len()).map(move |j| (i, j)));
            let square: f64 = all().map(|(i, j)| rule[i].1 * rule[j].1 * values[i][j].powi(2)).sum();
            let coefficient = |m: usize, n: usize| -> f64 {
                let of = |(i, j): (usize, usize)| {
                    rule[i].1 * rule[j].1 * values[i][j] * legendre(m, rule[i].0) * legendre(n, rule[j].0)
                };
                all().map(of).sum()
            };
            let continued = Continued::of(&target, &from);
            for degree in 1..6 {
                let held: f64 =
                    (0..=degree).flat_map(|m| (0..=degree).map(move |n| (m, n))).map(|(m, n)| coefficient(m, n).powi(2)).sum();
                let (left, bound) = (largest(square - held, 0.0).sqrt(), continued.beyond(degree));
                assert!(left <= bound + 1e-8, "{k} {degree}: {left:e} {bound:e}");
                finite += usize::from(bound.is_finite());
                sharpest = largest(sharpest, if left > 1e-7 { left / bound } else { 0.0 });
            }
        }
        assert!(finite > 250 && sharpest > 0.01, "{finite} {sharpest}");

        let to = element(DVec3::ZERO, DVec3::X * 0.25, DVec3::Y * 2.0);
        let from = element(DVec3::new(0.0, 0.0, 0.7), DVec3::Y * 2.0, DVec3::X * 0.25);
        let target = Target::of(&to, &places, &nodes);
        assert!(target.beyond_of_any(&from, 11).is_infinite() && Continued::of(&target, &from).beyond(30) < 1e-4);
    }
}
