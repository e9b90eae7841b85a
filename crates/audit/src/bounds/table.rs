//! The bounds table: per family the counts, how tight the bounds are, and the rungs that answered.

use std::io;

use crate::bounds::check::Check;
use crate::bounds::mark::{Figure, Mark, Rung};
use crate::cases::family::Name;
use crate::measures::decade::Decade;
use crate::measures::distribution::Distribution;
use crate::measures::table::write_figures;
use crate::measures::tally::{FamilyTally, Tally};

/// Counts and distributions of one family.
pub type FamilyTable = FamilyTally<Mark, Figure>;

/// The table of a campaign, of a shard, or of one case.
pub type Table = Tally<Mark, Figure>;

/// Counts in the recorded table.
const COUNTS: [Mark; 15] = [
    Mark::Case,
    Mark::Refused,
    Mark::Unanswered,
    Mark::NonFinite,
    Mark::Zero,
    Mark::Nonzero,
    Mark::Broken,
    Mark::MissesDefault,
    Mark::MissesTight,
    Mark::By(Rung::Quadrature),
    Mark::By(Rung::ClosedForm),
    Mark::By(Rung::DoubleDouble),
    Mark::By(Rung::ArbitraryPrecision),
    Mark::Answer,
    Mark::Blunt,
];

impl FamilyTable {
    /// The largest of a figure.
    #[must_use]
    pub fn largest(&self, figure: Figure) -> Option<f64> {
        Some(self.figures().get(&figure)?.worst()?.value)
    }

    /// Its median, to two digits: the least that it can be.
    #[must_use]
    pub fn median(&self, figure: Figure) -> Option<f64> {
        Some(self.figures().get(&figure)?.percentile(50)?.least())
    }

    /// Of the answers to 1e-12 that are not 0, the share that these rungs gave.
    #[must_use]
    pub fn share_of(&self, rungs: &[Rung]) -> f64 {
        let by: u64 = rungs.iter().map(|&rung| self.count(Mark::By(rung))).sum();
        by as f64 / self.count(Mark::Nonzero) as f64
    }
}

impl Table {
    /// Adds a case.
    pub fn record(&mut self, case: Name, check: &Check) {
        for &mark in &check.marks {
            self.count(case, mark);
        }
        for &(figure, value) in &check.figures {
            self.add(case, figure, value);
        }
    }

    /// How many, over all families.
    #[must_use]
    pub fn total(&self, mark: Mark) -> u64 {
        self.families().values().map(|table| table.count(mark)).sum()
    }

    /// Writes counts, and decades of the ratios of error to bound: they are the same on every machine, so a record can be
    /// compared byte by byte.
    ///
    /// # Errors
    /// If `writer` fails.
    pub fn write_bounds(&self, writer: impl io::Write) -> csv::Result<()> {
        let ratios = ["value-over-bound", "gradient-over-bound", "value-tightness", "gradient-tightness"];
        let mut rows = csv::Writer::from_writer(writer);
        let counted = COUNTS.map(|mark| mark.to_string());
        rows.write_record(["family"].into_iter().chain(counted.iter().map(String::as_str)).chain(ratios))?;
        for (family, table) in self.families() {
            let cell = |figure: Figure, decade: fn(&Distribution) -> Option<Decade>| {
                table.figures().get(&figure).and_then(decade).map_or_else(String::new, |d| d.to_string())
            };
            let worst = |d: &Distribution| d.worst_decade().map(|(decade, _)| decade);
            let median = |d: &Distribution| d.percentile(50).map(|step| step.decade());
            let counts = COUNTS.map(|mark| table.count(mark).to_string());
            let ratios = [
                cell(Figure::ValueOverBound, worst),
                cell(Figure::GradientOverBound, worst),
                cell(Figure::ValueTightness, median),
                cell(Figure::GradientTightness, median),
            ];
            rows.write_record([family.name()].into_iter().chain(counts.iter().chain(&ratios).map(String::as_str)))?;
        }
        Ok(rows.flush()?)
    }

    /// Writes `family,quantity,count,median,p99,worst,worst_case` of errors, and of errors over bounds, to two digits, which
    /// another machine may round otherwise; times are in nanoseconds.
    ///
    /// # Errors
    /// If `writer` fails.
    pub fn write_figures(&self, writer: impl io::Write) -> csv::Result<()> {
        write_figures(self, |figure| figure.to_string(), writer)
    }

    /// Writes `family,rung,answers,median_ns,p99_ns`, apart from the other tables because every machine has other times.
    ///
    /// # Errors
    /// If `writer` fails.
    pub fn write_times(&self, writer: impl io::Write) -> csv::Result<()> {
        let mut rows = csv::Writer::from_writer(writer);
        rows.write_record(["family", "rung", "answers", "median_ns", "p99_ns"])?;
        for (family, table) in self.families() {
            for rung in Rung::ALL {
                let Some(times) = table.figures().get(&Figure::Time(rung)) else { continue };
                let percentile = |percent| times.percentile(percent).map_or_else(String::new, |step| step.least().to_string());
                rows.write_record([family.name(), rung.name(), &times.count().to_string(), &percentile(50), &percentile(99)])?;
            }
        }
        Ok(rows.flush()?)
    }
}
