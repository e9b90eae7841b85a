//! Where something stands in a file.

use std::fmt;
use std::path::Path;
use std::sync::Arc;

use serde::{Deserialize, Serialize};

use crate::messages::printable;

/// A position in a file that an error or a note points at.
///
/// ```
/// use radgrad_scene::{Place, Position};
/// assert_eq!(Place::new("room.obj", Position::Line(12)).to_string(), "room.obj:12");
/// ```
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Place {
    file: Arc<Path>,
    position: Position,
}

/// Where in the file.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[non_exhaustive]
pub enum Position {
    /// The file as a whole.
    File,
    /// A line, from 1.
    Line(usize),
    /// A member of a JSON document, as a path: `nodes[3].mesh`.
    Member(String),
    /// A triangle of a glTF mesh, all counted from 0.
    Triangle {
        /// Index of the mesh.
        mesh: usize,
        /// Index of the primitive in the mesh.
        primitive: usize,
        /// Index of the triangle in the primitive.
        triangle: usize,
    },
}

impl Place {
    /// A position in `file`.
    #[must_use]
    pub fn new(file: impl AsRef<Path>, position: Position) -> Self {
        Self { file: file.as_ref().into(), position }
    }

    /// A position in a file whose name many places have in common.
    pub(crate) fn in_file(file: &Arc<Path>, position: Position) -> Self {
        Self { file: Arc::clone(file), position }
    }

    /// The file.
    #[must_use]
    pub fn file(&self) -> &Path {
        &self.file
    }

    /// Where in the file.
    #[must_use]
    pub const fn position(&self) -> &Position {
        &self.position
    }
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let file = self.file.to_string_lossy();
        let file = printable(&file);
        match &self.position {
            Position::File => write!(f, "{file}"),
            Position::Line(line) => write!(f, "{file}:{line}"),
            Position::Member(path) => write!(f, "{file}: {}", printable(path)),
            Position::Triangle { mesh, primitive, triangle } => {
                write!(f, "{file}: meshes[{mesh}].primitives[{primitive}], triangle {triangle}")
            }
        }
    }
}
