//! Files and streams are touched by few places: `write_whole` and `check` of the scene crate's `output`, its `read_file`, and `say`.

use std::fs;
use std::path::{Path, PathBuf};

/// What opens a file or writes to a stream by itself.
const WORDS: [&str; 14] = [
    "fs::write",
    "fs::read",
    "read_to_string(&",
    "File::create",
    "File::open",
    "File::options",
    "OpenOptions",
    "fs::remove",
    "fs::rename",
    "println!(",
    "print!(",
    "dbg!(",
    "stderr().lock()",
    "rustix::fs",
];

/// The places that may, and why.
const ALLOWED: [(&str, &str); 7] = [
    ("numbers/src/near_ties.rs", "tests alone have it"),
    ("scene/src/output.rs", "it is the door of what is written"),
    ("scene/src/output/unnamed.rs", "a part of that"),
    ("scene/src/reading.rs", "it is the door of what is read"),
    ("cli/src/factors/kept.rs", "rows are added to one file, which is locked"),
    ("cli/src/lib.rs", "cases of `eval` come through pipes too, and without end"),
    ("cli/src/say.rs", "it is the door of messages"),
];

fn sources(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let is_test = path.file_name().is_some_and(|name| name == "tests" || name == "tests.rs" || name == "bin");
        if path.is_dir() && !is_test {
            sources(&path, found);
        } else if path.extension().is_some_and(|ending| ending == "rs") && !is_test {
            found.push(path);
        }
    }
}

/// The lines of a source that are code of the library: neither of a test, nor a comment.
fn code(text: &str) -> impl Iterator<Item = (usize, &str)> {
    let is_code = |line: &&str| !line.trim_start().starts_with("//");
    let end = text.rfind("\nmod tests {").unwrap_or(text.len());
    text[..end].lines().enumerate().filter(move |(_, line)| is_code(line))
}

#[test]
fn few_places_touch_files_and_streams() {
    let crates = Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap();
    let (mut found, mut used) = (Vec::new(), [false; ALLOWED.len()]);
    for name in ["core", "numbers", "scene", "solver", "certificate", "curved", "cli", "python", "c"] {
        let mut files = Vec::new();
        sources(&crates.join(name).join("src"), &mut files);
        assert!(!files.is_empty(), "{name}");
        for file in files {
            let text = fs::read_to_string(&file).unwrap();
            let place = file.strip_prefix(crates).unwrap().to_str().unwrap().replace('\\', "/");
            let touches = code(&text).filter(|(_, line)| WORDS.iter().any(|word| line.contains(word)));
            let lines: Vec<String> = touches.map(|(number, line)| format!("{place}:{}: {}", number + 1, line.trim())).collect();
            match ALLOWED.iter().position(|(allowed, _)| *allowed == place) {
                Some(index) => used[index] |= !lines.is_empty(),
                None => found.extend(lines),
            }
        }
    }
    assert!(found.is_empty(), "these go through radgrad_scene::output, radgrad_scene::read_file or `say`:\n{}", found.join("\n"));
    let idle: Vec<&str> = ALLOWED.iter().zip(used).filter(|(_, used)| !used).map(|((place, _), _)| *place).collect();
    assert!(idle.is_empty(), "these need no leave any more: {idle:?}");
}
