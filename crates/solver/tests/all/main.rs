//! One program for all tests of the public interface, so that it is compiled and linked once.

mod coverage;
mod exact;
mod fewer_elements;
mod pictures;
mod prepared;
mod shadow_lines;
mod shadows;
mod textures;
mod zatz;
