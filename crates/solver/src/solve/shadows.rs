//! The mesh that is cut along shadow lines: a rough solution gives the light, and the faces are cut where polynomials then fit
//! it best ([`crate::mesh::partition`]).
//!
//! Every sample of the light is a gather: exact for lamps kept apart, shadows and all, and for reflected light as good as the rough solution.
//! Without such lamps there are no shadow lines, and faces of a mesh of [`MOST_PARTS`] parts or more are small already: nothing is cut then.

use std::time::Duration;

use radgrad_core::DVec3;
use radgrad_scene::Prepared;
use rayon::prelude::*;

use crate::clock::Clock;
use crate::error::Error;
use crate::gathering::ratio;
use crate::mesh::outline::Cut;
use crate::mesh::partition::{Known, Sample, partition};
use crate::mesh::shadow::{Scenery, lines};
use crate::mesh::{Mesh, Sight};
use crate::solve::goal_points::GoalPoints;
use crate::solve::options::{Marking, Options};
use crate::solve::solution::Solution;
use crate::solve::{dark, divide_evenly};

/// Elements of the rough solution, their degree and the light that links may neglect.
const ROUGH: usize = 150;
const DEGREE: usize = 2;
const ERROR: f64 = 0.05;

/// Parts of the time that the rough solution may take, and after which nothing more is cut.
const PART_OF_TIME: f64 = 0.2;
const CUTS: f64 = 0.4;

/// Parts of all faces, at most: all of them are linked with each other.
const MOST_PARTS: usize = 400;

/// The mesh with bases of a degree, cut for the error asked for.
pub(super) fn mesh(ready: &Prepared, options: &Options, degree: usize) -> Result<Mesh, Error> {
    // The cuts that shadows need are made here, and no more.
    let whole = Mesh::cut(&ready.scene, degree, Cut::Parts(&[]))?;
    if whole.clusters().root().is_some() || whole.roots().len() >= MOST_PARTS {
        return Ok(whole);
    }
    let started = Clock::started();
    let time = options.time.map(|time| time.mul_f64(PART_OF_TIME));
    let rough = Options { error: ERROR, time, marking: Marking::Residual, most_elements: 1, ..*options };
    let mut first = Mesh::cut(&ready.scene, DEGREE, Cut::Parts(&[]))?;
    divide_evenly(&mut first, ROUGH)?;
    let mut solution = dark(ready, &rough, (first, GoalPoints::default()), Clock::started())?;
    solution.round(&rough, Duration::ZERO)?;
    if solution.system.lamps.is_empty() {
        return Ok(whole);
    }
    let faces: Vec<Known> = (0..solution.system.mesh.polygons().len()).map(|face| solution.with_shadow_lines(face)).collect();
    let max_parts = MOST_PARTS.min(options.most_elements);
    let is_late = || options.time.is_some_and(|time| started.elapsed() > time.mul_f64(CUTS));
    let light = |face: usize, places: &[DVec3]| {
        let samples = places.par_iter().map(|&place| solution.sample(face, place));
        if is_late() { Ok(None) } else { samples.collect::<Result<_, Error>>().map(Some) }
    };
    let parts = partition(&faces, whole.bases(), (max_parts, options.error), &light)?;
    Mesh::cut(&ready.scene, degree, Cut::Parts(&parts))
}

impl Solution {
    /// A face with its shadow lines.
    fn with_shadow_lines(&self, face: usize) -> Known {
        let (mesh, normal) = (&self.system.mesh, self.system.mesh.polygons()[face].normal());
        let roots: Vec<usize> = mesh.roots().iter().copied().filter(|&root| mesh.elements()[root].face() == face).collect();
        let parts = roots.iter().map(|&root| mesh.elements()[root].polygon().vertices().to_vec()).collect();
        let lamps: Vec<usize> = self.system.lamps.roots().iter().map(|&root| mesh.elements()[root].face()).collect();
        let stays = lamps.contains(&face);
        let scenery = Scenery { polygons: mesh.polygons(), index: mesh.index(), lamps: &lamps };
        let lines = if stays { Vec::new() } else { lines(&scenery, face, mesh.convex_parts(face), &self.between(&roots)) };
        Known { normal, parts, lines, stays }
    }

    /// For each lamp's root, the faces that may hide it from some elements.
    fn between(&self, roots: &[usize]) -> Vec<Vec<usize>> {
        let of_lamp = |lamp: usize| {
            let sights = roots.iter().map(|&root| &self.radiosity.direct[root].sights()[lamp]);
            let mut faces: Vec<usize> = sights.flat_map(Sight::faces).copied().collect();
            faces.sort_unstable();
            faces.dedup();
            faces
        };
        (0..self.system.lamps.roots().len()).map(of_lamp).collect()
    }

    /// Radiosity at a point of a face, over the mean of each channel: 0 in one without light.
    fn sample(&self, face: usize, point: DVec3) -> Result<Sample, Error> {
        let light = match self.system.mesh.leaf_at(face, point) {
            Some(leaf) => self.radiosity_on(leaf, point)?,
            None => vec![0.0; self.channels().len()],
        };
        Ok(Sample { point, light: light.iter().zip(&self.radiosity.mean).map(|(&light, &mean)| ratio(light, mean)).collect() })
    }
}
