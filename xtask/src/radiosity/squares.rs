//! Scenes of a few quadrilaterals, most of them two unit squares.

use std::error::Error;
use std::f64::consts::PI;

use radgrad_core::{DVec3, Polygon};
use radgrad_scene::Scene;

/// Four corners.
pub(super) type Quad = [[f64; 3]; 4];

pub(super) const FLOOR: Quad = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];

/// Meets the floor in the edge x = 0.
pub(super) const WALL: Quad = [[0.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 1.0, 1.0], [0.0, 0.0, 1.0]];

pub(super) const fn ceiling(gap: f64) -> Quad {
    [[0.0, 0.0, gap], [0.0, 1.0, gap], [1.0, 1.0, gap], [1.0, 0.0, gap]]
}

/// A scene of one channel: each face with its reflectance and the radiosity that it emits.
pub(super) fn scene(faces: &[(Quad, f64, f64)]) -> Result<Scene, Box<dyn Error>> {
    let mut scene = Scene::new(["grey"])?;
    for (index, (corners, reflectance, emitted)) in faces.iter().enumerate() {
        let material = scene.add_material(index.to_string(), [*reflectance], [emitted / PI])?;
        let surface = scene.add_surface(index.to_string());
        scene.add_face(surface, material, Polygon::new(corners.map(DVec3::from).to_vec())?, None)?;
    }
    Ok(scene)
}
