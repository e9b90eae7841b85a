//! A folder of a test's own.

use std::fs;
use std::path::PathBuf;

/// It is removed at the end.
pub(crate) struct Folder(pub(crate) PathBuf);

impl Folder {
    /// With these files in it, of a name and a text.
    pub(crate) fn new(name: &str, files: &[(&str, &str)]) -> Self {
        let folder = std::env::temp_dir().join(format!("radgrad-{name}-{}", std::process::id()));
        fs::create_dir_all(&folder).unwrap();
        for (file, text) in files {
            fs::write(folder.join(file), text).unwrap();
        }
        Self(folder)
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}
