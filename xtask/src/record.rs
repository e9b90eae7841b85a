//! The settings and outcome of a run, in files beside its tables: `NAME-run.csv` with a field a row, `NAME-violations.csv`.

use std::error::Error;
use std::fmt::Display;
use std::path::Path;
use std::process::Command;
use std::time::{SystemTime, UNIX_EPOCH};

use crate::files::{self, in_workspace};

/// The record of a run.
pub(crate) struct Record {
    name: &'static str,
    fields: Vec<[String; 2]>,
    /// Each violation, and the command that shows it.
    violations: Vec<[String; 2]>,
}

impl Record {
    /// Of a run that was begun now, with so many cases under a seed.
    pub(crate) fn new(name: &'static str, seed: u64, cases: u64) -> Self {
        let mut record = Self { name, fields: Vec::new(), violations: Vec::new() };
        let arguments: Vec<String> = std::env::args().skip(1).collect();
        record.note("command", format_args!("cargo xtask {}", arguments.join(" ")));
        record.note("date", today());
        record.note("version", env!("CARGO_PKG_VERSION"));
        record.note("commit", commit());
        record.note("machine", format_args!("{} {}", std::env::consts::ARCH, std::env::consts::OS));
        record.note("seed", seed);
        record.note("cases", cases);
        record
    }

    /// Adds a field.
    pub(crate) fn note(&mut self, field: &str, value: impl Display) {
        self.fields.push([field.to_owned(), value.to_string()]);
    }

    /// Prints and keeps a violation, with the command that shows it.
    pub(crate) fn violated(&mut self, what: impl Display, command: &str) {
        println!("VIOLATED {what}\n  replay: {command}");
        self.violations.push([what.to_string(), command.to_owned()]);
    }

    /// Writes both files. Whether nothing was violated.
    pub(crate) fn write(mut self, out: &Path) -> Result<bool, Box<dyn Error>> {
        let passed = self.violations.is_empty();
        self.note("violations", self.violations.len());
        self.note("passed", passed);
        for (file, header, rows) in
            [("run", ["field", "value"], &self.fields), ("violations", ["violation", "command"], &self.violations)]
        {
            files::table(&out.join(format!("{}-{file}.csv", self.name)), |table| {
                table.write_record(header)?;
                Ok(rows.iter().try_for_each(|row| table.write_record(row))?)
            })?;
        }
        Ok(passed)
    }
}

/// The state of the sources, if git knows it.
fn commit() -> String {
    let described =
        Command::new("git").args(["describe", "--always", "--dirty", "--abbrev=12"]).current_dir(in_workspace(".")).output();
    let text = described.ok().filter(|output| output.status.success()).and_then(|output| String::from_utf8(output.stdout).ok());
    text.map_or_else(|| "unknown".to_owned(), |text| text.trim().to_owned())
}

/// The date in UTC, as 2026-11-21.
fn today() -> String {
    let seconds = SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |since| since.as_secs());
    let [year, month, day] = date(seconds / 86_400);
    format!("{year}-{month:02}-{day:02}")
}

/// Year, month and day so many days after 1970-01-01, in the Gregorian calendar: years begin in March, so that the day that
/// leap years have more is their last, and 400 years have 146,097 days.
const fn date(days: u64) -> [u64; 3] {
    let days = days + 719_468;
    let (cycle, in_cycle) = (days / 146_097, days % 146_097);
    let year = (in_cycle - in_cycle / 1460 + in_cycle / 36_524 - in_cycle / 146_096) / 365;
    let in_year = in_cycle - (365 * year + year / 4 - year / 100);
    // From March the months' lengths repeat every five, 153 days.
    let month = (5 * in_year + 2) / 153;
    let day = in_year - (153 * month + 2) / 5 + 1;
    let after_december = (month >= 10) as u64;
    [400 * cycle + year + after_december, month + 3 - 12 * after_december, day]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn days_have_their_dates() {
        assert_eq!(date(0), [1970, 1, 1]);
        assert_eq!(date(11_016), [2000, 2, 29]);
        assert_eq!(date(11_017), [2000, 3, 1]);
        assert_eq!(date(20_778), [2026, 11, 21]);
        assert_eq!(date(20_818), [2026, 12, 31]);
        assert_eq!(date(20_819), [2027, 1, 1]);
    }

    #[test]
    fn a_violation_is_written_and_fails() {
        let out = std::env::temp_dir().join(format!("radgrad-record-{}", std::process::id()));
        std::fs::create_dir_all(&out).unwrap();
        let mut record = Record::new("verify", 1, 7);
        record.violated("a, b", "cargo xtask replay generic:1:0");
        assert!(!record.write(&out).unwrap());
        let read = |name: &str| std::fs::read_to_string(out.join(name)).unwrap();
        assert!(read("verify-run.csv").contains("cases,7\n") && read("verify-run.csv").ends_with("violations,1\npassed,false\n"));
        assert_eq!(read("verify-violations.csv"), "violation,command\n\"a, b\",cargo xtask replay generic:1:0\n");
        std::fs::remove_dir_all(&out).unwrap();
    }
}
