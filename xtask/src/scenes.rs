//! `cargo xtask verify --scenes` and the part of `verify` that holds whole scenes to truth; replay of one scene.

use std::error::Error;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Instant;

use indicatif::ProgressBar;
use radgrad_audit::gates::Gates;
use radgrad_audit::scenes::brackets::{self, Brackets};
use radgrad_audit::scenes::family::{Family, Name};
use radgrad_audit::scenes::gradients::{self, Gradients};
use radgrad_audit::scenes::judge::{Ending, judge};
use radgrad_audit::scenes::model::Model;
use radgrad_audit::scenes::shrink::shrink;
use radgrad_audit::scenes::statement::Subject;
use radgrad_audit::scenes::table::{Row, Table, Violation};
use radgrad_audit::scenes::truth::EFFORT;
use radgrad_oracle::scene::Effort;
use radgrad_scene::output::write_whole;

use crate::files;
use crate::record::Record;
use crate::request::Arguments;
use crate::summary::{Ranked, ended, style};

/// Scenes of `verify --scenes` unless a number is given.
const CASES: u64 = 800;

/// Scenes beside the other cases of `verify`, and of the quick run.
const BESIDE: [u64; 2] = [160, 32];

/// Scenes after which a run that nobody watches says how far it is.
const STEP: u64 = 50;

/// Failing scenes that are shrunk, and smaller ones that are tried for each.
const SHRUNK: usize = 3;
const TRIES: usize = 60;

/// `verify --scenes`: whether nothing is beyond its gate.
pub(crate) fn run(arguments: &Arguments, gates: &Gates) -> Result<bool, Box<dyn Error>> {
    let cases = arguments.cases.unwrap_or(if arguments.quick { BESIDE[1] } else { CASES });
    // More scenes share the rays of so many: a larger campaign has more placements of light.
    let part = |rays: usize| rays.div_ceil(usize::try_from(cases.div_ceil(CASES).max(1)).unwrap_or(usize::MAX));
    let effort = Effort { rays: part(EFFORT.rays), rays_a_point: part(EFFORT.rays_a_point), ..EFFORT };
    let held = hold(cases, &effort, arguments, gates)?;
    Ok(ended(held.passed))
}

/// The scenes beside the other cases of `verify`, with half the rays.
pub(crate) fn beside(arguments: &Arguments, gates: &Gates) -> Result<Held, Box<dyn Error>> {
    let effort = Effort { rays: EFFORT.rays / 2, rays_a_point: EFFORT.rays_a_point / 2, ..EFFORT };
    hold(BESIDE[usize::from(arguments.quick)], &effort, arguments, gates)
}

fn hold(cases: u64, effort: &Effort, arguments: &Arguments, gates: &Gates) -> Result<Held, Box<dyn Error>> {
    let out = &arguments.out;
    let start = Instant::now();
    let families = arguments.scene_families();
    let bar = ProgressBar::new(cases.div_ceil(families.len() as u64) * families.len() as u64);
    bar.set_style(style());
    let (done, all) = (AtomicU64::new(0), bar.length().unwrap_or(cases));
    let table = Table::measure(&families, cases, arguments.seed, effort, |name, violations| {
        bar.set_message(name.family.name());
        bar.inc(1);
        // A long run says at once how far it is and reports its findings, in a file too.
        let count = done.fetch_add(1, Ordering::Relaxed) + 1;
        if bar.is_hidden() && count.is_multiple_of(STEP) {
            eprintln!("{count} of {all} scenes, {:.0} s", start.elapsed().as_secs_f64());
        }
        violations.iter().for_each(|violation| bar.suspend(|| eprintln!("VIOLATED {}", said(violation))));
    });
    bar.finish_and_clear();
    write_whole(&out.join("scenes.csv"), |file| table.write(file))?;
    write_whole(&out.join("scene-statements.csv"), |file| table.write_statements(file))?;
    let (scenes, judged, wrong) = (table.scenes(), table.judged(), table.wrong());
    println!(
        "{scenes} scenes, seed {}: {judged} statements judged, {wrong} broken or failed\n{}",
        arguments.seed,
        printed(&table, arguments.tables)
    );
    let mut record = Record::new("scenes", arguments.seed, scenes);
    record.note("judged", judged);
    record.note("share_off", table.share_off().map_or_else(String::new, |share| format!("{share:.4}")));
    record.note("broken_or_failed", wrong);
    record.note("seconds", format!("{:.0}", start.elapsed().as_secs_f64()));
    let requirement = gates.scenes();
    for (family, subject, part) in table.hardly_judged(&requirement) {
        let (subject, least) = (subject.name(), 100.0 * requirement.least_judged);
        record.violated(
            format_args!("{family}: {subject}: {:.0} % of the statements were judged, the gate is {least:.0} %", 100.0 * part),
            &format!("cargo xtask verify --scenes --family {family}"),
        );
    }
    if let Some(off) = table.share_off().filter(|off| *off > requirement.most_off) {
        let [off, most] = [off, requirement.most_off].map(|share| 100.0 * share);
        record.violated(
            format_args!("scenes: of {off:.1} % of the estimates the error is more than three times, the gate is {most:.1} %"),
            "cargo xtask verify --scenes",
        );
    }
    let [missed, of] = table.missed();
    record.note("certificates", of);
    record.note("certificates_missed", missed);
    let allowed = requirement.may_miss(of);
    if missed as f64 > allowed {
        record.violated(
            format_args!("scenes: {missed} of {of} certificates failed, the gate is {allowed:.1}"),
            "cargo xtask verify --scenes",
        );
    }
    if wrong > requirement.broken {
        for violation in &table.violations {
            report(violation, &mut record);
        }
        shrink_some(&table.violations, out)?;
    }
    if judged == 0 {
        record.violated("scenes: nothing was judged", "cargo xtask verify --scenes");
    }
    Ok(Held { passed: record.write(out)?, scenes, judged })
}

/// The families chosen that are asked this.
fn asked(subject: Subject, arguments: &Arguments) -> Vec<Family> {
    let families = arguments.scene_families().into_iter();
    families.filter(|family| family.subjects(0).contains(&subject)).collect()
}

/// Brackets of at least so many factors against rays: whether none is refuted.
pub(crate) fn brackets(pairs: u64, arguments: &Arguments, gates: &Gates) -> Result<bool, Box<dyn Error>> {
    let (start, out) = (Instant::now(), &arguments.out);
    let bar = ProgressBar::new(pairs);
    bar.set_style(style());
    let brackets = Brackets::measure(&asked(Subject::Factors, arguments), pairs, arguments.seed, |name, row| {
        bar.set_message(name.family.name());
        bar.inc(row.pairs);
    });
    bar.finish_and_clear();
    write_whole(&out.join("factor-brackets.csv"), |file| brackets.write(file))?;
    let (tried, outside) = (brackets.pairs(), brackets.outside.len());
    let mut printed = Ranked::new(&brackets::HEADER);
    for (family, row) in &brackets.rows {
        printed.add(row.outside as f64 * 1e6 + row.error_over_bound, row.cells(*family).into());
    }
    println!(
        "{tried} factors of pairs of faces, seed {}: {outside} brackets outside\n{}",
        arguments.seed,
        printed.printed(arguments.tables)
    );
    let mut record = Record::new("factors", arguments.seed, tried);
    record.note("outside", outside);
    record.note("seconds", format!("{:.0}", start.elapsed().as_secs_f64()));
    if outside as u64 > gates.scenes().broken {
        for one in &brackets.outside {
            record.violated(format_args!("{}: {}", one.name, one.said), &format!("cargo xtask replay {}", one.name));
        }
    }
    if tried < pairs {
        record.violated(format_args!("factors: {tried} pairs were tried of {pairs}"), "cargo xtask verify --factors");
    }
    record.write(out)
}

/// Gradients at the points of so many scenes: whether they are as near to the truth as the gates demand.
pub(crate) fn gradients(scenes: u64, arguments: &Arguments, gates: &Gates) -> Result<bool, Box<dyn Error>> {
    let (start, out, families) = (Instant::now(), &arguments.out, asked(Subject::Solve, arguments));
    let bar = ProgressBar::new(scenes.div_ceil(families.len() as u64) * families.len() as u64);
    bar.set_style(style());
    let gradients = Gradients::measure(&families, scenes, arguments.seed, |name| {
        bar.set_message(name.family.name());
        bar.inc(1);
    });
    bar.finish_and_clear();
    write_whole(&out.join("gradients.csv"), |file| gradients.write(file))?;
    let mut printed = Ranked::new(&gradients::HEADER);
    for (family, row) in &gradients.rows {
        printed.add(1.0 - row.within() as f64 / row.errors.len().max(1) as f64, row.cells(*family));
    }
    let (count, share, requirement) = (gradients.count(), gradients.share_within(), gates.scenes());
    println!(
        "{count} gradients, seed {}: {:.1} % within 1 %, estimate over error {:.1} in the median\n{}",
        arguments.seed,
        100.0 * share,
        gradients.median_estimate().unwrap_or(f64::NAN),
        printed.printed(arguments.tables)
    );
    for (name, slope) in &gradients.beyond {
        let (error, estimate) = (100.0 * slope.error(), slope.estimate_over_error());
        println!(
            "{name}: point {}, channel {}: off by {error:.1} %, estimated {estimate:.1e} times that",
            slope.probe, slope.channel
        );
    }
    let mut record = Record::new("gradients", arguments.seed, scenes);
    record.note("gradients", count);
    record.note("within_1_percent", format!("{share:.4}"));
    record.note("seconds", format!("{:.0}", start.elapsed().as_secs_f64()));
    let command = "cargo xtask verify --gradients";
    for (name, why) in &gradients.failed {
        record.violated(format_args!("gradients: {name} has no answer: {why}"), &format!("cargo xtask replay {name}"));
    }
    if gradients.share_judged() < requirement.least_judged {
        let (part, least) = (100.0 * gradients.share_judged(), 100.0 * requirement.least_judged);
        record.violated(format_args!("gradients: {part:.0} % were judged, the gate is {least:.0} %"), command);
    }
    // Of no gradients there is no share.
    if share.is_nan() || share < requirement.least_gradients {
        let least = 100.0 * requirement.least_gradients;
        record.violated(format_args!("gradients: {:.1} % are within 1 %, the gate is {least:.0} %", 100.0 * share), command);
    }
    if let Some(median) = gradients.median_estimate().filter(|median| *median > requirement.most_gradient_estimate) {
        let allowed = requirement.most_gradient_estimate;
        record.violated(
            format_args!("gradients: the median of estimates over errors is {median:.1}, the gate is {allowed}"),
            command,
        );
    }
    record.write(out)
}

/// How scenes fared.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Held {
    pub(crate) passed: bool,
    pub(crate) scenes: u64,
    /// Statements held against truth.
    pub(crate) judged: u64,
}

fn report(violation: &Violation, record: &mut Record) {
    record.violated(said(violation), &format!("cargo xtask replay {}", violation.name));
}

/// The scene, the subject, and the first of their faults.
fn said(violation: &Violation) -> String {
    let Violation { name, subject, faults } = violation;
    let more = faults.len().saturating_sub(1);
    let more_faults = if more == 0 { String::new() } else { format!(", and {more} more") };
    let first = faults.first().map_or("", String::as_str);
    format!("{name}: {}: {first}{more_faults}", subject.name())
}

fn printed(table: &Table, all_rows: bool) -> String {
    let mut printed = Ranked::new(&[
        "family",
        "asked",
        "scenes",
        "held",
        "broken",
        "off",
        "missed",
        "rough",
        "refused",
        "failed",
        "bound / error\nmedian",
        "estimate / error\nmedian",
        "half-width / mean\nmedian",
        "seconds\nan answer",
    ]);
    let figure = |value: Option<f64>| value.map_or_else(String::new, |value| format!("{value:.1e}"));
    for ((family, subject), row) in &table.rows {
        let Row { scenes, held, broken, off, missed, rough, refused, failed, .. } = row;
        let mut cells = vec![family.to_string(), subject.name().to_owned()];
        cells.extend([scenes, held, broken, off, missed, rough, refused, failed].map(u64::to_string));
        cells.extend([row.median_over_error(), row.median_estimate(), row.median_width()].map(figure));
        cells.push(format!("{:.2}", row.seconds_an_answer()));
        // Wrong first, then far beyond its estimate, then slow.
        let wrong = (broken + failed + missed) as f64 * 1e6 + *off as f64 * 1e3;
        printed.add(wrong + row.seconds_an_answer(), cells);
    }
    printed.printed(all_rows)
}

/// The first failing scenes of different families with the fewest faces, written as OBJ.
fn shrink_some(violations: &[Violation], out: &Path) -> Result<(), Box<dyn Error>> {
    let mut of_families: Vec<&Violation> = Vec::new();
    for violation in violations {
        if of_families.iter().all(|other| other.name.family != violation.name.family) {
            of_families.push(violation);
        }
    }
    for Violation { name, subject, .. } in of_families.into_iter().take(SHRUNK) {
        let model = name.model();
        let mut tries = 0;
        let fails = |smaller: &Model| {
            tries += 1;
            if tries > TRIES {
                return false;
            }
            let outcome = judge(smaller, *subject, &EFFORT);
            // A scene that became none does not show the fault that is sought.
            let same = matches!(outcome.ending, Ending::Judged(_) | Ending::Panicked | Ending::OtherDigits(..));
            same && outcome.fails(smaller)
        };
        let small = shrink(&model, fails);
        let files = write(&small, &name.to_string().replace(':', "-"), out)?;
        println!("  {name} with {} of {} faces: {}", small.parts.len(), model.parts.len(), files.display());
    }
    Ok(())
}

/// Writes a scene as OBJ, MTL and points beside each other; the OBJ's path.
fn write(model: &Model, name: &str, out: &Path) -> Result<PathBuf, Box<dyn Error>> {
    let folder = out.join("scenes");
    fs::create_dir_all(&folder)?;
    let [obj, mtl] = model.to_obj(&format!("{name}.mtl"));
    files::write(&folder.join(format!("{name}.mtl")), mtl)?;
    files::write(&folder.join(format!("{name}.points.jsonl")), model.to_points())?;
    let file = folder.join(format!("{name}.obj"));
    files::write(&file, obj)?;
    Ok(file)
}

/// Everything that is said of one scene; writes it as OBJ. Whether nothing is wrong.
pub(crate) fn replay(name: Name) -> Result<bool, Box<dyn Error>> {
    let model = name.model();
    let file = write(&model, &name.to_string().replace(':', "-"), Path::new("target/verify"))?;
    println!("{name}: {} faces, {:?}, {:?}: {}", model.parts.len(), model.expected, model.change, file.display());
    let mut right = true;
    for &subject in name.family.subjects(0) {
        let outcome = judge(&model, subject, &EFFORT);
        let (answer, truth) = (outcome.answer.as_secs_f64(), outcome.truth.as_secs_f64());
        println!("{}: {answer:.2} s, truth {truth:.2} s", subject.name());
        match &outcome.ending {
            Ending::Judged(all) => {
                for one in all {
                    let (statement, interval) = (one.statement, one.known.interval);
                    println!(
                        "  {:?} {:32} {:.9e} +- {:.2e}, truth {:.9e} in [{:.6e}, {:.6e}]",
                        one.verdict,
                        statement.of.name(),
                        statement.value,
                        statement.stated.size(),
                        one.known.value,
                        interval.low,
                        interval.high
                    );
                }
            }
            Ending::Refused(why) => println!("  refused: {why}"),
            other => println!("  {other:?}"),
        }
        for fault in outcome.faults(&model) {
            println!("VIOLATED {name}: {}: {fault}", subject.name());
        }
        right &= !outcome.fails(&model);
    }
    Ok(right)
}
