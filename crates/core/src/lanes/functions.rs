//! The functions of [`crate::scalar::arc_tangent`], [`crate::scalar::logarithm`] and [`crate::scalar::dilogarithm`] on lanes: the
//! same operations in the same order, so the same digits.

use std::f64::consts::{PI, SQRT_2};

use fearless_simd::{Select, Simd, SimdFloat};

use crate::scalar::arc_tangent::{CUBIC, FROM};
use crate::scalar::logarithm::{ARTANH, LN_2_PARTS};
use crate::scalar::series::clausen::DOUBLE_SERIES;

/// As [`crate::scalar::arc_tangent::atan2`] where y, and unless `LEFT` x, is not negative; and where that is away from the ends
/// of the range.
#[inline(always)]
pub(crate) fn plain_angle<S: Simd, V: SimdFloat<S, Element = f64>, const LEFT: bool>(simd: S, y: V, x: V) -> (V, V::Mask) {
    let run = x.abs();
    let (small, large) = (y.min(run), y.max(run));
    let octant = Octant {
        steep: y.simd_gt(run),
        left: x.simd_lt(V::splat(simd, 0.0)),
        half: small.simd_gt(V::splat(simd, 0.25) * large),
        whole: small.simd_gt(V::splat(simd, 0.75) * large),
    };
    let c: V = octant.nearest(simd, [0.0, 0.5, 1.0]);
    let s = (small - c * large) / (large + c * small);
    let turned = if LEFT { octant.steep ^ octant.left } else { octant.steep };
    let s = turned.select(-s, s);
    let square = s * s;
    let (from, rest): (V, V) = (octant.from::<S, V, LEFT>(simd, 0), octant.from::<S, V, LEFT>(simd, 1));
    let angle = from + (s + (s * square * nine_terms(simd, &CUBIC, square) + rest));
    (angle, large.simd_gt(V::splat(simd, f64::MIN_POSITIVE / f64::EPSILON)))
}

/// Where a point is: nearer to the y axis, left of it, and its tangent's reduction.
#[derive(Clone, Copy)]
struct Octant<M> {
    steep: M,
    left: M,
    half: M,
    whole: M,
}

impl<M> Octant<M> {
    /// One of three numbers for the nearest of 0, 1/2, 1.
    #[inline(always)]
    fn nearest<S: Simd, V: SimdFloat<S, Element = f64, Mask = M>>(&self, simd: S, [zero, half, one]: [f64; 3]) -> V
    where
        M: Copy + Select<V>,
    {
        let low = self.half.select(V::splat(simd, half), V::splat(simd, zero));
        self.whole.select(V::splat(simd, one), low)
    }

    /// A part of [`FROM`].
    #[inline(always)]
    fn from<S: Simd, V: SimdFloat<S, Element = f64, Mask = M>, const LEFT: bool>(&self, simd: S, part: usize) -> V
    where
        M: Copy + Select<V>,
    {
        let [a, b, c, d] = &FROM;
        let (right, up) = (self.nearest(simd, column(a, part)), self.nearest(simd, column(c, part)));
        if !LEFT {
            return self.steep.select(up, right);
        }
        let (left, beyond) = (self.nearest(simd, column(b, part)), self.nearest(simd, column(d, part)));
        self.steep.select(self.left.select(beyond, up), self.left.select(left, right))
    }
}

#[inline(always)]
const fn column(row: &[[f64; 2]; 3], part: usize) -> [f64; 3] {
    [row[0][part], row[1][part], row[2][part]]
}

/// A polynomial of degree 8, in the order of [`crate::scalar::arc_tangent`].
#[inline(always)]
pub(crate) fn nine_terms<S: Simd, V: SimdFloat<S, Element = f64>>(simd: S, c: &[f64; 9], z: V) -> V {
    let z2 = z * z;
    let z4 = z2 * z2;
    let low = pair(simd, [c[0], c[1]], z) + pair(simd, [c[2], c[3]], z) * z2;
    let high = pair(simd, [c[4], c[5]], z) + pair(simd, [c[6], c[7]], z) * z2;
    low + (high + V::splat(simd, c[8]) * z4) * z4
}

/// `(a + b z) + (c + d z) z^2`.
#[inline(always)]
fn four_terms<S: Simd, V: SimdFloat<S, Element = f64>>(simd: S, [a, b, c, d]: [f64; 4], [z, z2]: [V; 2]) -> V {
    pair(simd, [a, b], z) + pair(simd, [c, d], z) * z2
}

/// `a + b z`.
#[inline(always)]
pub(crate) fn pair<S: Simd, V: SimdFloat<S, Element = f64>>(simd: S, [a, b]: [f64; 2], z: V) -> V {
    V::splat(simd, a) + V::splat(simd, b) * z
}

/// As [`crate::scalar::logarithm::ln`] of positive normal numbers.
#[inline(always)]
pub(crate) fn logarithm<S: Simd, V: SimdFloat<S, Element = f64>>(simd: S, x: V) -> V {
    let (one, two) = (V::splat(simd, 1.0), V::splat(simd, 2.0));
    let bits = x.to_bits();
    // An integer in the last bits of 2^52, and that with the bias of exponents.
    let exponent = V::from_bits((bits >> 52) | (1075 << 52)) - V::splat(simd, ((1u64 << 52) + 1023) as f64);
    let mantissa = V::from_bits((bits & ((1 << 52) - 1)) | (1023 << 52));
    let high = mantissa.simd_gt(V::splat(simd, SQRT_2));
    let mantissa = high.select(mantissa * V::splat(simd, 0.5), mantissa);
    let k = high.select(exponent + one, exponent);
    let f = mantissa - one;
    let s = f / (f + two);
    let z = s * s;
    let z2 = z * z;
    let [c0, c1, c2, c3, c4, c5, c6] = ARTANH;
    let low = pair(simd, [c0, c1], z) + pair(simd, [c2, c3], z) * z2;
    let series = z * (low + (pair(simd, [c4, c5], z) + V::splat(simd, c6) * z2) * (z2 * z2));
    let less = s * (f - (series + series)) - k * V::splat(simd, LN_2_PARTS[1]);
    k * V::splat(simd, LN_2_PARTS[0]) + (f - less)
}

/// As [`crate::scalar::dilogarithm::clausen_rest`].
#[inline(always)]
fn clausen_rest<S: Simd, V: SimdFloat<S, Element = f64>>(simd: S, x: V) -> V {
    let c = &DOUBLE_SERIES;
    let z = x * x;
    let z2 = z * z;
    let z4 = z2 * z2;
    let low = four_terms(simd, [c[1], c[2], c[3], c[4]], [z, z2]) + four_terms(simd, [c[5], c[6], c[7], c[8]], [z, z2]) * z4;
    let high = four_terms(simd, [c[9], c[10], c[11], c[12]], [z, z2]) + V::splat(simd, c[13]) * z4;
    let rest = low + high * (z4 * z4);
    x * z * (V::splat(simd, c[0]) + z * rest)
}

/// The term of an end of a segment of `X1End` in [`crate::forms::linear`], at `s >= 0` from the distances d and S and the
/// logarithm there, with `beyond` where `s^2 > d S`; its angles phi and psi; and where all is away from the ends of the range.
#[inline(always)]
pub(crate) fn x1_end<S: Simd, V: SimdFloat<S, Element = f64>>(
    simd: S,
    s: V,
    [d, distance]: [V; 2],
    logarithm: V,
    beyond: V::Mask,
) -> ([V; 3], V::Mask) {
    let (phi, plain) = plain_angle::<S, V, false>(simd, s, d);
    let (psi, plain_too) = plain_angle::<S, V, false>(simd, s, distance);
    let sum = phi + psi;
    let whole = phi * logarithm + (clausen_rest(simd, phi) * V::splat(simd, 2.0) - clausen_rest(simd, phi - psi));
    let last = clausen_rest(simd, beyond.select(V::splat(simd, PI) - sum, sum));
    let term = whole + beyond.select(last - V::splat(simd, PI * 0.5), -last);
    ([term, phi, psi], plain & plain_too)
}

#[cfg(test)]
mod tests {
    use fearless_simd::{SimdBase, f64x4};
    use rand::{RngExt, SeedableRng, rngs::ChaCha8Rng};

    use super::*;
    use crate::lanes::instruction_set::{instruction_sets, on_instruction_set};
    use crate::scalar::{arc_tangent, dilogarithm};

    #[inline(always)]
    fn all<S: Simd>(simd: S, [y, x, t]: [f64; 3]) -> [f64; 4] {
        let splat = |value: f64| f64x4::splat(simd, value);
        [
            plain_angle::<S, f64x4<S>, true>(simd, splat(y), splat(x)).0[0],
            plain_angle::<S, f64x4<S>, false>(simd, splat(y), splat(x.abs())).0[1],
            logarithm(simd, splat(y))[2],
            clausen_rest(simd, splat(t))[3],
        ]
    }

    #[test]
    fn lanes_have_the_digits_of_the_scalar_functions() {
        let mut random = ChaCha8Rng::seed_from_u64(6);
        for i in 0..40_000 {
            let spread = [1e-12, 1e-3, 1.0, 30.0, 200.0][i % 5];
            let mut power = || libm::exp(random.random_range(-spread..spread));
            let ratio = [power(), 0.25 * power(), 0.75 * power(), power()][i % 4];
            let (x, small) = (power(), libm::exp(-power().min(700.0)));
            let y = x * ratio;
            let x = if i % 3 == 0 { -x } else { x };
            let t = [random.random_range(-PI..PI) * 0.5, 0.5 * PI - small, small][i % 3];
            let scalars = [
                arc_tangent::atan2(y, x),
                arc_tangent::atan2(y, x.abs()),
                crate::scalar::logarithm::ln(y),
                dilogarithm::clausen_rest(t),
            ];
            for level in instruction_sets() {
                assert_eq!(on_instruction_set!(level, simd => all(simd, [y, x, t])), scalars, "{y:e} {x:e} {t:e}");
            }
        }
    }
}
