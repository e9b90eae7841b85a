//! Radiosity and its gradient from polygonal emitters, for C: `include/radgrad.h`.
//!
//! `radgrad_derivatives` gives the derivatives by vertices, emission, normal and reflectance.
//! `radgrad_evaluate`, `radgrad_batch_f64` and `radgrad_batch_f32` neither lock nor unwind, on arrays with any strides. Nor do they
//! allocate where a closed form or a Gauss rule answers, unless the horizon leaves more than twelve corners of an emitter far
//! away. The remaining case is a receiver on the surface of an emitter that is flat up to rounding only. An emitter, and the room
//! that batches work in, are made beforehand, and each is freed by its own function. An emitter may be used by many threads at a
//! time, a room by one.
//!
//! Lengths are in one unit of the caller's choice, emission in any unit; radiosity is in the unit of the emission, the gradient in that
//! over the unit of length. Emitters are one-sided: their vertices are counter-clockwise seen from the side that they light. Bounds are
//! those of `radgrad-core`; where a tolerance is not met, they state the error that was reached. Built by itself (`cargo build
//! --release --package radgrad-c`) the library has no arbitrary precision: double-double is the last that is tried.

mod arrays;
mod emitter;
mod evaluate;

pub use arrays::{AnswersF32, AnswersF64, ArrayF32, ArrayF64, PointsF32, PointsF64};
pub use emitter::{
    Emitter, radgrad_emitter_affine, radgrad_emitter_constant, radgrad_emitter_free, radgrad_emitter_linear, radgrad_message,
};
pub use evaluate::{
    Answer, Room, Slopes, radgrad_batch_f32, radgrad_batch_f64, radgrad_derivatives, radgrad_evaluate, radgrad_room_free,
    radgrad_room_new,
};

/// The status of a call.
#[repr(C)]
#[allow(non_camel_case_types, clippy::upper_case_acronyms, reason = "C has one name space")]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Status {
    /// All is answered.
    RADGRAD_OK = 0,
    /// A pointer that must not be NULL is.
    RADGRAD_NULL = 1,
    /// A position or a normal is not finite, a normal is 0, or a reflectance is not in [0, 1].
    RADGRAD_RECEIVER = 2,
    /// The polygon or its emission is refused: `radgrad_message` says why.
    RADGRAD_EMITTER = 3,
    /// The tolerance is not in [0, 1].
    RADGRAD_TOLERANCE = 4,
    /// A result leaves the range of its type.
    RADGRAD_RANGE = 5,
    /// The library failed as it should not: please report it.
    RADGRAD_FAULT = 6,
}

impl Status {
    /// The status for an error of the evaluation.
    fn from_error(error: &radgrad_core::Error) -> Self {
        use radgrad_core::Error;
        match error {
            Error::InBatch { error, .. } => Self::from_error(error),
            Error::PositionNotFinite { .. } | Error::Normal { .. } | Error::Reflectance { .. } => Self::RADGRAD_RECEIVER,
            Error::Tolerance { .. } => Self::RADGRAD_TOLERANCE,
            _ => Self::RADGRAD_RANGE,
        }
    }
}

/// Calls `work` and turns a panic, which must not unwind into C, into the status of a fault.
fn guarded(work: impl FnOnce() -> Status) -> Status {
    std::panic::catch_unwind(std::panic::AssertUnwindSafe(work)).unwrap_or(Status::RADGRAD_FAULT)
}
