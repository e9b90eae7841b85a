//! The discrete system that is solved: elements, and the links between them.

use crate::field::Field;
use crate::gathering::{Equation, irradiance};
use crate::links::cell::Rules;
use crate::links::cluster::far::Far;
use crate::links::direct::Lamps;
use crate::links::link::Link;
use crate::mesh::Mesh;
use crate::mesh::surfaces::Surfaces;

/// Elements of a scene, and their links. The radiosity is a [`Field`](crate::field::Field) on it.
#[derive(Debug)]
pub(crate) struct System {
    pub(crate) mesh: Mesh,
    pub(crate) surfaces: Surfaces,
    pub(crate) rules: Rules,
    pub(crate) lamps: Lamps,
    /// Elements that gather reflected light.
    pub(crate) receivers: Vec<usize>,
    /// Links of receivers; empty for other elements.
    pub(crate) links: Vec<Vec<Link>>,
    /// Of receivers, the clusters that no link is for.
    pub(crate) far: Vec<Far>,
    pub(crate) channels: Vec<String>,
    /// The longest side of the scene's box.
    pub(crate) extent: f64,
}

impl System {
    /// Whether each element is a receiver.
    pub(crate) fn receives(&self) -> Vec<bool> {
        let mut receives = vec![false; self.mesh.elements().len()];
        self.receivers.iter().for_each(|&receiver| receives[receiver] = true);
        receives
    }

    /// The equation on the receivers with a source.
    pub(crate) fn equation<'a>(&'a self, source: &'a [Vec<f64>]) -> Equation<'a> {
        let Self { mesh, surfaces, receivers, links, far, .. } = self;
        Equation { mesh, surfaces, receivers, links, far, source }
    }

    /// Irradiance at each node of a receiver, without the light that links and clusters neglect.
    pub(crate) fn irradiance(&self, field: &Field, receiver: usize, channel: usize) -> Vec<f64> {
        let nodes = self.mesh.basis(receiver).nodes().len();
        irradiance(field, &self.links[receiver], &self.far[receiver], channel, nodes)
    }

    /// The polynomials of the reflectance of receivers, the source of their importance, and as many zeros.
    pub(crate) fn reflectances(&self) -> [Vec<Vec<f64>>; 2] {
        let mut source = vec![Vec::new(); self.mesh.elements().len()];
        let mut own = source.clone();
        for &receiver in &self.receivers {
            let len = self.mesh.basis(receiver).len();
            let of_channel = |channel: usize| match self.surfaces.pattern(receiver, channel) {
                Some(pattern) => pattern.reflectance().to_vec(),
                None => (0..len).map(|i| if i == 0 { self.reflectance(receiver, channel) } else { 0.0 }).collect(),
            };
            source[receiver] = (0..self.channels.len()).flat_map(of_channel).collect();
            own[receiver] = vec![0.0; source[receiver].len()];
        }
        [source, own]
    }

    pub(crate) fn reflectance(&self, element: usize, channel: usize) -> f64 {
        self.surfaces.reflectance[self.mesh.elements()[element].face()][channel]
    }
}
