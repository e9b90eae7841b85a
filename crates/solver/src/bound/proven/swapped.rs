//! The bound on the error of the mean with light and importance swapped.
//!
//! | symbol | meaning |
//! |---|---|
//! | `phi` | any function on the faces; here about the importance, `1 + G rho phi` |
//! | `d` | `1 + G rho phi - phi` |
//! | `e` | the error `B - B_h`; `o_i` bounds its mean over receiver i |
//! | `d_i` | a bound on `|d|` on receiver i |
//! | `k` | any number |
//!
//! As G is the same both ways, `int phi E = int phi (B - rho G B) = int (phi - G rho phi) B`, so that
//!
//! ```text
//! int B = int phi E + int d B
//! ```
//!
//! What is emitted is given, and no residual of the light is in that. phi is a polynomial on each receiver: what it sends of the importance
//! over its reflectance, and 1 and the projection of the irradiance where nothing is reflected. So d is what the projection of that
//! irradiance leaves out, and the unsolved rest. In a closed scene a constant leaves nothing out: where all reflectances are the same d is 0
//! but for rounding, whatever stands in it and however it is lit; and where they differ little it is small.
//!
//! On receiver i `int |d| B` is at most the largest `|d|` times the integral of B, or the mean of `|d|` times the largest B. The integral is
//! that of `B_h` and of e: with `int e` over all area at most the bound b itself,
//!
//! ```text
//! sum d_i int_i e <= k b + sum |d_i - k| o_i,      b = (all else + sum |d_i - k| o_i)/(1 - k)      if k < 1
//! ```
//!
//! where `d_i` is 0 for receivers that count by the largest B. k is the median of the `d_i` by their `o_i`. For scenes without textures.

use radgrad_core::mutant;
use rayon::prelude::*;

use super::nodes::ROUNDED;
use super::{Ground, Proven, Rest, Solved, Way, worth_cutting};
use crate::bound::ledger::Ledger;
use crate::field::Field;
use crate::field::gathering::irradiance;

/// What the importance leaves out on the receivers.
#[derive(Debug)]
pub(super) struct Swapped<'a> {
    sent: &'a Field,
    /// For each receiver, in each channel.
    left: Vec<Vec<Rest>>,
    /// How often each is cut into cells; sizes alone count where this is 0.
    deepest: Vec<usize>,
}

/// What a receiver adds to the bound, with its part of all area.
#[derive(Debug, Clone, Copy, Default)]
struct Added {
    known: f64,
    /// The largest magnitude of d that the error of the light counts with, and that error's integral.
    most: f64,
    off: f64,
    /// What it would add if B were as it was found, and even.
    evenly: f64,
}

impl<'a> Swapped<'a> {
    /// Of an importance as it is sent, by sizes alone.
    pub(super) fn of(solved: &Solved<'_>, ground: &Ground, sent: &'a Field) -> Self {
        let of = |&receiver: &usize| solved.left_of_irradiance(ground, sent, receiver, Way::BySize).0;
        let left = solved.receivers.par_iter().map(of).collect();
        Self { sent, left, deepest: vec![0; solved.receivers.len()] }
    }

    /// Cuts the receivers further that add most for the work that they are. Says whether there were any, and time.
    pub(super) fn cut_further(&mut self, solved: &Solved<'_>, ground: &Ground) -> bool {
        let mut places = vec![0; solved.mesh.elements().len()];
        solved.receivers.iter().enumerate().for_each(|(place, &receiver)| places[receiver] = place);
        let adds = |receiver: usize, channel: usize| {
            self.left[places[receiver]][channel].mean.discretisation * brightness(solved, receiver, channel)
        };
        let next = worth_cutting(solved, ground, &self.deepest, adds);
        let of = |&place: &usize| {
            let way = Way::Through { deepest: self.deepest[place] + 1 };
            let (sent, receiver) = (self.sent, solved.receivers[place]);
            (!solved.clock.is_over()).then(|| solved.left_of_irradiance(ground, sent, receiver, way).0)
        };
        let found: Option<Vec<Vec<Rest>>> = next.par_iter().map(of).collect();
        let Some(found) = found.filter(|found| !found.is_empty()) else { return false };
        for (place, found) in next.into_iter().zip(found) {
            self.deepest[place] += 1;
            self.left[place].iter_mut().zip(found).for_each(|(known, found)| *known = known.lesser(found));
        }
        true
    }

    /// For each channel the bound on the error of the mean, and what it would be if B were even on each receiver.
    pub(super) fn mean(&self, solved: &Solved<'_>, proven: &Proven) -> Vec<(Ledger, f64)> {
        (0..solved.channels).map(|channel| self.mean_in(solved, proven, channel)).collect()
    }

    fn mean_in(&self, solved: &Solved<'_>, proven: &Proven, channel: usize) -> (Ledger, f64) {
        let Solved { mesh, receivers, .. } = *solved;
        let area: f64 = receivers.iter().map(|&receiver| mesh.elements()[receiver].area()).sum();
        let (mut sums, mut all) = ([0.0; 2], Vec::with_capacity(receivers.len()));
        for (place, &receiver) in receivers.iter().enumerate() {
            let (part, basis) = (mesh.elements()[receiver].area() / area, mesh.basis(receiver));
            let (importance, unsolved) = self.importance(solved, receiver, channel);
            let face = mesh.elements()[receiver].face();
            let (emitted, given) = (solved.surfaces.emitted[face][channel], solved.given(face, channel));
            let held = solved.field.of(receiver, channel, basis.len());
            sums[0] += part * importance * emitted;
            sums[1] += part * (held[0] + emitted - given);
            let left = &self.left[place][channel];
            let [most, mean] = [&left.largest, &left.mean].map(|left| left.total() + unsolved);
            let lamp = emitted - given;
            let [most_off, off] = proven.most_off[receiver][channel];
            let found = brightness(solved, receiver, channel);
            let brightest = basis.magnitude(held) + most_off + lamp;
            let added = Added { known: part * most * found, most, off: part * off, evenly: part * mean * found };
            let by_mean = part * mean * brightest;
            all.push(if by_mean < added.known + most * added.off { Added { known: by_mean, most: 0.0, ..added } } else { added });
        }
        let known = (sums[0] - sums[1]).abs() + (ROUNDED - 1.0) * (sums[0].abs() + sums[1].abs());
        let sum: f64 = all.iter().map(|of| of.known).sum();
        let evenly = known + all.iter().map(|of| of.evenly).sum::<f64>();
        let half = 0.5 * all.iter().map(|of| of.off).sum::<f64>();
        all.sort_by(|a, b| a.most.total_cmp(&b.most));
        let mut below = 0.0;
        let median = all.iter().find(|of| {
            below += of.off;
            below >= half
        });
        let k = median.map_or(0.0, |of| of.most);
        let spread: f64 = all.iter().map(|of| (of.most - k).abs() * of.off).sum();
        let total = if k < 1.0 { (known + sum + spread) / (1.0 - k) * ROUNDED } else { f64::INFINITY };
        let bound = mutant!("solver.swapped", self.ledger(channel, known, total), |bound| bound * 0.1);
        (bound, evenly)
    }

    /// A bound by its sources: what `B_h` is found to be off by, and what the importance leaves out.
    fn ledger(&self, channel: usize, found: f64, total: f64) -> Ledger {
        let parts = self.left.iter().map(|left| left[channel].mean).sum::<Ledger>();
        if !total.is_finite() {
            return Ledger::unknown();
        }
        if parts.total() == 0.0 {
            return Ledger { discretisation: total, ..Ledger::default() };
        }
        parts * ((total - found) / parts.total()) + Ledger { discretisation: found, ..Ledger::default() }
    }

    /// The mean of phi over a receiver, and the most that the unsolved rest adds to d.
    fn importance(&self, solved: &Solved<'_>, receiver: usize, channel: usize) -> (f64, f64) {
        let (mesh, rho) = (solved.mesh, solved.reflectance(receiver, channel));
        let (basis, links, far) = (mesh.basis(receiver), &solved.links[receiver], &solved.far[receiver]);
        let mut gathered = basis.project(&irradiance(mesh, self.sent, links, far, channel, basis.nodes().len()));
        gathered[0] += 1.0;
        if rho == 0.0 {
            return (gathered[0], 0.0);
        }
        let sent = self.sent.of(receiver, channel, basis.len());
        let rest: Vec<f64> = gathered.iter().zip(sent).map(|(gathered, sent)| gathered - sent / rho).collect();
        (sent[0] / rho, basis.magnitude(&rest))
    }
}

/// A bound on the mean over a receiver of the magnitude of the radiosity that was found.
fn brightness(solved: &Solved<'_>, receiver: usize, channel: usize) -> f64 {
    solved.found_at_most(receiver, channel) + solved.surfaces.emitted[solved.mesh.elements()[receiver].face()][channel]
}
