//! Irradiance in colours, with their scale and its unit below the picture.

use std::path::Path;

use radgrad_scene::largest;
use radgrad_scene::output::{Unwritten, write_whole};

use super::Pixel;
use crate::field::{Canvas, colour};
use crate::photometry::Photometry;

/// Height of the scale, and of all that is below the picture.
const SCALE: usize = 16;
const BELOW: usize = 88;
const MARGIN: usize = 16;

/// Numbers along the scale, but for 0, at most.
const STEPS: [usize; 3] = [4, 2, 1];

/// The part of pixels that may be above the scale.
const ABOVE: f64 = 0.01;

/// Writes it, and returns how far the scale goes.
pub(super) fn write(
    file: &Path,
    [width, height]: [usize; 2],
    pixels: &[Pixel],
    photometry: Option<&Photometry>,
) -> Result<String, Unwritten> {
    let value = |pixel: &Pixel| match photometry {
        Some(photometry) => photometry.of(&pixel.irradiance),
        None => pixel.irradiance.iter().sum::<f64>() / pixel.irradiance.len() as f64,
    };
    let title = if photometry.is_some() { "illuminance, lux" } else { "irradiance, pi x unit of radiance" };
    let values: Vec<f64> = pixels.iter().map(value).collect();
    let most = nice(&values);
    let mut canvas = Canvas::new(width.max(2 * MARGIN + Canvas::width_of(title)), height + BELOW);
    for (place, value) in values.iter().enumerate() {
        // What is seen of no face has no value.
        let shade = if *value > 0.0 { colour(value / most) } else { [0; 3] };
        canvas.fill([place % width, place / width], [1, 1], shade);
    }
    let (left, right) = (MARGIN, width.saturating_sub(MARGIN));
    let long = right.saturating_sub(left).max(1);
    for x in 0..long {
        canvas.fill([left + x, height + 10], [1, SCALE], colour(x as f64 / long as f64));
    }
    let number = |step: usize, steps: usize| format!("{}", most * step as f64 / steps as f64);
    let widest = |steps: usize| (0..=steps).map(|step| Canvas::width_of(&number(step, steps))).max().unwrap_or(0);
    let steps = STEPS.into_iter().find(|&steps| (steps + 1) * widest(steps) <= long).unwrap_or(1);
    for step in 0..=steps {
        let number = number(step, steps);
        let wide = Canvas::width_of(&number);
        let middle = left + step * long / steps;
        canvas.text([middle.saturating_sub(wide / 2).clamp(2, width.saturating_sub(wide).max(2)), height + SCALE + 18], &number);
    }
    canvas.text([left, height + SCALE + 46], title);
    let scale = format!("{title}, from 0 to {most}");
    write_whole(file, |out| canvas.encode(out, [("scale".to_owned(), scale.clone())]))?;
    Ok(scale)
}

/// The end of the scale: the least of 1, 2, 4 and 8 times a power of ten that few values are above.
fn nice(values: &[f64]) -> f64 {
    let mut shown: Vec<f64> = values.iter().copied().filter(|value| *value > 0.0).collect();
    shown.sort_by(f64::total_cmp);
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a share of a count")]
    let beyond = (ABOVE * shown.len() as f64) as usize;
    let Some(&most) = shown.iter().rev().nth(beyond) else { return 1.0 };
    let power = 10.0_f64.powf(most.log10().floor());
    let end = [1.0, 2.0, 4.0, 8.0, 10.0].map(|factor| factor * power).into_iter().find(|end| *end >= most);
    largest(end.unwrap_or(most), f64::MIN_POSITIVE)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_scale_ends_in_a_round_number() {
        assert_eq!(nice(&[3.0, 770.0]), 800.0);
        assert_eq!(nice(&[0.0, 0.012]), 0.02);
        assert_eq!(nice(&[0.0]), 1.0);
    }
}
