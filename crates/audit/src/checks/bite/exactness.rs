//! Signs and sums that doubles decide exactly, and numbers of many bits: each against as many bits as hold all that is computed, over the
//! whole range of a double.

use glam::DVec3;
use radgrad_numbers::big::decimal::{to_decimal, upper_decimal};
use radgrad_numbers::big::enclosure::{Enclosure, enough_for_doubles, relative_error};
use radgrad_numbers::big::magnitude::Magnitude;
use radgrad_numbers::big::{self, Big};
use radgrad_numbers::double_double::{DoubleDouble, ROUNDOFF_OF_DOUBLE_DOUBLE};
use radgrad_numbers::exact::{are_in_line, height, orientation};
use radgrad_numbers::number::{Number, ROUNDOFF};
use radgrad_numbers::power::normalising_power;
use radgrad_numbers::radius::Radius;
use radgrad_numbers::{arc_tangent, effort};

use crate::cases::sampler::Sampler;
use crate::measures::measure::is_worse;

/// Bits that hold any sum of a few products of three doubles.
const ALL_BITS: usize = 8448;

/// A number of few digits and of any size, or 0.
fn number(sampler: &mut Sampler, exponents: &[i32]) -> f64 {
    if sampler.one_in(6) {
        return 0.0;
    }
    let exponent = exponents[sampler.below(u32::try_from(exponents.len()).unwrap_or(1)) as usize];
    libm::ldexp(sampler.integer(-9, 9) as f64 * (if sampler.one_in(2) { 0.1 } else { 1.0 }), exponent)
}

/// Exponents in which coordinates are of one size, or of any.
const EXPONENTS: [&[i32]; 6] =
    [&[0], &[0, -60], &[-1, 0, -345, -355, -365], &[-700, -360, 0, 350], &[-1060, -1000, -900], &[-1060, -600, -20, 0, 400, 900]];

fn point(sampler: &mut Sampler, exponents: &[i32]) -> DVec3 {
    DVec3::from([(); 3].map(|()| number(sampler, exponents)))
}

fn big(value: f64) -> Big {
    Big::from_double(value)
}

/// A height over a plane, to two units with the right sign.
fn heights(sampler: &mut Sampler) -> Vec<String> {
    let [of_normal, of_points] = [(); 2].map(|()| EXPONENTS[sampler.below(6) as usize]);
    let (n, origin) = (point(sampler, of_normal), point(sampler, of_points));
    let mut target = if sampler.one_in(3) { origin } else { point(sampler, of_points) };
    // Across the normal the height is 0.
    if sampler.one_in(3) {
        target = origin + n.cross(DVec3::from([1.0, -2.0, 3.0])) * normalising_power(n.abs().max_element());
    }
    let reach = (target - origin).abs().max_element();
    if !(reach.is_finite() && n.abs().max_element() > 0.0) {
        return Vec::new();
    }
    let [power_of_n, power] = [n.abs().max_element(), reach].map(normalising_power);
    let said = height((n, power_of_n), target, origin, power);
    let ([a, b, c], [p, q, r], [u, v, w]) = (n.to_array(), target.to_array(), origin.to_array());
    let terms = [(a, p, u), (b, q, v), (c, r, w)].map(|(n, p, o)| big(n) * (big(p) - big(o)));
    let truth = (terms[0] + terms[1] + terms[2]).scaled(power_of_n).scaled(power);
    let error = (truth - Big::from_double_double(said)).size();
    let room = truth.size() * (3.0 * ROUNDOFF_OF_DOUBLE_DOUBLE) + Magnitude::from(f64::MIN_POSITIVE);
    let is_zero = truth.size() == Magnitude::from(0.0);
    let has_sign = if is_zero { said == DoubleDouble::ZERO } else { said.hi != 0.0 && said.hi.signum() == truth.high().signum() };
    let told = || format!("{n:?} times the way from {origin:?} to {target:?} is {said:?}, off by {:e}", error.to_double());
    if error <= room && has_sign { Vec::new() } else { vec![told()] }
}

/// On which side of a plane a point is, and whether points are in line.
fn sides(sampler: &mut Sampler) -> Vec<String> {
    let exponents = EXPONENTS[sampler.below(6) as usize];
    let [a, b, c] = [(); 3].map(|()| point(sampler, exponents));
    // In the plane, in the line, or anywhere: the sum may round, and then it is beside.
    let d = match sampler.below(4) {
        0 => a + (b - a) * 2.0,
        1 => a + (b - a) * 0.5 + (c - a) * 4.0,
        2 => (a + (b - a) * 2.0).map(f64::next_up),
        _ => point(sampler, exponents),
    };
    if !d.is_finite() {
        return Vec::new();
    }
    let less = |p: DVec3| [0, 1, 2].map(|axis| big(p.to_array()[axis]) - big(a.to_array()[axis]));
    let ([b0, b1, b2], [c0, c1, c2], [d0, d1, d2]) = (less(b), less(c), less(d));
    // The determinant of the three is that of `b - a`, `c - a` and `d - a` less its sign.
    let volume = (d0 * (b1 * c2 - b2 * c1) + d1 * (b2 * c0 - b0 * c2) + d2 * (b0 * c1 - b1 * c0)).high();
    let said = orientation([a, b, c, d]);
    let is_in_line = [b1 * d2 - b2 * d1, b2 * d0 - b0 * d2, b0 * d1 - b1 * d0].iter().all(|part| part.high() == 0.0);
    let mut findings = Vec::new();
    if said.signum() * f64::from(u8::from(said != 0.0)) != -volume.signum() * f64::from(u8::from(volume != 0.0)) {
        findings.push(format!("{d} is {said:e} over {a}, {b} and {c}, not {:e}", -volume));
    }
    if are_in_line([a, b, d]) != is_in_line {
        findings.push(format!("{a}, {b} and {d} are in line: {}", !is_in_line));
    }
    findings
}

/// Angles of coordinates near both ends of the range, where the functions of doubles have their own ways.
fn angles(sampler: &mut Sampler) -> Vec<String> {
    let exponents: &[i32] = [&[-1070, -1060, -1022][..], &[1019, 1020], &[-1060, 0], &[-3, 0]][sampler.below(4) as usize];
    let [y, x] = [(); 2].map(|()| number(sampler, exponents));
    let (said, truth) = (arc_tangent::atan2(y, x), libm::atan2(y, x));
    // Two ulps of either, and the underflow below the normal range.
    let is_near = (said - truth).abs() <= 4.0 * f64::EPSILON * truth.abs() + 4.0 * f64::from_bits(1);
    if is_near { Vec::new() } else { vec![format!("the angle of ({x:e}, {y:e}) is {said}, not {truth}")] }
}

/// Decimal forms: a bound upward to three digits, a number to a place.
fn decimals(sampler: &mut Sampler) -> Vec<String> {
    // Often a power of ten or just below.
    let ten = libm::exp10(sampler.integer(-200, 200) as f64);
    let bound = ten * if sampler.one_in(2) { sampler.between(1.0, 10.0) } else { 1.0 - sampler.spread(-40, -6) };
    let mut findings = Vec::new();
    if upper_decimal(Magnitude::from(0.0)) != "0" {
        findings.push(format!("no error is written {}", upper_decimal(Magnitude::from(0.0))));
    }
    let text = upper_decimal(Magnitude::from(bound));
    let digits = text.split('e').next().map_or(0, str::len);
    if !text.parse().is_ok_and(|upper: f64| upper >= bound && upper <= bound * 1.011 && digits == 4) {
        findings.push(format!("{bound:e} is written {text} from above"));
    }
    let (value, place) = (sampler.sign() * sampler.between(1.0, 1e6), sampler.integer(-9, 3));
    let (text, unit) = (to_decimal(&big(value).to_float(), place), libm::exp10(place as f64));
    if !text.parse().is_ok_and(|written: f64| (written - value).abs() <= 0.5 * unit + 4.0 * f64::EPSILON * value.abs()) {
        findings.push(format!("{value} is written {text} to 1e{place}"));
    }
    findings
}

/// Magnitudes, which are doubles with an exponent of their own, and operations on them.
fn magnitudes(sampler: &mut Sampler) -> Vec<String> {
    let [a, b] = [(); 2].map(|()| sampler.spread(-40, 40) * sampler.between(1.0, 2.0));
    let (p, q, shift) = (Magnitude::from(a), Magnitude::from(b), Magnitude::power_of_two(sampler.integer(-9000, 9000)));
    let back = |m: Magnitude| (m / shift).to_double();
    // A double, and what is between two of them: rounded it is off by half their distance at most, and at least by what it is off.
    let rounded = |mid: Big| Enclosure { mid: mid.to_float(), radius: p }.to_double();
    let ((exact, of_exact), (near, of_near)) = (rounded(big(b)), rounded(big(b) + big(b * 1e-17)));
    let holds = (f64::from(u8::from(near == b && of_near >= p + Magnitude::from(b * 1e-17))), 1.0);
    let (up, down) = (p * shift, q * shift);
    let pairs = [
        (back(up + down), a + b),
        (back(up - down), a - b),
        ((up * q / down).to_double(), a * b / b),
        ((up / down).to_double(), a / b),
        (((up * shift * q).sqrt() / shift).to_double(), libm::sqrt(a * b)),
        (
            relative_error(&[Enclosure { mid: big(b).to_float(), radius: p }]).to_double(),
            if a < b { a / b } else { f64::INFINITY },
        ),
        (relative_error(&[Enclosure { mid: big(b).to_float(), radius: Magnitude::from(0.0) }]).to_double(), 0.0),
        (enough_for_doubles(a).to_double(), (a / 4.0).max(ROUNDOFF / 64.0)),
        (f64::from(u8::from(up < down)), f64::from(u8::from(a < b))),
        (exact, b),
        (of_exact.to_double(), a),
        holds,
        (Magnitude::of_number(&big(a).to_float()).to_double(), a),
    ];
    let is_off =
        |&(_, (said, truth)): &(usize, (f64, f64))| said != truth && is_worse((said - truth).abs(), 1e-12 * truth.abs().max(a));
    let wrong = pairs.into_iter().enumerate().find(is_off);
    wrong.map(|(k, (said, truth))| format!("operation {k} on {a:e} and {b:e}: {said:e}, not {truth:e}")).into_iter().collect()
}

/// What may be spent is never more than what remains outside.
fn efforts(sampler: &mut Sampler) -> Vec<String> {
    let [outer, inner, cost] = [(); 3].map(|()| 1 + u64::from(sampler.below(40)));
    let spend = |most: u64| (0..most).take_while(|_| effort::spend(1)).count() as u64;
    let mut ended = None;
    effort::within(outer, || {
        spend(2);
        ended = effort::within(inner, || spend(cost)).0;
    });
    let truth = (cost <= inner.min(outer.saturating_sub(2))).then_some(cost);
    if ended == truth { Vec::new() } else { vec![format!("{cost} of {inner} within {outer}, of which 2 are spent: {ended:?}")] }
}

/// Contradictions in so many draws of each.
pub(super) fn all_wrong(count: u64) -> Vec<String> {
    let asks: [fn(&mut Sampler) -> Vec<String>; 6] = [heights, sides, angles, decimals, magnitudes, efforts];
    let told = || {
        let ask = |index: u64| {
            let sampler = &mut Sampler::new(61, "exactness", index);
            asks.iter().flat_map(|ask| ask(sampler)).collect::<Vec<_>>()
        };
        (0..count).flat_map(ask).collect()
    };
    big::within(ALL_BITS, u64::MAX, told).0.unwrap_or_else(|| vec!["numbers of many bits are not computed".to_owned()])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_is_wrong() {
        assert_eq!(all_wrong(300), Vec::<String>::new());
    }
}
