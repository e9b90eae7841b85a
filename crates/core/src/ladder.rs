//! The answer to a tolerance, looked for from the cheap to the dear, as Ziv's strategy for elementary functions does.
//!
//! 1. A Gauss rule on the emitter with an a-priori bound ([`crate::gauss`]), where few nodes do: far away.
//! 2. The closed form in double precision with its bound: derived for a constant emitter ([`crate::constant`]) and for a linear
//!    one that is seen whole ([`crate::linear`]), running otherwise ([`crate::certify`]), where the rule may cost more before it.
//! 3. The Gauss rule with more nodes, where that is still cheaper than:
//! 4. the closed form in double-double with a running bound;
//! 5. the same with 256 to 8448 bits, rounded to doubles, where the crate is built with arbitrary precision.
//!
//! A rung whose bound is above the tolerance hands over to the next; where all are, the one with the smallest bound answers.

mod value;

use glam::DVec3;

#[cfg(feature = "arbitrary-precision")]
use crate::big::{Magnitude, PRECISIONS, Refined, enough_for_doubles, refined};
use crate::certify::Ball;
use crate::constant::BoundedSum;
#[cfg(feature = "arbitrary-precision")]
use crate::digits::Enclosed;
use crate::double_double::DoubleDouble;
use crate::evaluate::{Answer, Method};
use crate::gauss::Rule;
use crate::number::{Number, ROUNDOFF};
use crate::plan::{Horizon, Plan};
use crate::real::Real;
use crate::terms::{Terms, albedo};
use crate::unit::Unit;
use crate::vec3::Vec3;
use crate::{Emission, Emitter, Error, Polygon, Receiver, linear};

/// What a Gauss rule may cost.
struct Budget {
    /// Size of the emitter over the distance of its farthest vertex, above which the cheap rule is not worth planning.
    wide: f64,
    /// Nodes that cost as much as the closed form with a derived bound, or with a running one where none is derived.
    cheap: usize,
    /// Nodes that cost as much as the closed form with a running bound.
    running: usize,
    /// Nodes that cost half as much as it does in double-double.
    dear: usize,
}

/// [`Budget::wide`] where the closed form has a running bound.
const WIDE_BESIDE_RUNNING: f64 = 2.0;

impl Budget {
    fn of(emission: &Emission) -> Self {
        match emission {
            Emission::Constant(_) => Self { wide: 0.25, cheap: 110, running: 110, dear: 2000 },
            Emission::Linear(_) => Self { wide: 0.5, cheap: 250, running: 4000, dear: 16000 },
            Emission::Polynomial(_) => Self { wide: WIDE_BESIDE_RUNNING, cheap: 1000, running: 1000, dear: 8000 },
        }
    }
}

/// What a rung of the ladder evaluates.
#[derive(Clone, Copy)]
pub(crate) struct Case<'a> {
    pub(crate) receiver: &'a Receiver,
    pub(crate) emitter: &'a Emitter,
    pub(crate) occluders: &'a [&'a Polygon],
    pub(crate) plan: &'a Plan,
}

/// What a rung found, in normalised lengths and emission.
#[derive(Debug, Clone, Copy)]
struct Found {
    radiosity: f64,
    gradient: Vec3<f64>,
    radiosity_error: f64,
    gradient_error: f64,
}

impl Found {
    const ZERO: Self = Self { radiosity: 0.0, gradient: Vec3::new(0.0, 0.0, 0.0), radiosity_error: 0.0, gradient_error: 0.0 };

    /// Whether all is finite and both bounds are within `tolerance`, relative.
    fn meets(&self, tolerance: f64) -> bool {
        self.radiosity_error <= tolerance * self.radiosity.abs() && self.gradient_error <= tolerance * self.gradient.length()
    }

    /// The larger of the two relative bounds; infinite where one of them bounds nothing.
    fn relative_error(&self) -> f64 {
        let shares = [self.radiosity_error / self.radiosity.abs(), self.gradient_error / self.gradient.length()];
        if shares.iter().any(|share| share.is_nan()) { f64::INFINITY } else { shares[0].max(shares[1]) }
    }
}

impl Case<'_> {
    pub(crate) fn answer(&self, tolerance: f64) -> Result<Answer, Error> {
        if self.is_dark() {
            return Ok(Answer::ZERO);
        }
        let budget = Budget::of(self.emitter.emission());
        let mut rule = if self.is_within(budget.wide) { self.rule() } else { None };
        if let Some(found) = self.by_few_nodes(rule.as_ref(), budget.cheap)
            && let Some(answer) = self.accepted(&found, Method::Quadrature, tolerance)?
        {
            return Ok(answer);
        }
        let derived = self.bounded();
        if derived.is_none() && budget.running > budget.cheap && self.is_within(WIDE_BESIDE_RUNNING) {
            rule = rule.or_else(|| self.rule());
            if let Some(found) = self.by_few_nodes(rule.as_ref(), budget.running)
                && let Some(answer) = self.accepted(&found, Method::Quadrature, tolerance)?
            {
                return Ok(answer);
            }
        }
        let found = derived.unwrap_or_else(|| self.certified::<f64>());
        if let Some(answer) = self.accepted(&found, Method::ClosedForm, tolerance)? {
            return Ok(answer);
        }
        rule = rule.or_else(|| self.rule());
        if let Some(found) = self.by_few_nodes(rule.as_ref(), budget.dear)
            && let Some(answer) = self.accepted(&found, Method::Quadrature, tolerance)?
        {
            return Ok(answer);
        }
        let found = self.certified::<DoubleDouble>();
        // Where little but the rounding to doubles is left nothing dearer gives more.
        if let Some(answer) = self.accepted(&found, Method::DoubleDouble, tolerance.max(1.01 * ROUNDOFF))? {
            return Ok(answer);
        }
        let by_rule = || rule.as_ref().map(|rule| self.by_quadrature(rule));
        #[cfg(feature = "arbitrary-precision")]
        return self.rounded(tolerance, by_rule);
        #[cfg(not(feature = "arbitrary-precision"))]
        match by_rule() {
            Some(other) if other.relative_error() < found.relative_error() => self.scaled(&other, Method::Quadrature),
            _ => self.scaled(&found, Method::DoubleDouble),
        }
    }

    /// The closed form with a running bound, with as many bits as it takes, rounded to doubles; or a Gauss rule of any cost,
    /// where the input leaves the closed form a wider bound.
    #[cfg(feature = "arbitrary-precision")]
    #[cold]
    #[inline(never)]
    fn rounded(&self, tolerance: f64, by_rule: impl FnOnce() -> Option<Found>) -> Result<Answer, Error> {
        let enough = enough_for_doubles(tolerance);
        let Refined { found, is_enough, .. } =
            refined(PRECISIONS, enough, Enclosed::relative_error, || Enclosed::is_coincidence(self), || Enclosed::find(self));
        let Some(enclosed) = found else { return Ok(Answer::ZERO) };
        if !is_enough
            && let Some(found) = by_rule()
            && Magnitude::from(found.relative_error()) < enclosed.relative_error()
        {
            return self.scaled(&found, Method::Quadrature);
        }
        enclosed.to_answer(self)
    }

    /// Whether the emitter is as small as that over the distance of its farthest vertex.
    fn is_within(&self, wide: f64) -> bool {
        self.emitter.polygon().size() * self.plan.power <= wide
    }

    fn rule(&self) -> Option<Rule<'_>> {
        if self.occluders.is_empty() { Rule::new(self.receiver, self.emitter, self.plan) } else { None }
    }

    /// What a rule of at most so many nodes gives.
    fn by_few_nodes(&self, rule: Option<&Rule<'_>>, most: usize) -> Option<Found> {
        rule.filter(|rule| rule.nodes() <= most).map(|rule| self.by_quadrature(rule))
    }

    fn by_quadrature(&self, rule: &Rule<'_>) -> Found {
        let integral = rule.integrate();
        let albedo: f64 = albedo(self.receiver);
        // Quotient and product.
        let rounding = 4.0 * ROUNDOFF;
        let size = integral.gradient.length();
        Found {
            radiosity: integral.value * albedo,
            gradient: integral.gradient * albedo,
            radiosity_error: (integral.value_error + rounding * integral.value.abs()) * albedo,
            gradient_error: (integral.gradient_error + rounding * size) * albedo,
        }
    }

    /// The closed form in double precision with a bound derived for it, where there is one.
    #[inline]
    fn bounded(&self) -> Option<Found> {
        if !self.occluders.is_empty() {
            return None;
        }
        match self.emitter.emission() {
            Emission::Constant(_) => Some(self.bounded_constant()),
            Emission::Linear(_) if self.plan.horizon == Horizon::Above => self.bounded_linear(),
            Emission::Linear(_) | Emission::Polynomial(_) => None,
        }
    }

    fn bounded_linear(&self) -> Option<Found> {
        let Self { receiver, emitter, plan, .. } = *self;
        let (terms, bound) = linear::bounded(receiver, emitter, plan.power)?;
        let share = albedo::<f64>(receiver);
        Some(Found {
            radiosity: terms.radiosity(receiver),
            gradient: terms.gradient(receiver),
            radiosity_error: share * bound.radiosity,
            gradient_error: share * bound.gradient,
        })
    }

    fn bounded_constant(&self) -> Found {
        let Self { receiver, emitter, plan, .. } = *self;
        let (terms, bound) = BoundedSum::of(receiver, emitter.polygon(), plan);
        let emission = emitter.affine().value;
        let terms = Terms { irradiance: terms.irradiance * emission, gradient: terms.gradient * emission };
        let share = albedo::<f64>(receiver) * emission.abs();
        Found {
            radiosity: terms.radiosity(receiver),
            gradient: terms.gradient(receiver),
            radiosity_error: share * bound.irradiance,
            gradient_error: share * bound.gradient,
        }
    }

    /// The closed form with a running bound.
    fn certified<N: Number>(&self) -> Found {
        let Some(terms) = Terms::<Ball<N>>::sum::<true, true>(self) else { return Found::ZERO };
        let (radiosity, gradient) = (terms.radiosity(self.receiver), terms.gradient(self.receiver));
        let radius = gradient.map(Real::value_error);
        Found {
            radiosity: radiosity.value(),
            gradient: gradient.map(Real::value),
            radiosity_error: radiosity.value_error(),
            gradient_error: radius.length() * (1.0 + 8.0 * f64::EPSILON),
        }
    }

    /// Whether nothing is emitted, or all of it absorbed.
    pub(crate) fn is_dark(&self) -> bool {
        self.emitter.is_dark() || self.receiver.reflectance() == 0.0
    }

    /// The answer to what meets the tolerance, unless bounds below the normal range are too coarse for it.
    ///
    /// Always inlined: moving the answer costs as much as finding it met.
    #[inline(always)]
    fn accepted(&self, found: &Found, method: Method, tolerance: f64) -> Result<Option<Answer>, Error> {
        if !found.meets(tolerance) {
            return Ok(None);
        }
        let answer = self.scaled(found, method)?;
        let is_fine = answer.radiosity_error.min(answer.gradient_error) >= f64::MIN_POSITIVE || answer.meets(tolerance);
        Ok(Some(answer).filter(|_| is_fine))
    }

    #[inline]
    fn scaled(&self, found: &Found, method: Method) -> Result<Answer, Error> {
        if found.radiosity == 0.0 && found.radiosity_error == 0.0 && found.gradient_error == 0.0 {
            return Ok(Answer::ZERO);
        }
        let Vec3 { x, y, z } = found.gradient;
        let ([radiosity], radiosity_error) = self.radiosity_unit().components([found.radiosity], found.radiosity_error)?;
        let (gradient, gradient_error) = self.gradient_unit().components([x, y, z], found.gradient_error)?;
        Ok(Answer { radiosity, gradient: gradient.into(), radiosity_error, gradient_error, method })
    }

    /// A normalised radiosity in the unit of the emission.
    #[inline]
    pub(crate) fn radiosity(&self, normalised: f64) -> Result<f64, Error> {
        self.radiosity_unit().plain([normalised]).map(|[radiosity]| radiosity)
    }

    /// A normalised gradient in the unit of the emission over that of length.
    #[inline]
    pub(crate) fn gradient(&self, Vec3 { x, y, z }: Vec3<f64>) -> Result<DVec3, Error> {
        self.gradient_unit().plain([x, y, z]).map(DVec3::from)
    }

    #[inline]
    pub(crate) fn radiosity_unit(&self) -> Unit {
        Unit::of_derivative(0, "radiosity", self.plan, self.emitter)
    }

    #[inline]
    pub(crate) fn gradient_unit(&self) -> Unit {
        Unit::of_derivative(1, "gradient", self.plan, self.emitter)
    }
}
