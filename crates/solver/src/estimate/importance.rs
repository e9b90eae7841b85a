//! The importance `z = G b`, `b = rho + rho G b`: how much of a unit of light that leaves a place is reflected anywhere, once or
//! more.
//!
//! That is the radiosity equation with rho for the light that is emitted, so the links for it are there. Its polynomial solution
//! `b_h` has the defect `d = rho + rho G b_h - b_h`, and z is more than `G b_h` by `y = G d + G rho y`, bounded at every point by
//! sweeps ([`super::supersolution`]) from bounds on the nodes' gather of d. With textures d is not small, and then `z = G rho (1 + z)` as
//! it is may be less.
//!
//! With textures, of `rho y` with y at most Y, a point gathers at most Y times the least of `F max rho`, `k_max mean rho` and
//! `F mean rho + (k_max - k_min)/2 rms(rho - mean rho)`.

use radgrad_scene::{largest as larger, smallest as smaller};
use rayon::prelude::*;

use crate::error::Error;
use crate::estimate::residual::{Residual, Residuals};
use crate::estimate::supersolution::Supersolution;
use crate::estimate::visible_sources::VisibleSources;
use crate::field::Field;
use crate::gathering::MOST_SWEEPS;
use crate::links::link::Link;
use crate::mesh::glow::Pair;
use crate::system::System;

/// Changes below which the importance is solved: its defect has the remainder.
const SOLVED: f64 = 1e-3;

/// Of each receiver, in their order.
#[derive(Debug)]
pub(super) struct Importance {
    /// For each source that it sees, channel and node, the most that is gathered of `b_h`.
    pub(super) gathered: Vec<Vec<f64>>,
    /// For each channel and node, the same of light through clusters.
    from_clusters: Vec<Vec<f64>>,
    /// For each channel, the most by which z exceeds that.
    more: Vec<Vec<f64>>,
    /// For each channel, the most that z is in any case.
    most: Vec<Vec<f64>>,
}

impl Importance {
    /// The largest importance on a receiver, of light that the chosen sources and all in clusters reflect.
    pub(super) fn largest_on(&self, index: usize, channel: usize, seen: &VisibleSources, chosen: impl Fn(usize) -> bool) -> f64 {
        let (nodes, channels) = (seen.nodes, self.more[index].len());
        let mut sums = self.from_clusters[index][channel * nodes..(channel + 1) * nodes].to_vec();
        for place in (0..seen.sources.len()).filter(|&place| chosen(place)) {
            let start = (place * channels + channel) * nodes;
            sums.iter_mut().zip(&self.gathered[index][start..start + nodes]).for_each(|(sum, z)| *sum += z);
        }
        let largest = sums.into_iter().fold(0.0, larger);
        smaller(largest + self.more[index][channel], self.most[index][channel])
    }
}

/// Where no bound on the defect of `b_h` is found, as where faces reflect all light, the defect is left out.
pub(super) fn solve(system: &System, receives: &[bool], seen: &[VisibleSources]) -> Result<Importance, Error> {
    let System { mesh, surfaces, receivers, links, far, .. } = system;
    let channels = system.channels.len();
    let (field, own) = solved(system)?;
    let gathered_on = |(index, &receiver): (usize, &usize)| gathers(system, &field, &links[receiver], &seen[index]);
    let gathered: Vec<Vec<f64>> = receivers.par_iter().enumerate().map(gathered_on).collect();
    let of_far = |(index, &receiver): (usize, &usize)| -> Vec<f64> {
        // Errors of samples have either sign as often.
        let value = |channel: usize, node: usize| far[receiver].value(&field, channel, node);
        (0..channels)
            .flat_map(|channel| (0..seen[index].nodes).map(move |node| (channel, node)))
            .map(|(c, n)| value(c, n))
            .collect()
    };
    let from_clusters: Vec<Vec<f64>> = receivers.par_iter().enumerate().map(of_far).collect();
    let of_receiver = |(index, &receiver): (usize, &usize)| -> Vec<Residual> {
        (0..channels).map(|channel| defect(system, &field, receiver, channel, &seen[index], &own[receiver])).collect()
    };
    let defects: Vec<Vec<Residual>> = receivers.par_iter().enumerate().map(of_receiver).collect();
    let defects = Residual::everywhere(mesh, receivers, defects, channels);
    let unknown = vec![f64::INFINITY; mesh.elements().len() * channels];
    let on_clusters = system.pairs_of(&[&defects]);
    let of_defect = |(index, &receiver): (usize, &usize)| system.gathered_of(receiver, &defects, &on_clusters, &seen[index]);
    let own: Vec<Vec<f64>> = receivers.par_iter().enumerate().map(of_defect).collect();
    let more = Supersolution::solve(system, receives, seen, &own, &unknown);
    let largest_at_nodes = if surfaces.is_textured() || more.is_none() {
        let on_clusters = system.pairs(|element, channel| (system.reflectance(element, channel), f64::INFINITY));
        let reflected = |(index, &receiver): (usize, &usize)| system.reflected(receiver, &on_clusters, &seen[index]);
        let own: Vec<Vec<f64>> = receivers.par_iter().enumerate().map(reflected).collect();
        Supersolution::solve(system, receives, seen, &own, &unknown)
    } else {
        None
    };
    let is_bounded = more.is_some() || largest_at_nodes.is_some();
    let largest = |of: &Option<Supersolution>| -> Vec<Vec<f64>> {
        let largest_on = |receiver: usize, channel: usize| match (of, system.reflectance(receiver, channel)) {
            // The residual of a black receiver is rounding alone.
            (_, 0.0) => 0.0,
            (None, _) => f64::INFINITY,
            // As z itself at the nodes; but with textures this is most of it, and its variation is added.
            (Some(risen), rho) if surfaces.is_textured() => risen.largest_with_variation(receiver * channels + channel) / rho,
            (Some(risen), rho) => risen.largest[receiver * channels + channel] / rho,
        };
        let mut values: Vec<Vec<f64>> =
            receivers.iter().map(|&receiver| (0..channels).map(|channel| largest_on(receiver, channel)).collect()).collect();
        for channel in 0..channels {
            let greatest = values.iter().map(|of| of[channel]).fold(0.0, larger);
            let black = receivers.iter().zip(&mut values).filter(|(receiver, _)| system.reflectance(**receiver, channel) == 0.0);
            black.for_each(|(_, of)| of[channel] = greatest);
        }
        values
    };
    let nothing = || vec![vec![0.0; channels]; receivers.len()];
    Ok(Importance {
        gathered,
        from_clusters,
        more: if is_bounded { largest(&more) } else { nothing() },
        most: largest(&largest_at_nodes),
    })
}

/// The polynomial solution and the receivers' own coefficients of it.
fn solved(system: &System) -> Result<(Field, Vec<Vec<f64>>), Error> {
    let [source, mut own] = system.reflectances();
    let mut field = Field::dark(&system.mesh, system.channels.len());
    let even = vec![1.0; system.channels.len()];
    let until = (SOLVED, MOST_SWEEPS);
    let (sweeps, change) = system.equation(&source).solve((&mut field, &mut own), until, even, |_, _| ());
    if change <= SOLVED {
        field.pull(&system.mesh);
        return Ok((field, own));
    }
    Err(Error::Unsettled { sweeps, change })
}

/// Bounds on the gather of `b_h` by the nodes of a receiver from each source, in each channel.
fn gathers(system: &System, field: &Field, links: &[Link], seen: &VisibleSources) -> Vec<f64> {
    let System { mesh, .. } = system;
    let channels = system.channels.len();
    let mut gathered = vec![0.0; seen.sources.len() * channels * seen.nodes];
    for (link, place) in links.iter().zip(&seen.places) {
        for channel in 0..channels {
            let (coefficients, start) = (field.coefficients(link.source, channel), (place * channels + channel) * seen.nodes);
            for (sum, row) in gathered[start..start + seen.nodes].iter_mut().zip(&link.rows) {
                let value: f64 = row.values.iter().zip(coefficients).map(|(v, c)| v * c).sum();
                *sum += value + field.neglected(mesh, link.source, channel, row) + row.likely_error_of(coefficients);
            }
        }
    }
    gathered
}

/// The defect of `b_h` on a receiver.
fn defect(system: &System, field: &Field, receiver: usize, channel: usize, seen: &VisibleSources, own: &[f64]) -> Residual {
    let System { mesh, surfaces, links, far, .. } = system;
    let (element, basis, rho) = (&mesh.elements()[receiver], mesh.basis(receiver), system.reflectance(receiver, channel));
    let far = &far[receiver];
    let mut at_nodes: Vec<f64> = (0..seen.nodes).map(|node| far.value(field, channel, node)).collect();
    let mut beside = vec![0.0; seen.nodes];
    for link in &links[receiver] {
        let coefficients = field.coefficients(link.source, channel);
        for ((sum, beside), row) in at_nodes.iter_mut().zip(&mut beside).zip(&link.rows) {
            *sum += row.values.iter().zip(coefficients).map(|(v, c)| v * c).sum::<f64>();
            *beside += field.neglected(mesh, link.source, channel, row) + row.likely_error_of(coefficients);
        }
    }
    let samples: Vec<f64> = at_nodes.iter().map(|h| rho * h).collect();
    let held = &own[channel * basis.len()..(channel + 1) * basis.len()];
    let mut defect = Residual::project(element, basis, &samples);
    let unsolved: Vec<f64> = match surfaces.pattern(receiver, channel) {
        None => {
            let mut projected = basis.project(&samples);
            projected.iter_mut().zip(held).for_each(|(p, b)| *p -= b);
            projected[0] += rho;
            projected
        }
        Some(pattern) => {
            let mut sent = basis.project(&at_nodes);
            sent[0] += 1.0;
            defect = defect.textured(element, pattern, rho, pattern.detail(basis, &sent, false));
            pattern.reflected(&sent).iter().zip(held).map(|(p, b)| p - b).collect()
        }
    };
    defect.largest.computation = rho * beside.into_iter().fold(0.0, larger);
    defect.largest.solver = basis.magnitude(&unsolved);
    defect
}

impl System {
    /// Bounds on the gather by the nodes of a receiver of a quantity known on receivers and above, times the reflectance; channel
    /// after channel.
    fn gathered_of(&self, receiver: usize, of: &Residuals, on_clusters: &[Vec<Pair>], seen: &VisibleSources) -> Vec<f64> {
        let mut sums = vec![0.0; self.channels.len() * seen.nodes];
        for (place, &source) in seen.sources.iter().enumerate() {
            let degree = self.mesh.basis(source).degree();
            for node in 0..seen.nodes {
                let Some(found) = seen.kernel_bounds(place, node) else { continue };
                for (channel, residual) in of[source].iter().enumerate() {
                    sums[channel * seen.nodes + node] += residual.gathered(degree, &found).total();
                }
            }
        }
        for (channel, sums) in sums.chunks_exact_mut(seen.nodes).enumerate() {
            let rho = self.reflectance(receiver, channel);
            self.far[receiver].add_gathered(&on_clusters[channel], sums);
            sums.iter_mut().for_each(|sum| *sum *= rho);
        }
        sums
    }

    /// The gather by the nodes of a receiver of a unit of light everywhere, times the reflectance.
    fn reflected(&self, receiver: usize, on_clusters: &[Vec<Pair>], seen: &VisibleSources) -> Vec<f64> {
        let largest: Vec<f64> = (0..self.mesh.elements().len())
            .flat_map(|element| (0..self.channels.len()).map(move |channel| self.reflectance(element, channel)))
            .collect();
        let unknown = vec![f64::INFINITY; largest.len()];
        let of = |channel: usize| {
            let rho = self.reflectance(receiver, channel);
            let mut sums = seen.gathered((channel, self.channels.len()), &largest, &unknown);
            self.far[receiver].add_gathered(&on_clusters[channel], &mut sums);
            sums.into_iter().map(move |sum| rho * sum)
        };
        (0..self.channels.len()).flat_map(of).collect()
    }
}
