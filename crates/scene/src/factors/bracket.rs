//! A proven bracket of what two faces exchange past others.
//!
//! Both faces are cut into convex cells, and a pair of cells is
//! - seen, where no screen hides anything of one from the other ([`Screen::between`]): it exchanges all of it;
//! - hidden, where one screen hides all, or several with common edges do ([`fusion`]);
//! - mixed, else: it exchanges between nothing and all; where one edge alone is between the two, what passes it is known better
//!   ([`edge`], [`nesting`]).
//!
//! So what the two exchange is at least what seen pairs do, and at most what the faces would with nothing in between less what hidden
//! pairs would. The mixed pair that exchanges most, by a guess that enters no bound, is cut next ([`division`]): along the edge of a
//! shadow where that decides much of it, else in half. Cuts leave the width of penumbras undecided, which halving narrows; of n pairs
//! the width falls like 1/n.
//!
//! Of the two parts of a cut pair whose exchange is known, the second one exchanges what the first leaves of it, where that has digits enough.
//!
//! A corner made by a cut is off the edge that it is on by rounding, 4 eps of coordinates up to 1, and may be merged with another as near
//! as that; so the parts are off the whole by that times the perimeter, an area that exchanges at most itself; [`Screen::leak`] adds what displaced edges let pass.

mod cell;
mod division;
mod edge;
mod fusion;
mod nesting;

use std::cmp::Ordering;
use std::collections::BinaryHeap;
use std::rc::Rc;

use radgrad_core::Polygon;

pub(super) use self::cell::Cell;
use self::cell::{NEAR, Plane};
use self::division::division;
pub(super) use self::edge::share_outside;
use self::edge::{Passing, passing};
pub(super) use self::fusion::{Partial, fuse};
use self::nesting::nest;
use super::exchange::areas::Exchange;
use super::exchange::exchange_parts;
use super::rule::patches;
use super::screen::{Cells, Screen, Sight, Undecided};
use crate::extremes::{largest as larger, smallest as smaller};
use crate::occluders::overlap::perimeter;

/// Two faces and what may hide one from the other, with coordinates up to 1.
pub(super) struct TwoFaces<'a> {
    pub(super) polygons: [&'a Polygon; 2],
    pub(super) screens: Vec<&'a Screen>,
    /// Their exchange with nothing in between.
    pub(super) free: Exchange,
    /// Allowed relative error of the exchange of two cells: small for cells that the value sums, larger for those that only
    /// narrow the bracket.
    pub(super) accuracy: f64,
    /// Whether all between nothing and that is narrow enough: then what is known of mixed pairs is not asked for.
    pub(super) is_met: bool,
}

/// Lower and upper bound on the exchange of two faces.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Bracket {
    pub(super) least: f64,
    pub(super) most: f64,
}

impl Bracket {
    pub(super) const fn width(self) -> f64 {
        self.most - self.least
    }

    /// The nearest of what it allows: an estimate beyond an end is refuted.
    pub(super) fn nearest(self, value: f64) -> f64 {
        larger(smaller(value, self.most), self.least)
    }

    /// The distance of the farther end from the nearest value that it allows.
    pub(super) fn error_of(self, value: f64) -> f64 {
        let value = self.nearest(value);
        larger(self.most - value, value - self.least)
    }
}

/// A pair that is neither seen nor hidden, as far as is known.
pub(super) struct Mixed {
    pub(super) cells: [Rc<Cell>; 2],
    /// Those of the screens that hide something.
    pub(super) screens: Vec<Hider>,
    /// What of it is known all the same.
    passing: Passing,
    /// Their exchange with nothing in between, if the cells are far enough apart for that.
    whole: Option<Exchange>,
    guess: f64,
}

/// A screen by its number, and those of its edges that a segment between two cells may pass outside.
#[derive(Debug, Clone, Copy)]
pub(super) struct Hider {
    pub(super) screen: u32,
    pub(super) open: Undecided,
}

/// A search for what two faces exchange, which can be stopped and taken up again.
pub(super) struct Search<'a> {
    between: TwoFaces<'a>,
    planes: [Plane; 2],
    seen: Exchange,
    hidden: Exchange,
    /// Sum of the parts of mixed pairs that are proven seen and proven hidden.
    passing: Passing,
    open: BinaryHeap<Box<Mixed>>,
    /// Pairs too small to be cut.
    stuck: Vec<Mixed>,
    /// Bound on the area that cuts moved.
    moved: f64,
    /// Screens whose edges were displaced.
    displaced: Vec<u32>,
    /// Pairs examined.
    pairs: usize,
}

impl<'a> Search<'a> {
    /// The faces as they are, if convex, else their convex parts. Of each screen it is given what is known of its edges between the two.
    pub(super) fn new(between: TwoFaces<'a>, hiders: &[Hider]) -> Self {
        let planes = between.polygons.map(|polygon| Plane {
            normal: polygon.normal(),
            slope: perimeter(polygon.vertices()) / polygon.area(),
            defect: polygon.planarity_defect(),
        });
        let [from, to] = [0, 1].map(|k| between.cells(k, &planes).into_iter().map(Rc::new).collect::<Vec<_>>());
        let (seen, hidden) = (Exchange::default(), Exchange::default());
        let (open, stuck, displaced) = (BinaryHeap::new(), Vec::new(), Vec::new());
        let passing = Passing::default();
        let mut search = Self { between, planes, seen, hidden, passing, open, stuck, moved: 0.0, displaced, pairs: 0 };
        // What is known of edges between two faces is so of the faces as a whole.
        let are_whole = from.len() == 1 && to.len() == 1;
        for a in &from {
            for b in &to {
                search.examine([Rc::clone(a), Rc::clone(b)], (hiders, are_whole), None);
            }
        }
        search
    }

    /// From here on pairs serve the bracket alone.
    pub(super) const fn only_bracket(&mut self, accuracy: f64) {
        self.between.accuracy = accuracy;
    }

    /// The screens that may be between the faces.
    pub(super) fn screens(&self) -> &[&'a Screen] {
        &self.between.screens
    }

    /// Cuts pairs until the bracket is narrow enough or there are `most_pairs`.
    pub(super) fn narrow(&mut self, is_enough: impl Fn(Bracket) -> bool, most_pairs: usize) {
        while self.pairs < most_pairs && !is_enough(self.bracket()) {
            let Some(mixed) = self.open.pop() else { break };
            self.passing.seen -= mixed.passing.seen;
            self.passing.hidden -= mixed.passing.hidden;
            let screens = mixed.screens.iter().map(|hider| (self.between.screens[hider.screen as usize], hider.open));
            let screens: Vec<(&Screen, Undecided)> = screens.collect();
            let [a, b] = &mixed.cells;
            let division = division([a, b], [&self.planes[0], &self.planes[1]], &screens, mixed.whole.is_some());
            let k = division.cell;
            let (whole, plane) = (&mixed.cells[k], &self.planes[k]);
            let cut = division.heights.as_ref().map(|heights| whole.cut(heights, plane));
            let is_cut = |parts: &[Option<Cell>; 2]| parts.iter().flatten().all(|part| part.area < whole.area);
            let parts = cut.filter(is_cut).unwrap_or_else(|| whole.halves(division.across, plane));
            // The part that the cut moves exchanges at most its area.
            let moved = 2.0 * NEAR * whole.perimeter();
            self.moved += moved;
            if !is_cut(&parts) {
                self.passing.seen += mixed.passing.seen;
                self.passing.hidden += mixed.passing.hidden;
                self.stuck.push(*mixed);
                continue;
            }
            let mut rest = None;
            for part in parts.into_iter().flatten() {
                let part = Rc::new(part);
                let cells = if k == 0 { [part, Rc::clone(b)] } else { [Rc::clone(a), part] };
                let found = self.examine(cells, (&mixed.screens, false), rest);
                rest = mixed.whole.zip(found).map(|(whole, part)| whole.without(part, moved));
            }
        }
    }

    /// The bracket that the pairs examined so far prove.
    pub(super) fn bracket(&self) -> Bracket {
        let leak: f64 = self.displaced.iter().map(|&k| self.between.screens[k as usize].leak(1.0)).sum();
        let free = self.between.free;
        // Each pair adds to the sums over mixed pairs once, and leaves them once.
        let off = self.moved + leak + 4.0 * f64::EPSILON * self.pairs as f64 * free.most();
        let least = larger(self.seen.least() + self.passing.seen - off, 0.0);
        let whole = smaller(free.most(), free.most() - self.hidden.least() - self.passing.hidden + off);
        // Where no pair is open, the pairs that are seen make the whole exchange.
        let is_decided = self.open.is_empty() && self.stuck.is_empty();
        // Nothing was seen, cut or displaced.
        let is_all_hidden = is_decided && self.seen == Exchange::default() && self.moved == 0.0 && leak == 0.0;
        if is_all_hidden {
            return Bracket { least: 0.0, most: 0.0 };
        }
        let most = if is_decided { smaller(whole, self.seen.most() + off) } else { whole };
        Bracket { least, most: larger(most, least) }
    }

    /// The exchange of the pairs that are surely seen.
    pub(super) const fn seen(&self) -> f64 {
        self.seen.area
    }

    /// The pairs that are neither seen nor hidden.
    pub(super) fn undecided(&self) -> impl Iterator<Item = &Mixed> {
        self.open.iter().map(|mixed| &**mixed).chain(&self.stuck)
    }

    /// Decides whether a pair is seen, hidden or mixed, counts it as that, and returns the exchange of its cells if that was computed. `rest` is
    /// this exchange as far as their parents' says it. Of the screens that part the two, the edges that are given may be those of these cells.
    fn examine(
        &mut self,
        cells: [Rc<Cell>; 2],
        (screens, are_known): (&[Hider], bool),
        rest: Option<Exchange>,
    ) -> Option<Exchange> {
        let whole = || {
            let is_enough = |rest: &Exchange| rest.error <= self.between.accuracy * rest.area;
            rest.filter(is_enough).unwrap_or_else(|| self.between.exchange(&cells, &self.planes))
        };
        self.pairs += 1;
        let outlines = Cells::new([&cells[0].points, &cells[1].points]);
        let (mut partials, mut hiding) = (Vec::new(), Vec::new());
        for &Hider { screen: k, open } in screens {
            let screen = self.between.screens[k as usize];
            if are_known && open.is_parting() {
                partials.push(Partial { screen, name: k, open });
                continue;
            }
            let verdict = screen.between(&outlines, 1.0, open);
            if verdict.is_displaced && !self.displaced.contains(&k) {
                self.displaced.push(k);
            }
            match (verdict.sight, verdict.edges) {
                (Sight::Free, _) => {}
                (Sight::Part, Some(open)) => partials.push(Partial { screen, name: k, open }),
                (Sight::Part, None) => hiding.push(Hider { screen: k, open }),
                (Sight::Blocked, _) => {
                    return Some(add(&mut self.hidden, whole()));
                }
            }
        }
        let fused = fuse(&partials, [cells[0].centre(), cells[1].centre()]);
        if fused.is_all_hidden {
            return Some(add(&mut self.hidden, whole()));
        }
        let is_all = hiding.is_empty();
        let ([a, b], [first, second]) = (&cells, &self.planes);
        let (shadows, members) = nest(fused.groups, [a, b]);
        hiding.extend(members.iter().map(|&k| Hider { screen: partials[k].name, open: partials[k].open }));
        if hiding.is_empty() {
            return Some(add(&mut self.seen, whole()));
        }
        hiding.sort_unstable_by_key(|hider| hider.screen);
        let is_met = self.between.is_met;
        let found = if is_met { None } else { passing([a, b], [first, second], &shadows, is_all, whole) };
        let (known, guess) = match found {
            Some((known, whole)) => (known, larger(whole.most() - known.seen - known.hidden, 0.0)),
            None => (Passing::default(), guess(&cells, &self.planes)),
        };
        self.passing.seen += known.seen;
        self.passing.hidden += known.hidden;
        let whole = found.map(|(_, whole)| whole);
        self.open.push(Box::new(Mixed { cells, screens: hiding, passing: known, whole, guess }));
        whole
    }
}

impl TwoFaces<'_> {
    fn exchange(&self, [a, b]: &[Rc<Cell>; 2], planes: &[Plane; 2]) -> Exchange {
        exchange_parts([&a.part(&planes[0]), &b.part(&planes[1])], self.accuracy)
    }

    /// The convex parts of a face in front of the other.
    fn cells(&self, k: usize, planes: &[Plane; 2]) -> Vec<Cell> {
        let other = self.polygons[1 - k].vertices()[0];
        let normal = planes[1 - k].normal;
        let cell = |points: &[radgrad_core::DVec3]| {
            let whole = Cell::new(points.to_vec(), &planes[k])?;
            let heights: Vec<f64> = whole.points.iter().map(|&p| normal.dot(p - other)).collect();
            // A corner level with the other's plane up to rounding needs no cut.
            let is_in_front = heights.iter().all(|&h| h >= -1e-12);
            if is_in_front { Some(whole) } else { whole.cut(&heights, &planes[k])[1].clone() }
        };
        patches(self.polygons[k].vertices()).iter().filter_map(|patch| cell(patch.outline())).collect()
    }
}

/// Adds a part to a sum, and gives it back.
fn add(sum: &mut Exchange, part: Exchange) -> Exchange {
    sum.area += part.area;
    sum.error += part.error + f64::EPSILON * sum.area.abs();
    part
}

/// Rough exchange of two cells: the kernel between their centres, with a disc's correction for near ones. It only ranks pairs.
fn guess([a, b]: &[Rc<Cell>; 2], planes: &[Plane; 2]) -> f64 {
    let r = b.centre() - a.centre();
    let square = r.length_squared();
    let cosines = larger(planes[0].normal.dot(r), 0.0) * -smaller(planes[1].normal.dot(r), 0.0);
    let (large, small) = (larger(a.area, b.area), smaller(a.area, b.area));
    // Cells in contact are seen at any angle.
    let least = 0.01 * large / (square + large);
    let cosines = if square > 0.0 { larger(cosines / square, least) } else { least };
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
