//! Single operations with a running bound, against the same with more digits.
//!
//! A bound of one operation is met closely by random operands, so that half of it is seen to be too little; in a whole formula it is lost
//! among others. Operands are numbers, and balls of which the ends are asked.

use radgrad_numbers::ball::Ball;
use radgrad_numbers::double_double::DoubleDouble;
use radgrad_numbers::number::Number;
use radgrad_numbers::radius::Radius;
use radgrad_numbers::real::Real;

use crate::sampler::Sampler;

const NAMES: [&str; 9] = ["sum", "difference", "product", "quotient", "root", "logarithm", "angle", "clausen", "sine"];

fn results<T: Real>([x, y, small]: [T; 3]) -> [T; 9] {
    let sine = T::sine_series(small * small);
    [x + y, x - y, x * y, x / y, x.abs().sqrt(), x.abs().ln(), x.atan2(y), small.clausen_rest(), sine]
}

/// Operands with few digits, and a radius that leaves their ends exact.
fn operands(sampler: &mut Sampler) -> ([f64; 3], [f64; 3]) {
    #[allow(clippy::cast_possible_truncation, reason = "few digits are wanted")]
    let few = |value: f64| f64::from(value as f32);
    let power = [1.0 / 4096.0, 1.0 / 16.0, 1.0, 64.0, 4096.0][sampler.below(5) as usize];
    let [x, y] = [sampler.sign() * sampler.between(1.0, 2.0) * power, sampler.sign() * sampler.between(1.0, 2.0)];
    let operands = [few(x), few(y), few(sampler.between(0.01, 1.0))];
    let width = if sampler.one_in(2) { 0.0 } else { 1.0 / (1u64 << 28) as f64 };
    (operands, [width * power, width, width])
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

/// Violations by single operations on doubles against double-doubles, with the operands of case `index`.
#[must_use]
pub fn wrong(index: u64) -> Vec<String> {
    contradictions::<f64, DoubleDouble>(&mut Sampler::new(16, "operations", index))
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
