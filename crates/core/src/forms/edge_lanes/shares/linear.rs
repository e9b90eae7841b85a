//! The derivatives by vertices and vertex values of a linear emitter of three or four vertices, where double precision is sure that all of
//! it is above the horizon: [`crate::forms::hats`] and [`crate::forms::polynomial::parameters`] for an affine emission, one edge or vertex
//! a lane, with running bounds ([`radgrad_numbers::lanes::ball`]) and the derived bound of X1 ([`crate::forms::linear_bound`]).
//!
//! # In the plane
//! In the coordinates along `t_1` and `t_2` from the foot point of x, p is a point of the emitter, g the slope of the emission, m the part of
//! n1 and `phi = n1.n2`. On an edge with the direction tau, outward normal nu, at the signed distance d, `p = d nu + s tau`, and
//! `int s^k/r^2 ds` for k = 0, 1, 2 is `L0 = angle/S`, `L1 = ln(r2/r1)`, `L2 = |e| - S angle`. With `A<f> = int f/r^4 dA` and sums over
//! edges ([`crate::forms::polynomial::moments`])
//! - `a = A<p> = -1/2 sum nu L0`, `h^2 A<1> = 1/2 sum d L0`;
//! - `A<p (p.b)> = 1/2 (X1 b - sum (b.nu) k)`, `k = int p/r^2 ds = d L0 nu + L1 tau`, for b = g and b = m;
//! - `A<p (p.g)(p.m)> = 1/6 [2 (g (m.c) + m (g.c) + c (g.m)) - sum K]` with `c = int p/r^2 dA = sum d k - 2 h^2 a` and
//!   `K = contour grad((p.e)(p.g)(p.m)).nu/r^2 ds`, as a vector by which e is multiplied. With
//!   `q_b = ((b.nu) d^2 L0 + (b.tau) d L1, (b.nu) d L1 + (b.tau) L2)`, the integral of `p (p.b)/r^2` along nu and tau, that is
//!   `nu [(g.nu, g.tau).q_m] + (g.nu) [nu q_m1 + tau q_m2] + (m.nu) [nu q_g1 + tau q_g2]`.
//!
//! So of a weight `lambda = w + s.p` ([`crate::forms::affine_weights`]) `E[lambda] = w E[1] + s.(h A<p (p.m)> - phi h^2 a)`,
//! `E[1] = h m.a - phi h^2 A<1>`, and `R[lambda g.p] = w R[g.p] + s.(A<p (p.g)(p.m)> - h phi A<p (p.g)>)`,
//! `R[g.p] = m.A<p (p.g)> - h phi g.a`.
//!
//! # Along an edge
//! In the plane of x and the edge, V has the components of [`crate::forms::linear`], from
//! `int cos^2, cos sin, sin^2` = `(angle + w)/2, [s^2/r^2]/2, (angle - w)/2`, `w = S [s/r^2]`; the shares of the ends are
//! `(s2 near - V.along)/|e|` and `(V.along - s1 near)/|e|`, `near = toward.V/S`.
//!
//! Loses digits as [`crate::forms::linear`] does, and one over the angle under which an edge is seen.

use std::ops::{Add, Mul, Sub};

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f64x4};
use radgrad_numbers::ball::Ball;
use radgrad_numbers::in_library;
use radgrad_numbers::lanes::ball::LaneBall;
use radgrad_numbers::lanes::vectors::splat_vector;
use radgrad_numbers::number::ROUNDOFF;
use radgrad_numbers::real::Real;
use radgrad_numbers::vec3::Vec3;

use crate::boundary::plan::{Horizon, Plan};
use crate::forms::edge_lanes::linear::Added;
use crate::forms::edge_lanes::shares::{Shared, next_of, rows};
use crate::forms::edge_lanes::{EdgeLanes, INSTRUCTION_SET, plan};
use crate::forms::linear::{LinearSum, SeenLinear};
use crate::forms::linear_bound::Errors;
use crate::problem::emission::Emitter;
use crate::problem::polygon::Polygon;
use crate::problem::polynomial::plane::axes;
use crate::problem::receiver::Receiver;

/// A vector of the emitter's plane.
type InPlane<T> = [T; 2];

/// The derivatives of an emission by vertex values where double precision is sure of all decisions, and no edge passes near or is seen
/// past a quarter turn.
#[inline]
pub(crate) fn at_vertices(receiver: &Receiver, emitter: &Emitter) -> Option<Shared> {
    let polygon = emitter.polygon();
    in_library!(*INSTRUCTION_SET, simd => {
        let plan = plan(simd, receiver, polygon)?;
        if plan.horizon != Horizon::Above || polygon.half_slab() != 0.0 {
            return None;
        }
        on_lanes(simd, receiver, emitter, plan)
    })
}

#[inline(always)]
fn on_lanes<S: Simd>(simd: S, receiver: &Receiver, emitter: &Emitter, plan: Plan) -> Option<Shared> {
    let (polygon, power) = (emitter.polygon(), plan.power);
    let [edges] = polygon.four_edges() else { return None };
    let count = polygon.vertices().len();
    let x = splat_vector(simd, receiver.position());
    let four = EdgeLanes::new::<false>(simd, edges, x, f64x4::splat(simd, power), true)?;
    let linear = SeenLinear::<Ball<f64>>::new(receiver, emitter, power);
    let mut sum = LinearSum::new(SeenLinear::from(receiver, emitter, power, linear.height.value()));
    let mut errors = Errors::new(&sum, receiver, emitter, power, ROUNDOFF)?;
    let added = sum.add_four::<S, false>(simd, &four, None, count)?;
    errors.add_four::<S, false>(simd, &sum, (&four, &added), None, count)?;
    let seen = Seen::new(linear, polygon, Ball::approximate(sum.x1, errors.of_x1()));
    let edge = Edges::new(simd, &seen, &four, &added);
    let region = Region::new(&seen, &edge, count);
    Some(seen.shared(simd, plan, &edge, &region, count))
}

/// An affine emission as x sees it, its slope and n1 in the plane too.
struct Seen {
    linear: SeenLinear<Ball<f64>>,
    axes: [Vec3<Ball<f64>>; 2],
    slope: InPlane<Ball<f64>>,
    normal: InPlane<Ball<f64>>,
    /// `n1.n2`.
    facing: Ball<f64>,
    x1: Ball<f64>,
}

/// Four edges, seen from x: in the plane, in space, and the integrals along them.
struct Edges<S: Simd> {
    /// Where each one ends.
    end: InPlane<LaneBall<S>>,
    along: InPlane<LaneBall<S>>,
    outward: InPlane<LaneBall<S>>,
    /// The signed distance of its line.
    d: LaneBall<S>,
    /// `int s^k/r^2 ds`.
    powers: [LaneBall<S>; 3],
    /// `N` times the shares of its start and of its end.
    shares: [Vec3<LaneBall<S>>; 2],
}

/// Integrals over the emitter.
struct Region {
    /// `A<p>` and `h^2 A<1>`.
    first: InPlane<Ball<f64>>,
    facing: Ball<f64>,
    /// `A<p (p.g)>` and `A<p (p.m)>`.
    by_slope: InPlane<Ball<f64>>,
    by_normal: InPlane<Ball<f64>>,
    /// `A<p (p.g)(p.m)>`.
    third: InPlane<Ball<f64>>,
}

#[inline(always)]
fn dot<T: Copy + Add<Output = T> + Mul<Output = T>>(a: InPlane<T>, b: InPlane<T>) -> T {
    a[0] * b[0] + a[1] * b[1]
}

#[inline(always)]
fn times<T: Copy + Mul<Output = T>>(a: InPlane<T>, factor: T) -> InPlane<T> {
    [a[0] * factor, a[1] * factor]
}

#[inline(always)]
fn plus<T: Copy + Add<Output = T>>(a: InPlane<T>, b: InPlane<T>) -> InPlane<T> {
    [a[0] + b[0], a[1] + b[1]]
}

#[inline(always)]
fn minus<T: Copy + Sub<Output = T>>(a: InPlane<T>, b: InPlane<T>) -> InPlane<T> {
    [a[0] - b[0], a[1] - b[1]]
}

#[inline(always)]
fn splat<S: Simd>(simd: S, v: Vec3<Ball<f64>>) -> Vec3<LaneBall<S>> {
    Vec3::new(LaneBall::splat(simd, v.x), LaneBall::splat(simd, v.y), LaneBall::splat(simd, v.z))
}

#[inline(always)]
fn splat_in_plane<S: Simd>(simd: S, v: InPlane<Ball<f64>>) -> InPlane<LaneBall<S>> {
    [LaneBall::splat(simd, v[0]), LaneBall::splat(simd, v[1])]
}

#[inline(always)]
fn rounded<S: Simd>(v: Vec3<f64x4<S>>) -> Vec3<LaneBall<S>> {
    Vec3::new(LaneBall::rounded(v.x), LaneBall::rounded(v.y), LaneBall::rounded(v.z))
}

impl<S: Simd> Edges<S> {
    #[inline(always)]
    fn new(simd: S, seen: &Seen, four: &EdgeLanes<S>, added: &Added<S>) -> Self {
        let number = |ball| LaneBall::splat(simd, ball);
        let (one, half) = (number(Ball::exact(1.0)), number(Ball::exact(0.5)));
        let (arc, axes) = (&four.arc, [splat(simd, seen.axes[0]), splat(simd, seen.axes[1])]);
        // Differences that are rounded once.
        let (start, end, e) = (rounded(arc.start.point), rounded(arc.end.point), rounded(four.line.e));
        let length = e.norm_squared().sqrt();
        let inverse_length = one / length;
        let in_plane = |v: Vec3<LaneBall<S>>| [axes[0].dot(v), axes[1].dot(v)];
        let along = times(in_plane(e), inverse_length);
        let outward = [along[1], -along[0]];
        let (from, to) = (in_plane(start), in_plane(end));
        let d = dot(outward, from);
        let (s1, s2) = (dot(along, from), dot(along, to));
        let w = start.cross(e);
        let moment = w.norm_squared().sqrt();
        let inverse_moment = one / moment;
        let (normal, distance, nearness) = (w * inverse_moment, moment * inverse_length, length * inverse_moment);
        let angle = LaneBall::angle(moment, start.dot(end), arc.angle);
        let height = number(seen.linear.height);
        let square = height * height;
        let (square1, square2) = (start.norm_squared(), end.norm_squared());
        let [log1, log2] = added.logarithms;
        let l1 = (square2 / square).half_logarithm(log2) - (square1 / square).half_logarithm(log1);
        let powers = [angle * nearness, l1, length - distance * angle];
        let (n1, gradient) = (splat(simd, seen.linear.n1), splat(simd, seen.linear.gradient));
        let direction = e * inverse_length;
        let toward = direction.cross(normal);
        let ([p1, p2], [g1, g2]) = ([n1.dot(toward), n1.dot(direction)], [gradient.dot(toward), gradient.dot(direction)]);
        let (near1, near2) = (s1 / square1, s2 / square2);
        let wave = distance * (near2 - near1);
        let (cc, cs, ss) = ((angle + wave) * half, (s2 * near2 - s1 * near1) * half, (angle - wave) * half);
        let (mixed, beta) = (g1 * p2 + g2 * p1, number(seen.linear.beta));
        let of_toward = beta * (cc * p1 + cs * p2) + distance * (g1 * p1 * cc + mixed * cs + g2 * p2 * ss);
        let of_along = beta * (cs * p1 + ss * p2) + distance * (g1 * p1 * cs + mixed * ss + g2 * p2 * (l1 - cs));
        let near = of_toward * nearness;
        let shares = [(s2 * near - of_along) * inverse_length, (of_along - s1 * near) * inverse_length];
        Self { end: to, along, outward, d, powers, shares: [normal * shares[0], normal * shares[1]] }
    }

    /// `lambda_k = w + s.p` of the vertices in which the edges end: w and s.
    #[inline(always)]
    fn weights(&self, simd: S, count: usize) -> (LaneBall<S>, InPlane<LaneBall<S>>) {
        let share = Ball::exact(1.0) / Ball::exact(count as f64);
        let mean = [self.end[0].sum_of_first(count) * share, self.end[1].sum_of_first(count) * share];
        let middle = splat_in_plane(simd, mean);
        let arm = minus(self.end, middle);
        let product = |i: usize, j: usize| (arm[i] * arm[j]).sum_of_first(count);
        let (uu, uv, vv) = (product(0, 0), product(0, 1), product(1, 1));
        let inverse = Ball::exact(1.0) / (uu * vv - uv * uv);
        let [uu, uv, vv] = [uu, uv, vv].map(|entry| LaneBall::splat(simd, entry * inverse));
        let slope = [vv * arm[0] - uv * arm[1], uu * arm[1] - uv * arm[0]];
        (LaneBall::splat(simd, share) - dot(slope, middle), slope)
    }
}

impl Region {
    #[inline(always)]
    fn new<S: Simd>(seen: &Seen, edges: &Edges<S>, count: usize) -> Self {
        let simd = edges.d.middle().simd;
        let Edges { along, outward, d, powers: [l0, l1, l2], .. } = *edges;
        let (slope, normal) = (splat_in_plane(simd, seen.slope), splat_in_plane(simd, seen.normal));
        let sum = |v: InPlane<LaneBall<S>>| [v[0].sum_of_first(count), v[1].sum_of_first(count)];
        let (d0, d1) = (d * l0, d * l1);
        let k = plus(times(outward, d0), times(along, l1));
        let [(gn, gt), (mn, mt)] = [slope, normal].map(|v| (dot(v, outward), dot(v, along)));
        let dd = d * d0;
        let (q_m, q_g) = ([mn * dd + mt * d1, mn * d1 + mt * l2], [gn * dd + gt * d1, gn * d1 + gt * l2]);
        let by_outward = gn * q_m[0] + gt * q_m[1] + gn * q_m[0] + mn * q_g[0];
        let outflow = plus(times(outward, by_outward), times(along, gn * q_m[1] + mn * q_g[1]));
        let (half, two) = (Ball::exact(0.5), Ball::exact(2.0));
        let first = times(sum(times(outward, l0)), -half);
        let tensor = |v: InPlane<Ball<f64>>, on: LaneBall<S>| times(minus(times(v, seen.x1), sum(times(k, on))), half);
        let twice_square = two * seen.linear.height * seen.linear.height;
        let c = minus(sum(times(k, d)), times(first, twice_square));
        let (g, m) = (seen.slope, seen.normal);
        let symmetric = plus(plus(times(g, dot(m, c)), times(m, dot(g, c))), times(c, dot(g, m)));
        Self {
            first,
            facing: d0.sum_of_first(count) * half,
            by_slope: tensor(g, gn),
            by_normal: tensor(m, mn),
            third: times(minus(times(symmetric, two), sum(outflow)), Ball::exact(1.0) / Ball::exact(6.0)),
        }
    }
}

impl Seen {
    #[inline(always)]
    fn new(linear: SeenLinear<Ball<f64>>, polygon: &Polygon, x1: Ball<f64>) -> Self {
        let axes = axes(polygon);
        let in_plane = |v: Vec3<Ball<f64>>| [axes[0].dot(v), axes[1].dot(v)];
        let (slope, normal) = (in_plane(linear.gradient), in_plane(linear.n1));
        Self { linear, axes, slope, normal, facing: linear.n1.dot(linear.n2), x1 }
    }

    #[inline(always)]
    fn shared<S: Simd>(&self, simd: S, plan: Plan, edges: &Edges<S>, region: &Region, count: usize) -> Shared {
        let Self { linear: SeenLinear { n2, height, beta, gradient, .. }, axes, slope, normal, facing, .. } = *self;
        let Region { first, facing: facing_region, by_slope, by_normal, third } = *region;
        let square = height * height;
        // E[B], E[1] and R[g.p], and the vectors that slopes of weights are multiplied by.
        let in_plane = times(plus(times(first, beta), by_slope), height);
        let across = -(beta * facing_region + square * dot(slope, first));
        let of_one = height * dot(normal, first) - facing * facing_region;
        let of_slope = dot(normal, by_slope) - height * facing * dot(slope, first);
        let by_weight = minus(times(by_normal, height), times(first, facing * square));
        let by_product = minus(third, times(by_slope, height * facing));
        let (weight, weight_slope) = edges.weights(simd, count);
        let number = |ball| LaneBall::splat(simd, ball);
        let emission = weight * number(of_one) + dot(weight_slope, splat_in_plane(simd, by_weight));
        let product = weight * number(of_slope) + dot(weight_slope, splat_in_plane(simd, by_product));
        let plane = splat(simd, gradient) * emission + splat(simd, n2) * product;
        let after = |ball: LaneBall<S>| {
            ball.moved(
                #[inline(always)]
                |lanes| next_of(simd, lanes, count),
            )
        };
        let [from, to] = edges.shares;
        let vertices = to + Vec3::new(after(from.x), after(from.y), after(from.z)) - plane;
        let by_vertices = Vec3::new(vertices.x.middle(), vertices.y.middle(), vertices.z.middle());
        let radii = Vec3::new(vertices.x.error(), vertices.y.error(), vertices.z.error());
        let of_vertices = with_products(radii.norm_squared().sqrt(), by_vertices.norm_squared().sqrt());
        let of_emission = with_products(emission.error(), emission.middle().abs());
        let sum = |lanes: LaneBall<S>| -lanes.sum_of_first(count);
        let vector = axes[0] * in_plane[0] + axes[1] * in_plane[1] + n2 * across;
        let irradiance = dot(normal, in_plane) + facing * across;
        let [(vector, vector_error), (gradient, gradient_error)] =
            [vector, Vec3::new(sum(vertices.x), sum(vertices.y), sum(vertices.z))].map(|v| {
                let (middle, radius) = (v.map(Real::value), v.map(Real::error));
                (middle, with_products(radius.norm(), middle.norm()))
            });
        Shared {
            plan,
            irradiance: irradiance.value(),
            irradiance_error: with_products(irradiance.error(), irradiance.value().abs()),
            vector,
            vector_error,
            gradient,
            gradient_error,
            vertices: rows(by_vertices),
            vertex_errors: *of_vertices.as_array(),
            emission: *emission.middle().as_array(),
            emission_errors: *of_emission.as_array(),
        }
    }
}

/// A bound with the rounding of products with factors known to a few roundings.
#[inline(always)]
fn with_products<T: Add<Output = T> + Mul<f64, Output = T>>(error: T, size: T) -> T {
    (error + size * (8.0 * ROUNDOFF)) * (1.0 + 1e-9)
}
