//! Error tables: per family the outcomes counted, and per quantity its distribution.

use std::io;

use crate::cases::family::Name;
use crate::measures::decade::Decade;
use crate::measures::leading::Leading;
use crate::measures::measure::{Kind, Outcome, Quantity};
use crate::measures::tally::{FamilyTally, Tally};

/// Counts and distributions of one family.
pub type FamilyTable = FamilyTally<Kind, Quantity>;

/// The table of a run, of a shard, or of one case.
pub type Table = Tally<Kind, Quantity>;

impl FamilyTable {
    /// Number of cases: each ends in one way.
    #[must_use]
    pub fn cases(&self) -> u64 {
        self.counts().values().map(|bin| bin.count).sum()
    }
}

impl Table {
    /// The table of one case.
    #[must_use]
    pub fn single(case: Name, outcome: &Outcome) -> Self {
        let mut table = Self::default();
        table.record(case, outcome);
        table
    }

    /// Adds a case.
    pub fn record(&mut self, case: Name, outcome: &Outcome) {
        self.count(case, outcome.kind());
        for quantity in Quantity::ALL {
            if let Some(figure) = outcome.figure(quantity) {
                self.add(case, quantity, figure);
            }
        }
    }

    /// Number of cases.
    #[must_use]
    pub fn cases(&self) -> u64 {
        self.families().values().map(FamilyTable::cases).sum()
    }

    /// Writes `family,quantity,count,median,p99,worst,worst_case`: decades, the first case of the worst one. The same on every
    /// machine.
    ///
    /// # Errors
    /// If `writer` fails.
    pub fn write_errors(&self, writer: impl io::Write) -> csv::Result<()> {
        let mut rows = csv::Writer::from_writer(writer);
        rows.write_record(["family", "quantity", "count", "median", "p99", "worst", "worst_case"])?;
        for (family, table) in self.families() {
            for (quantity, distribution) in table.figures() {
                let decade = |d: Option<Decade>| d.map_or_else(String::new, |d| d.to_string());
                let worst = distribution.worst_decade();
                rows.write_record([
                    family.name(),
                    quantity.name(),
                    &distribution.count().to_string(),
                    &decade(distribution.percentile(50).map(Leading::decade)),
                    &decade(distribution.percentile(99).map(Leading::decade)),
                    &decade(worst.map(|(d, _)| d)),
                    &worst.map_or_else(String::new, |(_, name)| name.to_string()),
                ])?;
            }
        }
        Ok(rows.flush()?)
    }

    /// Writes `family,quantity,from,to,count`: how many figures lie between neighbours of 1, 2, 5, 10, ...; zeros from 0 to 0.
    ///
    /// # Errors
    /// If `writer` fails.
    pub fn write_histogram(&self, writer: impl io::Write) -> csv::Result<()> {
        let mut rows = csv::Writer::from_writer(writer);
        rows.write_record(["family", "quantity", "from", "to", "count"])?;
        for (family, table) in self.families() {
            for (quantity, distribution) in table.figures() {
                for (from, to, count) in distribution.thirds() {
                    let [from, to] = [from, to].map(|end| format!("{end:e}"));
                    rows.write_record([family.name(), quantity.name(), &from, &to, &count.to_string()])?;
                }
            }
        }
        Ok(rows.flush()?)
    }

    /// Writes `family,quantity,count,median,p99,worst,worst_case` to two digits, which another machine may round otherwise.
    ///
    /// # Errors
    /// If `writer` fails.
    pub fn write_figures(&self, writer: impl io::Write) -> csv::Result<()> {
        write_figures(self, |quantity| quantity.name().to_owned(), writer)
    }

    /// Writes `family,cases` and a column per [`Kind`].
    ///
    /// # Errors
    /// If `writer` fails.
    pub fn write_outcomes(&self, writer: impl io::Write) -> csv::Result<()> {
        let mut rows = csv::Writer::from_writer(writer);
        rows.write_record(["family", "cases"].into_iter().chain(Kind::ALL.map(Kind::name)))?;
        for (family, table) in self.families() {
            let counts = Kind::ALL.map(|kind| table.count(kind).to_string());
            let cases = table.cases().to_string();
            rows.write_record([family.name(), &cases].into_iter().chain(counts.iter().map(String::as_str)))?;
        }
        Ok(rows.flush()?)
    }
}

/// Writes `family,quantity,count,median,p99,worst,worst_case` of any tally, numbers to two digits.
pub(crate) fn write_figures<K, Q>(tally: &Tally<K, Q>, name: impl Fn(Q) -> String, writer: impl io::Write) -> csv::Result<()>
where
    K: Ord + Copy,
    Q: Ord + Copy,
{
    let mut rows = csv::Writer::from_writer(writer);
    rows.write_record(["family", "quantity", "count", "median", "p99", "worst", "worst_case"])?;
    for (family, table) in tally.families() {
        for (quantity, distribution) in table.figures() {
            let Some(worst) = distribution.worst() else { continue };
            let percentile = |percent| distribution.percentile(percent).map_or_else(String::new, |step| step.to_string());
            rows.write_record([
                family.name(),
                &name(*quantity),
                &distribution.count().to_string(),
                &percentile(50),
                &percentile(99),
                &two_digits(worst.value),
                &worst.case.to_string(),
            ])?;
        }
    }
    Ok(rows.flush()?)
}

/// A figure to two digits, rounded; 0 as it is.
pub(crate) fn two_digits(x: f64) -> String {
    if x == 0.0 { "0".to_owned() } else { format!("{x:.1e}") }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cases::family::Family;

    #[test]
    fn the_csv_names_what_happened() {
        let name = |index| Name { family: Family::Contact, seed: 1, index };
        let table: Table = [
            Table::single(name(0), &Outcome::Measured([1e-16, 2e-16, 0.5, 0.5, 0.1, 0.1])),
            Table::single(name(1), &Outcome::Measured([3e-14, f64::INFINITY, 0.5, 0.5, 0.1, 2.0])),
            Table::single(name(2), &Outcome::NonFinite("NaN".to_owned())),
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
