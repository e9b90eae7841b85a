//! Many receivers as a structure of arrays.

use std::ops::Range;

use glam::DVec3;
use radgrad_numbers::lanes::lane::Lane;

use crate::error::Error;
use crate::problem::receiver::Receiver;

/// Receiver points with their normals and reflectances, one entry of each slice a receiver.
///
/// ```
/// use radgrad_core::batch::Receivers;
/// let (zero, one) = ([0.0f32; 100], [1.0f32; 100]);
/// let x: Vec<f32> = (0..100).map(|i| i as f32 * 0.1).collect();
/// let floor = Receivers::new([&x, &zero, &zero], [&zero, &zero, &one], &[0.8])?;
/// assert_eq!(floor.count(), 100);
/// # Ok::<(), radgrad_core::Error>(())
/// ```
#[derive(Debug, Clone, Copy)]
pub struct Receivers<'a, F = f64> {
    pub(super) position: [&'a [F]; 3],
    pub(super) normal: [&'a [F]; 3],
    pub(super) reflectance: &'a [F],
}

impl<'a, F: Lane> Receivers<'a, F> {
    /// Receivers at `position` (x, y, z) facing along `normal` (of any length), with one reflectance for each or one for all.
    ///
    /// ```
    /// use radgrad_core::{Error, batch::Receivers};
    /// let (zero, one) = ([0.0; 3], [1.0; 3]);
    /// assert!(Receivers::new([&zero; 3], [&zero, &zero, &one], &one).is_ok());
    /// let short = Receivers::new([&zero[..2], &zero, &zero], [&zero, &zero, &one], &one).unwrap_err();
    /// assert_eq!(short, Error::Lengths { expected: 2, given: 3 });
    /// let flat = Receivers::new([&zero; 3], [&zero; 3], &one).unwrap_err();
    /// assert!(matches!(flat, Error::InBatch { index: 0, .. })); // a normal of length 0
    /// ```
    ///
    /// # Errors
    /// If the slices differ in length, or a receiver is one that [`Receiver::new`] refuses.
    pub fn new(position: [&'a [F]; 3], normal: [&'a [F]; 3], reflectance: &'a [F]) -> Result<Self, Error> {
        let count = position[0].len();
        let lengths = position.iter().chain(&normal).map(|slice| slice.len());
        if let Some(given) = lengths.chain((reflectance.len() != 1).then_some(reflectance.len())).find(|given| *given != count) {
            return Err(Error::Lengths { expected: count, given });
        }
        let receivers = Self { position, normal, reflectance };
        // All at once first: without a branch for each it costs a tenth of the loop that follows.
        let finite =
            position.iter().chain(&normal).fold(true, |finite, slice| finite & every_entry(slice, |v| v.to_double().is_finite()));
        let [x, y, z] = normal;
        let directed = x
            .iter()
            .zip(y)
            .zip(z)
            .fold(true, |every, ((x, y), z)| every & ((*x != F::default()) | (*y != F::default()) | (*z != F::default())));
        let reflects = every_entry(reflectance, |rho| (rho >= F::default()) & (rho <= F::nearest(1.0)));
        if !(finite & directed & reflects) {
            for index in 0..count {
                receivers.receiver(index).map_err(|error| Error::InBatch { index, error: Box::new(error) })?;
            }
        }
        Ok(receivers)
    }

    /// Number of receivers.
    ///
    /// ```
    /// # use radgrad_core::batch::Receivers;
    /// assert_eq!(Receivers::new([&[0.0; 4]; 3], [&[1.0; 4]; 3], &[0.5])?.count(), 4);
    /// # Ok::<(), radgrad_core::Error>(())
    /// ```
    #[must_use]
    pub const fn count(&self) -> usize {
        self.position[0].len()
    }

    /// The receivers in a range of indices.
    pub(super) fn part(&self, range: Range<usize>) -> Self {
        let part = |slices: [&'a [F]; 3]| slices.map(|slice| &slice[range.clone()]);
        let reflectance = if self.reflectance.len() == 1 { self.reflectance } else { &self.reflectance[range.clone()] };
        Self { position: part(self.position), normal: part(self.normal), reflectance }
    }

    /// One of them.
    pub(super) fn receiver(&self, index: usize) -> Result<Receiver, Error> {
        let reflectance = self.reflectance[if self.reflectance.len() == 1 { 0 } else { index }];
        Receiver::new(Self::vector(self.position, index), Self::vector(self.normal, index), reflectance.to_double())
    }

    pub(super) fn position(&self, index: usize) -> DVec3 {
        Self::vector(self.position, index)
    }

    fn vector(components: [&[F]; 3], index: usize) -> DVec3 {
        DVec3::from(components.map(|component| component[index].to_double()))
    }
}

/// Whether all numbers have a property.
fn every_entry<F: Lane>(slice: &[F], property: impl Fn(F) -> bool) -> bool {
    slice.iter().fold(true, |every, value| every & property(*value))
}
