//! `A_i F_ij = (1/pi) int int (n1.r)(-n2.r)/|r|^4 dA dA` by a product Gauss rule in four variables, where two outlines are far apart
//! for their size: its terms have one sign, while the sum over edges cancels by the square of distance over size.
//!
//! A point of a patch is affine in each of its two variables with the other held, `x = c + s b`, `|b| <= l/2` for edges up to l.
//! With D a lower bound of the distance, in the Bernstein ellipse of radius `R = 1 + 3D/2l`, for s at `sigma + i tau`: `|r.r| >= (D -
//! (|sigma| - 1) l/2)^2 - (tau l/2)^2`, `|n.r| <= |r|` below the farthest distance and the ellipse's axes, and the Jacobian, of degree 1,
//! is at most `l^2 (1 + |s|)`: M of L. N. Trefethen 2008, theorem 4.5, once for each variable.

use std::f64::consts::PI;

use radgrad_core::DVec3;

use super::{Exchange, ROUNDOFF};
use crate::factors::rule::{Patch, gauss_legendre, patches};

/// Distance over size from which the rule is asked.
const FAR: f64 = 4.0;

/// Nodes in each variable, at most.
const MOST: usize = 8;

/// What two outlines exchange, each in front of the other, with a truncation of `allowed` over it; `None` where they are not far apart, or too oblique.
pub(super) fn exchange(outlines: [&[DVec3]; 2], normals: [DVec3; 2], allowed: f64) -> Option<Exchange> {
    let spheres = outlines.map(Sphere::around);
    let distance = spheres[0].apart(&spheres[1]);
    if distance < FAR * spheres[0].radius.max(spheres[1].radius) {
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
    let distance = spheres[0].apart(&spheres[1]).max(0.0);
    areas.map(|area| (area * (1.0 + 1e-12) / (PI * distance * distance)).min(1.0))
}

/// A sphere around some points.
struct Sphere {
    centre: DVec3,
    radius: f64,
}

impl Sphere {
    fn around(points: &[DVec3]) -> Self {
        let centre = points.iter().sum::<DVec3>() / points.len() as f64;
        let radius = points.iter().fold(0.0, |m: f64, p| m.max((*p - centre).length())) * (1.0 + 1e-12);
        Self { centre, radius }
    }

    fn apart(&self, other: &Self) -> f64 {
        (self.centre - other.centre).length() * (1.0 - 1e-12) - self.radius - other.radius
    }
}

fn of_patches([a, b]: [&Patch; 2], [n1, n2]: [DVec3; 2], allowed: f64) -> Option<Exchange> {
    let spheres = [a, b].map(|patch| Sphere::around(&patch.corners));
    let (distance, between) = (spheres[0].apart(&spheres[1]), spheres[1].centre - spheres[0].centre);
    let farthest = between.length() + spheres[0].radius + spheres[1].radius;
    let sides = [a, b].map(longest_side);
    let (areas, square) = ([a, b].map(|patch| patch.at(0.5, 0.5).1), between.length_squared());
    let rough = areas[0] * areas[1] * n1.dot(between) * -n2.dot(between) / (PI * square * square);
    let truncation = |nodes: usize| -> f64 {
        // Two variables each.
        let one = |side: f64, other: f64| 2.0 * one_variable(nodes, distance, farthest, side, other);
        one(sides[0], sides[1]) + one(sides[1], sides[0])
    };
    let (nodes, truncation) = (3..=MOST).map(|nodes| (nodes, truncation(nodes))).find(|(_, bound)| *bound <= allowed * rough)?;
    let rule = gauss_legendre(nodes);
    let points = [a, b].map(|patch| {
        let product = rule.iter().flat_map(|&u| rule.iter().map(move |&v| (u, v)));
        let at = |((u, w), (v, z)): ((f64, f64), (f64, f64))| {
            let (point, density) = patch.at(0.5 + 0.5 * u, 0.5 + 0.5 * v);
            (point, 0.25 * w * z * density)
        };
        product.map(at).collect::<Vec<_>>()
    });
    let (mut sum, mut error) = (0.0, 0.0);
    for &(x, weight_x) in &points[0] {
        for &(y, weight_y) in &points[1] {
            let r = y - x;
            let (c1, c2, square) = (n1.dot(r), -n2.dot(r), r.length_squared());
            let weight = weight_x * weight_y / (square * square);
            sum += weight * c1 * c2;
            // n.r errs by 8u of |r|, which is what there is of it where it grazes.
            error += weight * ((c1.abs() + c2.abs()) * square.sqrt() + 4.0 * (c1 * c2).abs());
        }
    }
    // Weights err by up to 16u.
    let rounding = 8.0 * ROUNDOFF * error + 64.0 * ROUNDOFF * sum.abs();
    Some(Exchange { area: sum / PI, error: (rounding / PI + truncation) * 1.01 })
}

/// Bound on what the rule leaves out in one variable of a patch with edges up to `side`.
fn one_variable(nodes: usize, distance: f64, farthest: f64, side: f64, other: f64) -> f64 {
    let half = 0.5 * side;
    let radius = 1.0 + 0.75 * distance / half;
    let (stretch, imaginary) = (0.5 * (radius + 1.0 / radius), 0.5 * (radius - 1.0 / radius));
    let clear = distance - (stretch - 1.0) * half;
    let least = clear * clear - (imaginary * half) * (imaginary * half);
    if clear <= 0.0 || least <= 0.0 {
        return f64::INFINITY;
    }
    let reach = farthest + 2.0 * stretch * half;
    let most = side * side * (1.0 + stretch) * other * other * reach * reach / (least * least * PI);
    let power = (0..nodes - 1).fold(1.0, |power, _| power / (radius * radius));
    // Half of the bound on [-1, 1], for a variable in [0, 1].
    32.0 / 15.0 * most * power / (1.0 - 1.0 / (radius * radius))
}

fn longest_side(patch: &Patch) -> f64 {
    let corners = patch.corners;
    (0..4).map(|i| (corners[(i + 1) % 4] - corners[i]).length()).fold(0.0, f64::max)
}
