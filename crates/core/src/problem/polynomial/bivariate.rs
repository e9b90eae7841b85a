//! Tables over the monomials `u^i v^j` up to a degree: polynomials in the emitter's plane, and moments of its visible region.

use std::ops::{Add, Mul};

use radgrad_numbers::real::{RadiusOf, Real};

/// One entry for each `u^i v^j` with `i + j <= degree`, by degree, then by j.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Bivariate<T> {
    degree: usize,
    entries: Vec<T>,
}

fn index(i: usize, j: usize) -> usize {
    let degree = i + j;
    degree * (degree + 1) / 2 + j
}

/// The exponents of all monomials up to a degree, in the order of the entries.
pub(crate) fn exponents(degree: usize) -> impl Iterator<Item = (usize, usize)> {
    (0..=degree).flat_map(|k| (0..=k).map(move |j| (k - j, j)))
}

impl<T: Copy> Bivariate<T> {
    pub(crate) const fn degree(&self) -> usize {
        self.degree
    }

    pub(crate) fn coefficient(&self, i: usize, j: usize) -> T {
        self.entries[index(i, j)]
    }

    pub(crate) fn coefficient_mut(&mut self, i: usize, j: usize) -> &mut T {
        &mut self.entries[index(i, j)]
    }

    /// The polynomial at a point with coordinates of another type, such as one in each lane of a vector, by Horner's rule in u for
    /// each power of v, then in v.
    #[inline(always)]
    pub(crate) fn value_on<L: Copy + Add<Output = L> + Mul<Output = L>>(&self, [u, v]: [L; 2], like: impl Fn(T) -> L) -> L {
        let n = self.degree;
        let mut value = like(self.coefficient(0, n));
        for j in (0..n).rev() {
            let mut row = like(self.coefficient(n - j, j));
            for i in (0..n - j).rev() {
                row = row * u + like(self.coefficient(i, j));
            }
            value = value * v + row;
        }
        value
    }

    /// Entries made from the old ones and their exponents.
    pub(crate) fn map<U>(&self, f: impl Fn(usize, usize, T) -> U) -> Bivariate<U> {
        let entries = exponents(self.degree).zip(&self.entries).map(|((i, j), &c)| f(i, j, c)).collect();
        Bivariate { degree: self.degree, entries }
    }
}

impl<T: Real> Bivariate<T> {
    pub(crate) fn zero(degree: usize) -> Self {
        Self { degree, entries: vec![T::exact(0.0); (degree + 1) * (degree + 2) / 2] }
    }

    /// Adds another table of at most this degree, times a factor.
    pub(crate) fn add_scaled(&mut self, other: &Self, factor: T) {
        for (sum, &c) in self.entries.iter_mut().zip(&other.entries) {
            *sum = *sum + c * factor;
        }
    }

    /// Adds another table of at most this degree.
    pub(crate) fn add(&mut self, other: &Self) {
        for (sum, &c) in self.entries.iter_mut().zip(&other.entries) {
            *sum = *sum + c;
        }
    }

    /// The sum with another table of at most this degree.
    pub(crate) fn plus(mut self, other: &Self) -> Self {
        self.add(other);
        self
    }

    /// The polynomial times `constant + u along[0] + v along[1]`, one degree higher.
    pub(crate) fn times_linear(&self, constant: T, along: [T; 2]) -> Self {
        let mut product = Self::zero(self.degree + 1);
        for ((i, j), &c) in exponents(self.degree).zip(&self.entries) {
            for (factor, (i, j)) in [(constant, (i, j)), (along[0], (i + 1, j)), (along[1], (i, j + 1))] {
                *product.coefficient_mut(i, j) = product.coefficient(i, j) + c * factor;
            }
        }
        product
    }

    /// The polynomial `p(u - u0, v - v0)`, by repeated Horner steps in u for each power of v, then in v for each power of u.
    pub(crate) fn shifted(mut self, u0: T, v0: T) -> Self {
        let n = self.degree;
        for other in 0..=n {
            self.shift_one_variable(n - other, u0, |k| index(k, other));
        }
        for other in 0..=n {
            self.shift_one_variable(n - other, v0, |k| index(other, k));
        }
        self
    }

    fn shift_one_variable(&mut self, degree: usize, by: T, place: impl Fn(usize) -> usize) {
        for done in 0..degree {
            for k in (done..degree).rev() {
                self.entries[place(k)] = self.entries[place(k)] - self.entries[place(k + 1)] * by;
            }
        }
    }

    /// `u df/du + v df/dv = sum (i + j) b_ij u^i v^j`.
    pub(crate) fn radial(&self) -> Self {
        self.map(|i, j, b| if i + j > 0 { b * whole(i + j) } else { T::exact(0.0) })
    }

    /// The same polynomial as one of a higher degree.
    pub(crate) fn raised(self, degree: usize) -> Self {
        Self::zero(degree).plus(&self)
    }

    /// Partial derivatives; those of a constant are the zero polynomial of degree 0.
    pub(crate) fn gradient(&self) -> [Self; 2] {
        let mut slopes = [Self::zero(self.degree.saturating_sub(1)), Self::zero(self.degree.saturating_sub(1))];
        for ((i, j), &c) in exponents(self.degree).zip(&self.entries) {
            if i > 0 {
                *slopes[0].coefficient_mut(i - 1, j) = c * whole(i);
            }
            if j > 0 {
                *slopes[1].coefficient_mut(i, j - 1) = c * whole(j);
            }
        }
        slopes
    }

    /// Bound on the magnitude for |u| and |v| up to these.
    pub(crate) fn largest_within(&self, [u, v]: [RadiusOf<T>; 2]) -> RadiusOf<T> {
        let power = |reach: RadiusOf<T>, exponent: usize| (0..exponent).fold(RadiusOf::<T>::from(1.0), |power, _| power * reach);
        let terms =
            exponents(self.degree).zip(&self.entries).map(|((i, j), c)| (c.size() + c.error()) * power(u, i) * power(v, j));
        terms.fold(0.0.into(), |sum: RadiusOf<T>, term| sum + term)
    }

    /// The polynomial at a point.
    pub(crate) fn value(&self, point: [T; 2]) -> T {
        self.value_on(point, |c| c)
    }

    /// `sum self_ij table_(i + di, j + dj)` from degree `lowest` of this polynomial up.
    pub(crate) fn contract(&self, table: &Self, (di, dj): (usize, usize), lowest: usize) -> T {
        let terms = exponents(self.degree).zip(&self.entries).filter(|((i, j), _)| i + j >= lowest);
        terms.fold(T::exact(0.0), |sum, ((i, j), &c)| sum + c * table.coefficient(i + di, j + dj))
    }
}

/// A whole number as a scalar.
pub(crate) fn whole<T: Real>(n: usize) -> T {
    T::exact(n as f64)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// `1 + 2u - v + 3uv + v^2/2`.
    fn example() -> Bivariate<f64> {
        let mut p = Bivariate::zero(2);
        for ((i, j), c) in [((0, 0), 1.0), ((1, 0), 2.0), ((0, 1), -1.0), ((1, 1), 3.0), ((0, 2), 0.5)] {
            *p.coefficient_mut(i, j) = c;
        }
        p
    }

    fn value(p: &Bivariate<f64>, u: f64, v: f64) -> f64 {
        p.value([u, v])
    }

    #[test]
    fn horner_and_the_powers_give_the_same_value() {
        let mut powers = Bivariate::zero(2);
        powers.entries = exponents(2).map(|(i, j)| (0..i).map(|_| 3.0).chain((0..j).map(|_| -2.0)).product()).collect();
        assert_eq!(example().contract(&powers, (0, 0), 0), value(&example(), 3.0, -2.0));
        assert_eq!(value(&example(), 3.0, -2.0), 1.0 + 6.0 + 2.0 - 18.0 + 2.0);
    }

    #[test]
    fn a_shifted_polynomial_is_the_old_one_elsewhere() {
        let cubic = example().times_linear(0.5, [2.0, -1.0]);
        for (u, v) in [(0.0, 0.0), (1.0, -2.0), (0.25, 4.0)] {
            assert_eq!(value(&cubic, u, v), value(&example(), u, v) * (0.5 + 2.0 * u - v));
            assert_eq!(value(&cubic.clone().shifted(1.5, -3.0), u, v), value(&cubic, u - 1.5, v + 3.0));
        }
    }

    #[test]
    fn slopes_are_the_partial_derivatives() {
        let [u, v] = example().gradient();
        assert_eq!((value(&u, 5.0, 7.0), value(&v, 5.0, 7.0)), (2.0 + 21.0, -1.0 + 15.0 + 7.0));
        let constant = Bivariate::<f64>::zero(0);
        assert_eq!(constant.gradient()[0].degree(), 0);
    }
}
