//! Enclosures of the radiosity at a point and of its gradient: Eq. 1 of HS95 and its derivative, to the digits asked for.
//!
//! With `p = (rho/pi) / |n1|`, everything relative to the receiver and n1 of any length:
//! - value: `B = p sum H/|N|^2 int J B (n1.r)/|r|^4 ds dt` over the fans of each triangle (`N`, `H`: [`crate::surface::Triangle`]; `J = +-(a x b).N`);
//! - gradient, differentiated under the integral and integrated by parts over the emitter, the horizon having no part in it since `n1.r = 0` there:
//!   `p { sum 1/|N|^2 int J [H grad B + N (grad B . r)] (n1.r)/|r|^4 ds dt + sum over edges of int B (n1.r) (dr x r)/|r|^4 }`.
//!   The edge form has no `1/h` in it, while the differentiated kernel cancels as `1/h` on contact.
//!
//! Each pass plans the cells in double precision for the tolerances of the moment, then evaluates them in ball arithmetic; the first passes
//! only learn the magnitudes. The radius returned is the sum of the truncation bounds and the rounding radius: it is proven, not estimated.
//! Units: radiosity as the emission, gradient in that over the unit of length.

use radgrad_core::{Emitter, Receiver};

use crate::Error;
use crate::arithmetic::{Arithmetic, Real};
use crate::astro::Astro;
use crate::ball::{Ball, BallVector, dot, pi, up, vector};
use crate::cell::{Cell, EmissionSize, Shape, Weights};
use crate::double_double::DoubleDouble;
use crate::error::Reached;
use crate::exact::{Exact, scaled};
use crate::integral::{along_ray, over_fan};
use crate::interval::{Interval, power_of_ten};
use crate::source::{Expansion, Source};
use crate::surface::{Fan, Frame, Place, Point, Stretch, fans};

/// Radiosity and gradient, enclosed.
#[derive(Debug, Clone, PartialEq)]
pub struct Enclosure {
    /// `B(x)`.
    pub radiosity: Interval,
    /// Its gradient with respect to x at fixed normal.
    pub gradient: [Interval; 3],
    /// Evaluations of the integrands, over all passes.
    pub evaluations: u64,
    /// What computed it.
    pub arithmetic: Arithmetic,
}

/// What is asked for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Request {
    /// Radiosity relative to itself, gradient relative to its norm: 15 to 200.
    pub digits: u32,
    /// By default the fastest that offers the digits; double-double gives way to more bits where rounding keeps it from them.
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
    let digits = request.digits;
    let within = |arithmetic, least, most| {
        if (least..=most).contains(&digits) { Ok(()) } else { Err(Error::Digits { digits, arithmetic, least, most }) }
    };
    match request.arithmetic {
        Some(Arithmetic::DoubleDouble) => within("double-double", 15, 24)?,
        _ => within("arbitrary-precision", 15, 200)?,
    }
    let problem = Problem::new(receiver, source, request);
    match request.arithmetic {
        Some(Arithmetic::DoubleDouble) => problem.solve::<DoubleDouble>(DOUBLE_DOUBLE_BITS, Arithmetic::DoubleDouble),
        Some(Arithmetic::Astro) => problem.solve_in_bits::<Astro>(Arithmetic::Astro),
        #[cfg(feature = "mpfr")]
        Some(Arithmetic::Mpfr) => problem.solve_in_bits::<crate::mpfr::Mpfr>(Arithmetic::Mpfr),
        None if digits <= 24 => match problem.solve::<DoubleDouble>(DOUBLE_DOUBLE_BITS, Arithmetic::DoubleDouble) {
            Err(Error::Rounding { .. }) => problem.solve_in_bits::<Astro>(Arithmetic::Astro),
            result => result,
        },
        None => problem.solve_in_bits::<Astro>(Arithmetic::Astro),
    }
}

const DOUBLE_DOUBLE_BITS: usize = 106;
/// Share of the tolerance a cell may use in one direction: a few hundred cells stay below it all, as most keep well under their share.
const SHARE: f64 = 1.0 / 256.0;

struct Problem<'a> {
    source: &'a Source<'a>,
    request: &'a Request,
    reflectance: f64,
    frame: Frame,
    /// The emission is scaled by `2^-exponent`; none where nothing reaches the receiver.
    exponent: Option<i32>,
}

/// What multiplies the integrals: `rho / (pi |n1|)`.
type Prefactor<T> = Ball<T>;

/// The geometry and the emission in one arithmetic.
struct Prepared<T> {
    prefactor: Prefactor<T>,
    triangles: Vec<Patch<T>>,
    rays: Vec<Ray<T>>,
}

/// A triangle's fans.
struct Patch<T> {
    expansion: Expansion<T>,
    fans: Vec<Fan<T>>,
    normal: BallVector<T>,
    height: Ball<T>,
    /// `p / |N|^2`.
    factor: Ball<T>,
}

/// Half an edge, from its nearest point outward.
struct Ray<T> {
    foot: BallVector<T>,
    way: BallVector<T>,
    heights: [Ball<T>; 2],
    expansion: Expansion<T>,
    /// `+-way x foot` times the prefactor.
    moment: BallVector<T>,
}

/// Absolute tolerances on value and gradient.
#[derive(Debug, Clone, Copy)]
struct Tolerances {
    value: f64,
    gradient: f64,
}

/// One pass: the integrals and their truncation bounds.
struct Pass<T> {
    value: Ball<T>,
    gradient: BallVector<T>,
    truncation: Tolerances,
}

impl<'a> Problem<'a> {
    fn new(receiver: &Receiver, source: &'a Source<'a>, request: &'a Request) -> Self {
        let frame = Frame::new(receiver, source.polygon());
        let dark = frame.triangles.is_empty() || receiver.reflectance() == 0.0;
        let exponent = if dark { None } else { source.exponent(frame.scale) };
        Self { source, request, reflectance: receiver.reflectance(), frame, exponent }
    }

    /// With as many bits as the digits need, more where cancellation asks for them.
    fn solve_in_bits<T: Real>(&self, arithmetic: Arithmetic) -> Result<Enclosure, Error> {
        let digits = self.request.digits as usize;
        let mut bits = (digits * 10 / 3 + 30).div_ceil(64) * 64;
        loop {
            match self.solve::<T>(bits, arithmetic) {
                Err(Error::Rounding { .. }) if bits <= 8 * digits + 512 => bits += 64,
                result => return result,
            }
        }
    }

    fn solve<T: Real>(&self, bits: usize, arithmetic: Arithmetic) -> Result<Enclosure, Error> {
        let Some(exponent) = self.exponent else {
            let zero = Interval::zero;
            return Ok(Enclosure { radiosity: zero(), gradient: [zero(), zero(), zero()], evaluations: 0, arithmetic });
        };
        let prepared = self.prepare::<T>(exponent, bits);
        let mut evaluations = 0;
        let mut reached =
            Reached { radiosity: 0.0, radiosity_radius: f64::INFINITY, gradient: 0.0, gradient_radius: f64::INFINITY };
        let goal = power_of_ten(-i32::try_from(self.request.digits).unwrap_or(i32::MAX));
        let mut tolerances = prepared.first_tolerances();
        loop {
            let plan = prepared.plan(tolerances)?;
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
                return self.finish(&pass, radius, exponent, evaluations, arithmetic);
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
        radius: Tolerances,
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
        let _ = radius;
        let radiosity = interval(&pass.value, pass.truncation.value, exponent, "the radiosity")?;
        let component =
            |axis: usize| interval(&pass.gradient[axis], pass.truncation.gradient, exponent + self.frame.scale, "the gradient");
        let gradient = [component(0)?, component(1)?, component(2)?];
        Ok(Enclosure { radiosity, gradient, evaluations, arithmetic })
    }

    fn prepare<T: Real>(&self, exponent: i32, bits: usize) -> Prepared<T> {
        let frame = &self.frame;
        let length = Ball::<T>::from_exact(&frame.normal_squared, bits).sqrt();
        let prefactor = Ball::from_f64(self.reflectance, bits).divided_by(&(&pi(bits) * &length));
        let triangles: Vec<Patch<T>> = frame
            .triangles
            .iter()
            .map(|triangle| {
                let square = Ball::from_exact(&crate::exact::dot(&triangle.normal, &triangle.normal), bits);
                let fans = fans(frame, triangle, bits);
                let expansion: Expansion<T> = self.source.expansion(frame, triangle, exponent, bits);
                let expansion = fans.first().map_or_else(|| expansion.clone(), |fan| expansion.moved(&fan.apex));
                Patch {
                    expansion,
                    fans,
                    normal: vector(&triangle.normal, bits),
                    height: Ball::from_exact(&triangle.height, bits),
                    factor: prefactor.divided_by(&square),
                }
            })
            .collect();
        let mut rays = Vec::new();
        for [i, j] in frame.boundary() {
            let owner = frame.triangles.iter().position(|t| (0..3).any(|m| t.corners[m] == i && t.corners[(m + 1) % 3] == j));
            let Some(stretch) = Stretch::<T>::of_edge(frame, [i, j], bits) else { continue };
            let Some(owner) = owner else { continue };
            let (foot, place) = stretch.nearest(frame, [0.0; 3], bits);
            let expansion = triangles[owner].expansion.moved(&foot.position(bits));
            if place != Place::End {
                rays.push(ray(&foot, &stretch.ends[1], true, &prefactor, &expansion, bits));
            }
            if place != Place::Start {
                rays.push(ray(&foot, &stretch.ends[0], false, &prefactor, &expansion, bits));
            }
        }
        Prepared { prefactor, triangles, rays }
    }
}

fn ray<T: Real>(
    foot: &Point<T>,
    end: &Point<T>,
    forward: bool,
    prefactor: &Prefactor<T>,
    expansion: &Expansion<T>,
    bits: usize,
) -> Ray<T> {
    let (position, way) = (foot.position(bits), end.from(foot, bits));
    let heights = [foot.height.clone(), &end.height - &foot.height].map(|h| Ball::from_exact(&h, bits));
    let moment = std::array::from_fn(|i| {
        let (j, k) = ((i + 1) % 3, (i + 2) % 3);
        let component = &(&way[j] * &position[k]) - &(&way[k] * &position[j]);
        let component = prefactor * &component;
        if forward { component } else { -&component }
    });
    Ray { foot: position, way, heights, expansion: expansion.clone(), moment }
}

/// The cells of every fan and ray.
struct Plan {
    fans: Vec<Vec<Cell>>,
    rays: Vec<Vec<Cell>>,
    evaluations: u64,
}

fn sizes<T: Real>(
    expansion: &Expansion<T>,
    apex: &BallVector<T>,
    start: &BallVector<T>,
    way: Option<&BallVector<T>>,
) -> EmissionSize {
    let value = expansion.coefficient([0; 3]).magnitude();
    if expansion.degree == 0 {
        return EmissionSize { value, gradient: 0.0, slopes: [0.0; 3], higher: Vec::new() };
    }
    let unit = |axis: usize| std::array::from_fn(|i| usize::from(i == axis));
    let gradient: BallVector<T> = std::array::from_fn(|axis| expansion.coefficient(unit(axis)).clone());
    let slope = |direction: &BallVector<T>| {
        let slope = dot(&gradient, direction);
        slope.leading() + slope.radius.copysign(slope.leading())
    };
    let mut higher = Vec::new();
    for i in 0..=expansion.degree {
        for j in 0..=expansion.degree - i {
            for k in 0..=expansion.degree - i - j {
                if i + j + k >= 2 {
                    higher.push((expansion.coefficient([i, j, k]).magnitude(), [i, j, k]));
                }
            }
        }
    }
    let norm = gradient.iter().map(|g| g.magnitude() * g.magnitude()).sum::<f64>().sqrt();
    EmissionSize { value, gradient: norm * (1.0 + 1e-12), slopes: [slope(apex), slope(start), way.map_or(0.0, slope)], higher }
}

impl<T: Real> Patch<T> {
    fn shape(&self, fan: &Fan<T>, tolerances: Tolerances) -> Shape {
        let factor = self.factor.magnitude() * fan.measure.magnitude();
        let normal = self.normal.iter().map(|n| n.magnitude() * n.magnitude()).sum::<f64>().sqrt();
        let height = self.height.magnitude();
        let weights = Weights {
            emission: factor * height / tolerances.value,
            gradient: factor * height / tolerances.gradient,
            directional: factor * normal / tolerances.gradient,
        };
        let [apex, start, way] = fan.near;
        let heights = [0, 1, 2].map(|i| fan.heights[i].leading());
        Shape { apex, start, way, heights, emission: sizes(&self.expansion, &fan.apex, &fan.start, Some(&fan.way)), weights }
    }
}

impl<T: Real> Ray<T> {
    fn shape(&self, tolerances: Tolerances) -> Shape {
        let factor = self.moment.iter().map(|m| m.magnitude() * m.magnitude()).sum::<f64>().sqrt();
        let weights = Weights { emission: factor / tolerances.gradient, gradient: 0.0, directional: 0.0 };
        let near = |v: &BallVector<T>| [0, 1, 2].map(|i| v[i].leading());
        let heights = [self.heights[0].leading(), self.heights[1].leading(), 0.0];
        let emission = sizes(&self.expansion, &self.foot, &self.way, None);
        Shape { apex: near(&self.foot), start: near(&self.way), way: [0.0; 3], heights, emission, weights }
    }
}

impl<T: Real> Prepared<T> {
    /// A three-digit guess from above: the form factor is at most 1, and the gradient at most about the value over the distance.
    fn first_tolerances(&self) -> Tolerances {
        let largest = self.triangles.iter().map(|patch| {
            let unit = Tolerances { value: 1.0, gradient: 1.0 };
            let at = |fan: &Fan<T>| {
                let emission = patch.shape(fan, unit).emission;
                emission.value + emission.slopes[1].abs().max((emission.slopes[1] + emission.slopes[2]).abs())
            };
            patch.fans.iter().map(at).fold(0.0, f64::max)
        });
        let value = self.prefactor.magnitude() * largest.fold(0.0, f64::max);
        Tolerances { value: 1e-3 * value, gradient: 1e-3 * value }
    }

    fn plan(&self, tolerances: Tolerances) -> Result<Plan, Error> {
        let mut share = SHARE;
        loop {
            let mut plan = Plan { fans: Vec::new(), rays: Vec::new(), evaluations: 0 };
            let mut error = 0.0;
            for patch in &self.triangles {
                for fan in &patch.fans {
                    let mut cells = Vec::new();
                    patch.shape(fan, tolerances).subdivide(share, &mut cells)?;
                    plan.evaluations += cells.iter().map(|c| (c.orders[0].count * c.orders[1].count) as u64).sum::<u64>();
                    error += cells.iter().map(|c| c.orders[0].error + c.orders[1].error).sum::<f64>();
                    plan.fans.push(cells);
                }
            }
            for ray in &self.rays {
                let mut cells = Vec::new();
                ray.shape(tolerances).subdivide_ray(share, &mut cells)?;
                plan.evaluations += cells.iter().map(|c| c.orders[0].count as u64).sum::<u64>();
                error += cells.iter().map(|c| c.orders[0].error).sum::<f64>();
                plan.rays.push(cells);
            }
            if error <= 1.0 - 1e-9 {
                return Ok(plan);
            }
            share /= 2.0 * error;
        }
    }

    fn evaluate(&self, plan: &Plan, tolerances: Tolerances, bits: usize) -> Pass<T> {
        let zero = || self.prefactor.zero();
        let (mut value, mut gradient) = (zero(), [zero(), zero(), zero()]);
        let mut cells = plan.fans.iter();
        for patch in &self.triangles {
            let square = &patch.factor * &patch.height;
            for (fan, cells) in patch.fans.iter().zip(&mut cells) {
                let moments = over_fan(fan, &patch.expansion, cells, bits);
                value = &value + &(&(&square * &fan.measure) * &moments.emission);
                if patch.expansion.degree > 0 {
                    let factor = &patch.factor * &fan.measure;
                    for axis in 0..3 {
                        let along = &patch.height * &moments.gradient[axis];
                        let across = &patch.normal[axis] * &moments.directional;
                        gradient[axis] = &gradient[axis] + &(&factor * &(&along + &across));
                    }
                }
            }
        }
        for (ray, cells) in self.rays.iter().zip(&plan.rays) {
            let integral = along_ray(&ray.foot, &ray.way, ray.heights.each_ref(), &ray.expansion, cells, bits);
            for axis in 0..3 {
                gradient[axis] = &gradient[axis] + &(&ray.moment[axis] * &integral);
            }
        }
        Pass { value, gradient, truncation: tolerances }
    }
}

impl<T: Real> Pass<T> {
    fn rounding(&self) -> Tolerances {
        Tolerances { value: self.value.radius, gradient: self.gradient.iter().map(|g| g.radius).fold(0.0, f64::max) }
    }

    fn radii(&self) -> Tolerances {
        let rounding = self.rounding();
        Tolerances {
            value: up(rounding.value + self.truncation.value),
            gradient: up(rounding.gradient + self.truncation.gradient),
        }
    }

    fn reached(&self, radius: Tolerances) -> Reached {
        let norm = self.gradient.iter().map(|g| g.leading() * g.leading()).sum::<f64>().sqrt();
        Reached {
            radiosity: self.value.leading(),
            radiosity_radius: radius.value,
            gradient: norm,
            gradient_radius: radius.gradient,
        }
    }

    /// Tolerances for the digits asked where the magnitude is known, and five orders less where it is not; none if rounding is what is in the way.
    fn next_tolerances(&self, last: Tolerances, goal: f64, reached: Reached) -> Option<Tolerances> {
        let rounding = self.rounding();
        let known = |middle: f64, radius: f64| middle.abs() > 4.0 * radius;
        let value_known = known(reached.radiosity, reached.radiosity_radius);
        let gradient_known = known(reached.gradient, 2.0 * reached.gradient_radius);
        let all_known = value_known && gradient_known;
        let next = |last: f64, middle: f64, radius: f64, rounding: f64, known: bool| {
            let target = 0.5 * goal * (middle - 2.0 * radius);
            match known {
                false if rounding > 0.5 * radius => None,
                false => Some(last * 1e-5),
                true if rounding > target => None,
                true if all_known => Some(target.min(last)),
                true => Some(last),
            }
        };
        let value = next(last.value, reached.radiosity.abs(), reached.radiosity_radius, rounding.value, value_known)?;
        let gradient = next(last.gradient, reached.gradient, reached.gradient_radius, rounding.gradient, gradient_known)?;
        Some(Tolerances { value, gradient })
    }
}
