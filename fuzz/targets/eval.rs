//! Lines of `radgrad eval`, read and answered.
#![no_main]

#[allow(dead_code, reason = "each target uses a part")]
#[path = "../../crates/scene/tests/all/hostile/rules.rs"]
mod rules;

use radgrad_scene::case::{Line, Reply};

/// Past these an answer may rightly take as long as the program gives a line.
const DIGITS: u32 = 20;
const TOLERANCE: f64 = 1e-13;

libfuzzer_sys::fuzz_target!(|text: &[u8]| {
    let Some(read) = Line::read(1, text) else { return };
    let answered = read.and_then(|line| {
        let is_quick = line.wanted.digits.is_none_or(|digits| digits <= DIGITS) && line.case.tolerance >= TOLERANCE;
        if is_quick { line.answer().map(Some) } else { Ok(None) }
    });
    match answered {
        Err(refusal) => assert!(rules::is_shown(&refusal.error.to_string()), "{refusal:?}"),
        Ok(Some(Reply::Doubles(answer))) => {
            let errors = [answer.radiosity_error, answer.gradient_error];
            assert!(errors.iter().all(|error| (0.0..f64::INFINITY).contains(error)), "{answer:?}");
            assert!(answer.radiosity.is_finite() && answer.gradient.iter().all(|component| component.is_finite()), "{answer:?}");
        }
        Ok(_) => {}
    }
});
