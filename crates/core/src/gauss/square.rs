//! The products of a Gauss rule with itself on a triangle, all nodes in one row: few nodes leave few lanes idle.
//!
//! A node of the rule on the square, (a, b), is the point with the barycentric coordinates `1 - a`, `a (1 - b)` and `a b`, and
//! its weight is a times the product of the two. For a and b as rounded each coordinate errs by 2u of itself, the weight by 5u
//! with the roundings of the rule.

use crate::gauss::rules::{LANES, MOST, rule};

/// So many sets of lanes hold the products of the rules with 1, 2, ... nodes.
const SETS: [usize; MOST] = {
    let mut sets = [0; MOST];
    let mut i = 0;
    while i < MOST {
        sets[i] = ((i + 1) * (i + 1)).div_ceil(LANES);
        i += 1;
    }
    sets
};

const ALL: usize = first_set(MOST + 1);

/// Where those with `count` nodes in one variable start.
const fn first_set(count: usize) -> usize {
    let (mut first, mut i) = (0, 0);
    while i + 1 < count {
        first += SETS[i];
        i += 1;
    }
    first
}

/// Nodes side by side; nodes of weight 0 fill the lanes up.
#[derive(Debug, Clone, Copy)]
pub(super) struct Nodes {
    /// `1 - a`, `a (1 - b)` and `a b`.
    pub(super) barycentric: [[f64; LANES]; 3],
    /// `a`.
    pub(super) along: [f64; LANES],
    pub(super) weights: [f64; LANES],
}

static PRODUCTS: [Nodes; ALL] = {
    let third = 1.0 / 3.0;
    let filling = Nodes { barycentric: [[third; LANES]; 3], along: [2.0 * third; LANES], weights: [0.0; LANES] };
    let mut products = [filling; ALL];
    let mut count = 1;
    while count <= MOST {
        let rule = rule(count);
        let mut k = 0;
        while k < count * count {
            let ((a, b), weight) =
                ((rule.nodes[k / count], rule.nodes[k % count]), rule.weights[k / count] * rule.weights[k % count]);
            let nodes = &mut products[first_set(count) + k / LANES];
            nodes.barycentric[0][k % LANES] = 1.0 - a;
            nodes.barycentric[1][k % LANES] = a * (1.0 - b);
            nodes.barycentric[2][k % LANES] = a * b;
            nodes.along[k % LANES] = a;
            nodes.weights[k % LANES] = weight * a;
            k += 1;
        }
        count += 1;
    }
    products
};

/// Sets of lanes that hold the products of the rule with `count` nodes.
pub(super) const fn sets(count: usize) -> usize {
    SETS[count - 1]
}

/// The nodes with `count`, 1 to [`MOST`], in each variable.
#[inline]
pub(super) fn square(count: usize) -> &'static [Nodes] {
    &PRODUCTS[first_set(count)..first_set(count) + SETS[count - 1]]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_product_integrates_the_monomials_it_must() {
        for count in 1..=MOST {
            for (p, q) in (0..2 * count - 1).flat_map(|p| (0..2 * count - 1 - p).map(move |q| (p, q))) {
                let power = |x: f64, n: usize| (0..n).fold(1.0, |power, _| power * x);
                let sum: f64 = square(count)
                    .iter()
                    .flat_map(|nodes| (0..LANES).map(|i| (nodes.barycentric.map(|row| row[i]), nodes.weights[i])))
                    .map(|([_, first, last], weight)| weight * power(first, p) * power(last, q))
                    .sum();
                // p! q! / (p + q + 2)!
                let exact: f64 = (1..=q).fold(1.0, |f, i| f * i as f64 / (p + i) as f64) / ((p + q + 1) * (p + q + 2)) as f64;
                assert!((sum / exact - 1.0).abs() < 1e-14, "{count} nodes, powers {p} and {q}: {sum} {exact}");
            }
        }
    }
}
