//! Gathering: the discrete equation `b = e + P rho G b` on the leaves, solved by Gauss-Seidel, and its residual.
//!
//! At the nodes of a leaf the irradiance `G B_h` is a sum over its links; the projection of its product with the
//! reflectance is the leaf's reflected radiosity (module `surfaces`). Leaves are taken in order and use what the ones before have got in the same sweep; each
//! hands its change up to its ancestors, so that links to these see it too. G is a contraction with the reflectance, and the
//! sweeps converge like powers of it.

use crate::field::Field;
use crate::link::Link;
use crate::mesh::Mesh;
use crate::surfaces::Surfaces;

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
        let nodes = mesh.basis(leaf).nodes().len();
        for (channel, scale) in scale.iter().enumerate() {
            let at_nodes = irradiance(mesh, field, &links[leaf], channel, nodes);
            let new = surfaces.radiosity(mesh, leaf, channel, &at_nodes);
            largest = largest.max(field.set(mesh, leaf, channel, &new) / scale);
        }
    }
    largest
}
