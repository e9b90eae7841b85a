//! The light of a cluster at a point, by rays from the point.
//!
//! Rays leave the point in directions that are spread as the cosine with its normal is, so that each brings the same part of the
//! hemisphere (P. Shirley 1990, final gathers). Of N rays h meet a cluster first: its form factor is h/N, and its light is h/N
//! times its mean radiosity. That is neither too much nor too little in the mean over many points, whichever face hides another; in a
//! closed room all parts together are 1; and nothing is singular where the point touches the cluster. Each point has directions
//! of its own, so that the errors of many are without order. Clusters are opened by one draw and gathered from by another, since
//! those that a draw gives too little would be opened less often.
//!
//! The error at a point is taken to be the deviation of h, for a cluster that no ray met as if the next one might, as far as its
//! view allows; and where the radiosity is uneven, its deviation if the point sees half of the cluster.

use radgrad_scene::smallest;

use crate::bytes::bytes_of;
use crate::links::cluster::view::View;
use crate::links::station::Station;
use crate::links::transfer::Optics;
use crate::mesh::glow::ClusterEmission;
use crate::mesh::rule::STEPS;

/// Rays from a node, at least and at most; and those from a point that is asked for.
pub(crate) const FEWEST_RAYS: usize = 8;
pub(crate) const MOST_RAYS: usize = 1024;
pub(crate) const RAYS_OF_A_POINT: usize = 512;

/// Deviation of the visible kernel over a cluster, by its mean: 1 where half of the cluster is seen.
const UNEVEN: f64 = 1.0;

/// A point's view of a cluster: a bound by geometry, and the estimate of rays.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Seen {
    pub(crate) view: View,
    /// The mean of the visible kernel, the factor of the power in the irradiance.
    pub(crate) weight: f64,
    /// Deviation of that.
    deviation: f64,
    area: f64,
}

impl Seen {
    /// The gather at a point of a quantity that is nowhere negative, by its integral and its largest value.
    pub(crate) fn gathers(&self, whole: f64, largest: f64) -> f64 {
        let kernel = self.weight + self.deviation;
        if kernel == 0.0 || largest == 0.0 { 0.0 } else { kernel * smallest(whole, self.area * largest) }
    }

    /// Deviation of the light of a cluster that glows so, by the rays alone.
    pub(crate) fn noise(&self, glow: &ClusterEmission) -> f64 {
        self.deviation * glow.power
    }

    /// The error by the cluster's uneven emission.
    pub(crate) fn uneven(&self, glow: &ClusterEmission) -> f64 {
        UNEVEN * self.weight * glow.unevenness
    }
}

/// Which directions are drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Draw {
    /// To decide which clusters are opened.
    First,
    /// To gather from them.
    Second,
}

/// The faces that rays from a point meet.
#[derive(Debug)]
pub(crate) struct Rays {
    /// The clusters of the elements, each one alone, in order.
    met: Vec<usize>,
    count: usize,
}

/// Numbers from 0 to 1 in the order of splitmix64 (S. Vigna 2015). They follow from the digits of a place, not from its unit of length.
pub(crate) struct Numbers(u64);

impl Numbers {
    pub(crate) const fn from_seed(seed: u64) -> Self {
        Self(seed)
    }

    fn seeded(station: &Station, draw: Draw) -> Self {
        let digits = station.point.to_array().map(|x| x.to_bits() & ((1 << 52) - 1));
        let mut numbers = Self(u64::from(draw == Draw::Second));
        for digits in digits {
            numbers.0 ^= digits;
            numbers.0 = numbers.word();
        }
        numbers
    }

    fn word(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    pub(crate) fn next(&mut self) -> f64 {
        (self.word() >> 11) as f64 * (0.5 * f64::EPSILON)
    }
}

impl Optics<'_> {
    /// So many rays from a point.
    pub(crate) fn rays(&self, station: &Station, count: usize, draw: Draw) -> Rays {
        let mut numbers = Numbers::seeded(station, draw);
        let start = [numbers.next(), numbers.next()];
        let (across, along) = station.normal.any_orthonormal_pair();
        // Places on the disc below the hemisphere are spread evenly (T. Malley).
        let on_disc = |index: usize| {
            let [x, y] = [0, 1].map(|axis| 2.0 * (start[axis] + STEPS[axis] * index as f64).fract() - 1.0);
            let square = x * x + y * y;
            (square < 1.0).then(|| across * x + along * y + station.normal * (1.0 - square).sqrt())
        };
        let directions = (0..).filter_map(on_disc).take(count);
        let mut met: Vec<usize> = directions.filter_map(|toward| self.mesh.met(station.point, toward, station.face)).collect();
        met.sort_unstable();
        Rays { met, count }
    }

    /// A point's view of a cluster.
    pub(crate) fn look(&self, station: &Station, rays: &Rays, cluster: usize) -> Seen {
        let (tree, of) = (self.mesh.clusters(), &self.mesh.clusters().clusters()[cluster]);
        let view = of.view(station);
        if view.factor == 0.0 {
            return Seen { view, ..Seen::default() };
        }
        let (within, all) = (tree.within(cluster), rays.count as f64);
        let before = |end: usize| rays.met.partition_point(|&met| met < end);
        let hits = (before(within.end) - before(within.start)) as f64;
        let square = if hits > 0.0 { hits * (1.0 - hits / all) } else { smallest(1.0, all * smallest(view.factor, 1.0)) };
        let unit = 1.0 / (all * of.area());
        Seen { view, weight: hits * unit, deviation: square.sqrt() * unit, area: of.area() }
    }
}

bytes_of!(Seen { view, weight, deviation, area });
