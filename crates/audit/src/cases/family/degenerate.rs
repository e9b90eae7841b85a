//! Cases without light, and polygons that are none.

use glam::DVec3;
use radgrad_scene::case::EmissionRecord;

use super::many_sided;
use super::near;
use super::scene::{Scene, normal_where};
use super::spread;
use crate::cases::sampler::Sampler;

/// One of the lit families, turned over.
pub(super) fn back_facing(sampler: &mut Sampler) -> Scene {
    in_front(sampler).reversed()
}

/// One of the lit families, with a normal that puts all of the emitter below the horizon.
pub(super) fn below_horizon(sampler: &mut Sampler) -> Scene {
    loop {
        let mut scene = in_front(sampler);
        // From close above the inside no normal has all below; a dozen tries tell.
        for _ in 0..12 {
            let normal = normal_where(sampler, scene.position, &scene.vertices, |_, _| true);
            let highest = scene.vertices.iter().map(|v| normal.dot(*v - scene.position)).fold(f64::NEG_INFINITY, f64::max);
            if highest < -1e-9 {
                scene.normal = normal;
                return scene;
            }
        }
    }
}

/// On the lit side: those families whose height over the emitter is well above rounding.
fn in_front(sampler: &mut Sampler) -> Scene {
    loop {
        let scene = match sampler.below(7) {
            0 => spread::far(sampler),
            1 => near::contact(sampler),
            2 => near::edge(sampler),
            3 => near::grazing(sampler),
            4 => many_sided::concave(sampler),
            _ => spread::generic(sampler),
        };
        let [a, b, c] = [0, 1, 2].map(|k| scene.vertices[k]);
        let height = (b - a).cross(c - a).normalize().dot(scene.position - a);
        if scene.vertices.len() > 3 || height > 1e-13 {
            return scene;
        }
    }
}

/// A vertex twice in a row, first and last equal, a vertex met again later, or all on one line.
pub(super) fn equal_vertices(sampler: &mut Sampler) -> Scene {
    let mut scene = many_sided::convex(sampler);
    let count = u32::try_from(scene.vertices.len()).unwrap_or(3);
    let index = sampler.below(count) as usize;
    let repeated = scene.vertices[index];
    match sampler.below(4) {
        0 => scene.vertices.insert(index, repeated),
        1 => scene.vertices.push(scene.vertices[0]),
        2 => {
            let later = (index + 2 + sampler.below(count - 2) as usize) % scene.vertices.len();
            scene.vertices.insert(later, repeated);
        }
        _ => {
            let along = DVec3::new(1.0, 0.0, 0.0);
            scene.vertices = scene.vertices.iter().map(|v| along * v.x).collect();
        }
    }
    // The polygon alone is to blame.
    scene.emission = EmissionRecord::Constant { constant: 1.0 };
    scene
}
