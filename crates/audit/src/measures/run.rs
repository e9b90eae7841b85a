//! Which cases a run is made of, and running them on all cores.

use rayon::prelude::*;

use crate::cases::family::{Family, Name};
use crate::measures::measure::measure;
use crate::measures::table::Table;
use crate::measures::tally::Tally;

/// Part i of n of a run: every n-th case of each family.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub struct Part {
    /// Which part, from 0.
    pub index: u64,
    /// Of how many.
    pub of: u64,
}

impl Part {
    /// All of it.
    pub const WHOLE: Self = Self { index: 0, of: 1 };
}

/// A run: so many cases of some families under a seed, or a part of it.
///
/// ```
/// use radgrad_audit::cases::family::Family;
/// use radgrad_audit::measures::measure::Quantity;
/// use radgrad_audit::measures::run::Run;
/// let table = Run::of_each(5, &[Family::Needle], 1).table(|_| ());
/// let worst = table.families()[&Family::Needle].figures()[&Quantity::Value].worst();
/// assert!(worst.is_some_and(|worst| worst.value < 1e-12), "else `cargo xtask replay` of worst.case");
/// ```
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Run {
    /// Seed of all cases.
    pub seed: u64,
    /// Cases of each family.
    pub cases: Vec<(Family, u64)>,
    /// Which part of it.
    pub part: Part,
}

impl Run {
    /// All of a run with equally many cases of each family, but fewer of the dear ones.
    #[must_use]
    pub fn of_each(cases: u64, families: &[Family], seed: u64) -> Self {
        Self {
            seed,
            cases: families.iter().map(|&family| (family, cases.div_ceil(family.dearness()))).collect(),
            part: Part::WHOLE,
        }
    }

    /// The least such run with so many cases in all.
    #[must_use]
    pub fn at_least(cases: u64, families: &[Family], seed: u64) -> Self {
        let (mut run, mut of_each) = (Self::of_each(0, families, seed), 0);
        while run.count() < cases && !families.is_empty() {
            of_each += (cases - run.count()).div_ceil(families.len() as u64);
            run = Self::of_each(of_each, families, seed);
        }
        run
    }

    /// The part of it that is of these families.
    #[must_use]
    pub fn only(mut self, families: &[Family]) -> Self {
        self.cases.retain(|(family, _)| families.contains(family));
        self
    }

    /// At most the first `most` cases of each family.
    #[must_use]
    pub fn at_most(&self, most: u64) -> Self {
        Self { cases: self.cases.iter().map(|&(family, count)| (family, count.min(most))).collect(), ..*self }
    }

    /// The names of its cases. Families take turns, so that the costly ones spread over the cores.
    pub fn names(&self) -> impl Iterator<Item = Name> + '_ {
        (0..self.max_cases()).flat_map(|index| self.names_at(index))
    }

    /// The largest number of cases of a family.
    fn max_cases(&self) -> u64 {
        self.cases.iter().map(|(_, count)| *count).max().unwrap_or(0)
    }

    /// The names with this index, in the part.
    fn names_at(&self, index: u64) -> impl Iterator<Item = Name> + '_ {
        let of_part = index % self.part.of == self.part.index;
        let still = self.cases.iter().filter(move |(_, count)| of_part && index < *count);
        still.map(move |&(family, _)| Name { family, seed: self.seed, index })
    }

    /// Number of its cases.
    #[must_use]
    pub fn count(&self) -> u64 {
        let Part { index, of } = self.part;
        self.cases.iter().map(|(_, count)| count.saturating_sub(index).div_ceil(of)).sum()
    }

    /// Adds up all cases on all cores; `add` is called from any thread, in any order.
    pub fn tally<K, Q>(&self, add: impl Fn(&mut Tally<K, Q>, Name) + Sync) -> Tally<K, Q>
    where
        K: Ord + Copy + Send,
        Q: Ord + Copy + Send,
    {
        let with = |mut tally: Tally<K, Q>, index| {
            self.names_at(index).for_each(|name| add(&mut tally, name));
            tally
        };
        (0..self.max_cases()).into_par_iter().fold(Tally::default, with).reduce(Tally::default, |sum, tally| sum.merge(&tally))
    }

    /// Measures every case. `done` is called after each, from any thread.
    pub fn table(&self, done: impl Fn(Name) + Sync) -> Table {
        self.tally(|table: &mut Table, name| {
            table.record(name, &measure(&name.case()));
            done(name);
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_share_out_every_case_once() {
        let whole = Run { seed: 1, cases: vec![(Family::Far, 11), (Family::Generic, 4), (Family::NGon, 9)], part: Part::WHOLE };
        let part = |index| Run { part: Part { index, of: 3 }, ..whole.clone() };
        let mut shared: Vec<Name> = (0..3).flat_map(|index| part(index).names().collect::<Vec<_>>()).collect();
        shared.sort_unstable();
        let mut expected: Vec<Name> = whole.names().collect();
        expected.sort_unstable();
        assert_eq!(shared, expected);
        assert_eq!(expected.len(), 24);
        assert_eq!([whole.count(), part(0).count(), part(1).count(), part(2).count()], [24, 9, 8, 7]);
    }

    #[test]
    fn a_run_of_at_least_so_many_cases_has_hardly_more_and_few_of_dear_families() {
        let families = [Family::Generic, Family::Far, Family::HundredVertices];
        for cases in [0, 1, 2, 5, 1000] {
            let run = Run::at_least(cases, &families, 1);
            assert!((cases..cases + 3).contains(&run.count()), "{cases} {}", run.count());
            assert!(run.cases.iter().all(|(family, count)| count * family.dearness() <= run.cases[0].1 + family.dearness()));
        }
        assert_eq!(Run::at_least(7, &[], 1).count(), 0);
    }

    #[test]
    fn parts_merge_to_exactly_the_table_of_the_whole() {
        let whole = Run::of_each(4, &[Family::Generic, Family::BackFacing, Family::EqualVertices], 1);
        let part = |index| Run { part: Part { index, of: 3 }, ..whole.clone() }.table(|_| ());
        assert_eq!((0..3).map(part).collect::<Table>(), whole.table(|_| ()));
    }
}
