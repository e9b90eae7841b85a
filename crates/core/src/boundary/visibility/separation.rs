//! Whether two convex cones are separated, seen at once in double precision: surely no direction is in both.
//!
//! Most occluders hide nothing of the part of an emitter that is left, in whatever precision the rest is found. A cone is known
//! here by the rays through its corners, each brought to a length of 1 to 4 by a power of two, by the normals of its sides, and by
//! a circular cone around it. Every number carries a bound on its error, with u = 2^-53: a difference of two doubles errs by u of
//! itself, a cross product of two rays by 6u of the product of their lengths and by the effect of their own errors, a scalar
//! product by 3u.

use glam::DVec3;
use radgrad_numbers::number::ROUNDOFF;
use radgrad_numbers::power::normalising_power;
use radgrad_numbers::real::Real;
use radgrad_numbers::vec3::Vec3;

use crate::problem::triangulate::Few;

/// A vector and a bound on the length of its error.
#[derive(Debug, Clone, Copy)]
pub(super) struct UncertainVector {
    at: DVec3,
    length: f64,
    error: f64,
}

impl UncertainVector {
    /// A direction, of whatever length.
    fn ray(at: DVec3, error: f64) -> Self {
        let power = normalising_power(at.abs().max_element());
        Self::new(at * power, error * power)
    }

    fn new(at: DVec3, error: f64) -> Self {
        Self { at, length: at.length() * (1.0 + 4.0 * f64::EPSILON), error }
    }

    /// The direction from x to a point of the scene.
    fn from_to(x: DVec3, point: DVec3) -> Self {
        let direction = point - x;
        Self::ray(direction, 2.0 * ROUNDOFF * direction.abs().max_element())
    }

    /// A direction in doubles, its own error included.
    pub(super) fn from_direction<T: Real>(direction: Vec3<T>) -> Self {
        let error = direction.map(T::value_error);
        Self::ray(direction.map(T::value).into(), error.x + error.y + error.z)
    }

    pub(super) fn reversed(self) -> Self {
        Self { at: -self.at, ..self }
    }

    fn cross(&self, other: &Self) -> Self {
        let (lengths, errors) = (self.length * other.length, self.error * other.length + other.error * self.length);
        Self::new(self.at.cross(other.at), 6.0 * ROUNDOFF * lengths + 1.01 * (errors + self.error * other.error))
    }

    /// Whether the scalar product is surely positive.
    fn is_beyond(&self, side: &Self) -> bool {
        let error = side.error * self.length + side.length * self.error + side.error * self.error;
        side.at.dot(self.at) > 1.01 * error + 4.0 * ROUNDOFF * side.length * self.length
    }
}

/// A convex cone from the receiver: where `N . omega < 0` for the normals of its sides.
#[derive(Debug, Clone)]
pub(super) struct BoundingCone {
    /// The ray through each corner, and the normal of the side that starts there.
    corners: Few<[UncertainVector; 2]>,
    around: Option<CircularCone>,
}

/// A circular cone around a convex one, no wider than a half-space.
#[derive(Debug, Clone, Copy)]
pub(super) struct CircularCone {
    axis: DVec3,
    /// Lower bound on the cosine of the half-angle.
    cos: f64,
    /// Upper bound on the sine of the half-angle.
    sin: f64,
}

impl BoundingCone {
    /// The cone of these corners and sides.
    pub(super) fn new(corners: Few<[UncertainVector; 2]>) -> Self {
        let around = CircularCone::around(corners.iter().map(|[ray, _]| (ray.at / ray.length, 2.0 * ray.error / ray.length)));
        Self { corners, around }
    }

    /// The cone of a polygon's corners, clockwise as the receiver sees them.
    pub(super) fn of_polygon(x: DVec3, vertices: &[DVec3]) -> Self {
        let rays: Few<UncertainVector> = vertices.iter().map(|&vertex| UncertainVector::from_to(x, vertex)).collect();
        Self::new((0..rays.len()).map(|i| [rays[i], rays[i].cross(&rays[(i + 1) % rays.len()])]).collect())
    }

    /// Whether the two surely have no direction in common.
    pub(super) fn misses(&self, other: &Self) -> bool {
        CircularCone::are_apart(self.around, other.around) || self.is_parted_from(other) || other.is_parted_from(self)
    }

    /// Whether a side of this cone has all of the other one beyond it.
    fn is_parted_from(&self, other: &Self) -> bool {
        self.corners.iter().any(|[_, side]| other.corners.iter().all(|[ray, _]| ray.is_beyond(side)))
    }

    /// Approximate solid angle of a small cone.
    pub(super) fn size(&self) -> f64 {
        let unit = |[ray, _]: &[UncertainVector; 2]| ray.at / ray.length;
        let next = self.corners.iter().cycle().skip(1);
        let size = 0.5 * self.corners.iter().zip(next).map(|(a, b)| unit(a).cross(unit(b))).sum::<DVec3>().length();
        if size.is_nan() { 0.0 } else { size }
    }
}

impl CircularCone {
    /// Around unit vectors, each with a bound on its error; none where it would be too wide.
    pub(super) fn around(rays: impl Iterator<Item = (DVec3, f64)> + Clone) -> Option<Self> {
        let axis = rays.clone().map(|(ray, _)| ray).sum::<DVec3>().try_normalize()?;
        let cosines = rays.map(|(ray, error)| axis.dot(ray) - error);
        // Not a number where a ray is none.
        let least = cosines.fold(1.0, |least: f64, cos| if cos >= least || least.is_nan() { least } else { cos });
        let cos = least - 1e-12;
        (cos > 0.0).then(|| Self { axis, cos, sin: (1.0 - cos * cos).sqrt() })
    }

    /// Around points of the scene.
    pub(super) fn of_points(x: DVec3, points: &[DVec3]) -> Option<Self> {
        let unit = |&point: &DVec3| {
            let ray = UncertainVector::from_to(x, point);
            let inverse = 1.0 / ray.length;
            (ray.at * inverse, 2.0 * ray.error * inverse)
        };
        let rays: Few<(DVec3, f64)> = points.iter().map(unit).collect();
        Self::around(rays.iter().copied())
    }

    /// Whether two surely have no direction in common.
    pub(super) fn are_apart(one: Option<Self>, other: Option<Self>) -> bool {
        let (Some(a), Some(b)) = (one, other) else { return false };
        a.axis.dot(b.axis) < a.cos * b.cos - a.sin * b.sin - 1e-12
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A triangle around a direction, clockwise from the origin.
    fn triangle(middle: DVec3, size: f64) -> BoundingCone {
        let (u, v) = middle.any_orthonormal_pair();
        let mut corners = [u, v, -u - v].map(|aside| middle + aside * size);
        if corners[0].cross(corners[1]).dot(middle) > 0.0 {
            corners.reverse();
        }
        BoundingCone::of_polygon(DVec3::ZERO, &corners)
    }

    #[test]
    fn what_has_a_direction_in_common_is_never_missed() {
        // Each around the other's corner, nearer and nearer to only touching it.
        for k in 0..60 {
            let (near, scale) = (libm::exp2(-(k as f64)), libm::exp2(k as f64 - 30.0));
            let a = triangle(DVec3::new(0.3, 0.1, 1.0), 0.5);
            let b = triangle(a.corners[k % 3][0].at * scale, near * scale);
            assert!(!a.misses(&b) && !b.misses(&a), "{near}");
        }
    }

    #[test]
    fn what_is_apart_is_missed_until_rounding_may_join_it() {
        let a = triangle(DVec3::Z, 1.0);
        let [[from, side], [to, _], _] = a.corners[..] else { unreachable!() };
        let (edge, outward) = ((from.at + to.at) * 0.5, side.at.normalize());
        for k in 2..44 {
            let aside = 2f64.powi(-k);
            let b = triangle((edge + outward * aside) * 1e-200, 0.1 * aside * 1e-200);
            assert!(a.misses(&b) && b.misses(&a), "{aside}");
            assert!(!a.misses(&triangle(edge - outward * aside, 0.1 * aside)));
        }
        assert!(!a.misses(&triangle(edge + outward * 1e-16, 1e-17)));
    }

    #[test]
    fn what_is_not_a_number_is_not_missed() {
        let a = triangle(DVec3::Z, 1.0);
        for odd in [DVec3::ZERO, DVec3::NAN, DVec3::splat(f64::INFINITY)] {
            let b = BoundingCone::of_polygon(DVec3::ZERO, &[odd, DVec3::NEG_Z, DVec3::NEG_X]);
            assert!(!a.misses(&b) && !b.misses(&a), "{odd}");
        }
    }
}
