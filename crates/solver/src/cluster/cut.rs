//! The cut through the tree of clusters where a receiver leaves it: which cluster is opened next, and what those that stay closed
//! neglect together.

use super::far::{Far, Glow, cover, fill, left, scale};
use super::{Clusters, Parts, View};
use crate::field::Field;
use crate::link::Link;
use crate::mesh::Mesh;
use crate::transfer::{Row, Station};

/// Faces of which it is asked whether they hide a cluster.
const SCREENS: usize = 16;

/// Of so many clusters one is opened before what they neglect is summed again.
const AT_ONCE: usize = 8;

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
    /// The brightest first, in the first channel.
    closed: Vec<Closed>,
    nodes: usize,
    /// The part of the hemisphere that links fill.
    covered: Vec<f64>,
    factors: Vec<f64>,
    even: Vec<f64>,
    /// Faces that fill most of the view, and how much, the largest part first.
    screens: Vec<(f64, usize)>,
}

fn brightness(closed: &Closed, channel: usize) -> f64 {
    closed.glows.get(channel).map_or(0.0, |glow| glow.largest)
}

impl<'a> Cut<'a> {
    /// That of a receiver's clusters, with what its links give at the nodes.
    pub(crate) fn new(mesh: &'a Mesh, field: &'a Field, weight: &'a [f64], far: &Far, links: &[Link]) -> Self {
        let (nodes, channels) = (far.nodes(), weight.len());
        let (covered, factors) = (vec![0.0; nodes], vec![0.0; nodes]);
        let even = vec![0.0; channels * nodes];
        let mut cut = Self { mesh, field, weight, closed: Vec::new(), nodes, covered, factors, even, screens: Vec::new() };
        for (index, &cluster) in far.clusters().iter().enumerate() {
            cut.close(cluster, (0..nodes).map(|node| *far.view(index, node)).collect());
        }
        if nodes > 0 {
            links.iter().for_each(|link| cut.cover(link, 1.0));
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
        let place = self.closed.partition_point(|other| brightness(other, 0) >= brightness(&closed, 0));
        self.closed.insert(place, closed);
    }

    /// Adds to the sums, or takes away.
    fn sum(&mut self, closed: &Closed, sign: f64) {
        let area = self.tree().all()[closed.cluster].area();
        for (node, view) in closed.views.iter().enumerate().filter(|(_, view)| view.factor > 0.0) {
            self.factors[node] += sign * view.factor;
            for (channel, glow) in closed.glows.iter().enumerate() {
                let at = channel * self.nodes + node;
                self.even[at] += sign * view.even(area) * glow.power;
            }
        }
    }

    /// A link fills a part of the hemisphere, or no more.
    pub(crate) fn cover(&mut self, link: &Link, sign: f64) {
        if self.tree().are_apart() {
            cover(&mut self.covered, &link.rows, sign);
        }
        let face = self.mesh.elements()[link.source].face();
        let part = link.rows.iter().map(Row::factor).fold(0.0, f64::max);
        match self.screens.iter_mut().find(|screen| screen.1 == face) {
            Some(screen) => screen.0 = screen.0.max(part),
            None => self.screens.push((part, face)),
        }
        self.screens.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
        self.screens.truncate(SCREENS);
    }

    /// Whether nothing of a cluster is seen past one of the faces that fill most of the view.
    fn is_hidden(&self, receiver: usize, cluster: usize) -> bool {
        let (from, to) = (self.mesh.elements()[receiver].polygon().vertices(), self.tree().all()[cluster].corners());
        self.screens.iter().any(|&(_, face)| self.mesh.hides(face, [from, &to]))
    }

    /// What all closed clusters neglect at most at each node, the largest of the channels after each is multiplied by its weight:
    /// [`Far::neglected`]. Nothing if none is closed.
    pub(crate) fn neglected(&self) -> Vec<f64> {
        if self.closed.is_empty() {
            return Vec::new();
        }
        let mut most = vec![0.0_f64; self.nodes];
        for (channel, weight) in self.weight.iter().enumerate() {
            let mut order: Vec<&Closed> = self.closed.iter().collect();
            // Sorted already in the first channel.
            order.sort_by(|a, b| brightness(b, channel).total_cmp(&brightness(a, channel)));
            let of_node = |node: usize| {
                let (rest, at) = (left(self.covered[node]), channel * self.nodes + node);
                let value = scale(rest, self.factors[node]) * self.even[at];
                let [high, low] = fill(rest, order.iter().map(|closed| (&closed.views[node], &closed.glows[channel])));
                (high - value).max(value + low)
            };
            most.iter_mut().enumerate().for_each(|(node, most)| *most = most.max(weight * of_node(node)));
        }
        most
    }

    /// Opens the clusters that may give most, a few at once, until one is an element, which is to be linked then. `None` if none
    /// gives anything. One that is hidden is left out.
    pub(crate) fn open(&mut self, receiver: usize, stations: &[Station]) -> Option<Option<usize>> {
        let few = self.closed.len() / AT_ONCE;
        let mut opened = self.open_one(receiver, stations)?;
        for _ in 0..few {
            if opened.is_some() {
                break;
            }
            opened = self.open_one(receiver, stations).flatten();
        }
        Some(opened)
    }

    fn open_one(&mut self, receiver: usize, stations: &[Station]) -> Option<Option<usize>> {
        let largest = |a: &usize, b: &usize| {
            let [a, b] = [a, b].map(|&index| &self.closed[index]);
            a.most.total_cmp(&b.most).then(b.cluster.cmp(&a.cluster))
        };
        let largest = (0..self.closed.len()).max_by(largest).filter(|&index| self.closed[index].most > 0.0)?;
        let opened = self.closed.remove(largest);
        self.sum(&opened, -1.0);
        if self.is_hidden(receiver, opened.cluster) {
            return Some(None);
        }
        match self.tree().all()[opened.cluster].parts {
            Parts::Element(element) => Some(Some(element)),
            Parts::Two(parts) => {
                let (tree, element) = (self.tree(), &self.mesh.elements()[receiver]);
                for part in parts.into_iter().filter(|&part| tree.all()[part].faces(element)) {
                    self.close(part, stations.iter().map(|station| tree.all()[part].view(station)).collect());
                }
                Some(None)
            }
        }
    }

    /// What is to be kept: those that are not hidden.
    pub(crate) fn closed<'b>(mut self, receiver: usize, rows: impl Iterator<Item = &'b [Row]>) -> Far {
        let tree = self.tree();
        let closed = std::mem::take(&mut self.closed);
        self.closed = closed.into_iter().filter(|closed| !self.is_hidden(receiver, closed.cluster)).collect();
        let clusters = self.closed.iter().map(|closed| closed.cluster).collect();
        let views = self.closed.into_iter().flat_map(|closed| closed.views).collect();
        Far::new(tree, clusters, views, self.nodes, rows)
    }
}
