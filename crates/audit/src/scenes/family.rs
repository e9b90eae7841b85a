//! Families of scenes, each around one way in which light hides from samples or geometry from tests.

use std::fmt;
use std::str::FromStr;

use super::draw;
use super::model::Model;
use crate::sampler::Sampler;

/// One way of being difficult.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Family {
    /// A closed room with boxes in it and lamps under its ceiling, in one channel or three.
    Clutter,
    /// A closed room with boxes where every face emits what it does not reflect: the radiosity is 1.
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
}

impl Family {
    /// All of them, in the order of the tables.
    pub const ALL: [Self; 20] = [
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
            Self::Strips => draw::strips(sampler),
            Self::Sphere => draw::sphere(sampler),
            Self::Groove => draw::groove(sampler),
            Self::Manufactured => draw::manufactured(sampler),
        };
        if matches!(self, Self::Strips | Self::Sphere | Self::Groove | Self::Manufactured) {
            draw::ways(&mut model, sampler);
        }
        model
    }
}

impl fmt::Display for Family {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

/// A family was named that does not exist.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("no family of scenes is called {0:?}: the families are {list}", list = Family::ALL.map(Family::name).join(", "))]
pub struct UnknownFamily(String);

impl FromStr for Family {
    type Err = UnknownFamily;

    fn from_str(text: &str) -> Result<Self, UnknownFamily> {
        Self::ALL.into_iter().find(|f| f.name() == text).ok_or_else(|| UnknownFamily(text.to_owned()))
    }
}

/// The name of a scene: `slit:1:17` is scene 17 of family `slit` under seed 1.
///
/// ```
/// use radgrad_audit::scenes::family::{Family, Name};
/// let name: Name = "slit:1:17".parse()?;
/// assert_eq!((name.family, name.index), (Family::Slit, 17));
/// assert_eq!(name.model(), Family::Slit.model(1, 17), "the same bits on every machine");
/// # Ok::<(), radgrad_audit::scenes::family::BadName>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Name {
    /// Its family.
    pub family: Family,
    /// Seed of the run.
    pub seed: u64,
    /// Its number in the family, from 0.
    pub index: u64,
}

impl Name {
    /// The scene of this name.
    #[must_use]
    pub fn model(self) -> Model {
        self.family.model(self.seed, self.index)
    }
}

impl fmt::Display for Name {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}:{}:{}", self.family, self.seed, self.index)
    }
}

/// A text that is not the name of a scene.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum BadName {
    /// Not three parts, or numbers that are none.
    #[error("{0:?} is not the name of a scene: family:seed:index, such as slit:1:17")]
    Shape(String),
    /// The family does not exist.
    #[error(transparent)]
    Family(#[from] UnknownFamily),
}

impl FromStr for Name {
    type Err = BadName;

    fn from_str(text: &str) -> Result<Self, BadName> {
        let shape = || BadName::Shape(text.to_owned());
        let mut parts = text.split(':');
        let (Some(family), Some(seed), Some(index), None) = (parts.next(), parts.next(), parts.next(), parts.next()) else {
            return Err(shape());
        };
        let number = |text: &str| text.parse().map_err(|_| shape());
        Ok(Self { family: family.parse()?, seed: number(seed)?, index: number(index)? })
    }
}
