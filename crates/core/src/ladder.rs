//! The answer to a tolerance: from the cheapest method to the dearest.

pub(crate) mod answer;
pub(crate) mod caller_units;
pub(crate) mod components;
#[cfg(feature = "arbitrary-precision")]
pub(crate) mod digits;
pub(crate) mod irradiance;
pub(crate) mod on_surface;
pub(crate) mod quantities;
pub(crate) mod rungs;
pub(crate) mod sum;
pub(crate) mod value;
