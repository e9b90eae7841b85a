//! Names of drawn cases and scenes: `contact:1:17` is case 17 of family `contact` under seed 1, and `slit:1:17` is a scene
//! likewise.

use std::fmt;
use std::marker::PhantomData;
use std::str::FromStr;

/// A set of families, of cases or of scenes.
pub trait Families: Copy + fmt::Debug + 'static {
    /// All of them, in the order of the tables.
    const EVERY: &'static [Self];
    /// A family, as messages call it.
    const KIND: &'static str;
    /// A member, as messages call it, and the name of one.
    const MEMBER: [&'static str; 2];

    /// Name in tables and ids.
    fn id(self) -> &'static str;

    /// The family of a name.
    ///
    /// # Errors
    /// If no family has it.
    fn find(name: &str) -> Result<Self, UnknownFamily<Self>> {
        let family = Self::EVERY.iter().copied().find(|family| family.id() == name);
        family.ok_or_else(|| UnknownFamily(name.to_owned(), PhantomData))
    }

    /// Names of all, as messages list them.
    #[must_use]
    fn list() -> String {
        Self::EVERY.iter().map(|family| family.id()).collect::<Vec<_>>().join(", ")
    }
}

/// The name of a member of a family.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Name<F> {
    /// Its family.
    pub family: F,
    /// Seed of the run.
    pub seed: u64,
    /// Its number in the family, from 0.
    pub index: u64,
}

impl<F: Families> fmt::Display for Name<F> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}:{}:{}", self.family.id(), self.seed, self.index)
    }
}

impl<F: Families> FromStr for Name<F> {
    type Err = BadName<F>;

    fn from_str(text: &str) -> Result<Self, BadName<F>> {
        let shape = || BadName::Shape(text.to_owned());
        let mut parts = text.split(':');
        let (Some(family), Some(seed), Some(index), None) = (parts.next(), parts.next(), parts.next(), parts.next()) else {
            return Err(shape());
        };
        let number = |text: &str| text.parse().map_err(|_| shape());
        Ok(Self { family: F::find(family)?, seed: number(seed)?, index: number(index)? })
    }
}

/// A family was named that does not exist.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("no {} is called {_0:?}: the families are {}", F::KIND, F::list())]
pub struct UnknownFamily<F: Families>(String, PhantomData<F>);

/// A text that is not the name of a member.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum BadName<F: Families> {
    /// Not three parts, or numbers that are none.
    #[error("{_0:?} is not the name of a {}: family:seed:index, such as {}", F::MEMBER[0], F::MEMBER[1])]
    Shape(String),
    /// The family does not exist.
    #[error(transparent)]
    Family(#[from] UnknownFamily<F>),
}
