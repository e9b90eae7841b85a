//! What a face is made of.

use crate::Error;

/// A diffuse material: reflectance and emitted radiance, one value in each channel of its scene.
///
/// Radiance is what files give (`Ke` of MTL, the emissive factor of glTF): power a unit of area and solid angle. A diffuse
/// emitter of radiance L has the radiosity pi L.
#[derive(Debug, Clone, PartialEq)]
pub struct Material {
    name: String,
    reflectance: Vec<f64>,
    radiance: Vec<f64>,
}

impl Material {
    pub(super) fn new(name: String, reflectance: Vec<f64>, radiance: Vec<f64>, channels: &[String]) -> Result<Self, Error> {
        let expected = channels.len();
        for (what, values) in [("reflectances", &reflectance), ("radiances", &radiance)] {
            if values.len() != expected {
                return Err(Error::Count { what, found: values.len(), expected });
            }
        }
        let refused = |quantity, channel: usize, value, rule| {
            let (material, channel) = (name.clone(), channels[channel].clone());
            Err(Error::Material { material, quantity, channel, value, rule })
        };
        if let Some((channel, &value)) = reflectance.iter().enumerate().find(|(_, r)| !(0.0..=1.0).contains(*r)) {
            return refused("reflectance", channel, value, "between 0 and 1");
        }
        if let Some((channel, &value)) = radiance.iter().enumerate().find(|(_, r)| !(0.0..f64::INFINITY).contains(*r)) {
            return refused("radiance", channel, value, "finite and not negative");
        }
        Ok(Self { name, reflectance, radiance })
    }

    /// Its name.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Reflectance in each channel, in [0, 1].
    #[must_use]
    pub fn reflectance(&self) -> &[f64] {
        &self.reflectance
    }

    /// Emitted radiance in each channel, in the unit of the file.
    #[must_use]
    pub fn radiance(&self) -> &[f64] {
        &self.radiance
    }

    /// Emitted radiosity in a channel: pi times the radiance, the `B` of `radgrad_core::Emission`.
    #[must_use]
    pub fn emitted_radiosity(&self, channel: usize) -> Option<f64> {
        self.radiance.get(channel).map(|radiance| std::f64::consts::PI * radiance)
    }

    /// Whether it emits in any channel.
    #[must_use]
    pub fn emits(&self) -> bool {
        self.radiance.iter().any(|&radiance| radiance > 0.0)
    }
}
