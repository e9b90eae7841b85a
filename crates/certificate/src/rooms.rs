//! Rooms whose light is known, for tests.

use radgrad_core::{DVec3, Polygon};
use radgrad_scene::{Quantity, Scene, Texture};

/// A room in which the radiosity is 1 everywhere.
pub(crate) struct Room {
    pub(crate) scene: Scene,
    /// The mean reflected radiosity.
    pub(crate) reflected: f64,
    /// A point of its floor, which is face 0 and faces up.
    pub(crate) point: DVec3,
}

fn parallelogram(corner: [f64; 3], along: [f64; 3], up: [f64; 3]) -> Polygon {
    let [corner, along, up] = [corner, along, up].map(DVec3::from);
    Polygon::new(vec![corner, corner + along, corner + along + up, corner + up]).expect("a parallelogram")
}

fn box_of([x, y, z]: [f64; 3]) -> [Polygon; 6] {
    [
        parallelogram([0.0; 3], [x, 0.0, 0.0], [0.0, y, 0.0]),
        parallelogram([0.0, 0.0, z], [0.0, y, 0.0], [x, 0.0, 0.0]),
        parallelogram([0.0; 3], [0.0, 0.0, z], [x, 0.0, 0.0]),
        parallelogram([0.0, y, 0.0], [x, 0.0, 0.0], [0.0, 0.0, z]),
        parallelogram([0.0; 3], [0.0, y, 0.0], [0.0, 0.0, z]),
        parallelogram([x, 0.0, 0.0], [0.0, 0.0, z], [0.0, y, 0.0]),
    ]
}

/// Faces with their reflectances and emissions, by a texture of one texel if that is asked.
fn scene(faces: impl IntoIterator<Item = (Polygon, f64, f64)>, is_textured: bool) -> Scene {
    let mut scene = Scene::new(["grey"]).expect("a channel");
    for (index, (polygon, reflectance, emitted)) in faces.into_iter().enumerate() {
        let radiance = emitted / std::f64::consts::PI;
        let material = scene.add_material(format!("m{index}"), [reflectance], [radiance]).expect("in range");
        let surface = scene.add_surface(format!("s{index}"));
        if is_textured {
            let even = Texture::new("even", [1, 1], 1, vec![1.0]).expect("a texel");
            scene.set_texture(material, Quantity::Radiance, even).expect("a material");
            let corners = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
            scene.add_textured_face(surface, material, polygon, &corners, None).expect("a face");
        } else {
            scene.add_face(surface, material, polygon, None).expect("a face");
        }
    }
    scene
}

fn even(faces: Vec<(Polygon, f64)>, is_textured: bool) -> Room {
    let area: f64 = faces.iter().map(|(polygon, _)| polygon.area()).sum();
    let reflected: f64 = faces.iter().map(|(polygon, rho)| polygon.area() * rho).sum();
    let scene = scene(faces.into_iter().map(|(polygon, rho)| (polygon, rho, 1.0 - rho)), is_textured);
    Room { scene, reflected: reflected / area, point: DVec3::new(0.3, 0.2, 0.0) }
}

/// A box with a plate of two sides in it, which hides parts of it.
pub(crate) fn furnace(reflectances: [f64; 8], is_textured: bool) -> Room {
    let (along, up) = ([0.6, 0.3, 0.1], [-0.2, 0.5, 0.4]);
    let plate = [parallelogram([0.8, 0.5, 0.4], along, up), parallelogram([0.8, 0.5, 0.4], up, along)];
    even(box_of([2.0, 1.5, 1.0]).into_iter().chain(plate).zip(reflectances).collect(), is_textured)
}

/// A cube of one reflectance.
pub(crate) fn cube(rho: f64) -> Room {
    even(box_of([1.0; 3]).into_iter().map(|polygon| (polygon, rho)).collect(), false)
}

/// A square floor of reflectance 0.9 under a lamp of a fifth of its size that emits 1, as high as it is long.
pub(crate) fn lamp_over_a_floor() -> Scene {
    let floor = parallelogram([0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]);
    let lamp = parallelogram([0.4, 0.4, 1.0], [0.0, 0.2, 0.0], [0.2, 0.0, 0.0]);
    scene([(floor, 0.9, 0.0), (lamp, 0.0, 1.0)], false)
}

/// Unit squares, a floor and a lamp over it, and at half the height an upward black plate between these ends along x and along y.
pub(crate) fn plate_under_a_lamp(x: [f64; 2], y: [f64; 2]) -> Scene {
    let floor = parallelogram([0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]);
    let lamp = parallelogram([0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0]);
    let plate = parallelogram([x[0], y[0], 0.5], [x[1] - x[0], 0.0, 0.0], [0.0, y[1] - y[0], 0.0]);
    scene([(floor, 0.9, 0.0), (lamp, 0.0, 1.0), (plate, 0.0, 0.0)], false)
}
