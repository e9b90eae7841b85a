//! Gathering: a discrete equation `b = s + P rho G b` on the receivers, solved by Gauss-Seidel.
//!
//! At the nodes of a receiver the irradiance `G b` is a sum over its links; its projection on the basis, times the reflectance,
//! is the reflected radiosity; with a texture it is the projection of the product ([`crate::texture`]). Receivers are taken in
//! order and use what the ones before have got in the same sweep: each hands its change on to the elements above and below, which
//! links see. G is a contraction with the reflectance, and the sweeps converge like powers of it. The radiosity is such a b, and so
//! is the bound on its error.

use crate::cluster::Far;
use crate::field::Field;
use crate::link::Link;
use crate::mesh::Mesh;
use crate::surfaces::Surfaces;

/// Irradiance at each node of a receiver, without what links and clusters neglect.
pub(crate) fn irradiance(mesh: &Mesh, field: &Field, links: &[Link], far: &Far, channel: usize, nodes: usize) -> Vec<f64> {
    let mut at_nodes: Vec<f64> = (0..nodes).map(|node| far.value(mesh.clusters(), field, channel, node)).collect();
    for link in links {
        let coefficients = field.of(link.source, channel, mesh.basis(link.source).len());
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
    /// For each element that receives, channel after channel, the coefficients of what is added to the reflected light.
    pub(crate) source: &'a [Vec<f64>],
}

impl Equation<'_> {
    /// One sweep over all receivers, whose own part of `field` is `own`. Returns the largest change of a coefficient, relative
    /// to `scale` in each channel.
    pub(crate) fn sweep(&self, field: &mut Field, own: &mut [Vec<f64>], scale: &[f64]) -> f64 {
        let mut largest: f64 = 0.0;
        // Of clusters as they were before the sweep.
        field.pool(self.mesh);
        for &receiver in self.receivers {
            let len = self.mesh.basis(receiver).len();
            for (channel, scale) in scale.iter().enumerate() {
                let mut change = vec![0.0; len];
                for link in &self.links[receiver] {
                    let count = link.matrix.len() / len;
                    let coefficients = field.of(link.source, channel, count);
                    for (sum, row) in change.iter_mut().zip(link.matrix.chunks_exact(count)) {
                        *sum += row.iter().zip(coefficients).map(|(m, c)| m * c).sum::<f64>();
                    }
                }
                self.far[receiver].gather(field, channel, &mut change);
                self.surfaces.reflect(self.mesh, receiver, channel, &mut change);
                let range = channel * len..(channel + 1) * len;
                change.iter_mut().zip(&self.source[receiver][range.clone()]).for_each(|(c, s)| *c += s);
                for (change, own) in change.iter_mut().zip(&mut own[receiver][range]) {
                    *change -= *own;
                    *own += *change;
                    largest = largest.max(change.abs() / scale);
                }
                if change.iter().any(|c| *c != 0.0) {
                    field.add(self.mesh, receiver, channel, &change);
                }
            }
        }
        largest
    }
}
