//! Confidence limits for the mean of independent numbers, by betting against each candidate of the mean.
//!
//! For numbers `x_i` in `[0, 1]` of mean m and stakes `l_i` that depend on earlier numbers alone, the capitals
//! `K+(m) = prod (1 + l_i (x_i - m))` and `K-(m) = prod (1 - l_i (x_i - m))` are martingales that are never negative, so that each exceeds
//! `2 / delta` at any time with probability at most `delta / 2` (J. Ville 1939). The limits are where they do: hedged capital of
//! I. Waudby-Smith and A. Ramdas, "Estimating means of bounded random variables by betting", J. R. Stat. Soc. B 86 (2024), section 4.
//! The number of draws may depend on the draws. Nothing is assumed of their distribution; the lower limit needs no upper end of the range.
//!
//! The stake that is best for `n` numbers of variance `v` is about `sqrt(2 ln(2/delta) / (n v))`; v is that of earlier numbers. It is cut to
//! [`MOST`] of the capital that one number can lose, so that a capital stays positive.

/// The share of the capital that one bet may lose.
const MOST: f64 = 0.75;

/// Factors that are multiplied before a logarithm is taken: each is above `1 - MOST`, and no product overflows for means above 1e-38 of the range.
const GROUP: usize = 8;

/// The part of the width of an interval to which its ends are found.
const FINE: f64 = 1e-3;

/// Bound on the rounding of a sum of logarithms, relative to the threshold.
const ROUNDING: f64 = 1e-9;

/// Numbers with the stakes that were set before each was drawn.
#[derive(Debug, Clone)]
pub(crate) struct Bets {
    bets: Vec<(f64, f64)>,
    sum: f64,
    squares: f64,
    /// Numbers that count as drawn before, with their mean and variance: a pilot's.
    prior: Moments,
    /// `ln(2 / delta)`.
    threshold: f64,
}

/// Count, mean and variance of numbers.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Moments {
    pub(crate) count: f64,
    pub(crate) mean: f64,
    pub(crate) variance: f64,
}

impl Moments {
    pub(crate) fn new(values: impl ExactSizeIterator<Item = f64> + Clone) -> Self {
        let count = values.len() as f64;
        let mean = values.clone().sum::<f64>() / count;
        let variance = values.map(|x| (x - mean) * (x - mean)).sum::<f64>() / count;
        Self { count, mean, variance }
    }
}

impl Bets {
    /// No bets yet. `delta` is the probability that the limits fail.
    pub(crate) fn new(delta: f64, prior: Moments) -> Self {
        Self { bets: Vec::new(), sum: 0.0, squares: 0.0, prior, threshold: (2.0 / delta).ln() * (1.0 + ROUNDING) }
    }

    /// Takes numbers, with stakes for `planned` of them in all.
    pub(crate) fn extend(&mut self, values: impl Iterator<Item = f64>, planned: f64) {
        for x in values {
            let stake = (2.0 * self.threshold / (planned * self.variance())).sqrt();
            self.bets.push((x, stake));
            let deviation = x - self.prior.mean;
            self.sum += deviation;
            self.squares += deviation * deviation;
        }
    }

    /// The mean of the numbers.
    pub(crate) fn mean(&self) -> f64 {
        self.prior.mean + self.sum / self.bets.len() as f64
    }

    /// The variance of the numbers so far and of the prior's, never 0.
    pub(crate) fn variance(&self) -> f64 {
        let count = self.prior.count + self.bets.len() as f64;
        let mean = self.sum / count;
        let variance = (self.prior.count * self.prior.variance + self.squares) / count - mean * mean;
        // One number in so many may be at the far end of the range without having been seen.
        variance.max(0.0) + 0.25 / (count * count)
    }

    /// The lower limit of the mean.
    pub(crate) fn lower(&self) -> f64 {
        if self.bets.is_empty() { 0.0 } else { boundary(0.0, self.mean(), |m| self.capital(m, 1.0) >= self.threshold) }
    }

    /// The upper limit of the mean: 1 if nothing below is excluded.
    pub(crate) fn upper(&self) -> f64 {
        if self.bets.is_empty() { 1.0 } else { boundary(1.0, self.mean().min(1.0), |m| self.capital(m, -1.0) >= self.threshold) }
    }

    /// The logarithm of the capital of who bets that the mean is above m (`sign` 1), or below (-1).
    fn capital(&self, m: f64, sign: f64) -> f64 {
        let stake_limit = MOST / if sign > 0.0 { m } else { 1.0 - m };
        let factor = |&(x, stake): &(f64, f64)| 1.0 + sign * stake.min(stake_limit) * (x - m);
        self.bets.chunks(GROUP).map(|group| group.iter().map(factor).product::<f64>().ln()).sum()
    }
}

/// The last place between an end of the range, which is excluded or as good as that, and the mean that is seen to be excluded.
fn boundary(end: f64, mean: f64, is_excluded: impl Fn(f64) -> bool) -> f64 {
    let (mut excluded, mut open) = (end, mean);
    while (open - excluded).abs() > FINE * (mean - excluded).abs() {
        let middle = 0.5 * (excluded + open);
        if middle == excluded || middle == open {
            break;
        }
        *(if is_excluded(middle) { &mut excluded } else { &mut open }) = middle;
    }
    excluded
}

/// Draws that limits of this half-width need, for numbers of these moments.
pub(crate) fn draws(half_width: f64, variance: f64, delta: f64) -> f64 {
    let threshold = (2.0 / delta).ln();
    // Half the width is about `sqrt(2 t v / n) + t / (2 c n)`.
    let (root, range) = ((2.0 * threshold * variance).sqrt(), threshold / (2.0 * MOST));
    let inverse = (root + (root * root + 4.0 * half_width * range).sqrt()) / (2.0 * half_width);
    inverse * inverse
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::rngs::ChaCha8Rng;
    use rand::{RngExt, SeedableRng};

    fn limits(values: &[f64], delta: f64) -> [f64; 2] {
        let (pilot, others) = values.split_at(100);
        let mut bets = Bets::new(delta, Moments::new(pilot.iter().copied()));
        bets.extend(others.iter().copied(), others.len() as f64);
        [bets.lower(), bets.upper()]
    }

    #[test]
    fn limits_fail_no_more_often_than_they_say() {
        // Rare and large, common and small, two values: of 4,000 intervals at 2 % each 80 may fail.
        let laws: [(&dyn Fn(f64) -> f64, f64); 3] =
            [(&|u| if u < 0.01 { 1.0 } else { 0.0 }, 0.01), (&|u| 0.4 + 0.2 * u, 0.5), (&|u| u * u * u, 0.25)];
        for (which, (law, mean)) in laws.into_iter().enumerate() {
            let mut generator = ChaCha8Rng::seed_from_u64(which as u64);
            let mut misses = [0; 2];
            for _ in 0..4_000 {
                let values: Vec<f64> = (0..500).map(|_| law(generator.random())).collect();
                let [low, high] = limits(&values, 0.02);
                assert!(low < high);
                misses[0] += usize::from(low > mean);
                misses[1] += usize::from(high < mean);
            }
            assert!(misses.iter().sum::<usize>() <= 80, "law {which}: {misses:?}");
        }
    }

    #[test]
    fn a_stake_is_set_before_its_number_is_drawn() {
        let stakes = |last: f64| {
            let mut bets = Bets::new(0.02, Moments { count: 4.0, mean: 0.5, variance: 0.01 });
            bets.extend([0.4, 0.6, last].into_iter(), 100.0);
            bets.bets.into_iter().map(|(_, stake)| stake).collect::<Vec<_>>()
        };
        assert_eq!(stakes(0.0), stakes(1.0));
        assert!(stakes(0.5)[1] > stakes(0.5)[0]);
    }

    #[test]
    fn limits_narrow_as_the_root_of_the_draws() {
        let mut generator = ChaCha8Rng::seed_from_u64(7);
        let values: Vec<f64> = (0..100_100).map(|_| generator.random()).collect();
        let [low, high] = limits(&values, 1e-6);
        // 5.4 standard errors is the least that any limits of this confidence can have, about.
        let half = 0.5 * (high - low) / (1.0 / 12.0_f64 / 100_000.0).sqrt();
        assert!(low < 0.5 && 0.5 < high && (4.9..6.0).contains(&half), "{half}");
    }

    #[test]
    fn no_event_leaves_what_so_many_draws_exclude() {
        let [low, high] = limits(&[0.0; 10_100], 1e-6);
        assert!(low == 0.0 && (1.4e-3..3e-3).contains(&high), "{low} {high}");
        let [low, high] = limits(&[1.0; 10_100], 1e-6);
        assert!(high == 1.0 && (1.4e-3..3e-3).contains(&(1.0 - low)), "{low} {high}");
    }

    #[test]
    fn numbers_above_the_range_keep_the_lower_limit() {
        let mut generator = ChaCha8Rng::seed_from_u64(8);
        // Mean 2, and no upper end.
        let values: Vec<f64> = (0..20_000).map(|_| -2.0 * generator.random::<f64>().ln()).collect();
        let [low, high] = limits(&values, 1e-6);
        assert!((1.8..2.0).contains(&low) && high == 1.0);
    }
}
