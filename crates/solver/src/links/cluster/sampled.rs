//! What a point gets of a cluster, by a few points of it.
//!
//! With points `y_k` chosen by area the light of an even radiosity is `P mean(V k(x, y_k))`, P the power: what light cuts do (B. Walter et
//! al. 2005), with as many rays as points. It is no more than what is proven of the cluster's view, which counts where it is less. Its
//! error is taken to be the deviation of that mean as the samples' spread says, and a part of what more is possible: all of it where the
//! point is nearer than the cluster is wide, as samples miss what is near, which gives most.
//! Where the radiosity is not even either may be large where the other is: half of what that gives at most.

use radgrad_core::DVec3;
use radgrad_scene::smallest;

use crate::links::cluster::glow::Glow;
use crate::links::cluster::view::View;
use crate::links::rays::kernel;
use crate::links::station::Station;
use crate::links::transfer::Optics;
use crate::mesh::clusters::SAMPLES;

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

impl Optics<'_> {
    /// A point's view of a cluster.
    pub(crate) fn look(&self, station: &Station, cluster: usize) -> Seen {
        let (tree, of) = (self.mesh.clusters(), &self.mesh.clusters().all()[cluster]);
        let view = of.view(station);
        if view.factor == 0.0 {
            return Seen { view, ..Seen::default() };
        }
        let most = smallest(view.peak, view.factor / of.area());
        let visible = tree.samples(cluster).map(|sample| match kernel(station, sample.point, sample.normal) {
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
