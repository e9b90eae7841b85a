//! One program for all tests of what is public, so that it is compiled and linked once.

mod enclosure;
mod forms_agree;
mod monte_carlo;
mod occluded;
mod scene;
mod silent_failures;
