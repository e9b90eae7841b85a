//! The methods, each with its settings from coarse to fine.

use std::error::Error;

use radgrad_core::{DVec3, Emission, PreciseAnswer, Receiver, evaluate_digits, evaluate_to};
use radgrad_oracle::SourceFunction;
use radgrad_oracle::cubature::{Form, Status, integrate_form};
use radgrad_oracle::monte_carlo::{self, Sampling, Sequence};

use super::output::Output;
use super::regime::Case;
use super::{area_rule, contour_rule, lambert, lanes, legendre};

/// A way to radiosity and gradient.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Method {
    /// The plain closed form.
    ClosedForm,
    /// The ladder, to tolerances.
    Certified,
    /// The closed form on lanes, many receivers together.
    BatchDouble,
    /// The same with bounds, to tolerances.
    BatchCertified,
    /// The same in single precision.
    BatchSingle,
    /// The closed form to many digits.
    Digits,
    /// Forward dual numbers through the bare Lambert sum (constant emitters only).
    DualNumbers,
    /// Central differences of the closed form, over the step.
    CentralDifferences,
    /// A Gauss rule on each edge.
    ContourRule,
    /// A product Gauss rule on the area.
    AreaRule,
    /// Adaptive quadrature of the contour form (and of the area where the emission varies).
    AdaptiveContour,
    /// Adaptive cubature of Eq. 1 over the area.
    AdaptiveArea,
    /// Scrambled Sobol points by solid angle.
    QuasiMonteCarlo,
    /// Independent points by solid angle.
    MonteCarlo,
}

impl Method {
    /// All, in the order of the legend.
    pub(crate) const ALL: [Self; 14] = [
        Self::ClosedForm,
        Self::Certified,
        Self::BatchDouble,
        Self::BatchCertified,
        Self::BatchSingle,
        Self::Digits,
        Self::DualNumbers,
        Self::CentralDifferences,
        Self::ContourRule,
        Self::AreaRule,
        Self::AdaptiveContour,
        Self::AdaptiveArea,
        Self::QuasiMonteCarlo,
        Self::MonteCarlo,
    ];

    /// Name in tables and legends.
    pub(crate) const fn name(self) -> &'static str {
        match self {
            Self::ClosedForm => "closed form",
            Self::Certified => "certified ladder",
            Self::BatchDouble => "batch f64",
            Self::BatchCertified => "certified batch f64",
            Self::BatchSingle => "batch f32",
            Self::Digits => "arbitrary precision",
            Self::DualNumbers => "dual numbers",
            Self::CentralDifferences => "central differences",
            Self::ContourRule => "Gauss on the contour",
            Self::AreaRule => "Gauss on the area",
            Self::AdaptiveContour => "adaptive contour",
            Self::AdaptiveArea => "adaptive area",
            Self::QuasiMonteCarlo => "scrambled Sobol",
            Self::MonteCarlo => "Monte Carlo",
        }
    }

    /// The method at each of its settings for these cases.
    pub(crate) fn runs<'a>(self, cases: &'a [Case]) -> Vec<Run<'a>> {
        match self {
            Self::ClosedForm => vec![self.each(cases, "".to_owned(), closed_form)],
            Self::Certified => [1e-3, 1e-6, 1e-9, 1e-12, 1e-13, 1e-14, 1e-15]
                .map(|tolerance| self.each(cases, format!("{tolerance:e}"), move |case| certified(case, tolerance)))
                .into(),
            Self::BatchDouble => lanes::double_runs(cases),
            Self::BatchCertified => lanes::certified_runs(cases),
            Self::BatchSingle => lanes::single_runs(cases),
            Self::Digits => [15, 20, 30, 50, 100]
                .map(|digits| self.each(cases, format!("{digits} digits"), move |case| to_digits(case, digits)))
                .into(),
            Self::DualNumbers => {
                let constant = matches!(cases.first().map(|case| case.emitter.emission()), Some(Emission::Constant(_)));
                let run = |case: &Case| Ok(Output::new(lambert::radiosity_and_gradient(case), 1));
                if constant { vec![self.each(cases, "".to_owned(), run)] } else { Vec::new() }
            }
            Self::CentralDifferences => (1..=9)
                .map(|k| 0.1f64.powi(k))
                .map(|step| self.each(cases, format!("step {step:.0e}"), move |case| central_differences(case, step)))
                .collect(),
            Self::ContourRule => {
                gauss(|rule, case| contour_rule::evaluate(case, rule), self, cases, &[1, 2, 4, 8, 16, 32, 64, 128])
            }
            Self::AreaRule => {
                gauss(|rule, case| area_rule::evaluate(case, rule), self, cases, &[1, 2, 3, 4, 6, 8, 12, 16, 24, 32, 48])
            }
            Self::AdaptiveContour => self.adaptive(cases, Form::Contour),
            Self::AdaptiveArea => self.adaptive(cases, Form::Surface),
            Self::QuasiMonteCarlo => {
                self.sampled(cases, |samples| Sequence::Sobol { samples: samples / 2, scramblings: 2, seed: 1 })
            }
            Self::MonteCarlo => self.sampled(cases, |samples| Sequence::Independent { samples: samples as usize, seed: 1 }),
        }
    }

    fn each<'a>(
        self,
        cases: &'a [Case],
        setting: String,
        answer: impl Fn(&Case) -> Result<Output, Box<dyn Error>> + 'a,
    ) -> Run<'a> {
        let part = move |index: usize, outputs: &mut Vec<Output>| {
            outputs.push(answer(std::hint::black_box(&cases[index]))?);
            Ok(())
        };
        Run { method: self, setting, parts: cases.len(), answers: 1, part: Box::new(part) }
    }

    fn adaptive(self, cases: &[Case], form: Form) -> Vec<Run<'_>> {
        (1..=12)
            .map(|k| 0.1f64.powi(k))
            .map(|tolerance| self.each(cases, format!("{tolerance:.0e}"), move |case| adaptive(case, form, tolerance)))
            .collect()
    }

    fn sampled(self, cases: &[Case], sequence: impl Fn(u32) -> Sequence) -> Vec<Run<'_>> {
        (3..=8)
            .map(|k| 1 << (2 * k))
            .map(|samples| (samples, sequence(samples)))
            .map(|(samples, sequence)| self.each(cases, format!("{samples} points"), move |case| sampled(case, sequence)))
            .collect()
    }
}

/// A method at one setting, for some cases.
pub(crate) struct Run<'a> {
    /// The method.
    pub(crate) method: Method,
    /// Its setting.
    pub(crate) setting: String,
    /// Number of parts that are answered, and timed, one by one: a case each, or all cases together.
    pub(crate) parts: usize,
    /// Answers that a part computes.
    pub(crate) answers: usize,
    part: Part<'a>,
}

type Part<'a> = Box<dyn FnMut(usize, &mut Vec<Output>) -> Result<(), Box<dyn Error>> + 'a>;

impl<'a> Run<'a> {
    /// All cases in one part, which computes `answers` answers for them.
    pub(crate) fn together(
        method: Method,
        setting: String,
        answers: usize,
        part: impl FnMut(usize, &mut Vec<Output>) -> Result<(), Box<dyn Error>> + 'a,
    ) -> Self {
        Self { method, setting, parts: 1, answers, part: Box::new(part) }
    }

    /// Answers the cases of a part.
    pub(crate) fn part(&mut self, index: usize, outputs: &mut Vec<Output>) -> Result<(), Box<dyn Error>> {
        outputs.clear();
        (self.part)(index, outputs)
    }

    /// Answers all cases, in their order.
    pub(crate) fn outputs(&mut self) -> Result<Vec<Output>, Box<dyn Error>> {
        let (mut answers, mut outputs) = (Vec::new(), Vec::new());
        for index in 0..self.parts {
            self.part(index, &mut outputs).map_err(|error| format!("{} {}: {error}", self.method.name(), self.setting))?;
            answers.append(&mut outputs);
        }
        Ok(answers)
    }
}

fn closed_form(case: &Case) -> Result<Output, Box<dyn Error>> {
    Ok(Output::new(radgrad_core::radiosity_and_gradient(&case.receiver, &case.emitter)?, 1))
}

fn certified(case: &Case, tolerance: f64) -> Result<Output, Box<dyn Error>> {
    let answer = evaluate_to(&case.receiver, &case.emitter, &[], tolerance)?;
    let converged = answer.meets(tolerance);
    Ok(Output { converged, ..Output::new((answer.radiosity, answer.gradient), 1) })
}

fn to_digits(case: &Case, digits: u32) -> Result<Output, Box<dyn Error>> {
    let PreciseAnswer { radiosity, gradient, radiosity_error, gradient_error, .. } =
        evaluate_digits(&case.receiver, &case.emitter, &[], digits)?;
    let [x, y, z] = gradient;
    let (radiosity, gradient) = (radiosity.parse()?, DVec3::new(x.parse()?, y.parse()?, z.parse()?));
    let errors = [radiosity_error.parse::<f64>()? / radiosity, gradient_error.parse::<f64>()? / gradient.length()];
    Ok(Output { proven: Some(errors), ..Output::new((radiosity, gradient), 1) })
}

/// `step` is in units of the distance to the nearest vertex.
fn central_differences(case: &Case, step: f64) -> Result<Output, Box<dyn Error>> {
    let Case { receiver, emitter } = case;
    let (x, distances) = (receiver.position(), emitter.polygon().vertices().iter().map(|v| v.distance(receiver.position())));
    let step = step * distances.fold(f64::INFINITY, f64::min);
    let radiosity = |x| -> Result<f64, radgrad_core::Error> {
        radgrad_core::radiosity(&Receiver::new(x, receiver.normal(), receiver.reflectance())?, emitter)
    };
    let along =
        |axis: DVec3| Ok::<f64, radgrad_core::Error>((radiosity(x + axis * step)? - radiosity(x - axis * step)?) / (2.0 * step));
    let gradient = DVec3::new(along(DVec3::X)?, along(DVec3::Y)?, along(DVec3::Z)?);
    Ok(Output::new((radgrad_core::radiosity(receiver, emitter)?, gradient), 7))
}

fn gauss<'a>(
    evaluate: impl Fn(&[(f64, f64)], &Case) -> Output + Copy + 'a,
    method: Method,
    cases: &'a [Case],
    counts: &[u32],
) -> Vec<Run<'a>> {
    let run = |&count: &u32| {
        let rule = legendre::rule(count);
        let nodes = if method == Method::AreaRule { format!("{count} x {count} points") } else { format!("{count} points") };
        method.each(cases, nodes, move |case| Ok(evaluate(&rule, case)))
    };
    counts.iter().map(run).collect()
}

/// Evaluations after which adaptive methods give up.
const BUDGET: usize = 100_000;

fn adaptive(case: &Case, form: Form, tolerance: f64) -> Result<Output, Box<dyn Error>> {
    let source = SourceFunction::Emitter(&case.emitter);
    let estimate = integrate_form(&case.receiver, case.emitter.polygon(), source, form, tolerance, BUDGET)?;
    let converged = estimate.status == Status::Converged;
    Ok(Output { converged, ..Output::new((estimate.radiosity, estimate.gradient), estimate.evaluations) })
}

/// Confidence of the limits that come with each mean; they are computed and not used.
const CONFIDENCE: f64 = 0.95;

fn sampled(case: &Case, sequence: Sequence) -> Result<Output, Box<dyn Error>> {
    let estimate = monte_carlo::integrate(&case.receiver, &case.emitter, &[], Sampling::SolidAngle, sequence, CONFIDENCE)?;
    let gradient = DVec3::from_array(estimate.gradient.map(|limits| limits.mean));
    Ok(Output::new((estimate.radiosity.mean, gradient), estimate.samples))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bench::regime::{Kind, Regime};
    use crate::bench::truth::Truths;

    #[test]
    fn every_method_converges_to_the_truth_in_easy_and_in_clipped_cases() {
        for (regime, kind) in [Regime::Easy, Regime::Clipped].into_iter().flat_map(|r| Kind::ALL.map(|k| (r, k))) {
            let cases = &regime.cases(kind).unwrap()[..3];
            let truths = Truths::enclose(cases).unwrap();
            for method in Method::ALL {
                let mut best = f64::INFINITY;
                for mut run in method.runs(cases) {
                    best = best.min(truths.errors(&run.outputs().unwrap()).worst());
                }
                let expected = match method {
                    Method::MonteCarlo => 5e-2,
                    Method::BatchSingle => 1e-5,
                    Method::QuasiMonteCarlo => 1e-3,
                    Method::CentralDifferences => 1e-8,
                    Method::DualNumbers if kind == Kind::Linear => f64::INFINITY,
                    _ => 1e-10,
                };
                assert!(best <= expected, "{} in {regime:?}, {kind:?}: {best:e}", method.name());
            }
        }
    }
}
