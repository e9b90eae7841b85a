//! Derivatives of many receivers' radiosity.

use crate::batch::Engine;
use crate::batch::receivers::Receivers;
use crate::derivatives::{Derivatives, derivatives};
use crate::error::Error;
use crate::problem::emission::Emitter;
use crate::problem::polygon::Polygon;

impl Engine {
    /// Derivatives of each receiver's radiosity by everything that shapes it: those of [`crate::derivatives()`], bit for bit, in the order
    /// of the receivers.
    ///
    /// ```
    /// use radgrad_core::batch::{Engine, Receivers};
    /// use radgrad_core::{DVec3, Emission, Emitter, Polygon, Receiver, derivatives};
    /// let corners = [(0.0, 0.0), (0.0, 1.0), (1.0, 1.0), (1.0, 0.0)].map(|(x, y)| DVec3::new(x, y, 1.0));
    /// let lamp = Emitter::new(Polygon::new(corners.to_vec())?, Emission::Constant(1.0))?;
    /// let (x, zero, one) = ([0.0, 0.5], [0.0; 2], [1.0; 2]);
    /// let floor = Receivers::new([&x, &x, &zero], [&zero, &zero, &one], &[0.8])?; // under a corner and under the middle
    /// let found = Engine::new().threads().derivatives(&floor, &lamp, &[], 1e-12)?;
    /// assert_eq!(found[1], derivatives(&Receiver::new(DVec3::new(0.5, 0.5, 0.0), DVec3::Z, 0.8)?, &lamp, &[], 1e-12)?);
    /// assert!(found[0].vertices[2].value.x > 0.0, "a larger lamp gives more");
    /// # Ok::<(), radgrad_core::Error>(())
    /// ```
    ///
    /// # Errors
    /// As of [`crate::derivatives()`], of the first receiver that has none: [`Error::InBatch`] with its index; or if the tolerance is not
    /// in [0, 1].
    pub fn derivatives<'a>(
        &self,
        receivers: &Receivers<'_>,
        emitter: &Emitter,
        occluders: impl IntoIterator<Item = &'a Polygon>,
        tolerance: f64,
    ) -> Result<Vec<Derivatives>, Error> {
        crate::ladder::components::within_reach(tolerance)?;
        let occluders: Vec<&Polygon> = occluders.into_iter().collect();
        self.each_derivatives(receivers, &|index| {
            let receiver = receivers.receiver(index);
            let slopes = receiver.and_then(|receiver| derivatives(&receiver, emitter, occluders.iter().copied(), tolerance));
            slopes.map_err(|error| Error::InBatch { index, error: Box::new(error) })
        })
    }

    fn each_derivatives(
        &self,
        receivers: &Receivers<'_>,
        one: &(dyn Fn(usize) -> Result<Derivatives, Error> + Sync),
    ) -> Result<Vec<Derivatives>, Error> {
        #[cfg(feature = "threads")]
        if self.threads {
            use rayon::prelude::*;
            // All, so that the first that is refused is told, on however many threads.
            let slopes: Vec<_> = (0..receivers.count()).into_par_iter().map(one).collect();
            return slopes.into_iter().collect();
        }
        (0..receivers.count()).map(one).collect()
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::problem::emission::Emission;
    use crate::problem::receiver::Receiver;

    #[test]
    fn many_are_answered_as_one_by_one() {
        let triangle = |z: f64| Polygon::new(vec![DVec3::new(0.0, 0.0, z), DVec3::new(0.5, 0.8, z), DVec3::new(1.0, 0.0, z)]);
        let screen = triangle(0.25).unwrap();
        let count = 60;
        let x: Vec<f64> = (0..count).map(|i| f64::from(i) * 0.02).collect();
        let (y, zero, one) = (vec![0.1; x.len()], vec![0.0; x.len()], vec![1.0; x.len()]);
        let floor = Receivers::new([&x, &y, &zero], [&zero, &zero, &one], &[0.7]).unwrap();
        for emission in [Emission::Constant(2.0), Emission::at_vertices(vec![1.0, 2.0, 4.0])] {
            let lamp = Emitter::new(triangle(1.0).unwrap(), emission).unwrap();
            for occluders in [&[][..], std::slice::from_ref(&screen)] {
                let alone: Vec<_> = (0..x.len())
                    .map(|i| {
                        let receiver = Receiver::new(DVec3::new(x[i], y[i], 0.0), DVec3::Z, 0.7).unwrap();
                        derivatives(&receiver, &lamp, occluders, 1e-9).unwrap()
                    })
                    .collect();
                for engine in [Engine::new(), Engine::new().threads()] {
                    assert_eq!(engine.derivatives(&floor, &lamp, occluders, 1e-9).unwrap(), alone);
                }
            }
            assert!(matches!(Engine::new().derivatives(&floor, &lamp, &[], 2.0), Err(Error::Tolerance { .. })));
        }
    }
}
