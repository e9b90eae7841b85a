//! The functions of [`crate::arc_tangent`], [`crate::logarithm`] and [`crate::dilogarithm`] on lanes: the same operations in the
//! same order, so the same digits.

use std::f64::consts::{LN_2, PI, SQRT_2};

use fearless_simd::{Select, Simd, SimdFloat};

use crate::arc_tangent::{CUBIC, FROM};
use crate::dilogarithm::{DOUBLE_NEAR_PI, DOUBLE_NEAR_ZERO};
use crate::double_double::DoubleDouble;
use crate::logarithm::{ARTANH, LN_2_PARTS};

/// As [`crate::arc_tangent::atan2`] where y, and unless `LEFT` x, is not negative; and where that is away from the ends of the
/// range.
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

/// A polynomial of degree 8, in the order of [`crate::arc_tangent`].
#[inline(always)]
pub(crate) fn nine_terms<S: Simd, V: SimdFloat<S, Element = f64>>(simd: S, c: &[f64; 9], z: V) -> V {
    let z2 = z * z;
    let z4 = z2 * z2;
    let low = pair(simd, [c[0], c[1]], z) + pair(simd, [c[2], c[3]], z) * z2;
    let high = pair(simd, [c[4], c[5]], z) + pair(simd, [c[6], c[7]], z) * z2;
    low + (high + V::splat(simd, c[8]) * z4) * z4
}

/// `a + b z`.
#[inline(always)]
pub(crate) fn pair<S: Simd, V: SimdFloat<S, Element = f64>>(simd: S, [a, b]: [f64; 2], z: V) -> V {
    V::splat(simd, a) + V::splat(simd, b) * z
}

/// As [`crate::logarithm::ln`] of positive normal numbers.
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

/// As [`crate::dilogarithm::clausen`] of angles from 0 to pi: `u (base + z P(z))` around 0 or pi.
#[inline(always)]
fn clausen_to_pi<S: Simd, V: SimdFloat<S, Element = f64>>(simd: S, t: V) -> V {
    let near_pi = t.simd_gt(V::splat(simd, 2.0 * PI / 3.0));
    clausen_near(simd, near_pi, t, pi_minus(simd, t))
}

/// The same up to 2 pi, and of angles that are negative by rounding.
#[inline(always)]
fn clausen<S: Simd, V: SimdFloat<S, Element = f64>>(simd: S, t: V) -> V {
    let size = t.abs();
    let rest = pi_minus(simd, size * V::splat(simd, 0.5));
    let beyond = size.simd_gt(V::splat(simd, 4.0 * PI / 3.0));
    let near_pi = size.simd_gt(V::splat(simd, 2.0 * PI / 3.0)) ^ beyond;
    let magnitude = clausen_near(simd, near_pi, beyond.select((rest + rest).abs(), size), pi_minus(simd, size));
    (beyond ^ t.simd_lt(V::splat(simd, 0.0))).select(-magnitude, magnitude)
}

/// Around pi or 0, from the distances from both.
#[inline(always)]
fn clausen_near<S: Simd, V: SimdFloat<S, Element = f64>>(simd: S, near_pi: V::Mask, from_zero: V, from_pi: V) -> V {
    let from_logarithm = V::splat(simd, 1.0) - logarithm(simd, from_zero.max(V::splat(simd, f64::MIN_POSITIVE)));
    let base = near_pi.select(V::splat(simd, LN_2), from_logarithm);
    let u = near_pi.select(from_pi, from_zero);
    let z = u * u;
    let z2 = z * z;
    let z4 = z2 * z2;
    let low = either_pair(simd, near_pi, 0, z) + either_pair(simd, near_pi, 2, z) * z2;
    let high = either_pair(simd, near_pi, 4, z) + either_pair(simd, near_pi, 6, z) * z2;
    let [.., c8, c9] = DOUBLE_NEAR_ZERO;
    let last = near_pi.select(V::splat(simd, -DOUBLE_NEAR_PI[8]), pair(simd, [c8, c9], z));
    u * (base + z * (low + high * z4 + last * (z4 * z4)))
}

/// Terms k and k + 1 of the polynomial around 0, or of that around pi with the other sign.
#[inline(always)]
fn either_pair<S: Simd, V: SimdFloat<S, Element = f64>>(simd: S, near_pi: V::Mask, k: usize, z: V) -> V {
    let (zero, pi) = (&DOUBLE_NEAR_ZERO, &DOUBLE_NEAR_PI);
    let low = near_pi.select(V::splat(simd, -pi[k]), V::splat(simd, zero[k]));
    low + near_pi.select(V::splat(simd, -pi[k + 1]), V::splat(simd, zero[k + 1])) * z
}

#[inline(always)]
fn pi_minus<S: Simd, V: SimdFloat<S, Element = f64>>(simd: S, x: V) -> V {
    let DoubleDouble { hi, lo } = DoubleDouble::pi();
    (V::splat(simd, hi) - x) + V::splat(simd, lo)
}

/// The Clausen functions of an end of a segment in [`crate::linear`]: `2 Cl2(2 phi) - Cl2(2 delta) - Cl2(4 phi - 2 delta)` for phi the
/// angle of the point (d, s) and delta that of (across, along), which has the sign of s; no other is negative. And where both points
/// are away from the ends of the range.
#[inline(always)]
pub(crate) fn x1_clausens<S: Simd, V: SimdFloat<S, Element = f64>>(
    simd: S,
    [s, d]: [V; 2],
    [along, across]: [V; 2],
) -> (V, V::Mask) {
    let (two, four) = (V::splat(simd, 2.0), V::splat(simd, 4.0));
    // All is odd in s.
    let (phi, plain) = plain_angle::<S, V, false>(simd, s.abs(), d);
    let (delta, plain_too) = plain_angle::<S, V, false>(simd, along.abs(), across);
    let sum = clausen_to_pi(simd, phi * two) * two - clausen_to_pi(simd, delta * two) - clausen(simd, phi * four - delta * two);
    (s.simd_lt(V::splat(simd, 0.0)).select(-sum, sum), plain & plain_too)
}

#[cfg(test)]
mod tests {
    use fearless_simd::{SimdBase, f64x4};
    use rand::{RngExt, SeedableRng, rngs::ChaCha8Rng};

    use super::*;
    use crate::level::{levels, on_level};
    use crate::{arc_tangent, dilogarithm};

    #[inline(always)]
    fn all<S: Simd>(simd: S, [y, x, t, small]: [f64; 4]) -> [f64; 5] {
        let splat = |value: f64| f64x4::splat(simd, value);
        [
            plain_angle::<S, f64x4<S>, true>(simd, splat(y), splat(x)).0[0],
            plain_angle::<S, f64x4<S>, false>(simd, splat(y), splat(x.abs())).0[1],
            logarithm(simd, splat(y))[2],
            clausen(simd, splat(t))[3],
            clausen_to_pi(simd, splat(small))[0],
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
            let place = [0.0, PI, 2.0 * PI, 2.0 * PI / 3.0, 4.0 * PI / 3.0][i % 5];
            let t = if i % 2 == 0 { random.random_range(-2.0 * PI..2.0 * PI) } else { place - small };
            let small = [random.random_range(0.0..PI), PI - small, small][i % 3];
            let scalars = [
                arc_tangent::atan2(y, x),
                arc_tangent::atan2(y, x.abs()),
                crate::logarithm::ln(y),
                dilogarithm::clausen(t),
                dilogarithm::clausen(small),
            ];
            for level in levels() {
                assert_eq!(on_level!(level, simd => all(simd, [y, x, t, small])), scalars, "{y:e} {x:e} {t:e} {small:e}");
            }
        }
    }
}
