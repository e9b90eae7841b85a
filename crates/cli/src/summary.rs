//! The result in one JSON object.

use std::collections::BTreeMap;
use std::fmt;

use radgrad_scene::{Modelling, printable};
use radgrad_solver::{Ledger, Solution};
use serde::Serialize;

/// The output of `--summary`.
#[derive(Debug, Serialize)]
pub(crate) struct Summary {
    /// From the start of reading to the end of solving.
    seconds: f64,
    rounds: usize,
    elements: usize,
    links: usize,
    /// Proven bound on the error of the mean over the mean radiosity that is reflected, the largest of the channels.
    bound: f64,
    /// Estimate of the same.
    estimate: f64,
    /// The estimate asked for.
    error: f64,
    /// The bound asked for in its place.
    #[serde(skip)]
    at_most: Option<f64>,
    /// That bound by its sources; the sum is `bound`.
    ledger: BTreeMap<&'static str, f64>,
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
    bound: f64,
    estimate: f64,
    ledger: BTreeMap<&'static str, f64>,
}

impl Summary {
    pub(crate) fn of(solution: &Solution, modelling: Modelling, error: f64, at_most: Option<f64>, seconds: f64) -> Self {
        let progress = solution.progress();
        let bounds = solution.mean_bound();
        let estimates = solution.mean_estimate();
        let channel = |(index, name): (usize, &String)| Channel {
            name: name.clone(),
            mean: solution.mean()[index],
            reflected: solution.reflected()[index],
            bound: bounds[index].total(),
            estimate: estimates[index].total(),
            ledger: entries(&bounds[index], 1.0),
        };
        let channels: Vec<Channel> = solution.channels().iter().enumerate().map(channel).collect();
        let lit = bounds.iter().zip(solution.relative_to()).filter(|(_, mean)| *mean > 0.0);
        let worst = lit.max_by(|a, b| (a.0.total() / a.1).total_cmp(&(b.0.total() / b.1)));
        let (ledger, mean) = worst.map_or((Ledger::default(), 1.0), |(ledger, mean)| (*ledger, mean));
        Self {
            seconds,
            rounds: progress.round,
            elements: progress.elements,
            links: progress.links,
            bound: progress.bound,
            estimate: progress.estimate,
            error,
            at_most,
            ledger: entries(&ledger, mean),
            channels,
            modelling,
            warnings: solution.warnings().iter().map(ToString::to_string).collect(),
        }
    }
}

impl fmt::Display for Summary {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { seconds, rounds, elements, links, bound, estimate, error, at_most, .. } = self;
        writeln!(f, "{elements} elements, {links} links, {rounds} rounds, {seconds:.3} s")?;
        let asked = at_most.unwrap_or(*error);
        let [estimate, bound, asked] = [*estimate, *bound, asked].map(|share| 100.0 * share);
        let what = if at_most.is_some() { "a bound" } else { "an estimate" };
        let proven = if bound.is_finite() { format!("proven at most {bound:.3} %") } else { "nothing proven".to_owned() };
        writeln!(f, "error of the mean: estimated {estimate:.3} %, {proven}; {what} of {asked:.3} % asked for\n")?;
        let names = || self.channels.iter().map(|channel| printable(&channel.name));
        let width = names().map(|name| name.chars().count()).max().unwrap_or(0).max("channel".len());
        writeln!(f, "{:width$}  {:>14}  {:>14}  {:>14}", "channel", "mean", "estimate", "bound")?;
        for (name, channel) in names().zip(&self.channels) {
            writeln!(f, "{name:width$}  {:>14.6e}  {:>14.6e}  {:>14.6e}", channel.mean, channel.estimate, channel.bound)?;
        }
        writeln!(f, "\n{:15}  {:>14}", "of the bound", "% of the mean")?;
        self.ledger.iter().try_for_each(|(source, share)| writeln!(f, "{source:15}  {:>14.6}", 100.0 * share))
    }
}

fn entries(ledger: &Ledger, unit: f64) -> BTreeMap<&'static str, f64> {
    Ledger::NAMES.into_iter().zip(ledger.entries().map(|entry| entry / unit)).collect()
}
