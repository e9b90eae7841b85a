//! Arguments in double precision whose logarithm or arc tangent lies nearest to a double or midway between two, where a rounding is hardest
//! to tell. `data/reference/near_ties.txt` holds those of a long search, by which the functions of this crate are tested.
//!
//! V. Lefèvre and J.-M. Muller (2001) find them by tabulated differences: along `x + k u`, u the spacing of doubles, a function is
//! a parabola to more digits than are looked for. Its values in half units of the last place, without their integers, follow from each other
//! by two additions in fixed point. Those nearest to 0 are evaluated again to 256 bits.
//!
//! `cargo run --release -p radgrad-numbers --example near_ties -- 16384` searches so many stretches of 2^20 arguments for each function.
//! Printed are the function, the argument, and how many half units the value is away, as a power of two. For the two stretches that are
//! searched unless told:
//!
//! ```text
//! ln 6.289439299629712e29 2^-26.40
//! ln 1.8041892505866456e93 2^-21.96
//! atan 14171.093854875946 2^-22.21
//! atan 14171.093855477924 2^-21.86
//! ```

use std::thread;

use astro_float::{BigFloat, Consts, RoundingMode};
use rand::{RngExt, SeedableRng, rngs::ChaCha8Rng};

const BITS: usize = 256;
const NEAREST: RoundingMode = RoundingMode::ToEven;

/// Arguments in a stretch.
const STRETCH: u32 = 1 << 20;

/// Numbers nearer than this, of 2^128 in half a unit of the last place, are evaluated again.
const NEAR: u128 = 1 << (128 - 18);

/// The most that are printed of a function.
const KEPT: usize = 20;

#[derive(Clone, Copy)]
enum Function {
    Logarithm,
    ArcTangent,
}

/// An argument, and how near its value is: minus the logarithm to base 2 of the distance in half units.
type Tie = (f64, f64);

impl Function {
    const fn name(self) -> &'static str {
        match self {
            Self::Logarithm => "ln",
            Self::ArcTangent => "atan",
        }
    }

    /// The exponents of its arguments; of smaller ones the arc tangent is near a double because it is near its argument.
    const fn exponents(self) -> std::ops::Range<i32> {
        match self {
            Self::Logarithm => -1000..1000,
            Self::ArcTangent => -6..24,
        }
    }

    fn value(self, x: f64, consts: &mut Consts) -> BigFloat {
        let x = BigFloat::from_f64(x, BITS);
        match self {
            Self::Logarithm => x.ln(BITS, NEAREST, consts),
            Self::ArcTangent => x.atan(BITS, NEAREST, consts),
        }
    }

    /// The first and the second derivative.
    fn derivatives(self, x: f64) -> [BigFloat; 2] {
        let number = |x: f64| BigFloat::from_f64(x, BITS);
        match self {
            Self::Logarithm => {
                let first = number(1.0).div(&number(x), BITS, NEAREST);
                [first.clone(), first.mul(&first, BITS, NEAREST).neg()]
            }
            Self::ArcTangent => {
                let square = number(x).mul(&number(x), BITS, NEAREST);
                let first = number(1.0).div(&number(1.0).add(&square, BITS, NEAREST), BITS, NEAREST);
                let second = first.mul(&first, BITS, NEAREST).mul(&number(-2.0 * x), BITS, NEAREST);
                [first, second]
            }
        }
    }

    /// The nearest of the stretch from x upward.
    fn search(self, x: f64, spacing: f64, consts: &mut Consts) -> Vec<Tie> {
        let value = self.value(x, consts);
        let Some(exponent) = value.exponent() else { return Vec::new() };
        let [first, second] = self.derivatives(x);
        let times = |number: &BigFloat, factor: f64| number.mul(&BigFloat::from_f64(factor, BITS), BITS, NEAREST);
        // Half a unit in the last place is 2^(exponent - 54), with mantissas in [1/2, 1).
        let in_half_units = |number: &BigFloat| fraction(number, 54 - exponent);
        let (slope, bend) = (times(&first, spacing), times(&times(&second, spacing), spacing));
        let mut place = in_half_units(&value);
        let mut step = in_half_units(&slope.add(&times(&bend, 0.5), BITS, NEAREST));
        let step_of_step = in_half_units(&bend);
        let mut near = Vec::new();
        for k in 0..STRETCH {
            if place.wrapping_add(NEAR) < 2 * NEAR {
                near.push(x + f64::from(k) * spacing);
            }
            place = place.wrapping_add(step);
            step = step.wrapping_add(step_of_step);
        }
        near.into_iter().map(|x| (x, self.nearness(x, consts))).collect()
    }

    fn nearness(self, x: f64, consts: &mut Consts) -> f64 {
        let value = self.value(x, consts);
        let distance = value.exponent().map_or(0, |exponent| fraction(&value, 54 - exponent));
        128.0 - (distance.min(distance.wrapping_neg()) as f64).log2()
    }

    /// The nearest ones of so many random stretches.
    fn best(self, stretches: u64, seed: u64) -> Result<Vec<Tie>, astro_float::Error> {
        let (mut random, mut consts) = (ChaCha8Rng::seed_from_u64(seed), Consts::new()?);
        let mut best: Vec<Tie> = Vec::new();
        for _ in 0..stretches {
            let exponent = random.random_range(self.exponents());
            let scale = f64::from_bits(u64::from((exponent + 1023).unsigned_abs()) << 52);
            let mantissa = random.random_range(0..(1u64 << 52) - u64::from(STRETCH));
            let x = f64::from_bits(scale.to_bits() | mantissa);
            best.extend(self.search(x, scale * f64::EPSILON, &mut consts));
            best.sort_by(|a, b| b.1.total_cmp(&a.1));
            best.truncate(KEPT);
        }
        Ok(best)
    }
}

/// 128 bits after the point of a number times a power of two, as if it were written with infinitely many signs before it.
fn fraction(number: &BigFloat, power: i32) -> u128 {
    let Some((words, _, sign, exponent, _)) = number.as_raw_parts() else { return 0 };
    // Places before the point.
    let before = exponent + power;
    let bit = |place: i32| -> u128 {
        let from_end = usize::try_from(place).ok().and_then(|place| (words.len() * 64).checked_sub(place + 1));
        from_end.map_or(0, |from_end| u128::from(words[from_end / 64] >> (from_end % 64) & 1))
    };
    let magnitude = (0..128).fold(0, |bits, place| bits << 1 | bit(before + place));
    if sign.is_negative() { magnitude.wrapping_neg() } else { magnitude }
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let stretches: u64 = std::env::args().nth(1).map_or(Ok(2), |text| text.parse())?;
    for function in [Function::Logarithm, Function::ArcTangent] {
        // As many as there are, whatever the machine: the same stretches.
        const PARTS: u64 = 2;
        let mut best: Vec<Tie> = thread::scope(|scope| {
            let part = |seed: u64| scope.spawn(move || function.best(stretches.div_ceil(PARTS), seed));
            let running: Vec<_> = (0..PARTS).map(part).collect();
            let ended = running.into_iter().map(|part| part.join().map_err(|_| "a thread has panicked".to_owned()));
            ended.map(|best| best?.map_err(|error| error.to_string())).collect::<Result<Vec<_>, String>>()
        })?
        .concat();
        best.sort_by(|a, b| b.1.total_cmp(&a.1));
        for (x, nearness) in best.iter().take(if stretches > PARTS { KEPT } else { 2 }) {
            println!("{} {x:?} 2^-{nearness:.2}", function.name());
        }
    }
    Ok(())
}
