//! Factors, intervals and errors that the counts of rays make.

use radgrad_scene::{Counted, FactorMatrix, FormFactors, RayFactors, RayRow, RaySettings, Scene, largest, smallest};

/// The relative difference of factors whose multipliers are found in two ways, each until rows close to 1e-9.
pub(super) const SAME: f64 = 1e-6;

/// The same of numbers that follow from the counts in a few roundings.
pub(super) const ROUNDED: f64 = 1e-9;

/// The ratio of areas up to which both ways of a pair count.
const ALIKE: f64 = 2.4;

/// Multipliers beyond these are no matter of chance.
const RANGE: [f64; 2] = [0.5, 2.0];

/// A scene with the counts of its rays.
pub(super) struct Counts<'a> {
    pub(super) scene: &'a Scene,
    pub(super) factors: &'a FormFactors<'a>,
    pub(super) settings: RaySettings,
    pub(super) counted: Vec<Counted>,
    pub(super) truth: FactorMatrix,
}

/// A pair that rays counted.
#[derive(Debug, Clone, Copy)]
pub(super) struct Pair {
    faces: [usize; 2],
    hits: f64,
    trials: f64,
    /// The area that one hit stands for.
    weight: f64,
}

/// The counts of a scene by pairs, and the multipliers that close its rows.
pub(super) struct Model {
    pub(super) areas: Vec<f64>,
    pub(super) rays: f64,
    pub(super) logarithm: f64,
    /// `ln(2/delta)` of each of the sums of a product: two a face, one of either sign.
    of_sums: f64,
    pub(super) pairs: Vec<Pair>,
    /// Exchanges that are not by rays, with their errors, by the faces.
    pub(super) near: Vec<([usize; 2], [f64; 2])>,
    /// Rays that met nothing.
    open: Vec<f64>,
    pub(super) scale: Vec<f64>,
    least: f64,
}

/// `ln(2/delta)` of each of the intervals of so many faces.
pub(super) fn logarithm(faces: usize, confidence: f64) -> f64 {
    ((faces * (faces + 1)) as f64 / (1.0 - confidence)).ln()
}

/// The limit of a factor of which no ray tells: `(1 - p)^n = delta/2` of one way, or of both ways of faces that are alike.
pub(super) fn absent(rays: f64, logarithm: f64) -> f64 {
    let none = |trials: f64| -(-logarithm / trials).exp_m1();
    largest(none(rays), 2.0 * ALIKE / (1.0 + ALIKE) * none(2.0 * rays))
}

/// The probabilities p at which `q ln(q/p) + (1 - q) ln((1 - q)/(1 - p))` is so large, below and above q.
fn limits(hits: f64, trials: f64, logarithm: f64) -> [f64; 2] {
    let q = hits / trials;
    let term = |q: f64, p: f64| if q > 0.0 { q * (q / p).ln() } else { 0.0 };
    let cost = |p: f64| trials * (term(q, p) + term(1.0 - q, 1.0 - p));
    [0.0, 1.0].map(|end| between(q, end, |p| cost(p) > logarithm))
}

/// How far a sum of independent numbers from 0 to 1 may be off its mean m: `m - s + s ln(s/m)` is the logarithm.
fn deviation(sum: f64, logarithm: f64) -> f64 {
    let cost = |mean: f64| mean - sum + if sum > 0.0 { sum * (sum / mean).ln() } else { 0.0 };
    let far = 4.0 * (sum + logarithm) + 4.0;
    let [low, high] = [0.0, far].map(|end| between(sum, end, |mean| cost(mean) > logarithm));
    largest(high - sum, sum - low)
}

/// Where a condition begins to hold between two numbers; the second one if it holds nowhere.
fn between(from: f64, to: f64, holds: impl Fn(f64) -> bool) -> f64 {
    let (mut inside, mut outside) = (from, to);
    for _ in 0..200 {
        let middle = 0.5 * (inside + outside);
        *if holds(middle) { &mut outside } else { &mut inside } = middle;
    }
    outside
}

impl Model {
    /// Of the counts, without pairs that are exact by the rows and those of which both factors are below `least`.
    pub(super) fn new(asked: &Counts<'_>, rows: &[RayRow], least: f64) -> Result<Self, String> {
        let areas = asked.truth.areas().to_vec();
        let rays = asked.settings.rays_for(rows.len()).map_err(|error| error.to_string())? as f64;
        let near: Vec<([usize; 2], [f64; 2])> = rows
            .iter()
            .flat_map(|row| row.entries.iter().map(move |entry| (row.face, entry)))
            .filter(|(face, entry)| entry.is_exact && *face < entry.face)
            .map(|(face, entry)| ([face, entry.face], [entry.factor, entry.upper - entry.factor].map(|part| part * areas[face])))
            .collect();
        let mut hits = vec![vec![0.0; areas.len()]; areas.len()];
        let mut open = vec![rays; areas.len()];
        for row in &asked.counted {
            let text = serde_json::to_string(row).map_err(|error| error.to_string())?;
            let (face, met) = listed(&text)?;
            for (other, count) in met {
                hits[face][other] = count;
                open[face] -= count;
            }
        }
        let is_near = |i: usize, j: usize| near.iter().any(|(faces, _)| *faces == [i, j]);
        let mut pairs = Vec::new();
        for (i, j) in (0..areas.len()).flat_map(|i| (i + 1..areas.len()).map(move |j| (i, j))) {
            let [a, b] = [areas[i], areas[j]];
            let (trials, count, weight) = if largest(a, b) <= ALIKE * smallest(a, b) {
                (2.0 * rays, hits[i][j] + hits[j][i], 1.0 / (rays / a + rays / b))
            } else if a < b {
                (rays, hits[i][j], a / rays)
            } else {
                (rays, hits[j][i], b / rays)
            };
            if count > 0.0 && count * weight >= least * smallest(a, b) && !is_near(i, j) {
                pairs.push(Pair { faces: [i, j], hits: count, trials, weight });
            }
        }
        let mut model = Self {
            scale: vec![1.0; areas.len()],
            logarithm: logarithm(rows.len(), asked.settings.confidence),
            of_sums: (4.0 * areas.len() as f64 / (1.0 - asked.settings.confidence)).ln(),
            areas,
            rays,
            pairs,
            near,
            open,
            least,
        };
        model.close();
        Ok(model)
    }

    /// The multipliers, each by its own row, one face after the other, until nothing moves; then no row is above 1.
    fn close(&mut self) {
        let count = self.areas.len();
        let mut residual = self.areas.clone();
        for ([i, j], [area, _]) in &self.near {
            residual[*i] -= area;
            residual[*j] -= area;
        }
        let mut exchanges = vec![Vec::new(); count];
        for Pair { faces: [i, j], hits, weight, .. } in &self.pairs {
            exchanges[*i].push((*j, hits * weight));
            exchanges[*j].push((*i, hits * weight));
        }
        let taken = |scale: &[f64], i: usize| exchanges[i].iter().map(|(j, area)| area * scale[*j]).sum::<f64>();
        for _ in 0..400 {
            for (i, residual) in residual.iter().enumerate() {
                let whole = taken(&self.scale, i) + self.open[i] * self.areas[i] / self.rays;
                if whole > 0.0 {
                    self.scale[i] = (largest(*residual, 0.0) / whole).clamp(RANGE[0], RANGE[1]);
                }
            }
        }
        let excess = |i: usize| {
            let whole = self.scale[i] * taken(&self.scale, i);
            if whole > largest(residual[i], 0.0) { largest(residual[i], 0.0) / whole } else { 1.0 }
        };
        self.scale = (0..count).map(|i| self.scale[i] * excess(i)).collect();
    }

    /// Rows that differ from what the counts make, and totals of them.
    pub(super) fn differences(&self, factors: &RayFactors, rows: &[RayRow]) -> Vec<String> {
        let mut findings = Vec::new();
        let mut hold = |what: &dyn Fn() -> String, value: f64, expected: f64, most: f64| {
            let is_same = (value - expected).abs() <= most * expected.abs() + 1e-12;
            if !is_same {
                findings.push(format!("{} is {value:e}, by the counts {expected:e}", what()));
            }
        };
        let mut pairs = vec![None; self.areas.len() * self.areas.len()];
        for pair in &self.pairs {
            let [i, j] = pair.faces;
            pairs[i * self.areas.len() + j] = Some(pair);
            pairs[j * self.areas.len() + i] = Some(pair);
        }
        let (mut by_rays, mut exact) = (0, 0);
        for RayRow { face, entries, open } in rows {
            let i = *face;
            for entry in entries {
                let j = entry.face;
                exact += usize::from(entry.is_exact);
                if entry.is_exact {
                    continue;
                }
                by_rays += 1;
                let Some(pair) = pairs[i * self.areas.len() + j] else {
                    hold(&|| format!("the factor {i} to {j}"), entry.factor, 0.0, 0.0);
                    continue;
                };
                let unit = pair.trials * pair.weight / self.areas[i];
                let factor = pair.hits * pair.weight * self.scale[i] * self.scale[j] / self.areas[i];
                let [low, high] = limits(pair.hits, pair.trials, self.logarithm).map(|share| share * unit);
                let high = smallest(high, smallest(1.0, self.areas[j] / self.areas[i]));
                hold(&|| format!("the factor {i} to {j}"), entry.factor, factor, SAME);
                hold(&|| format!("the lower end {i} to {j}"), entry.lower, smallest(low, entry.factor), ROUNDED);
                hold(&|| format!("the upper end {i} to {j}"), entry.upper, largest(high, entry.factor), ROUNDED);
            }
            let sum: f64 = entries.iter().map(|entry| entry.factor).sum();
            hold(&|| format!("the open share of {i}"), open.factor, largest(1.0 - sum, 0.0), ROUNDED);
            hold(&|| format!("the open share of {i} by itself"), factors.open(i), open.factor, SAME);
            let [low, high] = limits(self.open[i], self.rays, self.logarithm);
            hold(&|| format!("the lower end of the open share of {i}"), open.lower, smallest(low, open.factor), ROUNDED);
            hold(&|| format!("the upper end of the open share of {i}"), open.upper, largest(high, open.factor), ROUNDED);
        }
        hold(&|| "the number of factors by rays".to_owned(), f64::from(by_rays), 2.0 * self.pairs.len() as f64, 0.0);
        hold(&|| "the number of exact factors".to_owned(), factors.exact() as f64, exact as f64, 0.0);
        let stored = 2 * (self.pairs.len() + self.near.len());
        hold(&|| "the number of factors".to_owned(), factors.stored() as f64, stored as f64, 0.0);
        let missing = largest(absent(self.rays, self.logarithm), self.least);
        hold(&|| "the limit of other factors".to_owned(), factors.absent(), missing, ROUNDED);
        findings
    }

    /// The product of the counted pairs as they were counted.
    pub(super) fn plain(&self, q: &[f64]) -> Vec<f64> {
        let mut sums = vec![0.0; q.len()];
        for Pair { faces: [i, j], hits, weight, .. } in &self.pairs {
            sums[*i] += hits * weight * q[*j] / self.areas[*i];
            sums[*j] += hits * weight * q[*i] / self.areas[*j];
        }
        sums
    }

    /// How far the multipliers move a product of numbers not below 0: `x_i |x_j - 1| + |x_i - 1| x_j` of each pair at most, one of the two
    /// without its multiplier.
    pub(super) fn moved(&self, q: &[f64]) -> Vec<f64> {
        let mut sums = vec![0.0; q.len()];
        let x = &self.scale;
        for Pair { faces, hits, weight, .. } in &self.pairs {
            for [i, j] in [*faces, [faces[1], faces[0]]] {
                let change = (x[i] - 1.0).abs() * x[j] + (x[j] - 1.0).abs();
                sums[i] += hits * weight * q[j] * change / self.areas[i];
            }
        }
        sums
    }

    /// How far the bounds of exact pairs move a product.
    pub(super) fn near_errors(&self, q: &[f64]) -> Vec<f64> {
        let mut sums = vec![0.0; q.len()];
        for ([i, j], [_, error]) in &self.near {
            sums[*i] += error * q[*j].abs() / self.areas[*i];
            sums[*j] += error * q[*i].abs() / self.areas[*j];
        }
        sums
    }

    /// How far a sum over the rays of numbers up to `most` may be off.
    pub(super) fn deviation(&self, sum: f64, most: f64) -> f64 {
        let one = most / self.rays;
        one * deviation(sum / one, self.of_sums)
    }
}

/// A face, and the faces that its rays met with how often, of the text that is kept.
fn listed(text: &str) -> Result<(usize, Vec<(usize, f64)>), String> {
    #[derive(serde::Deserialize)]
    struct Row {
        face: usize,
        met: Vec<(usize, f64)>,
    }
    serde_json::from_str::<Row>(text).map(|row| (row.face, row.met)).map_err(|error| error.to_string())
}
