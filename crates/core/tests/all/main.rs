//! One program for all tests of the public interface, so that it is compiled and linked once.

mod batch;
mod derivatives;
mod digits;
mod emitter_tree;
mod evaluate;
mod hessian;
mod irradiance;
mod not_flat;
mod occluders;
mod on_surface;
mod polynomials;
mod problem;
mod range;
mod scales;
mod value;
