//! The shapes of emitters with as many vertices each, and how bright they are, as arrays in the order of a cluster.
//!
//! A tree reads its emitters once into arrays and passes them on from a node to those below it, so that quantities that do not
//! depend on a node are computed once, and a node reads memory from its start to its end.

use glam::DVec3;

use crate::problem::emission::Emitter;
use crate::problem::polygon::Polygon;

/// Shapes of some emitters, lengths times a power of two.
#[derive(Debug)]
pub(super) struct Shapes {
    /// How many vertices each emitter has.
    corners: usize,
    /// Vertices of the emitters, one emitter after the other.
    pub(super) vertices: Vec<DVec3>,
    pub(super) normals: Vec<DVec3>,
    pub(super) largest_emissions: Vec<f64>,
    /// Triangles of the fans, one emitter after the other.
    facets: Vec<Facet>,
}

/// A triangle of the fan of an emitter.
#[derive(Debug, Clone, Copy)]
pub(super) struct Facet {
    /// `None` for a needle so thin that its normal is lost.
    pub(super) unit_normal: Option<DVec3>,
    /// Bound on the error of that by the rounding of vertices.
    pub(super) uncertainty: f64,
    /// At least `|B| A`.
    pub(super) power: f64,
}

impl Shapes {
    /// The shapes of the emitters of some indices, all with as many vertices.
    pub(super) fn new(emitters: &[Emitter], indices: &[usize], power: f64) -> Self {
        let corners = indices.first().map_or(0, |first| emitters[*first].polygon().vertices().len());
        let mut shapes = Self::with_room(corners, indices.len());
        for emitter in indices.iter().map(|index| &emitters[*index]) {
            let polygon = emitter.polygon();
            let emission = emitter.largest_emission();
            shapes.vertices.extend(polygon.vertices().iter().map(|v| *v * power));
            shapes.normals.push(polygon.normal());
            shapes.largest_emissions.push(emission);
            shapes.facets.extend(fan(polygon, power).map(|triangle| Facet::new(triangle, emission)));
        }
        shapes
    }

    fn with_room(corners: usize, count: usize) -> Self {
        Self {
            corners,
            vertices: Vec::with_capacity(corners * count),
            normals: Vec::with_capacity(count),
            largest_emissions: Vec::with_capacity(count),
            facets: Vec::with_capacity(corners.saturating_sub(2) * count),
        }
    }

    /// The shapes at some places, in that order.
    pub(super) fn gather(&self, places: impl ExactSizeIterator<Item = usize>) -> Self {
        let (corners, facets) = (self.corners, self.corners - 2);
        let mut shapes = Self::with_room(corners, places.len());
        for place in places {
            shapes.vertices.extend_from_slice(self.outline(place));
            shapes.normals.push(self.normals[place]);
            shapes.largest_emissions.push(self.largest_emissions[place]);
            shapes.facets.extend_from_slice(&self.facets[place * facets..][..facets]);
        }
        shapes
    }

    pub(super) const fn count(&self) -> usize {
        self.normals.len()
    }

    /// Vertices of the emitter at a place.
    fn outline(&self, place: usize) -> &[DVec3] {
        &self.vertices[place * self.corners..][..self.corners]
    }

    /// Mean of the vertices of the emitter at a place.
    pub(super) fn middle(&self, place: usize) -> DVec3 {
        self.outline(place).iter().sum::<DVec3>() / self.corners as f64
    }

    /// Each triangle, with vertex 0 of its emitter.
    pub(super) fn facets(&self) -> impl Iterator<Item = (DVec3, &Facet)> {
        let fans = self.facets.chunks_exact(self.corners - 2);
        self.vertices.chunks_exact(self.corners).zip(fans).flat_map(|(outline, fan)| fan.iter().map(|facet| (outline[0], facet)))
    }
}

impl Facet {
    fn new([a, b, c]: [DVec3; 3], emission: f64) -> Self {
        let across = (b - a).cross(c - a);
        let rounding = 8.0 * f64::EPSILON * (b - a).length() * (c - a).length();
        Self {
            unit_normal: across.try_normalize(),
            uncertainty: rounding / across.length(),
            power: 0.5 * emission * (across.length() + rounding),
        }
    }
}

/// The triangles of the fan from vertex 0.
pub(super) fn fan(polygon: &Polygon, power: f64) -> impl Iterator<Item = [DVec3; 3]> {
    let vertices = polygon.vertices();
    vertices[1..].windows(2).map(move |pair| [vertices[0], pair[0], pair[1]].map(|v| v * power))
}
