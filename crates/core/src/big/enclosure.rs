//! Balls that have left the computation: many digits and a bound, to be rounded to doubles or written out.

use astro_float::BigFloat;

use super::{Big, Magnitude, split_double, with_bits};
use crate::Error;
use crate::certify::Ball;
use crate::number::ROUNDOFF;
use crate::radius::Radius;
use crate::real::Real;
use crate::unit::Unit;

/// A number within `radius` of `mid`.
#[derive(Debug, Clone)]
pub(crate) struct Enclosure {
    pub(crate) mid: BigFloat,
    pub(crate) radius: Magnitude,
}

impl Enclosure {
    pub(crate) fn of(ball: Ball<Big>) -> Self {
        Self { mid: ball.middle().to_float(), radius: ball.error() }
    }

    pub(crate) fn size(&self) -> Magnitude {
        Magnitude::of(&self.mid)
    }

    /// Times a power of two, exactly.
    pub(crate) fn times(&self, power_of_two: Magnitude) -> Self {
        Self { mid: power_of_two.shift(&self.mid), radius: self.radius * power_of_two }
    }

    /// The nearest double and a bound on its error, the rounding included.
    pub(crate) fn to_double(&self) -> (f64, Magnitude) {
        let (value, rest) = split_double(&self.mid);
        // Half an ulp rather than what the rounding was: whoever compares with a rounded truth must not find it broken.
        let rounding = if rest == Magnitude::from(0.0) { rest } else { rest.max(Magnitude::from(ROUNDOFF * value.abs())) };
        (value, (self.radius + rounding) * (1.0 + f64::EPSILON))
    }
}

/// What came of a computation with ever more bits.
pub(crate) struct Refined<R> {
    /// `None` as soon as the computation says that there is nothing.
    pub(crate) found: Option<R>,
    /// Bits it was found with.
    pub(crate) bits: usize,
    /// Whether its error is small enough.
    pub(crate) is_enough: bool,
}

/// Bits that decide what doubles of like size leave open: what they do not is an exact coincidence.
const DECISIVE: usize = 1024;

/// Tries the precisions until the error is small enough (Ziv's strategy), or until more bits no longer help: what is left is an
/// uncertainty of the input, such as vertices that are not exactly in one plane, or `is_coincidence` says that a decision stays
/// open.
pub(crate) fn refined<R>(
    precisions: impl IntoIterator<Item = usize>,
    enough: Magnitude,
    relative_error: impl Fn(&R) -> Magnitude,
    is_coincidence: impl Fn() -> bool,
    computation: impl Fn() -> Option<R>,
) -> Refined<R> {
    let mut refined = Refined { found: None, bits: 0, is_enough: false };
    let mut before = Magnitude::from(f64::INFINITY);
    for bits in precisions {
        let Some(result) = with_bits(bits, &computation) else { return Refined { found: None, bits, is_enough: true } };
        let error = relative_error(&result);
        refined = Refined { found: Some(result), bits, is_enough: error <= enough };
        if refined.is_enough || error * 2.0 > before || (bits >= DECISIVE && with_bits(bits, &is_coincidence)) {
            break;
        }
        before = error;
    }
    refined
}

/// The relative error that rounding to doubles leaves nothing of, or a quarter of the tolerance where that is larger.
pub(crate) fn enough_for_doubles(tolerance: f64) -> Magnitude {
    Magnitude::from((0.25 * tolerance).max(ROUNDOFF / 64.0))
}

/// Bits to try for a result in doubles: their coordinates span 2100 binary places, and a height may cancel twice that.
pub(crate) const PRECISIONS: [usize; 4] = [256, 1024, 4096, 8448];

/// Bound on the error of a vector's norm over the norm; infinite where the vector may be 0, and 0 where it is.
pub(crate) fn relative_error<'a>(components: impl IntoIterator<Item = &'a Enclosure> + Copy) -> Magnitude {
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

/// Exponent of a normalised size below which what may be 0 is taken for 0: far below the roundings of any input, and far above
/// what an exact coincidence leaves at 1024 bits.
const NOTHING: i64 = -600;

/// The doubles nearest to the components of a number, vector or matrix in the unit, and a bound on the norm of their error. What
/// may be 0 is 0 where doubles have no digits for it, where nothing is known of it, or where a coincidence is all that is left.
pub(crate) fn to_doubles<const N: usize>(normalised: &[Enclosure; N], unit: Unit) -> Result<([f64; N], f64), Error> {
    let scaled = normalised.each_ref().map(|c| c.times(unit.magnitude()));
    let rounded = scaled.each_ref().map(Enclosure::to_double);
    let values = rounded.map(|(value, _)| value);
    if relative_error(normalised) < Magnitude::from(1.0) {
        unit.check_finite(values)?;
        unit.check_size(values)?;
    } else {
        let most = |of: &[Enclosure; N]| norm(of.each_ref().map(|c| c.size() + c.radius)) * (1.0 + 16.0 * f64::EPSILON);
        let has_no_digits = values.iter().all(|v| v.abs() < f64::MIN_POSITIVE) || values.iter().any(|v| !v.is_finite());
        if has_no_digits || most(normalised) < Magnitude::power_of_two(NOTHING) {
            return Ok(([0.0; N], bounding(most(&scaled))));
        }
    }
    Ok((values, bounding(norm(rounded.map(|(_, error)| error)) * (1.0 + 16.0 * f64::EPSILON))))
}

/// What is not a number bounds nothing.
fn bounding(error: Magnitude) -> f64 {
    let error = error.to_double();
    if error.is_nan() { f64::INFINITY } else { error }
}

/// Euclidean norm.
pub(crate) fn norm(components: impl IntoIterator<Item = Magnitude>) -> Magnitude {
    components.into_iter().fold(Magnitude::from(0.0), |sum, c| sum + c * c).sqrt()
}
