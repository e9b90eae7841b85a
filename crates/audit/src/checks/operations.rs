//! Single operations with a running bound, and those on lanes, against the same with more digits.
//!
//! A bound of one operation is met closely by random operands, so that half of it is seen to be too little; in a whole formula it is lost
//! among others. Operands are numbers, and balls of which the ends are asked.

use radgrad_numbers::arc_tangent;
use radgrad_numbers::arithmetic::Arithmetic;
use radgrad_numbers::ball::Ball;
use radgrad_numbers::big::{self, Big};
use radgrad_numbers::double_double::DoubleDouble;
use radgrad_numbers::double_double_on_lanes::ROUNDOFF_ON_LANES;
use radgrad_numbers::lanes::ball::LaneBall;
use radgrad_numbers::lanes::instruction_set::fearless_simd::{Level, Simd, SimdBase, f64x4};
use radgrad_numbers::logarithm;
use radgrad_numbers::number::{Number, ROUNDOFF};
use radgrad_numbers::on_instruction_set;
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

/// Factors of the operands on each of four lanes.
const FACTORS: [f64; 4] = [1.0, 2.0, 0.5, 4.0];

/// Factors with which the third lane outweighs the first two.
const SIGNS: [f64; 4] = [1.0, -1.0, -64.0, 1.0];

const BALLS_ON_LANES: [&str; 10] = [
    "sum",
    "difference",
    "product",
    "quotient",
    "root",
    "rounded",
    "quotient of two signs",
    "sum of three lanes",
    "sum of four",
    "sum of three of two signs",
];

/// Operations on balls on lanes, of two positive numbers times the factors; the angle of the two, and half the logarithm of the first.
#[inline(always)]
fn balls_on_lanes<S: Simd>(
    simd: S,
    numbers: [Ball<f64>; 2],
    [angle, logarithm]: [f64; 2],
) -> ([[Ball<f64>; 4]; 10], [Ball<f64>; 2]) {
    let factors = f64x4::from_slice(simd, &FACTORS);
    let plain = numbers.map(|number| LaneBall::splat(simd, number));
    let [x, y] = plain.map(|number| number.moved(|lanes| lanes * factors));
    let lanes = |ball: LaneBall<S>| [0, 1, 2, 3].map(|k| Ball::approximate(ball.middle()[k], ball.error()[k]));
    let splat = |value: f64| f64x4::splat(simd, value);
    let functions = [LaneBall::angle(plain[0], plain[1], splat(angle)), plain[0].half_logarithm(splat(logarithm))];
    let signed = x * LaneBall::rounded(f64x4::from_slice(simd, &SIGNS));
    let exact = LaneBall::rounded(x.middle());
    let results = [x + y, x - y, x * y, x / y, x.sqrt(), exact, -x / y].map(lanes);
    let [a, b, c, d, e, f, g] = results;
    let sums = [x.sum_of_first(3), x.sum_of_first(4), signed.sum_of_first(3)].map(|sum| [sum; 4]);
    let [three, four, of_signs] = sums;
    ([a, b, c, d, e, f, g, three, four, of_signs], functions.map(|function| lanes(function)[0]))
}

/// Operations on balls on lanes that double-doubles contradict, at ends of the balls.
fn contradictions_on_lanes(sampler: &mut Sampler) -> Vec<String> {
    let ([x, y, _], _) = operands(sampler);
    // Wide enough that the second order counts, narrow ones, and none: then rounding is all.
    let widths = [0.0, 0.0, 1.0 / (1u64 << 28) as f64, 1.0 / 16.0, 5.0 / 64.0, 7.0 / 8.0];
    let width = [(); 2].map(|()| widths[sampler.below(6) as usize]);
    let (middle, radius) = ([x.abs(), y.abs()], [x.abs() * width[0], y.abs() * width[1]]);
    let end = [0, 1].map(|k| middle[k] + [-1.0, 0.0, 1.0][sampler.below(3) as usize] * radius[k]);
    let numbers = [0, 1].map(|k| Ball::approximate(middle[k], radius[k]));
    let rough = [libm::atan2(middle[0], middle[1]), 0.5 * libm::log(middle[0])];
    let (results, functions) = on_instruction_set!(Level::new(), simd => balls_on_lanes(simd, numbers, rough));
    // Far from where nothing is known.
    let limit = if width.iter().all(|width| *width < 0.1) { f64::MAX } else { f64::INFINITY };
    let mut findings = Vec::new();
    let mut compare = |name: &str, coarse: Ball<f64>, fine: Ball<DoubleDouble>| {
        let apart = (DoubleDouble::from(coarse.middle()) - fine.middle()).hi.abs();
        let holds = (0.0..=coarse.error() + fine.error()).contains(&apart) && coarse.error() <= limit;
        if !holds {
            findings
                .push(format!("{name} on lanes of {end:?} within {radius:?}: off by {apart:e}, known to {:e}", coarse.error()));
        }
    };
    for (lane, factor) in FACTORS.into_iter().enumerate() {
        let [x, y] = end.map(|end| Ball::<DoubleDouble>::exact(end * factor));
        let sum = |count: usize| Ball::exact(end[0]) * Ball::exact(FACTORS[..count].iter().sum());
        let signed = (0..3).map(|k| FACTORS[k] * SIGNS[k]).sum();
        let of_signs = Ball::exact(end[0]) * Ball::exact(signed);
        let rounded = Ball::exact(middle[0] * factor);
        let fine = [x + y, x - y, x * y, x / y, x.sqrt(), rounded, -(x / y), sum(3), sum(4), of_signs];
        for ((coarse, fine), name) in results.iter().zip(fine).zip(BALLS_ON_LANES) {
            compare(name, coarse[lane], fine);
        }
    }
    let [x, y] = end.map(Ball::<DoubleDouble>::exact);
    compare("angle", functions[0], x.atan2(y));
    compare("half a logarithm", functions[1], x.ln() * Ball::exact(0.5));
    // The rounding of a function is proven, and larger than what any operand meets.
    for (name, function, units) in [("angle", functions[0], arc_tangent::UNITS), ("logarithm", functions[1], logarithm::UNITS)] {
        let least = units * ROUNDOFF * function.middle().abs();
        if function.error() < least {
            findings.push(format!("{name} on lanes is known to {:e}, its rounding is {least:e}", function.error()));
        }
    }
    findings
}

const FUNCTIONS: [&str; 10] =
    ["sum", "difference", "product", "quotient", "root", "logarithm", "angle", "angle to the right", "clausen", "sine"];

/// Operations on any numbers, two of them positive.
fn functions<T: Arithmetic>([x, y, z, square]: [T; 4]) -> [T; 10] {
    let sine = T::sine_series(square);
    [x + y, x - y, x * y, x / y, x.sqrt(), x.ln(), x.atan2(-y), x.atan2_right(y), z.clausen_rest(), sine]
}

/// Double-doubles on lanes that err by more than they are said to, where their series end latest: at the ends of what these are summed over.
fn coarse_functions(sampler: &mut Sampler) -> Vec<String> {
    let just = |sampler: &mut Sampler, limit: f64| {
        let beside = sampler.sign() * sampler.spread(-20, -8);
        limit * (1.0 + if sampler.one_in(2) { beside } else { 0.0 })
    };
    let high = if sampler.one_in(2) { sampler.between(0.5, 2.0) } else { just(sampler, std::f64::consts::SQRT_2) };
    let ratio = match sampler.below(4) {
        0 => just(sampler, 0.25),
        1 => just(sampler, 0.75),
        2 => just(sampler, 1.0),
        _ => sampler.spread(-12, 12),
    };
    let quarter = std::f64::consts::FRAC_PI_2;
    let third = if sampler.one_in(2) { sampler.between(0.0, quarter) } else { quarter };
    let fourth = if sampler.one_in(2) { sampler.between(0.0, 0.999) } else { 0.999 };
    let numbers = [high, high * ratio, third, fourth]
        .map(|high| DoubleDouble::from(high) + DoubleDouble::from(high * sampler.between(-1e-16, 1e-16)));
    let coarse = on_instruction_set!(Level::new(), simd => {
        let splat = |c: DoubleDouble| DoubleDouble { hi: f64x4::splat(simd, c.hi), lo: f64x4::splat(simd, c.lo) };
        functions(numbers.map(splat)).map(|result| DoubleDouble { hi: result.hi[3], lo: result.lo[3] })
    });
    let fine = functions(numbers.map(|number| Ball::<DoubleDouble>::from_double_double(number, 0.0)));
    let told = coarse.into_iter().zip(fine).zip(FUNCTIONS).filter_map(|((coarse, fine), name)| {
        let apart = (coarse - fine.middle()).hi.abs();
        let room = ROUNDOFF_ON_LANES * fine.middle().hi.abs() + fine.error();
        let holds = (0.0..=room).contains(&apart);
        (!holds).then(|| format!("{name} on lanes of {numbers:?}: off by {apart:e}, known to {room:e}"))
    });
    told.collect()
}

/// Violations by single operations on doubles against double-doubles, with the operands of case `index`, and now and then by those on
/// double-doubles against numbers of more bits, and on lanes.
#[must_use]
pub fn wrong(index: u64) -> Vec<String> {
    let sampler = &mut Sampler::new(16, "operations", index);
    let mut findings = contradictions::<f64, DoubleDouble>(sampler);
    if index.is_multiple_of(8) {
        findings.extend(finer_contradictions(sampler));
        findings.extend(contradictions_on_lanes(sampler));
        findings.extend(coarse_functions(sampler));
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
