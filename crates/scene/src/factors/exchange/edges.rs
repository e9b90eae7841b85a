//! `(a.b) int_0^1 int_0^1 ln|x(s) - y(t)| ds dt` for two edges `x(s) = p + s a`, `y(t) = q + t b` in normalised coordinates.
//!
//! - Perpendicular edges give 0.
//! - Parallel ones are elementary: with the distance h of their lines and `z = z0 + t - s` along them, `F(z) = (z^2 - h^2)/4 ln(z^2 +
//!   h^2) - 3 z^2/4 + h z atan(z/h)` has `F'' = ln(z^2 + h^2)/2`, and four of its values give the integral, however near the edges
//!   are, or one and the same.
//! - For others the inner integral is elementary, `[z ln(z^2 + h^2)/2 + h atan(z/h)] - |b|`, and the outer one is left to a
//!   Gauss-Legendre rule on cells of the edge. The inner one is analytic in s where `r.r` does not vanish for any t: on a cell of
//!   half-length m at distance D from the other edge that is so in the Bernstein ellipse with `R < 1 + D/m`, since for s at `sigma + i
//!   tau`, in units of m from the centre, `|r.r| >= (D - (|sigma| - 1) m)^2 - tau^2 m^2`. There `|ln(r.r)/2| <= (|ln|r.r|| + pi)/2 =:
//!   M`, and n nodes err by at most `(64/15) M R^(-2n) / (1 - R^-2)` on [-1, 1] ([`super::far`]). Where 16 nodes do not do, the cell is halved; at a common corner down to 2^-50 of the edge, where `int |ln r|` itself is small enough.

use std::collections::VecDeque;
use std::f64::consts::PI;

use radgrad_core::DVec3;

use super::ROUNDOFF;
use crate::factors::rule::gauss_legendre;
use crate::factors::{larger, smaller};

/// Nodes to try.
const NODES: [usize; 7] = [2, 3, 4, 6, 8, 12, 16];

/// Truncation below which no rule is asked, over the length of the second edge.
const LEAST: f64 = 1e-15;

/// Halvings of an edge.
const HALVINGS: i32 = 50;

/// Cells of an edge: two corners, graded, take a hundred, and one where edges meet at a small angle a hundred over that. Edges that
/// almost touch along all their length would take any number.
const CELLS: usize = 5000;

/// Two edges are parallel if moving an end by this makes them so: rounded coordinates, of size 1, tell no better.
const ASIDE: f64 = 64.0 * ROUNDOFF;

/// The integral times `a.b`, and a bound on its error. `truncation` is allowed of the mean logarithm.
pub(super) fn mean_logarithm(a: [DVec3; 2], b: [DVec3; 2], truncation: f64) -> (f64, f64) {
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
        skew(a[0], along_a, b, [lengths[1], most, truncation])
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

/// The mean of ln r by a rule along the first edge.
fn skew(p: DVec3, along: DVec3, b: [DVec3; 2], [length, most, truncation]: [f64; 3]) -> (f64, f64) {
    let direction = (b[1] - b[0]) / length;
    let own = along.length();
    let (mut sum, mut error) = (0.0, 0.0);
    // The largest first: those that are left if there are too many are the shortest.
    let mut cells = VecDeque::from([(0.0, 1.0, HALVINGS)]);
    let mut count = 0;
    let (all_digits, enough) = (LEAST / smaller(length, 1.0), larger(truncation, LEAST));
    while let Some((from, to, halvings)) = cells.pop_front() {
        count += 1;
        let half = 0.5 * (to - from);
        let middle = 0.5 * (from + to);
        let ends = [p + along * from, p + along * to];
        let distance = segments_apart(ends, b) * (1.0 - 1e-9) - 8.0 * ROUNDOFF;
        let Some((nodes, truncation)) = rule_for(distance, half * own, larger(truncation, all_digits)) else {
            // A mean of |ln r|, doubled for what rounding does to so short a cell.
            let left = 2.0 * (to - from) * most;
            if halvings == 0 || count > CELLS || left <= enough {
                error += left;
            } else {
                cells.extend([(from, middle, halvings - 1), (middle, to, halvings - 1)]);
            }
            continue;
        };
        let (mut part, mut rounding) = (0.0, 0.0);
        for &(node, weight) in gauss_legendre(nodes) {
            let (value, size) = inner(b[0] - (p + along * (middle + half * node)), direction, length);
            part += weight * value;
            rounding += weight * size;
        }
        sum += half * part;
        error += half * (truncation + 32.0 * ROUNDOFF * rounding);
    }
    // Rounding of the weights and of the sum.
    (sum, error + 32.0 * ROUNDOFF * (sum.abs() + most))
}

/// The fewest nodes whose bound on [-1, 1] is small enough, and the bound.
fn rule_for(distance: f64, half: f64, allowed: f64) -> Option<(usize, f64)> {
    let ratio = distance / half;
    // Below this 16 nodes never do.
    if ratio.is_nan() || ratio < 1.0 {
        return None;
    }
    let radius = 1.0 + 0.75 * ratio;
    let (stretch, imaginary) = (0.5 * (radius + 1.0 / radius), 0.5 * (radius - 1.0 / radius));
    let clear = distance - (stretch - 1.0) * half;
    let least = clear * clear - (imaginary * half) * (imaginary * half);
    if least <= 0.0 {
        return None;
    }
    // |r| <= 4 between real points, and the ellipse adds its semi-axes.
    let farthest = 4.0 + 2.0 * stretch * half;
    let most = 0.5 * (larger(libm::log(least).abs(), 2.0 * libm::log(farthest)) + PI);
    let bound = |nodes: usize| {
        let power = (0..nodes).fold(1.0, |power, _| power / (radius * radius));
        64.0 / 15.0 * most * power / (1.0 - 1.0 / (radius * radius))
    };
    NODES.into_iter().map(|nodes| (nodes, bound(nodes) * 1.01)).find(|(_, bound)| *bound <= allowed)
}

/// `int_0^1 ln|r + t b| dt`, and what 32u of bounds its rounding: r errs by a few u of coordinates below 4, and the integral's
/// derivatives with respect to z and h are `ln r` at the ends and an angle.
fn inner(r: DVec3, direction: DVec3, length: f64) -> (f64, f64) {
    let z = r.dot(direction);
    let h = r.cross(direction).length();
    let end = z + length;
    let logarithm = |z: f64| {
        let square = z * z + h * h;
        if square == 0.0 { 0.0 } else { 0.5 * libm::log(square) }
    };
    let (first, second) = (logarithm(z), logarithm(end));
    let angle = libm::atan2(length * h, h * h + z * end);
    let value = (end * second - z * first + h * angle) / length - 1.0;
    let size = (first.abs() + second.abs() + PI) * (1.0 + 4.0 / length);
    (value, size)
}

/// Distance of two segments, from below but for a relative 1e-9.
fn segments_apart([a, b]: [DVec3; 2], [c, d]: [DVec3; 2]) -> f64 {
    let to_segment = |p: DVec3, [from, to]: [DVec3; 2]| {
        let along = to - from;
        let t = ((p - from).dot(along) / along.length_squared()).clamp(0.0, 1.0);
        (from + along * t - p).length()
    };
    let ends = [to_segment(a, [c, d]), to_segment(b, [c, d]), to_segment(c, [a, b]), to_segment(d, [a, b])]
        .into_iter()
        .fold(f64::INFINITY, smaller);
    let (u, v, w) = (b - a, d - c, a - c);
    let (uu, uv, vv, uw, vw) = (u.dot(u), u.dot(v), v.dot(v), u.dot(w), v.dot(w));
    let determinant = uu * vv - uv * uv;
    if determinant <= 1e-12 * uu * vv {
        // The inside of either is at most 1e-6 of the shorter nearer than its ends.
        return ends - 1e-6 * smaller(uu, vv).sqrt();
    }
    let (s, t) = ((uv * vw - vv * uw) / determinant, (uu * vw - uv * uw) / determinant);
    // A margin for the rounding of s and t.
    let inside = |x: f64| (-1e-3..=1.0 + 1e-3).contains(&x);
    if inside(s) && inside(t) { smaller(ends, (w.dot(u.cross(v)) / determinant.sqrt()).abs()) } else { ends }
}
