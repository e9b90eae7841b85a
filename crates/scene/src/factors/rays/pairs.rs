//! Counts of pairs, and the factors that they make.

use std::ops::Range;

use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::limits::Limits;
use crate::extremes::{largest as larger, smallest as smaller};

/// The larger area over the smaller one, up to which both ways of a pair count.
pub(super) const ALIKE: f64 = 2.4;

/// How near to 1 rows are brought.
pub(super) const CLOSED: f64 = 1e-9;

/// The faces that the rays of a face met: an interrupted run keeps these counts for the next one, and machines send them to each other.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Counted {
    pub(super) face: u32,
    /// Faces that were met, ascending, and how often.
    pub(super) met: Vec<(u32, u32)>,
}

impl Counted {
    /// The face.
    #[must_use]
    pub const fn face(&self) -> usize {
        self.face as usize
    }
}

/// A face's index where it is stored; there are fewer than 2^32.
pub(super) fn short(face: usize) -> u32 {
    u32::try_from(face).unwrap_or(u32::MAX)
}

/// Parts that sums are taken in, whatever the number of threads: so that they are the same to the last digit.
const PARTS: usize = 16;

/// Faces that were met and how often, ascending: five bytes each, and four more where it was often.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct Counts {
    pub(super) faces: Vec<u32>,
    pub(super) few: Vec<u8>,
    pub(super) many: Vec<u32>,
}

impl Counts {
    fn push(&mut self, face: u32, count: u32) {
        self.faces.push(face);
        match u8::try_from(count).ok().filter(|few| *few < u8::MAX) {
            Some(few) => self.few.push(few),
            None => {
                self.few.push(u8::MAX);
                self.many.push(count);
            }
        }
    }

    fn iter(&self) -> impl Iterator<Item = (u32, u32)> {
        Self::listed(&self.faces, &self.few, &self.many)
    }

    fn listed<'a>(faces: &'a [u32], few: &'a [u8], many: &'a [u32]) -> impl Iterator<Item = (u32, u32)> + use<'a> {
        let mut many = many.iter();
        let count = move |&few: &u8| if few == u8::MAX { many.next().copied().unwrap_or(0) } else { u32::from(few) };
        faces.iter().copied().zip(few.iter().map(count))
    }

    /// Those that are in a range.
    fn within(&self, range: &Range<usize>) -> impl Iterator<Item = (u32, u32)> {
        let [start, end] = [range.start, range.end].map(|end| self.faces.partition_point(|face| (*face as usize) < end));
        let before = if start < end { self.few[..start].iter().filter(|few| **few == u8::MAX).count() } else { 0 };
        Self::listed(&self.faces[start..end], &self.few[start..end], &self.many[before..])
    }

    /// Gives back memory that is not used.
    fn shrunk(mut self) -> Self {
        self.faces.shrink_to_fit();
        self.few.shrink_to_fit();
        self.many.shrink_to_fit();
        self
    }
}

/// The exchange of a pair that is not left to rays, by the higher face, and a bound on its error.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Near {
    pub(super) face: u32,
    pub(super) area: f64,
    pub(super) error: f64,
}

impl Near {
    /// Whether it is no pair that sees nothing of each other.
    pub(super) fn is_seen(&self) -> bool {
        self.area + self.error > 0.0
    }
}

/// The areas of the scene and the settings of its rays.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Known {
    /// Areas in the unit of exchanges.
    pub(super) areas: Vec<f64>,
    pub(super) rays: u64,
    /// `ln(2/delta)` of each interval.
    pub(super) logarithm: f64,
    pub(super) confidence: f64,
}

impl Known {
    /// The area that a count of a pair stands for, and of how many trials it is.
    fn weight(&self, i: usize, j: usize) -> (f64, f64) {
        let ([a, b], n) = ([self.areas[i], self.areas[j]], self.rays as f64);
        let (small, large) = (smaller(a, b), larger(a, b));
        if large <= ALIKE * small { (small / (1.0 + small / large) / n, 2.0 * n) } else { (small / n, n) }
    }
}

/// Factors by rays.
///
/// Pairs that no ray joined are not stored: their factors are estimated as 0, and [`Self::absent`] limits them.
#[derive(Debug, Clone, PartialEq)]
pub struct RayFactors {
    pub(super) faces: Vec<usize>,
    pub(super) known: Known,
    /// By the lower face of each pair.
    pub(super) counts: Vec<Counts>,
    /// The faces in parts whose sums are taken together.
    pub(super) parts: Vec<Range<usize>>,
    pub(super) near: Vec<Vec<Near>>,
    /// Rays of each face that met no other.
    pub(super) open: Vec<u32>,
    /// The multiplier of each face's counted exchanges: see [`super`].
    pub(super) scale: Vec<f64>,
    /// The sums of the rows.
    pub(super) sums: Vec<f64>,
    /// Factors below this were left out, those of the smaller face.
    pub(super) dropped: f64,
}

/// A factor by rays, and the interval in which it is with the confidence asked for. Where a pair is near and in free sight, the interval is a bound.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RayEntry {
    /// The face that is seen.
    pub face: usize,
    /// The factor, in the interval.
    pub factor: f64,
    /// The lower end.
    pub lower: f64,
    /// The upper end.
    pub upper: f64,
    /// Whether it is of no ray, but exact up to the interval.
    pub is_exact: bool,
}

/// The factors of a face, and the share of its view that no face has.
#[derive(Debug, Clone, PartialEq)]
pub struct RayRow {
    /// The face.
    pub face: usize,
    /// Its factors, ascending in the other face.
    pub entries: Vec<RayEntry>,
    /// The share that is open: 1 less their sum, at least 0. Its `face` is that of the row.
    pub open: RayEntry,
}

impl RayFactors {
    pub(super) fn of(faces: Vec<usize>, known: Known, mut rows: Vec<Vec<(u32, u32)>>, near: Vec<Vec<Near>>) -> Self {
        let met = |row: &Vec<(u32, u32)>| row.iter().map(|(_, hits)| u64::from(*hits)).sum::<u64>();
        let open = rows.iter().map(|row| u32::try_from(known.rays.saturating_sub(met(row))).unwrap_or(u32::MAX)).collect();
        let count = rows.len();
        let mut counts = Vec::with_capacity(count);
        for block in blocks(count) {
            let mut back: Vec<Vec<(u32, u32)>> = vec![Vec::new(); block.len()];
            for (from, row) in rows.iter().enumerate() {
                // Only of pairs whose lower face is in the block.
                for &(to, hits) in within(row, |&(to, _)| to, &block).iter().take_while(|(to, _)| (*to as usize) < from) {
                    back[to as usize - block.start].push((short(from), hits));
                }
            }
            for (i, back) in block.clone().zip(back) {
                // Its own counts of lower faces are of pairs that were pooled before.
                let own = std::mem::take(&mut rows[i]);
                let above = own.partition_point(|&(to, _)| to as usize <= i);
                counts.push(known.pooled(i, [&own[above..], &back], &near[i]));
            }
        }
        let (scale, sums, parts) = (vec![1.0; count], vec![0.0; count], parts(&counts));
        let mut factors = Self { faces, known, counts, parts, near, open, scale, sums, dropped: 0.0 };
        factors.close();
        factors
    }

    /// Leaves out pairs of which both factors are below `least`: their share goes to the rest of the rows.
    #[must_use]
    pub fn without_below(mut self, least: f64) -> Self {
        for i in 0..self.counts.len() {
            let area = |j: u32| least * smaller(self.known.areas[i], self.known.areas[j as usize]);
            let mut kept = Counts::default();
            for (j, hits) in self.counts[i].iter() {
                if f64::from(hits) * self.known.weight(i, j as usize).0 >= area(j) {
                    kept.push(j, hits);
                }
            }
            self.near[i].retain(|near| !near.is_seen() || near.area >= area(near.face));
            self.counts[i] = kept.shrunk();
        }
        self.dropped = larger(self.dropped, least);
        self.parts = parts(&self.counts);
        self.close();
        self
    }

    /// Finds the multipliers of exchanges: `x_i (sum_j E_ij x_j + S_i) = A_i` less the area that near faces take, with the open area S that rays saw.
    fn close(&mut self) {
        const ROUNDS: usize = 100;
        // Beyond this it is no matter of chance, and left to the open.
        const RANGE: [f64; 2] = [0.5, 2.0];
        let (count, residual) = (self.counts.len(), self.left());
        let open: Vec<f64> = (0..count).map(|i| f64::from(self.open[i]) * self.known.areas[i] / self.known.rays as f64).collect();
        let mut scale = vec![1.0; count];
        for _ in 0..ROUNDS {
            let taken = self.exchanged(&scale);
            let mut worst = 0.0;
            for i in 0..count {
                let total = scale[i] * (taken[i] + open[i]);
                if total > 0.0 {
                    let share = larger(residual[i], 0.0) / total;
                    worst = larger(worst, (residual[i] - total).abs() / self.known.areas[i]);
                    scale[i] = (scale[i] * share.sqrt()).clamp(RANGE[0], RANGE[1]);
                }
            }
            if worst <= CLOSED {
                break;
            }
        }
        // No row is above 1: the larger excess of the two of a pair takes both down.
        let taken = self.exchanged(&scale);
        for i in 0..count {
            let total = scale[i] * taken[i];
            // Near faces may take more than all, by a rounding.
            let limit = larger(residual[i], 0.0);
            if total > limit {
                scale[i] *= limit / total * (1.0 - 4.0 * f64::EPSILON);
            }
        }
        self.scale = scale;
        self.sums = self.row_sums();
    }

    /// Of each face the area that near faces leave.
    fn left(&self) -> Vec<f64> {
        let mut residual = self.known.areas.clone();
        for (i, near) in self.near.iter().enumerate() {
            for near in near {
                residual[i] -= near.area;
                residual[near.face as usize] -= near.area;
            }
        }
        residual
    }

    pub(super) fn row_sums(&self) -> Vec<f64> {
        let (residual, taken, areas) = (self.left(), self.exchanged(&self.scale), &self.known.areas);
        (0..self.len()).map(|i| (areas[i] - residual[i] + self.scale[i] * taken[i]) / areas[i]).collect()
    }

    /// Of each face the counted exchanges, each times the `x` of the other face.
    pub(super) fn exchanged(&self, x: &[f64]) -> Vec<f64> {
        let [counted, _] = self.products::<1>([x.as_chunks().0, &vec![[0.0]; x.len()]]);
        counted.into_flattened()
    }

    /// Calls with each pair, the lower face first, and its exchange.
    pub(super) fn each_exchange(&self, mut exchange: impl FnMut([usize; 2], f64)) {
        for (i, (counts, near)) in self.counts.iter().zip(&self.near).enumerate() {
            for (j, hits) in counts.iter() {
                let j = j as usize;
                exchange([i, j], f64::from(hits) * self.known.weight(i, j).0 * self.scale[i] * self.scale[j]);
            }
            near.iter().for_each(|near| exchange([i, near.face as usize], near.area));
        }
    }

    /// Sums over the pairs of each face of its exchange times the other face's numbers, on all cores: of counted pairs and of near ones.
    pub(super) fn products<const K: usize>(&self, numbers: [&[[f64; K]]; 2]) -> [Vec<[f64; K]>; 2] {
        let zeros = || [vec![[0.0; K]; self.len()], vec![[0.0; K]; self.len()]];
        let part = |range: &Range<usize>| {
            let mut sums = zeros();
            self.add_products(range.clone(), numbers, &mut sums);
            sums
        };
        let parts: Vec<[Vec<[f64; K]>; 2]> = self.parts.par_iter().map(part).collect();
        let mut sums = zeros();
        for part in parts {
            for (sums, part) in sums.iter_mut().zip(part) {
                sums.as_flattened_mut().iter_mut().zip(part.into_flattened()).for_each(|(sum, part)| *sum += part);
            }
        }
        sums
    }

    /// Adds, to both faces of each pair whose lower face is in a range, its exchange times the other face's numbers: of counted pairs and of near ones.
    fn add_products<const K: usize>(
        &self,
        range: Range<usize>,
        [counted, near]: [&[[f64; K]]; 2],
        [of_counted, of_near]: &mut [Vec<[f64; K]>; 2],
    ) {
        let add = |sum: &mut [f64; K], area: f64, numbers: &[f64; K]| (0..K).for_each(|k| sum[k] += area * numbers[k]);
        for i in range {
            let mut sum = [0.0; K];
            for (j, hits) in self.counts[i].iter() {
                let j = j as usize;
                let area = f64::from(hits) * self.known.weight(i, j).0;
                add(&mut sum, area, &counted[j]);
                add(&mut of_counted[j], area, &counted[i]);
            }
            add(&mut of_counted[i], 1.0, &sum);
            for &Near { face, area, .. } in &self.near[i] {
                add(&mut of_near[i], area, &near[face as usize]);
                add(&mut of_near[face as usize], area, &near[i]);
            }
        }
    }

    /// Faces that have factors, ascending; others only hide.
    #[must_use]
    pub fn faces(&self) -> &[usize] {
        &self.faces
    }

    /// Number of faces of the scene.
    #[must_use]
    pub fn len(&self) -> usize {
        self.counts.len()
    }

    /// Whether the scene has no face.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.counts.is_empty()
    }

    /// Rays from each face.
    #[must_use]
    pub const fn rays(&self) -> u64 {
        self.known.rays
    }

    /// The probability with which all intervals hold.
    #[must_use]
    pub const fn confidence(&self) -> f64 {
        self.known.confidence
    }

    /// Factors that are stored, two of each pair.
    #[must_use]
    pub fn stored(&self) -> usize {
        self.exact() + 2 * self.counts.iter().map(|counts| counts.faces.len()).sum::<usize>()
    }

    /// Factors of pairs that are not left to rays.
    #[must_use]
    pub fn exact(&self) -> usize {
        2 * self.near.iter().flatten().filter(|near| near.is_seen()).count()
    }

    /// The upper limit of a factor that is not stored, with the same confidence: that of the smaller face of a pair, as the other one is smaller yet.
    #[must_use]
    pub fn absent(&self) -> f64 {
        let n = self.known.rays as f64;
        // Of both ways at once `2 A_j / (A_i + A_j)` times as much, of twice as many trials.
        let both = 2.0 * ALIKE / (1.0 + ALIKE) * Limits::new(2.0 * n, self.known.logarithm).of(0)[1];
        larger(self.dropped, larger(both, Limits::new(n, self.known.logarithm).of(0)[1]))
    }

    /// Half the width of the widest interval of a factor that is stored.
    #[must_use]
    pub fn widest(&self) -> f64 {
        let limits = self.limits();
        let mut widest = 0.0;
        for (i, counts) in self.counts.iter().enumerate() {
            for (j, hits) in counts.iter() {
                let j = j as usize;
                // Of the smaller face, whose factor is the larger one.
                let faces = if self.known.areas[i] < self.known.areas[j] { (i, j) } else { (j, i) };
                let entry = self.entry(faces, hits, &limits);
                widest = larger(widest, 0.5 * (entry.upper - entry.lower));
            }
        }
        widest
    }

    /// The share of a face's view that no face has.
    #[must_use]
    pub fn open(&self, face: usize) -> f64 {
        larger(1.0 - self.sums.get(face).copied().unwrap_or(1.0), 0.0)
    }

    /// Some rows, by their places among [`Self::faces`]: few at a time, so that they need not fit in memory together.
    #[must_use]
    pub fn rows(&self, block: Range<usize>) -> Vec<RayRow> {
        let limits = self.limits();
        self.rows_by(block, &limits)
    }

    /// Calls with one row after the other, until one fails.
    ///
    /// # Errors
    /// The first error of a call.
    pub fn each_row<E>(&self, mut row: impl FnMut(RayRow) -> Result<(), E>) -> Result<(), E> {
        let limits = self.limits();
        for block in blocks(self.faces.len()) {
            self.rows_by(block, &limits).into_iter().try_for_each(&mut row)?;
        }
        Ok(())
    }

    fn limits(&self) -> [Limits; 2] {
        [1.0, 2.0].map(|ways| Limits::new(ways * self.known.rays as f64, self.known.logarithm))
    }

    fn rows_by(&self, block: Range<usize>, limits: &[Limits; 2]) -> Vec<RayRow> {
        let Some(faces) = self.faces.get(block) else { return Vec::new() };
        let (Some(&first), Some(&last)) = (faces.first(), faces.last()) else { return Vec::new() };
        let span = first..last + 1;
        // The entries of these that faces below have.
        let mut below: Vec<Vec<RayEntry>> = vec![Vec::new(); span.len()];
        for i in 0..last {
            for (j, hits) in self.counts[i].within(&span) {
                below[j as usize - span.start].push(self.entry((j as usize, i), hits, limits));
            }
            for near in within(&self.near[i], |near| near.face, &span).iter().filter(|near| near.is_seen()) {
                below[near.face as usize - span.start].push(self.near_entry((near.face as usize, i), near));
            }
        }
        let row = |&face: &usize| {
            let mut entries = std::mem::take(&mut below[face - span.start]);
            entries.extend(self.counts[face].iter().map(|(j, hits)| self.entry((face, j as usize), hits, limits)));
            entries.extend(
                self.near[face]
                    .iter()
                    .filter(|near| near.is_seen())
                    .map(|near| self.near_entry((face, near.face as usize), near)),
            );
            entries.sort_unstable_by_key(|entry| entry.face);
            let factor = larger(1.0 - entries.iter().map(|entry| entry.factor).sum::<f64>(), 0.0);
            let [lower, upper] = limits[0].of(self.open[face]);
            let open = RayEntry { face, factor, lower: smaller(lower, factor), upper: larger(upper, factor), is_exact: false };
            RayRow { face, entries, open }
        };
        faces.iter().map(row).collect()
    }

    /// The factor from face i to face j by the counts.
    fn entry(&self, (i, j): (usize, usize), hits: u32, limits: &[Limits; 2]) -> RayEntry {
        let (weight, trials) = self.known.weight(i.min(j), i.max(j));
        let area = self.known.areas[i];
        let factor = f64::from(hits) * weight * self.scale[i] * self.scale[j] / area;
        let limits = &limits[usize::from(trials > self.known.rays as f64)];
        let [lower, upper] = limits.of(hits).map(|share| share * trials * weight / area);
        // No face exchanges more than its area.
        let bound = smaller(1.0, self.known.areas[j] / area);
        RayEntry { face: j, factor, lower: smaller(lower, factor), upper: larger(smaller(upper, bound), factor), is_exact: false }
    }

    fn near_entry(&self, (i, j): (usize, usize), near: &Near) -> RayEntry {
        let area = self.known.areas[i];
        // The area and the division err by a few roundings.
        let error = (near.error + 8.0 * f64::EPSILON * near.area) / area * (1.0 + 8.0 * f64::EPSILON);
        let factor = near.area / area;
        RayEntry { face: j, factor, lower: larger(factor - error, 0.0), upper: factor + error, is_exact: true }
    }

    pub(super) fn scale(&self) -> &[f64] {
        &self.scale
    }
}

impl Known {
    /// Of the pairs of a face with higher ones the counts from here and from there, both ascending, but for those that are known otherwise.
    fn pooled(&self, i: usize, [own, back]: [&[(u32, u32)]; 2], near: &[Near]) -> Counts {
        let mut counts = Counts::default();
        let (mut own, mut back) = (own.iter().peekable(), back.iter().peekable());
        loop {
            let next = |of: Option<&&(u32, u32)>| of.map_or(u32::MAX, |(face, _)| *face);
            let j = next(own.peek()).min(next(back.peek()));
            let take = |(face, _): &&(u32, u32)| *face == j;
            let [from_here, from_there] = [own.next_if(take), back.next_if(take)].map(|of| of.map_or(0, |(_, hits)| *hits));
            if from_here == 0 && from_there == 0 {
                return counts.shrunk();
            }
            if near.binary_search_by_key(&j, |near| near.face).is_ok() {
                continue;
            }
            let (_, trials) = self.weight(i, j as usize);
            let hits = match (trials > self.rays as f64, self.areas[i] <= self.areas[j as usize]) {
                (true, _) => from_here + from_there,
                (false, true) => from_here,
                (false, false) => from_there,
            };
            if hits > 0 {
                counts.push(j, hits);
            }
        }
    }
}

/// All faces, in ranges of about as many pairs each.
pub(super) fn parts(counts: &[Counts]) -> Vec<Range<usize>> {
    let (mut parts, mut start, mut pairs) = (Vec::new(), 0, 0);
    let whole: usize = counts.iter().map(|counts| counts.faces.len() + 1).sum();
    for (i, of_face) in counts.iter().enumerate() {
        pairs += of_face.faces.len() + 1;
        if pairs * PARTS >= whole || i + 1 == counts.len() {
            parts.push(start..i + 1);
            (start, pairs) = (i + 1, 0);
        }
    }
    parts
}

/// The part of an ascending list that is in a range.
fn within<'a, T>(all: &'a [T], face: impl Fn(&T) -> u32, range: &Range<usize>) -> &'a [T] {
    let end = |end: usize| all.partition_point(|of| (face(of) as usize) < end);
    &all[end(range.start)..end(range.end)]
}

/// So many places in blocks whose content is in memory at once.
fn blocks(count: usize) -> impl Iterator<Item = Range<usize>> {
    const BLOCKS: usize = 64;
    let length = count.div_ceil(BLOCKS).max(1);
    (0..count).step_by(length).map(move |start| start..count.min(start + length))
}
