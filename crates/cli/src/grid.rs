//! `--grid`: points of a plane inside the footprint of a scene, as those of a work plane.

use std::fmt;

use radgrad_core::DVec3;
use radgrad_scene::{Occluders, Scene};

/// The most points.
const MOST: f64 = 1e6;

/// A part of a step that rounding may take from a length.
const SLACK: f64 = 1e-9;

/// A plane across an axis, and the distance of its points.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Grid {
    axis: usize,
    level: f64,
    step: f64,
    margin: f64,
}

/// Why a grid has no points.
#[derive(Debug, thiserror::Error)]
pub(crate) enum Failure {
    #[error(
        "--grid {0}: more than {MOST} points: the scene reaches from {1} to {2}, in the unit of its file: give a larger step"
    )]
    Many(Grid, DVec3, DVec3),
    #[error("--grid {0}: no point of it is inside the scene, which reaches from {1} to {2}")]
    Outside(Grid, DVec3, DVec3),
    #[error("--grid: the scene has no faces")]
    Empty,
}

impl fmt::Display for Grid {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}={},step={}", ["x", "y", "z"][self.axis], self.level, self.step)
    }
}

impl Grid {
    /// `z=0.75,step=0.5`, with `margin=0.5` or without.
    pub(crate) fn parse(text: &str) -> Result<Self, String> {
        let (mut plane, mut step, mut margin) = (None, None, 0.0);
        for part in text.split(',').map(str::trim) {
            let (name, number) = part.split_once('=').ok_or_else(|| format!("`{part}`: expected as in z=0.75,step=0.5"))?;
            let value = number.trim().parse().ok().filter(|value: &f64| value.is_finite());
            let value = value.ok_or_else(|| format!("`{part}`: expected a finite number after `=`"))?;
            match name.trim() {
                "x" | "y" | "z" if plane.is_some() => return Err("more than one of x, y and z: one names the plane".to_owned()),
                "x" => plane = Some((0, value)),
                "y" => plane = Some((1, value)),
                "z" => plane = Some((2, value)),
                "step" if value > 0.0 => step = Some(value),
                "margin" if value >= 0.0 => margin = value,
                "step" | "margin" => return Err(format!("`{part}`: a step is above 0, a margin at least 0")),
                other => return Err(format!("`{other}`: expected x, y or z, then step, and margin if wanted")),
            }
        }
        let (axis, level) = plane.ok_or("no plane: expected as in z=0.75,step=0.5")?;
        let step = step.ok_or("no step: expected as in z=0.75,step=0.5")?;
        Ok(Self { axis, level, step, margin })
    }

    /// Its points, rows from the lower end of each axis on, with the normal along the axis: those below or above which there is a face,
    /// and that are not inside a body.
    pub(crate) fn points(&self, scene: &Scene) -> Result<Vec<(DVec3, DVec3)>, Failure> {
        let (lowest, highest) = scene.bounds().ok_or(Failure::Empty)?;
        let (low, high) = (lowest.to_array(), highest.to_array());
        let [across, along] = [(self.axis + 1) % 3, (self.axis + 2) % 3].map(|axis| self.stops(low[axis], high[axis]));
        if across.len() as f64 * along.len() as f64 > MOST {
            return Err(Failure::Many(*self, lowest, highest));
        }
        let index = Occluders::new(scene.polygons());
        let normal = DVec3::from_array(std::array::from_fn(|axis| if axis == self.axis { 1.0 } else { 0.0 }));
        let faces = scene.faces();
        // From a point inside the scene the first face below and above shows its front.
        let is_inside = |point: DVec3| {
            let first = [normal, -normal].map(|toward| Some((toward, index.first_along(point, toward, &[])?.0)));
            let mut met = first.into_iter().flatten().peekable();
            met.peek().is_some() && met.all(|(toward, face)| faces[face].polygon().normal().dot(toward) < 0.0)
        };
        let place = |(u, v): (f64, f64)| {
            let mut at = [self.level; 3];
            (at[(self.axis + 1) % 3], at[(self.axis + 2) % 3]) = (u, v);
            DVec3::from_array(at)
        };
        let all = along.iter().flat_map(|&v| across.iter().map(move |&u| (u, v)));
        let points: Vec<_> = all.map(place).filter(|&point| is_inside(point)).map(|point| (point, normal)).collect();
        if points.is_empty() {
            return Err(Failure::Outside(*self, lowest, highest));
        }
        Ok(points)
    }

    /// Places between two ends, a step apart and as far from both.
    fn stops(&self, low: f64, high: f64) -> Vec<f64> {
        let width = high - low - 2.0 * self.margin;
        let count = (width / self.step + SLACK).floor().clamp(0.0, 2.0 * MOST);
        let count = if width >= 0.0 { count.max(1.0) } else { 0.0 };
        let first = 0.5 * (low + high) - 0.5 * (count - 1.0) * self.step;
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "clamped above")]
        (0..count as usize).map(|k| first + k as f64 * self.step).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_are_a_step_apart_and_as_far_from_both_walls() {
        let grid = Grid::parse("z=0.75, step=0.5").unwrap();
        assert_eq!(grid.stops(0.0, 2.0), [0.25, 0.75, 1.25, 1.75]);
        assert_eq!(grid.stops(0.0, 2.2).len(), 4);
        assert_eq!(grid.stops(1.0, 1.2), [1.1]);
        assert_eq!(Grid::parse("y=1,step=1,margin=0.5").unwrap().stops(0.0, 3.0), [1.0, 2.0]);
        for wrong in ["z=1", "step=1", "z=1,y=2,step=1", "z=1,step=0", "z=1,step=nan", "z=1,step=1,side=2", "0.75"] {
            assert!(Grid::parse(wrong).is_err(), "{wrong}");
        }
    }
}
