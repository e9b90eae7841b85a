//! All the segments from a receiver to an emitter, as an intersection of half-spaces.
//!
//! What hides a point y of the emitter from a point x of the receiver meets the open segment from x to y. Those segments are in
//! the convex hull of receiver and emitter, in front of the emitter and above the receiver's horizon. So a polygon hides nothing
//!
//! - if it is nowhere in front of the emitter's plane, or nowhere above the receiver's horizon;
//! - if receiver and emitter are on one side of its own plane;
//! - if it is outside a plane that bounds the hull. What touches such a plane elsewhere than at a corner of the two is found all
//!   the same: seen from x its edge lies on the emitter's, the gradient has two values there, and the choice between them is not
//!   made here.
//!
//! The bounding planes of the hull are those through an edge of one and a corner of the other that have both on one side;
//! signs are exact, so that none is taken that would cut off a part.

use radgrad_core::{DVec3, Polygon, Receiver};

use super::half_space::{HalfSpace, Plane, Side};
use super::hull::convex_hull;
use crate::projection::normalising_power;

/// The space between a receiver, a point or a polygon, and an emitter: where occluders may be.
#[derive(Debug, Clone)]
pub struct Beam {
    /// In front of the emitter.
    front: HalfSpace,
    /// Above the receiver's horizon.
    horizon: HalfSpace,
    /// Inside the hull of receiver and emitter.
    sides: Vec<HalfSpace>,
    /// Whether planes are those of surfaces, or exactly those of the doubles as given.
    of_surfaces: bool,
    /// Corners of the receiver, then of the emitter, and the box around them.
    corners: Vec<DVec3>,
    of_receiver: usize,
    low: DVec3,
    high: DVec3,
    power: f64,
}

impl Beam {
    /// The beam from a receiver to an emitter; `None` where the receiver is not in front of the emitter's plane or the emitter is
    /// nowhere above the receiver's horizon: then the radiosity is 0, with or without occluders.
    ///
    /// What it does not find hides nothing, exactly for the doubles as given.
    #[must_use]
    pub fn from_receiver(receiver: &Receiver, emitter: &Polygon) -> Option<Self> {
        Self::new(&[receiver.position()], emitter, false, |power| HalfSpace::above(receiver, power))
    }

    /// The beam from a point of a polygon, whose side is that of the polygon; `None` as in [`Self::from_receiver`].
    ///
    /// Here planes are those of surfaces: the point is taken to be on the polygon, and what is level with the polygon or with the
    /// emitter, up to the rounding of coordinates, to be in its plane and so to hide nothing. The rest of a slanted wall would
    /// else stand out by an ulp here and there. A gap narrower than that rounding is none.
    #[must_use]
    pub fn from_point_of(polygon: &Polygon, point: DVec3, emitter: &Polygon) -> Option<Self> {
        Self::new(&[point], emitter, true, |power| Plane::of(polygon).over(power))
    }

    /// The beam from all points of a polygon to an emitter; `None` where none is in front of the other. Planes are those of
    /// surfaces as in [`Self::from_point_of`].
    #[must_use]
    pub fn from_polygon(receiver: &Polygon, emitter: &Polygon) -> Option<Self> {
        Self::new(&convex_hull(receiver), emitter, true, |power| Plane::of(receiver).over(power))
    }

    fn new(from: &[DVec3], emitter: &Polygon, of_surfaces: bool, horizon: impl FnOnce(f64) -> HalfSpace) -> Option<Self> {
        let to = convex_hull(emitter);
        let corners: Vec<DVec3> = from.iter().chain(emitter.vertices()).copied().collect();
        let (low, high) = corners.iter().fold((from[0], from[0]), |(low, high), &p| (low.min(p), high.max(p)));
        let power = normalising_power(corners.iter().fold(0.0, |farthest, &p| (p - from[0]).abs().max_element().max(farthest)));
        let front = front_of(&Plane::of(emitter), power, of_surfaces);
        let horizon = horizon(power);
        if front.excludes(from) || horizon.excludes(emitter.vertices()) {
            return None;
        }
        let mut beam =
            Self { front, horizon, sides: Vec::new(), of_surfaces, corners, of_receiver: from.len(), low, high, power };
        beam.bound(&to, from);
        if from.len() > 1 {
            beam.bound(from, &to);
        }
        Some(beam)
    }

    /// Adds the bounding planes through an edge of `outline` and one of `points`.
    fn bound(&mut self, outline: &[DVec3], points: &[DVec3]) {
        for (i, &a) in outline.iter().enumerate() {
            let b = outline[(i + 1) % outline.len()];
            for &point in points {
                let known = self.sides.iter().any(|plane| [point, a, b].iter().all(|&p| plane.side(p) == Side::On));
                if !known {
                    self.sides.extend(self.supporting([point, a, b]));
                }
            }
        }
    }

    /// The half-space that is bounded by the plane through three points, if all corners are on one side.
    fn supporting(&self, [o, a, b]: [DVec3; 3]) -> Option<HalfSpace> {
        let half_space = HalfSpace::through(o, a, b, self.power);
        let (mut inside, mut outside) = (false, false);
        for &corner in &self.corners {
            match half_space.side(corner) {
                Side::Inside => inside = true,
                Side::Outside => outside = true,
                Side::On => {}
            }
            if inside && outside {
                return None;
            }
        }
        match (inside, outside) {
            (true, false) => Some(half_space),
            (false, true) => Some(half_space.reversed()),
            _ => None,
        }
    }

    /// Whether nothing in a box can hide anything.
    pub(super) fn misses_box(&self, low: DVec3, high: DVec3) -> bool {
        let mut half_spaces = [&self.front, &self.horizon].into_iter().chain(&self.sides);
        self.is_beside(low, high) || half_spaces.any(|half_space| half_space.misses_box(low, high))
    }

    /// Whether a polygon can hide nothing.
    pub(super) fn misses_polygon(&self, vertices: &[DVec3], plane: &Plane) -> bool {
        let (low, high) = vertices.iter().fold((vertices[0], vertices[0]), |(low, high), &v| (low.min(v), high.max(v)));
        if self.is_beside(low, high)
            || self.front.excludes(vertices)
            || self.horizon.excludes(vertices)
            || self.sides.iter().any(|side| self.is_clear_of(side, vertices))
        {
            return true;
        }
        self.is_beside_plane(front_of(plane, self.power, self.of_surfaces))
    }

    /// Whether a polygon is outside a bounding plane, and touches it at corners of receiver and emitter only.
    fn is_clear_of(&self, side: &HalfSpace, vertices: &[DVec3]) -> bool {
        vertices.iter().all(|vertex| match side.side(*vertex) {
            Side::Inside => false,
            Side::On => self.corners.contains(vertex),
            Side::Outside => true,
        })
    }

    /// Whether receiver and emitter are on one side of a polygon's plane, or the receiver in it.
    fn is_beside_plane(&self, front: HalfSpace) -> bool {
        let (receiver, emitter) = self.corners.split_at(self.of_receiver);
        let behind = front.excludes(receiver);
        let back = front.clone().reversed();
        match (behind, back.excludes(receiver)) {
            (true, true) => true,
            (true, false) => front.excludes(emitter),
            (false, true) => back.excludes(emitter),
            (false, false) => false,
        }
    }

    /// Whether a box is outside that of the beam.
    fn is_beside(&self, low: DVec3, high: DVec3) -> bool {
        high.cmplt(self.low).any() || low.cmpgt(self.high).any()
    }
}

/// The space in front of a polygon.
fn front_of(plane: &Plane, power: f64, of_surfaces: bool) -> HalfSpace {
    if of_surfaces { plane.over(power) } else { plane.front(power) }
}
