//! Globally adaptive cubature over the triangles of a region and the edges of its boundary.
//!
//! The integrands of Eqs. 1, 6 and 9 (HS95) are analytic but for `r = 0`, so they vary on the scale of the distance to the
//! receiver. Before any error is estimated, pieces are halved until none is longer than [`LONGEST`] times its own distance: no
//! peak can hide between the points of a rule, which is how adaptive integrators fail silently. Then the piece with the largest
//! estimate, the difference of two rules of different degree, is halved until the sum of the estimates meets the tolerance. The
//! sum is an error of the lower rule and the result is that of the higher: an estimate, not a proof, but a cautious one.
//! Rounding is counted beside it, [`ROUNDING`] times the integral of the magnitude: an integral that cancels by more than that
//! says so. A function source states how far its own features are apart, and is looked at as closely.

use std::cmp::Ordering;
use std::collections::BinaryHeap;

use crate::Error;
use crate::cubature::Status;
use crate::cubature::piece::{Degrees, Four, Piece, ROUNDING, Sums, lengths};
use crate::region::plane::Vertex;

/// Largest length of a piece over its distance from the receiver. At 2 the singularity is at `+-i` or further for a line through
/// the piece mapped to `[-1, 1]`, so each degree gains a factor 2.4 or more (Bernstein's ellipse).
const LONGEST: f64 = 2.0;

/// Part of the estimate of a piece on which the function is rough that each half of it keeps: where the jump runs past a corner
/// of a half, between the points of its rules and its border, the half looks smooth.
const HIDDEN: f64 = 1.0 / 16.0;

/// Tolerance below which the pair of higher degree does the same with fewer evaluations.
const TIGHT: f64 = 1e-4;

/// The result of an adaptive integration.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Refined {
    pub(crate) integral: Four,
    /// Estimated error of the value, and of the gradient as a Euclidean norm.
    pub(crate) error: [f64; 2],
    pub(crate) evaluations: usize,
    pub(crate) status: Status,
}

/// When to stop.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Goal {
    /// Allowed error relative to the size of the integral.
    pub(crate) tolerance: f64,
    /// Evaluations allowed.
    pub(crate) budget: usize,
    /// Longest piece on which estimates of error are believed, whatever its distance.
    pub(crate) longest: f64,
    /// Whether the source may be rough, so that no estimate rests on one piece alone.
    pub(crate) is_wary: bool,
}

/// Integral and estimates over one piece.
#[derive(Debug, Clone, Copy)]
struct Cell {
    piece: Piece,
    integral: Four,
    /// Estimated error of the rule: of the value, of the gradient.
    discrepancy: [f64; 2],
    /// Rounding, likewise.
    rounding: [f64; 2],
    /// The least estimate for its halves: the error by a jump that all points miss.
    inherited: [f64; 2],
    urgency: f64,
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
    fn cmp(&self, other: &Self) -> Ordering {
        self.urgency.total_cmp(&other.urgency)
    }
}

/// Sums over all cells.
#[derive(Debug, Clone, Copy, Default)]
struct Totals {
    integral: Four,
    discrepancy: [f64; 2],
    rounding: [f64; 2],
}

/// Integrates over `pieces`, seen from `height` over the plane.
pub(crate) fn integrate(
    pieces: Vec<Piece>,
    height: f64,
    integrand: &impl Fn(&Piece, &Vertex) -> Four,
    goal: Goal,
) -> Result<Refined, Error> {
    let degrees = match goal {
        Goal { is_wary: true, .. } => Degrees::Wary,
        Goal { tolerance, .. } if tolerance < TIGHT => Degrees::Tight,
        _ => Degrees::Loose,
    };
    let pieces = graded(pieces, height, degrees, &goal)?;
    let mut evaluations = pieces.iter().map(|piece| piece.cost(degrees)).sum();
    let measure = |piece: Piece| Cell::new(piece, piece.sums(degrees, integrand));
    let halved = |cell: &Cell| {
        let mut halves = cell.piece.halves().map(measure);
        distrust(cell, &mut halves);
        halves
    };
    let mut cells: Vec<Cell> = pieces.into_iter().map(measure).collect();
    // The jump or kink of a rough piece may run on into a corner of the next one that no point is in: halve all of them once.
    if cells.iter().any(|cell| cell.inherited != [0.0; 2]) {
        let needed = 3 * evaluations;
        if needed > goal.budget {
            return Err(Error::Evaluations { budget: goal.budget, needed });
        }
        evaluations = needed;
        cells = cells.iter().flat_map(halved).collect();
    }
    let mut totals = sum(cells.iter());
    finite(&totals)?;
    let scale = lengths(totals.integral).map(|size| if size > 0.0 { size } else { 1.0 });
    let urgency = |cell: &Cell| (cell.discrepancy[0] / scale[0]).max(cell.discrepancy[1] / scale[1]);
    for cell in &mut cells {
        cell.urgency = urgency(cell);
    }
    let mut heap = BinaryHeap::from(cells);
    let status = loop {
        if let Some(status) = verdict(&totals, goal.tolerance) {
            // The running totals have drifted by rounding: the verdict must hold for the sums themselves.
            totals = sum(heap.iter());
            if verdict(&totals, goal.tolerance) == Some(status) {
                break status;
            }
        }
        let Some(worst) = heap.pop() else { break Status::Converged };
        let cost = 2 * worst.piece.cost(degrees);
        if evaluations + cost > goal.budget {
            heap.push(worst);
            totals = sum(heap.iter());
            break Status::BudgetExhausted;
        }
        evaluations += cost;
        let halves = halved(&worst);
        totals.replace(&worst, &halves);
        for mut half in halves {
            half.urgency = urgency(&half);
            heap.push(half);
        }
    };
    finite(&totals)?;
    let error = [0, 1].map(|i| totals.discrepancy[i] + totals.rounding[i]);
    Ok(Refined { integral: totals.integral, error, evaluations, status })
}

/// The pieces, halved until none is longer than [`LONGEST`] times its distance from the receiver, or than the goal allows.
fn graded(mut waiting: Vec<Piece>, height: f64, degrees: Degrees, goal: &Goal) -> Result<Vec<Piece>, Error> {
    let mut graded = Vec::with_capacity(waiting.len());
    let mut needed = waiting.iter().map(|piece| piece.cost(degrees)).sum::<usize>();
    while let Some(piece) = waiting.pop() {
        if needed > goal.budget {
            return Err(Error::Evaluations { budget: goal.budget, needed });
        }
        let squared_distance = piece.squared_distance_to_foot() + height * height;
        if piece.squared_diameter() <= (LONGEST * LONGEST * squared_distance).min(goal.longest * goal.longest) {
            graded.push(piece);
        } else {
            waiting.extend(piece.halves());
            needed += piece.cost(degrees);
        }
    }
    Ok(graded)
}

impl Cell {
    fn new(piece: Piece, sums: Sums) -> Self {
        let rounding = sums.magnitude.map(|magnitude| ROUNDING * magnitude);
        let inherited = if sums.is_rough { sums.discrepancy.map(|d| HIDDEN * d) } else { [0.0; 2] };
        Self { piece, integral: sums.integral, discrepancy: sums.discrepancy, rounding, inherited, urgency: 0.0 }
    }

    /// Takes over the least estimate for a half of `parent`.
    fn inherit(&mut self, parent: &Self) {
        for i in 0..2 {
            self.discrepancy[i] = self.discrepancy[i].max(parent.inherited[i]);
            self.inherited[i] = self.inherited[i].max(HIDDEN * parent.inherited[i]);
        }
    }
}

/// Raises the estimates of two halves if together they differ from their parent by more than the parent's estimate allowed:
/// then the estimates are not to be believed at this size.
fn distrust(parent: &Cell, halves: &mut [Cell; 2]) {
    let change = lengths([0, 1, 2, 3].map(|i| halves[0].integral[i] + halves[1].integral[i] - parent.integral[i]));
    for (i, change) in change.into_iter().enumerate() {
        if change > parent.discrepancy[i] + parent.rounding[i] {
            for half in &mut *halves {
                half.discrepancy[i] = half.discrepancy[i].max(0.5 * change);
            }
        }
    }
    for half in halves {
        half.inherit(parent);
    }
}

/// Whether to stop: both errors within tolerance, or above it by rounding only.
fn verdict(totals: &Totals, tolerance: f64) -> Option<Status> {
    let size = lengths(totals.integral);
    let within = |i: usize| totals.discrepancy[i] + totals.rounding[i] <= tolerance * size[i];
    let only_rounding = |i: usize| totals.discrepancy[i] <= totals.rounding[i];
    match (within(0), within(1)) {
        (true, true) => Some(Status::Converged),
        (value, gradient) if (value || only_rounding(0)) && (gradient || only_rounding(1)) => Some(Status::RoundoffLimited),
        _ => None,
    }
}

impl Totals {
    fn replace(&mut self, parent: &Cell, halves: &[Cell; 2]) {
        let [a, b] = halves;
        self.integral = [0, 1, 2, 3].map(|i| self.integral[i] + (a.integral[i] + b.integral[i] - parent.integral[i]));
        self.discrepancy = [0, 1].map(|i| self.discrepancy[i] + (a.discrepancy[i] + b.discrepancy[i] - parent.discrepancy[i]));
        self.rounding = [0, 1].map(|i| self.rounding[i] + (a.rounding[i] + b.rounding[i] - parent.rounding[i]));
    }
}

fn finite(totals: &Totals) -> Result<(), Error> {
    match totals.integral.iter().find(|value| !value.is_finite()) {
        Some(value) => Err(Error::NotFinite { quantity: "an integral over the emitter", value: *value }),
        None => Ok(()),
    }
}

/// Sums over cells; the integral compensated (Kahan), since thousands of them may be added.
fn sum<'a>(cells: impl Iterator<Item = &'a Cell>) -> Totals {
    let mut totals = Totals::default();
    let mut lost = [0.0; 4];
    for cell in cells {
        for (i, lost) in lost.iter_mut().enumerate() {
            let term = cell.integral[i] - *lost;
            let next = totals.integral[i] + term;
            *lost = (next - totals.integral[i]) - term;
            totals.integral[i] = next;
        }
        totals.discrepancy = [0, 1].map(|i| totals.discrepancy[i] + cell.discrepancy[i]);
        totals.rounding = [0, 1].map(|i| totals.rounding[i] + cell.rounding[i]);
    }
    totals
}
