//! The errors of cases and scenes.

use std::fmt;
use std::path::PathBuf;

use crate::messages::{Bytes, candidates, printable, quoted};
use crate::place::Place;

/// Every way in which a case, a scene or a file is refused. Messages say where: the column of the line, the part of the case, or
/// the file and its line.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The text is not JSON, a number does not fit a double, a field is missing or has another shape than its own.
    #[error("column {column}: {}", printable(rule))]
    Json {
        /// Column of the line, in bytes from 1, where reading stopped.
        column: usize,
        /// The value found and the value expected.
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
        /// The error of its polygon.
        source: radgrad_core::Error,
    },
    /// The tolerance is not a number in [0, 1].
    #[error(transparent)]
    Tolerance(radgrad_core::Error),
    /// The tolerance is finer than doubles are.
    #[error(
        "tolerance is {tolerance:e}: doubles are rounded by 1.1e-16 of themselves, so ask for decimal digits, \"digits\": {digits}"
    )]
    TooFine {
        /// The tolerance as given.
        tolerance: f64,
        /// Digits that meet it.
        digits: u32,
    },
    /// Digits do not meet the tolerance that stands beside them.
    #[error("{digits} digits do not meet the tolerance of {tolerance:e}: leave one of them out")]
    TooFewDigits {
        /// Digits asked for.
        digits: u32,
        /// The tolerance as given.
        tolerance: f64,
    },
    /// Two answers that were asked for do not go together.
    #[error("{first} and {second} do not go together: ask for one of them")]
    Together {
        /// `digits`, `an expression`.
        first: &'static str,
        /// `hessian`, `digits`.
        second: &'static str,
    },
    /// An expression cannot be read.
    #[error("emission: column {column} of the expression: {}", printable(rule))]
    Expression {
        /// Column of the expression, in bytes from 1.
        column: usize,
        /// The rule that it breaks there.
        rule: String,
    },
    /// An expression has no value somewhere on the emitter.
    #[error("emission is {value} at {point}: it must be finite all over the emitter")]
    ExpressionNotFinite {
        /// Where.
        point: radgrad_core::DVec3,
        /// Its value there.
        value: f64,
    },
    /// The case is valid, but its answer cannot be represented.
    #[error(transparent)]
    Evaluation(radgrad_core::Error),

    /// An error in a file, with its place.
    #[error("{place}: {fault}")]
    At {
        /// The place.
        place: Place,
        /// The error there.
        #[source]
        fault: Box<Self>,
    },
    /// A file cannot be read.
    #[error("`{}` cannot be read: {reason}", printable(&file.to_string_lossy()))]
    Unreadable {
        /// The file.
        file: PathBuf,
        /// The system's message.
        reason: String,
    },
    /// The name of a file does not tell its format.
    #[error("`{}` is no scene that is read here: expected a name ending in .obj, .gltf, .glb, .vs3, .stl or .ply", printable(&file.to_string_lossy()))]
    Format {
        /// The file.
        file: PathBuf,
    },
    /// Reading would take more memory than it may.
    #[error("{}: reading takes more than the {} that it may: give more with --budget", printable(what), Bytes(*budget))]
    Budget {
        /// The things that would have taken it.
        what: String,
        /// Bytes that reading may take in all.
        budget: u64,
    },
    /// The host computes otherwise than the bounds assume.
    #[error("{rule} in this thread: no bound holds, so set the floating-point mode back to its default")]
    Host {
        /// Its fault.
        rule: &'static str,
    },
    /// A case takes more than it may.
    #[error(
        "it takes at least {needed:.2e} operations, and a line may take {limit:.2e}: ask for a wider tolerance, give fewer vertices and \
         occluders, or allow more effort"
    )]
    Effort {
        /// Operations that it is known to take.
        needed: f64,
        /// Operations that it may take.
        limit: f64,
    },
    /// A line has more bytes than lines may have.
    #[error("a line has at most {}, this one more", Bytes(*bytes as u64))]
    TooLong {
        /// Bytes that a line may have.
        bytes: usize,
    },
    /// The program failed in a way that it should not.
    #[error("the program failed at this case: please report it")]
    Fault,
    /// An answer is no finite number.
    #[error("{what} is {value}: it is beyond the range of a double")]
    NotFinite {
        /// The quantity to be computed.
        what: String,
        /// The value.
        value: f64,
    },
    /// The file does not follow its format.
    #[error("expected {}, found {}", printable(expected), printable(found))]
    Expected {
        /// The text or value that the format asks for.
        expected: String,
        /// The text or value in the file.
        found: String,
    },
    /// The file is right, but this part of it is not read here.
    #[error("{} cannot be represented: {instead}", printable(what))]
    Unsupported {
        /// The part.
        what: String,
        /// A way to do without it.
        instead: &'static str,
    },
    /// A face is no polygon.
    #[error("face refused: {0}")]
    Face(#[source] radgrad_core::Error),
    /// A face is off its plane and cannot be split into triangles.
    #[error("face refused: {0}, and seen along its normal the face crosses or touches itself: it cannot be split")]
    Warped(#[source] radgrad_core::Error),
    /// A `View3D` subsurface does not lie in its base.
    #[error("subsurface of surface {base}: {}", printable(rule))]
    Subsurface {
        /// Number of the base surface.
        base: usize,
        /// The value found and the values allowed.
        rule: String,
    },
    /// A value of a material is out of range.
    #[error("material `{}`: {quantity} is {value} in channel `{}`: it must be {rule}", printable(material), printable(channel))]
    Material {
        /// Name of the material.
        material: String,
        /// `reflectance` or `radiance`.
        quantity: &'static str,
        /// Name of the channel.
        channel: String,
        /// The value as given.
        value: f64,
        /// The values allowed.
        rule: &'static str,
    },
    /// A texture, or its effect on a material, is refused.
    #[error("texture `{}`: {}", printable(texture), printable(rule))]
    Texture {
        /// Name of the texture.
        texture: String,
        /// The value found and the values allowed.
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
    /// Faces lie in one plane, face the same way and overlap.
    #[error(
        "{}: light from there would count twice. Leave one of them out, cut it out of the other (`--overlaps cut`, \
         `Scene::resolve_overlaps`), or move it before the other",
        Overlapping::listed(pairs, *more)
    )]
    Overlap {
        /// The pairs.
        pairs: Vec<Overlapping>,
        /// As many more there are.
        more: usize,
    },
    /// The sum of a face's form factors to all others is more than 1.
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
        /// The power of two that multiplies lengths.
        power: f64,
    },
    /// A face is no polygon without the rounding that its large coordinates have.
    #[error("{face} is no polygon when the scene is moved to its centre, where coordinates are not rounded as much: {source}")]
    Placed {
        /// The face with its surface.
        face: String,
        /// The error of its polygon.
        source: radgrad_core::Error,
    },
    /// A list has another length than it must have.
    #[error("{found} {what} were given: expected {expected}")]
    Count {
        /// The name of the entries.
        what: &'static str,
        /// Entries given.
        found: usize,
        /// Entries expected.
        expected: usize,
    },
    /// There is no entry of this index or name.
    #[error("there is no {what} {}: {}", printable(which), printable(known))]
    Missing {
        /// `surface`, `material`, ...
        what: &'static str,
        /// The name asked for.
        which: String,
        /// The names that there are.
        known: String,
    },
    /// The work was ended from elsewhere.
    #[error("the work was ended before it was done")]
    Stopped,
    /// Writing failed.
    #[error("cannot be written: {reason}")]
    Unwritable {
        /// The system's message.
        reason: String,
    },
}

/// Two faces that overlap.
#[derive(Debug, Clone, PartialEq)]
pub struct Overlapping {
    /// The faces with their surfaces, and their places where they were read.
    pub faces: [String; 2],
    /// A point of both.
    pub at: radgrad_core::DVec3,
    /// The part of the smaller one that both have.
    pub share: f64,
}

impl Overlapping {
    fn listed(pairs: &[Self], more: usize) -> String {
        let said = pairs.iter().map(ToString::to_string);
        said.chain((more > 0).then(|| format!("and {more} pairs more"))).collect::<Vec<_>>().join("; ")
    }
}

impl fmt::Display for Overlapping {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { faces: [first, second], at, share } = self;
        let (x, y, z) = (at.x, at.y, at.z);
        write!(
            f,
            "{first} and {second} overlap in one plane around ({x:?}, {y:?}, {z:?}), on {:.3} % of the smaller",
            100.0 * share
        )
    }
}

impl Error {
    /// A value other than the expected one was found.
    pub(crate) fn expected(expected: impl Into<String>, found: impl Into<String>) -> Self {
        Self::Expected { expected: expected.into(), found: found.into() }
    }

    /// The same, at a place.
    #[must_use]
    pub(crate) fn at_place(self, place: Place) -> Self {
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

    /// The error itself, without the place.
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
        let rule = text.strip_suffix(&place).unwrap_or(&text);
        Self::Json { column: error.column(), rule: misspelt(rule).unwrap_or_else(|| printable(rule).into_owned()) }
    }
}

/// A better message than serde's for an unknown field, with the name that was probably meant.
fn misspelt(rule: &str) -> Option<String> {
    let (field, fields) = rule.strip_prefix("unknown field `")?.rsplit_once("`, expected ")?;
    Some(format!("there is no field {}: {}", quoted(Some(field)), candidates(field, fields.split('`').skip(1).step_by(2))))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_misspelt_field_is_told_from_the_one_meant() {
        let said = misspelt("unknown field `ocluders`, expected one of `id`, `occluders`, `truth`").unwrap();
        assert_eq!(said, "there is no field `ocluders`: did you mean `occluders`? there are `id`, `occluders`, `truth`");
        let said = misspelt("unknown field `zz\u{1b}`, expected `id` or `truth`").unwrap();
        assert_eq!(said, "there is no field `zz\\u{1b}`: there are `id`, `truth`");
    }
}
