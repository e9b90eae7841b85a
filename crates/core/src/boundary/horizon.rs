//! The boundary of the part of an emitter above the receiver's horizon, `n1.r > 0`, with nothing in between.
//!
//! An edge that crosses the horizon is cut where the heights of its vertices, both with full relative accuracy
//! ([`crate::boundary::plan`]), say so. Each gap from where the boundary leaves the upper half-space to where it comes back is
//! closed by an arc of the horizon. On a concave polygon the gaps overlap; their signed angles still add up to those of the true
//! boundary, since all lie on one line.

use radgrad_numbers::real::Real;
use smallvec::SmallVec;

use crate::boundary::arc::{Arc, Generator};
use crate::boundary::line::{Line, Sighted};
use crate::boundary::plan::{Horizon, Plan, height_over_horizon};
use crate::problem::polygon::Polygon;
use crate::problem::receiver::{Receiver, unit_normal};

/// The arcs of a polygon with five vertices need no memory of their own.
type Arcs<T> = SmallVec<[Arc<T>; 6]>;

/// Calls `visit` with each arc of the boundary. Those past a horizon are computed first, so that their code is compiled once.
#[inline]
pub(crate) fn visit_boundary<T: Real>(receiver: &Receiver, polygon: &Polygon, plan: &Plan, visit: impl FnMut(&Arc<T>)) {
    match plan.horizon {
        Horizon::Above => whole(receiver, polygon, plan.power, visit),
        Horizon::Crossing => clipped(receiver, polygon, plan.power).iter().for_each(visit),
    }
}

#[inline]
fn whole<T: Real>(receiver: &Receiver, polygon: &Polygon, power: f64, mut visit: impl FnMut(&Arc<T>)) {
    let (x, vertices) = (receiver.position(), polygon.vertices());
    let mut from = vertices[vertices.len() - 1];
    for &to in vertices {
        // Seen anew for each edge: carried from one to the next they would wait for memory.
        let (start, end) = (Sighted::from(from, x, power), Sighted::from(to, x, power));
        let line = Line::through([from, to], [&start, &end], x, power);
        visit(&Arc::of_edge(start, end, T::exact(1.0), line));
        from = to;
    }
}

fn clipped<T: Real>(receiver: &Receiver, polygon: &Polygon, power: f64) -> Arcs<T> {
    let (x, vertices) = (receiver.position(), polygon.vertices());
    let horizon = Generator::Horizon(-unit_normal::<T>(receiver));
    let mut arcs = Arcs::new();
    // The last point where the boundary left, and the first where it came back, if that was before any left.
    let (mut exit, mut first_entry): (Option<Sighted<T>>, Option<Sighted<T>>) = (None, None);
    // Arcs of the horizon come one gap late: the only one of a convex polygon after all its edges.
    let mut gap: Option<Arc<T>> = None;
    let mut from = vertices[vertices.len() - 1];
    let mut start = Sighted::from(from, x, power);
    let mut before: T = height_over_horizon(receiver, from, power);
    for &to in vertices {
        let end = Sighted::from(to, x, power);
        let after: T = height_over_horizon(receiver, to, power);
        let (starts_above, ends_above) = (before.value() > 0.0, after.value() > 0.0);
        if starts_above || ends_above {
            let line = Line::through([from, to], [&start, &end], x, power);
            if starts_above && ends_above {
                arcs.push(Arc::of_edge(start, end, T::exact(1.0), line));
            } else if starts_above {
                let fraction = before / (before - after);
                let crossing = Sighted::new(start.point + line.e * fraction);
                arcs.push(Arc::of_edge(start, crossing, fraction, line));
                exit = Some(crossing);
            } else {
                let fraction = after / (after - before);
                let crossing = Sighted::new(end.point - line.e * fraction);
                arcs.push(Arc::of_edge(crossing, end, fraction, line));
                match exit {
                    Some(exit) => arcs.extend(gap.replace(Arc::between(exit, crossing, horizon))),
                    None => first_entry = Some(crossing),
                }
            }
        }
        (from, start, before) = (to, end, after);
    }
    arcs.extend(gap);
    if let (Some(exit), Some(entry)) = (exit, first_entry) {
        arcs.push(Arc::between(exit, entry, horizon));
    }
    arcs
}
