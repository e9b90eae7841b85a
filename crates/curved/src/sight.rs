//! Occlusion by patches: which ones can hide anything at all, and whether one is between two points.
//!
//! A patch that is a part of the boundary of a convex body which holds the whole scene, lit from within, hides nothing. For
//! polygons, spheres and cylinders that is decided from the extent of the others, on the safe side; for bilinear and Bezier
//! patches at a grid of tangent planes, to which the patch's own points must be on the lit side too.
//!
//! Of the others, all but Bezier patches are parts of surfaces of second order, which a line meets twice at most. A point known to
//! be on the surface is one of the two, and is divided out rather than found again: two points of one such surface never hide
//! each other. A Bezier patch that may hide something is refused.

use radgrad_core::{DVec3, Polygon};

use crate::patch::{Cylinder, Form, Patch, Sphere, Spot};

/// Tangent planes a side at which a bilinear or Bezier patch is looked at.
const GRID: usize = 33;

/// A point behind a plane by less than this part of the scene's size is on it.
const ON: f64 = 1e-9;

/// Rounding of a point's coordinates, relative to their size.
const ROUNDED: f64 = 1e-14;

/// A point of a patch, known by its index.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Station {
    pub(crate) patch: usize,
    pub(crate) spot: Spot,
}

/// Whether a patch of a scene can hide anything in it.
pub(crate) fn may_hide(which: usize, patches: &[&Patch], size: f64) -> bool {
    let within = |limit: f64, far: &dyn Fn(&Patch) -> f64| patches.iter().all(|patch| far(patch) <= limit + ON * size);
    let behind = |normal: DVec3, point: DVec3, others: &dyn Fn(usize) -> bool| {
        let others = patches.iter().enumerate().filter(|(index, _)| others(*index));
        others.map(|(_, patch)| patch.farthest_along(-normal) + normal.dot(point)).fold(f64::NEG_INFINITY, f64::max)
    };
    match &patches[which].0 {
        Form::Polygon(polygon) => behind(polygon.normal(), polygon.vertices()[0], &|index| index != which) > ON * size,
        Form::Sphere(s) => s.outwards || !within(s.radius, &|patch| patch.farthest_from(s.centre, DVec3::ZERO)),
        Form::Cylinder(c) => {
            let along = c.axis.normalize();
            // Of the same cylinder nothing is outside.
            let far = |patch: &Patch| match &patch.0 {
                Form::Cylinder(other) if other.axis.normalize().dot(along).abs() > 1.0 - ON => {
                    c.across(other.base - c.base).length() + other.radius
                }
                _ => patch.farthest_from(c.base, along),
            };
            c.outwards || !within(c.radius, &far)
        }
        Form::Bilinear(_) | Form::Bezier(_) => {
            let step = |i: usize| i as f64 / (GRID - 1) as f64;
            let places = (0..GRID * GRID).map(|i| [step(i % GRID), step(i / GRID)]);
            let spots: Vec<Spot> = places.map(|places| patches[which].spot(places)).collect();
            spots.iter().any(|here| {
                let own = spots.iter().map(|there| here.normal.dot(here.point - there.point)).fold(0.0, f64::max);
                own > ON * size || behind(here.normal, here.point, &|index| index != which) > ON * size
            })
        }
    }
}

/// Whether a patch is between two points that face each other.
pub(crate) fn hides(which: usize, patch: &Patch, from: &Station, to: &Station) -> bool {
    let [starts, ends] = [from, to].map(|station| station.patch == which);
    let (x, d) = (from.spot.point, to.spot.point - from.spot.point);
    match &patch.0 {
        Form::Polygon(polygon) => !starts && !ends && hidden_by_polygon(polygon, x, d),
        // Nothing leaves a ball and meets it again.
        Form::Sphere(s) => {
            let [starts, ends] = [from, to].map(|station| station.patch == which || on_sphere(s, station.spot.point));
            !((starts || ends) && s.outwards) && meets(&sphere(s, x, d), starts, ends, |t| s.holds(x + d * t))
        }
        Form::Cylinder(c) => {
            let [starts, ends] = [from, to].map(|station| station.patch == which || on_cylinder(c, station.spot.point));
            !((starts || ends) && c.outwards) && meets(&cylinder(c, x, d), starts, ends, |t| c.holds(x + d * t))
        }
        Form::Bilinear(corners) => {
            !(starts && ends) && hidden_by_bilinear(corners, x, d, starts.then_some(from), ends.then_some(to))
        }
        Form::Bezier(_) => false,
    }
}

/// Whether a point, of another patch, is on the sphere: up to the rounding of its coordinates.
fn on_sphere(sphere: &Sphere, point: DVec3) -> bool {
    ((point - sphere.centre).length() - sphere.radius).abs() <= ROUNDED * (sphere.radius + sphere.centre.length())
}

fn on_cylinder(cylinder: &Cylinder, point: DVec3) -> bool {
    let distance = cylinder.across(point - cylinder.base).length();
    (distance - cylinder.radius).abs() <= ROUNDED * (cylinder.radius + point.length())
}

fn hidden_by_polygon(polygon: &Polygon, x: DVec3, d: DVec3) -> bool {
    let (v, n) = (polygon.vertices(), polygon.normal());
    let (start, rise) = (n.dot(x - v[0]), n.dot(d));
    if start * (start + rise) >= 0.0 {
        return false;
    }
    let p = x - d * (start / rise);
    // Crossings of a ray along the first edge with the others, in the polygon's plane.
    let along = (v[1] - v[0]).normalize();
    let across = n.cross(along);
    let crosses = |i: usize| {
        let (a, b) = (v[i] - p, v[(i + 1) % v.len()] - p);
        let (ya, yb) = (across.dot(a), across.dot(b));
        (ya > 0.0) != (yb > 0.0) && along.dot(a) - ya * (along.dot(b) - along.dot(a)) / (yb - ya) > 0.0
    };
    (0..v.len()).filter(|&i| crosses(i)).count() % 2 == 1
}

/// `a t^2 + 2 b t + c`.
struct Quadratic([f64; 3]);

fn sphere(sphere: &Sphere, x: DVec3, d: DVec3) -> Quadratic {
    let r = x - sphere.centre;
    Quadratic([d.length_squared(), d.dot(r), r.length_squared() - sphere.radius * sphere.radius])
}

fn cylinder(cylinder: &Cylinder, x: DVec3, d: DVec3) -> Quadratic {
    let (r, d) = (cylinder.across(x - cylinder.base), cylinder.across(d));
    Quadratic([d.length_squared(), d.dot(r), r.length_squared() - cylinder.radius * cylinder.radius])
}

/// Whether a root between 0 and 1 is on a patch, where 0 or 1 may be known to be one.
fn meets(&Quadratic([a, b, c]): &Quadratic, starts: bool, ends: bool, holds: impl Fn(f64) -> bool) -> bool {
    let inside = |t: f64| t > 0.0 && t < 1.0 && holds(t);
    if a <= 0.0 || (starts && ends) {
        return false;
    }
    if starts {
        return inside(-2.0 * b / a);
    }
    if ends {
        return inside(c / a);
    }
    let discriminant = b * b - a * c;
    if discriminant <= 0.0 {
        return false;
    }
    // Without cancellation.
    let q = -(b + discriminant.sqrt().copysign(b));
    inside(q / a) || (q != 0.0 && inside(c / q))
}

/// The bilinear surface `a + u b + v c + u v e` met by a line: two equations across the line, one quadratic for u.
fn hidden_by_bilinear(corners: &[DVec3; 4], x: DVec3, d: DVec3, start: Option<&Station>, end: Option<&Station>) -> bool {
    let [p, q, r, s] = *corners;
    let (b, c, e) = (q - p, s - p, p - q + r - s);
    let one = d.any_orthogonal_vector();
    let two = d.cross(one);
    let part = |w: DVec3| [w.dot(p - x), w.dot(b), w.dot(c), w.dot(e)];
    let (f, g) = (part(one), part(two));
    // (f0 + f1 u)(g2 + g3 u) = (g0 + g1 u)(f2 + f3 u).
    let quadratic =
        [f[1] * g[3] - g[1] * f[3], 0.5 * (f[0] * g[3] + f[1] * g[2] - g[0] * f[3] - g[1] * f[2]), f[0] * g[2] - g[0] * f[2]];
    let on = |u: f64| {
        let (below, other) = (f[2] + f[3] * u, g[2] + g[3] * u);
        let v = if below.abs() > other.abs() { -(f[0] + f[1] * u) / below } else { -(g[0] + g[1] * u) / other };
        let y = p + b * u + c * v + e * (u * v);
        let t = d.dot(y - x) / d.length_squared();
        (0.0..=1.0).contains(&u) && (0.0..=1.0).contains(&v) && t > 0.0 && t < 1.0
    };
    let [qa, qb, qc] = quadratic;
    if let Some(end) = start.or(end) {
        // The sum of the roots gives the other.
        return qa != 0.0 && on(-2.0 * qb / qa - end.spot.at[0]);
    }
    let discriminant = qb * qb - qa * qc;
    if discriminant < 0.0 {
        return false;
    }
    let q = -(qb + discriminant.sqrt().copysign(qb));
    (qa != 0.0 && on(q / qa)) || (q != 0.0 && on(qc / q))
}

#[cfg(test)]
mod tests {
    use std::f64::consts::{PI, TAU};

    use super::*;
    use crate::patch::Side;

    fn station(patch: usize, point: [f64; 3], at: [f64; 2]) -> Station {
        let point = DVec3::from(point);
        Station { patch, spot: Spot { point, normal: DVec3::Z, area: 1.0, at } }
    }

    /// Numbers in [0, 1] without order.
    fn noise(i: u32, j: u32) -> f64 {
        f64::from((i * 7919 + j * 104_729) % 10_007) / 10_007.0
    }

    /// Whether a segment meets a patch, from its distance to a grid of points of it.
    fn near(patch: &Patch, x: DVec3, y: DVec3) -> f64 {
        let step = |i: u32| f64::from(i) / 300.0;
        let distance = |p: DVec3| {
            let t = (y - x).dot(p - x) / (y - x).length_squared();
            if (0.0..=1.0).contains(&t) { (x + (y - x) * t - p).length() } else { f64::INFINITY }
        };
        let grid = (0..=300).flat_map(|i| (0..=300).map(move |j| [step(i), step(j)]));
        grid.map(|at| distance(patch.spot(at).point)).fold(f64::INFINITY, f64::min)
    }

    fn patches() -> [Patch; 3] {
        let corners = [[-1.0, -1.0, 0.3], [1.0, -1.0, -0.4], [1.0, 1.0, 0.5], [-1.0, 1.0, -0.2]].map(DVec3::from);
        [
            Patch::sphere(DVec3::ZERO, 0.9, [0.4, 2.0], [-0.5, 3.0], Side::Outside).unwrap(),
            Patch::cylinder(DVec3::new(0.1, 0.0, -0.7), DVec3::new(0.2, 0.1, 1.3), 0.6, DVec3::X, [1.0, 5.0], Side::Inside)
                .unwrap(),
            Patch::bilinear(corners).unwrap(),
        ]
    }

    #[test]
    fn what_is_between_is_seen_to_be() {
        for (which, patch) in patches().iter().enumerate() {
            let (mut hidden, mut clear) = (0, 0);
            for i in 0..40 {
                let point = |j: u32| [0, 1, 2].map(|k| 3.0 * noise(i, 7 * j + k + 1) - 1.5);
                let (from, to) = (station(7, point(0), [0.0; 2]), station(8, point(1), [0.0; 2]));
                let distance = near(patch, from.spot.point, to.spot.point);
                // Points of the grid are within 0.02 of each other; a line that passes an edge as near as that decides nothing.
                if hides(0, patch, &from, &to) {
                    assert!(distance < 0.02, "{which} {i}: {distance}");
                    hidden += 1;
                } else {
                    assert!(distance > 0.002, "{which} {i}: {distance}");
                    clear += usize::from(distance > 0.02);
                }
            }
            assert!(hidden > 2 && clear > 10, "{which}: {hidden} {clear}");
        }
    }

    #[test]
    fn a_patch_does_not_hide_its_own_points_but_may_stand_behind_them() {
        for patch in &patches() {
            for i in 0..30 {
                let place = [noise(i, 1), noise(i, 2)];
                let own = Station { patch: 0, spot: patch.spot(place) };
                let other = Station { patch: 0, spot: patch.spot([noise(i, 3), noise(i, 4)]) };
                assert!(!hides(0, patch, &own, &other));
                // Straight up from the patch by a little, nothing is in the way.
                let up = own.spot.point + own.spot.normal * 1e-3;
                assert!(!hides(0, patch, &own, &station(3, up.into(), place)));
                assert!(!hides(0, patch, &station(3, up.into(), place), &own));
            }
        }
        // From the inside of a sphere's wall out through the wall on the other side.
        let sphere = Patch::sphere(DVec3::ZERO, 1.0, [0.0, PI], [0.0, TAU], Side::Inside).unwrap();
        let own = Station { patch: 0, spot: sphere.spot([0.0, 0.5]) };
        assert!(hides(0, &sphere, &own, &station(1, [-3.0, 0.1, 0.2], [0.0; 2])));
        assert!(!hides(0, &sphere, &own, &station(1, [-0.9, 0.1, 0.2], [0.0; 2])));
    }

    #[test]
    fn only_what_stands_out_may_hide_something() {
        let wall = |points: [[f64; 3]; 4]| Patch::polygon(Polygon::new(points.map(DVec3::from).to_vec()).unwrap());
        let floor = wall([[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [1.0, 1.0, 0.0], [-1.0, 1.0, 0.0]]);
        let turned = wall([[-1.0, -1.0, 0.0], [-1.0, 1.0, 0.0], [1.0, 1.0, 0.0], [1.0, -1.0, 0.0]]);
        let dome = Patch::sphere(DVec3::ZERO, 2.0, [0.0, 0.5 * PI], [0.0, TAU], Side::Inside).unwrap();
        let ball = Patch::whole_sphere(DVec3::Z, 0.5, Side::Outside).unwrap();
        let room = [&floor, &dome, &ball];
        assert_eq!([0, 1, 2].map(|which| may_hide(which, &room, 4.0)), [false, false, true]);
        assert!(may_hide(0, &[&turned, &dome], 4.0));
        let small = Patch::whole_sphere(DVec3::ZERO, 0.7, Side::Inside).unwrap();
        assert!(may_hide(0, &[&small, &dome], 4.0));
        let saddle =
            |h: f64| Patch::bilinear([[0.0, 0.0, h], [1.0, 0.0, 0.0], [1.0, 1.0, h], [0.0, 1.0, 0.0]].map(DVec3::from)).unwrap();
        assert!(!may_hide(0, &[&saddle(0.0), &dome], 4.0) && may_hide(0, &[&saddle(0.2), &dome], 4.0));
    }
}
