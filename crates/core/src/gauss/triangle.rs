//! A triangle of the fan, `y = P + a (e1 + b e)`, a and b in [0, 1], e the side opposite P: how many nodes it needs for full
//! precision, and what they leave.
//!
//! # Truncation
//! In one variable, the other held, y moves on a segment of half-length l. In the ellipse `E_R` around it (semi-axes A and tau,
//! `A + tau = R`) `|r.r| >= q = d^2 - tau^2 l^2` with d a lower bound of the distance of the real segment stretched to A: its
//! height over the plane, or the distance of the centroid less what the stretched triangle reaches. There `|r| <= rho + (R - 1)
//! l`, `n1.r` grows by no more than that, B as [`source`](super::source) says, and the integrand is bounded by M. So are its
//! Chebyshev coefficients, by `2 M R^-k`; n nodes are exact below degree 2n and, as the integral, for all odd k, and elsewhere
//! neither is above 2 or `2/(k^2 - 1)`: on a unit interval they err by at most `(8/3) M R^(-2n) / (1 - R^-2)`, one such term for
//! each variable. (The argument of Trefethen, "Is Gauss quadrature better than Clenshaw-Curtis?", 2008, Theorem 4.5, whose bound
//! gives one power of `R^2` away.)

use super::Scene;
use super::outline::Corner;
use super::rules;
use super::source::OnTriangle;
use crate::number::ROUNDOFF;
use crate::vec3::Vec3;

/// A triangle of the fan, seen from the receiver.
#[derive(Debug)]
pub(super) struct Triangle {
    pub(super) apex: Vec3<f64>,
    pub(super) first: Vec3<f64>,
    pub(super) side: Vec3<f64>,
    /// `n1.r` at the corners.
    pub(super) facing: [f64; 3],
    /// Largest `n1.r`, and a bound on the error of it at the corners.
    pub(super) most_facing: f64,
    pub(super) facing_error: f64,
    pub(super) emission: OnTriangle,
    /// Whether that is known to be nowhere negative.
    pub(super) is_bright: bool,
    /// Signed, and a bound on its error.
    pub(super) twice_area: f64,
    pub(super) twice_area_error: f64,
    /// Bound on the error of a side, and on the area by which displaced corners change the domain.
    pub(super) side_error: f64,
    pub(super) misplaced_area: f64,
    pub(super) grid: [Grid; 2],
    pub(super) truncation: Bound,
    /// Bounds on the distance of its points from the receiver, and its longest side.
    pub(super) nearest: f64,
    pub(super) farthest: f64,
    pub(super) longest: f64,
}

/// Bounds on the errors of value and gradient.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Bound {
    pub(super) value: f64,
    pub(super) gradient: f64,
}

/// A composite rule for one variable: equal panels with the same number of nodes.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Grid {
    pub(super) panels: usize,
    pub(super) count: usize,
}

impl Grid {
    pub(super) const fn nodes(self) -> usize {
        self.panels * self.count
    }
}

impl Triangle {
    pub(super) const fn nodes(&self) -> usize {
        self.grid[0].nodes() * self.grid[1].nodes()
    }
}

/// What bounds the integrand on a triangle.
struct Reach {
    /// Lower bound of the distance of the centroid less that of the corners from it.
    clear: f64,
    farthest: f64,
    most_facing: f64,
    area: f64,
    /// What value and gradient are expected to be like, by size.
    typical: Bound,
}

impl Scene<'_> {
    /// The triangle with the number of nodes it needs for full precision, of an outline with local offsets up to `spread`; `None` if that is more than there are rules for.
    pub(super) fn triangle(&self, corners: [Corner; 3], spread: f64, twice_area: Option<f64>) -> Option<Triangle> {
        let [a, b, c] = &corners;
        let [first, last, side] = [self.side(a, b), self.side(a, c), self.side(b, c)];
        let lengths = [first, last, side].map(|e| e.norm_squared().sqrt());
        let longest = lengths[0].max(lengths[1]).max(lengths[2]);
        // Two local offsets and their difference; a share of it is the displacement of crossings as seen from the receiver.
        let side_error = if self.is_clipped { 60.0 * ROUNDOFF * spread } else { ROUNDOFF * longest };
        // The area would lose digits to underflow.
        if longest < 1e-130 {
            return None;
        }
        let (twice_area, twice_area_error) = if let Some(twice_area) = twice_area {
            (twice_area, 4.0 * ROUNDOFF * twice_area)
        } else {
            let rounding = side_error * (lengths[0] + lengths[1]) + 12.0 * ROUNDOFF * lengths[0] * lengths[1];
            (self.n2.dot(first.cross(last)), rounding)
        };
        let centroid = (a.seen + b.seen + c.seen) * (1.0 / 3.0);
        let distance = centroid.norm_squared().sqrt() * (1.0 - 32.0 * ROUNDOFF);
        let reach = corners.map(|corner| (corner.seen - centroid).norm_squared().sqrt());
        let reach = reach[0].max(reach[1]).max(reach[2]) + 32.0 * ROUNDOFF * distance;
        let (nearest, farthest) = (self.height.max(distance - reach), distance + reach);
        let most_facing = a.facing.max(b.facing).max(c.facing);
        let area = twice_area.abs();
        // Slivers along the horizon are worth fewer than nine digits less than their area says.
        let facing = ((a.facing + b.facing + c.facing) / 3.0).max(1e-9 * farthest) / farthest;
        let typical = 0.5 * area * self.source.largest * self.height / (farthest * farthest * farthest);
        let typical = Bound { value: typical * facing, gradient: typical / farthest };
        let bounds = Reach { clear: distance - reach, farthest, most_facing, area, typical };
        // The Jacobian a is at most 1 + (A - 1)/2p in its own variable on p panels, and 1/2 on average in the other.
        let along = self.grid(&bounds, 0.5 * lengths[0].max(lengths[1]), |overhang| 1.0 + overhang)?;
        let across = self.grid(&bounds, 0.5 * lengths[2], |_| 0.5)?;
        Some(Triangle {
            apex: a.seen,
            first,
            side,
            facing: [a.facing, b.facing, c.facing],
            most_facing,
            facing_error: a.facing_error.max(b.facing_error).max(c.facing_error),
            emission: self.source.on_triangle([&a.lit, &b.lit, &c.lit]),
            is_bright: corners.iter().all(|corner| corner.lit.is_bright()),
            twice_area,
            twice_area_error,
            side_error,
            misplaced_area: if self.is_clipped { 70.0 * ROUNDOFF * spread * longest } else { 0.0 },
            grid: [along.0, across.0],
            truncation: Bound { value: along.1.value + across.1.value, gradient: along.1.gradient + across.1.gradient },
            nearest,
            farthest,
            longest,
        })
    }

    /// The cheapest grid for one variable, and the bound on what it leaves.
    fn grid(&self, reach: &Reach, half: f64, jacobian: impl Fn(f64) -> f64) -> Option<(Grid, Bound)> {
        /// So few nodes are never half as many on half the length.
        const FEW: usize = 6;
        let mut best: Option<(Grid, Bound)> = None;
        for panels in [1, 2, 4, 8] {
            let share = 1.0 / panels as f64;
            let overhang = |stretch: f64| jacobian(0.5 * (stretch - 1.0) * share);
            let Some((count, bound)) = self.nodes(reach, half * share, overhang) else { continue };
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
    fn nodes(&self, reach: &Reach, half: f64, jacobian: impl Fn(f64) -> f64) -> Option<(usize, Bound)> {
        /// Share of the way to the nearest singularity; above it M grows faster than the ellipse helps.
        const SHARE: f64 = 0.75;
        let Self { height, ref source, .. } = *self;
        let tau = (SHARE * height / half).max(0.5 * SHARE * reach.clear / half);
        let stretch = (tau * tau + 1.0).sqrt();
        let ratio = stretch + tau;
        let distance = height.max(reach.clear - (stretch - 1.0) * half) * (1.0 - 8.0 * ROUNDOFF);
        let q = distance * distance - tau * tau * half * half;
        if q <= 0.0 || q.is_nan() {
            return None;
        }
        let grown = (ratio - 1.0) * half;
        let (far, facing) = (reach.farthest + grown, reach.most_facing + grown);
        let emission = source.largest * source.growth(stretch, ratio);
        let shrink = 1.0 / (ratio * ratio);
        // What shrinks and what grows first: far away neither may meet the area alone, and underflow.
        let common = 8.0 / 3.0 * 1.01 * (shrink * jacobian(stretch) * emission) * reach.area / (q * q * (1.0 - shrink));
        let mut bound =
            Bound { value: common * height * facing, gradient: common * (facing + height + 4.0 * height * facing * far / q) };
        // A quarter of a roundoff of what is expected is not worth another node.
        let enough = Bound { value: 0.25 * ROUNDOFF * reach.typical.value, gradient: 0.25 * ROUNDOFF * reach.typical.gradient };
        for count in 1..=rules::MOST {
            if bound.value <= enough.value && bound.gradient <= enough.gradient {
                return Some((count, bound));
            }
            bound.value *= shrink;
            bound.gradient *= shrink;
        }
        None
    }
}
