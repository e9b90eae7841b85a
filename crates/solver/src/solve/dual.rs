//! The error of the mean radiosity, with its sign, by the importance.
//!
//! | symbol | meaning |
//! |---|---|
//! | `T` | the computed radiosity: polynomials on leaves, and the emission of lamps |
//! | `E`, `rho`, `G` | emission, reflectance, transport: `B = E + rho G B` |
//! | `r = E + rho G T - T` | the residual |
//! | `phi = 1 + G rho phi` | importance: how much of a unit of light is found in the end, over all area |
//! | `phi_h`, `b_h = rho phi_h` | its solution on the receivers, polynomials, and their reflected importance |
//!
//! The integral of `B - T` is `int phi r = int phi_h r + int (phi - phi_h) r`. As G is the same both ways the first part is
//!
//! ```text
//! int phi_h (E - T) + int T G b_h                                  the error of links, clusters, rays and the nodes' rules
//! ```
//!
//! with `G b_h` at the nodes of receivers: the light of lamps is found once more, gathered by the lamps. Links that neglect as
//! much of the importance as of the light do not see their neglect of either: by symmetry both errors are alike. So receivers
//! gather the importance by finer links where that may be a large part of all. The importance is smooth where the light has the
//! edges of shadows, so that the error of this gather itself is less; it is counted without its sign. In the second part `phi -
//! phi_h` is the part of the next degree in `G b_h` at the nodes, `r` that of direct light on leaves and of reflected light on
//! receivers, and their product is known with its sign, too. An element far below its receiver that holds much of all light, as
//! under a lamp close by, may see importance that the receiver's nodes miss: there it is gathered once more, for all leaves
//! below. Where a face is close to another, light and importance fall off along the rim, between the nodes: these layers
//! ([`crate::solve::layers`]) are in both parts. Light that no sample sees is in neither: its expectation counts by itself.
//!
//! This is the goal-oriented estimate of R. Becker and R. Rannacher (2001); for radiosity D. Lischinski, B. Smits and D. Greenberg (1994).

use std::collections::{BTreeMap, HashMap};

use radgrad_scene::{largest, smallest};
use rayon::prelude::*;

use crate::error::Error;
use crate::estimate::ledger::Ledger;
use crate::field::Field;
use crate::gathering::{MOST_SWEEPS, irradiance, ratio};
use crate::links::cluster::far::Far;
use crate::links::direct::FEW as MOST_LAMPS;
use crate::links::gatherer::Gatherer;
use crate::links::link::Link;
use crate::links::refine::{Need, WITHOUT_ORDER};
use crate::links::transfer::Row;
use crate::mesh::basis::{Basis, Excess, dot};
use crate::once::made;
use crate::solve::layers::Layers;
use crate::solve::solution::{MeanError, Solution, for_each};

/// Changes below which the importance is known, relative to its mean: the remainder is of second order where `phi_h` is `b_h` over the
/// reflectance, and of first with textures.
const SOLVED: f64 = 1e-6;
const SOLVED_WITH_TEXTURES: f64 = 1e-8;

/// The part of lamps in the light that links may neglect: they are few.
const OF_LAMPS: f64 = 0.1;

/// The part of a bound by Schwarz, on the light that a link neglects or on the product of truncations, that is taken to
/// be there: 0.01 to 0.05 in the mean of the Cornell box and of rooms of a hundred triangles and of a sphere.
const TYPICAL: f64 = 0.1;

/// An element below its receiver has an importance of its own if it holds more than this part of all light.
const MUCH: f64 = 1e-3;

/// That importance is the receiver's polynomial, moved by a constant to the value gathered at the element's centre. Its error is
/// taken to be the first part of that move, and the error of layers the same part of them. If the error times the element's light
/// is more than the second part of the light that links may neglect, the importance is gathered at all nodes instead.
const STILL_OFF: f64 = 0.25;
const NOTICED: f64 = 0.005;

/// Integrals over all area, of a receiver in a channel.
#[derive(Debug, Clone, Copy, Default)]
struct Part {
    /// By the swapped gather, and by the details of both.
    swapped: f64,
    detail: f64,
    /// The square of the likely error of both.
    squared_error: f64,
    /// Bound on the light that links of the swapped gather neglect: the same way wherever light and kernels are alike, so that it
    /// adds up by itself.
    neglected: f64,
    /// By light that no sample sees.
    unseen: f64,
}

impl Part {
    /// The likely error.
    fn likely_error(&self) -> f64 {
        self.squared_error.sqrt()
    }

    fn and(self, other: Self) -> Self {
        Self {
            swapped: self.swapped + other.swapped,
            detail: self.detail + other.detail,
            squared_error: self.squared_error + other.squared_error,
            neglected: self.neglected + other.neglected,
            unseen: self.unseen + other.unseen,
        }
    }
}

/// The error that remains once the correction is added to the mean, over the largest correction by rough or by fine links.
const STILL_OFF_BY: f64 = 0.9;

/// Over the other corrections, the importance that links may neglect before finer ones are made, and over the mean, as no more is
/// found than rounding leaves; the part of it that the finer ones may, and how often these are made.
const LITTLE: f64 = 0.5;
const ROUNDED: f64 = 1e-12;
const FINER: f64 = 0.1;
const MOST_REFINEMENTS: usize = 3;

/// An importance: as it is sent; the links of receivers that gather it by other links than light; and, channel by channel, the importance of
/// elements below their receivers that have their own.
struct Importance {
    sent: Field,
    links: HashMap<usize, Gathers>,
    below: HashMap<usize, Vec<Gathered>>,
}

/// The polynomial of an element's gather, and its error in the mean.
type Gathered = (Vec<f64>, f64);

/// The links and clusters of a receiver, at the nodes of another basis where there is one.
struct Gathers {
    links: Vec<Link>,
    far: Far,
    basis: Option<Basis>,
}

/// The degree of the polynomial for which faces that emit gather the importance by rays where that of their own may be off by much: it has
/// three times as many nodes.
const FINER_DEGREE: usize = 4;

/// The error of the mean by the rule of the nodes: the truncation, as far as it does not fall off;
/// where it does not, that of a sum over so many nodes without order.
fn rule_error(basis: &Basis, excess: &Excess) -> f64 {
    let ratio = if excess.next < excess.last { excess.next / excess.last } else { 1.0 };
    let falls = std::iter::repeat_n(ratio, basis.degree() + 2).product::<f64>();
    let without_order = 1.0 / basis.nodes().len() as f64;
    (if falls < without_order { falls } else { without_order }) * excess.next.hypot(excess.spread)
}

impl Solution {
    /// The importance by the links that there are, as it is sent; `None` if it grows without end.
    pub(super) fn importance(&self) -> Option<&Field> {
        made(&self.caches.importance, || self.solve_importance()).as_ref()
    }

    fn solve_importance(&self) -> Option<Field> {
        let (mesh, channels) = (&self.system.mesh, self.channels().len());
        let [source, mut own] = self.system.reflectances();
        let mut sent = Field::dark(mesh, channels);
        for channel in 0..channels {
            // As if everywhere as much were found, which it is where light is not lost and reflectances are the same.
            let reflected =
                |&receiver: &usize| self.element(receiver).area() * source[receiver][channel * self.basis(receiver).len()];
            let rho = self.system.receivers.iter().map(reflected).sum::<f64>() / mesh.area();
            let even = if rho < 1.0 { 1.0 / (1.0 - rho) } else { 1.0 };
            for &receiver in &self.system.receivers {
                let len = self.basis(receiver).len();
                let of_channel = channel * len..(channel + 1) * len;
                let first: Vec<f64> = source[receiver][of_channel.clone()].iter().map(|rho| even * rho).collect();
                sent.add(mesh, receiver, channel, &first);
                own[receiver][of_channel].copy_from_slice(&first);
            }
        }
        let until = if self.system.surfaces.is_textured() { SOLVED_WITH_TEXTURES } else { SOLVED };
        let scaled = |sent: &Field, scale: &mut [f64]| {
            scale.iter_mut().enumerate().for_each(|(channel, scale)| *scale = largest(sent.mean(mesh, channel), 1.0));
        };
        let equation = self.system.equation(&source);
        let (_, change) = equation.solve((&mut sent, &mut own), (until, MOST_SWEEPS), vec![1.0; channels], scaled);
        (change <= until).then(|| {
            sent.pull(mesh);
            sent
        })
    }

    /// The links of lamps, as finely as the importance there has to be known; also of other faces that emit and gather by rays, if all that
    /// emit are few. The links by which these faces gather light may be rougher, and their nodes fewer.
    fn links_of_lamps(&self, importance: &Field) -> Result<HashMap<usize, Gathers>, Error> {
        let (area, channels) = (self.system.mesh.area(), 0..self.channels().len());
        let emitted = |element: usize, channel: usize| self.system.surfaces.emitted[self.element(element).face()][channel];
        let emits = |element: &usize| channels.clone().any(|channel| emitted(*element, channel) > 0.0);
        if self.system.mesh.roots().iter().filter(|root| emits(root)).count() > MOST_LAMPS {
            return Ok(HashMap::new());
        }
        let is_meant = |element: &usize| self.is_lamp(self.element(*element).face()) || !self.system.far[*element].is_empty();
        let lamps: Vec<usize> = self.system.receivers.iter().copied().filter(|of| emits(of) && is_meant(of)).collect();
        let power = |channel: usize| lamps.iter().map(|&lamp| self.element(lamp).area() * emitted(lamp, channel)).sum::<f64>();
        let weight: Vec<f64> =
            channels.clone().zip(self.reference()).map(|(c, reference)| ratio(power(c), reference * area)).collect();
        let allowed = OF_LAMPS * self.budget.allowed;
        let need = Need {
            field: importance,
            weight: &weight,
            allowed,
            without_order: WITHOUT_ORDER,
            of_rays: WITHOUT_ORDER,
            clock: self.budget.clock,
        };
        let of_lamp = |lamp: usize| {
            let (optics, own) = (self.optics(), self.basis(lamp));
            let (links, far) = (&self.system.links[lamp], &self.system.far[lamp]);
            let weighted_error = |(channel, weight): (usize, &f64)| {
                let at_nodes = self.system.irradiance(importance, lamp, channel);
                weight * rule_error(own, &own.excess(&at_nodes))
            };
            let is_off = weight.iter().enumerate().map(weighted_error).fold(0.0, largest) > allowed;
            let basis = (is_off && !far.is_empty()).then(|| Basis::new(own.shape(), FINER_DEGREE));
            let gatherer = basis.as_ref().map_or(Gatherer::Element(lamp), |basis| Gatherer::Finer(lamp, basis));
            let (mut links, mut far) = match basis {
                Some(_) => optics.first_links(gatherer, None, &need)?,
                None => (links.clone(), far.clone()),
            };
            optics.refine(gatherer, (&mut links, &mut far), &need)?;
            Ok((lamp, Gathers { links, far, basis }))
        };
        Ok(for_each(&lamps, of_lamp)?.into_iter().collect())
    }

    /// The gather of the importance by elements below receivers that hold much of all light, and some of it in leaves that do not
    /// by themselves.
    fn importance_below(&self, sent: &Field) -> Result<HashMap<usize, Vec<Gathered>>, Error> {
        let power = |element: usize, channel: usize| {
            let (held, of) = (self.radiosity.field.coefficients(element, channel)[0], self.element(element));
            of.area() * (held + self.lamp_on(of.face(), channel)).abs()
        };
        let totals: Vec<f64> =
            (0..self.channels().len()).map(|channel| self.system.mesh.leaves().map(|leaf| power(leaf, channel)).sum()).collect();
        let holds_much =
            |element: usize| totals.iter().enumerate().any(|(channel, totals)| power(element, channel) > MUCH * totals);
        let has_own = |&element: &usize| {
            let receiver = self.receiver_of(element);
            let below = self.element(element).children();
            element != receiver
                && self.gathers(receiver)
                && self.system.far[receiver].is_empty()
                && holds_much(element)
                && below.is_none_or(|first| !(first..first + 4).all(holds_much))
        };
        let elements: Vec<usize> = (0..self.system.mesh.elements().len()).filter(has_own).collect();
        let importance_on = |element: usize| {
            let (receiver, basis) = (self.receiver_of(element), self.basis(element));
            let (above, own_element) = (basis.above().unwrap_or(basis), self.element(element));
            // The importance has no unit.
            let weight = vec![1.0; self.channels().len()];
            let gathered_at = |place: [f64; 2]| self.gathered_at((sent, &weight), receiver, own_element.point(place));
            let (centre, reference) = (own_element.shape().centre(), self.reference());
            let moved = |(channel, here): (usize, f64)| {
                let z = above.project(&self.system.irradiance(sent, receiver, channel));
                let mut z = self.restricted(receiver, element, above, &z);
                let differs = here - dot(&z, &above.values(centre));
                z[0] += differs;
                z.truncate(basis.len());
                (z, STILL_OFF * differs.abs())
            };
            let moved: Vec<Gathered> = gathered_at(centre)?.into_iter().enumerate().map(moved).collect();
            let relative_error = |(channel, (_, error)): (usize, &Gathered)| {
                ratio(power(element, channel) * error, reference[channel] * self.system.mesh.area())
            };
            if moved.iter().enumerate().map(relative_error).fold(0.0, largest) <= NOTICED * self.budget.allowed {
                return Ok((element, moved));
            }
            let at_nodes = basis.nodes().iter().map(|node| gathered_at(node.at)).collect::<Result<Vec<_>, Error>>()?;
            let of_channel = |channel: usize| {
                let at_nodes: Vec<f64> = at_nodes.iter().map(|of| of[channel]).collect();
                (basis.project(&at_nodes), rule_error(basis, &basis.excess(&at_nodes)))
            };
            Ok((element, (0..self.channels().len()).map(of_channel).collect()))
        };
        Ok(for_each(&elements, importance_on)?.into_iter().collect())
    }

    /// The error of the mean radiosity over all area, in each channel: the correction with its sign, and an estimate of the error
    /// once it is added to the mean. Neither is more than the estimate of the mean of the magnitude.
    pub(super) fn estimate_mean(&self) -> Result<Option<Vec<MeanError>>, Error> {
        let Some(sent) = self.importance().cloned() else { return Ok(None) };
        let (links, below) = (self.links_of_lamps(&sent)?, self.importance_below(&sent)?);
        let mut importance = Importance { sent, links, below };
        let mut below = vec![Vec::new(); self.system.mesh.elements().len()];
        for leaf in self.system.mesh.leaves() {
            below[self.receiver_of(leaf)].push(leaf);
        }
        let area = self.system.mesh.area();
        let layers = for_each(&self.system.receivers, |receiver| self.layers_on(receiver, &importance.sent))?;
        let mut parts = self.parts(&importance, (&below, &layers));
        let rough = parts.clone();
        for _ in 0..MOST_REFINEMENTS {
            let is_rough = |(part, mean): (&Part, &f64)| {
                let others = square(part.swapped + part.detail) + part.squared_error + square(part.unseen);
                TYPICAL * part.neglected > LITTLE * others.sqrt() && part.neglected > ROUNDED * mean * area
            };
            if !parts.iter().zip(&self.radiosity.mean).any(is_rough) || !self.refine_importance(&mut importance)? {
                break;
            }
            parts = self.parts(&importance, (&below, &layers));
        }
        let of_channel = |((part, rough), most): ((&Part, &Part), &Ledger)| {
            // In all it is no more than the error of gathers.
            let no_more = |found: f64| largest(smallest(found, most.total()), -most.total());
            let [found, found_roughly] = [part, rough].map(|part| no_more((part.swapped + part.detail) / area));
            let error = no_more(part.likely_error().hypot(part.unseen) / area);
            let remaining = STILL_OFF_BY * largest(found.abs(), found_roughly.abs());
            let total = smallest(remaining.hypot(error), most.total());
            let (discretisation, computation) = (part.detail.abs() + part.unseen, part.swapped.abs() + part.likely_error());
            let parts = Ledger { discretisation, computation, ..Ledger::default() };
            let estimate = parts * ratio(total, parts.total());
            MeanError { estimate, correction: found, error }
        };
        Ok(Some(parts.iter().zip(&rough).zip(&self.error_estimate.mean).map(of_channel).collect()))
    }

    /// The terms of layers on a receiver in the integrals, in each channel.
    fn layers_on(&self, receiver: usize, importance: &Field) -> Result<Vec<Part>, Error> {
        let links = &self.system.links[receiver];
        let Some(layers) = Layers::near_receiver(&self.optics(), receiver, links)? else {
            return Ok(vec![Part::default(); self.channels().len()]);
        };
        let (element, basis) = (self.element(receiver), self.basis(receiver));
        let (area, rho) = (element.area(), &self.system.surfaces.reflectance[element.face()]);
        let of_channel = |(channel, rho): (usize, &f64)| {
            let truncation = |field: &Field| {
                let at_nodes = self.system.irradiance(field, receiver, channel);
                let layer = layers.truncation(&at_nodes, basis, |source| field.coefficients(source, channel));
                (basis.next(&at_nodes), layer)
            };
            let ((light, of_light), (z, of_z)) = (truncation(&self.radiosity.field), truncation(importance));
            let mut held = self.radiosity.field.coefficients(receiver, channel).to_vec();
            held[0] += self.lamp_on(element.face(), channel);
            let swapped = area * layers.times(&held, &of_z);
            let product = layers.times(&light, &of_z) + layers.times(&z, &of_light) + layers.product(&of_light, &of_z);
            let detail = area * rho * product;
            Part { swapped, detail, squared_error: square(STILL_OFF * (swapped + detail)), ..Part::default() }
        };
        Ok(rho.iter().enumerate().map(of_channel).collect())
    }

    /// The sum over all receivers, in each channel; below each there are leaves, and each has layers.
    fn parts(&self, importance: &Importance, (below, layers): (&[Vec<usize>], &[Vec<Part>])) -> Vec<Part> {
        let of_channel = |channel: usize| {
            let part_on = |&receiver: &usize| self.part_of(receiver, channel, importance, &below[receiver]);
            let parts: Vec<Part> = self.system.receivers.par_iter().map(part_on).collect();
            parts.into_iter().chain(layers.iter().map(|part_on| part_on[channel])).fold(Part::default(), Part::and)
        };
        (0..self.channels().len()).map(of_channel).collect()
    }

    /// Refines the links by which receivers without clusters gather the importance to a part of the light that they neglect now,
    /// in the mean over all light. Returns whether any was refined.
    fn refine_importance(&self, importance: &mut Importance) -> Result<bool, Error> {
        let (field, reference) = (&importance.sent, self.reference());
        let own = |receiver: usize| importance.links.get(&receiver).map_or(&self.system.links[receiver][..], |of| &of.links[..]);
        // The light of a receiver, over that which errors are relative to.
        let light = |receiver: usize| -> Vec<f64> {
            let element = self.element(receiver);
            let relative_light = |(channel, reference): (usize, &f64)| {
                let held = self.radiosity.field.coefficients(receiver, channel)[0] + self.lamp_on(element.face(), channel);
                ratio(held.abs(), *reference)
            };
            reference.iter().enumerate().map(relative_light).collect()
        };
        let neglected = |receiver: usize| {
            let basis = self.basis(receiver);
            let weighted_neglect = |(channel, light): (usize, f64)| {
                light * own(receiver).iter().map(|link| self.neglected_by(link, field, basis, channel)).sum::<f64>()
            };
            Ok(light(receiver).into_iter().enumerate().map(weighted_neglect).fold(0.0, largest))
        };
        let receivers: Vec<usize> =
            self.system.receivers.iter().copied().filter(|&receiver| self.system.far[receiver].is_empty()).collect();
        let neglected: Vec<(usize, f64)> = receivers.iter().copied().zip(for_each(&receivers, neglected)?).collect();
        let area = |receiver: usize| self.element(receiver).area();
        let allowed = FINER * neglected.iter().map(|&(receiver, neglected)| area(receiver) * neglected).sum::<f64>()
            / self.system.mesh.area();
        let rough: Vec<usize> = neglected.into_iter().filter(|&(_, of)| of > allowed).map(|(receiver, _)| receiver).collect();
        let refined = |receiver: usize| {
            let need = Need {
                field,
                weight: &light(receiver),
                allowed,
                without_order: WITHOUT_ORDER,
                of_rays: WITHOUT_ORDER,
                clock: self.budget.clock,
            };
            let (mut links, mut far) = (own(receiver).to_vec(), Far::default());
            let any = self.optics().refine(Gatherer::Element(receiver), (&mut links, &mut far), &need)?;
            Ok(any.then_some((receiver, Gathers { links, far, basis: None })))
        };
        let refined: Vec<(usize, Gathers)> = for_each(&rough, refined)?.into_iter().flatten().collect();
        let any = !refined.is_empty();
        importance.links.extend(refined);
        Ok(any)
    }

    /// The terms of a receiver and the leaves below it, or of itself, in the integrals.
    fn part_of(&self, receiver: usize, channel: usize, importance: &Importance, leaves: &[usize]) -> Part {
        let own = (&self.system.links[receiver][..], &self.system.far[receiver]);
        let gathers = importance.links.get(&receiver);
        let by = gathers.map_or(own, |of| (&of.links[..], &of.far));
        let (below, importance) = (&importance.below, &importance.sent);
        let (element, basis) = (self.element(receiver), self.basis(receiver));
        let (len, rho) = (basis.len(), self.system.surfaces.reflectance[element.face()][channel]);
        let (area, above) = (element.area(), basis.above().unwrap_or(basis));
        let of_importance = gathers.and_then(|of| of.basis.as_ref());
        let nodes_basis = of_importance.unwrap_or(basis);
        let at_nodes = irradiance(importance, by.0, by.1, channel, nodes_basis.nodes().len());
        let (mut z, excess) = (of_importance.unwrap_or(above).project(&at_nodes), nodes_basis.excess(&at_nodes));
        z.truncate(above.len());
        let lamp = self.lamp_on(element.face(), channel);
        let held = self.radiosity.field.coefficients(receiver, channel);
        let phi: Vec<f64> = match self.system.surfaces.pattern(receiver, channel) {
            _ if rho == 0.0 => vec![0.0; len],
            None => importance.coefficients(receiver, channel).iter().map(|b| b / rho).collect(),
            Some(_) => z[..len].iter().enumerate().map(|(i, z)| if i == 0 { 1.0 + z } else { *z }).collect(),
        };
        let emitted = self.emitted_on(receiver, channel);
        let defect: f64 = phi.iter().zip(emitted).zip(held).map(|((phi, e), t)| phi * (e - t)).sum();
        // The error of the swapped gather.
        let power = (held[0] + lamp).abs() * area;
        let links_error = square(power * self.links_likely_error(importance, nodes_basis, channel, by, true));
        let of_links: f64 = by.0.iter().map(|link| power * self.neglected_by(link, importance, nodes_basis, channel)).sum();
        let mut part = Part { swapped: area * defect, squared_error: links_error, neglected: of_links, ..Part::default() };
        let (mut by_polynomial, mut power_errors_below) = (0.0, BTreeMap::new());
        if rho > 0.0 {
            let residuals = &self.error_estimate.residuals;
            part.unseen += area * phi[0] * (residuals[0][receiver][channel].unseen + residuals[1][receiver][channel].unseen);
            // Where light is even rays and clusters are off alike in both gathers.
            part.squared_error +=
                square(area * rho * phi[0] * self.links_likely_error(&self.radiosity.field, basis, channel, own, false));
            let samples: Vec<f64> =
                self.system.irradiance(&self.radiosity.field, receiver, channel).iter().map(|h| rho * h).collect();
            self.add_details(&mut part, receiver, (&samples, &z), own.1.is_empty().then_some(&excess));
        }
        for &leaf in leaves {
            let (area, mut light) = (self.element(leaf).area(), self.radiosity.field.coefficients(leaf, channel).to_vec());
            light[0] += lamp;
            let power = area * light[0];
            let z = self.restricted(receiver, leaf, above, &z);
            if let Some((element, own)) = self.nearest_below(receiver, leaf, below) {
                let (own, links_error) = &own[channel];
                part.swapped += area * (dot(&light, &self.restricted(element, leaf, basis, own)) - dot(&light, &z));
                *power_errors_below.entry(element).or_insert(0.0) += power * links_error;
            } else {
                by_polynomial += power;
            }
            part.swapped += area * dot(&light, &z);
            if rho > 0.0 && !self.radiosity.direct.is_empty() {
                self.add_details(&mut part, leaf, (&self.direct_samples(leaf, channel), &z), by.1.is_empty().then_some(&excess));
            }
        }
        part.squared_error += square(by_polynomial * rule_error(nodes_basis, &excess));
        part.squared_error += power_errors_below.into_values().map(square).sum::<f64>();
        part
    }

    /// The polynomials of the smallest element around a leaf, or it is, below its receiver that has some.
    fn nearest_below<'a>(
        &self,
        receiver: usize,
        leaf: usize,
        below: &'a HashMap<usize, Vec<Gathered>>,
    ) -> Option<(usize, &'a [Gathered])> {
        let around = std::iter::successors(Some(leaf), |&element| self.element(element).parent());
        around.take_while(|&element| element != receiver).find_map(|element| Some((element, &below.get(&element)?[..])))
    }

    /// Adds the product of the truncations of light and of an importance. Where clusters were gathered from that is noise.
    fn add_details(&self, part: &mut Part, element: usize, (samples, z): (&[f64], &[f64]), sure: Option<&Excess>) {
        let (area, basis) = (self.element(element).area(), self.basis(element));
        let detail = area * dot(&basis.next(samples), z);
        match sure {
            Some(of_importance) => {
                part.detail += detail;
                part.squared_error += square(TYPICAL * area * basis.excess(samples).spread * of_importance.spread);
            }
            None => part.squared_error += square(detail),
        }
    }

    /// A polynomial on a receiver, on a leaf below it.
    fn restricted(&self, receiver: usize, leaf: usize, basis: &Basis, coefficients: &[f64]) -> Vec<f64> {
        let mut path = Vec::new();
        let mut descendant = leaf;
        while descendant != receiver
            && let Some(parent) = self.element(descendant).parent()
        {
            path.push(descendant);
            descendant = parent;
        }
        path.into_iter().rev().fold(coefficients.to_vec(), |held, element| basis.restrict(self.system.mesh.child(element), &held))
    }

    /// The error of rays and clusters of a receiver in a light that it gathers, and of the evaluations of links if they count, in
    /// the mean over its nodes, as if without order.
    fn links_likely_error(
        &self,
        light: &Field,
        basis: &Basis,
        channel: usize,
        (links, far): (&[Link], &Far),
        evaluated: bool,
    ) -> f64 {
        let of_link = |link: &Link| {
            let coefficients = light.coefficients(link.source, channel);
            let row_error = |row: &Row| if evaluated || row.likely.is_some() { row.likely_error_of(coefficients) } else { 0.0 };
            over_nodes(basis, link, row_error)
        };
        let of_links: f64 = links.iter().map(of_link).map(square).sum();
        let of_far = if far.is_empty() { 0.0 } else { far.likely_mean(light, channel, basis) };
        of_links.sqrt().hypot(of_far)
    }

    /// Bound on the light that a link neglects, in the mean over the nodes of its receiver.
    fn neglected_by(&self, link: &Link, light: &Field, basis: &Basis, channel: usize) -> f64 {
        over_nodes(basis, link, |row| light.neglected(&self.system.mesh, link.source, channel, row))
    }
}

/// The mean of a function of a link's rows over the nodes.
fn over_nodes(basis: &Basis, link: &Link, of: impl Fn(&Row) -> f64) -> f64 {
    link.rows.iter().zip(basis.nodes()).map(|(row, node)| node.weight * of(row)).sum()
}

fn square(x: f64) -> f64 {
    x * x
}

#[cfg(test)]
mod tests {
    use radgrad_scene::{Degenerate, Scene};

    use crate::solve::options::Options;
    use crate::solve::solve;

    #[test]
    fn the_estimate_of_the_error_of_the_mean_is_what_a_finer_solution_differs_by() {
        let scene =
            Scene::read(concat!(env!("CARGO_MANIFEST_DIR"), "/../../data/scenes/cornell.obj"), Degenerate::Refuse).unwrap();
        let solved = |error: f64| solve(&scene, &Options { error, ..Options::default() }, |_| true).unwrap();
        let [rough, fine] = [0.2, 0.0005].map(solved);
        // One channel may be right by chance: over all of them.
        let (mut error_size, mut estimated) = (0.0_f64, 0.0_f64);
        for (channel, estimate) in rough.mean_estimate().iter().enumerate() {
            let error = rough.mean()[channel] - fine.mean()[channel];
            println!("channel {channel}: {error:.2e} off, estimate over error {:.2}", estimate.total() / error.abs());
            (error_size, estimated) = (error_size.hypot(error), estimated.hypot(estimate.total()));
        }
        assert!((0.7..5.0).contains(&(estimated / error_size)), "{error_size:e} off, estimated {estimated:e}");
    }
}
