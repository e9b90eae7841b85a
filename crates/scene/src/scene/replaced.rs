//! A scene with other values on its faces: what depends on its geometry alone, such as form factors, holds for both.

use std::collections::HashMap;

use super::Scene;
use crate::error::Error;
use crate::texture::Quantity;

impl Scene {
    /// The same with other values of a quantity, `channels` of each face, row by row. They stand in for its material's, and for a texture.
    ///
    /// ```
    /// use radgrad_scene::{Degenerate, Quantity, Scene};
    /// # let file = concat!(env!("CARGO_MANIFEST_DIR"), "/../../data/scenes/two_blocks.obj");
    /// let scene = Scene::read(file, Degenerate::Refuse)?;
    /// let values = vec![0.25; scene.faces().len() * scene.channels().len()];
    /// let grey = scene.replaced(Quantity::Reflectance, &values)?;
    /// assert_eq!(grey.mean_over(3, Quantity::Reflectance, 0), 0.25);
    /// assert_eq!(grey.mean_over(3, Quantity::Radiance, 0), scene.mean_over(3, Quantity::Radiance, 0));
    /// # Ok::<(), radgrad_scene::Error>(())
    /// ```
    ///
    /// # Errors
    /// If the number of values is another, or one is out of range.
    pub fn replaced(&self, quantity: Quantity, values: &[f64]) -> Result<Self, Error> {
        let (channels, expected) = (self.channels.len(), self.faces.len() * self.channels.len());
        if values.len() != expected {
            return Err(Error::Count { what: "values of faces", found: values.len(), expected });
        }
        let mut scene = Self { materials: Vec::new(), ..self.clone() };
        let mut known: HashMap<(usize, Vec<u64>), usize> = HashMap::new();
        for (face, values) in values.chunks_exact(channels).enumerate() {
            let before = &self.materials[self.faces[face].material];
            let key = (self.faces[face].material, values.iter().map(|value| value.to_bits()).collect());
            let material = match known.get(&key) {
                Some(material) => *material,
                None => {
                    let [reflectance, radiance] =
                        Quantity::ALL.map(|of| if of == quantity { values.to_vec() } else { before.factors(of).to_vec() });
                    let added = scene.add_material(before.name(), reflectance, radiance)?;
                    for of in Quantity::ALL.into_iter().filter(|of| *of != quantity) {
                        if let Some(texture) = before.texture(of) {
                            scene.set_texture(added, of, std::sync::Arc::clone(texture))?;
                        }
                    }
                    known.insert(key, added);
                    added
                }
            };
            scene.faces[face].material = material;
            scene.faces[face].charts[quantity as usize] = None;
        }
        Ok(scene)
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use radgrad_core::{DVec3, Polygon};

    use super::*;
    use crate::{Degenerate, Prepared};

    #[test]
    fn other_values_leave_all_else_and_wrong_ones_are_refused() {
        let file = concat!(env!("CARGO_MANIFEST_DIR"), "/../../data/scenes/cornell.obj");
        let scene = Scene::read(file, Degenerate::Refuse).unwrap();
        let count = scene.faces().len() * scene.channels().len();
        let values: Vec<f64> = (0..count).map(|index| index as f64 / count as f64).collect();
        let other = scene.replaced(Quantity::Reflectance, &values).unwrap();
        for face in 0..scene.faces().len() {
            for channel in 0..3 {
                assert_eq!(other.mean_over(face, Quantity::Reflectance, channel), values[3 * face + channel]);
                let [a, b] = [&scene, &other].map(|of| of.mean_over(face, Quantity::Radiance, channel));
                assert_eq!(a, b);
            }
            assert_eq!(scene.faces()[face].polygon(), other.faces()[face].polygon());
        }
        assert_eq!((scene.surfaces(), scene.notes().len()), (other.surfaces(), other.notes().len()));
        let [own, of_other] = [&scene, &other].map(|of| Prepared::new(of).unwrap().index);
        assert!(Arc::ptr_eq(&own, &of_other), "the index is not built again");
        let mut more = other.clone();
        let beside = Polygon::new([0.0, 1.0, 2.0].map(|x| DVec3::new(9e3 + x, x * x, 0.0)).to_vec()).unwrap();
        more.add_face(0, 0, beside, None).unwrap();
        assert_eq!(Prepared::new(&more).unwrap().index.len(), own.len() + 1);
        assert!(scene.replaced(Quantity::Reflectance, &values[1..]).is_err());
        for wrong in [1.5, -0.1, f64::NAN] {
            assert!(scene.replaced(Quantity::Reflectance, &vec![wrong; count]).is_err(), "{wrong}");
        }
        assert!(scene.replaced(Quantity::Radiance, &vec![f64::INFINITY; count]).is_err());
    }
}
