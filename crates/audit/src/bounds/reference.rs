//! The reference of an answer: a truth with a radius.

use glam::DVec3;
use radgrad_core::Answer;

use crate::bounds::mark::Mark;
use crate::measures::truth::{Truth, norm_above};

/// A truth, by its source.
#[derive(Debug, Clone, PartialEq)]
pub enum Reference {
    /// Core's answer to a tolerance of 0: its doubles, and its bounds as radii.
    Core(Answer),
    /// Core's answer to many digits.
    Digits(Truth),
    /// The oracle's enclosure.
    Oracle(Truth),
}

/// How far an answer is from a truth that is known to within a radius.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Distance {
    /// It cannot be less.
    pub least: f64,
    /// It cannot be more.
    pub most: f64,
    /// How well the truth is known.
    pub radius: f64,
}

impl Distance {
    /// From the distance of two doubles (or of vectors of them), itself off by a relative 8 eps at most.
    fn of_doubles(apart: f64, radius: f64) -> Self {
        let least = apart * (1.0 - 8.0 * f64::EPSILON) - radius;
        let upper = (apart + radius) * (1.0 + 8.0 * f64::EPSILON);
        Self { least: if least > 0.0 { least } else { 0.0 }, most: upper, radius }
    }

    /// Whether the radius is at most a hundredth of a bound.
    #[must_use]
    pub(crate) fn is_sharp(&self, bound: f64) -> bool {
        self.radius <= 0.01 * bound
    }
}

impl Reference {
    /// The mark that counts a case checked against it.
    #[must_use]
    pub const fn mark(&self) -> Mark {
        match self {
            Self::Core(_) => Mark::AgainstCore,
            Self::Digits(_) => Mark::AgainstDigits,
            Self::Oracle(_) => Mark::AgainstOracle,
        }
    }

    /// Whether it is known to many more digits than a double has.
    #[must_use]
    pub(crate) const fn has_many_digits(&self) -> bool {
        !matches!(self, Self::Core(_))
    }

    /// Distances of the radiosity and of the gradient of an answer (Euclidean norm).
    #[must_use]
    pub fn distances(&self, answer: &Answer) -> [Distance; 2] {
        match self {
            Self::Core(truth) => [
                Distance::of_doubles((answer.radiosity - truth.radiosity).abs(), truth.radiosity_error),
                Distance::of_doubles(norm_above(answer.gradient - truth.gradient), truth.gradient_error),
            ],
            Self::Digits(truth) | Self::Oracle(truth) => {
                let (value, gradient) = truth.errors_at_least(answer.radiosity, answer.gradient);
                let radii = DVec3::from_array([0, 1, 2].map(|axis| truth.gradient[axis].radius()));
                let upper = [truth.radiosity_error(answer.radiosity), truth.gradient_error(answer.gradient)];
                [
                    Distance { least: value, most: upper[0], radius: truth.radiosity.radius() },
                    Distance { least: gradient, most: upper[1], radius: norm_above(radii) },
                ]
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use radgrad_core::Method;
    use radgrad_oracle::Interval;

    fn answer(radiosity: f64, radiosity_error: f64) -> Answer {
        let gradient = DVec3::new(3e-200, 0.0, 4e-200);
        Answer { radiosity, gradient, radiosity_error, gradient_error: 1e-215, method: Method::ClosedForm }
    }

    #[test]
    fn the_radius_of_the_truth_is_in_favour_of_the_bound() {
        let truth = Reference::Core(answer(1.0, 1e-16));
        let [value, _] = truth.distances(&answer(1.0 + 1e-10, 0.0));
        assert!(value.least < 1e-10 && value.least > 0.999_998e-10 && value.most > 1e-10 && value.most < 1.000_002e-10);
        let [value, gradient] = truth.distances(&answer(1.0, 0.0));
        assert_eq!((value.least, gradient.least), (0.0, 0.0));
        assert!(value.is_sharp(1e-14) && !value.is_sharp(1e-15));
    }

    #[test]
    fn a_gradient_far_below_the_root_of_the_smallest_double_has_a_distance() {
        let zero = Answer { gradient: DVec3::ZERO, ..answer(1.0, 0.0) };
        let [_, gradient] = Reference::Core(answer(1.0, 1e-16)).distances(&zero);
        assert!((gradient.least / 5e-200 - 1.0).abs() < 1e-13);
    }

    #[test]
    fn intervals_and_doubles_say_the_same() {
        let read = |text: &str| Interval::around_decimal(text, 1e-30).unwrap();
        let truth = Truth { radiosity: read("1"), gradient: [read("0"), read("0"), read("0")] };
        let [value, gradient] = Reference::Oracle(truth).distances(&answer(1.0 + 1e-10, 0.0));
        assert!((value.least / 1e-10 - 1.0).abs() < 1e-5 && (value.most / 1e-10 - 1.0).abs() < 1e-5);
        assert!(value.is_sharp(1e-16) && gradient.radius > 1e-30);
    }
}
