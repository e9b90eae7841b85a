//! Snapshots: what every command says of itself, and a small file of every format that is written.
//!
//! Numbers have three digits there, since other processors add in another order; what is below 1e-7 says no more than that, and times
//! say nothing.

use std::collections::BTreeSet;
use std::fmt::Write as _;
use std::fs;
use std::io::BufReader;
use std::path::Path;
use std::process::Command;

use crate::folder::Folder;

const RADGRAD: &str = env!("CARGO_BIN_EXE_radgrad");

/// A floor under a lamp, in three channels that no two can be taken for each other.
const SCENE: &str = "mtllib small.mtl
v 0 0 0\nv 2 0 0\nv 2 1 0\nv 0 1 0\nv 0 0 1\nv 0 1 1\nv 1 0 1
g floor\nusemtl grey\nf 1 2 3 4
g lamp\nusemtl lamp\nf 5 6 7
";
const MATERIALS: &str = "newmtl grey\nKd 0.5 0.3 0.1\nnewmtl lamp\nKd 0 0 0\nKe 1 2 4\n";
const CASES: &str = r#"{"id":"corner","receiver":{"position":[0,0,0],"normal":[0,0,1]},"emitter":{"vertices":[[0,0,1],[0,1,1],[1,1,1],[1,0,1]],"emission":{"constant":1}}}
{"id":2,"hessian":true,"receiver":{"position":[0.25,0.5,0],"normal":[0,0,1],"reflectance":0.5},"emitter":{"vertices":[[0,0,1],[0,1,1],[1,0,1]],"emission":{"constant":2}}}
{"id":"digits","digits":20,"receiver":{"position":[0,0,0],"normal":[0,0,1]},"emitter":{"vertices":[[0,0,1],[0,1,1],[1,1,1],[1,0,1]],"emission":{"constant":1}}}
{"id":"expression","receiver":{"position":[0,0,0],"normal":[0,0,1]},"emitter":{"vertices":[[0,0,1],[0,1,1],[1,1,1],[1,0,1]],"emission":{"expression":"1 + x"}}}
{"id":"flat","receiver":{"position":[0,0,0],"normal":[0,0,0]},"emitter":{"vertices":[[0,0,1],[0,1,1],[1,1,1]],"emission":{"constant":1}}}
"#;
const POINTS: &str = r#"{"id":"a","position":[0.25,0.5,0],"normal":[0,0,1]}
{"position":[0.5,0.5,0.5],"normal":[1,0,0],"on":"free"}
{"id":"c","position":[0.5,0.5,0.5],"normal":[0,0,1],"on":"face"}
"#;

/// A folder of its own with the scene in it.
fn folder(name: &str) -> Folder {
    Folder::new(
        &format!("formats-{name}"),
        &[("small.obj", SCENE), ("small.mtl", MATERIALS), ("cases.jsonl", CASES), ("points.jsonl", POINTS)],
    )
}

impl Folder {
    /// What a command prints, with its status and the files that it writes.
    fn said(&self, arguments: &str, files: &[&str]) -> String {
        self.said_to(&arguments.split_whitespace().collect::<Vec<_>>(), files)
    }

    fn said_to(&self, arguments: &[&str], files: &[&str]) -> String {
        let output = Command::new(RADGRAD).current_dir(&self.0).args(arguments).output().unwrap();
        let mut said = format!("$ radgrad {}\n{}", arguments.join(" "), rounded(&String::from_utf8(output.stdout).unwrap()));
        for line in String::from_utf8(output.stderr).unwrap().lines() {
            let _ = writeln!(said, "! {}", rounded(line));
        }
        let _ = writeln!(said, "status {}", output.status.code().unwrap());
        for file in files {
            let _ = writeln!(said, "{file}:\n{}", rounded(&fs::read_to_string(self.0.join(file)).unwrap()));
        }
        said + "\n"
    }
}

/// Smaller numbers are bounds and estimates of rounding.
const LEAST: f64 = 1e-7;

/// The text with three digits of each number that has a point or an exponent, and without times.
fn rounded(text: &str) -> String {
    let (mut said, mut rest) = (String::new(), text);
    let is_part = |c: char| c.is_alphanumeric() || c == '_';
    while let Some(start) = rest.find(|c: char| c.is_ascii_digit()) {
        // What begins with a letter is a name.
        let word = rest[..start].rfind(|c| !is_part(c)).map_or(0, |place| place + 1);
        let is_number = rest[word..start].is_empty() && !(word == 0 && said.ends_with(is_part));
        let number = rest[start..].char_indices().take_while(|(place, c)| {
            let before = rest.as_bytes()[start..].get(place.wrapping_sub(1)).copied();
            let sign = "+-".contains(*c) && matches!(before, Some(b'e' | b'E'));
            c.is_ascii_digit() || *c == '.' || "eE".contains(*c) || sign
        });
        let length = number.last().map_or(1, |(place, _)| place + 1);
        let (found, after) = (&rest[start..start + length], &rest[start + length..]);
        said += &rest[..start];
        let is_time = said.ends_with("\"seconds\":") || after.starts_with(" s\n") || after.starts_with(" s ");
        match found.parse::<f64>() {
            Ok(_) if is_number && is_time => said += "TIME",
            Ok(number) if is_number && found.contains(['.', 'e']) && number != 0.0 && number < LEAST => said += "<1e-7",
            Ok(number) if is_number && found.contains(['.', 'e']) => {
                let _ = write!(said, "{}", format!("{number:.2e}").parse::<f64>().unwrap());
            }
            _ => said += found,
        }
        rest = after;
    }
    said + rest
}

/// The text with no more than the first lines of each table of numbers, and how many follow.
fn shortened(text: &str) -> String {
    const FIRST: usize = 4;
    let (mut said, mut rows) = (String::new(), 0);
    let end = |rows: usize, said: &mut String| {
        if rows > FIRST {
            let _ = writeln!(said, "and {} more", rows - FIRST);
        }
    };
    for line in text.lines() {
        let is_row = line.starts_with(|c: char| c.is_ascii_digit() || c == '-') || line.starts_with("<1e");
        if !is_row {
            end(std::mem::take(&mut rows), &mut said);
        }
        rows += usize::from(is_row);
        if rows <= FIRST {
            said += line;
            said.push('\n');
        }
    }
    end(rows, &mut said);
    said
}

#[test]
fn every_command_says_what_it_does_and_takes() {
    let folder = folder("help");
    for command in ["", "eval", "audit", "factors", "field", "solve", "heat", "check", "demo", "completions", "man"] {
        let name = if command.is_empty() { "help" } else { command };
        insta::assert_snapshot!(format!("help_{name}"), folder.said(&format!("{command} --help"), &[]));
    }
    // Pages and completions are made of the same texts.
    let shells = ["bash", "elvish", "fish", "powershell", "zsh"];
    for (arguments, part) in [("man".to_owned(), ".TH radgrad-solve")]
        .into_iter()
        .chain(shells.map(|shell| (format!("completions {shell}"), "most-elements")))
    {
        assert!(folder.said(&arguments, &[]).contains(part), "{arguments}");
    }
}

#[test]
fn answers_to_cases_have_the_recorded_form() {
    let folder = folder("eval");
    fs::write(folder.0.join("gates.toml"), "[generic]\nvalue = 1e-20\n").unwrap();
    let program = format!("'{RADGRAD}' eval -");
    let audit = "audit --cases 2 --family far --family generic --gates gates.toml --out tables --program".split(' ');
    let tables = ["tables/errors.csv", "tables/outcomes.csv"];
    let audited = folder.said_to(&audit.chain([program.as_str()]).collect::<Vec<_>>(), &tables);
    insta::assert_snapshot!(folder.said("eval cases.jsonl", &[]) + &audited.replace(RADGRAD, "radgrad"));
}

#[test]
fn factors_and_fields_have_the_recorded_form() {
    let folder = folder("factors");
    let mut said = String::new();
    for (file, more) in [("f.csv", ""), ("f.mtx", "f.bounds.mtx"), ("f.txt", "f.bounds.txt"), ("f.idf", "")] {
        let files: Vec<&str> = [file, more].into_iter().filter(|name| !name.is_empty()).collect();
        said += &folder.said(&format!("factors small.obj --out {file}"), &files);
    }
    said += &folder.said("factors small.obj --summary --resume rows.jsonl", &[]);
    // Rows are written as they are done.
    let written = fs::read_to_string(folder.0.join("rows.jsonl")).unwrap();
    let (head, rows) = written.split_once('\n').unwrap();
    let rows: BTreeSet<&str> = rows.lines().collect();
    said += &format!("rows.jsonl:\n{}\n", rounded(&[head].into_iter().chain(rows).collect::<Vec<_>>().join("\n")));
    said += &folder.said("factors small.obj --from floor --to lamp --digits 4", &[]);
    said += &folder.said("factors small.obj --from floor --to lamp --digits 4 --summary", &[]);
    for file in ["field.csv", "field.vtu"] {
        said += &folder.said(&format!("field small.obj --on floor --grid 2 --channel g --out {file}"), &[file]);
    }
    said += &folder.said("field small.obj --on floor --grid 2 --of lamp --out field.csv", &["field.csv"]);
    said += &folder.said("field small.obj --on floor --grid 2 --out field.png", &[]);
    said += &picture(&folder.0.join("field.png"), 4);
    insta::assert_snapshot!(said);
}

#[test]
fn solutions_have_the_recorded_form() {
    let folder = folder("solve");
    let solve = |more: &str, files: &[&str]| shortened(&folder.said(&format!("solve small.obj --error 50% {more}"), files));
    let mut said = solve("", &[]) + &solve("--summary", &[]);
    for file in ["s.vtu", "s.ply"] {
        said += &solve(&format!("--degree 1 --out {file}"), &[file]);
    }
    said += &solve("--points points.jsonl", &[]);
    said += &folder.said("solve small.obj --error 50% --resume run.json --summary", &["run.json"]);
    let camera = "--camera 0.5,0.5,2,0.5,0.5,0,0,1,0,40 --size 3x2";
    said += &solve(&format!("--view v.exr {camera}"), &[]);
    said += &exr(&folder.0.join("v.exr"), [3, 2]);
    said += &solve(&format!("--view v.png {camera}"), &[]);
    said += &picture(&folder.0.join("v.png"), 1);
    insta::assert_snapshot!(said);
}

/// Size and texts of a picture, and the colours of every so many of its pixels: in full where there are few, else how many there are.
fn picture(file: &Path, every: usize) -> String {
    let mut reader = png::Decoder::new(BufReader::new(fs::File::open(file).unwrap())).read_info().unwrap();
    let mut bytes = vec![0; reader.output_buffer_size().unwrap()];
    let frame = reader.next_frame(&mut bytes).unwrap();
    let info = reader.info();
    let mut said = format!("{}x{} {:?}\n", frame.width, frame.height, frame.color_type);
    for text in &info.uncompressed_latin1_text {
        let _ = writeln!(said, "{}: {}", text.keyword, rounded(&text.text));
    }
    for text in &info.utf8_text {
        let _ = writeln!(said, "{}: {}", text.keyword, rounded(&text.get_text().unwrap()));
    }
    let pixels: Vec<&[u8]> = bytes[..frame.buffer_size()].chunks(frame.color_type.samples()).step_by(every).collect();
    if pixels.len() <= 64 {
        let _ = writeln!(said, "{pixels:?}");
    } else {
        let mut kinds = pixels.clone();
        kinds.sort_unstable();
        kinds.dedup();
        let _ = writeln!(said, "more than {} colours", [1, 4, 16, 64].into_iter().rfind(|&few| kinds.len() > few).unwrap_or(0));
    }
    said
}

/// The texts in the head of a file, and the values of the channels, which are in the order of their names, row by row.
fn exr(file: &Path, [width, height]: [usize; 2]) -> String {
    let bytes = fs::read(file).unwrap();
    let channels = 6;
    let row = 8 + 4 * width * channels;
    let (head, rows) = bytes.split_at(bytes.len() - row * height);
    let words = head
        .split(|byte| !(32..127).contains(byte))
        .filter(|word| word.len() > 2 || word.is_ascii() && word.len() == 1 && word[0].is_ascii_uppercase());
    let mut said = words.map(|word| String::from_utf8_lossy(word).into_owned()).collect::<Vec<_>>().join(" ") + "\n";
    for line in rows.chunks(row) {
        let values = line[8..].chunks_exact(4).map(|value| f32::from_le_bytes(value.try_into().unwrap()));
        let values: Vec<String> = values.map(|value| rounded(&format!("{value:?}"))).collect();
        let _ = writeln!(said, "{}", values.join(" "));
    }
    said
}

#[test]
fn numbers_are_rounded_and_names_are_kept() {
    let text = "f1 0.123456,1.5e-12 -2.71828e3 3 uint8 \"seconds\":0.25 in 0.5 s\nv1.0 1e0";
    assert_eq!(rounded(text), "f1 0.123,<1e-7 -2720 3 uint8 \"seconds\":TIME in TIME s\nv1.0 1");
}
