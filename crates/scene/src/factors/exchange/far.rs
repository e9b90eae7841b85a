//! `A_i F_ij = (1/pi) int int (n1.r)(-n2.r)/|r|^4 dA dA` by a product Gauss rule in four variables, where two outlines are apart by more
//! than half their size: its terms have one sign, while the sum over edges cancels by the square of distance over size. Each variable has as many nodes as
//! the error that is allowed needs.
//!
//! A point of a patch is affine in each of its two variables with the other held: with s from -1 to 1, `r = p + s b`, `|b| <= a`. Let D be a lower
//! bound of `|p|`, and `t = a/D < 1`. By Gegenbauer's generating function, with `|C_k| <= G_k = (k + 1)(k + 2)(k + 3)/6` on [-1, 1],
//!
//! `1/|r|^4 = |p|^-4 sum_k C_k(-p.b/|p||b|) (s |b|/|p|)^k`, the coefficient of `s^k` at most `D^-4 G_k t^k`.
//!
//! `n.r` of the patch's own normal does not depend on s, and is at most `H`; that of the other's is `c + s d`, and the Jacobian `J + s j`. So the
//! coefficients of the integrand are at most `H D^-4 (|c J| G_k t^k + (|c j| + |d J|) G_(k-1) t^(k-1) + |d j| G_(k-2) t^(k-2))`.
//!
//! A rule of n nodes gives the means of `s^k` for k < 2n and for all odd k. Of the others it gives too little, since its error is a derivative of order 2n
//! times a positive number: for k = 2n the norm of the Legendre polynomial, `prod_(i = 1)^n i^2/(4 i^2 - 1)`, and at most `1/(k + 1)` for larger k. Ratios
//! of the terms fall with k, so that all after the first are bounded by a geometric series. The errors of the four variables add up, since weights are positive and each
//! rule is exact for the Jacobian.
//!
//! Nodes are off by some roundings of coordinates up to 1, and off the planes of their normals by what corners are: L in all. That changes `n.r` by
//! 2 L and r by as much; where a part is as much behind the other's plane, and exchanges nothing, the rule takes off `L H`.

use std::f64::consts::PI;

use radgrad_core::DVec3;
use smallvec::SmallVec;

use super::areas::{Exchange, ROUNDOFF};
use crate::extremes::{largest as larger, smallest as smaller};
use crate::factors::rule::{Patch, gauss_legendre, middle, patches};

/// Half the size of a patch over the distance, up to which the rule is asked.
const NEAR: f64 = 0.5;

/// Nodes in each variable, at most.
const MOST: usize = 8;

/// Roundings of coordinates up to 1 that nodes and differences of them may be off.
const OFF: f64 = 32.0 * ROUNDOFF;

/// What two outlines exchange, each in front of the other, with a truncation of `allowed` over it; `None` where they are not far apart, or too oblique.
pub(super) fn exchange(outlines: [&[DVec3]; 2], normals: [DVec3; 2], allowed: f64) -> Option<Exchange> {
    let part = |k: usize| move |patch: &Patch| Part::of(patch, normals[k]);
    let [from, to] = [0, 1].map(|k| patches(outlines[k]).iter().map(part(k)).collect::<SmallVec<[Part; 2]>>());
    if from.is_empty() || to.is_empty() {
        return None;
    }
    between([&from, &to], allowed)
}

/// The same of outlines that are made of some parts, each with all the others in front of it, in coordinates up to 1.
pub(super) fn between([from, to]: [&[Part]; 2], allowed: f64) -> Option<Exchange> {
    let mut sum = Exchange::default();
    for a in from {
        for b in to {
            let part = of_parts([a, b], allowed)?;
            sum.area += part.area;
            sum.error += part.error + ROUNDOFF * sum.area.abs();
        }
    }
    // An outline with parts of no width has no rule.
    sum.error.is_finite().then_some(sum)
}

/// Bounds on the point factors to each of two outlines from anywhere on the other.
pub(super) fn most_seen(outlines: [&[DVec3]; 2], areas: [f64; 2]) -> [f64; 2] {
    let spheres = outlines.map(|outline| {
        let centre = middle(outline);
        (centre, outline.iter().map(|p| (*p - centre).length()).fold(0.0, larger) * (1.0 + 1e-12))
    });
    let distance = larger((spheres[0].0 - spheres[1].0).length() * (1.0 - 1e-12) - spheres[0].1 - spheres[1].1, 0.0);
    areas.map(|area| smaller(area * (1.0 + 1e-12) / (PI * distance * distance), 1.0))
}

/// A patch as `middle + u edges[0] + v edges[1] + u v twist`, u and v from -1 to 1.
#[derive(Debug, Clone)]
pub(in crate::factors) struct Part {
    normal: DVec3,
    middle: DVec3,
    edges: [DVec3; 2],
    twist: DVec3,
    /// Its area for a unit of u v in the middle, and what u and v change of it.
    density: f64,
    slopes: [f64; 2],
    /// Half its length at most, along u and along v.
    halves: [f64; 2],
    radius: f64,
    /// How far corners are off its plane.
    tilt: f64,
    corners: [DVec3; 4],
}

/// Four nodes, for the lanes of the machine: their coordinates and their weights.
#[derive(Debug, Clone, Copy)]
struct Nodes {
    place: [[f64; LANES]; 3],
    weight: [f64; LANES],
}

const LANES: usize = 4;

impl Part {
    pub(in crate::factors) fn of(patch: &Patch, normal: DVec3) -> Self {
        let [a, b, c, d] = patch.corners;
        let middle = (a + b + c + d) * 0.25;
        let edges = [(b + c - a - d) * 0.25, (c + d - a - b) * 0.25];
        let twist = (a + c - b - d) * 0.25;
        let area = |u: DVec3, v: DVec3| normal.dot(u.cross(v));
        let halves = edges.map(|edge| larger((edge + twist).length(), (edge - twist).length()) * (1.0 + 1e-12));
        Self {
            normal,
            middle,
            edges,
            twist,
            density: area(edges[0], edges[1]),
            slopes: [area(edges[0], twist), area(twist, edges[1])],
            halves,
            radius: patch.corners.iter().map(|p| (*p - middle).length()).fold(0.0, larger) * (1.0 + 1e-12),
            tilt: patch.corners.iter().map(|p| normal.dot(*p - middle).abs()).fold(0.0, larger),
            corners: patch.corners,
        }
    }

    /// Its largest height over another's plane.
    fn height(&self, other: &Self) -> f64 {
        self.corners.iter().map(|&p| other.normal.dot(p - other.middle).abs()).fold(0.0, larger)
    }

    fn at(&self, u: f64, v: f64) -> (DVec3, f64) {
        let point = self.middle + self.edges[0] * u + (self.edges[1] + self.twist * u) * v;
        (point, self.density + self.slopes[0] * u + self.slopes[1] * v)
    }

    /// The points of a product rule, and the area that each stands for.
    fn nodes(&self, counts: [usize; 2]) -> impl Iterator<Item = (DVec3, f64)> {
        let [along, across] = counts.map(gauss_legendre);
        across.iter().flat_map(move |&(v, z)| {
            along.iter().map(move |&(u, w)| {
                let (point, density) = self.at(u, v);
                (point, w * z * density)
            })
        })
    }

    /// For each variable the nodes that bring its truncation below `allowed`, and the sum of both truncations; all over `H A/(pi D^4)`, of the other. `most`
    /// is its largest height over the other's plane.
    fn rule(&self, other: &Self, most: f64, distance: f64, allowed: f64) -> Option<([usize; 2], f64)> {
        let (mut counts, mut sum) = ([0; 2], 0.0);
        for (k, count) in counts.iter_mut().enumerate() {
            let tilt = other.normal.dot(self.edges[k]).abs() + other.normal.dot(self.twist).abs() + OFF;
            let (density, slope) = (self.density, self.slopes[k].abs());
            let sizes = [most * density, most * slope + tilt * density, tilt * slope].map(|size| 4.0 * size);
            let (nodes, truncation) = nodes_for(sizes, self.halves[k] / distance, allowed)?;
            (*count, sum) = (nodes, sum + truncation);
        }
        Some((counts, sum))
    }
}

/// The least nodes whose truncation is at most `allowed`, and this: of `1/|r|^4`, `t` of the module's text, times a polynomial of these coefficients.
fn nodes_for(sizes: [f64; 3], t: f64, allowed: f64) -> Option<(usize, f64)> {
    if t.is_nan() || t > NEAR {
        return None;
    }
    let square = t * t;
    let (mut left, mut power) = (1.0, 1.0);
    for nodes in 1..=MOST {
        let n = nodes as f64;
        left *= n * n / (4.0 * n * n - 1.0);
        // `t^k G_k` from k = 2n - 2 on.
        let largest = |k: f64| (k + 1.0) * (k + 2.0) * (k + 3.0) / 6.0;
        let [g0, g1, g2, g3, g4] = [0.0, 1.0, 2.0, 3.0, 4.0].map(|k| largest(2.0 * n - 2.0 + k));
        let rest = square / ((2.0 * n + 3.0) * (1.0 - square * g4 / g2));
        let terms = [square * (g2 * left + g4 * rest), t * (g1 * left + g3 * rest), g0 * left + g2 * rest];
        let truncation = power * (terms[0] * sizes[0] + terms[1] * sizes[1] + terms[2] * sizes[2]) * (1.0 + 1e-9);
        if truncation <= allowed {
            return Some((nodes, truncation));
        }
        power *= square;
    }
    None
}

fn of_parts([a, b]: [&Part; 2], allowed: f64) -> Option<Exchange> {
    let between = b.middle - a.middle;
    let square = between.length_squared();
    let distance = square.sqrt() * (1.0 - 1e-12) - a.radius - b.radius - OFF;
    if distance.is_nan() || distance <= 0.0 {
        return None;
    }
    let areas = [4.0 * a.density, 4.0 * b.density];
    let rough = areas[0] * areas[1] * a.normal.dot(between) * -b.normal.dot(between) / (square * square);
    let off = OFF + a.tilt + b.tilt;
    let heights = [a.height(b) + off, b.height(a) + off];
    let nearest = 1.0 / (distance * distance * distance * distance);
    let share = 0.25 * allowed * rough;
    let units = [heights[1] * areas[1] * nearest, heights[0] * areas[0] * nearest];
    let (counts_a, truncation_a) = a.rule(b, heights[0], distance, share / units[0])?;
    let (counts_b, truncation_b) = b.rule(a, heights[1], distance, share / units[1])?;
    let truncation = units[0] * truncation_a + units[1] * truncation_b;
    let nodes = Nodes::of(b.nodes(counts_b));
    let normals = [a, b].map(|part| part.normal.to_array());
    let mut sum = 0.0;
    for (x, weight) in a.nodes(counts_a) {
        let mut seen = [0.0; LANES];
        nodes.iter().for_each(|nodes| nodes.add_seen(x.to_array(), normals, &mut seen));
        sum += weight * ((seen[0] + seen[1]) + (seen[2] + seen[3]));
    }
    let rounding = areas[0] * areas[1] * nearest * 4.0 * off * (heights[0] + heights[1] + off)
        + sum.abs() * (8.0 * off / distance + 256.0 * ROUNDOFF);
    Some(Exchange { area: sum / PI, error: (rounding + truncation) / PI * 1.01 })
}

impl Nodes {
    /// Some nodes, by fours: the last ones are filled up with such that weigh nothing.
    fn of(points: impl Iterator<Item = (DVec3, f64)>) -> SmallVec<[Self; 4]> {
        let mut all: SmallVec<[Self; 4]> = SmallVec::new();
        for (place, (point, weight)) in points.enumerate() {
            let lane = place % LANES;
            if lane == 0 {
                all.push(Self { place: point.to_array().map(|x| [x; LANES]), weight: [0.0; LANES] });
            }
            if let Some(last) = all.last_mut() {
                last.place.iter_mut().zip(point.to_array()).for_each(|(places, x)| places[lane] = x);
                last.weight[lane] = weight;
            }
        }
        all
    }

    /// Adds `weight (n1.r)(-n2.r)/|r|^4` of each to the sums.
    #[inline]
    fn add_seen(&self, from: [f64; 3], [own, facing]: [[f64; 3]; 2], sums: &mut [f64; LANES]) {
        let [x, y, z] = &self.place;
        for (k, sum) in sums.iter_mut().enumerate() {
            let r = [x[k] - from[0], y[k] - from[1], z[k] - from[2]];
            let dot = |a: [f64; 3]| a[0] * r[0] + a[1] * r[1] + a[2] * r[2];
            let square = dot(r);
            *sum -= self.weight[k] * dot(own) * dot(facing) / (square * square);
        }
    }
}
