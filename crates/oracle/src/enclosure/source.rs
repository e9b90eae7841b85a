//! Emissions an enclosure can integrate: the radiosity of a polygon, as a polynomial in the position.
//!
//! A constant, an affine function (HS95 A.1, A.2), or any polynomial in x, y, z; only its restriction to the polygon matters.
//! Along a line `y = q + s c` it is a polynomial in `s`, and that is how it enters the integrals: `B(q + s c) = sum s^k b_k(c)`
//! with `b_k` the part of degree k of the Taylor expansion at q. Units: radiosity in W/m2.

use glam::DVec3;
use radgrad_core::{Emission, Emitter, Linear, Polygon};

use crate::Error;
use crate::enclosure::arithmetic::Real;
use crate::enclosure::ball::{Ball, BallVector, vector};
use crate::enclosure::exact::{Exact, ExactVector, cross, difference, dot};
use crate::enclosure::surface::{Frame, Triangle};

/// A polynomial in the coordinates of the emitter's points.
///
/// ```
/// use radgrad_core::DVec3;
/// use radgrad_oracle::Polynomial;
/// let emission = Polynomial::new(vec![(2.0, [0, 0, 0]), (-3.0, [1, 0, 2])])?; // 2 - 3 x z^2
/// assert_eq!(emission.value_at(DVec3::new(1.0, 5.0, 2.0)), -10.0);
/// assert_eq!(emission.gradient_at(DVec3::new(1.0, 5.0, 2.0)), DVec3::new(-12.0, 0.0, -12.0));
/// # Ok::<(), radgrad_oracle::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Polynomial {
    terms: Vec<(f64, [u32; 3])>,
}

impl Polynomial {
    /// Highest total degree of a term.
    pub const MOST_DEGREE: u32 = 16;

    /// The sum of `coefficient x^i y^j z^k` over the given `(coefficient, [i, j, k])`.
    ///
    /// # Errors
    /// If a coefficient is not finite or a degree above [`Self::MOST_DEGREE`].
    pub fn new(terms: Vec<(f64, [u32; 3])>) -> Result<Self, Error> {
        for (index, &(value, powers)) in terms.iter().enumerate() {
            if !value.is_finite() {
                return Err(Error::Coefficient { index, value });
            }
            let degree = powers.iter().fold(0u32, |sum, p| sum.saturating_add(*p));
            if degree > Self::MOST_DEGREE {
                return Err(Error::Degree { degree, most: Self::MOST_DEGREE });
            }
        }
        Ok(Self { terms })
    }

    /// The terms as given.
    #[must_use]
    pub fn terms(&self) -> &[(f64, [u32; 3])] {
        &self.terms
    }

    /// The value at `y`, rounded.
    #[must_use]
    pub fn value_at(&self, y: DVec3) -> f64 {
        self.terms.iter().map(|&(coefficient, powers)| coefficient * monomial(y, powers)).sum()
    }

    /// The gradient at `y`, rounded.
    #[must_use]
    pub fn gradient_at(&self, y: DVec3) -> DVec3 {
        let mut gradient = DVec3::ZERO;
        for &(coefficient, powers) in &self.terms {
            for axis in (0..3).filter(|&axis| powers[axis] > 0) {
                let mut lower = powers;
                lower[axis] -= 1;
                gradient[axis] += coefficient * f64::from(powers[axis]) * monomial(y, lower);
            }
        }
        gradient
    }

    fn degree(&self) -> usize {
        self.terms.iter().map(|(_, powers)| powers.iter().sum::<u32>() as usize).max().unwrap_or(0)
    }
}

fn monomial(y: DVec3, powers: [u32; 3]) -> f64 {
    let power = |axis: usize| (0..powers[axis]).fold(1.0, |product, _| product * y[axis]);
    power(0) * power(1) * power(2)
}

/// A polygon and its emission.
#[derive(Debug, Clone, Copy)]
pub enum Source<'a> {
    /// An emitter of core with any of its emissions.
    Emitter(&'a Emitter),
    /// Polynomial around the world's origin.
    Polynomial {
        /// Where.
        polygon: &'a Polygon,
        /// How much.
        emission: &'a Polynomial,
    },
}

impl Source<'_> {
    pub(crate) const fn polygon(&self) -> &Polygon {
        match self {
            Self::Emitter(emitter) => emitter.polygon(),
            Self::Polynomial { polygon, .. } => polygon,
        }
    }

    /// The exponent of the power of two above the largest number that states the emission in coordinates scaled by `2^scale`;
    /// none if all are 0.
    pub(crate) fn exponent(&self, scale: i32) -> Option<i32> {
        let exponent = |v: f64| (v != 0.0).then(|| Exact::from(v).exponent());
        let lowered = |(c, powers): (f64, [u32; 3])| exponent(c).map(|e| e - scale * total(powers));
        match self {
            Self::Emitter(emitter) => match emitter.emission() {
                Emission::Constant(value) => exponent(*value),
                Emission::Linear(Linear::AtVertices(values)) => values.iter().filter_map(|v| exponent(*v)).max(),
                Emission::Linear(Linear::Gradient { value, gradient }) => {
                    let slopes = gradient.to_array().into_iter().filter_map(|g| exponent(g).map(|e| e - scale));
                    slopes.chain(exponent(*value)).max()
                }
                Emission::Polynomial(emission) => terms(emission).filter_map(lowered).max(),
            },
            Self::Polynomial { emission, .. } => emission.terms.iter().copied().filter_map(lowered).max(),
        }
    }

    /// The emission on one triangle in the coordinates of `frame`, times `2^-exponent`.
    pub(crate) fn expansion<T: Real>(&self, frame: &Frame, triangle: &Triangle, exponent: i32, bits: usize) -> Expansion<T> {
        let scaled = |v: f64, power: i32| Exact::from(v).times_power(power - exponent);
        match self {
            Self::Emitter(emitter) => match emitter.emission() {
                Emission::Constant(value) => {
                    let coefficients = vec![Ball::from_exact(&scaled(*value, 0), bits)];
                    Expansion { degree: 0, at: vector(&frame.vertices[0], bits), coefficients }
                }
                Emission::Linear(Linear::AtVertices(values)) => {
                    let values = triangle.corners.map(|i| scaled(values[i], 0));
                    interpolant(frame, triangle, &values, bits)
                }
                Emission::Linear(Linear::Gradient { value, gradient }) => {
                    let gradient = gradient.to_array().map(|g| Ball::from_exact(&scaled(g, -frame.scale), bits));
                    affine(vector(&frame.vertices[0], bits), Ball::from_exact(&scaled(*value, 0), bits), gradient)
                }
                Emission::Polynomial(emission) => {
                    let offset = emission.origin().to_array().map(|o| Exact::from(o).times_power(frame.scale));
                    let origin = std::array::from_fn(|i| &frame.origin[i] + &offset[i]);
                    let terms = terms(emission).map(|(c, powers)| (scaled(c, -frame.scale * total(powers)), powers));
                    around(&origin, emission.degree() as usize, terms, bits)
                }
            },
            Self::Polynomial { emission, .. } => {
                let terms = emission.terms.iter().map(|&(c, powers)| (scaled(c, -frame.scale * total(powers)), powers));
                around(&frame.origin, emission.degree(), terms, bits)
            }
        }
    }
}

/// The expansion at `origin` with the given terms.
fn around<T: Real>(
    origin: &ExactVector,
    degree: usize,
    terms: impl Iterator<Item = (Exact, [u32; 3])>,
    bits: usize,
) -> Expansion<T> {
    let mut exact = vec![Exact::zero(); (degree + 1).pow(3)];
    for (coefficient, powers) in terms {
        let place = &mut exact[place(degree, powers.map(|p| p as usize))];
        *place = &*place + &coefficient;
    }
    let coefficients = exact.iter().map(|c| Ball::from_exact(c, bits)).collect();
    Expansion { degree, at: vector(origin, bits), coefficients }
}

/// The terms of an emitter's polynomial.
fn terms(emission: &radgrad_core::Polynomial) -> impl Iterator<Item = (f64, [u32; 3])> {
    emission.terms().iter().map(|term| (term.coefficient, term.powers.map(u32::from)))
}

/// Total degree of a term; below [`Polynomial::MOST_DEGREE`].
fn total(powers: [u32; 3]) -> i32 {
    powers.into_iter().fold(0, |sum, p| sum + i32::try_from(p).unwrap_or(i32::MAX / 4))
}

/// The affine function with the given values at the corners of a triangle. With edges `e1, e2` from corner 0 and `N = e1 x e2`
/// its in-plane gradient is `(D1 (e2 x N) + D2 (N x e1)) / N.N`.
fn interpolant<T: Real>(frame: &Frame, triangle: &Triangle, values: &[Exact; 3], bits: usize) -> Expansion<T> {
    let [r0, r1, r2] = triangle.corners.map(|i| &frame.vertices[i]);
    let (e1, e2) = (difference(r1, r0), difference(r2, r0));
    let (d1, d2) = (&values[1] - &values[0], &values[2] - &values[0]);
    let (first, second) = (cross(&e2, &triangle.normal), cross(&triangle.normal, &e1));
    let square = Ball::<T>::from_exact(&dot(&triangle.normal, &triangle.normal), bits);
    let gradient = std::array::from_fn(|i| {
        let above: Exact = &(&d1 * &first[i]) + &(&d2 * &second[i]);
        Ball::from_exact(&above, bits).divided_by(&square)
    });
    affine(vector(r0, bits), Ball::from_exact(&values[0], bits), gradient)
}

fn affine<T: Real>(at: BallVector<T>, value: Ball<T>, [x, y, z]: BallVector<T>) -> Expansion<T> {
    let mut coefficients = vec![value.zero(); 8];
    for (powers, coefficient) in [([0, 0, 1], z), ([0, 1, 0], y), ([1, 0, 0], x), ([0; 3], value)] {
        coefficients[place(1, powers)] = coefficient;
    }
    Expansion { degree: 1, at, coefficients }
}

/// Place of a monomial in the cube of coefficients.
const fn place(degree: usize, [i, j, k]: [usize; 3]) -> usize {
    (i * (degree + 1) + j) * (degree + 1) + k
}

/// The monomials of total degree `total`.
fn monomials(total: usize) -> impl Iterator<Item = [usize; 3]> {
    (0..=total).flat_map(move |i| (0..=total - i).map(move |j| [i, j, total - i - j]))
}

/// Taylor expansion of the emission at a point, in coordinates relative to the receiver: a cube of coefficients, zero above the
/// degree.
#[derive(Debug, Clone)]
pub(crate) struct Expansion<T> {
    pub(crate) degree: usize,
    at: BallVector<T>,
    coefficients: Vec<Ball<T>>,
}

impl<T: Real> Expansion<T> {
    /// The same polynomial expanded at another point: a shift of one variable after the other by repeated synthetic division.
    pub(crate) fn moved(&self, to: &BallVector<T>) -> Self {
        let n = self.degree;
        let mut coefficients = self.coefficients.clone();
        for axis in 0..3 {
            let step = &to[axis] - &self.at[axis];
            for other in 0..=n {
                for another in 0..=n - other {
                    let index = |power: usize| {
                        let mut powers = [other, another, 0];
                        powers.rotate_right(axis + 1);
                        powers[axis] = power;
                        place(n, powers)
                    };
                    let top = n - other - another;
                    for low in 0..top {
                        for power in (low..top).rev() {
                            coefficients[index(power)] = &coefficients[index(power)] + &(&step * &coefficients[index(power + 1)]);
                        }
                    }
                }
            }
        }
        Self { degree: n, at: to.clone(), coefficients }
    }

    /// The product with `m.y`.
    pub(crate) fn times_linear(&self, m: &BallVector<T>) -> Self {
        let degree = self.degree + 1;
        let constant = crate::enclosure::ball::dot(m, &self.at);
        let mut coefficients = vec![constant.zero(); (degree + 1).pow(3)];
        for powers in (0..=self.degree).flat_map(monomials) {
            let coefficient = self.coefficient(powers);
            let here = &mut coefficients[place(degree, powers)];
            *here = &*here + &(coefficient * &constant);
            for axis in 0..3 {
                let mut raised = powers;
                raised[axis] += 1;
                let there = &mut coefficients[place(degree, raised)];
                *there = &*there + &(coefficient * &m[axis]);
            }
        }
        Self { degree, at: self.at.clone(), coefficients }
    }

    /// Coefficient of a monomial, by its powers.
    pub(crate) fn coefficient(&self, powers: [usize; 3]) -> &Ball<T> {
        &self.coefficients[place(self.degree, powers)]
    }

    /// `b_0 ..= b_degree` along a direction.
    pub(crate) fn along(&self, direction: &BallVector<T>) -> Vec<Ball<T>> {
        (0..=self.degree).map(|k| self.part(k, None, direction)).collect()
    }

    /// The same for the component of the gradient along an axis, whose degree is lower by one.
    pub(crate) fn derivative_along(&self, axis: usize, direction: &BallVector<T>) -> Vec<Ball<T>> {
        (0..self.degree).map(|k| self.part(k, Some(axis), direction)).collect()
    }

    /// The part of degree `total` of the expansion, or of its derivative, at the given displacement.
    fn part(&self, total: usize, derived: Option<usize>, direction: &BallVector<T>) -> Ball<T> {
        let mut sum: Option<Ball<T>> = None;
        for powers in monomials(total) {
            let mut term = match derived {
                None => self.coefficient(powers).clone(),
                Some(axis) => {
                    let mut raised = powers;
                    raised[axis] += 1;
                    self.coefficient(raised).times_small(raised[axis])
                }
            };
            for axis in 0..3 {
                term = (0..powers[axis]).fold(term, |product, _| &product * &direction[axis]);
            }
            sum = Some(sum.map_or_else(|| term.clone(), |sum| &sum + &term));
        }
        sum.unwrap_or_else(|| self.coefficients[0].zero())
    }
}

/// The world's origin in the receiver's frame.
pub(crate) fn origin(position: DVec3, scale: i32) -> ExactVector {
    position.to_array().map(|p| (-&Exact::from(p)).times_power(scale))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::enclosure::double_double::DoubleDouble;

    #[test]
    fn a_moved_expansion_is_the_same_polynomial() {
        let degree = 4;
        let ball = |v: f64| Ball::<DoubleDouble>::from_f64(v, 106);
        let coefficients = (0..125)
            .map(|index| {
                let powers = [index / 25, index / 5 % 5, index % 5];
                ball(if powers.iter().sum::<usize>() <= degree { (index as f64 * 0.37).fract() - 0.5 } else { 0.0 })
            })
            .collect();
        let here = Expansion { degree, at: [ball(0.0), ball(0.0), ball(0.0)], coefficients };
        let to = [ball(0.5), ball(-1.25), ball(2.0)];
        let there = here.moved(&to);
        let direction = [ball(0.75), ball(1.5), ball(-0.125)];
        let end = std::array::from_fn(|i| &to[i] + &direction[i]);
        let sum = |parts: Vec<Ball<DoubleDouble>>| parts.iter().fold(ball(0.0), |sum, part| &sum + part);
        let pairs = [
            (sum(here.along(&end)), sum(there.along(&direction))),
            (sum(here.derivative_along(1, &end)), sum(there.derivative_along(1, &direction))),
        ];
        for (one, other) in pairs {
            let difference = &one - &other;
            assert!(one.leading().abs() > 0.1 && difference.radius < 1e-27);
            assert!(difference.leading().abs() <= difference.radius, "{} {}", one.leading(), other.leading());
        }
    }

    #[test]
    fn unusable_terms_are_named() {
        assert!(matches!(Polynomial::new(vec![(1.0, [0; 3]), (f64::NAN, [1, 0, 0])]), Err(Error::Coefficient { index: 1, .. })));
        assert_eq!(Polynomial::new(vec![(1.0, [9, 9, 0])]), Err(Error::Degree { degree: 18, most: 16 }));
    }
}
