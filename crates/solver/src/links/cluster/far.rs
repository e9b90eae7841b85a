//! The light that a receiver gathers from clusters that have no links.
//!
//! The light that reaches a node is estimated by rays from it ([`super::sampled`]): `w P`, linear in the radiosity, with P the
//! power of the cluster. Its error is taken to be the deviation of the rays.
//!
//! All clusters together get no more of the hemisphere than the links leave: of `rest`, 1 less the sum of the links' form factors. So
//! where the links fill the view, clusters behind count for nothing.
//!
//! No cluster is in another, and no element that is linked in any.

use crate::bytes::bytes_of;
use crate::field::Field;
use crate::links::cluster::cut;
use crate::links::cluster::sampled::{Draw, RAYS_OF_A_POINT, Rays, Seen};
use crate::links::cluster::view::View;
use crate::links::station::Station;
use crate::links::transfer::{Optics, Row};
use crate::mesh::basis::Basis;
use crate::mesh::clusters::Clusters;
use crate::mesh::glow::Pair;
use radgrad_scene::{largest, smallest};

/// Added to the part of the hemisphere that links leave, for the rounding of surfaces.
pub(crate) const MARGIN: f64 = 1e-9;

/// A receiver's clusters.
#[derive(Debug, Clone, Default)]
pub(crate) struct Far {
    clusters: Vec<usize>,
    /// Of each cluster from each node.
    seen: Vec<Seen>,
    /// For each node, an estimate of the part of the hemisphere that links leave.
    rest: Vec<f64>,
    /// Rays from each node.
    rays: usize,
    /// For each cluster, the factor of its power for each function of the receiver's basis.
    matrix: Vec<f64>,
}

impl Far {
    /// Clusters as stations see them by so many rays each, where links give these rows.
    pub(crate) fn seen_by<'a>(
        optics: &Optics<'_>,
        (stations, count): (&[Station], usize),
        clusters: Vec<usize>,
        rows: impl Iterator<Item = &'a [Row]>,
    ) -> Self {
        if clusters.is_empty() {
            return Self::default();
        }
        let rays: Vec<Rays> = stations.iter().map(|station| optics.rays(station, count, Draw::Second)).collect();
        let views = clusters.iter().flat_map(|&cluster| cut::look_from(optics, stations, &rays, cluster)).collect();
        Self { rays: count, ..Self::new(optics.mesh.clusters(), clusters, views, stations.len(), rows) }
    }

    /// Clusters as each node sees them.
    fn new<'a>(
        tree: &Clusters,
        clusters: Vec<usize>,
        seen: Vec<Seen>,
        nodes: usize,
        rows: impl Iterator<Item = &'a [Row]>,
    ) -> Self {
        let mut covered = vec![0.0; nodes];
        if tree.are_apart() {
            for rows in rows {
                covered.iter_mut().zip(rows).for_each(|(sum, row)| *sum += row.likely_factor());
            }
        }
        Self { clusters, seen, rest: covered.into_iter().map(uncovered).collect(), ..Self::default() }
    }

    /// From one point.
    pub(crate) fn of_point(&self, optics: &Optics<'_>, station: &Station, rows: &[(usize, Row)]) -> Self {
        let rows = rows.iter().map(|(_, row)| std::slice::from_ref(row));
        Self::seen_by(optics, (std::slice::from_ref(station), self.rays.max(RAYS_OF_A_POINT)), self.clusters.clone(), rows)
    }

    /// Finds those factors for the functions of a receiver's basis.
    pub(crate) fn projected(mut self, basis: &Basis) -> Self {
        let nodes = self.rest.len();
        for index in 0..self.clusters.len() {
            let mut of_functions = vec![0.0; basis.len()];
            for node in 0..nodes {
                let weight = basis.nodes()[node].weight * self.view(index, node).weight;
                of_functions.iter_mut().zip(basis.at_node(node)).for_each(|(sum, value)| *sum += weight * value);
            }
            self.matrix.extend(of_functions);
        }
        self
    }

    /// Whether it is that of an element with such a basis, over so many clusters.
    pub(crate) fn is_of(&self, basis: &Basis, clusters: usize) -> bool {
        let (count, nodes) = (self.clusters.len(), basis.nodes().len());
        self.clusters.iter().all(|cluster| *cluster < clusters)
            && self.seen.len() == count * nodes
            && self.matrix.len() == count * basis.len()
            && (self.rest.len() == nodes || count == 0)
    }

    pub(crate) const fn is_empty(&self) -> bool {
        self.clusters.is_empty()
    }

    pub(crate) const fn len(&self) -> usize {
        self.clusters.len()
    }

    /// How many rays each node has; 0 without clusters.
    pub(crate) const fn rays(&self) -> usize {
        self.rays
    }

    /// How many nodes the receiver has; 0 without clusters.
    pub(crate) const fn nodes(&self) -> usize {
        self.rest.len()
    }

    pub(crate) fn clusters(&self) -> &[usize] {
        &self.clusters
    }

    /// The view of a cluster from a node.
    pub(crate) fn view(&self, index: usize, node: usize) -> &Seen {
        &self.seen[index * self.rest.len() + node]
    }

    /// Irradiance of a node.
    pub(crate) fn value(&self, field: &Field, channel: usize, node: usize) -> f64 {
        let irradiance = |(index, &cluster): (usize, &usize)| self.view(index, node).weight * field.glow(cluster, channel).power;
        self.clusters.iter().enumerate().map(irradiance).sum()
    }

    /// Deviation of the irradiance of a node.
    pub(crate) fn likely(&self, field: &Field, channel: usize, node: usize) -> f64 {
        let deviation = |(index, &cluster): (usize, &usize)| {
            let (seen, glow) = (self.view(index, node), field.glow(cluster, channel));
            seen.noise(glow).hypot(seen.uneven(glow))
        };
        self.clusters.iter().enumerate().map(deviation).map(|error| error * error).sum::<f64>().sqrt()
    }

    /// Deviation of the mean irradiance over the nodes: each node has rays of its own, but clusters are as uneven for all.
    pub(crate) fn likely_mean(&self, field: &Field, channel: usize, basis: &Basis) -> f64 {
        let squares = |(index, &cluster): (usize, &usize)| {
            let (glow, nodes) = (field.glow(cluster, channel), basis.nodes().iter().enumerate());
            nodes.fold([0.0; 2], |[noise, uneven], (node, at)| {
                let view = self.view(index, node);
                let own = at.weight * view.noise(glow);
                [noise + own * own, uneven + at.weight * view.uneven(glow)]
            })
        };
        self.clusters.iter().enumerate().map(squares).map(|[noise, uneven]| noise + uneven * uneven).sum::<f64>().sqrt()
    }

    /// Adds the clusters' light to the sums for a receiver's functions.
    pub(crate) fn gather(&self, field: &Field, channel: usize, sums: &mut [f64]) {
        for (&cluster, row) in self.clusters.iter().zip(self.matrix.chunks_exact(sums.len())) {
            let power = field.glow(cluster, channel).power;
            sums.iter_mut().zip(row).for_each(|(sum, weight)| *sum += weight * power);
        }
    }

    /// Estimate of a node's gather of a quantity that is nowhere negative, given for each cluster.
    pub(crate) fn gathered(&self, node: usize, of: &[Pair]) -> f64 {
        let (mut sum, mut brightest) = (0.0, 0.0_f64);
        for (index, &cluster) in self.clusters.iter().enumerate() {
            let view = self.view(index, node);
            if view.view.factor > 0.0 {
                sum += view.gathers(of[cluster].whole, of[cluster].largest);
                brightest = largest(brightest, of[cluster].largest);
            }
        }
        if brightest == 0.0 { 0.0 } else { smallest(sum, self.rest[node] * brightest) }
    }

    /// Adds that to the sums of each node.
    pub(crate) fn add_gathered(&self, of: &[Pair], sums: &mut [f64]) {
        if !self.clusters.is_empty() {
            sums.iter_mut().enumerate().for_each(|(node, sum)| *sum += self.gathered(node, of));
        }
    }

    /// The largest view of a cluster from any node.
    pub(crate) fn widest(&self, index: usize) -> View {
        let nodes = self.rest.len();
        let join = |a: View, b: &View| View { factor: largest(a.factor, b.factor), peak: largest(a.peak, b.peak) };
        self.seen[index * nodes..(index + 1) * nodes].iter().map(|seen| &seen.view).fold(View::default(), join)
    }
}

/// Adds or takes away the part of the hemisphere that a link surely fills at each node.
pub(crate) fn cover(covered: &mut [f64], rows: &[Row], sign: f64) {
    let fills = |row: &Row| row.values.first().map_or(0.0, |factor| largest(factor - row.error, 0.0));
    covered.iter_mut().zip(rows).for_each(|(sum, row)| *sum += sign * fills(row));
}

/// The part of the hemisphere that is left.
pub(crate) fn uncovered(covered: f64) -> f64 {
    largest(1.0 - covered, 0.0) + MARGIN
}

bytes_of!(Far { clusters, seen, rest, rays, matrix });
