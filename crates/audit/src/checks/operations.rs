//! Single operations with a running bound, against the same with more digits.
//!
//! A bound of one operation is met closely by random operands, so that half of it is seen to be too little; in a whole formula it is lost
//! among others. Operands are numbers, and balls of which the ends are asked.

use radgrad_numbers::ball::Ball;
use radgrad_numbers::big::{self, Big};
use radgrad_numbers::double_double::DoubleDouble;
use radgrad_numbers::number::Number;
use radgrad_numbers::radius::Radius;
use radgrad_numbers::real::Real;

use crate::cases::sampler::Sampler;

const NAMES: [&str; 9] = ["sum", "difference", "product", "quotient", "root", "logarithm", "angle", "clausen", "sine"];

/// All operations.
pub(crate) fn results<T: Real>([x, y, small]: [T; 3]) -> [T; 9] {
    let sine = T::sine_series(small * small);
    [x + y, x - y, x * y, x / y, x.abs().sqrt(), x.abs().ln(), x.atan2(y), small.clausen_rest(), sine]
}

/// Numbers that a branch may single out.
const SINGLE: [f64; 6] = [1.0, -1.0, 2.0, 0.5, -0.25, 1.0 / 1024.0];

/// Operands with few digits, and a radius that leaves their ends exact.
pub(crate) fn operands(sampler: &mut Sampler) -> ([f64; 3], [f64; 3]) {
    #[allow(clippy::cast_possible_truncation, reason = "few digits are wanted")]
    let few = |value: f64| f64::from(value as f32);
    let power = [1.0 / 4096.0, 1.0 / 16.0, 1.0, 64.0, 4096.0][sampler.below(5) as usize];
    let mut operand = |power: f64| {
        if sampler.one_in(8) {
            return SINGLE[sampler.below(6) as usize];
        }
        sampler.sign() * few(sampler.between(1.0, 2.0)) * power
    };
    let [x, y] = [operand(power), operand(1.0)];
    let operands = [x, y, few(sampler.between(0.01, 1.0))];
    let width = if sampler.one_in(2) { 0.0 } else { 1.0 / (1u64 << 28) as f64 };
    (operands, [width * power.min(1.0 / 1024.0), width / 1024.0, width])
}

/// Operands so large or small that squares leave the range.
fn extreme_operands(sampler: &mut Sampler) -> [f64; 3] {
    let mut operand =
        || sampler.sign() * sampler.between(1.0, 2.0) * libm::ldexp(1.0, [-1000, -600, -1, 600, 1000][sampler.below(5) as usize]);
    [operand(), operand(), 0.5]
}

/// The results in coarse numbers that contradict those in fine ones.
fn contradictions<A: Number, B: Number>(sampler: &mut Sampler) -> Vec<String> {
    let (at, radii) = operands(sampler);
    let end = [0, 1, 2].map(|k| at[k] + [-1.0, 0.0, 1.0][sampler.below(3) as usize] * radii[k]);
    let coarse = results([0, 1, 2].map(|k| Ball::<A>::approximate(A::from_double(at[k]), radii[k].into())));
    let fine = results(end.map(Ball::<B>::exact));
    let pairs = coarse.into_iter().zip(fine).zip(NAMES);
    let told = pairs.filter_map(|((coarse, fine), name)| {
        let (a, b) = (coarse.middle(), fine.middle());
        let apart = ((a.high() - b.high()) + (a.low() - b.low())).abs();
        let room = coarse.error().to_double() + fine.error().to_double();
        (!(0.0..=room).contains(&apart))
            .then(|| format!("{name} of {end:?} within {radii:?}: off by {apart:e}, known to {room:e}"))
    });
    told.collect()
}

/// Roots and logarithms, whose range is within that of the operands.
const OF_ANY_SIZE: [usize; 2] = [4, 5];

/// Bits of numbers that double-doubles are held against.
const BITS: usize = 256;

/// The results in double-doubles that contradict those in more bits.
fn finer_contradictions(sampler: &mut Sampler) -> Vec<String> {
    let (at, asked): (_, Vec<usize>) = if sampler.one_in(4) {
        (extreme_operands(sampler), OF_ANY_SIZE.to_vec())
    } else {
        (operands(sampler).0, (0..NAMES.len()).collect())
    };
    let coarse = results(at.map(Ball::<DoubleDouble>::exact));
    let told = || -> Vec<String> {
        let fine = results(at.map(Ball::<Big>::exact));
        let wrong = |&k: &usize| {
            let off = (fine[k] - Ball::from_double_double(coarse[k].middle(), 0.0)).middle().high().abs();
            let room = coarse[k].error().to_double() + fine[k].error().to_double();
            (!(0.0..=room).contains(&off)).then(|| format!("{} of {at:?}: off by {off:e}, known to {room:e}", NAMES[k]))
        };
        // What is below the range of doubles is no zero.
        let small = Big::from_double(at[0].signum()).scaled(f64::MIN_POSITIVE) * Big::from_double(f64::MIN_POSITIVE);
        let lost = (small.high() * at[0].signum() <= 0.0).then(|| format!("a tiny number has the sign of {}", small.high()));
        asked.iter().filter_map(wrong).chain(lost).collect()
    };
    big::within(BITS, u64::MAX, told).0.unwrap_or_default()
}

/// Violations by single operations on doubles against double-doubles, with the operands of case `index`, and now and then by those on
/// double-doubles against numbers of more bits.
#[must_use]
pub fn wrong(index: u64) -> Vec<String> {
    let sampler = &mut Sampler::new(16, "operations", index);
    let mut findings = contradictions::<f64, DoubleDouble>(sampler);
    if index.is_multiple_of(8) {
        findings.extend(finer_contradictions(sampler));
    }
    findings
}

#[cfg(test)]
mod tests {
    use radgrad_scene::largest;

    use super::*;

    #[test]
    fn half_the_bound_of_an_operation_is_seen_to_be_too_little() {
        assert_eq!((0..400).flat_map(wrong).collect::<Vec<_>>(), Vec::<String>::new());
        // The error of a double's quotient comes near its bound, which is the roundoff.
        let worst = (0..4000).map(|index| {
            let ([x, y, _], _) = operands(&mut Sampler::new(16, "operations", index));
            let [coarse, fine] = [(Ball::<f64>::exact(x) / Ball::exact(y)).value(), x / y];
            assert_eq!(coarse, fine);
            let exact = (Ball::<DoubleDouble>::exact(x) / Ball::exact(y)).middle();
            ((coarse - exact.high()) - exact.low()).abs() / (Ball::<f64>::exact(x) / Ball::exact(y)).error()
        });
        assert!(worst.fold(0.0, largest) > 0.9);
    }
}
