//! The mesh that is cut along shadow lines: a rough solution says what light there is, and the faces are cut where polynomials then fit
//! it best ([`crate::mesh::partition`]).
//!
//! Of lamps kept apart the light at samples is exact, shadows and all; what is reflected is that of the rough solution. Without such
//! lamps there are no shadow lines, and where faces are a thousand or more these are small already: nothing is cut then.

use std::time::Duration;

use radgrad_core::DVec3;
use radgrad_scene::Prepared;

use crate::clock::Clock;
use crate::error::Error;
use crate::field::gathering::irradiance;
use crate::links::cluster::sampled::STEPS;
use crate::links::linking::Linking;
use crate::mesh::partition::{Known, Sample, partition};
use crate::mesh::shadow::{Scenery, lines};
use crate::mesh::shape::Shape;
use crate::mesh::{Mesh, Sight};
use crate::solve::dark;
use crate::solve::options::{Marking, Options};
use crate::solve::served::Served;
use crate::solve::solution::{Solution, for_each};

/// Elements of the rough solution, their degree and what links may neglect.
const ROUGH: usize = 150;
const DEGREE: usize = 2;
const ERROR: f64 = 0.05;

/// Part of the time that it may take.
const PART_OF_TIME: f64 = 0.2;

/// Samples, over all faces together.
const SAMPLES: f64 = 30_000.0;

/// Parts of all faces, at most: all of them are linked with each other.
const MOST_PARTS: usize = 400;

/// The mesh with bases of a degree, cut for the error asked for.
pub(super) fn mesh(ready: &Prepared, options: &Options, degree: usize) -> Result<Mesh, Error> {
    let whole = Mesh::new(&ready.scene, degree)?;
    if whole.clusters().root().is_some() {
        return Ok(whole);
    }
    let time = options.time.map(|time| time.mul_f64(PART_OF_TIME));
    let rough = Options {
        error: ERROR,
        bound: None,
        time,
        uniform: true,
        marking: Marking::Residual,
        linking: Linking::Error,
        most_elements: 1,
        ..*options
    };
    let mut first = Mesh::new(&ready.scene, DEGREE)?;
    while !first.roots().is_empty() && first.leaves().count() < ROUGH {
        let leaves: Vec<usize> = first.leaves().collect();
        leaves.into_iter().try_for_each(|leaf| first.divide(leaf))?;
    }
    let mut solution = dark(ready, &rough, (first, Served::default()), Clock::started())?;
    solution.round(&rough, Duration::ZERO)?;
    if solution.lamps.is_empty() {
        return Ok(whole);
    }
    let faces = solution.known()?;
    let parts = partition(&faces, whole.bases(), MOST_PARTS.min(options.most_elements), options.error);
    Mesh::of_parts(&ready.scene, degree, &parts)
}

impl Solution {
    /// Every face with its shadow lines and with samples of its radiosity, over the mean of each channel.
    fn known(&self) -> Result<Vec<Known>, Error> {
        let reflected = self.reflected_polynomials();
        (0..self.mesh.polygons().len()).map(|face| self.known_of(face, &reflected)).collect()
    }

    /// Coefficients of reflected irradiance on receivers, in each channel.
    fn reflected_polynomials(&self) -> Vec<Vec<Vec<f64>>> {
        let of = |receiver: usize| {
            let basis = self.mesh.basis(receiver);
            let at_nodes = |channel| {
                irradiance(&self.mesh, &self.field, &self.links[receiver], &self.far[receiver], channel, basis.nodes().len())
            };
            (0..self.channels.len()).map(|channel| basis.project(&at_nodes(channel))).collect()
        };
        (0..self.mesh.elements().len()).map(|e| if self.gathers(e) { of(e) } else { Vec::new() }).collect()
    }

    fn known_of(&self, face: usize, reflected: &[Vec<Vec<f64>>]) -> Result<Known, Error> {
        let (mesh, polygon) = (&self.mesh, &self.mesh.polygons()[face]);
        let roots: Vec<usize> = mesh.roots().iter().copied().filter(|&root| mesh.elements()[root].face() == face).collect();
        let parts = roots.iter().map(|&root| mesh.elements()[root].polygon().vertices().to_vec()).collect();
        let mut known = Known { normal: polygon.normal(), parts, lines: Vec::new(), samples: Vec::new() };
        let lamps: Vec<usize> = self.lamps.roots().iter().map(|&root| mesh.elements()[root].face()).collect();
        if lamps.contains(&face) {
            return Ok(known);
        }
        let scenery = Scenery { polygons: mesh.polygons(), index: mesh.index(), lamps: &lamps };
        known.lines = lines(&scenery, face, mesh.convex_parts(face), &self.between(&roots));
        for &root in &roots {
            let points: Vec<DVec3> = self.places(root);
            let indices: Vec<usize> = (0..points.len()).collect();
            known.samples.extend(for_each(&indices, |index| self.sample(face, points[index], reflected))?);
        }
        Ok(known)
    }

    /// For each lamp's root, the faces that may hide it from some elements.
    fn between(&self, roots: &[usize]) -> Vec<Vec<usize>> {
        let of_lamp = |lamp: usize| {
            let sights = roots.iter().map(|&root| &self.direct[root].sights()[lamp]);
            let mut faces: Vec<usize> = sights.flat_map(Sight::faces).copied().collect();
            faces.sort_unstable();
            faces.dedup();
            faces
        };
        (0..self.lamps.roots().len()).map(of_lamp).collect()
    }

    /// Places that cover an element evenly: the first points of the additive recurrence of the plastic number.
    fn places(&self, root: usize) -> Vec<DVec3> {
        let element = &self.mesh.elements()[root];
        let count = (SAMPLES * element.area() / self.mesh.area()).ceil();
        let mut places = Vec::new();
        let mut k = 0.5;
        while k < count {
            let [a, b] = STEPS.map(|step| (step * k).fract());
            let folded = element.shape() == Shape::Triangle && a + b > 1.0;
            places.push(element.point(if folded { [1.0 - a, 1.0 - b] } else { [a, b] }));
            k += 1.0;
        }
        places
    }

    /// Radiosity at a point of a face, over the mean of each channel: 0 in one without light.
    fn sample(&self, face: usize, point: DVec3, reflected: &[Vec<Vec<f64>>]) -> Result<Sample, Error> {
        let mut light = vec![0.0; self.channels.len()];
        if let Some(leaf) = self.mesh.leaf_at(face, point) {
            light = self.direct_at(leaf, point)?;
            let receiver = self.receiver_of(leaf);
            let values = self.mesh.basis(receiver).values(self.mesh.elements()[receiver].reference(point));
            for (light, of_channel) in light.iter_mut().zip(&reflected[receiver]) {
                *light += of_channel.iter().zip(&values).map(|(c, v)| c * v).sum::<f64>();
            }
        }
        let rho = &self.surfaces.reflectance[face];
        for (light, (rho, mean)) in light.iter_mut().zip(rho.iter().zip(&self.mean)) {
            *light = if *mean == 0.0 { 0.0 } else { *light * rho / mean };
        }
        Ok(Sample { point, light })
    }
}
