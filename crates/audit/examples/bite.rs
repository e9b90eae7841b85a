//! The small setting of the audit as a program. `cargo xtask mutants` builds it with faults in it. It prints a line of JSON
//! for each finding, and its exit status is 1 if there is one.
//!
//! `cargo run -p radgrad-audit --example bite`
//!
//! `--check NAME` makes that check first; with `--until-wrong` none after one in which truth finds something, with `--alone` no other.
//!
//! With `search ROUNDS` it climbs from the recorded witnesses until a bound is broken, and writes the cases that break one; with
//! `worst ROUNDS` it climbs to the end, and writes the two worst cases of each place; with `ordinary CASES` it writes as many cases
//! of some families, whose bounds are to be remembered though nothing comes near them; with `record FILE` it asks again what the file
//! holds and writes what is said of it today.

use std::error::Error;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use radgrad_audit::bounds::search::Search;
use radgrad_audit::bounds::witness::{self, Held, Query, Witness};
use radgrad_audit::cases::family::Family;
use radgrad_audit::checks::bite::{Made, Setting, bite};
use radgrad_audit::checks::record::{self, Record, RecordedSubject};
use radgrad_audit::gates::Gates;
use rayon::prelude::*;

type Ended = Result<ExitCode, Box<dyn Error>>;

fn main() -> Ended {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let words: Vec<&str> = arguments.iter().map(String::as_str).collect();
    let witnesses = || witness::read_all(&data("worst"));
    match words[..] {
        ["search", rounds] => climb(&witnesses()?, rounds.parse()?),
        ["worst", rounds] => worst(&witnesses()?, rounds.parse()?),
        ["ordinary", cases] => ordinary(cases.parse()?),
        ["record", file] => again(Path::new(file)),
        _ => judge(&words),
    }
}

fn data(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../data").join(name)
}

fn judge(words: &[&str]) -> Ended {
    let gates = Gates::from_toml(&std::fs::read_to_string(data("gates.toml"))?)?;
    let (witnesses, records) = (witness::read_all(&data("worst"))?, record::read_all(&data("record"))?);
    let first = words.iter().position(|word| *word == "--check").and_then(|place| words.get(place + 1)).copied();
    let made = if words.contains(&"--alone") {
        Made::First
    } else if words.contains(&"--until-wrong") {
        Made::UntilWrong
    } else {
        Made::All
    };
    let found = bite(&Setting { gates: &gates, witnesses: &witnesses, records: &records, first, made });
    for wrong in &found {
        println!("{}", serde_json::json!({ "check": wrong.check, "by_record": wrong.by_record, "what": wrong.what }));
    }
    Ok(ExitCode::from(u8::from(!found.is_empty())))
}

/// Whether nothing was broken in so many rounds.
fn climb(witnesses: &[Witness], rounds: u64) -> Ended {
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

fn worst(witnesses: &[Witness], rounds: u64) -> Ended {
    let mut search = Search::from_witnesses(witnesses);
    for round in 0..rounds {
        search.climb(1, round);
    }
    for witness in search.places.values().flat_map(|worst| worst.worst.iter().take(2)) {
        println!("{}", serde_json::to_string(witness)?);
    }
    Ok(ExitCode::SUCCESS)
}

fn ordinary(cases: u64) -> Ended {
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
        for ask in [Query::Answer(1.0), Query::Lanes(1.0)] {
            for Held { place, bound, ratio } in ask.check(&case).held {
                println!("{}", serde_json::to_string(&Witness { place, ask, ratio, bound, case: case.clone() })?);
            }
        }
    }
    Ok(ExitCode::SUCCESS)
}

/// The records of a file, made anew; or of what its lines name: `tree 3`, `factors facing:1:0`, `oracle limbs 20 @ generic:1:0`.
fn again(file: &Path) -> Ended {
    let text = std::fs::read_to_string(file)?;
    let read = |line: &str| -> Result<(RecordedSubject, Option<radgrad_scene::case::Case>), String> {
        if let Ok(record) = serde_json::from_str::<Record>(line) {
            return Ok((record.of, record.case));
        }
        let (of, name) = line.split_once(" @ ").map_or((line, None), |(of, name)| (of, Some(name)));
        let name = name.map(str::parse::<radgrad_audit::cases::family::Name>).transpose().map_err(|error| error.to_string())?;
        Ok((of.parse().map_err(|error| format!("{line}: {error}"))?, name.map(|name| name.case())))
    };
    let asked = text.lines().filter(|line| !line.is_empty()).map(read).collect::<Result<Vec<_>, _>>()?;
    let made: Vec<_> = asked.par_iter().map(|(of, case)| (of, Record::new(*of, case.clone()))).collect();
    let mut ended = ExitCode::SUCCESS;
    for (of, record) in made {
        match record {
            Ok(record) => println!("{}", serde_json::to_string(&record)?),
            Err(why) => {
                eprintln!("{of}: {why}");
                ended = ExitCode::FAILURE;
            }
        }
    }
    Ok(ended)
}
