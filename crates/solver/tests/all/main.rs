//! One program for all tests of what is public, so that it is compiled and linked once.

mod coverage;
mod exact;
mod fewer_elements;
mod linking;
mod receiver;
mod reconstruction;
mod shadows;
mod textures;
mod zatz;
