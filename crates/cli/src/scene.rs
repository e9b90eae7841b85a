//! The scene that a command works on, and how far the work is.

use std::io::IsTerminal;
use std::path::PathBuf;

use clap::ValueEnum;
use indicatif::{ProgressBar, ProgressStyle};
use radgrad_scene::{Degenerate, Error, Materials, Overlaps, Reading, Scene};

use crate::say::say;

/// Notes that are shown.
const MOST_NOTES: usize = 20;

/// Which scene to read, and how.
#[derive(Debug, clap::Args)]
pub(crate) struct SceneFile {
    /// Scene: .obj with its .mtl, .gltf, .glb, .vs3, .stl or .ply.
    #[arg(id = "scene", value_name = "SCENE")]
    pub(crate) path: PathBuf,
    /// Turn every face around.
    ///
    /// A face gives and takes light on the side from which its vertices run counter-clockwise.
    #[arg(long, help_heading = crate::solve::EXPERT)]
    flip: bool,
    /// Leave out faces that cross themselves.
    ///
    /// Otherwise the file is refused.
    #[arg(long, help_heading = crate::solve::EXPERT)]
    drop_degenerate: bool,
    /// By how much coordinates may be off.
    ///
    /// In the unit of the scene; 0 if they are exact. By default this is told from how they are written: in single precision, or with how
    /// many decimals.
    #[arg(long, value_name = "LENGTH", value_parser = length, help_heading = crate::solve::EXPERT)]
    precision: Option<f64>,
    /// Memory to take: bytes, or as 256M.
    ///
    /// Reading may take it, and so may points, grids and pictures: bytes, or a number with K, M or G.
    #[arg(long, value_name = "BYTES", default_value = "256M", value_parser = bytes, help_heading = crate::solve::EXPERT)]
    pub(crate) budget: u64,
    /// What becomes of faces in one plane.
    ///
    /// That is, of faces that overlap there and face the same way.
    #[arg(long, value_enum, value_name = "WHAT", default_value_t, help_heading = crate::solve::EXPERT)]
    overlaps: Overlapping,
    /// Read files outside the scene's folder.
    ///
    /// Those that the scene names.
    #[arg(long, help_heading = crate::solve::EXPERT)]
    allow_outside: bool,
}

/// What becomes of faces that overlap in one plane and face the same way.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, ValueEnum)]
enum Overlapping {
    /// Leave a second copy out, cut a face around those that lie in it, refuse the others.
    #[default]
    Nested,
    /// Cut the larger one, however they overlap.
    Cut,
    /// Refuse all.
    Refuse,
}

impl From<Overlapping> for Overlaps {
    fn from(overlapping: Overlapping) -> Self {
        match overlapping {
            Overlapping::Nested => Self::Nested,
            Overlapping::Cut => Self::Cut,
            Overlapping::Refuse => Self::Refuse,
        }
    }
}

impl SceneFile {
    /// Reads the scene, and prints the reader's changes on the standard error.
    pub(crate) fn read(&self, materials: Materials) -> Result<Scene, Error> {
        let degenerate = if self.drop_degenerate { Degenerate::Drop } else { Degenerate::Refuse };
        let (overlaps, precision) = (self.overlaps.into(), self.precision);
        let Self { budget, allow_outside, flip, .. } = *self;
        let reading = Reading { degenerate, budget, allow_outside, materials, overlaps, precision, flip };
        let scene = Scene::read(&self.path, reading)?;
        scene.notes().iter().take(MOST_NOTES).for_each(say);
        if let Some(more @ 1..) = scene.notes().len().checked_sub(MOST_NOTES) {
            say(format_args!("{}: and {more} notes more", self.path.display()));
        }
        Ok(scene)
    }

    /// Refuses more memory than the budget: so many entries of a certain size.
    pub(crate) fn afford(&self, what: &str, counts: &[usize], size: usize) -> Result<(), Error> {
        let all = counts.iter().try_fold(size, |product, &count| product.checked_mul(count));
        match all {
            Some(bytes) if bytes as u64 <= self.budget => Ok(()),
            _ => Err(Error::Budget { what: what.to_owned(), budget: self.budget }),
        }
    }
}

/// A length that is finite and not negative.
fn length(text: &str) -> Result<f64, String> {
    let length = text.parse::<f64>().map_err(|error| format!("`{text}`: {error}"))?;
    if length >= 0.0 && length.is_finite() { Ok(length) } else { Err(format!("`{text}`: expected a length, 0 or more")) }
}

/// `1000000`, `64K`, `256M`, `2G`, with `B` or `iB` after the letter or not.
pub(crate) fn bytes(text: &str) -> Result<u64, String> {
    let digits = text.trim_end_matches(|c: char| !c.is_ascii_digit());
    let shift = match text[digits.len()..].trim().to_ascii_lowercase().as_str() {
        "" | "b" => 0,
        "k" | "kb" | "kib" => 10,
        "m" | "mb" | "mib" => 20,
        "g" | "gb" | "gib" => 30,
        _ => return Err(format!("`{text}`: expected bytes, or a number with K, M or G")),
    };
    let number: u64 = digits.parse().map_err(|error| format!("`{text}`: {error}"))?;
    number.checked_mul(1 << shift).ok_or_else(|| format!("`{text}` is more than any memory"))
}

/// A bar on the standard error, where someone looks at it.
pub(crate) fn progress(steps: usize) -> ProgressBar {
    if !std::io::stderr().is_terminal() {
        return ProgressBar::hidden();
    }
    let style =
        ProgressStyle::with_template("{wide_bar} {percent:>3} %  {eta} left").unwrap_or_else(|_| ProgressStyle::default_bar());
    ProgressBar::new(steps as u64).with_style(style)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bytes_have_units_of_1024() {
        assert_eq!(["7", "64K", "256MiB", "2 GB"].map(bytes), [Ok(7), Ok(65_536), Ok(256 << 20), Ok(2 << 30)]);
        for wrong in ["", "M", "-1", "1.5G", "9T", "99999999999G"] {
            assert!(bytes(wrong).is_err(), "{wrong}");
        }
    }
}
