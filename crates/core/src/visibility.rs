//! The boundary of the part of an emitter that the receiver sees past occluders.
//!
//! Seen from x, a convex part of the emitter above the horizon is a convex cone, and so is the shadow of a convex occluder, cut
//! off at the emitter's plane. Subtracting a shadow leaves the parts outside its side k and inside its sides before k. The
//! seams between those parts lie on occluder lines and run once each way, so that they cancel in every sum over arcs.
//!
//! Edges on one line (in a mesh of occluders and at its T-junctions, or where an occluder stands on the emitter's edge) are
//! decided exactly ([`crate::edge_name`]). Elsewhere a corner may be within rounding of a shadow's side; then the middle of its
//! ball decides, and [`Doubt`] bounds what the other decision would have changed.

use glam::DVec3;

use crate::arc::{Arc, Generator};
use crate::edge_name::EdgeName;
use crate::line::{Line, Sighted};
use crate::plan::{Plan, Side, height_over_horizon, height_over_plane, side_of, unit_normal};
use crate::radius::Radius;
use crate::real::{RadiusOf, Real};
use crate::triangulate::convex_parts;
use crate::vec3::Vec3;
use crate::{Emitter, Polygon, Receiver};

/// Bounds on what undecided signs may change, in the sums without the factor rho/pi.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Doubt<R> {
    pub(crate) irradiance: R,
    pub(crate) gradient: R,
}

impl<R: Radius> Doubt<R> {
    pub(crate) fn none() -> Self {
        Self { irradiance: 0.0.into(), gradient: 0.0.into() }
    }

    /// Whether every decision was certain.
    pub(crate) fn is_none(&self) -> bool {
        self.irradiance == 0.0.into() && self.gradient == 0.0.into()
    }
}

/// A side of a cone: what generates it, and its edge where it is one of the input.
#[derive(Debug, Clone, Copy)]
struct ConeSide<T> {
    generator: Generator<T>,
    name: Option<EdgeName>,
}

/// A convex part of the emitter, by its corners in the emitter's plane: it is where `N . omega < 0` on all sides.
#[derive(Debug, Clone)]
struct Part<T>(Vec<Corner<T>>);

/// A corner of a part.
#[derive(Debug, Clone, Copy)]
struct Corner<T> {
    point: Vec3<T>,
    /// The vertex of the input that is seen there, where one is known to be.
    vertex: Option<DVec3>,
    /// The side that starts there.
    side: ConeSide<T>,
}

/// The shadow of a convex occluder: where `N . omega < 0` for all its lines.
struct Shadow<T> {
    lines: Vec<(Line<T>, Option<EdgeName>)>,
    corners: Vec<Vec3<T>>,
}

/// A part of what is seen: the arcs around it, each with whether its line and the next one's surely meet in space where the arcs
/// do, as they do at a vertex of the input.
pub(crate) type Outline<T> = Vec<(Arc<T>, bool)>;

/// What was found, and the doubt of the decisions taken.
type WithDoubt<T, Found> = (Found, Doubt<RadiusOf<T>>);

/// Calls `visit` with each arc of the visible boundary; returns the doubt of the decisions taken, or `None` where surely
/// nothing is visible.
pub(crate) fn visit_boundary<T: Real>(
    receiver: &Receiver,
    emitter: &Emitter,
    occluders: &[&Polygon],
    plan: &Plan,
    mut visit: impl FnMut(&Arc<T>),
) -> Option<Doubt<RadiusOf<T>>> {
    let (parts, doubt) = visible_parts(receiver, emitter, occluders, plan)?;
    for part in &parts {
        part.arcs().for_each(|arc| visit(&arc));
    }
    Some(doubt)
}

/// The parts of what is seen, and the doubt of the decisions taken; `None` where surely nothing is visible.
pub(crate) fn outlines<T: Real>(
    receiver: &Receiver,
    emitter: &Emitter,
    occluders: &[&Polygon],
    plan: &Plan,
) -> Option<WithDoubt<T, Vec<Outline<T>>>> {
    let (parts, doubt) = visible_parts(receiver, emitter, occluders, plan)?;
    Some((parts.iter().map(|part| part.arcs().zip(part.meetings()).collect()).collect(), doubt))
}

fn visible_parts<T: Real>(
    receiver: &Receiver,
    emitter: &Emitter,
    occluders: &[&Polygon],
    plan: &Plan,
) -> Option<WithDoubt<T, Vec<Part<T>>>> {
    let mut subtraction = Subtraction::<T>::new(receiver, emitter, plan);
    let mut parts: Vec<Part<T>> = convex_parts(emitter.polygon())
        .iter()
        .filter_map(|indices| subtraction.part_above_horizon(receiver, emitter.polygon(), indices, plan))
        .collect();
    for occluder in occluders {
        for indices in convex_parts(occluder) {
            let Some(shadow) = Shadow::new(receiver, emitter.polygon(), occluder, &indices, plan) else { continue };
            parts = parts.into_iter().flat_map(|part| subtraction.subtract(part, &shadow)).collect();
        }
    }
    let doubt = subtraction.doubt;
    (!parts.is_empty() || !doubt.is_none()).then_some((parts, doubt))
}

impl<T: Real> Part<T> {
    fn arcs(&self) -> impl Iterator<Item = Arc<T>> {
        let sighted = |corner: &Corner<T>| Sighted::at(corner.point);
        self.pairs().map(move |(start, end)| Arc::between(sighted(start), sighted(end), start.side.generator))
    }

    /// Whether each side surely meets the next in space. Lines of the emitter's plane do wherever they seem to, and lines that
    /// share a point nowhere else.
    fn meetings(&self) -> impl Iterator<Item = bool> {
        let sides = self.pairs().map(|(corner, next)| (&corner.side, &next.side));
        sides.map(|(side, next)| match (&side.generator, &next.generator, side.name, next.name) {
            (Generator::Emitter(_), Generator::Emitter(_), ..) => true,
            (_, _, Some(a), Some(b)) => a.shared_end(b).is_some() || a.is_on_the_line_of(b),
            _ => false,
        })
    }

    /// Each corner with the one after it.
    fn pairs(&self) -> impl Iterator<Item = (&Corner<T>, &Corner<T>)> {
        self.0.iter().zip(self.0.iter().cycle().skip(1))
    }
}

/// What bounds the doubt, and the doubt so far.
struct Subtraction<T: Real> {
    /// Height of the receiver over the emitter's plane, from below.
    height: RadiusOf<T>,
    /// Bound on `|B|`.
    emission: f64,
    /// Bound on `|grad B| (1 + 1/c)` over the emitter.
    steepness: RadiusOf<T>,
    doubt: Doubt<RadiusOf<T>>,
}

impl<T: Real> Subtraction<T> {
    fn new(receiver: &Receiver, emitter: &Emitter, plan: &Plan) -> Self {
        let polygon = emitter.polygon();
        let height: T = height_over_plane(receiver.position(), polygon, plan.power);
        let defect = RadiusOf::<T>::from(polygon.planarity_defect() * plan.power);
        let height = (height.size() * (1.0 - 2.0 * f64::EPSILON) - height.error() - defect).max(0.0.into());
        // Points of the emitter are at most 2 sqrt(3) away, so 1/c <= 4/h.
        let gradient = emitter.steepest_emission() * emitter.power() / plan.power * 1.01;
        let steepness = (RadiusOf::<T>::from(4.0) / height + 1.0.into()) * gradient;
        Self { height, emission: emitter.largest_emission() * emitter.power() * 1.01, steepness, doubt: Doubt::none() }
    }

    fn part_above_horizon(&mut self, receiver: &Receiver, polygon: &Polygon, indices: &[usize], plan: &Plan) -> Option<Part<T>> {
        let (x, power) = (receiver.position(), plan.power);
        let vertices: Vec<DVec3> = indices.iter().map(|&i| polygon.vertices()[i]).collect();
        let seen: Vec<Sighted<T>> = vertices.iter().map(|&v| Sighted::from(v, x, power)).collect();
        let corners = (0..vertices.len()).map(|i| {
            let j = (i + 1) % vertices.len();
            let line = Line::through([vertices[i], vertices[j]], [&seen[i], &seen[j]], x, power);
            let name = Some(EdgeName::new(vertices[i], vertices[j]));
            let side = ConeSide { generator: Generator::Emitter(line), name };
            Corner { point: seen[i].point, vertex: Some(vertices[i]), side }
        });
        let part = Part(corners.collect());
        let heights: Vec<T> = vertices.iter().map(|&v| height_over_horizon(receiver, v, power)).collect();
        let horizon = ConeSide { generator: Generator::Horizon(-unit_normal::<T>(receiver)), name: None };
        self.keep(&part, &heights, &horizon)
    }

    /// The parts of `part` outside `shadow`.
    fn subtract(&mut self, part: Part<T>, shadow: &Shadow<T>) -> Vec<Part<T>> {
        if shadow.misses(&part) {
            return vec![part];
        }
        let mut lit = Vec::new();
        let mut rest = part;
        for (line, name) in &shadow.lines {
            let [inside, outside] =
                [*line, line.reversed()].map(|line| ConeSide { generator: Generator::Occluder(line), name: *name });
            lit.extend(self.cut(&rest, &outside));
            match self.cut(&rest, &inside) {
                Some(inner) => rest = inner,
                None => break,
            }
        }
        lit
    }

    /// The part where `N . omega < 0` for the normal of `side`, if any.
    fn cut(&mut self, part: &Part<T>, side: &ConeSide<T>) -> Option<Part<T>> {
        let normal = side.generator.normal();
        let depth = |corner: &Corner<T>| {
            let depth = -normal.dot(corner.point);
            let is_on_it = || side.name.zip(corner.vertex).is_some_and(|(edge, vertex)| edge.is_in_line_with(vertex));
            if is_doubtful(depth) && is_on_it() { T::exact(0.0) } else { depth }
        };
        let depths: Vec<T> = part.0.iter().map(depth).collect();
        let on_one_line = |i: usize| {
            let (Some(own), Some(cutting)) = (part.0[i].side.name, side.name) else { return false };
            let is_small = |depth: T| depth.size() <= depth.error();
            let is_close = || is_small(depths[i]) && is_small(depths[(i + 1) % depths.len()]);
            own == cutting || (is_close() && own.is_on_the_line_of(cutting))
        };
        if let Some(i) = (0..depths.len()).find(|&i| on_one_line(i)) {
            let same_way = part.0[i].side.generator.normal().dot(normal).value() > 0.0;
            return same_way.then(|| part.clone());
        }
        self.keep(part, &depths, side)
    }

    /// The part of positive depth, closed along `cutting` (Sutherland and Hodgman 1974, on a cone).
    fn keep(&mut self, part: &Part<T>, depths: &[T], cutting: &ConeSide<T>) -> Option<Part<T>> {
        self.add_doubt(part, depths, cutting);
        let count = part.0.len();
        let inside = |i: usize| depths[i].value() > 0.0;
        // A part that a line only touches keeps its own edges, also one seen along that line: it lies elsewhere in space.
        let is_line = !matches!(cutting.generator, Generator::Horizon(_));
        if is_line && (0..count).any(inside) && depths.iter().all(|depth| depth.value() >= 0.0) {
            return Some(part.clone());
        }
        let mut kept = Vec::with_capacity(count + 1);
        for i in 0..count {
            let j = (i + 1) % count;
            let (start, end) = (part.0[i], part.0[j]);
            let crossing = |side: ConeSide<T>| {
                if is_exactly_0(depths[i]) || (is_doubtful(depths[i]) && is_doubtful(depths[j])) {
                    // Between two doubtful corners the cut may be anywhere, and the doubt covers any choice.
                    Corner { side, ..start }
                } else if is_exactly_0(depths[j]) {
                    Corner { side, ..end }
                } else {
                    let point = start.point + (end.point - start.point) * (depths[i] / (depths[i] - depths[j]));
                    // Lines that share a point are seen to meet there.
                    let vertex = start.side.name.zip(cutting.name).and_then(|(own, cutting)| own.shared_end(cutting));
                    Corner { point, vertex, side }
                }
            };
            match (inside(i), inside(j)) {
                (true, true) => kept.push(start),
                (true, false) => kept.extend([start, crossing(*cutting)]),
                (false, true) => kept.push(crossing(start.side)),
                (false, false) => {}
            }
        }
        (!kept.is_empty()).then_some(Part(kept))
    }

    /// Bounds what the other decision would change for corners whose depth may have either sign.
    ///
    /// The region in question is within `depth/h` of the cutting plane, in a hemisphere. Its boundary runs along the edges at the
    /// corner as far as the depth may vanish, and back along the cut.
    fn add_doubt(&mut self, part: &Part<T>, depths: &[T], side: &ConeSide<T>) {
        let count = part.0.len();
        let possible = |i: usize| depths[i].size() + depths[i].error();
        let half_turn = RadiusOf::<T>::from(std::f64::consts::PI);
        for i in 0..count {
            let j = (i + 1) % count;
            let (start, own) = (part.0[i].point, part.0[i].side);
            let end = part.0[j].point;
            let length = || (end - start).norm_squared().size().sqrt() * 1.01 / self.height;
            let (depth, weight) = match (is_doubtful(depths[i]), is_doubtful(depths[j])) {
                (false, false) => continue,
                (true, true) => {
                    let depth = possible(i).max(possible(j));
                    (depth, length().min(half_turn) * exchange(&own.generator, &side.generator, depth / self.height))
                }
                (first, _) => {
                    let (doubtful, other) = if first { (i, j) } else { (j, i) };
                    let depth = possible(doubtful);
                    let clear = depths[other].size() - depths[other].error() - depth;
                    let fraction = if clear > depth { depth / clear } else { 1.0.into() };
                    let length = (length() * fraction).min(half_turn);
                    (depth, length * (nearness(&own.generator) + nearness(&side.generator)))
                }
            };
            let area = (depth / self.height).min(1.0.into()) * std::f64::consts::TAU;
            self.doubt.irradiance = self.doubt.irradiance + area * self.emission;
            self.doubt.gradient = self.doubt.gradient + self.steepness * area + weight * self.emission;
        }
    }
}

/// How much a unit of arc weighs more or less in the gradient when it lies on the other of two lines that are seen within the
/// angle `near` of each other: an arc weighs `-(N/S) (toward.V)`, with `|V|` at most its length, and V itself moves by at most
/// four times `near`. Lines in space that coincide (edges with a T-junction) weigh the same; an edge in the horizon is seen
/// with `n1.omega` at most `near`.
fn exchange<T: Real>(own: &Generator<T>, cut: &Generator<T>, near: RadiusOf<T>) -> RadiusOf<T> {
    let moved = near * (nearness(own) + nearness(cut)) * 4.0;
    let (Generator::Emitter(own) | Generator::Occluder(own), Generator::Emitter(cut) | Generator::Occluder(cut)) = (own, cut)
    else {
        return moved;
    };
    let bound = |v: Vec3<T>| {
        let v = v.map(|c| c.size() + c.error());
        (v.x * v.x + v.y * v.y + v.z * v.z).sqrt()
    };
    let (own, cut) = (own.frame(), cut.frame());
    let facing = if own.normal.dot(cut.normal).value() < 0.0 { T::exact(-1.0) } else { T::exact(1.0) };
    let [own_weight, cut_weight] = [&own, &cut].map(|frame| frame.normal * (T::exact(1.0) / frame.distance));
    (bound(own_weight - cut_weight * facing) + bound(own.toward - cut.toward) * bound(cut_weight)) * 1.01 + moved
}

/// Whether the sign is not known. An exact zero is no doubt: a corner on the horizon.
fn is_doubtful<T: Real>(depth: T) -> bool {
    depth.error() > 0.0.into() && depth.size() <= depth.error()
}

fn is_exactly_0<T: Real>(depth: T) -> bool {
    depth.size() == 0.0.into() && depth.error() == 0.0.into()
}

/// Bound on `1/S` of a generating line; the horizon has none.
fn nearness<T: Real>(generator: &Generator<T>) -> RadiusOf<T> {
    match generator {
        Generator::Horizon(_) => 0.0.into(),
        Generator::Emitter(line) | Generator::Occluder(line) => {
            line.length.size() * 1.01 / (line.moment.size() - line.moment.error()).max(0.0.into())
        }
    }
}

impl<T: Real> Shadow<T> {
    /// The shadow of the part `indices` of `occluder`, or `None` where it casts none: seen edge-on, or not on the receiver's
    /// side of the emitter's plane.
    fn new(receiver: &Receiver, emitter: &Polygon, occluder: &Polygon, indices: &[usize], plan: &Plan) -> Option<Self> {
        let (x, power) = (receiver.position(), plan.power);
        let mut vertices: Vec<DVec3> = indices.iter().map(|&i| occluder.vertices()[i]).collect();
        match side_of(x, occluder, power) {
            Side::Front => {}
            Side::Back => vertices.reverse(),
            Side::InPlane => return None,
        }
        let sides: Vec<Side> = vertices.iter().map(|&v| side_of(v, emitter, power)).collect();
        if !sides.contains(&Side::Front) {
            return None;
        }
        let heights: Vec<T> = vertices.iter().map(|&v| height_over_plane(v, emitter, power)).collect();
        let seen: Vec<Sighted<T>> = vertices.iter().map(|&v| Sighted::from(v, x, power)).collect();
        let mut shadow = Self { lines: Vec::new(), corners: Vec::new() };
        let (mut sinks, mut rises) = (None, None);
        for i in 0..vertices.len() {
            let j = (i + 1) % vertices.len();
            let (from, to) = (vertices[i], vertices[j]);
            let start = seen[i].point;
            let line = Line::through([from, to], [&seen[i], &seen[j]], x, power);
            let touch = || start + line.e * (heights[i] / (heights[i] - heights[j]));
            match (sides[i], sides[j]) {
                (Side::Back, Side::Back | Side::InPlane) => {
                    if sides[j] == Side::InPlane {
                        rises = Some(seen[j].point);
                    }
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
            shadow.lines.push((line, Some(EdgeName::new(from, to))));
        }
        if let (Some(sink), Some(rise)) = (sinks, rises) {
            shadow.lines.push((waterline(sink, rise, emitter, occluder), None));
        }
        Some(shadow)
    }

    /// Whether one side of the shadow or of the part is known to separate them.
    fn misses(&self, part: &Part<T>) -> bool {
        let beyond = |normal: Vec3<T>, point: Vec3<T>| {
            let height = normal.dot(point);
            height.value() > 0.0 && height.size() > height.error()
        };
        self.lines.iter().any(|(line, _)| part.0.iter().all(|corner| beyond(line.normal, corner.point)))
            || part.0.iter().any(|own| self.corners.iter().all(|corner| beyond(own.side.generator.normal(), *corner)))
    }
}

/// The line in which the occluder meets the emitter's plane, from where it sinks below to where it rises.
fn waterline<T: Real>(sink: Vec3<T>, rise: Vec3<T>, emitter: &Polygon, occluder: &Polygon) -> Line<T> {
    let direction = emitter.unit_normal::<T>().cross(occluder.unit_normal());
    let direction = if direction.dot(rise - sink).value() < 0.0 { -direction } else { direction };
    Line::along(direction, sink)
}
