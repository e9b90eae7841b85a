//! Do the oracles agree? Three ways to the same numbers that share no integrand: the enclosure, adaptive cubature, Monte
//! Carlo; and core's second implementation beside them where it is meant to be good. The cubature takes no occluders: with them
//! it gets the visible part of the emitter ([`seen`](crate::measures::seen)), if that is a polygon.
//!
//! The enclosure decides; the others may not contradict it. A contradiction is an error of its own, whichever of the two is
//! wrong: it is reported, never averaged away.

use std::fmt;

use glam::DVec3;
use radgrad_core::{Emitter, Receiver};
use radgrad_oracle::cubature::{self, Status};
use radgrad_oracle::monte_carlo::{self, Limits, Sampling, Sequence};
use radgrad_oracle::{Error, Interval};
use radgrad_paper::appendix;
use radgrad_scene::case::Problem;
use rayon::prelude::*;

use crate::cases::family::{Family, Name};
use crate::measures::measure::{is_worse, ratio, worse};
use crate::measures::run::Run;
use crate::measures::seen::visible_part;
use crate::measures::truth::Truth;

/// Relative tolerance asked of the cubature.
const TOLERANCE: f64 = 1e-7;

/// Evaluations it may spend on a case.
const BUDGET: usize = 200_000;

/// "Converged" with an error of more than so many tolerances is a silent failure: an estimate is no bound, but must not be off
/// by that.
const SILENT: f64 = 10.0;

/// Points that Monte Carlo draws on an emitter.
const SAMPLES: usize = 4000;

/// Confidence of each of its intervals: with a thousand of them in a run, one in a million runs is falsely alarmed.
const CONFIDENCE: f64 = 1.0 - 1e-9;

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

/// Counts of comparisons, and the contradictions.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Agreement {
    /// Cases enclosed.
    pub enclosed: usize,
    /// Of these, converged by cubature.
    pub cubature: usize,
    /// Of these, sampled by Monte Carlo.
    pub monte_carlo: usize,
    /// Of these, answered by the second implementation, where it is meant to be good.
    pub paper: usize,
    /// The disagreements.
    pub contradictions: Vec<Contradiction>,
}

impl Agreement {
    fn merge(mut self, other: Self) -> Self {
        self.enclosed += other.enclosed;
        self.cubature += other.cubature;
        self.monte_carlo += other.monte_carlo;
        self.paper += other.paper;
        self.contradictions.extend(other.contradictions);
        self
    }
}

/// Compares on the first `count` cases of each family of the run; the second implementation may be off by `paper_gate`.
#[must_use]
pub fn agreement(run: &Run, count: u64, paper_gate: f64) -> Agreement {
    let names: Vec<Name> = run.at_most(count).names().collect();
    names.par_iter().map(|&name| compare(name, paper_gate)).reduce(Agreement::default, Agreement::merge)
}

fn compare(case: Name, paper_gate: f64) -> Agreement {
    let mut agreement = Agreement::default();
    let problem = match case.case().problem() {
        Ok(problem) => problem,
        Err(_) if case.family.is_refused() => return agreement,
        Err(error) => {
            agreement.contradictions.push(Contradiction { case, way: "the input", what: error.to_string() });
            return agreement;
        }
    };
    let truth = match Truth::of_problem(&problem) {
        Ok(truth) => truth,
        Err(error) => {
            agreement.contradictions.push(Contradiction { case, way: "no enclosure", what: error.to_string() });
            return agreement;
        }
    };
    agreement.enclosed = 1;
    if is_beyond_doubles(case.family) {
        return agreement;
    }
    let mut contradict = |way, what| agreement.contradictions.push(Contradiction { case, way, what });
    // It integrates over one plane, and the enclosure over the triangles of the vertices as they are.
    let visible = visible_part(&problem).filter(|_| !case.family.is_rounded());
    match visible.map_or(Ok(None), |emitter| by_cubature(&problem.receiver, &emitter)) {
        Ok(Some((radiosity, gradient))) => {
            agreement.cubature = 1;
            let worst = relative_error(&truth, radiosity, gradient);
            if is_worse(worst, SILENT * TOLERANCE) {
                contradict("converged cubature", format!("off by {worst:.1e}, {TOLERANCE:e} asked for"));
            }
        }
        Ok(None) => {}
        Err(error) => contradict("cubature", error.to_string()),
    }
    match by_monte_carlo(&problem, &truth, case) {
        Ok(outside) => {
            agreement.monte_carlo = 1;
            outside.into_iter().for_each(|what| contradict("Monte Carlo", what));
        }
        // Promised: a mean of samples has no finite variance there.
        Err(Error::Touching { .. }) if case.family == Family::InPlaneInside => {}
        Err(error) => contradict("Monte Carlo", error.to_string()),
    }
    if matches!(case.family, Family::Generic | Family::NGon | Family::BackFacing | Family::BelowHorizon)
        && let Ok((radiosity, gradient)) = appendix::radiosity_and_gradient(&problem.receiver, &problem.emitter, None)
    {
        agreement.paper = 1;
        let worst = relative_error(&truth, radiosity, gradient);
        if is_worse(worst, paper_gate) {
            contradict("appendix A", format!("off by {worst:.1e}, {paper_gate:e} allowed"));
        }
    }
    agreement
}

/// Whether products of lengths, or squares of an emission, leave the range of the doubles that cubature and Monte Carlo work in: the
/// enclosure, which has exponents enough, stands alone.
fn is_beyond_doubles(family: Family) -> bool {
    matches!(family, Family::Subnormal | Family::MixedExponents | Family::OtherScale | Family::SteepNormal)
}

/// Value and gradient if the cubature says it converged; to be out of budget, from the start or later, is no disagreement.
fn by_cubature(receiver: &Receiver, emitter: &Emitter) -> Result<Option<(f64, DVec3)>, Error> {
    match cubature::integrate(receiver, emitter, TOLERANCE, BUDGET) {
        Ok(estimate) => Ok((estimate.status == Status::Converged).then_some((estimate.radiosity, estimate.gradient))),
        Err(Error::Evaluations { .. }) => Ok(None),
        Err(error) => Err(error),
    }
}

/// Which interval of Monte Carlo the truth is outside of, if any.
fn by_monte_carlo(problem: &Problem, truth: &Truth, case: Name) -> Result<Option<String>, Error> {
    let sequence = Sequence::Independent { samples: SAMPLES, seed: case.index };
    // The gradient needs the side of an edge on which the emitter is visible; a ray 1e-8 beside the edge decides that, and
    // slivers of this family are narrower. And where an occluder crosses the emitter its line ends the visible part, and that is
    // no edge.
    let quantities = if matches!(case.family, Family::SilhouetteScreen | Family::DippingScreen) { 1 } else { 4 };
    let Problem { receiver, emitter, occluders, .. } = problem;
    let estimate = monte_carlo::integrate(receiver, emitter, occluders, Sampling::SolidAngle, sequence, CONFIDENCE)?;
    let numbers = std::iter::once((&truth.radiosity, estimate.radiosity)).chain(truth.gradient.iter().zip(estimate.gradient));
    let names = ["radiosity", "gradient x", "gradient y", "gradient z"];
    Ok(numbers.zip(names).take(quantities).find_map(|((truth, limits), quantity)| {
        outside(truth, &limits).map(|limits| format!("{quantity} is {:e}, sampled {limits}", truth.to_f64()))
    }))
}

/// The interval that the truth is outside of.
fn outside(truth: &Interval, limits: &Limits) -> Option<String> {
    [("Student", limits.student), ("distribution-free", limits.distribution_free)].into_iter().find_map(|(kind, interval)| {
        let (low, high) = truth.bounds();
        let inside = low <= interval.high && high >= interval.low;
        (!inside).then(|| format!("{:e} to {:e} ({kind})", interval.low, interval.high))
    })
}

/// The larger of the two relative errors.
fn relative_error(truth: &Truth, radiosity: f64, gradient: DVec3) -> f64 {
    let value = ratio(truth.radiosity_error(radiosity), truth.radiosity_magnitude());
    worse(value, ratio(truth.gradient_error(gradient), truth.gradient_magnitude()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_oracles_and_the_second_implementation_agree_on_generic_cases() {
        let run = Run::of_each(8, &[Family::Generic], 1);
        let agreement = agreement(&run, 8, 1e-10);
        assert_eq!(agreement.contradictions, []);
        assert_eq!((agreement.enclosed, agreement.cubature, agreement.monte_carlo, agreement.paper), (8, 8, 8, 8));
    }

    #[test]
    fn every_family_that_has_a_truth_is_asked_of_cubature_and_of_sampling() {
        for family in Family::ALL {
            let run = Run::of_each(4, &[family], 2);
            let agreement = agreement(&run, 4, 1e-10);
            assert_eq!(agreement.contradictions, [], "{family}");
            if is_beyond_doubles(family) {
                assert_eq!((agreement.enclosed, agreement.cubature, agreement.monte_carlo), (4, 0, 0), "{family}");
                continue;
            }
            let touches = family == Family::InPlaneInside;
            assert!(touches || agreement.monte_carlo == agreement.enclosed, "{family}: {agreement:?}");
            let is_seen =
                !family.is_rounded() && family.case(2, 0).problem().is_ok_and(|problem| visible_part(&problem).is_some());
            // An ulp over the surface the integrand is a spike that no adaptive rule finds.
            let is_spike = family == Family::OnSurface;
            assert!(is_spike || agreement.cubature > 0 || agreement.enclosed == 0 || !is_seen, "{family}: {agreement:?}");
        }
    }

    #[test]
    fn a_wrong_truth_is_contradicted_by_cubature_and_by_sampling() {
        let case = Name { family: Family::Generic, seed: 1, index: 0 };
        let problem = case.case().problem().expect("valid");
        let mut truth = Truth::unoccluded(&problem.receiver, &problem.emitter).expect("enclosed");
        truth.radiosity = truth.gradient[0].clone();
        let (radiosity, gradient) = by_cubature(&problem.receiver, &problem.emitter).expect("no error").expect("converged");
        assert!(relative_error(&truth, radiosity, gradient) > 0.1);
        let outside = by_monte_carlo(&problem, &truth, case).expect("sampled").expect("outside");
        assert!(outside.contains("radiosity"), "{outside}");
    }
}
