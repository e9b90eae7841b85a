//! Second derivatives of the radiosity of a linear or polynomial emission with respect to x, clipped by the receiver's horizon and
//! by occluders.
//!
//! In the emitter's plane, p the position relative to the foot point of x, h the height of x, f the emission, `f_a` its slopes
//! along the axes `t_a` and `F = p . grad f`. With `E[f] = int f (n1.omega) domega` and `e[f]` the sum over edges in the gradient
//! ([`crate::forms::polynomial::sum`]), `grad E[f] = sum t_a E[f_a] + (n2/h) E[F] + e[f]`. That applied to each `E` of it, where p
//! moves against x and h with it, `Q = sum p_a p_b f_ab`:
//!
//! `H = sum t_a t_b^T E[f_ab] + sum (t_a n2^T + n2 t_a^T) E[p.grad f_a]/h + n2 n2^T E[Q]/h^2`
//! `  + sum t_a e[f_a]^T + n2 e[F]^T / h + d e[f]/dx`.
//!
//! # Edges
//! On a generating line at distance S', r to its points, `e[f] = int f (n1.r)(dz x r)/r^4` and `dz x r = -S' N ds`. At fixed z, as
//! in [`crate::hessian`], the symmetric part of its derivative is `sym(N w^T)/S'^2`,
//! `w = int f (toward'.omega)^2 [n1 - 4 (n1.omega) omega] dpsi`. The point y of the emitter that is seen through z moves too:
//! `y - x = tau r`, `tau = h/(-n2.r)`, gives `dy = (1 - tau) [dx + r (n2.dx)/(-n2.r)]`, so that f adds `(1 - tau)` of the part
//! that the first two terms of the second row have on that edge, `sum t_a f_a + n2 F/h`: together `2 - tau` of it, and 1 on an
//! edge of the emitter itself, where tau is 1. A part that is not symmetric sums to zero, second derivatives being symmetric, and
//! is left out.
//!
//! In the frame of the segment of the emitter's plane that the arc sees, at distance S, with `t = tan psi`, `s = S t`,
//! `toward' = a toward + b along` and `n1 = p_1 toward + p_2 along + ..`: `toward'.omega = cos psi (a + b t)`,
//! `tau = (S/S') (a + b t)`, and all are polynomials in t times `s^k cos^2` or `s^k cos^4`:
//! - `P_kj = 1/S int s^k t^j cos^2 dpsi`: [`Segment`] has j up to 2, and `P_k3 = L_(k+1)/S - P_k1`;
//! - `R_kj = 1/S int s^k t^j cos^4 dpsi`: `R_00`, `R_01`, `R_02` are the arc's quartic moments over S, and
//!   `R_kj = P_(k,j-2) - R_(k,j-2)`, `R_kj = S R_(k-1,j+1)`.
//!
//! Digits are lost where the gradient loses them, and by one over the distance from an edge once more. Bounds are running.

use radgrad_numbers::real::Real;
use radgrad_numbers::vec3::Vec3;

use crate::boundary::arc::{Arc, Generator};
use crate::forms::polynomial::segment::Segment;
use crate::forms::polynomial::sum::{PolynomialSum, SeenPolynomial};
use crate::forms::segment::segment_frame;
use crate::problem::polynomial::bivariate::{Bivariate, whole};

/// A symmetric matrix: the entries xx, yy, zz and the entries yz, zx, xy.
pub(crate) type Symmetric<T> = [Vec3<T>; 2];

/// `a b^T + b a^T`.
pub(crate) fn symmetric_product<T: Real>(a: Vec3<T>, b: Vec3<T>) -> Symmetric<T> {
    let on = Vec3::new(a.x * b.x, a.y * b.y, a.z * b.z) * T::exact(2.0);
    [on, Vec3::new(a.y * b.z + a.z * b.y, a.z * b.x + a.x * b.z, a.x * b.y + a.y * b.x)]
}

/// The sums over the arcs.
#[derive(Debug, Clone)]
pub(crate) struct SecondDerivatives<T> {
    seen: SeenPolynomial<T>,
    /// The sums over the parts within the outline; a linear emission needs none.
    within: Option<PolynomialSum<T>>,
    slopes: [Bivariate<T>; 2],
    /// F.
    radial: Bivariate<T>,
    edges: Symmetric<T>,
}

/// Where an arc lies, and its integrals.
struct OnArc<T> {
    /// The point where the segment's line meets the normal from the foot point, and its direction, in the plane.
    foot: [T; 2],
    along: [T; 2],
    /// `P_kj` and `R_kj` by j.
    second: [Vec<T>; 4],
    fourth: [Vec<T>; 5],
}

impl<T: Real> SecondDerivatives<T> {
    pub(crate) fn new(seen: SeenPolynomial<T>) -> Self {
        let emission = &seen.emission;
        let within = (emission.degree() > 1).then(|| PolynomialSum::new(seen.clone()));
        let (slopes, radial) = (emission.gradient(), emission.radial());
        Self { seen, within, slopes, radial, edges: [Vec3::zero(); 2] }
    }

    /// Adds the contribution of an arc.
    pub(crate) fn add(&mut self, arc: &Arc<T>) {
        if let Some(within) = &mut self.within {
            within.add::<false>(arc);
        }
        let Some(line) = arc.line() else { return };
        let SeenPolynomial { n1, n2, height, .. } = self.seen;
        let frame = segment_frame(arc, n2, height);
        let on_arc = self.on_arc(arc);
        let (p1, p2) = (n1.dot(frame.toward), n1.dot(frame.along));
        let one = T::exact(1.0);
        let (a, b, ratio, distance) = match &arc.generator {
            Generator::Occluder(_) => {
                let line = line.frame();
                let (a, b) = (line.toward.dot(frame.toward), line.toward.dot(frame.along));
                (a, b, frame.distance / line.distance, line.distance)
            }
            Generator::Emitter(_) | Generator::Horizon(_) => (one, T::exact(0.0), one, frame.distance),
        };
        let is_own = matches!(arc.generator, Generator::Emitter(_));
        // (a + b t)(p1 + p2 t), and that times (a + b t).
        let first = if is_own { vec![p1, p2] } else { times(&[p1, p2], a, b) };
        let second = if is_own { first.clone() } else { times(&first, a, b) };
        let seen_edge = |f: &Bivariate<T>| {
            let on_line = on_arc.restricted(f);
            let once = weighted(&on_line, &first, &on_arc.second);
            if is_own {
                return once;
            }
            let moved = weighted(&on_line, &second, &on_arc.second) * ratio;
            (once + once - moved) * ratio
        };
        let [along_1, along_2] = [&self.slopes[0], &self.slopes[1]].map(seen_edge);
        let [t_1, t_2] = self.seen.axes;
        let slope = t_1 * along_1 + t_2 * along_2 + n2 * (seen_edge(&self.radial) / height);
        let on_line = on_arc.restricted(&self.seen.emission);
        let facing = if is_own { vec![one] } else { times(&[a, b], a, b) };
        let toward = weighted(&on_line, &second, &on_arc.fourth);
        let along = weighted(&on_line, &second, &on_arc.fourth[1..]);
        let four = T::exact(4.0);
        let w = n1 * weighted(&on_line, &facing, &on_arc.second) - (frame.toward * toward + frame.along * along) * four;
        let half = T::exact(0.5);
        let sum = w * (ratio / distance) - slope;
        self.add_matrix(symmetric_product(frame.normal, sum * half));
    }

    /// Adds the term of a corner of the outline where two lines only seem to meet, given that of a unit emission.
    pub(crate) fn add_corner(&mut self, point: Vec3<T>, of_unit_emission: Symmetric<T>) {
        let emission = self.seen.emission.value(self.seen.in_plane(point));
        self.add_matrix(of_unit_emission.map(|v| v * emission));
    }

    fn add_matrix(&mut self, matrix: Symmetric<T>) {
        self.edges = [self.edges[0] + matrix[0], self.edges[1] + matrix[1]];
    }

    fn on_arc(&self, arc: &Arc<T>) -> OnArc<T> {
        let SeenPolynomial { n2, height, .. } = self.seen;
        let frame = segment_frame(arc, n2, height);
        let outward = self.seen.in_plane(frame.along.cross(n2));
        let along = self.seen.in_plane(frame.along);
        let signed = frame.distance * n2.dot(frame.normal);
        let degree = self.seen.emission.degree().max(1);
        let segment = Segment::new(arc, frame, degree + 1);
        let (moments, quartic, distance) = (arc.moments(&frame), arc.quartic_moments(&frame), frame.distance);
        let (l, p) = (segment.over_square(), segment.over_fourth(&moments));
        let mut second = [0, 1, 2].map(|j| p.iter().take(degree + 1).map(|p| p[j]).collect::<Vec<T>>());
        let third = (0..=degree).map(|k| l[k + 1] / distance - second[1][k]).collect();
        let mut fourth = [quartic.cccc, quartic.cccs, quartic.ccss].map(|c| vec![c / distance]);
        for k in 1..=degree {
            let next = [fourth[1][k - 1] * distance, fourth[2][k - 1] * distance, second[0][k]];
            fourth[0].push(next[0]);
            fourth[1].push(next[1]);
            fourth[2].push(next[2] - next[0]);
        }
        let [p0, p1, p2] = [0, 1, 2].map(|j| std::mem::take(&mut second[j]));
        let [r0, r1, r2] = fourth;
        let less = |p: &[T], r: &[T]| p.iter().zip(r).map(|(&p, &r)| p - r).collect::<Vec<T>>();
        let (r3, r4) = (less(&p1, &r1), less(&p2, &r2));
        OnArc { foot: outward.map(|c| c * signed), along, second: [p0, p1, p2, third], fourth: [r0, r1, r2, r3, r4] }
    }

    /// The matrix, without the factor rho/pi.
    pub(crate) fn total(&self) -> Symmetric<T> {
        let Some(within) = &self.within else { return self.edges };
        let SeenPolynomial { n2, axes: [t_1, t_2], height, emission, .. } = &self.seen;
        let within = within.within();
        let [[uu, uv], [_, vv]] = [&self.slopes[0], &self.slopes[1]].map(Bivariate::gradient);
        let [uu, uv, vv] = [uu, uv, vv].map(|f| within.irradiance(&f));
        let [of_u, of_v] = [&self.slopes[0], &self.slopes[1]].map(|f| within.radial(&f.radial()));
        let twice = emission.map(|i, j, b| if i + j > 1 { b * whole((i + j) * (i + j - 1)) } else { T::exact(0.0) });
        let across = within.radial(&twice) / *height;
        let half = T::exact(0.5);
        let columns = [
            symmetric_product(*t_1, *t_1 * (uu * half) + *t_2 * uv + *n2 * of_u),
            symmetric_product(*t_2, *t_2 * (vv * half) + *n2 * of_v),
            symmetric_product(*n2, *n2 * (across * half)),
        ];
        columns.into_iter().fold(self.edges, |sum, matrix| [sum[0] + matrix[0], sum[1] + matrix[1]])
    }
}

impl<T: Real> OnArc<T> {
    /// The coefficients of the powers of s, by Horner's rule in u and in v.
    fn restricted(&self, f: &Bivariate<T>) -> Vec<T> {
        let degree = f.degree();
        let mut sum: Vec<T> = Vec::with_capacity(degree + 1);
        for i in (0..=degree).rev() {
            let mut row: Vec<T> = Vec::with_capacity(degree + 1);
            for j in (0..=degree - i).rev() {
                row = times(&row, self.foot[1], self.along[1]);
                add_constant(&mut row, f.coefficient(i, j));
            }
            sum = times(&sum, self.foot[0], self.along[0]);
            for (k, c) in row.into_iter().enumerate() {
                match sum.get_mut(k) {
                    Some(sum) => *sum = *sum + c,
                    None => sum.push(c),
                }
            }
        }
        sum
    }
}

/// A polynomial times `constant + t slope`.
fn times<T: Real>(polynomial: &[T], constant: T, slope: T) -> Vec<T> {
    let Some((&last, _)) = polynomial.split_last() else { return Vec::new() };
    let mut product: Vec<T> = polynomial.iter().map(|&c| c * constant).collect();
    for (k, &c) in polynomial.iter().enumerate().take(polynomial.len() - 1) {
        product[k + 1] = product[k + 1] + c * slope;
    }
    product.push(last * slope);
    product
}

fn add_constant<T: Real>(polynomial: &mut Vec<T>, constant: T) {
    match polynomial.first_mut() {
        Some(first) => *first = *first + constant,
        None => polynomial.push(constant),
    }
}

/// `sum_k sum_j f_k q_j I_kj`.
fn weighted<T: Real>(f: &[T], q: &[T], integrals: &[Vec<T>]) -> T {
    let of_power = |k: usize, &c: &T| c * q.iter().zip(integrals).fold(T::exact(0.0), |sum, (&q, i)| sum + q * i[k]);
    f.iter().enumerate().fold(T::exact(0.0), |sum, (k, c)| sum + of_power(k, c))
}
