//! The discrete system that is solved: elements, and the links between them.

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

    pub(crate) fn reflectance(&self, element: usize, channel: usize) -> f64 {
        self.surfaces.reflectance[self.mesh.elements()[element].face()][channel]
    }
}
