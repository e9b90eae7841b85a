//! Rows of a closed scene that sum to 1, by the least change within the proven brackets.
//!
//! With v the exchanges as computed, `[l, u]` their brackets, `w = u - l` their widths and A the areas, the x wanted minimises `sum (x - v)^2 / w`
//! over pairs, `l <= x <= u`, such that `sum_j x_ij = A_i` in every row: one symmetric number a pair, so reciprocity stays, and
//! an exchange that is known exactly stays. The minimum is `x_ij = clip(v_ij + w_ij (m_i + m_j))` with one multiplier a row, the
//! maximum of a concave function of them, `sum m_i A_i + sum [(x - v)^2/2w - (m_i + m_j) x]`, whose gradient is the rows' defect
//! `A_i - sum_j x_ij`. Newton's method finds it: its matrix, `diag(sum_j w_ij) + w` over the pairs that are not at an end, is positive
//! semidefinite, and conjugate gradients solve with it. Where too many pairs are at an end it is singular, and part of the defect changes
//! with no step to the first order: a share of the diagonal over all pairs is added, at most the worst defect (K. Levenberg 1944), and a step
//! that does not raise the function is halved (L. Armijo 1966).
//!
//! The error of a factor is the distance to the farther end of its bracket, so that a move may bring it over the bound that was asked
//! for. The ends are first set where the bound is met still, and only where rows cannot sum to 1 so, at those
//! of the brackets.

use super::FactorSettings;
use super::matrix::FactorMatrix;
use crate::error::Error;
use crate::extremes::{largest as larger, smallest as smaller};

/// How far a repair moved factors.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Repaired {
    /// Largest change of a factor.
    pub largest: f64,
    /// Mean of the changes of all factors, as sizes.
    pub mean: f64,
    /// The face from which, and the one to which, the factor was changed most.
    pub pair: [usize; 2],
    /// Largest `|1 - sum|` of a row that there was.
    pub closure_before: f64,
    /// Largest `|1 - sum|` of a row that is left.
    pub closure: f64,
}

/// The share that a row may lack at the end, over its area: the roundings of its sum.
const ENOUGH: f64 = 1e-14;

/// The most that is added of the whole diagonal, and the part of the rise that the gradient promises which a step has to bring.
const DAMPING: f64 = 1e-3;
const RISE: f64 = 1e-4;

/// A rise that is lost in the rounding of the function, relative to it.
const ROUNDED: f64 = 1e-12;

/// Steps of Newton's method, and of conjugate gradients in each.
const STEPS: usize = 200;
const GRADIENTS: usize = 400;

impl FactorMatrix {
    /// Moves factors the least, inside their brackets and the two of a pair together, until every row sums to 1. Brackets stay as they
    /// were; the error of an entry is the distance from its new value to their farther end, which stays below what `settings` ask
    /// for where it is so before and rows can sum to 1 with it.
    ///
    /// # Errors
    /// If some row cannot sum to 1 within its brackets, with the row: the scene is not closed there, or faces overlap. If rows are
    /// missing. Nothing is changed then.
    pub fn repair(&mut self, settings: &FactorSettings) -> Result<Repaired, Error> {
        let has_row = |face: u32| self.faces().binary_search(&(face as usize)).is_ok();
        if !self.pairs.iter().flat_map(|pair| pair.faces).all(has_row) {
            return Err(Error::expected("all rows of a matrix that is to be repaired", "a block of them"));
        }
        let worst = self.unclosed().map(|face| (face, self.sum(face))).max_by(|a, b| {
            let off = |sum: &super::matrix::SurfaceFactor| larger(sum.lower - 1.0, 1.0 - sum.upper);
            off(&a.1).total_cmp(&off(&b.1))
        });
        if let Some((face, sum)) = worst {
            let found = format!("a row of face {face} that sums to {} at least and {} at most", sum.lower, sum.upper);
            return Err(Error::expected("a closed scene, whose rows can sum to 1", found));
        }
        let closure_before = self.worst_closure();
        let before: Vec<f64> = self.pairs.iter().map(|pair| pair.known.value).collect();
        let within = |limits: Vec<[f64; 2]>| self.solve(&before, &limits);
        let brackets = || self.pairs.iter().map(|pair| [pair.known.least, pair.known.most]).collect();
        let moved = within(self.limits(settings)).or_else(|_| within(brackets()))?;
        let mut repaired = Repaired { largest: 0.0, mean: 0.0, pair: [0; 2], closure_before, closure: 0.0 };
        for ((pair, &from), &to) in self.pairs.iter_mut().zip(&before).zip(&moved) {
            pair.known.value = to;
            for k in 0..2 {
                let [a, b] = [pair.faces[k], pair.faces[1 - k]].map(|face| face as usize);
                let change = ((to - from) / self.scaled_areas[a]).abs();
                repaired.mean += change;
                if change > repaired.largest || change.is_nan() {
                    (repaired.largest, repaired.pair) = (change, [a, b]);
                }
            }
        }
        repaired.mean /= (2 * before.len()).max(1) as f64;
        repaired.closure = self.worst_closure();
        Ok(repaired)
    }

    /// Between what each exchange may be moved with its bound met still, or in its bracket where it is not met before.
    fn limits(&self, settings: &FactorSettings) -> Vec<[f64; 2]> {
        let of = |pair: &super::matrix::Pair| {
            let super::pair::Known { value, least, most, .. } = pair.known;
            let [a, b] = pair.faces.map(|face| self.scaled_areas[face as usize]);
            // The bound of the smaller face, less the roundings of a factor.
            let allowed = larger(settings.tolerance * smaller(a, b), settings.relative * least) * (1.0 - 1e-12);
            let is_met = larger(most - value, value - least) <= allowed;
            if is_met { [larger(least, most - allowed), smaller(most, least + allowed)] } else { [least, most] }
        };
        self.pairs.iter().map(of).collect()
    }

    fn solve(&self, before: &[f64], limits: &[[f64; 2]]) -> Result<Vec<f64>, Error> {
        let count = self.scaled_areas.len();
        let mut multipliers = vec![0.0; count];
        let (mut moved, mut free) = self.moved(before, limits, &multipliers);
        let mut lacking = self.lacking(&moved);
        let mut norm = self.worst(&lacking);
        let whole: f64 = self.faces().iter().map(|&face| self.scaled_areas[face]).sum();
        for _ in 0..STEPS {
            if norm <= ENOUGH {
                return Ok(moved);
            }
            let step = self.newton(&free, &lacking, smaller(norm, DAMPING));
            let height = self.height(before, &moved, &multipliers);
            let slope: f64 = step.iter().zip(&lacking).map(|(s, l)| s * l).sum();
            let mut share = 1.0;
            loop {
                let next: Vec<f64> = multipliers.iter().zip(&step).map(|(m, s)| m + share * s).collect();
                let (candidate, candidate_free) = self.moved(before, limits, &next);
                let left = self.lacking(&candidate);
                let squares = |rows: &[f64]| rows.iter().map(|x| x * x).sum::<f64>();
                let rise = share * slope;
                let is_better = if rise > ROUNDED * (height.abs() + whole) {
                    self.height(before, &candidate, &next) >= height + RISE * rise
                } else {
                    // Where large rows lack their rounding, small ones may still lack more of themselves.
                    squares(&left) < squares(&lacking) || self.worst(&left) < norm
                };
                if is_better {
                    (multipliers, moved, free, lacking) = (next, candidate, candidate_free, left);
                    break;
                }
                share *= 0.5;
                if share < 1e-9 {
                    return self.stuck(&lacking, norm).map(|()| moved);
                }
            }
            norm = self.worst(&lacking);
        }
        self.stuck(&lacking, norm).map(|()| moved)
    }

    /// Where no step helps, the rest of the defect is rounding, or the brackets of several rows do not allow their sums together.
    fn stuck(&self, lacking: &[f64], norm: f64) -> Result<(), Error> {
        if norm <= 1e3 * ENOUGH {
            return Ok(());
        }
        let off = |face: usize| (lacking[face] / self.scaled_areas[face]).abs();
        let face = self.faces().iter().copied().max_by(|&a, &b| off(a).total_cmp(&off(b))).unwrap_or(0);
        let found = format!("rows that cannot all: {:e} is left in that of face {face}", off(face));
        Err(Error::expected("rows that can sum to 1 together, within their brackets", found))
    }

    /// The exchanges that multipliers give, and the weights of those that are not at an end of their bracket.
    fn moved(&self, before: &[f64], limits: &[[f64; 2]], multipliers: &[f64]) -> (Vec<f64>, Vec<f64>) {
        let of = |((pair, &value), &[low, high]): ((&super::matrix::Pair, &f64), &[f64; 2])| {
            let [a, b] = pair.faces.map(|face| face as usize);
            let (least, most) = (pair.known.least, pair.known.most);
            let to = value + (most - least) * (multipliers[a] + multipliers[b]);
            let clipped = larger(smaller(to, high), low);
            (clipped, if clipped == to { most - least } else { 0.0 })
        };
        self.pairs.iter().zip(before).zip(limits).map(of).unzip()
    }

    /// The function of the multipliers whose maximum is wanted.
    fn height(&self, before: &[f64], moved: &[f64], multipliers: &[f64]) -> f64 {
        let of_rows: f64 = multipliers.iter().zip(self.scaled_areas.iter()).map(|(m, area)| m * area).sum();
        let of_pair = |((pair, &value), &to): ((&super::matrix::Pair, &f64), &f64)| {
            let [a, b] = pair.faces.map(|face| face as usize);
            let (width, change) = (pair.known.most - pair.known.least, to - value);
            let bent = if width > 0.0 { 0.5 * change * change / width } else { 0.0 };
            bent - (multipliers[a] + multipliers[b]) * to
        };
        of_rows + self.pairs.iter().zip(before).zip(moved).map(of_pair).sum::<f64>()
    }

    /// The part of its area that each row lacks.
    fn lacking(&self, exchanges: &[f64]) -> Vec<f64> {
        let mut lacking = vec![0.0; self.scaled_areas.len()];
        self.faces().iter().for_each(|&face| lacking[face] = self.scaled_areas[face]);
        for (pair, exchange) in self.pairs.iter().zip(exchanges) {
            pair.faces.iter().for_each(|&face| lacking[face as usize] -= exchange);
        }
        lacking
    }

    fn worst(&self, lacking: &[f64]) -> f64 {
        self.faces().iter().map(|&face| (lacking[face] / self.scaled_areas[face]).abs()).fold(0.0, larger)
    }

    /// Conjugate gradients with the diagonal for a preconditioner.
    fn newton(&self, weights: &[f64], lacking: &[f64], damping: f64) -> Vec<f64> {
        let count = lacking.len();
        let mut diagonal = vec![0.0; count];
        for (pair, weight) in self.pairs.iter().zip(weights) {
            let added = weight + damping * (pair.known.most - pair.known.least);
            pair.faces.iter().for_each(|&face| diagonal[face as usize] += added);
        }
        let times = |x: &[f64]| {
            let mut product: Vec<f64> = diagonal.iter().zip(x).map(|(d, x)| d * x).collect();
            for (pair, weight) in self.pairs.iter().zip(weights) {
                let [a, b] = pair.faces.map(|face| face as usize);
                product[a] += weight * x[b];
                product[b] += weight * x[a];
            }
            product
        };
        let precondition =
            |r: &[f64]| -> Vec<f64> { r.iter().zip(&diagonal).map(|(r, d)| if *d > 0.0 { r / d } else { 0.0 }).collect() };
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let (mut solution, mut rest) = (vec![0.0; count], lacking.to_vec());
        let mut ahead = precondition(&rest);
        let mut direction = ahead.clone();
        let mut size = dot(&rest, &ahead);
        let first = size;
        for _ in 0..GRADIENTS {
            if size <= 1e-28 * first || size.is_nan() {
                break;
            }
            let product = times(&direction);
            let curvature = dot(&direction, &product);
            if curvature <= 0.0 || curvature.is_nan() {
                break;
            }
            let share = size / curvature;
            solution.iter_mut().zip(&direction).for_each(|(solution, d)| *solution += share * d);
            rest.iter_mut().zip(&product).for_each(|(rest, p)| *rest -= share * p);
            ahead = precondition(&rest);
            let next = dot(&rest, &ahead);
            direction.iter_mut().zip(&ahead).for_each(|(direction, a)| *direction = a + next / size * *direction);
            size = next;
        }
        solution
    }
}
