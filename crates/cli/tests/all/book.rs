//! The commands of the READMEs and of the guide, their blocks `sh`, each page in an empty folder, and what the block `text` after them says
//! that they print: numbers as far as they are rounded there, `...` for lines or an end of a line that are left out.

use std::path::{Path, PathBuf};
use std::process::Command;

use serde_json::Value;

use crate::folder::Folder;

/// Commands, and their output if that is stated.
struct Step {
    commands: String,
    stated: Option<String>,
}

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

/// The steps of a page.
fn steps(page: &str) -> Vec<Step> {
    let mut steps: Vec<Step> = Vec::new();
    let (mut lines, mut is_next) = (page.lines(), false);
    while let Some(line) = lines.next() {
        let Some(kind) = line.strip_prefix("```").filter(|kind| !kind.is_empty()) else {
            // A list, a table or a heading begins something else.
            is_next &= !line.starts_with(['-', '|', '#']);
            continue;
        };
        let block: Vec<&str> = lines.by_ref().take_while(|line| *line != "```").collect();
        let block = block.join("\n");
        match kind {
            "sh" => steps.push(Step { commands: block, stated: None }),
            "text" if is_next => steps.last_mut().unwrap().stated = Some(block),
            _ => {}
        }
        is_next = kind == "sh";
    }
    steps
}

/// The words of a line, and numbers by themselves.
fn words(line: &str) -> Vec<&str> {
    line.split(|c: char| c.is_whitespace() || "[]{}(),:\"".contains(c)).filter(|word| !word.is_empty()).collect()
}

/// Whether a printed word is the stated one, or a number that rounds to it.
fn is_same(stated: &str, printed: &str) -> bool {
    let (Ok(one), Ok(other)) = (stated.parse::<f64>(), printed.parse::<f64>()) else { return stated == printed };
    let (digits, exponent) = stated.split_once(['e', 'E']).unwrap_or((stated, "0"));
    let places = digits.split_once('.').map_or(0, |(_, after)| after.len());
    let exponent: i32 = exponent.parse().unwrap_or(0);
    let step = 10.0_f64.powi(exponent - i32::try_from(places).unwrap());
    (one - other).abs() <= 0.5 * step * (1.0 + 1e-9) + 1e-15 * one.abs()
}

fn line_agrees(stated: &str, printed: &str) -> bool {
    let (head, is_cut) = stated.strip_suffix("...").map_or((stated, false), |head| (head, true));
    let (stated, printed) = (words(head), words(printed));
    let is_long = if is_cut { printed.len() >= stated.len() } else { printed.len() == stated.len() };
    is_long && stated.iter().zip(&printed).all(|(stated, printed)| is_same(stated, printed))
}

/// The first line that is stated and not printed.
fn missing<'a>(stated: &'a str, printed: &str) -> Option<&'a str> {
    let mut lines = printed.lines().filter(|line| !line.trim().is_empty());
    let mut may_skip = false;
    for line in stated.lines().filter(|line| !line.trim().is_empty()) {
        if line.trim() == "..." {
            may_skip = true;
            continue;
        }
        let found = if may_skip {
            lines.any(|printed| line_agrees(line, printed))
        } else {
            lines.next().is_some_and(|printed| line_agrees(line, printed))
        };
        if !found {
            return Some(line);
        }
        may_skip = false;
    }
    (!may_skip && lines.next().is_some()).then_some("the end")
}

/// Runs a page's steps one after the other in an empty folder.
fn follow(page: &Path) {
    let text = std::fs::read_to_string(page).unwrap();
    let name = page.strip_prefix(root()).unwrap().display().to_string();
    let folder = Folder::new(&format!("book-{}", name.replace(['/', '.'], "-")), &[]);
    let program = Path::new(env!("CARGO_BIN_EXE_radgrad")).parent().unwrap();
    let path = format!("{}:{}", program.display(), std::env::var("PATH").unwrap());
    for Step { commands, stated } in steps(&text) {
        let output = Command::new("bash")
            .args(["-euo", "pipefail", "-c", &commands])
            .current_dir(&folder.0)
            .env("PATH", &path)
            .output()
            .unwrap();
        let printed = String::from_utf8(output.stdout).unwrap() + &String::from_utf8(output.stderr).unwrap();
        assert!(output.status.success(), "{name}:\n{commands}\n{printed}");
        if let Some(stated) = stated {
            let missing = missing(&stated, &printed);
            assert!(missing.is_none(), "{name}: not printed: {}\n{commands}\n{printed}", missing.unwrap_or_default());
        }
    }
}

#[test]
fn the_commands_of_the_guide_run_in_an_empty_folder_and_print_what_it_states() {
    let pages = std::fs::read_dir(root().join("docs/guide")).unwrap().map(|entry| entry.unwrap().path());
    let mut pages: Vec<PathBuf> = pages.filter(|page| page.extension().is_some_and(|of| of == "md")).collect();
    pages.sort();
    assert!(pages.len() > 10);
    pages.iter().for_each(|page| follow(page));
}

#[test]
fn the_commands_of_the_readmes_print_what_they_state() {
    for page in ["README.md", "crates/cli/README.md"] {
        assert!(steps(&std::fs::read_to_string(root().join(page)).unwrap()).iter().any(|step| step.stated.is_some()), "{page}");
        follow(&root().join(page));
    }
}

#[test]
fn the_examples_of_the_schema_are_answered_and_have_all_its_fields() {
    let text = std::fs::read_to_string(root().join("docs/guide/eval.schema.json")).unwrap();
    let schema: Value = serde_json::from_str(&text).unwrap();
    let examples = schema["examples"].as_array().unwrap();
    for name in schema["properties"].as_object().unwrap().keys() {
        assert!(examples.iter().any(|example| example.get(name).is_some()), "{name} is in no example");
    }
    for example in examples {
        let line = radgrad_scene::case::Line::read(1, example.to_string().as_bytes()).unwrap().unwrap();
        assert!(line.answer().is_ok(), "{example}");
    }
    let mut unknown = examples[0].clone();
    unknown["other"] = Value::Bool(true);
    assert!(radgrad_scene::case::Line::read(1, unknown.to_string().as_bytes()).unwrap().is_err());
}

#[test]
fn a_stale_figure_is_noticed_and_a_rounded_one_is_not() {
    let printed = "a 1.2345 b\nother\nend 7";
    for (stated, is_held) in [
        ("a 1.23 b\n...\nend 7", true),
        ("a 1.2345 b\nother\nend 7", true),
        ("a 1.24 b\n...\nend 7", false),
        ("a 1.23 b\nend 7", false),
        ("a 1.23 ...\nother\nend 7", true),
        ("a 1.23 b\nother", false),
        ("a 1.2e0 b\n...", true),
    ] {
        assert_eq!(missing(stated, printed).is_none(), is_held, "{stated}");
    }
}
