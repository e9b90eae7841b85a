//! The mean of the error over all area.
//!
//! `mean |e| <= mean(z |r|)` with the importance z: no bound on the kernel enters, light spreads and is lost as it is. But r has
//! signs, which `G r` loses by: `mean |e| <= mean(b |G r|)` with `b = rho (1 + z)`. The gather of receiver i from r on j counts
//! in either way, for each pair in the one that is less:
//!
//! ```text
//! mean |e| <= sum_i mean_i(b) max_i |sum of G_ij r_j over the j of S_i|        the part that cancels: residual, Taylor's polynomials
//!           + sum_j mean_j |r| max_j (sum of G_ji b over the i without j in S_i)   the part that does not: z from such i
//! ```
//!
//! each mean over the receiver, with its part of all area. Both know i and j by links, whose sources may be above receivers. `S_i`
//! is a set of sources that i sees. On j a source is left out of the second sum if all receivers below it have j, or an element
//! above j, in their sets; so if any has not, some pairs count twice. Largest values are those at the nodes.
//!
//! Light through clusters is in no set. So all of it counts in the importance that is left for the second sum, and a receiver
//! with clusters has nothing in its set that it does not link to: where a link from j leads to it, it counts.
//!
//! Neglected links, rounding and the unsolved rest of the linear system have no known sign, and go with z.
//!
//! # Textures
//! The detail t of textures stays as elements become smaller, but `G t` does not ([`crate::estimate::residual`]); so it counts in the
//! first sum from all sources, clusters with its magnitude, and in the second nowhere.

use radgrad_scene::largest as larger;
use rayon::prelude::*;

use crate::estimate::importance::Importance;
use crate::estimate::ledger::Ledger;
use crate::estimate::residual::{Found, Residual, Residuals};
use crate::estimate::visible_sources::VisibleSources;
use crate::mesh::glow::Pair;
use crate::mesh::texture::Pattern;
use crate::system::System;

/// Receivers below a source beyond which it is not asked whether all of them have a receiver in their sets.
const MOST_BELOW: usize = 64;

/// For each channel the estimate and the parts that the sources of error have in it, and for each element that receives the
/// weight of its residual.
#[derive(Debug)]
pub(super) struct Mean {
    pub(super) mean: Vec<Ledger>,
    pub(super) shares: Vec<Ledger>,
    pub(super) weights: Vec<Vec<f64>>,
}

/// The gather by a receiver of oscillating residuals.
#[derive(Debug)]
struct Gathers {
    /// Whether each source that is seen is in the receiver's set.
    chosen: Vec<bool>,
    /// The same by the elements, sorted.
    sources: Vec<(usize, bool)>,
    /// Whether it may see others through clusters.
    has_far: bool,
    /// For each channel, the most that a node gathers from the sources of the set, and of the detail of textures.
    most: Vec<f64>,
    /// For each source and channel, the mean over nodes.
    parts: Vec<f64>,
}

pub(super) fn estimate(system: &System, residuals: &[Residuals; 2], seen: &[VisibleSources], importance: &Importance) -> Mean {
    let System { mesh, surfaces, receivers, .. } = system;
    let channels = system.channels.len();
    let area: f64 = receivers.iter().map(|&receiver| mesh.elements()[receiver].area()).sum();
    let whole = |index: usize| -> Vec<f64> {
        (0..channels).map(|channel| importance.largest_on(index, channel, &seen[index], |_| true)).collect()
    };
    let whole: Vec<Vec<f64>> = (0..receivers.len()).into_par_iter().map(whole).collect();
    let details = system.pairs(|element, channel| {
        let sum = |of: fn(&Residual) -> f64| residuals.iter().map(|all| of(&all[element][channel])).sum();
        (sum(Residual::largest_detail), sum(Residual::mean_detail))
    });
    let of_receiver = |(index, &receiver): (usize, &usize)| system.gathers(receiver, residuals, &details, &seen[index]);
    let gathers: Vec<Gathers> = receivers.par_iter().enumerate().map(of_receiver).collect();
    let mut places = vec![usize::MAX; mesh.elements().len()];
    receivers.iter().enumerate().for_each(|(index, &receiver)| places[receiver] = index);
    // The importance of a receiver that is not in the sets of others.
    let remainder = |index: usize| -> Vec<f64> {
        let above: Vec<usize> = mesh.above(receivers[index]).collect();
        let counts = |source: usize| {
            let mut remaining = MOST_BELOW;
            !system.all_below(&places, source, &mut remaining, &|other| gathers[other].have(&above))
        };
        let counts: Vec<bool> = seen[index].sources.iter().map(|&source| counts(source)).collect();
        (0..channels).map(|channel| importance.largest_on(index, channel, &seen[index], |place| counts[place])).collect()
    };
    let remainder: Vec<Vec<f64>> = (0..receivers.len()).into_par_iter().map(remainder).collect();

    let mut mean = Mean { mean: Vec::new(), shares: Vec::new(), weights: vec![Vec::new(); mesh.elements().len()] };
    for channel in 0..channels {
        let (mut plain, mut signed, mut detail, mut at_point) = (Ledger::default(), Ledger::default(), 0.0, Ledger::default());
        // The gather by others of a source's residual, over its mean and its area.
        let mut credit = vec![0.0; mesh.elements().len()];
        let of_element = |element: usize| residuals.iter().map(|of| of[element][channel].mean_ledger()).sum::<Ledger>();
        for (index, &receiver) in receivers.iter().enumerate() {
            let element = &mesh.elements()[receiver];
            let part = element.area() / area;
            let (z, left) = (whole[index][channel], of_element(receiver));
            plain += left * (z * part);
            let rho = system.reflectance(receiver, channel);
            let sends = surfaces.pattern(receiver, channel).map_or(rho, Pattern::mean_reflectance) * (1.0 + z);
            let [cancels, details] = [0, 1].map(|kind| part * sends * gathers[index].most[2 * channel + kind]);
            detail += details;
            let oscillates = left.discretisation * remainder[index][channel] * part + cancels;
            signed += Ledger { discretisation: oscillates, ..left * (z * part) };
            gathers[index].credit(&seen[index].sources, (channel, channels), sends * element.area(), &mut credit);
            // An evaluation at a point has an error of its own.
            for residuals in residuals {
                let largest = residuals[receiver][channel].largest;
                at_point += Ledger { discretisation: 0.0, solver: 0.0, ..largest } * part;
            }
        }
        let cancels = signed.total() < plain.total();
        let sent = if cancels { signed } else { plain } + Ledger { discretisation: detail, ..Ledger::default() };
        for (element, credit) in credit.iter_mut().enumerate().filter(|(_, credit)| **credit > 0.0) {
            let size = mesh.elements()[element].area() * of_element(element).discretisation;
            *credit = if size > 0.0 { *credit / size } else { 0.0 };
        }
        for (index, &receiver) in receivers.iter().enumerate() {
            let signed = remainder[index][channel] + mesh.above(receiver).map(|element| credit[element]).sum::<f64>();
            mean.weights[receiver].push(if cancels { signed } else { whole[index][channel] });
        }
        mean.shares.push(if sent.total() > 0.0 { sent * (1.0 / sent.total()) } else { sent });
        mean.mean.push(sent + at_point);
    }
    mean
}

impl Gathers {
    /// Whether one of these elements, a receiver and those above it, is in the set, or surely nothing of them is seen.
    fn have(&self, above: &[usize]) -> bool {
        let place = above.iter().find_map(|&element| self.sources.binary_search_by_key(&element, |source| source.0).ok());
        place.map_or(!self.has_far, |place| self.sources[place].1)
    }

    /// Adds each source's gather by the receiver, weighted by the receiver's importance.
    fn credit(&self, sources: &[usize], (channel, channels): (usize, usize), sends: f64, credit: &mut [f64]) {
        for (place, &source) in sources.iter().enumerate().filter(|(place, _)| self.chosen[*place]) {
            credit[source] += sends * self.parts[place * channels + channel];
        }
    }
}

impl System {
    /// Whether all receivers below an element, of not more than are left, pass.
    fn all_below(&self, places: &[usize], element: usize, left: &mut usize, pass: &impl Fn(usize) -> bool) -> bool {
        if let Some(&place) = places.get(element).filter(|&&place| place != usize::MAX) {
            if *left == 0 {
                return false;
            }
            *left -= 1;
            return pass(place);
        }
        let Some(first) = self.mesh.elements()[element].children() else { return false };
        (first..first + 4).all(|child| self.all_below(places, child, left, pass))
    }

    /// The gather by a receiver of the residual where it cancels, and the sources from which it is less so.
    fn gathers(
        &self,
        receiver: usize,
        [direct, reflected]: &[Residuals; 2],
        details: &[Vec<Pair>],
        seen: &VisibleSources,
    ) -> Gathers {
        let (mesh, channels, nodes) = (&self.mesh, self.channels.len(), seen.nodes);
        let count = seen.sources.len();
        let mut signed = vec![0.0; count * channels * nodes];
        let mut detail = vec![0.0; channels * nodes];
        let mut add = |place: usize, source: usize, node: usize, found: &Found, of: &Residuals| {
            let degree = mesh.basis(source).degree();
            for (channel, residual) in of[source].iter().enumerate() {
                signed[(place * channels + channel) * nodes + node] += residual.gathered_beside_detail(degree, found);
                detail[channel * nodes + node] += residual.gathered_detail(degree, found);
            }
        };
        for (link, &place) in self.links[receiver].iter().zip(&seen.places) {
            if direct[link.source].iter().all(|of| of.whole().discretisation == 0.0) {
                continue;
            }
            for (node, row) in link.rows.iter().enumerate().filter(|(_, row)| row.likely_factor() > 0.0) {
                add(place, link.source, node, &Found::by(row.likely_factor(), &row.kernel, row.truncation()), direct);
            }
        }
        for (place, &source) in seen.sources.iter().enumerate() {
            for node in 0..nodes {
                if let Some(found) = seen.kernel_bounds(place, node) {
                    add(place, source, node, &found, reflected);
                }
            }
        }
        for (sums, of) in detail.chunks_exact_mut(nodes).zip(details) {
            self.far[receiver].add_gathered(of, sums);
        }
        let weights: Vec<f64> = mesh.basis(receiver).nodes().iter().map(|node| node.weight).collect();
        let mean = |values: &[f64]| values.iter().zip(&weights).map(|(v, w)| v * w).sum::<f64>();
        let (mut chosen, mut parts) = (vec![false; count], vec![0.0; count * channels]);
        let mut sums = vec![0.0; channels * nodes];
        for (place, &source) in seen.sources.iter().enumerate() {
            let of_place = place * channels * nodes..(place + 1) * channels * nodes;
            let (range, factor) = (place * nodes..(place + 1) * nodes, |range| mean(&seen.factors[range]));
            let factor = factor(range);
            let (mut by_sign, mut by_size) = (0.0, 0.0);
            for (channel, values) in signed[of_place.clone()].chunks_exact(nodes).enumerate() {
                let size = direct[source][channel].mean_ledger() + reflected[source][channel].mean_ledger();
                parts[place * channels + channel] = mean(values);
                by_sign += values.iter().copied().fold(0.0, larger);
                by_size += factor * size.discretisation;
            }
            chosen[place] = by_sign < by_size;
            if chosen[place] {
                sums.iter_mut().zip(&signed[of_place]).for_each(|(sum, of)| *sum += of);
            }
        }
        let largest = |of: &[f64]| of.iter().copied().fold(0.0, larger);
        let maxima =
            sums.chunks_exact(nodes).zip(detail.chunks_exact(nodes)).flat_map(|(sums, detail)| [largest(sums), largest(detail)]);
        let maxima = maxima.collect();
        let mut sources: Vec<(usize, bool)> = seen.sources.iter().copied().zip(chosen.iter().copied()).collect();
        sources.sort_unstable();
        Gathers { chosen, sources, has_far: !self.far[receiver].is_empty(), most: maxima, parts }
    }
}
