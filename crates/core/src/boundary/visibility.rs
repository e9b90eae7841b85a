//! The boundary of the part of an emitter that occluders leave visible.
//!
//! Seen from x, a convex part of the emitter above the horizon is a convex cone, and so is the shadow of a convex occluder, cut
//! off at the emitter's plane. Subtracting a shadow leaves the parts outside its side k and inside its sides before k. The
//! seams between those parts lie on occluder lines and run once each way, so that they cancel in every sum over arcs.
//! The largest occluders come first, and an occluder that surely hides nothing of the parts that are left costs a look in double
//! precision ([`separation`]).
//!
//! Where double precision is sure of all decisions [`sure`] finds the same parts in plain doubles.
//!
//! Edges on one line (in a mesh of occluders and at its T-junctions, or where an occluder stands on the emitter's edge) are
//! decided exactly ([`crate::boundary::edge_name`]). Elsewhere a corner may be within rounding of a shadow's side; then the
//! middle of its ball decides, and [`Uncertainty`] bounds the change that the other decision would have made; [`not_flat`] bounds
//! that of other surfaces through vertices that are not in one plane.

mod boundary;
pub(crate) mod not_flat;
mod part;
mod separation;
mod shadow;
mod subtract;
pub(crate) mod sure;
pub(crate) mod uncertainty;

use std::cmp::Reverse;

use glam::DVec3;
use radgrad_numbers::effort;
use radgrad_numbers::real::{RadiusOf, Real};

use crate::boundary::arc::Arc;
use crate::boundary::origin::Origin;
use crate::boundary::plan::{Plan, Side, least_sure_height, side_of, sure_side};
use crate::boundary::visibility::not_flat::is_seen_convex;
use crate::boundary::visibility::part::{Sides, VisiblePart};
use crate::boundary::visibility::separation::{BoundingCone, CircularCone};
use crate::boundary::visibility::shadow::{Screen, Shadow};
use crate::boundary::visibility::subtract::Subtraction;
use crate::boundary::visibility::uncertainty::Uncertainty;
use crate::problem::emission::Emitter;
use crate::problem::polygon::Polygon;
use crate::problem::receiver::Receiver;
use crate::problem::triangulate::{Few, convex_parts};

/// One visible part: the arcs around it, each with whether its line and the next one's surely meet in space where the arcs do, as
/// they do at a vertex of the input.
pub(crate) type Outline<T> = Vec<(Arc<T>, bool)>;

/// An arc, with the line of the input that it is on.
type Traced<T> = (Arc<T>, Origin);

/// A result, with the uncertainty that the decisions left.
type WithUncertainty<T, R> = (R, Uncertainty<RadiusOf<T>>);

/// The arcs of the visible boundary and the uncertainty that the decisions left, or `None` where surely nothing is visible.
pub(crate) fn arcs<T: Real>(
    receiver: &Receiver,
    emitter: &Emitter,
    occluders: &[&Polygon],
    plan: &Plan,
) -> Option<WithUncertainty<T, Vec<Arc<T>>>> {
    let Visible { parts, sides, uncertainty } = visible(receiver, emitter, occluders, plan)?;
    Some((boundary::arcs(&parts, &sides), uncertainty))
}

/// The same, each arc with the line of the input that it is on.
pub(crate) fn arcs_with_origins<T: Real>(
    receiver: &Receiver,
    emitter: &Emitter,
    occluders: &[&Polygon],
    plan: &Plan,
) -> Option<WithUncertainty<T, Vec<Traced<T>>>> {
    let Visible { parts, sides, uncertainty } = visible(receiver, emitter, occluders, plan)?;
    Some((boundary::arcs_with_origins(&parts, &sides), uncertainty))
}

/// The occluders that may hide some of the emitter, by circular cones: double precision is sure of the others that they are wholly
/// below the receiver's horizon, behind the emitter, or seen apart from it.
pub(crate) fn near_by<'a>(receiver: &Receiver, emitter: &Polygon, occluders: &[&'a Polygon], plan: &Plan) -> Few<&'a Polygon> {
    let (x, n1, slab) = (receiver.position(), receiver.direction(), emitter.half_slab() * plan.power * 1.01);
    let is_below = |v: &DVec3| {
        let r = (*v - x) * plan.power;
        n1.dot(r) < -least_sure_height(r.abs().max_element())
    };
    let is_behind = |v: &DVec3| sure_side(*v, emitter, plan.power, slab) == Some(Side::Back);
    let lit = CircularCone::of_points(x, emitter.vertices());
    let may_hide = |occluder: &&&Polygon| {
        let vertices = occluder.vertices();
        // All of it is within the cone of its vertices.
        !(vertices.iter().all(is_below)
            || vertices.iter().all(is_behind)
            || CircularCone::are_apart(CircularCone::of_points(x, vertices), lit))
    };
    occluders.iter().filter(may_hide).copied().collect()
}

/// The occluders that may hide some of the emitter, or whose shadow is uncertain: no plane through the receiver surely has
/// the emitter on its other side. No rung needs to look at the others again.
pub(crate) fn in_between<'a>(receiver: &Receiver, emitter: &Polygon, occluders: &[&'a Polygon], plan: &Plan) -> Vec<&'a Polygon> {
    let x = receiver.position();
    let corners = |polygon: &Polygon, part: &[usize]| -> Few<DVec3> { part.iter().map(|&i| polygon.vertices()[i]).collect() };
    let is_cone = |polygon: &Polygon, outline: &[DVec3]| polygon.half_slab() == 0.0 || is_seen_convex(x, polygon, outline, plan);
    let outlines: Few<Few<DVec3>> = convex_parts(emitter).iter().map(|part| corners(emitter, part)).collect();
    if !outlines.iter().all(|outline| is_cone(emitter, outline)) {
        return occluders.to_vec();
    }
    let lit: Few<BoundingCone> = outlines.iter().map(|outline| BoundingCone::of_polygon(x, outline)).collect();
    let may_hide = |occluder: &&&Polygon| {
        let side = side_of(x, occluder, plan.power);
        convex_parts(occluder).iter().any(|part| {
            let mut outline = corners(occluder, part);
            if side == Side::InPlane || !is_cone(occluder, &outline) {
                return true;
            }
            if side == Side::Back {
                outline.reverse();
            }
            let cone = BoundingCone::of_polygon(x, &outline);
            !lit.iter().all(|part| cone.misses(part))
        })
    };
    occluders.iter().filter(may_hide).copied().collect()
}

/// Whether the light may have a kink as a flat occluder turns: the receiver is exactly in its plane, which meets the emitter, and no circular cones tell
/// the two apart. Edge on, the occluder hides nothing; turned either way, it does.
pub(crate) fn is_edge_on(receiver: &Receiver, emitter: &Polygon, occluder: &Polygon, plan: &Plan) -> bool {
    let x = receiver.position();
    let sides_of = |polygon: &Polygon, plane: &Polygon| -> Few<Side> {
        polygon.vertices().iter().map(|&vertex| side_of(vertex, plane, plan.power)).collect()
    };
    let one_side = |sides: &[Side], side: Side| sides.iter().all(|&other| other == side);
    if occluder.half_slab() > 0.0 || side_of(x, occluder, plan.power) != Side::InPlane {
        return false;
    }
    let lamp = sides_of(emitter, occluder);
    let cones = [occluder, emitter].map(|polygon| CircularCone::of_points(x, polygon.vertices()));
    !one_side(&lamp, Side::Front)
        && !one_side(&lamp, Side::Back)
        && sides_of(occluder, emitter).contains(&Side::Front)
        && !CircularCone::are_apart(cones[0], cones[1])
}

/// The visible parts, and the uncertainty that the decisions left; `None` where surely nothing is visible.
pub(crate) fn outlines<T: Real>(
    receiver: &Receiver,
    emitter: &Emitter,
    occluders: &[&Polygon],
    plan: &Plan,
) -> Option<WithUncertainty<T, Vec<Outline<T>>>> {
    let Visible { parts, sides, uncertainty } = visible(receiver, emitter, occluders, plan)?;
    Some((parts.iter().map(|part| part.arcs(&sides).zip(part.meetings(&sides)).collect()).collect(), uncertainty))
}

/// The visible parts, the sides that bound them, and the uncertainty that the decisions left.
struct Visible<T: Real> {
    parts: Vec<VisiblePart<T>>,
    sides: Sides<T>,
    uncertainty: Uncertainty<RadiusOf<T>>,
}

/// Operations of a look whether an occluder may hide some of a part, and of the comparison of a corner with a side of its shadow.
const LOOK: u64 = 8;
const CUT: u64 = 64;

/// The visible parts; `None` where surely nothing is visible.
fn visible<T: Real>(receiver: &Receiver, emitter: &Emitter, occluders: &[&Polygon], plan: &Plan) -> Option<Visible<T>> {
    let mut subtraction = Subtraction::<T>::new(receiver, emitter, plan);
    let mut parts: Vec<VisiblePart<T>> = convex_parts(emitter.polygon())
        .iter()
        .filter_map(|indices| subtraction.part_above_horizon(emitter.polygon(), indices))
        .collect();
    for screen in in_the_way(receiver, emitter.polygon(), occluders, plan, &parts) {
        if parts.is_empty() || !effort::spend(LOOK * parts.len() as u64) {
            break;
        }
        if parts.iter().all(|part| screen.misses(&part.cone)) {
            continue;
        }
        if let Some(doubt) = &screen.doubt {
            subtraction.add_doubt(doubt, parts.iter().filter(|part| !screen.misses(&part.cone)));
        }
        if !screen.casts_shadow() {
            continue;
        }
        let shadow = Shadow::new(receiver, emitter.polygon(), &screen, plan, &mut subtraction.sides);
        let mut lit = Vec::with_capacity(parts.len() + 2);
        for part in parts {
            if screen.cone.misses(&part.cone) || shadow.misses(&part, &subtraction.sides) {
                lit.push(part);
            } else {
                effort::spend(CUT * (part.corners.len() * shadow.lines.len()) as u64);
                subtraction.subtract(part, &shadow, &mut lit);
            }
        }
        parts = lit;
    }
    let Subtraction { sides, uncertainty, .. } = subtraction;
    (!parts.is_empty() || !uncertainty.is_none()).then_some(Visible { parts, sides, uncertainty })
}

/// The convex parts of the occluders that may hide some of the emitter, the largest as seen from the receiver first: the sooner
/// they are subtracted, the fewer parts the others cut.
fn in_the_way<'a, T>(
    receiver: &Receiver,
    emitter: &Polygon,
    occluders: &[&'a Polygon],
    plan: &Plan,
    whole: &[VisiblePart<T>],
) -> Vec<Screen<'a>> {
    let mut screens = Vec::with_capacity(occluders.len());
    for (index, &occluder) in occluders.iter().enumerate() {
        let screen = |indices: Few<usize>| Screen::new(receiver, emitter, (index, occluder), &indices, plan);
        let may_hide = |screen: &Screen<'_>| !whole.iter().all(|part| screen.misses(&part.cone));
        let screens_between = convex_parts(occluder).into_iter().filter_map(screen).filter(may_hide);
        screens.extend(screens_between);
    }
    // Doubles that are not negative are in the order of their bits.
    screens.sort_by_cached_key(|screen: &Screen<'_>| Reverse(screen.cone.size().to_bits()));
    screens
}
