//! Files of a run: each is whole or not there, also if the run is killed, and the one that was there before stays till then.

use std::error::Error;
use std::io::Write;
use std::path::Path;

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
