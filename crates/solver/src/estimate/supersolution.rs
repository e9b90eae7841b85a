//! A function that is nowhere less than `own + rho G w`: sweeps from 0 until they rise no more, then a margin, and a check that one
//! more sweep does not exceed it.
//!
//! Of w a node gathers from a source at most F times its largest value and `k_max` times its mean, k the kernel times the area;
//! of a cluster likewise ([`crate::links::cluster::far::Far::gathered`]).
//! The largest values are those at the nodes; only near-by sources need each other's, if means are known.

use radgrad_scene::{largest as larger, smallest as smaller};
use rayon::prelude::*;

use crate::estimate::visible_sources::VisibleSources;
use crate::mesh::glow::Pair;
use crate::system::System;

/// Sweeps after which there is no bound: far more than any reflectance below 0.99 needs.
const MOST_SWEEPS: usize = 2000;

/// Sweeps in which they have to rise less and less: they do not where form factors, as far as they are known, leave nothing to be lost.
const A_WHILE: usize = 100;

/// Relative margin added to the sweeps, so that a rest that would still rise a little stays below the sum.
const MARGIN: f64 = 0.03;

/// How much they may still rise, as a part.
const RISE: f64 = 1e-2;

/// The fewest receivers for which a thread is worth its while.
const FEW: usize = 16;

/// For each element, channel after channel: the largest value at a node, of elements above receivers too, and by how much the
/// values at a receiver's nodes differ.
#[derive(Debug, Clone)]
pub(super) struct Supersolution {
    pub(super) largest: Vec<f64>,
    pub(super) variation: Vec<f64>,
}

impl Supersolution {
    /// Solves for bounds, from each receiver's own values at its nodes, channel after channel, and from means that hold already.
    pub(super) fn solve(
        system: &System,
        receives: &[bool],
        seen: &[VisibleSources],
        own: &[Vec<f64>],
        means: &[f64],
    ) -> Option<Self> {
        let System { mesh, receivers, far, .. } = system;
        let channels = system.channels.len();
        let on_clusters = |largest: &[f64]| pairs(system, largest, means);
        let at_nodes = |largest: &[f64], on_clusters: &[Vec<Pair>], index: usize, channel: usize| -> Vec<f64> {
            let (rho, nodes) = (system.reflectance(receivers[index], channel), seen[index].nodes);
            let mut at_nodes = seen[index].gathered((channel, channels), largest, means);
            far[receivers[index]].add_gathered(&on_clusters[channel], &mut at_nodes);
            let own = &own[index][channel * nodes..(channel + 1) * nodes];
            at_nodes.iter_mut().zip(own).for_each(|(sum, own)| *sum = own + rho * *sum);
            at_nodes
        };
        let swept = |largest: &[f64]| -> Vec<Vec<f64>> {
            let clusters = on_clusters(largest);
            let largest_on =
                |channel: usize, index: usize| at_nodes(largest, &clusters, index, channel).into_iter().fold(0.0, larger);
            let in_channels = |index: usize| (0..channels).map(|channel| largest_on(channel, index)).collect();
            (0..receivers.len()).into_par_iter().with_min_len(FEW).map(in_channels).collect()
        };
        let largest_of_four = |of: [f64; 4]| of.into_iter().fold(0.0, larger);
        let mut largest = vec![0.0; mesh.elements().len() * channels];
        let mut risen_by = f64::INFINITY;
        for sweep in 1..=MOST_SWEEPS {
            let next = swept(&largest);
            let held = |receiver: usize, channel: usize| largest[receiver * channels + channel];
            if sweep % A_WHILE == 0 {
                let by = |(&receiver, next): (&usize, &Vec<f64>)| {
                    next.iter().enumerate().map(|(c, n)| n - held(receiver, c)).fold(0.0, larger)
                };
                let rise = receivers.iter().zip(&next).map(by).fold(0.0, larger);
                // Also where it is no number.
                let falls = rise < risen_by || rise == 0.0;
                if !falls {
                    return None;
                }
                risen_by = rise;
            }
            let mut pairs = receivers.iter().zip(&next);
            let rising = pairs.any(|(&r, next)| next.iter().enumerate().any(|(c, n)| *n > held(r, c) * (1.0 + RISE)));
            let margin = if rising { 1.0 } else { 1.0 + MARGIN };
            for (&receiver, next) in receivers.iter().zip(next) {
                let held = &mut largest[receiver * channels..(receiver + 1) * channels];
                held.iter_mut().zip(next).for_each(|(held, next)| *held = next * margin);
            }
            system.pull(receives, &mut largest, largest_of_four);
            if rising {
                continue;
            }
            let check = swept(&largest);
            let held = |receiver: usize, channel: usize| largest[receiver * channels + channel];
            let mut pairs = receivers.iter().zip(&check);
            if pairs.all(|(&r, check)| check.iter().enumerate().all(|(c, n)| *n <= held(r, c))) {
                let (mut variation, clusters) = (vec![0.0; largest.len()], on_clusters(&largest));
                for (index, &receiver) in receivers.iter().enumerate() {
                    for channel in 0..channels {
                        let entry = receiver * channels + channel;
                        let least = at_nodes(&largest, &clusters, index, channel).into_iter().fold(largest[entry], smaller);
                        variation[entry] = largest[entry] - least;
                    }
                }
                return Some(Self { largest, variation });
            }
        }
        None
    }

    /// The largest value on a receiver, with the variation between the nodes.
    pub(super) fn largest_with_variation(&self, index: usize) -> f64 {
        self.largest[index] + self.variation[index]
    }
}

/// For each channel, bounds on a quantity on clusters, from its largest values and means on elements.
pub(super) fn pairs(system: &System, largest: &[f64], means: &[f64]) -> Vec<Vec<Pair>> {
    let entry = |element: usize, channel: usize| element * system.channels.len() + channel;
    system.pairs(|element, channel| (largest[entry(element, channel)], means[entry(element, channel)]))
}
