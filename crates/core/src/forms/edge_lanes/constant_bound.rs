//! The sums and bounds of [`crate::forms::constant_bound`], four edges at a time, one a lane of a vector: the sums are those of
//! [`crate::forms::edge_lanes::constant`], and the bounds the same but for the order of their sums.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f64x4};

use crate::boundary::plan::{Horizon, Plan};
use crate::forms::constant_bound::{AngleError, BoundedSum, Displacement, FRACTION, LEAST_MOMENT, Still, of_horizon};
use crate::forms::edge_lanes::constant::Weight;
use crate::forms::edge_lanes::cut::Cut;
use crate::forms::edge_lanes::{EdgeLanes, SureCase, plan};
use crate::forms::irradiance_and_gradient::IrradianceAndGradient;
use crate::lanes::instruction_set::{INSTRUCTION_SET, on_instruction_set};
use crate::lanes::vectors::{all, plus_first};
use crate::problem::polygon::Polygon;
use crate::problem::receiver::Receiver;
use crate::scalar::number::ROUNDOFF;
use crate::scalar::vec3::Vec3;

/// The sums and their bounds, where double precision is sure of all decisions.
#[inline]
pub(crate) fn bounded(receiver: &Receiver, polygon: &Polygon, plan: &Plan) -> Option<(IrradianceAndGradient<f64>, BoundedSum)> {
    on_instruction_set!(*INSTRUCTION_SET, simd => {
        let whole = if plan.horizon == Horizon::Above { whole::<_, false>(simd, receiver, polygon, plan.power) } else { None };
        whole.or_else(|| cut_or_wide(simd, receiver, polygon, plan))
    })
}

/// As [`BoundedSum::where_sure`].
#[inline]
pub(crate) fn bounded_where_sure(receiver: &Receiver, polygon: &Polygon, narrow: f64) -> Option<SureCase<BoundedSum>> {
    on_instruction_set!(*INSTRUCTION_SET, simd => {
        let plan = plan(simd, receiver, polygon)?;
        if polygon.size() * plan.power <= narrow {
            return Some(SureCase { plan, sums: None });
        }
        if plan.horizon == Horizon::Above
            && let sums @ Some(_) = whole::<_, false>(simd, receiver, polygon, plan.power)
        {
            return Some(SureCase { plan, sums });
        }
        Some(SureCase { plan, sums: cut_or_wide(simd, receiver, polygon, &plan) })
    })
}

/// Apart, so that its registers do not cost what is ordinary.
#[inline(never)]
fn cut_or_wide<S: Simd>(
    simd: S,
    receiver: &Receiver,
    polygon: &Polygon,
    plan: &Plan,
) -> Option<(IrradianceAndGradient<f64>, BoundedSum)> {
    simd.vectorize(
        #[inline(always)]
        || match plan.horizon {
            Horizon::Above => whole::<_, true>(simd, receiver, polygon, plan.power),
            Horizon::Crossing => cut(simd, receiver, polygon, plan.power),
        },
    )
}

/// The terms of arcs, and what they err by: along their normals, by components; and of the angles, and of the weights across.
struct Bounded<S: Simd> {
    angle: Vec3<f64x4<S>>,
    edge: Vec3<f64x4<S>>,
    along: Vec3<f64x4<S>>,
    others: Vec3<f64x4<S>>,
}

impl<S: Simd> Bounded<S> {
    /// What so many roundings of sums add is in it, and what cut ends are moved by.
    #[inline(always)]
    fn new<D: Displacement<f64x4<S>>, const WIDE: bool>(
        simd: S,
        four: &EdgeLanes<S>,
        n1: Vec3<f64x4<S>>,
        additions: f64,
        moved: (D, f64),
    ) -> Option<Self> {
        if !four.line.moment.simd_ge(f64x4::splat(simd, LEAST_MOMENT)).all_true() {
            return None;
        }
        let found = Weight::new::<WIDE>(simd, four, n1)?;
        let (g, ew) = (four.arc.angle, four.relative_error() * ROUNDOFF);
        let of_angle = AngleError::new(g, g.min(f64x4::splat(simd, 1.0)), ew, moved);
        let (mut size, mut error) = of_angle.of_weight(&found.weighed);
        if let Some(wide) = found.wide {
            let of_wide = of_angle.of_wide_weight(four.line.nearness());
            (size, error) = (wide.select(of_wide.0, size), wide.select(of_wide.1, error));
        }
        let normal = four.line.normal;
        let of_term = of_angle.of_term(n1.dot(normal).abs()) + g * additions;
        Some(Self {
            angle: normal * g,
            edge: normal * -found.weight,
            along: Vec3::new(normal.x.abs(), normal.y.abs(), normal.z.abs()) * error,
            others: Vec3::new(of_term, size * (ew + additions), f64x4::splat(simd, 0.0)),
        })
    }
}

/// Of a polygon that is seen whole; unless `WIDE`, only where no edge passes near or is seen past a quarter turn.
#[inline(always)]
fn whole<S: Simd, const WIDE: bool>(
    simd: S,
    receiver: &Receiver,
    polygon: &Polygon,
    power: f64,
) -> Option<(IrradianceAndGradient<f64>, BoundedSum)> {
    let fours = polygon.four_edges();
    let (x, n1) = (all(simd, receiver.position()), all(simd, receiver.normal()));
    let (mut angles, mut edges, mut along, mut others) = (Vec3::default(), Vec3::default(), Vec3::default(), Vec3::default());
    let mut rest = polygon.vertices().len();
    let additions = (rest - 1) as f64 * ROUNDOFF;
    for four in fours {
        let four = EdgeLanes::new::<WIDE>(simd, four, x, f64x4::splat(simd, power), fours.len() == 1)?;
        let terms = Bounded::new::<_, WIDE>(simd, &four, n1, additions, (Still, 0.0))?;
        let count = rest.min(4);
        rest -= count;
        angles = plus_first(angles, terms.angle, count);
        edges = plus_first(edges, terms.edge, count);
        along = plus_first(along, terms.along, count);
        others = plus_first(others, terms.others, count);
    }
    let terms = IrradianceAndGradient { irradiance: angles * -0.5, gradient: edges };
    let bound = BoundedSum::new(&terms, others.x, along.norm() + others.y);
    Some((terms, bound))
}

#[inline(always)]
fn cut<S: Simd>(simd: S, receiver: &Receiver, polygon: &Polygon, power: f64) -> Option<(IrradianceAndGradient<f64>, BoundedSum)> {
    let [edges] = polygon.four_edges() else { return None };
    let (n1, count) = (all(simd, receiver.normal()), polygon.vertices().len());
    let part = Cut::new(simd, receiver, edges, count, power)?;
    let Cut { four, closing, .. } = &part;
    let nearest = four.arc.start.square.min(four.arc.end.square);
    // As `Moved`, at the nearer end.
    let eta = (f64x4::splat(simd, 10.4) / nearest.sqrt() + 3.0) * ROUNDOFF;
    // At most one arc more than edges.
    let additions = count as f64 * ROUNDOFF;
    let terms = Bounded::new::<_, true>(simd, four, n1, additions, (eta, FRACTION))?;
    let (angles, edges) = (part.sum(simd, terms.angle, count), part.sum(simd, terms.edge, count));
    let (along, others) = (part.sum(simd, terms.along, count), part.sum(simd, terms.others, count));
    let angles = (angles + closing.generator.normal() * closing.angle) * -0.5;
    let terms = IrradianceAndGradient { irradiance: angles, gradient: edges };
    let (angle_errors, slope) = of_horizon(closing);
    let angle_errors = others.x + angle_errors + closing.angle.abs() * additions;
    let bound = BoundedSum::new(&terms, angle_errors, along.norm() + others.y + slope);
    angle_errors.is_finite().then_some((terms, bound))
}

#[cfg(test)]
mod tests {
    use rand::{SeedableRng, rngs::ChaCha8Rng};

    use super::*;
    use crate::boundary::plan::{Horizon, Plan};
    use crate::forms::edge_lanes::random::{polygon_and_receiver, vector};

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
            // What is cut counts as if the horizon had left all edges.
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
