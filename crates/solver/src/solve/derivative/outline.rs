//! Edges of faces as borders of sight, and the planes of faces as their vertices move them.
//!
//! A face stays flat, so that it moves out of its plane by an affine function of the place: that of the vertices' heights, by least squares.
//! Within its plane nothing moves but its edges, since the light goes on smoothly beyond them.

use radgrad_core::{DVec3, Polygon};
use radgrad_scene::{Boxes, largest, smallest};

use crate::mesh::Mesh;
use crate::mesh::element::around;

/// Distances up to which edges lie on one line, or a face touches an edge, over the extent of the scene.
const JOINED: f64 = 4e-7;

/// The plane of a face as its vertices move it.
pub(super) struct Plane {
    pub(super) normal: DVec3,
    middle: DVec3,
    /// The slope of each vertex's part in the height.
    slopes: Vec<DVec3>,
}

/// An edge of a face.
pub(super) struct Edge {
    pub(super) face: usize,
    /// Its vertices, numbered within the face.
    pub(super) ends: [usize; 2],
    pub(super) from: DVec3,
    pub(super) direction: DVec3,
    pub(super) length: f64,
    /// Edges on the same line: their faces, and the parts of this one that they go along.
    beside: Vec<(usize, [f64; 2])>,
    /// Faces in whose planes it lies.
    level_with: Vec<usize>,
}

/// The faces at a place of an edge.
pub(super) struct Joint {
    /// Those that have an edge there, the edge's own first.
    pub(super) faces: Vec<usize>,
    /// Those that it lies on.
    pub(super) touched: Vec<usize>,
}

impl Plane {
    pub(super) fn from_polygon(polygon: &Polygon) -> Self {
        let (corners, normal) = (polygon.vertices(), polygon.normal());
        let middle = corners.iter().sum::<DVec3>() / corners.len() as f64;
        let (u, v) = normal.any_orthonormal_pair();
        let arms: Vec<[f64; 2]> = corners.iter().map(|corner| [u, v].map(|axis| (*corner - middle).dot(axis))).collect();
        let moment = |a: usize, b: usize| arms.iter().map(|arm| arm[a] * arm[b]).sum::<f64>();
        let (uu, uv, vv) = (moment(0, 0), moment(0, 1), moment(1, 1));
        // A polygon has area, so that its corners are not on a line.
        let determinant = uu * vv - uv * uv;
        let slope = |[a, b]: &[f64; 2]| (u * (vv * a - uv * b) + v * (uu * b - uv * a)) / determinant;
        Self { normal, middle, slopes: arms.iter().map(slope).collect() }
    }

    /// The slope of each vertex's part in the height.
    pub(super) fn slopes(&self) -> &[DVec3] {
        &self.slopes
    }

    /// The part of each vertex's height in that of a place, and the slope of that.
    pub(super) fn parts(&self, place: DVec3) -> impl Iterator<Item = (f64, DVec3)> {
        let even = 1.0 / self.slopes.len() as f64;
        self.slopes.iter().map(move |slope| (even + slope.dot(place - self.middle), *slope))
    }
}

impl Edge {
    /// All edges of a mesh.
    pub(super) fn of_mesh(mesh: &Mesh, extent: f64) -> Vec<Self> {
        let reach = JOINED * extent;
        let mut edges: Vec<Self> =
            mesh.polygons().iter().enumerate().flat_map(|(face, polygon)| Self::of_face(face, polygon)).collect();
        let boxes: Vec<[DVec3; 2]> = edges.iter().map(|edge| around(&[edge.from, edge.place(1.0)])).collect();
        let index = Boxes::new(&boxes);
        let joined = |(own, edge): (usize, &Self)| {
            let [low, high] = boxes[own];
            let near = index.near([low - reach, high + reach]).into_iter().filter(|&other| other != own);
            let beside = near.filter_map(|other| Some((edges[other].face, edge.common(&edges[other], reach)?))).collect();
            (beside, mesh.faces_near(low.midpoint(high), 0.5 * (high - low).length() + reach))
        };
        let joined: Vec<_> = edges.iter().enumerate().map(joined).collect();
        for (edge, (beside, near)) in edges.iter_mut().zip(joined) {
            let is_level = |face: &usize| {
                let polygon = &mesh.polygons()[*face];
                let height = |place: DVec3| polygon.normal().dot(place - polygon.vertices()[0]).abs();
                *face != edge.face && height(edge.from) <= reach && height(edge.place(1.0)) <= reach
            };
            edge.level_with = near.into_iter().filter(is_level).collect();
            edge.beside = beside;
        }
        edges
    }

    fn of_face(face: usize, polygon: &Polygon) -> impl Iterator<Item = Self> {
        let corners = polygon.vertices();
        (0..corners.len()).map(move |first| {
            let second = (first + 1) % corners.len();
            let side = corners[second] - corners[first];
            let (from, length) = (corners[first], side.length());
            let (beside, level_with) = (Vec::new(), Vec::new());
            Self { face, ends: [first, second], from, direction: side / length, length, beside, level_with }
        })
    }

    /// The place at a part of its length.
    pub(super) fn place(&self, part: f64) -> DVec3 {
        self.from + self.direction * (part * self.length)
    }

    /// The part of this edge that another one goes along.
    fn common(&self, other: &Self, reach: f64) -> Option<[f64; 2]> {
        let along = |place: DVec3| (place - self.from).dot(self.direction);
        let ends = [0.0, 1.0].map(|part| other.place(part));
        let is_on_line = |place: DVec3| (place - self.from - self.direction * along(place)).length() <= reach;
        let [a, b] = ends.map(|end| along(end) / self.length);
        let [low, high] = [largest(smallest(a, b), 0.0), smallest(largest(a, b), 1.0)];
        (ends.into_iter().all(is_on_line) && high > low).then_some([low, high])
    }

    /// The faces at a part of its length.
    pub(super) fn joint(&self, mesh: &Mesh, part: f64, extent: f64) -> Joint {
        let mut faces = vec![self.face];
        faces.extend(self.beside.iter().filter(|(_, [low, high])| (*low..=*high).contains(&part)).map(|(face, _)| *face));
        let place = self.place(part);
        let is_touched = |face: &usize| !faces.contains(face) && mesh.distance_to_face(*face, place).0 <= JOINED * extent;
        Joint { touched: self.level_with.iter().copied().filter(is_touched).collect(), faces }
    }
}
