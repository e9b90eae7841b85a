//! The sums over the edges of a constant emitter.

use fearless_simd::Simd;
use radgrad_numbers::lanes::lane::{Lane, Lanes, constant};
use radgrad_numbers::vec3::Vec3;

/// The sums over the edges.
pub(super) struct ConstantSums<S: Simd, F: Lane> {
    /// `sum g n1.N`.
    pub(super) value: Lanes<S, F>,
    /// `sum (N/S) 2 (cc p1 + cs p2)`.
    pub(super) gradient: Vec3<Lanes<S, F>>,
    /// `sum g`.
    pub(super) angles: Lanes<S, F>,
    /// The largest `1/S^2`.
    pub(super) nearest: Lanes<S, F>,
}

impl<S: Simd, F: Lane> ConstantSums<S, F> {
    #[inline(always)]
    pub(super) fn new(simd: S) -> Self {
        let zero = constant(simd, 0.0);
        Self { value: zero, gradient: Vec3::new(zero, zero, zero), angles: zero, nearest: zero }
    }
}
