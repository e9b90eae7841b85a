//! The product of the factors with numbers of faces, for many of them: a few bytes a pair are all that is held.

use super::limits::Chances;
use super::pairs::RayFactors;
use crate::error::Error;
use crate::extremes::largest as larger;

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
        operator.error = 2.0 * (operator.chances().deviation(counted, 1.0) + moved)
            + operator.near_errors(&ones).into_iter().fold(0.0, larger);
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
        self.apply_many(q, 1)
    }

    /// `F Q` for so many columns, face by face: the same as one after the other, in less time.
    ///
    /// # Errors
    /// If there are not so many finite numbers for each face.
    pub fn apply_many(&self, q: &[f64], columns: usize) -> Result<Vec<f64>, Error> {
        self.of_columns(q, columns)
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
                    *error += self.chances().deviation(sum, peak) + moved;
                }
            }
        }
        Ok(Certified { product, error })
    }

    /// The product of the counted pairs as they were counted: for each face a sum of independent numbers, each up to `max q / n`.
    fn plain(&self, q: &[f64]) -> Vec<f64> {
        self.factors.exchanged(q).iter().zip(&self.factors.known.areas).map(|(sum, area)| sum / area).collect()
    }

    /// Of a product there are two sums a face, of either sign, that hold together: far fewer than the pairs, which have intervals of their own.
    pub(super) fn chances(&self) -> Chances {
        let (sums, confidence) = (2.0 * self.len() as f64, self.factors.known.confidence);
        Chances { rays: self.factors.known.rays, logarithm: libm::log(2.0 * larger(sums, 1.0) / (1.0 - confidence)) }
    }

    /// How far the multipliers of the counted pairs move a product of numbers not below 0.
    pub(super) fn moved(&self, q: &[f64]) -> Vec<f64> {
        let scale = self.factors.scale();
        // |x_i x_j - 1| <= |x_i - 1| x_j + |x_j - 1|
        let [by_own, by_other] = [|x: f64| x, |x: f64| (x - 1.0).abs()]
            .map(|of: fn(f64) -> f64| self.plain(&q.iter().zip(scale).map(|(q, x)| q * of(*x)).collect::<Vec<_>>()));
        by_own.iter().zip(by_other).zip(scale).map(|((own, other), x)| own * (x - 1.0).abs() + other).collect()
    }

    /// By how much the bounds of near pairs may move a product.
    pub(super) fn near_errors(&self, q: &[f64]) -> Vec<f64> {
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

/// The product with some columns at once, by which that with any number of them is found.
pub(super) trait Products {
    fn faces(&self) -> usize;

    fn products<const K: usize>(&self, q: &[[f64; K]]) -> Vec<[f64; K]>;

    /// `F Q` of so many columns, face by face.
    fn of_columns(&self, q: &[f64], columns: usize) -> Result<Vec<f64>, Error> {
        check(q, self.faces(), columns)?;
        Ok(match columns {
            0 => Vec::new(),
            1 => self.products::<1>(q.as_chunks().0).into_flattened(),
            _ => in_eights(q, columns, |q| self.products(q)),
        })
    }
}

impl Products for FactorOperator {
    fn faces(&self) -> usize {
        self.len()
    }

    fn products<const K: usize>(&self, q: &[[f64; K]]) -> Vec<[f64; K]> {
        let (scale, areas) = (self.factors.scale(), &self.factors.known.areas);
        let scaled: Vec<[f64; K]> = q.iter().zip(scale).map(|(q, x)| q.map(|q| q * x)).collect();
        let [mut counted, near] = self.factors.products([&scaled, q]);
        for (i, sums) in counted.iter_mut().enumerate() {
            for (sum, near) in sums.iter_mut().zip(near[i]) {
                *sum = (*sum * scale[i] + near) / areas[i];
            }
        }
        counted
    }
}

/// Lists of numbers that are multiplied at once.
const AT_ONCE: usize = 8;

/// Products of columns, some at once.
fn in_eights(q: &[f64], columns: usize, products: impl Fn(&[[f64; AT_ONCE]]) -> Vec<[f64; AT_ONCE]>) -> Vec<f64> {
    let mut rows = vec![0.0; q.len()];
    for first in (0..columns).step_by(AT_ONCE) {
        let count = AT_ONCE.min(columns - first);
        let of = |row: &[f64]| std::array::from_fn(|k| if k < count { row[first + k] } else { 0.0 });
        let chosen: Vec<[f64; AT_ONCE]> = q.chunks_exact(columns).map(of).collect();
        for (row, sums) in rows.chunks_exact_mut(columns).zip(products(&chosen)) {
            row[first..first + count].copy_from_slice(&sums[..count]);
        }
    }
    rows
}

/// Refuses a list that is not so many finite numbers for each of so many faces.
fn check(q: &[f64], faces: usize, columns: usize) -> Result<(), Error> {
    let expected = || match columns {
        1 => format!("a finite number for each of the {faces} faces"),
        _ => format!("{columns} finite numbers for each of the {faces} faces"),
    };
    if faces.checked_mul(columns) != Some(q.len()) {
        return Err(Error::expected(expected(), q.len().to_string()));
    }
    match q.iter().position(|q| !q.is_finite()) {
        Some(at) => Err(Error::expected(expected(), format!("{} for face {}", q[at], at / columns.max(1)))),
        None => Ok(()),
    }
}
