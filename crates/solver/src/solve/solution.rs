//! The state of a solution: the data that a round works on, and that queries read.

use std::sync::OnceLock;

use radgrad_scene::{Placement, Warning, largest};
use rayon::prelude::*;

use crate::bytes::bytes_of;
use crate::clock::Clock;
use crate::error::Error;
use crate::estimate::ErrorEstimate;
use crate::estimate::ledger::Ledger;
use crate::estimate::point::Points;
use crate::estimate::unsampled::{Edges, Outlined};
use crate::field::Field;
use crate::gathering::ratio;
use crate::links::direct::Direct;
use crate::links::transfer::Optics;
use crate::mesh::Mesh;
use crate::mesh::basis::Basis;
use crate::mesh::element::Element;
use crate::solve::error_samples::ErrorSamples;
use crate::solve::goal_points::GoalPoints;
use crate::solve::next_degree::Detail;
use crate::solve::options::{Options, Progress};
use crate::solve::samples::Samples;
use crate::system::System;

/// A piecewise polynomial radiosity with an estimate of its error.
///
/// ```
/// use radgrad_solver::{Options, solve};
/// # use radgrad_scene::{Degenerate, Scene};
/// # let file = concat!(env!("CARGO_MANIFEST_DIR"), "/../../data/scenes/two_blocks.obj");
/// # let scene = Scene::read(file, Degenerate::Refuse)?;
/// let options = Options { error: 0.5, degree: Some(1), first_elements: 1, ..Options::default() };
/// let solution = solve(&scene, &options, |_| true)?;
/// for (mean, estimate) in solution.mean().iter().zip(solution.mean_estimate()) {
///     println!("{mean:.3} within about {:.3}", estimate.total());
/// }
/// assert!(solution.mean()[0] > 0.0 && solution.progress().estimate <= options.error);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct Solution {
    pub(crate) system: System,
    /// The lines of faces, across which light may be hidden.
    pub(super) edges: Edges,
    pub(crate) radiosity: Radiosity,
    pub(crate) error_estimate: ErrorEstimate,
    pub(super) refinement: Refinement,
    pub(super) budget: Budget,
    pub(super) caches: Caches,
    pub(super) progress: Progress,
    pub(super) placement: Placement,
    pub(super) warnings: Vec<Warning>,
}

/// The solution of the system: polynomials and their means.
#[derive(Debug)]
pub(crate) struct Radiosity {
    /// All light that elements send out, but for the emission of lamps.
    pub(crate) field: Field,
    /// Coefficients of the receivers themselves: light reflected twice or more, and emission where no lamps are kept apart.
    pub(super) own: Vec<Vec<f64>>,
    /// Direct light on each leaf.
    pub(crate) direct: Vec<Direct>,
    /// Of each leaf, bounds on the light of lamps that its nodes do not see, if there may be any.
    pub(super) unseen: Vec<Option<Vec<[f64; 2]>>>,
    /// Mean radiosity in each channel.
    pub(super) mean: Vec<f64>,
    /// The part of it that is reflected.
    pub(super) reflected: Vec<f64>,
    /// Means of the light that faces emit: of lamps kept apart, and of others.
    pub(super) emitted: [Vec<f64>; 2],
}

/// State of the refinement between rounds.
#[derive(Debug)]
pub(super) struct Refinement {
    /// Points that the refinement serves, and their importance.
    pub(super) served: GoalPoints,
    /// Samples of direct light on leaves and reflected light on receivers, of those that were judged by the gradient.
    pub(super) judged: Vec<[Option<Samples>; 2]>,
    /// The aim of [`Solution::light`] that direct light reached: its residual in the mean, over the part of the aim that it may have.
    pub(super) direct_residual: f64,
}

/// The errors and the time that evaluations may take.
#[derive(Debug, Clone, Copy)]
pub(super) struct Budget {
    /// The error asked for, relative to the mean of [`Solution::reference`].
    pub(super) asked: f64,
    /// The most that the links of a receiver may neglect together, relative to the same mean as errors.
    pub(super) allowed: f64,
    /// Error that the evaluation of a function may have.
    pub(super) absolute: f64,
    /// The same past faces that may hide a part: before [`Self::precise`] is over, and after it.
    pub(super) past: [f64; 2],
    /// Cells a side of a source that is seen past many faces; 0 for closed forms.
    pub(super) cells: usize,
    /// Evaluations keep to the first error past faces until this is over.
    pub(super) precise: Clock,
    /// After this is over, evaluations err by more than the error asked for needs.
    pub(super) late: Clock,
    pub(super) clock: Clock,
}

/// Results of queries, made when they are first asked for, and dropped after a round.
#[derive(Debug, Default)]
pub(super) struct Caches {
    /// Estimate of the error of the mean, in each channel.
    pub(super) estimated: OnceLock<Vec<MeanError>>,
    /// The detail beyond the polynomials.
    pub(super) details: OnceLock<Vec<Vec<Detail>>>,
    /// The importance of the mean; `None` if there is none.
    pub(super) importance: OnceLock<Option<Field>>,
    /// The part of the error of gathers whose sign is known; `None` if no part is.
    pub(super) known_error: OnceLock<Option<Field>>,
    /// Samples of the error near points at which gradients were asked for.
    pub(super) kept: ErrorSamples,
}

impl Solution {
    /// Estimates at points, which cost as much as that of the mean magnitude, and only who asks for them pays.
    pub(crate) fn points(&self) -> &Points {
        self.error_estimate.points(&self.system)
    }

    /// The lines of faces on the mesh.
    pub(super) const fn outlined(&self) -> Outlined<'_> {
        Outlined { mesh: &self.system.mesh, edges: &self.edges }
    }

    pub(crate) fn optics(&self) -> Optics<'_> {
        let past = self.budget.past[usize::from(self.budget.precise.is_over())];
        Optics {
            mesh: &self.system.mesh,
            rules: &self.system.rules,
            absolute: self.budget.absolute,
            past,
            cells: self.budget.cells,
            brightness: 1.0,
            clock: self.budget.late,
        }
    }

    /// The reference of errors, in each channel.
    pub(super) fn reference(&self) -> Vec<f64> {
        reference(&self.radiosity.mean, &self.radiosity.reflected)
    }

    pub(crate) fn element(&self, element: usize) -> &Element {
        &self.system.mesh.elements()[element]
    }

    pub(super) fn basis(&self, element: usize) -> &Basis {
        self.system.mesh.basis(element)
    }

    /// Errors in each channel over the mean that they are relative to, the largest.
    pub(super) fn relative(&self, errors: &[Ledger]) -> f64 {
        errors.iter().zip(self.reference()).map(|(error, reference)| ratio(error.total(), reference)).fold(0.0, largest)
    }

    /// Whether the error asked for is reached.
    pub(super) fn reached(&self, options: &Options) -> bool {
        // Where light may be reflected and none was found, nothing is known relative to it.
        let is_found = |(reflected, estimate): (&f64, &Ledger)| *reflected > 0.0 || estimate.total() == 0.0;
        let has_light = self.radiosity.reflected.iter().zip(&self.error_estimate.mean).all(is_found);
        has_light && self.progress.estimate <= options.error
    }

    /// Whether an element gathers reflected light, though it may see nothing.
    pub(super) fn gathers(&self, element: usize) -> bool {
        !self.radiosity.own[element].is_empty()
    }

    /// The element above a leaf, or itself, that gathers reflected light.
    pub(crate) fn receiver_of(&self, leaf: usize) -> usize {
        let mut ancestor = leaf;
        while !self.gathers(ancestor)
            && let Some(parent) = self.element(ancestor).parent()
        {
            ancestor = parent;
        }
        ancestor
    }

    /// Coefficients of an element's emission that is of no lamp kept apart.
    pub(crate) fn emitted_on(&self, element: usize, channel: usize) -> Vec<f64> {
        let face = self.element(element).face();
        match self.system.surfaces.pattern(element, channel) {
            Some(pattern) if self.system.surfaces.glows_by_texture(face) => pattern.emitted().to_vec(),
            _ if self.is_lamp(face) => self.even(element, 0.0),
            _ => self.even(element, self.system.surfaces.emitted[face][channel]),
        }
    }

    /// Coefficients of a constant on an element.
    pub(super) fn even(&self, element: usize, value: f64) -> Vec<f64> {
        let mut coefficients = vec![0.0; self.basis(element).len()];
        coefficients[0] = value;
        coefficients
    }

    /// Whether the emission of a face is a lamp's, kept apart.
    pub(super) fn is_lamp(&self, face: usize) -> bool {
        !self.system.lamps.is_empty() && !self.system.surfaces.glows_by_texture(face)
    }

    /// The emission of a face as a lamp kept apart.
    pub(super) fn lamp_on(&self, face: usize, channel: usize) -> f64 {
        if self.is_lamp(face) { self.system.surfaces.emitted[face][channel] } else { 0.0 }
    }
}

/// Means of a field over all area, with the emission of lamps and without that of any face.
pub(super) fn means(field: &Field, mesh: &Mesh, [lamps, others]: &[Vec<f64>; 2]) -> (Vec<f64>, Vec<f64>) {
    let held = (0..lamps.len()).map(|channel| field.mean(mesh, channel));
    held.zip(lamps.iter().zip(others)).map(|(held, (lamps, others))| (held + lamps, held - others)).unzip()
}

/// The error of the mean radiosity over all area in a channel, as the importance finds it ([`crate::solve::dual`]).
#[derive(Debug, Clone, Copy)]
pub(super) struct MeanError {
    /// Estimate of the remaining error once the correction is added.
    pub(super) estimate: Ledger,
    /// The error as found by the importance, with its sign, and the likely error of that.
    pub(super) correction: f64,
    pub(super) error: f64,
}

impl MeanError {
    /// An error of this size and of unknown sign.
    pub(super) const fn without_sign(estimate: Ledger) -> Self {
        Self { estimate, correction: 0.0, error: estimate.total() }
    }
}

/// The reference of errors of light with these means: the mean of all radiosity where no light that is reflected was found yet.
pub(super) fn reference(mean: &[f64], reflected: &[f64]) -> Vec<f64> {
    let denominator = |(&reflected, &mean): (&f64, &f64)| if reflected > 0.0 { reflected } else { mean };
    reflected.iter().zip(mean).map(denominator).collect()
}

/// Computes something for each element on all cores, in their order.
pub(crate) fn for_each<T: Send>(elements: &[usize], f: impl Fn(usize) -> Result<T, Error> + Sync) -> Result<Vec<T>, Error> {
    elements.par_iter().map(|&element| f(element)).collect()
}

bytes_of!(MeanError { estimate, correction, error });
