//! A picture in grey or colours, exposed by what it shows.
//!
//! `L = 2^exposure K B/m`, where m is the geometric mean of what is no lamp and not black, and K a middle grey. The curve of E. Reinhard et
//! al. (2002) is `L (1 + L/W^2)/(1 + L)`: W is the largest L of what is no lamp, but for a hundredth of it, so that lamps are white.

use std::io;
use std::path::Path;

use radgrad_scene::output::{Unwritten, write_whole};
use radgrad_scene::{largest, smallest};

use super::{Pixel, Tone};
use crate::export::srgb;

/// What the geometric mean is shown as, before the curve.
const KEY: f64 = 0.4;

/// The part of pixels that may be lighter than white, and the least W.
const LIGHTER: f64 = 0.01;
const LEAST_WHITE: f64 = 1.5;

/// The radiosity of middle grey over [`KEY`], and W.
struct Exposure {
    unit: f64,
    white: f64,
}

impl Exposure {
    fn of(pixels: &[Pixel]) -> Self {
        let lit = |pixel: &Pixel| pixel.radiosity.iter().copied().fold(0.0, largest);
        let mut shown: Vec<f64> =
            pixels.iter().filter(|pixel| pixel.light == 0.0).map(lit).filter(|value| *value > 0.0).collect();
        if shown.is_empty() {
            shown = pixels.iter().map(lit).filter(|value| *value > 0.0).collect();
        }
        shown.sort_by(f64::total_cmp);
        let Some(last) = shown.len().checked_sub(1) else { return Self { unit: 1.0, white: LEAST_WHITE } };
        let mean = (shown.iter().map(|value| value.ln()).sum::<f64>() / shown.len() as f64).exp();
        let unit = mean / KEY;
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a share of a count")]
        let beyond = (LIGHTER * shown.len() as f64) as usize;
        Self { unit, white: largest(shown[last - beyond.min(last)] / unit, LEAST_WHITE) }
    }
}

/// Writes it, and returns how it is exposed.
pub(super) fn write(
    file: &Path,
    [width, height]: [usize; 2],
    pixels: &[Pixel],
    (tone, stops): (Tone, f64),
) -> Result<String, Unwritten> {
    let Exposure { unit, white } = Exposure::of(pixels);
    let unit = unit / stops.exp2();
    let level = |pixel: &Pixel, c: usize| {
        let of = if pixel.radiosity.len() < 3 { 0 } else { c };
        largest(pixel.radiosity[of], 0.0) / unit
    };
    let colour = |pixel: &Pixel, c: usize| {
        let l = level(pixel, c);
        let shade = match tone {
            Tone::Reinhard => l * (1.0 + l / (white * white)) / (1.0 + l),
            Tone::Linear => l,
        };
        srgb(smallest(shade, 1.0))
    };
    let data: Vec<u8> = pixels.iter().flat_map(|pixel| [0, 1, 2].map(|c| colour(pixel, c))).collect();
    let exposure = match tone {
        Tone::Reinhard => {
            format!("tone curve reinhard, exposure {stops}: sRGB of L(1 + L/{:.3})/(1 + L), L = B/{unit:e}", white * white)
        }
        Tone::Linear => {
            let is_cut = |pixel: &&Pixel| (0..3).any(|c| level(pixel, c) > 1.0);
            let cut = 100.0 * pixels.iter().filter(is_cut).count() as f64 / pixels.len() as f64;
            format!("tone curve linear, exposure {stops}: sRGB of B/{unit:e}, cut at 1 in {cut:.2} % of the pixels")
        }
    };
    write_whole(file, |out| {
        let side = |length: usize| u32::try_from(length).map_err(|_| io::Error::other("more pixels a side than a PNG has"));
        let mut encoder = png::Encoder::new(out, side(width)?, side(height)?);
        encoder.set_color(png::ColorType::Rgb);
        encoder.set_depth(png::BitDepth::Eight);
        encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
        encoder.add_text_chunk("exposure".to_owned(), exposure.clone())?;
        let mut writer = encoder.write_header()?;
        writer.write_image_data(&data)?;
        writer.finish()
    })?;
    Ok(exposure)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lamps_do_not_darken_a_picture_and_are_white() {
        let pixel =
            |radiosity: f64, light: f64| Pixel { radiosity: vec![radiosity], estimate: vec![0.0], irradiance: vec![0.0], light };
        let room: Vec<Pixel> = (1..=100).map(|k| pixel(f64::from(k), 0.0)).collect();
        let with_lamp: Vec<Pixel> = room.iter().cloned().chain([pixel(1e6, 1.0)]).collect();
        let [alone, lit] = [&room, &with_lamp].map(|pixels| Exposure::of(pixels));
        assert_eq!((alone.unit, alone.white), (lit.unit, lit.white));
        // From the geometric mean, 38, to the lightest but one.
        assert!((lit.unit - 37.99 / KEY).abs() < 0.1 / KEY && lit.white == LEAST_WHITE, "{} {}", lit.unit, lit.white);
        assert!(1e6 / lit.unit > lit.white);
    }
}
