//! The proven bound of a round.

use rayon::prelude::*;

use crate::bound::ledger::Ledger;
use crate::bound::proven::{Proven, Rest, Solved};
use crate::solve::options::{Options, RelativeTo};
use crate::solve::solution::Solution;

impl Solution {
    /// Whether what was asked for is reached.
    pub(super) fn reached(&self, options: &Options) -> bool {
        // Where light may be reflected and none was found, nothing is known relative to it.
        let is_found = |(reflected, estimate): (&f64, &Ledger)| *reflected > 0.0 || estimate.total() == 0.0;
        let found = options.relative_to == RelativeTo::All || self.reflected.iter().zip(&self.bounds.mean).all(is_found);
        found
            && match options.bound {
                Some(bound) => self.progress.bound <= bound,
                None => self.progress.estimate <= options.error,
            }
    }

    /// The proven bound on the error of the mean over what errors are relative to, the largest of the channels.
    pub(super) fn prove(&mut self) -> f64 {
        self.prove_direct();
        if self.proven().is_none() {
            // What takes too long is not proven, nor what no bound on form factors says is lost.
            return f64::INFINITY;
        }
        self.relative(&self.mean_bound())
    }

    /// The proven bounds, if there are any.
    pub(crate) fn proven(&self) -> Option<&Proven> {
        let prove = || {
            if self.clock.is_over() {
                return None;
            }
            let of_leaf = |leaf: usize| match self.proven_direct.get(leaf) {
                Some(Some(known)) => known.clone(),
                _ => self.ground.left_of_direct(self.optics(), &self.surfaces, &self.lamps, &self.direct[leaf], leaf),
            };
            let leaves: Vec<usize> = self.mesh.leaves().filter(|_| !self.direct.is_empty()).collect();
            let direct = leaves.into_par_iter().map(of_leaf).collect();
            let is_wanted = !self.surfaces.is_textured() && self.mesh.clusters().root().is_none();
            let solved = Solved {
                mesh: &self.mesh,
                surfaces: &self.surfaces,
                lamps: &self.lamps,
                optics: self.optics(),
                field: &self.field,
                links: &self.links,
                far: &self.far,
                receivers: &self.receivers,
                channels: self.channels.len(),
                residuals: &self.bounds.residuals,
                importance: if is_wanted { self.importance() } else { None },
                clock: self.clock,
            };
            Proven::of(solved, &self.ground, direct)
        };
        self.proven.get_or_init(prove).as_ref()
    }

    /// Bounds the residual of direct light on leaves that have no such bound.
    pub(super) fn prove_direct(&mut self) {
        self.proven_direct.resize(self.mesh.elements().len(), None);
        if self.direct.is_empty() {
            return;
        }
        let new: Vec<usize> = self.mesh.leaves().filter(|&leaf| self.proven_direct[leaf].is_none()).collect();
        let of = |&leaf: &usize| self.ground.left_of_direct(self.optics(), &self.surfaces, &self.lamps, &self.direct[leaf], leaf);
        let clock = self.clock;
        let left: Option<Vec<Vec<Rest>>> = new.par_iter().map(|leaf| (!clock.is_over()).then(|| of(leaf))).collect();
        let Some(left) = left else { return };
        new.into_iter().zip(left).for_each(|(leaf, left)| self.proven_direct[leaf] = Some(left));
    }
}
