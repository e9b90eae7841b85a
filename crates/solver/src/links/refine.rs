//! The links of a receiver: all elements that it sees, linked as roughly as is allowed.
//!
//! Links are refined where the light they neglect, times the reflectance, is too large: Hanrahan's brightness-weighted refinement,
//! with a bound in the place of the brightness.
//!
//! Where faces are many a receiver begins with one cluster of all of them ([`crate::mesh::clusters`]). The one that is off most,
//! by an estimate, is opened, and its elements at last linked, until the error of all closed ones
//! and the light that links neglect are together within the allowed error.

use crate::clock::Clock;
use crate::error::Error;
use crate::field::Field;
use crate::links::cluster::cut::Cut;
use crate::links::cluster::far::Far;
use crate::links::cluster::sampled::{Draw, FEWEST_RAYS, MOST_RAYS, Rays};
use crate::links::gatherer::Gatherer;
use crate::links::link::{Link, rows};
use crate::links::station::Station;
use crate::links::transfer::{Kernel, Optics, Row};
use crate::mesh::Sight;
use crate::mesh::basis::Basis;
use radgrad_scene::largest;

/// How rough the links of a receiver may be.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Need<'a> {
    pub(crate) field: &'a Field,
    /// Weight of the error in each channel; the largest product counts.
    pub(crate) weight: &'a [f64],
    /// The sum of the errors of all links.
    pub(crate) allowed: f64,
    /// How much more clusters may be off by, and their rays.
    pub(crate) without_order: f64,
    pub(crate) of_rays: f64,
    pub(crate) clock: Clock,
}

/// The part of the allowed sum above which a link, one of a hundred, is surely refined.
const SURELY: f64 = 0.05;

/// The part of the allowed sum that clusters may take before they are opened rather than links refined.
const FAR_PART: f64 = 0.7;

/// The part of rays in the allowed error of clusters, in the mean over the nodes.
const RAYS_PART: f64 = 0.5;

/// The same before rays are drawn to find which to open, beyond the difference of the gathering rays from these.
const FAR_BEFORE: f64 = 1.0;

/// Clusters that a receiver opens whatever the time.
const OPENED: usize = 24;

/// The brightness from which on, and the part of the allowed sum above which, a link is evaluated once more.
const BRIGHT: f64 = 10.0;
const EVALUATED_PART: f64 = 0.05;

/// How much more clusters may be off by than links may neglect: too much as often as too little, so that gathers of it average it out.
pub(crate) const WITHOUT_ORDER: f64 = 3.0;

impl Optics<'_> {
    /// Links a gatherer to the sources that it sees, each with the faces that may be between; or to the children of those that
    /// would be refined anyway.
    pub(crate) fn links<'a>(
        &self,
        gatherer: Gatherer<'_>,
        sources: impl Iterator<Item = (usize, Option<&'a [usize]>)>,
        need: &Need<'_>,
    ) -> Result<Vec<Link>, Error> {
        let stations = gatherer.stations(self.mesh);
        let mut links = Vec::new();
        let mut open: Vec<(usize, Option<Vec<usize>>)> =
            sources.map(|(source, known)| (source, known.map(<[_]>::to_vec))).collect();
        while let Some((source, known)) = open.pop() {
            let sight = gatherer.sight(self.mesh, source, known.as_deref())?;
            if matches!(sight, Sight::Nothing(_)) {
                continue;
            }
            let is_too_rough = || self.is_too_rough(&stations, source, need);
            if let Some(first) = self.mesh.elements()[source].children().filter(|_| is_too_rough()) {
                open.extend((first..first + 4).map(|child| (child, Some(sight.faces().to_vec()))));
                continue;
            }
            links.push(self.evaluated(gatherer, &stations, (source, sight), need)?);
        }
        Ok(links)
    }

    /// A link, evaluated as precisely as its source is bright.
    fn evaluated(
        &self,
        gatherer: Gatherer<'_>,
        stations: &[Station],
        (source, sight): (usize, Sight),
        need: &Need<'_>,
    ) -> Result<Link, Error> {
        let (count, optics) = (self.mesh.basis(source).len(), self.for_light(need.field, source, need.weight));
        let rows = stations.iter().map(|station| optics.receive(station, source, &sight, count));
        let rows = rows.collect::<Result<Vec<Row>, _>>()?;
        let matrix = gatherer.basis(self.mesh).map_or_else(Vec::new, |basis| projected(basis, &rows, count));
        Ok(Link { source, sight, rows, matrix })
    }

    /// Evaluates links once more whose sources became so bright that errors of evaluations count, while there is time. Returns whether
    /// there were any.
    fn evaluate_bright(&self, gatherer: Gatherer<'_>, links: &mut [Link], need: &Need<'_>) -> Result<bool, Error> {
        let mut any = false;
        for link in links.iter_mut() {
            let brightness = self.for_light(need.field, link.source, need.weight).brightness;
            // Rays are drawn for all sources alike.
            let counts = |row: &Row| row.likely.is_none() && row.error * brightness > EVALUATED_PART * need.allowed;
            if brightness > BRIGHT && link.rows.iter().any(counts) && !need.clock.is_over() {
                *link = self.evaluated(gatherer, &gatherer.stations(self.mesh), (link.source, link.sight.clone()), need)?;
                any = true;
            }
        }
        Ok(any)
    }

    /// For a source whose light has this size in each channel, errors of which have these weights.
    pub(crate) fn for_light(self, field: &Field, source: usize, weight: &[f64]) -> Self {
        let size = |(channel, weight): (usize, &f64)| {
            weight * field.coefficients(source, channel).iter().map(|c| c * c).sum::<f64>().sqrt()
        };
        self.for_brightness(weight.iter().enumerate().map(size).fold(0.0, largest))
    }

    /// Whether a link would surely be refined, by the kernel at a few nodes as if all were seen.
    fn is_too_rough(&self, stations: &[Station], source: usize, need: &Need<'_>) -> bool {
        let element = &self.mesh.elements()[source];
        let error = |station: &Station| {
            let kernel = Kernel::bound(station, element);
            let weighted_neglect =
                |(channel, weight): (usize, &f64)| weight * need.field.smoothly_neglected(self.mesh, source, channel, &kernel);
            need.weight.iter().enumerate().map(weighted_neglect).fold(0.0, largest)
        };
        let few = [0, stations.len() / 2, stations.len() - 1];
        few.iter().map(|&node| error(&stations[node])).fold(0.0, largest) > SURELY * need.allowed
    }

    /// The first links of a gatherer: to all roots, or to one cluster of them; or to the sources of its parent.
    pub(crate) fn first_links(
        &self,
        gatherer: Gatherer<'_>,
        of_parent: Option<(&[Link], &Far)>,
        need: &Need<'_>,
    ) -> Result<(Vec<Link>, Far), Error> {
        let tree = self.mesh.clusters();
        let root = tree.root();
        let (links, mut clusters) = match of_parent {
            Some((links, far)) => {
                let sources = links.iter().map(|link| (link.source, Some(link.sight.faces())));
                (self.links(gatherer, sources, need)?, far.clusters().to_vec())
            }
            None if root.is_some() => (Vec::new(), root.into_iter().collect()),
            None => (self.links(gatherer, self.mesh.roots().iter().map(|&root| (root, None)), need)?, Vec::new()),
        };
        clusters.retain(|&cluster| gatherer.may_see(self.mesh, &tree.clusters()[cluster]));
        let stations = if clusters.is_empty() { Vec::new() } else { gatherer.stations(self.mesh) };
        // An element looks at its clusters before it gathers, by rays of its own.
        let first = if matches!(gatherer, Gatherer::Element(_)) { 1 } else { FEWEST_RAYS };
        let count = of_parent.map_or(first, |(_, far)| far.rays());
        let far = Far::seen_by(self, (&stations, count), clusters, rows(&links));
        Ok((links, self.projected(gatherer, far)))
    }

    /// Rays from each node for the allowed error of clusters: N of them see light of this root mean square to one over the root
    /// of N.
    fn rays_for(&self, nodes: usize, need: &Need<'_>) -> usize {
        let Some(root) = self.mesh.clusters().root() else { return FEWEST_RAYS };
        let light = |(channel, weight): (usize, &f64)| {
            let glow = need.field.glow(root, channel);
            if glow.square > 0.0 { weight * (glow.square / glow.area).sqrt() } else { 0.0 }
        };
        let light = need.weight.iter().enumerate().map(light).fold(0.0, largest);
        let count = (light / (RAYS_PART * need.of_rays * need.allowed)).powi(2) / nodes as f64;
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a cast saturates, and the limits are small")]
        (count.ceil() as usize).clamp(FEWEST_RAYS, MOST_RAYS)
    }

    /// Opens clusters and refines links of a receiver until the neglected light is within the allowed error at every node,
    /// nothing is left to refine, or there is no time: each time the worst one at the node with the largest sum. Clusters that were never
    /// looked at are, and some opened, whatever the time: else all that one receiver has time for would be missing from another. Returns
    /// whether any was.
    pub(crate) fn refine(
        &self,
        gatherer: Gatherer<'_>,
        (links, far): (&mut Vec<Link>, &mut Far),
        need: &Need<'_>,
    ) -> Result<bool, Error> {
        let &Need { field, weight, allowed, without_order, .. } = need;
        let evaluated = self.evaluate_bright(gatherer, links, need)?;
        let mut errors: Vec<Vec<f64>> = links.iter().map(|link| self.weighted_errors(link, field, weight)).collect();
        let is_new = !far.is_empty() && far.rays() < FEWEST_RAYS;
        let wanted = if need.clock.is_over() { FEWEST_RAYS } else { self.rays_for(gatherer.len(self.mesh), need) };
        let count = wanted.max(far.rays());
        let mut to_open = if is_new { OPENED } else { 0 };
        let mut cut = Cut::new(self, field, weight, far, count >= MOST_RAYS);
        let stations = if far.is_empty() { Vec::new() } else { gatherer.stations(self.mesh) };
        let mut sums = vec![0.0; gatherer.len(self.mesh)];
        let mut rays: Option<Vec<Rays>> = None;
        let mut opened = !far.is_empty() && count > far.rays() && (is_new || !need.clock.is_over());
        let mut refined = false;
        while to_open > 0 || !need.clock.is_over() {
            let cluster_errors: Vec<f64> = cut.likely().into_iter().map(|error| error / without_order).collect();
            sums.fill(0.0);
            errors.iter().chain([&cluster_errors]).for_each(|of| sums.iter_mut().zip(of).for_each(|(sum, error)| *sum += error));
            let node = (0..sums.len()).max_by(|&a, &b| sums[a].total_cmp(&sums[b]));
            let Some(node) = node.filter(|&node| sums[node] > allowed) else { break };
            let part = if rays.is_some() { FAR_PART } else { FAR_BEFORE };
            let is_far = cluster_errors.get(node).is_some_and(|&error| error > part * allowed);
            if is_far && rays.is_none() {
                let drawn: Vec<Rays> = stations.iter().map(|station| self.rays(station, count, Draw::First)).collect();
                cut.look(&stations, &drawn);
                rays = Some(drawn);
                continue;
            }
            let finer = if is_far && let Some(element) = cut.open(gatherer, &stations, rays.as_deref().unwrap_or_default()) {
                opened = true;
                to_open = to_open.saturating_sub(1);
                self.links(gatherer, element.into_iter().map(|element| (element, None)), need)?
            } else {
                to_open = 0;
                if need.clock.is_over() {
                    break;
                }
                let worst = (0..links.len()).max_by(|&a, &b| errors[a][node].total_cmp(&errors[b][node]));
                let Some(worst) = worst.filter(|&w| errors[w][node] > 0.0) else { break };
                let Some(first) = self.mesh.elements()[links[worst].source].children() else {
                    errors[worst].fill(0.0);
                    continue;
                };
                refined = true;
                let link = links.swap_remove(worst);
                errors.swap_remove(worst);
                self.links(gatherer, (first..first + 4).map(|child| (child, Some(link.sight.faces()))), need)?
            };
            for link in finer {
                errors.push(self.weighted_errors(&link, field, weight));
                links.push(link);
            }
        }
        if opened || (refined && !far.is_empty()) {
            *far = self.projected(gatherer, cut.closed((&stations, count), rows(links)));
        }
        Ok(opened || refined || evaluated)
    }

    /// With the gather from clusters of the functions of an element's basis.
    fn projected(&self, gatherer: Gatherer<'_>, far: Far) -> Far {
        match gatherer.basis(self.mesh) {
            Some(basis) => far.projected(basis),
            None => far,
        }
    }

    /// Bound on the light that a link neglects at each node, the largest of the channels after each is multiplied by its weight.
    fn weighted_errors(&self, link: &Link, field: &Field, weight: &[f64]) -> Vec<f64> {
        let of_row = |row: &Row| {
            let neglected = |(channel, weight): (usize, &f64)| weight * field.neglected(self.mesh, link.source, channel, row);
            weight.iter().enumerate().map(neglected).fold(0.0, largest)
        };
        link.rows.iter().map(of_row).collect()
    }
}

/// The projection on a receiver's basis of the light of a source's functions at its nodes.
fn projected(basis: &Basis, rows: &[Row], count: usize) -> Vec<f64> {
    let mut matrix = vec![0.0; basis.len() * count];
    for (node, row) in rows.iter().enumerate().filter(|(_, row)| row.factor() > 0.0) {
        let weight = basis.nodes()[node].weight;
        for (own, value) in matrix.chunks_exact_mut(count).zip(basis.at_node(node)) {
            own.iter_mut().zip(&row.values).for_each(|(m, v)| *m += weight * value * v);
        }
    }
    matrix
}
