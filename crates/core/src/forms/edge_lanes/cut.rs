//! The parts of four edges that are above the receiver's horizon, cut where [`crate::boundary::horizon`] cuts them.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f64x4, mask64x4};
use radgrad_numbers::arc_tangent::is_in_range;
use radgrad_numbers::double_double::DoubleDouble;
use radgrad_numbers::lanes::vectors::{chosen, plus_first, splat_vector};
use radgrad_numbers::number::ROUNDOFF;
use radgrad_numbers::vec3::Vec3;

use crate::boundary::arc::{Arc, Generator};
use crate::boundary::line::Sighted;
use crate::forms::edge_lanes::EdgeLanes;
use crate::problem::polygon::FourEdges;
use crate::problem::receiver::{Receiver, unit_normal};

/// Heights over the horizon, times the length of the normal as given, above which double-double has all digits of a double: it
/// errs by 64 units of terms that sum to less than 12 in normalised lengths.
const LOWEST: f64 = 1024.0 * ROUNDOFF;

/// The point p where the horizon cuts an edge, t along it from its end r, is off by `u (|r| + 6 t|e| + |p|)`: the 6 are four
/// roundings of t and two of its product ([`crate::forms::constant_bound`]).
const MOVED_ALONG: f64 = 6.0;

/// The parts of a polygon's edges above the horizon, where its boundary leaves the upper half-space once.
pub(crate) struct Cut<S: Simd> {
    /// The edges, with the ends and the angles of their visible parts.
    pub(crate) four: EdgeLanes<S>,
    /// Which have one.
    pub(crate) visible: mask64x4<S>,
    /// The arc along the horizon, from where the boundary leaves the upper half-space to where it comes back.
    pub(crate) closing: Arc<f64>,
    /// How far the ends of the edges are off, relative to their distances, in units of roundoff: 0 where an edge is not cut.
    pub(crate) moved: f64x4<S>,
    /// The same of the ends of the arc along the horizon.
    pub(crate) closing_moved: [f64; 2],
}

impl<S: Simd> Cut<S> {
    /// The cut of the first `count` edges, all that the polygon has; `None` unless double-double is sure of all digits of the
    /// heights of vertices.
    #[inline(always)]
    pub(crate) fn new(simd: S, receiver: &Receiver, edges: &FourEdges, count: usize, power: f64) -> Option<Self> {
        let mut four =
            EdgeLanes::new::<true>(simd, edges, splat_vector(simd, receiver.position()), f64x4::splat(simd, power), false)?;
        let before = heights(simd, receiver, edges.starts(simd), power);
        let after = heights(simd, receiver, edges.ends(simd), power);
        if !before.abs().min(after.abs()).simd_ge(f64x4::splat(simd, LOWEST)).all_true() {
            return None;
        }
        let (zero, one) = (f64x4::splat(simd, 0.0), f64x4::splat(simd, 1.0));
        let (starts, ends) = (before.simd_gt(zero), after.simd_gt(zero));
        let (exits, entries) = (starts & !ends, ends & !starts);
        let of_polygon = (1 << count) - 1;
        let (exit, entry) = (exits.to_bitmask() & of_polygon, entries.to_bitmask() & of_polygon);
        if exit.count_ones() != 1 {
            return None;
        }
        let change = before - after;
        let fraction = exits.select(before / change, entries.select(after / -change, one));
        let (Arc { start, end, .. }, along) = (&four.arc, four.line.e * fraction);
        let inside = entries.select(end.square, start.square).sqrt();
        let start = Sighted::new(chosen(entries, end.point - along, start.point));
        let end = Sighted::new(chosen(exits, four.arc.start.point + along, end.point));
        four.arc = Arc::of_edge(start, end, fraction, four.line);
        let Arc { start, end, .. } = &four.arc;
        let reach = inside + along.norm_squared().sqrt() * f64x4::splat(simd, MOVED_ALONG);
        let moved = (exits | entries).select(reach * entries.select(start.inverse, end.inverse) + one, zero);
        let plain = is_in_range(four.arc.across, four.arc.inline);
        let horizon = Generator::Horizon(-unit_normal::<f64>(receiver));
        if !plain.all_true() {
            return None;
        }
        let [exit, entry] = [exit, entry].map(|bit| (bit.trailing_zeros() & 3) as usize);
        let closing = Arc::between(Sighted::new(lane(end.point, exit)), Sighted::new(lane(start.point, entry)), horizon);
        let closing_moved = [moved[exit], moved[entry]];
        Some(Self { four, visible: starts | ends, closing, moved, closing_moved })
    }

    /// A sum with the terms of the first lanes where there is something to see.
    #[inline(always)]
    pub(crate) fn add(&self, simd: S, sum: Vec3<f64>, terms: Vec3<f64x4<S>>, count: usize) -> Vec3<f64> {
        let zero = f64x4::splat(simd, 0.0);
        plus_first(sum, chosen(self.visible, terms, Vec3::new(zero, zero, zero)), count)
    }
}

/// The vector in a lane.
#[inline(always)]
fn lane<S: Simd>(v: Vec3<f64x4<S>>, i: usize) -> Vec3<f64> {
    let (x, y, z) = (v.x.as_array(), v.y.as_array(), v.z.as_array());
    Vec3::new(x[i], y[i], z[i])
}

/// As [`crate::boundary::plan::height_over_horizon`] where double-double does.
#[inline(always)]
fn heights<S: Simd>(simd: S, receiver: &Receiver, points: Vec3<f64x4<S>>, power: f64) -> f64x4<S> {
    let (n, x) = (splat_vector(simd, receiver.direction()), splat_vector(simd, receiver.position()));
    let n = n.map(
        #[inline(always)]
        |c| DoubleDouble { hi: c, lo: f64x4::splat(simd, 0.0) },
    );
    let offset = Vec3::new(
        DoubleDouble::difference(points.x, x.x).scaled(power),
        DoubleDouble::difference(points.y, x.y).scaled(power),
        DoubleDouble::difference(points.z, x.z).scaled(power),
    );
    n.dot(offset).hi
}
