//! The emission `B(y)` of an emitter as the integrals of this crate see it: affine, or any function with its gradient.
//!
//! `B(y)` is in W/m2 (or any unit, kept), its gradient `grad B(y)` in that unit over the unit of length. Only the gradient's part
//! in the emitter's plane matters: the emission is not defined off the plane.

use glam::DVec3;
use radgrad_core::{Emission, Emitter, Linear};

use crate::confidence::ConfidenceInterval;

/// What a polygon emits.
#[derive(Clone, Copy)]
pub enum SourceFunction<'a> {
    /// The affine emission of an emitter, interpolated between its vertices.
    Emitter(&'a Emitter),
    /// Any function of the point `y`.
    Function {
        /// `B(y)`.
        radiosity: &'a dyn Fn(DVec3) -> f64,
        /// `grad B(y)`; only the contour forms of Eqs. 6 and 9 ask for it.
        gradient: &'a dyn Fn(DVec3) -> DVec3,
        /// Bounds on `B(y)` over the polygon; only the distribution-free limits of Monte Carlo ask for them.
        range: ConfidenceInterval,
        /// Bound on `|grad B(y)|` there, for the same.
        steepest: f64,
    },
}

impl SourceFunction<'_> {
    /// Emission at vertex `index` if the emission is affine: what interpolation starts from.
    pub(crate) fn at_vertex(&self, index: usize) -> Option<f64> {
        let Self::Emitter(emitter) = self else { return None };
        Some(match emitter.emission() {
            Emission::Constant(value) => *value,
            Emission::Linear(Linear::AtVertices(values)) => values[index],
            Emission::Linear(Linear::Gradient { .. }) => emitter.emission_at(emitter.polygon().vertices()[index]),
            Emission::Polynomial(_) => return None,
        })
    }

    /// Bounds on the emission over the polygon: of an affine one, the extremes of the vertex values as given.
    pub(crate) fn range(&self) -> ConfidenceInterval {
        match self {
            Self::Emitter(emitter) => {
                let values: Option<Vec<f64>> = (0..emitter.polygon().vertices().len()).map(|i| self.at_vertex(i)).collect();
                let (low, high) = values.map_or((-emitter.largest_emission(), emitter.largest_emission()), |values| {
                    let extremes = (f64::INFINITY, f64::NEG_INFINITY);
                    values.into_iter().fold(extremes, |(low, high), value| (low.min(value), high.max(value)))
                });
                ConfidenceInterval { low, high }
            }
            Self::Function { range, .. } => *range,
        }
    }

    /// Bound on the length of its gradient.
    pub(crate) fn steepest(&self) -> f64 {
        match self {
            Self::Emitter(emitter) => match emitter.emission() {
                Emission::Constant(_) => 0.0,
                Emission::Linear(_) => {
                    // Its square may be out of range where it is not.
                    let gradient = emitter.emission_gradient();
                    let largest = gradient.abs().max_element();
                    if largest > 0.0 { (gradient / largest).length() * largest } else { 0.0 }
                }
                Emission::Polynomial(_) => emitter.steepest_emission(),
            },
            Self::Function { steepest, .. } => *steepest,
        }
    }

    pub(crate) fn is_constant(&self) -> bool {
        matches!(self, Self::Emitter(emitter) if matches!(emitter.emission(), Emission::Constant(_)))
    }
}

impl std::fmt::Debug for SourceFunction<'_> {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Emitter(emitter) => formatter.debug_tuple("Emitter").field(emitter).finish(),
            Self::Function { range, .. } => formatter.debug_struct("Function").field("range", range).finish_non_exhaustive(),
        }
    }
}

#[cfg(test)]
mod tests {
    use radgrad_core::Polygon;

    use super::*;

    #[test]
    fn the_slope_of_an_emission_is_known_at_any_scale() {
        for power in [2f64.powi(-900), 1.0, 2f64.powi(900)] {
            let triangle = Polygon::new([DVec3::ZERO, DVec3::X, DVec3::Y].map(|v| v * power).to_vec()).unwrap();
            let emitter = Emitter::new(triangle, Emission::at_vertices(vec![1.0, 4.0, 5.0])).unwrap();
            assert_eq!(SourceFunction::Emitter(&emitter).steepest(), 5.0 / power);
        }
    }

    #[test]
    fn the_range_on_a_needle_is_that_of_its_vertex_values() {
        let (a, b, c) = (DVec3::new(0.1, -0.2, 0.3), DVec3::new(0.9, 0.3, 0.1), DVec3::new(0.2, 0.8, 0.7));
        let needle = Polygon::new(vec![a, b, a.lerp(b, 0.3) + (c - a) * 1e-10]).unwrap();
        let emitter = Emitter::new(needle, Emission::at_vertices(vec![1.0, 0.5, 2.0])).unwrap();
        assert_eq!(SourceFunction::Emitter(&emitter).range(), ConfidenceInterval { low: 0.5, high: 2.0 });
        // The gradient is steep: through rounded differences of coordinates the values do not come back.
        let back = [0, 1, 2].map(|i| emitter.emission_at(emitter.polygon().vertices()[i]));
        assert_ne!(back, [1.0, 0.5, 2.0]);
    }
}
