//! The radiosity of a mesh: coefficients in the basis of every element, in every channel.
//!
//! A light is given on an antichain of elements, so that every leaf is one of them or below one. The elements below hold its
//! restriction. Those above hold its projection, pulled up from the children, with the remainder: the mean square of the leaves'
//! radiosity, and a bound on the difference between the leaves' radiosity and the element's polynomial.

use radgrad_scene::largest;
use rayon::prelude::*;

use crate::bytes::bytes_of;
use crate::mesh::Mesh;
use crate::mesh::glow::ClusterEmission;

/// A piecewise polynomial radiosity.
#[derive(Debug, Clone, Default)]
pub(crate) struct Field {
    channels: usize,
    /// For each element, channel after channel.
    coefficients: Vec<Vec<f64>>,
    /// For each element and channel.
    mean_square: Vec<Vec<f64>>,
    /// For each element and channel, a bound on its polynomial's remainder, and the root mean square of that.
    truncation: Vec<Vec<f64>>,
    rms: Vec<Vec<f64>>,
    /// For each channel, the light that each cluster sends out.
    glows: Vec<Vec<ClusterEmission>>,
}

impl Field {
    /// No light.
    pub(crate) fn dark(mesh: &Mesh, channels: usize) -> Self {
        let elements = 0..mesh.elements().len();
        let coefficients = elements.clone().map(|e| vec![0.0; channels * mesh.basis(e).len()]).collect();
        let dark = vec![ClusterEmission::default(); mesh.clusters().clusters().len()];
        let none: Vec<Vec<f64>> = elements.map(|_| vec![0.0; channels]).collect();
        Self {
            channels,
            coefficients,
            mean_square: none.clone(),
            truncation: none.clone(),
            rms: none,
            glows: vec![dark; channels],
        }
    }

    /// Whether it is one of this mesh, in so many channels.
    pub(crate) fn is_of(&self, mesh: &Mesh, channels: usize) -> bool {
        let elements = mesh.elements().len();
        let is_each = |of: &Vec<Vec<f64>>| of.len() == elements && of.iter().all(|of| of.len() == channels);
        self.channels == channels
            && self.coefficients.len() == elements
            && self.coefficients.iter().enumerate().all(|(index, of)| of.len() == channels * mesh.basis(index).len())
            && [&self.mean_square, &self.truncation, &self.rms].into_iter().all(is_each)
            && self.glows.len() == channels
            && self.glows.iter().all(|glows| glows.len() == mesh.clusters().clusters().len())
    }

    /// Makes room for elements that the mesh has got since, the restriction of their parent to them.
    pub(crate) fn grow(&mut self, mesh: &Mesh) {
        for index in self.coefficients.len()..mesh.elements().len() {
            let basis = mesh.basis(index);
            let of_channel = |channel: usize| match mesh.elements()[index].parent() {
                Some(parent) => basis.restrict(mesh.child(index), self.coefficients(parent, channel)),
                None => vec![0.0; basis.len()],
            };
            let coefficients = (0..self.channels).flat_map(of_channel).collect();
            self.coefficients.push(coefficients);
            self.mean_square.push(vec![0.0; self.channels]);
            self.truncation.push(vec![0.0; self.channels]);
            self.rms.push(vec![0.0; self.channels]);
        }
    }

    /// Coefficients of an element.
    pub(crate) fn coefficients(&self, element: usize, channel: usize) -> &[f64] {
        let of_element = &self.coefficients[element];
        let len = of_element.len() / self.channels;
        &of_element[channel * len..(channel + 1) * len]
    }

    /// Adds to an element, all below and all above it.
    pub(crate) fn add(&mut self, mesh: &Mesh, element: usize, channel: usize, change: &[f64]) {
        self.add_below(mesh, element, channel, change);
        let len = change.len();
        let (mut at, mut change) = (element, change.to_vec());
        while let Some(parent) = mesh.elements()[at].parent() {
            let mut pulled = vec![0.0; len];
            mesh.basis(parent).pull(mesh.child(at), &change, &mut pulled);
            add_to(&mut self.coefficients[parent][channel * len..(channel + 1) * len], &pulled);
            (at, change) = (parent, pulled);
        }
    }

    /// Adds to an element and all below it.
    fn add_below(&mut self, mesh: &Mesh, element: usize, channel: usize, change: &[f64]) {
        let len = change.len();
        add_to(&mut self.coefficients[element][channel * len..(channel + 1) * len], change);
        if let Some(first) = mesh.elements()[element].children() {
            for child in 0..4 {
                let restricted = mesh.basis(element).restrict(child, change);
                self.add_below(mesh, first + child, channel, &restricted);
            }
        }
    }

    /// Pulls the leaves' radiosity up, and the remainder of each projection.
    pub(crate) fn pull(&mut self, mesh: &Mesh) {
        for index in (0..mesh.elements().len()).rev() {
            let (basis, children) = (mesh.basis(index), mesh.elements()[index].children());
            let len = basis.len();
            for channel in 0..self.channels {
                let Some(first) = children else {
                    self.mean_square[index][channel] = self.coefficients(index, channel).iter().map(|c| c * c).sum();
                    (self.truncation[index][channel], self.rms[index][channel]) = (0.0, 0.0);
                    continue;
                };
                let mut own = vec![0.0; len];
                (0..4).for_each(|child| basis.pull(child, self.coefficients(first + child, channel), &mut own));
                self.mean_square[index][channel] =
                    0.25 * (first..first + 4).map(|child| self.mean_square[child][channel]).sum::<f64>();
                let of_child = |child: usize| {
                    let restricted = basis.restrict(child, &own);
                    let of_child = self.coefficients(first + child, channel);
                    let difference: Vec<f64> = of_child.iter().zip(&restricted).map(|(c, r)| c - r).collect();
                    self.truncation[first + child][channel] + basis.magnitude(&difference)
                };
                self.truncation[index][channel] = (0..4).map(of_child).fold(0.0, largest);
                self.coefficients[index][channel * len..(channel + 1) * len].copy_from_slice(&own);
                self.rms[index][channel] = self.rms(index, channel);
            }
        }
        for channel in 0..self.channels {
            self.glows[channel] = mesh.clusters().glows(|element| self.glow_of(mesh, element, channel));
        }
    }

    /// The light that a cluster sends out.
    pub(crate) fn glow(&self, cluster: usize, channel: usize) -> &ClusterEmission {
        &self.glows[channel][cluster]
    }

    /// Sums the powers of clusters anew.
    pub(crate) fn pool(&mut self, mesh: &Mesh) {
        let Self { coefficients, glows, channels, .. } = self;
        glows.par_iter_mut().enumerate().for_each(|(channel, glows)| {
            let mean = |of_element: &[f64]| of_element[channel * (of_element.len() / *channels)];
            let power = |element: usize| mesh.elements()[element].area() * mean(&coefficients[element]);
            let powers = mesh.clusters().pull(power, |a, b| a + b);
            glows.iter_mut().zip(powers).for_each(|(glow, power)| glow.power = power);
        });
    }

    /// The light that an element sends out.
    fn glow_of(&self, mesh: &Mesh, element: usize, channel: usize) -> ClusterEmission {
        let area = mesh.elements()[element].area();
        let power = area * self.coefficients(element, channel)[0];
        ClusterEmission { power, ..ClusterEmission::default() }.over(area, area * self.mean_square[element][channel])
    }

    /// Bound on the magnitude of the leaves' radiosity less the element's polynomial.
    pub(crate) fn left_out(&self, element: usize, channel: usize) -> f64 {
        self.truncation[element][channel]
    }

    /// Bound on the root mean square of the leaves' radiosity less the element's polynomial.
    pub(crate) fn left_out_rms(&self, element: usize, channel: usize) -> f64 {
        self.rms[element][channel]
    }

    /// Root mean square over an element of the leaves' radiosity less the polynomial.
    fn rms(&self, element: usize, channel: usize) -> f64 {
        let taken: f64 = self.coefficients(element, channel).iter().map(|c| c * c).sum();
        let whole = self.mean_square[element][channel];
        // The difference of two sums of squares, each rounded.
        (largest(whole - taken, 0.0) + 16.0 * f64::EPSILON * whole).sqrt()
    }

    /// Mean over all elements.
    pub(crate) fn mean(&self, mesh: &Mesh, channel: usize) -> f64 {
        mesh.mean(|root| self.coefficients[root][channel * mesh.basis(root).len()])
    }
}

fn add_to(coefficients: &mut [f64], change: &[f64]) {
    coefficients.iter_mut().zip(change).for_each(|(c, change)| *c += change);
}

bytes_of!(Field { channels, coefficients, mean_square, truncation, rms, glows });
