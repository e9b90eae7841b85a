//! Tests of links and clusters by whole solutions.

mod clusters;
mod edges;
mod gradients;
mod links;
mod plates;
mod space;
mod tiles;
mod unseen;
mod white;
