//! The sums of a constant emitter and bounds on their errors, four edges at a time, one a lane of a vector: the digits of the sums
//! of [`crate::forms::constant`], where double precision is sure of all decisions ([`crate::forms::edge_lanes`]), and the bounds
//! of [`crate::forms::constant_bound`] but for the order of their sums. The horizon may cut a polygon of up to four vertices.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f64x4, mask64x4};
use radgrad_numbers::in_library;
use radgrad_numbers::lanes::vectors::{plus_first, splat_vector};
use radgrad_numbers::number::ROUNDOFF;
use radgrad_numbers::vec3::Vec3;

use crate::boundary::line::LEAST_MOMENT;
use crate::boundary::plan::{Horizon, Plan};
use crate::forms::constant_bound::{AngleError, BoundedSum, Weighed, of_horizon};
use crate::forms::edge_lanes::cut::Cut;
use crate::forms::edge_lanes::{EdgeLanes, INSTRUCTION_SET, SureCase, plan, without_power};
use crate::forms::irradiance_and_gradient::IrradianceAndGradient;
use crate::problem::polygon::Polygon;
use crate::problem::receiver::Receiver;

/// The sums for a unit emission, and bounds on their errors where they were requested.
type SumsAndBound = (IrradianceAndGradient<f64>, Option<BoundedSum>);

/// The plan and the sums for a unit emission, where double precision is sure of all decisions.
#[inline]
pub(crate) fn sure<const VALUE: bool, const GRADIENT: bool>(
    receiver: &Receiver,
    polygon: &Polygon,
) -> Option<(Plan, IrradianceAndGradient<f64>)> {
    in_library!(*INSTRUCTION_SET, simd => {
        let plan = plan(simd, receiver, polygon)?;
        sums::<_, VALUE, GRADIENT, false, _>(
            simd,
            receiver,
            polygon,
            &plan,
            #[inline(always)]
            |(terms, _)| Some((plan, terms)),
        )
    })
}

/// The sums and their bounds, where double precision is sure of all decisions.
#[inline]
pub(crate) fn bounded(receiver: &Receiver, polygon: &Polygon, plan: &Plan) -> Option<(IrradianceAndGradient<f64>, BoundedSum)> {
    in_library!(*INSTRUCTION_SET, simd => sums::<_, true, true, true, _>(simd, receiver, polygon, plan, with_bound))
}

/// As [`BoundedSum::where_sure`].
#[inline]
pub(crate) fn bounded_where_sure(receiver: &Receiver, polygon: &Polygon, narrow: f64) -> Option<SureCase<BoundedSum>> {
    in_library!(*INSTRUCTION_SET, simd => {
        let plan = plan(simd, receiver, polygon)?;
        if polygon.size() * plan.power <= narrow {
            return Some(SureCase { plan, sums: None });
        }
        Some(SureCase { plan, sums: sums::<_, true, true, true, _>(simd, receiver, polygon, &plan, with_bound) })
    })
}

#[inline(always)]
fn with_bound((terms, bound): SumsAndBound) -> Option<(IrradianceAndGradient<f64>, BoundedSum)> {
    Some((terms, bound?))
}

/// Calls `answer` on the sums, in each branch by itself: a call returns its result in memory, and where the branches met before it
/// the common case would be copied to memory too.
#[inline(always)]
fn sums<S: Simd, const VALUE: bool, const GRADIENT: bool, const BOUND: bool, A>(
    simd: S,
    receiver: &Receiver,
    polygon: &Polygon,
    plan: &Plan,
    answer: impl Fn(SumsAndBound) -> Option<A>,
) -> Option<A> {
    if plan.horizon == Horizon::Above {
        if BOUND {
            if let Some(narrow) = whole::<_, VALUE, GRADIENT, BOUND, false>(simd, receiver, polygon, plan.power) {
                return answer(narrow);
            }
        } else if let Some(terms) = without_power(
            plan,
            #[inline(always)]
            |power| Some(whole::<_, VALUE, GRADIENT, BOUND, false>(simd, receiver, polygon, power)?.0),
        ) {
            return answer((terms, None));
        }
    }
    answer(cut_or_wide::<_, VALUE, GRADIENT, BOUND>(simd, receiver, polygon, plan)?)
}

/// A function of its own, so that its registers do not slow the common case.
#[inline(never)]
fn cut_or_wide<S: Simd, const VALUE: bool, const GRADIENT: bool, const BOUND: bool>(
    simd: S,
    receiver: &Receiver,
    polygon: &Polygon,
    plan: &Plan,
) -> Option<SumsAndBound> {
    simd.vectorize(
        #[inline(always)]
        || match plan.horizon {
            Horizon::Above => whole::<_, VALUE, GRADIENT, BOUND, true>(simd, receiver, polygon, plan.power),
            Horizon::Crossing => cut::<_, VALUE, GRADIENT, BOUND>(simd, receiver, polygon, plan.power),
        },
    )
}

/// The sums of a polygon that is fully visible; unless `WIDE`, only where no edge that matters passes near or is seen past a
/// quarter turn.
#[inline(always)]
fn whole<S: Simd, const VALUE: bool, const GRADIENT: bool, const BOUND: bool, const WIDE: bool>(
    simd: S,
    receiver: &Receiver,
    polygon: &Polygon,
    power: f64,
) -> Option<SumsAndBound> {
    let (x, n1) = (splat_vector(simd, receiver.position()), splat_vector(simd, receiver.normal()));
    let mut sums = LaneSums::default();
    let mut remaining = polygon.vertices().len();
    let additions = (remaining - 1) as f64 * ROUNDOFF;
    let fours = polygon.four_edges();
    for four in fours {
        let four = EdgeLanes::new::<WIDE>(simd, four, x, f64x4::splat(simd, power), fours.len() == 1)?;
        let count = remaining.min(4);
        remaining -= count;
        sums.add::<_, VALUE, GRADIENT, BOUND, WIDE>(
            simd,
            (&four, n1),
            (additions, None),
            #[inline(always)]
            |sum, terms| plus_first(sum, terms, count),
        )?;
    }
    Some(sums.total::<BOUND>())
}

#[inline(always)]
fn cut<S: Simd, const VALUE: bool, const GRADIENT: bool, const BOUND: bool>(
    simd: S,
    receiver: &Receiver,
    polygon: &Polygon,
    power: f64,
) -> Option<SumsAndBound> {
    let [edges] = polygon.four_edges() else { return None };
    let (n1, count) = (splat_vector(simd, receiver.normal()), polygon.vertices().len());
    let part = Cut::new(simd, receiver, edges, count, power)?;
    let Cut { four, closing, .. } = &part;
    let nearest = four.arc.start.square.min(four.arc.end.square);
    // As `Moved`, at the nearer end.
    let eta = (f64x4::splat(simd, 10.4) / nearest.sqrt() + 3.0) * ROUNDOFF;
    // At most one arc more than edges.
    let additions = count as f64 * ROUNDOFF;
    let mut sums = LaneSums::default();
    sums.add::<_, VALUE, GRADIENT, BOUND, true>(
        simd,
        (four, n1),
        (additions, Some(eta)),
        #[inline(always)]
        |sum, terms| part.add(simd, sum, terms, count),
    )?;
    if VALUE {
        sums.angles = sums.angles + closing.generator.normal() * closing.angle;
    }
    if BOUND {
        let (of_angle, slope) = of_horizon(closing);
        sums.others.x = sums.others.x + of_angle + closing.angle.abs() * additions;
        sums.others.z = slope;
        if !sums.others.x.is_finite() {
            return None;
        }
    }
    Some(sums.total::<BOUND>())
}

/// Sums over arcs: of their terms; of their errors along their normals, by components; and of the errors of angles, of weights
/// across the normals, and of the horizon's end points.
#[derive(Debug, Clone, Copy, Default)]
struct LaneSums {
    angles: Vec3<f64>,
    edges: Vec3<f64>,
    along: Vec3<f64>,
    others: Vec3<f64>,
}

impl LaneSums {
    /// `plus` adds lanes to a sum. The errors include so many roundings of sums, and the displacement of cut ends.
    #[inline(always)]
    fn add<S: Simd, const VALUE: bool, const GRADIENT: bool, const BOUND: bool, const WIDE: bool>(
        &mut self,
        simd: S,
        (four, n1): (&EdgeLanes<S>, Vec3<f64x4<S>>),
        (additions, moved): (f64, Option<f64x4<S>>),
        plus: impl Fn(Vec3<f64>, Vec3<f64x4<S>>) -> Vec3<f64>,
    ) -> Option<()> {
        let (normal, g) = (four.line.normal, four.arc.angle);
        if VALUE {
            self.angles = plus(self.angles, normal * g);
        }
        if !GRADIENT {
            return Some(());
        }
        let weight = Weight::new::<WIDE>(simd, four, n1)?;
        self.edges = plus(self.edges, normal * -weight.weight);
        if BOUND {
            if !four.line.moment.simd_ge(f64x4::splat(simd, LEAST_MOMENT)).all_true() {
                return None;
            }
            let ew = four.relative_error() * ROUNDOFF;
            let of_angle = AngleError::new(g, g.min(f64x4::splat(simd, 1.0)), ew, moved);
            let (mut size, mut error) = of_angle.of_weight(&weight.weighed);
            if let Some(wide) = weight.wide {
                let of_wide = of_angle.of_wide_weight(four.line.nearness());
                (size, error) = (wide.select(of_wide.0, size), wide.select(of_wide.1, error));
            }
            let of_term = of_angle.of_term(n1.dot(normal).abs()) + g * additions;
            self.along = plus(self.along, Vec3::new(normal.x.abs(), normal.y.abs(), normal.z.abs()) * error);
            self.others = plus(self.others, Vec3::new(of_term, size * (ew + additions), f64x4::splat(simd, 0.0)));
        }
        Some(())
    }

    #[inline(always)]
    fn total<const BOUND: bool>(self) -> SumsAndBound {
        let Self { angles, edges, along, others } = self;
        let terms = IrradianceAndGradient { irradiance: angles * -0.5, gradient: edges };
        let bound = if BOUND { Some(BoundedSum::new(&terms, others.x, along.norm() + others.y + others.z)) } else { None };
        (terms, bound)
    }
}

/// The weights of arcs as in [`crate::boundary::arc::Arc::weight`], with the quantities that bound their errors.
pub(crate) struct Weight<S: Simd> {
    pub(crate) weight: f64x4<S>,
    pub(super) weighed: Weighed<f64x4<S>>,
    /// Where arcs are past a quarter turn, if any is.
    pub(crate) wide: Option<mask64x4<S>>,
}

impl<S: Simd> Weight<S> {
    /// Unless `WIDE`, only of arcs up to a quarter turn.
    #[inline(always)]
    pub(crate) fn new<const WIDE: bool>(simd: S, four: &EdgeLanes<S>, n1: Vec3<f64x4<S>>) -> Option<Self> {
        let EdgeLanes { arc, line, .. } = four;
        let wide = arc.inline.simd_lt(f64x4::splat(simd, 0.0));
        if !WIDE && wide.any_true() {
            return None;
        }
        let cosines = four.at_ends(
            #[inline(always)]
            |end| end.cosine(n1),
        );
        let mut weight = arc.within_a_quarter_turn([arc.start.inverse, arc.end.inverse], cosines);
        let is_wide = WIDE && wide.any_true();
        if is_wide {
            weight = wide.select(arc.weight_in_frame(line, n1), weight);
        }
        Some(Self { weight, weighed: Weighed::new(arc, cosines), wide: if is_wide { Some(wide) } else { None } })
    }
}

#[cfg(test)]
mod tests {
    use rand::{SeedableRng, rngs::ChaCha8Rng};

    use super::*;
    use crate::boundary::horizon;
    use crate::forms::constant::{EdgeSum, SolidAngleVector};
    use crate::forms::edge_lanes::random::{polygon_and_receiver, vector};
    use radgrad_numbers::lanes::instruction_set::instruction_sets;
    use radgrad_numbers::on_instruction_set;

    #[test]
    fn side_by_side_gives_the_digits_of_one_by_one_on_every_instruction_set() {
        let mut random = ChaCha8Rng::seed_from_u64(8);
        let (mut whole, mut cut) = (0, 0);
        for i in 0..6000 {
            let looks_aside = i % 2 == 0;
            let count = if looks_aside { 3 + i / 2 % 2 } else { 3 + i % 7 };
            let Some((polygon, mut receiver, _)) = polygon_and_receiver(&mut random, count, 4.0) else { continue };
            if looks_aside {
                receiver = Receiver::new(receiver.position(), vector(&mut random, 1.0), 1.0).unwrap();
            }
            let mut first = None;
            for level in instruction_sets() {
                let planned = on_instruction_set!(level, simd => plan(simd, &receiver, &polygon)
                    .and_then(|plan| Some((plan, sums::<_, true, true, false, _>(simd, &receiver, &polygon, &plan, Some)?.0))));
                let digits = planned.map(|(plan, terms)| (plan.power, plan.horizon, terms.irradiance, terms.gradient));
                assert_eq!(*first.get_or_insert(digits), digits, "{level:?}");
            }
            let Some((power, horizon, irradiance, gradient)) = first.flatten() else { continue };
            *(if horizon == Horizon::Above { &mut whole } else { &mut cut }) += 1;
            let plan = Plan::new(&receiver, &polygon).unwrap();
            let (mut angles, mut edges) = (SolidAngleVector::zero(), EdgeSum::new(receiver.normal().into()));
            horizon::visit_boundary::<f64>(&receiver, &polygon, &plan, |arc| {
                angles.add(arc);
                edges.add(arc);
            });
            assert_eq!((plan.power, plan.horizon), (power, horizon));
            assert_eq!((angles.phi(), edges.sum()), (irradiance, gradient), "{receiver:?} {polygon:?}");
            assert_eq!(sure::<true, false>(&receiver, &polygon).unwrap().1.irradiance, irradiance);
            assert_eq!(sure::<false, true>(&receiver, &polygon).unwrap().1.gradient, gradient);
        }
        println!("{whole} whole, {cut} cut");
        assert!(whole > 1000 && cut > 300, "{whole} {cut}");
    }

    #[test]
    fn bounds_side_by_side_are_those_of_one_by_one() {
        let mut random = ChaCha8Rng::seed_from_u64(9);
        let (mut whole, mut cut) = (0, 0);
        for i in 0..4000 {
            let looks_aside = i % 2 == 0;
            let count = if looks_aside { 3 + i / 2 % 2 } else { 3 + i % 7 };
            let Some((polygon, mut receiver, _)) = polygon_and_receiver(&mut random, count, 3.0) else { continue };
            if looks_aside {
                receiver = Receiver::new(receiver.position(), vector(&mut random, 1.0), 1.0).unwrap();
            }
            let Some(plan) = Plan::new(&receiver, &polygon) else { continue };
            let Some((terms, bound)) = bounded(&receiver, &polygon, &plan) else { continue };
            *(if plan.horizon == Horizon::Above { &mut whole } else { &mut cut }) += 1;
            let SureCase { plan: same_plan, sums } = bounded_where_sure(&receiver, &polygon, 0.0).unwrap();
            let (same_terms, same_bound) = sums.unwrap();
            let of_bound = |bound: &BoundedSum| [bound.irradiance, bound.gradient];
            assert_eq!((same_plan.power, same_plan.horizon), (plan.power, plan.horizon));
            assert_eq!((same_terms.irradiance, same_terms.gradient), (terms.irradiance, terms.gradient));
            assert_eq!(of_bound(&same_bound), of_bound(&bound));
            let (one_by_one, expected) = BoundedSum::one_by_one(&receiver, &polygon, &plan);
            assert_eq!((terms.irradiance, terms.gradient), (one_by_one.irradiance, one_by_one.gradient));
            // The bound of a cut polygon counts additions as if the horizon had left all edges.
            let room = if plan.horizon == Horizon::Above { 1e-13 } else { 0.1 };
            for (bound, expected) in [(bound.irradiance, expected.irradiance), (bound.gradient, expected.gradient)] {
                let more = bound / expected - 1.0;
                assert!(more > -1e-13 && more < room, "{bound:e} {expected:e}");
            }
        }
        println!("{whole} whole, {cut} cut");
        assert!(whole > 500 && cut > 200, "{whole} {cut}");
    }
}
