//! Data that is made when it is first asked for, on all cores, by whichever of many threads asks first.
//!
//! A thread of a pool that waits for others of it takes up other work meanwhile: work that asks for the same data would wait for itself. And
//! when all of them wait for the data, none is left to make it. So it is made by threads of its own, and who asks only waits.

use std::sync::OnceLock;

use rayon::ThreadPoolBuilder;

/// The data of a cell; if it is empty, made now.
pub(crate) fn made<T: Send + Sync>(cell: &OnceLock<T>, make: impl FnOnce() -> T + Send) -> &T {
    cell.get_or_init(|| {
        match ThreadPoolBuilder::new().num_threads(rayon::current_num_threads()).build() {
            Ok(threads) => {
                let done = std::thread::scope(|scope| scope.spawn(|| threads.install(make)).join());
                done.unwrap_or_else(|panicked| std::panic::resume_unwind(panicked))
            }
            // Where there is no thread left, there is one at least.
            Err(_) => make(),
        }
    })
}

#[cfg(test)]
mod tests {
    use rayon::prelude::*;

    use super::*;

    #[test]
    fn many_threads_of_one_pool_ask_at_once() {
        let threads = ThreadPoolBuilder::new().num_threads(8).build().unwrap();
        for _ in 0..50 {
            let (outer, inner) = (OnceLock::new(), OnceLock::new());
            let slow = |k: u64| (0..2_000).fold(k, |hash, x| (hash ^ x).wrapping_mul(0x0100_0000_01b3));
            let of_inner = || *made(&inner, || (0..256_u64).into_par_iter().map(slow).max());
            let of_outer = || *made(&outer, || (0..256_u64).into_par_iter().map(|k| (slow(k), of_inner())).max());
            let asked = || (0..64).into_par_iter().map(|_| of_outer()).collect::<Vec<_>>();
            let found = std::thread::scope(|scope| {
                let askers: Vec<_> = (0..4).map(|_| scope.spawn(|| threads.install(asked))).collect();
                askers.into_iter().flat_map(|asker| asker.join().unwrap()).collect::<Vec<_>>()
            });
            assert!(found.len() == 256 && found.iter().all(|one| *one == found[0]));
        }
    }
}
