//! How much time there is.

use std::time::{Duration, Instant};

use crate::bytes::Bytes;

/// The parts of the time given at which direct light is divided no more in the first round, and its links are refined no more: an answer
/// comes early. And those at which no round goes on, and an estimate is no longer refined.
const FIRST_LIGHT: f64 = 0.1;
const FIRST_LINKS: f64 = 0.2;
const ROUNDS: f64 = 0.8;
const ESTIMATE: f64 = 1.1;

/// How much longer than the time given evaluations are as precise as they should be: a small scene needs no more.
const GRACE: Duration = Duration::from_secs(1);

/// When to end; never without a time.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Clock {
    start: Instant,
    end: Option<Instant>,
}

impl Clock {
    /// From now on.
    pub(crate) fn started() -> Self {
        Self { start: Instant::now(), end: None }
    }

    pub(crate) fn elapsed(&self) -> Duration {
        self.start.elapsed()
    }

    /// For direct light and for links in a round, the first one or another after which so much is left to do.
    pub(crate) fn for_round(self, is_first: bool, time: Option<Duration>, after: Duration) -> [Self; 2] {
        if is_first {
            return [FIRST_LIGHT, FIRST_LINKS].map(|part| self.until(time, part));
        }
        let end = |end: Instant| end.checked_sub(after).unwrap_or(self.start);
        let whole = self.until(time, ROUNDS);
        [Self { end: whole.end.map(end), ..self }; 2]
    }

    /// Whether there is time for a round that does so much beside refining.
    pub(crate) fn has_time_for(self, time: Option<Duration>, round: Duration) -> bool {
        let end = self.until(time, ROUNDS).end;
        end.is_none_or(|end| Instant::now().checked_add(round).is_some_and(|done| done < end))
    }

    /// For evaluations that are more precise than the error asked for needs.
    pub(crate) fn for_precision(self, time: Option<Duration>) -> Self {
        self.until(time, FIRST_LINKS)
    }

    /// For evaluations that are as precise as the error asked for needs.
    pub(crate) fn for_all(self, time: Option<Duration>) -> Self {
        self.until(time.map(|time| time.saturating_add(GRACE)), 1.0)
    }

    /// For the estimate to be refined, where faces are many: of few it is worth its time.
    pub(crate) fn for_estimate(self, time: Option<Duration>, many: bool) -> Self {
        if many { self.until(time, ESTIMATE) } else { Self { end: None, ..self } }
    }

    fn until(self, time: Option<Duration>, part: f64) -> Self {
        Self {
            end: time.and_then(|time| self.start.checked_add(Duration::try_from_secs_f64(part * time.as_secs_f64()).ok()?)),
            ..self
        }
    }

    pub(crate) fn is_over(&self) -> bool {
        self.end.is_some_and(|end| Instant::now() >= end)
    }
}

/// Whether it is over: one that is read never ends, or ended already.
impl Bytes for Clock {
    fn put(&self, to: &mut Vec<u8>) {
        self.is_over().put(to);
    }

    fn take(from: &mut &[u8]) -> Option<Self> {
        let (start, is_over) = (Instant::now(), bool::take(from)?);
        Some(Self { start, end: is_over.then_some(start) })
    }
}
