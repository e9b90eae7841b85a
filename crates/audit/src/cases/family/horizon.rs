//! Triangles that the receiver's horizon cuts.

use super::scene::{Scene, normal_where};
use super::spread;
use crate::cases::sampler::Sampler;

/// Some vertices well above the horizon, some well below.
pub(super) fn clipped(sampler: &mut Sampler) -> Scene {
    let mut scene = spread::at_sizes(sampler, -2, 2);
    // At 4 sizes a fat triangle still spans 1/20 of the view whichever way it is foreshortened.
    scene.normal = normal_where(sampler, scene.position, &scene.vertices, |low, high| low < -0.01 && high > 0.01);
    scene
}

/// One vertex, or the edge between two, looks over the horizon by 2^-40 to 2^-3 of its distance; the rest is well below.
pub(super) fn sliver(sampler: &mut Sampler) -> Scene {
    let with_an_edge = sampler.one_in(2);
    let height = sampler.spread(-40, -3);
    loop {
        let mut scene = spread::generic(sampler);
        let first = sampler.below(3) as usize;
        let [a, b, c] = [0, 1, 2].map(|k| (scene.vertices[(first + k) % 3] - scene.position).normalize());
        let mut level = if with_an_edge { a.cross(b).normalize() } else { sampler.perpendicular(a) };
        if level.dot(c) > 0.0 {
            level = -level;
        }
        let toward = if with_an_edge { (a + b) * 0.5 } else { a };
        scene.normal = level + toward * height;
        let below = |v| scene.normal.dot(v) < -0.05;
        if below(c) && (with_an_edge || below(b)) {
            return scene;
        }
    }
}
