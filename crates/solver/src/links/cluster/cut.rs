//! The cut through the tree of clusters where a receiver leaves it: which cluster is opened next, and the light that the closed
//! ones neglect together.

use radgrad_scene::largest;
use std::collections::BTreeSet;

use crate::field::Field;
use crate::links::cluster::far::{Far, cover, even, fill, left};
use crate::links::cluster::glow::Glow;
use crate::links::cluster::screens::Screens;
use crate::links::cluster::view::View;
use crate::links::gatherer::Gatherer;
use crate::links::link::Link;
use crate::links::station::Station;
use crate::links::transfer::Row;
use crate::mesh::Mesh;
use crate::mesh::clusters::{Clusters, Parts};

/// Of so many clusters one is opened before the neglected light is summed again.
const AT_ONCE: usize = 8;

/// A cluster is opened all the same if, past the screens, more than this part of its largest possible light shows.
const SHOWN: f64 = 0.5;

/// A cluster that is not opened.
struct Closed {
    cluster: usize,
    /// From each node.
    views: Vec<View>,
    /// In each channel.
    glows: Vec<Glow>,
    /// The largest radiosity, summed over channels.
    brightness: f64,
    /// The most light that it may give to any node, weighted.
    most: f64,
    /// Whether its views already include the screens.
    asked: bool,
}

/// The closed clusters of a receiver.
pub(crate) struct Cut<'a> {
    mesh: &'a Mesh,
    field: &'a Field,
    weight: &'a [f64],
    /// The brightest first.
    closed: Vec<Closed>,
    /// The coarsest elements that links are for, or for parts of.
    linked: BTreeSet<usize>,
    nodes: usize,
    /// The part of the hemisphere that links fill.
    covered: Vec<f64>,
    screens: Screens,
}

/// Some closed clusters with one more.
fn with<'a>(others: &[&'a Closed], place: usize, one: &'a Closed) -> Vec<&'a Closed> {
    let (before, after) = others.split_at(place);
    before.iter().copied().chain([one]).chain(after.iter().copied()).collect()
}

impl<'a> Cut<'a> {
    /// That of a receiver's clusters, with the rows of its links.
    pub(crate) fn new(mesh: &'a Mesh, field: &'a Field, weight: &'a [f64], far: &Far, links: &[Link]) -> Self {
        let nodes = far.nodes();
        let (covered, linked) = (vec![0.0; nodes], BTreeSet::new());
        let mut cut = Self { mesh, field, weight, closed: Vec::new(), linked, nodes, covered, screens: Screens::default() };
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
        let closed = self.seen(cluster, views);
        self.closed.insert(self.place(&closed), closed);
    }

    fn place(&self, closed: &Closed) -> usize {
        self.closed.partition_point(|other| other.brightness >= closed.brightness)
    }

    fn seen(&self, cluster: usize, views: Vec<View>) -> Closed {
        let glows: Vec<Glow> = (0..self.weight.len()).map(|channel| *self.field.glow(cluster, channel)).collect();
        let most = views.iter().map(|view| self.most(&glows, view)).fold(0.0, largest);
        Closed { cluster, views, glows, brightness: self.field.brightness(cluster), most, asked: false }
    }

    /// The most light, weighted, in the channel where it is most.
    fn most(&self, glows: &[Glow], view: &View) -> f64 {
        let of = |(glow, weight): (&Glow, &f64)| weight * view.at_most(glow.positive, glow.largest);
        glows.iter().zip(self.weight).map(of).fold(0.0, largest)
    }

    /// A link fills a part of the hemisphere, or no more.
    pub(crate) fn cover(&mut self, link: &Link, sign: f64) {
        self.linked.insert(self.mesh.root_of(link.source));
        if self.tree().are_apart() {
            cover(&mut self.covered, &link.rows, sign);
        }
        let face = self.mesh.elements()[link.source].face();
        let part = link.rows.iter().map(Row::factor).fold(0.0, largest);
        self.screens.fill(face, part);
    }

    /// A face hides something.
    pub(crate) fn hide(&mut self, face: usize) {
        self.screens.hide(face);
    }

    /// Whether nothing of a cluster is seen past one of the faces that fill most of the view.
    fn is_hidden(&mut self, gatherer: Gatherer<'_>, cluster: usize) -> bool {
        let (from, to) = (gatherer.corners(self.mesh), self.tree().all()[cluster].corners());
        let between = self.screens.between(self.mesh, [from, &to]);
        between.into_iter().for_each(|face| self.screens.hide(face));
        between.is_some()
    }

    /// A cluster as it shows past the screens, if that is little of it: at a few nodes first.
    fn mostly_hidden(&self, of: &Closed, stations: &[Station]) -> Option<Closed> {
        let (screens, cluster) = (self.screens.polygons(self.mesh), &self.tree().all()[of.cluster]);
        let view = |station: &Station| cluster.view(station, &screens);
        let mut few = vec![0, stations.len() / 2, stations.len() - 1];
        few.dedup();
        let shows = |node: usize| self.most(&of.glows, &view(&stations[node])) > SHOWN * of.most;
        if few.into_iter().any(shows) {
            return None;
        }
        let shown = self.seen(of.cluster, stations.iter().map(view).collect());
        (shown.most <= SHOWN * of.most).then_some(Closed { asked: true, ..shown })
    }

    /// The most light that all closed clusters neglect at each node, the largest of the channels after each is multiplied by its
    /// weight: [`Far::neglected`]. Nothing if none is closed.
    pub(crate) fn neglected(&self) -> Vec<f64> {
        let closed: Vec<&Closed> = self.closed.iter().collect();
        let orders = self.orders(&closed);
        let nodes = if closed.is_empty() { 0 } else { self.nodes };
        (0..nodes).map(|node| self.neglected_at(node, &closed, &orders)).collect()
    }

    /// For each channel some closed clusters, the brightest first.
    fn orders(&self, closed: &[&Closed]) -> Vec<Vec<usize>> {
        let of_channel = |channel: usize| {
            let brightness = |index: usize| closed[index].glows[channel].largest;
            let mut order: Vec<usize> = (0..closed.len()).collect();
            order.sort_by(|&a, &b| brightness(b).total_cmp(&brightness(a)));
            order
        };
        (0..self.weight.len()).map(of_channel).collect()
    }

    /// The light that a node neglects if these are closed, the brightest first and in these orders for each channel.
    fn neglected_at(&self, node: usize, closed: &[&Closed], orders: &[Vec<usize>]) -> f64 {
        let (rest, tree) = (left(self.covered[node]), self.tree());
        let areas = closed.iter().map(|closed| (&closed.views[node], tree.all()[closed.cluster].area()));
        let weights: Vec<f64> = even(rest, areas).collect();
        let of_channel = |(channel, order): (usize, &Vec<usize>)| {
            let value: f64 = weights.iter().zip(closed).map(|(weight, of)| weight * of.glows[channel].power).sum();
            let seen = order.iter().map(|&index| (&closed[index].views[node], &closed[index].glows[channel]));
            let [high, low] = fill(rest, seen);
            self.weight[channel] * largest(high - value, value + low)
        };
        orders.iter().enumerate().map(of_channel).fold(0.0, largest)
    }

    /// Opens the clusters that may give most, a few at once, until one is an element, which is to be linked then. `None` if none
    /// gives anything. One that is hidden is left out.
    pub(crate) fn open(&mut self, gatherer: Gatherer<'_>, stations: &[Station]) -> Option<Option<usize>> {
        let few = self.closed.len() / AT_ONCE;
        let mut opened = self.open_one(gatherer, stations)?;
        for _ in 0..few {
            if opened.is_some() {
                break;
            }
            opened = self.open_one(gatherer, stations).flatten();
        }
        Some(opened)
    }

    fn open_one(&mut self, gatherer: Gatherer<'_>, stations: &[Station]) -> Option<Option<usize>> {
        let largest = |a: &usize, b: &usize| {
            let [a, b] = [a, b].map(|&index| &self.closed[index]);
            a.most.total_cmp(&b.most).then(b.cluster.cmp(&a.cluster))
        };
        let largest = (0..self.closed.len()).max_by(largest).filter(|&index| self.closed[index].most > 0.0)?;
        let opened = self.closed.remove(largest);
        if self.is_hidden(gatherer, opened.cluster) {
            return Some(None);
        }
        if !opened.asked
            && let Some(shown) = self.mostly_hidden(&opened, stations)
        {
            self.closed.insert(self.place(&shown), shown);
            return Some(None);
        }
        match self.tree().all()[opened.cluster].parts {
            Parts::Element(element) => Some(Some(element).filter(|element| !self.linked.contains(element))),
            Parts::Two(parts) => {
                let (tree, mesh) = (self.tree(), self.mesh);
                for part in parts.into_iter().filter(|&part| gatherer.may_see(mesh, &tree.all()[part])) {
                    self.close(part, stations.iter().map(|station| tree.all()[part].view(station, &[])).collect());
                }
                Some(None)
            }
        }
    }

    /// Closes clusters in the place of those in them, as long as no more than `allowed` is neglected at any node.
    ///
    /// A cluster is opened for the elements that may be in it. Once those that fill the view are linked, the links leave so little
    /// of the hemisphere that the others need not be told apart.
    pub(crate) fn merge(&mut self, stations: &[Station], allowed: f64, errors: &[Vec<f64>]) {
        let allowed: Vec<f64> = (0..self.nodes).map(|node| allowed - errors.iter().map(|of| of[node]).sum::<f64>()).collect();
        let slack: Vec<f64> = self.neglected().iter().zip(&allowed).map(|(neglected, allowed)| allowed - neglected).collect();
        let mut nodes: Vec<usize> = (0..slack.len()).collect();
        nodes.sort_by(|&a, &b| slack[a].total_cmp(&slack[b]));
        let (tree, screens) = (self.tree(), self.screens.polygons(self.mesh));
        let mut open: Vec<usize> = tree.root().into_iter().collect();
        while let Some(whole) = open.pop() {
            let others: Vec<&Closed> = self.closed.iter().filter(|closed| !tree.is_in(closed.cluster, whole)).collect();
            if others.len() + 1 >= self.closed.len() {
                continue;
            }
            let mut merged = self.seen(whole, vec![View::default(); self.nodes]);
            let place = others.partition_point(|other| other.brightness >= merged.brightness);
            let orders = self.orders(&with(&others, place, &merged));
            // The node first where the least is left.
            let fits = nodes.iter().all(|&node| {
                merged.views[node] = tree.all()[whole].view(&stations[node], &screens);
                self.neglected_at(node, &with(&others, place, &merged), &orders) <= allowed[node]
            });
            if fits {
                self.closed.retain(|closed| !tree.is_in(closed.cluster, whole));
                self.closed.insert(place, self.seen(whole, merged.views));
            } else if let Parts::Two(parts) = tree.all()[whole].parts {
                open.extend(parts);
                // The darker one first: it takes less of the allowed error.
                if self.field.brightness(parts[0]) < self.field.brightness(parts[1]) {
                    let last = open.len() - 1;
                    open.swap(last, last - 1);
                }
            }
        }
    }

    /// The clusters to keep: those that are not hidden.
    pub(crate) fn closed<'b>(mut self, gatherer: Gatherer<'_>, rows: impl Iterator<Item = &'b [Row]>) -> Far {
        let tree = self.tree();
        let closed = std::mem::take(&mut self.closed);
        self.closed = closed.into_iter().filter(|closed| !self.is_hidden(gatherer, closed.cluster)).collect();
        let clusters = self.closed.iter().map(|closed| closed.cluster).collect();
        let views = self.closed.into_iter().flat_map(|closed| closed.views).collect();
        Far::new((tree, self.field), clusters, views, self.nodes, rows)
    }
}
