//! The paper's equations against each other: Eq. 1 over the surface with its gradient under the integral, Eqs. 6 and 9 as corrected
//! along the contour and over the surface, and the visible boundary form, each by adaptive cubature, for constant, linear, polynomial
//! and arbitrary emission; and against the enclosure where the emission has one.
//!
//! They share the clipped region and the rules, not the integrand: a slip in one of the equations contradicts the others.

use std::fmt;

use glam::DVec3;
use radgrad_core::{Emission, Emitter, Polygon, Polynomial, Receiver};
use radgrad_oracle::cubature::{Estimate, Form, Status, integrate_form};
use radgrad_oracle::{EmissionFunction, SourceFunction};
use rayon::prelude::*;

use crate::cases::family::{Family, Name};
use crate::measures::measure::{is_worse, ratio, worse};
use crate::measures::truth::Truth;

/// Families in whose cases the contour keeps its digits.
const FAMILIES: [Family; 4] = [Family::Generic, Family::Clipped, Family::NGon, Family::Concave];

/// Relative tolerance asked of the cubature.
const TOLERANCE: f64 = 1e-8;

/// Evaluations it may spend on a form.
const BUDGET: usize = 300_000;

/// Two forms that converged may be so many tolerances apart.
const APART: f64 = 20.0;

/// Kind of emission.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum EmissionLaw {
    /// The same everywhere.
    Constant,
    /// Affine.
    Linear,
    /// A polynomial of degree 3.
    Polynomial,
    /// A function with its gradient, a wave.
    Arbitrary,
}

impl EmissionLaw {
    /// All, in the order of the table.
    pub const ALL: [Self; 4] = [Self::Constant, Self::Linear, Self::Polynomial, Self::Arbitrary];

    /// Name in tables.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Constant => "constant",
            Self::Linear => "linear",
            Self::Polynomial => "polynomial",
            Self::Arbitrary => "arbitrary",
        }
    }
}

/// The forms in the order of the table, with their names.
pub const FORMS: [(Form, &str); 3] =
    [(Form::Surface, "Eq. 1"), (Form::Contour, "Eqs. 6 and 9"), (Form::Boundary, "visible boundary")];

/// The agreement of the forms for a kind of emission.
#[derive(Debug, Clone, PartialEq)]
pub struct Row {
    /// Which.
    pub kind: EmissionLaw,
    /// Cases.
    pub cases: usize,
    /// Of these, converged, by form.
    pub converged: [usize; 3],
    /// Held against an enclosure too.
    pub enclosed: usize,
    /// The largest relative difference, of value or gradient.
    pub worst: f64,
    /// Its case.
    pub case: Option<Name>,
}

/// Two forms, or a form and the enclosure, that give different numbers.
#[derive(Debug, Clone, PartialEq)]
pub struct Contradiction {
    /// The case, whose receiver and polygon are taken.
    pub case: Name,
    /// The emission.
    pub kind: EmissionLaw,
    /// Which forms differ, and by how much.
    pub what: String,
}

impl fmt::Display for Contradiction {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "forms: {} emission at {}: {}", self.kind.name(), self.case, self.what)
    }
}

/// The equations on `count` cases of each family and emission.
#[must_use]
pub fn forms(seed: u64, count: u64) -> (Vec<Row>, Vec<Contradiction>) {
    let names: Vec<Name> =
        FAMILIES.iter().flat_map(|&family| (0..count).map(move |index| Name { family, seed, index })).collect();
    let (mut rows, mut contradictions) = (Vec::new(), Vec::new());
    for kind in EmissionLaw::ALL {
        let mut row = Row { kind, cases: names.len(), converged: [0; 3], enclosed: 0, worst: 0.0, case: None };
        let compared: Vec<Compared> = names.par_iter().map(|&name| compare(name, kind)).collect();
        for (name, compared) in names.iter().zip(compared) {
            for (sum, converged) in row.converged.iter_mut().zip(compared.converged) {
                *sum += usize::from(converged);
            }
            row.enclosed += usize::from(compared.enclosed);
            if row.case.is_none() || is_worse(compared.worst, row.worst) {
                (row.worst, row.case) = (compared.worst, Some(*name));
            }
            contradictions.extend(compared.wrong.into_iter().map(|what| Contradiction { case: *name, kind, what }));
        }
        for ((_, form), converged) in FORMS.iter().zip(row.converged) {
            if 2 * converged < row.cases {
                let what = format!("{form} converged in {converged} of {} cases only", row.cases);
                contradictions.push(Contradiction { case: names[0], kind, what });
            }
        }
        rows.push(row);
    }
    (rows, contradictions)
}

#[derive(Default)]
struct Compared {
    converged: [bool; 3],
    enclosed: bool,
    worst: f64,
    wrong: Vec<String>,
}

fn compare(name: Name, kind: EmissionLaw) -> Compared {
    let mut compared = Compared::default();
    let problem = match name.case().problem() {
        Ok(problem) => problem,
        Err(error) => {
            compared.wrong.push(error.to_string());
            return compared;
        }
    };
    let (receiver, polygon) = (&problem.receiver, problem.emitter.polygon());
    let origin = polygon.vertices()[0];
    let size = polygon.vertices().iter().map(|v| (*v - origin).length()).fold(0.0, f64::max);
    let slope = DVec3::new(0.5, -0.25, 0.375) / size;
    let emission = match kind {
        EmissionLaw::Constant => Ok(Emission::Constant(1.5)),
        EmissionLaw::Linear => Ok(Emission::gradient(1.5, slope)),
        EmissionLaw::Polynomial => {
            let terms = [
                (1.5, [0, 0, 0]),
                (0.5 / size, [1, 0, 0]),
                (0.3 / (size * size), [0, 1, 1]),
                (0.2 / (size * size * size), [2, 1, 0]),
            ];
            Polynomial::new(origin, terms).map(Emission::Polynomial)
        }
        EmissionLaw::Arbitrary => {
            return compared.with(name, receiver, polygon, None, (&|y| wave(origin, size, y), &|y| wave_slope(origin, size, y)));
        }
    };
    let emitter = emission.and_then(|emission| Emitter::new(polygon.clone(), emission));
    let emitter = match emitter {
        Ok(emitter) => emitter,
        Err(error) => {
            compared.wrong.push(error.to_string());
            return compared;
        }
    };
    let Emission::Polynomial(polynomial) = emitter.emission() else {
        return compared.with(
            name,
            receiver,
            polygon,
            Some(&emitter),
            (&|y| emitter.emission_at(y), &|_| emitter.emission_gradient()),
        );
    };
    let value = |y: DVec3| polynomial.terms().iter().map(|t| t.coefficient * power(y - polynomial.origin(), t.powers)).sum();
    let gradient = |y: DVec3| {
        let r = y - polynomial.origin();
        DVec3::from_array([0, 1, 2].map(|axis| {
            let lowered = |powers: [u8; 3]| std::array::from_fn(|i| if i == axis { powers[i] - 1 } else { powers[i] });
            let terms = polynomial.terms().iter().filter(|t| t.powers[axis] > 0);
            terms.map(|t| t.coefficient * f64::from(t.powers[axis]) * power(r, lowered(t.powers))).sum()
        }))
    };
    compared.with(name, receiver, polygon, Some(&emitter), (&value, &gradient))
}

fn power(r: DVec3, powers: [u8; 3]) -> f64 {
    let factor = |axis: usize| (0..powers[axis]).fold(1.0, |product, _| product * r[axis]);
    factor(0) * factor(1) * factor(2)
}

/// Three radians from vertex 0 along a direction.
fn wave(origin: DVec3, size: f64, y: DVec3) -> f64 {
    1.5 + libm::sin((y - origin).dot(DVec3::new(2.0, -1.0, 2.0)) / size)
}

fn wave_slope(origin: DVec3, size: f64, y: DVec3) -> DVec3 {
    let along = DVec3::new(2.0, -1.0, 2.0) / size;
    along * libm::cos((y - origin).dot(along))
}

/// An emission and its gradient.
type Function<'a> = (&'a dyn Fn(DVec3) -> f64, &'a dyn Fn(DVec3) -> DVec3);

impl Compared {
    fn with(
        mut self,
        name: Name,
        receiver: &Receiver,
        polygon: &Polygon,
        emitter: Option<&Emitter>,
        function: Function<'_>,
    ) -> Self {
        let function =
            EmissionFunction { radiosity: function.0, gradient: Some(function.1), detail: f64::INFINITY, bounds: None };
        let estimates = FORMS.map(|(form, called)| {
            match integrate_form(receiver, polygon, SourceFunction::Function(&function), form, TOLERANCE, BUDGET) {
                Ok(estimate) => (estimate.status == Status::Converged).then_some(estimate),
                Err(radgrad_oracle::Error::Evaluations { .. }) => None,
                Err(error) => {
                    self.wrong.push(format!("{called}: {error}"));
                    None
                }
            }
        });
        self.converged = estimates.map(|estimate| estimate.is_some());
        let converged: Vec<(&str, Estimate)> =
            FORMS.iter().zip(estimates).filter_map(|((_, called), e)| Some((*called, e?))).collect();
        if let Some(((_, first), others)) = converged.split_first() {
            for (called, other) in others {
                let value = (other.radiosity - first.radiosity).abs() / first.radiosity.abs();
                let apart = worse(value, (other.gradient - first.gradient).length() / first.gradient.length());
                self.note(apart, || format!("{called} and {} are {apart:.1e} apart", converged[0].0));
            }
        }
        let Some(emitter) = emitter else { return self };
        match Truth::unoccluded(receiver, emitter) {
            Ok(truth) => {
                self.enclosed = true;
                for (called, estimate) in &converged {
                    let value = ratio(truth.radiosity_error(estimate.radiosity), truth.radiosity_magnitude());
                    let error = worse(value, ratio(truth.gradient_error(estimate.gradient), truth.gradient_magnitude()));
                    self.note(error, || format!("{called} is off the enclosure by {error:.1e}"));
                }
            }
            Err(error) => self.wrong.push(format!("{name} has no enclosure: {error}")),
        }
        self
    }

    fn note(&mut self, apart: f64, what: impl FnOnce() -> String) {
        self.worst = worse(self.worst, apart);
        // A NaN agrees with nothing.
        if apart.is_nan() || apart > APART * TOLERANCE {
            self.wrong.push(what());
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_papers_equations_agree_for_every_emission() {
        let (rows, contradictions) = forms(1, 2);
        assert_eq!(contradictions, []);
        assert!(rows.iter().all(|row| row.converged.iter().all(|count| 2 * count >= row.cases)), "{rows:?}");
        assert!(rows[..3].iter().all(|row| row.enclosed == row.cases) && rows[3].enclosed == 0, "{rows:?}");
    }

    #[test]
    fn forms_that_differ_are_seen() {
        let mut compared = Compared::default();
        compared.note(1e-6, || "apart".to_owned());
        compared.note(f64::NAN, || "not a number".to_owned());
        compared.note(1e-9, || "close".to_owned());
        assert_eq!(compared.wrong, ["apart", "not a number"]);
        assert!(
            compared.worst.is_nan() && worse(f64::NAN, 1.0).is_nan() && worse(1.0, f64::NAN).is_nan() && worse(1.0, 2.0) == 2.0
        );
    }
}
