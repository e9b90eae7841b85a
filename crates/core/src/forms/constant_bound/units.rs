//! The constants of the derivation, in units of roundoff unless it says otherwise, in the order of its steps. `cargo xtask prove`
//! has gappa prove each from the recorded code and from those above it.

use radgrad_numbers::number::Number;

/// Pays for terms of second order in the errors; a factor.
pub const SECOND_ORDER: f64 = 1.001;
/// Largest relative errors of w and of crossing points with which anything is bounded; no unit.
pub const MOST_DISPLACED: f64 = 1e-6;
/// Error of the fraction of a cut edge in its cross product.
pub const FRACTION: f64 = 1.0;

/// Error of a component of w before its last rounding, over the sum of the sizes of its two products.
pub const PRODUCTS_OF_MOMENT: f64 = 3.0;
/// Of `|w|`, relative, beside `ew`.
pub const MOMENT: f64 = 2.5;
/// Of `1/|w|`, likewise; N errs by as much along itself.
pub const INVERSE_MOMENT: f64 = 3.5;
/// Of `1/S`, likewise.
pub const NEARNESS: f64 = 8.0;
/// Error of q, relative, beside eta.
pub const INVERSE_DISTANCE: f64 = 4.5;
/// Error of the product of two vectors, one rounding a component, over the product of their lengths.
pub const INLINE: f64 = 5.0;
/// Of (inline, across) as an angle, of its sine; beside `ew`, `2 eta` and the fraction.
pub const ANGLE: f64 = 8.0;
/// Error of the arc tangent, relative.
pub const ARC_TANGENT: f64 = <f64 as Number>::LIBRARY_UNITS;
/// Error of the products in `n1.(g N)`, relative.
pub const PRODUCTS: f64 = 2.0;
/// Error of c, relative to its size, beside [`INLINE`] and `2 eta`.
pub const COSINE: f64 = 5.5;
/// Of `c + c'` and of `c' - c`, beside `4 eta`: of 1, and of the sum of their sizes.
pub const COSINES: [f64; 2] = [10.0, 6.5];
/// Error of the sine, relative, beside `ew`, `2 eta` and the fraction.
pub const SINE: f64 = 14.0;
/// Of `1 + cos`, relative, beside `4 eta`.
pub const ONE_AND_COSINE: f64 = 9.0;
/// Error of the first term of a weight, relative, for given `g + sin g` and `c + c'`; beside `5 eta`.
pub const CHI_TERM: f64 = 19.0;
/// Error of psi, relative, for a given g.
pub const PSI: f64 = 3.0;
/// Largest `psi/g` up to a quarter turn; no unit.
pub const LARGEST_PSI: f64 = 0.091;
/// Largest `psi'` up to a quarter turn; no unit.
pub const SLOPE_OF_PSI: f64 = 0.11;
/// Error of the second term of a weight, over `Q g^2`, for given g and `c' - c`; beside `0.091 eta`.
pub const PSI_TERM: f64 = 0.9;
/// Error of a weight's sum and its product with N, relative.
pub const WEIGHT: f64 = 6.5;
