//! Far away: a product Gauss-Legendre rule on the emitter, with its error bound. For emitters wholly above the horizon and
//! unoccluded.
//!
//! The closed form cancels like the distance over the size, this rule not at all: from a few sizes away a handful of nodes
//! gives `B = (rho/pi) h int B(y) (n1.r)/r^4 dA` and `grad B = (rho/pi) int B(y) [n2 (n1.r) - n1 h + 4 h (n1.r) r/r^2]/r^4 dA`
//! (HS95 Eq. 1 differentiated) to rounding. The polygon is a fan of signed triangles, each `y = P + a (e1 + b e)`, a and b in
//! [0, 1], e the side opposite P.
//!
//! # Bound
//! In one variable, the other held, y moves on a segment of half-length l. In the ellipse `E_R` around it (semi-axes A and tau,
//! `A + tau = R`) `|r.r| >= q = d^2 - tau^2 l^2` with d a lower bound of the distance of the real segment stretched to A: its
//! height over the plane, or the distance of the centroid less what the stretched triangle reaches. There `|r| <= rho + (R - 1)
//! l`, B grows as [`source`] says, and the integrand is bounded by M; n nodes on a unit interval err by at most `(32/15) M
//! R^(-2(n-1)) / (1 - R^-2)` (Trefethen, "Is Gauss quadrature better than Clenshaw-Curtis?", 2008, Theorem 4.5 with n - 1 for
//! its n), one such term for each variable.
//!
//! Rounding: positions err by `delta = u (2 rho + 12 L)`, L the longest side, and everything else by the roundings counted in
//! [`Triangle::roundings`], against the sum of `1/r^4`, whose terms are all positive.

mod rules;
mod source;

use crate::geometry::Polygon;
use crate::number::ROUNDOFF;
use crate::plan::{Horizon, Plan, height_over_plane, offset, unit_normal};
use crate::vec3::Vec3;
use crate::{Emitter, Receiver};
use source::{OnTriangle, Source};

/// Value and gradient without the factor rho/pi, in normalised lengths and emission, with absolute error bounds.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Integral {
    pub(crate) value: f64,
    pub(crate) gradient: Vec3<f64>,
    pub(crate) value_error: f64,
    pub(crate) gradient_error: f64,
}

/// What all triangles of a case share.
struct Scene<'a> {
    n1: Vec3<f64>,
    n2: Vec3<f64>,
    height: f64,
    source: Source<'a>,
    /// Relative error that the input brings: vertices off the plane, values off the affine function.
    input_error: f64,
}

/// A triangle of the fan, seen from the receiver.
struct Triangle {
    apex: Vec3<f64>,
    first: Vec3<f64>,
    side: Vec3<f64>,
    emission: OnTriangle,
    /// Signed, and a bound on its error.
    twice_area: f64,
    twice_area_error: f64,
    grid: [Grid; 2],
    truncation: Bound,
    /// Bounds on the distance of its points from the receiver, and its longest side.
    nearest: f64,
    farthest: f64,
    longest: f64,
}

/// Bounds on the errors of value and gradient.
#[derive(Debug, Clone, Copy, Default)]
struct Bound {
    value: f64,
    gradient: f64,
}

/// The rule for a case: how many nodes where, and what they leave.
pub(crate) struct Rule<'a> {
    scene: Scene<'a>,
    first: Triangle,
    /// Of polygons that are no triangle.
    others: Vec<Triangle>,
}

impl<'a> Rule<'a> {
    /// The rule that a case needs for full precision; `None` where the emitter is cut by the horizon or too near for any.
    pub(crate) fn new(receiver: &Receiver, emitter: &'a Emitter, plan: &Plan) -> Option<Self> {
        if plan.horizon != Horizon::Above {
            return None;
        }
        let scene = Scene::new(receiver, emitter, plan);
        let triangle = |index: usize| scene.triangle(receiver, emitter, plan, index);
        let first = triangle(0)?;
        let others = (1..emitter.polygon().vertices().len() - 2).map(triangle).collect::<Option<_>>()?;
        Some(Self { scene, first, others })
    }

    /// Number of nodes in all.
    pub(crate) fn nodes(&self) -> usize {
        self.triangles().map(|triangle| triangle.grid[0].nodes() * triangle.grid[1].nodes()).sum()
    }

    pub(crate) fn integrate(&self) -> Integral {
        let mut sum = Integral::default();
        for triangle in self.triangles() {
            sum.add(self.scene.integral(triangle), self.others.len());
        }
        sum
    }

    fn triangles(&self) -> impl Iterator<Item = &Triangle> {
        std::iter::once(&self.first).chain(&self.others)
    }
}

/// A composite rule for one variable: equal panels with the same number of nodes.
#[derive(Debug, Clone, Copy, Default)]
struct Grid {
    panels: usize,
    count: usize,
}

impl Grid {
    fn nodes(self) -> usize {
        self.panels * self.count
    }

    /// Nodes and weights on [0, 1], two at a time.
    #[inline]
    fn pairs(self) -> impl Iterator<Item = rules::Pair> {
        let width = 1.0 / self.panels as f64;
        (0..self.panels).flat_map(move |panel| {
            rules::rule(self.count).iter().map(move |pair| rules::Pair {
                nodes: pair.nodes.map(|node| (panel as f64 + node) * width),
                weights: pair.weights.map(|weight| weight * width),
            })
        })
    }
}

impl Integral {
    fn add(&mut self, other: Self, terms: usize) {
        let rounding = terms as f64 * ROUNDOFF;
        self.value += other.value;
        self.gradient = self.gradient + other.gradient;
        self.value_error += other.value_error + rounding * other.value.abs();
        self.gradient_error += other.gradient_error + rounding * other.gradient.norm_squared().sqrt();
    }
}

impl<'a> Scene<'a> {
    fn new(receiver: &Receiver, emitter: &'a Emitter, plan: &Plan) -> Self {
        let polygon = emitter.polygon();
        let height: f64 = height_over_plane(receiver.position(), polygon, plan.power);
        let source = Source::new(emitter);
        let input_error = 8.0 * polygon.planarity_defect() * plan.power / height + source.input_error;
        Self { n1: unit_normal(receiver), n2: polygon.normal().into(), height, source, input_error }
    }

    /// The triangle with the number of nodes it needs for full precision; `None` if that is more than there are rules for.
    fn triangle(&self, receiver: &Receiver, emitter: &Emitter, plan: &Plan, index: usize) -> Option<Triangle> {
        let (x, power, polygon) = (receiver.position(), plan.power, emitter.polygon());
        let indices = apex_first(polygon, index, power);
        let corners = indices.map(|vertex| polygon.vertices()[vertex]);
        let [apex, second, third] = corners.map(|v| offset::<f64>(v, x, power));
        let first: Vec3<f64> = offset(corners[1], corners[0], power);
        let last: Vec3<f64> = offset(corners[2], corners[0], power);
        let side: Vec3<f64> = offset(corners[2], corners[1], power);
        let lengths = [first, last, side].map(|e| e.norm_squared().sqrt());
        let (twice_area, twice_area_error) = if polygon.vertices().len() == 3 {
            let twice_area = 2.0 * polygon.area_scaled(power);
            (twice_area, 4.0 * ROUNDOFF * twice_area)
        } else {
            (self.n2.dot(first.cross(last)), 12.0 * ROUNDOFF * lengths[0] * lengths[1])
        };
        let centroid = (apex + second + third) * (1.0 / 3.0);
        let distance = centroid.norm_squared().sqrt() * (1.0 - 16.0 * ROUNDOFF);
        let reach = [apex, second, third].map(|v| (v - centroid).norm_squared().sqrt());
        let reach = reach[0].max(reach[1]).max(reach[2]) + 16.0 * ROUNDOFF * distance;
        let mut triangle = Triangle {
            apex,
            first,
            side,
            emission: self.source.on_triangle(indices),
            twice_area,
            twice_area_error,
            grid: [Grid::default(); 2],
            truncation: Bound::default(),
            nearest: self.height.max(distance - reach),
            farthest: distance + reach,
            longest: lengths[0].max(lengths[1]).max(lengths[2]),
        };
        // The Jacobian a is at most 1 + (A - 1)/2p in its own variable on p panels, and 1/2 on average in the other.
        let clear = distance - reach;
        let along = self.grid(&triangle, 0.5 * lengths[0].max(lengths[1]), clear, |overhang| 1.0 + overhang)?;
        let across = self.grid(&triangle, 0.5 * lengths[2], clear, |_| 0.5)?;
        triangle.grid = [along.0, across.0];
        triangle.truncation = Bound { value: along.1.value + across.1.value, gradient: along.1.gradient + across.1.gradient };
        Some(triangle)
    }

    /// The cheapest grid for one variable, and the bound on what it leaves.
    fn grid(&self, triangle: &Triangle, half: f64, clear: f64, jacobian: impl Fn(f64) -> f64) -> Option<(Grid, Bound)> {
        /// So few nodes are never half as many on half the length.
        const FEW: usize = 6;
        let mut best: Option<(Grid, Bound)> = None;
        for panels in [1, 2, 4, 8] {
            let overhang = |stretch: f64| jacobian(0.5 * (stretch - 1.0) / panels as f64);
            let Some((count, bound)) = self.nodes(triangle, half / panels as f64, clear, overhang) else { continue };
            let grid = Grid { panels, count };
            if best.is_some_and(|(cheapest, _)| cheapest.nodes() <= grid.nodes()) {
                break;
            }
            best = Some((grid, bound));
            if count <= FEW {
                break;
            }
        }
        best
    }

    /// Nodes that each panel of half-length `half` needs, and the bound on what all of them leave.
    fn nodes(&self, triangle: &Triangle, half: f64, clear: f64, jacobian: impl Fn(f64) -> f64) -> Option<(usize, Bound)> {
        /// Share of the way to the nearest singularity; above it M grows faster than the ellipse helps.
        const SHARE: f64 = 0.75;
        let Self { height, source, .. } = self;
        let height = *height;
        let tau = (SHARE * height / half).max(0.5 * SHARE * clear / half);
        let stretch = (tau * tau + 1.0).sqrt();
        let ratio = stretch + tau;
        let distance = height.max(clear - (stretch - 1.0) * half) * (1.0 - 8.0 * ROUNDOFF);
        let q = distance * distance - tau * tau * half * half;
        if q <= 0.0 || q.is_nan() {
            return None;
        }
        let reach = triangle.farthest + (ratio - 1.0) * half;
        let emission = source.largest * source.growth(stretch, ratio);
        let shrink = 1.0 / (ratio * ratio);
        let common = 32.0 / 15.0 * triangle.twice_area.abs() * jacobian(stretch) * emission / (q * q * (1.0 - shrink)) * 1.01;
        let mut bound =
            Bound { value: common * height * reach, gradient: common * (height + reach + 4.0 * height * reach * reach / q) };
        // What the answer is expected to be like, by size: a hundredth of a roundoff of it is not worth another node.
        let typical = 0.5 * triangle.twice_area.abs() * source.largest * height / (triangle.farthest * triangle.farthest);
        let (value, gradient) = (typical / triangle.farthest, typical / (triangle.farthest * triangle.farthest));
        for count in 1..=rules::MOST {
            if bound.value <= 0.25 * ROUNDOFF * value && bound.gradient <= 0.25 * ROUNDOFF * gradient {
                return Some((count, bound));
            }
            bound.value *= shrink;
            bound.gradient *= shrink;
        }
        None
    }

    fn integral(&self, triangle: &Triangle) -> Integral {
        let Self { n1, n2, height, .. } = *self;
        let total = match &triangle.emission {
            OnTriangle::Affine([value, first, side]) => self.sums(triangle, |a| {
                let (start, step) = (value + first * a, side * a);
                move |b| start + step * b
            }),
            OnTriangle::Polynomial(polynomial, [p, first, side]) => self.sums(triangle, |a| {
                let start = [p[0] + first[0] * a, p[1] + first[1] * a];
                let step = [side[0] * a, side[1] * a];
                move |b| polynomial.value([start[0] + step[0] * b, start[1] + step[1] * b])
            }),
        };
        let gradient = n2 * total.projected - n1 * (height * total.plain) + total.pulled * (4.0 * height);
        let error = triangle.error(self, &total);
        Integral {
            value: triangle.twice_area * height * total.projected,
            gradient: gradient * triangle.twice_area,
            value_error: triangle.truncation.value + error.value,
            gradient_error: triangle.truncation.gradient + error.gradient,
        }
    }

    /// Sums over the nodes, with the emission as a function of a, then of b.
    #[inline]
    fn sums<F: Fn(f64) -> f64>(&self, triangle: &Triangle, emission: impl Fn(f64) -> F) -> Sums {
        let mut total = Sums::default();
        for pair in triangle.grid[0].pairs() {
            for (a, weight) in pair.nodes.into_iter().zip(pair.weights).filter(|(_, weight)| *weight > 0.0) {
                total.add(weight * a, &self.row(triangle, a, emission(a)));
            }
        }
        total
    }

    /// The sums along one row of nodes: two lanes, which compile to vector instructions of every target.
    #[inline]
    fn row(&self, triangle: &Triangle, a: f64, emission: impl Fn(f64) -> f64) -> Sums {
        let Triangle { apex, first, side, .. } = *triangle;
        let (start, step) = (apex + first * a, side * a);
        let mut lanes = [Sums::default(); 2];
        for pair in triangle.grid[1].pairs() {
            for (lane, sums) in lanes.iter_mut().enumerate() {
                let (b, weight) = (pair.nodes[lane], pair.weights[lane]);
                let r = start + step * b;
                let inverse = 1.0 / r.norm_squared();
                let k = weight * inverse * inverse;
                let emitted = k * emission(b);
                let projected = emitted * self.n1.dot(r);
                let pulled = r * (projected * inverse);
                sums.add(1.0, &Sums { positive: k, plain: emitted, projected, pulled });
            }
        }
        let [mut row, other] = lanes;
        row.add(1.0, &other);
        row
    }
}

/// Sums over nodes of `1/r^4` times 1, `B`, `B n1.r` and `B n1.r r/r^2`.
#[derive(Debug, Clone, Copy, Default)]
struct Sums {
    positive: f64,
    plain: f64,
    projected: f64,
    pulled: Vec3<f64>,
}

impl Sums {
    #[inline]
    fn add(&mut self, weight: f64, other: &Self) {
        self.positive += weight * other.positive;
        self.plain += weight * other.plain;
        self.projected += weight * other.projected;
        self.pulled = self.pulled + other.pulled * weight;
    }
}

impl Triangle {
    /// Relative errors, in the order of [`Sums`], against `sum 1/r^4` times the largest of what it is multiplied by.
    fn roundings(&self, emission: f64) -> [f64; 3] {
        const U: f64 = ROUNDOFF;
        let Self { nearest, farthest, longest, .. } = *self;
        let moved = U * (2.0 * farthest + 12.0 * longest) / nearest;
        let inverse = 2.0 * moved + 5.0 * U;
        // Weights, node in the Jacobian and their products; the two nested sums.
        let weights = 8.0 * U + (self.grid[0].nodes() + self.grid[1].nodes()) as f64 * U;
        let plain = 2.0 * inverse + weights + emission;
        let projected = plain + moved * nearest / farthest + 5.0 * U;
        let pulled = plain + inverse + 2.0 * moved + (5.0 * farthest / nearest + 4.0) * U;
        [plain, projected, pulled]
    }

    /// Bound on the rounding errors: those of the sums, and of area, height, normals and the last few operations, 16 roundings.
    fn error(&self, scene: &Scene<'_>, sums: &Sums) -> Bound {
        let Scene { height, ref source, input_error, .. } = *scene;
        let area = self.twice_area.abs();
        let size = sums.positive * source.largest * (1.0 + 1e-9);
        let last = area * (16.0 * ROUNDOFF + input_error) + self.twice_area_error;
        let [plain, projected, pulled] = self.roundings(source.rounding).map(|relative| area * relative + last);
        Bound {
            value: size * height * self.farthest * projected,
            gradient: size * (height * plain + self.farthest * projected + 4.0 * height * pulled),
        }
    }
}

/// Triangle `index` of the fan from vertex 0, starting at the corner opposite its shortest side if it is the whole polygon.
fn apex_first(polygon: &Polygon, index: usize, power: f64) -> [usize; 3] {
    let [a, b, c] = [0, index + 1, index + 2];
    let side = |from: usize, to: usize| ((polygon.vertices()[to] - polygon.vertices()[from]) * power).length_squared();
    let [ab, bc, ca] = [side(a, b), side(b, c), side(c, a)];
    if bc <= ab && bc <= ca {
        [a, b, c]
    } else if ca <= ab {
        [b, c, a]
    } else {
        [c, a, b]
    }
}
