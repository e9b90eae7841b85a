//! The sums of a case over its visible boundary, for whatever emission and scalar.
//!
//! The arcs come from [`crate::boundary::horizon`], or from [`crate::boundary::visibility`] where there are occluders.

use radgrad_numbers::real::{RadiusOf, Real};
use radgrad_numbers::vec3::Vec3;

use crate::boundary::arc::Arc;
use crate::boundary::case::Case;
use crate::boundary::visibility::uncertainty::Uncertainty;
use crate::boundary::{horizon, visibility};
use crate::forms::constant::{EdgeSum, SolidAngleVector};
use crate::forms::irradiance_and_gradient::IrradianceAndGradient;
use crate::forms::linear::{LinearSum, SeenLinear};
use crate::forms::polynomial::sum::{PolynomialSum, SeenPolynomial};
use crate::problem::emission::Emission;
use crate::problem::receiver::unit_normal;

impl<T: Real> IrradianceAndGradient<T> {
    /// Sums value, gradient or both, as asked for; `None` where nothing is visible.
    #[inline]
    pub(crate) fn sum<const VALUE: bool, const GRADIENT: bool>(case: &Case<'_>) -> Option<Self> {
        let Case { receiver, emitter, plan, .. } = *case;
        let terms = if let Emission::Constant(_) = emitter.emission() {
            let mut angles = SolidAngleVector::zero();
            let mut edges = EdgeSum::new(unit_normal(receiver));
            let uncertainty = visit(case, |arc: &Arc<T>| {
                if VALUE {
                    angles.add(arc);
                }
                if GRADIENT {
                    edges.add(arc);
                }
            })?;
            let emission = T::exact(emitter.affine().value);
            Self { irradiance: angles.phi() * emission, gradient: edges.sum() * emission }.widened(uncertainty)
        } else if let Some(plane) = emitter.polynomial() {
            let seen = SeenPolynomial::new(receiver, emitter, plane, plan.power);
            let mut sum = PolynomialSum::new(seen);
            let uncertainty = visit(case, |arc: &Arc<T>| sum.add::<GRADIENT>(arc))?;
            let gradient = if GRADIENT { sum.gradient() } else { Vec3::zero() };
            Self { irradiance: sum.irradiance(), gradient }.widened(uncertainty)
        } else {
            let mut sum = LinearSum::new(SeenLinear::new(receiver, emitter, plan.power));
            let uncertainty = visit(case, |arc: &Arc<T>| sum.add::<GRADIENT>(arc))?;
            sum.total().widened(uncertainty)
        };
        Some(terms)
    }

    fn widened(self, uncertainty: Uncertainty<RadiusOf<T>>) -> Self {
        Self {
            irradiance: self.irradiance.map(|c| c.widened(uncertainty.irradiance)),
            gradient: self.gradient.map(|c| c.widened(uncertainty.gradient)),
        }
    }
}

/// Calls the arcs of the visible boundary; returns a bound on the effect of undecided visibility, or `None` where nothing is
/// visible.
#[inline]
pub(crate) fn visit<T: Real>(case: &Case<'_>, visit: impl FnMut(&Arc<T>)) -> Option<Uncertainty<RadiusOf<T>>> {
    let Case { receiver, emitter, occluders, plan } = *case;
    if occluders.is_empty() {
        horizon::visit_boundary(receiver, emitter.polygon(), plan, visit);
        return Some(Uncertainty::none());
    }
    let (arcs, uncertainty) = visibility::arcs(receiver, emitter, occluders, plan)?;
    arcs.iter().for_each(visit);
    Some(uncertainty)
}
