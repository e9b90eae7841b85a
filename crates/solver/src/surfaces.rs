//! Reflectance and emission of faces: one value on a face, or textures.
//!
//! Transport needs three things of a leaf: the projection of `E + rho H` from the irradiance at its nodes, its largest and its
//! mean reflectance, and at a point the values there. Of a face without textures the first is the projection of the irradiance
//! times one number.

use radgrad_core::DVec3;
use radgrad_scene::{Face, Material, Quantity, Scene};
use rayon::prelude::*;

use crate::mesh::Mesh;
use crate::texture::{self, Pattern};

/// Reflectance and emitted radiosity in each channel.
#[derive(Debug, Clone)]
pub(crate) struct Surfaces {
    /// Of each face; the largest where it has a texture.
    pub(crate) reflectance: Vec<Vec<f64>>,
    pub(crate) emitted: Vec<Vec<f64>>,
    /// The scene, if any face has textures.
    textured: Option<Scene>,
    /// Of each leaf of a face with textures, in each channel.
    patterns: Vec<Option<Vec<Pattern>>>,
}

impl Surfaces {
    pub(crate) fn of(scene: &Scene) -> Self {
        let of_face = |quantity: Quantity, unit: f64| -> Vec<Vec<f64>> {
            let of_material = |material: &Material| {
                let largest = |channel| material.texture(quantity).map_or(1.0, |texture| texture.largest(channel));
                let factors = material.factors(quantity).iter().enumerate();
                factors.map(|(channel, factor)| unit * factor * largest(channel)).collect::<Vec<f64>>()
            };
            let textured: Vec<Vec<f64>> = scene.materials().iter().map(of_material).collect();
            let of = |face: &Face| match face.chart(quantity) {
                Some(_) => textured[face.material()].clone(),
                None => scene.materials()[face.material()].factors(quantity).iter().map(|factor| unit * factor).collect(),
            };
            scene.faces().iter().map(of).collect()
        };
        Self {
            reflectance: of_face(Quantity::Reflectance, 1.0),
            emitted: of_face(Quantity::Radiance, std::f64::consts::PI),
            textured: scene.is_textured().then(|| scene.clone()),
            patterns: Vec::new(),
        }
    }

    /// Learns the textures of leaves that the mesh has got since.
    pub(crate) fn grow(&mut self, mesh: &Mesh) {
        let Some(scene) = &self.textured else { return };
        let new = self.patterns.len()..mesh.elements().len();
        let of_element = |index: usize| {
            let element = &mesh.elements()[index];
            element.is_leaf().then(|| texture::patterns(scene, element, mesh.basis(index))).flatten()
        };
        let patterns: Vec<_> = new.into_par_iter().map(of_element).collect();
        self.patterns.extend(patterns);
        for (index, pattern) in self.patterns.iter_mut().enumerate() {
            if !mesh.elements()[index].is_leaf() {
                *pattern = None;
            }
        }
    }

    /// The textures of a leaf in a channel, if it has any.
    pub(crate) fn pattern(&self, leaf: usize, channel: usize) -> Option<&Pattern> {
        self.patterns.get(leaf)?.as_ref().map(|patterns| &patterns[channel])
    }

    /// Projection of `E + rho H` on a leaf from the irradiance at its nodes.
    pub(crate) fn radiosity(&self, mesh: &Mesh, leaf: usize, channel: usize, irradiance: &[f64]) -> Vec<f64> {
        let (basis, face) = (mesh.basis(leaf), mesh.elements()[leaf].face());
        if let Some(pattern) = self.pattern(leaf, channel) {
            return pattern.radiosity(&basis.project(irradiance));
        }
        let reflected: Vec<f64> = irradiance.iter().map(|h| self.reflectance[face][channel] * h).collect();
        let mut radiosity = basis.project(&reflected);
        radiosity[0] += self.emitted[face][channel];
        radiosity
    }

    /// Mean and largest reflectance on a leaf.
    pub(crate) fn reflectance_on(&self, mesh: &Mesh, leaf: usize, channel: usize) -> [f64; 2] {
        match self.pattern(leaf, channel) {
            Some(pattern) => [pattern.mean_reflectance(), pattern.largest_reflectance()],
            None => [self.reflectance[mesh.elements()[leaf].face()][channel]; 2],
        }
    }

    /// Reflectance and emission at a point of a face, in each channel.
    pub(crate) fn at(&self, face: usize, point: DVec3) -> [Vec<f64>; 2] {
        match &self.textured {
            None => [self.reflectance[face].clone(), self.emitted[face].clone()],
            Some(scene) => {
                let radiance = scene.at(face, Quantity::Radiance, point);
                let emitted = radiance.into_iter().map(|radiance| std::f64::consts::PI * radiance).collect();
                [scene.at(face, Quantity::Reflectance, point), emitted]
            }
        }
    }
}
