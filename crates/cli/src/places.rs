//! Files that must not be one and the same: those that are written, and those that are read.

use std::fs;
use std::path::{Path, PathBuf};

use radgrad_scene::read_file;

/// Two files of a run are one.
#[derive(Debug, thiserror::Error)]
#[error("--{option} is `{}`, which is {other}: name another file", file.display())]
pub(crate) struct Same {
    option: &'static str,
    file: PathBuf,
    other: String,
}

/// Refuses outputs, each with its option, that would replace the scene, a file that the scene or a material library of it names, another input,
/// or each other.
pub(crate) fn check(
    (scene, budget): (&Path, u64),
    inputs: &[(&'static str, &Path)],
    outputs: &[(&'static str, PathBuf)],
) -> Result<(), Same> {
    let refuse = |option, file: &PathBuf, other: &str| Err(Same { option, file: file.clone(), other: other.to_owned() });
    // Of a device nothing is lost.
    let is_lost = |(_, file): &&(&'static str, PathBuf)| file != Path::new("-") && (file.is_file() || !file.exists());
    let outputs: Vec<_> = outputs.iter().filter(is_lost).collect();
    for (k, (option, file)) in outputs.iter().enumerate() {
        if real(file) == real(scene) {
            return refuse(option, file, "the scene");
        }
        // Of a file that is not there nothing is lost, and reading the scene says why it cannot be read.
        if file.exists() && named_by(scene, budget, file) {
            return refuse(option, file, "named in the scene");
        }
        if let Some((other, _)) = inputs.iter().find(|(_, other)| real(other) == real(file)) {
            return refuse(option, file, &format!("read for --{other}"));
        }
        if let Some((other, _)) = outputs[..k].iter().find(|(_, other)| real(other) == real(file)) {
            return refuse(option, file, &format!("that of --{other} too"));
        }
    }
    Ok(())
}

/// Whether a scene has the name of a file, or a material library has it that the scene names.
fn named_by(scene: &Path, budget: u64, file: &Path) -> bool {
    let Ok(text) = read_file(scene, budget) else { return false };
    let folder = scene.parent().unwrap_or(Path::new("."));
    let libraries = text.split(|byte| *byte == b'\n').filter_map(|line| line.trim_ascii().strip_prefix(b"mtllib"));
    let names_it = |library: &[u8]| {
        let library = folder.join(String::from_utf8_lossy(library.trim_ascii()).as_ref());
        read_file(library, budget).is_ok_and(|text| names(&text, file))
    };
    names(&text, file) || libraries.into_iter().any(names_it)
}

/// Where a file is or will be, links followed.
fn real(file: &Path) -> PathBuf {
    let folder = match file.parent() {
        Some(folder) if folder != Path::new("") => folder,
        _ => Path::new("."),
    };
    let there = || Some(fs::canonicalize(folder).ok()?.join(file.file_name()?));
    fs::canonicalize(file).ok().or_else(there).unwrap_or_else(|| file.to_owned())
}

/// Whether a scene's text has the name of a file, as a word or the end of a path.
fn names(text: &[u8], file: &Path) -> bool {
    let Some(name) = file.file_name().map(|name| name.to_string_lossy().into_owned().into_bytes()) else { return false };
    let is_end = |byte: Option<&u8>| byte.is_none_or(|byte| byte.is_ascii_whitespace() || b"\"'/\\".contains(byte));
    let mut places = text.windows(name.len()).enumerate().filter(|(_, window)| *window == name);
    places.any(|(at, _)| is_end(at.checked_sub(1).and_then(|k| text.get(k))) && is_end(text.get(at + name.len())))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_is_a_whole_word_or_the_end_of_a_path() {
        let text = b"mtllib parts/white paint.txt data.csv\n";
        for (name, is_there) in [("out/white paint.txt", true), ("paint.txt", true), ("data.csv", true), ("ata.csv", false)] {
            assert_eq!(names(text, Path::new(name)), is_there, "{name}");
        }
        assert!(!names(b"", Path::new("data.csv")) && !names(b"data.csvs", Path::new("data.csv")));
    }
}
