//! A bound on the error that no placement of light breaks: no sample decides what may be missed.
//!
//! | symbol | meaning |
//! |---|---|
//! | `B`, `B_h` | the radiosity, and the polynomials on elements |
//! | `E`, `rho`, `G` | emission, reflectance, and gathering: `G B(x)` is the irradiance of x; the kernel is nowhere negative, `G 1 <= 1` |
//! | `r` | the residual, `E + rho G B_h - B_h` |
//! | `e` | the error, `B - B_h` |
//! | `i`, `j` | an element that receives, a source |
//! | `c`, `R`, `n1` | centre, radius and normal of i |
//! | `F_j(x)`, `f_j` | form factor from x to j past all that hides it, and its bound over all x of i |
//! | `k_j` | bound on the kernel over i and j, times the area of j |
//! | `H`, `P H` | irradiance on i, and its projection from the values at the nodes |
//! | `s_j`, `m_j`, `V_j` | bounds on `|r|` on j, on its mean, and on `rho G |e|` on j |
//! | `o_j`, `a_j` | two parts of r on j: o is orthogonal to the polynomials of j's basis, of this root mean square; the mean of `|a|` |
//! | `p_j` | a part of a that is known: a polynomial of j's basis |
//! | `b_j` | bound on the root mean square over j of the kernel times j's area, less a polynomial of j's basis |
//!
//! # From the residual to the error
//! `e = r + rho G e`, so that `|e| <= |r| + rho G |e|`. On i, `rho G |e|` is at most `V_i` if for all i
//!
//! ```text
//! V_i >= rho_i (sum_j g_j + max of sum_j F_j V_j  for  0 <= F_j <= f_j, sum_j F_j <= 1),  g_j = min(f_j s_j, k_j m_j, b_j o_j + k_j a_j)
//! ```
//!
//! The maximum is that of a fractional knapsack (D. Lischinski, B. Smits and D. Greenberg 1994): the largest V first. From any V for
//! which the right side is at most `V + d`, `V + d u` fulfils it if `u >= 1 + rho G u` ([`spent`]), so that sweeps may end at any time. At
//! a point the `F_j` are known: `|B - B_g| <= rho (sum_j g_j + sum_j F_j V_j)`, `B_g = E + rho G B_h`, with `F_j` for `f_j`.
//!
//! The third bound of g is that of Galerkin's method: `int k r = int (k - p) o + int k a` for any polynomial p, and by Schwarz the first is at
//! most `b_j o_j`. `b_j` is [`Row::beyond`] at a point, or by derivatives of the kernel ([`crate::mesh::remainder`], [`Kernel`]).
//!
//! Whatever was found, `B - E` is nowhere less than 0 nor more than a U with `U >= rho (D + G E + G U)`, D the light of lamps and E what
//! other faces emit: so `|e|` is at most `max(U + E - min B_h, max B_h)`, which counts where it is less than `s_j + V_j`, and is gathered.
//! In the mean over all area `B - E` is at least that of `rho D` and at most that of `w rho (D + G E)`, with the w below: the mean
//! of `B_h - E` is no farther off than from the one or the other. On an element the mean of `|e|` is no more than those of `B - E` and `|B_h - E|`.
//!
//! The mean of `B_h` over all area is off by `mean(w r)` with `w = 1 + G rho w`, as G is the same both ways; `w_i` is bounded by the same
//! knapsack. On i that is at most `w_i m_i`, or `u_i o_i + w_i a_i` with `u_i` a bound on the root mean square of w less a polynomial: of
//! the sum over j of what `f_j`, or the derivatives of the kernel in x, leave of `rho_j w_j`. Where nothing hides anything there is another
//! bound on `u_i`: for any polynomials phi, about the importance, and `d = 1 + G rho phi - phi` it is `w - phi = d + G rho (w - phi)`, so that
//! `|w - phi|` is at most a v with `v >= |d| + G rho v`, and `u_i` at most the largest `|d|` on i and what the derivatives leave of `rho_j v_j`.
//! Then p counts with its signs: `mean(w p)` differs from `mean(phi p)`, a sum of products of coefficients over all i, by at most `v_i` times the
//! root mean square of `p_i` on each i.
//!
//! *What is orthogonal.* Let `H - P H` be that of the sources that i sees as a whole, Q the orthogonal projection on i's polynomials, of degree m,
//! and T Taylor's polynomial of degree m + 2, of which the next section leaves R. P is Q for such polynomials, as its nodes are exact for their
//! products with those of the basis. So `Q (H - P H) = Q R - P R`, of a root mean square of at most `2 sup |R|`: that is in a; and o is no
//! more than `H - P H`. Where more places than the nodes narrow the bound, the part of `H - P H` along the polynomials is known ([`finely`]): that
//! is p. All else is in a: other sources, errors of evaluations and of their sums, what links neglect, the unsolved rest; with
//! textures all of r. On parts of an element nothing is known to be orthogonal; on one that is made of others o is, as are those of its parts.
//!
//! # The residual
//! r has four parts: the projection's error `rho (H - P H)`, neglected links, errors of rows, and the unsolved rest of the linear
//! system. The bounds of the last three are those at nodes, with kernels over all of i ([`Kernel::between`]); rows count by the
//! Lebesgue constant of P, in the mean by 1, as P does not raise the root mean square of samples. For `H - P H` there are three
//! bounds, and the least counts.
//!
//! **By size.** H is between the least and the largest `sum_j F_j B_j` of the knapsack. In the mean it is at most
//! `sum_j max|B_j| min(f_j, A_j/A_i)`: no more than j sends.
//!
//! **By sources.** Only an outline changes whether x sees y: an edge of a face that does not turn the same side to x as the other
//! face at that edge does, or a line where faces cross. So if no outline of a solid, of faces that hang together, is between i
//! and j, by their hulls, the solid hides all of j from all of i or nothing ([`left`]), and the sight of any one place of i says
//! which. Where a solid stands on i, each part of i beside it is asked by itself. The irradiance of a source that is wholly seen
//! differs from a polynomial of i's degree by at most the rest of its Taylor series. For the even part of `B_j` that is a sum
//! over the edges e of j, with z heights over i's plane and S the distance of e's line,
//!
//! ```text
//! F_j(c + t u) = sum_k a_k t^k,   |a_k| <= (k + 1)(k + 2)/(6 pi) sum_e int_e z S / |y - c|^(3 + k) ds
//! ```
//!
//! since `dF/dt = (1/pi) sum_e int_e z (e x (y - x)).u / |y - x|^4 ds`, z and the product do not change with t, and `|y - x|^-4` is the
//! generating function of Gegenbauer's polynomials, `|C_m^2| <= (m + 1)(m + 2)(m + 3)/6`; with the rest of `B_j` the kernel's own series
//! over the area. The horizon does not move, as i is plane. On a parallelogram a polynomial in each coordinate may leave less
//! ([`continued`]). More places of i than its nodes narrow the bound of wholly seen sources ([`finely`]). All other sources count by
//! size, in the part of the hemisphere that is left.
//!
//! **Closed scenes.** If faces are met from the front in every direction ([`closed`]) form factors sum to 1, and a constant
//! radiosity gives every place of i the same: so any number may be taken from the radiosity in `H - P H`; it is about the mean
//! that i sees.
//!
//! There the mean is known in another way, too ([`swapped`]).
//!
//! **Cell by cell.** An element is cut into cells ([`cells`]). Sources that a cell sees as a whole count by a polynomial on it; all others by
//! how fast their light changes. Where a bound is asked for the receivers that add most to it for their work are cut further, until it is
//! reached or time is over. Along a straight way of `D` from the cell's centre to x,
//!
//! ```text
//! |H(x) - H(centre)| <= sum over lines of J min(1, sup 1/pi int z |D.(e x (y - x))| / |y - x|^4 ds)
//!                     + sum_j max|grad B_j| (f_j |D| + |n2.D| 1/pi int z / |y - x|^3 dA)
//! ```
//!
//! The lines are the edges of the sources, and the outlines that may be between the cell and a source; J bounds the jump of the radiosity
//! seen across them: between two sources that share an edge the difference of their radiosities, and else what may be seen behind. A
//! line sweeps each direction at most once on the way, so that it changes H by no more than J. The last integral is at most
//! `2 pi |n1.n2| + sin ln(1 + p^2/d^2)`, d the distance from the plane of j, p the farthest place of j, sin that of the angle between the
//! planes; over the way `int ln(1 + p^2/d^2) dd <= D ln(1 + p^2/D^2) + 2 p atan(D/p)` from 0. Where something stands on a cell or crosses it
//! inside, H jumps, and this bound does not count.
//!
//! # Where no light is lost
//! A reflectance of 1 is refused. In a closed scene of such faces `B = E + G B` has no solution, or infinitely many that differ by a number.
//! Beside others that absorb, a bound needs to know from below how much of the light of each place reaches these, and that may be so
//! little that neither the sums of form factors nor what is solved by them tell it from nothing: no `w` would be known that is finite.
//!
//! # Rounding
//! Sums and products of at most a few thousand terms are raised by 1e-9 ([`ROUNDED`]). A projection rounds by as many roundings as it has
//! terms, each of the samples times the coefficients of a function's monomials ([`Nodes`]). Planes are those of surfaces: a point
//! level with one up to 1e-12 of the lengths at hand, or an edge that stands on it up to 1e-9, is in it, as it is for links.

mod cells;
mod closed;
mod continued;
mod edges;
mod finely;
mod left;
mod nodes;
mod swapped;
mod terms;

use radgrad_core::mutant;

use radgrad_scene::{largest, smallest as least};
use rayon::prelude::*;

use crate::bound::ledger::Ledger;
use crate::bound::residual::Residuals;
use crate::clock::Clock;
use crate::field::Field;
use crate::links::cluster::far::Far;
use crate::links::cluster::glow::Pair;
use crate::links::cluster::view::View;
use crate::links::direct::{Direct, Lamps};
use crate::links::link::Link;
use crate::links::transfer::{Kernel, Optics, Row};
use crate::mesh::element::Element;
use crate::mesh::shape::Shape;
use crate::mesh::surfaces::Surfaces;
use crate::mesh::{Mesh, Sight};
use cells::{Bases, DEEPEST, DEEPEST_OF_LAMPS};
use closed::Closure;
use edges::Edges;
use left::{Effort, Gathered, Kind, LeftOut, Light, Proof, fill};
use nodes::{Nodes, ROUNDED};
use swapped::{Found, Swapped};
use terms::Target;

/// Sweeps in which bounds on gathers rise.
const MOST_SWEEPS: usize = 400;

/// Rise, as a part, below which sweeps end.
const RISE: f64 = 1e-3;

/// What may be left out on a cell that is not cut further, over the estimate that is asked for: the bound is so much wider.
const OVER_ESTIMATE: f64 = 20.0;

/// The same over the bound that is asked for: light is reflected again.
const OVER_BOUND: f64 = 0.3;

/// How often receivers are cut into cells where nothing hides anything and no bound is asked for, and the links of all cells beyond which
/// that takes more than some tenths of a second.
const DEEPEST_IN_THE_CLEAR: usize = 2;
const MOST_IN_THE_CLEAR: usize = 32_000;

/// A second bound on the weights, by the importance, lowers two parts of the bound: that of the weights' unevenness, and that of what is known
/// of residuals. It is as much work as the bounds on what light leaves out, and is made where the two are more than this part of all.
const BY_WEIGHTS: f64 = 0.3;

/// The receivers that are cut further at a time leave this part of what all receivers leave.
const AT_A_TIME: f64 = 0.3;

/// The solution to bound.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Solved<'a> {
    pub(crate) mesh: &'a Mesh,
    pub(crate) surfaces: &'a Surfaces,
    pub(crate) lamps: &'a Lamps,
    pub(crate) optics: Optics<'a>,
    pub(crate) field: &'a Field,
    pub(crate) links: &'a [Vec<Link>],
    pub(crate) far: &'a [Far],
    pub(crate) receivers: &'a [usize],
    pub(crate) channels: usize,
    /// What was estimated: what of it is proven is taken from it.
    pub(crate) residuals: &'a [Residuals; 2],
    /// The importance, as it is sent, if it is known.
    pub(crate) importance: Option<&'a Field>,
    /// When to give up.
    pub(crate) clock: Clock,
}

/// What light leaves out on an element: at most and in the mean.
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct Rest {
    pub(crate) largest: Ledger,
    pub(crate) mean: Ledger,
    /// Of light that comes from lamps, all that is reflected of it, at most and in the mean; and the least that this mean may be.
    lit: [f64; 2],
    least_lit: f64,
    /// It is the sum of a part that is orthogonal to the polynomials of the element's basis, of this root mean square, of one that is such a
    /// polynomial, of these coefficients if any is known, and of one of this mean.
    orthogonal: f64,
    along: Vec<f64>,
    loose: f64,
}

/// Bounds on a function on an element: its largest magnitude and its mean; and, of two parts that it is the sum of, the root mean square of
/// the one, which is orthogonal to the polynomials of the basis, and the mean of the other.
#[derive(Debug, Clone, Copy)]
struct Size {
    most: f64,
    mean: f64,
    orthogonal: f64,
    loose: f64,
}

/// What a proof needs of a mesh's faces and bases.
#[derive(Debug)]
pub(crate) struct Ground {
    edges: Edges,
    nodes: [Nodes; 2],
    closure: Closure,
    bases: [Bases; 2],
    effort: Effort,
    /// For each channel, the bound on the error of the mean for which elements are cut into cells; or nothing, if they are not.
    enough: Vec<f64>,
}

/// The error that is asked for, over what errors are relative to.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Aim {
    /// Of the estimate: the bound says what it is.
    Estimate { part: f64 },
    /// Of the bound: elements are cut into cells, unless a rough proof is enough.
    Bound { part: f64, is_rough: bool },
}

/// The bounds.
#[derive(Debug, Default)]
pub(crate) struct Proven {
    /// For each channel, on the error of the mean.
    pub(crate) mean: Vec<Ledger>,
    /// For each element and channel: the residual of direct and of reflected light, also of elements above those that have
    /// samples.
    direct: Vec<Vec<Rest>>,
    pub(crate) reflected: Vec<Vec<Rest>>,
    /// For each element and channel, the most of the error that is gathered and reflected anywhere on it.
    carried: Vec<Vec<f64>>,
    /// For each receiver and channel, what its own residual adds to the bound on the mean, over its part of the area.
    counts: Vec<Vec<f64>>,
    shares: Vec<Ledger>,
    /// Whether much of the bound on the mean in a channel is less if the weights `w` are known better.
    is_by_weights: bool,
    /// For each element and channel, how much the polynomials are off anywhere on it at most, and in the mean.
    most_off: Vec<Vec<[f64; 2]>>,
    /// For each channel, on clusters: residuals, gathered errors, and errors of the polynomials.
    left_on_clusters: Vec<Vec<Pair>>,
    carried_on_clusters: Vec<Vec<Pair>>,
    off_on_clusters: Vec<Vec<Pair>>,
}

impl Ground {
    /// Of a mesh; elements are cut into cells until the clock's end.
    pub(crate) fn of(mesh: &Mesh, cells: Clock) -> Self {
        let edges = Edges::of(mesh);
        let closure = Closure::of(mesh, &edges);
        let bases = [Shape::Parallelogram, Shape::Triangle].map(Bases::of);
        Self {
            edges,
            nodes: [0, 1].map(|shape| Nodes::of(&mesh.bases()[shape])),
            closure,
            bases,
            effort: Effort { aim: Vec::new(), clock: cells },
            enough: Vec::new(),
        }
    }

    /// Whether form factors sum to 1, but for places that something lies on.
    pub(crate) const fn is_closed(&self) -> bool {
        self.closure.is_closed()
    }

    /// Says what is asked for; `reference` is the radiosity in each channel that errors are relative to.
    pub(crate) fn aim_at(&mut self, reference: &[f64], aim: Aim) {
        let times = |part: f64| reference.iter().map(|reference| part * reference).collect();
        (self.effort.aim, self.enough) = match aim {
            Aim::Estimate { part } => (times(OVER_ESTIMATE * part), Vec::new()),
            Aim::Bound { part, is_rough } => (times(OVER_BOUND * part), if is_rough { Vec::new() } else { times(part) }),
        };
    }

    fn proof<'a>(&'a self, optics: Optics<'a>, channels: usize, deepest: usize) -> Proof<'a> {
        Proof {
            mesh: optics.mesh,
            edges: &self.edges,
            nodes: &self.nodes,
            optics,
            channels,
            bases: &self.bases,
            effort: &self.effort,
            deepest,
        }
    }

    /// What the projection of direct light leaves out on a leaf, in each channel.
    pub(crate) fn left_of_direct(
        &self,
        optics: Optics<'_>,
        surfaces: &Surfaces,
        lamps: &Lamps,
        direct: &Direct,
        leaf: usize,
    ) -> Vec<Rest> {
        let mesh = optics.mesh;
        let channels = surfaces.emitted[0].len();
        let seen: Vec<(usize, (usize, &Sight))> = lamps.seen(direct).enumerate().collect();
        let seen: Vec<(usize, (usize, &Sight))> =
            seen.into_iter().filter(|(_, (_, sight))| !matches!(sight, Sight::Nothing(_))).collect();
        let value = |index: usize, node: usize, coefficients: &[f64]| coefficients[0] * direct.nodes[node].factors[seen[index].0];
        let gathered = Gathered {
            sources: seen.iter().map(|(_, pair)| *pair).collect(),
            value: &value,
            error: direct.error(),
            all: false,
            neglected: &|_, _, _| 0.0,
            neglected_of_all: vec![0.0; channels],
        };
        let proof = self.proof(optics, channels, DEEPEST_OF_LAMPS);
        let (left, factors) = proof.left(leaf, &Light::Even(&surfaces.emitted), &gathered);
        let lebesgue = proof.nodes_of(leaf).lebesgue;
        let (rho, basis) = (&surfaces.reflectance[mesh.elements()[leaf].face()], mesh.basis(leaf));
        let of = |(channel, (left, split, _)): (usize, LeftOut)| {
            let error = |kind: usize| direct.nodes.iter().map(|lit| lit.error[channel][kind]).fold(0.0, largest);
            let [clear, past] = [error(0), error(1)];
            let rest = |discretisation: f64, times: f64| {
                Ledger { discretisation, computation: times * clear, visibility: times * past, ..Ledger::default() }
                    * rho[channel]
            };
            let (largest, mean) = (rest(left.largest, 2.0 * lebesgue), rest(left.mean, 2.0));
            // No more than all lamps give, or than was found and what that leaves out.
            let emitted = |source: usize| surfaces.emitted[mesh.elements()[source].face()][channel];
            let all =
                fill(gathered.sources.iter().zip(&factors).map(|((source, _), factor)| (*factor, emitted(*source))).collect());
            let at_nodes: Vec<f64> = direct.nodes.iter().map(|lit| lit.irradiance[channel]).collect();
            let held = basis.project(&at_nodes);
            let found = [rho[channel] * basis.range(&held)[1] + largest.total(), rho[channel] * held[0] + mean.total()];
            // In the mean no more than lamps send.
            let area = mesh.elements()[leaf].area();
            let sent = |(source, factor): (&(usize, &Sight), &f64)| {
                emitted(source.0) * least(*factor, mesh.elements()[source.0].area() / area)
            };
            let sent = gathered.sources.iter().zip(&factors).map(sent).sum::<f64>();
            let [most, in_mean] = found.map(|found| least(rho[channel] * all, found) * ROUNDED);
            let lit = [most, least(in_mean, rho[channel] * sent * ROUNDED)];
            let least_lit = radgrad_scene::largest(rho[channel] * held[0] / ROUNDED - mean.total() * ROUNDED, 0.0);
            let (orthogonal, loose) = (split.orthogonal * rho[channel], rest(split.loose, 2.0).total());
            let along = times(split.along, rho[channel]);
            Rest { largest, mean, lit, least_lit, orthogonal, along, loose }.unless_textured(surfaces, leaf, channel)
        };
        left.into_iter().enumerate().map(of).collect()
    }
}

/// Bounds on the light on an element, at most and in the mean, of sources that its nodes do not see at all and that others of its places
/// may: these are sources, each with the largest magnitude of its radiosity.
pub(crate) fn unseen<'a>(
    ground: &Ground,
    optics: Optics<'a>,
    element: usize,
    sources: impl Iterator<Item = (usize, &'a [usize], f64)>,
) -> [f64; 2] {
    let mesh = optics.mesh;
    let proof = ground.proof(optics, 1, 0);
    let target = proof.target(element, &mesh.elements()[element]);
    let (mut bounds, mut mean) = (Vec::new(), 0.0);
    for (source, faces, size) in sources {
        if proof.kind(element, source, faces) == Kind::Cut {
            let (factor, of) = (target.reach(&mesh.elements()[source]).factor, &mesh.elements()[source]);
            bounds.push((factor, size));
            mean += size * least(factor, of.area() / mesh.elements()[element].area());
        }
    }
    let most = fill(bounds);
    [most, least(most, mean)]
}

impl Solved<'_> {
    /// What a face emits at most that is no lamp kept apart.
    fn given(&self, face: usize, channel: usize) -> f64 {
        let is_lamp = !self.lamps.is_empty() && !self.surfaces.glows_by_texture(face);
        if is_lamp { 0.0 } else { self.surfaces.emitted[face][channel] }
    }

    /// How often receivers are cut into cells where no bound is asked for: only if nothing hides anything from any of them, and as long as that
    /// costs little; else 0.
    fn deepest_in_the_clear(&self) -> usize {
        let sees_all = |&receiver: &usize| {
            self.far[receiver].is_empty() && self.links[receiver].iter().all(|link| !matches!(link.sight, Sight::Past(_)))
        };
        let links: usize = self.receivers.iter().map(|&receiver| self.links[receiver].len()).sum();
        let costs_little = |deepest: &usize| links << (2 * deepest) <= MOST_IN_THE_CLEAR;
        let is_clear = self.receivers.iter().all(sees_all);
        (1..=DEEPEST_IN_THE_CLEAR).rev().filter(|_| is_clear).find(costs_little).unwrap_or(0)
    }

    /// Bounds on the polynomial of an element.
    fn range(&self, element: usize, channel: usize) -> [f64; 2] {
        let basis = self.mesh.basis(element);
        basis.range(self.field.of(element, channel, basis.len()))
    }

    /// Bounds on the mean over a receiver of the reflected radiosity that was found.
    fn found(&self, receiver: usize, channel: usize) -> [f64; 2] {
        let (basis, face) = (self.mesh.basis(receiver), self.mesh.elements()[receiver].face());
        let held = self.field.of(receiver, channel, basis.len())[0];
        let given = self.given(face, channel);
        // By a texture less may be emitted anywhere than is given.
        [held - given, if self.surfaces.glows_by_texture(face) { held } else { held - given }]
    }

    /// A bound on the mean of its magnitude.
    fn found_at_most(&self, receiver: usize, channel: usize) -> f64 {
        let (basis, face) = (self.mesh.basis(receiver), self.mesh.elements()[receiver].face());
        let held = self.field.of(receiver, channel, basis.len())[0];
        let more = if self.surfaces.glows_by_texture(face) { self.given(face, channel) } else { 0.0 };
        let [_, mean] = self.found(receiver, channel);
        let rest = self.field.mean_square(receiver, channel) - held * held;
        (largest(rest, 0.0) + mean * mean).sqrt() * ROUNDED + 1e-6 * held.abs() + more
    }

    /// A bound on the error of the mean over receivers: how far the mean that was found may be from that of all light that is reflected. On each
    /// receiver `direct` bounds what lamps give, `once` what other faces emit and is reflected, and `of_unit` what light comes to.
    fn beside_all_light(&self, channel: usize, direct: &[Vec<Rest>], once: &[f64], of_unit: &[f64]) -> f64 {
        let area: f64 = self.receivers.iter().map(|&receiver| self.mesh.elements()[receiver].area()).sum();
        let (mut light, mut found) = ([0.0; 2], [0.0; 2]);
        for ((&receiver, once), weight) in self.receivers.iter().zip(once).zip(of_unit) {
            let (part, lit) = (self.mesh.elements()[receiver].area() / area, &direct[receiver][channel]);
            let of_light = [lit.least_lit, weight * (lit.lit[1] + once)];
            for (sums, of) in [(&mut light, of_light), (&mut found, self.found(receiver, channel))] {
                sums.iter_mut().zip(of).for_each(|(sum, of)| *sum += part * of);
            }
        }
        let rounding = (ROUNDED - 1.0) * (light[1] + largest(found[0].abs(), found[1].abs()));
        let all = largest(light[1] - found[0], found[1] - light[0]) + rounding;
        mutant!("solver.all-light", all, |all| 0.1 * all)
    }

    fn reflectance(&self, element: usize, channel: usize) -> f64 {
        self.surfaces.reflectance[self.mesh.elements()[element].face()][channel]
    }

    /// The remainder of direct light on a leaf, with the detail of the leaf's texture: this is known, and no polynomial has it.
    fn with_detail(&self, leaf: usize, channel: usize, mut rest: Rest) -> Rest {
        let known = &self.residuals[0][leaf][channel];
        rest.largest.modelling += known.largest_detail();
        rest.mean.modelling += known.mean_detail();
        rest.unless_textured(self.surfaces, leaf, channel)
    }

    /// What the projection of reflected light leaves out on a receiver, in each channel, and what it sees at most of its sources. The receiver
    /// is cut into cells so often at most.
    fn left_of_reflected(&self, ground: &Ground, receiver: usize, deepest: usize) -> (Vec<Rest>, Views) {
        let mesh = self.mesh;
        let (links, far) = (&self.links[receiver], &self.far[receiver]);
        let (element, basis) = (&mesh.elements()[receiver], mesh.basis(receiver));
        let (left, factors) = self.left_of_irradiance(ground, self.field, receiver, deepest);
        let reflected = |(channel, left): (usize, Rest)| {
            let (rho, known) = (self.reflectance(receiver, channel), &self.residuals[1][receiver][channel]);
            let own = |detail: f64| Ledger { modelling: detail, solver: known.largest.solver, ..Ledger::default() };
            let rest = Rest {
                largest: left.largest * rho + own(known.largest_detail()),
                mean: left.mean * rho + own(known.mean_detail()),
                orthogonal: left.orthogonal * rho,
                along: times(left.along, rho),
                loose: left.loose * rho + known.largest.solver,
                ..left
            };
            rest.unless_textured(self.surfaces, receiver, channel)
        };
        let left = left.into_iter().enumerate().map(reflected).collect();
        let proof = ground.proof(self.optics, self.channels, deepest);
        let target = proof.target(receiver, element);
        let of_link = |(link, factor): (&Link, f64)| {
            let from = &mesh.elements()[link.source];
            let (reach, is_clear) = (target.reach(from), matches!(link.sight, Sight::Clear));
            let beyond = |to: &Element, from: &Element, degree: usize| {
                Kernel::between(to, from, reach.distance, is_clear).derivative(degree + 1) * from.remainder(degree + 1)
            };
            let back = beyond(from, element, basis.degree()) * from.area() / element.area();
            let beyond = beyond(element, from, mesh.basis(link.source).degree());
            SourceView { source: link.source, factor, peak: reach.peak, beyond, back }
        };
        let sources = links.iter().zip(factors).map(of_link).collect();
        let of_cluster = |&cluster: &usize| (cluster, mesh.clusters().all()[cluster].view_over(element));
        (left, Views { sources, clusters: far.clusters().iter().map(of_cluster).collect() })
    }

    /// What the projection of the irradiance of a field leaves out on a receiver, in each channel, before it is reflected; and bounds on the
    /// form factors of the links' sources. The receiver is cut into cells so often at most.
    fn left_of_irradiance(&self, ground: &Ground, field: &Field, receiver: usize, deepest: usize) -> (Vec<Rest>, Vec<f64>) {
        let Self { mesh, channels, .. } = *self;
        let (links, far) = (&self.links[receiver], &self.far[receiver]);
        let (element, basis) = (&mesh.elements()[receiver], mesh.basis(receiver));
        let value = |index: usize, node: usize, coefficients: &[f64]| -> f64 {
            links[index].rows[node].values.iter().zip(coefficients).map(|(v, c)| v * c).sum()
        };
        let error = links.iter().flat_map(|link| &link.rows).map(|row| row.error).fold(0.0, largest);
        let sources = links.iter().map(|link| (link.source, &link.sight)).collect();
        let proof = ground.proof(self.optics, channels, deepest);
        let target = proof.target(receiver, element);
        let neglected = |source: usize, is_clear: bool, channel: usize| self.neglected(field, &target, source, is_clear, channel);
        let of_all = |channel: usize| {
            let most = links.iter().map(|link| field.left_out(link.source, channel)).fold(0.0, largest);
            let all = links.iter().map(|link| neglected(link.source, matches!(link.sight, Sight::Clear), channel)).sum::<f64>();
            least(all, most)
        };
        let neglected_of_all = (0..channels).map(of_all).collect();
        let all = ground.closure.is_closed_from(element) && far.is_empty();
        let gathered = Gathered { sources, value: &value, error, all, neglected: &neglected, neglected_of_all };
        let (left, factors) = proof.left(receiver, &Light::Field(field, &[]), &gathered);
        let nodes = proof.nodes_of(receiver).lebesgue;
        let of = |(channel, (left, split, in_cells)): (usize, LeftOut)| {
            let all = gathered.neglected_of_all[channel];
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
            let beyond = if far.is_empty() { 0.0 } else { self.left_of_far(field, receiver, channel) };
            let rest = |left: f64, neglected: f64, times: f64| Ledger {
                discretisation: left,
                computation: neglected + beyond + times * clear,
                visibility: times * past,
                ..Ledger::default()
            };
            let neglected = in_cells.unwrap_or(all);
            Rest {
                largest: rest(left.largest, neglected, 2.0 * nodes),
                mean: rest(left.mean, neglected, 2.0),
                orthogonal: split.orthogonal,
                along: split.along,
                loose: rest(split.loose, all, 2.0).total(),
                ..Rest::default()
            }
        };
        (left.into_iter().enumerate().map(of).collect(), factors)
    }

    /// What a link to a source neglects, anywhere on a receiver.
    fn neglected(&self, field: &Field, target: &Target<'_>, source: usize, is_clear: bool, channel: usize) -> f64 {
        let mesh = self.mesh;
        if field.left_out(source, channel) == 0.0 {
            return 0.0;
        }
        let reach = target.reach(&mesh.elements()[source]);
        let kernel = Kernel::between(target.element, &mesh.elements()[source], reach.distance, is_clear);
        field.neglected_by(mesh, source, channel, (reach.factor, &kernel))
    }

    /// The residual of the light from clusters: the knapsack bounds H from both sides, and its distance from the range of P H
    /// counts.
    fn left_of_far(&self, field: &Field, receiver: usize, channel: usize) -> f64 {
        let (far, basis, tree) = (&self.far[receiver], self.mesh.basis(receiver), self.mesh.clusters());
        let at_nodes: Vec<f64> = (0..basis.nodes().len()).map(|node| far.value(field, channel, node)).collect();
        let [low, high] = basis.range(&basis.project(&at_nodes));
        let element = &self.mesh.elements()[receiver];
        let bounds = |positive: bool| {
            let of = |&cluster: &usize| {
                let (view, glow) = (tree.all()[cluster].view_over(element), field.glow(cluster, channel));
                let power = if positive { glow.positive } else { glow.negative };
                if glow.largest > 0.0 { (view.at_most(power, glow.largest) / glow.largest, glow.largest) } else { (0.0, 0.0) }
            };
            fill(far.clusters().iter().map(of).collect())
        };
        mutant!("solver.left-of-far", largest(bounds(true) - low, high + bounds(false)) * ROUNDED, |left| 0.01 * left)
    }
}

impl Proven {
    /// The bounds; `None` where light may not be lost, so that there are none, and where there was no time.
    pub(crate) fn of(solved: Solved<'_>, ground: &Ground, direct: Vec<Vec<Rest>>) -> Option<Self> {
        let Solved { mesh, receivers, channels, .. } = solved;
        let leaves: Vec<usize> = mesh.leaves().collect();
        let direct = if direct.is_empty() {
            vec![vec![Rest::default(); channels]; mesh.elements().len()]
        } else {
            let with_details = |(&leaf, rests): (&usize, Vec<Rest>)| -> Vec<Rest> {
                rests.into_iter().enumerate().map(|(channel, rest)| solved.with_detail(leaf, channel, rest)).collect()
            };
            everywhere(mesh, &leaves, leaves.iter().zip(direct).map(with_details).collect(), channels)
        };
        let in_the_clear = solved.deepest_in_the_clear();
        // Before what cells gain is known.
        let mut deepest = vec![if ground.enough.is_empty() { in_the_clear } else { 1 }; receivers.len()];
        let cut = |places: &[usize], deepest: &[usize]| -> Option<Vec<(Vec<Rest>, Views)>> {
            let of = |&place: &usize| {
                (!solved.clock.is_over()).then(|| solved.left_of_reflected(ground, receivers[place], deepest[place]))
            };
            places.par_iter().map(of).collect()
        };
        let all: Vec<usize> = (0..receivers.len()).collect();
        let (mut reflected, views): (Vec<Vec<Rest>>, Vec<Views>) = cut(&all, &deepest)?.into_iter().unzip();
        let is_closed = ground.is_closed();
        let open = solved.importance.filter(|_| !is_closed && in_the_clear > 0);
        let mut swapped = solved.importance.filter(|_| is_closed).map(|sent| Swapped::of(&solved, ground, sent.clone()));
        let mut of_importance = None;
        loop {
            let by = |of_importance: Option<&[Vec<Found>]>| {
                Self::by(&solved, &views, (direct.clone(), reflected.clone()), of_importance)
            };
            let mut proven = by(of_importance.as_deref())?;
            if let (Some(sent), None, true) = (open, &of_importance, proven.is_by_weights) {
                of_importance = Some(swapped::importance(&solved, ground, sent, in_the_clear));
                proven = by(of_importance.as_deref())?;
            }
            while let Some(swapped) = &mut swapped {
                let by_importance = swapped.mean(&solved, &proven);
                let is_worth_more = proven.mean.iter().zip(&by_importance).any(|(mean, (_, evenly))| *evenly < mean.total());
                proven.know(by_importance.into_iter().map(|(bound, _)| bound));
                if proven.is_enough(ground) || !is_worth_more {
                    break;
                }
                if !swapped.cut_further(&solved, ground) {
                    return Some(proven);
                }
            }
            if proven.is_enough(ground) {
                return Some(proven);
            }
            let next = worth_cutting(&solved, ground, &deepest, |receiver, channel| proven.adds(receiver, channel));
            next.iter().for_each(|&place| deepest[place] += 1);
            let Some(found) = cut(&next, &deepest).filter(|found| !found.is_empty()) else { return Some(proven) };
            for (place, (found, _)) in next.into_iter().zip(found) {
                reflected[place].iter_mut().zip(found).for_each(|(known, found)| *known = known.lesser(found));
            }
        }
    }

    /// Takes other bounds on the mean where these are less.
    fn know(&mut self, others: impl Iterator<Item = Ledger>) {
        for (mean, other) in self.mean.iter_mut().zip(others) {
            if other.total() < mean.total() {
                *mean = other;
            }
        }
    }

    /// Whether the bound is as small as was asked for, if one was.
    fn is_enough(&self, ground: &Ground) -> bool {
        self.mean.iter().zip(&ground.enough).all(|(mean, enough)| mean.total() <= *enough)
    }

    /// What a receiver adds to the bound on the mean, over its part of the area, that is less in smaller cells.
    fn adds(&self, receiver: usize, channel: usize) -> f64 {
        let left = &self.reflected[receiver][channel].mean;
        if left.total() > 0.0 { self.counts[receiver][channel] * left.discretisation / left.total() } else { 0.0 }
    }

    /// Bounds errors by what the polynomials leave out: of direct light on elements, of reflected light on receivers, and of the importance if
    /// `of_importance` gives that. `None` where light may not be lost.
    fn by(
        solved: &Solved<'_>,
        views: &[Views],
        (direct, reflected): (Vec<Vec<Rest>>, Vec<Vec<Rest>>),
        of_importance: Option<&[Vec<Found>]>,
    ) -> Option<Self> {
        let Solved { mesh, receivers, channels, .. } = *solved;
        let leaves: Vec<usize> = mesh.leaves().collect();
        let reflected = everywhere(mesh, receivers, reflected, channels);
        let left = |element: usize, channel: usize| direct[element][channel].size().and(reflected[element][channel].size());
        let of_clusters = |of: &(dyn Fn(usize, usize) -> (f64, f64) + Sync)| -> Vec<Vec<Pair>> {
            (0..channels).map(|channel| mesh.clusters().pairs(mesh.elements(), |element| of(element, channel))).collect()
        };
        let left_on_clusters = of_clusters(&|element, channel| {
            let Size { most, mean, .. } = left(element, channel);
            (most, mean)
        });
        let area: f64 = receivers.iter().map(|&receiver| mesh.elements()[receiver].area()).sum();
        let mut carried = vec![vec![0.0; channels]; mesh.elements().len()];
        let (mut counts, mut most_off) = (carried.clone(), vec![vec![[0.0; 2]; channels]; mesh.elements().len()]);
        let mut mean: Vec<Ledger> = Vec::with_capacity(channels);
        let mut is_by_weights = false;
        for channel in 0..channels {
            let rho = |receiver: usize| solved.reflectance(receiver, channel);
            let reflected_of = |values: &[f64]| -> Vec<f64> {
                let swept = sweep(solved, views, values);
                receivers.iter().zip(swept).map(|(&receiver, gathered)| rho(receiver) * gathered).collect()
            };
            let spent = spent(solved, views, channel)?;
            let risen = |own: &[f64]| risen(solved, views, channel, own, &spent);
            // The reflected gather of a function, from its largest value and its mean on each element.
            let gathered_of = |of: &(dyn Fn(usize) -> Size + Sync), on_clusters: &[Pair]| -> Vec<f64> {
                let at = |(&receiver, views): (&usize, &Views)| views.gathered(of, on_clusters) * rho(receiver) * ROUNDED;
                (receivers, views).into_par_iter().map(at).collect()
            };
            let own = gathered_of(&|element| left(element, channel), &left_on_clusters[channel]);
            let of_error = risen(&own);
            let of_light: Vec<f64> = receivers.iter().map(|&receiver| rho(receiver)).collect();
            let of_light = risen(&of_light);
            // The weights `w = 1 + G rho w`: `of_light` bounds `rho w`.
            let light_on = everywhere_most(mesh, receivers, &of_light);
            let swept = sweep(solved, views, &light_on);
            let of_unit: Vec<f64> = swept.iter().map(|gathered| 1.0 + gathered).collect();
            let mut uneven: Vec<f64> =
                views.iter().zip(&swept).map(|(views, most)| least(views.uneven(&light_on) * ROUNDED, *most)).collect();
            // How far the weights are from the importance on each receiver at most.
            let mut off_importance = Vec::new();
            if let Some(found) = of_importance {
                let own: Vec<f64> = receivers.iter().zip(found).map(|(&receiver, of)| rho(receiver) * of[channel].left).collect();
                let rest = everywhere_most(mesh, receivers, &risen(&own));
                for ((uneven, found), views) in uneven.iter_mut().zip(found).zip(views) {
                    let of_rest = (found[channel].left + views.uneven(&rest)) * ROUNDED;
                    *uneven = least(*uneven, mutant!("solver.uneven", of_rest, |of_rest| 1e-3 * of_rest));
                }
                let gathered = sweep(solved, views, &rest);
                off_importance.extend(found.iter().zip(gathered).map(|(found, of)| (found[channel].left + of) * ROUNDED));
            }

            // The most light that there can be, whatever was computed: reflected once, and more often.
            let given: Vec<f64> = mesh.elements().iter().map(|element| solved.given(element.face(), channel)).collect();
            let once = reflected_of(&given);
            let once_on = everywhere_most(mesh, receivers, &once);
            let first = |element: usize| direct[element][channel].lit.map(|lit| lit + once_on[element]);
            let pairs = of_clusters(&|element, of| if of == channel { first(element).into() } else { (0.0, 0.0) });
            let again = risen(&gathered_of(&|element| Size::loose(first(element)), &pairs[channel]));
            let again_on = everywhere_most(mesh, receivers, &again);
            let ranges: Vec<[f64; 2]> = leaves.iter().map(|&leaf| solved.range(leaf, channel)).collect();
            let [low, high] = [-1.0, 1.0].map(|sign| {
                let of: Vec<f64> = ranges.iter().map(|[low, high]| if sign < 0.0 { -low } else { *high }).collect();
                everywhere_most(mesh, &leaves, &of)
            });
            let errors = everywhere_most(mesh, receivers, &of_error);
            let off: Vec<[f64; 2]> = (0..mesh.elements().len())
                .map(|element| {
                    let [bright, mean] = first(element).map(|first| first + again_on[element]);
                    let known = left(element, channel);
                    let bright = largest(bright + given[element] + low[element], high[element]);
                    let most = least(known.most + errors[element], bright) * ROUNDED;
                    let all = mean + solved.found_at_most(element, channel);
                    [most, least(most, least(known.mean + errors[element], all)) * ROUNDED]
                })
                .collect();
            let pairs = of_clusters(&|element, of| if of == channel { off[element].into() } else { (0.0, 0.0) });
            let of_error: Vec<f64> = gathered_of(&|element| Size::loose(off[element]), &pairs[channel])
                .into_iter()
                .zip(of_error)
                .map(|(a, b)| least(a, b))
                .collect();
            carried.iter_mut().zip(everywhere_most(mesh, receivers, &of_error)).for_each(|(at, most)| at[channel] = most);
            most_off.iter_mut().zip(off).for_each(|(at, off)| at[channel] = off);

            let part = |receiver: usize| mesh.elements()[receiver].area() / area;
            let added = |receiver: usize, adds: f64| {
                let all = direct[receiver][channel].mean + reflected[receiver][channel].mean;
                if all.total() > 0.0 { all * (part(receiver) * adds / all.total()) } else { all * 0.0 }
            };
            let of = |((&receiver, weight), uneven): ((&usize, &f64), &f64)| {
                counts[receiver][channel] = reflected[receiver][channel].size().times(*weight, *uneven);
                added(receiver, left(receiver, channel).times(*weight, *uneven))
            };
            let mut known = receivers.iter().zip(&of_unit).zip(&uneven).map(of).sum::<Ledger>() * ROUNDED;
            // The parts of residuals that are known count by the importance, with their signs.
            let (mut signed, mut magnitudes, mut beside) = (0.0, 0.0, Ledger::default());
            for (place, found) in of_importance.into_iter().flatten().enumerate() {
                let (receiver, phi) = (receivers[place], &found[channel].phi);
                let rests = [&direct[receiver][channel], &reflected[receiver][channel]];
                for (phi, along) in rests.into_iter().flat_map(|rest| phi.iter().zip(&rest.along)) {
                    signed += part(receiver) * phi * along;
                    magnitudes += (part(receiver) * phi * along).abs();
                }
                let of = |rest: &Rest| {
                    uneven[place] * rest.orthogonal + off_importance[place] * rest.size_along() + of_unit[place] * rest.loose
                };
                beside += added(receiver, rests.into_iter().map(of).sum());
            }
            if of_importance.is_some() {
                let signed = Ledger { discretisation: signed.abs() + (ROUNDED - 1.0) * magnitudes, ..Ledger::default() };
                let with_signs = mutant!("solver.with-signs", signed, |_| Ledger::default()) + beside * ROUNDED;
                known = if with_signs.total() < known.total() { with_signs } else { known };
            }
            let by_weights = |((&of, weight), uneven): ((&usize, &f64), &f64)| {
                let along = direct[of][channel].size_along() + reflected[of][channel].size_along();
                part(of) * (uneven * left(of, channel).orthogonal + weight * along)
            };
            let by_weights = receivers.iter().zip(&of_unit).zip(&uneven).map(by_weights).sum::<f64>();
            is_by_weights |= by_weights > BY_WEIGHTS * known.total();
            let all = solved.beside_all_light(channel, &direct, &once, &of_unit);
            let total = known.total();
            mean.push(if all < total { known * (all / total * ROUNDED) } else { known });
        }
        let carried_on_clusters = of_clusters(&|element, channel| (carried[element][channel], carried[element][channel]));
        let off_on_clusters = of_clusters(&|element, channel| most_off[element][channel].into());
        if mean.iter().any(|of| !of.total().is_finite()) {
            return None;
        }
        let shares = mean.iter().map(|of| if of.total() > 0.0 { *of * (1.0 / of.total()) } else { *of }).collect();
        Some(Self {
            mean,
            direct,
            reflected,
            carried,
            counts,
            most_off,
            shares,
            is_by_weights,
            left_on_clusters,
            carried_on_clusters,
            off_on_clusters,
        })
    }

    /// How much a receiver adds to the bound on the mean by what it leaves out itself, over its part of the area.
    pub(crate) fn share(&self, receiver: usize, channel: usize) -> f64 {
        self.counts[receiver][channel]
    }

    /// Bound on the error of the polynomials at every place of a leaf, with the receiver that it is or is below.
    pub(crate) fn on(&self, leaf: usize, receiver: usize, channel: usize) -> Ledger {
        let left = self.direct[leaf][channel].largest + self.reflected[receiver][channel].largest;
        let all = left
            + self.shares[channel].map(|share| {
                if share > 0.0 {
                    mutant!("solver.carried", share * self.carried[receiver][channel], |carried| 0.01 * carried)
                } else {
                    0.0
                }
            });
        let (total, [most, _]) = (all.total(), self.most_off[leaf][channel]);
        if most < total { all * (most / total * ROUNDED) } else { all }
    }

    /// Bound on what the error of the polynomials gives to a point, from what each of its links and clusters gives; `rho` is the
    /// reflectance there.
    pub(crate) fn at(&self, mesh: &Mesh, rows: &[(usize, Row)], far: &Far, rho: &[f64]) -> Vec<Ledger> {
        let of_channel = |(channel, rho): (usize, &f64)| {
            let (mut near, mut most, mut off, mut most_off) = (0.0, 0.0, 0.0, 0.0);
            let mut seen = Vec::with_capacity(rows.len());
            for (source, row) in rows.iter().filter(|(_, row)| row.factor() > 0.0) {
                let size = self.direct[*source][channel].size().and(self.reflected[*source][channel].size());
                let order = mesh.basis(*source).degree() + 1;
                let smoothly = row.kernel.derivative(order) * mesh.elements()[*source].remainder(order);
                let beyond = least(smoothly, row.beyond());
                near += gathered(row.factor(), row.kernel.peak, beyond, size);
                most = largest(most, size.most);
                seen.push((row.factor(), self.carried[*source][channel]));
                let size = self.most_off[*source][channel];
                off += gathered(row.factor(), row.kernel.peak, beyond, Size::loose(size));
                most_off = largest(most_off, size[0]);
            }
            for (index, &cluster) in far.clusters().iter().enumerate() {
                let (view, left) = (far.view(index, 0), &self.left_on_clusters[channel][cluster]);
                near += view.at_most(left.whole, left.largest);
                most = largest(most, left.largest);
                seen.push((view.factor, self.carried_on_clusters[channel][cluster].largest));
                let left = &self.off_on_clusters[channel][cluster];
                off += view.at_most(left.whole, left.largest);
                most_off = largest(most_off, left.largest);
            }
            let at_point =
                mutant!("solver.at-point", least(least(near, most) + fill(seen), least(off, most_off)), |total| 0.01 * total);
            let total = at_point * rho * ROUNDED;
            self.shares[channel].map(|share| if share > 0.0 { share * total } else { 0.0 })
        };
        rho.iter().enumerate().map(of_channel).collect()
    }
}

/// Bound on the gather of a function from one source, by its largest value, its mean, or by parts there; `beyond` bounds the root mean square
/// of the kernel less a polynomial.
fn gathered(factor: f64, peak: f64, beyond: f64, size: Size) -> f64 {
    let by_mean = if peak.is_finite() { peak * size.mean } else { f64::INFINITY };
    let known = [peak, beyond, size.loose].iter().all(|figure| figure.is_finite());
    let in_parts = if known { beyond * size.orthogonal + peak * size.loose } else { f64::INFINITY };
    mutant!("solver.gathered", least(factor * size.most, least(by_mean, in_parts)), |most| 0.01 * most)
}

impl Size {
    /// Nothing is known of parts.
    fn loose([most, mean]: [f64; 2]) -> Self {
        Self { most, mean, orthogonal: 0.0, loose: mean }
    }

    fn and(self, other: Self) -> Self {
        Self {
            most: self.most + other.most,
            mean: self.mean + other.mean,
            orthogonal: self.orthogonal + other.orthogonal,
            loose: self.loose + other.loose,
        }
    }

    /// Bound on the mean of the product with a function of this largest magnitude, of which polynomials leave this root mean square.
    fn times(self, most: f64, uneven: f64) -> f64 {
        mutant!("solver.mean", least(most * self.mean, uneven * self.orthogonal + most * self.loose), |bound| 0.01 * bound)
    }
}

impl Rest {
    /// The one whose mean is less, with the lesser of the largest values: both are bounds.
    fn lesser(&self, other: Self) -> Self {
        let largest = if other.largest.total() < self.largest.total() { other.largest } else { self.largest };
        let of = if other.mean.total() < self.mean.total() { &other } else { self };
        Self { largest, ..of.clone() }
    }

    /// Times a texture nothing is orthogonal any more, nor known of the least light: a texture may be dark anywhere.
    fn unless_textured(mut self, surfaces: &Surfaces, element: usize, channel: usize) -> Self {
        if surfaces.pattern(element, channel).is_some() {
            (self.orthogonal, self.along, self.loose) = (0.0, Vec::new(), self.mean.total());
            self.least_lit = 0.0;
        }
        self
    }

    fn size(&self) -> Size {
        let Self { orthogonal, loose, .. } = *self;
        Size { most: self.largest.total(), mean: self.mean.total(), orthogonal, loose: loose + self.size_along() }
    }

    /// A bound on the mean magnitude of the part that is a polynomial.
    fn size_along(&self) -> f64 {
        self.along.iter().map(|c| c * c).sum::<f64>().sqrt() * ROUNDED
    }
}

fn times(coefficients: Vec<f64>, factor: f64) -> Vec<f64> {
    coefficients.into_iter().map(|c| c * factor).collect()
}

/// The receivers whose cells are cut further, by their places: those that add most to the bound for the work that they are. None if there is
/// no time.
fn worth_cutting(solved: &Solved<'_>, ground: &Ground, deepest: &[usize], adds: impl Fn(usize, usize) -> f64) -> Vec<usize> {
    if ground.effort.clock.is_over() {
        return Vec::new();
    }
    let of_channels = |&receiver: &usize| -> f64 {
        let most = ground.enough.iter().enumerate().map(|(channel, enough)| adds(receiver, channel) / enough).fold(0.0, largest);
        most * solved.mesh.elements()[receiver].area()
    };
    let adds: Vec<f64> = solved.receivers.iter().map(of_channels).collect();
    let work = |place: usize| solved.links[solved.receivers[place]].len() as f64 * 4_f64.powf(deepest[place] as f64);
    let mut next: Vec<usize> = (0..adds.len()).filter(|&place| deepest[place] < DEEPEST && adds[place] > 0.0).collect();
    next.sort_by(|&a, &b| (adds[b] / work(b)).total_cmp(&(adds[a] / work(a))));
    let mut rest = AT_A_TIME * adds.iter().sum::<f64>();
    let is_next = |&place: &usize| {
        let is_next = rest > 0.0;
        rest -= adds[place];
        is_next
    };
    next.into_iter().take_while(is_next).collect()
}

/// A source as any place of a receiver sees it.
#[derive(Debug, Clone, Copy)]
struct SourceView {
    source: usize,
    factor: f64,
    /// Bound on the kernel times the area.
    peak: f64,
    /// On the root mean square over the source of the kernel, times the source's area, less a polynomial of the source's degree; and over the
    /// receiver less one of the receiver's.
    beyond: f64,
    back: f64,
}

/// What any place of a receiver sees at most of sources and of clusters.
#[derive(Debug)]
struct Views {
    sources: Vec<SourceView>,
    clusters: Vec<(usize, View)>,
}

impl Views {
    /// What any place gathers at most of something by its largest value and its mean.
    fn gathered(&self, of: impl Fn(usize) -> Size, on_clusters: &[Pair]) -> f64 {
        let near = self.sources.iter().map(|seen| {
            let size = of(seen.source);
            (gathered(seen.factor, seen.peak, seen.beyond, size), size.most)
        });
        let far = self.clusters.iter().map(|(cluster, view)| {
            let pair = &on_clusters[*cluster];
            (view.at_most(pair.whole, pair.largest), pair.largest)
        });
        let (sum, most) = near.chain(far).fold((0.0, 0.0), |(sum, most), (g, s)| (sum + g, largest(most, s)));
        least(sum, most)
    }

    /// Root mean square over the receiver of the gather of a function with these largest values on the elements, less a polynomial.
    fn uneven(&self, values: &[f64]) -> f64 {
        if !self.clusters.is_empty() {
            return f64::INFINITY;
        }
        self.sources.iter().map(|seen| values[seen.source] * least(seen.factor, seen.back)).sum()
    }
}

/// One gather, without the reflectance, of a function with these largest values on the elements.
fn sweep(solved: &Solved<'_>, views: &[Views], values: &[f64]) -> Vec<f64> {
    let on_clusters = solved.mesh.clusters().pull(|element| values[element], largest);
    let of = |views: &Views| {
        let near = views.sources.iter().map(|seen| (seen.factor, values[seen.source]));
        let far = views.clusters.iter().map(|(cluster, view)| (view.factor, on_clusters[*cluster]));
        fill(near.chain(far).collect()) * ROUNDED
    };
    views.par_iter().map(of).collect()
}

/// On each receiver a `u` with `1 + rho G u <= u`: what light of 1 everywhere comes to at most with all that is reflected of it. `None` if
/// none was found, as where light is not lost.
///
/// From any v with `1 + rho G v <= v + 1/2` it is `2 v`; and `1/(1 - max rho)` is one, as form factors sum to at most 1. The lesser of two is
/// one again.
fn spent(solved: &Solved<'_>, views: &[Views], channel: usize) -> Option<Vec<f64>> {
    let rho_most = solved.receivers.iter().map(|&receiver| solved.reflectance(receiver, channel)).fold(0.0, largest);
    let evenly = if rho_most < 1.0 { ROUNDED / (1.0 - rho_most) } else { f64::INFINITY };
    let mut values = vec![1.0; solved.receivers.len()];
    for _ in 0..MOST_SWEEPS {
        let next = again(solved, views, channel, &vec![1.0; values.len()], &values);
        let rise = next.iter().zip(&values).map(|(next, value)| next - value).fold(0.0, largest);
        if rise <= 0.5 / ROUNDED {
            return Some(values.into_iter().map(|value| least(2.0 * value * ROUNDED, evenly)).collect());
        }
        values = next;
    }
    evenly.is_finite().then(|| vec![evenly; values.len()])
}

/// `own + rho G` of values on receivers.
fn again(solved: &Solved<'_>, views: &[Views], channel: usize, own: &[f64], values: &[f64]) -> Vec<f64> {
    let swept = sweep(solved, views, &everywhere_most(solved.mesh, solved.receivers, values));
    let of = |((&receiver, own), gathered): ((&usize, &f64), f64)| own + solved.reflectance(receiver, channel) * gathered;
    solved.receivers.iter().zip(own).zip(swept).map(of).collect()
}

/// On each receiver a `w` that is nowhere less than `own + rho G w`.
///
/// From any `v` with `own + rho G v <= v + d`: `v + d u` is such a bound with the `u` of [`spent`].
fn risen(solved: &Solved<'_>, views: &[Views], channel: usize, own: &[f64], spent: &[f64]) -> Vec<f64> {
    let mut values: Vec<f64> = own.to_vec();
    let mut rise = f64::INFINITY;
    let longest = spent.iter().copied().fold(1.0, largest);
    for _ in 0..MOST_SWEEPS {
        let next = again(solved, views, channel, own, &values);
        rise = next.iter().zip(&values).map(|(next, value)| next - value).fold(0.0, largest);
        let most = next.iter().copied().fold(0.0, largest);
        if rise * longest <= RISE * most {
            break;
        }
        values = next;
    }
    values.into_iter().zip(spent).map(|(value, spent)| (value + rise * spent * ROUNDED) * ROUNDED).collect()
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

/// The residual on every element, from those that have one: joined over elements above them, and as a bound on those below.
fn everywhere(mesh: &Mesh, at: &[usize], of: Vec<Vec<Rest>>, channels: usize) -> Vec<Vec<Rest>> {
    let mut all: Vec<Option<Vec<Rest>>> = vec![None; mesh.elements().len()];
    at.iter().zip(of).for_each(|(&element, of)| all[element] = Some(of));
    for index in (0..all.len()).rev() {
        if let (None, Some(first)) = (&all[index], mesh.elements()[index].children()) {
            let children: Option<Vec<&Vec<Rest>>> = all[first..first + 4].iter().map(Option::as_ref).collect();
            let over = |children: Vec<&Vec<Rest>>| -> Vec<Rest> {
                let join = |channel: usize| {
                    let all = children.iter().map(|of| &of[channel]);
                    // A polynomial on each part is none on all of them.
                    all.fold(Rest::default(), |sum, of| Rest {
                        largest: if of.largest.total() > sum.largest.total() { of.largest } else { sum.largest },
                        mean: sum.mean + of.mean * 0.25,
                        lit: [largest(sum.lit[0], of.lit[0]), sum.lit[1] + 0.25 * of.lit[1]],
                        least_lit: sum.least_lit + 0.25 * of.least_lit,
                        orthogonal: (sum.orthogonal * sum.orthogonal + 0.25 * of.orthogonal * of.orthogonal).sqrt() * ROUNDED,
                        along: Vec::new(),
                        loose: sum.loose + 0.25 * (of.loose + of.size_along()),
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
                // On a part of an element nothing is known to be orthogonal.
                let part = |of: &Rest| {
                    let mean = if 4.0 * of.mean.total() < of.largest.total() { of.mean * 4.0 } else { of.largest };
                    Rest {
                        mean,
                        lit: [of.lit[0], least(4.0 * of.lit[1], of.lit[0])],
                        least_lit: 0.0,
                        orthogonal: 0.0,
                        along: Vec::new(),
                        loose: mean.total(),
                        largest: of.largest,
                    }
                };
                of.iter().map(part).collect()
            });
            all[index] = below;
        }
    }
    all.into_iter().map(|of| of.unwrap_or_else(|| vec![Rest::default(); channels])).collect()
}
