//! Bounds on the error: its mean over all area, and its magnitude at every point.
//!
//! `B = E + rho G B`, with a kernel that is nowhere negative and the same both ways. Let `B_h` be the piecewise polynomial
//! radiosity, `B_g = E + rho G B_h` what one exact gather makes of it, and `r = B_g - B_h` the residual ([`crate::residual`]).
//! The error of the gather obeys `e = B - B_g = rho G r + rho G e`.
//!
//! ```text
//! links -> Seen         seen: what a receiver's nodes see of receivers and of what is above them
//!   -> importance       importance: z, how much of a unit of light is reflected anywhere; rise: bounds on what it leaves
//!   -> mean             mean: |e| over all area, from z and from what cancels in G r
//!   -> at points        point: largest values near by and means far away, when they are asked for
//! ```
//!
//! Of what is seen through clusters ([`crate::cluster`]) only the largest value and the mean are known, and no sign; a node
//! gathers [`Far::at_most`] of it, besides what it gathers by links.
//!
//! Where a bound has to hold at every point of an element, the difference between the largest value at the nodes and the least is
//! added; that, and what is between the nodes of z and of gathers of the residual, are estimates of the same kind as the
//! residual's.

mod importance;
mod mean;
mod point;
pub(crate) mod proven;
mod rise;
mod seen;

use std::sync::OnceLock;

use rayon::prelude::*;

use crate::cluster::{Far, Pair};
use crate::ledger::Ledger;
use crate::link::Link;
use crate::mesh::Mesh;
use crate::residual::Residual;
use crate::surfaces::Surfaces;
use crate::transfer::Station;

pub(crate) use point::Points;
use seen::Seen;

/// What bounds are made of.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Scene<'a> {
    pub(crate) mesh: &'a Mesh,
    pub(crate) surfaces: &'a Surfaces,
    pub(crate) receivers: &'a [usize],
    pub(crate) links: &'a [Vec<Link>],
    pub(crate) far: &'a [Far],
    pub(crate) channels: usize,
}

/// What light leaves out on each element, by channel.
pub(crate) type Residuals = Vec<Vec<Residual>>;

/// Bounds for each channel.
#[derive(Debug, Default)]
pub(crate) struct Bounds {
    /// On the mean magnitude of the error of gathers over all area.
    pub(crate) mean: Vec<Ledger>,
    /// What direct and reflected light leave out on each element.
    pub(crate) residuals: [Residuals; 2],
    /// For each element that receives, channel after channel, what its residual counts for in the mean.
    weights: Vec<Vec<f64>>,
    /// The parts that the sources of error have in the mean.
    shares: Vec<Ledger>,
    /// At points, once they are asked for.
    points: OnceLock<Points>,
}

impl Bounds {
    /// Bounds on the error all over the mesh, from what direct and reflected light leave out; `None` if none was found, as
    /// where light cannot be lost.
    pub(crate) fn of(scene: Scene<'_>, residuals: [Residuals; 2]) -> Option<Self> {
        let receives = scene.receives();
        let seen = scene.seen(&receives);
        let importance = importance::of(scene, &receives, &seen)?;
        let mean::Mean { mean, shares, weights } = mean::of(scene, &residuals, &seen, &importance);
        Some(Self { mean, residuals, weights, shares, points: OnceLock::new() })
    }

    /// Bounds at points.
    pub(crate) fn points(&self, scene: Scene<'_>) -> &Points {
        self.points.get_or_init(|| Points::of(scene, self))
    }

    /// How much a receiver adds to the bound on the mean, for a residual of that mean.
    pub(crate) fn share(&self, mesh: &Mesh, receiver: usize, channel: usize, mean: f64) -> f64 {
        mesh.elements()[receiver].area() * self.weights[receiver][channel] * mean
    }
}

impl Scene<'_> {
    /// Whether each element is a receiver.
    fn receives(&self) -> Vec<bool> {
        let mut receives = vec![false; self.mesh.elements().len()];
        self.receivers.iter().for_each(|&receiver| receives[receiver] = true);
        receives
    }

    /// What each receiver sees.
    fn seen(&self, receives: &[bool]) -> Vec<Seen> {
        let of_receiver = |&receiver: &usize| {
            let links = self.links[receiver].iter().map(|link| (link.source, &link.rows[..]));
            Seen::of(self.mesh, self.surfaces, &self.stations(receiver), receives, links)
        };
        self.receivers.par_iter().map(of_receiver).collect()
    }

    fn stations(&self, element: usize) -> Vec<Station> {
        let (basis, element) = (self.mesh.basis(element), &self.mesh.elements()[element]);
        let station = |at| Station { point: element.point(at), normal: element.polygon().normal(), face: element.face() };
        basis.nodes().iter().map(|node| station(node.at)).collect()
    }

    fn reflectance(&self, element: usize, channel: usize) -> f64 {
        self.surfaces.reflectance[self.mesh.elements()[element].face()][channel]
    }

    /// For each channel, something that is nowhere negative on each cluster, from its largest value and its mean on elements.
    fn pairs(&self, of: impl Fn(usize, usize) -> (f64, f64)) -> Vec<Vec<Pair>> {
        let of_channel = |channel| self.mesh.clusters().pairs(self.mesh.elements(), |element| of(element, channel));
        (0..self.channels).map(of_channel).collect()
    }

    /// The same of the magnitude of residuals.
    fn pairs_of(&self, residuals: &[&Residuals]) -> Vec<Vec<Pair>> {
        let size = |residual: &Residual| (residual.whole().total(), residual.mean_ledger().total() + residual.mean_detail());
        self.pairs(|element, channel| {
            let sizes = residuals.iter().map(|of| size(&of[element][channel]));
            sizes.fold((0.0, 0.0), |sum, (largest, mean)| (sum.0 + largest, sum.1 + mean))
        })
    }

    /// Values of elements above receivers, channel after channel: the mean of their four children's, or the largest.
    fn pull(&self, receives: &[bool], values: &mut [f64], join: fn([f64; 4]) -> f64) {
        for index in (0..self.mesh.elements().len()).rev() {
            let Some(first) = self.mesh.elements()[index].children().filter(|_| !receives[index]) else { continue };
            for channel in 0..self.channels {
                values[index * self.channels + channel] =
                    join([0, 1, 2, 3].map(|child| values[(first + child) * self.channels + channel]));
            }
        }
    }
}

impl Residual {
    /// Those at some elements, and from there those over the elements above and for the elements below.
    pub(crate) fn everywhere(mesh: &Mesh, at: &[usize], of: Vec<Vec<Self>>, channels: usize) -> Residuals {
        let mut all: Vec<Option<Vec<Self>>> = vec![None; mesh.elements().len()];
        for (&element, of) in at.iter().zip(of) {
            all[element] = Some(of);
        }
        for index in (0..all.len()).rev() {
            if let (None, Some(first)) = (&all[index], mesh.elements()[index].children()) {
                let children: Vec<&Vec<Self>> = all[first..first + 4].iter().flatten().collect();
                if children.len() == 4 {
                    let of = |channel: usize| Self::over(&[0, 1, 2, 3].map(|child| children[child][channel]));
                    all[index] = Some((0..channels).map(of).collect());
                }
            }
        }
        all.into_iter().map(|of| of.unwrap_or_else(|| vec![Self::default(); channels])).collect()
    }
}
