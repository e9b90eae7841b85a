//! The boundary of all parts together. The seams between them fall away by construction, not by rounding.
//!
//! At a corner the boundary of a part passes from one side to the next: an arc ends on the one, and one begins on the other. Two
//! sides are seen to cross in one direction, so a corner from a to b and one from b to a are at one point and cancel on both.
//! Left on a side are the ends of the arcs in which it bounds the visible region: none, on a seam. An integral over an arc is a
//! difference of its values at the ends, so that sorting them along the side only serves to have few and short arcs.

use radgrad_numbers::real::Real;
use radgrad_numbers::vec3::Vec3;
use smallvec::SmallVec;

use crate::boundary::arc::Arc;
use crate::boundary::line::Sighted;
use crate::boundary::origin::Origin;
use crate::boundary::visibility::part::{Facing, Sides, VisiblePart, pairs};

/// As many corners as a triangle with one shadow in it leaves need no memory of their own.
type Several<T> = SmallVec<[T; 16]>;

/// Where a boundary passes from a side to another.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Turn {
    /// The sides in ascending order.
    sides: [usize; 2],
    /// Whether it passes from the second to the first.
    is_back: bool,
    /// The number of its point.
    point: usize,
}

/// Where on a side an arc begins, counted 1, or ends, counted -1.
struct End {
    side: usize,
    count: i32,
    /// The number of its point.
    point: usize,
    /// A function of its place that increases along the side.
    place: f64,
}

/// The arcs of the boundary.
pub(super) fn arcs<T: Real>(parts: &[VisiblePart<T>], sides: &Sides<T>) -> Vec<Arc<T>> {
    if let [part] = parts {
        return part.arcs(sides).collect();
    }
    let mut arcs = Vec::new();
    visit_several(parts, sides, &mut |arc, _| arcs.push(arc));
    arcs
}

/// The arcs of the boundary, each with the line of the input that it is on.
pub(super) fn arcs_with_origins<T: Real>(parts: &[VisiblePart<T>], sides: &Sides<T>) -> Vec<(Arc<T>, Origin)> {
    if let [part] = parts {
        return part.arcs(sides).zip(part.corners.iter().map(|corner| sides.origin(corner.side))).collect();
    }
    let mut arcs = Vec::new();
    visit_several(parts, sides, &mut |arc, facing| arcs.push((arc, sides.origin(facing))));
    arcs
}

fn visit_several<T: Real>(parts: &[VisiblePart<T>], sides: &Sides<T>, visit: &mut dyn FnMut(Arc<T>, Facing)) {
    let corners = || parts.iter().flat_map(|part| pairs(&part.corners));
    let points: Several<_> = corners().map(|(_, b)| b.point).collect();
    let turns: Several<[usize; 2]> = corners().map(|(a, b)| [a.side.side, b.side.side]).collect();
    visit_joined(
        &turns,
        &|side| sides.normal(Facing::forward(side)).map(T::value),
        &|point| points[point].map(T::value),
        &mut |from, to, facing| {
            visit(Arc::between(Sighted::new(points[from]), Sighted::new(points[to]), sides.generator(facing)), facing);
        },
    );
}

/// Calls `visit` with the points of both ends and the side of each arc, given at each point the sides from and to which the boundary
/// passes, the normals of the sides, and the points in doubles. Compiled once, for whatever precision.
fn visit_joined(
    turns: &[[usize; 2]],
    normal: &dyn Fn(usize) -> Vec3<f64>,
    place: &dyn Fn(usize) -> Vec3<f64>,
    visit: &mut dyn FnMut(usize, usize, Facing),
) {
    let turn =
        |(point, [from, to]): (usize, &[usize; 2])| Turn { sides: [*from.min(to), *from.max(to)], is_back: from > to, point };
    let mut turns: Several<Turn> = turns.iter().enumerate().map(turn).collect();
    turns.sort_unstable();
    let mut ends: Several<End> = Several::new();
    for alike in turns.chunk_by(|a, b| a.sides == b.sides) {
        // Those that pass the other way are last.
        let one_way = alike.iter().filter(|turn| !turn.is_back).count();
        let other_way = alike.len() - one_way;
        let unpaired = if one_way >= other_way { &alike[other_way..one_way] } else { &alike[2 * one_way..] };
        for turn in unpaired {
            let [from, to] = if turn.is_back { [turn.sides[1], turn.sides[0]] } else { turn.sides };
            ends.push(End { side: from, count: -1, point: turn.point, place: 0.0 });
            ends.push(End { side: to, count: 1, point: turn.point, place: 0.0 });
        }
    }
    ends.sort_by_key(|end| end.side);
    for on_side in ends.chunk_by_mut(|a, b| a.side == b.side) {
        let facing = Facing::forward(on_side[0].side);
        let (normal, first) = (normal(facing.side), place(on_side[0].point));
        for end in &mut *on_side {
            let point = place(end.point);
            end.place = turned(normal.dot(first.cross(point)), first.dot(point));
        }
        on_side.sort_by(|a, b| a.place.total_cmp(&b.place));
        let mut count = 0;
        for pair in on_side.windows(2) {
            count += pair[0].count;
            let (from, to, facing) =
                if count > 0 { (&pair[0], &pair[1], facing) } else { (&pair[1], &pair[0], facing.reversed()) };
            for _ in 0..i32::abs(count) {
                visit(from.point, to.point, facing);
            }
        }
    }
}

/// A function that increases with the angle of the point (x, y), in (-pi, pi].
fn turned(y: f64, x: f64) -> f64 {
    let share = y / (y.abs() + x.abs());
    if x < 0.0 { 2f64.copysign(y) - share } else { share }
}
