//! Bounds on the error: its mean over all area, and its magnitude at every point.
//!
//! `B = E + rho G B`, with a kernel that is nowhere negative and the same both ways. Let `B_h` be the piecewise polynomial
//! radiosity, `B_g = E + rho G B_h` what one exact gather makes of it, and `r = B_g - B_h` the residual ([`crate::residual`]).
//! The error of the gather obeys `e = B - B_g = rho G r + rho G e`.
//!
//! # The mean
//! `mean |e| <= mean(z |r|)` with the importance `z = G b`, `b = rho + rho G b`: how much of a unit of light that leaves a
//! place is reflected anywhere, once or more. That is the radiosity equation with rho for the light that is emitted, so the
//! links for it are there. No bound on the kernel enters: light spreads and is lost as it is. Over an element the mean of |r|
//! and the largest z at the nodes are taken. With `b_h` in the place of b, and `d = rho + rho G b_h - b_h`, `mean(z |r|)` is
//! `mean(z_h |r|) + mean(q d)` where `q = G |r| + G rho q`, and `rho q` is bounded as e is, but from the size of r.
//!
//! # A point
//! `|e| <= rho |G r| + rho G |e|`. Of |e| a point gathers from a source at most F times its largest value and `k_max` times its
//! mean, k the kernel times the area. Means over receivers come first: with `F_y` the form factor to receiver i from a place y of
//! receiver j, `A_i mean_i G f = int f F_y dy <= A_j mean_j(f) max F_y`. The largest values then are those at the nodes; only
//! near-by sources need each other's.
//!
//! # Textures
//! The detail t of textures stays as elements become smaller, but `G t` does not ([`crate::residual`]); so t is apart from the
//! rest s of r: `mean |e| <= mean(z |s|) + mean(b |G t|)`. Nor is the defect d of `b_h` small, which has detail too. So z is
//! bounded at every point, by the sweeps that bound e: `z = z_h + y` with `y = G d + G rho y`, from `|G d|` at the nodes, or `z
//! = G rho (1 + z)` as it is, whichever is less. Of `rho y` with y at most Y, a point gathers at most Y times the least of `F
//! max rho`, `k_max mean rho` and `F mean rho + (k_max - k_min)/2 rms(rho - mean rho)`.
//!
//! Where a bound has to hold at every point of an element, the difference between the largest value at the nodes and the least is
//! added; that, and z between the nodes, are estimates of the same kind as the residual's.

use std::collections::HashMap;

use rayon::prelude::*;

use crate::cluster::{Far, Pair, View};
use crate::field::Field;
use crate::gathering::{Equation, irradiance};
use crate::ledger::Ledger;
use crate::link::Link;
use crate::mesh::Mesh;
use crate::residual::Residual;
use crate::surfaces::Surfaces;
use crate::texture::Pattern;
use crate::transfer::{Kernel, Row, Station};

/// What a point gathers of a residual over a source at most, given the degree of the source's basis, the form factor and the
/// kernel.
type Gathered = fn(&Residual, usize, f64, &Kernel) -> Ledger;

/// Sweeps after which there is no bound: far more than any reflectance below 0.99 needs.
const MOST_SWEEPS: usize = 2000;

/// What is added, as a part, so that sweeps that still rise by a little end below.
const MARGIN: f64 = 0.03;

/// How much they may still rise, as a part.
const RISE: f64 = 1e-2;

/// How often means and largest values are drawn from each other.
const PASSES: usize = 1;

/// Sweeps in which means over receivers come down.
const MEAN_SWEEPS: usize = 8;

/// How much more than its form factor a cluster's kernel may give before its elements get the whole form factor each.
const BY_AREA: f64 = 100.0;

/// Changes below which the importance is solved: what that leaves is in its defect.
const SOLVED: f64 = 1e-3;

/// What bounds are made of.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Scene<'a> {
    pub(crate) mesh: &'a Mesh,
    pub(crate) surfaces: &'a Surfaces,
    pub(crate) receivers: &'a [usize],
    pub(crate) links: &'a [Vec<Link>],
    pub(crate) far: &'a [Far],
}

/// What light leaves out on each element, by channel.
pub(crate) type Residuals = Vec<Vec<Residual>>;

/// Bounds for each channel.
#[derive(Debug, Clone, Default)]
pub(crate) struct Bounds {
    /// On the mean magnitude of the error of gathers over all area.
    pub(crate) mean: Vec<Ledger>,
    /// What direct and reflected light leave out on each element.
    pub(crate) residuals: [Residuals; 2],
    /// For each receiver, the largest importance at a node.
    importance: Vec<Vec<f64>>,
    /// On the error of a gather, on each element: the mean over it and the largest value at its nodes.
    means: Vec<Vec<f64>>,
    largest: Vec<Vec<f64>>,
    /// By how much the bounds at a receiver's nodes differ.
    variation: Vec<Vec<f64>>,
    /// The parts that the sources of error have in the mean.
    shares: Vec<Ledger>,
    /// For each channel, the bound on the error of a gather on each cluster, and what is left out there.
    of_clusters: Vec<Vec<Pair>>,
    left_on_clusters: Vec<Vec<Pair>>,
    /// Whether each element is a receiver.
    receives: Vec<bool>,
}

/// What a receiver, or a point, sees of an element that is a receiver or above one.
#[derive(Debug, Clone)]
struct Seen {
    source: usize,
    /// For each node, a bound on the form factor and the kernel.
    nodes: Vec<(f64, Kernel)>,
    most_factor: f64,
    most_peak: f64,
    /// With textures, for each node and channel the reflectance that counts by the largest; else nothing.
    even: Vec<Vec<f64>>,
}

impl Seen {
    /// From links: those to elements below a receiver are taken together, as what is left out of reflected light cancels over
    /// receivers, not over their parts.
    fn of<'a>(
        mesh: &Mesh,
        surfaces: &Surfaces,
        stations: &[Station],
        receives: &[bool],
        links: impl Iterator<Item = (usize, &'a [Row])>,
    ) -> Vec<Self> {
        let mut seen: Vec<Self> = Vec::new();
        let mut places = HashMap::new();
        for (source, rows) in links {
            let receiver = receiver_above(mesh, receives, source).filter(|&receiver| receiver != source);
            let Some(receiver) = receiver else {
                seen.push(Self::from(source, rows.iter().map(|row| (row.factor(), row.kernel)).collect()));
                continue;
            };
            let place = *places.entry(receiver).or_insert_with(|| {
                let kernel = |station: &Station| (0.0, Kernel::of(station, &mesh.elements()[receiver]));
                seen.push(Self::from(receiver, stations.iter().map(kernel).collect()));
                seen.len() - 1
            });
            for ((factor, kernel), row) in seen[place].nodes.iter_mut().zip(rows) {
                *factor += row.factor();
                if !row.kernel.smooth {
                    (kernel.smooth, kernel.least) = (false, 0.0);
                }
            }
        }
        for seen in &mut seen {
            seen.most_factor = seen.nodes.iter().fold(0.0, |m: f64, n| m.max(n.0));
            seen.most_peak = seen.nodes.iter().filter(|n| n.0 > 0.0).fold(0.0, |m: f64, n| m.max(n.1.peak));
            seen.weigh(mesh, surfaces);
        }
        seen
    }

    const fn from(source: usize, nodes: Vec<(f64, Kernel)>) -> Self {
        Self { source, nodes, most_factor: 0.0, most_peak: 0.0, even: Vec::new() }
    }

    /// Learns what part of the largest reflectance of a source with textures counts.
    fn weigh(&mut self, mesh: &Mesh, surfaces: &Surfaces) {
        let most = &surfaces.reflectance[mesh.elements()[self.source].face()];
        if surfaces.pattern(self.source, 0).is_none() {
            return;
        }
        let of_channel = |(channel, most): (usize, &f64), (factor, kernel): &(f64, Kernel)| {
            let Some(pattern) = surfaces.pattern(self.source, channel).filter(|_| *factor > 0.0 && *most > 0.0) else {
                return 1.0;
            };
            if !kernel.peak.is_finite() {
                return 1.0;
            }
            let (mean, [_, varies, _]) = (pattern.mean_reflectance(), pattern.spread_of_reflectance());
            let halved = factor * mean + 0.5 * (kernel.peak - kernel.least) * varies;
            (halved.min(kernel.peak * mean) / (factor * most)).min(1.0)
        };
        let of_node = |node: &(f64, Kernel)| most.iter().enumerate().map(|rho| of_channel(rho, node)).collect();
        self.even = self.nodes.iter().map(of_node).collect();
    }
}

/// The receiver that an element is or is below.
fn receiver_above(mesh: &Mesh, receives: &[bool], element: usize) -> Option<usize> {
    std::iter::successors(Some(element), |&at| mesh.elements()[at].parent()).find(|&at| receives[at])
}

impl Residual {
    /// Those at some elements, and from there those over the elements above and for the elements below.
    pub(crate) fn everywhere(mesh: &Mesh, at: &[usize], of: Vec<Vec<Self>>, channels: usize) -> Residuals {
        let mut all: Vec<Option<Vec<Self>>> = vec![None; mesh.elements().len()];
        for (&element, of) in at.iter().zip(of) {
            all[element] = Some(of);
        }
        for index in (0..all.len()).rev() {
            if let (None, Some(first)) = (&all[index], mesh.elements()[index].children()) {
                let children: Vec<&Vec<Self>> = all[first..first + 4].iter().flatten().collect();
                if children.len() == 4 {
                    let of = |channel: usize| Self::over(&[0, 1, 2, 3].map(|child| children[child][channel]));
                    all[index] = Some((0..channels).map(of).collect());
                }
            }
        }
        all.into_iter().map(|of| of.unwrap_or_else(|| vec![Self::default(); channels])).collect()
    }
}

impl Bounds {
    /// Bounds on the error all over the mesh, from what direct and reflected light leave out; `None` if none was found, as
    /// where light cannot be lost.
    pub(crate) fn of(scene: Scene<'_>, residuals: [Residuals; 2], channels: usize) -> Option<Self> {
        let Scene { mesh, surfaces, receivers, links, .. } = scene;
        let mut receives = vec![false; mesh.elements().len()];
        receivers.iter().for_each(|&receiver| receives[receiver] = true);
        let empty = vec![vec![0.0; channels]; mesh.elements().len()];
        let (importance, defects) = importance(scene, channels);
        let of_receiver = |&receiver: &usize| {
            let links = links[receiver].iter().map(|link| (link.source, &link.rows[..]));
            Seen::of(mesh, surfaces, &stations(mesh, receiver), &receives, links)
        };
        let seen: Vec<Vec<Seen>> = receivers.par_iter().map(of_receiver).collect();
        let mut bounds = Self {
            mean: Vec::new(),
            residuals,
            importance,
            means: empty.clone(),
            largest: empty.clone(),
            variation: empty,
            shares: Vec::new(),
            of_clusters: vec![Vec::new(); channels],
            left_on_clusters: Vec::new(),
            receives,
        };
        bounds.left_on_clusters = bounds.residuals_of_clusters(mesh);
        // Each time from a bound that holds: at first a point may gather the largest error from everywhere.
        for &receiver in receivers {
            bounds.means[receiver] = vec![f64::INFINITY; channels];
        }
        bounds.pull(mesh);
        let defects = if surfaces.is_textured() {
            bounds.raise_importance(scene, &seen, defects)?;
            Vec::new()
        } else {
            defects
                .into_iter()
                .map(|of| of.iter().map(|d| d.mean() + d.largest.solver + d.largest.computation).collect())
                .collect()
        };
        // Of q, which knows no signs.
        let sizes = if surfaces.is_textured() {
            Vec::new()
        } else {
            let own = bounds.own(scene, &seen, Residual::size_gathered);
            bounds.rise(scene, &seen, &own)?;
            receivers.iter().map(|&r| bounds.largest[r].iter().zip(&bounds.variation[r]).map(|(q, v)| q + v).collect()).collect()
        };
        let own = bounds.own(scene, &seen, Residual::gathered);
        for _ in 0..PASSES {
            bounds.rise(scene, &seen, &own)?;
            bounds.average(scene, &seen, (&defects, &sizes));
            bounds.spread(scene, &seen);
        }
        bounds.rise(scene, &seen, &own)?;
        Some(bounds)
    }

    /// What the nodes of receivers gather of the residual or of its size, times the reflectance.
    fn own(&self, scene: Scene<'_>, seen: &[Vec<Seen>], gathered: Gathered) -> Vec<Vec<Vec<f64>>> {
        let Scene { mesh, surfaces, receivers, links, far } = scene;
        let channels = self.residuals[0].first().map_or(0, Vec::len);
        let of_clusters = self.residuals_of_clusters(mesh);
        let own = |(index, &receiver): (usize, &usize)| {
            let rho = &surfaces.reflectance[mesh.elements()[receiver].face()];
            let of_node = |channel: usize, node: usize| {
                let rows = links[receiver].iter().map(|link| (link.source, &link.rows[node]));
                let near = self.gathered_residual(mesh, channel, rows, (&seen[index], node), gathered).total();
                (near + far[receiver].at_most(node, &of_clusters[channel])) * rho[channel]
            };
            let nodes = mesh.basis(receiver).nodes().len();
            (0..channels).map(|channel| (0..nodes).map(|node| of_node(channel, node)).collect()).collect()
        };
        receivers.par_iter().enumerate().map(own).collect()
    }

    /// Makes the importance one that is no less at any point: it may be more by `y = G d + G rho y` with its defect d, and is at
    /// most `Z = G rho (1 + Z)`.
    fn raise_importance(&mut self, scene: Scene<'_>, seen: &[Vec<Seen>], defects: Vec<Vec<Residual>>) -> Option<()> {
        let Scene { mesh, surfaces, receivers, far, .. } = scene;
        let rho = |element: usize, channel: usize| surfaces.reflectance[mesh.elements()[element].face()][channel];
        let channels = self.residuals[0].first().map_or(0, Vec::len);
        let none = vec![vec![Residual::default(); channels]; mesh.elements().len()];
        let mut more = self.clone();
        more.residuals = [none, Residual::everywhere(mesh, receivers, defects, channels)];
        let of_defect = more.own(scene, seen, Residual::gathered);
        let more = more.rise(scene, seen, &of_defect).map(|()| more);
        let reflectances = |channel: usize| mesh.clusters().pairs(mesh.elements(), |e| (rho(e, channel), f64::INFINITY));
        let reflectances: Vec<Vec<Pair>> = (0..channels).map(reflectances).collect();
        let reflected = |(index, &receiver): (usize, &usize)| {
            let of_node = |channel: usize, node: usize| {
                let of = |seen: &Seen| {
                    seen.nodes[node].0 * rho(seen.source, channel) * seen.even.get(node).map_or(1.0, |even| even[channel])
                };
                let beyond = far[receiver].at_most(node, &reflectances[channel]);
                (seen[index].iter().map(of).sum::<f64>() + beyond) * rho(receiver, channel)
            };
            let nodes = mesh.basis(receiver).nodes().len();
            (0..channels).map(|channel| (0..nodes).map(|node| of_node(channel, node)).collect()).collect()
        };
        let mut most = self.clone();
        let own: Vec<Vec<Vec<f64>>> = receivers.par_iter().enumerate().map(reflected).collect();
        let most = most.rise(scene, seen, &own).map(|()| most);
        if more.is_none() && most.is_none() {
            return None;
        }
        for channel in 0..channels {
            let at = |of: &Option<Self>, receiver: usize| {
                let largest = |of: &Self| of.largest[receiver][channel] + of.variation[receiver][channel];
                of.as_ref().map_or(f64::INFINITY, |of| largest(of) / rho(receiver, channel))
            };
            let mut greatest: f64 = 0.0;
            for &receiver in receivers.iter().filter(|&&receiver| rho(receiver, channel) > 0.0) {
                let raised = self.importance[receiver][channel] + at(&more, receiver);
                self.importance[receiver][channel] = raised.min(at(&most, receiver));
                greatest = greatest.max(self.importance[receiver][channel]);
            }
            // A black receiver leaves nothing out but what rounding does.
            for &receiver in receivers.iter().filter(|&&receiver| rho(receiver, channel) == 0.0) {
                self.importance[receiver][channel] += greatest;
            }
        }
        Some(())
    }

    /// The mean magnitude of the residual over an element, but for the detail of textures, by its sources.
    fn mean_residual(&self, element: usize, channel: usize) -> Ledger {
        let [direct, reflected] = &self.residuals;
        direct[element][channel].mean_ledger() + reflected[element][channel].mean_ledger()
    }

    /// How much an element adds to the bound on the mean, for a residual of that mean.
    pub(crate) fn share(&self, mesh: &Mesh, element: usize, channel: usize, mean: f64) -> f64 {
        let receiver = receiver_above(mesh, &self.receives, element).unwrap_or(element);
        let importance = self.importance[receiver].get(channel).copied().unwrap_or(0.0);
        mesh.elements()[element].area() * importance * mean
    }

    /// Mean errors of receivers, `A_i e_i <= rho_i sum_j max F_ij A_j (|r|_j + e_j)`, from those that hold already and from the
    /// mean over all: `sum_j A_j e_j` is known.
    fn spread(&mut self, scene: Scene<'_>, seen: &[Vec<Seen>]) {
        let Scene { mesh, surfaces, receivers, far, .. } = scene;
        let area: f64 = receivers.iter().map(|&receiver| mesh.elements()[receiver].area()).sum();
        // Which receivers get how much at most of what leaves each.
        let reached = |index: usize| {
            let mut to = Vec::new();
            for seen in seen[index].iter().filter(|seen| seen.most_factor > 0.0) {
                let whole = mesh.elements()[seen.source].area();
                below(mesh, &self.receives, seen.source, &mut |target| {
                    to.push((target, seen.most_factor.min(seen.most_peak * mesh.elements()[target].area() / whole)));
                });
            }
            to
        };
        // The same of clusters.
        let widest = |&receiver: &usize| (0..far[receiver].len()).map(|index| far[receiver].widest(index)).collect();
        let widest: Vec<Vec<View>> = receivers.par_iter().map(widest).collect();
        let reached: Vec<Vec<(usize, f64)>> = (0..receivers.len()).into_par_iter().map(reached).collect();
        let channels = self.mean.len();
        for channel in 0..channels {
            let whole = area * self.mean[channel].total();
            for &receiver in receivers {
                let held = &mut self.means[receiver][channel];
                *held = held
                    .min(whole / mesh.elements()[receiver].area())
                    .min(self.largest[receiver][channel] + self.variation[receiver][channel]);
            }
            for _ in 0..MEAN_SWEEPS {
                let mut sums = vec![[0.0_f64; 3]; mesh.elements().len()];
                let mut of_clusters = vec![[[0.0_f64; 3]; 2]; mesh.clusters().all().len()];
                for ((&receiver, to), widest) in receivers.iter().zip(&reached).zip(&widest) {
                    let own = mesh.elements()[receiver].area();
                    let detail: f64 = self.residuals.iter().map(|of| of[receiver][channel].mean_detail()).sum();
                    let left = self.mean_residual(receiver, channel).total() + detail;
                    let [left, error] = [left, self.means[receiver][channel]].map(|m| own * m);
                    let add = |sums: &mut [f64; 3], most: f64| {
                        let [first, again, factor] = sums;
                        *first += most * left;
                        *again += most * error;
                        *factor = factor.max(most);
                    };
                    to.iter().for_each(|&(target, most)| add(&mut sums[target], most));
                    for (&cluster, view) in far[receiver].clusters().iter().zip(widest).filter(|(_, view)| view.factor > 0.0) {
                        // To each element in it by its area, or as much as to all.
                        let by_area = view.peak * mesh.clusters().all()[cluster].area() <= BY_AREA * view.factor;
                        let most = if by_area { view.peak } else { view.factor };
                        add(&mut of_clusters[cluster][usize::from(by_area)], most);
                    }
                }
                let join = |[a, b]: [[f64; 3]; 2], [c, d]: [[f64; 3]; 2]| {
                    [[a, c], [b, d]].map(|[a, b]| [a[0] + b[0], a[1] + b[1], a[2].max(b[2])])
                };
                mesh.clusters().push(&of_clusters, join, |element, [whole, by_area]| {
                    below(mesh, &self.receives, element, &mut |target| {
                        let area = mesh.elements()[target].area();
                        let [first, again, factor] = &mut sums[target];
                        *first += whole[0] + area * by_area[0];
                        *again += whole[1] + area * by_area[1];
                        *factor = factor.max(whole[2]).max(area * by_area[2]);
                    });
                });
                for &receiver in receivers {
                    let element = &mesh.elements()[receiver];
                    let [first, again, factor] = sums[receiver];
                    let rho = surfaces.reflectance[element.face()][channel];
                    let sum = rho * (first + again.min(factor * whole)) / element.area();
                    self.means[receiver][channel] = self.means[receiver][channel].min(sum);
                }
            }
        }
        self.pull(mesh);
    }

    /// Largest errors at the nodes of receivers, from what these gather of the residual: sweeps from 0 until they rise no more,
    /// then a margin, and a check that one more sweep does not exceed it.
    fn rise(&mut self, scene: Scene<'_>, seen: &[Vec<Seen>], own: &[Vec<Vec<f64>>]) -> Option<()> {
        let Scene { mesh, surfaces, receivers, far, .. } = scene;
        let at_nodes = |bounds: &Self, index: usize, channel: usize| -> Vec<f64> {
            let rho = surfaces.reflectance[mesh.elements()[receivers[index]].face()][channel];
            let far = &far[receivers[index]];
            let error = |node: usize| {
                bounds.gathered_error(channel, &seen[index], node) + far.at_most(node, &bounds.of_clusters[channel])
            };
            let carried = |(node, own): (usize, &f64)| own + rho * error(node);
            own[index][channel].iter().enumerate().map(carried).collect()
        };
        let channels = own.first().map_or(0, Vec::len);
        let swept = |bounds: &Self| -> Vec<Vec<f64>> {
            let of = |channel: usize, index: usize| at_nodes(bounds, index, channel).into_iter().fold(0.0, f64::max);
            let all = |index: usize| (0..channels).map(|channel| of(channel, index)).collect();
            (0..receivers.len()).into_par_iter().map(all).collect()
        };
        receivers.iter().for_each(|&receiver| self.largest[receiver].fill(0.0));
        self.pull(mesh);
        for _ in 0..MOST_SWEEPS {
            let next = swept(self);
            let rises = |(&receiver, next): (&usize, &Vec<f64>)| {
                next.iter().zip(&self.largest[receiver]).any(|(n, w)| *n > w * (1.0 + RISE))
            };
            let rising = receivers.iter().zip(&next).any(rises);
            let margin = if rising { 1.0 } else { 1.0 + MARGIN };
            for (&receiver, next) in receivers.iter().zip(next) {
                self.largest[receiver] = next.into_iter().map(|w| w * margin).collect();
            }
            self.pull(mesh);
            if rising {
                continue;
            }
            let check = swept(self);
            let holds = |(&receiver, check): (&usize, &Vec<f64>)| check.iter().zip(&self.largest[receiver]).all(|(n, w)| n <= w);
            if receivers.iter().zip(&check).all(holds) {
                for (index, &receiver) in receivers.iter().enumerate() {
                    for channel in 0..channels {
                        let largest = self.largest[receiver][channel];
                        let least = at_nodes(self, index, channel).into_iter().fold(largest, f64::min);
                        self.variation[receiver][channel] = largest - least;
                    }
                }
                return Some(());
            }
        }
        None
    }

    /// Values of elements above receivers.
    fn pull(&mut self, mesh: &Mesh) {
        for index in (0..mesh.elements().len()).rev() {
            let Some(first) = mesh.elements()[index].children().filter(|_| !self.receives[index]) else { continue };
            for channel in 0..self.means[index].len() {
                let children = first..first + 4;
                self.means[index][channel] = 0.25 * children.clone().map(|child| self.means[child][channel]).sum::<f64>();
                self.largest[index][channel] = children.map(|child| self.largest[child][channel]).fold(0.0, f64::max);
            }
        }
        for channel in 0..self.of_clusters.len() {
            let of = |element: usize| (self.largest[element][channel], self.means[element][channel]);
            self.of_clusters[channel] = mesh.clusters().pairs(mesh.elements(), of);
        }
    }

    /// What is left out on each cluster in each channel: direct and reflected light together, whatever its source.
    fn residuals_of_clusters(&self, mesh: &Mesh) -> Vec<Vec<Pair>> {
        let of = |element: usize, channel: usize| {
            let sum = |of: &dyn Fn(&Residual) -> f64| self.residuals.iter().map(|all| of(&all[element][channel])).sum::<f64>();
            (sum(&|residual| residual.whole().total()), sum(&|residual| residual.mean_ledger().total() + residual.mean_detail()))
        };
        let channels = 0..self.of_clusters.len();
        channels.map(|channel| mesh.clusters().pairs(mesh.elements(), |element| of(element, channel))).collect()
    }

    /// The bound on the mean error.
    fn average(&mut self, scene: Scene<'_>, seen: &[Vec<Seen>], (defects, sizes): (&[Vec<f64>], &[Vec<f64>])) {
        let Scene { mesh, surfaces, receivers, links, far } = scene;
        let area: f64 = receivers.iter().map(|&receiver| mesh.elements()[receiver].area()).sum();
        let channels = self.residuals[0].first().map_or(0, Vec::len);
        (self.mean, self.shares) = (Vec::new(), Vec::new());
        for channel in 0..channels {
            let details = mesh.clusters().pairs(mesh.elements(), |element| {
                let of = |f: fn(&Residual) -> f64| self.residuals.iter().map(|all| f(&all[element][channel])).sum::<f64>();
                (of(Residual::largest_detail), of(Residual::mean_detail))
            });
            let (mut sent, mut missed, mut at_point) = (Ledger::default(), 0.0, Ledger::default());
            for (index, &receiver) in receivers.iter().enumerate() {
                let element = &mesh.elements()[receiver];
                let part = element.area() / area;
                sent += self.mean_residual(receiver, channel) * (self.importance[receiver][channel] * part);
                let rho = surfaces.reflectance[element.face()][channel];
                if surfaces.is_textured() {
                    let mean = surfaces.pattern(receiver, channel).map_or(rho, Pattern::mean_reflectance);
                    let sends = mean * (1.0 + self.importance[receiver][channel]);
                    let of_node = |node: usize| {
                        self.gathered_detail(mesh, channel, &links[receiver], &seen[index], node)
                            + far[receiver].at_most(node, &details)
                    };
                    let most = (0..mesh.basis(receiver).nodes().len()).map(of_node).fold(0.0, f64::max);
                    sent.discretisation += part * sends * most;
                } else if rho > 0.0 {
                    missed += part * defects[index][channel] * sizes[index][channel] / rho;
                }
                // What is evaluated at a point has an error of its own.
                for residuals in &self.residuals {
                    let largest = residuals[receiver][channel].largest;
                    at_point += Ledger { discretisation: 0.0, solver: 0.0, ..largest } * part;
                }
            }
            let share = if sent.total() > 0.0 { sent * (1.0 / sent.total()) } else { sent };
            self.mean.push(sent + share * missed + at_point);
            self.shares.push(share);
        }
    }

    /// What a point gathers at most of the residual.
    fn gathered_residual<'a>(
        &self,
        mesh: &Mesh,
        channel: usize,
        rows: impl Iterator<Item = (usize, &'a Row)>,
        (seen, node): (&[Seen], usize),
        gathered: Gathered,
    ) -> Ledger {
        let [direct, reflected] = &self.residuals;
        let of_direct = |(source, row): (usize, &Row)| {
            gathered(&direct[source][channel], mesh.basis(source).degree(), row.factor(), &row.kernel)
        };
        let of_reflected = |seen: &Seen| {
            let (factor, kernel) = &seen.nodes[node];
            gathered(&reflected[seen.source][channel], mesh.basis(seen.source).degree(), *factor, kernel)
        };
        let direct = rows.map(of_direct).fold(Ledger::default(), |a, b| a + b);
        seen.iter().map(of_reflected).fold(direct, |a, b| a + b)
    }

    /// What a node of a receiver gathers at most of the detail of textures.
    fn gathered_detail(&self, mesh: &Mesh, channel: usize, links: &[Link], seen: &[Seen], node: usize) -> f64 {
        let [direct, reflected] = &self.residuals;
        let of_direct = |link: &Link| {
            let (row, source) = (&link.rows[node], link.source);
            direct[source][channel].gathered_detail(mesh.basis(source).degree(), row.factor(), &row.kernel)
        };
        let of_reflected = |seen: &Seen| {
            let ((factor, kernel), source) = (&seen.nodes[node], seen.source);
            reflected[source][channel].gathered_detail(mesh.basis(source).degree(), *factor, kernel)
        };
        links.iter().map(of_direct).sum::<f64>() + seen.iter().map(of_reflected).sum::<f64>()
    }

    /// What a point gathers at most of the error.
    fn gathered_error(&self, channel: usize, seen: &[Seen], node: usize) -> f64 {
        let of = |seen: &Seen| {
            let (factor, kernel) = &seen.nodes[node];
            let (mean, largest) = (self.means[seen.source][channel], self.largest[seen.source][channel]);
            let even = seen.even.get(node).map_or(1.0, |even| even[channel]);
            if *factor == 0.0 { 0.0 } else { (factor * largest * even).min(kernel.peak * mean) }
        };
        seen.iter().map(of).sum()
    }

    /// The bound at a point, from what each of its links gives.
    /// `rho` is the reflectance there.
    pub(crate) fn at_point(
        &self,
        mesh: &Mesh,
        surfaces: &Surfaces,
        station: &Station,
        rows: &[(usize, Row)],
        far: &Far,
        rho: &[f64],
    ) -> Vec<Ledger> {
        let links = rows.iter().map(|(source, row)| (*source, std::slice::from_ref(row)));
        let seen = Seen::of(mesh, surfaces, &[*station], &self.receives, links);
        let of_channel = |(channel, rho): (usize, &f64)| {
            let rows = rows.iter().map(|(source, row)| (*source, row));
            let beyond = far.at_most(0, &self.of_clusters[channel]);
            let carried = self.shares[channel] * (self.gathered_error(channel, &seen, 0) + beyond);
            let discretisation = far.at_most(0, &self.left_on_clusters[channel]);
            let of_clusters = Ledger { discretisation, ..Ledger::default() };
            (self.gathered_residual(mesh, channel, rows, (&seen, 0), Residual::gathered) + of_clusters + carried) * *rho
        };
        rho.iter().enumerate().map(of_channel).collect()
    }

    /// The bound on the error of gathers at every point of a receiver.
    pub(crate) fn on_receiver(&self, receiver: usize, channel: usize) -> Ledger {
        self.shares[channel] * (self.largest[receiver][channel] + self.variation[receiver][channel])
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

/// For each element the largest importance at the nodes, and for each receiver the defect of b.
fn importance(scene: Scene<'_>, channels: usize) -> (Vec<Vec<f64>>, Vec<Vec<Residual>>) {
    let Scene { mesh, surfaces, receivers, links, far } = scene;
    let mut source: Vec<Vec<f64>> = vec![Vec::new(); mesh.elements().len()];
    let mut own = source.clone();
    for &receiver in receivers {
        let (len, rho) = (mesh.basis(receiver).len(), &surfaces.reflectance[mesh.elements()[receiver].face()]);
        let of_channel = |(channel, rho): (usize, &f64)| match surfaces.pattern(receiver, channel) {
            Some(pattern) => pattern.reflectance().to_vec(),
            None => (0..len).map(|i| if i == 0 { *rho } else { 0.0 }).collect(),
        };
        source[receiver] = rho.iter().enumerate().flat_map(of_channel).collect();
        own[receiver] = vec![0.0; len * channels];
    }
    let mut field = Field::dark(mesh, channels);
    let equation = Equation { mesh, surfaces, receivers, links, far, source: &source };
    for _ in 0..MOST_SWEEPS {
        if equation.sweep(&mut field, &mut own, &vec![1.0; channels]) <= SOLVED {
            break;
        }
    }
    field.pull(mesh);
    let of = |&receiver: &usize| {
        let (element, basis) = (&mesh.elements()[receiver], mesh.basis(receiver));
        let of_channel = |channel: usize| {
            let rho = surfaces.reflectance[element.face()][channel];
            let at_nodes = irradiance(mesh, &field, &links[receiver], &far[receiver], channel, basis.nodes().len());
            let beside = |node: usize| {
                let of = |link: &Link| {
                    let (row, len) = (&link.rows[node], mesh.basis(link.source).len());
                    field.neglected(mesh, link.source, channel, row) + row.error_of(field.of(link.source, channel, len))
                };
                links[receiver].iter().map(of).sum::<f64>() + far[receiver].neglected(mesh.clusters(), &field, channel, node)
            };
            let beside: Vec<f64> = (0..at_nodes.len()).map(beside).collect();
            let z = at_nodes.iter().zip(&beside).map(|(z, beside)| z + beside).fold(0.0, f64::max);
            let samples: Vec<f64> = at_nodes.iter().map(|h| rho * h).collect();
            let held = &own[receiver][channel * basis.len()..(channel + 1) * basis.len()];
            let mut defect = Residual::of(element, basis, &samples);
            let unsolved = match surfaces.pattern(receiver, channel) {
                None => {
                    let mut projected = basis.project(&samples);
                    projected.iter_mut().zip(held).for_each(|(p, b)| *p -= b);
                    projected[0] += rho;
                    projected
                }
                Some(pattern) => {
                    let mut sent = basis.project(&at_nodes);
                    sent[0] += 1.0;
                    defect = defect.textured(element, pattern, rho, pattern.detail(basis, &sent, false));
                    pattern.reflected(&sent).iter().zip(held).map(|(p, b)| p - b).collect()
                }
            };
            let missed = rho * beside.into_iter().fold(0.0, f64::max);
            defect.largest.computation = missed;
            defect.largest.solver = basis.magnitude(&unsolved);
            (z, defect)
        };
        (0..channels).map(of_channel).unzip()
    };
    let (largest, defects): (Vec<Vec<f64>>, Vec<Vec<Residual>>) = receivers.par_iter().map(of).unzip();
    let mut all = vec![Vec::new(); mesh.elements().len()];
    receivers.iter().zip(largest).for_each(|(&receiver, z)| all[receiver] = z);
    (all, defects)
}

fn stations(mesh: &Mesh, element: usize) -> Vec<Station> {
    let (basis, element) = (mesh.basis(element), &mesh.elements()[element]);
    let station = |at| Station { point: element.point(at), normal: element.polygon().normal(), face: element.face() };
    basis.nodes().iter().map(|node| station(node.at)).collect()
}
