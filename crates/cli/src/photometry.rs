//! Lux and lumens, where the user states the unit of the scene's radiances.

use radgrad_solver::Solution;

/// Luminance of the primaries of sRGB (ITU-R BT.709).
const PRIMARIES: [f64; 3] = [0.2126, 0.7152, 0.0722];

/// How channels add up to light as eyes see it.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Photometry {
    weights: Vec<f64>,
}

impl Photometry {
    /// So many lumens for each unit of flux, of a scene of one channel or of red, green and blue.
    pub(crate) fn new(lumens: f64, solution: &Solution) -> Result<Self, String> {
        let names: Vec<&str> = solution.channels().iter().map(String::as_str).collect();
        let weights: &[f64] = match names[..] {
            [_] => &[1.0],
            ["r", "g", "b"] => &PRIMARIES,
            _ => return Err(format!("--lux is of one channel or of r, g, b, and the scene has {}", names.join(", "))),
        };
        Ok(Self { weights: weights.iter().map(|weight| lumens * weight).collect() })
    }

    /// Lux of an irradiance, or lumens of a flux, with a number for each channel.
    pub(crate) fn of(&self, channels: &[f64]) -> f64 {
        self.weights.iter().zip(channels).map(|(weight, of)| weight * of).sum()
    }
}

/// The lumens a unit of `--lux`.
pub(crate) fn lumens(text: &str) -> Result<f64, String> {
    let value = text.parse::<f64>().map_err(|error| error.to_string())?;
    if value > 0.0 && value.is_finite() {
        Ok(value)
    } else {
        Err(format!("{value} lumens a unit: expected a number above 0, 1 where the scene has luminances in cd/m2"))
    }
}
