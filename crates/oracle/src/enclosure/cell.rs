//! A-priori bounds for Gauss-Legendre quadrature, and the subdivision that makes them small.
//!
//! For f analytic with `|f| <= M` inside the Bernstein ellipse `E_R` of [-1, 1], n nodes err by at most `(64/15) M R^(-2(n-1))
//! / (1 - R^-2)` (Trefethen, SIAM Review 50, 2008, Theorem 4.5); a product rule on a square errs by one such term per variable,
//! times the length of the other. The integrands here are polynomials over `|r|^4`, with `r = r(z)` affine in one variable z.
//! Let z run over a segment from `r_0` to `r_1` of length L. The two complex zeros of `r.r` lie where `|z - 1| + |z + 1| = 2
//! A`, `A = (|r_0| + |r_1|) / L`, so a point z of `E_R`, whose sum is at most `2 a`, `a = (R + 1/R)/2`, is at least `A - a`
//! away from each (triangle inequality), and
//!
//! `|r.r| >= ((|r_0| + |r_1| - a L) / 2)^2`.
//!
//! Over a range of the other, real variable, `|r_0|` and `|r_1|` are convex, hence above a tangent, and L is convex, hence
//! below its chord: the bracket is bounded below by a linear function. All in double precision, with the rounding taken off
//! each bound.

use crate::Error;
use crate::enclosure::surface::{Jacobian, dot64};

/// Relative slack for the rounding of the few dozen operations of a bound.
const SLACK: f64 = 1e-12;

/// Sizes of the integrand's factors at `p + t u + s (c + t v)`.
#[derive(Debug, Clone)]
pub(crate) struct Shape {
    pub(crate) apex: [f64; 3],
    pub(crate) start: [f64; 3],
    pub(crate) way: [f64; 3],
    pub(crate) shift: [f64; 3],
    pub(crate) jacobian: Jacobian,
    /// `n1.r` is `heights[0] + t heights[3] + s (heights[1] + t heights[2])`.
    pub(crate) heights: [f64; 4],
    pub(crate) emission: EmissionSize,
    /// Tolerances that value and gradient must keep, as the factors `1 / tolerance`, times the factor of the integral.
    pub(crate) weights: Weights,
}

/// Factors of the parts of the integrand, in units of the tolerance.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Weights {
    /// Of `B (n1.r) / |r|^4`.
    pub(crate) emission: f64,
    /// Of `|grad B| (n1.r) / |r|^4`.
    pub(crate) gradient: f64,
    /// Of `|grad B . r| (n1.r) / |r|^4`.
    pub(crate) directional: f64,
}

/// Bounds on the Taylor expansion of the emission at the apex.
#[derive(Debug, Clone)]
pub(crate) struct EmissionSize {
    pub(crate) value: f64,
    /// `|grad B|` at the apex, and its product with p, c, v, u.
    pub(crate) gradient: f64,
    pub(crate) slopes: [f64; 4],
    /// Absolute coefficients of degree 2 and more, with their powers.
    pub(crate) higher: Vec<(f64, [usize; 3])>,
}

impl EmissionSize {
    /// Bounds on `|B|`, `|grad B|` and `|grad B . r|` at `p + d`, where `grad B(p) . d`, `|d|` by component, and `|r|` are
    /// bounded.
    fn bounds(&self, linear: f64, d: [f64; 3], reach: f64) -> [f64; 3] {
        let mut value = self.value + linear;
        let mut gradient = 0.0;
        let monomial = |powers: [usize; 3]| -> f64 {
            (0..3).map(|axis| (0..powers[axis]).fold(1.0, |product, _| product * d[axis])).product()
        };
        for (coefficient, powers) in &self.higher {
            value += coefficient * monomial(*powers);
            for axis in (0..3).filter(|axis| powers[*axis] > 0) {
                let mut lower = *powers;
                lower[axis] -= 1;
                gradient += coefficient * powers[axis] as f64 * monomial(lower);
            }
        }
        [value, self.gradient + gradient, self.slopes[0].abs() + linear + gradient * reach]
    }
}

/// A stretch of the real variable, for bounds over the complex one.
struct Piece {
    /// Lower bounds of `|r_0| + |r_1|` and upper bounds of L at the two ends of the stretch.
    sums: [f64; 2],
    lengths: [f64; 2],
    /// A lower bound of the sum over the whole stretch, for where the tangents fall below it.
    least: f64,
    /// `|s|` and `|1 - s|`, as `x + a y` with a the ellipse's semi-axis.
    s: [f64; 2],
    rest: [f64; 2],
    /// `n1.r`, `grad B . d` and the components of d, d the way from p.
    height: Bilinear,
    slope: Bilinear,
    way: [Bilinear; 3],
}

/// A bound `base + |s| rise`, both as `x + a y`.
#[derive(Clone, Copy)]
struct Bilinear {
    base: [f64; 2],
    rise: [f64; 2],
}

impl Piece {
    /// The shape given by the middles and half-ways of the two curves that bound the segments.
    fn new(
        curves: [([f64; 3], [f64; 3]); 2],
        lengths: [f64; 2],
        slack: f64,
        s: [f64; 2],
        rest: [f64; 2],
        [height, slope, x, y, z]: [Bilinear; 5],
    ) -> Self {
        let ends = curves.map(|(middle, step)| tangent(middle, step));
        let sums = [0, 1].map(|end| ends[0][end] + ends[1][end] - slack);
        let least = curves.map(|(middle, step)| nearest(middle, step)).iter().sum::<f64>() - slack;
        Self { sums, lengths, least, s, rest, height, slope, way: [x, y, z] }
    }

    /// The largest `a` the bound allows.
    fn farthest(&self) -> f64 {
        let ends = [0, 1].map(|end| self.sums[end] / self.lengths[end]);
        ends[0].min(ends[1]).max(self.least / self.lengths[0].max(self.lengths[1]))
    }

    /// A lower bound of `(|r_0| + |r_1| - a L) / 2` over the stretch.
    fn gap(&self, a: f64) -> f64 {
        let ends = [0, 1].map(|end| self.sums[end] - a * self.lengths[end]);
        let linear = ends[0].min(ends[1]) - SLACK * (self.sums[0].abs() + self.sums[1].abs());
        let apart = self.least * (1.0 - SLACK) - a * self.lengths[0].max(self.lengths[1]);
        0.5 * linear.max(apart)
    }
}

/// How many nodes a direction needs.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Order {
    pub(crate) count: usize,
    /// The bound with that many, in units of the tolerance.
    pub(crate) error: f64,
    /// Logarithm of the ellipse's R: each further node divides the error by `R^2`.
    gain: f64,
}

/// A part of the ranges of s and t.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Cell {
    pub(crate) s: [f64; 2],
    pub(crate) t: [f64; 2],
    pub(crate) orders: [Order; 2],
}

/// Ellipses tried: fractions of the way from the segment to the zeros.
const FRACTIONS: [f64; 7] = [0.3, 0.45, 0.58, 0.7, 0.8, 0.88, 0.94];
/// Splitting in four pays where a node gains less than this: found by trial, the total cost is flat around it.
const LEAST_GAIN: f64 = 0.75;
/// So few nodes are not worth a split.
const FEW: usize = 4;
/// More cells than this are a sign of the same.
const MOST_CELLS: usize = 100_000;
/// A cell narrower than this cannot be bounded in double precision.
const NARROWEST: f64 = 1e-40;

fn order(shape: &Shape, pieces: &[Piece], measure: f64, share: f64) -> Order {
    const NONE: Order = Order { count: usize::MAX, error: f64::INFINITY, gain: 0.0 };
    let farthest = pieces.iter().map(Piece::farthest).fold(1e8, f64::min);
    if farthest.is_nan() || farthest < 1.0 + 1e-6 {
        return NONE;
    }
    let mut best = NONE;
    for fraction in FRACTIONS {
        let a = 1.0 + fraction * (farthest - 1.0);
        let radius = (a + (a * a - 1.0).sqrt()) * (1.0 - SLACK);
        let largest = pieces.iter().map(|piece| largest(shape, piece, a)).fold(0.0, f64::max);
        let scale = measure * largest * (64.0 / 15.0) / (1.0 - 1.0 / (radius * radius)) * (1.0 + SLACK);
        let gain = libm::log(radius);
        let more = (libm::log(scale / share) / (2.0 * gain)).ceil().max(0.0);
        // Not a number and infinity end here too.
        if more < 5000.0 {
            #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a small non-negative integer")]
            let count = 1 + more as usize;
            let error = scale * libm::exp((-2.0 * gain) * more) * (1.0 + 1e-9);
            if count < best.count || (count == best.count && error < best.error) {
                best = Order { count, error, gain };
            }
        }
    }
    best
}

/// Upper bound of the integrand over a piece, in units of the tolerance.
fn largest(shape: &Shape, piece: &Piece, a: f64) -> f64 {
    let linear = |x: [f64; 2]| x[0] + a * x[1];
    let gap = piece.gap(a);
    if gap.is_nan() || gap <= 0.0 {
        return f64::INFINITY;
    }
    let s = linear(piece.s);
    let bilinear = |b: Bilinear| linear(b.base) + s * linear(b.rise);
    let way = piece.way.map(bilinear);
    let reach = length(shape.apex) + length(way);
    let [value, gradient, directional] = shape.emission.bounds(bilinear(piece.slope), way, reach);
    let weights = &shape.weights;
    let emission = weights.emission * value + weights.gradient * gradient + weights.directional * directional;
    let jacobian = match shape.jacobian {
        Jacobian::One => 1.0,
        Jacobian::Rising => s,
        Jacobian::Falling => linear(piece.rest),
    };
    let square = gap * gap;
    emission * bilinear(piece.height) * jacobian / (square * square) * (1.0 + SLACK)
}

fn length(v: [f64; 3]) -> f64 {
    dot64(v, v).sqrt()
}

fn plus(a: [f64; 3], scale: f64, b: [f64; 3]) -> [f64; 3] {
    [a[0] + scale * b[0], a[1] + scale * b[1], a[2] + scale * b[2]]
}

/// A lower bound of `|r|` over the segment around `middle` that reaches `step` either way.
fn nearest(middle: [f64; 3], step: [f64; 3]) -> f64 {
    let square = dot64(step, step);
    let place = if square > 0.0 { (-dot64(middle, step) / square).clamp(-1.0, 1.0) } else { 0.0 };
    length(plus(middle, place, step))
}

/// `|r|` at the ends of a stretch by the tangent at its middle, `r` moving by `step` from the middle to the second end.
fn tangent(middle: [f64; 3], step: [f64; 3]) -> [f64; 2] {
    let norm = length(middle);
    let slope = if norm > 0.0 { dot64(middle, step) / norm } else { 0.0 };
    [norm - slope, norm + slope]
}

impl Shape {
    fn direction(&self, t: f64) -> [f64; 3] {
        plus(self.start, t, self.way)
    }

    fn point(&self, s: f64, t: f64) -> [f64; 3] {
        plus(plus(self.apex, t, self.shift), s, self.direction(t))
    }

    /// Bound on the rounding of a point.
    fn slack(&self, s: f64, t: f64) -> f64 {
        SLACK * (length(self.apex) + t * length(self.shift) + s * (length(self.start) + t * length(self.way)))
    }

    /// `n1.r`, `grad B . d`, d as bounds, from a bound of `x + t y`.
    fn bilinear(&self, affine: impl Fn(f64, f64) -> [f64; 2]) -> [Bilinear; 5] {
        let form =
            |constant: f64, [rise, turn, shift]: [f64; 3]| Bilinear { base: affine(constant, shift), rise: affine(rise, turn) };
        let [h, slopes] = [self.heights, self.emission.slopes];
        let way = |axis: usize| form(0.0, [self.start[axis], self.way[axis], self.shift[axis]]);
        [form(h[0], [h[1], h[2], h[3]]), form(0.0, [slopes[1], slopes[2], slopes[3]]), way(0), way(1), way(2)]
    }

    /// The piece for s complex and t in `range`.
    fn radial_piece(&self, s: [f64; 2], range: [f64; 2]) -> Piece {
        let middle = 0.5 * (range[0] + range[1]);
        let half = 0.5 * (range[1] - range[0]);
        let curves = s.map(|s| (self.point(s, middle), plus(self.shift, s, self.way).map(|b| half * b)));
        let lengths = range.map(|t| (s[1] - s[0]) * length(self.direction(t)) * (1.0 + SLACK));
        let largest = |x: f64, y: f64| {
            let [low, high] = range;
            [(x + low * y).abs().max((x + high * y).abs()) + SLACK * (x.abs() + high * y.abs()), 0.0]
        };
        let (centre, spread) = (0.5 * (s[0] + s[1]), 0.5 * (s[1] - s[0]));
        Piece::new(curves, lengths, self.slack(s[1], range[1]), [centre, spread], [1.0 - centre, spread], self.bilinear(largest))
    }

    /// The piece for t complex and s in `range`.
    fn transverse_piece(&self, t: [f64; 2], range: [f64; 2]) -> Piece {
        let middle = 0.5 * (range[0] + range[1]);
        let half = 0.5 * (range[1] - range[0]);
        let curves = t.map(|t| (self.point(middle, t), self.direction(t).map(|c| half * c)));
        let lengths = range.map(|s| (t[1] - t[0]) * length(plus(self.shift, s, self.way)) * (1.0 + SLACK));
        let (centre, spread) = (0.5 * (t[0] + t[1]), 0.5 * (t[1] - t[0]));
        let largest = |x: f64, y: f64| [(x + centre * y).abs() + SLACK * (x.abs() + centre * y.abs()), spread * y.abs()];
        Piece::new(curves, lengths, self.slack(range[1], t[1]), [range[1], 0.0], [1.0 - range[0], 0.0], self.bilinear(largest))
    }

    /// The orders in s and in t on a cell.
    fn orders(&self, s: [f64; 2], t: [f64; 2], share: f64) -> [Order; 2] {
        const PIECES: usize = 3;
        let part = |[low, high]: [f64; 2], index: usize| {
            [index, index + 1].map(|i| if i == PIECES { high } else { low + (high - low) * i as f64 / PIECES as f64 })
        };
        let radial: [Piece; PIECES] = std::array::from_fn(|i| self.radial_piece(s, part(t, i)));
        let transverse: [Piece; PIECES] = std::array::from_fn(|i| self.transverse_piece(t, part(s, i)));
        // Half-lengths of both, times the length 2 of the other.
        let measure = 0.5 * (s[1] - s[0]) * (t[1] - t[0]);
        [order(self, &radial, measure, share), order(self, &transverse, measure, share)]
    }

    /// Cuts the square into cells with few nodes, each bounded by `share` per direction in units of the tolerance.
    pub(crate) fn subdivide(&self, share: f64, cells: &mut Vec<Cell>) -> Result<(), Error> {
        let mut pending = vec![([0.0, 1.0], [0.0, 1.0])];
        while let Some((s, t)) = pending.pop() {
            let orders = self.orders(s, t, share);
            let poor = |order: &Order| order.count > FEW && order.gain < LEAST_GAIN;
            let [radial, transverse] = orders.map(|order| if poor(&order) { order.gain } else { f64::INFINITY });
            if radial.is_infinite() && transverse.is_infinite() {
                cells.push(Cell { s, t, orders });
                continue;
            }
            if (s[1] - s[0]).min(t[1] - t[0]) < NARROWEST || cells.len() + pending.len() > MOST_CELLS {
                let distance = length(self.point(s[0], t[0]));
                return Err(Error::Cell { width: (s[1] - s[0]).min(t[1] - t[0]), distance });
            }
            // A wide range of t spoils the bound in s, so it is cut first. The integrand is steepest at the lower end of either
            // range.
            let wide = (t[1] - t[0]) * length(self.way) > 2.0 * length(self.direction(t[0]));
            if radial <= transverse && !(wide && transverse.is_finite()) {
                let [near, far] = parted(s);
                pending.extend([(far, t), (near, t)]);
            } else {
                let [near, far] = parted(t);
                pending.extend([(s, far), (s, near)]);
            }
        }
        Ok(())
    }

    /// The same along the ray t = 0, without the Jacobian s: for the edges.
    pub(crate) fn subdivide_ray(&self, share: f64, cells: &mut Vec<Cell>) -> Result<(), Error> {
        let mut pending = vec![[0.0, 1.0]];
        while let Some(s) = pending.pop() {
            let piece = self.radial_piece(s, [0.0, 0.0]);
            let order = order(self, &[piece], 0.5 * (s[1] - s[0]), share);
            if order.count <= FEW || order.gain >= LEAST_GAIN {
                cells.push(Cell { s, t: [0.0, 0.0], orders: [order, order] });
            } else if s[1] - s[0] < NARROWEST || cells.len() + pending.len() > MOST_CELLS {
                return Err(Error::Cell { width: s[1] - s[0], distance: length(self.point(s[0], 0.0)) });
            } else {
                let [near, far] = parted(s);
                pending.extend([far, near]);
            }
        }
        Ok(())
    }
}

/// A quarter next to the lower end, and the rest.
fn parted([low, high]: [f64; 2]) -> [[f64; 2]; 2] {
    let middle = low + 0.25 * (high - low);
    [[low, middle], [middle, high]]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::enclosure::arithmetic::Real;
    use crate::enclosure::double_double::DoubleDouble;

    fn gauss(count: usize, [low, high]: [f64; 2], f: impl Fn(f64) -> f64) -> f64 {
        let rule = DoubleDouble::rules().get(count, 106);
        let (centre, half) = (0.5 * (low + high), 0.5 * (high - low));
        rule.nodes.iter().zip(&rule.weights).map(|(x, w)| half * w.leading() * f(centre + half * x.leading())).sum()
    }

    #[test]
    fn the_bounds_cover_the_true_errors_and_not_by_orders() {
        let emission = EmissionSize { value: 1.0, gradient: 0.0, slopes: [0.0; 4], higher: Vec::new() };
        let weights = Weights { emission: 1.0, gradient: 0.0, directional: 0.0 };
        let mut shape = Shape {
            apex: [0.05, 0.0, 0.3],
            start: [0.5, 0.1, 0.0],
            way: [-0.1, 0.9, 0.0],
            shift: [0.0; 3],
            jacobian: Jacobian::Rising,
            heights: [0.2, 0.3, -0.1, 0.0],
            emission,
            weights,
        };
        for shift in [[0.0; 3], [0.02, -0.2, 0.0]] {
            shape.shift = shift;
            for jacobian in [Jacobian::Rising, Jacobian::Falling] {
                shape.jacobian = jacobian;
                let f = |s: f64, t: f64| {
                    let r = shape.point(s, t);
                    let height = shape.heights[0] + s * (shape.heights[1] + t * shape.heights[2]);
                    let area = if jacobian == Jacobian::Rising { s } else { 1.0 - s };
                    height * area / (dot64(r, r) * dot64(r, r))
                };
                let (s, t) = ([0.1, 0.5], [0.2, 0.6]);
                for share in [1e-3, 1e-6, 1e-9] {
                    let [radial, transverse] = shape.orders(s, t, share);
                    let error = |order: Order, range, g: &dyn Fn(f64) -> f64| {
                        0.4 * (gauss(order.count, range, g) - gauss(60, range, g)).abs()
                    };
                    let along = [0.2, 0.4, 0.6].map(|t| error(radial, s, &|s| f(s, t))).into_iter().fold(0.0, f64::max);
                    let across = [0.1, 0.3, 0.5].map(|s| error(transverse, t, &|t| f(s, t))).into_iter().fold(0.0, f64::max);
                    for (true_error, order) in [(along, radial), (across, transverse)] {
                        assert!(true_error <= order.error && order.error <= share, "{true_error:e} {order:?}");
                        assert!(true_error > 1e-7 * order.error, "a bound that loose costs nodes: {true_error:e} {order:?}");
                    }
                }
            }
        }
    }

    #[test]
    fn cells_fill_the_square_once() {
        let emission = EmissionSize { value: 1.0, gradient: 0.0, slopes: [0.0; 4], higher: Vec::new() };
        let weights = Weights { emission: 1e12, gradient: 0.0, directional: 0.0 };
        let (apex, start, way) = ([0.0, 0.0, 1e-6], [0.3, 0.1, 0.0], [-0.1, 0.9, 0.0]);
        let heights = [1e-6, 0.3, -0.1, 0.0];
        let shape = Shape { apex, start, way, shift: [0.0; 3], jacobian: Jacobian::Rising, heights, emission, weights };
        let mut cells = Vec::new();
        shape.subdivide(1.0, &mut cells).unwrap();
        assert!(cells.len() > 10);
        assert_eq!(cells.iter().map(|c| (c.s[1] - c.s[0]) * (c.t[1] - c.t[0])).sum::<f64>(), 1.0);
        let on_the_emitter = Shape { apex: [0.0; 3], heights: [0.0, 0.3, -0.1, 0.0], ..shape };
        assert!(matches!(on_the_emitter.subdivide(1.0, &mut Vec::new()), Err(Error::Cell { .. })));
    }
}
