//! The emission `B(y)` of an emitter as the integrals of this crate see it: affine, or any function with its gradient.
//!
//! Units as in [`crate::emission_function`].

use radgrad_core::{Emission, Emitter, Linear};

use crate::Error;
use crate::confidence::ConfidenceInterval;
use crate::emission_function::{EmissionBounds, EmissionFunction};

/// The emission of a polygon.
#[derive(Debug, Clone, Copy)]
pub enum SourceFunction<'a> {
    /// The affine emission of an emitter, interpolated between its vertices.
    Emitter(&'a Emitter),
    /// Any function of the point `y`.
    Function(&'a EmissionFunction<'a>),
}

impl SourceFunction<'_> {
    /// Emission at vertex `index` if the emission is affine, for interpolation.
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
    pub(crate) fn bounds(&self) -> Result<EmissionBounds, Error> {
        Ok(match self {
            Self::Emitter(emitter) => {
                let values: Option<Vec<f64>> = (0..emitter.polygon().vertices().len()).map(|i| self.at_vertex(i)).collect();
                let (low, high) = values.map_or((-emitter.largest_emission(), emitter.largest_emission()), |values| {
                    let extremes = (f64::INFINITY, f64::NEG_INFINITY);
                    values.into_iter().fold(extremes, |(low, high), value| (low.min(value), high.max(value)))
                });
                EmissionBounds { range: ConfidenceInterval { low, high }, steepest: emitter.steepest_emission() }
            }
            Self::Function(function) => function.bounds.ok_or(Error::EmissionPart { missing: "bounds", asker: "Monte Carlo" })?,
        })
    }

    /// Width of the smallest feature.
    pub(crate) fn detail(&self) -> f64 {
        match self {
            Self::Emitter(_) => f64::INFINITY,
            Self::Function(function) => function.detail,
        }
    }

    /// Refuses a function without the parts that `asker` needs.
    pub(crate) fn check(&self, needs_gradient: bool, asker: &'static str) -> Result<(), Error> {
        let Self::Function(function) = self else { return Ok(()) };
        function.check()?;
        if needs_gradient && function.gradient.is_none() {
            return Err(Error::EmissionPart { missing: "gradient", asker });
        }
        Ok(())
    }

    pub(crate) fn is_constant(&self) -> bool {
        matches!(self, Self::Emitter(emitter) if matches!(emitter.emission(), Emission::Constant(_)))
    }
}

#[cfg(test)]
mod tests {
    use radgrad_core::{DVec3, Polygon};

    use super::*;

    #[test]
    fn the_slope_of_an_emission_is_known_at_any_scale() {
        for power in [2f64.powi(-900), 1.0, 2f64.powi(900)] {
            let triangle = Polygon::new([DVec3::ZERO, DVec3::X, DVec3::Y].map(|v| v * power).to_vec()).unwrap();
            let emitter = Emitter::new(triangle, Emission::at_vertices(vec![1.0, 4.0, 5.0])).unwrap();
            assert_eq!(SourceFunction::Emitter(&emitter).bounds().unwrap().steepest, 5.0 / power);
        }
    }

    #[test]
    fn the_range_on_a_needle_is_that_of_its_vertex_values() {
        let (a, b, c) = (DVec3::new(0.1, -0.2, 0.3), DVec3::new(0.9, 0.3, 0.1), DVec3::new(0.2, 0.8, 0.7));
        let needle = Polygon::new(vec![a, b, a.lerp(b, 0.3) + (c - a) * 1e-10]).unwrap();
        let emitter = Emitter::new(needle, Emission::at_vertices(vec![1.0, 0.5, 2.0])).unwrap();
        let bounds = SourceFunction::Emitter(&emitter).bounds().unwrap();
        assert_eq!(bounds.range, ConfidenceInterval { low: 0.5, high: 2.0 });
        // The gradient is steep: through rounded differences of coordinates the values do not come back.
        let back = [0, 1, 2].map(|i| emitter.emission_at(emitter.polygon().vertices()[i]));
        assert_ne!(back, [1.0, 0.5, 2.0]);
    }
}
