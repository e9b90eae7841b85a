//! An obstructed factor by integration of what the points of a face see: with an estimate of its error, not a bound.
//!
//! What a point sees of a polygon past others is analytic in its place but where an edge of one of them is seen through a corner
//! of another (P. S. Heckbert 1992, A. J. Stewart and S. Ghali 1994: the events of an edge and a vertex; those of three edges are
//! left to refinement). Such points are on the plane through the edge and the corner, so the face is cut along those planes, if
//! they are few enough. On each cell a product Gauss rule of 12 by 12 points is compared with one of 8 by 8; the cell that differs
//! most is cut into four, until the sum of differences is small enough or the points are spent.

use radgrad_core::{DVec3, Polygon, Receiver};

use super::rule::{Patch, nodes_of, patches};
use super::{FactorSettings, FormFactors, Sighting};
use crate::Error;

/// Points a side of the two rules.
const ROUGH: usize = 8;
const FINE: usize = 12;

/// Cells that a face is cut into at most before the rules are asked.
const MOST_CELLS: usize = 64;

/// A part of the face, with what it contributes.
struct Cell {
    patch: Patch,
    fine: f64,
    difference: f64,
}

impl FormFactors<'_> {
    /// The factor from `from` to `to` past `candidates`, and the difference of the rules.
    pub(super) fn integrate(
        &self,
        from: usize,
        to: usize,
        candidates: &[usize],
        settings: &FactorSettings,
    ) -> Result<(f64, f64), Error> {
        let (face, area) = (self.polygon(from), self.polygon(from).area());
        let evaluate = |patch: Patch| -> Result<Cell, Error> {
            let rule = |per_side: usize| -> Result<f64, Error> {
                let (mut sum, mut at) = (0.0, Sighting { tolerance: settings.point_tolerance, hider: None });
                for node in nodes_of(&patch, per_side) {
                    let receiver = Receiver::new(node.point, face.normal(), 1.0).map_err(Error::Receiver)?;
                    sum += node.share * self.at_node(&receiver, to, candidates, &mut at)?.radiosity;
                }
                Ok(sum / area)
            };
            let (rough, fine) = (rule(ROUGH)?, rule(FINE)?);
            Ok(Cell { patch, fine, difference: (fine - rough).abs() })
        };
        let mut polygons = self.polygons(candidates);
        polygons.push(self.polygon(to));
        let mut cells = cut_by_events(face, &polygons).into_iter().map(&evaluate).collect::<Result<Vec<_>, _>>()?;
        let per_cell = ROUGH * ROUGH + FINE * FINE;
        let mut points = per_cell * cells.len();
        // Cells are few: a heap would not show.
        while cells.iter().map(|cell| cell.difference).sum::<f64>() > settings.estimate && points < settings.most_points {
            let differences = cells.iter().map(|cell| cell.difference).enumerate();
            let Some((worst, _)) = differences.max_by(|a, b| a.1.total_cmp(&b.1)) else { break };
            let quarters = cells.swap_remove(worst).patch.quarters();
            for patch in quarters {
                cells.push(evaluate(patch)?);
            }
            points += 4 * per_cell;
        }
        let sum = |of: fn(&Cell) -> f64| cells.iter().map(of).sum::<f64>();
        // The points' own errors are certified.
        Ok((sum(|cell| cell.fine), sum(|cell| cell.difference) + settings.point_tolerance))
    }
}

/// The face, cut along the planes through an edge of one polygon and a corner of another; whole, if that is too many cells.
fn cut_by_events(face: &Polygon, polygons: &[&Polygon]) -> Vec<Patch> {
    let outlines: Vec<Vec<DVec3>> = patches(face.vertices()).iter().map(|patch| patch.outline().to_vec()).collect();
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
                    return patches(face.vertices());
                }
            }
        }
    }
    cells.iter().flat_map(|cell| patches(cell)).collect()
}

/// The one or two parts of a convex outline beside a plane.
fn cut(outline: &[DVec3], origin: DVec3, normal: DVec3) -> Vec<Vec<DVec3>> {
    let heights: Vec<f64> = outline.iter().map(|&p| normal.dot(p - origin)).collect();
    let size = outline.iter().map(|&p| (p - outline[0]).length()).fold(0.0, f64::max);
    // A cut this near a corner or an edge leaves a cell that no rule would miss.
    let near = 1e-9 * size;
    if heights.iter().all(|&h| h >= -near) || heights.iter().all(|&h| h <= near) {
        return vec![outline.to_vec()];
    }
    let part = |sign: f64| {
        let mut points = Vec::with_capacity(outline.len() + 1);
        for i in 0..outline.len() {
            let j = (i + 1) % outline.len();
            let (h, next) = (sign * heights[i], sign * heights[j]);
            if h >= -near {
                points.push(outline[i]);
            }
            if (h > near && next < -near) || (h < -near && next > near) {
                points.push(outline[i] + (outline[j] - outline[i]) * (h / (h - next)));
            }
        }
        points
    };
    vec![part(1.0), part(-1.0)].into_iter().filter(|points| points.len() >= 3).collect()
}
