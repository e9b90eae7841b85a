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
use crate::gathering::{self, Surfaces};
use crate::ledger::Ledger;
use crate::link::{Link, for_leaves};
use crate::marking::{self, Marking};
use crate::mesh::Mesh;
use crate::transfer::{FarRules, Optics};

/// What is asked for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Options {
    /// Mean of the bound on the error of gathers over the mean radiosity, at most, in every channel.
    pub error: f64,
    /// Degree of the basis, 0 to 4. If none is given, 2 where nothing hides anything and 1 in scenes with shadows, whose edges
    /// higher degrees do not follow.
    pub degree: Option<usize>,
    /// All faces are divided alike until there are this many elements; then the first round begins.
    pub first_elements: usize,
    /// Elements, divided ones too, beyond which nothing is divided any more: the bound then says what was reached.
    pub most_elements: usize,
    /// Divide everything rather than what pays.
    pub uniform: bool,
    /// What pays: where the residual is large, or where the gradient says so too.
    pub marking: Marking,
}

impl Default for Options {
    fn default() -> Self {
        Self { error: 0.005, degree: None, first_elements: 32, most_elements: 5000, uniform: false, marking: Marking::Residual }
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
pub fn solve(scene: &Scene, options: &Options, watch: impl FnMut(&Solution) -> bool) -> Result<Solution, Error> {
    solve_from(scene, options, &[], watch)
}

/// [`solve`] from a mesh that is divided already, as another solution's was ([`Mesh::divisions`]): to go on where that one ended.
///
/// ```
/// # use radgrad_scene::{Degenerate, Scene};
/// use radgrad_solver::{Options, solve, solve_from};
/// # let file = concat!(env!("CARGO_MANIFEST_DIR"), "/../../data/scenes/two_blocks.obj");
/// let scene = Scene::read(file, Degenerate::Refuse)?;
/// let options = Options { error: 1.0, degree: Some(0), first_elements: 1, ..Options::default() };
/// let before = solve(&scene, &options, |_| false)?;
/// let after = solve_from(&scene, &options, &before.mesh().divisions(), |_| false)?;
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
    mut watch: impl FnMut(&Solution) -> bool,
) -> Result<Solution, Error> {
    if !(options.error > 0.0 && options.error <= 1.0) {
        return Err(Error::Tolerance { value: options.error });
    }
    let degree = match options.degree {
        Some(degree) => degree,
        None if Mesh::new(scene, 0)?.has_shadows() => 1,
        None => 2,
    };
    let mut mesh = Mesh::new(scene, degree)?;
    for (index, &element) in divisions.iter().enumerate() {
        let count = mesh.elements().len();
        if element >= count {
            return Err(Error::Division { index, element, count });
        }
        mesh.divide(element)?;
    }
    while !mesh.roots().is_empty() && mesh.leaves().count() < options.first_elements {
        let leaves: Vec<usize> = mesh.leaves().collect();
        leaves.into_iter().try_for_each(|leaf| mesh.divide(leaf))?;
    }
    let channels = scene.channels().to_vec();
    let of_face = |value: &dyn Fn(&radgrad_scene::Material, usize) -> f64| {
        let of =
            |face: &radgrad_scene::Face| (0..channels.len()).map(|c| value(&scene.materials()[face.material()], c)).collect();
        scene.faces().iter().map(of).collect::<Vec<Vec<f64>>>()
    };
    let surfaces = Surfaces {
        reflectance: of_face(&|material, c| material.reflectance()[c]),
        emitted: of_face(&|material, c| material.emitted_radiosity(c).unwrap_or(0.0)),
    };
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
        surfaces,
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
            let relative = self.bounds.residual[leaf].iter().zip(&self.mean).map(|(r, mean)| ratio(r.mean, *mean));
            let residual = relative.fold(0.0, f64::max);
            let off = match options.marking {
                Marking::Residual => residual,
                Marking::Gradient => residual + marking::BESIDE_RESIDUAL * self.off_by_gradient(leaf)?,
            };
            Ok(self.mesh.elements()[leaf].area() * off)
        };
        let indicators = for_leaves(&leaves, indicator)?;
        let mut marked: Vec<(f64, usize)> = indicators.into_iter().zip(leaves).collect();
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

    /// Bound on the error of the polynomial on a leaf, at every point of it, in each channel.
    #[must_use]
    pub fn bound_on(&self, leaf: usize) -> Vec<Ledger> {
        let (w, v, r) = (&self.bounds.mean[leaf], &self.bounds.variation[leaf], &self.bounds.residual[leaf]);
        (0..w.len()).map(|c| w[c] + v[c] + r[c].largest).collect()
    }

    /// Value of the polynomial on a leaf, in a channel.
    #[must_use]
    pub fn value_on(&self, leaf: usize, channel: usize, reference: [f64; 2]) -> f64 {
        let basis = self.mesh.basis(leaf);
        self.field.of(leaf, channel, basis.len()).iter().zip(basis.values(reference)).map(|(c, v)| c * v).sum()
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
