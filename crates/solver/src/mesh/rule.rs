//! Nodes and weights on the two reference shapes: the unit square and the triangle (0,0), (1,0), (0,1).
//!
//! On the square a product of Gauss-Legendre rules, `count` nodes a direction, exact to degree `2 count - 1` in each. On the
//! triangle the symmetric rules of Strang and Fix (1973) and Dunavant (1985) with 3, 6, 12 and 16 nodes, exact to total degree 2,
//! 4, 6 and 8, and beyond them the product rule carried to the triangle. All nodes are inside and no weight is negative; weights sum to one, so that a rule gives means.

use radgrad_scene::gauss_legendre;

use crate::mesh::shape::Shape;

/// One over the plastic number, and over its square: steps of a sequence that fills the square evenly (M. Roberts 2018).
pub(crate) const STEPS: [f64; 2] = [0.754_877_666_246_692_7, 0.569_840_290_998_053_2];

/// A node in reference coordinates and its weight.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Node {
    /// Coordinates `s` and `t`.
    pub at: [f64; 2],
    /// Weight; those of a rule sum to one.
    pub weight: f64,
}

/// The rule that projects on a basis of the given degree: exact for products of two of its functions with one of the next
/// degree, so that the projection's remainder is seen; and three nodes without weight, where the polynomials after that do not
/// vanish as they do at Gauss nodes.
pub(crate) fn for_degree(shape: Shape, degree: usize) -> Vec<Node> {
    let (rule, others) = match shape {
        Shape::Parallelogram => (product(degree + 2), [[0.03, 0.29], [0.71, 0.97], [0.52, 0.47]]),
        Shape::Triangle => {
            (if degree < 4 { triangle(degree + 1) } else { collapsed(degree + 2) }, [[0.03, 0.41], [0.94, 0.03], [0.35, 0.31]])
        }
    };
    rule.into_iter().chain(others.map(|at| Node { at, weight: 0.0 })).collect()
}

/// The fewest nodes that project on a degree: exact for products of two polynomials of it.
pub(crate) fn least_for_degree(shape: Shape, degree: usize) -> Vec<Node> {
    match shape {
        Shape::Parallelogram => product(degree + 1),
        Shape::Triangle if degree == 0 => vec![Node { at: [1.0 / 3.0; 2], weight: 1.0 }],
        Shape::Triangle => triangle(degree),
    }
}

/// The product rule with `count` Gauss nodes a direction.
pub(crate) fn product(count: usize) -> Vec<Node> {
    rectangular(count, count)
}

/// The product rule on the unit square with `along` Gauss nodes in `s` and `across` in `t`.
///
/// ```
/// // s^5 t^3 has the mean 1/24.
/// let mean: f64 = radgrad_solver::rectangular(3, 2).iter().map(|n| n.weight * n.at[0].powi(5) * n.at[1].powi(3)).sum();
/// assert!((mean - 1.0 / 24.0).abs() < 1e-15);
/// ```
#[must_use]
pub fn rectangular(along: usize, across: usize) -> Vec<Node> {
    let (along, across) = (on_unit_interval(along), on_unit_interval(across));
    let pair = |&(t, v): &(f64, f64)| along.iter().map(move |&(s, w)| Node { at: [s, t], weight: v * w }).collect::<Vec<_>>();
    across.iter().flat_map(pair).collect()
}

/// The product rule carried to the triangle by `(s, t) -> (s, (1 - s) t)`: of any order, as a far field needs.
pub(crate) fn collapsed(count: usize) -> Vec<Node> {
    product(count)
        .into_iter()
        .map(|Node { at: [s, t], weight }| Node { at: [s, (1.0 - s) * t], weight: 2.0 * (1.0 - s) * weight })
        .collect()
}

/// Gauss-Legendre nodes and weights on [0, 1].
fn on_unit_interval(count: usize) -> Vec<(f64, f64)> {
    gauss_legendre(count).iter().map(|(x, weight)| (0.5 + 0.5 * x, 0.5 * weight)).collect()
}

/// Symmetric rules: orbits of `(a, a, 1 - 2a)` with their weight, then of `(a, b, 1 - a - b)`.
fn triangle(degree: usize) -> Vec<Node> {
    let three = |a: f64, weight: f64| [[a, a], [1.0 - 2.0 * a, a], [a, 1.0 - 2.0 * a]].map(|at| Node { at, weight }).to_vec();
    let six = |a: f64, b: f64, weight: f64| {
        let c = 1.0 - a - b;
        [[a, b], [b, a], [b, c], [c, b], [c, a], [a, c]].map(|at| Node { at, weight }).to_vec()
    };
    match degree {
        0 | 1 => three(1.0 / 6.0, 1.0 / 3.0),
        2 => [three(0.445_948_490_915_964_9, 0.223_381_589_678_011_5), three(0.091_576_213_509_770_74, 0.109_951_743_655_321_87)]
            .concat(),
        3 => [
            three(0.249_286_745_170_910_42, 0.116_786_275_726_379_37),
            three(0.063_089_014_491_502_23, 0.050_844_906_370_206_82),
            six(0.053_145_049_844_816_945, 0.310_352_451_033_784_4, 0.082_851_075_618_373_57),
        ]
        .concat(),
        _ => [
            vec![Node { at: [1.0 / 3.0; 2], weight: 0.144_315_607_677_787_17 }],
            three(0.459_292_588_292_723_1, 0.095_091_634_267_284_62),
            three(0.170_569_307_751_760_2, 0.103_217_370_534_718_25),
            three(0.050_547_228_317_031, 0.032_458_497_623_198_08),
            six(0.008_394_777_409_957_605, 0.263_112_829_634_638_1, 0.027_230_314_174_434_994),
        ]
        .concat(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shape::moment;

    fn error(shape: Shape, rule: &[Node], powers: [i32; 2]) -> f64 {
        let [i, j] = powers.map(|p| usize::try_from(p).unwrap());
        let sum: f64 = rule.iter().map(|n| n.weight * n.at[0].powi(powers[0]) * n.at[1].powi(powers[1])).sum();
        (sum - moment(shape, i, j)).abs()
    }

    #[test]
    fn every_rule_has_the_degree_it_claims_and_not_the_next() {
        for degree in 0..=4 {
            let square = for_degree(Shape::Parallelogram, degree);
            let exact = i32::try_from(2 * degree + 3).unwrap();
            for i in 0..=exact {
                for j in 0..=exact {
                    assert!(error(Shape::Parallelogram, &square, [i, j]) < 1e-15);
                }
            }
            assert!(error(Shape::Parallelogram, &square, [exact + 1, 0]) > 1e-8);
            let triangle = for_degree(Shape::Triangle, degree);
            let exact = [2, 4, 6, 8, 10][degree];
            for i in 0..=exact {
                for j in 0..=exact - i {
                    assert!(
                        error(Shape::Triangle, &triangle, [i, j]) < 1e-14,
                        "{degree} {i} {j} {:e}",
                        error(Shape::Triangle, &triangle, [i, j])
                    );
                }
            }
            assert!((0..=exact + 1).any(|i| error(Shape::Triangle, &triangle, [i, exact + 1 - i]) > 1e-8));
            for node in square.iter().chain(&triangle) {
                assert!(node.weight >= 0.0 && node.at.iter().all(|c| (0.0..=1.0).contains(c)));
            }
            assert!(triangle.iter().all(|n| n.at[0] + n.at[1] < 1.0));
        }
        for i in 0..=8 {
            for j in 0..=8 - i {
                assert!(error(Shape::Triangle, &collapsed(5), [i, j]) < 1e-15);
            }
        }
    }
}
