//! The sums of a case over its visible boundary, for whatever emission and scalar.
//!
//! The arcs come from [`crate::boundary::horizon`], or from [`crate::boundary::visibility`] where there are occluders.

use radgrad_numbers::number::Number;
use radgrad_numbers::real::{RadiusOf, Real};
use radgrad_numbers::vec3::Vec3;

use crate::boundary::arc::Arc;
use crate::boundary::case::Case;
use crate::boundary::visibility::sure;
use crate::boundary::visibility::uncertainty::Uncertainty;
use crate::boundary::{horizon, visibility};
use crate::forms::constant::{EdgeSum, SolidAngleVector};
use crate::forms::irradiance_and_gradient::IrradianceAndGradient;
use crate::forms::linear::{LinearSum, SeenLinear};
use crate::forms::polynomial::sum::{PolynomialSum, SeenPolynomial};
use crate::problem::emission::Emission;
use crate::problem::receiver::unit_normal;

impl<T: Real> IrradianceAndGradient<T> {
    /// Sums value, gradient or both, as requested; `None` where nothing is visible.
    #[inline]
    pub(crate) fn sum<const VALUE: bool, const GRADIENT: bool>(case: &Case<'_>) -> Option<Self> {
        let Case { receiver, emitter, plan, .. } = *case;
        let terms = if let Emission::Constant(_) = emitter.emission() {
            let mut angles = SolidAngleVector::zero();
            let mut edges = EdgeSum::new(unit_normal(receiver));
            let uncertainty = visit::<T, GRADIENT>(case, |arc: &Arc<T>| {
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
            let relative = SeenPolynomial::new(receiver, emitter, plane, plan.power);
            let mut sum = PolynomialSum::new(relative);
            let uncertainty = visit::<T, GRADIENT>(case, |arc: &Arc<T>| sum.add::<GRADIENT>(arc))?;
            let gradient = if GRADIENT { sum.gradient() } else { Vec3::zero() };
            Self { irradiance: sum.irradiance(), gradient }.widened(uncertainty)
        } else {
            let mut sum = LinearSum::new(SeenLinear::new(receiver, emitter, plan.power));
            let uncertainty = visit::<T, GRADIENT>(case, |arc: &Arc<T>| sum.add::<GRADIENT>(arc))?;
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

/// The value where all is hidden and the gradient alone is in doubt is bounded by this, in normalised units: it is 0, and stays in the range of doubles.
const NEXT_TO_NOTHING: f64 = f64::from_bits((1023 - 1000) << 52);

/// Calls the arcs of the visible boundary; returns a bound on the effect of undecided visibility, or `None` where nothing is visible, nor, if the
/// gradient is wanted, beside the place.
#[inline]
pub(crate) fn visit<T: Real, const GRADIENT: bool>(
    case: &Case<'_>,
    visit: impl FnMut(&Arc<T>),
) -> Option<Uncertainty<RadiusOf<T>>> {
    let Case { receiver, emitter, occluders, plan } = *case;
    if occluders.is_empty() {
        horizon::visit_boundary(receiver, emitter.polygon(), plan, visit);
        return Some(Uncertainty::none());
    }
    // Plain doubles have a rung of their own where they are sure.
    if !T::Number::IS_DOUBLE
        && let Emission::Constant(_) = emitter.emission()
        && let Some(arcs) = sure::arcs(receiver, emitter.polygon(), occluders, plan)
    {
        arcs.iter().for_each(visit);
        return Some(Uncertainty::none());
    }
    let (arcs, mut uncertainty) = visibility::arcs(receiver, emitter, occluders, plan)?;
    if arcs.is_empty() && uncertainty.irradiance == 0.0.into() {
        if !GRADIENT {
            return None;
        }
        uncertainty.irradiance = NEXT_TO_NOTHING.into();
    }
    arcs.iter().for_each(visit);
    Some(uncertainty)
}

#[cfg(test)]
mod tests {
    use glam::DVec3;
    use radgrad_numbers::ball::Ball;
    use radgrad_numbers::double_double::DoubleDouble;

    use super::*;
    use crate::boundary::plan::Plan;
    use crate::problem::emission::Emitter;
    use crate::problem::polygon::Polygon;
    use crate::problem::receiver::Receiver;

    type Precise = Ball<DoubleDouble>;

    fn sums(receiver: &Receiver, arcs: &[Arc<Precise>]) -> [Precise; 6] {
        let (mut angles, mut edges) = (SolidAngleVector::zero(), EdgeSum::new(unit_normal(receiver)));
        for arc in arcs {
            angles.add(arc);
            edges.add(arc);
        }
        let (phi, gradient) = (angles.phi(), edges.sum());
        [phi.x, phi.y, phi.z, gradient.x, gradient.y, gradient.z]
    }

    #[test]
    fn what_double_precision_decides_has_the_sums_that_many_digits_decide() {
        let step = |i: usize, step: f64| (i as f64 * step).fract();
        let triangle = |i: usize, size: f64, height: f64| {
            let [x, y, z] = [0.618_034, 0.754_878, 0.569_84].map(|irrational| step(i, irrational));
            let corners = [[x, y, 0.1 * z], [x + 0.5 * size, y + size, 0.15 * z], [x + size, y + 0.25 * size, 0.2 * z]];
            Polygon::new(corners.map(|[x, y, z]| DVec3::new(x, y, height + z)).to_vec()).unwrap()
        };
        let lamp = Emitter::new(triangle(0, 1.0, 1.0), Emission::Constant(1.0)).unwrap();
        // Two that share an edge, with corners in common, beside those that do not.
        let [a, b, c, d] = [[0.5, 0.6], [0.9, 0.7], [0.8, 1.1], [0.4, 1.0]].map(|[x, y]| DVec3::new(x, y, 0.6));
        let halves = [[a, b, c], [a, c, d]].map(|corners| Polygon::new(corners.to_vec()).unwrap());
        let (mut visible, mut cut) = (0, 0);
        for i in 0..300 {
            let place = DVec3::new(step(i, 0.324_718), step(i, 0.414_214), -0.5);
            // Of every third the horizon cuts the lamp.
            let normal = if i % 3 == 0 { DVec3::new(1.0, 0.4, 0.2) } else { DVec3::new(0.2, -0.1, 1.0) };
            let receiver = Receiver::new(place, normal, 0.5).unwrap();
            let mut screens: Vec<Polygon> = (1..=1 + i % 5).map(|k| triangle(i * 7 + k, 0.3, 0.3)).collect();
            if i % 2 == 0 {
                screens.extend(halves.iter().cloned());
            }
            let occluders: Vec<&Polygon> = screens.iter().collect();
            let Some(plan) = Plan::new(&receiver, lamp.polygon()) else { continue };
            let Some(arcs) = sure::arcs(&receiver, lamp.polygon(), &occluders, &plan) else { continue };
            let expected = visibility::arcs(&receiver, &lamp, &occluders, &plan).map_or_else(Vec::new, |(arcs, _)| arcs);
            for (arcs, expected) in sums(&receiver, &arcs).into_iter().zip(sums(&receiver, &expected)) {
                let apart = arcs - expected;
                assert!(apart.size() <= apart.error() && apart.error() < 1e-24, "{i}: {apart:?}");
            }
            visible += usize::from(!arcs.is_empty());
            cut += usize::from(arcs.iter().any(|arc| arc.line().is_none()));
        }
        assert!(visible > 150 && cut > 30, "{visible} {cut}");
    }
}
