//! What is ahead of a run, and how far it is: for people, no decision depends on it.

use std::fmt;
use std::io::IsTerminal;
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

use indicatif::ProgressBar;
use radgrad_scene::{Error, FactorSettings, FormFactors};

use crate::say::say;
use crate::scene::progress;

/// Rows of which one is computed twice, to know how long they take, and the most of these.
const ROWS_A_PILOT: usize = 50;
const MOST_PILOTS: usize = 16;
/// Rows whose pairs are counted.
const MOST_COUNTED: usize = 64;
const A_LINE_EVERY: Duration = Duration::from_secs(10);

/// Says how many faces there are, how many pairs of them may see each other, and how long the rows of a block that are left to do may
/// take. Little work has no announcement.
pub(super) fn announce(factors: &FormFactors<'_>, block: usize, left: usize, settings: &FactorSettings) -> Result<(), Error> {
    let rows = factors.faces().len();
    let pilots = MOST_PILOTS.min(left / ROWS_A_PILOT);
    if pilots == 0 {
        return Ok(());
    }
    let counted = spread(MOST_COUNTED.min(rows), rows);
    let sightings = factors.sightings(&counted)?;
    let pairs = sightings.iter().sum::<usize>() as f64 * rows as f64 / counted.len() as f64;
    let pilot = spread(pilots, rows);
    let seen: usize = factors.sightings(&pilot)?.iter().sum();
    let started = Instant::now();
    for &row in &pilot {
        factors.block(row..row + 1, settings, || ())?;
    }
    let a_pair = started.elapsed().as_secs_f64() / seen.max(1) as f64;
    // A pair of a face in the block and one outside is computed in the block too.
    let share = block as f64 / rows as f64;
    let ahead = pairs * share * (2.0 - share) * left as f64 / block as f64;
    let threads = rayon::current_num_threads();
    say(format_args!(
        "{rows} faces, about {pairs:.0} pairs of them may see each other: {} on {threads} threads, by a pilot of {pilots} rows",
        Roughly(a_pair * ahead)
    ));
    Ok(())
}

/// Places from 0 to `rows`, evenly spread.
fn spread(count: usize, rows: usize) -> Vec<usize> {
    (0..count).map(|k| (2 * k + 1) * rows / (2 * count)).collect()
}

/// Seconds as people read them.
struct Roughly(f64);

impl fmt::Display for Roughly {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.0 {
            s if s < 1.0 => write!(f, "less than a second"),
            s if s < 120.0 => write!(f, "about {s:.0} s"),
            s if s < 7200.0 => write!(f, "about {:.0} min", s / 60.0),
            s => write!(f, "about {:.1} h", s / 3600.0),
        }
    }
}

/// How many rows are done: a bar where someone looks at it, else a line every ten seconds.
pub(super) struct Progress {
    bar: ProgressBar,
    rows: usize,
    /// The rows that are done, and when that was last said.
    done: Mutex<(usize, Instant)>,
}

impl Progress {
    pub(super) fn new(rows: usize, done: usize) -> Self {
        let bar = progress(rows);
        bar.inc(done as u64);
        Self { bar, rows, done: Mutex::new((done, Instant::now())) }
    }

    pub(super) fn row(&self) {
        self.bar.inc(1);
        let mut done = self.done.lock().unwrap_or_else(PoisonError::into_inner);
        done.0 += 1;
        if done.1.elapsed() >= A_LINE_EVERY && !std::io::stderr().is_terminal() {
            done.1 = Instant::now();
            say(format_args!("{} of {} rows", done.0, self.rows));
        }
    }

    pub(super) fn end(&self) {
        self.bar.finish_and_clear();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_are_spread_over_all_rows_and_times_are_round() {
        assert_eq!(spread(4, 200), [25, 75, 125, 175]);
        assert_eq!(spread(3, 3), [0, 1, 2]);
        let said = [0.2, 33.4, 600.0, 9000.0].map(|seconds| Roughly(seconds).to_string());
        assert_eq!(said, ["less than a second", "about 33 s", "about 10 min", "about 2.5 h"]);
    }
}
