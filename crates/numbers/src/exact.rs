//! Signs and sums of products of doubles, exact over the whole range of a double.
//!
//! Of lengths of an ordinary size the products are summed as a non-overlapping expansion (Shewchuk, "Adaptive precision
//! floating-point arithmetic and fast robust geometric predicates", 1997, theorem 10), or by the predicates of the crate
//! `robust`. Both are exact while no product underflows. Where one may, `WideSum` adds them in fixed point with an ulp below
//! every product of three doubles.

use glam::DVec3;

use crate::double_double::{DoubleDouble, two_product, two_sum};
use crate::power::normalising_power;

/// A sum of doubles, exact, with components that do not overlap, smallest first.
struct Expansion {
    components: [f64; 12],
    length: usize,
}

impl Expansion {
    fn add(&mut self, term: f64) {
        let mut carry = term;
        for component in &mut self.components[..self.length] {
            let (sum, error) = two_sum(carry, *component);
            *component = error;
            carry = sum;
        }
        self.components[self.length] = carry;
        self.length += 1;
    }

    /// The sum as a double-double: each component is below an ulp of the next, so that summing from the small end up loses at
    /// most a few units, and the sign is that of the largest.
    fn to_double_double(&self) -> DoubleDouble {
        self.components[..self.length].iter().fold(DoubleDouble::ZERO, |sum, c| sum + DoubleDouble::from(*c))
    }
}

/// 64-bit limbs of a [`WideSum`]: 24 products of three doubles are below 2^3077.
const LIMBS: usize = 104;

/// Exponent of the last place of a product of three doubles.
const LAST_PLACE: i32 = -3 * 1074;

/// A sum of products of three doubles in two's complement, times 2^-3222: exact for all finite doubles.
struct WideSum([u64; LIMBS]);

impl WideSum {
    const ZERO: Self = Self([0; LIMBS]);

    fn add(&mut self, factors: [f64; 3], subtracted: bool) {
        let negative = factors.iter().fold(subtracted, |negative, factor| negative ^ factor.is_sign_negative());
        // Each factor is a whole number times 2^(place - 1074).
        let field = factors.map(|factor| (factor.to_bits() >> 52) & 0x7ff);
        let whole = [0, 1, 2].map(|i| (factors[i].to_bits() & ((1 << 52) - 1)) | (u64::from(field[i] > 0) << 52));
        let place: u64 = field.iter().map(|field| (*field).max(1) - 1).sum();
        let [low, high] = limbs(u128::from(whole[0]) * u128::from(whole[1]));
        let [first, carry] = limbs(u128::from(low) * u128::from(whole[2]));
        let [second, third] = limbs(u128::from(high) * u128::from(whole[2]) + u128::from(carry));
        // At most 3 * 2045 / 64.
        let (start, shift) = ((place / 64) as usize, place % 64);
        let [a0, a1] = limbs(u128::from(first) << shift);
        let [b0, b1] = limbs(u128::from(second) << shift);
        let [c0, c1] = limbs(u128::from(third) << shift);
        let product = [a0, a1 | b0, b1 | c0, c1];
        let mut carry = false;
        for (i, limb) in self.0[start..].iter_mut().enumerate() {
            let term = product.get(i).copied().unwrap_or(0);
            if i >= product.len() && !carry {
                break;
            }
            let (sum, over) = if negative { limb.overflowing_sub(term) } else { limb.overflowing_add(term) };
            let (sum, again) = if negative { sum.overflowing_sub(carry.into()) } else { sum.overflowing_add(carry.into()) };
            (*limb, carry) = (sum, over | again);
        }
    }

    fn is_negative(&self) -> bool {
        self.0[LIMBS - 1] >> 63 == 1
    }

    fn is_positive(&self) -> bool {
        !self.is_negative() && self.0.iter().any(|limb| *limb != 0)
    }

    /// The sum times a power of two, to two units of double-double, with its sign: a size below the normal range becomes the smallest
    /// normal number.
    fn to_double_double(&self, power: i32) -> DoubleDouble {
        let negative = self.is_negative();
        let mut size = self.0;
        if negative {
            let mut carry = true;
            for limb in &mut size {
                (*limb, carry) = (!*limb).overflowing_add(carry.into());
            }
        }
        let Some(top) = size.iter().rposition(|limb| *limb != 0) else { return DoubleDouble::ZERO };
        // 129 bits at least, or all.
        let leading = |sum: DoubleDouble, i: usize| {
            let limb = top.checked_sub(i).map_or(0, |place| size[place]);
            let halves = [limb >> 32, limb & 0xffff_ffff].map(|half| DoubleDouble::from(half as f64));
            (sum.scaled(2f64.powi(32)) + halves[0]).scaled(2f64.powi(32)) + halves[1]
        };
        let leading = (0..3).fold(DoubleDouble::ZERO, leading);
        let exponent = (0..top).fold(LAST_PLACE - 2 * 64 + power, |exponent, _| exponent + 64);
        let [hi, lo] = [leading.hi, leading.lo].map(|part| libm::scalbn(part, exponent));
        let magnitude = if hi < f64::MIN_POSITIVE { DoubleDouble::from(f64::MIN_POSITIVE) } else { DoubleDouble { hi, lo } };
        if negative { -magnitude } else { magnitude }
    }
}

/// The low and the high half.
#[allow(clippy::cast_possible_truncation, reason = "the halves are what it is for")]
fn limbs(product: u128) -> [u64; 2] {
    [product as u64, (product >> 64) as u64]
}

/// `(point - origin)`, exact while it does not underflow, times a power of two.
#[inline]
pub fn difference(point: [f64; 3], origin: [f64; 3], power: f64) -> [DoubleDouble; 3] {
    let along = |axis: usize| DoubleDouble::difference(point[axis], origin[axis]).scaled(power);
    [along(0), along(1), along(2)]
}

/// Whether products of two numbers of that size, and the errors of those, are normal.
fn is_ordinary(number: f64) -> bool {
    const LEAST: f64 = 1.0 / ((1u128 << 120) as f64 * (1u128 << 120) as f64 * (1u128 << 120) as f64);
    number == 0.0 || (LEAST..1.0 / LEAST).contains(&number.abs())
}

/// `n . (point - origin)` times two powers of two, of n and of lengths, with the right sign and a relative error of at most two
/// units; below the normal range the smallest normal number of its sign.
pub fn height((n, power_of_n): (DVec3, f64), point: DVec3, origin: DVec3, power: f64) -> DoubleDouble {
    let (n, point, origin) = (n.to_array(), point.to_array(), origin.to_array());
    let are_ordinary = |r: [DoubleDouble; 3]| r.iter().all(|c| is_ordinary(c.hi) && is_ordinary(c.lo));
    // A component that is 0 only when scaled has underflowed.
    let scaled_n = n.map(|c| c * power_of_n);
    let is_kept = |i: usize| n[i] == 0.0 || (scaled_n[i] != 0.0 && is_ordinary(scaled_n[i]));
    let r = difference(point, origin, 1.0);
    let scaled = [r[0].scaled(power), r[1].scaled(power), r[2].scaled(power)];
    if (0..3).all(is_kept) && are_ordinary(r) && are_ordinary(scaled) {
        return dot(scaled_n, scaled);
    }
    let mut sum = WideSum::ZERO;
    for i in 0..3 {
        sum.add([n[i], point[i], power], false);
        sum.add([n[i], origin[i], power], true);
    }
    let (_, exponent_of_n) = libm::frexp(power_of_n);
    sum.to_double_double(exponent_of_n - 1)
}

/// Whether three points are exactly on one line: seen along each axis.
pub fn are_in_line(points: [DVec3; 3]) -> bool {
    let [a, b, c] = points.map(|p| p.to_array());
    [[0, 1], [1, 2], [2, 0]].into_iter().all(|[i, j]| {
        let mut sum = WideSum::ZERO;
        for (p, q) in [(a, b), (b, c), (c, a)] {
            sum.add([p[i], q[j], 1.0], false);
            sum.add([p[j], q[i], 1.0], true);
        }
        !sum.is_negative() && !sum.is_positive()
    })
}

/// `n . r` with `r` exact (each component an unevaluated sum), with the right sign and a relative error of at most two units.
fn dot(n: [f64; 3], r: [DoubleDouble; 3]) -> DoubleDouble {
    let mut sum = Expansion { components: [0.0; 12], length: 0 };
    for (factor, component) in n.into_iter().zip(r) {
        for part in [component.lo, component.hi] {
            let (product, error) = two_product(factor, part);
            sum.add(error);
            sum.add(product);
        }
    }
    sum.to_double_double()
}

/// A number with the sign of the determinant of `a - d`, `b - d` and `c - d`: positive where d is on the side from which a, b and
/// c run clockwise.
pub fn orientation([a, b, c, d]: [DVec3; 4]) -> f64 {
    let points = [a, b, c, d];
    let largest = points.iter().fold(0.0, |largest: f64, p| largest.max(p.abs().max_element()));
    let power = normalising_power(largest);
    // Coordinates are then multiples of 2^-152, and all that is computed from them of 2^-456.
    let is_ordinary = |c: f64| c == 0.0 || c.abs() * power >= 1.0 / (1u128 << 100) as f64;
    if points.iter().all(|p| p.to_array().into_iter().all(is_ordinary)) {
        let [a, b, c, d] = points.map(|p| p * power).map(|p| robust::Coord3D { x: p.x, y: p.y, z: p.z });
        return robust::orient3d(a, b, c, d);
    }
    let mut sum = WideSum::ZERO;
    for (rows, subtracted) in [([a, b, c], false), ([d, b, c], true), ([a, d, c], true), ([a, b, d], true)] {
        let [p, q, r] = rows.map(|row| row.to_array());
        for (i, j, k) in [(0, 1, 2), (1, 2, 0), (2, 0, 1)] {
            sum.add([p[i], q[j], r[k]], subtracted);
            sum.add([p[i], q[k], r[j]], !subtracted);
        }
    }
    if sum.is_negative() { -1.0 } else { f64::from(u8::from(sum.is_positive())) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cancellation_to_the_last_bit_is_seen() {
        let tiny = 2f64.powi(-80);
        let r = [DoubleDouble { hi: 1.0, lo: tiny }, DoubleDouble { hi: -1.0, lo: 0.0 }, DoubleDouble { hi: 0.0, lo: 0.0 }];
        assert_eq!(dot([0.1, 0.1, 3.0], r).hi, 0.1 * tiny);
        let level = [1.0 / 3.0, -0.1, 7.0].map(DoubleDouble::from);
        assert_eq!(dot([0.1, 1.0 / 3.0, 0.0], level), DoubleDouble::ZERO);
    }

    #[test]
    fn heights_beside_large_terms_keep_their_sign() {
        // 1 (1e300 - 1e300) + 1e-300 (y), from points that doubles span the whole range with.
        let n = DVec3::new(1.0, 1e-300, 0.0);
        for y in [1e-300, -1e-300, 1.0, -3.0, 1e10] {
            let computed = height((n, 1.0), DVec3::new(1e300, y, 0.0), DVec3::new(1e300, 0.0, 0.0), 1e-300);
            assert_eq!(computed.hi.signum(), y.signum(), "{y}: {computed:?}");
        }
        let computed = height((n, 1.0), DVec3::new(3.0, 1e300, 5.0), DVec3::new(2.0, -1e300, 1e-310), 0.5);
        assert_eq!(computed.hi, 1.5);
        assert_eq!(height((n, 1.0), DVec3::splat(1e-310), DVec3::splat(1e-310), 1.0), DoubleDouble::ZERO);
    }

    #[test]
    fn components_of_a_normal_far_apart_are_kept() {
        for (small, large) in [(1.25e-14, 1e308), (5e-324, f64::MAX), (1e-290, 1.0)] {
            let (n, power) = (DVec3::new(small, 0.0, large), normalising_power(large));
            let sign_at = |x: f64| height((n, power), DVec3::new(x, 0.0, 3.0), DVec3::new(0.0, 0.0, 3.0), 1.0).hi;
            assert!(sign_at(1.0) > 0.0 && sign_at(-1.0) < 0.0 && sign_at(0.0) == 0.0);
            // Times 2^900 it is within the range.
            let far = height((n, power), DVec3::new(2f64.powi(900), 0.0, 0.0), DVec3::ZERO, 1.0).hi;
            let (fraction, exponent) = libm::frexp(small);
            let (_, of_power) = libm::frexp(power);
            let truth = libm::scalbn(fraction, exponent + of_power - 1 + 900);
            assert!((far / truth - 1.0).abs() < 1e-15 || truth < f64::MIN_POSITIVE, "{far:e} {truth:e}");
        }
    }

    #[test]
    fn points_are_in_line_over_the_whole_range() {
        let [small, large] = [1e-300, 1e300];
        let line = |x: f64| DVec3::new(0.0, x, 2.0);
        assert!(are_in_line([line(-large), line(large), line(small)]) && are_in_line([line(0.0), line(small), line(large)]));
        assert!(!are_in_line([line(-large), line(large), DVec3::new(small, 0.0, 2.0)]));
        assert!(!are_in_line([line(-large), line(large), DVec3::new(0.0, 0.0, 2f64.next_up())]));
    }

    #[test]
    fn wide_sums_have_the_digits_of_expansions() {
        let mut state = 1u64;
        let mut random = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1u64 << 53) as f64 - 0.5
        };
        for _ in 0..1000 {
            let [n, point, origin] = [(); 3].map(|()| DVec3::new(random(), random(), random()));
            let mut sum = WideSum::ZERO;
            for i in 0..3 {
                sum.add([n.to_array()[i], point.to_array()[i], 1.0], false);
                sum.add([n.to_array()[i], origin.to_array()[i], 1.0], true);
            }
            let (wide, narrow) = (sum.to_double_double(0), height((n, 1.0), point, origin, 1.0));
            assert_eq!(wide.hi, narrow.hi);
            assert!((wide.lo - narrow.lo).abs() <= 1e-31 * wide.hi.abs());
        }
    }

    #[test]
    fn orientations_are_exact_over_the_whole_range() {
        let (small, large) = (1e-300, 1e300);
        let base = [DVec3::ZERO, DVec3::new(large, 0.0, 0.0), DVec3::new(0.0, small, 0.0)];
        for z in [1e-320, 1e-300, 1.0, 1e300] {
            let [above, below] = [z, -z].map(|z| orientation([base[0], base[1], base[2], DVec3::new(1.0, small, z)]));
            assert!(above < 0.0 && below > 0.0, "{z:e}: {above} {below}");
        }
        assert_eq!(orientation([base[0], base[1], base[2], DVec3::new(large, small, 0.0)]), 0.0);
        let plain = orientation([DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::new(0.2, 0.2, 1.0)]);
        assert!(plain < 0.0);
    }
}
