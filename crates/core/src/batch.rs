//! Many receivers or many emitters at once, on the vector units of the machine.

mod answers;
mod arc_tangent;
mod bound;
mod edge;
mod lanes;
#[allow(dead_code)]
mod logarithm;
mod one_emitter;
mod receivers;
mod tile;
mod visible;

use fearless_simd::Level;

pub use answers::{Answers, Counts};
pub use receivers::Receivers;

use crate::{Emitter, Error};
use one_emitter::OneEmitter;
use tile::Goal;

/// Single or double precision: `f32` or `f64`.
#[allow(private_bounds, reason = "what lanes need of a number is not for others to implement")]
pub trait Precision: lanes::Lane {}

impl Precision for f64 {}
impl Precision for f32 {}

/// How batches run: on which instruction set, on one thread or all.
#[derive(Debug, Clone, Copy)]
pub struct Engine {
    level: Level,
    threads: bool,
}

impl Default for Engine {
    fn default() -> Self {
        Self::new()
    }
}

impl Engine {
    /// The best instruction set of this machine, on one thread.
    #[must_use]
    pub fn new() -> Self {
        Self { level: Level::new(), threads: false }
    }

    /// One engine for each instruction set of this machine, best first. They give the same digits.
    #[must_use]
    pub fn all() -> Vec<Self> {
        levels().into_iter().map(|level| Self { level, threads: false }).collect()
    }

    /// The same on all threads.
    #[must_use]
    pub const fn threads(self) -> Self {
        Self { threads: true, ..self }
    }

    /// Radiosity alone.
    pub fn radiosity<F: Precision>(
        &self,
        receivers: &Receivers<'_, F>,
        emitter: &Emitter,
        answers: &mut Answers<F>,
    ) -> Result<(), Error> {
        self.against(receivers, emitter, Goal::plain(false), answers)
    }

    /// Radiosity and gradient.
    pub fn radiosity_and_gradient<F: Precision>(
        &self,
        receivers: &Receivers<'_, F>,
        emitter: &Emitter,
        answers: &mut Answers<F>,
    ) -> Result<(), Error> {
        self.against(receivers, emitter, Goal::plain(true), answers)
    }

    /// Radiosity and gradient to a relative tolerance
    pub fn evaluate_to<F: Precision>(
        &self,
        receivers: &Receivers<'_, F>,
        emitter: &Emitter,
        tolerance: f64,
        answers: &mut Answers<F>,
    ) -> Result<(), Error> {
        self.against(receivers, emitter, Goal::within(tolerance, true)?, answers)
    }

    fn against<F: Precision>(
        &self,
        receivers: &Receivers<'_, F>,
        emitter: &Emitter,
        goal: Goal,
        answers: &mut Answers<F>,
    ) -> Result<(), Error> {
        let job = OneEmitter::new(*receivers, emitter, goal, self.level);
        let slots = answers.sized(receivers.count(), goal.asked);
        answers.counts = tile::run(self.threads, 0, slots, &|start, slots| job.tile(start, slots))?;
        Ok(())
    }
}

/// The instruction sets of this machine, best first.
fn levels() -> Vec<Level> {
    let best = Level::new();
    let mut levels = vec![best];
    #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
    {
        use fearless_simd::Simd;
        levels.extend(best.as_avx512().map(Simd::level));
        levels.extend(best.as_avx2().map(Simd::level));
        levels.extend(best.as_sse4_2().map(Simd::level));
        levels.extend(best.as_sse2().map(Simd::level));
        levels.remove(0);
    }
    levels
}
