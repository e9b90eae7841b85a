//! One receiver, one emitter, any occluders: the answer with its bounds.
//!
//! `B(x) = (rho/pi) int B(y) (n1.r)(-n2.r)/|r|^4 dA` (HS95 Eq. 1) over the part of the emitter that x sees above its horizon, and its gradient with
//! respect to x at fixed n1. The sums of [`crate::constant`] and [`crate::linear`] run over the boundary that [`crate::horizon`] or
//! [`crate::visibility`] finds; with [`Ball`] for scalar they carry a proven bound, with `f64` they give the same digits without one.

use glam::DVec3;

use crate::arc::Arc;
use crate::certify::Ball;
use crate::constant::{EdgeSum, SolidAngleVector};
use crate::linear::{LinearSum, Seen};
use crate::plan::{Plan, unit_normal};
use crate::real::Real;
use crate::vec3::Vec3;
use crate::{Emission, Emitter, Error, Polygon, Receiver, horizon, visibility};

/// Radiosity and its gradient with proven absolute error bounds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Answer {
    /// Radiosity `B(x)`, in the unit of the emission.
    pub radiosity: f64,
    /// Gradient of `B` with respect to `x` at fixed normal, in that unit over the unit of length.
    pub gradient: DVec3,
    /// Proven bound on the error of `radiosity`.
    pub radiosity_error: f64,
    /// Proven bound on the Euclidean norm of the error of `gradient`.
    pub gradient_error: f64,
    /// What answered.
    pub method: Method,
}

impl Answer {
    const ZERO: Self =
        Self { radiosity: 0.0, gradient: DVec3::ZERO, radiosity_error: 0.0, gradient_error: 0.0, method: Method::Zero };
}

/// What gave an answer.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Method {
    /// Nothing to compute: the receiver is behind the emitter or in its plane, the emitter is below the horizon, or occluders hide all of
    /// it. Exactly 0.
    Zero,
    /// The closed form in double precision with a running error bound.
    ClosedForm,
}

impl Method {
    /// Name in files: `zero`, `closed-form`.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Zero => "zero",
            Self::ClosedForm => "closed-form",
        }
    }
}

/// Radiosity and gradient at `receiver` due to the part of `emitter` that it sees past `occluders`, with bounds.
///
/// Occluders are opaque from both sides; those behind the receiver or the emitter are left out by themselves. Where the bound on the rounding of
/// some step has no finite value (an emitter edge through the receiver to the last digit), the bound is infinite.
///
/// ```
/// use radgrad_core::{DVec3, Emission, Emitter, Polygon, Receiver, evaluate};
/// let at = |x, y, z| DVec3::new(x, y, z);
/// let ceiling = Polygon::new(vec![at(0.0, 0.0, 1.0), at(0.0, 1.0, 1.0), at(1.0, 1.0, 1.0), at(1.0, 0.0, 1.0)])?;
/// let lamp = Emitter::new(ceiling, Emission::Constant(1.0))?;
/// let corner = Receiver::new(DVec3::ZERO, DVec3::Z, 1.0)?;
/// let answer = evaluate(&corner, &lamp, &[])?;
/// assert!((answer.radiosity - 0.138_531_605_994_893).abs() <= answer.radiosity_error);
/// assert!(answer.radiosity_error < 1e-14);
/// # Ok::<(), radgrad_core::Error>(())
/// ```
///
/// # Errors
/// If a result overflows.
pub fn evaluate(receiver: &Receiver, emitter: &Emitter, occluders: &[Polygon]) -> Result<Answer, Error> {
    let Some(plan) = Plan::new(receiver, emitter.polygon()) else { return Ok(Answer::ZERO) };
    let Some(terms) = Terms::<Ball>::sum::<true, true>(receiver, emitter, occluders, &plan) else { return Ok(Answer::ZERO) };
    let (radiosity, gradient) = (terms.radiosity(receiver), terms.gradient(receiver, &plan));
    let radius = gradient.map(Ball::error);
    Ok(Answer {
        radiosity: finite(radiosity.value(), "radiosity")?,
        gradient: finite_vector(gradient)?,
        radiosity_error: bound(radiosity.error()),
        gradient_error: bound(radius.norm_squared().sqrt() * (1.0 + 8.0 * f64::EPSILON)),
        method: Method::ClosedForm,
    })
}

/// Radiosity `B(x)` alone: the digits of [`evaluate`], without bound and gradient.
///
/// # Errors
/// If the result overflows.
pub fn radiosity(receiver: &Receiver, emitter: &Emitter) -> Result<f64, Error> {
    let Some((_, terms)) = unoccluded::<true, false>(receiver, emitter) else { return Ok(0.0) };
    finite(terms.radiosity(receiver), "radiosity")
}

/// Gradient of `B` with respect to `x` alone: the digits of [`evaluate`], without bound and value.
///
/// # Errors
/// If the result overflows.
pub fn gradient(receiver: &Receiver, emitter: &Emitter) -> Result<DVec3, Error> {
    let Some((plan, terms)) = unoccluded::<false, true>(receiver, emitter) else { return Ok(DVec3::ZERO) };
    finite_vector(terms.gradient(receiver, &plan))
}

/// Radiosity and gradient together: the digits of [`evaluate`], without bounds.
///
/// # Errors
/// If a result overflows.
pub fn radiosity_and_gradient(receiver: &Receiver, emitter: &Emitter) -> Result<(f64, DVec3), Error> {
    let Some((plan, terms)) = unoccluded::<true, true>(receiver, emitter) else { return Ok((0.0, DVec3::ZERO)) };
    Ok((finite(terms.radiosity(receiver), "radiosity")?, finite_vector(terms.gradient(receiver, &plan))?))
}

/// Irradiance vector `E = int B(y) omega domega` over the part of the emitter above the horizon, in the unit of the emission.
///
/// The radiosity is `(rho/pi) n1.E`; a receiver at the same point with a nearby normal m, and the same part of the emitter above its horizon,
/// has `(rho/pi) m.E`. Its derivative with respect to the normal is `dB/dn1 = (rho/pi) E`, also where the horizon crosses the emitter, since
/// the part that the horizon gains or loses is seen edge-on.
///
/// # Errors
/// If the result overflows.
pub fn irradiance_vector(receiver: &Receiver, emitter: &Emitter) -> Result<DVec3, Error> {
    let Some((_, terms)) = unoccluded::<true, false>(receiver, emitter) else { return Ok(DVec3::ZERO) };
    let vector: DVec3 = terms.irradiance.into();
    if vector.is_finite() { Ok(vector) } else { Err(Error::Overflow { quantity: "irradiance vector" }) }
}

/// The plan and the sums asked for, or `None` where all are exactly zero.
#[inline]
fn unoccluded<const VALUE: bool, const GRADIENT: bool>(receiver: &Receiver, emitter: &Emitter) -> Option<(Plan, Terms<f64>)> {
    let plan = Plan::new(receiver, emitter.polygon())?;
    Terms::sum::<VALUE, GRADIENT>(receiver, emitter, &[], &plan).map(|terms| (plan, terms))
}

/// Irradiance vector and gradient without the factor rho/pi, in normalised lengths.
struct Terms<T> {
    irradiance: Vec3<T>,
    /// Zero where it was not asked for.
    gradient: Vec3<T>,
}

impl<T: Real> Terms<T> {
    /// Sums what is asked for; `None` where nothing is visible.
    #[inline]
    fn sum<const VALUE: bool, const GRADIENT: bool>(
        receiver: &Receiver,
        emitter: &Emitter,
        occluders: &[Polygon],
        plan: &Plan,
    ) -> Option<Self> {
        let terms = match emitter.emission() {
            Emission::Constant(value) => {
                let mut angles = SolidAngleVector::zero();
                let mut edges = EdgeSum::new(unit_normal(receiver));
                let doubt = visit(receiver, emitter, occluders, plan, |arc: &Arc<T>| {
                    if VALUE {
                        angles.add(arc);
                    }
                    if GRADIENT {
                        edges.add(arc);
                    }
                })?;
                let emission = T::exact(*value);
                Self { irradiance: angles.phi() * emission, gradient: edges.sum() * emission }.widened(doubt)
            }
            Emission::Linear(_) => {
                let mut sum = LinearSum::new(Seen::new(receiver, emitter.polygon(), emitter.affine(), plan.power));
                let doubt = visit(receiver, emitter, occluders, plan, |arc: &Arc<T>| sum.add::<GRADIENT>(arc))?;
                let total = sum.total();
                Self { irradiance: total.irradiance, gradient: total.gradient }.widened(doubt)
            }
        };
        Some(terms)
    }

    fn widened(self, doubt: visibility::Doubt) -> Self {
        Self {
            irradiance: self.irradiance.map(|c| c.widened(doubt.irradiance)),
            gradient: self.gradient.map(|c| c.widened(doubt.gradient)),
        }
    }

    #[inline]
    fn radiosity(&self, receiver: &Receiver) -> T {
        unit_normal(receiver).dot(self.irradiance) * albedo(receiver)
    }

    #[inline]
    fn gradient(&self, receiver: &Receiver, plan: &Plan) -> Vec3<T> {
        // The power of two last: scaling a scene by one scales the digits exactly.
        (self.gradient * albedo(receiver)).map(|c| c * T::exact(plan.power))
    }
}

/// Calls the arcs of the visible boundary; returns what undecided visibility may change, or `None` where nothing is visible.
#[inline]
fn visit<T: Real>(
    receiver: &Receiver,
    emitter: &Emitter,
    occluders: &[Polygon],
    plan: &Plan,
    visit: impl FnMut(&Arc<T>),
) -> Option<visibility::Doubt> {
    if occluders.is_empty() {
        horizon::visit_boundary(receiver, emitter.polygon(), plan, visit);
        Some(visibility::Doubt::default())
    } else {
        visibility::visit_boundary(receiver, emitter, occluders, plan, visit)
    }
}

/// `rho / pi`.
#[inline]
fn albedo<T: Real>(receiver: &Receiver) -> T {
    T::exact(receiver.reflectance()) / T::pi()
}

fn finite(value: f64, quantity: &'static str) -> Result<f64, Error> {
    if value.is_finite() { Ok(value) } else { Err(Error::Overflow { quantity }) }
}

fn finite_vector<T: Real>(v: Vec3<T>) -> Result<DVec3, Error> {
    let v: DVec3 = v.map(T::value).into();
    if v.is_finite() { Ok(v) } else { Err(Error::Overflow { quantity: "gradient" }) }
}

/// A bound that is not a number bounds nothing.
fn bound(radius: f64) -> f64 {
    if radius.is_nan() { f64::INFINITY } else { radius }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn case(normal: DVec3, emission: Emission) -> (Receiver, Emitter) {
        let triangle = [[-0.9, 0.1, 1.2], [-0.1, 0.7, 1.3], [0.4, -0.9, 1.1]].map(DVec3::from);
        let polygon = Polygon::new(triangle.iter().rev().copied().collect()).unwrap();
        let emitter = if polygon.normal().z < 0.0 { polygon } else { Polygon::new(triangle.to_vec()).unwrap() };
        (Receiver::new(DVec3::new(0.2, -0.1, 0.0), normal, 0.7).unwrap(), Emitter::new(emitter, emission).unwrap())
    }

    #[test]
    fn value_alone_gradient_alone_and_both_have_the_digits_of_the_bounded_answer() {
        for normal in [DVec3::new(0.1, 0.2, 1.0), DVec3::new(1.0, -0.3, 0.1)] {
            for emission in [Emission::Constant(3.2), Emission::at_vertices(vec![1.0, 0.25, 2.5])] {
                let (receiver, emitter) = case(normal, emission);
                let answer = evaluate(&receiver, &emitter, &[]).unwrap();
                assert!(answer.radiosity > 0.0 && answer.radiosity_error < 1e-12);
                assert_eq!(radiosity(&receiver, &emitter).unwrap(), answer.radiosity);
                assert_eq!(gradient(&receiver, &emitter).unwrap(), answer.gradient);
                assert_eq!(radiosity_and_gradient(&receiver, &emitter).unwrap(), (answer.radiosity, answer.gradient));
            }
        }
    }

    #[test]
    fn the_irradiance_vector_is_the_derivative_with_respect_to_the_normal() {
        for normal in [DVec3::new(0.1, 0.2, 1.0), DVec3::new(1.0, -0.3, 0.1)] {
            for emission in [Emission::Constant(3.2), Emission::at_vertices(vec![1.0, 0.25, 2.5])] {
                let (receiver, emitter) = case(normal, emission);
                let vector = irradiance_vector(&receiver, &emitter).unwrap();
                let per_pi = receiver.reflectance() / std::f64::consts::PI;
                let value = radiosity(&receiver, &emitter).unwrap();
                assert!((per_pi * receiver.normal().dot(vector) - value).abs() < 1e-15);
                let tangent = receiver.normal().any_orthonormal_vector();
                let step = 1e-4;
                let turned = |step: f64| {
                    let turned = Receiver::new(receiver.position(), receiver.normal() + tangent * step, 0.7).unwrap();
                    // The unit normal is shorter than n1 + step t by (1 + step^2)^(1/2).
                    radiosity(&turned, &emitter).unwrap() * (1.0 + step * step).sqrt()
                };
                let difference = (turned(step) - turned(-step)) / (2.0 * step);
                assert!((difference - per_pi * tangent.dot(vector)).abs() < 1e-8, "{difference} {normal}");
            }
        }
    }

    #[test]
    fn a_reversed_or_hidden_emitter_gives_exactly_zero() {
        let (receiver, emitter) = case(DVec3::Z, Emission::Constant(1.0));
        let reversed = Polygon::new(emitter.polygon().vertices().iter().rev().copied().collect()).unwrap();
        let dark = evaluate(&receiver, &Emitter::new(reversed, Emission::Constant(1.0)).unwrap(), &[]).unwrap();
        assert_eq!((dark.radiosity, dark.gradient, dark.radiosity_error, dark.method), (0.0, DVec3::ZERO, 0.0, Method::Zero));
        let away = Receiver::new(receiver.position(), DVec3::NEG_Z, 1.0).unwrap();
        assert_eq!(evaluate(&away, &emitter, &[]).unwrap().method, Method::Zero);
    }

    #[test]
    fn a_result_too_large_for_a_double_is_an_error() {
        let (receiver, emitter) = case(DVec3::Z, Emission::Constant(1e308));
        assert!(evaluate(&receiver, &emitter, &[]).is_ok());
        let near = [[-1e-200, -1e-200, 1e-210], [0.0, 1e-200, 1e-210], [1e-200, -1e-200, 1e-210]].map(DVec3::from);
        let polygon = Polygon::new(near.to_vec()).unwrap();
        let emitter = Emitter::new(polygon, Emission::Constant(1e150)).unwrap();
        let below = Receiver::new(DVec3::new(1e-200, 0.0, 0.0), DVec3::Z, 1.0).unwrap();
        assert_eq!(evaluate(&below, &emitter, &[]), Err(Error::Overflow { quantity: "gradient" }));
    }
}
