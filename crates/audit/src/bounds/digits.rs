//! Answers to many digits, and enclosures read from them.

use radgrad_core::{PreciseAnswer, evaluate_digits};
use radgrad_oracle::{Interval, enclose_occluded};
use radgrad_scene::case::Problem;

use crate::bounds::mark::Mark;
use crate::measures::seen::visible_part;
use crate::measures::truth::Truth;

/// Digits that are checked, in turn.
pub(crate) const MANY: [u32; 3] = [30, 50, 100];

/// Digits that the oracle is asked for beyond those checked.
const MORE: u32 = 4;

/// Core's enclosure to so many digits.
///
/// # Errors
/// If they are out of reach; why.
pub fn enclosure(problem: &Problem, digits: u32) -> Result<Truth, String> {
    let Problem { receiver, emitter, occluders, .. } = problem;
    let answer = evaluate_digits(receiver, emitter, occluders, digits).map_err(|error| error.to_string())?;
    read(&answer).ok_or_else(|| format!("not decimal numbers: {answer:?}"))
}

/// The bound on the norm of the gradient's error holds for each component.
fn read(answer: &PreciseAnswer) -> Option<Truth> {
    let interval = |text: &str, error: &str| {
        let radius: f64 = error.parse().ok()?;
        Interval::around_decimal(text, radius * (1.0 + 2.0 * f64::EPSILON)).ok()
    };
    let [x, y, z] = answer.gradient.each_ref().map(|text| interval(text, &answer.gradient_error));
    Some(Truth { radiosity: interval(&answer.radiosity, &answer.radiosity_error)?, gradient: [x?, y?, z?] })
}

/// Holds core's `digits` against twice as many, and against the oracle's if asked; marks, each with its message.
#[must_use]
pub fn check(problem: &Problem, digits: u32, by_oracle: bool) -> Vec<(Mark, String)> {
    let [few, more] = match [digits, 2 * digits].map(|digits| enclosure(problem, digits)) {
        [Ok(few), Ok(more)] => [few, more],
        [Err(why), _] | [_, Err(why)] => return vec![(Mark::ManyDigitsUnanswered, why)],
    };
    let mut marks = vec![(Mark::ManyDigits, String::new())];
    let mut compare = |truth: &Truth, with: &str| {
        if !few.overlaps(truth) {
            marks.push((Mark::ManyDigitsBroken, format!("{digits} digits and {with} have nothing in common")));
        }
    };
    compare(&more, "twice as many");
    if by_oracle {
        let emitter = visible_part(problem);
        let occluders = if emitter.is_some() { &[][..] } else { &problem.occluders };
        match enclose_occluded(&problem.receiver, emitter.as_deref().unwrap_or(&problem.emitter), occluders, digits + MORE) {
            Ok(enclosure) => {
                compare(&Truth { radiosity: enclosure.radiosity, gradient: enclosure.gradient }, "the oracle's");
                marks.push((Mark::ManyDigitsAgainstOracle, String::new()));
            }
            Err(error) => marks.push((Mark::WithoutOracle, error.to_string())),
        }
    }
    marks
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cases::family::Family;

    #[test]
    fn digits_agree_with_more_of_them_and_with_the_oracle() {
        for (family, digits) in
            [(Family::Generic, 30), (Family::FarNeedle, 50), (Family::FarScreen, 100), (Family::BackFacing, 30)]
        {
            let problem = family.case(1, 3).problem().unwrap();
            let marks: Vec<Mark> = check(&problem, digits, true).into_iter().map(|(mark, _)| mark).collect();
            assert_eq!(marks, [Mark::ManyDigits, Mark::ManyDigitsAgainstOracle], "{family}");
        }
    }

    #[test]
    fn an_answer_whose_bound_is_too_small_is_seen() {
        let problem = Family::Generic.case(1, 0).problem().unwrap();
        let truth = enclosure(&problem, 60).unwrap();
        let Problem { receiver, emitter, occluders, .. } = &problem;
        let mut answer = evaluate_digits(receiver, emitter, occluders, 30).unwrap();
        assert!(read(&answer).unwrap().overlaps(&truth));
        answer.radiosity_error = "1e-40".to_owned();
        assert!(!read(&answer).unwrap().overlaps(&truth));
    }
}
