//! Edge lanes: four edges of an emitter without occluders, one a lane of a vector; [`cut`] where the horizon crosses it.
//!
//! The operations are those of [`crate::boundary::arc`] and [`crate::boundary::line`] on doubles, in the same order, so the
//! digits are the same; the decisions are those of [`crate::boundary::plan`]. Where double precision is not sure of a decision
//! these decide: a receiver that is not surely in front of the plane, a vertex that is neither surely above the horizon nor
//! surely below, an edge that passes very near the receiver.

pub(crate) mod constant;
pub(crate) mod cut;
pub(crate) mod linear;
pub(crate) mod precise;
#[cfg(test)]
pub(crate) mod random;
pub(crate) mod shares;

use std::ops::Range;
use std::sync::LazyLock;

use fearless_simd::prelude::*;
use fearless_simd::{Level, Simd, f64x4};
use glam::DVec3;
use radgrad_numbers::arc_tangent::is_in_range;
use radgrad_numbers::double_double::{DoubleDouble, ROUNDOFF_OF_DOUBLE_DOUBLE};
use radgrad_numbers::in_library;
use radgrad_numbers::lanes::vectors::{chosen, row, splat_vector};
use radgrad_numbers::number::ROUNDOFF;
use radgrad_numbers::power::normalising_power;
use radgrad_numbers::vec3::Vec3;

use crate::boundary::arc::Arc;
use crate::boundary::line::{Line, MOMENT_UNITS, Sighted};
use crate::boundary::plan::{Horizon, Plan, least_sure_height};
use crate::forms::irradiance_and_gradient::IrradianceAndGradient;
use crate::problem::polygon::{FourEdges, Polygon};
use crate::problem::receiver::Receiver;

/// The best instruction set of this machine. It stands where it is used: a static of another crate is read through a table, at
/// three instructions an answer.
pub(crate) static INSTRUCTION_SET: LazyLock<Level> = LazyLock::new(Level::new);

/// An emitter whose visible part is sure in double precision, with bounds B.
pub(crate) struct SureCase<B> {
    pub(crate) plan: Plan,
    /// The sums and their bounds, where they were requested and no edge needs more care.
    pub(crate) sums: Option<(IrradianceAndGradient<f64>, B)>,
}

/// The plan, where the receiver is surely in front of the plane and all vertices are surely above its horizon; or, of up to four
/// vertices, surely above or below.
#[inline(always)]
pub(crate) fn plan<S: Simd>(simd: S, receiver: &Receiver, polygon: &Polygon) -> Option<Plan> {
    plan_in(simd, receiver, polygon, 1.0)
}

/// The same where products of lengths leave the range; a function apart, so that the common case does not pay for it. Offsets of
/// finite coordinates are never NaN.
pub(crate) fn plan_far_out(receiver: &Receiver, polygon: &Polygon) -> Option<Plan> {
    let reach = |v: &DVec3| (*v - receiver.position()).abs().max_element();
    let farthest = polygon.vertices().iter().map(reach).fold(0.0, f64::max);
    if least_sure_height(farthest).is_finite() {
        return None;
    }
    let power = normalising_power(farthest);
    let plan = in_library!(*INSTRUCTION_SET, simd => plan_in(simd, receiver, polygon, power))?;
    Some(Plan { power, ..plan })
}

/// The same with lengths times a power of two, for the caller to put in the place of the plan's own power.
#[inline(always)]
fn plan_in<S: Simd>(simd: S, receiver: &Receiver, polygon: &Polygon, power: f64) -> Option<Plan> {
    let position = receiver.position();
    let (x, n1) = (splat_vector(simd, position), splat_vector(simd, receiver.direction()));
    let (mut farthest, mut lowest) = (f64x4::splat(simd, 0.0), f64x4::splat(simd, f64::INFINITY));
    let fours = polygon.four_edges();
    for four in fours {
        let r = (four.ends(simd) - x) * f64x4::splat(simd, power);
        farthest = farthest.max(r.x.abs().max(r.y.abs()).max(r.z.abs()));
        lowest = lowest.min(n1.dot(r));
    }
    let ([a, b, c, d], [p, q, r, s]) = (*farthest.as_array(), *lowest.as_array());
    let larger = |a: f64, b: f64| if a > b { a } else { b };
    let lower = |a: f64, b: f64| if a < b { a } else { b };
    let farthest = larger(larger(a, b), larger(c, d));
    let height = polygon.normal().dot((position - polygon.vertices()[0]) * power);
    let surely = least_sure_height(farthest);
    if !(height > surely + polygon.half_slab() * power && polygon.is_well_known()) {
        return None;
    }
    let power = normalising_power(farthest);
    if lower(lower(p, q), lower(r, s)) > surely {
        return Some(Plan::whole(power));
    }
    // Of one four these are the heights of all vertices.
    let is_cut = fours.len() == 1
        && lowest.abs().simd_gt(f64x4::splat(simd, surely)).all_true()
        && larger(larger(p, q), larger(r, s)) > 0.0;
    is_cut.then_some(Plan { power, horizon: Horizon::Crossing, on_surface: false })
}

/// Powers of two so near to 1 that products of eight lengths stay in range without them.
const NEAR_ONE: Range<f64> = 1e-12..1e12;

/// The sums of a plan whose power is near 1, by lengths in the caller's unit, with the same digits: so they need not wait for the
/// farthest vertex to be found. Other powers are left to the rungs that follow.
#[inline(always)]
fn without_power(
    plan: &Plan,
    sums: impl FnOnce(f64) -> Option<IrradianceAndGradient<f64>>,
) -> Option<IrradianceAndGradient<f64>> {
    if !NEAR_ONE.contains(&plan.power) {
        return None;
    }
    let IrradianceAndGradient { irradiance, gradient } = sums(1.0)?;
    Some(IrradianceAndGradient { irradiance, gradient: gradient * (1.0 / plan.power) })
}

/// Four arcs of edges.
pub(crate) struct EdgeLanes<S: Simd> {
    pub(crate) arc: Arc<f64x4<S>>,
    pub(crate) line: Line<f64x4<S>>,
    edge_square: f64x4<S>,
    /// Whether all edges of a polygon are here: each one ends where the next one starts.
    closed: bool,
}

impl<S: Simd> EdgeLanes<S> {
    /// As [`Line::through`] and [`Arc::of_edge`]; unless `NEAR`, only where w need not be taken at the nearer end.
    #[inline(always)]
    pub(crate) fn new<const NEAR: bool>(
        simd: S,
        four: &FourEdges,
        x: Vec3<f64x4<S>>,
        power: f64x4<S>,
        closed: bool,
    ) -> Option<Self> {
        let (from, to) = (four.starts(simd), four.ends(simd));
        let (start, e) = (Sighted::new((from - x) * power), (to - from) * power);
        let end = if closed {
            let Sighted { point: Vec3 { x, y, z }, square, inverse } = start;
            Sighted { point: Vec3::new(next(x), next(y), next(z)), square: next(square), inverse: next(inverse) }
        } else {
            Sighted::new((to - x) * power)
        };
        let edge_square = e.norm_squared();
        let (mut w, mut reach) = (start.point.cross(e), start.square);
        let mut square = w.norm_squared();
        let mut passes = (f64x4::splat(simd, 16.0) * square).simd_ge(reach * edge_square);
        if NEAR && !passes.all_true() {
            let at_end = !passes & end.square.simd_lt(start.square);
            w = chosen(at_end, end.point, start.point).cross(e);
            reach = at_end.select(end.square, start.square);
            square = w.norm_squared();
            passes |= (f64x4::splat(simd, 64.0) * square).simd_ge(reach * edge_square);
        }
        let line = Line::new(e, edge_square, w, reach);
        let arc = Arc::of_edge(start, end, f64x4::splat(simd, 1.0), line);
        if !(passes & is_in_range(arc.across, arc.inline)).all_true() {
            return None;
        }
        Some(Self { arc, line, edge_square, closed })
    }

    /// A function of the two ends.
    #[inline(always)]
    pub(crate) fn at_ends(&self, function: impl Fn(&Sighted<f64x4<S>>) -> f64x4<S>) -> [f64x4<S>; 2] {
        let start = function(&self.arc.start);
        [start, if self.closed { next(start) } else { function(&self.arc.end) }]
    }

    /// As [`Line::relative_error`], in units of roundoff: edges that lanes take pass at an eighth of the distance at least.
    #[inline(always)]
    pub(crate) fn relative_error(&self) -> f64x4<S> {
        (self.line.reach * self.edge_square).sqrt() / self.line.moment * MOMENT_UNITS[0] + MOMENT_UNITS[1]
    }
}

/// Each lane gets the number of the next one.
#[inline(always)]
fn next<S: Simd>(lanes: f64x4<S>) -> f64x4<S> {
    lanes.rotate_elements_left::<1>()
}

/// The height of the receiver over the polygon's plane, in double-double rounded to a double as
/// [`crate::boundary::plan::height_over_plane`] has it, with x, y and z side by side.
#[inline(always)]
pub(crate) fn height_over_plane<S: Simd>(simd: S, receiver: &Receiver, polygon: &Polygon, power: f64) -> f64 {
    height_and_reach(simd, receiver, polygon, power).0
}

/// The receiver's height over the polygon's plane and a bound on its error.
#[inline]
pub(crate) fn certain_height(receiver: &Receiver, polygon: &Polygon, power: f64) -> (f64, f64) {
    let (height, reach) = in_library!(*INSTRUCTION_SET, simd => height_and_reach(simd, receiver, polygon, power));
    (
        height,
        reach * (polygon.normal_error() + 8.0 * ROUNDOFF_OF_DOUBLE_DOUBLE) * (1.0 + 8.0 * ROUNDOFF) + ROUNDOFF * height.abs(),
    )
}

/// The receiver's height over the polygon's plane, and the sum of the coordinates of the polygon's first vertex by size, as the
/// receiver sees it.
#[inline(always)]
fn height_and_reach<S: Simd>(simd: S, receiver: &Receiver, polygon: &Polygon, power: f64) -> (f64, f64) {
    let Vec3 { x, y, z } = polygon.precise_normal();
    let n = DoubleDouble { hi: row(simd, [x.hi, y.hi, z.hi]), lo: row(simd, [x.lo, y.lo, z.lo]) };
    let (vertex, x) = (row(simd, polygon.vertices()[0].to_array()), row(simd, receiver.position().to_array()));
    let r = DoubleDouble::difference(vertex, x).scaled(power);
    let product = n * r;
    let term = |i: usize| DoubleDouble { hi: product.hi[i], lo: product.lo[i] };
    let reach = r.hi.abs();
    (-(term(0) + term(1) + term(2)).hi, reach[0] + reach[1] + reach[2])
}
