//! The contents of the page, section by section, and the template that sets it.

use std::error::Error;
use std::path::PathBuf;

use minijinja::syntax::SyntaxConfig;
use minijinja::value::Serde;
use minijinja::{Environment, Value, context};
use radgrad_audit::comparison::stability::{DIGITS, ORACLE_EVERY};
use radgrad_audit::gates::Gates;
use radgrad_audit::measures::measure::Quantity;
use radgrad_paper::appendix;
use serde::Serialize;

use super::Beside;
use super::audit::{Audit, Fields, Figure, thousands};
use super::bench::Diagram;
use super::errata::Misprint;
use super::heat::{self, Group};
use super::histogram::{self, value};
use super::rungs;
use super::side_by_side;
use super::table::Table;
use super::tables::{self, Fault, Searched};
use super::worst::Worst;

/// All that the template needs.
#[derive(Serialize)]
pub(super) struct Page<'a> {
    passed: bool,
    verdict: String,
    /// Names and values that describe the run.
    facts: Vec<(&'static str, String)>,
    violations: Vec<(&'a str, &'a str)>,
    faults_told: String,
    survivors: Table,
    closest: Table,
    scenes_told: Option<String>,
    scenes: Table,
    histograms: [String; 2],
    families: Table,
    worst: &'a [Worst],
    contenders: String,
    side_by_side: [String; 2],
    comparison: [Table; 2],
    errata: Table,
    mutants: Table,
    mutants_caught: String,
    bounds_told: String,
    rungs: String,
    rungs_legend: String,
    bounds: Table,
    search: Table,
    maps: Vec<Group>,
    maps_legend: String,
    maps_told: String,
    diagrams: Vec<Diagram>,
    command: String,
}

impl<'a> Page<'a> {
    pub(super) fn new(
        audit: &'a Audit,
        gates: &Gates,
        misprints: &[Misprint],
        worst: &'a [Worst],
        diagrams: Vec<Diagram>,
        (searched, faults): (&[Searched], &[Fault]),
    ) -> Self {
        let runs = [Some(&audit.run), Some(&audit.bounds_run), audit.scenes.as_ref().map(|scenes| &scenes.run)];
        let passed = runs.iter().flatten().all(|run| run.get("passed") == "true");
        let slips = audit.mutants.iter().filter(|row| is_slip(&row.slip));
        let caught = slips.clone().filter(|row| row.verdict == "caught").count();
        let mutants_caught = format!("{caught} of {}", slips.count());
        Self {
            passed,
            verdict: verdict(audit, passed, &mutants_caught),
            facts: facts(audit),
            violations: audit.violations.iter().map(|v| (v.violation.as_str(), v.command.as_str())).collect(),
            faults_told: tables::faults_told(faults),
            survivors: tables::survivors(faults),
            closest: tables::closest(searched),
            scenes_told: audit.scenes.as_ref().map(|scenes| scenes_told(&scenes.run)),
            scenes: tables::scenes(audit),
            histograms: [(Quantity::Value, "radiosity"), (Quantity::Gradient, "gradient")]
                .map(|(quantity, what)| histogram::plot(audit, gates, quantity, what)),
            families: tables::families(audit),
            worst,
            contenders: side_by_side::legend(),
            side_by_side: [("value", "radiosity"), ("gradient", "gradient")]
                .map(|(quantity, what)| side_by_side::plot(audit, quantity, what)),
            comparison: [("value", "Radiosity"), ("gradient", "Gradient")]
                .map(|(quantity, what)| tables::comparison(audit, quantity, what)),
            errata: tables::errata(misprints),
            mutants: tables::mutants(audit),
            mutants_caught,
            bounds_told: bounds_told(audit),
            rungs: rungs::plot(audit),
            rungs_legend: rungs::legend(),
            bounds: tables::bounds(audit),
            search: tables::search(searched),
            maps: heat::groups(audit),
            maps_legend: heat::legend(),
            maps_told: format!(
                "{} points. The truth at each is known to {DIGITS} digits; at one in {ORACLE_EVERY} of them, {} in all, an \
                 arbitrary-precision enclosure that shares no formula with it says the same.",
                audit.run.count("map_points"),
                audit.run.count("map_points_against_oracle"),
            ),
            diagrams,
            command: audit.run.get("command").to_owned(),
        }
    }

    /// The page.
    pub(super) fn render(self, data: &[Beside], copied: &[PathBuf]) -> Result<String, Box<dyn Error>> {
        let mut files: Vec<String> = data.iter().map(|(name, _)| (*name).to_owned()).collect();
        files.extend(copied.iter().map(|path| path.file_name().unwrap_or_default().to_string_lossy().into_owned()));
        files.sort();
        let mut environment = Environment::new();
        environment.set_syntax(SyntaxConfig::builder().trim_blocks(true).lstrip_blocks(true).build()?);
        environment.add_template("page.html", include_str!("page.html"))?;
        let (style, script) = (include_str!("style.css"), include_str!("sort.js"));
        Ok(environment.get_template("page.html")?.render(context! { page => Value::from(Serde(&self)), files, style, script })?)
    }
}

/// Whether a row of the table of mutants is a slip's, and not the control's.
fn is_slip(name: &str) -> bool {
    appendix::Misprint::ALL.iter().any(|slip| slip.name() == name)
}

fn verdict(audit: &Audit, passed: bool, caught: &str) -> String {
    let (run, bounds) = (&audit.run, &audit.bounds_run);
    let worst_of = |figures: &[Figure], quantities: &[&str]| {
        let figures = figures.iter().filter(|figure| quantities.contains(&figure.quantity.as_str()));
        let worst = figures.max_by(|a, b| value(&a.worst).total_cmp(&value(&b.worst)));
        worst.map_or_else(|| "none".to_owned(), |worst| format!("{} ({})", worst.worst, worst.worst_case))
    };
    let worst = |quantity: &str| worst_of(&audit.figures, &[quantity]);
    format!(
        "{}: {} cases in {} families; worst relative error {} of the radiosity, {} of the gradient; {} bounds broken in {} \
         answers, the largest error over its bound {};{} {caught} planted slips caught.",
        if passed { "Passed" } else { "FAILED" },
        run.count("cases"),
        run.get("families"),
        worst("value"),
        worst("gradient"),
        bounds.count("broken"),
        bounds.count("answers"),
        worst_of(&audit.bounds_figures, &["value-over-bound", "gradient-over-bound"]),
        audit.scenes.as_ref().map_or_else(String::new, |scenes| format!(
            " {} statements of {} whole scenes judged, {} broken;",
            scenes.run.count("judged"),
            scenes.run.count("cases"),
            scenes.run.count("broken_or_failed")
        )),
    )
}

/// The outcome of the audit of whole scenes.
fn scenes_told(run: &Fields) -> String {
    format!(
        "{} scenes gave {} statements that were judged; {} were broken, or their scene failed. A bound counts as broken if the error is above it \
         by more than the truth's own uncertainty.",
        run.count("cases"),
        run.count("judged"),
        run.count("broken_or_failed")
    )
}

fn facts(audit: &Audit) -> Vec<(&'static str, String)> {
    let (run, bounds) = (&audit.run, &audit.bounds_run);
    let field = |field| run.get(field).to_owned();
    let mut facts = vec![
        ("version", format!("{} ({})", field("version"), field("commit"))),
        ("date", field("date")),
        ("seed", field("seed")),
        ("machine", field("machine")),
        ("to reproduce", field("command")),
    ];
    if bounds.get("command") != run.get("command") {
        facts
            .push(("bounds campaign", format!("{}, {}, seed {}", bounds.get("command"), bounds.get("date"), bounds.get("seed"))));
    }
    let agreement = format!(
        "{} enclosures; cubature converged in {}, Monte Carlo sampled {}, appendix A answered {}: {} contradictions",
        run.count("enclosed"),
        run.count("cubature"),
        run.count("monte_carlo"),
        run.count("appendix_a"),
        run.get("disagree")
    );
    facts.push(("independent oracles", agreement));
    facts
}

fn bounds_told(audit: &Audit) -> String {
    let run = &audit.bounds_run;
    let sharp = match (run.get("answers").parse::<u64>(), run.get("blunt").parse::<u64>()) {
        (Ok(answers), Ok(blunt)) => thousands(&answers.saturating_sub(blunt).to_string()),
        _ => String::new(),
    };
    format!(
        "{} cases, {} of them not 0, gave {} answers to 1e-12, 1e-15 and loose tolerances. Each was held against core's own \
         closest answer ({} cases), {} cases also against 22 digits and {} against the oracle's enclosure; for {sharp} answers the truth \
         was known to within 1 % of the bound. Bounds below their error: {}. Tolerances missed: {} at 1e-12, {} at 1e-15.",
        run.count("cases"),
        run.count("nonzero"),
        run.count("answers"),
        run.count("against-core"),
        run.count("against-digits"),
        run.count("against-oracle"),
        run.get("broken"),
        run.get("misses-1e-12"),
        run.get("misses-1e-15"),
    )
}
