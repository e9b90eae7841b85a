//! Integrals over lines through edges, and over rays from faces, whose sums are the derivatives by vertices.
//!
//! Places of a face move with it, and the polynomials with them. The irradiance of a place x that moves by v has the derivative
//!
//! ```text
//! 1/pi int over the borders seen from x: (B_behind - B_ahead) (n1.w) q.m/r sin(t, w) dl     q = V(y) - v
//!   + 1/pi int (n1.w) grad B . s dw                       s = w (q.n2)/(w.n2) - q
//!   - 1/pi int B (grad h1 . w) dw                         h1 = n1.v
//! ```
//!
//! with w the direction from x to y, t that of the border and m that across both: borders of faces and of elements sweep what is beside
//! them over what is behind, places of an element slide as they are seen, and the horizon turns. Weighed by the importance `a = rho I`
//! and integrated over x the first is an integral over lines through places of borders,
//!
//! ```text
//! 1/pi int dl int dw a(x) (B_behind - B_ahead) q.(t x w)
//! ```
//!
//! and the second one over rays from y, as `(n1.w) dA1 dw = -(n2.w) dA2 dw`: no distance is left in them, so that samples of them are
//! bounded however near faces are. Together they are the derivative of the discrete light, whose error counts in the mean alone. Where an
//! edge stands on a face the line ends there at once: what the edge covers loses its light.
//!
//! Few directions meet a lamp, and those count most: what lamps emit, if they are not near, is sampled by places of them instead.

use std::f64::consts::PI;

use radgrad_core::DVec3;
use radgrad_scene::largest;
use smallvec::SmallVec;

use crate::field::Field;
use crate::links::station::Station;
use crate::mesh::shape::Shape;
use crate::solve::derivative::outline::{Edge, JOINED, Joint, Plane};
use crate::solve::solution::Solution;

/// How far beside an edge it is looked for what is ahead of it and behind it, over the extent of the scene.
const BESIDE: f64 = 1e-7;

/// Places of an edge at which it is looked for a face that it stands on.
const PARTS: usize = 8;

/// Distances from a lamp's centre up to which it is near, over its radius.
const NEAR: f64 = 1.5;

/// A value in each channel.
type Light = SmallVec<[f64; 4]>;

/// A point of the sum.
pub(super) struct Viewpoint {
    pub(super) station: Station,
    /// Its weight times its reflectance, in each channel.
    pub(super) weights: Vec<f64>,
}

/// A side of an element that is not one of its face.
#[derive(Clone, Copy)]
struct Side {
    leaf: usize,
    from: DVec3,
    /// As long as it.
    along: DVec3,
}

/// A domain of integration, mapped to by the unit cube.
#[derive(Debug, Clone, Copy)]
pub(super) enum Domain {
    /// Lines through an edge.
    Lines(usize),
    /// Lines through an edge to lamps.
    Shadows(usize),
    /// Rays from a face.
    Rays(usize),
    /// Rays from a face to lamps.
    LampRays(usize),
    /// Rays from a face to the edges of lamps.
    LampEdges(usize),
    /// Rays from the borders of a face's elements.
    Borders(usize),
    /// The edge, as a point sees it.
    Sight { point: usize, edge: usize },
    /// The borders of elements, as a point sees them.
    BorderSight(usize),
    /// All that a point sees.
    Surroundings(usize),
}

/// What is integrated.
pub(super) struct Integrands<'a> {
    solution: &'a Solution,
    importance: &'a Field,
    pub(super) points: Vec<Viewpoint>,
    pub(super) edges: Vec<Edge>,
    pub(super) planes: Vec<Plane>,
    /// The first vertex of each face among those of all.
    first_vertices: Vec<usize>,
    /// The leaves of each face, each with the area of those before it and its own.
    leaves: Vec<Vec<(usize, f64)>>,
    /// The faces that exchange light, each with the area of those before it and its own.
    areas: Vec<(usize, f64)>,
    /// The sides of elements of each face, each with the length of those before it and its own.
    sides: Vec<Vec<(Side, f64)>>,
    /// Of each point the sides of all elements, each with the size at which it is seen of those before it and its own.
    seen_sides: Vec<Vec<(Side, f64)>>,
    /// The lamps, each with the power of those before it and its own.
    lamps: Vec<(Lamp, f64)>,
    lamp_on_face: Vec<Option<usize>>,
    /// The edges of lamps, each with the length times the emission of those before it and its own.
    lamp_edges: Vec<(usize, f64)>,
}

/// A face that emits evenly.
struct Lamp {
    face: usize,
    centre: DVec3,
    radius: f64,
}

/// A place of a face.
#[derive(Clone, Copy)]
pub(super) struct Place {
    pub(super) face: usize,
    pub(super) at: DVec3,
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
        let (mut lamps, mut lamp_on_face): (Vec<(Lamp, f64)>, _) = (Vec::new(), vec![None; leaves.len()]);
        let surfaces = &solution.system.surfaces;
        for (face, polygon) in mesh.polygons().iter().enumerate().filter(|(face, _)| !leaves[*face].is_empty()) {
            let power = polygon.area() * surfaces.emitted[face].iter().sum::<f64>();
            if power > 0.0 && !surfaces.glows_by_texture(face) {
                let centre = polygon.vertices().iter().sum::<DVec3>() / polygon.vertices().len() as f64;
                let radius = polygon.vertices().iter().map(|vertex| (*vertex - centre).length()).fold(0.0, largest);
                lamp_on_face[face] = Some(lamps.len());
                lamps.push((Lamp { face, centre, radius }, lamps.last().map_or(0.0, |(_, upto)| *upto) + power));
            }
        }
        let planes = mesh.polygons().iter().map(Plane::from_polygon).collect();
        let edges = Edge::of_mesh(mesh, solution.system.extent);
        let (sides, seen_sides) = (Vec::new(), Vec::new());
        let lamp_edges = (0..edges.len()).filter(|edge| lamp_on_face[edges[*edge].face].is_some());
        let size = |edge: &usize| edges[*edge].length * surfaces.emitted[edges[*edge].face].iter().sum::<f64>();
        let lamp_edges = summed(lamp_edges, size);
        let mut integrands = Self {
            solution,
            importance,
            points,
            edges,
            planes,
            first_vertices,
            leaves,
            areas,
            sides,
            seen_sides,
            lamps,
            lamp_on_face,
            lamp_edges,
        };
        let sides_of = |leaves: &Vec<(usize, f64)>| -> Vec<Side> {
            leaves.iter().flat_map(|(leaf, _)| integrands.sides_of(*leaf)).collect()
        };
        let sides: Vec<Vec<Side>> = integrands.leaves.iter().map(sides_of).collect();
        integrands.seen_sides = integrands
            .points
            .iter()
            .map(|Viewpoint { station, .. }| {
                let size = |side: &Side| {
                    let arm = side.from + 0.5 * side.along - station.point;
                    let is_above = [0.0, 1.0].into_iter().any(|part| station.normal.dot(arm + (part - 0.5) * side.along) > 0.0);
                    let length = side.along.length();
                    if is_above { length / largest(arm.length(), length).powi(2) } else { 0.0 }
                };
                summed(sides.iter().flatten().copied().filter(|side| size(side) > 0.0), size)
            })
            .collect();
        integrands.sides = sides.into_iter().map(|sides| summed(sides.into_iter(), |side| side.along.length())).collect();
        integrands
    }

    /// Whether an edge stands on a face, of which its motion covers a part.
    pub(super) fn stands(&self, edge: &Edge) -> bool {
        let (mesh, extent) = (&self.solution.system.mesh, self.solution.system.extent);
        (0..PARTS).any(|part| !edge.joint(mesh, (part as f64 + 0.5) / PARTS as f64, extent).touched.is_empty())
    }

    /// The sides of a leaf beyond which its face goes on.
    fn sides_of(&self, leaf: usize) -> Vec<Side> {
        let element = self.solution.element(leaf);
        let corners = element.polygon().vertices();
        let side = |first: usize| {
            let along = corners[(first + 1) % corners.len()] - corners[first];
            let side = Side { leaf, from: corners[first], along };
            self.beyond(&side, 0.5).is_some().then_some(side)
        };
        (0..corners.len()).filter_map(side).collect()
    }

    /// From a place of a side to one beyond it.
    fn beside(&self, side: &Side, normal: DVec3) -> DVec3 {
        side.along.cross(normal).normalize_or_zero() * (BESIDE * self.solution.system.extent)
    }

    /// The leaf beyond a place of a side.
    fn beyond(&self, side: &Side, part: f64) -> Option<usize> {
        let element = self.solution.element(side.leaf);
        let at = side.from + side.along * part + self.beside(side, element.polygon().normal());
        let beyond = self.solution.system.mesh.leaf_at(element.face(), at)?;
        let other = self.solution.element(beyond);
        (beyond != side.leaf && other.excess(other.reference(at)) <= 0.0).then_some(beyond)
    }

    /// All domains.
    pub(super) fn domains(&self) -> Vec<Domain> {
        let of_edge = |edge: usize| [Domain::Lines(edge), Domain::Shadows(edge)];
        let mut domains: Vec<Domain> = (0..self.edges.len()).flat_map(of_edge).collect();
        let of_face = |face: usize| [Domain::Rays(face), Domain::LampRays(face), Domain::LampEdges(face), Domain::Borders(face)];
        domains.extend(self.areas.iter().flat_map(|&(face, _)| of_face(face)));
        for (point, Viewpoint { station, .. }) in self.points.iter().enumerate() {
            let is_above = |edge: &usize| {
                let edge = &self.edges[*edge];
                [0.0, 1.0].into_iter().any(|part| station.normal.dot(edge.place(part) - station.point) > 0.0)
            };
            domains.extend((0..self.edges.len()).filter(is_above).map(|edge| Domain::Sight { point, edge }));
            domains.extend([Domain::BorderSight(point), Domain::Surroundings(point)]);
        }
        domains
    }

    /// The face whose edge, or place, is sampled; none of all around a point.
    pub(super) fn face_of(&self, domain: Domain) -> Option<usize> {
        match domain {
            Domain::Lines(edge) | Domain::Shadows(edge) | Domain::Sight { edge, .. } => Some(self.edges[edge].face),
            Domain::Rays(face) | Domain::LampRays(face) | Domain::LampEdges(face) | Domain::Borders(face) => Some(face),
            Domain::BorderSight(_) | Domain::Surroundings(_) => None,
        }
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
            Domain::Shadows(edge) => self.add_shadow(&self.edges[edge], unit, weight, sum),
            Domain::Rays(face) => self.add_ray(face, unit, weight, sum),
            Domain::LampRays(face) => self.add_lamp_ray(face, unit, weight, sum),
            Domain::LampEdges(face) => self.add_lamp_edge(face, unit, weight, sum),
            Domain::Borders(face) => self.add_border(face, unit, weight, sum),
            Domain::BorderSight(point) => self.add_border_sight(point, unit[0], weight, sum),
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

    /// The importance of a place at the foot of faces, but for what it has by their being lit from there: they move along, and what they
    /// cover was not in front of them.
    fn importance_at_contact(&self, foot: Place, at: DVec3, standing: &[usize]) -> Option<Light> {
        let mut importance = self.importance(foot)?;
        let rho = &self.solution.system.surfaces.reflectance_and_emission(foot.face, at)[0];
        for &face in standing.iter().filter(|face| self.planes[**face].normal.dot((foot.at - at).normalize_or_zero()) > JOINED) {
            // So much of the view, up to the foot, is the face's.
            let part = 0.5 * (1.0 - self.planes[face].normal.dot(self.planes[foot.face].normal));
            if let Some(own) = self.importance(Place { face, at }) {
                importance.iter_mut().zip(rho).zip(&own).for_each(|((a, rho), own)| *a -= rho * part * own);
            }
        }
        Some(importance)
    }

    fn radiosity(&self, place: Place) -> Option<Light> {
        let leaf = self.leaf(place)?;
        let mut light = self.value(leaf, place.at, |channel| self.solution.radiosity.field.coefficients(leaf, channel));
        light.iter_mut().enumerate().for_each(|(channel, b)| *b += self.solution.lamp_on(place.face, channel));
        Some(light)
    }

    /// No light.
    fn dark(&self) -> Light {
        SmallVec::from_elem(0.0, self.solution.channels().len())
    }

    /// The radiosity that a ray meets: none where it meets a back, or nothing.
    fn seen(&self, from: DVec3, toward: DVec3, leave_out: &[usize]) -> Light {
        let met = self.first_met(from, toward, leave_out).and_then(|place| self.radiosity(place));
        met.unwrap_or_else(|| self.dark())
    }

    /// Whether a face is a lamp whose emission on a place is sampled by places of it.
    fn is_sampled(&self, lamp: usize, place: DVec3) -> bool {
        let Lamp { centre, radius, .. } = self.lamps[lamp].0;
        (place - centre).length() > NEAR * radius
    }

    /// The radiosity without the emission on a place that is sampled otherwise.
    fn unsampled_radiosity(&self, met: Place, place: DVec3) -> Option<Light> {
        let mut light = self.radiosity(met)?;
        if self.lamp_on_face[met.face].is_some_and(|lamp| self.is_sampled(lamp, place)) {
            let emitted = &self.solution.system.surfaces.emitted[met.face];
            light.iter_mut().zip(emitted).for_each(|(light, emitted)| *light -= emitted);
        }
        Some(light)
    }

    /// The emission of a lamp, where a ray meets it.
    fn emission_seen(&self, lamp: usize, from: DVec3, toward: DVec3, leave_out: &[usize]) -> Light {
        let is_seen = self.first_met(from, toward, leave_out).is_some_and(|met| met.face == lamp);
        if is_seen { self.solution.system.surfaces.emitted[lamp].iter().copied().collect() } else { self.dark() }
    }

    /// A place of a lamp that is seen from another place under an angle, and the angle over the density of the choice; none where its
    /// emission is not sampled so.
    fn lamp_place(&self, from: DVec3, [a, b]: [f64; 2]) -> Option<(Place, f64)> {
        let (_, whole) = self.lamps.last()?;
        let (lamp, a, part) = chosen(&self.lamps, a);
        let face = self.lamps[lamp].0.face;
        let (_, at) = self.place_on(face, [a, b]);
        let arm = at - from;
        let cosine = -arm.dot(self.planes[face].normal) / arm.length();
        if cosine <= 0.0 || !self.is_sampled(lamp, from) {
            return None;
        }
        let area = self.leaves[face].last().map_or(0.0, |(_, area)| *area);
        Some((Place { face, at }, cosine * area / arm.length_squared() * whole / part))
    }

    /// Adds the change by an edge's motion.
    pub(super) fn add_edge(&self, (edge, part): (&Edge, f64), channel: usize, change: DVec3, sum: &mut impl Sum) {
        for (end, hat) in edge.ends.into_iter().zip([1.0 - part, part]) {
            sum.add(self.vertex(edge.face, end), channel, change * hat);
        }
    }

    /// Adds a change by the motion of a place of a face.
    pub(super) fn add_place(&self, Place { face, at }: Place, channel: usize, change: DVec3, sum: &mut impl Sum) {
        for (vertex, (hat, _)) in self.planes[face].parts(at).enumerate() {
            sum.add(self.vertex(face, vertex), channel, change * hat);
        }
    }

    /// Adds a change by the motion of a point, which follows the plane of its face along the normal.
    fn add_station(&self, station: &Station, channel: usize, change: DVec3, sum: &mut impl Sum) {
        if let Some(face) = station.face {
            self.add_place(Place { face, at: station.point }, channel, change.project_onto_normalized(station.normal), sum);
        }
    }

    /// Adds a change by the slope of a face's height along a direction.
    fn add_slopes(&self, face: usize, along: DVec3, channel: usize, change: f64, sum: &mut impl Sum) {
        let plane = &self.planes[face];
        for (vertex, slope) in plane.slopes().iter().enumerate() {
            sum.add(self.vertex(face, vertex), channel, plane.normal * (change * slope.dot(along)));
        }
    }

    /// Adds a line through an edge in any direction.
    fn add_line(&self, edge: &Edge, [part, height, turn, _]: [f64; 4], weight: f64, sum: &mut impl Sum) {
        let at = edge.place(part);
        let light = |from: DVec3, toward: DVec3, leave_out: &[usize], joined: &[usize]| {
            // Of a lamp's own edge it is the place that receives which is near or not.
            let seen = |met: Place| self.unsampled_radiosity(met, if joined.contains(&met.face) { from } else { at });
            self.first_met(from, toward, leave_out).and_then(seen).unwrap_or_else(|| self.dark())
        };
        self.add_through((edge, part), on_sphere(height, turn), 4.0 * PI * weight, light, sum);
    }

    /// Adds a line through an edge to a lamp, by what that emits.
    fn add_shadow(&self, edge: &Edge, [part, a, b, _]: [f64; 4], weight: f64, sum: &mut impl Sum) {
        let from = edge.place(part);
        let Some((Place { face, at }, angle)) = self.lamp_place(from, [a, b]) else { return };
        let light =
            |from: DVec3, toward: DVec3, leave_out: &[usize], _: &[usize]| self.emission_seen(face, from, toward, leave_out);
        self.add_through((edge, part), (at - from).normalize_or_zero(), angle * weight, light, sum);
    }

    /// Adds a line through an edge: from the place that receives the light, past the edge, to what is on either side of it.
    fn add_through(
        &self,
        (edge, part): (&Edge, f64),
        toward: DVec3,
        weight: f64,
        light: impl Fn(DVec3, DVec3, &[usize], &[usize]) -> Light,
        sum: &mut impl Sum,
    ) {
        let (extent, mesh, at) = (self.solution.system.extent, &self.solution.system.mesh, edge.place(part));
        let across = edge.direction.cross(toward);
        let aside = across.normalize_or_zero() * (BESIDE * extent);
        let Joint { faces, mut touched } = edge.joint(mesh, part, extent);
        let covered = touched.iter().copied().find(|face| self.planes[*face].normal.dot(toward) > 0.0);
        // Of either side, the light that arrives times the importance of the place where it does.
        let (receiver, sides) = if let Some(face) = covered {
            let normal = self.planes[face].normal;
            let side = |aside: DVec3| {
                let height = aside.dot(normal);
                let foot = at + aside - toward * (height / normal.dot(toward));
                let importance = self.importance_at_contact(Place { face, at: foot }, at, &faces)?;
                Some((importance, light(if height > 0.0 { at + aside } else { foot }, toward, &[face], &faces)))
            };
            (Place { face, at }, [side(aside), side(-aside)])
        } else {
            touched.extend(&faces);
            let Some(receiver) = self.first_met(at, -toward, &touched) else { return };
            let Some(importance) = self.importance(receiver) else { return };
            let side = |aside: DVec3| {
                let arm = at + aside - receiver.at;
                Some((importance.clone(), light(receiver.at, arm, &[receiver.face], &faces)))
            };
            (receiver, [side(aside), side(-aside)])
        };
        let weight = weight * edge.length / (PI * faces.len() as f64);
        let arrives = |side: &Option<(Light, Light)>, channel: usize| side.as_ref().map_or(0.0, |(a, b)| a[channel] * b[channel]);
        for channel in 0..self.solution.channels().len() {
            let change = across * (weight * (arrives(&sides[1], channel) - arrives(&sides[0], channel)));
            if change != DVec3::ZERO {
                self.add_edge((edge, part), channel, change, sum);
                self.add_place(receiver, channel, -change, sum);
            }
        }
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
        if let (Some(importance), Some(light)) = (self.importance(own), self.unsampled_radiosity(met, at)) {
            for (channel, (a, b)) in importance.iter().zip(&light).enumerate() {
                self.add_slopes(face, toward, channel, -weight * a * b, sum);
            }
        }
        if let Some(importance) = self.importance(met) {
            for (channel, a) in importance.iter().enumerate() {
                let slope = self.solution.gradient_on(leaf, channel, self.solution.element(leaf).reference(at));
                let change = weight * a * (slope.dot(toward) * normal - toward.dot(normal) * slope);
                self.add_place(own, channel, change, sum);
                self.add_place(met, channel, -change, sum);
            }
        }
    }

    /// Adds a ray from a border of elements, by the step of the polynomials there.
    fn add_border(&self, face: usize, [part, height, turn, _]: [f64; 4], weight: f64, sum: &mut impl Sum) {
        let Some((_, length)) = self.sides[face].last() else { return };
        let (index, part, _) = chosen(&self.sides[face], part);
        let normal = self.planes[face].normal;
        let side = &self.sides[face][index].0;
        let (own, along, step) = self.step(side, part);
        let toward = in_hemisphere(normal, height, turn);
        let Some(met) = self.first_met(own.at, toward, &[face]) else { return };
        // Where a face stands on the border, it is that face's edge.
        let aside = self.beside(side, normal);
        if [aside, -aside].into_iter().any(|aside| self.first_met(own.at + aside, toward, &[face]).is_none()) {
            return;
        }
        let Some(importance) = self.importance(met) else { return };
        for (channel, (a, step)) in importance.iter().zip(&step).enumerate() {
            // 2 pi over pi.
            let change = along.cross(-toward) * (2.0 * weight * length * a * step);
            self.add_place(own, channel, change, sum);
            self.add_place(met, channel, -change, sum);
        }
    }

    /// A place of a side, the side's direction, and half the step to the polynomial beyond, as each side is one of two.
    fn step(&self, side: &Side, part: f64) -> (Place, DVec3, Light) {
        let at = side.from + side.along * part;
        let own = Place { face: self.solution.element(side.leaf).face(), at };
        let value = |leaf: usize| self.value(leaf, at, |channel| self.solution.radiosity.field.coefficients(leaf, channel));
        let mut step = value(side.leaf);
        let beyond = self.beyond(side, part).map_or_else(|| step.clone(), value);
        step.iter_mut().zip(beyond).for_each(|(step, beyond)| *step = 0.5 * (beyond - *step));
        (own, side.along.normalize_or_zero(), step)
    }

    /// Adds a ray from a place of a face to a lamp, as light that comes to it.
    fn add_lamp_ray(&self, face: usize, [place, other, a, b]: [f64; 4], weight: f64, sum: &mut impl Sum) {
        let (_, at) = self.place_on(face, [place, other]);
        let Some(importance) = self.importance(Place { face, at }) else { return };
        let area = self.leaves[face].last().map_or(0.0, |(_, area)| *area);
        let station = Station { point: at, normal: self.planes[face].normal, face: Some(face) };
        self.add_lamp(&station, &importance, [a, b], weight * area, sum);
    }

    /// Adds a ray from a place of a face to an edge of a lamp, by what that emits.
    fn add_lamp_edge(&self, face: usize, [place, other, along, _]: [f64; 4], weight: f64, sum: &mut impl Sum) {
        let Some((_, whole)) = self.lamp_edges.last() else { return };
        let (index, part, own) = chosen(&self.lamp_edges, along);
        let edge = &self.edges[self.lamp_edges[index].0];
        let (_, from) = self.place_on(face, [place, other]);
        let arm = edge.place(part) - from;
        let toward = arm.normalize_or_zero();
        let cosine = toward.dot(self.planes[face].normal);
        if cosine <= 0.0 || edge.face == face || !self.lamp_on_face[edge.face].is_some_and(|lamp| self.is_sampled(lamp, from)) {
            return;
        }
        let Some(importance) = self.importance(Place { face, at: from }) else { return };
        let across = edge.direction.cross(toward);
        let aside = across.normalize_or_zero() * (BESIDE * self.solution.system.extent);
        let [ahead, behind] = [aside, -aside].map(|aside| self.emission_seen(edge.face, from, arm + aside, &[face]));
        let area = self.leaves[face].last().map_or(0.0, |(_, area)| *area);
        let weight = weight * area * edge.length * whole / own * cosine / (PI * arm.length_squared());
        for (channel, a) in importance.iter().enumerate() {
            // The emission counts for this edge alone, as other faces with edges there do not have it.
            let change = across * (weight * a * (behind[channel] - ahead[channel]));
            self.add_edge((edge, part), channel, change, sum);
            self.add_place(Place { face, at: from }, channel, -change, sum);
        }
    }

    /// Adds a lamp's light on a place of a face, as the face turns.
    fn add_lamp(&self, station: &Station, weights: &[f64], unit: [f64; 2], weight: f64, sum: &mut impl Sum) {
        let Some((lamp, angle)) = self.lamp_place(station.point, unit) else { return };
        let toward = (lamp.at - station.point).normalize_or_zero();
        let Some(face) = station.face.filter(|_| toward.dot(station.normal) > 0.0) else { return };
        if self.first_met(station.point, toward, &[face]).is_some_and(|met| met.face == lamp.face) {
            for (channel, emitted) in self.solution.system.surfaces.emitted[lamp.face].iter().enumerate() {
                self.add_slopes(face, toward, channel, -weight * angle / PI * weights[channel] * emitted, sum);
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
        for (channel, point) in weights.iter().enumerate() {
            let change = across * (weight * point * (behind[channel] - ahead[channel]));
            self.add_edge((edge, part), channel, change, sum);
            self.add_station(station, channel, -change, sum);
        }
    }

    /// Adds a place of a border of elements as a point sees it, by the step of the polynomials there.
    fn add_border_sight(&self, point: usize, place: f64, weight: f64, sum: &mut impl Sum) {
        let Viewpoint { station, weights } = &self.points[point];
        let sides = &self.seen_sides[point];
        let Some((_, whole)) = sides.last() else { return };
        let (index, part, own) = chosen(sides, place);
        let side = &sides[index].0;
        let (seen, along, step) = self.step(side, part);
        let arm = seen.at - station.point;
        let toward = arm.normalize_or_zero();
        let cosine = station.normal.dot(toward);
        let normal = self.planes[seen.face].normal;
        let is_above = cosine > 0.0 && toward.dot(normal) < 0.0;
        let aside = self.beside(side, normal);
        let is_hidden = |aside: DVec3| {
            let met = self.first_met(station.point, arm + aside, station.face.as_slice());
            met.is_none_or(|met| met.face != seen.face)
        };
        if !is_above || is_hidden(aside) || is_hidden(-aside) {
            return;
        }
        let weight = weight * side.along.length() * whole / own * cosine / (PI * arm.length_squared());
        for (channel, (point, step)) in weights.iter().zip(&step).enumerate() {
            let change = along.cross(toward) * (weight * point * step);
            self.add_place(seen, channel, change, sum);
            self.add_station(station, channel, -change, sum);
        }
    }

    /// Adds a direction from a point, and a place that it may see: the slopes of sources are sampled by both, each where it is likelier
    /// (E. Veach and L. Guibas 1995).
    fn add_surroundings(&self, point: &Viewpoint, [a, b, c, d]: [f64; 4], weight: f64, sum: &mut impl Sum) {
        let station = &point.station;
        let toward = in_hemisphere(station.normal, a, b);
        if let Some(met) = self.first_met(station.point, toward, station.face.as_slice())
            && let Some(leaf) = self.leaf(met)
        {
            if let (Some(face), Some(light)) = (station.face, self.unsampled_radiosity(met, station.point)) {
                for (channel, b) in light.iter().enumerate() {
                    self.add_slopes(face, toward, channel, -2.0 * weight * point.weights[channel] * b, sum);
                }
            }
            self.add_slide(point, (leaf, met), weight, sum);
        }
        self.add_lamp(station, &point.weights, [c, d], weight, sum);
        let (place, c, _) = chosen(&self.areas, c);
        let face = self.areas[place].0;
        let (leaf, at) = self.place_on(face, [c, d]);
        let toward = at - station.point;
        let is_above =
            toward.dot(station.normal) > 0.0 && toward.dot(self.planes[face].normal) < 0.0 && station.face != Some(face);
        if is_above && self.first_met(station.point, toward, station.face.as_slice()).is_some_and(|met| met.face == face) {
            self.add_slide(point, (leaf, Place { face, at }), weight, sum);
        }
    }

    /// Adds the slide of what a point sees there, as one of a direction and a place.
    fn add_slide(
        &self,
        Viewpoint { station, weights }: &Viewpoint,
        (leaf, seen): (usize, Place),
        weight: f64,
        sum: &mut impl Sum,
    ) {
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
            let change = -weight * point * (slope * cosines[1] + slope.dot(toward) * normal);
            self.add_place(seen, channel, change, sum);
            self.add_station(station, channel, -change, sum);
        }
    }

    /// The place of a face at a place of the unit square, evenly by area.
    fn place_on(&self, face: usize, [a, b]: [f64; 2]) -> (usize, DVec3) {
        let (place, a, _) = chosen(&self.leaves[face], a);
        let leaf = self.leaves[face][place].0;
        let element = self.solution.element(leaf);
        let reference = match element.shape() {
            Shape::Parallelogram => [a, b],
            Shape::Triangle => [1.0 - a.sqrt(), b * a.sqrt()],
        };
        (leaf, element.point(reference))
    }
}

/// A list in which each has the sum of the sizes up to it and its own.
fn summed<T>(list: impl Iterator<Item = T>, size: impl Fn(&T) -> f64) -> Vec<(T, f64)> {
    let mut upto = 0.0;
    let sum = |of: T| {
        upto += size(&of);
        (of, upto)
    };
    list.map(sum).collect()
}

/// One of a list in which each has the sum up to it and its own, in proportion to its own; where in it, and its own.
fn chosen<T>(sums: &[(T, f64)], at: f64) -> (usize, f64, f64) {
    let whole = sums.last().map_or(0.0, |(_, whole)| *whole);
    let place = sums.partition_point(|(_, upto)| *upto < at * whole).min(sums.len() - 1);
    let before = if place == 0 { 0.0 } else { sums[place - 1].1 };
    let own = sums[place].1 - before;
    (place, ((at * whole - before) / own).clamp(0.0, 1.0), own)
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
