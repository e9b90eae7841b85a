//! What can be wrong with a case or with a scene.

use std::path::PathBuf;

use crate::Place;

/// Every way in which a case, a scene or a file is refused. Messages say where: the column of the line, the part of the case, or
/// the file and its line.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The text is not JSON, a number does not fit a double, a field is missing or has another shape than its own.
    #[error("column {column}: {rule}")]
    Json {
        /// Column of the line, in bytes from 1, where reading stopped.
        column: usize,
        /// What was found and what was expected.
        rule: String,
    },
    /// The receiver is refused.
    #[error(transparent)]
    Receiver(radgrad_core::Error),
    /// The emitter's polygon or its emission is refused.
    #[error("emitter: {0}")]
    Emitter(#[source] radgrad_core::Error),
    /// An occluder is refused.
    #[error("occluder {index}: {source}")]
    Occluder {
        /// Its index in `occluders`, from 0.
        index: usize,
        /// What is wrong with its polygon.
        source: radgrad_core::Error,
    },
    /// The tolerance is not a number in [0, 1].
    #[error(transparent)]
    Tolerance(radgrad_core::Error),
    /// The case is valid, but its answer cannot be represented.
    #[error(transparent)]
    Evaluation(radgrad_core::Error),

    /// What is wrong with a file, and where.
    #[error("{place}: {fault}")]
    At {
        /// The place.
        place: Place,
        /// What is wrong there.
        #[source]
        fault: Box<Self>,
    },
    /// A file cannot be read.
    #[error("`{}` cannot be read: {reason}", file.display())]
    Unreadable {
        /// The file.
        file: PathBuf,
        /// What the system says.
        reason: String,
    },
    /// The name of a file does not say what is in it.
    #[error("`{}` is no scene that is read here: expected a name ending in .obj, .gltf, .glb or .vs3", file.display())]
    Format {
        /// The file.
        file: PathBuf,
    },
    /// Something else stands there than what the format asks for.
    #[error("expected {expected}, found {found}")]
    Expected {
        /// What the format asks for.
        expected: String,
        /// What stands there.
        found: String,
    },
    /// What stands there is right, but is not read here.
    #[error("{what} cannot be represented: {instead}")]
    Unsupported {
        /// What it is.
        what: String,
        /// What to do instead.
        instead: &'static str,
    },
    /// A face is no polygon.
    #[error("face refused: {0}")]
    Face(#[source] radgrad_core::Error),
    /// A face is off its plane and cannot be split into triangles.
    #[error("face refused: {0}, and seen along its normal the face crosses or touches itself: it cannot be split")]
    Warped(#[source] radgrad_core::Error),
    /// A `View3D` subsurface does not lie in its base.
    #[error("subsurface of surface {base}: {rule}")]
    Subsurface {
        /// Number of the base surface.
        base: usize,
        /// What was found and what is asked for.
        rule: String,
    },
    /// A value of a material is out of range.
    #[error("material `{material}`: {quantity} is {value} in channel `{channel}`: it must be {rule}")]
    Material {
        /// Name of the material.
        material: String,
        /// `reflectance` or `radiance`.
        quantity: &'static str,
        /// Name of the channel.
        channel: String,
        /// The value as given.
        value: f64,
        /// What is allowed.
        rule: &'static str,
    },
    /// A texture is refused, or what it does to a material.
    #[error("texture `{texture}`: {rule}")]
    Texture {
        /// Name of the texture.
        texture: String,
        /// What was found and what is allowed.
        rule: String,
    },
    /// The texture coordinates of a face are no affine function of the position.
    #[error(
        "texture coordinates of vertex {vertex} are {off:.3e} off the affine function of the others (allowed {allowed:e}): \
             split the face into triangles"
    )]
    Chart {
        /// Index of the vertex in the face, from 0.
        vertex: usize,
        /// The distance, in units of the texture.
        off: f64,
        /// The distance allowed.
        allowed: f64,
    },
    /// Two faces lie in one plane, face the same way and overlap.
    #[error(
        "{} and {} overlap in one plane around ({:?}, {:?}, {:?}), on {:.3} % of the smaller: light from there would count twice. \
         Leave one of them out, cut it out of the other, or move it before the other",
        faces[0], faces[1], at.x, at.y, at.z, 100.0 * share
    )]
    Overlap {
        /// The faces with their surfaces, and their places where they were read.
        faces: [String; 2],
        /// A point of both.
        at: radgrad_core::DVec3,
        /// The part of the smaller one that both have.
        share: f64,
    },
    /// What a face sees of all others is more than everything.
    #[error("{face} sees {sum} of its hemisphere covered, which is more than 1: faces before it overlap, and would count twice")]
    Covered {
        /// The face with its surface.
        face: String,
        /// The sum of the least that its factors can be.
        sum: f64,
    },
    /// A scene has lengths that no unit brings into the range of doubles.
    #[error(
        "{face}: vertex {vertex} at {value:?} loses digits when the scene is scaled by {power:e}, which brings its largest coordinate \
         to 1: its lengths are of too different sizes"
    )]
    Range {
        /// The face with its surface.
        face: String,
        /// Index of the vertex in it, from 0.
        vertex: usize,
        /// The vertex.
        value: radgrad_core::DVec3,
        /// What lengths are multiplied by.
        power: f64,
    },
    /// A face is no polygon without the rounding that its large coordinates have.
    #[error("{face} is no polygon when the scene is moved to its centre, where coordinates are not rounded as much: {source}")]
    Placed {
        /// The face with its surface.
        face: String,
        /// What is wrong with it.
        source: radgrad_core::Error,
    },
    /// A list has another length than it must have.
    #[error("{found} {what} were given: expected {expected}")]
    Count {
        /// What is listed.
        what: &'static str,
        /// Entries given.
        found: usize,
        /// Entries expected.
        expected: usize,
    },
    /// There is no entry of this index or name.
    #[error("there is no {what} {which}: {known}")]
    Missing {
        /// `surface`, `material`, ...
        what: &'static str,
        /// What was asked for.
        which: String,
        /// What there is.
        known: String,
    },
    /// Writing failed.
    #[error("cannot be written: {reason}")]
    Unwritable {
        /// What the system says.
        reason: String,
    },
}

impl Error {
    /// Something else was found than what was expected.
    pub(crate) fn expected(expected: impl Into<String>, found: impl Into<String>) -> Self {
        Self::Expected { expected: expected.into(), found: found.into() }
    }

    /// The same, at a place.
    #[must_use]
    pub(crate) fn at(self, place: Place) -> Self {
        Self::At { place, fault: Box::new(self) }
    }

    /// Where it is, if it is in a file.
    #[must_use]
    pub const fn place(&self) -> Option<&Place> {
        match self {
            Self::At { place, .. } => Some(place),
            _ => None,
        }
    }

    /// What is wrong, without the place.
    #[must_use]
    pub fn fault(&self) -> &Self {
        match self {
            Self::At { fault, .. } => fault.fault(),
            fault => fault,
        }
    }
}

impl From<serde_json::Error> for Error {
    /// Only the column is kept: to `serde_json` every line is line 1.
    fn from(error: serde_json::Error) -> Self {
        let text = error.to_string();
        let place = format!(" at line {} column {}", error.line(), error.column());
        let rule = text.strip_suffix(&place).unwrap_or(&text).to_owned();
        Self::Json { column: error.column(), rule }
    }
}
