//! The visible boundary in doubles, where double precision is sure of every decision: most cases, for a small part of the cost
//! with a bound on every number.
//!
//! The visible part is bounded by pieces of the emitter's sides that are in no shadow, and by pieces of the shadows' sides, turned
//! round, that are within the emitter and in no other shadow. A side cuts a piece where its ends are on both of its sides. A sign
//! that is not sure, an occluder that is not wholly before the emitter, an outline that is not seen convex, and numbers that may
//! have under- or overflowed leave the case to scalars that bound their errors.
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
//! Sides of one line of the input, as in a mesh of occluders or where one stands on the emitter's edge, cut nothing off each other.
//! A piece along a side of another cone counts as within it: of an emitter's it is dark where the shadow is on the emitter's side of
//! it, of a shadow's where the other shadow is beyond it, and where both are on one side in one of the two; none is within the emitter.
//!
//! An outline of which every side has all other corners surely inside is convex, and all surfaces through its vertices within their
//! hull are seen within it: whether the vertices are in one plane does not matter.
//!
//! The decisions hold for any scalar: [`arcs`] takes the sides from the edges that they are of, and corners from vertices or from
//! the two sides that cross there, in the scalar that is requested.

use std::cell::OnceCell;
use std::ops::Range;

use glam::DVec3;
use radgrad_numbers::effort;
use radgrad_numbers::number::ROUNDOFF;
use radgrad_numbers::real::Real;
use radgrad_numbers::vec3::Vec3;
use smallvec::SmallVec;

use crate::boundary::arc::{Arc, Generator};
use crate::boundary::edge_name::EdgeName;
use crate::boundary::line::{LEAST_MOMENT, Line, Sighted};
use crate::boundary::plan::{Horizon, Plan, Side, height_over_horizon, sure_side};
use crate::boundary::visibility::part::{Facing, PartCorner};
use crate::boundary::visibility::separation::CircularCone;
use crate::boundary::visibility::subtract::{Clipped, Place, clip};
use crate::problem::polygon::Polygon;
use crate::problem::receiver::{Receiver, unit_normal};
use crate::problem::triangulate::convex_parts;

/// An arc, with the errors of its ends and of its plane.
pub(crate) struct SureArc {
    /// The arc, its line taken for an occluder's: its ends are directions, not points of the line.
    pub(crate) arc: Arc<f64>,
    /// delta of both ends.
    pub(crate) spreads: [f64; 2],
    /// sigma of both ends.
    pub(crate) slips: [f64; 2],
    /// `en`.
    pub(crate) normal_error: f64,
}

/// Moments and squares of distances that are far from the ends of the range of doubles.
const ORDINARY: Range<f64> = LEAST_MOMENT..1.0 / LEAST_MOMENT;

/// Largest spread with which anything is sure.
const MOST_SPREAD: f64 = 1e-6;

/// Operations of cutting a piece by a shadow, and looks whether two shadows meet that cost as much.
const CUT: u64 = 128;
const MANY_LOOKS: usize = 16;

/// A direction, through a point on its ray.
#[derive(Debug, Clone, Copy)]
struct Ray {
    sighted: Sighted<f64>,
    /// delta.
    spread: f64,
    /// sigma.
    slip: f64,
    /// The vertex of the input that it is the direction of.
    vertex: Option<DVec3>,
}

/// A plane through the receiver that bounds a cone.
struct SureSide {
    generator: Generator<f64>,
    /// Its edge of the input; the horizon has none.
    edge: Option<[DVec3; 2]>,
    /// `en`.
    error: f64,
}

/// A convex cone, the emitter or the shadow of an occluder, where `N . omega < 0` on all sides; the corner that a side starts from
/// has its number.
struct Cone {
    sides: Range<usize>,
    around: Option<CircularCone>,
}

/// An end of a piece of a side: its ray, and the side that crosses there.
#[derive(Clone, Copy, PartialEq, Eq)]
struct End {
    ray: usize,
    other: usize,
}

/// A piece of a side.
#[derive(Clone, Copy)]
struct Piece {
    side: usize,
    from: End,
    to: End,
}

/// Where an end is relative to a side.
#[derive(Clone, Copy)]
enum Where {
    Inside,
    /// Exactly.
    OnIt,
    Outside,
}

/// As many pieces as a few shadows leave of a side need no memory of their own.
type Pieces = SmallVec<[Piece; 8]>;

/// All rays and sides, each once, and the pieces that bound the visible part.
struct Visible<'a> {
    receiver: &'a Receiver,
    plan: &'a Plan,
    rays: Vec<Ray>,
    sides: Vec<SureSide>,
    /// Pieces of the boundary; those of shadows are to be turned round.
    pieces: Vec<Piece>,
    emitter: Range<usize>,
}

/// Why nothing is sure is not told.
struct Unsure;

/// How far occluders hide an emitter.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Hidden {
    /// Surely not at all.
    Nothing,
    /// Occluders hide some of it, or all: the arcs of the visible part were visited.
    Something,
    /// Double precision is not sure.
    Unsure,
}

impl Ray {
    /// Where it is relative to a side: its height, if the sign is sure.
    fn sure_height(&self, normal: Vec3<f64>, error: f64) -> Option<f64> {
        let (height, length) = (normal.dot(self.sighted.point), self.sighted.square * self.sighted.inverse);
        let unsure = (error + self.spread + 4.0 * ROUNDOFF) * length * 1.001;
        (height.abs() > unsure).then_some(height)
    }

    fn unit(&self) -> DVec3 {
        (self.sighted.point * self.sighted.inverse).into()
    }
}

impl SureSide {
    fn normal(&self) -> Vec3<f64> {
        self.generator.normal()
    }

    fn height(&self, ray: &Ray) -> Option<f64> {
        ray.sure_height(self.normal(), self.error)
    }

    fn is_beyond(&self, ray: &Ray) -> bool {
        self.height(ray).is_some_and(|height| height > 0.0)
    }

    fn name(&self) -> Option<EdgeName> {
        self.edge.map(|[from, to]| EdgeName::new(from, to))
    }
}

impl Cone {
    /// The pieces that its sides are.
    fn pieces(&self) -> impl Iterator<Item = Piece> + use<> {
        let Range { start, end } = self.sides;
        let next = move |side| if side + 1 == end { start } else { side + 1 };
        let before = move |side| if side == start { end - 1 } else { side - 1 };
        (start..end).map(move |side| Piece {
            side,
            from: End { ray: side, other: before(side) },
            to: End { ray: next(side), other: next(side) },
        })
    }
}

impl<'a> Visible<'a> {
    /// The shadow of an outline, whichever way that runs.
    fn shadow(&mut self, count: usize, is_one_of_many: bool, vertex: impl Fn(usize) -> DVec3) -> Result<Cone, Unsure> {
        let [a, b, c] = [0, 1, 2].map(|i| vertex(i) - self.receiver.position());
        let is_turned = a.cross(b).dot(c) > 0.0;
        self.cone(count, is_one_of_many, |i| vertex(if is_turned { count - 1 - i } else { i }))
    }

    /// The cone of an outline, where `N . omega < 0` on all sides; one of many knows a circular one around it.
    fn cone(&mut self, count: usize, is_one_of_many: bool, vertex: impl Fn(usize) -> DVec3) -> Result<Cone, Unsure> {
        let (x, power, first) = (self.receiver.position(), self.plan.power, self.sides.len());
        let ray =
            |i| Ray { sighted: Sighted::from(vertex(i), x, power), spread: ROUNDOFF, slip: ROUNDOFF, vertex: Some(vertex(i)) };
        self.rays.extend((0..count).map(ray));
        let rays = &self.rays[first..];
        for i in 0..count {
            let j = (i + 1) % count;
            let edge = [vertex(i), vertex(j)];
            let line = Line::through(edge, [&rays[i].sighted, &rays[j].sighted], x, power);
            let error = line.relative_error() + ROUNDOFF;
            let is_known = error <= MOST_SPREAD
                && ORDINARY.contains(&line.moment)
                // Lengths of rays whose squares underflow have no digits.
                && ORDINARY.contains(&rays[i].sighted.square);
            let is_inside = |ray: &Ray| ray.sure_height(line.normal, error).is_some_and(|height| height < 0.0);
            if !is_known || !(0..count).all(|k| k == i || k == j || is_inside(&rays[k])) {
                return Err(Unsure);
            }
            self.sides.push(SureSide { generator: Generator::Occluder(line), edge: Some(edge), error });
        }
        let around = || CircularCone::around(rays.iter().map(|ray| (ray.unit(), 4.0 * MOST_SPREAD)));
        Ok(Cone { sides: first..first + count, around: if is_one_of_many { around() } else { None } })
    }

    /// The part of the emitter's cone above the horizon, if any.
    fn above_horizon(&mut self, whole: Cone, emitter: &Polygon) -> Result<Option<Cone>, Unsure> {
        let normal = -unit_normal::<f64>(self.receiver);
        let horizon = self.sides.len();
        self.sides.push(SureSide { generator: Generator::Horizon(normal), edge: None, error: 2.0 * ROUNDOFF });
        let place = |&vertex: &DVec3| {
            let depth: f64 = height_over_horizon(self.receiver, vertex, self.plan.power);
            Place { depth, is_exactly_on_it: depth == 0.0, is_doubtful: false }
        };
        let places: Vec<Place> = emitter.vertices().iter().map(place).collect();
        let corner =
            |side: usize| PartCorner { point: self.rays[side], vertex: self.rays[side].vertex, side: Facing::forward(side) };
        let corners: Vec<PartCorner<Ray>> = whole.sides.clone().map(corner).collect();
        let crossing = |i: usize, _| self.crossing(i, horizon, places[i].depth > 0.0);
        let corners = match clip(&corners, &places, Facing::forward(horizon), false, |_| None, crossing) {
            Clipped::Nothing => return Ok(None),
            Clipped::Whole => return Ok(Some(whole)),
            Clipped::Corners(corners) => corners,
        };
        self.rays.truncate(whole.sides.start);
        let mut sides: Vec<Option<SureSide>> = self.sides.drain(whole.sides.start..).map(Some).collect();
        for PartCorner { point, vertex, side } in corners {
            let Some(side) = sides[side.side - whole.sides.start].take().filter(|_| !point.spread.is_nan()) else {
                return Err(Unsure);
            };
            self.rays.push(Ray { vertex, ..point });
            self.sides.push(side);
        }
        Ok(Some(Cone { sides: whole.sides.start..self.sides.len(), ..whole }))
    }

    /// Whether one side of two cones is known to separate them.
    fn are_apart(&self, one: &Cone, other: &Cone) -> bool {
        let parts = |one: &Cone, other: &Cone| {
            let rays = &self.rays[other.sides.clone()];
            self.sides[one.sides.clone()].iter().any(|side| rays.iter().all(|ray| side.is_beyond(ray)))
        };
        CircularCone::are_apart(one.around, other.around) || parts(one, other) || parts(other, one)
    }

    /// Where an end of a piece of `own` is relative to another side.
    fn place(&self, own: usize, end: End, side: usize) -> Result<Where, Unsure> {
        if let Some(height) = self.sides[side].height(&self.rays[end.ray]) {
            return Ok(if height < 0.0 { Where::Inside } else { Where::Outside });
        }
        let Some(name) = self.sides[side].name() else { return Err(Unsure) };
        let is_on_its_line = |side: usize| self.sides[side].name().is_some_and(|name_of| name_of.is_on_the_line_of(name));
        let is_on_it = self.vertex(own, end).is_some_and(|vertex| name.is_in_line_with(vertex));
        if is_on_it || is_on_its_line(own) || is_on_its_line(end.other) { Ok(Where::OnIt) } else { Err(Unsure) }
    }

    /// The vertex that is seen at an end of a piece of `own`. Lines that share a point are seen to meet there.
    fn vertex(&self, own: usize, end: End) -> Option<DVec3> {
        let shared = || self.sides[own].name()?.shared_end(self.sides[end.other].name()?);
        self.rays[end.ray].vertex.or_else(shared)
    }

    /// The part of a piece in a cone, and the side of the cone along which it runs, if any.
    fn within(&mut self, piece: Piece, cone: &Cone) -> Result<Option<(Piece, Option<usize>)>, Unsure> {
        let is_beyond = |side: &SureSide, end: End| side.is_beyond(&self.rays[end.ray]);
        if self.sides[cone.sides.clone()].iter().any(|side| is_beyond(side, piece.from) && is_beyond(side, piece.to)) {
            return Ok(None);
        }
        let (mut piece, mut along) = (piece, None);
        for side in cone.sides.clone() {
            let places = [self.place(piece.side, piece.from, side)?, self.place(piece.side, piece.to, side)?];
            match places {
                [Where::OnIt, Where::OnIt] => along = Some(side),
                [Where::Inside | Where::OnIt, Where::Inside | Where::OnIt] => {}
                [Where::Outside | Where::OnIt, Where::Outside | Where::OnIt] => return Ok(None),
                [Where::Inside, Where::Outside] => piece.to = self.cut(piece.side, side, true)?,
                [Where::Outside, Where::Inside] => piece.from = self.cut(piece.side, side, false)?,
            }
        }
        Ok(Some((piece, along)))
    }

    /// Adds the part of a piece outside a shadow. A piece along the shadow's side is dark or lit by whether the two run the same way.
    fn subtract(
        &mut self,
        piece: Piece,
        shadow: &Cone,
        is_dark_along: impl Fn(bool) -> bool,
        lit: &mut Pieces,
    ) -> Result<(), Unsure> {
        let dark = self.within(piece, shadow)?.filter(|&(_, along)| {
            along.is_none_or(|side| is_dark_along(self.sides[piece.side].normal().dot(self.sides[side].normal()) > 0.0))
        });
        let Some((dark, _)) = dark else {
            lit.push(piece);
            return Ok(());
        };
        if dark.from != piece.from {
            lit.push(Piece { to: dark.from, ..piece });
        }
        if dark.to != piece.to {
            lit.push(Piece { from: dark.to, ..piece });
        }
        Ok(())
    }

    /// Pays for cutting a piece by so many shadows: where nothing is left to pay with, nothing is sure.
    fn pay(shadows: usize) -> Result<(), Unsure> {
        if effort::spend(CUT * shadows as u64) { Ok(()) } else { Err(Unsure) }
    }

    /// Adds the pieces that bound the visible part.
    fn add_pieces(&mut self, emitter: &Cone, shadows: &[Cone]) -> Result<(), Unsure> {
        let (mut pieces, mut lit) = (Pieces::new(), Pieces::new());
        for piece in emitter.pieces() {
            pieces.push(piece);
            Self::pay(shadows.len())?;
            for shadow in shadows {
                for piece in pieces.drain(..) {
                    self.subtract(piece, shadow, |is_same_way| is_same_way, &mut lit)?;
                }
                std::mem::swap(&mut pieces, &mut lit);
            }
            self.pieces.extend(pieces.drain(..));
        }
        Self::pay(shadows.len() * shadows.len() / MANY_LOOKS)?;
        for (number, shadow) in shadows.iter().enumerate() {
            let is_near = |other: &Cone| !CircularCone::are_apart(shadow.around, other.around);
            let others: SmallVec<[usize; 16]> = (0..shadows.len()).filter(|&k| k != number && is_near(&shadows[k])).collect();
            for piece in shadow.pieces() {
                let Some((piece, None)) = self.within(piece, emitter)? else { continue };
                pieces.push(piece);
                Self::pay(others.len())?;
                for &other in &others {
                    for piece in pieces.drain(..) {
                        self.subtract(piece, &shadows[other], |is_same_way| !is_same_way || other < number, &mut lit)?;
                    }
                    std::mem::swap(&mut pieces, &mut lit);
                }
                self.pieces.extend(pieces.drain(..));
            }
        }
        Ok(())
    }

    /// The end of a piece of `own` where another side cuts it, from its inside or from its outside.
    fn cut(&mut self, own: usize, other: usize, from_inside: bool) -> Result<End, Unsure> {
        let ray = self.crossing(own, other, from_inside);
        if ray.spread.is_nan() {
            return Err(Unsure);
        }
        self.rays.push(ray);
        Ok(End { ray: self.rays.len() - 1, other })
    }

    /// Where a side crosses another one, from its inside or from its outside; of a spread that is not a number where that is not
    /// sure.
    fn crossing(&self, own: usize, other: usize, from_inside: bool) -> Ray {
        let [own, other] = [own, other].map(|side| &self.sides[side]);
        let across = own.normal().cross(other.normal());
        let sighted = Sighted::new(if from_inside { -across } else { across });
        let (larger, least) = if own.error > other.error { (own.error, other.error) } else { (other.error, own.error) };
        let over_sine = |errors: f64| (errors + 2.2 * ROUNDOFF) * sighted.inverse * 1.001;
        let spread = over_sine(larger + least);
        let cosine = own.normal().dot(other.normal()).abs();
        let slip = over_sine(larger + least * cosine);
        Ray { sighted, spread: if spread <= MOST_SPREAD { spread } else { f64::NAN }, slip, vertex: None }
    }

    /// The boundary of the visible part; `None` where all above the horizon is lit.
    fn new(receiver: &'a Receiver, emitter: &Polygon, occluders: &[&Polygon], plan: &'a Plan) -> Result<Option<Self>, Unsure> {
        let (many, capacity) = (occluders.len() > 1, 4 * (occluders.len() + 2));
        let (rays, sides) = (Vec::with_capacity(2 * capacity), Vec::with_capacity(capacity));
        let mut visible = Self { receiver, plan, rays, sides, pieces: Vec::new(), emitter: 0..0 };
        let mut whole = visible.cone(emitter.vertices().len(), many, |i| emitter.vertices()[i])?;
        if plan.horizon == Horizon::Crossing {
            match visible.above_horizon(whole, emitter)? {
                Some(above) => whole = above,
                None => return Ok(Some(visible)),
            }
        }
        visible.emitter = whole.sides.clone();
        let slab = emitter.half_slab() * plan.power * 1.01;
        let mut shadows: SmallVec<[Cone; 4]> = SmallVec::new();
        for occluder in occluders {
            for part in convex_parts(occluder) {
                let shadow = visible.shadow(part.len(), many, |i| occluder.vertices()[part[i]])?;
                if visible.are_apart(&shadow, &whole) {
                    visible.rays.truncate(shadow.sides.start);
                    visible.sides.truncate(shadow.sides.start);
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
        visible.pieces.reserve(capacity);
        visible.add_pieces(&whole, &shadows)?;
        Ok(Some(visible))
    }
}

/// Calls `visit` with each arc of the visible boundary, unless a decision is not sure or nothing is hidden.
pub(crate) fn visit_boundary(
    receiver: &Receiver,
    emitter: &Polygon,
    occluders: &[&Polygon],
    plan: &Plan,
    mut visit: impl FnMut(&SureArc),
) -> Hidden {
    let visible = match Visible::new(receiver, emitter, occluders, plan) {
        Ok(Some(visible)) => visible,
        Ok(None) => return Hidden::Nothing,
        Err(Unsure) => return Hidden::Unsure,
    };
    for Piece { side, from, to } in &visible.pieces {
        let (SureSide { generator, error, .. }, [from, to]) =
            (&visible.sides[*side], [from, to].map(|end| &visible.rays[end.ray]));
        let (from, to, generator) =
            if visible.emitter.contains(side) { (from, to, *generator) } else { (to, from, generator.reversed()) };
        visit(&SureArc {
            arc: Arc::between(from.sighted, to.sighted, generator),
            spreads: [from.spread, to.spread],
            slips: [from.slip, to.slip],
            normal_error: *error,
        });
    }
    Hidden::Something
}

impl Visible<'_> {
    /// The generator of a side in another scalar.
    fn generator_in<T: Real>(&self, side: usize) -> Generator<T> {
        let (x, power) = (self.receiver.position(), self.plan.power);
        match self.sides[side].edge {
            Some(edge) => {
                let [from, to] = edge.map(|end| Sighted::from(end, x, power));
                Generator::Occluder(Line::through(edge, [&from, &to], x, power))
            }
            None => Generator::Horizon(-unit_normal(self.receiver)),
        }
    }
}

/// The arcs of the visible boundary, with every line taken for an occluder's; `None` where double precision is not sure, or nothing is
/// hidden.
pub(crate) fn arcs<T: Real>(receiver: &Receiver, emitter: &Polygon, occluders: &[&Polygon], plan: &Plan) -> Option<Vec<Arc<T>>> {
    let Ok(Some(visible)) = Visible::new(receiver, emitter, occluders, plan) else { return None };
    let generators: Vec<OnceCell<Generator<T>>> = vec![OnceCell::new(); visible.sides.len()];
    let generator = |side: usize| *generators[side].get_or_init(|| visible.generator_in(side));
    let sighted = |own: usize, end: End| {
        let about = visible.rays[end.ray].sighted.point;
        let is_before = |sighted: &Sighted<T>| sighted.point.map(T::value).dot(about) > 0.0;
        let vertex = visible.vertex(own, end).map(|vertex| Sighted::from(vertex, receiver.position(), plan.power));
        let crossing = || {
            let across = generator(own).normal().cross(generator(end.other).normal());
            [across, -across].map(Sighted::new).into_iter().find(is_before)
        };
        vertex.filter(is_before).or_else(crossing)
    };
    let arc = |&Piece { side, from, to }: &Piece| {
        let [from, to] = [sighted(side, from)?, sighted(side, to)?];
        Some(if visible.emitter.contains(&side) {
            Arc::between(from, to, generator(side))
        } else {
            Arc::between(to, from, generator(side).reversed())
        })
    };
    visible.pieces.iter().map(arc).collect()
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
