//! Wrong bounds and wrong answers, planted: the campaign must see them.

use radgrad_core::{Answer, Error, Method, evaluate_to};
use radgrad_scene::case::Problem;

use crate::bounds::campaign::{self, effort};
use crate::bounds::check::{Check, Effort, check, check_by};
use crate::bounds::mark::{Figure, Mark};
use crate::bounds::table::Table;
use crate::cases::family::{Family, Name};
use crate::cases::shrink::weight;
use crate::checks::regression::Regression;
use crate::gates::Gates;
use crate::measures::run::{Part, Run};
use crate::measures::shard::Shard;

const BY_CORE: Effort = Effort::LEAST;

fn by_digits() -> Effort {
    Effort { digits: true, ..Effort::LEAST }
}

fn by_oracle() -> Effort {
    Effort { oracle: true, ..Effort::LEAST }
}

fn honest(problem: &Problem, tolerance: f64) -> Result<Answer, Error> {
    evaluate_to(&problem.receiver, &problem.emitter, &problem.occluders, tolerance)
}

fn names(family: Family, count: u64) -> impl Iterator<Item = Name> {
    (0..count).map(move |index| Name { family, seed: 3, index })
}

/// In how many of the first cases of a family a bound is broken when answers are changed so.
fn broken(family: Family, count: u64, effort: &Effort, change: impl Fn(&mut Answer, f64)) -> usize {
    let changed = |problem: &Problem, tolerance: f64| {
        let mut answer = honest(problem, tolerance)?;
        change(&mut answer, tolerance);
        Ok(answer)
    };
    names(family, count).filter(|name| check_by(&name.case(), effort, changed).has(Mark::Broken)).count()
}

#[test]
fn honest_answers_break_nothing() {
    // Of rounded outlines some answers miss a tolerance: their vertices leave more open.
    for family in Family::ALL.into_iter().filter(|family| !family.is_rounded()) {
        for name in names(family, 8_u64.div_ceil(family.dearness())) {
            let check = check(&name.case(), &Effort { loose: vec![1.0, 1e-6], digits: true, ..by_oracle() });
            assert!(!Mark::FAULTS.iter().any(|mark| check.has(*mark)), "{name}: {:?}", check.remarks);
        }
    }
}

#[test]
fn bounds_a_hundred_times_too_small_are_seen_by_cores_own_truth() {
    for family in [Family::Generic, Family::Contact] {
        let shrunk = |answer: &mut Answer, tolerance: f64| {
            if tolerance > 0.0 {
                answer.radiosity_error *= 0.01;
                answer.gradient_error *= 0.01;
            }
        };
        assert!(broken(family, 100, &BY_CORE, shrunk) > 10, "{family}");
        assert_eq!(broken(family, 100, &BY_CORE, |_, _| ()), 0);
    }
}

#[test]
fn a_bound_without_the_rounding_to_doubles_is_seen_by_digits_alone() {
    let forget = |answer: &mut Answer, _: f64| {
        if answer.method == Method::DoubleDouble {
            answer.radiosity_error -= 0.5 * f64::EPSILON * answer.radiosity.abs();
        }
    };
    assert!(broken(Family::NearEdge, 20, &by_digits(), forget) > 10);
}

#[test]
fn a_gradient_bound_that_holds_for_components_only_is_seen_by_digits() {
    let component = |answer: &mut Answer, _: f64| answer.gradient_error /= 3f64.sqrt();
    assert!(broken(Family::NearEdge, 60, &by_digits(), component) > 0);
    assert_eq!(broken(Family::NearEdge, 60, &by_digits(), |_, _| ()), 0);
}

#[test]
fn a_slip_that_all_rungs_share_is_seen_by_the_oracle_and_not_by_cores_own_truth() {
    let slip = |answer: &mut Answer, _: f64| answer.gradient.x *= 1.0 + 1e-10;
    assert_eq!(broken(Family::Generic, 10, &BY_CORE, slip), 0);
    assert_eq!(broken(Family::Generic, 10, &by_oracle(), slip), 10);
    let dark = |answer: &mut Answer, _: f64| {
        let zero = glam::DVec3::ZERO;
        *answer = Answer { radiosity: 0.0, gradient: zero, radiosity_error: 0.0, gradient_error: 0.0, method: Method::Zero };
    };
    assert_eq!(broken(Family::FarClipped, 10, &by_oracle(), dark), 10);
}

#[test]
fn what_is_not_answered_or_not_finite_or_not_met_is_marked() {
    let name = Name { family: Family::Generic, seed: 3, index: 1 };
    let marked = |change: &dyn Fn(Answer) -> Result<Answer, Error>| -> Check {
        check_by(&name.case(), &BY_CORE, |problem, tolerance| honest(problem, tolerance).and_then(change))
    };
    assert!(marked(&|_| Err(Error::Overflow { quantity: "gradient" })).has(Mark::Unanswered));
    assert!(marked(&|answer| Ok(Answer { radiosity_error: f64::NAN, ..answer })).has(Mark::NonFinite));
    let loose = marked(&|answer| Ok(Answer { gradient_error: 1e-14 * answer.gradient.length(), ..answer }));
    assert!(loose.has(Mark::MissesTight) && !loose.has(Mark::MissesDefault) && !loose.has(Mark::Broken), "{loose:?}");
    let boundless = marked(&|answer| Ok(Answer { gradient_error: f64::INFINITY, ..answer }));
    assert!(boundless.has(Mark::MissesDefault) && boundless.has(Mark::Blunt));
}

const GATES: &str = "appendix-a = 1e-9\n[bounds.generic]\nfirst-rung = 1.0\ntightness = 1e-9\nworst-error = 1e-30\n";

/// Gates for every figure of the measurement, which these tests are not about, and some for the bounds.
fn gates() -> Gates {
    let figures: String = crate::measures::measure::Quantity::ALL.iter().map(|q| format!("{} = 1.0\n", q.name())).collect();
    let family = |family: &Family| if family.is_refused() { String::new() } else { format!("[{family}]\n{figures}") };
    Gates::from_toml(&(GATES.to_owned() + &Family::ALL.iter().map(family).collect::<String>())).expect("valid gates")
}

fn table(run: &Run) -> Table {
    campaign::table(run, || ())
}

#[test]
fn a_table_is_held_against_what_is_required() {
    let run = Run::of_each(14, &[Family::Generic, Family::BelowHorizon, Family::EqualVertices, Family::NearEdge], 1);
    let said: Vec<String> = gates().breaches(&table(&run)).iter().map(ToString::to_string).collect();
    assert_eq!(said.len(), 2, "{said:?}");
    assert!(said.iter().all(|text| text.contains("-error is") && text.contains("1e-30 is the most")), "{said:?}");

    let mut wrong = Table::default();
    let case = |family| Name { family, seed: 1, index: 4 };
    for (family, mark) in [
        (Family::Far, Mark::Broken),
        (Family::Far, Mark::MissesTight),
        (Family::BelowHorizon, Mark::Nonzero),
        (Family::EqualVertices, Mark::Zero),
        (Family::Contact, Mark::Refused),
    ] {
        wrong.count(case(family), mark);
    }
    let found_breaches = gates().breaches(&wrong);
    assert_eq!(found_breaches.len(), 5, "{found_breaches:?}");
    assert_eq!(found_breaches[0].to_string(), "bounds of far: 1 broken, at far:1:4");
    wrong.add(case(Family::Generic), Figure::ValueTightness, 1e-10);
    assert!(gates().breaches(&wrong).iter().any(|b| b.mark.is_none() && b.what.contains("the median of value-tightness")));
}

#[test]
fn shards_of_a_campaign_merge_to_the_whole_but_for_the_times() {
    let families = [Family::Generic, Family::FarClipped, Family::EqualVertices];
    let part = |index, of| campaign::run(60, &families, 2, Part { index, of });
    let written = |table: &Table| {
        let mut text = Vec::new();
        table.write_bounds(&mut text).expect("written");
        String::from_utf8(text).expect("text")
    };
    let shards: Vec<Shard<Mark, Figure>> = (0..3)
        .map(|index| Shard { run: part(index, 3), table: table(&part(index, 3)) })
        .map(|shard| Shard::from_json(&shard.to_json().expect("JSON")).expect("the same"))
        .collect();
    let merged = Shard::merge(&shards).expect("a whole");
    assert_eq!(merged.run, part(0, 1));
    assert_eq!(written(&merged.table), written(&table(&part(0, 1))));
}

#[test]
fn a_breach_of_one_case_is_shrunk_and_one_of_a_family_is_not() {
    let name = Name { family: Family::EqualVertices, seed: 1, index: 2 };
    let breach = |mark| super::requirements::Breach { case: name, mark, what: String::new() };
    let regression = Regression::of_breach(&breach(Some(Mark::Refused))).expect("it is refused");
    assert!(check(&regression.case, &effort(name)).has(Mark::Refused));
    assert!(weight(&regression.case) < weight(&name.case()));
    assert_eq!(Regression::of_breach(&breach(Some(Mark::Broken))), None);
    assert_eq!(Regression::of_breach(&breach(None)), None);
}
