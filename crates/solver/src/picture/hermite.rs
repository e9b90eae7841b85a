//! Cubic patches through values and gradients at the corners of an element.
//!
//! On a parallelogram the bicubic Hermite patch, whose mixed derivatives at the corners are those of the serendipity cubic through
//! the same data (A. Adini and R. Clough 1961): it is exact for all cubics, and for `s^3 t` and `s t^3`. On a triangle the cubic
//! Hermite triangle (P. Ciarlet 1978), which needs the value at the centroid besides and is exact for all cubics; what does
//! without that value, as the triangle of Clough and Tocher with linear normal derivatives, is exact for quadratics only. Both err
//! by `O(h^4)` for elements of size h.
//!
//! Along an edge the patch is the cubic through the values and the slopes along it at its ends, and nothing else: neighbours that
//! share an edge and the samples at its ends meet without a gap.
//!
//! Values have any unit, slopes that unit per reference coordinate. Held as Bernstein coefficients, whose range is a bound.

use crate::mesh::shape::Shape;
use radgrad_scene::{largest, smallest};

/// A cubic over the reference shape.
///
/// ```
/// use radgrad_solver::{HermitePatch, Shape};
/// // s^3 + s t, from its values and slopes at the corners of the square:
/// let corners = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
/// let values = corners.map(|[s, t]: [f64; 2]| s.powi(3) + s * t);
/// let slopes = corners.map(|[s, t]: [f64; 2]| [3.0 * s * s + t, s]);
/// let patch = HermitePatch::on_parallelogram(values, slopes);
/// assert_eq!(patch.shape(), Shape::Parallelogram);
/// assert!((patch.value([0.5, 0.5]) - 0.375).abs() < 1e-15);
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct HermitePatch {
    shape: Shape,
    /// Of `B_i(s) B_j(t)`, j the faster; or of `s^i t^j (1-s-t)^(3-i-j)` with its multinomial, in the same order.
    control: Vec<f64>,
}

impl HermitePatch {
    /// The patch on the unit square, from values and derivatives along s and t at (0,0), (1,0), (1,1) and (0,1).
    #[must_use]
    pub fn on_parallelogram(values: [f64; 4], slopes: [[f64; 2]; 4]) -> Self {
        // By corner (i, j).
        let at = |i: usize, j: usize| [[0, 3], [1, 2]][i][j];
        let mixed = values[0] - values[1] + values[2] - values[3];
        let mut control = vec![0.0; 16];
        for (i, j) in [(0, 0), (1, 0), (1, 1), (0, 1)] {
            let (value, [along, across]) = (values[at(i, j)], slopes[at(i, j)]);
            let twist = slopes[at(i, 1)][0] - slopes[at(i, 0)][0] + slopes[at(1, j)][1] - slopes[at(0, j)][1] - mixed;
            // Steps from the corner inward.
            let (u, v) = (1.0 - 2.0 * i as f64, 1.0 - 2.0 * j as f64);
            for (a, b) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
                let (k, l) = (if i == 0 { a } else { 3 - a }, if j == 0 { b } else { 3 - b });
                let (p, q) = (u * a as f64 / 3.0, v * b as f64 / 3.0);
                control[4 * k + l] = value + p * along + q * across + p * q * twist;
            }
        }
        Self { shape: Shape::Parallelogram, control }
    }

    /// The patch on the triangle (0,0), (1,0), (0,1), from values and derivatives along s and t at these corners, and the value
    /// at the centroid.
    #[must_use]
    pub fn on_triangle(values: [f64; 3], slopes: [[f64; 2]; 3], middle: f64) -> Self {
        const CORNERS: [[f64; 2]; 3] = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]];
        let mut control = vec![0.0; 10];
        let place = |from: usize, to: usize| {
            let mut powers = [0; 3];
            powers[from] += 2;
            powers[to] += 1;
            of_triangle(powers[1], powers[2])
        };
        for from in 0..3 {
            for to in 0..3 {
                let step = [0, 1].map(|k| (CORNERS[to][k] - CORNERS[from][k]) / 3.0);
                control[place(from, to)] = values[from] + slopes[from][0] * step[0] + slopes[from][1] * step[1];
            }
        }
        let corners: f64 = values.iter().sum();
        let edges: f64 = [(0, 1), (0, 2), (1, 0), (1, 2), (2, 0), (2, 1)].iter().map(|&(i, j)| control[place(i, j)]).sum();
        control[of_triangle(1, 1)] = (27.0 * middle - corners - 3.0 * edges) / 6.0;
        Self { shape: Shape::Triangle, control }
    }

    /// The shape it is on.
    #[must_use]
    pub const fn shape(&self) -> Shape {
        self.shape
    }

    /// The value at a point.
    #[must_use]
    pub fn value(&self, [s, t]: [f64; 2]) -> f64 {
        self.sum(bernstein(s), bernstein(t), |[i, j, k]| [power(s, i), power(t, j), power(1.0 - s - t, k)])
    }

    /// The derivatives along s and t at a point.
    #[must_use]
    pub fn slopes(&self, [s, t]: [f64; 2]) -> [f64; 2] {
        let r = 1.0 - s - t;
        // d/ds of r^k is that of a factor of its own.
        let along = self.sum(slope(s), bernstein(t), |[i, j, k]| [derived(s, i), power(t, j), power(r, k)]);
        let across = self.sum(bernstein(s), slope(t), |[i, j, k]| [power(s, i), derived(t, j), power(r, k)]);
        let inward = match self.shape {
            Shape::Parallelogram => 0.0,
            Shape::Triangle => self.sum([0.0; 4], [0.0; 4], |[i, j, k]| [power(s, i), power(t, j), derived(r, k)]),
        };
        [along - inward, across - inward]
    }

    /// Least and largest value over the element, or beyond them.
    #[must_use]
    pub fn range(&self) -> [f64; 2] {
        self.control.iter().fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], &c| [smallest(low, c), largest(high, c)])
    }

    fn sum(&self, along: [f64; 4], across: [f64; 4], factors: impl Fn([usize; 3]) -> [f64; 3]) -> f64 {
        match self.shape {
            Shape::Parallelogram => {
                let row = |i: usize| (0..4).map(|j| self.control[4 * i + j] * across[j]).sum::<f64>();
                (0..4).map(|i| along[i] * row(i)).sum()
            }
            Shape::Triangle => {
                const FACTORIAL: [f64; 4] = [1.0, 1.0, 2.0, 6.0];
                let all = (0..4).flat_map(|i| (0..4 - i).map(move |j| [i, j, 3 - i - j]));
                let term = |powers: [usize; 3]| {
                    let multinomial = 6.0 / powers.map(|p| FACTORIAL[p]).iter().product::<f64>();
                    let [a, b, c] = factors(powers);
                    self.control[of_triangle(powers[0], powers[1])] * multinomial * a * b * c
                };
                all.map(term).sum()
            }
        }
    }
}

/// Place of the coefficient of `s^i t^j` on a triangle.
const fn of_triangle(i: usize, j: usize) -> usize {
    [0, 4, 7, 9][i] + j
}

fn bernstein(t: f64) -> [f64; 4] {
    let u = 1.0 - t;
    [u * u * u, 3.0 * u * u * t, 3.0 * u * t * t, t * t * t]
}

fn slope(t: f64) -> [f64; 4] {
    let u = 1.0 - t;
    let [a, b, c] = [3.0 * u * u, 6.0 * u * t, 3.0 * t * t];
    [-a, a - b, b - c, c]
}

fn power(x: f64, n: usize) -> f64 {
    std::iter::repeat_n(x, n).product()
}

fn derived(x: f64, n: usize) -> f64 {
    n.checked_sub(1).map_or(0.0, |lower| n as f64 * power(x, lower))
}

#[cfg(test)]
mod tests {
    use super::*;

    const SQUARE: [[f64; 2]; 4] = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];

    fn monomial(i: i32, j: i32) -> impl Fn([f64; 2]) -> f64 {
        move |[s, t]: [f64; 2]| s.powi(i) * t.powi(j)
    }

    fn derivatives(i: i32, j: i32) -> impl Fn([f64; 2]) -> [f64; 2] {
        let raised = |x: f64, n: i32| if n < 0 { 0.0 } else { x.powi(n) };
        move |[s, t]: [f64; 2]| [f64::from(i) * raised(s, i - 1) * t.powi(j), f64::from(j) * s.powi(i) * raised(t, j - 1)]
    }

    fn patches(i: i32, j: i32) -> [HermitePatch; 2] {
        let (value, slopes) = (monomial(i, j), derivatives(i, j));
        let corners = [SQUARE[0], SQUARE[1], SQUARE[3]];
        [
            HermitePatch::on_parallelogram(SQUARE.map(&value), SQUARE.map(&slopes)),
            HermitePatch::on_triangle(corners.map(&value), corners.map(&slopes), value([1.0 / 3.0; 2])),
        ]
    }

    #[test]
    fn patches_are_exact_for_cubics_and_not_beyond() {
        let inside = [[0.2, 0.3], [0.05, 0.9], [0.61, 0.13]];
        for (i, j) in (0..=4).flat_map(|i| (0..=4 - i).map(move |j| (i, j))) {
            let (value, slopes) = (monomial(i, j), derivatives(i, j));
            for (patch, reach) in patches(i, j).iter().zip([i + j <= 3 || i * j == 3, i + j <= 3]) {
                let off = |at: [f64; 2]| {
                    let [found, exact] = [patch.slopes(at), slopes(at)];
                    (patch.value(at) - value(at)).abs() + (found[0] - exact[0]).abs() + (found[1] - exact[1]).abs()
                };
                let worst = inside.map(off).into_iter().fold(0.0, largest);
                assert_eq!(worst < 1e-13, reach, "{i} {j} {:?}: {worst:e}", patch.shape());
            }
        }
    }

    #[test]
    fn an_edge_depends_on_what_is_along_it_alone() {
        let (values, mut slopes) = ([1.0, 2.0, -1.0, 0.5], [[1.0, -2.0], [0.5, 3.0], [2.0, 1.0], [-1.0, 0.3]]);
        let patch = |slopes| HermitePatch::on_parallelogram(values, slopes);
        let before = patch(slopes);
        slopes.iter_mut().for_each(|s| s[1] += 5.0);
        let after = patch(slopes);
        for s in [0.1, 0.4, 0.9] {
            assert!((before.value([s, 0.0]) - after.value([s, 0.0])).abs() < 1e-15);
            assert!((before.value([s, 0.5]) - after.value([s, 0.5])).abs() < 10.0, "inside it may change");
            let [low, high] = before.range();
            assert!((low..=high).contains(&before.value([s, 0.3])));
        }
        let of_corners = |middle| HermitePatch::on_triangle([1.0, 2.0, -1.0], [[1.0, 0.0], [0.0, 2.0], [3.0, -1.0]], middle);
        for s in [0.0, 0.3, 1.0] {
            assert!((of_corners(0.0).value([s, 1.0 - s]) - of_corners(9.0).value([s, 1.0 - s])).abs() < 1e-14);
        }
    }
}
