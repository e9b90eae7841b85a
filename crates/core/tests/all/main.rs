//! One program for all tests of the public interface, so that it is compiled and linked once.

mod batch;
mod digits;
mod emitter_tree;
mod hessian;
mod irradiance;
mod not_flat;
mod occluders;
mod on_surface;
mod polynomials;
mod range;
mod value;
