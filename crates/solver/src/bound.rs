//! A bound on the error of a piecewise polynomial radiosity `B_h`, at every point.
//!
//! `B = E + rho G B`, with a kernel that is nowhere negative. With the residual `r = E + rho G B_h - B_h` the error `e = B - B_h`
//! obeys `e = r + rho G e`. So any w with `w >= |r| + rho G w` bounds it, `|e| <= w`, if rho < 1 or light can escape. We take w
//! constant on each leaf.
//!
//! # The residual over a leaf
//! It is computed at the leaf's nodes, with its gradient, from closed forms: `E + rho G B_h` there less its own projection, plus
//! what links neglect and the bounds of the evaluations (proven), plus the difference between `B_h` and the projection, what the
//! solver left (proven, by Bernstein coefficients, all over the leaf). Between nodes it is estimated, `|r| + |grad r| d + H d^2/2`
//! with d the largest distance of a point of the leaf from its nearest node and H the largest difference quotient of the
//! gradients at two nodes. That is exact for residuals that are quadratic, and an estimate for others: a feature of the light
//! that is smaller than an element and lies between its nodes can be missed.
//!
//! # The gather of w
//! From a source that is divided it is at most `F max w` and at most `P mean w` (see [`crate::link`]). Over a leaf it is taken to
//! be at most the largest value at a node plus the difference between the largest and the least one, an estimate. Sweeps start
//! at w = |r|; they stop when they change nothing any more, a part of 1e-5 is added, and the inequality is checked on all leaves.

use rayon::prelude::*;

use crate::field::Field;
use crate::gathering::{Surfaces, irradiance};
use crate::ledger::Ledger;
use crate::link::Link;
use crate::mesh::{Mesh, Sight};

/// Sweeps after which there is no bound: far more than any reflectance below 0.999 needs.
const MOST_SWEEPS: usize = 2000;

/// What is added so that sweeps that are still rising end below.
const MARGIN: f64 = 1e-5;

/// Bounds on each element: of a leaf its own, else the mean and the largest of the leaves below. One for each channel.
#[derive(Debug, Clone, Default)]
pub(crate) struct Bounds {
    pub(crate) mean: Vec<Vec<Ledger>>,
    pub(crate) largest: Vec<Vec<Ledger>>,
    /// The residual of the leaves.
    pub(crate) residual: Vec<Vec<Ledger>>,
}

/// Bound on the residual over a leaf in a channel.
pub(crate) fn residual(mesh: &Mesh, surfaces: &Surfaces, links: &[Link], field: &Field, leaf: usize, channel: usize) -> Ledger {
    let (element, basis) = (&mesh.elements()[leaf], mesh.basis(leaf));
    let (rho, emitted) = (surfaces.reflectance[element.face()][channel], surfaces.emitted[element.face()][channel]);
    let reflected: Vec<[f64; 3]> =
        irradiance(mesh, field, links, channel, basis.nodes().len()).into_iter().map(|h| h.map(|c| rho * c)).collect();
    let projected = basis.project(&reflected.iter().map(|h| h[0]).collect::<Vec<_>>());
    let held = field.of(leaf, channel, basis.len());
    let mut left: Vec<f64> = projected.iter().zip(held).map(|(p, b)| p - b).collect();
    left[0] += emitted;

    let nodes = basis.nodes();
    let remainder = |(node, h): (usize, &[f64; 3])| {
        let (values, slopes) = (basis.at_node(node), basis.slopes(nodes[node].at));
        let value: f64 = values.iter().zip(&projected).map(|(v, p)| v * p).sum();
        let slope = |k: usize| slopes.iter().zip(&projected).map(|(s, p)| s[k] * p).sum::<f64>();
        let slope = element.in_plane([slope(0), slope(1)]);
        [h[0] - value, h[1] - slope[0], h[2] - slope[1]]
    };
    let remainders: Vec<[f64; 3]> = reflected.iter().enumerate().map(remainder).collect();
    let curvature = curvature(&remainders, &nodes.iter().map(|n| element.point(n.at)).collect::<Vec<_>>());
    let reach = element.spacing;
    let at_most = |r: &[f64; 3]| r[0].abs() + r[1].hypot(r[2]) * reach + 0.5 * curvature * reach * reach;
    let discretisation = remainders.iter().map(at_most).fold(0.0, f64::max);

    let (mut computation, mut visibility): (f64, f64) = (0.0, 0.0);
    for node in 0..nodes.len() {
        let (mut neglected, mut clear, mut past) = (0.0, 0.0, 0.0);
        for link in links {
            let row = &link.rows[node];
            neglected += field.neglected(mesh, link.source, link.count, channel, row);
            let coefficients = &field.of(link.source, channel, mesh.basis(link.source).len())[..link.count];
            let size = row.error * coefficients.iter().map(|c| c.abs()).sum::<f64>();
            if matches!(link.sight, Sight::Past(_)) { past += size } else { clear += size }
        }
        // The sums themselves round.
        let summed = 2.0 * f64::EPSILON * links.len() as f64 * (reflected[node][0].abs() + emitted);
        computation = computation.max(rho * (neglected + clear) + summed);
        visibility = visibility.max(rho * past);
    }
    Ledger { modelling: 0.0, discretisation, computation, visibility, solver: basis.magnitude(&left) }
}

/// Largest difference of two gradients over the distance of their nodes.
fn curvature(remainders: &[[f64; 3]], points: &[radgrad_core::DVec3]) -> f64 {
    let pairs = (0..points.len()).flat_map(|i| (0..i).map(move |j| (i, j)));
    let quotient = |(i, j): (usize, usize)| {
        let difference = (remainders[i][1] - remainders[j][1]).hypot(remainders[i][2] - remainders[j][2]);
        difference / (points[i] - points[j]).length()
    };
    pairs.map(quotient).fold(0.0, f64::max)
}

impl Bounds {
    /// Bounds on the error all over the mesh; `None` if no bounded w was found, as where light cannot be lost.
    pub(crate) fn of(mesh: &Mesh, surfaces: &Surfaces, leaves: &[usize], links: &[Vec<Link>], field: &Field) -> Option<Self> {
        let channels = surfaces.reflectance.first().map_or(0, Vec::len);
        let empty = vec![vec![Ledger::default(); channels]; mesh.elements().len()];
        let mut bounds = Self { mean: empty.clone(), largest: empty.clone(), residual: empty };
        let residuals: Vec<Vec<Ledger>> = leaves
            .par_iter()
            .map(|&leaf| (0..channels).map(|c| residual(mesh, surfaces, &links[leaf], field, leaf, c)).collect())
            .collect();
        for (&leaf, residual) in leaves.iter().zip(&residuals) {
            bounds.mean[leaf].clone_from(residual);
            bounds.residual[leaf].clone_from(residual);
        }
        for _ in 0..MOST_SWEEPS {
            bounds.pull(mesh);
            let next = bounds.swept(mesh, surfaces, leaves, links);
            let rises = |(leaf, next): (&usize, &Vec<Ledger>)| {
                next.iter().zip(&bounds.mean[*leaf]).any(|(n, w)| n.total() > w.total() * (1.0 + 0.1 * MARGIN))
            };
            let rising = leaves.iter().zip(&next).any(rises);
            for (&leaf, next) in leaves.iter().zip(next) {
                bounds.mean[leaf] = next;
            }
            if !rising {
                for &leaf in leaves {
                    bounds.mean[leaf].iter_mut().for_each(|w| *w = *w * (1.0 + MARGIN));
                }
                bounds.pull(mesh);
                let check = bounds.swept(mesh, surfaces, leaves, links);
                let holds = |(leaf, next): (&usize, &Vec<Ledger>)| {
                    next.iter().zip(&bounds.mean[*leaf]).all(|(n, w)| n.total() <= w.total())
                };
                if leaves.iter().zip(&check).all(holds) {
                    return Some(bounds);
                }
            }
        }
        None
    }

    /// `|r| + rho G w` on each leaf.
    fn swept(&self, mesh: &Mesh, surfaces: &Surfaces, leaves: &[usize], links: &[Vec<Link>]) -> Vec<Vec<Ledger>> {
        let of_leaf = |&leaf: &usize| {
            let rho = &surfaces.reflectance[mesh.elements()[leaf].face()];
            let of_channel = |(channel, rho): (usize, &f64)| {
                let nodes = mesh.basis(leaf).nodes().len();
                let mut at_nodes = vec![Ledger::default(); nodes];
                for link in &links[leaf] {
                    for (sum, row) in at_nodes.iter_mut().zip(&link.rows) {
                        *sum += self.gathered(link.source, channel, row.values[0][0] + row.error, row.peak);
                    }
                }
                let most = at_nodes.iter().fold(Ledger::default(), |m, h| m.zip(*h, f64::max));
                let least = at_nodes.iter().fold(most, |m, h| m.zip(*h, f64::min));
                self.residual[leaf][channel] + (most * 2.0 + least * -1.0) * *rho
            };
            rho.iter().enumerate().map(of_channel).collect()
        };
        leaves.par_iter().map(of_leaf).collect()
    }

    /// What a point gathers of w at most from a source, from its form factor and the peak of the kernel times the area.
    pub(crate) fn gathered(&self, source: usize, channel: usize, factor: f64, peak: f64) -> Ledger {
        let (mean, largest) = (self.mean[source][channel], self.largest[source][channel]);
        mean.zip(largest, |mean, largest| if largest == 0.0 { 0.0 } else { (factor * largest).min(peak * mean) })
    }

    fn pull(&mut self, mesh: &Mesh) {
        for index in (0..mesh.elements().len()).rev() {
            let channels = self.mean[index].len();
            match mesh.elements()[index].children() {
                None => self.largest[index] = self.mean[index].clone(),
                Some(first) => {
                    for channel in 0..channels {
                        let children = first..first + 4;
                        let sum = children.clone().fold(Ledger::default(), |sum, child| sum + self.mean[child][channel]);
                        self.mean[index][channel] = sum * 0.25;
                        let most = |m: Ledger, child: usize| m.zip(self.largest[child][channel], f64::max);
                        self.largest[index][channel] = children.fold(Ledger::default(), most);
                    }
                }
            }
        }
    }
}
