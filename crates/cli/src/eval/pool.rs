//! Threads that answer lines, each line in a time of its own.
//!
//! A thread that takes too long for a line cannot be ended. It is given up: its line is refused, another thread takes its place,
//! and what it finds is dropped. The thread goes on beside the others until it finds it, or has cost what an answer may cost.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::sync::{Arc, Mutex, OnceLock, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

use radgrad_scene::Error;

/// How often it is looked how long threads have taken.
const TICK: Duration = Duration::from_millis(20);

/// Threads that were given up and still run, at most: when there are as many, lines may take longer.
const MOST_GIVEN_UP: usize = 32;

/// The function that answers a line, given its number.
pub(super) type Answer<L, R> = fn(usize, &L) -> R;

/// The function that makes the reply to a line without an answer.
pub(super) type Refuse<L, R> = fn(usize, &L, Error) -> R;

/// Lines, and their replies as they come.
#[derive(Debug)]
pub(super) struct Batch<L, R> {
    /// Number of the first line.
    first: usize,
    lines: Vec<L>,
    /// Index of the next line that nobody has taken.
    next: AtomicUsize,
    replies: Vec<OnceLock<R>>,
}

impl<L, R> Batch<L, R> {
    /// The replies, in the order of the lines.
    pub(super) fn replies(&self) -> impl Iterator<Item = &R> {
        self.replies.iter().filter_map(OnceLock::get)
    }
}

/// The work of a thread: the index of a line, and since when.
type Occupied = Arc<Mutex<Option<(usize, Instant)>>>;

struct Worker<L, R> {
    id: usize,
    batches: Sender<Arc<Batch<L, R>>>,
    occupied: Occupied,
}

/// Threads, as many as there are cores.
pub(super) struct Pool<L, R> {
    answer: Answer<L, R>,
    refuse: Refuse<L, R>,
    patience: Duration,
    workers: Vec<Worker<L, R>>,
    ids: usize,
    finished: (Sender<usize>, Receiver<usize>),
    given_up: Arc<AtomicUsize>,
}

impl<L: Send + Sync + 'static, R: Send + Sync + 'static> Pool<L, R> {
    pub(super) fn new(answer: Answer<L, R>, refuse: Refuse<L, R>, patience: Duration) -> Self {
        let (workers, finished, given_up) = (Vec::new(), channel(), Arc::default());
        let mut pool = Self { answer, refuse, patience, workers, ids: 0, finished, given_up };
        let threads = thread::available_parallelism().map_or(1, usize::from);
        for _ in 0..threads {
            pool.add_worker(None);
        }
        pool
    }

    /// The replies to lines, in their order.
    pub(super) fn answer(&mut self, first: usize, lines: Vec<L>) -> Arc<Batch<L, R>> {
        let replies = lines.iter().map(|_| OnceLock::new()).collect();
        let batch = Arc::new(Batch { first, lines, next: AtomicUsize::new(0), replies });
        let mut at_work: Vec<usize> = Vec::new();
        for worker in self.workers.iter().take(batch.lines.len()) {
            // A thread that is gone has nothing to say; there is always one that is not.
            if worker.batches.send(Arc::clone(&batch)).is_ok() {
                at_work.push(worker.id);
            }
        }
        while !at_work.is_empty() {
            match self.finished.1.recv_timeout(TICK) {
                Ok(id) => at_work.retain(|&other| other != id),
                Err(RecvTimeoutError::Timeout | RecvTimeoutError::Disconnected) => self.give_up_late(&batch, &mut at_work),
            }
        }
        batch
    }

    /// Gives up the threads that have been at their line for too long, and lets others go on.
    fn give_up_late(&mut self, batch: &Arc<Batch<L, R>>, at_work: &mut Vec<usize>) {
        for id in at_work.clone() {
            let Some(place) = self.workers.iter().position(|worker| worker.id == id) else { continue };
            let Some((index, since)) = *locked(&self.workers[place].occupied) else { continue };
            if since.elapsed() < self.patience || self.given_up.load(Ordering::Relaxed) >= MOST_GIVEN_UP {
                continue;
            }
            let error = Error::Time { seconds: self.patience.as_secs_f64() };
            let refusal = (self.refuse)(batch.first + index, &batch.lines[index], error);
            // Else it has answered just now.
            if batch.replies[index].set(refusal).is_ok() {
                self.given_up.fetch_add(1, Ordering::Relaxed);
                self.workers.swap_remove(place);
                at_work.retain(|&other| other != id);
                at_work.extend(self.add_worker(Some(batch)));
            }
        }
    }

    /// Starts a thread, with a batch to begin with or none, and returns its name if it has one.
    fn add_worker(&mut self, batch: Option<&Arc<Batch<L, R>>>) -> Option<usize> {
        let (batches, received) = channel::<Arc<Batch<L, R>>>();
        self.ids += 1;
        let (id, occupied) = (self.ids, Occupied::default());
        let (answer, refuse, finished, given_up) =
            (self.answer, self.refuse, self.finished.0.clone(), Arc::clone(&self.given_up));
        let at = Arc::clone(&occupied);
        thread::spawn(move || {
            for batch in received {
                if !work(&batch, &at, answer, refuse) {
                    given_up.fetch_sub(1, Ordering::Relaxed);
                    return;
                }
                drop(batch);
                // Without a pool there is nobody to tell.
                let _ = finished.send(id);
            }
        });
        let given = batch.is_some_and(|batch| batches.send(Arc::clone(batch)).is_ok());
        self.workers.push(Worker { id, batches, occupied });
        given.then_some(id)
    }
}

/// Answers the lines of a batch that nobody has taken; false once the thread was given up.
fn work<L, R>(batch: &Batch<L, R>, occupied: &Occupied, answer: Answer<L, R>, refuse: Refuse<L, R>) -> bool {
    loop {
        let index = batch.next.fetch_add(1, Ordering::Relaxed);
        let Some(line) = batch.lines.get(index) else { break };
        *locked(occupied) = Some((index, Instant::now()));
        let number = batch.first + index;
        // A fault costs its own line only.
        let reply = catch_unwind(AssertUnwindSafe(|| answer(number, line)));
        let reply = reply.unwrap_or_else(|_| refuse(number, line, Error::Fault));
        if batch.replies[index].set(reply).is_err() {
            return false;
        }
    }
    *locked(occupied) = None;
    true
}

/// The lock is held for no longer than an assignment, which cannot fail.
fn locked<T>(mutex: &Mutex<T>) -> std::sync::MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pool(patience: u64) -> Pool<u64, String> {
        let answer = |number: usize, milliseconds: &u64| {
            if *milliseconds == 7 {
                // As a panic does, without a trace on the screen.
                std::panic::resume_unwind(Box::new("fault"));
            }
            thread::sleep(Duration::from_millis(*milliseconds));
            format!("{number}: {milliseconds}")
        };
        Pool::new(answer, |number, _, error| format!("{number}: {error}"), Duration::from_millis(patience))
    }

    #[test]
    fn replies_come_in_order_and_a_slow_line_or_a_fault_costs_itself_only() {
        let mut pool = pool(1000);
        let batch = pool.answer(1, vec![0, 60_000, 0, 7, 1, 60_000, 60_000, 0]);
        let replies: Vec<&String> = batch.replies().collect();
        assert_eq!(replies.len(), 8);
        for (index, reply) in replies.into_iter().enumerate() {
            assert!(reply.starts_with(&format!("{}: ", index + 1)), "{reply}");
            assert_eq!(reply.contains("no answer within 1 s"), [1, 5, 6].contains(&index), "{reply}");
            assert_eq!(reply.contains("the program failed"), index == 3, "{reply}");
        }
        let batch = pool.answer(9, vec![0; 1000]);
        assert!(batch.replies().enumerate().all(|(i, reply)| *reply == format!("{}: 0", 9 + i)));
        assert_eq!(pool.answer(1, Vec::new()).replies().count(), 0);
    }
}
