//! The integrals over one fan and along one edge, in ball arithmetic.
//!
//! On a line t = const, `r = q + s c`: `r.r = q.q + s (2 q.c + s c.c)`, `n1.r` is affine in s and the emission a polynomial in
//! s, so there the product rule is a sum of the moments `T_k = sum w s^k J(s) / (r.r)^2` times coefficients that do not depend
//! on s. Each line starts at its nearest point: `q.c >= 0`, nothing cancels in `r.r`.

use std::sync::Arc;

use crate::enclosure::arithmetic::Real;
use crate::enclosure::ball::{Ball, BallVector, along, dot};
use crate::enclosure::cell::Cell;
use crate::enclosure::legendre::Rule;
use crate::enclosure::source::Expansion;
use crate::enclosure::surface::{Fan, Jacobian};

/// `int (n1.r)/|r|^4 (...)` with B, the components of grad B, and `grad B . r` in place of the dots.
#[derive(Debug)]
pub(crate) struct Moments<T> {
    pub(crate) emission: Ball<T>,
    pub(crate) gradient: BallVector<T>,
    pub(crate) directional: Ball<T>,
}

impl<T: Real> Moments<T> {
    fn zero(like: &Ball<T>) -> Self {
        let zero = like.zero();
        Self { emission: zero.clone(), gradient: [zero.clone(), zero.clone(), zero.clone()], directional: zero }
    }

    /// Adds `weight other`, of which nothing but the emission counts where that is constant.
    fn add(&mut self, weight: &Ball<T>, other: &Self, is_constant: bool) {
        self.emission = &self.emission + &(weight * &other.emission);
        if is_constant {
            return;
        }
        self.directional = &self.directional + &(weight * &other.directional);
        for axis in 0..3 {
            self.gradient[axis] = &self.gradient[axis] + &(weight * &other.gradient[axis]);
        }
    }
}

/// A rule mapped to `[low, high]`: nodes, and weights times the Jacobian and powers of the nodes.
struct Mapped<T> {
    nodes: Vec<Ball<T>>,
    /// `powers[k][i] = w_i J(s_i) s_i^k`.
    powers: Vec<Vec<Ball<T>>>,
}

fn mapped<T: Real>([low, high]: [f64; 2], count: usize, jacobian: Jacobian, powers: usize, bits: usize) -> Mapped<T> {
    let rule: Arc<Rule<T>> = T::rules().get(count, bits);
    let half = Ball::from_f64(0.5, bits);
    let (low, high) = (Ball::from_f64(low, bits), Ball::from_f64(high, bits));
    let (centre, radius) = (&half * &(&low + &high), &half * &(&high - &low));
    let nodes: Vec<Ball<T>> = rule.nodes.iter().map(|x| &centre + &(&radius * x)).collect();
    let times = |values: &[Ball<T>]| -> Vec<Ball<T>> { values.iter().zip(&nodes).map(|(v, s)| v * s).collect() };
    let mut weights: Vec<Ball<T>> = rule.weights.iter().map(|w| &radius * w).collect();
    let one = Ball::from_f64(1.0, bits);
    match jacobian {
        Jacobian::One => {}
        Jacobian::Rising => weights = times(&weights),
        Jacobian::Falling => {
            weights = weights.iter().zip(&nodes).map(|(w, s)| w * &(&one - s)).collect();
        }
    }
    let mut weighted = vec![weights];
    for k in 1..powers {
        let next = times(&weighted[k - 1]);
        weighted.push(next);
    }
    Mapped { nodes, powers: weighted }
}

/// `T_k` on a line `q + s c`.
fn line<T: Real>(apex_squared: &Ball<T>, twice: &Ball<T>, square: &Ball<T>, rule: &Mapped<T>) -> Vec<Ball<T>> {
    let mut sums = vec![apex_squared.zero(); rule.powers.len()];
    let one = Ball { middle: apex_squared.middle.one(), radius: 0.0 };
    for (i, s) in rule.nodes.iter().enumerate() {
        let distance = apex_squared + &(s * &(twice + &(s * square)));
        let inverse = one.divided_by(&(&distance * &distance));
        for (sum, powers) in sums.iter_mut().zip(&rule.powers) {
            *sum = &*sum + &(&powers[i] * &inverse);
        }
    }
    sums
}

/// The contribution of one line, from its moments.
fn contribution<T: Real>(
    expansion: &Expansion<T>,
    apex: &BallVector<T>,
    direction: &BallVector<T>,
    heights: [&Ball<T>; 2],
    sums: &[Ball<T>],
) -> Moments<T> {
    let total = |terms: &mut dyn Iterator<Item = Ball<T>>| terms.fold(sums[0].zero(), |sum, term| &sum + &term);
    // Moments with n1.r.
    let lifted: Vec<Ball<T>> = sums.windows(2).map(|pair| &(heights[0] * &pair[0]) + &(heights[1] * &pair[1])).collect();
    let values = expansion.along(direction);
    let emission = total(&mut values.iter().zip(&lifted).map(|(b, u)| b * u));
    if expansion.degree == 0 {
        return Moments { emission, ..Moments::zero(&sums[0]) };
    }
    let gradient: BallVector<T> = std::array::from_fn(|axis| {
        total(&mut expansion.derivative_along(axis, direction).iter().zip(&lifted).map(|(g, u)| g * u))
    });
    // grad B . r = grad B . q + s grad B . c, and s grad B . c = sum k b_k s^k (Euler).
    let euler = total(&mut values.iter().zip(&lifted).enumerate().skip(1).map(|(k, (b, u))| (b * u).times_small(k)));
    Moments { emission, directional: &dot(&gradient, apex) + &euler, gradient }
}

/// The products that `r.r` is made of on the lines `q + s (c + t v)` of a fan whose rays leave one point q: on each the foot of
/// `c + t v` comes first, `c.v >= 0`, so that nothing cancels here either.
struct Squares<T> {
    /// `q.q`.
    apex: Ball<T>,
    /// `2 q.c` and `2 q.v`.
    across: [Ball<T>; 2],
    /// `c.c`, `2 c.v` and `v.v`.
    along: [Ball<T>; 3],
}

impl<T: Real> Squares<T> {
    fn of_fan(fan: &Fan<T>, two: &Ball<T>) -> Self {
        let Fan { apex, start, way, .. } = fan;
        let across = [two * &dot(apex, start), two * &dot(apex, way)];
        Self { apex: dot(apex, apex), across, along: [dot(start, start), two * &dot(start, way), dot(way, way)] }
    }

    /// `2 q.(c + t v)`.
    fn twice(&self, t: &Ball<T>) -> Ball<T> {
        &self.across[0] + &(t * &self.across[1])
    }

    /// `(c + t v).(c + t v)`.
    fn square(&self, t: &Ball<T>) -> Ball<T> {
        &self.along[0] + &(t * &(&self.along[1] + &(t * &self.along[2])))
    }
}

/// Over a fan, without its measure.
pub(crate) fn over_fan<T: Real>(fan: &Fan<T>, expansion: &Expansion<T>, cells: &[Cell], bits: usize) -> Moments<T> {
    let two = Ball::from_f64(2.0, bits);
    let mut integral = Moments::zero(&two);
    let squares = Squares::of_fan(fan, &two);
    for cell in cells {
        let radial = mapped(cell.s, cell.orders[0].count, fan.jacobian, expansion.degree + 2, bits);
        let transverse = mapped(cell.t, cell.orders[1].count, Jacobian::One, 1, bits);
        for (t, weight) in transverse.nodes.iter().zip(&transverse.powers[0]) {
            let direction = along(&fan.start, t, &fan.way);
            let rise = &fan.heights[1] + &(t * &fan.heights[2]);
            let part = match &fan.shift {
                None => {
                    let sums = line(&squares.apex, &squares.twice(t), &squares.square(t), &radial);
                    contribution(expansion, &fan.apex, &direction, [&fan.heights[0], &rise], &sums)
                }
                Some(shift) => {
                    let apex = along(&fan.apex, t, shift);
                    let height = &fan.heights[0] + &(t * &fan.heights[3]);
                    let twice = &two * &dot(&apex, &direction);
                    let sums = line(&dot(&apex, &apex), &twice, &dot(&direction, &direction), &radial);
                    contribution(&expansion.moved(&apex), &apex, &direction, [&height, &rise], &sums)
                }
            };
            integral.add(weight, &part, expansion.degree == 0);
        }
    }
    integral
}

/// `int_0^1 B (n1.r) / |r|^4 ds` along the ray `foot + s way`.
pub(crate) fn along_ray<T: Real>(
    foot: &BallVector<T>,
    way: &BallVector<T>,
    heights: [&Ball<T>; 2],
    expansion: &Expansion<T>,
    cells: &[Cell],
    bits: usize,
) -> Ball<T> {
    let (foot_squared, square) = (dot(foot, foot), dot(way, way));
    let twice = &Ball::from_f64(2.0, bits) * &dot(foot, way);
    let values = expansion.along(way);
    let mut integral = foot_squared.zero();
    for cell in cells {
        let rule = mapped(cell.s, cell.orders[0].count, Jacobian::One, expansion.degree + 2, bits);
        let sums = line(&foot_squared, &twice, &square, &rule);
        for (value, pair) in values.iter().zip(sums.windows(2)) {
            let lifted = &(heights[0] * &pair[0]) + &(heights[1] * &pair[1]);
            integral = &integral + &(value * &lifted);
        }
    }
    integral
}
