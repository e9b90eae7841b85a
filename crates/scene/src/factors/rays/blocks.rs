//! Products of far blocks by two lists of numbers each: memory and time of a product grow about as the number of faces.
//!
//! Faces are put in an order by halving them along the longest side of their middles' box, so that near faces are near in the order. Of the exchanges
//! `E_ij` of two parts of it, of i and of j, that have the sums `R_i` and `C_j` and the total T, [`FactorOperator::blocks`] keeps either the numbers
//! themselves or the two lists of sums: `R_i C_j / T` are the exchanges then. So
//! - rows have the sums that they had, and close as before; pairs are reciprocal, and none is below 0;
//! - where the two parts are far apart beside their sizes, the sums have all of it that is linear in the place of either;
//! - the product of row i of the block and q errs by at most `R_i` times what is farther, from the largest q of the other part or from its least, to
//!   the mean that the sums make: the true one is a mean of q too. [`BlockOperator::certified`] adds this up.
//!
//! Whether the sums are enough is asked of the parts of the two parts, four by four: by how much their exchanges differ from those that the sums
//! make, beyond twice the deviation that counts have by chance, over T. Else both are halved, unless the numbers themselves are fewer bytes.

use std::ops::Range;

use radgrad_core::DVec3;
use rayon::prelude::*;

use super::limits::Chances;
use super::operator::{Certified, FactorOperator, Products};
use super::pairs::{RayFactors, short};
use crate::error::Error;
use crate::extremes::largest as larger;

/// Sides of a block of numbers, at most: places in it are bytes.
pub(super) const SIDE: usize = 256;

/// Bytes of a number with its two places.
const SINGLE: usize = 6;

/// Pairs that are divided at once.
const PAIRS: usize = 1 << 21;

/// Parts that sums are taken in, whatever the number of threads.
const PARTS: usize = 16;

/// Parts of a part whose exchanges are asked.
const ASKED: usize = 4;

/// [`FactorOperator`] with far blocks in fewer numbers. It need not keep the factors.
///
/// ```
/// use radgrad_scene::{Degenerate, FactorOperator, FormFactors, RaySettings, Scene};
/// # let file = concat!(env!("CARGO_MANIFEST_DIR"), "/../../data/scenes/two_blocks.obj");
/// let scene = Scene::read(file, Degenerate::Refuse)?;
/// let factors = FormFactors::new(&scene)?;
/// let settings = RaySettings { rays: Some(1000), ..RaySettings::default() };
/// let counted = factors.count_rays(0..factors.faces().len(), &settings, |_| ())?;
/// let operator = FactorOperator::new(factors.by_rays(counted, &settings)?);
/// let blocks = operator.blocks(&factors.middles(), 0.05)?;
/// let sent = vec![1.0; scene.faces().len()];
/// let (all, few) = (operator.apply(&sent)?, blocks.apply(&sent)?);
/// assert!(all.iter().zip(few).all(|(all, few)| (all - few).abs() < 1e-5)); // of a constant
/// # Ok::<(), radgrad_scene::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct BlockOperator {
    /// Faces by their places.
    pub(super) order: Vec<u32>,
    /// Of each face.
    pub(super) areas: Vec<f64>,
    /// Of each face the change that the multipliers of counted pairs, and the bounds of near ones, may make in a product of ones.
    pub(super) fixed: [Vec<f64>; 2],
    pub(super) chances: Chances,
    pub(super) blocks: Vec<Block>,
    /// Of each block its sums, those of the second part over the total; or its numbers.
    pub(super) numbers: Vec<f32>,
    /// The places of numbers in their blocks.
    pub(super) places: Vec<[u8; 2]>,
    pub(super) parts: Vec<Part>,
}

/// Two parts of the order.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Block {
    pub(super) starts: [u32; 2],
    pub(super) lengths: [u32; 2],
    /// Numbers that it has by their places, or none if it has sums.
    pub(super) pairs: u32,
}

impl Block {
    pub(super) fn ranges(&self) -> [Range<usize>; 2] {
        [0, 1].map(|side| self.starts[side] as usize..self.starts[side] as usize + self.lengths[side] as usize)
    }

    /// How many numbers it has, and how many places.
    pub(super) fn sizes(&self) -> [usize; 2] {
        let pairs = self.pairs as usize;
        if pairs == 0 { [self.lengths[0] as usize + self.lengths[1] as usize, 0] } else { [pairs, pairs] }
    }
}

/// Blocks that are summed together, and where their numbers and places begin.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Part {
    blocks: Range<usize>,
    numbers: usize,
    places: usize,
}

/// An exchange of two places.
#[derive(Debug, Clone, Copy)]
struct Pair {
    at: [u32; 2],
    area: f32,
}

/// Blocks that are found, with their numbers and places.
#[derive(Default)]
struct Found {
    blocks: Vec<Block>,
    numbers: Vec<f32>,
    places: Vec<[u8; 2]>,
}

impl Found {
    fn bytes(&self) -> usize {
        size_of::<Block>() * self.blocks.len() + size_of::<f32>() * self.numbers.len() + 2 * self.places.len()
    }

    fn extend(&mut self, other: Self) {
        self.blocks.extend(other.blocks);
        self.numbers.extend(other.numbers);
        self.places.extend(other.places);
    }
}

impl FactorOperator {
    /// The operator in far blocks, of the middles of all faces: `tolerance` is the share of the exchange of two parts that may be elsewhere in them,
    /// the larger the fewer numbers are kept.
    ///
    /// # Errors
    /// If there is not one middle for each face, or the tolerance is not above 0 and below 1.
    pub fn blocks(&self, middles: &[DVec3], tolerance: f64) -> Result<BlockOperator, Error> {
        if middles.len() != self.len() || !middles.iter().all(|middle| middle.is_finite()) {
            return Err(Error::expected(format!("a middle of each of the {} faces", self.len()), middles.len().to_string()));
        }
        if !(tolerance > 0.0 && tolerance < 1.0) {
            return Err(Error::expected("a tolerance above 0 and below 1", tolerance.to_string()));
        }
        let factors = self.factors();
        let mut order: Vec<u32> = (0..middles.len()).map(short).collect();
        halve(&mut order, middles);
        let mut place = vec![0; order.len()];
        order.iter().enumerate().for_each(|(at, &face)| place[face as usize] = short(at));
        let mut before = vec![0.0];
        for &face in &order {
            before.push(before[before.len() - 1] + factors.known.areas[face as usize]);
        }
        let setup = Setup { before, rays: factors.known.rays as f64, tolerance };
        // So many strips that the pairs of one are in memory at once.
        let pairs = factors.stored() / 2;
        let whole = 0..order.len();
        let mut strips = vec![whole];
        while strips.len() * PAIRS < pairs && strips.iter().all(|strip| strip.len() > 1) {
            strips = strips.into_iter().flat_map(halves).collect();
        }
        let mut division = Found::default();
        for (number, strip) in strips.iter().enumerate() {
            let mut blocks = pairs_of(factors, &place, &strips, number);
            let of_block = |(other, pairs): (usize, &mut Vec<Pair>)| {
                let parts = [strip.clone(), strips[other].clone()];
                setup.divided(parts, pairs)
            };
            let divided: Vec<Found> = blocks.par_iter_mut().enumerate().map(of_block).collect();
            divided.into_iter().for_each(|blocks| division.extend(blocks));
        }
        let ones = vec![1.0; order.len()];
        let fixed = [self.moved(&ones), self.near_errors(&ones)];
        let Found { blocks, numbers, places } = division;
        let chances = self.chances();
        let parts = parts(&blocks);
        Ok(BlockOperator { order, areas: factors.known.areas.clone(), fixed, chances, blocks, numbers, places, parts })
    }
}

/// The exchanges of a strip with itself and those that follow.
fn pairs_of(factors: &RayFactors, place: &[u32], strips: &[Range<usize>], number: usize) -> Vec<Vec<Pair>> {
    let strip_of = |place: u32| strips.partition_point(|strip| strip.end <= place as usize);
    let mut exchanges = vec![Vec::new(); strips.len()];
    factors.each_exchange(|[i, j], area| {
        let [a, b] = [place[i], place[j]];
        let at = [a.min(b), a.max(b)];
        if strips[number].contains(&(at[0] as usize)) && area > 0.0 {
            #[expect(clippy::cast_possible_truncation, reason = "single precision is what blocks have")]
            exchanges[strip_of(at[1])].push(Pair { at, area: area as f32 });
        }
    });
    exchanges
}

/// The numbers that the division of blocks needs.
struct Setup {
    /// The area before each place.
    before: Vec<f64>,
    rays: f64,
    tolerance: f64,
}

impl Setup {
    fn divided(&self, parts: [Range<usize>; 2], pairs: &mut [Pair]) -> Found {
        let Some(sides) = (!pairs.is_empty()).then(|| parts.each_ref().map(Range::len)) else { return Found::default() };
        let is_same = parts[0] == parts[1];
        let singles = SINGLE * pairs.len();
        let is_small = sides.iter().all(|side| *side <= SIDE);
        if !is_same && size_of::<f32>() * (sides[0] + sides[1]) < singles && self.is_sums(&parts, pairs) {
            return sums(&parts, pairs);
        }
        // Below this no two lists are fewer bytes.
        let is_least = sides.iter().all(|side| *side <= 2) || singles <= size_of::<Block>();
        if is_small && is_least {
            return single(&parts, pairs);
        }
        let [first, second] = parts.clone().map(halves);
        let middles = [first[0].end, second[0].end];
        let low = partition(pairs, |pair| (pair.at[0] as usize) < middles[0]);
        let mut division = Found::default();
        let (head, tail) = pairs.split_at_mut(low);
        for (rows, pairs) in first.iter().zip([head, tail]) {
            let low = partition(pairs, |pair| (pair.at[1] as usize) < middles[1]);
            let (before, after) = pairs.split_at_mut(low);
            for (columns, pairs) in second.iter().zip([before, after]) {
                division.extend(self.divided([rows.clone(), columns.clone()], pairs));
            }
        }
        if is_small && singles + size_of::<Block>() <= division.bytes() { single(&parts, pairs) } else { division }
    }

    /// Whether the sums of two parts make the exchanges of the parts of these.
    fn is_sums(&self, parts: &[Range<usize>; 2], pairs: &[Pair]) -> bool {
        let ends = parts.each_ref().map(|part| {
            let quarters: Vec<Range<usize>> = halves(part.clone()).into_iter().flat_map(halves).collect();
            [quarters[0].end, quarters[1].end, quarters[2].end]
        });
        let mut exchanged = [[0.0; ASKED]; ASKED];
        for Pair { at, area } in pairs {
            let [a, b] = [0, 1].map(|side| ends[side].iter().filter(|end| at[side] as usize >= **end).count());
            exchanged[a][b] += f64::from(*area);
        }
        let rows = exchanged.map(|row| row.iter().sum::<f64>());
        let columns: [f64; ASKED] = std::array::from_fn(|b| exchanged.iter().map(|row| row[b]).sum());
        let total: f64 = rows.iter().sum();
        let mean = |part: &Range<usize>| (self.before[part.end] - self.before[part.start]) / part.len() as f64;
        let [a, b] = parts.each_ref().map(mean);
        // The area that one ray stands for.
        let one = 1.0 / (1.0 / a + 1.0 / b) / self.rays;
        let beyond = |(a, b): (usize, usize)| {
            let expected = rows[a] * columns[b] / total;
            larger((exchanged[a][b] - expected).abs() - 2.0 * (larger(exchanged[a][b], expected) * one).sqrt(), 0.0)
        };
        let beyond: [[f64; ASKED]; ASKED] = std::array::from_fn(|a| std::array::from_fn(|b| beyond((a, b))));
        let of_row = |k: usize| beyond[k].iter().sum::<f64>() <= self.tolerance * larger(rows[k], total / ASKED as f64);
        let of_column =
            |k: usize| beyond.iter().map(|row| row[k]).sum::<f64>() <= self.tolerance * larger(columns[k], total / ASKED as f64);
        (0..ASKED).all(|k| of_row(k) && of_column(k))
    }
}

/// A block by its sums.
fn sums(parts: &[Range<usize>; 2], pairs: &[Pair]) -> Found {
    let mut sums = parts.each_ref().map(|part| vec![0.0; part.len()]);
    for Pair { at, area } in pairs {
        for side in 0..2 {
            sums[side][at[side] as usize - parts[side].start] += f64::from(*area);
        }
    }
    let total: f64 = sums[0].iter().sum();
    #[expect(clippy::cast_possible_truncation, reason = "single precision is what blocks have")]
    let numbers = sums[0].iter().copied().chain(sums[1].iter().map(|sum| sum / total)).map(|number| number as f32).collect();
    Found { blocks: vec![block(parts, 0)], numbers, places: Vec::new() }
}

/// A block by its numbers.
fn single(parts: &[Range<usize>; 2], pairs: &mut [Pair]) -> Found {
    pairs.sort_unstable_by_key(|pair| pair.at);
    let within = |pair: &Pair| [0, 1].map(|side| u8::try_from(pair.at[side] as usize - parts[side].start).unwrap_or(u8::MAX));
    Found {
        blocks: vec![block(parts, pairs.len())],
        numbers: pairs.iter().map(|pair| pair.area).collect(),
        places: pairs.iter().map(within).collect(),
    }
}

fn block(parts: &[Range<usize>; 2], pairs: usize) -> Block {
    let [starts, lengths] = [parts.each_ref().map(|part| short(part.start)), parts.each_ref().map(|part| short(part.len()))];
    Block { starts, lengths, pairs: short(pairs) }
}

/// The two halves of a part, the first the smaller one.
fn halves(part: Range<usize>) -> [Range<usize>; 2] {
    let middle = part.start + part.len() / 2;
    [part.start..middle, middle..part.end]
}

/// Moves those that count to the front; how many they are.
fn partition(pairs: &mut [Pair], counts: impl Fn(&Pair) -> bool) -> usize {
    let mut first = 0;
    for at in 0..pairs.len() {
        if counts(&pairs[at]) {
            pairs.swap(at, first);
            first += 1;
        }
    }
    first
}

/// Orders faces so that the halves of each part are apart.
fn halve(order: &mut [u32], middles: &[DVec3]) {
    if order.len() < 2 {
        return;
    }
    let (low, high) = order.iter().fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), &face| {
        (low.min(middles[face as usize]), high.max(middles[face as usize]))
    });
    let axis = (high - low).max_position();
    let key = |face: &u32| middles[*face as usize][axis];
    let middle = order.len() / 2;
    order.select_nth_unstable_by(middle, |a, b| key(a).total_cmp(&key(b)).then(a.cmp(b)));
    let (before, after) = order.split_at_mut(middle);
    halve(before, middles);
    halve(after, middles);
}

/// All blocks, in parts of about as many numbers each.
pub(super) fn parts(blocks: &[Block]) -> Vec<Part> {
    let whole: usize = blocks.iter().map(|block| block.sizes()[0]).sum();
    let mut parts = Vec::new();
    let (mut start, mut at, mut ends) = (0, [0; 2], [0; 2]);
    for (i, block) in blocks.iter().enumerate() {
        let [numbers, places] = block.sizes();
        ends = [ends[0] + numbers, ends[1] + places];
        if (ends[0] - at[0]) * PARTS >= whole || i + 1 == blocks.len() {
            parts.push(Part { blocks: start..i + 1, numbers: at[0], places: at[1] });
            (start, at) = (i + 1, ends);
        }
    }
    parts
}

impl BlockOperator {
    /// Number of faces.
    #[must_use]
    pub const fn len(&self) -> usize {
        self.order.len()
    }

    /// Whether the scene has no face.
    #[must_use]
    pub const fn is_empty(&self) -> bool {
        self.order.is_empty()
    }

    /// Bytes that the blocks take.
    #[must_use]
    pub const fn bytes(&self) -> usize {
        size_of::<Block>() * self.blocks.len() + size_of::<f32>() * self.numbers.len() + 2 * self.places.len()
    }

    /// `F q`, on all cores.
    ///
    /// # Errors
    /// If there is not one finite number for each face.
    pub fn apply(&self, q: &[f64]) -> Result<Vec<f64>, Error> {
        self.apply_many(q, 1)
    }

    /// `F Q` for so many columns, face by face: the same as one after the other, in less time.
    ///
    /// # Errors
    /// If there are not so many finite numbers for each face.
    pub fn apply_many(&self, q: &[f64], columns: usize) -> Result<Vec<f64>, Error> {
        self.of_columns(q, columns)
    }

    /// The same with an error for each face: that of the factors, and that of far blocks.
    ///
    /// # Errors
    /// As [`Self::apply`].
    pub fn certified(&self, q: &[f64]) -> Result<Certified, Error> {
        let product = self.apply(q)?;
        let spread = self.spread(q);
        let largest = q.iter().fold(0.0, |largest, q| larger(largest, q.abs()));
        let mut error: Vec<f64> = self.fixed[1].iter().zip(&spread).map(|(near, spread)| near * largest + spread).collect();
        for sign in [1.0, -1.0] {
            let part: Vec<f64> = q.iter().map(|q| larger(sign * q, 0.0)).collect();
            let peak = part.iter().copied().fold(0.0, larger);
            if peak > 0.0 {
                let (sums, spread) = (self.apply(&part)?, self.spread(&part));
                for (face, error) in error.iter_mut().enumerate() {
                    let moved = self.fixed[0][face] * peak;
                    // The counted sum is at most this.
                    *error += self.chances.deviation(sums[face] + spread[face] + moved, peak) + moved;
                }
            }
        }
        Ok(Certified { product, error })
    }

    /// How far far blocks may move a product, with the rounding of their numbers.
    fn spread(&self, q: &[f64]) -> Vec<f64> {
        let by_place: Vec<f64> = self.order.iter().map(|&face| q[face as usize]).collect();
        // How far any mean over a part is at most from the one that its sums make.
        let reach = |of: &Range<usize>, sums: &[f32]| {
            let q = &by_place[of.clone()];
            let [low, high] = q
                .iter()
                .fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], &q| [crate::extremes::smallest(low, q), larger(high, q)]);
            let [whole, mean] = sums.iter().zip(q).fold([0.0; 2], |[whole, mean], (&sum, q)| {
                let sum = f64::from(sum);
                [whole + sum, mean + sum * q]
            });
            let mean = mean / whole;
            if mean >= low && mean <= high { larger(high - mean, mean - low) } else { high - low }
        };
        let largest = q.iter().fold(0.0, |largest, q| larger(largest, q.abs()));
        // Four roundings of single precision.
        let rounding = 4.0 * f64::from(f32::EPSILON) * largest;
        let mut spread = vec![0.0; q.len()];
        let mut numbers = self.numbers.as_slice();
        for block in &self.blocks {
            let (own, tail) = numbers.split_at(block.sizes()[0]);
            numbers = tail;
            if block.pairs > 0 {
                continue;
            }
            let ranges = block.ranges();
            let (rows, columns) = own.split_at(ranges[0].len());
            let total: f64 = rows.iter().map(|row| f64::from(*row)).sum();
            let (by_rows, by_columns) = (reach(&ranges[0], rows), reach(&ranges[1], columns));
            for (sum, row) in spread[ranges[0].clone()].iter_mut().zip(rows) {
                *sum += f64::from(*row) * by_columns;
            }
            for (sum, column) in spread[ranges[1].clone()].iter_mut().zip(columns) {
                *sum += f64::from(*column) * total * by_rows;
            }
        }
        let mut errors = vec![0.0; q.len()];
        for (&face, spread) in self.order.iter().zip(spread) {
            errors[face as usize] = spread / self.areas[face as usize] + rounding;
        }
        errors
    }
}

impl Products for BlockOperator {
    fn faces(&self) -> usize {
        self.len()
    }

    fn products<const K: usize>(&self, q: &[[f64; K]]) -> Vec<[f64; K]> {
        let by_place: Vec<[f64; K]> = self.order.iter().map(|&face| q[face as usize]).collect();
        let part = |part: &Part| {
            let mut sums = vec![[0.0; K]; self.len()];
            let (mut numbers, mut places) = (&self.numbers[part.numbers..], &self.places[part.places..]);
            for block in &self.blocks[part.blocks.clone()] {
                let [count, singles] = block.sizes();
                let (own, tail) = numbers.split_at(count);
                let (at, others) = places.split_at(singles);
                (numbers, places) = (tail, others);
                block.add(own, at, &by_place, &mut sums);
            }
            sums
        };
        let parts: Vec<Vec<[f64; K]>> = self.parts.par_iter().map(part).collect();
        let mut products = vec![[0.0; K]; self.len()];
        for (place, &face) in self.order.iter().enumerate() {
            let of_face = &mut products[face as usize];
            for part in &parts {
                (0..K).for_each(|k| of_face[k] += part[place][k]);
            }
            of_face.iter_mut().for_each(|sum| *sum /= self.areas[face as usize]);
        }
        products
    }
}

impl Block {
    /// Adds to both parts the sums that they get of the other one.
    fn add<const K: usize>(&self, numbers: &[f32], places: &[[u8; 2]], q: &[[f64; K]], sums: &mut [[f64; K]]) {
        if self.pairs > 0 {
            for (&area, &[i, j]) in numbers.iter().zip(places) {
                let [i, j] = [self.starts[0] as usize + usize::from(i), self.starts[1] as usize + usize::from(j)];
                let area = f64::from(area);
                for k in 0..K {
                    sums[i][k] += area * q[j][k];
                    sums[j][k] += area * q[i][k];
                }
            }
            return;
        }
        let [rows, columns] = self.ranges();
        let (of_rows, of_columns) = numbers.split_at(rows.len());
        let mean = |numbers: &[f32], q: &[[f64; K]]| {
            let mut mean = [0.0; K];
            for (number, q) in numbers.iter().zip(q) {
                (0..K).for_each(|k| mean[k] += f64::from(*number) * q[k]);
            }
            mean
        };
        let sent = [mean(of_rows, &q[rows.clone()]), mean(of_columns, &q[columns.clone()])];
        for (numbers, part, sent) in [(of_rows, rows, sent[1]), (of_columns, columns, sent[0])] {
            for (number, sum) in numbers.iter().zip(&mut sums[part]) {
                (0..K).for_each(|k| sum[k] += f64::from(*number) * sent[k]);
            }
        }
    }
}
