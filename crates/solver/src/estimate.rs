//! Estimates of the error: its mean magnitude over all area, and its magnitude at every point.
//!
//! `B = E + rho G B`, with a kernel that is nowhere negative and the same both ways. Let `B_h` be the piecewise polynomial
//! radiosity, `B_g = E + rho G B_h` its exact gather, and `r = B_g - B_h` the residual ([`crate::estimate::residual`]). The error
//! of the gather obeys `e = B - B_g = rho G r + rho G e`.
//!
//! ```text
//! links -> VisibleSources  visible_sources: those that a receiver's nodes see: receivers and the elements above them
//!   -> importance       importance: z, how much of a unit of light is reflected anywhere; supersolution: its defect
//!   -> mean             mean: |e| over all area, from z and from the cancellation in G r
//!   -> at points        point: largest values near by and means far away, when they are asked for
//! ```
//!
//! Light through clusters ([`crate::links::cluster`]) has a largest value and a mean, but no sign; a node gathers
//! [`crate::links::cluster::far::Far::gathered`] of it, besides its gathers by links.
//!
//! Where a figure has to hold at every point of an element, the difference between the largest value at the nodes and the least
//! is added. That, and the values of z and of gathers of the residual between nodes, are estimates of the same kind as the
//! residual's. Only light that no sample sees is bounded by geometry ([`unsampled`]).

mod importance;
pub(crate) mod ledger;
mod mean;
pub(crate) mod point;
pub(crate) mod residual;
pub(crate) mod sources;
mod supersolution;
pub(crate) mod unsampled;
pub(crate) mod visible_sources;

use std::sync::OnceLock;

use crate::error::Error;
use crate::estimate::ledger::Ledger;
use crate::estimate::point::Points;
use crate::estimate::residual::{Residual, Residuals};
use crate::mesh::Mesh;
use crate::once::made;
use crate::system::System;

/// Estimates for each channel.
#[derive(Debug, Default)]
pub(crate) struct ErrorEstimate {
    /// Of the mean magnitude of the error of gathers over all area.
    pub(crate) mean: Vec<Ledger>,
    /// Projection residuals of direct and of reflected light on each element.
    pub(crate) residuals: [Residuals; 2],
    /// For each element that receives, channel after channel, the weight of its residual in the mean.
    pub(crate) weights: Vec<Vec<f64>>,
    /// The parts that the sources of error have in the mean.
    pub(crate) shares: Vec<Ledger>,
    /// At points, once they are asked for.
    points: OnceLock<Points>,
}

impl ErrorEstimate {
    /// Whether it is of so many elements and channels.
    pub(crate) fn is_of(&self, elements: usize, channels: usize) -> bool {
        let is_each = |of: &Vec<Residual>| of.len() == channels || of.is_empty();
        self.mean.len() == channels
            && self.shares.len() == channels
            && self.residuals.iter().all(|of| of.len() == elements && of.iter().all(is_each))
            && self.weights.len() == elements
            && self.weights.iter().all(|of| of.len() == channels || of.is_empty())
    }

    /// Estimates the error all over the mesh from the projection residuals of direct and of reflected light.
    ///
    /// # Errors
    /// If light does not settle.
    pub(crate) fn solve(system: &System, residuals: [Residuals; 2]) -> Result<Self, Error> {
        let receives = system.receives();
        let views = system.seen_sources(&receives);
        let importance = importance::solve(system, &receives, &views)?;
        let mean::Mean { mean, shares, weights } = mean::estimate(system, &residuals, &views, &importance);
        Ok(Self { mean, residuals, weights, shares, points: OnceLock::new() })
    }

    /// Estimates at points.
    pub(crate) fn points(&self, system: &System) -> &Points {
        made(&self.points, || Points::from_mean(system, self))
    }

    /// How much a receiver adds to the estimate of the mean magnitude, for a residual of that mean.
    pub(crate) fn indicator(&self, mesh: &Mesh, receiver: usize, channel: usize, mean: f64) -> f64 {
        mesh.elements()[receiver].area() * self.weights[receiver][channel] * mean
    }
}
