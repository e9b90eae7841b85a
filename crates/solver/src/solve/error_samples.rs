//! Samples of the error of polynomials, kept from one point to the next.

use std::collections::HashMap;
use std::sync::{Mutex, PoisonError};

use radgrad_core::DVec3;

use crate::error::Error;

/// Samples that are kept at most: some 30 MB.
const MOST_KEPT: usize = 1 << 18;

/// A sample of `C - q`, in each channel; none where q is not known.
pub(super) type Sample = Option<Vec<f64>>;

/// Samples at places of leaves, by the leaf and the place's bits.
#[derive(Debug, Default)]
pub(super) struct ErrorSamples(Mutex<HashMap<(usize, [u64; 3]), Sample>>);

impl ErrorSamples {
    /// Gives the sample at a place of a leaf: the one that is kept, or else the one that `found` makes, which is then kept.
    pub(super) fn get_or_evaluate(
        &self,
        leaf: usize,
        place: DVec3,
        evaluate: impl FnOnce() -> Result<Sample, Error>,
    ) -> Result<Sample, Error> {
        let key = (leaf, place.to_array().map(f64::to_bits));
        let cached = self.0.lock().unwrap_or_else(PoisonError::into_inner).get(&key).cloned();
        if let Some(sample) = cached {
            return Ok(sample);
        }
        let sample = evaluate()?;
        let mut samples = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        if samples.len() < MOST_KEPT {
            samples.insert(key, sample.clone());
        }
        drop(samples);
        Ok(sample)
    }
}
