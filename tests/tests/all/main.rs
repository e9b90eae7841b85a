//! One program for all tests of the public interface, so that it is compiled and linked once.

mod architecture;
mod contact;
mod cornell;
mod differences;
mod digits;
mod emission_functions;
mod errata;
mod hessian;
mod hundred_digits;
mod layers;
mod listed;
mod names;
mod polynomial_emission;
mod properties;
mod readme;
mod reference_cases;
mod reference_values;
mod releases;
mod scale;
mod traps;
