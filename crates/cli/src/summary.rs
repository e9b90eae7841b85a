//! The result in one JSON object.

use std::collections::BTreeMap;

use radgrad_solver::{Ledger, Solution};
use serde::Serialize;

/// What `--summary` prints.
#[derive(Debug, Serialize)]
pub(crate) struct Summary {
    /// From the start of reading to the end of solving.
    seconds: f64,
    rounds: usize,
    elements: usize,
    links: usize,
    /// Proven bound on the mean error over the mean radiosity, the largest of the channels.
    bound: f64,
    /// Estimate of the same.
    estimate: f64,
    /// What was asked for.
    error: f64,
    /// That bound by its sources; the sum is `bound`.
    ledger: BTreeMap<&'static str, f64>,
    /// In the unit of the scene.
    channels: Vec<Channel>,
}

#[derive(Debug, Serialize)]
struct Channel {
    name: String,
    mean: f64,
    bound: f64,
    estimate: f64,
    ledger: BTreeMap<&'static str, f64>,
}

impl Summary {
    pub(crate) fn of(solution: &Solution, error: f64, seconds: f64) -> Self {
        let progress = solution.progress();
        let bounds = solution.mean_bound();
        let estimates = solution.mean_estimate();
        let channel = |(((name, &mean), ledger), estimate): (((&String, &f64), &Ledger), &Ledger)| Channel {
            name: name.clone(),
            mean,
            bound: ledger.total(),
            estimate: estimate.total(),
            ledger: entries(ledger, 1.0),
        };
        let channels: Vec<Channel> =
            solution.channels().iter().zip(solution.mean()).zip(&bounds).zip(&estimates).map(channel).collect();
        let lit = bounds.iter().zip(solution.mean()).filter(|(_, mean)| **mean > 0.0);
        let worst = lit.max_by(|a, b| (a.0.total() / a.1).total_cmp(&(b.0.total() / b.1)));
        let (ledger, mean) = worst.map_or((Ledger::default(), 1.0), |(ledger, mean)| (*ledger, *mean));
        Self {
            seconds,
            rounds: progress.round,
            elements: progress.elements,
            links: progress.links,
            bound: progress.bound,
            estimate: progress.estimate,
            error,
            ledger: entries(&ledger, mean),
            channels,
        }
    }
}

fn entries(ledger: &Ledger, unit: f64) -> BTreeMap<&'static str, f64> {
    Ledger::NAMES.into_iter().zip(ledger.entries().map(|entry| entry / unit)).collect()
}
