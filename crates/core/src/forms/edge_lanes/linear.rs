//! The sums of a linear emitter that is fully visible, or that the horizon cuts, four edges at a time, one a lane of a vector:
//! the digits of the sums of [`crate::forms::linear`], where double precision is sure of all decisions
//! ([`crate::forms::edge_lanes`]).

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f64x4, f64x8, mask64x4};
use radgrad_numbers::arc_tangent::is_in_range;
use radgrad_numbers::in_library;
use radgrad_numbers::lanes::vectors::{chosen, number_plus_first, plus_first, splat_vector};
use radgrad_numbers::logarithm::of_normal;
use radgrad_numbers::number::ROUNDOFF;
use radgrad_numbers::vec3::Vec3;

use crate::boundary::arc::Arc;
use crate::boundary::line::Frame;
use crate::boundary::plan::{Horizon, Plan};
use crate::forms::edge_lanes::cut::Cut;
use crate::forms::edge_lanes::{EdgeLanes, INSTRUCTION_SET, SureCase, height_over_plane, plan, plan_far_out, without_power};
use crate::forms::irradiance_and_gradient::IrradianceAndGradient;
use crate::forms::linear::{ContourTerm, LinearSum, SeenLinear};
use crate::forms::linear_bound::{Errors, LinearBound};
use crate::forms::segment::{X1End, logarithms, met_frame, x1_between};
use crate::problem::emission::Emitter;
use crate::problem::polygon::Polygon;
use crate::problem::receiver::Receiver;

/// The plan and the sums, where double precision is sure of all decisions.
#[inline]
pub(crate) fn sure<const GRADIENT: bool>(receiver: &Receiver, emitter: &Emitter) -> Option<(Plan, IrradianceAndGradient<f64>)> {
    in_library!(*INSTRUCTION_SET, simd => {
        let plan = plan(simd, receiver, emitter.polygon())?;
        let sums = match plan.horizon {
            Horizon::Above => without_power(
                &plan,
                #[inline(always)]
                |power| Some(sums::<_, GRADIENT, false, false>(simd, receiver, emitter, power, ROUNDOFF)?.0),
            )?,
            // With its bound, so that this is compiled once.
            Horizon::Crossing => cut(simd, receiver, emitter, plan.power, ROUNDOFF)?.0,
        };
        Some((plan, sums))
    })
}

/// The sums of a polygon that is fully visible, with lengths normalised by `power`, and a bound on their errors; where all is sure
/// and no edge is seen past a quarter turn.
#[inline]
pub(crate) fn bounded(receiver: &Receiver, emitter: &Emitter, power: f64) -> Option<(IrradianceAndGradient<f64>, LinearBound)> {
    in_library!(*INSTRUCTION_SET, simd => {
        let (terms, bound) = sums::<_, true, true, false>(simd, receiver, emitter, power, ROUNDOFF)?;
        Some((terms, bound?))
    })
}

/// The same with the errors that a unit of roundoff leaves, past a quarter turn too; the horizon may cut a polygon of up to four
/// vertices. There the bound is above a running one, at a third of its cost.
#[inline]
pub(crate) fn bounded_in(
    unit: f64,
    receiver: &Receiver,
    emitter: &Emitter,
    plan: &Plan,
) -> Option<(IrradianceAndGradient<f64>, LinearBound)> {
    in_library!(*INSTRUCTION_SET, simd => {
        if plan.horizon == Horizon::Crossing {
            return cut(simd, receiver, emitter, plan.power, unit);
        }
        let (terms, bound) = sums::<_, true, true, true>(simd, receiver, emitter, plan.power, unit)?;
        Some((terms, bound?))
    })
}

/// The sums of a polygon that the horizon cuts. A function of its own, so that its registers do not slow the common case.
#[inline(never)]
fn cut<S: Simd>(
    simd: S,
    receiver: &Receiver,
    emitter: &Emitter,
    power: f64,
    unit: f64,
) -> Option<(IrradianceAndGradient<f64>, LinearBound)> {
    simd.vectorize(
        #[inline(always)]
        || {
            let polygon = emitter.polygon();
            let [edges] = polygon.four_edges() else { return None };
            let count = polygon.vertices().len();
            let height = height_over_plane(simd, receiver, polygon, power);
            let mut sum = LinearSum::new(SeenLinear::from(receiver, emitter, power, height));
            let Cut { four, visible, closing, moved, closing_moved } = Cut::new(simd, receiver, edges, count, power)?;
            let added = sum.add_four::<S, true>(simd, &four, Some(visible), count)?;
            let horizon = HorizonSegment::new(&sum.seen, closing);
            horizon.add_to(&mut sum);
            let terms = sum.total();
            let mut errors = Errors::new(&sum, receiver, emitter, power, unit)?;
            errors.add_arc();
            errors.add_four::<S, true>(simd, &sum, (&four, &added), Some((visible, moved)), count)?;
            errors.add_horizon(&sum, &horizon, closing_moved)?;
            let bound = errors.bound(&sum, &terms);
            (bound.radiosity + bound.gradient).is_finite().then_some((terms, bound))
        },
    )
}

/// The same of a polygon whose visible part is sure; the sums where its size is more than `narrow` of the distance of its farthest
/// vertex, and the horizon leaves enough of it for a relative tolerance.
#[inline]
pub(crate) fn bounded_where_sure(
    receiver: &Receiver,
    emitter: &Emitter,
    narrow: f64,
    tolerance: f64,
) -> Option<SureCase<LinearBound>> {
    in_library!(*INSTRUCTION_SET, simd => {
        let plan = plan(simd, receiver, emitter.polygon())?;
        if emitter.polygon().size() * plan.power <= narrow {
            return Some(SureCase { plan, sums: None });
        }
        let sums = match plan.horizon {
            Horizon::Above => match sums::<_, true, true, false>(simd, receiver, emitter, plan.power, ROUNDOFF) {
                Some((terms, Some(bound))) => Some((terms, bound)),
                _ => None,
            },
            Horizon::Crossing if light_left(receiver, emitter.polygon(), plan.power) * tolerance < FAINT => None,
            Horizon::Crossing => cut(simd, receiver, emitter, plan.power, ROUNDOFF),
        };
        Some(SureCase { plan, sums })
    })
}

/// Measured size of the bounds of cut emitters over the emission: no bound meets a tolerance that allows less.
const FAINT: f64 = 120.0 * ROUNDOFF;

/// A guess at the light that the horizon leaves, over the emission: the cosine at the highest vertex, times the solid angle of a
/// square, times the square of the part of its height that is visible. Where it is wrong an attempt is in vain, or a dearer rung
/// answers; no bound rests on it.
#[inline]
fn light_left(receiver: &Receiver, polygon: &Polygon, power: f64) -> f64 {
    let (mut lowest, mut highest, mut square) = (f64::INFINITY, f64::NEG_INFINITY, 0.0);
    for vertex in polygon.vertices() {
        let r = (*vertex - receiver.position()) * power;
        let (height, length) = (receiver.normal().dot(r), r.length_squared());
        (lowest, highest) = (if height < lowest { height } else { lowest }, if height > highest { height } else { highest });
        square = if length > square { length } else { square };
    }
    let (size, part) = (polygon.size() * power, highest / (highest - lowest));
    let depth = polygon.normal().dot(receiver.position() - polygon.vertices()[0]) * power;
    // From nearby it may fill half of the sky.
    if depth < 0.5 * size { 1.0 } else { highest * part * part * depth * size * size / (square * square) }
}

/// The same of a polygon that the horizon cuts where products of lengths leave the range; of others the rungs that follow find it.
#[cold]
#[inline(never)]
pub(crate) fn bounded_far_out(receiver: &Receiver, emitter: &Emitter, narrow: f64) -> Option<SureCase<LinearBound>> {
    let plan = plan_far_out(receiver, emitter.polygon()).filter(|plan| plan.horizon == Horizon::Crossing)?;
    let is_narrow = emitter.polygon().size() * plan.power <= narrow;
    let bounded = || in_library!(*INSTRUCTION_SET, simd => cut(simd, receiver, emitter, plan.power, ROUNDOFF));
    Some(SureCase { plan, sums: if is_narrow { None } else { bounded() } })
}

/// Unless `WIDE`, only where no edge passes near, and bounds only where none is seen past a quarter turn.
#[inline(always)]
fn sums<S: Simd, const GRADIENT: bool, const BOUND: bool, const WIDE: bool>(
    simd: S,
    receiver: &Receiver,
    emitter: &Emitter,
    power: f64,
    unit: f64,
) -> Option<(IrradianceAndGradient<f64>, Option<LinearBound>)> {
    let polygon = emitter.polygon();
    let mut sum = LinearSum::new(SeenLinear::from(receiver, emitter, power, height_over_plane(simd, receiver, polygon, power)));
    let mut errors = if BOUND { Some(Errors::new(&sum, receiver, emitter, power, unit)?) } else { None };
    let x = splat_vector(simd, receiver.position());
    let mut remaining = polygon.vertices().len();
    let fours = polygon.four_edges();
    for four in fours {
        let four = EdgeLanes::new::<WIDE>(simd, four, x, f64x4::splat(simd, power), fours.len() == 1)?;
        let count = remaining.min(4);
        let added = sum.add_four::<S, GRADIENT>(simd, &four, None, count)?;
        if let Some(errors) = &mut errors {
            errors.add_four::<S, WIDE>(simd, &sum, (&four, &added), None, count)?;
        }
        remaining -= count;
    }
    let terms = sum.total();
    let mut bound = None;
    if let Some(errors) = &errors {
        bound = Some(errors.bound(&sum, &terms));
    }
    Some((terms, bound))
}

impl<S: Simd> SeenLinear<f64x4<S>> {
    /// The same in all lanes.
    #[inline(always)]
    fn on_lanes(simd: S, SeenLinear { n1, n2, height, beta, gradient }: SeenLinear<f64>) -> Self {
        Self {
            n1: splat_vector(simd, n1.into()),
            n2: splat_vector(simd, n2.into()),
            height: f64x4::splat(simd, height),
            beta: f64x4::splat(simd, beta),
            gradient: splat_vector(simd, gradient.into()),
        }
    }
}

impl LinearSum<f64> {
    /// As [`LinearSum::add`] for the first `count` lanes, of them those that are visible, where all is sure.
    #[inline(always)]
    pub(super) fn add_four<S: Simd, const GRADIENT: bool>(
        &mut self,
        simd: S,
        four: &EdgeLanes<S>,
        visible: Option<mask64x4<S>>,
        count: usize,
    ) -> Option<Added<S>> {
        let EdgeLanes { arc, line, .. } = four;
        let (seen, frame) = (SeenLinear::on_lanes(simd, self.seen), line.frame());
        let square = seen.height * seen.height;
        let logarithms = four.at_ends(
            #[inline(always)]
            |end| of_normal(end.square / square) * f64x4::splat(simd, 0.5),
        );
        let contour = seen.contour(arc, &frame, logarithms);
        let x1 = X1::new(simd, arc, &frame, contour.kappa, logarithms)?;
        self.angles = plus_first(self.angles, only(simd, visible, frame.normal * arc.angle), count);
        self.contour = plus_first(self.contour, only(simd, visible, contour.outward * contour.flux), count);
        let term = match visible {
            Some(visible) => visible.select(x1.term, f64x4::splat(simd, 0.0)),
            None => x1.term,
        };
        self.x1 = number_plus_first(self.x1, term, count);
        let cosines = four.at_ends(
            #[inline(always)]
            |end| seen.cosine(end),
        );
        let emissions = four.at_ends(
            #[inline(always)]
            |end| seen.emission(end),
        );
        if GRADIENT {
            let mut weight = arc.within_a_quarter_turn(emissions, cosines);
            let wide = arc.inline.simd_lt(f64x4::splat(simd, 0.0));
            if wide.any_true() {
                weight = wide.select(seen.toward(&frame, &arc.moments(&frame)) / frame.distance, weight);
            }
            self.edges = plus_first(self.edges, only(simd, visible, frame.normal * -weight), count);
        }
        Some(Added { logarithms, contour, x1, cosines, emissions })
    }
}

/// The terms of the lanes that are visible.
#[inline(always)]
pub(crate) fn only<S: Simd>(simd: S, visible: Option<mask64x4<S>>, terms: Vec3<f64x4<S>>) -> Vec3<f64x4<S>> {
    let zero = f64x4::splat(simd, 0.0);
    match visible {
        Some(visible) => chosen(visible, terms, Vec3::new(zero, zero, zero)),
        None => terms,
    }
}

/// The segment in which the horizon meets the emitter, with the quantities that bound its errors.
pub(crate) struct HorizonSegment {
    pub(crate) arc: Arc<f64>,
    pub(crate) frame: Frame<f64>,
    /// `ln(r/h)` at the ends.
    pub(crate) logarithms: [f64; 2],
    pub(crate) contour: ContourTerm<f64>,
    /// The magnitudes of s, and the ends of the segment's part of X1.
    pub(crate) s: [f64; 2],
    pub(crate) d: f64,
    pub(crate) ends: [X1End<f64>; 2],
    pub(crate) term: f64,
    pub(crate) quotient: f64,
}

impl HorizonSegment {
    /// As [`LinearSum::add`] has it.
    #[inline(always)]
    fn new(seen: &SeenLinear<f64>, arc: Arc<f64>) -> Self {
        let frame = met_frame(arc.generator.normal(), seen.n2, seen.height);
        let logarithms = logarithms(&arc, seen.height);
        let contour = seen.contour(&arc, &frame, logarithms);
        let signed = frame.distance * contour.kappa;
        let (d, along) = (signed.abs(), [arc.start.point.dot(frame.along), arc.end.point.dot(frame.along)]);
        let distances = [d, frame.distance, frame.distance + d];
        let ends = [0, 1].map(|i| X1End::new(along[i].abs(), distances, logarithms[i]));
        let (term, quotient) = x1_between([ends[0].on_side_of(along[0]), ends[1].on_side_of(along[1])], signed);
        let (term, s) = (if signed == 0.0 { 0.0 } else { term }, along.map(f64::abs));
        Self { arc, frame, logarithms, contour, s, d, ends, term, quotient }
    }

    #[inline(always)]
    fn add_to(&self, sum: &mut LinearSum<f64>) {
        sum.angles = sum.angles + self.frame.normal * self.arc.angle;
        sum.contour = sum.contour + self.contour.outward * self.contour.flux;
        sum.x1 += self.term;
    }
}

/// The contributions of four arcs, for the bound on their error.
pub(crate) struct Added<S: Simd> {
    /// `ln(r/h)` at the ends.
    pub(crate) logarithms: [f64x4<S>; 2],
    pub(crate) contour: ContourTerm<f64x4<S>>,
    pub(crate) x1: X1<S>,
    /// n1 along the directions of the ends, and the emission there over the distance.
    pub(crate) cosines: [f64x4<S>; 2],
    pub(crate) emissions: [f64x4<S>; 2],
}

/// The contributions of four segments to X1, and the quantities of both their ends, the starts before the ends.
pub(crate) struct X1<S: Simd> {
    pub(crate) term: f64x4<S>,
    /// The magnitude of s.
    pub(crate) s: f64x8<S>,
    pub(crate) d: f64x8<S>,
    pub(crate) distance: f64x8<S>,
    pub(crate) ends: X1End<f64x8<S>>,
    /// The logarithm of the quotient.
    pub(crate) quotient: f64x4<S>,
}

#[inline(always)]
pub(crate) fn both<S: Simd>(simd: S, [start, end]: [f64x4<S>; 2]) -> f64x8<S> {
    simd.combine_f64x4(start, end)
}

impl<S: Simd> X1<S> {
    /// As [`crate::forms::segment::x1_term`], with both ends of the four segments side by side; where all is sure.
    #[inline(always)]
    fn new(simd: S, arc: &Arc<f64x4<S>>, frame: &Frame<f64x4<S>>, kappa: f64x4<S>, logarithms: [f64x4<S>; 2]) -> Option<Self> {
        let (signed, zero) = (frame.distance * kappa, f64x4::splat(simd, 0.0));
        let (d, distance) = (both(simd, [signed.abs(); 2]), both(simd, [frame.distance; 2]));
        let along = both(simd, [arc.start.point.dot(frame.along), arc.end.point.dot(frame.along)]);
        let s = along.abs();
        // Then so are those of s and S, which is at least d but for roundings.
        if !is_in_range(s, d).all_true() {
            return None;
        }
        let ends = X1End::new(s, [d, distance, distance + d], both(simd, logarithms));
        let [term, above, below] = ends.on_side_of(along);
        let (term, above, below) = (simd.split_f64x8(term), simd.split_f64x8(above), simd.split_f64x8(below));
        let (term, quotient) = x1_between([[term.0, above.0, below.0], [term.1, above.1, below.1]], signed);
        let term = signed.simd_eq(zero).select(zero, term);
        Some(Self { term, s, d, distance, ends, quotient })
    }
}

#[cfg(test)]
mod tests {
    use rand::{SeedableRng, rngs::ChaCha8Rng};

    use super::*;
    use crate::boundary::horizon;
    use crate::forms::edge_lanes::random::{polygon_and_receiver, vector};
    use crate::problem::emission::Emission;
    use radgrad_numbers::lanes::instruction_set::instruction_sets;
    use radgrad_numbers::on_instruction_set;

    #[test]
    fn side_by_side_gives_the_digits_of_one_by_one_on_every_instruction_set() {
        let mut random = ChaCha8Rng::seed_from_u64(9);
        let mut counts = [0; 2];
        for i in 0..4000 {
            let (count, spread) = (3 + i % 7, [5.0, 1.5][i / 7 % 2]);
            let Some((polygon, receiver, size)) = polygon_and_receiver(&mut random, count, spread) else { continue };
            let emitter = Emitter::new(polygon, Emission::gradient(1.0, vector(&mut random, 1.0 / size))).unwrap();
            let Some(plan) = Plan::new(&receiver, emitter.polygon()) else { continue };
            let mut first = None;
            for level in instruction_sets() {
                let terms = on_instruction_set!(level, simd => match plan.horizon {
                    Horizon::Above => sums::<_, true, false, false>(simd, &receiver, &emitter, plan.power, ROUNDOFF).map(|terms| terms.0),
                    Horizon::Crossing => cut(simd, &receiver, &emitter, plan.power, ROUNDOFF).map(|terms| terms.0),
                });
                let digits = terms.map(|terms| (terms.irradiance, terms.gradient));
                assert_eq!(*first.get_or_insert(digits), digits, "{level:?}");
            }
            let Some((irradiance, gradient)) = first.flatten() else { continue };
            counts[usize::from(plan.horizon == Horizon::Crossing)] += 1;
            let mut sum = LinearSum::<f64>::new(SeenLinear::new(&receiver, &emitter, plan.power));
            horizon::visit_boundary(&receiver, emitter.polygon(), &plan, |arc| sum.add::<true>(arc));
            let one_by_one = sum.total();
            assert_eq!((one_by_one.irradiance, one_by_one.gradient), (irradiance, gradient), "{receiver:?} {emitter:?}");
            if let Some((_, terms)) = sure::<false>(&receiver, &emitter) {
                assert_eq!(terms.irradiance, irradiance);
            }
        }
        println!("{counts:?} found whole and cut");
        assert!(counts[0] > 700 && counts[1] > 50, "{counts:?}");
    }
}
