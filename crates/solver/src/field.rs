//! The radiosity of a mesh: coefficients in the basis of every element, in every channel.
//!
//! Those of leaves are the unknowns. An element that is divided holds the projection of its leaves, pulled up from its children,
//! and what that leaves out: the mean square of the leaves' radiosity, and for each degree a bound on the difference between the
//! leaves' radiosity and the functions up to that degree.

use crate::mesh::Mesh;
use crate::transfer::Row;

/// A piecewise polynomial radiosity.
#[derive(Debug, Clone, Default)]
pub(crate) struct Field {
    channels: usize,
    /// For each element, channel after channel.
    coefficients: Vec<Vec<f64>>,
    /// For each element and channel.
    mean_square: Vec<Vec<f64>>,
    /// For each element, channel after channel: bounds on what is beyond each degree.
    beyond: Vec<Vec<f64>>,
}

impl Field {
    pub(crate) fn new(channels: usize) -> Self {
        Self { channels, ..Self::default() }
    }

    /// Makes room for elements that the mesh has got since, the restriction of their parent to them.
    pub(crate) fn grow(&mut self, mesh: &Mesh) {
        for index in self.coefficients.len()..mesh.elements().len() {
            let basis = mesh.basis(index);
            let of_channel = |channel: usize| match mesh.elements()[index].parent() {
                Some(parent) => {
                    let child = index - mesh.elements()[parent].children().unwrap_or(index);
                    basis.restrict(child, self.of(parent, channel, basis.len()))
                }
                None => vec![0.0; basis.len()],
            };
            let coefficients = (0..self.channels).flat_map(of_channel).collect();
            self.coefficients.push(coefficients);
            self.mean_square.push(vec![0.0; self.channels]);
            self.beyond.push(vec![0.0; self.channels * (basis.degree() + 1)]);
        }
    }

    /// Coefficients of an element whose basis has `len` functions.
    pub(crate) fn of(&self, element: usize, channel: usize, len: usize) -> &[f64] {
        &self.coefficients[element][channel * len..(channel + 1) * len]
    }

    /// Gives a leaf new coefficients and brings its ancestors up to date. Returns the largest change.
    pub(crate) fn set(&mut self, mesh: &Mesh, leaf: usize, channel: usize, new: &[f64]) -> f64 {
        let range = channel * new.len()..(channel + 1) * new.len();
        let old = &mut self.coefficients[leaf][range.clone()];
        let mut change: Vec<f64> = new.iter().zip(old.iter()).map(|(new, old)| new - old).collect();
        old.copy_from_slice(new);
        let largest = change.iter().fold(0.0, |m: f64, c| m.max(c.abs()));
        let mut at = leaf;
        while let Some(parent) = mesh.elements()[at].parent() {
            let child = at - mesh.elements()[parent].children().unwrap_or(at);
            let mut pulled = vec![0.0; new.len()];
            mesh.basis(parent).pull(child, &change, &mut pulled);
            self.coefficients[parent][range.clone()].iter_mut().zip(&pulled).for_each(|(c, p)| *c += p);
            (at, change) = (parent, pulled);
        }
        largest
    }

    /// Pulls the leaves' radiosity up, and what is lost on the way.
    pub(crate) fn pull(&mut self, mesh: &Mesh) {
        for index in (0..mesh.elements().len()).rev() {
            let (basis, children) = (mesh.basis(index), mesh.elements()[index].children());
            let len = basis.len();
            for channel in 0..self.channels {
                let own = match children {
                    None => self.of(index, channel, len).to_vec(),
                    Some(first) => {
                        let mut own = vec![0.0; len];
                        (0..4).for_each(|child| basis.pull(child, self.of(first + child, channel, len), &mut own));
                        own
                    }
                };
                self.mean_square[index][channel] = match children {
                    None => own.iter().map(|c| c * c).sum(),
                    Some(first) => 0.25 * (first..first + 4).map(|child| self.mean_square[child][channel]).sum::<f64>(),
                };
                for degree in 0..=basis.degree() {
                    let taken = &own[..basis.count(degree)];
                    let beyond = match children {
                        None => basis.magnitude(&without(&own, taken.len())),
                        Some(first) => {
                            let of_child = |child: usize| {
                                let restricted = basis.restrict(child, taken);
                                let of_child = self.of(first + child, channel, len);
                                let difference: Vec<f64> = of_child.iter().zip(&restricted).map(|(c, r)| c - r).collect();
                                let full = channel * (basis.degree() + 1) + basis.degree();
                                self.beyond[first + child][full] + basis.magnitude(&difference)
                            };
                            (0..4).map(of_child).fold(0.0, f64::max)
                        }
                    };
                    self.beyond[index][channel * (basis.degree() + 1) + degree] = beyond;
                }
                self.coefficients[index][channel * len..(channel + 1) * len].copy_from_slice(&own);
            }
        }
    }

    /// Bound on what a link to `source` neglects that takes `count` of its functions, at the node of `row`.
    pub(crate) fn neglected(&self, mesh: &Mesh, source: usize, count: usize, channel: usize, row: &Row) -> f64 {
        let basis = mesh.basis(source);
        let degree = (0..basis.degree()).rev().find(|&d| basis.count(d) < count).map_or(0, |d| d + 1);
        let largest = self.beyond[source][channel * (basis.degree() + 1) + degree];
        if largest == 0.0 {
            return 0.0;
        }
        let rms = self.rms(source, count, channel, basis.len());
        let factor = row.values[0] + row.error;
        (factor * largest).min(0.5 * row.peak * rms).min(row.slope * mesh.elements()[source].radius() * rms)
    }

    /// Root mean square over an element of what is beyond the first `count` functions.
    fn rms(&self, element: usize, count: usize, channel: usize, len: usize) -> f64 {
        let taken: f64 = self.of(element, channel, len)[..count].iter().map(|c| c * c).sum();
        let all = self.mean_square[element][channel];
        // The difference of two sums of squares, each rounded.
        ((all - taken).max(0.0) + 16.0 * f64::EPSILON * all).sqrt()
    }

    /// The largest of the channels' [`Self::rms`], each times its weight.
    pub(crate) fn rms_beyond(&self, element: usize, count: usize, weight: &[f64]) -> f64 {
        let len = self.coefficients[element].len() / self.channels;
        (0..self.channels).map(|c| weight[c] * self.rms(element, count.min(len), c, len)).fold(0.0, f64::max)
    }

    /// Mean radiosity over all elements.
    pub(crate) fn mean(&self, mesh: &Mesh, channel: usize) -> f64 {
        let of_root = |&root: &usize| {
            let area = mesh.elements()[root].area();
            (area, area * self.of(root, channel, mesh.basis(root).len())[0])
        };
        let (area, power) = mesh.roots().iter().map(of_root).fold((0.0, 0.0), |(a, p), (b, q)| (a + b, p + q));
        power / area
    }
}

fn without(coefficients: &[f64], count: usize) -> Vec<f64> {
    coefficients.iter().enumerate().map(|(i, &c)| if i < count { 0.0 } else { c }).collect()
}
