//! `radgrad factors --method rays`: rows that close, divisions of the work, and options that do not go together.

use std::fs;

use serde_json::Value;

use crate::factors::{folder, object, status_and_said};

#[test]
fn rows_close_with_what_is_open_and_pairs_are_reciprocal() {
    let folder = folder("by-rays");
    let output = folder.factors("room.obj --method rays --rays 2000 --out f.csv --open --summary");
    let summary = object(&output);
    assert_eq!((output.status.code(), &summary["method"], &summary["confidence"]), (Some(0), &"rays".into(), &0.99.into()));
    let table = folder.text_of("f.csv");
    let lines: Vec<Vec<&str>> = table.lines().skip(1).map(|line| line.split(',').collect()).collect();
    let number = |text: &str| text.parse::<f64>().unwrap();
    let mut faces: Vec<&str> = lines.iter().map(|line| line[0]).collect();
    faces.dedup();
    let mut stored = 0;
    for face in faces {
        let row: Vec<&Vec<&str>> = lines.iter().filter(|line| line[0] == face).collect();
        let sum: f64 = row.iter().map(|line| number(line[4])).sum();
        assert!((sum - 1.0).abs() < 1e-12 && row.last().unwrap()[2] == "open", "{face}: {sum}");
        for line in row.iter().filter(|line| line[2] != "open") {
            stored += 1;
            let [factor, low, high, area] = [4, 5, 6, 8].map(|column| number(line[column]));
            assert!(low <= factor && factor <= high && ["rays", "closed form"].contains(&line[7]), "{line:?}");
            let back = lines.iter().find(|other| other[0] == line[2] && other[2] == face).unwrap();
            assert!((factor * area - number(back[4]) * number(back[8])).abs() < 1e-12 * area, "{line:?} {back:?}");
        }
    }
    assert_eq!(summary["factors"], stored);
    // Values alone.
    assert_eq!(folder.factors("room.obj --method rays --rays 2000 --out f.mtx").status.code(), Some(0));
    let matrix = folder.text_of("f.mtx");
    let entries: Vec<&str> = matrix.lines().filter(|line| !line.starts_with('%')).skip(1).collect();
    assert_eq!(entries.len(), stored);
    let first: Vec<&str> = entries[0].split(' ').collect();
    assert_eq!(number(first[2]), number(lines[0][4]));
    assert_eq!(folder.factors("room.obj --method rays --rays 2000 --out f.npz").status.code(), Some(0));
    let bytes = fs::metadata(folder.0.join("f.npz")).unwrap().len();
    assert!((12 * stored as u64..12 * stored as u64 + 4000).contains(&bytes), "{bytes}");
    // Small pairs may be left out.
    let output = folder.factors("room.obj --method rays --rays 2000 --drop-below 0.02 --out g.csv --open --summary");
    let fewer = object(&output);
    assert!(
        fewer["factors"].as_u64() < summary["factors"].as_u64() && fewer["absent_at_most"].as_f64().unwrap() >= 0.02,
        "{fewer}"
    );
}

#[test]
fn an_interrupted_run_and_runs_of_blocks_come_to_the_same_bytes() {
    let folder = folder("by-rays-blocks");
    let settings = "room.obj --tolerance 0.2 --seed 7 --method rays";
    assert_eq!(folder.factors(&format!("{settings} --out whole.csv --resume rows.jsonl")).status.code(), Some(0));
    let (whole, rows) = (folder.text_of("whole.csv"), folder.text_of("rows.jsonl"));
    // A kill in the midst of a row.
    let end = rows.len() / 2;
    fs::write(folder.0.join("rows.jsonl"), &rows[..end]).unwrap();
    assert_eq!(folder.factors(&format!("{settings} --out again.csv --resume rows.jsonl")).status.code(), Some(0));
    assert!(folder.text_of("again.csv") == whole);
    for i in 1..=3 {
        assert_eq!(folder.factors(&format!("{settings} --rows {i}/3 --resume part{i}.jsonl")).status.code(), Some(0));
    }
    let counted = [1, 2, 3].map(|i| folder.text_of(&format!("part{i}.jsonl")).lines().count() - 1).iter().sum::<usize>();
    assert_eq!(counted, rows.lines().count() - 1);
    let joined = "--join part3.jsonl part1.jsonl part2.jsonl part1.jsonl";
    assert_eq!(folder.factors(&format!("{settings} {joined} --out joined.csv")).status.code(), Some(0));
    assert!(folder.text_of("joined.csv") == whole);
    // Missing rows are counted; another seed, or another row of a face, is refused.
    assert_eq!(folder.factors(&format!("{settings} --join part1.jsonl --out rest.csv")).status.code(), Some(0));
    assert!(folder.text_of("rest.csv") == whole);
    let part = folder.text_of("part1.jsonl");
    let line = part.lines().nth(1).unwrap();
    let mut row: Value = serde_json::from_str(line).unwrap();
    row["met"][0][1] = 1.into();
    fs::write(folder.0.join("part2.jsonl"), part.replace(line, &row.to_string())).unwrap();
    for (arguments, sentence) in [
        ("--join part1.jsonl part2.jsonl", "each once"),
        ("--join part1.jsonl --seed 8", "it was written for another scene or other settings"),
        ("--join nowhere.jsonl", "nowhere.jsonl"),
        ("--join room.obj", "`room.obj` is no file of --resume"),
    ] {
        let settings = settings.replace("--seed 7", if arguments.contains("seed") { "" } else { "--seed 7" });
        let (status, said) = status_and_said(&folder.factors(&format!("{settings} {arguments} --out f.csv")));
        assert!(status == Some(2) && said.contains(sentence), "{arguments}: {said}");
    }
    assert!(!folder.0.join("f.csv").exists());
}

#[test]
fn what_does_not_go_with_rays_is_refused_before_any_is_drawn() {
    let folder = folder("by-rays-refused");
    for (arguments, sentence) in [
        ("--method rays --out f.idf", "factors by rays are those of faces"),
        ("--method rays --rows 1/2", "name that file"),
        ("--method rays --rows 1/2 --out f.csv --resume r.jsonl", "write with --join"),
        ("--method rays --repair", "--repair goes with --method brackets"),
        ("--method brackets --confidence 0.9", "--confidence goes with --method rays"),
        ("--rays 10 --cells 10", "--rays goes with --method rays and --cells with --method brackets"),
        ("--confidence 1", "a confidence above 0 and below 1"),
        ("--confidence NaN", "a confidence above 0 and below 1"),
        ("--method rays --tolerance 0", "a tolerance above 0 and below 1"),
        ("--method rays --tolerance 1e-6", "ask for a larger tolerance"),
        ("--drop-below 1.5", "it must be between 0 and 1"),
    ] {
        let (status, said) = status_and_said(&folder.factors(&format!("room.obj {arguments}")));
        assert!(status == Some(2) && said.contains(sentence), "{arguments}: {said}");
    }
}
