//! What the running error bounds assume of the mathematical library: `log` and `atan2` err by at most 2 ulp.

use astro_float::{BigFloat, Consts, RoundingMode};
use rand::{RngExt, SeedableRng, rngs::ChaCha8Rng};

const BITS: usize = 192;
const NEAREST: RoundingMode = RoundingMode::ToEven;

fn big(x: f64) -> BigFloat {
    BigFloat::from_f64(x, BITS)
}

/// Error of `value` in units in the last place.
fn ulps(value: f64, truth: &BigFloat) -> f64 {
    let difference = big(value).sub(truth, BITS, NEAREST);
    let difference: f64 = difference.to_string().parse().unwrap();
    let ulp = value.abs().next_up() - value.abs();
    (difference / ulp).abs()
}

#[test]
fn logarithm_errs_by_less_than_two_ulp() {
    let mut consts = Consts::new().unwrap();
    let mut random = ChaCha8Rng::seed_from_u64(1);
    let mut worst = 0.0f64;
    for i in 0..3000 {
        let spread = [1e-8, 1e-3, 1.0, 700.0][i % 4];
        let x = libm::exp(random.random_range(-spread..spread));
        worst = worst.max(ulps(libm::log(x), &big(x).ln(BITS, NEAREST, &mut consts)));
    }
    println!("log: {worst:.3} ulp");
    assert!(worst < 2.0, "{worst}");
}

#[test]
fn arc_tangent_errs_by_less_than_two_ulp() {
    let mut consts = Consts::new().unwrap();
    let pi = consts.pi(BITS, NEAREST);
    let mut random = ChaCha8Rng::seed_from_u64(2);
    let mut worst = 0.0f64;
    for i in 0..3000 {
        let spread = [0.1, 1.0, 30.0][i % 3];
        let y = libm::exp(random.random_range(-spread..spread)) * if i % 2 == 0 { 1.0 } else { -1.0 };
        let x = libm::exp(random.random_range(-spread..spread)) * if i % 5 < 3 { 1.0 } else { -1.0 };
        let mut angle = big(y).div(&big(x), BITS, NEAREST).atan(BITS, NEAREST, &mut consts);
        if x < 0.0 {
            angle = if y > 0.0 { angle.add(&pi, BITS, NEAREST) } else { angle.sub(&pi, BITS, NEAREST) };
        }
        worst = worst.max(ulps(libm::atan2(y, x), &angle));
    }
    println!("atan2: {worst:.3} ulp");
    assert!(worst < 2.0, "{worst}");
}
