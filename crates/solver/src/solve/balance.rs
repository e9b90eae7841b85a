//! The balance of exchanges: what one root of the mesh gives another is what that gives it, and what one gives all others is all it has.
//!
//! Receivers gather at nodes, and a node stands for a part of its element. Where something hangs close over an element the few nodes below it
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
//! the same weights for which `sum_Q X_PQ + open_P = A_P`; `open_P`, the part that sees no face, has its own doubt. The links of the receivers of P to
//! sources in Q are multiplied by `X_PQ / g_PQ`. So a light that is constant on each root keeps its energy, to rounding; what is redistributed
//! within a root by the changes of its light, to the error of the rule.

use crate::links::link::Link;
use crate::mesh::Mesh;
use crate::solve::solution::Solution;
use radgrad_scene::{largest, smallest};

/// Roots beyond which exchanges are not balanced.
const MOST_ROOTS: usize = 500;

/// Sweeps of the least squares.
const SWEEPS: usize = 200;

/// The doubt of exchanges on which nodes agree, relative to the smaller area.
const FINE: f64 = 1e-9;

/// The most by which links are multiplied: a face that sees less than that of another one by its nodes is not known to see more of it.
const MOST: f64 = 10.0;

/// Exchanges as one side's nodes find them.
struct Exchanges {
    count: usize,
    areas: Vec<f64>,
    /// For each pair, by the nodes of the first.
    given: Vec<f64>,
    doubt: Vec<f64>,
    /// What sees no face.
    open: Vec<[f64; 2]>,
}

impl Solution {
    /// Balances the links of all receivers.
    pub(super) fn balance(&mut self) {
        let count = self.mesh.roots().len();
        if self.mesh.clusters().root().is_some() || count > MOST_ROOTS || std::env::var("RG_NOBAL").is_ok() {
            return;
        }
        let root_of = roots(&self.mesh);
        let exchanges = self.exchanges(&root_of);
        let balanced = exchanges.balanced();
        if std::env::var("RG_BAL").is_ok() {
            for (k, &lamp) in self.lamps.roots().iter().enumerate() {
                let mut sum = 0.0;
                for leaf in self.mesh.leaves() {
                    let basis = self.mesh.basis(leaf);
                    let v: f64 = self.direct[leaf].nodes.iter().zip(basis.nodes()).map(|(l, n)| n.weight * l.factors[k]).sum();
                    sum += v * self.mesh.elements()[leaf].area();
                }
                let row = root_of[lamp] * count;
                let own: f64 = exchanges.given[row..row + count].iter().sum();
                let given: f64 = (0..count).map(|p| exchanges.given[p * count + root_of[lamp]]).sum();
                eprintln!(
                    "lamp {k} area {} flux by leaves {} ({:+.3} %) by own nodes {own}, by receivers {:+.3} %",
                    self.mesh.elements()[lamp].area(),
                    sum,
                    100.0 * (sum / self.mesh.elements()[lamp].area() - 1.0),
                    100.0 * (given / self.mesh.elements()[lamp].area() - 1.0)
                );
            }
        }
        for &receiver in &self.receivers {
            let row = root_of[receiver] * count;
            for link in &mut self.links[receiver] {
                let pair = row + root_of[link.source];
                let given = exchanges.given[pair];
                link.scale = if given > 0.0 { smallest(balanced[pair] / given, MOST) } else { 1.0 };
            }
        }
    }

    fn exchanges(&self, root_of: &[usize]) -> Exchanges {
        let (mesh, count) = (&self.mesh, self.mesh.roots().len());
        let areas = mesh.roots().iter().map(|&root| mesh.elements()[root].area()).collect();
        let mut found = Exchanges {
            count,
            areas,
            given: vec![0.0; count * count],
            doubt: vec![0.0; count * count],
            open: vec![[0.0; 2]; count],
        };
        for &receiver in &self.receivers {
            let (basis, area, row) = (mesh.basis(receiver), mesh.elements()[receiver].area(), root_of[receiver]);
            let nodes = basis.nodes().len();
            let mut open = vec![1.0; nodes];
            let mean_and_square = |factors: &[f64]| {
                let fitted = basis.project(factors);
                let off = |node: usize| factors[node] - basis.at_node(node).iter().zip(&fitted).map(|(a, b)| a * b).sum::<f64>();
                let square =
                    basis.nodes().iter().enumerate().map(|(node, of)| of.weight.abs() * off(node) * off(node)).sum::<f64>();
                (area * fitted[0], area * area * square)
            };
            let mut links: Vec<&Link> = self.links[receiver].iter().collect();
            links.sort_by_key(|link| root_of[link.source]);
            for same in links.chunk_by(|a, b| root_of[a.source] == root_of[b.source]) {
                let mut factors = vec![0.0; nodes];
                for link in same {
                    factors.iter_mut().zip(&link.rows).for_each(|(factor, row)| *factor += row.values.first().unwrap_or(&0.0));
                }
                open.iter_mut().zip(&factors).for_each(|(open, factor)| *open -= factor);
                let (given, square) = mean_and_square(&factors);
                let pair = row * count + root_of[same[0].source];
                found.given[pair] += given;
                found.doubt[pair] += square;
            }
            let (given, square) = mean_and_square(&open);
            found.open[row] = [found.open[row][0] + given, found.open[row][1] + square];
        }
        found
    }
}

impl Exchanges {
    /// The exchanges that are the same both ways and add up to the areas.
    fn balanced(&self) -> Vec<f64> {
        let &Self { count, .. } = self;
        let (mut exchange, mut freedom) = (vec![0.0; count * count], vec![0.0; count * count]);
        for p in 0..count {
            for q in 0..count {
                let [there, back] = [p * count + q, q * count + p];
                let finest = FINE * smallest(self.areas[p], self.areas[q]);
                let [a, b] = [there, back].map(|pair| 1.0 / (self.doubt[pair] + finest * finest));
                if self.given[there] > 0.0 || self.given[back] > 0.0 {
                    exchange[there] = (a * self.given[there] + b * self.given[back]) / (a + b);
                    freedom[there] = 1.0 / (a + b);
                }
            }
        }
        let missing: Vec<f64> = (0..count)
            .map(|p| self.areas[p] - self.open[p][0] - exchange[p * count..(p + 1) * count].iter().sum::<f64>())
            .collect();
        let mut multipliers = vec![0.0; count];
        for _ in 0..SWEEPS {
            for p in 0..count {
                let row = &freedom[p * count..(p + 1) * count];
                let (others, own): (f64, f64) = (row.iter().zip(&multipliers).map(|(f, m)| f * m).sum(), row.iter().sum());
                let all = own + self.open[p][1];
                if all > 0.0 {
                    multipliers[p] = (missing[p] - others + row[p] * multipliers[p]) / (all + row[p]);
                }
            }
        }
        for p in 0..count {
            for q in 0..count {
                let pair = p * count + q;
                exchange[pair] = largest(exchange[pair] + freedom[pair] * (multipliers[p] + multipliers[q]), 0.0);
            }
        }
        exchange
    }
}

/// For each element the place of its root among roots.
fn roots(mesh: &Mesh) -> Vec<usize> {
    let mut root_of = vec![0; mesh.elements().len()];
    mesh.roots().iter().enumerate().for_each(|(place, &root)| root_of[root] = place);
    // Children come after their parents.
    for (index, element) in mesh.elements().iter().enumerate() {
        if let Some(parent) = element.parent() {
            root_of[index] = root_of[parent];
        }
    }
    root_of
}
