//! The sums of an emitter that is fully visible, or that the horizon cuts, in double-double, four edges at a time, one a lane of
//! a vector.
//!
//! # Error
//! The formulas and decisions are those of [`crate::forms::edge_lanes::constant`], so the derivation of
//! [`crate::forms::constant_bound`] holds for these sums with another unit, U = 2^-90 for u. For every rounding that it counts errs
//! here by at most `V = U/16`, the roundoff of double-doubles on lanes ([`ROUNDOFF_ON_LANES`]), with v = 2^-103 the
//! [`ROUNDOFF_OF_DOUBLE_DOUBLE`]:
//!
//! | | counted | here |
//! |---|---|---|
//! | sums, products, quotients, roots | u | below V |
//! | offsets and edges | u | exact |
//! | n1, rho/pi | u a component | 32v, below V |
//! | w, of a line that passes at an eighth of the distance at least | `3.5u |r||e|` and u, so 2u at least | `29 v` of itself, below V |
//! | arc tangent | 4u | V |
//! | sum of n terms | `(n - 1) u` | fewer, V each |
//! | psi, given g | 3u | see below |
//!
//! psi is no polynomial here. Up to g = 1 it is made of a series, of V, and of 1 + cos: `psi = g p (1 + cos)/24 (1 - g^2 p/6)^2` errs
//! by 1.4V from p and by the errors of 1 + cos and of its own operations, 100v: below 2V. Past that it is `(g - sin g)/4 (1 - cos
//! g)` with `4 (1 - cos g) >= 1.83`: the arc tangent's error of Vg moves it by 0.86V, all else by less than 0.1V. That is at most
//! U/16, and `0.11 dg + 0.9ug` are counted, which is above `0.9u`.
//!
//! So the bound of the sums of a constant emission in double precision times `U/u` ([`SHARE`]) bounds these: known before they are
//! made. Most of it is the factor 16 and the slack of the derivation; the remaining error of an answer is the rounding to doubles.
//!
//! Where the horizon cuts, the fraction t of an edge is a quotient of heights, each with a relative error of 8v of 12 over itself. 4u of
//! t are counted, and with a unit of at least that error it errs by 3 units here. So near a vertex the unit is larger than U
//! ([`OF_HEIGHT`]); the signs of heights are sure there.
//!
//! A linear emission is that of [`crate::forms::edge_lanes::linear`], and [`crate::forms::linear_bound`] derives its bound likewise:
//! logarithm and Clausen's function err by V where 3u and 6u are counted, gB and n2 by V at most where it is to hold. The errors of
//! height and emission that the input leaves are the same in any unit, so that bound is found anew with U for u.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f64x4, f64x8, mask64x4};
use radgrad_numbers::arc_tangent::is_in_range;
use radgrad_numbers::arithmetic::Arithmetic;
use radgrad_numbers::ball::Ball;
use radgrad_numbers::double_double::{DoubleDouble, ROUNDOFF_OF_DOUBLE_DOUBLE};
use radgrad_numbers::double_double_on_lanes::ROUNDOFF_ON_LANES;
use radgrad_numbers::in_library;
use radgrad_numbers::lanes::vectors::splat_vector;
use radgrad_numbers::number::ROUNDOFF;
use radgrad_numbers::real::Real;
use radgrad_numbers::vec3::Vec3;

use crate::boundary::arc::{Arc, Generator};
use crate::boundary::line::{Frame, Line, Sighted};
use crate::boundary::plan::{Horizon, Plan};
use crate::forms::edge_lanes::{INSTRUCTION_SET, next};
use crate::forms::irradiance_and_gradient::IrradianceAndGradient;
use crate::forms::linear::{LinearSum, SeenLinear};
use crate::forms::segment::{X1End, met_frame, x1_between};
use crate::problem::emission::Emitter;
use crate::problem::polygon::{FourEdges, Polygon};
use crate::problem::receiver::Receiver;

/// The unit U of bounds, in which errors are counted.
pub(crate) const UNIT: f64 = 16.0 * ROUNDOFF_ON_LANES;

/// Bounds in double-double over those in double precision, `U/u`.
pub(crate) const SHARE: f64 = UNIT / ROUNDOFF;

/// Relative error of a height over the horizon, in double-double and over a roundoff of doubles, times the height: 8 roundings of 12.
const OF_HEIGHT: f64 = 96.0 * ROUNDOFF_OF_DOUBLE_DOUBLE / ROUNDOFF;

/// The largest unit of a bound over that of double precision that is worth it.
const MOST_SHARE: f64 = 1e-6;

/// Four double-doubles.
type Four<S> = DoubleDouble<f64x4<S>>;

/// The sums of a constant unit emission, and the unit of their bound over that of double precision, where that bound is finite: where
/// the receiver passes no edge's line very near, and the horizon cuts four edges at most, far from a vertex.
#[inline]
pub(crate) fn constant(
    receiver: &Receiver,
    polygon: &Polygon,
    plan: &Plan,
) -> Option<(IrradianceAndGradient<DoubleDouble>, f64)> {
    in_library!(*INSTRUCTION_SET, simd => constant_on(simd, receiver, polygon, plan))
}

#[inline(always)]
fn constant_on<S: Simd>(
    simd: S,
    receiver: &Receiver,
    polygon: &Polygon,
    plan: &Plan,
) -> Option<(IrradianceAndGradient<DoubleDouble>, f64)> {
    let n1 = splat_precise(simd, receiver.precise_normal());
    let zero = splat(simd, DoubleDouble::ZERO);
    let (mut angles, mut edges) = (Vec3::new(zero, zero, zero), Vec3::new(zero, zero, zero));
    let (mut remaining, mut share) = (polygon.vertices().len(), SHARE);
    let fours = polygon.four_edges();
    for from in fours {
        let mut used = first(simd, remaining);
        let mut four = Edges::new(simd, from, receiver, plan.power, fours.len() == 1)?;
        if plan.horizon == Horizon::Crossing {
            if fours.len() > 1 {
                return None;
            }
            let cut = four.cut(simd, receiver, (from, used), plan.power)?;
            (four, used, share) = (cut.four, used & cut.visible, cut.share);
            let lane = first(simd, 1);
            angles = only(lane, cut.closing.generator.normal() * cut.closing.angle, zero);
        }
        remaining = remaining.saturating_sub(4);
        let Edges { arc, line, .. } = &four;
        angles = angles + only(used, line.normal * arc.angle, zero);
        let cosines = four.at_ends(
            #[inline(always)]
            |end| end.cosine(n1),
        );
        let mut weight = arc.within_a_quarter_turn([arc.start.inverse, arc.end.inverse], cosines);
        let wide = arc.inline.hi.simd_lt(f64x4::splat(simd, 0.0));
        if wide.any_true() {
            weight = DoubleDouble::choose(wide, arc.weight_in_frame(line, n1), weight);
        }
        edges = edges + only(used, line.normal * -weight, zero);
    }
    let half = DoubleDouble::from(-0.5);
    Some((IrradianceAndGradient { irradiance: in_all(angles) * half, gradient: in_all(edges) }, share))
}

/// The sums of a linear emission, as balls without radius, and the unit of their bound, where double precision has one in it; where
/// [`constant`] has its sums.
#[inline]
pub(crate) fn linear(
    receiver: &Receiver,
    emitter: &Emitter,
    plan: &Plan,
) -> Option<(IrradianceAndGradient<Ball<DoubleDouble>>, f64)> {
    let case = SeenLinear::new(receiver, emitter, plan.power);
    in_library!(*INSTRUCTION_SET, simd => linear_on(simd, receiver, emitter.polygon(), case, plan))
}

#[inline(always)]
fn linear_on<S: Simd>(
    simd: S,
    receiver: &Receiver,
    polygon: &Polygon,
    one: SeenLinear<Ball<DoubleDouble>>,
    plan: &Plan,
) -> Option<(IrradianceAndGradient<Ball<DoubleDouble>>, f64)> {
    let lanes = SeenLinear {
        n1: splat_middles(simd, one.n1),
        n2: splat_middles(simd, one.n2),
        height: splat(simd, one.height.middle()),
        beta: splat(simd, one.beta.middle()),
        gradient: splat_middles(simd, one.gradient),
    };
    let zero = splat(simd, DoubleDouble::ZERO);
    let none = Vec3::new(zero, zero, zero);
    let (mut angles, mut contours, mut edges, mut x1) = (none, none, none, zero);
    let (mut remaining, mut share) = (polygon.vertices().len(), SHARE);
    let inverse = splat(simd, DoubleDouble::from(1.0)) / (lanes.height * lanes.height);
    let fours = polygon.four_edges();
    for from in fours {
        let mut used = first(simd, remaining);
        let mut four = Edges::new(simd, from, receiver, plan.power, fours.len() == 1)?;
        if plan.horizon == Horizon::Crossing {
            if fours.len() > 1 {
                return None;
            }
            let cut = four.cut(simd, receiver, (from, used), plan.power)?;
            (four, used, share) = (cut.four, used & cut.visible, cut.share);
            let (lane, arc) = (first(simd, 1), &cut.closing);
            let frame = met_frame(arc.generator.normal(), lanes.n2, lanes.height);
            let logarithms = [logarithm(&arc.start, inverse), logarithm(&arc.end, inverse)];
            let contour = lanes.contour(arc, &frame, logarithms);
            angles = only(lane, frame.normal * arc.angle, zero);
            contours = only(lane, contour.outward * contour.flux, zero);
            x1 = DoubleDouble::choose(lane, x1_term(simd, arc, &frame, contour.kappa, logarithms)?, zero);
        }
        let Edges { arc, line, .. } = &four;
        let frame = line.frame();
        remaining = remaining.saturating_sub(4);
        let logarithms = four.at_ends(
            #[inline(always)]
            |end| logarithm(end, inverse),
        );
        let contour = lanes.contour(arc, &frame, logarithms);
        angles = angles + only(used, line.normal * arc.angle, zero);
        contours = contours + only(used, contour.outward * contour.flux, zero);
        x1 = x1 + DoubleDouble::choose(used, x1_term(simd, arc, &frame, contour.kappa, logarithms)?, zero);
        let cosines = four.at_ends(
            #[inline(always)]
            |end| lanes.cosine(end),
        );
        let emissions = four.at_ends(
            #[inline(always)]
            |end| lanes.emission(end),
        );
        let mut weight = arc.within_a_quarter_turn(emissions, cosines);
        let wide = arc.inline.hi.simd_lt(f64x4::splat(simd, 0.0));
        if wide.any_true() {
            weight = DoubleDouble::choose(wide, lanes.toward(&frame, &arc.moments(&frame)) / frame.distance, weight);
        }
        edges = edges + only(used, line.normal * -weight, zero);
    }
    let ball = |c: DoubleDouble| Ball::approximate(c, 0.0);
    let sums = LinearSum {
        seen: one,
        angles: in_all(angles).map(ball),
        x1: ball(of_all(x1)),
        contour: in_all(contours).map(ball),
        edges: in_all(edges).map(ball),
    };
    Some((sums.total(), share * ROUNDOFF))
}

/// `ln(r/h)` of an end, given `1/h^2`.
#[inline(always)]
fn logarithm<S: Simd>(end: &Sighted<Four<S>>, inverse: Four<S>) -> Four<S> {
    (end.square * inverse).ln().scaled(0.5)
}

/// As [`crate::forms::edge_lanes::linear`] has the contributions to X1.
#[inline(always)]
fn x1_term<S: Simd>(
    simd: S,
    arc: &Arc<Four<S>>,
    frame: &Frame<Four<S>>,
    kappa: Four<S>,
    logarithms: [Four<S>; 2],
) -> Option<Four<S>> {
    let beside = |[start, end]: [Four<S>; 2]| DoubleDouble {
        hi: simd.combine_f64x4(start.hi, end.hi),
        lo: simd.combine_f64x4(start.lo, end.lo),
    };
    let signed = frame.distance * kappa;
    let (d, distance) = (beside([Arithmetic::abs(signed); 2]), beside([frame.distance; 2]));
    let along = beside([arc.start.point.dot(frame.along), arc.end.point.dot(frame.along)]);
    let s = Arithmetic::abs(along);
    if !(is_in_range(s.hi, d.hi) & is_in_range(s.hi, distance.hi)).all_true() {
        return None;
    }
    let [term, above, below] = X1End::new(s, [d, distance, distance + d], beside(logarithms)).on_side_of(along);
    let parts = |c: DoubleDouble<f64x8<S>>| {
        let ((start, end), (start_rest, end_rest)) = (simd.split_f64x8(c.hi), simd.split_f64x8(c.lo));
        [DoubleDouble { hi: start, lo: start_rest }, DoubleDouble { hi: end, lo: end_rest }]
    };
    let ([start, end], [above, other_above], [below, other_below]) = (parts(term), parts(above), parts(below));
    let (term, _) = x1_between([[start, above, below], [end, other_above, other_below]], signed);
    let zero = splat(simd, DoubleDouble::ZERO);
    Some(DoubleDouble::choose(signed.hi.simd_eq(zero.hi), zero, term))
}

/// Four arcs of edges with their lines.
struct Edges<S: Simd> {
    arc: Arc<Four<S>>,
    line: Line<Four<S>>,
    /// Whether all edges of a polygon are here: each one ends where the next one starts.
    closed: bool,
}

impl<S: Simd> Edges<S> {
    /// As [`crate::forms::edge_lanes::EdgeLanes::new`], also near lines.
    #[inline(always)]
    fn new(simd: S, four: &FourEdges, receiver: &Receiver, power: f64, closed: bool) -> Option<Self> {
        let (from, to, x) = (four.starts(simd), four.ends(simd), splat_vector(simd, receiver.position()));
        let (start, end, e) = (Sighted::new(apart(from, x, power)), apart(to, x, power), apart(to, from, power));
        let end = if closed {
            Sighted { point: end, square: both(start.square, next), inverse: both(start.inverse, next) }
        } else {
            Sighted::new(end)
        };
        let edge_square = e.norm_squared();
        let (mut w, mut reach) = (start.point.cross(e), start.square);
        let square = |w: Vec3<Four<S>>| w.x.hi * w.x.hi + w.y.hi * w.y.hi + w.z.hi * w.z.hi;
        let mut passes = (f64x4::splat(simd, 16.0) * square(w)).simd_ge(reach.hi * edge_square.hi);
        if !passes.all_true() {
            let at_end = !passes & end.square.hi.simd_lt(start.square.hi);
            let nearer = end.point.cross(e);
            w = only_or(at_end, nearer, w);
            reach = DoubleDouble::choose(at_end, end.square, start.square);
            passes |= (f64x4::splat(simd, 64.0) * square(w)).simd_ge(reach.hi * edge_square.hi);
        }
        let line = Line::new(e, edge_square, w, reach);
        let arc = Arc::of_edge(start, end, splat(simd, DoubleDouble::from(1.0)), line);
        if !(passes & is_in_range(arc.across.hi, arc.inline.hi)).all_true() {
            return None;
        }
        Some(Self { arc, line, closed })
    }

    /// The parts above the horizon of the edges used, as [`crate::forms::edge_lanes::cut`].
    #[inline(always)]
    fn cut(self, simd: S, receiver: &Receiver, (edges, used): (&FourEdges, mask64x4<S>), power: f64) -> Option<Cut<S>> {
        let before = heights(simd, receiver, edges.starts(simd), power);
        let after = heights(simd, receiver, edges.ends(simd), power);
        let lowest = Arithmetic::abs(before.hi).min(Arithmetic::abs(after.hi));
        if !lowest.simd_ge(f64x4::splat(simd, OF_HEIGHT / MOST_SHARE)).all_true() {
            return None;
        }
        let share = lowest.as_array().iter().fold(SHARE, |share, lowest| share.max(OF_HEIGHT / lowest));
        let zero = f64x4::splat(simd, 0.0);
        let (starts, ends) = (before.hi.simd_gt(zero), after.hi.simd_gt(zero));
        let (exits, entries) = (starts & !ends, ends & !starts);
        let (exit, entry) = ((exits & used).to_bitmask(), (entries & used).to_bitmask());
        if exit.count_ones() != 1 || entry.count_ones() != 1 {
            return None;
        }
        let Arc { start, end, .. } = self.arc;
        let line = self.line;
        let share_of_edge =
            DoubleDouble::choose(exits, before, after) / DoubleDouble::choose(exits, before - after, after - before);
        let fraction = DoubleDouble::choose(exits | entries, share_of_edge, splat(simd, DoubleDouble::from(1.0)));
        let along = line.e * fraction;
        let start = Sighted::new(only_or(entries, end.point - along, start.point));
        let end = Sighted::new(only_or(exits, self.arc.start.point + along, end.point));
        let arc = Arc::of_edge(start, end, fraction, line);
        let n1 = splat_precise(simd, receiver.precise_normal());
        let horizon = Generator::Horizon(Vec3::new(-n1.x, -n1.y, -n1.z));
        let closing = Arc::between(in_lane(simd, end, exit), in_lane(simd, start, entry), horizon);
        let is_plain =
            is_in_range(arc.across.hi, arc.inline.hi) & is_in_range(Arithmetic::abs(closing.across.hi), closing.inline.hi);
        if !is_plain.all_true() || closing.across.hi[0] < 0.0 {
            return None;
        }
        Some(Cut { four: Self { arc, line, closed: false }, visible: starts | ends, closing, share })
    }

    /// A function of the two ends.
    #[inline(always)]
    fn at_ends(&self, function: impl Fn(&Sighted<Four<S>>) -> Four<S>) -> [Four<S>; 2] {
        let start = function(&self.arc.start);
        [start, if self.closed { both(start, next) } else { function(&self.arc.end) }]
    }
}

/// Four edges that the horizon cuts.
struct Cut<S: Simd> {
    /// The parts above it.
    four: Edges<S>,
    /// Which have one.
    visible: mask64x4<S>,
    /// The arc along the horizon, the same in all lanes.
    closing: Arc<Four<S>>,
    /// The unit of bounds over that of double precision.
    share: f64,
}

/// The heights of four points over the receiver's horizon, times the length of the normal as given: off by eight roundings of
/// double-double of terms that sum to less than 12.
#[inline(always)]
fn heights<S: Simd>(simd: S, receiver: &Receiver, points: Vec3<f64x4<S>>, power: f64) -> Four<S> {
    let n = splat_precise(simd, Vec3::from(receiver.direction()).map(DoubleDouble::from));
    n.dot(apart(points, splat_vector(simd, receiver.position()), power))
}

/// A point in the lane of a bit, in all lanes.
#[inline(always)]
fn in_lane<S: Simd>(simd: S, sighted: Sighted<Four<S>>, bit: u64) -> Sighted<Four<S>> {
    let i = (bit.trailing_zeros() & 3) as usize;
    let one = |c: Four<S>| splat(simd, DoubleDouble { hi: c.hi.as_array()[i], lo: c.lo.as_array()[i] });
    let Vec3 { x, y, z } = sighted.point;
    Sighted { point: Vec3::new(one(x), one(y), one(z)), square: one(sighted.square), inverse: one(sighted.inverse) }
}

/// A function of the two parts, that moves lanes.
#[inline(always)]
fn both<S: Simd>(c: Four<S>, function: impl Fn(f64x4<S>) -> f64x4<S>) -> Four<S> {
    DoubleDouble { hi: function(c.hi), lo: function(c.lo) }
}

/// The difference of two points, exact, times a power of two.
#[inline(always)]
fn apart<S: Simd>(to: Vec3<f64x4<S>>, from: Vec3<f64x4<S>>, power: f64) -> Vec3<Four<S>> {
    Vec3::new(
        DoubleDouble::difference(to.x, from.x).scaled(power),
        DoubleDouble::difference(to.y, from.y).scaled(power),
        DoubleDouble::difference(to.z, from.z).scaled(power),
    )
}

#[inline(always)]
fn splat<S: Simd>(simd: S, DoubleDouble { hi, lo }: DoubleDouble) -> Four<S> {
    DoubleDouble { hi: f64x4::splat(simd, hi), lo: f64x4::splat(simd, lo) }
}

#[inline(always)]
fn splat_precise<S: Simd>(simd: S, v: Vec3<DoubleDouble>) -> Vec3<Four<S>> {
    Vec3::new(splat(simd, v.x), splat(simd, v.y), splat(simd, v.z))
}

#[inline(always)]
fn splat_middles<S: Simd>(simd: S, v: Vec3<Ball<DoubleDouble>>) -> Vec3<Four<S>> {
    Vec3::new(splat(simd, v.x.middle()), splat(simd, v.y.middle()), splat(simd, v.z.middle()))
}

/// So many lanes, all of them of four and more.
#[inline(always)]
fn first<S: Simd>(simd: S, count: usize) -> mask64x4<S> {
    f64x4::load_array(simd, [0.0, 1.0, 2.0, 3.0]).simd_lt(f64x4::splat(simd, count as f64))
}

/// The terms of these lanes.
#[inline(always)]
fn only<S: Simd>(used: mask64x4<S>, terms: Vec3<Four<S>>, zero: Four<S>) -> Vec3<Four<S>> {
    only_or(used, terms, Vec3::new(zero, zero, zero))
}

/// The same, with others elsewhere.
#[inline(always)]
fn only_or<S: Simd>(used: mask64x4<S>, set: Vec3<Four<S>>, unset: Vec3<Four<S>>) -> Vec3<Four<S>> {
    Vec3::new(
        DoubleDouble::choose(used, set.x, unset.x),
        DoubleDouble::choose(used, set.y, unset.y),
        DoubleDouble::choose(used, set.z, unset.z),
    )
}

/// The sum of the lanes.
#[inline(always)]
fn in_all<S: Simd>(terms: Vec3<Four<S>>) -> Vec3<DoubleDouble> {
    Vec3::new(of_all(terms.x), of_all(terms.y), of_all(terms.z))
}

#[inline(always)]
fn of_all<S: Simd>(terms: Four<S>) -> DoubleDouble {
    let pairs = terms
        + both(
            terms,
            #[inline(always)]
            |c| c.rotate_elements_left::<2>(),
        );
    let sum = pairs + both(pairs, next);
    DoubleDouble { hi: sum.hi[0], lo: sum.lo[0] }
}

#[cfg(all(test, feature = "arbitrary-precision"))]
mod tests {
    use rand::{RngExt, SeedableRng, rngs::ChaCha8Rng};

    use super::*;
    use crate::boundary::case::Case;
    use crate::forms::constant_bound::BoundedSum;
    use crate::forms::edge_lanes::linear::bounded_in;
    use crate::forms::edge_lanes::random::{polygon_and_receiver, vector};
    use crate::problem::emission::Emission;
    use radgrad_numbers::big::{Big, within};
    use radgrad_numbers::lanes::instruction_set::instruction_sets;
    use radgrad_numbers::number::Number;
    use radgrad_numbers::on_instruction_set;

    fn error(sum: Vec3<DoubleDouble>, truth: Vec3<Ball<Big>>) -> Vec3<f64> {
        (sum.map(|c| Ball::approximate(Big::from_double_double(c), 0.0.into())) - truth).map(Real::value)
    }

    /// A receiver close above a polygon, where arcs are past a quarter turn.
    fn close_above(polygon: &Polygon, receiver: &Receiver, random: &mut ChaCha8Rng) -> Receiver {
        let [a, b, c] = [0, 1, 2].map(|k| polygon.vertices()[k]);
        let share = libm::exp(random.random_range(-16.0..-1.0));
        let place = a * 0.4 + b * 0.3 + c * 0.3 + polygon.normal() * share * (b - a).length();
        Receiver::new(place, receiver.direction() * (0.1 * share) - polygon.normal(), 1.0).unwrap()
    }

    /// A polygon and its size, and a receiver that sees some of it: whole, cut by its horizon, or from close above.
    struct Drawn {
        polygon: Polygon,
        size: f64,
        receiver: Receiver,
        plan: Plan,
        is_close: bool,
    }

    fn drawn(random: &mut ChaCha8Rng, i: usize) -> Option<Drawn> {
        let (polygon, mut receiver, size) = polygon_and_receiver(random, 3 + i % 7, [0.7, 1.5, 5.0][i % 3])?;
        let is_close = i.is_multiple_of(4);
        if is_close {
            receiver = close_above(&polygon, &receiver, random);
        }
        if i.is_multiple_of(3) {
            let tilted = receiver.direction() + vector(random, if is_close { 1e-2 } else { 2.0 });
            receiver = Receiver::new(receiver.position(), tilted, 1.0).unwrap();
        }
        let plan = Plan::new(&receiver, &polygon).filter(|plan| !plan.on_surface)?;
        Some(Drawn { polygon, size, receiver, plan, is_close })
    }

    #[test]
    fn constant_sums_are_within_their_bound_of_those_of_256_bits_on_every_instruction_set() {
        let mut random = ChaCha8Rng::seed_from_u64(17);
        let (mut cases, mut wide, mut cut, mut worst) = (0, 0, 0, [0.0f64; 2]);
        for i in 0..3000 {
            let Some(Drawn { polygon, receiver, plan, is_close, .. }) = drawn(&mut random, i) else { continue };
            let mut first = None;
            for level in instruction_sets() {
                let sums = on_instruction_set!(level, simd => constant_on(simd, &receiver, &polygon, &plan));
                let digits = sums.map(|(sums, share)| (sums.irradiance, sums.gradient, share));
                assert_eq!(*first.get_or_insert(digits), digits, "{level:?}");
            }
            let Some((irradiance, gradient, share)) = first.flatten() else { continue };
            let (_, bound) = BoundedSum::of_polygon(&receiver, &polygon, &plan);
            if !(bound.irradiance + bound.gradient).is_finite() {
                continue;
            }
            let emitter = Emitter::new(polygon.clone(), Emission::Constant(1.0)).unwrap();
            let case = Case { receiver: &receiver, emitter: &emitter, occluders: &[], plan: &plan };
            let (errors, _) = within(256, u64::MAX, || {
                let truth = IrradianceAndGradient::<Ball<Big>>::sum::<true, true>(&case).unwrap();
                let irradiance = Vec3::from(receiver.normal()).dot(error(irradiance, truth.irradiance)).abs();
                [irradiance / bound.irradiance, error(gradient, truth.gradient).length() / bound.gradient]
            });
            cases += 1;
            wide += usize::from(is_close);
            cut += usize::from(plan.horizon == Horizon::Crossing);
            for (worst, error) in worst.iter_mut().zip(errors.unwrap()) {
                assert!(error <= share, "{error:e} {receiver:?} {polygon:?}");
                *worst = worst.max(error / share);
            }
        }
        println!("{cases} found, {wide} of them close above, {cut} cut, worst error over bound {worst:?}");
        assert!(
            cases > 1000 && wide > 100 && cut > 100 && worst.iter().all(|&worst| worst > 1e-7 && worst < 1.0 / 16.0),
            "{cases} {wide} {cut} {worst:?}"
        );
    }

    #[test]
    fn linear_sums_are_within_their_bound_of_those_of_256_bits_on_every_instruction_set() {
        let mut random = ChaCha8Rng::seed_from_u64(18);
        let (mut cases, mut close, mut cut, mut worst) = (0, 0, 0, [0.0f64; 2]);
        for i in 0..2000 {
            let Some(Drawn { polygon, receiver, size, plan, is_close }) = drawn(&mut random, i) else { continue };
            let emitter = Emitter::new(polygon, Emission::gradient(1.0, vector(&mut random, 1.0 / size))).unwrap();
            let mut first = None;
            for level in instruction_sets() {
                let case = SeenLinear::new(&receiver, &emitter, plan.power);
                let polygon = emitter.polygon();
                let sums = on_instruction_set!(level, simd => linear_on(simd, &receiver, polygon, case, &plan));
                let digits = sums.map(|(sums, unit)| (sums.irradiance.map(Ball::middle), sums.gradient.map(Ball::middle), unit));
                assert_eq!(*first.get_or_insert(digits), digits, "{level:?}");
            }
            let Some((irradiance, gradient, unit)) = first.flatten() else { continue };
            let Some((_, bound)) = bounded_in(unit, &receiver, &emitter, &plan) else { continue };
            let case = Case { receiver: &receiver, emitter: &emitter, occluders: &[], plan: &plan };
            let (errors, _) = within(256, u64::MAX, || {
                let truth = IrradianceAndGradient::<Ball<Big>>::sum::<true, true>(&case).unwrap();
                let irradiance = Vec3::from(receiver.normal()).dot(error(irradiance, truth.irradiance)).abs();
                [irradiance / bound.radiosity, error(gradient, truth.gradient).length() / bound.gradient]
            });
            cases += 1;
            close += usize::from(is_close);
            cut += usize::from(plan.horizon == Horizon::Crossing);
            for (worst, error) in worst.iter_mut().zip(errors.unwrap()) {
                assert!(error <= 1.0, "{error:e} {receiver:?} {emitter:?}");
                *worst = worst.max(error);
            }
        }
        println!("{cases} found, {close} of them close above, {cut} cut, worst error over bound {worst:?}");
        assert!(
            cases > 500 && close > 60 && cut > 20 && worst.iter().all(|&worst| worst > 1e-7 && worst < 1.0 / 16.0),
            "{cases} {close} {cut} {worst:?}"
        );
    }
}
