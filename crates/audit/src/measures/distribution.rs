//! The distribution of one figure over many cases: a monoid, so that shards merge to exactly the result of one run.
//!
//! A histogram by leading digits with the first case of each step, and the largest value with its case. Merging adds counts,
//! keeps the smaller name as witness of a bin and the larger value as maximum (the smaller name among equals): associative,
//! commutative, with the empty distribution as unit.

use std::collections::BTreeMap;

use crate::cases::family::Name;
use crate::measures::decade::Decade;
use crate::measures::leading::Leading;

/// Some cases: how many, and the first of them.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Bin {
    /// Their number.
    pub count: u64,
    /// The first of them in the order of names.
    pub first: Name,
}

impl Bin {
    /// One case.
    #[must_use]
    pub const fn single(case: Name) -> Self {
        Self { count: 1, first: case }
    }

    /// Adds the cases of `other`.
    pub fn merge(&mut self, other: &Self) {
        self.count += other.count;
        self.first = self.first.min(other.first);
    }
}

/// The largest value and whose it is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Extreme {
    /// The value.
    pub value: f64,
    /// Its case.
    pub case: Name,
}

/// Counts by leading digits with witnesses, and the maximum.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Distribution {
    bins: BTreeMap<Leading, Bin>,
    worst: Option<Extreme>,
}

impl Distribution {
    /// A distribution of one value.
    ///
    /// # Panics
    /// If the value is negative or not a number, as [`Leading::containing`].
    #[must_use]
    pub fn single(value: f64, case: Name) -> Self {
        Self { bins: BTreeMap::from([(Leading::containing(value), Bin::single(case))]), worst: Some(Extreme { value, case }) }
    }

    /// Adds one value.
    ///
    /// # Panics
    /// As [`Distribution::single`].
    pub fn add(&mut self, value: f64, case: Name) {
        self.merge(&Self::single(value, case));
    }

    /// A distribution from its parts, as read from a file.
    #[must_use]
    pub(crate) const fn from_parts(bins: BTreeMap<Leading, Bin>, worst: Option<Extreme>) -> Self {
        Self { bins, worst }
    }

    /// Adds all cases of `other`.
    pub fn merge(&mut self, other: &Self) {
        for (step, theirs) in &other.bins {
            self.bins.entry(*step).and_modify(|ours| ours.merge(theirs)).or_insert(*theirs);
        }
        self.worst = match (self.worst, other.worst) {
            (Some(ours), Some(theirs)) => {
                let theirs_is_worse = theirs.value.total_cmp(&ours.value).then_with(|| ours.case.cmp(&theirs.case)).is_gt();
                Some(if theirs_is_worse { theirs } else { ours })
            }
            (ours, theirs) => ours.or(theirs),
        };
    }

    /// Number of cases.
    #[must_use]
    pub fn count(&self) -> u64 {
        self.bins.values().map(|bin| bin.count).sum()
    }

    /// The bins by leading digits.
    #[must_use]
    pub const fn bins(&self) -> &BTreeMap<Leading, Bin> {
        &self.bins
    }

    /// Counts between neighbours of 1, 2, 5, 10, ...: `(from, to, count)`, rising. Zeros count from 0 to 0, infinite values from
    /// `inf` to `inf`.
    #[must_use]
    pub(crate) fn thirds(&self) -> Vec<(f64, f64, u64)> {
        let mut thirds: Vec<(f64, f64, u64)> = Vec::new();
        for (step, bin) in &self.bins {
            let (from, to) = step.third();
            match thirds.last_mut() {
                Some(last) if last.0 == from => last.2 += bin.count,
                _ => thirds.push((from, to, bin.count)),
            }
        }
        thirds
    }

    /// The largest value.
    #[must_use]
    pub const fn worst(&self) -> Option<Extreme> {
        self.worst
    }

    /// The worst decade and the first case in it: the same on every machine, where the maximum's case may be another among near
    /// equals.
    #[must_use]
    pub(crate) fn worst_decade(&self) -> Option<(Decade, Name)> {
        let decade = self.bins.last_key_value()?.0.decade();
        let inside = self.bins.iter().rev().take_while(|(step, _)| step.decade() == decade);
        inside.map(|(_, bin)| bin.first).min().map(|first| (decade, first))
    }

    /// The step below the end of which at least `percent` of the cases lie; `None` of no cases.
    #[must_use]
    pub fn percentile(&self, percent: u64) -> Option<Leading> {
        let wanted = self.count() * percent;
        let mut below = 0;
        self.bins.iter().find_map(|(step, bin)| {
            below += bin.count * 100;
            (below >= wanted).then_some(*step)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cases::family::Family;
    use proptest::prelude::*;

    fn name(index: u64) -> Name {
        Name { family: Family::Generic, seed: 1, index }
    }

    fn merged<'a>(parts: impl IntoIterator<Item = &'a Distribution>) -> Distribution {
        parts.into_iter().fold(Distribution::default(), |mut sum, part| {
            sum.merge(part);
            sum
        })
    }

    #[test]
    fn percentiles_are_steps_of_the_counts() {
        let values = [0.0, 1e-16, 2e-16, 3e-16, 1e-3];
        let distribution = merged(&values.iter().zip(0..).map(|(v, i)| Distribution::single(*v, name(i))).collect::<Vec<_>>());
        let percentile = |percent| distribution.percentile(percent).map(|step| step.to_string());
        assert_eq!([20, 50, 80, 99].map(percentile), ["0", "2.0e-16", "3.0e-16", "1.0e-3"].map(|s| Some(s.to_owned())));
        assert_eq!(Distribution::default().percentile(50), None);
        assert_eq!(distribution.worst_decade(), Some((Decade::From(-3), name(4))));
    }

    #[test]
    fn thirds_of_decades_have_all_counts_and_round_ends() {
        let values = [0.0, 1e-16, 1.9e-16, 2e-16, 4.9e-16, 5e-16, 1e-15, f64::INFINITY];
        let distribution = merged(&values.iter().zip(0..).map(|(v, i)| Distribution::single(*v, name(i))).collect::<Vec<_>>());
        let inf = f64::INFINITY;
        let expected = [(0.0, 0.0, 1), (1e-16, 2e-16, 2), (2e-16, 5e-16, 2), (5e-16, 1e-15, 1), (1e-15, 2e-15, 1), (inf, inf, 1)];
        assert_eq!(distribution.thirds(), expected);
    }

    /// Values that collide often, in their decade and altogether.
    fn values() -> impl Strategy<Value = Vec<f64>> {
        prop::collection::vec(prop::sample::select(vec![0.0, 1e-17, 1.5e-17, 2e-17, 1e-15, 3.0, f64::INFINITY]), 0..40)
    }

    proptest! {
        #[test]
        fn shards_in_any_order_merge_to_the_whole(values in values(), assignment in prop::collection::vec(0..5usize, 40)) {
            let parts: Vec<_> = values.iter().zip(0..).map(|(v, i)| Distribution::single(*v, name(i))).collect();
            let shards: Vec<_> = (0..5)
                .map(|s| merged(parts.iter().zip(&assignment).filter(|(_, a)| **a == s).map(|(p, _)| p)))
                .collect();
            prop_assert_eq!(merged(&parts), merged(shards.iter().rev()));
        }

        #[test]
        fn the_maximum_is_in_the_worst_decade(values in values()) {
            let whole = merged(&values.iter().zip(0..).map(|(v, i)| Distribution::single(*v, name(i))).collect::<Vec<_>>());
            prop_assert_eq!(whole.worst().map(|w| Decade::containing(w.value)), whole.worst_decade().map(|(d, _)| d));
            prop_assert_eq!(whole.worst().map(|w| w.value), values.into_iter().reduce(f64::max));
        }
    }
}
