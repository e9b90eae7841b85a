//! The parts that estimates need: the mesh, its links, and the sources that its receivers see.

use rayon::prelude::*;

use crate::estimate::residual::{Residual, Residuals};
use crate::estimate::seen::SeenSources;
use crate::links::cluster::far::Far;
use crate::links::cluster::glow::Pair;
use crate::links::link::Link;
use crate::links::station::Station;
use crate::mesh::Mesh;
use crate::mesh::surfaces::Surfaces;

/// The system that errors are estimated for.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Scene<'a> {
    pub(crate) mesh: &'a Mesh,
    pub(crate) surfaces: &'a Surfaces,
    pub(crate) receivers: &'a [usize],
    pub(crate) links: &'a [Vec<Link>],
    pub(crate) far: &'a [Far],
    pub(crate) channels: usize,
}

impl Scene<'_> {
    /// Whether each element is a receiver.
    pub(super) fn receives(&self) -> Vec<bool> {
        let mut receives = vec![false; self.mesh.elements().len()];
        self.receivers.iter().for_each(|&receiver| receives[receiver] = true);
        receives
    }

    /// The sources that each receiver sees.
    pub(super) fn seen_sources(&self, receives: &[bool]) -> Vec<SeenSources> {
        let of_receiver = |&receiver: &usize| {
            let links = self.links[receiver].iter().map(|link| (link.source, &link.rows[..]));
            SeenSources::gather(self.mesh, self.surfaces, &Station::at_nodes(self.mesh, receiver), receives, links)
        };
        self.receivers.par_iter().map(of_receiver).collect()
    }

    pub(super) fn reflectance(&self, element: usize, channel: usize) -> f64 {
        self.surfaces.reflectance[self.mesh.elements()[element].face()][channel]
    }

    /// For each channel, something that is nowhere negative on each cluster, from its largest value and its mean on elements.
    pub(super) fn pairs(&self, of: impl Fn(usize, usize) -> (f64, f64)) -> Vec<Vec<Pair>> {
        let of_channel = |channel| self.mesh.clusters().pairs(self.mesh.elements(), |element| of(element, channel));
        (0..self.channels).map(of_channel).collect()
    }

    /// The same of the magnitude of residuals.
    pub(super) fn pairs_of(&self, residuals: &[&Residuals]) -> Vec<Vec<Pair>> {
        let size = |residual: &Residual| (residual.whole().total(), residual.mean_ledger().total() + residual.mean_detail());
        self.pairs(|element, channel| {
            let sizes = residuals.iter().map(|of| size(&of[element][channel]));
            sizes.fold((0.0, 0.0), |sum, (largest, mean)| (sum.0 + largest, sum.1 + mean))
        })
    }

    /// Values of elements above receivers, channel after channel: the mean of their four children's, or the largest.
    pub(super) fn pull(&self, receives: &[bool], values: &mut [f64], join: fn([f64; 4]) -> f64) {
        for index in (0..self.mesh.elements().len()).rev() {
            let Some(first) = self.mesh.elements()[index].children().filter(|_| !receives[index]) else { continue };
            for channel in 0..self.channels {
                values[index * self.channels + channel] =
                    join([0, 1, 2, 3].map(|child| values[(first + child) * self.channels + channel]));
            }
        }
    }
}
