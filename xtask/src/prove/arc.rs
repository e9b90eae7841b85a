//! The steps of the constant emitter's bound (`crates/core/src/forms/constant_bound.rs`) on one arc, in their order. A result
//! that a step takes from one above it is a hypothesis of as many units as core has for that.
//!
//! | symbol | meaning |
//! |---|---|
//! | r, s | ends of the arc, as seen from the receiver: each component is a difference of two doubles, rounded once |
//! | e, w | the edge, and its moment `r x e` |
//! | q, c | `1/|r|` and `n1.r/|r|` |
//! | g | angle of the arc |
//! | ew, eta | relative errors of w and of the place of a crossing point |

use radgrad_core::closed_forms::{self as forms, MOMENT_UNITS, units};

use crate::prove::lemma::{Case, Displaced, Lemma, Stated, U};
use crate::prove::script::{Known, Rounding, Script, computed};
use crate::prove::tape::{Recorded, Tape};

/// In the order of the derivation.
pub(crate) const LEMMAS: &[Lemma] = &[
    Lemma::new(
        "w: products",
        units::PRODUCTS_OF_MOMENT,
        products_of_moment,
        "a component of r x e before its last rounding, in u of the sum of the sizes of its products",
    ),
    Lemma::new(
        "w",
        MOMENT_UNITS[0],
        moment,
        "r x e before its last rounding, in u of |r||e|; of sizes, the vector of those sums is at most (4/3)^(1/2) |r||e| long",
    ),
    Lemma::new("|w|", units::MOMENT, length_of_moment, "in u, relative, beside ew"),
    Lemma::new("1/|w|", units::INVERSE_MOMENT, inverse_moment, "in u, relative, beside ew"),
    Lemma::new("N", 1.0, normal, "a component, in u, relative, beside what 1/|w| is off by: for its product"),
    Lemma::new("1/S", units::NEARNESS, nearness, "one over the distance of the line, in u, relative, beside ew"),
    Lemma::new("q", units::INVERSE_DISTANCE, inverse_distance, "in u, relative, beside eta"),
    Lemma::new(
        "inline",
        units::INLINE,
        inline,
        "r.s, in u of the sum of the sizes of its products, which is at most |r||s|; beside 2 eta",
    ),
    Lemma::new(
        "across",
        units::FRACTION,
        across,
        "|r x s| of a cut edge, in u, relative, beside ew and the rounding of |w|: for the product with its fraction",
    ),
    Lemma::new(
        "angle",
        units::ANGLE,
        angle,
        "sine of the angle between (inline, across) and the exact point, in u of sin g, beside ew, 2 eta and the fraction",
    ),
    Lemma::new("g N", units::PRODUCTS, term, "a component, in u, relative, beside dg, ew and 1/|w|: for the products"),
    Lemma::new("c", units::COSINE, cosine, "in u of its size, beside 5u of 1 from its product with n1, and 2 eta"),
    Lemma::new("sin g", units::SINE, sine, "in u, relative, beside ew, 2 eta and the fraction"),
    Lemma::new("1 + cos g", units::ONE_AND_COSINE, one_and_cosine, "up to a quarter turn, in u, relative, beside 4 eta"),
    Lemma::new(
        "c + c'",
        units::COSINES[0],
        sum_of_cosines,
        "in u of 1, beside what goes with their sizes, and 4 eta; c' - c likewise",
    ),
    Lemma::new("c + c', by size", units::COSINES[1], sizes_of_cosines, "in u of the sum of their sizes, beside 10u and 4 eta"),
    Lemma::new(
        "weight: chi",
        units::CHI_TERM,
        chi_term,
        "its first term for given g + sin g and c + c', in u, relative, beside 5 eta",
    ),
    Lemma::new(
        "weight: psi",
        units::PSI_TERM,
        psi_term,
        "its second term for given g and c' - c, in u of Q g^2, beside 0.091 eta",
    ),
    Lemma::new("weight", units::WEIGHT, weight_and_normal, "its sum and product with N, in u, relative, beside ew"),
    Lemma::new(
        "linear weight: chi",
        forms::LINEAR_CHI_TERM,
        linear_chi_term,
        "a linear emitter's first term for given p, g + sin g and c + c', in u, relative",
    ),
    Lemma::new(
        "linear weight: psi",
        forms::LINEAR_PSI_TERM,
        linear_psi_term,
        "a linear emitter's second term for given p, g and c' - c, in u, relative",
    ),
];

/// Vectors of no meaning: the paths do not depend on them.
const R: [f64; 3] = [0.5, 0.25, 0.75];
const S: [f64; 3] = [0.25, 0.75, 0.5];

fn one(script: &Script<'_>) -> Vec<Case> {
    vec![Case { name: String::new(), script: script.write() }]
}

/// On the relative error of a number in the program of sizes, given the errors of others.
fn of_sizes<'t>(tape: &'t Tape, number: Recorded<'t>, most: f64, known: &[(&[Recorded<'t>], Known)]) -> Script<'t> {
    let mut script = Script::of_sizes(tape);
    for (numbers, known) in known {
        script.know_all(numbers.iter().copied(), *known);
    }
    script.relative_error(number, most);
    script
}

/// The error of a component before its last rounding, of the sizes of its products, as a name of the script.
fn component_of_moment<'t>(tape: &'t Tape) -> Script<'t> {
    let [r, e] = [tape.inputs(R), tape.inputs(S)];
    let [x, ..] = forms::cross(r, e);
    let mut script = Script::of_sizes(tape);
    script.know_all(r.into_iter().chain(e), Known::Relative(U));
    script.use_all(x);
    let ([a, b], exact) = (x.operands().map(computed), script.exact(x));
    script.define("error", &format!("(({a} + {b}) - {exact}) / {exact}"));
    script
}

fn products_of_moment(stated: &Stated) -> Vec<Case> {
    let tape = Tape::default();
    let mut script = component_of_moment(&tape);
    script.within("error", stated.units_and(0.0));
    one(&script)
}

fn moment(stated: &Stated) -> Vec<Case> {
    let tape = Tape::default();
    let mut script = component_of_moment(&tape);
    script.define("error_of_vector", "error * sqrt(4 / 3)");
    script.within("error_of_vector", stated.units_and(0.0));
    one(&script)
}

fn length_of_moment(stated: &Stated) -> Vec<Case> {
    let tape = Tape::default();
    let (length, ..) = forms::line(tape.inputs(R), tape.inputs(S));
    let mut script = of_sizes(&tape, length, stated.units_and(0.0), &[]);
    script.range(length.operand(), [1.0; 2]);
    one(&script)
}

fn inverse_moment(stated: &Stated) -> Vec<Case> {
    let tape = Tape::default();
    let (length, [x, ..], _) = forms::line(tape.inputs(R), tape.inputs(S));
    let [_, inverse] = x.operands();
    let given = [(&[length][..], Known::Relative(units::MOMENT * U))];
    let mut script = of_sizes(&tape, inverse, stated.units_and(0.0), &given);
    script.range(length, [1.0; 2]);
    one(&script)
}

fn normal(stated: &Stated) -> Vec<Case> {
    let tape = Tape::default();
    let (_, [x, ..], _) = forms::line(tape.inputs(R), tape.inputs(S));
    let [_, inverse] = x.operands();
    one(&of_sizes(&tape, x, stated.units_and(0.0), &[(&[inverse], Known::Exact)]))
}

fn nearness(stated: &Stated) -> Vec<Case> {
    let tape = Tape::default();
    let e = tape.inputs(R);
    let (_, _, nearness) = forms::line(e, tape.inputs(S));
    let [length, inverse] = nearness.operands();
    let given = [(&e[..], Known::Relative(U)), (&[inverse], Known::Relative(units::INVERSE_MOMENT * U))];
    let mut script = of_sizes(&tape, nearness, stated.units_and(0.0), &given);
    script.range(length.operand(), [1.0; 2]);
    one(&script)
}

fn inverse_distance(stated: &Stated) -> Vec<Case> {
    let tape = Tape::default();
    let r = tape.inputs(R);
    let [q, _] = forms::sighted(r, tape.inputs(S));
    let [_, distance] = q.operands();
    let mut script = of_sizes(&tape, q, stated.units_and(0.0), &[(&r, Known::Relative(U))]);
    script.range(distance.operand(), [1.0; 2]);
    one(&script)
}

fn inline(stated: &Stated) -> Vec<Case> {
    let tape = Tape::default();
    let vectors @ [r, s, ..] = [R, S, R, S].map(|vector| tape.inputs(vector));
    let [inline, _] = forms::inline_and_across(vectors, tape.input(1.0));
    let given = [(&r[..], Known::Relative(U)), (&s[..], Known::Relative(U))];
    one(&of_sizes(&tape, inline, stated.units_and(0.0), &given))
}

fn across(stated: &Stated) -> Vec<Case> {
    let tape = Tape::default();
    let vectors = [R, S, R, S].map(|vector| tape.inputs(vector));
    let [_, across] = forms::inline_and_across(vectors, tape.input(0.5));
    let [_, moment] = across.operands();
    one(&of_sizes(&tape, across, stated.units_and(0.0), &[(&[moment], Known::Exact)]))
}

/// `(x, y)` is `(cos g, sin g)` where `|r||s| = 1`.
fn angle(stated: &Stated) -> Vec<Case> {
    let case = |displaced: Displaced| {
        let tape = Tape::default();
        let vectors = [R, S, R, S].map(|vector| tape.inputs(vector));
        let [x, y] = forms::inline_and_across(vectors, tape.input(1.0));
        let mut script = Script::new(&tape, Rounding::Relative);
        script.know(x, Known::Absolute(units::INLINE * U + 2.0 * displaced.eta));
        script.know(y, Known::Relative(units::MOMENT * U + displaced.ew));
        script.range(x, [-1.0, 1.0]);
        script.range(y, [0.0, 1.0]);
        let [cx, cy, ex, ey] = [computed(x), computed(y), script.exact(x), script.exact(y)];
        // The product of the two points over sin g.
        script.define("turned", &format!("(({cy} * {ex}) - ({cx} * {ey})) / {ey}"));
        script.hint(&format!("turned -> {ex} * (({cy} - {ey}) / {ey}) - ({cx} - {ex}) {{ {ey} <> 0 }}"));
        script.within("turned", stated.units_and(displaced.ew + 2.0 * displaced.eta));
        displaced.case("", &script)
    };
    Displaced::corners().map(case).collect()
}

/// `n1.(g N)` where the angle and `1/|w|` are given.
fn term(stated: &Stated) -> Vec<Case> {
    let tape = Tape::default();
    let (_, [x, ..], _) = forms::line(tape.inputs(R), tape.inputs(S));
    let [_, inverse] = x.operands();
    let product = x * tape.input(0.5);
    one(&of_sizes(&tape, product, stated.units_and(0.0), &[(&[inverse], Known::Exact)]))
}

fn cosine(stated: &Stated) -> Vec<Case> {
    let tape = Tape::default();
    let [_, c] = forms::sighted(tape.inputs(R), tape.inputs(S));
    let [product, inverse] = c.operands();
    let given = [(&[product][..], Known::Exact), (&[inverse], Known::Relative(units::INVERSE_DISTANCE * U))];
    one(&of_sizes(&tape, c, stated.units_and(0.0), &given))
}

/// The weight of an arc up to a quarter turn, taken apart: `chi (q + q')(c + c') + psi (q' - q)(c' - c)`.
struct Weight<'t> {
    weight: Recorded<'t>,
    across: Recorded<'t>,
    inline: Recorded<'t>,
    /// One over the distances of the ends.
    inverse: [Recorded<'t>; 2],
    /// In the place of q, `1/|r|` or a linear emitter's counterpart of it.
    q: [Recorded<'t>; 2],
    c: [Recorded<'t>; 2],
    angle: Recorded<'t>,
    sine: Recorded<'t>,
    one_and_cosine: Recorded<'t>,
    psi: Recorded<'t>,
    /// `c + c'` and `c' - c`.
    cosines: [Recorded<'t>; 2],
    /// The two terms.
    terms: [Recorded<'t>; 2],
}

impl<'t> Weight<'t> {
    fn on(tape: &'t Tape) -> Self {
        let [angle, across, inline] = tape.inputs([0.7, 0.4, 0.5]);
        let [inverse, q, c] = [[0.8, 0.9], [0.8, 0.9], [0.3, 0.2]].map(|pair| tape.inputs(pair));
        let weight = forms::weight([angle, across, inline], inverse, q, c);
        let terms = weight.operands();
        let [[chi_q, sum], [psi_q, difference]] = terms.map(Recorded::operands);
        let ([chi, _], [psi, _]) = (chi_q.operands(), psi_q.operands());
        let [numerator, denominator] = chi.operands();
        let ([_, sine], [one_and_cosine, _]) = (numerator.operands(), denominator.operands());
        Self { weight, across, inline, inverse, q, c, angle, sine, one_and_cosine, psi, cosines: [sum, difference], terms }
    }
}

fn sine(stated: &Stated) -> Vec<Case> {
    let case = |displaced: Displaced| {
        let tape = Tape::default();
        let Weight { across, inverse, sine, .. } = Weight::on(&tape);
        let mut script = Script::of_sizes(&tape);
        script.know(across, Known::Relative(units::MOMENT * U + displaced.ew));
        script.know_all(inverse, Known::Relative(units::INVERSE_DISTANCE * U + displaced.eta));
        script.relative_error(sine, stated.units_and(displaced.ew + 2.0 * displaced.eta));
        displaced.case("", &script)
    };
    Displaced::corners().map(case).collect()
}

/// The error is at most a power series in the cosine too, and the bound linear in it: its ends suffice.
fn one_and_cosine(stated: &Stated) -> Vec<Case> {
    let case = |displaced: Displaced, cosine: f64| {
        let tape = Tape::default();
        let Weight { inline, inverse, one_and_cosine, .. } = Weight::on(&tape);
        let mut script = Script::new(&tape, Rounding::Relative);
        script.know(inline, Known::Absolute(units::INLINE * U + 2.0 * displaced.eta));
        script.know_all(inverse, Known::Relative(units::INVERSE_DISTANCE * U + displaced.eta));
        script.use_all(one_and_cosine);
        let (c, e) = (computed(one_and_cosine), script.exact(one_and_cosine));
        script.define("error", &format!("({c} - {e}) / {e}"));
        script.within("error", stated.units_and(4.0 * displaced.eta));
        script.range(inline, [cosine; 2]);
        inverse.into_iter().for_each(|inverse| script.range(inverse, [1.0; 2]));
        displaced.case(&format!(", cos g = {cosine}"), &script)
    };
    Displaced::of_points().flat_map(|displaced| [0.0, 1.0].map(|cosine| case(displaced, cosine))).collect()
}

fn sum_of_cosines(stated: &Stated) -> Vec<Case> {
    Displaced::of_points().map(|displaced| cosines_at(displaced, [0.0; 2], stated.units_and(4.0 * displaced.eta))).collect()
}

/// The error is at most linear in both sizes, as the bound is: their ends suffice.
fn sizes_of_cosines(stated: &Stated) -> Vec<Case> {
    let case_of_sizes = |displaced: Displaced, sizes: [f64; 2]| {
        let sized = Stated { number: units::COSINES[0] + stated.number * (sizes[0] + sizes[1]), ..*stated };
        cosines_at(displaced, sizes, sized.units_and(4.0 * displaced.eta))
    };
    Displaced::of_points().flat_map(|displaced| [[0.0, 1.0], [1.0, 1.0]].map(|sizes| case_of_sizes(displaced, sizes))).collect()
}

fn cosines_at(displaced: Displaced, sizes: [f64; 2], most: f64) -> Case {
    let tape = Tape::default();
    let Weight { c, cosines: [sum, _], .. } = Weight::on(&tape);
    let mut script = Script::of_sizes(&tape);
    for (cosine, size) in c.into_iter().zip(sizes) {
        script.know(cosine, Known::Absolute((units::INLINE + units::COSINE * size) * U + 2.0 * displaced.eta));
        script.range(cosine, [size; 2]);
    }
    script.use_all(sum);
    let error = format!("{} - {}", computed(sum), script.exact(sum));
    script.within(&error, most);
    displaced.case(&format!(", |c| = {}, |c'| = {}", sizes[0], sizes[1]), &script)
}

fn chi_term(stated: &Stated) -> Vec<Case> {
    let case = |displaced: Displaced| {
        let of_q = Known::Relative(units::INVERSE_DISTANCE * U + displaced.eta);
        displaced.case("", &chi(&Tape::default(), displaced, of_q, stated.units_and(5.0 * displaced.eta)))
    };
    Displaced::of_points().map(case).collect()
}

fn linear_chi_term(stated: &Stated) -> Vec<Case> {
    one(&chi(&Tape::default(), Displaced::NOT, Known::Exact, stated.units_and(0.0)))
}

fn chi(tape: &Tape, displaced: Displaced, of_q: Known, most: f64) -> Script<'_> {
    let Weight { angle, sine, one_and_cosine, q, cosines: [sum, _], terms: [term, _], .. } = Weight::on(tape);
    let of_cosine = Known::Relative(units::ONE_AND_COSINE * U + 4.0 * displaced.eta);
    of_sizes(tape, term, most, &[(&[angle, sine, sum], Known::Exact), (&[one_and_cosine], of_cosine), (&q, of_q)])
}

fn psi_term(stated: &Stated) -> Vec<Case> {
    let case = |displaced: Displaced| {
        let of_q = Known::Relative(units::INVERSE_DISTANCE * U + displaced.eta);
        // `psi |c' - c|` is at most `g^2/12`.
        let bound = 12.0 * stated.units_and(units::LARGEST_PSI * displaced.eta);
        displaced.case("", &psi(&Tape::default(), of_q, bound))
    };
    Displaced::of_points().map(case).collect()
}

fn linear_psi_term(stated: &Stated) -> Vec<Case> {
    one(&psi(&Tape::default(), Known::Exact, stated.units_and(0.0)))
}

fn psi(tape: &Tape, of_q: Known, most: f64) -> Script<'_> {
    let Weight { psi, q, cosines: [_, difference], terms: [_, term], .. } = Weight::on(tape);
    of_sizes(tape, term, most, &[(&[difference], Known::Exact), (&[psi], Known::Relative(units::PSI * U)), (&q, of_q)])
}

fn weight_and_normal(stated: &Stated) -> Vec<Case> {
    let tape = Tape::default();
    let Weight { weight, terms, .. } = Weight::on(&tape);
    let (_, [x, ..], _) = forms::line(tape.inputs(R), tape.inputs(S));
    let [_, inverse] = x.operands();
    let given = [(&terms[..], Known::Exact), (&[inverse], Known::Relative(units::INVERSE_MOMENT * U))];
    one(&of_sizes(&tape, x * weight, stated.units_and(0.0), &given))
}
