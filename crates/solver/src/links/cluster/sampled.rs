//! What a point gets of a cluster, by a few points of it.
//!
//! With points `y_k` chosen by area the light of an even radiosity is `P mean(V k(x, y_k))`, P the power: what light cuts do (B. Walter et
//! al. 2005), with as many rays as points. Each receiving point has its own `y_k`, one in each of as many parts of the area and at random
//! there: the mean over many receiving points is right where that at each is not, and their errors are without order. A mean above what is
//! proven of the cluster's view gives way to that. Clusters are opened by
//! one draw and gathered from by another, since those that a draw gives too little would be opened less often.
//!
//! The error at a point is taken to be the deviation of the mean as the samples' spread says, and a part of what more is possible: all of it
//! where the point is nearer than the cluster is wide, as samples miss what is near, which gives most.
//! Where the radiosity is not even either may be large where the other is: half of what that gives at most.

use radgrad_core::DVec3;
use radgrad_scene::smallest;

use crate::links::cluster::glow::Glow;
use crate::links::cluster::view::View;
use crate::links::rays::kernel;
use crate::links::station::Station;
use crate::links::transfer::Optics;
use crate::mesh::clusters::Sample;

/// Points of a cluster by which what a point gets of it is estimated.
const SAMPLES: usize = 4;

/// The part of what is possible beyond the samples' mean that they are off by, from afar.
const MISSED: f64 = 0.2;

/// A point's view of a cluster: what is proven, and what is estimated.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Seen {
    pub(crate) view: View,
    /// The mean of the visible kernel, the factor of the power in the irradiance.
    pub(crate) weight: f64,
    /// Deviation of that mean, and of the kernel.
    off: f64,
    spread: f64,
    area: f64,
}

impl Seen {
    /// What a point gets of something that is nowhere negative, by its integral and its largest value.
    pub(crate) fn gathers(&self, whole: f64, largest: f64) -> f64 {
        let kernel = self.weight + self.off;
        if kernel == 0.0 || largest == 0.0 { 0.0 } else { kernel * smallest(whole, self.area * largest) }
    }

    /// Deviation of the light of a cluster that glows so.
    pub(crate) fn deviation(&self, glow: &Glow) -> f64 {
        (self.off * glow.power).hypot(0.5 * self.spread * glow.unevenness)
    }
}

/// Which samples are drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Draw {
    /// To decide which clusters are opened.
    First,
    /// To gather from them.
    Second,
}

/// Numbers from 0 to 1 in the order of splitmix64 (S. Vigna 2015). They follow from the digits of a place, not from its unit of length.
struct Numbers(u64);

impl Numbers {
    fn of(station: &Station, cluster: usize, draw: Draw) -> Self {
        let digits = station.point.to_array().map(|x| x.to_bits() & ((1 << 52) - 1));
        let mut numbers = Self(2 * cluster as u64 + u64::from(draw == Draw::Second));
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

    fn next(&mut self) -> f64 {
        (self.word() >> 11) as f64 * (0.5 * f64::EPSILON)
    }
}

impl Optics<'_> {
    /// A point's view of a cluster.
    pub(crate) fn look(&self, station: &Station, cluster: usize, draw: Draw) -> Seen {
        let (tree, of) = (self.mesh.clusters(), &self.mesh.clusters().all()[cluster]);
        let view = of.view(station);
        if view.factor == 0.0 {
            return Seen { view, ..Seen::default() };
        }
        let most = smallest(view.peak, view.factor / of.area());
        let mut numbers = Numbers::of(station, cluster, draw);
        let samples: [Sample; SAMPLES] = std::array::from_fn(|part| {
            let among = (part as f64 + numbers.next()) / SAMPLES as f64;
            tree.sample(self.mesh.elements(), cluster, among, [numbers.next(), numbers.next()])
        });
        let visible = samples.map(|sample| match kernel(station, sample.point, sample.normal) {
            kernel if kernel > 0.0 && self.sees(station, sample.point, sample.face) => kernel,
            _ => 0.0,
        });
        let count = SAMPLES as f64;
        let mean = visible.iter().sum::<f64>() / count;
        let spread = (visible.iter().map(|kernel| (kernel - mean) * (kernel - mean)).sum::<f64>() / (count - 1.0)).sqrt();
        let (low, high) = (of.low - station.point, of.high - station.point);
        let nearest = low.max(DVec3::ZERO) + high.min(DVec3::ZERO);
        let missed = if 2.0 * nearest.length() < (high - low).length() { 1.0 } else { MISSED };
        let [weight, spread] = [mean, spread].map(|of| smallest(of, most));
        Seen { view, weight, off: (spread / count.sqrt()).hypot(missed * (most - weight)), spread, area: of.area() }
    }
}
