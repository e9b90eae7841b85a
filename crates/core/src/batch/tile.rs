//! A stretch of a batch: what lanes find is settled, what they do not settle is done again.

use fearless_simd::Simd;

use super::answers::{Asked, Counts, Slots};
use super::lanes::{Lane, Lanes, constant};
use super::visible::Found;
use crate::Error;
use crate::evaluate::Answer;
use crate::number::ROUNDOFF;

/// Entries of a tile.
pub(super) const TILE: usize = 256;

/// What is asked of a batch, and to what relative tolerance where bounds are.
#[derive(Debug, Clone, Copy)]
pub(super) struct Goal {
    pub(super) asked: Asked,
    pub(super) tolerance: f64,
}

/// Bound up to which a lane of single precision is taken where no tolerance is given.
const SINGLE_TOLERANCE: f64 = 3e-5;

impl Goal {
    /// Without bounds.
    pub(super) const fn plain(gradient: bool) -> Self {
        Self { asked: Asked { gradient, errors: false }, tolerance: SINGLE_TOLERANCE }
    }

    /// With bounds, to a relative tolerance.
    pub(super) fn within(tolerance: f64, gradient: bool) -> Result<Self, Error> {
        if (0.0..=1.0).contains(&tolerance) {
            Ok(Self { asked: Asked { gradient, errors: true }, tolerance })
        } else {
            Err(Error::Tolerance { value: tolerance })
        }
    }
}

/// The entries of a tile that are not settled, and what settled the others.
#[derive(Debug)]
pub(super) struct Rest {
    entries: [u8; TILE],
    count: usize,
    pub(super) counts: Counts,
}

impl Rest {
    pub(super) fn new() -> Self {
        Self { entries: [0; TILE], count: 0, counts: Counts::default() }
    }

    /// All entries of a tile of this length.
    pub(super) fn all(length: usize) -> Self {
        let mut rest = Self::new();
        (0..length).for_each(|entry| rest.push(entry));
        rest
    }

    #[allow(clippy::cast_possible_truncation, reason = "an entry is below TILE")]
    pub(super) fn push(&mut self, entry: usize) {
        self.entries[self.count] = entry as u8;
        self.count += 1;
    }

    pub(super) fn entries(&self) -> impl ExactSizeIterator<Item = usize> {
        self.entries[..self.count].iter().map(|entry| usize::from(*entry))
    }
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

/// Writes what was found from entry `first` on, as far as the tile goes, and notes which lanes are not settled.
#[inline(always)]
pub(super) fn settle<S: Simd, F: Lane, const GRADIENT: bool, const BOUND: bool>(
    simd: S,
    found: &Found<S, F>,
    scale: &Scale<S, F>,
    tolerance: f64,
    (slots, first): (&mut Slots<'_, F>, usize),
    rest: &mut Rest,
) {
    let end = (first + Lanes::<S, F>::COUNT).min(slots.radiosity.len());
    let (largest, tolerance) = (constant(simd, F::LARGEST), constant(simd, tolerance));
    // Results below the normal range are rounded more.
    let tiny = constant(simd, F::TINY);
    let value = found.value * scale.value;
    write(simd, found, value, &mut slots.radiosity[..], first);
    let mut good = found.good & value.abs().at_most(largest);
    if BOUND {
        good = good & found.bound.value.at_most(tolerance * found.value.abs());
        write(simd, found, found.bound.value * scale.value.abs() + tiny, &mut slots.radiosity_error[..], first);
    }
    if GRADIENT {
        let gradient = found.gradient * scale.gradient;
        write(simd, found, gradient.x, &mut slots.gradient[0][..], first);
        write(simd, found, gradient.y, &mut slots.gradient[1][..], first);
        write(simd, found, gradient.z, &mut slots.gradient[2][..], first);
        good = good & (gradient.x.abs() + gradient.y.abs() + gradient.z.abs()).at_most(largest);
        if BOUND {
            good = good & found.bound.gradient.at_most(tolerance * found.gradient.norm_squared().sqrt());
            write(simd, found, found.bound.gradient * scale.gradient.abs() + tiny, &mut slots.gradient_error[..], first);
        }
    }
    let here = (1u64 << (end - first)) - 1;
    let (zero, good, clipped) = (found.zero.bits() & here, good.bits() & here, found.clipped.bits());
    rest.counts.zero += zero.count_ones() as usize;
    rest.counts.whole += (good & !clipped).count_ones() as usize;
    rest.counts.clipped += (good & clipped).count_ones() as usize;
    let mut open = here & !(zero | good);
    while open != 0 {
        rest.push(first + open.trailing_zeros() as usize);
        open &= open - 1;
    }
}

/// Writes lanes to the entries from `first` on where they are wanted; zeros where nothing is seen.
#[inline(always)]
fn write<S: Simd, F: Lane>(simd: S, found: &Found<S, F>, lanes: Lanes<S, F>, slot: &mut [F], first: usize) {
    if !slot.is_empty() {
        found.zero.select(constant(simd, 0.0), lanes).store(&mut slot[first..]);
    }
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
