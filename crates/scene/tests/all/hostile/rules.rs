//! Rules for each result of a reader, whatever the file: for the tests of files that were changed at random, and for the fuzz
//! targets.

use std::io;
use std::path::Path;

use radgrad_scene::{Degenerate, Error, Materials, Reading, Scene};

/// The materials beside the OBJ file that is the seed.
pub(crate) const MTL: &str = include_str!("../../../../../fuzz/seeds/mtl/room.mtl");

/// Checks a scene, or the error in its place.
pub(crate) fn judge(read: impl Fn(Reading) -> Result<Scene, Error>) {
    let reading = |degenerate| Reading { degenerate, budget: 1 << 22, materials: Materials::Optional, ..Reading::default() };
    let refused = read(reading(Degenerate::Refuse));
    let dropped = read(reading(Degenerate::Drop));
    assert!(refused.is_err() || dropped.is_ok(), "{dropped:?}");
    for result in [refused, dropped] {
        match result {
            Ok(scene) => {
                for face in scene.faces() {
                    assert!(face.polygon().area() >= 0.0 && face.polygon().vertices().iter().all(|v| v.is_finite()));
                    let material = &scene.materials()[face.material()];
                    assert!(material.reflectance().iter().all(|rho| (0.0..=1.0).contains(rho)));
                    assert!(material.radiance().iter().all(|radiance| (0.0..f64::INFINITY).contains(radiance)));
                }
                assert!(scene.notes().iter().all(|note| is_shown(&note.to_string())), "{:?}", scene.notes());
            }
            Err(error) => assert!(is_shown(&error.to_string()), "{error}"),
        }
    }
}

/// Whether a terminal shows all of a text.
pub(crate) fn is_shown(text: &str) -> bool {
    !text.contains(char::is_control)
}

pub(crate) fn png() -> Vec<u8> {
    let mut file = Vec::new();
    let mut encoder = png::Encoder::new(&mut file, 3, 2);
    encoder.set_color(png::ColorType::Rgb);
    encoder.write_header().unwrap().write_image_data(&[9; 18]).unwrap();
    file
}

/// The files beside a scene.
pub(crate) fn beside<'a>(library: &'a [u8], texture: &'a [u8]) -> impl Fn(&Path) -> io::Result<Vec<u8>> + 'a {
    move |name| match name.to_str() {
        Some("m.mtl") => Ok(library.to_vec()),
        Some("t.png") => Ok(texture.to_vec()),
        _ => Err(io::ErrorKind::NotFound.into()),
    }
}
