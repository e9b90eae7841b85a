//! The part of an emitter's triangle that an occluder hides: a convex cone from the receiver.
//!
//! A direction w is hidden by a convex polygon in the plane `M.y = K > 0` from a triangle in the plane `N.y = -H < 0` if it is
//! inside the planes through the receiver and its sides, and if it meets the polygon first: `K / M.w < -H / N.w`, that is
//! `(H M + K N).w > 0`, a plane through the receiver and the line in which the two planes meet. Opaque from both sides; an
//! occluder in the plane of the receiver or of the triangle hides nothing, as only the open segment between the two counts.

use crate::enclosure::cone::{Cone, Corner, Direction, Planes};
use crate::enclosure::exact::{Exact, ExactVector, cross, difference, dot};
use crate::enclosure::surface::{Body, Frame, Triangle};
use crate::enclosure::triangulation::triangles;

/// A convex polygon of an occluder in the receiver's coordinates.
#[derive(Debug)]
pub(crate) struct Occluder {
    /// `M` and `K > 0`.
    normal: ExactVector,
    offset: Exact,
    corners: Vec<Direction>,
    /// Planes through its sides, by their number; their normals point inward.
    sides: Vec<usize>,
}

/// The line that generates a plane through the receiver.
#[derive(Debug)]
pub(crate) enum Generator {
    /// An edge of the emitter, by its vertices in ascending order.
    Edge([usize; 2]),
    /// The receiver's horizon.
    Horizon,
    /// An edge of an occluder, by m and k: on its plane, `m.y = k` for the points of the edge's line.
    Occluder(Box<(ExactVector, Exact)>),
    /// Where an occluder meets the emitter's plane.
    Waterline,
}

/// The convex polygons of an occluder: itself where it is exactly planar and convex, otherwise the triangles that ear clipping
/// gives. Those in a plane with the receiver are left out.
pub(crate) fn occluders(frame: &Frame, body: &Body<'_>, planes: &mut Planes, generators: &mut Vec<Generator>) -> Vec<Occluder> {
    let vertices: Vec<ExactVector> = body.vertices.iter().map(|vertex| frame.relative(vertex)).collect();
    let parts = triangles(body.polygon);
    let whole: Vec<usize> = (0..vertices.len()).collect();
    let is_whole = parts.first().is_some_and(|first| is_flat_and_convex(&vertices, *first));
    let parts: Vec<Vec<usize>> = if is_whole { vec![whole] } else { parts.iter().map(|t| t.to_vec()).collect() };
    parts.iter().filter_map(|part| Occluder::new(part.iter().map(|i| &vertices[*i]).collect(), planes, generators)).collect()
}

/// Whether the vertices are in the plane of the three given ones, and turn one way or go straight on.
fn is_flat_and_convex(vertices: &[ExactVector], [a, b, c]: [usize; 3]) -> bool {
    let way = |from: usize, to: usize| difference(&vertices[to], &vertices[from]);
    let (normal, count) = (cross(&way(a, b), &way(a, c)), vertices.len());
    let is_flat = || (0..count).all(|i| dot(&normal, &way(a, i)).is_zero());
    // A simple polygon that never turns right is convex.
    let turn = |i: usize| dot(&normal, &cross(&way(i, (i + 1) % count), &way((i + 1) % count, (i + 2) % count))).sign();
    is_flat() && (0..count).all(|i| turn(i) >= 0)
}

impl Occluder {
    fn new(mut vertices: Vec<&ExactVector>, planes: &mut Planes, generators: &mut Vec<Generator>) -> Option<Self> {
        let count = vertices.len();
        let normals = (0..count).map(|i| {
            let [a, b, c] = [i, i + 1, i + 2].map(|k| vertices[k % count]);
            cross(&difference(b, a), &difference(c, a))
        });
        let mut normal = normals.into_iter().find(|n| n.iter().any(|c| !c.is_zero()))?;
        let mut offset = dot(&normal, vertices[0]);
        match offset.sign() {
            0 => return None,
            -1 => (normal, offset) = (normal.each_ref().map(|c| -c), -&offset),
            _ => vertices.reverse(),
        }
        // Counter-clockwise for the receiver, whence `b x a` points inward.
        let corners = vertices.iter().map(|v| Direction::new(v)).collect::<Option<_>>()?;
        let mut sides = Vec::with_capacity(count);
        for i in 0..count {
            let (a, b) = (vertices[i], vertices[(i + 1) % count]);
            let inward = cross(b, a);
            let e = difference(b, a);
            let m = cross(&e, &cross(a, &e));
            let k = dot(&m, a);
            sides.push(planes.len());
            planes.push(Direction::new(&inward)?);
            generators.push(Generator::Occluder(Box::new((m, k))));
        }
        Some(Self { normal, offset, corners, sides })
    }

    /// The planes whose inner sides together are hidden from a triangle; none where nothing can be.
    pub(crate) fn shadow(&self, triangle: &Triangle, planes: &mut Planes, generators: &mut Vec<Generator>) -> Option<Vec<usize>> {
        let term = |i: usize| &(&triangle.height * &self.normal[i]) + &(&self.offset * &triangle.normal[i]);
        let nearer = Direction::new(&[term(0), term(1), term(2)])?;
        let signs: Vec<i32> = self.corners.iter().map(|corner| nearer.side(corner)).collect();
        if signs.iter().all(|s| *s <= 0) {
            return None;
        }
        let mut shadow = self.sides.clone();
        if signs.iter().any(|s| *s < 0) {
            shadow.push(planes.len());
            planes.push(nearer);
            generators.push(Generator::Waterline);
        }
        Some(shadow)
    }

    /// Replaces each cone by its parts outside a shadow; whether any was not outside as a whole.
    pub(crate) fn hide(&self, cones: &mut Vec<Cone>, shadow: &[usize], planes: &Planes, facing: &Direction) -> bool {
        let mut lit = Vec::with_capacity(cones.len());
        let mut hides = false;
        for cone in cones.drain(..) {
            match self.outside(&cone, shadow, planes, facing) {
                Some(parts) => {
                    hides = true;
                    lit.extend(parts);
                }
                None => lit.push(cone),
            }
        }
        *cones = lit;
        hides
    }

    /// The parts of a cone outside a shadow; none if that is all of it.
    fn outside(&self, cone: &Cone, shadow: &[usize], planes: &Planes, facing: &Direction) -> Option<Vec<Cone>> {
        let has_shadow_outside = |side: &Corner| {
            let inward = if side.inward { 1 } else { -1 };
            self.corners.iter().all(|own| planes[side.plane].side(own) * inward <= 0)
        };
        if shadow.iter().any(|plane| cone.is_beyond(&planes[*plane])) || cone.0.iter().any(has_shadow_outside) {
            return None;
        }
        let mut outside = Vec::new();
        let mut inside = cone.clone();
        for plane in shadow {
            outside.extend(inside.cut(planes, *plane, false, facing));
            inside = inside.cut(planes, *plane, true, facing)?;
        }
        Some(outside)
    }
}
