//! Walks of one kind: a pilot of random numbers of its own, walks until limits are narrow enough, and the limits.

use radgrad_scene::largest;
use rayon::prelude::*;

use crate::betting::{Bets, Moments, draws};
use crate::error::Error;
use crate::{Interval, Request};

/// Blocks of a pilot: as many as a part of the rays allows, within these limits.
const PILOT: [usize; 2] = [2, 32];
const PILOT_PART: f64 = 0.05;

/// The allowed truncation of a walk, relative to the requested half-width.
const CUT: f64 = 0.05;

/// Walks beyond those that are expected to be enough, and at least so many more of those that there are where they were not.
const SPARE: f64 = 1.05;

/// The most by which the number of walks grows before limits are looked at again.
const GROWTH: usize = 4;

/// One kind of walks.
pub(crate) trait Walker: Sync {
    /// The walks of one stream of random numbers.
    fn block(&self, seed: u64, stream: u64) -> Result<Block, Error>;

    /// Range of a walk's sum in each channel.
    fn ranges(&self) -> Vec<f64>;

    /// The deterministic part of each channel's mean, to which the walks add.
    fn deterministic_part(&self) -> Vec<f64>;

    /// Bound on the truncation of a walk's sum in each channel.
    fn leaves_out(&self) -> Vec<f64>;
}

/// Walks of one stream.
#[derive(Debug, Default)]
pub(crate) struct Block {
    /// The sum of each, at least and at most, channel by channel.
    pub(crate) sums: Vec<[f64; 2]>,
    pub(crate) rays: u64,
    /// The reflected weights, surface by surface and channel by channel; empty where they are not recorded.
    pub(crate) surfaces: Vec<f64>,
}

impl Block {
    fn column(&self, channel: usize, channels: usize, end: usize) -> impl Iterator<Item = f64> {
        self.sums.iter().skip(channel).step_by(channels).map(move |ends| ends[end])
    }
}

/// Walks, with the variances and costs that a pilot measured.
pub(crate) struct Trial<W> {
    pub(crate) walker: W,
    request: Request,
    /// The probability with which the limits of a channel fail.
    delta: f64,
    /// Names the random numbers.
    stream: u64,
    /// The range in each channel, or where it is infinite the largest sum of the pilot.
    scales: Vec<f64>,
    /// Moments of the pilot's sums over their scale.
    pilot: Vec<Moments>,
    pub(crate) rays: u64,
    rays_a_block: f64,
    walks_a_block: usize,
}

/// The limits from all walks so far.
pub(crate) struct Outcome {
    pub(crate) limits: Vec<Interval>,
    pub(crate) walks: usize,
    pub(crate) rays: u64,
    pub(crate) surfaces: Vec<f64>,
}

impl<W: Walker> Trial<W> {
    /// Makes a pilot. `kind` names the random numbers of these walks among others of the same seed; it is below 2^31.
    pub(crate) fn new(walker: W, request: &Request, delta: f64, kind: u64) -> Result<Self, Error> {
        let ranges = walker.ranges();
        let channels = ranges.len();
        let stream = kind << 33;
        let mut trial = Self {
            walker,
            request: *request,
            delta,
            stream: stream | 1 << 32,
            scales: Vec::new(),
            pilot: Vec::new(),
            rays: 0,
            rays_a_block: 0.0,
            walks_a_block: 0,
        };
        let mut drawn = trial.blocks(0..PILOT[0])?;
        let rays = |drawn: &[Block]| drawn.iter().map(|block| block.rays).sum::<u64>();
        let affordable = PILOT_PART * request.rays as f64 / (rays(&drawn) as f64 / PILOT[0] as f64);
        drawn.extend(trial.blocks(PILOT[0]..count(affordable.floor()).clamp(PILOT[0], PILOT[1]))?);
        (trial.stream, trial.rays) = (stream, rays(&drawn));
        trial.rays_a_block = trial.rays as f64 / drawn.len() as f64;
        trial.walks_a_block = drawn[0].sums.len() / channels;
        for (channel, range) in ranges.into_iter().enumerate() {
            let sums: Vec<f64> = drawn.iter().flat_map(|block| block.column(channel, channels, 1)).collect();
            let scale = if range.is_finite() { range } else { sums.iter().copied().fold(0.0, largest) };
            // Where nothing is emitted or was seen in a channel any scale will do.
            let scale = if scale > 0.0 { scale } else { 1.0 };
            trial.scales.push(scale);
            trial.pilot.push(Moments::new(sums.iter().map(|sum| sum / scale)));
        }
        Ok(trial)
    }

    /// Whether the pilot found anything.
    pub(crate) fn is_lit(&self) -> bool {
        self.pilot.iter().any(|pilot| pilot.mean > 0.0)
    }

    /// Bound on the truncation of the walks' sums in each channel.
    pub(crate) fn cut(&self) -> Vec<f64> {
        (0..self.pilot.len())
            .map(|channel| CUT * self.half_width(channel, self.pilot[channel].mean) * self.scales[channel])
            .collect()
    }

    /// The requested half-width, over the scale, where sums have this mean.
    fn half_width(&self, channel: usize, mean: f64) -> f64 {
        self.request.width * (mean + self.walker.deterministic_part()[channel] / self.scales[channel])
    }

    /// Walks that the requested width needs, by the pilot; infinite where that found nothing.
    fn draws(&self) -> f64 {
        let lit = self.pilot.iter().enumerate().filter(|(_, pilot)| pilot.mean > 0.0);
        let need = lit.map(|(channel, pilot)| draws(self.half_width(channel, pilot.mean), pilot.variance, self.delta));
        let largest_need = need.fold(0.0, largest);
        if largest_need > 0.0 { SPARE * largest_need } else { f64::INFINITY }
    }

    /// Rays that these need.
    pub(crate) fn work(&self) -> f64 {
        self.draws() * self.rays_a_block / self.walks_a_block as f64
    }

    fn blocks(&self, blocks: std::ops::Range<usize>) -> Result<Vec<Block>, Error> {
        blocks.into_par_iter().map(|block| self.walker.block(self.request.seed, self.stream | block as u64)).collect()
    }

    /// Makes walks until limits are as narrow as asked, or no ray is left.
    pub(crate) fn run(&self) -> Result<Outcome, Error> {
        let channels = self.scales.len();
        let leaves_out = self.walker.leaves_out();
        let ranges = self.walker.ranges();
        let mut bets: Vec<[Bets; 2]> = self.pilot.iter().map(|pilot| [0, 1].map(|_| Bets::new(self.delta, *pilot))).collect();
        let mut outcome = Outcome { limits: Vec::new(), walks: 0, rays: self.rays, surfaces: Vec::new() };
        let block_limit = count(self.request.rays as f64 / self.rays_a_block).max(1);
        let (mut blocks, mut planned) = (0, count(self.draws() / self.walks_a_block as f64));
        loop {
            planned = planned.clamp(blocks + 1, block_limit.max(blocks + 1));
            let last = planned.min(GROWTH * blocks.max(PILOT[1]));
            let drawn = self.blocks(blocks..last)?;
            blocks = last;
            for block in &drawn {
                outcome.rays += block.rays;
                outcome.surfaces.resize(block.surfaces.len(), 0.0);
                outcome.surfaces.iter_mut().zip(&block.surfaces).for_each(|(sum, more)| *sum += more);
            }
            within(&drawn, &ranges)?;
            let take = |(channel, bets): (usize, &mut [Bets; 2])| {
                for (end, bets) in bets.iter_mut().enumerate() {
                    let sums = drawn.iter().flat_map(|block| block.column(channel, channels, end));
                    bets.extend(sums.map(|sum| sum / self.scales[channel]), (planned * self.walks_a_block) as f64);
                }
                let upper = match ranges[channel] {
                    0.0 => 0.0,
                    range if range.is_finite() => bets[1].upper() * range + leaves_out[channel],
                    _ => f64::INFINITY,
                };
                Interval { lower: bets[0].lower() * self.scales[channel], upper }
            };
            outcome.limits = bets.par_iter_mut().enumerate().map(take).collect();
            outcome.walks = blocks * self.walks_a_block;
            let need = |(channel, [_, bets]): (usize, &[Bets; 2])| {
                let half_width = self.half_width(channel, bets.mean());
                let is_narrow = outcome.limits[channel].half_width() <= half_width * self.scales[channel];
                if is_narrow { 0.0 } else { draws(half_width, bets.variance(), self.delta) }
            };
            let need = bets.iter().enumerate().map(need).fold(0.0, largest);
            if need == 0.0 || blocks >= block_limit {
                return Ok(outcome);
            }
            planned = count(largest(need / self.walks_a_block as f64, blocks as f64) * SPARE);
        }
    }
}

/// Rounding of a walk's sum and of its range, relative.
const ROUNDING: f64 = 1e-12;

/// Refuses a sum that is beyond its range: no limits follow from it.
fn within(drawn: &[Block], ranges: &[f64]) -> Result<(), Error> {
    for block in drawn {
        for (&[_, value], &most) in block.sums.iter().zip(ranges.iter().cycle()) {
            if value > most * (1.0 + ROUNDING) || value.is_nan() {
                return Err(Error::BeyondRange { value, most });
            }
        }
    }
    Ok(())
}

/// A number of blocks that is not negative, rounded up.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "a cast saturates, and callers take the least of it and a limit"
)]
fn count(blocks: f64) -> usize {
    blocks.ceil() as usize
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use std::sync::Mutex;

    /// Sums of walks over their ranges, channel by channel, with limits of their means that fail with probability 1e-6, once for the least and
    /// once for the most that they may be. No sum is beyond its range.
    pub(crate) fn limits(walker: &impl Walker, blocks: u64) -> Result<Vec<[[f64; 2]; 2]>, Error> {
        let drawn: Vec<Block> = (0..blocks).map(|stream| walker.block(1, stream)).collect::<Result<_, _>>()?;
        let ranges = walker.ranges();
        let limit = |channel: usize, end: usize| {
            let column = drawn.iter().flat_map(|block| block.column(channel, ranges.len(), end));
            let sums: Vec<f64> = column.map(|sum| sum / ranges[channel]).collect();
            let largest_sum = sums.iter().copied().fold(0.0, largest);
            assert!(largest_sum <= 1.0 + 1e-9, "channel {channel}: {largest_sum} times the range");
            let mut bets = Bets::new(1e-6, Moments { count: 10.0, mean: 0.5, variance: 0.1 });
            bets.extend(sums.iter().copied(), sums.len() as f64);
            [bets.lower(), bets.upper()]
        };
        Ok((0..ranges.len()).map(|channel| [limit(channel, 0), limit(channel, 1)]).collect())
    }

    /// Walks of one step that record the random numbers they are given.
    struct Noted(Mutex<Vec<(u64, u64)>>);

    impl Walker for Noted {
        fn block(&self, seed: u64, stream: u64) -> Result<Block, Error> {
            self.0.lock().expect("no panic").push((seed, stream));
            let sums = (0..64).map(|walk| [f64::from(u8::from((stream + walk).is_multiple_of(7))); 2]).collect();
            Ok(Block { sums, rays: 64, surfaces: Vec::new() })
        }

        fn ranges(&self) -> Vec<f64> {
            vec![1.0]
        }

        fn deterministic_part(&self) -> Vec<f64> {
            vec![0.0]
        }

        fn leaves_out(&self) -> Vec<f64> {
            vec![0.0]
        }
    }

    #[test]
    fn no_random_numbers_are_used_twice() -> Result<(), Error> {
        let request = Request { width: 0.02, seed: 5, ..Request::default() };
        let mut numbers = Vec::new();
        for kind in [0, 1, 2, 3, 4] {
            let trial = Trial::new(Noted(Mutex::new(Vec::new())), &request, 1e-6, kind)?;
            let walks = trial.run()?.walks;
            let noted = trial.walker.0.into_inner().expect("no panic");
            assert!(noted.len() > PILOT[1] + walks / 64 - 1 && walks > 64 * GROWTH * PILOT[1]);
            assert!(noted.iter().all(|(seed, _)| *seed == 5));
            numbers.extend(noted);
        }
        let count = numbers.len();
        numbers.sort_unstable();
        numbers.dedup();
        assert_eq!(numbers.len(), count);
        Ok(())
    }
}
