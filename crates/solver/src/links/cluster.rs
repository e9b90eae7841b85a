//! What a receiver sees of clusters, and which of them it opens.

pub(crate) mod cut;
pub(crate) mod far;
pub(crate) mod glow;
pub(crate) mod screens;
pub(crate) mod view;
