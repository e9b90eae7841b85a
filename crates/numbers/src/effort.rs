//! Effort: the cost of a computation, counted in operations and not in time, so that where it ends does not depend on the machine.
//!
//! An operation is about one on doubles; one on numbers of many bits counts as many times its words. A computation that may take
//! long, for the size of its input or for the digits that it needs, pays by [`spend`] as it goes on. Past the limit of its thread
//! it need not compute any more: it runs out quickly, and [`within`] drops its result.

use std::cell::Cell;

#[derive(Clone, Copy)]
struct Meter {
    spent: u64,
    limit: u64,
}

thread_local! {
    static METER: Cell<Meter> = const { Cell::new(Meter { spent: 0, limit: u64::MAX }) };
}

/// Charges the outer computation also where the inner one panics.
struct Outer(Meter);

impl Drop for Outer {
    fn drop(&mut self) {
        let spent = self.0.spent.saturating_add(METER.get().spent);
        METER.set(Meter { spent, ..self.0 });
    }
}

/// Runs a computation of at most so many operations: its result, or `None` if it would have taken more; and the operations it has
/// taken.
///
/// ```
/// use radgrad_numbers::effort::{spend, within};
/// let count = |most: u64| (0..most).take_while(|_| spend(1)).count();
/// assert_eq!(within(10, || count(7)), (Some(7), 7));
/// assert_eq!(within(10, || count(1000)), (None, 11));
/// assert_eq!(within(10, || within(1000, || count(1000)).0).0, None, "it is a part of the outer one");
/// ```
pub fn within<R>(limit: u64, computation: impl FnOnce() -> R) -> (Option<R>, u64) {
    let outer = METER.get();
    let limit = limit.min(remaining());
    METER.set(Meter { spent: 0, limit });
    let outer = Outer(outer);
    let result = computation();
    let spent = METER.get().spent;
    drop(outer);
    ((spent <= limit).then_some(result), spent)
}

/// Pays for so many operations; false once the computation has cost more than it may.
#[inline]
pub fn spend(operations: u64) -> bool {
    let Meter { spent, limit } = METER.get();
    let spent = spent.saturating_add(operations);
    METER.set(Meter { spent, limit });
    spent <= limit
}

/// The operations so far.
#[must_use]
pub fn spent() -> u64 {
    METER.get().spent
}

/// The remaining operations.
#[must_use]
pub fn remaining() -> u64 {
    let Meter { spent, limit } = METER.get();
    limit.saturating_sub(spent)
}

/// Whether the computation has cost more than it may.
#[must_use]
pub fn is_over() -> bool {
    !spend(0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_panic_leaves_the_outer_limit_and_is_paid_for() {
        let (result, spent) = within(10, || {
            let panicked = std::panic::catch_unwind(|| {
                within(1000, || {
                    spend(4);
                    std::panic::resume_unwind(Box::new("a fault"));
                })
            });
            assert!(panicked.is_err() && remaining() == 6);
            spend(6) && !spend(1) && is_over()
        });
        assert_eq!((result, spent), (None, 11));
        assert!(remaining() > 1 << 60 && !is_over());
    }
}
