//! The parts of four edges that are above the receiver's horizon, cut where [`crate::boundary::horizon`] cuts them.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f64x4, mask64x4};
use glam::DVec3;

use crate::boundary::arc::{Arc, Generator};
use crate::boundary::line::Sighted;
use crate::forms::edge_lanes::EdgeLanes;
use crate::lanes::double_double::DoubleDoubles;
use crate::lanes::functions::plain_angle;
use crate::lanes::vectors::{all, chosen, plus_first};
use crate::problem::polygon::FourEdges;
use crate::problem::receiver::{Receiver, unit_normal};
use crate::scalar::number::ROUNDOFF;
use crate::scalar::vec3::Vec3;

/// Heights over the horizon, times the length of the normal as given, above which double-double has all digits of a double: it
/// errs by 64 units of terms that sum to less than 12 in normalised lengths.
const LOWEST: f64 = 1024.0 * ROUNDOFF;

/// What is above the horizon of the edges of a polygon that leaves it once.
pub(crate) struct Cut<S: Simd> {
    /// The edges, with the ends and the angles of their visible parts.
    pub(crate) four: EdgeLanes<S>,
    /// Which have one.
    pub(crate) visible: mask64x4<S>,
    /// The arc along the horizon, from where the boundary leaves the upper half-space to where it comes back.
    pub(crate) closing: Arc<f64>,
}

impl<S: Simd> Cut<S> {
    /// Of the first `count` edges, all that the polygon has; where double-double is sure of all digits of the heights of
    /// vertices.
    #[inline(always)]
    pub(crate) fn new(simd: S, receiver: &Receiver, edges: &FourEdges, count: usize, power: f64) -> Option<Self> {
        let lanes = f64x4::splat(simd, power);
        let mut four = EdgeLanes::new::<true>(simd, edges, all(simd, receiver.position()), lanes)?;
        let before = heights(simd, receiver, edges.starts(simd), lanes);
        let after = heights(simd, receiver, edges.ends(simd), lanes);
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
        let along = four.e * fraction;
        let (from_start, from_end) = (four.start + along, four.end - along);
        four.start = chosen(entries, from_end, four.start);
        four.end = chosen(exits, from_start, four.end);
        four.start_square = four.start.norm_squared();
        four.across = fraction * four.moment;
        four.inline = four.start.dot(four.end);
        let (angle, plain) = plain_angle::<S, _, true>(simd, four.across, four.inline);
        four.angle = angle;
        let horizon = Generator::Horizon(-unit_normal::<f64>(receiver));
        let (exit, entry) = (Sighted::at(lane(four.end, exit)), Sighted::at(lane(four.start, entry)));
        plain.all_true().then(|| Self { four, visible: starts | ends, closing: Arc::between(exit, entry, horizon) })
    }

    /// The sum over the first lanes of what there is to see.
    #[inline(always)]
    pub(crate) fn sum(&self, simd: S, terms: Vec3<f64x4<S>>, count: usize) -> Vec3<f64> {
        let zero = f64x4::splat(simd, 0.0);
        plus_first(Vec3::default(), chosen(self.visible, terms, Vec3::new(zero, zero, zero)), count)
    }
}

/// The vector in the lane of a bit.
#[inline(always)]
fn lane<S: Simd>(v: Vec3<f64x4<S>>, bit: u64) -> Vec3<f64> {
    let i = (bit.trailing_zeros() & 3) as usize;
    let (x, y, z) = (v.x.as_array(), v.y.as_array(), v.z.as_array());
    Vec3::new(x[i], y[i], z[i])
}

/// As [`crate::boundary::plan::height_over_horizon`] where double-double does.
#[inline(always)]
fn heights<S: Simd>(simd: S, receiver: &Receiver, points: Vec3<f64x4<S>>, power: f64x4<S>) -> f64x4<S> {
    let (n, x): (DVec3, DVec3) = (receiver.direction(), receiver.position());
    let along_x = term(simd, n.x, points.x, x.x, power);
    along_x.plus(term(simd, n.y, points.y, x.y, power)).plus(term(simd, n.z, points.z, x.z, power)).hi
}

#[inline(always)]
fn term<S: Simd>(simd: S, n: f64, point: f64x4<S>, x: f64, power: f64x4<S>) -> DoubleDoubles<S> {
    let r = DoubleDoubles::difference(point, f64x4::splat(simd, x), power);
    DoubleDoubles { hi: f64x4::splat(simd, n), lo: f64x4::splat(simd, 0.0) }.times(simd, r)
}
