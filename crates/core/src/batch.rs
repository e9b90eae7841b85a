//! Many receivers against one emitter, or one receiver against many emitters, on the vector units of the machine.
//!
//! The closed form of a constant emitter (HS95 Eqs. 10, 11 and A.1, in the form of `batch::edge`) or of a linear one
//! (`batch::linear`), with the receiver's horizon, several answers at a time: as many as a vector of the instruction set
//! holds, found at run time. Each lane carries the bound derived in `batch::bound`; a lane whose bound is above the tolerance,
//! or that cannot tell on which side of a plane it is, is answered again by the scalar path, so that a batch's answers are as
//! certain as those. Polynomial emitters take the scalar path altogether.
//!
//! - [`Engine`] says how: which instruction set, one thread or all. All instruction sets give the same digits (no fused
//!   multiply-add), and an answer does not depend on its neighbours.
//! - [`Receivers`] and [`Emitters`] are structures of arrays; [`Answers`] holds the results, [`Counts`] by which way they came.
//! - [`EmitterTree`] sums the light of very many emitters at each receiver, within an absolute error: nodes of the tree that are
//!   below the horizon, face away or are too weak are left out, far ones are answered as one, and the bound includes all of that;
//!   [`Tally`] counts each kind.
//! - In single precision twice as many lanes fit; those that cancel are done again in double precision, and those of a linear
//!   emitter are done in it from the start.
//!
//! In short: `Engine::{new, all, threads}` and, on it, `radiosity`, `radiosity_and_gradient`, `radiosity_to`, `evaluate_to` (many
//! receivers, one emitter), `radiosity_occluded`, `evaluate_occluded` (the same with occluders), `each`, `each_to` (one receiver,
//! many emitters), `total` (many of both, summed), `derivatives` (many receivers, one emitter).
//!
//! Digits are lost as by [`crate::radiosity`]: about `log10 D/s` of them at distance D for size s, of a linear emitter three
//! times as many. The bound is some 30 (value) to 60 times (gradient) the error found, a linear emitter's some thousand times.
//!
//! ```
//! use radgrad_core::batch::{Answers, Engine, Receivers};
//! use radgrad_core::{DVec3, Emission, Emitter, Polygon};
//! let corners = [(0.0, 0.0), (0.0, 1.0), (1.0, 1.0), (1.0, 0.0)].map(|(x, y)| DVec3::new(x, y, 1.0));
//! let lamp = Emitter::new(Polygon::new(corners.to_vec())?, Emission::Constant(1.0))?;
//! let x: Vec<f64> = (0..1000).map(|i| f64::from(i) * 0.001).collect();
//! let (zero, one) = (vec![0.0; 1000], vec![1.0; 1000]);
//! let floor = Receivers::new([&x, &zero, &zero], [&zero, &zero, &one], &[0.8])?;
//! let mut answers = Answers::new();
//! Engine::new().evaluate_to(&floor, &lamp, 1e-10, &mut answers)?;
//! assert!(answers.radiosity_error[500] <= 1e-10 * answers.radiosity[500]);
//! assert!(answers.gradient[0][0] > 0.0, "towards the middle of the lamp it is brighter");
//! assert_eq!(answers.counts.whole, 1000);
//! # Ok::<(), radgrad_core::Error>(())
//! ```

mod answers;
mod bound;
mod cluster;
mod derivatives;
mod edge;
mod emitter_tree;
mod emitters;
mod emitting;
mod far_field;
mod lamps;
mod linear;
mod many_emitters;
mod one_emitter;
mod receivers;
mod shapes;
mod span;
mod sums;
mod tile;
mod total;
mod visible;

use std::fmt;

use fearless_simd::Level;
use radgrad_numbers::lanes::instruction_set;
use radgrad_numbers::lanes::lane::Lane;

pub use answers::{Answers, Counts};
pub use emitter_tree::EmitterTree;
pub use emitters::Emitters;
pub use receivers::Receivers;
pub use total::Tally;

use crate::batch::emitters::OneReceiver;
use crate::batch::one_emitter::{LinearOnLanes, Occluders, OnLanes, OneEmitter};
use crate::batch::tile::Goal;
use crate::batch::total::TreeWalk;
use crate::error::Error;
use crate::problem::emission::Emitter;
use crate::problem::polygon::Polygon;
use crate::problem::receiver::Receiver;

/// Single or double precision: `f32` or `f64`.
///
/// ```
/// use radgrad_core::batch::{Answers, Engine, Precision, Receivers};
/// use radgrad_core::{DVec3, Emission, Emitter, Error, Polygon};
/// fn at_origin<F: Precision + From<f32>>(lamp: &Emitter) -> Result<F, Error> {
///     let (zero, one) = ([F::from(0.0)], [F::from(1.0)]);
///     let mut answers = Answers::new();
///     Engine::new().radiosity(&Receivers::new([&zero; 3], [&zero, &zero, &one], &one)?, lamp, &mut answers)?;
///     Ok(answers.radiosity[0])
/// }
/// let corners = [(0.0, 0.0), (0.0, 1.0), (1.0, 1.0), (1.0, 0.0)].map(|(x, y)| DVec3::new(x, y, 1.0));
/// let lamp = Emitter::new(Polygon::new(corners.to_vec())?, Emission::Constant(1.0))?;
/// assert!((at_origin::<f32>(&lamp)? - 0.138_531_6).abs() < 1e-6);
/// assert!((at_origin::<f64>(&lamp)? - 0.138_531_605_994_893).abs() < 1e-6 * 0.138);
/// # Ok::<(), radgrad_core::Error>(())
/// ```
#[allow(private_bounds, reason = "what lanes need of a number is not for others to implement")]
pub trait Precision: Lane + Compiled {}

/// The kernels of one precision, compiled once here: generic functions are compiled again in every crate that calls them.
trait Compiled: LinearOnLanes {
    /// An emitter as lanes take it.
    fn on_lanes(emitter: &Emitter) -> OnLanes<Self>;

    /// Many receivers against one emitter, with occluders.
    fn against(
        engine: &Engine,
        receivers: &Receivers<'_, Self>,
        emitter: (&Emitter, &OnLanes<Self>, &[&Polygon]),
        goal: Goal,
        answers: &mut Answers<Self>,
    ) -> Result<(), Error>;

    /// One receiver against many emitters.
    fn seen_from(
        engine: &Engine,
        receiver: &Receiver,
        emitters: &Emitters<'_, Self>,
        goal: Goal,
        answers: &mut Answers<Self>,
    ) -> Result<(), Error>;
}

macro_rules! compiled {
    ($precision:ty) => {
        impl Precision for $precision {}

        impl Compiled for $precision {
            #[inline(never)]
            fn on_lanes(emitter: &Emitter) -> OnLanes<Self> {
                OnLanes::new(emitter)
            }

            #[inline(never)]
            fn against(
                engine: &Engine,
                receivers: &Receivers<'_, Self>,
                (emitter, on_lanes, occluders): (&Emitter, &OnLanes<Self>, &[&Polygon]),
                goal: Goal,
                answers: &mut Answers<Self>,
            ) -> Result<(), Error> {
                let occluders = Occluders::new(occluders, emitter);
                let job = OneEmitter { receivers: *receivers, emitter, occluders, on_lanes, goal, level: engine.level };
                let slots = answers.sized(receivers.count(), goal.asked);
                answers.counts = tile::run(engine.threads, 0, slots, &|start, slots| job.tile(start, slots))?;
                Ok(())
            }

            #[inline(never)]
            fn seen_from(
                engine: &Engine,
                receiver: &Receiver,
                emitters: &Emitters<'_, Self>,
                goal: Goal,
                answers: &mut Answers<Self>,
            ) -> Result<(), Error> {
                answers.counts = OneReceiver::new(receiver, emitters, goal, engine.level).answer_all(engine.threads, answers)?;
                Ok(())
            }
        }
    };
}

compiled!(f32);
compiled!(f64);

/// An emitter that is ready for batches in one precision. Each call of [`Engine`] makes that ready for itself, and allocates the outline
/// for it; with this, and [`Answers`] that were as long before, it allocates nothing, as
/// [`Engine::evaluate_ready`] says.
///
/// ```
/// # use radgrad_core::{DVec3, Emission, Emitter, Polygon};
/// use radgrad_core::batch::ReadyEmitter;
/// # let corners = [(0.0, 0.0), (0.0, 1.0), (1.0, 1.0), (1.0, 0.0)].map(|(x, y)| DVec3::new(x, y, 1.0));
/// let lamp = Emitter::new(Polygon::new(corners.to_vec())?, Emission::Constant(1.0))?;
/// let ready = ReadyEmitter::<f32>::new(lamp.clone());
/// assert_eq!(ready.emitter(), &lamp);
/// # Ok::<(), radgrad_core::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct ReadyEmitter<F> {
    emitter: Emitter,
    on_lanes: OnLanes<F>,
}

impl<F: Precision> ReadyEmitter<F> {
    /// Makes it ready.
    ///
    /// ```
    /// # use radgrad_core::{DVec3, Emission, Emitter, Polygon};
    /// # use radgrad_core::batch::ReadyEmitter;
    /// let triangle = Polygon::new(vec![DVec3::ZERO, DVec3::Y, DVec3::X])?;
    /// let ready = ReadyEmitter::<f64>::new(Emitter::new(triangle, Emission::Constant(1.0))?);
    /// # Ok::<(), radgrad_core::Error>(())
    /// ```
    #[must_use]
    pub fn new(emitter: Emitter) -> Self {
        let on_lanes = F::on_lanes(&emitter);
        Self { emitter, on_lanes }
    }

    /// The emitter.
    ///
    /// ```
    /// # use radgrad_core::{DVec3, Emission, Emitter, Polygon};
    /// # use radgrad_core::batch::ReadyEmitter;
    /// # let triangle = Polygon::new(vec![DVec3::ZERO, DVec3::Y, DVec3::X])?;
    /// let ready = ReadyEmitter::<f64>::new(Emitter::new(triangle, Emission::Constant(1.0))?);
    /// assert_eq!(ready.emitter().polygon().area(), 0.5);
    /// # Ok::<(), radgrad_core::Error>(())
    /// ```
    #[must_use]
    pub const fn emitter(&self) -> &Emitter {
        &self.emitter
    }
}

/// How batches run: on which instruction set, on one thread or all.
///
/// The methods without a tolerance leave out the arrays of bounds. A lane is then taken where its bound is below 1e-6 of the
/// value and of the gradient's norm (in single precision below 3e-5 and 1e-4: errors are found to be below 1e-6 and 1.2e-6); any
/// other entry has the digits of [`crate::radiosity_and_gradient`].
///
/// ```
/// use radgrad_core::batch::{Answers, Engine, Receivers};
/// // A square lamp of side 1 over two receivers: a length under its corner, and under its middle.
/// # use radgrad_core::{DVec3, Emission, Emitter, Polygon};
/// # let corners = [(0.0, 0.0), (0.0, 1.0), (1.0, 1.0), (1.0, 0.0)].map(|(x, y)| DVec3::new(x, y, 1.0));
/// # let lamp = Emitter::new(Polygon::new(corners.to_vec())?, Emission::Constant(1.0))?;
/// # let (x, zero, one) = ([0.0, 0.5], [0.0_f64; 2], [1.0; 2]);
/// # let floor = Receivers::new([&x, &x, &zero], [&zero, &zero, &one], &[1.0])?; // under a corner and under the middle
///
/// let mut answers = Answers::new();
/// Engine::new().threads().radiosity(&floor, &lamp, &mut answers)?;
/// assert!((answers.radiosity[0] - 0.138_531_605_994_893).abs() < 1e-6 * 0.138);
/// assert!(answers.gradient[0].is_empty()); // it was not requested
/// # Ok::<(), radgrad_core::Error>(())
/// ```
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

impl fmt::Display for Engine {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(instruction_set::name(self.level))?;
        f.write_str(if self.threads { " on all threads" } else { "" })
    }
}

impl Engine {
    /// The best instruction set of this machine, on one thread.
    ///
    /// ```
    /// # use radgrad_core::batch::Engine;
    /// assert_eq!(Engine::new().to_string(), Engine::all()[0].to_string());
    /// ```
    #[must_use]
    pub fn new() -> Self {
        Self { level: Level::new(), threads: false }
    }

    /// One engine for each instruction set of this machine, best first.
    ///
    /// ```
    /// use radgrad_core::batch::{Answers, Engine, Receivers};
    /// // A square lamp of side 1 over two receivers: a length under its corner, and under its middle.
    /// # use radgrad_core::{DVec3, Emission, Emitter, Polygon};
    /// # let corners = [(0.0, 0.0), (0.0, 1.0), (1.0, 1.0), (1.0, 0.0)].map(|(x, y)| DVec3::new(x, y, 1.0));
    /// # let lamp = Emitter::new(Polygon::new(corners.to_vec())?, Emission::Constant(1.0))?;
    /// # let (x, zero, one) = ([0.0, 0.5], [0.0_f64; 2], [1.0; 2]);
    /// # let floor = Receivers::new([&x, &x, &zero], [&zero, &zero, &one], &[1.0])?; // under a corner and under the middle
    ///
    /// for engine in Engine::all() {
    ///     let (mut best, mut other) = (Answers::new(), Answers::new());
    ///     Engine::new().radiosity(&floor, &lamp, &mut best)?;
    ///     engine.radiosity(&floor, &lamp, &mut other)?;
    ///     assert_eq!(best, other, "{engine} gives other digits");
    /// }
    /// # Ok::<(), radgrad_core::Error>(())
    /// ```
    #[must_use]
    pub fn all() -> Vec<Self> {
        instruction_set::instruction_sets().into_iter().map(|level| Self { level, threads: false }).collect()
    }

    /// The same on all threads of rayon's pool, where the crate is built with the feature `threads`.
    ///
    /// ```
    /// # use radgrad_core::batch::Engine;
    /// let engine = Engine::new().threads();
    /// assert_eq!(engine.to_string(), format!("{} on all threads", Engine::new()));
    /// ```
    #[must_use]
    pub const fn threads(self) -> Self {
        Self { threads: true, ..self }
    }

    /// Radiosity of each receiver alone.
    ///
    /// ```
    /// use radgrad_core::batch::{Answers, Engine, Receivers};
    /// // A square lamp of side 1 over two receivers: a length under its corner, and under its middle.
    /// # use radgrad_core::{DVec3, Emission, Emitter, Polygon};
    /// # let corners = [(0.0, 0.0), (0.0, 1.0), (1.0, 1.0), (1.0, 0.0)].map(|(x, y)| DVec3::new(x, y, 1.0));
    /// # let lamp = Emitter::new(Polygon::new(corners.to_vec())?, Emission::Constant(1.0))?;
    /// # let (x, zero, one) = ([0.0, 0.5], [0.0_f64; 2], [1.0; 2]);
    /// # let floor = Receivers::new([&x, &x, &zero], [&zero, &zero, &one], &[1.0])?; // under a corner and under the middle
    ///
    /// let mut answers = Answers::new();
    /// Engine::new().radiosity(&floor, &lamp, &mut answers)?;
    /// assert!(answers.radiosity[1] > 1.5 * answers.radiosity[0]);
    /// # Ok::<(), radgrad_core::Error>(())
    /// ```
    ///
    /// # Errors
    /// If a result overflows: [`Error::InBatch`] with the receiver's index.
    pub fn radiosity<F: Precision>(
        &self,
        receivers: &Receivers<'_, F>,
        emitter: &Emitter,
        answers: &mut Answers<F>,
    ) -> Result<(), Error> {
        F::against(self, receivers, (emitter, &F::on_lanes(emitter), &[]), Goal::plain::<F>(false), answers)
    }

    /// Radiosity and gradient at each receiver.
    ///
    /// ```
    /// use radgrad_core::batch::{Answers, Engine, Receivers};
    /// // A square lamp of side 1 over two receivers: a length under its corner, and under its middle.
    /// # use radgrad_core::{DVec3, Emission, Emitter, Polygon};
    /// # let corners = [(0.0, 0.0), (0.0, 1.0), (1.0, 1.0), (1.0, 0.0)].map(|(x, y)| DVec3::new(x, y, 1.0));
    /// # let lamp = Emitter::new(Polygon::new(corners.to_vec())?, Emission::Constant(1.0))?;
    /// # let (x, zero, one) = ([0.0, 0.5], [0.0_f64; 2], [1.0; 2]);
    /// # let floor = Receivers::new([&x, &x, &zero], [&zero, &zero, &one], &[1.0])?; // under a corner and under the middle
    ///
    /// let mut answers = Answers::new();
    /// Engine::new().radiosity_and_gradient(&floor, &lamp, &mut answers)?;
    /// let [x, y, _] = &answers.gradient;
    /// assert!(x[0] > 0.1 && (x[0] - y[0]).abs() < 1e-6, "from the corner towards the middle it gets brighter");
    /// # Ok::<(), radgrad_core::Error>(())
    /// ```
    ///
    /// # Errors
    /// If a result overflows: [`Error::InBatch`] with the receiver's index.
    pub fn radiosity_and_gradient<F: Precision>(
        &self,
        receivers: &Receivers<'_, F>,
        emitter: &Emitter,
        answers: &mut Answers<F>,
    ) -> Result<(), Error> {
        F::against(self, receivers, (emitter, &F::on_lanes(emitter), &[]), Goal::plain::<F>(true), answers)
    }

    /// Radiosity of each receiver with its bound, to a relative tolerance as of [`crate::evaluate::evaluate_to`].
    ///
    /// ```
    /// use radgrad_core::batch::{Answers, Engine, Receivers};
    /// // A square lamp of side 1 over two receivers: a length under its corner, and under its middle.
    /// # use radgrad_core::{DVec3, Emission, Emitter, Polygon};
    /// # let corners = [(0.0, 0.0), (0.0, 1.0), (1.0, 1.0), (1.0, 0.0)].map(|(x, y)| DVec3::new(x, y, 1.0));
    /// # let lamp = Emitter::new(Polygon::new(corners.to_vec())?, Emission::Constant(1.0))?;
    /// # let (x, zero, one) = ([0.0, 0.5], [0.0_f64; 2], [1.0; 2]);
    /// # let floor = Receivers::new([&x, &x, &zero], [&zero, &zero, &one], &[1.0])?; // under a corner and under the middle
    ///
    /// let mut answers = Answers::new();
    /// Engine::new().radiosity_to(&floor, &lamp, 1e-12, &mut answers)?;
    /// assert!((answers.radiosity[0] - 0.138_531_605_994_892_996_78).abs() <= answers.radiosity_error[0] + 1e-17);
    /// assert!(answers.radiosity_error[0] <= 1e-12 * answers.radiosity[0]);
    /// # Ok::<(), radgrad_core::Error>(())
    /// ```
    ///
    /// # Errors
    /// If a result overflows, or the tolerance is not in [0, 1].
    pub fn radiosity_to<F: Precision>(
        &self,
        receivers: &Receivers<'_, F>,
        emitter: &Emitter,
        tolerance: f64,
        answers: &mut Answers<F>,
    ) -> Result<(), Error> {
        F::against(self, receivers, (emitter, &F::on_lanes(emitter), &[]), Goal::within(tolerance, false)?, answers)
    }

    /// Radiosity and gradient at each receiver with their bounds, to a relative tolerance as of [`crate::evaluate::evaluate_to`].
    /// In single precision the bounds count the rounding of the results, so that nothing meets a tolerance below 1e-7.
    ///
    /// ```
    /// use radgrad_core::batch::{Answers, Engine, Receivers};
    /// // A square lamp of side 1 over two receivers: a length under its corner, and under its middle.
    /// # use radgrad_core::{DVec3, Emission, Emitter, Polygon};
    /// # let corners = [(0.0, 0.0), (0.0, 1.0), (1.0, 1.0), (1.0, 0.0)].map(|(x, y)| DVec3::new(x, y, 1.0));
    /// # let lamp = Emitter::new(Polygon::new(corners.to_vec())?, Emission::Constant(1.0))?;
    /// # let (x, zero, one) = ([0.0, 0.5], [0.0_f64; 2], [1.0; 2]);
    /// # let floor = Receivers::new([&x, &x, &zero], [&zero, &zero, &one], &[1.0])?; // under a corner and under the middle
    ///
    /// let mut answers = Answers::new();
    /// Engine::new().evaluate_to(&floor, &lamp, 1e-10, &mut answers)?;
    /// let slope = DVec3::from(answers.gradient.each_ref().map(|component| component[0]));
    /// assert!(answers.gradient_error[0] <= 1e-10 * slope.length());
    /// # Ok::<(), radgrad_core::Error>(())
    /// ```
    ///
    /// # Errors
    /// If a result overflows, or the tolerance is not in [0, 1].
    pub fn evaluate_to<F: Precision>(
        &self,
        receivers: &Receivers<'_, F>,
        emitter: &Emitter,
        tolerance: f64,
        answers: &mut Answers<F>,
    ) -> Result<(), Error> {
        F::against(self, receivers, (emitter, &F::on_lanes(emitter), &[]), Goal::within(tolerance, true)?, answers)
    }

    /// [`Self::evaluate_to`] of an emitter that is ready: the same digits. On one thread, and where a closed form or a Gauss rule answers,
    /// it allocates only if `answers` were never so long, or if the horizon leaves more than twelve corners of the emitter.
    ///
    /// ```
    /// use radgrad_core::batch::{Answers, Engine, ReadyEmitter, Receivers};
    /// # use radgrad_core::{DVec3, Emission, Emitter, Polygon};
    /// # let corners = [(0.0, 0.0), (0.0, 1.0), (1.0, 1.0), (1.0, 0.0)].map(|(x, y)| DVec3::new(x, y, 1.0));
    /// # let lamp = Emitter::new(Polygon::new(corners.to_vec())?, Emission::Constant(1.0))?;
    /// # let (x, zero, one) = ([0.0, 0.5], [0.0_f64; 2], [1.0; 2]);
    /// # let floor = Receivers::new([&x, &x, &zero], [&zero, &zero, &one], &[1.0])?;
    /// let (mut ready, mut other) = (Answers::new(), Answers::new());
    /// Engine::new().evaluate_ready(&floor, &ReadyEmitter::new(lamp.clone()), 1e-10, &mut ready)?;
    /// Engine::new().evaluate_to(&floor, &lamp, 1e-10, &mut other)?;
    /// assert_eq!(ready, other);
    /// # Ok::<(), radgrad_core::Error>(())
    /// ```
    ///
    /// # Errors
    /// As of [`Self::evaluate_to`].
    pub fn evaluate_ready<F: Precision>(
        &self,
        receivers: &Receivers<'_, F>,
        emitter: &ReadyEmitter<F>,
        tolerance: f64,
        answers: &mut Answers<F>,
    ) -> Result<(), Error> {
        let ReadyEmitter { emitter, on_lanes } = emitter;
        F::against(self, receivers, (emitter, on_lanes, &[]), Goal::within(tolerance, true)?, answers)
    }

    /// Radiosity of each receiver and its bound, with occluders, to a relative tolerance.
    ///
    /// This is [`Self::evaluate_occluded`] without the gradient. Where a shadow's edge is seen in line with another edge it is
    /// much cheaper.
    ///
    /// ```
    /// use radgrad_core::batch::{Answers, Engine, Receivers};
    /// # use radgrad_core::{DVec3, Emission, Emitter, Polygon};
    /// # let square = |x: f64, z: f64| {
    /// #     Polygon::new([(0.0, 0.0), (0.0, 1.0), (1.0, 1.0), (1.0, 0.0)].map(|(u, y)| DVec3::new(x + u, y, z)).to_vec())
    /// # };
    /// # let (x, zero, one) = ([0.0, 0.5], [0.0_f64; 2], [1.0; 2]);
    /// # let floor = Receivers::new([&x, &x, &zero], [&zero, &zero, &one], &[1.0])?;
    /// let lamp = Emitter::new(square(0.0, 1.0)?, Emission::Constant(1.0))?; // over the floor, and half way down
    /// let screen = square(0.0, 0.5)?; // a square below it, which hides all of it from under its middle
    /// let mut answers = Answers::new();
    /// Engine::new().radiosity_occluded(&floor, &lamp, &[&screen], 1e-10, &mut answers)?;
    /// assert!(answers.radiosity[0] + answers.radiosity_error[0] < 1e-12 && answers.radiosity[1] == 0.0);
    /// # Ok::<(), radgrad_core::Error>(())
    /// ```
    ///
    /// # Errors
    /// If a result overflows, or the tolerance is not in [0, 1].
    pub fn radiosity_occluded<F: Precision>(
        &self,
        receivers: &Receivers<'_, F>,
        emitter: &Emitter,
        occluders: &[&Polygon],
        tolerance: f64,
        answers: &mut Answers<F>,
    ) -> Result<(), Error> {
        let on_lanes = F::on_lanes(emitter);
        F::against(self, receivers, (emitter, &on_lanes, occluders), Goal::within(tolerance, false)?, answers)
    }

    /// Radiosity and gradient at each receiver and their bounds, with occluders, to a relative tolerance.
    ///
    /// Where spheres around the emitter and each occluder, seen from a receiver, prove that none hides anything, the lanes answer, with the digits
    /// of [`Self::evaluate_to`]; the other receivers have the answers of [`crate::evaluate_to`]. Each receiver looks at each occluder, some 5 ns:
    /// of a scene, give those that are between the receivers and the emitter.
    ///
    /// ```
    /// use radgrad_core::batch::{Answers, Engine, Receivers};
    /// # use radgrad_core::{DVec3, Emission, Emitter, Polygon};
    /// # let square = |x: f64, z: f64| {
    /// #     Polygon::new([(0.0, 0.0), (0.0, 1.0), (1.0, 1.0), (1.0, 0.0)].map(|(u, y)| DVec3::new(x + u, y, z)).to_vec())
    /// # };
    /// # let (x, zero, one) = ([0.0, 0.5], [0.0_f64; 2], [1.0; 2]);
    /// # let floor = Receivers::new([&x, &x, &zero], [&zero, &zero, &one], &[1.0])?;
    /// let lamp = Emitter::new(square(0.0, 1.0)?, Emission::Constant(1.0))?;
    /// let screen = square(5.0, 0.5)?; // beside the lamp: it hides nothing
    /// let (mut past, mut free) = (Answers::new(), Answers::new());
    /// Engine::new().evaluate_occluded(&floor, &lamp, &[&screen], 1e-10, &mut past)?;
    /// Engine::new().evaluate_to(&floor, &lamp, 1e-10, &mut free)?;
    /// assert_eq!(past, free);
    /// # Ok::<(), radgrad_core::Error>(())
    /// ```
    ///
    /// # Errors
    /// If a result overflows, or the tolerance is not in [0, 1].
    pub fn evaluate_occluded<F: Precision>(
        &self,
        receivers: &Receivers<'_, F>,
        emitter: &Emitter,
        occluders: &[&Polygon],
        tolerance: f64,
        answers: &mut Answers<F>,
    ) -> Result<(), Error> {
        let on_lanes = F::on_lanes(emitter);
        F::against(self, receivers, (emitter, &on_lanes, occluders), Goal::within(tolerance, true)?, answers)
    }

    /// Radiosity and gradient due to each emitter, in the emitters' order.
    ///
    /// ```
    /// use radgrad_core::batch::{Answers, Emitters, Engine};
    /// // A square lamp of side 1, a length over the floor, with a corner at x.
    /// # use radgrad_core::{DVec3, Emission, Emitter, Polygon, Receiver};
    /// # let lamp = |x: f64| {
    /// #     let corners = [(0.0, 0.0), (0.0, 1.0), (1.0, 1.0), (1.0, 0.0)].map(|(u, y)| DVec3::new(x + u, y, 1.0));
    /// #     Emitter::new(Polygon::new(corners.to_vec())?, Emission::Constant(1.0))
    /// # };
    ///
    /// let lamps = [lamp(0.0)?, lamp(5.0)?];
    /// let mut answers = Answers::new();
    /// Engine::new().each(&Receiver::new(DVec3::ZERO, DVec3::Z, 1.0)?, &Emitters::<f64>::new(&lamps), &mut answers)?;
    /// assert!((answers.radiosity[0] - 0.138_531_605_994_893).abs() < 1e-6 * 0.138);
    /// assert!(answers.radiosity[1] < 0.01);
    /// # Ok::<(), radgrad_core::Error>(())
    /// ```
    ///
    /// # Errors
    /// If a result overflows: [`Error::InBatch`] with the emitter's index.
    pub fn each<F: Precision>(
        &self,
        receiver: &Receiver,
        emitters: &Emitters<'_, F>,
        answers: &mut Answers<F>,
    ) -> Result<(), Error> {
        F::seen_from(self, receiver, emitters, Goal::plain::<F>(true), answers)
    }

    /// The same with bounds, to a relative tolerance for each emitter.
    ///
    /// ```
    /// use radgrad_core::batch::{Answers, Emitters, Engine};
    /// // A square lamp of side 1, a length over the floor, with a corner at x.
    /// # use radgrad_core::{DVec3, Emission, Emitter, Polygon, Receiver};
    /// # let lamp = |x: f64| {
    /// #     let corners = [(0.0, 0.0), (0.0, 1.0), (1.0, 1.0), (1.0, 0.0)].map(|(u, y)| DVec3::new(x + u, y, 1.0));
    /// #     Emitter::new(Polygon::new(corners.to_vec())?, Emission::Constant(1.0))
    /// # };
    ///
    /// let lamps = [lamp(0.0)?, lamp(5.0)?];
    /// let mut answers = Answers::new();
    /// Engine::new().each_to(&Receiver::new(DVec3::ZERO, DVec3::Z, 1.0)?, &Emitters::<f64>::new(&lamps), 1e-10, &mut answers)?;
    /// assert!(answers.radiosity_error.iter().zip(&answers.radiosity).all(|(error, value)| *error <= 1e-10 * value));
    /// # Ok::<(), radgrad_core::Error>(())
    /// ```
    ///
    /// # Errors
    /// If a result overflows, or the tolerance is not in [0, 1].
    pub fn each_to<F: Precision>(
        &self,
        receiver: &Receiver,
        emitters: &Emitters<'_, F>,
        tolerance: f64,
        answers: &mut Answers<F>,
    ) -> Result<(), Error> {
        F::seen_from(self, receiver, emitters, Goal::within(tolerance, true)?, answers)
    }

    /// Radiosity of each receiver due to all emitters of a tree together, within an absolute tolerance in the unit of the
    /// emission.
    ///
    /// The bounds include the neglected nodes, the errors of far fields, and all rounding. A tolerance below the rounding of double
    /// precision is not an error: the bounds are then above it.
    ///
    /// ```
    /// use radgrad_core::batch::{Answers, EmitterTree, Engine, Receivers};
    /// use radgrad_core::{DVec3, Emission, Emitter, Polygon};
    /// let cell = |i: u32| {
    ///     let (x, y) = (f64::from(i % 50) * 0.02, f64::from(i / 50) * 0.02);
    ///     let corners = [(0.0, 0.0), (0.0, 0.02), (0.02, 0.02), (0.02, 0.0)].map(|(u, v)| DVec3::new(x + u, y + v, 1.0));
    ///     Emitter::new(Polygon::new(corners.to_vec())?, Emission::Constant(1.0))
    /// };
    /// let ceiling = (0..2500).map(cell).collect::<Result<Vec<_>, _>>()?;
    /// let tree = EmitterTree::new(&ceiling);
    /// let corner = Receivers::new([&[0.0], &[0.0], &[0.0]], [&[0.0], &[0.0], &[1.0]], &[1.0])?;
    /// let mut answers = Answers::new();
    /// let tally = Engine::new().total(&corner, &tree, 1e-5, &mut answers)?;
    /// assert!((answers.radiosity[0] - 0.138_531_605_994_893).abs() <= 1e-5);
    /// assert!(tally.alone + tally.far_fields < 500);
    /// # Ok::<(), radgrad_core::Error>(())
    /// ```
    ///
    /// # Errors
    /// If a result overflows, or the tolerance is not a positive number.
    pub fn total(
        &self,
        receivers: &Receivers<'_, f64>,
        tree: &EmitterTree<'_>,
        tolerance: f64,
        answers: &mut Answers<f64>,
    ) -> Result<Tally, Error> {
        if !(tolerance > 0.0 && tolerance.is_finite()) {
            return Err(Error::AbsoluteTolerance { value: tolerance });
        }
        let job = TreeWalk { receivers: *receivers, tree, tolerance, level: self.level };
        answers.counts = Counts::default();
        let slots = answers.sized(receivers.count(), Goal::absolute(tolerance).asked);
        tile::run(self.threads, 0, slots, &|start, slots| job.tile(start, slots))
    }
}
