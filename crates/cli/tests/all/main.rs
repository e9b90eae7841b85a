//! One program for all tests of the public interface, so that it is compiled and linked once.

mod audit;
mod book;
mod by_rays;
mod certified;
mod doors;
mod eval;
mod factors;
mod folder;
mod formats;
mod hostile;
mod kills;
mod scenes;
mod solve;
