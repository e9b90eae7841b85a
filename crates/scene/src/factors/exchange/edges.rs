//! `(a.b) int_0^1 int_0^1 ln|x(s) - y(t)| ds dt` for two edges `x(s) = p + s a`, `y(t) = q + t b` in normalised coordinates.
//!
//! - Perpendicular edges give 0.
//! - Parallel ones are elementary: with the distance h of their lines and `z = z0 + t - s` along them, `F(z) = (z^2 - h^2)/4 ln(z^2 +
//!   h^2) - 3 z^2/4 + h z atan(z/h)` has `F'' = ln(z^2 + h^2)/2`, and four of its values give the integral, however near the edges
//!   are, or one and the same.
//! - Edges in one plane, or so nearly that their height does not count, have the closed form of [`planar`](super::planar).
//! - For others the inner integral is elementary, `[z ln(z^2 + h^2)/2 + h atan(z/h)] - |b|`, and the outer one is left to a
//!   Gauss-Legendre rule on cells of the edge ([`super::skew`]).
//!
//! Where more than one holds, the one of the smaller bound counts.

use radgrad_core::DVec3;

use super::areas::ROUNDOFF;
use super::planar::Plane;
use super::skew::{segments_apart, skew};
use crate::extremes::{largest as larger, smallest as smaller};

/// Two edges are parallel if moving an end by this makes them so: rounded coordinates, of size 1, tell no better.
const ASIDE: f64 = 64.0 * ROUNDOFF;

/// The integral times `a.b`, and a bound on its error. `truncation` is allowed of the mean logarithm.
pub(in crate::factors) fn mean_logarithm(a: [DVec3; 2], b: [DVec3; 2], truncation: f64) -> (f64, f64) {
    let (along_a, along_b) = (a[1] - a[0], b[1] - b[0]);
    let lengths = [along_a.length(), along_b.length()];
    let product = lengths[0] * lengths[1];
    let weight = along_a.dot(along_b);
    // The ends of an edge may be one point in this unit.
    if product == 0.0 {
        return (0.0, 0.0);
    }
    // The mean of |ln r| along a line of length l <= 4 is at most ln 4 + ln(2/l) + 1.
    let most = 4.0 + libm::log(2.0 / lengths[1]).abs();
    if weight.abs() <= 8.0 * ROUNDOFF * product {
        return (0.0, 8.0 * ROUNDOFF * product * most);
    }
    // How far the shorter edge's end is from where it were if the two were parallel.
    let aside = along_a.cross(along_b).length() / larger(lengths[0], lengths[1]);
    let (mean, error) = if aside <= ASIDE {
        // What is short enough may have any direction: turning it moves its end farther than that.
        let turned = ASIDE / (0.5 + 0.5 * weight.abs() / product).sqrt();
        let aside = if aside == 0.0 { 0.0 } else { turned };
        let starts = [a[0], b[0]];
        let is_second_longer = lengths[1] > lengths[0];
        let (along, lengths, [from, to]) = if is_second_longer {
            (along_b, [lengths[1], lengths[0]], [starts[1], starts[0]])
        } else {
            (along_a, lengths, starts)
        };
        parallel(from, along, lengths, to, weight > 0.0, aside)
    } else {
        oblique([a, b], [along_a, along_b], lengths, [most, truncation])
    };
    // The weight is a sum of three products.
    (weight * mean, (weight.abs() * error + 4.0 * ROUNDOFF * product * mean.abs()) * (1.0 + 8.0 * ROUNDOFF))
}

/// The mean of ln r on edges whose directions differ by a few roundings, the longer one first: that of the other is as much less known
/// as it is shorter.
///
/// F errs by 16u of its terms. Where the edges are not parallel to the last bit, an end of the shorter one, of length l, is `aside` by
/// that much, and `int int 1/r` is at most `2 l ln(4/u) <= 80 l` where the lines are not nearer than u.
fn parallel(p: DVec3, along: DVec3, [m, n]: [f64; 2], q: DVec3, same_way: bool, aside: f64) -> (f64, f64) {
    let direction = along / m;
    let offset = q - p;
    let distance = offset.cross(direction).length();
    let start = offset.dot(direction);
    // The other edge from its end that comes first.
    let z = if same_way { start } else { start - n };
    let second = |z: f64| {
        let square = z * z + distance * distance;
        if square == 0.0 {
            return 0.0;
        }
        let turn = if distance == 0.0 { 0.0 } else { distance * z * libm::atan(z / distance) };
        0.25 * (z - distance) * (z + distance) * libm::log(square) - 0.75 * z * z + turn
    };
    let terms = [second(z + n), second(z - m), -second(z + n - m), -second(z)];
    let sum: f64 = terms.iter().sum();
    let size: f64 = terms.iter().map(|term| term.abs()).sum();
    // Where ln passes through 0 the terms are small and their parts are not: those are below 2 z^2 + h^2, with |z|, h <= 4.
    let reach = z.abs() + m + n + distance;
    let product = m * n;
    let rounding = 16.0 * ROUNDOFF * (size + 2.0 * reach * reach) + 80.0 * aside * smaller(m, n);
    (sum / product, rounding / product)
}

/// The mean of ln r on edges that are not parallel: in their plane, if they have one, or else by a rule.
fn oblique([a, b]: [[DVec3; 2]; 2], along: [DVec3; 2], lengths: [f64; 2], [most, truncation]: [f64; 2]) -> (f64, f64) {
    // The share of the whole that is allowed, or the rule's own rounding.
    let enough = larger(16.0 * truncation, 32.0 * ROUNDOFF * most * (1.0 + 4.0 / lengths[1]));
    let by_rule = || skew(a[0], along[0], b, [lengths[1], most, truncation]);
    let in_plane = |(plane, raised): (Plane, f64)| {
        let (mean, rounding) = plane.mean_logarithm();
        (mean + raised, (rounding + raised) * (1.0 + 8.0 * ROUNDOFF))
    };
    let plane = || {
        let plane = Plane::of(a, b, along, lengths);
        let raised = 0.5 * plane.raised(enough, || larger(segments_apart(a, b) * (1.0 - 1e-9) - 8.0 * ROUNDOFF, 0.0));
        (plane, raised)
    };
    if are_off_any_plane(a[0] - b[0], along, lengths, enough) {
        let by_rule = by_rule();
        return if by_rule.1 <= enough { by_rule } else { better(by_rule, in_plane(plane())) };
    }
    let plane = plane();
    let is_flat = plane.1 <= enough;
    let first = if is_flat { in_plane(plane) } else { by_rule() };
    if first.1 <= enough {
        return first;
    }
    better(first, if is_flat { by_rule() } else { in_plane(plane) })
}

/// Whether they are so far off any plane that no closed form serves: of three vectors that are at most 2h off a plane the determinant is at most 6h times
/// the product of the longer two.
fn are_off_any_plane(offset: DVec3, along: [DVec3; 2], [m, n]: [f64; 2], enough: f64) -> bool {
    let determinant = along[0].cross(along[1]).dot(offset).abs();
    let away = offset.length();
    let height = determinant / (6.0 * larger(m * n, larger(m, n) * away));
    height > enough && height * height > 64.0 * enough
}

fn better(first: (f64, f64), second: (f64, f64)) -> (f64, f64) {
    if first.1 <= second.1 { first } else { second }
}
