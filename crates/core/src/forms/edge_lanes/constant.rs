//! The sums of a constant emitter, four edges at a time, one a lane of a vector: the digits of the sums of
//! [`crate::forms::constant`], where double precision is sure of all decisions ([`crate::forms::edge_lanes`]). The horizon may
//! cut a polygon of up to four vertices.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f64x4, mask64x4};

use crate::boundary::plan::{Horizon, Plan};
use crate::forms::constant_bound::Weighed;
use crate::forms::edge_lanes::cut::Cut;
use crate::forms::edge_lanes::{EdgeLanes, plan};
use crate::forms::irradiance_and_gradient::IrradianceAndGradient;
use crate::lanes::instruction_set::{INSTRUCTION_SET, on_instruction_set};
use crate::lanes::vectors::{all, plus_first};
use crate::problem::polygon::Polygon;
use crate::problem::receiver::Receiver;
use crate::scalar::vec3::Vec3;

/// The plan and the sums for a unit emission, where double precision is sure of all decisions.
#[inline]
pub(crate) fn sure<const VALUE: bool, const GRADIENT: bool>(
    receiver: &Receiver,
    polygon: &Polygon,
) -> Option<(Plan, IrradianceAndGradient<f64>)> {
    on_instruction_set!(*INSTRUCTION_SET, simd => sums::<_, VALUE, GRADIENT>(simd, receiver, polygon))
}

#[inline(always)]
fn sums<S: Simd, const VALUE: bool, const GRADIENT: bool>(
    simd: S,
    receiver: &Receiver,
    polygon: &Polygon,
) -> Option<(Plan, IrradianceAndGradient<f64>)> {
    let plan = plan(simd, receiver, polygon)?;
    if plan.horizon == Horizon::Above
        && let Some(terms) = whole::<_, VALUE, GRADIENT, false>(simd, receiver, polygon, plan.power)
    {
        return Some((plan, terms));
    }
    Some((plan, cut_or_wide::<_, VALUE, GRADIENT>(simd, receiver, polygon, &plan)?))
}

/// Apart, so that its registers do not cost what is ordinary.
#[inline(never)]
fn cut_or_wide<S: Simd, const VALUE: bool, const GRADIENT: bool>(
    simd: S,
    receiver: &Receiver,
    polygon: &Polygon,
    plan: &Plan,
) -> Option<IrradianceAndGradient<f64>> {
    simd.vectorize(
        #[inline(always)]
        || match plan.horizon {
            Horizon::Above => whole::<_, VALUE, GRADIENT, true>(simd, receiver, polygon, plan.power),
            Horizon::Crossing => cut::<_, VALUE, GRADIENT>(simd, receiver, polygon, plan.power),
        },
    )
}

/// Of a polygon that is seen whole; unless `WIDE`, only where no edge that matters passes near or is seen past a quarter turn.
#[inline(always)]
fn whole<S: Simd, const VALUE: bool, const GRADIENT: bool, const WIDE: bool>(
    simd: S,
    receiver: &Receiver,
    polygon: &Polygon,
    power: f64,
) -> Option<IrradianceAndGradient<f64>> {
    let (x, n1) = (all(simd, receiver.position()), all(simd, receiver.normal()));
    let (mut angles, mut edges) = (Vec3::default(), Vec3::default());
    let mut rest = polygon.vertices().len();
    let fours = polygon.four_edges();
    for four in fours {
        let four = EdgeLanes::new::<WIDE>(simd, four, x, f64x4::splat(simd, power), fours.len() == 1)?;
        let count = rest.min(4);
        rest -= count;
        if VALUE {
            angles = plus_first(angles, four.line.normal * four.arc.angle, count);
        }
        if GRADIENT {
            let weight = Weight::new::<WIDE>(simd, &four, n1)?.weight;
            edges = plus_first(edges, four.line.normal * -weight, count);
        }
    }
    Some(IrradianceAndGradient { irradiance: angles * -0.5, gradient: edges })
}

#[inline(always)]
fn cut<S: Simd, const VALUE: bool, const GRADIENT: bool>(
    simd: S,
    receiver: &Receiver,
    polygon: &Polygon,
    power: f64,
) -> Option<IrradianceAndGradient<f64>> {
    let [edges] = polygon.four_edges() else { return None };
    let (n1, count) = (all(simd, receiver.normal()), polygon.vertices().len());
    let part = Cut::new(simd, receiver, edges, count, power)?;
    let Cut { four, closing, .. } = &part;
    let (mut angles, mut slopes) = (Vec3::default(), Vec3::default());
    if VALUE {
        angles = part.sum(simd, four.line.normal * four.arc.angle, count);
        angles = angles + closing.generator.normal() * closing.angle;
    }
    if GRADIENT {
        slopes = part.sum(simd, four.line.normal * -Weight::new::<true>(simd, four, n1)?.weight, count);
    }
    Some(IrradianceAndGradient { irradiance: angles * -0.5, gradient: slopes })
}

/// What arcs weigh, as [`crate::boundary::arc::Arc::weight`] has it, with what bounds on it follow from.
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
            |end| n1.dot(end.point) * end.inverse,
        );
        let mut weight = arc.within_a_quarter_turn([arc.start.inverse, arc.end.inverse], cosines);
        let is_wide = WIDE && wide.any_true();
        if is_wide {
            weight = wide.select(arc.weight_in_frame(line, n1), weight);
        }
        Some(Self { weight, weighed: Weighed::new(arc, cosines), wide: is_wide.then_some(wide) })
    }
}

#[cfg(test)]
mod tests {
    use rand::{SeedableRng, rngs::ChaCha8Rng};

    use super::*;
    use crate::boundary::horizon;
    use crate::forms::constant::{EdgeSum, SolidAngleVector};
    use crate::forms::edge_lanes::random::{polygon_and_receiver, vector};
    use crate::lanes::instruction_set::instruction_sets;

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
                let found = on_instruction_set!(level, simd => sums::<_, true, true>(simd, &receiver, &polygon));
                let digits = found.map(|(plan, terms)| (plan.power, plan.horizon, terms.irradiance, terms.gradient));
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
}
