//! The small setting of the audit as a program. `cargo xtask mutants` builds it with faults to plant. It prints a line of JSON
//! for each finding, and its exit status is 1 if there is one.
//!
//! `cargo run -p radgrad-audit --example bite`
//!
//! With `search ROUNDS` it climbs from the recorded witnesses until a bound is broken, and writes the cases that break one; with
//! `record ROUNDS` it climbs to the end, and writes the two worst cases of each place; with `ordinary CASES` it writes as many cases
//! of some families, whose bounds are to be remembered though nothing comes near them.

use std::error::Error;
use std::path::Path;
use std::process::ExitCode;

use radgrad_audit::bite::{Setting, bite};
use radgrad_audit::family::Family;
use radgrad_audit::gates::Gates;
use radgrad_audit::search::Search;
use radgrad_audit::witness::{self, Ask, Held, Witness};

fn main() -> Result<ExitCode, Box<dyn Error>> {
    let data = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../data");
    let gates = Gates::from_toml(&std::fs::read_to_string(data.join("gates.toml"))?)?;
    let witnesses = witness::all(&data.join("worst"))?;
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    if let [what, rounds] = &arguments[..] {
        return match what.as_str() {
            "search" => climb(&witnesses, rounds.parse()?),
            "record" => record(&witnesses, rounds.parse()?),
            "ordinary" => ordinary(rounds.parse()?),
            _ => Err(format!("{what}: search, record or ordinary, and how many").into()),
        };
    }
    let first_only = arguments.iter().any(|argument| argument == "--first");
    let found = bite(&Setting { gates: &gates, witnesses: &witnesses, first_only });
    for wrong in &found {
        println!("{}", serde_json::json!({ "check": wrong.check, "by_record": wrong.by_record, "what": wrong.what }));
    }
    Ok(ExitCode::from(u8::from(!found.is_empty())))
}

/// Whether nothing was broken in so many rounds.
fn climb(witnesses: &[Witness], rounds: u64) -> Result<ExitCode, Box<dyn Error>> {
    let mut search = Search::from_witnesses(witnesses);
    for round in 0..rounds {
        search.climb(77, round);
        let broken: Vec<&Witness> =
            search.places.values().flat_map(|worst| &worst.worst).filter(|witness| witness.ratio > 1.0).collect();
        if !broken.is_empty() || !search.faults.is_empty() {
            for witness in broken {
                println!("{}", serde_json::to_string(witness)?);
            }
            for (ask, case, fault) in &search.faults {
                eprintln!("{ask}: {fault}: {}", serde_json::to_string(case)?);
            }
            return Ok(ExitCode::FAILURE);
        }
    }
    if let Some(worst) = search.worst() {
        eprintln!("{} cases, the worst is {:.3}: {}", search.asked, worst.ratio, worst.place);
    }
    Ok(ExitCode::SUCCESS)
}

fn record(witnesses: &[Witness], rounds: u64) -> Result<ExitCode, Box<dyn Error>> {
    let mut search = Search::from_witnesses(witnesses);
    for round in 0..rounds {
        search.climb(1, round);
    }
    for witness in search.places.values().flat_map(|worst| worst.worst.iter().take(2)) {
        println!("{}", serde_json::to_string(witness)?);
    }
    Ok(ExitCode::SUCCESS)
}

fn ordinary(cases: u64) -> Result<ExitCode, Box<dyn Error>> {
    let families = [
        Family::Generic,
        Family::Clipped,
        Family::NGon,
        Family::Contact,
        Family::NearEdge,
        Family::Grazing,
        Family::HorizonSliver,
        Family::FarClipped,
        Family::PolynomialFar,
        Family::OneScreen,
    ];
    for (family, index) in families.into_iter().flat_map(|family| (0..cases).map(move |index| (family, index))) {
        let case = family.case(21, index);
        for ask in [Ask::Answer(1.0), Ask::Lanes(1.0)] {
            for Held { place, bound, ratio } in ask.of(&case).held {
                println!("{}", serde_json::to_string(&Witness { place, ask, ratio, bound, case: case.clone() })?);
            }
        }
    }
    Ok(ExitCode::SUCCESS)
}
