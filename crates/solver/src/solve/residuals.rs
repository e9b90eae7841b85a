//! Projection residuals of direct and of reflected light, on every element.

use radgrad_scene::{largest, smallest};
use rayon::prelude::*;

use crate::estimate::residual::{Residual, Residuals};
use crate::mesh::Sight;
use crate::solve::solution::Solution;

impl Solution {
    /// The part of a residual that division reduces: the detail of a texture stays, but gathers of it fall off with the power of
    /// their size that the kernel's Taylor polynomial leaves.
    pub(super) fn reducible(&self, element: usize, residual: &Residual) -> f64 {
        if residual.mean_detail() == 0.0 {
            return residual.mean();
        }
        let size = smallest(self.element(element).radius() / self.system.extent, 1.0);
        let fades: f64 = std::iter::repeat_n(size, self.basis(element).degree() + 1).product();
        residual.mean() + residual.mean_detail() * fades
    }

    pub(super) fn residual_on_leaf(&self, leaf: usize, channel: usize) -> Residual {
        let (element, basis) = (self.element(leaf), self.basis(leaf));
        let rho = self.system.surfaces.reflectance[element.face()][channel];
        let mut residual = Residual::project(element, basis, &self.direct_samples(leaf, channel));
        if let Some(pattern) = self.system.surfaces.pattern(leaf, channel) {
            let detail = pattern.detail(basis, &self.direct_irradiance(leaf, channel), false);
            residual = residual.textured(element, pattern, rho, detail);
        }
        if let Some(unseen) = &self.radiosity.unseen[leaf] {
            residual = residual.with_unseen(element, basis.nodes().len(), unseen[channel].map(|light| rho * light));
        }
        for lit in &self.radiosity.direct[leaf].nodes {
            let [clear, past] = lit.likely[channel];
            residual.largest.computation = largest(residual.largest.computation, rho * clear);
            residual.largest.visibility = largest(residual.largest.visibility, rho * past);
        }
        residual
    }

    /// For each channel, bounds on the light of lamps that no node of a leaf sees, at most and in the mean, if there may be any.
    pub(super) fn unseen_on(&self, leaf: usize) -> Option<Vec<[f64; 2]>> {
        let lamps: Vec<(usize, &[usize])> = self.radiosity.direct[leaf].unseen(&self.system.lamps).collect();
        let unseen_in = |channel: usize| {
            let emitted = |root: usize| self.system.surfaces.emitted[self.element(root).face()][channel];
            let sources = lamps.iter().map(|&(root, faces)| (root, faces, emitted(root)));
            self.outlined().unseen(leaf, sources)
        };
        (!lamps.is_empty()).then(|| (0..self.channels().len()).map(unseen_in).collect())
    }

    /// Projection residuals of direct light, everywhere.
    pub(super) fn residuals_of_direct(&self) -> Residuals {
        let channels = self.channels().len();
        if self.radiosity.direct.is_empty() {
            return vec![vec![Residual::default(); channels]; self.system.mesh.elements().len()];
        }
        let leaves: Vec<usize> = self.system.mesh.leaves().collect();
        let on_leaf = |&leaf: &usize| (0..channels).map(|channel| self.residual_on_leaf(leaf, channel)).collect();
        let residuals = leaves.par_iter().map(on_leaf).collect();
        Residual::everywhere(&self.system.mesh, &leaves, residuals, channels)
    }

    /// Projection residuals of reflected light on receivers, everywhere.
    pub(super) fn residuals_of_reflected(&self) -> Residuals {
        let channels = self.channels().len();
        let on_receiver = |&receiver: &usize| (0..channels).map(|channel| self.residual_on_receiver(receiver, channel)).collect();
        let residuals = self.system.receivers.par_iter().map(on_receiver).collect();
        Residual::everywhere(&self.system.mesh, &self.system.receivers, residuals, channels)
    }

    fn residual_on_receiver(&self, receiver: usize, channel: usize) -> Residual {
        let (element, basis, links) = (self.element(receiver), self.basis(receiver), &self.system.links[receiver]);
        let (rho, emitted) =
            (self.system.surfaces.reflectance[element.face()][channel], self.system.surfaces.emitted[element.face()][channel]);
        let emitted = if self.is_lamp(element.face()) { 0.0 } else { emitted };
        let far = &self.system.far[receiver];
        let at_nodes = self.system.irradiance(&self.radiosity.field, receiver, channel);
        let samples: Vec<f64> = at_nodes.iter().map(|h| rho * h).collect();
        let mut residual = Residual::project(element, basis, &samples);

        let held = &self.radiosity.own[receiver][channel * basis.len()..(channel + 1) * basis.len()];
        let mut difference = match self.system.surfaces.pattern(receiver, channel) {
            None => basis.project(&samples),
            Some(pattern) => {
                let projected = basis.project(&at_nodes);
                residual = residual.textured(element, pattern, rho, pattern.detail(basis, &projected, true));
                pattern.reflected(&projected)
            }
        };
        difference.iter_mut().zip(held).for_each(|(p, b)| *p -= b);
        difference.iter_mut().zip(self.emitted_on(receiver, channel)).for_each(|(p, e)| *p += e);
        residual.largest.solver = basis.magnitude(&difference);
        if far.is_empty() && at_nodes.iter().all(|h| *h == 0.0) {
            // All samples are 0, and say nothing of light between the nodes.
            let past = links.iter().filter(|link| matches!(link.sight, Sight::Past(_)));
            let size = |source: usize| {
                self.basis(source).magnitude(self.radiosity.field.coefficients(source, channel))
                    + self.radiosity.field.left_out(source, channel)
            };
            let sources = past.map(|link| (link.source, link.sight.faces(), size(link.source)));
            let unseen = self.outlined().unseen(receiver, sources);
            residual = residual.with_unseen(element, basis.nodes().len(), unseen.map(|light| rho * light));
        }
        for (node, sample) in samples.iter().enumerate() {
            let mut neglected = far.likely(&self.radiosity.field, channel, node);
            let (mut clear, mut past) = (0.0, 0.0);
            for link in links {
                let row = &link.rows[node];
                neglected += self.radiosity.field.neglected(&self.system.mesh, link.source, channel, row);
                let size = row.likely_error_of(self.radiosity.field.coefficients(link.source, channel));
                if matches!(link.sight, Sight::Past(_)) { past += size } else { clear += size }
            }
            // The sums themselves round.
            let adds = rho > 0.0 && !(links.is_empty() && far.is_empty());
            let rounds = if adds { 2.0 * f64::EPSILON * (links.len() + 2) as f64 } else { 0.0 };
            let summed = rounds * (sample.abs() + emitted);
            let maxima = &mut residual.largest;
            maxima.computation = largest(maxima.computation, rho * (neglected + clear) + summed);
            maxima.visibility = largest(maxima.visibility, rho * past);
        }
        residual
    }
}
