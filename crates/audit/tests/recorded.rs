//! What is recorded in `data/` and beside this file, against what is measured now.

use std::fs;
use std::path::{Path, PathBuf};

use radgrad_audit::bounds::campaign;
use radgrad_audit::bounds::check::check;
use radgrad_audit::bounds::mark::Mark;
use radgrad_audit::family::Family;
use radgrad_audit::gates::{Gates, Violation};
use radgrad_audit::regression::Regression;
use radgrad_audit::run::Run;

fn data(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../data").join(name)
}

fn gates() -> Gates {
    Gates::from_toml(&fs::read_to_string(data("gates.toml")).expect("data/gates.toml")).expect("valid gates")
}

#[test]
fn no_case_that_failed_once_fails_again() {
    let regressions = Regression::all(&data("regressions")).expect("data/regressions");
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
    for Regression { name, case } in Regression::all(&data("regressions")).expect("data/regressions") {
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
