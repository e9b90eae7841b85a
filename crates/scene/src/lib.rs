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
mod messages;
pub mod obj;
mod occluders;
pub mod output;
mod place;
mod placement;
pub mod ply;
mod precision;
mod projection;
mod read;
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
pub use factors::block::FactorBlock;
pub use factors::field::FieldCell;
pub use factors::matrix::{ComputedRow, Entry, FactorMatrix, SurfaceFactor, SurfaceMatrix};
pub use factors::narrow::Narrowed;
pub use factors::pair::Factor;
#[doc(hidden)]
pub use factors::probes;
pub use factors::rays::RaySettings;
pub use factors::rays::blocks::BlockOperator;
pub use factors::rays::operator::{Certified, FactorOperator};
pub use factors::rays::pairs::{Counted, RayEntry, RayFactors, RayRow};
pub use factors::repair::Repaired;
pub use factors::rule::gauss_legendre;
pub use factors::{FactorSettings, FormFactors};
pub use heat::{Boundary, HeatError, STEFAN_BOLTZMANN, SurfaceHeat, heat_balance, heat_jacobian, reciprocal_areas};
pub use host::check_host;
pub use messages::printable;
#[doc(hidden)]
pub use occluders::Boxes;
pub use occluders::beam::Beam;
pub use occluders::segment::contains;
pub use occluders::{Found, Occluders};
pub use place::{Place, Position};
pub use placement::Placement;
pub use reading::{Degenerate, Materials, Overlaps, Reading, read_file};
pub use scene::arrays::GivenFace;
pub use scene::material::Material;
pub use scene::note::Note;
pub use scene::prepared::Prepared;
pub use scene::seams::{Closedness, Part, Seam, SeamKind};
pub use scene::split::{is_parallelogram, triangles as triangulate};
pub use scene::{Face, Modelling, Scene, Surface};
pub use texture::chart::Chart;
pub use texture::cut::Piece;
pub use texture::{Quantity, Texture, Wrap};
pub use warning::Warning;
