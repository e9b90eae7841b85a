//! Pixels to draw on, and a scale of colours.

use std::io::Write;

use super::glyphs::{HEIGHT, WIDTH, glyph};

type Rgb = [u8; 3];

pub(super) const INK: Rgb = [255, 255, 255];
const TEXT: Rgb = [38, 38, 46];

/// Pixels that a dot of a letter takes along each side.
const DOT: usize = 2;

pub(crate) struct Canvas {
    width: usize,
    height: usize,
    pixels: Vec<Rgb>,
}

impl Canvas {
    pub(crate) fn new(width: usize, height: usize) -> Self {
        Self { width, height, pixels: vec![[255; 3]; width * height] }
    }

    pub(crate) fn fill(&mut self, [left, top]: [usize; 2], [width, height]: [usize; 2], colour: Rgb) {
        for y in top..(top + height).min(self.height) {
            for x in left..(left + width).min(self.width) {
                self.pixels[y * self.width + x] = colour;
            }
        }
    }

    pub(crate) fn text(&mut self, [left, top]: [usize; 2], text: &str) {
        for (place, letter) in text.chars().enumerate() {
            for (row, dots) in glyph(letter).iter().enumerate() {
                for column in (0..WIDTH).filter(|column| dots >> (WIDTH - 1 - column) & 1 == 1) {
                    let x = left + (place * (WIDTH + 1) + column) * DOT;
                    self.fill([x, top + row * DOT], [DOT, DOT], TEXT);
                }
            }
        }
    }

    pub(crate) fn width_of(text: &str) -> usize {
        text.chars().count() * (WIDTH + 1) * DOT
    }

    /// A line around its middle, with a head at the end where it is long enough for one.
    pub(crate) fn arrow(&mut self, [x, y]: [f64; 2], [along, down]: [f64; 2], colour: Rgb) {
        let length = along.hypot(down);
        let tip = [x + 0.5 * along, y + 0.5 * down];
        self.line([x - 0.5 * along, y - 0.5 * down], tip, colour);
        if length >= HEIGHT as f64 {
            let back = [-along, -down].map(|part| part / length * 4.0);
            for turn in [-0.6, 0.6] {
                self.line(tip, [tip[0] + back[0] - turn * back[1], tip[1] + back[1] + turn * back[0]], colour);
            }
        }
    }

    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a place on the canvas, and casts saturate")]
    fn line(&mut self, from: [f64; 2], to: [f64; 2], colour: Rgb) {
        let [along, down] = [to[0] - from[0], to[1] - from[1]];
        let steps = along.abs().max(down.abs()).ceil().max(1.0);
        for step in 0..=steps as usize {
            let share = step as f64 / steps;
            self.fill([from[0] + along * share, from[1] + down * share].map(|place| place as usize), [1, 1], colour);
        }
    }

    pub(crate) fn encode(
        &self,
        out: impl Write,
        chunks: impl IntoIterator<Item = (String, String)>,
    ) -> Result<(), png::EncodingError> {
        let [width, height] = [self.width, self.height].map(u32::try_from);
        let too_large = |_| std::io::Error::other("a picture of more than 4294967295 pixels a side");
        let mut encoder = png::Encoder::new(out, width.map_err(too_large)?, height.map_err(too_large)?);
        encoder.set_color(png::ColorType::Rgb);
        encoder.set_depth(png::BitDepth::Eight);
        for (keyword, text) in chunks {
            encoder.add_text_chunk(keyword, text)?;
        }
        let mut writer = encoder.write_header()?;
        writer.write_image_data(self.pixels.as_flattened())?;
        writer.finish()
    }
}

/// Nine steps of the scale viridis (S. van der Walt and N. Smith), from dark blue to yellow; colours between them are mixed.
const VIRIDIS: [Rgb; 9] = [
    [68, 1, 84],
    [71, 44, 122],
    [59, 81, 139],
    [44, 113, 142],
    [33, 144, 141],
    [39, 173, 129],
    [92, 200, 99],
    [170, 220, 50],
    [253, 231, 37],
];

/// A share that is not finite is grey.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a share of the scale, and casts saturate")]
pub(crate) fn colour(share: f64) -> Rgb {
    if !share.is_finite() {
        return [150; 3];
    }
    let place = share.clamp(0.0, 1.0) * (VIRIDIS.len() - 1) as f64;
    let below = (place as usize).min(VIRIDIS.len() - 2);
    let part = place - below as f64;
    [0, 1, 2].map(|k| {
        let [low, high] = [below, below + 1].map(|step| f64::from(VIRIDIS[step][k]));
        (low + (high - low) * part).round() as u8
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_scale_of_colours_begins_and_ends_where_it_should_and_grows_lighter() {
        assert_eq!([colour(0.0), colour(1.0), colour(0.5)], [VIRIDIS[0], VIRIDIS[8], VIRIDIS[4]]);
        let lightness = |share: f64| colour(share).map(f64::from).iter().zip([0.21, 0.72, 0.07]).map(|(c, w)| c * w).sum::<f64>();
        assert!((0..20).all(|k| lightness(f64::from(k + 1) / 20.0) > lightness(f64::from(k) / 20.0)));
        assert_eq!(colour(f64::NAN), [150; 3]);
    }
}
