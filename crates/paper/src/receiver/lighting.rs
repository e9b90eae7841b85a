//! Light on a receiver: emitters, and occluders between.

use radgrad_core::{DVec3, Emitter, Polygon, Receiver, evaluate_to};

use crate::error::Error;

/// The light on a receiver. Radiosities are in the unit of the emissions.
///
/// ```
/// use radgrad_core::{DVec3, Emission, Emitter, Polygon};
/// use radgrad_paper::receiver::Lighting;
/// let corners = [(0.0, 0.0), (0.0, 1.0), (1.0, 1.0), (1.0, 0.0)].map(|(x, y)| DVec3::new(x, y, 1.0));
/// let lamp = Emitter::new(Polygon::new(corners.to_vec())?, Emission::Constant(1.0))?;
/// let light = Lighting { emitters: &[lamp], occluders: &[], reflectance: 1.0, tolerance: 1e-9 };
/// let corner = light.sample(DVec3::ZERO, DVec3::Z)?;
/// assert!((corner.value - 0.138_531_605_994_893).abs() <= corner.value_error);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, Copy)]
pub struct Lighting<'a> {
    /// The emitters.
    pub emitters: &'a [Emitter],
    /// Occluders: planar polygons, opaque from both sides.
    pub occluders: &'a [Polygon],
    /// Reflectance of the receiver, in [0, 1].
    pub reflectance: f64,
    /// Relative error that each emitter's part may have.
    pub tolerance: f64,
}

/// Radiosity and gradient at a point, with their bounds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sample {
    /// The point.
    pub position: DVec3,
    /// Radiosity.
    pub value: f64,
    /// Its gradient with respect to the position, in that unit over the unit of length, all three components.
    pub gradient: DVec3,
    /// Proven bound on the error of `value`.
    pub value_error: f64,
    /// Proven bound on the Euclidean norm of the error of `gradient`.
    pub gradient_error: f64,
}

impl Lighting<'_> {
    /// Samples a point that faces along `normal`.
    ///
    /// # Errors
    /// If the reflectance or the tolerance is not in [0, 1], or a result over- or underflows.
    pub fn sample(&self, position: DVec3, normal: DVec3) -> Result<Sample, Error> {
        let refused = |source| Error::Sample { position, source };
        let receiver = Receiver::new(position, normal, self.reflectance).map_err(refused)?;
        let mut sample = Sample { position, value: 0.0, gradient: DVec3::ZERO, value_error: 0.0, gradient_error: 0.0 };
        // Each sum rounds by half an epsilon of its result: of all magnitudes at most; a gradient in three components.
        let rounding = f64::EPSILON * self.emitters.len().saturating_sub(1) as f64;
        for emitter in self.emitters {
            let answer = evaluate_to(&receiver, emitter, self.occluders, self.tolerance).map_err(refused)?;
            sample.value += answer.radiosity;
            sample.gradient += answer.gradient;
            sample.value_error += answer.radiosity_error + rounding * answer.radiosity.abs();
            sample.gradient_error += answer.gradient_error + rounding * answer.gradient.length();
        }
        Ok(sample)
    }
}
