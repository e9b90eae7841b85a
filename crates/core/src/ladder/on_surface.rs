//! The answer on the surface of an emitter whose vertices are not exactly in one plane ([`Plan::on_surface`]): it encloses the
//! radiosity of receivers just in front of it and just behind. It also serves just in front, where no rung bounds as much: the
//! forms of emissions that are not constant take the height over the plane, of which then nothing is known.
//!
//! Behind all vertices B and its gradient are 0. Moved along n2 to where it is above all vertices, the receiver sees the emitter in
//! directions with `n2.omega <= 0`, and light above its horizon, `n1.omega > 0`. With `t = |n1 - n2|`:
//! - `int n1.omega domega` over the directions between the two planes is `pi t^2/4`, a half hemisphere for perpendicular planes
//!   and a whole one for `n1 = -n2`. So B is within rho `t^2/4` of the least and the largest emission, where those are below and
//!   above 0; and a floor gives nothing to a floor.
//! - Seen from outside its outline, at a distance of d from it, the emitter is within an angle of `H/d` below its plane, H the
//!   largest height of the receiver over a vertex. There `n1.omega <= t`, so rho `2 t H/d` is a bound too.
//! - Within that angle the order of two edges in one direction from the receiver is not known: an outline that is not flat may be
//!   seen to cross itself, and then counts light with the wrong sign, or more than once. A line through the receiver meets at most
//!   two edges of a convex outline, one of them from inside, where nothing can cross; of any outline of n edges it meets n at most,
//!   and no place counts more than n/2 times. So up to `n/2` times `2 t H/d`, or `t^2/4`, of the largest magnitude of the emission
//!   may be missing on either side.
//! - The gradient is `(rho/pi)` times the contour integral of `B (n1.omega)/r^2 ds`, over edges of the emitter and of occluders,
//!   and the term of the slope G of the emission. Over an edge of length L at a distance of d the integral of `1/r^2` is at most
//!   `min(L/d, pi)/d`. The slope adds `G int n1.omega domega` and `int (n1.omega) G dA/r^2`, at most `2 pi t G (1 + ln(R/d))` from
//!   outside, R the distance of the farthest point. From inside that has no bound: just in front the gradient of a linear emission
//!   grows like a logarithm of the height, as that of any emission does like one over the distance next to an edge.

use std::f64::consts::{FRAC_1_PI, PI};

use glam::DVec3;
use radgrad_numbers::number::ROUNDOFF;
use radgrad_numbers::vec3::Vec3;

use crate::boundary::case::Case;
#[cfg(doc)]
use crate::boundary::plan::Plan;
use crate::boundary::plan::precise_height;
use crate::error::Error;
use crate::ladder::answer::{Answer, Method, Value};
use crate::ladder::rungs::Evaluated;
use crate::problem::emission::Emission;
use crate::problem::polygon::Polygon;

/// One above 1 by more than the rounding of a bound.
const UP: f64 = 1.0 + 1e-12;

/// Above the rounding of a distance, in normalised lengths.
const SLACK: f64 = 1e-13;

/// Above the distance of the farthest vertex, `2 sqrt(3)` in normalised lengths.
const FARTHEST: f64 = 4.0;

impl Case<'_> {
    /// An answer with the bounds of the surface, where those are smaller.
    pub(super) fn narrowed(&self, answer: Answer) -> Result<Answer, Error> {
        if self.emitter.polygon().half_slab() == 0.0 {
            return Ok(answer);
        }
        let other = self.scaled(&self.on_surface(), Method::OnSurface)?;
        let mut narrowed = answer;
        if is_smaller(other.radiosity_error, answer.radiosity_error) {
            let Answer { radiosity, radiosity_error, method, .. } = other;
            narrowed = Answer { radiosity, radiosity_error, method, ..answer };
        }
        if is_smaller(other.gradient_error, answer.gradient_error) {
            let Answer { gradient, gradient_error, .. } = other;
            narrowed = Answer { gradient, gradient_error, ..narrowed };
        }
        Ok(narrowed)
    }

    /// The same of a value.
    pub(super) fn narrowed_value(&self, value: Value) -> Result<Value, Error> {
        if self.emitter.polygon().half_slab() == 0.0 {
            return Ok(value);
        }
        let other = self.value_of(&self.on_surface(), Method::OnSurface)?;
        Ok(if is_smaller(other.radiosity_error, value.radiosity_error) { other } else { value })
    }

    /// An answer that encloses both sides.
    #[cold]
    #[inline(never)]
    pub(super) fn on_surface(&self) -> Evaluated {
        let Self { receiver, emitter, occluders, plan } = *self;
        let polygon = emitter.polygon();
        let (height, height_error) = precise_height(receiver.position(), polygon, plan.power);
        // On the surface the receiver is as near to the plane as the vertices, and is moved by as much as they are apart.
        let height = height.hi.abs() + 4.0 * (polygon.half_slab() * plan.power + height_error);
        let turned = (receiver.normal() - polygon.normal()).length() * UP + 8.0 * ROUNDOFF + polygon.normal_error();
        let slant = turned.min(1.0);
        let outline = self.relative_vertices(polygon);
        let distance = clear(&outline) - height;
        let is_outside = distance > 0.0 && !is_around(&outline, polygon.normal());
        let strip = if is_outside { 2.0 * slant * height / distance } else { f64::INFINITY };
        let share = receiver.reflectance() * (0.25 * turned * turned).min(strip).min(1.0) * UP;
        let [low, high] = self.range();
        let largest_emission = low.abs().max(high);
        let is_convex = polygon.is_convex();
        let is_crossed = is_outside || distance <= 0.0 || !is_convex;
        let layers = if is_convex { 1.0 } else { (polygon.vertices().len() / 2) as f64 };
        let slack = if distance > 0.0 { 2.0 * slant * height / distance } else { f64::INFINITY };
        let crossed = if is_crossed {
            receiver.reflectance() * layers * (0.25 * turned * turned).min(slack) * UP * largest_emission
        } else {
            0.0
        };
        let off_edges = occluders.iter().map(|occluder| clear(&self.relative_vertices(occluder))).fold(distance, f64::min);
        let gradient_error = if off_edges > 0.0 {
            let outlines = occluders.iter().map(|occluder| self.relative_vertices(occluder)).chain([outline]);
            let edges: f64 = outlines.map(|outline| near_edges(&outline, height)).sum();
            let slope = emitter.steepest_emission() * emitter.power() / plan.power * self.slope(is_outside, distance);
            receiver.reflectance() * FRAC_1_PI * slant * (largest_emission * edges + slope) * UP
        } else {
            f64::INFINITY
        };
        Evaluated {
            radiosity: 0.5 * share * (low + high),
            gradient: Vec3::new(0.0, 0.0, 0.0),
            radiosity_error: (0.5 * share * (high - low) + crossed) * UP,
            gradient_error,
        }
    }

    /// A polygon's vertices from the receiver, in normalised lengths.
    fn relative_vertices(&self, polygon: &Polygon) -> Vec<DVec3> {
        polygon.vertices().iter().map(|v| (*v - self.receiver.position()) * self.plan.power).collect()
    }

    /// The factor of the emission's slope in the bound on the gradient.
    fn slope(&self, is_outside: bool, distance: f64) -> f64 {
        match self.emitter.emission() {
            Emission::Constant(_) => 0.0,
            Emission::Linear(_) | Emission::Polynomial(_) if is_outside => {
                2.0 * PI * (1.0 + libm::log(FARTHEST / distance.min(FARTHEST)))
            }
            Emission::Linear(_) | Emission::Polynomial(_) if self.emitter.steepest_emission() == 0.0 => 0.0,
            Emission::Linear(_) | Emission::Polynomial(_) => f64::INFINITY,
        }
    }

    /// The least and the largest normalised emission, 0 between them.
    fn range(&self) -> [f64; 2] {
        let (emitter, power) = (self.emitter, self.emitter.power());
        match emitter.emission() {
            Emission::Constant(value) => [(value * power).min(0.0), (value * power).max(0.0)],
            Emission::Linear(_) => {
                let affine = emitter.affine();
                let error = emitter.vertex_error()
                    + affine.residual
                    + 2.0 * emitter.steepest_emission() * power * emitter.polygon().half_slab();
                let values = (0..emitter.polygon().vertices().len()).map(|i| emitter.vertex_value(i));
                values.fold([0.0, 0.0], |[low, high], b| [f64::min(low, b - error), f64::max(high, b + error)])
            }
            Emission::Polynomial(_) => [-1.0, 1.0].map(|sign| sign * emitter.largest_emission() * power),
        }
    }
}

/// Whether a bound is smaller than another, which may be none.
fn is_smaller(bound: f64, other: f64) -> bool {
    bound < other || other.is_nan()
}

/// Lower bound on the distance of an outline from the origin.
fn clear(outline: &[DVec3]) -> f64 {
    edges(outline).map(|(a, b)| distance(a, b)).fold(f64::INFINITY, f64::min) - SLACK
}

/// Bound on the integral of `1/r^2` along an outline, for an origin that moves by a height.
fn near_edges(outline: &[DVec3], height: f64) -> f64 {
    let along = |(a, b): (DVec3, DVec3)| {
        let near = distance(a, b) - SLACK - height;
        ((b - a).length() / near).min(PI) / near
    };
    edges(outline).map(along).sum::<f64>() * UP
}

fn edges(outline: &[DVec3]) -> impl Iterator<Item = (DVec3, DVec3)> {
    outline.iter().copied().zip(outline.iter().copied().cycle().skip(1))
}

/// Distance of the origin from a segment.
fn distance(a: DVec3, b: DVec3) -> f64 {
    let e = b - a;
    let place = (-a.dot(e) / e.length_squared()).clamp(0.0, 1.0);
    // Of a segment so short that its square underflows either end serves.
    let nearest = if place.is_nan() { a } else { a + e * place };
    nearest.length()
}

/// Whether an outline goes around the origin, seen along the axis that its normal is nearest to; the origin is off it by far
/// more than rounding.
fn is_around(outline: &[DVec3], normal: DVec3) -> bool {
    let [x, y, z] = normal.abs().to_array();
    let flat = |v: DVec3| {
        if z >= x && z >= y {
            [v.x, v.y]
        } else if y >= x {
            [v.z, v.x]
        } else {
            [v.y, v.z]
        }
    };
    let crosses = |(a, b): (DVec3, DVec3)| {
        let ([ax, ay], [bx, by]) = (flat(a), flat(b));
        (ay > 0.0) != (by > 0.0) && ((ax * by - bx * ay > 0.0) == (by > ay))
    };
    edges(outline).filter(|edge| crosses(*edge)).count() % 2 == 1
}
