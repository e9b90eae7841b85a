//! The program with faults in it, asked one check at a time.
//!
//! A check with a fault may take so much of the processor's time and of memory, by the limits of the system; a clock on the wall ends
//! only what waits for ever.

use std::collections::BTreeMap;
use std::error::Error;
use std::fs::{self, File};
use std::path::PathBuf;
use std::process::{Command, ExitStatus, Stdio};
use std::thread;
use std::time::{Duration, Instant};

use rayon::prelude::*;
use serde::Deserialize;

/// A check that takes so many times as long as without a fault, and so many seconds more, is one that does not end.
const PATIENCE: (f64, f64) = (5.0, 3.0);

/// In KiB.
const MEMORY: u64 = 4 << 20;

/// A check that has not ended then, whatever it does.
const FOR_EVER: Duration = Duration::from_secs(900);

/// A check, and what it comes to.
#[derive(Debug)]
pub(crate) struct Check {
    pub(crate) name: &'static str,
    /// Of the processor, without a fault.
    pub(crate) seconds: f64,
    /// Of each fault whose place it comes to: whether that gives another value there, as far as is known.
    reached: BTreeMap<usize, bool>,
}

/// What is seen of a fault.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum Seen {
    /// Truth tells, in this check.
    Truth { check: &'static str, what: String },
    /// The record alone.
    Record { check: &'static str, what: String },
    /// No check tells of those that come to it.
    Nothing,
    /// No check comes to where it gives another value.
    NeverDiffers,
    /// No check comes to it.
    Unreached,
}

/// A line of the program.
#[derive(Deserialize)]
struct Line {
    by_record: bool,
    what: String,
}

/// The program and where it writes.
#[derive(Debug)]
pub(crate) struct Program {
    pub(crate) path: PathBuf,
    pub(crate) out: PathBuf,
}

impl Program {
    /// The checks, the quickest first, with what each comes to where no fault is on: then nothing must be wrong. `is_told` says of which
    /// faults it is told that they give another value.
    pub(crate) fn checks(
        &self,
        names: &[&'static str],
        is_told: impl Fn(usize) -> bool + Sync,
    ) -> Result<Vec<Check>, Box<dyn Error>> {
        let recorded = names.par_iter().map(|name| self.recorded(name, &is_told).map_err(|error| error.to_string()));
        let mut checks = recorded.collect::<Result<Vec<_>, String>>()?;
        checks.sort_by(|a, b| a.seconds.total_cmp(&b.seconds));
        Ok(checks)
    }

    fn recorded(&self, name: &'static str, is_told: impl Fn(usize) -> bool) -> Result<Check, Box<dyn Error>> {
        let file = self.out.join(format!("reached-{name}"));
        if file.exists() {
            fs::remove_file(&file)?;
        }
        let start = Instant::now();
        let mut command = Command::new("sh");
        command.args(["-c", "\"$0\" \"$@\"; status=$?; times >&2; exit $status"]).arg(&self.path);
        let output = asking(&mut command, name).env("FAULT", "record").env("FAULT_RECORD", &file).output()?;
        if !output.status.success() {
            return Err(format!("without a fault {name} finds {}", String::from_utf8_lossy(&output.stdout)).into());
        }
        let mut reached = BTreeMap::new();
        for line in fs::read_to_string(&file).unwrap_or_default().lines() {
            if let Some((what, number)) = line.split_once(' ') {
                let number = number.parse()?;
                let differs = what == "differs" || !is_told(number);
                *reached.entry(number).or_insert(false) |= differs;
            }
        }
        let times = String::from_utf8_lossy(&output.stderr);
        let seconds = times.lines().last().and_then(of_times).unwrap_or_else(|| start.elapsed().as_secs_f64());
        Ok(Check { name, seconds, reached })
    }

    /// What is seen of a fault, and how long that took.
    pub(crate) fn fared(&self, checks: &[Check], fault: usize) -> Result<(Seen, f64), Box<dyn Error>> {
        let (start, mut record) = (Instant::now(), None);
        for check in checks.iter().filter(|check| check.reached.get(&fault) == Some(&true)) {
            match self.asked(check, fault)? {
                Some((false, what)) => return Ok((Seen::Truth { check: check.name, what }, start.elapsed().as_secs_f64())),
                Some((true, what)) if record.is_none() => record = Some(Seen::Record { check: check.name, what }),
                _ => {}
            }
        }
        let differs: Vec<bool> = checks.iter().filter_map(|check| check.reached.get(&fault).copied()).collect();
        let unseen = match (differs.is_empty(), differs.contains(&true)) {
            (true, _) => Seen::Unreached,
            (false, true) => Seen::Nothing,
            (false, false) => Seen::NeverDiffers,
        };
        Ok((record.unwrap_or(unseen), start.elapsed().as_secs_f64()))
    }

    /// What a check says with a fault: whether it is by the record alone, and what.
    fn asked(&self, check: &Check, fault: usize) -> Result<Option<(bool, String)>, Box<dyn Error>> {
        let said = self.out.join(format!("said-{fault}"));
        let seconds = (PATIENCE.0 * check.seconds + PATIENCE.1).ceil();
        let mut command = Command::new("sh");
        command.args(["-c", &format!("ulimit -t {seconds}; ulimit -v {MEMORY}; exec \"$0\" \"$@\"")]).arg(&self.path);
        let status = ended(asking(&mut command, check.name).env("FAULT", fault.to_string()).stdout(File::create(&said)?))?;
        let text = String::from_utf8_lossy(&fs::read(&said)?).into_owned();
        fs::remove_file(&said)?;
        let lines: Vec<Line> = text.lines().filter_map(|line| serde_json::from_str(line).ok()).collect();
        if let Some(line) = lines.iter().find(|line| !line.by_record).or(lines.first()) {
            return Ok(Some((line.by_record, line.what.clone())));
        }
        Ok(match status {
            None => Some((false, "it waits for ever".to_owned())),
            Some(status) if !status.success() => Some((false, format!("it ends with {status}"))),
            Some(_) => None,
        })
    }

    /// Witnesses that a climb finds of a bound that a fault breaks, as lines of JSON.
    pub(crate) fn searched(&self, fault: usize, rounds: u64) -> Result<Vec<String>, Box<dyn Error>> {
        let output = Command::new(&self.path).args(["search", &rounds.to_string()]).env("FAULT", fault.to_string()).output()?;
        Ok(String::from_utf8(output.stdout)?.lines().map(str::to_owned).collect())
    }
}

/// One check, on one core: others run beside it.
fn asking<'a>(command: &'a mut Command, check: &str) -> &'a mut Command {
    command.args(["--check", check, "--alone"]).env("RAYON_NUM_THREADS", "1").stdin(Stdio::null())
}

/// How it ended, if it did.
fn ended(command: &mut Command) -> Result<Option<ExitStatus>, Box<dyn Error>> {
    let (start, mut child) = (Instant::now(), command.stderr(Stdio::null()).spawn()?);
    loop {
        if let Some(status) = child.try_wait()? {
            return Ok(Some(status));
        }
        if start.elapsed() > FOR_EVER {
            child.kill()?;
            child.wait()?;
            return Ok(None);
        }
        thread::sleep(Duration::from_millis(5));
    }
}

/// Seconds of user and system, as the shell's `times` writes them: `0m1.230s 0m0.040s`.
fn of_times(line: &str) -> Option<f64> {
    let parsed = |word: &str| {
        let (minutes, seconds) = word.strip_suffix('s')?.split_once('m')?;
        Some(60.0 * minutes.parse::<f64>().ok()? + seconds.parse::<f64>().ok()?)
    };
    line.split_whitespace().map(parsed).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_of_the_shell_are_read() {
        assert_eq!(of_times("1m1.25s 0m0.5s"), Some(61.75));
        assert_eq!(of_times("no times"), None);
    }

    #[test]
    fn a_program_that_runs_away_is_one_that_ends_with_a_signal() {
        let mut command = Command::new("sh");
        let status = ended(command.args(["-c", "ulimit -t 1; while :; do :; done"])).unwrap();
        assert!(status.is_some_and(|status| !status.success()));
    }
}
