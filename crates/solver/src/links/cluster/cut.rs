//! The cut through the tree of clusters where a receiver leaves it: which cluster is opened next, and the error of the closed
//! ones together, as if without order ([`super::sampled`]).

use radgrad_scene::largest;

use crate::field::Field;
use crate::links::cluster::far::Far;
use crate::links::cluster::sampled::{Rays, Seen};
use crate::links::gatherer::Gatherer;
use crate::links::station::Station;
use crate::links::transfer::{Optics, Row};
use crate::mesh::clusters::Parts;
use crate::mesh::glow::ClusterEmission;

/// A cluster that is not opened.
struct Closed {
    cluster: usize,
    /// Deviation of its light, weighted, at each node, and the largest.
    errors: Vec<f64>,
    most: f64,
}

/// The closed clusters of a receiver.
pub(crate) struct Cut<'a> {
    optics: &'a Optics<'a>,
    field: &'a Field,
    weight: &'a [f64],
    closed: Vec<Closed>,
    nodes: usize,
    /// Whether the noise of rays counts: else as many are drawn as are needed.
    with_noise: bool,
}

impl<'a> Cut<'a> {
    /// That of a receiver's clusters.
    pub(crate) fn new(optics: &'a Optics<'a>, field: &'a Field, weight: &'a [f64], far: &Far, with_noise: bool) -> Self {
        let mut cut = Self { optics, field, weight, closed: Vec::new(), nodes: far.nodes(), with_noise };
        for (index, &cluster) in far.clusters().iter().enumerate() {
            let views: Vec<Seen> = (0..far.nodes()).map(|node| *far.view(index, node)).collect();
            cut.close(cluster, &views);
        }
        cut
    }

    fn close(&mut self, cluster: usize, seen: &[Seen]) {
        let glows: Vec<&ClusterEmission> = (0..self.weight.len()).map(|channel| self.field.glow(cluster, channel)).collect();
        let error_at = |seen: &Seen| {
            // Nodes have rays of their own.
            let noise =
                |glow: &ClusterEmission| if self.with_noise { seen.noise(glow) / (self.nodes as f64).sqrt() } else { 0.0 };
            let weighted_error = |(glow, weight): (&&ClusterEmission, &f64)| weight * noise(glow).hypot(seen.uneven(glow));
            glows.iter().zip(self.weight).map(weighted_error).fold(0.0, largest)
        };
        let errors: Vec<f64> = seen.iter().map(error_at).collect();
        let largest_error = errors.iter().copied().fold(0.0, largest);
        self.closed.push(Closed { cluster, errors, most: largest_error });
    }

    /// Looks at the clusters once more, by rays from each station.
    pub(crate) fn look(&mut self, stations: &[Station], rays: &[Rays]) {
        for Closed { cluster, .. } in std::mem::take(&mut self.closed) {
            self.close(cluster, &look_from(self.optics, stations, rays, cluster));
        }
    }

    /// The error of all at each node, the largest of the channels after each is multiplied by its weight. Nothing if none is
    /// closed.
    pub(crate) fn likely(&self) -> Vec<f64> {
        let nodes = if self.closed.is_empty() { 0 } else { self.nodes };
        let mut squares = vec![0.0; nodes];
        for closed in &self.closed {
            squares.iter_mut().zip(&closed.errors).for_each(|(sum, error)| *sum += error * error);
        }
        squares.into_iter().map(f64::sqrt).collect()
    }

    /// Opens the cluster that is off most, or gives the element that it is, to be linked. `None` if none is off at all.
    pub(crate) fn open(&mut self, gatherer: Gatherer<'_>, stations: &[Station], rays: &[Rays]) -> Option<Option<usize>> {
        let worst = |a: &usize, b: &usize| {
            let [a, b] = [a, b].map(|&index| &self.closed[index]);
            a.most.total_cmp(&b.most).then(b.cluster.cmp(&a.cluster))
        };
        let worst = (0..self.closed.len()).max_by(worst).filter(|&index| self.closed[index].most > 0.0)?;
        let tree = self.optics.mesh.clusters();
        match tree.clusters()[self.closed.swap_remove(worst).cluster].parts {
            Parts::Element(element) => Some(Some(element)),
            Parts::Two(parts) => {
                for part in parts.into_iter().filter(|&part| gatherer.may_see(self.optics.mesh, &tree.clusters()[part])) {
                    self.close(part, &look_from(self.optics, stations, rays, part));
                }
                Some(None)
            }
        }
    }

    /// The clusters to keep, seen from stations by rays that did not choose them, so many from each.
    pub(crate) fn closed<'b>(self, (stations, rays): (&[Station], usize), rows: impl Iterator<Item = &'b [Row]>) -> Far {
        let clusters = self.closed.iter().map(|closed| closed.cluster).collect();
        Far::seen_by(self.optics, (stations, rays), clusters, rows)
    }
}

/// The views of a cluster from stations by their rays.
pub(crate) fn look_from(optics: &Optics<'_>, stations: &[Station], rays: &[Rays], cluster: usize) -> Vec<Seen> {
    stations.iter().zip(rays).map(|(station, rays)| optics.look(station, rays, cluster)).collect()
}
