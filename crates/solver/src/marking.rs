//! Which leaves a round divides: those that are off most, by the residual alone or by the gradient too.
//!
//! The residual is known where it is sampled, at the nodes. The gradient adds what the light does between them (N. Holzschuch
//! and F. X. Sillion 1995, 3.2): of a constant leaf what it changes by over its widths, from the gradient at the centre; of a
//! linear one by how much the cubic through exact values and gradients of two corners leaves the straight line, along the edges
//! and, on a parallelogram, the diagonals. A basis of a higher degree is judged like a linear one, which is too strict for it.
//! Corners are moved inward, those of a square to its four Gauss nodes: at an edge between two faces gradients are infinite, and
//! there a cubic through the corners themselves says nothing.

use radgrad_core::DVec3;

use crate::Error;
use crate::basis::Shape;
use crate::receiver::{departure, variation};
use crate::solve::Solution;

/// What leaves are divided by.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Marking {
    /// The mean residual over the leaf.
    #[default]
    Residual,
    /// That, and what the gradients of exact gathers say of the light between nodes.
    Gradient,
}

/// Weight of what the gradient says beside the residual: of several the best in the Cornell box before faces were cut where others
/// stand on them, by the number of elements for the same error.
pub(crate) const BESIDE_RESIDUAL: f64 = 0.1;

/// Part of the way to the centre at which a corner is sampled: `1 - 1/sqrt(3)`.
const INWARD: f64 = 0.422_649_730_810_374_2;

impl Solution {
    /// What a leaf is off relative to the mean radiosity, in the worst channel, by the gradient.
    pub(crate) fn off_by_gradient(&self, leaf: usize) -> Result<f64, Error> {
        let (element, channels) = (&self.mesh().elements()[leaf], self.channels().len());
        let relative = |channel: usize, off: f64| if off > 0.0 { off / self.mean()[channel] } else { 0.0 };
        if self.mesh().basis(leaf).degree() == 0 {
            let gradients = self.gradient_at(leaf, element.centre())?;
            let off = |channel: usize| 0.5 * variation(gradients[channel], element.axes()).iter().sum::<f64>();
            return Ok((0..channels).map(|channel| relative(channel, off(channel))).fold(0.0, f64::max));
        }
        let sample = |&corner: &DVec3| {
            let point = corner + (element.centre() - corner) * INWARD;
            Ok((point, self.gather_on(leaf, point)?.radiosity, self.gradient_at(leaf, point)?))
        };
        let corners = element.polygon().vertices().iter().map(sample).collect::<Result<Vec<_>, Error>>()?;
        let lines: &[[usize; 2]] = match element.shape() {
            Shape::Parallelogram => &[[0, 1], [1, 2], [2, 3], [3, 0], [0, 2], [1, 3]],
            Shape::Triangle => &[[0, 1], [1, 2], [2, 0]],
        };
        let mut worst = 0.0_f64;
        for ends in lines {
            let [a, b] = ends.map(|end| &corners[end]);
            for channel in 0..channels {
                let slopes = [a, b].map(|end| end.2[channel].dot(b.0 - a.0));
                let off = departure([a.1[channel], b.1[channel]], slopes).largest;
                worst = worst.max(relative(channel, off));
            }
        }
        Ok(worst)
    }
}
