//! Second derivatives of the radiosity with respect to x, clipped by the receiver's horizon and by occluders.
//!
//! The following is for constant emission; [`crate::forms::second_derivatives`] has the terms of an emission that varies. The
//! gradient is `(rho B/pi) sum int (n1.r) (dy x r) / r^4` over the parts of the emitter's edges above the horizon
//! ([`crate::forms::constant`]). Its derivative with respect to x at fixed y is minus that with respect to r. The end points of
//! the parts move with x where the horizon cuts an edge, but the integrand is zero there, `n1.r = 0`: the horizon adds nothing
//! beyond shortening the edges. In the frame of a line at distance S, `r = S (toward + along tan psi)`, `dy x r = -S N ds`, the
//! integrals are those of `cos^2` times one, `cos^2`, `cos sin` and `sin^2`:
//!
//! `H = (rho B/pi) sum (N w^T + w N^T) / 2 S^2`,
//! `w = p3 cc N + [p1 (cc - 4 cccc) - 4 p2 cccs] toward + [p2 (cc - 4 ccss) - 4 p1 cccs] along`,
//!
//! with `p1, p2, p3` the components of n1 along toward, along and N, and the arc's moments. A part that is not symmetric sums
//! to zero, second derivatives being symmetric, and is left out. Unit: that of the emission over the unit of length squared.
//!
//! # Past occluders
//! An arc of an occluder's edge has the same term. Where two lines only seem to meet, in the direction d and at distances r and
//! r', the point of one line that the other one covers moves as x does, and the integrand is not zero there. The point `a + t e`
//! is in the plane of x and the line `(a', e')` where `(a' - x) x e' . (a + t e - x) = 0`; differentiated, `dt/dx = (1 - r/r')
//! w'/(w'.e)`, `w' = (a' - x) x e'`. That times the integrand `(n1.r)(e x r)/r^4`, from the arc that ends there and from the one
//! that begins, is, symmetric part,
//!
//! `H += (rho B/pi) (n1.d) (1/r - 1/r')^2 (N N'^T + N' N^T) / 2 d.(N x N')`,
//!
//! which vanishes at a vertex, where the lines do meet, and on the horizon.
//!
//! # Where it is
//! B is twice differentiable in front of the emitter except where a whole edge lies in the horizon, which leaves the second
//! derivative from the side on which the edge is hidden, and where an edge is seen through a vertex or along another edge that it
//! does not meet: then the bound is infinite. Terms are of the size `1/(S r)`: far away the sum cancels by D/s,
//! at distance D for an emitter of size s, as the gradient's does. Bounds are running ([`radgrad_numbers::ball`]); the ladder is
//! f64, double-double, then as many bits as it takes.

use glam::DMat3;
use radgrad_numbers::real::Real;
use radgrad_numbers::vec3::Vec3;

use crate::boundary::arc::Arc;
use crate::boundary::case::{Case, with_case};
use crate::boundary::line::Line;
use crate::boundary::{horizon, visibility};
use crate::error::Error;
use crate::forms::linear::SeenLinear;
use crate::forms::polynomial::sum::SeenPolynomial;
use crate::forms::second_derivatives::{SecondDerivatives, Symmetric, symmetric_product};
use crate::ladder::answer::Method;
use crate::ladder::caller_units::CallerUnits;
use crate::ladder::components::{Bounded, Components, within_reach};
use crate::problem::emission::{Emission, Emitter};
use crate::problem::polygon::Polygon;
use crate::problem::receiver::{Receiver, albedo, unit_normal};

/// Second derivatives of the radiosity with a proven absolute error bound.
///
/// ```
/// use radgrad_core::{DVec3, Emission, Emitter, Polygon, Receiver, hessian_to};
/// let corners = [(0.0, 0.0), (0.0, 1.0), (1.0, 1.0), (1.0, 0.0)].map(|(x, y)| DVec3::new(x, y, 1.0));
/// let lamp = Emitter::new(Polygon::new(corners.to_vec())?, Emission::Constant(1.0))?;
/// let middle = Receiver::new(DVec3::new(0.5, 0.5, 0.0), DVec3::Z, 1.0)?;
/// let curvature = hessian_to(&middle, &lamp, &[], 1e-10)?;
/// assert!((curvature.matrix.x_axis.x - curvature.matrix.y_axis.y).abs() <= 2.0 * curvature.error); // by symmetry
/// assert!(curvature.matrix.x_axis.x < 0.0, "under the middle it is brightest");
/// # Ok::<(), radgrad_core::Error>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hessian {
    /// `d^2 B / dx_i dx_j` at fixed normal, in the unit of the emission over the unit of length squared.
    pub matrix: DMat3,
    /// Proven bound on the Frobenius norm of the error.
    pub error: f64,
    /// The method that answered.
    pub method: Method,
}

impl Hessian {
    const ZERO: Self = Self { matrix: DMat3::ZERO, error: 0.0, method: Method::Zero };

    /// Whether the bound is within `tolerance` times the Frobenius norm of the matrix.
    ///
    /// ```
    /// use radgrad_core::{DMat3, Hessian, Method};
    /// let hessian = Hessian { matrix: DMat3::IDENTITY, error: 1e-12, method: Method::ClosedForm }; // of the norm sqrt 3
    /// assert!(hessian.meets(6e-13) && !hessian.meets(5e-13));
    /// ```
    #[must_use]
    pub fn meets(&self, tolerance: f64) -> bool {
        self.error <= tolerance * frobenius_norm(self.matrix.to_cols_array())
    }
}

/// Second derivatives of the radiosity: the digits of the closed form in double precision, without bound.
///
/// ```
/// use radgrad_core::{DVec3, Emission, Emitter, Polygon, Receiver, gradient, hessian};
/// let triangle = Polygon::new(vec![DVec3::new(1.0, 0.0, 2.0), DVec3::new(-1.0, -1.0, 2.0), DVec3::new(-1.0, 1.0, 2.0)])?;
/// let lamp = Emitter::new(Polygon::new(triangle.vertices().iter().rev().copied().collect())?, Emission::Constant(1.0))?;
/// let receiver = |x| Receiver::new(DVec3::new(x, 0.0, 0.0), DVec3::Z, 1.0);
/// let difference = (gradient(&receiver(1e-4)?, &lamp)? - gradient(&receiver(-1e-4)?, &lamp)?) / 2e-4;
/// assert!((hessian(&receiver(0.0)?, &lamp)?.x_axis - difference).length() < 1e-8);
/// # Ok::<(), radgrad_core::Error>(())
/// ```
///
/// # Errors
/// If the receiver is on the surface of an emitter that is not flat ([`Error::OnSurface`]), or a result over- or underflows.
pub fn hessian(receiver: &Receiver, emitter: &Emitter) -> Result<DMat3, Error> {
    if receiver.reflectance() == 0.0 {
        return Ok(DMat3::ZERO);
    }
    with_case(receiver, emitter, &[], DMat3::ZERO, |case| {
        columns::<f64>(case)
            .map_or(Ok(DMat3::ZERO), |columns| Hessian::unit(case).plain(columns).map(|c| DMat3::from_cols_array(&c)))
    })
}

/// Second derivatives of the radiosity due to the part of `emitter` that `occluders` leave visible, with a bound.
///
/// The closed form in double precision, in double-double or with as many bits as it takes: the first whose bound is at most
/// `tolerance` times the Frobenius norm answers. Where none is, the last does, and its bound says so: below a tolerance of
/// 2^-53 it is that of the rounding to doubles, and infinite where an edge is seen exactly through a vertex or along another edge
/// that it does not meet, since the radiosity has no second derivative there.
///
/// ```
/// use radgrad_core::{DVec3, Emission, Emitter, Polygon, Receiver, evaluate, hessian_to};
/// let point = |x, y, z| DVec3::new(x, y, z);
/// let lamp = Polygon::new(vec![point(-1.0, -1.0, 2.0), point(-1.0, 1.0, 2.0), point(1.0, 1.0, 2.0), point(1.0, -1.0, 2.0)])?;
/// let lamp = Emitter::new(lamp, Emission::Constant(1.0))?;
/// let screen = [Polygon::new(vec![point(0.2, -1.0, 1.0), point(0.2, 1.0, 1.0), point(2.0, 0.0, 1.0)])?];
/// let floor = |x| Receiver::new(point(x, 0.0, 0.0), DVec3::Z, 1.0);
/// let answer = hessian_to(&floor(0.0)?, &lamp, &screen, 1e-12)?;
/// let gradient = |x| Ok::<_, radgrad_core::Error>(evaluate(&floor(x)?, &lamp, &screen)?.gradient);
/// let difference = (gradient(1e-4)? - gradient(-1e-4)?) / 2e-4;
/// assert!(answer.meets(1e-12) && (answer.matrix.x_axis - difference).length() < 1e-7);
/// # Ok::<(), radgrad_core::Error>(())
/// ```
///
/// # Errors
/// If the receiver is on the surface of an emitter that is not flat ([`Error::OnSurface`]), the tolerance is not in [0, 1], or a
/// result over- or underflows.
pub fn hessian_to<'a>(
    receiver: &Receiver,
    emitter: &Emitter,
    occluders: impl IntoIterator<Item = &'a Polygon>,
    tolerance: f64,
) -> Result<Hessian, Error> {
    bounded(receiver, emitter, &occluders.into_iter().collect::<Vec<_>>(), tolerance)
}

/// [`hessian_to`], compiled once: generic functions are compiled again in every crate that calls them.
fn bounded(receiver: &Receiver, emitter: &Emitter, occluders: &[&Polygon], tolerance: f64) -> Result<Hessian, Error> {
    let tolerance = within_reach(tolerance)?;
    if receiver.reflectance() == 0.0 {
        return Ok(Hessian::ZERO);
    }
    with_case(receiver, emitter, occluders, Hessian::ZERO, |case| {
        Ok(Bounded::to::<Hessian>(case, tolerance)?.map_or(Hessian::ZERO, |Bounded { components, error, method }| Hessian {
            matrix: DMat3::from_cols_array(&components),
            error,
            method,
        }))
    })
}

impl Components<9> for Hessian {
    /// Nine squares and their sum, a root, and the way back from a power of two.
    const UP: f64 = 1.0 + 16.0 * f64::EPSILON;

    fn find<T: Real>(case: &Case<'_>) -> Option<[T; 9]> {
        columns(case)
    }

    fn norm(components: [f64; 9]) -> f64 {
        frobenius_norm(components)
    }

    fn unit(case: &Case<'_>) -> CallerUnits {
        CallerUnits::of_derivative(2, "Hessian", case.plan, case.emitter)
    }
}

fn frobenius_norm(columns: [f64; 9]) -> f64 {
    let [x, y, z] = [0, 3, 6].map(|i| Vec3::new(columns[i], columns[i + 1], columns[i + 2]).length());
    Vec3::new(x, y, z).length()
}

/// The columns of the matrix, in normalised lengths and emission; `None` where nothing is visible.
fn columns<T: Real>(case: &Case<'_>) -> Option<[T; 9]> {
    let Case { receiver, emitter, plan, .. } = *case;
    let n1 = unit_normal(receiver);
    let constant = |value: f64| {
        let mut sum = [Vec3::zero(); 2];
        let mut add = |[diagonal, others]: Symmetric<T>| sum = [sum[0] + diagonal, sum[1] + others];
        let is_certain = visit(case, |part| match part {
            ArcOrCorner::Arc(arc) => add(edge_term(n1, arc)),
            ArcOrCorner::Corner(ending, beginning) => add(corner_term(n1, ending, beginning)),
        })?;
        let factor = albedo::<T>(receiver) * T::exact(value);
        Some((is_certain, sum.map(|v| v * factor)))
    };
    let varying = |seen: SeenPolynomial<T>| {
        let mut sum = SecondDerivatives::new(seen);
        let is_certain = visit(case, |part| match part {
            ArcOrCorner::Arc(arc) => sum.add(arc),
            ArcOrCorner::Corner(ending, beginning) => sum.add_corner(ending.end.point, corner_term(n1, ending, beginning)),
        })?;
        Some((is_certain, sum.total().map(|v| v * albedo::<T>(receiver))))
    };
    let (is_certain, [diagonal, others]) = match (emitter.emission(), emitter.polynomial()) {
        (Emission::Constant(_), _) => constant(emitter.affine().value)?,
        (_, Some(plane)) => varying(SeenPolynomial::new(receiver, emitter, plane, plan.power))?,
        (_, None) => varying(SeenPolynomial::linear(SeenLinear::new(receiver, emitter, plan.power), emitter.polygon()))?,
    };
    let columns = [diagonal.x, others.z, others.y, others.z, diagonal.y, others.x, others.y, others.x, diagonal.z];
    // A corner more or less bounds nothing.
    Some(if is_certain { columns } else { columns.map(|c| c.widened(f64::INFINITY.into())) })
}

/// The arcs and corners that contribute to the sums.
enum ArcOrCorner<'a, T> {
    Arc(&'a Arc<T>),
    /// Where two lines only seem to meet: the arc that ends there and the one that begins.
    Corner(&'a Arc<T>, &'a Arc<T>),
}

/// Calls the parts of the visible boundary; returns whether they are certain, or `None` where nothing is visible.
fn visit<T: Real>(case: &Case<'_>, mut visit: impl FnMut(ArcOrCorner<'_, T>)) -> Option<bool> {
    let Case { receiver, emitter, occluders, plan } = *case;
    if occluders.is_empty() {
        horizon::visit_boundary(receiver, emitter.polygon(), plan, |arc: &Arc<T>| visit(ArcOrCorner::Arc(arc)));
        return Some(true);
    }
    let (outlines, uncertainty) = visibility::outlines(receiver, emitter, occluders, plan)?;
    for outline in &outlines {
        let next = outline.iter().cycle().skip(1);
        for ((arc, meets), (next, _)) in outline.iter().zip(next) {
            visit(ArcOrCorner::Arc(arc));
            if !meets {
                visit(ArcOrCorner::Corner(arc, next));
            }
        }
    }
    Some(uncertainty.is_none())
}

/// `(N w^T + w N^T) / 2 S^2`.
fn edge_term<T: Real>(n1: Vec3<T>, arc: &Arc<T>) -> Symmetric<T> {
    let Some(line) = arc.line() else { return [Vec3::zero(); 2] };
    let frame = line.frame();
    let (m, q) = (arc.moments(&frame), arc.quartic_moments(&frame));
    let [p1, p2, p3] = [frame.toward, frame.along, frame.normal].map(|axis| n1.dot(axis));
    let four = T::exact(4.0);
    let toward = p1 * (m.cc - four * q.cccc) - four * p2 * q.cccs;
    let along = p2 * (m.cc - four * q.ccss) - four * p1 * q.cccs;
    let w = frame.normal * (p3 * m.cc) + frame.toward * toward + frame.along * along;
    symmetric_product(frame.normal, w * (T::exact(0.5) / (frame.distance * frame.distance)))
}

/// `(n1.d) (1/r - 1/r')^2 (N N'^T + N' N^T) / 2 d.(N x N')`, where one arc ends and the next begins. On the horizon `n1.d` is 0.
fn corner_term<T: Real>(n1: Vec3<T>, ending: &Arc<T>, beginning: &Arc<T>) -> Symmetric<T> {
    let (Some(line), Some(next)) = (ending.line(), beginning.line()) else { return [Vec3::zero(); 2] };
    let direction = ending.end.point * ending.end.inverse;
    let nearness = |line: &Line<T>| direction.dot(line.frame().toward) * line.nearness();
    let apart = nearness(line) - nearness(next);
    let turn = direction.dot(line.normal.cross(next.normal));
    symmetric_product(line.normal, next.normal * (n1.dot(direction) * apart * apart / (turn + turn)))
}
