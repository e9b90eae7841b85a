//! A polynomial of the position restricted to the plane of a polygon: what of it is seen.
//!
//! `y = E_0 + u t_1 + v t_2` with `E_0` vertex 0 and `(t_1, t_2, n2)` orthonormal turns `B(y)` into `sum b_ij u^i v^j`. Done once per emitter, in double-double with
//! running bounds, lengths in a unit near the polygon's size: coefficients lose what cancels when the origin is far from the polygon, and say so.

use glam::DVec3;

use super::Polynomial;
use super::bivariate::{Bivariate, whole};
use crate::Error;
use crate::certify::Ball;
use crate::double_double::DoubleDouble;
use crate::emission::Affine;
use crate::geometry::{Polygon, exact_offset, normalising_power};
use crate::real::Real;
use crate::vec3::Vec3;

type Precise = Ball<DoubleDouble>;

/// A bivariate polynomial around vertex 0 of a polygon.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct InPlane {
    axes: [Vec3<Precise>; 2],
    /// Multiplies lengths.
    power: f64,
    coefficients: Bivariate<Precise>,
    largest: f64,
    steepest: f64,
}

impl InPlane {
    pub(crate) fn new(polygon: &Polygon, polynomial: &Polynomial) -> Result<Self, Error> {
        let power = normalising_power(polygon.size());
        let axes = axes(polygon);
        let exact = |r: Vec3<DoubleDouble>| r.map(|c| Precise::from_double_double(c, 0.0));
        let from_origin = exact(exact_offset(polygon.vertices()[0], polynomial.origin(), power));
        let coordinates = [
            (from_origin.x, [axes[0].x, axes[1].x]),
            (from_origin.y, [axes[0].y, axes[1].y]),
            (from_origin.z, [axes[0].z, axes[1].z]),
        ];
        let degree = usize::try_from(polynomial.degree().max(1)).unwrap_or(usize::MAX);
        let mut coefficients = Bivariate::zero(degree);
        for term in polynomial.terms() {
            let mut product = Bivariate::zero(0);
            *product.at_mut(0, 0) = Precise::exact(term.coefficient);
            for ((constant, along), count) in coordinates.into_iter().zip(term.powers) {
                for _ in 0..count {
                    product = product.times_linear(constant, along).map(|_, _, c| c.scaled(1.0 / power));
                }
            }
            coefficients.add_scaled(&product, Precise::exact(1.0));
        }
        let mut plane = Self { axes, power, coefficients, largest: 0.0, steepest: 0.0 };
        let reach = plane.reach(polygon);
        plane.largest = bound_over(&plane.coefficients, reach);
        let [along_u, along_v] = plane.coefficients.gradient().map(|slope| bound_over(&slope, reach));
        plane.steepest = (along_u * along_u + along_v * along_v).sqrt() * power;
        if plane.largest.is_finite() { Ok(plane) } else { Err(Error::Overflow { quantity: "emission over the polygon" }) }
    }

    /// Bounds on |u| and |v| over the polygon.
    fn reach(&self, polygon: &Polygon) -> [f64; 2] {
        let vertices = polygon.vertices();
        self.axes.map(|axis| {
            let along = |v: &DVec3| {
                let r = exact_offset(*v, vertices[0], self.power).map(|c| Precise::from_double_double(c, 0.0));
                magnitude(axis.dot(r))
            };
            vertices.iter().map(along).fold(0.0, f64::max)
        })
    }

    /// The unit vectors `t_1` and `t_2`.
    pub(super) fn axes<T: Real>(&self) -> [Vec3<T>; 2] {
        self.axes.map(|axis| axis.map(|c| T::from_double_double(c.middle(), c.error())))
    }

    /// The coefficients around vertex 0 for lengths multiplied by `power` and emission by `emission_power`.
    pub(super) fn coefficients<T: Real>(&self, power: f64, emission_power: f64) -> Bivariate<T> {
        let ratio = self.power / power;
        self.coefficients.map(|i, j, c| {
            let rounded = T::from_double_double(c.middle(), c.error()).scaled(emission_power);
            (0..i + j).fold(rounded, |c, _| c.scaled(ratio))
        })
    }

    /// Bound on `|B|` over the polygon, in the unit of the caller.
    pub(crate) const fn largest(&self) -> f64 {
        self.largest
    }

    /// Bound on the length of `grad B` in the plane over the polygon, in the unit of the caller.
    pub(crate) const fn steepest(&self) -> f64 {
        self.steepest
    }

    /// The affine function with the value and the gradient at vertex 0.
    pub(crate) fn tangent(&self) -> Affine {
        let slope = self.axes[0] * self.coefficients.at(1, 0) + self.axes[1] * self.coefficients.at(0, 1);
        let error = slope.map(Real::error);
        Affine {
            value: self.coefficients.at(0, 0).value(),
            gradient: slope.map(|c| c.middle().scaled(self.power)),
            gradient_error: error.x.max(error.y).max(error.z) * self.power,
            residual: 0.0,
        }
    }
}

/// Unit vectors in the plane, `t_1 x t_2 = n2`: the first across the coordinate axis that is farthest from the normal.
fn axes(polygon: &Polygon) -> [Vec3<Precise>; 2] {
    let n2 = polygon.precise_normal().map(|c| Precise::from_double_double(c, polygon.normal_error()));
    let size = n2.map(|c| c.value().abs());
    let axis = if size.x <= size.y && size.x <= size.z {
        [1.0, 0.0, 0.0]
    } else if size.y <= size.z {
        [0.0, 1.0, 0.0]
    } else {
        [0.0, 0.0, 1.0]
    };
    let across = Vec3::from(DVec3::from_array(axis)).map(Precise::exact).cross(n2);
    let first = across * (Precise::exact(1.0) / across.norm_squared().sqrt());
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
        let axes: [Vec3<f64>; 2] = plane.axes();
        let coefficients: Bivariate<f64> = plane.coefficients(1.0, 1.0);
        for (a, b) in [(0.0, 0.0), (0.5, 0.25), (0.1, 0.8), (1.0, 0.0)] {
            let y = triangle[0] + (triangle[1] - triangle[0]) * a + (triangle[2] - triangle[0]) * b;
            let [u, v] = axes.map(|axis| axis.dot((y - triangle[0]).into()));
            let here: f64 = coefficients.clone().shifted(-u, -v).at(0, 0);
            assert!((here - polynomial.at(y)).abs() < 1e-15, "{here}");
            assert!(polynomial.at(y).abs() <= plane.largest);
            let in_plane = polynomial.gradient_at(y).reject_from_normalized(polygon.normal());
            assert!(in_plane.length() <= plane.steepest);
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
