//! How a line's weight in the gradient is shared between its two ends: derivatives of the radiosity by the end points of the edges
//! that bound the part that is seen.
//!
//! Where the line of an arc moves by v(z) at its points z, the irradiance changes by `int (N.v) B (n1.omega) (toward.omega)/S ds`, as
//! a ribbon's flux. Where v is that of the ends p and q of a segment, `v = (1 - t) v_p + t v_q` at `z = p + t (q - p)`. With omega the
//! direction of z and `e = q - p`, `toward.omega/S = 1/|z|`, and `1 - t` and `t` times that are linear in omega:
//!
//! `(1 - t)/|z| = e.(omega' q - omega)/e^2`, `t/|z| = e.(omega - omega' p)/e^2`, `omega' = toward.omega/S`.
//!
//! So the derivative by q is `N` times the second of these, taken of `V = int B (n1.omega) omega ds` in place of omega, and that by p
//! `N` times the first; their sum is the arc's part of minus the gradient ([`crate::forms::constant`]). A motion that is any affine
//! function on the line is shared alike.
//!
//! For a constant emission `V = (A - D) u + (A + D) v` with u, v the directions of the ends, `A = chi (u + v).n1`,
//! `D = psi (v - u).n1` ([`crate::boundary::arc::weight`]). On a whole edge the shares are `(A - D)/|p|` and `(A + D)/|q|`: nothing
//! cancels, however far it is. Elsewhere one over the angle of the edge is lost.

use radgrad_numbers::arithmetic::Arithmetic;
use radgrad_numbers::real::Real;
use radgrad_numbers::series::sine::psi;
use radgrad_numbers::vec3::Vec3;

use crate::boundary::arc::{Arc, Generator};
use crate::boundary::line::{Line, Sighted};

/// A vector of the plane of x and a line, with `toward.V/S` on that line.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Weighed<T> {
    pub(crate) vector: Vec3<T>,
    pub(crate) near: T,
}

/// Two points of a generating line.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Ends<T> {
    points: [Vec3<T>; 2],
    e: Vec3<T>,
    inverse_square: T,
}

impl<T: Real> Ends<T> {
    pub(crate) fn new(points: [Vec3<T>; 2], e: Vec3<T>) -> Self {
        Self { points, e, inverse_square: T::exact(1.0) / e.norm_squared() }
    }

    /// The shares of the two points.
    pub(crate) fn shares(&self, Weighed { vector, near }: Weighed<T>) -> [T; 2] {
        let [from, to] = self.points;
        let [first, second] = [to * near - vector, vector - from * near];
        [self.e.dot(first) * self.inverse_square, self.e.dot(second) * self.inverse_square]
    }

    /// The shares of the two points in the weight of an arc on their line, for a unit emission.
    pub(crate) fn shares_of_constant(&self, arc: &Arc<T>, line: &Line<T>, n1: Vec3<T>) -> [T; 2] {
        if !arc.is_within_a_quarter_turn() {
            return self.shares(past_a_quarter_turn(arc, line, n1));
        }
        let weights = end_weights(arc, [arc.start.cosine(n1), arc.end.cosine(n1)]);
        if let Generator::Emitter(_) = arc.generator
            && self.is_whole(arc)
        {
            return [weights[0] * arc.start.inverse, weights[1] * arc.end.inverse];
        }
        let toward = line.frame().toward * line.nearness();
        let [start, end] = [&arc.start, &arc.end].map(|end: &Sighted<T>| {
            let near = if let Generator::Emitter(_) = arc.generator { end.inverse } else { toward.dot(end.point) * end.inverse };
            self.shares(Weighed { vector: end.point * end.inverse, near })
        });
        [0, 1].map(|k| start[k] * weights[0] + end[k] * weights[1])
    }

    /// Whether an arc runs from the first point to the second, exactly.
    fn is_whole(&self, arc: &Arc<T>) -> bool {
        let is_at = |end: &Sighted<T>, point: Vec3<T>| {
            let is_equal = |a: T, b: T| a.value() == b.value() && a.error() == b.error();
            is_equal(end.point.x, point.x) && is_equal(end.point.y, point.y) && is_equal(end.point.z, point.z)
        };
        is_at(&arc.start, self.points[0]) && is_at(&arc.end, self.points[1])
    }
}

/// `A - D` and `A + D`, given n1 along the directions of the ends.
#[inline(always)]
pub(in crate::forms) fn end_weights<T: Arithmetic>(arc: &Arc<T>, [c1, c2]: [T; 2]) -> [T; 2] {
    let product = arc.start.inverse * arc.end.inverse;
    let (sin, cos) = (arc.across * product, arc.inline * product);
    let one_and_cos = cos.like(1.0) + cos;
    let sum = (arc.angle + sin) / (one_and_cos * cos.like(4.0)) * (c1 + c2);
    let difference = psi(arc.angle, sin, cos, one_and_cos) * (c2 - c1);
    [sum - difference, sum + difference]
}

/// `V = M n1` in the frame of the line.
fn past_a_quarter_turn<T: Real>(arc: &Arc<T>, line: &Line<T>, n1: Vec3<T>) -> Weighed<T> {
    let frame = line.frame();
    let m = arc.moments(&frame);
    let (p1, p2) = (n1.dot(frame.toward), n1.dot(frame.along));
    let [toward, along] = [m.cc * p1 + m.cs * p2, m.cs * p1 + m.ss * p2];
    Weighed { vector: frame.toward * toward + frame.along * along, near: toward * line.nearness() }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// `int (1 - t, t) (n1.z) S/|z|^4 |e| dt` over part of a segment, by the midpoint rule.
    fn by_quadrature([p, q]: [Vec3<f64>; 2], n1: Vec3<f64>, [from, to]: [f64; 2], distance: f64) -> [f64; 2] {
        let (e, count) = (q - p, 20_000);
        let step = (to - from) / f64::from(count);
        (0..count).fold([0.0; 2], |sum, k| {
            let t = from + (f64::from(k) + 0.5) * step;
            let z = p + e * t;
            let weight = n1.dot(z) * distance * e.length() * step / (z.norm_squared() * z.norm_squared());
            [sum[0] + (1.0 - t) * weight, sum[1] + t * weight]
        })
    }

    #[test]
    fn shares_are_the_integrals_of_the_hats() {
        let n1 = Vec3::new(0.3, -0.5, 0.812);
        let (p, q) = (Vec3::new(2.0, -0.75, 0.5), Vec3::new(1.5, 3.0, 1.0));
        let far = Vec3::new(0.1, -6.0, 0.2);
        for (ends, part) in [([p, q], [0.0, 1.0]), ([p, q], [0.25, 0.75]), ([far, q], [0.0, 1.0]), ([far, q], [0.1, 0.9])] {
            let e = ends[1] - ends[0];
            let line = Line::<f64>::along(e, ends[0]);
            let [start, end] = part.map(|t| Sighted::new(ends[0] + e * t));
            let expected = by_quadrature(ends, n1, part, line.frame().distance);
            // Seen at another distance, an occluder's edge has the same shares.
            let beyond = [&start, &end].map(|end| Sighted::new(end.point * 1.7));
            let emitters = Arc::between(start, end, Generator::Emitter(line));
            let occluders = Arc::between(beyond[0], beyond[1], Generator::Occluder(line));
            for arc in [emitters, occluders] {
                let shares = Ends::new(ends, e).shares_of_constant(&arc, &line, n1);
                assert!(
                    (shares[0] - expected[0]).abs() < 1e-8 && (shares[1] - expected[1]).abs() < 1e-8,
                    "{shares:?} {expected:?}"
                );
                assert!((shares[0] + shares[1] - arc.weight(&line, n1)).abs() < 1e-15);
            }
        }
    }
}
