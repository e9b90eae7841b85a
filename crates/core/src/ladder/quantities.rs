//! Any number of quantities of one case to a tolerance, all from one pass over the visible boundary: the closed form in double
//! precision, in double-double, or with as many bits as it takes.
//!
//! Quantities are of kinds; an error counts relative to the largest quantity of its kind.

use radgrad_numbers::ball::Ball;
#[cfg(feature = "arbitrary-precision")]
use radgrad_numbers::big::Big;
#[cfg(feature = "arbitrary-precision")]
use radgrad_numbers::big::enclosure::{Enclosure, Outcome, PRECISIONS, enough_for_doubles, is_nothing, norm, refined};
#[cfg(feature = "arbitrary-precision")]
use radgrad_numbers::big::magnitude::Magnitude;
use radgrad_numbers::double_double::DoubleDouble;
use radgrad_numbers::number::Number;
#[cfg(feature = "arbitrary-precision")]
use radgrad_numbers::radius::Radius;
use radgrad_numbers::real::Real;
use radgrad_numbers::vec3::Vec3;

use crate::boundary::case::Case;
use crate::error::Error;
use crate::ladder::answer::Method;
use crate::ladder::caller_units::CallerUnits;
#[cfg(feature = "arbitrary-precision")]
use crate::ladder::digits::{Enclosed, to_doubles};

/// One above 1 by the roundings of a norm and of the way back from a power of two.
const UP: f64 = 1.0 + 8.0 * f64::EPSILON;

/// A vector, or a number with two zeros after it, in normalised lengths and emission.
pub(crate) struct Quantity<T> {
    pub(crate) components: Vec3<T>,
    /// Below [`KINDS`].
    pub(crate) kind: usize,
    pub(crate) unit: CallerUnits,
}

/// How many kinds there may be.
pub(crate) const KINDS: usize = 5;

/// Finds quantities on whatever scalar.
pub(crate) trait Find {
    /// The quantities in an order of their own; `None` where nothing is visible.
    fn find<T: Real>(&self, case: &Case<'_>) -> Option<Vec<Quantity<T>>>;
}

/// The components and a bound on the norm of their error.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Known {
    pub(crate) components: [f64; 3],
    pub(crate) error: f64,
}

/// The results of a rung, in normalised units and in those of the caller.
struct Rung {
    normalised: Vec<(Known, usize, CallerUnits)>,
    method: Method,
}

/// The quantities in the units of the caller, by the first rung whose bounds are within the tolerance, or by the last; `None` where
/// nothing is visible.
#[cold]
pub(crate) fn to_tolerance(find: &impl Find, case: &Case<'_>, tolerance: f64) -> Result<Option<(Vec<Known>, Method)>, Error> {
    let Some(rough) = Rung::by::<f64>(find, case, Method::ClosedForm) else { return Ok(None) };
    if let Some(answer) = rough.answer_within(tolerance)? {
        return Ok(Some(answer));
    }
    let Some(fine) = Rung::by::<DoubleDouble>(find, case, Method::DoubleDouble) else { return Ok(None) };
    if let Some(answer) = fine.answer_within(tolerance)? {
        return Ok(Some(answer));
    }
    #[cfg(feature = "arbitrary-precision")]
    {
        let enclose = |quantity: Quantity<Ball<Big>>| {
            let Vec3 { x, y, z } = quantity.components;
            ([x, y, z].map(Enclosure::from_ball), quantity.kind, quantity.unit)
        };
        let compute = || Some(find.find::<Ball<Big>>(case)?.into_iter().map(enclose).collect::<Vec<_>>());
        let enough = enough_for_doubles(tolerance);
        let stays_open = |enclosed: &Vec<Enclosing>| {
            let one_scale = case.is_of_one_scale();
            let is_settled = |kind| relative_error(enclosed, kind) <= enough || (one_scale && are_nothing(enclosed, kind));
            (0..KINDS).all(is_settled) || Enclosed::is_coincidence(case)
        };
        let error = |enclosed: &Vec<Enclosing>| largest((0..KINDS).map(|kind| relative_error(enclosed, kind)));
        match refined(PRECISIONS, enough, error, stays_open, compute) {
            Outcome::Nothing { .. } => return Ok(None),
            Outcome::Found(refined) => {
                let quantities = refined.result.iter().map(|(enclosures, _, unit)| rounded(enclosures, *unit));
                return Ok(Some((quantities.collect::<Result<_, Error>>()?, Method::ArbitraryPrecision)));
            }
            Outcome::TooDear => {}
        }
    }
    fine.answer().map(Some)
}

impl Rung {
    /// The closed form with a running bound.
    fn by<M: Number>(find: &impl Find, case: &Case<'_>, method: Method) -> Option<Self> {
        let known = |Quantity { components, kind, unit }: Quantity<Ball<M>>| {
            let error = components.map(Real::value_error).length() * UP;
            let Vec3 { x, y, z } = components.map(Real::value);
            (Known { components: [x, y, z], error }, kind, unit)
        };
        Some(Self { normalised: find.find::<Ball<M>>(case)?.into_iter().map(known).collect(), method })
    }

    fn answer(&self) -> Result<(Vec<Known>, Method), Error> {
        let in_unit = |(known, _, unit): &(Known, usize, CallerUnits)| {
            let (components, error) = unit.components(known.components, known.error)?;
            Ok(Known { components, error })
        };
        Ok((self.normalised.iter().map(in_unit).collect::<Result<_, Error>>()?, self.method))
    }

    /// The answer if it meets the tolerance, before and after the change of unit.
    fn answer_within(&self, tolerance: f64) -> Result<Option<(Vec<Known>, Method)>, Error> {
        let kinds = || self.normalised.iter().map(|(_, kind, _)| *kind);
        if !meets(self.normalised.iter().map(|(known, ..)| *known).zip(kinds()), tolerance) {
            return Ok(None);
        }
        let answer = self.answer()?;
        let is_met = meets(answer.0.iter().copied().zip(kinds()), tolerance);
        Ok(is_met.then_some(answer))
    }
}

/// Whether all errors are within the tolerance, relative to the largest of their kind.
fn meets(quantities: impl Iterator<Item = (Known, usize)> + Clone, tolerance: f64) -> bool {
    let mut largest = [0.0f64; KINDS];
    for (Known { components: [x, y, z], .. }, kind) in quantities.clone() {
        largest[kind] = largest[kind].max(Vec3::new(x, y, z).length());
    }
    quantities.into_iter().all(|(known, kind)| known.error <= tolerance * largest[kind])
}

#[cfg(feature = "arbitrary-precision")]
type Enclosing = ([Enclosure; 3], usize, CallerUnits);

#[cfg(feature = "arbitrary-precision")]
fn of_kind(enclosed: &[Enclosing], kind: usize) -> impl Iterator<Item = &[Enclosure; 3]> {
    enclosed.iter().filter(move |(_, of, _)| *of == kind).map(|(enclosures, ..)| enclosures)
}

#[cfg(feature = "arbitrary-precision")]
fn largest(norms: impl Iterator<Item = Magnitude>) -> Magnitude {
    norms.fold(Magnitude::from(0.0), Radius::max)
}

/// The largest error of a kind over the largest quantity of it.
#[cfg(feature = "arbitrary-precision")]
fn relative_error(enclosed: &[Enclosing], kind: usize) -> Magnitude {
    let quantities = || of_kind(enclosed, kind);
    let is_known = |c: &Enclosure| c.radius < Magnitude::from(f64::INFINITY);
    let radius = largest(quantities().map(|q| norm(q.iter().map(|c| c.radius))));
    let size = largest(quantities().map(|q| norm(q.iter().map(Enclosure::size))));
    if !quantities().flatten().all(is_known) {
        Magnitude::from(f64::INFINITY)
    } else if radius == Magnitude::from(0.0) {
        radius
    } else if radius < size {
        radius / size
    } else {
        Magnitude::from(1.0)
    }
}

#[cfg(feature = "arbitrary-precision")]
fn are_nothing(enclosed: &[Enclosing], kind: usize) -> bool {
    of_kind(enclosed, kind).all(|quantity| is_exactly_zero(quantity) || is_nothing(quantity))
}

#[cfg(feature = "arbitrary-precision")]
fn is_exactly_zero(enclosures: &[Enclosure; 3]) -> bool {
    let zero = Magnitude::from(0.0);
    enclosures.iter().all(|c| c.radius == zero && c.size() == zero)
}

#[cfg(feature = "arbitrary-precision")]
fn rounded(enclosures: &[Enclosure; 3], unit: CallerUnits) -> Result<Known, Error> {
    if is_exactly_zero(enclosures) {
        return Ok(Known { components: [0.0; 3], error: 0.0 });
    }
    let (components, error) = to_doubles(enclosures, unit)?;
    Ok(Known { components, error })
}
