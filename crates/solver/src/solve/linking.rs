//! Links of a round: of new receivers, and refined where they neglect too much.

use radgrad_scene::largest;
use rayon::prelude::*;

use crate::clock::Clock;
use crate::error::Error;
use crate::links::cluster::far::Far;
use crate::links::gatherer::Gatherer;
use crate::links::link::Link;
use crate::links::refine::{Need, WITHOUT_ORDER};
use crate::mesh::clusters::FEWEST;
use crate::solve::solution::{Solution, for_each};

/// How much more exactly than else large receivers know their clusters, and how much less small ones do, at most.
const FINER: f64 = 0.3;
const ROUGHER: f64 = 3.0;

/// Links and clusters of a receiver.
type Linked = (Vec<Link>, Far);

/// So many elements are linked to all others whatever the time.
const FEW: usize = 300;

impl Solution {
    /// Links receivers that have none, to the sources of their parent's links; these go.
    pub(super) fn link(&mut self, allowed: f64, clock: Clock) -> Result<(), Error> {
        self.system.links.resize(self.system.mesh.elements().len(), Vec::new());
        self.system.far.resize(self.system.mesh.elements().len(), Far::default());
        self.radiosity.own.resize(self.system.mesh.elements().len(), Vec::new());
        let new: Vec<usize> = self.system.receivers.iter().copied().filter(|&receiver| !self.gathers(receiver)).collect();
        let links = match self.links_of(&new, allowed, clock)? {
            Some(links) => links,
            None => {
                // There is no time to link all elements to all others.
                self.system.mesh.cluster();
                self.radiosity.field.pull(&self.system.mesh);
                self.links_of(&new, allowed, clock)?.unwrap_or_default()
            }
        };
        for (&receiver, (links, far)) in new.iter().zip(links) {
            (self.system.links[receiver], self.system.far[receiver]) = (links, far);
            let basis = self.basis(receiver);
            let len = basis.len();
            let restricted = |channel: usize| match self.element(receiver).parent().map(|p| &self.radiosity.own[p]) {
                Some(own) if !own.is_empty() => {
                    basis.restrict(self.system.mesh.child(receiver), &own[channel * len..(channel + 1) * len])
                }
                _ => vec![0.0; len],
            };
            self.radiosity.own[receiver] = (0..self.channels().len()).flat_map(restricted).collect();
        }
        let receives = self.system.receives();
        for index in (0..self.system.links.len()).filter(|&index| !receives[index]) {
            (self.system.links[index], self.system.far[index]) = (Vec::new(), Far::default());
            self.radiosity.own[index] = Vec::new();
        }
        Ok(())
    }

    /// The first links of some receivers: none in a scene without light. `None` if there are no clusters, and no time for all.
    fn links_of(&self, new: &[usize], allowed: f64, clock: Clock) -> Result<Option<Vec<Linked>>, Error> {
        if self.system.surfaces.are_dark() {
            return Ok(Some(vec![Linked::default(); new.len()]));
        }
        let optics = self.optics();
        let of_parent = |element: usize| {
            let parent = self.element(element).parent().filter(|&parent| self.gathers(parent))?;
            Some((&self.system.links[parent][..], &self.system.far[parent]))
        };
        let mean_area = self.mean_area();
        let is_long = self.system.mesh.clusters().root().is_none() && new.len() > FEW;
        let link_receiver = |receiver: usize| {
            let of_parent = of_parent(receiver);
            if is_long && of_parent.is_none() && clock.is_over() {
                return Ok(None);
            }
            let (weight, [without_order, of_rays]) = (&self.weight(receiver), self.without_order(receiver, mean_area));
            let need = Need { field: &self.radiosity.field, weight, allowed, without_order, of_rays, clock };
            optics.first_links(Gatherer::Element(receiver), of_parent, &need).map(Some)
        };
        Ok(for_each(new, link_receiver)?.into_iter().collect())
    }

    /// How much more the clusters of a receiver may be off by than its links may neglect, and how much more their rays may. Errors without order
    /// of many receivers add up by their squares, so that those of small ones count for less. What a cluster hides is alike for receivers side by
    /// side; rays are drawn for each, and the more receivers there are the fewer each needs for the same error of the mean.
    fn without_order(&self, receiver: usize, mean_area: f64) -> [f64; 2] {
        if self.system.mesh.clusters().root().is_none() {
            return [WITHOUT_ORDER; 2];
        }
        let off = WITHOUT_ORDER * (mean_area / self.element(receiver).area()).sqrt().clamp(FINER, ROUGHER);
        [off, off * largest(self.system.receivers.len() as f64 / FEWEST as f64, 1.0).sqrt()]
    }

    /// The mean area of receivers.
    fn mean_area(&self) -> f64 {
        self.system.mesh.area() / self.system.receivers.len() as f64
    }

    /// The weight of an error of the irradiance, relative to the reference of errors.
    fn weight(&self, receiver: usize) -> Vec<f64> {
        let mut weight = self.weight_of(self.reflectance_of(receiver));
        weight.iter_mut().enumerate().for_each(|(channel, weight)| *weight *= self.carefully(receiver, channel));
        weight
    }

    /// The same where this much of the irradiance counts.
    pub(super) fn weight_of(&self, rho: &[f64]) -> Vec<f64> {
        rho.iter().zip(self.reference()).map(|(rho, mean)| if mean > 0.0 { rho / mean } else { 0.0 }).collect()
    }

    /// The same where all of the irradiance counts.
    pub(super) fn whole_weight(&self) -> Vec<f64> {
        self.weight_of(&vec![1.0; self.channels().len()])
    }

    /// Refines links of all receivers, until there is no time. Returns whether any was.
    pub(super) fn refine(&mut self, allowed: f64, clock: Clock) -> Result<bool, Error> {
        let (links, far) = (&mut self.system.links, &mut self.system.far);
        let take = |&receiver: &usize| (std::mem::take(&mut links[receiver]), std::mem::take(&mut far[receiver]));
        let taken: Vec<(Vec<Link>, Far)> = self.system.receivers.iter().map(take).collect();
        let (optics, mean_area) = (self.optics(), self.mean_area());
        let refined: Vec<(Vec<Link>, Far, bool)> = self
            .system
            .receivers
            .par_iter()
            .zip(taken)
            .map(|(&receiver, (mut links, mut far))| {
                let (weight, [without_order, of_rays]) = (&self.weight(receiver), self.without_order(receiver, mean_area));
                let need = Need { field: &self.radiosity.field, weight, allowed, without_order, of_rays, clock };
                let changed = optics.refine(Gatherer::Element(receiver), (&mut links, &mut far), &need)?;
                Ok((links, far, changed))
            })
            .collect::<Result<_, Error>>()?;
        let mut any = false;
        for (&receiver, (links, far, changed)) in self.system.receivers.iter().zip(refined) {
            any |= changed;
            (self.system.links[receiver], self.system.far[receiver]) = (links, far);
        }
        Ok(any)
    }
}
