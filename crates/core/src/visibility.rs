use crate::arc::Arc;
use crate::plan::Plan;
use crate::real::Real;
use crate::{Emitter, Polygon, Receiver};
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Doubt {
    pub(crate) irradiance: f64,
    pub(crate) gradient: f64,
}
pub(crate) fn visit_boundary<T: Real>(
    r: &Receiver,
    e: &Emitter,
    _o: &[Polygon],
    plan: &Plan,
    visit: impl FnMut(&Arc<T>),
) -> Doubt {
    crate::horizon::visit_boundary(r, e.polygon(), plan, visit);
    Doubt::default()
}
