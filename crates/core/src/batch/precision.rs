//! Single or double precision.

use crate::lanes::lane::Lane;

/// Single or double precision: `f32` or `f64`.
#[allow(private_bounds, reason = "what lanes need of a number is not for others to implement")]
pub trait Precision: Lane {}

impl Precision for f64 {}
impl Precision for f32 {}
