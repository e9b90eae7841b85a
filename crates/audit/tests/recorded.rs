//! The records in `data/` and beside this file, held against a run of today.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use radgrad_audit::bounds::campaign;
use radgrad_audit::bounds::check::check;
use radgrad_audit::bounds::mark::Mark;
use radgrad_audit::bounds::witness::{self, Place};
use radgrad_audit::cases::family::Family;
use radgrad_audit::checks::regression::Regression;
use radgrad_audit::gates::{Gates, Violation};
use radgrad_audit::measures::measure::Quantity;
use radgrad_audit::measures::run::Run;

fn data(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../data").join(name)
}

fn gates() -> Gates {
    Gates::from_toml(&fs::read_to_string(data("gates.toml")).expect("data/gates.toml")).expect("valid gates")
}

#[test]
fn no_case_that_failed_once_fails_again() {
    let regressions = Regression::read_all(&data("regressions")).expect("data/regressions");
    assert!(!regressions.is_empty());
    let gates = gates();
    let again: Vec<Violation> = regressions.iter().flat_map(|regression| gates.violations(&regression.table())).collect();
    assert_eq!(again, []);
}

#[test]
fn a_small_run_gives_the_recorded_table_on_every_machine() {
    let table = Run::of_each(6, &Family::ALL, 1).table(|_| ());
    let (mut errors, mut outcomes) = (Vec::new(), Vec::new());
    table.write_errors(&mut errors).expect("written");
    table.write_outcomes(&mut outcomes).expect("written");
    insta::assert_snapshot!(String::from_utf8([outcomes, errors].concat()).expect("text"));
}

#[test]
fn no_bound_that_was_broken_once_is_broken_again() {
    for Regression { name, case } in Regression::read_all(&data("regressions")).expect("data/regressions") {
        let check = check(&case, &campaign::full_effort());
        assert!(!Mark::FAULTS.iter().any(|mark| check.has(*mark)), "{name}: {:?}", check.remarks);
    }
}

#[test]
fn a_small_campaign_gives_the_recorded_bounds_on_every_machine() {
    let table = campaign::table(&Run::of_each(14, &Family::ALL, 1), || ());
    let mut bounds = Vec::new();
    table.write_bounds(&mut bounds).expect("written");
    insta::assert_snapshot!(String::from_utf8(bounds).expect("text"));
}

#[test]
fn a_small_run_is_within_the_gates() {
    let table = Run::of_each(6, &Family::ALL, 4).table(|_| ());
    assert_eq!(gates().violations(&table), []);
}

#[test]
fn no_gate_is_above_ten_times_the_recorded_worst() {
    let gates = gates();
    let mut reader = csv::Reader::from_path(data("tables/errors.csv")).expect("data/tables/errors.csv");
    let rows: Vec<[String; 7]> = reader.deserialize().map(|row| row.expect("seven columns")).collect();
    let mut held = 0;
    for [family, quantity, count, _, _, worst, case] in &rows {
        // A quantity over a bound has 1 for its gate; and of few cases the worst says little.
        if quantity.ends_with("-over-bound") || count.parse::<u64>().expect("a count") < 20 {
            continue;
        }
        let family = family.parse().expect("a family");
        let quantity = Quantity::ALL.into_iter().find(|known| known.name() == quantity).expect("a quantity");
        let decade: f64 = worst.trim_start_matches('<').parse().expect("a decade");
        let gate = gates.gate(family, quantity).expect("a gate");
        assert!(
            gate <= 10.0 * decade * (1.0 + 1e-9),
            "{family}: {}: {gate:e}, and {worst} is recorded ({case})",
            quantity.name()
        );
        held += 1;
    }
    assert!(held > 150, "{held}");
}

#[test]
fn no_recorded_case_breaks_its_bound_and_no_bound_is_smaller_than_recorded() {
    let witnesses = witness::read_all(&data("worst")).expect("data/worst");
    assert!(witnesses.len() > 100);
    let wrong: Vec<String> = witnesses
        .iter()
        .flat_map(|witness| witness.wrong().into_iter().map(|wrong| format!("{}: {}", witness.case.id, wrong.what)))
        .collect();
    assert_eq!(wrong, Vec::<String>::new());
}

#[test]
fn the_table_of_the_search_is_that_of_the_recorded_cases() {
    let mut worst: BTreeMap<Place, f64> = BTreeMap::new();
    for witness in witness::read_all(&data("worst")).expect("data/worst") {
        let largest = worst.entry(witness.place).or_default();
        *largest = largest.max(witness.ratio);
    }
    let mut reader = csv::Reader::from_path(data("tables/search.csv")).expect("data/tables/search.csv");
    let rows: Vec<[String; 8]> = reader.deserialize().map(|row| row.expect("eight columns")).collect();
    assert!(rows.len() > 60);
    for [by, emission, sight, quantity, _, ratio, _, why] in rows {
        let name = format!("{by} {emission} {sight} {quantity}");
        let place = worst.iter().find(|(place, _)| place.to_string() == name);
        let ratio_found = *place.unwrap_or_else(|| panic!("{name} has no witness")).1;
        let stated: f64 = ratio.parse().expect("a number");
        assert!((ratio_found - stated).abs() < 6e-4 || ratio_found > stated, "{name}: {ratio_found} and {stated}");
        assert!(stated >= 0.05 || why.len() > 20, "{name}: {stated} of the bound without a reason");
    }
}

#[test]
fn the_guide_has_the_table_of_the_search() {
    let mut reader = csv::Reader::from_path(data("tables/search.csv")).expect("data/tables/search.csv");
    let rows: Vec<[String; 8]> = reader.deserialize().map(|row| row.expect("eight columns")).collect();
    let mut whose: Vec<[&str; 2]> = rows.iter().map(|row| [row[0].as_str(), row[1].as_str()]).collect();
    whose.dedup();
    let guide = fs::read_to_string(data("../docs/guide/trust.md")).expect("docs/guide/trust.md");
    for [rung, emission] in whose {
        let cell = |sight: &str, quantity: &str| {
            let is_it = |row: &&[String; 8]| row[..4] == [rung, emission, sight, quantity].map(str::to_owned);
            rows.iter().find(is_it).map(|row| row[5].as_str())
        };
        let cell = |sight: &str| match [cell(sight, "value"), cell(sight, "gradient")] {
            [Some(value), Some(gradient)] => format!("{value}, {gradient}"),
            _ => String::new(),
        };
        let line = format!("| {rung} | {emission} | {} | {} | {} |", cell("whole"), cell("cut"), cell("screened"));
        assert!(guide.contains(&line), "the guide lacks: {line}");
    }
}
