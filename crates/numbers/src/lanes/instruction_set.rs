//! The vector unit of this machine, found at run time. All instruction sets give the same digits: kernels use correctly rounded
//! operations only, no product is fused with a sum but where the result is exact, and no sum's order depends on how many lanes there
//! are.

use fearless_simd::{Level, Simd};

#[doc(hidden)]
pub use fearless_simd;

/// Runs a call with the vectors of an instruction set: AVX-512, AVX2 or the one that every machine of the target has. It is
/// compiled for each, or for those named.
#[macro_export]
macro_rules! on_instruction_set {
    ([$($set:ident)*] $level:expr, $simd:ident => $call:expr) => {{
        #[cfg(target_arch = "x86_64")]
        {
            use $crate::lanes::instruction_set::fearless_simd::Simd;
            $(if let Some($simd) = $level.$set() {
                $simd.vectorize(
                    #[inline(always)]
                    || $call,
                )
            } else)* {
                unreachable!("every x86-64 has SSE2")
            }
        }
        #[cfg(not(target_arch = "x86_64"))]
        {
            $crate::lanes::instruction_set::fearless_simd::dispatch!($level, $simd => $call)
        }
    }};
    ($level:expr, $simd:ident => $call:expr) => {
        $crate::lanes::instruction_set::on_instruction_set!([as_avx512 as_avx2 as_sse2] $level, $simd => $call)
    };
}

/// As [`on_instruction_set`], for functions that a crate's users call; compiled for those named, else for AVX2 and what every machine has: on four
/// lanes AVX-512 is no faster. The unit tests of that crate have it for one set only, as any gives the same digits: the sets themselves
/// are compared where [`on_instruction_set`] is called, and by tests of the library.
#[macro_export]
macro_rules! in_library {
    ([$($set:ident)*] $level:expr, $simd:ident => $call:expr) => {{
        #[cfg(test)]
        {
            $crate::lanes::instruction_set::on_instruction_set!([as_sse2] $level, $simd => $call)
        }
        #[cfg(not(test))]
        {
            $crate::lanes::instruction_set::on_instruction_set!([$($set)*] $level, $simd => $call)
        }
    }};
    ($level:expr, $simd:ident => $call:expr) => {
        $crate::lanes::instruction_set::in_library!([as_avx2 as_sse2] $level, $simd => $call)
    };
}

#[doc(hidden)]
pub use {in_library, on_instruction_set};

/// Calls a function without inlining it, so that the compiler makes one copy for all callers. The function must be `#[inline(always)]`:
/// then its code uses the instruction set.
#[inline(never)]
pub fn apart<S: Simd, A, R>(simd: S, arguments: A, function: impl Fn(A) -> R) -> R {
    simd.vectorize(
        #[inline(always)]
        || function(arguments),
    )
}

/// The instruction sets of this machine that [`on_instruction_set`] tells apart, best first.
pub fn instruction_sets() -> Vec<Level> {
    let best = Level::new();
    #[cfg(target_arch = "x86_64")]
    {
        let instruction_sets =
            [best.as_avx512().map(Simd::level), best.as_avx2().map(Simd::level), best.as_sse2().map(Simd::level)];
        instruction_sets.into_iter().flatten().collect()
    }
    #[cfg(not(target_arch = "x86_64"))]
    {
        vec![best]
    }
}

/// Its usual name.
pub fn name(level: Level) -> &'static str {
    #[cfg(target_arch = "x86_64")]
    {
        let (wide, wider) = (level.as_avx2().is_some(), level.as_avx512().is_some());
        if wider { "AVX-512" } else { ["SSE2", "AVX2"][usize::from(wide)] }
    }
    #[cfg(not(target_arch = "x86_64"))]
    {
        if level.is_fallback() { "no vectors" } else { "vectors of 128 bits" }
    }
}
