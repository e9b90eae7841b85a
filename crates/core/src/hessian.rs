//! Second derivatives of the radiosity with respect to x, for constant emission, clipped by the receiver's horizon or not.
//!
//! The gradient is `(rho B/pi) sum int (n1.r) (dy x r) / r^4` over the parts of the emitter's edges above the horizon
//! ([`crate::constant`]). Its derivative with respect to x at fixed y is minus that with respect to r. The end points of the
//! parts move with x where the horizon cuts an edge, but the integrand is zero there, `n1.r = 0`: the horizon adds nothing
//! beyond shortening the edges. In the frame of a line at distance S, `r = S (toward + along tan psi)`, `dy x r = -S N ds`, the
//! integrals are those of `cos^2` times one, `cos^2`, `cos sin` and `sin^2`:
//!
//! `H = (rho B/pi) sum (N w^T + w N^T) / 2 S^2`,
//! `w = p3 cc N + [p1 (cc - 4 cccc) - 4 p2 cccs] toward + [p2 (cc - 4 ccss) - 4 p1 cccs] along`,
//!
//! with `p1, p2, p3` the components of n1 along toward, along and N, and the arc's moments. A part that is not symmetric sums
//! to zero, second derivatives being symmetric, and is left out. Unit: that of the emission over the unit of length squared.
//!
//! B is twice differentiable in front of the emitter except where a whole edge lies in the horizon; there this is the second
//! derivative from the side on which the edge is hidden. Terms are of the size `1/(S r)`: far away the sum cancels by D/s, at
//! distance D for an emitter of size s, as the gradient's does. Measured on random triangles: 2e-15 of the norm near by, at
//! contact and clipped, 9e-12 at D/s = 1e4; in double-double full double precision to 1e7.

use glam::{DMat3, DVec3};

use crate::arc::Arc;
use crate::certify::Ball;
use crate::double_double::DoubleDouble;
use crate::number::Number;
use crate::plan::{Plan, unit_normal};
use crate::real::Real;
use crate::terms::albedo;
use crate::vec3::Vec3;
use crate::{Emission, Emitter, Error, Method, Receiver, horizon};

/// Second derivatives of the radiosity with a proven absolute error bound.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hessian {
    /// `d^2 B / dx_i dx_j` at fixed normal, in the unit of the emission over the unit of length squared.
    pub matrix: DMat3,
    /// Proven bound on the Frobenius norm of the error.
    pub error: f64,
    /// What answered.
    pub method: Method,
}

impl Hessian {
    const ZERO: Self = Self { matrix: DMat3::ZERO, error: 0.0, method: Method::Zero };

    /// Whether the bound is within `tolerance` times the Frobenius norm of the matrix.
    #[must_use]
    pub fn meets(&self, tolerance: f64) -> bool {
        let [x, y, z] = [self.matrix.x_axis, self.matrix.y_axis, self.matrix.z_axis].map(|column| Vec3::from(column).length());
        self.error <= tolerance * Vec3::new(x, y, z).length()
    }
}

/// Second derivatives of the radiosity: the digits of the closed form in double precision, without bound.
///
/// ```
/// use radgrad_core::{DVec3, Emission, Emitter, Polygon, Receiver, gradient, hessian};
/// let triangle = Polygon::new(vec![DVec3::new(1.0, 0.0, 2.0), DVec3::new(-1.0, -1.0, 2.0), DVec3::new(-1.0, 1.0, 2.0)])?;
/// let lamp = Emitter::new(Polygon::new(triangle.vertices().iter().rev().copied().collect())?, Emission::Constant(1.0))?;
/// let at = |x| Receiver::new(DVec3::new(x, 0.0, 0.0), DVec3::Z, 1.0);
/// let difference = (gradient(&at(1e-4)?, &lamp)? - gradient(&at(-1e-4)?, &lamp)?) / 2e-4;
/// assert!((hessian(&at(0.0)?, &lamp)?.x_axis - difference).length() < 1e-8);
/// # Ok::<(), radgrad_core::Error>(())
/// ```
///
/// # Errors
/// If the emission is not constant, or a result overflows.
pub fn hessian(receiver: &Receiver, emitter: &Emitter) -> Result<DMat3, Error> {
    let emission = constant(emitter)?;
    let Some(plan) = Plan::new(receiver, emitter.polygon()) else { return Ok(DMat3::ZERO) };
    matrix(&entries::<f64>(receiver, emitter, &plan, emission))
}

/// Second derivatives of the radiosity with a bound: in double precision, and where that is above `tolerance` times the
/// Frobenius norm, in double-double. What that gives is returned whether or not it meets the tolerance: the bound says so.
///
/// # Errors
/// If the emission is not constant, the tolerance is not in [0, 1], or a result overflows.
pub fn hessian_to(receiver: &Receiver, emitter: &Emitter, tolerance: f64) -> Result<Hessian, Error> {
    let emission = constant(emitter)?;
    if !(0.0..=1.0).contains(&tolerance) {
        return Err(Error::Tolerance { value: tolerance });
    }
    let Some(plan) = Plan::new(receiver, emitter.polygon()) else { return Ok(Hessian::ZERO) };
    match certified::<f64>(receiver, emitter, &plan, emission, Method::ClosedForm)? {
        answer if answer.meets(tolerance) => Ok(answer),
        _ => certified::<DoubleDouble>(receiver, emitter, &plan, emission, Method::DoubleDouble),
    }
}

fn constant(emitter: &Emitter) -> Result<f64, Error> {
    let given = match emitter.emission() {
        Emission::Constant(value) => return Ok(*value),
        Emission::Linear(_) => "linear",
        Emission::Polynomial(_) => "polynomial",
    };
    Err(Error::EmissionKind { quantity: "the Hessian", needed: "constant", given })
}

fn certified<N: Number>(
    receiver: &Receiver,
    emitter: &Emitter,
    plan: &Plan,
    emission: f64,
    method: Method,
) -> Result<Hessian, Error> {
    let entries = entries::<Ball<N>>(receiver, emitter, plan, emission);
    let [on, off] = entries.map(|v| v.map(Real::value_error).length());
    // Entries off the diagonal stand twice.
    let error = Vec3::new(on, off, off).length() * (1.0 + 16.0 * f64::EPSILON);
    let error = if error.is_nan() { f64::INFINITY } else { error };
    Ok(Hessian { matrix: matrix(&entries)?, error, method })
}

fn matrix<T: Real>(entries: &[Vec3<T>; 2]) -> Result<DMat3, Error> {
    let [on, off] = entries.map(|v| DVec3::from(v.map(T::value)));
    let rows = [DVec3::new(on.x, off.z, off.y), DVec3::new(off.z, on.y, off.x), DVec3::new(off.y, off.x, on.z)];
    if rows.iter().all(|row| row.is_finite()) {
        Ok(DMat3::from_cols(rows[0], rows[1], rows[2]))
    } else {
        Err(Error::Overflow { quantity: "Hessian" })
    }
}

/// The entries xx, yy, zz and the entries yz, zx, xy.
fn entries<T: Real>(receiver: &Receiver, emitter: &Emitter, plan: &Plan, emission: f64) -> [Vec3<T>; 2] {
    let n1 = unit_normal(receiver);
    let mut sum = [Vec3::zero(); 2];
    horizon::visit_boundary(receiver, emitter.polygon(), plan, |arc: &Arc<T>| {
        let [on, off] = edge_term(n1, arc);
        sum = [sum[0] + on, sum[1] + off];
    });
    let factor = albedo::<T>(receiver) * T::exact(emission * emitter.power());
    // Two of the powers of two may cancel: they go first, the larger before the smaller.
    let powers = [plan.power, 1.0 / emitter.power()];
    let (first, second) = (powers[0].max(powers[1]), powers[0].min(powers[1]));
    sum.map(|v| (v * factor).map(|c| c.scaled(first).scaled(second).scaled(plan.power)))
}

/// `(N w^T + w N^T) / 2 S^2`.
fn edge_term<T: Real>(n1: Vec3<T>, arc: &Arc<T>) -> [Vec3<T>; 2] {
    let Some(line) = arc.line() else { return [Vec3::zero(); 2] };
    let frame = line.frame();
    let (m, q) = (arc.moments(&frame), arc.quartic_moments(&frame));
    let [p1, p2, p3] = [frame.toward, frame.along, frame.normal].map(|axis| n1.dot(axis));
    let four = T::exact(4.0);
    let toward = p1 * (m.cc - four * q.cccc) - four * p2 * q.cccs;
    let along = p2 * (m.cc - four * q.ccss) - four * p1 * q.cccs;
    let w = frame.normal * (p3 * m.cc) + frame.toward * toward + frame.along * along;
    let w = w * (T::exact(0.5) / (frame.distance * frame.distance));
    let n = frame.normal;
    let on = Vec3::new(n.x * w.x, n.y * w.y, n.z * w.z) * T::exact(2.0);
    [on, Vec3::new(n.y * w.z + n.z * w.y, n.z * w.x + n.x * w.z, n.x * w.y + n.y * w.x)]
}
