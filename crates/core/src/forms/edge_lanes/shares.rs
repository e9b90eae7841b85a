//! Derivatives of a constant emitter of up to four vertices by each of them, with bounds on their errors, where double precision is sure
//! that all of it is above the horizon: the shares of the edges' ends ([`crate::forms::hats`]), one edge a lane.
//!
//! A share is `q (A -+ D)`, q one over the distance of its end, `A = chi (c + c')`, `D = psi (c' - c)`: the terms that the weight of the edge
//! has as `A Q + D (q' - q)`. In the terms of [`crate::forms::constant_bound`], `q <= Q`, and q errs by no more of itself than Q does, so that
//! the size and the error of a share are at most those derived for the weight, and two roundings of its own. The derivative by a vertex is
//! `N to + N' from` of its two edges, the gradient minus the sum of all. The irradiance vector errs as its product with n1 does, with
//! `|n1.N|` replaced by 1.

pub(crate) mod linear;

use std::ops::Range;

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
use crate::forms::hats::end_weights;
use crate::problem::emission::Emitter;
use crate::problem::receiver::{Receiver, unit_normal};

/// The most vertices.
pub(crate) const MOST: usize = 4;

/// The sizes from which products with factors of the kind leave the range of normal numbers by far.
const MODERATE: Range<f64> = 1e-120..1e120;

/// Derivatives without the factor rho/pi, in normalised lengths and emission, each with a bound that includes the products with factors
/// known to a few roundings. Of each array entries beyond the number of vertices are without meaning.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Shared {
    pub(crate) plan: Plan,
    /// The irradiance vector's component along n1.
    pub(crate) irradiance: f64,
    pub(crate) irradiance_error: f64,
    pub(crate) vector: Vec3<f64>,
    pub(crate) vector_error: f64,
    pub(crate) gradient: Vec3<f64>,
    pub(crate) gradient_error: f64,
    pub(crate) vertices: [Vec3<f64>; MOST],
    pub(crate) vertex_errors: [f64; MOST],
    /// Of a constant emission the first alone.
    pub(crate) emission: [f64; MOST],
    pub(crate) emission_errors: [f64; MOST],
}

impl Shared {
    /// Whether all errors are within the tolerance, relative to the largest of their kind, and nothing is near the ends of the range.
    #[inline(always)]
    pub(crate) fn is_within(&self, tolerance: f64, [vertices, parameters]: [usize; 2]) -> bool {
        let meets = |error: f64, size: f64| error <= tolerance * size && MODERATE.contains(&size);
        let (mut by_vertices, mut by_emission) = (0.0f64, 0.0f64);
        // A maximum drops NaN; the bound of such a derivative is NaN too, which meets nothing.
        for vertex in &self.vertices[..vertices] {
            by_vertices = by_vertices.max(vertex.norm_squared());
        }
        for parameter in &self.emission[..parameters] {
            by_emission = by_emission.max(parameter.abs());
        }
        by_vertices = by_vertices.sqrt();
        let mut are_met = meets(self.irradiance_error, self.irradiance.abs())
            && meets(self.vector_error, self.vector.norm())
            && meets(self.gradient_error, self.gradient.norm());
        for error in &self.vertex_errors[..vertices] {
            are_met &= meets(*error, by_vertices);
        }
        for error in &self.emission_errors[..parameters] {
            are_met &= meets(*error, by_emission);
        }
        are_met
    }
}

/// The derivatives of a constant emission where double precision is sure of all decisions and no edge passes near or is seen past a
/// quarter turn.
#[inline]
pub(crate) fn constant(receiver: &Receiver, emitter: &Emitter) -> Option<Shared> {
    in_library!(*INSTRUCTION_SET, simd => {
        let plan = plan(simd, receiver, emitter.polygon())?;
        if plan.horizon != Horizon::Above {
            return None;
        }
        on_lanes(simd, receiver, emitter, plan)
    })
}

#[inline(always)]
fn on_lanes<S: Simd>(simd: S, receiver: &Receiver, emitter: &Emitter, plan: Plan) -> Option<Shared> {
    const U: f64 = ROUNDOFF;
    let polygon = emitter.polygon();
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
    let [at_start, at_end] = end_weights(arc, cosines);
    let (from, to) = (normal * (at_start * arc.start.inverse), normal * (at_end * arc.end.inverse));
    // Lane k is the edge that ends in vertex k, and the next one starts there.
    let after = |of: f64x4<S>| next_of(simd, of, count);
    let emission = emitter.affine().value;
    let vertices = (to + Vec3::new(after(from.x), after(from.y), after(from.z))) * lanes(emission);
    let ew = four.relative_error() * U;
    let of_angle = AngleError::new(g, g.min(lanes(1.0)), ew, None);
    let (size, error) = of_angle.of_weight(&Weighed::new(arc, cosines));
    let of_share = error + size * (ew + lanes(3.0 * U));
    // Of the terms of each vertex and of all, and the product with the emission.
    let additions = (count + 1) as f64 * U;
    let of_term = of_angle.of_term(n1.dot(normal).abs()) + g * additions;
    let of_vector = of_angle.of_term(lanes(1.0)) + g * additions;
    let angles = plus_first(Vec3::zero(), normal * g, count);
    let sums = plus_first(Vec3::zero(), Vec3::new(of_term, of_vector, of_share * 2.0 + size * additions), count);
    let (strength, vector) = (emission.abs(), angles * (-0.5 * emission));
    let gradient = -plus_first(Vec3::zero(), vertices, count);
    let with_products = |error: f64, size: f64| SECOND_ORDER * (error * strength + 8.0 * U * size);
    let sizes = vertices.norm_squared().sqrt();
    let of_vertices = ((of_share + after(of_share)) * strength + sizes * (8.0 * U)) * SECOND_ORDER;
    let n1 = unit_normal::<f64>(receiver);
    let unit = angles.dot(n1) * -0.5;
    let of_unit = SECOND_ORDER * (0.5 * sums.x + 4.0 * U * angles.norm());
    Some(Shared {
        plan,
        irradiance: unit * emission,
        irradiance_error: of_unit * strength,
        vector,
        vector_error: with_products(0.5 * sums.y, vector.norm()),
        gradient,
        gradient_error: with_products(sums.z, gradient.norm()),
        vertices: rows(vertices),
        vertex_errors: *of_vertices.as_array(),
        emission: [unit, 0.0, 0.0, 0.0],
        emission_errors: [of_unit, 0.0, 0.0, 0.0],
    })
}

/// Each lane gets the number of the next one; of a triangle the fourth is none.
#[inline(always)]
fn next_of<S: Simd>(simd: S, of: f64x4<S>, count: usize) -> f64x4<S> {
    let [a, b, c, d] = *of.as_array();
    f64x4::load_array(simd, if count == 3 { [b, c, a, a] } else { [b, c, d, a] })
}

#[inline(always)]
fn rows<S: Simd>(Vec3 { x, y, z }: Vec3<f64x4<S>>) -> [Vec3<f64>; MOST] {
    let (x, y, z) = (x.as_array(), y.as_array(), z.as_array());
    let row = |k: usize| Vec3::new(x[k], y[k], z[k]);
    [row(0), row(1), row(2), row(3)]
}
