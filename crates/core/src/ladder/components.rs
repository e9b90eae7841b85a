//! A vector or a matrix to a tolerance: the closed form in double precision, in double-double, or with as many bits as it takes.

use radgrad_numbers::ball::Ball;
#[cfg(feature = "arbitrary-precision")]
use radgrad_numbers::big::Big;
#[cfg(feature = "arbitrary-precision")]
use radgrad_numbers::big::enclosure::{Enclosure, Outcome, PRECISIONS, enough_for_doubles, is_nothing, refined, relative_error};
use radgrad_numbers::double_double::DoubleDouble;
use radgrad_numbers::number::{Number, ROUNDOFF};
use radgrad_numbers::real::Real;

use crate::boundary::case::Case;
use crate::error::Error;
use crate::ladder::answer::Method;
use crate::ladder::caller_units::CallerUnits;
#[cfg(feature = "arbitrary-precision")]
use crate::ladder::digits::{Enclosed, to_doubles};

/// A quantity of N components that has a closed form.
pub(crate) trait Components<const N: usize> {
    /// One above 1 by the roundings of [`Self::norm`].
    const UP: f64;

    /// The closed form in normalised lengths and emission; `None` where nothing is visible.
    fn find<T: Real>(case: &Case<'_>) -> Option<[T; N]>;

    /// The norm in which an error is bounded.
    fn norm(components: [f64; N]) -> f64;

    /// The caller's unit of a component.
    fn unit(case: &Case<'_>) -> CallerUnits;
}

/// Components, with a bound on the norm of their error.
pub(crate) struct Bounded<const N: usize> {
    pub(crate) components: [f64; N],
    pub(crate) error: f64,
    pub(crate) method: Method,
}

/// The tolerance, checked and not below the rounding to doubles, where nothing dearer gives more.
pub(crate) fn within_reach(tolerance: f64) -> Result<f64, Error> {
    if (0.0..=1.0).contains(&tolerance) { Ok(tolerance.max(1.01 * ROUNDOFF)) } else { Err(Error::Tolerance { value: tolerance }) }
}

impl<const N: usize> Bounded<N> {
    /// The first rung whose bound is within the tolerance, relative to the norm, or the last; `None` where nothing is visible.
    #[cold]
    pub(crate) fn to<Q: Components<N>>(case: &Case<'_>, tolerance: f64) -> Result<Option<Self>, Error> {
        let Some(rough) = Self::by::<Q, f64>(case, Method::ClosedForm) else { return Ok(None) };
        if let Some(answer) = rough.answer_within::<Q>(case, tolerance)? {
            return Ok(Some(answer));
        }
        let Some(fine) = Self::by::<Q, DoubleDouble>(case, Method::DoubleDouble) else { return Ok(None) };
        if let Some(answer) = fine.answer_within::<Q>(case, tolerance)? {
            return Ok(Some(answer));
        }
        #[cfg(feature = "arbitrary-precision")]
        if !case.is_error_of_input([fine.error, Q::norm(fine.components), rough.error]) {
            let find = || Some(Q::find::<Ball<Big>>(case)?.map(Enclosure::from_ball));
            let is_open = |components: &[Enclosure; N]| {
                (case.is_of_one_scale() && is_nothing(components)) || Enclosed::is_coincidence(case)
            };
            match refined(PRECISIONS, enough_for_doubles(tolerance), |components| relative_error(components), is_open, find) {
                Outcome::Nothing { .. } => return Ok(None),
                Outcome::Found(refined) => {
                    let (components, error) = to_doubles(&refined.result, Q::unit(case))?;
                    return Ok(Some(Self { components, error, method: Method::ArbitraryPrecision }));
                }
                Outcome::TooDear => {}
            }
        }
        fine.answer::<Q>(case).map(Some)
    }

    /// The closed form with a running bound.
    fn by<Q: Components<N>, M: Number>(case: &Case<'_>, method: Method) -> Option<Self> {
        let components = Q::find::<Ball<M>>(case)?;
        let error = Q::norm(components.map(Real::value_error)) * Q::UP;
        Some(Self { components: components.map(Real::value), error, method })
    }

    fn answer<Q: Components<N>>(&self, case: &Case<'_>) -> Result<Self, Error> {
        let (components, error) = Q::unit(case).components(self.components, self.error)?;
        Ok(Self { components, error, method: self.method })
    }

    /// The answer if it meets the tolerance, before and after the change of unit.
    fn answer_within<Q: Components<N>>(&self, case: &Case<'_>, tolerance: f64) -> Result<Option<Self>, Error> {
        let meets = |bounded: &Self| bounded.error <= tolerance * Q::norm(bounded.components);
        if meets(self) { self.answer::<Q>(case).map(|answer| Some(answer).filter(meets)) } else { Ok(None) }
    }
}
