//! Globally adaptive cubature over the triangles of a region.
//!
//! The integrands of Eqs. 1, 6 and 9 (HS95) are analytic but for `r = 0`, so they vary on the scale of the distance to the receiver. Before
//! any error is estimated, triangles are halved until none is longer than [`LONGEST`] times its own distance: no peak can hide
//! between the points of a rule, which is how adaptive integrators fail silently. Then the triangle with the largest estimate,
//! the difference of two rules of different degree, is halved until the sum of the estimates meets the tolerance. The sum is an
//! error of the lower rule and the result is that of the higher: an estimate, not a proof, but a cautious one. Rounding is counted
//! beside it, [`ROUNDING`] times the integral of the magnitude: an integral that cancels by more than that says so.
//! For a function source this holds as long as the function itself varies no faster than the kernel.

use std::cmp::Ordering;
use std::collections::BinaryHeap;

use crate::Error;
use crate::cubature::Status;
use crate::region::{Region, Triangle, Vertex};
use crate::triangle_rule::{DEGREE_8, DEGREE_14, TriangleRule};

/// Largest length of a triangle over its distance from the receiver. At 2 the singularity is at `+-i` or further for a line through
/// the triangle mapped to `[-1, 1]`, so each degree gains a factor 2.4 or more (Bernstein's ellipse).
const LONGEST: f64 = 2.0;

/// Rounding error of one evaluation relative to the magnitude of the integrand, with that of the rounded geometry.
const ROUNDING: f64 = 4.0 * f64::EPSILON;

/// Tolerance below which the pair of higher degree does the same with fewer evaluations.
const TIGHT: f64 = 1e-4;

/// A value and the three components of its gradient, as one integrand.
pub(crate) type Four = [f64; 4];

/// What an adaptive integration gives.
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
    /// Allowed error relative to the size of `known` plus the integral.
    pub(crate) tolerance: f64,
    /// Evaluations allowed.
    pub(crate) budget: usize,
    /// A part of the answer that is not integrated here.
    pub(crate) known: Four,
}

/// Integral and estimates over one triangle.
#[derive(Debug, Clone, Copy)]
struct Cell {
    triangle: Triangle,
    integral: Four,
    /// Estimated error of the rule: of the value, of the gradient.
    discrepancy: [f64; 2],
    /// Rounding, likewise.
    rounding: [f64; 2],
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

/// Integrates `integrand` over the region.
pub(crate) fn integrate(region: &Region, integrand: &impl Fn(&Vertex) -> Four, goal: Goal) -> Result<Refined, Error> {
    let (low, high): (&TriangleRule, &TriangleRule) =
        if goal.tolerance < TIGHT { (&DEGREE_8, &DEGREE_14) } else { (&DEGREE_8, &DEGREE_14) };
    let cost = low.points.len() + high.points.len();
    let triangles = graded(region, goal.budget / cost)?;
    let mut evaluations = cost * triangles.len();
    if evaluations > goal.budget {
        return Err(Error::Budget { budget: goal.budget, needed: evaluations });
    }
    let mut cells: Vec<Cell> = triangles.into_iter().map(|triangle| measure(triangle, integrand, low, high)).collect();
    let mut totals = sum(cells.iter());
    let scale = sizes(goal.known, totals.integral).map(|size| if size > 0.0 { size } else { 1.0 });
    let urgency = |cell: &Cell| (cell.discrepancy[0] / scale[0]).max(cell.discrepancy[1] / scale[1]);
    for cell in &mut cells {
        cell.urgency = urgency(cell);
    }
    let mut heap = BinaryHeap::from(cells);
    let status = loop {
        if let Some(status) = verdict(&totals, &goal) {
            // The running totals have drifted by rounding: the verdict must hold for the sums themselves.
            totals = sum(heap.iter());
            if verdict(&totals, &goal) == Some(status) {
                break status;
            }
        }
        if evaluations + 2 * cost > goal.budget {
            totals = sum(heap.iter());
            break Status::BudgetExhausted;
        }
        let Some(worst) = heap.pop() else { break Status::Converged };
        let mut halves = worst.triangle.halves().map(|half| measure(half, integrand, low, high));
        evaluations += 2 * cost;
        distrust(&worst, &mut halves);
        totals.replace(&worst, &halves);
        for mut half in halves {
            half.urgency = urgency(&half);
            heap.push(half);
        }
    };
    if let Some(value) = totals.integral.iter().find(|value| !value.is_finite()) {
        return Err(Error::NotFinite { quantity: "an integral over the emitter", value: *value });
    }
    let error = [0, 1].map(|i| totals.discrepancy[i] + totals.rounding[i]);
    Ok(Refined { integral: totals.integral, error, evaluations, status })
}

/// The region's triangles, halved until none is longer than [`LONGEST`] times its distance from the receiver.
fn graded(region: &Region, most: usize) -> Result<Vec<Triangle>, Error> {
    let squared_height = region.height * region.height;
    let mut waiting = region.triangles.clone();
    let mut graded = Vec::with_capacity(waiting.len());
    while let Some(triangle) = waiting.pop() {
        let squared_distance = triangle.squared_distance_to_foot() + squared_height;
        if triangle.squared_diameter() <= LONGEST * LONGEST * squared_distance {
            graded.push(triangle);
        } else if graded.len() + waiting.len() > most {
            return Err(Error::Budget { budget: most, needed: graded.len() + waiting.len() });
        } else {
            waiting.extend(triangle.halves());
        }
    }
    Ok(graded)
}

fn measure(triangle: Triangle, integrand: &impl Fn(&Vertex) -> Four, low: &TriangleRule, high: &TriangleRule) -> Cell {
    let mut coarse = [0.0; 4];
    for (l, weight) in &low.points {
        let f = integrand(&triangle.at(*l));
        coarse = [0, 1, 2, 3].map(|i| coarse[i] + weight * f[i]);
    }
    let (mut integral, mut magnitude) = ([0.0; 4], [0.0; 2]);
    for (l, weight) in &high.points {
        let f = integrand(&triangle.at(*l));
        integral = [0, 1, 2, 3].map(|i| integral[i] + weight * f[i]);
        magnitude = [magnitude[0] + weight * f[0].abs(), magnitude[1] + weight * (f[1].abs() + f[2].abs() + f[3].abs())];
    }
    let difference = [0, 1, 2, 3].map(|i| triangle.area * (integral[i] - coarse[i]));
    Cell {
        triangle,
        integral: integral.map(|mean| triangle.area * mean),
        discrepancy: lengths(difference),
        rounding: magnitude.map(|mean| ROUNDING * triangle.area * mean),
        urgency: 0.0,
    }
}

/// Raises the estimates of two halves if together they differ from their parent by more than the parent's estimate allowed: then the
/// estimates are not to be believed at this size.
fn distrust(parent: &Cell, halves: &mut [Cell; 2]) {
    let change = lengths([0, 1, 2, 3].map(|i| halves[0].integral[i] + halves[1].integral[i] - parent.integral[i]));
    for i in 0..2 {
        if change[i] > parent.discrepancy[i] + parent.rounding[i] {
            for half in &mut *halves {
                half.discrepancy[i] = half.discrepancy[i].max(0.5 * change[i]);
            }
        }
    }
}

/// Whether to stop: both errors within tolerance, or what exceeds it is rounding.
fn verdict(totals: &Totals, goal: &Goal) -> Option<Status> {
    let size = sizes(goal.known, totals.integral);
    let within = |i: usize| totals.discrepancy[i] + totals.rounding[i] <= goal.tolerance * size[i];
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
        self.discrepancy =
            [0, 1].map(|i| self.discrepancy[i] + (a.discrepancy[i] + b.discrepancy[i] - parent.discrepancy[i]));
        self.rounding = [0, 1].map(|i| self.rounding[i] + (a.rounding[i] + b.rounding[i] - parent.rounding[i]));
    }
}

/// Sums over cells; the integral compensated (Kahan), since thousands of them may be added.
fn sum<'a>(cells: impl Iterator<Item = &'a Cell>) -> Totals {
    let mut totals = Totals::default();
    let mut lost = [0.0; 4];
    for cell in cells {
        for i in 0..4 {
            let term = cell.integral[i] - lost[i];
            let next = totals.integral[i] + term;
            lost[i] = (next - totals.integral[i]) - term;
            totals.integral[i] = next;
        }
        totals.discrepancy = [0, 1].map(|i| totals.discrepancy[i] + cell.discrepancy[i]);
        totals.rounding = [0, 1].map(|i| totals.rounding[i] + cell.rounding[i]);
    }
    totals
}

/// Magnitude of the value and of the gradient.
fn lengths(f: Four) -> [f64; 2] {
    [f[0].abs(), (f[1] * f[1] + f[2] * f[2] + f[3] * f[3]).sqrt()]
}

fn sizes(known: Four, integral: Four) -> [f64; 2] {
    lengths([0, 1, 2, 3].map(|i| known[i] + integral[i]))
}
