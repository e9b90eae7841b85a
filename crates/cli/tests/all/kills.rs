//! Runs that are killed: no file is lost or half written, and the next run gives the same files as one without a kill.
//!
//! `RADGRAD_KILLS` is how many kills each command gets, evenly over the time that it takes.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};
use std::thread::sleep;
use std::time::Instant;

use crate::folder::Folder;

const SCENES: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../data/scenes");

/// A command, and the files that it writes.
struct Run {
    arguments: Vec<String>,
    /// Those that are written as one: before a kill, or after it, whole.
    whole: &'static [&'static str],
    /// One that grows line by line.
    grows: Option<&'static str>,
}

fn folder(name: &str) -> Folder {
    let read = |file: &str| fs::read_to_string(format!("{SCENES}/{file}")).unwrap();
    let points: String = (0..40).map(|k| format!("{} {} 0.3 0 0 1\n", 0.1 + 0.02 * f64::from(k), 0.45)).collect();
    let files = [("two_blocks.obj", read("two_blocks.obj")), ("two_blocks.mtl", read("two_blocks.mtl")), ("points.txt", points)];
    Folder::new(&format!("kills-{name}"), &files.each_ref().map(|(file, text)| (*file, text.as_str())))
}

fn command(folder: &Path, run: &Run) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_radgrad"));
    command.args(&run.arguments).current_dir(folder).stdout(Stdio::null()).stderr(Stdio::null());
    command
}

/// Files by name with their contents, of folders within too.
fn files(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let mut contents = BTreeMap::new();
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let name = path.file_name().unwrap().to_string_lossy().into_owned();
        if path.is_dir() {
            contents.extend(files(&path).into_iter().map(|(inner, content)| (format!("{name}/{inner}"), content)));
        } else {
            contents.insert(name, fs::read(&path).unwrap());
        }
    }
    contents
}

/// Kills a command again and again, and then lets it end. Returns the files that a run without kills leaves, and those of this one.
fn killed(name: &str, run: &Run) -> [BTreeMap<String, Vec<u8>>; 2] {
    let kills = std::env::var("RADGRAD_KILLS").ok().and_then(|count| count.parse().ok()).unwrap_or(3);
    let (alone, folder) = (folder(&format!("{name}-alone")), folder(name));
    let start = Instant::now();
    assert!(command(&alone.0, run).status().unwrap().code().is_some_and(|code| code < 2), "{name}");
    let (took, given, left) = (start.elapsed(), files(&folder.0), files(&alone.0));
    let mut grown = Vec::new();
    for kill in 0..kills {
        let mut child = command(&folder.0, run).spawn().unwrap();
        sleep(took.mul_f64((f64::from(kill) + 0.5) / f64::from(kills)));
        child.kill().unwrap();
        child.wait().unwrap();
        for (file, content) in files(&folder.0) {
            match given.get(&file) {
                Some(before) => assert!(content == *before, "{name}: {file} is an input"),
                None if run.grows == Some(file.as_str()) => {
                    let whole = |text: &[u8]| text.iter().rposition(|byte| *byte == b'\n').map_or(0, |end| end + 1);
                    assert!(
                        content.len() >= whole(&grown) && content.starts_with(&grown[..whole(&grown)]),
                        "{name}: {file} lost rows"
                    );
                    grown = content;
                }
                None if run.whole.contains(&file.as_str()) => assert!(
                    content.is_empty() && file.ends_with(".json") || is_whole(&file, &content),
                    "{name}: {file} is half written"
                ),
                // A run that is killed between two names of a whole file leaves the second.
                None => assert!(file.rsplit('/').next().unwrap().starts_with('.'), "{name}: {file} is none of its files"),
            }
        }
    }
    assert!(command(&folder.0, run).status().unwrap().code().is_some_and(|code| code < 2), "{name}");
    [left, files(&folder.0)]
}

/// Whether a file has its end.
fn is_whole(file: &str, content: &[u8]) -> bool {
    let text = String::from_utf8_lossy(content);
    match Path::new(file).extension().and_then(|ending| ending.to_str()) {
        Some("json") => serde_json::from_slice::<serde_json::Value>(content).is_ok(),
        Some("vtu") => text.trim_end().ends_with("</VTKFile>"),
        Some("png") => content.ends_with(b"IEND\xaeB\x60\x82"),
        _ => text.ends_with('\n'),
    }
}

fn words(text: &str) -> Vec<String> {
    text.split_whitespace().map(str::to_owned).collect()
}

#[test]
fn factors_that_are_killed_go_on_to_the_same_bytes() {
    let arguments = words("factors two_blocks.obj --tolerance 1e-3 --out factors.csv --resume rows.jsonl");
    let [alone, found] = killed("factors", &Run { arguments, whole: &["factors.csv"], grows: Some("rows.jsonl") });
    assert!(alone["factors.csv"] == found["factors.csv"]);
    let rows = |of: &BTreeMap<String, Vec<u8>>| {
        let text = String::from_utf8(of["rows.jsonl"].clone()).unwrap();
        let mut lines: Vec<String> = text.lines().map(str::to_owned).collect();
        lines.sort();
        lines
    };
    assert!(rows(&alone) == rows(&found), "each row is kept once");
}

#[test]
fn a_solve_that_is_killed_goes_on_and_two_that_go_on_agree() {
    let line = "solve two_blocks.obj --error 10% --seconds 1000 --certify off --out out.vtu --view view.png --draft --size 24x24 \
                --camera 0.5,0.5,0.9,0.5,0.5,0,0,1,0,60 --points points.txt --answers answers.csv";
    let run = Run { arguments: words(line), whole: &["out.vtu", "view.png", "answers.csv"], grows: None };
    let [alone, found] = killed("solve", &run);
    assert!(alone.iter().all(|(file, content)| found.get(file) == Some(content)), "a run from the start has the same bytes");
    let run = Run {
        arguments: [run.arguments, words("--resume run.json")].concat(),
        whole: &["out.vtu", "view.png", "answers.csv", "run.json"],
        grows: None,
    };
    let [_, found] = killed("solve-resume", &run);
    let again = folder("solve-again");
    fs::write(again.0.join("run.json"), &found["run.json"]).unwrap();
    let [first, second] = [0, 1].map(|_| {
        assert!(command(&again.0, &run).status().unwrap().code().is_some_and(|code| code < 2));
        files(&again.0)
    });
    assert!(first == second, "two runs from one file have the same bytes");
}

#[test]
fn an_audit_that_is_killed_leaves_tables_that_are_whole() {
    let arguments = [
        "audit",
        "--program",
        concat!(env!("CARGO_BIN_EXE_radgrad"), " eval -"),
        "--family",
        "generic",
        "--cases",
        "300",
        "--out",
        "tables",
    ];
    let whole: &[_] = &["tables/errors.csv", "tables/figures.csv", "tables/histogram.csv", "tables/outcomes.csv"];
    let run = Run { arguments: arguments.map(str::to_owned).to_vec(), whole, grows: None };
    let [alone, found] = killed("audit", &run);
    assert!(alone == found);
}

/// A second run must not write the rounds of another scene's run, nor of the same.
#[cfg(unix)]
#[test]
fn a_file_of_resume_is_one_runs_at_a_time() {
    let folder = folder("held");
    let line = "solve two_blocks.obj --error 0.001% --seconds 1000 --certify off --resume run.json";
    let run = Run { arguments: words(line), whole: &["run.json"], grows: None };
    let mut first = command(&folder.0, &run).spawn().unwrap();
    while !folder.0.join("run.json").exists() {
        sleep(std::time::Duration::from_millis(5));
    }
    // Taken it is before anything else is done with it.
    sleep(std::time::Duration::from_millis(50));
    let second = command(&folder.0, &run).stderr(Stdio::piped()).output().unwrap();
    first.kill().unwrap();
    first.wait().unwrap();
    let said = String::from_utf8_lossy(&second.stderr).into_owned();
    assert!(second.status.code() == Some(2) && said.contains("another run holds it"), "{said}");
}

/// A file that may not grow stands for a disk that is full: that is known before the work.
#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_is_found_before_the_work() {
    let folder = folder("full");
    for arguments in
        ["factors two_blocks.obj --out f.csv", "factors two_blocks.obj --resume r.jsonl", "solve two_blocks.obj --out s.vtu"]
    {
        let line = format!("trap '' XFSZ; ulimit -f 64; exec '{}' {arguments}", env!("CARGO_BIN_EXE_radgrad"));
        let output = Command::new("sh").args(["-c", &line]).current_dir(&folder.0).output().unwrap();
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(output.status.code() == Some(2) && said.contains("cannot be written") && said.lines().count() <= 2, "{said}");
    }
    assert_eq!(files(&folder.0).len(), 3, "nothing is left");
}
