//! Linear emitters as a structure of arrays: [`Group`]'s outlines, each with its own emission over its plane.

use std::ops::Range;

use fearless_simd::{Level, Simd};
use radgrad_numbers::in_library;
use radgrad_numbers::lanes::lane::{MOST_LANES, load};

use crate::batch::emitting::Emitting;
use crate::batch::linear::{AffineEmission, EmissionOnLanes, LinearSums, Vector, Wide};
use crate::batch::many_emitters::{Group, SeenFrom, Work, fits, lanes};
use crate::batch::tile::{Goal, Settled};
use crate::batch::visible::Outline;
use crate::problem::emission::Emitter;

/// Linear emitters with as many vertices each.
#[derive(Debug, Clone)]
pub(in crate::batch) struct LinearGroup {
    pub(in crate::batch) outlines: Group<f64>,
    emissions: AffineEmissions,
}

/// Their emissions, as long as the group's arrays.
#[derive(Debug, Clone)]
pub(in crate::batch) struct AffineEmissions {
    /// Emission at each vertex in turn.
    at_vertices: Vec<Vec<f64>>,
    gradient: [Vec<f64>; 3],
    largest: Vec<f64>,
    steepness: Vec<f64>,
    /// [`AffineEmission::scale`].
    scale: Vec<f64>,
}

/// Whether an emitter can go on lanes with others, all lengths times a power of two.
pub(in crate::batch) fn goes_on_lanes(emitter: &Emitter, power: f64) -> bool {
    fits::<f64>(emitter, power) && AffineEmission::new(emitter, power).is_some()
}

impl LinearGroup {
    /// The emitters of these indices, all with as many vertices and fit for lanes.
    pub(in crate::batch) fn new(emitters: &[Emitter], index: Vec<usize>, power: f64) -> Self {
        let emissions: Vec<AffineEmission> = index.iter().filter_map(|i| AffineEmission::new(&emitters[*i], power)).collect();
        let array = |entry: &dyn Fn(&AffineEmission) -> f64| -> Vec<f64> {
            emissions.iter().chain(std::iter::repeat_n(emissions.last(), MOST_LANES).flatten()).map(entry).collect()
        };
        let count = emissions.first().map_or(0, |emission| emission.at_vertices.len());
        let brightness = array(&|emission| emission.brightness);
        Self {
            emissions: AffineEmissions {
                at_vertices: (0..count).map(|k| array(&|emission| emission.at_vertices[k])).collect(),
                gradient: [0, 1, 2].map(|axis| array(&|emission| emission.gradient[axis])),
                largest: array(&|emission| emission.largest),
                steepness: array(&|emission| emission.steepness),
                scale: array(&|emission| emission.scale),
            },
            outlines: Group::with_brightness(emitters, index, power, brightness),
        }
    }

    /// The answers for a range of emitters, at most a tile long.
    pub(in crate::batch) fn answer(
        &self,
        level: Level,
        seen: &SeenFrom<f64>,
        range: Range<usize>,
        goal: Goal,
        work: &mut Work<f64>,
    ) -> Settled {
        let Self { outlines, emissions } = self;
        work.answered(range, goal, |start, slots| {
            let tile = (outlines, start, emissions);
            if goal.asked.gradient {
                in_library!([as_avx512 as_avx2 as_sse2] level, simd => lanes::<_, f64, _, true>(simd, tile, seen, goal, slots))
            } else {
                in_library!([as_avx512 as_avx2 as_sse2] level, simd => lanes::<_, f64, _, false>(simd, tile, seen, goal, slots))
            }
        })
    }

    /// The emission at a vertex, in units of the brightness.
    pub(in crate::batch) fn at_vertex(&self, vertex: usize) -> &[f64] {
        &self.emissions.at_vertices[vertex]
    }

    /// The size that errors of an emitter's emission are relative to.
    pub(in crate::batch) fn scale(&self, entry: usize) -> f64 {
        self.emissions.scale[entry]
    }
}

/// The emissions of a vector of emitters.
pub(in crate::batch) struct EmissionBlock<'a> {
    emissions: &'a AffineEmissions,
    first: usize,
}

impl<S: Simd> EmissionOnLanes<S> for EmissionBlock<'_> {
    #[inline(always)]
    fn ends(&self, simd: S, index: usize) -> [Wide<S>; 2] {
        let vertices = &self.emissions.at_vertices;
        let next = if index + 1 == vertices.len() { 0 } else { index + 1 };
        [Wide::load(simd, &vertices[index][self.first..]), Wide::load(simd, &vertices[next][self.first..])]
    }
    #[inline(always)]
    fn gradient(&self, simd: S) -> Vector<S> {
        let [x, y, z] = &self.emissions.gradient;
        load(simd, [&x[self.first..], &y[self.first..], &z[self.first..]])
    }
    #[inline(always)]
    fn steepness(&self, simd: S) -> Wide<S> {
        Wide::load(simd, &self.emissions.steepness[self.first..])
    }
    #[inline(always)]
    fn largest(&self, simd: S) -> Wide<S> {
        Wide::load(simd, &self.emissions.largest[self.first..])
    }
}

impl<'a, S: Simd> Emitting<S, f64> for &'a AffineEmissions {
    type Sums = LinearSums<S, EmissionBlock<'a>>;

    #[inline(always)]
    fn sums<O: Outline<S, f64>>(&self, simd: S, first: usize, outline: &O, x: Vector<S>, n1: Vector<S>) -> Self::Sums {
        LinearSums::new(simd, EmissionBlock { emissions: self, first }, outline, x, n1)
    }
}
