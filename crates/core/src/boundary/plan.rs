//! The decisions that change the shape of the answer, each taken exactly: is the receiver in front, which vertices are above the
//! horizon?
//!
//! - The receiver must be in front of the emitter's plane, `h = n2.(x - E_0) > 0`: emission is one-sided. Where vertices are not
//!   exactly in one plane, as those of a rotated square are not, no plane is the emitter's: the receiver must be above all
//!   vertices, gets nothing below all of them, and is on the surface in between ([`Plan::on_surface`]). So it does not matter
//!   which vertex is named first.
//! - Each vertex is above the receiver's horizon, `n1.r_i > 0`, or not; a vertex on it counts as not above, and contributes
//!   nothing.
//!
//! A double-precision filter with its rounding bound decides nearly always; double-double, then exact arithmetic, decide the
//! rest. The truth is the exact result for the doubles as given, so a sign found here is right without a tolerance.
//!
//! The plan also holds the power of two that brings the farthest vertex to a distance of about 1: all lengths are multiplied by
//! it, so any scene from 2^-900 to 2^900 gives the same digits.

use std::ops::Range;

use glam::DVec3;
use radgrad_numbers::double_double::{DoubleDouble, ROUNDOFF_OF_DOUBLE_DOUBLE};
use radgrad_numbers::exact;
use radgrad_numbers::exact::orientation;
use radgrad_numbers::number::{Number, ROUNDOFF};
use radgrad_numbers::offset::{exact_offset, offset};
use radgrad_numbers::power::normalising_power;
use radgrad_numbers::real::{RadiusOf, Real};
use radgrad_numbers::vec3::Vec3;

use crate::error::Error;
use crate::problem::polygon::Polygon;
use crate::problem::receiver::Receiver;

/// Where the emitter is relative to the receiver's horizon.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Horizon {
    /// All vertices are strictly above.
    Above,
    /// Some are above, some on it or below.
    Crossing,
}

/// The decisions on a case with a non-zero answer.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Plan {
    /// Multiplies all lengths.
    pub(crate) power: f64,
    pub(crate) horizon: Horizon,
    /// Whether the receiver is neither above nor below all vertices of a polygon that is not flat, or that cannot be told: it may
    /// be in front or behind.
    pub(crate) on_surface: bool,
}

impl Plan {
    /// The plan for an emitter wholly above the horizon.
    #[inline]
    pub(crate) const fn whole(power: f64) -> Self {
        Self { power, horizon: Horizon::Above, on_surface: false }
    }

    /// The plan, or `None` where the radiosity and its gradient are exactly zero.
    #[inline]
    pub(crate) fn new(receiver: &Receiver, polygon: &Polygon) -> Option<Self> {
        let (x, n1, vertices) = (receiver.position(), receiver.direction(), polygon.vertices());
        let (mut farthest, mut lowest) = (0.0, f64::INFINITY);
        for vertex in vertices {
            let r = *vertex - x;
            let (reach, height) = (r.abs().max_element(), n1.dot(r));
            farthest = if reach > farthest { reach } else { farthest };
            lowest = if height < lowest { height } else { lowest };
        }
        let power = normalising_power(farthest);
        let surely = least_sure_height(farthest);
        let height = polygon.normal().dot(x - vertices[0]);
        let in_front = height > surely + polygon.half_slab() && polygon.is_well_known();
        let on_surface = if in_front {
            false
        } else {
            match side_of_vertices(x, polygon, power) {
                Some(Side::Front) => false,
                Some(Side::InPlane | Side::Back) => return None,
                None => true,
            }
        };
        if lowest > surely {
            return Some(Self { power, horizon: Horizon::Above, on_surface });
        }
        let above = vertices.iter().filter(|v| is_above(receiver, **v, power)).count();
        let horizon = match above {
            0 => return None,
            _ if above == vertices.len() => Horizon::Above,
            _ => Horizon::Crossing,
        };
        Some(Self { power, horizon, on_surface })
    }

    /// Refuses a receiver on the surface, where an answer has two values.
    pub(crate) fn off_surface(self, receiver: &Receiver, polygon: &Polygon) -> Result<Self, Error> {
        if self.on_surface {
            let height = polygon.normal().dot(receiver.position() - polygon.vertices()[0]);
            return Err(Error::OnSurface { height, defect: polygon.planarity_defect() });
        }
        Ok(self)
    }
}

/// The height over a plane or the horizon above which its sign is sure, for points at most that far.
///
/// Three products of rounded factors and two sums, of components below 2 and below `farthest`: within 24 u of it.
#[inline]
pub(crate) fn least_sure_height(farthest: f64) -> f64 {
    if WITHOUT_UNDERFLOW.contains(&farthest) { 32.0 * ROUNDOFF * farthest } else { f64::INFINITY }
}

/// Where products of a distance with a component of a normal keep an absolute error below a roundoff of the distance.
const WITHOUT_UNDERFLOW: Range<f64> = 1e-200..1e200;

/// Where a point is relative to a polygon's plane.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Side {
    /// On the side to which the normal points.
    Front,
    /// Exactly in the plane.
    InPlane,
    /// On the other side.
    Back,
}

impl Side {
    fn of_height(height: f64) -> Self {
        if height > 0.0 {
            Self::Front
        } else if height < 0.0 {
            Self::Back
        } else {
            Self::InPlane
        }
    }
}

/// The side of the polygon's plane that a point is on, exactly.
pub(crate) fn side_of(point: DVec3, polygon: &Polygon, power: f64) -> Side {
    sure_side(point, polygon, power, 0.0).unwrap_or_else(|| exact_side(point, polygon))
}

/// Front above all vertices of the polygon, back below them; of vertices exactly in one plane its side, exactly. `None` in
/// between.
fn side_of_vertices(point: DVec3, polygon: &Polygon, power: f64) -> Option<Side> {
    let sure = sure_side(point, polygon, power, polygon.half_slab() * power);
    if polygon.half_slab() == 0.0 { sure.or_else(|| Some(exact_side(point, polygon))) } else { sure }
}

/// The side of a point that is surely farther from the polygon's plane than a normalised height.
pub(crate) fn sure_side(point: DVec3, polygon: &Polygon, power: f64, least: f64) -> Option<Side> {
    let r = (polygon.vertices()[0] - point) * power;
    let height = -polygon.normal().dot(r);
    let reach = r.x.abs() + r.y.abs() + r.z.abs();
    // Three products and two sums of rounded factors: 6 roundings of at most the reach. Nearer than that products underflow.
    if polygon.is_well_known() && reach >= WITHOUT_UNDERFLOW.start && height.abs() > 16.0 * ROUNDOFF * reach + least {
        return Some(Side::of_height(height));
    }
    let (height, error) = precise_height(point, polygon, power);
    // The least height errs by a rounding.
    (height.hi.abs() > (error + least) * (1.0 + 4.0 * f64::EPSILON)).then(|| Side::of_height(height.hi))
}

/// Height of a point over the polygon's plane, normalised, and a bound on its error.
pub(crate) fn precise_height(point: DVec3, polygon: &Polygon, power: f64) -> (DoubleDouble, f64) {
    let r = exact_offset(polygon.vertices()[0], point, power);
    let height = -polygon.precise_normal().dot(r);
    let length = r.x.hi.abs() + r.y.hi.abs() + r.z.hi.abs();
    // Underflow loses up to the smallest normal number.
    (height, length * (polygon.normal_error() + 8.0 * ROUNDOFF_OF_DOUBLE_DOUBLE) + f64::MIN_POSITIVE)
}

/// The same to the digits of the scalar.
pub(crate) fn height_over_plane<T: Real>(point: DVec3, polygon: &Polygon, power: f64) -> T {
    if T::Number::BEYOND_DOUBLE_DOUBLE {
        return -polygon.unit_normal::<T>().dot(offset(polygon.vertices()[0], point, power));
    }
    let (height, error) = precise_height(point, polygon, power);
    T::from_double_double(height, error)
}

/// The sign of a 4 x 4 determinant, by adaptive exact arithmetic.
fn exact_side(point: DVec3, polygon: &Polygon) -> Side {
    let [a, b, c] = polygon.plane_vertices();
    Side::of_height(-orientation([a, b, c, point]))
}

#[inline]
fn is_above(receiver: &Receiver, vertex: DVec3, power: f64) -> bool {
    let n = receiver.direction();
    let r = (vertex - receiver.position()) * power;
    let products = n * r;
    let height = products.x + products.y + products.z;
    // Of a product two roundings, of the sums two; the fifth pays for second order. Below the normal range three products of
    // factors up to 2 lose less than the smallest normal number.
    let bound = 5.0 * ROUNDOFF * (products.x.abs() + products.y.abs() + products.z.abs()) + f64::MIN_POSITIVE;
    if height.abs() > bound { height > 0.0 } else { exact_height_over_horizon(receiver, vertex, power).hi > 0.0 }
}

fn exact_height_over_horizon(receiver: &Receiver, vertex: DVec3, power: f64) -> DoubleDouble {
    exact::height(receiver.exact_direction(), vertex, receiver.position(), power)
}

/// Whether a point is exactly in the plane of the receiver's horizon.
pub(crate) fn is_on_horizon(receiver: &Receiver, point: DVec3, power: f64) -> bool {
    exact_height_over_horizon(receiver, point, power).hi == 0.0
}

/// Height of a vertex over the receiver's horizon, times the length of the normal as given: to a few roundoffs of the scalar, and
/// with the right sign. Only ratios of it are used.
pub(crate) fn height_over_horizon<T: Real>(receiver: &Receiver, vertex: DVec3, power: f64) -> T {
    let r = exact_offset(vertex, receiver.position(), power);
    let n = Vec3::from(receiver.direction());
    let height = n.map(DoubleDouble::from).dot(r);
    let magnitude = (n.x * r.x.hi).abs() + (n.y * r.y.hi).abs() + (n.z * r.z.hi).abs();
    let error = 8.0 * ROUNDOFF_OF_DOUBLE_DOUBLE * magnitude;
    // Far above the losses of products below the normal range.
    if magnitude > WITHOUT_UNDERFLOW.start && RadiusOf::<T>::from(error) < T::Number::roundoff() * height.hi.abs() {
        T::from_double_double(height, error)
    } else {
        let height = T::Number::exact_height(receiver.exact_direction(), vertex, receiver.position(), power);
        let tiny = T::Number::tiny();
        let lost = if height.size() <= tiny && height.high() != 0.0 { tiny } else { 0.0.into() };
        T::approximate(height, T::Number::roundoff() * height.size() * 2.0 + lost)
    }
}
