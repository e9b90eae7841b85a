//! The exchange of two polygons with nothing in between: `A_i F_ij = A_j F_ji`, an area.
//!
//! `A_i F_ij = (1/2 pi) sum_ab (a.b) int_0^1 int_0^1 ln|x(s) - y(t)| ds dt` over the edges a of one and b of the other, each
//! counter-clockwise seen from its own lit side (Stokes' theorem twice: E. M. Sparrow 1963). It holds where all points of each are
//! in front of the other's plane, so both are cut there first; the parts behind exchange nothing.
//!
//! The bound has three parts. The sum's own: rounding and the Gauss rule ([`edges`]). The rounding of the coordinates and of the
//! cuts: a point sees of a polygon of area A at distance D at most `min(1, A/pi D^2)`, so corners that move by at most d change the
//! result by at most d times the perimeter times that. And corners level with the other's plane up to the rounding of coordinates
//! count as in it, as in [`crate::Beam::from_polygon`]. Far away the sum cancels, and [`far`] integrates the kernel itself. Of faces that are thin or
//! small for their distance roundings of the large one are left, and [`points`] integrates what is seen from them.

pub(super) mod areas;
mod clip;
pub(super) mod edges;
pub(super) mod far;
mod planar;
mod points;
mod skew;

#[cfg(test)]
mod tests;

use radgrad_core::{DVec3, Polygon};

use self::areas::{Exchange, FlatOutline, ROUNDOFF};
use self::edges::mean_logarithm;
use self::far::Part;
use super::rule::middle;
use crate::extremes::{largest as larger, smallest as smaller};
use crate::occluders::overlap::perimeter;
use crate::projection::normalising_power;

/// Relative truncation that is allowed where all digits are wanted.
pub(super) const ALL_DIGITS: f64 = 4e-14;

/// The part of it that the sum over edges may take: what it is compared with is a guess, which may be high.
const CONTOUR: f64 = 1.0 / 40.0;

/// Error over the smaller area, up to which the sum over edges is not held against what points see.
#[cfg(test)]
pub(super) const RESOLVED: f64 = 1e-9;

/// Points for that: the first number mostly, the second where the sum says less than this over the area.
const POINTS: [usize; 2] = [2_000, 10_000];
const UNRESOLVED: f64 = 1e-4;

/// The exchange of `from` and `to`, with about that much truncation allowed, over the result, and an error of `resolved` over the smaller area;
/// exactly 0 where neither has a point in front of the other.
pub(super) fn exchange(from: &Polygon, to: &Polygon, truncation: f64, resolved: f64) -> Exchange {
    let [from, to] = [from, to].map(|polygon| FlatOutline {
        points: polygon.vertices(),
        normal: polygon.normal(),
        slope: perimeter(polygon.vertices()) / polygon.area(),
        defect: polygon.planarity_defect(),
        area: polygon.area(),
    });
    exchange_outlines([&from, &to], truncation, resolved)
}

/// The same of two faces that have all of each other in front, up to a few roundings of coordinates up to 1, and are not near for their size; `None` where
/// they are. The parts of each are given, and how far its vertices may be off its plane.
pub(super) fn exchange_apart(faces: [(&[Part], &Polygon); 2], truncation: f64) -> Option<Exchange> {
    let [(from, a), (to, b)] = faces;
    let found = far::between([from, to], truncation)?;
    let moved = a.planarity_defect() + b.planarity_defect() + 64.0 * ROUNDOFF;
    let [seen_a, seen_b] = far::most_seen([a.vertices(), b.vertices()], [a.area(), b.area()]);
    let displaced = moved * (perimeter(a.vertices()) * seen_b + perimeter(b.vertices()) * seen_a);
    Some(Exchange { error: found.error + displaced, ..found })
}

/// The same of parts of polygons, by the sum over edges alone.
pub(super) fn exchange_parts(parts: [&FlatOutline<'_>; 2], truncation: f64) -> Exchange {
    exchange_outlines(parts, truncation, f64::INFINITY)
}

fn exchange_outlines(parts: [&FlatOutline<'_>; 2], truncation: f64, resolved: f64) -> Exchange {
    let origin = parts[0].points[0];
    let points = parts[0].points.iter().chain(parts[1].points);
    let reach = points.map(|&v| (v - origin).abs().max_element()).fold(0.0, larger);
    let power = normalising_power(reach);
    let [a, b] = parts.map(|part| clip::Outline::new(part, origin, power));
    let (Some(front_a), Some(front_b)) = (a.in_front_of(&b), b.in_front_of(&a)) else { return Exchange::default() };
    let (outlines, moved) = ([&front_a.points[..], &front_b.points[..]], larger(front_a.moved, front_b.moved));
    let normals = [a.normal, b.normal];
    let areas = parts.map(|part| part.area * power * power);
    let by_contour = || contour(outlines, CONTOUR * truncation * rough(outlines, normals, areas));
    let mut found = far::exchange(outlines, normals, truncation).unwrap_or_else(by_contour);
    let unresolved = found.error / smaller(areas[0], areas[1]);
    if unresolved > resolved {
        let from = usize::from(areas[1] < areas[0]);
        let most_points = POINTS[usize::from(unresolved > UNRESOLVED)];
        let goal = points::Goal { error: 0.3 * resolved, most_points };
        let by_points = points::exchange([outlines[from], outlines[1 - from]], normals[from], goal);
        found = by_points.filter(|by_points| by_points.error < found.error).unwrap_or(found);
    }
    let seen = far::most_seen(outlines, areas);
    let displaced = moved * (perimeter(outlines[0]) * seen[1] + perimeter(outlines[1]) * seen[0]);
    // Rounding of the bound itself, and of the scale, which is a power of two.
    Exchange { area: found.area / power / power, error: (found.error + displaced) * (1.0 + 1e-12) / power / power }
}

/// Rough exchange of two outlines: the kernel between their centres, with a disc's correction for near ones.
fn rough(outlines: [&[DVec3]; 2], normals: [DVec3; 2], areas: [f64; 2]) -> f64 {
    let [a, b] = outlines.map(middle);
    let r = b - a;
    let square = r.length_squared();
    let [large, small] = if areas[0] > areas[1] { areas } else { [areas[1], areas[0]] };
    let least = 0.01 * large / (square + large);
    let cosines = if square > 0.0 { larger(normals[0].dot(r) * -normals[1].dot(r) / square, least) } else { least };
    small * large * cosines / (std::f64::consts::PI * square + large)
}

/// The sum over edges, with an area of `truncation` allowed: the mean logarithm of each pair gets its share, as the sum cancels.
fn contour([a, b]: [&[DVec3]; 2], truncation: f64) -> Exchange {
    let edge = |outline: &[DVec3], i: usize| [outline[i], outline[(i + 1) % outline.len()]];
    let (mut sum, mut error) = (0.0, 0.0);
    let truncation = truncation * std::f64::consts::TAU / (perimeter(a) * perimeter(b));
    for i in 0..a.len() {
        for j in 0..b.len() {
            let pair = mean_logarithm(edge(a, i), edge(b, j), truncation);
            sum += pair.0;
            error += pair.1 + ROUNDOFF * sum.abs();
        }
    }
    let unit = std::f64::consts::TAU;
    Exchange { area: sum / unit, error: (error + 4.0 * ROUNDOFF * sum.abs()) / unit }
}
