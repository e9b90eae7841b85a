//! A stretch of a batch: what lanes find is settled, what they do not settle is done again.

use fearless_simd::Simd;

use super::answers::{Asked, Counts, Slots};
use super::lanes::{Lane, Lanes, constant};
use super::visible::Found;
use crate::Error;
use crate::evaluate::Answer;
use crate::number::ROUNDOFF;

/// Entries of a tile.
pub(super) const TILE: usize = Entries::BITS as usize;

/// What is asked of a batch, and to what relative tolerances.
#[derive(Debug, Clone, Copy)]
pub(super) struct Goal {
    pub(super) asked: Asked,
    pub(super) tolerance: Tolerance,
}

/// Relative bounds up to which a lane is taken, where there are bounds.
#[derive(Debug, Clone, Copy)]
pub(super) struct Tolerance {
    pub(super) value: f64,
    pub(super) gradient: f64,
}

/// For single precision where no tolerance is given. Errors are a thirtieth of the bound on the value at most, and an eightieth of
/// that on the gradient (measured: `tests/batch.rs`).
const SINGLE: Tolerance = Tolerance { value: 3e-5, gradient: 1e-4 };

impl Goal {
    /// Without bounds.
    pub(super) const fn plain(gradient: bool) -> Self {
        Self { asked: Asked { gradient, errors: false }, tolerance: SINGLE }
    }

    /// With bounds, to a relative tolerance.
    pub(super) fn within(tolerance: f64, gradient: bool) -> Result<Self, Error> {
        if (0.0..=1.0).contains(&tolerance) {
            Ok(Self { asked: Asked { gradient, errors: true }, tolerance: Tolerance { value: tolerance, gradient: tolerance } })
        } else {
            Err(Error::Tolerance { value: tolerance })
        }
    }
}

/// Entries of a tile, as bits.
pub(super) type Entries = u128;

/// What lanes made of a tile.
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

    pub(super) fn counts(&self) -> Counts {
        let count = |entries: Entries| entries.count_ones() as usize;
        let clipped = count(self.good & self.clipped);
        Counts { zero: count(self.zero), whole: count(self.good) - clipped, clipped, ..Counts::default() }
    }
}

/// The entries whose bits are set.
pub(super) fn each(entries: Entries) -> impl Iterator<Item = usize> {
    std::iter::successors(Some(entries), |rest| Some(rest & rest.wrapping_sub(1)))
        .take_while(|rest| *rest != 0)
        .map(|rest| rest.trailing_zeros() as usize)
}

/// The first entries of the vectors that cover a tile of this length, at least a vector long: the last one may go over entries
/// again, to the same digits.
#[inline(always)]
pub(super) fn windows(length: usize, lanes: usize) -> impl Iterator<Item = usize> {
    (0..length).step_by(lanes).map(move |first| first.min(length - lanes))
}

/// Answers all entries, tile by tile, on all threads where `threads` is set; counts what answered. The first error stops it.
pub(super) fn run<F: Lane>(
    threads: bool,
    start: usize,
    slots: Slots<'_, F>,
    tile: &(impl Fn(usize, Slots<'_, F>) -> Result<Counts, Error> + Sync),
) -> Result<Counts, Error> {
    let length = slots.radiosity.len();
    if length <= TILE {
        return tile(start, slots);
    }
    let middle = length.div_ceil(TILE) / 2 * TILE;
    let (left, right) = slots.split_at(middle);
    let halves = (|| run(threads, start, left, tile), || run(threads, start + middle, right, tile));
    let (left, right) = if threads { join(halves.0, halves.1) } else { (halves.0(), halves.1()) };
    let mut counts = left?;
    counts += right?;
    Ok(counts)
}

/// Factors of what is found, each lane's own.
pub(super) struct Scale<S: Simd, F: Lane> {
    /// `rho B/pi`.
    pub(super) value: Lanes<S, F>,
    /// That times the power of two by which lengths were multiplied.
    pub(super) gradient: Lanes<S, F>,
}

/// Writes what was found to the entries from `first` on, and notes what is settled.
#[inline(always)]
pub(super) fn settle<S: Simd, F: Lane, const GRADIENT: bool, const BOUND: bool>(
    simd: S,
    found: &Found<S, F>,
    scale: &Scale<S, F>,
    tolerance: Tolerance,
    (slots, first): (&mut Slots<'_, F>, usize),
    settled: &mut Settled,
) {
    let largest = constant(simd, F::LARGEST);
    // Results below the normal range are rounded more.
    let tiny = constant(simd, F::TINY);
    let value = found.value * scale.value;
    write(simd, found, value, slots.radiosity, first);
    let mut good = found.good & value.abs().at_most(largest);
    if BOUND {
        good = good & found.bound.value.at_most(constant(simd, tolerance.value) * found.value.abs());
        if !slots.radiosity_error.is_empty() {
            write(simd, found, found.bound.value * scale.value.abs() + tiny, slots.radiosity_error, first);
        }
    }
    if GRADIENT {
        let gradient = found.gradient * scale.gradient;
        let [x, y, z] = &mut slots.gradient;
        write(simd, found, gradient.x, x, first);
        write(simd, found, gradient.y, y, first);
        write(simd, found, gradient.z, z, first);
        good = good & (gradient.x.abs() + gradient.y.abs() + gradient.z.abs()).at_most(largest);
        if BOUND {
            let allowed = constant(simd, tolerance.gradient * tolerance.gradient) * found.gradient.norm_squared();
            good = good & (found.bound.gradient * found.bound.gradient).at_most(allowed);
            if !slots.gradient_error.is_empty() {
                write(simd, found, found.bound.gradient * scale.gradient.abs() + tiny, slots.gradient_error, first);
            }
        }
    }
    settled.zero |= Entries::from(found.zero.bits()) << first;
    settled.good |= Entries::from(good.bits()) << first;
    settled.clipped |= Entries::from(found.clipped.bits()) << first;
}

/// Writes lanes to the entries from `first` on; zeros where nothing is seen.
#[inline(always)]
fn write<S: Simd, F: Lane>(simd: S, found: &Found<S, F>, lanes: Lanes<S, F>, slot: &mut [F], first: usize) {
    found.zero.select(constant(simd, 0.0), lanes).store(&mut slot[first..]);
}

/// Writes the answer to one entry.
pub(super) fn put<F: Lane>(slots: &mut Slots<'_, F>, entry: usize, answer: &Answer) -> Result<(), Error> {
    let rounded = |value: f64, quantity| {
        let rounded = F::nearest(value);
        if rounded.to_double().is_finite() { Ok(rounded) } else { Err(Error::Overflow { quantity }) }
    };
    // A bound is rounded up, and holds what rounding the value adds.
    let bound = |error: f64, size: f64| {
        let rounding = if F::ROUNDOFF > ROUNDOFF { F::ROUNDOFF * size + F::TINY } else { 0.0 };
        F::nearest((error + rounding) * (1.0 + 4.0 * F::ROUNDOFF))
    };
    slots.radiosity[entry] = rounded(answer.radiosity, "radiosity")?;
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
        *slot = if exact { F::default() } else { bound(answer.gradient_error, answer.gradient.length()) };
    }
    Ok(())
}

#[cfg(feature = "threads")]
fn join<A: Send, B: Send>(a: impl FnOnce() -> A + Send, b: impl FnOnce() -> B + Send) -> (A, B) {
    rayon::join(a, b)
}

#[cfg(not(feature = "threads"))]
fn join<A, B>(a: impl FnOnce() -> A, b: impl FnOnce() -> B) -> (A, B) {
    (a(), b())
}
