//! A scalar that records the operations on it: core's closed forms, run on [`Recorded`], leave the straight-line program of the
//! code that users run.
//!
//! Each number also has the double that it would be, so that the program takes the path of one example; the decisions on the way are
//! recorded as they were taken. A closed form has few paths, and a lemma records one for each.

use std::cell::RefCell;
use std::ops::{Add, Div, Mul, Neg, Sub};

use radgrad_core::closed_forms::{Arithmetic, Doubles};

/// A step, on the steps of the numbers given.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Step {
    Input,
    Constant(f64),
    Neg(usize),
    Abs(usize),
    Sqrt(usize),
    Add(usize, usize),
    Sub(usize, usize),
    Mul(usize, usize),
    Div(usize, usize),
    /// A function that lemmas treat as a number with a known error: no step of it is seen.
    Function(&'static str, usize),
    /// The angle of a point, likewise: y, x.
    Angle(usize, usize),
}

/// The recorded steps.
#[derive(Debug, Default)]
pub(crate) struct Tape {
    /// Steps, each with its value in the example.
    steps: RefCell<Vec<(Step, f64)>>,
    /// Comparisons: whether the first number exceeded the second one.
    decisions: RefCell<Vec<(usize, usize, bool)>>,
}

/// A number on a tape.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Recorded<'t> {
    tape: &'t Tape,
    pub(crate) place: usize,
}

impl Tape {
    /// An input, of that value in the example.
    pub(crate) fn input(&self, value: f64) -> Recorded<'_> {
        self.push(Step::Input, value)
    }

    pub(crate) fn inputs<const N: usize>(&self, values: [f64; N]) -> [Recorded<'_>; N] {
        values.map(|value| self.input(value))
    }

    fn push(&self, step: Step, value: f64) -> Recorded<'_> {
        let mut steps = self.steps.borrow_mut();
        steps.push((step, value));
        Recorded { tape: self, place: steps.len() - 1 }
    }

    pub(crate) fn step(&self, place: usize) -> Step {
        self.steps.borrow()[place].0
    }

    pub(crate) fn recorded(&self, place: usize) -> Recorded<'_> {
        Recorded { tape: self, place }
    }

    pub(crate) fn len(&self) -> usize {
        self.steps.borrow().len()
    }

    /// The path that was taken.
    pub(crate) fn decisions(&self) -> Vec<(usize, usize, bool)> {
        self.decisions.borrow().clone()
    }

    /// The program on other inputs, in doubles; `of` evaluates a function.
    #[cfg(test)]
    pub(crate) fn replay(&self, inputs: &[f64]) -> Vec<f64> {
        let (mut inputs, mut values) = (inputs.iter(), Vec::<f64>::new());
        for (step, _) in self.steps.borrow().iter() {
            values.push(match *step {
                Step::Input => *inputs.next().expect("a value for each input"),
                Step::Constant(value) => value,
                Step::Neg(a) => -values[a],
                Step::Abs(a) => values[a].abs(),
                Step::Sqrt(a) => values[a].sqrt(),
                Step::Add(a, b) => values[a] + values[b],
                Step::Sub(a, b) => values[a] - values[b],
                Step::Mul(a, b) => values[a] * values[b],
                Step::Div(a, b) => values[a] / values[b],
                Step::Function("exponent", a) => values[a].exponent_and_mantissa().0,
                Step::Function("mantissa", a) => values[a].exponent_and_mantissa().1,
                Step::Function(name, _) => panic!("no lemma asks for {name}"),
                Step::Angle(y, x) => Arithmetic::atan2(values[y], values[x]),
            });
        }
        values
    }
}

impl<'t> Recorded<'t> {
    fn value(self) -> f64 {
        self.tape.steps.borrow()[self.place].1
    }

    /// The number that this is the root of.
    pub(crate) fn operand(self) -> Self {
        match self.tape.step(self.place) {
            Step::Sqrt(a) | Step::Neg(a) | Step::Abs(a) => Self { place: a, ..self },
            step => unreachable!("{step:?} has no one operand"),
        }
    }

    /// The two numbers that this was made of.
    pub(crate) fn operands(self) -> [Self; 2] {
        match self.tape.step(self.place) {
            Step::Add(a, b) | Step::Sub(a, b) | Step::Mul(a, b) | Step::Div(a, b) | Step::Angle(a, b) => {
                [a, b].map(|place| Self { place, ..self })
            }
            step => unreachable!("{step:?} has no two operands"),
        }
    }

    fn push(self, step: Step, value: f64) -> Self {
        self.tape.push(step, value)
    }
}

macro_rules! operations {
    ($($trait:ident $method:ident $operator:tt),*) => {$(
        impl $trait for Recorded<'_> {
            type Output = Self;
            fn $method(self, other: Self) -> Self {
                self.push(Step::$trait(self.place, other.place), self.value() $operator other.value())
            }
        }
    )*};
}

operations!(Add add +, Sub sub -, Mul mul *, Div div /);

impl Neg for Recorded<'_> {
    type Output = Self;
    fn neg(self) -> Self {
        self.push(Step::Neg(self.place), -self.value())
    }
}

impl Arithmetic for Recorded<'_> {
    type Mask = bool;
    const IS_DOUBLE: bool = true;

    fn like(self, constant: f64) -> Self {
        self.push(Step::Constant(constant), constant)
    }

    fn like_pi(self) -> Self {
        self.like(std::f64::consts::PI)
    }

    fn exceeds(self, other: Self) -> bool {
        let exceeds = self.value() > other.value();
        self.tape.decisions.borrow_mut().push((self.place, other.place, exceeds));
        exceeds
    }

    fn choose(mask: bool, set: Self, unset: Self) -> Self {
        if mask { set } else { unset }
    }

    fn choose_of(mask: bool, set: impl FnOnce() -> Self, unset: impl FnOnce() -> Self) -> Self {
        if mask { set() } else { unset() }
    }

    fn abs(self) -> Self {
        self.push(Step::Abs(self.place), self.value().abs())
    }

    fn sqrt(self) -> Self {
        self.push(Step::Sqrt(self.place), self.value().sqrt())
    }

    fn ln(self) -> Self {
        self.push(Step::Function("ln", self.place), Arithmetic::ln(self.value()))
    }

    fn atan2(self, x: Self) -> Self {
        self.push(Step::Angle(self.place, x.place), Arithmetic::atan2(self.value(), x.value()))
    }

    fn clausen_rest(self) -> Self {
        self.push(Step::Function("clausen_rest", self.place), self.value().clausen_rest())
    }

    fn sine_series(square: Self) -> Self {
        radgrad_core::closed_forms::sine_series(square) * square.like(12.0)
    }

    fn known_to(self, _: f64) -> Self {
        self
    }
}

impl Doubles for Recorded<'_> {
    fn min(self, other: Self) -> Self {
        if other.exceeds(self) { self } else { other }
    }

    fn max(self, other: Self) -> Self {
        if self.exceeds(other) { self } else { other }
    }

    fn exponent_and_mantissa(self) -> (Self, Self) {
        let (exponent, mantissa) = self.value().exponent_and_mantissa();
        (self.push(Step::Function("exponent", self.place), exponent), self.push(Step::Function("mantissa", self.place), mantissa))
    }

    fn entry(self, table: &[[[f64; 3]; 3]; 4], row: (bool, Option<bool>), column: [bool; 2]) -> [Self; 3] {
        self.value().entry(table, row, column).map(|constant| self.like(constant))
    }
}
