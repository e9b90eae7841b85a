//! Error tables: per family the outcomes counted, and per quantity its distribution. A monoid under [`Table::merge`], since its
//! parts are.

use std::collections::BTreeMap;
use std::io;

use crate::decade::Decade;
use crate::distribution::{Bin, Distribution};
use crate::family::{Family, Name};
use crate::measure::{Kind, Outcome, Quantity};

/// What is known of one family.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct FamilyTable {
    outcomes: BTreeMap<Kind, Bin>,
    figures: BTreeMap<Quantity, Distribution>,
}

impl FamilyTable {
    /// From its parts, as read from a file.
    #[must_use]
    pub const fn from_parts(outcomes: BTreeMap<Kind, Bin>, figures: BTreeMap<Quantity, Distribution>) -> Self {
        Self { outcomes, figures }
    }

    /// How many cases ended so, and the first of them.
    #[must_use]
    pub const fn outcomes(&self) -> &BTreeMap<Kind, Bin> {
        &self.outcomes
    }

    /// The distributions by quantity.
    #[must_use]
    pub const fn figures(&self) -> &BTreeMap<Quantity, Distribution> {
        &self.figures
    }

    /// Number of cases.
    #[must_use]
    pub fn cases(&self) -> u64 {
        self.outcomes.values().map(|bin| bin.count).sum()
    }

    fn merge(&mut self, other: &Self) {
        for (kind, theirs) in &other.outcomes {
            self.outcomes.entry(*kind).and_modify(|ours| ours.merge(theirs)).or_insert(*theirs);
        }
        for (quantity, theirs) in &other.figures {
            self.figures.entry(*quantity).or_default().merge(theirs);
        }
    }
}

/// The table of a run, of a shard, or of one case.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Table {
    families: BTreeMap<Family, FamilyTable>,
}

impl Table {
    /// The table of one case.
    #[must_use]
    pub fn of(case: Name, outcome: &Outcome) -> Self {
        let outcomes = BTreeMap::from([(outcome.kind(), Bin { count: 1, first: case })]);
        let figure = |q: Quantity| outcome.figure(q).map(|value| (q, Distribution::of(value, case)));
        let figures = Quantity::ALL.into_iter().filter_map(figure).collect();
        Self { families: BTreeMap::from([(case.family, FamilyTable { outcomes, figures })]) }
    }

    /// From its parts, as read from a file.
    #[must_use]
    pub const fn from_parts(families: BTreeMap<Family, FamilyTable>) -> Self {
        Self { families }
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
    pub const fn families(&self) -> &BTreeMap<Family, FamilyTable> {
        &self.families
    }

    /// Number of cases.
    #[must_use]
    pub fn cases(&self) -> u64 {
        self.families.values().map(FamilyTable::cases).sum()
    }

    /// Writes `family,quantity,count,median,p99,worst,worst_case`: decades, the first case of the worst one. The same on every
    /// machine.
    ///
    /// # Errors
    /// If `writer` fails.
    pub fn write_errors(&self, writer: impl io::Write) -> csv::Result<()> {
        let mut rows = csv::Writer::from_writer(writer);
        rows.write_record(["family", "quantity", "count", "median", "p99", "worst", "worst_case"])?;
        for (family, table) in &self.families {
            for (quantity, distribution) in &table.figures {
                let decade = |d: Option<Decade>| d.map_or_else(String::new, |d| d.to_string());
                let worst = distribution.worst_decade();
                rows.write_record([
                    family.name(),
                    quantity.name(),
                    &distribution.count().to_string(),
                    &decade(distribution.percentile(50)),
                    &decade(distribution.percentile(99)),
                    &decade(worst.map(|(d, _)| d)),
                    &worst.map_or_else(String::new, |(_, name)| name.to_string()),
                ])?;
            }
        }
        Ok(rows.flush()?)
    }

    /// Writes `family,cases` and a column per [`Kind`].
    ///
    /// # Errors
    /// If `writer` fails.
    pub fn write_outcomes(&self, writer: impl io::Write) -> csv::Result<()> {
        let mut rows = csv::Writer::from_writer(writer);
        rows.write_record(["family", "cases"].into_iter().chain(Kind::ALL.map(Kind::name)))?;
        for (family, table) in &self.families {
            let count = |kind: Kind| table.outcomes.get(&kind).map_or(0, |bin| bin.count).to_string();
            let counts = Kind::ALL.map(count);
            let cases = table.cases().to_string();
            rows.write_record([family.name(), &cases].into_iter().chain(counts.iter().map(String::as_str)))?;
        }
        Ok(rows.flush()?)
    }
}

impl FromIterator<Self> for Table {
    fn from_iter<I: IntoIterator<Item = Self>>(tables: I) -> Self {
        tables.into_iter().fold(Self::default(), |sum, table| sum.merge(&table))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn outcome() -> impl Strategy<Value = Outcome> {
        let figures = prop::array::uniform6(prop::sample::select(vec![0.0, 1e-17, 2e-17, 0.5, f64::INFINITY]));
        prop_oneof![
            4 => figures.prop_map(Outcome::Measured),
            1 => Just(Outcome::Refused("why".to_owned())),
            1 => Just(Outcome::NonFinite("NaN".to_owned())),
        ]
    }

    proptest! {
        #[test]
        fn any_sharding_merges_to_the_same_table(outcomes in prop::collection::vec((0..3usize, outcome()), 0..60), shards in 1..6u64) {
            let tables: Vec<Table> = outcomes
                .iter()
                .zip(0..)
                .map(|((family, outcome), index)| Table::of(Name { family: Family::ALL[*family], seed: 1, index }, outcome))
                .collect();
            let whole: Table = tables.iter().cloned().collect();
            let shard = |s: u64| tables.iter().zip(0..).filter(|(_, i)| i % shards == s).map(|(t, _)| t.clone()).collect::<Table>();
            prop_assert_eq!(&whole, &(0..shards).rev().map(shard).collect::<Table>());
            prop_assert_eq!(whole.cases(), outcomes.len() as u64);
        }
    }

    #[test]
    fn the_csv_names_what_happened() {
        let name = |index| Name { family: Family::Contact, seed: 1, index };
        let table: Table = [
            Table::of(name(0), &Outcome::Measured([1e-16, 2e-16, 0.5, 0.5, 0.1, 0.1])),
            Table::of(name(1), &Outcome::Measured([3e-14, f64::INFINITY, 0.5, 0.5, 0.1, 2.0])),
            Table::of(name(2), &Outcome::NonFinite("NaN".to_owned())),
        ]
        .into_iter()
        .collect();
        let (mut errors, mut outcomes) = (Vec::new(), Vec::new());
        table.write_errors(&mut errors).unwrap();
        table.write_outcomes(&mut outcomes).unwrap();
        insta::assert_snapshot!(String::from_utf8([errors, outcomes].concat()).unwrap(), @r"
        family,quantity,count,median,p99,worst,worst_case
        contact,value,2,<1e-15,<1e-13,<1e-13,contact:1:1
        contact,gradient,2,<1e-15,inf,inf,contact:1:1
        contact,value-over-condition,2,<1e0,<1e0,<1e0,contact:1:0
        contact,gradient-over-condition,2,<1e0,<1e0,<1e0,contact:1:0
        contact,value-over-bound,2,<1e0,<1e0,<1e0,contact:1:0
        contact,gradient-over-bound,2,<1e0,<1e1,<1e1,contact:1:1
        family,cases,measured,refused,unanswered,non-finite,undetermined
        contact,3,2,0,0,1,0
        ");
    }
}
