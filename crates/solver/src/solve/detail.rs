//! The part of the radiosity beyond the polynomials on elements: the next degree, with its sign.
//!
//! A residual `r = B_g - B_h` is sampled at the nodes of every projection, where direct light and links were computed anyway. The nodes
//! see the polynomials of the next degree exactly ([`crate::mesh::rule`]); these, of direct light on leaves and of reflected light on the
//! receivers above, are the detail. What the samples have beyond that too is kept as a root mean square without a sign. Both are samples:
//! of light with features between the nodes nothing is known.

use radgrad_scene::largest;
use rayon::prelude::*;

use crate::field::gathering::irradiance;
use crate::links::link::Link;
use crate::mesh::basis::Basis;
use crate::once::made;
use crate::solve::solution::Solution;

/// Of an element in a channel; above leaves, the projection of theirs.
#[derive(Debug, Clone, Default)]
pub(crate) struct Detail {
    /// Coefficients in the basis of the next degree.
    pub(crate) coefficients: Vec<f64>,
    /// Root mean square of what samples have beyond that.
    pub(crate) beyond: f64,
    /// The part of that along the polynomials up to the next degree, which samples cannot tell from it.
    pub(crate) along: f64,
    /// On leaves, what links and clusters neglect of it, as if the links' signs were at random.
    pub(crate) neglected: f64,
}

impl Detail {
    /// The part of the coefficients that is taken for the light's own, beside what samples have beyond: Wiener's filter.
    pub(super) fn sure(&self) -> f64 {
        let square = self.coefficients.iter().map(|c| c * c).sum::<f64>();
        if square > 0.0 { square / (square + self.beyond * self.beyond) } else { 1.0 }
    }

    fn with(mut self, other: &Self) -> Self {
        self.coefficients.iter_mut().zip(&other.coefficients).for_each(|(sum, c)| *sum += c);
        self.beyond = self.beyond.hypot(other.beyond);
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
            all += 0.25 * (squares(&of.coefficients) + of.beyond * of.beyond);
            along += 0.25 * of.along * of.along;
        }
        over.along = along.sqrt();
        over.beyond = largest(all - squares(&over.coefficients), 0.0).sqrt();
        over
    }
}

impl Solution {
    /// Details of elements, by channel.
    pub(crate) fn details(&self) -> &[Vec<Detail>] {
        made::<Vec<_>>(&self.details, || {
            let of_receiver = |&receiver: &usize| (receiver, self.of_reflected(receiver));
            let receivers: Vec<(usize, Vec<Detail>)> = self.receivers.par_iter().map(of_receiver).collect();
            let mut reflected = vec![Vec::new(); self.mesh.elements().len()];
            receivers.into_iter().for_each(|(receiver, details)| reflected[receiver] = details);
            for element in 0..reflected.len() {
                let Some(above) = self.mesh.basis(element).above() else { continue };
                if let Some(parent) = self.mesh.elements()[element].parent().filter(|_| reflected[element].is_empty()) {
                    let child = self.mesh.child(element);
                    let restricted = |of: &Detail| Detail { coefficients: above.restrict(child, &of.coefficients), ..*of };
                    reflected[element] = reflected[parent].iter().map(restricted).collect();
                }
            }
            let of_leaf = |leaf: usize| match self.mesh.elements()[leaf].is_leaf() {
                true => {
                    let both = |(channel, reflected): (usize, &Detail)| self.of_direct(leaf, channel).with(reflected);
                    reflected[leaf].iter().enumerate().map(both).collect()
                }
                false => Vec::new(),
            };
            let mut all: Vec<Vec<Detail>> = (0..reflected.len()).into_par_iter().map(of_leaf).collect();
            for element in (0..all.len()).rev() {
                let Some(first) = self.mesh.elements()[element].children() else { continue };
                let Some(above) = self.mesh.basis(element).above() else { continue };
                let of = |channel: usize| Detail::over(above, [0, 1, 2, 3].map(|child| &all[first + child][channel]));
                let over = (0..self.channels.len()).map(of).collect();
                all[element] = over;
            }
            all
        })
    }

    fn of_direct(&self, leaf: usize, channel: usize) -> Detail {
        if self.direct.is_empty() {
            let len = self.mesh.basis(leaf).above().map_or(0, Basis::len);
            return Detail { coefficients: vec![0.0; len], ..Detail::default() };
        }
        self.detail_of(leaf, &self.direct_samples(leaf, channel))
    }

    fn of_reflected(&self, receiver: usize) -> Vec<Detail> {
        let nodes = self.mesh.basis(receiver).nodes().len();
        let rho = &self.surfaces.reflectance[self.mesh.elements()[receiver].face()];
        let of_channel = |(channel, rho): (usize, &f64)| {
            let received = irradiance(&self.mesh, &self.field, &self.links[receiver], &self.far[receiver], channel, nodes);
            let neglected = (0..nodes).map(|node| rho * self.neglected_at(receiver, channel, node)).fold(0.0, largest);
            let samples: Vec<f64> = received.iter().map(|h| rho * h).collect();
            Detail { neglected, ..self.detail_of(receiver, &samples) }
        };
        rho.iter().enumerate().map(of_channel).collect()
    }

    fn detail_of(&self, element: usize, samples: &[f64]) -> Detail {
        let basis = self.mesh.basis(element);
        let excess = basis.excess(samples);
        let along = basis.seen_of(&excess) * excess.spread;
        Detail { coefficients: basis.next(samples), beyond: excess.spread, along, neglected: 0.0 }
    }

    /// What a node's links and clusters neglect.
    fn neglected_at(&self, receiver: usize, channel: usize, node: usize) -> f64 {
        let of_link = |link: &Link| self.field.neglected(&self.mesh, link.source, channel, &link.rows[node]);
        let of_links = self.links[receiver].iter().map(of_link).map(|size| size * size).sum::<f64>().sqrt();
        of_links + self.far[receiver].likely(&self.field, channel, node)
    }
}
