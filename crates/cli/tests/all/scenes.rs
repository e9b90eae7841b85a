//! `radgrad factors` and `radgrad field` as a user sees them: files in, files out, an exit status.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use serde_json::Value;

const ROOM: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../data/scenes/two_blocks.obj");

fn radgrad(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_radgrad")).args(arguments).output().unwrap()
}

fn place(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("scenes");
    fs::create_dir_all(&folder).unwrap();
    folder.join(name)
}

fn text(bytes: &[u8]) -> &str {
    std::str::from_utf8(bytes).unwrap()
}

#[test]
fn the_summary_is_one_object_and_says_that_a_closed_room_closes() {
    let output = radgrad(&["factors", ROOM, "--tolerance", "0.01", "--summary"]);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    let summary: Value = serde_json::from_slice(&output.stdout).unwrap();
    let number = |name: &str| summary[name].as_f64().unwrap_or_else(|| panic!("{name} in {summary}"));
    assert_eq!(summary["faces"], 21);
    assert!(number("worst_closure") < 1e-3 && number("seconds") > 0.0, "{summary}");
    assert!(number("worst_reciprocity") <= 1e-15 && number("worst_bound") <= 0.01, "{summary}");
    assert_eq!((&summary["unmet"], &summary["rows_that_cannot_close"]), (&Value::from(0), &Value::from(0)));
    // What is asked decides the rule: 3e-2 of the tolerance, over the factor.
    assert!(number("worst_bound_in_free_sight") <= 3e-4, "{summary}");
    let output = radgrad(&["factors", ROOM, "--tolerance", "0.01", "--estimate", "3e-5", "--summary"]);
    let summary: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert!(summary["worst_bound_in_free_sight"].as_f64().unwrap() <= 1e-11, "{summary}");
}

#[test]
fn what_is_not_met_is_listed_and_ends_in_1() {
    let output = radgrad(&["factors", ROOM, "--tolerance", "0.001", "--cells", "2", "--estimate", "0.01"]);
    assert_eq!(output.status.code(), Some(1));
    assert!(text(&output.stderr).starts_with("radgrad: not met: from "), "{}", text(&output.stderr));
    for part in [" more, with their `error` in a .csv", "by how brackets narrow --cells ", " would do, and all meet --tolerance "]
    {
        assert!(text(&output.stderr).contains(part), "{part}: {}", text(&output.stderr));
    }
}

#[test]
fn the_factors_are_written_in_every_format_and_they_agree() {
    let files = ["room.csv", "room.txt", "room.mtx", "room.idf"].map(place);
    for file in &files {
        let output = radgrad(&["factors", ROOM, "--tolerance", "0.02", "--repair", "--out", file.to_str().unwrap()]);
        assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
        let report = text(&output.stdout);
        assert!(report.starts_with("21 faces of 16 surfaces, ") && report.contains("\nrepaired  "), "{report}");
        assert!(
            report.contains("\nclosure  ") && report.contains(" before, ") && report.trim_end().ends_with(" after"),
            "{report}"
        );
    }
    let [csv, view3d, matrix_market, energy_plus] = files.map(|file| fs::read_to_string(file).unwrap());
    let numbers = |text: &str| -> Vec<Vec<f64>> {
        text.lines().skip(1).map(|line| line.split_whitespace().map(|word| word.parse().unwrap()).collect()).collect()
    };
    let lines = numbers(&view3d);
    let (areas, rows, emittances) = (&lines[0], &lines[1..17], &lines[17]);
    assert_eq!((areas.len(), lines.len(), emittances.len()), (16, 18, 16));
    assert!(emittances.iter().all(|e| (e - 0.3).abs() < 1e-15));
    for (i, row) in rows.iter().enumerate() {
        assert!((row.iter().sum::<f64>() - 1.0).abs() < 1e-12);
        assert!((0..16).all(|j| (areas[i] * row[j] - areas[j] * rows[j][i]).abs() <= 1e-15 * areas[i]), "{i}");
    }
    // Surface 0 is face 0 alone, surface 2 face 2.
    let entry: Vec<&str> = csv.lines().find(|line| line.starts_with("0,room_top,2,room_north,")).unwrap().split(',').collect();
    let [factor, lower, upper, error] = [4, 5, 6, 7].map(|column| entry[column].parse::<f64>().unwrap());
    assert_eq!(factor, rows[0][2]);
    assert!(lower <= factor && factor <= upper && error >= (upper - factor).max(factor - lower) && error <= 0.02, "{entry:?}");
    let bounds = numbers(&fs::read_to_string(place("room.bounds.txt")).unwrap());
    assert!((bounds[1][2] - error).abs() <= 1e-12, "{} {error}", bounds[1][2]);
    let coordinates: Vec<Vec<f64>> = numbers(&matrix_market.lines().skip(1).collect::<Vec<_>>().join("\n"));
    assert_eq!(coordinates[0], [21.0, 21.0, csv.lines().count() as f64 - 1.0]);
    assert!(coordinates.contains(&vec![1.0, 3.0, factor]));
    assert!(energy_plus.contains(&format!(",\n  room_top, room_north, {factor:?}")), "{energy_plus}");
    // A line for the object, one for the zone, and one for each pair, also with itself.
    assert_eq!(energy_plus.lines().count(), 2 + 16 * 16);
    assert!(energy_plus.contains(",\n  room_top, room_top, 0.0,"), "{energy_plus}");
}

#[test]
fn blocks_of_rows_join_to_the_whole_byte_for_byte() {
    let write = |name: &str, more: &[&str]| {
        let file = place(name);
        let arguments = [&["factors", ROOM, "--tolerance", "0.05", "--out", file.to_str().unwrap()], more].concat();
        assert_eq!(radgrad(&arguments).status.code(), Some(0));
        fs::read(file).unwrap()
    };
    let parts = ["1/3", "2/3", "3/3"].map(|block| write(&format!("part{}.csv", &block[..1]), &["--rows", block]));
    assert_eq!(parts.concat(), write("all.csv", &[]));
}

#[test]
fn an_interrupted_run_goes_on_to_the_same_bytes() {
    let (kept, out) = (place("kept.jsonl"), place("resumed.csv"));
    let _ = fs::remove_file(&kept);
    let run = |tolerance: &str| {
        radgrad(&["factors", ROOM, "--tolerance", tolerance, "--out", out.to_str().unwrap(), "--resume", kept.to_str().unwrap()])
    };
    assert_eq!(run("0.05").status.code(), Some(0));
    let (whole, rows) = (fs::read(&out).unwrap(), fs::read_to_string(&kept).unwrap());
    assert_eq!(rows.lines().count(), 1 + 21);
    // A kill in the midst of the twelfth line.
    let end = rows.match_indices('\n').nth(11).unwrap().0 - 10;
    fs::write(&kept, &rows[..end]).unwrap();
    let again = run("0.05");
    assert_eq!(again.status.code(), Some(0), "{}", text(&again.stderr));
    assert_eq!(fs::read(&out).unwrap(), whole);
    let completed = fs::read_to_string(&kept).unwrap();
    assert!(completed.starts_with(&rows[..end - 100]) && completed.lines().count() == 1 + 21);
    // What was asked for with other settings is not taken for it.
    let other = run("0.04");
    assert_eq!(other.status.code(), Some(2));
    assert!(text(&other.stderr).contains("other settings"), "{}", text(&other.stderr));
}

#[test]
fn a_field_has_a_line_a_cell_with_bounds_that_are_small() {
    let file = place("floor.csv");
    let output = radgrad(&["field", ROOM, "--on", "floor", "--grid", "3", "--out", file.to_str().unwrap()]);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    let table = fs::read_to_string(file).unwrap();
    let rows: Vec<Vec<f64>> =
        table.lines().skip(1).map(|line| line.split(',').map(|word| word.parse().unwrap()).collect()).collect();
    assert_eq!(rows.len(), 6 * 9);
    // The ceiling's radiance is 1, so nothing is brighter than pi.
    assert!(rows.iter().all(|row| (0.1..std::f64::consts::PI).contains(&row[4])), "{table}");
    assert!(rows.iter().all(|row| row[8] < 1e-11), "{table}");
}

#[test]
fn a_field_is_a_picture_of_one_patch_and_a_grid_of_any() {
    let (png, vtu) = (place("lit.png"), place("lit.vtu"));
    let field = |on: &str, file: &Path| radgrad(&["field", ROOM, "--on", on, "--grid", "4", "--out", file.to_str().unwrap()]);
    assert_eq!(field("tall_top", &png).status.code(), Some(0));
    assert_eq!(field("floor", &vtu).status.code(), Some(0));
    assert_eq!(&fs::read(&png).unwrap()[1..4], b"PNG");
    let grid = fs::read_to_string(vtu).unwrap();
    assert!(grid.contains("NumberOfPoints=\"384\" NumberOfCells=\"96\"") && grid.ends_with("</VTKFile>\n"));
    let refused = field("floor", &png);
    assert_eq!(refused.status.code(), Some(2));
    assert!(text(&refused.stderr).contains("the surface has 6"), "{}", text(&refused.stderr));
}

#[test]
fn what_is_wrong_is_named_with_its_place_and_nothing_is_written() {
    let broken = place("broken.obj");
    fs::write(&broken, "v 0 0 0\nv 1 0 0\nv 1 x 0\nf 1 2 3\n").unwrap();
    let out = place("never.csv");
    let out = out.to_str().unwrap();
    let cases: [(&[&str], &str); 7] = [
        (&["factors", broken.to_str().unwrap(), "--out", out], "broken.obj:3: "),
        (&["factors", "missing.obj", "--out", out], "`missing.obj` cannot be read"),
        (&["factors", ROOM, "--out", "matrix.zip"], "`matrix.zip`: factors are written to a name ending in"),
        (&["factors", ROOM, "--rows", "1/2", "--out", "part.mtx"], "`part.mtx`: a block of rows is written to a name ending in"),
        (&["factors", ROOM, "--tolerance", "2", "--out", out], "tolerance is 2"),
        (&["field", ROOM, "--on", "roof", "--grid", "2", "--out", out], "`roof`"),
        (&["field", ROOM, "--on", "floor", "--grid", "0", "--out", out], "grid of at least one cell"),
    ];
    for (arguments, message) in cases {
        let output = radgrad(arguments);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}");
        assert!(output.stdout.is_empty() && text(&output.stderr).contains(message), "{}", text(&output.stderr));
    }
    assert!(!Path::new(out).exists());
}
