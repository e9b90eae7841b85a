//! One program for all tests of the public interface, so that it is compiled and linked once.

mod closure;
mod factors;
mod files;
mod hostile;
mod overlaps;
mod prepared;
mod rounded;
mod scales;
mod two_polygons;
