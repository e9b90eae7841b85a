//! Lemmas that stay on paper, and the reasons.

use crate::summary::with_header;

const ON_PAPER: &[[&str; 2]] = &[
    [
        "errors of the polynomials of arc tangent, logarithm, psi and J",
        "of functions that gappa does not know; by Remez's algorithm, with 120 digits; hypotheses",
    ],
    ["underflow", "relative roundings have none; the code bounds nothing below its least moment"],
    [
        "the vector of the sums of sizes of r x e is at most (4/3)^(1/2) |r||e| long; |r.s| <= |r||s|",
        "inequalities between lengths, with no rounding in them",
    ],
    [
        "a difference errs by no more than the sum of the sizes does",
        "monomials, for all programs (script.rs); gappa has the program of sizes",
    ],
    [
        "errors are convex in those given, so that corners suffice",
        "power series with coefficients that are not negative (lemma.rs)",
    ],
    ["sin g <= min(g, 1), and what ew across N turns", "functions of an angle; geometry"],
    ["what a crossing point's displacement along its edge does; arcs of the horizon", "an area and a slope, second order"],
    ["psi' <= 0.11 and psi |c' - c| <= g^2/12", "derivatives of functions of an angle"],
    [
        "weights past a quarter turn; totals; the linear emitter but for J and an edge's weight",
        "not recorded; as derived in their modules' heads",
    ],
    [
        "batches, Gauss rules, double-double, arbitrary precision",
        "their own derivations, running bounds, and the crates astro-float and robust",
    ],
];

/// As `prove` prints it.
pub(crate) fn table() -> String {
    let mut table = with_header(&["on paper", "why"]);
    for row in ON_PAPER {
        table.add_row(row.to_vec());
    }
    table.to_string()
}
