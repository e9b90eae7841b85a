//! Bounds at points: `|e| <= rho |G r| + rho G |e|`.
//!
//! Of |e| a point gathers from a source at most F times its largest value and `k_max` times its mean, k the kernel times the
//! area. Means over receivers come first: with `F_y` the form factor to receiver i from a place y of receiver j,
//! `A_i mean_i G f = int f F_y dy <= A_j mean_j(f) max F_y`. The largest values then are those at the nodes.

use rayon::prelude::*;

use super::rise::Risen;
use super::{Bounds, Residuals, Scene, Seen};
use crate::ledger::Ledger;
use crate::mesh::Mesh;
use crate::residual::Found;
use crate::transfer::{Row, Station};

/// Sweeps in which means over receivers come down.
const MEAN_SWEEPS: usize = 8;

/// Bounds on the error of gathers at points.
#[derive(Debug)]
pub(crate) struct Points {
    /// Whether each element is a receiver.
    receives: Vec<bool>,
    /// For each element, channel after channel, the mean over it, and the largest value at its nodes; `None` if there is no bound.
    means: Vec<f64>,
    risen: Option<Risen>,
    channels: usize,
}

impl Points {
    /// From a bound on the mean.
    pub(super) fn of(scene: Scene<'_>, bounds: &Bounds) -> Self {
        let Scene { mesh, receivers, links, channels, .. } = scene;
        let receives = scene.receives();
        let seen = scene.seen(&receives);
        let own = |(index, &receiver): (usize, &usize)| -> Vec<f64> {
            let of_node = |channel: usize, node: usize| {
                let rows = links[receiver].iter().map(|link| (link.source, &link.rows[node]));
                let sum = bounds.gathered(mesh, channel, rows, (&seen[index], node)).total();
                sum * scene.reflectance(receiver, channel)
            };
            let nodes = seen[index].nodes;
            (0..channels).flat_map(|channel| (0..nodes).map(move |node| (channel, node))).map(|(c, n)| of_node(c, n)).collect()
        };
        let own: Vec<Vec<f64>> = receivers.par_iter().enumerate().map(own).collect();
        // Each time from a bound that holds: at first a point may gather the largest error from everywhere.
        let mut means = vec![0.0; mesh.elements().len() * channels];
        receivers.iter().for_each(|&receiver| means[receiver * channels..(receiver + 1) * channels].fill(f64::INFINITY));
        scene.pull(&receives, &mut means, |of| 0.25 * of.iter().sum::<f64>());
        let mut risen = Risen::of(scene, &receives, &seen, &own, &means);
        if let Some(first) = &risen {
            scene.spread(&receives, &seen, bounds, first, &mut means);
            risen = Risen::of(scene, &receives, &seen, &own, &means);
        }
        Self { receives, means, risen, channels }
    }

    /// The bound on the error of gathers at every point of a receiver.
    pub(crate) fn on_receiver(&self, bounds: &Bounds, receiver: usize, channel: usize) -> Ledger {
        let most = self.risen.as_ref().map_or(f64::INFINITY, |risen| risen.most(receiver * self.channels + channel));
        bounds.shares[channel].map(|share| if share > 0.0 { share * most } else { 0.0 })
    }

    /// The bound at a point, from what each of its links gives.
    /// `rho` is the reflectance there.
    pub(crate) fn at(
        &self,
        scene: Scene<'_>,
        bounds: &Bounds,
        station: &Station,
        rows: &[(usize, Row)],
        rho: &[f64],
    ) -> Vec<Ledger> {
        let links = rows.iter().map(|(source, row)| (*source, std::slice::from_ref(row)));
        let seen = Seen::of(scene.mesh, scene.surfaces, &[*station], &self.receives, links);
        let of_channel = |(channel, rho): (usize, &f64)| {
            let rows = rows.iter().map(|(source, row)| (*source, row));
            let carried = match &self.risen {
                Some(risen) => seen.gathered((channel, self.channels), &risen.largest, &self.means)[0],
                None => f64::INFINITY,
            };
            let carried = bounds.shares[channel].map(|share| if share > 0.0 { share * carried } else { 0.0 });
            (bounds.gathered(scene.mesh, channel, rows, (&seen, 0)) + carried) * *rho
        };
        rho.iter().enumerate().map(of_channel).collect()
    }
}

impl Bounds {
    /// What a point gathers at most of the residual.
    fn gathered<'a>(
        &self,
        mesh: &Mesh,
        channel: usize,
        rows: impl Iterator<Item = (usize, &'a Row)>,
        (seen, node): (&Seen, usize),
    ) -> Ledger {
        let [direct, reflected] = &self.residuals;
        let of = |residuals: &Residuals, source: usize, found: &Found| {
            residuals[source][channel].gathered(mesh.basis(source).degree(), found)
        };
        let found = |row: &Row| Found::by(row.factor(), &row.kernel, row.beyond());
        let of_direct = rows.map(|(source, row)| of(direct, source, &found(row))).sum::<Ledger>();
        let of_source = |(place, &source): (usize, &usize)| {
            seen.found(place, node).map_or_else(Ledger::default, |found| of(reflected, source, &found))
        };
        of_direct + seen.sources.iter().enumerate().map(of_source).sum::<Ledger>()
    }
}

impl Scene<'_> {
    /// Mean errors of receivers, `A_i e_i <= rho_i sum_j max F_ij A_j (|r|_j + e_j)`, from those that hold already and from the
    /// mean over all: `sum_j A_j e_j` is known.
    fn spread(&self, receives: &[bool], seen: &[Seen], bounds: &Bounds, risen: &Risen, means: &mut [f64]) {
        let (mesh, receivers, channels) = (self.mesh, self.receivers, self.channels);
        let area: f64 = receivers.iter().map(|&receiver| mesh.elements()[receiver].area()).sum();
        // Which receivers get how much at most of what leaves each.
        let reached = |seen: &Seen| {
            let mut to = Vec::new();
            for (place, &source) in seen.sources.iter().enumerate() {
                let (factor, peak) = seen.most(place);
                let whole = mesh.elements()[source].area();
                if factor > 0.0 {
                    below(mesh, receives, source, &mut |target| {
                        to.push((target, factor.min(peak * mesh.elements()[target].area() / whole)));
                    });
                }
            }
            to
        };
        let reached: Vec<Vec<(usize, f64)>> = seen.par_iter().map(reached).collect();
        for channel in 0..channels {
            let whole = area * bounds.mean[channel].total();
            for &receiver in receivers {
                let at = receiver * channels + channel;
                means[at] = means[at].min(whole / mesh.elements()[receiver].area()).min(risen.most(at));
            }
            for _ in 0..MEAN_SWEEPS {
                let mut sums = vec![[0.0_f64; 3]; mesh.elements().len()];
                for (&receiver, to) in receivers.iter().zip(&reached) {
                    let own = mesh.elements()[receiver].area();
                    let of = |residuals: &Residuals| {
                        residuals[receiver][channel].mean_ledger().total() + residuals[receiver][channel].mean_detail()
                    };
                    let left = own * bounds.residuals.iter().map(of).sum::<f64>();
                    let error = own * means[receiver * channels + channel];
                    for &(target, most) in to {
                        let [first, again, factor] = &mut sums[target];
                        *first += most * left;
                        *again += most * error;
                        *factor = factor.max(most);
                    }
                }
                for &receiver in receivers {
                    let [first, again, factor] = sums[receiver];
                    let sum = self.reflectance(receiver, channel) * (first + again.min(factor * whole));
                    let mean = &mut means[receiver * channels + channel];
                    *mean = mean.min(sum / mesh.elements()[receiver].area());
                }
            }
        }
        self.pull(receives, means, |of| 0.25 * of.iter().sum::<f64>());
    }
}

/// Calls `visit` with the receivers below an element, or itself.
fn below(mesh: &Mesh, receives: &[bool], element: usize, visit: &mut impl FnMut(usize)) {
    if receives[element] {
        visit(element);
    } else if let Some(first) = mesh.elements()[element].children() {
        (first..first + 4).for_each(|child| below(mesh, receives, child, visit));
    }
}
