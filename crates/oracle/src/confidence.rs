//! Confidence limits for the mean of independent samples.
//!
//! Student's limits assume a mean close to normal: right asymptotically, blind to a peak that no sample hit. The
//! distribution-free ones assume nothing but the range: for independent samples in `[low, high]`, with probability `1 - delta`,
//! both
//! - Hoeffding 1963: `|mean - mu| <= range sqrt(ln(4/delta) / (2 n))`
//! - Maurer and Pontil 2009, Theorem 4: `|mean - mu| <= sqrt(2 V ln(8/delta) / n) + 7 range ln(8/delta) / (3 (n - 1))`
//!
//! each given half of `delta`, two sides each; the narrower is reported, cut to the range itself.

use statrs::distribution::{ContinuousCDF, StudentsT};

use crate::Error;

/// A closed interval that contains a number with a stated confidence.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ConfidenceInterval {
    /// Lower end.
    pub low: f64,
    /// Upper end.
    pub high: f64,
}

impl ConfidenceInterval {
    /// Whether `value` is in it.
    #[must_use]
    pub fn contains(&self, value: f64) -> bool {
        self.low <= value && value <= self.high
    }

    /// Its length.
    #[must_use]
    pub fn width(&self) -> f64 {
        self.high - self.low
    }

    pub(crate) fn scaled(self, factor: f64) -> Self {
        Self { low: self.low * factor, high: self.high * factor }
    }

    pub(crate) fn widened(self, by: f64) -> Self {
        Self { low: self.low - by, high: self.high + by }
    }

    /// Cut to `range`.
    pub(crate) fn within(self, range: Self) -> Self {
        Self { low: self.low.max(range.low), high: self.high.min(range.high) }
    }

    fn around(middle: f64, half_width: f64) -> Self {
        Self { low: middle - half_width, high: middle + half_width }
    }
}

/// Count, mean and variance of a stream (Welford 1962).
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Moments {
    count: usize,
    mean: f64,
    squares: f64,
}

impl Moments {
    pub(crate) fn add(&mut self, value: f64) {
        self.count += 1;
        let deviation = value - self.mean;
        self.mean += deviation / self.count as f64;
        self.squares += deviation * (value - self.mean);
    }

    pub(crate) const fn mean(&self) -> f64 {
        self.mean
    }

    /// Unbiased; needs two samples.
    fn variance(&self) -> f64 {
        self.squares / (self.count as f64 - 1.0)
    }

    /// Limits of Student's distribution with `count - 1` degrees of freedom.
    pub(crate) fn student(&self, confidence: f64) -> Result<ConfidenceInterval, Error> {
        let freedom = self.count as f64 - 1.0;
        let distribution = StudentsT::new(0.0, 1.0, freedom).map_err(|_| Error::TooFewSamples {
            what: "samples",
            value: self.count,
            least: 2,
        })?;
        let quantile = distribution.inverse_cdf(0.5 + 0.5 * confidence);
        Ok(ConfidenceInterval::around(self.mean, quantile * (self.variance() / self.count as f64).sqrt()))
    }

    /// Limits for any distribution on `range`.
    pub(crate) fn distribution_free(&self, confidence: f64, range: ConfidenceInterval) -> ConfidenceInterval {
        let (count, delta) = (self.count as f64, 1.0 - confidence);
        let hoeffding = range.width() * (libm::log(4.0 / delta) / (2.0 * count)).sqrt();
        let log = libm::log(8.0 / delta);
        let bernstein = (2.0 * self.variance() * log / count).sqrt() + 7.0 * range.width() * log / (3.0 * (count - 1.0));
        ConfidenceInterval::around(self.mean, hoeffding.min(bernstein)).within(range)
    }
}

/// Limits for a probability of which `successes` of `trials` are seen: those p for which `trials KL(successes/trials, p) <=
/// ln(2/delta)` with `KL(q, p) = q ln(q/p) + (1 - q) ln((1 - q)/(1 - p))` (H. Chernoff 1952), each side with half of `delta`.
pub(crate) fn of_successes(successes: u32, trials: u32, confidence: f64) -> ConfidenceInterval {
    let (count, fraction) = (f64::from(trials), f64::from(successes) / f64::from(trials));
    let limit = libm::log(2.0 / (1.0 - confidence)) / count;
    let part = |q: f64, p: f64| if q == 0.0 { 0.0 } else { q * libm::log(q / p) };
    let beyond = |p: f64| part(fraction, p) + part(1.0 - fraction, 1.0 - p) > limit;
    // `beyond` at the outer end, not at the inner one: the outer end is returned.
    let limit = |outer: f64| {
        let (mut outer, mut inner) = (outer, fraction);
        for _ in 0..60 {
            let middle = 0.5 * (outer + inner);
            if beyond(middle) { outer = middle } else { inner = middle }
        }
        outer
    };
    let low = if successes == 0 { 0.0 } else { limit(0.0) };
    let high = if successes == trials { 1.0 } else { limit(1.0) };
    ConfidenceInterval { low, high }
}

/// Refuses a confidence that is not a probability.
pub(crate) fn check_confidence(confidence: f64) -> Result<(), Error> {
    if confidence > 0.0 && confidence < 1.0 { Ok(()) } else { Err(Error::Confidence { value: confidence }) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn student_limits_match_the_table() {
        let mut moments = Moments::default();
        (0..16).for_each(|i| moments.add(f64::from(i % 2)));
        // t(15 degrees of freedom, 0.995) = 2.9467; standard error sqrt(4/15/16).
        let limits = moments.student(0.99).unwrap();
        assert!((limits.high - 0.5 - 2.946_712_883 * (4.0_f64 / 15.0 / 16.0).sqrt()).abs() < 1e-8, "{limits:?}");
        assert!((limits.low + limits.high - 1.0).abs() < 1e-15);
    }

    #[test]
    fn constant_samples_are_not_certain() {
        let mut moments = Moments::default();
        (0..1000).for_each(|_| moments.add(0.0));
        let limits = moments.distribution_free(0.99, ConfidenceInterval { low: 0.0, high: 5.0 });
        assert!(limits.low == 0.0 && limits.high > 0.05 && limits.high < 0.1, "{limits:?}");
    }

    #[test]
    fn limits_of_a_probability_hold_its_frequency_and_are_those_of_the_ends() {
        let limits = of_successes(0, 1000, 0.99);
        // (1 - p)^1000 = 0.005.
        assert!(limits.low == 0.0 && (limits.high - (1.0 - 0.005_f64.powf(1e-3))).abs() < 1e-12, "{limits:?}");
        let half = of_successes(500, 1000, 0.99);
        assert!((half.low + half.high - 1.0).abs() < 1e-12 && half.width() < 0.11 && half.width() > 0.08, "{half:?}");
        assert_eq!(of_successes(7, 7, 0.9).high, 1.0);
    }

    #[test]
    fn one_sample_has_no_limits() {
        let mut moments = Moments::default();
        moments.add(1.0);
        assert_eq!(moments.student(0.9), Err(Error::TooFewSamples { what: "samples", value: 1, least: 2 }));
    }
}
