//! Sources that the nodes of a receiver, or a point, see: receivers and the elements above them.
//!
//! Links to elements below a receiver are taken together, as the residual of reflected light cancels over receivers, not over
//! their parts. Numbers of the nodes lie beside each other: gathers are summed for all nodes at a time.

use std::collections::HashMap;

use crate::estimate::residual::Found;
use crate::links::station::Station;
use crate::links::transfer::{Kernel, Row, Sampled};
use crate::mesh::Mesh;
use crate::mesh::surfaces::Surfaces;
use radgrad_scene::{largest as larger, smallest as smaller};

/// Form factors and kernels for each source and node.
#[derive(Debug)]
pub(crate) struct VisibleSources {
    pub(super) sources: Vec<usize>,
    /// For each link, the place of its source among the sources.
    pub(super) places: Vec<usize>,
    pub(super) nodes: usize,
    /// Bounds on the form factor, and the kernels and their largest values; 0 where nothing is seen. Node after node.
    pub(crate) factors: Vec<f64>,
    pub(super) kernels: Vec<Kernel>,
    /// Root mean square of the kernel's truncation by the source's polynomials.
    pub(crate) truncation: Vec<f64>,
    peaks: Vec<f64>,
    /// With textures, for each channel and node the reflectance that counts by the largest; else nothing.
    even: Vec<Vec<f64>>,
}

impl VisibleSources {
    /// From links, with their rows for the stations.
    pub(crate) fn gather<'a>(
        mesh: &Mesh,
        surfaces: &Surfaces,
        stations: &[Station],
        receives: &[bool],
        links: impl Iterator<Item = (usize, &'a [Row])>,
    ) -> Self {
        let nodes = stations.len();
        let (sources, places, factors, kernels) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
        let (truncation, peaks, even) = (Vec::new(), Vec::new(), Vec::new());
        let mut view = Self { sources, places, nodes, factors, kernels, truncation, peaks, even };
        let mut places = HashMap::new();
        // Of the parts of receivers together.
        let mut together: Vec<Option<Vec<Together>>> = Vec::new();
        for (source, rows) in links {
            let receiver = receiver_above(mesh, receives, source).filter(|&receiver| receiver != source);
            let next = view.sources.len();
            let Some(receiver) = receiver else {
                view.places.push(next);
                view.sources.push(source);
                view.factors.extend(rows.iter().map(Row::likely_factor));
                view.kernels.extend(rows.iter().map(|row| row.kernel));
                view.truncation.extend(rows.iter().map(Row::truncation));
                together.push(None);
                continue;
            };
            let place = *places.entry(receiver).or_insert_with(|| {
                view.sources.push(receiver);
                view.factors.resize(view.factors.len() + nodes, 0.0);
                view.kernels.extend(stations.iter().map(|station| Kernel::bound(station, &mesh.elements()[receiver])));
                view.truncation.resize(view.truncation.len() + nodes, f64::INFINITY);
                together.push(Some(vec![Together::new(mesh.basis(receiver).len()); nodes]));
                next
            });
            view.places.push(place);
            if let Some(together) = &mut together[place] {
                together.iter_mut().zip(rows).for_each(|(all, row)| all.add(mesh, receiver, source, row));
            }
            let range = place * nodes..(place + 1) * nodes;
            for ((factor, kernel), row) in view.factors[range.clone()].iter_mut().zip(&mut view.kernels[range]).zip(rows) {
                *factor += row.likely_factor();
                if !row.kernel.smooth {
                    (kernel.smooth, kernel.least) = (false, 0.0);
                }
            }
        }
        for (place, together) in together.into_iter().enumerate() {
            let truncation = &mut view.truncation[place * nodes..(place + 1) * nodes];
            truncation
                .iter_mut()
                .zip(together.into_iter().flatten())
                .for_each(|(truncation, all)| *truncation = all.truncation());
        }
        let peak = |(factor, kernel): (&f64, &Kernel)| if *factor > 0.0 { kernel.peak } else { 0.0 };
        view.peaks = view.factors.iter().zip(&view.kernels).map(peak).collect();
        if surfaces.is_textured() {
            view.even = (0..view.sources.len()).map(|place| view.weighed(place, mesh, surfaces)).collect();
        }
        view
    }

    /// Factors and kernels of a source at the nodes.
    fn at_nodes(&self, place: usize) -> impl Iterator<Item = (f64, &Kernel)> {
        let range = place * self.nodes..(place + 1) * self.nodes;
        self.factors[range.clone()].iter().copied().zip(&self.kernels[range])
    }

    /// Bounds on the kernel of a source at a node, if the node sees it.
    pub(super) fn kernel_bounds(&self, place: usize, node: usize) -> Option<Found> {
        let index = place * self.nodes + node;
        (self.factors[index] > 0.0).then(|| Found::by(self.factors[index], &self.kernels[index], self.truncation[index]))
    }

    /// For each node the ratio of a textured source's mean reflectance to its largest one.
    fn weighed(&self, place: usize, mesh: &Mesh, surfaces: &Surfaces) -> Vec<f64> {
        let source = self.sources[place];
        let reflectances = &surfaces.reflectance[mesh.elements()[source].face()];
        if surfaces.pattern(source, 0).is_none() {
            return Vec::new();
        }
        let of_channel = |(channel, reflectances): (usize, &f64)| {
            let of_node = |(factor, kernel): (f64, &Kernel)| {
                let is_known = factor > 0.0 && *reflectances > 0.0 && kernel.peak.is_finite();
                let Some(pattern) = surfaces.pattern(source, channel).filter(|_| is_known) else { return 1.0 };
                let (mean, [_, varies, _]) = (pattern.mean_reflectance(), pattern.spread_of_reflectance());
                let halved = factor * mean + 0.5 * (kernel.peak - kernel.least) * varies;
                smaller(smaller(halved, kernel.peak * mean) / (factor * reflectances), 1.0)
            };
            self.at_nodes(place).map(of_node).collect::<Vec<f64>>()
        };
        reflectances.iter().enumerate().flat_map(of_channel).collect()
    }

    /// Largest factor and largest peak over the nodes.
    pub(super) fn largest_factor_and_peak(&self, place: usize) -> (f64, f64) {
        let range = place * self.nodes..(place + 1) * self.nodes;
        let largest = |of: &[f64]| of.iter().copied().fold(0.0, larger);
        (largest(&self.factors[range.clone()]), largest(&self.peaks[range]))
    }

    /// Bounds on each node's gather of a quantity with these largest values and means on the sources, in a channel.
    pub(crate) fn gathered(&self, (channel, channels): (usize, usize), largest: &[f64], means: &[f64]) -> Vec<f64> {
        let mut sums = vec![0.0; self.nodes];
        for (place, source) in self.sources.iter().enumerate() {
            let (largest, mean) = (largest[source * channels + channel], means[source * channels + channel]);
            let range = place * self.nodes..(place + 1) * self.nodes;
            let (factors, peaks) = (&self.factors[range.clone()], &self.peaks[range]);
            let even = self.even.get(place).filter(|even| !even.is_empty());
            if let Some(even) = even {
                let even = &even[channel * self.nodes..(channel + 1) * self.nodes];
                for (((sum, factor), peak), even) in sums.iter_mut().zip(factors).zip(peaks).zip(even) {
                    *sum += smaller_if_known(factor * largest * even, peak * mean);
                }
            } else {
                for ((sum, factor), peak) in sums.iter_mut().zip(factors).zip(peaks) {
                    *sum += smaller_if_known(factor * largest, peak * mean);
                }
            }
        }
        sums
    }
}

/// The kernel over a receiver from parts of it.
#[derive(Debug, Clone)]
struct Together {
    sampled: Option<Sampled>,
    /// Its projection on the receiver's basis.
    values: Vec<f64>,
}

impl Together {
    fn new(len: usize) -> Self {
        Self { sampled: Some(Sampled::default()), values: vec![0.0; len] }
    }

    /// Adds a part. A part that the receiver does not see is 0 and has no row.
    fn add(&mut self, mesh: &Mesh, receiver: usize, part: usize, row: &Row) {
        if row.likely_factor() == 0.0 {
            return;
        }
        let (Some(all), Some(of_part)) = (&mut self.sampled, &row.sampled) else {
            self.sampled = None;
            return;
        };
        all.square += of_part.square * mesh.elements()[receiver].area() / mesh.elements()[part].area();
        // A function of the receiver is on the part one of its own, of no larger values.
        all.error += of_part.error;
        let (mut at, mut values) = (part, row.values.clone());
        while let Some(parent) = mesh.elements()[at].parent().filter(|_| at != receiver) {
            let mut pulled = vec![0.0; values.len()];
            mesh.basis(parent).pull(mesh.child(at), &values, &mut pulled);
            // Means over a child count for a quarter, but these are sums.
            values = pulled.into_iter().map(|v| 4.0 * v).collect();
            at = parent;
        }
        self.values.iter_mut().zip(values).for_each(|(sum, v)| *sum += v);
    }

    fn truncation(&self) -> f64 {
        self.sampled.map_or(f64::INFINITY, |sampled| sampled.truncation(&self.values))
    }
}

/// The lesser of two, the first one if the other is no number, as where the kernel is infinite and the mean 0.
pub(super) fn smaller_if_known(a: f64, b: f64) -> f64 {
    if b < a { b } else { a }
}

/// The receiver that an element is or is below.
fn receiver_above(mesh: &Mesh, receives: &[bool], element: usize) -> Option<usize> {
    mesh.above(element).find(|&at| receives[at])
}
