//! Logarithm and arc tangent in double-double, by one reduction and one series each.
//!
//! Terms that are below 2^-53 of the sum are taken in plain double precision: their roundings are below 2^-106 of
//! it.

use crate::double_double::DoubleDouble;

/// Relative error of [`DoubleDouble::ln`] and [`DoubleDouble::atan2`], in units of
/// [`crate::double_double::ROUNDOFF_OF_DOUBLE_DOUBLE`].
///
/// Logarithm: the argument of the series errs by 4 units (two sums, a quotient), the series by 2, the sum with `k ln 2` can
/// lose a factor of two. Arc tangent: the rotation errs by 2 units of its length against an angle of at least `pi/32`, or is
/// the identity; quotient and series add
/// 4. Both stay below 64.
pub const LIBRARY_UNITS: f64 = 64.0;

/// ln 2.
pub(crate) const LN_2: DoubleDouble = DoubleDouble { hi: std::f64::consts::LN_2, lo: 2.319_046_813_846_299_6e-17 };
const PI: DoubleDouble = DoubleDouble { hi: std::f64::consts::PI, lo: 1.224_646_799_147_353_2e-16 };
const PI_16: DoubleDouble = DoubleDouble { hi: std::f64::consts::PI / 16.0, lo: 7.654_042_494_670_958e-18 };

/// `1/(2k + 1)`.
pub(crate) const RECIPROCALS: [DoubleDouble; 11] = DoubleDouble::table([
    (1.0, 0.0),
    (1.0 / 3.0, 1.850371707708594e-17),
    (1.0 / 5.0, -1.1102230246251566e-17),
    (1.0 / 7.0, 7.93016446160826e-18),
    (1.0 / 9.0, 6.1679056923619804e-18),
    (1.0 / 11.0, -2.523234146875356e-18),
    (1.0 / 13.0, -4.270088556250602e-18),
    (1.0 / 15.0, 9.251858538542971e-19),
    (1.0 / 17.0, 8.163404592832033e-19),
    (1.0 / 19.0, 2.921639538487254e-18),
    (1.0 / 21.0, 2.64338815386942e-18),
]);

/// Cosine and sine of `k pi/16`.
const ROTATIONS: [(DoubleDouble, DoubleDouble); 5] = [
    (DoubleDouble { hi: 1.0, lo: 0.0 }, DoubleDouble { hi: 0.0, lo: 0.0 }),
    (
        DoubleDouble { hi: 0.9807852804032304, lo: 1.8546939997825006e-17 },
        DoubleDouble { hi: 0.19509032201612828, lo: -7.991079068461731e-18 },
    ),
    (
        DoubleDouble { hi: 0.9238795325112867, lo: 1.7645047084336677e-17 },
        DoubleDouble { hi: 0.3826834323650898, lo: -1.0050772696461588e-17 },
    ),
    (
        DoubleDouble { hi: 0.8314696123025452, lo: 1.4073856984728024e-18 },
        DoubleDouble { hi: 0.5555702330196022, lo: 4.709410940561677e-17 },
    ),
    (
        DoubleDouble { hi: std::f64::consts::FRAC_1_SQRT_2, lo: -4.833646656726457e-17 },
        DoubleDouble { hi: std::f64::consts::FRAC_1_SQRT_2, lo: -4.833646656726457e-17 },
    ),
];

/// `sum_k sign^k z^k / (2k + 1)`, the last `plain` terms, which follow the first `RECIPROCALS` up to `wide`, in double precision.
fn odd_series(z: DoubleDouble, sign: f64, wide: usize, plain: usize) -> DoubleDouble {
    let first = z.hi * sign;
    let tail = (wide..wide + plain).rev().fold(0.0, |sum, k| sum * first + 1.0 / (2 * k + 1) as f64);
    let z = z.scaled(sign);
    RECIPROCALS[..wide].iter().rev().fold(DoubleDouble::from(tail), |sum, c| sum * z + *c)
}

impl DoubleDouble {
    /// Natural logarithm of a positive number: `ln m 2^k = 2 artanh((m - 1)/(m + 1)) + k ln 2`, m in [sqrt(1/2), sqrt 2].
    pub fn ln(self) -> Self {
        if !(self.hi > 0.0 && self.hi.is_finite()) {
            return Self::from(libm::log(self.hi));
        }
        let (_, mut exponent) = libm::frexp(self.hi);
        let mut m = Self { hi: libm::scalbn(self.hi, -exponent), lo: libm::scalbn(self.lo, -exponent) };
        if m.hi < std::f64::consts::FRAC_1_SQRT_2 {
            exponent -= 1;
            m = m.scaled(2.0);
        }
        let one = Self::from(1.0);
        let z = (m - one).divided_by(m + one);
        // |z| <= 0.1716, z^2 <= 0.0295: the twenty-second term is below 2^-108, the twelfth below 2^-55.
        z.scaled(2.0) * odd_series(z * z, 1.0, 11, 10) + LN_2 * Self::from(f64::from(exponent))
    }

    /// Angle of the point `(x, self)`, in [-pi, pi]: reflected into the first octant, turned to within `pi/32` of the axis, and
    /// `arctan t = sum (-1)^k t^(2k+1)/(2k + 1)`.
    pub fn atan2(self, x: Self) -> Self {
        let (across, along) = (self.abs(), x.abs());
        let swapped = across.hi > along.hi;
        let (across, along) = if swapped { (along, across) } else { (across, along) };
        if along.hi == 0.0 || !along.hi.is_finite() {
            return Self::from(libm::atan2(self.hi, x.hi));
        }
        let ratio = across.hi / along.hi;
        // tan((2k + 1) pi/32), k = 0..3: where the next rotation is nearer.
        let k = [0.098_491_403_357_164_25, 0.303_346_683_607_342_4, 0.534_511_135_950_791_6, 0.820_678_790_828_660_4]
            .iter()
            .filter(|limit| ratio > **limit)
            .count();
        let (cosine, sine) = ROTATIONS[k];
        let t = (across * cosine - along * sine).divided_by(along * cosine + across * sine);
        // t^2 <= 0.0098: the seventeenth term is below 2^-107, the ninth below 2^-53.
        let octant = PI_16 * Self::from(k as f64) + t * odd_series(t * t, -1.0, 8, 8);
        let quadrant = if swapped { PI.scaled(0.5) - octant } else { octant };
        let half = if x.hi < 0.0 { PI - quadrant } else { quadrant };
        if self.hi < 0.0 { -half } else { half }
    }

    /// The magnitude.
    #[inline]
    pub fn abs(self) -> Self {
        if self.hi < 0.0 { -self } else { self }
    }

    /// pi; off by less than 2^-107 of it.
    #[inline]
    pub const fn pi() -> Self {
        PI
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::double_double::ROUNDOFF_OF_DOUBLE_DOUBLE;
    use astro_float::{BigFloat, Consts, RoundingMode};
    use proptest::prelude::*;

    const BITS: usize = 256;
    const NEAREST: RoundingMode = RoundingMode::ToEven;

    fn big(x: DoubleDouble) -> BigFloat {
        BigFloat::from_f64(x.hi, BITS).add(&BigFloat::from_f64(x.lo, BITS), BITS, NEAREST)
    }

    /// Error in units, relative.
    fn units(value: DoubleDouble, truth: &BigFloat) -> f64 {
        let difference: f64 = big(value).sub(truth, BITS, NEAREST).to_string().parse().unwrap();
        (difference / value.hi).abs() / ROUNDOFF_OF_DOUBLE_DOUBLE
    }

    fn wide() -> impl Strategy<Value = DoubleDouble> {
        (-20.0..20.0f64, -0.5..0.5f64).prop_map(|(e, l)| {
            let hi = libm::exp(e);
            DoubleDouble::from(hi) + DoubleDouble::from(hi * l * f64::EPSILON)
        })
    }

    #[test]
    fn square_roots_keep_their_digits_at_the_ends_of_the_range() {
        let root = DoubleDouble::from(1.3).sqrt();
        assert!(root.lo != 0.0);
        for half in [-511, -505, -500, -450, -400, 0, 400, 498, 505, 511] {
            let power = 2f64.powi(half);
            let computed = DoubleDouble::from(1.3 * power * power).sqrt();
            assert_eq!(computed, root.scaled(power), "2^{}", 2 * half);
        }
    }

    /// A square root of infinity once called itself for ever.
    #[test]
    fn what_is_no_finite_number_comes_back() {
        let arguments = [f64::INFINITY, f64::NEG_INFINITY, f64::NAN, f64::MAX, 5e-324, 0.0, -0.0, -1.0].map(DoubleDouble::from);
        assert_eq!(arguments[0].sqrt().hi, f64::INFINITY);
        assert!(arguments[2].sqrt().hi.is_nan() && arguments[2].ln().hi.is_nan() && arguments[1].sqrt() == DoubleDouble::ZERO);
        for a in arguments {
            for b in arguments {
                let is_lost = [a, b].iter().any(|c| c.hi.is_nan());
                let results = [a.atan2(b), a.divided_by(b), a * b, a + b];
                assert!(!is_lost || results.iter().all(|c| c.hi.is_nan()), "{a:?} {b:?}: {results:?}");
            }
        }
    }

    proptest! {
        #[test]
        fn logarithm_and_arc_tangent_keep_their_error_bound(x in wide(), y in wide(), near in -1e-3..1e-3f64, quarter in 0..4u32) {
            let mut consts = Consts::new().unwrap();
            let log_error = |x: DoubleDouble, consts: &mut Consts| units(x.ln(), &big(x).ln(BITS, NEAREST, consts));
            prop_assert!(log_error(x, &mut consts) < LIBRARY_UNITS / 4.0);
            let near_one = DoubleDouble::from(1.0) + DoubleDouble::from(near) * DoubleDouble::from(1.0 / 3.0);
            prop_assume!(near != 0.0);
            prop_assert!(log_error(near_one, &mut consts) < LIBRARY_UNITS / 4.0);
            let (a, b) = (if quarter & 1 == 0 { y } else { -y }, if quarter & 2 == 0 { x } else { -x });
            let mut truth = big(a).div(&big(b), BITS, NEAREST).atan(BITS, NEAREST, &mut consts);
            if b.hi < 0.0 {
                let pi = consts.pi(BITS, NEAREST);
                truth = if a.hi > 0.0 { truth.add(&pi, BITS, NEAREST) } else { truth.sub(&pi, BITS, NEAREST) };
            }
            prop_assert!(units(a.atan2(b), &truth) < LIBRARY_UNITS / 4.0, "{:?} {:?} {}", a, b, units(a.atan2(b), &truth));
        }
    }
}
