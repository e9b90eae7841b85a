//! A-priori bounds for Gauss-Legendre quadrature, and the subdivision that makes them small.
//!
//! For f analytic with `|f| <= M` inside the Bernstein ellipse `E_R` of [-1, 1], n nodes err by at most
//! `(64/15) M R^(-2(n-1)) / (1 - R^-2)` (Trefethen, SIAM Review 50, 2008, Theorem 4.5); a product rule on a square errs by one such term
//! per variable, times the length of the other. The integrands here are polynomials over `|r|^4`, with `r = r(z)` affine in one
//! variable z. Let z run over a segment from `r_0` to `r_1` of length L. The two complex zeros of `r.r` lie where
//! `|z - 1| + |z + 1| = 2 A`, `A = (|r_0| + |r_1|) / L`, so a point z of `E_R`, whose sum is at most `2 a`, `a = (R + 1/R)/2`, is at
//! least `A - a` away from each (triangle inequality), and
//!
//! `|r.r| >= ((|r_0| + |r_1| - a L) / 2)^2`.
//!
//! Over a range of the other, real variable, `|r_0|` and `|r_1|` are convex, hence above a tangent, and L is convex, hence below its chord:
//! the bracket is bounded below by a linear function. All in double precision, with the rounding taken off each bound.

use crate::Error;
use crate::surface::dot64;

/// Relative slack for the rounding of the few dozen operations of a bound.
const SLACK: f64 = 1e-12;

/// Sizes of the integrand's factors at `q + s (a + t b)`.
#[derive(Debug, Clone)]
pub(crate) struct Shape {
    pub(crate) apex: [f64; 3],
    pub(crate) start: [f64; 3],
    pub(crate) way: [f64; 3],
    /// `n1.r` is `heights[0] + s (heights[1] + t heights[2])`.
    pub(crate) heights: [f64; 3],
    pub(crate) emission: EmissionSize,
    /// Tolerances that value and gradient must keep, as the factors `1 / tolerance`, times what multiplies the integral.
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
    /// `|grad B|`, `grad B . q`, `grad B . a`, `grad B . b` at the apex.
    pub(crate) gradient: f64,
    pub(crate) slopes: [f64; 3],
    /// Absolute coefficients of degree 2 and more, with their powers.
    pub(crate) higher: Vec<(f64, [usize; 3])>,
}

impl EmissionSize {
    /// Bounds on `|B|`, `|grad B|` and `|grad B . r|` at `q + s c`, where `|s|`, `|c|` by component, `|grad B(q) . c|` and `|r|` are bounded.
    fn bounds(&self, s: f64, slope: f64, c: [f64; 3], reach: f64) -> [f64; 3] {
        let mut value = self.value + s * slope;
        let mut gradient = 0.0;
        for (coefficient, powers) in &self.higher {
            let monomial = |powers: [usize; 3]| -> f64 {
                (0..3).map(|axis| (0..powers[axis]).fold(1.0, |product, _| product * s * c[axis])).product()
            };
            value += coefficient * monomial(*powers);
            for axis in (0..3).filter(|axis| powers[*axis] > 0) {
                let mut lower = *powers;
                lower[axis] -= 1;
                gradient += coefficient * powers[axis] as f64 * monomial(lower);
            }
        }
        [value, self.gradient + gradient, self.slopes[0].abs() + s * slope + gradient * reach]
    }
}

/// A stretch of the real variable, for bounds over the complex one.
struct Piece {
    /// Lower bounds of `|r_0| + |r_1|` and upper bounds of L at the two ends of the stretch.
    sums: [f64; 2],
    lengths: [f64; 2],
    /// `|s|`, `|n1.c|`, `|grad B . c|` and the components of `|c|`, each as `x + a y` with a the ellipse's semi-axis.
    s: [f64; 2],
    height: [f64; 2],
    slope: [f64; 2],
    c: [[f64; 2]; 3],
}

/// How many nodes a direction needs.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Order {
    pub(crate) count: usize,
    /// The bound with that many, in units of the tolerance.
    pub(crate) error: f64,
    /// Logarithm of the ellipse's R: what each further node gains twice.
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
/// A cell narrower than this cannot be bounded in double precision.
const NARROWEST: f64 = 1e-40;

fn order(shape: &Shape, pieces: &[Piece], jacobian: bool, measure: f64, share: f64) -> Order {
    const NONE: Order = Order { count: usize::MAX, error: f64::INFINITY, gain: 0.0 };
    let ends = || pieces.iter().flat_map(|p| (0..2).map(|end| (p.sums[end], p.lengths[end])));
    let farthest = ends().map(|(sum, length)| sum / length).fold(1e8, f64::min);
    if farthest.is_nan() || farthest < 1.0 + 1e-6 {
        return NONE;
    }
    let mut best = NONE;
    for fraction in FRACTIONS {
        let a = 1.0 + fraction * (farthest - 1.0);
        let radius = (a + (a * a - 1.0).sqrt()) * (1.0 - SLACK);
        let largest = pieces.iter().map(|piece| largest(shape, piece, a, jacobian)).fold(0.0, f64::max);
        let scale = measure * largest * (64.0 / 15.0) / (1.0 - 1.0 / (radius * radius)) * (1.0 + SLACK);
        let gain = libm::log(radius);
        let more = (libm::log(scale / share) / (2.0 * gain)).ceil().max(0.0);
        // Not a number and infinity end here too.
        if more < 5000.0 {
            #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a small non-negative integer")]
            let count = 1 + more as usize;
            let error = scale * libm::exp(-2.0 * gain * more) * (1.0 + 1e-9);
            if count < best.count || (count == best.count && error < best.error) {
                best = Order { count, error, gain };
            }
        }
    }
    best
}

/// Upper bound of the integrand over a piece, in units of the tolerance.
fn largest(shape: &Shape, piece: &Piece, a: f64, jacobian: bool) -> f64 {
    let at = |x: [f64; 2]| x[0] + a * x[1];
    let gaps = [0, 1].map(|end| piece.sums[end] - a * piece.lengths[end]);
    let gap = 0.5 * (gaps[0].min(gaps[1]) - SLACK * (piece.sums[0] + piece.sums[1]));
    if gap.is_nan() || gap <= 0.0 {
        return f64::INFINITY;
    }
    let (s, c) = (at(piece.s), piece.c.map(at));
    let reach = length(shape.apex) + s * length(c);
    let [value, gradient, directional] = shape.emission.bounds(s, at(piece.slope), c, reach);
    let weights = &shape.weights;
    let emission = weights.emission * value + weights.gradient * gradient + weights.directional * directional;
    let square = gap * gap;
    let height = shape.heights[0].abs() + s * at(piece.height);
    emission * height * if jacobian { s } else { 1.0 } / (square * square) * (1.0 + SLACK)
}

fn length(v: [f64; 3]) -> f64 {
    dot64(v, v).sqrt()
}

fn plus(a: [f64; 3], scale: f64, b: [f64; 3]) -> [f64; 3] {
    [a[0] + scale * b[0], a[1] + scale * b[1], a[2] + scale * b[2]]
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

    /// Largest of an affine function of t, `x + t y`, over a range.
    fn most(x: f64, y: f64, [low, high]: [f64; 2]) -> f64 {
        (x + low * y).abs().max((x + high * y).abs()) + SLACK * (x.abs() + high * y.abs())
    }

    /// For s complex and t in `range`.
    fn radial_piece(&self, s: [f64; 2], range: [f64; 2]) -> Piece {
        let middle = 0.5 * (range[0] + range[1]);
        let half = 0.5 * (range[1] - range[0]);
        let ends = s.map(|s| tangent(plus(self.apex, s, self.direction(middle)), self.way.map(|b| s * half * b)));
        let lengths = range.map(|t| (s[1] - s[0]) * length(self.direction(t)));
        let slack = SLACK * (length(self.apex) + s[1] * (length(self.start) + range[1] * length(self.way)));
        let most = |x: f64, y: f64| [Self::most(x, y, range), 0.0];
        Piece {
            sums: [0, 1].map(|end| ends[0][end] + ends[1][end] - slack),
            lengths: lengths.map(|l| l * (1.0 + SLACK)),
            s: [0.5 * (s[0] + s[1]), 0.5 * (s[1] - s[0])],
            height: most(self.heights[1], self.heights[2]),
            slope: most(self.emission.slopes[1], self.emission.slopes[2]),
            c: [0, 1, 2].map(|axis| most(self.start[axis], self.way[axis])),
        }
    }

    /// For t complex and s in `range`.
    fn transverse_piece(&self, t: [f64; 2], range: [f64; 2]) -> Piece {
        let middle = 0.5 * (range[0] + range[1]);
        let half = 0.5 * (range[1] - range[0]);
        let directions = t.map(|t| self.direction(t));
        let ends = directions.map(|c| tangent(plus(self.apex, middle, c), c.map(|c| half * c)));
        let lengths = range.map(|s| s * (t[1] - t[0]) * length(self.way) * (1.0 + SLACK));
        let slack = SLACK * (length(self.apex) + range[1] * (length(self.start) + t[1] * length(self.way)));
        let (centre, spread) = (0.5 * (t[0] + t[1]), 0.5 * (t[1] - t[0]));
        let most = |x: f64, y: f64| [(x + centre * y).abs() + SLACK * (x.abs() + centre * y.abs()), spread * y.abs()];
        Piece {
            sums: [0, 1].map(|end| ends[0][end] + ends[1][end] - slack),
            lengths,
            s: [range[1], 0.0],
            height: most(self.heights[1], self.heights[2]),
            slope: most(self.emission.slopes[1], self.emission.slopes[2]),
            c: [0, 1, 2].map(|axis| most(self.start[axis], self.way[axis])),
        }
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
        [order(self, &radial, true, measure, share), order(self, &transverse, true, measure, share)]
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
            if (s[1] - s[0]).min(t[1] - t[0]) < NARROWEST {
                let distance = length(plus(self.apex, s[0], self.direction(t[0])));
                return Err(Error::Cell { width: (s[1] - s[0]).min(t[1] - t[0]), distance });
            }
            // A wide range of t spoils the bound in s, so it is cut first. The integrand is steepest at the lower end of either range.
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
            let order = order(self, &[piece], false, 0.5 * (s[1] - s[0]), share);
            if order.count <= FEW || order.gain >= LEAST_GAIN {
                cells.push(Cell { s, t: [0.0, 0.0], orders: [order, order] });
            } else if s[1] - s[0] < NARROWEST {
                return Err(Error::Cell { width: s[1] - s[0], distance: length(plus(self.apex, s[0], self.start)) });
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
