//! Direct light of a round: projected on new leaves, which are divided until little is left out.

use crate::clock::Clock;
use crate::error::Error;
use crate::gathering::ratio;
use crate::solve::divide::{bulk, part_to_divide};
use crate::solve::options::{Marking, Options};
use crate::solve::solution::{Solution, for_each};
use radgrad_scene::largest;

/// The part of the error asked for that direct light may leave out in the mean.
const DIRECT_PART: f64 = 0.15;

impl Solution {
    /// Projects direct light on new leaves, and divides leaves until its projection residual is small, or there is no time.
    pub(super) fn light(&mut self, aim: f64, options: &Options, clock: Clock) -> Result<(), Error> {
        let apart = options.marking == Marking::Residual;
        loop {
            self.project_direct()?;
            if self.radiosity.direct.is_empty() || !apart || self.is_full(options) || clock.is_over() {
                return Ok(());
            }
            let marked = self.marked_by_direct();
            let residual: f64 = marked.iter().map(|m| m.0).sum();
            self.refinement.direct_residual = residual / DIRECT_PART;
            // A NaN is refused after the round.
            let allowed = if self.may_be_missed() { 0.0 } else { DIRECT_PART * aim };
            if residual <= allowed || residual.is_nan() {
                return Ok(());
            }
            for leaf in bulk(marked, part_to_divide(allowed / residual)) {
                self.system.mesh.divide(leaf)?;
            }
        }
    }

    /// Projects direct light on the elements that are new, and finds the light that none of their nodes sees.
    fn project_direct(&mut self) -> Result<(), Error> {
        let first_new = self.radiosity.direct.len();
        let new: Vec<usize> = (first_new..self.system.mesh.elements().len()).collect();
        if !self.system.lamps.is_empty() {
            let optics = self.optics();
            let above = |element: usize| self.element(element).parent().and_then(|p| self.radiosity.direct.get(p));
            let light_on = |element: usize| self.system.lamps.light(&optics, &self.system.surfaces, element, above(element));
            let direct = for_each(&new, light_on)?;
            self.radiosity.direct.extend(direct);
        }
        self.radiosity.field.grow(&self.system.mesh);
        self.system.surfaces.grow(&self.system.mesh);
        if self.radiosity.direct.is_empty() {
            return Ok(());
        }
        let leaves: Vec<usize> = new.into_iter().filter(|&element| self.element(element).is_leaf()).collect();
        for &element in &leaves {
            for channel in 0..self.channels().len() {
                let mut change = self.projected(element, channel);
                if let Some(parent) = self.element(element).parent().filter(|_| first_new > 0) {
                    let basis = self.basis(element);
                    let held = basis.restrict(self.system.mesh.child(element), &self.projected(parent, channel));
                    change.iter_mut().zip(held).for_each(|(c, h)| *c -= h);
                }
                self.radiosity.field.add(&self.system.mesh, element, channel, &change);
            }
        }
        self.radiosity.unseen.resize(self.system.mesh.elements().len(), None);
        let unseen = for_each(&leaves, |leaf| Ok(self.unseen_on(leaf)))?;
        leaves.into_iter().zip(unseen).for_each(|(leaf, unseen)| self.radiosity.unseen[leaf] = unseen);
        Ok(())
    }

    /// The projection residual of direct light on each leaf, as a part of the mean.
    fn marked_by_direct(&self) -> Vec<(f64, usize)> {
        let leaves: Vec<usize> = self.system.mesh.leaves().collect();
        let area: f64 = leaves.iter().map(|&leaf| self.element(leaf).area()).sum();
        // Relative to the light there is so far, or to all that lamps send if no sample has seen any.
        let mean = |channel: usize| match self.radiosity.field.mean(&self.system.mesh, channel) {
            0.0 => self.sent(channel),
            mean => mean,
        };
        let mean: Vec<f64> = (0..self.channels().len()).map(mean).collect();
        let indicator = |leaf: usize| {
            let relative_residual = |channel: usize| {
                let residual =
                    largest(self.reducible(leaf, &self.residual_on_leaf(leaf, channel)) - self.noise_on(leaf, channel), 0.0);
                match self.refinement.served.is_known() {
                    true => self.indicator_for_points(leaf, channel, residual),
                    false => self.element(leaf).area() / area * ratio(residual, mean[channel]),
                }
            };
            ((0..mean.len()).map(relative_residual).fold(0.0, largest), leaf)
        };
        leaves.into_iter().map(indicator).collect()
    }

    /// The power of lamps over all area.
    fn sent(&self, channel: usize) -> f64 {
        self.system.lamps.power(&self.system.mesh, &self.system.surfaces, channel) / self.system.mesh.area()
    }

    /// Whether no sample has seen any light in some channel, though there may be some: nothing is known relative to it yet.
    fn may_be_missed(&self) -> bool {
        let is_left = |channel: usize| self.system.mesh.leaves().any(|leaf| self.residual_on_leaf(leaf, channel).mean() > 0.0);
        (0..self.channels().len()).any(|channel| self.radiosity.field.mean(&self.system.mesh, channel) == 0.0 && is_left(channel))
    }

    /// The error of rays at the nodes of a leaf: smaller leaves would have it as well.
    fn noise_on(&self, leaf: usize, channel: usize) -> f64 {
        let rho = self.system.reflectance(leaf, channel);
        rho * self.radiosity.direct[leaf].nodes.iter().map(|lit| lit.noise[channel]).fold(0.0, largest)
    }

    /// The projection of direct light on an element, as it is reflected.
    fn projected(&self, element: usize, channel: usize) -> Vec<f64> {
        let basis = self.basis(element);
        match self.system.surfaces.pattern(element, channel) {
            None => basis.project(&self.direct_samples(element, channel)),
            Some(pattern) => pattern.reflected(&self.direct_irradiance(element, channel)),
        }
    }

    /// The projection of the irradiance of lamps on an element.
    pub(super) fn direct_irradiance(&self, element: usize, channel: usize) -> Vec<f64> {
        let at_nodes: Vec<f64> = self.radiosity.direct[element].nodes.iter().map(|lit| lit.irradiance[channel]).collect();
        self.basis(element).project(&at_nodes)
    }

    /// Irradiance of lamps at the nodes times the face's reflectance, the largest where it has a texture.
    pub(super) fn direct_samples(&self, element: usize, channel: usize) -> Vec<f64> {
        let rho = self.system.reflectance(element, channel);
        self.radiosity.direct[element].nodes.iter().map(|lit| rho * lit.irradiance[channel]).collect()
    }
}
