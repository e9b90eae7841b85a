//! Which convex parts of faces share edges.

use std::collections::HashMap;

use radgrad_core::DVec3;
use smallvec::SmallVec;

use super::screen::Screen;
use crate::extremes::smallest as smaller;

/// A screen: its face, and its number among the convex parts of that.
pub(super) type Place = (usize, usize);

/// The edges of each face's convex parts, one part after the other.
#[derive(Debug, Clone, Default)]
pub(super) struct Neighbours {
    edges: Vec<Vec<Edge>>,
}

/// An edge of a screen, and the screens that share it.
#[derive(Debug, Clone)]
struct Edge {
    ends: [DVec3; 2],
    /// The other screens that have it, either way: mostly one.
    others: SmallVec<[Place; 1]>,
    /// The normals of those of other faces.
    normals: SmallVec<[DVec3; 1]>,
}

impl Neighbours {
    pub(super) fn new(screens: &[Vec<Screen>]) -> Self {
        let mut of: HashMap<_, Vec<Place>> = HashMap::new();
        for (face, parts) in screens.iter().enumerate() {
            for (part, screen) in parts.iter().enumerate() {
                screen.edges().for_each(|edge| of.entry(Self::key(edge)).or_default().push((face, part)));
            }
        }
        let of_screen = |(place, screen): (Place, &Screen)| -> Vec<Edge> {
            let edge = |ends: [DVec3; 2]| {
                let [a, b] = ends;
                let all = [[a, b], [b, a]].into_iter().filter_map(|edge| of.get(&Self::key(edge))).flatten().copied();
                let others: SmallVec<[Place; 1]> = all.filter(|other| *other != place).collect();
                let normal = |&(face, part): &Place| screens[face][part].normal();
                let normals = others.iter().filter(|other| other.0 != place.0).map(normal).collect();
                Edge { ends, others, normals }
            };
            screen.edges().map(edge).collect()
        };
        let of_face = |(face, parts): (usize, &Vec<Screen>)| {
            parts.iter().enumerate().flat_map(|(part, screen)| of_screen(((face, part), screen))).collect()
        };
        Self { edges: screens.iter().enumerate().map(of_face).collect() }
    }

    /// How far a point of a face is inside the outline that the face and its neighbours show along a direction.
    pub(super) fn clearance(&self, (face, normal): (usize, DVec3), point: DVec3, along: DVec3) -> f64 {
        let towards = normal.dot(along);
        let is_outline = |edge: &&Edge| edge.normals.iter().all(|normal| normal.dot(along) * towards <= 0.0);
        // Squares, of an edge along the direction 0.
        let across = |Edge { ends: [a, b], .. }: &Edge| {
            let side = (*b - *a).cross(along);
            let (height, length) = (side.dot(point - *a), side.length_squared());
            if length > 0.0 { height * height / length } else { 0.0 }
        };
        self.edges[face].iter().filter(is_outline).map(across).fold(f64::INFINITY, smaller).sqrt()
    }

    fn key([a, b]: [DVec3; 2]) -> [u64; 6] {
        // Zeros of either sign are one.
        [a.x, a.y, a.z, b.x, b.y, b.z].map(|x| (x + 0.0).to_bits())
    }

    /// The other screens that have an edge of a face, given by its number among those of all parts.
    pub(super) fn beyond(&self, face: usize, edge: usize) -> impl Iterator<Item = Place> {
        self.edges[face].get(edge).into_iter().flat_map(|edge| edge.others.iter().copied())
    }
}
