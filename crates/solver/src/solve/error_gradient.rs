//! The gradient of the error of polynomials near a point, by samples.
//!
//! The gradient of the kernel falls as the third power of the distance, so that near a source it depends on details that no polynomial of the
//! source has. A leaf near a point is divided on paper into cells, the nearer the smaller. Samples in each cell find the error of the polynomial,
//! `C - q + eps` in the symbols of [`crate::solve::wedge`], with eps where that module knows it. Where the gradient already has the slope
//! that it finds, the samples have the difference from it. Closed forms give the gradient of the linear function through the samples of a cell.
//!
//! The estimate of the error that is left adds up squares: those of the parts that the slopes of these functions give, cell by cell; and that of
//! a part of the whole, because C has an error as well.
//!
//! Cells of a leaf are the same for all points, and most of those of a leaf near one are near others, too: samples are kept.

use radgrad_core::DVec3;

use crate::error::Error;
use crate::links::station::Station;
use crate::mesh::Sight;
use crate::mesh::basis::Basis;
use crate::mesh::element::Element;
use crate::solve::error_samples::Sample;
use crate::solve::solution::Solution;
use crate::solve::wedge::Lacking;

/// The radius of a leaf over its distance from which on it is sampled, and of a cell from which on it is divided; and the range of how often
/// at most. The error of a linear function falls by four with each division, so that is the logarithm of the error asked for to that base.
pub(super) const NEAR: f64 = 0.4;
const DIVISIONS: [u32; 2] = [1, 5];

/// The likely error of the correction, over it.
const STILL_OFF: f64 = 0.25;

/// In a channel, the gradient of a leaf's error, and the square of the likely error of that gradient.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Sampled {
    pub(super) gradient: DVec3,
    pub(super) squared_error: f64,
}

impl Solution {
    /// The gradient at a station of a leaf's error, in each channel.
    pub(super) fn gradient_of_samples(
        &self,
        station: &Station,
        (leaf, sight): (usize, &Sight),
        near_edges: &[Lacking],
    ) -> Result<Vec<Sampled>, Error> {
        let element = self.element(leaf);
        let basis = Basis::linear(element.shape());
        let mut gradients = vec![Sampled::default(); self.channels().len()];
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a cast saturates, and the limits are small")]
        let divisions = (self.budget.asked.log(0.25).ceil() as u32).clamp(DIVISIONS[0], DIVISIONS[1]);
        let mut open = element.divided(leaf, basis)?;
        while let Some(cell) = open.pop() {
            if cell.nearness_to(station.point) > NEAR && cell.level() < element.level() + divisions {
                open.extend(cell.divided(leaf, basis)?);
                continue;
            }
            let Some(functions) = self.defects_on(&cell, basis, station, (leaf, near_edges))? else { continue };
            let whole: Vec<&[f64]> = functions.iter().map(|of| &of[..]).collect();
            let mean: Vec<&[f64]> = functions.iter().map(|of| &of[..1]).collect();
            let [whole, mean] = [whole, mean].map(|of| self.gradients_of((&cell, basis), sight, station, &of));
            for ((sum, whole), mean) in gradients.iter_mut().zip(whole?).zip(mean?) {
                sum.gradient += whole;
                sum.squared_error += (whole - mean).length_squared();
            }
        }
        gradients.iter_mut().for_each(|of| of.squared_error += STILL_OFF * STILL_OFF * of.gradient.length_squared());
        Ok(gradients)
    }

    /// In each channel, coefficients of the linear function through samples on a cell of a leaf. Where the station sees nothing, below its
    /// horizon, the mean of the others stands; `None` if it is so everywhere.
    fn defects_on(
        &self,
        cell: &Element,
        basis: &Basis,
        station: &Station,
        (leaf, near_edges): (usize, &[Lacking]),
    ) -> Result<Option<Vec<Vec<f64>>>, Error> {
        let mut samples = Vec::with_capacity(basis.nodes().len());
        for node in basis.nodes() {
            let place = cell.point(node.at);
            let is_above = station.normal.dot(place - station.point) > 0.0;
            samples.push(if is_above { self.defect_at(leaf, place, near_edges)? } else { None });
        }
        let count = samples.iter().flatten().count();
        if count == 0 {
            return Ok(None);
        }
        let of_channel = |channel: usize| {
            let value = |sample: &Vec<f64>| sample[channel];
            let mean = samples.iter().flatten().map(value).sum::<f64>() / count as f64;
            let values: Vec<f64> = samples.iter().map(|sample| sample.as_ref().map_or(mean, value)).collect();
            basis.project(&values)
        };
        Ok(Some((0..self.channels().len()).map(of_channel).collect()))
    }

    /// The error `C - q` of a place of a leaf, with the terms of edges near by; `None` if q is not known.
    pub(super) fn defect_at(&self, leaf: usize, place: DVec3, near_edges: &[Lacking]) -> Result<Sample, Error> {
        let face = self.element(leaf).face();
        let sample = || {
            let Some(taken) = self.taken_at(face, place) else { return Ok(None) };
            let [_, radiosity] = self.corrected_at(leaf, place)?;
            Ok(Some(radiosity.iter().zip(taken).map(|(radiosity, taken)| radiosity - taken).collect()))
        };
        let Some(mut defect) = self.caches.kept.get_or_evaluate(leaf, place, sample)? else { return Ok(None) };
        for edge in near_edges.iter().filter(|edge| edge.other.face == face) {
            let Some(more) = edge.other.more_at(place) else { continue };
            defect.iter_mut().zip(more).for_each(|(defect, more)| *defect += more);
        }
        Ok(Some(defect))
    }
}
