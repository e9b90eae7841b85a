//! Gathering: the discrete equation `b = e + P rho G b` on the leaves, solved by Gauss-Seidel, and its residual.
//!
//! At the nodes of a leaf the irradiance `G B_h` is a sum over its links; its projection on the basis, times the reflectance,
//! is the leaf's reflected radiosity. Leaves are taken in order and use what the ones before have got in the same sweep; each
//! hands its change up to its ancestors, so that links to these see it too. G is a contraction with the reflectance, and the
//! sweeps converge like powers of it.

use crate::field::Field;
use crate::link::Link;
use crate::mesh::Mesh;

/// Reflectance and emitted radiosity of each face in each channel.
#[derive(Debug, Clone)]
pub(crate) struct Surfaces {
    pub(crate) reflectance: Vec<Vec<f64>>,
    pub(crate) emitted: Vec<Vec<f64>>,
}

/// Irradiance at each node of a leaf, without what links neglect.
pub(crate) fn irradiance(mesh: &Mesh, field: &Field, links: &[Link], channel: usize, nodes: usize) -> Vec<f64> {
    let mut at_nodes = vec![0.0; nodes];
    for link in links {
        let coefficients = &field.of(link.source, channel, mesh.basis(link.source).len())[..link.count];
        for (sum, row) in at_nodes.iter_mut().zip(&link.rows) {
            *sum += coefficients.iter().zip(&row.values).map(|(c, v)| c * v).sum::<f64>();
        }
    }
    at_nodes
}

/// One sweep over all leaves. Returns the largest change of a coefficient, relative to `scale` in each channel.
pub(crate) fn sweep(
    mesh: &Mesh,
    surfaces: &Surfaces,
    leaves: &[usize],
    links: &[Vec<Link>],
    field: &mut Field,
    scale: &[f64],
) -> f64 {
    let mut largest: f64 = 0.0;
    for &leaf in leaves {
        let (basis, face) = (mesh.basis(leaf), mesh.elements()[leaf].face());
        for (channel, scale) in scale.iter().enumerate() {
            let at_nodes = irradiance(mesh, field, &links[leaf], channel, basis.nodes().len());
            let reflected: Vec<f64> = at_nodes.iter().map(|h| surfaces.reflectance[face][channel] * h).collect();
            let mut new = basis.project(&reflected);
            new[0] += surfaces.emitted[face][channel];
            largest = largest.max(field.set(mesh, leaf, channel, &new) / scale);
        }
    }
    largest
}
