//! The bits of answers in one number, and answers to one question held against each other.

use std::fmt::Display;

use glam::DVec3;

use crate::cases::sampler::split_mix;
use crate::measures::measure::{is_worse, worse};

/// The bits so far, and contradictions.
#[derive(Debug, Default)]
pub(super) struct Digest {
    pub(super) bits: u64,
    pub(super) said: u64,
    pub(super) refused: u64,
    pub(super) wrong: Vec<String>,
}

impl Digest {
    pub(super) fn word(&mut self, word: u64) {
        self.said += 1;
        self.bits = split_mix(self.bits ^ word).wrapping_add(self.bits.rotate_left(23));
    }

    /// No answer, whatever the reason: its text may have rounded digits.
    pub(super) fn refused(&mut self) {
        self.refused += 1;
        self.word(u64::MAX);
    }

    /// A NaN of any sign and payload is one.
    pub(super) fn number(&mut self, number: f64) {
        self.word(if number.is_nan() { f64::NAN.to_bits() } else { number.to_bits() });
    }

    pub(super) fn numbers<'a>(&mut self, numbers: impl IntoIterator<Item = &'a f64>) {
        numbers.into_iter().for_each(|&number| self.number(number));
    }

    pub(super) fn vector(&mut self, vector: DVec3) {
        self.numbers(&vector.to_array());
    }

    pub(super) fn text(&mut self, text: impl Display) {
        text.to_string().bytes().for_each(|byte| self.word(byte.into()));
    }

    /// Numbers, or that there are none.
    pub(super) fn say<E: Display>(&mut self, said: Result<Vec<f64>, E>) {
        match said {
            Ok(numbers) => self.numbers(&numbers),
            Err(_) => self.refused(),
        }
    }
}

/// Answers to one question, which have a point in common by pairs.
pub(super) struct Question<'a> {
    pub(super) name: &'a str,
    pub(super) said: Vec<(String, [f64; 3], f64)>,
}

impl<'a> Question<'a> {
    pub(super) const fn new(name: &'a str) -> Self {
        Self { name, said: Vec::new() }
    }

    pub(super) fn add(&mut self, digest: &mut Digest, by: impl Display, value: [f64; 3], bound: f64) {
        digest.numbers(&value);
        digest.number(bound);
        self.said.push((by.to_string(), value, bound));
    }

    pub(super) fn close(self, digest: &mut Digest) {
        let Some((best, at, least)) = self.said.iter().min_by(|a, b| a.2.total_cmp(&b.2)) else { return };
        for (by, value, bound) in &self.said {
            let apart = [0, 1, 2].map(|k| (value[k] - at[k]).abs());
            let difference = apart.into_iter().fold(0.0, worse);
            let room = (bound + least) * (1.0 + 1e-9) + f64::MIN_POSITIVE;
            if is_worse(difference, room) {
                let name = self.name;
                digest.wrong.push(format!("{name}, {by}: {value:?} is off {best} by {difference:e}, the bounds allow {room:e}"));
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_bit_of_any_number_changes_a_digest_and_a_nan_of_another_sign_does_not() {
        let of = |numbers: &[f64]| {
            let mut digest = Digest::default();
            digest.numbers(numbers);
            digest.bits
        };
        let numbers = [1.0, -0.0, f64::NAN];
        assert_eq!(of(&numbers), of(&[1.0, -0.0, -f64::NAN]));
        for other in [[1.0 + f64::EPSILON, -0.0, f64::NAN], [1.0, 0.0, f64::NAN], [-0.0, 1.0, f64::NAN]] {
            assert_ne!(of(&numbers), of(&other));
        }
    }

    #[test]
    fn an_answer_that_is_off_by_more_than_the_bounds_contradicts_the_best() {
        let off = |off: f64| {
            let (mut digest, mut question) = (Digest::default(), Question::new("of a test"));
            question.add(&mut digest, "one", [1.0, 0.0, 0.0], 0.5);
            question.add(&mut digest, "another", [1.0 + off, 0.0, 0.0], 0.25);
            question.close(&mut digest);
            digest.wrong.len()
        };
        assert_eq!([off(0.7), off(0.8), off(f64::NAN)], [0, 1, 2]);
    }
}
