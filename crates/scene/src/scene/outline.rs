//! Faces of a file as they were read.

use radgrad_core::{DVec3, Polygon};

use super::Face;
use crate::error::Error;
use crate::place::Place;
use crate::reading::Budget;
use crate::texture::chart::Chart;

/// A face that is being read: its vertices, and at each of them the coordinates of the textures of its reflectance and of its
/// radiance, where it has these.
#[derive(Debug, Clone, Default)]
pub(crate) struct Outline {
    pub(crate) vertices: Vec<DVec3>,
    pub(crate) coordinates: [Option<Vec<[f64; 2]>>; 2],
}

impl Outline {
    /// Some of the vertices.
    pub(super) fn part(&self, kept: &[usize]) -> Self {
        let coordinates = self.coordinates.each_ref().map(|of| of.as_ref().map(|of| kept.iter().map(|&i| of[i]).collect()));
        Self { vertices: kept.iter().map(|&i| self.vertices[i]).collect(), coordinates }
    }

    pub(super) fn charts(&self, polygon: &Polygon) -> Result<[Option<Chart>; 2], Error> {
        let [reflectance, radiance] = &self.coordinates;
        let chart = |of: &Option<Vec<[f64; 2]>>| of.as_ref().map(|of| Chart::new(polygon, of)).transpose();
        Ok([chart(reflectance)?, chart(radiance)?])
    }
}

/// A face of a file, as it was read.
#[derive(Debug)]
pub(super) struct Given {
    pub(super) surface: usize,
    pub(super) material: usize,
    pub(super) outline: Outline,
    pub(super) place: Place,
}

/// Takes the memory of a face of so many vertices.
pub(super) fn take_face(budget: &Budget, vertices: usize) -> Result<(), Error> {
    // A polygon keeps more of an edge than its vertex: about ten times as much.
    let size = size_of::<Face>() + vertices.saturating_mul(10 * size_of::<DVec3>());
    budget.take_many("faces", 1, size)
}
