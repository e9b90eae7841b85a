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
//! over its reflectance, and 1 and the projection of the irradiance where nothing is reflected. In a closed scene, for any number c,
//!
//! ```text
//! d = 1 + c - phi + G (rho phi - c)
//! ```
//!
//! so that d is 0 but for rounding where all reflectances are the same, whatever stands in the scene and however it is lit, and small where
//! they differ little. Else it is what the projection of `G rho phi` leaves out, cell by cell, and the unsolved rest. What something lies on
//! sees nothing, nor is it seen: there B is E, and of any phi that is sent from there nothing is found elsewhere.
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
use radgrad_scene::largest;
use rayon::prelude::*;

use super::left::fill;
use super::nodes::ROUNDED;
use super::{Ground, Proven, Rest, Solved, worth_cutting};
use crate::bound::ledger::Ledger;
use crate::field::Field;
use crate::field::gathering::irradiance;
use crate::links::link::Link;

/// Rounding of ranges of polynomials, over their sizes.
const ROUNDING: f64 = 1e-12;

/// What the importance leaves out on the receivers.
#[derive(Debug)]
pub(super) struct Swapped {
    /// The importance as it is sent, and evenly where something lies on the receiver.
    sent: Field,
    is_covered: Vec<bool>,
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

impl Swapped {
    /// Of an importance as it is sent, by sizes alone.
    pub(super) fn of(solved: &Solved<'_>, ground: &Ground, mut sent: Field) -> Self {
        let Solved { mesh, receivers, channels, .. } = *solved;
        let is_covered: Vec<bool> =
            receivers.iter().map(|&receiver| ground.closure.is_covered(&mesh.elements()[receiver])).collect();
        let covered: Vec<usize> = (0..receivers.len()).filter(|&place| is_covered[place]).collect();
        let seen: Vec<usize> = (0..receivers.len()).filter(|&place| !is_covered[place]).map(|place| receivers[place]).collect();
        let area = |&receiver: &usize| mesh.elements()[receiver].area();
        for channel in (0..channels).filter(|_| !covered.is_empty()) {
            let held = |receiver: &usize| area(receiver) * sent.of(*receiver, channel, mesh.basis(*receiver).len())[0];
            let mean = seen.iter().map(held).sum::<f64>() / seen.iter().map(area).sum::<f64>();
            for &receiver in covered.iter().map(|&place| &receivers[place]) {
                let mut change: Vec<f64> = sent.of(receiver, channel, mesh.basis(receiver).len()).iter().map(|c| -c).collect();
                change[0] += mean;
                sent.add(mesh, receiver, channel, &change);
            }
        }
        sent.pull(mesh);
        let new = Self { left: Vec::new(), is_covered, deepest: vec![0; receivers.len()], sent };
        let of = |(place, &receiver): (usize, &usize)| match () {
            () if new.is_covered[place] => vec![Rest::default(); channels],
            () if ground.closure.is_closed_from(&mesh.elements()[receiver]) && solved.far[receiver].is_empty() => {
                new.evenly(solved, ground, receiver)
            }
            () => new.through(solved, ground, receiver, 0),
        };
        Self { left: receivers.par_iter().enumerate().map(of).collect(), ..new }
    }

    /// Bounds on d by how even what is sent is, where form factors sum to 1.
    fn evenly(&self, solved: &Solved<'_>, ground: &Ground, receiver: usize) -> Vec<Rest> {
        let Solved { mesh, channels, .. } = *solved;
        let proof = ground.proof(solved.optics, channels, 0);
        let target = proof.target(receiver, &mesh.elements()[receiver]);
        let factor = |link: &Link| target.reach(&mesh.elements()[link.source]).factor;
        let seen: Vec<(usize, f64)> = solved.links[receiver].iter().map(|link| (link.source, factor(link))).collect();
        let of_channel = |channel: usize| {
            let mut phi = self.importance(solved, receiver, channel).0;
            let c = std::mem::take(&mut phi[0]) - 1.0;
            let beyond = |&(source, factor): &(usize, f64), sign: f64| {
                let basis = mesh.basis(source);
                let [low, high] = basis.range(self.sent.of(source, channel, basis.len()));
                let most = if sign > 0.0 { high - c } else { c - low };
                (factor, most + self.sent.left_out(source, channel))
            };
            let gathered = [1.0, -1.0].map(|sign| fill(seen.iter().map(|of| beyond(of, sign)).collect()));
            let most = mesh.basis(receiver).magnitude(&phi) + gathered.into_iter().fold(0.0, largest);
            let left = Ledger { discretisation: most * ROUNDED + ROUNDING * (1.0 + c.abs()), ..Ledger::default() };
            Rest { largest: left, mean: left, ..Rest::default() }
        };
        (0..channels).map(of_channel).collect()
    }

    /// The same by what the projection leaves out, cell by cell, and the unsolved rest.
    fn through(&self, solved: &Solved<'_>, ground: &Ground, receiver: usize, deepest: usize) -> Vec<Rest> {
        let left = solved.left_of_irradiance(ground, &self.sent, receiver, deepest).0;
        let with_rest = |(channel, left): (usize, Rest)| {
            let solver = self.importance(solved, receiver, channel).1;
            let rest = Ledger { solver, ..Ledger::default() };
            Rest { largest: left.largest + rest, mean: left.mean + rest, ..left }
        };
        left.into_iter().enumerate().map(with_rest).collect()
    }

    /// Cuts the receivers further that add most for the work that they are. Says whether there were any, and time.
    pub(super) fn cut_further(&mut self, solved: &Solved<'_>, ground: &Ground) -> bool {
        let mut places = vec![0; solved.mesh.elements().len()];
        solved.receivers.iter().enumerate().for_each(|(place, &receiver)| places[receiver] = place);
        let adds = |receiver: usize, channel: usize| {
            if self.is_covered[places[receiver]] {
                return 0.0;
            }
            self.left[places[receiver]][channel].mean.discretisation * brightness(solved, receiver, channel)
        };
        let next = worth_cutting(solved, ground, &self.deepest, adds);
        let of = |&place: &usize| {
            let through = || self.through(solved, ground, solved.receivers[place], self.deepest[place] + 1);
            (!solved.clock.is_over()).then(through)
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
            let face = mesh.elements()[receiver].face();
            let (emitted, given) = (solved.surfaces.emitted[face][channel], solved.given(face, channel));
            let held = solved.field.of(receiver, channel, basis.len());
            sums[1] += part * (held[0] + emitted - given);
            if self.is_covered[place] {
                sums[0] += part * emitted;
                continue;
            }
            sums[0] += part * self.importance(solved, receiver, channel).0[0] * emitted;
            let left = &self.left[place][channel];
            let [most, mean] = [left.largest.total(), left.mean.total()];
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

    /// The coefficients of phi on a receiver, and the most that the unsolved rest adds to d.
    fn importance(&self, solved: &Solved<'_>, receiver: usize, channel: usize) -> (Vec<f64>, f64) {
        let (mesh, rho) = (solved.mesh, solved.reflectance(receiver, channel));
        let (basis, links, far) = (mesh.basis(receiver), &solved.links[receiver], &solved.far[receiver]);
        let mut gathered = basis.project(&irradiance(mesh, &self.sent, links, far, channel, basis.nodes().len()));
        gathered[0] += 1.0;
        if rho == 0.0 {
            return (gathered, 0.0);
        }
        let phi: Vec<f64> = self.sent.of(receiver, channel, basis.len()).iter().map(|sent| sent / rho).collect();
        let rest: Vec<f64> = gathered.iter().zip(&phi).map(|(gathered, phi)| gathered - phi).collect();
        (phi, basis.magnitude(&rest))
    }
}

/// A bound on the mean over a receiver of the magnitude of the radiosity that was found.
fn brightness(solved: &Solved<'_>, receiver: usize, channel: usize) -> f64 {
    solved.found_at_most(receiver, channel) + solved.surfaces.emitted[solved.mesh.elements()[receiver].face()][channel]
}
