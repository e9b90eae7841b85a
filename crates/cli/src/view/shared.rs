//! Pixels that share gathers: where a square of pixels shows few faces and the light on each is bilinear, as more gathers inside the square
//! tell, its pixels are interpolated; else it is divided, down to a gather a pixel and face. On a face that ends in the square the light is the
//! plane that fits gathers at its outermost pixels best, if that is near to all of them.
//!
//! The direct light of lamps has the edges of shadows, and costs one closed form a lamp; the remainder has none that are sharp, and costs a
//! gather over the whole scene. So they are shared apart: the direct light in squares that are smaller and more often divided.

use std::collections::HashMap;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, PoisonError};

use radgrad_core::DVec3;
use radgrad_scene::{Occluders, contains, largest, smallest};
use radgrad_solver::{Gathered, Ledger, PictureGathers, Solution};
use rayon::prelude::*;

use super::camera::Camera;
use super::{Failure, Pixel, offset};

/// Pixels along a square that is drawn by itself, of a small picture and of others: gathers along its sides are made again beside it.
const TILES: [usize; 2] = [16, 64];
const SMALL: usize = 256;

/// Pixels along a square that may be interpolated, of each layer of light: a thing smaller than half of it may be missed where it has no edge
/// of a face.
const LARGEST_SQUARE: [usize; 2] = [16, 4];

/// The layers: all but the direct light of lamps, and that.
const REST: usize = 0;
const LAMPS: usize = 1;

/// Tolerance of an interpolated layer, relative to the value plus a part of the picture's mean; and the part of that tolerance that a plane may
/// use, which does not join those of the squares beside it.
const TOLERANCE: f64 = 0.01;
const OF_THE_MEAN: f64 = 0.25;
const ON_PLANES: f64 = 0.5;

/// Pixels of a face, and pixels along a square, from which on a plane costs less than a gather each.
const LEAST_PIXELS: usize = 8;
const LEAST_SIDE: usize = 4;

/// The part of the spread of places that is added to it in every direction.
const RIDGE: f64 = 1e-3;

/// Faces that a square of pixels may show to be interpolated.
const MOST_FACES: usize = 4;

/// How often a picture is written while it is drawn.
const PARTS: usize = 16;

/// A ray that meets nothing, or the back of a face.
const NOTHING: u32 = u32::MAX;

/// The solved scene that is looked at, and the camera.
pub(super) struct Scene<'a> {
    pub(super) solution: &'a Solution,
    pub(super) gathers: PictureGathers<'a>,
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
        tile.square(corner, side, None)?;
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
    hits: Vec<Vec<u32>>,
    /// For each layer, the light at corners of pixels, of a face.
    corners: [HashMap<(usize, usize, u32), Option<Pixel>>; 2],
    pixels: Vec<Pixel>,
}

/// The light of a layer on a face in a square of pixels: its values at some places, and the misfit in each channel.
struct Light {
    face: u32,
    places: Places,
    values: Vec<Pixel>,
    misfits: Vec<f64>,
}

/// Where values are.
enum Places {
    /// On a grid of so many a side, in a square.
    Grid { corner: [usize; 2], side: usize, count: usize },
    /// Anywhere: the plane that fits all best.
    Plane(Vec<[f64; 2]>),
}

impl<'a> Tile<'a> {
    fn new(scene: &'a Scene<'a>, corner: [usize; 2], side: usize) -> Self {
        let size = [0, 1].map(|k| side.min(scene.size[k] - corner[k]));
        let eye = scene.solution.placement().inward(scene.camera.eye);
        let polygons = scene.solution.mesh().polygons();
        let hits = |pixel: usize| {
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
        Self { scene, corner, size, hits: (0..count).map(hits).collect(), corners: Default::default(), pixels }
    }

    fn index(&self, [x, y]: [usize; 2]) -> usize {
        (y - self.corner[1]) * self.size[0] + x - self.corner[0]
    }

    /// Draws the pixels of a square that are in the tile, with all but the direct light of lamps where a larger one has that.
    fn square(&mut self, corner: [usize; 2], side: usize, indirect: Option<&[Light]>) -> Result<(), Failure> {
        let end = [0, 1].map(|k| (corner[k] + side).min(self.corner[k] + self.size[k]));
        if corner[0] >= end[0] || corner[1] >= end[1] {
            return Ok(());
        }
        if side == 1 {
            return self.pixel(corner, indirect.unwrap_or_default());
        }
        let is_whole = end[0] - corner[0] == side && end[1] - corner[1] == side;
        let places = (corner[1]..end[1]).flat_map(|y| (corner[0]..end[0]).map(move |x| [x, y]));
        let mut faces: Vec<u32> = places.flat_map(|place| self.hits[self.index(place)].iter().copied()).collect();
        faces.sort_unstable();
        faces.dedup();
        faces.retain(|&face| face != NOTHING);
        if faces.is_empty() {
            return Ok(());
        }
        let may_share = |layer: usize| is_whole && faces.len() <= MOST_FACES && side <= LARGEST_SQUARE[layer];
        let fresh = if indirect.is_none() && may_share(REST) { self.shared(REST, (corner, side), &faces, &[])? } else { None };
        let indirect = indirect.or(fresh.as_deref());
        if let Some(rest) = indirect.filter(|_| may_share(LAMPS))
            && let Some(lamps) = self.shared(LAMPS, (corner, side), &faces, rest)?
        {
            for at in (0..side * side).map(|k| [corner[0] + k % side, corner[1] + k / side]) {
                let index = self.index(at);
                self.pixels[index] = self.shown(at, |_, face, middle| {
                    let mut pixel = Pixel::dark(self.scene.solution.channels().len());
                    for light in rest.iter().chain(&lamps).filter(|light| light.face == face) {
                        pixel.add(&light.pixel(middle), 1.0);
                    }
                    Ok(Some(pixel))
                })?;
            }
            return Ok(());
        }
        let half = side / 2;
        for [x, y] in [[0, 0], [half, 0], [0, half], [half, half]] {
            self.square([corner[0] + x, corner[1] + y], half, indirect)?;
        }
        Ok(())
    }

    /// The light of a layer on each face that a square shows, if it can be shared, given the light of the other layer.
    fn shared(
        &mut self,
        layer: usize,
        (corner, side): ([usize; 2], usize),
        faces: &[u32],
        rest: &[Light],
    ) -> Result<Option<Vec<Light>>, Failure> {
        let mut shared = Vec::with_capacity(faces.len());
        for &face in faces {
            let light = match self.grid(layer, (corner, side), face)? {
                None => self.plane(layer, (corner, side), face)?,
                light => light,
            };
            let below = rest.iter().filter(|light| light.face == face).flat_map(|light| &light.values);
            match light.and_then(|light| light.accepted(self.scene.solution.mean(), below)) {
                Some(light) => shared.push(light),
                None => return Ok(None),
            }
        }
        Ok(Some(shared))
    }

    /// The light of a layer on a face that is at all corners of a square.
    fn grid(&mut self, layer: usize, (corner, side): ([usize; 2], usize), face: u32) -> Result<Option<Light>, Failure> {
        let step = if side > 2 { side / 2 } else { side };
        let count = side / step + 1;
        let mut values = Vec::with_capacity(count * count);
        for at in (0..count * count).map(|k| [corner[0] + k % count * step, corner[1] + k / count * step]) {
            let key = (at[0], at[1], face);
            let value = match self.corners[layer].get(&key) {
                Some(value) => value.clone(),
                // Two pixels are the least square, and take only values that a larger one has.
                None if side == 2 => None,
                None => {
                    let light = self.light(layer, at.map(|place| place as f64), face)?;
                    self.corners[layer].entry(key).or_insert(light).clone()
                }
            };
            match value {
                Some(value) => values.push(value),
                None => return Ok(None),
            }
        }
        Ok(Some(Light { face, places: Places::Grid { corner, side, count }, values, misfits: Vec::new() }))
    }

    /// The light of a layer on a face that ends in a square: at its outermost pixels and in its middle.
    fn plane(&self, layer: usize, (corner, side): ([usize; 2], usize), face: u32) -> Result<Option<Light>, Failure> {
        let pixels = (0..side * side).map(|k| [corner[0] + k % side, corner[1] + k / side]);
        let own: Vec<[usize; 2]> = pixels.filter(|&at| self.hits[self.index(at)].contains(&face)).collect();
        if side < LEAST_SIDE || own.len() < LEAST_PIXELS {
            return Ok(None);
        }
        let count = own.len() as f64;
        let centre = [0, 1].map(|k| own.iter().map(|at| at[k] as f64).sum::<f64>() / count);
        let ways = [[1.0, 1.0], [1.0, -1.0], [-1.0, 1.0], [-1.0, -1.0]];
        let from_centre = |at: &[usize; 2]| [0, 1].map(|k| at[k] as f64 - centre[k]);
        let least = |key: &dyn Fn([f64; 2]) -> f64| own.iter().min_by(|a, b| key(from_centre(a)).total_cmp(&key(from_centre(b))));
        let outermost = ways.iter().filter_map(|way| least(&|[x, y]| way[0] * x + way[1] * y));
        let mut chosen: Vec<[usize; 2]> = outermost.chain(least(&|[x, y]| x * x + y * y)).copied().collect();
        chosen.sort_unstable();
        chosen.dedup();
        let (mut places, mut values) = (Vec::new(), Vec::new());
        for at in chosen {
            let Some((place, value)) = self.in_pixel(layer, at, face)? else { return Ok(None) };
            places.push(place);
            values.push(value);
        }
        Ok(Some(Light { face, places: Places::Plane(places), values, misfits: Vec::new() }))
    }

    /// Gathers each face of a pixel in the middle of its hits, and takes the indirect light of a larger square where there is one.
    fn pixel(&mut self, at: [usize; 2], indirect: &[Light]) -> Result<(), Failure> {
        let index = self.index(at);
        self.pixels[index] = self.shown(at, |at, face, middle| {
            let Some((_, mut pixel)) = self.in_pixel(LAMPS, at, face)? else { return Ok(None) };
            match indirect.iter().find(|light| light.face == face) {
                Some(light) => pixel.add(&light.pixel(middle), 1.0),
                None => self.in_pixel(REST, at, face)?.iter().for_each(|(_, light)| pixel.add(light, 1.0)),
            }
            Ok(Some(pixel))
        })?;
        Ok(())
    }

    /// A pixel of its faces, each by its part of the rays.
    fn shown(
        &self,
        at: [usize; 2],
        light: impl Fn([usize; 2], u32, [f64; 2]) -> Result<Option<Pixel>, Failure>,
    ) -> Result<Pixel, Failure> {
        let hits = &self.hits[self.index(at)];
        let mut faces = hits.clone();
        faces.sort_unstable();
        faces.dedup();
        let mut sum = Pixel::dark(self.scene.solution.channels().len());
        for face in faces.into_iter().filter(|&face| face != NOTHING) {
            let (middle, share) = self.middle(at, face);
            if let Some(pixel) = light(at, face, middle)? {
                sum.add(&pixel, share);
            }
        }
        Ok(sum)
    }

    /// Where the rays of a pixel that meet a face do in the mean, and their part of all.
    fn middle(&self, at: [usize; 2], face: u32) -> ([f64; 2], f64) {
        let hits = &self.hits[self.index(at)];
        let own = || (0..hits.len()).filter(|&ray| hits[ray] == face);
        let count = own().count() as f64;
        let mean = |k: usize| own().map(|ray| offset(ray, self.scene.samples)[k]).sum::<f64>() / count;
        ([0, 1].map(|k| at[k] as f64 + mean(k)), count / hits.len() as f64)
    }

    /// The light of a layer on a face of a pixel, and where.
    fn in_pixel(&self, layer: usize, at: [usize; 2], face: u32) -> Result<Option<([f64; 2], Pixel)>, Failure> {
        let first = self.hits[self.index(at)].iter().position(|&hit| hit == face);
        let first = first.map(|ray| offset(ray, self.scene.samples)).map(|within| [0, 1].map(|k| at[k] as f64 + within[k]));
        for place in std::iter::once(self.middle(at, face).0).chain(first) {
            if let Some(light) = self.light(layer, place, face)? {
                return Ok(Some((place, light)));
            }
        }
        Ok(None)
    }

    /// The light of a layer at a place of the picture, on the plane of a face; none beside the face.
    fn light(&self, layer: usize, place: [f64; 2], face: u32) -> Result<Option<Pixel>, Failure> {
        let Scene { solution, gathers, camera, size, stop, .. } = self.scene;
        if stop.load(Ordering::Relaxed) {
            return Err(Failure::Stopped);
        }
        let eye = solution.placement().inward(camera.eye);
        let direction = camera.direction([0; 2], place, *size);
        let face = face as usize;
        let Some(point) = meeting(solution, face, [eye, direction]) else { return Ok(None) };
        let Some(leaf) = solution.mesh().leaf_at(face, point) else { return Ok(None) };
        let [radiosity, irradiance] = gathers.from_lamps(leaf, point)?;
        let lamps = Pixel { radiosity, irradiance, ..Pixel::dark(solution.channels().len()) };
        if layer == LAMPS {
            return Ok(Some(lamps));
        }
        let mut indirect = gathered(solution, leaf, gathers.gather_on(leaf, point)?);
        let less = |whole: &mut [f64], part: &[f64]| whole.iter_mut().zip(part).for_each(|(whole, part)| *whole -= part);
        less(&mut indirect.radiosity, &lamps.radiosity);
        less(&mut indirect.irradiance, &lamps.irradiance);
        Ok(Some(indirect))
    }
}

impl Light {
    /// This light with its misfit, if that is within the tolerance: relative to its least value, with that of the light below it, and to the mean.
    fn accepted<'b>(mut self, means: &[f64], below: impl Iterator<Item = &'b Pixel> + Clone) -> Option<Self> {
        let part = if matches!(self.places, Places::Plane(_)) { ON_PLANES * TOLERANCE } else { TOLERANCE };
        for (channel, mean) in means.iter().enumerate() {
            let radiosity = |pixel: &Pixel| pixel.radiosity[channel];
            let least = self.values.iter().map(radiosity).fold(f64::INFINITY, smallest);
            let under = below.clone().map(radiosity).reduce(smallest).unwrap_or(0.0);
            let misfit = self.misfit(channel);
            let is_within = misfit <= part * ((least + under).abs() + OF_THE_MEAN * mean);
            if !is_within {
                return None;
            }
            self.misfits.push(misfit);
        }
        Some(self)
    }

    /// The largest distance in a channel of values from a plane, or of those inside a square from the means of those at its corners; of a square
    /// of corners alone a quarter of their differences.
    fn misfit(&self, channel: usize) -> f64 {
        let value = |k: usize| self.values[k].radiosity[channel];
        let values = || (0..self.values.len()).map(value);
        match &self.places {
            Places::Grid { count: 3, .. } => {
                let inside = [(1, &[0, 2][..]), (3, &[0, 6]), (5, &[2, 8]), (7, &[6, 8]), (4, &[0, 2, 6, 8])];
                let distance = |(middle, around): (usize, &[usize])| {
                    (value(middle) - around.iter().map(|&k| value(k)).sum::<f64>() / around.len() as f64).abs()
                };
                inside.map(distance).into_iter().fold(0.0, largest)
            }
            Places::Grid { .. } => 0.25 * (values().fold(f64::NEG_INFINITY, largest) - values().fold(f64::INFINITY, smallest)),
            Places::Plane(places) => {
                let distance = |(k, place): (usize, &[f64; 2])| {
                    let fit: f64 = self.weights(*place).into_iter().map(|(at, weight)| weight * value(at)).sum();
                    (fit - value(k)).abs()
                };
                places.iter().enumerate().map(distance).fold(0.0, largest)
            }
        }
    }

    /// The value at a place of the picture; the misfit counts in its estimate.
    fn pixel(&self, place: [f64; 2]) -> Pixel {
        let mut pixel = Pixel::dark(self.misfits.len());
        self.weights(place).into_iter().for_each(|(k, weight)| pixel.add(&self.values[k], weight));
        pixel.estimate.iter_mut().zip(&self.misfits).for_each(|(estimate, misfit)| *estimate += misfit);
        pixel
    }

    /// The weights of values at a place.
    fn weights(&self, place: [f64; 2]) -> Vec<(usize, f64)> {
        match &self.places {
            &Places::Grid { corner, side, count } => {
                let [u, v] = [0, 1].map(|k| (place[k] - corner[k] as f64) / side as f64 * (count - 1) as f64);
                let [i, j] = [u, v].map(|place| usize::from(place >= 1.0 && count == 3));
                let (u, v) = (u - i as f64, v - j as f64);
                let weights = [(1.0 - u) * (1.0 - v), u * (1.0 - v), (1.0 - u) * v, u * v];
                (0..4).map(|k| ((j + k / 2) * count + i + k % 2, weights[k])).collect()
            }
            Places::Plane(places) => {
                let count = places.len() as f64;
                let centre = [0, 1].map(|k| places.iter().map(|place| place[k]).sum::<f64>() / count);
                let [x, y] = [0, 1].map(|k| place[k] - centre[k]);
                let from_centre = |k: usize| [places[k][0] - centre[0], places[k][1] - centre[1]];
                let sum = |term: fn([f64; 2]) -> f64| (0..places.len()).map(|k| term(from_centre(k))).sum::<f64>();
                let [xx, xy, yy] = [sum(|[x, _]| x * x), sum(|[x, y]| x * y), sum(|[_, y]| y * y)];
                // In a line, they tell nothing of light across it.
                let little = RIDGE * (xx + yy);
                let [xx, yy] = [xx + little, yy + little];
                let det = xx * yy - xy * xy;
                let weight = |k: usize| {
                    let [a, b] = from_centre(k);
                    let slope = if det > 0.0 { (x * (yy * a - xy * b) + y * (xx * b - xy * a)) / det } else { 0.0 };
                    (k, 1.0 / count + slope)
                };
                (0..places.len()).map(weight).collect()
            }
        }
    }
}

/// Where a ray meets the plane of a face, if that is on the face.
fn meeting(solution: &Solution, face: usize, [eye, direction]: [DVec3; 2]) -> Option<DVec3> {
    let polygon = &solution.mesh().polygons()[face];
    let (normal, corner) = (polygon.normal(), polygon.vertices()[0]);
    let point = eye + direction * (normal.dot(corner - eye) / normal.dot(direction));
    (point.is_finite() && contains(polygon.vertices(), normal, point)).then_some(point)
}

/// A gather as a pixel.
pub(super) fn gathered(solution: &Solution, leaf: usize, gathered: Gathered) -> Pixel {
    let estimate = gathered.estimate.iter().map(Ledger::total).collect();
    Pixel { radiosity: gathered.radiosity, estimate, irradiance: gathered.irradiance.irradiance, light: 0.0 }.of(solution, leaf)
}
