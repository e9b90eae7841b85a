//! Many digits: core's `evaluate_digits` against the oracle's enclosure to as many and more, in arithmetic of 192 bits and above.
//!
//! Neither uses doubles, double-doubles or the bounds proven for them, and the two share no formula. Each comes with a proven
//! radius, and the two intervals must have a point in common.

use std::collections::BTreeMap;

use radgrad_oracle::{Request, Source, enclose_source_occluded};
use rayon::prelude::*;

use crate::bounds::digits;
use crate::cases::family::{Family, Name};
use crate::measures::seen::reduced;
use crate::measures::truth::Truth;

/// Digits that are asked for, and the cases of each, in the whole run and in the quick one.
pub const LEVELS: [(u32, [u64; 2]); 3] = [(34, [1000, 60]), (50, [700, 40]), (100, [300, 20])];

/// Digits that the oracle is asked for beyond those of core.
const MORE: u32 = 3;

/// Evaluations that the oracle may spend on a case.
const BUDGET: u64 = 400_000;

/// The outcome of the cases with so many digits.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Level {
    /// Held against the oracle, by family.
    pub held: BTreeMap<Family, u64>,
    /// Cases that take the oracle more than it may spend.
    pub dear: u64,
    /// Not of one mind, or without an answer: which case, and why.
    pub wrong: Vec<(Name, String)>,
}

impl Level {
    /// Cases held against the oracle.
    #[must_use]
    pub fn count(&self) -> u64 {
        self.held.values().sum()
    }
}

enum Ended {
    Held,
    Dear,
    Wrong(String),
}

/// About so many cases, shared among the families that have an answer and none that takes a second.
#[must_use]
pub fn level(digits: u32, cases: u64, seed: u64) -> Level {
    let families: Vec<Family> =
        Family::ALL.into_iter().filter(|family| !family.is_refused() && !family.is_rounded() && family.dearness() == 1).collect();
    let each = cases.div_ceil(families.len() as u64);
    let names: Vec<Name> = (0..each).flat_map(|index| families.iter().map(move |&family| Name { family, seed, index })).collect();
    let ended: Vec<Ended> = names.par_iter().map(|name| compare(*name, digits)).collect();
    let mut level = Level::default();
    for (name, ended) in names.into_iter().zip(ended) {
        match ended {
            Ended::Held => *level.held.entry(name.family).or_default() += 1,
            Ended::Dear => level.dear += 1,
            Ended::Wrong(why) => level.wrong.push((name, why)),
        }
    }
    level
}

fn compare(name: Name, count: u32) -> Ended {
    let problem = match name.case().problem() {
        Ok(problem) => problem,
        Err(error) => return Ended::Wrong(error.to_string()),
    };
    let few = match digits::enclosure(&problem, count) {
        Ok(few) => few,
        Err(why) => return Ended::Wrong(why),
    };
    let (emitter, occluders) = reduced(&problem);
    let request = Request { digits: count + MORE, arithmetic: None, budget: BUDGET };
    match enclose_source_occluded(&problem.receiver, &Source::Emitter(&emitter), occluders, &request) {
        Ok(enclosure) => {
            let truth = Truth { radiosity: enclosure.radiosity, gradient: enclosure.gradient };
            if few.overlaps(&truth) {
                Ended::Held
            } else {
                Ended::Wrong(format!("{count} digits and the oracle's have nothing in common"))
            }
        }
        Err(radgrad_oracle::Error::Budget { .. } | radgrad_oracle::Error::Cell { .. }) => Ended::Dear,
        Err(error) => Ended::Wrong(error.to_string()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn thirty_four_digits_are_those_of_the_oracle() {
        let level = level(34, 30, 5);
        assert_eq!(level.wrong, []);
        assert!(level.count() > 10, "{level:?}");
    }
}
