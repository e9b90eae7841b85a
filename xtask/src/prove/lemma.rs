//! A lemma to prove, and a fault to plant in it.

use radgrad_core::closed_forms::units::{MOST_DISPLACED, SECOND_ORDER};

use crate::prove::script::Script;

/// Unit roundoff.
pub(crate) const U: f64 = f64::EPSILON / 2.0;

/// A statement on a piece of core's code.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Lemma {
    pub(crate) name: &'static str,
    /// Its statement, beside the number.
    pub(crate) says: &'static str,
    /// The number that core has for it.
    pub(crate) stated: f64,
    /// Scripts, one a path or a corner; all must be proved.
    pub(crate) cases: fn(&Stated) -> Vec<Case>,
    /// Whether the code has a coefficient to alter.
    pub(crate) has_coefficient: bool,
}

impl Lemma {
    pub(crate) const fn new(name: &'static str, stated: f64, cases: fn(&Stated) -> Vec<Case>, says: &'static str) -> Self {
        Self { name, says, stated, cases, has_coefficient: false }
    }

    pub(crate) const fn with_coefficient(self) -> Self {
        Self { has_coefficient: true, ..self }
    }
}

/// A script with its name.
#[derive(Debug)]
pub(crate) struct Case {
    pub(crate) name: String,
    pub(crate) script: String,
}

/// The number that a lemma's scripts state, and a factor of a coefficient of the code: those of core, or with a fault.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Stated {
    pub(crate) number: f64,
    pub(crate) coefficient: f64,
}

impl Stated {
    pub(crate) fn as_is(lemma: &Lemma) -> Self {
        Self { number: lemma.stated, coefficient: 1.0 }
    }

    /// With half of the constant: too little, or the constant would be wide by two.
    pub(crate) fn half(lemma: &Lemma) -> Self {
        Self { number: 0.5 * lemma.stated, coefficient: 1.0 }
    }

    pub(crate) fn coefficient_off(lemma: &Lemma) -> Option<Self> {
        lemma.has_coefficient.then_some(Self { number: lemma.stated, coefficient: 1.0 + 1e-6 })
    }

    /// To first order, so many units of roundoff and the error from outside the code.
    pub(crate) fn units_and(&self, outside: f64) -> f64 {
        SECOND_ORDER * (self.number * U + outside)
    }
}

/// Errors from outside the code: of w and of crossing points.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Displaced {
    pub(crate) ew: f64,
    pub(crate) eta: f64,
}

impl Displaced {
    /// By nothing.
    pub(crate) const NOT: Self = Self { ew: 0.0, eta: 0.0 };

    /// The corners of the allowed range.
    ///
    /// They suffice. An error is at most a power series in the sizes of the given errors, with coefficients that are not negative: so it is
    /// convex in each of these alone. The bound is linear in each. Their difference is largest at a corner.
    pub(crate) fn corners() -> impl Iterator<Item = Self> {
        const ENDS: [f64; 2] = [0.0, MOST_DISPLACED];
        ENDS.into_iter().flat_map(|ew| ENDS.into_iter().map(move |eta| Self { ew, eta }))
    }

    /// Those of crossing points alone.
    pub(crate) fn of_points() -> impl Iterator<Item = Self> {
        Self::corners().filter(|corner| corner.ew == 0.0)
    }

    pub(crate) fn case(&self, also: &str, script: &Script<'_>) -> Case {
        let size = |displaced: f64, name| if displaced > 0.0 { format!("largest {name}") } else { format!("no {name}") };
        Case { name: format!("{}, {}{also}", size(self.ew, "ew"), size(self.eta, "eta")), script: script.write() }
    }
}
