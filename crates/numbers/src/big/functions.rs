//! Logarithm and arc tangent: a step to the nearest 64th, whose value is kept, and one short series.
//!
//! `ln m 2^e = e ln 2 + ln c + 2 artanh z`, `z = (m - c)/(m + c)`, for m in [3/4, 3/2) and c the nearest 64th; `arctan t = arctan
//! c + arctan z`, `z = (t - c)/(1 + t c)`, for t in [0, 1]. Either way `|z| <= 1/128`, and c is 1 or 0 where the result is small,
//! so that no sum loses more than a factor of three; all is done with [`GUARD`] bits more than asked, which pay for it.

use astro_float::{BigFloat, Consts};

use crate::big::float::{NEAREST, nearest_double, shifted};
use crate::big::magnitude::Magnitude;
use crate::big::series::{GUARD, first_integer_above, integer, rounded};

/// Error of logarithm and arc tangent in units of roundoff: one rounding and the error beyond the guard bits. The arc tangent is
/// rounded once more where it is taken from pi/2 and from pi.
pub(super) const LIBRARY_UNITS: f64 = 2.0;

/// Logarithms and angles of the 64ths that were needed, and the coefficients of both series, for one precision.
#[derive(Debug, Default)]
pub(super) struct Steps {
    logarithms: Vec<Option<BigFloat>>,
    angles: Vec<Option<BigFloat>>,
    /// `1/(2k + 1)`.
    reciprocals: Vec<BigFloat>,
}

/// Bits of the argument that a step takes.
const STEP_BITS: i32 = 6;

/// The nearest multiple of a 64th.
#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "between 0 and 96")]
fn nearest_step(number: &BigFloat) -> usize {
    (nearest_double(number) * 64.0).round() as usize
}

impl Steps {
    /// The result of `find` at the step, computed once.
    fn cached(cache: &mut Vec<Option<BigFloat>>, step: usize, find: impl FnOnce(&BigFloat) -> BigFloat) -> &BigFloat {
        if cache.len() <= step {
            cache.resize(step + 1, None);
        }
        cache[step].get_or_insert_with(|| find(&shifted(&integer(step), -STEP_BITS)))
    }

    /// `sum sign^k z^(2k+1) / (2k + 1)`, |z| at most 1/128: as many terms as leave less than 2^-bits of it.
    fn odd_series(&mut self, z: &BigFloat, sign: f64, bits: usize) -> BigFloat {
        let square = z.mul(z, bits, NEAREST);
        let terms = first_integer_above(bits as f64 / -Magnitude::of_number(&square).log2()).max(1);
        while self.reciprocals.len() < terms {
            let next = BigFloat::from_word(1, 64).div(&integer(2 * self.reciprocals.len() + 1), bits, NEAREST);
            self.reciprocals.push(next);
        }
        let square = if sign < 0.0 { square.neg() } else { square };
        let sum = self.reciprocals[..terms]
            .iter()
            .rev()
            .fold(BigFloat::new(bits), |sum, c| sum.mul(&square, bits, NEAREST).add(c, bits, NEAREST));
        sum.mul(z, bits, NEAREST)
    }
}

/// Natural logarithm of a positive number.
pub(super) fn ln(x: &BigFloat, bits: usize, steps: &mut Steps, constants: &mut Consts) -> BigFloat {
    let Some(exponent) = x.exponent().filter(|_| x.is_positive() && !x.is_zero()) else {
        return x.ln(bits, NEAREST, constants);
    };
    let working = bits + GUARD;
    let half = shifted(x, -exponent);
    let (m, exponent) = if nearest_double(&half) < 0.75 { (shifted(&half, 1), exponent - 1) } else { (half, exponent) };
    let step = nearest_step(&m);
    let c = shifted(&integer(step), -STEP_BITS);
    let z = m.sub(&c, working, NEAREST).div(&m.add(&c, working, NEAREST), working, NEAREST);
    let mut sum = shifted(&steps.odd_series(&z, 1.0, working), 1);
    if step != 1 << STEP_BITS {
        let logarithm = Steps::cached(&mut steps.logarithms, step, |c| c.ln(working, NEAREST, constants));
        sum = sum.add(logarithm, working, NEAREST);
    }
    if exponent != 0 {
        let factor = BigFloat::from_i32(exponent, 64);
        sum = sum.add(&constants.ln_2(working, NEAREST).mul(&factor, working, NEAREST), working, NEAREST);
    }
    rounded(sum, bits)
}

/// Angle of the point `(x, y)`, in [-pi, pi].
pub(super) fn atan2(y: &BigFloat, x: &BigFloat, bits: usize, steps: &mut Steps, constants: &mut Consts) -> BigFloat {
    let working = bits + GUARD;
    let (across, along) = (y.abs(), x.abs());
    let swapped = across.cmp(&along).is_some_and(|order| order > 0);
    let (across, along) = if swapped { (along, across) } else { (across, along) };
    // The angle of the origin is 0, as for doubles.
    let octant = if across.is_zero() { across } else { arc_tangent(&across, &along, working, steps, constants) };
    let pi = constants.pi(working, NEAREST);
    let quadrant = if swapped { shifted(&pi, -1).sub(&octant, working, NEAREST) } else { octant };
    let half = if x.is_negative() { pi.sub(&quadrant, working, NEAREST) } else { quadrant };
    rounded(if y.is_negative() { half.neg() } else { half }, bits)
}

/// Arc tangent of a quotient between 0 and 1.
fn arc_tangent(across: &BigFloat, along: &BigFloat, bits: usize, steps: &mut Steps, constants: &mut Consts) -> BigFloat {
    let step = nearest_step(&across.div(along, 64, NEAREST));
    if step == 0 {
        let z = across.div(along, bits, NEAREST);
        return steps.odd_series(&z, -1.0, bits);
    }
    let c = shifted(&integer(step), -STEP_BITS);
    let numerator = across.sub(&along.mul(&c, bits, NEAREST), bits, NEAREST);
    let z = numerator.div(&along.add(&across.mul(&c, bits, NEAREST), bits, NEAREST), bits, NEAREST);
    let remainder = steps.odd_series(&z, -1.0, bits);
    Steps::cached(&mut steps.angles, step, |c| c.atan(bits, NEAREST, constants)).add(&remainder, bits, NEAREST)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::big::float::exact_sum;
    use crate::big::magnitude::Magnitude;
    use crate::big::{Big, with_bits};
    use crate::number::Number;
    use crate::radius::Radius;
    use proptest::prelude::*;

    /// The same with more bits, brought back.
    fn error_in_units(bits: usize, wider: usize, function: impl Fn() -> Big) -> f64 {
        let [rough, fine] = [bits, wider].map(|bits| with_bits(bits, || function().to_float()));
        let difference = fine.sub_full_prec(&rough);
        (Magnitude::of_number(&difference) / Magnitude::of_number(&fine) * Magnitude::power_of_two(bits as i64)).to_double()
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(64))]
        #[test]
        fn functions_keep_their_error_bounds(y in -3.0..3.0f64, x in -3.0..3.0f64, near in -1e-9..1e-9f64, words in 2..6usize) {
            prop_assume!(x != 0.0 && near != 0.0);
            let bits = 64 * words;
            let atan2 = |y: f64, x: f64| error_in_units(bits, 2 * bits, || Big::from_double(y).atan2(Big::from_double(x)));
            prop_assert!(atan2(y, x) <= LIBRARY_UNITS);
            prop_assert!(atan2(near, x) <= LIBRARY_UNITS);
            prop_assert!(atan2(y, near) <= LIBRARY_UNITS);
            let ln = |x: f64| error_in_units(bits, 2 * bits, || Big::from_double(x).ln());
            prop_assert!(ln(x.abs()) <= LIBRARY_UNITS);
            prop_assert!(ln(1.0 + near) <= LIBRARY_UNITS);
            prop_assert!(ln(near.abs()) <= LIBRARY_UNITS);
            prop_assert!(error_in_units(bits, 2 * bits, || Big::from_double(x.abs()).sqrt()) <= 1.0);
            prop_assert!(error_in_units(bits, 2 * bits, || Big::from_double(x) / Big::from_double(near)) <= 1.0);
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(64))]
        #[test]
        fn functions_are_those_of_the_library(y in -3.0..3.0f64, x in -3.0..3.0f64, near in -0.02..0.02f64, words in 1..6usize) {
            prop_assume!(x != 0.0 && y != 0.0);
            let bits = 64 * words;
            let mut constants = Consts::new().unwrap();
            let units = |ours: &BigFloat, library: &BigFloat| {
                let apart = Magnitude::of_number(&exact_sum(ours, &library.neg())) / Magnitude::of_number(library);
                (apart * Magnitude::power_of_two(bits as i64)).to_double()
            };
            for x in [x.abs(), 1.0 + near, near.abs() + 1e-300, 2.0 - near] {
                let third = with_bits(bits, || (Big::from_double(x) / Big::from_double(3.0)).to_float());
                for x in [third, crate::big::float::exact(x)] {
                    let ours = ln(&x, bits, &mut Steps::default(), &mut constants);
                    prop_assert!(units(&ours, &x.ln(bits, NEAREST, &mut constants)) <= 1.0);
                }
            }
            for (y, x) in [(y, x), (near, x), (y, near)] {
                let [y, x] = [y, x].map(crate::big::float::exact);
                let ours = atan2(&y, &x, bits, &mut Steps::default(), &mut constants);
                let mut library = y.div(&x, 2 * bits, NEAREST).atan(2 * bits, NEAREST, &mut constants);
                if x.is_negative() {
                    let pi = constants.pi(2 * bits, NEAREST);
                    library = library.add(&if y.is_negative() { pi.neg() } else { pi }, 2 * bits, NEAREST);
                }
                prop_assert!(units(&ours, &library) <= 1.0);
            }
        }

        #[test]
        fn sums_and_products_are_rounded_to_nearest(a in -1.0..1.0f64, b in -1.0..1.0f64, shift in -400..400i32, bits in 1..4usize) {
            prop_assume!(a != 0.0 && b != 0.0);
            let bits = 64 * bits;
            // Thirds fill all bits.
            let operand = |x: f64| Big::from_double(x) / Big::from_double(3.0);
            let (p, q) = with_bits(bits, || (operand(a).to_float(), operand(b).scaled(2f64.powi(shift)).to_float()));
            let error_in_units = |rounded: BigFloat, exact: BigFloat| {
                let units = Magnitude::of_number(&exact_sum(&rounded, &exact.neg())) / Magnitude::of_number(&exact);
                (units * Magnitude::power_of_two(bits as i64)).to_double()
            };
            prop_assert!(error_in_units(p.add(&q, bits, NEAREST), exact_sum(&p, &q)) <= 1.0);
            prop_assert!(error_in_units(p.sub(&q, bits, NEAREST), exact_sum(&p, &q.neg())) <= 1.0);
            prop_assert!(error_in_units(p.mul(&q, bits, NEAREST), p.mul_full_prec(&q)) <= 1.0);
            prop_assert!(error_in_units(p.div(&q, bits, NEAREST).mul_full_prec(&q), p.clone()) <= 1.0);
            prop_assert!(error_in_units(p.abs().sqrt(bits, NEAREST).mul_full_prec(&p.abs().sqrt(bits, NEAREST)), p.abs()) <= 2.0);
        }
    }

    #[test]
    fn angles_on_the_axes_are_multiples_of_a_right_angle() {
        with_bits(128, || {
            let angle = |y: f64, x: f64| Big::from_double(y).atan2(Big::from_double(x)).high();
            let pi = std::f64::consts::PI;
            assert_eq!([angle(0.0, 2.0), angle(3.0, 0.0), angle(0.0, -2.0), angle(-3.0, 0.0)], [0.0, pi / 2.0, pi, -pi / 2.0]);
            assert_eq!(angle(0.0, 0.0), 0.0);
        });
    }
}
