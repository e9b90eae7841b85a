//! Queries to a solution: its mesh, its polynomials and estimates of their errors.

use radgrad_core::DVec3;
use radgrad_scene::{Placement, Warning, largest};

use crate::estimate::ledger::Ledger;
use crate::field::Field;
use crate::mesh::Mesh;
use crate::once::made;
use crate::solve::options::Progress;
use crate::solve::solution::{MeanError, Solution};

impl Solution {
    /// The mesh, in the coordinates of [`Self::placement`].
    #[must_use]
    pub const fn mesh(&self) -> &Mesh {
        &self.system.mesh
    }

    /// Names of the channels.
    #[must_use]
    pub fn channels(&self) -> &[String] {
        &self.system.channels
    }

    /// How far it came.
    #[must_use]
    pub const fn progress(&self) -> &Progress {
        &self.progress
    }

    /// Mean radiosity over all area, in each channel.
    #[must_use]
    pub fn mean(&self) -> &[f64] {
        &self.radiosity.mean
    }

    /// The part of the mean radiosity over all area that is reflected, in each channel.
    #[must_use]
    pub fn reflected(&self) -> &[f64] {
        &self.radiosity.reflected
    }

    /// The reference of relative errors, in each channel.
    #[must_use]
    pub fn relative_to(&self) -> Vec<f64> {
        self.reference()
    }

    /// Warnings about properties of the scene that a modeller probably did not mean.
    #[must_use]
    pub fn warnings(&self) -> &[Warning] {
        &self.warnings
    }

    /// How the scene was moved and scaled. The mesh, points and gradients on its elements have the coordinates and the unit of
    /// length of that; an ordinary scene keeps its own.
    #[must_use]
    pub const fn placement(&self) -> &Placement {
        &self.placement
    }

    /// Estimate of the error of [`Self::mean`], in each channel: the correction by a gather of the importance, with its sign, and
    /// its likely error, as a root mean square.
    #[must_use]
    pub fn mean_estimate(&self) -> Vec<Ledger> {
        self.mean_error().iter().map(|error| error.estimate).collect()
    }

    /// Adds to the mean its correction.
    pub(super) fn correct_mean(&mut self) {
        let corrections: Vec<f64> = self.mean_error().iter().map(|error| error.correction).collect();
        for ((mean, reflected), correction) in self.radiosity.mean.iter_mut().zip(&mut self.radiosity.reflected).zip(corrections)
        {
            // No less than the emission.
            let correction = largest(correction, -*reflected);
            (*mean, *reflected) = (*mean + correction, *reflected + correction);
        }
    }

    /// The estimate with its two parts.
    pub(super) fn mean_error(&self) -> &[MeanError] {
        // Where no importance is found the error of gathers is an estimate, too.
        let without_sign = || self.error_estimate.mean.iter().copied().map(MeanError::without_sign).collect();
        made::<Vec<_>>(&self.caches.estimated, || self.estimate_mean().ok().flatten().unwrap_or_else(without_sign))
    }

    /// Estimate of the error of the polynomial on a leaf, the most at any point of it, in each channel; it holds for [`Self::value_on`] and for
    /// [`Self::textured_on`], as the detail of textures, which no polynomial has, is in it.
    #[must_use]
    pub fn estimate_on(&self, leaf: usize) -> Vec<Ledger> {
        let receiver = self.receiver_of(leaf);
        let [direct, reflected] = &self.error_estimate.residuals;
        let ledger = |c: usize| {
            self.points().on_receiver(&self.error_estimate, receiver, c)
                + direct[leaf][c].whole()
                + reflected[receiver][c].whole()
        };
        (0..self.channels().len()).map(ledger).collect()
    }

    /// Value of the polynomial on a leaf, in a channel; no less than [`Self::least_on`].
    #[must_use]
    pub fn value_on(&self, leaf: usize, channel: usize, reference: [f64; 2]) -> f64 {
        let (basis, face) = (self.basis(leaf), self.element(leaf).face());
        let values = basis.values(reference);
        let sent: f64 = self.radiosity.field.coefficients(leaf, channel).iter().zip(values).map(|(c, v)| c * v).sum();
        largest(sent + self.lamp_on(face, channel), self.least_on(leaf, channel))
    }

    /// The least radiosity that there can be on a leaf: the emission of its face, if it emits evenly, and 0 else.
    #[must_use]
    pub fn least_on(&self, leaf: usize, channel: usize) -> f64 {
        let face = self.element(leaf).face();
        if self.system.surfaces.glows_by_texture(face) { 0.0 } else { self.system.surfaces.emitted[face][channel] }
    }

    /// Coefficients of the polynomial on a leaf, with its emission as a lamp, in a channel.
    pub(crate) fn coefficients_on(&self, leaf: usize, channel: usize) -> Vec<f64> {
        let mut coefficients = self.radiosity.field.coefficients(leaf, channel).to_vec();
        coefficients[0] += self.lamp_on(self.element(leaf).face(), channel);
        coefficients
    }

    /// Irradiance on a leaf as a polynomial, in a channel: its coefficients in the leaf's basis.
    #[must_use]
    pub fn irradiance_on(&self, leaf: usize, channel: usize) -> Vec<f64> {
        let receiver = self.receiver_of(leaf);
        let gathered = self.gathered_by(receiver, &self.radiosity.field, channel);
        self.with_direct(self.brought_down(&gathered, receiver, leaf), leaf, channel)
    }

    /// The light that a leaf gathers, with the light of lamps that are kept apart.
    pub(super) fn with_direct(&self, mut gathered: Vec<f64>, leaf: usize, channel: usize) -> Vec<f64> {
        if !self.radiosity.direct.is_empty() {
            gathered.iter_mut().zip(self.direct_irradiance(leaf, channel)).for_each(|(h, direct)| *h += direct);
        }
        gathered
    }

    /// The part of a light that a receiver gathers, as a polynomial on it.
    pub(super) fn gathered_by(&self, receiver: usize, light: &Field, channel: usize) -> Vec<f64> {
        self.basis(receiver).project(&self.system.irradiance(light, receiver, channel))
    }

    /// A polynomial on a receiver as one on a leaf below it.
    pub(super) fn brought_down(&self, of_receiver: &[f64], receiver: usize, leaf: usize) -> Vec<f64> {
        let path: Vec<usize> = self.system.mesh.above(leaf).take_while(|&element| element != receiver).collect();
        let restricted = |held: Vec<f64>, &element: &usize| self.basis(receiver).restrict(self.system.mesh.child(element), &held);
        path.iter().rev().fold(of_receiver.to_vec(), restricted)
    }

    /// `E + rho H` at a point of a leaf with the irradiance as a polynomial, in a channel, where [`Self::value_on`] has the
    /// projection of the whole: the detail of textures is in it.
    /// `irradiance` is that of [`Self::irradiance_on`].
    #[must_use]
    pub fn textured_on(&self, leaf: usize, channel: usize, irradiance: &[f64], reference: [f64; 2]) -> f64 {
        let (basis, element) = (self.basis(leaf), self.element(leaf));
        let [rho, emitted] = self.system.surfaces.reflectance_and_emission(element.face(), element.point(reference));
        let received: f64 = irradiance.iter().zip(basis.values(reference)).map(|(c, v)| c * v).sum();
        emitted[channel] + rho[channel] * received
    }

    /// Gradient of the polynomial on a leaf over the leaf's plane, in a channel; in the unit of length of [`Self::placement`].
    #[must_use]
    pub fn gradient_on(&self, leaf: usize, channel: usize, reference: [f64; 2]) -> DVec3 {
        let basis = self.basis(leaf);
        let coefficients = self.radiosity.field.coefficients(leaf, channel);
        let slopes = basis.slopes(reference);
        let along = |k: usize| coefficients.iter().zip(&slopes).map(|(c, s)| c * s[k]).sum::<f64>();
        self.element(leaf).gradient([along(0), along(1)])
    }

    /// Estimate of the length of the error of [`Self::gradient_on`]: the gradient of the next degree, which the samples at the
    /// nodes have, and their part beyond it over the leaf's radius.
    #[must_use]
    pub fn gradient_estimate_on(&self, leaf: usize, channel: usize, reference: [f64; 2]) -> f64 {
        let (element, detail) = (self.element(leaf), &self.details()[leaf][channel]);
        let Some(above) = self.basis(leaf).above() else { return f64::INFINITY };
        let slopes = above.slopes(reference);
        let along = |k: usize| detail.coefficients.iter().zip(&slopes).map(|(c, s)| c * s[k]).sum::<f64>();
        element.gradient([along(0), along(1)]).length() + detail.truncation * (above.degree() as f64) / element.radius()
    }
}
