//! A recorded program as a script for gappa, read twice: `c7` is step 7 as computed, with roundings, `e7` the same without.
//!
//! Errors of inputs, or of steps whose error another lemma bounds, are hypotheses. Two readings need a line on paper each:
//!
//! - *Relative roundings*: each operation errs by at most u of its result, barring underflow, whatever that is. Relative errors do
//!   not change with the scale then, so a lemma may set a length to 1. The roundings of binary64 themselves are for programs that
//!   rest on exact steps.
//! - *Sizes*: of a program of sums, differences and products, each monomial of the result has a factor `(1 + d)` for each rounding
//!   on its way, |d| <= u. So the error is at most that of the program if all inputs were positive and all differences sums; and there a
//!   relative error is at most the largest of those of the terms, since shares of a sum of positive numbers are between 0 and 1.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write;

use crate::prove::tape::{Recorded, Step, Tape};

/// How operations round.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Rounding {
    Binary64,
    Relative,
}

/// The known error of a number instead of how it was computed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Known {
    /// It is a double, and exact.
    Exact,
    /// It is an integer, and exact.
    Integer,
    /// It is 0.
    Zero,
    /// It is off by at most this, relative.
    Relative(f64),
    /// It is off by at most this.
    Absolute(f64),
}

/// A script in the making.
#[derive(Debug)]
pub(crate) struct Script<'t> {
    tape: &'t Tape,
    rounding: Rounding,
    sizes: bool,
    known: BTreeMap<usize, Known>,
    altered: Option<(usize, f64)>,
    definitions: String,
    hypotheses: Vec<String>,
    goals: Vec<String>,
    hints: String,
    used: BTreeSet<usize>,
}

/// A double as gappa reads it exactly.
pub(crate) fn exactly(value: f64) -> String {
    assert!(value.is_finite(), "{value} in a script");
    let (mut mantissa, mut exponent) = (value, 0);
    while mantissa.fract() != 0.0 {
        (mantissa, exponent) = (mantissa * 2.0, exponent - 1);
    }
    format!("{mantissa:.0}b{exponent}")
}

/// A number as computed.
pub(crate) fn computed(number: Recorded<'_>) -> String {
    format!("c{}", number.place)
}

impl<'t> Script<'t> {
    pub(crate) fn new(tape: &'t Tape, rounding: Rounding) -> Self {
        Self {
            tape,
            rounding,
            sizes: false,
            known: BTreeMap::new(),
            altered: None,
            definitions: String::new(),
            hypotheses: Vec::new(),
            goals: Vec::new(),
            hints: String::new(),
            used: BTreeSet::new(),
        }
    }

    /// With relative roundings, all inputs positive and all differences sums.
    pub(crate) fn of_sizes(tape: &'t Tape) -> Self {
        Self { sizes: true, ..Self::new(tape, Rounding::Relative) }
    }

    pub(crate) fn know(&mut self, number: Recorded<'t>, known: Known) {
        self.known.insert(number.place, known);
    }

    pub(crate) fn know_all(&mut self, numbers: impl IntoIterator<Item = Recorded<'t>>, known: Known) {
        numbers.into_iter().for_each(|number| self.know(number, known));
    }

    /// The computed program has this constant times a factor: a fault.
    pub(crate) fn alter(&mut self, place: usize, factor: f64) {
        self.altered = Some((place, factor));
    }

    /// A number without roundings.
    pub(crate) fn exact(&self, number: Recorded<'t>) -> String {
        self.name(number.place, 'e')
    }

    /// A step's number as computed, `c`, or without roundings, `e`, which is the same number for some.
    fn name(&self, place: usize, kind: char) -> String {
        let exact = match self.known.get(&place) {
            Some(Known::Relative(_) | Known::Absolute(_)) => false,
            Some(Known::Exact | Known::Integer | Known::Zero) => true,
            None => match self.tape.step(place) {
                Step::Constant(_) => self.altered.is_none_or(|(altered, _)| altered != place),
                Step::Input | Step::Function(..) | Step::Angle(..) => true,
                _ => false,
            },
        };
        format!("{}{place}", if exact { 'c' } else { kind })
    }

    /// Where the exact number is.
    pub(crate) fn range(&mut self, number: Recorded<'t>, [from, to]: [f64; 2]) {
        self.use_all(number);
        self.assume(format!("{} in [{},{}]", self.exact(number), exactly(from), exactly(to)));
    }

    /// A name for an expression.
    pub(crate) fn define(&mut self, name: &str, expression: &str) {
        writeln!(self.definitions, "{name} = {expression};").expect("to a string");
    }

    pub(crate) fn assume(&mut self, what: String) {
        self.hypotheses.push(what);
    }

    pub(crate) fn hint(&mut self, hint: &str) {
        writeln!(self.hints, "{hint};").expect("to a string");
    }

    /// To be proved: the relative error of a number.
    pub(crate) fn relative_error(&mut self, number: Recorded<'t>, most: f64) {
        self.use_all(number);
        self.within(&format!("{} -/ {}", computed(number), self.exact(number)), most);
    }

    /// The truth differs from the program's result without roundings by `rest`: sizes times numbers of at most so much.
    pub(crate) fn known_to(&mut self, terms: &[(&str, f64)]) {
        let names = ["tau", "rho"];
        let sum: Vec<String> = terms.iter().zip(names).map(|((size, _), name)| format!("{name} * {size}")).collect();
        self.define("rest", &sum.join(" + "));
        for ((_, most), name) in terms.iter().zip(names) {
            self.assume(format!("{name} in [{},{}]", exactly(-most), exactly(*most)));
        }
    }

    /// To be proved: the relative error of a number whose truth has a rest.
    pub(crate) fn error_with_rest(&mut self, number: Recorded<'t>, most: f64) {
        let (c, e) = (computed(number), self.exact(number));
        self.define("error", &format!("(({c} - {e}) - rest) / ({e} + rest)"));
        self.hint(&format!("error -> (({c} - {e}) / {e} - rest / {e}) / (1 + rest / {e}) {{ {e} <> 0 }}"));
        self.within("error", most);
    }

    /// To be proved: an expression is at most so large, either way.
    pub(crate) fn within(&mut self, expression: &str, most: f64) {
        self.goals.push(format!("{expression} in [{},{}]", exactly(-most), exactly(most)));
    }

    /// The steps to a number enter the script, as far as they are not known otherwise; a step's own rounding with it.
    pub(crate) fn use_all(&mut self, number: Recorded<'t>) {
        let mut open = vec![number.place];
        while let Some(place) = open.pop() {
            if !self.used.insert(place) {
                continue;
            }
            if !self.is_free(place) {
                open.extend(operands(self.tape.step(place)));
            }
        }
    }

    /// Whether how a number was computed is left out.
    fn is_free(&self, place: usize) -> bool {
        match self.known.get(&place) {
            Some(_) => true,
            None => matches!(self.tape.step(place), Step::Input | Step::Function(..) | Step::Angle(..)),
        }
    }

    /// The whole script.
    pub(crate) fn write(&self) -> String {
        let (mut text, mut hints, mut hypotheses) = (String::new(), String::new(), Vec::new());
        for &place in &self.used {
            self.write_step(place, &mut text, &mut hints, &mut hypotheses);
        }
        hypotheses.extend(self.hypotheses.iter().cloned());
        let premise = if hypotheses.is_empty() { String::new() } else { format!("{}\n->\n  ", hypotheses.join("\n/\\ ")) };
        let decided = self.tape.decisions().into_iter().filter(|(a, b, _)| self.used.contains(a) || self.used.contains(b));
        let path: String = decided
            .map(|(a, b, exceeds)| {
                format!("# {} {} {}\n", self.name(a, 'c'), if exceeds { ">" } else { "<=" }, self.name(b, 'c'))
            })
            .collect();
        format!("{path}{text}{}\n{{ {premise}{} }}\n\n{hints}{}", self.definitions, self.goals.join("\n/\\ "), self.hints)
    }

    fn write_step(&self, place: usize, text: &mut String, hints: &mut String, hypotheses: &mut Vec<String>) {
        let step = self.tape.step(place);
        let (c, e) = (format!("c{place}"), self.name(place, 'e'));
        if self.is_free(place) {
            match self.known.get(&place).unwrap_or(&Known::Exact) {
                Known::Relative(error) => {
                    hypotheses.push(format!("{c} -/ {e} in [{},{}]", exactly(-error), exactly(*error)));
                    hypotheses.push(format!("{e} <> 0"));
                    *hints += &format!("{c} ~ {e};\n");
                }
                Known::Absolute(error) => {
                    hypotheses.push(format!("{c} - {e} in [{},{}]", exactly(-error), exactly(*error)));
                    *hints += &format!("{c} ~ {e};\n");
                }
                Known::Zero => *text += &format!("{c} = 0;\n"),
                Known::Integer => *text += &format!("{c} = int<ne>(i{place});\n"),
                _ => {
                    if self.rounding == Rounding::Binary64 {
                        *text += &format!("{c} = float<ieee_64,ne>(i{place});\n");
                    }
                    if self.sizes {
                        hypotheses.push(format!("{e} <> 0"));
                    }
                }
            }
            return;
        }
        let factor = self.altered.filter(|(altered, _)| *altered == place).map_or(1.0, |(_, factor)| factor);
        let computed = match step {
            Step::Constant(value) => exactly(self.sized(value * factor)),
            _ => self.rounded(step),
        };
        if self.rounding == Rounding::Relative && matches!(step, Step::Div(..) | Step::Sqrt(_)) {
            // Gappa has relative roundings of sums and products only.
            *text += &format!("q{place} = {computed};\n");
            hypotheses.push(format!("{c} -/ q{place} in [-1b-53,1b-53]"));
            *hints += &format!("{c} ~ q{place};\n");
        } else {
            *text += &format!("{c} = {computed};\n");
        }
        if e != c {
            *text += &format!("{e} = {};\n", self.plain(step, 'e'));
            *hints += &format!("{c} ~ {e};\n");
        }
        if self.sizes && e != c {
            if let Step::Add(a, b) | Step::Sub(a, b) = step {
                hypotheses.extend([a, b].map(|term| format!("{} / {e} in [0,1]", self.name(term, 'e'))));
            }
            hypotheses.push(format!("{e} <> 0"));
        }
    }

    /// Whether a step gives 0 whatever the inputs.
    fn is_zero(&self, place: usize) -> bool {
        match self.tape.step(place) {
            _ if self.known.get(&place) == Some(&Known::Zero) => true,
            Step::Constant(value) => value == 0.0,
            Step::Mul(a, b) => self.is_zero(a) || self.is_zero(b),
            _ => false,
        }
    }

    fn sized(&self, value: f64) -> f64 {
        if self.sizes { value.abs() } else { value }
    }

    /// A step on numbers of a kind, without its rounding.
    fn plain(&self, step: Step, kind: char) -> String {
        let name = |place| self.name(place, kind);
        match step {
            Step::Constant(value) => exactly(self.sized(value)),
            Step::Neg(a) if self.sizes => name(a),
            Step::Neg(a) => format!("-{}", name(a)),
            Step::Abs(a) if self.sizes => name(a),
            Step::Abs(a) => format!("|{}|", name(a)),
            Step::Sqrt(a) => format!("sqrt({})", name(a)),
            Step::Mul(a, b) if self.is_zero(a) || self.is_zero(b) => "0".to_owned(),
            Step::Add(a, b) | Step::Sub(a, b) if self.is_zero(b) => name(a),
            Step::Add(a, b) if self.is_zero(a) => name(b),
            Step::Add(a, b) => format!("{} + {}", name(a), name(b)),
            Step::Sub(a, b) => format!("{} {} {}", name(a), if self.sizes { '+' } else { '-' }, name(b)),
            Step::Mul(a, b) => format!("{} * {}", name(a), name(b)),
            Step::Div(a, b) => format!("{} / {}", name(a), name(b)),
            Step::Input | Step::Function(..) | Step::Angle(..) => unreachable!("known by its error alone"),
        }
    }

    /// A step on computed numbers, with its rounding.
    fn rounded(&self, step: Step) -> String {
        let plain = self.plain(step, 'c');
        let is_power = |place| matches!(self.tape.step(place), Step::Constant(c) if c.abs().log2().fract() == 0.0);
        let is_exact = match step {
            Step::Neg(_) | Step::Abs(_) | Step::Constant(_) => true,
            Step::Mul(a, b) => is_power(a) || is_power(b) || self.is_zero(a) || self.is_zero(b),
            Step::Add(a, b) => self.is_zero(a) || self.is_zero(b),
            Step::Sub(_, b) => self.is_zero(b),
            _ => false,
        };
        match (self.rounding, step) {
            _ if is_exact => plain,
            (Rounding::Binary64, _) => format!("float<ieee_64,ne>({plain})"),
            (_, Step::Add(a, b)) => format!("add_rel<53>(c{a}, c{b})"),
            (_, Step::Sub(a, b)) => format!("{}<53>(c{a}, c{b})", if self.sizes { "add_rel" } else { "sub_rel" }),
            (_, Step::Mul(a, b)) => format!("mul_rel<53>(c{a}, c{b})"),
            _ => plain,
        }
    }
}

fn operands(step: Step) -> Vec<usize> {
    match step {
        Step::Neg(a) | Step::Abs(a) | Step::Sqrt(a) | Step::Function(_, a) => vec![a],
        Step::Add(a, b) | Step::Sub(a, b) | Step::Mul(a, b) | Step::Div(a, b) | Step::Angle(a, b) => vec![a, b],
        Step::Input | Step::Constant(_) => Vec::new(),
    }
}
