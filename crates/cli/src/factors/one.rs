//! One factor between surfaces: that of what all their faces exchange, to some digits.
//!
//! A first look says how large it is, and which pairs of faces have others between. These share the errors that are allowed, so that the
//! sum has no more than is asked for, and a stated effort. They are integrated by a rule that looks fast, and, where that does not reach the digits,
//! by one that has many.

use std::fmt;

use radgrad_scene::{Factor, FactorSettings, FormFactors, largest, printable, smallest};
use rayon::prelude::*;
use serde::Serialize;

use super::Failure;

/// Digits, points and pairs of cells unless others are asked for; both together take some ten seconds of one core at most.
pub(super) const DIGITS: u8 = 6;
pub(super) const POINTS: usize = 30_000;
pub(super) const CELLS: usize = 1_000_000;

/// Points and pairs of cells of the first look at a pair of faces.
const LOOK: FactorSettings =
    FactorSettings { tolerance: 1.0, relative: 0.0, most_cells: 1, estimate: 1e-4, relative_estimate: 0.0, most_points: 2000 };

/// The least estimate that the fast rule serves, and points below which the other one cannot begin.
const FAST: f64 = 1e-7;
const LEAST: f64 = 1e-16;
const BEGINNING: usize = 5_000;
/// Its points that take as long as one of the other.
const FAST_A_POINT: usize = 16;

/// What is asked of the factor.
#[derive(Debug, Clone, Copy)]
pub(super) struct Asked {
    pub(super) digits: u8,
    pub(super) tolerance: f64,
    pub(super) relative: f64,
    /// Of all pairs of faces together.
    pub(super) points: usize,
    pub(super) cells: usize,
    /// Whether digits, or a bound, were asked for by name. Where neither was, one of the two will do.
    pub(super) wants: [bool; 2],
}

/// A pair of faces, and the share of the first one in its surface's area.
struct Part {
    faces: [usize; 2],
    share: f64,
    /// Area of the second face over that of the first, at most 1.
    ratio: f64,
    found: Factor,
}

/// The factor, and what of what was asked is reached.
#[derive(Debug, Serialize)]
pub(super) struct OneFactor {
    from: String,
    to: String,
    factor: f64,
    lower: f64,
    upper: f64,
    error: f64,
    /// The part of it that the rounding of coordinates takes.
    modelling: f64,
    estimate: f64,
    occluders: usize,
    seconds: f64,
    digits: u8,
    digits_asked: u8,
    digits_met: bool,
    tolerance: f64,
    tolerance_met: bool,
    #[serde(skip)]
    asked: Asked,
}

impl OneFactor {
    /// The factor between surfaces that are named.
    pub(super) fn find(factors: &FormFactors<'_>, names: [&str; 2], asked: Asked) -> Result<Self, Failure> {
        let scene = factors.scene();
        let [from, to] = [scene.surface_named(names[0])?, scene.surface_named(names[1])?];
        let area = |face: usize| scene.faces()[face].polygon().area();
        let [from_faces, to_faces] = [from, to].map(|surface| scene.surfaces()[surface].faces());
        let pairs: Vec<[usize; 2]> = from_faces.iter().flat_map(|&a| to_faces.iter().map(move |&b| [a, b])).collect();
        let part = |&[a, b]: &[usize; 2]| -> Result<Part, Failure> {
            let found = factors.between(a, b, &LOOK)?;
            Ok(Part { faces: [a, b], share: area(a) / scene.area_of(from), ratio: smallest(area(b) / area(a), 1.0), found })
        };
        let mut parts: Vec<Part> = pairs.par_iter().map(part).collect::<Result<_, _>>()?;
        let look = sum(&parts);
        let open = parts.iter().filter(|part| part.found.occluders > 0).count().max(1);
        let [points, cells] = [asked.points / open, asked.cells / open];
        // Where nothing is seen at a glance, the bracket says how much that can be. A little is left for what the look is off.
        let size = if look.value > 0.0 { 0.99 * look.value } else { look.upper };
        let goal = 0.8 * half_unit(size, asked.digits);
        // Of a sum no term knows whether the absolute bound will count or the relative one: each has one half then.
        let both = if asked.relative > 0.0 && open > 1 { 0.5 } else { 1.0 };
        for is_fast in [true, false] {
            if !is_fast && (sum(&parts).estimate <= goal || points < BEGINNING) {
                break;
            }
            let covers: Vec<f64> = parts.chunks(to_faces.len().max(1)).flat_map(covers).collect();
            let again = |(part, cover): (&mut Part, f64)| -> Result<(), Failure> {
                let settings = FactorSettings {
                    tolerance: smallest(both * asked.tolerance / cover, 1.0),
                    relative: both * asked.relative,
                    most_cells: if is_fast { cells } else { 1 },
                    estimate: if is_fast {
                        largest(goal / cover, FAST)
                    } else {
                        largest(smallest(goal / cover, 0.5 * FAST), LEAST)
                    },
                    relative_estimate: 0.0,
                    most_points: if is_fast { FAST_A_POINT * points } else { points },
                };
                let [a, b] = part.faces;
                part.found = nearest(&part.found, factors.between(a, b, &settings)?);
                Ok(())
            };
            let blocked = parts.par_iter_mut().zip(covers).filter(|(part, _)| part.found.occluders > 0);
            blocked.try_for_each(again)?;
        }
        Ok(Self::of(sum(&parts), names, asked))
    }

    fn of(found: Factor, names: [&str; 2], asked: Asked) -> Self {
        let computed = found.computed_error();
        let Factor { value: factor, lower, upper, error, modelling, estimate, occluders } = found;
        // What is proven is no less known than what is estimated.
        let estimate = smallest(estimate, error);
        // Looks that see nothing say nothing of digits.
        let known = if factor == 0.0 { error } else { estimate };
        let digits = (1..=15).rev().find(|&digits| known <= half_unit(factor, digits)).unwrap_or(0);
        let tolerance = largest(asked.tolerance, asked.relative * lower);
        let [from, to] = names.map(str::to_owned);
        Self {
            from,
            to,
            factor,
            lower,
            upper,
            error,
            modelling,
            estimate,
            occluders,
            seconds: 0.0,
            digits,
            digits_asked: asked.digits,
            digits_met: digits >= asked.digits,
            tolerance,
            tolerance_met: computed <= tolerance,
            asked,
        }
    }

    /// After so many seconds.
    pub(super) fn after(self, seconds: f64) -> Self {
        Self { seconds, ..self }
    }

    /// What was asked for and is not reached, each with the option that goes on.
    pub(super) fn unmet(&self) -> Vec<String> {
        let Asked { points, cells, wants, .. } = self.asked;
        let digits = || {
            let Self { digits, digits_asked, .. } = self;
            let goes_on = if self.occluders == 0 { "that is what roundings leave".to_owned() } else { more("points", points) };
            format!("not met: {digits_asked} digits are asked for, {digits} are reached: {goes_on}")
        };
        let bound = || {
            let Self { tolerance, error, .. } = self;
            let goes_on = if self.occluders == 0 { "that is what roundings leave".to_owned() } else { more("cells", cells) };
            format!("not met: a bound of {tolerance} is asked for, {error:.1e} is proven: {goes_on}")
        };
        let is_wanted = |k: usize| wants[k] || wants == [false; 2];
        let (met, wanted) = ([self.digits_met, self.tolerance_met], [is_wanted(0), is_wanted(1)]);
        if wants == [false; 2] && met.contains(&true) {
            return Vec::new();
        }
        let said = [(wanted[0] && !met[0]).then(digits), (wanted[1] && !met[1]).then(bound)];
        said.into_iter().flatten().collect()
    }
}

/// How a search goes on.
fn more(option: &str, count: usize) -> String {
    format!("--{option} above {count} goes on")
}

/// Half a unit of so many significant digits of a value: an error up to that leaves them all. Of 0 it is 0.
fn half_unit(value: f64, digits: u8) -> f64 {
    let text = format!("{value:e}");
    let exponent = text.split_once('e').and_then(|(_, exponent)| exponent.parse::<i32>().ok());
    let unit = exponent.filter(|_| value != 0.0).and_then(|e| format!("5e{}", e - i32::from(digits)).parse().ok());
    unit.unwrap_or(0.0)
}

/// For each part of one face: how many errors, each an error of the smaller face, those of the face past others add up to.
fn covers(of_face: &[Part]) -> impl Iterator<Item = f64> {
    let cover = of_face.iter().filter(|part| part.found.occluders > 0).map(|part| part.ratio).sum();
    std::iter::repeat_n(cover, of_face.len())
}

/// What two searches for one factor know: both brackets hold, and the better estimate counts.
fn nearest(before: &Factor, found: Factor) -> Factor {
    let [lower, upper] = [largest(before.lower, found.lower), smallest(before.upper, found.upper)];
    let best = if found.estimate <= before.estimate { &found } else { before };
    let value = largest(smallest(best.value, upper), lower);
    let error = largest(upper - value, value - lower) * (1.0 + f64::EPSILON);
    let estimate = best.estimate + (value - best.value).abs();
    Factor { value, lower, upper, error, modelling: found.modelling, estimate, occluders: found.occluders }
}

fn sum(parts: &[Part]) -> Factor {
    let mut sum = Factor { value: 0.0, lower: 0.0, upper: 0.0, error: 0.0, modelling: 0.0, estimate: 0.0, occluders: 0 };
    for Part { share, found, .. } in parts {
        sum.value += share * found.value;
        sum.lower += share * found.lower;
        sum.upper += share * found.upper;
        sum.modelling += share * found.modelling;
        sum.estimate += share * found.estimate;
        sum.occluders = sum.occluders.max(found.occluders);
    }
    // Shares and sums round.
    let off = 4.0 * f64::EPSILON * parts.len() as f64;
    (sum.lower, sum.upper) = (sum.lower * (1.0 - off), sum.upper * (1.0 + off));
    sum.error = largest(sum.upper - sum.value, sum.value - sum.lower) * (1.0 + f64::EPSILON);
    sum
}

impl fmt::Display for OneFactor {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { from, to, factor, lower, upper, estimate, digits, .. } = self;
        let places = usize::from((*digits).max(2)) - 1;
        let [from, to] = [from, to].map(|name| printable(name).to_string());
        writeln!(f, "from {from} to {to}: {factor:.places$e}")?;
        let [how, known] =
            if self.occluders == 0 { ["in free sight", "proven"] } else { ["the difference of two rules", "estimated"] };
        writeln!(f, "off by about        {estimate:.1e}   ({known}: {how})")?;
        write!(f, "proven bracket      [{lower}, {upper}]")?;
        let goals = [
            (format!("{} digits, {known}", self.digits_asked), self.digits_met),
            (format!("a bound of {}, proven", self.tolerance), self.tolerance_met),
        ];
        for (what, is_met) in [("\nreached             ", true), ("\nnot reached         ", false)] {
            let which: Vec<&str> = goals.iter().filter(|goal| goal.1 == is_met).map(|goal| goal.0.as_str()).collect();
            if !which.is_empty() {
                write!(f, "{what}{}", which.join("; "))?;
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn half_a_unit_is_that_of_the_last_digit() {
        assert_eq!([half_unit(0.123, 3), half_unit(9.99, 2), half_unit(2e-7, 6)], [5e-4, 5e-2, 5e-13]);
        assert_eq!([half_unit(0.0, 3), half_unit(f64::NAN, 3), half_unit(f64::INFINITY, 3)], [0.0; 3]);
    }

    #[test]
    fn what_is_met_is_never_said_to_be_unmet() {
        let found = |estimate: f64, error: f64| Factor {
            value: 0.5,
            lower: 0.5 - error,
            upper: 0.5,
            error,
            modelling: 0.0,
            estimate,
            occluders: 1,
        };
        let asked = |wants: [bool; 2]| Asked { digits: 6, tolerance: 1e-3, relative: 0.0, points: 1, cells: 1, wants };
        let said = |found, wants| OneFactor::of(found, ["a", "b"], asked(wants)).unmet().join(" ");
        // The digits, the bound or both are reached: one will do unless one is asked for.
        for (estimate, error, wants, unmet) in [
            (1e-7, 1e-2, [false; 2], [false, false]),
            (1e-5, 1e-4, [false; 2], [false, false]),
            (1e-5, 1e-2, [false; 2], [true, true]),
            (1e-5, 1e-4, [true, false], [true, false]),
            (1e-5, 1e-4, [true, true], [true, false]),
            (1e-7, 1e-2, [true, true], [false, true]),
            (f64::NAN, f64::NAN, [false; 2], [true, true]),
        ] {
            let said = said(found(estimate, error), wants);
            assert_eq!([said.contains("digits"), said.contains("bound")], unmet, "{estimate} {error} {wants:?}: {said}");
        }
    }
}
