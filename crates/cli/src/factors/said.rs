//! Summaries of factors, as one JSON object or as text.

use std::fmt;

use radgrad_scene::{Factor, FactorMatrix, FactorSettings, FormFactors, Repaired, largest};
use serde::Serialize;

/// The summary of a matrix.
#[derive(Debug, Serialize)]
pub(super) struct Summary {
    faces: usize,
    surfaces: usize,
    factors: usize,
    past_occluders: usize,
    seconds: f64,
    tolerance: f64,
    relative: f64,
    unmet: usize,
    worst_closure: f64,
    rows_that_cannot_close: usize,
    worst_reciprocity: f64,
    worst_bound: f64,
    worst_bound_in_free_sight: f64,
    warnings: Vec<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    repaired: Option<Repair>,
}

/// The effect of a repair.
#[derive(Debug, Serialize)]
struct Repair {
    largest: f64,
    mean: f64,
    closure_before: f64,
    closure: f64,
    from: usize,
    to: usize,
}

impl Summary {
    pub(super) fn of(
        factors: &FormFactors<'_>,
        matrix: &FactorMatrix,
        settings: &FactorSettings,
        repaired: Option<Repaired>,
        seconds: f64,
    ) -> Self {
        let in_free_sight = matrix.entries().filter(|(_, entry)| entry.occluders == 0);
        let repaired = repaired.map(|Repaired { largest, mean, pair: [from, to], closure_before, closure }| Repair {
            largest,
            mean,
            closure_before,
            closure,
            from,
            to,
        });
        Self {
            faces: matrix.faces().len(),
            surfaces: factors.scene().surfaces().len(),
            factors: matrix.entries().count(),
            past_occluders: matrix.entries().filter(|(_, entry)| entry.occluders > 0).count(),
            seconds,
            tolerance: settings.tolerance,
            relative: settings.relative,
            unmet: matrix.unmet(settings).count(),
            worst_closure: matrix.worst_closure(),
            rows_that_cannot_close: matrix.unclosed().count(),
            worst_reciprocity: matrix.worst_reciprocity(),
            worst_bound: matrix.worst_bound(),
            worst_bound_in_free_sight: in_free_sight.map(|(_, entry)| entry.error).fold(0.0, largest),
            warnings: factors.warnings().map(ToString::to_string).collect(),
            repaired,
        }
    }
}

impl fmt::Display for Summary {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let &Self { faces, surfaces, factors, past_occluders, seconds, unmet, .. } = self;
        writeln!(
            f,
            "{faces} faces of {surfaces} surfaces, {factors} factors, {past_occluders} of them past occluders, in {seconds:.3} s"
        )?;
        let (closure, never) = (self.worst_closure, self.rows_that_cannot_close);
        writeln!(
            f,
            "worst closure       {closure:.1e}   (largest |1 - sum of a row|); {never} rows cannot be closed within their bounds"
        )?;
        let reciprocity = self.worst_reciprocity;
        writeln!(f, "worst reciprocity   {reciprocity:.1e}   (largest |A_i F_ij - A_j F_ji| over the smaller of the two areas)")?;
        let (bound, in_free_sight, asked) = (self.worst_bound, self.worst_bound_in_free_sight, self.tolerance);
        write!(
            f,
            "worst bound         {bound:.1e}   (in free sight {in_free_sight:.1e}); {unmet} of {factors} are over {asked}"
        )?;
        if self.relative > 0.0 {
            write!(f, " or {} of the factor", self.relative)?;
        }
        if let Some(Repair { largest, mean, closure_before, closure, from, to }) = self.repaired {
            write!(
                f,
                "\nrepaired            {largest:.1e}   (largest change, from {from} to {to}; {mean:.1e} in the mean)\n\
                 closure             {closure_before:.1e} before, {closure:.1e} after"
            )?;
        }
        Ok(())
    }
}

/// The summary of one factor between surfaces.
#[derive(Debug, Serialize)]
pub(super) struct OneFactor<'a> {
    from: &'a str,
    to: &'a str,
    factor: f64,
    lower: f64,
    upper: f64,
    error: f64,
    estimate: f64,
    occluders: usize,
    seconds: f64,
    #[serde(skip)]
    digits: u8,
}

impl<'a> OneFactor<'a> {
    pub(super) const fn of(found: Factor, [from, to]: [&'a str; 2], digits: u8, seconds: f64) -> Self {
        let Factor { value: factor, lower, upper, error, estimate, occluders } = found;
        Self { from, to, factor, lower, upper, error, estimate, occluders, seconds, digits }
    }
}

impl fmt::Display for OneFactor<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let &Self { from, to, factor, lower, upper, estimate, digits, .. } = self;
        let places = usize::from(digits).max(2) - 1;
        let how = if self.occluders == 0 { "proven, in free sight" } else { "estimated: the difference of two rules" };
        writeln!(f, "from {from} to {to}: {factor:.places$e}")?;
        writeln!(f, "off by about        {estimate:.1e}   ({how})")?;
        write!(f, "proven bracket      [{lower}, {upper}]")
    }
}
