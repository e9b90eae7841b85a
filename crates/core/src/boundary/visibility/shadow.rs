//! The shadow of a convex occluder on the emitter's plane: a convex cone, cut off where the occluder sinks below that plane.

use glam::DVec3;
use radgrad_numbers::real::Real;
use radgrad_numbers::vec3::Vec3;

use crate::boundary::arc::Generator;
use crate::boundary::edge_name::EdgeName;
use crate::boundary::line::{Line, Sighted};
use crate::boundary::plan::{Plan, Side, height_over_plane, side_of};
use crate::boundary::visibility::not_flat::{Doubt, is_on_outline};
use crate::boundary::visibility::part::{Facing, Sides, VisiblePart};
use crate::boundary::visibility::separation::BoundingCone;
use crate::problem::polygon::Polygon;
use crate::problem::receiver::Receiver;

/// A convex occluder that stands, at least with a corner, before the emitter's plane, and is not seen edge-on; or of which that is
/// open.
pub(super) struct Screen<'a> {
    occluder: &'a Polygon,
    /// Its number.
    index: usize,
    /// Counter-clockwise as the receiver sees them.
    vertices: Vec<DVec3>,
    /// Where each is relative to the emitter's plane.
    sides: Vec<Side>,
    /// Where the receiver is relative to the occluder's.
    receiver_side: Side,
    /// A circular cone and rays around it, in doubles.
    pub(super) cone: BoundingCone,
    /// The uncertain part of its shadow, if any.
    pub(super) doubt: Option<Doubt>,
}

/// The shadow of a convex occluder: where `N . omega < 0` for all its lines.
pub(super) struct Shadow<T> {
    pub(super) lines: Vec<Facing>,
    corners: Vec<Vec3<T>>,
}

impl<'a> Screen<'a> {
    /// The part `indices` of `occluder`, or `None` where it surely casts no shadow on the emitter.
    pub(super) fn new(
        receiver: &Receiver,
        emitter: &Polygon,
        (index, occluder): (usize, &'a Polygon),
        indices: &[usize],
        plan: &Plan,
    ) -> Option<Self> {
        let x = receiver.position();
        let mut vertices: Vec<DVec3> = indices.iter().map(|&i| occluder.vertices()[i]).collect();
        let doubt = Doubt::of_part(receiver, emitter, occluder, &vertices, plan);
        let receiver_side = side_of(x, occluder, plan.power);
        if receiver_side == Side::Back {
            vertices.reverse();
        }
        // The outline is on every surface through the emitter's vertices.
        let is_on_it = |v: DVec3| emitter.half_slab() > 0.0 && is_on_outline(v, emitter);
        let side = |&v: &DVec3| if is_on_it(v) { Side::InPlane } else { side_of(v, emitter, plan.power) };
        let sides: Vec<Side> = if receiver_side == Side::InPlane { Vec::new() } else { vertices.iter().map(side).collect() };
        let screen =
            Self { occluder, index, cone: BoundingCone::of_polygon(x, &vertices), vertices, sides, receiver_side, doubt };
        (screen.casts_shadow() || screen.doubt.is_some()).then_some(screen)
    }

    /// Whether it hides anything, taking the two polygons for flat.
    pub(super) fn casts_shadow(&self) -> bool {
        self.sides.contains(&Side::Front)
    }

    /// Whether it surely hides nothing of a cone.
    pub(super) fn misses(&self, cone: &BoundingCone) -> bool {
        !self.doubt.as_ref().is_some_and(Doubt::is_edge_on) && self.cone.misses(cone)
    }
}

impl<T: Real> Shadow<T> {
    /// The shadow of a screen.
    pub(super) fn new(receiver: &Receiver, emitter: &Polygon, screen: &Screen<'_>, plan: &Plan, sides: &mut Sides<T>) -> Self {
        let (x, power) = (receiver.position(), plan.power);
        let Screen { occluder, index, vertices, sides: places, receiver_side: from, .. } = screen;
        let heights: Vec<T> = vertices.iter().map(|&v| height_over_plane(v, emitter, power)).collect();
        let sighted: Vec<Sighted<T>> = vertices.iter().map(|&v| Sighted::from(v, x, power)).collect();
        let mut shadow = Self { lines: Vec::new(), corners: Vec::new() };
        let (mut sinks, mut rises) = (None, None);
        for i in 0..vertices.len() {
            let j = (i + 1) % vertices.len();
            let ends = [vertices[i], vertices[j]];
            let start = sighted[i].point;
            let line = Line::through(ends, [&sighted[i], &sighted[j]], x, power);
            let touch = || start + line.e * (heights[i] / (heights[i] - heights[j]));
            match (places[i], places[j]) {
                (Side::Back, Side::Back) => continue,
                (Side::Back, Side::InPlane) => {
                    rises = Some(sighted[j].point);
                    continue;
                }
                (Side::InPlane, Side::Back) => {
                    sinks = Some(start);
                    shadow.corners.push(start);
                    continue;
                }
                (Side::Front, Side::Back) => {
                    sinks = Some(touch());
                    shadow.corners.extend([start, touch()]);
                }
                (Side::Back, Side::Front) => {
                    rises = Some(touch());
                    shadow.corners.push(touch());
                }
                (Side::Front | Side::InPlane, Side::Front | Side::InPlane) => shadow.corners.push(start),
            }
            shadow.lines.push(sides.add_shadow(Generator::Occluder(line), Some(EdgeName::new(ends[0], ends[1])), *index));
        }
        if let (Some(sink), Some(rise)) = (sinks, rises) {
            let line = waterline([sink, rise], *from, emitter, occluder);
            shadow.lines.push(sides.add_shadow(Generator::Occluder(line), None, *index));
        }
        shadow
    }

    /// Whether one side of the shadow or of the part is known to separate them.
    pub(super) fn misses(&self, part: &VisiblePart<T>, sides: &Sides<T>) -> bool {
        let is_beyond = |normal: Vec3<T>, point: Vec3<T>| {
            let height = normal.dot(point);
            height.value() > 0.0 && height.size() > height.error()
        };
        let is_clear_of = |side: Facing| part.corners.iter().all(|corner| is_beyond(sides.normal(side), corner.point));
        let is_within = |side: Facing| self.corners.iter().all(|corner| is_beyond(sides.normal(side), *corner));
        self.lines.iter().any(|&side| is_clear_of(side)) || part.corners.iter().any(|corner| is_within(corner.side))
    }
}

/// The line in which the occluder meets the emitter's plane, from where it sinks below to where it rises, so that its part before
/// that plane is on its left as the receiver sees it. Where the occluder only just dips below the plane the two points hardly
/// tell which way that is; of two planes the normals do, with that of the occluder turned to the receiver.
fn waterline<T: Real>([sink, rise]: [Vec3<T>; 2], receiver_side: Side, emitter: &Polygon, occluder: &Polygon) -> Line<T> {
    if emitter.half_slab() > 0.0 || occluder.half_slab() > 0.0 {
        return Line::along(rise - sink, sink);
    }
    let direction = emitter.unit_normal::<T>().cross(occluder.unit_normal());
    Line::along(if receiver_side == Side::Back { -direction } else { direction }, sink)
}
