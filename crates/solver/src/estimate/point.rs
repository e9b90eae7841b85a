//! Estimates at points: `|e| <= rho |G r| + rho G |e|`.
//!
//! Of |e| a point gathers from a source at most F times its largest value and `k_max` times its mean, k the kernel times the
//! area. Means over receivers come first: with `F_y` the form factor to receiver i from a place y of receiver j,
//! `A_i mean_i G f = int f F_y dy <= A_j mean_j(f) max F_y`. The largest values then are those at the nodes. Clusters of which i is
//! a part get no more than theirs, and i of that by its area where the kernel is bounded.

use radgrad_scene::{largest as larger, smallest as smaller};
use rayon::prelude::*;

use crate::estimate::ErrorEstimate;
use crate::estimate::ledger::Ledger;
use crate::estimate::residual::{Found, Residuals};
use crate::estimate::supersolution::{self, Supersolution};
use crate::estimate::visible_sources::{VisibleSources, smaller_if_known};
use crate::links::cluster::far::Far;
use crate::links::cluster::view::View;
use crate::links::station::Station;
use crate::links::transfer::Row;
use crate::mesh::Mesh;
use crate::mesh::glow::Pair;
use crate::system::System;

/// Sweeps in which means over receivers come down.
const MEAN_SWEEPS: usize = 8;

/// How much more than its form factor a cluster's kernel may give before its elements get the whole form factor each.
const BY_AREA: f64 = 100.0;

/// Estimates of the error of gathers at points.
#[derive(Debug)]
pub(crate) struct Points {
    /// Whether each element is a receiver.
    receives: Vec<bool>,
    /// For each element, channel after channel, the mean over it, and the largest value at its nodes; `None` if there is no estimate.
    means: Vec<f64>,
    risen: Option<Supersolution>,
    /// For each channel, the residual on each cluster, and the error of gathers there.
    left_on_clusters: Vec<Vec<Pair>>,
    error_of_clusters: Vec<Vec<Pair>>,
    channels: usize,
}

impl Points {
    /// From the estimate of the mean magnitude.
    pub(super) fn from_mean(system: &System, estimate: &ErrorEstimate) -> Self {
        let System { mesh, receivers, links, far, .. } = system;
        let channels = system.channels.len();
        let receives = system.receives();
        let views = system.seen_sources(&receives);
        let [direct, reflected] = &estimate.residuals;
        let left_on_clusters = system.pairs_of(&[direct, reflected]);
        let own = |(index, &receiver): (usize, &usize)| -> Vec<f64> {
            let of_node = |channel: usize, node: usize| {
                let rows = links[receiver].iter().map(|link| (link.source, &link.rows[node]));
                let near = estimate.gathered(mesh, channel, rows, (&views[index], node)).total();
                (near + far[receiver].gathered(node, &left_on_clusters[channel])) * system.reflectance(receiver, channel)
            };
            let nodes = views[index].nodes;
            (0..channels).flat_map(|channel| (0..nodes).map(move |node| (channel, node))).map(|(c, n)| of_node(c, n)).collect()
        };
        let own: Vec<Vec<f64>> = receivers.par_iter().enumerate().map(own).collect();
        // Each time from one that holds: at first a point may gather the largest error from everywhere.
        let mut means = vec![0.0; mesh.elements().len() * channels];
        receivers.iter().for_each(|&receiver| means[receiver * channels..(receiver + 1) * channels].fill(f64::INFINITY));
        system.pull(&receives, &mut means, |of| 0.25 * of.iter().sum::<f64>());
        let mut risen = Supersolution::solve(system, &receives, &views, &own, &means);
        if let Some(first) = &risen {
            system.spread(&receives, &views, estimate, first, &mut means);
            risen = Supersolution::solve(system, &receives, &views, &own, &means);
        }
        let errors = |risen: &Supersolution| supersolution::pairs(system, &risen.largest, &means);
        let error_of_clusters = risen.as_ref().map_or_else(Vec::new, errors);
        Self { receives, means, risen, left_on_clusters, error_of_clusters, channels }
    }

    /// The estimate of the error of gathers at every point of a receiver, the most.
    pub(crate) fn on_receiver(&self, estimate: &ErrorEstimate, receiver: usize, channel: usize) -> Ledger {
        let largest_rise =
            self.risen.as_ref().map_or(f64::INFINITY, |risen| risen.largest_with_variation(receiver * self.channels + channel));
        estimate.shares[channel].map(|share| if share == 0.0 { 0.0 } else { share * largest_rise })
    }

    /// The estimate at a point, from each of its links and from its clusters. `rho` is the reflectance there.
    pub(crate) fn estimate(
        &self,
        system: &System,
        estimate: &ErrorEstimate,
        station: &Station,
        (rows, far): (&[(usize, Row)], &Far),
        rho: &[f64],
    ) -> Vec<Ledger> {
        let links = rows.iter().map(|(source, row)| (*source, std::slice::from_ref(row)));
        let view = VisibleSources::gather(&system.mesh, &system.surfaces, &[*station], &self.receives, links);
        let of_channel = |(channel, rho): (usize, &f64)| {
            let rows = rows.iter().map(|(source, row)| (*source, row));
            let propagated = match &self.risen {
                Some(risen) => {
                    let near = view.gathered((channel, self.channels), &risen.largest, &self.means)[0];
                    near + far.gathered(0, &self.error_of_clusters[channel])
                }
                None => f64::INFINITY,
            };
            let propagated = estimate.shares[channel].map(|share| if share == 0.0 { 0.0 } else { share * propagated });
            let discretisation = far.gathered(0, &self.left_on_clusters[channel]);
            let of_clusters = Ledger { discretisation, ..Ledger::default() };
            (estimate.gathered(&system.mesh, channel, rows, (&view, 0)) + of_clusters + propagated) * *rho
        };
        rho.iter().enumerate().map(of_channel).collect()
    }
}

impl ErrorEstimate {
    /// Bound on the gather by a point of the residual.
    fn gathered<'a>(
        &self,
        mesh: &Mesh,
        channel: usize,
        rows: impl Iterator<Item = (usize, &'a Row)>,
        (seen, node): (&VisibleSources, usize),
    ) -> Ledger {
        let [direct, reflected] = &self.residuals;
        let gathered = |residuals: &Residuals, source: usize, found: &Found| {
            residuals[source][channel].gathered(mesh.basis(source).degree(), found)
        };
        let bounds = |row: &Row| Found::by(row.likely_factor(), &row.kernel, row.truncation());
        let of_direct = rows.map(|(source, row)| gathered(direct, source, &bounds(row))).sum::<Ledger>();
        let of_source = |(place, &source): (usize, &usize)| {
            seen.kernel_bounds(place, node).map_or_else(Ledger::default, |bounds| gathered(reflected, source, &bounds))
        };
        of_direct + seen.sources.iter().enumerate().map(of_source).sum::<Ledger>()
    }
}

impl System {
    /// Mean errors of receivers, `A_i e_i <= rho_i sum_j max F_ij A_j (|r|_j + e_j)`, from those that hold already and from the
    /// mean over all: `sum_j A_j e_j` is known.
    fn spread(
        &self,
        receives: &[bool],
        seen: &[VisibleSources],
        estimate: &ErrorEstimate,
        risen: &Supersolution,
        means: &mut [f64],
    ) {
        let (mesh, receivers, far, channels) = (&self.mesh, &self.receivers, &self.far, self.channels.len());
        let area: f64 = receivers.iter().map(|&receiver| mesh.elements()[receiver].area()).sum();
        // For each source, the receivers that its light reaches and bounds on the factors.
        let reached = |seen: &VisibleSources| {
            let mut to = Vec::new();
            for (place, &source) in seen.sources.iter().enumerate() {
                let (factor, peak) = seen.largest_factor_and_peak(place);
                let whole = mesh.elements()[source].area();
                if factor > 0.0 {
                    below(mesh, receives, source, &mut |target| {
                        to.push((target, smaller_if_known(factor, peak * mesh.elements()[target].area() / whole)));
                    });
                }
            }
            to
        };
        let reached: Vec<Vec<(usize, f64)>> = seen.par_iter().map(reached).collect();
        let widest = |&receiver: &usize| (0..far[receiver].len()).map(|index| far[receiver].widest(index)).collect();
        let widest: Vec<Vec<View>> = receivers.par_iter().map(widest).collect();
        for channel in 0..channels {
            let whole = area * estimate.mean[channel].total();
            for &receiver in receivers {
                let index = receiver * channels + channel;
                means[index] =
                    smaller(smaller(means[index], whole / mesh.elements()[receiver].area()), risen.largest_with_variation(index));
            }
            for _ in 0..MEAN_SWEEPS {
                let mut sums = vec![[0.0_f64; 3]; mesh.elements().len()];
                let mut of_clusters = vec![[[0.0_f64; 3]; 2]; mesh.clusters().clusters().len()];
                for ((&receiver, to), widest) in receivers.iter().zip(&reached).zip(&widest) {
                    let own = mesh.elements()[receiver].area();
                    let magnitude = |residuals: &Residuals| {
                        residuals[receiver][channel].mean_ledger().total() + residuals[receiver][channel].mean_detail()
                    };
                    let residual = own * estimate.residuals.iter().map(magnitude).sum::<f64>();
                    let error = own * means[receiver * channels + channel];
                    let add = |sums: &mut [f64; 3], most: f64| {
                        let [first, again, factor] = sums;
                        *first += most * residual;
                        *again += most * error;
                        *factor = larger(*factor, most);
                    };
                    to.iter().for_each(|&(target, most)| add(&mut sums[target], most));
                    for (&cluster, view) in far[receiver].clusters().iter().zip(widest).filter(|(_, view)| view.factor > 0.0) {
                        // To each element in it by its area, or as much as to all.
                        let by_area = view.peak * mesh.clusters().clusters()[cluster].area() <= BY_AREA * view.factor;
                        let view_bound = if by_area { view.peak } else { view.factor };
                        add(&mut of_clusters[cluster][usize::from(by_area)], view_bound);
                    }
                }
                let join = |[a, b]: [[f64; 3]; 2], [c, d]: [[f64; 3]; 2]| {
                    [[a, c], [b, d]].map(|[a, b]| [a[0] + b[0], a[1] + b[1], larger(a[2], b[2])])
                };
                mesh.clusters().push(&of_clusters, join, |element, [whole, by_area]| {
                    below(mesh, receives, element, &mut |target| {
                        let area = mesh.elements()[target].area();
                        let [first, again, factor] = &mut sums[target];
                        *first += whole[0] + area * by_area[0];
                        *again += whole[1] + area * by_area[1];
                        *factor = larger(larger(*factor, whole[2]), area * by_area[2]);
                    });
                });
                for &receiver in receivers {
                    let [first, again, factor] = sums[receiver];
                    let sum = self.reflectance(receiver, channel) * (first + smaller_if_known(again, factor * whole));
                    let mean = &mut means[receiver * channels + channel];
                    *mean = smaller(*mean, sum / mesh.elements()[receiver].area());
                }
            }
        }
        self.pull(receives, means, |of| 0.25 * of.iter().sum::<f64>());
    }
}

/// Calls `visit` with the receivers below an element, or itself.
pub(crate) fn below(mesh: &Mesh, receives: &[bool], element: usize, visit: &mut impl FnMut(usize)) {
    if receives[element] {
        visit(element);
    } else if let Some(first) = mesh.elements()[element].children() {
        (first..first + 4).for_each(|child| below(mesh, receives, child, visit));
    }
}
