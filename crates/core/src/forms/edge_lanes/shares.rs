//! Derivatives of a constant emitter of up to four vertices by each of them, with bounds on their errors, where double precision is sure
//! that all of it is above the horizon: the shares of the edges' ends ([`crate::forms::hats`]), one edge a lane.
//!
//! A share is `q (A -+ D)`, q one over the distance of its end, `A = chi (c + c')`, `D = psi (c' - c)`: the terms that the weight of the edge
//! has as `A Q + D (q' - q)`. In the terms of [`crate::forms::constant_bound`], `q <= Q`, and q errs by no more of itself than Q does, so that
//! the size and the error of a share are at most those derived for the weight, and two roundings of its own. The derivative by a vertex is
//! `N to + N' from` of its two edges, the gradient minus the sum of all. The irradiance vector errs as its product with n1 does, with
//! `|n1.N|` replaced by 1.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f64x4};
use radgrad_numbers::in_library;
use radgrad_numbers::lanes::vectors::{plus_first, splat_vector};
use radgrad_numbers::number::ROUNDOFF;
use radgrad_numbers::vec3::Vec3;

use crate::boundary::line::LEAST_MOMENT;
use crate::boundary::plan::{Horizon, Plan};
use crate::forms::constant_bound::units::SECOND_ORDER;
use crate::forms::constant_bound::{AngleError, Weighed};
use crate::forms::edge_lanes::{EdgeLanes, INSTRUCTION_SET, plan};
use crate::problem::polygon::Polygon;
use crate::problem::receiver::Receiver;

/// The most vertices.
pub(crate) const MOST: usize = 4;

/// Sums for a unit emission, without the factor rho/pi, each with a bound that includes the products with factors known to a few
/// roundings.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Shared {
    pub(crate) plan: Plan,
    pub(crate) irradiance: Vec3<f64>,
    /// Of the irradiance vector, and of its component along n1.
    pub(crate) irradiance_errors: [f64; 2],
    pub(crate) gradient: Vec3<f64>,
    pub(crate) gradient_error: f64,
    /// The derivatives by the vertices; entries beyond their number are without meaning.
    pub(crate) vertices: [Vec3<f64>; MOST],
    pub(crate) vertex_errors: [f64; MOST],
}

/// The sums where double precision is sure of all decisions and no edge passes near or is seen past a quarter turn.
#[inline]
pub(crate) fn constant(receiver: &Receiver, polygon: &Polygon) -> Option<Shared> {
    in_library!(*INSTRUCTION_SET, simd => {
        let plan = plan(simd, receiver, polygon)?;
        if plan.horizon != Horizon::Above {
            return None;
        }
        on_lanes(simd, receiver, polygon, plan)
    })
}

#[inline(always)]
fn on_lanes<S: Simd>(simd: S, receiver: &Receiver, polygon: &Polygon, plan: Plan) -> Option<Shared> {
    const U: f64 = ROUNDOFF;
    let [four] = polygon.four_edges() else { return None };
    let (x, n1) = (splat_vector(simd, receiver.position()), splat_vector(simd, receiver.normal()));
    let lanes = |value: f64| f64x4::splat(simd, value);
    let count = polygon.vertices().len();
    let four = EdgeLanes::new::<false>(simd, four, x, lanes(plan.power), true)?;
    let (normal, arc) = (four.line.normal, &four.arc);
    let is_in_range = four.line.moment.simd_ge(lanes(LEAST_MOMENT)) & arc.inline.simd_ge(lanes(0.0));
    if !is_in_range.all_true() {
        return None;
    }
    let g = arc.angle;
    let cosines = four.at_ends(
        #[inline(always)]
        |end| end.cosine(n1),
    );
    let zero = lanes(0.0);
    let from = normal * arc.within_a_quarter_turn([arc.start.inverse, zero], cosines);
    let to = normal * arc.within_a_quarter_turn([zero, arc.end.inverse], cosines);
    // Lane k is the edge that ends in vertex k, and the next one starts there; of a triangle the fourth is none.
    let after = |of: f64x4<S>| {
        let [a, b, c, d] = *of.as_array();
        f64x4::from_slice(simd, &if count == 3 { [b, c, a, a] } else { [b, c, d, a] })
    };
    let vertices = to + Vec3::new(after(from.x), after(from.y), after(from.z));
    let ew = four.relative_error() * U;
    let of_angle = AngleError::new(g, g.min(lanes(1.0)), ew, None);
    let (size, error) = of_angle.of_weight(&Weighed::new(arc, cosines));
    let of_share = error + size * (ew + lanes(3.0 * U));
    let of_vertex = of_share + after(of_share);
    let additions = count as f64 * U;
    let of_term = of_angle.of_term(n1.dot(normal).abs()) + g * additions;
    let of_vector = of_angle.of_term(lanes(1.0)) + g * additions;
    let zeros = Vec3::zero();
    let angles = plus_first(zeros, normal * g, count);
    let moved = plus_first(zeros, vertices, count);
    let sums = plus_first(zeros, Vec3::new(of_term, of_vector, of_share * 2.0 + size * additions), count);
    let (irradiance, gradient) = (angles * -0.5, moved * -1.0);
    let with_products = |error: f64, size: f64| SECOND_ORDER * (error + 8.0 * U * size);
    let (of_vertex, [vx, vy, vz]) = (*of_vertex.as_array(), [vertices.x, vertices.y, vertices.z].map(|c| *c.as_array()));
    let vertices = [0, 1, 2, 3].map(|k| Vec3::new(vx[k], vy[k], vz[k]));
    Some(Shared {
        plan,
        irradiance,
        irradiance_errors: [sums.y, sums.x].map(|error| with_products(0.5 * error, irradiance.norm())),
        gradient,
        gradient_error: with_products(sums.z, gradient.norm()),
        vertices,
        vertex_errors: [0, 1, 2, 3].map(|k| with_products(of_vertex[k], vertices[k].norm())),
    })
}
