//! Times that a busy machine does not change much: medians of many samples, each far above the clock's noise; ratios of
//! neighbours in time.

use std::time::{Duration, Instant};

/// Median and quartiles.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Spread {
    pub(crate) median: f64,
    pub(crate) quartiles: [f64; 2],
}

impl Spread {
    /// Of some figures, at least one; between the two in the middle where they are even.
    pub(crate) fn quartiles(mut figures: Vec<f64>) -> Self {
        figures.sort_by(f64::total_cmp);
        let last = figures.len() - 1;
        let quartile = |quarters: usize| {
            let (place, rest) = (quarters * last / 4, (quarters * last % 4) as f64 / 4.0);
            figures[place] + rest * (figures[(place + 1).min(last)] - figures[place])
        };
        Self { median: quartile(2), quartiles: [quartile(1), quartile(3)] }
    }

    /// Each figure times `factor`.
    pub(crate) fn scaled(self, factor: f64) -> Self {
        Self { median: self.median * factor, quartiles: self.quartiles.map(|q| q * factor) }
    }
}

impl std::iter::Sum for Spread {
    /// Of times that follow each other: quartiles add at most.
    fn sum<I: Iterator<Item = Self>>(spreads: I) -> Self {
        spreads.fold(Self { median: 0.0, quartiles: [0.0; 2] }, |sum, spread| Self {
            median: sum.median + spread.median,
            quartiles: [sum.quartiles[0] + spread.quartiles[0], sum.quartiles[1] + spread.quartiles[1]],
        })
    }
}

/// Samples of a time.
pub(crate) const SAMPLES: usize = 15;

/// Shortest sample: the clock's reading costs some 30 ns, and a busy machine lets a thread run for a few milliseconds.
const SAMPLE: Duration = Duration::from_micros(100);

/// Seconds that `work` takes once.
pub(crate) fn time(mut work: impl FnMut()) -> Spread {
    let (repeats, first) = repeats(SAMPLE, &mut work);
    let again = std::iter::repeat_with(|| sample(repeats, &mut work));
    // Where one run is a sample the first one counts: long runs are not done in vain.
    Spread::quartiles(if repeats == 1 {
        std::iter::once(first).chain(again).take(SAMPLES).collect()
    } else {
        again.take(SAMPLES).collect()
    })
}

/// `a`'s time over `b`'s: the median over pairs of samples next to each other, a b a b.
pub(crate) fn ratio(pairs: usize, least: Duration, mut a: impl FnMut(), mut b: impl FnMut()) -> Spread {
    let ((repeats_a, _), (repeats_b, _)) = (repeats(least, &mut a), repeats(least, &mut b));
    Spread::quartiles((0..pairs).map(|_| sample(repeats_a, &mut a) / sample(repeats_b, &mut b)).collect())
}

/// How often `work` is repeated so that it takes at least `least`, and its time in the last trial.
fn repeats(least: Duration, work: &mut impl FnMut()) -> (u32, f64) {
    let mut repeats = 1;
    loop {
        let seconds = sample(repeats, work);
        if seconds * f64::from(repeats) >= least.as_secs_f64() || repeats > u32::MAX / 4 {
            return (repeats, seconds);
        }
        repeats *= 2;
    }
}

fn sample(repeats: u32, work: &mut impl FnMut()) -> f64 {
    let start = Instant::now();
    for _ in 0..repeats {
        work();
    }
    start.elapsed().as_secs_f64() / f64::from(repeats)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_median_and_quartiles_do_not_see_one_disturbed_sample() {
        let spread = Spread::quartiles(vec![3.0, 1.0, 2.0, 1e9, 4.0]);
        assert_eq!(spread, Spread { median: 3.0, quartiles: [2.0, 4.0] });
        assert_eq!(Spread::quartiles(vec![1.0, 2.0]).median, 1.5);
        assert_eq!(Spread::quartiles(vec![7.0]), Spread { median: 7.0, quartiles: [7.0; 2] });
        assert_eq!(spread.scaled(2.0).quartiles, [4.0, 8.0]);
    }

    #[test]
    fn twice_the_work_has_twice_the_time() {
        let work =
            |rounds: u32| move || _ = std::hint::black_box((0..rounds).fold(1.0, |x: f64, i| x / (1.0 + x * f64::from(i))));
        let ratio = ratio(15, Duration::from_micros(200), work(2000), work(1000));
        assert!((ratio.median - 2.0).abs() < 0.5, "{ratio:?}");
    }
}
