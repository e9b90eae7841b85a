//! A cluster of emitters seen from afar: its emission as weights at a few nodes, with a bound on the remainder.
//!
//! Wholly seen, emitters give `B(x) = -(rho/pi) int F(y) . dmu(y)`, `F = (n1.r) r/r^4`, `dmu = B n2 dA` (HS95 Eq. 1). In the box
//! of the cluster F is replaced by its polynomial interpolant in Chebyshev's points, `p + 1` along each axis: the integral
//! becomes a sum of `F(y_m) . W_m` over the nodes, with the weights `W_m = int L_m dmu` of Lagrange's polynomials, found once for
//! all receivers by a Gauss rule on each emitter.
//!
//! # Bound
//! Around a point at distance r, `1/|r + t|^4 = sum of C_k(-cos) |t|^k/|r|^(k+4)` with Gegenbauer's polynomials of index 2, at
//! most `b_k = (k+1)(k+2)(k+3)/6`. With the factors `n1.(r + t)` and `r + t` the terms of order k of F are at most `[(h/D) (b_k +
//! b_(k-1)) + b_(k-1) + b_(k-2)] |t|^k/D^(k+2)`, D a lower bound of r and h an upper bound of |n1.r|: that bounds F's derivatives
//! along a line, over k!.
//! - Interpolation of degree p in Chebyshev's points over a half-width w errs by at most `2^-p w^(p+1)` times the derivative of
//!   order p + 1 over (p + 1)!. The three axes add up, the second and third times the Lebesgue constants `1 + (2/pi) ln(p + 1)`
//!   of those before (Rivlin, "The Chebyshev polynomials", 1974, chapter 1; the tests sample them).
//! - A Gauss rule with n nodes each way integrates polynomials of degree 2n - 2 over a triangle exactly, with positive weights,
//!   so it errs by at most twice the remainder of Taylor's polynomial within the triangle's reach from its middle: the sum of all
//!   terms of higher order. A linear emission takes one degree of it.
//! - Weights and sums are off by a rounding for each operation, times the product of the Lebesgue constants, which bounds the sum
//!   of `|L_m|`, and areas by some of the product of two sides, as do emissions; places by a few roundings of the coordinates,
//!   which changes F by `6/D^3` of that.

use std::f64::consts::{FRAC_1_PI, PI};
use std::ops::Range;
use std::sync::OnceLock;

use fearless_simd::{Level, Simd};
use glam::DVec3;
use radgrad_numbers::lanes::lane::{Lanes, MOST_LANES, constant, same};
use radgrad_numbers::number::ROUNDOFF;
use radgrad_numbers::on_instruction_set;
use radgrad_numbers::vec3::Vec3;

use crate::batch::cluster::{Cluster, Sight, UP};
use crate::batch::lamps::Lamps;

/// One above the highest degree of interpolation along an axis.
const DEGREES: usize = 14;

/// Distance over the box's radius at which degrees are chosen to leave [`ENOUGH`] along each axis, relative to `P/d^2`.
const USUAL: f64 = 4.5;
const ENOUGH: f64 = 1e-7;

/// `b_k`, which is 0 for the k of -1 and -2 as well.
fn gegenbauer(k: isize) -> f64 {
    ((k + 1) * (k + 2) * (k + 3)) as f64 / 6.0
}

/// The factors of `h/D` and of 1 in the bound on terms of order k.
fn order(k: usize) -> [f64; 2] {
    let k = k.cast_signed();
    [gegenbauer(k) + gegenbauer(k - 1), gegenbauer(k - 1) + gegenbauer(k - 2)]
}

/// Remainder of interpolation of a degree over a half-width at a distance, for `h = D`, relative to `1/D^2`.
fn left_by(degree: usize, half: f64, distance: f64) -> f64 {
    let ratio = half / distance;
    let [steep, flat] = order(degree + 1);
    (0..degree).fold(ratio, |power, _| power * ratio * 0.5) * (steep + flat)
}

/// Chebyshev's points of the first kind, and the factors `1/prod (x_i - x_j)` of Lagrange's polynomials.
#[derive(Debug, Clone)]
struct Points {
    nodes: Vec<f64>,
    factors: Vec<f64>,
}

impl Points {
    fn new(degree: usize) -> Self {
        let count = degree + 1;
        let nodes: Vec<f64> = (0..count).map(|i| libm::cos((2 * i + 1) as f64 * PI / (2 * count) as f64)).collect();
        let factor = |i: usize| 1.0 / (0..count).filter(|j| *j != i).map(|j| nodes[i] - nodes[j]).product::<f64>();
        Self { factors: (0..count).map(factor).collect(), nodes }
    }

    /// Lagrange's polynomials at a place.
    #[inline(always)]
    fn lagrange<S: Simd>(&self, simd: S, place: Lanes<S, f64>, values: &mut [Lanes<S, f64>; DEGREES]) {
        let count = self.nodes.len();
        for (value, factor) in values.iter_mut().zip(&self.factors) {
            *value = Lanes::splat(simd, *factor);
        }
        let (mut before, mut after) = (constant(simd, 1.0), constant(simd, 1.0));
        for i in 0..count {
            let last = count - 1 - i;
            values[i] = values[i] * before;
            before = before * (place - Lanes::splat(simd, self.nodes[i]));
            values[last] = values[last] * after;
            after = after * (place - Lanes::splat(simd, self.nodes[last]));
        }
    }
}

fn lebesgue(degree: usize) -> f64 {
    1.0 + 2.0 / PI * libm::log((degree + 1) as f64) + 1e-9
}

/// Nodes and weights of a cluster, filled up to whole vectors with weights of 0.
#[derive(Debug, Clone, Default)]
pub(super) struct Nodes {
    pub(super) place: [Vec<f64>; 3],
    pub(super) weight: [Vec<f64>; 3],
}

/// The far field of a cluster. The bound on its remainder is known before its weights, which are found when they are needed.
#[derive(Debug, Clone)]
pub(super) struct FarField {
    nodes: OnceLock<Nodes>,
    degree: [usize; 3],
    /// Nodes of the rule each way.
    rule: usize,
    axes: [Axis; 3],
    /// The remainder of the rule depends on the reach of the triangles, and on the order of the first term that it does not
    /// integrate.
    reach: f64,
    first: usize,
    /// Relative rounding error, and that of a displacement times the distance.
    rounding: f64,
    displaced: f64,
}

/// Remainder of interpolation along an axis: `(steep h/D + flat) / D^order`, relative to `1/D^2`.
#[derive(Debug, Clone, Copy)]
struct Axis {
    steep: f64,
    flat: f64,
    order: i32,
}

impl FarField {
    /// The degrees along the axes that leave little at the usual distance.
    pub(super) fn degree(cluster: &Cluster) -> [usize; 3] {
        let least = |half: f64| (0..DEGREES - 1).find(|p| left_by(*p, half, USUAL * cluster.radius) <= ENOUGH);
        cluster.half.map(|half| least(half).unwrap_or(DEGREES - 1))
    }

    /// The far field of a cluster, lamps in a range, each covered once by a fan from its vertex 0.
    pub(super) fn new(cluster: &Cluster, degree: [usize; 3], lamps: &Lamps, range: Range<usize>) -> Self {
        let emitters = range.len();
        let usual = USUAL * cluster.radius;
        let (reach, sides) = lamps.extent(range);
        // The rule's degree, less that of the emission.
        let first = |n: usize| 2 * n - lamps.order();
        let rule = (2..=6).find(|n| left_by_rule(reach / usual, first(*n)) <= ENOUGH).unwrap_or(6);
        let growth = degree.map(lebesgue);
        let axis = |k: usize| {
            let [steep, flat] = order(degree[k] + 1);
            let power = (0..degree[k]).fold(cluster.half[k], |power, _| power * cluster.half[k] * 0.5);
            let factor = growth[..k].iter().product::<f64>() * power * UP;
            Axis { steep: steep * factor, flat: flat * factor, order: i32::try_from(degree[k] + 1).unwrap_or(i32::MAX) }
        };
        let (all, count) = (growth.iter().product::<f64>(), count(degree));
        Self {
            nodes: OnceLock::new(),
            degree,
            rule,
            axes: [axis(0), axis(1), axis(2)],
            reach,
            first: first(rule),
            rounding: ((emitters + count + 520) as f64 + 16.0 * PI * sides / cluster.power) * ROUNDOFF * all,
            displaced: 256.0 * ROUNDOFF * (cluster.centre.length() + cluster.radius) * all,
        }
    }

    /// How many nodes there are, without those that fill up.
    pub(super) fn count(&self) -> usize {
        count(self.degree)
    }

    /// Nodes and weights, of the cluster and the lamps that it was made of.
    pub(super) fn nodes(&self, cluster: &Cluster, lamps: &Lamps, range: Range<usize>, level: Level) -> &Nodes {
        self.nodes.get_or_init(|| {
            let (points, gauss) = (self.degree.map(Points::new), gauss_rule(self.rule));
            let interpolation = Interpolation { cluster, points: &points, gauss: &gauss };
            interpolation.nodes(&on_instruction_set!(level, simd => interpolation.weights(simd, lamps, range)))
        })
    }

    /// Bound on the error at a receiver that sees all of the cluster, without the factor rho.
    #[inline]
    pub(super) fn error(&self, cluster: &Cluster, sight: &Sight) -> f64 {
        let Sight { highest, clear, .. } = *sight;
        if clear <= cluster.radius {
            return f64::INFINITY;
        }
        let (near, slope) = (UP / clear, (highest / clear).min(UP));
        let axes = self.axes.iter().map(|Axis { steep, flat, order }| (steep * slope + flat) * near.powi(*order)).sum::<f64>();
        let remainder = left_by_rule(self.reach * near, self.first) + self.rounding + self.displaced * near;
        cluster.power * (axes + remainder) * (near * near) * (FRAC_1_PI * UP)
    }
}

/// Nodes of an interpolation.
fn count(degree: [usize; 3]) -> usize {
    degree.iter().map(|degree| degree + 1).product()
}

/// Remainder of a rule that is exact below an order, on triangles of a reach over the distance, relative to `1/D^2`.
///
/// From order 3 on a term is at most 5q/2 times the one before: all are at most the first over `1 - 5q/2`.
#[inline]
fn left_by_rule(q: f64, first: usize) -> f64 {
    if q >= 0.2 {
        return f64::INFINITY;
    }
    let [steep, flat] = order(first);
    2.0 * (steep + flat) * (0..first).fold(1.0, |power, _| power * q) / (1.0 - 2.5 * q) * UP
}

/// Nodes and weights of Gauss and Legendre's rule on [0, 1], by Newton's method on Legendre's polynomial.
fn gauss_rule(count: usize) -> Vec<(f64, f64)> {
    let polynomial = |x: f64| {
        // The polynomial and its derivative, by the three-term recurrence.
        let (mut before, mut last) = (1.0, x);
        for k in 2..=count {
            (before, last) = (last, ((2 * k - 1) as f64 * x * last - (k - 1) as f64 * before) / k as f64);
        }
        (last, count as f64 * (x * last - before) / (x * x - 1.0))
    };
    let node = |i: usize| {
        let mut x = libm::cos(PI * (i as f64 + 0.75) / (count as f64 + 0.5));
        for _ in 0..6 {
            let (value, slope) = polynomial(x);
            x -= value / slope;
        }
        let slope = polynomial(x).1;
        (0.5 + 0.5 * x, 1.0 / ((1.0 - x * x) * slope * slope))
    };
    (0..count).map(node).collect()
}

/// The cluster, the nodes and the rule from which weights are found.
struct Interpolation<'a> {
    cluster: &'a Cluster,
    points: &'a [Points; 3],
    gauss: &'a [(f64, f64)],
}

/// Emitters that go side by side, whatever the width of vectors.
const SIDE_BY_SIDE: usize = 8;

impl Interpolation<'_> {
    /// The weights at the nodes, over pi.
    #[inline(always)]
    fn weights<S: Simd>(&self, simd: S, lamps: &Lamps, range: Range<usize>) -> Vec<[f64; 3]> {
        let [first, second, third] = self.points.each_ref().map(|points| points.nodes.len());
        let count = first * second * third;
        let mut areas = vec![0.0; count * SIDE_BY_SIDE];
        let mut sums = [(); 3].map(|()| vec![0.0; count * SIDE_BY_SIDE]);
        for block in range.clone().step_by(SIDE_BY_SIDE) {
            for lane in (0..SIDE_BY_SIDE).step_by(Lanes::<S, f64>::COUNT) {
                let entry = block + lane;
                if entry >= range.end {
                    break;
                }
                for k in 0..lamps.outlines().triangles() {
                    let [a, ab, bc, emitted] = lamps.outlines().triangle(simd, k, entry, range.end);
                    for node in 0..count {
                        constant(simd, 0.0).store(&mut areas[node * SIDE_BY_SIDE + lane..]);
                    }
                    self.integrate(simd, [a, ab, bc], lamps.emission(simd, k, entry), &mut areas[lane..]);
                    for (sums, emitted) in sums.iter_mut().zip([emitted.x, emitted.y, emitted.z]) {
                        for node in 0..count {
                            let offset = node * SIDE_BY_SIDE + lane;
                            (Lanes::load(simd, &sums[offset..]) + emitted * Lanes::load(simd, &areas[offset..]))
                                .store(&mut sums[offset..]);
                        }
                    }
                }
            }
        }
        let total = |sums: &[f64], node: usize| sums[node * SIDE_BY_SIDE..][..SIDE_BY_SIDE].iter().sum();
        (0..count).map(|node| [0, 1, 2].map(|k| total(&sums[k], node))).collect()
    }

    /// Adds the integrals of Lagrange's polynomials times the emission, `b + u (b_ab + v b_bc)`, over triangles
    /// `a + u (ab + v bc)`, over twice their areas.
    #[inline(always)]
    fn integrate<S: Simd>(
        &self,
        simd: S,
        [a, ab, bc]: [Vec3<Lanes<S, f64>>; 3],
        [base, along_ab, along_bc]: [Lanes<S, f64>; 3],
        areas: &mut [f64],
    ) {
        let Cluster { centre, axes, half, .. } = self.cluster;
        let centre = same(simd, centre.to_array());
        for (u, first) in self.gauss {
            for (v, second) in self.gauss {
                let point = a + (ab + bc * Lanes::splat(simd, *v)) * Lanes::splat(simd, *u) - centre;
                let emission = base + (along_ab + along_bc * Lanes::splat(simd, *v)) * Lanes::splat(simd, *u);
                let area = emission * Lanes::splat(simd, u * first * second);
                let mut values = [[constant(simd, 0.0); DEGREES]; 3];
                for k in 0..3 {
                    let place = same::<S, f64>(simd, axes[k].to_array()).dot(point) * Lanes::splat(simd, 1.0 / half[k]);
                    self.points[k].lagrange(simd, place, &mut values[k]);
                }
                let [first, second, third] = self.points.each_ref().map(|points| points.nodes.len());
                let mut offset = 0;
                for z in &values[2][..third] {
                    for y in &values[1][..second] {
                        let factor = area * *z * *y;
                        for x in &values[0][..first] {
                            (Lanes::load(simd, &areas[offset..]) + factor * *x).store(&mut areas[offset..]);
                            offset += SIDE_BY_SIDE;
                        }
                    }
                }
            }
        }
    }

    /// The nodes with their weights.
    fn nodes(&self, weights: &[[f64; 3]]) -> Nodes {
        let Cluster { centre, axes, half, .. } = self.cluster;
        let mut nodes = Nodes::default();
        let [first, second, third] = self.points;
        let mut push = |place: DVec3, weight: [f64; 3]| {
            nodes.place.iter_mut().zip(place.to_array()).for_each(|(array, along)| array.push(along));
            nodes.weight.iter_mut().zip(weight).for_each(|(array, along)| array.push(along));
        };
        let along = |k: usize, share: f64| axes[k] * (half[k] * share);
        let places = third.nodes.iter().flat_map(|z| second.nodes.iter().flat_map(|y| first.nodes.iter().map(|x| [*x, *y, *z])));
        for ([x, y, z], weight) in places.zip(weights) {
            push(*centre + along(0, x) + along(1, y) + along(2, z), *weight);
        }
        let filled = weights.len().next_multiple_of(MOST_LANES);
        (weights.len()..filled).for_each(|_| push(*centre, [0.0; 3]));
        nodes
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use radgrad_numbers::ball::Ball;
    use radgrad_numbers::double_double::DoubleDouble;
    use rand::{RngExt, SeedableRng, rngs::ChaCha8Rng};

    use super::*;
    use crate::batch::lamps::sorted;
    use crate::batch::shapes::Shapes;
    use crate::batch::total::far_value;
    use crate::boundary::case::Case;
    use crate::boundary::plan::Plan;
    use crate::forms::irradiance_and_gradient::IrradianceAndGradient;
    use crate::problem::emission::{Emission, Emitter};
    use crate::problem::polygon::Polygon;
    use crate::problem::receiver::{Receiver, unit_normal};

    #[test]
    fn lebesgue_constants_are_bounded() {
        for degree in 0..DEGREES {
            let points = Points::new(degree);
            let sum = |place: f64| {
                let term =
                    |i: usize| points.nodes.iter().enumerate().filter(|(j, _)| *j != i).map(|(_, x)| place - x).product::<f64>();
                (0..=degree).map(|i| (points.factors[i] * term(i)).abs()).sum::<f64>()
            };
            let largest_sum = (0..=2000).map(|i| sum(f64::from(i) * 0.001 - 1.0)).fold(0.0, f64::max);
            assert!(
                largest_sum <= lebesgue(degree) && largest_sum > 0.85 * lebesgue(degree),
                "{degree}: {largest_sum} {}",
                lebesgue(degree)
            );
        }
    }

    #[test]
    fn rules_integrate_their_degree_and_not_the_next() {
        for count in 2..=6 {
            let integral = |k: i32| gauss_rule(count).iter().map(|(x, w)| w * x.powi(k)).sum::<f64>();
            let degree = 2 * i32::try_from(count).unwrap() - 1;
            for k in 0..=degree {
                assert!((integral(k) - 1.0 / f64::from(k + 1)).abs() < 1e-15, "{count} {k}");
            }
            assert!((integral(degree + 1) - 1.0 / f64::from(degree + 2)).abs() > 1e-9);
        }
    }

    /// A flat or bent sheet of triangles or of quadrilaterals, constant or linear.
    fn sheet(bent: f64, triangles: bool, linear: bool, random: &mut ChaCha8Rng) -> Vec<Emitter> {
        let place = |i: usize, j: usize| {
            let (u, v) = (i as f64 / 6.0 - 0.5, j as f64 / 6.0 - 0.5);
            DVec3::new(u, v * 0.7, 0.3 * u - bent * (u * u + v * v) + 40.0)
        };
        let mut lamps = Vec::new();
        for i in 0..6 {
            for j in 0..6 {
                let [a, b, c, d] = [place(i, j), place(i, j + 1), place(i + 1, j + 1), place(i + 1, j)];
                let cells = if triangles { vec![vec![a, b, c], vec![a, c, d]] } else { vec![vec![a, b, c, d]] };
                for vertices in cells {
                    let mut uniform = || random.random_range(-0.2..1.0);
                    let emission = if !linear {
                        Emission::Constant(uniform())
                    } else if triangles {
                        Emission::at_vertices(vec![uniform(), uniform(), uniform()])
                    } else {
                        Emission::gradient(uniform(), DVec3::new(uniform(), uniform(), uniform()) * 6.0)
                    };
                    lamps.push(Emitter::new(Polygon::new(vertices).unwrap(), emission).unwrap());
                }
            }
        }
        lamps
    }

    /// Radiosity by the closed form in double-double.
    fn radiosity(receiver: &Receiver, lamp: &Emitter) -> f64 {
        let Some(plan) = Plan::new(receiver, lamp.polygon()) else { return 0.0 };
        let case = Case { receiver, emitter: lamp, occluders: &[], plan: &plan };
        let sums = IrradianceAndGradient::<Ball<DoubleDouble>>::sum::<true, true>(&case);
        sums.map_or(0.0, |sums| case.radiosity(unit_normal(receiver).dot(sums.irradiance).middle().hi / PI).unwrap())
    }

    #[test]
    fn far_fields_are_within_their_bounds_from_near_to_far() {
        let mut random = ChaCha8Rng::seed_from_u64(31);
        let (mut worst, mut usual) = (0.0f64, f64::INFINITY);
        let sheets = [(0.0, true), (0.0, false), (0.4, true), (-0.4, true)];
        for ((bent, triangles), linear) in sheets.into_iter().flat_map(|shape| [(shape, false), (shape, true)]) {
            let lamps = sheet(bent, triangles, linear, &mut random);
            let index: Vec<usize> = (0..lamps.len()).collect();
            let cluster = Cluster::new(&Shapes::new(&lamps, &index, 1.0));
            let (mut kinds, _) = sorted(&lamps, &index, 1.0);
            let group = kinds.remove(0);
            for degree in [FarField::degree(&cluster), [3, 2, 1]] {
                let field = FarField::new(&cluster, degree, &group, 0..lamps.len());
                let nodes = field.nodes(&cluster, &group, 0..lamps.len(), Level::new());
                for i in 0..300 {
                    let direction = DVec3::from([(); 3].map(|()| random.random_range(-1.0..1.0))) - DVec3::Z;
                    let x = cluster.centre + direction.normalize() * cluster.radius * libm::exp(0.02 * f64::from(i));
                    let n1 = (cluster.centre - x).normalize() + DVec3::from([(); 3].map(|()| random.random_range(-0.7..0.7)));
                    let receiver = Receiver::new(x, n1, 1.0).unwrap();
                    let sight = cluster.sight(x, receiver.normal());
                    let bound = field.error(&cluster, &sight);
                    if !sight.whole || bound.is_infinite() {
                        continue;
                    }
                    let exact = lamps.iter().map(|lamp| radiosity(&receiver, lamp));
                    let (sum, size) = exact.fold((0.0, 0.0), |(sum, size), exact| (sum + exact, size + exact.abs()));
                    assert!(size <= sight.largest_value, "{size:e} above the most there can be, {:e}", sight.largest_value);
                    let error = (far_value(Level::new(), nodes, &receiver) - sum).abs();
                    assert!(
                        error <= bound + 1e-11 * size,
                        "bent {bent}, linear {linear}, degree {degree:?}, {i}: {error:e} > {bound:e}"
                    );
                    worst = worst.max(error / bound);
                    usual = usual.min(bound / size);
                }
            }
        }
        println!("nearest to its bound: {worst:.2e}, smallest relative bound {usual:.1e}");
        assert!(worst > 1e-3 && usual < 1e-9);
    }
}
