//! Transfers past many faces, by rays: where closed forms would cut a source into hundreds of parts and no more than a rough answer is
//! asked for.
//!
//! The source is cut into equal cells, a ray goes to the centre of each, and the light of the hidden ones is taken from the
//! transfer in the clear, which is known: `G phi - 1/n sum of (1 - V) k phi`. The visible part of an element has an outline, and
//! only the cells on it are in doubt: m of the n, by the changes between neighbours, and each by half of its light, without
//! order. The error is taken to be `sqrt(m + 1)/2n` of the light in the clear. That is an estimate; proven is only that nothing
//! gives less than 0 or more than in the clear.

use crate::error::Error;
use crate::links::station::Station;
use crate::links::transfer::{Optics, Row};
use crate::mesh::Sight;
use crate::mesh::basis::Basis;
use crate::mesh::element::Element;
use crate::mesh::shape::Shape;
use radgrad_core::DVec3;
use radgrad_scene::largest;

/// Faces between a point and a source from which on rays are quicker.
pub(crate) const MANY: usize = 24;

/// Cells a side times the error asked for to the power of 2/3: an outline leaves about `side^(-3/2)` of the light.
const FINENESS: f64 = 2.0;

/// Error from which on no more than a rough answer is asked for.
const ROUGH: f64 = 0.01;

/// Cells a side of a source for an error, relative to the light; none if rays would be too many.
pub(crate) fn cells_for(error: f64) -> usize {
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a small number above 0")]
    if error >= ROUGH { (FINENESS * error.powf(-2.0 / 3.0)).ceil() as usize } else { 0 }
}

/// Kernel `cos1 cos2 / pi r^2` from a point to one of a surface, 0 if either is behind the other.
pub(crate) fn kernel(station: &Station, point: DVec3, normal: DVec3) -> f64 {
    let r = point - station.point;
    let (over, toward, square) = (station.normal.dot(r), -normal.dot(r), r.length_squared());
    if over > 0.0 && toward > 0.0 { over * toward / (std::f64::consts::PI * square * square) } else { 0.0 }
}

/// Centres of the cells of an element, in reference coordinates, in an order in which those that follow each other are neighbours.
pub(crate) fn centres(shape: Shape, side: usize) -> Vec<[f64; 2]> {
    let unit = 1.0 / side as f64;
    let coordinate = |i: usize, part: f64| (i as f64 + part) * unit;
    let mut centres = Vec::with_capacity(side * side);
    for i in 0..side {
        let row = centres.len();
        match shape {
            Shape::Parallelogram => centres.extend((0..side).map(|j| [coordinate(j, 0.5), coordinate(i, 0.5)])),
            Shape::Triangle => {
                for j in 0..side - i {
                    centres.push([coordinate(j, 1.0 / 3.0), coordinate(i, 1.0 / 3.0)]);
                    if j + 1 < side - i {
                        centres.push([coordinate(j, 2.0 / 3.0), coordinate(i, 2.0 / 3.0)]);
                    }
                }
            }
        }
        if i % 2 == 1 {
            centres[row..].reverse();
        }
    }
    centres
}

impl Optics<'_> {
    /// Whether no face is between a point and one of another face.
    pub(crate) fn sees(&self, station: &Station, point: DVec3, face: usize) -> bool {
        !self.mesh.is_between([station.point, point], [station.face.unwrap_or(face), face])
    }

    /// The light that a point receives from the first `count` functions of a source, past whatever is between.
    pub(crate) fn by_rays(&self, station: &Station, (source, basis): (usize, &Basis), count: usize) -> Result<Row, Error> {
        let clear = self.receive_of(station, (source, basis), &Sight::Clear, count)?;
        let element: &Element = &self.mesh.elements()[source];
        let cells = centres(element.shape(), self.cells);
        let (normal, part) = (element.polygon().normal(), element.area() / cells.len() as f64);
        let (mut changes, mut before, mut all) = (0, None, 0.0);
        let (mut hidden, mut functions) = (vec![0.0; count], vec![0.0; basis.len()]);
        for &at in &cells {
            let point = element.point(at);
            let weight = part * kernel(station, point, normal);
            if weight == 0.0 {
                continue;
            }
            all += weight;
            let is_visible = self.sees(station, point, element.face());
            changes += usize::from(before.is_some_and(|before| before != is_visible));
            before = Some(is_visible);
            if !is_visible {
                basis.fill(at, &mut functions);
                hidden.iter_mut().zip(&functions).for_each(|(sum, phi)| *sum += weight * phi);
            }
        }
        // The cells' own sum is not that in the clear.
        let scale = if all > 0.0 { clear.values[0] / all } else { 0.0 };
        let values: Vec<f64> = clear.values.iter().zip(&hidden).map(|(value, hidden)| value - scale * hidden).collect();
        let whole = largest(clear.values[0], 0.0) + clear.error;
        let error = largest(values[0].abs(), whole - values[0]) + clear.error;
        let other_errors = 2.0 * whole * basis.largest() + clear.other_errors;
        // Twice the changes along rows: outlines cross columns as well.
        let doubt = 0.5 * ((2 * changes + 1) as f64).sqrt() / cells.len() as f64;
        let mut kernel = clear.kernel;
        (kernel.smooth, kernel.least) = (false, 0.0);
        Ok(Row { values, error, other_errors, likely: Some(doubt * whole + clear.error), kernel, sampled: None })
    }
}
