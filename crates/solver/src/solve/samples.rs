//! Samples of a light on an element, by which it is judged.

use radgrad_core::DVec3;

/// Samples of the irradiance on an element, in each channel: at the nodes, and with gradients at the corners moved inward, if the
/// basis is below cubic.
#[derive(Debug, Clone)]
pub(crate) struct Samples {
    pub(super) nodes: Vec<Vec<f64>>,
    pub(super) corners: Vec<(Vec<f64>, Vec<DVec3>)>,
}

impl Samples {
    /// Those of two lights together.
    pub(crate) fn with(&self, other: &Self) -> Self {
        let mut sum = self.clone();
        let add = |a: &mut Vec<f64>, b: &Vec<f64>| a.iter_mut().zip(b).for_each(|(a, b)| *a += b);
        sum.nodes.iter_mut().zip(&other.nodes).for_each(|(a, b)| add(a, b));
        for (a, b) in sum.corners.iter_mut().zip(&other.corners) {
            add(&mut a.0, &b.0);
            a.1.iter_mut().zip(&b.1).for_each(|(a, b)| *a += *b);
        }
        sum
    }
}
