//! The arcs of the visible boundary, each traced to the line of the input that it is on.

use radgrad_numbers::real::{RadiusOf, Real};

use crate::boundary::arc::Arc;
use crate::boundary::case::Case;
use crate::boundary::edge_name::EdgeName;
use crate::boundary::line::{Line, Sighted};
use crate::boundary::origin::Origin;
use crate::boundary::plan::Horizon;
use crate::boundary::visibility;
use crate::boundary::visibility::uncertainty::Uncertainty;

/// Calls the arcs of the visible boundary with their origins; returns a bound on the effect of undecided visibility, or `None` where
/// nothing is visible.
pub(crate) fn visit_with_origins<T: Real>(
    case: &Case<'_>,
    mut visit: impl FnMut(&Arc<T>, Origin),
) -> Option<Uncertainty<RadiusOf<T>>> {
    let Case { receiver, emitter, occluders, plan } = *case;
    if !occluders.is_empty() || plan.horizon == Horizon::Crossing {
        let (arcs, uncertainty) = visibility::arcs_with_origins(receiver, emitter, occluders, plan)?;
        arcs.iter().for_each(|(arc, origin)| visit(arc, *origin));
        return Some(uncertainty);
    }
    let (x, vertices, power) = (receiver.position(), emitter.polygon().vertices(), plan.power);
    for (i, &from) in vertices.iter().enumerate() {
        let to = vertices[(i + 1) % vertices.len()];
        let (start, end) = (Sighted::from(from, x, power), Sighted::from(to, x, power));
        let line = Line::through([from, to], [&start, &end], x, power);
        let origin = Origin::Edge { occluder: None, edge: EdgeName::new(from, to) };
        visit(&Arc::of_edge(start, end, T::exact(1.0), line), origin);
    }
    Some(Uncertainty::none())
}
