//! The product of the factors with numbers of faces, for many of them: a few bytes a pair are all that is held.

use super::super::larger;
use super::limits::sum_limits;
use super::pairs::RayFactors;
use crate::Error;

/// `F q`, the amounts that faces get of the amounts that all send, by [`RayFactors`].
///
/// ```
/// use radgrad_scene::{Degenerate, FactorOperator, FormFactors, RaySettings, Scene};
/// # let file = concat!(env!("CARGO_MANIFEST_DIR"), "/../../data/scenes/two_blocks.obj");
/// let scene = Scene::read(file, Degenerate::Refuse)?;
/// let factors = FormFactors::new(&scene)?;
/// let settings = RaySettings { rays: Some(1000), ..RaySettings::default() };
/// let counted = factors.count_rays(0..factors.faces().len(), &settings, |_| ())?;
/// let operator = FactorOperator::new(factors.by_rays(counted, &settings)?);
/// let sent = vec![1.0; scene.faces().len()];
/// let got = operator.certified(&sent)?;
/// assert_eq!(got.product, operator.apply(&sent)?);
/// assert!(got.error.iter().all(|error| *error < operator.error())); // of numbers up to 1
/// # Ok::<(), radgrad_scene::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct FactorOperator {
    factors: RayFactors,
    error: f64,
}

/// A product, and how far it may be off.
#[derive(Debug, Clone, PartialEq)]
pub struct Certified {
    /// `F q`.
    pub product: Vec<f64>,
    /// Its error in each face is at most this, in all of them with the confidence of the factors, if the numbers were chosen without looking
    /// at the counts.
    pub error: Vec<f64>,
}

impl FactorOperator {
    /// The operator of some factors.
    #[must_use]
    pub fn new(factors: RayFactors) -> Self {
        let mut operator = Self { factors, error: 0.0 };
        // The counted sum of numbers from 0 to 1 is at most that of ones; and there are two signs.
        let ones = vec![1.0; operator.factors.len()];
        let counted = operator.plain(&ones).into_iter().fold(0.0, larger);
        let moved = operator.moved(&ones).into_iter().fold(0.0, larger);
        operator.error =
            2.0 * (operator.chance(counted, 1.0) + moved) + operator.near_errors(&ones).into_iter().fold(0.0, larger);
        operator
    }

    /// The factors.
    #[must_use]
    pub const fn factors(&self) -> &RayFactors {
        &self.factors
    }

    /// Number of faces.
    #[must_use]
    pub fn len(&self) -> usize {
        self.factors.len()
    }

    /// Whether the scene has no face.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.factors.is_empty()
    }

    /// The bound of a product's error in each face, over the largest of the numbers, with the confidence of the factors: whatever they are, if they
    /// were chosen without looking at the counts. [`Self::certified`] has narrower ones.
    #[must_use]
    pub const fn error(&self) -> f64 {
        self.error
    }

    /// `F q`, on all cores.
    ///
    /// # Errors
    /// If there is not one finite number for each face.
    pub fn apply(&self, q: &[f64]) -> Result<Vec<f64>, Error> {
        self.check(q)?;
        let scale = self.factors.scale();
        let scaled: Vec<f64> = q.iter().zip(scale).map(|(q, x)| q * x).collect();
        let [mut counted, near] = self.factors.products([&scaled, q]);
        let areas = &self.factors.known.areas;
        for (i, sum) in counted.iter_mut().enumerate() {
            *sum = (*sum * scale[i] + near[i]) / areas[i];
        }
        Ok(counted)
    }

    /// The same with an error for each face.
    ///
    /// # Errors
    /// As [`Self::apply`].
    pub fn certified(&self, q: &[f64]) -> Result<Certified, Error> {
        let product = self.apply(q)?;
        let mut error = self.near_errors(q);
        for sign in [1.0, -1.0] {
            let part: Vec<f64> = q.iter().map(|q| larger(sign * q, 0.0)).collect();
            let peak = part.iter().copied().fold(0.0, larger);
            if peak > 0.0 {
                let plain = self.plain(&part);
                for ((error, sum), moved) in error.iter_mut().zip(plain).zip(self.moved(&part)) {
                    *error += self.chance(sum, peak) + moved;
                }
            }
        }
        Ok(Certified { product, error })
    }

    fn check(&self, q: &[f64]) -> Result<(), Error> {
        let expected = || format!("a finite number for each of the {} faces", self.len());
        if q.len() != self.len() {
            return Err(Error::expected(expected(), q.len().to_string()));
        }
        match q.iter().position(|q| !q.is_finite()) {
            Some(face) => Err(Error::expected(expected(), format!("{} for face {face}", q[face]))),
            None => Ok(()),
        }
    }

    /// The product of the counted pairs as they were counted: for each face a sum of independent numbers, each up to `max q / n`.
    fn plain(&self, q: &[f64]) -> Vec<f64> {
        let [sums, _] = self.factors.products([q, &vec![0.0; q.len()]]);
        sums.iter().zip(&self.factors.known.areas).map(|(sum, area)| sum / area).collect()
    }

    /// How far such a sum may be off: of numbers up to `most`, not below 0, by Chernoff's limits.
    fn chance(&self, sum: f64, most: f64) -> f64 {
        let one = most / self.factors.known.rays as f64;
        let counted = sum / one;
        let [low, high] = sum_limits(counted, self.factors.known.logarithm);
        one * larger(high - counted, counted - low)
    }

    /// How far the multipliers of the counted pairs move a product of numbers not below 0.
    fn moved(&self, q: &[f64]) -> Vec<f64> {
        let scale = self.factors.scale();
        // |x_i x_j - 1| <= |x_i - 1| x_j + |x_j - 1|
        let [by_own, by_other] = [|x: f64| x, |x: f64| (x - 1.0).abs()]
            .map(|of: fn(f64) -> f64| self.plain(&q.iter().zip(scale).map(|(q, x)| q * of(*x)).collect::<Vec<_>>()));
        by_own.iter().zip(by_other).zip(scale).map(|((own, other), x)| own * (x - 1.0).abs() + other).collect()
    }

    /// By how much the bounds of near pairs may move a product.
    fn near_errors(&self, q: &[f64]) -> Vec<f64> {
        let mut errors = vec![0.0; q.len()];
        for (i, near) in self.factors.near.iter().enumerate() {
            for near in near {
                let j = near.face as usize;
                errors[i] += near.error * q[j].abs();
                errors[j] += near.error * q[i].abs();
            }
        }
        errors.iter().zip(&self.factors.known.areas).map(|(error, area)| error / area).collect()
    }
}
