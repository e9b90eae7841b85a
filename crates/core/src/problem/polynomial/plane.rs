//! A polynomial of the position restricted to the plane of a polygon, the only part of it that matters.
//!
//! `y = m + u t_1 + v t_2`, m the middle of the polygon and `(t_1, t_2, n2)` orthonormal, turns `B(y)` into `sum b_ij u^i v^j`.
//! Done once per emitter, in double-double with running bounds, lengths in a unit near the polygon's size: coefficients lose digits
//! to cancellation when the origin is far from the polygon, and their bounds include the loss. For scalars with more digits it is
//! done anew.

use glam::DVec3;
use radgrad_numbers::ball::Ball;
use radgrad_numbers::double_double::DoubleDouble;
use radgrad_numbers::number::Number;
use radgrad_numbers::offset::offset;
use radgrad_numbers::power::normalising_power;
use radgrad_numbers::real::Real;
use radgrad_numbers::vec3::Vec3;

use crate::error::Error;
use crate::problem::affine::Affine;
use crate::problem::polygon::Polygon;
use crate::problem::polynomial::bivariate::{Bivariate, whole};
use crate::problem::polynomial::{Monomial, Polynomial};

type Precise = Ball<DoubleDouble>;

/// Coordinates in the plane of a polygon: the offset from its vertex 0 along two axes, less that of its middle.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Coordinates<T> {
    axes: [Vec3<T>; 2],
    first: DVec3,
    middle: [f64; 2],
    /// Multiplies lengths.
    power: f64,
}

/// A bivariate polynomial around the middle of a polygon.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct InPlane {
    polynomial: Polynomial,
    coordinates: Coordinates<Precise>,
    coefficients: Bivariate<Precise>,
    largest: f64,
    /// Bound on the slope, for lengths multiplied by the power of the coordinates.
    steepest: f64,
    uncertainty: f64,
}

impl<T: Real> Coordinates<T> {
    /// The middle is that of the extents along the axes.
    fn new(polygon: &Polygon) -> Self {
        let power = normalising_power(polygon.size());
        let mut plane = Self { axes: axes(polygon), first: polygon.vertices()[0], middle: [0.0; 2], power };
        plane.middle = [0, 1].map(|axis| {
            let along = polygon.vertices().iter().map(|v| plane.coordinates(*v)[axis].value());
            let (low, high) = along.fold((0.0, 0.0), |(low, high): (f64, f64), u| (low.min(u), high.max(u)));
            0.5 * (low + high)
        });
        plane
    }

    fn coordinates(&self, point: DVec3) -> [T; 2] {
        let r = offset::<T>(point, self.first, self.power);
        [0, 1].map(|i| self.axes[i].dot(r) - T::exact(self.middle[i]))
    }

    /// The middle, as an offset from `origin`.
    fn middle_from(&self, origin: DVec3) -> Vec3<T> {
        let first = offset::<T>(self.first, origin, self.power);
        first + self.axes[0] * T::exact(self.middle[0]) + self.axes[1] * T::exact(self.middle[1])
    }

    /// The unit vectors `t_1` and `t_2`.
    pub(crate) const fn axes(&self) -> [Vec3<T>; 2] {
        self.axes
    }

    /// The polynomial with these coefficients for lengths multiplied by `power`, emission by `emission_power`, and positions
    /// relative to the foot point of `x`.
    pub(crate) fn around_foot(&self, coefficients: &Bivariate<T>, x: DVec3, power: f64, emission_power: f64) -> Bivariate<T> {
        let ratio = self.power / power;
        let scaled = coefficients.map(|i, j, c| (0..i + j).fold(c.scaled(emission_power), |c, _| c.scaled(ratio)));
        let first: Vec3<T> = offset(self.first, x, power);
        let [u, v] = [0, 1].map(|i| first.dot(self.axes[i]) + T::exact(self.middle[i] / ratio));
        scaled.shifted(u, v)
    }
}

impl Coordinates<Precise> {
    /// Bounds on |u| and |v| over the polygon.
    fn reach(&self, polygon: &Polygon) -> [f64; 2] {
        let along = |axis: usize| polygon.vertices().iter().map(|v| magnitude(self.coordinates(*v)[axis])).fold(0.0, f64::max);
        [along(0), along(1)]
    }
}

impl InPlane {
    pub(crate) fn new(polygon: &Polygon, polynomial: &Polynomial) -> Result<Self, Error> {
        let coordinates = Coordinates::<Precise>::new(polygon);
        let coefficients = restricted(polynomial, &coordinates);
        let reach = coordinates.reach(polygon);
        let largest = bound_over(&coefficients, reach);
        let [along_u, along_v] = coefficients.gradient().map(|slope| bound_over(&slope, reach));
        let steepest = Vec3::new(along_u, along_v, 0.0).length();
        if !(largest.is_finite() && steepest.is_finite()) {
            return Err(Error::Overflow { quantity: "emission over the polygon" });
        }
        let uncertainty = bound_over(&coefficients.map(|_, _, c| Precise::exact(c.error())), reach);
        Ok(Self { polynomial: polynomial.clone(), coordinates, coefficients, largest, steepest, uncertainty })
    }

    /// Coordinates of a point of the plane in the unit of the polynomial, to a rounding.
    pub(crate) fn coordinates(&self, point: DVec3) -> [f64; 2] {
        self.coordinates.coordinates(point).map(Real::value)
    }

    /// The coefficients in that unit for emission multiplied by `emission_power`, to a rounding.
    pub(crate) fn rounded(&self, emission_power: f64) -> Bivariate<f64> {
        self.coefficients.map(|_, _, c| c.middle().to_f64() * emission_power)
    }

    pub(crate) const fn degree(&self) -> usize {
        self.coefficients.degree()
    }

    /// Bound on the effect of the coefficients' errors over the polygon, in the unit of the caller.
    pub(crate) const fn uncertainty(&self) -> f64 {
        self.uncertainty
    }

    /// Coordinates in the plane and the coefficients in them, to the digits of the scalar.
    pub(crate) fn precise<T: Real>(&self, polygon: &Polygon) -> (Coordinates<T>, Bivariate<T>) {
        if T::Number::BEYOND_DOUBLE_DOUBLE {
            let coordinates = Coordinates::new(polygon);
            let coefficients = restricted(&self.polynomial, &coordinates);
            return (coordinates, coefficients);
        }
        let Coordinates { axes, first, middle, power } = self.coordinates;
        let rounded = |c: Precise| T::from_double_double(c.middle(), c.error());
        let coordinates = Coordinates { axes: axes.map(|axis| axis.map(rounded)), first, middle, power };
        (coordinates, self.coefficients.map(|_, _, c| rounded(c)))
    }

    /// The slope along n2 over the plane, in the unit of the caller, to the digits of the scalar.
    pub(crate) fn slope_across<T: Real>(&self, polygon: &Polygon, coordinates: &Coordinates<T>) -> Bivariate<T> {
        let Vec3 { x, y, z } = polygon.unit_normal::<T>();
        let mut sum = Bivariate::zero(self.degree());
        for (axis, component) in [x, y, z].into_iter().enumerate() {
            sum.add_scaled(&restricted(&derivative(&self.polynomial, axis), coordinates), component);
        }
        sum
    }

    /// Each term with a coefficient of 1, to the digits of the scalar.
    pub(crate) fn monomials<T: Real>(&self, coordinates: &Coordinates<T>) -> impl Iterator<Item = Bivariate<T>> {
        let origin = self.polynomial.origin;
        self.polynomial.terms.iter().map(move |term| {
            let terms = vec![Monomial { coefficient: 1.0, ..*term }];
            restricted(&Polynomial { origin, terms }, coordinates)
        })
    }

    /// Bound on `|B|` over the polygon, in the unit of the caller.
    pub(crate) const fn largest(&self) -> f64 {
        self.largest
    }

    /// Bound on the length of `grad B` in the plane over the polygon, in the unit of the caller.
    pub(crate) const fn steepest(&self) -> f64 {
        self.steepest * self.coordinates.power
    }

    /// Bound on the change of the emission over a distance, in the unit of the caller also where the gradient's is beyond a double.
    pub(crate) const fn change_over(&self, distance: f64) -> f64 {
        self.steepest * (distance * self.coordinates.power)
    }

    /// The affine function with the value and the gradient at vertex 0.
    pub(crate) fn tangent(&self) -> Affine {
        let Coordinates { axes, middle, power, .. } = &self.coordinates;
        let first = middle.map(|m| Precise::exact(-m));
        let [along_u, along_v] = self.coefficients.gradient().map(|slope| slope.value(first));
        let slope = axes[0] * along_u + axes[1] * along_v;
        Affine::new(self.coefficients.value(first).value(), slope.map(|c| c.scaled(*power)))
    }
}

/// The derivative along an axis. A coefficient times an exponent may have more digits than a double: it is a sum of powers of two
/// times the coefficient.
fn derivative(polynomial: &Polynomial, axis: usize) -> Polynomial {
    let lowered = polynomial.terms.iter().flat_map(|term| {
        let (power, mut powers) = (term.powers[axis], term.powers);
        powers[axis] = power.saturating_sub(1);
        let bits = (0..u8::BITS).map(move |bit| power & (1 << bit)).filter(|bit| *bit > 0);
        bits.map(move |bit| Monomial { coefficient: term.coefficient * f64::from(bit), powers })
    });
    Polynomial { origin: polynomial.origin, terms: lowered.collect() }
}

/// The polynomial with each coordinate replaced by its affine function of u and v.
fn restricted<T: Real>(polynomial: &Polynomial, coordinates: &Coordinates<T>) -> Bivariate<T> {
    let Coordinates { axes: [t_1, t_2], power, .. } = coordinates;
    let middle = coordinates.middle_from(polynomial.origin());
    let affine = [(middle.x, [t_1.x, t_2.x]), (middle.y, [t_1.y, t_2.y]), (middle.z, [t_1.z, t_2.z])];
    let terms: Vec<&Monomial> = polynomial.terms().iter().collect();
    let mut sum = Bivariate::zero(polynomial.degree().max(1) as usize);
    sum.add(&nested(&terms, &affine, 1.0 / power));
    sum
}

/// A sum of terms as a polynomial in the plane, by Horner's rule in each coordinate in turn: as many products as there are
/// combinations of exponents, and not for each of them as many as its degree.
fn nested<T: Real>(terms: &[&Monomial], affine: &[(T, [T; 2])], unit: f64) -> Bivariate<T> {
    let Some(((constant, along), outer)) = affine.split_last() else {
        let mut sum = Bivariate::zero(0);
        *sum.coefficient_mut(0, 0) = terms.iter().fold(T::exact(0.0), |sum, term| sum + T::exact(term.coefficient));
        return sum;
    };
    let axis = outer.len();
    let mut sum: Option<Bivariate<T>> = None;
    let degree = terms.iter().map(|term| term.powers[axis]).max().unwrap_or(0);
    for power in (0..=degree).rev() {
        let of_power: Vec<&Monomial> = terms.iter().copied().filter(|term| term.powers[axis] == power).collect();
        let raised = sum.map(|sum| sum.times_linear(*constant, *along).map(|_, _, c| c.scaled(unit)));
        let added = (!of_power.is_empty()).then(|| nested(&of_power, outer, unit));
        sum = match (raised, added) {
            (Some(raised), Some(added)) if raised.degree() >= added.degree() => Some(raised.plus(&added)),
            (Some(raised), Some(added)) => Some(added.plus(&raised)),
            (raised, added) => raised.or(added),
        };
    }
    sum.unwrap_or_else(|| Bivariate::zero(0))
}

/// Unit vectors in the plane, `t_1 x t_2 = n2`: the first across the coordinate axis that is farthest from the normal.
pub(crate) fn axes<T: Real>(polygon: &Polygon) -> [Vec3<T>; 2] {
    let n2 = polygon.unit_normal::<T>();
    let size = n2.map(|c| c.value().abs());
    let axis = if size.x <= size.y && size.x <= size.z {
        [1.0, 0.0, 0.0]
    } else if size.y <= size.z {
        [0.0, 1.0, 0.0]
    } else {
        [0.0, 0.0, 1.0]
    };
    let across = Vec3::from(DVec3::from_array(axis)).map(T::exact).cross(n2);
    let first = across * (T::exact(1.0) / across.norm_squared().sqrt());
    [first, n2.cross(first)]
}

/// `sum |b_ij| |u|^i |v|^j` and a little more.
fn bound_over(polynomial: &Bivariate<Precise>, reach: [f64; 2]) -> f64 {
    let sizes = polynomial.map(|_, _, c| Precise::exact(magnitude(c)));
    let mut powers = Bivariate::zero(polynomial.degree());
    let [u, v] = reach.map(Precise::exact);
    powers = powers.map(|i, j, _: Precise| (0..i).map(|_| u).chain((0..j).map(|_| v)).fold(whole(1), |product, c| product * c));
    magnitude(sizes.contract(&powers, (0, 0), 0))
}

/// Bound on the magnitude.
fn magnitude(c: Precise) -> f64 {
    (c.value().abs() + c.value_error()) * (1.0 + 4.0 * f64::EPSILON)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_restriction_takes_the_values_of_the_polynomial_in_the_plane() {
        let triangle = [[0.3, -0.2, 1.1], [1.4, 0.1, 1.6], [0.2, 0.9, 0.7]].map(DVec3::from);
        let polygon = Polygon::new(triangle.to_vec()).unwrap();
        let terms = [(1.0, [0, 0, 0]), (0.7, [1, 0, 2]), (-2.0, [0, 3, 1]), (0.3, [2, 2, 1])];
        let polynomial = Polynomial::new(DVec3::new(0.5, 0.5, 1.0), terms).unwrap();
        let plane = InPlane::new(&polygon, &polynomial).unwrap();
        let coefficients = plane.rounded(1.0);
        for (a, b) in [(0.0, 0.0), (0.5, 0.25), (0.1, 0.8), (1.0, 0.0)] {
            let y = triangle[0] + (triangle[1] - triangle[0]) * a + (triangle[2] - triangle[0]) * b;
            let here = coefficients.value(plane.coordinates(y));
            assert!((here - polynomial.value_at(y)).abs() < 1e-15, "{here}");
            assert!(polynomial.value_at(y).abs() <= plane.largest);
            let in_plane = polynomial.gradient_at(y).reject_from_normalized(polygon.normal());
            assert!(in_plane.length() <= plane.steepest());
        }
    }

    #[test]
    fn the_slope_across_the_plane_and_the_single_terms_are_those_of_the_polynomial() {
        let triangle = [[0.3, -0.2, 1.1], [1.4, 0.1, 1.6], [0.2, 0.9, 0.7]].map(DVec3::from);
        let polygon = Polygon::new(triangle.to_vec()).unwrap();
        let terms = [(1.0, [0, 0, 0]), (0.7, [1, 0, 3]), (-2.0, [0, 7, 1]), (0.3, [2, 2, 1])];
        let polynomial = Polynomial::new(DVec3::new(0.5, 0.5, 1.0), terms).unwrap();
        let plane = InPlane::new(&polygon, &polynomial).unwrap();
        let (coordinates, _) = plane.precise::<f64>(&polygon);
        let (across, monomials) = (plane.slope_across(&polygon, &coordinates), plane.monomials(&coordinates));
        let monomials: Vec<Bivariate<f64>> = monomials.collect();
        for (a, b) in [(0.0, 0.0), (0.5, 0.25), (0.1, 0.8)] {
            let y = triangle[0] + (triangle[1] - triangle[0]) * a + (triangle[2] - triangle[0]) * b;
            let here = plane.coordinates(y);
            assert!((across.value(here) - polynomial.gradient_at(y).dot(polygon.normal())).abs() < 1e-14);
            let sum: f64 = monomials.iter().zip(terms).map(|(monomial, (c, _))| monomial.value(here) * c).sum();
            assert!((sum - polynomial.value_at(y)).abs() < 1e-14);
        }
    }

    #[test]
    fn emission_too_large_for_a_double_is_refused() {
        let polygon = Polygon::new([[0.0; 3], [1e200, 0.0, 0.0], [0.0, 1e200, 0.0]].map(DVec3::from).to_vec()).unwrap();
        let polynomial = Polynomial::new(DVec3::ZERO, [(1.0, [2, 0, 0])]).unwrap();
        let error = InPlane::new(&polygon, &polynomial).unwrap_err();
        assert!(error.to_string().starts_with("the emission over the polygon overflows"), "{error}");
    }
}
