//! A stretch of a batch: lanes settle most entries, and the scalar path answers the rest.

use std::ops::AddAssign;

use fearless_simd::Simd;
use glam::DVec3;
use radgrad_numbers::lanes::lane::{Lane, Lanes, MOST_LANES, Mask, constant};
use radgrad_numbers::number::ROUNDOFF;

use crate::batch::answers::{Asked, Counts, Slots};
use crate::batch::visible::VisibleSums;
use crate::error::Error;
use crate::evaluate::{evaluate_to, evaluate_value, radiosity, radiosity_and_gradient};
use crate::ladder;
use crate::ladder::answer::{Answer, Method, Value};
use crate::problem::emission::Emitter;
use crate::problem::polygon::Polygon;
use crate::problem::receiver::Receiver;

/// Entries of a tile.
pub(super) const TILE: usize = Entries::BITS as usize;

/// The quantities asked of a batch, and their relative tolerances.
#[derive(Debug, Clone, Copy)]
pub(super) struct Goal {
    pub(super) asked: Asked,
    pub(super) tolerance: Tolerance,
}

/// Bounds up to which a lane is taken, relative but for an absolute part that the value is allowed besides.
#[derive(Debug, Clone, Copy)]
pub(super) struct Tolerance {
    pub(super) value: f64,
    pub(super) absolute: f64,
    pub(super) gradient: f64,
}

/// The tolerance of double precision where none is given. Beyond, the scalar path has more digits.
const DOUBLE: Tolerance = Tolerance { value: 1e-6, absolute: 0.0, gradient: 1e-6 };

/// The tolerance of single precision where none is given. Errors are a thirtieth of the bound on the value at most, and an eightieth
/// of that on the gradient (measured: `tests/all/batch.rs`).
const SINGLE: Tolerance = Tolerance { value: 3e-5, absolute: 0.0, gradient: 1e-4 };

impl Goal {
    /// Without bounds.
    pub(super) const fn plain<F: Lane>(gradient: bool) -> Self {
        Self { asked: Asked { gradient, errors: false, methods: false }, tolerance: if F::IS_SINGLE { SINGLE } else { DOUBLE } }
    }

    /// The value alone, with its bound, to an absolute tolerance.
    pub(super) const fn absolute(tolerance: f64) -> Self {
        let tolerance = Tolerance { value: 0.0, absolute: tolerance, gradient: 0.0 };
        Self { asked: Asked { gradient: false, errors: true, methods: false }, tolerance }
    }

    /// The same in double precision, for entries that single precision did not settle.
    pub(super) fn doubled(self) -> Self {
        if self.asked.errors { self } else { Self::plain::<f64>(self.asked.gradient) }
    }

    /// Value or both, with bounds, to a relative tolerance.
    pub(super) fn within(tolerance: f64, gradient: bool) -> Result<Self, Error> {
        if (0.0..=1.0).contains(&tolerance) {
            Ok(Self {
                asked: Asked { gradient, errors: true, methods: true },
                tolerance: Tolerance { value: tolerance, absolute: 0.0, gradient: tolerance },
            })
        } else {
            Err(Error::Tolerance { value: tolerance })
        }
    }

    /// An entry that lanes did not settle, on the scalar path. Occluders are for those with bounds.
    #[cold]
    pub(super) fn single(&self, receiver: &Receiver, emitter: &Emitter, occluders: &[&Polygon]) -> Result<Answer, Error> {
        let past = || occluders.iter().copied();
        if self.asked.errors && !self.asked.gradient {
            let tolerance = ladder::answer::Tolerance { relative: self.tolerance.value, absolute: self.tolerance.absolute };
            let Value { radiosity, radiosity_error, method } = evaluate_value(receiver, emitter, past(), tolerance)?;
            return Ok(Answer { radiosity, radiosity_error, method, ..Answer::ZERO });
        }
        if self.asked.errors {
            return evaluate_to(receiver, emitter, past(), self.tolerance.value);
        }
        let plain = |radiosity, gradient| Answer { radiosity, gradient, method: Method::ClosedForm, ..Answer::ZERO };
        if self.asked.gradient {
            radiosity_and_gradient(receiver, emitter).map(|(radiosity, gradient)| plain(radiosity, gradient))
        } else {
            radiosity(receiver, emitter).map(|radiosity| plain(radiosity, DVec3::ZERO))
        }
    }
}

/// Entries of a tile, as bits.
pub(super) type Entries = u128;

/// The entries of a tile that lanes settled.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Settled {
    /// Entries that see nothing.
    pub(super) zero: Entries,
    /// Entries answered, and those among them cut by the horizon.
    pub(super) good: Entries,
    pub(super) clipped: Entries,
}

impl Settled {
    /// Entries of a tile of this length that are not settled.
    pub(super) fn open(&self, length: usize) -> Entries {
        !(self.zero | self.good) & (Entries::MAX >> (TILE - length))
    }

    /// The same of the first `count` entries only.
    pub(super) fn first(self, count: usize) -> Self {
        let first = Entries::MAX >> (TILE - count);
        Self { zero: self.zero & first, good: self.good & first, clipped: self.clipped }
    }

    pub(super) fn counts(&self) -> Counts {
        let count = |entries: Entries| entries.count_ones() as usize;
        let clipped = count(self.good & self.clipped);
        Counts { zero: count(self.zero), whole: count(self.good) - clipped, clipped, ..Counts::default() }
    }
}

/// The entries whose bits are set.
pub(super) fn each(entries: Entries) -> impl Iterator<Item = usize> {
    std::iter::successors(Some(entries), |remaining| Some(remaining & remaining.wrapping_sub(1)))
        .take_while(|remaining| *remaining != 0)
        .map(|remaining| remaining.trailing_zeros() as usize)
}

/// The first entries of the vectors that cover a tile of this length, at least a vector long: the last one may go over entries
/// again, to the same digits.
#[inline(always)]
pub(super) fn windows(length: usize, lanes: usize) -> impl Iterator<Item = usize> {
    (0..length).step_by(lanes).map(move |first| first.min(length - lanes))
}

/// So many entries stay with one thread: they take it microseconds, and to offer them to another takes tens of nanoseconds.
const UNDIVIDED: usize = 8 * TILE;

/// Answers all entries, tile by tile, on all threads where `threads` is set; counts the ways they were answered. The first error
/// stops it.
pub(super) fn run<F: Lane, C: Default + AddAssign + Send>(
    threads: bool,
    start: usize,
    slots: Slots<'_, F>,
    tile: &(impl Fn(usize, Slots<'_, F>) -> Result<C, Error> + Sync),
) -> Result<C, Error> {
    let length = slots.radiosity.len();
    if length <= TILE {
        return if length == 0 { Ok(C::default()) } else { tile(start, slots) };
    }
    if threads && length > UNDIVIDED {
        let middle = length.div_ceil(TILE) / 2 * TILE;
        let (left, right) = slots.split_at(middle);
        let (left, right) = join(|| run(true, start, left, tile), || run(true, start + middle, right, tile));
        let mut counts = left?;
        counts += right?;
        return Ok(counts);
    }
    let (mut counts, mut remaining) = (C::default(), slots);
    for start in (start..start + length).step_by(TILE) {
        let (first, others) = remaining.split_at(TILE);
        counts += tile(start, first)?;
        remaining = others;
    }
    Ok(counts)
}

/// Factors of the sums that were found, each lane's own.
pub(super) struct Scale<S: Simd, F: Lane> {
    /// `rho B/pi`.
    value: Lanes<S, F>,
    /// The factor of the gradient: that of the value times the power of two by which lengths were multiplied.
    gradient: Lanes<S, F>,
    /// Where rho is 0.
    black: Mask<S, F>,
}

impl<S: Simd, F: Lane> Scale<S, F> {
    /// Factors for a brightness `B/pi`, not 0.
    #[inline(always)]
    pub(super) fn new(simd: S, brightness: Lanes<S, F>, reflectance: Lanes<S, F>, power: Lanes<S, F>) -> Self {
        let value = brightness * reflectance;
        Self { value, gradient: value * power, black: reflectance.at_most(constant(simd, 0.0)) }
    }
}

/// Writes the sums that were found to the entries from `first` on, and notes which entries are settled.
#[inline(always)]
pub(super) fn settle<S: Simd, F: Lane, const GRADIENT: bool>(
    simd: S,
    visible: &VisibleSums<S, F>,
    scale: &Scale<S, F>,
    tolerance: Tolerance,
    (slots, first): (&mut Slots<'_, F>, usize),
    settled: &mut Settled,
) {
    let largest = constant(simd, F::LARGEST);
    // Results below the normal range are rounded more.
    let tiny = constant(simd, F::TINY);
    let value = visible.value * scale.value;
    let zero = visible.zero | scale.black;
    write(simd, zero, value, slots.radiosity, first);
    let normal = tiny.at_most(scale.value.abs()) & tiny.at_most(scale.gradient.abs());
    let mut good = visible.good & normal & value.abs().at_most(largest);
    let error = visible.bound.value * scale.value.abs();
    good = good & error.at_most(constant(simd, tolerance.value) * value.abs() + constant(simd, tolerance.absolute));
    if !slots.radiosity_error.is_empty() {
        write(simd, zero, error + tiny, slots.radiosity_error, first);
    }
    if GRADIENT {
        let gradient = visible.gradient * scale.gradient;
        let [x, y, z] = &mut slots.gradient;
        write(simd, zero, gradient.x, x, first);
        write(simd, zero, gradient.y, y, first);
        write(simd, zero, gradient.z, z, first);
        good = good & (gradient.x.abs() + gradient.y.abs() + gradient.z.abs()).at_most(largest);
        let allowed = constant(simd, tolerance.gradient * tolerance.gradient) * visible.gradient.norm_squared();
        good = good & visible.bound.gradient_square.at_most(allowed);
        if !slots.gradient_error.is_empty() {
            write(simd, zero, visible.bound.gradient_square.sqrt() * scale.gradient.abs() + tiny, slots.gradient_error, first);
        }
    }
    settled.zero |= placed(zero.bits(), first);
    settled.good |= placed((good & !zero).bits(), first);
    settled.clipped |= placed(visible.clipped.bits(), first);
}

/// A vector's bits at the entries from `first` on: in one half of them but for a last vector that goes over entries again.
#[inline(always)]
fn placed(bits: u64, first: usize) -> Entries {
    let shift = first % 64;
    if shift <= 64 - MOST_LANES { Entries::from(bits << shift) << (first - shift) } else { Entries::from(bits) << first }
}

/// Writes lanes to the entries from `first` on, and zeros where they are.
#[inline(always)]
fn write<S: Simd, F: Lane>(simd: S, zero: Mask<S, F>, lanes: Lanes<S, F>, slot: &mut [F], first: usize) {
    zero.select(constant(simd, 0.0), lanes).store(&mut slot[first..]);
}

/// Writes the answer to one entry.
pub(super) fn put<F: Lane>(slots: &mut Slots<'_, F>, entry: usize, answer: &Answer) -> Result<(), Error> {
    let rounded = |value: f64, quantity| {
        let rounded = F::nearest(value);
        if rounded.to_double().is_finite() { Ok(rounded) } else { Err(Error::Overflow { quantity }) }
    };
    // A bound is rounded up, and includes the rounding of the value.
    let bound = |error: f64, size: f64| {
        let rounding = if F::ROUNDOFF > ROUNDOFF { F::ROUNDOFF * size + F::TINY } else { 0.0 };
        F::nearest((error + rounding) * (1.0 + 4.0 * F::ROUNDOFF))
    };
    slots.radiosity[entry] = rounded(answer.radiosity, "radiosity")?;
    if let Some(slot) = slots.method.get_mut(entry) {
        *slot = answer.method;
    }
    let exact = answer.radiosity_error == 0.0 && answer.radiosity == 0.0;
    if let Some(slot) = slots.radiosity_error.get_mut(entry) {
        *slot = if exact { F::default() } else { bound(answer.radiosity_error, answer.radiosity.abs()) };
    }
    for (slot, component) in slots.gradient.iter_mut().zip(answer.gradient.to_array()) {
        if let Some(slot) = slot.get_mut(entry) {
            *slot = rounded(component, "gradient")?;
        }
    }
    if let Some(slot) = slots.gradient_error.get_mut(entry) {
        let exact = exact && answer.gradient_error == 0.0;
        *slot = if exact { F::default() } else { bound(answer.gradient_error, answer.gradient.length()) };
    }
    Ok(())
}

#[cfg(feature = "threads")]
pub(super) fn join<A: Send, B: Send>(a: impl FnOnce() -> A + Send, b: impl FnOnce() -> B + Send) -> (A, B) {
    rayon::join(a, b)
}

#[cfg(not(feature = "threads"))]
pub(super) fn join<A, B>(a: impl FnOnce() -> A, b: impl FnOnce() -> B) -> (A, B) {
    (a(), b())
}
