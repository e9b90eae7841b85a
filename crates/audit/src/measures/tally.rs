//! Cases counted and figures distributed, by family: a monoid under [`Tally::merge`], since its parts are.
//!
//! Keys `K` count cases, and `Q` are the figures: outcomes and errors in [`crate::measures::table`], checks and ratios in
//! [`crate::bounds`].

use std::collections::BTreeMap;

use crate::cases::family::{Family, Name};
use crate::measures::distribution::{Bin, Distribution};

/// Counts of outcomes and distributions of figures of one family.
#[derive(Debug, Clone, PartialEq)]
pub struct FamilyTally<K, Q> {
    counts: BTreeMap<K, Bin>,
    figures: BTreeMap<Q, Distribution>,
}

impl<K, Q> Default for FamilyTally<K, Q> {
    fn default() -> Self {
        Self { counts: BTreeMap::new(), figures: BTreeMap::new() }
    }
}

impl<K: Ord + Copy, Q: Ord + Copy> FamilyTally<K, Q> {
    /// From its parts, as read from a file.
    #[must_use]
    pub(crate) const fn from_parts(counts: BTreeMap<K, Bin>, figures: BTreeMap<Q, Distribution>) -> Self {
        Self { counts, figures }
    }

    /// How many cases were counted so, and the first of them.
    #[must_use]
    pub const fn counts(&self) -> &BTreeMap<K, Bin> {
        &self.counts
    }

    /// The number counted so.
    #[must_use]
    pub fn count(&self, kind: K) -> u64 {
        self.counts.get(&kind).map_or(0, |bin| bin.count)
    }

    /// The distributions by figure.
    #[must_use]
    pub const fn figures(&self) -> &BTreeMap<Q, Distribution> {
        &self.figures
    }

    fn merge(&mut self, other: &Self) {
        for (kind, theirs) in &other.counts {
            self.counts.entry(*kind).and_modify(|ours| ours.merge(theirs)).or_insert(*theirs);
        }
        for (figure, theirs) in &other.figures {
            self.figures.entry(*figure).or_default().merge(theirs);
        }
    }
}

/// The tally of a run, of a shard, or of one case.
#[derive(Debug, Clone, PartialEq)]
pub struct Tally<K, Q> {
    families: BTreeMap<Family, FamilyTally<K, Q>>,
}

impl<K, Q> Default for Tally<K, Q> {
    fn default() -> Self {
        Self { families: BTreeMap::new() }
    }
}

impl<K: Ord + Copy, Q: Ord + Copy> Tally<K, Q> {
    /// From its parts, as read from a file.
    #[must_use]
    pub(crate) const fn from_parts(families: BTreeMap<Family, FamilyTally<K, Q>>) -> Self {
        Self { families }
    }

    /// Counts a case.
    pub fn count(&mut self, case: Name, kind: K) {
        let one = Bin::single(case);
        self.families.entry(case.family).or_default().counts.entry(kind).and_modify(|bin| bin.merge(&one)).or_insert(one);
    }

    /// Adds a figure of a case.
    ///
    /// # Panics
    /// If it is negative or not a number, as [`Distribution::single`].
    pub fn add(&mut self, case: Name, figure: Q, value: f64) {
        self.families.entry(case.family).or_default().figures.entry(figure).or_default().add(value, case);
    }

    /// Adds all cases of `other`.
    #[must_use]
    pub fn merge(mut self, other: &Self) -> Self {
        for (family, theirs) in &other.families {
            self.families.entry(*family).or_default().merge(theirs);
        }
        self
    }

    /// By family.
    #[must_use]
    pub const fn families(&self) -> &BTreeMap<Family, FamilyTally<K, Q>> {
        &self.families
    }
}

impl<K: Ord + Copy, Q: Ord + Copy> FromIterator<Self> for Tally<K, Q> {
    fn from_iter<I: IntoIterator<Item = Self>>(tallies: I) -> Self {
        tallies.into_iter().fold(Self::default(), |sum, tally| sum.merge(&tally))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn any_sharding_merges_to_the_same_tally(
            cases in prop::collection::vec((0..3usize, 0..3u8, prop::sample::select(vec![0.0, 1e-17, 2e-17, 0.5, f64::INFINITY])), 0..60),
            shards in 1..6u64,
        ) {
            let tally_of_shard = |shard: u64, shards: u64| {
                let mut tally = Tally::<u8, u8>::default();
                for ((family, kind, value), index) in cases.iter().zip(0..).filter(|(_, index)| index % shards == shard) {
                    let name = Name { family: Family::ALL[*family], seed: 1, index };
                    tally.count(name, *kind);
                    tally.add(name, *kind, *value);
                }
                tally
            };
            prop_assert_eq!(tally_of_shard(0, 1), (0..shards).rev().map(|shard| tally_of_shard(shard, shards)).collect::<Tally<u8, u8>>());
        }
    }
}
