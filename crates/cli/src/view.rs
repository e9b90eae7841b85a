//! `radgrad solve --view`: what a camera sees of a solution, one ray through the centre of each pixel, or the mean of more.
//!
//! A ray ends at the nearest face that it meets, of two back to back at the one that faces it; there stands the radiosity in the scene's unit, and an estimate of its error. The back of a face
//! and pixels beside all faces are 0. An `.exr` has these numbers as they are, a channel each, and the estimates in the layer
//! `estimate`; its attributes say quantity and unit. A `.png` has colours in the transfer curve of sRGB, by a tone curve of
//! `L = 2^exposure B/2m` with the mean radiosity m over all channels: `L/(1 + L)` (E. Reinhard et al. 2002) or L up to 1. It says so in
//! its text chunk `exposure`.

mod camera;
mod exr;

use std::io::{self, Write};
use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};
use indicatif::ProgressBar;
use radgrad_core::{DVec3, Polygon};
use radgrad_scene::output::{self, Unwritten, extension, write_whole};
use radgrad_scene::{Occluders, Scene, largest, smallest};
use radgrad_solver::{Ledger, NonNegative, Solution};
use rayon::prelude::*;

use crate::export::{UNIT, shade, srgb};
use crate::file::Picture;
use crate::say::say;
use crate::scene::{SceneFile, progress};
use camera::Camera;

/// Squares of pixels along a side that refinement serves one of each of.
const SERVED: usize = 16;

/// A view that is asked for.
#[derive(Debug, Args)]
pub(crate) struct View {
    /// Write what a camera sees: .exr (linear radiosity and the estimate of its error) or .png (tone-mapped, sRGB).
    #[arg(long, value_name = "FILE", requires = "camera")]
    view: Option<PathBuf>,
    /// Eye, target, up and vertical field of view in degrees: ten numbers, with spaces or commas between.
    #[arg(long, value_name = "\"EYE TARGET UP FOV\"", value_parser = Camera::parse, allow_hyphen_values = true)]
    camera: Option<Camera>,
    /// Pixels of the view: width x height.
    #[arg(long, value_name = "WxH", default_value = "512x512", value_parser = size)]
    size: [usize; 2],
    /// Rays a pixel, spread evenly over it; the pixel is the mean of the radiosities that they meet.
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u16).range(1..=4096), help_heading = crate::solve::EXPERT)]
    samples: u16,
    /// Stops by which a .png is brighter, each twice as bright; negative for darker.
    #[arg(long, value_name = "STOPS", default_value_t = 0.0, value_parser = stops, allow_hyphen_values = true, help_heading = crate::solve::EXPERT)]
    exposure: f64,
    /// Tone curve of a .png.
    #[arg(long, value_enum, default_value_t, help_heading = crate::solve::EXPERT)]
    tone: Tone,
    /// One exact gather for every ray rather than the polynomials.
    #[arg(long, help_heading = crate::solve::EXPERT)]
    gather: bool,
}

/// How radiosities become shades.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, ValueEnum)]
enum Tone {
    /// L/(1 + L), which leaves nothing out.
    #[default]
    Reinhard,
    /// L, cut at 1.
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
}

/// A pixel: radiosity and the estimate of its error in each channel.
struct Pixel {
    radiosity: Vec<f64>,
    estimate: Vec<f64>,
}

impl View {
    /// Refuses a name of another format, a picture that is too large, and a file that cannot be written.
    pub(crate) fn check(&self, scene: &SceneFile) -> Result<(), Failure> {
        let Some(file) = &self.view else { return Ok(()) };
        if !matches!(extension(file).as_str(), "exr" | "png") {
            return Err(Failure::Format { file: file.clone() });
        }
        // Values and estimates of three channels, and where they are.
        scene.afford("a picture of so many pixels", &self.size, 2 * size_of::<Pixel>() + 6 * size_of::<f64>())?;
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
            let (face, point) = index.first_along(camera.eye, camera.direction(pixel, offset(0), self.size), &[])?;
            Some((point, polygons[face].normal()))
        };
        squares.filter_map(met).collect()
    }

    pub(crate) fn file(&self) -> Option<&Path> {
        self.view.as_deref()
    }

    /// Draws the view, if one is asked for.
    pub(crate) fn write(&self, solution: &Solution) -> Result<(), Failure> {
        if self.view.is_some() { self.picture(solution).map(|_| ()) } else { Ok(()) }
    }

    /// Draws the view, and writes it where a file is named.
    pub(crate) fn picture(&self, solution: &Solution) -> Result<Picture, Failure> {
        let camera = self.camera.as_ref().ok_or(Failure::Camera)?;
        // What is gathered needs nothing that is drawn.
        let drawn = (!self.gather).then(|| solution.not_negative());
        let [width, height] = self.size;
        let (eye, samples) = (solution.placement().inward(camera.eye), usize::from(self.samples));
        let index = Occluders::new(solution.mesh().polygons());
        let bar = if self.gather { progress(width * height) } else { ProgressBar::hidden() };
        let pixel = |place: usize| {
            let met = |sample: usize| {
                let direction = camera.direction([place % width, place / width], offset(sample), self.size);
                pixel(solution, drawn.as_ref(), &index, [eye, direction])
            };
            let mut sum = met(0)?;
            for sample in 1..samples {
                sum.add(&met(sample)?);
            }
            bar.inc(1);
            Ok(sum.over(samples))
        };
        let pixels = (0..width * height).into_par_iter().map(pixel).collect::<Result<Vec<Pixel>, radgrad_solver::Error>>()?;
        bar.finish_and_clear();
        let mut numbers = pixels.iter().flat_map(|pixel| pixel.radiosity.iter().chain(&pixel.estimate));
        if let Some(&value) = numbers.find(|number| !number.is_finite()) {
            return Err(radgrad_scene::Error::NotFinite { what: "a pixel".to_owned(), value }.into());
        }
        if let Some(file) = &self.view {
            match extension(file).as_str() {
                "exr" => write_whole(file, |out| self.exr(solution, &pixels, out))?,
                "png" => self.png(file, solution, &pixels)?,
                _ => return Err(Failure::Format { file: file.clone() }),
            }
        }
        let all = |of: fn(&Pixel) -> &Vec<f64>| pixels.iter().flat_map(|pixel| of(pixel).iter().copied()).collect();
        Ok(Picture { size: self.size, radiosity: all(|pixel| &pixel.radiosity), estimate: all(|pixel| &pixel.estimate) })
    }

    fn exr(&self, solution: &Solution, pixels: &[Pixel], out: &mut dyn Write) -> io::Result<()> {
        let names: Vec<String> = solution.channels().iter().map(|name| shown(name)).collect();
        let plane = |values: &dyn Fn(&Pixel) -> f64| pixels.iter().map(values).collect::<Vec<f64>>();
        let mut channels = Vec::new();
        for (index, name) in names.into_iter().enumerate() {
            channels.push((format!("estimate.{name}"), plane(&|pixel| pixel.estimate[index])));
            channels.push((name, plane(&|pixel| pixel.radiosity[index])));
        }
        let how = if self.gather {
            "exact gathers"
        } else {
            "polynomials on elements, drawn toward their means where they would be negative"
        };
        let said =
            [("quantity", "radiosity"), ("unit", UNIT), ("shading", how), ("estimate", "of the error, in the layer estimate")];
        exr::write(out, self.size, channels, &said)
    }

    fn png(&self, file: &Path, solution: &Solution, pixels: &[Pixel]) -> Result<(), Unwritten> {
        let channels = solution.channels().len();
        let middle = 2.0 * solution.mean().iter().sum::<f64>() / channels as f64;
        let middle = middle / self.exposure.exp2();
        let shown = |pixel: &Pixel, c: usize| pixel.radiosity[if channels < 3 { 0 } else { c }];
        let colour = |pixel: &Pixel, c: usize| match self.tone {
            Tone::Reinhard => srgb(shade(shown(pixel, c), middle)),
            Tone::Linear => srgb(smallest(largest(shown(pixel, c), 0.0) / middle, 1.0)),
        };
        let data: Vec<u8> = pixels.iter().flat_map(|pixel| [0, 1, 2].map(|c| colour(pixel, c))).collect();
        let stops = self.exposure;
        let exposure = match self.tone {
            Tone::Reinhard => format!("tone curve reinhard, exposure {stops}: sRGB of B/(B + {middle:e})"),
            Tone::Linear => {
                let is_cut = |pixel: &&Pixel| (0..3).any(|c| shown(pixel, c) > middle);
                let cut = 100.0 * pixels.iter().filter(is_cut).count() as f64 / pixels.len() as f64;
                format!("tone curve linear, exposure {stops}: sRGB of B/{middle:e}, cut at 1 in {cut:.2} % of the pixels")
            }
        };
        write_whole(file, |out| {
            let side = |length: usize| u32::try_from(length).map_err(|_| io::Error::other("more pixels a side than a PNG has"));
            let mut encoder = png::Encoder::new(out, side(self.size[0])?, side(self.size[1])?);
            encoder.set_color(png::ColorType::Rgb);
            encoder.set_depth(png::BitDepth::Eight);
            encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
            encoder.add_text_chunk("exposure".to_owned(), exposure.clone())?;
            let mut writer = encoder.write_header()?;
            writer.write_image_data(&data)?;
            writer.finish()
        })?;
        say(format_args!("{}: {exposure}", file.display()));
        Ok(())
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
    let dark = Pixel { radiosity: vec![0.0; channels], estimate: vec![0.0; channels] };
    let Some((face, point)) = index.first_along(eye, direction, &[]) else { return Ok(dark) };
    let is_front = solution.mesh().polygons()[face].normal().dot(direction) < 0.0;
    let Some(leaf) = solution.mesh().leaf_at(face, point).filter(|_| is_front) else { return Ok(dark) };
    let Some(drawn) = drawn else {
        let gathered = solution.gather_on(leaf, point)?;
        let estimate = gathered.estimate.iter().map(Ledger::total).collect();
        return Ok(Pixel { radiosity: gathered.radiosity, estimate });
    };
    let at = solution.mesh().elements()[leaf].reference(point);
    let polynomial = |channel| solution.value_on(leaf, channel, at);
    let value = |channel| largest(drawn.value_on(leaf, channel, at), solution.least_on(leaf, channel));
    // What is drawn differs from the polynomial, and that counts beside the polynomial's estimate.
    let estimates = solution.estimate_on(leaf);
    let estimate = |channel: usize| estimates[channel].total() + (value(channel) - polynomial(channel)).abs();
    Ok(Pixel { radiosity: (0..channels).map(value).collect(), estimate: (0..channels).map(estimate).collect() })
}

impl Pixel {
    fn add(&mut self, other: &Self) {
        let add = |sums: &mut [f64], more: &[f64]| sums.iter_mut().zip(more).for_each(|(sum, more)| *sum += more);
        add(&mut self.radiosity, &other.radiosity);
        add(&mut self.estimate, &other.estimate);
    }

    fn over(mut self, samples: usize) -> Self {
        self.radiosity.iter_mut().chain(&mut self.estimate).for_each(|sum| *sum /= samples as f64);
        self
    }
}

/// Where a ray goes through a pixel, from its upper left corner: the centre first, then evenly (M. Roberts 2018, in two dimensions).
fn offset(sample: usize) -> [f64; 2] {
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
