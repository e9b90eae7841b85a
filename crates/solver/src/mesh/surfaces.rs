//! Reflectance and emission of faces: one value on a face, or textures.
//!
//! Transport needs three things: the projection of `rho H` on an element from that of the irradiance H, the largest and the mean
//! reflectance, and at a point the values there. Of a face without textures the first is the projection of H times one number.

use radgrad_core::DVec3;
use radgrad_scene::{Face, Material, Quantity, Scene, largest, smallest};
use rayon::prelude::*;

use crate::error::Error;
use crate::mesh::Mesh;
use crate::mesh::texture::{self, Pattern};

/// Relative differences of radiosities that are those of rounding.
const ROUNDING: f64 = 1e-9;

/// Reflectance and emitted radiosity in each channel.
#[derive(Debug, Clone)]
pub(crate) struct Surfaces {
    /// Of each face; the largest where it has a texture.
    pub(crate) reflectance: Vec<Vec<f64>>,
    pub(crate) emitted: Vec<Vec<f64>>,
    /// The scene, if any face has textures.
    textured: Option<Scene>,
    /// Of each element of a face with textures, in each channel.
    patterns: Vec<Option<Vec<Pattern>>>,
}

impl Surfaces {
    pub(crate) fn from_scene(scene: &Scene) -> Self {
        let of_face = |quantity: Quantity, unit: f64| -> Vec<Vec<f64>> {
            let of_material = |material: &Material| {
                let largest = |channel| material.texture(quantity).map_or(1.0, |texture| texture.largest(channel));
                let factors = material.factors(quantity).iter().enumerate();
                factors.map(|(channel, factor)| unit * factor * largest(channel)).collect::<Vec<f64>>()
            };
            let textured: Vec<Vec<f64>> = scene.materials().iter().map(of_material).collect();
            let values = |face: &Face| match face.chart(quantity) {
                Some(_) => textured[face.material()].clone(),
                None => scene.materials()[face.material()].factors(quantity).iter().map(|factor| unit * factor).collect(),
            };
            scene.faces().iter().map(values).collect()
        };
        Self {
            reflectance: of_face(Quantity::Reflectance, 1.0),
            emitted: of_face(Quantity::Radiance, std::f64::consts::PI),
            textured: scene.is_textured().then(|| scene.clone()),
            patterns: Vec::new(),
        }
    }

    /// Whether light may be even: whether there is one radiosity of which each face emits the part that it does not reflect. Scenes with
    /// textures are not examined: the answer is yes.
    pub(crate) fn may_be_even(&self, mesh: &Mesh) -> bool {
        let faces = || mesh.roots().iter().map(|&root| mesh.elements()[root].face());
        let radiosity = |face: usize, channel: usize| self.emitted[face][channel] / (1.0 - self.reflectance[face][channel]);
        // A face that reflects all light and emits none is as bright as the faces that it sees, whichever they are.
        let is_any = |face: usize, channel: usize| self.reflectance[face][channel] == 1.0 && self.emitted[face][channel] == 0.0;
        let is_even = |channel: usize| {
            let (low, high) = faces()
                .filter(|&face| !is_any(face, channel))
                .map(|face| radiosity(face, channel))
                .fold((f64::INFINITY, 0.0), |(low, high), of| (smallest(low, of), largest(high, of)));
            // Of one that reflects all light and emits some it is infinite, and the difference then is no number, or is infinite too.
            high < f64::INFINITY && high - low <= ROUNDING * high
        };
        let channels = self.emitted.first().map_or(0, Vec::len);
        self.textured.is_some() || (0..channels).all(is_even)
    }

    /// Refuses emitted radiosities beyond the range of a double.
    pub(crate) fn check(&self, channels: &[String]) -> Result<(), Error> {
        for (face, emitted) in self.emitted.iter().enumerate() {
            if let Some(channel) = emitted.iter().position(|value| !value.is_finite()) {
                let (quantity, value) = (format!("radiosity emitted by face {face}"), emitted[channel]);
                return Err(Error::NotFinite { quantity, channel: channels[channel].clone(), value });
            }
        }
        Ok(())
    }

    /// Learns the textures of elements that the mesh has got since.
    pub(crate) fn grow(&mut self, mesh: &Mesh) {
        let Some(scene) = &self.textured else { return };
        let new = self.patterns.len()..mesh.elements().len();
        let of_element = |index: usize| texture::patterns(scene, &mesh.elements()[index], mesh.basis(index));
        let patterns: Vec<_> = new.into_par_iter().map(of_element).collect();
        self.patterns.extend(patterns);
    }

    /// Whether no face emits anything, so that there is no light.
    pub(crate) fn are_dark(&self) -> bool {
        self.emitted.iter().flatten().all(|emitted| *emitted == 0.0)
    }

    /// Whether any face has a texture.
    pub(crate) const fn is_textured(&self) -> bool {
        self.textured.is_some()
    }

    /// Whether a face reflects all light of a channel everywhere.
    pub(crate) fn is_white(&self, face: usize, channel: usize) -> bool {
        let is_patterned =
            || self.textured.as_ref().is_some_and(|scene| scene.faces()[face].chart(Quantity::Reflectance).is_some());
        self.reflectance[face][channel] == 1.0 && !is_patterned()
    }

    /// Whether a face emits by a texture.
    pub(crate) fn glows_by_texture(&self, face: usize) -> bool {
        self.textured.as_ref().is_some_and(|scene| scene.faces()[face].chart(Quantity::Radiance).is_some())
    }

    /// The textures of an element in a channel, if it has any.
    pub(crate) fn pattern(&self, element: usize, channel: usize) -> Option<&Pattern> {
        self.patterns.get(element)?.as_ref().map(|patterns| &patterns[channel])
    }

    /// Projection of `rho H` on an element, from that of the irradiance H.
    pub(crate) fn reflect(&self, mesh: &Mesh, element: usize, channel: usize, irradiance: &mut [f64]) {
        match self.pattern(element, channel) {
            Some(pattern) => irradiance.copy_from_slice(&pattern.reflected(irradiance)),
            None => {
                let rho = self.reflectance[mesh.elements()[element].face()][channel];
                irradiance.iter_mut().for_each(|h| *h *= rho);
            }
        }
    }

    /// Reflectance and emission at a point of a face, in each channel.
    pub(crate) fn reflectance_and_emission(&self, face: usize, point: DVec3) -> [Vec<f64>; 2] {
        match &self.textured {
            None => [self.reflectance[face].clone(), self.emitted[face].clone()],
            Some(scene) => {
                let radiance = scene.value_at(face, Quantity::Radiance, point);
                let emitted = radiance.into_iter().map(|radiance| std::f64::consts::PI * radiance).collect();
                [scene.value_at(face, Quantity::Reflectance, point), emitted]
            }
        }
    }
}
