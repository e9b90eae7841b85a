//! Bounds on what planes of surfaces leave out of a point's light.
//!
//! By planes of surfaces ([`super::Beam::from_point_of`]) a polygon hides nothing if what of it is above the horizon, in front of the
//! emitter or before the emitter's far side is so by rounding only. By its coordinates it may hide a sliver: the edge of a wall that a
//! lamp touches passes an ulp before the lamp's own edge. A polygon that is level all over with the point's surface or with the emitter
//! is taken to be in it. Of any other one
//!
//! | symbol | meaning |
//! |---|---|
//! | `x`, `e`, `q` | the point, the emitter, the polygon |
//! | `d` | a distance that is no less than a vertex may be off the plane of a surface |
//! | `A`, `r` | the area of a part, and a bound from below on its distance from x |
//! | `c` | a bound on the cosine at the part |
//!
//! light from y of e is hidden at a point of q that is above the horizon and in front of e, and y is on the far side of q's plane from x. So
//! the form factor of what q hides is at most that of the part of q above the horizon and before e, raised by d, and that of the part of e on
//! the far side, raised by d. Either is at most `A c / (pi r^2)`. Of a polygon whose edges are at least s from x, and its plane h, all places
//! are at least `max(h, s - sqrt(A / pi))` away: a place farther than that from all edges would have a larger disc around it in the polygon.

use std::f64::consts::PI;

use radgrad_core::{DVec3, Polygon};

use super::half_space::Plane;
use super::overlap::{above, on_the_way, perimeter};
use crate::extremes::{largest, smallest};

/// A bound on the form factor that a polygon hides of an emitter from a point of a surface, if planes of surfaces say that it hides nothing.
pub(crate) fn may_hide(point: DVec3, surface: &Polygon, emitter: &Polygon, other: &Polygon) -> f64 {
    let [horizon, front, across] = [surface, emitter, other].map(Plane::of);
    let vertices = other.vertices();
    if [&horizon, &front].iter().any(|plane| vertices.iter().all(|&v| plane.height(v).abs() <= plane.slack(v))) {
        return 0.0;
    }
    let seen = kept(&kept(vertices, &horizon, 1.0), &front, 1.0);
    let by_other = factor_at_most(point, &seen, &across);
    let side = across.height(point);
    if side.abs() <= across.slack(point) {
        return by_other;
    }
    let beyond = kept(emitter.vertices(), &across, -side.signum());
    smallest(by_other, factor_at_most(point, &beyond, &front))
}

/// The part of a polygon on a side of a plane, raised by what that may be off.
fn kept(vertices: &[DVec3], plane: &Plane, sign: f64) -> Vec<DVec3> {
    let slack = vertices.iter().map(|&v| plane.slack(v)).fold(0.0, largest);
    let heights: Vec<f64> = vertices.iter().map(|&v| sign * plane.height(v) + slack).collect();
    above(vertices, &heights, on_the_way)
}

/// A bound on the form factor of a polygon in a plane.
fn factor_at_most(point: DVec3, vertices: &[DVec3], plane: &Plane) -> f64 {
    if vertices.len() < 3 {
        return 0.0;
    }
    let edges = || (0..vertices.len()).map(|i| (vertices[i] - point, vertices[(i + 1) % vertices.len()] - point));
    // From a corner: areas of slivers cancel less than from the point.
    let corner = vertices[0] - point;
    let turning: DVec3 = edges().map(|(a, b)| (a - corner).cross(b - corner)).sum();
    let reach = vertices.iter().map(|v| largest(v.length(), (*v - point).length())).fold(point.length(), largest);
    // With the rounding of coordinates and of products.
    let area = 0.5 * turning.length() + 16.0 * f64::EPSILON * perimeter(vertices) * reach;
    let to_edge = edges().map(|(a, b)| distance(a, b)).fold(f64::INFINITY, smallest);
    let height = plane.height(point).abs();
    let rounding = 16.0 * f64::EPSILON * reach;
    let nearest = largest(height - plane.slack(point), to_edge - (area / PI).sqrt()) - rounding;
    if nearest <= 0.0 {
        return 1.0;
    }
    let cosine = smallest((height + plane.slack(point)) / nearest, 1.0);
    smallest(area * cosine / (PI * nearest * nearest), 1.0)
}

/// The distance of the origin from a segment.
fn distance(a: DVec3, b: DVec3) -> f64 {
    let along = b - a;
    let square = along.length_squared();
    let at = if square > 0.0 { (-a.dot(along) / square).clamp(0.0, 1.0) } else { 0.0 };
    (a + along * at).length()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn polygon(corners: &[[f64; 3]]) -> Polygon {
        Polygon::new(corners.iter().copied().map(DVec3::from).collect()).unwrap()
    }

    #[test]
    fn what_a_wall_an_ulp_before_a_lamp_hides_is_within_the_bound_and_little() {
        let floor = polygon(&[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]]);
        let lamp = polygon(&[[0.0, 0.0, 0.9], [0.0, 1.0, 0.9], [0.5, 1.0, 0.9], [0.5, 0.0, 0.9]]);
        let point = DVec3::new(0.3, 0.4, 0.0);
        for ulps in [0.0, 1.0, 4.0] {
            let x = ulps * f64::EPSILON;
            let wall = polygon(&[[x, 0.0, 0.0], [x, 1.0, 0.0], [x, 1.0, 1.0], [x, 0.0, 1.0]]);
            let bound = may_hide(point, &floor, &lamp, &wall);
            // A strip of this width, at its nearest.
            let strip = x * 0.9 * 0.9 / (PI * (0.09_f64 + 0.81).powi(2));
            assert!(bound >= 0.5 * strip && bound < 1e-13, "{ulps}: {bound:e}");
        }
        let level = polygon(&[[0.2, 0.2, 0.9], [0.2, 0.3, 0.9], [0.3, 0.3, 0.9]]);
        assert_eq!(may_hide(point, &floor, &lamp, &level), 0.0);
    }

    #[test]
    fn a_form_factor_is_within_its_bound() {
        let square = polygon(&[[0.0, 0.0, 1.0], [0.0, 1.0, 1.0], [1.0, 1.0, 1.0], [1.0, 0.0, 1.0]]);
        let bound = factor_at_most(DVec3::ZERO, square.vertices(), &Plane::of(&square));
        assert!((0.138_531_605..1.0 / PI + 1e-9).contains(&bound), "{bound}");
        // In the plane it sees nothing.
        assert!(factor_at_most(DVec3::new(3.0, 0.0, 1.0), square.vertices(), &Plane::of(&square)) < 1e-12);
    }
}
