//! Triangles with their frame, to place receivers by.

use glam::DVec3;

use crate::cases::sampler::Sampler;

/// A fat triangle: its area is at least a tenth of its longest edge squared.
#[derive(Debug, Clone, Copy)]
pub(super) struct Triangle {
    pub(super) vertices: [DVec3; 3],
    /// Unit normal to the lit side.
    pub(super) normal: DVec3,
    /// Longest edge.
    pub(super) longest: f64,
}

impl Triangle {
    /// Vertices anywhere in [-1, 1]^3.
    pub(super) fn random(sampler: &mut Sampler) -> Self {
        loop {
            let vertices = std::array::from_fn(|_| sampler.cube());
            if let Some(triangle) = Self::fat(vertices) {
                return triangle;
            }
        }
    }

    /// In the plane z = 0, lit from above: heights over it are exact.
    pub(super) fn horizontal(sampler: &mut Sampler) -> Self {
        loop {
            let vertices = std::array::from_fn(|_| sampler.cube().with_z(0.0));
            if let Some(triangle) = Self::fat(vertices).filter(|t| t.normal.z > 0.0) {
                return triangle;
            }
        }
    }

    /// One of the two above at random.
    pub(super) fn random_or_horizontal(sampler: &mut Sampler) -> Self {
        if sampler.one_in(2) { Self::random(sampler) } else { Self::horizontal(sampler) }
    }

    fn fat(vertices: [DVec3; 3]) -> Option<Self> {
        let [a, b, c] = vertices;
        let cross = (b - a).cross(c - a);
        let longest = (b - a).length().max((c - b).length()).max((a - c).length());
        (longest > 0.5 && cross.length() > 0.2 * longest * longest).then(|| Self {
            vertices,
            normal: cross / cross.length(),
            longest,
        })
    }

    pub(super) fn centroid(&self) -> DVec3 {
        let [a, b, c] = self.vertices;
        (a + b + c) / 3.0
    }

    /// An edge: its start and its vector.
    pub(super) fn edge(&self, sampler: &mut Sampler) -> (DVec3, DVec3) {
        let start = sampler.below(3) as usize;
        (self.vertices[start], self.vertices[(start + 1) % 3] - self.vertices[start])
    }
}

/// A point inside a triangle, at least a tenth of the altitudes from the edges.
pub(super) fn inside(sampler: &mut Sampler, [a, b, c]: [DVec3; 3]) -> DVec3 {
    loop {
        let (u, v) = (sampler.uniform(), sampler.uniform());
        if u > 0.1 && v > 0.1 && u + v < 0.9 {
            return a + (b - a) * u + (c - a) * v;
        }
    }
}
