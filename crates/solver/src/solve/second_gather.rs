//! The error of a gather at a point, by a second gather.
//!
//! | symbol | meaning |
//! |---|---|
//! | `B_h` | the polynomials on leaves |
//! | `B_g` | one gather of them, `E + rho G B_h`, G without the light that links neglect |
//! | `d` | the known part, with its sign, of the light that links do not have: of `B_g - B_h` the next degree ([`crate::solve::next_degree`]), and `B_h` on leaves less its projection on an element that is linked |
//! | `e` | `B - B_g` |
//!
//! Of the error the part `e_1 = rho G d + rho G e_1` is known with its sign. It is an equation of radiosity, whose emission `rho G d` is
//! gathered at a few points of each receiver and whose links are there. At the point that is asked for one gather of both gives
//! `rho (G d + G e_1)`: as elements shrink, that is the error itself (K. Atkinson 1976: iterated collocation). The answer adds it.
//! The polynomials on leaves are orthogonal to d, so sources that are small for their distance count for next to nothing, and are not
//! evaluated.
//!
//! A detail counts by the part of it that is sure ([`crate::solve::next_degree`]): where elements are too large for the light on them,
//! the next degree tells no more of the error than the truncation.
//!
//! The error of the corrected answer is estimated. A part of the correction counts in full ([`LEFT`]), a smaller part of differences of
//! polynomials ([`STILL_OFF`]): the point gathers these exactly, but `e_1` does not. By squares are added, source by source, samples beyond
//! the next degree, reduced by as much as details fell short of their bounds ([`Beyond`]); a part of each detail; the light that goes back and
//! forth between the point and sources that touch it, which `e_1`, known at a few points of each receiver, may lack; and the light that links
//! neglect, with the errors of evaluations. The last term is the part that `e_1` lacks in the mean, times the reflected light that the point
//! gathers: the importance finds the error of the mean in another way ([`crate::solve::dual`]), and the mean of `e_1` is taken from that.

use radgrad_scene::{largest, smallest};

use crate::error::Error;
use crate::estimate::ledger::Ledger;
use crate::field::Field;
use crate::gathering::{MOST_SWEEPS, ratio};
use crate::links::cluster::far::Far;
use crate::links::link::Link;
use crate::links::station::Station;
use crate::links::transfer::{Kernel, Optics, Row};
use crate::mesh::Sight;
use crate::mesh::basis::{Basis, dot};
use crate::once::made;
use crate::solve::solution::{MeanError, Solution, for_each};

/// Changes below which the error is known, relative to its largest source.
const SOLVED: f64 = 1e-3;

/// The part of all that sources may give of a detail from which on one is evaluated, and the error that this may have, over the error
/// asked for.
const MUCH: f64 = 0.01;
const ROUGH: f64 = 1e-3;

/// The part of the bound on a link's neglected light that is taken to be there.
const TYPICAL: f64 = 0.5;

/// The radius of a source over its distance from which on its children are seen one by one.
const NEAR: f64 = 0.5;

/// The parts that the corrected answer is likely off by: of details and of the known error that is reflected; and of differences of
/// polynomials and, source by source, of details.
const LEFT: f64 = 0.5;
const STILL_OFF: f64 = 0.25;

/// The part of the likely error of the mean's own error that counts beside its difference from the mean of the known error: the two may
/// agree by chance.
const BY_CHANCE: f64 = 0.1;

/// Samples beyond details count by this part of the square of their bound at least, as details may cancel by symmetry.
const LEAST_BEYOND: f64 = 0.25;

/// The gather of a station from a source.
pub(super) struct Term<'a> {
    pub(super) source: usize,
    pub(super) sight: &'a Sight,
    /// The row that has its form factor.
    pub(super) row: &'a Row,
}

/// A part of a source, as a station sees it.
#[derive(Debug, Clone)]
struct Piece {
    source: usize,
    /// Its form factor at most, and its radius over its distance.
    factor: f64,
    near: f64,
    /// Whether all of it is seen.
    is_smooth: bool,
    /// In each channel, the polynomial that is linked, and beside it, in the basis of the next degree, the leaves' own and
    /// the known detail.
    linked: Vec<Vec<f64>>,
    differs: Vec<Vec<f64>>,
    detail: Vec<Vec<f64>>,
    /// In each channel, the most that is gathered of all that; of the detail by the kernel's part of its degree, and of the samples beyond by
    /// that of theirs; of these by the kernel's other parts; and of the leaves below.
    sizes: Vec<f64>,
    by_kernel: Vec<f64>,
    truncation: Vec<f64>,
    along: Vec<f64>,
    neglected: Vec<f64>,
}

/// The error of a gather: the part that is known with its sign, and an estimate of its remainder, in each channel.
pub(super) struct KnownError {
    pub(super) known: Vec<f64>,
    pub(super) left: Vec<Ledger>,
}

/// Of the details that a station gathers, in a channel.
#[derive(Debug, Clone, Copy, Default)]
struct Gathered {
    /// Known as differences of polynomials, and as details.
    sure: f64,
    unsure: f64,
    /// Known of the face beside the station: its error is known apart.
    beside: f64,
    /// Square of the likely error of the others.
    squared_error: f64,
}

impl Gathered {
    fn total(&self) -> f64 {
        self.sure + self.unsure + self.beside
    }
}

/// Squares of a station's gathers: bounds on the truncations, on details, and of these as they were found.
#[derive(Debug, Clone, Copy, Default)]
struct Beyond {
    most: f64,
    of_details: f64,
    found: f64,
}

impl Beyond {
    /// The likely square of the samples' part, which falls short of its bound as details do.
    fn likely(&self) -> f64 {
        let part = if self.found < self.of_details { self.found / self.of_details } else { 1.0 };
        self.most * largest(part, LEAST_BEYOND)
    }
}

/// Of the sources that touch a station: the known part of their details, their form factor, and that times their reflectance.
#[derive(Debug, Clone, Copy, Default)]
struct Touching {
    known: f64,
    factor: f64,
    reflected: f64,
}

impl Touching {
    fn add(&mut self, known: f64, factor: f64, rho: f64) {
        self.known += known;
        self.factor += factor;
        self.reflected += rho * factor;
    }

    /// The light of the details that comes again, as often as it goes back and forth. Form factors are at most that, and their
    /// sum is at most 1.
    fn again(&self) -> f64 {
        let returned = self.reflected / largest(self.factor, 1.0);
        self.known * returned / (1.0 - returned)
    }
}

impl Solution {
    /// The part of the error of gathers that is known, on the receivers; `None` if it grows without end or cannot be evaluated.
    pub(super) fn known_error(&self) -> Option<&Field> {
        made(&self.caches.known_error, || self.solve_error().ok().flatten()).as_ref()
    }

    fn solve_error(&self) -> Result<Option<Field>, Error> {
        let (mesh, channels) = (&self.system.mesh, self.channels().len());
        let mut source = vec![Vec::new(); mesh.elements().len()];
        let mut own = source.clone();
        let emitted = for_each(&self.system.receivers, |receiver| self.error_emitted(receiver))?;
        let mut scale = vec![0.0; channels];
        for (&receiver, emitted) in self.system.receivers.iter().zip(emitted) {
            let len = mesh.basis(receiver).len();
            scale.iter_mut().zip(emitted.chunks_exact(len)).for_each(|(most, of)| {
                *most = of.iter().fold(*most, |most, c| largest(most, c.abs()));
            });
            own[receiver] = vec![0.0; emitted.len()];
            source[receiver] = emitted;
        }
        let mut error = Field::dark(mesh, channels);
        let equation = self.system.equation(&source);
        let (_, change) = equation.solve((&mut error, &mut own), (SOLVED, MOST_SWEEPS), scale, |_, _| ());
        error.pull(mesh);
        Ok((change <= SOLVED).then_some(error))
    }

    /// The projection of `rho G d` on a receiver, as far as a rule for the first degree sees it, channel after channel.
    fn error_emitted(&self, receiver: usize) -> Result<Vec<f64>, Error> {
        let (element, channels, len) = (self.element(receiver), self.channels().len(), self.basis(receiver).len());
        let mut emitted = vec![0.0; len * channels];
        if self.system.surfaces.reflectance[element.face()].iter().all(|rho| *rho == 0.0) {
            return Ok(emitted);
        }
        let basis = Basis::linear(element.shape());
        let links = &self.system.links[receiver];
        // The last node is near the middle.
        let term = |link| {
            let Link { source, sight, rows, .. }: &Link = link;
            Some(Term { source: *source, sight, row: rows.last()? })
        };
        let terms = || links.iter().filter_map(term);
        let details_at = |place: [f64; 2]| self.gathered_details(&Station::on(element, element.point(place)), terms(), None);
        let at_nodes: Vec<Vec<Gathered>> = basis.nodes().iter().map(|node| details_at(node.at)).collect::<Result<_, _>>()?;
        for (channel, emitted) in emitted.chunks_exact_mut(len).enumerate() {
            let samples: Vec<f64> = at_nodes.iter().map(|details| details[channel].total()).collect();
            emitted.iter_mut().zip(basis.project(&samples)).for_each(|(emitted, of)| *emitted = of);
            self.system.surfaces.reflect(&self.system.mesh, receiver, channel, emitted);
        }
        Ok(emitted)
    }

    /// Whether details are of the light itself: where clusters are gathered from by rays they are the noise of those.
    pub(super) fn has_sure_details(&self) -> bool {
        self.system.receivers.iter().all(|&receiver| self.system.far[receiver].is_empty())
    }

    /// A source in pieces that a station sees from afar, or that are leaves.
    fn pieces(&self, station: &Station, source: usize, row: &Row) -> Vec<Piece> {
        let (mut found, mut open) = (Vec::new(), vec![self.whole_of(station, source, row)]);
        while let Some(piece) = open.pop() {
            match self.element(piece.source).children() {
                Some(first) if piece.near > NEAR => open.extend(self.children_of(station, &piece, first)),
                _ => found.push(piece),
            }
        }
        found
    }

    fn whole_of(&self, station: &Station, source: usize, row: &Row) -> Piece {
        let linked =
            (0..self.channels().len()).map(|channel| self.radiosity.field.coefficients(source, channel).to_vec()).collect();
        let neglected = |channel| self.radiosity.field.neglected(&self.system.mesh, source, channel, row);
        self.piece(station, (source, row.likely_factor(), row.kernel.smooth), linked, neglected)
    }

    fn children_of(&self, station: &Station, piece: &Piece, first: usize) -> Vec<Piece> {
        let child_of = |child: usize| {
            let source = first + child;
            let mut kernel = Kernel::bound(station, self.element(source));
            kernel.smooth &= piece.is_smooth;
            let factor = smallest(kernel.peak, piece.factor);
            let linked = piece.linked.iter().map(|of| self.basis(piece.source).restrict(child, of)).collect();
            let neglected = |channel| self.radiosity.field.neglected_by(&self.system.mesh, source, channel, (factor, &kernel));
            self.piece(station, (source, factor, piece.is_smooth), linked, neglected)
        };
        (0..4).map(child_of).collect()
    }

    fn piece(
        &self,
        station: &Station,
        (source, factor, is_smooth): (usize, f64, bool),
        linked: Vec<Vec<f64>>,
        neglected: impl Fn(usize) -> f64,
    ) -> Piece {
        let (element, basis) = (self.element(source), self.basis(source));
        let near = element.nearness_to(station.point);
        let falls = if is_smooth { near } else { 1.0 };
        let channels = self.channels().len();
        let mut piece = Piece {
            source,
            factor,
            near,
            differs: Vec::new(),
            detail: Vec::new(),
            sizes: Vec::new(),
            by_kernel: Vec::new(),
            truncation: Vec::new(),
            along: Vec::new(),
            neglected: Vec::new(),
            is_smooth,
            linked,
        };
        for (channel, of) in (0..channels).zip(&self.details()[source]) {
            let sure = of.sure();
            let held = self.radiosity.field.coefficients(source, channel);
            let differs: Vec<f64> = held.iter().zip(&piece.linked[channel]).map(|(held, linked)| held - linked).collect();
            let detail = power(falls, basis.degree() + 1) * length(&of.coefficients);
            let size = detail + length(&differs);
            let neglected = if factor > 0.0 { neglected(channel) } else { 0.0 };
            let textured = self.error_estimate.residuals.iter().map(|of| of[source][channel].detail_rms()).fold(0.0, f64::hypot);
            let unsure = (1.0 - sure) * detail;
            piece.by_kernel.push(factor * sure * detail);
            piece.truncation.push(factor * (power(falls, basis.degree() + 2) * of.truncation).hypot(unsure));
            piece.along.push(factor * of.along.hypot(textured));
            piece.sizes.push(factor * size + neglected);
            piece.neglected.push(TYPICAL * neglected);
            piece.differs.push(differs);
            piece.detail.push(of.coefficients.iter().map(|c| sure * c).collect());
        }
        piece
    }

    /// `G d` at a station, in each channel, with the light that links neglect. Of a face beside the station the part that touches
    /// it is known otherwise.
    fn gathered_details<'a>(
        &self,
        station: &Station,
        terms: impl Iterator<Item = Term<'a>>,
        beside: Option<usize>,
    ) -> Result<Vec<Gathered>, Error> {
        let rough = ROUGH * self.budget.asked;
        let optics = Optics { absolute: rough, past: rough, ..self.optics() };
        let (reference, is_sure) = (self.reference(), self.has_sure_details());
        let relative = |sizes: &[f64]| sizes.iter().zip(&reference).map(|(size, of)| ratio(*size, *of)).fold(0.0, largest);
        let mut open = Vec::new();
        for Term { source, sight, row } in terms {
            open.extend(self.pieces(station, source, row).into_iter().map(|piece| (piece, sight)));
        }
        let much = MUCH * open.iter().map(|(piece, _)| relative(&piece.sizes)).sum::<f64>();
        let mut gathered = vec![Gathered::default(); self.channels().len()];
        let mut touching = vec![Touching::default(); self.channels().len()];
        let mut truncation = vec![Beyond::default(); self.channels().len()];
        while let Some((piece, sight)) = open.pop() {
            let counts = |sizes: &[f64]| relative(sizes) > much;
            if let Some(first) = self.element(piece.source).children().filter(|_| counts(&piece.neglected)) {
                open.extend(self.children_of(station, &piece, first).into_iter().map(|piece| (piece, sight)));
                continue;
            }
            let is_known = piece.near == 1.0 && beside == Some(self.element(piece.source).face());
            for (channel, (gathered, truncation)) in gathered.iter_mut().zip(&mut truncation).enumerate().filter(|_| !is_known) {
                gathered.squared_error += square(piece.along[channel]);
                truncation.most += square(piece.truncation[channel]);
            }
            if !counts(&piece.sizes) {
                gathered.iter_mut().zip(&piece.sizes).for_each(|(gathered, size)| gathered.squared_error += square(*size));
                continue;
            }
            let Some(above) = self.basis(piece.source).above() else { continue };
            let sizes: Vec<f64> = piece.differs.iter().zip(&piece.detail).map(|(a, b)| length(a) + length(b)).collect();
            let row = optics.for_brightness(relative(&sizes)).receive_of(station, (piece.source, above), sight, above.len())?;
            for (channel, gathered) in gathered.iter_mut().enumerate() {
                // A difference of polynomials is exact; a detail is an estimate.
                let [differs, detail] = [&piece.differs, &piece.detail].map(|of| dot(&of[channel], &row.values));
                let error = differs + detail;
                if is_known {
                    gathered.beside += if is_sure { error } else { 0.0 };
                    continue;
                }
                if is_sure {
                    gathered.sure += differs;
                    gathered.unsure += detail;
                }
                gathered.squared_error +=
                    square(if is_sure { STILL_OFF * detail } else { error }) + square(piece.neglected[channel]);
                truncation[channel].found += square(detail);
                truncation[channel].of_details += square(piece.by_kernel[channel]);
                if piece.near == 1.0 {
                    let rho = self.system.reflectance(piece.source, channel);
                    touching[channel].add(error, piece.factor, rho);
                }
            }
        }
        gathered.iter_mut().zip(touching).for_each(|(gathered, touching)| gathered.squared_error += square(touching.again()));
        gathered.iter_mut().zip(truncation).for_each(|(gathered, truncation)| gathered.squared_error += truncation.likely());
        Ok(gathered)
    }

    /// The error of the irradiance of a point, from its gathers of each source. `None` if no error of the sources is known. The
    /// estimate leaves out sources on the face `beside` the point that touch it: [`crate::solve::wedge`] estimates their error.
    pub(super) fn error_at<'a>(
        &self,
        station: &Station,
        terms: impl Iterator<Item = Term<'a>> + Clone,
        far: &Far,
        beside: Option<usize>,
    ) -> Option<KnownError> {
        let error = self.known_error()?;
        let details = self.gathered_details(station, terms.clone(), beside).ok()?;
        let of_mean = self.mean_error();
        let of_channel = |(channel, Gathered { sure, unsure, beside: known, squared_error }): (usize, Gathered)| {
            let gathered = |field: &Field| far.value(field, channel, 0);
            let (mut propagated, mut reflected, mut unseen) = (gathered(error), gathered(&self.radiosity.field), 0.0);
            let mut beside_carried = 0.0;
            for Term { source, row, .. } in terms.clone() {
                let of_error = dot(error.coefficients(source, channel), &row.values);
                if beside == Some(self.element(source).face()) {
                    beside_carried += of_error;
                } else {
                    propagated += of_error;
                }
                // The emission of faces has no error.
                reflected += dot(self.radiosity.field.coefficients(source, channel), &row.values)
                    - dot(&self.emitted_on(source, channel), &row.values);
                unseen +=
                    row.likely_factor() * self.error_estimate.residuals.iter().map(|of| of[source][channel].unseen).sum::<f64>();
            }
            let MeanError { correction, error: error_in_mean, .. } = of_mean[channel];
            let lacks = (correction - error.mean(&self.system.mesh, channel)).hypot(BY_CHANCE * error_in_mean);
            let light = if self.radiosity.reflected[channel] > 0.0 {
                self.radiosity.reflected[channel]
            } else {
                self.radiosity.mean[channel]
            };
            let of_light = reflected.abs() * ratio(lacks, light);
            let remaining =
                (LEFT * (unsure + propagated) + STILL_OFF * sure).abs() + unseen + squared_error.sqrt().hypot(of_light);
            (sure + unsure + propagated + known + beside_carried, Ledger { discretisation: remaining, ..Ledger::default() })
        };
        let (known, left) = details.into_iter().enumerate().map(of_channel).unzip();
        Some(KnownError { known, left })
    }
}

fn square(x: f64) -> f64 {
    x * x
}

fn power(x: f64, n: usize) -> f64 {
    std::iter::repeat_n(x, n).product()
}

fn length(coefficients: &[f64]) -> f64 {
    coefficients.iter().map(|c| c * c).sum::<f64>().sqrt()
}
