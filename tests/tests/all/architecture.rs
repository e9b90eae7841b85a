//! ARCHITECTURE leads to files and items that exist.

use std::fs;
use std::path::PathBuf;

const ARCHITECTURE: &str = include_str!("../../../ARCHITECTURE.md");

fn in_workspace(path: &str) -> PathBuf {
    PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/..")).join(path)
}

/// The file of a path, which is under core's sources unless it says otherwise.
fn found(path: &str) -> Option<PathBuf> {
    [in_workspace("crates/core/src"), in_workspace("crates"), in_workspace("")]
        .into_iter()
        .map(|folder| folder.join(path))
        .find(|path| path.is_file())
}

/// The parts of a line between backticks.
fn quoted(line: &str) -> impl Iterator<Item = &str> {
    line.split('`').skip(1).step_by(2)
}

#[test]
fn every_file_that_is_named_exists() {
    let files: Vec<&str> = ARCHITECTURE.lines().flat_map(quoted).filter(|name| name.ends_with(".rs")).collect();
    assert!(files.len() > 20, "{}", files.len());
    for name in files {
        assert!(name.contains("tests/") || found(name).is_some(), "there is no {name}");
    }
}

#[test]
fn every_item_of_a_table_stands_in_the_file_before_it() {
    let mut checked = 0;
    for line in ARCHITECTURE.lines().filter(|line| line.starts_with('|')) {
        let mut file = None;
        for name in quoted(line) {
            if name.ends_with(".rs") {
                file = found(name);
            } else if let Some(file) = file.as_ref().filter(|_| name.chars().all(|c| c.is_alphanumeric() || c == '_')) {
                let is_next = line.contains(&format!("`: `{name}`")) || line.contains(&format!("`, `{name}`"));
                if is_next {
                    assert!(fs::read_to_string(file).unwrap().contains(name), "{name} is not in {}", file.display());
                    checked += 1;
                }
            }
        }
    }
    assert!(checked >= 8, "{checked}");
}
