//! Subtracts a shadow from a part of the emitter: cut along the shadow's sides, one after the other.

use glam::DVec3;
use radgrad_numbers::radius::Radius;
use radgrad_numbers::real::{RadiusOf, Real};
use radgrad_numbers::vec3::Vec3;

use crate::boundary::arc::Generator;
use crate::boundary::edge_name::EdgeName;
use crate::boundary::line::{Line, Sighted};
use crate::boundary::plan::{Horizon, Plan, height_over_horizon, height_over_plane, is_on_horizon};
use crate::boundary::visibility::part::{Facing, PartCorner, Sides, VisiblePart};
use crate::boundary::visibility::shadow::Shadow;
use crate::boundary::visibility::uncertainty::{Uncertainty, is_doubtful, is_exactly_0};
use crate::problem::emission::Emitter;
use crate::problem::polygon::Polygon;
use crate::problem::receiver::{Receiver, unit_normal};

/// The sides and heights that bound the uncertainty, and the uncertainty so far.
pub(super) struct Subtraction<'a, T: Real> {
    receiver: &'a Receiver,
    plan: &'a Plan,
    pub(super) sides: Sides<T>,
    /// The emitter's plane: where `-n2 . p` is the height of the receiver over it.
    plane: (Vec3<T>, T),
    /// Height of the receiver over the emitter's plane, from below.
    pub(super) height: RadiusOf<T>,
    /// Bound on `|B|`.
    pub(super) emission: f64,
    /// Bound on `|grad B| (1 + 1/c)` over the emitter.
    pub(super) steepness: RadiusOf<T>,
    pub(super) uncertainty: Uncertainty<RadiusOf<T>>,
}

impl<'a, T: Real> Subtraction<'a, T> {
    pub(super) fn new(receiver: &'a Receiver, emitter: &Emitter, plan: &'a Plan) -> Self {
        let polygon = emitter.polygon();
        let height: T = height_over_plane(receiver.position(), polygon, plan.power);
        let plane = (-polygon.unit_normal(), height);
        let defect = RadiusOf::<T>::from(polygon.planarity_defect() * plan.power);
        let height = (height.size() * (1.0 - 2.0 * f64::EPSILON) - height.error() - defect).max(0.0.into());
        // Points of the emitter are at most 2 sqrt(3) away, so 1/c <= 4/h.
        let gradient = emitter.steepest_emission() * emitter.power() / plan.power * 1.01;
        let steepness = (RadiusOf::<T>::from(4.0) / height + 1.0.into()) * gradient;
        let emission = emitter.largest_emission() * emitter.power() * 1.01;
        Self { receiver, plan, sides: Sides::new(), plane, height, emission, steepness, uncertainty: Uncertainty::none() }
    }

    pub(super) fn part_above_horizon(&mut self, polygon: &Polygon, indices: &[usize]) -> Option<VisiblePart<T>> {
        let receiver = self.receiver;
        let (x, power) = (receiver.position(), self.plan.power);
        let vertices: Vec<DVec3> = indices.iter().map(|&i| polygon.vertices()[i]).collect();
        let sighted: Vec<Sighted<T>> = vertices.iter().map(|&v| Sighted::from(v, x, power)).collect();
        let corners = (0..vertices.len()).map(|i| {
            let j = (i + 1) % vertices.len();
            let line = || Line::through([vertices[i], vertices[j]], [&sighted[i], &sighted[j]], x, power);
            let name = EdgeName::new(vertices[i], vertices[j]);
            let side = self.sides.add_emitter_edge(|| Generator::Emitter(line()), name);
            PartCorner { point: sighted[i].point, vertex: Some(vertices[i]), side }
        });
        let corners = corners.collect();
        let part = VisiblePart::new(corners, &self.sides);
        let heights: Vec<T> = vertices.iter().map(|&v| height_over_horizon(receiver, v, power)).collect();
        let horizon = self.sides.add(Generator::Horizon(-unit_normal::<T>(receiver)), None);
        self.keep(&part, &heights, horizon)
    }

    /// Adds the parts of `part` outside `shadow`.
    pub(super) fn subtract(&mut self, part: VisiblePart<T>, shadow: &Shadow<T>, lit: &mut Vec<VisiblePart<T>>) {
        let mut inside = part;
        for &side in &shadow.lines {
            lit.extend(self.cut(&inside, side.reversed(), None));
            match self.cut(&inside, side, Some(shadow)) {
                Some(inner) => inside = inner,
                None => break,
            }
        }
    }

    /// The part where `N . omega < 0` for the normal of `side`, if any; of the side of a shadow the kinks in the light are added.
    fn cut(&mut self, part: &VisiblePart<T>, side: Facing, shadow: Option<&Shadow<T>>) -> Option<VisiblePart<T>> {
        let (normal, name) = (self.sides.normal(side), self.sides.name(side));
        let count = part.corners.len();
        let is_in_horizon = |i: usize| {
            self.is_horizon(side) && [i, (i + count - 1) % count].iter().any(|&k| self.is_horizon(part.corners[k].side))
        };
        // The depth of a corner, and whether it is seen exactly on the line though it is not known to be on it, or in the horizon with it.
        let depth = |i: usize| {
            let corner = &part.corners[i];
            let depth = -normal.dot(corner.point);
            if !is_doubtful(depth) && !is_exactly_0(depth) {
                return (depth, false);
            }
            let is_on_it = || name.zip(corner.vertex).is_some_and(|(edge, vertex)| edge.is_in_line_with(vertex));
            if is_on_it() || is_in_horizon(i) { (T::exact(0.0), false) } else { (depth, is_exactly_0(depth)) }
        };
        let (depths, are_seen_on_it): (Vec<T>, Vec<bool>) = (0..count).map(depth).unzip();
        let is_small = |i: usize| depths[i].size() <= depths[i].error();
        if let Some(i) =
            (0..count).find(|&i| self.are_one(part.corners[i].side, side, || is_small(i) && is_small((i + 1) % count)))
        {
            let same_way = self.sides.normal(part.corners[i].side).dot(normal).value() > 0.0;
            return same_way.then(|| part.clone());
        }
        if let Some(shadow) = shadow {
            for (i, j) in (0..count).map(|i| (i, (i + 1) % count)) {
                if (are_seen_on_it[i] || are_seen_on_it[j]) && is_exactly_0(depths[i]) && is_exactly_0(depths[j]) {
                    self.add_kink([i, j].map(|k| part.corners[k].point), [part.corners[i].side, side], shadow);
                }
            }
        }
        self.keep(part, &depths, side)
    }

    /// Whether the plane of a side is exactly that of the receiver's horizon: the horizon's own, or of an occluder that stands on the
    /// receiver's plane.
    fn is_horizon(&self, side: Facing) -> bool {
        let lies_in_it = |name: EdgeName| name.ends().into_iter().all(|end| self.is_on_horizon(end));
        matches!(self.sides.unturned(side), Generator::Horizon(_)) || self.sides.name(side).is_some_and(lies_in_it)
    }

    fn is_on_horizon(&self, point: DVec3) -> bool {
        self.plan.horizon == Horizon::Crossing && is_on_horizon(self.receiver, point, self.plan.power)
    }

    /// Whether a side of a part is on the line which cuts it, or both are in the receiver's horizon: by their names, or, where both of
    /// its ends may be on that line, exactly.
    fn are_one(&self, own: Facing, cutting: Facing, is_close: impl Fn() -> bool) -> bool {
        let Some(line) = self.sides.name(cutting) else { return false };
        let is_on_line = |name: EdgeName| name == line || (is_close() && name.is_on_the_line_of(line));
        self.sides.name(own).is_some_and(is_on_line) || (is_close() && self.is_horizon(own) && self.is_horizon(cutting))
    }

    /// A vertex in which two sides surely meet as they are seen: lines that share it, or the horizon and a line that ends there.
    fn shared_vertex(&self, own: Facing, cutting: Facing) -> Option<DVec3> {
        let [name, line] = [own, cutting].map(|side| self.sides.name(side));
        let in_horizon = |horizon: Facing, line: Option<EdgeName>| {
            line?.ends().into_iter().find(|&end| self.is_on_horizon(end) && self.is_horizon(horizon))
        };
        let shared = name.zip(line).and_then(|(name, line)| name.shared_end(line));
        shared.or_else(|| in_horizon(own, line)).or_else(|| in_horizon(cutting, name))
    }

    /// The part of positive depth, closed along `cutting`.
    fn keep(&mut self, part: &VisiblePart<T>, depths: &[T], cutting: Facing) -> Option<VisiblePart<T>> {
        self.add_uncertainty(part, depths, cutting);
        let is_line = !matches!(self.sides.unturned(cutting), Generator::Horizon(_));
        let places: Vec<Place> = depths.iter().map(|&depth| Place::of_depth(depth)).collect();
        let crossing = |i: usize, j: usize| {
            let [start, end] = [i, j].map(|k| &part.corners[k]);
            let from_ends = start.point + (end.point - start.point) * (depths[i] / (depths[i] - depths[j]));
            self.crossing(start.side, cutting, from_ends)
        };
        match clip(&part.corners, &places, cutting, is_line, |own| self.shared_vertex(own, cutting), crossing) {
            Clipped::Nothing => None,
            Clipped::Whole => Some(part.clone()),
            Clipped::Corners(corners) => Some(VisiblePart::new(corners, &self.sides)),
        }
    }

    /// The point of the emitter's plane that is seen where two sides cross: between the ends of an edge, or, where others have cut
    /// that edge before and their errors would be inherited, from the generators of the two. Whichever is known better.
    fn crossing(&self, own: Facing, cutting: Facing, from_ends: Vec3<T>) -> Vec3<T> {
        let [own, cutting] = [own, cutting].map(|facing| self.sides.unturned(facing));
        let direction = own.normal().cross(cutting.normal());
        // An edge of the emitter is where it is, off the plane by rounding.
        let (toward, distance) = match own {
            Generator::Emitter(line) => {
                let frame = line.frame();
                (frame.toward, frame.distance)
            }
            _ => self.plane,
        };
        let along = toward.dot(direction);
        if along.size() <= along.error() * 8.0 {
            return from_ends;
        }
        let from_sides = direction * (distance / along);
        let error = |point: Vec3<T>| point.x.error() + point.y.error() + point.z.error();
        if error(from_sides) < error(from_ends) { from_sides } else { from_ends }
    }
}

/// Where a corner is relative to a side that cuts.
#[derive(Debug, Clone, Copy)]
pub(super) struct Place {
    /// Height over the side, positive on the part that remains; a value within its bound where it is uncertain.
    pub(super) depth: f64,
    pub(super) is_exactly_on_it: bool,
    pub(super) is_doubtful: bool,
}

impl Place {
    fn of_depth<T: Real>(depth: T) -> Self {
        Self { depth: depth.value(), is_exactly_on_it: is_exactly_0(depth), is_doubtful: is_doubtful(depth) }
    }
}

/// The part of an outline on the positive side of a line.
pub(super) enum Clipped<P> {
    Nothing,
    Whole,
    Corners(Vec<PartCorner<P>>),
}

/// The corners of positive depth, closed along `cutting` (Sutherland and Hodgman 1974, on a cone), given where a side from one corner
/// to another crosses it, and the vertex of the input that is surely seen there, if any.
pub(super) fn clip<P: Copy>(
    corners: &[PartCorner<P>],
    places: &[Place],
    cutting: Facing,
    is_line: bool,
    vertex: impl Fn(Facing) -> Option<DVec3>,
    point: impl Fn(usize, usize) -> P,
) -> Clipped<P> {
    let count = corners.len();
    let inside = |i: usize| places[i].depth > 0.0;
    // A part that a line only touches keeps its own edges, also one seen along that line: it lies elsewhere in space.
    if is_line && (0..count).any(inside) && places.iter().all(|place| place.depth >= 0.0) {
        return Clipped::Whole;
    }
    let mut clipped = Vec::with_capacity(count + 1);
    for i in 0..count {
        let j = (i + 1) % count;
        let (start, end) = (corners[i], corners[j]);
        let crossing = |side: Facing| {
            if places[i].is_exactly_on_it || (places[i].is_doubtful && places[j].is_doubtful) {
                // Between two doubtful corners the cut may be anywhere, and the doubt covers any choice.
                PartCorner { side, ..start }
            } else if places[j].is_exactly_on_it {
                PartCorner { side, ..end }
            } else {
                PartCorner { point: point(i, j), vertex: vertex(start.side), side }
            }
        };
        match (inside(i), inside(j)) {
            (true, true) => clipped.push(start),
            (true, false) => {
                clipped.push(start);
                clipped.push(crossing(cutting));
            }
            (false, true) => clipped.push(crossing(start.side)),
            (false, false) => {}
        }
    }
    if clipped.is_empty() { Clipped::Nothing } else { Clipped::Corners(clipped) }
}
