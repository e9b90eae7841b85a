//! The quantity that a solution serves if it is not the mean: points, such as those that are asked for or those that a camera
//! sees.
//!
//! With `w(y)` the mean over the points p of `rho_p k(p, y)`, k the kernel, the error of gathers at the points is in the mean
//! `int w (r + rho G r + ...)`, and since G is the same both ways `int I r` with the importance `I = w + G rho I` (B. Smits, J.
//! Arvo and D. Salesin 1992). So `b = rho I` obeys the radiosity equation with `rho w` for the light that is emitted, over the
//! links that there are; one solution serves all points together. A receiver is divided where `I |r|` is large, and linked
//! roughly where I is small. The estimate is the sum of `I |r|` without signs, over the mean reflected radiosity at the points.

use radgrad_core::DVec3;
use radgrad_scene::{largest, smallest};
use rayon::prelude::*;

use crate::error::Error;
use crate::field::Field;
use crate::gathering::ratio;
use crate::links::cluster::far::Far;
use crate::links::transfer::Row;
use crate::solve::gather::Sum;
use crate::solve::goal_points::GoalPoints;
use crate::solve::solution::Solution;

/// Sweeps at most, and changes, relative to the mean, below which the importance is solved.
const MOST_SWEEPS: usize = 200;
const SOLVED: f64 = 1e-3;

/// The view of a point.
struct Seen {
    rows: Vec<(usize, Row)>,
    far: Far,
    rho: Vec<f64>,
    reflected: Vec<f64>,
}

impl Solution {
    /// Serves some points from now on, beside the mean.
    pub(super) fn serve(&mut self, points: &[(DVec3, DVec3)]) -> Result<(), Error> {
        self.refinement.served = GoalPoints { beside: true, ..GoalPoints::at_points(points) };
        self.find_importance()?;
        self.progress.estimate = self.estimate_at_points().unwrap_or(self.progress.estimate);
        Ok(())
    }

    /// The estimate is again that of the mean, if points were served beside it.
    pub(super) fn end_service(&mut self) {
        if self.refinement.served.beside {
            self.progress.estimate = self.relative(&self.mean_estimate());
        }
    }

    /// Finds the importance of elements for the points served.
    pub(super) fn find_importance(&mut self) -> Result<(), Error> {
        if self.refinement.served.points.is_empty() {
            return Ok(());
        }
        let views = self.refinement.served.points.par_iter().filter_map(|&point| self.seen_from(point).transpose());
        let views: Vec<Seen> = views.collect::<Result<_, Error>>()?;
        let (channels, mesh) = (self.channels().len(), &self.system.mesh);
        let count = views.len() as f64;
        let reflected = (0..channels).map(|channel| views.iter().map(|point| point.reflected[channel] / count).sum()).collect();
        let source = self.source_of_importance(&views);
        let first = |receiver: usize, channel: usize| source[receiver][channel * mesh.basis(receiver).len()];
        let scale = |channel: usize| Some(self.mean_of(&first, channel)).filter(|mean| *mean > 0.0).unwrap_or(1.0);
        let scale: Vec<f64> = (0..channels).map(scale).collect();
        let mut own: Vec<Vec<f64>> = source.iter().map(|of| vec![0.0; of.len()]).collect();
        let mut sent = Field::dark(mesh, channels);
        self.system.equation(&source).solve((&mut sent, &mut own), (SOLVED, MOST_SWEEPS), scale, |_, _| ());
        // Black receivers leave nothing out.
        let importance_on = |receiver: usize, channel: usize| match self.reflectance_of(receiver)[channel] {
            0.0 => 0.0,
            rho => largest(own[receiver][channel * mesh.basis(receiver).len()], 0.0) / rho,
        };
        let mut importance = vec![Vec::new(); mesh.elements().len()];
        for &receiver in &self.system.receivers {
            importance[receiver] = (0..channels).map(|channel| importance_on(receiver, channel)).collect();
        }
        let mean = (0..channels).map(|channel| self.mean_of(&importance_on, channel)).collect();
        (self.refinement.served.importance, self.refinement.served.mean, self.refinement.served.reflected) =
            (importance, mean, reflected);
        Ok(())
    }

    /// The reflectance of an element's face in each channel.
    pub(super) fn reflectance_of(&self, element: usize) -> &[f64] {
        &self.system.surfaces.reflectance[self.element(element).face()]
    }

    /// The mean of a function of receivers over their area.
    fn mean_of(&self, of: &dyn Fn(usize, usize) -> f64, channel: usize) -> f64 {
        let add = |(area, sum): (f64, f64), &receiver: &usize| {
            let own = self.element(receiver).area();
            (area + own, sum + own * of(receiver, channel))
        };
        let (area, sum) = self.system.receivers.iter().fold((0.0, 0.0), add);
        sum / area
    }

    /// The direct light of the elements at the points, `rho w` of the module's head: the coefficients of each element in all
    /// channels.
    fn source_of_importance(&self, seen: &[Seen]) -> Vec<Vec<f64>> {
        let (mesh, channels, count) = (&self.system.mesh, self.channels().len(), seen.len() as f64);
        let mut field = Field::dark(mesh, channels);
        let mut add = |element: usize, channel: usize, density: f64| {
            if density > 0.0 {
                field.add(mesh, element, channel, &self.even(element, density));
            }
        };
        let mut of_clusters = vec![vec![0.0; mesh.clusters().clusters().len()]; channels];
        for Seen { rows, far, rho, .. } in seen {
            for channel in 0..channels {
                for (source, row) in rows {
                    add(*source, channel, rho[channel] * row.likely_factor() / (count * mesh.elements()[*source].area()));
                }
                for (index, &cluster) in far.clusters().iter().enumerate() {
                    of_clusters[channel][cluster] += rho[channel] * far.view(index, 0).weight / count;
                }
            }
        }
        for (channel, of) in of_clusters.iter().enumerate() {
            mesh.clusters().push(of, |a, b| a + b, |element, density| add(element, channel, density));
        }
        let mut source = vec![Vec::new(); mesh.elements().len()];
        for &receiver in &self.system.receivers {
            let sent = |(channel, rho): (usize, &f64)| {
                let direct = field.coefficients(receiver, channel)[0];
                self.even(receiver, rho * direct)
            };
            source[receiver] = self.reflectance_of(receiver).iter().enumerate().flat_map(sent).collect();
        }
        source
    }

    /// The view of a point; none of one that is asked for where it cannot be.
    fn seen_from(&self, [position, normal]: [DVec3; 2]) -> Result<Option<Seen>, Error> {
        let Ok((leaf, foot)) = self.leaf_of(position, normal) else {
            let Ok(station) = self.station_in_space(position, normal) else { return Ok(None) };
            let Sum { rows, far, sums, .. } = self.sum_in_space(&station)?;
            return Ok(Some(Seen { rows, far, rho: vec![1.0; self.channels().len()], reflected: sums }));
        };
        let (_, Sum { rows, far, sums, .. }) = self.sum_on(leaf, foot)?;
        let [rho, _] = self.system.surfaces.reflectance_and_emission(self.element(leaf).face(), foot);
        let reflected = sums.iter().zip(&rho).map(|(received, rho)| received * rho).collect();
        Ok(Some(Seen { rows, far, rho, reflected }))
    }

    /// The importance of an element, as that of the receiver of the last round that it is or is below.
    fn importance_of(&self, element: usize, channel: usize) -> f64 {
        let importance = |at: usize| self.refinement.served.importance.get(at).filter(|values| !values.is_empty());
        self.system.mesh.above(element).find_map(importance).map_or(0.0, |values| values[channel])
    }

    /// The part of a mean of the residual on an element, over the reference of errors, in the error aimed at.
    pub(super) fn indicator_for_points(&self, element: usize, channel: usize, left: f64) -> f64 {
        let weight = self.element(element).area() * self.importance_of(element, channel);
        ratio(weight * left, self.refinement.served.reflected[channel])
    }

    /// How much less than elsewhere the neglected light of a receiver's links counts, where no point is near that gathers by
    /// them.
    pub(super) fn carefully(&self, receiver: usize, channel: usize) -> f64 {
        if !self.refinement.served.is_known() || self.refinement.served.beside || self.has_point(receiver) {
            return 1.0;
        }
        match self.refinement.served.mean[channel] {
            mean if mean > 0.0 => smallest(self.importance_of(receiver, channel) / mean, 1.0),
            _ => 1.0,
        }
    }

    fn has_point(&self, receiver: usize) -> bool {
        let element = self.element(receiver);
        let reach = 1e-6 * self.system.extent;
        self.refinement.served.points.iter().any(|[point, _]| {
            let point = self.placement.inward(*point);
            let height = element.polygon().normal().dot(point - element.centre());
            height.abs() <= reach && element.is_at(point, reach)
        })
    }

    /// Estimate of the mean error of gathers at the points served, over the mean of their reflected radiosity; `None` if the mean
    /// is served.
    pub(super) fn estimate_at_points(&self) -> Option<f64> {
        if !self.refinement.served.is_known() {
            return None;
        }
        let of_channel = |channel: usize| {
            let indicator_on = |&receiver: &usize| {
                let residual: f64 = self
                    .error_estimate
                    .residuals
                    .iter()
                    .map(|residuals| residuals[receiver][channel].mean_ledger().total())
                    .sum();
                self.indicator_for_points(receiver, channel, residual)
            };
            self.system.receivers.iter().map(indicator_on).sum::<f64>()
        };
        Some((0..self.channels().len()).map(of_channel).fold(0.0, largest))
    }
}
