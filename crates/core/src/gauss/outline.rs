//! The corners of the part of the emitter above the horizon, over which the rule integrates where the horizon crosses the emitter.
//!
//! A crossing is where the heights of an edge's ends over the horizon, both to full relative accuracy, say so: the fraction t
//! of the way e from the end above errs by 8u, u = 2^-53. Offsets are kept from a vertex above, too, so that a small part of a
//! large polygon loses nothing. With Λ the longest of these, `|e| t <= 2Λ`, and corners err by
//!
//! | | local offset | offset from x | height over the horizon |
//! |---|---|---|---|
//! | vertex | `u Λ` | `u |r|` | `5u |r|`, or `8u` of itself |
//! | crossing | `22u Λ` | `2u |r| + 22u Λ` | exactly 0 |

use std::ops::Deref;

use glam::DVec3;
use radgrad_numbers::number::ROUNDOFF;
use radgrad_numbers::offset::offset;
use radgrad_numbers::vec3::Vec3;
use smallvec::SmallVec;

use crate::boundary::plan::{Plan, height_over_horizon};
use crate::gauss::scene::Scene;
use crate::gauss::source::Lit;
use crate::problem::polygon::Polygon;
use crate::problem::receiver::Receiver;

/// A corner of the outline, in normalised lengths.
#[derive(Debug, Clone, Copy)]
pub(super) struct OutlineCorner {
    /// Offset from the receiver.
    pub(super) from_receiver: Vec3<f64>,
    /// Offset from a vertex above the horizon: differences of these lose nothing to the distance.
    pub(super) local: Vec3<f64>,
    /// `n1.r`.
    pub(super) facing: f64,
    /// Bound on the error of that.
    pub(super) facing_error: f64,
    pub(super) lit: Lit,
}

/// Corners in order. A few are kept in place, so that an answer allocates nothing for an ordinary emitter.
#[derive(Debug)]
pub(super) struct Corners {
    few: [OutlineCorner; FEW],
    count: usize,
    /// All of them, if they are more than a few.
    many: Vec<OutlineCorner>,
}

const FEW: usize = 12;

impl Corners {
    /// None yet; `any` holds their places.
    fn new(any: OutlineCorner) -> Self {
        Self { few: [any; FEW], count: 0, many: Vec::new() }
    }

    fn push(&mut self, corner: OutlineCorner) {
        if let Some(place) = self.few.get_mut(self.count) {
            *place = corner;
            self.count += 1;
        } else {
            if self.many.is_empty() {
                self.many.extend(self.few);
            }
            self.many.push(corner);
        }
    }
}

impl Deref for Corners {
    type Target = [OutlineCorner];

    fn deref(&self) -> &[OutlineCorner] {
        if self.many.is_empty() { &self.few[..self.count] } else { &self.many }
    }
}

/// Below this share of the distance the height over the horizon is taken to full relative accuracy.
const GRAZING: f64 = 0.0625;

impl Scene<'_> {
    /// The corners of the part above the horizon, counter-clockwise as the polygon's vertices are (Sutherland and Hodgman 1974).
    pub(super) fn outline(&self, receiver: &Receiver, polygon: &Polygon, plan: &Plan) -> Corners {
        let count = polygon.vertices().len();
        let facing: SmallVec<[f64; FEW]> =
            polygon.vertices().iter().map(|&vertex| precise_facing(receiver, vertex, plan.power)).collect();
        let base = facing.iter().position(|&facing| facing > 0.0).unwrap_or(0);
        let corner = |vertex: usize| self.corner(receiver, polygon, plan, vertex, facing[vertex], base);
        let first = corner(0);
        let (mut above, mut start) = (Corners::new(first), first);
        for i in 0..count {
            let j = (i + 1) % count;
            let end = if j == 0 { first } else { corner(j) };
            let e = || offset(polygon.vertices()[j], polygon.vertices()[i], plan.power);
            match (start.facing > 0.0, end.facing > 0.0) {
                (true, true) => above.push(start),
                (true, false) => {
                    above.push(start);
                    above.push(start.towards(&end, e()));
                }
                (false, true) => above.push(end.towards(&start, -e())),
                (false, false) => {}
            }
            start = end;
        }
        above
    }

    fn corner(
        &self,
        receiver: &Receiver,
        polygon: &Polygon,
        plan: &Plan,
        vertex: usize,
        facing: f64,
        base: usize,
    ) -> OutlineCorner {
        let (x, place, first) = (receiver.position(), polygon.vertices()[vertex], polygon.vertices()[base]);
        let from_receiver: Vec3<f64> = offset(place, x, plan.power);
        let local = offset(place, first, plan.power);
        let lit = self.source.at_vertex(vertex, place);
        OutlineCorner { from_receiver, local, facing, facing_error: 8.0 * ROUNDOFF * facing.abs(), lit }
    }

    /// `n1.r` of a vertex that is seen at an offset and a distance, and a bound on its error.
    pub(super) fn facing(&self, receiver: &Receiver, vertex: DVec3, from_receiver: Vec3<f64>, distance: f64) -> (f64, f64) {
        let facing = self.n1.dot(from_receiver);
        if facing < GRAZING * distance {
            let facing = precise_facing(receiver, vertex, self.power);
            (facing, 8.0 * ROUNDOFF * facing.abs())
        } else {
            (facing, 5.0 * ROUNDOFF * distance)
        }
    }
}

impl OutlineCorner {
    /// The point of the edge `e` from here to `end`, below the horizon, where that crosses it.
    fn towards(&self, end: &Self, e: Vec3<f64>) -> Self {
        let fraction = self.facing / (self.facing - end.facing);
        Self {
            from_receiver: self.from_receiver + e * fraction,
            local: self.local + e * fraction,
            facing: 0.0,
            facing_error: 0.0,
            lit: self.lit.towards(&end.lit, fraction),
        }
    }
}

/// `n1.r` of a vertex with a relative error of 8u: two of the height, and five and one of the length of the normal as given.
fn precise_facing(receiver: &Receiver, vertex: DVec3, power: f64) -> f64 {
    let height: f64 = height_over_horizon(receiver, vertex, power);
    height / Vec3::from(receiver.direction()).norm()
}
