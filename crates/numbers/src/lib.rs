//! Numbers on which a closed form has one definition: doubles, double-doubles, balls with a running bound, numbers of any precision,
//! and several doubles side by side on the lanes of a vector.
//!
//! A formula is written on [`Arithmetic`](arithmetic::Arithmetic), or on [`Real`](real::Real) where it takes decisions. Its operations
//! and their order are then the same on each number: a [`Ball`](ball::Ball) encloses the exact result and has the digits of the plain
//! evaluation for its middle, and lanes have those of one number alone. Errors are stated in units of roundoff, relative to the result:
//! 2^-53 for doubles ([`ROUNDOFF`](number::ROUNDOFF)), 2^-103 for double-doubles.
//!
//! ```
//! use radgrad_numbers::arithmetic::Arithmetic;
//! use radgrad_numbers::ball::Ball;
//! use radgrad_numbers::double_double::DoubleDouble;
//! use radgrad_numbers::real::Real;
//!
//! /// The angle at the origin of a right triangle, and the logarithm of its hypotenuse.
//! fn angle_and_logarithm<T: Real>(x: T, y: T) -> [T; 2] {
//!     [y.atan2(x), (x * x + y * y).sqrt().ln()]
//! }
//!
//! let plain = angle_and_logarithm(0.3, 0.4);
//! let bounded = angle_and_logarithm(Ball::<f64>::exact(0.3), Ball::exact(0.4));
//! let fine = angle_and_logarithm(Ball::<DoubleDouble>::exact(0.3), Ball::exact(0.4));
//! for ((plain, bounded), fine) in plain.into_iter().zip(bounded).zip(fine) {
//!     assert_eq!(bounded.value(), plain);
//!     assert!((fine.value() - plain).abs() <= bounded.value_error());
//!     assert!(bounded.value_error() < 1e-14 && fine.error() < 1e-28);
//! }
//! ```
//!
//! The crate serves `radgrad-core`. No unsafe code; vectors are those of the crate [`fearless_simd`], numbers of any precision those of
//! `astro-float` (feature `arbitrary-precision`, on by default).

pub mod arc_tangent;
pub mod arithmetic;
pub mod ball;
#[cfg(feature = "arbitrary-precision")]
pub mod big;
pub mod dilogarithm;
pub mod double_double;
pub mod double_double_on_lanes;
pub mod effort;
pub mod exact;
pub mod lanes;
pub mod logarithm;
#[cfg(all(test, feature = "arbitrary-precision"))]
mod near_ties;
pub mod number;
pub mod offset;
pub mod power;
pub mod radius;
pub mod real;
pub mod series;
pub mod vec3;
