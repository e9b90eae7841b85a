//! As many digits as are requested, each proven.
//!
//! The closed form is evaluated with balls of ever more bits, until the radius is small enough (Ziv's strategy). It starts with
//! 80 bits beyond the digits asked, which pays for a cancellation of 1e20, and gives up at [`SPARE_BITS`] beyond, or before where
//! it would cost too much or more bits do not help. A sum that cancels by symmetry is 0 within a bound that is below any rounding
//! of its terms; no number of bits would tell it from 0. Else a screen may be seen exactly in line with the emitter's edge, or
//! the vertices of a linear emission not be exactly in one plane.

use std::array::from_ref;
use std::iter;

use radgrad_numbers::ball::Ball;
use radgrad_numbers::big::Big;
use radgrad_numbers::big::decimal::{to_decimal, upper_decimal};
use radgrad_numbers::big::enclosure::{Enclosure, Outcome, Refined, is_nothing, norm, refined, relative_error};
use radgrad_numbers::big::magnitude::Magnitude;
use radgrad_numbers::radius::Radius;
use radgrad_numbers::vec3::Vec3;

use crate::boundary::case::Case;
use crate::boundary::plan::Plan;
use crate::error::Error;
use crate::forms::irradiance_and_gradient::IrradianceAndGradient;
use crate::ladder::answer::{Answer, Method};
use crate::ladder::caller_units::CallerUnits;
use crate::ladder::sum::visit;
use crate::problem::emission::{Emission, Emitter};
use crate::problem::polygon::Polygon;
use crate::problem::receiver::Receiver;

/// Radiosity and gradient in decimal digits, with proven absolute error bounds that include the rounding of the digits.
///
/// All are in scientific notation, `-1.25e-3`, and parse as any decimal number does.
///
/// ```
/// use radgrad_core::{DVec3, Emission, Emitter, Polygon, Receiver, evaluate_digits};
/// let corners = [(0.0, 0.0), (0.0, 1.0), (1.0, 1.0), (1.0, 0.0)].map(|(x, y)| DVec3::new(x, y, 1.0));
/// let lamp = Emitter::new(Polygon::new(corners.to_vec())?, Emission::Constant(1.0))?;
/// let answer = evaluate_digits(&Receiver::new(DVec3::ZERO, DVec3::Z, 1.0)?, &lamp, &[], 30)?;
/// assert!(answer.radiosity.starts_with("1.3853160599489299678076970863"));
/// assert!(answer.radiosity_error.parse::<f64>().unwrap() <= 1.386e-31);
/// assert!(answer.bits > 100);
/// # Ok::<(), radgrad_core::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PreciseAnswer {
    /// Radiosity `B(x)`, in the unit of the emission.
    pub radiosity: String,
    /// Gradient of `B` with respect to `x` at fixed normal, in that unit over the unit of length.
    pub gradient: [String; 3],
    /// Proven bound on the error of `radiosity`.
    pub radiosity_error: String,
    /// Proven bound on the Euclidean norm of the error of `gradient`.
    pub gradient_error: String,
    /// Bits of the numbers that gave the answer; 0 where it is exactly 0 and nothing was computed.
    pub bits: usize,
}

/// Most digits that can be requested.
///
/// ```
/// use radgrad_core::{DVec3, Emission, Emitter, Error, MOST_DIGITS, Polygon, Receiver, evaluate_digits};
/// let triangle = Polygon::new(vec![DVec3::Z, DVec3::new(0.0, 1.0, 1.0), DVec3::new(1.0, 0.0, 1.0)])?;
/// let lamp = Emitter::new(triangle, Emission::Constant(1.0))?;
/// let error = evaluate_digits(&Receiver::new(DVec3::ZERO, DVec3::Z, 1.0)?, &lamp, &[], MOST_DIGITS + 1).unwrap_err();
/// assert_eq!(error, Error::Digits { value: 1001, most: 1000 });
/// # Ok::<(), radgrad_core::Error>(())
/// ```
pub const MOST_DIGITS: u32 = 1000;

/// Bits beyond the digits asked after which the evaluation gives up: doubles span 2100 binary places, and a height may cancel
/// twice that.
const SPARE_BITS: usize = 8192;

/// Radiosity and gradient at `receiver` due to the part of `emitter` that `occluders` leave visible, with a relative error of at
/// most `10^-digits` (of the norm, for the gradient). A sum that cancels by symmetry, as odd emission over an even emitter does,
/// has no relative error: it is 0 with a bound below `2^-600` of the terms that cancel.
///
/// The truth is the exact result for the doubles as given. A triangle takes about 0.2 ms for 20 or 50 digits and 0.25 ms for 100
/// where its emission is constant, 0.6 to 1 ms where it is linear; the first call of a thread at a new precision finds the
/// coefficients of the series, in 5 ms more.
///
/// ```
/// use radgrad_core::{DVec3, Emission, Emitter, Polygon, Receiver, evaluate_digits};
/// let point = |x, y, z| DVec3::new(x, y, z);
/// let ceiling = Polygon::new(vec![point(0.0, 0.0, 1.0), point(0.0, 1.0, 1.0), point(1.0, 1.0, 1.0), point(1.0, 0.0, 1.0)])?;
/// let lamp = Emitter::new(ceiling, Emission::Constant(1.0))?;
/// let corner = Receiver::new(DVec3::ZERO, DVec3::Z, 1.0)?;
/// let answer = evaluate_digits(&corner, &lamp, &[], 50)?;
/// // atan(1/sqrt 2) / (pi sqrt 2)
/// assert!(answer.radiosity.starts_with("1.3853160599489299678076970863447567973073739484901"));
/// # Ok::<(), radgrad_core::Error>(())
/// ```
///
/// # Errors
/// If `digits` is 0 or above [`MOST_DIGITS`], the bound does not reach these digits within some seconds, or the receiver is on
/// the surface of an emitter that is not flat ([`Error::OnSurface`]).
pub fn evaluate_digits<'a>(
    receiver: &Receiver,
    emitter: &Emitter,
    occluders: impl IntoIterator<Item = &'a Polygon>,
    digits: u32,
) -> Result<PreciseAnswer, Error> {
    precise(receiver, emitter, &occluders.into_iter().collect::<Vec<_>>(), digits)
}

/// [`evaluate_digits`], compiled once: generic functions are compiled again in every crate that calls them.
fn precise(receiver: &Receiver, emitter: &Emitter, occluders: &[&Polygon], digits: u32) -> Result<PreciseAnswer, Error> {
    if !(1..=MOST_DIGITS).contains(&digits) {
        return Err(Error::Digits { value: digits, most: MOST_DIGITS });
    }
    let Some(plan) = Plan::new(receiver, emitter.polygon()) else { return Ok(PreciseAnswer::zero(0)) };
    let case = Case { receiver, emitter, occluders, plan: &plan };
    if case.is_dark() {
        return Ok(PreciseAnswer::zero(0));
    }
    plan.off_surface(receiver, emitter.polygon())?;
    let tolerance = Magnitude::power_of_ten(-i64::from(digits)) * 0.5;
    // log2 10 < 3.322
    let first = ((digits as usize * 3322).div_ceil(1000) + 80).next_multiple_of(64);
    let precisions = iter::successors(Some(first), |bits| Some(2 * bits)).take_while(|bits| *bits <= first + SPARE_BITS);
    let stays_open = |enclosed: &Enclosed| enclosed.stays_open(&case, tolerance);
    match refined(precisions, tolerance, Enclosed::relative_error, stays_open, || Enclosed::find(&case)) {
        Outcome::Nothing { bits } => Ok(PreciseAnswer::zero(bits)),
        Outcome::Found(Refined { result: enclosed, bits, is_enough }) if is_enough || enclosed.is_settled(&case, tolerance) => {
            Ok(enclosed.in_unit(&case).to_decimals(digits, bits, enclosed.are_nothing()))
        }
        Outcome::Found(Refined { bits, .. }) => Err(Error::Undecided { digits, bits }),
        Outcome::TooDear => Err(Error::Undecided { digits, bits: first }),
    }
}

/// The result of the closed form, in normalised lengths and emission.
#[derive(Debug, Clone)]
pub(crate) struct Enclosed {
    radiosity: Enclosure,
    gradient: [Enclosure; 3],
}

impl Enclosed {
    /// Evaluates with the bits of the computation; `None` where nothing is visible.
    pub(crate) fn find(case: &Case<'_>) -> Option<Self> {
        let terms = IrradianceAndGradient::<Ball<Big>>::sum::<true, true>(case)?;
        let Vec3 { x, y, z } = terms.gradient(case.receiver);
        Some(Self {
            radiosity: Enclosure::from_ball(terms.radiosity(case.receiver)),
            gradient: [x, y, z].map(Enclosure::from_ball),
        })
    }

    /// Whether the bits of the computation do not decide the part that an occluder hides, or the plane or the affine function of an
    /// emission.
    pub(crate) fn is_coincidence(case: &Case<'_>) -> bool {
        let emitter = case.emitter;
        (emitter.polygon().half_slab() > 0.0 && !matches!(emitter.emission(), Emission::Constant(_)))
            || emitter.affine().residual > 0.0
            || visit::<Ball<Big>, true>(case, |_| {}).is_some_and(|uncertainty| !uncertainty.is_none())
    }

    /// Whether more bits than a coincidence takes serve nothing: the visible part stays undecided, or each of value and gradient
    /// is known well enough or not to be told from 0.
    pub(crate) fn stays_open(&self, case: &Case<'_>, enough: Magnitude) -> bool {
        self.is_settled(case, enough) || Self::is_coincidence(case)
    }

    /// Whether each of value and gradient is known well enough or not to be told from 0.
    fn is_settled(&self, case: &Case<'_>, enough: Magnitude) -> bool {
        let one_scale = case.is_of_one_scale();
        let is_settled = |quantity: &[Enclosure]| relative_error(quantity) <= enough || (one_scale && is_nothing(quantity));
        is_settled(from_ref(&self.radiosity)) && is_settled(&self.gradient)
    }

    /// Whether value and gradient are not to be told from 0.
    fn are_nothing(&self) -> [bool; 2] {
        [is_nothing(from_ref(&self.radiosity)), is_nothing(&self.gradient)]
    }

    /// The larger of the relative errors of value and gradient; infinite where a value may be 0.
    pub(crate) fn relative_error(&self) -> Magnitude {
        let radiosity = relative_error([&self.radiosity]);
        radiosity.max(relative_error(&self.gradient))
    }

    /// Converts from normalised lengths and emission to those of the caller, exactly.
    fn in_unit(&self, case: &Case<'_>) -> Self {
        let (radiosity, gradient) = (case.radiosity_unit().magnitude(), case.gradient_unit().magnitude());
        Self { radiosity: self.radiosity.times(radiosity), gradient: self.gradient.each_ref().map(|c| c.times(gradient)) }
    }

    /// The doubles nearest to value and gradient in their units, each with a bound on its error, the rounding included.
    pub(crate) fn to_answer(&self, case: &Case<'_>) -> Result<Answer, Error> {
        let ([radiosity], radiosity_error) = to_doubles(from_ref(&self.radiosity), case.radiosity_unit())?;
        let (gradient, gradient_error) = to_doubles(&self.gradient, case.gradient_unit())?;
        let gradient = gradient.into();
        Ok(Answer { radiosity, gradient, radiosity_error, gradient_error, method: Method::ArbitraryPrecision })
    }

    /// A number not to be told from 0 is 0, with its largest possible size as the bound.
    fn to_decimals(&self, digits: u32, bits: usize, are_nothing: [bool; 2]) -> PreciseAnswer {
        // A unit of the last place is at most a tenth of the tolerance.
        let place = |size: Magnitude| size.decimal_exponent() - i64::from(digits) - 1;
        let rounded = |radius: Magnitude, last: i64| radius + Magnitude::power_of_ten(last);
        let largest_norm = |components: &[Enclosure]| upper_decimal(norm(components.iter().map(|c| c.size() + c.radius)));
        let zero = || "0".to_owned();
        let (radiosity, radiosity_error) = if are_nothing[0] {
            (zero(), largest_norm(from_ref(&self.radiosity)))
        } else {
            let last = place(self.radiosity.size());
            (to_decimal(&self.radiosity.mid, last), upper_decimal(rounded(self.radiosity.radius, last)))
        };
        let (gradient, gradient_error) = if are_nothing[1] {
            ([zero(), zero(), zero()], largest_norm(&self.gradient))
        } else {
            let last = place(norm(self.gradient.each_ref().map(Enclosure::size)));
            let error = norm(self.gradient.each_ref().map(|c| rounded(c.radius, last)));
            (self.gradient.each_ref().map(|c| to_decimal(&c.mid, last)), upper_decimal(error))
        };
        PreciseAnswer { radiosity, gradient, radiosity_error, gradient_error, bits }
    }
}

impl PreciseAnswer {
    fn zero(bits: usize) -> Self {
        let zero = || "0".to_owned();
        Self { radiosity: zero(), gradient: [zero(), zero(), zero()], radiosity_error: zero(), gradient_error: zero(), bits }
    }
}

/// The doubles nearest to the components of a number, vector or matrix in the unit, and a bound on the norm of their error. A
/// number that may be 0 is 0 where doubles have no digits for it, where its bound is infinite, or where its sign hangs on a
/// coincidence.
pub(crate) fn to_doubles<const N: usize>(normalised: &[Enclosure; N], unit: CallerUnits) -> Result<([f64; N], f64), Error> {
    let scaled = normalised.each_ref().map(|c| c.times(unit.magnitude()));
    let rounded = scaled.each_ref().map(Enclosure::to_double);
    let values = rounded.map(|(value, _)| value);
    if relative_error(normalised) < Magnitude::from(1.0) {
        unit.check_finite(values)?;
        unit.check_size(values)?;
    } else {
        let largest_norm =
            |components: &[Enclosure; N]| norm(components.each_ref().map(|c| c.size() + c.radius)) * (1.0 + 16.0 * f64::EPSILON);
        let has_no_digits = values.iter().all(|v| v.abs() < f64::MIN_POSITIVE) || values.iter().any(|v| !v.is_finite());
        if has_no_digits || is_nothing(normalised) {
            return Ok(([0.0; N], bounding(largest_norm(&scaled))));
        }
    }
    Ok((values, bounding(norm(rounded.map(|(_, error)| error)) * (1.0 + 16.0 * f64::EPSILON))))
}

/// NaN bounds nothing.
fn bounding(error: Magnitude) -> f64 {
    let error = error.to_double();
    if error.is_nan() { f64::INFINITY } else { error }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;
    use rand::{RngExt, SeedableRng, rngs::ChaCha8Rng};

    use super::*;
    use crate::problem::polynomial::Polynomial;
    use radgrad_numbers::big::within;

    /// Wherever a computation exceeds its effort, it ends, and says so.
    #[test]
    fn what_runs_out_anywhere_ends_and_is_dropped() {
        let mut random = ChaCha8Rng::seed_from_u64(5);
        let mut vector = || DVec3::from([(); 3].map(|()| random.random_range(-1.0..1.0)));
        let mut dropped = 0;
        for round in 0..40 {
            let polynomial = Polynomial::new(DVec3::ZERO, [(1.0, [0, 0, 0]), (0.5, [2, 1, 0])]).unwrap();
            let emission =
                [Emission::Constant(1.0), Emission::gradient(1.0, vector()), Emission::Polynomial(polynomial)][round % 3].clone();
            let polygon = |points: Vec<DVec3>| Polygon::new(points).unwrap();
            let lamp = [vector(), vector(), vector()].map(|v| v.with_z(1.0)).to_vec();
            let lamp = Some(polygon(lamp.clone())).filter(|p| p.normal().z < 0.0);
            let Some(lamp) = lamp else { continue };
            let emitter = Emitter::new(lamp, emission).unwrap();
            let receiver = Receiver::new(vector() * 0.3, vector() + DVec3::Z, 1.0).unwrap();
            let screens: Vec<Polygon> = (0..round % 4)
                .map(|_| {
                    let middle = vector() * 0.3 + DVec3::Z * 0.6;
                    polygon((0..3).map(|_| middle + vector() * 0.4).collect())
                })
                .collect();
            let occluders: Vec<&Polygon> = screens.iter().collect();
            let Some(plan) = Plan::new(&receiver, emitter.polygon()) else { continue };
            let case = Case { receiver: &receiver, emitter: &emitter, occluders: &occluders, plan: &plan };
            let (whole, spent) = within(256, u64::MAX, || Enclosed::find(&case));
            assert!(whole.is_some());
            for share in 0..60 {
                let limit = spent.effort() * share / 60;
                let (dropped_result, spent) = within(256, limit, || Enclosed::find(&case));
                assert!(dropped_result.is_none() && spent.effort() > limit);
                dropped += 1;
            }
        }
        assert!(dropped > 300, "{dropped}");
    }
}
