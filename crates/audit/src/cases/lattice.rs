//! Polygons that are planar to the last bit.
//!
//! Rounding the vertices of a polygon with more than three of them bends it, and then "the" integral over it is not defined to
//! more than a few ulp. Here every vertex is `2^k (o + i a + j b)` with small integer vectors o, a, b and integers i, j: exact
//! in doubles, so the polygon is exactly planar, and an affine function of (i, j) with integer coefficients is exactly affine
//! on it.

use glam::DVec3;

use crate::cases::sampler::{Sampler, power_of_two};

/// Integer coordinates on a lattice.
pub(crate) type Site = [i64; 2];

/// Sites are refined by this factor where points between them are needed (a receiver in the plane).
pub(crate) const FINE: i64 = 256;

/// A plane spanned by two integer vectors.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Lattice {
    origin: [i64; 3],
    a: [i64; 3],
    b: [i64; 3],
    exponent: i64,
}

/// Largest coordinate of a site: 12 bits.
pub(crate) const SITE: i64 = 1 << 11;

/// Largest component of a basis vector: 15 bits, 28 with a site and its sum, 36 with [`FINE`].
const BASIS: i64 = 1 << 14;

impl Lattice {
    /// A plane of random direction through points of size about 1. The basis is not far from orthogonal.
    pub(crate) fn random(sampler: &mut Sampler) -> Self {
        loop {
            let mut vector = || std::array::from_fn(|_| sampler.integer(-BASIS, BASIS));
            let (a, b) = (vector(), vector());
            let (u, v) = (real(a), real(b));
            let squares = u.length_squared() * v.length_squared();
            let least = 0.1 * (BASIS * BASIS) as f64;
            if u.cross(v).length_squared() > 0.25 * squares && u.length_squared() > least && v.length_squared() > least {
                let reach = BASIS * SITE;
                let origin = std::array::from_fn(|_| sampler.integer(-reach, reach) / 2);
                return Self { origin, a, b, exponent: -25 };
            }
        }
    }

    /// The plane of the first two coordinates, at height 0: heights over it are exact.
    #[must_use]
    pub(crate) const fn horizontal() -> Self {
        Self { origin: [0; 3], a: [1, 0, 0], b: [0, 1, 0], exponent: -11 }
    }

    /// The plane moved by `offset` lattice units of 2^-25 along the coordinates.
    #[must_use]
    pub(crate) fn moved(mut self, offset: [i64; 3]) -> Self {
        for (component, step) in self.origin.iter_mut().zip(offset) {
            *component += step;
        }
        self
    }

    /// The point at (i, j) / [`FINE`]: exact.
    #[must_use]
    pub(crate) fn fine_point(&self, [i, j]: Site) -> DVec3 {
        let component = |axis: usize| self.origin[axis] * FINE + i * self.a[axis] + j * self.b[axis];
        real([component(0), component(1), component(2)]) * (power_of_two(self.exponent) / FINE as f64)
    }
}

fn real(v: [i64; 3]) -> DVec3 {
    DVec3::from_array(v.map(|c| c as f64))
}

/// Twice the signed area of the triangle a b c.
#[must_use]
pub(crate) const fn turn(a: Site, b: Site, c: Site) -> i64 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

/// Sites of a strictly convex polygon with `count` vertices, counter-clockwise: points of a stretched circle by its rational
/// parametrisation `((1 - t^2), 2 t) / (1 + t^2)`.
pub(crate) fn convex_sites(sampler: &mut Sampler, count: usize) -> Vec<Site> {
    loop {
        let (width, height) = (sampler.between(0.3, 1.0), sampler.between(0.3, 1.0));
        let mut sites: Vec<Site> = (0..count).map(|k| on_circle(sampler, k, count, width, height, 1.0)).collect();
        sites.dedup();
        let corner = |k: usize| turn(sites[k], sites[(k + 1) % count], sites[(k + 2) % count]);
        if sites.len() == count && (0..count).all(|k| corner(k) > 0) && circles_once(&sites) && large(&sites) {
            return sites;
        }
    }
}

/// Sites of a polygon that is star-shaped about (0, 0) and has a reflex vertex, counter-clockwise.
pub(crate) fn star_sites(sampler: &mut Sampler, count: usize) -> Vec<Site> {
    loop {
        let sites: Vec<Site> = (0..count)
            .map(|k| {
                let radius = sampler.between(0.2, 1.0);
                on_circle(sampler, k, count, 1.0, 1.0, radius)
            })
            .collect();
        let reflex = (0..count).any(|k| turn(sites[k], sites[(k + 1) % count], sites[(k + 2) % count]) < 0);
        if reflex && circles_once(&sites) {
            return sites;
        }
    }
}

/// A site near angle 2 pi k / count on an ellipse, jittered.
fn on_circle(sampler: &mut Sampler, k: usize, count: usize, width: f64, height: f64, radius: f64) -> Site {
    let quarter = (4.0 * (k as f64 + sampler.between(-0.3, 0.3)) / count as f64).rem_euclid(4.0);
    // t in [-1, 1] covers the quarter around the first axis; turning it by right angles covers the rest.
    let turns = (quarter + 0.5).floor();
    let t = (quarter - turns) * 0.83;
    let (x, y) = ((1.0 - t * t) / (1.0 + t * t), 2.0 * t / (1.0 + t * t));
    let (x, y) = match turns.rem_euclid(4.0) {
        0.0 => (x, y),
        1.0 => (-y, x),
        2.0 => (-x, -y),
        _ => (y, -x),
    };
    [rounded(width * radius * x), rounded(height * radius * y)]
}

/// A coordinate in [-1, 1] on the grid of sites.
fn rounded(x: f64) -> i64 {
    let on_grid = (x * (SITE - 1) as f64).round();
    #[expect(clippy::cast_possible_truncation, reason = "an integer of at most 11 bits")]
    let site = on_grid as i64;
    site
}

/// Whether the sites go once around (0, 0), each step by less than half a turn.
fn circles_once(sites: &[Site]) -> bool {
    let count = sites.len();
    let steps_forward = (0..count).all(|k| turn([0, 0], sites[k], sites[(k + 1) % count]) > 0);
    // Each step is forward, so the number of turns is the number of passages of the positive first axis.
    let below = |s: Site| s[1] < 0;
    let passages = (0..count).filter(|&k| below(sites[k]) && !below(sites[(k + 1) % count])).count();
    steps_forward && passages == 1
}

fn large(sites: &[Site]) -> bool {
    sites.windows(2).skip(1).map(|pair| turn(sites[0], pair[0], pair[1])).sum::<i64>() > SITE * SITE / 8
}

/// Rectilinear shapes, the last not star-shaped: L, U and a spiral, on a grid whose lines are spread at random; and a triangle
/// inside.
pub(crate) fn rectilinear_sites(sampler: &mut Sampler) -> (Vec<Site>, [Site; 3]) {
    const L: &[[usize; 2]] = &[[0, 0], [2, 0], [2, 1], [1, 1], [1, 2], [0, 2]];
    const U: &[[usize; 2]] = &[[0, 0], [3, 0], [3, 2], [2, 2], [2, 1], [1, 1], [1, 2], [0, 2]];
    const SPIRAL: &[[usize; 2]] =
        &[[0, 0], [5, 0], [5, 5], [1, 5], [1, 2], [3, 2], [3, 3], [2, 3], [2, 4], [4, 4], [4, 1], [0, 1]];
    let template = [L, U, SPIRAL][sampler.below(3) as usize];
    let mut line = || {
        let mut coordinate = -SITE + sampler.integer(0, 300);
        std::array::from_fn::<i64, 6, _>(|_| {
            coordinate += sampler.integer(60, 600);
            coordinate
        })
    };
    let (across, up) = (line(), line());
    let place = |site: &[usize; 2]| [across[site[0]], up[site[1]]];
    // The cell [0, 1]^2 is part of all three.
    (template.iter().map(place).collect(), [[0, 0], [1, 0], [1, 1]].map(|s| place(&s)))
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use radgrad_core::Polygon;

    /// A coordinate on a lattice in units of 2^-33, its last bit.
    #[expect(clippy::cast_possible_truncation, reason = "an integer of at most 53 bits")]
    pub(crate) fn in_units(coordinate: f64) -> i128 {
        (coordinate * power_of_two(33)) as i128
    }

    #[test]
    fn every_shape_is_a_polygon_without_any_planarity_defect() {
        for index in 0..200 {
            let mut sampler = Sampler::new(1, "lattice", index);
            let lattice = Lattice::random(&mut sampler).moved(std::array::from_fn(|_| sampler.integer(0, 1 << 30) << 14));
            let count = 3 + usize::try_from(index % 22).expect("small");
            for sites in
                [convex_sites(&mut sampler, count), star_sites(&mut sampler, count.max(4)), rectilinear_sites(&mut sampler).0]
            {
                assert!(sites.iter().flatten().all(|c| c.abs() <= SITE), "{sites:?}");
                let polygon = Polygon::new(sites.iter().map(|s| lattice.fine_point(s.map(|c| c * FINE))).collect())
                    .expect("a valid polygon");
                // The normal is rounded, so a height computed with it is not exactly 0, but far below an ulp.
                assert!(polygon.planarity_defect() < 1e-24, "{}", polygon.planarity_defect());
            }
        }
    }

    #[test]
    fn points_of_a_lattice_are_coplanar_in_exact_arithmetic() {
        let mut sampler = Sampler::new(3, "coplanar", 0);
        let lattice = Lattice::random(&mut sampler);
        let scaled = |site: Site| lattice.fine_point(site).to_array().map(in_units);
        let o = scaled([0, 0]);
        let from_origin = |site: Site| {
            let p = scaled(site);
            [p[0] - o[0], p[1] - o[1], p[2] - o[2]]
        };
        let (u, v) = (from_origin([FINE, 0]), from_origin([0, FINE]));
        for _ in 0..50 {
            let w = from_origin([sampler.integer(-100_000, 100_000), sampler.integer(-100_000, 100_000)]);
            let determinant =
                u[0] * (v[1] * w[2] - v[2] * w[1]) - u[1] * (v[0] * w[2] - v[2] * w[0]) + u[2] * (v[0] * w[1] - v[1] * w[0]);
            assert_eq!(determinant, 0);
        }
    }
}
