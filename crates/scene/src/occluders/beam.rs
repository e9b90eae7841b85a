//! All the segments from a receiver to an emitter, as an intersection of half-spaces.
//!
//! An occluder between a point x of the receiver and a point y of the emitter meets the open segment from x to y. Those segments
//! are in the convex hull of receiver and emitter, in front of the emitter and above the receiver's horizon. So a polygon hides
//! nothing
//!
//! - if it is nowhere in front of the emitter's plane, or nowhere above the receiver's horizon;
//! - if receiver and emitter are on one side of its own plane;
//! - if it is outside a plane that bounds the hull. A polygon that touches such a plane elsewhere than at a corner of the two is
//!   found all the same: seen from x its edge lies on the emitter's, the gradient has two values there, and the choice between them
//!   is not made here.
//!
//! The bounding planes of the hull are those through an edge of one and a corner of the other that have both on one side. For
//! each edge that corner is sought; signs are exact, and a plane that would cut off a part is not taken, as may be all those of
//! an edge whose plane the other polygon crosses.

use radgrad_core::{DVec3, Polygon, Receiver};

use super::half_space::{Frame, HalfSpace, Located, Plane, Side};
use super::hull::convex_hull;
use super::shape::{Bounds, Shape};
use crate::extremes::largest;
use crate::projection::normalising_power;

/// The space between a receiver, a point or a polygon, and an emitter: where occluders may be.
///
/// ```
/// use radgrad_core::{DVec3, Polygon, Receiver};
/// use radgrad_scene::{Beam, Occluders};
/// let square = |half: f64, z: f64| {
///     Polygon::new([(-half, -half), (-half, half), (half, half), (half, -half)].map(|(x, y)| DVec3::new(x, y, z)).to_vec())
/// };
/// let (lamp, floor) = (square(1.0, 2.0)?, Receiver::new(DVec3::ZERO, DVec3::Z, 1.0)?);
/// let others = [square(0.5, 1.0)?, square(0.5, 3.0)?]; // between, and behind the lamp
/// let beam = Beam::from_receiver(&floor, &lamp).ok_or("the lamp is not seen")?;
/// assert_eq!(Occluders::new(&others).in_beam(&beam, &[]).polygons, [0]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
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
    bounds: Bounds,
    /// Where all half-spaces have their coordinates.
    frame: Frame,
}

impl Beam {
    /// The beam from a receiver to an emitter; `None` where the receiver is not in front of the emitter's plane or the emitter is
    /// nowhere above the receiver's horizon: then the radiosity is 0, with or without occluders.
    ///
    /// A polygon that it does not find hides nothing, exactly for the doubles as given.
    #[must_use]
    pub fn from_receiver(receiver: &Receiver, emitter: &Polygon) -> Option<Self> {
        Self::new(&[receiver.position()], emitter, false, |frame| HalfSpace::above(receiver, frame))
    }

    /// The beam from a point of a polygon, whose side is that of the polygon; `None` as in [`Self::from_receiver`].
    ///
    /// Here planes are those of surfaces: the point is taken to be on the polygon, and a surface level with the polygon or with the
    /// emitter, up to the rounding of coordinates, is taken to be in its plane and so to hide nothing. The rest of a slanted wall
    /// would else stand out by an ulp here and there. A gap narrower than that rounding is none.
    #[must_use]
    pub fn from_point_of(polygon: &Polygon, point: DVec3, emitter: &Polygon) -> Option<Self> {
        Self::new(&[point], emitter, true, |frame| Plane::of(polygon).over(frame))
    }

    /// The beam from all points of a polygon to an emitter; `None` where none is in front of the other. Planes are those of
    /// surfaces as in [`Self::from_point_of`].
    #[must_use]
    pub fn from_polygon(receiver: &Polygon, emitter: &Polygon) -> Option<Self> {
        Self::new(&convex_hull(receiver), emitter, true, |frame| Plane::of(receiver).over(frame))
    }

    fn new(from: &[DVec3], emitter: &Polygon, of_surfaces: bool, horizon: impl FnOnce(&Frame) -> HalfSpace) -> Option<Self> {
        let to = convex_hull(emitter);
        let corners: Vec<DVec3> = from.iter().chain(emitter.vertices()).copied().collect();
        let farthest = corners.iter().map(|&p| (p - from[0]).abs().max_element()).fold(0.0, largest);
        let frame = Frame { origin: from[0], power: normalising_power(farthest) };
        let plane = Plane::of(emitter);
        let front = if of_surfaces { plane.over(&frame) } else { plane.front(&frame) };
        let horizon = horizon(&frame);
        let locate = |&point: &DVec3| frame.locate(point);
        if front.excludes(from.iter().map(locate)) || horizon.excludes(emitter.vertices().iter().map(locate)) {
            return None;
        }
        let (bounds, of_receiver) = (Bounds::of(&corners), from.len());
        let mut beam = Self { front, horizon, sides: Vec::new(), of_surfaces, corners, of_receiver, bounds, frame };
        beam.bound(&to, from);
        if from.len() > 1 {
            beam.bound(from, &to);
        }
        Some(beam)
    }

    /// Adds the bounding planes through an edge of `outline` and one of `points`.
    fn bound(&mut self, outline: &[DVec3], points: &[DVec3]) {
        let count = outline.len();
        for (i, &a) in outline.iter().enumerate() {
            let (b, own) = (outline[(i + 1) % count], outline[(i + 2) % count]);
            let point = self.extreme([a, b, own], points);
            // Four corners in one plane give it twice.
            let is_on = |plane: &HalfSpace, p: DVec3| plane.side(&self.frame.locate(p)) == Side::On;
            let is_known = |plane: &HalfSpace| is_on(plane, point) && is_on(plane, a) && is_on(plane, b);
            if points.len() == 1 || !self.sides.iter().any(is_known) {
                self.sides.extend(self.supporting([point, a, b]));
            }
        }
    }

    /// The point whose plane through the edge a b is turned farthest away from `own`, which is beside the edge: all others are on
    /// its side if they are on one side of the plane of a, b and own.
    fn extreme(&self, [a, b, own]: [DVec3; 3], points: &[DVec3]) -> DVec3 {
        points[1..].iter().fold(points[0], |extreme, &point| {
            let plane = HalfSpace::through(extreme, a, b, &self.frame);
            let side = |p: DVec3| plane.side(&self.frame.locate(p));
            match (side(own), side(point)) {
                (Side::On, _) | (Side::Inside, Side::Outside) | (Side::Outside, Side::Inside) => point,
                _ => extreme,
            }
        })
    }

    /// The half-space that is bounded by the plane through three points, if all corners are on one side.
    fn supporting(&self, [o, a, b]: [DVec3; 3]) -> Option<HalfSpace> {
        let half_space = HalfSpace::through(o, a, b, &self.frame);
        let (mut inside, mut outside) = (false, false);
        for &corner in self.corners.iter().filter(|corner| ![o, a, b].contains(corner)) {
            match half_space.side(&self.frame.locate(corner)) {
                Side::Inside => inside = true,
                Side::Outside => outside = true,
                Side::On => {}
                Side::Unknown => return None,
            }
        }
        match (inside, outside) {
            (true, false) => Some(half_space),
            (false, true) => Some(half_space.reversed()),
            _ => None,
        }
    }

    /// Whether nothing in a box can hide anything. Only the part of it in the box around the beam matters.
    pub(super) fn misses_box(&self, bounds: &Bounds) -> bool {
        let Some(common) = bounds.common(&self.bounds) else { return true };
        let (low, high) = (self.frame.locate(common.low), self.frame.locate(common.high));
        let misses = |half_space: &HalfSpace| half_space.misses_box(&low, &high);
        misses(&self.front) || misses(&self.horizon) || self.sides.iter().any(misses)
    }

    /// Whether a polygon can hide nothing.
    pub(super) fn misses_polygon(&self, shape: &Shape) -> bool {
        let vertices = || shape.vertices.iter().map(|&vertex| self.frame.locate(vertex));
        self.misses_box(&shape.bounds)
            || self.front.excludes(vertices())
            || self.horizon.excludes(vertices())
            || self.sides.iter().any(|side| vertices().all(|vertex| self.is_clear_of(side, &vertex)))
            || self.is_beside(shape)
    }

    /// Whether a vertex is outside a bounding plane, or touches it at a corner of receiver or emitter.
    fn is_clear_of(&self, side: &HalfSpace, vertex: &Located) -> bool {
        match side.side(vertex) {
            Side::Inside | Side::Unknown => false,
            Side::On => self.corners.contains(&vertex.point),
            Side::Outside => true,
        }
    }

    /// Whether receiver and emitter are on one side of a polygon's plane, or the receiver in it.
    fn is_beside(&self, shape: &Shape) -> bool {
        let front = shape.front(self.of_surfaces);
        let [receiver, emitter] = [0..self.of_receiver, self.of_receiver..self.corners.len()]
            .map(|range| self.corners[range].iter().map(|&corner| shape.frame.locate(corner)));
        match (front.holds(receiver.clone()), front.excludes(receiver)) {
            (true, true) => true,
            (true, false) => front.holds(emitter),
            (false, true) => front.excludes(emitter),
            (false, false) => false,
        }
    }
}
