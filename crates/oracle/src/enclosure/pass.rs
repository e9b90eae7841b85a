//! One pass of an enclosure: cells for given tolerances, the integrals over them, and the radii that result.
//!
//! A pass knows nothing of digits; it encloses to absolute tolerances and reports the part of rounding in the radii.

use crate::Error;
use crate::enclosure::arithmetic::Real;
use crate::enclosure::ball::{Ball, BallVector, dot, pi, up, vector};
use crate::enclosure::cell::{Cell, EmissionSize, Shape, Weights};
use crate::enclosure::integral::{along_ray, over_fan};
use crate::enclosure::outline::{Place, Point};
use crate::enclosure::source::{Expansion, Source};
use crate::enclosure::surface::{Fan, Frame, Jacobian, fans};
use crate::enclosure::view::{Border, View};
use crate::error::Reached;

/// Share of the tolerance a cell may use in one direction: a few hundred cells stay below it all, as most keep well under their
/// share.
const SHARE: f64 = 1.0 / 256.0;

/// The factor of the integrals: `rho / (pi |n1|)`.
type Prefactor<T> = Ball<T>;

/// The geometry and the emission in one arithmetic.
pub(crate) struct Prepared<T> {
    prefactor: Prefactor<T>,
    triangles: Vec<Patch<T>>,
    rays: Vec<Ray<T>>,
}

/// The fans of a triangle's pieces.
struct Patch<T> {
    /// Each with the expansion of the emission at its apex.
    fans: Vec<(Fan<T>, Expansion<T>)>,
    expansion: Expansion<T>,
    normal: BallVector<T>,
    height: Ball<T>,
    /// `p / |N|^2`.
    factor: Ball<T>,
}

/// Half a border, from its nearest point outward.
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
pub(crate) struct Tolerances {
    pub(crate) value: f64,
    pub(crate) gradient: f64,
}

/// One pass: the integrals and their truncation bounds.
pub(crate) struct Pass<T> {
    pub(crate) value: Ball<T>,
    pub(crate) gradient: BallVector<T>,
    pub(crate) truncation: Tolerances,
}

fn ray<T: Real>(
    foot: &Point,
    end: &Point,
    forward: bool,
    prefactor: &Prefactor<T>,
    expansion: &Expansion<T>,
    bits: usize,
) -> Ray<T> {
    let (position, way) = (foot.position(bits), end.from(foot, bits));
    let heights = [foot.height(bits), end.climb(foot, bits)];
    let moment = std::array::from_fn(|i| {
        let (j, k) = ((i + 1) % 3, (i + 2) % 3);
        let component = &(&way[j] * &position[k]) - &(&way[k] * &position[j]);
        let component = prefactor * &component;
        if forward { component } else { -&component }
    });
    Ray { foot: position, way, heights, expansion: expansion.clone(), moment }
}

/// The cells of every fan and ray.
pub(crate) struct Plan {
    fans: Vec<Vec<Cell>>,
    rays: Vec<Vec<Cell>>,
    pub(crate) evaluations: u64,
}

fn sizes<T: Real>(expansion: &Expansion<T>, directions: [Option<&BallVector<T>>; 4]) -> EmissionSize {
    let value = expansion.coefficient([0; 3]).magnitude();
    if expansion.degree == 0 {
        return EmissionSize { value, gradient: 0.0, slopes: [0.0; 4], higher: Vec::new() };
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
    EmissionSize { value, gradient: norm * (1.0 + 1e-12), slopes: directions.map(|d| d.map_or(0.0, slope)), higher }
}

impl<T: Real> Patch<T> {
    fn shape(&self, (fan, expansion): &(Fan<T>, Expansion<T>), tolerances: Tolerances) -> Shape {
        let factor = self.factor.magnitude() * fan.measure.magnitude();
        let normal = self.normal.iter().map(|n| n.magnitude() * n.magnitude()).sum::<f64>().sqrt();
        let height = self.height.magnitude();
        let weights = Weights {
            emission: factor * height / tolerances.value,
            gradient: factor * height / tolerances.gradient,
            directional: factor * normal / tolerances.gradient,
        };
        let [apex, start, way, shift] = fan.near;
        let heights = [0, 1, 2, 3].map(|i| fan.heights[i].leading());
        let emission = sizes(expansion, [Some(&fan.apex), Some(&fan.start), Some(&fan.way), fan.shift.as_ref()]);
        Shape { apex, start, way, shift, jacobian: fan.jacobian, heights, emission, weights }
    }
}

impl<T: Real> Ray<T> {
    fn shape(&self, tolerances: Tolerances) -> Shape {
        let factor = self.moment.iter().map(|m| m.magnitude() * m.magnitude()).sum::<f64>().sqrt();
        let weights = Weights { emission: factor / tolerances.gradient, gradient: 0.0, directional: 0.0 };
        let near = |v: &BallVector<T>| [0, 1, 2].map(|i| v[i].leading());
        let heights = [self.heights[0].leading(), self.heights[1].leading(), 0.0, 0.0];
        let emission = sizes(&self.expansion, [Some(&self.foot), Some(&self.way), None, None]);
        let (apex, start, none) = (near(&self.foot), near(&self.way), [0.0; 3]);
        Shape { apex, start, way: none, shift: none, jacobian: Jacobian::One, heights, emission, weights }
    }
}

impl<T: Real> Prepared<T> {
    /// The fans, rays and factors of a problem.
    pub(crate) fn new(source: &Source<'_>, frame: &Frame, view: &View, reflectance: f64, exponent: i32, bits: usize) -> Self {
        let length = Ball::<T>::from_exact(&frame.normal_squared, bits).sqrt();
        let prefactor = Ball::from_f64(reflectance, bits).divided_by(&(&pi(bits) * &length));
        let mut triangles: Vec<Patch<T>> = frame
            .triangles
            .iter()
            .map(|triangle| {
                let square = Ball::from_exact(&crate::enclosure::exact::dot(&triangle.normal, &triangle.normal), bits);
                Patch {
                    fans: Vec::new(),
                    expansion: source.expansion(frame, triangle, exponent, bits),
                    normal: vector(&triangle.normal, bits),
                    height: Ball::from_exact(&triangle.height, bits),
                    factor: prefactor.divided_by(&square),
                }
            })
            .collect();
        for piece in &view.pieces {
            let patch = &mut triangles[piece.triangle];
            for fan in fans(frame, &frame.triangles[piece.triangle], &piece.outline, bits) {
                let expansion = patch.expansion.moved(&fan.apex);
                patch.fans.push((fan, expansion));
            }
        }
        let mut rays = Vec::new();
        for Border { triangle, stretch, cast } in &view.borders {
            let (foot, place) = stretch.nearest(frame, [0.0; 3]);
            let mut expansion = triangles[*triangle].expansion.moved(&foot.position(bits));
            if let Some((m, k)) = cast {
                let k = Ball::from_exact(k, bits);
                expansion = expansion.times_linear(&vector(m, bits).map(|c: Ball<T>| c.divided_by(&k)));
            }
            if place != Place::End {
                rays.push(ray(&foot, &stretch.ends[1], true, &prefactor, &expansion, bits));
            }
            if place != Place::Start {
                rays.push(ray(&foot, &stretch.ends[0], false, &prefactor, &expansion, bits));
            }
        }
        Self { prefactor, triangles, rays }
    }

    /// A three-digit guess from above: the form factor is at most 1, and the gradient at most about the value over the distance.
    pub(crate) fn first_tolerances(&self) -> Tolerances {
        let largest = self.triangles.iter().map(|patch| {
            let unit = Tolerances { value: 1.0, gradient: 1.0 };
            let largest_emission = |fan: &(Fan<T>, Expansion<T>)| {
                let emission = patch.shape(fan, unit).emission;
                emission.value + emission.slopes[1].abs().max((emission.slopes[1] + emission.slopes[2]).abs())
            };
            patch.fans.iter().map(largest_emission).fold(0.0, f64::max)
        });
        let value = self.prefactor.magnitude() * largest.fold(0.0, f64::max);
        Tolerances { value: 1e-3 * value, gradient: 1e-3 * value }
    }

    /// The cells for the tolerances; not all of them where they take more than `most` evaluations, which the caller refuses.
    pub(crate) fn plan(&self, tolerances: Tolerances, most: u64) -> Result<Plan, Error> {
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
                    if plan.evaluations > most {
                        return Ok(plan);
                    }
                }
            }
            for ray in &self.rays {
                let mut cells = Vec::new();
                ray.shape(tolerances).subdivide_ray(share, &mut cells)?;
                plan.evaluations += cells.iter().map(|c| c.orders[0].count as u64).sum::<u64>();
                error += cells.iter().map(|c| c.orders[0].error).sum::<f64>();
                plan.rays.push(cells);
                if plan.evaluations > most {
                    return Ok(plan);
                }
            }
            if error <= 1.0 - 1e-9 {
                return Ok(plan);
            }
            share /= 2.0 * error;
        }
    }

    pub(crate) fn evaluate(&self, plan: &Plan, tolerances: Tolerances, bits: usize) -> Pass<T> {
        let zero = || self.prefactor.zero();
        let (mut value, mut gradient) = (zero(), [zero(), zero(), zero()]);
        let mut cells = plan.fans.iter();
        for patch in &self.triangles {
            let square = &patch.factor * &patch.height;
            for ((fan, expansion), cells) in patch.fans.iter().zip(&mut cells) {
                let moments = over_fan(fan, expansion, cells, bits);
                value = &value + &(&(&square * &fan.measure) * &moments.emission);
                if patch.expansion.degree > 0 {
                    let factor = &patch.factor * &fan.measure;
                    for (axis, component) in gradient.iter_mut().enumerate() {
                        let along = &patch.height * &moments.gradient[axis];
                        let across = &patch.normal[axis] * &moments.directional;
                        *component = &*component + &(&factor * &(&along + &across));
                    }
                }
            }
        }
        for (ray, cells) in self.rays.iter().zip(&plan.rays) {
            let integral = along_ray(&ray.foot, &ray.way, ray.heights.each_ref(), &ray.expansion, cells, bits);
            for (component, moment) in gradient.iter_mut().zip(&ray.moment) {
                *component = &*component + &(moment * &integral);
            }
        }
        Pass { value, gradient, truncation: tolerances }
    }
}

impl<T: Real> Pass<T> {
    /// The part of the radii that rounding takes.
    pub(crate) fn rounding(&self) -> Tolerances {
        Tolerances { value: self.value.radius, gradient: self.gradient.iter().map(|g| g.radius).fold(0.0, f64::max) }
    }

    pub(crate) fn radii(&self) -> Tolerances {
        let rounding = self.rounding();
        Tolerances {
            value: up(rounding.value + self.truncation.value),
            gradient: up(rounding.gradient + self.truncation.gradient),
        }
    }

    pub(crate) fn reached(&self, radius: Tolerances) -> Reached {
        let norm = self.gradient.iter().map(|g| g.leading() * g.leading()).sum::<f64>().sqrt();
        Reached {
            radiosity: self.value.leading(),
            radiosity_radius: radius.value,
            gradient: norm,
            gradient_radius: radius.gradient,
        }
    }

    /// Tolerances for the digits asked where the magnitude is known, and five orders less where it is not; none if rounding alone
    /// exceeds them, since smaller cells would not help.
    pub(crate) fn next_tolerances(&self, last: Tolerances, goal: f64, reached: Reached) -> Option<Tolerances> {
        let rounding = self.rounding();
        let has_digits = |middle: f64, radius: f64| middle.abs() > 4.0 * radius;
        let value_known = has_digits(reached.radiosity, reached.radiosity_radius);
        let gradient_known = has_digits(reached.gradient, 2.0 * reached.gradient_radius);
        let all_known = value_known && gradient_known;
        let next = |last: f64, middle: f64, radius: f64, rounding: f64, has_digits: bool| {
            let target = 0.5 * goal * (middle - 2.0 * radius);
            match has_digits {
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
