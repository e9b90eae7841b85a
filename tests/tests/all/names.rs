//! Names are nouns and verbs of the field: a pronoun or an adverb does not say whose value a line holds.

use std::fs;
use std::path::Path;

/// Names of functions that say nothing of what they do, and how many there may be: the count may only fall.
const FUNCTIONS: ([&str; 8], usize) = (["of", "at", "all", "found", "left", "known", "seen", "kept"], 56);

/// The same of local variables.
const VARIABLES: ([&str; 8], usize) = (["of", "found", "all", "left", "rest", "known", "most", "off"], 214);

/// How often comments may say "what" in 1,000 words, where the thing has a name: this may only fall.
const WHAT: f64 = 1.5;

fn sources(folder: &Path, texts: &mut Vec<String>) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() && path.file_name().is_none_or(|name| name != "target") {
            sources(&path, texts);
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            texts.push(fs::read_to_string(path).unwrap());
        }
    }
}

fn workspace() -> Vec<String> {
    let mut texts = Vec::new();
    for folder in ["crates", "fuzz", "tests", "xtask"] {
        sources(&Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/..")).join(folder), &mut texts);
    }
    texts
}

/// How many functions and how many variables have one of the names.
fn counts(text: &str) -> [usize; 2] {
    let code = || text.lines().filter(|line| !line.trim_start().starts_with("//"));
    let follows = |keyword: &str, names: &[&str]| {
        let name = |after: &'_ str| {
            let after = after.strip_prefix("mut ").unwrap_or(after);
            names.contains(&after.split(|c: char| !c.is_alphanumeric() && c != '_').next().unwrap_or_default())
        };
        code().flat_map(|line| line.split(keyword).skip(1)).filter(|after| name(after)).count()
    };
    [follows("fn ", &FUNCTIONS.0), follows("let ", &VARIABLES.0)]
}

#[test]
fn few_names_are_pronouns() {
    assert_eq!(counts("fn of(a: f64) { let mut rest = a; let of_a = rest; }\n// fn at\nfn at() {}"), [2, 1]);
    let counts = workspace().iter().map(|text| counts(text)).fold([0, 0], |[a, b], [c, d]| [a + c, b + d]);
    assert!(
        counts[0] <= FUNCTIONS.1 && counts[1] <= VARIABLES.1,
        "{counts:?} functions and variables have names that say nothing"
    );
}

#[test]
fn comments_name_things() {
    let texts = workspace();
    let comments =
        texts.iter().flat_map(|text| text.lines().filter_map(|line| line.split_once("//")).map(|(_, comment)| comment));
    let words = comments.flat_map(|comment| comment.split(|c: char| !c.is_alphabetic())).filter(|word| !word.is_empty());
    let [whats, total] =
        words.fold([0, 0], |[whats, total], word| [whats + usize::from(word.eq_ignore_ascii_case("what")), total + 1]);
    let share = 1000.0 * whats as f64 / total as f64;
    assert!(share <= WHAT, "comments say \"what\" {share:.2} times in 1,000 words");
}
