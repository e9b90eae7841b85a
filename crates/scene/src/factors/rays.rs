//! Factors of very many faces, by rays: an interval each, that holds with a stated probability. None is a bound.
//!
//! Rays leave each face uniformly over its area and by the cosine ([`draw`]), so many from each, and the first face that one meets, from its front,
//! is counted. Each pair makes its factor of the counts:
//!
//! | pair | value | interval |
//! |---|---|---|
//! | spheres around the two meet, and nothing is between them | their exchange in free sight, as [`super::exchange`] has it | its bound |
//! | areas alike | both counts together, over `n/A_i + n/A_j`: each way weighted by the inverse of its variance | of 2 n trials ([`limits`]) |
//! | areas more than [`pairs::ALIKE`] apart | the count from the smaller face, whose factor is the larger one; the other way would add little | of n trials |
//!
//! The exchange is one number a pair, so factors are reciprocal; the open share, that part of its view in which a face sees no other, is 1 less its
//! row, and never below 0. Each pair that was counted is then multiplied by `x_i x_j`, which are next to 1, so that rows and the open shares that
//! rays saw add up to their faces ([`pairs`]): rows of faces that no ray left the scene from sum to 1 up to [`pairs::CLOSED`].
//!
//! The number of rays follows from the error and the confidence that are asked for before any is drawn (M. Pellegrini 1995): the intervals of all pairs and
//! open shares hold together with that confidence. Every count depends on the seed, the face and the scene alone, and sums are taken in the order of faces: so
//! answers do not depend on how many threads or machines the rows were computed on.

pub(crate) mod blocks;
mod bytes;
mod draw;
mod limits;
pub(crate) mod operator;
pub(crate) mod pairs;
#[cfg(test)]
mod tests;

use radgrad_core::{DVec3, Polygon};
use rayon::prelude::*;

use self::draw::{Grid, Source};
use self::pairs::{Counted, Known, Near, RayFactors, short};
use super::{FactorSettings, FormFactors};
use crate::error::Error;
use crate::extremes::largest as larger;
use crate::occluders::shape::Bounds;
use crate::occluders::tree::Tree;

/// Settings of factors by rays.
///
/// ```
/// use radgrad_scene::RaySettings;
/// let settings = RaySettings { tolerance: 0.02, ..RaySettings::default() };
/// // `ln(2 m / (1 - c)) / (2 e^2)` for the m intervals of a thousand faces, and the rays that fill a grid.
/// assert_eq!(settings.rays_for(1000)?, 24_025);
/// # Ok::<(), radgrad_scene::Error>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RaySettings {
    /// Half-width that no interval of a pair's larger factor exceeds.
    pub tolerance: f64,
    /// The probability with which all intervals hold.
    pub confidence: f64,
    /// Rays from each face, in place of as many as the tolerance asks for.
    pub rays: Option<u32>,
    /// The seed of the random numbers.
    pub seed: u64,
}

impl Default for RaySettings {
    /// To 0.01, with a confidence of 0.99.
    fn default() -> Self {
        Self { tolerance: 0.01, confidence: 0.99, rays: None, seed: 1 }
    }
}

impl RaySettings {
    /// Rays from each of so many faces.
    ///
    /// # Errors
    /// If the tolerance is not above 0 and below 1, the confidence not between 0 and 1, no ray is asked for, or more than 2^30 are from a face.
    pub fn rays_for(&self, faces: usize) -> Result<u64, Error> {
        self.grid(faces).map(Grid::rays)
    }

    fn grid(&self, faces: usize) -> Result<Grid, Error> {
        const MOST: f64 = (1_u64 << 30) as f64;
        let is_inside = |value: f64| value > 0.0 && value < 1.0;
        if !is_inside(self.tolerance) {
            return Err(Error::expected("a tolerance above 0 and below 1", self.tolerance.to_string()));
        }
        if !is_inside(self.confidence) {
            return Err(Error::expected("a confidence above 0 and below 1", self.confidence.to_string()));
        }
        let rays = self.rays.map_or_else(|| limits::trials_for(self.tolerance, self.logarithm(faces)), f64::from);
        if !(1.0..=MOST).contains(&rays) {
            let remedy = "ask for a larger tolerance, or for brackets";
            return Err(Error::expected(format!("from 1 to {MOST} rays a face: {remedy}"), rays.to_string()));
        }
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a whole number from 1 to 2^30")]
        Ok(Grid::of(rays as u32))
    }

    /// `ln(2/delta)` where each interval may fail with delta: all pairs and all open shares have a part of 1 less the confidence.
    fn logarithm(&self, faces: usize) -> f64 {
        let intervals = 0.5 * faces as f64 * (faces as f64 + 1.0);
        libm::log(2.0 * larger(intervals, 1.0) / (1.0 - self.confidence))
    }
}

impl FormFactors<'_> {
    /// The middle of each face of the scene, in a unit in which coordinates are up to 1.
    #[must_use]
    pub fn middles(&self) -> Vec<DVec3> {
        self.spheres.iter().map(|sphere| sphere.centre).collect()
    }

    /// The faces that the rays of a range of [`Self::faces`] meet, counted on all cores. `keep` is called with each row, in any order.
    ///
    /// # Errors
    /// If a setting is out of range, or there are not so many rows.
    pub fn count_rays(
        &self,
        block: std::ops::Range<usize>,
        settings: &RaySettings,
        keep: impl Fn(&Counted) + Sync,
    ) -> Result<Vec<Counted>, Error> {
        let sources = self.faces();
        let range = format!("{} to {}", block.start, block.end);
        let faces = sources.get(block).ok_or_else(|| Error::expected(format!("a range of the {} rows", sources.len()), range))?;
        self.count_rays_of(faces, settings, keep)
    }

    /// The same of some faces.
    ///
    /// # Errors
    /// As [`Self::count_rays`].
    pub fn count_rays_of(
        &self,
        faces: &[usize],
        settings: &RaySettings,
        keep: impl Fn(&Counted) + Sync,
    ) -> Result<Vec<Counted>, Error> {
        let sources = self.faces();
        if let Some(face) = faces.iter().find(|face| sources.binary_search(face).is_err()) {
            return Err(Error::expected("faces that have factors", format!("face {face}")));
        }
        let grid = settings.grid(sources.len())?;
        let count = self.emitters.len();
        let mut exchanges = vec![false; count];
        sources.iter().for_each(|&face| exchanges[face] = true);
        let of_face = |(hits, touched): &mut (Vec<u32>, Vec<u32>), &face: &usize| {
            Source::of(self.polygon(face)).rays(grid, (settings.seed, face), |from, toward| {
                let Some((met, _)) = self.index.first_along(from, toward, &[face]) else { return };
                if exchanges[met] && self.polygon(met).normal().dot(toward) < 0.0 {
                    if hits[met] == 0 {
                        touched.push(short(met));
                    }
                    hits[met] += 1;
                }
            });
            touched.sort_unstable();
            let met = touched.drain(..).map(|met| (met, std::mem::take(&mut hits[met as usize]))).collect();
            let counted = Counted { face: short(face), met };
            keep(&counted);
            counted
        };
        Ok(faces.par_iter().with_max_len(1).map_init(|| (vec![0; count], Vec::new()), of_face).collect())
    }

    /// The factors of the counts of all faces, each row once, in any order.
    ///
    /// ```
    /// use radgrad_scene::{Degenerate, FormFactors, RaySettings, Scene};
    /// # let file = concat!(env!("CARGO_MANIFEST_DIR"), "/../../data/scenes/two_blocks.obj");
    /// let scene = Scene::read(file, Degenerate::Refuse)?;
    /// let factors = FormFactors::new(&scene)?;
    /// let settings = RaySettings { rays: Some(1000), ..RaySettings::default() };
    /// let rows = factors.faces().len();
    /// // Two halves, as of two machines.
    /// let halves = [0..rows / 2, rows / 2..rows].map(|rows| factors.count_rays(rows, &settings, |_| ()));
    /// let [mut counted, second] = [halves[0].clone()?, halves[1].clone()?];
    /// counted.extend(second);
    /// let by_rays = factors.by_rays(counted, &settings)?;
    /// for row in by_rays.rows(0..rows) {
    ///     let sum: f64 = row.entries.iter().map(|entry| entry.factor).sum();
    ///     assert!((sum + row.open.factor - 1.0).abs() < 1e-12 && row.open.factor >= 0.0);
    /// }
    /// # Ok::<(), radgrad_scene::Error>(())
    /// ```
    ///
    /// # Errors
    /// If a setting is out of range, a row is missing or there twice, or it has counts that so many rays cannot make.
    pub fn by_rays(&self, counted: Vec<Counted>, settings: &RaySettings) -> Result<RayFactors, Error> {
        let faces = self.faces();
        let (rays, logarithm) = (settings.rays_for(faces.len())?, settings.logarithm(faces.len()));
        let mut rows: Vec<Vec<(u32, u32)>> = vec![Vec::new(); self.emitters.len()];
        let mut is_there = vec![false; rows.len()];
        for Counted { face, met } in counted {
            let at = face as usize;
            let is_new = faces.binary_search(&at).is_ok() && !std::mem::replace(&mut is_there[at], true);
            if !is_new {
                return Err(Error::expected("rows of faces that have factors, each once", format!("one of face {face}")));
            }
            let is_ascending = met.windows(2).all(|two| two[0].0 < two[1].0);
            let are_faces = met.iter().all(|&(to, hits)| to != face && hits > 0 && faces.binary_search(&(to as usize)).is_ok());
            let total: u64 = met.iter().map(|(_, hits)| u64::from(*hits)).sum();
            if !(is_ascending && are_faces && total <= rays) {
                let rule = format!("other faces in their order, met by {rays} rays together at most");
                return Err(Error::expected(rule, format!("{total} rays to {} faces in the row of face {face}", met.len())));
            }
            rows[at] = met;
        }
        if let Some(face) = faces.iter().find(|face| !is_there[**face]) {
            return Err(Error::expected("a row of each face that has factors", format!("none of face {face}")));
        }
        let areas: Vec<f64> = self.scaled.iter().map(Polygon::area).collect();
        let setup = Known { areas, rays, logarithm, confidence: settings.confidence };
        Ok(RayFactors::of(faces, setup, rows, self.near_pairs()))
    }

    /// The exchanges of faces whose spheres meet and that have nothing between them, or see nothing of each other, by the lower face.
    fn near_pairs(&self) -> Vec<Vec<Near>> {
        let faces = self.faces();
        let mut exchanges = vec![false; self.emitters.len()];
        faces.iter().for_each(|&face| exchanges[face] = true);
        let boxes: Vec<Bounds> = self.scaled.iter().map(|polygon| Bounds::of(polygon.vertices())).collect();
        let tree = Tree::over(&boxes);
        let settings = FactorSettings { relative_estimate: 1e-6, estimate: 1e-6, ..FactorSettings::default() };
        let of_face = |(from, own): (usize, &Bounds)| {
            let mut near = Vec::new();
            if !exchanges[from] {
                return near;
            }
            let sphere = self.spheres[from];
            let around = Bounds { low: sphere.centre - sphere.radius, high: sphere.centre + sphere.radius }.and(own);
            tree.near(&around, |to| {
                let other = self.spheres[to];
                let reach = sphere.radius + other.radius;
                if to > from && exchanges[to] && (other.centre - sphere.centre).length_squared() <= reach * reach {
                    near.extend(self.free_exchange([from, to], &settings).map(|[area, error]| Near {
                        face: short(to),
                        area,
                        error,
                    }));
                }
            });
            near.sort_unstable_by_key(|near| near.face);
            near
        };
        boxes.par_iter().enumerate().with_max_len(16).map(of_face).collect()
    }
}
