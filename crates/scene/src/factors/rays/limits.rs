//! Limits for the mean probability of independent trials, each with a probability of its own.
//!
//! Of n trials with the mean probability p, at least a share q > p succeeds with a probability of at most `exp(-n KL(q, p))`, with
//! `KL(q, p) = q ln(q/p) + (1 - q) ln((1 - q)/(1 - p))`, and likewise at most a share q < p (W. Hoeffding 1963, Theorem 1; H. Chernoff 1952 for
//! equal probabilities). So where k succeeded the p with `n KL(k/n, p) <= ln(2/delta)` are an interval that fails with a
//! probability of at most delta; `KL(q, p) >= 2 (q - p)^2` says before any trial how wide it is at most.

use std::sync::OnceLock;

use crate::extremes::{largest as larger, smallest as smaller};

/// Steps of the search for a limit: each halves the range.
const STEPS: u32 = 60;

/// Success of k trials out of so many, for intervals that each fail with this probability: limits are kept for the small k, of which there are many.
#[derive(Debug, Clone)]
pub(super) struct Limits {
    trials: f64,
    /// `ln(2/delta) / n`.
    most: f64,
    known: Vec<OnceLock<[f64; 2]>>,
}

impl Limits {
    /// `logarithm` is `ln(2/delta)`.
    pub(super) fn new(trials: f64, logarithm: f64) -> Self {
        const KEPT: u32 = 1 << 12;
        let cache = (0..KEPT).map(|_| OnceLock::new()).collect();
        Self { trials, most: logarithm / trials, known: cache }
    }

    /// Limits of the mean probability.
    pub(super) fn of(&self, successes: u32) -> [f64; 2] {
        let compute = || self.compute(f64::from(successes));
        self.known.get(successes as usize).map_or_else(compute, |known| *known.get_or_init(compute))
    }

    fn compute(&self, successes: f64) -> [f64; 2] {
        let q = smaller(successes / self.trials, 1.0);
        let search = |end: f64| {
            if divergence(q, end) <= self.most {
                return end;
            }
            // The limit is between the two.
            let (mut inside, mut outside) = (q, end);
            for _ in 0..STEPS {
                let middle = 0.5 * (inside + outside);
                *if divergence(q, middle) <= self.most { &mut inside } else { &mut outside } = middle;
            }
            outside
        };
        [search(0.0), search(1.0)]
    }
}

/// `KL(q, p)`.
fn divergence(q: f64, p: f64) -> f64 {
    let part = |q: f64, p: f64| if q == 0.0 { 0.0 } else { q * libm::log(q / p) };
    part(q, p) + part(1.0 - q, 1.0 - p)
}

/// By how much a sum of independent numbers from 0 to 1 may be off its mean, likewise: of a sum s the means m with
/// `m - s + s ln(s/m) <= logarithm` (the same for very many trials of little probability). At least 0.
pub(super) fn sum_limits(sum: f64, logarithm: f64) -> [f64; 2] {
    let cost = |mean: f64| mean - sum + if sum > 0.0 { sum * libm::log(sum / mean) } else { 0.0 };
    let search = |end: f64| {
        let (mut inside, mut outside) = (sum, end);
        for _ in 0..STEPS {
            let middle = 0.5 * (inside + outside);
            *if cost(middle) <= logarithm { &mut inside } else { &mut outside } = middle;
        }
        outside
    };
    // `m - s - s ln(m/s) >= (m - s)^2 / 2m` for `m >= s`: beyond this it is more than the logarithm.
    [search(0.0), search(sum + 2.0 * logarithm + 2.0 * (logarithm * sum).sqrt())]
}

/// How far sums of independent numbers may be off, each up to a share of a ray.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Chances {
    /// Rays from each face.
    pub(super) rays: u64,
    /// `ln(2/delta)` of each sum.
    pub(super) logarithm: f64,
}

impl Chances {
    /// Bounds the deviation of a sum over the rays of numbers up to `most`, not below 0, or of a sum that is at most so large, by Chernoff's limits.
    pub(super) fn deviation(self, sum: f64, most: f64) -> f64 {
        let one = most / self.rays as f64;
        let counted = sum / one;
        let [low, high] = sum_limits(counted, self.logarithm);
        one * larger(high - counted, counted - low)
    }
}

/// Trials by which each interval is at most so wide to either side.
pub(super) fn trials_for(error: f64, logarithm: f64) -> f64 {
    (logarithm / (2.0 * error * error)).ceil()
}

#[cfg(test)]
mod tests {
    use statrs::distribution::{Binomial, DiscreteCDF, Poisson};

    use super::*;

    #[test]
    fn limits_fail_no_more_often_than_stated_and_are_no_wider_than_hoeffding_s() {
        let (n, delta) = (200_u64, 1e-3);
        let logarithm = libm::log(2.0 / delta);
        let limits = Limits::new(n as f64, logarithm);
        let half_width = (logarithm / (2.0 * n as f64)).sqrt();
        assert!((trials_for(half_width, logarithm) - n as f64).abs() <= 1.0);
        for p in [0.001, 0.02, 0.3, 0.5, 0.97] {
            let trials = Binomial::new(p, n).unwrap();
            let misses = |k: &u64| {
                let [low, high] = limits.of(u32::try_from(*k).unwrap());
                p < low || p > high
            };
            let chance: f64 = (0..=n).filter(misses).map(|k| statrs::distribution::Discrete::pmf(&trials, k)).sum();
            assert!(chance <= delta, "{p}: {chance}");
        }
        for k in 0..=200 {
            let ([low, high], q) = (limits.of(k), f64::from(k) / n as f64);
            assert!(low <= q && q <= high && q - low <= half_width + 1e-12 && high - q <= half_width + 1e-12, "{k}");
        }
        // 0 of n: `(1 - p)^n = delta/2`.
        let highest = 1.0 - libm::pow(delta / 2.0, 1.0 / n as f64);
        assert!((limits.of(0)[1] - highest).abs() < 1e-12);
    }

    #[test]
    fn limits_of_a_sum_cover_counts() {
        let delta = 1e-3;
        for mean in [0.1, 3.0, 50.0, 2000.0] {
            let counts = Poisson::new(mean).unwrap();
            let [low, high] = sum_limits(mean, libm::log(2.0 / delta));
            assert!(low <= mean && mean <= high);
            let misses = |k: &u64| {
                let [low, high] = sum_limits(*k as f64, libm::log(2.0 / delta));
                mean < low || mean > high
            };
            let chance: f64 = (0..5000).filter(misses).map(|k| statrs::distribution::Discrete::pmf(&counts, k)).sum();
            assert!(chance <= delta, "{mean}: {chance}");
            assert!(counts.cdf(4999) > 0.999);
        }
    }
}
