//! The gates: the largest figure allowed per family and quantity, in `data/gates.toml`.
//!
//! ```toml
//! appendix-a = 1e-10
//!
//! [generic]
//! value = 1e-14
//! gradient = 1e-14
//! ```
//!
//! The table `scenes` is for [`crate::scenes`]. Tables under `bounds` are for [`crate::bounds::requirements`]. `appendix-a` is for the second implementation, value and
//! gradient, on the cases it is meant for; `derivatives` is the least share of cases whose derivatives are held against the oracle's slopes.
//!
//! Beside them stand rules that need no number: each input that must be refused is refused and no other, every valid case has an
//! answer, no answer is NaN or infinite, every case has a truth to be measured by. A gate may only be tightened.

use std::collections::BTreeMap;
use std::fmt;

use serde::Deserialize;

use crate::bounds;
use crate::bounds::requirements::{Breach, Requirement, breaches};
use crate::cases::family::{Family, Name};
use crate::cases::name::UnknownFamily;
use crate::measures::measure::{Kind, Quantity};
use crate::measures::table::{FamilyTable, Table};
use crate::scenes;

/// The largest figure allowed per family and quantity.
#[derive(Debug, Clone, PartialEq)]
pub struct Gates {
    families: BTreeMap<Family, BTreeMap<Quantity, f64>>,
    bounds: BTreeMap<Family, Requirement>,
    scenes: scenes::table::Requirement,
    appendix_a: f64,
    derivatives: f64,
}

/// The file as it is written.
#[derive(Deserialize)]
#[serde(rename_all = "kebab-case")]
struct File {
    appendix_a: f64,
    #[serde(default)]
    derivatives: f64,
    #[serde(default)]
    bounds: BTreeMap<String, Requirement>,
    #[serde(default)]
    scenes: scenes::table::Requirement,
    #[serde(flatten)]
    families: BTreeMap<String, BTreeMap<Quantity, f64>>,
}

/// Why gates cannot be read.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// Not TOML, or a quantity that does not exist.
    #[error("gates: {0}")]
    Toml(#[from] toml::de::Error),
    /// A family that does not exist.
    #[error("gates: {0}")]
    Family(#[from] UnknownFamily<Family>),
    /// A gate that nothing passes, or everything.
    #[error("gates: {family}.{quantity} = {value}: a gate is a finite number and not negative", quantity = quantity.name())]
    Value {
        /// Of which family.
        family: Family,
        /// Of which quantity.
        quantity: Quantity,
        /// The value given.
        value: f64,
    },
    /// A family with figures lacks a gate.
    #[error("gates: {family}.{quantity} is missing", quantity = quantity.name())]
    Missing {
        /// Of which family.
        family: Family,
        /// Of which quantity.
        quantity: Quantity,
    },
}

/// A figure beyond its gate, or an outcome that must not be.
#[derive(Debug, Clone, PartialEq)]
pub struct Violation {
    /// The first or worst case that does it.
    pub case: Name,
    /// How the case fails.
    pub fault: Fault,
}

/// A figure or an outcome that the gates refuse.
#[derive(Debug, Clone, PartialEq)]
pub enum Fault {
    /// A figure beyond its gate.
    Beyond {
        /// The quantity.
        quantity: Quantity,
        /// The worst figure.
        figure: f64,
        /// The gate.
        gate: f64,
    },
    /// Cases that ended in a way they must not.
    Ended {
        /// How they ended.
        kind: Kind,
        /// How many of them.
        count: u64,
    },
}

impl fmt::Display for Violation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { case, fault } = self;
        match fault {
            Fault::Beyond { quantity, figure, gate } => {
                write!(f, "{}: {} is {figure:.2e}, the gate is {gate:.0e}, at {case}", case.family, quantity.name())
            }
            Fault::Ended { kind, count } => write!(f, "{}: {count} {}, the first is {case}", case.family, kind.name()),
        }
    }
}

impl Gates {
    /// Reads gates; every family that is answered must have one for every quantity.
    ///
    /// # Errors
    /// If it is not TOML, names an unknown family or quantity, or a gate is missing, negative or infinite.
    pub fn from_toml(text: &str) -> Result<Self, Error> {
        let file: File = toml::from_str(text)?;
        let families: BTreeMap<Family, BTreeMap<Quantity, f64>> = by_family(file.families)?;
        for family in Family::ALL.into_iter().filter(|f| !f.is_refused()) {
            for quantity in Quantity::ALL {
                let gate = families.get(&family).and_then(|gates| gates.get(&quantity));
                let value = *gate.ok_or(Error::Missing { family, quantity })?;
                if !(0.0..f64::INFINITY).contains(&value) {
                    return Err(Error::Value { family, quantity, value });
                }
            }
        }
        let (bounds, derivatives) = (by_family(file.bounds)?, file.derivatives);
        Ok(Self { families, bounds, scenes: file.scenes, appendix_a: file.appendix_a, derivatives })
    }

    /// The least share of cases whose derivatives are held against slopes.
    #[must_use]
    pub const fn derivatives(&self) -> f64 {
        self.derivatives
    }

    /// The gate of the second implementation.
    #[must_use]
    pub const fn appendix_a(&self) -> f64 {
        self.appendix_a
    }

    /// The gate of a family and a quantity, if figures of it are gated.
    #[must_use]
    pub fn gate(&self, family: Family, quantity: Quantity) -> Option<f64> {
        self.families.get(&family)?.get(&quantity).copied()
    }

    /// Requirements on the bounds table of a family.
    #[must_use]
    pub fn bounds(&self, family: Family) -> Requirement {
        self.bounds.get(&family).copied().unwrap_or_default()
    }

    /// Requirements on whole scenes.
    #[must_use]
    pub const fn scenes(&self) -> scenes::table::Requirement {
        self.scenes
    }

    /// Everything in the bounds table that must not be.
    #[must_use]
    pub fn breaches(&self, table: &bounds::table::Table) -> Vec<Breach> {
        table.families().iter().flat_map(|(family, table)| breaches(*family, table, &self.bounds(*family))).collect()
    }

    /// Everything in the table that must not be.
    #[must_use]
    pub fn violations(&self, table: &Table) -> Vec<Violation> {
        table.families().iter().flat_map(|(family, table)| self.violations_of(*family, table)).collect()
    }

    fn violations_of(&self, family: Family, table: &FamilyTable) -> Vec<Violation> {
        let wanted = if family.is_refused() { Kind::Refused } else { Kind::Measured };
        let ended = table.counts().iter().filter(|(kind, _)| **kind != wanted);
        let ended = ended.map(|(kind, bin)| Violation { case: bin.first, fault: Fault::Ended { kind: *kind, count: bin.count } });
        let beyond = table.figures().iter().filter_map(|(&quantity, distribution)| {
            let worst = distribution.worst()?;
            let gate = self.gate(family, quantity)?;
            let fault = Fault::Beyond { quantity, figure: worst.value, gate };
            (worst.value > gate).then_some(Violation { case: worst.case, fault })
        });
        ended.chain(beyond).collect()
    }
}

fn by_family<T>(named: BTreeMap<String, T>) -> Result<BTreeMap<Family, T>, Error> {
    named.into_iter().map(|(name, value)| Ok((name.parse()?, value))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::measures::measure::Outcome;

    fn gates_of(value: &str) -> String {
        let family = |f: Family| {
            let gates: String = Quantity::ALL.iter().map(|q| format!("{} = {value}\n", q.name())).collect();
            format!("[{f}]\n{gates}")
        };
        let families: String = Family::ALL.into_iter().filter(|f| !f.is_refused()).map(family).collect();
        format!("appendix-a = 1e-10\n{families}")
    }

    fn violations(family: Family, outcome: &Outcome) -> Vec<String> {
        let table = Table::single(Name { family, seed: 1, index: 5 }, outcome);
        let gates = Gates::from_toml(&gates_of("1e-12")).unwrap();
        gates.violations(&table).iter().map(Violation::to_string).collect()
    }

    #[test]
    fn a_figure_at_its_gate_passes_and_one_above_does_not() {
        assert_eq!(violations(Family::Far, &Outcome::Measured([1e-12; 6])), Vec::<String>::new());
        let mut figures = [0.0; 6];
        figures[1] = 2e-12;
        let expected = "far: gradient is 2.00e-12, the gate is 1e-12, at far:1:5";
        assert_eq!(violations(Family::Far, &Outcome::Measured(figures)), [expected]);
        figures[1] = f64::INFINITY;
        assert_eq!(violations(Family::Far, &Outcome::Measured(figures)).len(), 1);
    }

    #[test]
    fn every_other_outcome_is_a_violation_where_it_must_not_be() {
        let why = || "why".to_owned();
        for outcome in
            [Outcome::Refused(why()), Outcome::Unanswered(why()), Outcome::NonFinite(why()), Outcome::Undetermined(why())]
        {
            assert_eq!(violations(Family::Far, &outcome).len(), 1, "{outcome:?}");
        }
        assert!(violations(Family::EqualVertices, &Outcome::Refused(why())).is_empty());
        let answered = violations(Family::EqualVertices, &Outcome::Measured([0.0; 6]));
        assert_eq!(answered, ["equal-vertices: 1 measured, the first is equal-vertices:1:5"]);
    }

    #[test]
    fn bad_gates_are_refused() {
        let message = |text: &str| Gates::from_toml(text).unwrap_err().to_string();
        assert!(message(&gates_of("inf")).contains("generic.value = inf"));
        assert!(message(&gates_of("-1e-3")).contains("generic.value"));
        assert!(message(&gates_of("1").replace("[far]", "[fat]")).contains("\"fat\""));
        assert!(message(&gates_of("1").replacen("value = 1\n", "", 1)).contains("generic.value is missing"));
        assert!(message(&gates_of("1").replacen("value = 1", "valve = 1", 1)).contains("valve"));
    }
}
