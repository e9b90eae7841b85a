//! The limits: `data/instructions.toml`.
//!
//! ```toml
//! compiler = "1.95.0"
//!
//! [limits]
//! constant = 600
//! ```

use std::collections::BTreeMap;
use std::fmt::Write;

use serde::Deserialize;

use super::Count;

/// Instructions an answer at most, by kernel, with the compiler that they are of.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Limits {
    pub(super) compiler: String,
    limits: BTreeMap<String, u32>,
}

/// Room of a limit above the count found, in hundredths.
const ROOM: f64 = 3.0;

impl Limits {
    /// Reads limits.
    pub(super) fn from_toml(text: &str) -> Result<Self, toml::de::Error> {
        toml::from_str(text)
    }

    /// Limits a little above these counts.
    pub(super) fn above(counts: &[Count], compiler: &str) -> Self {
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "counts are positive and below 2^32")]
        let limit = |count: &Count| (count.kernel.clone(), (count.instructions * (1.0 + ROOM / 100.0)).ceil() as u32);
        Self { compiler: compiler.to_owned(), limits: counts.iter().map(limit).collect() }
    }

    /// The same limits, none above the same compiler's former ones: recording loosens nothing.
    pub(super) fn no_looser_than(mut self, before: &Self) -> Self {
        if self.compiler == before.compiler {
            for (kernel, limit) in &mut self.limits {
                *limit = before.limit(kernel).map_or(*limit, |before| before.min(*limit));
            }
        }
        self
    }

    /// As the file is written.
    pub(super) fn to_toml(&self) -> String {
        let Self { compiler, limits } = self;
        let mut text = format!(
            "# Instructions an answer at most, under callgrind with AVX2, release build: what was found and {ROOM} %.\n\
             # `cargo xtask instructions` fails beyond them; with `--record` it writes them, but none that is looser. To loosen one takes a reason in CHANGELOG.md.\n\n\
             compiler = {compiler:?}\n\n[limits]\n"
        );
        for (kernel, limit) in limits {
            _ = writeln!(text, "{kernel} = {limit}");
        }
        text
    }

    /// The limit of a kernel.
    pub(super) fn limit(&self, kernel: &str) -> Option<u32> {
        self.limits.get(kernel).copied()
    }

    /// Kernels beyond their limit or without one, and those with a limit that were neither counted nor `unknown` to valgrind.
    pub(super) fn violations(&self, counts: &[Count], unknown: &[String]) -> Vec<String> {
        let mut violations: Vec<String> = counts
            .iter()
            .filter_map(|Count { kernel, instructions }| match self.limit(kernel) {
                None => Some(format!("{kernel} has no limit in data/instructions.toml")),
                Some(limit) if *instructions <= f64::from(limit) => None,
                Some(limit) => Some(format!("{kernel} takes {instructions:.0} instructions, the limit is {limit}")),
            })
            .collect();
        let missing = |kernel: &&String| !unknown.contains(kernel) && counts.iter().all(|count| count.kernel != **kernel);
        violations.extend(self.limits.keys().filter(missing).map(|kernel| format!("{kernel} has a limit and was not run")));
        violations
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn count(kernel: &str, instructions: f64) -> Count {
        Count { kernel: kernel.to_owned(), instructions }
    }

    #[test]
    fn limits_leave_three_hundredths_and_survive_their_file() {
        let limits = Limits::above(&[count("constant", 1000.0), count("batch-f64-avx2", 254.5)], "1.95.0");
        assert_eq!((limits.limit("constant"), limits.limit("batch-f64-avx2")), (Some(1030), Some(263)));
        assert_eq!(Limits::from_toml(&limits.to_toml()).unwrap(), limits);
    }

    #[test]
    fn to_record_tightens_limits_and_loosens_none_but_of_another_compiler() {
        let before = Limits::above(&[count("a", 100.0), count("b", 100.0)], "1.95.0");
        let counts = [count("a", 90.0), count("b", 101.0), count("new", 10.0)];
        let recorded = |compiler: &str| Limits::above(&counts, compiler).no_looser_than(&before);
        assert_eq!(["a", "b", "new"].map(|kernel| recorded("1.95.0").limit(kernel)), [Some(93), Some(103), Some(11)]);
        assert_eq!(recorded("1.96.0").limit("b"), Some(105));
    }

    #[test]
    fn what_is_beyond_without_a_limit_or_missing_is_a_violation() {
        let limits = Limits::above(&[count("a", 100.0), count("b", 100.0), count("c", 100.0)], "1.95.0");
        assert!(limits.violations(&[count("a", 100.0), count("b", 103.0), count("c", 1.0)], &[]).is_empty());
        assert!(limits.violations(&[count("a", 100.0)], &["b".to_owned(), "c".to_owned()]).is_empty());
        let violations = limits.violations(&[count("a", 103.1), count("b", 1.0), count("d", 1.0)], &[]);
        assert_eq!(violations.len(), 3, "{violations:?}");
        assert!(
            violations[0].starts_with("a takes 103")
                && violations[1].starts_with("d has no")
                && violations[2].starts_with("c has")
        );
    }

    #[test]
    fn the_committed_limits_are_read() {
        assert!(Limits::from_toml(include_str!("../../../data/instructions.toml")).unwrap().limit("constant").is_some());
    }
}
