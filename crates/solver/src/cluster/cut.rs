//! The cut through the tree of clusters where a receiver leaves it: which cluster is opened next, and what those that stay closed
//! neglect together.

use super::far::{Far, Glow, cover, left, scale};
use super::{Clusters, Parts, View};
use crate::field::Field;
use crate::mesh::Mesh;
use crate::transfer::{Row, Station};

/// A cluster that is not opened.
struct Closed {
    cluster: usize,
    /// From each node.
    views: Vec<View>,
    /// In each channel.
    glows: Vec<Glow>,
    /// What it may give at most to any node, weighted.
    most: f64,
}

/// The closed clusters of a receiver, and sums over them for each channel and node.
pub(crate) struct Cut<'a> {
    mesh: &'a Mesh,
    field: &'a Field,
    weight: &'a [f64],
    closed: Vec<Closed>,
    nodes: usize,
    /// The part of the hemisphere that links fill.
    covered: Vec<f64>,
    factors: Vec<f64>,
    high: Vec<f64>,
    low: Vec<f64>,
    even: Vec<f64>,
}

impl<'a> Cut<'a> {
    /// That of a receiver's clusters, with what its links give at the nodes.
    pub(crate) fn new<'b>(
        mesh: &'a Mesh,
        field: &'a Field,
        weight: &'a [f64],
        far: &Far,
        rows: impl Iterator<Item = &'b [Row]>,
    ) -> Self {
        let (nodes, channels) = (far.nodes(), weight.len());
        let sums = || vec![0.0; channels * nodes];
        let (covered, factors) = (vec![0.0; nodes], vec![0.0; nodes]);
        let (high, low, even) = (sums(), sums(), sums());
        let mut cut = Self { mesh, field, weight, closed: Vec::new(), nodes, covered, factors, high, low, even };
        for (index, &cluster) in far.clusters().iter().enumerate() {
            cut.close(cluster, (0..nodes).map(|node| *far.view(index, node)).collect());
        }
        if nodes > 0 {
            rows.for_each(|rows| cut.cover(rows, 1.0));
        }
        cut
    }

    fn tree(&self) -> &'a Clusters {
        self.mesh.clusters()
    }

    fn close(&mut self, cluster: usize, views: Vec<View>) {
        let glows: Vec<Glow> = (0..self.weight.len()).map(|channel| *self.field.glow(cluster, channel)).collect();
        let most = |(glow, weight): (&Glow, &f64)| {
            let at_node = |view: &View| weight * view.at_most(glow.positive, glow.largest);
            views.iter().map(at_node).fold(0.0, f64::max)
        };
        let most = glows.iter().zip(self.weight).map(most).fold(0.0, f64::max);
        let closed = Closed { cluster, views, glows, most };
        self.sum(&closed, 1.0);
        self.closed.push(closed);
    }

    /// Adds to the sums, or takes away.
    fn sum(&mut self, closed: &Closed, sign: f64) {
        let area = self.tree().all()[closed.cluster].area();
        for (node, view) in closed.views.iter().enumerate().filter(|(_, view)| view.factor > 0.0) {
            self.factors[node] += sign * view.factor;
            for (channel, glow) in closed.glows.iter().enumerate() {
                let at = channel * self.nodes + node;
                self.high[at] += sign * view.at_most(glow.positive, glow.largest);
                self.low[at] += sign * view.at_most(glow.negative, glow.largest);
                self.even[at] += sign * view.even(area) * glow.power;
            }
        }
    }

    /// A link fills a part of the hemisphere, or no more.
    pub(crate) fn cover(&mut self, rows: &[Row], sign: f64) {
        if self.tree().are_apart() {
            cover(&mut self.covered, rows, sign);
        }
    }

    /// What all closed clusters neglect at most at any node, weighted: [`Far::neglected`].
    pub(crate) fn neglected(&self) -> f64 {
        if self.closed.is_empty() {
            return 0.0;
        }
        let of_channel = |(channel, weight): (usize, &f64)| {
            let largest = self.closed.iter().map(|closed| closed.glows[channel].largest).fold(0.0, f64::max);
            let of_node = |node: usize| {
                let (rest, at) = (left(self.covered[node]), channel * self.nodes + node);
                let value = scale(rest, self.factors[node]) * self.even[at];
                (self.high[at].min(rest * largest) - value).max(value + self.low[at].min(rest * largest))
            };
            weight * (0..self.nodes).map(of_node).fold(0.0, f64::max)
        };
        self.weight.iter().enumerate().map(of_channel).fold(0.0, f64::max)
    }

    /// Opens the cluster that may give most, if any gives anything. An element that it was is to be linked.
    pub(crate) fn open(&mut self, receiver: usize, stations: impl Fn() -> Vec<Station>) -> Option<Option<usize>> {
        let largest = |a: &usize, b: &usize| {
            let [a, b] = [a, b].map(|&index| &self.closed[index]);
            a.most.total_cmp(&b.most).then(b.cluster.cmp(&a.cluster))
        };
        let largest = (0..self.closed.len()).max_by(largest).filter(|&index| self.closed[index].most > 0.0)?;
        let opened = self.closed.swap_remove(largest);
        self.sum(&opened, -1.0);
        match self.tree().all()[opened.cluster].parts {
            Parts::Element(element) => Some(Some(element)),
            Parts::Two(parts) => {
                let (tree, element) = (self.tree(), &self.mesh.elements()[receiver]);
                let stations = stations();
                for part in parts.into_iter().filter(|&part| tree.all()[part].faces(element)) {
                    self.close(part, stations.iter().map(|station| tree.all()[part].view(station)).collect());
                }
                Some(None)
            }
        }
    }

    /// What is to be kept.
    pub(crate) fn closed<'b>(self, rows: impl Iterator<Item = &'b [Row]>) -> Far {
        let tree = self.tree();
        let clusters = self.closed.iter().map(|closed| closed.cluster).collect();
        let views = self.closed.into_iter().flat_map(|closed| closed.views).collect();
        Far::new(tree, clusters, views, self.nodes, rows)
    }
}
