//! Which fault is on, in the copy that `cargo xtask mutants` makes; and which places a run comes to.
//!
//! The environment says it: `FAULT` is the number of one; or `record`, with `FAULT_RECORD` naming a file that gets a line `reached K`
//! for each place that is come to, and `differs K` where the fault would have given another value.

use std::io::Write;
use std::sync::atomic::{AtomicI32, AtomicU64, Ordering::Relaxed};

const NONE: i32 = -1;
const UNKNOWN: i32 = -2;
const RECORD: i32 = -3;

static ON: AtomicI32 = AtomicI32::new(UNKNOWN);
static SEEN: [AtomicU64; 1024] = [const { AtomicU64::new(0) }; 1024];

/// Whether this fault is on.
#[inline(always)]
pub fn on(fault: i32) -> bool {
    let on = ON.load(Relaxed);
    on == fault || (on < NONE && asked(fault))
}

/// Whether places are recorded.
#[inline(always)]
pub fn records() -> bool {
    ON.load(Relaxed) == RECORD
}

#[cold]
#[inline(never)]
fn asked(fault: i32) -> bool {
    if ON.load(Relaxed) == UNKNOWN {
        let named = match std::env::var("FAULT").as_deref() {
            Ok("record") => RECORD,
            Ok(number) => number.parse().unwrap_or(NONE),
            Err(_) => NONE,
        };
        ON.store(named, Relaxed);
        return on(fault);
    }
    note(2 * fault as usize, "reached", fault);
    false
}

/// The fault would have given another value here.
#[cold]
#[inline(never)]
pub fn differs(fault: i32, differs: bool) {
    if differs {
        note(2 * fault as usize + 1, "differs", fault);
    }
}

fn note(bit: usize, what: &str, fault: i32) {
    let mask = 1 << (bit % 64);
    let word = &SEEN[bit / 64];
    if word.load(Relaxed) & mask == 0 && word.fetch_or(mask, Relaxed) & mask == 0 {
        let file = std::env::var_os("FAULT_RECORD").expect("a file is named");
        let mut file = std::fs::OpenOptions::new().append(true).create(true).open(file).expect("the file opens");
        file.write_all(format!("{what} {fault}\n").as_bytes()).expect("the file is written");
    }
}
