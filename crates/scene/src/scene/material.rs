//! Materials of faces: diffuse reflectance and emitted radiance.

use std::f64::consts::PI;
use std::sync::Arc;

use crate::error::Error;
use crate::texture::{Quantity, Texture};

/// A diffuse material: reflectance and emitted radiance, one value in each channel of its scene, and a texture for each that
/// varies over its faces. Values are then times those of the texture.
///
/// Radiance is the quantity in the files (`Ke` of MTL, the emissive factor of glTF): power a unit of area and solid angle. A
/// diffuse emitter of radiance L has the radiosity pi L.
///
/// ```
/// use radgrad_scene::Scene;
/// let mut scene = Scene::new(["r", "g", "b"])?;
/// let panel = scene.add_material("panel", [0.0; 3], [100.0; 3])?;
/// assert_eq!(scene.materials()[panel].emitted_radiosity(0), Some(100.0 * std::f64::consts::PI));
/// # Ok::<(), radgrad_scene::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Material {
    name: String,
    reflectance: Vec<f64>,
    radiance: Vec<f64>,
    /// Of the reflectance and of the radiance.
    textures: [Option<Arc<Texture>>; 2],
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
        if let Some((channel, &value)) = radiance.iter().enumerate().find(|(_, r)| !(0.0..f64::INFINITY).contains(&(PI * **r))) {
            return refused("radiance", channel, value, "finite and not negative, and so must be its product with pi");
        }
        Ok(Self { name, reflectance, radiance, textures: [None, None] })
    }

    /// Makes no reflectance larger than `most` in any channel, and says whether one was. A texture is darkened as a whole.
    pub(super) fn cap_reflectance(&mut self, most: f64) -> bool {
        let texture = self.textures[Quantity::Reflectance as usize].as_deref();
        let mut capped = false;
        for (channel, factor) in self.reflectance.iter_mut().enumerate() {
            let peak = texture.map_or(1.0, |texture| texture.largest(channel));
            if *factor * peak > most {
                *factor = most / peak;
                capped = true;
            }
        }
        capped
    }

    /// Gives the material a texture; values times that of each texel must be as those of any material.
    pub(super) fn set_texture(&mut self, quantity: Quantity, texture: Arc<Texture>, channels: &[String]) -> Result<(), Error> {
        if texture.channels() != channels.len() {
            return Err(Error::Count { what: "values in a texel", found: texture.channels(), expected: channels.len() });
        }
        let (factors, largest, rule) = match quantity {
            Quantity::Reflectance => (&self.reflectance, 1.0, "between 0 and 1"),
            Quantity::Radiance => (&self.radiance, f64::MAX / PI, "finite, and so must be its product with pi"),
        };
        // Which texel it is, is looked for only where there is one.
        let exceeds = (0..channels.len()).any(|channel| factors[channel] * texture.largest(channel) > largest);
        let exceeding = || texture.values().find(|&(value, _, c)| factors[c] * value > largest);
        if let Some((value, [column, row], channel)) = exceeds.then(exceeding).flatten() {
            let (product, quantity, material) = (factors[channel] * value, quantity.name(), &self.name);
            let rule = format!(
                "{quantity} of material `{material}` is {product} at texel ({column}, {row}) in channel `{}`: it must be {rule}",
                channels[channel]
            );
            return Err(Error::Texture { texture: texture.name().to_owned(), rule });
        }
        self.textures[quantity as usize] = Some(texture);
        Ok(())
    }

    /// The texture that its reflectance or its radiance is to be multiplied by.
    #[must_use]
    pub const fn texture(&self, quantity: Quantity) -> Option<&Arc<Texture>> {
        self.textures[quantity as usize].as_ref()
    }

    /// Its values without the texture.
    #[must_use]
    pub fn factors(&self, quantity: Quantity) -> &[f64] {
        match quantity {
            Quantity::Reflectance => &self.reflectance,
            Quantity::Radiance => &self.radiance,
        }
    }

    /// Its name.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Reflectance in each channel, in [0, 1]; where there is a texture, the factor of its values.
    #[must_use]
    pub fn reflectance(&self) -> &[f64] {
        &self.reflectance
    }

    /// Emitted radiance in each channel, in the unit of the file; where there is a texture, the factor of its values.
    #[must_use]
    pub fn radiance(&self) -> &[f64] {
        &self.radiance
    }

    /// Emitted radiosity in a channel without the texture: pi times the radiance, the `B` of `radgrad_core::Emission`.
    #[must_use]
    pub fn emitted_radiosity(&self, channel: usize) -> Option<f64> {
        self.radiance.get(channel).map(|radiance| PI * radiance)
    }

    /// Whether it emits in any channel.
    #[must_use]
    pub fn emits(&self) -> bool {
        self.radiance.iter().any(|&radiance| radiance > 0.0)
    }
}
