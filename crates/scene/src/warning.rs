//! Warnings: properties of a valid scene that are probably not meant.

use std::fmt;

/// A property of a scene that its maker probably did not mean. Answers are those of the scene as it is.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum Warning {
    /// No face emits light: all radiosities are 0.
    Dark,
    /// No face has another before it.
    InsideOut,
    /// Faces of these surfaces emit light and have nothing before them.
    LightsNothing {
        /// Their names.
        surfaces: Vec<String>,
    },
    /// No face of these surfaces has anything before it.
    SeesNothing {
        /// Their names.
        surfaces: Vec<String>,
    },
    /// Coordinates are so large that few digits are left to the extent of the scene.
    Coarse {
        /// The largest coordinate.
        largest: f64,
        /// The distance of doubles there.
        spacing: f64,
        /// Binary digits that are left to the extent.
        digits: i32,
    },
}

/// Surfaces that are named; of more their number is given.
const NAMED: usize = 8;

impl fmt::Display for Warning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let names = |surfaces: &[String]| {
            let named: Vec<String> = surfaces.iter().take(NAMED).map(|name| format!("`{name}`")).collect();
            let more = if surfaces.len() > NAMED { format!(" and {} more", surfaces.len() - NAMED) } else { String::new() };
            named.join(", ") + &more
        };
        match self {
            Self::Dark => write!(
                f,
                "the scene has no lamp: no face emits light, so that every radiosity is 0. Lamps have `Ke` in MTL, an `emissiveFactor` in \
                 glTF"
            ),
            Self::InsideOut => write!(
                f,
                "no face has another before it: the scene seems to be turned inside out. A face gives and takes light on the side from \
                 which it is counter-clockwise: turn all faces around with --flip (`Reading::flip`)"
            ),
            Self::LightsNothing { surfaces } => {
                write!(
                    f,
                    "lamps that light nothing, as no face is before them (are they wound the other way?): {}",
                    names(surfaces)
                )
            }
            Self::SeesNothing { surfaces } => {
                write!(
                    f,
                    "surfaces that see nothing, as no face is before them (are they wound the other way?): {}",
                    names(surfaces)
                )
            }
            Self::Coarse { largest, spacing, digits } => write!(
                f,
                "coordinates of up to {largest:e} are multiples of {spacing:e}, which leaves {digits} binary digits to the scene's \
                 extent: what a file says beyond them is lost in reading it"
            ),
        }
    }
}
