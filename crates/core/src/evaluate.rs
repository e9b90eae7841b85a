//! One receiver, one emitter, any occluders: the answer with its bounds.
//!
//! `B(x) = (rho/pi) int B(y) (n1.r)(-n2.r)/|r|^4 dA` (HS95 Eq. 1) over the part of the emitter that x sees above its horizon,
//! and its gradient with respect to x at fixed n1. The case is decided in [`crate::boundary::plan`], the method in
//! [`crate::ladder::rungs`].

use glam::DVec3;
use radgrad_numbers::vec3::Vec3;

use crate::boundary::case::{Case, with_case};
use crate::boundary::plan::Plan;
use crate::error::Error;
use crate::forms::edge_lanes;
use crate::forms::irradiance_and_gradient::IrradianceAndGradient;
use crate::ladder::answer::{Answer, Tolerance, Value};
use crate::ladder::components::{Components, within_reach};
use crate::ladder::irradiance::IrradianceVector;
use crate::ladder::rungs::DirectAttempt;
use crate::problem::emission::{Emission, Emitter};
use crate::problem::polygon::Polygon;
use crate::problem::receiver::Receiver;
use crate::problem::triangulate::Few;

/// The relative error that [`evaluate`] asks for.
///
/// ```
/// use radgrad_core::{DEFAULT_TOLERANCE, DVec3, Emission, Emitter, Polygon, Receiver, evaluate};
/// let corners = [(0.0, 0.0), (0.0, 1.0), (1.0, 1.0), (1.0, 0.0)].map(|(x, y)| DVec3::new(x, y, 1.0));
/// let lamp = Emitter::new(Polygon::new(corners.to_vec())?, Emission::Constant(1.0))?;
/// let answer = evaluate(&Receiver::new(DVec3::new(0.3, 0.2, 0.9), DVec3::X, 1.0)?, &lamp, &[])?;
/// assert!(answer.meets(DEFAULT_TOLERANCE));
/// # Ok::<(), radgrad_core::Error>(())
/// ```
pub const DEFAULT_TOLERANCE: f64 = 1e-12;

/// [`evaluate_to`] a relative tolerance of [`DEFAULT_TOLERANCE`].
///
/// ```
/// use radgrad_core::{DVec3, Emission, Emitter, Polygon, Receiver, evaluate};
/// let square = |x: f64, z: f64| [(0.0, 0.0), (0.0, 1.0), (1.0, 1.0), (1.0, 0.0)].map(|(a, y)| DVec3::new(x + a, y, z));
/// let lamp = Emitter::new(Polygon::new(square(0.0, 1.0).to_vec())?, Emission::Constant(1.0))?;
/// let middle = Receiver::new(DVec3::new(0.5, 0.5, 0.0), DVec3::Z, 1.0)?;
/// let screen = Polygon::new(square(0.0, 0.5).to_vec())?; // as large, half as far: it hides all of the lamp
/// assert!((evaluate(&middle, &lamp, &[])?.radiosity - 0.239_457).abs() < 1e-5);
/// assert_eq!(evaluate(&middle, &lamp, [&screen])?.radiosity, 0.0);
/// # Ok::<(), radgrad_core::Error>(())
/// ```
///
/// # Errors
/// If a result over- or underflows.
pub fn evaluate<'a>(
    receiver: &Receiver,
    emitter: &Emitter,
    occluders: impl IntoIterator<Item = &'a Polygon>,
) -> Result<Answer, Error> {
    evaluate_to(receiver, emitter, occluders, DEFAULT_TOLERANCE)
}

/// Radiosity and gradient at `receiver` due to the part of `emitter` that `occluders` leave visible, with bounds.
///
/// The cheapest method whose bound is at most `tolerance` times the value (times the norm, for the gradient) answers; if none
/// is, the last one does: the bounds say so. The last one gives the nearest doubles, so below a tolerance of 2^-53 its bound is
/// that of their rounding, and [`crate::evaluate_digits`] gives more digits than doubles have. Occluders are opaque from both
/// sides; those behind the receiver or the emitter are left out by themselves. If the receiver sees one edge
/// exactly behind another, the gradient has two values: the answer has one of them, and its bound reaches the other.
///
/// ```
/// use radgrad_core::{DVec3, Emission, Emitter, Polygon, Receiver, evaluate_to};
/// let point = |x, y, z| DVec3::new(x, y, z);
/// let ceiling = Polygon::new(vec![point(0.0, 0.0, 1.0), point(0.0, 1.0, 1.0), point(1.0, 1.0, 1.0), point(1.0, 0.0, 1.0)])?;
/// let lamp = Emitter::new(ceiling, Emission::Constant(1.0))?;
/// let corner = Receiver::new(DVec3::ZERO, DVec3::Z, 1.0)?;
/// let answer = evaluate_to(&corner, &lamp, &[], 1e-14)?;
/// assert!((answer.radiosity - 0.138_531_605_994_893).abs() <= 1e-15);
/// assert!(answer.radiosity_error <= 1e-14 * answer.radiosity);
/// # Ok::<(), radgrad_core::Error>(())
/// ```
///
/// # Errors
/// If a result over- or underflows, or the tolerance is not in [0, 1].
pub fn evaluate_to<'a>(
    receiver: &Receiver,
    emitter: &Emitter,
    occluders: impl IntoIterator<Item = &'a Polygon>,
    tolerance: f64,
) -> Result<Answer, Error> {
    with_list(occluders, |occluders| answer(receiver, emitter, occluders, tolerance))
}

/// Calls a function with a list of occluders. Most callers have none, and pay nothing for it.
#[inline]
fn with_list<'a, R>(occluders: impl IntoIterator<Item = &'a Polygon>, call: impl FnOnce(&[&'a Polygon]) -> R) -> R {
    let mut remaining = occluders.into_iter();
    match remaining.next() {
        None => call(&[]),
        Some(first) => call(&std::iter::once(first).chain(remaining).collect::<Few<_>>()),
    }
}

/// [`evaluate_to`], compiled once: generic functions are compiled again in every crate that calls them.
fn answer(receiver: &Receiver, emitter: &Emitter, occluders: &[&Polygon], tolerance: f64) -> Result<Answer, Error> {
    if !(0.0..=1.0).contains(&tolerance) {
        return Err(Error::Tolerance { value: tolerance });
    }
    let direct = if occluders.is_empty() { DirectAttempt::new(receiver, emitter, tolerance)? } else { DirectAttempt::Nothing };
    let plan = match direct {
        DirectAttempt::Answer(answer) => return Ok(answer),
        DirectAttempt::Plan(plan) => Some(plan),
        DirectAttempt::Nothing => Plan::new(receiver, emitter.polygon()),
    };
    let Some(plan) = plan else { return Ok(Answer::ZERO) };
    let case = Case { receiver, emitter, occluders, plan: &plan };
    if occluders.is_empty() { case.answer(tolerance) } else { answer_occluded(&case, tolerance) }
}

/// The answer past those occluders that may hide something.
#[cold]
#[inline(never)]
fn answer_occluded(case: &Case<'_>, tolerance: f64) -> Result<Answer, Error> {
    match &*case.near_by() {
        [] => answer(case.receiver, case.emitter, &[], tolerance),
        occluders => Case { occluders, ..*case }.answer(tolerance),
    }
}

/// Radiosity alone at `receiver` due to the part of `emitter` that `occluders` leave visible, with a bound.
///
/// The cheapest method whose bound meets the tolerance answers; if none does, the last one: the bound says so. An absolute
/// tolerance, in the unit of the emission, is for sums of many values: an emitter hidden but for a sliver is then bounded, and not
/// decided to the last digit. Where a shadow's edge is seen in line with another edge, this is also much cheaper than
/// [`evaluate_to`], whose gradient has two values there.
///
/// ```
/// use radgrad_core::{DVec3, Emission, Emitter, Polygon, Receiver, Tolerance, evaluate_value};
/// let square = |x: f64, z: f64| [(0.0, 0.0), (0.0, 1.0), (1.0, 1.0), (1.0, 0.0)].map(|(a, y)| DVec3::new(x + a, y, z));
/// let lamp = Emitter::new(Polygon::new(square(0.0, 1.0).to_vec())?, Emission::Constant(1.0))?;
/// let screen = Polygon::new(square(0.25, 0.5).to_vec())?;
/// let corner = Receiver::new(DVec3::ZERO, DVec3::Z, 1.0)?;
/// let value = evaluate_value(&corner, &lamp, [&screen], Tolerance { relative: 0.0, absolute: 1e-12 })?;
/// assert!(value.radiosity < 0.138_531_605_994_893 && value.radiosity_error <= 1e-12);
/// # Ok::<(), radgrad_core::Error>(())
/// ```
///
/// # Errors
/// If the result over- or underflows, the relative tolerance is not in [0, 1], or the absolute one is negative or not finite.
pub fn evaluate_value<'a>(
    receiver: &Receiver,
    emitter: &Emitter,
    occluders: impl IntoIterator<Item = &'a Polygon>,
    tolerance: Tolerance,
) -> Result<Value, Error> {
    with_list(occluders, |occluders| value(receiver, emitter, occluders, tolerance))
}

/// [`evaluate_value`], compiled once.
fn value(receiver: &Receiver, emitter: &Emitter, occluders: &[&Polygon], tolerance: Tolerance) -> Result<Value, Error> {
    if !(0.0..=1.0).contains(&tolerance.relative) {
        return Err(Error::Tolerance { value: tolerance.relative });
    }
    if !(0.0..f64::INFINITY).contains(&tolerance.absolute) {
        return Err(Error::AbsoluteTolerance { value: tolerance.absolute });
    }
    let Some(plan) = Plan::new(receiver, emitter.polygon()) else { return Ok(Value::ZERO) };
    let case = Case { receiver, emitter, occluders, plan: &plan };
    Case { occluders: &case.near_by(), ..case }.value(tolerance)
}

/// Radiosity `B(x)` alone: the digits of the closed form in double precision, without bound and gradient. Where that breaks
/// down, on a line through the receiver to the last digit, and where most of its digits cancel, the ladder of [`evaluate`] answers.
///
/// ```
/// use radgrad_core::{DVec3, Emission, Emitter, Polygon, Receiver, radiosity};
/// let corners = [(0.0, 0.0), (0.0, 1.0), (1.0, 1.0), (1.0, 0.0)].map(|(x, y)| DVec3::new(x, y, 1.0));
/// let lamp = Emitter::new(Polygon::new(corners.to_vec())?, Emission::Constant(2.0))?;
/// let corner = Receiver::new(DVec3::ZERO, DVec3::Z, 0.5)?;
/// assert!((radiosity(&corner, &lamp)? - 0.138_531_605_994_893).abs() < 1e-15);
/// # Ok::<(), radgrad_core::Error>(())
/// ```
///
/// # Errors
/// If the result over- or underflows.
pub fn radiosity(receiver: &Receiver, emitter: &Emitter) -> Result<f64, Error> {
    let sums = on_lanes::<true, false, _>(
        receiver,
        emitter,
        #[inline(always)]
        |plan, terms| Some((plan, terms.radiosity(receiver))),
    );
    if let Some((plan, radiosity)) = sums
        && is_sound([radiosity], emitter)
    {
        return Case { receiver, emitter, occluders: &[], plan: &plan }.radiosity(radiosity);
    }
    let Some(plan) = Plan::new(receiver, emitter.polygon()) else { return Ok(0.0) };
    let case = Case { receiver, emitter, occluders: &[], plan: &plan };
    let Some(terms) = plain::<true, false>(&case) else { return case.answer(FALLBACK).map(|answer| answer.radiosity) };
    let radiosity = terms.radiosity(receiver);
    if is_sound([radiosity], emitter) { case.radiosity(radiosity) } else { case.answer(FALLBACK).map(|answer| answer.radiosity) }
}

/// Gradient of `B` with respect to `x` alone: the digits of the closed form in double precision, without bound and value; of
/// [`evaluate`] where they cancel.
///
/// ```
/// use radgrad_core::{DVec3, Emission, Emitter, Polygon, Receiver, gradient};
/// let corners = [(0.0, 0.0), (0.0, 1.0), (1.0, 1.0), (1.0, 0.0)].map(|(x, y)| DVec3::new(x, y, 1.0));
/// let lamp = Emitter::new(Polygon::new(corners.to_vec())?, Emission::Constant(1.0))?;
/// let slope = gradient(&Receiver::new(DVec3::new(0.5, 0.5, 0.0), DVec3::Z, 1.0)?, &lamp)?;
/// assert!(slope.truncate().length() < 1e-14, "under the middle it is brightest");
/// assert!(slope.z > 0.3, "nearer the lamp it is brighter");
/// # Ok::<(), radgrad_core::Error>(())
/// ```
///
/// # Errors
/// If the result over- or underflows.
pub fn gradient(receiver: &Receiver, emitter: &Emitter) -> Result<DVec3, Error> {
    let sums = on_lanes::<false, true, _>(
        receiver,
        emitter,
        #[inline(always)]
        |plan, terms| {
            let gradient = terms.gradient(receiver);
            is_sound(DVec3::from(gradient).to_array(), emitter).then_some((plan, gradient))
        },
    );
    if let Some((plan, gradient)) = sums {
        return Case { receiver, emitter, occluders: &[], plan: &plan }.gradient(gradient);
    }
    let Some(plan) = Plan::new(receiver, emitter.polygon()) else { return Ok(DVec3::ZERO) };
    let case = Case { receiver, emitter, occluders: &[], plan: &plan };
    let Some(terms) = plain::<false, true>(&case) else { return case.answer(FALLBACK).map(|answer| answer.gradient) };
    let gradient = terms.gradient(receiver);
    let is_sound = is_sound(DVec3::from(gradient).to_array(), emitter);
    if is_sound { case.gradient(gradient) } else { case.answer(FALLBACK).map(|answer| answer.gradient) }
}

/// Radiosity and gradient together: the digits of the closed form in double precision, without bounds; of [`evaluate`] where they
/// cancel.
///
/// ```
/// use radgrad_core::{DVec3, Emission, Emitter, Polygon, Receiver, radiosity, radiosity_and_gradient};
/// let corners = [(0.0, 0.0), (0.0, 1.0), (1.0, 1.0), (1.0, 0.0)].map(|(x, y)| DVec3::new(x, y, 1.0));
/// let lamp = Emitter::new(Polygon::new(corners.to_vec())?, Emission::Constant(1.0))?;
/// let receiver = |x| Receiver::new(DVec3::new(x, 0.2, 0.0), DVec3::Z, 1.0);
/// let (value, slope) = radiosity_and_gradient(&receiver(0.1)?, &lamp)?;
/// assert!((radiosity(&receiver(0.1001)?, &lamp)? - value - 0.0001 * slope.x).abs() < 1e-8);
/// # Ok::<(), radgrad_core::Error>(())
/// ```
///
/// # Errors
/// If a result over- or underflows.
pub fn radiosity_and_gradient(receiver: &Receiver, emitter: &Emitter) -> Result<(f64, DVec3), Error> {
    let are_sound = |radiosity, gradient| [is_sound([radiosity], emitter), is_sound(DVec3::from(gradient).to_array(), emitter)];
    let sums = on_lanes::<true, true, _>(
        receiver,
        emitter,
        #[inline(always)]
        |plan, terms| {
            let (radiosity, gradient) = (terms.radiosity(receiver), terms.gradient(receiver));
            let [value_is, gradient_is] = are_sound(radiosity, gradient);
            (value_is && gradient_is).then_some((plan, radiosity, gradient))
        },
    );
    if let Some((plan, radiosity, gradient)) = sums {
        let case = Case { receiver, emitter, occluders: &[], plan: &plan };
        return Ok((case.radiosity(radiosity)?, case.gradient(gradient)?));
    }
    let Some(plan) = Plan::new(receiver, emitter.polygon()) else { return Ok((0.0, DVec3::ZERO)) };
    let case = Case { receiver, emitter, occluders: &[], plan: &plan };
    let Some(terms) = plain::<true, true>(&case) else {
        return case.answer(FALLBACK).map(|answer| (answer.radiosity, answer.gradient));
    };
    let (radiosity, gradient) = (terms.radiosity(receiver), terms.gradient(receiver));
    // Each by itself, so that it has the digits that it has alone.
    let [value_is, gradient_is] = are_sound(radiosity, gradient);
    let in_full = if value_is && gradient_is { None } else { Some(case.answer(FALLBACK)?) };
    Ok((
        in_full.filter(|_| !value_is).map_or_else(|| case.radiosity(radiosity), |answer| Ok(answer.radiosity))?,
        in_full.filter(|_| !gradient_is).map_or_else(|| case.gradient(gradient), |answer| Ok(answer.gradient))?,
    ))
}

/// Irradiance vector `E = int B(y) omega domega` over the part of the emitter above the horizon, in the unit of the emission: **pi times**
/// the irradiance, if the emission is `pi L` for a radiance L.
///
/// Its part along a normal is the irradiance itself only where the emission was given as the radiance: of an emission `B = pi L` the
/// irradiance is `n.E/pi`.
///
/// The radiosity is `(rho/pi) n1.E`; a receiver at the same point with a nearby normal m, and the same part of the emitter
/// above its horizon, has `(rho/pi) m.E`. Its derivative with respect to the normal is `dB/dn1 = (rho/pi) E`, also where the
/// horizon crosses the emitter, since the part that the horizon gains or loses is seen edge-on.
///
/// It has the digits of the closed form in double precision; where most of them cancel, those of [`irradiance_vector_to`] a
/// tolerance of 1e-9.
///
/// ```
/// use radgrad_core::{DVec3, Emission, Emitter, Polygon, Receiver, irradiance_vector, radiosity};
/// let corners = [(0.0, 0.0), (0.0, 1.0), (1.0, 1.0), (1.0, 0.0)].map(|(x, y)| DVec3::new(x, y, 1.0));
/// let lamp = Emitter::new(Polygon::new(corners.to_vec())?, Emission::Constant(1.0))?;
/// let vector = irradiance_vector(&Receiver::new(DVec3::ZERO, DVec3::Z, 1.0)?, &lamp)?;
/// let tilted = Receiver::new(DVec3::ZERO, DVec3::new(0.0, 0.6, 0.8), 0.5)?; // the lamp stays above its horizon
/// assert!((radiosity(&tilted, &lamp)? - 0.5 / std::f64::consts::PI * tilted.normal().dot(vector)).abs() < 1e-15);
/// # Ok::<(), radgrad_core::Error>(())
/// ```
///
/// # Errors
/// If the result over- or underflows, or the receiver is on the surface of an emitter that is not flat ([`Error::OnSurface`]).
pub fn irradiance_vector(receiver: &Receiver, emitter: &Emitter) -> Result<DVec3, Error> {
    with_case(receiver, emitter, &[], DVec3::ZERO, |case| {
        let components = |Vec3 { x, y, z }: Vec3<f64>| [x, y, z];
        let irradiance = plain::<true, false>(case).map(|terms| components(terms.irradiance));
        match irradiance.filter(|vector| is_sound(*vector, emitter)) {
            Some(vector) => IrradianceVector::unit(case).plain(vector).map(DVec3::from),
            None => case.irradiance_vector(FALLBACK).map(|answer| answer.vector),
        }
    })
}

/// The [`irradiance_vector`] of the part of `emitter` that `occluders` leave visible, with a bound.
///
/// The closed form in double precision, in double-double or with as many bits as it takes: the first whose bound is at most
/// `tolerance` times the vector's length answers. Where none is, the last does, and its bound says so: below a tolerance of
/// 2^-53 it is that of the rounding to doubles.
///
/// ```
/// use radgrad_core::{DVec3, Emission, Emitter, Polygon, Receiver, evaluate, irradiance_vector_to};
/// let point = |x, y, z| DVec3::new(x, y, z);
/// let lamp = Polygon::new(vec![point(-1.0, -1.0, 2.0), point(-1.0, 1.0, 2.0), point(1.0, 1.0, 2.0), point(1.0, -1.0, 2.0)])?;
/// let lamp = Emitter::new(lamp, Emission::Constant(1.0))?;
/// let screen = [Polygon::new(vec![point(0.2, -1.0, 1.0), point(0.2, 1.0, 1.0), point(2.0, 0.0, 1.0)])?];
/// let floor = Receiver::new(DVec3::ZERO, DVec3::Z, 1.0)?;
/// let irradiance = irradiance_vector_to(&floor, &lamp, &screen, 1e-12)?;
/// assert!(irradiance.meets(1e-12));
/// // Any receiver point this point that sees the same part: its radiosity is (rho/pi) m.E.
/// let tilted = Receiver::new(DVec3::ZERO, DVec3::new(0.1, 0.2, 1.0), 0.5)?;
/// let radiosity = 0.5 / std::f64::consts::PI * tilted.normal().dot(irradiance.vector);
/// assert!((radiosity - evaluate(&tilted, &lamp, &screen)?.radiosity).abs() < 1e-12 * radiosity);
/// # Ok::<(), radgrad_core::Error>(())
/// ```
///
/// # Errors
/// If the receiver is on the surface of an emitter that is not flat ([`Error::OnSurface`]), the tolerance is not in [0, 1], or a
/// result over- or underflows.
pub fn irradiance_vector_to<'a>(
    receiver: &Receiver,
    emitter: &Emitter,
    occluders: impl IntoIterator<Item = &'a Polygon>,
    tolerance: f64,
) -> Result<IrradianceVector, Error> {
    let tolerance = within_reach(tolerance)?;
    with_list(occluders, |occluders| {
        with_case(receiver, emitter, occluders, IrradianceVector::ZERO, |case| case.irradiance_vector(tolerance))
    })
}

/// The closed form in double precision, off the surface of the emitter.
fn plain<const VALUE: bool, const GRADIENT: bool>(case: &Case<'_>) -> Option<IrradianceAndGradient<f64>> {
    if case.plan.on_surface { None } else { IrradianceAndGradient::<f64>::sum::<VALUE, GRADIENT>(case) }
}

/// The answer by the sums over an emitter on edge lanes, where double precision is sure of the visible part and `answer` takes them.
/// Each branch calls `answer`: where branches meet, their sums are copied to memory first.
#[inline(always)]
fn on_lanes<const VALUE: bool, const GRADIENT: bool, A>(
    receiver: &Receiver,
    emitter: &Emitter,
    answer: impl Fn(Plan, IrradianceAndGradient<f64>) -> Option<A>,
) -> Option<A> {
    match emitter.emission() {
        Emission::Constant(_) => {
            let (plan, sums) = edge_lanes::constant::sure::<VALUE, GRADIENT>(receiver, emitter.polygon())?;
            let emission = emitter.affine().value;
            let sums = IrradianceAndGradient { irradiance: sums.irradiance * emission, gradient: sums.gradient * emission };
            answer(plan, sums)
        }
        Emission::Linear(_) => {
            let (plan, sums) = edge_lanes::linear::sure::<GRADIENT>(receiver, emitter)?;
            answer(plan, sums)
        }
        Emission::Polynomial(_) => None,
    }
}

/// The relative error that is requested where double precision does not serve.
const FALLBACK: f64 = 1e-9;

/// Whether double precision served: it neither broke down, nor did so much of its terms, which are about 1, cancel that less than
/// six digits are sure.
#[inline]
fn is_sound<const N: usize>(normalised: [f64; N], emitter: &Emitter) -> bool {
    let least = if let Emission::Constant(_) = emitter.emission() { MOST_CANCELLED } else { MOST_CANCELLED_OF_OTHERS };
    (least..f64::INFINITY).contains(&normalised.iter().map(|c| c.abs()).sum())
}

/// A constant emission's result errs by a few roundings of its terms, that of another, seen at D/s times its size, by D/s as many.
const MOST_CANCELLED: f64 = 1.0 / (1 << 30) as f64;
const MOST_CANCELLED_OF_OTHERS: f64 = 1.0 / (1 << 20) as f64;
