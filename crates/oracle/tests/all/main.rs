//! One program for all tests of the public interface, so that it is compiled and linked once.

mod enclosure;
mod forms_agree;
mod monte_carlo;
mod occluded;
mod scales;
mod scene;
mod silent_failures;
