//! Double-double arithmetic: an unevaluated sum `hi + lo` of two doubles, about 106 bits.
//!
//! Used where the *input* of a closed form would lose digits in plain double precision: the height of the receiver over
//! the emitter plane, its distance to an edge line, a vertex's height over the horizon. Differences of two doubles and
//! products of two doubles are exact; the operations on double-doubles have the relative errors proven by Joldes, Muller
//! and Popescu, "Tight and rigorous error bounds for basic building blocks of double-word arithmetic" (ACM TOMS 44, 2017),
//! u = 2^-53: sum 3u^2/(1-4u) (their Algorithm 6), product 5u^2 (Algorithm 11 without FMA: 7u^2, see there).
//! All of it holds while nothing over- or underflows; callers normalise by a power of two first.

use std::ops::{Add, Div, Mul, Neg, Range, Sub};

use crate::arithmetic::Doubles;

pub(crate) mod functions;
pub use functions::LIBRARY_UNITS;

/// `hi + lo` with `|lo| <= ulp(hi)/2`; of lanes of doubles, several side by side.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct DoubleDouble<T = f64> {
    /// The sum, rounded.
    pub hi: T,
    /// The rest.
    pub lo: T,
}

/// Relative error of one operation: above every bound of the module documentation, u^2 = 2^-106.
pub const ROUNDOFF_OF_DOUBLE_DOUBLE: f64 = 8.0 / (1u128 << 106) as f64;

/// Exact sum `a + b = s + t` (Knuth 1969).
#[inline(always)]
pub fn two_sum<T: Doubles>(a: T, b: T) -> (T, T) {
    let s = a + b;
    let b_seen = s - a;
    (s, (a - (s - b_seen)) + (b - b_seen))
}

/// Exact sum for `|a| >= |b|` (Dekker 1971).
#[inline(always)]
pub(crate) fn fast_two_sum<T: Doubles>(a: T, b: T) -> (T, T) {
    let s = a + b;
    (s, b - (s - a))
}

/// Exact product `a b = p + e`.
#[inline(always)]
pub fn two_product<T: Doubles>(a: T, b: T) -> (T, T) {
    let p = a * b;
    (p, a.product_error(b, p))
}

/// Numbers whose product with a roundoff of double-double is normal, and whose halves do not overflow.
const SQUARES: Range<f64> = 1e-240..1e300;

impl<T: Doubles> DoubleDouble<T> {
    /// The exact difference of two doubles.
    #[inline(always)]
    pub fn difference(a: T, b: T) -> Self {
        let (hi, lo) = two_sum(a, -b);
        Self { hi, lo }
    }

    /// Multiplied by a power of two: exact.
    #[inline(always)]
    pub fn scaled(self, power_of_two: f64) -> Self {
        let power = self.hi.like(power_of_two);
        Self { hi: self.hi * power, lo: self.lo * power }
    }
}

impl DoubleDouble {
    /// Numbers by their high and low parts.
    pub(crate) const fn table<const N: usize>(parts: [(f64, f64); N]) -> [Self; N] {
        let (mut table, mut index) = ([Self::ZERO; N], 0);
        while index < N {
            (table[index].hi, table[index].lo) = parts[index];
            index += 1;
        }
        table
    }

    /// Zero.
    pub const ZERO: Self = Self { hi: 0.0, lo: 0.0 };

    /// The nearest double, up to half an ulp.
    #[inline]
    pub fn to_f64(self) -> f64 {
        self.hi + self.lo
    }

    /// Square root by one Newton step from the double one; relative error below 4u^2 (Karp and Markstein 1997). Where the square
    /// of the root would underflow or overflow it is that of a multiple by a power of four; infinity and NaN stay so.
    #[inline]
    pub fn sqrt(self) -> Self {
        if self.hi <= 0.0 {
            return Self::ZERO;
        }
        if !SQUARES.contains(&self.hi) {
            if !self.hi.is_finite() {
                return Self::from(self.hi);
            }
            let (power, root) = if self.hi < SQUARES.start { (600, -300) } else { (-600, 300) };
            return self.scaled(libm::scalbn(1.0, power)).sqrt().scaled(libm::scalbn(1.0, root));
        }
        let root = self.hi.sqrt();
        let (square, error) = two_product(root, root);
        let residual = (self - Self { hi: square, lo: error }).to_f64();
        let (hi, lo) = fast_two_sum(root, residual / (2.0 * root));
        Self { hi, lo }
    }

    /// Quotient by two long-division steps; relative error below 16u^2.
    #[inline]
    pub fn divided_by(self, divisor: Self) -> Self {
        let first = self.hi / divisor.hi;
        let remainder = self - divisor * Self::from(first);
        let second = remainder.hi / divisor.hi;
        let last_remainder = remainder - divisor * Self::from(second);
        let third = last_remainder.hi / divisor.hi;
        let (hi, lo) = fast_two_sum(first, second);
        Self { hi, lo } + Self::from(third)
    }
}

impl From<f64> for DoubleDouble {
    #[inline]
    fn from(value: f64) -> Self {
        Self { hi: value, lo: 0.0 }
    }
}

impl<T: Doubles> Add for DoubleDouble<T> {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        self.hi.run(
            [self, other],
            #[inline(always)]
            |[a, b]| {
                let (s_hi, s_lo) = two_sum(a.hi, b.hi);
                let (t_hi, t_lo) = two_sum(a.lo, b.lo);
                let (v_hi, v_lo) = fast_two_sum(s_hi, s_lo + t_hi);
                let (hi, lo) = fast_two_sum(v_hi, t_lo + v_lo);
                Self { hi, lo }
            },
        )
    }
}

impl<T: Doubles> Neg for DoubleDouble<T> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self { hi: -self.hi, lo: -self.lo }
    }
}

impl<T: Doubles> Sub for DoubleDouble<T> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        self + (-other)
    }
}

impl Div for DoubleDouble {
    type Output = Self;
    #[inline]
    fn div(self, divisor: Self) -> Self {
        self.divided_by(divisor)
    }
}

impl<T: Doubles> Mul for DoubleDouble<T> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        self.hi.run(
            [self, other],
            #[inline(always)]
            |[a, b]| {
                let (p_hi, p_lo) = two_product(a.hi, b.hi);
                let cross = a.hi * b.lo + a.lo * b.hi;
                let (hi, lo) = fast_two_sum(p_hi, p_lo + cross);
                Self { hi, lo }
            },
        )
    }
}
