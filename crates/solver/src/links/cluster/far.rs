//! The light that a receiver gathers from clusters that have no links.
//!
//! A cluster's light at a node is between `-min(k P-, F M)` and `min(k P+, F M)`: k and F bound kernel and form factor ([`View`]),
//! M is the largest radiosity in the cluster, `P+` and `P-` are the powers of where it is positive and negative. With P the power,
//! `P+ - P- = P`, and `P+ + P-` is at most the area times the root mean square.
//!
//! All clusters together get no more of the hemisphere than the links leave: of `rest`, 1 less the sum of the links' form
//! factors. The most that they may give then is found by filling it with the brightest first. This accounts for occlusion: where
//! the links fill the view, clusters behind count for nothing.
//!
//! For the light that reaches the node half of that is taken for an even radiosity: `w P` with `w = min(k, F/A)/2`, less where the
//! hemisphere is full; linear in the radiosity, and with form factors that sum to no more than 1. The distance to the farther end
//! of the interval is the neglected light.
//!
//! No cluster is in another, but a link's source may be in one as well: then the bounds count it twice.

use crate::field::Field;
use crate::links::cluster::glow::{Glow, Pair};
use crate::links::cluster::screens::Screens;
use crate::links::cluster::view::View;
use crate::links::station::Station;
use crate::links::transfer::Row;
use crate::mesh::Mesh;
use crate::mesh::basis::Basis;
use crate::mesh::clusters::Clusters;
use radgrad_scene::{largest, smallest};

/// Added to the part of the hemisphere that links leave, for the rounding of surfaces.
pub(crate) const MARGIN: f64 = 1e-9;

/// A receiver's clusters.
#[derive(Debug, Clone, Default)]
pub(crate) struct Far {
    clusters: Vec<usize>,
    /// Of each cluster from each node.
    views: Vec<View>,
    /// Of each cluster at each node: the factor of its power in the node's irradiance.
    weights: Vec<f64>,
    /// For each node, the part of the hemisphere that links leave.
    rest: Vec<f64>,
    /// For each cluster, the factor of its power for each function of the receiver's basis.
    matrix: Vec<f64>,
}

impl Far {
    /// Clusters of the light that a field has, with their views from each node, where links give these rows at the nodes.
    pub(crate) fn new<'a>(
        (tree, field): (&Clusters, &Field),
        clusters: Vec<usize>,
        views: Vec<View>,
        nodes: usize,
        rows: impl Iterator<Item = &'a [Row]>,
    ) -> Self {
        if clusters.is_empty() {
            return Self::default();
        }
        let mut covered = vec![0.0; nodes];
        if tree.are_apart() {
            rows.for_each(|rows| cover(&mut covered, rows, 1.0));
        }
        let rest: Vec<f64> = covered.into_iter().map(left).collect();
        let brightness: Vec<f64> = clusters.iter().map(|&cluster| field.brightness(cluster)).collect();
        let mut order: Vec<usize> = (0..clusters.len()).collect();
        order.sort_by(|&a, &b| brightness[b].total_cmp(&brightness[a]));
        let mut weights = vec![0.0; views.len()];
        for (node, &rest) in rest.iter().enumerate() {
            let seen = order.iter().map(|&index| (&views[index * nodes + node], tree.all()[clusters[index]].area()));
            for (&index, weight) in order.iter().zip(even(rest, seen)) {
                weights[index * nodes + node] = weight;
            }
        }
        Self { clusters, views, weights, rest, matrix: Vec::new() }
    }

    /// From one point.
    pub(crate) fn of_point(&self, (mesh, field): (&Mesh, &Field), station: &Station, rows: &[(usize, Row)]) -> Self {
        let tree = mesh.clusters();
        let mut screens = Screens::default();
        rows.iter().for_each(|(source, row)| screens.fill(mesh.elements()[*source].face(), row.factor()));
        let screens = screens.polygons(mesh);
        let views = self.clusters.iter().map(|&cluster| tree.all()[cluster].view(station, &screens)).collect();
        Self::new((tree, field), self.clusters.clone(), views, 1, rows.iter().map(|(_, row)| std::slice::from_ref(row)))
    }

    /// Finds those factors for the functions of a receiver's basis.
    pub(crate) fn projected(mut self, basis: &Basis) -> Self {
        let nodes = self.rest.len();
        for index in 0..self.clusters.len() {
            let mut of_functions = vec![0.0; basis.len()];
            for node in 0..nodes {
                let weight = basis.nodes()[node].weight * self.weights[index * nodes + node];
                of_functions.iter_mut().zip(basis.at_node(node)).for_each(|(sum, value)| *sum += weight * value);
            }
            self.matrix.extend(of_functions);
        }
        self
    }

    pub(crate) const fn is_empty(&self) -> bool {
        self.clusters.is_empty()
    }

    pub(crate) const fn len(&self) -> usize {
        self.clusters.len()
    }

    /// How many nodes the receiver has; 0 without clusters.
    pub(crate) const fn nodes(&self) -> usize {
        self.rest.len()
    }

    pub(crate) fn clusters(&self) -> &[usize] {
        &self.clusters
    }

    /// A node's view of a cluster.
    pub(crate) fn view(&self, index: usize, node: usize) -> &View {
        &self.views[index * self.rest.len() + node]
    }

    /// Irradiance of a node.
    pub(crate) fn value(&self, field: &Field, channel: usize, node: usize) -> f64 {
        let weight = |index: usize| self.weights[index * self.rest.len() + node];
        let of = |(index, &cluster): (usize, &usize)| weight(index) * field.glow(cluster, channel).power;
        self.clusters.iter().enumerate().map(of).sum()
    }

    /// Bound on the light that is neglected in that.
    pub(crate) fn neglected(&self, field: &Field, channel: usize, node: usize) -> f64 {
        if self.clusters.is_empty() {
            return 0.0;
        }
        let mut seen: Vec<(&View, &Glow)> =
            self.clusters.iter().enumerate().map(|(index, &at)| (self.view(index, node), field.glow(at, channel))).collect();
        seen.sort_by(|a, b| b.1.largest.total_cmp(&a.1.largest));
        let [high, low] = fill(self.rest[node], seen.into_iter());
        let value = self.value(field, channel, node);
        // The sums round.
        let rounding = 4.0 * f64::EPSILON * self.clusters.len() as f64 * (high + low + value.abs());
        largest(high - value, value + low) + rounding
    }

    /// Adds the clusters' light to the sums for a receiver's functions.
    pub(crate) fn gather(&self, field: &Field, channel: usize, sums: &mut [f64]) {
        for (&cluster, row) in self.clusters.iter().zip(self.matrix.chunks_exact(sums.len())) {
            let power = field.glow(cluster, channel).power;
            sums.iter_mut().zip(row).for_each(|(sum, weight)| *sum += weight * power);
        }
    }

    /// The most that a node gets of a quantity that is nowhere negative, given for each cluster.
    pub(crate) fn at_most(&self, node: usize, of: &[Pair]) -> f64 {
        let (mut sum, mut brightest) = (0.0, 0.0_f64);
        for (index, &cluster) in self.clusters.iter().enumerate() {
            let view = self.view(index, node);
            if view.factor > 0.0 {
                sum += view.at_most(of[cluster].whole, of[cluster].largest);
                brightest = largest(brightest, of[cluster].largest);
            }
        }
        if brightest == 0.0 { 0.0 } else { smallest(sum, self.rest[node] * brightest) }
    }

    /// Adds that to the sums of each node.
    pub(crate) fn add_at_most(&self, of: &[Pair], sums: &mut [f64]) {
        if !self.clusters.is_empty() {
            sums.iter_mut().enumerate().for_each(|(node, sum)| *sum += self.at_most(node, of));
        }
    }

    /// The largest view of a cluster from any node.
    pub(crate) fn widest(&self, index: usize) -> View {
        let nodes = self.rest.len();
        let join = |a: View, b: &View| View { factor: largest(a.factor, b.factor), peak: largest(a.peak, b.peak) };
        self.views[index * nodes..(index + 1) * nodes].iter().fold(View::default(), join)
    }
}

/// Adds or takes away the part of the hemisphere that a link surely fills at each node.
pub(crate) fn cover(covered: &mut [f64], rows: &[Row], sign: f64) {
    let fills = |row: &Row| row.values.first().map_or(0.0, |factor| largest(factor - row.error, 0.0));
    covered.iter_mut().zip(rows).for_each(|(sum, row)| *sum += sign * fills(row));
}

/// The part of the hemisphere that is left.
pub(crate) fn left(covered: f64) -> f64 {
    largest(1.0 - covered, 0.0) + MARGIN
}

/// Half of the most light of clusters of these areas with an even radiosity, over their power, if they get no more of the
/// hemisphere than `rest`, the first ones first.
pub(crate) fn even<'a>(mut rest: f64, seen: impl Iterator<Item = (&'a View, f64)>) -> impl Iterator<Item = f64> {
    seen.map(move |(view, area)| {
        let by_peak = if view.peak.is_finite() { view.peak * area } else { f64::INFINITY };
        let part = smallest(smallest(by_peak, view.factor), rest);
        rest -= part;
        0.5 * part / area
    })
}

/// The most light that clusters may add, and subtract where they are negative, the brightest first, if they get no more of the
/// hemisphere than `rest`.
pub(crate) fn fill<'a>(rest: f64, brightest_first: impl Iterator<Item = (&'a View, &'a Glow)>) -> [f64; 2] {
    let (mut sums, mut rests) = ([0.0; 2], [rest; 2]);
    for (view, glow) in brightest_first {
        if glow.largest == 0.0 || (rests[0] == 0.0 && rests[1] == 0.0) {
            break;
        }
        for (which, power) in [glow.positive, glow.negative].into_iter().enumerate() {
            let part = smallest(view.at_most(power, glow.largest) / glow.largest, rests[which]);
            sums[which] += part * glow.largest;
            rests[which] -= part;
        }
    }
    sums
}
