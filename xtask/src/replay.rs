//! `cargo xtask replay`: one case, everything known of it.

use std::error::Error;
use std::path::Path;

use clap::Args;
use radgrad_audit::bounds::campaign;
use radgrad_audit::bounds::check::check;
use radgrad_audit::bounds::mark::{Figure, Mark};
use radgrad_audit::cases::family::Name;
use radgrad_audit::checks::regression::Regression;
use radgrad_audit::gates::Gates;
use radgrad_audit::measures::condition::Condition;
use radgrad_audit::measures::measure::{Outcome, Quantity, measure};
use radgrad_audit::measures::table::Table;
use radgrad_audit::measures::truth::Truth;
use radgrad_core::evaluate;
use radgrad_scene::case::{Case, Problem};

use crate::files::in_workspace;

/// Show core's answer to a case, the truth, the errors, the bounds and the condition
#[derive(Debug, Args)]
pub(crate) struct Arguments {
    /// The name of a case or of a scene, such as contact:1:17 or slit:1:3, or a file of data/regressions
    case: String,
}

/// Whether the case is within the gates.
pub(crate) fn run(arguments: &Arguments) -> Result<bool, Box<dyn Error>> {
    if let Ok(name) = arguments.case.parse() {
        return crate::scenes::replay(name);
    }
    let (name, case) = find(&arguments.case)?;
    println!("{}", serde_json::to_string(&case)?);
    match case.problem() {
        Ok(problem) => show(&problem)?,
        Err(error) => println!("refused: {error}"),
    }
    let outcome = measure(&case);
    show_outcome(&outcome);
    let held = show_bounds(&case);
    let gates = Gates::from_toml(&std::fs::read_to_string(in_workspace("data/gates.toml"))?)?;
    let violations = gates.violations(&Table::single(name, &outcome));
    for violation in &violations {
        println!("VIOLATED {violation}");
    }
    Ok(violations.is_empty() && held)
}

/// The case of a name or of a file.
fn find(text: &str) -> Result<(Name, Case), Box<dyn Error>> {
    if Path::new(text).extension().is_some_and(|extension| extension == "json") {
        let Regression { name, case } = Regression::read(Path::new(text))?;
        return Ok((name, case));
    }
    let name: Name = text.parse()?;
    Ok((name, name.case()))
}

fn show(problem: &Problem) -> Result<(), Box<dyn Error>> {
    let Problem { receiver, emitter, occluders, .. } = problem;
    match evaluate(receiver, emitter, occluders) {
        Ok(answer) => {
            println!("core radiosity   {:e} +- {:.2e} ({})", answer.radiosity, answer.radiosity_error, answer.method.name());
            let [x, y, z] = answer.gradient.to_array();
            println!("core gradient    [{x:e}, {y:e}, {z:e}] +- {:.2e}", answer.gradient_error);
        }
        Err(error) => println!("core has no answer: {error}"),
    }
    match Truth::of_problem(problem) {
        Ok(truth) => {
            println!("true radiosity   {}", truth.radiosity.to_decimal()?);
            let [x, y, z] = [0, 1, 2].map(|axis| truth.gradient[axis].to_decimal());
            println!("true gradient    [{}, {}, {}]", x?, y?, z?);
        }
        Err(error) => println!("the oracle has no truth: {error}"),
    }
    match Condition::of_problem(problem) {
        Ok(Condition { radiosity, gradient }) => {
            println!("half an ulp in   radiosity {radiosity:.2e}, gradient {gradient:.2e}");
        }
        Err(error) => println!("no condition: {error}"),
    }
    Ok(())
}

/// Whether every bound holds, at every tolerance and against every truth.
fn show_bounds(case: &Case) -> bool {
    let check = check(case, &campaign::full_effort());
    let largest = |figure| check.figures.iter().filter(|(f, _)| *f == figure).map(|(_, x)| *x).fold(0.0, f64::max);
    let [value, gradient] = [Figure::ValueOverBound, Figure::GradientOverBound].map(largest);
    println!("at any tolerance error / bound is at most {value:.2e} (value), {gradient:.2e} (gradient)");
    for remark in &check.remarks {
        println!("  {remark}");
    }
    !Mark::FAULTS.iter().any(|mark| check.has(*mark))
}

fn show_outcome(outcome: &Outcome) {
    println!("outcome          {}", outcome.kind().name());
    match outcome {
        Outcome::Measured(_) => {
            for quantity in Quantity::ALL {
                if let Some(figure) = outcome.figure(quantity) {
                    println!("  {:24} {figure:.2e}", quantity.name());
                }
            }
        }
        Outcome::Refused(why) | Outcome::Unanswered(why) | Outcome::NonFinite(why) | Outcome::Undetermined(why) => {
            println!("  {why}");
        }
    }
}
