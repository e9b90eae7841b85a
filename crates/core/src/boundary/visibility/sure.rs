//! The visible boundary in doubles, where double precision is sure of every decision: most cases, for a small part of what it takes
//! with a bound on every number.
//!
//! The parts, the cuts and the arcs are those of [`crate::boundary::visibility`]. A sign that is not sure, an occluder that is not
//! wholly before the emitter, an outline that is not seen convex, and numbers that may have under- or overflowed leave the case to
//! scalars that bound their errors.
//!
//! | symbol | meaning | error |
//! |---|---|---|
//! | p | a point on the ray of a direction | `delta |p|`, up to a factor: its SPREAD; `sigma |p|` along the sides that meet there |
//! | N | normal of a side | `en` across itself; u = 2^-53 |
//!
//! - A vertex less x errs by u in each component: `delta = sigma = u`.
//! - A side's `en` is `ew + u` ([`Line::relative_error`], and the rounding of N), that of the horizon 2u. The 3.5u by which N errs
//!   along itself change no direction and no sign.
//! - `N.p` errs by `(en + delta + 3u) |p|`: three products and two sums, by Cauchy's inequality.
//! - Two sides cross in `N x N'`. Each component is a difference of two products and errs by u of the sum of their sizes and u of
//!   itself, so the vector by 2.2u (the vector of those sums is at most `(4/3)^(1/2)` long): `delta = (en + en' + 2.2u)/|N x N'|`.
//! - A side that is off by en' across the other one moves their crossing along that by `en'/|N x N'|`, and along itself by
//!   `|N.N'|` times that: `sigma = (max(en, en') + min(en, en') |N.N'| + 2.2u)/|N x N'|` along both.
//! - Seen along the side it runs from inside to outside where that is turned round: along the arc `p' = N x p`, and the depth
//!   `-N'.p` of `p = -N x N'` changes by `(N.N')^2 - 1 < 0`.
//!
//! An outline of which every side has all other corners surely inside is convex, and all surfaces through its vertices within their
//! hull are seen within it: whether the vertices are in one plane does not matter.
//!
//! What is decided holds for any scalar: [`arcs`] takes the sides from the edges that they are of, and corners from vertices or from
//! the two sides that cross there, in the scalar that is asked for.

use std::cell::{OnceCell, RefCell};

use glam::DVec3;
use radgrad_numbers::number::ROUNDOFF;
use radgrad_numbers::offset::offset;
use radgrad_numbers::real::Real;
use radgrad_numbers::vec3::Vec3;
use smallvec::SmallVec;

use crate::boundary::arc::{Arc, Generator};
use crate::boundary::edge_name::EdgeName;
use crate::boundary::line::{LEAST_MOMENT, Line, Sighted};
use crate::boundary::plan::{Horizon, Plan, Side, height_over_horizon, sure_side};
use crate::boundary::visibility::boundary::visit_joined;
use crate::boundary::visibility::part::{Facing, PartCorner, pairs};
use crate::boundary::visibility::separation::CircularCone;
use crate::boundary::visibility::subtract::{Kept, Place, kept, side_on_the_line};
use crate::problem::polygon::Polygon;
use crate::problem::receiver::{Receiver, unit_normal};
use crate::problem::triangulate::convex_parts;

/// An arc, with what its ends and its plane are off by.
pub(crate) struct SureArc {
    /// With every line taken for an occluder's: its ends are directions, not points of the line.
    pub(crate) arc: Arc<f64>,
    /// delta of both ends.
    pub(crate) spreads: [f64; 2],
    /// sigma of both ends.
    pub(crate) slips: [f64; 2],
    /// `en`.
    pub(crate) normal_error: f64,
}

/// Largest spread with which anything is sure.
const MOST_SPREAD: f64 = 1e-6;

/// A direction, through a point on its ray.
#[derive(Debug, Clone, Copy)]
struct Ray {
    sighted: Sighted<f64>,
    /// delta.
    spread: f64,
    /// sigma.
    slip: f64,
}

/// A plane through the receiver.
struct SureSide {
    generator: Generator<f64>,
    name: Option<EdgeName>,
    /// `en`.
    error: f64,
}

/// All that bounds a part, each once.
struct SureSides<'a> {
    receiver: &'a Receiver,
    plan: &'a Plan,
    sides: Vec<SureSide>,
    /// Whether there are several shadows, so that it pays to know circular cones.
    has_many: bool,
}

/// A convex cone: a part of the emitter, or the shadow of an occluder.
struct Cone {
    corners: Vec<PartCorner<Ray>>,
    around: Option<CircularCone>,
}

/// Where a part is relative to a side.
enum Cut {
    Inside,
    Outside,
    /// It has corners on both sides, or on the line.
    Across,
}

/// Where a part's boundary crosses a side, by the corner before: both of the parts that the side cuts it into have these corners.
type Crossings = RefCell<SmallVec<[(usize, Ray); 2]>>;

/// Why nothing is sure is not told.
struct Unsure;

/// How far occluders hide an emitter.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Hidden {
    /// Surely not at all.
    Nothing,
    /// In part or wholly: the arcs of what is left were visited.
    Something,
    /// Double precision is not sure.
    Unsure,
}

impl Ray {
    /// Where it is relative to a plane: its height on the side of the normal, if the sign is sure.
    fn sure_height(&self, normal: Vec3<f64>, error: f64) -> Option<f64> {
        let (height, length) = (normal.dot(self.sighted.point), self.sighted.square * self.sighted.inverse);
        let unsure = mutant!("sure.height", (error + self.spread + 4.0 * ROUNDOFF) * length * 1.001, |unsure| 1e-3 * unsure);
        (height.abs() > unsure).then_some(height)
    }

    fn unit(&self) -> DVec3 {
        (self.sighted.point * self.sighted.inverse).into()
    }
}

impl SureSides<'_> {
    /// A part of these corners.
    fn part(&self, corners: Vec<PartCorner<Ray>>) -> Cone {
        let around = || CircularCone::around(corners.iter().map(|corner| (corner.point.unit(), 4.0 * MOST_SPREAD)));
        Cone { around: if self.has_many { around() } else { None }, corners }
    }

    fn name(&self, facing: Facing) -> Option<EdgeName> {
        self.sides[facing.side].name
    }

    fn error(&self, facing: Facing) -> f64 {
        self.sides[facing.side].error
    }

    fn generator(&self, facing: Facing) -> Generator<f64> {
        let generator = self.sides[facing.side].generator;
        if facing.is_reversed() { generator.reversed() } else { generator }
    }

    fn normal(&self, facing: Facing) -> Vec3<f64> {
        let normal = self.sides[facing.side].generator.normal();
        if facing.is_reversed() { -normal } else { normal }
    }

    /// Height of a ray over a side, where its sign is sure.
    fn height(&self, facing: Facing, ray: &Ray) -> Option<f64> {
        ray.sure_height(self.normal(facing), self.error(facing))
    }

    fn ray(&self, vertex: DVec3) -> Ray {
        Ray { sighted: Sighted::from(vertex, self.receiver.position(), self.plan.power), spread: ROUNDOFF, slip: ROUNDOFF }
    }

    /// The shadow of an outline, whichever way that runs.
    fn shadow(&mut self, count: usize, vertex: impl Fn(usize) -> DVec3) -> Result<Cone, Unsure> {
        let [a, b, c] = [0, 1, 2].map(|i| vertex(i) - self.receiver.position());
        if a.cross(b).dot(c) > 0.0 { self.cone(count, |i| vertex(count - 1 - i)) } else { self.cone(count, vertex) }
    }

    /// The cone of an outline, where `N . omega < 0` on all sides.
    fn cone(&mut self, count: usize, vertex: impl Fn(usize) -> DVec3) -> Result<Cone, Unsure> {
        let (x, power, known) = (self.receiver.position(), self.plan.power, self.sides.len());
        let corner = |i| PartCorner { point: self.ray(vertex(i)), vertex: Some(vertex(i)), side: Facing::forward(known + i) };
        let corners: Vec<PartCorner<Ray>> = (0..count).map(corner).collect();
        for i in 0..count {
            let (j, ray) = ((i + 1) % count, |k: usize| &corners[k].point);
            let edge = [vertex(i), vertex(j)];
            let line = Line::through(edge, [&ray(i).sighted, &ray(j).sighted], x, power);
            let error = line.relative_error() + ROUNDOFF;
            let is_known = error <= MOST_SPREAD && (LEAST_MOMENT..1.0 / LEAST_MOMENT).contains(&line.moment);
            let is_inside = |ray: &Ray| ray.sure_height(line.normal, error).is_some_and(|height| height < 0.0);
            if !is_known || !(0..count).all(|k| k == i || k == j || is_inside(ray(k))) {
                return Err(Unsure);
            }
            let name = Some(EdgeName::new(edge[0], edge[1]));
            self.sides.push(SureSide { generator: Generator::Occluder(line), name, error });
        }
        Ok(self.part(corners))
    }

    /// Whether one side of the shadow or of the part is known to separate them.
    fn misses(&self, shadow: &Cone, part: &Cone) -> bool {
        let is_beyond = |side: Facing, ray: &Ray| self.height(side, ray).is_some_and(|height| height > 0.0);
        let parts = |one: &Cone, other: &Cone| {
            one.corners.iter().any(|side| other.corners.iter().all(|corner| is_beyond(side.side, &corner.point)))
        };
        CircularCone::are_apart(shadow.around, part.around) || parts(shadow, part) || parts(part, shadow)
    }

    /// Adds the parts of `part` outside `shadow`.
    fn subtract(&self, part: Cone, shadow: &Cone, lit: &mut Vec<Cone>) -> Result<(), Unsure> {
        let mut rest = part;
        let mut places = SmallVec::new();
        for (number, corner) in shadow.corners.iter().enumerate() {
            match self.place(&rest, corner.side, &mut places)? {
                Cut::Inside => continue,
                Cut::Outside => {
                    lit.push(rest);
                    return Ok(());
                }
                Cut::Across => {}
            }
            // What is inside all sides is in the shadow.
            let is_last = number + 1 == shadow.corners.len();
            let crossings = Crossings::default();
            let inner = if is_last { Kept::Nothing } else { self.keep(&rest, &places, corner.side, &crossings)? };
            places.iter_mut().for_each(|place| place.depth = -place.depth);
            match self.keep(&rest, &places, corner.side.reversed(), &crossings)? {
                Kept::Nothing => {}
                Kept::Whole => {
                    lit.push(rest);
                    return Ok(());
                }
                Kept::Corners(corners) => lit.push(self.part(corners)),
            }
            match inner {
                Kept::Nothing => return Ok(()),
                Kept::Whole => {}
                Kept::Corners(corners) => rest = self.part(corners),
            }
        }
        Ok(())
    }

    /// Where a part is relative to a side, with the places of its corners where that cuts it.
    fn place(&self, part: &Cone, side: Facing, places: &mut SmallVec<[Place; 8]>) -> Result<Cut, Unsure> {
        let (normal, error, name) = (self.normal(side), self.error(side), self.name(side));
        let place = |corner: &PartCorner<Ray>| {
            let height = corner.point.sure_height(normal, error);
            let is_on_it = height.is_none() && name.zip(corner.vertex).is_some_and(|(edge, vertex)| edge.is_in_line_with(vertex));
            Place {
                depth: height.map_or(0.0, |height| -height),
                is_exactly_on_it: is_on_it,
                is_doubtful: height.is_none() && !is_on_it,
            }
        };
        places.clear();
        places.extend(part.corners.iter().map(place));
        if places.iter().all(|place| place.depth > 0.0) {
            return Ok(Cut::Inside);
        }
        if places.iter().all(|place| place.depth < 0.0) {
            return Ok(Cut::Outside);
        }
        // What is on the line has corners of which the depth is not sure.
        let is_small = |i: usize| places[i].depth == 0.0;
        if (0..places.len()).any(is_small) {
            if let Some(i) = side_on_the_line(&part.corners, |facing| self.name(facing), name, is_small) {
                let same_way = self.normal(part.corners[i].side).dot(normal) > 0.0;
                return Ok(if same_way { Cut::Inside } else { Cut::Outside });
            }
            if places.iter().any(|place| place.is_doubtful) {
                return Err(Unsure);
            }
        }
        Ok(Cut::Across)
    }

    /// The part of positive depth, closed along `side`, given the crossings that are known.
    fn keep(&self, part: &Cone, places: &[Place], side: Facing, crossings: &Crossings) -> Result<Kept<Ray>, Unsure> {
        let is_line = !matches!(self.sides[side.side].generator, Generator::Horizon(_));
        let crossing = |i: usize, _| {
            let mut crossings = crossings.borrow_mut();
            let known = crossings.iter().find(|(before, _)| *before == i).map(|(_, ray)| *ray);
            known.unwrap_or_else(|| {
                let ray = self.crossing(part.corners[i].side, side, places[i].depth > 0.0);
                crossings.push((i, ray));
                ray
            })
        };
        let left = kept(&part.corners, places, side, is_line, |facing| self.name(facing), crossing);
        match &left {
            Kept::Corners(corners) if corners.iter().any(|corner| corner.point.spread.is_nan()) => Err(Unsure),
            _ => Ok(left),
        }
    }

    /// Where the boundary along a side crosses another one, from its inside or from its outside; of a spread that is not a number
    /// where that is not sure.
    fn crossing(&self, own: Facing, cutting: Facing, from_inside: bool) -> Ray {
        let across = self.normal(own).cross(self.normal(cutting));
        let sighted = Sighted::at(if from_inside { -across } else { across });
        let (one, other) = (self.error(own), self.error(cutting));
        let (most, least) = if one > other { (one, other) } else { (other, one) };
        let over_sine = |errors: f64| (errors + 2.2 * ROUNDOFF) * sighted.inverse * 1.001;
        let spread = mutant!("sure.crossing", over_sine(one + other), |spread| 0.1 * spread);
        let cosine = self.normal(own).dot(self.normal(cutting)).abs();
        let slip = mutant!("sure.slip", over_sine(most + least * cosine), |slip| 0.1 * slip);
        Ray { sighted, spread: if spread <= MOST_SPREAD { spread } else { f64::NAN }, slip }
    }
}

/// The lit parts, and the sides that bound them; none where all is lit that is above the horizon.
fn lit_parts<'a>(
    receiver: &'a Receiver,
    emitter: &Polygon,
    occluders: &[&Polygon],
    plan: &'a Plan,
) -> Result<Option<(Vec<Cone>, SureSides<'a>)>, Unsure> {
    let has_many = occluders.len() > 1;
    let mut sides = SureSides { receiver, plan, sides: Vec::with_capacity(4 * (occluders.len() + 1)), has_many };
    let mut whole = sides.cone(emitter.vertices().len(), |i| emitter.vertices()[i])?;
    if plan.horizon == Horizon::Crossing {
        let generator = Generator::Horizon(-unit_normal::<f64>(receiver));
        let horizon = Facing::forward(sides.sides.len());
        sides.sides.push(SureSide { generator, name: None, error: 2.0 * ROUNDOFF });
        let place = |&vertex: &DVec3| {
            let depth: f64 = height_over_horizon(receiver, vertex, plan.power);
            Place { depth, is_exactly_on_it: depth == 0.0, is_doubtful: false }
        };
        let places: Vec<Place> = emitter.vertices().iter().map(place).collect();
        match sides.keep(&whole, &places, horizon, &Crossings::default())? {
            Kept::Nothing => return Ok(Some((Vec::new(), sides))),
            Kept::Whole => {}
            Kept::Corners(corners) => whole = sides.part(corners),
        }
    }
    let slab = emitter.half_slab() * plan.power * 1.01;
    let mut shadows = Vec::with_capacity(occluders.len());
    for occluder in occluders {
        for part in convex_parts(occluder) {
            let shadow = sides.shadow(part.len(), |i| occluder.vertices()[part[i]])?;
            if sides.misses(&shadow, &whole) {
                continue;
            }
            let is_before = |&i: &usize| sure_side(occluder.vertices()[i], emitter, plan.power, slab) == Some(Side::Front);
            if !part.iter().all(is_before) {
                return Err(Unsure);
            }
            shadows.push(shadow);
        }
    }
    if shadows.is_empty() {
        return Ok(None);
    }
    // The widest first: the sooner they are subtracted, the fewer parts the others cut. Doubles that are not negative are in the
    // order of their bits.
    shadows.sort_by_cached_key(|shadow| shadow.around.map_or(0, |cone| cone.cosine().to_bits()));
    let (mut parts, mut lit) = (Vec::with_capacity(4), Vec::with_capacity(4));
    parts.push(whole);
    for (number, shadow) in shadows.iter().enumerate() {
        for part in parts.drain(..) {
            // None of them misses the whole.
            if number > 0 && sides.misses(shadow, &part) {
                lit.push(part);
            } else {
                sides.subtract(part, shadow, &mut lit)?;
            }
        }
        std::mem::swap(&mut parts, &mut lit);
    }
    Ok(Some((parts, sides)))
}

/// Calls `visit` with each arc of the visible boundary, unless a decision is not sure or nothing is hidden.
pub(crate) fn visit_boundary(
    receiver: &Receiver,
    emitter: &Polygon,
    occluders: &[&Polygon],
    plan: &Plan,
    mut visit: impl FnMut(&SureArc),
) -> Hidden {
    let (parts, sides) = match lit_parts(receiver, emitter, occluders, plan) {
        Ok(Some(found)) => found,
        Ok(None) => return Hidden::Nothing,
        Err(Unsure) => return Hidden::Unsure,
    };
    let mut visit = |from: &Ray, to: &Ray, facing: Facing| {
        visit(&SureArc {
            arc: Arc::between(from.sighted, to.sighted, sides.generator(facing)),
            spreads: [from.spread, to.spread],
            slips: [from.slip, to.slip],
            normal_error: sides.error(facing),
        });
    };
    if let [part] = &parts[..] {
        pairs(&part.corners).for_each(|(start, end)| visit(&start.point, &end.point, start.side));
    } else {
        let outlines: SmallVec<[_; 16]> = parts.iter().map(|part| &*part.corners).collect();
        visit_joined(&outlines, |side| sides.normal(Facing::forward(side)), |ray| ray.sighted.point, visit);
    }
    Hidden::Something
}

/// A corner in doubles, and as it is in another scalar.
struct Placed<T> {
    ray: Vec3<f64>,
    sighted: Sighted<T>,
}

impl SureSides<'_> {
    /// The generator of a side in another scalar.
    fn generator_in<T: Real>(&self, side: usize) -> Generator<T> {
        let (x, power, side) = (self.receiver.position(), self.plan.power, &self.sides[side]);
        match (side.generator, side.name) {
            (Generator::Emitter(line) | Generator::Occluder(line), Some(name)) => {
                let [a, b] = name.ends();
                let edge = if line.e.dot(offset(b, a, power)) > 0.0 { [a, b] } else { [b, a] };
                let [from, to] = edge.map(|end| Sighted::from(end, x, power));
                Generator::Occluder(Line::through(edge, [&from, &to], x, power))
            }
            _ => Generator::Horizon(-unit_normal(self.receiver)),
        }
    }
}

/// The arcs of the visible boundary, with every line taken for an occluder's; `None` where double precision is not sure, or nothing is
/// hidden.
pub(crate) fn arcs<T: Real>(receiver: &Receiver, emitter: &Polygon, occluders: &[&Polygon], plan: &Plan) -> Option<Vec<Arc<T>>> {
    let Ok(Some((parts, sides))) = lit_parts(receiver, emitter, occluders, plan) else { return None };
    let generators: Vec<OnceCell<Generator<T>>> = vec![OnceCell::new(); sides.sides.len()];
    let generator = |facing: Facing| {
        let forward = *generators[facing.side].get_or_init(|| sides.generator_in(facing.side));
        if facing.is_reversed() { forward.reversed() } else { forward }
    };
    let is_before = |sighted: &Sighted<T>, ray: &Ray| sighted.point.map(T::value).dot(ray.sighted.point) > 0.0;
    let placed = |before: &PartCorner<Ray>, corner: &PartCorner<Ray>| {
        let crossing = || {
            let across = generator(before.side).normal().cross(generator(corner.side).normal());
            [across, -across].map(Sighted::at).into_iter().find(|sighted| is_before(sighted, &corner.point))
        };
        let seen = corner.vertex.map(|vertex| Sighted::from(vertex, receiver.position(), plan.power));
        let sighted = seen.filter(|sighted| is_before(sighted, &corner.point)).or_else(crossing)?;
        Some(PartCorner { point: Placed { ray: corner.point.sighted.point, sighted }, vertex: corner.vertex, side: corner.side })
    };
    let outline = |part: &Cone| pairs(&part.corners).map(|(before, corner)| placed(before, corner)).collect::<Option<Vec<_>>>();
    let outlines: Vec<Vec<PartCorner<Placed<T>>>> = parts.iter().map(outline).collect::<Option<_>>()?;
    let outlines: Vec<_> = outlines.iter().map(|corners| &**corners).collect();
    let mut arcs = Vec::new();
    visit_joined(
        &outlines,
        |side| sides.normal(Facing::forward(side)),
        |placed| placed.ray,
        |from, to, facing| arcs.push(Arc::between(from.sighted, to.sighted, generator(facing))),
    );
    Some(arcs)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::problem::emission::{Emission, Emitter};

    /// A number in [0, 1) of a lattice without structure.
    fn spread(i: usize, step: f64) -> f64 {
        (i as f64 * step).fract()
    }

    fn triangle(i: usize, size: f64, height: f64) -> Polygon {
        let [x, y, z] = [0.618_034, 0.754_878, 0.569_84].map(|step| spread(i, step));
        let corners = [[x, y, 0.1 * z], [x + 0.5 * size, y + size, 0.15 * z], [x + size, y + 0.25 * size, 0.2 * z]];
        Polygon::new(corners.map(|[x, y, z]| DVec3::new(x, y, height + z)).to_vec()).unwrap()
    }

    #[test]
    fn most_cases_are_sure() {
        let lamp = Emitter::new(triangle(0, 1.0, 1.0), Emission::Constant(1.0)).unwrap();
        let (mut sure, mut all) = (0, 0);
        for i in 0..400 {
            let place = DVec3::new(spread(i, 0.324_718), spread(i, 0.414_214), -0.5);
            let receiver = Receiver::new(place, DVec3::new(0.2, -0.1, 1.0), 0.5).unwrap();
            let screens: Vec<Polygon> = (1..=1 + i % 5).map(|k| triangle(i * 7 + k, 0.3, 0.3)).collect();
            let Some(plan) = Plan::new(&receiver, lamp.polygon()) else { continue };
            all += 1;
            let occluders: Vec<&Polygon> = screens.iter().collect();
            sure += usize::from(visit_boundary(&receiver, lamp.polygon(), &occluders, &plan, |_| ()) != Hidden::Unsure);
        }
        assert!(all > 300 && sure * 100 > 98 * all, "{sure} of {all}");
    }
}
