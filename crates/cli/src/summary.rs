//! The result in one JSON object.

use std::fmt;

use radgrad_scene::{Modelling, printable};
use radgrad_solver::Solution;
use serde::Serialize;

/// The output of `--summary`.
#[derive(Debug, Serialize)]
pub(crate) struct Summary {
    /// From the start of reading to the end of solving.
    seconds: f64,
    rounds: usize,
    elements: usize,
    links: usize,
    /// Estimate of the error of the mean over the mean radiosity that is reflected, the largest of the channels.
    estimate: f64,
    /// The estimate asked for.
    error: f64,
    /// In the unit of the scene.
    channels: Vec<Channel>,
    /// The rounding of the scene's coordinates, and what reading changed for it.
    modelling: Modelling,
    /// Properties of the scene that are probably not meant.
    warnings: Vec<String>,
}

#[derive(Debug, Serialize)]
struct Channel {
    name: String,
    /// Over all area, with the emission of faces.
    mean: f64,
    /// The part of it that is reflected.
    reflected: f64,
    estimate: f64,
}

impl Summary {
    pub(crate) fn of(solution: &Solution, modelling: Modelling, error: f64, seconds: f64) -> Self {
        let progress = solution.progress();
        let estimates = solution.mean_estimate();
        let channel = |(index, name): (usize, &String)| Channel {
            name: name.clone(),
            mean: solution.mean()[index],
            reflected: solution.reflected()[index],
            estimate: estimates[index].total(),
        };
        let channels: Vec<Channel> = solution.channels().iter().enumerate().map(channel).collect();
        Self {
            seconds,
            rounds: progress.round,
            elements: progress.elements,
            links: progress.links,
            estimate: progress.estimate,
            error,
            channels,
            modelling,
            warnings: solution.warnings().iter().map(ToString::to_string).collect(),
        }
    }
}

impl fmt::Display for Summary {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { seconds, rounds, elements, links, estimate, error, .. } = self;
        writeln!(f, "{elements} elements, {links} links, {rounds} rounds, {seconds:.3} s")?;
        let [estimate, error] = [*estimate, *error].map(|share| 100.0 * share);
        writeln!(f, "error of the mean: estimated {estimate:.3} %; {error:.3} % asked for\n")?;
        let names = || self.channels.iter().map(|channel| printable(&channel.name));
        let width = names().map(|name| name.chars().count()).max().unwrap_or(0).max("channel".len());
        writeln!(f, "{:width$}  {:>14}  {:>14}", "channel", "mean", "estimate")?;
        names()
            .zip(&self.channels)
            .try_for_each(|(name, Channel { mean, estimate, .. })| writeln!(f, "{name:width$}  {mean:>14.6e}  {estimate:>14.6e}"))
    }
}
