//! What the nodes of a receiver, or a point, see of receivers and of the elements above them.
//!
//! Links to elements below a receiver are taken together, as what is left out of reflected light cancels over receivers, not
//! over their parts. Numbers of the nodes lie beside each other: what is gathered is summed for all of them at a time.

use std::collections::HashMap;

use crate::mesh::Mesh;
use crate::surfaces::Surfaces;
use crate::transfer::{Kernel, Row, Station};

/// What is seen, for each source and node.
#[derive(Debug)]
pub(super) struct Seen {
    pub(super) sources: Vec<usize>,
    /// For each link, the place of what it belongs to among the sources.
    pub(super) places: Vec<usize>,
    pub(super) nodes: usize,
    /// Bounds on the form factor, and the kernels and their largest values; 0 where nothing is seen. Node after node.
    pub(super) factors: Vec<f64>,
    pub(super) kernels: Vec<Kernel>,
    peaks: Vec<f64>,
    /// With textures, for each channel and node the reflectance that counts by the largest; else nothing.
    even: Vec<Vec<f64>>,
}

impl Seen {
    /// From links, with their rows for the stations.
    pub(super) fn of<'a>(
        mesh: &Mesh,
        surfaces: &Surfaces,
        stations: &[Station],
        receives: &[bool],
        links: impl Iterator<Item = (usize, &'a [Row])>,
    ) -> Self {
        let nodes = stations.len();
        let (sources, places, factors, kernels) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
        let mut seen = Self { sources, places, nodes, factors, kernels, peaks: Vec::new(), even: Vec::new() };
        let mut known = HashMap::new();
        for (source, rows) in links {
            let receiver = receiver_above(mesh, receives, source).filter(|&receiver| receiver != source);
            let next = seen.sources.len();
            let Some(receiver) = receiver else {
                seen.places.push(next);
                seen.sources.push(source);
                seen.factors.extend(rows.iter().map(Row::factor));
                seen.kernels.extend(rows.iter().map(|row| row.kernel));
                continue;
            };
            let place = *known.entry(receiver).or_insert_with(|| {
                seen.sources.push(receiver);
                seen.factors.resize(seen.factors.len() + nodes, 0.0);
                seen.kernels.extend(stations.iter().map(|station| Kernel::of(station, &mesh.elements()[receiver])));
                next
            });
            seen.places.push(place);
            let range = place * nodes..(place + 1) * nodes;
            for ((factor, kernel), row) in seen.factors[range.clone()].iter_mut().zip(&mut seen.kernels[range]).zip(rows) {
                *factor += row.factor();
                if !row.kernel.smooth {
                    (kernel.smooth, kernel.least) = (false, 0.0);
                }
            }
        }
        let peak = |(factor, kernel): (&f64, &Kernel)| if *factor > 0.0 { kernel.peak } else { 0.0 };
        seen.peaks = seen.factors.iter().zip(&seen.kernels).map(peak).collect();
        if surfaces.is_textured() {
            seen.even = (0..seen.sources.len()).map(|place| seen.weighed(place, mesh, surfaces)).collect();
        }
        seen
    }

    /// Factors and kernels of a source at the nodes.
    pub(super) fn at_nodes(&self, place: usize) -> impl Iterator<Item = (f64, &Kernel)> {
        let range = place * self.nodes..(place + 1) * self.nodes;
        self.factors[range.clone()].iter().copied().zip(&self.kernels[range])
    }

    /// What part of the largest reflectance of a source with textures counts.
    fn weighed(&self, place: usize, mesh: &Mesh, surfaces: &Surfaces) -> Vec<f64> {
        let source = self.sources[place];
        let most = &surfaces.reflectance[mesh.elements()[source].face()];
        if surfaces.pattern(source, 0).is_none() {
            return Vec::new();
        }
        let of_channel = |(channel, most): (usize, &f64)| {
            let of_node = |(factor, kernel): (f64, &Kernel)| {
                let Some(pattern) = surfaces.pattern(source, channel).filter(|_| factor > 0.0 && *most > 0.0) else {
                    return 1.0;
                };
                if !kernel.peak.is_finite() {
                    return 1.0;
                }
                let (mean, [_, varies, _]) = (pattern.mean_reflectance(), pattern.spread_of_reflectance());
                let halved = factor * mean + 0.5 * (kernel.peak - kernel.least) * varies;
                (halved.min(kernel.peak * mean) / (factor * most)).min(1.0)
            };
            self.at_nodes(place).map(of_node).collect::<Vec<f64>>()
        };
        most.iter().enumerate().flat_map(of_channel).collect()
    }

    /// Largest factor and largest peak over the nodes.
    pub(super) fn most(&self, place: usize) -> (f64, f64) {
        let range = place * self.nodes..(place + 1) * self.nodes;
        let largest = |of: &[f64]| of.iter().copied().fold(0.0, f64::max);
        (largest(&self.factors[range.clone()]), largest(&self.peaks[range]))
    }

    /// What each node gathers at most of what has at most these values and means on the sources, in a channel.
    pub(super) fn gathered(&self, (channel, channels): (usize, usize), largest: &[f64], means: &[f64]) -> Vec<f64> {
        let mut sums = vec![0.0; self.nodes];
        for (place, source) in self.sources.iter().enumerate() {
            let (largest, mean) = (largest[source * channels + channel], means[source * channels + channel]);
            let range = place * self.nodes..(place + 1) * self.nodes;
            let (factors, peaks) = (&self.factors[range.clone()], &self.peaks[range]);
            let even = self.even.get(place).filter(|even| !even.is_empty());
            if let Some(even) = even {
                let even = &even[channel * self.nodes..(channel + 1) * self.nodes];
                for (((sum, factor), peak), even) in sums.iter_mut().zip(factors).zip(peaks).zip(even) {
                    *sum += lesser(factor * largest * even, peak * mean);
                }
            } else {
                for ((sum, factor), peak) in sums.iter_mut().zip(factors).zip(peaks) {
                    *sum += lesser(factor * largest, peak * mean);
                }
            }
        }
        sums
    }
}

/// The lesser of two, the first one if the other is no number, as where the kernel is infinite and the mean 0.
fn lesser(a: f64, b: f64) -> f64 {
    if b < a { b } else { a }
}

/// The receiver that an element is or is below.
fn receiver_above(mesh: &Mesh, receives: &[bool], element: usize) -> Option<usize> {
    std::iter::successors(Some(element), |&at| mesh.elements()[at].parent()).find(|&at| receives[at])
}
