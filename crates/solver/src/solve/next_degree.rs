//! The part of the radiosity beyond the polynomials on elements: the next degree, with its sign.
//!
//! A residual `r = B_g - B_h` is sampled at the nodes of every projection, where direct light and links were computed anyway. The
//! nodes see the polynomials of the next degree exactly ([`crate::mesh::rule`]); these, of direct light on leaves and of
//! reflected light on the receivers above, are the detail. The samples' truncation beyond that too is kept as a root mean square
//! without a sign. Both are samples: of light with features between the nodes nothing is known.

use radgrad_scene::largest;
use rayon::prelude::*;

use crate::links::link::Link;
use crate::mesh::basis::Basis;
use crate::once::made;
use crate::solve::solution::Solution;

/// Of an element in a channel; above leaves, the projection of theirs.
#[derive(Debug, Clone, Default)]
pub(crate) struct Detail {
    /// Coefficients in the basis of the next degree.
    pub(crate) coefficients: Vec<f64>,
    /// Root mean square of the samples' truncation.
    pub(crate) truncation: f64,
    /// The part of that along the polynomials up to the next degree, which samples cannot tell from it.
    pub(crate) along: f64,
    /// On leaves, the light that links and clusters neglect, as if the links' signs were at random.
    pub(crate) neglected: f64,
}

impl Detail {
    /// The part of the coefficients that is taken for the light's own, beside the truncation: Wiener's filter.
    pub(super) fn sure(&self) -> f64 {
        let square = self.coefficients.iter().map(|c| c * c).sum::<f64>();
        if square > 0.0 { square / (square + self.truncation * self.truncation) } else { 1.0 }
    }

    fn with(mut self, other: &Self) -> Self {
        self.coefficients.iter_mut().zip(&other.coefficients).for_each(|(sum, c)| *sum += c);
        self.truncation = self.truncation.hypot(other.truncation);
        self.along = self.along.hypot(other.along);
        self.neglected += other.neglected;
        self
    }

    /// That of an element whose children have these.
    fn over(above: &Basis, children: [&Self; 4]) -> Self {
        let squares = |coefficients: &[f64]| coefficients.iter().map(|c| c * c).sum::<f64>();
        let mut over = Self { coefficients: vec![0.0; above.len()], ..Self::default() };
        let (mut all, mut along) = (0.0, 0.0);
        for (child, of) in children.into_iter().enumerate() {
            above.pull(child, &of.coefficients, &mut over.coefficients);
            all += 0.25 * (squares(&of.coefficients) + of.truncation * of.truncation);
            along += 0.25 * of.along * of.along;
        }
        over.along = along.sqrt();
        over.truncation = largest(all - squares(&over.coefficients), 0.0).sqrt();
        over
    }
}

impl Solution {
    /// Details of elements, by channel.
    pub(crate) fn details(&self) -> &[Vec<Detail>] {
        made::<Vec<_>>(&self.caches.details, || {
            let of_receiver = |&receiver: &usize| (receiver, self.of_reflected(receiver));
            let receivers: Vec<(usize, Vec<Detail>)> = self.system.receivers.par_iter().map(of_receiver).collect();
            let mut reflected = vec![Vec::new(); self.system.mesh.elements().len()];
            receivers.into_iter().for_each(|(receiver, details)| reflected[receiver] = details);
            for element in 0..reflected.len() {
                let Some(above) = self.basis(element).above() else { continue };
                if let Some(parent) = self.element(element).parent().filter(|_| reflected[element].is_empty()) {
                    let child = self.system.mesh.child(element);
                    let restricted = |of: &Detail| Detail { coefficients: above.restrict(child, &of.coefficients), ..*of };
                    reflected[element] = reflected[parent].iter().map(restricted).collect();
                }
            }
            let of_leaf = |leaf: usize| match self.element(leaf).is_leaf() {
                true => {
                    let both = |(channel, reflected): (usize, &Detail)| self.of_direct(leaf, channel).with(reflected);
                    reflected[leaf].iter().enumerate().map(both).collect()
                }
                false => Vec::new(),
            };
            let mut details: Vec<Vec<Detail>> = (0..reflected.len()).into_par_iter().map(of_leaf).collect();
            for element in (0..details.len()).rev() {
                let Some(first) = self.element(element).children() else { continue };
                let Some(above) = self.basis(element).above() else { continue };
                let merged = |channel: usize| Detail::over(above, [0, 1, 2, 3].map(|child| &details[first + child][channel]));
                let over = (0..self.channels().len()).map(merged).collect();
                details[element] = over;
            }
            details
        })
    }

    fn of_direct(&self, leaf: usize, channel: usize) -> Detail {
        if self.radiosity.direct.is_empty() {
            let len = self.basis(leaf).above().map_or(0, Basis::len);
            return Detail { coefficients: vec![0.0; len], ..Detail::default() };
        }
        self.detail_of(leaf, &self.direct_samples(leaf, channel))
    }

    fn of_reflected(&self, receiver: usize) -> Vec<Detail> {
        let nodes = self.basis(receiver).nodes().len();
        let rho = self.reflectance_of(receiver);
        let of_channel = |(channel, rho): (usize, &f64)| {
            let received = self.system.irradiance(&self.radiosity.field, receiver, channel);
            let neglected = (0..nodes).map(|node| rho * self.neglected_at(receiver, channel, node)).fold(0.0, largest);
            let samples: Vec<f64> = received.iter().map(|h| rho * h).collect();
            Detail { neglected, ..self.detail_of(receiver, &samples) }
        };
        rho.iter().enumerate().map(of_channel).collect()
    }

    fn detail_of(&self, element: usize, samples: &[f64]) -> Detail {
        let basis = self.basis(element);
        let excess = basis.excess(samples);
        let along = basis.seen_of(&excess) * excess.spread;
        Detail { coefficients: basis.next(samples), truncation: excess.spread, along, neglected: 0.0 }
    }

    /// The light that a node's links and clusters neglect.
    fn neglected_at(&self, receiver: usize, channel: usize, node: usize) -> f64 {
        let of_link = |link: &Link| self.radiosity.field.neglected(&self.system.mesh, link.source, channel, &link.rows[node]);
        let of_links = self.system.links[receiver].iter().map(of_link).map(|size| size * size).sum::<f64>().sqrt();
        of_links + self.system.far[receiver].likely(&self.radiosity.field, channel, node)
    }
}
