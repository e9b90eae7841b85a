//! Closed parts of a scene whose faces reflect all light of a channel: light that is emitted in one is never lost, so that there
//! is no solution; and where none is emitted it is dark.
//!
//! A part is made up of faces that rays from each other meet. It is shown to be closed if all rays from it meet the fronts of its
//! own faces, if their areas, as vectors along the normals, sum to 0 (those of light through a hole would be missing), and if no
//! other face reaches into the box around it, where rays may have missed it. A part that is not shown to be closed is solved, and
//! refused if light does not settle.

use radgrad_core::DVec3;
use radgrad_scene::Scene;

use crate::error::Error;
use crate::mesh::Mesh;
use crate::mesh::element::around;
use crate::mesh::shape::Shape;
use crate::mesh::surfaces::Surfaces;

/// Rays from each of the coarsest elements, and those that would leave the disc below the hemisphere.
const RAYS: usize = 320;

/// Steps of an even sequence in four dimensions (M. Roberts 2018): powers of the inverse of the root of `x^5 = x + 1`.
const STEPS: [f64; 4] = [0.856_674_883_854_502_9, 0.733_891_856_627_126, 0.628_706_721_037_808_6, 0.538_597_257_223_61];

/// Rounding, relative to all area and to the size of a part.
const ROUNDING: f64 = 1e-9;

/// Refuses closed parts that are lit and reflect all light of a channel, and makes those that are dark black, which changes nothing: there, too,
/// light would be lost nowhere.
pub(super) fn settle(scene: &Scene, mesh: &Mesh, surfaces: &mut Surfaces) -> Result<(), Error> {
    for (channel, name) in scene.channels().iter().enumerate() {
        for part in closed_parts(mesh, |face| mesh.exchanges(face) && surfaces.is_white(face, channel)) {
            if part.iter().any(|&face| surfaces.emitted[face][channel] > 0.0) {
                let mut indices: Vec<usize> = part.iter().map(|&face| scene.faces()[face].surface()).collect();
                indices.sort_unstable();
                indices.dedup();
                let surfaces = indices.into_iter().map(|surface| scene.surfaces()[surface].name().to_owned()).collect();
                return Err(Error::Lossless { channel: name.clone(), surfaces });
            }
            part.into_iter().for_each(|face| surfaces.reflectance[face][channel] = 0.0);
        }
    }
    Ok(())
}

/// Parts of faces of a kind that are shown to be closed.
fn closed_parts(mesh: &Mesh, is_meant: impl Fn(usize) -> bool) -> Vec<Vec<usize>> {
    let count = mesh.polygons().len();
    let is_meant: Vec<bool> = (0..count).map(is_meant).collect();
    // Each face leads to another one of its part, the last one to itself.
    let mut next: Vec<usize> = (0..count).collect();
    let mut is_open: Vec<bool> = is_meant.iter().map(|is_meant| !is_meant).collect();
    for element in mesh.roots().iter().map(|&root| &mesh.elements()[root]) {
        let face = element.face();
        if is_open[face] {
            continue;
        }
        let normal = element.polygon().normal();
        let (across, along) = normal.any_orthonormal_pair();
        for index in 0..RAYS {
            let [s, t, x, y] = STEPS.map(|step| (0.5 + step * index as f64).fract());
            let place = if element.shape() == Shape::Triangle && s + t > 1.0 { [1.0 - s, 1.0 - t] } else { [s, t] };
            let [x, y] = [x, y].map(|place| 2.0 * place - 1.0);
            let square = x * x + y * y;
            if square >= 1.0 {
                continue;
            }
            let toward = across * x + along * y + normal * (1.0 - square).sqrt();
            match mesh.front_met(element.point(place), toward, &[face]) {
                Some((other, _)) if is_meant[other] => {
                    let [a, b] = [face, other].map(|face| last(&next, face));
                    next[a] = b;
                }
                _ => {
                    is_open[face] = true;
                    break;
                }
            }
        }
    }
    let mut parts = vec![Vec::new(); count];
    (0..count).filter(|&face| is_meant[face]).for_each(|face| parts[last(&next, face)].push(face));
    parts.retain(|part| !part.is_empty() && part.iter().all(|&face| !is_open[face]) && is_closed(mesh, part));
    parts
}

fn last(next: &[usize], mut face: usize) -> usize {
    while next[face] != face {
        face = next[face];
    }
    face
}

/// Whether a part that no ray leaves has no hole that areas tell of, and no other face within the box around it.
fn is_closed(mesh: &Mesh, part: &[usize]) -> bool {
    let polygon = |face: usize| &mesh.polygons()[face];
    let (sum, area) = part.iter().fold((DVec3::ZERO, 0.0), |(sum, area), &face| {
        (sum + polygon(face).normal() * polygon(face).area(), area + polygon(face).area())
    });
    let vertices: Vec<DVec3> = part.iter().flat_map(|&face| polygon(face).vertices()).copied().collect();
    let [low, high] = around(&vertices);
    let within = ROUNDING * (high - low).max_element();
    let is_inside = |v: &DVec3| v.cmpgt(low + within).all() && v.cmplt(high - within).all();
    let mut is_other = vec![true; mesh.polygons().len()];
    part.iter().for_each(|&face| is_other[face] = false);
    let mut others = (0..is_other.len()).filter(|face| is_other[*face]);
    sum.length() <= ROUNDING * area && !others.any(|face| polygon(face).vertices().iter().any(is_inside))
}
