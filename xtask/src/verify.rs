//! `cargo xtask verify`: measures random cases of every family against truth and holds the figures against the gates.

mod paragraph;

use std::error::Error;
use std::fs;
use std::path::Path;
use std::time::Instant;

use indicatif::ProgressBar;
use radgrad_audit::bounds::witness;
use radgrad_audit::cases::family::Family;
use radgrad_audit::checks::agreement::{Agreement, agreement};
use radgrad_audit::checks::bite::{Made, Setting, bite};
use radgrad_audit::checks::forms::{FORMS as FORMS_NAMED, forms};
use radgrad_audit::checks::motions::{self, Row};
use radgrad_audit::checks::mutants::{self, mutants};
use radgrad_audit::checks::precision;
use radgrad_audit::checks::regression::Regression;
use radgrad_audit::comparison::Comparison;
use radgrad_audit::comparison::stability::{Plane, Stability};
use radgrad_audit::gates::Gates;
use radgrad_audit::measures::measure::{Kind, Quantity};
use radgrad_audit::measures::run::{Part, Run};
use radgrad_audit::measures::shard::Shard;
use radgrad_audit::measures::table::Table;
use radgrad_scene::output::write_whole;

use crate::files::{self, in_workspace};
use crate::record::Record;
use crate::request::{Arguments, merged};
use crate::summary::{ended, style};
use crate::{bounds, summary};

/// Cases unless a number is given.
const CASES: u64 = 42_000;

/// Cases of the bounds campaign beside them, and of the quick run.
const BOUNDS: [u64; 2] = [100_000, 20_000];

/// Pairs of faces whose factors are held against rays beside them, and in the quick run.
const PAIRS: [u64; 2] = [5000, 500];

/// Cases of each family and emission that the paper's equations are compared on, in the whole run and in the quick one.
const FORMS: [u64; 2] = [12, 3];

type Measured = Shard<Kind, Quantity>;

/// Cases of each family that the mutants and the oracles' agreement are tried on.
const SUBSAMPLE: u64 = 25;

/// Cases of each family that other ways of computing it are compared on, in the whole run and in the quick one.
const COMPARED: [u64; 2] = [200, 50];

/// Points along the axes of a plane of the stability maps, in the whole run and in the quick one.
const PLANE: [[u32; 2]; 2] = [[45, 33], [23, 17]];

/// Whether nothing is beyond its gate.
pub(crate) fn run(arguments: &Arguments) -> Result<bool, Box<dyn Error>> {
    arguments.check()?;
    let gates = Gates::from_toml(&fs::read_to_string(in_workspace("data/gates.toml"))?)?;
    fs::create_dir_all(&arguments.out)?;
    if arguments.scenes {
        return crate::scenes::run(arguments, &gates);
    }
    if let Some(pairs) = arguments.factors {
        return crate::scenes::brackets(pairs, arguments, &gates).map(ended);
    }
    if let Some(scenes) = arguments.gradients {
        return crate::scenes::gradients(scenes, arguments, &gates).map(ended);
    }
    if let Some(cases) = arguments.derivatives {
        return derivatives(cases, arguments, &gates).map(ended);
    }
    if arguments.bounds {
        return bounds::run(arguments, &gates);
    }
    let start = Instant::now();
    let Shard { run, table } = if arguments.merge.is_empty() { measured(arguments) } else { merged(&arguments.merge)? };
    println!("{} cases, seed {}\n{}", table.cases(), run.seed, summary::families(&table, &gates).printed(arguments.tables));
    if run.part != Part::WHOLE {
        let path = arguments.out.join(format!("shard-{}-of-{}.json", run.part.index + 1, run.part.of));
        files::write(&path, Shard { run, table }.to_json()?)?;
        println!("written to {}; the gates are held against the whole", path.display());
        return Ok(true);
    }
    write_tables(&table, &arguments.out)?;
    let mut record = Record::new("verify", run.seed, table.cases());
    record.note("families", run.cases.len());
    for violation in gates.violations(&table) {
        let shrunk = Regression::shrunk(&violation).write(&arguments.out.join("regressions"))?;
        record.violated(&violation, &format!("cargo xtask replay {}", violation.case));
        println!("  shrunk: cargo xtask replay {}", shrunk.display());
    }
    for (family, _) in run.cases.iter().filter(|(family, _)| table.families().get(family).is_none_or(|t| t.cases() == 0)) {
        record.violated(format_args!("{family}: no case was measured"), &format!("cargo xtask verify --family {family}"));
    }
    let bounds = bounds::small(BOUNDS[usize::from(arguments.quick)], arguments, &gates)?;
    let witnesses = judge_small(&gates, &mut record)?;
    let slips = judge_mutants(run.seed, arguments, &gates, &mut record)?;
    let agreement = judge_oracles(&run, &gates, &mut record);
    compare(&run, arguments, &mut record)?;
    let digits = judge_digits(&run, arguments, &mut record)?;
    // Families of cases alone are asked for without scenes.
    let every_family = arguments.family.is_empty();
    let scenes = if every_family { Some(crate::scenes::beside(arguments, &gates)?) } else { None };
    let are_held = !every_family || crate::scenes::brackets(PAIRS[usize::from(arguments.quick)], arguments, &gates)?;
    let passed = record.write(&arguments.out)? & bounds.passed & scenes.is_none_or(|scenes| scenes.passed) & are_held;
    let figures = paragraph::Found {
        table: &table,
        bounds,
        witnesses,
        slips,
        agreement,
        digits,
        scenes,
        seconds: start.elapsed().as_secs_f64(),
    };
    println!("{}", figures.said(&run, &arguments.out));
    Ok(ended(passed))
}

/// Derivatives by everything that shapes the light of a point: whether bounds and identities hold.
fn derivatives(cases: u64, arguments: &Arguments, gates: &Gates) -> Result<bool, Box<dyn Error>> {
    let families: Vec<Family> = arguments.families().into_iter().filter(|family| !family.is_refused()).collect();
    let run = Run::at_least(cases, &families, arguments.seed);
    let bar = ProgressBar::new(run.count());
    bar.set_style(style());
    let campaign = motions::campaign(&run, !arguments.identities, |name| {
        bar.set_message(name.family.name());
        bar.inc(1);
    });
    bar.finish_and_clear();
    let mut table = csv::Writer::from_writer(Vec::new());
    table.write_record(["family", "cases", "compared", "worst share of the bound"])?;
    for (family, Row { cases, compared, worst }) in &campaign.rows {
        table.write_record([family.name(), &cases.to_string(), &compared.to_string(), &format!("{worst:.3}")])?;
    }
    files::write(&arguments.out.join("derivatives.csv"), table.into_inner()?)?;
    let count: u64 = campaign.rows.values().map(|row| row.cases).sum();
    let (share, least) = (campaign.compared(), gates.derivatives());
    println!(
        "derivatives of {count} cases, seed {}: {:.1} % held against the oracle's slope, {} wrong",
        arguments.seed,
        100.0 * share,
        campaign.wrong.len()
    );
    let mut record = Record::new("derivatives", arguments.seed, count);
    record.note("compared", format!("{share:.4}"));
    for (name, why) in &campaign.wrong {
        record.violated(format_args!("derivatives: {name}: {why}"), &format!("cargo xtask replay {name}"));
    }
    // Of no cases there is no share.
    if !arguments.identities && (share.is_nan() || share < least) {
        let what = format!("derivatives: {:.0} % were held against slopes, the gate is {:.0} %", 100.0 * share, 100.0 * least);
        record.violated(what, "cargo xtask verify --derivatives 1000");
    }
    record.write(&arguments.out)
}

/// Many digits against the oracle, and the paper's equations against each other; how many cases of how many digits.
fn judge_digits(run: &Run, arguments: &Arguments, record: &mut Record) -> Result<Vec<(u32, u64)>, Box<dyn Error>> {
    let mut held = Vec::new();
    let mut table = csv::Writer::from_writer(Vec::new());
    table.write_record(["digits", "family", "cases"])?;
    for (digits, cases) in precision::LEVELS {
        let level = precision::level(digits, cases[usize::from(arguments.quick)], run.seed);
        for (family, count) in &level.held {
            table.write_record([&digits.to_string(), family.name(), &count.to_string()])?;
        }
        println!(
            "{digits} digits: {} cases of {} families against the oracle, {} take it too long, {} wrong",
            level.count(),
            level.held.len(),
            level.dear,
            level.wrong.len()
        );
        record.note(&format!("digits_{digits}"), level.count());
        for (name, why) in &level.wrong {
            record.violated(format_args!("{digits} digits: {name}: {why}"), &format!("cargo xtask replay {name}"));
        }
        if level.count() == 0 {
            record.violated(format_args!("{digits} digits: no case was held against the oracle"), "cargo xtask verify");
        }
        held.push((digits, level.count()));
    }
    files::write(&arguments.out.join("digits.csv"), table.into_inner()?)?;
    let (rows, contradictions) = forms(run.seed, FORMS[usize::from(arguments.quick)]);
    for row in &rows {
        let converged: Vec<String> =
            FORMS_NAMED.iter().zip(row.converged).map(|((_, form), count)| format!("{form} {count}")).collect();
        println!(
            "{} emission: of {} cases converged by {}; {} against the enclosure; at most {:.1e} apart",
            row.kind.name(),
            row.cases,
            converged.join(", "),
            row.enclosed,
            row.worst
        );
        record.note(&format!("forms_{}", row.kind.name()), row.cases);
    }
    for contradiction in &contradictions {
        record.violated(contradiction, &format!("cargo xtask replay {}", contradiction.case));
    }
    Ok(held)
}

/// The small setting of the audit, with the recorded witnesses; how many of these there are.
fn judge_small(gates: &Gates, record: &mut Record) -> Result<usize, Box<dyn Error>> {
    let witnesses = witness::read_all(&in_workspace("data/worst"))?;
    let records = radgrad_audit::checks::record::read_all(&in_workspace("data/record"))?;
    for wrong in bite(&Setting { gates, witnesses: &witnesses, records: &records, first: None, made: Made::All }) {
        record.violated(format_args!("{}: {}", wrong.check, wrong.what), "cargo run -p radgrad-audit --example bite");
    }
    record.note("witnesses", witnesses.len());
    record.note("records", records.len());
    Ok(witnesses.len())
}

fn measured(arguments: &Arguments) -> Measured {
    let families = arguments.families();
    let total = arguments.cases.unwrap_or(CASES);
    let wanted = if arguments.quick { total.div_ceil(20) } else { total };
    let cases = wanted.div_ceil(families.len() as u64);
    let run = Run { part: arguments.part(), ..Run::of_each(cases, &families, arguments.seed) };
    let bar = ProgressBar::new(run.count());
    bar.set_style(style());
    let table = run.table(|name| {
        bar.set_message(name.family.name());
        bar.inc(1);
    });
    bar.finish_and_clear();
    Shard { run, table }
}

fn write_tables(table: &Table, out: &Path) -> Result<(), Box<dyn Error>> {
    write_whole(&out.join("errors.csv"), |file| table.write_errors(file))?;
    write_whole(&out.join("outcomes.csv"), |file| table.write_outcomes(file))?;
    write_whole(&out.join("figures.csv"), |file| table.write_figures(file))?;
    write_whole(&out.join("histogram.csv"), |file| table.write_histogram(file))?;
    Ok(())
}

fn judge_mutants(seed: u64, arguments: &Arguments, gates: &Gates, record: &mut Record) -> Result<usize, Box<dyn Error>> {
    let (rows, lost) = mutants(seed, SUBSAMPLE, gates.appendix_a());
    let table = summary::mutants(&rows, gates.appendix_a());
    println!("slips planted in the second implementation\n{}", table.printed(arguments.tables));
    write_whole(&arguments.out.join("mutants.csv"), |file| mutants::write(&rows, gates.appendix_a(), file))?;
    for row in rows.iter().filter(|row| !row.passes(gates.appendix_a())) {
        record.violated(format_args!("mutants: {} is not caught, or the control is", row.name()), "cargo xtask verify");
    }
    for (name, why) in lost {
        record.violated(format_args!("mutants: {name} is no witness: {why}"), &format!("cargo xtask replay {name}"));
    }
    Ok(rows.iter().filter(|row| row.slip.is_some() && row.passes(gates.appendix_a())).count())
}

fn judge_oracles(run: &Run, gates: &Gates, record: &mut Record) -> Agreement {
    let agreement = agreement(run, SUBSAMPLE, gates.appendix_a());
    let Agreement { enclosed, cubature, monte_carlo, paper, contradictions } = &agreement;
    println!(
        "{enclosed} cases enclosed; cubature converged in {cubature}, Monte Carlo sampled {monte_carlo}, appendix A answered {paper}: {} disagree",
        contradictions.len()
    );
    let counts = [("enclosed", *enclosed), ("cubature", *cubature), ("monte_carlo", *monte_carlo), ("appendix_a", *paper)];
    for (name, count) in counts.into_iter().chain([("disagree", contradictions.len())]) {
        record.note(name, count);
    }
    // A run of some families need not have those that are asked in every way.
    let all_families = run.cases.len() == Family::ALL.len();
    for (name, _) in counts.into_iter().filter(|(_, count)| all_families && *count == 0) {
        record.violated(format_args!("agreement: {name} answered in no case"), "cargo xtask verify");
    }
    for contradiction in contradictions {
        record.violated(contradiction, &format!("cargo xtask replay {}", contradiction.case));
    }
    agreement
}

/// Other ways of computing it beside ours: family by family, and over planes of two parameters.
fn compare(run: &Run, arguments: &Arguments, record: &mut Record) -> Result<(), Box<dyn Error>> {
    let (quick, out) = (usize::from(arguments.quick), &arguments.out);
    let families = arguments.families();
    let comparison = Comparison::compute(run.seed, &families, COMPARED[quick]);
    write_whole(&out.join("comparison.csv"), |file| comparison.write(file))?;
    let bar = ProgressBar::new(2 * Plane::ALL.len() as u64);
    let stability = Stability::compute(PLANE[quick], || bar.inc(1));
    bar.finish_and_clear();
    write_whole(&out.join("stability.csv"), |file| stability.write(file))?;
    let points: usize = stability.maps.iter().map(|map| map.points.len()).sum();
    println!(
        "{points} points of stability maps; the oracle agreed at {}, had no enclosure at {}: {} complaints",
        stability.agreed,
        stability.without_oracle,
        stability.complaints.len()
    );
    record.note("map_points", points);
    record.note("map_points_against_oracle", stability.agreed);
    for complaint in &stability.complaints {
        record.violated(complaint, &format!("echo '{}' | radgrad eval -", serde_json::to_string(&complaint.case)?));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_run_without_cases_is_refused_with_a_sentence() {
        for more in [&[][..], &["--bounds"], &["--scenes"], &["--quick"]] {
            let given = ["verify", "--cases", "0"].iter().chain(more);
            let arguments = <Parsed as clap::Parser>::try_parse_from(given).unwrap().arguments;
            let error = run(&arguments).unwrap_err().to_string();
            assert_eq!(error, "--cases 0: a run without cases shows nothing; ask for 1 or more");
        }
    }

    #[derive(clap::Parser)]
    struct Parsed {
        #[command(flatten)]
        arguments: Arguments,
    }
}
