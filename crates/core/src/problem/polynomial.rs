//! Emission that is a polynomial of the position: `B(y) = sum b_ijk dx^i dy^j dz^k` with `(dx, dy, dz) = y - origin`.
//!
//! The user's [`Polynomial`] has three variables and any origin. [`plane`] restricts it to the emitter's plane once per emitter.
//! Its closed form is in `forms/polynomial`: `segment` integrates powers along the pieces of the visible boundary, `moments` brings
//! every integral over the visible region down to those and one non-elementary number, and `sum` puts radiosity and gradient
//! together.
//!
//! Units: coefficients in the unit of the emission over the unit of length to the power of the degree.

pub(crate) mod bivariate;
pub(crate) mod plane;

use glam::DVec3;

use crate::error::Error;

/// One term, `coefficient * dx^powers[0] * dy^powers[1] * dz^powers[2]`.
///
/// ```
/// use radgrad_core::{DVec3, Monomial, Polynomial};
/// let product = Polynomial::new(DVec3::ZERO, [(3.0, [1, 1, 0])])?; // 3 x y
/// assert_eq!(product.terms(), [Monomial { coefficient: 3.0, powers: [1, 1, 0] }]);
/// assert_eq!(product.value_at(DVec3::new(2.0, 5.0, 7.0)), 30.0);
/// # Ok::<(), radgrad_core::Error>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Monomial {
    /// Factor, in the unit of the emission over the unit of length to the power of the degree.
    pub coefficient: f64,
    /// Exponents of the three coordinates.
    pub powers: [u8; 3],
}

/// A polynomial in the position relative to an origin.
///
/// Only its values on the emitter's plane matter. An origin near the emitter keeps the digits of high powers; the answer's bounds
/// include the loss.
///
/// ```
/// use radgrad_core::{DVec3, Emission, Emitter, Polygon, Polynomial, Receiver, evaluate};
/// // A disc lamp's profile, brightest above the origin: 4 - 2 dx^2 - 2 dy^2.
/// let profile = Polynomial::new(DVec3::Z, [(4.0, [0, 0, 0]), (-2.0, [2, 0, 0]), (-2.0, [0, 2, 0])])?;
/// assert_eq!(profile.value_at(DVec3::new(1.0, 0.5, 1.0)), 1.5);
/// let corners = [(-1.0, -1.0), (-1.0, 1.0), (1.0, 1.0), (1.0, -1.0)].map(|(x, y)| DVec3::new(x, y, 1.0));
/// let lamp = Emitter::new(Polygon::new(corners.to_vec())?, Emission::Polynomial(profile))?;
/// let answer = evaluate(&Receiver::new(DVec3::ZERO, DVec3::Z, 1.0)?, &lamp, &[])?;
/// assert!(answer.radiosity_error <= 1e-12 * answer.radiosity);
/// # Ok::<(), radgrad_core::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Polynomial {
    origin: DVec3,
    terms: Vec<Monomial>,
}

impl Polynomial {
    /// Highest degree accepted, that of an exponent of 8 bits. The closed form costs the third power of the degree an edge, and
    /// each degree loses digits, which the bounds say: high ones take double-double or more bits.
    ///
    /// ```
    /// # use radgrad_core::{DVec3, Error, Polynomial};
    /// assert!(Polynomial::new(DVec3::ZERO, [(1.0, [255, 0, 0])]).is_ok());
    /// let error = Polynomial::new(DVec3::ZERO, [(1.0, [255, 1, 0])]).unwrap_err();
    /// assert_eq!(error, Error::EmissionDegree { index: 0, degree: 256, allowed: Polynomial::MAX_DEGREE });
    /// ```
    pub const MAX_DEGREE: u32 = 255;

    /// The polynomial with the given terms, each a coefficient and the exponents of `dx`, `dy` and `dz`. Terms
    /// with the same exponents add up; no terms make the zero polynomial.
    ///
    /// ```
    /// use radgrad_core::{DVec3, Polynomial};
    /// let parabola = Polynomial::new(DVec3::X, [(4.0, [0, 0, 0]), (-2.0, [2, 0, 0])])?; // 4 - 2 (x - 1)^2
    /// assert_eq!((parabola.value_at(DVec3::X), parabola.value_at(DVec3::ZERO)), (4.0, 2.0));
    /// assert!(Polynomial::new(DVec3::ZERO, [(f64::NAN, [0, 0, 0])]).is_err());
    /// # Ok::<(), radgrad_core::Error>(())
    /// ```
    ///
    /// # Errors
    /// If the origin or a coefficient is not finite, or a term's degree is above [`Self::MAX_DEGREE`].
    pub fn new(origin: DVec3, terms: impl IntoIterator<Item = (f64, [u8; 3])>) -> Result<Self, Error> {
        for (axis, value) in origin.to_array().into_iter().enumerate() {
            if !value.is_finite() {
                return Err(Error::EmissionNotFinite { place: format!("origin component {axis}"), value });
            }
        }
        let terms: Vec<Monomial> = terms.into_iter().map(|(coefficient, powers)| Monomial { coefficient, powers }).collect();
        for (index, term) in terms.iter().enumerate() {
            if !term.coefficient.is_finite() {
                return Err(Error::EmissionNotFinite { place: format!("coefficient of term {index}"), value: term.coefficient });
            }
            if term.degree() > Self::MAX_DEGREE {
                return Err(Error::EmissionDegree { index, degree: term.degree(), allowed: Self::MAX_DEGREE });
            }
        }
        Ok(Self { origin, terms })
    }

    /// The point that positions are relative to.
    ///
    /// ```
    /// # use radgrad_core::{DVec3, Polynomial};
    /// assert_eq!(Polynomial::new(DVec3::Z, [])?.origin(), DVec3::Z);
    /// # Ok::<(), radgrad_core::Error>(())
    /// ```
    #[must_use]
    pub const fn origin(&self) -> DVec3 {
        self.origin
    }

    /// The terms as given.
    ///
    /// ```
    /// # use radgrad_core::{DVec3, Polynomial};
    /// let twice = Polynomial::new(DVec3::ZERO, [(1.0, [0, 0, 1]), (2.0, [0, 0, 1])])?;
    /// assert_eq!(twice.terms().len(), 2); // kept apart, though they add up
    /// assert_eq!(twice.value_at(DVec3::Z), 3.0);
    /// # Ok::<(), radgrad_core::Error>(())
    /// ```
    #[must_use]
    pub fn terms(&self) -> &[Monomial] {
        &self.terms
    }

    /// Largest degree of a term; 0 without terms.
    ///
    /// ```
    /// # use radgrad_core::{DVec3, Polynomial};
    /// assert_eq!(Polynomial::new(DVec3::ZERO, [(1.0, [3, 0, 0]), (1.0, [2, 2, 1])])?.degree(), 5);
    /// # Ok::<(), radgrad_core::Error>(())
    /// ```
    #[must_use]
    pub fn degree(&self) -> u32 {
        self.terms.iter().map(Monomial::degree).max().unwrap_or(0)
    }

    /// The value at a point.
    ///
    /// ```
    /// # use radgrad_core::{DVec3, Polynomial};
    /// let profile = Polynomial::new(DVec3::Z, [(1.0, [0, 0, 0]), (0.5, [1, 0, 2])])?; // 1 + x (z - 1)^2 / 2
    /// assert_eq!(profile.value_at(DVec3::new(2.0, 0.0, 4.0)), 10.0);
    /// # Ok::<(), radgrad_core::Error>(())
    /// ```
    #[must_use]
    pub fn value_at(&self, point: DVec3) -> f64 {
        let r = (point - self.origin).to_array();
        self.terms.iter().map(|term| term.coefficient * product(r, term.powers)).sum()
    }

    /// The gradient at a point, all three components.
    ///
    /// ```
    /// # use radgrad_core::{DVec3, Polynomial};
    /// let product = Polynomial::new(DVec3::ZERO, [(3.0, [2, 1, 0])])?; // 3 x^2 y
    /// assert_eq!(product.gradient_at(DVec3::new(1.0, 2.0, 0.0)), DVec3::new(12.0, 3.0, 0.0));
    /// # Ok::<(), radgrad_core::Error>(())
    /// ```
    #[must_use]
    pub fn gradient_at(&self, point: DVec3) -> DVec3 {
        let r = (point - self.origin).to_array();
        let slope = |axis: usize| -> f64 {
            let lowered = self.terms.iter().filter(|term| term.powers[axis] > 0).map(|term| {
                let mut powers = term.powers;
                powers[axis] -= 1;
                term.coefficient * f64::from(term.powers[axis]) * product(r, powers)
            });
            lowered.sum()
        };
        DVec3::new(slope(0), slope(1), slope(2))
    }
}

impl Monomial {
    /// Sum of the exponents.
    ///
    /// ```
    /// # use radgrad_core::Monomial;
    /// assert_eq!(Monomial { coefficient: 2.0, powers: [1, 0, 2] }.degree(), 3);
    /// ```
    #[must_use]
    pub fn degree(&self) -> u32 {
        self.powers.iter().map(|&p| u32::from(p)).sum()
    }
}

/// Powers by multiplication, the same on every machine.
fn product(r: [f64; 3], powers: [u8; 3]) -> f64 {
    let factors = r.into_iter().zip(powers).flat_map(|(c, power)| (0..power).map(move |_| c));
    factors.product()
}
