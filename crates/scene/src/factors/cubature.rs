//! What undecided pairs of cells exchange, by integration of what the points of one see of the other: with an estimate of its error,
//! not a bound.
//!
//! A product Gauss rule on the smaller cell of a pair is compared with one of fewer points, and the piece that differs most is
//! halved across the direction in which the visible share bends most, until the sum of differences is small enough or the points
//! are spent. Each point's share has a closed form, occlusion included: without bounds in double precision ([`super::point_factor`])
//! or, by
//! [`Rule::PRECISE`], by the evaluations of core.
//!
//! [`Rule::PRECISE`] is for many digits. What a point sees of a polygon past others is analytic in its place but where an edge of one
//! of them is seen through a corner of another (P. S. Heckbert 1992, A. J. Stewart and S. Ghali 1994: the events of an edge and a
//! vertex; those of three edges are left to refinement). Such points are on the plane through the edge and the corner, so the cell
//! is cut along those planes first, if they are few enough.

use std::cmp::Ordering;
use std::collections::BinaryHeap;

use radgrad_core::{DVec3, Emission, Emitter, Polygon, Receiver};

use super::bracket::{Hider, Mixed};
use super::point_factor::PointFactor;
use super::rule::{Patch, nodes_of, patches};
use super::screen::{Cells, Screen, Sight as Visible};
use super::{FormFactors, Sighting};
use crate::error::Error;
use crate::extremes::{largest as larger, smallest as smaller};
use crate::occluders::overlap::{above, on_the_way};

/// Points a side of two product rules, and whether cells are cut along events first.
#[derive(Debug, Clone, Copy)]
pub(super) struct Rule {
    rough: usize,
    fine: usize,
    by_events: bool,
}

impl Rule {
    pub(super) const PLAIN: Self = Self { rough: 2, fine: 3, by_events: false };
    pub(super) const PRECISE: Self = Self { rough: 8, fine: 12, by_events: true };

    const fn points(self) -> usize {
        self.rough * self.rough + self.fine * self.fine
    }
}

/// How far an integration goes.
#[derive(Debug, Clone, Copy)]
pub(super) struct Goal {
    /// Sum of differences that is small enough, an area.
    pub(super) difference: f64,
    pub(super) most_points: usize,
    /// Absolute error that is allowed of what a point sees.
    pub(super) at_point: f64,
}

/// A value and what it is off by all appearances, both areas.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Estimate {
    pub(super) area: f64,
    pub(super) difference: f64,
}

/// Cells that a cell is cut into at most before the rules are asked.
const MOST_CELLS: usize = 64;

/// Two cells, the points of one of which look at the other.
struct Sight<'a> {
    normal: DVec3,
    /// The cell that is looked at.
    cell: &'a [DVec3],
    facing: DVec3,
    /// The screens that their numbers are of.
    screens: &'a [&'a Screen],
    /// For the evaluations of core.
    exact: Option<Exact>,
}

/// What a point is evaluated with exactly.
struct Exact {
    emitter: Emitter,
    /// The faces that may hide a part.
    candidates: Vec<usize>,
}

/// The faces between two faces, and the convex screens that they are made of.
#[derive(Clone, Copy)]
pub(super) struct Hiding<'a> {
    pub(super) screens: &'a [&'a Screen],
    /// The face of each.
    pub(super) owners: &'a [usize],
}

/// A part of the cell whose points look.
struct Piece {
    /// Which of the sights it belongs to.
    sight: usize,
    patch: Patch,
    /// The hiders of a part.
    hiders: Vec<Hider>,
    fine: f64,
    difference: f64,
    /// The direction to halve it in.
    direction: usize,
}

impl Sight<'_> {
    /// Those that hide something from a part of a patch; `None` where one hides all.
    fn hiders_of(&self, part: &Patch, of_patch: &[Hider]) -> Option<Vec<Hider>> {
        let mut hiders = Vec::with_capacity(of_patch.len());
        let cells = Cells::new([part.outline(), self.cell]);
        for &hider in of_patch {
            // The cells' order decides nothing of what a screen leaves.
            let verdict = self.screens[hider.screen as usize].between(&cells, 1.0, hider.open);
            match verdict.sight {
                Visible::Blocked => return None,
                Visible::Part => hiders.push(Hider { open: verdict.edges.unwrap_or(hider.open), ..hider }),
                Visible::Free => {}
            }
        }
        Some(hiders)
    }
}

impl FormFactors<'_> {
    /// The exchange of pairs of cells of two faces.
    pub(super) fn integrate<'a>(
        &self,
        faces: [usize; 2],
        pairs: impl Iterator<Item = &'a Mixed>,
        hiding: Hiding<'a>,
        rule: Rule,
        goal: Goal,
    ) -> Result<Estimate, Error> {
        let (mut sights, mut pieces, mut points) = (Vec::new(), BinaryHeap::new(), 0);
        let (mut sum, mut difference) = (0.0, 0.0);
        let mut view = PointFactor::default();
        for mixed in pairs {
            self.go_on()?;
            // The smaller cell looks: what its points see differs less.
            let from = usize::from(mixed.cells[1].area < mixed.cells[0].area);
            let [own, cell] = [from, 1 - from].map(|k| &mixed.cells[k].points[..]);
            let [normal, facing] = [from, 1 - from].map(|k| self.scaled(faces[k]).normal());
            let mut sight = Sight { normal, cell, facing, screens: hiding.screens, exact: None };
            if rule.by_events {
                let Ok(polygon) = Polygon::new(cell.to_vec()) else {
                    // A cell of hardly any width.
                    difference += smaller(mixed.cells[1 - from].area, mixed.cells[from].area);
                    continue;
                };
                let emitter = Emitter::new(polygon, Emission::Constant(1.0)).map_err(Error::Emitter)?;
                let mut candidates: Vec<usize> = mixed.screens.iter().map(|hider| hiding.owners[hider.screen as usize]).collect();
                candidates.dedup();
                sight.exact = Some(Exact { emitter, candidates });
            }
            let parts = sight.exact.as_ref().map_or_else(|| patches(own), |exact| self.cut_by_events(own, exact));
            for patch in parts {
                // A shadow of few edges leaves few parts.
                let mut hiders = mixed.screens.clone();
                hiders.sort_by_key(|hider| hider.open.count());
                pieces.push(self.piece(patch, hiders, (sights.len(), &sight), rule, goal.at_point, &mut view)?);
                points += rule.points();
            }
            sights.push(sight);
        }
        let mut open: f64 = pieces.iter().map(|piece: &Piece| piece.difference).sum();
        while open > goal.difference && points < goal.most_points {
            self.go_on()?;
            let Some(worst) = pieces.pop() else { break };
            open -= worst.difference;
            for patch in worst.patch.halves(worst.direction) {
                let sight = &sights[worst.sight];
                let Some(hiders) = sight.hiders_of(&patch, &worst.hiders) else { continue };
                let piece = self.piece(patch, hiders, (worst.sight, sight), rule, goal.at_point, &mut view)?;
                open += piece.difference;
                pieces.push(piece);
                points += rule.points();
            }
        }
        for piece in pieces.into_sorted_vec() {
            sum += piece.fine;
            difference += piece.difference;
        }
        Ok(Estimate { area: sum, difference })
    }

    fn piece(
        &self,
        patch: Patch,
        hiders: Vec<Hider>,
        (place, sight): (usize, &Sight<'_>),
        rule: Rule,
        tolerance: f64,
        view: &mut PointFactor,
    ) -> Result<Piece, Error> {
        let mut at = Sighting { tolerance, hider: None };
        let mut bent = [0.0; 2];
        let mut by = |per_side: usize| -> Result<f64, Error> {
            let mut seen = 0.0;
            bent = [0.0; 2];
            for node in nodes_of(&patch, per_side) {
                let factor = match &sight.exact {
                    Some(Exact { emitter, candidates }) => {
                        let receiver = Receiver::new(node.point, sight.normal, 1.0).map_err(Error::Receiver)?;
                        self.at_node(&receiver, emitter, candidates, &mut at)?.radiosity
                    }
                    None => {
                        let from = (node.point, sight.normal);
                        let screens = hiders.iter().map(|hider| (sight.screens[hider.screen as usize], hider.open));
                        view.factor(from, (sight.cell, sight.facing), screens)
                    }
                };
                let value = node.share * factor;
                seen += value;
                for (bent, x) in bent.iter_mut().zip(node.place) {
                    *bent += (1.5 * x * x - 0.5) * value;
                }
            }
            Ok(seen)
        };
        let (rough, fine) = (by(rule.rough)?, by(rule.fine)?);
        let sides = patch.sides();
        let direction = match (bent[0].abs(), bent[1].abs()) {
            (u, v) if v > u => 1,
            (u, v) if u > v => 0,
            _ => usize::from(sides[1] > sides[0]),
        };
        Ok(Piece { sight: place, patch, hiders, fine, difference: (fine - rough).abs(), direction })
    }

    /// The cell, cut along the planes through an edge of one polygon and a corner of another; whole, if that is too many cells.
    fn cut_by_events(&self, outline: &[DVec3], exact: &Exact) -> Vec<Patch> {
        let mut polygons: Vec<&Polygon> = exact.candidates.iter().map(|&face| self.scaled(face)).collect();
        polygons.push(exact.emitter.polygon());
        let outlines: Vec<Vec<DVec3>> = patches(outline).iter().map(|patch| patch.outline().to_vec()).collect();
        let whole = outlines.len();
        let mut cells = outlines;
        for (k, polygon) in polygons.iter().enumerate() {
            let vertices = polygon.vertices();
            for i in 0..vertices.len() {
                let (a, b) = (vertices[i], vertices[(i + 1) % vertices.len()]);
                let others = polygons.iter().enumerate().filter(|(other, _)| *other != k);
                for &corner in others.flat_map(|(_, other)| other.vertices()) {
                    let normal = (b - a).cross(corner - a);
                    // Where the corner is on the edge's line there is no plane.
                    if normal.length() <= 1e-12 * (b - a).length() * (corner - a).length() {
                        continue;
                    }
                    cells = cells.iter().flat_map(|cell| cut(cell, a, normal.normalize())).collect();
                    if cells.len() > MOST_CELLS * whole {
                        return patches(outline);
                    }
                }
            }
        }
        cells.iter().flat_map(|cell| patches(cell)).collect()
    }
}

/// The one or two parts of a convex outline beside a plane.
fn cut(outline: &[DVec3], origin: DVec3, normal: DVec3) -> Vec<Vec<DVec3>> {
    let size = outline.iter().map(|&p| (p - outline[0]).length()).fold(0.0, larger);
    // A cut this near a corner or an edge leaves a cell that no rule would miss.
    let near = 1e-9 * size;
    let height = |&p: &DVec3| {
        let height = normal.dot(p - origin);
        if height.abs() <= near { 0.0 } else { height }
    };
    let heights: Vec<f64> = outline.iter().map(height).collect();
    if heights.iter().all(|&h| h >= 0.0) || heights.iter().all(|&h| h <= 0.0) {
        return vec![outline.to_vec()];
    }
    let below: Vec<f64> = heights.iter().map(|h| -h).collect();
    [heights, below].iter().map(|heights| above(outline, heights, on_the_way)).filter(|points| points.len() >= 3).collect()
}

impl PartialEq for Piece {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for Piece {}

impl PartialOrd for Piece {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Piece {
    fn cmp(&self, other: &Self) -> Ordering {
        self.difference.total_cmp(&other.difference)
    }
}
