//! Edge lanes: four edges of an emitter without occluders, one a lane of a vector; [`cut`] where the horizon crosses it.
//!
//! The operations are those of [`crate::boundary::arc`] and [`crate::boundary::line`] on doubles, in the same order, so the
//! digits are the same; the decisions are those of [`crate::boundary::plan`]. Where double precision is not sure of a decision
//! these decide: a receiver that is not surely in front of the plane, a vertex that is neither surely above the horizon nor
//! surely below, an edge that passes very near the receiver.

pub(crate) mod constant;
pub(crate) mod constant_bound;
pub(crate) mod cut;
pub(crate) mod linear;
#[cfg(test)]
pub(crate) mod random;

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f64x4};

use crate::boundary::arc::weight::PSI;
use crate::boundary::plan::{Horizon, Plan, least_sure_height};
use crate::forms::irradiance_and_gradient::IrradianceAndGradient;
use crate::lanes::double_double::DoubleDoubles;
use crate::lanes::functions::{nine_terms, plain_angle};
use crate::lanes::instruction_set::{INSTRUCTION_SET, on_instruction_set};
use crate::lanes::vectors::{all, chosen, row};
use crate::problem::polygon::{FourEdges, Polygon};
use crate::problem::receiver::Receiver;
use crate::scalar::double_double::{DoubleDouble, ROUNDOFF_OF_DOUBLE_DOUBLE};
use crate::scalar::number::ROUNDOFF;
use crate::scalar::power::normalising_power;
use crate::scalar::vec3::Vec3;

/// An emitter of which double precision is sure what is seen, with bounds B.
pub(crate) struct SureCase<B> {
    pub(crate) plan: Plan,
    /// The sums and their bounds, where they were asked for and no edge needs more care.
    pub(crate) sums: Option<(IrradianceAndGradient<f64>, B)>,
}

/// The plan, where the receiver is surely in front of the plane and all vertices are surely above its horizon; or, of up to four
/// vertices, surely above or below.
#[inline(always)]
pub(crate) fn plan<S: Simd>(simd: S, receiver: &Receiver, polygon: &Polygon) -> Option<Plan> {
    let position = receiver.position();
    let (x, n1) = (all(simd, position), all(simd, receiver.direction()));
    let (mut farthest, mut lowest) = (f64x4::splat(simd, 0.0), f64x4::splat(simd, f64::INFINITY));
    let fours = polygon.four_edges();
    for four in fours {
        let r = four.ends(simd) - x;
        farthest = farthest.max(r.x.abs().max(r.y.abs()).max(r.z.abs()));
        lowest = lowest.min(n1.dot(r));
    }
    let ([a, b, c, d], [p, q, r, s]) = (*farthest.as_array(), *lowest.as_array());
    let larger = |a: f64, b: f64| if a > b { a } else { b };
    let lower = |a: f64, b: f64| if a < b { a } else { b };
    let farthest = larger(larger(a, b), larger(c, d));
    let height = polygon.normal().dot(position - polygon.vertices()[0]);
    let surely = least_sure_height(farthest);
    if !(height > surely + polygon.half_slab() && polygon.is_well_known()) {
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

/// The power of two that normalises lengths, where the receiver is surely in front of the plane and all vertices are surely above
/// its horizon.
#[inline(always)]
pub(crate) fn power_seen_whole<S: Simd>(simd: S, receiver: &Receiver, polygon: &Polygon) -> Option<f64> {
    plan(simd, receiver, polygon).filter(|plan| plan.horizon == Horizon::Above).map(|plan| plan.power)
}

/// Four arcs of edges: `Arc<f64>` on lanes.
pub(crate) struct EdgeLanes<S: Simd> {
    pub(crate) start: Vec3<f64x4<S>>,
    pub(crate) end: Vec3<f64x4<S>>,
    pub(crate) e: Vec3<f64x4<S>>,
    pub(crate) edge_square: f64x4<S>,
    pub(crate) start_square: f64x4<S>,
    /// `|r|^2` of the vertex that w was taken at, be that seen or not.
    pub(crate) line_square: f64x4<S>,
    pub(crate) normal: Vec3<f64x4<S>>,
    /// `|w|`.
    pub(crate) moment: f64x4<S>,
    pub(crate) across: f64x4<S>,
    pub(crate) inline: f64x4<S>,
    pub(crate) angle: f64x4<S>,
}

impl<S: Simd> EdgeLanes<S> {
    /// As [`crate::boundary::line::Line::through`] and [`crate::boundary::arc::Arc::of_edge`]; unless `NEAR`, only where w need
    /// not be taken at the nearer end.
    #[inline(always)]
    pub(crate) fn new<const NEAR: bool>(simd: S, four: &FourEdges, x: Vec3<f64x4<S>>, power: f64x4<S>) -> Option<Self> {
        let (from, to) = (four.starts(simd), four.ends(simd));
        let (start, end, e) = ((from - x) * power, (to - x) * power, (to - from) * power);
        let (start_square, edge_square) = (start.norm_squared(), e.norm_squared());
        let (mut w, mut line_square) = (start.cross(e), start_square);
        let mut square = w.norm_squared();
        let mut passes = (f64x4::splat(simd, 16.0) * square).simd_ge(start_square * edge_square);
        if NEAR && !passes.all_true() {
            let end_square = end.norm_squared();
            let at_end = !passes & end_square.simd_lt(start_square);
            w = chosen(at_end, end, start).cross(e);
            line_square = at_end.select(end_square, start_square);
            square = w.norm_squared();
            passes |= (f64x4::splat(simd, 64.0) * square).simd_ge(line_square * edge_square);
        }
        let moment = square.sqrt();
        let inline = start.dot(end);
        let (angle, plain) = plain_angle::<S, _, true>(simd, moment, inline);
        let normal = w * (f64x4::splat(simd, 1.0) / moment);
        (passes & plain).all_true().then_some(Self {
            start,
            end,
            e,
            edge_square,
            start_square,
            line_square,
            normal,
            moment,
            across: moment,
            inline,
            angle,
        })
    }
}

/// What arcs up to a quarter turn weigh: `chi` and `psi` of [`crate::boundary::arc::Arc::weight`], and what they are made of.
pub(crate) struct Weights<S: Simd> {
    chi: f64x4<S>,
    psi: f64x4<S>,
    /// `g + sin g`.
    pub(crate) sum: f64x4<S>,
    pub(crate) one_and_cos: f64x4<S>,
}

impl<S: Simd> Weights<S> {
    /// As [`crate::boundary::arc::Arc::within_a_quarter_turn`], from `1/|r|` at the ends.
    #[inline(always)]
    pub(crate) fn new(simd: S, four: &EdgeLanes<S>, [q1, q2]: [f64x4<S>; 2]) -> Self {
        let product = q1 * q2;
        let (sin, cos) = (four.across * product, four.inline * product);
        let one_and_cos = f64x4::splat(simd, 1.0) + cos;
        let sum = four.angle + sin;
        let z = four.angle * four.angle;
        let psi = four.angle * (f64x4::splat(simd, PSI[0]) + z * nine_terms(simd, &HIGHER, z));
        Self { chi: sum / (one_and_cos * f64x4::splat(simd, 4.0)), psi, sum, one_and_cos }
    }

    #[inline(always)]
    pub(crate) fn of(&self, [q1, q2]: [f64x4<S>; 2], [c1, c2]: [f64x4<S>; 2]) -> f64x4<S> {
        self.chi * (q1 + q2) * (c1 + c2) + self.psi * (q2 - q1) * (c2 - c1)
    }
}

/// What follows the first term of [`PSI`].
const HIGHER: [f64; 9] = {
    let [_, c1, c2, c3, c4, c5, c6, c7, c8, c9] = PSI;
    [c1, c2, c3, c4, c5, c6, c7, c8, c9]
};

/// The height of the receiver over the polygon's plane, in double-double rounded to a double as
/// [`crate::boundary::plan::height_over_plane`] has it, with x, y and z side by side.
#[inline(always)]
pub(crate) fn height_over_plane<S: Simd>(simd: S, receiver: &Receiver, polygon: &Polygon, power: f64) -> f64 {
    height_and_reach(simd, receiver, polygon, power).0
}

/// That height and a bound on its error.
#[inline]
pub(crate) fn certain_height(receiver: &Receiver, polygon: &Polygon, power: f64) -> (f64, f64) {
    let (height, reach) = on_instruction_set!(*INSTRUCTION_SET, simd => height_and_reach(simd, receiver, polygon, power));
    (
        height,
        reach * (polygon.normal_error() + 8.0 * ROUNDOFF_OF_DOUBLE_DOUBLE) * (1.0 + 8.0 * ROUNDOFF) + ROUNDOFF * height.abs(),
    )
}

/// That height, and the sum of the coordinates of the polygon's first vertex by size, as the receiver sees it.
#[inline(always)]
fn height_and_reach<S: Simd>(simd: S, receiver: &Receiver, polygon: &Polygon, power: f64) -> (f64, f64) {
    let (Vec3 { x, y, z }, power) = (polygon.precise_normal(), f64x4::splat(simd, power));
    let n = DoubleDoubles { hi: row(simd, [x.hi, y.hi, z.hi]), lo: row(simd, [x.lo, y.lo, z.lo]) };
    let (vertex, x) = (row(simd, polygon.vertices()[0].to_array()), row(simd, receiver.position().to_array()));
    let r = DoubleDoubles::difference(vertex, x, power);
    let product = n.times(simd, r);
    let term = |i: usize| DoubleDouble { hi: product.hi[i], lo: product.lo[i] };
    let reach = r.hi.abs();
    (-(term(0) + term(1) + term(2)).hi, reach[0] + reach[1] + reach[2])
}
