//! Pixels that share gathers: where a square of pixels shows few faces and the light on each is bilinear, as more gathers inside the square
//! tell, its pixels are interpolated; else it is divided, down to a gather a pixel and face. So edges of shadows have a gather a pixel,
//! and edges of faces the share of each.

use std::collections::HashMap;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, PoisonError};

use radgrad_core::DVec3;
use radgrad_scene::{Occluders, contains, largest, smallest};
use radgrad_solver::{Error, Ledger, Solution};
use rayon::prelude::*;

use super::camera::Camera;
use super::{Failure, Pixel, offset};

/// Pixels along a square that is drawn by itself, of a small picture and of others: gathers along its sides are made again beside it.
const TILES: [usize; 2] = [16, 64];
const SMALL: usize = 256;

/// Pixels along a square that may be interpolated: a thing smaller than half of it may be missed where it has no edge of a face.
const LARGEST: usize = 8;

/// How far gathers may be off the bilinear function through the corners of their square, over the value and a part of the mean.
const OFF: f64 = 0.015;
const DARK: f64 = 0.25;

/// Faces that a square of pixels may show to be interpolated.
const FACES: usize = 3;

/// How often a picture is written while it is drawn.
const PARTS: usize = 16;

/// A ray that meets nothing, or the back of a face.
const NOTHING: u32 = u32::MAX;

/// The solved scene that is looked at, and the camera.
pub(super) struct Scene<'a> {
    pub(super) solution: &'a Solution,
    pub(super) camera: &'a Camera,
    pub(super) size: [usize; 2],
    pub(super) samples: usize,
    pub(super) index: &'a Occluders,
    /// Set where the work is to end.
    pub(super) stop: &'a AtomicBool,
}

/// Draws all pixels; `done` is told of so many, and `save` gets the picture with the pixels that are done at each of [`PARTS`] of it.
pub(super) fn draw(
    scene: &Scene<'_>,
    done: impl Fn(usize) + Sync,
    save: &(dyn Fn(&[Pixel]) -> Result<(), Failure> + Sync),
) -> Result<Vec<Pixel>, Failure> {
    let [width, height] = scene.size;
    let side = TILES[usize::from(width.min(height) >= SMALL)];
    let across = width.div_ceil(side);
    let tiles: Vec<[usize; 2]> = (0..across * height.div_ceil(side)).map(|k| [k % across * side, k / across * side]).collect();
    let (count, channels) = (tiles.len(), scene.solution.channels().len());
    let picture = Mutex::new((0, (0..width * height).map(|_| Pixel::dark(channels)).collect::<Vec<_>>()));
    tiles.into_par_iter().try_for_each(|corner @ [left, top]| {
        let mut tile = Tile::new(scene, corner, side);
        let [w, h] = tile.size;
        tile.square(corner, side)?;
        done(w * h);
        let mut picture = picture.lock().unwrap_or_else(PoisonError::into_inner);
        for (k, pixel) in tile.pixels.into_iter().enumerate() {
            picture.1[(top + k / w) * width + left + k % w] = pixel;
        }
        picture.0 += 1;
        let is_part = picture.0 < count && picture.0 * PARTS / count > (picture.0 - 1) * PARTS / count;
        if is_part { save(&picture.1) } else { Ok(()) }
    })?;
    Ok(picture.into_inner().unwrap_or_else(PoisonError::into_inner).1)
}

/// A square of the picture.
struct Tile<'a> {
    scene: &'a Scene<'a>,
    corner: [usize; 2],
    size: [usize; 2],
    /// The faces that the rays of each pixel meet.
    met: Vec<Vec<u32>>,
    /// Gathers at corners of pixels, of a face.
    gathers: HashMap<(usize, usize, u32), Option<Pixel>>,
    pixels: Vec<Pixel>,
}

impl<'a> Tile<'a> {
    fn new(scene: &'a Scene<'a>, corner: [usize; 2], side: usize) -> Self {
        let size = [0, 1].map(|k| side.min(scene.size[k] - corner[k]));
        let eye = scene.solution.placement().inward(scene.camera.eye);
        let polygons = scene.solution.mesh().polygons();
        let met = |pixel: usize| {
            let at = [corner[0] + pixel % size[0], corner[1] + pixel / size[0]];
            let ray = |sample: usize| {
                let direction = scene.camera.direction(at, offset(sample, scene.samples), scene.size);
                match scene.index.first_along(eye, direction, &[]) {
                    Some((face, _)) if polygons[face].normal().dot(direction) < 0.0 => u32::try_from(face).unwrap_or(NOTHING),
                    _ => NOTHING,
                }
            };
            (0..scene.samples).map(ray).collect()
        };
        let channels = scene.solution.channels().len();
        let count = size[0] * size[1];
        let pixels = (0..count).map(|_| Pixel::dark(channels)).collect();
        Self { scene, corner, size, met: (0..count).map(met).collect(), gathers: HashMap::new(), pixels }
    }

    fn index(&self, [x, y]: [usize; 2]) -> usize {
        (y - self.corner[1]) * self.size[0] + x - self.corner[0]
    }

    /// Draws the pixels of a square that are in the tile.
    fn square(&mut self, corner: [usize; 2], side: usize) -> Result<(), Failure> {
        let end = [0, 1].map(|k| (corner[k] + side).min(self.corner[k] + self.size[k]));
        if corner[0] >= end[0] || corner[1] >= end[1] {
            return Ok(());
        }
        if side == 1 {
            return self.pixel(corner);
        }
        let is_whole = end[0] - corner[0] == side && end[1] - corner[1] == side;
        let places = (corner[1]..end[1]).flat_map(|y| (corner[0]..end[0]).map(move |x| [x, y]));
        let mut faces: Vec<u32> = places.flat_map(|place| self.met[self.index(place)].iter().copied()).collect();
        faces.sort_unstable();
        faces.dedup();
        faces.retain(|&face| face != NOTHING);
        if faces.is_empty() {
            return Ok(());
        }
        if is_whole && faces.len() <= FACES && side <= LARGEST && self.interpolate(corner, side, &faces)? {
            return Ok(());
        }
        let half = side / 2;
        for [x, y] in [[0, 0], [half, 0], [0, half], [half, half]] {
            self.square([corner[0] + x, corner[1] + y], half)?;
        }
        Ok(())
    }

    /// Interpolates a square of few faces, if the light on each allows that.
    fn interpolate(&mut self, [left, top]: [usize; 2], side: usize, faces: &[u32]) -> Result<bool, Failure> {
        let mut planes: Vec<(u32, Vec<Pixel>, Vec<f64>)> = Vec::new();
        for &face in faces {
            let places = if side > 2 { side / 2 } else { side };
            let count = side / places + 1;
            let mut corners: Vec<Pixel> = Vec::new();
            for k in 0..count * count {
                let at = [left + k % count * places, top + k / count * places];
                // Two pixels are the least square, and take only gathers that were made for a larger one.
                let gather =
                    if side > 2 { self.at_corner(at, face)? } else { self.gathers.get(&(at[0], at[1], face)).cloned().flatten() };
                match gather {
                    Some(pixel) => corners.push(pixel),
                    None => return Ok(false),
                }
            }
            match self.off(&corners) {
                Some(off) => planes.push((face, corners, off)),
                None => return Ok(false),
            }
        }
        for y in 0..side {
            for x in 0..side {
                let index = self.index([left + x, top + y]);
                let mut pixel = Pixel::dark(self.scene.solution.channels().len());
                for (face, corners, off) in &planes {
                    let rays = self.met[index].iter().filter(|met| *met == face).count();
                    if rays > 0 {
                        let share = rays as f64 / self.met[index].len() as f64;
                        let [u, v] = [x, y].map(|place| (place as f64 + 0.5) / side as f64);
                        pixel.add(&between(corners, [u, v], off), share);
                    }
                }
                self.pixels[index] = pixel;
            }
        }
        Ok(true)
    }

    /// The largest distance in each channel of gathers inside a square from the means of those at its corners, if it is small enough; of a
    /// square of corners alone a quarter of their differences.
    fn off(&self, gathers: &[Pixel]) -> Option<Vec<f64>> {
        let means = self.scene.solution.mean();
        let mut distances = vec![0.0; means.len()];
        for (channel, mean) in means.iter().enumerate() {
            let value = |k: usize| gathers[k].radiosity[channel];
            let all = || (0..gathers.len()).map(value);
            let distance = if gathers.len() == 9 {
                let inside = [(1, &[0, 2][..]), (3, &[0, 6]), (5, &[2, 8]), (7, &[6, 8]), (4, &[0, 2, 6, 8])];
                let off = |(middle, around): (usize, &[usize])| {
                    (value(middle) - around.iter().map(|&k| value(k)).sum::<f64>() / around.len() as f64).abs()
                };
                inside.map(off).into_iter().fold(0.0, largest)
            } else {
                0.25 * (all().fold(f64::NEG_INFINITY, largest) - all().fold(f64::INFINITY, smallest))
            };
            let least = all().fold(f64::INFINITY, smallest);
            let is_within = distance <= OFF * (least.abs() + DARK * mean);
            if !is_within {
                return None;
            }
            distances[channel] = distance;
        }
        Some(distances)
    }

    /// A gather at the upper left corner of a pixel, on the plane of a face; none beside the face.
    fn at_corner(&mut self, at: [usize; 2], face: u32) -> Result<Option<Pixel>, Failure> {
        let key = (at[0], at[1], face);
        if let Some(known) = self.gathers.get(&key) {
            return Ok(known.clone());
        }
        let gather = self.gather(at, [0.0; 2], face)?;
        self.gathers.insert(key, gather.clone());
        Ok(gather)
    }

    /// Each face of a pixel, gathered in the middle of the places where rays meet it.
    fn pixel(&mut self, at: [usize; 2]) -> Result<(), Failure> {
        let index = self.index(at);
        let mut faces = self.met[index].clone();
        faces.sort_unstable();
        faces.dedup();
        let rays = self.met[index].len() as f64;
        let mut sum = Pixel::dark(self.scene.solution.channels().len());
        for face in faces.into_iter().filter(|&face| face != NOTHING) {
            let own: Vec<[f64; 2]> = (0..self.met[index].len())
                .filter(|&ray| self.met[index][ray] == face)
                .map(|ray| offset(ray, self.scene.samples))
                .collect();
            let count = own.len() as f64;
            let middle = [0, 1].map(|k| own.iter().map(|place| place[k]).sum::<f64>() / count);
            let gathered = match self.gather(at, middle, face)? {
                None => self.gather(at, own[0], face)?,
                found => found,
            };
            if let Some(gathered) = gathered {
                sum.add(&gathered, count / rays);
            }
        }
        self.pixels[index] = sum;
        Ok(())
    }

    fn gather(&self, at: [usize; 2], within: [f64; 2], face: u32) -> Result<Option<Pixel>, Failure> {
        let Scene { solution, camera, size, stop, .. } = self.scene;
        if stop.load(Ordering::Relaxed) {
            return Err(Failure::Stopped);
        }
        let eye = solution.placement().inward(camera.eye);
        let direction = camera.direction(at, within, *size);
        let face = face as usize;
        let Some(point) = meeting(solution, face, [eye, direction]) else { return Ok(None) };
        let Some(leaf) = solution.mesh().leaf_at(face, point) else { return Ok(None) };
        Ok(Some(gathered(solution, leaf, point)?))
    }
}

/// The bilinear function through four or nine gathers of a square at a place of it, with the distances of these from it.
fn between(gathers: &[Pixel], place: [f64; 2], off: &[f64]) -> Pixel {
    let count = if gathers.len() == 9 { 2 } else { 1 };
    let [u, v] = place.map(|place| place * count as f64);
    let [i, j] = [u, v].map(|place| usize::from(place >= 1.0 && count == 2));
    let (u, v) = (u - i as f64, v - j as f64);
    let weights = [(1.0 - u) * (1.0 - v), u * (1.0 - v), (1.0 - u) * v, u * v];
    let mut pixel = Pixel::dark(off.len());
    (0..4).for_each(|k| pixel.add(&gathers[(j + k / 2) * (count + 1) + i + k % 2], weights[k]));
    pixel.estimate.iter_mut().zip(off).for_each(|(estimate, off)| *estimate += off);
    pixel
}

/// Where a ray meets the plane of a face, if that is on the face.
fn meeting(solution: &Solution, face: usize, [eye, direction]: [DVec3; 2]) -> Option<DVec3> {
    let polygon = &solution.mesh().polygons()[face];
    let (normal, corner) = (polygon.normal(), polygon.vertices()[0]);
    let point = eye + direction * (normal.dot(corner - eye) / normal.dot(direction));
    (point.is_finite() && contains(polygon.vertices(), normal, point)).then_some(point)
}

/// An exact gather as a pixel.
pub(super) fn gathered(solution: &Solution, leaf: usize, point: DVec3) -> Result<Pixel, Error> {
    let gathered = solution.gather_on(leaf, point)?;
    let estimate = gathered.estimate.iter().map(Ledger::total).collect();
    Ok(Pixel { radiosity: gathered.radiosity, estimate, irradiance: gathered.irradiance.irradiance, light: 0.0 }
        .of(solution, leaf))
}
