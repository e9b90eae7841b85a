//! Direct irradiance of a surface from others, with its gradient, on a grid.

use radgrad_core::{DVec3, Receiver, evaluate_to};
use rayon::prelude::*;

use super::rule::patches;
use super::{FormFactors, Hiding};
use crate::error::Error;

/// A cell of a grid on a face.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FieldCell {
    /// The face.
    pub face: usize,
    /// The cell's corners, counter-clockwise seen from the lit side; beside the apex of a triangle two coincide.
    pub corners: [DVec3; 4],
    /// Where the field is given: the middle of the cell's parameters.
    pub centre: DVec3,
    /// Irradiance, in the unit of the radiosities given.
    pub value: f64,
    /// Its gradient with respect to position at fixed normal, in that unit over the unit of length.
    pub gradient: DVec3,
    /// Proven bound on the error of `value`.
    pub value_error: f64,
    /// Proven bound on the norm of the error of `gradient`; infinite where the gradient has two values. Planes are those of surfaces: what
    /// stands out of one by rounding is in it.
    pub gradient_error: f64,
}

impl FormFactors<'_> {
    /// The irradiance that faces of the given radiosities cause on a surface, on `grid` squared cells of each of its faces (of
    /// each triangle, of those with more than four corners), on all cores. `progress` is called once a cell.
    ///
    /// # Errors
    /// If there is no such surface or face, the grid has no cell, or an answer is out of range.
    pub fn field(
        &self,
        surface: usize,
        grid: usize,
        radiosities: &[(usize, f64)],
        tolerance: f64,
        progress: impl Fn() + Sync,
    ) -> Result<Vec<FieldCell>, Error> {
        let scene = self.scene();
        let on = scene.surfaces().get(surface).ok_or_else(|| Error::Missing {
            what: "surface",
            which: surface.to_string(),
            known: format!("they are numbered from 0, and there are {}", scene.surfaces().len()),
        })?;
        if grid == 0 {
            return Err(Error::expected("a grid of at least one cell", "0"));
        }
        let place = |k: usize| k as f64 / grid as f64;
        let (half, placement) = (0.5 / grid as f64, self.placement());
        let mut cells = Vec::new();
        for &face in on.faces() {
            for patch in patches(self.emitter(face)?.polygon().vertices()) {
                for (row, column) in (0..grid).flat_map(|row| (0..grid).map(move |column| (row, column))) {
                    let ([u, v], [next_u, next_v]) = ([column, row].map(place), [column + 1, row + 1].map(place));
                    let corners = [(u, v), (next_u, v), (next_u, next_v), (u, next_v)].map(|(u, v)| patch.at(u, v).0);
                    // Far from the origin a middle rounds as it is moved back: the field is that of the place which is stated.
                    let centre = placement.inward(placement.outward(patch.at(u + half, v + half).0));
                    let (value, gradient) = (0.0, DVec3::ZERO);
                    cells.push(FieldCell { face, corners, centre, value, gradient, value_error: 0.0, gradient_error: 0.0 });
                }
            }
        }
        cells.par_iter_mut().try_for_each(|cell| {
            progress();
            self.fill(cell, radiosities, tolerance)
        })?;
        for cell in &mut cells {
            cell.corners = cell.corners.map(|corner| placement.outward(corner));
            cell.centre = placement.outward(cell.centre);
            cell.gradient *= placement.power();
            cell.gradient_error *= placement.power();
        }
        Ok(cells)
    }

    fn fill(&self, cell: &mut FieldCell, radiosities: &[(usize, f64)], tolerance: f64) -> Result<(), Error> {
        let own = self.polygon(cell.face);
        let receiver = Receiver::new(cell.centre, own.normal(), 1.0).map_err(Error::Receiver)?;
        for &(face, radiosity) in radiosities.iter().filter(|(face, _)| *face != cell.face) {
            let emitter = self.emitter(face)?;
            let Some(Hiding { found, left_out }) = self.hiding(&receiver, cell.face, face) else { continue };
            let answer = evaluate_to(&receiver, emitter, self.polygons(&found), tolerance).map_err(Error::Evaluation)?;
            cell.value += radiosity * answer.radiosity;
            cell.gradient += answer.gradient * radiosity;
            // A product and a sum each.
            cell.value_error += radiosity.abs() * (answer.radiosity_error + left_out) + f64::EPSILON * cell.value.abs();
            cell.gradient_error += radiosity.abs() * answer.gradient_error + 2.0 * f64::EPSILON * cell.gradient.length();
        }
        Ok(())
    }
}
