//! The proven bound of a round.

use rayon::prelude::*;

use crate::bound::proven::{Proven, Rest, Solved};
use crate::error::Error;
use crate::solve::options::Options;
use crate::solve::solution::Solution;

impl Solution {
    /// Whether what was asked for is reached.
    pub(super) fn reached(&self, options: &Options) -> bool {
        match options.bound {
            Some(bound) => self.progress.bound <= bound,
            None => self.progress.estimate <= options.error,
        }
    }

    /// Proves the bound.
    pub(super) fn prove(&mut self) -> Result<(), Error> {
        self.prove_direct();
        let leaves = self.mesh.leaves().filter(|_| !self.direct.is_empty());
        let direct = leaves.filter_map(|leaf| self.proven_direct[leaf].clone()).collect();
        let solved = Solved {
            mesh: &self.mesh,
            surfaces: &self.surfaces,
            field: &self.field,
            links: &self.links,
            far: &self.far,
            receivers: &self.receivers,
            channels: self.channels.len(),
            residuals: &self.bounds.residuals,
        };
        self.proven = Proven::of(solved, &self.ground, direct).ok_or_else(|| self.lossless())?;
        Ok(())
    }

    /// Bounds what is left out of direct light on leaves of which it is not known.
    pub(super) fn prove_direct(&mut self) {
        self.proven_direct.resize(self.mesh.elements().len(), None);
        if self.direct.is_empty() {
            return;
        }
        let new: Vec<usize> = self.mesh.leaves().filter(|&leaf| self.proven_direct[leaf].is_none()).collect();
        let of = |&leaf: &usize| self.ground.left_of_direct(&self.mesh, &self.surfaces, &self.lamps, &self.direct[leaf], leaf);
        let left: Vec<Vec<Rest>> = new.par_iter().map(of).collect();
        new.into_iter().zip(left).for_each(|(leaf, left)| self.proven_direct[leaf] = Some(left));
    }
}
