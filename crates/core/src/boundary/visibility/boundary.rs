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
use crate::boundary::visibility::part::{Facing, PartCorner, Sides, VisiblePart, pairs};

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
struct End<'a, P> {
    side: usize,
    count: i32,
    point: &'a P,
    /// A function of its place that increases along the side.
    place: f64,
}

/// The arcs of the boundary.
pub(super) fn arcs<T: Real>(parts: &[VisiblePart<T>], sides: &Sides<T>) -> Vec<Arc<T>> {
    if let [part] = parts {
        return part.arcs(sides).collect();
    }
    let mut arcs = Vec::new();
    visit_several(parts, sides, |arc, _| arcs.push(arc));
    arcs
}

/// The arcs of the boundary, each with the line of the input that it is on.
pub(super) fn arcs_with_origins<T: Real>(parts: &[VisiblePart<T>], sides: &Sides<T>) -> Vec<(Arc<T>, Origin)> {
    if let [part] = parts {
        return part.arcs(sides).zip(part.corners.iter().map(|corner| sides.origin(corner.side))).collect();
    }
    let mut arcs = Vec::new();
    visit_several(parts, sides, |arc, facing| arcs.push((arc, sides.origin(facing))));
    arcs
}

fn visit_several<T: Real>(parts: &[VisiblePart<T>], sides: &Sides<T>, mut visit: impl FnMut(Arc<T>, Facing)) {
    let outlines: Vec<_> = parts.iter().map(|part| &*part.corners).collect();
    let normal = |side: usize| sides.normal(Facing::forward(side)).map(T::value);
    visit_joined(
        &outlines,
        normal,
        |point| point.map(T::value),
        |from, to, facing| visit(Arc::between(Sighted::new(*from), Sighted::new(*to), sides.generator(facing)), facing),
    );
}

/// Calls `visit` with the ends and the side of each arc, given the normals of the sides and the points in doubles.
pub(super) fn visit_joined<P>(
    outlines: &[&[PartCorner<P>]],
    normal: impl Fn(usize) -> Vec3<f64>,
    place: impl Fn(&P) -> Vec3<f64>,
    mut visit: impl FnMut(&P, &P, Facing),
) {
    let points: Several<&P> = outlines.iter().flat_map(|corners| pairs(corners).map(|(_, b)| &b.point)).collect();
    let sides = outlines.iter().flat_map(|corners| pairs(corners).map(|(a, b)| [a.side.side, b.side.side]));
    let turn = |(point, [from, to]): (usize, [usize; 2])| Turn { sides: [from.min(to), from.max(to)], is_back: from > to, point };
    let mut turns: Several<Turn> = sides.enumerate().map(turn).collect();
    turns.sort_unstable();
    let mut ends: Several<End<'_, P>> = Several::new();
    for alike in turns.chunk_by(|a, b| a.sides == b.sides) {
        // Those that pass the other way are last.
        let one_way = alike.iter().filter(|turn| !turn.is_back).count();
        let other_way = alike.len() - one_way;
        let unpaired = if one_way >= other_way { &alike[other_way..one_way] } else { &alike[2 * one_way..] };
        for turn in unpaired {
            let [from, to] = if turn.is_back { [turn.sides[1], turn.sides[0]] } else { turn.sides };
            ends.push(End { side: from, count: -1, point: points[turn.point], place: 0.0 });
            ends.push(End { side: to, count: 1, point: points[turn.point], place: 0.0 });
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
