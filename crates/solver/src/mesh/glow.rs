//! Sums over clusters of quantities given on elements: the light that they send out, or a largest value and an integral.

use crate::bytes::bytes_of;
use crate::mesh::clusters::{Clusters, Parts};
use crate::mesh::element::Element;
use radgrad_scene::largest;

/// Light that a cluster sends out, in a channel.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct ClusterEmission {
    /// Integral of the radiosity over the area.
    pub(crate) power: f64,
    /// Area, and integral of the square.
    pub(crate) area: f64,
    pub(crate) square: f64,
    /// Deviation from the mean, times the area.
    pub(crate) unevenness: f64,
}

impl ClusterEmission {
    /// With the area and the integral of the square of the emission.
    pub(crate) fn over(self, area: f64, square: f64) -> Self {
        let variance = area * square - self.power * self.power;
        Self { area, square, unevenness: if variance > 0.0 { variance.sqrt() } else { 0.0 }, ..self }
    }

    pub(crate) fn and(self, other: Self) -> Self {
        Self { power: self.power + other.power, ..Self::default() }.over(self.area + other.area, self.square + other.square)
    }
}

/// Of something that is nowhere negative on the elements of a cluster: its largest value, and its integral over the area.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Pair {
    pub(crate) largest: f64,
    pub(crate) whole: f64,
}

impl Pair {
    pub(crate) const fn and(self, other: Self) -> Self {
        Self { largest: largest(self.largest, other.largest), whole: self.whole + other.whole }
    }
}

impl Clusters {
    /// The light that clusters send out.
    pub(crate) fn glows(&self, of_element: impl Fn(usize) -> ClusterEmission) -> Vec<ClusterEmission> {
        self.pull(of_element, ClusterEmission::and)
    }

    /// Of something on each element.
    pub(crate) fn pairs(&self, elements: &[Element], of: impl Fn(usize) -> (f64, f64)) -> Vec<Pair> {
        let of_element = |element: usize| {
            let (largest, mean) = of(element);
            Pair { largest, whole: elements[element].area() * mean }
        };
        self.pull(of_element, Pair::and)
    }

    /// For each element the values given for clusters, joined over all clusters that it is in.
    pub(crate) fn push<T: Copy>(&self, of_cluster: &[T], join: impl Fn(T, T) -> T, mut visit: impl FnMut(usize, T)) {
        let mut pushed = of_cluster.to_vec();
        for (index, cluster) in self.clusters().iter().enumerate() {
            match cluster.parts {
                Parts::Two(parts) => parts.into_iter().for_each(|part| pushed[part] = join(pushed[index], pushed[part])),
                Parts::Element(element) => visit(element, pushed[index]),
            }
        }
    }
}

bytes_of!(ClusterEmission { power, area, square, unevenness });
