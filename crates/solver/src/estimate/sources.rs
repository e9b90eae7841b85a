//! The sources that receivers see, and sums over clusters.

use rayon::prelude::*;

use crate::estimate::residual::{Residual, Residuals};
use crate::estimate::visible_sources::VisibleSources;
use crate::links::station::Station;
use crate::mesh::Mesh;
use crate::mesh::glow::Pair;
use crate::system::System;

impl System {
    /// The sources that each receiver sees.
    pub(super) fn seen_sources(&self, receives: &[bool]) -> Vec<VisibleSources> {
        let of_receiver = |&receiver: &usize| {
            let links = self.links[receiver].iter().map(|link| (link.source, &link.rows[..]));
            VisibleSources::gather(&self.mesh, &self.surfaces, &Station::at_nodes(&self.mesh, receiver), receives, links)
        };
        self.receivers.par_iter().map(of_receiver).collect()
    }

    /// For each channel, a quantity that is nowhere negative on each cluster, from its largest value and its mean on elements.
    pub(super) fn pairs(&self, of: impl Fn(usize, usize) -> (f64, f64)) -> Vec<Vec<Pair>> {
        let of_channel = |channel| self.mesh.clusters().pairs(self.mesh.elements(), |element| of(element, channel));
        (0..self.channels.len()).map(of_channel).collect()
    }

    /// The same of the magnitude of residuals.
    pub(super) fn pairs_of(&self, residuals: &[&Residuals]) -> Vec<Vec<Pair>> {
        let size = |residual: &Residual| (residual.whole().total(), residual.mean_ledger().total() + residual.mean_detail());
        self.pairs(|element, channel| {
            let sizes = residuals.iter().map(|of| size(&of[element][channel]));
            sizes.fold((0.0, 0.0), |sum, (largest, mean)| (sum.0 + largest, sum.1 + mean))
        })
    }

    /// Values of elements above receivers ([`pull`]).
    pub(super) fn pull(&self, receives: &[bool], values: &mut [f64], join: fn([f64; 4]) -> f64) {
        pull(&self.mesh, self.channels.len(), receives, values, join);
    }
}

/// Values of elements above receivers, channel after channel: the mean of their four children's, or the largest.
pub(crate) fn pull(mesh: &Mesh, channels: usize, receives: &[bool], values: &mut [f64], join: fn([f64; 4]) -> f64) {
    for index in (0..mesh.elements().len()).rev() {
        let Some(first) = mesh.elements()[index].children().filter(|_| !receives[index]) else { continue };
        for channel in 0..channels {
            values[index * channels + channel] = join([0, 1, 2, 3].map(|child| values[(first + child) * channels + channel]));
        }
    }
}
