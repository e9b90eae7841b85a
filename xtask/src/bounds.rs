//! `cargo xtask verify --bounds`: the campaign that looks for a bound below its error.

mod search;
mod summary;

use std::error::Error;
use std::path::Path;

use indicatif::ProgressBar;
use radgrad_audit::bounds::campaign;
use radgrad_audit::bounds::mark::{Figure, Mark};
use radgrad_audit::bounds::requirements::Breach;
use radgrad_audit::bounds::table::Table;
use radgrad_audit::cases::family::Family;
use radgrad_audit::checks::regression::Regression;
use radgrad_audit::gates::Gates;
use radgrad_audit::measures::distribution::Extreme;
use radgrad_audit::measures::run::{Part, Run};
use radgrad_audit::measures::shard;
use radgrad_scene::output::write_whole;

use crate::files;
use crate::record::Record;
use crate::request::{Arguments, merged};
use crate::summary::{ended, style};

type Shard = shard::Shard<Mark, Figure>;

/// Cases of the whole campaign, and of the quick one.
const CASES: [u64; 2] = [10_000_000, 100_000];

/// The counts that stand in the record, over all families.
const NOTED: [Mark; 10] = [
    Mark::Nonzero,
    Mark::Answer,
    Mark::Blunt,
    Mark::AgainstCore,
    Mark::AgainstDigits,
    Mark::AgainstOracle,
    Mark::ManyDigits,
    Mark::Broken,
    Mark::MissesDefault,
    Mark::MissesTight,
];

/// The campaign by itself, or a part of it, or its parts merged. Whether nothing is broken, missed or beyond its gate.
pub(crate) fn run(arguments: &Arguments, gates: &Gates) -> Result<bool, Box<dyn Error>> {
    let out = &arguments.out;
    let Shard { run, table } = if arguments.merge.is_empty() {
        let (families, part) = (arguments.families(), arguments.part());
        campaigned(match arguments.cases {
            Some(cases) => campaign::run(cases, &families, arguments.seed, part),
            None => campaign::run(CASES[usize::from(arguments.quick)], &Family::ALL, arguments.seed, part).only(&families),
        })
    } else {
        merged(&arguments.merge)?
    };
    if run.part != Part::WHOLE {
        println!("{}", summary::print(&table, &run, arguments.tables));
        let path = out.join(format!("bounds-{}-of-{}.json", run.part.index + 1, run.part.of));
        files::write(&path, Shard { run, table }.to_json()?)?;
        println!("written to {}; the gates are held against the whole", path.display());
        return Ok(true);
    }
    let held = judged(&run, &table, gates, arguments)?;
    let climbed = search::run(arguments, out)?;
    Ok(ended(held.passed & climbed))
}

/// The part of a campaign of so many cases that is of the families asked for, within another command.
pub(crate) fn small(cases: u64, arguments: &Arguments, gates: &Gates) -> Result<Held, Box<dyn Error>> {
    let Shard { run, table } =
        campaigned(campaign::run(cases, &Family::ALL, arguments.seed, Part::WHOLE).only(&arguments.families()));
    judged(&run, &table, gates, arguments)
}

fn campaigned(run: Run) -> Shard {
    let bar = ProgressBar::new(run.count());
    bar.set_style(style());
    let table = campaign::table(&run, || bar.inc(1));
    bar.finish_and_clear();
    Shard { run, table }
}

/// Prints and writes the tables, and holds them against the requirements.
fn judged(run: &Run, table: &Table, gates: &Gates, arguments: &Arguments) -> Result<Held, Box<dyn Error>> {
    let out = &arguments.out;
    println!("{}", summary::print(table, run, arguments.tables));
    write_whole(&out.join("bounds.csv"), |file| table.write_bounds(file))?;
    write_whole(&out.join("bounds-times.csv"), |file| table.write_times(file))?;
    write_whole(&out.join("bounds-figures.csv"), |file| table.write_figures(file))?;
    let mut record = Record::new("bounds", run.seed, table.total(Mark::Case));
    for mark in NOTED {
        record.note(&mark.to_string(), table.total(mark));
    }
    for breach in &gates.breaches(table) {
        report(breach, out, &mut record)?;
    }
    if table.total(Mark::Answer) == 0 {
        record.violated("bounds: there is no answer to hold against truth", "cargo xtask verify --bounds");
    } else if table.total(Mark::Nonzero) > 2000 && table.total(Mark::AgainstOracle) == 0 {
        record.violated("bounds: no answer was held against the oracle", "cargo xtask verify --bounds");
    }
    let worst = |figure| table.families().values().filter_map(move |family| family.figures().get(&figure)?.worst());
    let worst = [Figure::ValueOverBound, Figure::GradientOverBound].into_iter().flat_map(worst);
    let worst = worst.max_by(|a, b| a.value.total_cmp(&b.value));
    Ok(Held { passed: record.write(out)?, answers: table.total(Mark::Answer), worst })
}

/// How bounds fared.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Held {
    pub(crate) passed: bool,
    pub(crate) answers: u64,
    /// The largest error over its bound.
    pub(crate) worst: Option<Extreme>,
}

/// Records a breach with the command that replays it; keeps a case that is to blame alone, shrunk.
fn report(breach: &Breach, out: &Path, record: &mut Record) -> Result<(), Box<dyn Error>> {
    record.violated(breach, &format!("cargo xtask replay {}", breach.case));
    if let Some(regression) = Regression::of_breach(breach) {
        let path = regression.write(&out.join("regressions"))?;
        println!("  shrunk: cargo xtask replay {}", path.display());
    }
    Ok(())
}
