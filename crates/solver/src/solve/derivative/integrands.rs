//! Domains of the integrals of [`crate::solve::derivative::sampled`]: edges, elements and their borders, lamps, and the light at places.

use radgrad_core::DVec3;
use radgrad_scene::largest;
use smallvec::SmallVec;

use crate::field::Field;
use crate::links::station::Station;
use crate::mesh::shape::Shape;
use crate::solve::derivative::outline::{Edge, Plane};
use crate::solve::solution::Solution;

/// How far beside an edge rays pass it that meet the faces ahead of it and behind it, over the extent of the scene.
pub(super) const BESIDE: f64 = 1e-7;

/// Distances from a lamp's centre up to which it is near, over its radius.
const NEAR: f64 = 1.5;

/// A value in each channel.
pub(super) type Light = SmallVec<[f64; 4]>;

/// A point of the sum.
pub(super) struct Viewpoint {
    pub(super) station: Station,
    /// Its weight times its reflectance, in each channel.
    pub(super) weights: Vec<f64>,
}

/// A side of an element that is not one of its face.
#[derive(Clone, Copy)]
pub(super) struct Side {
    pub(super) leaf: usize,
    pub(super) from: DVec3,
    /// As long as it.
    pub(super) along: DVec3,
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

/// An integrand.
pub(super) struct Integrands<'a> {
    pub(super) solution: &'a Solution,
    pub(super) importance: &'a Field,
    /// Of each face the weight of its light by itself in the sum, over its area, in each channel.
    pub(super) densities: Vec<Vec<f64>>,
    pub(super) points: Vec<Viewpoint>,
    pub(super) edges: Vec<Edge>,
    pub(super) planes: Vec<Plane>,
    /// The first vertex of each face among those of all.
    pub(super) first_vertices: Vec<usize>,
    /// The leaves of each face, each with the area of those before it and its own.
    pub(super) leaves: Vec<Vec<(usize, f64)>>,
    /// The faces that exchange light, each with the area of those before it and its own.
    pub(super) areas: Vec<(usize, f64)>,
    /// The sides of elements of each face, each with the length of those before it and its own.
    pub(super) sides: Vec<Vec<(Side, f64)>>,
    /// Of each point the sides of all elements, each with the size at which it is seen of those before it and its own.
    pub(super) seen_sides: Vec<Vec<(Side, f64)>>,
    /// The lamps, each with the power of those before it and its own.
    pub(super) lamps: Vec<(Lamp, f64)>,
    pub(super) lamp_on_face: Vec<Option<usize>>,
    /// The edges of lamps, each with the length times the emission of those before it and its own.
    pub(super) lamp_edges: Vec<(usize, f64)>,
}

/// A face that emits evenly.
pub(super) struct Lamp {
    pub(super) face: usize,
    pub(super) centre: DVec3,
    pub(super) radius: f64,
}

/// A place of a face.
#[derive(Clone, Copy)]
pub(super) struct Place {
    pub(super) face: usize,
    pub(super) at: DVec3,
}

impl<'a> Integrands<'a> {
    pub(super) fn new(solution: &'a Solution, importance: &'a Field, densities: Vec<Vec<f64>>, points: Vec<Viewpoint>) -> Self {
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
            densities,
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

    /// The sides of a leaf beyond which its face goes on.
    pub(super) fn sides_of(&self, leaf: usize) -> Vec<Side> {
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
    pub(super) fn beside(&self, side: &Side, normal: DVec3) -> DVec3 {
        side.along.cross(normal).normalize_or_zero() * (BESIDE * self.solution.system.extent)
    }

    /// The leaf beyond a place of a side.
    pub(super) fn beyond(&self, side: &Side, part: f64) -> Option<usize> {
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

    pub(super) fn first_met(&self, from: DVec3, toward: DVec3, leave_out: &[usize]) -> Option<Place> {
        self.solution.system.mesh.front_met(from, toward, leave_out).map(|(face, at)| Place { face, at })
    }

    pub(super) fn leaf(&self, place: Place) -> Option<usize> {
        self.solution.system.mesh.leaf_at(place.face, place.at)
    }

    /// A light's polynomial on a leaf at a place.
    pub(super) fn value(&self, leaf: usize, at: DVec3, coefficients: impl Fn(usize) -> &'a [f64]) -> Light {
        let (basis, element) = (self.solution.basis(leaf), self.solution.element(leaf));
        let mut values: SmallVec<[f64; 32]> = SmallVec::from_elem(0.0, basis.len());
        basis.fill(element.reference(at), &mut values);
        let channels = 0..self.solution.channels().len();
        channels.map(|channel| coefficients(channel).iter().zip(&values).map(|(c, v)| c * v).sum()).collect()
    }

    pub(super) fn importance(&self, place: Place) -> Option<Light> {
        let leaf = self.leaf(place)?;
        let light = self.value(leaf, place.at, |channel| self.importance.coefficients(leaf, channel));
        light.iter().any(|a| *a != 0.0).then_some(light)
    }

    /// What a face's light counts for by itself, in the weights of the sum, times its reflectance; none if that is nothing.
    pub(super) fn weight_itself(&self, Place { face, at }: Place) -> Option<Light> {
        let [rho, _] = self.solution.system.surfaces.reflectance_and_emission(face, at);
        let weights: Light = rho.iter().zip(&self.densities[face]).map(|(rho, density)| rho * density).collect();
        weights.iter().any(|weight| *weight != 0.0).then_some(weights)
    }

    pub(super) fn radiosity(&self, place: Place) -> Option<Light> {
        let leaf = self.leaf(place)?;
        let mut light = self.value(leaf, place.at, |channel| self.solution.radiosity.field.coefficients(leaf, channel));
        light.iter_mut().enumerate().for_each(|(channel, b)| *b += self.solution.lamp_on(place.face, channel));
        Some(light)
    }

    /// No light.
    pub(super) fn dark(&self) -> Light {
        SmallVec::from_elem(0.0, self.solution.channels().len())
    }

    /// The radiosity that a ray meets: none where it meets a back, or nothing.
    pub(super) fn light_from(&self, from: DVec3, toward: DVec3, leave_out: &[usize]) -> Light {
        let met = self.first_met(from, toward, leave_out).and_then(|place| self.radiosity(place));
        met.unwrap_or_else(|| self.dark())
    }

    /// Whether a face is a lamp whose emission on a place is sampled by places of it.
    pub(super) fn is_sampled(&self, lamp: usize, place: DVec3) -> bool {
        let Lamp { centre, radius, .. } = self.lamps[lamp].0;
        (place - centre).length() > NEAR * radius
    }

    /// The radiosity without the emission on a place that is sampled otherwise.
    pub(super) fn unsampled_radiosity(&self, met: Place, place: DVec3) -> Option<Light> {
        let mut light = self.radiosity(met)?;
        if self.lamp_on_face[met.face].is_some_and(|lamp| self.is_sampled(lamp, place)) {
            let emitted = &self.solution.system.surfaces.emitted[met.face];
            light.iter_mut().zip(emitted).for_each(|(light, emitted)| *light -= emitted);
        }
        Some(light)
    }

    /// The emission of a lamp, where a ray meets it.
    pub(super) fn emission_seen(&self, lamp: usize, from: DVec3, toward: DVec3, leave_out: &[usize]) -> Light {
        let is_seen = self.first_met(from, toward, leave_out).is_some_and(|met| met.face == lamp);
        if is_seen { self.solution.system.surfaces.emitted[lamp].iter().copied().collect() } else { self.dark() }
    }

    /// A place of a lamp that is seen from another place under an angle, and the angle over the density of the choice; none where its
    /// emission is not sampled so.
    pub(super) fn lamp_place(&self, from: DVec3, [a, b]: [f64; 2]) -> Option<(Place, f64)> {
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

    /// The place of a face at a place of the unit square, evenly by area.
    pub(super) fn place_on(&self, face: usize, [a, b]: [f64; 2]) -> (usize, DVec3) {
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
pub(super) fn summed<T>(list: impl Iterator<Item = T>, size: impl Fn(&T) -> f64) -> Vec<(T, f64)> {
    let mut upto = 0.0;
    let sum = |of: T| {
        upto += size(&of);
        (of, upto)
    };
    list.map(sum).collect()
}

/// One of a list in which each has the sum up to it and its own, in proportion to its own; where in it, and its own.
pub(super) fn chosen<T>(sums: &[(T, f64)], at: f64) -> (usize, f64, f64) {
    let whole = sums.last().map_or(0.0, |(_, whole)| *whole);
    let place = sums.partition_point(|(_, upto)| *upto < at * whole).min(sums.len() - 1);
    let before = if place == 0 { 0.0 } else { sums[place - 1].1 };
    let own = sums[place].1 - before;
    (place, ((at * whole - before) / own).clamp(0.0, 1.0), own)
}
