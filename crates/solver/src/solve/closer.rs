//! What the sources near a point are off by, by samples of them.

use std::sync::OnceLock;

use radgrad_core::DVec3;

use crate::error::Error;
use crate::links::station::Station;
use crate::mesh::Sight;
use crate::mesh::basis::Basis;
use crate::mesh::shape::Shape;
use crate::solve::solution::Solution;
use crate::solve::wedge::OffNearEdge;

/// Nearness.
pub(super) const NEAR: f64 = 0.6;
const MOST_DIVISIONS: u32 = 4;

#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Sampled {
    pub(super) gradient: DVec3,
    /// Square.
    pub(super) off: f64,
}

impl Solution {
    pub(super) fn gradient_of_samples(
        &self,
        leaf: usize,
        sight: &Sight,
        station: &Station,
        near_edge: Option<(&OffNearEdge, bool)>,
    ) -> Result<Vec<Sampled>, Error> {
        static BASES: OnceLock<[Basis; 2]> = OnceLock::new();
        let bases = BASES.get_or_init(|| [Shape::Parallelogram, Shape::Triangle].map(|shape| Basis::of_fewest_nodes(shape, 1)));
        let element = &self.mesh.elements()[leaf];
        let basis = &bases[usize::from(element.shape() == Shape::Triangle)];
        let channels = self.channels.len();
        let mut found = vec![Sampled::default(); channels];
        let (mut open, mut closed) = (element.divided(leaf, basis)?, Vec::new());
        while let Some(cell) = open.pop() {
            if cell.nearness_to(station.point) > NEAR && cell.level() < element.level() + MOST_DIVISIONS {
                open.extend(cell.divided(leaf, basis)?);
            } else {
                closed.push(cell);
            }
        }
        for cell in closed {
            let above = |v: &DVec3| station.normal.dot(*v - station.point) > 0.0;
            if !cell.polygon().vertices().iter().any(above) {
                continue;
            }
            let mut samples: Vec<Option<Vec<f64>>> = Vec::new();
            for node in basis.nodes() {
                let place = cell.point(node.at);
                samples.push(if above(&place) { self.beyond_at(leaf, place, near_edge)? } else { None });
            }
            let count = samples.iter().flatten().count();
            if count == 0 {
                continue;
            }
            let mut coefficients: Vec<Vec<f64>> = Vec::new();
            for channel in 0..channels {
                let mean = samples.iter().flatten().map(|of| of[channel]).sum::<f64>() / count as f64;
                let values: Vec<f64> = samples.iter().map(|of| of.as_ref().map_or(mean, |of| of[channel])).collect();
                coefficients.push(basis.project(&values));
            }
            let all: Vec<&[f64]> = coefficients.iter().map(|of| &of[..]).collect();
            let constant: Vec<&[f64]> = coefficients.iter().map(|of| &of[..1]).collect();
            let gradients = self.gradients_of((&cell, basis), sight, station, &all)?;
            let roughly = self.gradients_of((&cell, basis), sight, station, &constant)?;
            for channel in 0..channels {
                found[channel].gradient += gradients[channel];
                found[channel].off += (gradients[channel] - roughly[channel]).length_squared();
            }
        }
        Ok(found)
    }

    /// The radiosity beyond what gathers take.
    fn beyond_at(&self, leaf: usize, place: DVec3, near_edge: Option<(&OffNearEdge, bool)>) -> Result<Option<Vec<f64>>, Error> {
        let face = self.mesh.elements()[leaf].face();
        let irradiance = self.corrected_on(leaf, place)?;
        let [rho, emitted] = self.surfaces.at(face, place);
        let Some(taken) = self.taken_at(face, place) else { return Ok(None) };
        let more = near_edge.filter(|(of, _)| of.face == face).and_then(|(of, is_known)| Some((of.at(place)?, is_known)));
        let more = |c: usize| more.as_ref().map_or(0.0, |(of, is_known)| if *is_known { of[c][1] - of[c][0] } else { of[c][1] });
        let of = |(c, taken): (usize, f64)| more(c) + rho[c] * irradiance[c] + emitted[c] - self.lamp_on(face, c) - taken;
        Ok(Some(taken.into_iter().enumerate().map(of).collect()))
    }

}
