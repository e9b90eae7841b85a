//! A scene as bytes, to be sent to another machine: the same faces, materials and textures back, bit for bit, without the notes of
//! its reader.
//!
//! JSON. The scene read back passes through the constructors of [`Scene`], so bytes that were tampered with are refused as a file
//! is.

use std::path::PathBuf;
use std::sync::Arc;

use radgrad_core::{DVec3, Polygon};
use serde::{Deserialize, Serialize};

use super::{Modelling, Scene};
use crate::error::Error;
use crate::place::{Place, Position};
use crate::texture::chart::Chart;
use crate::texture::{Quantity, Texture, Wrap};

#[derive(Serialize, Deserialize)]
struct SceneRecord {
    title: Option<String>,
    enclosure: Option<bool>,
    channels: Vec<String>,
    textures: Vec<TextureRecord>,
    materials: Vec<MaterialRecord>,
    /// Name, and whether it exchanges light.
    surfaces: Vec<(String, bool)>,
    files: Vec<PathBuf>,
    faces: Vec<FaceRecord>,
    /// Precision, distance and share.
    modelling: [f64; 3],
}

#[derive(Serialize, Deserialize)]
struct TextureRecord {
    name: String,
    size: [usize; 2],
    channels: usize,
    wrap: [Wrap; 2],
    texels: Vec<f64>,
}

#[derive(Serialize, Deserialize)]
struct MaterialRecord {
    name: String,
    reflectance: Vec<f64>,
    radiance: Vec<f64>,
    textures: [Option<usize>; 2],
}

#[derive(Serialize, Deserialize)]
struct FaceRecord {
    vertices: Vec<[f64; 3]>,
    /// Of the coordinates, and the largest motion of a vertex.
    precision: f64,
    moved: f64,
    surface: usize,
    material: usize,
    /// Index of the file, and where in it.
    place: Option<(usize, Position)>,
    charts: [Option<[[f64; 3]; 4]>; 2],
}

impl Scene {
    /// The scene as bytes.
    ///
    /// ```
    /// use radgrad_scene::{Degenerate, Scene};
    /// # let file = concat!(env!("CARGO_MANIFEST_DIR"), "/../../data/scenes/two_blocks.obj");
    /// let scene = Scene::read(file, Degenerate::Refuse)?;
    /// let sent = Scene::from_bytes(&scene.to_bytes()?)?;
    /// assert_eq!((sent.faces(), sent.materials()), (scene.faces(), scene.materials()));
    /// # Ok::<(), radgrad_scene::Error>(())
    /// ```
    ///
    /// # Errors
    /// If a name is not UTF-8.
    pub fn to_bytes(&self) -> Result<Vec<u8>, Error> {
        let (mut textures, mut files): (Vec<Arc<Texture>>, Vec<PathBuf>) = (Vec::new(), Vec::new());
        let mut materials = Vec::with_capacity(self.materials.len());
        for material in &self.materials {
            let used = Quantity::ALL.map(|quantity| {
                let texture = material.texture(quantity)?;
                Some(textures.iter().position(|known| Arc::ptr_eq(known, texture)).unwrap_or_else(|| {
                    textures.push(Arc::clone(texture));
                    textures.len() - 1
                }))
            });
            let (reflectance, radiance) = (material.reflectance().to_vec(), material.factors(Quantity::Radiance).to_vec());
            materials.push(MaterialRecord { name: material.name().to_owned(), reflectance, radiance, textures: used });
        }
        let mut faces = Vec::with_capacity(self.faces.len());
        for face in &self.faces {
            let place = face.place().map(|place| {
                // Neighbours are mostly of one file.
                let index = files.iter().rposition(|file| file == place.file());
                let file = index.unwrap_or_else(|| {
                    files.push(place.file().to_owned());
                    files.len() - 1
                });
                (file, place.position().clone())
            });
            faces.push(FaceRecord {
                vertices: face.polygon.vertices().iter().map(DVec3::to_array).collect(),
                precision: face.polygon.precision(),
                moved: face.moved,
                surface: face.surface,
                material: face.material,
                place,
                charts: face.charts.map(|chart| chart.map(Chart::numbers)),
            });
        }
        let texture = |texture: &Arc<Texture>| TextureRecord {
            name: texture.name().to_owned(),
            size: texture.size(),
            channels: texture.channels(),
            wrap: texture.wrap(),
            texels: texture.texels().to_vec(),
        };
        let record = SceneRecord {
            title: self.title.clone(),
            enclosure: self.enclosure,
            channels: self.channels.clone(),
            textures: textures.iter().map(texture).collect(),
            materials,
            surfaces: self.surfaces.iter().map(|surface| (surface.name.clone(), surface.exchanges)).collect(),
            files,
            faces,
            modelling: [self.modelling.precision, self.modelling.distance, self.modelling.share],
        };
        Ok(serde_json::to_vec(&record)?)
    }

    /// The scene that was made into bytes.
    ///
    /// # Errors
    /// If the bytes are no scene.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, Error> {
        let record: SceneRecord = serde_json::from_slice(bytes)?;
        let mut scene = Self::new(record.channels)?;
        (scene.title, scene.enclosure) = (record.title, record.enclosure);
        let [precision, distance, share] = record.modelling;
        scene.modelling = Modelling { precision, distance, share };
        let texture = |record: TextureRecord| -> Result<Arc<Texture>, Error> {
            Ok(Arc::new(Texture::new(record.name, record.size, record.channels, record.texels)?.wrapped(record.wrap)))
        };
        let textures = record.textures.into_iter().map(texture).collect::<Result<Vec<_>, _>>()?;
        let missing = |what: &'static str, index: usize| Error::expected(format!("a {what} that is there"), index.to_string());
        for material in record.materials {
            let index = scene.add_material(material.name, material.reflectance, material.radiance)?;
            for (quantity, used) in Quantity::ALL.into_iter().zip(material.textures) {
                if let Some(used) = used {
                    let texture = textures.get(used).ok_or_else(|| missing("texture", used))?;
                    scene.set_texture(index, quantity, Arc::clone(texture))?;
                }
            }
        }
        for (name, exchanges) in record.surfaces {
            if exchanges {
                scene.add_surface(name)
            } else {
                scene.add_obstruction(name)
            };
        }
        let files: Vec<Arc<std::path::Path>> = record.files.into_iter().map(Into::into).collect();
        for face in record.faces {
            let place = match face.place {
                Some((file, position)) => Some(Place::in_file(files.get(file).ok_or_else(|| missing("file", file))?, position)),
                None => None,
            };
            let vertices = face.vertices.into_iter().map(DVec3::from).collect();
            let polygon = Polygon::from_rounded(vertices, face.precision).map_err(Error::Face)?;
            let charts = face.charts.map(|numbers| numbers.map(Chart::from_numbers));
            let index = scene.add_charted_face(face.surface, face.material, polygon, place, charts)?;
            scene.faces[index].moved = face.moved;
        }
        Ok(scene)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_textured_scene_comes_back_whole_and_what_is_none_is_refused() {
        let mut scene = Scene::new(["r", "g"]).unwrap();
        let tiles = scene.add_material("tiles", [0.5, 0.25], [0.1, 0.0]).unwrap();
        let board = Texture::from_fn("board", [3, 2], 2, |column, row| vec![column as f64 / 3.0, row as f64 * 0.1]).unwrap();
        scene.set_texture(tiles, Quantity::Reflectance, board.wrapped([Wrap::Mirror, Wrap::Clamp])).unwrap();
        let (floor, screen) = (scene.add_surface("floor"), scene.add_obstruction("screen"));
        let square = [(0.1, 0.0), (2.0, 0.0), (2.0, 2.0 / 3.0), (0.1, 2.0 / 3.0)];
        let polygon = |z: f64| Polygon::new(square.map(|(x, y)| DVec3::new(x, y, z)).to_vec()).unwrap();
        scene.add_textured_face(floor, tiles, polygon(0.3), &square.map(|(x, y)| [0.7 * x + 0.1, y]), None).unwrap();
        let place = Place::new("room.obj", Position::Line(7));
        scene.add_face(screen, tiles, polygon(1.0), Some(place)).unwrap();
        scene.cap_reflectance(0.1);
        let bytes = scene.to_bytes().unwrap();
        let sent = Scene::from_bytes(&bytes).unwrap();
        assert_eq!((sent.faces(), sent.surfaces()), (scene.faces(), scene.surfaces()));
        assert_eq!((sent.materials(), sent.channels()), (scene.materials(), scene.channels()));
        assert_eq!(sent.to_bytes().unwrap(), bytes);
        let text = String::from_utf8(bytes).unwrap();
        for (good, bad) in [
            ("\"material\":0", "\"material\":3"),
            ("\"surface\":0", "\"surface\":9"),
            ("\"textures\":[0", "\"textures\":[7"),
            ("0.25", "1.25"),
        ] {
            assert!(text.contains(good), "{good} is not in {text}");
            assert!(Scene::from_bytes(text.replacen(good, bad, 1).as_bytes()).is_err(), "{bad}");
        }
        assert!(Scene::from_bytes(b"[]").is_err());
    }
}
