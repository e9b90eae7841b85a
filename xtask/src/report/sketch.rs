//! A small picture of a case: the emitter from its lit side, aslant, and the receiver with its normal.
//!
//! Seen along parallel lines, the emitter's plane level and its lit side up; a receiver that is far away is drawn nearer, on
//! the same line, which is then dashed. A shape too thin to be seen is drawn as a line.

use std::fmt::Write;

use radgrad_audit::cases::family::Name;
use radgrad_core::{DVec3, Emitter, Polygon, Receiver};
use radgrad_scene::case::Problem;

use super::svg::{Svg, around, through};

const SIZE: (f64, f64) = (220.0, 130.0);
const MARGIN: f64 = 12.0;
/// Distances beyond, in sizes of the emitter, are drawn as this.
const FARTHEST: f64 = 1.5;
/// Length of the normal, in sizes.
const NORMAL: f64 = 0.4;

/// Geometry of a case in sizes of its emitter.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Geometry {
    emitter: Vec<DVec3>,
    occluders: Vec<Vec<DVec3>>,
    receiver: DVec3,
    normal: DVec3,
    /// From the middle of the emitter to the receiver.
    pub(super) distance: f64,
    /// Of the receiver over the emitter's plane.
    pub(super) height: f64,
    /// Length of the emitter, in the case's unit.
    pub(super) size: f64,
}

impl Geometry {
    /// Of a case; `None` if it is refused.
    pub(super) fn from_case(name: Name) -> Option<Self> {
        let Problem { receiver, emitter, occluders, .. } = name.case().problem().ok()?;
        Some(Self::of_scene(&receiver, &emitter, &occluders))
    }

    pub(super) fn of_scene(receiver: &Receiver, emitter: &Emitter, occluders: &[Polygon]) -> Self {
        let polygon = emitter.polygon();
        let vertices = polygon.vertices();
        // Differences first, then their size taken out: squares of them may leave the range of doubles.
        let offsets: Vec<DVec3> = vertices.iter().map(|v| *v - vertices[0]).collect();
        let reach = offsets.iter().fold(0.0, |m: f64, v| m.max(v.abs().max_element()));
        let within = |v: DVec3| (v - vertices[0]) / reach;
        let corners: Vec<DVec3> = offsets.iter().map(|v| *v / reach).collect();
        let apart = corners.iter().flat_map(|a| corners.iter().map(move |b| (*a - *b).length()));
        let longest = apart.fold(0.0, f64::max);
        let middle = corners.iter().sum::<DVec3>() / corners.len() as f64;
        let up = polygon.normal();
        let to_receiver = (within(receiver.position()) - middle) / longest;
        // The receiver is aside to the right: one axis is along its foot point, or any where it is right above.
        let level = to_receiver - up * up.dot(to_receiver);
        let x = if level.length() > 1e-3 * to_receiver.length() { level.normalize() } else { up.any_orthonormal_vector() };
        let y = up.cross(x);
        let in_frame = |v: DVec3| DVec3::new(v.dot(x), v.dot(y), v.dot(up));
        let placed = |v: &DVec3| in_frame((within(*v) - middle) / longest);
        Self {
            emitter: vertices.iter().map(placed).collect(),
            occluders: occluders.iter().map(|occluder| occluder.vertices().iter().map(placed).collect()).collect(),
            receiver: in_frame(to_receiver),
            normal: in_frame(receiver.normal()),
            distance: to_receiver.length(),
            height: up.dot(to_receiver),
            size: longest * reach,
        }
    }

    /// The picture.
    pub(super) fn draw(&self, title: &str) -> String {
        let is_far = self.distance > FARTHEST;
        let receiver = if is_far { self.receiver * (FARTHEST / self.distance) } else { self.receiver };
        let tip = receiver + self.normal * NORMAL;
        let shown: Vec<DVec3> = self.emitter.iter().chain([&receiver, &tip]).copied().collect();
        let view = View::onto(&shown);
        let mut svg = Svg::new(SIZE.0, SIZE.1);
        let outline: Vec<(f64, f64)> = self.emitter.iter().map(|v| view.place(*v)).collect();
        svg.path("lit", &around(&outline));
        for occluder in &self.occluders {
            // One at the emitter of a far receiver: near enough to be drawn as it is.
            let corners: Vec<(f64, f64)> = occluder.iter().map(|v| view.place(*v)).collect();
            svg.path("screen", &around(&corners));
        }
        let foot = view.place(DVec3::new(receiver.x, receiver.y, 0.0));
        svg.path("plumb", &through(&[view.place(receiver), foot]));
        svg.path(if is_far { "ray broken" } else { "ray" }, &through(&[view.place(receiver), view.place(DVec3::ZERO)]));
        svg.path("normal", &(through(&[view.place(receiver), view.place(tip)]) + &head(view.place(receiver), view.place(tip))));
        svg.circle("point", view.place(receiver), 3.0);
        let mut description = format!("{} corners, receiver {:.1e} sizes away", self.emitter.len(), self.distance);
        // Writing to a string cannot fail.
        let _ = write!(description, ", {:.1e} sizes over the emitter's plane", self.height);
        svg.finish("sketch", title, &description)
    }
}

/// The two strokes of an arrow head.
pub(super) fn head(tail: (f64, f64), tip: (f64, f64)) -> String {
    let (dx, dy) = (tip.0 - tail.0, tip.1 - tail.1);
    let length = (dx * dx + dy * dy).sqrt();
    if length < 1e-9 {
        return String::new();
    }
    let (ux, uy, size) = (dx / length, dy / length, (0.4 * length).min(5.0));
    let barb = |side: f64| (tip.0 - size * (ux + side * 0.5 * uy), tip.1 - size * (uy - side * 0.5 * ux));
    through(&[barb(1.0), tip, barb(-1.0)])
}

/// Where points of space stand in the picture.
struct View {
    scale: f64,
    offset: (f64, f64),
}

impl View {
    /// The view that just holds all points.
    fn onto(points: &[DVec3]) -> Self {
        let flat: Vec<(f64, f64)> = points.iter().map(|p| Self::flat(*p)).collect();
        let ends = |of: fn(&(f64, f64)) -> f64| flat.iter().map(of).fold((f64::MAX, f64::MIN), |(l, h), x| (l.min(x), h.max(x)));
        let ((left, right), (low, high)) = (ends(|p| p.0), ends(|p| p.1));
        let room = (SIZE.0 - 2.0 * MARGIN, SIZE.1 - 2.0 * MARGIN);
        let scale = (room.0 / (right - left).max(1e-3)).min(room.1 / (high - low).max(1e-3));
        let offset = (SIZE.0 / 2.0 - scale * (left + right) / 2.0, SIZE.1 / 2.0 + scale * (low + high) / 2.0);
        Self { scale, offset }
    }

    /// From an elevation of 25 degrees, turned by 20: sines and cosines below.
    fn flat(p: DVec3) -> (f64, f64) {
        let (right, back) = (0.940 * p.x - 0.342 * p.y, 0.342 * p.x + 0.940 * p.y);
        (right, 0.423 * back + 0.906 * p.z)
    }

    fn place(&self, p: DVec3) -> (f64, f64) {
        let (x, y) = Self::flat(p);
        (self.offset.0 + self.scale * x, self.offset.1 - self.scale * y)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use radgrad_audit::cases::family::Family;

    #[test]
    fn every_valid_case_has_a_picture_without_a_nan_at_any_scale() {
        for family in Family::ALL {
            for index in 0..5 {
                let Some(geometry) = Geometry::from_case(Name { family, seed: 1, index }) else {
                    assert!(family.is_refused(), "{family}");
                    continue;
                };
                let svg = geometry.draw("a case");
                assert!(!svg.contains("NaN") && !svg.contains("inf"), "{family}:1:{index} {svg}");
                assert!(geometry.distance.is_finite() && geometry.size > 0.0);
            }
        }
    }

    #[test]
    fn heights_and_distances_are_in_sizes_of_the_emitter() {
        let geometry = |family, index| Geometry::from_case(Name { family, seed: 1, index }).unwrap();
        assert!((0..9).all(|index| geometry(Family::Far, index).distance > 5.0));
        assert!(
            (0..9)
                .all(|index| geometry(Family::Contact, index).height < 0.2 && geometry(Family::ContactScale, index).height < 0.2)
        );
    }
}
