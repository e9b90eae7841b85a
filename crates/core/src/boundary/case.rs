//! One receiver, one emitter, the occluders between them, and the plan for them.

use crate::boundary::plan::Plan;
use crate::problem::emission::Emitter;
use crate::problem::polygon::Polygon;
use crate::problem::receiver::Receiver;

/// What a rung of the ladder evaluates.
#[derive(Clone, Copy)]
pub(crate) struct Case<'a> {
    pub(crate) receiver: &'a Receiver,
    pub(crate) emitter: &'a Emitter,
    pub(crate) occluders: &'a [&'a Polygon],
    pub(crate) plan: &'a Plan,
}

impl Case<'_> {
    /// Whether nothing is emitted, or all of it absorbed.
    pub(crate) fn is_dark(&self) -> bool {
        self.emitter.is_dark() || self.receiver.reflectance() == 0.0
    }
}
