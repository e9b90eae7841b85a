//! Digests: of many thousands of answers every bit, bounds, methods and counts of work with them, as one number a block.
//!
//! Whatever changes changes the digest, however far it is below every bound. Core, the oracle and factors give the same bits on every
//! machine and on every number of threads; solutions and certificates do not, and have records of their own. The statements of a block
//! are held against each other too: all answers to one question have a point in common.

mod of_core;
mod of_others;

use std::fmt::Display;

use glam::DVec3;

use super::{Asked, Recorded, Statement};
use crate::cases::sampler::split_mix;
use crate::checks::{hidden, lamps};
use crate::measures::measure::{is_worse, worse};

/// The subject of a block.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Block {
    /// Cases of a family, asked in every way.
    Cases,
    /// Cases on the brink of decisions.
    Brinks,
    /// Receivers in batches, with and without occluders, and emitters from one receiver.
    Batches,
    /// Totals of trees of a few lamps.
    Trees,
    /// Single operations in every arithmetic.
    Operations,
    /// Polygons and emissions.
    Problems,
    /// The oracle's enclosures.
    Enclosures,
    /// The oracle's cubature and samples.
    Estimates,
    /// Edges, exchanges and screens.
    Exchanges,
    /// The index of occluders.
    Index,
    /// Matrices of form factors.
    Factors,
}

impl Block {
    pub(super) const ALL: [(&str, Self); 11] = [
        ("cases", Self::Cases),
        ("brinks", Self::Brinks),
        ("batches", Self::Batches),
        ("trees", Self::Trees),
        ("operations", Self::Operations),
        ("problems", Self::Problems),
        ("enclosures", Self::Enclosures),
        ("estimates", Self::Estimates),
        ("exchanges", Self::Exchanges),
        ("index", Self::Index),
        ("factors", Self::Factors),
    ];

    /// Its name.
    pub(super) fn name(self) -> &'static str {
        Self::ALL.into_iter().find(|(_, block)| *block == self).map_or("other", |(name, _)| name)
    }

    /// Who is asked.
    pub(super) const fn asks(self) -> Asked {
        match self {
            Self::Enclosures | Self::Estimates => Asked::Oracle,
            Self::Exchanges | Self::Index | Self::Factors => Asked::Scenes,
            _ => Asked::Core,
        }
    }

    /// The digest of a block, and the contradictions in it.
    pub(super) fn asked(self, index: u64) -> Result<Recorded, String> {
        let mut digest = Digest::default();
        match self {
            Self::Cases => of_core::of_cases(&mut digest, index),
            Self::Brinks => of_core::of_brinks(&mut digest, index),
            Self::Batches => of_core::of_batches(&mut digest, index),
            Self::Trees => (0..20).for_each(|k| digest.say(lamps::recorded(20 * index + k))),
            Self::Operations => (0..400).for_each(|k| of_core::of_operations(&mut digest, 400 * index + k)),
            Self::Problems => (0..60).for_each(|k| of_core::of_problems(&mut digest, 60 * index + k)),
            Self::Enclosures => of_others::of_enclosures(&mut digest, index),
            Self::Estimates => of_others::of_estimates(&mut digest, index),
            Self::Exchanges => of_others::of_exchanges(&mut digest, index),
            Self::Index => {
                digest.numbers(&hidden::recorded(100 + index)?);
                digest.numbers(&hidden::recorded_work(100 + index)?);
            }
            Self::Factors => of_others::of_factors(&mut digest, index)?,
        }
        if digest.said < 4 * digest.refused && !matches!(self, Self::Cases) {
            digest.wrong.push(format!("{} answers of {} numbers are refused", digest.refused, digest.said));
        }
        // The upper bits, which a double holds.
        let statements = vec![Statement::new(&[], (digest.bits >> 12) as f64)];
        Ok(Recorded { statements, wrong: digest.wrong })
    }
}

/// The bits so far, and contradictions.
#[derive(Debug, Default)]
struct Digest {
    bits: u64,
    said: u64,
    refused: u64,
    wrong: Vec<String>,
}

impl Digest {
    fn word(&mut self, word: u64) {
        self.said += 1;
        self.bits = split_mix(self.bits ^ word).wrapping_add(self.bits.rotate_left(23));
    }

    /// No answer, whatever the reason: its text may have rounded digits.
    fn refused(&mut self) {
        self.refused += 1;
        self.word(u64::MAX);
    }

    /// A NaN of any sign and payload is one.
    fn number(&mut self, number: f64) {
        self.word(if number.is_nan() { f64::NAN.to_bits() } else { number.to_bits() });
    }

    fn numbers<'a>(&mut self, numbers: impl IntoIterator<Item = &'a f64>) {
        numbers.into_iter().for_each(|&number| self.number(number));
    }

    fn vector(&mut self, vector: DVec3) {
        self.numbers(&vector.to_array());
    }

    fn text(&mut self, text: impl Display) {
        text.to_string().bytes().for_each(|byte| self.word(byte.into()));
    }

    /// Numbers, or that there are none.
    fn say<E: Display>(&mut self, said: Result<Vec<f64>, E>) {
        match said {
            Ok(numbers) => self.numbers(&numbers),
            Err(_) => self.refused(),
        }
    }
}

/// Answers to one question, which have a point in common by pairs.
struct Question<'a> {
    name: &'a str,
    said: Vec<(String, [f64; 3], f64)>,
}

impl<'a> Question<'a> {
    const fn new(name: &'a str) -> Self {
        Self { name, said: Vec::new() }
    }

    fn add(&mut self, digest: &mut Digest, by: impl Display, value: [f64; 3], bound: f64) {
        digest.numbers(&value);
        digest.number(bound);
        self.said.push((by.to_string(), value, bound));
    }

    fn close(self, digest: &mut Digest) {
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

    #[test]
    fn a_block_says_the_same_twice() {
        for (_, block) in Block::ALL {
            assert_eq!(block.asked(1), block.asked(1), "{}", block.name());
        }
    }
}
