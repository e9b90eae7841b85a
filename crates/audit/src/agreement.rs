//! Do the oracles agree? Three ways to the same numbers that share no integrand: the enclosure, adaptive cubature, Monte Carlo; and core's
//! second implementation beside them where it is meant to be good.
//!
//! The enclosure decides; the others may not contradict it. A contradiction is an error of its own, whichever of the two is wrong: it is
//! reported, never averaged away.

use std::fmt;

use glam::DVec3;
use radgrad_core::paper;
use radgrad_oracle::cubature::{Status, integrate};
use radgrad_scene::case::Problem;
use rayon::prelude::*;

use crate::family::{Family, Name};
use crate::measure::ratio;
use crate::run::Run;
use crate::truth::Truth;

/// Relative tolerance asked of the cubature.
const TOLERANCE: f64 = 1e-7;

/// Evaluations it may spend on a case.
const BUDGET: usize = 50_000;

/// "Converged" with an error of more than so many tolerances is a silent failure: an estimate is no bound, but must not be off by that.
const SILENT: f64 = 10.0;

/// Two ways that give different numbers for a case.
#[derive(Debug, Clone, PartialEq)]
pub struct Contradiction {
    /// The case.
    pub case: Name,
    /// Which way contradicts the enclosure.
    pub way: &'static str,
    /// How far off it is.
    pub what: String,
}

impl fmt::Display for Contradiction {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} and the enclosure disagree at {}: {}", self.way, self.case, self.what)
    }
}

/// What was compared, and what did not agree.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Agreement {
    /// Cases enclosed.
    pub enclosed: usize,
    /// Of these, converged by cubature.
    pub cubature: usize,
    /// Of these, answered by the second implementation, where it is meant to be good.
    pub paper: usize,
    /// The disagreements.
    pub contradictions: Vec<Contradiction>,
}

impl Agreement {
    fn merge(mut self, other: Self) -> Self {
        self.enclosed += other.enclosed;
        self.cubature += other.cubature;
        self.paper += other.paper;
        self.contradictions.extend(other.contradictions);
        self
    }
}

/// Compares on the first `count` cases of each family of the run; the second implementation may be off by `paper_gate`.
#[must_use]
pub fn agreement(run: &Run, count: u64, paper_gate: f64) -> Agreement {
    let names: Vec<Name> = Run { cases: count.min(run.cases), ..run.clone() }.names().collect();
    names.par_iter().map(|&name| compare(name, paper_gate)).reduce(Agreement::default, Agreement::merge)
}

fn compare(case: Name, paper_gate: f64) -> Agreement {
    let mut agreement = Agreement::default();
    let Ok(problem) = case.case().problem() else { return agreement };
    let Ok(truth) = Truth::of(&problem.receiver, &problem.emitter) else { return agreement };
    agreement.enclosed = 1;
    let mut contradict = |way, what| agreement.contradictions.push(Contradiction { case, way, what });
    match by_cubature(&problem) {
        Ok(Some((radiosity, gradient))) => {
            agreement.cubature = 1;
            let worst = relative_error(&truth, radiosity, gradient);
            if worst > SILENT * TOLERANCE {
                contradict("converged cubature", format!("off by {worst:.1e}, {TOLERANCE:e} asked for"));
            }
        }
        Ok(None) => {}
        Err(why) => contradict("cubature", why),
    }
    if matches!(case.family, Family::Generic | Family::NGon | Family::BackFacing | Family::BelowHorizon)
        && let Ok((radiosity, gradient)) = paper::radiosity_and_gradient(&problem.receiver, &problem.emitter, None)
    {
        agreement.paper = 1;
        let worst = relative_error(&truth, radiosity, gradient);
        if worst > paper_gate {
            contradict("appendix A", format!("off by {worst:.1e}, {paper_gate:e} allowed"));
        }
    }
    agreement
}

/// Value and gradient if the cubature says it converged.
fn by_cubature(problem: &Problem) -> Result<Option<(f64, DVec3)>, String> {
    let estimate = integrate(&problem.receiver, &problem.emitter, TOLERANCE, BUDGET).map_err(|error| error.to_string())?;
    Ok((estimate.status == Status::Converged).then_some((estimate.radiosity, estimate.gradient)))
}

/// The larger of the two relative errors.
fn relative_error(truth: &Truth, radiosity: f64, gradient: DVec3) -> f64 {
    let value = ratio(truth.radiosity_error(radiosity), truth.radiosity_magnitude());
    value.max(ratio(truth.gradient_error(gradient), truth.gradient_magnitude()))
}
