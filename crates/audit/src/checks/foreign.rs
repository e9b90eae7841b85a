//! Answers of any program, held to the same truth as core's.
//!
//! A program reads cases as JSON Lines and writes a line for each, in their order, in the format of `radgrad eval`: `radiosity`,
//! and where it has them `gradient`, `radiosity_error` and `gradient_error`; or `error`. A field that it leaves out is not
//! measured.
//!
//! Gates for it, in TOML: the largest figure allowed by quantity, for all families or for one.
//!
//! ```toml
//! [all]
//! value = 1e-6
//!
//! [far]
//! value = 1e-2
//! ```

use std::collections::BTreeMap;

use glam::DVec3;
use radgrad_core::{Answer, Method};
use radgrad_scene::case::{Case, Id, Problem};
use serde::Deserialize;

use crate::cases::family::{Family, Name};
use crate::cases::name::UnknownFamily;
use crate::measures::condition::Condition;
use crate::measures::measure::{Kind, Outcome, Quantity, measure_answer, ratio};
use crate::measures::table::Table;
use crate::measures::truth::Truth;

/// A line that a program wrote.
#[derive(Debug, Clone, PartialEq, Default, Deserialize)]
pub struct Given {
    /// The case it is for, if it says so.
    #[serde(default)]
    pub id: Option<Id>,
    /// The radiosity.
    #[serde(default)]
    pub radiosity: Option<f64>,
    /// The gradient.
    #[serde(default)]
    pub gradient: Option<[f64; 3]>,
    /// A bound on the error of the radiosity.
    #[serde(default)]
    pub radiosity_error: Option<f64>,
    /// A bound on the norm of the error of the gradient.
    #[serde(default)]
    pub gradient_error: Option<f64>,
    /// Why there is no answer.
    #[serde(default)]
    pub error: Option<String>,
}

/// The outcome of a case.
#[derive(Debug, Clone, PartialEq)]
pub struct Held {
    /// How it ended.
    pub kind: Kind,
    /// The figures that can be had.
    pub figures: Vec<(Quantity, f64)>,
    /// Remarks for people.
    pub remark: String,
}

impl Held {
    fn ended(kind: Kind, remark: impl Into<String>) -> Self {
        Self { kind, figures: Vec::new(), remark: remark.into() }
    }

    /// Adds it to a table.
    pub fn record(&self, case: Name, table: &mut Table) {
        table.count(case, self.kind);
        for &(quantity, figure) in &self.figures {
            table.add(case, quantity, figure);
        }
    }
}

/// Holds the line that a program wrote for a case to truth.
#[must_use]
pub fn hold(case: &Case, line: &str) -> Held {
    let given = match serde_json::from_str::<Given>(line) {
        Ok(given) => given,
        // JSON has no such numbers, and programs write them.
        Err(_) if ["nan", "inf"].iter().any(|word| line.to_lowercase().contains(word)) => {
            return Held::ended(Kind::NonFinite, line);
        }
        Err(error) => return Held::ended(Kind::Unanswered, format!("{error}: {line}")),
    };
    if let Some(other) = given.id.as_ref().filter(|id| **id != case.id) {
        return Held::ended(
            Kind::Unanswered,
            format!("this is the answer to {other}: lines must come in the order of the cases"),
        );
    }
    let problem = match (case.problem(), &given.error) {
        (Err(_), Some(why)) => return Held::ended(Kind::Refused, why),
        (Err(_), None) => return Held::ended(Kind::Measured, "an answer to what is no case"),
        (Ok(_), Some(why)) => return Held::ended(Kind::Unanswered, why),
        (Ok(problem), None) => problem,
    };
    let Some(radiosity) = given.radiosity else { return Held::ended(Kind::Unanswered, format!("no radiosity in {line}")) };
    if let (Some(gradient), Some(radiosity_error), Some(gradient_error)) =
        (given.gradient, given.radiosity_error, given.gradient_error)
    {
        let gradient = DVec3::from_array(gradient);
        let answer = Answer { radiosity, gradient, radiosity_error, gradient_error, method: Method::ClosedForm };
        return match measure_answer(&problem, &answer) {
            Outcome::Measured(figures) => {
                Held { kind: Kind::Measured, figures: Quantity::ALL.into_iter().zip(figures).collect(), remark: String::new() }
            }
            other => Held::ended(other.kind(), format!("{other:?}")),
        };
    }
    hold_to_truth(&problem, radiosity, &given)
}

/// Holds a radiosity, and the gradient and bounds where they are given, to truth.
fn hold_to_truth(problem: &Problem, radiosity: f64, given: &Given) -> Held {
    let truth = match Truth::of_problem(problem) {
        Ok(truth) => truth,
        Err(error) => return Held::ended(Kind::Undetermined, error.to_string()),
    };
    let mut figures = Vec::new();
    let mut push_figures = |quantity, over_condition, error: f64, size: f64, condition: fn(&Condition) -> f64| {
        figures.push((quantity, ratio(error, size)));
        let conditioned =
            if error == 0.0 { Ok(0.0) } else { Condition::of_problem(problem).map(|c| ratio(error, condition(&c))) };
        conditioned.map(|figure| figures.push((over_condition, figure)))
    };
    let value = push_figures(
        Quantity::Value,
        Quantity::ValueOverCondition,
        truth.radiosity_error(radiosity),
        truth.radiosity_magnitude(),
        |condition| condition.radiosity,
    );
    let gradient = given.gradient.map_or(Ok(()), |gradient| {
        push_figures(
            Quantity::Gradient,
            Quantity::GradientOverCondition,
            truth.gradient_error(DVec3::from_array(gradient)),
            truth.gradient_magnitude(),
            |condition| condition.gradient,
        )
    });
    if let Err(error) = value.and(gradient) {
        return Held::ended(Kind::Undetermined, format!("condition: {error}"));
    }
    let least = truth.errors_at_least(radiosity, given.gradient.map_or(DVec3::ZERO, DVec3::from_array));
    if let Some(bound) = given.radiosity_error {
        figures.push((Quantity::ValueOverBound, ratio(least.0, bound)));
    }
    if let (Some(_), Some(bound)) = (given.gradient, given.gradient_error) {
        figures.push((Quantity::GradientOverBound, ratio(least.1, bound)));
    }
    Held { kind: Kind::Measured, figures, remark: String::new() }
}

/// The largest figures allowed.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Gates {
    all: BTreeMap<Quantity, f64>,
    families: BTreeMap<Family, BTreeMap<Quantity, f64>>,
}

/// Why gates cannot be read.
#[derive(Debug, thiserror::Error)]
pub enum GateError {
    /// Not TOML, or a quantity that does not exist. The line is not quoted: the file may be another one than was meant.
    #[error("line {line}: expected `[all]` or `[FAMILY]`, then lines such as `value = 1e-6`")]
    Toml {
        /// From 1.
        line: usize,
    },
    /// A family that does not exist.
    #[error(transparent)]
    Family(#[from] UnknownFamily<Family>),
    /// A gate that nothing passes, or everything.
    #[error("{family}.{quantity} = {value}: a gate is a finite number and not negative")]
    Value {
        /// Of which family, or `all`.
        family: String,
        /// Of which quantity.
        quantity: &'static str,
        /// The value given.
        value: f64,
    },
}

/// A figure beyond its gate, or a fault that needs no gate.
#[derive(Debug, Clone, PartialEq)]
pub struct Violation {
    /// The family.
    pub family: Family,
    /// The case that does it, if it is one.
    pub case: Option<Name>,
    /// The fault, for people.
    pub what: String,
}

impl Gates {
    /// Reads gates.
    ///
    /// # Errors
    /// If it is not TOML, names an unknown family or quantity, or a gate is negative or not finite.
    pub fn from_toml(text: &str) -> Result<Self, GateError> {
        let mut gates = Self::default();
        let line = |error: &toml::de::Error| {
            1 + text.bytes().take(error.span().map_or(0, |span| span.start)).filter(|b| *b == b'\n').count()
        };
        let read = toml::from_str::<BTreeMap<String, BTreeMap<Quantity, f64>>>(text);
        for (family, of) in read.map_err(|error| GateError::Toml { line: line(&error) })? {
            if let Some((quantity, value)) = of.iter().find(|(_, value)| !(0.0..f64::INFINITY).contains(*value)) {
                return Err(GateError::Value { family, quantity: quantity.name(), value: *value });
            }
            if family == "all" {
                gates.all = of;
            } else {
                gates.families.insert(family.parse()?, of);
            }
        }
        Ok(gates)
    }

    /// The gate of a family and a quantity, if there is one.
    #[must_use]
    pub fn gate(&self, family: Family, quantity: Quantity) -> Option<f64> {
        let own = self.families.get(&family).and_then(|of| of.get(&quantity));
        own.or_else(|| self.all.get(&quantity)).copied()
    }

    /// Everything in a table of these families that must not be: beyond a gate, or without a figure to hold against one; a stated
    /// bound below the error; an answer that is no number; a case without truth.
    #[must_use]
    pub fn violations(&self, families: &[Family], table: &Table) -> Vec<Violation> {
        let mut violations = Vec::new();
        for &family in families {
            let Some(of) = table.families().get(&family) else {
                violations.push(Violation { family, case: None, what: "no case was asked".to_owned() });
                continue;
            };
            for (kind, what) in [(Kind::NonFinite, "not a number"), (Kind::Undetermined, "without truth")] {
                if let Some(bin) = of.counts().get(&kind) {
                    violations.push(Violation { family, case: Some(bin.first), what: format!("{} {what}", bin.count) });
                }
            }
            for quantity in Quantity::ALL {
                let is_bound = matches!(quantity, Quantity::ValueOverBound | Quantity::GradientOverBound);
                let gate = self.gate(family, quantity).or(is_bound.then_some(1.0));
                match (gate, of.figures().get(&quantity).and_then(|figures| figures.worst())) {
                    (Some(gate), Some(worst)) if worst.value > gate => {
                        let what = format!("{} is {:.2e}, the gate is {gate:.0e}", quantity.name(), worst.value);
                        violations.push(Violation { family, case: Some(worst.case), what });
                    }
                    (Some(_), None) if !is_bound && !family.is_refused() => {
                        let what = format!("{} has a gate, and no answer to be held against it", quantity.name());
                        violations.push(Violation { family, case: None, what });
                    }
                    _ => {}
                }
            }
        }
        violations
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::measures::measure::measure;

    fn line(case: &Case, factor: f64, fields: &str) -> String {
        let problem = case.problem().unwrap();
        let answer = radgrad_core::evaluate(&problem.receiver, &problem.emitter, &problem.occluders).unwrap();
        let [x, y, z] = answer.gradient.to_array();
        let radiosity = answer.radiosity * factor;
        let every_field = format!(
            "\"radiosity\":{radiosity:e},\"gradient\":[{x:e},{y:e},{z:e}],\"radiosity_error\":{:e},\"gradient_error\":{:e}",
            answer.radiosity_error, answer.gradient_error
        );
        let fields_kept: Vec<&str> =
            if fields == "value" { vec![every_field.split(",\"gradient\"").next().unwrap()] } else { vec![&every_field] };
        format!("{{\"id\":\"{}\",{}}}", case.id, fields_kept.join(","))
    }

    #[test]
    fn our_own_answers_have_the_figures_of_the_audit() {
        for family in [Family::Generic, Family::Clipped, Family::BackFacing] {
            let case = family.case(1, 2);
            let held = hold(&case, &line(&case, 1.0, "all"));
            let figures = Quantity::ALL.map(|quantity| (quantity, measure(&case).figure(quantity).unwrap()));
            assert_eq!((held.kind, &held.figures[..]), (Kind::Measured, &figures[..]), "{family}");
        }
    }

    #[test]
    fn a_value_alone_is_measured_alone() {
        let case = Family::Generic.case(1, 2);
        let held = hold(&case, &line(&case, 1.0 + 1e-6, "value"));
        assert_eq!(held.figures.len(), 2, "{held:?}");
        assert!((held.figures[0].1 / 1e-6 - 1.0).abs() < 1e-6);
    }

    #[test]
    fn what_is_no_answer_has_a_name() {
        let case = Family::Generic.case(1, 2);
        let kind = |line: &str| hold(&case, line).kind;
        assert_eq!(kind("{\"radiosity\":nan}"), Kind::NonFinite);
        assert_eq!(kind("{\"error\":\"no\"}"), Kind::Unanswered);
        assert_eq!(kind("{\"id\":\"another\",\"radiosity\":1}"), Kind::Unanswered);
        assert_eq!(kind("segmentation fault"), Kind::Unanswered);
        let none = Family::EqualVertices.case(1, 0);
        assert_eq!(hold(&none, "{\"error\":\"no\"}").kind, Kind::Refused);
        assert_eq!(hold(&none, "{\"radiosity\":1}").kind, Kind::Measured);
    }

    #[test]
    fn gates_hold_for_all_families_or_for_one_and_need_something_to_hold() {
        let gates = Gates::from_toml("[all]\nvalue = 1e-9\n[far]\nvalue = 1e-3\n").unwrap();
        let table = |family: Family, figures: &[(Quantity, f64)]| {
            let mut table = Table::default();
            let held = Held { kind: Kind::Measured, figures: figures.to_vec(), remark: String::new() };
            held.record(Name { family, seed: 1, index: 4 }, &mut table);
            table
        };
        let count = |family: Family, figures: &[(Quantity, f64)]| gates.violations(&[family], &table(family, figures)).len();
        assert_eq!(count(Family::Far, &[(Quantity::Value, 1e-4)]), 0);
        assert_eq!(count(Family::Generic, &[(Quantity::Value, 1e-4)]), 1);
        assert_eq!(count(Family::Generic, &[]), 1);
        assert_eq!(count(Family::Generic, &[(Quantity::Value, 0.0), (Quantity::ValueOverBound, 1.5)]), 1);
        assert_eq!(gates.violations(&[Family::Generic], &Table::default()).len(), 1);
        assert!(Gates::from_toml("[all]\nvalue = -1.0\n").unwrap_err().to_string().contains("all.value = -1"));
        assert!(Gates::from_toml("[fat]\nvalue = 1.0\n").is_err());
        let foreign = Gates::from_toml("[all]\nroot:x:0:0:secret\n").unwrap_err().to_string();
        assert!(foreign.contains("line 2") && !foreign.contains("secret"), "{foreign}");
    }
}
