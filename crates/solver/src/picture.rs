//! The radiosity that pictures show: the polynomials of a solution, nowhere negative; and gathers of as many digits as a picture has.

use std::collections::HashMap;
use std::sync::{Arc, Mutex, PoisonError};

use radgrad_core::DVec3;
use rayon::prelude::*;

use crate::error::Error;
use crate::links::station::Station;
use crate::links::transfer::Optics;
use crate::solve::gather::Gathered;
use crate::solve::solution::Solution;
use crate::solve::wedge::{BesideEdge, Section};
use radgrad_scene::largest;

/// The error that an evaluation may have at least, per unit of the source's radiosity: some hundred of them are a thousandth off.
const PRECISE: f64 = 1e-5;

/// The part of the difference between sections of an edge that counts as an error of the light between them.
const BETWEEN: f64 = 0.5;

/// The polynomials on the leaves of a solution, drawn toward their means where they would be negative.
#[derive(Debug, Clone)]
pub struct NonNegative<'a> {
    solution: &'a Solution,
    /// For each element, if it is a leaf, channel after channel.
    coefficients: Vec<Vec<Vec<f64>>>,
}

impl Solution {
    /// The polynomials of the leaves, drawn toward their means where they would be negative (X. Zhang and C.-W. Shu 2010): beside the
    /// edge of a shadow, most often.
    ///
    /// That keeps the mean of each. A negative mean becomes 0.
    #[must_use]
    pub fn not_negative(&self) -> NonNegative<'_> {
        let of_leaf = |leaf: usize| {
            let channels = if self.mesh().elements()[leaf].is_leaf() { self.channels().len() } else { 0 };
            (0..channels).map(|channel| self.limited(leaf, channel)).collect()
        };
        let coefficients = (0..self.mesh().elements().len()).into_par_iter().map(of_leaf).collect();
        NonNegative { solution: self, coefficients }
    }

    /// The polynomial on a leaf, drawn toward its mean as far as it may be negative.
    fn limited(&self, leaf: usize, channel: usize) -> Vec<f64> {
        let mut coefficients = self.coefficients_on(leaf, channel);
        let [low, _] = self.mesh().basis(leaf).range(&coefficients);
        if low < 0.0 {
            let mean = largest(coefficients[0], 0.0);
            let part = mean / (mean - low);
            coefficients.iter_mut().for_each(|c| *c *= part);
            coefficients[0] = mean;
        }
        coefficients
    }
}

impl NonNegative<'_> {
    /// Radiosity on a leaf in a channel; 0 if the element is no leaf.
    #[must_use]
    pub fn value_on(&self, leaf: usize, channel: usize, reference: [f64; 2]) -> f64 {
        let Some(coefficients) = self.coefficients.get(leaf).and_then(|of| of.get(channel)) else { return 0.0 };
        coefficients.iter().zip(self.solution.mesh().basis(leaf).values(reference)).map(|(c, v)| c * v).sum()
    }
}

/// Gathers for a picture, that share their sections of edges.
///
/// Evaluations are no more precise than a picture is. Beside an edge of two faces a gather lacks light that some eighteen others tell, on a
/// section across the edge: points of the same two leaves share two such sections, and interpolate.
#[derive(Debug)]
pub struct PictureGathers<'a> {
    solution: &'a Solution,
    sections: Mutex<HashMap<[usize; 2], Sections>>,
}

/// Two sections of an edge of two leaves, if anything is known there.
type Sections = Arc<Option<[Section; 2]>>;

impl Solution {
    /// Gathers for a picture.
    #[must_use]
    pub fn picture_gathers(&self) -> PictureGathers<'_> {
        PictureGathers { solution: self, sections: Mutex::default() }
    }
}

impl PictureGathers<'_> {
    /// As [`Solution::gather_on`].
    ///
    /// # Errors
    /// If it cannot be represented.
    pub fn gather_on(&self, leaf: usize, point: DVec3) -> Result<Gathered, Error> {
        let lacking = match self.solution.beside_edge(leaf, point) {
            Some(beside) => self.lacking(&beside)?.map(|lacking| (beside.other, lacking)),
            None => None,
        };
        self.solution.gather_by(&self.optics(), (leaf, point), lacking)
    }

    /// The part of a point's radiosity and that of its irradiance, in each channel, that come from lamps directly and are computed apart: all
    /// that may have the edges of sharp shadows. They are 0 if most of the scene glows.
    ///
    /// # Errors
    /// If they cannot be represented.
    pub fn from_lamps(&self, leaf: usize, point: DVec3) -> Result<[Vec<f64>; 2], Error> {
        let (element, none) = (self.solution.element(leaf), || vec![0.0; self.solution.channels().len()]);
        let lit = self.solution.lit_by(&self.optics(), leaf, &Station::on(element, point))?;
        let irradiance = lit.map_or_else(none, |lit| lit.irradiance);
        let [rho, _] = self.solution.system.surfaces.reflectance_and_emission(element.face(), point);
        Ok([rho.iter().zip(&irradiance).map(|(rho, light)| rho * light).collect(), irradiance])
    }

    fn optics(&self) -> Optics<'_> {
        let optics = self.solution.optics();
        Optics { absolute: largest(optics.absolute, PRECISE), past: largest(optics.past, PRECISE), ..optics }
    }

    /// The light that a gather lacks beside an edge in each channel, with an estimate of its error.
    fn lacking(&self, beside: &BesideEdge) -> Result<Option<Vec<[f64; 2]>>, Error> {
        let entry = self.sections.lock().unwrap_or_else(PoisonError::into_inner).get(&beside.leaves).cloned();
        let sections = match entry {
            Some(sections) => sections,
            // Two threads may find the same: they wait for nothing.
            None => {
                let pair = Arc::new(self.solution.shared_sections(beside)?);
                self.sections.lock().unwrap_or_else(PoisonError::into_inner).entry(beside.leaves).or_insert(pair).clone()
            }
        };
        let Some(sections) = &*sections else { return Ok(None) };
        let [first, second] = sections.each_ref().map(|section| section.lacking_at(beside.distance));
        let weights = [1.0 - beside.weight, beside.weight];
        let of_channel = |([first, error], [second, other]): (&[f64; 2], &[f64; 2])| {
            let estimate = weights[0].abs() * error + weights[1].abs() * other + BETWEEN * (second - first).abs();
            [weights[0] * first + weights[1] * second, estimate]
        };
        Ok(Some(first.iter().zip(&second).map(of_channel).collect()))
    }
}
