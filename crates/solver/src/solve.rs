//! The solution of a scene to an error: solve, bound, divide where the bound says that it pays, and again.
//!
//! Elements that receive gather reflected light, and may be divided into leaves for the sake of direct light alone, which is
//! cheap ([`crate::direct`]). Each round divides leaves until direct light is seen well enough, links the new receivers, sweeps
//! until the linear system is solved, refines links, and bounds the error. If the bound on its mean over all area is not within
//! the error asked for, relative to the mean radiosity, the receivers that add most to the bound are divided: those that
//! together make up a given part of it (W. Dörfler 1996). Asked to go by the gradient it divides instead, leaves and receivers
//! alike, what is off most in the mean square ([`crate::marking`]); by thresholds, nothing after the first round
//! ([`crate::linking`]).

mod divide;
mod options;
mod queries;
mod sweep;

use std::time::{Duration, Instant};

use radgrad_core::DVec3;
use radgrad_scene::Scene;
use rayon::prelude::*;

use crate::Error;
use crate::bound::proven::{Ground, Proven, Rest, Solved};
use crate::bound::{self, Bounds, Points, Residuals};
use crate::cell::Rules;
use crate::cluster::Far;
use crate::direct::{Direct, Lamps};
use crate::field::Field;
use crate::gathering::irradiance;
use crate::link::{Link, Need, for_each};
use crate::linking::Linking;
use crate::marking::{Marking, Samples};
use crate::mesh::{Mesh, Sight};
use crate::residual::Residual;
use crate::surfaces::Surfaces;
use crate::transfer::Optics;
use divide::{BULK, bulk};
pub use options::{Options, Progress};

/// Degree of the basis if none is given.
const DEGREE: usize = 2;

/// The part of the error asked for that links may neglect.
const LINK_PART: f64 = 0.1;

/// The part of the error asked for that one evaluation may have, per unit of the source's radiosity.
const EVALUATION_PART: f64 = 2e-4;

/// The same where there are no lamps and no clusters: light may then be far more even than was asked for, and known as well.
const GLOWING_PART: f64 = 2e-10;

/// The least error asked of an evaluation, about what closed forms in double precision have.
const FINEST: f64 = 1e-14;

/// The part of the error asked for that direct light may leave out in the mean.
const DIRECT_PART: f64 = 0.25;

/// Changes relative to the mean radiosity below which the linear system is solved: where light may be even, as for evaluations,
/// and, over the error aimed at, in scenes with lamps.
const SOLVED: f64 = 1e-13;
const ROUGHLY_SOLVED: f64 = 1e-4;

/// How much longer than the round before one is expected to take at most.
const MOST_GROWTH: f64 = 3.0;

/// A piecewise polynomial radiosity with a bound on its error.
#[derive(Debug)]
pub struct Solution {
    pub(crate) mesh: Mesh,
    pub(crate) surfaces: Surfaces,
    pub(crate) rules: Rules,
    pub(crate) lamps: Lamps,
    /// Direct light on each leaf.
    pub(crate) direct: Vec<Direct>,
    /// All light that elements send out, but for what lamps emit.
    pub(crate) field: Field,
    /// What receivers themselves hold: light reflected twice or more, and what is emitted where no lamps are kept apart.
    own: Vec<Vec<f64>>,
    /// Of receivers; empty for other elements.
    pub(crate) links: Vec<Vec<Link>>,
    /// Of receivers, the clusters that no link is for.
    pub(crate) far: Vec<Far>,
    receivers: Vec<usize>,
    /// Samples of direct light on leaves and reflected light on receivers, of those that were judged by the gradient.
    judged: Vec<[Option<Samples>; 2]>,
    pub(crate) bounds: Bounds,
    /// What is needed to prove a bound, and the bound that is proven.
    ground: Ground,
    pub(crate) proven: Proven,
    /// Of each leaf, what is proven to be left out of direct light at most.
    proven_direct: Vec<Option<Vec<Rest>>>,
    pub(crate) channels: Vec<String>,
    pub(crate) extent: f64,
    /// Error that the evaluation of a function may have.
    pub(crate) absolute: f64,
    progress: Progress,
    /// Mean radiosity in each channel.
    mean: Vec<f64>,
}

/// Solves a scene. `watch` sees the solution after each round, and says whether to go on: what was reached is returned.
///
/// ```
/// use radgrad_core::{DVec3, Polygon};
/// use radgrad_scene::Scene;
/// use radgrad_solver::{Options, solve};
/// // Two squares face each other; each reflects half and radiates 1 by itself.
/// let mut scene = Scene::new(["grey"])?;
/// let white = scene.add_material("white", [0.5], [std::f64::consts::FRAC_1_PI])?;
/// let surface = scene.add_surface("squares");
/// let square = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)];
/// let floor = Polygon::new(square.map(|(x, y)| DVec3::new(x, y, 0.0)).to_vec()).unwrap();
/// let ceiling = Polygon::new(square.map(|(x, y)| DVec3::new(y, x, 1.0)).to_vec()).unwrap();
/// scene.add_face(surface, white, floor, None)?;
/// scene.add_face(surface, white, ceiling, None)?;
/// let solution = solve(&scene, &Options::default(), |_| true)?;
/// let centre = solution.gather(DVec3::new(0.5, 0.5, 0.0), DVec3::Z)?;
/// assert!((centre.radiosity[0] - 1.133_303_564_992_420_8).abs() <= centre.ledger[0].total());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// If the error asked for is not in (0, 1], a face cannot be cut into elements, or light is not lost, so that no bound exists.
pub fn solve(scene: &Scene, options: &Options, watch: impl FnMut(&Solution) -> bool) -> Result<Solution, Error> {
    solve_from(scene, options, &[], watch)
}

/// [`solve`] from a mesh that is divided already, as another solution's was ([`Solution::divisions`]): to go on where that one ended.
///
/// ```
/// # use radgrad_scene::{Degenerate, Scene};
/// use radgrad_solver::{Options, solve, solve_from};
/// # let file = concat!(env!("CARGO_MANIFEST_DIR"), "/../../data/scenes/two_blocks.obj");
/// let scene = Scene::read(file, Degenerate::Refuse)?;
/// let options = Options { error: 1.0, degree: Some(0), first_elements: 1, ..Options::default() };
/// let before = solve(&scene, &options, |_| false)?;
/// let after = solve_from(&scene, &options, &before.divisions(), |_| false)?;
/// assert_eq!(before.progress().elements, after.progress().elements);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// As for [`solve`], and if a division is of an element that is not there.
pub fn solve_from(
    scene: &Scene,
    options: &Options,
    divisions: &[usize],
    watch: impl FnMut(&Solution) -> bool,
) -> Result<Solution, Error> {
    if !(options.error > 0.0 && options.error <= 1.0) {
        return Err(Error::Tolerance { value: options.error });
    }
    options.linking.check()?;
    let mut mesh = Mesh::new(scene, options.degree.unwrap_or(DEGREE))?;
    for (index, &element) in divisions.iter().enumerate() {
        let count = mesh.elements().len();
        if element >= count {
            return Err(Error::Division { index, element, count });
        }
        mesh.divide(element)?;
    }
    solve_on(scene, options, mesh, watch)
}

/// The same on a mesh of the scene.
pub(crate) fn solve_on(
    scene: &Scene,
    options: &Options,
    mut mesh: Mesh,
    mut watch: impl FnMut(&Solution) -> bool,
) -> Result<Solution, Error> {
    options.linking.divide(&mut mesh, options.most_elements)?;
    while !mesh.roots().is_empty() && mesh.leaves().count() < options.first_elements {
        let leaves: Vec<usize> = mesh.leaves().collect();
        leaves.into_iter().try_for_each(|leaf| mesh.divide(leaf))?;
    }
    let channels = scene.channels().to_vec();
    let surfaces = Surfaces::of(scene);
    let (low, high) = scene.bounds().unwrap_or((DVec3::ZERO, DVec3::ZERO));
    let progress = Progress { round: 0, elements: 0, links: 0, gathers: 0, bound: f64::INFINITY, estimate: f64::INFINITY };
    let receivers: Vec<usize> = mesh.leaves().collect();
    let lamps = Lamps::of(&mesh, &surfaces);
    let precision = if may_be_even(&mesh, &lamps) { GLOWING_PART } else { EVALUATION_PART };
    let mut solution = Solution {
        rules: Rules::new(),
        direct: Vec::new(),
        field: Field::dark(&mesh, channels.len()),
        own: Vec::new(),
        links: Vec::new(),
        far: Vec::new(),
        receivers,
        judged: Vec::new(),
        bounds: Bounds::default(),
        ground: Ground::of(&mesh),
        proven: Proven::default(),
        proven_direct: Vec::new(),
        extent: (high - low).max_element(),
        absolute: (options.error * precision).max(FINEST),
        mean: vec![0.0; channels.len()],
        lamps,
        mesh,
        surfaces,
        channels,
        progress,
    };
    let start = Instant::now();
    let mut before = Duration::ZERO;
    loop {
        let began = start.elapsed();
        solution.round(options)?;
        let go_on = watch(&solution);
        let took = start.elapsed().saturating_sub(began);
        let once = options.linking != Linking::Error;
        let enough = once || solution.reached(options) || solution.mesh.elements().len() >= options.most_elements;
        if enough || !go_on || options.time.is_some_and(|time| start.elapsed() + expected(took, before) > time) {
            return Ok(solution);
        }
        before = took;
        solution.divide(options)?;
    }
}

impl Solution {
    /// One round: direct light, links, sweeps, finer links, bounds.
    fn round(&mut self, options: &Options) -> Result<(), Error> {
        // What a round cannot reach anyway is not paid for, if there may be another one.
        let is_last = self.mesh.elements().len() >= options.most_elements;
        let aim = match options.linking {
            Linking::Error if !is_last => options.error.max(0.3 * self.progress.estimate.min(1.0)),
            _ => options.error,
        };
        self.light(aim, options)?;
        self.link(LINK_PART * aim, options.linking)?;
        if self.progress.round == 0 && self.mesh.clusters().root().is_some() {
            self.fill_evenly();
        } else {
            self.sweep(options.order, 1e-2 * aim);
        }
        for _ in 0..8 {
            let changed = options.linking == Linking::Error && self.refine(LINK_PART * aim)?;
            self.sweep(options.order, 1e-2 * aim);
            if !changed {
                break;
            }
        }
        if options.linking == Linking::Error {
            self.merge(LINK_PART * aim);
        }
        self.sweep(options.order, if may_be_even(&self.mesh, &self.lamps) { SOLVED } else { ROUGHLY_SOLVED * aim });
        let bounds = Bounds::of(self.bounded(), [self.left_of_direct(), self.left_of_reflected()]);
        self.bounds = bounds.ok_or_else(|| self.lossless())?;
        let links = self.receivers.iter().map(|&receiver| self.links[receiver].len() + self.far[receiver].len()).sum();
        let estimate = self.mean_estimate().iter().zip(&self.mean).map(|(w, mean)| ratio(w.total(), *mean)).fold(0.0, f64::max);
        self.prove()?;
        let bound = self.mean_bound().iter().zip(&self.mean).map(|(w, mean)| ratio(w.total(), *mean)).fold(0.0, f64::max);
        let (round, gathers) = (self.progress.round + 1, self.progress.gathers);
        self.progress = Progress { round, elements: self.mesh.leaves().count(), links, gathers, bound, estimate };
        Ok(())
    }

    /// Whether what was asked for is reached.
    pub(crate) fn reached(&self, options: &Options) -> bool {
        match options.bound {
            Some(bound) => self.progress.bound <= bound,
            None => self.progress.estimate <= options.error,
        }
    }

    /// Proves the bound.
    fn prove(&mut self) -> Result<(), Error> {
        self.prove_direct();
        let leaves = self.mesh.leaves().filter(|_| !self.direct.is_empty());
        let direct = leaves.filter_map(|leaf| self.proven_direct[leaf].clone()).collect();
        let solved = Solved {
            mesh: &self.mesh,
            surfaces: &self.surfaces,
            lamps: &self.lamps,
            field: &self.field,
            links: &self.links,
            far: &self.far,
            receivers: &self.receivers,
            channels: self.channels.len(),
            residuals: &self.bounds.residuals,
        };
        self.proven = Proven::of(solved, &self.ground, direct).ok_or_else(|| self.lossless())?;
        Ok(())
    }

    /// Bounds what is left out of direct light on leaves of which it is not known.
    fn prove_direct(&mut self) {
        self.proven_direct.resize(self.mesh.elements().len(), None);
        if self.direct.is_empty() {
            return;
        }
        let new: Vec<usize> = self.mesh.leaves().filter(|&leaf| self.proven_direct[leaf].is_none()).collect();
        let of = |&leaf: &usize| self.ground.left_of_direct(&self.mesh, &self.surfaces, &self.lamps, &self.direct[leaf], leaf);
        let left: Vec<Vec<Rest>> = new.par_iter().map(of).collect();
        new.into_iter().zip(left).for_each(|(leaf, left)| self.proven_direct[leaf] = Some(left));
    }

    /// What bounds are made of.
    pub(crate) fn bounded(&self) -> bound::Scene<'_> {
        let Self { mesh, surfaces, receivers, links, far, channels, .. } = self;
        bound::Scene { mesh, surfaces, receivers, links, far, channels: channels.len() }
    }

    /// Bounds at points, which cost as much as that on the mean, and only who asks for them pays.
    pub(crate) fn points(&self) -> &Points {
        self.bounds.points(self.bounded())
    }

    pub(crate) const fn optics(&self) -> Optics<'_> {
        Optics { mesh: &self.mesh, rules: &self.rules, absolute: self.absolute }
    }

    fn lossless(&self) -> Error {
        let faces = self.surfaces.reflectance.iter().enumerate();
        let all = faces.flat_map(|(face, rho)| rho.iter().enumerate().map(move |(channel, rho)| (face, channel, *rho)));
        let (face, channel, _) = all.max_by(|a, b| a.2.total_cmp(&b.2)).unwrap_or((0, 0, 1.0));
        Error::Lossless { channel: self.channels[channel].clone(), face }
    }

    /// Whether an element gathers reflected light, though it may see nothing.
    fn gathers(&self, element: usize) -> bool {
        !self.own[element].is_empty()
    }

    /// The element above a leaf, or itself, that gathers reflected light.
    pub(crate) fn receiver_of(&self, leaf: usize) -> usize {
        let mut at = leaf;
        while !self.gathers(at)
            && let Some(parent) = self.mesh.elements()[at].parent()
        {
            at = parent;
        }
        at
    }

    /// Projects direct light on new leaves, and divides leaves until what that leaves out is small.
    fn light(&mut self, aim: f64, options: &Options) -> Result<(), Error> {
        let channels = self.channels.len();
        loop {
            let known = self.direct.len();
            let new: Vec<usize> = (known..self.mesh.elements().len()).collect();
            if !self.lamps.is_empty() {
                let optics = self.optics();
                let above = |element: usize| self.mesh.elements()[element].parent().and_then(|p| self.direct.get(p));
                let of = |element: usize| self.lamps.light(&optics, &self.surfaces, element, above(element));
                let direct = for_each(&new, of)?;
                self.direct.extend(direct);
            }
            self.field.grow(&self.mesh);
            self.surfaces.grow(&self.mesh);
            for element in new {
                if self.direct.is_empty() || !self.mesh.elements()[element].is_leaf() {
                    continue;
                }
                for channel in 0..channels {
                    let mut change = self.projected(element, channel);
                    if let Some(parent) = self.mesh.elements()[element].parent().filter(|_| known > 0) {
                        let basis = self.mesh.basis(element);
                        let held = basis.restrict(self.mesh.child(element), &self.projected(parent, channel));
                        change.iter_mut().zip(held).for_each(|(c, h)| *c -= h);
                    }
                    self.field.add(&self.mesh, element, channel, &change);
                }
            }
            let apart = !options.uniform && options.marking == Marking::Residual && options.linking == Linking::Error;
            if self.direct.is_empty() || !apart || self.mesh.elements().len() >= options.most_elements {
                return Ok(());
            }
            // Relative to what light there is so far.
            let mean: Vec<f64> = (0..channels).map(|channel| self.field.mean(&self.mesh, channel)).collect();
            let leaves: Vec<usize> = self.mesh.leaves().collect();
            let area: f64 = leaves.iter().map(|&leaf| self.mesh.elements()[leaf].area()).sum();
            let indicator = |&leaf: &usize| {
                let of = |channel: usize| ratio(self.counts(leaf, &self.left_on_leaf(leaf, channel)), mean[channel]);
                (self.mesh.elements()[leaf].area() / area * (0..channels).map(of).fold(0.0, f64::max), leaf)
            };
            let marked: Vec<(f64, usize)> = leaves.iter().map(indicator).collect();
            if marked.iter().map(|m| m.0).sum::<f64>() <= DIRECT_PART * aim {
                return Ok(());
            }
            for leaf in bulk(marked, BULK) {
                self.mesh.divide(leaf)?;
            }
        }
    }

    /// What of a residual becomes less as elements do: the detail of a texture stays, but gathers of it fall off with the power of
    /// their size that the kernel's Taylor polynomial leaves.
    fn counts(&self, element: usize, residual: &Residual) -> f64 {
        if residual.mean_detail() == 0.0 {
            return residual.mean();
        }
        let size = (self.mesh.elements()[element].radius() / self.extent).min(1.0);
        let fades: f64 = std::iter::repeat_n(size, self.mesh.basis(element).degree() + 1).product();
        residual.mean() + residual.mean_detail() * fades
    }

    /// The projection of direct light on an element, as it is reflected.
    fn projected(&self, element: usize, channel: usize) -> Vec<f64> {
        let basis = self.mesh.basis(element);
        match self.surfaces.pattern(element, channel) {
            None => basis.project(&self.direct_samples(element, channel)),
            Some(pattern) => pattern.reflected(&self.direct_irradiance(element, channel)),
        }
    }

    /// The projection of the irradiance of lamps on an element.
    fn direct_irradiance(&self, element: usize, channel: usize) -> Vec<f64> {
        let at_nodes: Vec<f64> = self.direct[element].nodes.iter().map(|lit| lit.irradiance[channel]).collect();
        self.mesh.basis(element).project(&at_nodes)
    }

    /// Irradiance of lamps at the nodes times the face's reflectance, the largest where it has a texture.
    fn direct_samples(&self, element: usize, channel: usize) -> Vec<f64> {
        let rho = self.surfaces.reflectance[self.mesh.elements()[element].face()][channel];
        self.direct[element].nodes.iter().map(|lit| rho * lit.irradiance[channel]).collect()
    }

    fn left_on_leaf(&self, leaf: usize, channel: usize) -> Residual {
        let (element, basis) = (&self.mesh.elements()[leaf], self.mesh.basis(leaf));
        let rho = self.surfaces.reflectance[element.face()][channel];
        let mut residual = Residual::of(element, basis, &self.direct_samples(leaf, channel));
        if let Some(pattern) = self.surfaces.pattern(leaf, channel) {
            let detail = pattern.detail(basis, &self.direct_irradiance(leaf, channel), false);
            residual = residual.textured(element, pattern, rho, detail);
        }
        for lit in &self.direct[leaf].nodes {
            let [clear, past] = lit.error[channel];
            residual.largest.computation = residual.largest.computation.max(rho * clear);
            residual.largest.visibility = residual.largest.visibility.max(rho * past);
        }
        residual
    }

    /// What the projection of direct light leaves out, everywhere.
    fn left_of_direct(&self) -> Residuals {
        let channels = self.channels.len();
        if self.direct.is_empty() {
            return vec![vec![Residual::default(); channels]; self.mesh.elements().len()];
        }
        let leaves: Vec<usize> = self.mesh.leaves().collect();
        let of = |&leaf: &usize| (0..channels).map(|channel| self.left_on_leaf(leaf, channel)).collect();
        let at = leaves.par_iter().map(of).collect();
        Residual::everywhere(&self.mesh, &leaves, at, channels)
    }

    /// What receivers leave out of the reflected light, everywhere.
    fn left_of_reflected(&self) -> Residuals {
        let channels = self.channels.len();
        let of = |&receiver: &usize| (0..channels).map(|channel| self.left_on_receiver(receiver, channel)).collect();
        let at = self.receivers.par_iter().map(of).collect();
        Residual::everywhere(&self.mesh, &self.receivers, at, channels)
    }

    fn left_on_receiver(&self, receiver: usize, channel: usize) -> Residual {
        let (element, basis, links) = (&self.mesh.elements()[receiver], self.mesh.basis(receiver), &self.links[receiver]);
        let (rho, emitted) = (self.surfaces.reflectance[element.face()][channel], self.surfaces.emitted[element.face()][channel]);
        let emitted = if self.is_lamp(element.face()) { 0.0 } else { emitted };
        let far = &self.far[receiver];
        let at_nodes = irradiance(&self.mesh, &self.field, links, far, channel, basis.nodes().len());
        let samples: Vec<f64> = at_nodes.iter().map(|h| rho * h).collect();
        let mut residual = Residual::of(element, basis, &samples);

        let held = &self.own[receiver][channel * basis.len()..(channel + 1) * basis.len()];
        let mut left = match self.surfaces.pattern(receiver, channel) {
            None => basis.project(&samples),
            Some(pattern) => {
                let projected = basis.project(&at_nodes);
                residual = residual.textured(element, pattern, rho, pattern.detail(basis, &projected, true));
                pattern.reflected(&projected)
            }
        };
        left.iter_mut().zip(held).for_each(|(p, b)| *p -= b);
        left.iter_mut().zip(self.emitted_on(receiver, channel)).for_each(|(p, e)| *p += e);
        residual.largest.solver = basis.magnitude(&left);
        for (node, sample) in samples.iter().enumerate() {
            let mut neglected = far.neglected(&self.field, channel, node);
            let (mut clear, mut past) = (0.0, 0.0);
            for link in links {
                let row = &link.rows[node];
                neglected += self.field.neglected(&self.mesh, link.source, channel, row);
                let size = row.error_of(self.field.of(link.source, channel, self.mesh.basis(link.source).len()));
                if matches!(link.sight, Sight::Past(_)) { past += size } else { clear += size }
            }
            // The sums themselves round.
            let summed = 2.0 * f64::EPSILON * (links.len() + 2) as f64 * (sample.abs() + emitted);
            let largest = &mut residual.largest;
            largest.computation = largest.computation.max(rho * (neglected + clear) + summed);
            largest.visibility = largest.visibility.max(rho * past);
        }
        residual
    }

    /// Coefficients of what an element emits that is no lamp kept apart.
    pub(crate) fn emitted_on(&self, element: usize, channel: usize) -> Vec<f64> {
        let (len, face) = (self.mesh.basis(element).len(), self.mesh.elements()[element].face());
        match self.surfaces.pattern(element, channel) {
            Some(pattern) if self.surfaces.glows_by_texture(face) => pattern.emitted().to_vec(),
            _ => {
                let mut even = vec![0.0; len];
                even[0] = if self.is_lamp(face) { 0.0 } else { self.surfaces.emitted[face][channel] };
                even
            }
        }
    }

    /// Whether what a face emits is a lamp's, kept apart.
    fn is_lamp(&self, face: usize) -> bool {
        !self.lamps.is_empty() && !self.surfaces.glows_by_texture(face)
    }

    /// What a face emits as a lamp kept apart.
    fn lamp_on(&self, face: usize, channel: usize) -> f64 {
        if self.is_lamp(face) { self.surfaces.emitted[face][channel] } else { 0.0 }
    }

    /// Links receivers that have none, to what their parent's links had for sources; these go.
    fn link(&mut self, allowed: f64, linking: Linking) -> Result<(), Error> {
        self.links.resize(self.mesh.elements().len(), Vec::new());
        self.far.resize(self.mesh.elements().len(), Far::default());
        self.own.resize(self.mesh.elements().len(), Vec::new());
        let new: Vec<usize> = self.receivers.iter().copied().filter(|&receiver| !self.gathers(receiver)).collect();
        let optics = self.optics();
        let of_parent = |element: usize| {
            let parent = self.mesh.elements()[element].parent().filter(|&parent| self.gathers(parent))?;
            Some((&self.links[parent][..], &self.far[parent]))
        };
        let of = |receiver: usize| {
            let need = Need { field: &self.field, weight: &self.weight(receiver), allowed, linking };
            optics.first_links(receiver, of_parent(receiver), &need)
        };
        let links = for_each(&new, of)?;
        for (&receiver, (links, far)) in new.iter().zip(links) {
            (self.links[receiver], self.far[receiver]) = (links, far);
            let basis = self.mesh.basis(receiver);
            let len = basis.len();
            let restricted = |channel: usize| match self.mesh.elements()[receiver].parent().map(|p| &self.own[p]) {
                Some(own) if !own.is_empty() => {
                    basis.restrict(self.mesh.child(receiver), &own[channel * len..(channel + 1) * len])
                }
                _ => vec![0.0; len],
            };
            self.own[receiver] = (0..self.channels.len()).flat_map(restricted).collect();
        }
        let mut receives = vec![false; self.links.len()];
        self.receivers.iter().for_each(|&receiver| receives[receiver] = true);
        for index in (0..self.links.len()).filter(|&index| !receives[index]) {
            (self.links[index], self.far[index]) = (Vec::new(), Far::default());
            self.own[index] = Vec::new();
        }
        Ok(())
    }

    /// What an error of the irradiance counts for, relative to the mean.
    fn weight(&self, receiver: usize) -> Vec<f64> {
        let rho = &self.surfaces.reflectance[self.mesh.elements()[receiver].face()];
        rho.iter().zip(&self.mean).map(|(rho, mean)| if *mean > 0.0 { rho / mean } else { 0.0 }).collect()
    }

    /// Puts clusters of receivers together again where they need not be told apart.
    fn merge(&mut self, allowed: f64) {
        let (optics, linking) = (self.optics(), Linking::Error);
        let merged = |&receiver: &usize| {
            let need = Need { field: &self.field, weight: &self.weight(receiver), allowed, linking };
            optics.merge(receiver, &self.links[receiver], &self.far[receiver], &need)
        };
        let merged: Vec<Far> = self.receivers.par_iter().map(merged).collect();
        self.receivers.iter().zip(merged).for_each(|(&receiver, far)| self.far[receiver] = far);
    }

    fn refine(&mut self, allowed: f64) -> Result<bool, Error> {
        let (links, far) = (&mut self.links, &mut self.far);
        let take = |&receiver: &usize| (std::mem::take(&mut links[receiver]), std::mem::take(&mut far[receiver]));
        let taken: Vec<(Vec<Link>, Far)> = self.receivers.iter().map(take).collect();
        let (optics, linking) = (self.optics(), Linking::Error);
        let refined: Vec<(Vec<Link>, Far, bool)> = self
            .receivers
            .par_iter()
            .zip(taken)
            .map(|(&receiver, (mut links, mut far))| {
                let need = Need { field: &self.field, weight: &self.weight(receiver), allowed, linking };
                let changed = optics.refine(receiver, (&mut links, &mut far), &need)?;
                Ok((links, far, changed))
            })
            .collect::<Result<_, Error>>()?;
        let mut any = false;
        for (&receiver, (links, far, changed)) in self.receivers.iter().zip(refined) {
            any |= changed;
            (self.links[receiver], self.far[receiver]) = (links, far);
        }
        Ok(any)
    }
}

/// Whether light may be far more even than was asked for: where there are no lamps and no clusters.
fn may_be_even(mesh: &Mesh, lamps: &Lamps) -> bool {
    lamps.is_empty() && mesh.clusters().root().is_none()
}

/// The time of a round after one that took so long, and one before that.
fn expected(last: Duration, before: Duration) -> Duration {
    let growth = if before.is_zero() { MOST_GROWTH } else { (last.as_secs_f64() / before.as_secs_f64()).clamp(1.0, MOST_GROWTH) };
    last.mul_f64(growth)
}

fn ratio(part: f64, whole: f64) -> f64 {
    if part == 0.0 { 0.0 } else { part / whole }
}
