//! Coefficients of series, in double and in double-double, and sums of few terms by Estrin's scheme, shorter than Horner's by
//! half.

use crate::arithmetic::Arithmetic;

pub mod clausen;
pub mod sine;

/// `a + b z`.
#[inline(always)]
fn pair<T: Arithmetic>(a: f64, b: f64, z: T) -> T {
    z.like(a) + z.like(b) * z
}

#[inline(always)]
fn four_terms<T: Arithmetic>([a, b, c, d]: &[f64; 4], z: T, z2: T) -> T {
    pair(*a, *b, z) + pair(*c, *d, z) * z2
}

/// `sum c[k] z^k`, k below seven.
#[inline(always)]
pub fn seven_terms<T: Arithmetic>([a, b, c, d, e, f, g]: &[f64; 7], z: T) -> T {
    let z2 = z * z;
    four_terms(&[*a, *b, *c, *d], z, z2) + (pair(*e, *f, z) + z.like(*g) * z2) * (z2 * z2)
}

/// `sum c[k] z^k`, k below nine.
#[inline(always)]
pub fn nine_terms<T: Arithmetic>([a, b, c, d, e, f, g, h, i]: &[f64; 9], z: T) -> T {
    let z2 = z * z;
    let z4 = z2 * z2;
    four_terms(&[*a, *b, *c, *d], z, z2) + (four_terms(&[*e, *f, *g, *h], z, z2) + z.like(*i) * z4) * z4
}
