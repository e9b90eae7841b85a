//! The angle of a point in double precision, `atan2`, with a proven error and the same digits on every machine.
//!
//! With t the smaller over the larger of the two magnitudes and c the nearest of 0, 1/2, 1 (limits at 1/4 and 3/4),
//! `atan t = atan c + atan s`, `s = (small - c large) / (large + c small)`, |s| <= 1/4, and `atan s = s + s^3 p(s^2)` with p of
//! degree 8: the least largest error relative to s on [0, 1/16], 6e-20, by Remez's algorithm; 2e-19 with rounded coefficients.
//! Table and sign take it to the right octant. One division; the only branch is for numbers near the ends of the range.
//!
//! # Bound
//! Below 4 u of the result, u = 2^-53. The products with c are exact and so is the difference where c is not 0, the operands
//! being within a factor of two; sum and quotient make s err by 2u, its quotient alone by u where c is 0. The cubic part, at
//! most |s|/48, errs by less than 0.2 u |s|. Where c is 0 in the first octant: (1 + 0.2 + 1) u. Elsewhere at most (2 + 0.2 + 1)
//! u |s| from s, the cubic part and their sum, and u from the last one; the result is at least atan(1/4) = 0.2449 and |s| at most
//! 2/9 where c is 1/2, a larger result elsewhere: (3.2 x 0.2222 / 0.2449 + 1) u = 3.91 u. The remainder beyond the table's second
//! doubles is below 2^-107.

use crate::arithmetic::Doubles;
use crate::series::nine_terms;

/// Bound on the error of an angle, in units of roundoff of it, proved by `cargo xtask prove` from [`TRUNCATION`].
pub const UNITS: f64 = 3.91;

/// Largest error of the polynomial, relative to s, by Remez's algorithm and with 120 digits; and of the table, with 60.
pub const TRUNCATION: [f64; 2] = [2e-19, 1.0 / (1u128 << 107) as f64];

/// `(atan s - s)/s^3` in powers of `s^2`.
const CUBIC: [f64; 9] = [
    -0.333_333_333_333_333_2,
    0.199_999_999_999_914_52,
    -0.142_857_142_838_134_72,
    0.111_111_109_036_574_53,
    -0.090_908_962_616_193_23,
    0.076_918_271_484_634_7,
    -0.066_555_197_561_948_33,
    0.057_248_663_393_826_636,
    -0.040_000_180_093_643_01,
];

/// Of c = 0, 1/2, 1: c; the leading double of the angle added to, `atan c`, `pi - atan c`, `pi/2 - atan c`, `pi/2 + atan c`, where
/// the point is nearer to the x axis, to the right and to the left, or nearer to the y axis, likewise; and the rest of that angle.
#[allow(clippy::approx_constant, reason = "the first doubles of two")]
pub(crate) const FROM: [[[f64; 3]; 3]; 4] = [
    [[0.0, 0.0, 0.0], [0.5, 0.4636476090008061, 2.2698777452961687e-17], [1.0, 0.7853981633974483, 3.061616997868383e-17]],
    [
        [0.0, 3.141592653589793, 1.2246467991473532e-16],
        [0.5, 2.677945044588987, 1.5527705369303147e-16],
        [1.0, 2.356194490192345, 9.184850993605148e-17],
    ],
    [
        [0.0, 1.5707963267948966, 6.123233995736766e-17],
        [0.5, 1.1071487177940904, 9.40447137356638e-17],
        [1.0, 0.7853981633974483, 3.061616997868383e-17],
    ],
    [
        [0.0, 1.5707963267948966, 6.123233995736766e-17],
        [0.5, 2.0344439357957027, 2.841996617907152e-17],
        [1.0, 2.356194490192345, 9.184850993605148e-17],
    ],
];

/// Below, sums and products with c may leave the range.
const LEAST: f64 = f64::MIN_POSITIVE / f64::EPSILON;

/// Angle of the point (x, y), in [-pi, pi].
#[inline]
pub fn atan2(y: f64, x: f64) -> f64 {
    let (rise, run) = (y.abs(), x.abs());
    let large = if rise > run { rise } else { run };
    if !(large > LEAST && large < f64::MAX / 4.0) {
        return at_the_ends(y, x);
    }
    angle::<f64, true>(rise, x).copysign(y)
}

/// Where [`angle`] has its digits, of coordinates that are not near the upper end of the range.
#[inline(always)]
pub fn is_in_range<T: Doubles>(y: T, x: T) -> T::Mask {
    y.max(x.abs()).exceeds(y.like(LEAST))
}

/// The same where y, and unless `LEFT` x, is not negative, and the larger one is not near the ends of the range.
#[inline(always)]
pub fn angle<T: Doubles, const LEFT: bool>(y: T, x: T) -> T {
    let run = x.abs();
    let (steep, left) = (y.exceeds(run), x.like(0.0).exceeds(x));
    let (small, large) = (T::choose(steep, run, y), T::choose(steep, y, run));
    let nearest = [small.exceeds(x.like(0.25) * large), small.exceeds(x.like(0.75) * large)];
    let octant = (steep, if LEFT { Some(left) } else { None });
    let [c, from, rest] = x.entry(&FROM, octant, nearest);
    let s = (small - c * large) / (large + c * small);
    let s = T::choose(if LEFT { steep ^ left } else { steep }, -s, s);
    let square = s * s;
    from + (s + (s * square * nine_terms(&CUBIC, square) + rest))
}

/// Coordinates that are zero or very small, very large, infinite or no numbers.
#[cold]
#[inline(never)]
fn at_the_ends(y: f64, x: f64) -> f64 {
    let large = y.abs().max(x.abs());
    if large == 0.0 || !large.is_finite() || y.is_nan() || x.is_nan() {
        return libm::atan2(y, x);
    }
    let power = if large < 1.0 { 1.0 / f64::EPSILON / f64::EPSILON } else { f64::EPSILON };
    atan2(y * power, x * power)
}

#[cfg(test)]
mod tests {
    use astro_float::{BigFloat, Consts, RoundingMode};
    use proptest::prelude::*;

    use super::*;
    use crate::number::{Number, ROUNDOFF};

    const BITS: usize = 192;
    const NEAREST: RoundingMode = RoundingMode::ToEven;

    fn big(x: f64) -> BigFloat {
        BigFloat::from_f64(x, BITS)
    }

    /// Error of `atan2(y, x)` in units of roundoff of it.
    fn units(y: f64, x: f64, consts: &mut Consts) -> f64 {
        let mut truth = big(y).div(&big(x), BITS, NEAREST).atan(BITS, NEAREST, consts);
        if x < 0.0 {
            let pi = consts.pi(BITS, NEAREST);
            truth = if y > 0.0 { truth.add(&pi, BITS, NEAREST) } else { truth.sub(&pi, BITS, NEAREST) };
        }
        let difference: f64 = big(atan2(y, x)).sub(&truth, BITS, NEAREST).to_string().parse().unwrap();
        (difference / atan2(y, x) / ROUNDOFF).abs()
    }

    #[test]
    fn the_angle_errs_by_less_than_its_bound() {
        let mut consts = Consts::new().unwrap();
        // Around the limits of the reductions, in all octants, close and not so close.
        let mut worst = 0.0f64;
        for limit in [0.25, 0.75, 1.0, 0.5, 0.01, 1e-9, 4.0, 4.0 / 3.0, 30.0] {
            for k in -150..150i32 {
                let step = f64::from(k) * [1e-3, 1e-9, 1.2e-16][k.unsigned_abs() as usize % 3];
                let x = 1.0 + 0.9 * libm::sin(f64::from(k * k));
                for (y, x) in
                    [(limit, 1.0), (-limit, 1.0), (limit, -1.0), (-limit, -1.0)].map(|(r, s)| (r * (1.0 + step) * x, s * x))
                {
                    worst = worst.max(units(y, x, &mut consts));
                }
            }
        }
        println!("{worst:.3} units");
        assert!(worst < <f64 as Number>::LIBRARY_UNITS, "{worst}");
    }

    #[test]
    fn the_ends_of_the_range_keep_their_digits() {
        let mut consts = Consts::new().unwrap();
        for (y, x) in
            [(5e-324, 5e-324), (1e-320, -3e-322), (1e300, 1.7e308), (-1.7e308, 1.7e308), (3e-308, 1e-307), (1e308, -1e290)]
        {
            assert!(units(y, x, &mut consts) < 4.0, "{y} {x}");
        }
        let pi = std::f64::consts::PI;
        for (y, x, angle) in [(0.0, 1.0, 0.0), (0.0, -1.0, pi), (1.0, 0.0, pi / 2.0), (-1.0, 0.0, -pi / 2.0), (0.0, 0.0, 0.0)] {
            assert_eq!(atan2(y, x), angle);
        }
        assert!(atan2(f64::NAN, 1.0).is_nan() && atan2(1.0, f64::NAN).is_nan());
        assert_eq!(atan2(1.0, f64::INFINITY), 0.0);
    }

    proptest! {
        #[test]
        fn it_is_the_angle_of_the_library(rise in -40.0..40.0f64, run in -40.0..40.0f64, signs in 0..4u8) {
            let y = libm::exp(rise) * if signs & 1 == 0 { 1.0 } else { -1.0 };
            let x = libm::exp(run) * if signs & 2 == 0 { 1.0 } else { -1.0 };
            let library = libm::atan2(y, x);
            prop_assert!((atan2(y, x) - library).abs() <= 8.0 * ROUNDOFF * library.abs());
        }
    }
}
