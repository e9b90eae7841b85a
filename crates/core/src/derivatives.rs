//! Derivatives of the radiosity at a point by everything that shapes it: the vertices of the emitter and of its occluders, the
//! emission, the receiver's normal and its reflectance.
//!
//! With E the irradiance vector, `B = (rho/pi) n1.E`: the derivative by n1 is `(rho/pi) E`, that by rho is `B/rho`, that by a parameter
//! of the emission is the radiosity of the function that the parameter multiplies. A vertex moves the lines of its edges, whose flux is that of
//! a ribbon ([`crate::forms::hats`]), and the plane of an emission that varies ([`crate::forms::polynomial::parameters`]); the sums are in
//! [`sums`]. A shift of all vertices and of the emission is one of the receiver the other way: with the gradient g, a turn w around p
//! changes B by `-(w x (x - p)).g - (w x n1).(dB/dn1)`, and a scale around p by `-(x - p).g` for each unit of its logarithm.
//!
//! # Where they are
//! B has derivatives by vertices in front of the emitter except where an edge is seen along another edge that is not on its line in
//! space, or an occluder meets the emitter's plane along an edge: the bounds there are no smaller than the difference of the two sides.
//! They are infinite where an occluder meets the emitter's plane and one of the two is not flat to the last digit, and for the vertices of an
//! occluder that is seen exactly edge on before the emitter: turned either way, it hides some of it. The gradient there is the mean of those from
//! both sides of the occluder's plane. Edges of several
//! polygons that are exactly on one line, as in a mesh of occluders or where an occluder stands on the emitter's edge, are taken to stay so:
//! the part that they bound counts for one of them, and the derivatives are those by motions that move them together.
//!
//! Bounds are running ([`radgrad_numbers::ball`]) but for the first attempt at an unoccluded triangle or quadrangle: there they are derived
//! for a constant emission ([`crate::forms::edge_lanes::shares`]), and run on lanes for one by vertex values; the ladder is f64, double-double, then as many bits as it takes.

mod sums;

use std::f64::consts::FRAC_1_PI;

use glam::DVec3;
use radgrad_numbers::number::ROUNDOFF;
use radgrad_numbers::real::Real;
use radgrad_numbers::vec3::Vec3;

use crate::boundary::case::Case;
use crate::boundary::plan::Plan;
use crate::boundary::visibility::is_edge_on;
use crate::derivatives::sums::Sums;
use crate::error::Error;
use crate::forms::edge_lanes::shares;
use crate::ladder::answer::Method;
use crate::ladder::caller_units::CallerUnits;
use crate::ladder::components::within_reach;
use crate::ladder::quantities::{Find, KINDS, Known, Quantity, to_tolerance};
use crate::problem::emission::{Emission, Emitter, Linear};
use crate::problem::polygon::Polygon;
use crate::problem::receiver::{Receiver, albedo, unit_normal};

/// A derivative with a proven absolute bound on its error, of a vector on the Euclidean norm.
///
/// ```
/// use radgrad_core::Derivative;
/// let derivative = Derivative { value: 2.0, error: 1e-12 };
/// assert_eq!(derivative.value + derivative.error, 2.000_000_000_001);
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Derivative<V> {
    /// The derivative.
    pub value: V,
    /// Proven bound on its error.
    pub error: f64,
}

/// Derivatives of the radiosity at a receiver, with the radiosity itself.
///
/// ```
/// use radgrad_core::{DVec3, Emission, Emitter, Polygon, Receiver, derivatives};
/// let corners = [(0.0, 0.0), (0.0, 1.0), (1.0, 1.0), (1.0, 0.0)].map(|(x, y)| DVec3::new(x, y, 1.0));
/// let lamp = Emitter::new(Polygon::new(corners.to_vec())?, Emission::Constant(2.0))?;
/// let corner = derivatives(&Receiver::new(DVec3::ZERO, DVec3::Z, 0.5)?, &lamp, &[], 1e-12)?;
/// assert!((corner.emission[0].value * 2.0 - corner.radiosity.value).abs() < 1e-15); // linear in the emission
/// assert!(corner.vertices[2].value.x > 0.0, "a larger lamp gives more");
/// let together: DVec3 = corner.vertices.iter().map(|vertex| vertex.value).sum();
/// assert!((together + corner.gradient.value).length() < 1e-15); // moving the lamp is moving the receiver the other way
/// # Ok::<(), radgrad_core::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Derivatives {
    /// The radiosity `B(x)` itself, in the unit of the emission.
    pub radiosity: Derivative<f64>,
    /// By the receiver's position at fixed normal, in that unit over the unit of length.
    pub gradient: Derivative<DVec3>,
    /// By each vertex of the emitter, in that unit. Vertex values move with their vertices; a linear emission that is given by value
    /// and gradient moves with vertex 0, and a polynomial stays where it is. A polygon of more than three vertices stays flat only
    /// along some motions; the derivatives are those for motions that keep it flat, and vertex values affine.
    pub vertices: Vec<Derivative<DVec3>>,
    /// By each vertex of each occluder, in the order given: likewise.
    pub occluders: Vec<Vec<Derivative<DVec3>>>,
    /// By each parameter of the emission: the constant; the value at each vertex; value, then gradient, which has the unit of length; or
    /// the coefficient of each term of the polynomial, which has the unit of length to the power of its degree.
    pub emission: Vec<Derivative<f64>>,
    /// By the unit normal, in the unit of the emission. As that turns, only the part across it counts.
    pub normal: Derivative<DVec3>,
    /// By the reflectance, in the unit of the emission.
    pub reflectance: Derivative<f64>,
    /// The method that answered.
    pub method: Method,
    position: DVec3,
    unit_normal: DVec3,
}

/// Derivatives at `receiver` due to the part of `emitter` that `occluders` leave visible, each with a bound.
///
/// The closed form in double precision, in double-double or with as many bits as it takes: the first whose bounds are at most
/// `tolerance` times the largest derivative of their kind answers, where those by vertices are one kind, of emitter and occluders
/// together, and those by emission another. Where none is, the last does, and its bounds say so.
///
/// ```
/// use radgrad_core::{DVec3, Emission, Emitter, Polygon, Receiver, derivatives, evaluate};
/// let point = |x, y, z| DVec3::new(x, y, z);
/// let lamp = |z| {
///     let corners = vec![point(-1.0, -1.0, 2.0), point(-1.0, 1.0, 2.0), point(1.0, z, 2.0)];
///     Emitter::new(Polygon::new(corners)?, Emission::at_vertices(vec![1.0, 2.0, 3.0]))
/// };
/// let screen = [Polygon::new(vec![point(0.2, -1.0, 1.0), point(0.2, 1.0, 1.0), point(2.0, 0.0, 1.0)])?];
/// let floor = Receiver::new(point(0.0, 0.0, 0.0), DVec3::Z, 1.0)?;
/// let answer = derivatives(&floor, &lamp(0.0)?, &screen, 1e-12)?;
/// let radiosity = |y| Ok::<_, radgrad_core::Error>(evaluate(&floor, &lamp(y)?, &screen)?.radiosity);
/// let difference = (radiosity(1e-4)? - radiosity(-1e-4)?) / 2e-4;
/// assert!((answer.vertices[2].value.y - difference).abs() < 1e-8);
/// # Ok::<(), radgrad_core::Error>(())
/// ```
///
/// # Errors
/// If the receiver is on the surface of an emitter that is not flat ([`Error::OnSurface`]), the tolerance is not in [0, 1], or a
/// result over- or underflows.
pub fn derivatives<'a>(
    receiver: &Receiver,
    emitter: &Emitter,
    occluders: impl IntoIterator<Item = &'a Polygon>,
    tolerance: f64,
) -> Result<Derivatives, Error> {
    bounded(receiver, emitter, &occluders.into_iter().collect::<Vec<_>>(), tolerance)
}

/// [`derivatives`], compiled once: generic functions are compiled again in every crate that calls them.
fn bounded(receiver: &Receiver, emitter: &Emitter, occluders: &[&Polygon], tolerance: f64) -> Result<Derivatives, Error> {
    let tolerance = within_reach(tolerance)?;
    if occluders.is_empty()
        && let Some(answer) = Derivatives::on_lanes(receiver, emitter, tolerance)
    {
        return Ok(answer);
    }
    let Some(plan) = Plan::new(receiver, emitter.polygon()) else {
        return Ok(Derivatives::zero(receiver, emitter, occluders));
    };
    plan.off_surface(receiver, emitter.polygon())?;
    let case = Case { receiver, emitter, occluders, plan: &plan };
    let mut answer = match to_tolerance(&All, &case, tolerance)? {
        Some((known, method)) => Derivatives::new(&case, known, method),
        None => Derivatives::zero(receiver, emitter, occluders),
    };
    for (occluder, vertices) in occluders.iter().zip(&mut answer.occluders) {
        if is_edge_on(receiver, emitter.polygon(), occluder, &plan) {
            vertices.iter_mut().for_each(|vertex| vertex.error = f64::INFINITY);
        }
    }
    Ok(answer)
}

/// The kinds of quantities: an error counts relative to the largest of its kind.
const VALUE: usize = 0;
const GRADIENT: usize = 1;
const VERTEX: usize = 2;
const EMISSION: usize = 3;
const NORMAL: usize = KINDS - 1;

/// The least reflectance with which products stay in the range.
const LEAST_REFLECTANCE: f64 = 1e-30;

/// All derivatives, in the order in which [`Derivatives::new`] takes them.
struct All;

impl Find for All {
    fn find<T: Real>(&self, case: &Case<'_>) -> Option<Vec<Quantity<T>>> {
        let Case { receiver, emitter, plan, .. } = *case;
        let sums = Sums::<T>::new(case)?;
        let (factor, n1) = (albedo::<T>(receiver), unit_normal::<T>(receiver));
        let zero = T::exact(0.0);
        let number = |value: T| Vec3::new(value, zero, zero);
        let irradiance = n1.dot(sums.irradiance);
        let unit = |order, name| CallerUnits::of_derivative(order, name, plan, emitter);
        let [value, normal] = ["radiosity", "derivative by the normal"].map(|name| unit(0, name));
        let [gradient, vertex] = ["gradient", "derivative by a vertex"].map(|name| unit(1, name));
        let vertices = sums.vertices.into_iter().flatten();
        let parameters = sums.emission.into_iter().map(|parameter| Quantity {
            components: number(parameter.derivative * factor),
            kind: EMISSION,
            unit: CallerUnits::of_length(i32::from(parameter.is_slope), "derivative by the emission", plan),
        });
        let mut quantities = vec![
            Quantity { components: number(irradiance * factor), kind: VALUE, unit: value },
            Quantity { components: sums.gradient * factor, kind: GRADIENT, unit: gradient },
            Quantity { components: sums.irradiance * factor, kind: NORMAL, unit: normal },
            Quantity { components: number(irradiance / T::pi()), kind: VALUE, unit: value },
        ];
        quantities.extend(vertices.map(|derivative| Quantity { components: derivative * factor, kind: VERTEX, unit: vertex }));
        quantities.extend(parameters);
        Some(quantities)
    }
}

/// How many parameters an emission has.
fn parameter_count(emission: &Emission) -> usize {
    match emission {
        Emission::Constant(_) => 1,
        Emission::Linear(Linear::AtVertices(values)) => values.len(),
        Emission::Linear(Linear::Gradient { .. }) => 4,
        Emission::Polynomial(polynomial) => polynomial.terms().len(),
    }
}

impl Derivative<f64> {
    const ZERO: Self = Self { value: 0.0, error: 0.0 };

    const fn number(known: Known) -> Self {
        Self { value: known.components[0], error: known.error }
    }
}

impl Derivative<DVec3> {
    const fn vector(known: Known) -> Self {
        Self { value: DVec3::from_array(known.components), error: known.error }
    }

    const ZERO: Self = Self { value: DVec3::ZERO, error: 0.0 };
}

impl Derivatives {
    fn new(case: &Case<'_>, known: Vec<Known>, method: Method) -> Self {
        let mut quantities = known.into_iter();
        let mut result = Self::zero(case.receiver, case.emitter, case.occluders);
        let mut next = || quantities.next().unwrap_or(Known { components: [0.0; 3], error: 0.0 });
        result.method = method;
        result.radiosity = Derivative::number(next());
        result.gradient = Derivative::vector(next());
        result.normal = Derivative::vector(next());
        result.reflectance = Derivative::number(next());
        for vertex in result.vertices.iter_mut().chain(result.occluders.iter_mut().flatten()) {
            *vertex = Derivative::vector(next());
        }
        for parameter in &mut result.emission {
            *parameter = Derivative::number(next());
        }
        result
    }

    /// Of an emitter whose derivatives are found on lanes, where their bounds are within the tolerance. Factors near the ends of the
    /// range, a reflectance of 0 and an emission of 0 are left to the ladder.
    #[inline(always)]
    fn on_lanes(receiver: &Receiver, emitter: &Emitter, tolerance: f64) -> Option<Self> {
        let vertices = emitter.polygon().vertices().len();
        let (shared, parameters) = match emitter.emission() {
            Emission::Constant(_) => (shares::constant(receiver, emitter)?, 1),
            Emission::Linear(Linear::AtVertices(_)) => (shares::linear::at_vertices(receiver, emitter)?, vertices),
            _ => return None,
        };
        let units = |order| CallerUnits::of_derivative(order, "derivatives", &shared.plan, emitter).moderate();
        let (unit, slope) = (units(0)?, units(1)?);
        if receiver.reflectance() < LEAST_REFLECTANCE || !shared.is_within(tolerance, [vertices, parameters]) {
            return None;
        }
        let albedo = albedo::<f64>(receiver);
        // A component that is not normal is rounded by less than the smallest normal number.
        let error = |error: f64, factor: f64| error * factor + f64::MIN_POSITIVE;
        let vector = |value: Vec3<f64>, of_value: f64, factor: f64| Derivative {
            value: DVec3::from(value * (albedo * factor)),
            error: error(of_value, albedo * factor),
        };
        let number =
            |value: f64, of_value: f64, factor: f64| Derivative { value: value * factor, error: error(of_value, factor) };
        Some(Self {
            radiosity: number(shared.irradiance, shared.irradiance_error, albedo * unit),
            gradient: vector(shared.gradient, shared.gradient_error, slope),
            vertices: (0..vertices).map(|k| vector(shared.vertices[k], shared.vertex_errors[k], slope)).collect(),
            occluders: Vec::new(),
            emission: (0..parameters).map(|k| number(shared.emission[k], shared.emission_errors[k], albedo)).collect(),
            normal: vector(shared.vector, shared.vector_error, unit),
            reflectance: number(shared.irradiance, shared.irradiance_error, FRAC_1_PI * unit),
            method: Method::ClosedForm,
            position: receiver.position(),
            unit_normal: receiver.normal(),
        })
    }

    fn zero(receiver: &Receiver, emitter: &Emitter, occluders: &[&Polygon]) -> Self {
        let number = Derivative::<f64>::ZERO;
        let zeros = |polygon: &Polygon| vec![Derivative::<DVec3>::ZERO; polygon.vertices().len()];
        Self {
            radiosity: number,
            gradient: Derivative::<DVec3>::ZERO,
            vertices: zeros(emitter.polygon()),
            occluders: occluders.iter().map(|occluder| zeros(occluder)).collect(),
            emission: vec![number; parameter_count(emitter.emission())],
            normal: Derivative::<DVec3>::ZERO,
            reflectance: number,
            method: Method::Zero,
            position: receiver.position(),
            unit_normal: receiver.normal(),
        }
    }

    /// By a shift of the emitter with its emission and of all occluders together: minus the gradient.
    #[must_use]
    pub fn translation(&self) -> Derivative<DVec3> {
        Derivative { value: -self.gradient.value, error: self.gradient.error }
    }

    /// By a turn of the emitter with its emission and of all occluders together around `about`: the component along an axis is the
    /// derivative by the angle, in the unit of the emission over radians.
    ///
    /// ```
    /// use radgrad_core::{DVec3, Emission, Emitter, Polygon, Receiver, derivatives};
    /// let corners = [(-1.0, -1.0), (-1.0, 1.0), (1.0, 1.0), (1.0, -1.0)].map(|(x, y)| DVec3::new(x, y, 1.0));
    /// let lamp = Emitter::new(Polygon::new(corners.to_vec())?, Emission::Constant(1.0))?;
    /// let floor = derivatives(&Receiver::new(DVec3::X, DVec3::Z, 1.0)?, &lamp, &[], 1e-12)?;
    /// assert!(floor.rotation(DVec3::X).value.z.abs() < 1e-15, "the lamp is symmetric across the plane through both");
    /// let turned: DVec3 = floor.vertices.iter().zip(&corners).map(|(vertex, corner)| corner.cross(vertex.value)).sum();
    /// assert!((floor.rotation(DVec3::ZERO).value - turned).length() < 1e-15);
    /// # Ok::<(), radgrad_core::Error>(())
    /// ```
    #[must_use]
    pub fn rotation(&self, about: DVec3) -> Derivative<DVec3> {
        let arm = self.position - about;
        let [by_place, by_normal] = [arm.cross(self.gradient.value), self.unit_normal.cross(self.normal.value)];
        let size = length(arm) * length(self.gradient.value) + length(self.normal.value);
        let error = length(arm) * self.gradient.error + self.normal.error;
        Derivative { value: -(by_place + by_normal), error: with_rounding(error, size) }
    }

    /// By the logarithm of a scale of the emitter with its emission and of all occluders together around `about`, in the unit of the
    /// emission.
    ///
    /// ```
    /// use radgrad_core::{DVec3, Emission, Emitter, Polygon, Receiver, derivatives};
    /// let corners = [(0.0, 0.0), (0.0, 1.0), (1.0, 1.0), (1.0, 0.0)].map(|(x, y)| DVec3::new(x, y, 1.0));
    /// let lamp = Emitter::new(Polygon::new(corners.to_vec())?, Emission::Constant(1.0))?;
    /// let floor = derivatives(&Receiver::new(DVec3::X, DVec3::Z, 1.0)?, &lamp, &[], 1e-12)?;
    /// assert_eq!(floor.scale(DVec3::X).value, 0.0, "around the receiver all directions stay");
    /// assert!(floor.scale(DVec3::Z).value > 0.0, "a larger lamp at its height");
    /// # Ok::<(), radgrad_core::Error>(())
    /// ```
    #[must_use]
    pub fn scale(&self, about: DVec3) -> Derivative<f64> {
        let (arm, gradient) = (self.position - about, self.gradient.value);
        let error = with_rounding(length(arm) * self.gradient.error, length(arm) * length(gradient));
        Derivative { value: -arm.dot(gradient), error }
    }
}

/// The length of a vector whose square may leave the range of doubles.
fn length(v: DVec3) -> f64 {
    Vec3::from(v).length()
}

/// A bound with the rounding of products of a rounded difference or unit normal with a vector, of that size in all: a difference errs
/// by a rounding of itself, a component of a product by three more, the sum by one, and no product below the normal range by more than
/// the smallest normal number.
fn with_rounding(error: f64, size: f64) -> f64 {
    let rounding = if size > 0.0 { 12.0 * ROUNDOFF * size + f64::MIN_POSITIVE } else { 0.0 };
    (error + rounding) * (1.0 + 16.0 * ROUNDOFF)
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng, rngs::ChaCha8Rng};

    use super::*;
    use crate::boundary::visibility::not_flat::largest;
    use crate::forms::edge_lanes::random::{polygon_and_receiver, vector};

    #[test]
    fn what_lanes_find_is_within_its_bounds_of_what_the_ladder_finds() {
        let mut random = ChaCha8Rng::seed_from_u64(59);
        let (mut counts, mut sharp, mut worst, mut longest) = ([0; 2], [0; 2], [0.0f64; 2], 0.0f64);
        for i in 0..4000 {
            let (count, kind) = (3 + i % 2, i / 2 % 2);
            let Some((polygon, receiver, size)) = polygon_and_receiver(&mut random, count, 1.5) else { continue };
            let (base, slope) = (random.random_range(-2.0..2.0), vector(&mut random, 3.0) / size);
            let values = polygon.vertices().iter().map(|v| base + slope.dot(*v - polygon.vertices()[0])).collect();
            let emission = if kind == 0 { Emission::Constant(base) } else { Emission::at_vertices(values) };
            let Ok(emitter) = Emitter::new(polygon, emission) else { continue };
            let Some(ours) = Derivatives::on_lanes(&receiver, &emitter, 1.0) else { continue };
            let plan = Plan::new(&receiver, emitter.polygon()).unwrap();
            let case = Case { receiver: &receiver, emitter: &emitter, occluders: &[], plan: &plan };
            let (components, method) = to_tolerance(&All, &case, 1e-14).unwrap().unwrap();
            let theirs = Derivatives::new(&case, components, method);
            let share = |off: f64, errors: f64| if off == 0.0 { 0.0 } else { off / errors };
            let vectors = [(ours.gradient, theirs.gradient), (ours.normal, theirs.normal)];
            let vectors = vectors.into_iter().chain(ours.vertices.iter().copied().zip(theirs.vertices.iter().copied()));
            let numbers = [(ours.radiosity, theirs.radiosity), (ours.reflectance, theirs.reflectance)];
            let numbers = numbers.into_iter().chain(ours.emission.iter().copied().zip(theirs.emission.iter().copied()));
            for (a, b) in vectors {
                worst[kind] = largest(worst[kind], share((a.value - b.value).length(), a.error + b.error));
            }
            for (a, b) in numbers {
                worst[kind] = largest(worst[kind], share((a.value - b.value).abs(), a.error + b.error));
            }
            counts[kind] += 1;
            sharp[kind] += usize::from(Derivatives::on_lanes(&receiver, &emitter, 1e-11).is_some());
            longest = longest.max(ours.vertices.len() as f64);
        }
        println!("{counts:?} found, {sharp:?} to 1e-11, worst shares of bounds {worst:?}");
        assert!(counts.iter().all(|&n| n > 200) && sharp.iter().all(|&n| n > 100), "{counts:?} {sharp:?}");
        assert!(worst.iter().all(|&worst| worst < 1.0 && worst > 1e-4) && longest == 4.0, "{worst:?}");
    }
}
