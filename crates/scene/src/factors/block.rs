//! The pairs whose lower face has its row in a block: what one machine of many computes, so that each pair is computed once.
//!
//! As bytes: numbers in little-endian order, the block's first row and the row after its last one, then 52 bytes a pair.

use std::ops::Range;

use rayon::prelude::*;

use super::culling::Wanted;
use super::matrix::{FactorMatrix, Pair};
use super::pair::Known;
use super::{FactorSettings, FormFactors};
use crate::error::Error;

/// Pairs of faces whose lower face has its row in a block of rows.
///
/// ```
/// use radgrad_scene::{Degenerate, FactorBlock, FactorSettings, FormFactors, Scene};
/// # let file = concat!(env!("CARGO_MANIFEST_DIR"), "/../../data/scenes/two_blocks.obj");
/// let scene = Scene::read(file, Degenerate::Refuse)?;
/// let (factors, settings) = (FormFactors::new(&scene)?, FactorSettings { tolerance: 0.1, ..FactorSettings::default() });
/// let rows = factors.faces().len();
/// let lower = factors.block(0..rows / 3, &settings, || ())?;
/// let upper = factors.block(rows / 3..rows, &settings, || ())?;
/// let sent = FactorBlock::from_bytes(&upper.to_bytes())?;
/// assert_eq!(factors.join(vec![sent, lower])?, factors.matrix(&settings, || ())?);
/// # Ok::<(), radgrad_scene::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct FactorBlock {
    rows: Range<usize>,
    pairs: Vec<Pair>,
}

impl FormFactors<'_> {
    /// The pairs whose lower face is one of [`Self::faces`] by its place in a range. `progress` is called once a row.
    ///
    /// # Errors
    /// If there are not so many rows, or a point's factor is out of range.
    pub fn block(&self, rows: Range<usize>, settings: &FactorSettings, progress: impl Fn() + Sync) -> Result<FactorBlock, Error> {
        let all = self.faces();
        if all.get(rows.clone()).is_none() {
            let found = format!("{} to {}", rows.start, rows.end);
            return Err(Error::expected(format!("a range of the {} rows", all.len()), found));
        }
        let mut has_factors = vec![false; self.emitters.len()];
        all.iter().for_each(|&face| has_factors[face] = true);
        let wanted = Wanted::new(self.index.order(), has_factors);
        let of_row = |place: usize| {
            let found = self.pairs_of(all[place], &self.may_see(all[place], &wanted), settings)?;
            self.go_on()?;
            progress();
            Ok::<_, Error>(found)
        };
        let found = rows.clone().into_par_iter().with_max_len(1).map(of_row).collect::<Result<Vec<_>, _>>()?;
        let mut pairs: Vec<Pair> = found.into_iter().flatten().collect();
        pairs.sort_by_key(Pair::key);
        Ok(FactorBlock { rows, pairs })
    }

    /// How many later ones of [`Self::faces`] each of some of them may see, by their places in it: the pairs that [`Self::block`] computes for
    /// these rows, counted without computing any.
    ///
    /// # Errors
    /// If there is no such row.
    pub fn sightings(&self, rows: &[usize]) -> Result<Vec<usize>, Error> {
        let all = self.faces();
        if let Some(row) = rows.iter().find(|&&row| row >= all.len()) {
            return Err(Error::expected(format!("rows below {}", all.len()), row.to_string()));
        }
        let mut has_factors = vec![false; self.emitters.len()];
        all.iter().for_each(|&face| has_factors[face] = true);
        let wanted = Wanted::new(self.index.order(), has_factors);
        Ok(rows.par_iter().with_max_len(1).map(|&row| self.may_see(all[row], &wanted).len()).collect())
    }

    /// The matrix of blocks that have every row once, in any order: to the last digit that of [`Self::matrix`].
    ///
    /// # Errors
    /// If a row is missing or there twice, a pair is of faces that are not there, or its figures are none of an exchange.
    pub fn join(&self, mut blocks: Vec<FactorBlock>) -> Result<FactorMatrix, Error> {
        let faces = self.faces();
        blocks.sort_by_key(|block| (block.rows.start, block.rows.end));
        let mut next = 0;
        for FactorBlock { rows, .. } in &blocks {
            if rows.start != next {
                return Err(Error::expected(
                    format!("a block from row {next} on"),
                    format!("one of rows {} to {}", rows.start, rows.end),
                ));
            }
            next = rows.end;
        }
        if next != faces.len() {
            return Err(Error::expected(format!("blocks of all {} rows", faces.len()), format!("{next} rows")));
        }
        let pairs: Vec<Pair> = blocks.into_iter().flat_map(|block| block.pairs).collect();
        let is_row = |face: u32| faces.binary_search(&(face as usize)).is_ok();
        if let Some(pair) =
            pairs.iter().find(|pair| pair.faces[0] >= pair.faces[1] || !pair.faces.iter().all(|face| is_row(*face)))
        {
            return Err(Error::expected("pairs of faces of the scene, the lower one first", format!("{:?}", pair.faces)));
        }
        if let Some(two) = pairs.windows(2).find(|two| two[0].faces >= two[1].faces) {
            let found = format!("{:?} before {:?}", two[0].faces, two[1].faces);
            return Err(Error::expected("each pair of faces once, in their order", found));
        }
        pairs.iter().try_for_each(|pair| self.check_known(pair.faces.map(|face| face as usize), pair.known))?;
        self.of_pairs(faces, pairs)
    }
}

/// Bytes of a pair, and of the header before the pairs.
const PAIR: usize = 52;
const HEAD: usize = 16;

impl FactorBlock {
    /// As bytes, to be sent.
    #[must_use]
    pub fn to_bytes(&self) -> Vec<u8> {
        let mut bytes = Vec::with_capacity(HEAD + PAIR * self.pairs.len());
        for row in [self.rows.start, self.rows.end] {
            bytes.extend((row as u64).to_le_bytes());
        }
        for Pair { faces, known } in &self.pairs {
            faces.iter().for_each(|face| bytes.extend(face.to_le_bytes()));
            let Known { value, least, most, estimate, modelling, occluders } = known;
            [value, least, most, estimate, modelling].iter().for_each(|number| bytes.extend(number.to_le_bytes()));
            bytes.extend(occluders.to_le_bytes());
        }
        bytes
    }

    /// From those bytes.
    ///
    /// # Errors
    /// If they are not such bytes.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, Error> {
        let wrong = || Error::expected("a block of factors", format!("{} bytes that are none", bytes.len()));
        let (head, rest) = bytes.split_at_checked(HEAD).filter(|(_, rest)| rest.len() % PAIR == 0).ok_or_else(wrong)?;
        let row = |at: usize| head[at..].first_chunk().and_then(|&bytes| usize::try_from(u64::from_le_bytes(bytes)).ok());
        let rows = row(0).ok_or_else(wrong)?..row(8).ok_or_else(wrong)?;
        let whole = |pair: &[u8], at: usize| u32::from_le_bytes(std::array::from_fn(|k| pair[at + k]));
        let real = |pair: &[u8], at: usize| f64::from_le_bytes(std::array::from_fn(|k| pair[at + k]));
        let pair = |pair: &[u8]| Pair {
            faces: [whole(pair, 0), whole(pair, 4)],
            known: Known {
                value: real(pair, 8),
                least: real(pair, 16),
                most: real(pair, 24),
                estimate: real(pair, 32),
                modelling: real(pair, 40),
                occluders: whole(pair, 48),
            },
        };
        Ok(Self { rows, pairs: rest.chunks_exact(PAIR).map(pair).collect() })
    }
}

impl FactorMatrix {
    /// All of its pairs as one block, of which [`FormFactors::join`] makes it again without computing any.
    ///
    /// ```
    /// use radgrad_scene::{Degenerate, FactorSettings, FormFactors, Scene};
    /// # let file = concat!(env!("CARGO_MANIFEST_DIR"), "/../../data/scenes/two_blocks.obj");
    /// let scene = Scene::read(file, Degenerate::Refuse)?;
    /// let factors = FormFactors::new(&scene)?;
    /// let matrix = factors.matrix(&FactorSettings { tolerance: 0.1, ..FactorSettings::default() }, || ())?;
    /// assert_eq!(factors.join(vec![matrix.to_block()])?, matrix);
    /// # Ok::<(), radgrad_scene::Error>(())
    /// ```
    #[must_use]
    pub fn to_block(&self) -> FactorBlock {
        FactorBlock { rows: 0..self.faces().len(), pairs: self.pairs.clone() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Degenerate, Scene};

    #[test]
    fn a_block_with_a_figure_that_is_none_is_refused() {
        let file = concat!(env!("CARGO_MANIFEST_DIR"), "/../../data/scenes/two_blocks.obj");
        let scene = Scene::read(file, Degenerate::Refuse).unwrap();
        let factors = FormFactors::new(&scene).unwrap();
        let settings = FactorSettings { tolerance: 0.1, ..FactorSettings::default() };
        let whole = factors.block(0..factors.faces().len(), &settings, || ()).unwrap();
        let spoils: [fn(&mut Vec<Pair>); 8] = [
            |pairs| pairs[0].known.value = 2.0 * pairs[0].known.most + 1e-3,
            |pairs| pairs[1].known.value = f64::NAN,
            |pairs| pairs[1].known.least = -1.0,
            |pairs| pairs[2].known.most = f64::INFINITY,
            |pairs| pairs[2].known.estimate = f64::NAN,
            |pairs| pairs[3].known.modelling = f64::NEG_INFINITY,
            |pairs| pairs.swap(0, 1),
            |pairs| pairs.push(pairs[pairs.len() - 1]),
        ];
        assert!(factors.join(vec![whole.clone()]).is_ok());
        for (index, spoil) in spoils.iter().enumerate() {
            let mut block = whole.clone();
            spoil(&mut block.pairs);
            assert!(factors.join(vec![block]).is_err(), "{index}");
        }
    }
}
