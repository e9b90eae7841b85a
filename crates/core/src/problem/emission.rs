//! The emission of an emitter: its radiosity `B(y)`, constant or linear over the polygon (HS95 sections A.1 and A.2), or a
//! polynomial.
//!
//! Units: radiosity in W/m2 (or any other unit, kept), gradient in that unit over the unit of length. The condition of a linear
//! emission given by vertex values on a needle is the needle's: its gradient across is a difference over the width.

use glam::DVec3;
use radgrad_numbers::ball::Ball;
use radgrad_numbers::double_double::DoubleDouble;
use radgrad_numbers::exact::orientation;
use radgrad_numbers::number::Number;
use radgrad_numbers::offset::offset;
use radgrad_numbers::power::normalising_power;
use radgrad_numbers::real::Real;
use radgrad_numbers::vec3::Vec3;

use crate::error::Error;
use crate::problem::affine::{Affine, larger};
use crate::problem::polygon::{COORDINATE_ROUNDING, Polygon};
use crate::problem::polynomial::Polynomial;
use crate::problem::polynomial::plane::InPlane;

/// The radiosity of an emitter over its polygon, as the user states it.
///
/// ```
/// use radgrad_core::{DVec3, Emission, Emitter, Polygon, Polynomial};
/// let lamp = |emission| Emitter::new(Polygon::new(vec![DVec3::ZERO, DVec3::X, DVec3::Y]).unwrap(), emission);
/// let square = Polynomial::new(DVec3::ZERO, [(1.0, [2, 0, 0])])?;
/// let middle = DVec3::new(0.5, 0.0, 0.0);
/// assert_eq!(lamp(Emission::Constant(2.0))?.emission_at(middle), 2.0);
/// assert_eq!(lamp(Emission::gradient(2.0, DVec3::X))?.emission_at(middle), 2.5);
/// assert_eq!(lamp(Emission::Polynomial(square))?.emission_at(middle), 0.25);
/// # Ok::<(), radgrad_core::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub enum Emission {
    /// The same value everywhere.
    Constant(f64),
    /// An affine function of the position.
    Linear(Linear),
    /// A polynomial of the position.
    Polynomial(Polynomial),
}

/// Two ways to state an affine emission.
///
/// ```
/// # use radgrad_core::{DVec3, Emission, Emitter, Linear, Polygon};
/// let lamp = |linear| Emitter::new(Polygon::new(vec![DVec3::ZERO, DVec3::X, DVec3::Y]).unwrap(), Emission::Linear(linear));
/// let (values, gradient) = (vec![1.0, 3.0, 2.0], DVec3::new(2.0, 1.0, 0.0));
/// assert_eq!(lamp(Linear::AtVertices(values))?.emission_gradient(), gradient);
/// assert_eq!(lamp(Linear::Gradient { value: 1.0, gradient })?.emission_at(DVec3::Y), 2.0);
/// # Ok::<(), radgrad_core::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub enum Linear {
    /// One value per vertex; for more than three they must lie on one affine function.
    AtVertices(Vec<f64>),
    /// The value at vertex 0 and the gradient; a part of the gradient along the polygon's normal has no effect.
    Gradient {
        /// Value at vertex 0.
        value: f64,
        /// Gradient over the polygon's plane.
        gradient: DVec3,
    },
}

impl Emission {
    /// Linear emission from one value per vertex.
    ///
    /// ```
    /// use radgrad_core::{DVec3, Emission, Emitter, Polygon};
    /// let triangle = Polygon::new(vec![DVec3::ZERO, DVec3::X, DVec3::Y])?;
    /// let lamp = Emitter::new(triangle, Emission::at_vertices(vec![1.0, 3.0, 2.0]))?;
    /// assert_eq!(lamp.emission_at(DVec3::new(0.5, 0.5, 0.0)), 2.5);
    /// # Ok::<(), radgrad_core::Error>(())
    /// ```
    #[must_use]
    pub const fn at_vertices(values: Vec<f64>) -> Self {
        Self::Linear(Linear::AtVertices(values))
    }

    /// Linear emission from the value at vertex 0 and the gradient.
    ///
    /// ```
    /// use radgrad_core::{DVec3, Emission, Emitter, Polygon};
    /// let triangle = Polygon::new(vec![DVec3::ZERO, DVec3::X, DVec3::Y])?;
    /// let lamp = Emitter::new(triangle, Emission::gradient(1.0, DVec3::new(2.0, 0.0, 7.0)))?;
    /// assert_eq!(lamp.emission_at(DVec3::X), 3.0);
    /// assert_eq!(lamp.emission_gradient(), DVec3::X * 2.0); // along the normal it has no effect
    /// # Ok::<(), radgrad_core::Error>(())
    /// ```
    #[must_use]
    pub const fn gradient(value: f64, gradient: DVec3) -> Self {
        Self::Linear(Linear::Gradient { value, gradient })
    }
}

/// A polygon that emits.
///
/// ```
/// use radgrad_core::{DVec3, Emission, Emitter, Polygon};
/// let triangle = Polygon::new(vec![DVec3::Z, DVec3::new(0.5, 0.8, 1.0), DVec3::new(1.0, 0.0, 1.0)])?;
/// let emitter = Emitter::new(triangle, Emission::at_vertices(vec![1.0, 2.0, 4.0]))?;
/// assert!((emitter.emission_at(DVec3::new(1.0, 0.0, 1.0)) - 4.0).abs() < 1e-15);
/// # Ok::<(), radgrad_core::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Emitter {
    polygon: Polygon,
    emission: Emission,
    /// The emission; of a polynomial, its tangent at vertex 0.
    affine: Affine,
    polynomial: Option<InPlane>,
    /// A linear emission at the vertices; empty for others. On a needle the gradient is steep and rounded, the values are not.
    vertex_values: Vec<f64>,
    /// Bound on the error of each of them.
    vertex_error: f64,
    /// Brings the emission to a size of about 1.
    power: f64,
}

/// Vertex values may be off one affine function by this fraction of the largest of them, beside the effect of rounded
/// coordinates.
const AFFINITY: f64 = 4e-12;

impl Emitter {
    /// An emitter with the given polygon and emission.
    ///
    /// ```
    /// use radgrad_core::{DVec3, Emission, Emitter, Error, Polygon};
    /// let square = Polygon::new(vec![DVec3::ZERO, DVec3::X, DVec3::new(1.0, 1.0, 0.0), DVec3::Y])?;
    /// assert!(Emitter::new(square.clone(), Emission::at_vertices(vec![1.0, 2.0, 3.0, 2.0])).is_ok());
    /// let error = Emitter::new(square.clone(), Emission::at_vertices(vec![1.0, 2.0, 3.0])).unwrap_err();
    /// assert_eq!(error, Error::EmissionCount { values: 3, vertices: 4 });
    /// let saddle = Emission::at_vertices(vec![1.0, 2.0, 1.0, 2.0]);
    /// assert!(matches!(Emitter::new(square, saddle), Err(Error::EmissionNotAffine { .. })));
    /// # Ok::<(), radgrad_core::Error>(())
    /// ```
    ///
    /// # Errors
    /// If a value is not finite, the number of vertex values is not the number of vertices, or they do not lie on one affine
    /// function.
    pub fn new(polygon: Polygon, emission: Emission) -> Result<Self, Error> {
        let (affine, polynomial) = match &emission {
            Emission::Constant(value) => {
                finite(*value, || "value".to_owned())?;
                (Affine { value: *value, gradient: Vec3::default(), gradient_error: 0.0, residual: 0.0 }, None)
            }
            Emission::Linear(Linear::AtVertices(values)) => (through_vertices(&polygon, values)?, None),
            Emission::Linear(Linear::Gradient { value, gradient }) => {
                finite(*value, || "value at vertex 0".to_owned())?;
                for (axis, component) in gradient.to_array().into_iter().enumerate() {
                    finite(component, || format!("gradient component {axis}"))?;
                }
                (in_plane(&polygon, *value, (*gradient).into()), None)
            }
            Emission::Polynomial(polynomial) => {
                let plane = InPlane::new(&polygon, polynomial)?;
                (plane.tangent(), Some(plane))
            }
        };
        let (vertex_values, vertex_error) = match &emission {
            Emission::Linear(Linear::AtVertices(values)) => (values.clone(), 0.0),
            Emission::Linear(Linear::Gradient { .. }) => values_at_vertices(&polygon, affine),
            Emission::Constant(_) | Emission::Polynomial(_) => (Vec::new(), 0.0),
        };
        is_representable(affine, &vertex_values, vertex_error)?;
        let steepest = affine.gradient.map(|c| c.hi.abs());
        let variation = steepest.x.max(steepest.y).max(steepest.z) * polygon.size();
        let largest = polynomial.as_ref().map_or(affine.value.abs().max(variation), InPlane::largest);
        let power = normalising_power(largest);
        Ok(Self { power, polygon, emission, affine, polynomial, vertex_values, vertex_error })
    }

    /// The polygon.
    ///
    /// ```
    /// # use radgrad_core::{DVec3, Emission, Emitter, Polygon};
    /// let triangle = Polygon::new(vec![DVec3::ZERO, DVec3::X, DVec3::Y])?;
    /// assert_eq!(*Emitter::new(triangle.clone(), Emission::Constant(1.0))?.polygon(), triangle);
    /// # Ok::<(), radgrad_core::Error>(())
    /// ```
    #[must_use]
    pub const fn polygon(&self) -> &Polygon {
        &self.polygon
    }

    /// The emission as stated.
    ///
    /// ```
    /// # use radgrad_core::{DVec3, Emission, Emitter, Polygon};
    /// let triangle = Polygon::new(vec![DVec3::ZERO, DVec3::X, DVec3::Y])?;
    /// assert_eq!(*Emitter::new(triangle, Emission::Constant(1.5))?.emission(), Emission::Constant(1.5));
    /// # Ok::<(), radgrad_core::Error>(())
    /// ```
    #[must_use]
    pub const fn emission(&self) -> &Emission {
        &self.emission
    }

    /// Gradient of the emission over the polygon's plane, at vertex 0; zero for a constant emission, and the same everywhere
    /// for a linear one.
    ///
    /// ```
    /// # use radgrad_core::{DVec3, Emission, Emitter, Polygon};
    /// let triangle = Polygon::new(vec![DVec3::ZERO, DVec3::X * 2.0, DVec3::Y])?;
    /// let lamp = Emitter::new(triangle, Emission::at_vertices(vec![1.0, 3.0, 4.0]))?;
    /// assert_eq!(lamp.emission_gradient(), DVec3::new(1.0, 3.0, 0.0));
    /// # Ok::<(), radgrad_core::Error>(())
    /// ```
    #[must_use]
    pub fn emission_gradient(&self) -> DVec3 {
        self.affine.gradient.map(DoubleDouble::to_f64).into()
    }

    /// Gradient of the emission over the polygon's plane at a point of it.
    ///
    /// ```
    /// # use radgrad_core::{DVec3, Emission, Emitter, Polygon, Polynomial};
    /// let square = Polynomial::new(DVec3::ZERO, [(1.0, [2, 0, 0]), (5.0, [0, 0, 1])])?; // x^2 + 5 z
    /// let lamp = Emitter::new(Polygon::new(vec![DVec3::ZERO, DVec3::X, DVec3::Y])?, Emission::Polynomial(square))?;
    /// assert_eq!(lamp.emission_gradient_at(DVec3::new(0.5, 0.25, 0.0)), DVec3::X);
    /// # Ok::<(), radgrad_core::Error>(())
    /// ```
    #[must_use]
    pub fn emission_gradient_at(&self, point: DVec3) -> DVec3 {
        match &self.emission {
            Emission::Polynomial(polynomial) => polynomial.gradient_at(point).reject_from_normalized(self.polygon.normal()),
            Emission::Constant(_) | Emission::Linear(_) => self.emission_gradient(),
        }
    }

    /// Emission `B(y)` at a point of the polygon's plane.
    ///
    /// ```
    /// # use radgrad_core::{DVec3, Emission, Emitter, Polygon};
    /// let triangle = Polygon::new(vec![DVec3::ZERO, DVec3::X * 2.0, DVec3::Y])?;
    /// let lamp = Emitter::new(triangle, Emission::at_vertices(vec![1.0, 3.0, 4.0]))?;
    /// assert_eq!(lamp.emission_at(DVec3::new(1.0, 0.5, 0.0)), 3.5);
    /// # Ok::<(), radgrad_core::Error>(())
    /// ```
    #[must_use]
    pub fn emission_at(&self, point: DVec3) -> f64 {
        match &self.emission {
            Emission::Polynomial(polynomial) => polynomial.value_at(point),
            Emission::Constant(_) | Emission::Linear(_) => {
                self.affine.value + self.emission_gradient().dot(point - self.polygon.vertices()[0])
            }
        }
    }

    /// Largest magnitude of the emission over the polygon: for a constant or linear emission that at a vertex, for a polynomial
    /// an upper bound.
    ///
    /// ```
    /// # use radgrad_core::{DVec3, Emission, Emitter, Polygon};
    /// let triangle = Polygon::new(vec![DVec3::ZERO, DVec3::X, DVec3::Y])?;
    /// let lamp = Emitter::new(triangle, Emission::at_vertices(vec![1.0, -3.0, 2.0]))?;
    /// assert_eq!(lamp.largest_emission(), 3.0);
    /// # Ok::<(), radgrad_core::Error>(())
    /// ```
    #[must_use]
    pub fn largest_emission(&self) -> f64 {
        if let Some(plane) = &self.polynomial {
            return plane.largest();
        }
        self.vertex_values.iter().fold(0.0, |largest: f64, b| largest.max(b.abs())).max(self.affine.value.abs())
            + self.vertex_error
            + self.affine.residual
    }

    /// A linear emission at a vertex, times [`Self::power`].
    pub(crate) fn vertex_value(&self, vertex: usize) -> f64 {
        self.vertex_values[vertex] * self.power
    }

    /// Bound on the error of [`Self::vertex_value`].
    pub(crate) fn vertex_error(&self) -> f64 {
        self.vertex_error * self.power
    }

    /// [`Affine::gradient`] times [`Self::power`], to the digits of the scalar.
    #[inline]
    pub(crate) fn precise_gradient<T: Real>(&self) -> Vec3<T> {
        let gradient = match &self.emission {
            Emission::Linear(Linear::AtVertices(values)) if T::Number::BEYOND_DOUBLE_DOUBLE => {
                gradient_through_vertices(&self.polygon, values)
            }
            Emission::Linear(Linear::Gradient { gradient, .. }) if T::Number::BEYOND_DOUBLE_DOUBLE => {
                gradient_in_plane(&self.polygon, (*gradient).into())
            }
            _ => self.affine.gradient.map(|c| T::from_double_double(c, self.affine.gradient_error)),
        };
        gradient.map(|c| c.scaled(self.power))
    }

    /// Largest length of the emission's gradient over the polygon: for a polynomial an upper bound.
    ///
    /// ```
    /// # use radgrad_core::{DVec3, Emission, Emitter, Polygon};
    /// let triangle = Polygon::new(vec![DVec3::ZERO, DVec3::X, DVec3::Y])?;
    /// let lamp = Emitter::new(triangle, Emission::at_vertices(vec![1.0, 4.0, 5.0]))?;
    /// assert_eq!(lamp.steepest_emission(), 5.0); // of the gradient (3, 4, 0)
    /// # Ok::<(), radgrad_core::Error>(())
    /// ```
    #[must_use]
    pub fn steepest_emission(&self) -> f64 {
        self.polynomial.as_ref().map_or_else(|| Vec3::from(self.emission_gradient()).length(), InPlane::steepest)
    }

    /// Whether the emission is stated to be zero everywhere.
    pub(crate) fn is_dark(&self) -> bool {
        match &self.emission {
            Emission::Constant(value) => *value == 0.0,
            Emission::Linear(Linear::AtVertices(values)) => values.iter().all(|value| *value == 0.0),
            Emission::Linear(Linear::Gradient { value, gradient }) => *value == 0.0 && *gradient == DVec3::ZERO,
            Emission::Polynomial(polynomial) => polynomial.terms().iter().all(|term| term.coefficient == 0.0),
        }
    }

    /// The polynomial emission in the plane, where it is one.
    pub(crate) const fn polynomial(&self) -> Option<&InPlane> {
        self.polynomial.as_ref()
    }

    /// The emission times [`Self::power`].
    pub(crate) fn affine(&self) -> Affine {
        let Affine { value, gradient, gradient_error, residual } = self.affine;
        let power = self.power;
        Affine {
            value: value * power,
            gradient: gradient.map(|c| c.scaled(power)),
            gradient_error: gradient_error * power,
            residual: residual * power,
        }
    }

    /// Whether the emission differs over the surfaces that its vertices, or its values, leave open.
    pub(crate) fn has_defect(&self) -> bool {
        let is_off_plane = self.polygon.planarity_defect() > 0.0 && !matches!(self.emission, Emission::Constant(_));
        // Values that are on an affine function are computed to be off it by the rounding of double-double.
        is_off_plane || self.affine.residual * self.power > 1e-24
    }

    /// The power of two by which the emission is multiplied before it is computed with.
    pub(crate) const fn power(&self) -> f64 {
        self.power
    }
}

/// Refuses an emission that is finite where it is given, but whose slope or continuation to the vertices is not.
fn is_representable(affine: Affine, vertex_values: &[f64], vertex_error: f64) -> Result<(), Error> {
    let gradient = affine.gradient.map(DoubleDouble::to_f64);
    for (axis, component) in [gradient.x, gradient.y, gradient.z].into_iter().enumerate() {
        finite(component, || format!("gradient component {axis} over the polygon"))?;
    }
    finite(affine.gradient_error(), || "gradient's error".to_owned())?;
    finite(affine.residual, || "difference from an affine function".to_owned())?;
    for (index, value) in vertex_values.iter().enumerate() {
        finite(*value, || format!("at vertex {index}"))?;
    }
    finite(vertex_error, || "error at the vertices".to_owned())
}

fn finite(value: f64, place: impl FnOnce() -> String) -> Result<(), Error> {
    if value.is_finite() { Ok(()) } else { Err(Error::EmissionNotFinite { place: place(), value }) }
}

/// The affine function with the part of `gradient` in the plane of the polygon.
fn in_plane(polygon: &Polygon, value: f64, gradient: Vec3<f64>) -> Affine {
    Affine::new(value, gradient_in_plane(polygon, gradient))
}

fn gradient_in_plane<T: Real>(polygon: &Polygon, gradient: Vec3<f64>) -> Vec3<T> {
    let (normal, given) = (polygon.unit_normal::<T>(), gradient.map(T::exact));
    given - normal * normal.dot(given)
}

/// Gradient of the affine function through the vertex values. By the divergence theorem in the plane,
/// `grad B = (1/A) sum (B_i + B_{i+1})/2 (e_i x n2)` for any polygon; for three vertices it is the interpolant.
fn gradient_through_vertices<T: Real>(polygon: &Polygon, values: &[f64]) -> Vec3<T> {
    let vertices = polygon.vertices();
    let count = vertices.len();
    let power = normalising_power(polygon.size());
    let from_first = |i: usize| offset::<T>(vertices[i % count], vertices[0], power);
    // Above that size the products of double-double overflow.
    let largest = values.iter().fold(0.0, |m: f64, b| m.max(b.abs()));
    let down = if largest > 2f64.powi(900) { 2f64.powi(-200) } else { 1.0 };
    let exact = |i: usize| T::exact(values[i]).scaled(down);
    let above_first = |i: usize| {
        if down < 1.0 { exact(i % count) - exact(0) } else { T::difference(values[i % count], values[0], 1.0) }
    };
    let (mut weighted, mut twice_area) = (Vec3::<T>::zero(), Vec3::<T>::zero());
    for i in 0..count {
        let (here, next) = (from_first(i), from_first(i + 1));
        weighted = weighted + (next - here) * (above_first(i) + above_first(i + 1));
        twice_area = twice_area + here.cross(next);
    }
    let normal = polygon.unit_normal::<T>();
    let area = normal.dot(twice_area);
    weighted.cross(normal).map(|c| (c / area).scaled(power)).map(|c| if down < 1.0 { c.scaled(1.0 / down) } else { c })
}

/// The affine function at the vertices.
fn at_vertices(polygon: &Polygon, affine: Affine) -> impl Iterator<Item = Ball<DoubleDouble>> {
    let vertices = polygon.vertices();
    let power = normalising_power(polygon.size());
    let slope = affine.gradient.map(|c| Ball::<DoubleDouble>::from_double_double(c, affine.gradient_error).scaled(1.0 / power));
    vertices.iter().map(move |v| Ball::exact(affine.value) + slope.dot(offset(*v, vertices[0], power)))
}

/// The same, rounded, and a bound on the error.
fn values_at_vertices(polygon: &Polygon, affine: Affine) -> (Vec<f64>, f64) {
    let (values, errors): (_, Vec<f64>) = at_vertices(polygon, affine).map(|value| (value.value(), value.value_error())).unzip();
    (values, errors.into_iter().fold(0.0, larger))
}

/// The affine function through the vertex values.
fn through_vertices(polygon: &Polygon, values: &[f64]) -> Result<Affine, Error> {
    let vertices = polygon.vertices();
    let count = vertices.len();
    if values.len() != count {
        return Err(Error::EmissionCount { values: values.len(), vertices: count });
    }
    for (index, &value) in values.iter().enumerate() {
        finite(value, || format!("at vertex {index}"))?;
    }
    let affine = Affine::new(values[0], gradient_through_vertices(polygon, values));
    if is_affine(polygon, values) {
        return Ok(affine);
    }
    let largest = values.iter().fold(0.0, |m: f64, b| m.max(b.abs()));
    let coordinate = vertices.iter().fold(0.0, |m: f64, v| m.max(v.abs().max_element()));
    let gradient = DVec3::from(affine.gradient.map(DoubleDouble::to_f64));
    let displacement = COORDINATE_ROUNDING * coordinate + polygon.precision() * most_moved(polygon);
    let allowed = AFFINITY * largest + displacement * Vec3::from(gradient).length();
    // Halves of halves, that do not overflow.
    let expected = |i: usize| 0.25 * values[0] + gradient.dot((vertices[i] - vertices[0]) * 0.25);
    let difference = |i: &usize| (0.25 * values[*i] - expected(*i)).abs() * 4.0;
    let index = (0..count).max_by(|i, j| difference(i).total_cmp(&difference(j))).unwrap_or(0);
    if difference(&index) > allowed {
        return Err(Error::EmissionNotAffine { index, value: values[index], expected: 4.0 * expected(index), allowed });
    }
    // Rounded differences may be 0 where values are off by as much as roundings.
    let residual = |(value, given): (Ball<DoubleDouble>, &f64)| {
        let residual = value - Ball::exact(*given);
        residual.value().abs() + residual.value_error()
    };
    Ok(Affine { residual: at_vertices(polygon, affine).zip(values).map(residual).fold(0.0, larger), ..affine })
}

/// How far from a vertex its value is met, where the function was affine before each coordinate moved by 1: two vertices move by
/// their diagonals, and the gradient turns by `(1/A) sum |d_i| |e_i|` over the reach.
fn most_moved(polygon: &Polygon) -> f64 {
    let (vertices, power) = (polygon.vertices(), normalising_power(polygon.size()));
    let from = |i: usize, j: usize| ((vertices[i] - vertices[j]) * power).length();
    let perimeter: f64 = (0..vertices.len()).map(|i| from(i, (i + 1) % vertices.len())).sum();
    let reach = (0..vertices.len()).map(|i| from(i, 0)).fold(0.0, larger);
    3.0_f64.sqrt() * (2.0 + perimeter * reach / polygon.area_scaled(power))
}

/// Whether the vertex values are exactly those of one affine function, as three always are: seen along the normal's largest
/// component, the points with the values for third coordinate lie in one plane.
fn is_affine(polygon: &Polygon, values: &[f64]) -> bool {
    let points = polygon.projected();
    let power = normalising_power(values.iter().fold(0.0, |m: f64, b| m.max(b.abs())));
    let lifted = |i: usize| DVec3::new(points[i].x, points[i].y, values[i] * power);
    let corners = polygon.plane_corners();
    let [a, b, c] = corners.map(lifted);
    (0..values.len()).filter(|i| !corners.contains(i)).all(|i| orientation([a, b, c, lifted(i)]) == 0.0)
}
