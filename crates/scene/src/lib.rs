//! The files that `radgrad` reads and writes, and the search for occluders.
//!
//! - [`case`]: single cases as JSON Lines.
//! - [`Scene`]: named surfaces with materials, read from OBJ and MTL ([`obj`]), glTF 2.0 ([`gltf`]), `View3D` files
//!   ([`view3d`], which also writes matrices of form factors), and meshes without materials from STL ([`stl`]) and PLY ([`ply`]).
//! - [`Occluders`]: an index of a scene's polygons that finds those that may hide a part of an emitter from a receiver.
//! - [`heat_balance`]: temperatures and heat of grey surfaces, from form factors.
//! - [`output`]: files that are whole or not there.
//!
//! Scenes hold radiances; what they are in other units is on the guide's page `docs/guide/units.md`.
//!
//! Everything read here passes through the types of `radgrad-core`, so a [`case::Problem`] or a [`Face`] that exists is valid.

pub mod case;
mod digest;
mod error;
mod extremes;
mod factors;
pub mod gltf;
mod heat;
mod host;
pub mod obj;
mod occluders;
pub mod output;
mod place;
pub mod ply;
mod projection;
mod reading;
mod scene;
pub mod stl;
mod texture;
pub mod view3d;
mod warning;
mod words;

#[doc(hidden)]
pub use digest::fnv1a;
pub use error::{Error, Overlapping};
pub use extremes::{largest, smallest};
#[doc(hidden)]
pub use factors::probes;
pub use factors::{
    BlockOperator, Certified, ComputedRow, Counted, Entry, Factor, FactorBlock, FactorMatrix, FactorOperator, FactorSettings,
    FieldCell, FormFactors, Narrowed, RayEntry, RayFactors, RayRow, RaySettings, Repaired, SurfaceFactor, SurfaceMatrix,
    gauss_legendre,
};
pub use heat::{Boundary, HeatError, STEFAN_BOLTZMANN, SurfaceHeat, heat_balance, heat_jacobian, reciprocal_areas};
pub use host::check_host;
#[doc(hidden)]
pub use occluders::Boxes;
pub use occluders::{Beam, Found, Occluders, contains};
pub use place::{Place, Position};
pub use reading::{Materials, Reading, read_file};
pub use scene::split::{is_parallelogram, triangles as triangulate};
pub use scene::{
    Closedness, Degenerate, Face, GivenFace, Material, Modelling, Note, Overlaps, Part, Placement, Prepared, Scene, Seam,
    SeamKind, Surface,
};
pub use texture::{Chart, Piece, Quantity, Texture, Wrap};
pub use warning::Warning;
pub use words::printable;

/// The content of a scene's own file.
fn open(file: &std::path::Path, budget: &reading::Budget) -> Result<Vec<u8>, Error> {
    reading::read_regular(file, budget).map_err(|error| Error::Unreadable { file: file.to_owned(), reason: error.to_string() })
}
