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
//! edge stands on a face the line ends there at once: what the edge covers loses its light, which counts by the weight of the face itself.
//!
//! Few directions meet a lamp, and those count most: what lamps emit, if they are not near, is sampled by places of them instead.

use std::f64::consts::PI;

use radgrad_core::DVec3;
use radgrad_scene::largest;

use crate::links::station::Station;
use crate::solve::derivative::integrands::{BESIDE, Domain, Integrands, Light, Place, Side, Viewpoint, chosen};
use crate::solve::derivative::outline::{Edge, Joint};

/// A sum over vertices: of each that has a part, in a channel.
pub(super) trait Sum {
    fn add(&mut self, vertex: usize, channel: usize, change: DVec3);
}

impl Integrands<'_> {
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

    /// Adds a line through an edge to a lamp, by the emission of that.
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
            // Places that see this one lose it by the same motion, by lines from there.
            let Some(weights) = self.weight_itself(Place { face, at }) else { return };
            let side = |aside: DVec3| {
                let height = aside.dot(normal);
                let start = if height > 0.0 { at + aside } else { at + aside - toward * (height / normal.dot(toward)) };
                Some((weights.clone(), light(start, toward, &[face], &faces)))
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

    /// Adds a ray from a place of a face to an edge of a lamp, by the emission of that.
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
            [aside, -aside].map(|aside| self.light_from(station.point, at + aside - station.point, station.face.as_slice()));
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

    /// Adds the slide of the light that a point sees there, as one of a direction and a place.
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
