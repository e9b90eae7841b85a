//! One version everywhere, and each published crate with the metadata that its page needs.

use std::fs;
use std::path::{Path, PathBuf};

const MANIFEST: &str = include_str!("../../../Cargo.toml");
const CHANGELOG: &str = include_str!("../../../CHANGELOG.md");
const CITATION: &str = include_str!("../../../CITATION.cff");

/// The value of the first line `key = "value"`.
fn value<'a>(text: &'a str, key: &str) -> Option<&'a str> {
    let line = text.lines().find(|line| line.starts_with(&format!("{key} = ")))?;
    line.split('"').nth(1)
}

fn version() -> &'static str {
    value(MANIFEST, "version").unwrap()
}

/// The manifests of the crates that are published, with their folders.
fn published() -> Vec<(PathBuf, String)> {
    let crates = Path::new(env!("CARGO_MANIFEST_DIR")).join("../crates");
    let folders = fs::read_dir(crates).unwrap().map(|entry| entry.unwrap().path());
    let manifests = folders.map(|folder| (folder.clone(), fs::read_to_string(folder.join("Cargo.toml")).unwrap()));
    manifests.filter(|(_, manifest)| !manifest.contains("publish = false")).collect()
}

#[test]
fn the_version_is_the_same_everywhere() {
    let version = version();
    let own = MANIFEST.lines().filter(|line| line.starts_with("radgrad") && line.contains("path = "));
    let own: Vec<&str> = own.collect();
    assert!(own.len() >= 9, "{own:?}");
    for line in own {
        assert!(line.contains(&format!("version = \"{version}\"")), "{line}");
    }
    assert!(CITATION.lines().any(|line| line == format!("version: {version}")), "CITATION.cff has another version");
    assert!(CHANGELOG.contains(&format!("\n## [{version}]")), "CHANGELOG.md has no section for {version}");
    assert!(CHANGELOG.contains("\n## [Unreleased]\n"));
}

#[test]
fn each_published_crate_has_what_its_page_needs() {
    let published = published();
    assert!(published.len() >= 10, "{}", published.len());
    for (folder, manifest) in published {
        let name = value(&manifest, "name").unwrap();
        assert!(manifest.contains("version.workspace = true") && manifest.contains("license.workspace = true"), "{name}");
        assert!(value(&manifest, "description").is_some_and(|text| text.len() > 20), "{name}: description");
        assert_eq!(value(&manifest, "documentation"), Some(&*format!("https://docs.rs/{name}")));
        assert_eq!(value(&manifest, "readme"), Some("README.md"), "{name}");
        let readme = fs::read_to_string(folder.join("README.md")).unwrap();
        assert!(readme.starts_with(&format!("# {name}\n")), "{name}");
        assert!(readme.lines().count() <= 40 && readme.contains("```"), "{name}: an example, and at most 40 lines");
        for licence in ["LICENSE-APACHE", "LICENSE-MIT"] {
            assert!(folder.join(licence).is_file(), "{name}: {licence}");
        }
        for line in manifest.lines().filter(|line| line.contains("path = \"..")) {
            assert!(line.contains(&format!("version = \"{}\"", version())), "{name}: {line}");
        }
    }
}
