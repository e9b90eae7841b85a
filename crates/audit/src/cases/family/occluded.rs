//! Emitters behind opaque polygons, from one to a thousand, each family around one way for a shadow to be hard to find.

use glam::DVec3;

use super::frame::{Triangle, inside};
use super::scene::Scene;
use super::spread;
use crate::cases::sampler::Sampler;

/// One triangle that surely hides a part and leaves one: its middle is on the way to a point of the inside.
pub(super) fn one_screen(sampler: &mut Sampler) -> Scene {
    let mut scene = spread::generic(sampler);
    let screen = on_the_way(sampler, &scene, 0.2, 0.8, 0.3);
    scene.occluders.push(screen);
    scene
}

/// Ten of them, overlapping as seen from the receiver, at all distances between.
pub(super) fn ten_screens(sampler: &mut Sampler) -> Scene {
    let mut scene = spread::generic(sampler);
    scene.occluders = (0..10).map(|_| on_the_way(sampler, &scene, 0.1, 0.9, 0.15)).collect();
    scene
}

/// A screen with an edge seen along an edge of the emitter, off it by 2^-40 to 2^-3 of its length to either side, or exactly in
/// line as far as rounding allows; it hides a sliver or all but one.
pub(super) fn silhouette_screen(sampler: &mut Sampler) -> Scene {
    let mut scene = spread::generic(sampler);
    let x = scene.position;
    let first = sampler.below(3) as usize;
    let [a, b, c] = [0, 1, 2].map(|k| scene.vertices[(first + k) % 3]);
    let shift = (c - (a + b) * 0.5) * (sampler.sign() * sampler.spread(-40, -3));
    let (near, far) = (sampler.between(0.2, 0.5), sampler.between(0.5, 0.8));
    let [from, to] = [(a + (a - b) * 0.2 + shift, near), (b + (b - a) * 0.2 + shift, far)].map(|(v, k)| x + (v - x) * k);
    let aside = if sampler.one_in(2) { (a + b) * 0.5 - c } else { c - (a + b) * 0.5 };
    scene.occluders.push(vec![from, to, (from + to) * 0.5 + aside * sampler.between(0.5, 2.0)]);
    scene
}

/// A screen that stands on an edge of the emitter and leans over it or away, to the receiver's side or beyond its plane.
pub(super) fn edge_screen(sampler: &mut Sampler) -> Scene {
    let mut scene = spread::generic(sampler);
    let first = sampler.below(3) as usize;
    let [a, b, c] = [0, 1, 2].map(|k| scene.vertices[(first + k) % 3]);
    let foot = inside(sampler, [a, b, c]);
    let lean = (foot - (a + b) * 0.5) * sampler.between(-1.0, 2.0);
    let rise = (scene.position - foot) * sampler.spread(-6, -1);
    scene.occluders.push(vec![a, b, (a + b) * 0.5 + lean + rise]);
    scene
}

/// A screen with a corner in the emitter's plane as far as rounding allows, or 2^-52 to 2^-30 before it or behind; half of them stand
/// on a vertex of the emitter.
pub(super) fn dipping_screen(sampler: &mut Sampler) -> Scene {
    let mut scene = spread::generic(sampler);
    let [a, b, c] = [0, 1, 2].map(|k| scene.vertices[k]);
    let foot = if sampler.one_in(2) { a } else { inside(sampler, [a, b, c]) };
    let way = (scene.position - foot) * sampler.between(0.1, 0.5);
    let offset = if sampler.one_in(2) { 0.0 } else { sampler.sign() * sampler.spread(-52, -30) };
    let aside = way.length();
    let mut over = || foot + way + sampler.direction() * (0.7 * aside);
    scene.occluders.push(vec![foot + way * offset, over(), over()]);
    scene
}

/// A screen 2^-24 to 2^-8 of the way from the receiver, and as much smaller.
pub(super) fn near_screen(sampler: &mut Sampler) -> Scene {
    let mut scene = spread::generic(sampler);
    let share = sampler.spread(-24, -8);
    let screen = on_the_way(sampler, &scene, share, share * 1.0625, 0.3);
    scene.occluders.push(screen);
    scene
}

/// Screens that hide nothing: behind the receiver, behind the emitter, in its plane, touching the receiver's side of neither.
pub(super) fn idle_screens(sampler: &mut Sampler) -> Scene {
    let mut scene = spread::generic(sampler);
    let x = scene.position;
    let middle = (scene.vertices[0] + scene.vertices[1] + scene.vertices[2]) / 3.0;
    let behind = [sampler.between(-2.0, -0.5), sampler.between(1.5, 3.0)];
    for place in behind {
        let turn = sampler.between(0.5, 1.0);
        let corner = |v: &DVec3| x + (middle + (*v - middle) * turn - x) * place;
        let screen = scene.vertices.iter().map(corner).collect();
        scene.occluders.push(screen);
    }
    scene.occluders.push(scene.vertices.clone());
    scene
}

/// A closed box of twelve triangles around all, the emitter on its floor or before it, and a smaller box in the way.
pub(super) fn boxes(sampler: &mut Sampler) -> Scene {
    let mut scene = spread::at_sizes(sampler, -1, 1);
    let x = scene.position;
    let around = scene.vertices.iter().fold([x, x], |[low, high], v| [low.min(*v), high.max(*v)]);
    let margin = DVec3::splat(0.25);
    scene.occluders.extend(faces([around[0] - margin, around[1] + margin]));
    let middle = x + (inside(sampler, [0, 1, 2].map(|k| scene.vertices[k])) - x) * sampler.between(0.3, 0.6);
    let half = DVec3::splat((middle - x).length() * sampler.between(0.05, 0.15));
    scene.occluders.extend(faces([middle - half, middle + half]));
    scene
}

/// Two dozen small triangles anywhere between, most of them in the way.
pub(super) fn thicket(sampler: &mut Sampler) -> Scene {
    let mut scene = spread::at_sizes(sampler, 0, 2);
    scene.occluders = (0..24).map(|_| on_the_way(sampler, &scene, 0.2, 0.9, 0.06)).collect();
    scene
}

/// A thousand, each of which hides some of the emitter or is hidden by others.
pub(super) fn thousand_triangles(sampler: &mut Sampler) -> Scene {
    let mut scene = spread::at_sizes(sampler, 0, 2);
    scene.occluders = (0..1000).map(|_| on_the_way(sampler, &scene, 0.2, 0.9, 0.02)).collect();
    scene
}

/// A triangle around a point on the way to a point of the inside, at a share of it between two; its size is so much of the
/// emitter's size as seen there. On the receiver's side of the emitter's plane.
pub(super) fn on_the_way(sampler: &mut Sampler, scene: &Scene, low: f64, high: f64, size: f64) -> Vec<DVec3> {
    let corners = [0, 1, 2].map(|k| scene.vertices[k]);
    let share = sampler.between(low, high);
    let middle = scene.position + (inside(sampler, corners) - scene.position) * share;
    let longest = (0..3).map(|k| (corners[(k + 1) % 3] - corners[k]).length()).fold(0.0, f64::max);
    let triangle = Triangle::random(sampler);
    let scale = size * share * longest / triangle.longest;
    let centroid = triangle.centroid();
    triangle.vertices.iter().map(|v| middle + (*v - centroid) * scale).collect()
}

/// The triangles of a box.
fn faces([low, high]: [DVec3; 2]) -> impl Iterator<Item = Vec<DVec3>> {
    let corner = move |axis: usize, side: usize, u: usize, v: usize| {
        let mut corner = [low, high][side];
        corner[(axis + 1) % 3] = [low, high][u][(axis + 1) % 3];
        corner[(axis + 2) % 3] = [low, high][v][(axis + 2) % 3];
        corner
    };
    let rectangles = (0..3)
        .flat_map(move |axis| (0..2).map(move |side| [[0, 0], [1, 0], [1, 1], [0, 1]].map(|[u, v]| corner(axis, side, u, v))));
    rectangles.flat_map(|[a, b, c, d]| [vec![a, b, c], vec![a, c, d]])
}
