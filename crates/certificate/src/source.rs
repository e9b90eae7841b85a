//! Where walks begin, so that each brings light to where it first arrives.
//!
//! - From lamps: a lamp by its power, a point of it, a direction by the cosine. Cheap, but where lamps shine past almost all of the scene, as a
//!   sun through a slit, next to none arrives.
//! - From pairs of a part of a lamp and a part of a face ([`pairs`]), by the most that one may give the other.
//!
//! Either way the power is a number known beforehand times a number in `[0, 1]`, whose mean the walks estimate.

mod pairs;

use radgrad_scene::largest;
use rand::RngExt;
use rand::rngs::ChaCha8Rng;

use crate::model::Model;
use crate::paths::{Tally, Walks, by_cosine};
use pairs::Pair;
pub(crate) use pairs::largest_factor;

/// Where walks begin.
#[derive(Debug, Clone)]
pub(crate) struct Source {
    origins: Origins,
    /// Bounds on the power that each origin sends out, in the brightest channel, summed up to it.
    sums: Vec<f64>,
    /// Bound in each channel on the weight at the first arrival.
    shares: Vec<f64>,
}

#[derive(Debug, Clone)]
enum Origins {
    Lamps(Vec<usize>),
    Pairs(Vec<Pair>),
}

impl Source {
    /// All lamps.
    pub(crate) fn lamps(model: &Model<'_>) -> Self {
        let lamps: Vec<usize> = model.lamps().map(|(lamp, _)| lamp).collect();
        let powers: Vec<f64> = lamps.iter().map(|&lamp| model.faces[lamp].brightest() * model.faces[lamp].area).collect();
        Self::new(model, Origins::Lamps(lamps), powers.into_iter())
    }

    /// Pairs of parts of lamps and of faces, where they are not too many.
    pub(crate) fn pairs(model: &Model<'_>) -> Option<Self> {
        let pairs = pairs::pairs(model)?;
        let powers: Vec<f64> = pairs.iter().map(Pair::power).collect();
        Some(Self::new(model, Origins::Pairs(pairs), powers.into_iter()))
    }

    fn new(model: &Model<'_>, origins: Origins, powers: impl Iterator<Item = f64>) -> Self {
        let sums = powers.scan(0.0, |sum, power| {
            *sum += power;
            Some(*sum)
        });
        let share = |channel: usize| model.lamps().map(|(_, lamp)| lamp.emission[channel] / lamp.brightest()).fold(0.0, largest);
        Self { origins, sums: sums.collect(), shares: (0..model.channels).map(share).collect() }
    }

    /// The bound on the power of all origins.
    pub(crate) fn power(&self) -> f64 {
        self.sums.last().copied().unwrap_or(0.0)
    }

    /// Bound in each channel on the sum of a walk.
    pub(crate) fn ranges(&self, walks: &Walks<'_>) -> Vec<f64> {
        self.shares
            .iter()
            .zip(&walks.weight_limits)
            .map(|(share, limit)| if *share == 0.0 { 0.0 } else { share * limit })
            .collect()
    }

    /// One walk, with weights relative to [`Self::power`].
    pub(crate) fn walk(&self, walks: &Walks<'_>, generator: &mut ChaCha8Rng, weights: &mut [f64], tally: &mut Tally) {
        let place = generator.random::<f64>() * self.power();
        let origin = self.sums.partition_point(|sum| *sum <= place).min(self.sums.len() - 1);
        let model = walks.model;
        let (lamp, point, hit) = match &self.origins {
            Origins::Lamps(lamps) => {
                let lamp = lamps[origin];
                let point = model.faces[lamp].point(generator);
                tally.rays += 1;
                (lamp, point, model.hit(Some(lamp), point, by_cosine(model.faces[lamp].normal, generator)).map(|hit| (hit, 1.0)))
            }
            Origins::Pairs(pairs) => {
                tally.rays += 1;
                let (point, hit) = pairs[origin].draw(model, generator);
                (pairs[origin].lamp, point, hit)
            }
        };
        let Some((hit, share)) = hit else { return };
        weights.fill(share / model.faces[lamp].brightest());
        model.emit(lamp, point, weights);
        walks.arrive(hit, weights, generator, tally);
    }
}
