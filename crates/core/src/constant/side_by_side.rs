//! The sums of a constant emitter that is seen whole, four edges at a time, one a lane of a vector.
//!
//! The same operations in the same order as of [`crate::arc`], [`crate::line`] and the sums of [`super`] on doubles, so the same
//! digits; the decisions are those of [`crate::plan`]. What is not plain is left to them: a receiver that is not surely in front of
//! the plane, a vertex that is not surely above the horizon, an edge that passes near the receiver or, for the gradient, is seen
//! past a quarter turn.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f64x4, mask64x4};

use crate::arc::PSI;
use crate::arc_tangent::{CUBIC, FROM};
use crate::geometry::{FourEdges, normalising_power};
use crate::level::{LEVEL, on_level};
use crate::plan::{Horizon, Plan, sure};
use crate::terms::Terms;
use crate::vec3::Vec3;
use crate::{DVec3, Polygon, Receiver};

/// The sums for a unit emission and the plan, where all is plain.
#[inline]
pub(crate) fn whole<const VALUE: bool, const GRADIENT: bool>(
    receiver: &Receiver,
    polygon: &Polygon,
) -> Option<(Plan, Terms<f64>)> {
    on_level!(*LEVEL, simd => sums::<_, VALUE, GRADIENT>(simd, receiver, polygon))
}

#[inline(always)]
fn sums<S: Simd, const VALUE: bool, const GRADIENT: bool>(
    simd: S,
    receiver: &Receiver,
    polygon: &Polygon,
) -> Option<(Plan, Terms<f64>)> {
    let fours = polygon.four_edges();
    let power = power_seen_whole(simd, receiver, polygon, fours)?;
    let (x, n1) = (all(simd, receiver.position()), all(simd, receiver.normal()));
    let (mut angles, mut edges) = (Vec3::default(), Vec3::default());
    let mut rest = polygon.vertices().len();
    for four in fours {
        let found = Four::new(simd, four, x, f64x4::splat(simd, power))?;
        let count = rest.min(4);
        rest -= count;
        if VALUE {
            angles = plus_first(angles, found.normal * found.angle, count);
        }
        if GRADIENT {
            edges = plus_first(edges, found.normal * -found.weight(simd, n1, fours.len() == 1)?, count);
        }
    }
    Some((Plan { power, horizon: Horizon::Above }, Terms { irradiance: angles * -0.5, gradient: edges }))
}

/// The power of two that normalises lengths, where the receiver is surely in front of the plane and all vertices are surely above
/// its horizon.
#[inline(always)]
fn power_seen_whole<S: Simd>(simd: S, receiver: &Receiver, polygon: &Polygon, fours: &[FourEdges]) -> Option<f64> {
    let position = receiver.position();
    let (x, n1) = (all(simd, position), all(simd, receiver.direction()));
    let (mut farthest, mut lowest) = (f64x4::splat(simd, 0.0), f64x4::splat(simd, f64::INFINITY));
    for four in fours {
        let r = four.ends(simd) - x;
        farthest = farthest.max(r.x.abs().max(r.y.abs()).max(r.z.abs()));
        lowest = lowest.min(n1.dot(r));
    }
    let ([a, b, c, d], [p, q, r, s]) = (*farthest.as_array(), *lowest.as_array());
    let larger = |a: f64, b: f64| if a > b { a } else { b };
    let lower = |a: f64, b: f64| if a < b { a } else { b };
    let farthest = larger(larger(a, b), larger(c, d));
    let height = polygon.normal().dot(position - polygon.vertices()[0]);
    let surely = sure(farthest);
    let is_whole = height > surely && polygon.is_well_known() && lower(lower(p, q), lower(r, s)) > surely;
    is_whole.then(|| normalising_power(farthest))
}

/// Four arcs: `Arc<f64>` on lanes.
struct Four<S: Simd> {
    start: Vec3<f64x4<S>>,
    end: Vec3<f64x4<S>>,
    start_square: f64x4<S>,
    normal: Vec3<f64x4<S>>,
    across: f64x4<S>,
    inline: f64x4<S>,
    angle: f64x4<S>,
}

impl<S: Simd> Four<S> {
    /// As [`crate::line::Line::through`] and [`crate::arc::Arc::of_edge`].
    #[inline(always)]
    fn new(simd: S, four: &FourEdges, x: Vec3<f64x4<S>>, power: f64x4<S>) -> Option<Self> {
        let (from, to) = (four.starts(simd), four.ends(simd));
        let (start, end, e) = ((from - x) * power, (to - x) * power, (to - from) * power);
        let (start_square, w) = (start.norm_squared(), start.cross(e));
        let square = w.norm_squared();
        let passes = (f64x4::splat(simd, 16.0) * square).simd_ge(start_square * e.norm_squared());
        let across = square.sqrt();
        let inline = start.dot(end);
        let (angle, plain) = angle(simd, across, inline);
        let normal = w * (f64x4::splat(simd, 1.0) / across);
        (passes & plain).all_true().then_some(Self { start, end, start_square, normal, across, inline, angle })
    }

    /// As [`crate::arc::Arc::weight`]. Where all edges are here each one ends where the next one starts.
    #[inline(always)]
    fn weight(&self, simd: S, n1: Vec3<f64x4<S>>, closed: bool) -> Option<f64x4<S>> {
        let Self { start, end, start_square, across, inline, angle, .. } = *self;
        if !inline.simd_ge(f64x4::splat(simd, 0.0)).all_true() {
            return None;
        }
        let one = f64x4::splat(simd, 1.0);
        let q1 = one / start_square.sqrt();
        let c1 = n1.dot(start) * q1;
        let (q2, c2) = if closed {
            (q1.rotate_elements_left::<1>(), c1.rotate_elements_left::<1>())
        } else {
            let q2 = one / end.norm_squared().sqrt();
            (q2, n1.dot(end) * q2)
        };
        let product = q1 * q2;
        let (sin, cos) = (across * product, inline * product);
        let one_and_cos = one + cos;
        let chi = (angle + sin) / (one_and_cos * f64x4::splat(simd, 4.0));
        let z = angle * angle;
        let psi = angle * (f64x4::splat(simd, PSI[0]) + z * nine_terms(simd, &HIGHER, z));
        Some(chi * (q1 + q2) * (c1 + c2) + psi * (q2 - q1) * (c2 - c1))
    }
}

/// What follows the first term of [`PSI`].
const HIGHER: [f64; 9] = {
    let [_, c1, c2, c3, c4, c5, c6, c7, c8, c9] = PSI;
    [c1, c2, c3, c4, c5, c6, c7, c8, c9]
};

/// The same vector in all lanes.
#[inline(always)]
fn all<S: Simd>(simd: S, v: DVec3) -> Vec3<f64x4<S>> {
    Vec3::new(f64x4::splat(simd, v.x), f64x4::splat(simd, v.y), f64x4::splat(simd, v.z))
}

/// A sum with the terms of the first lanes, one after the other.
#[inline(always)]
fn plus_first<S: Simd>(sum: Vec3<f64>, terms: Vec3<f64x4<S>>, count: usize) -> Vec3<f64> {
    let (x, y, z) = (terms.x.as_array(), terms.y.as_array(), terms.z.as_array());
    let term = |i: usize| Vec3::new(x[i], y[i], z[i]);
    match count {
        3 => sum + term(0) + term(1) + term(2),
        4 => sum + term(0) + term(1) + term(2) + term(3),
        2 => sum + term(0) + term(1),
        _ => sum + term(0),
    }
}

/// As [`crate::arc_tangent::atan2`] of what is not negative, and where that is away from the ends of the range.
#[inline(always)]
fn angle<S: Simd>(simd: S, y: f64x4<S>, x: f64x4<S>) -> (f64x4<S>, mask64x4<S>) {
    let run = x.abs();
    let (small, large) = (y.min(run), y.max(run));
    let octant = Octant {
        steep: y.simd_gt(run),
        left: x.simd_lt(f64x4::splat(simd, 0.0)),
        half: small.simd_gt(f64x4::splat(simd, 0.25) * large),
        whole: small.simd_gt(f64x4::splat(simd, 0.75) * large),
    };
    let c = octant.nearest(simd, [0.0, 0.5, 1.0]);
    let s = (small - c * large) / (large + c * small);
    let s = (octant.steep ^ octant.left).select(-s, s);
    let square = s * s;
    let angle = octant.from(simd, 0) + (s + (s * square * nine_terms(simd, &CUBIC, square) + octant.from(simd, 1)));
    (angle, large.simd_gt(f64x4::splat(simd, f64::MIN_POSITIVE / f64::EPSILON)))
}

/// Where a point is: nearer to the y axis, left of it, and its tangent's reduction.
#[derive(Clone, Copy)]
struct Octant<S: Simd> {
    steep: mask64x4<S>,
    left: mask64x4<S>,
    half: mask64x4<S>,
    whole: mask64x4<S>,
}

impl<S: Simd> Octant<S> {
    /// One of three numbers for the nearest of 0, 1/2, 1.
    #[inline(always)]
    fn nearest(&self, simd: S, [zero, half, one]: [f64; 3]) -> f64x4<S> {
        let low = self.half.select(f64x4::splat(simd, half), f64x4::splat(simd, zero));
        self.whole.select(f64x4::splat(simd, one), low)
    }

    /// A part of [`FROM`].
    #[inline(always)]
    fn from(&self, simd: S, part: usize) -> f64x4<S> {
        let [a, b, c, d] = &FROM;
        let (right, left) = (self.nearest(simd, column(a, part)), self.nearest(simd, column(b, part)));
        let (up, beyond) = (self.nearest(simd, column(c, part)), self.nearest(simd, column(d, part)));
        self.steep.select(self.left.select(beyond, up), self.left.select(left, right))
    }
}

#[inline(always)]
const fn column(row: &[[f64; 2]; 3], part: usize) -> [f64; 3] {
    [row[0][part], row[1][part], row[2][part]]
}

/// A polynomial of degree 8, in the order of [`crate::arc_tangent`].
#[inline(always)]
fn nine_terms<S: Simd>(simd: S, c: &[f64; 9], z: f64x4<S>) -> f64x4<S> {
    let z2 = z * z;
    let z4 = z2 * z2;
    let low = pair(simd, [c[0], c[1]], z) + pair(simd, [c[2], c[3]], z) * z2;
    let high = pair(simd, [c[4], c[5]], z) + pair(simd, [c[6], c[7]], z) * z2;
    low + (high + f64x4::splat(simd, c[8]) * z4) * z4
}

#[inline(always)]
fn pair<S: Simd>(simd: S, [a, b]: [f64; 2], z: f64x4<S>) -> f64x4<S> {
    f64x4::splat(simd, a) + f64x4::splat(simd, b) * z
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng, rngs::ChaCha8Rng};

    use super::*;
    use crate::constant::{EdgeSum, SolidAngleVector};
    use crate::horizon;
    use crate::level::levels;

    #[test]
    fn side_by_side_gives_the_digits_of_one_by_one_on_every_instruction_set() {
        let mut random = ChaCha8Rng::seed_from_u64(8);
        let (mut found, mut wide) = (0, 0);
        for i in 0..4000 {
            let count = 3 + i % 7;
            // Vertices of a circle, in order of their angles, pulled into an ellipse somewhere.
            let mut angles: Vec<f64> = (0..count).map(|_| random.random_range(0.0..6.0)).collect();
            angles.sort_unstable_by(f64::total_cmp);
            let mut vector = |size: f64| DVec3::from([(); 3].map(|()| random.random_range(-size..size)));
            let (centre, a, b, size) = (vector(1.0), vector(1.0), vector(1.0), libm::exp(vector(6.0).x));
            let vertices = angles.iter().map(|t| (centre + a * libm::cos(*t) + b * libm::sin(*t)) * size).collect();
            let Ok(polygon) = Polygon::new(vertices) else { continue };
            let x = centre * size + polygon.normal() * size * libm::exp(vector(4.0).y) + vector(size);
            let receiver = Receiver::new(x, centre * size - x + vector(size) * 0.5, 1.0).unwrap();
            let (mut first, mut angles) = (None, SolidAngleVector::zero());
            for level in levels() {
                let found = on_level!(level, simd => sums::<_, true, true>(simd, &receiver, &polygon));
                let digits = found.map(|(plan, terms)| (plan.power, terms.irradiance, terms.gradient));
                assert_eq!(*first.get_or_insert(digits), digits, "{level:?}");
            }
            let value = whole::<true, false>(&receiver, &polygon);
            wide += usize::from(first.flatten().is_none() && value.is_some());
            let Some((power, irradiance, gradient)) = first.flatten() else { continue };
            found += 1;
            let plan = Plan::new(&receiver, &polygon).unwrap();
            let mut edges = EdgeSum::new(receiver.normal().into());
            horizon::visit_boundary::<f64>(&receiver, &polygon, &plan, |arc| {
                angles.add(arc);
                edges.add(arc);
            });
            assert_eq!((plan.power, plan.horizon), (power, Horizon::Above));
            assert_eq!((angles.phi(), edges.sum()), (irradiance, gradient), "{receiver:?} {polygon:?}");
            assert_eq!(value.unwrap().1.irradiance, irradiance);
            assert_eq!(whole::<false, true>(&receiver, &polygon).unwrap().1.gradient, gradient);
        }
        println!("{found} found, {wide} for their value alone");
        assert!(found > 1000 && wide > 20, "{found} {wide}");
    }
}
