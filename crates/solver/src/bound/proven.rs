//! A bound on the error that no placement of light breaks: no sample decides what may be missed.
//!
//! | symbol | meaning |
//! |---|---|
//! | `B`, `B_h` | the radiosity, and the polynomials on elements |
//! | `E`, `rho`, `G` | emission, reflectance, and gathering: `G B(x)` is the irradiance of x; the kernel is nowhere negative, `G 1 <= 1` |
//! | `r` | what is left out, `E + rho G B_h - B_h` |
//! | `e` | the error, `B - B_h` |
//! | `i`, `j` | an element that receives, a source |
//! | `c`, `R`, `n1` | centre, radius and normal of i |
//! | `F_j(x)`, `f_j` | form factor from x to j past all that hides it, and its bound over all x of i |
//! | `k_j` | bound on the kernel over i and j, times the area of j |
//! | `H`, `P H` | irradiance on i, and its projection from the values at the nodes |
//! | `s_j`, `m_j`, `V_j` | bounds on `|r|` on j, on its mean, and on `rho G |e|` on j |
//!
//! # From what is left out to the error
//! `e = r + rho G e`, so that `|e| <= |r| + rho G |e|`. On i, `rho G |e|` is at most `V_i` if for all i
//!
//! ```text
//! V_i >= rho_i (sum_j min(f_j s_j, k_j m_j) + max of sum_j F_j V_j  for  0 <= F_j <= f_j, sum_j F_j <= 1)
//! ```
//!
//! The maximum is that of a fractional knapsack (D. Lischinski, B. Smits and D. Greenberg 1994): the largest V first. From any V for
//! which the right side is at most `V + d`, `V + d/(1 - max rho)` fulfils it, so that sweeps may end at any time. At a point the
//! `F_j` are known: `|B - B_g| <= rho (sum_j min(F_j s_j, k_j m_j) + sum_j F_j V_j)`, `B_g = E + rho G B_h`.
//!
//! In the mean over all area `mean |e| <= mean(w |r|)` with `w = 1 + G rho w`, as G is the same both ways; `w_i` is bounded by the
//! same knapsack. The mean of `B_h` is off by no more than that.
//!
//! # What is left out
//! `r = rho (H - P H)`, what links neglect, what rows are off, and what of the linear system is not solved. The bounds of the last
//! three are those at nodes, with kernels over all of i ([`Kernel::between`]); rows count by the Lebesgue constant of P, in the mean
//! by 1, as P does not raise the root mean square of samples. Of `H - P H` three bounds are known, and the least counts.
//!
//! **By size.** H is between the least and the largest `sum_j F_j B_j` of the knapsack. In the mean it is at most
//! `sum_j max|B_j| min(f_j, A_j/A_i)`: no more than j sends.
//!
//! **By sources.** Nothing changes what x sees of y but an outline: an edge of a face that does not turn the same side to x as the other
//! face at that edge does, or where faces cross. So if no outline is between i and j, by their hulls, all of j is seen from all of i or
//! nothing ([`left`]), and what any node sees says which. What is seen as a whole differs from a polynomial of i's degree by what
//! Taylor's leaves: with the even part of `B_j` a sum over the edges e of j, with z heights over i's plane and S the distance of e's line,
//!
//! ```text
//! F_j(c + t u) = sum_k a_k t^k,   |a_k| <= (k + 1)(k + 2)/(6 pi) sum_e int_e z S / |y - c|^(3 + k) ds
//! ```
//!
//! since `dF/dt = (1/pi) sum_e int_e z (e x (y - x)).u / |y - x|^4 ds`, z and the product do not change with t, and `|y - x|^-4` is the
//! generating function of Gegenbauer's polynomials, `|C_m^2| <= (m + 1)(m + 2)(m + 3)/6`; with the rest of `B_j` the kernel's own series
//! over the area. The horizon does not move, as i is plane. All other sources count by size, in the part of the hemisphere that is left.
//!
//! **By how fast light changes.** Along a straight way of `D` from a node to x, with `B_h` on the sources split into the polynomial of
//! the coarsest elements and what each finer one has beyond it,
//!
//! ```text
//! |H(x) - H(node)| <= sum over lines of J min(1, sup 1/pi int z |D.(e x (y - x))| / |y - x|^4 ds)
//!                   + sum_j max|grad B_j| (f_j |D| + |n2.D| 1/pi int z / |y - x|^3 dA)
//! ```
//!
//! The lines are the edges of the parts, and the outlines that may be between i and a source; J bounds the jump of the radiosity seen
//! across them: between two faces that share an edge the difference of their radiosities, and else what may be seen behind. A line sweeps
//! each direction at most once on the way, so that it changes H by no more than J. The last integral is at most
//! `2 pi |n1.n2| + sin ln(1 + p^2/d^2)`, d the distance from the plane of j, p the farthest place of j, sin that of the angle between the
//! planes; over the way `int ln(1 + p^2/d^2) dd <= D ln(1 + p^2/D^2) + 2 p atan(D/p)` from 0. At the nodes `H - P H` is known. Where
//! something stands on i or crosses it inside, H jumps, and this bound does not count.
//!
//! # Rounding
//! Sums and products of at most a few thousand terms are raised by 1e-9 ([`ROUNDED`]). Planes are those of surfaces: what is level with
//! one up to 1e-12 of the lengths at hand, or stands on it up to 1e-9, is in it, as it is for links.

mod edges;
mod left;
mod nodes;
mod terms;

use radgrad_core::mutant;

use radgrad_scene::{largest, smallest as least};
use rayon::prelude::*;

use crate::bound::ledger::Ledger;
use crate::bound::residual::Residuals;
use crate::field::Field;
use crate::links::cluster::far::Far;
use crate::links::cluster::glow::Pair;
use crate::links::cluster::view::View;
use crate::links::direct::{Direct, Lamps};
use crate::links::link::Link;
use crate::links::transfer::{Kernel, Row};
use crate::mesh::clusters::Clusters;
use crate::mesh::shape::Shape;
use crate::mesh::surfaces::Surfaces;
use crate::mesh::{Mesh, Sight};
use edges::Edges;
use left::{Gathered, Light, Proof, fill};
use nodes::{Nodes, ROUNDED};
use terms::Target;

/// Sweeps in which bounds on what is gathered rise.
const MOST_SWEEPS: usize = 400;

/// Rise, as a part, below which sweeps end.
const RISE: f64 = 1e-3;

/// What is bounded.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Solved<'a> {
    pub(crate) mesh: &'a Mesh,
    pub(crate) surfaces: &'a Surfaces,
    pub(crate) field: &'a Field,
    pub(crate) links: &'a [Vec<Link>],
    pub(crate) far: &'a [Far],
    pub(crate) receivers: &'a [usize],
    pub(crate) channels: usize,
    /// What was estimated: what of it is proven is taken from it.
    pub(crate) residuals: &'a [Residuals; 2],
}

/// What light leaves out on an element: at most and in the mean.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Rest {
    pub(crate) largest: Ledger,
    pub(crate) mean: Ledger,
}

/// What a proof needs of a mesh's faces and bases.
#[derive(Debug)]
pub(crate) struct Ground {
    edges: Edges,
    nodes: [Nodes; 2],
}

/// The bounds.
#[derive(Debug, Default)]
pub(crate) struct Proven {
    /// For each channel, on the mean magnitude of the error of the polynomials, and so on the error of the mean.
    pub(crate) mean: Vec<Ledger>,
    /// For each element and channel: what is left out of direct and of reflected light; of elements above those over which it is known
    /// too.
    direct: Vec<Vec<Rest>>,
    reflected: Vec<Vec<Rest>>,
    /// For each element and channel, what is gathered and reflected of the error at most, anywhere on it.
    carried: Vec<Vec<f64>>,
    /// For each receiver and channel, how much a mean error of 1 on it adds at most to that of all, over its part of the area.
    weights: Vec<Vec<f64>>,
    shares: Vec<Ledger>,
    /// For each channel, all that is left out and what is carried, on clusters.
    left_on_clusters: Vec<Vec<Pair>>,
    carried_on_clusters: Vec<Vec<Pair>>,
}

impl Ground {
    pub(crate) fn of(mesh: &Mesh) -> Self {
        Self { edges: Edges::of(mesh), nodes: [0, 1].map(|shape| Nodes::of(&mesh.bases()[shape])) }
    }

    fn proof<'a>(&'a self, mesh: &'a Mesh, channels: usize) -> Proof<'a> {
        Proof { mesh, edges: &self.edges, nodes: &self.nodes, channels }
    }

    /// What the projection of direct light leaves out on a leaf, in each channel.
    pub(crate) fn left_of_direct(
        &self,
        mesh: &Mesh,
        surfaces: &Surfaces,
        lamps: &Lamps,
        direct: &Direct,
        leaf: usize,
    ) -> Vec<Rest> {
        let channels = surfaces.emitted[0].len();
        let seen: Vec<(usize, (usize, &Sight))> = lamps.seen(direct).enumerate().collect();
        let seen: Vec<(usize, (usize, &Sight))> =
            seen.into_iter().filter(|(_, (_, sight))| !matches!(sight, Sight::Nothing(_))).collect();
        let value = |index: usize, node: usize, coefficients: &[f64]| coefficients[0] * direct.nodes[node].factors[seen[index].0];
        let gathered = Gathered { sources: seen.iter().map(|(_, pair)| *pair).collect(), value: &value, error: direct.error() };
        let proof = self.proof(mesh, channels);
        let left = proof.left(leaf, &Light::Even(&surfaces.emitted), &gathered);
        let lebesgue = proof.nodes_of(leaf).lebesgue;
        let rho = &surfaces.reflectance[mesh.elements()[leaf].face()];
        let of = |(channel, left): (usize, left::Left)| {
            let error = |kind: usize| direct.nodes.iter().map(|lit| lit.error[channel][kind]).fold(0.0, largest);
            let [clear, past] = [error(0), error(1)];
            let rest = |discretisation: f64, times: f64| {
                Ledger { discretisation, computation: times * clear, visibility: times * past, ..Ledger::default() }
                    * rho[channel]
            };
            Rest { largest: rest(left.largest, 2.0 * lebesgue), mean: rest(left.mean, 2.0) }
        };
        left.into_iter().enumerate().map(of).collect()
    }
}

/// Bounds on the light on an element, at most and in the mean, of sources that its nodes do not see at all and that others of its places
/// may: these are sources, each with the largest magnitude of its radiosity.
pub(crate) fn unseen<'a>(
    ground: &Ground,
    mesh: &Mesh,
    element: usize,
    sources: impl Iterator<Item = (usize, &'a [usize], f64)>,
) -> [f64; 2] {
    let basis = mesh.basis(element);
    let places: Vec<[f64; 2]> = basis.nodes().iter().map(|node| node.at).collect();
    let proof = ground.proof(mesh, 1);
    let target = Target::of(&mesh.elements()[element], &places, proof.nodes_of(element));
    let (mut bounds, mut mean) = (Vec::new(), 0.0);
    for (source, faces, size) in sources {
        if proof.is_cut(&target, element, source, faces) {
            let (factor, of) = (target.reach(&mesh.elements()[source]).factor, &mesh.elements()[source]);
            bounds.push((factor, size));
            mean += size * least(factor, of.area() / mesh.elements()[element].area());
        }
    }
    let most = fill(bounds);
    [most, least(most, mean)]
}

impl Solved<'_> {
    fn reflectance(&self, element: usize, channel: usize) -> f64 {
        self.surfaces.reflectance[self.mesh.elements()[element].face()][channel]
    }

    /// What the projection of reflected light leaves out on a receiver, in each channel.
    fn left_of_reflected(&self, ground: &Ground, receiver: usize) -> Vec<Rest> {
        let Self { mesh, field, channels, .. } = *self;
        let (links, far) = (&self.links[receiver], &self.far[receiver]);
        let (element, basis) = (&mesh.elements()[receiver], mesh.basis(receiver));
        let value = |index: usize, node: usize, coefficients: &[f64]| -> f64 {
            links[index].rows[node].values.iter().zip(coefficients).map(|(v, c)| v * c).sum()
        };
        let error = links.iter().flat_map(|link| &link.rows).map(|row| row.error).fold(0.0, largest);
        let gathered = Gathered { sources: links.iter().map(|link| (link.source, &link.sight)).collect(), value: &value, error };
        let proof = ground.proof(mesh, channels);
        let left = proof.left(receiver, &Light::Field(field), &gathered);
        let nodes = ground.nodes[usize::from(element.shape() == Shape::Triangle)].lebesgue;
        let places: Vec<[f64; 2]> = basis.nodes().iter().map(|node| node.at).collect();
        let target = Target::of(element, &places, proof.nodes_of(receiver));
        let of = |(channel, left): (usize, left::Left)| {
            let rho = self.reflectance(receiver, channel);
            // What links neglect, anywhere on the element.
            let (mut neglected, mut most) = (0.0, 0.0);
            for link in links {
                let beyond = field.left_out(link.source, channel);
                if beyond > 0.0 {
                    let source = &mesh.elements()[link.source];
                    let reach = target.reach(source);
                    let kernel = Kernel::between(element, source, reach.distance, matches!(link.sight, Sight::Clear));
                    let smoothly = field.smoothly_neglected(mesh, link.source, channel, &kernel);
                    let by_size = reach.factor * beyond;
                    neglected += if smoothly < by_size { smoothly } else { by_size };
                    most = largest(most, beyond);
                }
            }
            neglected = least(neglected, most);
            let (mut clear, mut past) = (0.0, 0.0);
            for node in 0..basis.nodes().len() {
                let mut sums = [0.0; 2];
                let mut size = 0.0;
                for link in links {
                    let coefficients = field.of(link.source, channel, mesh.basis(link.source).len());
                    let error = link.rows[node].error_of(coefficients);
                    sums[usize::from(matches!(link.sight, Sight::Past(_)))] += error;
                    size += link.rows[node].values.iter().zip(coefficients).map(|(v, c)| (v * c).abs()).sum::<f64>();
                }
                // The sums themselves round.
                let summed = 2.0 * f64::EPSILON * (links.len() + basis.len() + 2) as f64 * size;
                (clear, past) = (largest(clear, sums[0] + summed), largest(past, sums[1]));
            }
            let beyond = if far.is_empty() { 0.0 } else { self.left_of_far(receiver, channel) };
            let known = &self.residuals[1][receiver][channel];
            let rest = |left: f64, detail: f64, times: f64| {
                let reflected = Ledger {
                    discretisation: left,
                    computation: neglected + beyond + times * clear,
                    visibility: times * past,
                    ..Ledger::default()
                };
                let own = Ledger { discretisation: detail, solver: known.largest.solver, ..Ledger::default() };
                reflected * rho + own
            };
            Rest {
                largest: rest(left.largest, known.largest_detail(), 2.0 * nodes),
                mean: rest(left.mean, known.mean_detail(), 2.0),
            }
        };
        left.into_iter().enumerate().map(of).collect()
    }

    /// What is left out of what clusters give.
    fn left_of_far(&self, receiver: usize, channel: usize) -> f64 {
        let (far, basis, tree) = (&self.far[receiver], self.mesh.basis(receiver), self.mesh.clusters());
        let at_nodes: Vec<f64> = (0..basis.nodes().len()).map(|node| far.value(self.field, channel, node)).collect();
        let [low, high] = basis.range(&basis.project(&at_nodes));
        let element = &self.mesh.elements()[receiver];
        let bounds = |positive: bool| {
            let of = |&cluster: &usize| {
                let (view, glow) = (tree.all()[cluster].view_over(element), self.field.glow(cluster, channel));
                let power = if positive { glow.positive } else { glow.negative };
                if glow.largest > 0.0 { (view.at_most(power, glow.largest) / glow.largest, glow.largest) } else { (0.0, 0.0) }
            };
            fill(far.clusters().iter().map(of).collect())
        };
        mutant!("solver.left-of-far", largest(bounds(true) - low, high + bounds(false)) * ROUNDED, |left| 0.01 * left)
    }
}

impl Proven {
    /// The bounds; `None` where light may not be lost, so that there are none.
    pub(crate) fn of(solved: Solved<'_>, ground: &Ground, direct: Vec<Vec<Rest>>) -> Option<Self> {
        let Solved { mesh, receivers, channels, .. } = solved;
        let rho_most: Vec<f64> =
            (0..channels).map(|channel| receivers.iter().map(|&r| solved.reflectance(r, channel)).fold(0.0, largest)).collect();
        if rho_most.iter().any(|rho| *rho >= 1.0 || rho.is_nan()) {
            return None;
        }
        let reflected: Vec<Vec<Rest>> =
            receivers.par_iter().map(|&receiver| solved.left_of_reflected(ground, receiver)).collect();
        let leaves: Vec<usize> = mesh.leaves().collect();
        let direct = if direct.is_empty() {
            vec![vec![Rest::default(); channels]; mesh.elements().len()]
        } else {
            everywhere(mesh, &leaves, direct, channels)
        };
        let reflected = everywhere(mesh, receivers, reflected, channels);
        let left = |element: usize, channel: usize| {
            let (a, b) = (&direct[element][channel], &reflected[element][channel]);
            [a.largest.total() + b.largest.total(), a.mean.total() + b.mean.total()]
        };
        let views: Vec<Views> = receivers.par_iter().map(|&receiver| Views::of(&solved, ground, receiver)).collect();
        let of_clusters = |of: &(dyn Fn(usize, usize) -> (f64, f64) + Sync)| -> Vec<Vec<Pair>> {
            (0..channels).map(|channel| mesh.clusters().pairs(mesh.elements(), |element| of(element, channel))).collect()
        };
        let left_on_clusters = of_clusters(&|element, channel| {
            let [most, mean] = left(element, channel);
            (most, mean)
        });
        let mut carried = vec![vec![0.0; channels]; mesh.elements().len()];
        let mut weights = vec![vec![0.0; channels]; mesh.elements().len()];
        for channel in 0..channels {
            let own: Vec<f64> = (receivers, &views)
                .into_par_iter()
                .map(|(&receiver, views)| {
                    let near = views.sources.iter().map(|&(source, factor, peak)| {
                        let [most, mean] = left(source, channel);
                        (gathered(factor, peak, most, mean), most)
                    });
                    let (sum, most) = near.fold((0.0, 0.0), |(sum, most), (g, s)| (sum + g, largest(most, s)));
                    let (sum, most) = views.clusters.iter().fold((sum, most), |(sum, most), (cluster, view)| {
                        let pair = &left_on_clusters[channel][*cluster];
                        (sum + view.at_most(pair.whole, pair.largest), largest(most, pair.largest))
                    });
                    least(sum, most) * solved.reflectance(receiver, channel)
                })
                .collect();
            let of_error = risen(&solved, &views, channel, &own, rho_most[channel]);
            let of_light: Vec<f64> = receivers.iter().map(|&receiver| solved.reflectance(receiver, channel)).collect();
            let of_light = risen(&solved, &views, channel, &of_light, rho_most[channel]);
            let spread = |values: &[f64], into: &mut Vec<Vec<f64>>| {
                for (&receiver, value) in receivers.iter().zip(values) {
                    into[receiver][channel] = *value;
                }
            };
            spread(&of_error, &mut carried);
            // What is reflected of the light, for each unit of what arrives.
            let swept = sweep(&solved, &views, channel, &everywhere_most(mesh, receivers, &of_light));
            spread(&swept.iter().map(|gathered| 1.0 + gathered).collect::<Vec<f64>>(), &mut weights);
            let most = everywhere_most(mesh, receivers, &of_error);
            carried.iter_mut().zip(most).for_each(|(at, most)| at[channel] = most);
        }
        let carried_on_clusters = of_clusters(&|element, channel| (carried[element][channel], carried[element][channel]));
        let area: f64 = receivers.iter().map(|&receiver| mesh.elements()[receiver].area()).sum();
        let mean_of = |channel: usize| {
            let of = |&receiver: &usize| {
                let part = mesh.elements()[receiver].area() / area * weights[receiver][channel];
                (direct[receiver][channel].mean + reflected[receiver][channel].mean) * part
            };
            receivers.iter().map(of).sum::<Ledger>() * ROUNDED
        };
        let mean: Vec<Ledger> = (0..channels).map(mean_of).collect();
        if mean.iter().any(|of| !of.total().is_finite()) {
            return None;
        }
        let shares = mean.iter().map(|of| if of.total() > 0.0 { *of * (1.0 / of.total()) } else { *of }).collect();
        Some(Self { mean, direct, reflected, carried, weights, shares, left_on_clusters, carried_on_clusters })
    }

    /// How much a receiver adds to the bound on the mean by what it leaves out itself, over its part of the area.
    pub(crate) fn share(&self, receiver: usize, channel: usize) -> f64 {
        self.weights[receiver][channel] * self.reflected[receiver][channel].mean.total()
    }

    /// What is left out on a leaf and on the receiver that it is or is below.
    pub(crate) fn left_on(&self, leaf: usize, receiver: usize, channel: usize) -> Ledger {
        self.direct[leaf][channel].largest + self.reflected[receiver][channel].largest
    }

    /// Bound on the error of gathers at every place of a receiver.
    pub(crate) fn carried_on(&self, receiver: usize, channel: usize) -> Ledger {
        self.shares[channel].map(|share| {
            if share > 0.0 {
                mutant!("solver.carried", share * self.carried[receiver][channel], |carried| 0.01 * carried)
            } else {
                0.0
            }
        })
    }

    /// Bound on what the error of the polynomials gives to a point, from what each of its links and clusters gives; `rho` is the
    /// reflectance there.
    pub(crate) fn at(&self, rows: &[(usize, Row)], far: &Far, rho: &[f64]) -> Vec<Ledger> {
        let of_channel = |(channel, rho): (usize, &f64)| {
            let (mut near, mut most) = (0.0, 0.0);
            let mut seen = Vec::with_capacity(rows.len());
            for (source, row) in rows.iter().filter(|(_, row)| row.factor() > 0.0) {
                let (a, b) = (&self.direct[*source][channel], &self.reflected[*source][channel]);
                let (size, mean) = (a.largest.total() + b.largest.total(), a.mean.total() + b.mean.total());
                near += gathered(row.factor(), row.kernel.peak, size, mean);
                most = largest(most, size);
                seen.push((row.factor(), self.carried[*source][channel]));
            }
            for (index, &cluster) in far.clusters().iter().enumerate() {
                let (view, left) = (far.view(index, 0), &self.left_on_clusters[channel][cluster]);
                near += view.at_most(left.whole, left.largest);
                most = largest(most, left.largest);
                seen.push((view.factor, self.carried_on_clusters[channel][cluster].largest));
            }
            let total = (mutant!("solver.at-point", least(near, most) + fill(seen), |total| 0.01 * total)) * rho * ROUNDED;
            self.shares[channel].map(|share| if share > 0.0 { share * total } else { 0.0 })
        };
        rho.iter().enumerate().map(of_channel).collect()
    }
}

/// What is gathered at most of something by its largest value and its mean.
fn gathered(factor: f64, peak: f64, most: f64, mean: f64) -> f64 {
    let by_mean = if peak.is_finite() { peak * mean } else { f64::INFINITY };
    mutant!("solver.gathered", least(factor * most, by_mean), |most| 0.01 * most)
}

/// What any place of a receiver sees at most of sources and of clusters.
#[derive(Debug)]
struct Views {
    /// Source, form factor, kernel times the area.
    sources: Vec<(usize, f64, f64)>,
    clusters: Vec<(usize, View)>,
}

impl Views {
    fn of(solved: &Solved<'_>, ground: &Ground, receiver: usize) -> Self {
        let (mesh, element, basis) = (solved.mesh, &solved.mesh.elements()[receiver], solved.mesh.basis(receiver));
        let places: Vec<[f64; 2]> = basis.nodes().iter().map(|node| node.at).collect();
        let proof = ground.proof(mesh, solved.channels);
        let target = Target::of(element, &places, proof.nodes_of(receiver));
        let of_link = |link: &Link| {
            let reach = target.reach(&mesh.elements()[link.source]);
            (link.source, reach.factor, reach.peak)
        };
        let tree: &Clusters = mesh.clusters();
        let of_cluster = |&cluster: &usize| (cluster, tree.all()[cluster].view_over(element));
        Self {
            sources: solved.links[receiver].iter().map(of_link).collect(),
            clusters: solved.far[receiver].clusters().iter().map(of_cluster).collect(),
        }
    }
}

/// One gather, without the reflectance, of what is at most this on each element.
fn sweep(solved: &Solved<'_>, views: &[Views], _channel: usize, values: &[f64]) -> Vec<f64> {
    let on_clusters = solved.mesh.clusters().pull(|element| values[element], largest);
    let of = |views: &Views| {
        let near = views.sources.iter().map(|&(source, factor, _)| (factor, values[source]));
        let far = views.clusters.iter().map(|(cluster, view)| (view.factor, on_clusters[*cluster]));
        fill(near.chain(far).collect()) * ROUNDED
    };
    views.par_iter().map(of).collect()
}

/// On each receiver what is nowhere less than `own + rho G` of itself.
///
/// From any `v` with `own + rho G v <= v + d`: `v + d/(1 - rho)` with the largest rho is such a bound, as form factors sum to at most 1.
fn risen(solved: &Solved<'_>, views: &[Views], channel: usize, own: &[f64], rho_most: f64) -> Vec<f64> {
    let mut values: Vec<f64> = own.to_vec();
    let mut rise = f64::INFINITY;
    for _ in 0..MOST_SWEEPS {
        let spread = everywhere_most(solved.mesh, solved.receivers, &values);
        let swept = sweep(solved, views, channel, &spread);
        let next = solved.receivers.iter().zip(own).zip(swept).map(|((&r, own), g)| own + solved.reflectance(r, channel) * g);
        let next: Vec<f64> = next.collect();
        rise = next.iter().zip(&values).map(|(next, value)| next - value).fold(0.0, largest);
        let most = next.iter().copied().fold(0.0, largest);
        if rise <= RISE * (1.0 - rho_most) * most {
            break;
        }
        values = next;
    }
    let more = rise / (1.0 - rho_most) * ROUNDED;
    values.into_iter().map(|value| (value + more) * ROUNDED).collect()
}

/// On each element the largest value on the receivers that are it or below it, or the one that it is below.
fn everywhere_most(mesh: &Mesh, receivers: &[usize], values: &[f64]) -> Vec<f64> {
    let mut all: Vec<Option<f64>> = vec![None; mesh.elements().len()];
    receivers.iter().zip(values).for_each(|(&receiver, value)| all[receiver] = Some(*value));
    for index in (0..all.len()).rev() {
        if let (None, Some(first)) = (all[index], mesh.elements()[index].children()) {
            let children: Option<Vec<f64>> = all[first..first + 4].iter().copied().collect();
            all[index] = children.map(|children| children.into_iter().fold(0.0, largest));
        }
    }
    for index in 0..all.len() {
        if all[index].is_none() {
            all[index] = mesh.elements()[index].parent().and_then(|parent| all[parent]);
        }
    }
    all.into_iter().map(|value| value.unwrap_or(f64::NAN)).collect()
}

/// What is left out on each element, from where it is known: over those above, and at most on those below.
fn everywhere(mesh: &Mesh, at: &[usize], of: Vec<Vec<Rest>>, channels: usize) -> Vec<Vec<Rest>> {
    let mut all: Vec<Option<Vec<Rest>>> = vec![None; mesh.elements().len()];
    at.iter().zip(of).for_each(|(&element, of)| all[element] = Some(of));
    for index in (0..all.len()).rev() {
        if let (None, Some(first)) = (&all[index], mesh.elements()[index].children()) {
            let children: Option<Vec<&Vec<Rest>>> = all[first..first + 4].iter().map(Option::as_ref).collect();
            let over = |children: Vec<&Vec<Rest>>| -> Vec<Rest> {
                let join = |channel: usize| {
                    let all = children.iter().map(|of| of[channel]);
                    all.fold(Rest::default(), |sum, of| Rest {
                        largest: if of.largest.total() > sum.largest.total() { of.largest } else { sum.largest },
                        mean: sum.mean + of.mean * 0.25,
                    })
                };
                (0..channels).map(join).collect()
            };
            all[index] = children.map(over);
        }
    }
    for index in 0..all.len() {
        if let (None, Some(parent)) = (&all[index], mesh.elements()[index].parent()) {
            let below = all[parent].as_ref().map(|of| {
                let part = |of: &Rest| Rest {
                    mean: if 4.0 * of.mean.total() < of.largest.total() { of.mean * 4.0 } else { of.largest },
                    ..*of
                };
                of.iter().map(part).collect()
            });
            all[index] = below;
        }
    }
    all.into_iter().map(|of| of.unwrap_or_else(|| vec![Rest::default(); channels])).collect()
}
