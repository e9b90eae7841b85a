//! Radiosity (HS95 Eq. 1) and its gradient by Monte Carlo, past any opaque polygons: intervals at a stated confidence.
//!
//! A sample is the contribution of one point of the emitter, blocked or not, and for the gradient of one point of the
//! generating edges (`silhouette`). Each quantity comes with two intervals: Student's, which needs a mean close to normal, and
//! a distribution-free one from the range that the geometry allows a contribution. A mean that rests on the equivalent of fewer
//! than 50 full contributions is [`Status::TooFewHits`], and then both intervals are the distribution-free one: a peak that no
//! sample found, or an emitter seen through a keyhole, cannot look converged.
//!
//! With a randomised sequence a sample is the mean over one scrambling, so the intervals rest on the number of scramblings.

mod arc;
pub(crate) mod sampling;
mod silhouette;
mod sobol;
mod visibility;

use radgrad_core::{Emitter, Polygon, Receiver};
use rand::rngs::Xoshiro256PlusPlus;
use rand::{Rng, SeedableRng};
use rand_distr::{Distribution, StandardUniform};

use crate::Error;
use crate::confidence::{ConfidenceInterval, Moments, check_confidence};
use crate::cubature::integrand::Integrand;
use crate::cubature::piece::Four;
use crate::emission_function::EmissionBounds;
use crate::monte_carlo::sampling::Sampler;
pub use crate::monte_carlo::sampling::Sampling;
use crate::monte_carlo::silhouette::Silhouette;
use crate::monte_carlo::sobol::ScrambledSobol;
use crate::monte_carlo::visibility::Occluders;
use crate::region::plane::Triangle;
use crate::region::{FrameVector, Region};
use crate::source_function::SourceFunction;

/// Where the points of the unit square come from; the same seed gives the same points on every machine.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Sequence {
    /// Independent points by xoshiro256++ (Blackman and Vigna 2021), seeded by `SplitMix64`.
    Independent {
        /// Points.
        samples: usize,
        /// Seed.
        seed: u64,
    },
    /// The Sobol sequence, scrambled independently several times.
    Sobol {
        /// Points of each scrambling; a power of two makes them a net.
        samples: u32,
        /// Scramblings.
        scramblings: usize,
        /// Seed.
        seed: u64,
    },
}

/// The basis of an estimate.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Status {
    /// Nothing of the emitter is in view, occluders aside: exactly zero.
    Zero,
    /// Enough contributions for Student's limits.
    Sampled,
    /// Too few for a normal mean: only the distribution-free limits are given.
    TooFewHits,
}

/// A number estimated by sampling.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Limits {
    /// Mean of the samples.
    pub mean: f64,
    /// Interval at the stated confidence if the mean is close to normal.
    pub student: ConfidenceInterval,
    /// Interval at the stated confidence whatever the distribution.
    pub distribution_free: ConfidenceInterval,
    /// The basis of the limits.
    pub status: Status,
}

/// Radiosity and gradient with their limits.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Estimate {
    /// Radiosity `B(x)`.
    pub radiosity: Limits,
    /// Components of its gradient with respect to `x` at fixed normal.
    pub gradient: [Limits; 3],
    /// Points drawn on the emitter.
    pub samples: usize,
    /// Points among them that were seen.
    pub hits: usize,
}

/// Equivalent number of largest possible contributions below which a mean is not taken for normal. The coverage test measures
/// the coverage of Student's limits above it.
const FEWEST_HITS: f64 = 50.0;

/// Units of rounding in one sample: its point, its weight and the integrand are some forty operations without cancellation.
const ROUNDINGS_OF_A_SAMPLE: f64 = 64.0;

/// Radiosity and gradient of `emitter` at `receiver` with opaque `occluders`, with limits at the given `confidence` each. Where
/// an occluder crosses the emitter itself the gradient lacks the term of that line.
///
/// ```
/// use radgrad_core::{DVec3, Emission, Emitter, Polygon, Receiver};
/// use radgrad_oracle::monte_carlo::{Sampling, Sequence, integrate};
/// let triangle = Polygon::new(vec![DVec3::new(0.0, 0.0, 1.0), DVec3::new(0.0, 1.0, 1.0), DVec3::new(1.0, 0.0, 1.0)])?;
/// let emitter = Emitter::new(triangle, Emission::Constant(1.0))?;
/// let receiver = Receiver::new(DVec3::ZERO, DVec3::Z, 1.0)?;
/// let sequence = Sequence::Independent { samples: 10_000, seed: 1 };
/// let estimate = integrate(&receiver, &emitter, &[], Sampling::SolidAngle, sequence, 0.99)?;
/// let exact = radgrad_oracle::cubature::integrate(&receiver, &emitter, 1e-10, 100_000)?;
/// assert!(estimate.radiosity.distribution_free.contains(exact.radiosity));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// If the confidence is not between 0 and 1, there are fewer than two samples or scramblings, or the receiver touches the
/// emitter or an edge.
pub fn integrate(
    receiver: &Receiver,
    emitter: &Emitter,
    occluders: &[Polygon],
    sampling: Sampling,
    sequence: Sequence,
    confidence: f64,
) -> Result<Estimate, Error> {
    let source = SourceFunction::Emitter(emitter);
    integrate_source(receiver, emitter.polygon(), source, occluders, sampling, sequence, confidence)
}

/// The same for any emission over `polygon`: a function needs its gradient and its bounds.
///
/// # Errors
/// As [`integrate`], or if a function lacks one of the two.
pub fn integrate_source(
    receiver: &Receiver,
    polygon: &Polygon,
    source: SourceFunction<'_>,
    occluders: &[Polygon],
    sampling: Sampling,
    sequence: Sequence,
    confidence: f64,
) -> Result<Estimate, Error> {
    check_confidence(confidence)?;
    sequence.check()?;
    source.check(true, "Monte Carlo")?;
    let bounds = source.bounds()?;
    let region = Region::new(receiver, polygon, &source)?;
    if region.touched {
        return Err(Error::Touching { position: receiver.position(), what: "the emitter" });
    }
    if region.triangles.is_empty() {
        let zero = Limits::zero();
        return Ok(Estimate { radiosity: zero, gradient: [zero; 3], samples: 0, hits: 0 });
    }
    let occluders = Occluders::new(receiver.position(), region.unit, occluders);
    let integrand = Integrand::new(&region, source);
    let estimator = Estimator {
        sampler: Sampler::new(&region, sampling),
        silhouette: Silhouette::new(&region, integrand, &occluders)?,
        integrand,
        occluders: &occluders,
        region: &region,
    };
    estimator.run(sequence).limits(estimator.ranges(bounds, sampling), &region, confidence)
}

impl Sequence {
    fn check(self) -> Result<(), Error> {
        let (what, value) = match self {
            Self::Independent { samples, .. } => ("samples", samples),
            Self::Sobol { scramblings, .. } => ("scramblings", scramblings),
        };
        if value < 2 {
            return Err(Error::TooFewSamples { what, value, least: 2 });
        }
        match self {
            Self::Sobol { samples: 0, .. } => Err(Error::TooFewSamples { what: "samples", value: 0, least: 1 }),
            _ => Ok(()),
        }
    }
}

/// All that one sample needs.
struct Estimator<'a> {
    sampler: Sampler<'a>,
    silhouette: Silhouette<'a>,
    integrand: Integrand<'a>,
    occluders: &'a Occluders,
    region: &'a Region,
}

/// Moments of the samples of value and gradient components, and mean magnitudes.
#[derive(Default)]
struct Tally {
    moments: [Moments; 4],
    magnitudes: [Moments; 4],
    samples: usize,
    hits: usize,
}

impl Estimator<'_> {
    fn run(&self, sequence: Sequence) -> Tally {
        let mut tally = Tally::default();
        match sequence {
            Sequence::Independent { samples, seed } => {
                let mut generator = Xoshiro256PlusPlus::seed_from_u64(seed);
                let mut uniform = || StandardUniform.sample(&mut generator);
                for _ in 0..samples {
                    let (on_emitter, on_edges) = ([uniform(), uniform()], [uniform(), uniform()]);
                    let contribution = self.sample(on_emitter, on_edges, &mut tally);
                    tally.add(contribution);
                }
            }
            Sequence::Sobol { samples, scramblings, seed } => {
                let mut generator = Xoshiro256PlusPlus::seed_from_u64(seed);
                for _ in 0..scramblings {
                    let [surface, edges] = [(); 2].map(|()| ScrambledSobol::new(generator.next_u64()));
                    let mut sums = [0.0; 4];
                    for index in 0..samples {
                        let contribution = self.sample(surface.point(index), edges.point(index), &mut tally);
                        sums = [0, 1, 2, 3].map(|i| sums[i] + contribution[i]);
                    }
                    tally.add(sums.map(|sum| sum / f64::from(samples)));
                }
            }
        }
        tally
    }

    /// One contribution to radiosity and gradient.
    fn sample(&self, on_emitter: [f64; 2], on_edges: [f64; 2], tally: &mut Tally) -> Four {
        let (at, weight) = self.sampler.point(on_emitter);
        let (ray, _) = self.integrand.ray(&at);
        let mut sum = [0.0; 4];
        tally.samples += 1;
        if !self.occluders.block(self.region.to_space(ray)) {
            tally.hits += 1;
            let [value, gu, gv, gn] = self.integrand.boundary_surface(&at);
            let gradient = self.region.to_space(FrameVector::new(gu, gv, gn));
            sum = [value, gradient.x, gradient.y, gradient.z].map(|f| f * weight);
        }
        let along_edges = self.silhouette.sample(on_edges);
        sum = [sum[0], sum[1] + along_edges.x, sum[2] + along_edges.y, sum[3] + along_edges.z];
        let magnitudes = sum.map(f64::abs);
        for (moments, magnitude) in tally.magnitudes.iter_mut().zip(magnitudes) {
            moments.add(magnitude);
        }
        sum
    }

    /// Ranges of a contribution to the value and to a component of the gradient, before the factor `rho/pi`: with `c <= 1` the
    /// largest cosine at the receiver and `d` the smallest distance, `B s h/r^4 <= B c h/d^3` and `|h g + (r.g) n2| s/r^4 <=
    /// |g| c/d^2` per area; `B c` and `|g| s/h` per solid angle.
    fn ranges(&self, bounds: EmissionBounds, sampling: Sampling) -> [ConfidenceInterval; 2] {
        let emitted = bounds.range;
        let emission = emitted.low.abs().max(emitted.high.abs());
        let gradient = bounds.steepest / self.region.unit;
        let corners = || self.region.triangles.iter().flat_map(|triangle: &Triangle| triangle.corners);
        let largest = corners().map(|corner| corner.s).fold(0.0, f64::max);
        let distance = self.region.squared_distance().sqrt();
        let cosine = (largest / distance).min(1.0);
        let height = self.region.height;
        let [value, slope] = match sampling {
            Sampling::Area => [cosine * height / (distance * distance * distance), cosine / (distance * distance)],
            Sampling::SolidAngle => [cosine, largest / height],
        };
        let value = self.sampler.total() * value;
        let gradient = self.sampler.total() * gradient * slope + self.silhouette.total() * emission;
        let value = ConfidenceInterval { low: value * emitted.low.min(0.0), high: value * emitted.high.max(0.0) };
        let gradient = ConfidenceInterval { low: -gradient, high: gradient };
        // The bounds are rounded as a sample is.
        [value, gradient].map(|range| range.scaled(1.0 + ROUNDINGS_OF_A_SAMPLE * f64::EPSILON))
    }
}

impl Tally {
    fn add(&mut self, sample: Four) {
        for (moments, value) in self.moments.iter_mut().zip(sample) {
            moments.add(value);
        }
    }

    /// Bound on the rounding of a mean: that of each addition to it, and of its samples. Without it the limits of samples that
    /// hardly differ, such as those of an emitter 1e8 sizes away by solid angle, would be narrower than the digits they are
    /// made of.
    fn rounding(&self, magnitude: f64) -> f64 {
        (self.samples as f64 + ROUNDINGS_OF_A_SAMPLE) * f64::EPSILON * magnitude
    }

    fn limits(&self, [value, gradient]: [ConfidenceInterval; 2], region: &Region, confidence: f64) -> Result<Estimate, Error> {
        let magnitude = |i: usize| self.magnitudes[i].mean();
        // A component is a sum of three of the frame of the region.
        let of_gradient = self.rounding(magnitude(1) + magnitude(2) + magnitude(3));
        let limits = |i: usize, range: ConfidenceInterval, factor: f64| -> Result<Limits, Error> {
            let moments = &self.moments[i];
            let rounding = if i == 0 { self.rounding(magnitude(0)) } else { of_gradient };
            let distribution_free = moments.distribution_free(confidence, range).widened(rounding).within(range).scaled(factor);
            let equivalent = magnitude(i) * self.samples as f64 / range.low.abs().max(range.high);
            let (student, status) = if equivalent >= FEWEST_HITS {
                (moments.student(confidence)?.widened(rounding).scaled(factor), Status::Sampled)
            } else {
                (distribution_free, Status::TooFewHits)
            };
            let mean = factor * moments.mean();
            if mean.is_finite() && distribution_free.width().is_finite() {
                Ok(Limits { mean, student, distribution_free, status })
            } else {
                Err(Error::NotFinite { quantity: "a mean of samples or its limit", value: distribution_free.high })
            }
        };
        let component = |i: usize| limits(i, gradient, region.factor * region.unit);
        let radiosity = limits(0, value, region.factor)?;
        let gradient = [component(1)?, component(2)?, component(3)?];
        Ok(Estimate { radiosity, gradient, samples: self.samples, hits: self.hits })
    }
}

impl Limits {
    const fn zero() -> Self {
        let nothing = ConfidenceInterval { low: 0.0, high: 0.0 };
        Self { mean: 0.0, student: nothing, distribution_free: nothing, status: Status::Zero }
    }
}
