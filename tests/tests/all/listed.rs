//! No test is lost in a folder: every file of every `tests/all` is a module of its `main.rs`.

use std::fs;
use std::path::Path;

#[test]
fn every_file_of_tests_is_a_module() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let crates = fs::read_dir(root.join("crates")).unwrap().map(|entry| entry.unwrap().path());
    let mut files = 0;
    for folder in crates.chain([root.join("tests")]).map(|folder| folder.join("tests/all")).filter(|folder| folder.is_dir()) {
        let main = fs::read_to_string(folder.join("main.rs")).unwrap();
        for file in fs::read_dir(&folder).unwrap().map(|entry| entry.unwrap().path()) {
            let name = file.file_stem().unwrap().to_str().unwrap();
            if name != "main" && file.extension().is_some_and(|extension| extension == "rs") {
                assert!(main.lines().any(|line| line == format!("mod {name};")), "{} is no module", file.display());
                files += 1;
            }
        }
    }
    assert!(files > 40, "{files} files found");
}
