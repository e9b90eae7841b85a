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
mod engine;
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

use radgrad_numbers::lanes::lane::Lane;

pub use answers::{Answers, Counts};
pub use emitter_tree::EmitterTree;
pub use emitters::Emitters;
pub use engine::Engine;
pub use receivers::Receivers;
pub use total::Tally;

use crate::batch::emitters::OneReceiver;
use crate::batch::one_emitter::{LinearOnLanes, Occluders, OnLanes, OneEmitter};
use crate::batch::tile::Goal;
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
