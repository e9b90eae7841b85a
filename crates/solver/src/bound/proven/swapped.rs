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
//! sees nothing, nor is it seen: there B is E, and of any phi that is sent from there nothing is found elsewhere. On a receiver with such a
//! part phi is a number, and d counts on the rest of it.
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
use radgrad_scene::{largest, smallest as least};
use rayon::prelude::*;

use super::closed::SAME;
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
    /// The importance as it is sent, and evenly where something lies on a part of the receiver.
    sent: Field,
    /// For each receiver, the part of its area that something lies on.
    covered: Vec<f64>,
    /// phi on these receivers, in each channel; on all receivers where an even importance leaves less out.
    even: Vec<f64>,
    /// For each receiver, in each channel, bounds on d.
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
    /// What the receiver would add if B were even on it, and as bright as was found.
    evenly: f64,
}

impl Swapped {
    /// Of an importance as it is sent, or in channels in which that leaves less out of one that is even, as if all reflectances were the same.
    pub(super) fn of(solved: &Solved<'_>, ground: &Ground, sent: Field) -> Self {
        let Solved { mesh, receivers, channels, .. } = *solved;
        let covered: Vec<f64> = receivers.iter().map(|&receiver| ground.closure.covered(&mesh.elements()[receiver])).collect();
        // Means over the receivers that nothing lies on.
        let mean = |of: &dyn Fn(usize) -> f64| {
            let free = receivers.iter().zip(&covered).filter(|(_, covered)| **covered == 0.0).map(|(&receiver, _)| receiver);
            let sums = free.map(|receiver| (mesh.elements()[receiver].area(), of(receiver)));
            let [area, sum] = sums.fold([0.0; 2], |[all, sum], (area, of)| [all + area, sum + area * of]);
            if area > 0.0 { sum / area } else { 0.0 }
        };
        let in_channel = |channel: usize| {
            let rho = mean(&|receiver| solved.reflectance(receiver, channel));
            let sent = mean(&|receiver| sent.of(receiver, channel, mesh.basis(receiver).len())[0]);
            let found = if rho > 0.0 { sent / rho } else { 1.0 };
            [found, if rho < 1.0 { 1.0 / (1.0 - rho) } else { found }]
        };
        let numbers: Vec<[f64; 2]> = (0..channels).map(in_channel).collect();
        let [found, even] = [0, 1].map(|way| numbers.iter().map(|of| of[way]).collect::<Vec<f64>>());
        let mut found = Self::with(solved, ground, sent.clone(), (covered.clone(), found), |covered| covered > 0.0);
        let even = Self::with(solved, ground, sent, (covered, even), |_| true);
        let is_less = |&channel: &usize| even.size(solved, channel) < found.size(solved, channel);
        let less: Vec<usize> = (0..channels).filter(is_less).collect();
        for channel in less {
            found.even[channel] = even.even[channel];
            for (place, &receiver) in receivers.iter().enumerate() {
                found.left[place][channel] = even.left[place][channel].clone();
                found.send(solved, receiver, channel);
            }
        }
        found.sent.pull(mesh);
        found
    }

    /// With numbers for phi in each channel, on receivers of which such a part is covered.
    fn with(
        solved: &Solved<'_>,
        ground: &Ground,
        sent: Field,
        (covered, even): (Vec<f64>, Vec<f64>),
        is_even: impl Fn(f64) -> bool,
    ) -> Self {
        let Solved { mesh, receivers, channels, .. } = *solved;
        let mut new = Self { left: Vec::new(), covered, even, deepest: vec![0; receivers.len()], sent };
        let places: Vec<usize> = (0..receivers.len()).filter(|&place| is_even(new.covered[place])).collect();
        for place in places {
            (0..channels).for_each(|channel| new.send(solved, receivers[place], channel));
        }
        new.sent.pull(mesh);
        let of = |(place, &receiver): (usize, &usize)| {
            if solved.far[receiver].is_empty() {
                new.evenly(solved, ground, place)
            } else {
                new.through(solved, ground, place, 0)
            }
        };
        Self { left: receivers.par_iter().enumerate().map(of).collect(), ..new }
    }

    /// Makes phi a number on a receiver.
    fn send(&mut self, solved: &Solved<'_>, receiver: usize, channel: usize) {
        let len = solved.mesh.basis(receiver).len();
        let mut change: Vec<f64> = self.sent.of(receiver, channel, len).iter().map(|c| -c).collect();
        change[0] += solved.reflectance(receiver, channel) * self.even[channel];
        self.sent.add(solved.mesh, receiver, channel, &change);
    }

    /// How much d is, with the light that was found.
    fn size(&self, solved: &Solved<'_>, channel: usize) -> f64 {
        let of = |(left, &receiver): (&Vec<Rest>, &usize)| {
            solved.mesh.elements()[receiver].area() * left[channel].largest.total() * brightness(solved, receiver, channel)
        };
        self.left.iter().zip(solved.receivers).map(of).sum()
    }

    /// Bounds on d where form factors sum to 1: `rho phi` is nearly a number everywhere if reflectances are nearly the same.
    fn evenly(&self, solved: &Solved<'_>, ground: &Ground, place: usize) -> Vec<Rest> {
        let Solved { mesh, channels, receivers, .. } = *solved;
        let receiver = receivers[place];
        let proof = ground.proof(solved.optics, channels, 0);
        let target = proof.target(receiver, &mesh.elements()[receiver]);
        let factor = |link: &Link| target.reach(&mesh.elements()[link.source]).factor;
        let seen: Vec<(usize, f64)> = solved.links[receiver].iter().map(|link| (link.source, factor(link))).collect();
        // Where nothing lies on a node it sees something in every direction: else a gap was missed, and nothing is known.
        let sums_to_less =
            |node: usize| solved.links[receiver].iter().map(|link| link.rows[node].factor()).sum::<f64>() < 1.0 - SAME;
        let is_open = self.covered[place] == 0.0 && (0..mesh.basis(receiver).nodes().len()).any(sums_to_less);
        let of_channel = |channel: usize| {
            let mut phi = self.phi(solved, place, channel);
            let c = std::mem::take(&mut phi[0]) - 1.0;
            let beyond = |&(source, factor): &(usize, f64), sign: f64| {
                let basis = mesh.basis(source);
                let [low, high] = basis.range(self.sent.of(source, channel, basis.len()));
                let most = if sign > 0.0 { high - c } else { c - low };
                (factor, most + self.sent.left_out(source, channel))
            };
            let gathered = [1.0, -1.0].map(|sign| fill(seen.iter().map(|of| beyond(of, sign)).collect()));
            let most = mesh.basis(receiver).magnitude(&phi) + gathered.into_iter().fold(0.0, largest);
            let most = if is_open { f64::INFINITY } else { most * ROUNDED + ROUNDING * (1.0 + c.abs()) };
            let left = Ledger { discretisation: most, ..Ledger::default() };
            Rest { largest: left, mean: left, ..Rest::default() }
        };
        (0..channels).map(of_channel).collect()
    }

    /// The same by what the projection leaves out, cell by cell, and the unsolved rest.
    fn through(&self, solved: &Solved<'_>, ground: &Ground, place: usize, deepest: usize) -> Vec<Rest> {
        let left = solved.left_of_irradiance(ground, &self.sent, solved.receivers[place], deepest).0;
        let with_rest = |(channel, left): (usize, Rest)| {
            let rest = Ledger { solver: self.unsolved(solved, place, channel), ..Ledger::default() };
            Rest { largest: left.largest + rest, mean: left.mean + rest, ..left }
        };
        left.into_iter().enumerate().map(with_rest).collect()
    }

    /// Cuts the receivers further that add most for the work that they are. Says whether there were any, and time.
    pub(super) fn cut_further(&mut self, solved: &Solved<'_>, ground: &Ground) -> bool {
        let mut places = vec![0; solved.mesh.elements().len()];
        solved.receivers.iter().enumerate().for_each(|(place, &receiver)| places[receiver] = place);
        let adds = |receiver: usize, channel: usize| {
            if self.covered[places[receiver]] > 0.0 {
                return 0.0;
            }
            self.left[places[receiver]][channel].mean.discretisation * brightness(solved, receiver, channel)
        };
        let next = worth_cutting(solved, ground, &self.deepest, adds);
        let of = |&place: &usize| {
            let through = || self.through(solved, ground, place, self.deepest[place] + 1);
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

    /// For each channel the bound on the error of the mean, and a figure for how small smaller cells may make it: B is taken to be even on each
    /// receiver.
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
            let covered = least(self.covered[place], 1.0);
            sums[0] += part * (covered + (1.0 - covered) * self.phi(solved, place, channel)[0]) * emitted;
            if covered > 1.0 - SAME {
                continue;
            }
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

    /// The coefficients of phi on a receiver.
    fn phi(&self, solved: &Solved<'_>, place: usize, channel: usize) -> Vec<f64> {
        let (receiver, len) = (solved.receivers[place], solved.mesh.basis(solved.receivers[place]).len());
        let rho = solved.reflectance(receiver, channel);
        if self.covered[place] > 0.0 {
            let mut even = vec![0.0; len];
            even[0] = self.even[channel];
            even
        } else if rho > 0.0 {
            self.sent.of(receiver, channel, len).iter().map(|sent| sent / rho).collect()
        } else {
            self.gathered(solved, receiver, channel)
        }
    }

    /// 1 and the projection of what a receiver gathers of the importance.
    fn gathered(&self, solved: &Solved<'_>, receiver: usize, channel: usize) -> Vec<f64> {
        let (mesh, basis) = (solved.mesh, solved.mesh.basis(receiver));
        let (links, far) = (&solved.links[receiver], &solved.far[receiver]);
        let mut gathered = basis.project(&irradiance(mesh, &self.sent, links, far, channel, basis.nodes().len()));
        gathered[0] += 1.0;
        gathered
    }

    /// The most that the unsolved rest adds to d on a receiver.
    fn unsolved(&self, solved: &Solved<'_>, place: usize, channel: usize) -> f64 {
        let (receiver, phi) = (solved.receivers[place], self.phi(solved, place, channel));
        let rest: Vec<f64> = self.gathered(solved, receiver, channel).iter().zip(&phi).map(|(all, phi)| all - phi).collect();
        solved.mesh.basis(receiver).magnitude(&rest)
    }
}

/// The importance on a receiver: the coefficients of phi, and a bound on `|d|`.
#[derive(Debug)]
pub(super) struct Found {
    pub(super) phi: Vec<f64>,
    pub(super) left: f64,
}

/// For each receiver, in each channel, the importance as it is sent, where nothing lies on anything.
pub(super) fn importance(solved: &Solved<'_>, ground: &Ground, sent: &Field, deepest: usize) -> Vec<Vec<Found>> {
    let (count, channels) = (solved.receivers.len(), solved.channels);
    let (covered, even) = (vec![0.0; count], vec![1.0; channels]);
    let importance = Swapped { sent: sent.clone(), covered, even, left: Vec::new(), deepest: Vec::new() };
    let of = |place: usize| -> Vec<Found> {
        let left = importance.through(solved, ground, place, deepest).into_iter().enumerate();
        left.map(|(channel, left)| Found { phi: importance.phi(solved, place, channel), left: left.largest.total() }).collect()
    };
    (0..count).into_par_iter().map(of).collect()
}

/// A bound on the mean over a receiver of the magnitude of the radiosity that was found.
fn brightness(solved: &Solved<'_>, receiver: usize, channel: usize) -> f64 {
    solved.found_at_most(receiver, channel) + solved.surfaces.emitted[solved.mesh.elements()[receiver].face()][channel]
}
