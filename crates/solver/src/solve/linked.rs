//! Links of a round: of new receivers, and refined where they neglect too much.

use rayon::prelude::*;

use crate::clock::Clock;
use crate::error::Error;
use crate::links::cluster::far::Far;
use crate::links::gatherer::Gatherer;
use crate::links::link::Link;
use crate::links::linking::Linking;
use crate::links::refine::Need;
use crate::solve::solution::{Solution, for_each};

impl Solution {
    /// Links receivers that have none, to what their parent's links had for sources; these go.
    pub(super) fn link(&mut self, allowed: f64, linking: Linking, clock: Clock) -> Result<(), Error> {
        self.links.resize(self.mesh.elements().len(), Vec::new());
        self.far.resize(self.mesh.elements().len(), Far::default());
        self.own.resize(self.mesh.elements().len(), Vec::new());
        let new: Vec<usize> = self.receivers.iter().copied().filter(|&receiver| !self.gathers(receiver)).collect();
        let optics = self.optics();
        let of_parent = |element: usize| {
            let parent = self.mesh.elements()[element].parent().filter(|&parent| self.gathers(parent))?;
            Some((&self.links[parent][..], &self.far[parent]))
        };
        let of = |receiver: usize| {
            let need = Need { field: &self.field, weight: &self.weight(receiver), allowed, linking, clock };
            optics.first_links(Gatherer::Element(receiver), of_parent(receiver), &need)
        };
        let links = for_each(&new, of)?;
        for (&receiver, (links, far)) in new.iter().zip(links) {
            (self.links[receiver], self.far[receiver]) = (links, far);
            let basis = self.mesh.basis(receiver);
            let len = basis.len();
            let restricted = |channel: usize| match self.mesh.elements()[receiver].parent().map(|p| &self.own[p]) {
                Some(own) if !own.is_empty() => {
                    basis.restrict(self.mesh.child(receiver), &own[channel * len..(channel + 1) * len])
                }
                _ => vec![0.0; len],
            };
            self.own[receiver] = (0..self.channels.len()).flat_map(restricted).collect();
        }
        let mut receives = vec![false; self.links.len()];
        self.receivers.iter().for_each(|&receiver| receives[receiver] = true);
        for index in (0..self.links.len()).filter(|&index| !receives[index]) {
            (self.links[index], self.far[index]) = (Vec::new(), Far::default());
            self.own[index] = Vec::new();
        }
        Ok(())
    }

    /// What an error of the irradiance counts for, relative to what errors are.
    fn weight(&self, receiver: usize) -> Vec<f64> {
        let mut weight = self.weight_of(&self.surfaces.reflectance[self.mesh.elements()[receiver].face()]);
        weight.iter_mut().enumerate().for_each(|(channel, weight)| *weight *= self.carefully(receiver, channel));
        weight
    }

    /// The same where this much of the irradiance counts.
    pub(super) fn weight_of(&self, rho: &[f64]) -> Vec<f64> {
        rho.iter().zip(self.reference()).map(|(rho, mean)| if mean > 0.0 { rho / mean } else { 0.0 }).collect()
    }

    /// Refines links of all receivers, until there is no time. Returns whether any was.
    pub(super) fn refine(&mut self, allowed: f64, clock: Clock) -> Result<bool, Error> {
        let (links, far) = (&mut self.links, &mut self.far);
        let take = |&receiver: &usize| (std::mem::take(&mut links[receiver]), std::mem::take(&mut far[receiver]));
        let taken: Vec<(Vec<Link>, Far)> = self.receivers.iter().map(take).collect();
        let (optics, linking) = (self.optics(), Linking::Error);
        let refined: Vec<(Vec<Link>, Far, bool)> = self
            .receivers
            .par_iter()
            .zip(taken)
            .map(|(&receiver, (mut links, mut far))| {
                let need = Need { field: &self.field, weight: &self.weight(receiver), allowed, linking, clock };
                let changed = optics.refine(Gatherer::Element(receiver), (&mut links, &mut far), &need)?;
                Ok((links, far, changed))
            })
            .collect::<Result<_, Error>>()?;
        let mut any = false;
        for (&receiver, (links, far, changed)) in self.receivers.iter().zip(refined) {
            any |= changed;
            (self.links[receiver], self.far[receiver]) = (links, far);
        }
        Ok(any)
    }
}
