//! One receiver, one emitter, the occluders between them, and the plan for them.

#[cfg(feature = "arbitrary-precision")]
use glam::DVec3;

use crate::boundary::plan::Plan;
use crate::boundary::visibility;
use crate::error::Error;
use crate::problem::emission::Emitter;
use crate::problem::polygon::Polygon;
use crate::problem::receiver::Receiver;
use crate::problem::triangulate::Few;

/// A receiver, an emitter and its occluders, as a rung of the ladder evaluates them.
#[derive(Clone, Copy)]
pub(crate) struct Case<'a> {
    pub(crate) receiver: &'a Receiver,
    pub(crate) emitter: &'a Emitter,
    pub(crate) occluders: &'a [&'a Polygon],
    pub(crate) plan: &'a Plan,
}

impl<'a> Case<'a> {
    /// The occluders that a look at circular cones leaves; on the surface all.
    pub(crate) fn near_by(&self) -> Few<&'a Polygon> {
        if self.occluders.is_empty() || self.plan.on_surface {
            return Few::from_slice(self.occluders);
        }
        visibility::near_by(self.receiver, self.emitter.polygon(), self.occluders, self.plan)
    }

    /// The occluders that a rung dearer than [`crate::boundary::visibility::sure`] has to look at.
    pub(crate) fn in_between(&self) -> Vec<&'a Polygon> {
        visibility::in_between(self.receiver, self.emitter.polygon(), self.occluders, self.plan)
    }
}

impl Case<'_> {
    /// Whether nothing is emitted, or all of it absorbed.
    pub(crate) fn is_dark(&self) -> bool {
        self.emitter.is_dark() || self.receiver.reflectance() == 0.0
    }

    /// Whether no length and no component of a normal is far smaller than the largest, unless it is 0: products of a few of them,
    /// where not 0, are then far above the rounding left where they cancel. In contact at a height of 1e-300 it is not.
    #[cfg(feature = "arbitrary-precision")]
    pub(crate) fn is_of_one_scale(&self) -> bool {
        const LEAST: f64 = 1.0 / (1u128 << 100) as f64;
        let x = self.receiver.position();
        let occluders = self.occluders.iter().flat_map(|occluder| occluder.vertices());
        let polygons = self.occluders.iter().copied().chain([self.emitter.polygon()]);
        let edges = polygons.flat_map(|polygon| {
            let v = polygon.vertices();
            (0..v.len()).map(move |i| v[(i + 1) % v.len()] - v[i])
        });
        let offsets = self.emitter.polygon().vertices().iter().chain(occluders).map(|&vertex| vertex - x);
        let lengths = offsets.chain(edges).map(|length| length * self.plan.power);
        let is_of_one_scale = |v: DVec3| v.to_array().into_iter().all(|c| c == 0.0 || c.abs() >= LEAST);
        // A component that is 0 only when scaled has underflowed.
        let (given, direction) = (self.receiver.given_normal(), self.receiver.direction());
        given.cmpeq(DVec3::ZERO) == direction.cmpeq(DVec3::ZERO)
            && lengths.chain([direction, self.emitter.polygon().normal()]).all(is_of_one_scale)
    }
}

/// Runs a computation that is not zero by plan; the reflectance has no part in it.
pub(crate) fn with_case<R>(
    receiver: &Receiver,
    emitter: &Emitter,
    occluders: &[&Polygon],
    zero: R,
    computation: impl FnOnce(&Case<'_>) -> Result<R, Error>,
) -> Result<R, Error> {
    let Some(plan) = Plan::new(receiver, emitter.polygon()) else { return Ok(zero) };
    if emitter.is_dark() {
        return Ok(zero);
    }
    plan.off_surface(receiver, emitter.polygon())?;
    computation(&Case { receiver, emitter, occluders, plan: &plan })
}
