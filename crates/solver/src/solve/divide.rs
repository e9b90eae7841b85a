//! Which elements a round divides: those that together make up a given part of what is left out (W. Dörfler 1996).

use super::{Solution, ratio};
use crate::Error;
use crate::link::for_each;
use crate::marking::{self, Marking};
use crate::solve::Options;

/// The part of the bound whose receivers are divided in a round.
const BULK: f64 = 0.6;

impl Solution {
    /// Divides the receivers that leave out most.
    pub(super) fn divide(&mut self, options: &Options) -> Result<(), Error> {
        let indicator = |receiver: usize| {
            let worst = |of: &dyn Fn(usize) -> f64| {
                (0..self.channels.len()).map(|channel| ratio(of(channel), self.mean[channel])).fold(0.0, f64::max)
            };
            let counts = |channel: usize| self.counts(receiver, &self.bounds.residuals[1][receiver][channel]);
            let off = match options.marking {
                Marking::Residual => worst(&|channel| self.bounds.share(&self.mesh, receiver, channel, counts(channel))),
                Marking::Gradient => {
                    let residual = worst(&counts);
                    let off = residual + marking::BESIDE_RESIDUAL * self.off_by_gradient(receiver)?;
                    self.mesh.elements()[receiver].area() * off
                }
            };
            Ok((off, receiver))
        };
        let marked = for_each(&self.receivers, indicator)?;
        let divided = if options.uniform { self.receivers.clone() } else { bulk(marked) };
        for &receiver in &divided {
            self.mesh.divide(receiver)?;
        }
        let mut goes = vec![false; self.mesh.elements().len()];
        divided.iter().for_each(|&receiver| goes[receiver] = true);
        self.receivers.retain(|&receiver| !goes[receiver]);
        let children = divided.iter().filter_map(|&receiver| self.mesh.elements()[receiver].children());
        self.receivers.extend(children.flat_map(|first| first..first + 4));
        self.receivers.sort_unstable();
        Ok(())
    }

    /// The elements above those that gather, in the order in which they were divided, numbered as they are in a mesh that was
    /// divided so and not for direct light.
    #[must_use]
    pub fn divisions(&self) -> Vec<usize> {
        let mut numbers = vec![None; self.mesh.elements().len()];
        let undivided = self.mesh.undivided();
        numbers[..undivided].iter_mut().enumerate().for_each(|(index, number)| *number = Some(index));
        let mut count = undivided;
        let mut divisions = Vec::new();
        for divided in self.mesh.divisions() {
            let (Some(number), true) = (numbers[divided], self.links[divided].is_empty()) else { continue };
            divisions.push(number);
            for child in self.mesh.elements()[divided].children().into_iter().flat_map(|first| first..first + 4) {
                numbers[child] = Some(count);
                count += 1;
            }
        }
        divisions
    }
}

/// The elements with the largest parts that together make up the bulk of the whole.
pub(super) fn bulk(mut marked: Vec<(f64, usize)>) -> Vec<usize> {
    marked.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
    let all: f64 = marked.iter().map(|m| m.0).sum();
    let mut taken = 0.0;
    let takes = |&(share, _): &(f64, usize)| {
        let goes_on = taken < BULK * all;
        taken += share;
        goes_on
    };
    marked.into_iter().take_while(takes).map(|m| m.1).collect()
}
