//! Which cases a run is made of, and running them on all cores.

use rayon::prelude::*;

use crate::family::{Family, Name};
use crate::measure::measure;
use crate::table::Table;

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

/// A run: these many cases of these families under this seed, or a part of it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Run {
    /// Seed of all cases.
    pub seed: u64,
    /// Cases of each family.
    pub cases: u64,
    /// The families.
    pub families: Vec<Family>,
    /// Which part of it.
    pub part: Part,
}

impl Run {
    /// The names of its cases. Families take turns, so that the costly ones spread over the cores.
    pub fn names(&self) -> impl Iterator<Item = Name> + '_ {
        (0..self.cases)
            .filter(|index| index % self.part.of == self.part.index)
            .flat_map(move |index| self.families.iter().map(move |&family| Name { family, seed: self.seed, index }))
    }

    /// Measures every case. `done` is called after each, from any thread.
    pub fn table(&self, done: impl Fn(Name) + Sync) -> Table {
        let names: Vec<Name> = self.names().collect();
        names
            .par_iter()
            .map(|&name| {
                let table = Table::of(name, &measure(&name.case()));
                done(name);
                table
            })
            .reduce(Table::default, |sum, table| sum.merge(&table))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_share_out_every_case_once() {
        let whole = Run { seed: 1, cases: 11, families: Family::ALL.to_vec(), part: Part::WHOLE };
        let part = |index| Run { part: Part { index, of: 3 }, ..whole.clone() };
        let mut shared: Vec<Name> = (0..3).flat_map(|index| part(index).names().collect::<Vec<_>>()).collect();
        shared.sort_unstable();
        let mut all: Vec<Name> = whole.names().collect();
        all.sort_unstable();
        assert_eq!(shared, all);
        assert_eq!(all.len(), 11 * Family::ALL.len());
    }

    #[test]
    fn parts_merge_to_exactly_the_table_of_the_whole() {
        let families = vec![Family::Generic, Family::BackFacing, Family::EqualVertices];
        let whole = Run { seed: 1, cases: 4, families, part: Part::WHOLE };
        let part = |index| Run { part: Part { index, of: 3 }, ..whole.clone() }.table(|_| ());
        assert_eq!((0..3).map(part).collect::<Table>(), whole.table(|_| ()));
    }
}
