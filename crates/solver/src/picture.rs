//! Solutions made continuous for pictures: no bound is claimed.

pub(crate) mod hermite;
pub(crate) mod reconstruction;
