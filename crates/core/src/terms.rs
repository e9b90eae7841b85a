//! The sums over the visible boundary that value and gradient are made of, for whatever emission and scalar.
//!
//! The arcs come from [`crate::horizon`], or from [`crate::visibility`] past occluders; the sums are those of
//! [`crate::constant`], [`crate::linear`] and [`crate::polynomial`]. On balls they carry a proven bound, on doubles they give
//! the same digits without one.

use crate::arc::Arc;
use crate::constant::{EdgeSum, SolidAngleVector};
use crate::double_double::UNIT;
use crate::ladder::Case;
use crate::linear::{LinearSum, Seen};
use crate::number::Number;
use crate::plan::unit_normal;
use crate::polynomial::{self, PolynomialSum};
use crate::real::{RadiusOf, Real};
use crate::vec3::Vec3;
use crate::{Emission, Receiver, horizon, visibility};

/// Irradiance vector and gradient without the factor rho/pi, in normalised lengths and emission.
pub(crate) struct Terms<T> {
    pub(crate) irradiance: Vec3<T>,
    /// Zero where it was not asked for.
    pub(crate) gradient: Vec3<T>,
}

impl<T: Real> Terms<T> {
    /// Sums what is asked for; `None` where nothing is visible.
    #[inline]
    pub(crate) fn sum<const VALUE: bool, const GRADIENT: bool>(case: &Case<'_>) -> Option<Self> {
        let Case { receiver, emitter, plan, .. } = *case;
        let terms = if let Emission::Constant(_) = emitter.emission() {
            let mut angles = SolidAngleVector::zero();
            let mut edges = EdgeSum::new(unit_normal(receiver));
            let doubt = visit(case, |arc: &Arc<T>| {
                if VALUE {
                    angles.add(arc);
                }
                if GRADIENT {
                    edges.add(arc);
                }
            })?;
            let emission = T::exact(emitter.affine().value);
            Self { irradiance: angles.phi() * emission, gradient: edges.sum() * emission }.widened(doubt)
        } else if let Some(plane) = emitter.polynomial() {
            let seen = polynomial::Seen::new(receiver, emitter, plane, plan.power);
            let mut sum = PolynomialSum::new(seen);
            let doubt = visit(case, |arc: &Arc<T>| sum.add::<GRADIENT>(arc))?;
            let gradient = if GRADIENT { sum.gradient() } else { Vec3::zero() };
            Self { irradiance: sum.irradiance(), gradient }.widened(doubt)
        } else {
            let mut sum = LinearSum::new(Seen::new(receiver, emitter, plan.power));
            let doubt = visit(case, |arc: &Arc<T>| sum.add::<GRADIENT>(arc))?;
            sum.total().widened(doubt)
        };
        Some(terms)
    }

    fn widened(self, doubt: visibility::Doubt<RadiusOf<T>>) -> Self {
        Self {
            irradiance: self.irradiance.map(|c| c.widened(doubt.irradiance)),
            gradient: self.gradient.map(|c| c.widened(doubt.gradient)),
        }
    }

    /// Radiosity, in normalised emission.
    #[inline]
    pub(crate) fn radiosity(&self, receiver: &Receiver) -> T {
        unit_normal(receiver).dot(self.irradiance) * albedo(receiver)
    }

    /// Gradient, in normalised lengths and emission.
    #[inline]
    pub(crate) fn gradient(&self, receiver: &Receiver) -> Vec3<T> {
        self.gradient * albedo(receiver)
    }
}

/// Calls the arcs of the visible boundary; returns what undecided visibility may change, or `None` where nothing is visible.
#[inline]
pub(crate) fn visit<T: Real>(case: &Case<'_>, visit: impl FnMut(&Arc<T>)) -> Option<visibility::Doubt<RadiusOf<T>>> {
    let Case { receiver, emitter, occluders, plan } = *case;
    if occluders.is_empty() {
        horizon::visit_boundary(receiver, emitter.polygon(), plan, visit);
        Some(visibility::Doubt::none())
    } else {
        visibility::visit_boundary(receiver, emitter, occluders, plan, visit)
    }
}

/// `rho / pi`.
#[inline]
pub(crate) fn albedo<T: Real>(receiver: &Receiver) -> T {
    if T::Number::BEYOND_DOUBLE_DOUBLE {
        return T::exact(receiver.reflectance()) / T::pi();
    }
    let albedo = receiver.albedo();
    T::from_double_double(albedo, 32.0 * UNIT * albedo.hi)
}
