//! Errors of a scene or of a request.

use radgrad_core::DVec3;

/// Every way in which this crate refuses an input. Messages give the value, its place and the rule it breaks.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A face cannot be cut into triangles.
    #[error("face {face} cannot be cut into triangles: its outline touches itself")]
    Face {
        /// Index of the face in the scene, from 0.
        face: usize,
    },
    /// A part of a face is no polygon any more: it became too small for its coordinates.
    #[error("a part of face {face}: {source}")]
    Element {
        /// Index of the face in the scene, from 0.
        face: usize,
        /// The rule that it breaks.
        source: radgrad_core::Error,
    },
    /// Bytes are no solution of a scene.
    #[error("bytes are no solution of this scene, as this version writes it: {rule}")]
    Bytes {
        /// The rule that they break.
        rule: &'static str,
    },
    /// A radiosity cannot be represented.
    #[error("a radiosity on face {face}: {source}")]
    Evaluation {
        /// Index of the face that receives, from 0.
        face: usize,
        /// The rule that it breaks.
        source: radgrad_core::Error,
    },
    /// A sample cannot be computed.
    #[error("the radiosity at {position}: {source}")]
    Sample {
        /// The point.
        position: DVec3,
        /// The rule that it breaks.
        source: radgrad_core::Error,
    },
    /// A mesh is to be divided where it has no element.
    #[error("division {index} is of element {element}: the mesh has {count} elements then, from 0")]
    Division {
        /// Index of the division, from 0.
        index: usize,
        /// The element.
        element: usize,
        /// Elements of the mesh.
        count: usize,
    },
    /// The error asked for is not positive.
    #[error("the error is {value}: it must be above 0 and at most 1, relative to the mean radiosity that is reflected")]
    Tolerance {
        /// The value given.
        value: f64,
    },
    /// Weights of a sum of radiosities do not fit the scene.
    #[error("weights: {rule}")]
    Weights {
        /// The weights that do not fit, and the ones that would.
        rule: String,
    },
    /// The scene is refused.
    #[error(transparent)]
    Scene(#[from] radgrad_scene::Error),
    /// The form factors from a point to all faces sum to more than 1.
    #[error(
        "a point of {face} sees {sum} of its hemisphere covered, which is more than 1: faces overlap, so that light would count twice. \
         It sees most of {}", faces.join(", ")
    )]
    Covered {
        /// The face with its surface.
        face: String,
        /// The sum of the least that the form factors from there can be.
        sum: f64,
        /// The faces that it sees most of, with their surfaces.
        faces: Vec<String>,
    },
    /// A number is beyond the range of a double.
    #[error("the {quantity} in channel {channel} is {value}: it must be finite")]
    NotFinite {
        /// Name of the quantity.
        quantity: String,
        /// The channel.
        channel: String,
        /// Its value.
        value: f64,
    },
    /// Light is emitted where it is never lost, so that there is no solution.
    #[error(
        "in channel {channel} light is emitted inside of {} and never lost: all of these reflect 1, and nothing else is in there; give one of \
         them a reflectance below 1, or open the space that they enclose",
        named(surfaces)
    )]
    Lossless {
        /// The channel.
        channel: String,
        /// Names of the surfaces around the closed space.
        surfaces: Vec<String>,
    },
    /// Light was reflected again and again, and did not settle.
    #[error(
        "light does not settle: after {sweeps} sweeps it still changes by {change:e} of its mean in each; where hardly any is lost nothing is \
         known of it, so give faces that reflect all light a reflectance below 1"
    )]
    Unsettled {
        /// How often all elements gathered.
        sweeps: usize,
        /// Change by the last sweep over the mean radiosity.
        change: f64,
    },
    /// A point is on no face.
    #[error("no face at {position} faces along {normal}: the point must be within {reach:e} of one")]
    NoFace {
        /// The point.
        position: DVec3,
        /// The normal given.
        normal: DVec3,
        /// The distance allowed.
        reach: f64,
    },
}

/// Names of surfaces that are named in a sentence.
const MOST_NAMES: usize = 8;

fn named(surfaces: &[String]) -> String {
    let names: Vec<String> = surfaces.iter().take(MOST_NAMES).map(|name| format!("`{name}`")).collect();
    let remaining = surfaces.len().saturating_sub(MOST_NAMES);
    if remaining > 0 {
        format!("{} and {remaining} more surfaces", names.join(", "))
    } else {
        format!("surfaces {}", names.join(", "))
    }
}

impl Error {
    /// The same with a sample's place in the coordinates of the scene.
    pub(crate) fn at_position(self, position: DVec3) -> Self {
        match self {
            Self::Sample { source, .. } => Self::Sample { position, source },
            other => other,
        }
    }
}
