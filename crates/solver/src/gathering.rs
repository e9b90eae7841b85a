//! Gathering: a discrete equation `b = s + P rho G b` on the receivers, solved by Gauss-Seidel.
//!
//! At the nodes of a receiver the irradiance `G b` is a sum over its links; its projection on the basis, times the reflectance,
//! is the reflected radiosity; with a texture it is the projection of the product ([`crate::mesh::texture`]). Receivers are taken
//! in order, a few at a time, and use the radiosities of those before in the same sweep: each hands its change on to the elements
//! above and below, which links see. Clusters are gathered from as they were before the sweep. G is a contraction with the
//! reflectance, and the sweeps converge like powers of it. The radiosity is such a b, and so is the bound on its error.

mod acceleration;

use radgrad_scene::largest;
use rayon::prelude::*;

use crate::field::Field;
use crate::links::cluster::far::Far;
use crate::links::link::Link;
use crate::mesh::Mesh;
use crate::mesh::surfaces::Surfaces;

/// Sweeps after which an importance or an error is not known.
pub(crate) const MOST_SWEEPS: usize = 2000;

/// Irradiance at each node of a receiver, without the light that links and clusters neglect.
pub(crate) fn irradiance(field: &Field, links: &[Link], far: &Far, channel: usize, nodes: usize) -> Vec<f64> {
    let mut at_nodes: Vec<f64> = (0..nodes).map(|node| far.value(field, channel, node)).collect();
    for link in links {
        let coefficients = field.coefficients(link.source, channel);
        for (sum, row) in at_nodes.iter_mut().zip(&link.rows) {
            *sum += coefficients.iter().zip(&row.values).map(|(c, v)| c * v).sum::<f64>();
        }
    }
    at_nodes
}

/// An equation on the receivers.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Equation<'a> {
    pub(crate) mesh: &'a Mesh,
    pub(crate) surfaces: &'a Surfaces,
    pub(crate) receivers: &'a [usize],
    pub(crate) links: &'a [Vec<Link>],
    pub(crate) far: &'a [Far],
    /// For each element that receives, channel after channel, the coefficients of the source s in the reflected light.
    pub(crate) source: &'a [Vec<f64>],
}

/// Receivers that are taken together, on all cores: they see each other as they were before. A number that does not depend on the
/// machine, so that results do not.
const TOGETHER: usize = 16;

/// Of many receivers more are taken together, so many times: those that are handed to all cores have to be worth it.
const TIMES: usize = 500;

impl Equation<'_> {
    /// One sweep over all receivers, whose own part of `field` is `own`. Returns the largest change of a coefficient, relative
    /// to `scale` in each channel: infinite where that is 0 and anything changes.
    fn sweep(&self, field: &mut Field, own: &mut [Vec<f64>], scale: &[f64]) -> f64 {
        let mut greatest: f64 = 0.0;
        field.pool(self.mesh);
        for receivers in self.receivers.chunks((self.receivers.len() / TIMES).max(TOGETHER)) {
            let change = |&receiver: &usize| self.change(receiver, field, &own[receiver], scale.len());
            let changes: Vec<Vec<f64>> = receivers.par_iter().map(change).collect();
            for (&receiver, change) in receivers.iter().zip(&changes) {
                let len = self.mesh.basis(receiver).len();
                own[receiver].iter_mut().zip(change).for_each(|(own, change)| *own += change);
                for (channel, (change, scale)) in change.chunks_exact(len).zip(scale).enumerate() {
                    greatest = change.iter().fold(greatest, |most, c| largest(most, ratio(c.abs(), *scale)));
                    if change.iter().any(|c| *c != 0.0) {
                        field.add(self.mesh, receiver, channel, change);
                    }
                }
            }
        }
        greatest
    }

    /// The irradiance that a receiver gathers now, by links and from clusters with their powers when these were last summed, less
    /// its own part, channel after channel.
    pub(crate) fn change(&self, receiver: usize, field: &Field, own: &[f64], channels: usize) -> Vec<f64> {
        let len = self.mesh.basis(receiver).len();
        let mut change = vec![0.0; len * channels];
        for link in &self.links[receiver] {
            for (channel, sums) in change.chunks_exact_mut(len).enumerate() {
                multiply(&link.matrix, field.coefficients(link.source, channel), sums);
            }
        }
        for (channel, sums) in change.chunks_exact_mut(len).enumerate() {
            self.far[receiver].gather(field, channel, sums);
            self.surfaces.reflect(self.mesh, receiver, channel, sums);
        }
        change.iter_mut().zip(&self.source[receiver]).zip(own).for_each(|((c, source), own)| *c = *c + source - own);
        change
    }
}

/// Adds a matrix, row after row, times a vector.
pub(crate) fn multiply(matrix: &[f64], vector: &[f64], sum: &mut [f64]) {
    for (sum, row) in sum.iter_mut().zip(matrix.chunks_exact(vector.len())) {
        *sum += row.iter().zip(vector).map(|(m, v)| m * v).sum::<f64>();
    }
}

/// A part over the whole: 0 of nothing, whatever the whole, and infinity of a whole that is not positive, as where rounding hides it.
pub(crate) fn ratio(part: f64, whole: f64) -> f64 {
    match part == 0.0 {
        true => 0.0,
        false if whole > 0.0 || whole.is_nan() => part / whole,
        false => part * f64::INFINITY,
    }
}
