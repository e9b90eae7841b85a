//! Gauss-Legendre rules with proven nodes and weights.
//!
//! The n roots of `P_n` are isolated by n sign changes, so each node comes with a proven radius. `P_n` is computed by its
//! recurrence `(k+1) P_{k+1} = (2k+1) x P_k - k P_{k-1}`. With `eta_k` the rounding error made in this equation, the error
//! `delta_k` of the result has the generating function `delta(z) = p(z) int_0^z eta(w) p(w) dw`, `p = (1 - 2 x z + z^2)^(-1/2)`;
//! as `|P_k| <= 1`, `p` is majorised by `1/(1-z)`, hence `|delta_n| <= n max |eta_k|` (argument of Johansson and Mezzarobba,
//! SIAM J. Sci. Comput. 40, 2018). Weights: `w = 2 (1 - x^2) / (n P_{n-1}(x))^2`.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, PoisonError};

use crate::enclosure::arithmetic::Real;
use crate::enclosure::astro::Astro;
use crate::enclosure::ball::Ball;
use crate::enclosure::exact::scaled;
use crate::enclosure::limbs::Limbs;

/// Nodes in (-1, 1), ascending, and their weights.
#[derive(Debug)]
pub(crate) struct Rule<T> {
    pub(crate) nodes: Vec<Ball<T>>,
    pub(crate) weights: Vec<Ball<T>>,
}

/// Rules by bits and number of nodes.
type Table<T> = BTreeMap<(usize, usize), Arc<Rule<T>>>;

/// The rules computed so far.
#[derive(Debug)]
pub(crate) struct Rules<T>(Mutex<Table<T>>);

impl<T: Real> Rules<T> {
    pub(crate) const fn new() -> Self {
        Self(Mutex::new(BTreeMap::new()))
    }

    /// The rule with `count` nodes for numbers of `bits` bits.
    pub(crate) fn get(&self, count: usize, bits: usize) -> Arc<Rule<T>> {
        let mut rules = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        Arc::clone(rules.entry((bits, count)).or_insert_with(|| Arc::new(rule(count, bits))))
    }
}

/// Bits beyond the working precision, for the rounding in the recurrence (`60 n^2` units) and its effect on the weights (`n^2`
/// more).
const GUARD: usize = 64;

fn rule<T: Real>(count: usize, bits: usize) -> Rule<T> {
    match bits.div_ceil(64) * 64 + GUARD {
        working @ ..=192 => made::<T, Limbs<3>>(count, bits, working),
        working @ ..=256 => made::<T, Limbs<4>>(count, bits, working),
        working @ ..=320 => made::<T, Limbs<5>>(count, bits, working),
        working @ ..=384 => made::<T, Limbs<6>>(count, bits, working),
        working @ ..=448 => made::<T, Limbs<7>>(count, bits, working),
        working @ ..=512 => made::<T, Limbs<8>>(count, bits, working),
        working => made::<T, Astro>(count, bits, working),
    }
}

/// The rule for numbers of `bits` bits, made of numbers W of `working` bits.
fn made<T: Real, W: Real>(count: usize, bits: usize, working: usize) -> Rule<T> {
    let half: Vec<(Ball<W>, Ball<W>)> = (0..count / 2).map(|i| node(count, i, working)).collect();
    let mut nodes = Vec::with_capacity(count);
    let mut weights = Vec::with_capacity(count);
    // Disjoint intervals with a sign change each, mirrored, are all n roots.
    let isolated = half.windows(2).all(|pair| (&pair[0].0 - &pair[1].0).leading() > pair[0].0.radius + pair[1].0.radius)
        && half.last().is_none_or(|(x, _)| x.leading() > x.radius);
    let doubt = if isolated { 0.0 } else { f64::INFINITY };
    for (x, w) in &half {
        nodes.push(-&converted(x, bits));
        weights.push(converted::<T, W>(w, bits).widened(doubt));
    }
    if count % 2 == 1 {
        let zero = Ball::<W>::from_f64(0.0, working);
        let (_, previous) = legendre(count, &zero.middle, working);
        let value = Ball { middle: previous, radius: recurrence_error(count, working) };
        nodes.push(Ball::from_f64(0.0, bits));
        weights.push(converted(&weight(count, &zero, &value, working), bits));
    }
    for (x, w) in half.iter().rev() {
        nodes.push(converted(x, bits));
        weights.push(converted::<T, W>(w, bits).widened(doubt));
    }
    Rule { nodes, weights }
}

fn converted<T: Real, W: Real>(ball: &Ball<W>, bits: usize) -> Ball<T> {
    Ball::from_exact(&ball.middle.to_exact(), bits).widened(ball.radius)
}

/// Root number `index` from 1 downward, and its weight.
fn node<W: Real>(count: usize, index: usize, bits: usize) -> (Ball<W>, Ball<W>) {
    let mut x = W::from_f64(start(count, index), bits);
    let mut correct = 40;
    while correct < bits {
        x = newton(count, &x, bits);
        correct *= 2;
    }
    let error = recurrence_error(count, bits);
    let mut radius = error;
    let opposite = |radius: f64| {
        let offset = W::from_f64(radius, bits);
        let [below, above] = [x.subtract(&offset).0, x.add(&offset).0].map(|y| legendre(count, &y, bits).0.leading());
        below.abs() > error && above.abs() > error && (below > 0.0) != (above > 0.0)
    };
    // |P_n'| is above 1 at every root, so a few steps suffice; if not, the infinite radius says so.
    while !opposite(radius) {
        radius *= 8.0;
        if radius > 1.0 {
            radius = f64::INFINITY;
            break;
        }
    }
    // x +- radius was rounded once, by four units at most.
    let x = Ball { middle: x, radius: radius + scaled(1.0, 3 - i32::try_from(bits).unwrap_or(i32::MAX)) };
    let (_, previous) = legendre(count, &x.middle, bits);
    // |P_{n-1}'| <= n^2 / 2 on [-1, 1].
    let slope = (count * count) as f64;
    let value = Ball { middle: previous, radius: error + slope * x.radius };
    let weight = weight(count, &x, &value, bits);
    (x, weight)
}

/// Tricomi's approximation, then Newton's method in double precision.
fn start(count: usize, index: usize) -> f64 {
    let n = count as f64;
    let mut x = libm::cos(std::f64::consts::PI * (index as f64 + 0.75) / (n + 0.5));
    for _ in 0..4 {
        let (mut previous, mut value) = (1.0, x);
        for k in 1..count {
            let k = k as f64;
            (previous, value) = (value, ((2.0 * k + 1.0) * x * value - k * previous) / (k + 1.0));
        }
        x -= value * (1.0 - x * x) / (n * (previous - x * value));
    }
    x
}

/// `x - P_n(x) / P_n'(x)`, with `(1 - x^2) P_n' = n (P_{n-1} - x P_n)`.
fn newton<W: Real>(count: usize, x: &W, bits: usize) -> W {
    let (value, previous) = legendre(count, x, bits);
    let one = W::from_f64(1.0, bits);
    let above = one.subtract(&x.multiply(x).0).0.multiply(&value).0;
    let below = previous.subtract(&x.multiply(&value).0).0.multiply(&W::from_f64(count as f64, bits)).0;
    x.subtract(&above.divide(&below).0).0
}

/// `P_n(x)` and `P_{n-1}(x)`.
fn legendre<W: Real>(count: usize, x: &W, bits: usize) -> (W, W) {
    let (mut previous, mut value) = (W::from_f64(1.0, bits), x.clone());
    for k in 1..count {
        let [k, twice, next] = [k as f64, (2 * k + 1) as f64, (k + 1) as f64].map(|v| W::from_f64(v, bits));
        let sum = x.multiply(&value).0.multiply(&twice).0.subtract(&previous.multiply(&k).0).0;
        (previous, value) = (value, sum.divide(&next).0);
    }
    (value, previous)
}

/// Bound on the error of [`legendre`]. With unit `e = 2^-bits` a product or difference errs by at most `4 e` of its result, a quotient
/// by `22 e` ([`Limbs`]; [`Astro`] by `e` each). All computed values are below 1.01, so one equation is off by at most `(4 (2 (2k+1) +
/// k + (3k+1)) + 22 (k+1)) 1.02 e <= 60 n e` (two roundings of the first product, one of the second, of the difference and of the
/// quotient times k+1), and the module's argument gives n times that.
fn recurrence_error(count: usize, bits: usize) -> f64 {
    scaled((60 * count * count + 60) as f64, -i32::try_from(bits).unwrap_or(i32::MAX))
}

/// `2 (1 - x^2) / (n P_{n-1})^2`.
fn weight<W: Real>(count: usize, x: &Ball<W>, previous: &Ball<W>, bits: usize) -> Ball<W> {
    let one = Ball::from_f64(1.0, bits);
    let root = &Ball::from_f64(count as f64, bits) * previous;
    let above = &Ball::from_f64(2.0, bits) * &(&one - &(x * x));
    above.divided_by(&(&root * &root))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::enclosure::double_double::DoubleDouble;

    /// Integrals of the even monomials up to the rule's degree, and the first it misses.
    fn integrates_its_degree<T: Real>(count: usize, bits: usize, widest: f64) {
        let rule = T::rules().get(count, bits);
        for power in 0..=2 * count {
            let mut sum = Ball::<T>::from_f64(0.0, bits);
            for (x, w) in rule.nodes.iter().zip(&rule.weights) {
                let term = (0..power).fold(w.clone(), |term, _| &term * x);
                sum = &sum + &term;
            }
            let truth = if power % 2 == 1 { 0.0 } else { 2.0 / (power as f64 + 1.0) };
            let exact = Ball::<T>::from_f64(if power % 2 == 1 { 0.0 } else { 2.0 }, bits);
            let error = &sum - &exact.divided_by(&Ball::from_f64(power as f64 + 1.0, bits));
            assert!(error.radius < widest, "{count} nodes, power {power}: radius {:e}", error.radius);
            let inside = error.leading().abs() <= error.radius;
            assert_eq!(
                inside,
                power < 2 * count,
                "{count} nodes, power {power}, {truth}: {:e} +- {:e}",
                error.leading(),
                error.radius
            );
        }
    }

    #[test]
    fn rules_are_exact_to_degree_2n_minus_1_and_no_further() {
        for count in 1..=24 {
            integrates_its_degree::<DoubleDouble>(count, 106, 1e-29);
        }
        integrates_its_degree::<Astro>(7, 128, 1e-35);
        integrates_its_degree::<Astro>(40, 704, 1e-205);
    }

    #[test]
    fn radii_stay_at_the_last_bits_for_many_nodes() {
        let rule = Astro::rules().get(200, 256);
        let widest = rule.nodes.iter().chain(&rule.weights).map(|ball| ball.radius).fold(0.0, f64::max);
        assert!(widest < 1e-74, "{widest:e}");
    }
}
