//! The radiosity that pictures show: the polynomials of a solution, nowhere negative.

use rayon::prelude::*;

use crate::solve::solution::Solution;
use radgrad_scene::largest;

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
