//! The functions on doubles: arc tangent, logarithm and the odd series. Their polynomials' own errors, which Remez's algorithm gives
//! with many digits, are hypotheses; but for the series of the sine, whose truth is an alternating series.
//!
//! | symbol | meaning |
//! |---|---|
//! | truth | the function at the exact argument |
//! | tau, rho | errors of polynomial and table over their bounds, from -1 to 1 |

use radgrad_core::closed_forms::{
    self as forms, ARC_TANGENT_TRUNCATION, CLAUSEN_TRUNCATION, LOGARITHM_TRUNCATION, SINE_REST, units,
};

use crate::prove::lemma::{Case, Lemma, Stated, U};
use crate::prove::script::{Known, Rounding, Script, computed, exactly};
use crate::prove::tape::{Recorded, Step, Tape};

pub(crate) const LEMMAS: &[Lemma] = &[
    Lemma::new(
        "arc tangent",
        forms::ARC_TANGENT_UNITS,
        arc_tangent,
        "in u, relative; each octant and each of the three reductions",
    )
    .with_coefficient(),
    Lemma::new(
        "logarithm",
        forms::LOGARITHM_UNITS,
        logarithm,
        "in u, relative; the exponent 0 with either half of the mantissas, positive, negative",
    )
    .with_coefficient(),
    Lemma::new("sine series", SINE_REST[0], sine_series, "its coefficients and what it leaves out, in u of 1").with_coefficient(),
    Lemma::new("psi", units::PSI, psi, "in u, relative, up to a quarter turn").with_coefficient(),
    Lemma::new("psi/g", units::LARGEST_PSI, largest_psi, "its largest value up to a quarter turn"),
    Lemma::new(
        "J",
        forms::CLAUSEN_UNITS,
        clausen,
        "the linear emitter's special function over x^3, and two products with x, in u, relative, up to pi/2",
    )
    .with_coefficient(),
];

/// A little more than a quarter turn.
const QUARTER: f64 = std::f64::consts::FRAC_PI_2 * (1.0 + 8.0 * U);

/// Below, powers of a double may underflow: the quotients that a function is a series of are 0 or at least this.
const SMALL: f64 = 1e-90;

/// The constants of a program from one step on.
fn constants(tape: &Tape, from: usize) -> Vec<usize> {
    (from..tape.len()).filter(|place| matches!(tape.step(*place), Step::Constant(_))).collect()
}

fn arc_tangent(stated: &Stated) -> Vec<Case> {
    let reductions = [(0.0, [SMALL, 0.25]), (0.5, [0.25, 0.75 + 4.0 * U]), (1.0, [0.75 - 4.0 * U, 1.0])];
    let octants = [(false, false), (false, true), (true, false), (true, true)];
    let paths = octants.into_iter().flat_map(|octant| reductions.into_iter().map(move |reduction| (octant, reduction)));
    paths.map(|(octant, reduction)| arc_tangent_on(stated, octant, reduction)).collect()
}

/// On the path where the ratio of the smaller coordinate to the larger one is in a range, c that of the reduction.
fn arc_tangent_on(stated: &Stated, (steep, left): (bool, bool), (c, ratios): (f64, [f64; 2])) -> Case {
    let tape = Tape::default();
    let [low, high] = [1.5 * 0.5 * (ratios[0] + ratios[1]), 1.5];
    let [y, x] = tape.inputs(if steep { [high, low] } else { [low, high] });
    let x = if left { -x } else { x };
    let angle = forms::arc_tangent(y, x);
    let run = tape.recorded(x.place + 1);
    let [small, large] = if steep { [run, y] } else { [y, run] };
    let [from, s_and_rest] = angle.operands();
    let [s, _] = s_and_rest.operands();
    let quotient = if steep != left { s.operand() } else { s };
    let coefficients = constants(&tape, s.place);

    let mut script = Script::new(&tape, Rounding::Binary64);
    script.alter(coefficients[0], stated.coefficient);
    script.use_all(angle);
    script.range(large, [1.0, 2.0]);
    script.define("ratio", &format!("{} / {}", script.exact(small), script.exact(large)));
    script.assume(format!("ratio in [{},{}]", exactly(ratios[0]), exactly(ratios[1])));
    let es = script.exact(quotient);
    script.assume(format!("|{es}| in [{},1]", exactly(SMALL)));
    let is_table_exact = tape.step(from.place) == Step::Constant(0.0);
    let remainders = [(es.as_str(), ARC_TANGENT_TRUNCATION[0]), ("1", ARC_TANGENT_TRUNCATION[1])];
    script.known_to(if is_table_exact { &remainders[..1] } else { &remainders });
    script.error_with_rest(angle, stated.number * U);

    let [[cn, en], [cd, ed]] = quotient.operands().map(|part| [computed(part), script.exact(part)]);
    let [small, large, c] = [computed(small), script.exact(large), exactly(c)];
    script.hint(&format!("{cn} / {cd} ~ {es}"));
    script.hint(&format!("{small} -> ratio * {large} {{ {large} <> 0 }}"));
    script.hint(&format!("{es} -> (ratio - {c}) / (1 + {c} * ratio) {{ {large} <> 0, {ed} <> 0, 1 + {c} * ratio <> 0 }}"));
    script.hint(&format!("{en} -> {large} * (ratio - {c}) {{ {large} <> 0 }}"));
    script.hint(&format!("{ed} -> {large} * (1 + {c} * ratio) {{ {large} <> 0 }}"));
    if is_table_exact {
        // `s + (s s^2) p(s^2)`: the shares of a sum that has no table's angle.
        let [cubic, _] = s_and_rest.operands()[1].operands();
        let [cube, polynomial] = cubic.operands();
        let [sum, cubic, square, polynomial] = [s_and_rest, cubic, cube.operands()[1], polynomial].map(|part| script.exact(part));
        let factors = format!("({square} * {polynomial})");
        script.hint(&format!("{sum} -> {es} * (1 + {factors}) {{ {es} <> 0 }}"));
        script.hint(&format!("{es} / {sum} -> 1 / (1 + {factors}) {{ {es} <> 0, {sum} <> 0 }}"));
        script.hint(&format!("rest / {sum} -> tau * ({es} / {sum}) {{ {sum} <> 0 }}"));
        script.hint(&format!("{cubic} / {es} -> {factors} {{ {es} <> 0 }}"));
    } else {
        script.hint("$ ratio in 16");
    }
    let name = |is, yes: &'static str, no: &'static str| if is { yes } else { no };
    Case { name: format!("{}, {}, c = {c}", name(steep, "steep", "flat"), name(left, "left", "right")), script: script.write() }
}

fn logarithm(stated: &Stated) -> Vec<Case> {
    let paths = [
        ("0, low mantissas", 1.2, [1.0 + 2.0 * U, std::f64::consts::SQRT_2], [0.0; 2]),
        ("0, high mantissas", 0.9, [std::f64::consts::SQRT_2, 2.0 - 2.0 * U], [-1.0; 2]),
        ("above, low mantissas", 4.8, [1.0, std::f64::consts::SQRT_2], [1.0, 1023.0]),
        ("above, high mantissas", 3.6, [std::f64::consts::SQRT_2, 2.0 - 2.0 * U], [0.0, 1023.0]),
        ("below, low mantissas", 0.3, [1.0, std::f64::consts::SQRT_2], [-1022.0, -1.0]),
        ("below, high mantissas", 0.45, [std::f64::consts::SQRT_2, 2.0 - 2.0 * U], [-1022.0, -2.0]),
    ];
    paths
        .into_iter()
        .map(|(name, example, mantissas, exponents)| {
            let tape = Tape::default();
            let x = tape.input(example);
            let logarithm = forms::logarithm(x);
            let [exponent, mantissa] = [tape.recorded(x.place + 1), tape.recorded(x.place + 2)];
            let [high, low] = logarithm.operands();
            let [[k, _], [f, t]] = [high.operands(), low.operands()];
            let [product, _] = t.operands();
            let mut script = Script::new(&tape, Rounding::Binary64);
            script.know(exponent, Known::Integer);
            if name.starts_with('0') {
                script.know(k, Known::Zero);
            }
            script.alter(constants(&tape, f.place)[1], stated.coefficient);
            script.use_all(logarithm);
            script.range(mantissa, mantissas);
            let [ef, ek] = [f, k].map(|number| script.exact(number));
            // |ln m| is at most 1.19 |f|.
            let remainders = [(ef.as_str(), 1.19 * LOGARITHM_TRUNCATION[0]), (&ek, LOGARITHM_TRUNCATION[1])];
            if name.starts_with('0') {
                script.known_to(&remainders[..1]);
                hint_near_one(&mut script, [logarithm, low, f, product]);
            } else {
                script.range(exponent, exponents);
                script.known_to(&remainders);
            }
            script.error_with_rest(logarithm, stated.number * U);
            Case { name: name.to_owned(), script: script.write() }
        })
        .collect()
}

/// Shares of `f - s (f - 2 z L)` and of its terms, of f: `s = f/(f + 2)`, `z = s^2`.
fn hint_near_one<'t>(script: &mut Script<'t>, [logarithm, low, f, product]: [Recorded<'t>; 4]) {
    let [s, difference] = product.operands();
    let [_, twice] = difference.operands();
    let [series, _] = twice.operands();
    let [_, polynomial] = series.operands();
    let [_, divisor] = s.operands();
    let numbers = [logarithm, low, f, product, s, difference, twice, polynomial, divisor];
    let [logarithm, low, f, t, s, d, twice, l, divisor] = numbers.map(|number| script.exact(number));
    let (inner, outer) = (format!("(2 * {s} * {l} / {divisor})"), format!("({d} / {divisor})"));
    script.hint(&format!("{twice} / {f} -> {inner} {{ {f} <> 0, {divisor} <> 0 }}"));
    for (sum, share) in [(&d, &inner), (&low, &outer)] {
        script.hint(&format!("{sum} -> {f} * (1 - {share}) {{ {divisor} <> 0 }}"));
        script.hint(&format!("{f} / {sum} -> 1 / (1 - {share}) {{ {f} <> 0, {sum} <> 0, {divisor} <> 0 }}"));
    }
    script.hint(&format!("{twice} / {d} -> {inner} / (1 - {inner}) {{ {f} <> 0, {d} <> 0, {divisor} <> 0 }}"));
    script.hint(&format!("{t} / {low} -> {outer} / (1 - {outer}) {{ {f} <> 0, {low} <> 0, {divisor} <> 0 }}"));
    script.hint(&format!("rest / {logarithm} -> tau * ({f} / {low}) {{ {low} <> 0 }}"));
}

/// `(g - sin g)/2g^3 = sum (-1)^k z^k / 2(2k + 3)!`, z from 0 to 1: the remainder is at most its first term.
fn sine_series(stated: &Stated) -> Vec<Case> {
    let tape = Tape::default();
    let z = tape.input(0.5);
    forms::sine_series(z);
    let mut script = Script::new(&tape, Rounding::Relative);
    script.range(z, [0.0, 1.0]);
    let coefficients = constants(&tape, z.place);
    let z = script.exact(z);
    let (mut factorial, mut sum) = (2.0, String::from("left"));
    let mut terms = Vec::new();
    for k in 0..12 {
        let n = f64::from(2 * k + 3);
        factorial *= n * (n - 1.0).max(1.0) / if k == 0 { n - 1.0 } else { 1.0 };
        let sign = if k % 2 == 0 { "" } else { "-" };
        let own = coefficients.get(k as usize).map_or_else(
            || "0".to_owned(),
            |place| match tape.step(*place) {
                Step::Constant(value) => exactly(value * if k == 1 { stated.coefficient } else { 1.0 }),
                _ => unreachable!("a constant"),
            },
        );
        terms.push(format!("({own} - ({sign}1 / {}))", exactly(2.0 * factorial)));
    }
    for term in terms.iter().rev() {
        sum = format!("{term} + {z} * ({sum})");
    }
    script.define("error", &sum);
    script.assume("left in [-1b-80,1b-80]".to_owned());
    script.within("error", stated.number * U);
    vec![Case { name: String::new(), script: script.write() }]
}

/// The polynomial over g is known to so many roundings of 1.
fn psi(stated: &Stated) -> Vec<Case> {
    let tape = Tape::default();
    let g = tape.input(0.7);
    let psi = forms::psi(g);
    let [_, sum] = psi.operands();
    let mut script = Script::new(&tape, Rounding::Binary64);
    script.alter(constants(&tape, g.place)[1], stated.coefficient);
    script.use_all(psi);
    script.range(g, [SMALL, QUARTER]);
    let [g, psi_over_g] = [script.exact(g), script.exact(sum)];
    script.known_to(&[(&g, SINE_REST[1] * U)]);
    script.error_with_rest(psi, stated.number * U);
    let exact = script.exact(psi);
    script.hint(&format!("rest / {exact} -> tau / {psi_over_g} {{ {g} <> 0, {psi_over_g} <> 0 }}"));
    vec![Case { name: String::new(), script: script.write() }]
}

fn clausen(stated: &Stated) -> Vec<Case> {
    let tape = Tape::default();
    let x = tape.input(0.7);
    let square = x * x;
    let j = x * square * forms::clausen_series(square);
    let mut script = Script::new(&tape, Rounding::Binary64);
    script.alter(constants(&tape, square.place)[1], stated.coefficient);
    script.use_all(j);
    script.range(x, [SMALL, QUARTER]);
    let exact = script.exact(j);
    script.known_to(&[(&exact, CLAUSEN_TRUNCATION)]);
    script.error_with_rest(j, stated.number * U);
    script.hint(&format!("rest / {exact} -> tau {{ {exact} <> 0 }}"));
    vec![Case { name: String::new(), script: script.write() }]
}

fn largest_psi(stated: &Stated) -> Vec<Case> {
    let tape = Tape::default();
    let g = tape.input(0.7);
    let [_, sum] = forms::psi(g).operands();
    let mut script = Script::new(&tape, Rounding::Binary64);
    script.use_all(sum);
    script.range(g, [0.0, QUARTER]);
    script.define("largest", &format!("{} + {}", script.exact(sum), exactly(SINE_REST[1] * U)));
    script.within("largest", stated.number);
    vec![Case { name: String::new(), script: script.write() }]
}
