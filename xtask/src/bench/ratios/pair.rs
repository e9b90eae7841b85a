//! One ratio, by pairs of samples.

use std::time::Duration;

use crate::bench::clock::{self, Spread};

/// One ratio.
#[derive(Debug, Clone)]
pub(crate) struct Ratio {
    /// Its key in the result and in `data/speed.toml`.
    pub(crate) name: &'static str,
    /// Median and quartiles over the pairs.
    pub(crate) spread: Spread,
}

/// Pairs of samples, and the shortest sample: many short ones, since a busy machine takes a thread off its core every few
/// milliseconds and the median then sees only samples in which it did not.
const PAIRS: usize = 501;
const SAMPLE: Duration = Duration::from_micros(200);

/// The time of `a` over that of `b`.
pub(crate) fn pair(name: &'static str, a: impl FnMut(), b: impl FnMut()) -> Ratio {
    Ratio { name, spread: clock::ratio(PAIRS, SAMPLE, a, b) }
}

/// The time of `a` over that of `b`, by a fifth of the pairs: each of the two takes milliseconds.
pub(crate) fn pair_of_long(name: &'static str, a: impl FnMut(), b: impl FnMut()) -> Ratio {
    Ratio { name, spread: clock::ratio(PAIRS / 5, SAMPLE, a, b) }
}
