//! The solution of a scene to an error: solve, bound, divide where the bound says that it pays, and again.
//!
//! Each round links the new leaves, sweeps until the linear system is solved, refines links, and bounds the error. If the mean
//! of the bound over all area is not within the error asked for, relative to the mean radiosity, the leaves with the largest
//! residual times area are divided: those that together make up half of it (W. Dörfler 1996).

use radgrad_core::DVec3;
use radgrad_scene::Scene;
use rayon::prelude::*;

use crate::Error;
use crate::bound::Bounds;
use crate::field::Field;
use crate::gathering;
use crate::ledger::Ledger;
use crate::link::{Link, for_leaves};
use crate::mesh::Mesh;
use crate::residual::Residual;
use crate::surfaces::Surfaces;
use crate::transfer::{FarRules, Optics};

/// What is asked for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Options {
    /// Mean of the bound on the error of gathers over the mean radiosity, at most, in every channel.
    pub error: f64,
    /// Degree of the basis, 0 to 3. If none is given, 2 where nothing hides anything and 1 in scenes with shadows, whose edges
    /// higher degrees do not follow.
    pub degree: Option<usize>,
    /// All faces are divided alike until there are this many elements; then the first round begins.
    pub first_elements: usize,
    /// Elements, divided ones too, beyond which nothing is divided any more: the bound then says what was reached.
    pub most_elements: usize,
    /// Divide everything rather than what pays.
    pub uniform: bool,
}

impl Default for Options {
    fn default() -> Self {
        Self { error: 0.005, degree: None, first_elements: 32, most_elements: 5000, uniform: false }
    }
}

/// How far a solution has come.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Progress {
    /// Round, from 1.
    pub round: usize,
    /// Leaves.
    pub elements: usize,
    /// Links.
    pub links: usize,
    /// Mean of the bound over the mean radiosity, the largest of the channels.
    pub bound: f64,
}

/// The part of the error asked for that links may neglect.
const LINK_PART: f64 = 0.15;

/// The part of the error asked for that one evaluation may have, per unit of the source's radiosity.
const EVALUATION_PART: f64 = 1e-5;

/// The part of the sum of all residuals times area whose elements are divided in a round.
const BULK: f64 = 0.5;

/// Changes relative to the mean radiosity below which the linear system is solved.
const SOLVED: f64 = 1e-13;

const MOST_SWEEPS: usize = 1000;

/// A piecewise polynomial radiosity with a bound on its error.
#[derive(Debug)]
pub struct Solution {
    pub(crate) mesh: Mesh,
    pub(crate) surfaces: Surfaces,
    pub(crate) far: FarRules,
    pub(crate) field: Field,
    pub(crate) links: Vec<Vec<Link>>,
    pub(crate) bounds: Bounds,
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
pub fn solve(scene: &Scene, options: &Options, mut watch: impl FnMut(&Solution) -> bool) -> Result<Solution, Error> {
    if !(options.error > 0.0 && options.error <= 1.0) {
        return Err(Error::Tolerance { value: options.error });
    }
    let degree = match options.degree {
        Some(degree) => degree,
        None if Mesh::new(scene, 0)?.has_shadows() => 1,
        None => 2,
    };
    let mut mesh = Mesh::new(scene, degree)?;
    while !mesh.roots().is_empty() && mesh.leaves().count() < options.first_elements {
        let leaves: Vec<usize> = mesh.leaves().collect();
        leaves.into_iter().try_for_each(|leaf| mesh.divide(leaf))?;
    }
    let channels = scene.channels().to_vec();
    let (low, high) = scene.bounds().unwrap_or((DVec3::ZERO, DVec3::ZERO));
    let progress = Progress { round: 0, elements: 0, links: 0, bound: f64::INFINITY };
    let mut solution = Solution {
        far: FarRules::new(degree),
        field: Field::new(channels.len()),
        links: Vec::new(),
        bounds: Bounds::default(),
        extent: (high - low).max_element(),
        absolute: EVALUATION_PART * options.error,
        mean: vec![0.0; channels.len()],
        mesh,
        surfaces: Surfaces::of(scene),
        channels,
        progress,
    };
    loop {
        solution.round(options)?;
        let go_on = watch(&solution);
        let enough = solution.progress.bound <= options.error || solution.mesh.elements().len() >= options.most_elements;
        if enough || !go_on {
            return Ok(solution);
        }
        solution.divide(options)?;
    }
}

impl Solution {
    /// One round: link, sweep, refine links, bound.
    fn round(&mut self, options: &Options) -> Result<(), Error> {
        let leaves: Vec<usize> = self.mesh.leaves().collect();
        self.link(&leaves)?;
        self.field.grow(&self.mesh);
        self.surfaces.grow(&self.mesh);
        // What a round cannot reach anyway is not paid for.
        let aim = options.error.max(0.5 * self.progress.bound.min(1.0));
        self.sweep(&leaves, 1e-2 * aim);
        for _ in 0..8 {
            let changed = self.refine(&leaves, LINK_PART * aim)?;
            self.sweep(&leaves, 1e-2 * aim);
            if !changed {
                break;
            }
        }
        self.sweep(&leaves, SOLVED);
        let bounds = Bounds::of(&self.mesh, &self.surfaces, &leaves, &self.links, &self.field);
        self.bounds = bounds.ok_or_else(|| self.lossless())?;
        let links = leaves.iter().map(|&leaf| self.links[leaf].len()).sum();
        let bound = self.mean_bound().iter().zip(&self.mean).map(|(w, mean)| ratio(w.total(), *mean)).fold(0.0, f64::max);
        self.progress = Progress { round: self.progress.round + 1, elements: leaves.len(), links, bound };
        Ok(())
    }

    pub(crate) const fn optics(&self) -> Optics<'_> {
        Optics { mesh: &self.mesh, far: &self.far, absolute: self.absolute }
    }

    fn lossless(&self) -> Error {
        let faces = self.surfaces.reflectance.iter().enumerate();
        let all = faces.flat_map(|(face, rho)| rho.iter().enumerate().map(move |(channel, rho)| (face, channel, *rho)));
        let (face, channel, _) = all.max_by(|a, b| a.2.total_cmp(&b.2)).unwrap_or((0, 0, 1.0));
        Error::Lossless { channel: self.channels[channel].clone(), face }
    }

    fn link(&mut self, leaves: &[usize]) -> Result<(), Error> {
        self.links.resize(self.mesh.elements().len(), Vec::new());
        let new: Vec<usize> = leaves.iter().copied().filter(|&leaf| self.links[leaf].is_empty()).collect();
        let optics = self.optics();
        let of_parent = |leaf: usize| self.mesh.elements()[leaf].parent().map(|p| &self.links[p][..]).filter(|l| !l.is_empty());
        let links = for_leaves(&new, |leaf| optics.first_links(leaf, of_parent(leaf)))?;
        for (leaf, links) in new.into_iter().zip(links) {
            self.links[leaf] = links;
        }
        for index in 0..self.links.len() {
            if !self.mesh.elements()[index].is_leaf() {
                self.links[index] = Vec::new();
            }
        }
        Ok(())
    }

    fn sweep(&mut self, leaves: &[usize], until: f64) {
        self.field.pull(&self.mesh);
        for _ in 0..MOST_SWEEPS {
            let scale: Vec<f64> = self.mean.iter().map(|&mean| if mean > 0.0 { mean } else { 1.0 }).collect();
            let change = gathering::sweep(&self.mesh, &self.surfaces, leaves, &self.links, &mut self.field, &scale);
            self.mean = (0..self.channels.len()).map(|channel| self.field.mean(&self.mesh, channel)).collect();
            if change <= until {
                break;
            }
        }
        self.field.pull(&self.mesh);
    }

    fn refine(&mut self, leaves: &[usize], allowed: f64) -> Result<bool, Error> {
        let taken: Vec<Vec<Link>> = leaves.iter().map(|&leaf| std::mem::take(&mut self.links[leaf])).collect();
        let optics = self.optics();
        let (field, surfaces, mean) = (&self.field, &self.surfaces, &self.mean);
        let refined: Vec<(Vec<Link>, bool)> = leaves
            .par_iter()
            .zip(taken)
            .map(|(&leaf, mut links)| {
                let rho = &surfaces.reflectance[self.mesh.elements()[leaf].face()];
                let of = |(rho, mean): (&f64, &f64)| if *mean > 0.0 { rho / mean } else { 0.0 };
                let weight: Vec<f64> = rho.iter().zip(mean).map(of).collect();
                let changed = optics.refine(leaf, &mut links, field, &weight, allowed)?;
                Ok((links, changed))
            })
            .collect::<Result<_, Error>>()?;
        let mut any = false;
        for (&leaf, (links, changed)) in leaves.iter().zip(refined) {
            any |= changed;
            self.links[leaf] = links;
        }
        Ok(any)
    }

    fn divide(&mut self, options: &Options) -> Result<(), Error> {
        let leaves: Vec<usize> = self.mesh.leaves().collect();
        let indicator = |leaf: usize| {
            // A texture's detail stays when leaves become smaller; what it does elsewhere becomes less as they do.
            let fades = (self.mesh.elements()[leaf].radius() / self.extent).min(1.0);
            let counts = |r: &Residual| r.mean - r.texture.mean * (1.0 - fades);
            let relative = self.bounds.residual[leaf].iter().zip(&self.mean).map(|(r, mean)| ratio(counts(r), *mean));
            self.mesh.elements()[leaf].area() * relative.fold(0.0, f64::max)
        };
        let mut marked: Vec<(f64, usize)> = leaves.iter().map(|&leaf| (indicator(leaf), leaf)).collect();
        marked.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
        let all: f64 = marked.iter().map(|m| m.0).sum();
        let mut taken = 0.0;
        for (share, leaf) in marked {
            if !options.uniform && taken >= BULK * all {
                break;
            }
            taken += share;
            self.mesh.divide(leaf)?;
        }
        Ok(())
    }

    /// The mesh.
    #[must_use]
    pub const fn mesh(&self) -> &Mesh {
        &self.mesh
    }

    /// Names of the channels.
    #[must_use]
    pub fn channels(&self) -> &[String] {
        &self.channels
    }

    /// How far it came.
    #[must_use]
    pub const fn progress(&self) -> &Progress {
        &self.progress
    }

    /// Mean radiosity over all area, in each channel.
    #[must_use]
    pub fn mean(&self) -> &[f64] {
        &self.mean
    }

    /// Mean of the bound on the error of gathers over all area, in each channel.
    #[must_use]
    pub fn mean_bound(&self) -> Vec<Ledger> {
        let of_channel = |channel: usize| {
            let of_root = |&root: &usize| (self.mesh.elements()[root].area(), self.bounds.mean[root][channel]);
            let sum = |(area, w): (f64, Ledger), (a, v): (f64, Ledger)| (area + a, w + v * a);
            let (area, w) = self.mesh.roots().iter().map(of_root).fold((0.0, Ledger::default()), sum);
            w * (1.0 / area)
        };
        (0..self.channels.len()).map(of_channel).collect()
    }

    /// Bound on the error of the polynomial on a leaf, at every point of it, in each channel; the detail of textures, which no
    /// polynomial has, is in it.
    #[must_use]
    pub fn bound_on(&self, leaf: usize) -> Vec<Ledger> {
        let (w, v, r) = (&self.bounds.largest[leaf], &self.bounds.variation[leaf], &self.bounds.residual[leaf]);
        (0..w.len()).map(|c| w[c] + v[c] + r[c].largest).collect()
    }

    /// Value of the polynomial on a leaf, in a channel.
    #[must_use]
    pub fn value_on(&self, leaf: usize, channel: usize, reference: [f64; 2]) -> f64 {
        let basis = self.mesh.basis(leaf);
        self.field.of(leaf, channel, basis.len()).iter().zip(basis.values(reference)).map(|(c, v)| c * v).sum()
    }

    /// Irradiance on a leaf as a polynomial, in a channel: its coefficients in the leaf's basis.
    #[must_use]
    pub fn irradiance_on(&self, leaf: usize, channel: usize) -> Vec<f64> {
        let basis = self.mesh.basis(leaf);
        basis.project(&gathering::irradiance(&self.mesh, &self.field, &self.links[leaf], channel, basis.nodes().len()))
    }

    /// `E + rho H` at a point of a leaf with the irradiance as a polynomial, in a channel, where [`Self::value_on`] has the
    /// projection of the whole: the detail of textures is in it.
    /// `irradiance` is that of [`Self::irradiance_on`].
    #[must_use]
    pub fn textured_on(&self, leaf: usize, channel: usize, irradiance: &[f64], reference: [f64; 2]) -> f64 {
        let (basis, element) = (self.mesh.basis(leaf), &self.mesh.elements()[leaf]);
        let [rho, emitted] = self.surfaces.at(element.face(), element.point(reference));
        let received: f64 = irradiance.iter().zip(basis.values(reference)).map(|(c, v)| c * v).sum();
        emitted[channel] + rho[channel] * received
    }

    /// Bound on the error of [`Self::textured_on`], at every point of a leaf, in each channel.
    #[must_use]
    pub fn textured_bound_on(&self, leaf: usize) -> Vec<Ledger> {
        let without =
            |(bound, r): (Ledger, &Residual)| Ledger { discretisation: bound.discretisation - r.texture.largest, ..bound };
        self.bound_on(leaf).into_iter().zip(&self.bounds.residual[leaf]).map(without).collect()
    }

    /// Gradient of the polynomial on a leaf over the leaf's plane, in a channel.
    #[must_use]
    pub fn gradient_on(&self, leaf: usize, channel: usize, reference: [f64; 2]) -> DVec3 {
        let basis = self.mesh.basis(leaf);
        let coefficients = self.field.of(leaf, channel, basis.len());
        let slopes = basis.slopes(reference);
        let along = |k: usize| coefficients.iter().zip(&slopes).map(|(c, s)| c * s[k]).sum::<f64>();
        self.mesh.elements()[leaf].gradient([along(0), along(1)])
    }
}

fn ratio(part: f64, whole: f64) -> f64 {
    if part == 0.0 { 0.0 } else { part / whole }
}
