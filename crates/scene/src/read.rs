//! A scene from a file, by the reader of its format.

use std::path::Path;

use crate::error::Error;
use crate::output::extension;
use crate::reading::Reading;
use crate::scene::Scene;
use crate::{gltf, obj, ply, stl, view3d};

impl Scene {
    /// Reads a scene, as a [`Reading`] says or a [`crate::Degenerate`] alone: `.obj` with its `.mtl` ([`crate::obj`]), `.gltf` or `.glb`
    /// ([`crate::gltf`]), `.vs3` of `View3D` ([`crate::view3d`]), `.stl` ([`crate::stl`]) and `.ply` ([`crate::ply`]).
    ///
    /// ```
    /// use radgrad_scene::{Degenerate, Scene};
    /// # let file = concat!(env!("CARGO_MANIFEST_DIR"), "/../../data/scenes/cornell.obj");
    /// let scene = Scene::read(file, Degenerate::Refuse)?;
    /// let light = scene.surface_named("light")?;
    /// println!("{} faces, light {} mm2", scene.faces().len(), scene.area_of(light));
    /// for note in scene.notes() {
    ///     println!("{note}"); // cornell.obj:..: `left` is 3.2 off its plane ...
    /// }
    /// # assert_eq!(scene.notes().len(), 1);
    /// # Ok::<(), radgrad_scene::Error>(())
    /// ```
    ///
    /// # Errors
    /// If a file cannot be read or its format is unknown, with the file; if it breaks its format, with file, line and the expected
    /// value. Nothing is half-loaded.
    pub fn read(file: impl AsRef<Path>, reading: impl Into<Reading>) -> Result<Self, Error> {
        let (file, reading) = (file.as_ref(), reading.into());
        match extension(file).as_str() {
            "obj" => obj::read(file, reading),
            "gltf" | "glb" => gltf::read(file, reading),
            "vs3" => view3d::read(file, reading),
            "stl" => stl::read(file, reading),
            "ply" => ply::read(file, reading),
            _ => Err(Error::Format { file: file.to_owned() }),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::reading::Degenerate;

    #[test]
    fn a_file_of_another_format_is_refused_by_its_name() {
        let error = Scene::read("room.skp", Degenerate::Refuse).unwrap_err();
        assert_eq!(error, Error::Format { file: "room.skp".into() });
        let error = Scene::read("no-such-directory/room.OBJ", Degenerate::Refuse).unwrap_err().to_string();
        assert!(error.starts_with("`no-such-directory/room.OBJ` cannot be read: "), "{error}");
    }
}
