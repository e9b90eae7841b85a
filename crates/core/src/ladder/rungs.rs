//! The answer to a tolerance: the rungs of a ladder are tried from the cheapest to the dearest, as Ziv's strategy for elementary
//! functions does.
//!
//! 0. The direct attempt: the closed form in double precision with its derived bound, on edge lanes, of a constant or linear
//!    emitter near by, without occluders, where double precision is sure of the visible part. It answers most calls, and where it
//!    does not its plan serves the rungs that follow.
//! 1. A Gauss rule on the emitter with an a-priori bound ([`crate::gauss`]), where few nodes are enough: far away.
//! 2. The closed form in double precision with its bound: derived for a constant emitter ([`crate::forms::constant_bound`]), past
//!    occluders too where double precision is sure of the visible part ([`crate::boundary::visibility::sure`]), and for a linear one
//!    that is fully visible ([`crate::forms::linear_bound`]; where the horizon cuts it rung 0 alone has that), running otherwise
//!    ([`radgrad_numbers::ball`]), where the rule may cost more before it.
//! 3. The closed form in double-double on lanes, of a constant or linear emitter without occluders, with the bound that is derived for
//!    double precision in another unit ([`crate::forms::edge_lanes::precise`]); where that was found before, it says whether this
//!    will do.
//! 4. The Gauss rule with more nodes, where that is still cheaper than the next, or than rung 3 before it:
//! 5. the closed form in double-double with a running bound; for a constant emitter with occluders it takes the visible boundary
//!    from double precision, where that is sure of it;
//! 6. the same with 256 to 8448 bits, rounded to doubles, where the crate is built with arbitrary precision, and as long as that
//!    takes no more than some seconds; not where sizes and distances say that the answer is below the range of doubles.
//!
//! A rung whose bound is above the tolerance hands over to the next; where all are, the one with the smallest bound answers. On the
//! surface of an emitter that is not flat no rung answers, but [`crate::ladder::on_surface`].
//!
//! [`DirectAttempt::new`] is rung 0, [`Case::climb`] takes rungs 1 to 5, and [`Case::answer`] the last one.

use std::borrow::Cow;
use std::cell::Cell;

use radgrad_numbers::ball::Ball;
#[cfg(feature = "arbitrary-precision")]
use radgrad_numbers::big::enclosure::{Outcome, PRECISIONS, Refined, enough_for_doubles, refined};
#[cfg(feature = "arbitrary-precision")]
use radgrad_numbers::big::magnitude::Magnitude;
use radgrad_numbers::double_double::DoubleDouble;
use radgrad_numbers::number::{Number, ROUNDOFF};
use radgrad_numbers::real::Real;
use radgrad_numbers::vec3::Vec3;

use crate::boundary::case::Case;
use crate::boundary::plan::{Horizon, Plan};
use crate::boundary::visibility::sure::Hidden;
use crate::error::Error;
use crate::forms::constant_bound::{BoundedSum, past_occluders};
use crate::forms::edge_lanes::{SureCase, precise};
use crate::forms::irradiance_and_gradient::IrradianceAndGradient;
use crate::forms::{edge_lanes, linear_bound};
use crate::gauss::{self, FULL_PRECISION};
use crate::ladder::answer::{Answer, Method};
#[cfg(feature = "arbitrary-precision")]
use crate::ladder::digits::Enclosed;
use crate::problem::emission::{Emission, Emitter};
use crate::problem::receiver::{Receiver, albedo};

/// The largest cost of a Gauss rule.
struct Budget {
    /// Size of the emitter over the distance of its farthest vertex, above which the cheap rule is not worth planning.
    wide: f64,
    /// Nodes that cost as much as the closed form with a derived bound, or with a running one where none is derived.
    cheap: usize,
    /// Nodes that cost as much as the closed form with a running bound.
    running: usize,
    /// Nodes that cost as much as double-double on lanes.
    beside_lanes: usize,
    /// Nodes that cost half as much as double-double with a running bound.
    dear: usize,
}

/// [`Budget::wide`] where the closed form has a running bound.
const WIDE_BESIDE_RUNNING: f64 = 2.0;

impl Budget {
    fn for_emission(emission: &Emission) -> Self {
        match emission {
            Emission::Constant(_) => Self { wide: 0.4, cheap: 110, running: 110, beside_lanes: 900, dear: 2000 },
            Emission::Linear(_) => Self { wide: 0.5, cheap: 260, running: 4000, beside_lanes: 5800, dear: 16000 },
            Emission::Polynomial(_) => {
                Self { wide: WIDE_BESIDE_RUNNING, cheap: 1000, running: 1000, beside_lanes: 1000, dear: 8000 }
            }
        }
    }
}

/// The relative bound that a Gauss rule cannot have less than: the places of its nodes alone are off by more.
const LEAST_OF_RULE: f64 = 12.0 * ROUNDOFF;

/// The share of the tolerance that a rule's truncation may take where it has more than a few nodes: these would be half as many
/// again for full precision. For a finer tolerance than this one it takes nearly all digits anyway.
const TRUNCATED: f64 = 1.0 / 64.0;
const FINE: f64 = 1e-13;

/// Nodes that a Gauss rule may have where nothing else meets the tolerance: a second or so.
const MOST_NODES: usize = 1 << 26;

/// The result of a rung, in normalised lengths and emission.
#[derive(Debug, Clone, Copy)]
pub(super) struct Evaluated {
    pub(super) radiosity: f64,
    pub(super) gradient: Vec3<f64>,
    pub(super) radiosity_error: f64,
    pub(super) gradient_error: f64,
}

impl Evaluated {
    const ZERO: Self = Self { radiosity: 0.0, gradient: Vec3::new(0.0, 0.0, 0.0), radiosity_error: 0.0, gradient_error: 0.0 };

    /// Whether all is finite and both bounds are within `tolerance`, relative.
    #[inline(always)]
    fn meets(&self, tolerance: f64) -> bool {
        self.radiosity_error <= tolerance * self.radiosity.abs() && self.gradient_error <= tolerance * self.gradient.length()
    }

    /// Results in double-double rounded to doubles, given bounds on their errors before.
    fn rounded(radiosity: f64, gradient: Vec3<f64>, [of_radiosity, of_gradient]: [f64; 2]) -> Self {
        let error = |before: f64, size: f64| (before + ROUNDOFF * size) * (1.0 + 8.0 * f64::EPSILON);
        Self {
            radiosity,
            gradient,
            radiosity_error: error(of_radiosity, radiosity.abs()),
            gradient_error: error(of_gradient, gradient.length()),
        }
    }

    /// The larger of the two relative bounds; infinite where one of them bounds nothing.
    fn relative_error(&self) -> f64 {
        let shares = [self.radiosity_error / self.radiosity.abs(), self.gradient_error / self.gradient.length()];
        if shares.iter().any(|share| share.is_nan()) { f64::INFINITY } else { shares[0].max(shares[1]) }
    }
}

/// The end of a climb: the accepted answer, or the result in double-double; the latter apart where its error is the input's.
pub(super) enum Climb<A> {
    Met(A),
    Last(Evaluated),
    LastOfInput(Evaluated),
}

/// The roundoff of double-double over that of doubles is 2^-53, and a root of it falls by half of these digits. An error that falls by
/// less than this is not rounding.
const LEAST_FALL: f64 = 1.0 / (1_u32 << 20) as f64;

/// The result of the direct attempt.
pub(crate) enum DirectAttempt {
    /// The answer, the one that [`Case::answer`] gives.
    Answer(Answer),
    /// No answer, but the plan for the other rungs.
    Plan(Plan),
    /// Neither: it is not sure of the visible part.
    Nothing,
}

impl DirectAttempt {
    /// The closed form in double precision, for a near emitter of constant or linear emission whose visible part double precision
    /// decides, with the plan made on the way.
    #[inline]
    pub(crate) fn new(receiver: &Receiver, emitter: &Emitter, tolerance: f64) -> Result<Self, Error> {
        let narrow = Budget::for_emission(emitter.emission()).wide;
        match emitter.emission() {
            Emission::Constant(_) => {
                let sure = BoundedSum::where_sure(receiver, emitter.polygon(), narrow);
                Self::from(sure, receiver, emitter, tolerance, |case, terms, bound| case.of_unit_emission(terms, *bound))
            }
            Emission::Linear(_) => {
                let of_linear = |case: &Case<'_>, terms: &_, bound: &_| case.of_linear(terms, *bound);
                match edge_lanes::linear::bounded_where_sure(receiver, emitter, narrow, tolerance) {
                    // Apart, so that the common case is not copied.
                    None => {
                        let sure = edge_lanes::linear::bounded_far_out(receiver, emitter, narrow);
                        Self::from(sure, receiver, emitter, tolerance, of_linear)
                    }
                    sure => Self::from(sure, receiver, emitter, tolerance, of_linear),
                }
            }
            Emission::Polynomial(_) => Ok(Self::Nothing),
        }
    }

    #[inline(always)]
    fn from<B>(
        sure: Option<SureCase<B>>,
        receiver: &Receiver,
        emitter: &Emitter,
        tolerance: f64,
        bounded: impl Fn(&Case<'_>, &IrradianceAndGradient<f64>, &B) -> Evaluated,
    ) -> Result<Self, Error> {
        let Some(SureCase { plan, sums }) = sure else { return Ok(Self::Nothing) };
        let Some((terms, bound)) = sums else { return Ok(Self::Plan(plan)) };
        let case = Case { receiver, emitter, occluders: &[], plan: &plan };
        Ok(match case.accepted(&bounded(&case, &terms, &bound), Method::ClosedForm, tolerance)? {
            Some(answer) => Self::Answer(answer),
            None => Self::Plan(plan),
        })
    }
}

impl Case<'_> {
    pub(crate) fn answer(&self, tolerance: f64) -> Result<Answer, Error> {
        if self.is_dark() {
            return Ok(Answer::ZERO);
        }
        if self.plan.on_surface {
            return self.scaled(&self.on_surface(), Method::OnSurface);
        }
        let climb = self.climb::<_, true>(tolerance, |evaluated, method| {
            // Where little but the rounding to doubles is left nothing dearer gives more.
            let least = if method == Method::DoubleDouble { 1.01 * ROUNDOFF } else { 0.0 };
            self.accepted(evaluated, method, tolerance.max(least))
        })?;
        let by_rule = || self.by_quadrature(MOST_NODES, FULL_PRECISION);
        match climb {
            Climb::Met(answer) => Ok(answer),
            #[cfg(feature = "arbitrary-precision")]
            Climb::Last(last) => self.narrowed(self.rounded(tolerance, &last, by_rule)?),
            #[cfg(not(feature = "arbitrary-precision"))]
            Climb::Last(last) => self.by_rule_or(&last, by_rule),
            Climb::LastOfInput(last) => self.by_rule_or(&last, by_rule),
        }
    }

    /// The result in double-double, or that of a Gauss rule where its bound is less.
    #[cold]
    #[inline(never)]
    fn by_rule_or(&self, last: &Evaluated, by_rule: impl FnOnce() -> Option<Evaluated>) -> Result<Answer, Error> {
        let answer = match by_rule() {
            Some(other) if other.relative_error() < last.relative_error() => self.scaled(&other, Method::Quadrature)?,
            _ => self.scaled(last, Method::DoubleDouble)?,
        };
        self.narrowed(answer)
    }

    /// Climbs from rung to rung up to the closed form in double-double, until a result is accepted, for a relative tolerance.
    #[inline(always)]
    pub(super) fn climb<A, const GRADIENT: bool>(
        &self,
        tolerance: f64,
        accepted: impl Fn(&Evaluated, Method) -> Result<Option<A>, Error>,
    ) -> Result<Climb<A>, Error> {
        if self.occluders.is_empty() {
            return self.climb_from::<A, GRADIENT>(None, tolerance, accepted);
        }
        let (hidden, derived) = self.bounded_occluded();
        let in_between = match hidden {
            Hidden::Unsure => Cow::Owned(self.in_between()),
            Hidden::Something => Cow::Borrowed(self.occluders),
            Hidden::Nothing => Cow::Borrowed(&[][..]),
        };
        Case { occluders: &in_between, ..*self }.climb_from::<A, GRADIENT>(derived, tolerance, accepted)
    }

    /// The same, from the closed form in double precision with a derived bound where that is known.
    #[inline(always)]
    fn climb_from<A, const GRADIENT: bool>(
        &self,
        derived: Option<Evaluated>,
        tolerance: f64,
        accepted: impl Fn(&Evaluated, Method) -> Result<Option<A>, Error>,
    ) -> Result<Climb<A>, Error> {
        let budget = Budget::for_emission(self.emitter.emission());
        let tried = Cell::new(false);
        let enough = if tolerance > FINE { TRUNCATED * tolerance } else { FULL_PRECISION };
        let by_rule = |node_limit: usize, enough: f64| -> Result<Option<A>, Error> {
            let Some(quadrature) = self.by_quadrature(node_limit, enough) else { return Ok(None) };
            tried.set(true);
            accepted(&quadrature, Method::Quadrature)
        };
        if self.is_within(budget.wide)
            && let Some(answer) = by_rule(budget.cheap, FULL_PRECISION)?
        {
            return Ok(Climb::Met(answer));
        }
        let derived = derived.or_else(|| self.bounded());
        if derived.is_none()
            && !tried.get()
            && budget.running > budget.cheap
            && self.is_within(WIDE_BESIDE_RUNNING)
            && let Some(answer) = by_rule(budget.running, enough)?
        {
            return Ok(Climb::Met(answer));
        }
        let closed_form = derived.unwrap_or_else(|| self.certified::<f64, GRADIENT>());
        if let Some(answer) = accepted(&closed_form, Method::ClosedForm)? {
            return Ok(Climb::Met(answer));
        }
        if self.is_for_lanes(derived.as_ref(), &accepted) {
            let by_rounding = [closed_form.radiosity.abs(), closed_form.gradient.length()].map(|size| LEAST_OF_RULE * size);
            let [radiosity_error, gradient_error] = by_rounding;
            let best = Evaluated { radiosity_error, gradient_error, ..closed_form };
            if !tried.get()
                && !matches!(accepted(&best, Method::Quadrature), Ok(None))
                && let Some(answer) = by_rule(budget.beside_lanes, enough)?
            {
                return Ok(Climb::Met(answer));
            }
            if let Some(precise) = self.on_double_double_lanes(&closed_form)
                && let Some(answer) = accepted(&precise, Method::DoubleDouble)?
            {
                return Ok(Climb::Met(answer));
            }
        }
        if !tried.get()
            && let Some(answer) = by_rule(budget.dear, enough)?
        {
            return Ok(Climb::Met(answer));
        }
        let precise = self.certified::<DoubleDouble, GRADIENT>();
        Ok(match accepted(&precise, Method::DoubleDouble)? {
            Some(answer) => Climb::Met(answer),
            None if self.is_of_input(&precise, &closed_form) => Climb::LastOfInput(precise),
            None => Climb::Last(precise),
        })
    }

    /// The closed form with a running bound, with as many bits as it takes, rounded to doubles; or a Gauss rule of any cost,
    /// where the input leaves the closed form a wider bound; or the result with fewer bits, where more would take too long.
    #[cfg(feature = "arbitrary-precision")]
    #[cold]
    #[inline(never)]
    fn rounded(&self, tolerance: f64, before: &Evaluated, by_rule: impl FnOnce() -> Option<Evaluated>) -> Result<Answer, Error> {
        if let Some([radiosity_error, gradient_error]) = self.below_range()?
            && gradient_error < f64::MIN_POSITIVE
        {
            return Ok(Answer { radiosity_error, gradient_error, method: Method::Quadrature, ..Answer::ZERO });
        }
        let enough = enough_for_doubles(tolerance);
        let stays_open = |enclosed: &Enclosed| enclosed.stays_open(self, enough);
        let refined = refined(PRECISIONS, enough, Enclosed::relative_error, stays_open, || Enclosed::find(self));
        let enclosed = match refined {
            Outcome::Nothing { .. } => return Ok(Answer::ZERO),
            Outcome::Found(Refined { result: enclosed, is_enough: true, .. }) => return enclosed.to_answer(self),
            Outcome::Found(Refined { result: enclosed, .. }) => Some(enclosed),
            Outcome::TooDear => None,
        };
        let closest = enclosed.as_ref().map_or_else(|| Magnitude::from(before.relative_error()), Enclosed::relative_error);
        match (by_rule(), enclosed) {
            (Some(quadrature), _) if Magnitude::from(quadrature.relative_error()) < closest => {
                self.scaled(&quadrature, Method::Quadrature)
            }
            (_, Some(enclosed)) => enclosed.to_answer(self),
            (_, None) => self.scaled(before, Method::DoubleDouble),
        }
    }

    /// Whether an error in double-double is the input's, given that of double precision.
    fn is_of_input(&self, precise: &Evaluated, before: &Evaluated) -> bool {
        let radiosity = [precise.radiosity_error, precise.radiosity.abs(), before.radiosity_error];
        let gradient = [precise.gradient_error, precise.gradient.length(), before.gradient_error];
        [radiosity, gradient].into_iter().any(|errors| self.is_error_of_input(errors))
    }

    /// Whether an error in double-double, of something of the size that follows, is the input's, given its error in double precision: the
    /// emitter is off a plane, or its vertex values are off one affine function, and more bits leave that as it is. Where occluders may be
    /// between, more bits may decide which part is visible.
    pub(super) fn is_error_of_input(&self, [error, size, before]: [f64; 3]) -> bool {
        // Less the rounding to doubles.
        self.occluders.is_empty() && self.emitter.has_defect() && error - 1.01 * ROUNDOFF * size > LEAST_FALL * before
    }

    /// Whether the emitter is as small as that over the distance of its farthest vertex.
    fn is_within(&self, wide: f64) -> bool {
        self.emitter.polygon().size() * self.plan.power <= wide
    }

    /// The answer of a Gauss rule of at most so many nodes and a truncation that is enough, relative.
    fn by_quadrature(&self, node_limit: usize, enough: f64) -> Option<Evaluated> {
        if !self.occluders.is_empty() {
            return None;
        }
        let integral = gauss::integral(self.receiver, self.emitter, self.plan, node_limit, enough)?;
        let albedo: f64 = albedo(self.receiver);
        // Quotient and product.
        let rounding = 4.0 * ROUNDOFF;
        let size = integral.gradient.length();
        Some(Evaluated {
            radiosity: integral.value * albedo,
            gradient: integral.gradient * albedo,
            radiosity_error: (integral.value_error + rounding * integral.value.abs()) * albedo,
            gradient_error: (integral.gradient_error + rounding * size) * albedo,
        })
    }

    /// The closed form in double precision with a bound derived for it, where there is one.
    #[inline]
    fn bounded(&self) -> Option<Evaluated> {
        let Self { receiver, emitter, occluders, plan } = *self;
        if !occluders.is_empty() {
            return None;
        }
        match emitter.emission() {
            Emission::Constant(_) => {
                let (terms, bound) = BoundedSum::of_polygon(receiver, emitter.polygon(), plan);
                Some(self.of_unit_emission(&terms, bound))
            }
            Emission::Linear(_) if plan.horizon == Horizon::Above => {
                edge_lanes::linear::bounded(receiver, emitter, plan.power).map(|(terms, bound)| self.of_linear(&terms, bound))
            }
            Emission::Linear(_) | Emission::Polynomial(_) => None,
        }
    }

    /// The same for a constant emitter with occluders.
    fn bounded_occluded(&self) -> (Hidden, Option<Evaluated>) {
        if !matches!(self.emitter.emission(), Emission::Constant(_)) {
            return (Hidden::Unsure, None);
        }
        let (hidden, terms, bound) = past_occluders::sums(self);
        (hidden, (hidden == Hidden::Something).then(|| self.of_unit_emission(&terms, bound)))
    }

    /// Whether double-double on lanes is to be tried: where a bound was derived for double precision, this one's is known.
    #[inline(always)]
    fn is_for_lanes<A>(
        &self,
        derived: Option<&Evaluated>,
        accepted: impl Fn(&Evaluated, Method) -> Result<Option<A>, Error>,
    ) -> bool {
        let expected = |evaluated: &Evaluated| {
            let bounds = [evaluated.radiosity_error, evaluated.gradient_error].map(|bound| bound * precise::SHARE);
            Evaluated::rounded(evaluated.radiosity, evaluated.gradient, bounds)
        };
        match derived {
            _ if !self.occluders.is_empty() => false,
            Some(evaluated) => !matches!(accepted(&expected(evaluated), Method::DoubleDouble), Ok(None)),
            None => matches!(self.emitter.emission(), Emission::Linear(_)),
        }
    }

    /// The closed form in double-double on lanes, given that in double precision, with its derived bound where the emission is constant.
    #[cold]
    #[inline(never)]
    fn on_double_double_lanes(&self, before: &Evaluated) -> Option<Evaluated> {
        let Self { receiver, emitter, plan, .. } = *self;
        match emitter.emission() {
            Emission::Constant(_) => {
                let (sums, share) = precise::constant(receiver, emitter.polygon(), plan)?;
                let factor = receiver.albedo() * DoubleDouble::from(emitter.affine().value);
                let radiosity = (receiver.precise_normal().dot(sums.irradiance) * factor).hi;
                let gradient = (sums.gradient * factor).map(|c| c.hi);
                let bounds = [before.radiosity_error, before.gradient_error].map(|bound| bound * share);
                Some(Evaluated::rounded(radiosity, gradient, bounds))
            }
            Emission::Linear(_) => {
                let (sums, unit) = precise::linear(receiver, emitter, plan)?;
                let (_, bound) = edge_lanes::linear::bounded_in(unit, receiver, emitter, plan)?;
                let (radiosity, gradient) = (sums.radiosity(receiver).value(), sums.gradient(receiver).map(Real::value));
                let share = albedo::<f64>(receiver);
                Some(Evaluated::rounded(radiosity, gradient, [share * bound.radiosity, share * bound.gradient]))
            }
            Emission::Polynomial(_) => None,
        }
    }

    /// The answer by the sums of a linear emission and their bounds.
    #[inline(always)]
    fn of_linear(&self, terms: &IrradianceAndGradient<f64>, bound: linear_bound::LinearBound) -> Evaluated {
        let share = albedo::<f64>(self.receiver);
        Evaluated {
            radiosity: terms.radiosity(self.receiver),
            gradient: terms.gradient(self.receiver),
            radiosity_error: share * bound.radiosity,
            gradient_error: share * bound.gradient,
        }
    }

    /// The answer by the sums for a unit emission and their bounds.
    #[inline(always)]
    fn of_unit_emission(&self, terms: &IrradianceAndGradient<f64>, bound: BoundedSum) -> Evaluated {
        let Self { receiver, emitter, .. } = *self;
        let emission = emitter.affine().value;
        let terms = IrradianceAndGradient { irradiance: terms.irradiance * emission, gradient: terms.gradient * emission };
        let share = albedo::<f64>(receiver) * emission.abs();
        Evaluated {
            radiosity: terms.radiosity(receiver),
            gradient: terms.gradient(receiver),
            radiosity_error: share * bound.irradiance,
            gradient_error: share * bound.gradient,
        }
    }

    /// The closed form with a running bound; without the gradient where that is not wanted.
    fn certified<N: Number, const GRADIENT: bool>(&self) -> Evaluated {
        let Some(terms) = IrradianceAndGradient::<Ball<N>>::sum::<true, GRADIENT>(self) else { return Evaluated::ZERO };
        let (radiosity, gradient) = (terms.radiosity(self.receiver), terms.gradient(self.receiver));
        let value_only = Evaluated { radiosity: radiosity.value(), radiosity_error: radiosity.value_error(), ..Evaluated::ZERO };
        if !GRADIENT {
            return value_only;
        }
        let radius = gradient.map(Real::value_error);
        let gradient_error = radius.length() * (1.0 + 8.0 * f64::EPSILON);
        Evaluated { gradient: gradient.map(Real::value), gradient_error, ..value_only }
    }

    /// The answer by a result that meets the tolerance, unless bounds below the normal range are too coarse for it.
    ///
    /// Always inlined: moving the answer costs as much as finding it met.
    #[inline(always)]
    fn accepted(&self, evaluated: &Evaluated, method: Method, tolerance: f64) -> Result<Option<Answer>, Error> {
        if !evaluated.meets(tolerance) {
            return Ok(None);
        }
        let answer = self.scaled(evaluated, method)?;
        let is_fine = answer.radiosity_error.min(answer.gradient_error) >= f64::MIN_POSITIVE || answer.meets(tolerance);
        Ok(Some(answer).filter(|_| is_fine))
    }

    #[inline(always)]
    pub(super) fn scaled(&self, evaluated: &Evaluated, method: Method) -> Result<Answer, Error> {
        if evaluated.radiosity == 0.0 && evaluated.radiosity_error == 0.0 && evaluated.gradient_error == 0.0 {
            return Ok(Answer::ZERO);
        }
        let Vec3 { x, y, z } = evaluated.gradient;
        let ([radiosity], radiosity_error) =
            self.radiosity_unit().components([evaluated.radiosity], evaluated.radiosity_error)?;
        let (gradient, gradient_error) = self.gradient_unit().components([x, y, z], evaluated.gradient_error)?;
        Ok(Answer { radiosity, gradient: gradient.into(), radiosity_error, gradient_error, method })
    }
}
