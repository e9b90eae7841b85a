//! The mean logarithm of two edges that are in no plane: over one edge in closed form, over the other by Gauss-Legendre rules on cells.
//!
//! With z and h the place and the distance of `x(s)` along and from the line of the second edge, of length l, the inner integral is
//! `g l = [z ln(z^2 + h^2)/2 + h atan(z/h)] - l`, from z at the start to z at the end of it. On a cell of half-length m in s, n nodes err by at most `(64/15) M R^(-2n)
//! / (1 - R^-2)` on [-1, 1] ([`super::far`]), where g, or g less a constant, is at most M in the Bernstein ellipse of radius R. Two ways know an R:
//!
//! *By the distance* D of the cell from the other edge. For s at `sigma + i tau`, in units of m from the centre, `|r.r| >= (D - (|sigma| - 1) m)^2 - tau^2
//! m^2`, so that for `R < 1 + D/m` it does not vanish for any t, and `M = (|ln|r.r|| + pi)/2`.
//!
//! *By the singular places of the closed form.* With `w = z + i h` and its conjugate w', at the start and at the end, it is half the sum of
//! `w ln w + w' ln w'` between the two. So g is analytic where h^2 does not vanish, nor `w w' = z^2 + h^2` for either end. The lines of the edges are H apart, at an angle alpha:
//!
//! | what vanishes | where | so from a real s it is away by |
//! |---|---|---|
//! | `h^2` | at the crossing, `+- i H/(|a| sin alpha)` beside | `h(s)/(|a| sin alpha)` |
//! | `w w'` of an end of b | at its foot on the line of a, `+- i d/|a|` beside, d its distance from that line | its distance from `x(s)`, over `|a|` |
//!
//! Edges that run side by side come near each other all along, yet these places are near few cells, and halving makes as many cells as the
//! logarithm of the distances says. Let s be no farther from a place sigma of the cell than 3/5 of the least of these distances. From there `|z'| = |a| cos
//! alpha` and `|h'| <= 5/4 |a| sin alpha`, so that w moves by less than `0.97 |w(sigma)|`: its argument stays within 1.33 of `[0, pi]`. In units of twice
//! the largest `|r|` of an end, `|w| <= 1` and `|w ln w| <= 1/e + 4.5`. This gives `M = 20 |r|/l` for g less a constant. The ellipse with `R - 1/R = 2 B` is within B of [-1, 1].
//!
//! Where 16 nodes do not do, the cell is halved; at most down to 2^-50 of the edge, where `int |ln r|` itself is small enough.

use std::collections::VecDeque;
use std::f64::consts::PI;

use radgrad_core::DVec3;

use super::areas::ROUNDOFF;
use crate::extremes::{largest as larger, smallest as smaller};
use crate::factors::rule::gauss_legendre;

/// Nodes to try.
const NODES: [usize; 7] = [2, 3, 4, 6, 8, 12, 16];

/// Halvings before singular places are asked for.
const PLAIN: i32 = 3;

/// Truncation below which no rule is asked, over the length of the second edge.
const LEAST: f64 = 1e-15;

/// Halvings of an edge.
const HALVINGS: i32 = 50;

/// Cells of an edge: three places, each graded from both sides, take some hundreds.
const CELLS: usize = 400;

/// The mean of ln r by a rule along the first edge.
pub(super) fn skew(p: DVec3, along: DVec3, b: [DVec3; 2], [length, most, truncation]: [f64; 3]) -> (f64, f64) {
    let direction = (b[1] - b[0]) / length;
    let own = along.length();
    let sine = along.cross(direction).length() / own + 8.0 * ROUNDOFF;
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
        let size = half * own;
        let allowed = larger(truncation, all_digits);
        let plain = rule_for(by_distance(ends, b, size), allowed);
        let by_places = || rule_for(by_places(ends, b, direction, [length, sine, size]), allowed);
        // The first cells are mostly halved anyway, and what is left of them served by their distance.
        let asks_places = halvings <= HALVINGS - PLAIN;
        let Some((nodes, truncation)) = plain.or_else(|| if asks_places { by_places() } else { None }) else {
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

/// A Bernstein ellipse, and what the integrand is at most there.
#[derive(Debug, Clone, Copy)]
struct Ellipse {
    radius: f64,
    most: f64,
}

/// By the distance of a cell, of this half-length, from the other edge.
fn by_distance(ends: [DVec3; 2], b: [DVec3; 2], half: f64) -> Option<Ellipse> {
    let distance = segments_apart(ends, b) * (1.0 - 1e-9) - 8.0 * ROUNDOFF;
    let radius = 1.0 + 0.75 * distance / half;
    let (stretch, imaginary) = (0.5 * (radius + 1.0 / radius), 0.5 * (radius - 1.0 / radius));
    let clear = distance - (stretch - 1.0) * half;
    let least = clear * clear - (imaginary * half) * (imaginary * half);
    // |r| <= 4 between real points, and the ellipse adds its semi-axes.
    let farthest = 4.0 + 2.0 * stretch * half;
    let most = 0.5 * (larger(libm::log(least).abs(), 2.0 * libm::log(farthest)) + PI);
    (distance > 0.0 && least > 0.0).then_some(Ellipse { radius, most })
}

/// By the places where the closed form is singular: lengths are those of the other edge and of half the cell, the sine that of the edges.
fn by_places(ends: [DVec3; 2], b: [DVec3; 2], direction: DVec3, [length, sine, half]: [f64; 3]) -> Option<Ellipse> {
    // Coordinates up to 4, in few roundings.
    let off = 32.0 * ROUNDOFF;
    let to_line = ends.map(|x| larger((x - b[0]).cross(direction).length() - off, 0.0) / sine);
    let to_ends = b.map(|y| ends.map(|x| larger((x - y).length() - off, 0.0)));
    let [start, end] = to_ends.map(|distances| least_between(distances, 2.0 * half));
    let nearest = smaller(smaller(start, end), least_between(to_line, 2.0 * half));
    let within = 0.6 * nearest / half;
    let radius = within + (within * within + 1.0).sqrt();
    let farthest = to_ends.iter().flatten().fold(0.0, |most, &r| larger(most, r)) + off;
    (within > 0.0).then_some(Ellipse { radius, most: 20.0 * farthest / length })
}

/// Least distance of a segment from a point that has these from its ends.
fn least_between([a, b]: [f64; 2], length: f64) -> f64 {
    let place = 0.5 * ((a - b) * (a + b) / length + length);
    if place <= 0.0 || place >= length {
        return smaller(a, b) * (1.0 - 1e-9);
    }
    // Of a point on the segment a rounding of squares is left.
    let square = (a - place) * (a + place) - 1e-9 * length * length;
    larger(square, 0.0).sqrt() * (1.0 - 1e-9)
}

/// The fewest nodes whose bound on [-1, 1] is small enough, and the bound.
fn rule_for(ellipse: Option<Ellipse>, allowed: f64) -> Option<(usize, f64)> {
    let Ellipse { radius, most } = ellipse?;
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
pub(super) fn segments_apart([a, b]: [DVec3; 2], [c, d]: [DVec3; 2]) -> f64 {
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
