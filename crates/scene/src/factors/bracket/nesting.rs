//! Which edges are passed by segments that pass others, between two convex cells.
//!
//! | symbol | meaning |
//! |---|---|
//! | `S_e(x, y)` | T of an edge e ([`crate::factors::screen`]), positive where the segment from x to y passes inside it |
//! | P, Q | any of the functions `S_e`, `-S_e` |
//! | `l` | a number, not negative |
//!
//! P and Q are affine in x and in y, and so is `Q - l P`: if that is not negative at any pair of corners, it is so for no pair of points, and then
//! Q is negative nowhere where P is positive: P implies Q, but for pairs of no measure. Each pair of corners bounds l on one side,
//!
//! `l <= Q/P` where P > 0, `l >= Q/P` where P < 0, and Q >= 0 where P = 0,
//!
//! so such an l is found, or seen not to be there, from one pass over them. An l that is found is tried at all pairs, with bounds on P and Q that rounding
//! cannot pass. So it is proven that
//! - inside a is inside b (`S_a` implies `S_b`): of a shadow that has both edges b leaves nothing out; and a shadow each edge of which is implied
//!   by one of another is around that other one, which hides nothing more: rows of blocks behind a higher one;
//! - inside a is outside b (`S_a` implies `-S_b`): shadows with these edges hide nothing twice, as those of the two sides of a street;
//! - outside a is inside b (`-S_a` implies `S_b`): nothing passes outside both.

use radgrad_core::DVec3;

use super::cell::Cell;
use super::fusion::Group;
use crate::extremes::{largest as larger, smallest as smaller};
use crate::factors::screen::SightedEdge;

/// Pairs of corners up to which edges are compared.
const MOST_PAIRS: usize = 36;

/// Edges above which they are not: pairs of them are compared.
const MOST_EDGES: usize = 100;

/// An edge, and T at all pairs of corners.
#[derive(Debug, Clone)]
pub(super) struct Turns {
    edge: [DVec3; 2],
    least: [f64; MOST_PAIRS],
    most: [f64; MOST_PAIRS],
    /// The pairs that may be inside, and those that may be outside: one bit each.
    inside: u64,
    outside: u64,
    pairs: usize,
}

impl Turns {
    fn new(edge: [DVec3; 2], [a, b]: [&Cell; 2]) -> Self {
        let mut turns = Self {
            edge,
            least: [0.0; MOST_PAIRS],
            most: [0.0; MOST_PAIRS],
            inside: 0,
            outside: 0,
            pairs: a.points.len() * b.points.len(),
        };
        let mut pair = 0;
        for &x in &a.points {
            let seen = SightedEdge::new(edge, x);
            for &y in &b.points {
                let [least, most] = seen.turn_within(y);
                (turns.least[pair], turns.most[pair]) = (least, most);
                turns.inside |= u64::from(most > 0.0) << pair;
                turns.outside |= u64::from(least < 0.0) << pair;
                pair += 1;
            }
        }
        turns
    }

    /// Whether whatever passes inside this edge passes inside another.
    fn is_within(&self, other: &Self) -> bool {
        self.edge == other.edge || self.inside & other.outside == 0 && implies(self.pairs, |k| self.most[k], |k| other.least[k])
    }

    /// Whether nothing passes inside both.
    fn is_apart_from(&self, other: &Self) -> bool {
        let [a, b] = other.edge;
        self.edge == [b, a] || self.inside & other.inside == 0 && implies(self.pairs, |k| self.most[k], |k| -other.most[k])
    }

    /// Whether nothing passes outside both.
    fn covers_with(&self, other: &Self) -> bool {
        let [a, b] = other.edge;
        self.edge == [b, a] || self.outside & other.outside == 0 && implies(self.pairs, |k| -self.least[k], |k| other.least[k])
    }
}

/// Whether P implies Q, which is at most and at least this at pairs of corners.
fn implies(pairs: usize, at_most: impl Fn(usize) -> f64, at_least: impl Fn(usize) -> f64) -> bool {
    let (mut low, mut high) = (0.0, f64::INFINITY);
    for k in 0..pairs {
        let (p, q) = (at_most(k), at_least(k));
        if p > 0.0 {
            high = smaller(high, q / p);
        } else if p < 0.0 {
            low = larger(low, q / p);
        }
        if low > high || (p >= 0.0 && q < 0.0) {
            return false;
        }
    }
    let between = if high.is_finite() { 0.5 * (low + high) } else { 2.0 * low };
    (0..pairs).all(|k| {
        let product = between * at_most(k);
        at_least(k) - product >= 4.0 * f64::EPSILON * product.abs()
    })
}

/// A shadow with what is known of its edges between two cells.
#[derive(Debug)]
pub(super) struct Nested {
    pub(super) edges: Vec<[DVec3; 2]>,
    /// Of each edge, if they were compared.
    turns: Vec<Turns>,
}

impl Nested {
    /// Whether it is proven that all of it is in another.
    fn is_within(&self, other: &Self) -> bool {
        !self.turns.is_empty() && other.turns.iter().all(|b| self.turns.iter().any(|a| a.is_within(b))) && !other.turns.is_empty()
    }

    /// Whether it is proven that it has nothing in common with another.
    pub(super) fn is_apart_from(&self, other: &Self) -> bool {
        self.turns.iter().any(|a| other.turns.iter().any(|b| a.is_apart_from(b)))
    }

    /// Whether it is proven that nothing is outside two of its edges.
    pub(super) fn is_covered_by(&self, [a, b]: [usize; 2]) -> bool {
        self.turns.len() > a.max(b) && self.turns[a].covers_with(&self.turns[b])
    }

    /// Without edges that others imply.
    fn without_implied(mut self) -> Self {
        let mut k = 0;
        while k < self.turns.len() {
            let is_implied = (0..self.turns.len()).any(|other| other != k && self.turns[other].is_within(&self.turns[k]));
            if is_implied {
                self.turns.remove(k);
                self.edges.remove(k);
            } else {
                k += 1;
            }
        }
        self
    }
}

/// The shadows of groups of screens without those that are in others, and the screens of the groups that have one left.
pub(super) fn nest(groups: Vec<Group>, cells: [&Cell; 2]) -> (Vec<Nested>, Vec<usize>) {
    let count: usize = groups.iter().flat_map(|group| &group.shadows).map(Vec::len).sum();
    let is_compared = count > 1 && count <= MOST_EDGES && cells[0].points.len() * cells[1].points.len() <= MOST_PAIRS;
    let mut shadows: Vec<(usize, Nested)> = Vec::new();
    for (group, Group { shadows: of_group, .. }) in groups.iter().enumerate() {
        for edges in of_group {
            let turns = if is_compared { edges.iter().map(|&edge| Turns::new(edge, cells)).collect() } else { Vec::new() };
            shadows.push((group, Nested { edges: edges.clone(), turns }.without_implied()));
        }
    }
    let mut k = 0;
    while k < shadows.len() {
        let is_within = shadows.iter().enumerate().any(|(other, (_, shadow))| other != k && shadows[k].1.is_within(shadow));
        if is_within {
            shadows.remove(k);
        } else {
            k += 1;
        }
    }
    let is_left = |group: usize| shadows.iter().any(|(of, _)| *of == group);
    let members = groups.iter().enumerate().filter(|(group, _)| is_left(*group)).flat_map(|(_, group)| &group.members).copied();
    let mut members: Vec<usize> = members.collect();
    members.sort_unstable();
    (shadows.into_iter().map(|(_, shadow)| shadow).collect(), members)
}

impl Nested {
    /// The region inside one edge.
    #[cfg(test)]
    pub(super) fn alone(edge: [DVec3; 2]) -> Self {
        Self { edges: vec![edge], turns: Vec::new() }
    }
}

#[cfg(test)]
mod tests {
    use super::super::cell::Plane;
    use super::*;
    use crate::factors::tests::draws;

    /// Drawn edges between two drawn cells, and drawn segments, which must pass as is said.
    #[test]
    fn segments_pass_edges_as_is_said_of_all() {
        let mut draw = draws(7);
        let mut uniform = || draw() - 0.5;
        let mut found = [0; 3];
        for _ in 0..4000 {
            let mut cell = |z: f64| {
                let (x, y, size) = (uniform(), uniform(), 0.1 + 0.3 * (uniform() + 0.5));
                let points = [(0.0, 0.0), (size, 0.0), (size, size), (0.0, 0.5 * size)];
                let plane = Plane { normal: DVec3::Z, slope: 1.0, defect: 0.0 };
                Cell::new(points.map(|(u, v)| DVec3::new(x + u, y + v, z + 0.2 * u)).to_vec(), &plane).unwrap()
            };
            let cells = [cell(0.0), cell(1.0)];
            let mut edge = || {
                let corner = |z: f64, x: f64, y: f64| DVec3::new(x, y, z);
                let z = 0.5 + 0.6 * uniform();
                [corner(z, uniform(), uniform()), corner(z + 0.1 * uniform(), uniform(), uniform())]
            };
            let edges = [edge(), edge()];
            let [a, b] = edges.map(|edge| Turns::new(edge, [&cells[0], &cells[1]]));
            let said = [a.is_within(&b), a.is_apart_from(&b), a.covers_with(&b)];
            for _ in 0..20 {
                let [x, y] = [0, 1].map(|k| {
                    let weights = [(); 4].map(|()| uniform() + 0.5);
                    let sum: DVec3 = cells[k].points.iter().zip(weights).map(|(&p, w)| p * w).sum();
                    sum / weights.iter().sum::<f64>()
                });
                let [first, second] = edges.map(|[from, to]| (y - x).dot((to - x).cross(from - x)) > 0.0);
                assert!(!said[0] || !first || second);
                assert!(!said[1] || !first || !second);
                assert!(!said[2] || first || second);
            }
            // An edge that all segments pass on one side says nothing of others.
            let is_open = |turns: &Turns| turns.inside != 0 && turns.outside != 0;
            if is_open(&a) && is_open(&b) {
                found.iter_mut().zip(said).for_each(|(count, said)| *count += usize::from(said));
            }
        }
        assert!(found.iter().all(|&count| count > 20), "{found:?}");
    }
}
