//! Which elements a round divides: those that together make up a given part of the residual (W. Dörfler 1996).

use crate::error::Error;
use crate::gathering::ratio;
use crate::solve::options::{Marking, Options};
use crate::solve::samples::Samples;
use crate::solve::solution::{Solution, for_each};
use radgrad_scene::{largest, smallest};

/// The part of the estimate whose receivers are divided in a round.
const BULK: f64 = 0.7;

/// The same part where elements are divided by samples and gradients: less, since there the number of elements counts, not of
/// rounds.
const OFF_BULK: f64 = 0.4;

/// Part of their share that elements are expected to keep when they are divided.
const LEFT_BY_CHILDREN: f64 = 0.3;

/// Part of the error asked for at which the last round aims.
const AIMED_BELOW: f64 = 0.95;

/// The part of the least that is divided from which on reflected light by itself asks for finer gathers: these cost time, but no
/// elements where direct light has divided already.
const REFLECTED_PART: f64 = 0.005;

impl Solution {
    /// Divides the elements with the largest error.
    pub(super) fn divide(&mut self, options: &Options) -> Result<(), Error> {
        let (elements, receivers) = match options.marking {
            Marking::Residual => (Vec::new(), bulk(self.indicators(), self.part(options))),
            Marking::Gradient | Marking::Shadows => self.largest_errors()?,
        };
        for &element in elements.iter().chain(&receivers) {
            self.system.mesh.divide(element)?;
        }
        let mut goes = vec![false; self.system.mesh.elements().len()];
        receivers.iter().for_each(|&receiver| goes[receiver] = true);
        self.system.receivers.retain(|&receiver| !goes[receiver]);
        let mesh = &self.system.mesh;
        let children = receivers.iter().filter_map(|&receiver| mesh.elements()[receiver].children());
        self.system.receivers.extend(children.flat_map(|first| first..first + 4));
        self.system.receivers.sort_unstable();
        Ok(())
    }

    /// The part of the estimate whose receivers have to be divided so that it comes to a little below the one asked for.
    fn part(&self, options: &Options) -> f64 {
        part_to_divide(options.error / self.progress.estimate)
    }

    /// The refinement indicator of each receiver: its part of the estimated mean magnitude.
    fn indicators(&self) -> Vec<(f64, usize)> {
        let reference = self.reference();
        let indicator = |receiver: usize, channel: usize| {
            let residual = self.reducible(receiver, &self.error_estimate.residuals[1][receiver][channel]);
            if self.refinement.served.is_known() {
                return self.indicator_for_points(receiver, channel, residual);
            }
            ratio(self.error_estimate.indicator(&self.system.mesh, receiver, channel, residual), reference[channel])
        };
        let worst = |receiver: usize| (0..self.channels().len()).map(|channel| indicator(receiver, channel)).fold(0.0, largest);
        self.system.receivers.iter().map(|&receiver| (worst(receiver), receiver)).collect()
    }

    /// Leaves, and receivers above them, that are off most by samples and gradients; and the receivers among these that gather
    /// more finely from now on: those where reflected light by itself is no small part of the error.
    fn largest_errors(&mut self) -> Result<(Vec<usize>, Vec<usize>), Error> {
        self.judge()?;
        let elements = self.system.mesh.elements();
        let weighted_residual =
            |element: usize, light: &Samples| elements[element].area() * self.mean_square_residual(element, light);
        let receives = self.system.receives();
        let lights = |element: usize| {
            let [direct, reflected] = &self.refinement.judged[element];
            let direct = direct.as_ref().filter(|_| elements[element].is_leaf());
            (direct, reflected.as_ref().filter(|_| receives[element]))
        };
        let of_element = |element: usize| match lights(element) {
            (Some(direct), Some(reflected)) => Some((weighted_residual(element, &direct.with(reflected)), element)),
            (Some(light), None) | (None, Some(light)) => Some((weighted_residual(element, light), element)),
            (None, None) => None,
        };
        let marked: Vec<(f64, usize)> = (0..elements.len()).filter_map(of_element).collect();
        let chosen = bulk(marked, OFF_BULK);
        let whole = |&element: &usize| of_element(element).map_or(f64::INFINITY, |(weighted_residual, _)| weighted_residual);
        let least = chosen.iter().map(whole).fold(f64::INFINITY, smallest);
        let finer =
            |&element: &usize| lights(element).1.is_some_and(|light| weighted_residual(element, light) >= REFLECTED_PART * least);
        let receivers = chosen.iter().copied().filter(finer).collect();
        Ok((chosen, receivers))
    }

    /// Samples the light on leaves and receivers that were not before.
    fn judge(&mut self) -> Result<(), Error> {
        self.refinement.judged.resize(self.system.mesh.elements().len(), [None, None]);
        let leaves = self
            .system
            .mesh
            .leaves()
            .filter(|&leaf| self.refinement.judged[leaf][0].is_none() && !self.radiosity.direct.is_empty());
        let leaves: Vec<usize> = leaves.collect();
        let receivers = self.system.receivers.iter().copied().filter(|&receiver| self.refinement.judged[receiver][1].is_none());
        let receivers: Vec<usize> = receivers.collect();
        let direct = for_each(&leaves, |leaf| self.direct_on(leaf))?;
        let reflected = for_each(&receivers, |receiver| self.reflected_on(receiver))?;
        leaves.into_iter().zip(direct).for_each(|(leaf, light)| self.refinement.judged[leaf][0] = Some(light));
        receivers.into_iter().zip(reflected).for_each(|(receiver, light)| self.refinement.judged[receiver][1] = Some(light));
        Ok(())
    }

    /// The elements above those that gather, in the order in which they were divided, numbered as they are in a mesh that was
    /// divided so and not for direct light.
    #[must_use]
    pub fn divisions(&self) -> Vec<usize> {
        let mut numbers = vec![None; self.system.mesh.elements().len()];
        let undivided = self.system.mesh.undivided();
        numbers[..undivided].iter_mut().enumerate().for_each(|(index, number)| *number = Some(index));
        let mut count = undivided;
        let mut divisions = Vec::new();
        for divided in self.system.mesh.divisions() {
            let (Some(number), true) = (numbers[divided], !self.gathers(divided)) else { continue };
            divisions.push(number);
            for child in self.element(divided).children().into_iter().flat_map(|first| first..first + 4) {
                numbers[child] = Some(count);
                count += 1;
            }
        }
        divisions
    }
}

/// The part of a sum over elements that has to be that of divided ones, so that it comes to a little less than this part of it.
pub(super) fn part_to_divide(left: f64) -> f64 {
    ((1.0 - AIMED_BELOW * left) / (1.0 - LEFT_BY_CHILDREN)).clamp(0.0, BULK)
}

/// The elements with the largest parts that together make up this part of the whole.
pub(super) fn bulk<T: Ord>(mut marked: Vec<(f64, T)>, part: f64) -> Vec<T> {
    marked.sort_by(|a, b| b.0.total_cmp(&a.0).then_with(|| a.1.cmp(&b.1)));
    let total: f64 = marked.iter().map(|m| m.0).sum();
    let mut taken = 0.0;
    let takes = |(share, _): &(f64, T)| {
        let goes_on = taken < part * total;
        taken += share;
        goes_on
    };
    marked.into_iter().take_while(takes).map(|m| m.1).collect()
}
