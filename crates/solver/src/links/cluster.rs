//! Views of clusters from a receiver, and the choice of those that it opens.

pub(crate) mod cut;
pub(crate) mod far;
pub(crate) mod sampled;
pub(crate) mod view;
