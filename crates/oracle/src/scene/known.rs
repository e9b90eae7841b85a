//! Scenes whose radiosity is known otherwise than by walks.
//!
//! - *A furnace*: in a closed scene where every face emits `1 - rho`, `B = 1` everywhere, whatever stands in it, since then
//!   `1 = (1 - rho) + rho G 1` wherever no ray ends on a back. [`furnace_emission`] is the emission of a face.
//! - *Two rectangles that face each other* ([`FacingRectangles`]): nothing hides, and the kernel `gap^2 / (pi r^4)` is analytic, so
//!   that Nystrom's method with Gauss rules on panels no wider than the gap converges geometrically (K. Atkinson, The Numerical
//!   Solution of Integral Equations of the Second Kind, 1997, chapter 4). The answer is that of [`FINE`] nodes a panel and side,
//!   the half-width ten times its difference from that of [`COARSE`] nodes, plus rounding: converged, not proven.
//! - *A manufactured solution* on them: for any `B` chosen, `E = B - rho G B` ([`FacingRectangles::manufactured`]).

use std::f64::consts::PI;

use glam::DVec3;
use radgrad_core::Polygon;

use super::Known;
use crate::confidence::ConfidenceInterval;

/// The emission of a face of reflectance `rho` in a furnace of radiosity 1.
#[must_use]
pub const fn furnace_emission(rho: f64) -> f64 {
    1.0 - rho
}

/// Nodes a panel and side.
pub const FINE: usize = 14;

/// Nodes of the rule that says how far the other one is off.
pub const COARSE: usize = 10;

/// Bound on the rounding, relative to the largest radiosity.
const ROUNDING: f64 = 1e-13;

/// Two rectangles with sides along the axes x and y: one in the plane z = 0 that faces up, one in z = gap that faces down.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FacingRectangles {
    /// `[x, y]` of each one's lowest corner.
    pub low: [[f64; 2]; 2],
    /// `[x, y]` of each one's highest corner.
    pub high: [[f64; 2]; 2],
    /// Their distance.
    pub gap: f64,
    /// Reflectances.
    pub reflectance: [f64; 2],
    /// Emitted radiosities.
    pub emitted: [f64; 2],
}

/// Radiosity at the nodes of both rectangles.
#[derive(Debug, Clone)]
struct Nodes {
    /// Position and weight, of each rectangle.
    rule: [Vec<[f64; 3]>; 2],
    values: [Vec<f64>; 2],
}

impl FacingRectangles {
    /// The rectangles as polygons.
    ///
    /// # Errors
    /// If one has no area.
    pub fn polygons(&self) -> Result<[Polygon; 2], radgrad_core::Error> {
        let corners = |which: usize, z: f64| {
            let ([a, b], [c, d]) = (self.low[which], self.high[which]);
            [[a, b, z], [c, b, z], [c, d, z], [a, d, z]].map(DVec3::from).to_vec()
        };
        let upper = corners(1, self.gap).into_iter().rev().collect();
        Ok([Polygon::new(corners(0, 0.0))?, Polygon::new(upper)?])
    }

    /// Mean of `B - E` over both, and `B` at points: each the index of the rectangle and `[x, y]`.
    #[must_use]
    pub fn truth(&self, points: &[(usize, [f64; 2])]) -> (Known, Vec<Known>) {
        let [fine, coarse] = [FINE, COARSE].map(|count| self.solve(count));
        let between_orders = |quantity: &dyn Fn(&Nodes) -> f64| {
            let [value, other] = [quantity(&fine), quantity(&coarse)];
            let largest = fine.values.iter().flatten().copied().fold(0.0, f64::max);
            let half = 10.0 * (value - other).abs() + ROUNDING * largest;
            Known { value, interval: ConfidenceInterval { low: value - half, high: value + half } }
        };
        let mean = between_orders(&|nodes| self.mean_reflected(nodes));
        (mean, points.iter().map(|&(which, at)| between_orders(&|nodes| self.radiosity(nodes, which, at))).collect())
    }

    /// The gradients of the irradiance `G B` along x and y, at points as [`Self::truth`] takes them.
    #[must_use]
    pub fn slopes(&self, points: &[(usize, [f64; 2])]) -> Vec<[f64; 2]> {
        let nodes = self.solve(FINE);
        points.iter().map(|&(which, at)| self.slope(&nodes, which, at)).collect()
    }

    fn slope(&self, nodes: &Nodes, which: usize, [x, y]: [f64; 2]) -> [f64; 2] {
        let other = 1 - which;
        let mut slope = [0.0; 2];
        for ([u, v, weight], radiosity) in nodes.rule[other].iter().zip(&nodes.values[other]) {
            let square = (x - u) * (x - u) + (y - v) * (y - v) + self.gap * self.gap;
            let part = -4.0 * weight * radiosity * self.kernel([x, y], [*u, *v]) / square;
            slope[0] += part * (x - u);
            slope[1] += part * (y - v);
        }
        slope
    }

    /// `E = B - rho G B` at a point, for a radiosity that is chosen as a function of the rectangle and of `[x, y]`.
    pub fn manufactured(&self, which: usize, at: [f64; 2], radiosity: impl Fn(usize, [f64; 2]) -> f64) -> f64 {
        let other = 1 - which;
        let gathered: f64 = self
            .rule(other, FINE)
            .iter()
            .map(|&[x, y, weight]| weight * self.kernel(at, [x, y]) * radiosity(other, [x, y]))
            .sum();
        radiosity(which, at) - self.reflectance[which] * gathered
    }

    fn rule(&self, which: usize, count: usize) -> Vec<[f64; 3]> {
        let along = |axis: usize| {
            let (low, high) = (self.low[which][axis], self.high[which][axis]);
            let mut panels = 1_u32;
            while (high - low) / f64::from(panels) > self.gap {
                panels += 1;
            }
            let half = 0.5 * (high - low) / f64::from(panels);
            let mut nodes = Vec::new();
            for panel in 0..panels {
                let middle = low + half * f64::from(2 * panel + 1);
                nodes.extend(gauss(count).into_iter().map(|[t, weight]| [middle + half * t, half * weight]));
            }
            nodes
        };
        let columns = along(0);
        let rows = along(1);
        rows.iter().flat_map(|[y, v]| columns.iter().map(move |[x, w]| [*x, *y, v * w])).collect()
    }

    fn kernel(&self, [x, y]: [f64; 2], [u, v]: [f64; 2]) -> f64 {
        let square = (x - u) * (x - u) + (y - v) * (y - v) + self.gap * self.gap;
        self.gap * self.gap / (PI * square * square)
    }

    fn solve(&self, count: usize) -> Nodes {
        let rule = [0, 1].map(|which| self.rule(which, count));
        let values = [0, 1].map(|which| vec![self.emitted[which]; rule[which].len()]);
        let mut nodes = Nodes { rule, values };
        let matrix: Vec<f64> =
            nodes.rule[0].iter().flat_map(|a| nodes.rule[1].iter().map(|b| self.kernel([a[0], a[1]], [b[0], b[1]]))).collect();
        let columns = nodes.rule[1].len();
        loop {
            let before = nodes.values.clone();
            let [first, second] = &mut nodes.values;
            for (i, value) in first.iter_mut().enumerate() {
                let row = &matrix[i * columns..(i + 1) * columns];
                let gathered: f64 = row.iter().zip(&nodes.rule[1]).zip(&*second).map(|((k, [_, _, w]), b)| k * w * b).sum();
                *value = self.emitted[0] + self.reflectance[0] * gathered;
            }
            let mut gathered = vec![0.0; columns];
            for ((i, [_, _, w]), b) in nodes.rule[0].iter().enumerate().zip(&*first) {
                gathered.iter_mut().zip(&matrix[i * columns..]).for_each(|(sum, k)| *sum += k * w * b);
            }
            second.iter_mut().zip(gathered).for_each(|(value, sum)| *value = self.emitted[1] + self.reflectance[1] * sum);
            let moved = nodes.values.iter().flatten().zip(before.iter().flatten()).map(|(a, b)| (a - b).abs());
            if moved.fold(0.0, f64::max) <= 1e-15 * nodes.values.iter().flatten().copied().fold(0.0, f64::max) {
                return nodes;
            }
        }
    }

    fn radiosity(&self, nodes: &Nodes, which: usize, at: [f64; 2]) -> f64 {
        let other = 1 - which;
        let gathered = nodes.rule[other].iter().zip(&nodes.values[other]).map(|([x, y, w], b)| w * self.kernel(at, [*x, *y]) * b);
        self.emitted[which] + self.reflectance[which] * gathered.sum::<f64>()
    }

    fn mean_reflected(&self, nodes: &Nodes) -> f64 {
        let (mut sum, mut area) = (0.0, 0.0);
        for which in [0, 1] {
            for ([_, _, w], b) in nodes.rule[which].iter().zip(&nodes.values[which]) {
                sum += w * (b - self.emitted[which]);
                area += w;
            }
        }
        sum / area
    }
}

/// Nodes and weights of the Gauss-Legendre rule on [-1, 1], by Newton's method on Legendre's polynomial.
fn gauss(count: usize) -> Vec<[f64; 2]> {
    let degree = count as f64;
    (0..count)
        .map(|i| {
            let mut x = libm::cos(PI * (i as f64 + 0.75) / (degree + 0.5));
            let mut slope = 1.0;
            for _ in 0..100 {
                let (mut before, mut value) = (0.0, 1.0);
                for k in 0..count {
                    let k = k as f64;
                    (before, value) = (value, ((2.0 * k + 1.0) * x * value - k * before) / (k + 1.0));
                }
                slope = degree * (x * value - before) / (x * x - 1.0);
                let step = value / slope;
                x -= step;
                if step.abs() < 1e-16 {
                    break;
                }
            }
            [x, 2.0 / ((1.0 - x * x) * slope * slope)]
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_rule_is_exact_for_polynomials() {
        let rule = gauss(8);
        for power in 0..16 {
            let sum: f64 = rule.iter().map(|[x, w]| w * x.powi(power)).sum();
            let exact = if power % 2 == 0 { 2.0 / f64::from(power + 1) } else { 0.0 };
            assert!((sum - exact).abs() < 1e-14, "{power}: {sum}");
        }
    }

    #[test]
    fn unit_squares_have_the_published_radiosity() {
        let squares =
            FacingRectangles { low: [[0.0; 2]; 2], high: [[1.0; 2]; 2], gap: 1.0, reflectance: [0.5; 2], emitted: [1.0; 2] };
        let (_, points) = squares.truth(&[(0, [0.5, 0.5]), (1, [0.0, 1.0])]);
        for (point, exact) in points.iter().zip([1.133_303_564_992_420_8, 1.076_981_393_145_044_5]) {
            assert!(point.interval.contains(exact) && point.interval.width() < 1e-10, "{point:?} {exact}");
        }
    }
}
