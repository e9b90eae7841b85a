//! Files of a run: each is whole or not there, also if the run is killed, and the one that was there before stays till then.
//! Paths of the workspace do not depend on where the task was called.

use std::env;
use std::error::Error;
use std::ffi::OsString;
use std::io::Write;
use std::path::{Path, PathBuf};

use radgrad_scene::output::{Unwritten, write_whole};

/// Writes a file.
pub(crate) fn write(file: &Path, content: impl AsRef<[u8]>) -> Result<(), Unwritten> {
    write_whole(file, |out| out.write_all(content.as_ref()))
}

/// Writes a table as CSV.
pub(crate) fn table(
    file: &Path,
    fill: impl FnOnce(&mut csv::Writer<Vec<u8>>) -> Result<(), Box<dyn Error>>,
) -> Result<(), Box<dyn Error>> {
    let mut rows = csv::Writer::from_writer(Vec::new());
    fill(&mut rows)?;
    Ok(write(file, rows.into_inner()?)?)
}

/// The cargo that runs this, or any.
pub(crate) fn cargo() -> OsString {
    env::var_os("CARGO").unwrap_or_else(|| "cargo".into())
}

/// A path in the workspace, wherever the task was called from.
pub(crate) fn in_workspace(path: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..").join(path)
}
