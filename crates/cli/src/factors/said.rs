//! The summary of factors, as one JSON object or as text.

use std::fmt;

use radgrad_scene::{FactorMatrix, FactorSettings, FormFactors, Modelling, Repaired, largest, printable};
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
    worst_rows: Vec<Row>,
    worst_reciprocity: f64,
    worst_bound: f64,
    worst_bound_in_free_sight: f64,
    modelling: Modelling,
    /// The largest part of a bound that the rounding of coordinates takes.
    worst_modelling: f64,
    warnings: Vec<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    repaired: Option<Repair>,
}

/// A row that cannot be closed within its bounds.
#[derive(Debug, Serialize)]
struct Row {
    face: usize,
    surface: String,
    sum: f64,
    /// One less the sum: what no face is seen in, below 0 where too much is seen.
    missing: f64,
    /// As much of that as the bounds of its factors explain.
    bounds: f64,
}

/// Rows that are named.
const WORST: usize = 3;

impl Row {
    /// Those that are farthest from closing.
    fn worst(factors: &FormFactors<'_>, matrix: &FactorMatrix) -> Vec<Self> {
        let scene = factors.scene();
        let of = |face: usize| {
            let sum = matrix.sum(face);
            let missing = 1.0 - sum.factor;
            let bounds = if missing > 0.0 { sum.upper - sum.factor } else { sum.factor - sum.lower };
            let surface = scene.surfaces()[scene.faces()[face].surface()].name().to_owned();
            Self { face, surface, sum: sum.factor, missing, bounds }
        };
        let mut rows: Vec<Self> = matrix.unclosed().map(of).collect();
        rows.sort_by(|a, b| (b.missing.abs() - b.bounds).total_cmp(&(a.missing.abs() - a.bounds)));
        rows.truncate(WORST);
        rows
    }
}

impl fmt::Display for Row {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { face, surface, sum, missing, bounds } = self;
        let what = if *missing < 0.0 { "is too much" } else { "is missing" };
        let [missing, bounds] = [missing.abs(), *bounds].map(share);
        write!(f, "row of face {face} (`{}`): {sum:.4}, {missing} {what}: its bounds explain {bounds}", printable(surface))
    }
}

/// A share of a view as people read it.
fn share(share: f64) -> String {
    if share == 0.0 || share >= 1e-3 { format!("{share:.4}") } else { format!("{share:.1e}") }
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
            worst_rows: Row::worst(factors, matrix),
            worst_reciprocity: matrix.worst_reciprocity(),
            worst_bound: matrix.worst_bound(),
            worst_bound_in_free_sight: in_free_sight.map(|(_, entry)| entry.error).fold(0.0, largest),
            modelling: factors.scene().modelling(),
            worst_modelling: matrix.entries().map(|(_, entry)| entry.modelling).fold(0.0, largest),
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
        self.worst_rows.iter().try_for_each(|row| writeln!(f, "  {row}"))?;
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
        if self.worst_modelling > 0.0 {
            let (part, precision) = (self.worst_modelling, self.modelling.precision);
            write!(f, "\nof that, rounding   {part:.1e}   (coordinates are off by up to {precision:.1e}; no effort narrows it)")?;
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
