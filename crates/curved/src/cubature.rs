//! Adaptive cubature over the unit square, of several functions at once.
//!
//! A cell's integral is that of the product Gauss rule with 5 x 5 nodes; its error is taken to be the sum of the differences from
//! those with 4 x 5 and 5 x 4, which are the errors of the smaller rules and so, where functions are smooth, far above its own.
//! In a cell of which a part is cut off, as by a shadow or a horizon, these say nothing: its error is its area times the largest
//! values that are there, cut off or not. Whether one is cut is asked at all nodes and at its corners. A horizon is known by how
//! far points are above it: a cell whose nodes are all on one side, but by less than a tenth of their differences, is taken for a
//! cut one. The cell with the largest error is halved, across the direction of the larger difference, until the sum over all cells
//! meets the tolerance, or there are too many: in either case that sum is the stated error. It is an estimate. It fails where a
//! function has a feature that no node of the first cells sees; of shadows the caller says where they may be.

use std::cmp::Ordering;
use std::collections::BinaryHeap;
use std::sync::OnceLock;

use crate::error::Error;
use radgrad_solver::{Node, rectangular};

/// Cells a side at the start.
const FIRST: u32 = 2;

/// How near to a horizon a cell is taken for cut, as a part of the differences of its nodes: between nodes a curved one may be
/// nearer by the square of their distance, at most 0.27 of the cell, over eight, times four for the parabola through the cell.
const NEAR: f64 = 0.1;

/// Integrals and the estimates of their errors.
#[derive(Debug, Clone, Default)]
pub(crate) struct Integrals {
    pub(crate) values: Vec<f64>,
    pub(crate) errors: Vec<f64>,
}

struct Cell {
    low: [f64; 2],
    size: [f64; 2],
    values: Vec<f64>,
    errors: Vec<f64>,
    worst: f64,
    /// The direction in which it is to be halved.
    along: usize,
}

impl PartialEq for Cell {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for Cell {}

impl PartialOrd for Cell {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Cell {
    /// Orders by error; of equal ones the place decides, so that the order is always the same.
    fn cmp(&self, other: &Self) -> Ordering {
        let place = |cell: &Self| (cell.low[0].to_bits(), cell.low[1].to_bits());
        self.worst.total_cmp(&other.worst).then(place(self).cmp(&place(other)))
    }
}

/// Integrates `count` functions over where a point is above. `f` gives the values, and by how much the point is above: 0 or less
/// where it is cut off, with the values that would be there. `doubt` is whether a cell of this corner and size may be cut by
/// something that no node of it sees.
pub(crate) fn integrate(
    count: usize,
    tolerance: f64,
    most_cells: usize,
    doubt: impl Fn([f64; 2], [f64; 2]) -> bool,
    mut f: impl FnMut([f64; 2], &mut [f64]) -> Result<f64, Error>,
) -> Result<Integrals, Error> {
    static RULES: OnceLock<[Vec<Node>; 3]> = OnceLock::new();
    let rules = RULES.get_or_init(|| [[5, 5], [4, 5], [5, 4]].map(|[s, t]| rectangular(s, t)));
    let corners = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [1.0, 1.0]].map(|at| Node { at, weight: 0.0 });
    let mut here = vec![0.0; count];
    let mut cell = |low: [f64; 2], size: [f64; 2]| -> Result<Cell, Error> {
        let (mut lowest, mut highest, mut largest) = (f64::INFINITY, f64::NEG_INFINITY, vec![0.0_f64; count]);
        let area = size[0] * size[1];
        let mut sum = |nodes: &[Node]| {
            let mut values = vec![0.0; count];
            for node in nodes {
                here.fill(0.0);
                let above = f([low[0] + size[0] * node.at[0], low[1] + size[1] * node.at[1]], &mut here)?;
                (lowest, highest) = (lowest.min(above), highest.max(above));
                let weight = if above > 0.0 { node.weight * area } else { 0.0 };
                for ((sum, most), value) in values.iter_mut().zip(&mut largest).zip(&here) {
                    *sum += weight * value;
                    *most = most.max(value.abs());
                }
            }
            Ok::<_, Error>(values)
        };
        let (values, others) = (sum(&rules[0])?, [sum(&rules[1])?, sum(&rules[2])?]);
        sum(&corners)?;
        let differences = others.map(|other| values.iter().zip(&other).map(|(a, b)| (a - b).abs()).collect::<Vec<_>>());
        let greatest = |errors: &[f64]| errors.iter().fold(0.0, |most: f64, e| most.max(*e));
        let near = NEAR * (highest - lowest);
        let is_cut = (lowest < near && highest > -near) || (highest > 0.0 && doubt(low, size));
        let (errors, along): (Vec<f64>, _) = if is_cut {
            (largest.iter().map(|most| most * area).collect(), usize::from(size[1] > size[0]))
        } else {
            let along = usize::from(greatest(&differences[1]) > greatest(&differences[0]));
            (differences[0].iter().zip(&differences[1]).map(|(a, b)| a + b).collect(), along)
        };
        let worst = greatest(&errors);
        Ok(Cell { low, size, values, errors, worst, along })
    };
    let mut cells = BinaryHeap::new();
    let side = 1.0 / f64::from(FIRST);
    for i in 0..FIRST {
        for j in 0..FIRST {
            cells.push(cell([f64::from(i) * side, f64::from(j) * side], [side; 2])?);
        }
    }
    let mut remaining_error: f64 = cells.iter().map(|cell| cell.worst).sum();
    while remaining_error > tolerance && cells.len() < most_cells {
        let Some(worst) = cells.pop() else { break };
        let (mut low, mut size) = (worst.low, worst.size);
        size[worst.along] *= 0.5;
        remaining_error -= worst.worst;
        for _ in 0..2 {
            let half = cell(low, size)?;
            remaining_error += half.worst;
            cells.push(half);
            low[worst.along] += size[worst.along];
        }
    }
    Ok(sum(count, cells))
}

/// The sums over all cells, in the order of the heap, which is always the same.
fn sum(count: usize, cells: BinaryHeap<Cell>) -> Integrals {
    let mut total = Integrals { values: vec![0.0; count], errors: vec![0.0; count] };
    for cell in cells.into_sorted_vec() {
        for index in 0..count {
            total.values[index] += cell.values[index];
            // With the rounding of some tens of products and sums.
            total.errors[index] += cell.errors[index] + 64.0 * f64::EPSILON * cell.values[index].abs();
        }
    }
    total
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn smooth_peaked_and_broken_functions_are_within_their_errors() {
        let smooth = |[s, t]: [f64; 2]| (s + 2.0 * t).exp();
        let peaked = |[s, t]: [f64; 2]| 1.0 / (1e-4 + s * s + t * t);
        let broken = |_| 1.0;
        // The second by the same in polar coordinates, one of them exactly: int_0^{pi/4} ln(1 + sec^2 a / 1e-4) da.
        let polar: f64 = (0..200_000)
            .map(|i| {
                let angle = (f64::from(i) + 0.5) * std::f64::consts::FRAC_PI_4 / 200_000.0;
                (1.0 + 1e4 / angle.cos().powi(2)).ln() * std::f64::consts::FRAC_PI_4 / 200_000.0
            })
            .sum();
        let e = std::f64::consts::E;
        let exact = [(e - 1.0) * (e * e - 1.0) / 2.0, polar, 0.125 * std::f64::consts::PI];
        for (which, tolerance) in [(0, 1e-9), (1, 1e-8), (2, 1e-2)] {
            let integrals = integrate(
                1,
                tolerance,
                20_000,
                |_, _| false,
                |at, values| {
                    values[0] = [smooth(at), peaked(at), broken(at)][which];
                    Ok(if which == 2 { 0.5 - at[0] * at[0] - at[1] * at[1] } else { 1.0 })
                },
            );
            let integrals = integrals.unwrap();
            let error = (integrals.values[0] - exact[which]).abs();
            assert!(
                error <= integrals.errors[0] && integrals.errors[0] <= 2.0 * tolerance,
                "{which}: {error:e} {:e}",
                integrals.errors[0]
            );
        }
    }

    #[test]
    fn what_cannot_be_reached_is_stated() {
        let step = |at: [f64; 2]| if at[0] + at[1] < 1.1 { 1.0 } else { 0.0 };
        let integrals = integrate(
            1,
            1e-9,
            40,
            |_, _| false,
            |at, values| {
                values[0] = 1.0;
                Ok(step(at) - 0.5)
            },
        );
        let integrals = integrals.unwrap();
        assert!(integrals.errors[0] > 1e-4 && (integrals.values[0] - (1.0 - 0.5 * 0.81)).abs() <= integrals.errors[0]);
    }
}
