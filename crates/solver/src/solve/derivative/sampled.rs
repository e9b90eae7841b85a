//! Integrals over lines through edges, and over rays from faces, whose sums are the derivatives by vertices.
//!
//! The irradiance of a place x that moves with its face, along its normal n1 by h1, has the derivative
//!
//! ```text
//! 1/pi int over the edges seen from x: (B_behind - B_ahead) (n1.w) q.m/r sin(t, w) dl     q = V(y) - h1 n1
//!   + 1/pi int (n1.w) grad B . s dw                       s = h1 n1 + w (h2 - h1 n1.n2)/(w.n2)
//!   - 1/pi int B (grad h1 . w) dw
//! ```
//!
//! with w the direction from x to y, t that of the edge and m that across both: edges sweep what is beside them over what is behind; the
//! place of a plane that is seen slides, and the horizon turns. Weighed by the importance `a = rho I` and integrated over x the first is
//! an integral over lines through places of edges,
//!
//! ```text
//! 1/pi int dl int dw a(x) (B_behind - B_ahead) q.(t x w)
//! ```
//!
//! and the second one over rays from y, as `(n1.w) dA1 dw = -(n2.w) dA2 dw`: no distance is left in them, so that samples of them are
//! bounded however near faces are. Where an edge stands on a face the line ends there at once: what the edge covers loses its light.

use std::f64::consts::PI;

use radgrad_core::DVec3;
use radgrad_scene::largest;
use smallvec::SmallVec;

use crate::field::Field;
use crate::links::station::Station;
use crate::mesh::shape::Shape;
use crate::solve::derivative::outline::{Edge, Joint, Plane};
use crate::solve::solution::Solution;

/// How far beside an edge it is looked for what is ahead of it and behind it, over the extent of the scene.
const BESIDE: f64 = 1e-7;

/// A value in each channel.
type Light = SmallVec<[f64; 4]>;

/// A point of the sum.
pub(super) struct Viewpoint {
    pub(super) station: Station,
    /// Its weight times its reflectance, in each channel.
    pub(super) weights: Vec<f64>,
}

/// A domain of integration, mapped to by the unit cube.
#[derive(Debug, Clone, Copy)]
pub(super) enum Domain {
    /// Lines through an edge.
    Lines(usize),
    /// Rays from a face.
    Rays(usize),
    /// The edge, as a point sees it.
    Sight { point: usize, edge: usize },
    /// All that a point sees.
    Surroundings(usize),
}

/// What is integrated.
pub(super) struct Integrands<'a> {
    solution: &'a Solution,
    importance: &'a Field,
    pub(super) points: Vec<Viewpoint>,
    pub(super) edges: Vec<Edge>,
    planes: Vec<Plane>,
    /// The first vertex of each face among those of all.
    first_vertices: Vec<usize>,
    /// The leaves of each face, each with the area of those before it and its own.
    leaves: Vec<Vec<(usize, f64)>>,
    /// The faces that exchange light, each with the area of those before it and its own.
    areas: Vec<(usize, f64)>,
}

/// A place of a face.
#[derive(Clone, Copy)]
struct Place {
    face: usize,
    at: DVec3,
}

/// A sum over vertices: of each that has a part, in a channel.
pub(super) trait Sum {
    fn add(&mut self, vertex: usize, channel: usize, change: DVec3);
}

impl<'a> Integrands<'a> {
    pub(super) fn new(solution: &'a Solution, importance: &'a Field, points: Vec<Viewpoint>) -> Self {
        let mesh = &solution.system.mesh;
        let mut leaves = vec![Vec::new(); mesh.polygons().len()];
        for leaf in mesh.leaves() {
            let element = &mesh.elements()[leaf];
            let before = leaves[element.face()].last().map_or(0.0, |(_, area)| *area);
            leaves[element.face()].push((leaf, before + element.area()));
        }
        let mut areas = Vec::new();
        let mut area = 0.0;
        for (face, leaves) in leaves.iter().enumerate() {
            if let Some((_, own)) = leaves.last() {
                area += own;
                areas.push((face, area));
            }
        }
        let mut first_vertices = vec![0];
        for polygon in mesh.polygons() {
            first_vertices.push(first_vertices[first_vertices.len() - 1] + polygon.vertices().len());
        }
        let planes = mesh.polygons().iter().map(Plane::from_polygon).collect();
        let edges = Edge::of_mesh(mesh, solution.system.extent);
        Self { solution, importance, points, edges, planes, first_vertices, leaves, areas }
    }

    /// All domains.
    pub(super) fn domains(&self) -> Vec<Domain> {
        let mut domains: Vec<Domain> = (0..self.edges.len()).map(Domain::Lines).collect();
        domains.extend(self.areas.iter().map(|(face, _)| Domain::Rays(*face)));
        for (point, Viewpoint { station, .. }) in self.points.iter().enumerate() {
            let is_above = |edge: &usize| {
                let edge = &self.edges[*edge];
                [0.0, 1.0].into_iter().any(|part| station.normal.dot(edge.place(part) - station.point) > 0.0)
            };
            domains.extend((0..self.edges.len()).filter(is_above).map(|edge| Domain::Sight { point, edge }));
            domains.push(Domain::Surroundings(point));
        }
        domains
    }

    /// How many vertices there are.
    pub(super) fn vertices(&self) -> usize {
        self.first_vertices[self.first_vertices.len() - 1]
    }

    /// The number of a face's vertex among those of all.
    pub(super) fn vertex(&self, face: usize, vertex: usize) -> usize {
        self.first_vertices[face] + vertex
    }

    /// Adds the integrand at a place of the unit cube, times the domain's measure and a weight.
    pub(super) fn add(&self, domain: Domain, unit: [f64; 4], weight: f64, sum: &mut impl Sum) {
        match domain {
            Domain::Lines(edge) => self.add_line(&self.edges[edge], unit, weight, sum),
            Domain::Rays(face) => self.add_ray(face, unit, weight, sum),
            Domain::Sight { point, edge } => self.add_sight(&self.points[point], &self.edges[edge], unit[0], weight, sum),
            Domain::Surroundings(point) => self.add_surroundings(&self.points[point], unit, weight, sum),
        }
    }

    fn first_met(&self, from: DVec3, toward: DVec3, leave_out: &[usize]) -> Option<Place> {
        self.solution.system.mesh.front_met(from, toward, leave_out).map(|(face, at)| Place { face, at })
    }

    fn leaf(&self, place: Place) -> Option<usize> {
        self.solution.system.mesh.leaf_at(place.face, place.at)
    }

    /// A light's polynomial on a leaf at a place.
    fn value(&self, leaf: usize, at: DVec3, coefficients: impl Fn(usize) -> &'a [f64]) -> Light {
        let (basis, element) = (self.solution.basis(leaf), self.solution.element(leaf));
        let mut values: SmallVec<[f64; 32]> = SmallVec::from_elem(0.0, basis.len());
        basis.fill(element.reference(at), &mut values);
        let channels = 0..self.solution.channels().len();
        channels.map(|channel| coefficients(channel).iter().zip(&values).map(|(c, v)| c * v).sum()).collect()
    }

    fn importance(&self, place: Place) -> Option<Light> {
        let leaf = self.leaf(place)?;
        let light = self.value(leaf, place.at, |channel| self.importance.coefficients(leaf, channel));
        light.iter().any(|a| *a != 0.0).then_some(light)
    }

    fn radiosity(&self, place: Place) -> Option<Light> {
        let leaf = self.leaf(place)?;
        let mut light = self.value(leaf, place.at, |channel| self.solution.radiosity.field.coefficients(leaf, channel));
        light.iter_mut().enumerate().for_each(|(channel, b)| *b += self.solution.lamp_on(place.face, channel));
        Some(light)
    }

    /// The radiosity that a ray meets: none where it meets a back, or nothing.
    fn seen(&self, from: DVec3, toward: DVec3, leave_out: &[usize]) -> Light {
        let met = self.first_met(from, toward, leave_out).and_then(|place| self.radiosity(place));
        met.unwrap_or_else(|| SmallVec::from_elem(0.0, self.solution.channels().len()))
    }

    /// Adds the change by an edge's motion relative to the plane that the light falls on.
    fn add_edge(&self, (edge, part): (&Edge, f64), receiver: Option<Place>, change: impl Fn(usize) -> DVec3, sum: &mut impl Sum) {
        for channel in 0..self.solution.channels().len() {
            let change = change(channel);
            if change == DVec3::ZERO {
                continue;
            }
            for (end, hat) in edge.ends.into_iter().zip([1.0 - part, part]) {
                sum.add(self.vertex(edge.face, end), channel, change * hat);
            }
            if let Some(Place { face, at }) = receiver {
                let normal = self.planes[face].normal;
                self.add_heights(face, at, channel, -normal.dot(change), sum);
            }
        }
    }

    /// Adds a change by the height of a place of a face.
    fn add_heights(&self, face: usize, at: DVec3, channel: usize, change: f64, sum: &mut impl Sum) {
        let plane = &self.planes[face];
        for (vertex, (hat, _)) in plane.parts(at).enumerate() {
            sum.add(self.vertex(face, vertex), channel, plane.normal * (change * hat));
        }
    }

    /// Adds a change by the slope of a face's height along a direction.
    fn add_slopes(&self, face: usize, along: DVec3, channel: usize, change: f64, sum: &mut impl Sum) {
        let plane = &self.planes[face];
        for (vertex, slope) in plane.slopes().iter().enumerate() {
            sum.add(self.vertex(face, vertex), channel, plane.normal * (change * slope.dot(along)));
        }
    }

    /// Adds a line through an edge: from the place that receives the light, past the edge, to what is on either side of it.
    fn add_line(&self, edge: &Edge, [part, height, turn, _]: [f64; 4], weight: f64, sum: &mut impl Sum) {
        let (extent, mesh) = (self.solution.system.extent, &self.solution.system.mesh);
        let (at, toward) = (edge.place(part), on_sphere(height, turn));
        let across = edge.direction.cross(toward);
        let side = across.normalize_or_zero() * (BESIDE * extent);
        let Joint { faces, mut touched } = edge.joint(mesh, part, extent);
        let covered = touched.iter().find(|&&face| self.planes[face].normal.dot(toward) > 0.0);
        let (receiver, sides) = if let Some(&face) = covered {
            // The place itself, seen from where it is covered and where it is not.
            let receiver = Place { face, at };
            let normal = self.planes[face].normal;
            let start = |aside: DVec3| at + aside + toward * (largest(-aside.dot(normal), 0.0) / normal.dot(toward));
            let Some(importance) = self.importance(receiver) else { return };
            ((receiver, importance), [side, -side].map(|aside| self.seen(start(aside), toward, &[face])))
        } else {
            touched.extend(&faces);
            let Some(receiver) = self.first_met(at, -toward, &touched) else { return };
            let Some(importance) = self.importance(receiver) else { return };
            ((receiver, importance), [side, -side].map(|aside| self.seen(receiver.at, at + aside - receiver.at, &[receiver.face])))
        };
        let ((receiver, importance), [ahead, behind]) = (receiver, sides);
        // 4 pi over pi, and the part of the edge among those that are on its line.
        let weight = 4.0 * weight * edge.length / faces.len() as f64;
        let change = |channel: usize| across * (weight * importance[channel] * (behind[channel] - ahead[channel]));
        self.add_edge((edge, part), Some(receiver), change, sum);
    }

    /// Adds a ray from a place of a face: as light that comes to it, and as light that it sends.
    fn add_ray(&self, face: usize, [place, other, height, turn]: [f64; 4], weight: f64, sum: &mut impl Sum) {
        let (leaf, at) = self.place_on(face, [place, other]);
        let normal = self.planes[face].normal;
        let toward = in_hemisphere(normal, height, turn);
        let Some(met) = self.first_met(at, toward, &[face]) else { return };
        let own = Place { face, at };
        let area = self.leaves[face].last().map_or(0.0, |(_, area)| *area);
        // 2 pi over pi.
        let weight = 2.0 * weight * area;
        if let (Some(importance), Some(light)) = (self.importance(own), self.radiosity(met)) {
            for (channel, (a, b)) in importance.iter().zip(&light).enumerate() {
                self.add_slopes(face, toward, channel, -weight * a * b, sum);
            }
        }
        if let Some(importance) = self.importance(met) {
            for (channel, a) in importance.iter().enumerate() {
                let slope = self.solution.gradient_on(leaf, channel, self.solution.element(leaf).reference(at));
                let receiver = self.planes[met.face].normal;
                let by_source = weight * a * slope.dot(toward);
                self.add_heights(face, at, channel, by_source, sum);
                let by_receiver = weight * a * slope.dot(receiver) * toward.dot(normal) - by_source * receiver.dot(normal);
                self.add_heights(met.face, met.at, channel, by_receiver, sum);
            }
        }
    }

    /// Adds a place of an edge as a point sees it, the place being even in angle.
    fn add_sight(&self, Viewpoint { station, weights }: &Viewpoint, edge: &Edge, part: f64, weight: f64, sum: &mut impl Sum) {
        let arm = edge.from - station.point;
        let foot = arm.dot(edge.direction);
        let distance = (arm - edge.direction * foot).length();
        let [low, high] = [foot, foot + edge.length].map(|along| libm::atan2(along, distance));
        let angle = low + (high - low) * part;
        let part = (distance * libm::tan(angle) - foot) / edge.length;
        let at = edge.place(part);
        let range = (at - station.point).length();
        let toward = (at - station.point) / range;
        let across = edge.direction.cross(toward).normalize_or_zero();
        let cosine = station.normal.dot(toward);
        if cosine <= 0.0 || across == DVec3::ZERO {
            return;
        }
        let (extent, mesh) = (self.solution.system.extent, &self.solution.system.mesh);
        let aside = across * (BESIDE * extent);
        let [ahead, behind] =
            [aside, -aside].map(|aside| self.seen(station.point, at + aside - station.point, station.face.as_slice()));
        if ahead == behind {
            return;
        }
        let joint = edge.joint(mesh, part, extent);
        let weight = weight * (high - low) * cosine / (PI * range * joint.faces.len() as f64);
        let change = |channel: usize| across * (weight * weights[channel] * (behind[channel] - ahead[channel]));
        let receiver = station.face.map(|face| Place { face, at: station.point });
        self.add_edge((edge, part), receiver, change, sum);
    }

    /// Adds a direction from a point, and a place that it may see: the slopes of sources are sampled by both, each where it is likelier
    /// (E. Veach and L. Guibas 1995).
    fn add_surroundings(&self, point: &Viewpoint, [a, b, c, d]: [f64; 4], weight: f64, sum: &mut impl Sum) {
        let station = &point.station;
        let toward = in_hemisphere(station.normal, a, b);
        if let Some(met) = self.first_met(station.point, toward, station.face.as_slice())
            && let Some(leaf) = self.leaf(met)
        {
            if let (Some(face), Some(light)) = (station.face, self.radiosity(met)) {
                for (channel, b) in light.iter().enumerate() {
                    self.add_slopes(face, toward, channel, -2.0 * weight * point.weights[channel] * b, sum);
                }
            }
            self.add_slide(point, (leaf, met), weight, sum);
        }
        let Some((_, area)) = self.areas.last() else { return };
        let chosen = self.areas.partition_point(|(_, upto)| *upto < c * area).min(self.areas.len() - 1);
        let (face, upto) = self.areas[chosen];
        let before = if chosen == 0 { 0.0 } else { self.areas[chosen - 1].1 };
        let (leaf, at) = self.place_on(face, [((c * area - before) / (upto - before)).clamp(0.0, 1.0), d]);
        let toward = at - station.point;
        let is_above = toward.dot(station.normal) > 0.0 && toward.dot(self.planes[face].normal) < 0.0 && station.face != Some(face);
        if is_above && self.first_met(station.point, toward, station.face.as_slice()).is_some_and(|met| met.face == face) {
            self.add_slide(point, (leaf, Place { face, at }), weight, sum);
        }
    }

    /// Adds the slide of what a point sees there, as one of a direction and a place.
    fn add_slide(&self, Viewpoint { station, weights }: &Viewpoint, (leaf, seen): (usize, Place), weight: f64, sum: &mut impl Sum) {
        let arm = seen.at - station.point;
        let range = arm.length();
        let toward = arm / range;
        let normal = self.planes[seen.face].normal;
        let cosines = [station.normal.dot(toward), -normal.dot(toward)];
        let area = self.areas.last().map_or(0.0, |(_, area)| *area);
        // Densities by area: of directions, and of places.
        let density = cosines[1] / (2.0 * PI * range * range) + 1.0 / area;
        let weight = weight * cosines[0] / (PI * range * range * density);
        for (channel, point) in weights.iter().enumerate() {
            let slope = self.solution.gradient_on(leaf, channel, self.solution.element(leaf).reference(seen.at));
            let along = weight * point * slope.dot(toward);
            self.add_heights(seen.face, seen.at, channel, -along, sum);
            if let Some(face) = station.face {
                let by_receiver = weight * point * slope.dot(station.normal) * cosines[1] + along * station.normal.dot(normal);
                self.add_heights(face, station.point, channel, by_receiver, sum);
            }
        }
    }

    /// The place of a face at a place of the unit square, evenly by area.
    fn place_on(&self, face: usize, [a, b]: [f64; 2]) -> (usize, DVec3) {
        let leaves = &self.leaves[face];
        let area = leaves.last().map_or(0.0, |(_, area)| *area);
        let chosen = leaves.partition_point(|(_, upto)| *upto < a * area).min(leaves.len() - 1);
        let (leaf, upto) = leaves[chosen];
        let before = if chosen == 0 { 0.0 } else { leaves[chosen - 1].1 };
        let element = self.solution.element(leaf);
        let a = ((a * area - before) / (upto - before)).clamp(0.0, 1.0);
        let reference = match element.shape() {
            Shape::Parallelogram => [a, b],
            Shape::Triangle => [1.0 - a.sqrt(), b * a.sqrt()],
        };
        (leaf, element.point(reference))
    }
}

/// The direction at a place of the unit square, evenly.
fn on_sphere(height: f64, turn: f64) -> DVec3 {
    let height = 2.0 * height - 1.0;
    let (sine, cosine) = libm::sincos(2.0 * PI * turn);
    let radius = largest(1.0 - height * height, 0.0).sqrt();
    DVec3::new(radius * cosine, radius * sine, height)
}

/// The direction above a plane at a place of the unit square, evenly.
fn in_hemisphere(normal: DVec3, height: f64, turn: f64) -> DVec3 {
    let (u, v) = normal.any_orthonormal_pair();
    let DVec3 { x, y, z } = on_sphere(0.5 + 0.5 * height, turn);
    u * x + v * y + normal * z
}
