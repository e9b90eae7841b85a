//! `radgrad solve --view`: what a camera sees of a solution, the mean of rays through each pixel.
//!
//! A ray ends at the nearest face that it meets, of two back to back at the one that faces it; there stands the radiosity in the scene's unit,
//! and an estimate of its error. The back of a face and pixels beside all faces are 0. An `.exr` has these numbers as they are, a channel
//! each, and the estimates in the layer `estimate`; its attributes say quantity and unit. A `.png` has colours in the transfer curve of sRGB, by
//! a tone curve ([`tone`]), or irradiance in a scale of colours ([`legend`]).

mod camera;
mod exr;
mod legend;
mod shared;
mod tone;

use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};

use clap::{Args, ValueEnum};
use indicatif::ProgressBar;
use radgrad_core::{DVec3, Polygon};
use radgrad_scene::output::{self, Unwritten, extension, write_whole};
use radgrad_scene::{Occluders, Scene, largest};
use radgrad_solver::{NonNegative, Solution};
use rayon::prelude::*;

use crate::export::UNIT;
use crate::file::Picture;
use crate::photometry::Photometry;
use crate::say::say;
use crate::scene::{SceneFile, progress};
use camera::Camera;

/// Rays a pixel, where they share gathers.
const SAMPLES: usize = 16;

/// Squares of pixels along a side that refinement serves one of each of.
const SERVED: usize = 16;

/// A view that is asked for.
#[derive(Debug, Args)]
pub(crate) struct View {
    /// Write what a camera sees: .png, or .exr with numbers.
    ///
    /// An .exr has the linear radiosity and the estimate of its error, a .png shades by a tone curve in sRGB. It is written as parts are done
    /// too, so that a run that is interrupted leaves these.
    #[arg(long, value_name = "FILE", requires = "camera")]
    view: Option<PathBuf>,
    /// Eye, target, up, and field of view: ten numbers.
    ///
    /// In quotes, with spaces or commas between; the field of view is the vertical one, in degrees.
    #[arg(long, value_name = "TEN", value_parser = Camera::parse, allow_hyphen_values = true)]
    camera: Option<Camera>,
    /// Pixels of the view, width by height.
    #[arg(long, value_name = "WxH", default_value = "512x512", value_parser = size)]
    size: [usize; 2],
    /// Rays a pixel.
    ///
    /// They are spread evenly over it, and it is the mean of what they meet. By default 16, that share gathers; 1 with --gather and --draft.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=4096), help_heading = crate::solve::EXPERT)]
    samples: Option<u16>,
    /// Stops by which a .png is brighter.
    ///
    /// Each is twice as bright; negative for darker.
    #[arg(long, value_name = "STOPS", default_value_t = 0.0, value_parser = stops, allow_hyphen_values = true, help_heading = crate::solve::EXPERT)]
    exposure: f64,
    /// Tone curve of a .png.
    #[arg(long, value_enum, default_value_t, help_heading = crate::solve::EXPERT)]
    tone: Tone,
    /// Show irradiance in colours, with their scale.
    ///
    /// In lux with --lux, else pi times the unit of radiance; of several channels their mean.
    #[arg(long, requires = "view")]
    false_colour: bool,
    /// One exact gather for every ray.
    #[arg(long, help_heading = crate::solve::EXPERT)]
    gather: bool,
    /// The polynomials of elements: at once, with edges.
    #[arg(long, conflicts_with = "gather", help_heading = crate::solve::EXPERT)]
    draft: bool,
}

/// How radiosities become shades.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, ValueEnum)]
enum Tone {
    /// L (1 + L/W^2)/(1 + L), which is white from W on.
    #[default]
    Reinhard,
    /// L, white from 1 on.
    Linear,
}

/// Why there is no view.
#[derive(Debug, thiserror::Error)]
pub(crate) enum Failure {
    #[error("{}: expected a name ending in .exr or .png", file.display())]
    Format { file: PathBuf },
    #[error("no camera: give eye, target, up and field of view")]
    Camera,
    #[error(transparent)]
    Scene(#[from] radgrad_scene::Error),
    #[error(transparent)]
    Solve(#[from] radgrad_solver::Error),
    #[error(transparent)]
    Write(#[from] Unwritten),
    #[error("the picture was ended before it was whole")]
    Stopped,
}

/// A pixel: radiosity, the estimate of its error and irradiance in each channel, and which part of it is of lamps.
#[derive(Debug, Clone)]
struct Pixel {
    radiosity: Vec<f64>,
    estimate: Vec<f64>,
    irradiance: Vec<f64>,
    light: f64,
}

impl View {
    /// Refuses a name of another format, a picture that is too large, and a file that cannot be written.
    pub(crate) fn check(&self, scene: &SceneFile) -> Result<(), Failure> {
        let Some(file) = &self.view else { return Ok(()) };
        if !matches!(extension(file).as_str(), "exr" | "png") {
            return Err(Failure::Format { file: file.clone() });
        }
        // Values and estimates of three channels, and where they are.
        scene.afford("a picture of so many pixels", &self.size, 2 * size_of::<Pixel>() + 9 * size_of::<f64>())?;
        Ok(output::check(file)?)
    }

    /// What the camera sees of a scene, through a pixel of every square of them, with the normals there: for the sake of these.
    pub(crate) fn places(&self, scene: &Scene) -> Vec<(DVec3, DVec3)> {
        let Some(camera) = &self.camera else { return Vec::new() };
        let polygons: Vec<Polygon> = scene.polygons().cloned().collect();
        let index = Occluders::new(&polygons);
        let squares = (0..SERVED * SERVED).map(|index| [index % SERVED, index / SERVED]);
        let met = |square: [usize; 2]| {
            let pixel = [0, 1].map(|k| square[k] * self.size[k] / SERVED + self.size[k] / (2 * SERVED));
            let (face, point) = index.first_along(camera.eye, camera.direction(pixel, offset(0, 1), self.size), &[])?;
            Some((point, polygons[face].normal()))
        };
        squares.filter_map(met).collect()
    }

    pub(crate) fn file(&self) -> Option<&Path> {
        self.view.as_deref()
    }

    /// Draws the view, if one is asked for.
    pub(crate) fn write(&self, solution: &Solution, photometry: Option<&Photometry>) -> Result<(), Failure> {
        if self.view.is_some() { self.drawn(solution, photometry, &AtomicBool::new(false)).map(|_| ()) } else { Ok(()) }
    }

    /// Draws the view, and writes it where a file is named, until `stop` is set.
    pub(crate) fn picture(&self, solution: &Solution, stop: &AtomicBool) -> Result<Picture, Failure> {
        self.drawn(solution, None, stop)
    }

    /// The file is written as parts of the picture are done too, so that a run that is interrupted leaves these.
    fn drawn(&self, solution: &Solution, photometry: Option<&Photometry>, stop: &AtomicBool) -> Result<Picture, Failure> {
        let save = |pixels: &[Pixel], is_whole: bool| -> Result<(), Failure> {
            let mut numbers = pixels.iter().flat_map(|pixel| pixel.radiosity.iter().chain(&pixel.estimate));
            if let Some(&value) = numbers.find(|number| !number.is_finite()) {
                return Err(radgrad_scene::Error::NotFinite { what: "a pixel".to_owned(), value }.into());
            }
            let Some(file) = &self.view else { return Ok(()) };
            let said = match extension(file).as_str() {
                "exr" => write_whole(file, |out| self.exr(solution, pixels, out)).map(|()| None)?,
                "png" if self.false_colour => Some(legend::write(file, self.size, pixels, photometry)?),
                "png" => Some(tone::write(file, self.size, pixels, (self.tone, self.exposure))?),
                _ => return Err(Failure::Format { file: file.clone() }),
            };
            if let Some(said) = said.filter(|_| is_whole) {
                say(format_args!("{}: {said}", file.display()));
            }
            Ok(())
        };
        let pixels = self.pixels(solution, stop, &|pixels| save(pixels, false))?;
        if pixels.iter().all(|pixel| pixel.radiosity.iter().all(|value| *value == 0.0)) {
            say(format_args!(
                "the view is black: no ray meets the lit front of a face; faces are seen from the side from which their vertices run \
                 counter-clockwise: is the eye of --camera inside the room?"
            ));
        }
        save(&pixels, true)?;
        let all = |of: fn(&Pixel) -> &Vec<f64>| pixels.iter().flat_map(|pixel| of(pixel).iter().copied()).collect();
        Ok(Picture { size: self.size, radiosity: all(|pixel| &pixel.radiosity), estimate: all(|pixel| &pixel.estimate) })
    }

    fn pixels(
        &self,
        solution: &Solution,
        stop: &AtomicBool,
        save: &(dyn Fn(&[Pixel]) -> Result<(), Failure> + Sync),
    ) -> Result<Vec<Pixel>, Failure> {
        let camera = self.camera.as_ref().ok_or(Failure::Camera)?;
        let [width, height] = self.size;
        let index = Occluders::new(solution.mesh().polygons());
        let bar = if self.draft { ProgressBar::hidden() } else { progress(width * height) };
        let samples = self.samples.map_or(if self.gather || self.draft { 1 } else { SAMPLES }, usize::from);
        let pixels = if self.gather || self.draft {
            let eye = solution.placement().inward(camera.eye);
            let drawn = self.draft.then(|| solution.not_negative());
            let pixel = |place: usize| {
                if stop.load(Ordering::Relaxed) {
                    return Err(Failure::Stopped);
                }
                let mut sum = Pixel::dark(solution.channels().len());
                for sample in 0..samples {
                    let direction = camera.direction([place % width, place / width], offset(sample, samples), self.size);
                    sum.add(&pixel(solution, drawn.as_ref(), &index, [eye, direction])?, 1.0 / samples as f64);
                }
                bar.inc(1);
                Ok(sum)
            };
            (0..width * height).into_par_iter().map(pixel).collect::<Result<Vec<Pixel>, Failure>>()?
        } else {
            let gathers = solution.picture_gathers();
            let scene = shared::Scene { solution, gathers, camera, size: self.size, samples, index: &index, stop };
            shared::draw(&scene, |count| bar.inc(count as u64), save)?
        };
        bar.finish_and_clear();
        Ok(pixels)
    }

    fn exr(&self, solution: &Solution, pixels: &[Pixel], out: &mut dyn Write) -> io::Result<()> {
        let names: Vec<String> = solution.channels().iter().map(|name| shown(name)).collect();
        let plane = |values: &dyn Fn(&Pixel) -> f64| pixels.iter().map(values).collect::<Vec<f64>>();
        let mut channels = Vec::new();
        for (index, name) in names.into_iter().enumerate() {
            channels.push((format!("estimate.{name}"), plane(&|pixel| pixel.estimate[index])));
            channels.push((name, plane(&|pixel| pixel.radiosity[index])));
        }
        let how = match (self.gather, self.draft) {
            (true, _) => "exact gathers",
            (_, true) => "polynomials on elements, drawn toward their means where they would be negative",
            _ => "exact gathers, interpolated where the estimate says so",
        };
        let said =
            [("quantity", "radiosity"), ("unit", UNIT), ("shading", how), ("estimate", "of the error, in the layer estimate")];
        exr::write(out, self.size, channels, &said)
    }
}

/// The pixel of a ray from a point of the solution's own coordinates: of what is drawn, or else gathered.
fn pixel(
    solution: &Solution,
    drawn: Option<&NonNegative<'_>>,
    index: &Occluders,
    [eye, direction]: [DVec3; 2],
) -> Result<Pixel, radgrad_solver::Error> {
    let channels = solution.channels().len();
    let Some((face, point)) = index.first_along(eye, direction, &[]) else { return Ok(Pixel::dark(channels)) };
    let is_front = solution.mesh().polygons()[face].normal().dot(direction) < 0.0;
    let Some(leaf) = solution.mesh().leaf_at(face, point).filter(|_| is_front) else { return Ok(Pixel::dark(channels)) };
    let Some(drawn) = drawn else { return Ok(shared::gathered(solution, leaf, solution.gather_on(leaf, point)?)) };
    let at = solution.mesh().elements()[leaf].reference(point);
    let polynomial = |channel| solution.value_on(leaf, channel, at);
    let value = |channel| largest(drawn.value_on(leaf, channel, at), solution.least_on(leaf, channel));
    // What is drawn differs from the polynomial, and that counts beside the polynomial's estimate.
    let estimates = solution.estimate_on(leaf);
    let estimate = |channel: usize| estimates[channel].total() + (value(channel) - polynomial(channel)).abs();
    let basis = solution.mesh().basis(leaf).values(at);
    let irradiance = |channel: usize| solution.irradiance_on(leaf, channel).iter().zip(&basis).map(|(c, v)| c * v).sum();
    let pixel = Pixel {
        radiosity: (0..channels).map(value).collect(),
        estimate: (0..channels).map(estimate).collect(),
        irradiance: (0..channels).map(irradiance).collect(),
        light: 0.0,
    };
    Ok(pixel.of(solution, leaf))
}

impl Pixel {
    fn dark(channels: usize) -> Self {
        let zeros = || vec![0.0; channels];
        Self { radiosity: zeros(), estimate: zeros(), irradiance: zeros(), light: 0.0 }
    }

    /// With whether its face is a lamp.
    fn of(mut self, solution: &Solution, leaf: usize) -> Self {
        self.light = if (0..self.radiosity.len()).any(|channel| solution.least_on(leaf, channel) > 0.0) { 1.0 } else { 0.0 };
        self
    }

    fn add(&mut self, other: &Self, weight: f64) {
        let add = |sums: &mut [f64], more: &[f64]| sums.iter_mut().zip(more).for_each(|(sum, more)| *sum += weight * more);
        add(&mut self.radiosity, &other.radiosity);
        add(&mut self.estimate, &other.estimate);
        add(&mut self.irradiance, &other.irradiance);
        self.light += weight * other.light;
    }
}

/// Where one of so many rays goes through a pixel, from its upper left corner: on a grid if they are a square of a number, else evenly
/// (M. Roberts 2018, in two dimensions).
fn offset(sample: usize, samples: usize) -> [f64; 2] {
    let side = samples.isqrt();
    if side * side == samples {
        return [sample % side, sample / side].map(|place| (place as f64 + 0.5) / side as f64);
    }
    [0.754_877_666_246_692_8, 0.569_840_290_998_053_3].map(|by| (0.5 + sample as f64 * by).fract())
}

/// The name of a channel in a picture: programs that show colours know R, G and B.
fn shown(name: &str) -> String {
    if matches!(name, "r" | "g" | "b") { name.to_uppercase() } else { name.to_owned() }
}

fn stops(text: &str) -> Result<f64, String> {
    let value = text.parse::<f64>().map_err(|error| error.to_string())?;
    if value.abs() <= 64.0 { Ok(value) } else { Err(format!("{value} is not from -64 to 64")) }
}

/// `640x480`.
fn size(text: &str) -> Result<[usize; 2], String> {
    let wrong = || format!("`{text}`: expected WIDTHxHEIGHT, as 640x480, each from 1 to 32768");
    let (width, height) = text.split_once('x').ok_or_else(wrong)?;
    let side = |text: &str| text.parse().ok().filter(|n| (1..=32_768).contains(n)).ok_or_else(wrong);
    Ok([side(width)?, side(height)?])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_size_is_two_numbers() {
        assert_eq!(size("640x480"), Ok([640, 480]));
        for wrong in ["640", "0x4", "4x-1", "x", "99999x2"] {
            assert!(size(wrong).is_err(), "{wrong}");
        }
    }
}
