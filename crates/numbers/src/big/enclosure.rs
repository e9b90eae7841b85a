//! Balls that have left the computation: many digits and a bound, to be rounded to doubles or written out.

use astro_float::BigFloat;

use crate::ball::Ball;
use crate::big::float::split_double;
use crate::big::magnitude::Magnitude;
use crate::big::{Big, Spent, within};
use crate::number::ROUNDOFF;
use crate::radius::Radius;
use crate::real::Real;

/// A number within `radius` of `mid`.
#[derive(Debug, Clone)]
pub struct Enclosure {
    /// The middle.
    pub mid: BigFloat,
    /// The bound.
    pub radius: Magnitude,
}

impl Enclosure {
    /// A ball, taken out of its computation.
    pub fn from_ball(ball: Ball<Big>) -> Self {
        Self { mid: ball.middle().to_float(), radius: ball.error() }
    }

    /// Magnitude of the middle.
    pub fn size(&self) -> Magnitude {
        Magnitude::of_number(&self.mid)
    }

    /// Times a power of two, exactly.
    pub fn times(&self, power_of_two: Magnitude) -> Self {
        Self { mid: power_of_two.shift(&self.mid), radius: self.radius * power_of_two }
    }

    /// The nearest double and a bound on its error, the rounding included.
    pub fn to_double(&self) -> (f64, Magnitude) {
        let (value, remainder) = split_double(&self.mid);
        // Half an ulp rather than the actual rounding: whoever compares with a rounded truth must not find the bound broken.
        let rounding =
            if remainder == Magnitude::from(0.0) { remainder } else { remainder.max(Magnitude::from(ROUNDOFF * value.abs())) };
        (value, (self.radius + rounding) * (1.0 + f64::EPSILON))
    }
}

/// The outcome of a computation with ever more bits.
#[derive(Debug)]
pub enum Outcome<R> {
    /// The computation says that there is nothing, with so many bits.
    Nothing {
        /// The bits.
        bits: usize,
    },
    /// The result with the most bits that were tried.
    Found(Refined<R>),
    /// Even the fewest bits would have taken more than [`EFFORT`].
    TooDear,
}

/// A result, and how it was found.
#[derive(Debug)]
pub struct Refined<R> {
    /// The result.
    pub result: R,
    /// Bits it was found with.
    pub bits: usize,
    /// Whether its error is small enough.
    pub is_enough: bool,
}

/// The largest effort for an answer: some seconds. A case that would take more is answered with the bound of fewer bits. It counts
/// operations and not time, so that the answer is the same on every machine.
pub const EFFORT: u64 = 16_000_000_000;

/// Bits that decide cases that doubles of like size leave open; a case still open then is an exact coincidence.
const DECISIVE: usize = 1024;

/// Exponent of a normalised size below which a number that may be 0 is taken for 0: far below the roundings of any input, and far
/// above the remainder of an exact coincidence at [`DECISIVE`] bits.
const NOTHING: i64 = -600;

/// Whether a number, vector or matrix may be 0, and is that small for sure: as a sum that cancels by symmetry, which no number of
/// bits tells from 0.
pub fn is_nothing<'a>(components: impl IntoIterator<Item = &'a Enclosure> + Copy) -> bool {
    let largest = norm(components.into_iter().map(|c| c.size() + c.radius));
    relative_error(components) >= Magnitude::from(1.0) && largest < Magnitude::power_of_two(NOTHING)
}

/// Tries the precisions until the error is small enough (Ziv's strategy), or until more bits no longer help. The remaining error is
/// then an uncertainty of the input, such as vertices that are not exactly in one plane, or from `DECISIVE` (1024) bits on `stays_open`
/// says so of the result: a decision stays open, or a number that may be 0 is too small to matter.
pub fn refined<R>(
    precisions: impl IntoIterator<Item = usize>,
    enough: Magnitude,
    relative_error: impl Fn(&R) -> Magnitude,
    stays_open: impl Fn(&R) -> bool,
    computation: impl Fn() -> Option<R>,
) -> Outcome<R> {
    refined_within(EFFORT, precisions, enough, relative_error, stays_open, computation)
}

fn refined_within<R>(
    effort: u64,
    precisions: impl IntoIterator<Item = usize>,
    enough: Magnitude,
    relative_error: impl Fn(&R) -> Magnitude,
    stays_open: impl Fn(&R) -> bool,
    computation: impl Fn() -> Option<R>,
) -> Outcome<R> {
    let mut outcome = Outcome::TooDear;
    let mut before = Magnitude::from(f64::INFINITY);
    let (mut remaining, mut last) = (effort.min(crate::effort::remaining()), None);
    for bits in precisions {
        // The effort of as many operations with more bits is known before they are done.
        if last.is_some_and(|spent: Spent| spent.with_bits(bits) > remaining) {
            break;
        }
        let (result, spent) = within(bits, remaining, &computation);
        let Some(result) = result else { break };
        let Some(result) = result else { return Outcome::Nothing { bits } };
        (remaining, last) = (remaining.saturating_sub(spent.effort()), Some(spent));
        let error = relative_error(&result);
        let is_enough = error <= enough;
        let is_last = is_enough
            || error * 2.0 > before
            || (bits >= DECISIVE && within(bits, remaining, || stays_open(&result)).0 != Some(false));
        outcome = Outcome::Found(Refined { result, bits, is_enough });
        if is_last {
            break;
        }
        before = error;
    }
    outcome
}

/// The relative error that rounding to doubles leaves nothing of, or a quarter of the tolerance where that is larger.
pub fn enough_for_doubles(tolerance: f64) -> Magnitude {
    Magnitude::from((0.25 * tolerance).max(ROUNDOFF / 64.0))
}

/// Bits to try for a result in doubles: their coordinates span 2100 binary places, and a height may cancel twice that.
pub const PRECISIONS: [usize; 4] = [256, 1024, 4096, 8448];

/// Bound on the error of a vector's norm over the norm; infinite where the vector may be 0, and 0 where it is.
pub fn relative_error<'a>(components: impl IntoIterator<Item = &'a Enclosure> + Copy) -> Magnitude {
    let radius = norm(components.into_iter().map(|c| c.radius));
    let size = norm(components.into_iter().map(Enclosure::size));
    if radius == Magnitude::from(0.0) {
        radius
    } else if radius < size {
        radius / size
    } else {
        Magnitude::from(f64::INFINITY)
    }
}

/// Euclidean norm.
pub fn norm(components: impl IntoIterator<Item = Magnitude>) -> Magnitude {
    components.into_iter().fold(Magnitude::from(0.0), |sum, c| sum + c * c).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A sum whose ten thousand terms cancel, to the tolerance given, within an effort.
    fn cancelling(effort: u64, enough: f64) -> Outcome<Enclosure> {
        let computation = || {
            let third = Ball::<Big>::exact(1.0) / Ball::exact(3.0);
            let sum = (0..10_000).fold(Ball::exact(0.0), |sum, i| if i % 2 == 0 { sum + third } else { sum - third });
            Some(Enclosure::from_ball(sum + Ball::exact(2f64.powi(-900))))
        };
        let share = |enclosure: &Enclosure| relative_error([enclosure]);
        refined_within(effort, PRECISIONS, Magnitude::from(enough), share, |_| false, computation)
    }

    #[test]
    fn what_costs_too_much_is_left_at_fewer_bits_or_not_begun() {
        let Outcome::Found(refined) = cancelling(EFFORT, 1e-3) else { panic!() };
        assert!(refined.is_enough && refined.bits == 1024);
        let Outcome::Found(refined) = cancelling(6_000_000, 1e-3) else { panic!() };
        assert!(!refined.is_enough && refined.bits == 256, "{}", refined.bits);
        assert!(matches!(cancelling(1_000_000, 1e-3), Outcome::TooDear));
        // No effort remains for a later computation.
        let Outcome::Found(refined) = cancelling(EFFORT, 1e-3) else { panic!() };
        assert!(refined.is_enough);
    }
}
