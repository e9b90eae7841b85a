//! The gates on each ratio: `data/speed.toml`.
//!
//! ```toml
//! [value_over_lambert]
//! at-most = 2.6 # the gate; or `at-least`
//! found = 2.1
//! aim = 1.1
//! ```

use std::collections::BTreeMap;
use std::fmt;

use comfy_table::Table;
use serde::Deserialize;

use super::pair::Ratio;
use crate::summary;

/// The gates by ratio.
#[derive(Debug, Clone, Deserialize)]
pub(crate) struct Gates(BTreeMap<String, Gate>);

/// The limit of a ratio, its value when that was written, and the value aimed at.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
struct Gate {
    at_most: Option<f64>,
    at_least: Option<f64>,
    found: f64,
    aim: f64,
}

/// Why there are no gates.
#[derive(Debug, thiserror::Error)]
pub(crate) enum Error {
    /// Not the format.
    #[error("data/speed.toml: {0}")]
    Toml(#[from] toml::de::Error),
    /// None or two limits, or one that its own figure is beyond.
    #[error("data/speed.toml: {name}: one of `at-most` and `at-least`, and `found` within it")]
    Limit {
        /// The ratio.
        name: String,
    },
}

/// A ratio beyond its gate, or without one.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Violation {
    name: &'static str,
    found: f64,
    gate: Option<Gate>,
}

impl fmt::Display for Violation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { name, found, gate } = self;
        match gate {
            Some(gate) => write!(f, "{name} is {found:.3}, the gate is {gate}"),
            None => write!(f, "{name} has no gate in data/speed.toml"),
        }
    }
}

impl fmt::Display for Gate {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match (self.at_most, self.at_least) {
            (Some(most), _) => write!(f, "<= {most}"),
            (_, Some(least)) => write!(f, ">= {least}"),
            _ => Ok(()),
        }
    }
}

impl Gate {
    fn holds(&self, ratio: f64) -> bool {
        ratio.is_finite() && self.at_most.is_none_or(|most| ratio <= most) && self.at_least.is_none_or(|least| ratio >= least)
    }
}

impl Gates {
    /// Reads the gates.
    ///
    /// # Errors
    /// If a ratio has not exactly one limit, or its figure is beyond it.
    pub(crate) fn from_toml(text: &str) -> Result<Self, Error> {
        let gates: Self = toml::from_str(text)?;
        match gates.0.iter().find(|(_, gate)| gate.at_most.is_some() == gate.at_least.is_some() || !gate.holds(gate.found)) {
            Some((name, _)) => Err(Error::Limit { name: name.clone() }),
            None => Ok(gates),
        }
    }

    /// Ratios beyond their gates.
    pub(crate) fn violations(&self, ratios: &[Ratio]) -> Vec<Violation> {
        let judged = |ratio: &Ratio| {
            let (found, gate) = (ratio.spread.median, self.0.get(ratio.name).copied());
            let holds = gate.is_some_and(|gate| gate.holds(found));
            (!holds).then_some(Violation { name: ratio.name, found, gate })
        };
        ratios.iter().filter_map(judged).collect()
    }

    /// A row a ratio.
    pub(crate) fn table(&self, ratios: &[Ratio]) -> Table {
        let mut table = summary::with_header(&["ratio", "median", "quartiles", "gate", "aim"]);
        for ratio in ratios {
            let Ratio { name, spread } = ratio;
            let [first, third] = spread.quartiles;
            let gate = self.0.get(*name);
            let (limit, aim) = (gate.map_or_else(String::new, Gate::to_string), gate.map_or(f64::NAN, |gate| gate.aim));
            let figures = [format!("{:.3}", spread.median), format!("{first:.3} .. {third:.3}"), limit, aim.to_string()];
            table.add_row(std::iter::once((*name).to_owned()).chain(figures));
        }
        summary::right_aligned(table)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bench::clock::Spread;

    const TEXT: &str = "[a]\nat-most = 2.0\nfound = 1.5\naim = 1.0\n[b]\nat-least = 10.0\nfound = 12.0\naim = 20.0\n";

    fn ratio(name: &'static str, median: f64) -> Ratio {
        Ratio { name, spread: Spread::quartiles(vec![median]) }
    }

    #[test]
    fn a_ratio_is_held_against_its_side() {
        let gates = Gates::from_toml(TEXT).unwrap();
        assert_eq!(gates.violations(&[ratio("a", 2.0), ratio("b", 10.0)]), []);
        let beyond = gates.violations(&[ratio("a", 2.1), ratio("b", 9.9), ratio("a", f64::NAN), ratio("c", 1.0)]);
        let texts: Vec<String> = beyond.iter().map(Violation::to_string).collect();
        assert_eq!(texts[..2], ["a is 2.100, the gate is <= 2", "b is 9.900, the gate is >= 10"]);
        assert!(texts.len() == 4 && texts[3].contains("no gate"), "{texts:?}");
    }

    #[test]
    fn a_gate_has_one_limit_and_holds_for_its_own_figure() {
        for wrong in ["[a]\nfound = 1.0\naim = 1.0\n", "[a]\nat-most = 1.0\nat-least = 1.0\nfound = 1.0\naim = 1.0\n"] {
            assert!(matches!(Gates::from_toml(wrong), Err(Error::Limit { .. })), "{wrong}");
        }
        assert!(Gates::from_toml(&TEXT.replace("found = 1.5", "found = 2.5")).is_err());
        assert!(matches!(Gates::from_toml("[a]\nat_most = 1.0\n"), Err(Error::Toml(_))));
    }

    #[test]
    fn the_committed_gates_are_read() {
        Gates::from_toml(include_str!("../../../../data/speed.toml")).unwrap();
    }
}
