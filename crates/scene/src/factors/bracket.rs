//! A proven bracket of what two faces exchange past others.
//!
//! Both faces are cut into convex cells, and a pair of cells is
//! - seen, where no screen hides anything of one from the other ([`Screen::between`]): it exchanges all of it;
//! - hidden, where one screen hides all;
//! - mixed, else: it exchanges between nothing and all.
//!
//! So what the two exchange is at least what seen pairs do, and at most what the faces would with nothing in between less what hidden
//! pairs would. The mixed pair that exchanges most, by a guess that enters no bound, is cut next ([`division`]): along the edge of a
//! shadow where that decides much of it, else in half. Cuts leave the width of penumbras undecided, which halving narrows; of n pairs
//! the width falls like 1/n where shadows' edges are parallel, like `n^(-1/2)` else.
//!
//! A corner made by a cut is off the edge that it is on by rounding, 4 eps of coordinates up to 1, and may be merged with another as near
//! as that; so the parts are off the whole by that times the perimeter, an area that exchanges at most itself; [`Screen::leak`] adds what displaced edges let pass.

mod cell;
mod division;

use std::cmp::Ordering;
use std::collections::BinaryHeap;

use radgrad_core::Polygon;

use self::cell::{Cell, NEAR, Plane};
use self::division::division;
use super::exchange::{Exchange, exchange_parts};
use super::rule::patches;
use super::screen::{Screen, Sight, perimeter};

/// Truncation that is allowed of a cell's exchange, over that of the whole: it is for a bracket.
const TRUNCATION: f64 = 1e-9;

/// Two faces and what may hide one from the other, all in the same unit, with coordinates up to 1.
pub(super) struct Between<'a> {
    pub(super) polygons: [&'a Polygon; 2],
    /// Their coordinates are multiplied by this power of two.
    pub(super) power: f64,
    pub(super) screens: Vec<&'a Screen>,
    /// What they exchange with nothing in between, in the polygons' unit.
    pub(super) free: Exchange,
}

/// What two faces exchange at least and at most.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Bracket {
    pub(super) least: f64,
    pub(super) most: f64,
}

impl Bracket {
    /// What both allow.
    pub(super) const fn and(self, other: Self) -> Self {
        Self { least: self.least.max(other.least), most: self.most.min(other.most) }
    }

    pub(super) const fn width(self) -> f64 {
        self.most - self.least
    }
}

/// A pair that is neither seen nor hidden, as far as is known.
struct Mixed {
    cells: [Cell; 2],
    /// Those of the screens that hide something.
    screens: Vec<u32>,
    guess: f64,
}

/// What has been found.
#[derive(Default)]
struct Found {
    seen: Exchange,
    hidden: Exchange,
    open: BinaryHeap<Mixed>,
    /// Whether a pair was given up.
    is_incomplete: bool,
    /// Bound on what cuts moved.
    moved: f64,
    /// Screens whose edges were displaced.
    displaced: Vec<u32>,
}

impl Between<'_> {
    /// The bracket, narrowed to `width`, in the polygons' unit of area, if `most_pairs` do.
    pub(super) fn bracket(&self, width: f64, most_pairs: usize) -> Bracket {
        let square = self.power * self.power;
        let free = Exchange { area: self.free.area * square, error: self.free.error * square };
        let planes = self.polygons.map(|polygon| Plane {
            normal: polygon.normal(),
            slope: perimeter(polygon.vertices()) / polygon.area() / self.power,
            defect: polygon.planarity_defect() * self.power,
        });
        let [from, to] = [0, 1].map(|k| self.cells(k, &planes));
        let mut found = Found::default();
        let all: Vec<u32> = (0..u32::try_from(self.screens.len()).unwrap_or(u32::MAX)).collect();
        for a in &from {
            for b in &to {
                self.examine([a.clone(), b.clone()], &planes, &all, &mut found);
            }
        }
        let mut pairs = from.len() * to.len();
        while free.area - found.seen.area - found.hidden.area > width * square && pairs < most_pairs {
            let Some(mixed) = found.open.pop() else { break };
            let screens: Vec<&Screen> = mixed.screens.iter().map(|&k| self.screens[k as usize]).collect();
            let [a, b] = &mixed.cells;
            let division = division([a, b], [&planes[0], &planes[1]], &screens);
            let k = division.cell;
            let (whole, plane) = (&mixed.cells[k], &planes[k]);
            let cut = division.heights.as_ref().map(|heights| whole.cut(heights, plane));
            let is_cut = |parts: &[Option<Cell>; 2]| parts.iter().flatten().all(|part| part.area < whole.area);
            let parts = cut.filter(is_cut).unwrap_or_else(|| whole.halves(division.across, plane));
            found.moved += 2.0 * NEAR * whole.perimeter();
            if !is_cut(&parts) {
                // Too small to be cut.
                found.is_incomplete = true;
                continue;
            }
            let parts = parts.into_iter().flatten();
            for part in parts {
                pairs += 1;
                let cells = if k == 0 { [part, b.clone()] } else { [a.clone(), part] };
                self.examine(cells, &planes, &mixed.screens, &mut found);
            }
        }
        self.sum_up(&found, free, square)
    }

    fn sum_up(&self, found: &Found, free: Exchange, square: f64) -> Bracket {
        let leak: f64 = found.displaced.iter().map(|&k| self.screens[k as usize].leak(1.0)).sum();
        let off = found.moved + leak;
        let least = (found.seen.least() - off).max(0.0);
        let whole = free.most().min(free.most() - found.hidden.least() + off);
        // Where nothing is open, what is seen is all.
        let is_decided = found.open.is_empty() && !found.is_incomplete;
        let most = if is_decided { whole.min(found.seen.most() + off) } else { whole };
        Bracket { least: least / square, most: most.max(least) / square }
    }

    /// The convex parts of a face in front of the other.
    fn cells(&self, k: usize, planes: &[Plane; 2]) -> Vec<Cell> {
        let other = self.polygons[1 - k].vertices()[0] * self.power;
        let normal = planes[1 - k].normal;
        let cell = |points: &[radgrad_core::DVec3]| {
            let whole = Cell::new(points.iter().map(|&p| p * self.power).collect(), &planes[k])?;
            let heights: Vec<f64> = whole.points.iter().map(|&p| normal.dot(p - other)).collect();
            // What is level with the other's plane but for rounding need not be cut.
            let is_in_front = heights.iter().all(|&h| h >= -1e-12);
            if is_in_front { Some(whole) } else { whole.cut(&heights, &planes[k])[1].clone() }
        };
        patches(self.polygons[k].vertices()).iter().filter_map(|patch| cell(patch.outline())).collect()
    }

    fn examine(&self, cells: [Cell; 2], planes: &[Plane; 2], screens: &[u32], found: &mut Found) {
        let outlines = [&cells[0].points[..], &cells[1].points[..]];
        let mut hiding = Vec::new();
        for &k in screens {
            let verdict = self.screens[k as usize].between(outlines, 1.0);
            if verdict.is_displaced && !found.displaced.contains(&k) {
                found.displaced.push(k);
            }
            match verdict.sight {
                Sight::Free => {}
                Sight::Part => hiding.push(k),
                Sight::Blocked => {
                    add(&mut found.hidden, self.exchange(&cells, planes));
                    return;
                }
            }
        }
        if hiding.is_empty() {
            add(&mut found.seen, self.exchange(&cells, planes));
            return;
        }
        let guess = guess(&cells, planes);
        found.open.push(Mixed { cells, screens: hiding, guess });
    }

    fn exchange(&self, [a, b]: &[Cell; 2], planes: &[Plane; 2]) -> Exchange {
        exchange_parts([&a.part(&planes[0]), &b.part(&planes[1])], TRUNCATION)
    }
}

fn add(sum: &mut Exchange, part: Exchange) {
    sum.area += part.area;
    sum.error += part.error + f64::EPSILON * sum.area.abs();
}

/// About what two cells exchange: the kernel between their centres, with the disc's correction for what is near.
fn guess([a, b]: &[Cell; 2], planes: &[Plane; 2]) -> f64 {
    let r = b.centre() - a.centre();
    let square = r.length_squared();
    let cosines = planes[0].normal.dot(r).max(0.0) * -planes[1].normal.dot(r).min(0.0);
    let (large, small) = (a.area.max(b.area), a.area.min(b.area));
    // Cells in contact are seen at any angle.
    let cosines = (cosines / square).max(0.01 * large / (square + large));
    small * large * cosines / (std::f64::consts::PI * square + large)
}

impl PartialEq for Mixed {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for Mixed {}

impl PartialOrd for Mixed {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Mixed {
    fn cmp(&self, other: &Self) -> Ordering {
        self.guess.total_cmp(&other.guess)
    }
}
