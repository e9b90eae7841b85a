//! The precision to which the coordinates of a file are written: the rounding q, the most by which a coordinate may differ from
//! the one that was meant, in the file's unit of length.
//!
//! Three kinds of rounding are told from the numbers themselves.
//!
//! - Single precision: each number is an f32 printed to so many digits, and numbers that are none would pass for that by a chance
//!   below 1 in 1000: a number whose last digit is u passes by u / s, with s the distance of f32 there. Numbers with up to seven
//!   digits pass nearly all, so that these say nothing but where eight have seven or more digits and are of no other kind. q = 2^-24
//!   times the largest coordinate (half a unit in the last place).
//! - Decimals, d of them (0 or fewer of whole numbers): of at least eight different numbers with four or more significant digits,
//!   60 % have a d-th decimal that is not zero; 90 % of numbers with random digits have. Or every number is written with the same d
//!   of at least five decimals, as `%.6f` does. q = 10^-d / 2.
//! - Significant digits, as `%g` writes: the same with the last of n of them, and q = half a unit of the n-th digit of the largest
//!   coordinate.
//!
//! Of several the coarsest counts: a rounded number stays rounded where it is rounded again. Numbers with 15 or more significant
//! digits are doubles, and then q is 0 but for single precision. Numbers with few digits are taken as meant.

use std::collections::HashSet;

use crate::extremes::{largest, smallest};

/// Numbers that are told from those before them; of more each counts.
const DISTINCT: usize = 4096;

/// Significant digits from which on a number counts as one with random digits, and from which on as a double.
const LONG: u16 = 4;
const DOUBLE: u16 = 15;

/// The most significant digits that are typed, and that every f32 keeps.
const TYPED: u16 = 6;

/// Different numbers that it takes to tell of most of them.
const ENOUGH: usize = 8;

/// How a number is written: its digits without zeros before and behind.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(crate) struct Digits {
    /// From the first that is not zero to the last that is not.
    significant: u16,
    /// The place of the last behind the point: 2 of `0.25`, -2 of `1200`.
    decimals: i16,
    /// Decimals as they stand there, zeros included; none where there is an exponent.
    fixed: Option<u16>,
}

impl Digits {
    /// Of the text of a number.
    pub(crate) fn parse(text: &str) -> Self {
        let (mantissa, exponent) = text.split_once(['e', 'E']).unwrap_or((text, ""));
        let power: i32 = exponent.parse().unwrap_or(0);
        let (whole, decimals) = mantissa.split_once('.').unwrap_or((mantissa, ""));
        let digits = || whole.bytes().chain(decimals.bytes()).filter(u8::is_ascii_digit);
        let count = digits().count();
        let before = digits().take_while(|&digit| digit == b'0').count();
        let behind = digits().rev().take_while(|&digit| digit == b'0').count();
        let small = |count: usize| u16::try_from(count).unwrap_or(u16::MAX);
        let last = decimals.len() as i64 - behind as i64 - i64::from(power);
        Self {
            significant: small(count.saturating_sub(before + behind)),
            decimals: i16::try_from(last).unwrap_or(if last < 0 { i16::MIN } else { i16::MAX }),
            fixed: exponent.is_empty().then(|| small(decimals.len())),
        }
    }
}

/// How a file writes a coordinate.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Written {
    /// As a text of these digits.
    Text(Digits),
    /// As four bytes.
    Single,
    /// As eight bytes.
    Double,
}

/// The three coordinates of a vertex, and how each is written.
pub(crate) type Coordinates = ([f64; 3], [Written; 3]);

/// A collector of the coordinates of a file.
#[derive(Debug)]
pub(crate) struct WrittenPrecision {
    largest: f64,
    distinct: HashSet<u64>,
    /// Whether every number is an f32 as far as its digits tell, and the chance by which others would pass for that.
    all_single: bool,
    chance: f64,
    any_double: bool,
    /// Numbers with random digits, and those with so many that nobody types them.
    long: usize,
    beyond_typed: usize,
    /// The most decimals of a number, and how many of the long ones have them.
    decimals: Option<i16>,
    with_decimals: usize,
    /// The most significant digits of a number, and how many have them.
    significant: u16,
    with_significant: usize,
    /// The decimals of all numbers, while all have as many.
    fixed: Option<Option<u16>>,
    /// A rounding known otherwise.
    known: f64,
}

impl WrittenPrecision {
    pub(crate) fn new() -> Self {
        Self {
            largest: 0.0,
            distinct: HashSet::new(),
            all_single: true,
            chance: 1.0,
            any_double: false,
            long: 0,
            beyond_typed: 0,
            decimals: None,
            with_decimals: 0,
            significant: 0,
            with_significant: 0,
            fixed: None,
            known: 0.0,
        }
    }

    /// A coordinate as it is written.
    pub(crate) fn add(&mut self, written: Written, value: f64) {
        match written {
            Written::Text(digits) => self.digits(digits, value),
            Written::Single => self.single(value),
            Written::Double => {
                self.digits(Digits::parse(&value.to_string()), value);
                self.fixed = Some(None);
            }
        }
    }

    fn digits(&mut self, digits: Digits, value: f64) {
        self.fixed = Some(match self.fixed {
            None => digits.fixed,
            Some(known) => known.filter(|_| known == digits.fixed),
        });
        if self.is_new(value) {
            self.count(digits, value);
            self.compare_with_single(digits, value);
        }
    }

    /// Of four bytes the decimals are those of the shortest text that gives the same bytes.
    fn single(&mut self, value: f64) {
        self.fixed = Some(None);
        // The first numbers tell enough: to print all takes longer than to read them.
        if self.is_new(value) && self.distinct.len() < DISTINCT {
            let single = to_single(value);
            let shortest = Digits::parse(&single.to_string());
            self.count(Digits { significant: shortest.significant.min(DOUBLE - 1), ..shortest }, value);
            self.compare_with_single(Digits::parse(&f64::from(single).to_string()), value);
        }
    }

    /// A rounding that coordinates have whatever the others are.
    pub(crate) fn at_least(&mut self, rounding: f64) {
        if rounding.is_finite() {
            self.known = largest(self.known, rounding);
        }
    }

    /// The rounding q of the file's coordinates; 0 where none is seen.
    pub(crate) fn rounding(&self) -> f64 {
        let decimal = if self.any_double { 0.0 } else { self.decimal() };
        // Digits that no other kind explains, in numbers that are f32 all.
        let is_single = self.chance < 1e-3 || decimal == 0.0 && self.beyond_typed >= ENOUGH;
        let single = if self.all_single && is_single { self.largest / f64::from(1 << 24) } else { 0.0 };
        largest(self.known, largest(single, decimal))
    }

    fn decimal(&self) -> f64 {
        let are_most = |having: usize| self.long >= ENOUGH && 5 * having >= 3 * self.long;
        let unit = match (self.decimals, self.fixed) {
            (Some(decimals), _) if are_most(self.with_decimals) => i32::from(decimals),
            (_, Some(Some(fixed))) if fixed >= 5 => i32::from(fixed),
            _ if self.significant > LONG && are_most(self.with_significant) => {
                // `9.99e3` has the exponent 3.
                let exponent =
                    format!("{:e}", self.largest).rsplit_once('e').and_then(|(_, exponent)| exponent.parse::<i32>().ok());
                i32::from(self.significant) - 1 - exponent.unwrap_or(0)
            }
            _ => return 0.0,
        };
        0.5 * power_of_ten(-unit)
    }

    /// Whether a number is not zero, and not one of those before it.
    fn is_new(&mut self, value: f64) -> bool {
        let size = value.abs();
        if size == 0.0 || !size.is_finite() {
            return false;
        }
        self.largest = largest(self.largest, size);
        self.distinct.len() >= DISTINCT || self.distinct.insert(size.to_bits())
    }

    fn count(&mut self, digits: Digits, value: f64) {
        let is_single = f64::from(to_single(value)) == value;
        self.any_double |= digits.significant >= DOUBLE && !is_single;
        let long = usize::from(digits.significant >= LONG);
        self.long += long;
        self.beyond_typed += usize::from(digits.significant > TYPED);
        if self.decimals.is_none_or(|most| digits.decimals > most) {
            (self.decimals, self.with_decimals) = (Some(digits.decimals), 0);
        }
        if self.decimals == Some(digits.decimals) {
            self.with_decimals += long;
        }
        if digits.significant > self.significant {
            (self.significant, self.with_significant) = (digits.significant, 0);
        }
        if self.significant == digits.significant {
            self.with_significant += long;
        }
    }

    fn compare_with_single(&mut self, digits: Digits, value: f64) {
        let single = to_single(value);
        let unit = power_of_ten(-i32::from(digits.decimals));
        // Half a unit, and the rounding of the difference.
        let is_single = (value - f64::from(single)).abs() <= 0.5 * unit * (1.0 + 1e-6) + value.abs() * f64::EPSILON;
        self.all_single &= single.is_finite() && is_single;
        let distance = f64::from(single.abs().next_up()) - f64::from(single.abs());
        self.chance *= smallest(unit / distance, 1.0);
    }
}

/// Whether a number that is read as a double is likely to have been rounded to single precision: it has more digits than are typed,
/// and is an f32 or has fewer digits than doubles have.
pub(crate) fn seems_single(value: f64) -> bool {
    let Digits { significant, .. } = Digits::parse(&value.to_string());
    significant > TYPED && (significant < DOUBLE || f64::from(to_single(value)) == value)
}

/// The f32 next to a number.
#[expect(clippy::cast_possible_truncation, reason = "rounding is meant, and casts saturate to infinity")]
const fn to_single(value: f64) -> f32 {
    value as f32
}

/// A power of ten, rounded once.
fn power_of_ten(power: i32) -> f64 {
    format!("1e{power}").parse().unwrap_or(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rounding<T: AsRef<str>>(texts: impl IntoIterator<Item = T>) -> f64 {
        let mut precision = WrittenPrecision::new();
        let mut add = |text: &str| precision.add(Written::Text(Digits::parse(text)), text.parse().unwrap());
        texts.into_iter().for_each(|text| add(text.as_ref()));
        precision.rounding()
    }

    /// Numbers with random digits from 0 to `size`.
    fn random(size: f64) -> impl Iterator<Item = f64> {
        (1..60).map(move |index| size * (f64::from(index) * 0.618_033_988_749_894_9).fract())
    }

    #[test]
    fn digits_are_counted_without_zeros_at_either_end() {
        let digits = |text: &str| {
            let Digits { significant, decimals, fixed } = Digits::parse(text);
            (significant, decimals, fixed)
        };
        assert_eq!((digits("4123"), digits("-1200"), digits("0.0250")), ((4, 0, Some(0)), (2, -2, Some(0)), (2, 3, Some(4))));
        assert_eq!((digits("1.5e-3"), digits("+10.E2"), digits(".5")), ((2, 4, None), (1, -3, None), (1, 1, Some(1))));
        assert_eq!((digits("0.000").0, digits("").0, digits("1e999999999").1), (0, 0, i16::MIN));
    }

    #[test]
    fn few_digits_are_meant_and_many_are_doubles() {
        assert_eq!(rounding(["1", "0.5", "2", "0.25", "552.8", "549.6", "559.2"]), 0.0);
        assert_eq!(rounding(random(5.0).map(|x| x.to_string())), 0.0);
        assert_eq!(rounding(Vec::<String>::new()), 0.0);
        // One double among decimals.
        assert_eq!(rounding(random(5.0).map(|x| format!("{x:.3}")).chain(["0.1234567890123456".to_owned()])), 0.0);
        // Eight numbers and more, of which few use the last decimal.
        assert_eq!(rounding((1000..1100).map(|x| format!("{}.{}", x, if x % 3 == 0 { "5" } else { "0" }))), 0.0);
    }

    #[test]
    fn decimals_are_those_that_most_numbers_use() {
        for (decimals, q) in [(2, 5e-3), (3, 5e-4), (4, 5e-5), (6, 5e-7)] {
            let texts = || random(50.0).map(|x| format!("{x:.decimals$}"));
            // Zeros at the end say nothing.
            let trimmed = texts().map(|text| text.trim_end_matches('0').trim_end_matches('.').to_owned());
            let padded = texts().map(|text| text + "00");
            assert_eq!((rounding(texts()), rounding(trimmed), rounding(padded)), (q, q, q), "{decimals}");
        }
        assert_eq!(rounding(random(9000.0).map(|x| format!("{x:.0}"))), 0.5);
        assert_eq!(rounding(random(9e5).map(|x| format!("{:.0}0", x / 10.0))), 5.0);
        assert_eq!(rounding(random(50.0).take(6).map(|x| format!("{x:.3}"))), 0.0, "too few");
    }

    #[test]
    fn a_fixed_number_of_decimals_is_a_rounding_even_of_few_numbers() {
        assert_eq!(rounding(["1.000000", "0.500000", "0.000000"]), 5e-7);
        assert_eq!(rounding(["1.000000", "0.5", "0.000000"]), 0.0);
        assert_eq!(rounding(["1.0000", "0.5000"]), 0.0);
    }

    #[test]
    fn significant_digits_round_by_the_largest() {
        let rounded = |x: f64, digits: usize| format!("{x:.digits$e}").parse::<f64>().unwrap().to_string();
        let q = rounding(random(1.0).enumerate().map(|(index, x)| rounded(x * [1.0, 10.0, 100.0][index % 3], 5)));
        assert_eq!(q, 5e-5, "six digits of up to 99.9999");
    }

    #[test]
    fn single_precision_is_seen_in_every_print_of_it() {
        let singles = || random(5700.0).map(|x| f64::from(to_single(x)));
        let largest = singles().fold(0.0, largest);
        let q = largest / 16_777_216.0;
        let prints: [fn(f64) -> String; 4] =
            [|x| x.to_string(), |x| (to_single(x)).to_string(), |x| format!("{x:.8e}"), |x| format!("{x:.6}")];
        for print in prints {
            let computed = rounding(singles().map(print));
            assert!((computed - q).abs() < 1e-8 * q, "{computed:e} of {q:e}, {}", print(largest));
        }
        // Where their distance is about a unit of the third decimal: a few need a fourth.
        let far: Vec<String> = (1..16_u16).map(|index| (10_000.0 + f32::from(index) * 60.0 / 7.0).to_string()).collect();
        assert_eq!(rounding(&far), 5e-4, "three decimals explain these");
        let far = far.into_iter().chain(["10000.0205".to_owned()]);
        assert!((rounding(far) * 16_777_216.0 - 10_128.571).abs() < 1e-2);
        // One that is none.
        assert_eq!(rounding(singles().map(|x| x.to_string()).chain(["0.1".to_owned(), "0.12345678912".to_owned()])), 0.0);
        let wall = ["7200", "5600", "2", "7207.41162", "5605.10596", "3.22960377", "12"];
        assert_eq!(rounding(wall), 7207.41162 / 16_777_216.0);
    }

    #[test]
    fn four_bytes_are_rounded_where_their_value_is_no_short_decimal() {
        let precision_of = |values: &[f32]| {
            let mut precision = WrittenPrecision::new();
            values.iter().for_each(|&value| precision.add(Written::Single, f64::from(value)));
            precision.rounding()
        };
        assert_eq!(precision_of(&[0.0, 1.0, 0.5, -2.25, 4123.0]), 0.0);
        assert_eq!(precision_of(&[0.0, 1.0, -0.3]), 1.0 / 16_777_216.0);
        let millimetres: Vec<f32> = random(5.0).map(|x| format!("{x:.3}").parse().unwrap()).collect();
        assert_eq!(precision_of(&millimetres), 5e-4, "rounded before");
    }

    #[test]
    fn doubles_of_a_binary_file_are_read_by_their_shortest_text() {
        let mut precision = WrittenPrecision::new();
        random(5.0).for_each(|x| precision.add(Written::Double, format!("{x:.3}").parse().unwrap()));
        assert_eq!(precision.rounding(), 5e-4);
        random(5.0).for_each(|x| precision.add(Written::Double, x));
        assert_eq!(precision.rounding(), 0.0);
        precision.at_least(1e-3);
        precision.at_least(f64::NAN);
        assert_eq!(precision.rounding(), 1e-3);
    }

    #[test]
    fn numbers_of_single_precision_are_told_from_those_typed_and_from_doubles() {
        for value in [0.923_879_5, f64::from(0.923_879_5_f32), 1.234_567] {
            assert!(seems_single(value), "{value}");
        }
        for value in [0.0, 1.0, -0.5, 1234.5, std::f64::consts::FRAC_1_SQRT_2] {
            assert!(!seems_single(value), "{value}");
        }
    }

    #[test]
    fn values_out_of_range_are_no_single_precision_and_stop_nothing() {
        assert_eq!(rounding(["1e300", "1e-320", "1e-300", "5e-324"]), 0.0);
        let mut precision = WrittenPrecision::new();
        precision.add(Written::Text(Digits::parse("nan")), f64::NAN);
        precision.add(Written::Single, f64::INFINITY);
        assert_eq!(precision.rounding(), 0.0);
    }
}
