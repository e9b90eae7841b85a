//! The dot product of a double vector with an exact difference of points, correctly signed and accurate to a double-double.
//!
//! Twelve exact products are summed as a non-overlapping expansion (Shewchuk, "Adaptive precision floating-point arithmetic and
//! fast robust geometric predicates", 1997, theorem 10). Exact while no product underflows: callers normalise lengths to about
//! 1 first, so a wrong sign needs a true value below 2^-1000.

use crate::scalar::double_double::{DoubleDouble, two_product, two_sum};

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

/// `(point - origin)`, exact, times a power of two.
#[inline]
pub(crate) fn difference(point: [f64; 3], origin: [f64; 3], power: f64) -> [DoubleDouble; 3] {
    [0, 1, 2].map(|axis| DoubleDouble::difference(point[axis], origin[axis]).scaled(power))
}

/// `n . r` with `r` exact (each component an unevaluated sum), with the right sign and a relative error of at most two units.
pub(crate) fn dot(n: [f64; 3], r: [DoubleDouble; 3]) -> DoubleDouble {
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
}
