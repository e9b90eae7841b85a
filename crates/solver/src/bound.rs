//! Bounds on the error, at every point.
//!
//! `B = E + rho G B`, with a kernel that is nowhere negative. Let `B_h` be the piecewise polynomial radiosity, `B_g = E + rho G
//! B_h` what one exact gather makes of it, and `r = B_g - B_h` the residual ([`crate::residual`]). The error of the gather obeys
//! `B - B_g = rho G (B - B_g) + rho G r`. So any w with `w >= rho |G r| + rho G w` bounds it, and `|B - B_h| <= w + |r|`. We take
//! w on each leaf a constant times the reflectance.
//!
//! # The gather of the residual
//! From a source, at a point with form factor F, with P and S the largest value and the largest slope of the kernel times the
//! area (infinite S past occluders): `|G r|` is at most `F max|r|`, and `P (mean|r| + |mean r|)/2`, since a constant may be
//! taken from the kernel; and `S mean(radius |r|) + P |mean r|`, since the kernel may be replaced by its value at the centre of
//! each leaf. The last is what makes an oscillating residual count for little.
//!
//! # The gather of w
//! From a source that is divided it is at most `F max w` and at most `P mean w`. A leaf's w is the largest of those at its nodes;
//! as an average over the leaf with a positive kernel is meant, that is an estimate of the same kind as the residual's. Where w
//! stands for a bound at every point of the leaf, the difference between the largest and the least at the nodes is added.
//! Sweeps start at 0; they stop when they rise by less than a thousandth, a fiftieth is added, and the inequality is checked at
//! all nodes.

use rayon::prelude::*;

use crate::field::Field;
use crate::ledger::Ledger;
use crate::link::Link;
use crate::mesh::Mesh;
use crate::residual::Residual;
use crate::surfaces::Surfaces;
use crate::transfer::Row;

/// Sweeps after which there is no bound: far more than any reflectance below 0.99 needs.
const MOST_SWEEPS: usize = 2000;

/// What is added, as a part, so that sweeps that still rise by a little end below.
const MARGIN: f64 = 0.02;

/// How much they may still rise, as a part.
const RISE: f64 = 1e-3;

/// Bounds on each element: of a leaf its own, else those over the leaves below. One for each channel.
#[derive(Debug, Clone, Default)]
pub(crate) struct Bounds {
    /// Mean and largest bound on the error of a gather.
    pub(crate) mean: Vec<Vec<Ledger>>,
    pub(crate) largest: Vec<Vec<Ledger>>,
    /// What the bound at a leaf's nodes varies by.
    pub(crate) variation: Vec<Vec<Ledger>>,
    pub(crate) residual: Vec<Vec<Residual>>,
}

impl Bounds {
    /// Bounds on the error all over the mesh; `None` if no bounded w was found, as where light cannot be lost.
    pub(crate) fn of(mesh: &Mesh, surfaces: &Surfaces, leaves: &[usize], links: &[Vec<Link>], field: &Field) -> Option<Self> {
        let channels = surfaces.reflectance.first().map_or(0, Vec::len);
        let empty = vec![vec![Ledger::default(); channels]; mesh.elements().len()];
        let residual = vec![vec![Residual::default(); channels]; mesh.elements().len()];
        let mut bounds = Self { mean: empty.clone(), largest: empty.clone(), variation: empty, residual };
        let of_leaf = |&leaf: &usize| -> Vec<Residual> {
            (0..channels).map(|channel| Residual::of(mesh, surfaces, &links[leaf], field, leaf, channel)).collect()
        };
        let residuals: Vec<Vec<Residual>> = leaves.par_iter().map(of_leaf).collect();
        for (&leaf, residual) in leaves.iter().zip(residuals) {
            bounds.residual[leaf] = residual;
        }
        for index in (0..mesh.elements().len()).rev() {
            if let Some(first) = mesh.elements()[index].children() {
                for channel in 0..channels {
                    let children = [0, 1, 2, 3].map(|child| bounds.residual[first + child][channel]);
                    bounds.residual[index][channel] = Residual::over(&children);
                }
            }
        }
        for _ in 0..MOST_SWEEPS {
            let next = bounds.swept(mesh, surfaces, leaves, links);
            let rises = |(leaf, next): (&usize, &Vec<[Ledger; 2]>)| {
                next.iter().zip(&bounds.mean[*leaf]).any(|([n, _], w)| n.total() > w.total() * (1.0 + RISE))
            };
            let rising = leaves.iter().zip(&next).any(rises);
            let margin = if rising { 1.0 } else { 1.0 + MARGIN };
            for (&leaf, next) in leaves.iter().zip(next) {
                bounds.mean[leaf] = next.iter().map(|w| w[0] * margin).collect();
                bounds.variation[leaf] = next.iter().map(|w| w[1]).collect();
            }
            bounds.pull(mesh, surfaces);
            if !rising {
                let check = bounds.swept(mesh, surfaces, leaves, links);
                let holds = |(leaf, next): (&usize, &Vec<[Ledger; 2]>)| {
                    next.iter().zip(&bounds.mean[*leaf]).all(|([n, _], w)| n.total() <= w.total())
                };
                if leaves.iter().zip(&check).all(holds) {
                    return Some(bounds);
                }
            }
        }
        None
    }

    /// `rho |G r| + rho G w` on each leaf: the largest at a node, and by how much the least is less.
    fn swept(&self, mesh: &Mesh, surfaces: &Surfaces, leaves: &[usize], links: &[Vec<Link>]) -> Vec<Vec<[Ledger; 2]>> {
        let of_leaf = |&leaf: &usize| {
            let of_channel = |channel: usize| {
                let [rho, largest] = surfaces.reflectance_on(mesh, leaf, channel);
                let mut at_nodes = vec![Ledger::default(); mesh.basis(leaf).nodes().len()];
                for link in &links[leaf] {
                    for (sum, row) in at_nodes.iter_mut().zip(&link.rows) {
                        *sum += self.gathered(link.source, channel, row);
                    }
                }
                let most = at_nodes.iter().fold(Ledger::default(), |m, h| m.zip(*h, f64::max));
                let least = at_nodes.iter().fold(most, |m, h| m.zip(*h, f64::min));
                [most * rho, (most + least * -1.0) * largest]
            };
            (0..self.mean[leaf].len()).map(of_channel).collect()
        };
        leaves.par_iter().map(of_leaf).collect()
    }

    /// What a point gathers at most from a source of the residual and of w.
    pub(crate) fn gathered(&self, source: usize, channel: usize, row: &Row) -> Ledger {
        let (mean, largest, residual) =
            (self.mean[source][channel], self.largest[source][channel], &self.residual[source][channel]);
        let factor = row.values.first().map_or(0.0, |f| f.max(0.0) + row.error);
        // Where something is 0, nothing times a peak that is infinite.
        let least = |factor: f64, largest: f64, others: [f64; 2]| {
            if largest == 0.0 || factor == 0.0 { 0.0 } else { others.into_iter().fold(factor * largest, f64::min) }
        };
        let halved = 0.5 * row.peak * (residual.mean + residual.bias);
        let centred = row.slope * residual.arm + row.peak * residual.bias;
        let oscillating = least(factor, residual.largest.discretisation, [halved, centred]);
        let rest = Ledger { discretisation: 0.0, ..residual.largest };
        let of_bound = mean.zip(largest, |mean, largest| least(factor, largest, [row.peak * mean, f64::INFINITY]));
        of_bound + rest * factor + Ledger { discretisation: oscillating, ..Ledger::default() }
    }

    fn pull(&mut self, mesh: &Mesh, surfaces: &Surfaces) {
        for index in (0..mesh.elements().len()).rev() {
            match mesh.elements()[index].children() {
                None => {
                    let largest = |(channel, w): (usize, &Ledger)| {
                        let [mean, largest] = surfaces.reflectance_on(mesh, index, channel);
                        if largest > mean { *w * (largest / mean) } else { *w }
                    };
                    self.largest[index] = self.mean[index].iter().enumerate().map(largest).collect();
                }
                Some(first) => {
                    for channel in 0..self.mean[index].len() {
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
