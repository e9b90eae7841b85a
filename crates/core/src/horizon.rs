//! The boundary of the part of an emitter above the receiver's horizon, `n1.r > 0`, with nothing in between.
//!
//! An edge that crosses the horizon is cut where the heights of its vertices, both with full relative accuracy
//! ([`crate::plan`]), say so. Each gap from where the boundary leaves the upper half-space to where it comes back is closed by
//! an arc of the horizon. On a concave polygon the gaps overlap; their signed angles still add up to those of the true
//! boundary, since all lie on one line.

use crate::arc::{Arc, Generator, Line};
use crate::plan::{Horizon, Plan, height_over_horizon, offset, unit_normal};
use crate::real::Real;
use crate::vec3::Vec3;
use crate::{Polygon, Receiver};

/// Calls `visit` with each arc of the boundary.
#[inline]
pub(crate) fn visit_boundary<T: Real>(receiver: &Receiver, polygon: &Polygon, plan: &Plan, visit: impl FnMut(&Arc<T>)) {
    match plan.horizon {
        Horizon::Above => whole(receiver, polygon, plan.power, visit),
        Horizon::Crossing => clipped(receiver, polygon, plan.power, visit),
    }
}

/// The corners of edge `i`.
#[inline]
fn edge(polygon: &Polygon, i: usize) -> (glam::DVec3, glam::DVec3) {
    let vertices = polygon.vertices();
    (vertices[i], vertices[if i + 1 == vertices.len() { 0 } else { i + 1 }])
}

#[inline]
fn whole<T: Real>(receiver: &Receiver, polygon: &Polygon, power: f64, mut visit: impl FnMut(&Arc<T>)) {
    let x = receiver.position();
    for i in 0..polygon.vertices().len() {
        let (from, to) = edge(polygon, i);
        let line = Line::through(from, to, x, power);
        visit(&Arc::of_edge(offset(from, x, power), offset(to, x, power), T::exact(1.0), line));
    }
}

fn clipped<T: Real>(receiver: &Receiver, polygon: &Polygon, power: f64, mut visit: impl FnMut(&Arc<T>)) {
    let x = receiver.position();
    let horizon = Generator::Horizon(-unit_normal::<T>(receiver));
    // The last point where the boundary left, and the first where it came back, if that was before any left.
    let (mut left, mut first_entry): (Option<Vec3<T>>, Option<Vec3<T>>) = (None, None);
    let mut before: T = height_over_horizon(receiver, polygon.vertices()[0], power);
    for i in 0..polygon.vertices().len() {
        let (from, to) = edge(polygon, i);
        let after: T = height_over_horizon(receiver, to, power);
        let (starts_above, ends_above) = (before.value() > 0.0, after.value() > 0.0);
        if starts_above || ends_above {
            let line = Line::through(from, to, x, power);
            let (start, end) = (offset(from, x, power), offset(to, x, power));
            if starts_above && ends_above {
                visit(&Arc::of_edge(start, end, T::exact(1.0), line));
            } else if starts_above {
                let fraction = before / (before - after);
                let crossing = start + line.e * fraction;
                visit(&Arc::of_edge(start, crossing, fraction, line));
                left = Some(crossing);
            } else {
                let fraction = after / (after - before);
                let crossing = end - line.e * fraction;
                visit(&Arc::of_edge(crossing, end, fraction, line));
                match left {
                    Some(exit) => visit(&Arc::between(exit, crossing, horizon)),
                    None => first_entry = Some(crossing),
                }
            }
        }
        before = after;
    }
    if let (Some(exit), Some(entry)) = (left, first_entry) {
        visit(&Arc::between(exit, entry, horizon));
    }
}
