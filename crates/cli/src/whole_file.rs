//! Files that are there whole or not at all: written beside their place, then renamed.

use std::ffi::OsString;
use std::fs::{self, File};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

/// Writes a file by `content`. If that fails, or the program ends on the way, what was there before still is.
pub(crate) fn write(file: &Path, content: impl FnOnce(&mut dyn Write) -> io::Result<()>) -> io::Result<()> {
    let beside = beside(file);
    let written = (|| {
        let mut output = BufWriter::new(File::create(&beside)?);
        content(&mut output)?;
        output.flush()?;
        output.get_ref().sync_all()?;
        fs::rename(&beside, file)
    })();
    if written.is_err() {
        // What is left of it is of no use; the first error is the one to report.
        let _ = fs::remove_file(&beside);
    }
    written
}

fn beside(file: &Path) -> PathBuf {
    let mut name = OsString::from(".");
    name.push(file.file_name().unwrap_or_default());
    name.push(format!(".{}", std::process::id()));
    file.with_file_name(name)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_failure_on_the_way_leaves_the_old_file_and_nothing_else() {
        let folder = std::env::temp_dir().join(format!("radgrad-whole-file-{}", std::process::id()));
        fs::create_dir_all(&folder).unwrap();
        let file = folder.join("out");
        write(&file, |output| output.write_all(b"first")).unwrap();
        let failed = write(&file, |output| {
            output.write_all(b"sec")?;
            Err(io::Error::other("the disk is full"))
        });
        assert!(failed.is_err());
        assert_eq!(fs::read(&file).unwrap(), b"first");
        assert_eq!(fs::read_dir(&folder).unwrap().count(), 1);
        fs::remove_dir_all(&folder).unwrap();
    }
}
