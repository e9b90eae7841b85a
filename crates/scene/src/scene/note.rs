//! Notes on a reader's changes and omissions: nothing is changed or left out silently.

use std::fmt;

use crate::messages::printable;
use crate::place::Place;

/// Something changed or left out while reading, and where.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum Note {
    /// A face that is not planar was split into triangles.
    Split {
        /// Where the face is.
        place: Place,
        /// Name of its surface.
        surface: String,
        /// Triangles it became.
        triangles: usize,
        /// Distance of the worst vertex from the plane that fits best.
        distance: f64,
        /// Largest extent of the face along an axis.
        size: f64,
    },
    /// A face whose texture coordinates are no affine function of the position was split into triangles.
    SplitForTexture {
        /// Where the face is.
        place: Place,
        /// Name of its surface.
        surface: String,
        /// Triangles it became.
        triangles: usize,
        /// Distance of the worst vertex' coordinates from the affine function of others, in units of the texture.
        off: f64,
    },
    /// Vertices of faces were moved onto the planes that they were on before their coordinates were rounded.
    Healed {
        /// The face with the vertex that was moved farthest.
        place: Place,
        /// Faces with a vertex that was moved.
        faces: usize,
        /// The largest motion.
        distance: f64,
        /// The rounding of the coordinates.
        precision: f64,
    },
    /// Vertices that repeat their predecessor were left out.
    RepeatedVertices {
        /// The first face.
        place: Place,
        /// How many faces have such.
        faces: usize,
    },
    /// Faces were left out: they are without area, or thinner than their coordinates are rounded, or no polygon where
    /// [`crate::Degenerate::Drop`] is asked for.
    LeftOut {
        /// The first of them.
        place: Place,
        /// How many there are.
        faces: usize,
        /// Why the first is no polygon; none if it is thinner than the rounding alone.
        reason: Option<radgrad_core::Error>,
        /// The rounding of the coordinates.
        precision: f64,
    },
    /// A reflectance was made smaller, as [`crate::Scene::cap_reflectance`] asks.
    Capped {
        /// Name of the material.
        material: String,
        /// The largest reflectance that was left.
        most: f64,
    },
    /// A face whose outline comes back to a vertex of its own, as it does around a hole, was cut there.
    Bridged {
        /// Where the face is.
        place: Place,
        /// Name of its surface.
        surface: String,
        /// Parts it became.
        parts: usize,
    },
    /// Of two faces that are the same one was left out.
    SameFace {
        /// Where the one left out is.
        place: Option<Place>,
        /// Its name.
        face: String,
        /// The name and the place of the one that was kept.
        kept: String,
        /// Whether that is the later one, since it emits light and the other does not.
        emits: bool,
        /// The material of the one left out, if it is another.
        unused: Option<String>,
    },
    /// A face was cut around smaller ones that lie in it.
    Cut {
        /// Where the face is.
        place: Option<Place>,
        /// Its name.
        face: String,
        /// Pieces that are left of it.
        pieces: usize,
        /// The name and the place of the first of those that it was cut around.
        around: String,
        /// How many more there are.
        more: usize,
    },
    /// A face was left out since smaller ones cover all of it.
    Covered {
        /// Where the face is.
        place: Option<Place>,
        /// Its name.
        face: String,
        /// The name and the place of the first of those that cover it.
        by: String,
        /// How many more there are.
        more: usize,
    },
    /// Faces overlap by no more than the rounding of coordinates explains, and were left as they are.
    SmallOverlaps {
        /// Where the first one is.
        place: Option<Place>,
        /// Pairs of such faces.
        pairs: usize,
        /// The largest error of a coordinate.
        precision: f64,
    },
    /// A part of the file was not used.
    Ignored {
        /// Where it stands first.
        place: Place,
        /// The thing, and the reader's replacement for it.
        what: String,
    },
}

impl Note {
    /// Where it happened, if it was while reading a file.
    #[must_use]
    pub const fn place(&self) -> Option<&Place> {
        match self {
            Self::Capped { .. } => None,
            Self::SameFace { place, .. }
            | Self::Cut { place, .. }
            | Self::Covered { place, .. }
            | Self::SmallOverlaps { place, .. } => place.as_ref(),
            Self::Split { place, .. }
            | Self::SplitForTexture { place, .. }
            | Self::Bridged { place, .. }
            | Self::Healed { place, .. }
            | Self::RepeatedVertices { place, .. }
            | Self::LeftOut { place, .. }
            | Self::Ignored { place, .. } => Some(place),
        }
    }
}

impl fmt::Display for Note {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(place) = self.place() {
            write!(f, "{place}: ")?;
        }
        match self {
            Self::Capped { material, most } => {
                write!(f, "material `{}` reflects more than {most}: capped, as was asked", printable(material))
            }
            Self::Split { surface, triangles, distance, size, .. } => write!(
                f,
                "a face of `{}` has a vertex {distance:.3e} off its plane (size {size:.3e}): split into {triangles} triangles",
                printable(surface)
            ),
            Self::SplitForTexture { surface, triangles, off, .. } => write!(
                f,
                "a face of `{}` has texture coordinates {off:.3e} off an affine function: split into {triangles} triangles",
                printable(surface)
            ),
            Self::Healed { faces, distance, precision, .. } => {
                let faces = Counted(*faces, "face");
                write!(
                    f,
                    "coordinates are rounded by {precision:.1e}: vertices of {faces} were moved onto common planes, by {distance:.1e} at most (here)"
                )
            }
            Self::RepeatedVertices { faces, .. } => {
                write!(f, "vertices that repeat their predecessor were left out of {}, this one first", Counted(*faces, "face"))
            }
            Self::LeftOut { faces, reason, precision, .. } => {
                write!(f, "{} left out, this one first: ", Counted(*faces, "face"))?;
                match reason {
                    Some(reason) => write!(f, "{reason}"),
                    None => write!(f, "it is thinner than the rounding of its coordinates, {precision:.1e}"),
                }
            }
            Self::Bridged { surface, parts, .. } => write!(
                f,
                "a face of `{}` comes back to a vertex of its own, as around a hole: cut there into {parts} parts",
                printable(surface)
            ),
            Self::SameFace { face, kept, emits, unused, .. } => {
                write!(f, "{} is left out: it is the same as {}", printable(face), printable(kept))?;
                if *emits {
                    f.write_str(", which emits light")?;
                }
                unused.as_ref().map_or(Ok(()), |material| write!(f, "; its material `{}` is not used", printable(material)))
            }
            Self::Cut { face, pieces, around, more, .. } => {
                let parts = if *pieces == 1 { "its rest".to_owned() } else { format!("{pieces} pieces") };
                write!(f, "{} is cut into {parts} around {}{}", printable(face), printable(around), others(*more))
            }
            Self::Covered { face, by, more, .. } => {
                write!(f, "{} is left out: all of it is covered by {}{}", printable(face), printable(by), others(*more))
            }
            Self::SmallOverlaps { pairs, precision, .. } => write!(
                f,
                "{pairs} pairs of faces, here the first, overlap by no more than coordinates rounded by {precision:.1e} explain: \
                 left as they are"
            ),
            Self::Ignored { what, .. } => f.write_str(&printable(what)),
        }
    }
}

/// A number of things.
struct Counted(usize, &'static str);

impl fmt::Display for Counted {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self(count, thing) = *self;
        write!(f, "{count} {thing}{}", if count == 1 { "" } else { "s" })
    }
}

/// Others that are not named.
fn others(count: usize) -> String {
    match count {
        0 => String::new(),
        1 => " and one other".to_owned(),
        count => format!(" and {count} others"),
    }
}
