//! Where to cut a pair of cells whose sight is neither free nor blocked.
//!
//! The plane through an edge of a screen and a corner of one cell cuts the other where a shadow's edge lies, seen from that corner. Of
//! all corners the outermost leaves a part on which nothing of that edge's shadow falls, the innermost one that is wholly within the
//! edge. Where such a cut decides much, it is made. Else the penumbra is as wide as the cells, and the one is halved whose extent
//! moves the shadows most.

use radgrad_core::DVec3;

use super::cell::{Cell, Plane};
use crate::extremes::{largest as larger, smallest as smaller};
use crate::factors::screen::{Screen, Sides, Undecided};

/// A cut of one of the two cells.
#[derive(Debug, Clone)]
pub(super) struct Division {
    /// Which.
    pub(super) cell: usize,
    /// Heights of its corners over the cutting plane, if there is one.
    pub(super) heights: Option<Vec<f64>>,
    /// The direction to halve it in, if not.
    pub(super) across: DVec3,
}

/// Share of a cell that a cut has to decide.
const ENOUGH: f64 = 0.25;

/// What a part is worth that is clear of one screen of several.
const CLEAR_OF_ONE: f64 = 0.6;

/// Size over distance and the other's size from which a cell is halved before all else.
const SPREAD: f64 = 3.0;

/// What a cut along the plane of a screen is worth at least, where it cuts this share off: on either side edges say what the screen hides. They
/// say little between near cells.
const PARTING: f64 = 0.6;
const MORE_THAN_SLIVER: f64 = 0.02;
const MORE_IF_NEAR: f64 = 0.15;

/// A cut along the edge of a shadow, and the share that it decides.
struct Candidate {
    cell: usize,
    heights: Vec<f64>,
    worth: f64,
}

/// The part that a cut is made for.
#[derive(Debug, Clone, Copy)]
enum Wanted {
    Below,
    Above,
}

/// Share of the reach by which cuts are made inside of where they would be, so that rounding leaves no doubt of the part wanted.
const ASIDE: f64 = 1e-8;

fn aside(heights: &[f64], wanted: Wanted) -> Vec<f64> {
    let [low, high] = range(heights.iter().copied());
    let shift = ASIDE * (high - low);
    let by = match wanted {
        Wanted::Below => shift,
        Wanted::Above => -shift,
    };
    heights.iter().map(|height| height + by).collect()
}

/// The best cut of a pair. `is_far` says that edges alone leave something undecided, and not the nearness of the cells.
pub(super) fn division(cells: [&Cell; 2], planes: [&Plane; 2], screens: &[(&Screen, Undecided)], is_far: bool) -> Division {
    let mut best: Option<Candidate> = None;
    let axes = [0, 1].map(|k| cells[k].axes(planes[k]));
    if let Some((cell, across)) = spread(cells, &axes) {
        return Division { cell, heights: None, across };
    }
    let mut variation = [[0.0; 2]; 2];
    let clear = if screens.len() == 1 { 1.0 } else { CLEAR_OF_ONE };
    let mut offer = |cell: usize, heights: &dyn Fn() -> Vec<f64>, worth: f64| {
        if worth > ENOUGH && best.as_ref().is_none_or(|best| worth > best.worth) {
            best = Some(Candidate { cell, heights: heights(), worth });
        }
    };
    let mut turns = Vec::new();
    for &(screen, open) in screens {
        let sides = cells.map(|cell| screen.sides(&cell.points));
        let is_split = |side: Sides| side.front && side.behind;
        if sides.iter().any(|&side| is_split(side)) {
            // The part of a cell on the other's side of the screen's plane is clear of the screen: cut there.
            for k in 0..2 {
                if is_split(sides[k]) {
                    // Corners of a cut are in the plane up to rounding, and count as in it: neither part has a sliver beyond.
                    let heights: Vec<f64> = cells[k].points.iter().map(|&p| screen.height(p)).collect();
                    let below = share_below(heights.iter().copied());
                    let worth = match (sides[1 - k].front, sides[1 - k].behind) {
                        (true, false) => 1.0 - below,
                        (false, true) => below,
                        _ => 0.5,
                    };
                    let is_parting = smaller(below, 1.0 - below) > if is_far { MORE_THAN_SLIVER } else { MORE_IF_NEAR };
                    offer(k, &|| heights.clone(), larger(clear * worth, if is_parting { PARTING } else { 0.0 }));
                }
            }
            continue;
        }
        let sign = if sides[0].front || sides[1].behind { 1.0 } else { -1.0 };
        examine(screen.undecided(open.in_order()), cells, sign, clear, &axes, &mut turns, &mut offer, &mut variation);
    }
    if let Some(Candidate { cell, heights, .. }) = best {
        let longest = if cells[cell].extent(axes[cell][0]) >= cells[cell].extent(axes[cell][1]) { 0 } else { 1 };
        return Division { cell, heights: Some(heights), across: axes[cell][longest] };
    }
    if variation == [[0.0; 2]; 2] {
        variation = [0, 1].map(|k| axes[k].map(|axis| cells[k].extent(axis)));
    }
    let (mut cell, mut axis) = (0, 0);
    for (k, a) in [(0, 1), (1, 0), (1, 1)] {
        if variation[k][a] > variation[cell][axis] {
            (cell, axis) = (k, a);
        }
    }
    Division { cell, heights: None, across: axes[cell][axis] }
}

/// A cell that is large for where it is seen from, and its longest direction: most of it hardly counts, and shares of it say nothing.
fn spread(cells: [&Cell; 2], axes: &[[DVec3; 2]; 2]) -> Option<(usize, DVec3)> {
    let longest = [0, 1].map(|k| {
        let [along, across] = axes[k].map(|axis| (cells[k].extent(axis), axis));
        if along.0 >= across.0 { along } else { across }
    });
    (0..2).find_map(|k| {
        let away = cells[k].away(cells[1 - k].centre());
        (longest[k].0 > SPREAD * (longest[1 - k].0 + away)).then_some((k, longest[k].1))
    })
}

/// A line of T: its values at the corners of one cell, seen from a corner of the other.
#[derive(Debug, Clone, Copy, Default)]
struct Line {
    /// The corner that looks.
    corner: usize,
    /// Share of the cell that is outside the edge.
    outside: f64,
}

/// The cuts along edges of a screen that parts the two cells, those that are not decided, and how their extents move its shadow.
#[expect(clippy::too_many_arguments, reason = "what is looked at, and three things that are added to")]
fn examine(
    edges: impl Iterator<Item = [DVec3; 2]>,
    cells: [&Cell; 2],
    sign: f64,
    clear: f64,
    axes: &[[DVec3; 2]; 2],
    turns: &mut Vec<f64>,
    offer: &mut impl FnMut(usize, &dyn Fn() -> Vec<f64>, f64),
    variation: &mut [[f64; 2]; 2],
) {
    let [a, b] = cells.map(|cell| &cell.points);
    let centres = cells.map(Cell::centre);
    // T, positive inside.
    let turn = |[from, to]: [DVec3; 2], x: DVec3, y: DVec3| sign * (y - x).dot((to - x).cross(from - x));
    // Its values at the corners of cell k, seen from a corner of the other.
    let line = |k: usize, edge: [DVec3; 2], corner: usize| -> Vec<f64> {
        if k == 1 {
            b.iter().map(|&y| turn(edge, a[corner], y)).collect()
        } else {
            a.iter().map(|&x| turn(edge, x, b[corner])).collect()
        }
    };
    // For each cell, of all edges: the product of the shares inside, and the line with the most outside.
    let mut hidden = [1.0; 2];
    let mut widest: [Option<([DVec3; 2], Line)>; 2] = [None; 2];
    for edge in edges {
        let [from, to] = edge;
        turns.clear();
        for &x in a {
            let normal = (to - x).cross(from - x);
            turns.extend(b.iter().map(|&y| sign * (y - x).dot(normal)));
        }
        let (columns, turns) = (b.len(), &*turns);
        let extremes = |count: usize, share: &dyn Fn(usize) -> f64| {
            let mut found: Option<[Line; 2]> = None;
            for line in (0..count).map(|corner| Line { corner, outside: share(corner) }) {
                let [least, most] = found.unwrap_or([line; 2]);
                let least = if line.outside < least.outside { line } else { least };
                found = Some([least, if line.outside > most.outside { line } else { most }]);
            }
            found.unwrap_or_default()
        };
        let row = |i: usize| share_below(turns[i * columns..(i + 1) * columns].iter().copied());
        let column = |j: usize| share_below(turns.iter().skip(j).step_by(columns).copied());
        let lines = [extremes(b.len(), &column), extremes(a.len(), &row)];
        for k in [1, 0] {
            let [lit, _] = lines[k];
            offer(k, &|| aside(&line(k, edge, lit.corner), Wanted::Below), clear * lit.outside);
        }
        let largest = turns.iter().map(|t| t.abs()).fold(0.0, larger);
        // The share that is in the penumbra of this edge.
        let penumbra = lines.iter().map(|[lit, inside]| inside.outside - lit.outside).fold(0.0, larger);
        if penumbra > 0.0 && largest > 0.0 {
            let gradients = [0, 1].map(|k| (from - centres[1 - k]).cross(to - centres[1 - k]) / largest);
            for k in 0..2 {
                for axis in 0..2 {
                    variation[k][axis] += penumbra * gradients[k].dot(axes[k][axis]).abs() * cells[k].extent(axes[k][axis]);
                }
            }
        }
        for k in 0..2 {
            let [_, inside] = lines[k];
            hidden[k] *= 1.0 - inside.outside;
            if inside.outside > 0.0 && widest[k].is_none_or(|(_, widest)| inside.outside > widest.outside) {
                widest[k] = Some((edge, inside));
            }
        }
    }
    for k in 0..2 {
        if let Some((edge, inside)) = widest[k] {
            offer(k, &|| aside(&line(k, edge, inside.corner), Wanted::Above), hidden[k]);
        }
    }
}

/// Share of the reach over which an affine function is negative.
fn share_below(heights: impl Iterator<Item = f64>) -> f64 {
    let [low, high] = range(heights);
    if low >= 0.0 {
        0.0
    } else if high <= 0.0 {
        1.0
    } else {
        -low / (high - low)
    }
}

fn range(heights: impl Iterator<Item = f64>) -> [f64; 2] {
    heights.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], height| [smaller(low, height), larger(high, height)])
}
