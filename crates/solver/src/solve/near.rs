//! The gradient of what sources near a point are off by, by samples.
//!
//! The gradient of the kernel falls as the third power of the distance: near a source it goes by details that no polynomial of the source has.
//! So a leaf near a point is divided on paper into cells, the smaller the nearer, and what it is off by is sampled in each: `C - q + eps`, as
//! [`crate::solve::wedge`] has it, with eps where that is known. Where that module's own sum is in the gradient already the samples are what
//! they differ from that. The linear function through the samples of a cell is gathered by closed forms.
//!
//! The estimate of what that leaves adds up squares: of the slopes of these functions, cell by cell; and of a part of all that is added, as C is
//! off as well.

use std::sync::OnceLock;

use radgrad_core::DVec3;

use crate::error::Error;
use crate::links::station::Station;
use crate::mesh::Sight;
use crate::mesh::basis::Basis;
use crate::mesh::element::Element;
use crate::mesh::shape::Shape;
use crate::solve::solution::Solution;
use crate::solve::wedge::Lacking;

/// The radius of a leaf over its distance from which on it is sampled, and of a cell from which on it is divided; and how often at most.
pub(super) const NEAR: f64 = 0.4;
const MOST_DIVISIONS: u32 = 5;

/// The part of what is added that it is likely off by.
const STILL_OFF: f64 = 0.25;

/// In a channel, the gradient of what a leaf is off by, and the square of what that is off by.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Sampled {
    pub(super) gradient: DVec3,
    pub(super) off: f64,
}

impl Solution {
    /// The gradient at a station of what a leaf is off by, in each channel; near edges with what the other faces lack there.
    pub(super) fn gradient_of_samples(
        &self,
        station: &Station,
        (leaf, sight): (usize, &Sight),
        near_edges: &[Lacking],
    ) -> Result<Vec<Sampled>, Error> {
        static LINEAR: OnceLock<[Basis; 2]> = OnceLock::new();
        let linear = LINEAR.get_or_init(|| [Shape::Parallelogram, Shape::Triangle].map(|shape| Basis::of_fewest_nodes(shape, 1)));
        let element = &self.mesh.elements()[leaf];
        let basis = &linear[usize::from(element.shape() == Shape::Triangle)];
        let mut found = vec![Sampled::default(); self.channels.len()];
        let mut open = element.divided(leaf, basis)?;
        while let Some(cell) = open.pop() {
            if cell.nearness_to(station.point) > NEAR && cell.level() < element.level() + MOST_DIVISIONS {
                open.extend(cell.divided(leaf, basis)?);
                continue;
            }
            let Some(functions) = self.off_on(&cell, basis, station, (leaf, near_edges))? else { continue };
            let whole: Vec<&[f64]> = functions.iter().map(|of| &of[..]).collect();
            let mean: Vec<&[f64]> = functions.iter().map(|of| &of[..1]).collect();
            let [whole, mean] = [whole, mean].map(|of| self.gradients_of((&cell, basis), sight, station, &of));
            for ((sum, whole), mean) in found.iter_mut().zip(whole?).zip(mean?) {
                sum.gradient += whole;
                sum.off += (whole - mean).length_squared();
            }
        }
        found.iter_mut().for_each(|of| of.off += STILL_OFF * STILL_OFF * of.gradient.length_squared());
        Ok(found)
    }

    /// In each channel, coefficients of the linear function through samples on a cell of a leaf; `None` if the station is level with all of
    /// them. Of others, below its horizon, it sees nothing.
    fn off_on(
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
            samples.push(if is_above { self.off_at(leaf, place, near_edges)? } else { None });
        }
        let count = samples.iter().flatten().count();
        if count == 0 {
            return Ok(None);
        }
        let of_channel = |channel: usize| {
            let known = |sample: &Vec<f64>| sample[channel];
            let mean = samples.iter().flatten().map(known).sum::<f64>() / count as f64;
            let values: Vec<f64> = samples.iter().map(|sample| sample.as_ref().map_or(mean, known)).collect();
            basis.project(&values)
        };
        Ok(Some((0..self.channels.len()).map(of_channel).collect()))
    }

    /// What a place of a leaf is off by, less what is known of that; `None` if nothing is known there.
    fn off_at(&self, leaf: usize, place: DVec3, near_edges: &[Lacking]) -> Result<Option<Vec<f64>>, Error> {
        let face = self.mesh.elements()[leaf].face();
        let Some(taken) = self.taken_at(face, place) else { return Ok(None) };
        let [_, radiosity] = self.corrected_at(leaf, place)?;
        let mut off: Vec<f64> = radiosity.iter().zip(taken).map(|(radiosity, taken)| radiosity - taken).collect();
        for edge in near_edges.iter().filter(|edge| edge.other.face == face) {
            let Some([all, more]) = edge.other.off_at(place) else { continue };
            let known = |c: usize| if edge.is_beside { more[c] - all[c] } else { more[c] };
            off.iter_mut().enumerate().for_each(|(c, off)| *off += known(c));
        }
        Ok(Some(off))
    }
}
