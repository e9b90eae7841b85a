//! Polygons with many vertices, exactly planar, seen from anywhere on their lit side or from exactly within their plane.

use glam::DVec3;

use super::emission;
use super::scene::{Scene, elevations};
use crate::cases::lattice::{FINE, Lattice, Site, convex_sites, rectilinear_sites, star_sites};
use crate::cases::sampler::Sampler;

/// A polygon on a lattice; sites in units of 1/[`FINE`].
pub(super) struct OnLattice {
    lattice: Lattice,
    sites: Vec<Site>,
    /// Three corners of a triangle inside.
    inner: [Site; 3],
}

impl OnLattice {
    fn new(lattice: Lattice, sites: &[Site], inner: [Site; 3]) -> Self {
        let fine = |s: &Site| s.map(|c| c * FINE);
        Self { lattice, sites: sites.iter().map(fine).collect(), inner: inner.map(|s| fine(&s)) }
    }

    /// Strictly convex, 3 to 24 vertices.
    fn convex(sampler: &mut Sampler, lattice: Lattice) -> Self {
        let count = 3 + sampler.below(22) as usize;
        Self::convex_with(sampler, lattice, count)
    }

    /// Strictly convex with so many vertices.
    pub(super) fn convex_with(sampler: &mut Sampler, lattice: Lattice, count: usize) -> Self {
        let sites = convex_sites(sampler, count);
        let middle = 1 + sampler.below(u32::try_from(count - 2).unwrap_or(1)) as usize;
        let inner = [sites[0], sites[middle], sites[middle + 1]];
        Self::new(lattice, &sites, inner)
    }

    fn concave(sampler: &mut Sampler, lattice: Lattice) -> Self {
        if sampler.one_in(2) {
            let (sites, inner) = rectilinear_sites(sampler);
            Self::new(lattice, &sites, inner)
        } else {
            let count = 4 + sampler.below(13) as usize;
            Self::star(sampler, lattice, count)
        }
    }

    /// A star about (0, 0) with so many vertices.
    fn star(sampler: &mut Sampler, lattice: Lattice, count: usize) -> Self {
        let sites = star_sites(sampler, count);
        let inner = [[0, 0], sites[0], sites[1]];
        Self::new(lattice, &sites, inner)
    }

    /// Puts a vertex on the middle of an edge: a T-junction seen from one side.
    fn with_straight_vertex(mut self, sampler: &mut Sampler) -> Self {
        let count = self.sites.len();
        let index = sampler.below(u32::try_from(count).unwrap_or(1)) as usize;
        let (a, b) = (self.sites[index], self.sites[(index + 1) % count]);
        self.sites.insert(index + 1, [(a[0] + b[0]) / 2, (a[1] + b[1]) / 2]);
        self
    }

    pub(super) fn vertices(&self) -> Vec<DVec3> {
        self.sites.iter().map(|s| self.lattice.fine_point(*s)).collect()
    }

    /// Seen from a point over the inner triangle or beside the polygon, at a height of 2^-10 to 4; part of it above the horizon.
    fn with_receiver(self, sampler: &mut Sampler) -> Scene {
        let vertices = self.vertices();
        let [a, b, c] = self.inner.map(|s| self.lattice.fine_point(s));
        let cross = (b - a).cross(c - a);
        let lit = cross / cross.length();
        let foot = if sampler.one_in(2) { (a + b + c) / 3.0 } else { a + sampler.perpendicular(lit) * sampler.between(0.0, 3.0) };
        let position = foot + lit * sampler.spread(-10, 2);
        let normal = loop {
            let normal = sampler.direction();
            if elevations(normal, position, &vertices).1 > 0.1 {
                break normal;
            }
        };
        self.scene(sampler, position, normal)
    }

    pub(super) fn scene(self, sampler: &mut Sampler, position: DVec3, normal: DVec3) -> Scene {
        let vertices = self.vertices();
        let coarse: Vec<Site> = self.sites.iter().map(|s| s.map(|c| c / (FINE / 2))).collect();
        let emission = emission::on_sites(sampler, &vertices, &coarse);
        Scene::open(position, normal, vertices, emission)
    }
}

/// A lattice near the origin: of random direction, or horizontal.
pub(super) fn lattice(sampler: &mut Sampler) -> Lattice {
    if sampler.one_in(4) { Lattice::horizontal() } else { Lattice::random(sampler) }
}

/// Convex, one in four with a vertex on a straight edge.
pub(super) fn convex(sampler: &mut Sampler) -> Scene {
    let lattice = lattice(sampler);
    let mut polygon = OnLattice::convex(sampler, lattice);
    if sampler.one_in(4) {
        polygon = polygon.with_straight_vertex(sampler);
    }
    polygon.with_receiver(sampler)
}

/// Convex with 4 to 8 vertices, none on a straight edge.
pub(super) fn few_sided(sampler: &mut Sampler) -> Scene {
    let lattice = lattice(sampler);
    let count = 4 + sampler.below(5) as usize;
    OnLattice::convex_with(sampler, lattice, count).with_receiver(sampler)
}

/// Stars and rectilinear shapes, one in four with a vertex on a straight edge.
pub(super) fn concave(sampler: &mut Sampler) -> Scene {
    let lattice = lattice(sampler);
    let mut polygon = OnLattice::concave(sampler, lattice);
    if sampler.one_in(4) {
        polygon = polygon.with_straight_vertex(sampler);
    }
    polygon.with_receiver(sampler)
}

/// A star with so many vertices.
pub(super) fn star(sampler: &mut Sampler, count: usize) -> Scene {
    let lattice = lattice(sampler);
    OnLattice::star(sampler, lattice, count).with_receiver(sampler)
}

/// Convex, its coordinates up to 2^19 and exact.
pub(super) fn far_origin(sampler: &mut Sampler) -> Scene {
    let far = sampler.integer(0, 43);
    let offset = std::array::from_fn(|_| (sampler.integer(-(1 << 30), 1 << 30) * (1 << 14)) >> (43 - far));
    let lattice = Lattice::random(sampler).moved(offset);
    OnLattice::convex(sampler, lattice).with_receiver(sampler)
}

/// Inside the inner triangle, on an edge or at a vertex of it, by integer weights: exactly in the plane.
pub(super) fn in_plane_inside(sampler: &mut Sampler) -> Scene {
    let lattice = lattice(sampler);
    let polygon = if sampler.one_in(2) { OnLattice::convex(sampler, lattice) } else { OnLattice::concave(sampler, lattice) };
    let first = sampler.integer(0, FINE);
    let second = sampler.integer(0, FINE - first);
    let weights = match sampler.below(4) {
        0 => [0, FINE, 0],
        1 => [0, first, FINE - first],
        _ => [first, second, FINE - first - second],
    };
    let mean = |axis: usize| (0..3).map(|k| weights[k] * (polygon.inner[k][axis] / FINE)).sum::<i64>();
    let position = polygon.lattice.fine_point([mean(0), mean(1)]);
    let normal = sampler.direction();
    polygon.scene(sampler, position, normal)
}

/// Beyond a vertex on the line from another: outside a convex polygon, on the line of an edge if the two are neighbours.
pub(super) fn in_plane_outside(sampler: &mut Sampler) -> Scene {
    let lattice = lattice(sampler);
    let polygon = OnLattice::convex(sampler, lattice);
    let count = u32::try_from(polygon.sites.len()).unwrap_or(3);
    let from = sampler.below(count);
    let to = (from + 1 + sampler.below(count - 1)) % count;
    let (from, to) = (polygon.sites[from as usize], polygon.sites[to as usize]);
    let beyond = sampler.integer(1, 4 * FINE);
    let position = polygon.lattice.fine_point([0, 1].map(|k| to[k] + (to[k] - from[k]) / FINE * beyond));
    let normal = sampler.direction();
    polygon.scene(sampler, position, normal)
}
