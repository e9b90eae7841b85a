//! A segment's part of `X1 = int dA/r^2`, on lanes.
//!
//! d is the signed in-plane distance of the receiver's foot from the segment's line, S that of the receiver, s the coordinate
//! along; `phi = atan2(s, |d|)`, `psi = atan2(s, S)` and `lambda = asinh(|d|/h) = ln (S + |d|)/h`. From [`crate::forms::linear`],
//! before the logarithms are taken out, the segment adds `sgn(d) [f(s') - f(s)]`,
//!
//! `f = lambda psi - 1/4 [2 Cl2(2 phi) - Cl2(2 phi - 2 psi) - Cl2(2 phi + 2 psi)]`.
//!
//! All lengths along and beside come times the length |e| of any vector along the line, so that no root is taken of it.
//!
//! Clausen's function is `Cl2(t) = t [1 - ln t + t^2 P(t^2)]` on all of [0, pi], with P through Chebyshev's twelve points:
//! 2^-53.1 off at most. Absolutely: near pi the bracket cancels. So it errs by `3.15 (1 + 4.6) u` there from the logarithm's 3u
//! and the roundings of the bracket, and by less elsewhere: [`CLAUSEN`] in all.

use fearless_simd::Simd;

use crate::batch::linear::Wide;
use crate::lanes::angle::angles;
use crate::lanes::lane::{constant, polynomials};
use crate::scalar::arithmetic::Arithmetic;

/// Largest absolute error of Clausen's function for its argument, in roundoffs.
pub(super) const CLAUSEN: f64 = 25.0;

/// P.
const SERIES: [f64; 12] = [
    0.013_888_888_888_888_886,
    6.944_444_444_450_688e-05,
    7.873_519_775_277_597e-07,
    1.148_221_690_744_997_7e-08,
    1.897_881_547_368_891_5e-10,
    3.387_610_715_360_320_6e-12,
    6.361_578_449_812_492e-14,
    1.271_997_388_618_284_3e-15,
    2.114_644_745_959_677_6e-17,
    9.101_258_423_398_236e-19,
    -1.267_495_892_472_007_4e-20,
    9.558_060_507_073_981e-22,
];

/// A segment of the boundary in the emitter's plane.
pub(super) struct Segment<S: Simd> {
    /// `S |e|` and `d |e|`.
    pub(super) moment: Wide<S>,
    pub(super) beside: Wide<S>,
    /// h, and `1/e^2`.
    pub(super) height: Wide<S>,
    pub(super) inverse: Wide<S>,
}

impl<S: Simd> Segment<S> {
    /// Its part of X1 between two points `s |e|` along.
    #[inline(always)]
    pub(super) fn x1(&self, simd: S, ends: [Wide<S>; 2]) -> Wide<S> {
        let (zero, two) = (constant(simd, 0.0), constant(simd, 2.0));
        // A foot at the end of a segment has no direction: any will do.
        let beside = self.beside.abs().max(constant(simd, f64::MIN_POSITIVE));
        let [from, to] = [ends[0].abs(), ends[1].abs()];
        let [phi, phi_to, psi, psi_to] = angles(simd, [from, to, from, to], [beside, beside, self.moment, self.moment]);
        let reach = (self.moment + beside) / self.height;
        let lambda = (reach * reach * self.inverse).ln() * constant(simd, 0.5);
        let turn = constant(simd, std::f64::consts::TAU);
        let pi = constant(simd, std::f64::consts::PI);
        let sums = [two * (phi + psi), two * (phi_to + psi_to)];
        let over = [pi.below(sums[0]), pi.below(sums[1])];
        let folded = [over[0].select(turn - sums[0], sums[0]), over[1].select(turn - sums[1], sums[1])];
        let differences = [two * (phi - psi), two * (phi_to - psi_to)];
        let [a, a_to, b, b_to, c, c_to] = clausens(
            simd,
            [
                two * phi,
                two * phi_to,
                differences[0].max(zero),
                differences[1].max(zero),
                folded[0].max(zero),
                folded[1].max(zero),
            ],
        );
        let quarter = constant(simd, 0.25);
        let f_from = lambda * psi - quarter * ((a + a - b) - over[0].select(-c, c));
        let f_to = lambda * psi_to - quarter * ((a_to + a_to - b_to) - over[1].select(-c_to, c_to));
        // Odd in s.
        let term = zero.at_most(ends[1]).select(f_to, -f_to) - zero.at_most(ends[0]).select(f_from, -f_from);
        self.beside.below(zero).select(-term, term)
    }
}

/// Clausen's function of angles from 0 to pi.
#[inline(always)]
fn clausens<S: Simd, const N: usize>(simd: S, t: [Wide<S>; N]) -> [Wide<S>; N] {
    let mut squares = t;
    for square in &mut squares {
        *square = *square * *square;
    }
    let series = polynomials(simd, squares, &SERIES);
    let mut values = t;
    for k in 0..N {
        let logarithm = t[k].max(constant(simd, f64::MIN_POSITIVE)).ln();
        values[k] = t[k] * ((constant(simd, 1.0) - logarithm) + squares[k] * series[k]);
    }
    values
}

#[cfg(test)]
mod tests {
    use fearless_simd::{Level, dispatch};
    use rand::{RngExt, SeedableRng, rngs::ChaCha8Rng};

    use super::*;
    use crate::lanes::lane::Lanes;
    use crate::scalar::dilogarithm::clausen_rest;
    use crate::scalar::double_double::DoubleDouble;
    use crate::scalar::number::ROUNDOFF;

    #[inline(always)]
    fn run<S: Simd>(simd: S, t: &[f64], out: &mut [f64]) {
        let width = Lanes::<S, f64>::COUNT;
        for (t, out) in t.chunks_exact(width).zip(out.chunks_exact_mut(width)) {
            let [value] = clausens(simd, [Lanes::load(simd, t)]);
            value.store(out);
        }
    }

    /// `Cl2(t) = t - 4 J(t/2) - t ln(2 sin(t/2))`, the sine by its series.
    fn clausen(t: f64) -> DoubleDouble {
        let [t, half, two, four] = [t, 0.5 * t, 2.0, 4.0].map(DoubleDouble::from);
        let square = half * half;
        let term = |sum: DoubleDouble, k: i32| {
            DoubleDouble::from(1.0) - square * sum.divided_by(DoubleDouble::from(f64::from(2 * k * (2 * k + 1))))
        };
        let sine = half * (1..=20).rev().fold(DoubleDouble::from(1.0), term);
        t - clausen_rest(half) * four - t * (sine * two).ln()
    }

    #[test]
    fn clausens_function_errs_by_less_than_its_bound() {
        let mut random = ChaCha8Rng::seed_from_u64(8);
        let t: Vec<f64> = (0..40_000)
            .map(|i| match i % 4 {
                0 => libm::exp(random.random_range(-40.0..1.1)),
                1 => std::f64::consts::PI - libm::exp(random.random_range(-40.0..1.1)),
                _ => random.random_range(0.0..std::f64::consts::PI),
            })
            .collect();
        let mut out = vec![0.0; t.len()];
        dispatch!(Level::new(), simd => run(simd, &t, &mut out));
        let mut worst = 0.0f64;
        for (t, value) in t.iter().zip(&out) {
            let error = (clausen(*t) - DoubleDouble::from(*value)).to_f64().abs();
            worst = worst.max(error / ROUNDOFF);
        }
        println!("{worst:.2} units");
        assert!(worst <= CLAUSEN && worst > 1.0, "{worst}");
    }
}
