//! Arc tangent of a point, and the complement to pi.

use astro_float::{BigFloat, Consts};

use super::{NEAREST, exact_sum, shifted};

/// Error of logarithm and arc tangent in units of roundoff: 1 for the logarithm. Arc tangent: a quotient and its arc tangent err by 2 units of an
/// angle of at most pi/4; taken from pi/2 and pi that adds up to 2 + 2 + 1, then 5/2 + 2 + 1 units.
pub(super) const LIBRARY_UNITS: f64 = 6.0;

/// Angle of the point `(x, y)`, in [-pi, pi].
pub(super) fn atan2(y: &BigFloat, x: &BigFloat, bits: usize, constants: &mut Consts) -> BigFloat {
    let (across, along) = (y.abs(), x.abs());
    let swapped = across.cmp(&along).is_some_and(|order| order > 0);
    let (across, along) = if swapped { (along, across) } else { (across, along) };
    // The angle of the origin is 0, as for doubles.
    let octant = if across.is_zero() { across } else { across.div(&along, bits, NEAREST).atan(bits, NEAREST, constants) };
    let pi = constants.pi(bits, NEAREST);
    let quadrant = if swapped { shifted(&pi, -1).sub(&octant, bits, NEAREST) } else { octant };
    let half = if x.is_negative() { pi.sub(&quadrant, bits, NEAREST) } else { quadrant };
    if y.is_negative() { half.neg() } else { half }
}

/// `pi - angle`, to full relative accuracy: where the difference cancels, pi is taken to as many bits more.
pub(super) fn pi_minus(angle: &BigFloat, bits: usize, constants: &mut Consts) -> BigFloat {
    let mut pi_bits = bits + 64;
    loop {
        let difference = exact_sum(&constants.pi(pi_bits, NEAREST), &angle.neg());
        let lost = difference.exponent().map_or(0, |exponent| usize::try_from(-exponent).unwrap_or(0));
        if difference.is_zero() || pi_bits < bits + lost + 8 {
            pi_bits = (2 * pi_bits).max(bits + lost + 64);
        } else {
            return difference.add(&BigFloat::new(64), bits, NEAREST);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Big, Magnitude, with_bits};
    use super::*;
    use crate::number::Number;
    use crate::radius::Radius;
    use proptest::prelude::*;

    /// The same with more bits, brought back.
    fn units_off(bits: usize, wider: usize, function: impl Fn() -> Big) -> f64 {
        let [rough, fine] = [bits, wider].map(|bits| with_bits(bits, || function().to_float()));
        let difference = fine.sub_full_prec(&rough);
        (Magnitude::of(&difference) / Magnitude::of(&fine) * Magnitude::power_of_two(bits as i64)).to_double()
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(64))]
        #[test]
        fn functions_keep_their_error_bounds(y in -3.0..3.0f64, x in -3.0..3.0f64, near in -1e-9..1e-9f64, words in 2..6usize) {
            prop_assume!(x != 0.0 && near != 0.0);
            let bits = 64 * words;
            let atan2 = |y: f64, x: f64| units_off(bits, 2 * bits, || Big::from_double(y).atan2(Big::from_double(x)));
            prop_assert!(atan2(y, x) <= LIBRARY_UNITS);
            prop_assert!(atan2(near, x) <= LIBRARY_UNITS);
            prop_assert!(atan2(y, near) <= LIBRARY_UNITS);
            let ln = |x: f64| units_off(bits, 2 * bits, || Big::from_double(x).ln());
            prop_assert!(ln(x.abs()) <= 1.0);
            prop_assert!(ln(1.0 + near) <= 1.0);
            prop_assert!(ln(near.abs()) <= 1.0);
            prop_assert!(units_off(bits, 2 * bits, || Big::from_double(x).pi_minus()) <= 1.0);
            prop_assert!(units_off(bits, 2 * bits, || Big::from_double(x.abs()).sqrt()) <= 1.0);
            prop_assert!(units_off(bits, 2 * bits, || Big::from_double(x) / Big::from_double(near)) <= 1.0);
        }
    }

    proptest! {
        #[test]
        fn sums_and_products_are_rounded_to_nearest(a in -1.0..1.0f64, b in -1.0..1.0f64, shift in -400..400i32, bits in 1..4usize) {
            prop_assume!(a != 0.0 && b != 0.0);
            let bits = 64 * bits;
            // Thirds fill all bits.
            let operand = |x: f64| Big::from_double(x) / Big::from_double(3.0);
            let (p, q) = with_bits(bits, || (operand(a).to_float(), operand(b).scaled(2f64.powi(shift)).to_float()));
            let off = |rounded: BigFloat, exact: BigFloat| {
                let units = Magnitude::of(&exact_sum(&rounded, &exact.neg())) / Magnitude::of(&exact);
                (units * Magnitude::power_of_two(bits as i64)).to_double()
            };
            prop_assert!(off(p.add(&q, bits, NEAREST), exact_sum(&p, &q)) <= 1.0);
            prop_assert!(off(p.sub(&q, bits, NEAREST), exact_sum(&p, &q.neg())) <= 1.0);
            prop_assert!(off(p.mul(&q, bits, NEAREST), p.mul_full_prec(&q)) <= 1.0);
            prop_assert!(off(p.div(&q, bits, NEAREST).mul_full_prec(&q), p.clone()) <= 1.0);
            prop_assert!(off(p.abs().sqrt(bits, NEAREST).mul_full_prec(&p.abs().sqrt(bits, NEAREST)), p.abs()) <= 2.0);
        }
    }

    #[test]
    fn pi_minus_keeps_its_digits_next_to_pi() {
        // pi to 128 bits, taken from pi.
        let nearest = with_bits(128, || Big::pi().to_float());
        let rest = |bits| with_bits(bits, || Big::new(|_| nearest.clone()).pi_minus().to_float());
        let difference = rest(512).sub_full_prec(&rest(128));
        assert!(Magnitude::of(&difference) <= Magnitude::of(&rest(512)) * 2f64.powi(-128));
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
