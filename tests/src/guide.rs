//! The guide of `docs/guide`, whose programs run as tests of this documentation.

#[doc = include_str!("../../docs/guide/evaluate.md")]
pub mod evaluate {}

#[doc = include_str!("../../docs/guide/trust.md")]
pub mod trust {}

#[doc = include_str!("../../docs/guide/speed.md")]
pub mod speed {}

#[doc = include_str!("../../docs/guide/scenes.md")]
pub mod scenes {}
