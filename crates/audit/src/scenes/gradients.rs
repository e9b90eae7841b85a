//! Gradients at the points of scenes, as `radgrad solve --points` finds them by default, against exact slopes or central differences of a
//! finer solution that serves these points.
//!
//! No bound is stated of them, so that nothing is broken or held here: the figures are the error over the length of the true gradient, and
//! the estimate over the error. Differences share the solver's gathers but not its gradients; slopes of two rectangles that face each other
//! share nothing ([`radgrad_oracle::scene::known`]). Of points where light is even nothing is asked. A truth is **rough** where the finer
//! solution does not know the gradient well itself by its estimate, or differences by two steps are not the same: a kink has no gradient.

use std::collections::BTreeMap;
use std::io::Write;
use std::time::Duration;

use glam::DVec3;
use radgrad_solver::{GradientRounds, Options, Solution, solve, solve_for};

use super::family::{Family, Name};
use super::model::{Exact, Expected, Model, Part, Probe};
use super::table::{median, write_rows};

/// The part of its length that a gradient is asked to be known to.
pub const WITHIN: f64 = 0.01;

/// Elements above which nothing is divided, in an answer and in a truth: effort is counted and not timed, so that the result
/// depends on the scene alone.
const MOST_ELEMENTS: usize = 3000;

/// Error asked of a truth, and the part of its length that the estimate of a true gradient is within where it is not rough.
const TRUE: f64 = 1e-5;
const ROUGH: f64 = 0.5 * WITHIN;

/// Steps of differences over the extent of the scene, and the largest difference of the results by the two, over their length.
const STEPS: [f64; 2] = [1e-5, 2e-5];
const SMOOTH: f64 = 0.1 * WITHIN;

/// Points of a scene beside those that are drawn with it: one solution answers all.
const MORE: usize = 9;

/// The gradient times the extent over the irradiance below which light is even.
const EVEN: f64 = 1e-3;

/// The error over the length below which an estimate is held against nothing: it knows rounding only to a bound.
const EXACT: f64 = 1e-6;

/// A gradient of the irradiance at a probe in a channel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Slope {
    /// Index of the probe.
    pub probe: usize,
    /// Channel.
    pub channel: usize,
    /// As it is stated.
    pub gradient: DVec3,
    /// The estimate of the length of its error.
    pub estimate: f64,
    /// The truth.
    pub truth: DVec3,
}

impl Slope {
    /// Length of the error over that of the truth.
    #[must_use]
    pub fn error(&self) -> f64 {
        (self.gradient - self.truth).length() / self.truth.length()
    }

    /// Whether the error is within [`WITHIN`]; one that is no number is not.
    #[must_use]
    pub fn is_within(&self) -> bool {
        self.error() <= WITHIN
    }

    /// The estimate over the error.
    #[must_use]
    pub fn estimate_over_error(&self) -> f64 {
        self.estimate / (self.gradient - self.truth).length()
    }
}

/// The gradients at the probes of a scene where light is not even, and how many have a truth that is too rough.
///
/// # Errors
/// If the solver refuses the scene or a point: why.
pub fn slopes(model: &Model) -> Result<(Vec<Slope>, u64), String> {
    if matches!(model.exact, Exact::Even(_)) {
        return Ok((Vec::new(), 0));
    }
    let scene = model.scene().map_err(|error| error.to_string())?;
    let asked = model.asked().map_err(|error| error.to_string())?;
    let (low, high) = scene.bounds().ok_or("no faces")?;
    let extent = (high - low).length();
    let options = Options { most_elements: MOST_ELEMENTS, ..Options::default() };
    let mut rounds = GradientRounds::new(&asked, WITHIN, options.error, Duration::MAX);
    let beyond = Options { error: rounds.error(), ..options };
    let stated = solve(&scene, &beyond, |solution| rounds.next(solution)).map_err(|error| error.to_string())?;
    let truths: Vec<Vec<Option<DVec3>>> = match &model.exact {
        Exact::Facing(rectangles) => {
            let exact = rectangles.slopes(&model.probes.iter().map(Probe::on_a_rectangle).collect::<Vec<_>>());
            exact.into_iter().map(|[x, y]| vec![Some(DVec3::new(x, y, 0.0))]).collect()
        }
        Exact::Nothing | Exact::Even(_) => {
            let finer = solve_for(&scene, &Options { error: TRUE, ..options }, &[], &asked, |_| true);
            let finer = finer.map_err(|error| error.to_string())?;
            asked.iter().map(|&point| differences(&finer, point, extent)).collect::<Result<_, String>>()?
        }
    };
    let (mut slopes, mut rough) = (Vec::new(), 0);
    for ((probe, &(at, normal)), truths) in asked.iter().enumerate().zip(truths) {
        let gradient = stated.gradient(at, normal).map_err(|error| error.to_string())?.irradiance;
        let irradiance = stated.gather(at, normal).map_err(|error| error.to_string())?.irradiance.irradiance;
        for (channel, truth) in truths.into_iter().enumerate() {
            match truth {
                None => rough += 1,
                Some(truth) if truth.length() * extent <= EVEN * irradiance[channel] => {}
                Some(truth) => {
                    let (gradient, estimate) = (gradient.gradient[channel], gradient.estimate[channel]);
                    slopes.push(Slope { probe, channel, gradient, estimate, truth });
                }
            }
        }
    }
    Ok((slopes, rough))
}

/// Points in the first triangles of faces, by the additive recurrence of the plastic number, one face after another; of faces that reflect,
/// since the solver serves no others.
fn more(model: &Model) -> Vec<Probe> {
    // A part of the first triangle is a part of the face where that is convex.
    let is_asked = |part: &Part| part.corners.len() <= 4 && part.reflectance.iter().all(|rho| *rho > 0.0);
    let parts: Vec<usize> = (0..model.parts.len()).filter(|&part| is_asked(&model.parts[part])).collect();
    let place = |k: usize| {
        let part = parts[(k * parts.len() + parts.len() / 2) / MORE];
        let [s, t] = [0.754_877_666_246_692_7, 0.569_840_290_998_053_2].map(|step: f64| (step * (k as f64 + 0.5)).fract());
        let [s, t] = if s + t > 1.0 { [1.0 - s, 1.0 - t] } else { [s, t] };
        let corners = &model.parts[part].corners;
        Probe { part, position: corners[0] + (corners[1] - corners[0]) * s + (corners[2] - corners[0]) * t }
    };
    if parts.is_empty() { Vec::new() } else { (0..MORE).map(place).collect() }
}

/// In each channel the central differences of a solution's irradiance at a point by the shorter step; none where they are rough.
fn differences(solution: &Solution, (at, normal): (DVec3, DVec3), extent: f64) -> Result<Vec<Option<DVec3>>, String> {
    let stated = solution.gradient(at, normal).map_err(|error| error.to_string())?.irradiance;
    let u = normal.any_orthonormal_vector();
    let gather = |place: DVec3| solution.gather(place, normal).map(|found| found.irradiance.irradiance);
    let mut by_step = Vec::new();
    for step in STEPS {
        let mut sums = vec![DVec3::ZERO; stated.gradient.len()];
        for way in [u, normal.cross(u)].map(|way| way * (step * extent)) {
            // Beyond the edge of a face there is nothing to see.
            let (Ok(after), Ok(before)) = (gather(at + way), gather(at - way)) else { return Ok(vec![None; sums.len()]) };
            let rise = after.iter().zip(before).map(|(after, before)| (after - before) / (2.0 * way.length_squared()));
            sums.iter_mut().zip(rise).for_each(|(sum, rise)| *sum += way * rise);
        }
        by_step.push(sums);
    }
    let truth = |channel: usize| {
        let [near, far] = [&by_step[0], &by_step[1]].map(|sums| sums[channel]);
        let is_known = stated.estimate[channel] <= ROUGH * near.length() && (near - far).length() <= SMOOTH * near.length();
        // Even light is known to be even without that.
        let is_even = (near.length() + stated.estimate[channel]) * extent <= EVEN * solution.mean()[channel];
        (is_known || is_even).then_some(near)
    };
    Ok((0..stated.gradient.len()).map(truth).collect())
}

/// The gradients of a family.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Row {
    /// Scenes.
    pub scenes: u64,
    /// Scenes that were refused.
    pub refused: u64,
    /// Gradients whose truth is too rough.
    pub rough: u64,
    /// Errors over the lengths of true gradients.
    pub errors: Vec<f64>,
    /// Estimates over errors, of gradients that are not exact.
    pub estimates: Vec<f64>,
}

impl Row {
    /// The gradients that are within [`WITHIN`].
    #[must_use]
    pub fn within(&self) -> usize {
        self.errors.iter().filter(|error| **error <= WITHIN).count()
    }
}

/// The gradients of many scenes.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Gradients {
    /// By family.
    pub rows: BTreeMap<Family, Row>,
    /// Those that are not within [`WITHIN`].
    pub beyond: Vec<(Name, Slope)>,
    /// Scenes that must have an answer and have none, and why.
    pub failed: Vec<(Name, String)>,
}

impl Gradients {
    /// Of so many scenes, shared among the families. `done` is called after each.
    pub fn measure(families: &[Family], scenes: u64, seed: u64, done: impl Fn(Name)) -> Self {
        let each = scenes.div_ceil(families.len().max(1) as u64);
        let mut gradients = Self::default();
        for name in (0..each).flat_map(|index| families.iter().map(move |&family| Name { family, seed, index })) {
            let row = gradients.rows.entry(name.family).or_default();
            row.scenes += 1;
            let mut model = name.model();
            model.probes.extend(more(&model));
            match slopes(&model) {
                Ok((slopes, rough)) => {
                    row.rough += rough;
                    row.errors.extend(slopes.iter().map(Slope::error));
                    let inexact = slopes.iter().filter(|slope| slope.error() > EXACT);
                    row.estimates.extend(inexact.map(Slope::estimate_over_error));
                    gradients.beyond.extend(slopes.iter().filter(|slope| !slope.is_within()).map(|&slope| (name, slope)));
                }
                Err(why) => {
                    row.refused += 1;
                    if model.expected == Expected::Answer {
                        gradients.failed.push((name, why));
                    }
                }
            }
            done(name);
        }
        gradients
    }

    /// The gradients that have a truth.
    #[must_use]
    pub fn count(&self) -> usize {
        self.rows.values().map(|row| row.errors.len()).sum()
    }

    /// The share of all gradients that have a truth, where light is not even.
    #[must_use]
    pub fn share_judged(&self) -> f64 {
        let rough: u64 = self.rows.values().map(|row| row.rough).sum();
        self.count() as f64 / (self.count() as f64 + rough as f64)
    }

    /// The share of those with a truth that is within [`WITHIN`].
    #[must_use]
    pub fn share_within(&self) -> f64 {
        self.rows.values().map(Row::within).sum::<usize>() as f64 / self.count() as f64
    }

    /// The median of estimates over errors.
    #[must_use]
    pub fn median_estimate(&self) -> Option<f64> {
        median(&self.rows.values().flat_map(|row| row.estimates.iter().copied()).collect::<Vec<_>>())
    }

    /// The rows as CSV.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn write(&self, out: impl Write) -> Result<(), csv::Error> {
        write_rows(out, &HEADER, self.rows.iter().map(|(family, row)| row.cells(*family)))
    }
}

/// Columns of the table.
pub const HEADER: [&str; 8] =
    ["family", "scenes", "refused", "rough", "gradients", "within_1_percent", "median_error", "median_estimate_over_error"];

impl Row {
    /// As a row of the table.
    #[must_use]
    pub fn cells(&self, family: Family) -> Vec<String> {
        let counts = [self.scenes, self.refused, self.rough].map(|count| count.to_string());
        let judged = [self.errors.len(), self.within()].map(|count| count.to_string());
        let figures =
            [&self.errors, &self.estimates].map(|values| median(values).map_or_else(String::new, |m| format!("{m:.1e}")));
        [family.name().to_owned()].into_iter().chain(counts).chain(judged).chain(figures).collect()
    }
}

#[cfg(test)]
mod tests {
    use radgrad_scene::largest;

    use super::*;

    #[test]
    fn gradients_between_rectangles_are_their_exact_slopes() {
        let gradients = Gradients::measure(&[Family::Facing, Family::Strips], 2, 3, |_| ());
        assert!(gradients.count() >= 16, "{:?}", gradients.rows);
        let worst = gradients.rows.values().flat_map(|row| &row.errors).copied().fold(0.0, largest);
        assert!(worst <= 1e-3, "{worst}");
    }
}
