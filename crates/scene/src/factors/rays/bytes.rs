//! Factors by rays as bytes, five bytes a pair and a little for each face, and their products in blocks.

use super::blocks;
use super::blocks::{Block, BlockOperator, SIDE};
use super::limits::Chances;
use super::pairs::{Counted, Counts, Known, Near, RayFactors, parts, short};
use crate::error::Error;

/// The first bytes of [`RayFactors::to_bytes`].
const BEGIN: &[u8; 16] = b"radgrad by rays1";

impl RayFactors {
    /// All of it as bytes, to be kept or sent.
    #[must_use]
    pub fn to_bytes(&self) -> Vec<u8> {
        let Self { faces, known: setup, counts, near, open, scale, dropped, .. } = self;
        let mut bytes = BEGIN.to_vec();
        let whole = |bytes: &mut Vec<u8>, number: usize| bytes.extend((number as u64).to_le_bytes());
        let short = |bytes: &mut Vec<u8>, all: &[u32]| all.iter().for_each(|number| bytes.extend(number.to_le_bytes()));
        let real = |bytes: &mut Vec<u8>, all: &[f64]| all.iter().for_each(|number| bytes.extend(number.to_le_bytes()));
        whole(&mut bytes, counts.len());
        whole(&mut bytes, faces.len());
        bytes.extend(setup.rays.to_le_bytes());
        real(&mut bytes, &[setup.logarithm, setup.confidence, *dropped]);
        faces.iter().for_each(|face| bytes.extend(super::pairs::short(*face).to_le_bytes()));
        real(&mut bytes, &setup.areas);
        real(&mut bytes, scale);
        short(&mut bytes, open);
        for (of_face, near) in counts.iter().zip(near) {
            [of_face.faces.len(), of_face.many.len(), near.len()].iter().for_each(|length| whole(&mut bytes, *length));
            short(&mut bytes, &of_face.faces);
            bytes.extend(&of_face.few);
            short(&mut bytes, &of_face.many);
            for Near { face, area, error } in near {
                short(&mut bytes, &[*face]);
                real(&mut bytes, &[*area, *error]);
            }
        }
        bytes
    }

    /// From those bytes.
    ///
    /// # Errors
    /// If they are not such bytes.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, Error> {
        let wrong = || Error::expected("factors by rays, as they were kept", format!("{} bytes that are none", bytes.len()));
        Self::read(&mut Bytes(bytes)).ok_or_else(wrong)
    }

    fn read(bytes: &mut Bytes<'_>) -> Option<Self> {
        (bytes.take(BEGIN.len())? == BEGIN).then_some(())?;
        let (count, rows) = (bytes.length()?, bytes.length()?);
        let rays = u64::from_le_bytes(*bytes.take(8)?.first_chunk()?);
        let &[logarithm, confidence, dropped] = bytes.reals(3)?.first_chunk()?;
        let faces: Vec<usize> = bytes.shorts(rows)?.into_iter().map(|face| face as usize).collect();
        let (areas, scale, open) = (bytes.reals(count)?, bytes.reals(count)?, bytes.shorts(count)?);
        let is_place = |face: usize, above: usize| face > above && face < count;
        let (mut counts, mut near) = (Vec::new(), Vec::new());
        for face in 0..count {
            let [pairs, often, beside] = [bytes.length()?, bytes.length()?, bytes.length()?];
            let of_face = Counts { faces: bytes.shorts(pairs)?, few: bytes.take(pairs)?.to_vec(), many: bytes.shorts(often)? };
            let is_whole = of_face.few.iter().filter(|few| **few == u8::MAX).count() == often;
            let are_places = of_face.faces.iter().all(|other| is_place(*other as usize, face));
            let is_ascending = of_face.faces.windows(2).all(|two| two[0] < two[1]);
            let one = |bytes: &mut Bytes<'_>| {
                let (face, &[area, error]) = (*bytes.shorts(1)?.first()?, bytes.reals(2)?.first_chunk()?);
                Some(Near { face, area, error })
            };
            let of_near = (0..beside).map(|_| one(bytes)).collect::<Option<Vec<Near>>>()?;
            let are_near = of_near.iter().all(|near| is_place(near.face as usize, face) && near.area >= 0.0 && near.error >= 0.0);
            let is_sorted = of_near.windows(2).all(|two| two[0].face < two[1].face);
            (is_whole && are_places && is_ascending && are_near && is_sorted).then_some(())?;
            counts.push(of_face);
            near.push(of_near);
        }
        let is_positive = |number: &f64| *number > 0.0 && number.is_finite();
        let are_faces = faces.windows(2).all(|two| two[0] < two[1]) && faces.iter().all(|face| *face < count);
        let are_asked =
            confidence > 0.0 && confidence < 1.0 && is_positive(&logarithm) && (0.0..=1.0).contains(&dropped) && rays > 0;
        let are_scales = scale.iter().all(|scale| (0.0..=2.0).contains(scale));
        let is_all = bytes.0.is_empty() && are_faces && are_asked && are_scales && areas.iter().all(is_positive);
        is_all.then_some(())?;
        let (parts, setup) = (parts(&counts), Known { areas, rays, logarithm, confidence });
        let mut factors = Self { faces, known: setup, counts, parts, near, open, scale, sums: Vec::new(), dropped };
        factors.sums = factors.row_sums();
        // A row is above 1 by no more than bounds of near pairs.
        factors.sums.iter().all(|sum| *sum <= 1.0 + 1e-6).then_some(factors)
    }
}

/// The first bytes of [`Counted::to_bytes`].
const BEGIN_ROWS: &[u8; 16] = b"radgrad rows  1\n";

impl Counted {
    /// Rows as bytes, to be sent: eight a pair and eight a row.
    #[must_use]
    pub fn to_bytes(rows: &[Self]) -> Vec<u8> {
        let mut bytes = BEGIN_ROWS.to_vec();
        for Self { face, met } in rows {
            let numbers = [*face, short(met.len())].into_iter().chain(met.iter().flat_map(|&(to, hits)| [to, hits]));
            numbers.for_each(|number| bytes.extend(number.to_le_bytes()));
        }
        bytes
    }

    /// From those bytes. What the rows say is looked at when they are joined ([`crate::FormFactors::by_rays`]).
    ///
    /// # Errors
    /// If they are not such bytes.
    pub fn from_bytes(bytes: &[u8]) -> Result<Vec<Self>, Error> {
        let wrong = || Error::expected("rows of counted rays", format!("{} bytes that are none", bytes.len()));
        let mut unread = Bytes(bytes);
        unread.take(BEGIN_ROWS.len()).filter(|begin| begin == BEGIN_ROWS).ok_or_else(wrong)?;
        let mut rows = Vec::new();
        while !unread.0.is_empty() {
            rows.push(Self::read(&mut unread).ok_or_else(wrong)?);
        }
        Ok(rows)
    }

    fn read(bytes: &mut Bytes<'_>) -> Option<Self> {
        let &[face, count] = bytes.shorts(2)?.first_chunk()?;
        let numbers = bytes.shorts((count as usize).checked_mul(2)?)?;
        let (pairs, _) = numbers.as_chunks();
        Some(Self { face, met: pairs.iter().map(|&[to, hits]| (to, hits)).collect() })
    }
}

/// The first bytes of [`BlockOperator::to_bytes`].
const BEGIN_BLOCKS: &[u8; 16] = b"radgrad blocks 1";

impl BlockOperator {
    /// All of it as bytes, to be kept or sent.
    #[must_use]
    pub fn to_bytes(&self) -> Vec<u8> {
        let Self { order, areas, fixed, chances, blocks, numbers, places, .. } = self;
        let mut bytes = BEGIN_BLOCKS.to_vec();
        for number in [order.len(), blocks.len(), numbers.len(), places.len()] {
            bytes.extend((number as u64).to_le_bytes());
        }
        bytes.extend(chances.rays.to_le_bytes());
        bytes.extend(chances.logarithm.to_le_bytes());
        let reals = [areas, &fixed[0], &fixed[1]].into_iter().flatten();
        reals.for_each(|number| bytes.extend(number.to_le_bytes()));
        let of_block = |&Block { starts: [a, b], lengths: [c, d], pairs }: &Block| [a, b, c, d, pairs];
        let shorts = order.iter().copied().chain(blocks.iter().flat_map(of_block));
        shorts.for_each(|number| bytes.extend(number.to_le_bytes()));
        numbers.iter().for_each(|number| bytes.extend(number.to_le_bytes()));
        bytes.extend(places.as_flattened());
        bytes
    }

    /// From those bytes.
    ///
    /// # Errors
    /// If they are not such bytes.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, Error> {
        let wrong = || Error::expected("products in blocks, as they were kept", format!("{} bytes that are none", bytes.len()));
        Self::read(&mut Bytes(bytes)).ok_or_else(wrong)
    }

    fn read(bytes: &mut Bytes<'_>) -> Option<Self> {
        (bytes.take(BEGIN_BLOCKS.len())? == BEGIN_BLOCKS).then_some(())?;
        let [count, blocks, numbers, places] = [bytes.length()?, bytes.length()?, bytes.length()?, bytes.length()?];
        let rays = u64::from_le_bytes(*bytes.take(8)?.first_chunk()?);
        let logarithm = *bytes.reals(1)?.first()?;
        let (areas, fixed) = (bytes.reals(count)?, [bytes.reals(count)?, bytes.reals(count)?]);
        let order = bytes.shorts(count)?;
        let of_block = |of: &[u32; 5]| Block { starts: [of[0], of[1]], lengths: [of[2], of[3]], pairs: of[4] };
        let blocks: Vec<Block> = bytes.shorts(blocks.checked_mul(5)?)?.as_chunks().0.iter().map(of_block).collect();
        let numbers: Vec<f32> = bytes.shorts(numbers)?.into_iter().map(f32::from_bits).collect();
        let places = bytes.take(places.checked_mul(2)?)?.as_chunks().0.to_vec();
        let is_amount = |number: &f64| *number >= 0.0 && number.is_finite();
        let mut is_there = vec![false; count];
        let is_new = |face: &u32| is_there.get_mut(*face as usize).is_some_and(|there| !std::mem::replace(there, true));
        let are_known =
            rays > 0 && logarithm > 0.0 && logarithm.is_finite() && areas.iter().all(|area| is_amount(area) && *area > 0.0);
        let are_amounts =
            fixed.iter().flatten().all(is_amount) && numbers.iter().all(|number| *number >= 0.0 && number.is_finite());
        (bytes.0.is_empty() && order.iter().all(is_new) && are_known && are_amounts).then_some(())?;
        let mut ends = [0_usize; 2];
        for block in &blocks {
            let sizes = block.sizes();
            let start = ends[1];
            ends = [ends[0].checked_add(sizes[0])?, start.checked_add(sizes[1])?];
            let [rows, columns] = block.ranges();
            let are_within = |&[i, j]: &[u8; 2]| usize::from(i) < rows.len() && usize::from(j) < columns.len();
            let is_small = block.pairs == 0 || rows.len() <= SIDE && columns.len() <= SIDE;
            let is_block =
                is_small && rows.end <= count && columns.end <= count && places.get(start..ends[1])?.iter().all(are_within);
            is_block.then_some(())?;
        }
        (ends == [numbers.len(), places.len()]).then_some(())?;
        let parts = blocks::parts(&blocks);
        let chances = Chances { rays, logarithm };
        let operator = Self { order, areas, fixed, chances, blocks, numbers, places, parts };
        // No row is above 1 by more than bounds of near pairs and roundings.
        operator.apply(&vec![1.0; count]).ok()?.iter().all(|sum| *sum <= 1.0 + 1e-5).then_some(operator)
    }
}

/// Bytes that are read from the first on.
struct Bytes<'a>(&'a [u8]);

impl<'a> Bytes<'a> {
    fn take(&mut self, count: usize) -> Option<&'a [u8]> {
        let (taken, tail) = self.0.split_at_checked(count)?;
        self.0 = tail;
        Some(taken)
    }

    fn length(&mut self) -> Option<usize> {
        self.take(8)?.first_chunk().and_then(|bytes| usize::try_from(u64::from_le_bytes(*bytes)).ok())
    }

    fn shorts(&mut self, count: usize) -> Option<Vec<u32>> {
        let (chunks, _) = self.take(count.checked_mul(4)?)?.as_chunks();
        Some(chunks.iter().map(|bytes| u32::from_le_bytes(*bytes)).collect())
    }

    fn reals(&mut self, count: usize) -> Option<Vec<f64>> {
        let (chunks, _) = self.take(count.checked_mul(8)?)?.as_chunks();
        Some(chunks.iter().map(|bytes| f64::from_le_bytes(*bytes)).collect())
    }
}
