//! `A_i F_ij = (1/pi) int int (n1.r)(-n2.r)/|r|^4 dA dA` by a product Gauss rule in four variables, where two outlines are far apart
//! for their size: its terms have one sign, while the sum over edges cancels by the square of distance over size.
//!
//! A point of a patch is affine in each of its two variables with the other held, `x = c + s b`, `|b| <= l/2` for edges up to l.
//! With D a lower bound of the distance, in the Bernstein ellipse of radius `R = 1 + 3D/2l`, for s at `sigma + i tau`: `|r.r| >= (D -
//! (|sigma| - 1) l/2)^2 - (tau l/2)^2`; `n.r` of the patch's own normal stays as it is, that of the other's is at most its largest
//! value plus `|s| l/2`; and the Jacobian is affine, `J + J_u s + J_v t`. Their product is at most M.
//!
//! A function that is at most M there has Chebyshev coefficients `|a_k| <= 2 M R^-k`. A rule of n nodes is exact up to the degree 2n - 1
//! and for all odd k; of the others it misses at most `2 + 2/(k^2 - 1) <= 32/15` each for n >= 2. So it errs by at most `(64/15) M
//! R^(-2n) / (1 - R^-2)` on [-1, 1] (after L. N. Trefethen 2008, theorem 4.5), once for each variable.

use std::f64::consts::PI;

use radgrad_core::DVec3;

use super::{Exchange, ROUNDOFF};
use crate::factors::rule::{Patch, gauss_legendre, patches};
use crate::factors::{larger, middle, smaller};

/// Distance over size from which the rule is asked.
const FAR: f64 = 4.0;

/// Nodes in each variable, at most.
const MOST: usize = 8;

/// What two outlines exchange, each in front of the other, with a truncation of `allowed` over it; `None` where they are not far apart, or too oblique.
pub(super) fn exchange(outlines: [&[DVec3]; 2], normals: [DVec3; 2], allowed: f64) -> Option<Exchange> {
    let spheres = outlines.map(Sphere::around);
    let distance = spheres[0].apart(&spheres[1]);
    if distance < FAR * larger(spheres[0].radius, spheres[1].radius) {
        return None;
    }
    let [from, to] = outlines.map(patches);
    if from.is_empty() || to.is_empty() {
        return None;
    }
    let mut sum = Exchange::default();
    for a in &from {
        for b in &to {
            let part = of_patches([a, b], normals, allowed)?;
            sum.area += part.area;
            sum.error += part.error + ROUNDOFF * sum.area.abs();
        }
    }
    // An outline with parts of no width has no rule.
    sum.error.is_finite().then_some(sum)
}

/// Bounds on the point factors to each of two outlines from anywhere on the other.
pub(super) fn most_seen(outlines: [&[DVec3]; 2], areas: [f64; 2]) -> [f64; 2] {
    let spheres = outlines.map(Sphere::around);
    let distance = larger(spheres[0].apart(&spheres[1]), 0.0);
    areas.map(|area| smaller(area * (1.0 + 1e-12) / (PI * distance * distance), 1.0))
}

/// A sphere around some points.
struct Sphere {
    centre: DVec3,
    radius: f64,
}

impl Sphere {
    fn around(points: &[DVec3]) -> Self {
        let centre = middle(points);
        let radius = points.iter().map(|p| (*p - centre).length()).fold(0.0, larger) * (1.0 + 1e-12);
        Self { centre, radius }
    }

    fn apart(&self, other: &Self) -> f64 {
        (self.centre - other.centre).length() * (1.0 - 1e-12) - self.radius - other.radius
    }
}

fn of_patches([a, b]: [&Patch; 2], [n1, n2]: [DVec3; 2], allowed: f64) -> Option<Exchange> {
    let spheres = [a, b].map(|patch| Sphere::around(&patch.corners));
    let (distance, between) = (spheres[0].apart(&spheres[1]), spheres[1].centre - spheres[0].centre);
    let shapes = [Jacobian::of(a), Jacobian::of(b)];
    let square = between.length_squared();
    let rough = shapes[0].middle * shapes[1].middle * n1.dot(between) * -n2.dot(between) / (PI * square * square);
    // Heights over the other's plane are largest at corners.
    let height = |patch: &Patch, normal: DVec3, origin: DVec3| {
        patch.corners.iter().map(|&p| normal.dot(p - origin).abs()).fold(0.0, larger) * (1.0 + 1e-12) + 8.0 * ROUNDOFF
    };
    // Corners may be off their own plane, by rounding.
    let tilts = [height(a, n1, a.corners[0]), height(b, n2, b.corners[0])];
    let heights = [height(a, n2, b.corners[0]) + tilts[1], height(b, n1, a.corners[0]) + tilts[0]];
    let truncation = |nodes: usize| -> f64 {
        let one = |k: usize| shapes[k].truncation(nodes, distance, [heights[k], heights[1 - k]], tilts[k]) * shapes[1 - k].most();
        one(0) + one(1)
    };
    let (nodes, truncation) = (2..=MOST).map(|nodes| (nodes, truncation(nodes))).find(|(_, bound)| *bound <= allowed * rough)?;
    let rule = gauss_legendre(nodes);
    let count = nodes * nodes;
    let mut points = [[(DVec3::ZERO, 0.0); MOST * MOST]; 2];
    for (patch, points) in [a, b].into_iter().zip(&mut points) {
        let product = rule.iter().flat_map(|&u| rule.iter().map(move |&v| (u, v)));
        for (((u, w), (v, z)), place) in product.zip(points) {
            let (point, density) = patch.at(0.5 + 0.5 * u, 0.5 + 0.5 * v);
            *place = (point, 0.25 * w * z * density);
        }
    }
    let (mut sum, mut error) = (0.0, 0.0);
    for &(x, weight_x) in &points[0][..count] {
        let (mut seen, mut rounding) = (0.0, 0.0);
        for &(y, weight_y) in &points[1][..count] {
            let r = y - x;
            let (c1, c2, square) = (n1.dot(r), -n2.dot(r), r.length_squared());
            let weight = weight_y / (square * square);
            seen += weight * c1 * c2;
            // n.r errs by 8u of |r|, which is what there is of it where it grazes.
            rounding += weight * ((c1.abs() + c2.abs()) * square.sqrt() + 4.0 * (c1 * c2).abs());
        }
        sum += weight_x * seen;
        error += weight_x * rounding;
    }
    // Weights err by up to 16u, and two sums have up to 64 terms.
    let rounding = 8.0 * ROUNDOFF * error + 160.0 * ROUNDOFF * sum.abs();
    Some(Exchange { area: sum / PI, error: (rounding / PI + truncation) * 1.01 })
}

/// The area of a patch for a unit of its two variables: affine in both, from -1 to 1.
struct Jacobian {
    middle: f64,
    slopes: [f64; 2],
    /// Longest edge.
    side: f64,
}

impl Jacobian {
    fn of(patch: &Patch) -> Self {
        let at = |u: f64, v: f64| patch.at(u, v).1;
        let corners = [at(0.0, 0.0), at(1.0, 0.0), at(0.0, 1.0)];
        let slopes = [0.5 * (corners[1] - corners[0]).abs(), 0.5 * (corners[2] - corners[0]).abs()];
        Self { middle: at(0.5, 0.5), slopes, side: longest_side(patch) }
    }

    fn most(&self) -> f64 {
        (self.middle + self.slopes[0] + self.slopes[1]) * (1.0 + 1e-12)
    }

    /// Bound on what the rule leaves out in the two variables of this patch, over the area of the other. `heights` are
    /// its own over the other's plane and the other's over its own, `tilt` what it is off its plane.
    fn truncation(&self, nodes: usize, distance: f64, heights: [f64; 2], tilt: f64) -> f64 {
        let half = 0.5 * self.side;
        let radius = 1.0 + 0.75 * distance / half;
        let (stretch, imaginary) = (0.5 * (radius + 1.0 / radius), 0.5 * (radius - 1.0 / radius));
        let clear = distance - (stretch - 1.0) * half;
        let least = clear * clear - (imaginary * half) * (imaginary * half);
        if clear <= 0.0 || least <= 0.0 {
            return f64::INFINITY;
        }
        let cosines = (heights[1] + stretch * tilt) * (heights[0] + stretch * half);
        // Once for each variable, with the other one anywhere.
        let areas = 2.0 * self.middle + (self.slopes[0] + self.slopes[1]) * (1.0 + stretch);
        let power = (0..nodes).fold(1.0, |power, _| power / (radius * radius));
        // Half of the bound on [-1, 1], for a variable in [0, 1].
        let share = 32.0 / 15.0 * power / (1.0 - 1.0 / (radius * radius));
        share * areas * (1.0 + 1e-12) * cosines / (least * least * PI)
    }
}

fn longest_side(patch: &Patch) -> f64 {
    let corners = patch.corners;
    (0..4).map(|i| (corners[(i + 1) % 4] - corners[i]).length()).fold(0.0, larger)
}
