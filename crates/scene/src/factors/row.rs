//! What a face sees: one rule of points for all of it, refined where it is too coarse for any of what is seen.
//!
//! What the points of a closed scene see sums to 1 to the last digits, and so does the row, whatever the rule. The rule is a product
//! Gauss rule on each of some cells of the face. A factor is good enough when it lies within its proven bounds, or off them by no more
//! than the tolerance, over the geometric mean of the face's area and the smaller one of the two; in free sight by a fifth of it. Until all are, the cells are halved that serve the others
//! worst: where the second Legendre coefficient of what is seen is large, across the direction in which it is.

use radgrad_core::Receiver;
use rayon::prelude::*;

use super::matrix::Entry;
use super::pair::Pair;
use super::rule::{Patch, nodes_of, patches};
use super::{FactorSettings, FormFactors, Sighting};
use crate::Error;

/// A part of the face.
struct Cell {
    patch: Patch,
    /// One for each face seen.
    sums: Vec<Sum>,
}

/// What the points of a cell see of a face.
#[derive(Debug, Clone, Copy, Default)]
struct Sum {
    /// Times the cell's area.
    area: f64,
    /// Second Legendre coefficients of the same, along the two directions of the patch.
    bent: [f64; 2],
}

/// Share of the tolerance that a factor in free sight may be off.
const IN_FREE_SIGHT: f64 = 0.2;

/// Cells that are halved together serve at least this share as badly as the worst.
const WITH_THE_WORST: f64 = 0.3;

impl FormFactors<'_> {
    /// The entries of a row.
    pub(super) fn row(&self, from: usize, pairs: &[(usize, &Pair)], settings: &FactorSettings) -> Result<Vec<Entry>, Error> {
        if pairs.is_empty() {
            return Ok(Vec::new());
        }
        let polygon = self.polygon(from);
        let area = polygon.area();
        let allowed = |&(to, pair): &(usize, &Pair)| {
            let shared = (area * area.min(self.polygon(to).area())).sqrt();
            // In free sight nothing else is in the bound.
            let own = if pair.bracket.is_none() { IN_FREE_SIGHT * area } else { f64::INFINITY };
            settings.tolerance * shared.min(own)
        };
        let allowed: Vec<f64> = pairs.iter().map(allowed).collect();
        let whole = patches(polygon.vertices());
        let mut cells = whole.into_iter().map(|patch| self.cell(from, patch, pairs, settings)).collect::<Result<Vec<_>, _>>()?;
        let per_cell = settings.points_per_side * settings.points_per_side;
        loop {
            let left = settings.most_points_a_face / per_cell;
            let chosen = worst(&cells, pairs, &allowed);
            if chosen.is_empty() || cells.len() >= left {
                break;
            }
            // All that are about as bad at once, the worst first.
            let chosen = &chosen[..chosen.len().min(left - cells.len())];
            let halves: Vec<Patch> = chosen.iter().flat_map(|&(k, direction)| cells[k].patch.halves(direction)).collect();
            let found = halves.into_par_iter().map(|patch| self.cell(from, patch, pairs, settings));
            let mut found = found.collect::<Result<Vec<_>, _>>()?.into_iter();
            for &(k, _) in chosen {
                if let (Some(first), Some(second)) = (found.next(), found.next()) {
                    cells[k] = first;
                    cells.push(second);
                }
            }
        }
        let entry = |(k, &(face, pair)): (usize, &(usize, &Pair))| {
            let factor = cells.iter().map(|cell| cell.sums[k].area).sum::<f64>() / area;
            let [least, most] = pair.bounds().map(|bound| bound / area);
            // The truth is in the bracket, wherever the points are.
            let error = (most - factor).max(factor - least) * (1.0 + 8.0 * f64::EPSILON) + 8.0 * f64::EPSILON * factor.abs();
            Entry { face, factor, error, occluders: pair.candidates.len() }
        };
        Ok(pairs.iter().enumerate().map(entry).collect())
    }

    fn cell(&self, from: usize, patch: Patch, pairs: &[(usize, &Pair)], settings: &FactorSettings) -> Result<Cell, Error> {
        let mut sums = vec![Sum::default(); pairs.len()];
        let mut sightings = vec![Sighting { tolerance: settings.point_tolerance, hider: None }; pairs.len()];
        for node in nodes_of(&patch, settings.points_per_side) {
            let receiver = Receiver::new(node.point, self.polygon(from).normal(), 1.0).map_err(Error::Receiver)?;
            for ((&(to, pair), sum), at) in pairs.iter().zip(&mut sums).zip(&mut sightings) {
                let seen = node.share * self.at_node(&receiver, to, &pair.candidates, at)?.radiosity;
                sum.area += seen;
                for (bent, x) in sum.bent.iter_mut().zip(node.place) {
                    *bent += (1.5 * x * x - 0.5) * seen;
                }
            }
        }
        Ok(Cell { patch, sums })
    }
}

/// The cells to halve, the worst first, each with the direction to halve it in; none where every sum is good enough.
fn worst(cells: &[Cell], pairs: &[(usize, &Pair)], allowed: &[f64]) -> Vec<(usize, usize)> {
    let is_off = |k: &usize| {
        let sum: f64 = cells.iter().map(|cell| cell.sums[*k].area).sum();
        let [least, most] = pairs[*k].1.bounds();
        (sum - most).max(least - sum) > allowed[*k]
    };
    let off: Vec<usize> = (0..pairs.len()).filter(is_off).collect();
    let of_cell = |(place, cell): (usize, &Cell)| {
        let mut bent = [0.0; 2];
        let mut worst = 0.0_f64;
        for &k in &off {
            let [u, v] = cell.sums[k].bent.map(|b| b.abs() / allowed[k].max(f64::MIN_POSITIVE));
            bent = [bent[0] + u, bent[1] + v];
            worst = worst.max(u + v);
        }
        (worst, place, usize::from(bent[1] > bent[0]))
    };
    let mut found: Vec<(f64, usize, usize)> = cells.iter().enumerate().map(of_cell).filter(|(worst, ..)| *worst > 0.0).collect();
    found.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
    let most = found.first().map_or(0.0, |cell| cell.0);
    found.into_iter().take_while(|cell| cell.0 >= WITH_THE_WORST * most).map(|(_, place, direction)| (place, direction)).collect()
}
