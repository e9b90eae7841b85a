//! Integrals of powers along one piece of the visible boundary: closed forms by recursion in the power.
//!
//! A piece lies on a line of the emitter's plane at distance S from x, s is the coordinate along it from the point nearest to
//! x, and `r^2 = S^2 + s^2`; psi with `s = S tan psi` is the arc's angle in its own plane, g its extent.
//! - `L_k = int s^k / r^2 ds`: `L_0 = g/S`, `L_1 = ln(|v|/|u|)`, and since `s^k = s^(k-2) (r^2 - S^2)`,
//!   `L_k = [s^(k-1)]/(k-1) - S^2 L_(k-2)`.
//! - `P_k = int S^2 s^k / r^4 ds`: with the arc's moments `P_0 = cc/S`, `P_1 = cs`, `P_2 = S ss`, then
//!   `P_k = S^2 (L_(k-2) - P_(k-2))`.
//!
//! Each second step subtracts numbers `(S/s)^2` times the result: digits are lost where the piece is seen under a small angle
//! around the line's nearest point, none where s is of the size of S or above.

use radgrad_numbers::real::Real;

use crate::boundary::arc::{Arc, Moments};
use crate::boundary::line::Frame;
use crate::problem::polynomial::bivariate::{Bivariate, whole};

/// A piece of the visible boundary with its integrals `L_k`.
#[derive(Debug, Clone)]
pub(in crate::forms) struct Segment<T> {
    frame: Frame<T>,
    /// `L_k`.
    over_square: Vec<T>,
}

impl<T: Real> Segment<T> {
    /// With `L_k` up to `k = degree`, which is at least 1.
    pub(in crate::forms) fn new(arc: &Arc<T>, frame: Frame<T>, degree: usize) -> Self {
        let distance = frame.distance;
        let [start, end] = [&arc.start, &arc.end].map(|end| end.point.dot(frame.along));
        let length = (arc.end.point - arc.start.point).dot(frame.along);
        let square = distance * distance;
        let log_ratio = (arc.end.square / arc.start.square).ln() * T::exact(0.5);
        let mut over_square = Vec::with_capacity(degree + 1);
        over_square.extend([arc.angle / distance, log_ratio]);
        // s_2^m - s_1^m = (s_2 - s_1) q_m with q_m = s_2 q_(m-1) + s_1^(m-1).
        let (mut quotient, mut power) = (T::exact(1.0), start);
        for k in 2..=degree {
            over_square.push(length * quotient / whole(k - 1) - square * over_square[k - 2]);
            quotient = end * quotient + power;
            power = power * start;
        }
        Self { frame, over_square }
    }

    pub(in crate::forms) const fn frame(&self) -> &Frame<T> {
        &self.frame
    }

    /// `L_k`.
    pub(in crate::forms) fn over_square(&self) -> &[T] {
        &self.over_square
    }

    /// `[P_k, P_(k+1)/S, P_(k+2)/S^2]` for k up to the degree: the integrals of `s^k` with `cos^2`, `cos sin` and `sin^2` of
    /// psi, over S.
    pub(in crate::forms) fn over_fourth(&self, m: &Moments<T>) -> Vec<[T; 3]> {
        let distance = self.frame.distance;
        let l = &self.over_square;
        let mut p = vec![m.cc / distance, m.cs];
        for k in 2..l.len() {
            p.push(if k == 2 { distance * m.ss } else { distance * distance * (l[k - 2] - p[k - 2]) });
        }
        let step = |k: usize| match k {
            0 => [p[0], m.cs / distance, m.ss / distance],
            1 => [p[1], m.ss, l[1] - p[1]],
            _ => [p[k], distance * (l[k - 1] - p[k - 1]), l[k] - p[k]],
        };
        (0..l.len()).map(step).collect()
    }
}

/// The integrals of `u^i v^j w(s)`, `i + j <= degree`, from those of `s^k w(s)` along a line, `k <= degree`:
/// `(u, v) = foot + s along`.
pub(in crate::forms) fn on_line<T: Real>(mut powers: Vec<T>, foot: [T; 2], along: [T; 2]) -> Bivariate<T> {
    let degree = powers.len() - 1;
    let mut table = Bivariate::zero(degree);
    for j in 0..=degree {
        let mut row = powers.clone();
        for i in 0..=degree - j {
            *table.coefficient_mut(i, j) = row[0];
            times_coordinate(&mut row, foot[0], along[0]);
        }
        times_coordinate(&mut powers, foot[1], along[1]);
    }
    table
}

/// Integrals of `s^k (foot + s along) w` from those of `s^k w`: one fewer.
fn times_coordinate<T: Real>(powers: &mut Vec<T>, foot: T, along: T) {
    for k in 1..powers.len() {
        powers[k - 1] = powers[k - 1] * foot + powers[k] * along;
    }
    powers.pop();
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::boundary::line::{Line, Sighted};
    use glam::DVec3;

    /// Composite Gauss-Legendre rule of five nodes on 400 panels.
    fn integral(from: f64, to: f64, f: impl Fn(f64) -> f64) -> f64 {
        let rule = [
            (0.0, 128.0 / 225.0),
            (0.538_469_310_105_683_1, 0.478_628_670_499_366_47),
            (0.906_179_845_938_664, 0.236_926_885_056_189_08),
        ];
        let half = (to - from) / 800.0;
        let panel = |i: i32| from + half * f64::from(2 * i + 1);
        let on_panel = |middle: f64| -> f64 {
            rule.iter()
                .map(|&(t, w)| w * half * if t == 0.0 { f(middle) } else { f(middle - t * half) + f(middle + t * half) })
                .sum()
        };
        (0..400).map(|i| on_panel(panel(i))).sum()
    }

    #[test]
    fn the_recursions_give_the_integrals() {
        let (from, to) = (DVec3::new(-0.4, 0.3, 0.5), DVec3::new(0.9, 0.3, 0.5));
        let [start, end] = [from, to].map(|point| Sighted::from(point, DVec3::ZERO, 1.0));
        let line = Line::<f64>::through([from, to], [&start, &end], DVec3::ZERO, 1.0);
        let arc = Arc::of_edge(start, end, 1.0, line);
        let frame = line.frame();
        let segment = Segment::new(&arc, frame, 6);
        let square = frame.distance * frame.distance;
        let fourth = segment.over_fourth(&arc.moments(&frame));
        let mut s_to: Vec<fn(f64) -> f64> = vec![|_| 1.0, |s| s, |s| s * s, |s| s * s * s, |s| s * s * s * s];
        s_to.extend([(|s| s * s * s * s * s) as fn(f64) -> f64, |s| s * s * s * s * s * s]);
        for (k, power) in s_to.iter().enumerate() {
            let l = integral(-0.4, 0.9, |s| power(s) / (square + s * s));
            assert!((segment.over_square()[k] - l).abs() < 2e-15, "L_{k}");
            for (shift, divisor) in [1.0, frame.distance, square].into_iter().enumerate() {
                let weight = |s: f64| (0..shift).map(|_| s).product::<f64>() * square / divisor;
                let p = integral(-0.4, 0.9, |s| power(s) * weight(s) / ((square + s * s) * (square + s * s)));
                assert!((fourth[k][shift] - p).abs() < 4e-15, "P_{k}, {shift}: {} {p}", fourth[k][shift]);
            }
        }
    }

    #[test]
    fn a_table_on_a_line_holds_the_powers_of_its_points() {
        // All weight at s = 2, the point (1, -1) + 2 (0.5, 3) = (2, 5).
        let table = on_line(vec![1.0, 2.0, 4.0, 8.0], [1.0, -1.0], [0.5, 3.0]);
        for (i, j, expected) in [(0, 0, 1.0), (1, 0, 2.0), (0, 1, 5.0), (2, 1, 20.0), (1, 2, 50.0), (0, 3, 125.0)] {
            assert_eq!(table.coefficient(i, j), expected);
        }
    }
}
