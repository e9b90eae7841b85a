//! Angles on lanes: the angle of the point (x, y) by one division and one polynomial, without a branch.
//!
//! With `m = min(|x|, |y|)` and `M = max(|x|, |y|)`, `t = m/M`:
//! - `3 m <= M`: `arctan t = arctan z`, `z = t`;
//! - else `arctan t = arctan 1/2 + arctan z`, `z = (t - 1/2)/(1 + t/2) = (m - M/2)/(M + m/2)`, in [-1/7, 1/3]; the numerator
//!   is exact (Sterbenz: `M/2` is within a factor of two of m).
//!
//! `|z| <= 1/3`, and `arctan z = z + z z^2 P(z^2)` with P of minimal largest relative error on [0, 1/9], found by Remez'
//! algorithm in 60 digits (weight `z^3/arctan z`), coefficients rounded to nearest: 2^-58.1 for the ten of double precision,
//! 2^-28.3 for the four of single precision. The octant adds 0, `pi/2` or `pi`, each kept in two parts, as is `arctan 1/2`.
//!
//! # Error
//! Below `arctan 1/3` the quotient errs by half an ulp, so does the sum `z + z^3 P`, and the rest is below a tenth. Else z errs
//! by 2u relative (denominator, quotient), at most `0.64 u` with the angle's derivative, the polynomial's sum by `u/4`, the two
//! sums with the octant's constant by half an ulp of a number half as large and by half an ulp: below 1.75 ulp in all.
//! The bounds assume [`ANGLE_ULP`]; the tests measure 1.36 on 10^6 points, and 1.5 on all quotients of single precision.

use fearless_simd::Simd;

use crate::lanes::lane::{Lane, Lanes, Mask, constant, polynomials};

/// Largest error of an angle in units in the last place, assumed by the bounds.
pub const ANGLE_ULP: f64 = 2.0;

/// The constants of one precision.
#[derive(Debug, Clone, Copy)]
pub struct ArcTangent<F: 'static> {
    /// Of P, from the lowest power.
    pub polynomial: &'static [F],
    /// `pi/2`, in two parts.
    pub half_pi: [F; 2],
    /// `arctan 1/2`, in two parts.
    pub half: [F; 2],
}

impl ArcTangent<f64> {
    /// Constants of double precision.
    pub const DOUBLE: Self = Self {
        polynomial: &[
            -0.333_333_333_333_332_76,
            0.199_999_999_999_757_32,
            -0.142_857_142_820_086_46,
            0.111_111_108_305_283_23,
            -0.090_908_968_559_038_98,
            0.076_919_765_246_843_42,
            -0.066_609_023_740_875_46,
            0.058_173_981_446_675_78,
            -0.047_996_620_086_403_16,
            0.027_940_362_113_418_552,
        ],
        half_pi: [std::f64::consts::FRAC_PI_2, 6.123_233_995_736_766e-17],
        half: [0.463_647_609_000_806_1, 2.269_877_745_296_168_7e-17],
    };
}

impl ArcTangent<f32> {
    /// Constants of single precision.
    pub const SINGLE: Self = Self {
        polynomial: &[-0.333_332_57, 0.199_932_22, -0.140_966_85, 0.089_814_946],
        half_pi: [std::f32::consts::FRAC_PI_2, -4.371_139e-8],
        half: [0.463_647_6, 5.012_158_7e-9],
    };
}

/// Angle of the point (x, y) from the positive x axis, in [-pi, pi], with the sign of y; neither is NaN, and not both are 0.
///
/// Off by less than [`ANGLE_ULP`] where the quotient of the smaller by the larger is a normal number.
#[inline(always)]
pub fn angle<S: Simd, F: Lane>(simd: S, y: Lanes<S, F>, x: Lanes<S, F>) -> Lanes<S, F> {
    let [angle] = Quotients::new(simd, [y.abs()], [x]).angles(simd);
    angle.copysign(y)
}

/// The quotients z of several points with y not negative, side by side: none waits for the division of the one before, nor does
/// other work between them and [`Self::angles`].
#[derive(Debug)]
pub struct Quotients<S: Simd, F: Lane, const N: usize> {
    y: [Lanes<S, F>; N],
    x: [Lanes<S, F>; N],
    z: [Lanes<S, F>; N],
    /// Where z is that of the angle less `arctan 1/2`.
    shifted: [Mask<S, F>; N],
}

impl<S: Simd, F: Lane, const N: usize> Quotients<S, F, N> {
    /// The quotients of the points (x, y).
    #[inline(always)]
    pub fn new(simd: S, y: [Lanes<S, F>; N], x: [Lanes<S, F>; N]) -> Self {
        let zero = constant(simd, 0.0);
        let never = zero.below(zero);
        let (mut z, mut shifted) = (y, [never; N]);
        for k in 0..N {
            let width = x[k].abs();
            let (least, most) = (y[k].min(width), y[k].max(width));
            let (half_least, half_most) = (least * constant(simd, 0.5), most * constant(simd, 0.5));
            shifted[k] = half_most.below(least + half_least);
            z[k] = shifted[k].select(least - half_most, least) / shifted[k].select(most + half_least, most);
        }
        Self { y, x, z, shifted }
    }

    /// The angles, as of [`angle`]; a coefficient is loaded once.
    #[inline(always)]
    pub fn angles(self, simd: S) -> [Lanes<S, F>; N] {
        let Self { y, x, z, shifted } = self;
        let ArcTangent { polynomial, half_pi, half } = F::ARC_TANGENT;
        let zero = constant(simd, 0.0);
        let mut squares = z;
        for square in &mut squares {
            *square = *square * *square;
        }
        let series = polynomials(simd, squares, polynomial);
        let mut angles = z;
        for k in 0..N {
            let small = z[k] + z[k] * (squares[k] * series[k]);
            angles[k] = shifted[k].select(Lanes::splat(simd, half[1]), zero) + small;
        }
        // Several angles are mostly those of a polygon from afar, all below a half right angle. One alone is of an edge that the
        // horizon cuts, and mostly above.
        if N > 1 && !(1..N).fold(x[0].below(y[0]), |wide, k| wide | x[k].below(y[k])).any() {
            for k in 0..N {
                angles[k] = shifted[k].select(Lanes::splat(simd, half[0]), zero) + angles[k];
            }
            return angles;
        }
        for k in 0..N {
            // The angle is `octant + side (shift + small)`.
            let (steep, leftward) = (x[k].abs().below(y[k]), x[k].below(zero));
            let octant =
                steep.select(Lanes::splat(simd, half_pi[0]), leftward.select(Lanes::splat(simd, half_pi[0] + half_pi[0]), zero));
            let quadrant =
                steep.select(Lanes::splat(simd, half_pi[1]), leftward.select(Lanes::splat(simd, half_pi[1] + half_pi[1]), zero));
            let turned = steep ^ leftward;
            let shift = shifted[k].select(turned.select(Lanes::splat(simd, -half[0]), Lanes::splat(simd, half[0])), zero);
            let high = octant + shift;
            let low = ((octant - high) + shift) + quadrant;
            angles[k] = high + (low + turned.select(-angles[k], angles[k]));
        }
        angles
    }
}

#[cfg(test)]
mod tests {
    use fearless_simd::dispatch;
    use rand::{RngExt, SeedableRng, rngs::ChaCha8Rng};

    use super::*;
    use crate::double_double::DoubleDouble;
    use crate::lanes::instruction_set::instruction_sets;
    use fearless_simd::Level;

    fn angles<F: Lane>(level: Level, y: &[F], x: &[F], out: &mut [F]) {
        #[inline(always)]
        fn run<S: Simd, F: Lane>(simd: S, y: &[F], x: &[F], out: &mut [F]) {
            let width = Lanes::<S, F>::COUNT;
            for ((y, x), out) in y.chunks(width).zip(x.chunks(width)).zip(out.chunks_mut(width)) {
                angle(simd, Lanes::load(simd, y), Lanes::load(simd, x)).store(out);
            }
        }
        dispatch!(level, simd => run(simd, y, x, out));
    }

    /// Units in the last place of a double between a value and a truth known to twice as many digits.
    fn ulps(value: f64, truth: DoubleDouble) -> f64 {
        let size = value.abs();
        ((DoubleDouble::from(value) - truth).to_f64() / (size.next_up() - size)).abs()
    }

    /// Points of all octants: exponents far apart, ordinary ratios, ratios next to the break points and near the axes.
    fn strata(count: usize) -> (Vec<f64>, Vec<f64>) {
        let mut random = ChaCha8Rng::seed_from_u64(3);
        let mut points = (Vec::with_capacity(count), Vec::with_capacity(count));
        for i in 0..count {
            let ratio: f64 = match i % 5 {
                0 => libm::exp(random.random_range(-600.0..600.0)),
                1 => libm::exp(random.random_range(-3.0..3.0)),
                2 => [1.0 / 3.0, 1.0, 3.0, 0.5, 2.0][i / 5 % 5] * (1.0 + random.random_range(-1e-3..1e-3)),
                3 => [1.0 / 3.0, 1.0, 3.0][i / 5 % 3] * (1.0 + f64::from(random.random_range(-8..8)) * f64::EPSILON),
                _ => random.random_range(0.2..1.2),
            };
            let x = libm::exp(random.random_range(-20.0..20.0));
            points.0.push(if i % 2 == 0 { x * ratio } else { -x * ratio });
            points.1.push(if i % 3 == 0 { x } else { -x });
        }
        points
    }

    #[test]
    fn angles_in_double_precision_err_by_less_than_the_bounds_assume() {
        let (y, x) = strata(1_000_000);
        let mut out = vec![0.0; y.len()];
        angles(Level::new(), &y, &x, &mut out);
        let mut worst = (0.0, 0);
        for (i, value) in out.iter().enumerate() {
            let error = ulps(*value, DoubleDouble::from(y[i]).atan2(DoubleDouble::from(x[i])));
            if error > worst.0 || error.is_nan() {
                worst = (error, i);
            }
        }
        println!("{:.3} ulp at ({:e}, {:e})", worst.0, x[worst.1], y[worst.1]);
        assert!(worst.0 <= ANGLE_ULP, "{} ulp at ({:e}, {:e})", worst.0, x[worst.1], y[worst.1]);
    }

    #[test]
    fn all_levels_give_the_same_digits() {
        let (y, x) = strata(10_000);
        let (single_y, single_x): (Vec<f32>, Vec<f32>) =
            (y.iter().copied().map(f32::nearest).collect(), x.iter().copied().map(f32::nearest).collect());
        let mut first: Option<(Vec<u64>, Vec<u32>)> = None;
        for level in instruction_sets() {
            let (mut double, mut single) = (vec![0.0; y.len()], vec![0.0; y.len()]);
            angles(level, &y, &x, &mut double);
            angles(level, &single_y, &single_x, &mut single);
            let bits = (double.iter().map(|v| v.to_bits()).collect(), single.iter().map(|v| v.to_bits()).collect());
            assert_eq!(*first.get_or_insert(bits.clone()), bits, "{level:?}");
        }
    }

    /// Every quotient of single precision in [2^-20, 1], above and below the diagonal and in the left half plane.
    #[test]
    fn angles_in_single_precision_err_by_less_than_the_bounds_assume() {
        let mut worst = 0.0f64;
        const TILE: u32 = 1 << 13;
        let mut tile = [(); 3].map(|()| vec![0.0f32; 1 << 13]);
        let mut exact = vec![0.0f64; 1 << 13];
        for exponent in 107..127u32 {
            for start in (0..1 << 23).step_by(1 << 13) {
                let [y, x, out] = &mut tile;
                let octant = (start / TILE + exponent) % 4;
                for (i, (y, x)) in (start..).zip(y.iter_mut().zip(x.iter_mut())) {
                    let ratio = f32::from_bits((exponent << 23) | i);
                    (*y, *x) = [(ratio, 1.0), (1.0, ratio), (1.0, -ratio), (ratio, -1.0)][octant as usize];
                }
                let (wide_y, wide_x): (Vec<f64>, Vec<f64>) =
                    (y.iter().map(|v| f64::from(*v)).collect(), x.iter().map(|v| f64::from(*v)).collect());
                angles(Level::new(), y, x, out);
                angles(Level::new(), &wide_y, &wide_x, &mut exact);
                for (value, exact) in out.iter().zip(&exact) {
                    let ulp = f64::from(value.next_up() - value);
                    worst = worst.max((f64::from(*value) - exact).abs() / ulp);
                }
            }
        }
        println!("{worst:.3} ulp");
        assert!(worst <= ANGLE_ULP, "{worst} ulp");
    }
}
