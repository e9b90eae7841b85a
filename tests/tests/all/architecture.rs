//! The documents for who changes the code: they are short, and lead to files, items and headings that exist.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

/// A document, with its folder and the most words that it may have.
struct Document {
    name: &'static str,
    text: &'static str,
    folder: &'static str,
    most_words: usize,
}

macro_rules! documents {
    ($($folder:literal $file:literal $most_words:literal),* $(,)?) => {
        &[$(Document { name: $file, text: include_str!(concat!("../../../", $folder, $file)), folder: $folder, most_words: $most_words }),*]
    };
}

const DOCUMENTS: &[Document] = documents! {
    "" "ARCHITECTURE.md" 2500,
    "" "CONTRIBUTING.md" 900,
    "" "SECURITY.md" 500,
    "docs/" "releasing.md" 900,
    "docs/design/" "closed-forms.md" 1500,
    "docs/design/" "scenes-and-factors.md" 1500,
    "docs/design/" "radiosity.md" 1500,
    "docs/design/" "verification.md" 1500,
    "docs/design/" "dependencies.md" 1500,
};

const MANIFEST: &str = include_str!("../../../Cargo.toml");

fn in_workspace(path: &str) -> PathBuf {
    PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/..")).join(path)
}

/// The file of a path, which is under core's sources unless it says otherwise.
fn located(path: &str) -> Option<PathBuf> {
    [in_workspace("crates/core/src"), in_workspace("crates"), in_workspace("")]
        .into_iter()
        .map(|folder| folder.join(path))
        .find(|path| path.is_file())
}

/// The parts of a line between backticks.
fn quoted(line: &str) -> impl Iterator<Item = &str> {
    line.split('`').skip(1).step_by(2)
}

/// The name by which a link finds a heading.
fn anchor(heading: &str) -> String {
    let letters = heading.to_lowercase().chars().filter(|c| c.is_alphanumeric() || *c == ' ' || *c == '-').collect::<String>();
    letters.trim().replace(' ', "-")
}

#[test]
fn documents_are_short() {
    for Document { name, text, most_words, .. } in DOCUMENTS {
        let words = text.split_whitespace().count();
        assert!(words <= *most_words, "{name}: {words} words, {most_words} at most");
    }
}

#[test]
fn every_file_that_is_named_exists() {
    let mut checked = 0;
    for Document { name, text, .. } in DOCUMENTS {
        for file in text.lines().flat_map(quoted).filter(|file| file.ends_with(".rs") && file.contains('/')) {
            // Each crate has a file of this name.
            let is_of_each = file == "tests/all/main.rs";
            assert!(is_of_each || located(file).is_some(), "{name}: there is no {file}");
            checked += 1;
        }
    }
    assert!(checked > 60, "{checked}");
}

#[test]
fn every_item_of_a_table_stands_in_the_file_before_it() {
    let mut checked = 0;
    for line in DOCUMENTS.iter().flat_map(|document| document.text.lines()).filter(|line| line.starts_with('|')) {
        let mut file = None;
        for name in quoted(line) {
            if name.ends_with(".rs") {
                file = located(name);
            } else if let Some(file) = file.as_ref().filter(|_| name.chars().all(|c| c.is_alphanumeric() || c == '_')) {
                let is_next = line.contains(&format!("`: `{name}`")) || line.contains(&format!("`, `{name}`"));
                if is_next {
                    assert!(fs::read_to_string(file).unwrap().contains(name), "{name} is not in {}", file.display());
                    checked += 1;
                }
            }
        }
    }
    assert!(checked >= 24, "{checked}");
}

#[test]
fn each_walk_leads_through_eight_files() {
    let walks = DOCUMENTS[0].text.split("## Enter here").nth(1).unwrap().split("\n## ").next().unwrap();
    let walks: Vec<usize> = walks
        .split("| file | what it does |")
        .skip(1)
        .map(|walk| walk.lines().filter(|line| line.starts_with("| `")).count())
        .collect();
    assert_eq!(walks, [8, 8, 8]);
}

#[test]
fn every_link_leads_to_a_file_and_a_heading() {
    let mut checked = 0;
    for Document { name, text, folder, .. } in DOCUMENTS {
        for target in text.split("](").skip(1).filter_map(|rest| rest.split(')').next()) {
            if target.starts_with("http") {
                continue;
            }
            let (file, heading) = target.split_once('#').map_or((target, None), |(file, heading)| (file, Some(heading)));
            let path = if file.is_empty() { Path::new(folder).join(name) } else { Path::new(folder).join(file) };
            let path = in_workspace(path.to_str().unwrap());
            assert!(path.exists(), "{name}: {target} leads nowhere");
            if let Some(heading) = heading {
                let linked = fs::read_to_string(&path).unwrap();
                let mut headings = linked.lines().filter_map(|line| line.strip_prefix('#'));
                assert!(headings.any(|line| anchor(line.trim_start_matches('#')) == heading), "{name}: {target}");
            }
            checked += 1;
        }
    }
    assert!(checked >= 12, "{checked}");
}

/// Each crate with all that it may import, from the lines `a, b <- c` of the document.
fn importable() -> BTreeMap<&'static str, BTreeSet<&'static str>> {
    let section = DOCUMENTS[0].text.split("## Who may import whom").nth(1).unwrap();
    let lines = section.split("```").nth(1).unwrap().lines().filter(|line| line.contains(" <- "));
    let mut may: BTreeMap<&str, BTreeSet<&str>> = BTreeMap::new();
    for line in lines {
        let groups: Vec<Vec<&str>> = line.split(" <- ").map(|group| group.split(", ").collect()).collect();
        for pair in groups.windows(2) {
            for &importer in &pair[1] {
                let more: BTreeSet<&str> = pair[0].iter().flat_map(|name| may.get(name).into_iter().flatten()).copied().collect();
                may.entry(importer).or_default().extend(more.iter().chain(&pair[0]));
            }
        }
    }
    may
}

#[test]
fn manifests_import_what_the_document_allows() {
    let may = importable();
    let crates = fs::read_dir(in_workspace("crates")).unwrap().map(|entry| entry.unwrap().path());
    let mut checked = 0;
    for folder in crates.chain([in_workspace("xtask")]) {
        let manifest = fs::read_to_string(folder.join("Cargo.toml")).unwrap();
        let importer = folder.file_name().unwrap().to_str().unwrap();
        let table = manifest.split("\n[dependencies]").nth(1).unwrap().split("\n[").next().unwrap();
        let imported = table.lines().filter(|line| line.starts_with("radgrad"));
        for line in imported {
            let name = line.split(|c: char| !(c.is_alphanumeric() || c == '-')).next().unwrap();
            let name = if name == "radgrad" { "cli" } else { name.trim_start_matches("radgrad-") };
            let is_allowed = may.get(importer).is_some_and(|allowed| allowed.contains(name));
            assert!(is_allowed, "{importer} imports {name}, which ARCHITECTURE.md does not allow");
            checked += 1;
        }
    }
    assert!(checked > 20, "{checked}");
}

#[test]
fn every_dependency_has_a_reason() {
    let reasons = DOCUMENTS.iter().find(|document| document.name == "dependencies.md").unwrap().text;
    let table = MANIFEST.split("[workspace.dependencies]").nth(1).unwrap().split("\n[").next().unwrap();
    let names = table.lines().filter(|line| !line.starts_with('#')).filter_map(|line| line.split_once(" = "));
    let others: Vec<&str> = names.map(|(name, _)| name).filter(|name| !name.starts_with("radgrad")).collect();
    assert!(others.len() > 20, "{others:?}");
    for name in others {
        let is_named = reasons.split(|c: char| !(c.is_alphanumeric() || c == '-' || c == '_')).any(|word| word == name);
        assert!(is_named, "{name} has no row in docs/design/dependencies.md");
    }
}
