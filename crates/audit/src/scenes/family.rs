//! Families of scenes, each around one way in which light hides from samples or geometry from tests.

use std::fmt;
use std::str::FromStr;

use super::draw::{self, exact, odd, world};
use super::model::Model;
use super::statement::Subject;
use crate::cases::name::{Families, UnknownFamily};
use crate::cases::sampler::Sampler;

/// One scene in so many has more time.
const LONG: u64 = 8;

/// One way of being difficult.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Family {
    /// A closed room with boxes in it and lamps under its ceiling, in one channel or three.
    Clutter,
    /// A closed room with boxes where every face emits the light that it does not reflect: the radiosity is 1.
    Furnace,
    /// Two rectangles that face each other: known to ten digits.
    Facing,
    /// A lamp in a shade over the floor, of any size and at any height.
    Downlight,
    /// A lamp outside that shines in through a slit of a wall.
    Slit,
    /// The same through a small square hole.
    Pinhole,
    /// Slats between lamp and floor.
    Grating,
    /// A lamp that almost touches the floor or a wall.
    Touching,
    /// Reflectances up to 0.99.
    Bright,
    /// Lamps whose power differs by up to six decades.
    ManyLamps,
    /// Reflectance, and in a third of the scenes emission, by a texture.
    Textured,
    /// Walls cut into needles whose vertices are on the edges of their neighbours.
    TJunctions,
    /// Polygons in the open, some of them lamps.
    Open,
    /// A face lies in another one: to be refused.
    Overlap,
    /// Clutter or a downlight scaled by a power of two: the same digits, or refused.
    Scaled,
    /// The same shifted, every coordinate exactly: right within the bound, or refused.
    Shifted,
    /// Two long rectangles that face each other.
    Strips,
    /// A closed polyhedron around a point, even in reflectance and emission.
    Sphere,
    /// Two rectangles that share an edge.
    Groove,
    /// A room with boxes where reflectance and emission vary so that the radiosity is 1.
    Manufactured,
    /// A room with things that almost touch, cross, stand on each other, or are as thin as can be.
    Odd,
    /// A closed box read from a file, turned, moved and rounded: walls whole or with vertices on their edges, cut, with needles.
    Rounded,
    /// A room read from a file where a window, a lamp and a rug lie on larger faces, and faces are there twice.
    Nested,
    /// A box of more than a thousand faces with plates of two sides, even in light.
    Plates,
}

impl Family {
    /// All of them, in the order of the tables.
    pub const ALL: [Self; 24] = [
        Self::Clutter,
        Self::Furnace,
        Self::Facing,
        Self::Downlight,
        Self::Slit,
        Self::Pinhole,
        Self::Grating,
        Self::Touching,
        Self::Bright,
        Self::ManyLamps,
        Self::Textured,
        Self::TJunctions,
        Self::Open,
        Self::Overlap,
        Self::Scaled,
        Self::Shifted,
        Self::Strips,
        Self::Sphere,
        Self::Groove,
        Self::Manufactured,
        Self::Odd,
        Self::Rounded,
        Self::Nested,
        Self::Plates,
    ];

    /// Name in tables and ids.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Clutter => "clutter",
            Self::Furnace => "furnace",
            Self::Facing => "facing",
            Self::Downlight => "downlight",
            Self::Slit => "slit",
            Self::Pinhole => "pinhole",
            Self::Grating => "grating",
            Self::Touching => "touching",
            Self::Bright => "bright",
            Self::ManyLamps => "many-lamps",
            Self::Textured => "textured",
            Self::TJunctions => "t-junctions",
            Self::Open => "open",
            Self::Overlap => "overlap",
            Self::Scaled => "scaled",
            Self::Shifted => "shifted",
            Self::Strips => "strips",
            Self::Sphere => "sphere",
            Self::Groove => "groove",
            Self::Manufactured => "manufactured",
            Self::Odd => "odd",
            Self::Rounded => "rounded",
            Self::Nested => "nested",
            Self::Plates => "plates",
        }
    }

    /// The subjects of scene `index`: of most families the light, with certificates, and of every third scene factors and fields
    /// too.
    #[must_use]
    pub const fn subjects(self, index: u64) -> &'static [Subject] {
        match self {
            // A bound that rounding widens is known for factors.
            Self::Rounded | Self::Nested => &[Subject::Factors],
            Self::Plates => &[Subject::Solve, Subject::Certificate],
            _ if index.is_multiple_of(3) => &Subject::ALL,
            _ => &[Subject::Solve, Subject::Certificate],
        }
    }

    /// Scene `index` under `seed`.
    #[must_use]
    pub fn model(self, seed: u64, index: u64) -> Model {
        let sampler = &mut Sampler::new(seed, self.name(), index);
        let mut model = match self {
            Self::Clutter => draw::clutter(sampler),
            Self::Furnace => draw::furnace(sampler),
            Self::Facing => draw::facing(sampler),
            Self::Downlight => draw::downlight(sampler),
            Self::Slit => draw::slit(sampler),
            Self::Pinhole => draw::pinhole(sampler),
            Self::Grating => draw::grating(sampler),
            Self::Touching => draw::touching(sampler),
            Self::Bright => draw::bright(sampler),
            Self::ManyLamps => draw::many_lamps(sampler),
            Self::Textured => draw::textured(sampler),
            Self::TJunctions => draw::t_junctions(sampler),
            Self::Open => draw::open(sampler),
            Self::Overlap => draw::overlap(sampler),
            Self::Scaled => draw::scaled(sampler),
            Self::Shifted => draw::shifted(sampler),
            Self::Strips => exact::strips(sampler),
            Self::Sphere => exact::sphere(sampler),
            Self::Groove => exact::groove(sampler),
            Self::Manufactured => exact::manufactured(sampler),
            Self::Odd => odd::odd(sampler),
            Self::Rounded => world::rounded(sampler),
            Self::Nested => world::nested(sampler),
            Self::Plates => world::plates(sampler),
        };
        if matches!(self, Self::Strips | Self::Sphere | Self::Groove | Self::Manufactured | Self::Odd) {
            draw::ways(&mut model, sampler);
        }
        model.ways.long = index % LONG == LONG - 1;
        model
    }
}

impl fmt::Display for Family {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

impl FromStr for Family {
    type Err = UnknownFamily<Self>;

    fn from_str(text: &str) -> Result<Self, UnknownFamily<Self>> {
        Self::find(text)
    }
}

impl Families for Family {
    const EVERY: &'static [Self] = &Self::ALL;
    const KIND: &'static str = "family of scenes";
    const MEMBER: [&'static str; 2] = ["scene", "slit:1:17"];

    fn id(self) -> &'static str {
        self.name()
    }
}

/// The name of a scene: `slit:1:17` is scene 17 of family `slit` under seed 1.
///
/// ```
/// use radgrad_audit::scenes::family::{Family, Name};
/// let name: Name = "slit:1:17".parse()?;
/// assert_eq!((name.family, name.index), (Family::Slit, 17));
/// assert_eq!(name.model(), Family::Slit.model(1, 17), "the same bits on every machine");
/// # Ok::<(), radgrad_audit::cases::name::BadName<Family>>(())
/// ```
pub type Name = crate::cases::name::Name<Family>;

impl Name {
    /// The scene of this name.
    #[must_use]
    pub fn model(self) -> Model {
        self.family.model(self.seed, self.index)
    }
}
