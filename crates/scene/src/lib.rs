//! What `radgrad` reads and writes, and what may hide what.
//!
//! - [`case`]: single cases as JSON Lines.
//! - [`Scene`]: named surfaces with materials, read from OBJ and MTL ([`obj`]), glTF 2.0 ([`gltf`]) and `View3D` files
//!   ([`view3d`], which also writes matrices of form factors).
//! - [`Occluders`]: an index of a scene's polygons that finds those that may hide a part of an emitter from a receiver.
//!
//! Everything read here passes through the types of `radgrad-core`, so a [`case::Problem`] or a [`Face`] that exists is valid.

pub mod case;
mod error;
mod extremes;
mod factors;
pub mod gltf;
pub mod obj;
mod occluders;
mod place;
mod projection;
mod scene;
mod texture;
pub mod view3d;
mod warning;
mod words;

use std::path::Path;

pub use error::Error;
pub use extremes::{largest, smallest};
pub use factors::{Entry, Factor, FactorMatrix, FactorSettings, FieldCell, FormFactors, SurfaceMatrix, gauss_legendre};
pub use occluders::{Beam, Found, Occluders};
pub use place::{Place, Position};
pub use scene::split::triangles as triangulate;
pub use scene::{Degenerate, Face, Material, Note, Placement, Prepared, Scene, Surface};
pub use texture::{Chart, Piece, Quantity, Texture, Wrap};
pub use warning::Warning;

/// The content of a file.
fn open(file: &Path) -> Result<Vec<u8>, Error> {
    std::fs::read(file).map_err(|error| Error::Unreadable { file: file.to_owned(), reason: error.to_string() })
}
