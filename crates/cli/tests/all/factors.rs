//! `radgrad factors`: the accuracy that defaults reach, the messages where they do not, and hands that slip.

use std::fs;
use std::process::{Command, Output};

use serde_json::Value;

use crate::folder::Folder;

const SCENES: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../data/scenes");

/// Two squares back to back, and the same without a word about materials in another file.
const BACK_TO_BACK: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\n\
    g below\nf 4 3 2 1\ng above\nf 5 6 7 8\n";

/// The scenes, with the room's materials in a file whose name factors may be written to.
pub(crate) fn folder(name: &str) -> Folder {
    let read = |file: &str| fs::read_to_string(format!("{SCENES}/{file}")).unwrap();
    let room = read("two_blocks.obj").replace("two_blocks.mtl", "paint.txt");
    let files = [
        ("room.obj", room),
        ("paint.txt", read("two_blocks.mtl")),
        ("office.obj", read("office.obj")),
        ("two_blocks.mtl", read("two_blocks.mtl")),
        ("cornell.obj", read("cornell.obj")),
        ("cornell.mtl", read("cornell.mtl")),
        ("back.obj", BACK_TO_BACK.to_owned()),
    ];
    Folder::new(&format!("factors-{name}"), &files.each_ref().map(|(file, text)| (*file, text.as_str())))
}

impl Folder {
    pub(crate) fn factors(&self, arguments: &str) -> Output {
        let arguments = arguments.split_whitespace();
        Command::new(env!("CARGO_BIN_EXE_radgrad")).arg("factors").args(arguments).current_dir(&self.0).output().unwrap()
    }

    pub(crate) fn text_of(&self, file: &str) -> String {
        fs::read_to_string(self.0.join(file)).unwrap()
    }
}

pub(crate) fn status_and_said(output: &Output) -> (Option<i32>, String) {
    (output.status.code(), String::from_utf8_lossy(&output.stderr).into_owned())
}

pub(crate) fn object(output: &Output) -> Value {
    serde_json::from_slice(&output.stdout).unwrap_or_else(|_| panic!("{}", String::from_utf8_lossy(&output.stderr)))
}

#[test]
fn by_default_an_office_meets_its_tolerance() {
    let folder = folder("office");
    let output = folder.factors("office.obj --summary");
    let summary = object(&output);
    assert_eq!((output.status.code(), &summary["unmet"]), (Some(0), &Value::from(0)), "{summary}");
    assert!(summary["worst_bound"].as_f64().unwrap() <= 1e-3, "{summary}");
}

#[test]
fn one_factor_has_six_digits_by_default_and_says_what_of_more_is_reached() {
    let folder = folder("one");
    let output = folder.factors("cornell.obj --from light --to floor --summary");
    let found = object(&output);
    let number = |name: &str| found[name].as_f64().unwrap_or_else(|| panic!("{name} in {found}"));
    assert_eq!((output.status.code(), &found["digits"]), (Some(0), &Value::from(6)), "{found}");
    assert!((number("factor") - 0.123_150_2).abs() <= 5e-7, "{found}");
    assert!(number("lower") <= number("factor") && number("factor") <= number("upper"), "{found}");
    assert!(number("upper") - number("factor") <= number("error") && number("error") <= 1e-3, "{found}");
    // What is asked for by name decides, and nothing else is said to be missing.
    let (status, said) = status_and_said(&folder.factors("cornell.obj --from light --to floor --digits 12 --points 100"));
    assert!(status == Some(1) && said.contains("12 digits are asked for") && !said.contains("bound of"), "{said}");
    let (status, said) = status_and_said(&folder.factors("cornell.obj --from light --to floor --tolerance 1e-9 --cells 100"));
    assert!(status == Some(1) && said.contains("a bound of 0.000000001 is asked for") && !said.contains("digits"), "{said}");
    // The ceiling of the room is in the same direction as a face of six parts, whose errors add up to what is asked for.
    let output = folder.factors("room.obj --from room_top --to floor --tolerance 0.002 --digits 4 --summary");
    let found = object(&output);
    assert_eq!([&found["digits_met"], &found["tolerance_met"]], [true, true].map(Value::from).each_ref(), "{found}");
    assert_eq!(output.status.code(), Some(0));
}

#[test]
fn in_free_sight_twelve_digits_are_proven() {
    let folder = folder("free");
    fs::write(folder.0.join("squares.obj"), BACK_TO_BACK.replace("4 3 2 1", "1 2 3 4").replace("5 6 7 8", "8 7 6 5")).unwrap();
    let output = folder.factors("squares.obj --from below --to above --digits 12");
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    assert_eq!(output.status.code(), Some(0), "{text}");
    assert!(text.contains("(proven: in free sight)") && text.contains("12 digits, proven; a bound of 0.001, proven"), "{text}");
    assert!(!text.contains("not reached") && text.starts_with("from below to above: 1.99824895698"), "{text}");
}

#[test]
fn rows_that_cannot_close_are_named_and_what_is_open_is_written() {
    let folder = folder("open");
    let output = folder.factors("cornell.obj --tolerance 0.05 --summary --out f.csv --open");
    let summary = object(&output);
    let rows = summary["worst_rows"].as_array().unwrap();
    assert_eq!(rows.len(), 3);
    let missing: Vec<f64> = rows.iter().map(|row| row["missing"].as_f64().unwrap()).collect();
    assert!((rows[0]["surface"] == "short") && missing[0] > 0.7 && missing[0] > missing[1], "{summary}");
    let table = folder.text_of("f.csv");
    let mut sums = [0.0; 20];
    let mut open = 0;
    for line in table.lines().skip(1) {
        let fields: Vec<&str> = line.split(',').collect();
        let [factor, lower, upper, error] = [4, 5, 6, 7].map(|k| fields[k].parse::<f64>().unwrap());
        sums[fields[0].parse::<usize>().unwrap()] += factor;
        open += usize::from(fields[2..4] == ["open", "open"]);
        assert!(lower <= factor && factor <= upper && error >= (upper - factor).max(factor - lower), "{line}");
    }
    assert!(open == 20 && sums.iter().all(|sum| (sum - 1.0).abs() <= 1e-15), "{sums:?}");
    let text = String::from_utf8_lossy(&folder.factors("cornell.obj --tolerance 0.05").stdout).into_owned();
    assert!(text.contains("  row of face 12 (`short`): 0.2632, 0.7368 is missing: its bounds explain "), "{text}");
    let (status, said) = status_and_said(&folder.factors("cornell.obj --out f.mtx --open"));
    assert!(status == Some(2) && said.contains("`f.mtx`: --open adds lines to a name ending in .csv"), "{said}");
}

#[test]
fn faces_that_see_nothing_are_noted() {
    let (status, said) = status_and_said(&folder("back").factors("back.obj"));
    assert!(status == Some(0) && said.contains("no face sees another: all factors are 0"), "{said}");
}

#[test]
fn no_file_is_lost_to_a_name_that_slipped() {
    let folder = folder("slips");
    let settings = "room.obj --tolerance 0.05";
    let kept = |file: &str| fs::read(folder.0.join(file)).unwrap();
    assert_eq!(folder.factors(&format!("{settings} --resume rows.jsonl")).status.code(), Some(0));
    fs::write(folder.0.join("notes.txt"), "no line feed").unwrap();
    fs::write(folder.0.join("other.jsonl"), "{}\n{\"a\": 1}\n").unwrap();
    let files = ["room.obj", "paint.txt", "notes.txt", "other.jsonl", "cornell.obj", "rows.jsonl"];
    let before = files.map(kept);
    for (arguments, sentence) in [
        ("--resume room.obj", "--resume is `room.obj`, which is the scene"),
        ("--resume paint.txt", "--resume is `paint.txt`, which is named in the scene"),
        ("--out paint.txt", "--out is `paint.txt`, which is named in the scene"),
        ("--resume notes.txt", "`notes.txt` is no file of --resume, and is left as it is"),
        ("--resume other.jsonl", "`other.jsonl` is no file of --resume"),
        ("--resume cornell.obj", "`cornell.obj` is no file of --resume"),
        ("--out a.csv --resume ./a.csv", "--resume is `./a.csv`, which is that of --out too"),
        ("--out a.txt --resume a.bounds.txt", "--resume is `a.bounds.txt`, which is that of --out too"),
        ("--resume rows.jsonl --relative 0.5", "it was written for another scene or other settings"),
    ] {
        let (status, said) = status_and_said(&folder.factors(&format!("{settings} {arguments}")));
        assert!(status == Some(2) && said.contains(sentence), "{arguments}: {said}");
        assert!(files.map(kept) == before, "{arguments}");
    }
    assert!(["a.csv", "a.txt", "a.bounds.txt"].iter().all(|file| !folder.0.join(file).exists()));
    // A kill in the midst of the first line leaves a part of it, or nothing.
    let rows = folder.text_of("rows.jsonl");
    for end in [0, 100, rows.find('\n').unwrap()] {
        fs::write(folder.0.join("rows.jsonl"), &rows[..end]).unwrap();
        assert_eq!(folder.factors(&format!("{settings} --resume rows.jsonl")).status.code(), Some(0), "{end}");
        assert_eq!(folder.text_of("rows.jsonl").lines().count(), rows.lines().count(), "{end}");
    }
}

#[test]
fn rows_of_a_run_before_are_checked() {
    let folder = folder("rows");
    let arguments = "room.obj --tolerance 0.05 --resume rows.jsonl";
    assert_eq!(folder.factors(arguments).status.code(), Some(0));
    let rows = folder.text_of("rows.jsonl");
    let line = rows.lines().nth(1).unwrap();
    let row: Value = serde_json::from_str(line).unwrap();
    let face = row["face"].as_u64().unwrap();
    let pairs = row["pairs"].as_array().unwrap().clone();
    let twice = [pairs.clone(), vec![pairs[0].clone()]].concat();
    let with = |change: &dyn Fn(&mut Value)| {
        let mut changed = row.clone();
        change(&mut changed);
        rows.replace(line, &changed.to_string())
    };
    let of_first = |member: &'static str, value: Value| move |row: &mut Value| row["pairs"][0][1][member] = value.clone();
    let cases = [
        (with(&of_first("value", 7.5.into())), "inside its bracket"),
        (with(&of_first("most", 7.5.into())), "inside its bracket"),
        (with(&of_first("least", (-1e-9).into())), "inside its bracket"),
        (with(&of_first("estimate", (-1.0).into())), "inside its bracket"),
        (with(&of_first("value", Value::Null)), "line 2 is no row of --resume"),
        (with(&|row| row["pairs"][0][0] = 99.into()), "the pairs that belong to it"),
        (with(&|row| row["pairs"][0][0] = face.into()), "the pairs that belong to it"),
        (with(&|row| row["pairs"] = twice.clone().into()), "each pair of a computed row once"),
        (with(&|row| row["face"] = 99.into()), "a row of face 99"),
        (format!("{rows}{line}\n"), "twice or of another block"),
    ];
    for (text, sentence) in cases {
        fs::write(folder.0.join("rows.jsonl"), &text).unwrap();
        let (status, said) = status_and_said(&folder.factors(arguments));
        assert!(status == Some(2) && said.contains(sentence), "{sentence}: {said}");
    }
}
