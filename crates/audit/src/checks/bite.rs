//! The small setting of the audit, which takes seconds: does shipped code, or the audit itself, give a wrong answer?
//!
//! Beside cases of every family it asks cases that large runs seldom meet: the recorded witnesses of every bound, enclosures of two
//! arithmetics against each other and against core's digits, lanes and trees, small scenes; and of the audit itself whether
//! shards make the whole, and whether a wrong answer, a wrong bound and a figure beyond its gate are seen.
//!
//! `cargo xtask verify` has it in every run, and `cargo xtask mutants` runs it on shipped code with a fault planted.

mod exactness;
mod lane_derivatives;
mod oracle_units;
mod outlines;
mod scene_checks;
mod surfaces;

use std::fmt::Display;

use glam::DVec3;
use radgrad_core::evaluate_to;
use radgrad_oracle::{Arithmetic, Request, Source, enclose_source_occluded};
use rayon::prelude::*;

use crate::bounds::check::{Effort as Checks, check_by};
use crate::bounds::mark::Mark;
use crate::bounds::search::{awkward, brink};
use crate::bounds::witness::{self, Query, Witness};
use crate::bounds::{campaign, digits, table as bounds_table};
use crate::cases::family::{Family, Name};
use crate::cases::sampler::Sampler;
use crate::checks::agreement::agreement;
use crate::checks::forms::forms;
use crate::checks::record::{Asked, Record, RecordedSubject};
use crate::checks::{
    batches, closed, derivatives, derived, entries, estimates, hulls, lamps, long, motions, operations, rays, refusals, shadows,
    symmetry,
};
use crate::gates::Gates;
use crate::measures::measure::{Kind, Outcome, Quantity};
use crate::measures::run::{Part, Run};
use crate::measures::seen::reduced;
use crate::measures::shard::Shard;
use crate::measures::table::Table;
use crate::measures::truth::Truth;
use crate::scenes;

/// Something wrong.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Wrong {
    /// Which check says so.
    pub check: &'static str,
    /// Whether the answer differs from the record alone, and truth does not refute it.
    pub by_record: bool,
    /// The finding, for people.
    pub what: String,
}

/// The gates and records that the checks use.
#[derive(Debug, Clone, Copy)]
pub struct Setting<'a> {
    /// The gates that errors are held against.
    pub gates: &'a Gates,
    /// The recorded witnesses.
    pub witnesses: &'a [Witness],
    /// Recorded values and bounds of cases and scenes.
    pub records: &'a [Record],
    /// The check that goes first.
    pub first: Option<&'a str>,
    /// Which of them are made.
    pub made: Made,
}

/// Which checks are made.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Made {
    /// All.
    All,
    /// No more after one in which truth finds something.
    UntilWrong,
    /// The first one alone.
    First,
}

/// A check by its name.
type Check = (&'static str, fn(&Setting<'_>) -> Vec<Wrong>);

/// A check whose findings truth makes: the part that asks by the setting, or `=` the findings that it tells in any setting.
macro_rules! by_truth {
    ($name:literal, $check:path) => {
        ($name, |setting| told($name, $check(setting)))
    };
    ($name:literal = $told:expr) => {
        ($name, |_| told($name, $told))
    };
}

/// Findings of truth.
fn told(check: &'static str, findings: Vec<String>) -> Vec<Wrong> {
    findings.into_iter().map(|what| Wrong { check, by_record: false, what }).collect()
}

/// The checks, the quickest first.
const CHECKS: [Check; 42] = [
    by_truth!("merge", merge),
    by_truth!("canaries", canaries),
    ("witnesses", witnesses),
    by_truth!("exactness" = exactness::all_wrong(150)),
    by_truth!("outlines" = outlines::all_wrong(2000)),
    by_truth!("surfaces" = surfaces::all_wrong(160)),
    by_truth!("units" = oracle_units::all_wrong(2)),
    by_truth!("shares" = lane_derivatives::all_wrong(60)),
    by_truth!("brinks", brinks),
    by_truth!("trees", trees),
    by_truth!("refusals" = refusals::all_wrong()),
    by_truth!("symmetries" = symmetry::all_wrong()),
    by_truth!("derived" = derived::all_wrong(300)),
    by_truth!("lamps" = lamps::all_wrong(300)),
    by_truth!("long" = long::all_wrong(5)),
    by_truth!("batches" = batches::all_wrong(64)),
    by_truth!("estimates" = estimates::all_wrong()),
    by_truth!("hulls" = hulls::all_wrong(100)),
    by_truth!("lanes", lanes),
    by_truth!("exchanges", scene_checks::free_exchanges),
    by_truth!("screens", scene_checks::past_screens),
    by_truth!("hidden", scene_checks::in_beams),
    by_truth!("enclosures", enclosures),
    by_truth!("awkward", awkward_cases),
    by_truth!("closed" = closed::all_wrong(48)),
    by_truth!("rays" = rays::all_wrong(2)),
    by_truth!("shadows" = shadows::all_wrong()),
    by_truth!("pieces", scene_checks::pieces),
    by_truth!("identities" = scenes::identities::all_wrong()),
    by_truth!("alike", scene_checks::alike),
    ("records", |setting| records("records", Asked::Core, setting)),
    ("oracle-records", |setting| records("oracle-records", Asked::Oracle, setting)),
    ("scene-records", |setting| records("scene-records", Asked::Scenes, setting)),
    ("solver-records", |setting| records("solver-records", Asked::Solver, setting)),
    by_truth!("bounds", bounds),
    by_truth!("errors", errors),
    by_truth!("derivatives", second_derivatives),
    by_truth!("motions", motions_of_all),
    by_truth!("brackets", scene_checks::brackets),
    by_truth!("entries", other_entries),
    by_truth!("operations", single_operations),
    by_truth!("scenes", scene_checks::whole_scenes),
];

/// The names of the checks.
#[must_use]
pub fn names() -> [&'static str; CHECKS.len()] {
    CHECKS.map(|(name, _)| name)
}

/// Everything that is found wrong.
#[must_use]
pub fn bite(setting: &Setting<'_>) -> Vec<Wrong> {
    let is_first = |(name, _): &&Check| Some(*name) == setting.first;
    let checks = CHECKS.iter().filter(is_first).chain(CHECKS.iter().filter(|check| !is_first(check)));
    let mut findings = Vec::new();
    for (index, (_, run)) in checks.enumerate() {
        let is_enough = match setting.made {
            Made::All => false,
            Made::UntilWrong => findings.iter().any(|wrong: &Wrong| !wrong.by_record),
            Made::First => index > 0,
        };
        if is_enough {
            break;
        }
        findings.extend(run(setting));
    }
    findings
}

/// Recorded witnesses, asked again. That there is none is wrong too.
fn witnesses(setting: &Setting<'_>) -> Vec<Wrong> {
    again("witnesses", &setting.witnesses.iter().collect::<Vec<_>>(), Witness::wrong)
}

/// The same of the records of one answerer.
fn records(check: &'static str, asked: Asked, setting: &Setting<'_>) -> Vec<Wrong> {
    let of = |record: &&Record| record.of.asks() == asked;
    again(check, &setting.records.iter().filter(of).collect::<Vec<_>>(), Record::wrong)
}

fn again<T: Sync>(check: &'static str, recorded: &[&T], wrong: impl Fn(&T) -> Vec<witness::Wrong> + Send + Sync) -> Vec<Wrong> {
    if recorded.is_empty() {
        return vec![Wrong { check, by_record: false, what: format!("there are no recorded {check}") }];
    }
    let findings = recorded.par_iter().flat_map_iter(|recorded| wrong(recorded));
    findings.map(|witness::Wrong { by_record, what }| Wrong { check, by_record, what }).collect()
}

/// Shards, written and read back, make the whole; two alike or a missing one do not.
fn merge(_: &Setting<'_>) -> Vec<String> {
    let whole = Run { seed: 1, cases: vec![(Family::Far, 11), (Family::Generic, 4), (Family::NGon, 9)], part: Part::WHOLE };
    let outcome = |name: Name| match name.index {
        4 => Outcome::Refused("why".to_owned()),
        index => Outcome::Measured([0.0, 1e-17 * (index * 7 % 5) as f64, index as f64, 0.1 * (10 - index % 10) as f64, 0.2, 0.3]),
    };
    let table = |run: &Run| run.names().map(|name| Table::single(name, &outcome(name))).collect::<Table>();
    let shard = |index: u64| {
        let run = Run { part: Part { index, of: 3 }, ..whole.clone() };
        Shard { table: table(&run), run }
    };
    let mut findings = Vec::new();
    let back: Result<Vec<_>, _> = [2, 0, 1].map(|index| Shard::from_json(&shard(index).to_json()?)).into_iter().collect();
    match back.and_then(|shards: Vec<Shard<Kind, Quantity>>| Shard::merge(&shards)) {
        Ok(merged) if merged == (Shard { table: table(&whole), run: whole.clone() }) => {}
        Ok(_) => findings.push("three shards do not make the table of the whole".to_owned()),
        Err(error) => findings.push(format!("three shards do not merge: {error}")),
    }
    // Counted without merging.
    let counts = |table: &Table| -> Vec<u64> {
        let of = |family: &Family| table.families().get(family).map_or(0, |t| t.count(Kind::Measured) + t.count(Kind::Refused));
        [Family::Far, Family::Generic, Family::NGon].iter().map(of).collect()
    };
    if counts(&table(&whole)) != [11, 4, 9] {
        findings.push(format!("a table of 11, 4 and 9 cases counts {:?}", counts(&table(&whole))));
    }
    let counted = table(&whole);
    let worst = counted.families()[&Family::Far].figures().get(&Quantity::ValueOverCondition).and_then(|figures| figures.worst());
    if worst.is_none_or(|worst| worst.value != 10.0) {
        findings.push(format!("the worst of 0 to 10 is {worst:?}"));
    }
    let late_first =
        [5, 2].map(|index| Table::single(Name { family: Family::Far, seed: 1, index }, &Outcome::Refused(String::new())));
    let first =
        late_first.into_iter().collect::<Table>().families()[&Family::Far].counts().get(&Kind::Refused).map(|b| b.first.index);
    if first != Some(2) {
        findings.push(format!("the first of cases 5 and 2 is {first:?}"));
    }
    if Shard::merge(&[shard(0), shard(1), shard(1), shard(2)]).is_ok() {
        findings.push("a shard that is there twice is merged".to_owned());
    }
    findings
}

/// Wrong answers, wrong bounds and figures beyond their gates are seen.
fn canaries(setting: &Setting<'_>) -> Vec<String> {
    let mut findings = Vec::new();
    let case = Family::Generic.case(1, 0);
    let ask = |factor: f64| {
        move |problem: &radgrad_scene::case::Problem, tolerance: f64| {
            let mut answer = evaluate_to(&problem.receiver, &problem.emitter, &problem.occluders, tolerance)?;
            if tolerance > 0.0 {
                answer.radiosity += factor * answer.radiosity_error;
                answer.gradient.x += factor * answer.gradient_error;
            }
            Ok(answer)
        }
    };
    let effort = Checks { digits: true, ..Checks::LEAST };
    if !check_by(&case, &effort, ask(2.5)).has(Mark::Broken) {
        findings.push("an answer that is off by 2.5 bounds is not seen".to_owned());
    }
    if check_by(&case, &effort, ask(0.0)).has(Mark::Broken) {
        findings.push("an answer that is right is called broken".to_owned());
    }
    if let Ok(problem) = case.problem()
        && let Ok(truth) = Truth::of_problem(&problem)
    {
        let size = truth.radiosity_magnitude();
        let (least, _) = truth.errors_at_least(truth.radiosity.to_f64() + 1e-6 * size, DVec3::ZERO);
        if !(0.999e-6..1.001e-6).contains(&(least / size)) {
            findings.push(format!("a radiosity that is off by 1e-6 is held to be off by {:e} at least", least / size));
        }
    }
    for quantity in Quantity::ALL {
        let gate = setting.gates.gate(Family::Generic, quantity).unwrap_or(0.0);
        let of = |factor: f64| {
            let mut figures = [0.0; 6];
            figures[quantity as usize] = factor * gate;
            let name = Name { family: Family::Generic, seed: 1, index: 0 };
            setting.gates.violations(&Table::single(name, &Outcome::Measured(figures))).len()
        };
        if [of(1.0), of(1.01)] != [0, 1] {
            findings.push(format!("{} at its gate and 1 % above: {} and {} violations", quantity.name(), of(1.0), of(1.01)));
        }
    }
    if let Ok(problem) = case.problem()
        && let Ok(answer) = evaluate_to(&problem.receiver, &problem.emitter, &problem.occluders, 1e-12)
    {
        let size = answer.gradient.length();
        let wrong = radgrad_core::Answer { gradient: answer.gradient + DVec3::new(1e-6 * size, 0.0, 0.0), ..answer };
        let figure = crate::measures::measure::measure_answer(&problem, &wrong).figure(Quantity::Gradient).unwrap_or(0.0);
        if !(0.999e-6..1.001e-6).contains(&figure) {
            findings.push(format!("a gradient that is off by 1e-6 is measured to be off by {figure:e}"));
        }
    }
    findings
}

/// Lanes of double and single precision, with the bounds that they state themselves; and polygons of many edges cut by the horizon.
fn lanes(_: &Setting<'_>) -> Vec<String> {
    let families = [Family::Generic, Family::Clipped, Family::Far, Family::HorizonSliver, Family::NGon, Family::NearEdge];
    let names = names_of(&families, 16, 9);
    let ask = |name: &Name| {
        let case = name.case();
        [Query::Lanes(1.0), Query::SingleLanes(1.0)].into_iter().flat_map(|ask| complaints(name, ask, &case)).collect::<Vec<_>>()
    };
    let cut = |name: &Name| {
        let mut case = name.case();
        tilt(&mut case);
        let asks = [Query::Answer(1e-12), Query::Answer(1e-16), Query::Lanes(1.0)];
        asks.into_iter().flat_map(|ask| complaints(&format_args!("{name}, tilted"), ask, &case)).collect::<Vec<_>>()
    };
    let many_sided = names_of(&[Family::NGon, Family::Concave], 16, 9);
    names.par_iter().flat_map_iter(ask).chain(many_sided.par_iter().flat_map_iter(cut)).collect()
}

/// Turns the receiver so that its horizon is through the middle of the emitter.
fn tilt(case: &mut radgrad_scene::case::Case) {
    let (x, vertices) = (DVec3::from(case.receiver.position), &case.emitter.vertices);
    let middle = vertices.iter().map(|v| DVec3::from(*v) - x).sum::<DVec3>();
    let tilted = middle.cross(DVec3::from(vertices[0]) - x);
    if let Some(normal) = tilted.try_normalize() {
        case.receiver.normal = normal.to_array();
    }
}

fn complaints(name: &impl Display, ask: Query, case: &radgrad_scene::case::Case) -> Vec<String> {
    let asked = ask.check(case);
    let broken = asked.held.iter().filter(|held| held.ratio > 1.0);
    let broken = broken.map(|held| format!("{name}, {ask}, {}: broken by a factor of {:.3}", held.place, held.ratio));
    broken.chain(asked.faults.iter().map(|fault| format!("{name}, {fault}"))).collect()
}

/// Cases on the brink of every decision.
fn awkward_cases(_: &Setting<'_>) -> Vec<String> {
    let ask = |index: u64| {
        let case = awkward(&mut Sampler::new(4, "awkward", index));
        let asks = [Query::Answer(1.0), Query::Answer(1e-12), Query::Lanes(1.0)].into_iter();
        asks.flat_map(|ask| complaints(&format_args!("awkward:4:{index}"), ask, &case)).collect::<Vec<_>>()
    };
    (0..80u64).into_par_iter().flat_map_iter(ask).collect()
}

/// Receivers and emitters in each other's planes to a few roundings and less, against the oracle, which decides with integers.
fn brinks(_: &Setting<'_>) -> Vec<String> {
    let ask = |index: u64| {
        let case = brink(&mut Sampler::new(5, "brinks", index));
        let name = format!("brinks:5:{index}");
        let mut findings: Vec<String> =
            [Query::Answer(1.0), Query::Answer(1e-12), Query::Value(1.0), Query::Lanes(1.0), Query::SingleLanes(1.0)]
                .into_iter()
                .flat_map(|ask| complaints(&name, ask, &case))
                .collect();
        findings.extend(off_the_oracle(&name, &case));
        findings
    };
    (0..200u64).into_par_iter().flat_map_iter(ask).collect()
}

/// Answers in doubles that the oracle contradicts. Core's digits decide by the same predicates as its doubles; the oracle does not.
fn off_the_oracle(name: &str, case: &radgrad_scene::case::Case) -> Vec<String> {
    let Ok(problem) = case.problem() else { return vec![format!("{name}: refused")] };
    // A surface that is not flat is another one by each vertex that it is named by first; answers must agree whatever the truth is.
    if problem.emitter.polygon().planarity_defect() > 0.0 {
        let contradicted = |ask: Query| {
            let apart = witness::apart_from_other_names(ask, &problem);
            (apart > 1.0).then(|| format!("{name}, {ask}: {apart:.3} bounds from what it is by another vertex named first"))
        };
        return [Query::Answer(1.0), Query::Answer(1e-12)].into_iter().filter_map(contradicted).collect();
    }
    let request = Request { digits: 15, arithmetic: Some(Arithmetic::DoubleDouble), budget: 20_000 };
    let Ok(enclosure) = enclose_source_occluded(&problem.receiver, &Source::Emitter(&problem.emitter), &[], &request) else {
        return Vec::new();
    };
    let truth = Truth { radiosity: enclosure.radiosity, gradient: enclosure.gradient };
    let contradicts = |ask: Query| {
        let Ok(Some((_, answer))) = ask.answer(&problem) else { return None };
        let (value, gradient) = truth.errors_at_least(answer.radiosity, answer.gradient);
        let is_off = value > answer.radiosity_error || gradient > answer.gradient_error;
        is_off.then(|| format!("{name}, {ask}: {answer:?}, the oracle has {:e}", truth.radiosity.to_f64()))
    };
    [Query::Answer(1.0), Query::Answer(1e-12), Query::Lanes(1.0)].into_iter().filter_map(contradicts).collect()
}

/// A bent sheet of lamps by a tree, against its lamps one by one.
fn trees(_: &Setting<'_>) -> Vec<String> {
    let ask = |index: u64| {
        let said = RecordedSubject::Tree(index).asked(None);
        let findings = said.map_or_else(|error| vec![error], |said| said.wrong);
        named(format_args!("receiver {index}"), findings)
    };
    (0..40u64).into_par_iter().flat_map_iter(ask).collect()
}

/// Enclosures in two arithmetics and core's digits have points in common, and so have answers of cubature and sampling.
fn enclosures(setting: &Setting<'_>) -> Vec<String> {
    let families = [
        Family::Generic,
        Family::Clipped,
        Family::Contact,
        Family::NGon,
        Family::OneScreen,
        Family::SteepExtension,
        Family::PolynomialClipped,
        Family::Far,
    ];
    let names = names_of(&families, 2, 2);
    let compare = |name: &Name| {
        let Ok(problem) = name.case().problem() else { return vec![format!("{name}: refused")] };
        let (emitter, occluders) = reduced(&problem);
        let source = Source::Emitter(&emitter);
        let enclosed = |digits, arithmetic| {
            let request = Request { digits, arithmetic: Some(arithmetic), budget: 50_000_000 };
            let enclosure = enclose_source_occluded(&problem.receiver, &source, occluders, &request).ok()?;
            Some(Truth { radiosity: enclosure.radiosity, gradient: enclosure.gradient })
        };
        let precise = match digits::enclosure(&problem, 60) {
            Ok(precise) => precise,
            Err(why) => return vec![format!("{name}: 60 digits: {why}")],
        };
        let mut ways = Vec::new();
        for digits in [15, 20, 23] {
            ways.push((format!("the oracle's {digits} digits in double-double"), enclosed(digits, Arithmetic::DoubleDouble)));
        }
        // Every arithmetic but the dearest family's.
        if name.index < 1 {
            ways.push(("the oracle's 20 digits in more bits".to_owned(), enclosed(20, Arithmetic::Astro)));
        }
        for digits in [20, 36] {
            ways.push((format!("the oracle's {digits} digits on limbs"), enclosed(digits, Arithmetic::Limbs)));
        }
        for digits in [25, 40, 100] {
            ways.push((format!("core's {digits} digits"), digits::enclosure(&problem, digits).ok()));
        }
        let differ = |(way, truth): &(String, Option<Truth>)| {
            let apart = !truth.as_ref()?.overlaps(&precise);
            apart.then(|| format!("{name}: {way} and core's 60 digits have nothing in common"))
        };
        let mut findings: Vec<String> = ways.iter().filter_map(differ).collect();
        if ways.iter().take(2).all(|(_, truth)| truth.is_none()) && !matches!(name.family, Family::Contact) {
            findings.push(format!("{name}: the oracle has no enclosure in double-double"));
        }
        findings
    };
    let mut findings: Vec<String> = names.par_iter().flat_map_iter(compare).collect();
    findings.extend(forms(3, 1).1.iter().map(ToString::to_string));
    let run = Run::of_each(2, &[Family::Generic, Family::Clipped, Family::OneScreen, Family::BackFacing], 6);
    let agreed = agreement(&run, 2, setting.gates.appendix_a());
    findings.extend(agreed.contradictions.iter().map(ToString::to_string));
    if agreed.cubature == 0 || agreed.enclosed == 0 {
        findings.push(format!("no case is enclosed, or none converged by cubature: {agreed:?}"));
    }
    findings
}

/// A small bounds campaign: the first case of a family is asked for many digits too, so that it has one of three.
fn bounds(setting: &Setting<'_>) -> Vec<String> {
    let families: Vec<Family> = cheap().step_by(3).collect();
    let table: bounds_table::Table = campaign::table(&Run::of_each(12, &families, 1), || ());
    let faults = setting.gates.breaches(&table).into_iter().filter(|breach| breach.mark.is_some());
    faults.map(|breach| breach.to_string()).collect()
}

/// A few cases of every family against the gates.
fn errors(setting: &Setting<'_>) -> Vec<String> {
    let families: Vec<Family> = cheap().collect();
    let table = Run::of_each(2, &families, 6).table(|_| ());
    setting.gates.violations(&table).iter().map(ToString::to_string).collect()
}

fn cheap() -> impl Iterator<Item = Family> {
    Family::ALL.into_iter().filter(|family| family.dearness() == 1)
}

/// The first cases of each family.
fn names_of(families: &[Family], count: u64, seed: u64) -> Vec<Name> {
    families.iter().flat_map(|&family| (0..count).map(move |index| Name { family, seed, index })).collect()
}

/// Findings with the name of the thing that they are about.
fn named(name: impl Display, findings: impl IntoIterator<Item = String>) -> Vec<String> {
    findings.into_iter().map(|finding| format!("{name}: {finding}")).collect()
}

/// Second derivatives and irradiance vectors against differences and turned receivers.
fn second_derivatives(_: &Setting<'_>) -> Vec<String> {
    let families = [
        Family::Generic,
        Family::Far,
        Family::Clipped,
        Family::NGon,
        Family::Concave,
        Family::NearEdge,
        Family::PolynomialFar,
        Family::PolynomialClipped,
        Family::OneScreen,
        Family::Contact,
    ];
    let names = names_of(&families, 1, 14);
    let ask = |name: &Name| {
        let problem = name.case().problem().ok()?;
        let [rough, fine] = [1.0, 1e-12].map(|tolerance| derivatives::wrong(&problem, tolerance));
        Some(named(name, rough?.into_iter().chain(fine?)))
    };
    let told: Vec<Option<Vec<String>>> = names.par_iter().map(ask).collect();
    let mut findings = Vec::new();
    if 2 * told.iter().flatten().count() < names.len() {
        findings.push("less than half of the cases have derivatives to compare with".to_owned());
    }
    findings.extend(told.into_iter().flatten().flatten());
    findings
}

/// Derivatives by everything that shapes the light of a point.
fn motions_of_all(_: &Setting<'_>) -> Vec<String> {
    let families = [
        Family::Generic,
        Family::Far,
        Family::Clipped,
        Family::Contact,
        Family::NearVertex,
        Family::Needle,
        Family::Concave,
        Family::NGon,
        Family::PolynomialFar,
        Family::PolynomialClipped,
        Family::OneScreen,
        Family::NearScreen,
        Family::DippingScreen,
        Family::Boxes,
    ];
    let campaign = motions::campaign(&Run::of_each(2, &families, 15), true, |_| ());
    let mut findings: Vec<String> = campaign.wrong.iter().map(|(name, finding)| format!("{name}: {finding}")).collect();
    if 2.0 * campaign.compared() < 1.0 || campaign.rows.len() < families.len() {
        findings.push(format!("{:.2} of the cases have slopes to compare with", campaign.compared()));
    }
    findings.extend(motions::of_special_cases());
    findings
}

/// Running bounds of single operations.
fn single_operations(_: &Setting<'_>) -> Vec<String> {
    (0..4000u64).into_par_iter().flat_map_iter(operations::wrong).collect()
}

/// Core's answers without bounds, and operations on matrices of form factors.
fn other_entries(_: &Setting<'_>) -> Vec<String> {
    use scenes::family::Family as Scenes;
    let families =
        [Family::Generic, Family::Clipped, Family::NGon, Family::Concave, Family::BackFacing, Family::PolynomialClipped];
    let names = names_of(&families, 6, 15);
    let plain = |name: &Name| {
        let findings = name.case().problem().map_or_else(|error| vec![error.to_string()], |problem| entries::plain(&problem));
        named(name, findings)
    };
    let mut findings: Vec<String> = names.par_iter().flat_map_iter(plain).collect();
    let scenes = [Scenes::Clutter, Scenes::Furnace, Scenes::Touching, Scenes::Slit, Scenes::Open, Scenes::Textured];
    let of_matrix = |&family: &Scenes| {
        let name = scenes::family::Name { family, seed: 15, index: 0 };
        let findings = entries::of_matrix(name).unwrap_or_else(|error| vec![error]);
        named(name, findings)
    };
    findings.extend(scenes.par_iter().flat_map_iter(of_matrix).collect::<Vec<_>>());
    let of_rounding = |index: u64| {
        let name = scenes::family::Name { family: Scenes::Rounded, seed: 15, index };
        named(name, entries::of_rounding(name).unwrap_or_else(|error| vec![error]))
    };
    findings.extend((0..3u64).into_par_iter().flat_map_iter(of_rounding).collect::<Vec<_>>());
    findings.extend(entries::of_repairs().unwrap_or_else(|error| vec![error]));
    findings
}

#[cfg(test)]
mod tests {
    use super::*;

    fn gates() -> Gates {
        Gates::from_toml(include_str!("../../../../data/gates.toml")).unwrap()
    }

    fn without_records(gates: &Gates) -> Setting<'_> {
        Setting { gates, witnesses: &[], records: &[], first: None, made: Made::All }
    }

    #[test]
    fn a_run_without_a_witness_says_so() {
        let gates = gates();
        let setting = without_records(&gates);
        assert_eq!([witnesses(&setting), records("records", Asked::Core, &setting)].map(|findings| findings.len()), [1, 1]);
    }

    #[test]
    fn nothing_is_wrong_with_derivatives_by_everything() {
        let gates = gates();
        let setting = without_records(&gates);
        assert_eq!(motions_of_all(&setting), Vec::<String>::new());
    }

    #[test]
    fn nothing_is_wrong_with_shards_canaries_trees_derivatives_and_other_entries() {
        let gates = gates();
        let setting = without_records(&gates);
        for check in [merge, canaries, trees, second_derivatives, other_entries] {
            assert_eq!(check(&setting), Vec::<String>::new());
        }
    }
}
