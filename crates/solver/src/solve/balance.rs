//! The balance of exchanges: what one root of the mesh gives another is what that gives it, and what one gives all others is all it has.
//!
//! Receivers gather at nodes, and a node stands for a part of its element. Where something hangs over an element the few nodes below it
//! stand for too much or too little, and what a face gets too little of is lost: in a room that reflects rho, `1/(1 - rho)` times. But the
//! other face of the exchange sees the same from afar, and its nodes agree with each other. So for two roots P and Q, with
//!
//! | symbol | meaning |
//! |---|---|
//! | `A_P` | the area of P |
//! | `g_PQ` | `A_P` times the mean over P, by its receivers' nodes, of the form factor to all of Q |
//! | `u_PQ` | what the nodes' factors differ by from the polynomials that receivers project them on, times area, in the root mean square |
//!
//! the exchange `X_PQ = X_QP` is the mean of `g_PQ` and `g_QP`, weighted by the inverse squares of u, and then changed by the least squares over
//! the same weights for which `sum_Q X_PQ + open_P = A_P`; `open_P`, the part that sees no face, has its own doubt. What a link of a receiver of P to
//! a source in Q gathers of a constant c is then that of `c + (X_PQ / g_PQ - 1)(c - b)` with b the mean radiosity of P: since the changes
//! of a row add up to 0, this is the energy that the exchanges say, and even light stays even at every node. Light of lamps is projected at the
//! nodes of leaves, so that these are g for a lamp, and what they see of it is multiplied by `X_PQ / g_PQ`. So a light that is constant on each
//! root keeps its energy, to the rounding of sums; what changes of it within a root redistribute keeps it to the error of the rule.

use radgrad_scene::{largest, smallest};

use crate::links::link::Link;
use crate::mesh::basis::Basis;
use crate::solve::solution::Solution;

/// Roots beyond which exchanges are not balanced.
const MOST_ROOTS: usize = 500;

/// Sweeps of the least squares.
const SWEEPS: usize = 200;

/// The doubt of exchanges on which nodes agree, relative to the smaller area.
const FINE: f64 = 1e-9;

/// The most by which light is multiplied: a face that sees less than that of another one by its nodes is not known to see more of it.
const MOST: f64 = 10.0;

/// Exchanges as the nodes of one side find them.
#[derive(Debug, Clone, Copy, Default)]
struct Given {
    /// The area times the mean factor.
    exchange: f64,
    /// The square of what that may be off by.
    doubt: f64,
}

impl Given {
    /// Adds what the nodes of an element of this area find.
    fn add(&mut self, basis: &Basis, area: f64, factors: &[f64]) {
        let fitted = basis.project(factors);
        let off = |node: usize| factors[node] - basis.at_node(node).iter().zip(&fitted).map(|(a, b)| a * b).sum::<f64>();
        let square: f64 = basis.nodes().iter().enumerate().map(|(node, of)| of.weight * off(node) * off(node)).sum();
        self.exchange += area * fitted[0];
        self.doubt += area * area * largest(square, 0.0);
    }
}

/// The exchanges of all roots: for each pair by the nodes of the first, and of each what sees no face.
struct Exchanges {
    areas: Vec<f64>,
    pairs: Vec<Given>,
    open: Vec<Given>,
}

impl Solution {
    /// Balances the links of all receivers and the light of lamps on all leaves.
    pub(super) fn balance(&mut self) {
        let count = self.mesh.roots().len();
        if self.mesh.clusters().root().is_some() || count > MOST_ROOTS {
            return;
        }
        let by_links = self.exchanges_by_links();
        let mut given = Exchanges { areas: by_links.areas.clone(), pairs: by_links.pairs.clone(), open: by_links.open.clone() };
        let by_leaves = self.exchanges_with_lamps();
        for (place, of) in by_leaves.iter().enumerate() {
            given.pairs[place / self.lamps.roots().len() * count + self.lamps.roots()[place % self.lamps.roots().len()]] = *of;
        }
        let balanced = given.balanced();
        let scale =
            |given: &Given, pair: usize| if given.exchange > 0.0 { smallest(balanced[pair] / given.exchange, MOST) } else { 1.0 };
        for &receiver in &self.receivers {
            let row = self.mesh.root_of(receiver) * count;
            for link in &mut self.links[receiver] {
                let pair = row + self.mesh.root_of(link.source);
                link.balance = scale(&by_links.pairs[pair], pair) - 1.0;
            }
        }
        let lamps = self.lamps.roots();
        let of_lamp = |(place, of): (usize, &Given)| scale(of, place / lamps.len() * count + lamps[place % lamps.len()]);
        let scales = by_leaves.iter().enumerate().map(of_lamp).collect();
        self.scale_lamps(scales);
    }

    /// The exchanges by links, which begin at roots.
    fn exchanges_by_links(&self) -> Exchanges {
        let (mesh, count) = (&self.mesh, self.mesh.roots().len());
        let areas = mesh.roots().iter().map(|&root| mesh.elements()[root].area()).collect();
        let mut found = Exchanges { areas, pairs: vec![Given::default(); count * count], open: vec![Given::default(); count] };
        for &receiver in &self.receivers {
            let (basis, area, row) = (mesh.basis(receiver), mesh.elements()[receiver].area(), mesh.root_of(receiver));
            let mut open = vec![1.0; basis.nodes().len()];
            let mut links: Vec<(usize, &Link)> =
                self.links[receiver].iter().map(|link| (mesh.root_of(link.source), link)).collect();
            links.sort_by_key(|(root, _)| *root);
            for same in links.chunk_by(|a, b| a.0 == b.0) {
                let mut factors = vec![0.0; open.len()];
                for (_, link) in same {
                    factors.iter_mut().zip(&link.rows).for_each(|(factor, row)| *factor += row.values.first().unwrap_or(&0.0));
                }
                open.iter_mut().zip(&factors).for_each(|(open, factor)| *open -= factor);
                found.pairs[row * count + same[0].0].add(basis, area, &factors);
            }
            found.open[row].add(basis, area, &open);
        }
        found
    }

    /// The exchanges of all roots with each lamp, by the nodes of leaves.
    fn exchanges_with_lamps(&self) -> Vec<Given> {
        let lamps = self.lamps.roots().len();
        if self.direct.is_empty() {
            return Vec::new();
        }
        let mut found = vec![Given::default(); self.mesh.roots().len() * lamps];
        for leaf in self.mesh.leaves() {
            let (basis, area, row) = (self.mesh.basis(leaf), self.mesh.elements()[leaf].area(), self.mesh.root_of(leaf));
            for lamp in 0..lamps {
                let factors: Vec<f64> = self.direct[leaf].nodes.iter().map(|lit| lit.factors[lamp]).collect();
                found[row * lamps + lamp].add(basis, area, &factors);
            }
        }
        found
    }
}

impl Exchanges {
    /// The exchanges that are the same both ways and add up to the areas.
    fn balanced(&self) -> Vec<f64> {
        let count = self.areas.len();
        let (mut exchange, mut freedom) = (vec![0.0; count * count], vec![0.0; count * count]);
        for p in 0..count {
            for q in 0..count {
                let pair = p * count + q;
                let [there, back] = [self.pairs[pair], self.pairs[q * count + p]];
                let finest = FINE * smallest(self.areas[p], self.areas[q]);
                let [a, b] = [there, back].map(|given| 1.0 / (given.doubt + finest * finest));
                if there.exchange > 0.0 || back.exchange > 0.0 {
                    exchange[pair] = (a * there.exchange + b * back.exchange) / (a + b);
                    freedom[pair] = 1.0 / (a + b);
                }
            }
        }
        let row = |p: usize| p * count..(p + 1) * count;
        let missing = |p: usize| self.areas[p] - self.open[p].exchange - exchange[row(p)].iter().sum::<f64>();
        let missing: Vec<f64> = (0..count).map(missing).collect();
        // By Gauss and Seidel, one multiplier for each root.
        let mut multipliers = vec![0.0; count];
        for _ in 0..SWEEPS {
            for p in 0..count {
                let (free, own) = (&freedom[row(p)], freedom[p * count + p]);
                let others = free.iter().zip(&multipliers).map(|(f, m)| f * m).sum::<f64>() - own * multipliers[p];
                let all = free.iter().sum::<f64>() + own + self.open[p].doubt;
                if all > 0.0 {
                    multipliers[p] = (missing[p] - others) / all;
                }
            }
        }
        for (pair, (exchange, freedom)) in exchange.iter_mut().zip(&freedom).enumerate() {
            *exchange = largest(*exchange + freedom * (multipliers[pair / count] + multipliers[pair % count]), 0.0);
        }
        exchange
    }
}
