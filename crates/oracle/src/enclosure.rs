//! Enclosures of the radiosity at a point and of its gradient: Eq. 1 of HS95 and its derivative, to the requested digits.
//!
//! With `p = (rho/pi) / |n1|`, everything relative to the receiver and n1 of any length:
//! - value: `B = p sum H/|N|^2 int J B (n1.r)/|r|^4 ds dt` over the fans of each triangle (`N`, `H`:
//!   [`crate::enclosure::surface::Triangle`]; `J = +-(a x b).N`);
//! - gradient, differentiated under the integral and integrated by parts over the emitter, the horizon having no part in it
//!   since `n1.r = 0` there: `p { sum 1/|N|^2 int J [H grad B + N (grad B . r)] (n1.r)/|r|^4 ds dt + sum over edges of int B
//!   (n1.r) (dr x r)/|r|^4 }`. The edge form has no `1/h` in it, while the differentiated kernel cancels as `1/h` on contact.
//!
//! Each pass plans the cells in double precision for the tolerances of the moment, then evaluates them in ball arithmetic; the
//! first passes only learn the magnitudes. The radius returned is the sum of the truncation bounds and the rounding radius: it
//! is proven, not estimated. Units: radiosity as the emission, gradient in that over the unit of length.

pub(crate) mod arithmetic;
mod astro;
mod ball;
mod cell;
mod cone;
mod double_double;
mod exact;
mod integral;
pub(crate) mod interval;
mod legendre;
mod limbs;
#[cfg(feature = "mpfr")]
mod mpfr;
mod outline;
mod pass;
mod shadow;
pub(crate) mod source;
mod surface;
pub(crate) mod triangulation;
mod view;

use glam::DVec3;
use radgrad_core::{Emitter, Polygon, Receiver};

use crate::Error;
use crate::enclosure::arithmetic::{Arithmetic, Real};
use crate::enclosure::astro::Astro;
use crate::enclosure::ball::{Ball, up};
use crate::enclosure::double_double::DoubleDouble;
use crate::enclosure::exact::scaled;
use crate::enclosure::interval::{Interval, power_of_ten};
use crate::enclosure::limbs::Limbs;
use crate::enclosure::pass::{Pass, Prepared, Tolerances};
use crate::enclosure::source::Source;
use crate::enclosure::surface::{Body, Frame, displaced};
use crate::enclosure::view::View;
use crate::error::Reached;

/// Radiosity and gradient, enclosed.
///
/// ```
/// # use radgrad_core::{DVec3, Emission, Emitter, Polygon, Receiver};
/// # let triangle = Polygon::new(vec![DVec3::Z, DVec3::new(0.0, 1.0, 1.0), DVec3::new(1.0, 0.0, 1.0)])?;
/// # let lamp = Emitter::new(triangle, Emission::Constant(1.0))?;
/// # let floor = Receiver::new(DVec3::ZERO, DVec3::Z, 1.0)?;
/// let truth = radgrad_oracle::enclose(&floor, &lamp, 30)?;
/// let answer = radgrad_core::evaluate(&floor, &lamp, &[])?;
/// assert!(truth.radiosity.error_of(answer.radiosity) <= answer.radiosity_error);
/// assert!(truth.gradient[2].radius() < 1e-29 * answer.gradient.length());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Enclosure {
    /// `B(x)`.
    pub radiosity: Interval,
    /// Its gradient with respect to x at fixed normal.
    pub gradient: [Interval; 3],
    /// Evaluations of the integrands, over all passes.
    pub evaluations: u64,
    /// The arithmetic that was used.
    pub arithmetic: Arithmetic,
    /// The part of the radii due to rounding: of the radiosity's, and of the largest of the gradient's.
    pub rounding: [f64; 2],
}

/// The requested digits and arithmetic.
///
/// ```
/// use radgrad_oracle::{Request, Source, enclose_source};
/// # use radgrad_core::{DVec3, Emission, Emitter, Polygon, Receiver};
/// # let triangle = Polygon::new(vec![DVec3::Z, DVec3::new(0.0, 1.0, 1.0), DVec3::new(1.0, 0.0, 1.0)])?;
/// # let lamp = Emitter::new(triangle, Emission::Constant(1.0))?;
/// # let floor = Receiver::new(DVec3::ZERO, DVec3::Z, 1.0)?;
/// let request = Request { budget: 1_000_000, ..Request::digits(20) };
/// let truth = enclose_source(&floor, &Source::Emitter(&lamp), &request)?;
/// assert!(truth.evaluations <= request.budget);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Request {
    /// Radiosity relative to itself, gradient relative to its norm: 15 to 200.
    pub digits: u32,
    /// The arithmetic; by default the fastest that offers the digits: double-double gives way to more bits where rounding keeps
    /// it from them.
    pub arithmetic: Option<Arithmetic>,
    /// Evaluations of the integrands allowed.
    pub budget: u64,
}

impl Request {
    /// A request for so many digits.
    #[must_use]
    pub const fn digits(digits: u32) -> Self {
        Self { digits, arithmetic: None, budget: 50_000_000 }
    }
}

/// A motion of a case: rates of change by a parameter. Vertices without a rate stay where they are.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Motion {
    /// Of the emitter's vertices.
    pub vertices: Vec<DVec3>,
    /// Of each occluder's vertices.
    pub occluders: Vec<Vec<DVec3>>,
    /// Of the receiver's normal as given, of any length.
    pub normal: DVec3,
}

/// Encloses radiosity and gradient at `receiver` due to the whole of `emitter`.
///
/// ```
/// use radgrad_core::{DVec3, Emission, Emitter, Polygon, Receiver};
/// use radgrad_oracle::enclose;
/// let receiver = Receiver::new(DVec3::ZERO, DVec3::Z, 1.0)?;
/// let square = [(0.0, 0.0), (0.0, 1.0), (1.0, 1.0), (1.0, 0.0)].map(|(x, y)| DVec3::new(x, y, 1.0));
/// let emitter = Emitter::new(Polygon::new(square.to_vec())?, Emission::Constant(1.0))?;
/// let enclosure = enclose(&receiver, &emitter, 20)?;
/// assert!(enclosure.radiosity.error_of(0.138_531_605_994_893) < 1e-15);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// If `digits` is not in 15..=200, the budget is exhausted, or a number leaves the range of a double.
pub fn enclose(receiver: &Receiver, emitter: &Emitter, digits: u32) -> Result<Enclosure, Error> {
    enclose_source(receiver, &Source::Emitter(emitter), &Request::digits(digits))
}

/// The same for any emission, arithmetic and budget.
///
/// # Errors
/// As [`enclose`]; with the arithmetic given, also if its rounding is too coarse.
pub fn enclose_source(receiver: &Receiver, source: &Source<'_>, request: &Request) -> Result<Enclosure, Error> {
    enclose_source_occluded(receiver, source, &[], request)
}

/// Encloses radiosity and gradient at `receiver` due to the part of `emitter` that it sees past opaque polygons.
///
/// A point of the emitter is hidden if an occluder meets the open segment between it and the receiver, from either side; an
/// occluder in the plane of one of the two hides nothing, and one that cuts the emitter hides only the region that its near part
/// covers. Like the emitter, an occluder that is not exactly planar is the surface of the triangles that ear clipping gives. Which
/// parts are seen is decided exactly. Where two edges of different depth are seen in one plane the gradient jumps; the one enclosed
/// is then of either side.
///
/// ```
/// use radgrad_core::{DVec3, Emission, Emitter, Polygon, Receiver};
/// use radgrad_oracle::enclose_occluded;
/// let rectangle = |x: [f64; 2], z| {
///     Polygon::new([(0, 0.0), (0, 1.0), (1, 1.0), (1, 0.0)].map(|(i, y)| DVec3::new(x[i], y, z)).to_vec())
/// };
/// let receiver = Receiver::new(DVec3::ZERO, DVec3::Z, 1.0)?;
/// let lamp = Emitter::new(rectangle([-1.0, 1.0], 1.0)?, Emission::Constant(1.0))?;
/// let half = enclose_occluded(&receiver, &lamp, &[rectangle([-1.0, 0.0], 0.5)?], 20)?;
/// assert!(half.radiosity.error_of(0.138_531_605_994_893) < 1e-15);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// As [`enclose`].
pub fn enclose_occluded(receiver: &Receiver, emitter: &Emitter, occluders: &[Polygon], digits: u32) -> Result<Enclosure, Error> {
    enclose_source_occluded(receiver, &Source::Emitter(emitter), occluders, &Request::digits(digits))
}

/// The same for any emission, arithmetic and budget.
///
/// # Errors
/// As [`enclose_source`].
pub fn enclose_source_occluded(
    receiver: &Receiver,
    source: &Source<'_>,
    occluders: &[Polygon],
    request: &Request,
) -> Result<Enclosure, Error> {
    enclose_moved(receiver, source, occluders, &Motion::default(), 0.0, request)
}

/// The same after a motion by that much of its parameter: no coordinate is rounded on the way, however short it is. A polygon keeps the
/// triangles that it has before.
///
/// # Errors
/// As [`enclose_source`].
pub fn enclose_moved(
    receiver: &Receiver,
    source: &Source<'_>,
    occluders: &[Polygon],
    motion: &Motion,
    parameter: f64,
    request: &Request,
) -> Result<Enclosure, Error> {
    let digits = request.digits;
    let within = |arithmetic, least, most| {
        if (least..=most).contains(&digits) { Ok(()) } else { Err(Error::Digits { digits, arithmetic, least, most }) }
    };
    match request.arithmetic {
        Some(Arithmetic::DoubleDouble) => within("double-double", 15, 24)?,
        _ => within("arbitrary-precision", 15, 200)?,
    }
    let problem = Problem::new(receiver, source, occluders, motion, parameter, request);
    match request.arithmetic {
        Some(Arithmetic::DoubleDouble) => problem.solve::<DoubleDouble>(DOUBLE_DOUBLE_BITS, Arithmetic::DoubleDouble),
        Some(Arithmetic::Astro) => problem.solve_in_bits(|bits| problem.solve::<Astro>(bits, Arithmetic::Astro)),
        Some(Arithmetic::Limbs) => problem.solve_in_limbs(),
        #[cfg(feature = "mpfr")]
        Some(Arithmetic::Mpfr) => {
            problem.solve_in_bits(|bits| problem.solve::<crate::enclosure::mpfr::Mpfr>(bits, Arithmetic::Mpfr))
        }
        None if digits <= 24 => match problem.solve::<DoubleDouble>(DOUBLE_DOUBLE_BITS, Arithmetic::DoubleDouble) {
            Err(Error::Rounding { .. }) => problem.solve_in_limbs(),
            result => result,
        },
        None => problem.solve_in_limbs(),
    }
}

const DOUBLE_DOUBLE_BITS: usize = 106;
struct Problem<'a> {
    source: &'a Source<'a>,
    request: &'a Request,
    reflectance: f64,
    frame: Frame,
    view: View,
    /// The emission is scaled by `2^-exponent`; none where nothing reaches the receiver.
    exponent: Option<i32>,
}

impl<'a> Problem<'a> {
    fn new(
        receiver: &Receiver,
        source: &'a Source<'a>,
        occluders: &[Polygon],
        motion: &Motion,
        parameter: f64,
        request: &'a Request,
    ) -> Self {
        let normal = displaced(receiver.given_normal(), motion.normal, parameter);
        let emitter = Body::new(source.polygon(), &motion.vertices, parameter);
        let frame = Frame::new(receiver.position(), &normal, &emitter);
        let rates = motion.occluders.iter().map(Vec::as_slice).chain(std::iter::repeat(&[][..]));
        let occluders: Vec<Body<'_>> = occluders.iter().zip(rates).map(|(o, rates)| Body::new(o, rates, parameter)).collect();
        let view = if occluders.is_empty() { View::free(&frame) } else { View::past(&frame, &occluders) };
        let dark = view.pieces.is_empty() || receiver.reflectance() == 0.0;
        let exponent = if dark { None } else { source.exponent(frame.scale) };
        Self { source, request, reflectance: receiver.reflectance(), frame, view, exponent }
    }

    /// Solves with as many bits as the digits need, more where cancellation takes them.
    fn solve_in_bits(&self, solve: impl Fn(usize) -> Result<Enclosure, Error>) -> Result<Enclosure, Error> {
        let digits = self.request.digits as usize;
        let mut bits = (digits * 10 / 3 + 30).div_ceil(64) * 64;
        loop {
            match solve(bits) {
                Err(Error::Rounding { .. }) if bits <= 8 * digits + 512 => bits += 64,
                result => return result,
            }
        }
    }

    /// The same on limbs that need no memory of their own while there are no more than eight, which is soonest.
    fn solve_in_limbs(&self) -> Result<Enclosure, Error> {
        self.solve_in_bits(|bits| match bits {
            ..=192 => self.solve::<Limbs<3>>(192, Arithmetic::Limbs),
            256 => self.solve::<Limbs<4>>(bits, Arithmetic::Limbs),
            320 => self.solve::<Limbs<5>>(bits, Arithmetic::Limbs),
            384 => self.solve::<Limbs<6>>(bits, Arithmetic::Limbs),
            448 => self.solve::<Limbs<7>>(bits, Arithmetic::Limbs),
            512 => self.solve::<Limbs<8>>(bits, Arithmetic::Limbs),
            _ => self.solve::<Astro>(bits, Arithmetic::Astro),
        })
    }

    fn solve<T: Real>(&self, bits: usize, arithmetic: Arithmetic) -> Result<Enclosure, Error> {
        let Some(exponent) = self.exponent else {
            let zero = Interval::zero;
            let gradient = [zero(), zero(), zero()];
            return Ok(Enclosure { radiosity: zero(), gradient, evaluations: 0, arithmetic, rounding: [0.0; 2] });
        };
        // A factor of the whole: without its power of two, no arithmetic meets a subnormal double.
        let (reflectance, power) = libm::frexp(self.reflectance);
        let prepared = Prepared::<T>::new(self.source, &self.frame, &self.view, reflectance, exponent, bits);
        let mut evaluations = 0;
        let mut reached =
            Reached { radiosity: 0.0, radiosity_radius: f64::INFINITY, gradient: 0.0, gradient_radius: f64::INFINITY };
        let goal = power_of_ten(-i32::try_from(self.request.digits).unwrap_or(i32::MAX));
        let mut tolerances = prepared.first_tolerances();
        loop {
            let plan = prepared.plan(tolerances, self.request.budget)?;
            evaluations += plan.evaluations;
            if evaluations > self.request.budget {
                let (digits, allowed) = (self.request.digits, self.request.budget);
                return Err(Error::Budget { needed: evaluations, allowed, digits, reached });
            }
            let pass = prepared.evaluate(&plan, tolerances, bits);
            let radius = pass.radii();
            reached = pass.reached(radius);
            if !(radius.value.is_finite() && radius.gradient.is_finite()) {
                return Err(Error::Range { quantity: "the radius of an integral" });
            }
            if radius.value <= goal * reached.radiosity.abs() && radius.gradient <= goal * reached.gradient {
                return self.finish(&pass, exponent + power, evaluations, arithmetic);
            }
            tolerances = pass.next_tolerances(tolerances, goal, reached).ok_or(Error::Rounding {
                bits,
                digits: self.request.digits,
                reached,
            })?;
        }
    }

    /// Back to the units of the caller, exactly but for the radius.
    fn finish<T: Real>(
        &self,
        pass: &Pass<T>,
        exponent: i32,
        evaluations: u64,
        arithmetic: Arithmetic,
    ) -> Result<Enclosure, Error> {
        let interval = |ball: &Ball<T>, truncation: f64, power: i32, quantity| {
            let radius = up(scaled(up(ball.radius + truncation), power));
            let middle = ball.middle.to_exact().times_power(power);
            let range = middle.leading().is_finite() && radius.is_finite();
            if range { Ok(Interval::new(middle, radius)) } else { Err(Error::Range { quantity }) }
        };
        let radiosity = interval(&pass.value, pass.truncation.value, exponent, "the radiosity")?;
        let component =
            |axis: usize| interval(&pass.gradient[axis], pass.truncation.gradient, exponent + self.frame.scale, "the gradient");
        let gradient = [component(0)?, component(1)?, component(2)?];
        let Tolerances { value, gradient: slope } = pass.rounding();
        let rounding = [up(scaled(value, exponent)), up(scaled(slope, exponent + self.frame.scale))];
        Ok(Enclosure { radiosity, gradient, evaluations, arithmetic, rounding })
    }
}
