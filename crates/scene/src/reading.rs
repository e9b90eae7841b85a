//! Options of reading a scene: whether faces that are no polygons are dropped, which files may be opened, and how much memory it
//! may take.

use std::cell::Cell;
use std::fs::File;
use std::io::{self, Read};
use std::path::{Path, PathBuf};
use std::rc::Rc;

use crate::error::Error;
use crate::messages::Bytes;

/// Gives the content of a file that another one names. Not generic, so that readers are compiled once.
pub(crate) type ReadFile<'a> = dyn FnMut(&Path) -> io::Result<Vec<u8>> + 'a;

/// Options of a reader. A [`Degenerate`] alone stands for the default of all else.
///
/// ```
/// use radgrad_scene::{Degenerate, Reading, Scene};
/// # let file = concat!(env!("CARGO_MANIFEST_DIR"), "/../../data/scenes/cornell.obj");
/// let small = Reading { budget: 1 << 10, ..Reading::default() };
/// assert!(Scene::read(file, small).unwrap_err().to_string().contains("1 KiB"));
/// assert!(Scene::read(file, Degenerate::Drop).is_ok());
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Reading {
    /// Whether faces that are no polygon are refused or dropped.
    pub degenerate: Degenerate,
    /// Bytes that reading may take in all, for files, faces and texels. A file of a few kilobytes may stand for gigabytes of these.
    pub budget: u64,
    /// Whether files that a scene names may lie outside the folder of the scene.
    pub allow_outside: bool,
    /// Whether the values of the materials are needed.
    pub materials: Materials,
    /// By how much coordinates may be off, in their unit: 0 where they are exact. If it is not given, it is told from how the
    /// coordinates are written.
    pub precision: Option<f64>,
    /// How faces that overlap in one plane are resolved.
    pub overlaps: Overlaps,
    /// Whether every face is turned around, so that it gives and takes light on its other side.
    pub flip: bool,
}

/// The treatment of faces whose outline crosses itself. Faces without area exchange nothing: they are left out, with a [`crate::Note`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Degenerate {
    /// Refuse the file, naming the face.
    #[default]
    Refuse,
    /// Leave them out, with a [`crate::Note`].
    Drop,
}

/// How faces that overlap in one plane and face the same way are resolved.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Overlaps {
    /// A face that is there twice is left out once, and one is cut around others that lie in it, each with a [`crate::Note`]. Faces that overlap in
    /// another way are refused.
    #[default]
    Nested,
    /// The larger one is cut, however they overlap.
    Cut,
    /// All are refused.
    Refuse,
}

/// Whether the values of the materials are needed. Form factors depend on shapes alone.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Materials {
    /// A material that is used and not known is refused.
    #[default]
    Required,
    /// It is taken as black, with a [`crate::Note`].
    Optional,
}

impl Reading {
    /// The bytes of [`Self::budget`] unless others are asked for: 256 MiB, some 200,000 triangles or eight million texels.
    pub const BUDGET: u64 = 256 << 20;

    /// For data in memory already.
    pub(crate) const UNLIMITED: u64 = u64::MAX;
}

impl Default for Reading {
    fn default() -> Self {
        Self {
            degenerate: Degenerate::default(),
            budget: Self::BUDGET,
            allow_outside: false,
            materials: Materials::default(),
            precision: None,
            overlaps: Overlaps::default(),
            flip: false,
        }
    }
}

impl From<Degenerate> for Reading {
    fn from(degenerate: Degenerate) -> Self {
        Self { degenerate, ..Self::default() }
    }
}

/// The bytes of the budget, and those that are left. Memory given back still counts as taken: the budget bounds the work too.
#[derive(Debug)]
pub(crate) struct Budget {
    all: u64,
    left: Cell<u64>,
}

impl Budget {
    pub(crate) fn new(all: u64) -> Rc<Self> {
        Rc::new(Self { all, left: Cell::new(all) })
    }

    /// Takes bytes for something.
    pub(crate) fn take(&self, what: &str, bytes: u64) -> Result<(), Error> {
        match self.left.get().checked_sub(bytes) {
            Some(left) => {
                self.left.set(left);
                Ok(())
            }
            None => Err(self.exceeded(what)),
        }
    }

    /// The error for something that there is no room for.
    pub(crate) fn exceeded(&self, what: &str) -> Error {
        Error::Budget { what: what.to_owned(), budget: self.all }
    }

    /// Takes as many entries of a certain size.
    pub(crate) fn take_many(&self, what: &str, count: usize, size: usize) -> Result<(), Error> {
        self.take(what, (count as u64).saturating_mul(size as u64))
    }

    pub(crate) fn remaining(&self) -> u64 {
        self.left.get()
    }
}

/// The files that a scene names, in its folder.
#[derive(Debug)]
pub(crate) struct Folder {
    path: PathBuf,
    allow_outside: bool,
    budget: Rc<Budget>,
}

impl Folder {
    /// The folder of a scene's file.
    pub(crate) fn beside(scene: &Path, reading: &Reading, budget: &Rc<Budget>) -> Self {
        let parent = scene.parent().unwrap_or(Path::new(""));
        let path = if parent == Path::new("") { Path::new(".") } else { parent };
        Self { path: path.to_owned(), allow_outside: reading.allow_outside, budget: Rc::clone(budget) }
    }

    /// The content of a file named relative to the folder. Links are followed before the place is judged.
    pub(crate) fn read(&self, name: &Path) -> io::Result<Vec<u8>> {
        let file = self.path.join(name).canonicalize()?;
        if !self.allow_outside && !file.starts_with(self.path.canonicalize()?) {
            let rule = "it lies outside the folder of the scene: allow that with --allow-outside, or copy it";
            return Err(io::Error::new(io::ErrorKind::PermissionDenied, rule));
        }
        read_regular(&file, &self.budget)
    }
}

/// The content of a regular file, of no more bytes than are left.
pub(crate) fn read_regular(path: &Path, budget: &Budget) -> io::Result<Vec<u8>> {
    // A pipe without a writer would hold up its opening.
    refuse_special(&std::fs::metadata(path)?)?;
    let file = File::open(path)?;
    let metadata = file.metadata()?;
    refuse_special(&metadata)?;
    let remaining = budget.remaining();
    let too_large = |bytes: u64| {
        let rule =
            format!("it has {} or more, and of the budget {} are left: give more with --budget", Bytes(bytes), Bytes(remaining));
        io::Error::new(io::ErrorKind::FileTooLarge, rule)
    };
    if metadata.len() > remaining {
        return Err(too_large(metadata.len()));
    }
    let mut content = Vec::new();
    file.take(remaining.saturating_add(1)).read_to_end(&mut content)?;
    let length = content.len() as u64;
    budget.take("files", length).map_err(|_| too_large(length))?;
    Ok(content)
}

/// The content of a scene's own file.
pub(crate) fn open(file: &Path, budget: &Budget) -> Result<Vec<u8>, Error> {
    read_regular(file, budget).map_err(|error| Error::Unreadable { file: file.to_owned(), reason: error.to_string() })
}

/// The content of a regular file of at most `limit` bytes: pipes, devices and folders are refused, which may never end.
///
/// # Errors
/// If the file is none, is larger or cannot be read.
pub fn read_file(file: impl AsRef<Path>, limit: u64) -> io::Result<Vec<u8>> {
    read_regular(file.as_ref(), &Budget::new(limit))
}

fn refuse_special(metadata: &std::fs::Metadata) -> io::Result<()> {
    if metadata.is_file() {
        return Ok(());
    }
    let what = if metadata.is_dir() { "a folder" } else { "a pipe, a device or a socket" };
    Err(io::Error::new(io::ErrorKind::InvalidInput, format!("it is {what}: only regular files are read")))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_budget_is_not_overdrawn() {
        let budget = Budget::new(10);
        assert_eq!(budget.take("a", 7), Ok(()));
        let error = budget.take("texels", 4).unwrap_err().to_string();
        assert_eq!(error, "texels: reading takes more than the 10 bytes that it may: give more with --budget");
        assert_eq!((budget.remaining(), budget.take_many("b", usize::MAX, 16).is_err()), (3, true));
        assert_eq!(budget.take("c", 3), Ok(()));
    }
}
