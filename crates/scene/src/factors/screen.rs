//! The sight that one convex screen leaves between two convex cells: all, nothing, or a part.
//!
//! Let x be a corner of one cell, in front of the screen's plane, and y one of the other, behind it. The segment from x to y crosses the
//! plane at z, and for an edge a b of the screen
//!
//! `T(x, y) = (y - x).((b - x) x (a - x)) = |b - a| H(x, y) h(z)`,
//!
//! with H the sum of the heights of x and y over and under the plane and h(z) the distance of z inside the edge's line. T is affine in x
//! and in y. So if T <= 0 at every pair of corners for one edge, every segment between the cells passes outside that edge, and the screen
//! hides nothing; if T >= 0 at every pair for every edge, every segment meets the screen, and it hides all. Zeros decide nothing: they are
//! pairs of no measure. The same holds where cells touch the screen's plane, for then almost all of their points do not.
//!
//! Signs within rounding are exact ones (J. R. Shewchuk 1997, crate `robust`), but for those that displacing the edge by [`Screen::slack`],
//! a few roundings of the coordinates, would change: a cell's corner computed to lie on an edge lies there only so well. Those count as
//! zero; but four points with a coordinate in common are in one plane exactly, three with two in one line, and an edge and a segment along one axis
//! are parallel, so that T is 0 and no edge is displaced. The exchange that passes between the edge and the displaced edge is at most the area of that strip, [`Screen::leak`],
//! since two cells exchange through an aperture no more than its area. A point level with the screen's plane up to the rounding
//! of coordinates is in it, as in [`crate::Beam::from_polygon`].

use std::cell::OnceCell;

use radgrad_core::{DVec3, Polygon};
use robust::{Coord3D, orient3d};

use super::rule::{middle, patches};
use crate::extremes::{largest as larger, smallest as smaller};
use crate::occluders::half_space::Level;
use crate::occluders::overlap::perimeter;
use crate::projection::normalising_power;

/// Corners up to which a cell is looked at.
pub(super) const MOST_CORNERS: usize = 16;

/// A triangle or a convex quadrilateral that hides the faces behind it.
#[derive(Debug, Clone)]
pub(super) struct Screen {
    outline: Vec<DVec3>,
    normal: DVec3,
    perimeter: f64,
    /// Largest coordinate.
    largest: f64,
    level: Level,
    /// Distance by which vertices are off the plane.
    defect: f64,
    low: DVec3,
    high: DVec3,
}

/// How much of the sight between two cells a screen leaves, ascending in what it hides.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Sight {
    /// All.
    Free,
    /// Some, or not known.
    Part,
    /// Nothing.
    Blocked,
}

/// Which sides of a screen's plane have points: in front, behind.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Sides {
    pub(super) front: bool,
    pub(super) behind: bool,
}

/// The sign of T, where it is known.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Passing {
    Outside,
    On,
    Inside,
}

/// A sight, and whether an edge was displaced for it.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Verdict {
    pub(super) sight: Sight,
    pub(super) is_displaced: bool,
    /// The edges that some segments pass outside and some inside, if a part is left and all are inside the others. Not known where a
    /// cell is on both sides of the screen.
    pub(super) edges: Option<Undecided>,
}

/// Some edges of a screen.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Undecided {
    /// One bit each.
    edges: u8,
    /// Whether the first cell is in front of the screen.
    is_first_in_front: bool,
    /// Whether the cells are known to be on sides of their own of the screen.
    is_parting: bool,
}

impl Undecided {
    /// All edges of a screen that nothing is known of.
    pub(super) const ALL: Self = Self { edges: u8::MAX, is_first_in_front: true, is_parting: false };

    /// The same, counter-clockwise seen from the front.
    pub(super) const fn in_order(self) -> Self {
        Self { is_first_in_front: true, ..self }
    }

    /// Whether the cells are on sides of their own of the screen.
    pub(super) const fn is_parting(self) -> bool {
        self.is_parting
    }

    /// How many they are.
    pub(super) const fn count(self) -> u32 {
        self.edges.count_ones()
    }

    const fn has(self, edge: usize) -> bool {
        self.edges >> edge & 1 == 1
    }
}

impl Verdict {
    const fn exact(sight: Sight) -> Self {
        Self { sight, is_displaced: false, edges: None }
    }
}

impl Screen {
    /// The convex screens that a polygon is made of.
    pub(super) fn all_of(polygon: &Polygon) -> Vec<Self> {
        let screen = |outline: &[DVec3]| {
            let outline = outline.to_vec();
            let perimeter = perimeter(&outline);
            let largest = outline.iter().map(|v| v.abs().max_element()).fold(0.0, larger);
            Self {
                normal: polygon.normal(),
                perimeter,
                level: Level::new(largest, perimeter / area(&outline, polygon.normal())),
                largest,
                defect: polygon.planarity_defect(),
                low: outline.iter().copied().fold(DVec3::INFINITY, DVec3::min),
                high: outline.iter().copied().fold(DVec3::NEG_INFINITY, DVec3::max),
                outline,
            }
        };
        patches(polygon.vertices()).iter().map(|patch| screen(patch.outline())).collect()
    }

    /// Edges, counter-clockwise seen from the front.
    pub(super) fn edges(&self) -> impl Iterator<Item = [DVec3; 2]> + Clone {
        let count = self.outline.len();
        (0..count).map(move |k| [self.outline[k], self.outline[(k + 1) % count]])
    }

    /// Some of them, counter-clockwise seen from the first cell.
    pub(super) fn undecided(&self, which: Undecided) -> impl Iterator<Item = [DVec3; 2]> + Clone {
        self.numbered(which).map(|(_, edge)| edge)
    }

    /// The same, each with its number.
    pub(super) fn numbered(&self, which: Undecided) -> impl Iterator<Item = (usize, [DVec3; 2])> + Clone {
        let all = self.edges().enumerate().filter(move |(k, _)| which.has(*k));
        all.map(move |(k, [a, b])| (k, if which.is_first_in_front { [a, b] } else { [b, a] }))
    }

    pub(super) fn outline(&self) -> &[DVec3] {
        &self.outline
    }

    pub(super) const fn normal(&self) -> DVec3 {
        self.normal
    }

    /// Height over the plane, 0 for a point level with it up to rounding.
    pub(super) fn height(&self, point: DVec3) -> f64 {
        let r = point - self.outline[0];
        let height = self.normal.dot(r);
        let level = |reach: f64| self.level.at(reach) + self.defect;
        // The sum of the components is at least the length, and saves its root for almost all points.
        let is_level =
            height.abs() <= level(r.abs().element_sum() * (1.0 + 4.0 * f64::EPSILON)) && height.abs() <= level(r.length());
        if is_level { 0.0 } else { height }
    }

    /// The heights of some points, and on which sides they are.
    fn rise(&self, points: &[DVec3]) -> ([f64; MOST_CORNERS], Sides) {
        let mut heights = [0.0; MOST_CORNERS];
        heights.iter_mut().zip(points).for_each(|(height, &point)| *height = self.height(point));
        let any = |is: fn(&f64) -> bool| heights[..points.len()].iter().any(is);
        (heights, Sides { front: any(|h| *h > 0.0), behind: any(|h| *h < 0.0) })
    }

    /// On which sides of its plane some points are.
    pub(super) fn sides(&self, points: &[DVec3]) -> Sides {
        points.iter().fold(Sides { front: false, behind: false }, |sides, &point| {
            let height = self.height(point);
            Sides { front: sides.front || height > 0.0, behind: sides.behind || height < 0.0 }
        })
    }

    /// By how much edges may be displaced.
    fn slack(&self, reach: f64) -> f64 {
        64.0 * f64::EPSILON * (self.largest + reach)
    }

    /// The most that two polygons with coordinates up to `reach` exchange between this screen and its displaced self.
    pub(super) fn leak(&self, reach: f64) -> f64 {
        self.slack(reach) * (self.perimeter + 8.0 * self.slack(reach))
    }

    /// How much of the sight between two convex cells the screen leaves; their coordinates are up to `reach`. The caller knows that
    /// all segments between them are inside the edges that are not `open`.
    pub(super) fn between(&self, cells: &Cells<'_>, reach: f64, open: Undecided) -> Verdict {
        self.leaves(cells, self.slack(reach), open)
    }

    /// The same where each cell is on a side of its own of the screen's plane, or both are on one: else nothing.
    pub(super) fn parting(&self, cells: [&[DVec3]; 2], reach: f64) -> Option<Verdict> {
        self.parts(cells, self.slack(reach), Undecided::ALL)
    }

    fn leaves(&self, cells: &Cells<'_>, slack: f64, open: Undecided) -> Verdict {
        let through = || Verdict::exact(if self.is_apart(cells.hull()) { Sight::Free } else { Sight::Part });
        self.parts(cells.outlines, slack, open).unwrap_or_else(through)
    }

    fn parts(&self, cells: [&[DVec3]; 2], slack: f64, open: Undecided) -> Option<Verdict> {
        if cells.iter().any(|cell| cell.len() > MOST_CORNERS) {
            return Some(Verdict::exact(Sight::Part));
        }
        let (heights_a, sides_a) = self.rise(cells[0]);
        let (heights_b, sides_b) = self.rise(cells[1]);
        let [a, b] = [(cells[0], &heights_a), (cells[1], &heights_b)];
        let is_level = |sides: Sides| !sides.front && !sides.behind;
        let is_beside = (!sides_a.behind && !sides_b.behind) || (!sides_a.front && !sides_b.front);
        if is_level(sides_a) || is_level(sides_b) || is_beside {
            return Some(Verdict::exact(Sight::Free));
        }
        let (from, to, is_first_in_front) = if !sides_a.behind && !sides_b.front {
            (a, b, true)
        } else if !sides_a.front && !sides_b.behind {
            (b, a, false)
        } else {
            return None;
        };
        let (mut undecided, mut hidden_displaced) = (Undecided { edges: 0, is_first_in_front, is_parting: true }, false);
        for (k, edge) in self.edges().enumerate().filter(|(k, _)| open.has(*k)) {
            let (mut inside, mut outside, mut displaced) = (false, false, false);
            'pairs: for (&x, &over) in from.0.iter().zip(from.1) {
                let seen = SightedEdge::new(edge, x);
                for (&y, &under) in to.0.iter().zip(to.1) {
                    let (passing, moved) = seen.passing(y, [over, under], slack);
                    displaced |= moved;
                    inside |= passing == Passing::Inside;
                    outside |= passing == Passing::Outside;
                    if inside && outside {
                        break 'pairs;
                    }
                }
            }
            if !inside {
                return Some(Verdict { sight: Sight::Free, is_displaced: displaced, edges: None });
            }
            if outside {
                undecided.edges |= 1 << k;
            } else {
                hidden_displaced |= displaced;
            }
        }
        let (sight, edges) = if undecided.edges == 0 { (Sight::Blocked, None) } else { (Sight::Part, Some(undecided)) };
        Some(Verdict { sight, is_displaced: hidden_displaced, edges })
    }

    /// The part of an outline that it leaves visible from a point, the two cells: exact for the doubles as given, but for points level with
    /// its plane.
    pub(super) fn before(&self, cells: &Cells<'_>) -> Sight {
        self.leaves(cells, 0.0, Undecided::ALL).sight
    }

    /// Whether a plane that bounds the hull of two cells, or that of a coordinate, has the screen beyond it.
    fn is_apart(&self, hull: &Hull) -> bool {
        if hull.low.cmpge(self.high).any() || hull.high.cmple(self.low).any() {
            return true;
        }
        // There is no such plane where a segment between the two meets the screen.
        !self.is_met(hull.middles) && hull.sides.iter().any(|side| self.is_beyond(side, hull.reach))
    }

    /// Whether a segment meets it, up to rounding.
    pub(super) fn is_met(&self, [x, y]: [DVec3; 2]) -> bool {
        let sign = self.normal.dot(x - self.outline[0]);
        let is_between = sign * self.normal.dot(y - self.outline[0]) < 0.0;
        is_between && self.edges().all(|[a, b]| sign * (y - x).dot((b - x).cross(a - x)) > 0.0)
    }

    fn is_beyond(&self, side: &Side, reach: f64) -> bool {
        let lowest = self.outline.iter().map(|&p| side.normal.dot(p - side.origin)).fold(f64::INFINITY, smaller);
        if lowest <= 0.0 {
            return false;
        }
        let reach = self.outline.iter().map(|&p| (p - side.origin).abs().max_element()).fold(reach, larger);
        lowest > side.error(reach)
    }
}

/// Two cells. Their hull is found when the first screen needs it.
pub(super) struct Cells<'a> {
    outlines: [&'a [DVec3]; 2],
    hull: OnceCell<Hull>,
}

impl<'a> Cells<'a> {
    pub(super) const fn new(outlines: [&'a [DVec3]; 2]) -> Self {
        Self { outlines, hull: OnceCell::new() }
    }

    fn hull(&self) -> &Hull {
        self.hull.get_or_init(|| Hull::of(self.outlines))
    }
}

/// The convex hull of two cells.
struct Hull {
    low: DVec3,
    high: DVec3,
    /// Of the two cells.
    middles: [DVec3; 2],
    /// The planes through an edge of one cell and a corner of the other that have no point of either before them.
    sides: Vec<Side>,
    /// The most by which coordinates of the two differ.
    reach: f64,
}

/// A plane, its normal pointing out of the hull, with any length.
struct Side {
    origin: DVec3,
    normal: DVec3,
}

impl Side {
    /// Six times a bound on the error of heights over it, of points as far from the origin as this: a difference, a product and two sums in
    /// three components. The normal is exact, whatever it is: it is a plane.
    fn error(&self, reach: f64) -> f64 {
        12.0 * f64::EPSILON * self.normal.abs().element_sum() * reach
    }
}

impl Hull {
    fn of([a, b]: [&[DVec3]; 2]) -> Self {
        let all = || a.iter().chain(b).copied();
        let (low, high) = (all().fold(DVec3::INFINITY, DVec3::min), all().fold(DVec3::NEG_INFINITY, DVec3::max));
        let reach = (high - low).max_element();
        let mut sides = Vec::new();
        for (outline, points) in [(a, b), (b, a)] {
            for (i, &origin) in outline.iter().enumerate() {
                let along = outline[(i + 1) % outline.len()] - origin;
                for &point in points {
                    let side = Side { origin, normal: along.cross(point - origin) };
                    // Half of it: what is beyond all of it is then beyond the hull, whichever way both err.
                    let error = 0.5 * side.error(reach);
                    let (mut is_before, mut is_behind) = (false, false);
                    for height in all().map(|p| side.normal.dot(p - origin)) {
                        is_before |= height > error;
                        is_behind |= height < -error;
                        if is_before && is_behind {
                            break;
                        }
                    }
                    match (is_before, is_behind) {
                        (false, true) => sides.push(side),
                        (true, false) => sides.push(Side { normal: -side.normal, ..side }),
                        _ => {}
                    }
                }
            }
        }
        Self { low, high, middles: [middle(a), middle(b)], sides, reach }
    }
}

/// An edge seen from a point x.
pub(super) struct SightedEdge {
    edge: [DVec3; 2],
    x: DVec3,
    /// `(b - x) x (a - x)`, and the sum of the magnitudes of the terms of each component.
    turn: DVec3,
    size: DVec3,
}

impl SightedEdge {
    pub(super) fn new([a, b]: [DVec3; 2], x: DVec3) -> Self {
        let (to_a, to_b) = (a - x, b - x);
        let (n, p) = (to_a.abs(), to_b.abs());
        let size = DVec3::new(n.y * p.z + n.z * p.y, n.z * p.x + n.x * p.z, n.x * p.y + n.y * p.x);
        Self { edge: [a, b], x, turn: to_b.cross(to_a), size }
    }

    /// T, and a bound on its error: a term passes through ten roundings.
    fn turn(&self, y: DVec3) -> (f64, f64) {
        let r = y - self.x;
        (r.dot(self.turn), 10.0 * f64::EPSILON * r.abs().dot(self.size) + f64::MIN_POSITIVE)
    }

    /// Bounds on T: both 0 where it is surely that.
    pub(super) fn turn_within(&self, y: DVec3) -> [f64; 2] {
        let (turn, error) = self.turn(y);
        if turn.abs() <= error && self.is_flat(y) { [0.0; 2] } else { [turn - error, turn + error] }
    }

    /// Whether the edge and the segment to y are surely in one plane.
    fn is_flat(&self, y: DVec3) -> bool {
        let ([a, b], x) = (self.edge, self.x);
        let is_touching = x == a || x == b || y == a || y == b;
        is_touching || is_level([a, b, x, y]) || is_line([a, b, x]) || is_line([a, b, y]) || are_along([a, b], [x, y])
    }

    /// On which side of the edge the segment to y passes, given with their heights; and whether the edge was displaced by `slack` for it.
    fn passing(&self, y: DVec3, [over, under]: [f64; 2], slack: f64) -> (Passing, bool) {
        if over == 0.0 && under == 0.0 {
            return (Passing::On, false);
        }
        let (turn, error) = self.turn(y);
        if turn > error {
            return (Passing::Inside, false);
        }
        if turn < -error {
            return (Passing::Outside, false);
        }
        self.passing_near(y, (turn, error), slack * (over - under))
    }

    /// The same where rounding may hide the sign.
    fn passing_near(&self, y: DVec3, (turn, error): (f64, f64), slack: f64) -> (Passing, bool) {
        let ([a, b], x) = (self.edge, self.x);
        if self.is_flat(y) {
            return (Passing::On, false);
        }
        if turn != 0.0 && turn.abs() + error <= slack * (b - a).length() {
            return (Passing::On, true);
        }
        let power = normalising_power([a, b, x, y].iter().map(|v| v.abs().max_element()).fold(0.0, larger));
        let at = |v: DVec3| Coord3D { x: v.x * power, y: v.y * power, z: v.z * power };
        match orient3d(at(x), at(y), at(a), at(b)) {
            sign if sign > 0.0 => (Passing::Inside, false),
            sign if sign < 0.0 => (Passing::Outside, false),
            _ => (Passing::On, false),
        }
    }
}

/// Whether four points are surely in one plane: they have a coordinate in common.
fn is_level([a, b, c, d]: [DVec3; 4]) -> bool {
    (a.cmpeq(b) & a.cmpeq(c) & a.cmpeq(d)).any()
}

/// Whether three points are surely on one line: they have two coordinates in common.
fn is_line([a, b, c]: [DVec3; 3]) -> bool {
    (a.cmpeq(b) & a.cmpeq(c)).bitmask().count_ones() >= 2
}

/// Whether two segments surely run along one axis.
fn are_along([a, b]: [DVec3; 2], [c, d]: [DVec3; 2]) -> bool {
    (a.cmpeq(b) & c.cmpeq(d)).bitmask().count_ones() >= 2
}

/// Area of a flat convex outline.
pub(super) fn area(outline: &[DVec3], normal: DVec3) -> f64 {
    let fan = (2..outline.len()).map(|i| normal.dot((outline[i - 1] - outline[0]).cross(outline[i] - outline[0])));
    0.5 * fan.sum::<f64>()
}
