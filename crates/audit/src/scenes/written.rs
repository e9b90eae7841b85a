//! A scene as files have it: turned, far from the origin, with rounded coordinates, with faces that lie on larger ones.

use std::fmt::Write;

use glam::DVec3;
use radgrad_scene::{Degenerate, Scene, obj};

use super::model::{Model, Part};

/// How a file rounds coordinates.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Rounding {
    /// To single precision.
    Single,
    /// To so many decimals.
    Decimals(usize),
}

/// How a scene is placed and written.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Written {
    /// Where the axes go: orthonormal.
    pub axes: [DVec3; 3],
    /// Where the origin goes.
    pub by: DVec3,
    /// The rounding of coordinates.
    pub rounding: Rounding,
}

impl Written {
    /// A direction of the scene in the file.
    #[must_use]
    pub fn turned(&self, direction: DVec3) -> DVec3 {
        let [x, y, z] = self.axes;
        x * direction.x + y * direction.y + z * direction.z
    }

    /// A point of the scene in the file, before it is rounded.
    #[must_use]
    pub fn placed(&self, point: DVec3) -> DVec3 {
        self.turned(point) + self.by
    }

    /// Where a point of the file is in the scene, to rounding.
    #[must_use]
    pub fn undone(&self, point: DVec3) -> DVec3 {
        DVec3::from(self.axes.map(|axis| axis.dot(point - self.by)))
    }
}

impl Rounding {
    /// A coordinate as the file has it.
    #[must_use]
    pub fn text(self, coordinate: f64) -> String {
        match self {
            #[expect(clippy::cast_possible_truncation, reason = "rounding is meant")]
            Self::Single => (coordinate as f32).to_string(),
            Self::Decimals(count) => format!("{coordinate:.count$}"),
        }
    }
}

/// A part of a parallelogram: from the fractions `low` to the fractions `high` of the sides from its first corner.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Window {
    /// The lower fractions.
    pub low: [f64; 2],
    /// The upper fractions.
    pub high: [f64; 2],
}

impl Window {
    /// All of it.
    pub const WHOLE: Self = Self { low: [0.0; 2], high: [1.0; 2] };

    /// Its corners in a parallelogram.
    #[must_use]
    pub fn corners(&self, of: &[DVec3]) -> Vec<DVec3> {
        let point = |x: f64, y: f64| of[0] + (of[1] - of[0]) * x + (of[3] - of[0]) * y;
        let ([x0, y0], [x1, y1]) = (self.low, self.high);
        vec![point(x0, y0), point(x1, y0), point(x1, y1), point(x0, y1)]
    }

    /// The window that is `inner` of this one.
    fn within(&self, inner: &Self) -> Self {
        let place_within = |place: [f64; 2]| [0, 1].map(|k| self.low[k] + (self.high[k] - self.low[k]) * place[k]);
        Self { low: place_within(inner.low), high: place_within(inner.high) }
    }

    /// The remainder of it around another: below, above, before and behind.
    fn around(&self, hole: &Self) -> Vec<Self> {
        let clipped = |place: [f64; 2]| [0, 1].map(|k| place[k].clamp(self.low[k], self.high[k]));
        let ([x0, y0], [x1, y1]) = (clipped(hole.low), clipped(hole.high));
        let Self { low, high } = *self;
        let sides = [
            Self { low, high: [high[0], y0] },
            Self { low: [low[0], y1], high },
            Self { low: [low[0], y0], high: [x0, y1] },
            Self { low: [x1, y0], high: [high[0], y1] },
        ];
        sides.into_iter().filter(|one| one.low[0] < one.high[0] && one.low[1] < one.high[1]).collect()
    }
}

/// Where a face lies on a larger one, or on one that is the same.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Lies {
    /// The index of that face, a parallelogram of which nothing is seen there.
    pub on: usize,
    /// The part of it that is covered.
    pub at: Window,
}

impl Lies {
    /// The same where a face is left out, of which it is known on which it lay.
    #[must_use]
    pub(super) fn without(self, part: usize, below: Option<Self>) -> Option<Self> {
        let lies =
            if self.on == part { below.map(|below| Self { on: below.on, at: below.at.within(&self.at) }) } else { Some(self) };
        lies.map(|lies| Self { on: lies.on - usize::from(lies.on > part), ..lies })
    }
}

/// The visible part of each face, where others lie on it: the index of the face, and the outline of a piece.
pub(super) fn visible_pieces(parts: &[Part]) -> Vec<(usize, Vec<DVec3>)> {
    let pieces = |(index, part): (usize, &Part)| {
        let holes: Vec<Window> =
            parts.iter().filter_map(|other| other.lies).filter(|lies| lies.on == index).map(|lies| lies.at).collect();
        if holes.is_empty() {
            return vec![(index, part.corners.clone())];
        }
        let around = |pieces: Vec<Window>, hole: &Window| pieces.iter().flat_map(|piece| piece.around(hole)).collect();
        let pieces: Vec<Window> = holes.iter().fold(vec![Window::WHOLE], around);
        pieces.iter().map(|piece| (index, piece.corners(&part.corners))).collect()
    };
    parts.iter().enumerate().flat_map(pieces).collect()
}

/// The scene read from its file.
pub(super) fn read(model: &Model) -> Result<Scene, radgrad_scene::Error> {
    let [file, library] = model.to_obj("scene.mtl");
    obj::parse(file.as_bytes(), "scene.obj".as_ref(), Degenerate::Refuse, |_| Ok(library.clone().into_bytes()))
}

/// Lines `v` of an outline's corners.
pub(super) fn vertices(corners: impl Iterator<Item = DVec3>, text: impl Fn(f64) -> String) -> String {
    corners.fold(String::new(), |mut lines, corner| {
        let [x, y, z] = corner.to_array().map(&text);
        // Writing to a string does not fail.
        let _ = writeln!(lines, "v {x} {y} {z}");
        lines
    })
}
