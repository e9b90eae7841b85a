//! Files that are whole or not there: written beside their place, and moved to it when nothing is missing.

use std::fs::{self, File};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

/// A file could not be written.
#[derive(Debug, thiserror::Error)]
#[error("`{}` cannot be written: {reason}", file.display())]
pub(crate) struct Unwritten {
    file: PathBuf,
    reason: String,
}

/// Writes a file by way of another one in the same folder. Whatever fails, the file is as it was before.
pub(crate) fn write_whole<E: ToString>(
    file: &Path,
    content: impl FnOnce(&mut BufWriter<File>) -> Result<(), E>,
) -> Result<(), Unwritten> {
    let refused = |reason: String| Unwritten { file: file.to_owned(), reason };
    let name = file.file_name().ok_or_else(|| refused("it has no file name".to_owned()))?;
    let mut beside = name.to_owned();
    beside.push(format!(".{}.part", std::process::id()));
    let part = file.with_file_name(beside);
    let written = write_part(&part, content).and_then(|()| fs::rename(&part, file).map_err(|error| error.to_string()));
    written.map_err(|reason| {
        // Nothing half-written stays, if it was there at all.
        let _ = fs::remove_file(&part);
        refused(reason)
    })
}

fn write_part<E: ToString>(part: &Path, content: impl FnOnce(&mut BufWriter<File>) -> Result<(), E>) -> Result<(), String> {
    let io = |error: io::Error| error.to_string();
    let mut out = BufWriter::new(File::create_new(part).map_err(io)?);
    content(&mut out).map_err(|error| error.to_string())?;
    out.flush().map_err(io)?;
    out.get_ref().sync_all().map_err(io)
}

/// The extension of a file's name, in lower case.
pub(crate) fn extension(file: &Path) -> String {
    file.extension().map_or_else(String::new, |e| e.to_string_lossy().to_ascii_lowercase())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_fails_half_way_leaves_the_old_file_and_nothing_else() {
        let folder = std::env::temp_dir().join(format!("radgrad-output-{}", std::process::id()));
        fs::create_dir_all(&folder).unwrap();
        let file = folder.join("matrix.csv");
        write_whole(&file, |out| out.write_all(b"old")).unwrap();
        let failed = write_whole(&file, |out| out.write_all(b"new").and_then(|()| Err(io::Error::other("enough"))));
        assert_eq!(failed.unwrap_err().to_string(), format!("`{}` cannot be written: enough", file.display()));
        assert_eq!(fs::read(&file).unwrap(), b"old");
        assert_eq!(fs::read_dir(&folder).unwrap().count(), 1);
        fs::remove_dir_all(&folder).unwrap();
    }
}
