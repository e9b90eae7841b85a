//! More pairs of cells for factors whose bounds are not met, as long as a stated effort lasts.
//!
//! Round by round each pair of faces that is not met is bracketed again with twice the pairs of cells, those nearest to their bounds
//! first, so that the effort meets the most. A round is charged with what it allows, before it is computed: nothing depends on time
//! or on the number of cores. A bracket narrows at best like the inverse of its pairs of cells; a pair that would take more than what is left even so
//! is left as it is, and so is one whose bracket twice the pairs hardly narrowed.

use rayon::prelude::*;

use super::matrix::{FactorMatrix, Pair};
use super::{FactorSettings, FormFactors};
use crate::error::Error;
use crate::extremes::largest as larger;

/// What narrowing took, and what would be left to do.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Narrowed {
    /// Pairs of cells that were allowed beyond those of the settings, of all pairs of faces together.
    pub spent: usize,
    /// Largest number of pairs of cells that one pair of faces was allowed.
    pub most_cells: usize,
    /// That which would meet all bounds, by how brackets narrowed, an extrapolation: 0 where all are met, infinite where a bracket no longer
    /// narrows.
    pub wanted: f64,
}

/// A pair of faces whose bound is not met.
#[derive(Debug, Clone, Copy)]
struct Unmet {
    place: usize,
    /// Pairs of cells that it was allowed.
    cells: usize,
    /// Its bound over what is asked for, and what that was with half the pairs of cells.
    excess: f64,
    before: Option<f64>,
}

/// A bracket that twice the pairs of cells narrow by less than this is not narrowed further: halving cells wins 0.7 at the least.
const HARDLY: f64 = 0.95;

impl Unmet {
    /// Whether a further round may meet it with what is left.
    fn may_be_met(&self, left: usize) -> bool {
        self.narrows() && self.twice() <= left && self.cells as f64 * self.excess <= left as f64
    }

    const fn twice(&self) -> usize {
        self.cells.saturating_mul(2)
    }

    fn narrows(&self) -> bool {
        self.before.is_none_or(|before| self.excess <= HARDLY * before)
    }

    /// Pairs of cells that would meet it if it goes on to narrow as it did, or else like the inverse root.
    fn wanted(&self) -> f64 {
        let halvings = self.before.map_or(0.5, |before| (before / self.excess).log2());
        if self.narrows() { self.cells as f64 * self.excess.powf(1.0 / halvings) } else { f64::INFINITY }
    }
}

impl FormFactors<'_> {
    /// Brackets the factors of a matrix that do not meet `settings` again, with twice the pairs of cells and twice as many again, until
    /// they do or `effort` pairs of cells are spent. The matrix was computed with the same settings. Where all bounds are met in the end, factors are
    /// the same to the last digit whatever rows there are.
    ///
    /// ```
    /// use radgrad_scene::{Degenerate, FactorSettings, FormFactors, Scene};
    /// # let file = concat!(env!("CARGO_MANIFEST_DIR"), "/../../data/scenes/two_blocks.obj");
    /// let scene = Scene::read(file, Degenerate::Refuse)?;
    /// let (factors, settings) = (FormFactors::new(&scene)?, FactorSettings { tolerance: 0.02, most_cells: 50, ..FactorSettings::default() });
    /// let mut matrix = factors.matrix(&settings, || ())?;
    /// assert!(matrix.unmet(&settings).count() > 0);
    /// let narrowed = factors.narrow(&mut matrix, &settings, 1_000_000)?;
    /// assert_eq!((matrix.unmet(&settings).count(), narrowed.wanted), (0, 0.0));
    /// # Ok::<(), radgrad_scene::Error>(())
    /// ```
    ///
    /// # Errors
    /// As [`Self::matrix`], or if the matrix is of another scene.
    pub fn narrow(&self, matrix: &mut FactorMatrix, settings: &FactorSettings, effort: usize) -> Result<Narrowed, Error> {
        if matrix.areas().len() != self.emitters.len() {
            let expected = format!("a matrix of the scene's {} faces", self.emitters.len());
            return Err(Error::expected(expected, format!("one of {}", matrix.areas().len())));
        }
        // Of the factors of a pair that of the smaller face has the larger bound, whether its row is here or not.
        let excess = |pair: &Pair| {
            let of = |face: u32| {
                let factor = pair.known.over(matrix.scaled_areas[face as usize]);
                factor.computed_error() / settings.allowed(factor.lower)
            };
            larger(of(pair.faces[0]), of(pair.faces[1]))
        };
        let mut pairs: Vec<Option<Pair>> = matrix.pairs.iter().copied().map(Some).collect();
        // In free sight, and where a bound is no number, cells change nothing.
        let mut open: Vec<Unmet> = (0..)
            .zip(&matrix.pairs)
            .filter(|(_, pair)| pair.known.occluders > 0)
            .map(|(place, pair)| Unmet { place, cells: settings.most_cells, excess: excess(pair), before: None })
            .filter(|unmet| unmet.excess > 1.0)
            .collect();
        let (mut spent, mut most_cells) = (0, settings.most_cells);
        loop {
            open.sort_by(|a, b| a.excess.total_cmp(&b.excess).then(a.place.cmp(&b.place)));
            let (mut round, mut rest) = (Vec::new(), Vec::new());
            for unmet in open {
                if unmet.may_be_met(effort - spent) {
                    spent += unmet.twice();
                    round.push(unmet);
                } else {
                    rest.push(unmet);
                }
            }
            open = rest;
            if round.is_empty() {
                break;
            }
            let again = |unmet: &Unmet| {
                let Some(pair) = pairs[unmet.place] else { return Ok((*unmet, None)) };
                let cells = unmet.twice();
                let faces = pair.faces.map(|face| face as usize);
                let known = self.pair(faces, &FactorSettings { most_cells: cells, ..*settings })?;
                let pair = known.map(|known| Pair { known, ..pair });
                let excess = pair.as_ref().map_or(0.0, &excess);
                Ok((Unmet { cells, excess, before: Some(unmet.excess), ..*unmet }, pair))
            };
            let found: Vec<(Unmet, Option<Pair>)> = round.par_iter().with_max_len(1).map(again).collect::<Result<_, Error>>()?;
            for (unmet, pair) in found {
                pairs[unmet.place] = pair;
                most_cells = most_cells.max(unmet.cells);
                if unmet.excess > 1.0 {
                    open.push(unmet);
                }
            }
        }
        let wanted = open.iter().map(Unmet::wanted).fold(0.0, larger);
        *matrix = self.of_pairs(matrix.faces().to_vec(), pairs.into_iter().flatten().collect())?;
        Ok(Narrowed { spent, most_cells, wanted })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Degenerate, Scene};

    const ROOM: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../data/scenes/two_blocks.obj");

    #[test]
    fn blocks_are_narrowed_as_the_whole_is() {
        let scene = Scene::read(ROOM, Degenerate::Refuse).unwrap();
        let factors = FormFactors::new(&scene).unwrap();
        let settings = FactorSettings { tolerance: 0.02, most_cells: 50, ..FactorSettings::default() };
        let mut whole = factors.matrix(&settings, || ()).unwrap();
        let before: Vec<(usize, usize)> = whole.unmet(&settings).map(|(from, entry)| (from, entry.face)).collect();
        factors.narrow(&mut whole, &settings, 1_000_000).unwrap();
        assert_eq!((before.is_empty(), whole.unmet(&settings).count()), (false, 0));
        for rows in [0..5, 5..21] {
            let mut block = factors.rows(rows, &settings, || ()).unwrap();
            factors.narrow(&mut block, &settings, 1_000_000).unwrap();
            block.faces().iter().for_each(|&face| assert!(block.row(face).eq(whole.row(face)), "{face}"));
        }
    }

    #[test]
    fn the_effort_is_kept_and_what_is_left_is_extrapolated() {
        let scene = Scene::read(ROOM, Degenerate::Refuse).unwrap();
        let factors = FormFactors::new(&scene).unwrap();
        let settings = FactorSettings { tolerance: 0.01, most_cells: 50, ..FactorSettings::default() };
        let coarse = factors.matrix(&settings, || ()).unwrap();
        let left = |effort: usize| {
            let mut matrix = coarse.clone();
            let narrowed = factors.narrow(&mut matrix, &settings, effort).unwrap();
            assert!(narrowed.spent <= effort && narrowed.most_cells >= 50);
            (matrix.unmet(&settings).count(), narrowed.wanted)
        };
        let counts = [0, 1000, 5000, 10_000_000].map(left);
        assert!(counts.windows(2).all(|two| two[0].0 > two[1].0), "{counts:?}");
        assert!(counts[..3].iter().all(|(_, wanted)| *wanted > 50.0) && counts[3] == (0, 0.0), "{counts:?}");
        // What is extrapolated is of the size of what it takes.
        let most_cells = (6..40).map(|power| 1 << power).find(|&cells| cells as f64 >= 4.0 * counts[0].1).unwrap();
        let enough = factors.matrix(&FactorSettings { most_cells, ..settings }, || ()).unwrap();
        assert_eq!(enough.unmet(&settings).count(), 0, "{most_cells}");
    }
}
