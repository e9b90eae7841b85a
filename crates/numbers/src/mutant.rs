//! Faults that `cargo xtask mutants` plants in the shipped code, one at a time, to see which of them the audit catches.
//!
//! `mutant!("place.what", value, fault)` is `value`, and nothing else, in every build but that command's own: what the compiler
//! gets is the expression alone. A build with `--cfg radgrad_mutants` gives `fault(value)` where `plant` has named the place. Cargo
//! sets no such flag, and no feature does.
//!
//! `data/mutants.toml` lists all of them with what each shows.

/// The value; in the build of `cargo xtask mutants` the fault made of it, where that one is planted.
#[cfg(not(radgrad_mutants))]
#[doc(hidden)]
#[macro_export]
macro_rules! mutant {
    ($id:literal, $value:expr, $fault:expr) => {
        $value
    };
}

/// The value, or the fault made of it where that one is planted.
#[cfg(radgrad_mutants)]
#[doc(hidden)]
#[macro_export]
macro_rules! mutant {
    ($id:literal, $value:expr, $fault:expr) => {
        $crate::mutant::planted(const { $crate::mutant::key($id) }, $value, $fault)
    };
}

/// A number for a name, other ones for other names (Fowler, Noll and Vo's hash; a test of xtask looks).
#[cfg(radgrad_mutants)]
#[must_use]
pub const fn key(id: &str) -> u64 {
    let (bytes, mut hash, mut i) = (id.as_bytes(), 0xcbf2_9ce4_8422_2325_u64, 0);
    while i < bytes.len() {
        hash = (hash ^ bytes[i] as u64).wrapping_mul(0x0100_0000_01b3);
        i += 1;
    }
    hash
}

/// The value, or the fault made of it where the one with this key is planted.
#[cfg(radgrad_mutants)]
#[inline(always)]
pub fn planted<T>(key: u64, value: T, fault: impl FnOnce(T) -> T) -> T {
    if key == PLANTED.load(std::sync::atomic::Ordering::Relaxed) { fault(value) } else { value }
}

/// The key of the fault that is planted; 0, which no name has, for none.
#[cfg(radgrad_mutants)]
static PLANTED: std::sync::atomic::AtomicU64 = std::sync::atomic::AtomicU64::new(0);

/// Plants the fault of this name from now on, on all threads; none of the empty name. Tables that were made before keep what they
/// were made with.
#[cfg(radgrad_mutants)]
pub fn plant(id: &str) {
    PLANTED.store(if id.is_empty() { 0 } else { key(id) }, std::sync::atomic::Ordering::Relaxed);
}
